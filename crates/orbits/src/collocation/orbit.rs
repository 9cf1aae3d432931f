//! The iterate of the collocation: one turn of several orbits on all pairs of nodes, and the sweeps that
//! improve it.

use std::f64::consts::PI;

use pulp::Simd;

use super::field::{Combination, Field, Pair, Values, cosh_sinh, exp_m1};
use super::lanes::Lanes;
use super::nodes::{MOST_PAIRS, Nodes};

/// Least rate of the angle relative to omega. Near zero the polar angle is not monotone in time (an
/// overdamped node).
const SLOWEST_TURN: f64 = 0.05;

/// A function sampled at the nodes, to be integrated with weight sin^2.
struct Samples<S: Simd> {
    sums: [Lanes<S>; MOST_PAIRS],
    differences: [Lanes<S>; MOST_PAIRS],
    /// Half the integral over the turn.
    half: Lanes<S>,
}

impl<S: Simd> Samples<S> {
    #[inline(always)]
    fn new(simd: S) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        Self { sums: [zero; MOST_PAIRS], differences: [zero; MOST_PAIRS], half: zero }
    }

    /// Clears the integral; new values are [`put`](Self::put) next.
    #[inline(always)]
    fn clear(&mut self) {
        self.half = self.half.same(0.0);
    }

    #[inline(always)]
    fn put(&mut self, nodes: &Nodes, i: usize, value: Pair<S>) {
        let sum = value.late + value.early;
        self.sums[i] = sum;
        self.differences[i] = value.late - value.early;
        self.half = sum.mul_add(sum.same(0.5 * nodes.weight[i]), self.half);
    }

    /// The antiderivative from the start of the turn to the nodes. Two pairs at a time: that keeps both
    /// multiplication units busy and loads every sample half as often.
    #[inline(always)]
    fn integrals(&self, nodes: &Nodes, into: &mut [Pair<S>; MOST_PAIRS]) {
        let pairs = nodes.pairs();
        for (rows, into) in nodes.matrix.chunks(2 * pairs).zip(into.chunks_mut(2)) {
            let zero = self.half.same(0.0);
            let (mut odd, mut even) = ([zero; 2], [self.half; 2]);
            let (row, other) = rows.split_at(pairs);
            // The last row of an odd number is processed twice.
            let other = if other.is_empty() { row } else { other };
            for (((a, b), &sum), &difference) in row.iter().zip(other).zip(&self.sums).zip(&self.differences)
            {
                odd[0] = sum.mul_add(zero.same(a.even), odd[0]);
                even[0] = difference.mul_add(zero.same(a.odd), even[0]);
                odd[1] = sum.mul_add(zero.same(b.even), odd[1]);
                even[1] = difference.mul_add(zero.same(b.odd), even[1]);
            }
            for (into, (even, odd)) in into.iter_mut().zip(even.into_iter().zip(odd)) {
                *into = Pair::of_parts(even, odd);
            }
        }
    }
}

/// The result of the sweeps.
pub(super) struct End<S: Simd> {
    /// ln r(2 pi) / V.
    pub(crate) log: Lanes<S>,
    pub(crate) truncation: Lanes<S>,
    pub(crate) iteration: Lanes<S>,
    pub(crate) rounding: Lanes<S>,
    pub(crate) room: Lanes<S>,
}

/// The iterate on all nodes.
pub(super) struct Orbit<S: Simd> {
    /// x = v / V.
    x: [Pair<S>; MOST_PAIRS],
    /// omega^2 Q.
    crossing: [Pair<S>; MOST_PAIRS],
    /// Slope of the iterate: y' = -mu + sin^2 h.
    h: [Pair<S>; MOST_PAIRS],
    residual: [Pair<S>; MOST_PAIRS],
    /// J of the first guess.
    gain: [Pair<S>; MOST_PAIRS],
    /// Scratch of a sweep.
    one: Samples<S>,
    two: Samples<S>,
    integral: [Pair<S>; MOST_PAIRS],
    /// J of the first guess as a combination of functions with known integrals.
    model: Combination<S>,
    /// Half of ln r(2 pi).
    half: Lanes<S>,
    /// Integral of sin^2 times the square of the last correction of h.
    correction: Lanes<S>,
}

impl<S: Simd> Orbit<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let zero = Lanes::splat(simd, 0.0);
        let pairs = [Pair { late: zero, early: zero }; MOST_PAIRS];
        Self {
            x: pairs,
            crossing: pairs,
            h: pairs,
            residual: pairs,
            gain: pairs,
            one: Samples::new(simd),
            two: Samples::new(simd),
            integral: pairs,
            model: Combination([zero; 4]),
            half: zero,
            correction: zero,
        }
    }

    /// The first guess: H and J are interpolated between their values at the angles 0, pi and 2 pi, on an
    /// orbit that follows the spiral of constant divergence there.
    #[inline(always)]
    pub(super) fn guess(&mut self, nodes: &Nodes, field: &Field<S>) {
        let mu = field.mu;
        // exp(-pi mu) by Pade.
        let y = mu * mu.same(-PI);
        let even = y.mul_add(y * mu.same(1.0 / 12.0), mu.same(1.0));
        let odd = y * mu.same(0.5);
        let drift = (even + odd) / (even - odd);
        let farthest = (field.q1 - mu.same(0.3)) / field.k;
        let start = field.on_axis(mu.same(1.0));
        let middle = field.on_axis(-drift);
        let end = field.on_axis((drift * drift).min(farthest));
        let h = Combination::through(start.0, middle.0, end.0, mu);
        self.model = Combination::through(start.1, middle.1, end.1, mu);
        self.half = mu.mul_add(mu.same(-PI), h.0[1] * mu.same(nodes.guess_half));
        let base = exp_m1(self.half) + mu.same(1.0);
        for i in 0..nodes.pairs() {
            let (even, odd) = h.parts(&nodes.guess[i]);
            self.h[i] = Pair::of_parts(even, odd);
            let (even, odd) = self.model.parts(&nodes.guess[i]);
            self.gain[i] = Pair::of_parts(even, odd);
            let (odd, even) = h.parts(&nodes.guess_integral[i]);
            let odd = mu.mul_add(mu.same(-nodes.xi[i]), odd);
            let (cosh, sinh) = cosh_sinh(odd);
            let r = grow(base, even);
            let (sin, cos) = (mu.same(nodes.sin[i]), mu.same(nodes.cos[i]));
            let axes = Pair::of_parts(cos, -(mu * sin));
            self.x[i] = Pair { late: r * (cosh + sinh), early: r * (cosh - sinh) }.mul(axes);
            let sin = field.omega2 * sin;
            self.crossing[i] = Pair { late: -(sin * axes.late), early: sin * axes.early };
        }
    }

    /// One sweep: y <- y + (1 + S J) S r with S the integration and the J of the first guess.
    #[inline(always)]
    pub(super) fn sweep(&mut self, nodes: &Nodes, field: &Field<S>) {
        let zero = self.half.same(0.0);
        self.one.clear();
        for i in 0..nodes.pairs() {
            let residual = field.at(self.x[i], self.crossing[i]).h.sub(self.h[i]);
            self.residual[i] = residual;
            self.one.put(nodes, i, residual);
        }
        self.one.integrals(nodes, &mut self.integral);
        self.two.clear();
        self.correction = zero;
        for i in 0..nodes.pairs() {
            let first = self.integral[i];
            let change = Pair {
                late: first.late.mul_add(self.gain[i].late, self.residual[i].late),
                early: first.early.mul_add(self.gain[i].early, self.residual[i].early),
            };
            self.h[i] = self.h[i].add(change);
            self.correction = change.square().mul_add(zero.same(nodes.weight[i]), self.correction);
            self.two.put(nodes, i, change);
        }
        self.half += self.two.half;
        self.two.integrals(nodes, &mut self.integral);
        for i in 0..nodes.pairs() {
            let change = self.integral[i];
            self.x[i] =
                Pair { late: grow(self.x[i].late, change.late), early: grow(self.x[i].early, change.early) };
        }
    }

    /// Evaluates H for the last time, which only affects ln r(2 pi), and estimates all errors.
    #[inline(always)]
    pub(super) fn finish(&mut self, nodes: &Nodes, field: &Field<S>) -> End<S> {
        let zero = self.half.same(0.0);
        let one = zero.same(1.0);
        let (mut room, mut end) = (zero.same(f64::INFINITY), zero);
        let (mut left, mut norm) = (zero, zero);
        for i in 0..nodes.pairs() {
            let Values { h, q, u, turn } = field.at(self.x[i], self.crossing[i]);
            for (q, u, turn) in [(q.late, u.late, turn.late), (q.early, u.early, turn.early)] {
                room = room.min(u.neg_mul_add(zero.same(SLOWEST_TURN), turn)).min(q);
            }
            let residual = h.sub(self.h[i]);
            let weight = zero.same(nodes.weight[i]);
            // exp(-K) to first order in J.
            let (odd, even) = self.model.parts(&nodes.guess_integral[i]);
            let decay = Pair::of_parts(one - even, -odd);
            end = residual.early.mul_add(decay.early, residual.late * decay.late).mul_add(weight, end);
            left = residual.square().mul_add(weight, left);
            norm = h.square().mul_add(weight, norm);
            self.one.put(nodes, i, h);
        }
        // exp(K(2 pi) / 2).
        let [j1, j2, j3, _] = self.model.0;
        let k = j2 * zero.same(nodes.guess_half);
        let growth = k.mul_add(k.mul_add(zero.same(0.5), one), one);
        let log = (self.half + self.half) + growth * end;
        let mut tail = zero;
        for (rows, of) in
            [(&nodes.tail_of_sums, &self.one.sums), (&nodes.tail_of_differences, &self.one.differences)]
        {
            for row in rows.chunks_exact(nodes.pairs()) {
                let mut coefficient = zero;
                for (&entry, &value) in row.iter().zip(of) {
                    coefficient = value.mul_add(zero.same(entry), coefficient);
                }
                tail = coefficient.mul_add(coefficient, tail);
            }
        }
        // By Schwarz's inequality: sin^2 integrates to pi. sin^2 |cos|, sin^2 cos^2 and sin^2 |xi cos| / pi
        // integrate to 4/3, pi/4 and less than 2/3.
        let stiffness = j1.abs().mul_add(
            zero.same(4.0 / 3.0),
            j2.abs().mul_add(zero.same(PI / 4.0), j3.abs() * zero.same(2.0 / 3.0)),
        );
        let correction = (self.correction * zero.same(PI)).sqrt();
        let left = (left * zero.same(PI)).sqrt();
        let size = norm.sqrt();
        // Gauss's rule squares the convergence of the coefficients, less so the closer the pole q = 0.
        let squared = (stiffness * stiffness).mul_add(zero.same(200.0), zero.same(2.0));
        let near_pole = (field.k * field.k).mul_add(zero.same(80.0), one);
        let truncation = size.mul_add(zero.same(nodes.harmonic_error), tail / size * squared * near_pole);
        // The error of the J of the guess is its own size times that of the guess, plus its interpolation
        // error, which ignores the pole; the truncation errors of the short series of `cosh_sinh` and `grow`
        // remain.
        let z = field.mu.abs().mul_add(zero.same(0.5 * PI), size);
        let series =
            z * z * eighth(z) * zero.same(1e-9) + (eighth(size) + eighth(correction)) * zero.same(2.5e-5);
        let wrong = field.k * field.k * zero.same(0.05);
        let iteration =
            stiffness * left.mul_add((z + stiffness).mul_add(zero.same(0.125), correction + wrong), series);
        let rounding =
            (field.terms * field.inverse_omega3 + size + log.abs()) * zero.same(8.0 * f64::EPSILON);
        End { log, truncation, iteration, rounding, room }
    }
}

/// z^8. A function: a closure would not be compiled for the wide vectors, and each product would become a
/// call.
#[inline(always)]
fn eighth<S: Simd>(z: Lanes<S>) -> Lanes<S> {
    let square = z * z;
    let fourth = square * square;
    fourth * fourth
}

/// x exp(eta), to eta^8 / 8!.
#[inline(always)]
fn grow<S: Simd>(x: Lanes<S>, eta: Lanes<S>) -> Lanes<S> {
    let mut p = eta.same(1.0 / 5040.0);
    for factor in [1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0] {
        p = p.mul_add(eta, eta.same(factor));
    }
    (p * eta).mul_add(x, x)
}

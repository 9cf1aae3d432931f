//! The damping at which an orbit of given amplitude closes, for every friction law: Newton's method for the
//! whole orbit at once.
//!
//! In the polar form of [`super::polar`] a closed orbit through the maximum `radius` of x2 is a function p =
//! ln(r / radius) of the angle with
//!
//! ```text
//! p' = g(th, p; C) = D sin^2 th / (1 + D sin th cos th),   D = w(V - radius e^p cos th) - C,   p(0) = p(2 pi) = 0
//! ```
//!
//! for one C. The turn is cut into elements, and p' is a polynomial on each, with p' = g at Gauss's nodes. A
//! step of Newton's method solves the linear equation for (dp, dC) by the integrating factor exp(A), A the
//! integral of a = dg/dp; it starts from the circle p = 0, on which C is the mean of w with the weight sin^2.
//!
//! **Elements.** The weakening rate is compiled to polynomials on pieces of slip speeds ([`Weakening`]).
//! Elements end where the orbit passes from one piece to the next, so that g is smooth on each, at the
//! corners of a measured law too. The slip speed rises on (0, pi) and falls on (pi, 2 pi), since x2' = -r
//! sin th: the orbit passes each end of a piece at most once on either side. These angles follow the orbit
//! from step to step. A wrong angle counts to second order only, because w is continuous.
//!
//! **Error of the iteration.** Let rho = g - p' be the residual of an iterate. To first order its C is wrong
//! by the mean of W rho over that of W dg/dC, W = exp(-A). The sum of the sizes, which cannot vanish by chance,
//! stands for the first.
//!
//! **Error of the elements.** The method is Gauss's collocation, whose error at the end of the turn is that
//! of a product of two functions that each are resolved to first order. Two indicators are added: twice the
//! change of C from the last, coarser elements; and the square of the error that their polynomials leave
//! between their nodes, which cannot vanish by chance.
//!
//! **Error of the form.** The bound of the law's polynomials (theory, "One form for every law").

use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

use super::gauss::{MOST, Rule};
use super::polar::Closing;
use crate::friction::{Polynomial, Weakening};

/// Least dth/dt: the polar form applies as long as it is positive, but near zero g is hard to resolve.
const SLOWEST_TURN: f64 = 0.02;
/// Largest |ln(r / radius)|.
const LARGEST_LOG: f64 = 1.0;
/// Largest |A| in a step of Newton's method.
const LARGEST_GROWTH: f64 = 8.0;
/// Least step of the share of w that acts, on the way to an orbit far from the circle.
const SHORTEST_SHARE: f64 = 0.02;
/// Error of C on that way, in units of the largest |w|.
const ON_THE_WAY: f64 = 1e-3;
/// Residual, as an error of C in these units, from which the iteration does not come back.
const HOPELESS: f64 = 10.0;
/// The same for the distance from the border of the domain of the polar form.
const FARTHEST_OUTSIDE: f64 = -0.3;
/// Error of C, in units of the largest |w|, below which the steps converge quadratically.
const NEAR: f64 = 0.03;
/// Safety factor of the error predicted from that.
const PREDICTION: f64 = 10.0;
/// Largest change of p in a step.
const LONGEST_STEP: f64 = 0.25;
/// How far outside its piece a polynomial is used, in halves of the piece's width.
const OUTSIDE: f64 = 1.1;
/// Widest element of the coarsest rung.
const WIDEST: f64 = 0.5 * PI;
/// Nodes per element, and the parts into which each element of the rung before is cut.
const LADDER: [(usize, usize); 5] = [(4, 1), (8, 1), (8, 2), (8, 2), (8, 2)];
/// Error of C on the first rungs, in units of the largest |w|, below which the iteration gains nothing.
const FLOORS: [f64; 2] = [1e-6, 1e-10];
/// Error of C, in units of the largest |w|, that the finest rung may leave where less is asked for.
const WORST: f64 = 1e-8;
/// How often an orbit without an answer is tried again with finer elements.
const RETRIES: u32 = 1;
/// Largest number of elements.
const MOST_ELEMENTS: usize = 1 << 15;
/// Largest number of steps of Newton's method on one rung; four are usual on the first, two on the others.
const MOST_STEPS: usize = 15;
/// Round-off of C, in units of the largest weakening rate on the orbit: sums of some hundred terms of that
/// size with random signs of error.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;

static RULES: LazyLock<(Rule<4>, Rule<8>)> = LazyLock::new(|| (Rule::new(), Rule::new()));

/// Values at the nodes of an element as a sum of those at the nodes of the element that contains it, one
/// matrix for each part, `[k][j]` as in [`Rule`]; for each rung but the first.
static TRANSFERS: LazyLock<Vec<Vec<[[f64; MOST]; MOST]>>> = LazyLock::new(|| {
    let nodes = |size: usize| match size {
        4 => RULES.0.nodes.to_vec(),
        _ => RULES.1.nodes.to_vec(),
    };
    let interpolate = |size: usize, values: &[f64; MOST], x: f64| match size {
        4 => RULES.0.interpolate(values, x),
        _ => RULES.1.interpolate(values, x),
    };
    let matrix = |from: usize, to: usize, part: usize, parts: usize| {
        let mut matrix = [[0.0; MOST]; MOST];
        for (k, row) in matrix.iter_mut().enumerate().take(from) {
            let mut unit = [0.0; MOST];
            unit[k] = 1.0;
            for (value, x) in row.iter_mut().zip(nodes(to)) {
                let inside = (2.0 * part as f64 + 1.0 + x) / parts as f64 - 1.0;
                *value = interpolate(from, &unit, inside);
            }
        }
        matrix
    };
    LADDER
        .windows(2)
        .map(|rungs| {
            let [(from, _), (to, parts)] = [rungs[0], rungs[1]];
            (0..parts).map(|part| matrix(from, to, part, parts)).collect()
        })
        .collect()
});

/// An orbit to be closed.
#[derive(Clone, Copy, Debug)]
struct Problem<'a> {
    weakening: &'a Weakening,
    belt_speed: f64,
    radius: f64,
}

/// A part of the turn on which p' is one polynomial.
#[derive(Clone, Debug)]
struct Element {
    /// Number of the law's piece.
    piece: usize,
    middle: f64,
    /// Half its width.
    half: f64,
    cos: [f64; MOST],
    sin_cos: [f64; MOST],
    sin_squared: [f64; MOST],
    /// p at the nodes, and at the end.
    log_r: [f64; MOST],
    end: f64,
    /// p' at the nodes.
    slope: [f64; MOST],
    /// p' after the step of Newton's method, without dC and by dC.
    next: [f64; MOST],
    by_damping: [f64; MOST],
}

/// The elements between two neighbouring passages of ends of pieces, or of the angle pi.
#[derive(Clone, Copy, Debug)]
struct Span {
    piece: usize,
    parts: usize,
}

/// An iterate.
#[derive(Clone)]
struct Orbit<'a> {
    problem: Problem<'a>,
    viscous: f64,
    /// The share of w that acts; 1 but on the way to an orbit far from the circle.
    share: f64,
    /// Largest ratio of the error left by a step to the square of that before it, near the solution.
    curvature: f64,
    /// As many before the angle pi as after it.
    spans: Vec<Span>,
    /// Angles at which spans begin and end.
    bounds: Vec<f64>,
    /// Their cosines.
    cos: Vec<f64>,
    elements: Vec<Element>,
}

/// exp(x) to a few units in the last place for |x| <= 1, to 1e-9 for |x| <= 8: Taylor series of exp(x/16) to
/// degree 9, then four squarings.
#[inline(always)]
fn exp(x: f64) -> f64 {
    let y = 0.0625 * x;
    let mut sum = 1.0 / 362_880.0;
    for inverse_factorial in
        [1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0]
    {
        sum = y.mul_add(sum, inverse_factorial);
    }
    // expm1 keeps the accuracy of small arguments through the squarings: e(2y) = e(y) (2 + e(y)).
    let mut expm1 = y * sum;
    for _ in 0..4 {
        expm1 *= 2.0 + expm1;
    }
    1.0 + expm1
}

/// sin(z) and cos(z) for |z| <= pi / 4.
#[inline(always)]
fn sin_cos(z: f64) -> [f64; 2] {
    let y = z * z;
    let mut sin = 1.0 / 355_687_428_096_000.0;
    for term in [
        -1.0 / 1_307_674_368_000.0,
        1.0 / 6_227_020_800.0,
        -1.0 / 39_916_800.0,
        1.0 / 362_880.0,
        -1.0 / 5_040.0,
        1.0 / 120.0,
        -1.0 / 6.0,
        1.0,
    ] {
        sin = y.mul_add(sin, term);
    }
    let mut cos = 1.0 / 20_922_789_888_000.0;
    for term in [
        -1.0 / 87_178_291_200.0,
        1.0 / 479_001_600.0,
        -1.0 / 3_628_800.0,
        1.0 / 40_320.0,
        -1.0 / 720.0,
        1.0 / 24.0,
        -0.5,
        1.0,
    ] {
        cos = y.mul_add(cos, term);
    }
    [z * sin, cos]
}

/// w and w' by the polynomial of a piece, at x within it.
#[inline(always)]
fn weakening(piece: &Polynomial, x: f64) -> [f64; 2] {
    let (mut value, mut slope) = (0.0, 0.0);
    for c in piece.c.iter().rev() {
        slope = x.mul_add(slope, value);
        value = x.mul_add(value, *c);
    }
    [value, slope * piece.scale]
}

/// `matrix` applied to `values`.
#[inline(always)]
fn apply<const N: usize>(matrix: &[[f64; N]; N], values: &[f64; N]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (row, value) in matrix.iter().zip(values) {
        for j in 0..N {
            sum[j] = row[j].mul_add(*value, sum[j]);
        }
    }
    sum
}

#[inline(always)]
fn dot<const N: usize>(weights: &[f64; N], values: &[f64; N]) -> f64 {
    let mut terms = [0.0; N];
    for j in 0..N {
        terms[j] = weights[j] * values[j];
    }
    terms.iter().sum()
}

/// The first N values.
#[inline(always)]
fn first<const N: usize>(values: &[f64; MOST]) -> [f64; N] {
    std::array::from_fn(|j| values[j])
}

/// A step of Newton's method, before it is made.
#[derive(Clone, Copy, Debug)]
struct Step {
    /// dC.
    change: f64,
    /// Bound to first order of the error of C before it.
    left: f64,
    /// Distance from the border of the domain of the polar form.
    room: f64,
}

impl Orbit<'_> {
    /// The circle of this radius, with so many times more elements than are needed at least.
    fn circle<'a>(problem: Problem<'a>, finer: usize) -> Orbit<'a> {
        let Problem { weakening, belt_speed, radius } = problem;
        let breaks = weakening.breaks();
        let (from, to) = (weakening.piece_of(belt_speed - radius), weakening.piece_of(belt_speed + radius));
        let mut bounds = vec![0.0];
        bounds.extend((from..to).map(|piece| angle((belt_speed - breaks[piece + 1]) / radius)));
        let mirrored: Vec<f64> = bounds.iter().rev().map(|angle| TAU - angle).collect();
        bounds.push(PI);
        bounds.extend(mirrored);
        let spans = (from..=to).chain((from..=to).rev()).zip(bounds.windows(2));
        let spans = spans.map(|(piece, ends)| Span { piece, parts: finer * parts(ends[1] - ends[0]) });
        let spans: Vec<Span> = spans.collect();
        let elements =
            spans.iter().flat_map(|span| std::iter::repeat_n(Element::new(span.piece), span.parts));
        let elements = elements.collect();
        let mut orbit = Orbit {
            problem,
            viscous: 0.0,
            share: 1.0,
            curvature: 0.0,
            spans,
            bounds: Vec::new(),
            cos: Vec::new(),
            elements,
        };
        orbit.set_bounds(bounds);
        orbit
    }

    /// Puts the elements into their spans, and moves the functions with them, to first order.
    #[inline(always)]
    fn place<const N: usize>(&mut self, rule: &Rule<N>) {
        let mut elements = self.elements.iter_mut();
        let mut start = 0.0;
        for (span, ends) in self.spans.iter().zip(self.bounds.windows(2)) {
            let half = 0.5 * (ends[1] - ends[0]) / span.parts as f64;
            for (part, element) in (0..span.parts).zip(&mut elements) {
                let middle = half.mul_add(2.0 * part as f64 + 1.0, ends[0]);
                element.place(rule, middle, half);
                start = element.integrate(rule, start);
            }
        }
    }

    /// Prepares a step of Newton's method.
    #[inline(always)]
    fn step<const N: usize>(&mut self, rule: &Rule<N>) -> Step {
        let Self { problem: Problem { weakening: law, belt_speed, radius }, viscous, share, .. } = *self;
        // A, and the integrals of exp(-A) times dg/dC and the residual, at the beginning of an element.
        let [mut growth, mut by_damping, mut residual] = [0.0; 3];
        // Sums over all elements for each node.
        let [mut size, mut slopes, mut slopes_by_damping] = [[0.0; N]; 3];
        let mut room = [f64::INFINITY; N];
        for element in &mut self.elements {
            let piece = law.polynomial(element.piece);
            let [mut g, mut a, mut b, mut rho] = [[0.0; N]; 4];
            let [mut v, mut x, mut w, mut steepness] = [[0.0; N]; 4];
            let mut outermost = [0.0_f64; N];
            for j in 0..N {
                let log_r = element.log_r[j].clamp(-LARGEST_LOG, LARGEST_LOG);
                v[j] = radius * exp(log_r) * element.cos[j];
                x[j] = (belt_speed - v[j] - piece.middle) * piece.scale;
                outermost[j] = x[j].abs();
            }
            if outermost.iter().all(|x| *x <= OUTSIDE) {
                for j in 0..N {
                    [w[j], steepness[j]] = weakening(&piece, x[j]);
                }
            } else {
                // The ends of the span do not follow the orbit yet.
                for j in 0..N {
                    let u = (belt_speed - v[j]).clamp(0.0, law.reach());
                    let piece = law.polynomial(law.piece_of(u));
                    [w[j], steepness[j]] = weakening(&piece, (u - piece.middle) * piece.scale);
                }
            }
            for j in 0..N {
                let d = share.mul_add(w[j], -viscous);
                let left = LARGEST_LOG - element.log_r[j].abs();
                let turn = d.mul_add(element.sin_cos[j], 1.0);
                let left = left.min(turn - SLOWEST_TURN);
                room[j] = room[j].min(left);
                let inverse = 1.0 / turn.max(SLOWEST_TURN);
                let part = element.sin_squared[j] * inverse;
                g[j] = part * d;
                b[j] = -part * inverse;
                a[j] = b[j] * (share * steepness[j]) * v[j];
                rho[j] = g[j] - element.slope[j];
            }
            let half = element.half;
            let grown = apply(&rule.antiderivative, &a);
            let (mut weight, mut inverse, mut weighted_b, mut weighted_rho) =
                ([0.0; N], [0.0; N], [0.0; N], [0.0; N]);
            for j in 0..N {
                let exponent = half.mul_add(grown[j], growth).clamp(-LARGEST_GROWTH, LARGEST_GROWTH);
                weight[j] = exp(-exponent);
                inverse[j] = a[j] / weight[j];
                weighted_b[j] = weight[j] * b[j];
                weighted_rho[j] = weight[j] * rho[j];
            }
            let at_b = apply(&rule.antiderivative, &weighted_b);
            let at_rho = apply(&rule.antiderivative, &weighted_rho);
            for j in 0..N {
                let next = inverse[j].mul_add(half.mul_add(at_rho[j], residual), g[j]);
                let by = inverse[j].mul_add(half.mul_add(at_b[j], by_damping), b[j]);
                (element.next[j], element.by_damping[j]) = (next, by);
                size[j] = half.mul_add(weighted_rho[j].abs(), size[j]);
                slopes[j] = half.mul_add(next, slopes[j]);
                slopes_by_damping[j] = half.mul_add(by, slopes_by_damping[j]);
            }
            growth += half * dot(&rule.weights, &a);
            by_damping += half * dot(&rule.weights, &weighted_b);
            residual += half * dot(&rule.weights, &weighted_rho);
        }
        Step {
            change: -dot(&rule.weights, &slopes) / dot(&rule.weights, &slopes_by_damping),
            left: dot(&rule.weights, &size) / by_damping.abs(),
            room: room.iter().copied().fold(f64::INFINITY, f64::min),
        }
    }

    /// Makes the step, or as much of it as moves p by no more than [`LONGEST_STEP`]. Returns whether it was made whole.
    #[inline(always)]
    fn advance<const N: usize>(&mut self, rule: &Rule<N>, change: f64) -> bool {
        let mut start = 0.0;
        let mut longest = [0.0_f64; N];
        for element in &mut self.elements {
            // From here on the two arrays hold the new p' and p.
            for j in 0..N {
                element.next[j] = change.mul_add(element.by_damping[j], element.next[j]);
            }
            let next = first::<N>(&element.next);
            let rise = apply(&rule.antiderivative, &next);
            for j in 0..N {
                element.by_damping[j] = element.half.mul_add(rise[j], start);
                longest[j] = longest[j].max((element.by_damping[j] - element.log_r[j]).abs());
            }
            start = element.half.mul_add(dot(&rule.weights, &next), start);
        }
        let longest = longest.iter().copied().fold(0.0, f64::max);
        let share = if longest > LONGEST_STEP { LONGEST_STEP / longest } else { 1.0 };
        self.viscous += share * change;
        let mut start = 0.0;
        for element in &mut self.elements {
            for j in 0..N {
                element.slope[j] = share.mul_add(element.next[j] - element.slope[j], element.slope[j]);
            }
            start = element.integrate(rule, start);
        }
        share == 1.0
    }

    /// C for the circle to first order in D, and the largest |w| on it.
    #[inline(always)]
    fn first_order<const N: usize>(&self, rule: &Rule<N>) -> [f64; 2] {
        let Problem { weakening: law, belt_speed, radius } = self.problem;
        let (mut sum, mut largest) = (0.0, 0.0_f64);
        for element in &self.elements {
            let piece = law.polynomial(element.piece);
            for j in 0..N {
                let u = radius.mul_add(-element.cos[j], belt_speed);
                let [w, _] = weakening(&piece, (u - piece.middle) * piece.scale);
                sum += element.half * rule.weights[j] * element.sin_squared[j] * w;
                largest = largest.max(w.abs());
            }
        }
        [sum / PI, largest]
    }

    /// Moves the ends of the spans to the angles at which the orbit passes the ends of the pieces, unless
    /// all are closer than `allowed`, in units of the narrower piece, where the law is smooth, and
    /// `allowed_at_corners` (slip speeds) where it is not. Returns whether they were moved; `None` where the orbit leaves the pieces.
    #[inline(always)]
    fn follow(&mut self, allowed: f64, allowed_at_corners: f64) -> Option<bool> {
        let Problem { weakening, belt_speed, radius } = self.problem;
        let breaks = weakening.breaks();
        let half = self.spans.len() / 2;
        let mut at_bounds = Vec::with_capacity(self.bounds.len());
        at_bounds.push(0.0);
        let mut next = 0;
        for span in &self.spans {
            next += span.parts;
            at_bounds.push(self.elements[next - 1].end);
        }
        let farthest = radius * exp(at_bounds[half].clamp(-LARGEST_LOG, LARGEST_LOG));
        let last = self.spans[half].piece;
        if belt_speed + farthest > breaks[last + 1] {
            if last + 2 == breaks.len() {
                return None;
            }
            // A further piece, as yet without width.
            let width = PI - angle((belt_speed - breaks[last + 1]) / farthest);
            let span = Span { piece: last + 1, parts: parts(width) };
            let mut element = Element::new(span.piece);
            (element.log_r, element.end) = ([at_bounds[half]; MOST], at_bounds[half]);
            let before: usize = self.spans[..half].iter().map(|span| span.parts).sum();
            self.elements.splice(before..before, std::iter::repeat_n(element, 2 * span.parts));
            self.spans.splice(half..half, [span; 2]);
            let mut bounds = std::mem::take(&mut self.bounds);
            bounds.splice(half..half, [PI, PI]);
            self.set_bounds(bounds);
            return self.follow(0.0, 0.0);
        }
        let first = self.spans[0].piece;
        // The number of the end of a piece, counted on both sides.
        let number = |i: usize| if i < half { i } else { 2 * half - i };
        let slip = |i: usize| breaks[first + number(i)];
        let r = |i: usize| radius * exp(at_bounds[i].clamp(-LARGEST_LOG, LARGEST_LOG));
        let target = |i: usize| ((belt_speed - slip(i)) / r(i)).clamp(-1.0, 1.0);
        let kinked = !weakening.corners().is_empty();
        let inner = (1..half).chain(half + 1..2 * half);
        let misplaced = |i: usize| {
            let (below, above) = (breaks[first + number(i) - 1], breaks[first + number(i) + 1]);
            let limit = allowed * (slip(i) - below).min(above - slip(i));
            let limit = if kinked { limit.min(allowed_at_corners) } else { limit };
            r(i) * (self.cos[i] - target(i)).abs() > limit
        };
        if !inner.clone().any(misplaced) {
            return Some(false);
        }
        let mut bounds = self.bounds.clone();
        for i in inner {
            // Newton's step, in which r varies.
            let (sin, cos) = self.bounds[i].sin_cos();
            let d = self.share * weakening.at(slip(i)) - self.viscous;
            let turn = (d * sin).mul_add(cos, 1.0).clamp(SLOWEST_TURN, 2.0);
            let before_pi = i < half;
            let target = if before_pi { angle(target(i)) } else { TAU - angle(target(i)) };
            let moved = turn.mul_add(target - self.bounds[i], self.bounds[i]);
            let [lowest, highest] =
                if before_pi { [bounds[i - 1], PI] } else { [bounds[i - 1].max(PI), TAU] };
            bounds[i] = moved.clamp(lowest, highest);
        }
        self.set_bounds(bounds);
        Some(true)
    }

    fn set_bounds(&mut self, bounds: Vec<f64>) {
        self.cos = bounds.iter().map(|angle| angle.cos()).collect();
        self.bounds = bounds;
    }

    /// Cuts elements, and takes the functions over.
    #[inline(always)]
    fn refine(&mut self, rung: usize) {
        let (_, parts) = LADDER[rung];
        for span in &mut self.spans {
            span.parts *= parts;
        }
        let old = std::mem::take(&mut self.elements);
        self.elements = Vec::with_capacity(parts * old.len());
        for element in old {
            let width = element.half / parts as f64;
            for (part, matrix) in TRANSFERS[rung - 1].iter().enumerate() {
                let slope = apply(matrix, &element.slope);
                let middle = width.mul_add(2.0 * part as f64 + 1.0, element.middle - element.half);
                self.elements.push(Element { slope, middle, half: width, ..Element::new(element.piece) });
            }
        }
    }

    /// -x2 at its lowest, at the angle pi.
    fn lowest(&self) -> f64 {
        let before: usize = self.spans[..self.spans.len() / 2].iter().map(|span| span.parts).sum();
        self.problem.radius * self.elements[before - 1].end.exp()
    }

    /// The evaluations of g in a step.
    fn cost<const N: usize>(&self) -> u64 {
        (self.elements.len() * N) as u64
    }
}

/// The angle in [0, pi] with this cosine, or the nearest one.
fn angle(cos: f64) -> f64 {
    cos.clamp(-1.0, 1.0).acos()
}

/// The number of elements in a span.
fn parts(width: f64) -> usize {
    // The width has rounding errors.
    ((width / WIDEST - 1e-9).ceil() as usize).max(1)
}

impl Element {
    fn new(piece: usize) -> Self {
        let zero = [0.0; MOST];
        Self {
            piece,
            middle: 0.0,
            half: 0.0,
            cos: zero,
            sin_cos: zero,
            sin_squared: zero,
            log_r: zero,
            end: 0.0,
            slope: zero,
            next: zero,
            by_damping: zero,
        }
    }

    #[inline(always)]
    fn place<const N: usize>(&mut self, rule: &Rule<N>, middle: f64, half: f64) {
        // Where there was no width nothing is known about the function's slope.
        if self.half > 0.0 && (middle, half) != (self.middle, self.half) {
            let bend = apply(&rule.derivative, &first(&self.slope));
            for (j, bend) in bend.into_iter().enumerate() {
                // Farther than an element's half the slope at the node says nothing.
                let shift = (half - self.half).mul_add(rule.nodes[j], middle - self.middle) / self.half;
                self.slope[j] += bend * shift.clamp(-0.5, 0.5);
            }
        }
        (self.middle, self.half) = (middle, half);
        let (sin_middle, cos_middle) = middle.sin_cos();
        for j in 0..N {
            let [sin, cos] = sin_cos(half * rule.nodes[j]);
            let (sin, cos) = (sin_middle * cos + cos_middle * sin, cos_middle * cos - sin_middle * sin);
            (self.cos[j], self.sin_cos[j], self.sin_squared[j]) = (cos, sin * cos, sin * sin);
        }
    }

    /// p from p' and from its value at the beginning; returns that at the end.
    #[inline(always)]
    fn integrate<const N: usize>(&mut self, rule: &Rule<N>, start: f64) -> f64 {
        let slope = first::<N>(&self.slope);
        let rise = apply(&rule.antiderivative, &slope);
        for (log_r, rise) in self.log_r.iter_mut().zip(rise) {
            *log_r = self.half.mul_add(rise, start);
        }
        self.end = self.half.mul_add(dot(&rule.weights, &slope), start);
        self.end
    }
}

/// The steps of Newton's method on one rung, for the function whose vector width pulp selects at run time.
struct Solve<'a, 'b, const N: usize> {
    orbit: &'a mut Orbit<'b>,
    rule: &'a Rule<N>,
    /// Whether it starts from the circle, and else the rung to which the orbit is taken.
    starts: bool,
    rung: usize,
    /// How many times more elements there are than on the first rung.
    finer: usize,
    tolerance: f64,
    /// The largest |w|; found on the circle.
    unit: &'a mut f64,
}

/// Result of [`Solve`].
struct Solved {
    /// Error left by the iteration.
    left: f64,
    /// That of the iterate at the start.
    left_at_first: f64,
    rhs: u64,
}

impl<const N: usize> pulp::WithSimd for Solve<'_, '_, N> {
    /// `Err` with the number of evaluations where there is no answer.
    type Output = Result<Solved, u64>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        let Self { orbit, rule, starts, rung, finer, tolerance, unit } = self;
        if !starts {
            orbit.refine(rung);
            orbit.place(rule);
            return orbit.newton(rule, tolerance, *unit);
        }
        orbit.place(rule);
        [orbit.viscous, *unit] = orbit.first_order(rule);
        let mut spent = orbit.cost::<N>();
        // With w scaled by a share, from 0 on, where the circle is the answer. One step is enough for most orbits.
        let (mut share, mut step) = (0.0, 1.0);
        while step >= SHORTEST_SHARE {
            let next = f64::min(share + step, 1.0);
            let before = (share > 0.0).then(|| orbit.clone());
            orbit.rescale(rule, share, next);
            // On the way only the neighbourhood is needed.
            let enough = if next < 1.0 { tolerance.max(ON_THE_WAY) } else { tolerance };
            match orbit.newton(rule, enough, *unit) {
                Ok(solved) if next == 1.0 => return Ok(Solved { rhs: spent + solved.rhs, ..solved }),
                Ok(solved) => {
                    spent += solved.rhs;
                    share = next;
                }
                Err(rhs) => {
                    spent += rhs;
                    *orbit = match before {
                        Some(before) => before,
                        None => {
                            let mut circle = Orbit::circle(orbit.problem, finer);
                            circle.place(rule);
                            [circle.viscous, _] = circle.first_order(rule);
                            circle
                        }
                    };
                    step *= 0.5;
                }
            }
        }
        Err(spent)
    }
}

impl Orbit<'_> {
    /// From the law with w scaled by `from` to that with w scaled by `to`, to first order.
    #[inline(always)]
    fn rescale<const N: usize>(&mut self, rule: &Rule<N>, from: f64, to: f64) {
        self.share = to;
        let ratio = if from > 0.0 { to / from } else { to };
        self.viscous *= ratio;
        if from > 0.0 {
            let mut start = 0.0;
            for element in &mut self.elements {
                element.slope = element.slope.map(|slope| ratio * slope);
                start = element.integrate(rule, start);
            }
        }
    }

    /// Steps of Newton's method until the error of C that is left is `tolerance` times `unit`; `Err` with the
    /// number of evaluations where it is not reached.
    #[inline(always)]
    fn newton<const N: usize>(&mut self, rule: &Rule<N>, tolerance: f64, unit: f64) -> Result<Solved, u64> {
        let enough = (0.1 * tolerance + ROUND_OFF) * unit;
        let speed = self.problem.belt_speed;
        let mut rhs = 0;
        let mut left_at_first = f64::NAN;
        let (mut before, mut moved) = (f64::NAN, false);
        for steps in 0..MOST_STEPS {
            let step = self.step(rule);
            rhs += self.cost::<N>();
            if steps == 0 {
                left_at_first = step.left;
            }
            let whole = self.advance(rule, step.change);
            // From here the iteration does not come back.
            let lost = step.left > HOPELESS * unit || step.room < FARTHEST_OUTSIDE;
            if lost || !self.viscous.is_finite() {
                return Err(rhs);
            }
            if before < NEAR * unit && !moved {
                self.curvature = self.curvature.max(step.left / (before * before));
            }
            // What the step itself leaves.
            let after = PREDICTION * self.curvature * step.left * step.left;
            let left = if self.curvature > 0.0 && !moved && step.left < NEAR * unit {
                after.min(step.left)
            } else {
                step.left
            };
            if whole && left <= enough {
                return if step.room > 0.0 { Ok(Solved { left, left_at_first, rhs }) } else { Err(rhs) };
            }
            before = step.left;
            // w has a jump in its slope of at most about its size over the width of a piece.
            match self.follow(0.02, 0.1 * speed * (0.1 * tolerance).sqrt()) {
                Some(true) => {
                    self.place(rule);
                    moved = true;
                }
                Some(false) => moved = false,
                None => return Err(rhs),
            }
        }
        Err(rhs)
    }
}

/// The C at which the orbit through the maximum `radius` of x2, 0 < `radius` <= V, closes, with an error of
/// at most `tolerance` in units of the weakening rate; `Err` with the number of evaluations where the polar
/// form does not apply or no rung reaches that.
pub(super) fn closing_damping(
    weakening: &Weakening,
    belt_speed: f64,
    radius: f64,
    tolerance: f64,
) -> Result<Closing, u64> {
    if !(belt_speed + radius <= weakening.reach()) {
        return Err(0);
    }
    let arch = pulp::Arch::new();
    let problem = Problem { weakening, belt_speed, radius };
    let mut orbit = Orbit::circle(problem, 1);
    let mut finer = 1;
    let mut unit = 0.0;
    let mut rhs = 0;
    let mut before: Option<f64> = None;
    let mut failures = 0;
    for (rung, (nodes, parts)) in LADDER.into_iter().enumerate() {
        if orbit.elements.len() * parts > MOST_ELEMENTS {
            return Err(rhs);
        }
        finer *= parts;
        let starts = before.is_none();
        if starts {
            orbit = Orbit::circle(problem, finer);
        }
        let (now, unit_now) = (&mut orbit, &mut unit);
        let asked = tolerance;
        let tolerance = FLOORS.get(rung).map_or(asked, |floor| asked.max(*floor));
        let solved = match nodes {
            4 => arch.dispatch(Solve {
                orbit: now,
                rule: &RULES.0,
                starts,
                rung,
                finer,
                tolerance,
                unit: unit_now,
            }),
            _ => arch.dispatch(Solve {
                orbit: now,
                rule: &RULES.1,
                starts,
                rung,
                finer,
                tolerance,
                unit: unit_now,
            }),
        };
        let Solved { left, left_at_first, rhs: spent } = match solved {
            Ok(solved) => solved,
            Err(spent) => {
                // Coarse elements may fail where finer ones do not.
                rhs += spent;
                before = None;
                failures += 1;
                if failures > RETRIES {
                    return Err(rhs);
                }
                continue;
            }
        };
        rhs += spent;
        if let Some(before) = before {
            let uncertain = 2.0 * (orbit.viscous - before).abs() + left_at_first * left_at_first / unit;
            let last = rung + 1 == LADDER.len() || orbit.elements.len() > MOST_ELEMENTS / 2;
            let allowed = if last { asked.max(WORST) } else { asked + 4.0 * ROUND_OFF };
            if uncertain <= allowed * unit {
                let form = weakening.error(belt_speed - radius, belt_speed + orbit.lowest()).bound();
                let error = uncertain + left + ROUND_OFF * unit + form;
                return Ok(Closing { viscous: orbit.viscous, error, rhs });
            }
        }
        before = Some(orbit.viscous);
    }
    Err(rhs)
}

//! The divergence in the skew axes, and elementary functions for its integration.

use pulp::Simd;

use super::lanes::Lanes;

/// A function's values at the two nodes of a pair.
#[derive(Clone, Copy)]
pub(super) struct Pair<S: Simd> {
    pub(crate) late: Lanes<S>,
    pub(crate) early: Lanes<S>,
}

impl<S: Simd> Pair<S> {
    /// The pair with these even and odd parts.
    #[inline(always)]
    pub(super) fn of_parts(even: Lanes<S>, odd: Lanes<S>) -> Self {
        Self { late: even + odd, early: even - odd }
    }

    #[inline(always)]
    pub(super) fn add(self, other: Self) -> Self {
        Self { late: self.late + other.late, early: self.early + other.early }
    }

    #[inline(always)]
    pub(super) fn sub(self, other: Self) -> Self {
        Self { late: self.late - other.late, early: self.early - other.early }
    }

    #[inline(always)]
    pub(super) fn mul(self, other: Self) -> Self {
        Self { late: self.late * other.late, early: self.early * other.early }
    }

    /// The sum of both squares.
    #[inline(always)]
    pub(super) fn square(self) -> Lanes<S> {
        self.late.mul_add(self.late, self.early * self.early)
    }
}

/// The field of the orbits, with q and u = q^2 multiplied by omega and omega^2 where that saves operations.
pub(super) struct Field<S: Simd> {
    pub(crate) k: Lanes<S>,
    ak: Lanes<S>,
    b2: Lanes<S>,
    pub(crate) q1: Lanes<S>,
    pub(crate) mu: Lanes<S>,
    pub(crate) omega2: Lanes<S>,
    pub(crate) inverse_omega3: Lanes<S>,
    /// k omega and (1 + k) omega.
    k_hat: Lanes<S>,
    q1_hat: Lanes<S>,
    /// E u / x omega^-3 as a polynomial in q omega.
    g: [Lanes<S>; 3],
    /// J times a square as a polynomial in q omega.
    j: [Lanes<S>; 2],
    /// Sum of the sizes of the terms of d0.
    pub(crate) terms: Lanes<S>,
}

/// H at a pair of nodes, and the terms that decide whether the orbit stays in the domain.
pub(super) struct Values<S: Simd> {
    pub(crate) h: Pair<S>,
    pub(crate) q: Pair<S>,
    pub(crate) u: Pair<S>,
    pub(crate) turn: Pair<S>,
}

impl<S: Simd> Field<S> {
    #[inline(always)]
    pub(super) fn new(a: Lanes<S>, k: Lanes<S>, b: Lanes<S>, c: Lanes<S>) -> Self {
        let one = a.same(1.0);
        let q1 = one + k;
        let inverse_q1 = one / q1;
        let weakening = a * inverse_q1 * inverse_q1;
        let b2 = b + b;
        let d0 = weakening - (c + b2);
        let omega2 = (d0 * d0).neg_mul_add(a.same(0.25), one);
        let omega = omega2.sqrt();
        let inverse_omega = one / omega;
        let inverse_omega2 = inverse_omega * inverse_omega;
        let inverse_omega3 = inverse_omega2 * inverse_omega;
        let ak = weakening * k;
        let g2 = b2 * inverse_omega3;
        Self {
            k,
            ak,
            b2,
            q1,
            mu: d0 * inverse_omega * a.same(-0.5),
            omega2,
            inverse_omega3,
            k_hat: k * omega,
            q1_hat: q1 * omega,
            g: [ak * q1 * inverse_omega, ak * inverse_omega2, g2],
            j: [(a + a) * k, g2],
            terms: weakening + c.abs() + b2,
        }
    }

    /// Evaluates H at a pair of nodes with positions `x` and crossing factors omega^2 Q, with one division.
    #[inline(always)]
    pub(super) fn at(&self, x: Pair<S>, crossing: Pair<S>) -> Values<S> {
        let (late_q, late_u, late_n, late_turn) = self.terms(x.late, crossing.late);
        let (early_q, early_u, early_n, early_turn) = self.terms(x.early, crossing.early);
        let inverse = late_turn.same(1.0) / (late_turn * early_turn);
        Values {
            h: Pair { late: late_n * early_turn * inverse, early: early_n * late_turn * inverse },
            q: Pair { late: late_q, early: early_q },
            u: Pair { late: late_u, early: early_u },
            turn: Pair { late: late_turn, early: early_turn },
        }
    }

    /// q, u = q^2, and numerator and denominator of H at a node.
    #[inline(always)]
    fn terms(&self, x: Lanes<S>, crossing: Lanes<S>) -> (Lanes<S>, Lanes<S>, Lanes<S>, Lanes<S>) {
        let q = self.k_hat.neg_mul_add(x, self.q1_hat);
        let u = q * q;
        let n = x * self.g[2].mul_add(u, self.g[1].mul_add(q, self.g[0]));
        (q, u, n, n.mul_add(crossing, u))
    }

    /// H and J at an angle 0 or pi, where Q = 0.
    #[inline(always)]
    pub(super) fn on_axis(&self, x: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
        let q = self.k.neg_mul_add(x, self.q1);
        let inverse = x.same(1.0) / q;
        let scale = x * self.inverse_omega3;
        let square = inverse * inverse;
        let h = (self.ak * (self.q1 + q)).mul_add(square, self.b2);
        let j = (self.j[0] * square).mul_add(inverse, self.b2);
        (h * scale, j * scale)
    }
}

/// Coefficients of a combination of [`Nodes::guess`]: the function has given values at the angles 0, pi and
/// 2 pi, and to first order follows cos t + mu sin t.
#[derive(Clone, Copy)]
pub(super) struct Combination<S: Simd>(pub(crate) [Lanes<S>; 4]);

impl<S: Simd> Combination<S> {
    #[inline(always)]
    pub(super) fn through(start: Lanes<S>, middle: Lanes<S>, end: Lanes<S>, mu: Lanes<S>) -> Self {
        let mean = (start + end) * mu.same(0.25);
        let c1 = middle.neg_mul_add(mu.same(0.5), mean);
        Self([c1, middle.mul_add(mu.same(0.5), mean), (end - start) * mu.same(0.5), c1 * mu])
    }

    /// Even and odd part at a pair of nodes, from the values there of the four functions.
    #[inline(always)]
    pub(super) fn parts(&self, functions: &[f64; 4]) -> (Lanes<S>, Lanes<S>) {
        let [a, b, c, d] = self.0;
        let even = b.mul_add(a.same(functions[1]), a * a.same(functions[0]));
        let odd = d.mul_add(a.same(functions[3]), c * a.same(functions[2]));
        (even, odd)
    }
}

/// exp(x) - 1 to about 64 ulps of the greater of x and exp(x) for |x| < 5, less accurate beyond.
#[inline(always)]
pub(super) fn exp_m1<S: Simd>(x: Lanes<S>) -> Lanes<S> {
    let x = x * x.same(1.0 / 64.0);
    let mut p = x.same(1.0 / 40320.0);
    for factor in [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0] {
        p = p.mul_add(x, x.same(factor));
    }
    let mut e = p * x;
    for _ in 0..6 {
        e = e.mul_add(e, e + e);
    }
    e
}

/// cosh z and sinh z for |z| < 1, to 1e-6 (z/2)^10.
#[inline(always)]
pub(super) fn cosh_sinh<S: Simd>(z: Lanes<S>) -> (Lanes<S>, Lanes<S>) {
    let z = z * z.same(0.5);
    let y = z * z;
    let mut cosh = z.same(1.0 / 40320.0);
    for factor in [1.0 / 720.0, 1.0 / 24.0, 0.5, 1.0] {
        cosh = cosh.mul_add(y, z.same(factor));
    }
    let mut sinh = z.same(1.0 / 362_880.0);
    for factor in [1.0 / 5040.0, 1.0 / 120.0, 1.0 / 6.0, 1.0] {
        sinh = sinh.mul_add(y, z.same(factor));
    }
    let sinh = sinh * z;
    let twice = sinh + sinh;
    (twice.mul_add(sinh, z.same(1.0)), twice * cosh)
}

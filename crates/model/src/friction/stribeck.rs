//! The paper's Stribeck law, section 5:
//! `phi(u) = (1 - alpha)/(1 + eps gamma u) + alpha + eps beta u^2`.
//!
//! Departures from the text: the paper writes the law in the signed argument x2 - V and drops the sign in
//! its system (15); here u = |x2 - V|, which is what its figures and its condition (12) use.

use super::built_in::{BuiltIn, ClosedForm, Strengthening, rounded};
use super::family::Series;
use super::{FirstOrder, Gradient, Parameter, Range};
use crate::point::{LawParameters, ScaledGroups};
use slipmap_numbers::jet::Real;

/// The law. The limits alpha = 1, beta = 0 and gamma = 0 are legal.
pub(super) const LAW: BuiltIn = BuiltIn {
    name: "stribeck",
    formula: "(1 - alpha)/(1 + eps*gamma*u) + alpha + eps*beta*u^2",
    of_coefficients: "mu_k + (mu_s - mu_k)/(1 + u/v_s) + eta*u^2",
    parameters: &[ALPHA, BETA, GAMMA],
    depends_on_epsilon: true,
    phi_at: |u, epsilon, parameters| {
        let &[alpha, beta, gamma] = parameters else { return None };
        let one = Series::constant(1.0);
        Some((one - alpha) / (one + epsilon * gamma * u) + alpha + epsilon * beta * u * u)
    },
    strengthening: Strengthening::Quadratic,
    parameters_of: |of, velocity| {
        LawParameters::new(&[of.kinetic, of.strengthening * velocity * velocity, velocity / of.width])
    },
};

const ALPHA: Parameter = Parameter {
    name: "alpha",
    long_name: "kinetic to static friction ratio at high slip speed",
    min: 0.0,
    max: 1.0,
};
const BETA: Parameter = Parameter {
    name: "beta",
    long_name: "quadratic strengthening of friction",
    min: 0.0,
    max: f64::INFINITY,
};
const GAMMA: Parameter =
    Parameter { name: "gamma", long_name: "rate of Stribeck weakening", min: 0.0, max: f64::INFINITY };

/// The Stribeck curve at fixed eps, alpha, beta, gamma.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stribeck {
    /// eps, as it was given.
    pub epsilon: f64,
    /// 1 - alpha, rounded to the nearest f64.
    pub drop: f64,
    /// gamma, as it was given.
    pub gamma: f64,
    /// beta, as it was given.
    pub beta: f64,
    /// eps gamma.
    rate: f64,
}

impl Stribeck {
    pub(super) fn new(epsilon: f64, parameters: &LawParameters) -> Self {
        let &[alpha, beta, gamma] = parameters.as_slice() else {
            unreachable!("a Stribeck point has alpha, beta and gamma");
        };
        Self { epsilon, drop: 1.0 - alpha, gamma, beta, rate: epsilon * gamma }
    }

    #[inline]
    pub(super) fn phi(&self, u: f64) -> f64 {
        // 1 - drop * x/(1+x), which keeps phi(0) = 1 exact and small changes of phi accurate.
        let x = self.rate * u;
        1.0 - self.drop * x / (1.0 + x) + self.epsilon * self.beta * u * u
    }

    /// -phi'(u).
    #[inline]
    pub(super) fn weakening(&self, u: f64) -> f64 {
        let q = 1.0 + self.rate * u;
        self.rate * self.drop / (q * q) - 2.0 * self.epsilon * self.beta * u
    }

    /// phi(u) in any arithmetic.
    pub(super) fn formula<T: Real>(&self, u: T) -> T {
        let c = T::constant;
        let x = c(self.rate) * u;
        c(1.0) - c(self.drop) * x / (c(1.0) + x) + c(self.epsilon) * c(self.beta) * u * u
    }

    /// Proved bounds of the weakening rate at one slip speed. In units in the last place the rate of weakening has 1/2, q at
    /// most 2, the quotient by its square 6 with its factors, and the rise 2.
    #[inline]
    pub(super) fn bounds(&self, u: f64) -> Range {
        let q = 1.0 + self.rate * u;
        let at_rest = self.rate * self.drop;
        rounded(at_rest / (q * q), 8.0, 2.0 * self.epsilon * self.beta * u, at_rest)
    }

    /// The weakening rate falls with u, so its bounds are those at the ends.
    pub(super) fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        Range { lo: self.bounds(hi).lo, hi: self.bounds(lo).hi }
    }

    /// The scaled groups at belt speed V and damping force rate C = eps c.
    #[must_use]
    pub fn scaled(&self, belt_speed: f64, viscous: f64) -> ScaledGroups {
        ScaledGroups {
            a: self.rate * self.drop,
            k: self.rate * belt_speed,
            b: self.epsilon * self.beta * belt_speed,
            c: viscous,
        }
    }
}

impl ClosedForm for Stribeck {
    fn is_normal(&self) -> bool {
        let slope = self.rate * self.drop;
        [(self.rate, self.gamma), (slope, self.gamma * self.drop), (self.epsilon * self.beta, self.beta)]
            .into_iter()
            .all(|(product, factor)| factor == 0.0 || product.abs() >= f64::MIN_POSITIVE)
    }

    fn gradient(&self, u: f64) -> Gradient {
        let Self { epsilon, drop, gamma, beta, rate } = *self;
        let x = rate * u;
        let q = 1.0 + x;
        // d/dx (x / q^2) = (1 - x) / q^3, and eps gamma / q^2 = x / (q^2 u).
        let by_rate = drop * (1.0 - x) / (q * q * q);
        Gradient {
            epsilon: gamma * by_rate - 2.0 * beta * u,
            parameters: LawParameters::new(&[-rate / (q * q), -2.0 * epsilon * u, epsilon * by_rate]),
        }
    }

    /// Closed form of the average: 2A / (q (1 + k + q)) - 2b with q = sqrt(1 + 2k), free of cancellation
    /// for all k >= 0.
    fn mean_weakening(&self, belt_speed: f64) -> f64 {
        let ScaledGroups { a, k, b, .. } = self.scaled(belt_speed, 0.0);
        let q = (1.0 + 2.0 * k).sqrt();
        2.0 * a / (q * (1.0 + k + q)) - 2.0 * b
    }

    fn onset(&self) -> f64 {
        self.rate.recip()
    }

    fn weakening_is_convex(&self) -> bool {
        true
    }

    /// Bounds of phi on [0, hi]. phi is convex, so it is largest at an end.
    fn friction_range(&self, hi: f64) -> Option<Range> {
        let x = self.rate * hi;
        Some(Range { lo: 1.0 - self.drop * (1.0 - 1.0 / (1.0 + x)), hi: self.phi(hi).max(1.0) })
    }

    /// The even part of 1/(1 + k(1 - s))^2 is convex in s: least at s = 0, greatest at |s| = 1. The even
    /// part of the linear term is its value at belt speed.
    fn even_weakening_range(&self, belt_speed: f64) -> Option<Range> {
        let ScaledGroups { a, k, b, .. } = self.scaled(belt_speed, 0.0);
        let far = 1.0 + 2.0 * k;
        // Rounded as in `bounds`.
        let of = |fall: f64| rounded(fall, 8.0, 2.0 * b, a);
        Some(Range { lo: of(a / ((1.0 + k) * (1.0 + k))).lo, hi: of(0.5 * a * (1.0 + 1.0 / (far * far))).hi })
    }

    /// F1(u) = -gamma (1 - alpha) u + beta u^2; its average over the grazing circle is the left side of
    /// the paper's (12) without c.
    fn first_order(&self, belt_speed: f64) -> Option<FirstOrder> {
        let at_rest = self.gamma * self.drop;
        Some(FirstOrder {
            mean_weakening: at_rest - 2.0 * self.beta * belt_speed,
            mean_error: 0.0,
            weakening_range: Range { lo: at_rest - 4.0 * self.beta * belt_speed, hi: at_rest },
        })
    }
}

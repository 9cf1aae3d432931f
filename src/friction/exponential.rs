//! The exponential law of Tustin and of Bo and Pavelescu, with a viscous part:
//! `phi(u) = mu + (1 - mu) exp(-u / vs) + eta u`. It does not depend on eps.

use super::jet::Real;
use super::{Gradient, Parameter, Range};
use crate::point::LawParameters;

/// mu, vs, eta, in this order; shared by the laws that fall from 1 to mu over the speed vs.
pub(super) const PARAMETERS: [Parameter; 3] = [
    Parameter { name: "mu", long_name: "kinetic to static friction ratio", min: 0.0, max: 1.0 },
    Parameter { name: "vs", long_name: "Stribeck velocity", min: f64::MIN_POSITIVE, max: f64::INFINITY },
    Parameter { name: "eta", long_name: "viscous strengthening of friction", min: 0.0, max: f64::INFINITY },
];

/// The curve at fixed parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Exponential {
    /// 1 - mu.
    drop: f64,
    /// 1 / vs.
    rate: f64,
    eta: f64,
}

/// phi of a law that falls from 1 to mu as `rest` falls from 1 to 0, in any arithmetic.
pub(super) fn falling_from_one<T: Real>(rest: T, u: T, mu: T, eta: T) -> T {
    mu + (T::constant(1.0) - mu) * rest + eta * u
}

impl Exponential {
    pub(super) fn new(parameters: &LawParameters) -> Self {
        let &[mu, vs, eta] = parameters.as_slice() else {
            unreachable!("an exponential point has mu, vs and eta");
        };
        Self { drop: 1.0 - mu, rate: 1.0 / vs, eta }
    }

    /// Returns whether no coefficient of the law is a product below the normal numbers, where it may be wrong
    /// by any factor.
    pub(super) fn is_normal(&self) -> bool {
        self.rate.is_normal() && (self.drop == 0.0 || (self.drop * self.rate).is_normal())
    }

    #[inline]
    pub(super) fn phi(&self, u: f64) -> f64 {
        1.0 + self.drop * (-self.rate * u).exp_m1() + self.eta * u
    }

    #[inline]
    pub(super) fn weakening(&self, u: f64) -> f64 {
        self.drop * self.rate * (-self.rate * u).exp() - self.eta
    }

    pub(super) fn formula<T: Real>(&self, u: T) -> T {
        let c = T::constant;
        c(1.0) - c(self.drop) + c(self.drop) * (-u * c(self.rate)).exp() + c(self.eta) * u
    }

    /// Derivatives of the weakening rate.
    pub(super) fn gradient(&self, u: f64) -> Gradient {
        let x = self.rate * u;
        let fade = self.rate * (-x).exp();
        let by_vs = -self.rate * self.drop * fade * (1.0 - x);
        Gradient { epsilon: 0.0, parameters: LawParameters::new(&[-fade, by_vs, -1.0]) }
    }

    /// The weakening rate falls with u.
    pub(super) fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        Range { lo: self.weakening(hi), hi: self.weakening(lo) }
    }

    /// The even part of exp(-(V - v) / vs) is exp(-V / vs) cosh(v / vs).
    pub(super) fn even_weakening_range(&self, belt_speed: f64) -> Range {
        let scale = self.drop * self.rate;
        let fade = (-2.0 * self.rate * belt_speed).exp();
        Range { lo: self.weakening(belt_speed), hi: 0.5 * scale * (1.0 + fade) - self.eta }
    }
}

//! The exponential law of Tustin and of Bo and Pavelescu, with a viscous part:
//! `phi(u) = mu + (1 - mu) exp(-u / vs) + eta u`. It does not depend on eps.

use super::built_in::{BuiltIn, ClosedForm, Fall, Strengthening};
use super::family::Series;
use super::{Gradient, Parameter, Range, mean};
use crate::point::LawParameters;
use slipmap_numbers::jet::Real;

/// The law.
pub(super) const LAW: BuiltIn = BuiltIn {
    name: "exponential",
    formula: "φ(u) = μ + (1 − μ) exp(−u / vs) + η u",
    parameters: &PARAMETERS,
    depends_on_epsilon: false,
    phi_at: |u, _, parameters| {
        let &[mu, vs, eta] = parameters else { return None };
        Some(falling_from_one((-u / vs).exp(), u, mu, eta))
    },
    strengthening: Strengthening::Linear,
    parameters_of,
};

/// mu, vs, eta, in this order; shared by the laws that fall from 1 to mu over the speed vs.
pub(super) const PARAMETERS: [Parameter; 3] = [
    Parameter { name: "mu", long_name: "kinetic to static friction ratio", min: 0.0, max: 1.0 },
    Parameter { name: "vs", long_name: "Stribeck velocity", min: f64::MIN_POSITIVE, max: f64::INFINITY },
    Parameter { name: "eta", long_name: "viscous strengthening of friction", min: 0.0, max: f64::INFINITY },
];

/// The curve at fixed parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponential {
    /// 1 - mu.
    drop: f64,
    /// 1 / vs.
    rate: f64,
    eta: f64,
}

/// phi of a law that falls from 1 to mu as `rest` falls from 1 to 0.
pub(super) fn falling_from_one(rest: Series, u: Series, mu: Series, eta: Series) -> Series {
    mu + (Series::constant(1.0) - mu) * rest + eta * u
}

/// mu, vs and eta of a machine's friction.
pub(super) fn parameters_of(friction: &Fall, velocity: f64) -> LawParameters {
    LawParameters::new(&[friction.kinetic, friction.width / velocity, friction.strengthening * velocity])
}

/// A weakening rate that falls exponentially, `steepest exp(-rate u) - rise`, for vectorised engines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialFall {
    /// Its part that falls, at rest.
    pub steepest: f64,
    /// 1 / vs.
    pub rate: f64,
    /// The rise of friction with the slip speed.
    pub rise: f64,
}

impl Exponential {
    pub(super) fn fall(&self) -> ExponentialFall {
        ExponentialFall { steepest: self.drop * self.rate, rate: self.rate, rise: self.eta }
    }

    pub(super) fn new(parameters: &LawParameters) -> Self {
        let &[mu, vs, eta] = parameters.as_slice() else {
            unreachable!("an exponential point has mu, vs and eta");
        };
        Self { drop: 1.0 - mu, rate: 1.0 / vs, eta }
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

    /// The weakening rate falls with u.
    pub(super) fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        Range { lo: self.weakening(hi), hi: self.weakening(lo) }
    }
}

impl ClosedForm for Exponential {
    fn is_normal(&self) -> bool {
        self.rate.is_normal() && (self.drop == 0.0 || (self.drop * self.rate).is_normal())
    }

    fn gradient(&self, u: f64) -> Gradient {
        let x = self.rate * u;
        let fade = self.rate * (-x).exp();
        let by_vs = -self.rate * self.drop * fade * (1.0 - x);
        Gradient { epsilon: 0.0, parameters: LawParameters::new(&[-fade, by_vs, -1.0]) }
    }

    fn mean_weakening(&self, belt_speed: f64) -> f64 {
        mean::mean_weakening(|u| self.weakening(u), belt_speed)
    }

    fn cost(&self) -> u64 {
        2
    }

    fn weakening_is_convex(&self) -> bool {
        true
    }

    /// The even part of exp(-(V - v) / vs) is exp(-V / vs) cosh(v / vs).
    fn even_weakening_range(&self, belt_speed: f64) -> Option<Range> {
        let scale = self.drop * self.rate;
        let fade = (-2.0 * self.rate * belt_speed).exp();
        Some(Range { lo: self.weakening(belt_speed), hi: 0.5 * scale * (1.0 + fade) - self.eta })
    }
}

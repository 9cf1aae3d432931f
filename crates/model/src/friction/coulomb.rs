//! Coulomb's law with two coefficients, and a viscous part: `phi(u) = 1 - drop + eta u` in slip, 1 at rest. It
//! does not depend on eps.

use super::built_in::{BuiltIn, ClosedForm, Fall, Strengthening};
use super::family::Series;
use super::{DROP, Gradient, Parameter, Range, exponential};
use crate::point::LawParameters;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::jet::Real;

/// The law.
pub(super) const LAW: BuiltIn = BuiltIn {
    name: "coulomb",
    formula: "1 - drop + eta*u",
    of_coefficients: "mu_k + eta*u",
    parameters: &[DROP, ETA],
    depends_on_epsilon: false,
    phi_at: |u, _, parameters| {
        let &[drop, eta] = parameters else { return None };
        Some(Series::constant(1.0) - drop + eta * u)
    },
    strengthening: Strengthening::Linear,
    parameters_of: |friction: &Fall, velocity| {
        LawParameters::new(&[1.0 - friction.kinetic, friction.strengthening * velocity])
    },
};

const ETA: Parameter = exponential::PARAMETERS[2];

/// The curve at fixed parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coulomb {
    drop: f64,
    eta: f64,
}

impl Coulomb {
    pub(super) fn new(parameters: &LawParameters) -> Self {
        let &[drop, eta] = parameters.as_slice() else {
            unreachable!("a point of Coulomb's law has drop and eta");
        };
        Self { drop, eta }
    }

    pub(super) fn drop(&self) -> f64 {
        self.drop
    }

    #[inline]
    pub(super) fn phi(&self, u: f64) -> f64 {
        self.eta.times_plus(u, 1.0 - self.drop)
    }

    #[inline]
    pub(super) fn weakening(&self, _: f64) -> f64 {
        -self.eta
    }

    pub(super) fn formula<T: Real>(&self, u: T) -> T {
        T::constant(1.0) - T::constant(self.drop) + T::constant(self.eta) * u
    }

    pub(super) fn weakening_range(&self, _: f64, _: f64) -> Range {
        Range { lo: -self.eta, hi: -self.eta }
    }
}

impl ClosedForm for Coulomb {
    fn is_normal(&self) -> bool {
        true
    }

    fn gradient(&self, _: f64) -> Gradient {
        Gradient { epsilon: 0.0, parameters: LawParameters::new(&[0.0, -1.0]) }
    }

    fn mean_weakening(&self, _: f64) -> f64 {
        -self.eta
    }

    fn onset(&self) -> f64 {
        f64::INFINITY
    }

    fn weakening_is_convex(&self) -> bool {
        true
    }

    fn even_weakening_range(&self, _: f64) -> Option<Range> {
        Some(Range { lo: -self.eta, hi: -self.eta })
    }
}

//! The Lorentzian law of Hess and Soom, with a viscous part:
//! `phi(u) = mu + (1 - mu) / (1 + (u / vs)^2) + eta u`. It does not depend on eps.
//!
//! It starts flat: the weakening rate rises from -eta at rest to its maximum at u = vs / sqrt(3) and falls
//! from there. Around that maximum stable slip cycles arise.

use super::built_in::{BuiltIn, ClosedForm, ONSET, Strengthening, range_about_peak, rounded};
use super::exponential::{PARAMETERS, falling_from_one, parameters_of};
use super::family::Series;
use super::{Gradient, Range};
use crate::point::LawParameters;
use slipmap_numbers::jet::Real;

/// The law.
pub(super) const LAW: BuiltIn = BuiltIn {
    name: "lorentzian",
    formula: "mu + (1 - mu)/(1 + (u/vs)^2) + eta*u",
    of_coefficients: "mu_k + (mu_s - mu_k)/(1 + (u/v_s)^2) + eta*u",
    parameters: &PARAMETERS,
    depends_on_epsilon: false,
    phi_at: |u, _, parameters| {
        let &[mu, vs, eta] = parameters else { return None };
        let (x, one) = (u / vs, Series::constant(1.0));
        Some(falling_from_one(one / (one + x * x), u, mu, eta))
    },
    strengthening: Strengthening::Linear,
    parameters_of,
};

/// The curve at fixed parameters: mu, vs and eta, like those of the exponential law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lorentzian {
    /// 1 - mu.
    pub drop: f64,
    /// 1 / vs.
    pub rate: f64,
    /// Viscous coefficient eta.
    pub eta: f64,
}

impl Lorentzian {
    pub(super) fn new(parameters: &LawParameters) -> Self {
        let &[mu, vs, eta] = parameters.as_slice() else {
            unreachable!("a Lorentzian point has mu, vs and eta");
        };
        Self { drop: 1.0 - mu, rate: 1.0 / vs, eta }
    }

    #[inline]
    pub(super) fn phi(&self, u: f64) -> f64 {
        let x = self.rate * u;
        let square = x * x;
        // For large x, x^2 overflows, and the fraction is 1.
        let fallen = if square < 1e300 { square / (1.0 + square) } else { 1.0 };
        1.0 - self.drop * fallen + self.eta * u
    }

    /// With x = u / vs it is 2 (1 - mu) / vs times x / (1 + x^2)^2, less eta.
    #[inline]
    pub fn weakening(&self, u: f64) -> f64 {
        let x = self.rate * u;
        let q = 1.0 + x * x;
        2.0 * self.drop * self.rate * (x / q) / q - self.eta
    }

    /// Proved bounds of the weakening rate at one slip speed. In units in the last place x has 1, q at most 3, the two quotients
    /// 8 and the factors 2.
    fn bounds(&self, u: f64) -> Range {
        let x = self.rate * u;
        let q = 1.0 + x * x;
        let scale = 2.0 * self.drop * self.rate;
        rounded(scale * (x / q) / q, 12.0, self.eta, scale)
    }

    /// The weakening rate has one maximum, at u = vs / sqrt(3).
    pub fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        range_about_peak(|u| self.bounds(u), 1.0 / (3f64.sqrt() * self.rate), lo, hi)
    }

    pub(super) fn formula<T: Real>(&self, u: T) -> T {
        let (x, c) = (u * T::constant(self.rate), T::constant);
        c(1.0 - self.drop) + c(self.drop) / (c(1.0) + x * x) + c(self.eta) * u
    }
}

impl ClosedForm for Lorentzian {
    fn is_normal(&self) -> bool {
        self.rate.is_normal() && (self.drop == 0.0 || (self.drop * self.rate).is_normal())
    }

    fn gradient(&self, u: f64) -> Gradient {
        let x = self.rate * u;
        let q = 1.0 + x * x;
        let by_vs = -4.0 * self.rate * self.rate * self.drop * ((x / q) * ((1.0 - x * x) / q) / q);
        Gradient {
            epsilon: 0.0,
            parameters: LawParameters::new(&[-2.0 * self.rate * (x / q) / q, by_vs, -1.0]),
        }
    }

    fn onset(&self) -> f64 {
        ONSET * self.rate.recip()
    }

    /// By parts it is the mean of 2 phi(V - V cos t) cos t / V. With 1 / (1 + x^2) = Re 1 / (1 + i x), k = V / vs and
    /// p + i q the root of 1 + 2 i k, that of 1 / (1 + i k - i k cos t) gives -4 Im 1 / (s (s + 1)^2), s = p + i q, which is
    /// 2 q / (p^2 (2 p^2 - 1)), free of cancellation.
    fn mean_weakening(&self, belt_speed: f64) -> f64 {
        let k = self.rate * belt_speed;
        let square = 1.0_f64.hypot(2.0 * k);
        let p = (0.5 * (1.0 + square)).sqrt();
        2.0 * self.drop * self.rate * (k / square) / (p * p * p) - self.eta
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn very_fast_slip_does_not_overflow() {
        let law = Lorentzian::new(&LawParameters::new(&[0.4, 1e-200, 0.0]));
        assert_eq!(law.phi(1.0), 0.4);
        assert_eq!(law.weakening(1.0), 0.0);
    }
}

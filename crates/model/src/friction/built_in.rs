//! What the file of a built-in law defines: the law, and its curves in closed form.

use super::family::Series;
use super::{FirstOrder, Gradient, Parameter, Range};
use crate::point::LawParameters;

/// [`super::Curve::onset`] in units of the slip speed over which a law falls. By choice, not measured: over this share of
/// it an exponential falls by an eighth, which the first step of an integrator sees.
pub(super) const ONSET: f64 = 0.125;

/// Bounds over [`lo`, `hi`] of a weakening rate that rises up to its maximum, at the slip speed `peak`, and falls from
/// there, by its bounds at one slip speed. A rounded `peak` has less than the maximum by the square of its rounding, which
/// these exceed.
pub(super) fn range_about_peak(bounds: impl Fn(f64) -> Range, peak: f64, lo: f64, hi: f64) -> Range {
    let ends = bounds(lo).hull(bounds(hi));
    if lo < peak && peak < hi { ends.hull(bounds(peak)) } else { ends }
}

/// More than what is lost where numbers are below the normal ones, each less than 5e-324, times the 750 that stand before an
/// exponential there.
const UNDERFLOW: f64 = 1e-10 * f64::MIN_POSITIVE;

/// Bounds of `fall` - `rise`, as computed of a law with a fall that is wrong by at most `roundings` units in the last place,
/// each 2^-52 of it, and a rise that is wrong by at most two: with the difference, and underflow, in units of `size`.
pub(super) fn rounded(fall: f64, roundings: f64, rise: f64, size: f64) -> Range {
    let value = fall - rise;
    // Products with a factor of zero are exact.
    if size == 0.0 && rise == 0.0 {
        return Range { lo: value, hi: value };
    }
    let by = f64::EPSILON * (roundings * fall.abs() + 2.0 * rise.abs()) + UNDERFLOW * (1.0 + size);
    Range { lo: value, hi: value }.widened(by)
}

/// A built-in law, defined in its own file.
pub struct BuiltIn {
    /// Name in configurations.
    pub(super) name: &'static str,
    /// phi(u) as a formula, see [`super::Expression`].
    pub formula: &'static str,
    /// The coefficient of friction of a machine as a formula: in mu_s and mu_k, static and kinetic friction, v_s, the
    /// Stribeck velocity, eta, the strengthening, and delta, the exponent.
    pub of_coefficients: &'static str,
    /// Its parameters, in the order in which they become axes of a map.
    pub(super) parameters: &'static [Parameter],
    /// Returns whether phi(u) depends on eps.
    pub(super) depends_on_epsilon: bool,
    /// phi at slip speed u, eps and parameters, enclosed with its derivatives, for proofs over boxes of
    /// parameters; `None` if the number of parameters is not the law's.
    pub(super) phi_at: fn(u: Series, epsilon: Series, parameters: &[Series]) -> Option<Series>,
    /// How friction rises at high slip speed.
    pub strengthening: Strengthening,
    /// The parameters of a machine's friction, for slip speeds in units of `velocity`, in m/s: those of a
    /// built-in law follow from the coefficients of [`Fall`].
    pub parameters_of: fn(friction: &Fall, velocity: f64) -> LawParameters,
}

/// How the friction of a built-in law rises at high slip speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Strengthening {
    /// In proportion to the slip speed, as viscous damping does.
    Linear,
    /// In proportion to its square.
    Quadratic,
}

/// Friction in units of that at rest, as a machine has it: it falls, and rises at high slip speed.
pub struct Fall {
    /// Kinetic friction.
    pub kinetic: f64,
    /// Slip speed over which friction falls, m/s.
    pub width: f64,
    /// Strengthening at high slip speed, per m/s or per (m/s)^2, see [`BuiltIn::strengthening`].
    pub strengthening: f64,
    /// Exponent of the fall, for the law that has it as a parameter.
    pub exponent: f64,
}

/// A built-in law with all parameters fixed. Its friction, weakening rate and formula are called in inner
/// loops, and so by the matches of `Form`.
pub(super) trait ClosedForm {
    /// Returns whether no coefficient of the law is a product below the normal numbers, where it may be wrong
    /// by any factor.
    fn is_normal(&self) -> bool;

    /// Derivatives of the weakening rate.
    fn gradient(&self, u: f64) -> Gradient;

    /// See [`super::Curve::mean_weakening`].
    fn mean_weakening(&self, belt_speed: f64) -> f64;

    /// Cost of one evaluation in units of the cost of the Stribeck law.
    fn cost(&self) -> u64 {
        1
    }

    /// See [`super::Curve::weakening_is_convex`].
    fn weakening_is_convex(&self) -> bool {
        false
    }

    /// See [`super::Curve::has_known_features`]; then the law is one analytic function, too.
    fn has_known_features(&self) -> bool {
        true
    }

    /// See [`super::Curve::onset`].
    fn onset(&self) -> f64;

    /// Bounds of phi on [0, hi]; `None` if they come from the formula in interval arithmetic.
    fn friction_range(&self, _hi: f64) -> Option<Range> {
        None
    }

    /// See [`super::Curve::even_weakening_range`]; `None` if the bounds come from the compiled law.
    fn even_weakening_range(&self, _belt_speed: f64) -> Option<Range> {
        None
    }

    /// The first order in eps; `None` for a law that does not depend on eps.
    fn first_order(&self, _belt_speed: f64) -> Option<FirstOrder> {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Law, Range};
    use crate::point::LawParameters;

    /// The claim is that of the weakening rate at equally spaced slip speeds.
    #[test]
    fn convexity_is_claimed_of_the_laws_that_have_it() {
        for (law, parameters) in [
            (Law::Stribeck, [0.3, 0.1, 2.0]),
            (Law::Exponential, [0.4, 0.5, 0.1]),
            (Law::Lorentzian, [0.4, 0.5, 0.1]),
        ] {
            let curve = law.curve(0.5, &LawParameters::new(&parameters));
            let rates: Vec<f64> = (0..60).map(|i| curve.weakening(0.05 * f64::from(i))).collect();
            let falls = rates.windows(2).all(|pair| pair[1] <= pair[0]);
            let is_convex = rates.windows(3).all(|three| three[0] + three[2] >= 2.0 * three[1]);
            assert_eq!(curve.weakening_is_convex(), falls && is_convex, "{law:?}");
        }
    }

    /// At one slip speed the bounds hold the exact value, which lies between these neighbouring numbers: from 40 digits.
    #[test]
    fn bounds_are_rounded_outwards() {
        let holds = |range: Range, [below, above]: [f64; 2]| {
            assert!(range.lo <= below && above <= range.hi, "{range:?} {below} {above}");
            assert!(range.hi - range.lo <= 100.0 * f64::EPSILON * (1.0 + above.abs()), "{range:?}");
        };
        for (law, parameters, u, exact) in [
            (Law::Stribeck, &[0.3, 0.1, 2.0][..], 0.7, [0.172_214_532_871_972_33, 0.172_214_532_871_972_36]),
            (
                Law::Exponential,
                &[0.4, 0.1, 0.02],
                0.7,
                [-0.014_528_708_206_672_9, -0.014_528_708_206_672_899],
            ),
            (Law::Stretched, &[0.4, 0.3, 0.02, 7.0], 0.2, [1.139_210_323_273_748_5, 1.139_210_323_273_748_7]),
            (
                Law::Stretched,
                &[0.4, 0.3, 0.02, 1.5],
                0.7,
                [0.109_773_543_362_877_95, 0.109_773_543_362_877_96],
            ),
            (Law::Lorentzian, &[0.4, 0.3, 0.02], 0.7, [0.204_732_461_355_529_14, 0.204_732_461_355_529_17]),
        ] {
            let curve = law.curve(0.5, &LawParameters::new(parameters));
            holds(curve.weakening_range(u, u), exact);
            assert!(curve.ranges(u).highest(u, u) >= exact[1]);
            let even = curve.even_weakening_range(u);
            match law {
                Law::Stribeck => {
                    holds(Range { hi: even.lo + 1e-15, ..even }, exact);
                    assert!(even.hi >= 0.340_763_888_888_888_9, "{even:?}");
                }
                Law::Exponential => {
                    holds(Range { hi: even.lo + 1e-15, ..even }, exact);
                    assert!(even.hi >= 2.980_002_494_586_157, "{even:?}");
                }
                _ => {}
            }
        }
    }
}

//! The bifurcations of codimension one, each as a test function that changes its sign there, and their curves
//! in any plane of two parameters.
//!
//! | bifurcation | test function | what happens |
//! | --- | --- | --- |
//! | Hopf | D(V), the trace at the equilibrium | the equilibrium changes its stability, a slip cycle is born |
//! | grazing-sliding | the scaled margin m / V | the orbit from the exit point comes back to the belt line, or not |
//! | landing | `crossing::reach` less 2; with a drop j the landing speed less 2 - j | it lands on the stick segment, or beyond and crosses |
//! | crossing | `crossing::reach` less 2 (2 - j) | it sticks after one crossing, or crosses for ever |
//! | fold | C - eps c at the extreme of the backbone C(r) that is nearest to eps c | two slip cycles meet and vanish |

use std::f64::consts::PI;

use super::Failure;
use super::backbone::Backbone;
use super::continuation::{Branch, TestValue, zero_curves};
use super::crossing::{beyond_landing, reach};
use super::critical::{CriticalDamping, critical_damping};
use super::return_map::{Turn, turn_of};
use slipmap_model::filippov::{HopfRate, Oscillator};
use slipmap_model::friction::Column;
use slipmap_numbers::named;

/// Factor from the tolerance to a coarser one: the difference of the two values is taken as the error.
const COARSER: f64 = 100.0;

named! {
    /// A bifurcation of codimension one, with its name in tables.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Bifurcation {
        /// The trace of the linearisation at the equilibrium vanishes.
        Hopf => "hopf",
        /// The orbit from the exit point grazes the belt line.
        GrazingSliding => "grazing_sliding",
        /// The orbit from the exit point comes back to the far end of the stick segment.
        Landing => "landing",
        /// The orbit from the exit point, having crossed the belt line, comes back through the exit point.
        Crossing => "crossing",
        /// Two slip cycles meet and vanish.
        Fold => "fold",
    }
}

impl Bifurcation {
    /// The test function, with an accuracy of about `tolerance`; `None` where it is undefined or unknown.
    pub fn test(self, oscillator: &Oscillator, tolerance: f64) -> Option<TestValue> {
        let fastest = oscillator.fastest_sticking();
        match self {
            Bifurcation::Hopf => {
                let value = oscillator.divergence(oscillator.belt_speed);
                // D(V), up to the rounding of the difference.
                let error = 4.0 * f64::EPSILON * (value.abs() + oscillator.viscous.abs());
                let rate = HopfRate::new(&oscillator.curve, oscillator.belt_speed).value();
                // A damping that is not distinguishable from 0 is no curve.
                (rate != 0.0).then_some(TestValue { value, error })
            }
            Bifurcation::GrazingSliding => margin(oscillator, tolerance),
            // With a drop the reach jumps at the landing.
            Bifurcation::Landing if oscillator.drop() > 0.0 => with_error(tolerance, |tolerance| {
                let beyond = beyond_landing(oscillator, tolerance)?;
                Ok(beyond.unwrap_or(-oscillator.fastest_sticking()))
            }),
            Bifurcation::Landing => {
                with_error(tolerance, |tolerance| Ok(reach(oscillator, 0.0, tolerance)? - fastest))
            }
            Bifurcation::Crossing => {
                with_error(tolerance, |tolerance| Ok(reach(oscillator, 0.0, tolerance)? - 2.0 * fastest))
            }
            // There is at most one slip cycle (see `weakening_is_convex`), so none can meet.
            Bifurcation::Fold if oscillator.curve.weakening_is_convex() => None,
            // For planes without the damping; in planes with it the extremes are followed (`folds`).
            Bifurcation::Fold => {
                let backbone =
                    Backbone::of_curve(&oscillator.curve, oscillator.belt_speed, tolerance).ok()?;
                let excess = backbone.folds().iter().map(|fold| fold.viscous - oscillator.viscous);
                let value = excess.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
                Some(TestValue { value, error: backbone.error })
            }
        }
    }

    /// The curves in a plane of two parameters. `at` maps a point of the unit square to the oscillator there
    /// and is never evaluated outside; points and errors of the curves are in sides of the square.
    #[must_use]
    pub fn curves(self, at: &(dyn Fn([f64; 2]) -> Oscillator + Sync), tolerance: f64) -> Vec<Branch> {
        zero_curves(&|place| self.test(&at(place), tolerance))
    }
}

/// A test function, with its difference from that at a coarser tolerance as the error.
fn with_error(tolerance: f64, value: impl Fn(f64) -> Result<f64, Failure>) -> Option<TestValue> {
    let (fine, coarse) = (value(tolerance).ok()?, value(COARSER * tolerance).ok()?);
    Some(TestValue { value: fine, error: (fine - coarse).abs() + 4.0 * f64::EPSILON })
}

/// The scaled margin; where the turn leaves the domain of the polar form, about what the distance from the critical damping
/// makes of it, which has a margin's zero and sign.
fn margin(oscillator: &Oscillator, tolerance: f64) -> Option<TestValue> {
    if let Turn::Complete { margin, error, .. } = turn_of(oscillator, tolerance) {
        return Some(TestValue { value: margin, error });
    }
    let Oscillator { curve, viscous, belt_speed } = oscillator;
    let column = Column { curve: curve.clone(), epsilon: 1.0, belt_speed: *belt_speed, unit: 1.0 };
    let critical = critical_damping(&column, tolerance).and_then(CriticalDamping::known).ok()?;
    // Of a negative one perhaps only the sign is known.
    let error = if critical.is_located() { critical.error } else { 0.0 };
    Some(TestValue { value: PI * (critical.c - viscous), error: PI * error })
}

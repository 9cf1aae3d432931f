//! The bifurcations of codimension one, each as a test function that changes its sign there, and their curves
//! in any plane of two parameters.
//!
//! | bifurcation | test function | what happens |
//! | --- | --- | --- |
//! | Hopf | D(V), the trace at the equilibrium | the equilibrium changes its stability, a slip cycle is born |
//! | grazing-sliding | the scaled margin m / V | the orbit from the exit point comes back to the belt line, or not |
//! | landing | wL - 2, wL the landing speed x2' | it lands on the stick segment, or beyond and crosses |
//! | crossing | y', where it crosses down again beyond E | it sticks after one crossing, or crosses for ever |
//! | fold | C - eps c at the extreme of the backbone C(r) that is nearest to eps c | two slip cycles meet and vanish |

use super::backbone::Backbone;
use super::continuation::{Branch, TestValue, zero_curves};
use super::crossing::{landing_speed, second_crossing};
use super::return_map::{Turn, turn_of};
use super::{Failure, flow};
use crate::filippov::Oscillator;
use crate::named::named;

/// Length of the stick segment, twice the static friction: the landing speed at which it is missed.
const SEGMENT: f64 = 2.0;
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
    pub(crate) fn test(self, oscillator: &Oscillator, tolerance: f64) -> Option<TestValue> {
        match self {
            Bifurcation::Hopf => {
                let value = oscillator.divergence(oscillator.belt_speed);
                // D(V), up to the rounding of the difference.
                let error = 4.0 * f64::EPSILON * (value.abs() + oscillator.viscous.abs());
                Some(TestValue { value, error })
            }
            Bifurcation::GrazingSliding => margin(oscillator, tolerance),
            Bifurcation::Landing => twice(tolerance, |tolerance| {
                // An orbit that stays below the belt line counts as one that grazes it, with landing speed
                // zero.
                Ok(Some(landing_speed(oscillator, tolerance)?.unwrap_or(0.0) - SEGMENT))
            }),
            Bifurcation::Crossing => twice(tolerance, |tolerance| second_crossing(oscillator, tolerance)),
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

/// A value, with its difference from that at a coarser tolerance as the error.
fn twice(tolerance: f64, value: impl Fn(f64) -> Result<Option<f64>, Failure>) -> Option<TestValue> {
    let fine = value(tolerance).ok()??;
    let coarse = value(COARSER * tolerance).ok()??;
    Some(TestValue { value: fine, error: (fine - coarse).abs() + 4.0 * f64::EPSILON })
}

/// The scaled margin; far from grazing perhaps only its sign.
fn margin(oscillator: &Oscillator, tolerance: f64) -> Option<TestValue> {
    if let Turn::Complete { margin, error, .. } = turn_of(oscillator, tolerance) {
        return Some(TestValue { value: margin, error });
    }
    let answer = flow(oscillator, tolerance);
    Some(TestValue { value: answer.signed_margin()?, error: answer.margin_error })
}

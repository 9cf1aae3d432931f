//! Columns of any friction law: what is proved of their turns and landings.

use super::interval::Interval;
use super::landing_speed::{Divergence, Flow};
use super::turn::{Resists, critical};
use super::{Claim, CriticalEnclosure, sticks_from};
use crate::friction::Column;

/// What is proved of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// C* = eps c*, enclosed; infinite where nothing bounds it.
    pub critical: CriticalEnclosure,
    /// The damping c from which on the landing is proved; infinity if none is.
    pub sticks_from: f64,
    /// Why C* is not known better, if something kept it from being so.
    pub resists: Option<Resists>,
}

/// Proves what can be proved of a column, by its compiled law.
#[must_use]
pub fn prove(column: &Column) -> Proof {
    let (law, belt_speed) = (column.compiled(), column.belt_speed);
    // The theorem of the even part, for any law.
    let even = law.even_range(belt_speed, belt_speed);
    let (bounds, resists) = match even.hi < 0.0 {
        // Where no legal damping is small enough for a cycle, nobody needs to know C*.
        true => ([even.lo, even.hi], None),
        false => critical(&law, belt_speed, [even.lo, even.hi]),
    };
    let [lo, hi] = bounds;
    let epsilon = Interval::of(column.epsilon);
    let flow = |c: f64| Flow {
        divergence: Divergence::Compiled(&law),
        viscous: epsilon * Interval::of(c),
        belt_speed: Interval::of(belt_speed),
    };
    let below = if lo.is_finite() { Interval::of(lo).over(epsilon).lo } else { f64::NEG_INFINITY };
    let sticks_from = if below > 0.0 { sticks_from(&|c| flow(c).lands(), below) } else { 0.0 };
    Proof { critical: CriticalEnclosure { lo, hi }, sticks_from, resists }
}

/// The claim of a column.
pub(super) fn claim(column: &Column) -> Claim {
    // Coefficients below the normal numbers have lost digits that the enclosure does not know of.
    if !column.curve.is_normal() {
        return Claim::NOTHING;
    }
    let Proof { critical: CriticalEnclosure { lo, hi }, sticks_from, .. } = prove(column);
    let epsilon = Interval::of(column.epsilon);
    if !lo.is_finite() && !hi.is_finite() {
        return Claim::NOTHING;
    }
    // What is not bounded is not claimed.
    let present_below = if lo.is_finite() { Interval::of(lo).over(epsilon).lo } else { f64::NEG_INFINITY };
    let absent_above = if hi.is_finite() { Interval::of(hi).over(epsilon).hi } else { f64::INFINITY };
    Claim { sticks_from, present_below, absent_above }
}

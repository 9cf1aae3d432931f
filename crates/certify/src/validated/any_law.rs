//! Proofs for columns of any friction law: enclosures of the critical damping and of the landing.

use super::turn::{Obstacle, critical};
use super::{Claim, claim_of};
use crate::drop::fastest;
use crate::landing::Flow;
use slipmap_model::friction::{Column, Range};
use slipmap_numbers::interval::Interval;
use std::cell::LazyCell;

/// The proved statements about a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Proof {
    /// Enclosure of C* = eps c*; an end is infinite where no bound is proved.
    pub critical: Range,
    /// The reason why the enclosure of C* is not sharp, if it is not.
    pub obstacle: Option<Obstacle>,
}

/// Computes the proofs of a column from its compiled law.
#[must_use]
pub fn prove(column: &Column) -> Proof {
    let (drop, belt_speed) = (column.curve.drop(), column.belt_speed);
    // The compiled law, up to the slip speeds of orbits near the critical one.
    let reach = if drop > 0.0 { 1.5 * fastest(column) } else { 0.0 };
    let law = column.curve.compiled((4.0 * belt_speed).max(reach));
    // The theorem of the even part, for any law.
    let even = law.even_range(belt_speed, belt_speed);
    let known = match drop > 0.0 {
        // With D <= -2 at all slip speeds that an orbit whose radius falls can reach, none returns.
        true => [even.lo, (Interval::of(law.range(0.0, fastest(column)).hi) + Interval::of(2.0)).hi],
        false => [even.lo, even.hi],
    };
    let (bounds, obstacle) = match known[1] < 0.0 {
        // No legal damping is small enough for a cycle, so a sharper enclosure is not needed.
        true => (known, None),
        false => critical(&law, belt_speed, drop, known),
    };
    let [lo, hi] = bounds;
    Proof { critical: Range { lo, hi }, obstacle }
}

pub(super) fn claim(column: &Column) -> Claim {
    // Coefficients below the normal numbers have lost digits that the enclosure does not account for.
    if !column.curve.is_normal() {
        return Claim::NOTHING;
    }
    let Range { lo, hi } = prove(column).critical;
    let [epsilon, belt_speed] = [column.epsilon, column.belt_speed].map(Interval::of);
    // An orbit that lands slowly enough swings no farther than sqrt(4 + V^2), unless damping slows it, and bounds of it
    // reach twice as far.
    let reach = column.belt_speed + 2.0 * column.belt_speed.hypot(2.0);
    let law = LazyCell::new(|| column.curve.compiled(reach.max(4.0 * column.belt_speed)));
    let highest = |least: Interval, most: Interval| {
        law.range((belt_speed * least).lo.max(0.0), (belt_speed * most).hi).hi
    };
    let flow = |c: f64| Flow::new(belt_speed, column.curve.drop(), epsilon * Interval::of(c), &highest);
    claim_of(Interval::new(lo, hi).over(epsilon), &|c| flow(c).lands())
}

//! Proofs for columns of any friction law: enclosures of the critical damping and of the landing.

use super::landing_speed::{Divergence, Flow};
use super::turn::{Obstacle, critical};
use super::{Claim, claim_of};
use slipmap_model::friction::{Column, Range};
use slipmap_numbers::interval::Interval;

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
    let (law, belt_speed) = (column.compiled(), column.belt_speed);
    // The theorem of the even part, for any law.
    let even = law.even_range(belt_speed, belt_speed);
    let (bounds, obstacle) = match even.hi < 0.0 {
        // No legal damping is small enough for a cycle, so a sharper enclosure is not needed.
        true => ([even.lo, even.hi], None),
        false => critical(&law, belt_speed, [even.lo, even.hi]),
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
    let (law, epsilon) = (column.compiled(), Interval::of(column.epsilon));
    let flow = |c: f64| Flow {
        divergence: Divergence::Compiled(&law),
        viscous: epsilon * Interval::of(c),
        belt_speed: Interval::of(column.belt_speed),
    };
    claim_of(Interval::new(lo, hi).over(epsilon), &|c| flow(c).lands())
}

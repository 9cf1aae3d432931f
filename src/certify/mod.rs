//! Closed-form tests for stick-slip limit cycles, one file each, and the table of them.
//!
//! Every test answers the same question, "does the orbit that leaves the belt at the exit point stick
//! again?", and every one of them turns into thresholds along the damping axis: a [`Claim`] per
//! [`Column`]. This module knows nothing of `simulate`: the agreement of the two is evidence only while
//! they are independent.

use crate::friction::Column;

/// What a test says of one point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// A stick-slip limit cycle exists.
    Present,
    /// None exists.
    Absent,
    /// The test does not apply here, or does not decide.
    Undecided,
}

/// What a test says along a whole column: presence for c in [`sticks_from`, `present_below`), absence for
/// c > `absent_above`, nothing elsewhere. Infinite thresholds mean "never" or "no limit".
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Claim {
    /// Presence is claimed only from this damping up: below it the orbit may land beyond the stick
    /// segment. Negative infinity for the asymptotic tests, which ignore the landing.
    pub sticks_from: f64,
    /// The test's critical damping: edge of the claim of presence. Negative infinity if it claims none.
    pub present_below: f64,
    /// Edge of the claim of absence. Infinity if it claims none.
    pub absent_above: f64,
}

impl Claim {
    /// No claim anywhere.
    pub const NOTHING: Claim = Claim {
        sticks_from: f64::NEG_INFINITY,
        present_below: f64::NEG_INFINITY,
        absent_above: f64::INFINITY,
    };

    /// What the test says at damping `c`.
    #[must_use]
    pub fn decide(&self, c: f64) -> Decision {
        if c > self.absent_above {
            Decision::Absent
        } else if c < self.present_below && c >= self.sticks_from {
            Decision::Present
        } else {
            Decision::Undecided
        }
    }

    /// Signed distance in c to the edge of the claim of presence: positive below it, negative above.
    /// Negative infinity if the test claims no presence in this column.
    #[must_use]
    pub fn margin(&self, c: f64) -> f64 {
        self.present_below - c
    }
}

/// How far a verdict can be trusted.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guarantee {
    /// True in the limit eps -> 0; may be wrong at any given eps.
    Asymptotic,
    /// A theorem at every eps > 0, evaluated in double precision.
    FiniteEpsilon,
    /// Numerical integration with an error estimate.
    Numerical,
    /// A theorem including round-off.
    Validated,
    /// No claim of correctness: a method that is here to be measured.
    None,
}

impl Guarantee {
    /// The word stored in map files.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Guarantee::Asymptotic => "asymptotic",
            Guarantee::FiniteEpsilon => "finite_epsilon",
            Guarantee::Numerical => "numerical",
            Guarantee::Validated => "validated",
            Guarantee::None => "none",
        }
    }
}

/// A closed-form test.
#[derive(Clone, Copy, Debug)]
pub struct Test {
    /// Name in configurations and map files.
    pub name: &'static str,
    /// One phrase for legends and `long_name`.
    pub long_name: &'static str,
    /// Where the condition stands in the paper or in the crate's theory pages.
    pub equation: &'static str,
    /// What a verdict is worth.
    pub guarantee: Guarantee,
    /// The claim along a column.
    pub claim: fn(&Column) -> Claim,
}

/// Every closed-form test, in the order in which maps and tables list them.
pub static TESTS: [Test; 0] = [];

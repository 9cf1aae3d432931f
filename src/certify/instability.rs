//! The divergence at the equilibrium, D(V) > 0, with the condition that makes it a certificate.
//!
//! ```text
//! present if  eps c < weakening(V)  and  eps c < min over 0 < |v| <= V of E(v),  the landing speed below 2
//! ```
//!
//! The first inequality is the paper's (14), gamma (1 - alpha) / (1 + eps gamma V)^2 - 2 beta V > c for
//! the Stribeck law: the equilibrium is unstable. E is the even part in v of weakening(V - v).
//!
//! **Domain**: every law. **Guarantee**: a theorem at every eps > 0, evaluated in double precision. **Why the
//! second inequality.** By itself (14) proves nothing about the orbit from the exit point: a stable slip
//! cycle may surround the equilibrium and attract that orbit. E is weakening(V) at v = 0, and
//! [`super::symmetric`] proves presence where its minimum exceeds eps c. If the minimum is at v = 0, as for
//! the Stribeck law, whose E is convex, the second inequality is implied by the first and (14) *is* a
//! certificate. For a law with its minimum elsewhere the claim shrinks to what is proved, and coincides with
//! that of `symmetric`. Absence is not claimed: between this edge and the critical damping the equilibrium is
//! stable and the stick-slip cycle exists. The landing is checked, see [`super::landing`].
//!
//! Departures from the paper: there (14) is a remark, followed by Bendixson's criterion to exclude slip
//! cycles; the second inequality and the landing are not in it.

use super::{Claim, Guarantee, Test, landing, presence_edge};
use crate::friction::Column;

/// The test.
pub const TEST: Test = Test {
    name: "instability",
    long_name: "divergence at the equilibrium",
    equation: "paper (14)",
    guarantee: Guarantee::FiniteEpsilon,
    first_order: false,
    claim,
    claims: None,
};

fn claim(column: &Column) -> Claim {
    let at_equilibrium = column.curve.weakening(column.belt_speed);
    let proved = column.curve.even_weakening_range(column.belt_speed).lo;
    let present_below = presence_edge(column, at_equilibrium.min(proved));
    Claim { sticks_from: landing::sticks_from(column, present_below), present_below, ..Claim::NOTHING }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::certify::symmetric;
    use crate::certify::test_columns::{random_columns, stribeck};

    #[test]
    fn edge_by_hand() {
        // k = 4: 1/25 - 2 beta V = 1/25 - 1/32; a few roundings.
        let claim = (TEST.claim)(&stribeck(1.0, 0.5, 0.0078125, 2.0, 2.0));
        assert!((claim.present_below - (0.04 - 0.03125)).abs() <= 4.0 * f64::EPSILON * 0.04);
        assert_eq!(claim.absent_above, f64::INFINITY);
    }

    #[test]
    fn is_the_presence_claim_of_symmetric_for_the_stribeck_law() {
        for column in random_columns(500) {
            let (here, there) = ((TEST.claim)(&column), (symmetric::TEST.claim)(&column));
            assert_eq!(here.present_below, there.present_below);
            assert_eq!(here.sticks_from, there.sticks_from);
        }
    }
}

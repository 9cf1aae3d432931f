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
//! cycle may surround the equilibrium and attract that orbit. [`super::symmetric`] proves presence where the
//! minimum of E exceeds eps c; and E is weakening(V) at v = 0, so that the second inequality implies the
//! first. The claim is therefore the presence that `symmetric` claims. If the minimum is at v = 0, as for the
//! Stribeck law, whose E is convex, the two inequalities are one and (14) *is* a certificate. Absence is not
//! claimed: between this edge and the critical damping the equilibrium is stable and the stick-slip cycle
//! exists. The landing is checked, see [`super::landing`].
//!
//! Departures from the paper: there (14) is a remark, followed by Bendixson's criterion to exclude slip
//! cycles; the second inequality and the landing are not in it.

use super::{Claim, Guarantee, Test, symmetric};

/// The test.
pub const TEST: Test = Test {
    name: "instability",
    long_name: "divergence at the equilibrium",
    equation: "paper (14)",
    guarantee: Guarantee::FiniteEpsilon,
    first_order: false,
    claims: |columns| symmetric::TEST.claims(columns).into_iter().map(presence_of).collect(),
};

fn presence_of(symmetric: Claim) -> Claim {
    Claim { absent_above: Claim::NOTHING.absent_above, ..symmetric }
}

//! Bendixson's criterion to first order in eps, as the paper sketches it.
//!
//! ```text
//! present if  c < min over u in [0, 2 V] of -F1'(u)
//! ```
//!
//! which for the Stribeck law is gamma (1 - alpha) - 4 beta V (paper, section 5.1: the divergence along the
//! orbit, with x2 >= -V).
//!
//! **Domain**: laws with an expansion in eps and without a drop as slip begins, which is no small change at
//! small eps; none is claimed for others. **Guarantee**: asymptotic. At
//! finite eps the weakening is smaller at u = 2 V and the orbit overshoots -V, so the claim may be wrong;
//! [`super::bendixson`] makes the same idea rigorous. The landing is not checked, as in
//! [`super::perturbation`]. **Idea**: there is no closed orbit along and inside which the divergence is
//! positive, so nothing keeps an orbit from the exit point, which spirals away from the equilibrium, below
//! the belt line.
//!
//! Departures from the paper: none in the formula. The paper takes the inequality along the supposed
//! cycle; the bound x2 >= -V on that cycle is what makes it a formula.

use super::{Claim, Guarantee, Test};
use slipmap_model::friction::Column;

/// The test.
pub const TEST: Test = Test {
    name: "bendixson_leading",
    long_name: "Bendixson criterion at first order",
    equation: "paper section 5.1, first order",
    guarantee: Guarantee::Asymptotic,
    first_order: true,
    claims: |columns| columns.iter().map(claim).collect(),
};

fn claim(column: &Column) -> Claim {
    let Ok(first_order) = column.first_order() else { return Claim::NOTHING };
    Claim { present_below: first_order.weakening_range.lo, ..Claim::NOTHING }
}

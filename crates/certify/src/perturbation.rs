//! The paper's new test: the first-order energy balance.
//!
//! ```text
//! present if  c < 1 / (pi V) * integral over [0, 2 pi] of F1(V - V cos t) cos t dt      paper (6)
//! absent  if  c > the same
//! ```
//!
//! where phi(u) = 1 + eps F1(u) + O(eps^2); for the Stribeck law the right side is gamma (1 - alpha) - 2
//! beta V, the paper's (12).
//!
//! **Domain**: laws with an expansion in eps and without a drop as slip begins, which is no small change at
//! small eps; none is claimed for others. **Guarantee**: asymptotic. At a
//! fixed c off the edge the verdict is right for all sufficiently small eps (presence: the paper's
//! Proposition 2; absence: its conclusion). At finite eps the edge is too high: the exact critical damping of
//! the Stribeck law is smaller by 2 eps gamma^2 (1 - alpha) V + O(eps^2), and in that band the test claims
//! cycles that do not exist. The landing is not checked, since the landing speed is O(sqrt(eps)). **Idea**:
//! work done by friction and damping on the circle x2 = V cos t, which is the orbit at eps = 0.
//!
//! Departures from the paper: its section 5 expands the law in the signed argument x2 - V < 0 and once writes
//! lambda for alpha; the inequality that results is the same.

use super::{Claim, Guarantee, Test};
use slipmap_model::friction::Column;

/// The test.
pub const TEST: Test = Test {
    name: "perturbation",
    long_name: "first-order perturbation test",
    equation: "paper (12), for any law (6)",
    guarantee: Guarantee::Asymptotic,
    first_order: true,
    claims: |columns| columns.iter().map(claim).collect(),
};

fn claim(column: &Column) -> Claim {
    let Ok(first_order) = column.first_order() else { return Claim::NOTHING };
    let (edge, error) = (first_order.mean_weakening, first_order.mean_error);
    if edge.is_nan() {
        return Claim::NOTHING;
    }
    Claim { present_below: edge - error, absent_above: edge + error, ..Claim::NOTHING }
}

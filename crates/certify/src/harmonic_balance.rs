//! Energy balance on the grazing circle, without expanding the law in eps.
//!
//! ```text
//! present if  eps c < M,   absent if  eps c > M,
//! M = (1 / pi) * integral over [0, 2 pi] of weakening(V - V cos t) sin^2 t dt
//! ```
//!
//! which is the paper's (6) with (phi - 1) / eps in place of its derivative at eps = 0, integrated by
//! parts. For the Stribeck law, with k = eps gamma V and q = sqrt(1 + 2 k),
//!
//! ```text
//! M = 2 eps gamma (1 - alpha) / (q (1 + k + q)) - 2 eps beta V.
//! ```
//!
//! **Domain**: every law. **Guarantee**: asymptotic. For the Stribeck law the edge differs from the exact
//! critical damping by O(eps^4). The edge lies above the critical damping for k < 15.62 wherever it was
//! tried, but below it for weak laws of larger k with little strengthening: at eps = alpha = 0.5, beta = 0,
//! gamma = V = 8 this test denies a cycle that exists. The landing is not checked, as in
//! [`super::perturbation`]. **Idea**: the circle x2 = V cos t is the orbit at eps = 0; the work done along it
//! by the full law, not by its linear part, decides whether the orbit gains or loses energy.
//!
//! **With a drop** j of friction as slip begins ln(1 + j^2/V^2) / (2 pi) is added to M: the orbit starts at the
//! distance hypot(V, j) from the equilibrium, not V. That is first order in the weakening and in j^2/V^2.
//!
//! Departures from the paper: this test is not in it.

use super::{Claim, Guarantee, Test, absence_edge, presence_edge};
use slipmap_model::friction::Column;

/// The test.
pub const TEST: Test = Test {
    name: "harmonic_balance",
    long_name: "harmonic balance on the grazing circle",
    equation: "paper (6) without expansion in eps",
    guarantee: Guarantee::Asymptotic,
    first_order: false,
    claims: |columns| columns.iter().map(claim).collect(),
};

fn claim(column: &Column) -> Claim {
    let [mut mean, error] = column.curve.mean_weakening_with_error(column.belt_speed);
    let drop = column.curve.drop();
    if drop > 0.0 {
        mean += (drop / column.belt_speed).powi(2).ln_1p() / std::f64::consts::TAU;
    }
    Claim {
        present_below: presence_edge(column, mean - error),
        absent_above: absence_edge(column, mean + error),
        ..Claim::NOTHING
    }
}

//! Divergence split into its odd and even parts: rigorous at every eps, in closed form.
//!
//! Write weakening(V - v) = O(v) + E(v), O odd and E even in v. Then
//!
//! ```text
//! present if  eps c < min over 0 < |v| <= V of E(v), and the landing speed is below 2
//! absent  if  eps c > max over 0 < |v| <= V of E(v)
//! ```
//!
//! For the Stribeck law, with A = eps gamma (1 - alpha), k = eps gamma V and b = eps beta V, the bounds are
//! A / (1 + k)^2 - 2 b, at v = 0, and (A / 2) (1 + 1 / (1 + 2 k)^2) - 2 b, at |v| = V.
//!
//! **Domain**: every law, foci and nodes alike. **Guarantee**: a theorem at every eps > 0, evaluated in
//! double precision.
//!
//! **Proof**, in the notation of [`super`]: D = O + E - eps c.
//!
//! *Reference orbit.* Let D~ = O, of which only |v| <= V matters. As a function of s, O is odd in each
//! half plane, and dp/ds = O - s/p is unchanged under s -> -s. From s = -V, p = 0 the reference p~ is
//! positive for s < 0, because -s/p dominates as p -> 0, and bounded, because O is; reflected, it is the
//! solution on s > 0. So it turns at s = V exactly, and does the same in the upper half plane: the
//! reference orbit closes on the exit point.
//!
//! *Presence.* Let E - eps c > 0. In the lower half plane D > D~ and both start at s = -V with p = 0, so
//! by the comparison lemma p > p~ up to s = V, and p > 0 there: the amplitude R exceeds V, or the orbit
//! never turns, which the bound on the landing speed rules out. In the upper half plane it passes s = -V
//! with p > 0 = p~, so p > p~ up to and at s = V: the orbit reaches the belt line with `wL` > 0. It sticks
//! if `wL` < 2, see [`super::landing`].
//!
//! *Absence.* Let E - eps c < 0. The same comparison with the roles exchanged: the orbit turns at R < V;
//! in the upper half plane p~ > 0 = p at s = -R, so that p < p~ as long as p lasts, and p vanishes at some
//! s in (0, V), short of the belt line. []
//!
//! **With a drop** of friction as slip begins presence stands: p > 0 = p~ at s = -V. Absence takes a larger
//! damping, see "Even part of the divergence" in the source of `certify::drop`.
//!
//! Departures from the paper: this test is not in it. Its presence edge for the Stribeck law is the
//! paper's (14), see [`super::instability`].

use super::{Claim, Guarantee, Test, absence_edge, drop, landing, presence_edge};
use slipmap_model::friction::Column;

/// The test.
pub const TEST: Test = Test {
    name: "symmetric",
    long_name: "sign of the even part of the divergence",
    equation: "not in the paper: even part of the divergence",
    guarantee: Guarantee::FiniteEpsilon,
    first_order: false,
    claims: |columns| (0..columns.len()).map(|number| columns.symmetric(number)).collect(),
};

pub(super) fn claim(column: &Column) -> Claim {
    let even = column.curve.even_weakening_range(column.belt_speed);
    let present_below = presence_edge(column, even.lo);
    let absent = if column.curve.drop() > 0.0 { drop::even_absence(column, even.hi) } else { even.hi };
    Claim {
        sticks_from: landing::sticks_from(column, present_below),
        present_below,
        absent_above: absence_edge(column, absent),
    }
}

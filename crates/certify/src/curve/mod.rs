//! A proof is a curve that orbits cross one way: one kind of proof for every law, steep or with a drop, of
//! foci and nodes.
//!
//! Below the belt line the flow is F = (v', y') = (y, -v + D y), D = w(u) - C, u = V - v, C = eps c. Let a
//! curve G be run clockwise; `S = cross(tangent, F) = v_s (-v + D y) - y_s y` is positive where orbits cross
//! it outwards, to its left, and negative where they cross it inwards. j is the drop of friction as slip
//! begins; the orbit leaves the line at E = (V, -j).
//!
//! **Lemma.** *Let G be continuous and piecewise C^1 in v <= V, begin at (V, y0), y0 <= 0, meet {y = 0, 0 <=
//! v < V} at its last point at most, and be a graph over v where both y < 0 and v >= 0. Let S have one strict
//! sign on it, at joins on both sides, and at jumps of w with the limit of the side from which G comes.*
//! - [`CurveKind::Returns`]: *S > 0, -j <= y0, last point (V, y1), y1 > 0. For every C' <= C the orbit from E
//!   comes back to the line or runs away.*
//! - [`CurveKind::Absent`]: *S < 0, y0 < -j (or y0 = -j < 0), last point (v1, 0), 0 < v1 < V. For no C' >= C it
//!   comes back.*
//! - [`CurveKind::Lands`]: *S < 0, y0 as before, last point (V, y1), 0 < y1 < 2 - j. For every C' >= C it stays
//!   bounded, and sticks if it comes back.*
//!
//! *Proof.* Close G along y = 0 to (V, 0), where it ends before, and along v = V, to a curve K. The ray from
//! a point of {y = 0, 0 <= v < V} (slightly above it, where y0 = 0) to the right meets K once only, on the
//! closing part, which runs down: there the winding number n of K is -1, and so it is just left of the
//! closing part; beyond the line it is 0. S is not zero, so tangents do not vanish, an orbit crosses G at
//! single times, and at a join both tangents lie on one side of F. Left of a curve n is larger by one than
//! right of it: along an orbit in v < V, n never falls if S > 0 and never rises if S < 0, whether or not G
//! meets itself.
//! (1) S > 0. If y0 > -j, E is joined to the points beyond the line without crossing K, since where y < 0 <=
//! v G is a graph and meets the line at its first point only; if y0 = -j the orbit leaves the corner to the
//! left of G. Either way n >= 0 from then on: the orbit does not meet {y = 0, 0 <= v < V}, tends to no
//! equilibrium, and does not pass {V} x (0, y1). As long as y < 0, v falls; dy/dv = D - v/y bounds y over
//! bounded v, so it runs away or meets y = 0 at v < 0. Then y > 0 and v rises until v = V.
//! (2) S < 0. The orbit enters left of the closing part, with n = -1 (with y0 = -j < 0 to the right of G;
//! with j = 0 it leaves E downwards and to the left). It then crosses G, and the parts {y = 0} and {v = V, y
//! < 0} of the closing part, towards smaller n only: it stays where n is not 0, which is bounded, and comes
//! to the line in {V} x (0, y1), if there is such a part, only. (Where G touches the line above that, n is 1
//! on the left of G, where the orbit is not.)
//! (3) Other dampings: by the comparison lemma of [`super`], with q = y^2/2 and m = V - v, `dq/dm = v + D
//! sqrt(2 q)` below and `dq/dv = -v + D sqrt(2 q)` above rise with D, so the orbit of a smaller damping stays
//! outside that of a larger one. []
//!
//! So presence on [C1, C2] is a curve that lands at C1 and one that returns at C2, and absence from C on is
//! one curve. Slip speeds of the orbits stay below the largest of the inward curve: a table need not reach
//! farther.
//!
//! **A curve** is a list of Bezier polynomials in (u, y), whose control points are doubles, exactly.
//! [`check`](OneWay::check) trusts nothing in it; how it was found (`find`) does not matter. **The law** is
//! the compiled one, with the proved error of each of its polynomials
//! (`slipmap_model::friction::Weakening::proved_pieces`) and the roundings of its coefficients.

mod boxes;
mod check;
mod column;
mod find;
mod follow;
mod region;

use serde::{Deserialize, Serialize};

use super::certificate::list::List;
use slipmap_model::friction::Column;
use slipmap_model::point::MAX_LAW_PARAMETERS;

pub use boxes::{BoxProof, Shares};
pub use check::Fault;
pub(crate) use column::claim;
pub use column::{Proof, Stop, prove};
pub(crate) use region::Region;

/// Largest degree of a piece.
pub const MOST_DEGREE: usize = 9;
/// Largest number of pieces of a curve.
pub const MOST_PIECES: usize = 1000;
/// Largest number of axes of a box: eps, the law's parameters, V.
pub const MOST_AXES: usize = MAX_LAW_PARAMETERS + 2;
/// Slip speeds up to which a law is asked for a belt speed V: an orbit that lands slowly enough swings no
/// farther than sqrt(4 + V^2), unless damping slows it; curves reach a little farther.
fn reach(column: &Column) -> f64 {
    let belt_speed = column.belt_speed;
    (4.0 * belt_speed).max(belt_speed + 2.0 * belt_speed.hypot(2.0))
}

/// What a curve proves.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum CurveKind {
    /// The orbit comes back or runs away, at its damping and all smaller ones.
    Returns,
    /// The orbit does not come back, at its damping and all larger ones.
    Absent,
    /// The orbit is bounded and sticks if it comes back, at its damping and all larger ones.
    Lands,
}

impl CurveKind {
    /// The sign of S.
    fn sign(self) -> f64 {
        if self == CurveKind::Returns { 1.0 } else { -1.0 }
    }
}

/// The control points (u, y) of a piece.
pub type Piece = List<[f64; 2], { MOST_DEGREE + 1 }>;

/// A curve with the claim that orbits cross it one way.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OneWay {
    /// What it proves.
    pub kind: CurveKind,
    /// The damping; over a box, that in its middle.
    pub c: f64,
    /// Its pieces, clockwise; over a box, those in its middle.
    pub pieces: List<Piece, MOST_PIECES>,
    /// What is added times z, which runs from -1 to 1 along each axis on which the box is wide.
    #[serde(default, skip_serializing_if = "is_empty")]
    pub along: List<Along, MOST_AXES>,
}

/// How a curve changes along an axis of a box.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Along {
    /// Its damping.
    pub c: f64,
    /// Its control points.
    pub pieces: List<Piece, MOST_PIECES>,
}

fn is_empty(list: &List<Along, MOST_AXES>) -> bool {
    list.is_empty()
}

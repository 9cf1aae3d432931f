//! Cycles that slip all the time below the belt line, and the boundaries of basins.
//!
//! The return map P takes a maximum r of x2, 0 < r < V, to the next one. Its fixed points are the slip
//! cycles; their Floquet multiplier is its slope there. At r = 0 its slope gives the stability of the
//! equilibrium, at r = V the sign of P(r) - r is that of the grazing margin. Where both the equilibrium and
//! the stick-slip cycle attract, an unstable slip cycle lies between them: the boundary of their basins.
//!
//! **Slope.** The flow stretches areas by exp(integral of D), and passes the section x2' = 0 at the rate
//! x2'' = -r. Hence P'(r) = (r / P(r)) exp(integral of D along the turn): no derivative of the friction
//! law is needed. At a fixed point the angles cancel.
//!
//! **Cycles that repel** are fixed points of the map backward in time: forward, a turn multiplies the
//! rounding error of the start by the multiplier.

use super::backbone::CycleRange;
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::Failure;
use slipmap_model::friction::Range;
use slipmap_numbers::roots::fixed_point;
use slipmap_orbits::arc::{Extent, LowerEnd, SlipTurn, State, Walk};
use slipmap_orbits::{Cycle, Piece, Work};

/// Largest relative error of a turn that is used for slip cycles: their amplitude is ill-conditioned where
/// the multiplier is close to 1.
pub const TIGHT: f64 = 1e-13;

/// Sudden changes of velocity that carry the mass from steady slip, at rest at the equilibrium, onto an
/// unstable slip cycle: a slightly larger one leads to the attractor that lies outside of it.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Kick {
    /// Along the belt's motion, > 0.
    pub forward: f64,
    /// Against it, as a positive number.
    pub backward: f64,
}

impl Kick {
    /// Both times a factor, as for other units.
    #[must_use]
    pub fn times(self, factor: f64) -> Self {
        Self { forward: factor * self.forward, backward: factor * self.backward }
    }
}

/// Returns whether a turn leads outward.
fn outward(from: f64, turn: &SlipTurn) -> bool {
    match turn {
        SlipTurn::Returns { radius, .. } => *radius > from,
        SlipTurn::MeetsBelt { .. } => true,
        SlipTurn::Rests => false,
    }
}

/// Returns whether it is proved that no slip cycle exists: where the even part E in v of weakening(V - v)
/// stays above eps c for 0 < |v| <= V, every turn below the belt line leads outward, and where it stays
/// below, inward.
///
/// **Proof.** That of the test `symmetric` with a start at any maximum r <= V of x2 in place of V: the bounds
/// on |v| <= V hold on |v| <= r. []
#[must_use]
pub fn none_proved(oscillator: &Oscillator) -> bool {
    oscillator.curve.even_weakening_range(oscillator.belt_speed).excludes(oscillator.viscous)
}

/// Reason why cycles are unknown.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CyclesUnknown {
    /// An orbit failed.
    #[error(transparent)]
    Orbit(#[from] Failure),
    /// Near a fold, where two cycles meet: whether there are two or none is within the error.
    #[error("two cycles meet within the error")]
    TooClose,
    /// No orbit closes within its error where one was read from those of other dampings.
    #[error("the orbit that was taken for a cycle does not close within its error")]
    NotClosed,
    /// The equilibrium is neutral: nothing tells whether orbits next to it lead outward or inward.
    #[error("steady slip is neutral: orbits next to it neither grow nor decay within rounding errors")]
    Neutral,
    /// There may be crossing cycles so far beyond the exit point that no loop was followed there, or that
    /// loops change by less than their error.
    #[error(
        "far beyond the exit point, where friction may push for ever, loops change by less than their error, or \
         none was followed: from more than 10^4 max(1, V)"
    )]
    FarOut,
}

/// Tolerance of the backbone, in units of the weakening rate. It only brackets each slip cycle, which is then
/// located by turns of its own.
pub(super) const BACKBONE_TOLERANCE: f64 = 1e-10;

/// Computes the slip cycle whose amplitude has known bounds and whose stability is known, with the relative error
/// `tolerance` of one turn divided by |1 - multiplier|, on one of `parts` equal parts of the quota.
///
/// # Errors
/// [`CyclesUnknown`] where an orbit fails, or none closes.
pub(super) fn locate(
    oscillator: &Oscillator,
    cycle: &CycleRange,
    tolerance: f64,
    parts: usize,
) -> Result<Cycle, CyclesUnknown> {
    let work = Work::of(Piece::SlipCycles, &oscillator.curve).part(parts);
    let CycleRange { near, between, is_stable } = *cycle;
    // The error of a backbone is an estimate: where no orbit closes within it, one does between the extremes.
    match locate_between(oscillator, near, is_stable, tolerance, &work) {
        Err(CyclesUnknown::NotClosed) if near != between => {
            locate_between(oscillator, between, is_stable, tolerance, &work)
        }
        found => found,
    }
}

fn locate_between(
    oscillator: &Oscillator,
    between: [f64; 2],
    is_stable: bool,
    tolerance: f64,
    work: &Work,
) -> Result<Cycle, CyclesUnknown> {
    let (radius, (from, end, extent)) = fixed_point(between, true, tolerance, |radius| {
        let mut extent = Extent::default();
        let end = walk_towards(oscillator, radius, is_stable, tolerance, work)
            .lower_arc(|walk, from, to| extent.step(walk, from, to))?;
        let turn = SlipTurn::of(radius, &end);
        let returns = match turn {
            SlipTurn::Returns { radius: next, slope, .. } => Some([next, slope]),
            SlipTurn::MeetsBelt { .. } | SlipTurn::Rests => None,
        };
        Ok::<_, Failure>((outward(radius, &turn), returns, (radius, end, extent)))
    })?;
    let (LowerEnd::Turns(end) | LowerEnd::Meets(end)) = end else { return Err(CyclesUnknown::NotClosed) };
    let State { v, w, growth, time, spread, .. } = end;
    let returned = v.hypot(w);
    if !is_closed(from, returned, spread / returned, tolerance * radius) {
        return Err(CyclesUnknown::NotClosed);
    }
    Ok(Cycle {
        period: time,
        displacement: extent.displacement,
        velocity: Range { hi: radius, ..extent.velocity },
        multiplier: if is_stable { growth.exp() } else { (-growth).exp() },
        beyond_exit: None,
    })
}

/// Whether an orbit that began at `from` came back there: within the `error` of its way, and what a fixed point was
/// located to. A search between two places ends somewhere, whether an orbit closes there or not.
pub(super) fn is_closed(from: f64, returned: f64, error: f64, located: f64) -> bool {
    (returned - from).abs() <= error + located
}

/// A walk from (x2, x2') = (`radius`, 0) in the direction of time in which a slip cycle attracts. A walk
/// forward would leave a cycle that strongly repels within a turn.
fn walk_towards<'a>(
    oscillator: &'a Oscillator,
    radius: f64,
    is_stable: bool,
    tolerance: f64,
    work: &'a Work,
) -> Walk<'a> {
    let walk = Walk::new(oscillator, Side::Below, [radius, 0.0], tolerance, radius, work);
    if is_stable { walk } else { walk.backward() }
}

/// The kicks that carry the equilibrium onto the slip cycle `cycle`: the velocities at which it passes the
/// equilibrium's x1. The cycle is followed with the relative error `tolerance`.
///
/// # Errors
/// [`Failure`] of its orbit.
pub fn kick_onto(oscillator: &Oscillator, cycle: &Cycle, tolerance: f64) -> Result<Kick, Failure> {
    let radius = cycle.velocity.hi;
    let work = Work::of(Piece::Kick, &oscillator.curve);
    let walk = walk_towards(oscillator, radius, cycle.is_stable(), tolerance, &work);
    Ok(kick_onto_orbit(oscillator, walk, Kick { forward: radius, backward: -cycle.velocity.lo })?.0)
}

/// The kicks that carry the equilibrium onto the orbit that grazes the belt line, where it is the edge of the
/// basin of stick-slip: with a drop, between C(V) and eps c* (theory, "Breakaway"). Followed backward, that
/// orbit comes from (V, -g), 0 < g < j, and the piece of the belt line between its ends closes the edge.
/// Returns the kicks and g; `None` elsewhere.
///
/// # Errors
/// [`Failure`] of the orbit.
pub fn kick_onto_grazing(oscillator: &Oscillator, tolerance: f64) -> Result<Option<(Kick, f64)>, Failure> {
    let belt_speed = oscillator.belt_speed;
    let work = Work::of(Piece::Kick, &oscillator.curve);
    let walk = Walk::new(oscillator, Side::Below, [belt_speed, 0.0], tolerance, belt_speed, &work);
    // Through the piece of the line the equilibrium is kicked out at V.
    let unknown = Kick { forward: belt_speed, backward: f64::NAN };
    let (kick, end) = kick_onto_orbit(oscillator, walk.backward(), unknown)?;
    let LowerEnd::Meets(end) = end else { return Ok(None) };
    let is_edge = end.w > 0.0 && end.w < oscillator.drop() && kick.backward.is_finite();
    Ok(is_edge.then_some((kick, end.w)))
}

/// The velocities at which an orbit passes the equilibrium's x1, those of `kick` where it does not, and its end.
fn kick_onto_orbit(
    oscillator: &Oscillator,
    mut walk: Walk,
    mut kick: Kick,
) -> Result<(Kick, LowerEnd), Failure> {
    let rest = oscillator.equilibrium_x1();
    let end = walk.lower_arc(|walk, from, to| {
        let [before, after] = [from, to].map(|state| walk.x1(state) - rest);
        if before * after <= 0.0 && before != after {
            let at = walk.locate(from, to, |walk, state| [walk.x1(state) - rest, walk.pace_of_x1(state)]);
            // The orbit passes once on the way forward and once on the way back.
            if at.v > 0.0 {
                kick.forward = at.v;
            } else {
                kick.backward = -at.v;
            }
        }
    })?;
    Ok((kick, end))
}

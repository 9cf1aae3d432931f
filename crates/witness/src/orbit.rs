//! A state of a slipping orbit, and the events along it.

use super::dop853::Compensated;

/// A state on an orbit, on a known side of the belt line.
#[derive(Clone, Copy, Debug)]
pub(super) struct State {
    /// x1 and x2, as offsets from the exit point.
    pub(super) offset: [Compensated; 2],
    /// w = x2'.
    pub(super) w: f64,
    /// Divergence D of the field.
    pub(super) divergence: f64,
    /// Time since the start.
    pub(super) time: f64,
}

impl State {
    /// x1 minus that of the exit point.
    pub(super) fn x1_offset(&self) -> f64 {
        self.offset[0].value()
    }

    /// x2 - V.
    pub(super) fn x2_offset(&self) -> f64 {
        self.offset[1].value()
    }
}

/// Whether the orbit moves away from the belt line or back towards it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Motion {
    /// |x2 - V| grows.
    Away,
    /// |x2 - V| falls.
    Back,
}

/// The event of one accepted step.
#[derive(Clone, Copy, Debug)]
pub(super) enum Event {
    /// No event; or the extremum of x2 farthest from the line, which is not used.
    Moved,
    /// The orbit turned away again at this state, without reaching the belt line.
    NearMiss(State),
    /// The orbit returned to the belt line.
    Landed(Contact),
}

/// The arrival at the belt line.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// The state on the line.
    pub(super) at: State,
    /// The extremum of x2 that the continued field reaches, if it lies in the same step.
    pub(super) turn: Option<State>,
    /// The end of the step, beyond the line.
    pub(super) beyond: State,
}

/// Outcome of following the continued field beyond the belt line.
#[derive(Clone, Copy, Debug)]
pub(super) enum Overshoot {
    /// It turns back at this state.
    Turns(State),
    /// It leaves the range of the continuation; this is its last state.
    Farther(State),
}

/// Reason why an orbit will never return to the belt line; v = x2, w = x2'. Both arguments use proved bounds
/// of the divergence D over the slip speeds in question.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rest {
    /// r^2 = v^2 + w^2 obeys r r' = D w^2, so where D <= 0 for all |v| <= r it never grows.
    Trapped {
        /// r, a bound on all later x2.
        radius: f64,
    },
    /// Where D <= -2 between here and the equilibrium, the wedge between w = 0 and w = -v is never left:
    /// on w = -v, (v + w)' = -v (D + 2) points inward, and so does w' = -v on w = 0. In it |v| falls
    /// monotonically to zero: x2 has no maximum any more.
    Creeping,
}

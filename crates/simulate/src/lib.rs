//! The simulated Filippov flow: the fate of the orbit that leaves the belt at the exit point.
//!
//! [`return_map`] follows the orbit in the scalar form, in polar coordinates of (x2, x2'); where that does not
//! apply, and from the belt line on, [`flow`] follows it by arcs of the Liénard form (`exit_orbit`).
//! [`critical_damping`] answers for a whole column at once.

pub mod arc;
pub mod backbone;
pub mod bifurcation;
mod circle;
mod closing;
mod collocation;
pub mod continuation;
pub mod critical;
pub mod crossing;
mod dop853;
mod elements;
mod exit_orbit;
pub mod far_loops;
pub mod graphs;
mod lower_set;
pub mod margins;
pub mod naive;
mod neighbours;
mod polar;
mod quarters;
pub mod return_map;
pub mod sensitivity;
pub mod slip_cycle;
mod stepping;
mod turn;
mod work;

pub use critical::{CriticalDamping, HALVINGS, NoCriticalDamping, SticksFrom, critical_damping, sticks_from};
pub use neighbours::{Neighbour, TIGHT, crossing_separates, separates};
pub use return_map::flow;
pub use work::QUESTION;

pub use slipmap_model::flow::{Failure, Fate, Flow, Landing};
pub use slipmap_model::friction::Range;

/// A limit cycle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Cycle {
    /// Period.
    pub period: f64,
    /// Positions x1 on it.
    #[serde(rename = "x1")]
    pub displacement: Range,
    /// Velocities x2 on it.
    #[serde(rename = "x2")]
    pub velocity: Range,
    /// Floquet multiplier: the cycle attracts if it is below 1 and repels if it is above; 0 for the
    /// stick-slip cycle, which is reached in finite time.
    pub multiplier: f64,
    /// For a cycle that crosses the belt line and never sticks: x1 at which it crosses downward, less that of
    /// the exit point.
    #[serde(skip)]
    pub beyond_exit: Option<f64>,
}

impl Cycle {
    /// Returns whether it attracts.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        self.multiplier < 1.0
    }
}

//! Orbits followed and closed: the engines.
//!
//! [`flow`] follows the orbit that leaves the belt at the exit point by arcs of the Liénard form (`exit_orbit`), next
//! to grazing by comparison with C* of [`grazing`]. [`closing`] and [`quarters`] find the dampings at which orbits close.

pub mod arc;
mod circle;
pub mod closing;
pub mod dop853;
pub mod elements;
mod exit_orbit;
pub mod far_loops;
mod flow;
pub mod grazing;
pub mod naive;
mod polar;
pub mod quarters;
pub mod work;

pub use flow::{fate_and_extent, flow, flow_with, flow_within};
pub use polar::Closing;
pub use work::{Effort, Piece, Work};

use slipmap_model::friction::Range;

/// A limit cycle.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
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

//! All that the flow of one oscillator tends to, or is kept apart by.

use super::crossing::{CrossingCycle, StickSlipCycle, crossing_cycles, stick_slip_cycle};
use super::Flow;
use super::slip_cycle::{Kick, SlipCycle, Unknown, kick_onto, slip_cycles};
use crate::filippov::{Eigenvalues, Oscillator};

/// The equilibrium and the cycles, with their stability as computed.
#[derive(Clone, Debug, PartialEq)]
pub struct Dynamics {
    /// Eigenvalues at the equilibrium.
    pub equilibrium: Eigenvalues,
    /// The stick-slip cycle.
    pub stick_slip: Option<StickSlipCycle>,
    /// Cycles below the belt line, by growing amplitude.
    pub slip: Vec<SlipCycle>,
    /// Cycles that cross the belt line, by growing size.
    pub crossing: Vec<CrossingCycle>,
    /// The kick that carries steady slip out of the reach of the equilibrium and of all slip cycles: `None`
    /// where the equilibrium is unstable and needs none, or where no kick below the belt line does it.
    pub kick: Option<Kick>,
}

/// The relative error of a turn below which nothing is gained, asked for where slip cycles are concerned:
/// their amplitude is the less certain the closer the multiplier is to 1.
const TIGHT: f64 = 1e-13;

/// Finds them; `flow` is the answer about the orbit from the exit point.
///
/// # Errors
/// [`Unknown`].
pub fn dynamics(oscillator: &Oscillator, flow: &Flow, tolerance: f64) -> Result<Dynamics, Unknown> {
    let equilibrium = oscillator.eigenvalues();
    let slip = slip_cycles(oscillator, tolerance.min(TIGHT))?;
    // What lies outside the outermost slip cycle leaves it if it repels.
    let boundary = slip.last().filter(|cycle| equilibrium.is_stable() && !cycle.is_stable());
    let kick = boundary.map(|cycle| kick_onto(oscillator, cycle, tolerance.min(TIGHT))).transpose()?;
    Ok(Dynamics {
        equilibrium,
        stick_slip: stick_slip_cycle(oscillator, flow, tolerance)?,
        crossing: crossing_cycles(oscillator, tolerance)?,
        slip,
        kick,
    })
}

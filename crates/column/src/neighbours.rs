//! The attractors on both sides of a cycle that repels.

use slipmap_model::flow::Fate;
use slipmap_numbers::named;

named! {
    /// The attractor of orbits on one side of a repelling cycle, with its name in `--json`.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Neighbour {
        /// Steady slip.
        Equilibrium => "equilibrium",
        /// The next slip cycle.
        SlipCycle => "slip_cycle",
        /// The stick-slip cycle.
        StickSlip => "stick_slip",
        /// None, or a cycle that crosses: orbits cross the belt line for ever.
        Crossing => "crossing",
        /// Not known: the orbit from the exit point, which lies between, has no certain fate, or orbits grow
        /// beyond the cycles found.
        Unknown => "unknown",
    }
}

/// The attractors on both sides of the slip cycle with this position among `count`, if it repels: of orbits
/// just inside it and of orbits just outside it, where the orbit from the exit point has the given fate.
/// Cycles alternate in stability, so its neighbours attract.
#[must_use]
pub fn separates(cycle: usize, count: usize, fate: &Fate) -> [Neighbour; 2] {
    let inside = if cycle == 0 { Neighbour::Equilibrium } else { Neighbour::SlipCycle };
    let outside = match fate {
        _ if cycle + 1 < count => Neighbour::SlipCycle,
        Fate::CrossesForever => Neighbour::Crossing,
        Fate::Sticks(_) => Neighbour::StickSlip,
        // Towards this cycle, which repels: the fate is wrong, or cycles are missing.
        Fate::SpiralsInward | Fate::TooCloseToCall | Fate::Failed(_) => Neighbour::Unknown,
    };
    [inside, outside]
}

/// The attractors on both sides of a repelling cycle that crosses the belt line, with this position among
/// `count` of them, with `slip_cycles` slip cycles. The orbit from the exit point runs between both kinds.
#[must_use]
pub fn crossing_separates(cycle: usize, count: usize, slip_cycles: usize, fate: &Fate) -> [Neighbour; 2] {
    let inside = match fate {
        _ if cycle > 0 => Neighbour::Crossing,
        Fate::Sticks(_) => Neighbour::StickSlip,
        Fate::SpiralsInward if slip_cycles > 0 => Neighbour::SlipCycle,
        Fate::SpiralsInward => Neighbour::Equilibrium,
        // Outward, to this cycle, which repels.
        Fate::CrossesForever | Fate::TooCloseToCall | Fate::Failed(_) => Neighbour::Unknown,
    };
    let outside = if cycle + 1 < count { Neighbour::Crossing } else { Neighbour::Unknown };
    [inside, outside]
}

//! The labels that a map stores.

use crate::certify::Decision;
use crate::simulate::Fate;
use crate::simulate::naive::NaiveVerdict;

/// A method's verdict on one cell, with the code stored in `verdict_METHOD`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum Verdict {
    /// No stick-slip limit cycle.
    Absent = -1,
    /// The method does not decide.
    Undecided = 0,
    /// A stick-slip limit cycle exists.
    Present = 1,
    /// The method failed; `slipmap probe` shows the reason.
    Failed = 2,
    /// The cell was not computed.
    NotComputed = 3,
}

impl Verdict {
    /// Every verdict, in the order of its code.
    pub const ALL: [Verdict; 5] =
        [Verdict::Absent, Verdict::Undecided, Verdict::Present, Verdict::Failed, Verdict::NotComputed];

    /// Name in tables and in `flag_meanings`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Verdict::Absent => "absent",
            Verdict::Undecided => "undecided",
            Verdict::Present => "present",
            Verdict::Failed => "failed",
            Verdict::NotComputed => "not_computed",
        }
    }

    /// The stored code.
    #[must_use]
    pub fn code(self) -> i8 {
        self as i8
    }
}

impl From<Decision> for Verdict {
    fn from(decision: Decision) -> Self {
        match decision {
            Decision::Present => Verdict::Present,
            Decision::Absent => Verdict::Absent,
            Decision::Undecided => Verdict::Undecided,
        }
    }
}

impl From<&Fate> for Verdict {
    fn from(fate: &Fate) -> Self {
        match fate {
            Fate::Sticks(_) => Verdict::Present,
            Fate::SpiralsInward | Fate::CrossesForever => Verdict::Absent,
            Fate::TooCloseToCall => Verdict::Undecided,
            Fate::Failed(_) => Verdict::Failed,
        }
    }
}

impl From<NaiveVerdict> for Verdict {
    fn from(verdict: NaiveVerdict) -> Self {
        match verdict {
            NaiveVerdict::Sticks { .. } => Verdict::Present,
            NaiveVerdict::NeverSticks => Verdict::Absent,
            NaiveVerdict::Failed(_) => Verdict::Failed,
        }
    }
}

/// The attractor of the orbit from the exit point, if the orbit returns to the belt line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outside {
    /// The stick-slip cycle.
    StickSlip,
    /// It crosses the belt line for ever.
    Crossing,
}

/// A set of attractors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attractors {
    /// Steady slip at the equilibrium.
    pub equilibrium: bool,
    /// A cycle that slips all the time below the belt line, or several.
    pub slip: bool,
    /// The attractor outside of these. Crossing cycles around a stick-slip cycle are not searched for here.
    pub outside: Option<Outside>,
}

/// The long-run behaviour of a cell, which is its set of attractors, with the code stored in `regime`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum Regime {
    /// Steady slip at the equilibrium is the only attractor.
    Equilibrium = 0,
    /// The stick-slip cycle is the only attractor.
    StickSlip = 1,
    /// The equilibrium and the stick-slip cycle both attract.
    Bistable = 2,
    /// A cycle that slips all the time below the belt line, or several, and nothing else.
    PureSlip = 3,
    /// Orbits cross the belt line for ever and never stick; nothing else attracts.
    Crossing = 4,
    /// Not determined.
    Failed = 5,
    /// A slip cycle and the stick-slip cycle both attract.
    PureSlipAndStickSlip = 6,
    /// A slip cycle and the equilibrium both attract.
    PureSlipAndEquilibrium = 7,
    /// The equilibrium, a slip cycle and the stick-slip cycle attract.
    EquilibriumPureSlipAndStickSlip = 8,
    /// The equilibrium attracts, and from outside its basin orbits cross the belt line for ever.
    EquilibriumAndCrossing = 9,
    /// A slip cycle attracts, and from outside its basin orbits cross the belt line for ever.
    PureSlipAndCrossing = 10,
    /// The equilibrium and a slip cycle attract, and from outside their basins orbits cross the belt line for
    /// ever.
    EquilibriumPureSlipAndCrossing = 11,
}

impl Regime {
    /// Every regime, in the order of its code.
    pub const ALL: [Regime; 12] = [
        Regime::Equilibrium,
        Regime::StickSlip,
        Regime::Bistable,
        Regime::PureSlip,
        Regime::Crossing,
        Regime::Failed,
        Regime::PureSlipAndStickSlip,
        Regime::PureSlipAndEquilibrium,
        Regime::EquilibriumPureSlipAndStickSlip,
        Regime::EquilibriumAndCrossing,
        Regime::PureSlipAndCrossing,
        Regime::EquilibriumPureSlipAndCrossing,
    ];

    /// The regime with these attractors; [`Regime::Failed`] for none, which no flow has.
    #[must_use]
    pub fn of(attractors: Attractors) -> Self {
        let Attractors { equilibrium, slip, outside } = attractors;
        match (equilibrium, slip, outside) {
            (false, false, None) => Regime::Failed,
            (true, false, None) => Regime::Equilibrium,
            (false, true, None) => Regime::PureSlip,
            (true, true, None) => Regime::PureSlipAndEquilibrium,
            (false, false, Some(Outside::StickSlip)) => Regime::StickSlip,
            (true, false, Some(Outside::StickSlip)) => Regime::Bistable,
            (false, true, Some(Outside::StickSlip)) => Regime::PureSlipAndStickSlip,
            (true, true, Some(Outside::StickSlip)) => Regime::EquilibriumPureSlipAndStickSlip,
            (false, false, Some(Outside::Crossing)) => Regime::Crossing,
            (true, false, Some(Outside::Crossing)) => Regime::EquilibriumAndCrossing,
            (false, true, Some(Outside::Crossing)) => Regime::PureSlipAndCrossing,
            (true, true, Some(Outside::Crossing)) => Regime::EquilibriumPureSlipAndCrossing,
        }
    }

    /// Name in tables and in `flag_meanings`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Regime::Equilibrium => "equilibrium",
            Regime::StickSlip => "stick_slip",
            Regime::Bistable => "bistable",
            Regime::PureSlip => "pure_slip",
            Regime::Crossing => "crossing",
            Regime::Failed => "failed",
            Regime::PureSlipAndStickSlip => "pure_slip_and_stick_slip",
            Regime::PureSlipAndEquilibrium => "pure_slip_and_equilibrium",
            Regime::EquilibriumPureSlipAndStickSlip => "equilibrium_pure_slip_and_stick_slip",
            Regime::EquilibriumAndCrossing => "equilibrium_and_crossing",
            Regime::PureSlipAndCrossing => "pure_slip_and_crossing",
            Regime::EquilibriumPureSlipAndCrossing => "equilibrium_pure_slip_and_crossing",
        }
    }

    /// The stored code.
    #[must_use]
    pub fn code(self) -> i8 {
        self as i8
    }
}

//! The labels a map stores.

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
    /// The method broke down; the reason is available from `slipmap probe`.
    Failed = 2,
    /// The cell was not computed.
    NotComputed = 3,
}

impl Verdict {
    /// Every verdict, in the order of its code.
    pub const ALL: [Verdict; 5] =
        [Verdict::Absent, Verdict::Undecided, Verdict::Present, Verdict::Failed, Verdict::NotComputed];

    /// The word used in tables and in `flag_meanings`.
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

/// The long-run behaviour of a cell, with the code stored in `regime`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(i8)]
pub enum Regime {
    /// Steady slip at the equilibrium is the only attractor.
    Equilibrium = 0,
    /// The stick-slip cycle is the only attractor.
    StickSlip = 1,
    /// The equilibrium and the stick-slip cycle both attract.
    Bistable = 2,
    /// A cycle that slips all the time below the belt line.
    PureSlip = 3,
    /// A cycle that crosses the belt line and never sticks.
    Crossing = 4,
    /// Not determined.
    Failed = 5,
    /// A slip cycle and the stick-slip cycle both attract.
    PureSlipAndStickSlip = 6,
    /// A slip cycle and the equilibrium both attract.
    PureSlipAndEquilibrium = 7,
}

impl Regime {
    /// Every regime, in the order of its code.
    pub const ALL: [Regime; 8] = [
        Regime::Equilibrium,
        Regime::StickSlip,
        Regime::Bistable,
        Regime::PureSlip,
        Regime::Crossing,
        Regime::Failed,
        Regime::PureSlipAndStickSlip,
        Regime::PureSlipAndEquilibrium,
    ];

    /// The word used in tables and in `flag_meanings`.
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
        }
    }

    /// The stored code.
    #[must_use]
    pub fn code(self) -> i8 {
        self as i8
    }
}

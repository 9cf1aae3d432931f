//! The labels that a map stores.

use slipmap_certify::Decision;
use slipmap_numbers::named;
use slipmap_orbits::naive::NaiveVerdict;

named! {
    /// A method's verdict on one cell, with the code stored in `verdict_METHOD` and its name in tables and in
    /// `flag_meanings`.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[derive(serde::Serialize, serde::Deserialize)]
    #[repr(i8)]
    pub enum Verdict {
        /// No stick-slip limit cycle.
        Absent = -1 => "absent",
        /// The method does not decide.
        Undecided = 0 => "undecided",
        /// A stick-slip limit cycle exists.
        Present = 1 => "present",
        /// The method failed; `slipmap probe` shows the reason.
        Failed = 2 => "failed",
        /// The cell was not computed.
        NotComputed = 3 => "not_computed",
    }
}

impl Verdict {
    /// The stored code.
    #[must_use]
    pub fn code(self) -> i8 {
        self as i8
    }

    /// The verdict that a code in a map stands for.
    pub fn of_code(code: i8) -> Option<Self> {
        Self::ALL.into_iter().find(|verdict| verdict.code() == code)
    }

    /// Returns whether it is presence or absence.
    pub fn is_decision(self) -> bool {
        self.presence().is_some()
    }

    /// Whether it is presence; `None` if it is neither that nor absence.
    pub fn presence(self) -> Option<bool> {
        match self {
            Verdict::Present => Some(true),
            Verdict::Absent => Some(false),
            Verdict::Undecided | Verdict::Failed | Verdict::NotComputed => None,
        }
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

impl From<NaiveVerdict> for Verdict {
    fn from(verdict: NaiveVerdict) -> Self {
        match verdict {
            NaiveVerdict::Sticks { .. } => Verdict::Present,
            NaiveVerdict::NeverSticks => Verdict::Absent,
            NaiveVerdict::Failed(_) => Verdict::Failed,
        }
    }
}

/// A set of attractors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Attractors {
    /// Steady slip at the equilibrium.
    pub equilibrium: bool,
    /// A cycle that slips all the time below the belt line, or several.
    pub slip: bool,
    /// The stick-slip cycle.
    pub stick_slip: bool,
    /// Orbits that cross the belt line for ever and never stick: they tend to a crossing cycle, or grow.
    pub crossing: bool,
}

named! {
    /// The long-run behaviour of a cell, which is its set of attractors, with the code stored in `regime` and
    /// its name in tables and in `flag_meanings`.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    #[repr(i8)]
    pub enum Regime {
        /// Steady slip at the equilibrium is the only attractor.
        Equilibrium = 0 => "equilibrium",
        /// The stick-slip cycle is the only attractor.
        StickSlip = 1 => "stick_slip",
        /// The equilibrium and the stick-slip cycle both attract.
        Bistable = 2 => "bistable",
        /// A cycle that slips all the time below the belt line, or several, and nothing else.
        PureSlip = 3 => "pure_slip",
        /// Orbits cross the belt line for ever and never stick; nothing else attracts.
        Crossing = 4 => "crossing",
        /// Not determined.
        Failed = 5 => "failed",
        /// A slip cycle and the stick-slip cycle both attract.
        PureSlipAndStickSlip = 6 => "pure_slip_and_stick_slip",
        /// A slip cycle and the equilibrium both attract.
        PureSlipAndEquilibrium = 7 => "pure_slip_and_equilibrium",
        /// The equilibrium, a slip cycle and the stick-slip cycle attract.
        EquilibriumPureSlipAndStickSlip = 8 => "equilibrium_pure_slip_and_stick_slip",
        /// The equilibrium attracts, and from outside its basin orbits cross the belt line for ever.
        EquilibriumAndCrossing = 9 => "equilibrium_and_crossing",
        /// A slip cycle attracts, and from outside its basin orbits cross the belt line for ever.
        PureSlipAndCrossing = 10 => "pure_slip_and_crossing",
        /// The equilibrium and a slip cycle attract, and from outside their basins orbits cross the belt line
        /// for ever.
        EquilibriumPureSlipAndCrossing = 11 => "equilibrium_pure_slip_and_crossing",
        /// The stick-slip cycle attracts, and orbits far outside of it cross the belt line for ever.
        StickSlipAndCrossing = 12 => "stick_slip_and_crossing",
        /// The equilibrium and the stick-slip cycle attract, and orbits far outside cross the belt line for
        /// ever.
        EquilibriumStickSlipAndCrossing = 13 => "equilibrium_stick_slip_and_crossing",
        /// A slip cycle and the stick-slip cycle attract, and orbits far outside cross the belt line for
        /// ever.
        PureSlipStickSlipAndCrossing = 14 => "pure_slip_stick_slip_and_crossing",
        /// The equilibrium, a slip cycle and the stick-slip cycle attract, and orbits far outside cross the
        /// belt line for ever.
        EquilibriumPureSlipStickSlipAndCrossing = 15 => "equilibrium_pure_slip_stick_slip_and_crossing",
        /// Steady slip neither attracts nor repels: its divergence is 0 within rounding. Which cycles attract
        /// beside it is not told; the verdict of the simulation tells it of the stick-slip cycle.
        Neutral = 16 => "neutral",
    }
}

impl Regime {
    /// The regime with these attractors; [`Regime::Failed`] for none, which no flow has.
    #[must_use]
    pub fn of(attractors: Attractors) -> Self {
        let Attractors { equilibrium, slip, stick_slip, crossing } = attractors;
        match (equilibrium, slip, stick_slip, crossing) {
            (false, false, false, false) => Regime::Failed,
            (true, false, false, false) => Regime::Equilibrium,
            (false, true, false, false) => Regime::PureSlip,
            (true, true, false, false) => Regime::PureSlipAndEquilibrium,
            (false, false, true, false) => Regime::StickSlip,
            (true, false, true, false) => Regime::Bistable,
            (false, true, true, false) => Regime::PureSlipAndStickSlip,
            (true, true, true, false) => Regime::EquilibriumPureSlipAndStickSlip,
            (false, false, false, true) => Regime::Crossing,
            (true, false, false, true) => Regime::EquilibriumAndCrossing,
            (false, true, false, true) => Regime::PureSlipAndCrossing,
            (true, true, false, true) => Regime::EquilibriumPureSlipAndCrossing,
            (false, false, true, true) => Regime::StickSlipAndCrossing,
            (true, false, true, true) => Regime::EquilibriumStickSlipAndCrossing,
            (false, true, true, true) => Regime::PureSlipStickSlipAndCrossing,
            (true, true, true, true) => Regime::EquilibriumPureSlipStickSlipAndCrossing,
        }
    }

    /// Its attractors; none of [`Regime::Failed`] and [`Regime::Neutral`].
    #[must_use]
    pub fn attractors(self) -> Attractors {
        let mut all = (0..16).map(|bits| {
            let [equilibrium, slip, stick_slip, crossing] = [1, 2, 4, 8].map(|bit| bits & bit != 0);
            Attractors { equilibrium, slip, stick_slip, crossing }
        });
        let none = Attractors { equilibrium: false, slip: false, stick_slip: false, crossing: false };
        all.find(|attractors| Regime::of(*attractors) == self).unwrap_or(none)
    }

    /// The stored code.
    #[must_use]
    pub fn code(self) -> i8 {
        self as i8
    }
}

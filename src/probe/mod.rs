//! All answers about one parameter point as one typed result: printed by `slipmap probe`, returned to Python.

mod answer;
#[cfg(feature = "cli")]
mod command;

pub(crate) use answer::landing;
pub use answer::{Answer, MethodAnswer};
#[cfg(feature = "cli")]
pub(crate) use command::{axis_names, command_line, flag};

use std::borrow::Cow;

use crate::behaviour::Behaviour;
use crate::filippov::{Eigenvalues, Oscillator};
use crate::friction::{Law, Range};
use crate::machine::Machine;
use crate::map::limits::Limit;
use crate::map::{AttractingCycle, Grid, Regime};
use crate::simulate::crossing::{CrossingCycle, StickSlipCycle};
use crate::simulate::sensitivity::{Estimate, NoSensitivity, Sensitivity};
use crate::simulate::slip_count::SlipCount;
use crate::simulate::slip_cycle::{Kick, SlipCycle};
use crate::simulate::{
    CriticalDamping, Dynamics, Fate, Flow, Landing, Neighbour, NoCriticalDamping, crossing_separates,
    separates,
};

/// Derives `Serialize` where the feature `serde` is on.
macro_rules! result {
    ($($(#[$meta:meta])* $vis:vis struct $name:ident { $($fields:tt)* })*) => {
        $($(#[$meta])*
        #[derive(Clone, Debug, PartialEq)]
        #[cfg_attr(feature = "serde", derive(serde::Serialize))]
        $vis struct $name { $($fields)* })*
    };
}

result! {
    /// All answers about one point; `slipmap probe --json` prints its serialised form.
    pub struct Probe {
        /// Name of the friction law.
        pub(crate) law: &'static str,
        /// The point: each axis of the law with its value, in the order of [`Grid::axis_names`].
        #[cfg_attr(feature = "serde", serde(serialize_with = "as_map"))]
        pub(crate) point: Vec<(&'static str, f64)>,
        /// Bound on the error of the scaled grazing margin m / V that the simulation aimed at.
        pub(crate) tolerance: f64,
        /// The answer of each method, by name.
        #[cfg_attr(feature = "serde", serde(serialize_with = "as_map"))]
        pub(crate) methods: Vec<(&'static str, MethodResult)>,
        /// The orbit from the exit point by both engines.
        pub(crate) flow: Flows,
        /// The critical damping of the column.
        pub(crate) critical_c: CriticalResult,
        /// Sensitivities of the critical damping.
        pub(crate) sensitivity: SensitivityResult,
        /// Name of the long-run behaviour.
        pub(crate) regime: &'static str,
        /// The state of steady slip.
        pub(crate) equilibrium: Equilibrium,
        /// The segment on which the mass can stick.
        pub(crate) sliding_segment: SlidingSegment,
        /// The point at which every sticking orbit leaves the belt.
        pub(crate) exit_point: State,
        /// Place and times of sticking again, for the orbit from the exit point.
        pub(crate) landing: Option<LandingResult>,
        /// The dampings between which steady slip and stick-slip both attract.
        pub(crate) bistable_band: Option<BistableBand>,
        /// The attracting cycle.
        pub(crate) attracting_cycle: Option<CycleResult>,
        /// The unstable slip cycle inside which orbits tend to steady slip.
        pub(crate) basin_boundary: Option<BasinBoundary>,
        /// All cycles, with their stability.
        pub(crate) cycles: Cycles,
        /// Behaviour of the machine, in SI units; only if one was given.
        #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
        pub machine: Option<MachineResult>,
    }

    /// The answer of one method.
    pub(crate) struct MethodResult {
        /// "present", "absent", "undecided" or "failed".
        pub(crate) verdict: &'static str,
        /// As in a map, see [`MethodAnswer::margin`].
        pub(crate) margin: f64,
        /// The edge of presence in c; `None` where there is none at c >= 0.
        pub(crate) critical_c: Option<f64>,
        /// Guarantee of the verdict.
        pub(crate) guarantee: &'static str,
        /// Equation in the paper, or section of the theory pages.
        pub(crate) equation: Cow<'static, str>,
        /// Reason why the verdict is neither presence nor absence.
        pub(crate) reason: Option<String>,
        /// Largest eps up to which the verdict equals the simulated one.
        pub(crate) epsilon_limit: Limit,
        /// Largest eps up to which the verdict does not contradict the simulated one.
        pub(crate) epsilon_limit_sound: Limit,
        /// Reason why one of these two is not known.
        pub(crate) epsilon_limit_reason: Option<String>,
    }

    /// The orbit from the exit point by both engines.
    pub(crate) struct Flows {
        /// By the scalar return map.
        pub(crate) return_map: FlowResult,
        /// By integration in (x1, x2).
        pub(crate) direct: FlowResult,
    }

    /// The orbit from the exit point by one engine.
    pub(crate) struct FlowResult {
        /// "sticks", "spirals_inward", "crosses_forever", "too_close_to_call" or "failed".
        pub(crate) fate: &'static str,
        /// The verdict that follows from this fate.
        pub(crate) verdict: &'static str,
        /// The scaled grazing margin m / V; NaN where the flow has none.
        pub(crate) margin: f64,
        /// Estimate of the absolute error of `margin`.
        pub(crate) margin_error: f64,
        /// Evaluations of the right-hand side.
        pub(crate) rhs: u64,
        /// Place and times of sticking.
        pub(crate) landing: Option<LandingResult>,
        /// Reason why there is no answer.
        pub(crate) reason: Option<String>,
    }

    /// Place and times of sticking.
    pub(crate) struct LandingResult {
        /// x1 at which the mass begins to stick.
        pub(crate) x1: f64,
        /// Time of slipping.
        pub(crate) slip_time: f64,
        /// Time of sticking.
        pub(crate) stick_time: f64,
        /// Their sum.
        pub(crate) period: f64,
        /// Crossings of the belt line before the mass sticks.
        pub(crate) crossings: u32,
    }

    /// The critical damping of a column.
    pub(crate) struct CriticalResult {
        /// c*; negative where no legal damping is small enough for a cycle.
        pub(crate) value: Option<f64>,
        /// Estimate of the absolute error of `value`.
        pub(crate) error: Option<f64>,
        /// Evaluations of the right-hand side.
        pub(crate) rhs: Option<u64>,
        /// Reason why there is none.
        pub(crate) reason: Option<String>,
    }

    /// Derivatives of the critical damping.
    pub(crate) struct SensitivityResult {
        /// By each axis but the damping, in the order of [`Grid::axis_names`]; empty if they are unknown.
        #[cfg_attr(feature = "serde", serde(serialize_with = "as_map"))]
        pub(crate) derivatives: Vec<(&'static str, EstimateResult)>,
        /// The standard error of the critical damping, of a table with standard errors.
        pub(crate) standard_error: Option<EstimateResult>,
        /// Reason why there are none.
        pub(crate) reason: Option<String>,
    }

    /// A number and an estimate of its absolute error.
    pub(crate) struct EstimateResult {
        /// The number.
        pub(crate) value: f64,
        /// Estimate of its absolute error.
        pub(crate) error: f64,
    }

    /// The state of steady slip.
    pub(crate) struct Equilibrium {
        /// Position.
        pub(crate) x1: f64,
        /// Velocity, 0.
        pub(crate) x2: f64,
        /// Divergence of the flow there.
        pub(crate) divergence: f64,
        /// Type, for instance "unstable focus".
        #[cfg_attr(feature = "serde", serde(rename = "type"))]
        pub(crate) kind: &'static str,
        /// The two eigenvalues.
        pub(crate) eigenvalues: [Complex; 2],
    }

    /// A complex number.
    pub(crate) struct Complex {
        /// Real part.
        pub(crate) re: f64,
        /// Imaginary part.
        pub(crate) im: f64,
    }

    /// The sliding segment: from_x1 < x1 < to_x1 on the line x2.
    pub(crate) struct SlidingSegment {
        /// The end at which the upper field is tangent.
        pub(crate) from_x1: f64,
        /// The exit point.
        pub(crate) to_x1: f64,
        /// Belt speed.
        pub(crate) x2: f64,
    }

    /// A state.
    pub(crate) struct State {
        /// Position.
        pub(crate) x1: f64,
        /// Velocity.
        pub(crate) x2: f64,
    }

    /// The dampings c >= 0 between which steady slip and stick-slip both attract.
    pub(crate) struct BistableBand {
        /// Damping from which on the equilibrium is stable.
        pub(crate) from_c: f64,
        /// The critical damping.
        pub(crate) to_c: f64,
        /// Estimate of the absolute error of the latter.
        pub(crate) error: f64,
    }

    /// The range of a coordinate.
    pub(crate) struct Extent {
        /// Least value.
        pub(crate) from: f64,
        /// Greatest value.
        pub(crate) to: f64,
    }

    /// A cycle that attracts.
    pub(crate) struct CycleResult {
        /// Period.
        pub(crate) period: f64,
        /// Positions on it.
        pub(crate) x1: Extent,
        /// Velocities on it.
        pub(crate) x2: Extent,
        /// Floquet multiplier; 0 if it sticks.
        pub(crate) multiplier: f64,
    }

    /// A cycle with its stability.
    pub(crate) struct StabilityResult {
        /// Whether it attracts.
        pub(crate) stable: bool,
        /// Floquet multiplier; 0 if it sticks.
        pub(crate) multiplier: f64,
        /// For a repelling cycle: the attractors of the orbits just inside it and just outside it,
        /// "equilibrium", "slip_cycle", "stick_slip", "crossing" or "unknown".
        #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
        pub(crate) separates: Option<[&'static str; 2]>,
        /// Period.
        pub(crate) period: f64,
        /// For a cycle that crosses the belt line: x1 at which it crosses downward, less that of the exit
        /// point.
        #[cfg_attr(feature = "serde", serde(skip_serializing_if = "Option::is_none"))]
        pub(crate) beyond_exit: Option<f64>,
        /// Positions on it.
        pub(crate) x1: Extent,
        /// Velocities on it.
        pub(crate) x2: Extent,
    }

    /// The unstable slip cycle inside which orbits tend to steady slip, and the kicks onto it.
    pub(crate) struct BasinBoundary {
        /// The cycle.
        pub(crate) cycle: StabilityResult,
        /// The kicks.
        pub(crate) kick: KickResult,
    }

    /// Sudden changes of velocity that start stick-slip from steady slip.
    pub(crate) struct KickResult {
        /// Along the belt's motion.
        pub(crate) forward: f64,
        /// Against it, as a positive number.
        pub(crate) backward: f64,
    }

    /// All cycles of a point.
    pub(crate) struct AllCycles {
        /// The stick-slip cycle.
        pub(crate) stick_slip: Option<StabilityResult>,
        /// Cycles below the belt line, by growing amplitude.
        pub(crate) slip: Vec<StabilityResult>,
        /// Bounds on their number.
        pub(crate) slip_count: SlipCountResult,
        /// Cycles that cross the belt line, by growing size.
        pub(crate) crossing: Vec<StabilityResult>,
    }

    /// Proved bounds on the number of slip cycles.
    pub(crate) struct SlipCountResult {
        /// The number, where it is proved.
        pub(crate) proved: Option<u32>,
        /// Lower bound.
        pub(crate) at_least: u32,
        /// Upper bound; `None` where there is none.
        pub(crate) at_most: Option<u32>,
        /// Ranges of the maximum of x2 in which nothing is proved.
        pub(crate) open: Vec<Extent>,
    }

    /// Behaviour of a machine, in SI units (for a rotation: rad for m, N m for N, kg m^2 for kg).
    pub struct MachineResult {
        /// "translation" or "rotation".
        pub(crate) motion: &'static str,
        /// Belt speed, m/s.
        pub(crate) belt_speed: f64,
        /// Damping coefficient, N s/m.
        pub(crate) damping: f64,
        /// See [`Behaviour::critical_belt_speed`].
        pub(crate) critical_belt_speed: Option<f64>,
        /// See [`Behaviour::critical_damping`].
        pub(crate) critical_damping: Option<f64>,
        /// The same as a damping ratio.
        pub(crate) critical_damping_ratio: Option<f64>,
        /// Damping ratio d / (2 sqrt(k m)).
        pub(crate) damping_ratio: f64,
        /// Undamped natural frequency, Hz.
        pub(crate) natural_frequency: f64,
        /// Name of the long-run behaviour.
        pub(crate) regime: &'static str,
        /// Slip time of the stick-slip cycle, s.
        pub(crate) slip_time: Option<f64>,
        /// Stick time of the stick-slip cycle, s.
        pub(crate) stick_time: Option<f64>,
        /// Half the distance between the extremes of x of the attracting cycle, m.
        pub(crate) amplitude: Option<f64>,
        /// The units of the dimensionless oscillator.
        pub(crate) units: UnitsResult,
    }

    /// The units of the dimensionless oscillator, in SI.
    pub(crate) struct UnitsResult {
        /// s.
        pub(crate) time: f64,
        /// m.
        pub(crate) length: f64,
        /// m/s.
        pub(crate) velocity: f64,
        /// N.
        pub(crate) force: f64,
    }
}

/// All cycles, or the reason why they could not be computed.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize), serde(untagged))]
pub(crate) enum Cycles {
    /// All of them.
    Found(AllCycles),
    /// An orbit could not be followed.
    Failed {
        /// The reason.
        reason: String,
    },
}

/// Pairs as a map, in their order.
#[cfg(feature = "serde")]
fn as_map<T: serde::Serialize, S: serde::Serializer>(
    pairs: &[(&'static str, T)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}

/// Serialises a limit as a number; "inf" where it is beyond all eps looked at, since JSON has no infinity;
/// null where it is unknown.
#[cfg(feature = "serde")]
impl serde::Serialize for Limit {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Limit::Never | Limit::UpTo(_) => serializer.serialize_f64(self.value()),
            Limit::Throughout => serializer.serialize_str("inf"),
            Limit::Unknown(_) => serializer.serialize_none(),
        }
    }
}

impl Probe {
    /// The whole result, with the flow of the engine `direct`. Takes much longer than [`Answer::of`]: the
    /// limits in eps need a few hundred orbits.
    #[must_use]
    pub fn new(answer: &Answer, direct: &Flow) -> Self {
        let oscillator = &answer.oscillator;
        let methods = answer.methods.iter().zip(answer.limits()).map(|(said, limit)| {
            let result = MethodResult {
                verdict: said.verdict.name(),
                margin: said.margin,
                critical_c: said.critical_c,
                guarantee: said.method.guarantee().name(),
                equation: said.method.equation_for(&answer.law),
                reason: said.reason.clone(),
                epsilon_limit: limit.equal,
                epsilon_limit_sound: limit.sound,
                epsilon_limit_reason: limit.unknown().map(|why| why.to_string()),
            };
            (said.method.name(), result)
        });
        Self {
            law: answer.law.name(),
            point: Grid::coordinates(&answer.law, &answer.point),
            tolerance: answer.tolerance,
            methods: methods.collect(),
            flow: Flows { return_map: (&answer.flow).into(), direct: direct.into() },
            critical_c: (&answer.critical).into(),
            sensitivity: SensitivityResult::of(&answer.law, answer.sensitivity()),
            regime: answer.regime.name(),
            equilibrium: Equilibrium::of(oscillator),
            sliding_segment: SlidingSegment {
                from_x1: oscillator.upper_tangency_x1(),
                to_x1: oscillator.exit_x1(),
                x2: oscillator.belt_speed,
            },
            exit_point: State { x1: oscillator.exit_x1(), x2: oscillator.belt_speed },
            landing: answer.landing().map(Into::into),
            bistable_band: answer.bistable_band().map(|[from_c, to_c, error]| BistableBand {
                from_c,
                to_c,
                error,
            }),
            attracting_cycle: answer.cycle.map(Into::into),
            basin_boundary: answer.basin.map(|(cycle, Kick { forward, backward })| BasinBoundary {
                cycle: cycle.into(),
                kick: KickResult { forward, backward },
            }),
            cycles: match answer.dynamics() {
                Ok(dynamics) => {
                    Cycles::Found(AllCycles::of(dynamics, answer.slip_count(), &answer.flow.fate))
                }
                Err(failure) => Cycles::Failed { reason: failure.to_string() },
            },
            machine: None,
        }
    }
}

impl SensitivityResult {
    fn of(law: &Law, found: Result<Sensitivity, NoSensitivity>) -> Self {
        match found {
            Ok(found) => Self {
                derivatives: found.named(law).map(|(name, by)| (name, by.into())).collect(),
                standard_error: found.standard_error.map(Into::into),
                reason: None,
            },
            Err(why) => Self { derivatives: Vec::new(), standard_error: None, reason: Some(why.to_string()) },
        }
    }
}

impl From<Estimate> for EstimateResult {
    fn from(Estimate { value, error }: Estimate) -> Self {
        Self { value, error }
    }
}

impl From<&Flow> for FlowResult {
    fn from(flow: &Flow) -> Self {
        Self {
            fate: fate_name(&flow.fate),
            verdict: crate::map::Verdict::from(&flow.fate).name(),
            margin: flow.margin,
            margin_error: flow.margin_error,
            rhs: flow.rhs,
            landing: landing(flow).map(Into::into),
            reason: match flow.fate {
                Fate::Failed(failure) => Some(failure.to_string()),
                _ => None,
            },
        }
    }
}

impl From<Landing> for LandingResult {
    fn from(Landing { x1, slip_time, stick_time, crossings }: Landing) -> Self {
        Self { x1, slip_time, stick_time, period: slip_time + stick_time, crossings }
    }
}

impl From<&Result<CriticalDamping, NoCriticalDamping>> for CriticalResult {
    fn from(critical: &Result<CriticalDamping, NoCriticalDamping>) -> Self {
        match critical {
            Ok(root) => {
                Self { value: Some(root.c), error: Some(root.error), rhs: Some(root.rhs), reason: None }
            }
            Err(why) => Self { value: None, error: None, rhs: None, reason: Some(why.to_string()) },
        }
    }
}

impl Equilibrium {
    fn of(oscillator: &Oscillator) -> Self {
        Self {
            x1: oscillator.equilibrium_x1(),
            x2: 0.0,
            divergence: oscillator.divergence(oscillator.belt_speed),
            kind: equilibrium_type(oscillator),
            eigenvalues: match oscillator.eigenvalues() {
                Eigenvalues::Complex { re, im } => [Complex { re, im: -im }, Complex { re, im }],
                Eigenvalues::Real { slow, fast } => {
                    [Complex { re: slow, im: 0.0 }, Complex { re: fast, im: 0.0 }]
                }
            },
        }
    }
}

impl From<Range> for Extent {
    fn from(range: Range) -> Self {
        Self { from: range.lo, to: range.hi }
    }
}

impl From<AttractingCycle> for CycleResult {
    fn from(cycle: AttractingCycle) -> Self {
        Self {
            period: cycle.period,
            x1: cycle.displacement.into(),
            x2: cycle.velocity.into(),
            multiplier: cycle.multiplier,
        }
    }
}

impl From<SlipCycle> for StabilityResult {
    fn from(cycle: SlipCycle) -> Self {
        Self {
            stable: cycle.is_stable(),
            multiplier: cycle.multiplier,
            separates: None,
            period: cycle.period,
            beyond_exit: None,
            x1: cycle.displacement.into(),
            x2: cycle.velocity.into(),
        }
    }
}

impl From<CrossingCycle> for StabilityResult {
    fn from(cycle: CrossingCycle) -> Self {
        Self {
            stable: cycle.is_stable(),
            multiplier: cycle.multiplier,
            separates: None,
            period: cycle.period,
            beyond_exit: Some(cycle.beyond_exit),
            x1: cycle.displacement.into(),
            x2: cycle.velocity.into(),
        }
    }
}

impl From<StickSlipCycle> for StabilityResult {
    fn from(cycle: StickSlipCycle) -> Self {
        Self {
            stable: true,
            multiplier: 0.0,
            separates: None,
            period: cycle.period,
            beyond_exit: None,
            x1: cycle.displacement.into(),
            x2: cycle.velocity.into(),
        }
    }
}

impl AllCycles {
    fn of(dynamics: Dynamics, count: SlipCount, fate: &Fate) -> Self {
        let number = dynamics.slip.len();
        let slip = dynamics.slip.into_iter().enumerate().map(|(i, cycle)| StabilityResult {
            separates: (!cycle.is_stable()).then(|| separates(i, number, fate).map(Neighbour::name)),
            ..cycle.into()
        });
        let crossings = dynamics.crossing.len();
        let crossing = dynamics.crossing.into_iter().enumerate().map(|(i, cycle)| StabilityResult {
            separates: (!cycle.is_stable())
                .then(|| crossing_separates(i, crossings, number, fate).map(Neighbour::name)),
            ..cycle.into()
        });
        Self {
            stick_slip: dynamics.stick_slip.map(Into::into),
            slip: slip.collect(),
            slip_count: SlipCountResult {
                proved: count.exact(),
                at_least: count.at_least,
                at_most: count.at_most,
                open: count.open.into_iter().map(Into::into).collect(),
            },
            crossing: crossing.collect(),
        }
    }
}

impl MachineResult {
    /// Converts the behaviour of `machine`.
    #[must_use]
    pub fn new(machine: &Machine, behaviour: &Behaviour) -> Self {
        let units = machine.units();
        let [slip_time, stick_time] =
            behaviour.slip_and_stick_time.map_or([None; 2], |times| times.map(Some));
        Self {
            motion: machine.motion.name(),
            belt_speed: machine.belt_speed,
            damping: machine.damping,
            critical_belt_speed: behaviour.critical_belt_speed,
            critical_damping: behaviour.critical_damping,
            critical_damping_ratio: behaviour.critical_damping_ratio,
            damping_ratio: behaviour.damping_ratio,
            natural_frequency: behaviour.natural_frequency,
            regime: behaviour.regime.name(),
            slip_time,
            stick_time,
            amplitude: behaviour.amplitude,
            units: UnitsResult {
                time: units.time,
                length: units.length,
                velocity: units.velocity,
                force: units.force,
            },
        }
    }
}

/// A fate in one word.
pub(crate) fn fate_name(fate: &Fate) -> &'static str {
    match fate {
        Fate::Sticks(_) => "sticks",
        Fate::SpiralsInward => "spirals_inward",
        Fate::CrossesForever => "crosses_forever",
        Fate::TooCloseToCall => "too_close_to_call",
        Fate::Failed(_) => "failed",
    }
}

/// The type of the equilibrium, for instance "unstable focus".
pub(crate) fn equilibrium_type(oscillator: &Oscillator) -> &'static str {
    match oscillator.eigenvalues() {
        Eigenvalues::Complex { re, .. } if re < 0.0 => "stable focus",
        Eigenvalues::Complex { re, .. } if re > 0.0 => "unstable focus",
        Eigenvalues::Complex { .. } => "centre of the linearisation",
        Eigenvalues::Real { slow, .. } if slow < 0.0 => "stable node",
        Eigenvalues::Real { .. } => "unstable node",
    }
}

/// A regime in words.
#[must_use]
pub fn regime_words(regime: Regime) -> &'static str {
    match regime {
        Regime::Equilibrium => "steady slip at the equilibrium is the only attractor",
        Regime::StickSlip => "the stick-slip cycle is the only attractor",
        Regime::Bistable => "the equilibrium and the stick-slip cycle both attract",
        Regime::PureSlip => "a cycle that slips all the time below the belt line is the only attractor",
        Regime::Crossing => "orbits cross the belt line for ever and never stick",
        Regime::Failed => "not determined",
        Regime::PureSlipAndStickSlip => {
            "a cycle that slips all the time and the stick-slip cycle both attract"
        }
        Regime::PureSlipAndEquilibrium => "a cycle that slips all the time and the equilibrium both attract",
        Regime::EquilibriumPureSlipAndStickSlip => {
            "the equilibrium, a cycle that slips all the time and the stick-slip cycle attract"
        }
        Regime::EquilibriumAndCrossing => {
            "the equilibrium attracts, and orbits outside its basin cross the belt line for ever"
        }
        Regime::PureSlipAndCrossing => {
            "a cycle that slips all the time attracts, and orbits outside its basin cross the belt line for ever"
        }
        Regime::EquilibriumPureSlipAndCrossing => {
            "the equilibrium and a cycle that slips all the time attract, and orbits outside their basins cross \
             the belt line for ever"
        }
    }
}

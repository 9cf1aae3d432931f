//! All answers about one parameter point as one typed result: printed by `slipmap probe`, returned to Python.

mod answer;
mod command;
mod result;

pub use crate::method_answer::MethodAnswer;
pub use answer::Answer;
pub use command::{axis_names, command_line, flag};
use result::{
    BasinBoundary, ChangeResult, Complex, CriticalResult, Cycles, Equilibrium, FlowResult, Flows,
    LandingResult, MethodResult, SensitivityResult, SlidingSegment, SlipCountResult, StabilityResult, State,
};
pub use result::{BistableBand, MachineResult, Probe};

use crate::Machine;
use crate::assessment::StandardErrors;
use crate::behaviour::{MachineBehaviour, growth_time};
use slipmap_certify::slip_count::SlipCount;
use slipmap_column::critical::is_known;
use slipmap_column::sensitivity::{NoSensitivity, Sensitivity};
use slipmap_column::slip_cycle::CyclesUnknown;
use slipmap_column::{
    Change, CriticalDamping, Neighbour, NoCriticalDamping, Regime, crossing_separates, separates,
};
use slipmap_model::filippov::{Eigenvalues, Oscillator};
use slipmap_model::flow::{Fate, Flow, Landing};
use slipmap_model::friction::Law;
use slipmap_orbits::Cycle;

/// The reason why a regime is not known where every cycle was found.
const MAY_HAVE_MORE: &str = "within the error of the closed orbits there may be further slip cycles";

impl Probe {
    /// The whole result, with the flow of the engine `direct`. Takes much longer than [`Answer::of`]: the
    /// limits in eps need a few hundred orbits.
    #[must_use]
    pub fn new(answer: &Answer, direct: &Flow) -> Self {
        let oscillator = &answer.oscillator;
        let methods = answer.methods.iter().zip(answer.limits(false)).map(|(of_method, limit)| {
            let result = MethodResult {
                verdict: of_method.verdict.name(),
                margin: of_method.margin,
                critical_c: of_method.critical_c,
                critical_c_error: of_method.critical_c_error,
                guarantee: of_method.method.guarantee().name(),
                equation: of_method.method.equation_for(&answer.law),
                reason: of_method.reason.clone(),
                epsilon_limit: Some(limit.value()).filter(|limit| !limit.is_nan()),
                epsilon_limit_reason: limit.unknown().map(|why| why.to_string()),
            };
            (of_method.method.name(), result)
        });
        let cycles = Cycles::of(answer);
        let known = answer.known_of_regime();
        Self {
            law: answer.law.name(),
            point: answer.law.coordinates(&answer.point),
            tolerance: answer.tolerance,
            methods: methods.collect(),
            flow: Flows { arcs: (&answer.told).into(), direct: direct.into() },
            critical_c: (&answer.critical).into(),
            sensitivity: SensitivityResult::of(&answer.law, answer.sensitivity()),
            regime: answer.regime.name(),
            regime_reason: (answer.contradiction.clone())
                .or_else(|| cycles.reason.clone().filter(|_| known.is_some()))
                .or_else(|| (answer.regime == Regime::Failed).then(|| MAY_HAVE_MORE.to_owned())),
            regime_known: known,
            equilibrium: Equilibrium::of(oscillator),
            sliding_segment: SlidingSegment {
                from_x1: oscillator.upper_tangency_x1(),
                to_x1: oscillator.exit_x1(),
                x2: oscillator.belt_speed,
            },
            exit_point: State { x1: oscillator.exit_x1(), x2: oscillator.belt_speed },
            landing: answer.flow.landing().map(Into::into),
            changes: answer.changes().iter().map(|change| ChangeResult::of(change, answer)).collect(),
            bistable_band: answer.bistable_band(),
            attracting_cycle: answer.cycle,
            basin_boundary: answer.basin.map(
                |slipmap_column::BasinBoundary { cycle, kick, separates, .. }| BasinBoundary {
                    separates: separates.map(Neighbour::name),
                    cycle: cycle.map(|cycle| StabilityResult {
                        separates: Some(separates.map(Neighbour::name)),
                        ..cycle.into()
                    }),
                    kick,
                },
            ),
            cycles,
            machine: None,
        }
    }
}

impl SensitivityResult {
    fn of(law: &Law, found: Result<Sensitivity, NoSensitivity>) -> Self {
        match found {
            Ok(found) => Self {
                derivatives: found.named(law).collect(),
                standard_error: found.standard_error,
                reason: None,
            },
            Err(why) => Self { derivatives: Vec::new(), standard_error: None, reason: Some(why.to_string()) },
        }
    }
}

impl ChangeResult {
    fn of(change: &Change, answer: &Answer) -> Self {
        let c = |viscous: f64| viscous / answer.point.epsilon;
        let [low, high] = change.between.map(c);
        Self {
            kind: change.kind.name(),
            c: is_known(c(change.viscous), 0.5 * (high - low)).then(|| c(change.viscous)),
            at_least: low,
            at_most: Some(high).filter(|high| high.is_finite()),
            reason: change.failure.map(|failure| failure.to_string()),
        }
    }
}

impl From<&Flow> for FlowResult {
    fn from(flow: &Flow) -> Self {
        Self {
            fate: fate_name(&flow.fate),
            verdict: slipmap_column::Verdict::from(&flow.fate).name(),
            margin: flow.margin,
            margin_error: flow.margin_error,
            rhs: flow.rhs,
            landing: flow.landing().map(Into::into),
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
                let known = root.known();
                Self {
                    value: known.ok().map(|root| root.c),
                    error: Some(root.error),
                    rhs: Some(root.rhs),
                    reason: known.err().map(|why| why.to_string()),
                }
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
            divergence: oscillator.equilibrium_divergence(),
            kind: equilibrium_type(oscillator),
            eigenvalues: match oscillator.eigenvalues() {
                Eigenvalues::Complex { re, im } => [Complex { re, im: -im }, Complex { re, im }],
                Eigenvalues::Real { slow, fast } => {
                    [Complex { re: slow, im: 0.0 }, Complex { re: fast, im: 0.0 }]
                }
            },
            growth_time: growth_time(oscillator),
        }
    }
}

impl From<Cycle> for StabilityResult {
    fn from(cycle: Cycle) -> Self {
        let Cycle { period, displacement: x1, velocity: x2, multiplier, beyond_exit } = cycle;
        Self { stable: cycle.is_stable(), multiplier, separates: None, period, beyond_exit, x1, x2 }
    }
}

impl Cycles {
    fn of(answer: &Answer) -> Self {
        let (stick_slip, slip, crossing) =
            (answer.stick_slip_cycle(), answer.slip.clone(), answer.crossing_cycles());
        let no_stick_slip = match answer.flow.fate {
            Fate::Failed(why) => Some(why),
            _ => stick_slip.as_ref().err().copied(),
        };
        let reasons = [
            ("stick-slip cycle", no_stick_slip.map(CyclesUnknown::Orbit)),
            ("slip cycles", slip.as_ref().err().copied()),
            ("crossing cycles", crossing.unknown),
        ];
        let reasons = reasons
            .into_iter()
            .filter_map(|(which, why)| Some(format!("{which}: {}", answer.why_unknown(why?))));
        let reasons: Vec<String> = reasons.chain(answer.left_out()).collect();
        let fate = match answer.flow.fate {
            // The orbit spirals to an attractor that is not known.
            Fate::SpiralsInward if slip.is_err() => Fate::TooCloseToCall,
            fate => fate,
        };
        let number = slip.as_ref().map_or(0, Vec::len);
        let slip = slip.ok().map(|cycles| {
            let cycles = cycles.into_iter().enumerate().map(|(i, cycle)| StabilityResult {
                separates: (!cycle.is_stable()).then(|| separates(i, number, &fate).map(Neighbour::name)),
                ..cycle.into()
            });
            cycles.collect()
        });
        // Of cycles that may have others between them the neighbours are not known.
        let is_complete = crossing.unknown.is_none();
        let crossings = crossing.cycles.len();
        let cycles = crossing.cycles.into_iter().enumerate().map(|(i, cycle)| StabilityResult {
            separates: (is_complete && !cycle.is_stable())
                .then(|| crossing_separates(i, crossings, number, &fate).map(Neighbour::name)),
            ..cycle.into()
        });
        let crossing: Vec<StabilityResult> = cycles.collect();
        Self {
            stick_slip: stick_slip.ok().flatten().map(Into::into),
            slip,
            slip_count: answer.slip_count().into(),
            crossing: (is_complete || !crossing.is_empty()).then_some(crossing),
            reason: (!reasons.is_empty()).then(|| reasons.join("; ")),
        }
    }
}

impl From<&SlipCount> for SlipCountResult {
    fn from(count: &SlipCount) -> Self {
        let SlipCount { at_least, at_most, ref open } = *count;
        Self { proved: count.exact(), at_least, at_most, open: open.clone() }
    }
}

impl MachineResult {
    /// Converts the behaviour of `machine`; the `errors` of its friction may leave its regime open.
    #[must_use]
    pub fn new(machine: &Machine, behaviour: &MachineBehaviour, errors: Option<&StandardErrors>) -> Self {
        let [slip_time, stick_time] =
            behaviour.slip_and_stick_time.map_or([None; 2], |times| times.map(Some));
        Self {
            motion: machine.motion.name(),
            belt_speed: machine.belt_speed,
            damping: machine.damping,
            critical_belt_speed: behaviour.critical_belt_speed.value(),
            critical_damping: behaviour.critical_damping,
            critical_damping_error: behaviour.critical_damping_error,
            critical_damping_ratio: behaviour.critical_damping_ratio,
            damping_ratio: behaviour.damping_ratio,
            natural_frequency: behaviour.natural_frequency,
            regime: behaviour.regime.name(),
            critical_damping_standard_error: errors
                .and_then(|errors| errors.critical_damping)
                .map(|critical| critical.standard_error),
            regimes_left_open_by_data: errors
                .map(|errors| errors.leave_open(machine.damping, behaviour.regime).names()),
            slip_time,
            stick_time,
            growth_time: behaviour.growth_time,
            amplitude: behaviour.amplitude,
            needed_slip_speed: behaviour.needed_slip_speed,
            units: machine.units(),
        }
    }
}

/// A fate in one word.
pub fn fate_name(fate: &Fate) -> &'static str {
    match fate {
        Fate::Sticks(_) => "sticks",
        Fate::SpiralsInward => "spirals_inward",
        Fate::CrossesForever => "crosses_forever",
        Fate::TooCloseToCall => "too_close_to_call",
        Fate::Failed(_) => "failed",
    }
}

/// The type of the equilibrium, for instance "unstable focus"; a centre where it is neutral.
pub fn equilibrium_type(oscillator: &Oscillator) -> &'static str {
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
        Regime::Neutral => "steady slip neither attracts nor repels: its divergence is 0 within rounding",
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
        Regime::StickSlipAndCrossing => {
            "the stick-slip cycle attracts, and orbits far outside cross the belt line for ever"
        }
        Regime::EquilibriumStickSlipAndCrossing => {
            "the equilibrium and the stick-slip cycle attract, and orbits far outside cross the belt line for ever"
        }
        Regime::PureSlipStickSlipAndCrossing => {
            "a cycle that slips all the time and the stick-slip cycle attract, and orbits far outside cross the \
             belt line for ever"
        }
        Regime::EquilibriumPureSlipStickSlipAndCrossing => {
            "the equilibrium, a cycle that slips all the time and the stick-slip cycle attract, and orbits far \
             outside cross the belt line for ever"
        }
    }
}

//! The typed result about one point: its parts and their serialisation.

use std::borrow::Cow;
use std::collections::BTreeMap;

use serde::Serialize as _;

use crate::Units;
use slipmap_column::sensitivity::Estimate;
use slipmap_column::slip_cycle::Kick;
use slipmap_model::friction::Range;
use slipmap_orbits::Cycle;

/// All answers about one point; `slipmap probe --json` prints its serialised form.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Probe {
    pub(crate) law: &'static str,
    /// Each axis of the law with its value, in the order of a map's dimensions.
    #[serde(serialize_with = "as_map")]
    #[schemars(with = "BTreeMap<&str, f64>")]
    pub(crate) point: Vec<(&'static str, f64)>,
    /// Requested bound on the error of the scaled grazing margin m / V of the simulation.
    pub(crate) tolerance: f64,
    #[serde(serialize_with = "as_map")]
    #[schemars(with = "BTreeMap<&str, MethodResult>")]
    pub(crate) methods: Vec<(&'static str, MethodResult)>,
    /// The orbit from the exit point by both engines.
    pub(crate) flow: Flows,
    pub(crate) critical_c: CriticalResult,
    pub(crate) sensitivity: SensitivityResult,
    /// Name of the long-run behaviour.
    pub(crate) regime: &'static str,
    /// What is known of a regime that is not determined in full.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) regime_known: Option<String>,
    /// Reason why the rest of it is not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) regime_reason: Option<String>,
    /// The state of steady slip.
    pub(crate) equilibrium: Equilibrium,
    /// The segment on which the mass can stick.
    pub(crate) sliding_segment: SlidingSegment,
    /// The point at which every sticking orbit leaves the belt.
    pub(crate) exit_point: State,
    /// Place and times of sticking again, for the orbit from the exit point.
    pub(crate) landing: Option<LandingResult>,
    /// The dampings c > 0 at which the behaviour changes at this belt speed, by growing damping.
    pub(crate) changes: Vec<ChangeResult>,
    /// The dampings between which steady slip and stick-slip both attract.
    pub(crate) bistable_band: Option<BistableBand>,
    pub(crate) attracting_cycle: Option<Cycle>,
    pub(crate) basin_boundary: Option<BasinBoundary>,
    /// All cycles, with their stability.
    pub(crate) cycles: Cycles,
    /// Behaviour of the machine, in SI units; only if one was given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub machine: Option<MachineResult>,
}

#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct MethodResult {
    /// "present", "absent", "undecided" or "failed".
    pub(crate) verdict: &'static str,
    /// Signed distance in c to the edge of presence, -infinity where the method claims none;
    /// NaN where there is none.
    #[serde(serialize_with = "with_infinities")]
    #[schemars(with = "Option<f64>")]
    pub(crate) margin: f64,
    /// The edge of presence in c; `None` where there is none at c >= 0, or none that is known to 1 %.
    pub(crate) critical_c: Option<f64>,
    /// Estimate of its absolute error; `None` for methods whose edge is exact to rounding.
    #[serde(serialize_with = "with_infinities")]
    pub(crate) critical_c_error: Option<f64>,
    pub(crate) guarantee: &'static str,
    /// Equation in the paper, or section of the theory pages.
    pub(crate) equation: Cow<'static, str>,
    /// Reason why the verdict is neither presence nor absence, or what it follows from where that is not the claim
    /// with this edge.
    pub(crate) reason: Option<String>,
    /// Largest epsilon up to which the verdict equals the simulated one; infinite as far as was looked, null where it is unknown.
    #[serde(serialize_with = "with_infinities")]
    pub(crate) epsilon_limit: Option<f64>,
    /// Reason why that limit is not known.
    pub(crate) epsilon_limit_reason: Option<String>,
}

/// The orbit from the exit point by both engines.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct Flows {
    pub(crate) arcs: FlowResult,
    /// By integration in (x1, x2).
    pub(crate) direct: FlowResult,
}

/// The orbit from the exit point by one engine.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct FlowResult {
    /// "sticks", "spirals_inward", "crosses_forever", "too_close_to_call" or "failed".
    pub(crate) fate: &'static str,
    /// The verdict that follows from this fate.
    pub(crate) verdict: &'static str,
    /// The scaled grazing margin m / V; NaN where the flow has none.
    #[schemars(with = "Option<f64>")]
    pub(crate) margin: f64,
    /// Estimate of the absolute error of `margin`; NaN where there is none.
    #[serde(serialize_with = "with_infinities")]
    #[schemars(with = "Option<f64>")]
    pub(crate) margin_error: f64,
    /// Evaluations of the right-hand side.
    pub(crate) rhs: u64,
    /// Place and times of sticking.
    pub(crate) landing: Option<LandingResult>,
    /// Reason why there is no answer.
    pub(crate) reason: Option<String>,
}

/// Place and times of sticking.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct LandingResult {
    /// x1 at which the mass begins to stick.
    pub(crate) x1: f64,
    pub(crate) slip_time: f64,
    pub(crate) stick_time: f64,
    /// Sum of slip time and stick time.
    pub(crate) period: f64,
    /// Crossings of the belt line before the mass sticks; `None` where the landing is within its error of
    /// the end of the stick segment.
    pub(crate) crossings: Option<u32>,
}

/// The critical damping of a column.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct CriticalResult {
    /// c*; negative where no legal damping is small enough for a cycle. `None` where it is not known to 1 %.
    pub(crate) value: Option<f64>,
    /// Estimate of the absolute error, also of a c* that is not known to 1 %.
    #[serde(serialize_with = "with_infinities")]
    pub(crate) error: Option<f64>,
    /// Evaluations of the right-hand side.
    pub(crate) rhs: Option<u64>,
    /// Reason why there is none.
    pub(crate) reason: Option<String>,
}

/// Derivatives of the critical damping.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct SensitivityResult {
    /// By each axis but the damping, in the order of a map's dimensions; empty if they are unknown.
    #[serde(serialize_with = "as_map")]
    #[schemars(with = "BTreeMap<&str, Estimate>")]
    pub(crate) derivatives: Vec<(&'static str, Estimate)>,
    /// The standard error of the critical damping, of a table with standard errors.
    pub(crate) standard_error: Option<Estimate>,
    /// Reason why there are none.
    pub(crate) reason: Option<String>,
}

/// The state of steady slip.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct Equilibrium {
    pub(crate) x1: f64,
    /// Velocity, 0.
    pub(crate) x2: f64,
    pub(crate) divergence: f64,
    /// Type, for instance "unstable focus".
    #[serde(rename = "type")]
    pub(crate) kind: &'static str,
    pub(crate) eigenvalues: [Complex; 2],
    /// Time in which small disturbances grow by the factor e, where it is unstable.
    pub(crate) growth_time: Option<f64>,
}

#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct Complex {
    pub(crate) re: f64,
    pub(crate) im: f64,
}

/// The stick segment: from_x1 < x1 < to_x1 on the line x2.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct SlidingSegment {
    /// The end at which the upper field is tangent.
    pub(crate) from_x1: f64,
    /// The exit point.
    pub(crate) to_x1: f64,
    pub(crate) x2: f64,
}

#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct State {
    pub(crate) x1: f64,
    /// Velocity.
    pub(crate) x2: f64,
}

/// A damping at which the behaviour changes.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct ChangeResult {
    /// "hopf", "fold", "unresolved", "grazing", "return" (the critical damping), "crossing" or "far_crossing".
    pub(crate) kind: &'static str,
    /// The damping; `None` where it is not known to 1 %.
    pub(crate) c: Option<f64>,
    /// Bounds of it; the upper one `None` where none is known.
    pub(crate) at_least: f64,
    /// See `at_least`.
    pub(crate) at_most: Option<f64>,
    /// Reason why the bounds are far apart, where orbits between them cannot be followed.
    pub(crate) reason: Option<String>,
}

/// The dampings c >= 0 between which steady slip and stick-slip both attract.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct BistableBand {
    /// Damping above which the equilibrium is stable and the orbit from the exit point sticks; `None` where it is not
    /// known to 1 %.
    pub from_c: Option<f64>,
    /// Bounds of that damping.
    pub from_c_between: [f64; 2],
    /// Reason why it is not known.
    pub from_c_reason: Option<String>,
    /// The critical damping.
    pub to_c: f64,
    /// Estimate of the absolute error of `to_c`.
    pub error: f64,
}

/// A cycle with its stability.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct StabilityResult {
    /// Whether it attracts.
    pub(crate) stable: bool,
    /// Floquet multiplier; 0 if it sticks, infinite above the largest double.
    #[serde(serialize_with = "with_infinities")]
    pub(crate) multiplier: f64,
    /// For a repelling cycle: the attractors of the orbits just inside it and just outside it,
    /// "equilibrium", "slip_cycle", "stick_slip", "crossing" or "unknown".
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) separates: Option<[&'static str; 2]>,
    pub(crate) period: f64,
    /// For a cycle that crosses the belt line: x1 at which it crosses downward, less that of the exit
    /// point.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) beyond_exit: Option<f64>,
    /// Positions on it.
    pub(crate) x1: Range,
    /// Velocities on it.
    pub(crate) x2: Range,
}

/// The edge of a basin, and the kicks of steady slip onto it.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct BasinBoundary {
    /// The attractors of orbits just inside it and just outside it.
    pub(crate) separates: [&'static str; 2],
    /// The outermost unstable slip cycle; `None` where the edge is the grazing orbit, which a drop of
    /// friction makes one.
    pub(crate) cycle: Option<StabilityResult>,
    pub kick: Kick,
}

/// All cycles; `None` for those of a kind that could not be followed.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct Cycles {
    /// `None` also where there is none.
    pub(crate) stick_slip: Option<StabilityResult>,
    /// Cycles below the belt line, by growing amplitude.
    pub(crate) slip: Option<Vec<StabilityResult>>,
    /// Bounds on their number.
    pub(crate) slip_count: SlipCountResult,
    /// Cycles that cross the belt line, by growing size: those that are certain where `reason` says that there may be
    /// others.
    pub(crate) crossing: Option<Vec<StabilityResult>>,
    /// Reason why some kinds could not be followed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) reason: Option<String>,
}

/// Proved bounds on the number of slip cycles.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub(crate) struct SlipCountResult {
    /// The number, where it is proved.
    pub(crate) proved: Option<u32>,
    pub(crate) at_least: u32,
    /// Upper bound; `None` where there is none.
    pub(crate) at_most: Option<u32>,
    /// Ranges of the maximum of x2 in which nothing is proved.
    pub(crate) open: Vec<Range>,
}

/// Behaviour of a machine, in SI units (for a rotation: rad for m, N m for N, kg m^2 for kg).
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct MachineResult {
    /// "translation" or "rotation".
    pub(crate) motion: &'static str,
    /// Belt speed, m/s.
    pub(crate) belt_speed: f64,
    /// Damping coefficient, N s/m.
    pub(crate) damping: f64,
    /// Belt speed above which the mass does not come back to the belt, m/s.
    pub(crate) critical_belt_speed: Option<f64>,
    /// Damping coefficient above which the same holds, N s/m; `None` where none is positive, or known to 1 %.
    pub(crate) critical_damping: Option<f64>,
    /// Estimate of its absolute error, N s/m, also of one that is not known to 1 %.
    #[serde(serialize_with = "with_infinities")]
    pub(crate) critical_damping_error: Option<f64>,
    /// Its standard error by measured or fitted friction, N s/m; absent for friction without errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) critical_damping_standard_error: Option<f64>,
    /// The critical damping as a damping ratio.
    pub(crate) critical_damping_ratio: Option<f64>,
    /// Damping ratio d / (2 sqrt(k m)).
    pub(crate) damping_ratio: f64,
    /// Undamped natural frequency, Hz.
    pub(crate) natural_frequency: f64,
    /// Name of the long-run behaviour.
    pub(crate) regime: &'static str,
    /// The regimes that are possible within two standard errors of the friction, that of its nominal values first;
    /// none where the data decide. Absent for friction without errors.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(crate) regimes_left_open_by_data: Option<Vec<&'static str>>,
    /// Slip time of the stick-slip cycle, s.
    pub(crate) slip_time: Option<f64>,
    /// Stick time of the stick-slip cycle, s.
    pub(crate) stick_time: Option<f64>,
    /// Time in which disturbances of unstable steady slip grow by the factor e, s.
    pub(crate) growth_time: Option<f64>,
    /// Half the distance between the extremes of x of the attracting cycle, m.
    pub(crate) amplitude: Option<f64>,
    /// Slip speed up to which measured friction should be known, m/s, where the orbit leaves the data.
    pub(crate) needed_slip_speed: Option<f64>,
    /// The units of the dimensionless oscillator.
    pub(crate) units: Units,
}

/// Pairs as a map, in their order.
fn as_map<T: serde::Serialize, S: serde::Serializer>(
    pairs: &[(&'static str, T)],
    serializer: S,
) -> Result<S::Ok, S::Error> {
    serializer.collect_map(pairs.iter().map(|(name, value)| (name, value)))
}

/// Serialises a number that may be infinite: JSON has no infinity, which is the text "inf" or "-inf".
fn with_infinities<T: Copy + Into<Option<f64>>, S: serde::Serializer>(
    number: &T,
    serializer: S,
) -> Result<S::Ok, S::Error> {
    match (*number).into() {
        Some(x) if x.is_infinite() => serializer.collect_str(&x),
        number => number.serialize(serializer),
    }
}

//! The behaviour of a machine at its working point, in SI units.

use crate::Model;
pub use crate::intervals::Limit;
use crate::intervals::{Intervals, of_stick_slip};
use slipmap_column::{CriticalDamping, End, LongRun, NoCriticalDamping, Regime, critical_damping};
use slipmap_model::filippov::{Eigenvalues, HopfRate, Oscillator};
use slipmap_model::flow::{Fate, Flow};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::Point;
use slipmap_orbits::{Cycle, Effort, flow, flow_with};
use slipmap_witness::{Start, trace};

/// The behaviour of a machine, in SI units; for a rotation rad replaces m and N m replaces N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MachineBehaviour {
    /// Undamped natural frequency, Hz.
    pub natural_frequency: f64,
    /// Damping ratio d / (2 sqrt(k m)).
    pub damping_ratio: f64,
    /// Critical belt speed, m/s: above it a mass that leaves the belt does not return to it. It is the end of the
    /// highest interval of belt speeds at which the machine may stick-slip, among the speeds that are tried; these do
    /// not depend on the working point.
    pub critical_belt_speed: Limit,
    /// Critical damping coefficient, N s/m: above it a mass that leaves the belt does not return to it.
    /// `None` if no damping is needed, or none is known to 1 %.
    pub critical_damping: Option<f64>,
    /// Whether the critical damping is known to 1 %, or known not to be needed.
    pub critical_damping_is_known: bool,
    /// Estimate of the absolute error of the critical damping, N s/m, also of one that is not known to 1 %.
    pub critical_damping_error: Option<f64>,
    /// Damping ratio of the critical damping.
    pub critical_damping_ratio: Option<f64>,
    /// Long-run behaviour.
    pub regime: Regime,
    /// Slip and stick time of the stick-slip cycle, s.
    pub slip_and_stick_time: Option<[f64; 2]>,
    /// Time in which small disturbances of steady slip grow by the factor e, s; `None` unless it is unstable.
    pub growth_time: Option<f64>,
    /// Half the distance between the extremes of x, m, on the stick-slip cycle, or else on the largest stable
    /// slip cycle.
    pub amplitude: Option<f64>,
    /// Slip speed up to which measured friction should be known, m/s, if the orbit leaves the data.
    pub needed_slip_speed: Option<f64>,
}

/// Tolerance of orbits of friction that is continued beyond its data.
const CONTINUED: f64 = 1e-6;

/// The slip speed u up to which a measured law should be known, to some per cent, if the friction continues
/// in a straight line; `None` for other laws, and if the orbit from the exit point stays within the data.
pub(crate) fn needed_slip_speed(law: &Law, point: &Point) -> Option<f64> {
    /// Ratio of the estimate to the largest slip speed on that orbit.
    const ROOM: f64 = 1.05;
    let Law::Table(table) = law else { return None };
    let continued = Law::Table(table.continued(8.0 * table.fastest())?);
    let oscillator = Oscillator::new(&continued, point);
    let orbit = trace(&oscillator, Start::ExitPoint, CONTINUED, 2.0 * std::f64::consts::TAU);
    let fastest = orbit.samples.iter().map(|state| (point.belt_speed - state.x2).abs()).fold(0.0, f64::max);
    (fastest > table.fastest()).then_some(ROOM * fastest)
}

/// How far a measured law should be known, as [`needed_slip_speed`], for the highest belt speed at which the stick-slip
/// cycle attracts, where orbits of belts faster than `from` leave the data; `attracts` is whether it does at `from`, else
/// it is tried. `None` where the orbits of faster belts stay within the data, and where the cycle does not attract there or
/// does at any speed if the friction continues in a straight line.
pub(crate) fn needed_for_stick_slip(law: &Law, point: &Point, from: f64, attracts: bool) -> Option<f64> {
    const FARTHER: f64 = 1.05;
    const TRIED: i32 = 60;
    let Law::Table(table) = law else { return None };
    let continued = Law::Table(table.continued(8.0 * table.fastest())?);
    let at = |belt_speed: f64| Point { belt_speed, ..*point };
    let sticks = |speed: &f64| {
        matches!(
            flow_with(Effort::Small, &Oscillator::new(&continued, &at(*speed)), CONTINUED).fate,
            Fate::Sticks(_)
        )
    };
    if !(attracts || sticks(&from)) {
        return None;
    }
    let limit = (1..TRIED).map(|i| from * FARTHER.powi(i)).find(|speed| !sticks(speed))?;
    needed_slip_speed(law, &at(limit))
}

/// The time in which small disturbances of steady slip grow by the factor e: 1 / Re(lambda) of the fastest
/// growing part, which almost all disturbances have. `None` where they decay, and where the divergence is not
/// distinguishable from 0.
///
/// A disturbance of velocity a reaches the belt speed V after about ln(V / a) such times (theory, "Any friction law").
pub fn growth_time(oscillator: &Oscillator) -> Option<f64> {
    let rate = match oscillator.eigenvalues() {
        Eigenvalues::Complex { re, .. } => re,
        Eigenvalues::Real { fast, .. } => fast,
    };
    (rate > 0.0).then(|| rate.recip())
}

/// Returns whether a critical damping c* is positive and distinguishable from 0.
pub(crate) fn is_positive(column: &Column, critical: f64) -> bool {
    critical > 0.0 && column.epsilon * critical > HopfRate::new(&column.curve, column.belt_speed).rounding()
}

/// Computes the behaviour of a machine.
#[must_use]
pub fn behaviour(model: &Model, tolerance: f64) -> MachineBehaviour {
    let oscillator = Oscillator::new(&model.law, &model.point);
    let flow = flow(&oscillator, tolerance);
    let long_run = slipmap_column::long_run(&oscillator, &flow, tolerance);
    with_speeds(model, &flow, &long_run, tolerance).0
}

/// The behaviour with this flow and in the long run, and the belt speeds V at which the stick-slip cycle attracts.
pub(crate) fn with_speeds(
    model: &Model,
    flow: &Flow,
    long_run: &LongRun,
    tolerance: f64,
) -> (MachineBehaviour, Intervals) {
    let Model { law, point, si: units } = model;
    let oscillator = Oscillator::new(law, point);
    let half = |range: slipmap_model::friction::Range| 0.5 * (range.hi - range.lo) * units.length;
    let stick_slip = long_run.cycle.filter(|_| End::of(flow) == End::Sticks);
    let slip = || long_run.slip.as_ref().ok()?.iter().copied().rfind(Cycle::is_stable);
    let amplitude = stick_slip.or_else(slip).map(|cycle| half(cycle.displacement));
    let column = model.column();
    let root = critical_damping(&column, tolerance);
    let known = root.and_then(CriticalDamping::known);
    let critical = known.ok().filter(|root| is_positive(&column, root.c));
    let times = flow.landing().map(|landing| [landing.slip_time, landing.stick_time]);
    let speeds = of_stick_slip(law, point);
    let behaviour = MachineBehaviour {
        natural_frequency: 1.0 / (std::f64::consts::TAU * units.time),
        damping_ratio: 0.5 * point.damping,
        critical_belt_speed: speeds.highest().times(units.velocity),
        critical_damping: critical.map(|root| root.c * units.damping),
        critical_damping_is_known: known.is_ok(),
        critical_damping_error: match known {
            Ok(_) => critical.map(|root| root.error * units.damping),
            Err(NoCriticalDamping::Inaccurate { error }) => Some(error * units.damping),
            Err(
                NoCriticalDamping::NotFollowed | NoCriticalDamping::Quota | NoCriticalDamping::Contradicted,
            ) => None,
        },
        critical_damping_ratio: critical.map(|root| 0.5 * root.c),
        regime: long_run.regime,
        slip_and_stick_time: times.map(|times| times.map(|time| time * units.time)),
        growth_time: growth_time(&oscillator).map(|time| time * units.time),
        amplitude,
        needed_slip_speed: match flow.fate {
            Fate::Failed(_) => needed_slip_speed(law, point).map(|speed| speed * units.velocity),
            Fate::Sticks(_) | Fate::SpiralsInward | Fate::CrossesForever | Fate::TooCloseToCall => None,
        },
    };
    (behaviour, speeds)
}

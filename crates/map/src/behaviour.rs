//! The behaviour of a machine at its working point, in SI units.

use crate::machine::Model;
use crate::map::{Regime, regime};
use slipmap_model::filippov::{Eigenvalues, HopfRate, Oscillator};
use slipmap_model::friction::{Column, Curve, Law, NOTHING};
use slipmap_model::point::Point;
use slipmap_simulate::crossing::stick_slip_cycle;
use slipmap_simulate::slip_cycle::slip_cycles;
use slipmap_simulate::{CriticalDamping, Fate, NoCriticalDamping, critical_damping, exceeds, flow};
use slipmap_witness::{Start, trace};

/// A limit of a quantity, below which a statement holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// It is unknown whether the statement holds at the values that were tried.
    NotDetermined,
    /// There is none: the statement fails at all values that were tried, up to this one.
    NoneUpTo(f64),
    /// The limit.
    Below(f64),
    /// The limit lies between these two values: it is unknown whether the statement holds between them.
    Between(f64, f64),
    /// The limit is at least this value; what holds beyond it is unknown, or was not tried.
    AtLeast(f64),
}

/// Relative width of a bracket of a limit that is told as one number: four digits are printed.
pub(crate) const SAME: f64 = 1e-5;

impl Limit {
    /// The limit; `None` unless it was found.
    #[must_use]
    pub fn value(self) -> Option<f64> {
        match self {
            Limit::Below(value) => Some(value),
            Limit::NotDetermined | Limit::NoneUpTo(_) | Limit::AtLeast(_) | Limit::Between(..) => None,
        }
    }

    /// The limit within this bracket.
    pub(crate) fn within([low, high]: [f64; 2]) -> Self {
        match high - low <= SAME * high {
            true => Limit::Below(0.5 * (low + high)),
            false => Limit::Between(low, high),
        }
    }

    /// The limit times `unit`, the factor to another unit.
    pub(crate) fn times(self, unit: f64) -> Self {
        match self {
            Limit::Below(value) => Limit::Below(value * unit),
            Limit::NoneUpTo(value) => Limit::NoneUpTo(value * unit),
            Limit::AtLeast(value) => Limit::AtLeast(value * unit),
            Limit::Between(low, high) => Limit::Between(low * unit, high * unit),
            Limit::NotDetermined => self,
        }
    }
}

/// The behaviour of a machine, in SI units; for a rotation rad replaces m and N m replaces N.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Behaviour {
    /// Undamped natural frequency, Hz.
    pub natural_frequency: f64,
    /// Damping ratio d / (2 sqrt(k m)).
    pub damping_ratio: f64,
    /// Critical belt speed, m/s: above it a mass that leaves the belt does not return to it. It is the
    /// highest such limit among the speeds that are tried; these do not depend on the working point.
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

/// Number of belt speeds per factor of ten at which the critical damping is tested. Friction that rises and
/// falls several times has windows of speeds: of 58 random wavy laws, 4 had one between speeds eight per
/// factor of ten.
const CRITICAL_PER_DECADE: i32 = 32;
/// Number of factors of ten by which the belt speeds that are tried reach beyond the velocities of the
/// machine.
const DECADES: f64 = 3.0;

/// Slip speeds u at which the friction of a law is examined, up to its last one.
fn slip_speeds(curve: &Curve) -> impl DoubleEndedIterator<Item = f64> {
    const PER_DECADE: i32 = 8;
    const EXTENT: i32 = 6;
    let speeds = (-EXTENT * PER_DECADE..=EXTENT * PER_DECADE).map(|i| speed_of(i, PER_DECADE));
    speeds.filter(|u| *u <= curve.fastest())
}

/// The slip speed u at which the friction has fallen by half of its largest fall; 1 if it does not fall.
fn half_fall(curve: &Curve) -> f64 {
    // A formula may be a law up to some slip speed only: friction is positive.
    let onset = 1.0 - curve.drop();
    let falls = slip_speeds(curve).map(|u| (u, onset - curve.phi(u))).take_while(|(_, fall)| *fall < onset);
    let falls: Vec<(f64, f64)> = falls.collect();
    let half = 0.5 * falls.iter().map(|(_, fall)| *fall).fold(0.0, f64::max);
    falls.into_iter().find(|(_, fall)| *fall > 0.0 && *fall >= half).map_or(1.0, |(u, _)| u)
}

/// The slip speed from which on the friction of a law pushes at all others, or is not a number; infinite if
/// there is none.
fn pushes_from(curve: &Curve) -> f64 {
    let resists = |u: f64| curve.phi(u) >= NOTHING;
    let mut pushes = f64::INFINITY;
    for u in slip_speeds(curve).rev() {
        if resists(u) {
            return match pushes.is_finite() {
                true => last_between(u, pushes, |u| Some(resists(u)))[0],
                false => f64::INFINITY,
            };
        }
        pushes = u;
    }
    f64::INFINITY
}

fn speed_of(number: i32, per_decade: i32) -> f64 {
    10f64.powf(f64::from(number) / f64::from(per_decade))
}

/// The belt speeds V that are tried, from the slowest, `per_decade` of them per factor of ten: from a
/// thousandth of the slower to a thousand times the faster of two velocities of the machine, that of the
/// static friction on its mass and spring, V = 1, and that at which its friction falls. A closed orbit
/// reaches about twice the belt speed: data and samples give no answers beyond half their end, and
/// formulas none beyond half the slip speed from which on their friction pushes.
///
/// The speeds do not depend on the belt speed and the damping of the machine, so its limits do not either.
pub(crate) fn belt_speeds(curve: &Curve, per_decade: i32) -> Vec<f64> {
    let fall = half_fall(curve);
    let index = |speed: f64| speed.log10() * f64::from(per_decade);
    let first = (index(fall.min(1.0)) - DECADES * f64::from(per_decade)).floor() as i32;
    let last = (index(fall.max(1.0)) + DECADES * f64::from(per_decade)).ceil() as i32;
    let end = 0.5 * curve.fastest().min(pushes_from(curve));
    let mut speeds: Vec<f64> = (first..=last).map(|i| speed_of(i, per_decade)).collect();
    if speeds.last().is_some_and(|last| *last > end) {
        speeds.retain(|speed| *speed < end);
        speeds.push(end);
    }
    speeds
}

/// By bisection, two values between `low`, where `holds` is true, and `high`, where it is false: it is true at
/// the first, false at the second, and unknown between them unless they nearly agree.
pub(crate) fn last_between(low: f64, high: f64, holds: impl Fn(f64) -> Option<bool>) -> [f64; 2] {
    last_within(1e-12, [low, high], holds)
}

/// As [`last_between`], to within this relative width.
pub(crate) fn last_within(
    width: f64,
    [mut low, mut high]: [f64; 2],
    holds: impl Fn(f64) -> Option<bool>,
) -> [f64; 2] {
    /// Number of bisections for each end of a range in which it is unknown.
    const ROUNDS: u32 = 12;
    while high - low > width * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        match holds(middle) {
            Some(true) => low = middle,
            Some(false) => high = middle,
            None => {
                let [mut from, mut to] = [middle; 2];
                for _ in 0..ROUNDS {
                    let middle = 0.5 * (low + from);
                    *(if holds(middle) == Some(true) { &mut low } else { &mut from }) = middle;
                    let middle = 0.5 * (to + high);
                    *(if holds(middle) == Some(false) { &mut high } else { &mut to }) = middle;
                }
                break;
            }
        }
    }
    [low, high]
}

/// The highest of the increasing `speeds` up to which `holds` is true and beyond which it is false, located
/// between two of them. A speed at which it is unknown counts neither way.
fn highest_belt_speed(speeds: &[f64], holds: impl Fn(f64) -> Option<bool>) -> Limit {
    // The slowest speed from which on `holds` is false at all faster ones.
    let mut fails_from = None;
    // The fastest speed from which on `holds` is false at all slower ones.
    let mut none_up_to = Limit::NotDetermined;
    for &speed in speeds.iter().rev() {
        match (holds(speed), fails_from) {
            (Some(true), Some(high)) => {
                return Limit::within(last_between(speed, high, holds));
            }
            (Some(true), None) => return Limit::AtLeast(speed),
            (Some(false), _) => {
                fails_from = Some(speed);
                if none_up_to == Limit::NotDetermined {
                    none_up_to = Limit::NoneUpTo(speed);
                }
            }
            (None, _) => (fails_from, none_up_to) = (None, Limit::NotDetermined),
        }
    }
    none_up_to
}

/// The highest belt speed V at which c* falls through the point's damping.
fn critical_belt_speed(law: &Law, point: &Point, tolerance: f64) -> Limit {
    let speeds = belt_speeds(&law.column(point).curve, CRITICAL_PER_DECADE);
    highest_belt_speed(&speeds, |belt_speed| {
        let column = law.column(&Point { belt_speed, ..*point });
        exceeds(&column, point.damping, tolerance).ok()
    })
}

/// The slip speed u up to which a measured law should be known, to some per cent, if the friction continues
/// in a straight line; `None` for other laws, and if the orbit from the exit point stays within the data.
pub(crate) fn needed_slip_speed(law: &Law, point: &Point) -> Option<f64> {
    /// Tolerance of the orbit.
    const ACCURACY: f64 = 1e-6;
    /// Ratio of the estimate to the largest slip speed on that orbit.
    const ROOM: f64 = 1.05;
    let Law::Table(table) = law else { return None };
    let continued = Law::Table(table.continued(8.0 * table.fastest())?);
    let oscillator = Oscillator::new(&continued, point);
    let orbit = trace(&oscillator, Start::ExitPoint, ACCURACY, 2.0 * std::f64::consts::TAU);
    let fastest = orbit.samples.iter().map(|state| (point.belt_speed - state.x2).abs()).fold(0.0, f64::max);
    (fastest > table.fastest()).then_some(ROOM * fastest)
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
pub fn behaviour(model: &Model, tolerance: f64) -> Behaviour {
    let Model { law, point, si } = model;
    let units = si.units;
    let oscillator = Oscillator::new(law, point);
    let flow = flow(&oscillator, tolerance);
    let half = |range: slipmap_model::friction::Range| 0.5 * (range.hi - range.lo) * units.length;
    let stick_slip = stick_slip_cycle(&oscillator, &flow, tolerance).ok().flatten();
    let slip = || slip_cycles(&oscillator, tolerance).ok()?.into_iter().rfind(|cycle| cycle.is_stable());
    let amplitude = stick_slip.map(|cycle| half(cycle.displacement));
    let amplitude = amplitude.or_else(|| slip().map(|cycle| half(cycle.displacement)));
    let column = model.column();
    let root = critical_damping(&column, tolerance);
    let known = root.and_then(CriticalDamping::known);
    let critical = known.ok().filter(|root| is_positive(&column, root.c));
    let times = match flow.fate {
        Fate::Sticks(landing) => Some([landing.slip_time * units.time, landing.stick_time * units.time]),
        Fate::SpiralsInward | Fate::CrossesForever | Fate::TooCloseToCall | Fate::Failed(_) => None,
    };
    Behaviour {
        natural_frequency: 1.0 / (std::f64::consts::TAU * units.time),
        damping_ratio: 0.5 * point.damping,
        critical_belt_speed: critical_belt_speed(law, point, tolerance).times(units.velocity),
        critical_damping: critical.map(|root| root.c * units.damping),
        critical_damping_is_known: known.is_ok(),
        critical_damping_error: match known {
            Ok(_) => critical.map(|root| root.error * units.damping),
            Err(NoCriticalDamping::Inaccurate { error }) => Some(error * units.damping),
            Err(NoCriticalDamping::NoVerdict) => None,
        },
        critical_damping_ratio: critical.map(|root| 0.5 * root.c),
        regime: regime(&oscillator, &flow),
        slip_and_stick_time: times,
        growth_time: growth_time(&oscillator).map(|time| time * units.time),
        amplitude,
        needed_slip_speed: match flow.fate {
            Fate::Failed(_) => needed_slip_speed(law, point).map(|speed| speed * units.velocity),
            Fate::Sticks(_) | Fate::SpiralsInward | Fate::CrossesForever | Fate::TooCloseToCall => None,
        },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::{Friction, Machine, example};
    use slipmap_model::friction::{Expression, Table};

    fn does(machine: &Machine) -> Behaviour {
        behaviour(&machine.model().unwrap(), 1e-10)
    }

    fn example_point() -> Point {
        example(Law::Exponential).model().unwrap().point
    }

    /// Friction that rises: the machine stick-slips at no belt speed, as far as the data reach.
    #[test]
    fn a_limit_that_does_not_exist_is_told_from_an_unknown_one() {
        let speeds = belt_speeds(&Law::Exponential.column(&example_point()).curve, CRITICAL_PER_DECADE);
        let (slowest, fastest) = (speeds[0], *speeds.last().unwrap());
        let below = |known: f64, limit: f64| {
            highest_belt_speed(&speeds, |speed| (speed < known).then_some(speed < limit))
        };
        assert_eq!(below(f64::INFINITY, f64::INFINITY), Limit::AtLeast(fastest));
        assert!(matches!(below(f64::INFINITY, 2.0), Limit::Below(at) if (at - 2.0).abs() < 1e-9));
        assert_eq!(below(f64::INFINITY, 0.0), Limit::NoneUpTo(fastest));
        assert!(matches!(below(5.0, 0.0), Limit::NoneUpTo(at) if at < 5.0 && at > 4.0));
        assert!(matches!(below(5.0, f64::INFINITY), Limit::AtLeast(at) if at < 5.0 && at > 4.0));
        assert_eq!(below(0.0, 0.0), Limit::NotDetermined);
        // Unknown at the slowest speed.
        let slow = highest_belt_speed(&speeds, |speed| (speed > slowest).then_some(false));
        assert_eq!(slow, Limit::NotDetermined);
        // Unknown around the limit.
        let gap = highest_belt_speed(&speeds, |speed| (!(0.5..=2.0).contains(&speed)).then_some(speed < 1.0));
        assert!(matches!(gap, Limit::AtLeast(at) if at < 0.5 && at > 0.4), "{gap:?}");
        let data = [0.0, 0.05, 0.1, 0.2, 0.5, 1.2].map(|u| (u, 0.3 + 0.2 * u));
        let friction = Friction::Measured(Table::new("rises", &data, 0.3).unwrap());
        let machine = Machine { friction, belt_speed: 0.2, ..example(Law::Stribeck) };
        let found = does(&machine).critical_belt_speed;
        assert!(matches!(found, Limit::NoneUpTo(speed) if speed > 0.5 && speed <= 0.6), "{found:?}");
        // Friction that falls as far as the data reach: the limit lies beyond half their end.
        let data = data.map(|(u, mu)| (u, 0.6 - mu));
        let friction = Friction::Measured(Table::new("falls", &data, 0.3).unwrap());
        let falls = Machine { friction, damping: 0.0, ..machine };
        let found = does(&falls).critical_belt_speed;
        assert!(matches!(found, Limit::AtLeast(speed) if (speed - 0.6).abs() < 1e-12), "{found:?}");
    }

    /// Friction that falls without end pushes from some slip speed on, which orbits of belts half as fast reach.
    /// Friction that tends to 0 never pushes.
    #[test]
    fn tried_speeds_end_where_orbits_reach_friction_that_pushes() {
        for (phi, end) in [
            ("1 - 0.5*u*exp(-u) - u/16", 8.0),
            // It pushes next to u = 1 as well.
            ("1 - 3*u*exp(-u) - u/50", 25.0),
            ("exp(-u)", 1000.0),
            ("0.5*(1 - u + abs(1 - u))", 1000.0),
        ] {
            let law = Law::Expression(Expression::new(phi, 1.0).unwrap());
            let speeds = belt_speeds(&law.column(&law.point(1.0, &[], 1.0, 0.0).unwrap()).curve, 32);
            let last = speeds[speeds.len() - 1];
            assert!((last / end - 1.0).abs() < 0.1, "{phi}: {last}");
        }
    }

    #[test]
    fn tried_speeds_enclose_the_velocities_of_the_machine() {
        // Friction that falls far below, at, and far above the velocity of its static force.
        for velocity in [1e-4, 1.0, 1e4] {
            let machine = example(Law::Exponential).with("strengthening", 0.0).unwrap();
            let machine = machine.with("stribeck_velocity", velocity).unwrap();
            let model = machine.model().unwrap();
            let speeds = belt_speeds(&model.column().curve, 4);
            let velocity = velocity / model.si.units.velocity;
            let (slowest, fastest) = (speeds[0], speeds[speeds.len() - 1]);
            assert!(slowest <= 1.1e-3 * velocity.min(1.0), "{velocity}: {slowest}");
            assert!(fastest >= 0.8e3 * velocity.max(1.0), "{velocity}: {fastest}");
            assert!(speeds.len() < 2 * 4 * 6 * 2, "{}", speeds.len());
        }
    }

    #[test]
    fn critical_values_are_those_of_the_machine_itself() {
        for law in Law::BUILT_IN {
            let machine = example(law.clone());
            let here = does(&machine);
            let (Some(speed), Some(damping)) = (here.critical_belt_speed.value(), here.critical_damping)
            else {
                continue;
            };
            let sticks = |name: &str, value: f64| {
                let Model { law, point, .. } = machine.with(name, value).unwrap().model().unwrap();
                matches!(flow(&Oscillator::new(&law, &point), 1e-11).fate, Fate::Sticks(_))
            };
            assert!(sticks("belt_speed", speed * (1.0 - 1e-6)), "{law:?}");
            assert!(!sticks("belt_speed", speed * (1.0 + 1e-6)), "{law:?}");
            assert!(sticks("damping", damping * (1.0 - 1e-6)), "{law:?}");
            assert!(!sticks("damping", damping * (1.0 + 1e-6)), "{law:?}");
            let [slip, stick] = here.slip_and_stick_time.unwrap();
            // While it sticks the mass moves with the belt, at most from end to end of its motion.
            assert!(stick * 0.1 <= 2.0 * here.amplitude.unwrap() && slip > 0.0, "{here:?}");
        }
        let stribeck = does(&example(Law::Stribeck));
        assert!(stribeck.critical_belt_speed.value().is_some() && stribeck.critical_damping.is_some());
    }
}

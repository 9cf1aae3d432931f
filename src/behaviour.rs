//! The behaviour of a machine at its working point, in SI units.

use crate::filippov::Oscillator;
use crate::friction::Law;
use crate::machine::Model;
use crate::map::{Regime, regime};
use crate::point::Point;
use crate::simulate::crossing::stick_slip_cycle;
use crate::simulate::direct::{Start, trace};
use crate::simulate::slip_cycle::slip_cycles;
use crate::simulate::{Fate, critical_damping, exceeds, flow};

/// A limit of a quantity, below which a statement holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Limit {
    /// The statement fails at the smallest values that were tried, or it is unknown beyond the limit.
    NotFound,
    /// The statement fails at all values that were tried, up to this one; beyond it, it is unknown.
    NoneUpTo(f64),
    /// The limit.
    Below(f64),
    /// The statement holds at all values that were tried.
    Everywhere,
}

impl Limit {
    /// The limit; `None` if there is none.
    #[must_use]
    pub fn value(self) -> Option<f64> {
        match self {
            Limit::Below(value) => Some(value),
            Limit::NotFound | Limit::NoneUpTo(_) | Limit::Everywhere => None,
        }
    }

    /// The limit times `unit`, the factor to another unit.
    pub(crate) fn times(self, unit: f64) -> Self {
        match self {
            Limit::Below(value) => Limit::Below(value * unit),
            Limit::NoneUpTo(value) => Limit::NoneUpTo(value * unit),
            Limit::NotFound | Limit::Everywhere => self,
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
    /// highest such limit within a factor of 1000 of the machine's speed.
    pub critical_belt_speed: Limit,
    /// Critical damping coefficient, N s/m: above it a mass that leaves the belt does not return to it.
    /// `None` if no damping is needed, or none was found.
    pub critical_damping: Option<f64>,
    /// Whether the critical damping was found, or found not to be needed.
    pub critical_damping_is_known: bool,
    /// Estimate of the absolute error of the critical damping, N s/m.
    pub critical_damping_error: Option<f64>,
    /// Damping ratio of the critical damping.
    pub critical_damping_ratio: Option<f64>,
    /// Long-run behaviour.
    pub regime: Regime,
    /// Slip and stick time of the stick-slip cycle, s.
    pub slip_and_stick_time: Option<[f64; 2]>,
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
const DECADES: i32 = 3;

/// Belt speeds within three decades of `near`, from the slowest, `per_decade` of them per factor of ten.
pub(crate) fn belt_speeds(near: f64, per_decade: i32) -> impl DoubleEndedIterator<Item = f64> {
    let range = DECADES * per_decade;
    (-range..=range).map(move |i| near * 10f64.powf(f64::from(i) / f64::from(per_decade)))
}

/// By bisection, a value up to which `holds` is true, between `low`, where it is true, and `high`, where it
/// is false; `None` if it is unknown at a value that is tried.
pub(crate) fn last_between(mut low: f64, mut high: f64, holds: impl Fn(f64) -> Option<bool>) -> Option<f64> {
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        if holds(middle)? {
            low = middle;
        } else {
            high = middle;
        }
    }
    Some(0.5 * (low + high))
}

/// The highest belt speed, within three decades of `near`, up to which `holds` is true and beyond which it is
/// false.
fn highest_belt_speed(near: f64, holds: impl Fn(f64) -> Option<bool>) -> Limit {
    let mut beyond = Limit::Everywhere;
    // The fastest speed from which on `holds` is false at all slower ones.
    let mut none_up_to = Limit::NotFound;
    for speed in belt_speeds(near, CRITICAL_PER_DECADE).rev() {
        beyond = match (holds(speed), beyond) {
            (Some(true), Limit::Below(high)) => {
                return last_between(speed, high, holds).map_or(Limit::NotFound, Limit::Below);
            }
            (Some(true), unchanged) => return unchanged,
            (Some(false), _) => {
                if none_up_to == Limit::NotFound {
                    none_up_to = Limit::NoneUpTo(speed);
                }
                Limit::Below(speed)
            }
            (None, _) => {
                none_up_to = Limit::NotFound;
                Limit::NotFound
            }
        };
    }
    none_up_to
}

/// The highest belt speed V at which c* falls through the point's damping.
fn critical_belt_speed(law: &Law, point: &Point, tolerance: f64) -> Limit {
    // A closed orbit reaches about twice the belt speed: beyond half their end, data tell nothing.
    let end = if let Law::Table(table) = law { 0.5 * table.fastest() } else { f64::INFINITY };
    highest_belt_speed(point.belt_speed, |belt_speed| {
        if belt_speed > end {
            return None;
        }
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

/// Computes the behaviour of a machine.
#[must_use]
pub fn behaviour(model: &Model, tolerance: f64) -> Behaviour {
    let Model { law, point, si } = model;
    let units = si.units;
    let oscillator = Oscillator::new(law, point);
    let flow = flow(&oscillator, tolerance);
    let half = |range: crate::friction::Range| 0.5 * (range.hi - range.lo) * units.length;
    let stick_slip = stick_slip_cycle(&oscillator, &flow, tolerance).ok().flatten();
    let slip = || slip_cycles(&oscillator, tolerance).ok()?.into_iter().rfind(|cycle| cycle.is_stable());
    let amplitude = stick_slip.map(|cycle| half(cycle.displacement));
    let amplitude = amplitude.or_else(|| slip().map(|cycle| half(cycle.displacement)));
    let root = critical_damping(&model.column(), tolerance);
    let critical = root.ok().filter(|root| root.c >= 0.0);
    let times = match flow.fate {
        Fate::Sticks(landing) => Some([landing.slip_time * units.time, landing.stick_time * units.time]),
        Fate::SpiralsInward | Fate::CrossesForever | Fate::TooCloseToCall | Fate::Failed(_) => None,
    };
    Behaviour {
        natural_frequency: 1.0 / (std::f64::consts::TAU * units.time),
        damping_ratio: 0.5 * point.damping,
        critical_belt_speed: critical_belt_speed(law, point, tolerance).times(units.velocity),
        critical_damping: critical.map(|root| root.c * units.damping),
        critical_damping_is_known: root.is_ok(),
        critical_damping_error: critical.map(|root| root.error * units.damping),
        critical_damping_ratio: critical.map(|root| 0.5 * root.c),
        regime: regime(&oscillator, &flow),
        slip_and_stick_time: times,
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
    use crate::friction::Table;
    use crate::machine::{Friction, Machine, example};

    fn does(machine: &Machine) -> Behaviour {
        behaviour(&machine.model().unwrap(), 1e-10)
    }

    /// Friction that rises: the machine stick-slips at no belt speed, as far as the data reach.
    #[test]
    fn a_limit_that_does_not_exist_is_told_from_an_unknown_one() {
        let below = |known: f64, limit: f64| {
            highest_belt_speed(1.0, |speed| (speed < known).then_some(speed < limit))
        };
        assert_eq!(below(f64::INFINITY, f64::INFINITY), Limit::Everywhere);
        assert!(matches!(below(f64::INFINITY, 2.0), Limit::Below(at) if (at - 2.0).abs() < 1e-9));
        assert_eq!(below(f64::INFINITY, 0.0), Limit::NoneUpTo(1e3));
        assert!(matches!(below(5.0, 0.0), Limit::NoneUpTo(at) if at < 5.0 && at > 4.0));
        assert_eq!(below(5.0, f64::INFINITY), Limit::NotFound);
        assert_eq!(below(0.0, 0.0), Limit::NotFound);
        // Unknown at the slowest speeds.
        let slow = highest_belt_speed(1.0, |speed| (speed > 0.1).then_some(false));
        assert_eq!(slow, Limit::NotFound);
        let data = [0.0, 0.05, 0.1, 0.2, 0.5, 1.2].map(|u| (u, 0.3 + 0.2 * u));
        let friction = Friction::Measured(Table::new("rises", &data, 0.3).unwrap());
        let machine = Machine { friction, belt_speed: 0.2, ..example(Law::Stribeck) };
        let found = does(&machine).critical_belt_speed;
        assert!(matches!(found, Limit::NoneUpTo(speed) if speed > 0.5 && speed <= 0.6), "{found:?}");
        // Friction that falls as far as the data reach has no limit there.
        let data = data.map(|(u, mu)| (u, 0.6 - mu));
        let friction = Friction::Measured(Table::new("falls", &data, 0.3).unwrap());
        let falls = Machine { friction, damping: 0.0, ..machine };
        assert_eq!(does(&falls).critical_belt_speed, Limit::NotFound);
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

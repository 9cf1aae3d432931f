//! The intervals of the belt speed, and of the damping, in which a machine behaves in one way.
//!
//! A statement about the behaviour is judged at many values, and each change between two of them is located by
//! bisection. The ends of an interval are such changes only: a value up to which a statement is known to hold,
//! and beyond which nothing is known or was tried, is told apart from a limit. An interval that fits between two
//! of the values is missed.

use std::cell::OnceCell;

use rayon::prelude::*;

use super::TOLERANCE;
use crate::behaviour::{Limit, SAME, belt_speeds, last_within};
use crate::map::{self, Regime};
use slipmap_model::filippov::{Oscillator, Stability};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::Point;
use slipmap_numbers::named;
use slipmap_simulate::{Fate, Flow, flow};

named! {
    /// A statement about the behaviour of a machine, with its name in JSON.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Statement {
        /// The stick-slip cycle is the only attractor.
        AlwaysSticks => "always_stick_slips",
        /// The stick-slip cycle attracts.
        MayStick => "may_stick_slip",
        /// A cycle attracts that slips all the time.
        MaySlip => "may_vibrate_without_sticking",
        /// Orbits cross the belt line for ever.
        MayCross => "may_overtake_the_belt",
    }
}

const STATEMENTS: usize = Statement::ALL.len();

impl Statement {
    /// Whether it holds where the orbit from the exit point is `flow`; `None` if that is unknown.
    fn holds(self, oscillator: &Oscillator, flow: &Flow, regime: impl FnOnce() -> Regime) -> Option<bool> {
        let sticks = match flow.fate {
            Fate::Sticks(_) => Some(true),
            Fate::SpiralsInward | Fate::CrossesForever => Some(false),
            Fate::TooCloseToCall | Fate::Failed(_) => None,
        };
        let never = || sticks == Some(false) || oscillator.stability() == Stability::Attracts;
        match self {
            Statement::MayStick => return sticks,
            Statement::AlwaysSticks if never() => return Some(false),
            Statement::AlwaysSticks | Statement::MaySlip | Statement::MayCross => {}
        }
        let regime = regime();
        let attractors = regime.attractors();
        match (regime, self) {
            (Regime::Failed | Regime::Neutral, _) => None,
            (_, Statement::MaySlip) => Some(attractors.slip),
            (_, Statement::MayCross) => Some(attractors.crossing),
            (_, Statement::AlwaysSticks | Statement::MayStick) => Some(regime == Regime::StickSlip),
        }
    }
}

/// An end of an interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum End {
    /// It ends at this value, known to within the error.
    At {
        /// The value.
        value: f64,
        /// Bound of its absolute error.
        error: f64,
    },
    /// It reaches this value, the least or the largest that was tried.
    Tried(f64),
    /// It reaches this value; whether it goes on beyond it is not known.
    Open(f64),
}

impl End {
    /// The end, or the value that is known to be reached.
    pub fn value(self) -> f64 {
        match self {
            End::At { value, .. } | End::Tried(value) | End::Open(value) => value,
        }
    }

    /// The end and its error, where it is one.
    pub fn located(self) -> Option<[f64; 2]> {
        match self {
            End::At { value, error } => Some([value, error]),
            End::Tried(_) | End::Open(_) => None,
        }
    }

    fn times(self, unit: f64) -> Self {
        match self {
            End::At { value, error } => End::At { value: value * unit, error: error * unit },
            End::Tried(value) => End::Tried(value * unit),
            End::Open(value) => End::Open(value * unit),
        }
    }
}

/// The values at which a statement holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Intervals {
    /// From where to where it holds, by increasing values.
    pub holds: Vec<[End; 2]>,
    /// Where that is not known.
    pub unknown: Vec<[f64; 2]>,
    /// The least and the largest value that was tried.
    pub tried: [f64; 2],
}

impl Intervals {
    /// The intervals of a statement that is judged at increasing values, at least two; `known` holds limits that
    /// may be among the ends: an end that agrees with one within its error is that one. Others are located to the
    /// relative `width`.
    fn between(
        judged: &[(f64, Option<bool>)],
        known: &[f64],
        width: f64,
        holds: impl Fn(f64) -> Option<bool>,
    ) -> Self {
        let (first, last) = (judged[0], judged[judged.len() - 1]);
        let mut found = Self { holds: Vec::new(), unknown: Vec::new(), tried: [first.0, last.0] };
        let mut begun = End::Tried(first.0);
        for pair in judged.windows(2) {
            let [(low, before), (high, after)] = [pair[0], pair[1]];
            if before == after {
                continue;
            }
            let [low, high] = match (before, after) {
                (Some(before), Some(_)) => beside(known, [low, high], |at| Some(holds(at)? == before))
                    .unwrap_or_else(|| last_within(width, [low, high], |at| Some(holds(at)? == before))),
                (Some(_), None) => [last_within(ROUGH, [low, high], |at| Some(holds(at) == before))[0]; 2],
                (None, _) => [last_within(ROUGH, [low, high], |at| Some(holds(at) != after))[1]; 2],
            };
            let is_located = before.is_some() && after.is_some() && high - low <= LOCATED * high;
            let [ends, begins] = match is_located {
                true => [at([low, high], known); 2],
                false => [End::Open(low), End::Open(high)],
            };
            if before.is_some() && after.is_some() && !is_located {
                found.unknown.push([low, high]);
            }
            found.close(before, [begun, ends]);
            begun = begins;
        }
        found.close(last.1, [begun, End::Tried(last.0)]);
        found
    }

    fn close(&mut self, state: Option<bool>, ends: [End; 2]) {
        match state {
            Some(true) => self.holds.push(ends),
            Some(false) => {}
            None => self.unknown.push(ends.map(End::value)),
        }
    }

    /// The located ends.
    fn ends(&self) -> impl Iterator<Item = f64> {
        self.holds.iter().flatten().filter_map(|end| Some(end.located()?[0]))
    }

    /// The same in another unit, `unit` times smaller.
    fn times(self, unit: f64) -> Self {
        Self {
            holds: self.holds.into_iter().map(|ends| ends.map(|end| end.times(unit))).collect(),
            unknown: self.unknown.into_iter().map(|ends| ends.map(|end| end * unit)).collect(),
            tried: self.tried.map(|end| end * unit),
        }
    }

    /// The limit of the interval that begins at the least value that was tried.
    pub(crate) fn lowest(&self) -> Limit {
        let unknown_from = |at: f64| self.unknown.iter().find(|ends| ends[0] == at);
        match self.holds.first() {
            Some([End::Tried(_), End::At { value, error }]) => match *error <= SAME * value {
                true => Limit::Below(*value),
                false => Limit::Between(value - error, value + error),
            },
            Some([End::Tried(_), end]) => match unknown_from(end.value()) {
                Some([low, high]) if *high < self.tried[1] => Limit::Between(*low, *high),
                _ => Limit::AtLeast(end.value()),
            },
            _ if unknown_from(self.tried[0]).is_some() => Limit::NotDetermined,
            _ => Limit::NoneUpTo(self.tried[0]),
        }
    }
}

/// The change between two values, the statement's `holds` being true at the lower one and false at the upper one,
/// if it is at one of the `known` limits: what holds is much dearer to know than most limits.
fn beside(known: &[f64], [low, high]: [f64; 2], holds: impl Fn(f64) -> Option<bool>) -> Option<[f64; 2]> {
    known.iter().filter(|limit| low < **limit && **limit < high).find_map(|limit| {
        // Next to a limit the behaviour may be too close to call.
        let around = BESIDE.map(|distance| [limit * (1.0 - distance), limit * (1.0 + distance)]);
        let mut around = around.into_iter().filter(|[below, above]| low < *below && *above < high);
        around.find(|[below, above]| holds(*below) == Some(true) && holds(*above) == Some(false))
    })
}

/// Relative distances from a known limit at which it is tried whether it is one.
const BESIDE: [f64; 3] = [1e-8, 1e-6, 1e-4];

/// The change between two values that nearly agree.
fn at([low, high]: [f64; 2], known: &[f64]) -> End {
    let (middle, error) = (0.5 * (low + high), 0.5 * (high - low));
    let is_it = |limit: &&f64| (**limit - middle).abs() <= error + NEAR * middle;
    let nearest =
        known.iter().filter(is_it).min_by(|a, b| (*a - middle).abs().total_cmp(&(*b - middle).abs()));
    End::At { value: nearest.copied().unwrap_or(middle), error: error + NEAR * middle }
}

/// Relative width to which a change of stability or of stick-slip is located.
const CLOSE: f64 = 1e-7;
/// Relative width to which the end of what is known is; a change that takes all attractors to see is located to
/// [`SAME`].
const ROUGH: f64 = 1e-3;
/// Relative width of a bracket in which a change counts as located: as for the critical damping, 1 %.
const LOCATED: f64 = 0.01;
/// Relative error of a change beside that of the bisection: that of orbits with [`TOLERANCE`].
const NEAR: f64 = 1e-8;

/// Number of belt speeds per factor of ten. Friction that rises and falls several times has windows of speeds.
const SPEEDS_PER_DECADE: i32 = 32;

/// All attractors are sought at each of this number of them, since that costs far more.
const FEWER: usize = 4;
/// Ratio to the highest change of stick-slip up to which they are.
const FAR: f64 = 4.0;
/// Relative distance from a change at which they are, too.
const ASIDE: f64 = 1e-3;

/// The belt speeds at the point's damping at which each statement holds, in units of `unit`; `critical` is the
/// critical one.
pub(super) fn of_speeds(
    law: &Law,
    point: &Point,
    unit: f64,
    critical: Option<f64>,
) -> [Intervals; STATEMENTS] {
    let at = |belt_speed: f64| Oscillator::new(law, &Point { belt_speed, ..*point });
    let speeds = belt_speeds(&law.column(point).curve, SPEEDS_PER_DECADE);
    // Steady slip becomes stable or unstable, and stick-slip begins or ends: the least work to know.
    let repels = |speed: f64| match at(speed).stability() {
        Stability::Neutral => None,
        stability => Some(stability == Stability::Repels),
    };
    let sticks = |speed: f64| {
        let oscillator = at(speed);
        Statement::MayStick.holds(&oscillator, &flow(&oscillator, TOLERANCE), || Regime::Failed)
    };
    let of = |holds: &(dyn Fn(f64) -> Option<bool> + Sync)| {
        let judged: Vec<_> = speeds.par_iter().map(|speed| (*speed, holds(*speed))).collect();
        Intervals::between(&judged, critical.as_slice(), CLOSE, holds)
    };
    let [steady, stick_slip] = [of(&repels), of(&sticks)];
    let known: Vec<f64> = [&steady, &stick_slip].into_iter().flat_map(Intervals::ends).collect();
    // All attractors, at fewer speeds and on both sides of these changes, but not far beyond stick-slip: orbits of
    // fast belts reach over many waves of friction.
    let (first, last) = (speeds[0], speeds[speeds.len() - 1]);
    let fastest = stick_slip.ends().last().map_or(last, |end| last.min(FAR * end));
    let sides = known.iter().flat_map(|change| [change * (1.0 - ASIDE), change * (1.0 + ASIDE)]);
    let mut fewer: Vec<f64> = speeds.into_iter().step_by(FEWER).chain(sides).collect();
    fewer.retain(|speed| first < *speed && *speed < fastest);
    fewer.extend([first, fastest]);
    fewer.sort_by(f64::total_cmp);
    fewer.dedup();
    let judged: Vec<_> = fewer.into_par_iter().map(|speed| (speed, judge(&at(speed), map::regime))).collect();
    let mut all = each(&judged, &known, unit, |statement, speed| {
        let oscillator = at(speed);
        let flow = flow(&oscillator, TOLERANCE);
        statement.holds(&oscillator, &flow, || map::regime(&oscillator, &flow))
    });
    all[Statement::MayStick as usize] = stick_slip.times(unit);
    all
}

/// Number of dampings per factor of ten.
const DAMPINGS_PER_DECADE: i32 = 16;

/// The dampings c of a column at which each statement holds, in units of `unit`; `limits` are its dampings at
/// which the behaviour changes, as far as they are known.
pub(super) fn of_dampings(
    column: &Column,
    unit: f64,
    limits: &[f64],
    regime: impl Fn(&Oscillator, &Flow) -> Regime,
) -> [Intervals; STATEMENTS] {
    let mut limits: Vec<f64> = limits.iter().copied().filter(|it| *it > 0.0 && it.is_finite()).collect();
    limits.sort_by(f64::total_cmp);
    // Between limits that agree nothing is known.
    limits.dedup_by(|one, other| *one - *other <= SAME * *one);
    let ends = [limits.first(), limits.last()].map(|end| end.copied().unwrap_or(1.0));
    let index = |damping: f64| damping.log10() * f64::from(DAMPINGS_PER_DECADE);
    let [first, last] = [index(0.01 * ends[0]).floor() as i32, index(2.0 * ends[1]).ceil() as i32];
    let of_index = |i: i32| 10f64.powf(f64::from(i) / f64::from(DAMPINGS_PER_DECADE));
    let between = limits.windows(2).map(|pair| 0.5 * (pair[0] + pair[1]));
    let mut dampings: Vec<f64> = (first..=last).map(of_index).chain(between).collect();
    // Without damping steady slip may be neutral.
    let at = |damping: f64| Oscillator::in_column(column, damping);
    dampings.extend((at(0.0).stability() != Stability::Neutral).then_some(0.0));
    dampings.sort_by(f64::total_cmp);
    let judged: Vec<_> =
        dampings.into_iter().map(|damping| (damping, judge(&at(damping), &regime))).collect();
    each(&judged, &limits, unit, |statement, damping| {
        let oscillator = at(damping);
        let flow = flow(&oscillator, TOLERANCE);
        statement.holds(&oscillator, &flow, || regime(&oscillator, &flow))
    })
}

/// Judges every statement.
fn judge(
    oscillator: &Oscillator,
    regime: impl Fn(&Oscillator, &Flow) -> Regime,
) -> [Option<bool>; STATEMENTS] {
    let (flow, known) = (flow(oscillator, TOLERANCE), OnceCell::new());
    Statement::ALL.map(|it| it.holds(oscillator, &flow, || *known.get_or_init(|| regime(oscillator, &flow))))
}

fn each(
    judged: &[(f64, [Option<bool>; STATEMENTS])],
    known: &[f64],
    unit: f64,
    holds: impl Fn(Statement, f64) -> Option<bool>,
) -> [Intervals; STATEMENTS] {
    let mut position = 0;
    Statement::ALL.map(|statement| {
        let of_one: Vec<_> = judged.iter().map(|(value, all)| (*value, all[position])).collect();
        position += 1;
        Intervals::between(&of_one, known, SAME, |value| holds(statement, value)).times(unit)
    })
}

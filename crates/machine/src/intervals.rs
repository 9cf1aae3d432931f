//! The intervals of the belt speed, and of the damping, in which a machine behaves in one way.
//!
//! A statement about the behaviour is judged at many values, and each change between two of them is located. The ends
//! of an interval are such changes only: a value up to which a statement is known to hold, and beyond which nothing is
//! known or was tried, is told apart from a limit. An interval that fits between two of the values is missed.
//!
//! What steady slip and the orbit from the exit point do is quick to know, and their changes are located by bisection.
//! All attractors take a backbone for each value. They change there or at folds of slip cycles, which are roots of a
//! continuous function of the backbone ([`surplus`]); a change is then confirmed on both sides of such a root, and
//! bisected only where it is none of them.

mod tried;

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;

use slipmap_certify::{Decision, symmetric};
use slipmap_column::backbone::Backbone;
use slipmap_column::critical::critical_damping_with;
use slipmap_column::{Behaviour, Change, Regime, Verdict};
use slipmap_model::filippov::{Oscillator, Stability};
use slipmap_model::flow::Flow;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_numbers::named;
use slipmap_numbers::roots::{Bracket, falling_root};
use slipmap_orbits::{Effort, flow_with};
pub(crate) use tried::belt_speeds;
use tried::last_within;

/// The flow at one of many values.
fn flow_of(oscillator: &Oscillator) -> Flow {
    flow_with(Effort::Small, oscillator, TOLERANCE)
}

/// Tolerance of the scaled grazing margin.
pub(crate) const TOLERANCE: f64 = 1e-9;

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

    /// A limit that is known to within an error.
    fn located(value: f64, error: f64) -> Self {
        match error <= SAME * value {
            true => Limit::Below(value),
            false => Limit::Between(value - error, value + error),
        }
    }

    /// The limit times `unit`, the factor to another unit.
    #[must_use]
    pub fn times(self, unit: f64) -> Self {
        match self {
            Limit::Below(value) => Limit::Below(value * unit),
            Limit::NoneUpTo(value) => Limit::NoneUpTo(value * unit),
            Limit::AtLeast(value) => Limit::AtLeast(value * unit),
            Limit::Between(low, high) => Limit::Between(low * unit, high * unit),
            Limit::NotDetermined => self,
        }
    }
}

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
    /// Whether it holds, given whether the orbit from the exit point sticks; `None` if that is unknown.
    fn holds(self, sticks: Option<bool>, steady: Stability, regime: impl FnOnce() -> Regime) -> Option<bool> {
        let never = || sticks == Some(false) || steady == Stability::Attracts;
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
        known: &[Known],
        closeness: &Closeness,
        holds: impl Fn(f64) -> Option<bool>,
    ) -> Self {
        let Closeness { width, rough, rounds, farther } = *closeness;
        let (first, last) = (judged[0], judged[judged.len() - 1]);
        let mut found = Self { holds: Vec::new(), unknown: Vec::new(), tried: [first.0, last.0] };
        let mut begun = End::Tried(first.0);
        for pair in judged.windows(2) {
            let [(low, before), (high, after)] = [pair[0], pair[1]];
            if before == after {
                continue;
            }
            let [low, high] = match (before, after) {
                (Some(before), Some(_)) => {
                    beside(known, farther, [low, high], |at| Some(holds(at)? == before)).unwrap_or_else(
                        || last_within(width, rounds, [low, high], |at| Some(holds(at)? == before)),
                    )
                }
                (Some(_), None) => {
                    [last_within(rough, rounds, [low, high], |at| Some(holds(at) == before))[0]; 2]
                }
                (None, _) => [last_within(rough, rounds, [low, high], |at| Some(holds(at) != after))[1]; 2],
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

    /// The intervals of a statement that is known on adjacent spans of C from 0 on. A narrow span in which it is not known is
    /// that of a change.
    fn of_spans(spans: impl Iterator<Item = ([f64; 2], Option<bool>)>, changes: &[Change]) -> Self {
        let mut runs: Vec<([f64; 2], Option<bool>)> = Vec::new();
        for (span, state) in spans {
            let is_narrow = |[low, high]: [f64; 2]| high - low <= (LOCATED * high).max(NO_DAMPING);
            // A narrow gap that is ended by a state, known or not.
            if let Some((gap, None)) = runs.last().copied()
                && state.is_some()
                && is_narrow(gap)
            {
                runs.pop();
            }
            match runs.last_mut() {
                Some((run, of_run)) if *of_run == state => run[1] = span[1],
                None => runs.push(([0.0, span[1]], state)),
                Some(_) => runs.push((span, state)),
            }
        }
        let tried = [0.0, runs.last().map_or(0.0, |(run, _)| run[1])];
        let mut found = Self { holds: Vec::new(), unknown: Vec::new(), tried };
        let end_of = |position: usize, side: usize| {
            let at = runs[position].0[side];
            let Some((next, state)) = (position + 2 * side).checked_sub(1).and_then(|next| runs.get(next))
            else {
                return End::Tried(at);
            };
            match state {
                None => End::Open(at),
                Some(_) => located([at, next[1 - side]], changes),
            }
        };
        for (position, (_, state)) in runs.iter().enumerate() {
            found.close(*state, [0, 1].map(|side| end_of(position, side)));
        }
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

    /// The limit of the highest interval; at least its end where something is unknown beyond it.
    pub(crate) fn highest(&self) -> Limit {
        match self.holds.last() {
            Some([_, End::At { value, error }]) if self.unknown.iter().all(|[_, high]| high < value) => {
                Limit::located(*value, *error)
            }
            Some([_, end]) => match self.unknown.iter().find(|[low, _]| *low == end.value()) {
                Some([low, high]) if *high < self.tried[1] => Limit::Between(*low, *high),
                _ => Limit::AtLeast(end.value()),
            },
            None => match self.unknown.first() {
                None => Limit::NoneUpTo(self.tried[1]),
                Some([low, _]) if *low == self.tried[0] => Limit::NotDetermined,
                Some([low, _]) => Limit::NoneUpTo(*low),
            },
        }
    }

    /// The limit of the interval that begins at the least value that was tried.
    pub(crate) fn lowest(&self) -> Limit {
        let unknown_from = |at: f64| self.unknown.iter().find(|ends| ends[0] == at);
        match self.holds.first() {
            Some([End::Tried(_), End::At { value, error }]) => Limit::located(*value, *error),
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
fn beside(
    known: &[Known],
    farther: &[f64],
    [low, high]: [f64; 2],
    holds: impl Fn(f64) -> Option<bool>,
) -> Option<[f64; 2]> {
    known.iter().filter(|(limit, _)| low < *limit && *limit < high).find_map(|(limit, distance)| {
        // Next to a limit the behaviour may be too close to call.
        let around = farther.iter().map(|times| times * distance);
        let around = around.map(|distance| [limit * (1.0 - distance), limit * (1.0 + distance)]);
        let mut around = around.filter(|[below, above]| low < *below && *above < high);
        around.find(|[below, above]| holds(*below) == Some(true) && holds(*above) == Some(false))
    })
}

/// A limit that is known, and the relative distance from it at which it is tried whether it is one.
type Known = (f64, f64);

/// Such a distance of a limit that is known well, and the factors to it and farther ones.
const BESIDE: f64 = 4e-6;
const FARTHER: [f64; 2] = [1.0, 25.0];
/// The same of measured friction, whose errors are far larger: windows that lie within the last one are not looked into.
const FARTHER_OF_DATA: [f64; 3] = [1.0, 25.0, 1000.0];

/// The change between two values that nearly agree.
fn at([low, high]: [f64; 2], known: &[Known]) -> End {
    let (middle, error) = (0.5 * (low + high), 0.5 * (high - low));
    let is_it = |limit: &&f64| (**limit - middle).abs() <= error + NEAR * middle;
    let known = known.iter().map(|(limit, _)| limit).filter(is_it);
    let nearest = known.min_by(|a, b| (*a - middle).abs().total_cmp(&(*b - middle).abs()));
    End::At { value: nearest.copied().unwrap_or(middle), error: error + NEAR * middle }
}

/// The change between two ends of spans: that of the changes there which is known best.
fn located(ends: [f64; 2], changes: &[Change]) -> End {
    let [low, high] = [ends[0].min(ends[1]), ends[0].max(ends[1])];
    let is_there = |change: &&Change| low <= change.viscous && change.viscous <= high;
    let width = |change: &Change| change.between[1] - change.between[0];
    let best = changes.iter().filter(is_there).min_by(|one, other| width(one).total_cmp(&width(other)));
    let value = best.map_or(0.5 * (low + high), |change| change.viscous);
    End::At { value, error: (value - low).max(high - value) + f64::EPSILON * value }
}

/// How closely changes are located by bisection.
struct Closeness {
    /// Relative width to which a change is.
    width: f64,
    /// Relative width to which the end of what is known is.
    rough: f64,
    /// Number of bisections for each end of a range in which it is unknown.
    rounds: u32,
    /// Distances from a limit that is known, in units of its own, at which it is tried whether a change is there.
    farther: &'static [f64],
}

/// Changes of stability and of stick-slip.
const CLOSE: Closeness = Closeness { width: 1e-7, rough: 1e-3, rounds: 12, farther: &FARTHER };
/// Changes that take all attractors to see: the less of them are known, the longer each takes.
const DEAR: Closeness = Closeness { width: SAME, rough: 0.35, rounds: 1, farther: &FARTHER };
const DEAR_OF_DATA: Closeness = Closeness { farther: &FARTHER_OF_DATA, ..DEAR };
/// Relative width of a bracket in which a change counts as located: as for the critical damping, 1 %.
const LOCATED: f64 = 0.01;
/// Relative error of a change beside that of the bisection: that of orbits with [`TOLERANCE`].
const NEAR: f64 = 1e-8;

/// Number of belt speeds per factor of ten. Friction that rises and falls several times has windows of speeds.
const SPEEDS_PER_DECADE: i32 = 32;

/// All attractors are sought at each of this number of them, since that costs far more; at half of these of a table
/// whose friction turns from falling to rising, or back, more often than this.
const FEWER: usize = 4;
const SMOOTH: usize = 1;
/// Ratio to the highest change of stick-slip up to which they are.
const FAR: f64 = 4.0;
/// Relative distance from a change at which they are, too, and of measured friction.
const ASIDE: f64 = 1e-3;
const ASIDE_OF_DATA: f64 = 1e-2;

/// The belt speeds at the point's damping at which the stick-slip cycle attracts.
pub(crate) fn of_stick_slip(law: &Law, point: &Point) -> Intervals {
    let speeds = Speeds { law, point, regimes: Mutex::default() };
    let sticks = |speed: f64| {
        let oscillator = speeds.at(speed);
        let holds = Verdict::from(&flow_of(&oscillator).fate).presence();
        // A theorem may decide, or the critical damping be known, where an orbit cannot be followed.
        holds.or_else(|| {
            let column = law.column(&Point { belt_speed: speed, ..*point });
            match symmetric::TEST.claim(&column).decide(point.damping) {
                Decision::Present => return Some(true),
                Decision::Absent => return Some(false),
                Decision::Undecided => {}
            }
            let critical = critical_damping_with(Effort::Small, &column, TOLERANCE).ok()?;
            (critical.c + critical.error < point.damping).then_some(false)
        })
    };
    speeds.of(&sticks)
}

/// The belt speeds at the point's damping at which each statement holds, in units of `unit`; the stick-slip cycle
/// attracts at those of `stick_slip`.
pub(crate) fn of_speeds(
    law: &Law,
    point: &Point,
    unit: f64,
    stick_slip: Intervals,
) -> [Intervals; STATEMENTS] {
    let speeds = Speeds { law, point, regimes: Mutex::default() };
    let steady = speeds.of(&|speed| match speeds.at(speed).stability() {
        Stability::Neutral => None,
        stability => Some(stability == Stability::Repels),
    });
    let mut known: Vec<Known> =
        [&steady, &stick_slip].into_iter().flat_map(Intervals::ends).map(|end| (end, BESIDE)).collect();
    // All attractors, at fewer speeds and on both sides of these changes, but not far beyond stick-slip: orbits of
    // fast belts reach over many waves of friction.
    let [first, last] = stick_slip.tried;
    let fastest = match stick_slip.holds.last() {
        Some([_, End::At { value, .. }]) => last.min(FAR * value),
        _ => last,
    };
    let is_measured = matches!(law.as_written(), Law::Table(_));
    let (aside, closeness) = if is_measured { (ASIDE_OF_DATA, &DEAR_OF_DATA) } else { (ASIDE, &DEAR) };
    let sides = known.iter().flat_map(|(change, _)| [change * (1.0 - aside), change * (1.0 + aside)]);
    // Backbones of rows that scatter take long.
    let scatters = law.column(point).curve.table().is_some_and(|table| table.turns() > SMOOTH);
    let step = if scatters { 2 * FEWER } else { FEWER };
    let mut fewer: Vec<f64> = speeds.tried().into_iter().step_by(step).chain(sides).collect();
    fewer.retain(|speed| first < *speed && *speed < fastest);
    fewer.extend([first, fastest]);
    fewer.sort_by(f64::total_cmp);
    fewer.dedup();
    let judge = |speed: f64| (speed, Statement::ALL.map(|statement| speeds.holds(statement, speed)));
    let judged: Vec<_> = fewer.into_par_iter().map(judge).collect();
    let folds: Vec<Known> =
        judged.par_windows(2).filter_map(|pair| speeds.fold(pair, &known, closeness.farther)).collect();
    known.extend(folds);
    let mut all = each(&judged, &known, closeness, unit, |statement, speed| speeds.holds(statement, speed));
    all[Statement::MayStick as usize] = stick_slip.times(unit);
    all
}

/// What holds of each of [`Statement::ALL`].
type States = [Option<bool>; STATEMENTS];

/// The belt speeds at a point.
struct Speeds<'a> {
    law: &'a Law,
    point: &'a Point,
    /// What was found at speeds so far, by their bits.
    regimes: Mutex<HashMap<u64, Regime>>,
}

impl Speeds<'_> {
    fn at(&self, belt_speed: f64) -> Oscillator {
        Oscillator::new(self.law, &Point { belt_speed, ..*self.point })
    }

    fn tried(&self) -> Vec<f64> {
        belt_speeds(&self.law.column(self.point).curve, SPEEDS_PER_DECADE)
    }

    /// The intervals of a statement that is quick to judge.
    fn of(&self, holds: &(dyn Fn(f64) -> Option<bool> + Sync)) -> Intervals {
        let judged: Vec<_> = self.tried().into_par_iter().map(|speed| (speed, holds(speed))).collect();
        Intervals::between(&judged, &[], &CLOSE, holds)
    }

    /// Whether a statement holds at a speed. The attractors are found once for each speed.
    fn holds(&self, statement: Statement, speed: f64) -> Option<bool> {
        let oscillator = self.at(speed);
        let flow = flow_of(&oscillator);
        statement.holds(Verdict::from(&flow.fate).presence(), oscillator.stability(), || {
            let known = || self.regimes.lock().unwrap_or_else(PoisonError::into_inner);
            let found = known().get(&speed.to_bits()).copied();
            found.unwrap_or_else(|| {
                let behaviour = Behaviour::with(Effort::Small, &oscillator.curve, speed);
                let regime = behaviour.regime_of(&oscillator, &flow);
                known().insert(speed.to_bits(), regime);
                regime
            })
        })
    }

    /// The fold at which slip cycles begin or cease to attract between two speeds; `None` where they do not, and at
    /// one of the `known` limits or a distance `farther` from it.
    fn fold(&self, pair: &[(f64, States)], known: &[Known], farther: &[f64]) -> Option<Known> {
        let slips = |states: &States| states[Statement::MaySlip as usize];
        let [(low, before), (high, after)] = [&pair[0], &pair[1]];
        let (before, after) = (slips(before)?, slips(after)?);
        let holds = |speed: f64| Some(self.holds(Statement::MaySlip, speed)? == before);
        if before == after || beside(known, farther, [*low, *high], holds).is_some() {
            return None;
        }
        let sign = if before { 1.0 } else { -1.0 };
        let error = Cell::new(0.0);
        let falling = |speed: f64| {
            let (surplus, at_speed) = surplus(&self.at(speed)).ok_or(())?;
            error.set(at_speed);
            Ok::<_, ()>(sign * surplus)
        };
        let ends = [*low, *high].map(|speed| falling(speed).map(|surplus| (speed, surplus)));
        let [Ok(low @ (_, 0.0..)), Ok(high @ (_, ..=0.0))] = ends else { return None };
        let enough = 0.02 * SAME * high.0;
        let (speed, bracket) = falling_root(Bracket { low, high }, enough, falling).ok()?;
        // Cycles are counted from some errors of the backbone on.
        Some((speed, (COUNTED * error.get() / (bracket.steepness() * speed)).max(BESIDE)))
    }
}

/// Tolerance of the backbones of folds, in units of the weakening rate.
const OF_FOLDS: f64 = 1e-8;
const WITH_CORNERS: f64 = 1e-5;
/// Distance of a damping from a fold, in errors of the backbone, from which on its cycles are counted.
const COUNTED: f64 = 6.0;

/// The largest m for which C(r) - m rises above eps c at some amplitude and C(r) + m falls below it at a larger one: a
/// continuous function of the law and the point, positive where a slip cycle attracts and negative where none does.
/// With the error of the backbone; `None` where that is unknown.
fn surplus(oscillator: &Oscillator) -> Option<(f64, f64)> {
    let Oscillator { curve, belt_speed, viscous } = oscillator;
    // Orbits that only touch a corner take many steps at a fine tolerance.
    let tolerance = if curve.corners().is_empty() { OF_FOLDS } else { WITH_CORNERS };
    let backbone = Backbone::with(Effort::Small, curve, *belt_speed, tolerance).ok()?;
    let (mut highest, mut most) = (f64::NEG_INFINITY, f64::NEG_INFINITY);
    for turn in backbone.turning_points() {
        most = most.max(highest.min(viscous - turn.viscous));
        highest = highest.max(turn.viscous - viscous);
    }
    Some((most, backbone.error))
}

/// Relative distance beyond the last change up to which dampings are told.
const BEYOND_LAST: f64 = 2.0;
/// Dampings C below this count as none: where orbits are circles without damping, nothing is known of them.
const NO_DAMPING: f64 = 1e-9;

/// The dampings at which each statement holds, and the one above which steady slip is the only attractor, in units of `unit` of
/// C; from the dampings at which anything changes: between two of them nothing does.
pub(crate) fn of_dampings(column: &Behaviour, unit: f64) -> ([Intervals; STATEMENTS], Option<f64>) {
    let changes = column.changes();
    let mut ends: Vec<f64> = changes.iter().flat_map(|change| change.between).collect();
    ends.retain(|end| *end > 0.0 && *end < f64::INFINITY);
    let last = BEYOND_LAST * ends.iter().copied().fold(0.5, f64::max);
    ends.extend([0.0, last]);
    ends.sort_by(f64::total_cmp);
    ends.dedup();
    let judge = |pair: &[f64]| {
        let viscous = 0.5 * (pair[0] + pair[1]);
        let (sticks, regime) = (column.end_at(viscous).verdict().presence(), column.regime_at(viscous));
        let states = Statement::ALL.map(|it| it.holds(sticks, column.stability(viscous), || regime));
        let vibrates = !matches!(regime, Regime::Failed | Regime::Neutral);
        ([pair[0], pair[1]], states, vibrates.then_some(regime != Regime::Equilibrium))
    };
    let judged: Vec<_> = ends.windows(2).map(judge).collect();
    let vibrates = Intervals::of_spans(judged.iter().map(|(span, _, state)| (*span, *state)), changes);
    let vibrates_below = match vibrates.times(unit).highest() {
        Limit::NoneUpTo(end) if end == last * unit => Some(0.0),
        limit => limit.value(),
    };
    let of = |statement: Statement| {
        let of_one = judged.iter().map(|(span, states, _)| (*span, states[statement as usize]));
        Intervals::of_spans(of_one, changes).times(unit)
    };
    (Statement::ALL.map(of), vibrates_below)
}

fn each(
    judged: &[(f64, States)],
    known: &[Known],
    closeness: &Closeness,
    unit: f64,
    holds: impl Fn(Statement, f64) -> Option<bool>,
) -> [Intervals; STATEMENTS] {
    let mut position = 0;
    Statement::ALL.map(|statement| {
        let of_one: Vec<_> = judged.iter().map(|(value, all)| (*value, all[position])).collect();
        position += 1;
        Intervals::between(&of_one, known, closeness, |value| holds(statement, value)).times(unit)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::behaviour::behaviour;
    use crate::{Friction, Machine, example};
    use slipmap_model::friction::Table;

    /// Friction that rises: the machine stick-slips at no belt speed, as far as the data reach.
    #[test]
    fn a_limit_that_does_not_exist_is_told_from_an_unknown_one() {
        let model = example(Law::Exponential).model().unwrap();
        let speeds = belt_speeds(&model.column().curve, SPEEDS_PER_DECADE);
        let (slowest, fastest) = (speeds[0], *speeds.last().unwrap());
        let highest = |holds: &dyn Fn(f64) -> Option<bool>| {
            let judged: Vec<_> = speeds.iter().map(|speed| (*speed, holds(*speed))).collect();
            Intervals::between(&judged, &[], &CLOSE, holds).highest()
        };
        let below = |known: f64, limit: f64| highest(&|speed| (speed < known).then_some(speed < limit));
        assert_eq!(below(f64::INFINITY, f64::INFINITY), Limit::AtLeast(fastest));
        assert!(
            matches!(below(f64::INFINITY, 2.0), Limit::Below(at) if (at - 2.0).abs() < 2.0 * CLOSE.width)
        );
        assert_eq!(below(f64::INFINITY, 0.0), Limit::NoneUpTo(fastest));
        assert!(matches!(below(5.0, 0.0), Limit::NoneUpTo(at) if at < 5.0 && at > 4.0));
        assert!(matches!(below(5.0, f64::INFINITY), Limit::AtLeast(at) if at < 5.0 && at > 4.0));
        assert_eq!(below(0.0, 0.0), Limit::NotDetermined);
        // Unknown at the slowest speed.
        let slow = highest(&|speed| (speed > slowest).then_some(false));
        assert_eq!(slow, Limit::NotDetermined);
        // Unknown around the limit.
        let gap = highest(&|speed| (!(0.5..=2.0).contains(&speed)).then_some(speed < 1.0));
        assert!(matches!(gap, Limit::Between(low, high) if low < 0.5 && low > 0.4 && high > 2.0), "{gap:?}");
        // Above a limit it is unknown whether there is a higher one.
        let above = highest(&|speed| (!(2.0..3.0).contains(&speed)).then_some(speed < 1.0));
        assert!(matches!(above, Limit::AtLeast(at) if (at - 1.0).abs() < 2.0 * CLOSE.width), "{above:?}");
        let data = [0.0, 0.05, 0.1, 0.2, 0.5, 1.2].map(|u| (u, 0.3 + 0.2 * u));
        let friction = Friction::Measured(Table::new("rises", &data, 0.3).unwrap());
        let machine = Machine { friction, belt_speed: 0.2, ..example(Law::Stribeck) };
        let limit = |machine: &Machine| behaviour(&machine.model().unwrap(), TOLERANCE).critical_belt_speed;
        let found = limit(&machine);
        assert!(matches!(found, Limit::NoneUpTo(speed) if speed > 0.5 && speed <= 0.6), "{found:?}");
        // Friction that falls as far as the data reach: the limit lies beyond the speed whose orbit reaches their end.
        let data = data.map(|(u, mu)| (u, 0.6 - mu));
        let friction = Friction::Measured(Table::new("falls", &data, 0.3).unwrap());
        let falls = Machine { friction, damping: 0.0, ..machine };
        let found = limit(&falls);
        assert!(matches!(found, Limit::AtLeast(speed) if speed > 0.45 && speed <= 0.6), "{found:?}");
    }
}

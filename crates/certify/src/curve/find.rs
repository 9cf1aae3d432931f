//! The finder: an orbit of the turned flow that closes, cut into polynomials which the checker accepts.
//!
//! A piece of degree 9 goes through the states at the Chebyshev-Lobatto times of an interval of time: equal
//! times, not lengths, so that layers next to the line are resolved by themselves. The interval grows as long
//! as samples of S keep a share of what the exact orbit has, and the checker proves the sign; else it
//! shrinks.

use std::cell;
use std::sync::LazyLock;

use super::check::{Budget, Cell, Field};
use super::column::Stop;
use super::follow::{End, State, Turned, Until};
use super::{CurveKind, MOST_DEGREE, MOST_PIECES, OneWay};
use slipmap_model::friction::Column;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::chebyshev::node;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::roots::{Bracket, falling_root};

const COUNT: usize = MOST_DEGREE + 1;
/// Number of places at which S is sampled on a piece.
const SAMPLES: usize = 27;
/// Least share of S that the samples must have.
const SHARE: f64 = 0.3;
/// First interval of time of a piece, of the whole half, and its factors.
const FIRST: f64 = 0.05;
const SHRINKS: f64 = 0.7;
const GROWS: f64 = 1.25;
/// Largest number of trials of one piece.
const MOST_TRIALS: usize = 60;
/// Largest number of factors of two between the guess of kappa and a bracket.
const MOST_DOUBLINGS: usize = 40;
/// Relative accuracy of kappa: what is left of a gap is small against what kappa turns.
const ENOUGH: f64 = 1e-10;
/// Quota of a column: steps of orbits, a few microseconds each. It ends the search of a law with a kink, which took 40 s of
/// processor time in vain, within two seconds.
const MOST_STEPS: u64 = 400_000;
/// kappa of curves that land.
const LANDING: [f64; 7] = [0.2, 0.1, 0.05, 0.02, 0.01, 5e-3, 1e-3];
/// Relative distance of an inward end from the line: of the size of what kappa turns there.
const END: f64 = 1e-3;

/// Times, in [0, 1], of the states that a piece goes through; its control points as sums of the states.
static NODES: LazyLock<[f64; COUNT]> =
    LazyLock::new(|| std::array::from_fn(|i| 0.5 * (1.0 - node(i, COUNT - 1))));
static WEIGHTS: LazyLock<Vec<[f64; COUNT]>> = LazyLock::new(|| inverse(NODES.map(bernstein)));
static AT_SAMPLES: LazyLock<Vec<[f64; COUNT]>> =
    LazyLock::new(|| (0..SAMPLES).map(|i| bernstein(0.5 * (1.0 - node(i, SAMPLES - 1)))).collect());

/// The Bernstein polynomials of degree 9 at t.
fn bernstein(t: f64) -> [f64; COUNT] {
    let mut row = [0.0; COUNT];
    row[0] = 1.0;
    for degree in 1..COUNT {
        for i in (0..=degree).rev() {
            let before = if i > 0 { row[i - 1] } else { 0.0 };
            row[i] = (1.0 - t).times_plus(row[i], t * before);
        }
    }
    row
}

/// The inverse of a matrix, by Gauss and Jordan.
fn inverse(mut a: [[f64; COUNT]; COUNT]) -> Vec<[f64; COUNT]> {
    let mut b: Vec<[f64; COUNT]> = (0..COUNT).map(|i| std::array::from_fn(|j| f64::from(i == j))).collect();
    for k in 0..COUNT {
        let pivot = (k..COUNT).max_by(|&i, &j| a[i][k].abs().total_cmp(&a[j][k].abs())).unwrap_or(k);
        a.swap(k, pivot);
        b.swap(k, pivot);
        let scale = 1.0 / a[k][k];
        let (own, also) = (a[k].map(|x| x * scale), b[k].map(|x| x * scale));
        (a[k], b[k]) = (own, also);
        for i in (0..COUNT).filter(|i| *i != k) {
            let factor = a[i][k];
            for j in 0..COUNT {
                a[i][j] -= factor * own[j];
                b[i][j] -= factor * also[j];
            }
        }
    }
    b
}

/// Half a curve: the flow, the first state, the state at which it ends after a time, and the direction of
/// time.
struct Half<'a> {
    flow: Turned<'a>,
    from: State,
    to: State,
    time: f64,
    sign: f64,
}

/// The control points of a piece.
type Points = Vec<[f64; 2]>;

/// The state and the time at which the flow leaves its section, if it does.
type Leaves = Option<(State, f64)>;

/// A piece as it may become one of the curve: control points in the order of the curve, the time and the
/// state at its end.
struct Trial {
    points: Points,
    time: f64,
    state: State,
}

impl Half<'_> {
    fn trial(&self, from: State, time: f64, h: f64) -> Option<Trial> {
        let flow = self.flow.near(from, self.sign);
        let h = h.min(flow.room(from, self.sign));
        let mut end = (time + h).min(self.time);
        if self.time - end < 0.2 * h {
            end = self.time;
        }
        let (mut states, left) = Self::states(&flow, from, self.sign, end - time)?;
        if end == self.time {
            states[COUNT - 1] = self.to;
        }
        if let Some((corner, after)) = left {
            // Up to the corner of the law only.
            end = time + after;
            states = Self::states(&flow, from, self.sign, after)?.0;
            states[COUNT - 1] = corner;
        }
        let points = self.through(&states);
        let is_known = points.iter().all(|point| (0.0..=self.flow.field.law.reach()).contains(&point[0]));
        let lies_well =
            is_known && self.flow.field.place(&points).is_some() && Self::seems_one_way(&flow, &points);
        lies_well.then_some(Trial { points, time: end, state: states[COUNT - 1] })
    }

    /// The states at the nodes of an interval of time; the state and the time at which the flow leaves its
    /// section.
    fn states(flow: &Turned, from: State, sign: f64, h: f64) -> Option<([State; COUNT], Leaves)> {
        let (mut states, mut left) = ([from; COUNT], None);
        for i in 1..COUNT {
            states[i] = flow.after(states[i - 1], sign * (NODES[i] - NODES[i - 1]) * h)?;
            if left.is_none() {
                left = flow.leaves(states[i], sign).map(|(corner, back)| (corner, NODES[i] * h + back));
            }
        }
        Some((states, left.filter(|(_, after)| *after > 0.0 && *after < h)))
    }

    /// Whether samples of S keep their share of kappa times the product of the speeds of curve and flow.
    fn seems_one_way(flow: &Turned, points: &[[f64; 2]]) -> bool {
        let degree = (COUNT - 1) as f64;
        AT_SAMPLES.iter().all(|row| {
            let sum = |axis: usize| -> f64 { row.iter().zip(points).map(|(w, x)| w * x[axis]).sum() };
            let [u, y] = [sum(0), sum(1)];
            // The derivative: differences of the control points, with the polynomials of one degree less.
            let slope = |axis: usize| -> f64 {
                let differences = points.windows(2).map(|ends| ends[1][axis] - ends[0][axis]);
                degree * differences.zip(lowered(row)).map(|(d, w)| d * w).sum::<f64>()
            };
            let [us, ys] = [slope(0), slope(1)];
            let [force, a] = flow.force([u, y]);
            let s = -us * force - ys * y;
            let moves = force * force / a + a * y * y;
            let speed = ((a * us * us + ys * ys / a) / moves).sqrt();
            -s * flow.kappa >= SHARE * flow.kappa * flow.kappa * moves * speed
        })
    }

    /// The pieces of the half, in the order in which they are found, and the shares of its time at which they end.
    fn pieces(&self, budget: &mut Budget) -> Result<(Vec<Points>, Vec<f64>), Stop> {
        let (mut state, mut time, mut h) = (self.from, 0.0, FIRST * self.time);
        let (mut found, mut shares) = (Vec::new(), Vec::new());
        while time < self.time {
            let (mut trial, mut trials) = (self.trial(state, time, h), 0);
            while trial.is_none() && trials < MOST_TRIALS {
                h *= SHRINKS;
                trials += 1;
                trial = self.trial(state, time, h);
            }
            let Some(mut best) = trial else { return Err(Stop::Pieces) };
            while trials == 0 && best.time < self.time {
                let longer = self.trial(state, time, GROWS * h).filter(|longer| longer.time > best.time);
                let Some(longer) = longer else { break };
                h *= GROWS;
                best = longer;
            }
            loop {
                match self.flow.field.crosses(&best.points, -self.flow.kappa.signum(), budget) {
                    Ok(()) => break,
                    Err(Cell::NoEnclosure(at)) => return Err(Stop::NoEnclosure { at }),
                    Err(Cell::TooMuchWork) => return Err(Stop::TooMuchWork),
                    Err(Cell::Sign) => {}
                }
                h = SHRINKS * (best.time - time);
                trials += 1;
                if trials > MOST_TRIALS {
                    return Err(Stop::Pieces);
                }
                best = self.trial(state, time, h).unwrap_or(best);
            }
            (state, time) = (best.state, best.time);
            found.push(best.points);
            shares.push(time / self.time);
            if found.len() > MOST_PIECES / 2 {
                return Err(Stop::TooMuchWork);
            }
        }
        Ok((found, shares))
    }

    /// The pieces that end at these shares of its time, in the order of [`Half::pieces`].
    fn divided(&self, shares: &[f64]) -> Option<Vec<Points>> {
        let (mut from, mut time, mut found) = (self.from, 0.0, Vec::new());
        for (i, share) in shares.iter().enumerate() {
            let flow = self.flow.near(from, self.sign);
            let (mut states, _) = Self::states(&flow, from, self.sign, share * self.time - time)?;
            if i + 1 == shares.len() {
                states[COUNT - 1] = self.to;
            }
            (from, time) = (states[COUNT - 1], share * self.time);
            found.push(self.through(&states));
        }
        Some(found)
    }

    /// The control points of the piece through states at the nodes, in the order of the curve.
    fn through(&self, states: &[State; COUNT]) -> Points {
        let sum = |row: &[f64; COUNT], axis: usize| row.iter().zip(states).map(|(w, x)| w * x[axis]).sum();
        let mut points: Points = WEIGHTS.iter().map(|row| [sum(row, 0), sum(row, 1)]).collect();
        (points[0], points[COUNT - 1]) = (states[0], states[COUNT - 1]);
        if self.sign < 0.0 {
            points.reverse();
        }
        points
    }
}

/// The Bernstein polynomials of one degree less.
fn lowered(row: &[f64; COUNT]) -> [f64; COUNT - 1] {
    let n = (COUNT - 1) as f64;
    std::array::from_fn(|i| ((n - i as f64) / n).times_plus(row[i], (i as f64 + 1.0) / n * row[i + 1]))
}

/// Finds curves of one column.
pub(super) struct Finder {
    field: Field,
    /// The steps of orbits that are left.
    work: cell::Cell<u64>,
}

impl Finder {
    pub(super) fn new(column: &Column) -> Self {
        Self { field: Field::new(column), work: cell::Cell::new(MOST_STEPS) }
    }

    pub(super) fn field(&self) -> &Field {
        &self.field
    }

    /// Has curves start farther from the drop, on their side.
    pub(super) fn widen_drop(&mut self, slack: f64) {
        let drop = self.field.drop;
        if drop.hi > 0.0 {
            let slack = slack + 1e-6 * drop.hi;
            self.field.drop = (drop + Interval::new(-slack, slack)).at_least_zero();
        }
    }

    /// First and last state of a curve that closes.
    fn ends(flow: &Turned, kind: CurveKind) -> [State; 2] {
        let (kappa, belt_speed) = (flow.kappa.abs(), flow.field.belt_speed);
        let a = flow.metric(0.0);
        let y = 2.0 * kappa * belt_speed / a;
        let drop = flow.field.drop;
        match kind {
            CurveKind::Returns => [[0.0, -drop.lo], [0.0, y]],
            _ if drop.hi > 0.0 => [[0.0, -drop.hi], [END * kappa * belt_speed / (a * a), 0.0]],
            _ => [[0.0, -y], [END * kappa * belt_speed / (a * a), 0.0]],
        }
    }

    /// How far the half forward from the start turns left of the half backward from the end; `None` beyond
    /// the law.
    fn mismatch(flow: &Turned, [start, end]: [State; 2]) -> (f64, [End; 2]) {
        let halves = [(start, 1.0), (end, -1.0)].map(|(from, sign)| flow.follow(from, sign, Until::Turns));
        let most = 1e3 * flow.field.belt_speed;
        let [one, two] = halves.map(|end| match end {
            End::At { state, .. } => state[0].min(most),
            End::Beyond => most,
            End::Creeps => -most,
        });
        (one - two, halves)
    }

    /// c*, approximately, between two dampings.
    pub(super) fn critical(&self, [lo, hi]: [f64; 2]) -> Result<f64, Stop> {
        let at = |damping: f64| {
            let field = self.field.at(damping);
            let flow = Turned::new(&field, 0.0, &self.work);
            Self::mismatch(&flow, [[0.0, -field.drop.hi], [0.0, 0.0]]).0
        };
        let (low, high) = ((lo, at(lo)), (hi, at(hi)));
        if !(low.1 > 0.0) {
            return Err(Stop::NeverReturns { at: lo });
        }
        if !(high.1 < 0.0) {
            return Err(Stop::AlwaysReturns { at: hi });
        }
        let enough = 1e-13 * (hi - lo).min(lo.abs().max(hi.abs()));
        let found: Result<_, Stop> = falling_root(Bracket { low, high }, enough, |c| Ok(at(c)));
        Ok(found?.0)
    }

    /// kappa, with its sign, with which a curve closes in a field; `guess` is a guess of its size.
    fn closes(&self, field: &Field, kind: CurveKind, guess: f64) -> Result<f64, Stop> {
        let sign = -kind.sign();
        // Positive for small kappa: turning moves an outward curve inwards, and an inward one outwards.
        let at = |log: f64| {
            let flow = Turned::new(field, sign * log.exp(), &self.work);
            -sign * Self::mismatch(&flow, Self::ends(&flow, kind)).0
        };
        let mut log = guess.max(f64::MIN_POSITIVE).ln();
        let mut value = at(log);
        let step = std::f64::consts::LN_2.copysign(value);
        let mut bracket = None;
        for _ in 0..MOST_DOUBLINGS {
            let (next, there) = (log + step, at(log + step));
            if (there > 0.0) != (value > 0.0) {
                let [one, two] = [(log, value), (next, there)];
                bracket = Some(if step > 0.0 {
                    Bracket { low: one, high: two }
                } else {
                    Bracket { low: two, high: one }
                });
                break;
            }
            (log, value) = (next, there);
        }
        let bracket = bracket.filter(|it| it.high.1 < 0.0).ok_or(Stop::NotClosed)?;
        let found: Result<_, Stop> = falling_root(bracket, ENOUGH, |log| Ok(at(log)));
        Ok(sign * found?.0.exp())
    }

    /// A curve that closes, at c; `guess` is a guess of kappa.
    pub(super) fn closed(&self, kind: CurveKind, damping: f64, guess: f64) -> Result<Found, Stop> {
        let field = self.field.at(damping);
        let found = self.closes(&field, kind, guess).and_then(|kappa| {
            let flow = Turned::new(&field, kappa, &self.work);
            let halves = Self::closing(&flow, kind).ok_or(Stop::NotClosed)?;
            Found::of(kind, &flow, &halves, &mut Budget::of_a_curve())
        });
        found.map_err(|why| self.because(why))
    }

    /// The halves of a curve that nearly closes.
    fn closing<'a>(flow: &Turned<'a>, kind: CurveKind) -> Option<Vec<Half<'a>>> {
        let [start, end] = Self::ends(flow, kind);
        let (_, halves) = Self::mismatch(flow, [start, end]);
        let [End::At { state: one, time: down }, End::At { state: two, time: up }] = halves else {
            return None;
        };
        let middle = [0.5 * (one[0] + two[0]), 0.0];
        let half = |from, time, sign| Half { flow: *flow, from, to: middle, time, sign };
        Some(vec![half(start, down, 1.0), half(end, up, -1.0)])
    }

    /// The way to the stick segment.
    fn way<'a>(flow: &Turned<'a>) -> Result<Vec<Half<'a>>, Stop> {
        let Field { drop, law, damping, .. } = flow.field;
        let [start, _] = Self::ends(flow, CurveKind::Lands);
        match flow.follow(start, 1.0, Until::Lands) {
            End::At { state, time } if state[1] < 2.0 - drop.hi => {
                Ok(vec![Half { flow: *flow, from: start, to: state, time, sign: 1.0 }])
            }
            End::At { .. } => Err(Stop::LandsBeyond { damping: *damping }),
            End::Beyond => Err(Stop::BeyondTheLaw { known: law.reach() }),
            End::Creeps => Err(Stop::NotClosed),
        }
    }

    /// A curve that lands on the stick segment, at c.
    pub(super) fn landing(&self, damping: f64) -> Result<Found, Stop> {
        let field = self.field.at(damping);
        let mut stop = Stop::NotClosed;
        for kappa in LANDING {
            let flow = Turned::new(&field, kappa, &self.work);
            let found = Self::way(&flow)
                .and_then(|halves| Found::of(CurveKind::Lands, &flow, &halves, &mut Budget::of_a_curve()));
            match found {
                Ok(found) => return Ok(found),
                Err(why) => stop = self.because(why),
            }
            if stop == Stop::TooMuchWork {
                break;
            }
        }
        Err(stop)
    }

    /// The reason why nothing was found: that no steps are left, where that is it.
    fn because(&self, why: Stop) -> Stop {
        if self.work.get() == 0 { Stop::TooMuchWork } else { why }
    }

    /// The control points of a curve found elsewhere, divided at the same shares of time, here and at c.
    pub(super) fn again(&self, found: &Found, damping: f64) -> Option<Vec<Points>> {
        let (field, kind) = (self.field.at(damping), found.curve.kind);
        let kappa = match kind {
            CurveKind::Lands => found.kappa,
            _ => self.closes(&field, kind, found.kappa.abs()).ok()?,
        };
        let flow = Turned::new(&field, kappa, &self.work);
        let halves = match kind {
            CurveKind::Lands => Self::way(&flow).ok()?,
            _ => Self::closing(&flow, kind)?,
        };
        let pieces = halves.iter().zip(&found.shares).map(|(half, shares)| half.divided(shares));
        pieces.collect::<Option<Vec<_>>>().map(in_order)
    }
}

/// The pieces of the halves, in the order of the curve.
fn in_order(mut halves: Vec<Vec<Points>>) -> Vec<Points> {
    if let Some(last) = halves.get_mut(1) {
        last.reverse();
    }
    halves.into_iter().flatten().collect()
}

/// A curve, and what it was made of.
pub(super) struct Found {
    pub(super) curve: OneWay,
    kappa: f64,
    /// The shares of the time of each half at which pieces end.
    shares: Vec<Vec<f64>>,
}

impl Found {
    fn of(kind: CurveKind, flow: &Turned, halves: &[Half], budget: &mut Budget) -> Result<Self, Stop> {
        let found = halves.iter().map(|half| half.pieces(budget)).collect::<Result<Vec<_>, Stop>>()?;
        let (pieces, shares) = found.into_iter().unzip();
        let pieces = in_order(pieces).into_iter().map(|piece| piece.into_iter().collect()).collect();
        let along = std::iter::empty().collect();
        let curve = OneWay { kind, c: flow.field.damping, pieces, along };
        Ok(Self { curve, kappa: flow.kappa, shares })
    }
}

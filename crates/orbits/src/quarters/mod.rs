//! The damping at which an orbit closes, from its four quarters: for laws that fall steeply next to the belt line, for
//! friction that drops as slip begins, and wherever the orbit's polar angle is not monotone in time, or hardly so.
//!
//! The orbit that starts at (x2, x2') = (`radius`, -j) and ends at the maximum `radius` of x2 turns at a lowest point x2 =
//! -R. From the start, from the end backward in time, and from the lowest point in both directions of time it is followed
//! to x2 = 0. With s = 1 forward and -1 backward, W = |x2'| and the distance m from where the quarter begins, which is at
//! |x2| = a, each quarter obeys
//!
//! ```text
//! dW/dm = s D(u) + (a - m)/W,    W(0) = 0, or j at the start,    D = w(u) - C
//! ```
//!
//! so that the distance of two solutions at the same slip speed u never grows: all quarters are stable, however steep
//! the law, and W vanishes nowhere on the way. Beyond x2 = 0 they are not: where friction is steep, the end of the orbit
//! creeps up to the belt line along an unstable curve of equilibria. The state is the energy beyond that of the beginning,
//! h = ((a - m)^2 + W^2 - a^2)/2, with its derivative by C:
//!
//! ```text
//! dh/dt = s D W^2,    d(dh/dC)/dt = s (D dh/dC - W^2),    t the time along the quarter
//! ```
//!
//! At x2 = 0, h changes with a^2/2 by the exponential of the integral of s D dt (Liouville's formula, at fixed u). The
//! orbit closes where W at x2 = 0 is the same from above and from below, on both ways: two equations for C and R, by
//! Newton's method for the logarithms of W^2 and R^2, nearly linear in C as those of linear orbits are. From above W falls
//! with C forward in time and rises backward; from below it rises with R. So C is below the root where W is larger from above
//! forward and less backward, and above it where both are the other way round, whatever R; else R is below or above its
//! own root, whatever C. A quarter that creeps up to the equilibrium, at a node, arrives there with W = 0: its sign counts, too.
//!
//! **Steps.** The variable is the angle th of m = a (1 - cos th), in which W is smooth at the start. Steps grow in
//! geometric progression out of the layer in which the law is steep: their number grows like the logarithm of its width.
//! They pass over no piece of the law: it may be flat but for a layer that is not steep.
//!
//! **The creeping end.** Where -s D is large, W follows (m - a)/(s D), and forgets its start. The quarter starts so late
//! that it forgets this start as far as the tolerance needs, and early steps are not stiff; but not where braking has not
//! yet taken away the speed with which it came.
//!
//! **Error.** The sum of the local error estimates of h, each carried to x2 = 0 by the exponential of the integral of s D
//! over the time between: an error e of h is one of 2 e/W^2 of ln W^2.

mod lanes;
mod quarter;

use std::borrow::Cow;
use std::sync::Arc;

use super::polar::Closing;
use super::work::Work;
use lanes::{Arrival, follow, most_steps};
use quarter::{Quarter, Rate, layer};
use slipmap_model::corners::Layers;
use slipmap_model::filippov::HopfRate;
use slipmap_model::friction::{Curve, Weakening};
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::vectorized;

/// Error of C of the first orbits, which only lead near a root, in units of C.
const ROUGH: f64 = 1e-5;
/// Largest tolerance: of 3,600 coarser orbits two had an error of twice the estimate.
const COARSEST: f64 = 1e-9;
/// Change of C, in units of C and of the fourth root of the tolerance, after which the next orbit is usually the last one.
/// For 12,000 falls of widths from 1e-6 to 0.1 a factor of 5 took up to a fifth more work than 20, one of 60 a tenth.
const NEARLY: f64 = 20.0;
/// Least unit of C, so that errors in it do not underflow.
const LEAST_SIZE: f64 = 1e-200;
/// Largest step of ln R^2, and the largest after which the next orbit may be the last: a law may have more than its
/// derivatives tell on the way of a longer one. Of 18,000 orbits over steep steps from six starts each, 6 disagreed beyond
/// their errors where this was 0.1, and one at 0.003, for a hundredth of the work.
const LONGEST_STEP: f64 = 2.0;
const SHORT_STEP: f64 = 0.003;
/// Least mismatch, in units of its error, whose sign is certain.
const CERTAIN: f64 = 2.0;
/// Largest number of orbits in the search for a root; three are usual.
const MOST_ORBITS: u32 = 40;
/// Safety factor of the error left by a step of Newton's method.
const CURVATURE: f64 = 4.0;
/// Error of a law's polynomials, in units of the size of C, above which orbits follow the law itself.
const WORST: f64 = 1e-8;
/// Distance of the bounds of a search from the mean weakening rate where nothing proves bounds, absolute and relative.
pub const WIDE: f64 = 4.0;

/// An orbit whose C is sought: a column's law, and the maximum of x2 at which the orbit closes.
#[derive(Clone, Copy)]
pub struct Sought<'a> {
    curve: &'a Curve,
    belt_speed: f64,
    radius: f64,
    /// -x2' at the start.
    drop: f64,
    layer: Option<f64>,
    /// C at which the search begins, its size for which errors are allowed, and its bounds.
    start: f64,
    size: f64,
    bounds: [f64; 2],
    /// The quota that it draws on, and the number of orbits that do, each of which has at most twice its share at once.
    work: &'a Work,
    sharing: usize,
}

impl<'a> Sought<'a> {
    /// The orbit from the exit point, where friction drops as slip begins or falls so steeply that the polar angle is not
    /// monotone; `None` elsewhere. The search begins at `start` and stays within bounds.
    pub fn from_exit(
        curve: &'a Curve,
        belt_speed: f64,
        work: &'a Work,
        start: impl FnOnce() -> f64,
        bounds: impl FnOnce() -> [f64; 2],
    ) -> Option<Self> {
        let (layer, drop) = (layer(curve, belt_speed, belt_speed), curve.drop());
        if layer.is_none() && drop == 0.0 {
            return None;
        }
        let (start, bounds) = (start(), bounds());
        let (radius, size) = (belt_speed, start.abs());
        Some(Self { curve, belt_speed, radius, drop, layer, start, size, bounds, work, sharing: 1 })
    }

    /// The orbit through the maximum `radius` <= V of x2. Its C lies between the bounds of the even part of the
    /// weakening rate (theory, "The backbone"), and near `guess` where there is one.
    pub fn of_amplitude(
        curve: &'a Curve,
        belt_speed: f64,
        radius: f64,
        guess: Option<f64>,
        work: &'a Work,
    ) -> Self {
        let even = curve.even_weakening_range(belt_speed);
        let mean = curve.rough_mean_weakening(belt_speed);
        // Rounding may change the signs at the bounds.
        let pad = 1e-9 * (even.hi - even.lo) + 1e-13 * even.lo.abs().max(even.hi.abs());
        let far = WIDE * (1.0 + mean.abs());
        let low = if even.lo.is_finite() { even.lo - pad } else { mean - far };
        let high = if even.hi.is_finite() { even.hi + pad } else { mean + far };
        let layer = layer(curve, belt_speed, radius);
        let start = guess.unwrap_or(mean);
        let size = start.abs().max(mean.abs());
        let bounds = [low, high];
        Self { curve, belt_speed, radius, drop: 0.0, layer, start, size, bounds, work, sharing: 1 }
    }
}

impl Sought<'_> {
    /// The orbit as one of this number that draw on the same quota.
    #[must_use]
    pub fn sharing(self, sharing: usize) -> Self {
        Self { sharing, ..self }
    }
}

/// The state of a search.
struct Search<'a> {
    /// The quarter from the start forward in time; the others differ from it by where and how they begin.
    first: Quarter<'a>,
    belt_speed: f64,
    /// Bounds of the errors of C and of h by that of the law's polynomials, or its rounding errors.
    form: f64,
    form_of_energy: f64,
    /// Cost of an evaluation.
    cost: u64,
    viscous: f64,
    bounds: [f64; 2],
    /// Unit of C, and its accuracy.
    size: f64,
    aim: f64,
    is_accurate: bool,
    /// ln (R / radius)^2 and its bounds, and the quarters from above at this C, once they are known.
    depth: Option<f64>,
    depths: [f64; 2],
    above: Option<[Arrival; 2]>,
    /// The orbit before.
    before: Option<Before>,
    /// The least W^2 at x2 = 0.
    square: f64,
    /// Derivative by C of the gap, see [`Meeting::of_ways`].
    steepness: f64,
    rhs: u64,
    work: &'a Work,
    sharing: usize,
}

/// How quarters meet at x2 = 0, on the way down and on the way up.
struct Meeting {
    /// ln W^2 from above less from below on the way down, from below less from above on the way up: both fall with C.
    mismatch: [f64; 2],
    errors: [f64; 2],
    /// Derivatives of the mismatches by C and by ln R^2.
    by_damping: [f64; 2],
    by_depth: [f64; 2],
}

impl Meeting {
    /// The meeting of quarters, of which R^2 - radius^2 is `more`; on the way up the quarter from above is followed backward
    /// in time, on the way down that from below.
    fn of(above: [Arrival; 2], below: [Arrival; 2], more: f64) -> Self {
        let ratio = |way: usize| match [above[way].square, below[way].square] {
            // One of them is at rest, and infinitely slower.
            [above, below] if above * below == 0.0 => (above / below).ln(),
            [_, square] => ((2.0 * (above[way].h - below[way].h) - more) / square).ln_1p(),
        };
        let by_square =
            |value: f64, arrival: &Arrival| if value == 0.0 { 0.0 } else { 2.0 * value / arrival.square };
        let relative = |arrival: &Arrival| by_square(arrival.error, arrival);
        let slope = |arrival: &Arrival| by_square(arrival.by_damping, arrival);
        Self {
            mismatch: [ratio(0), -ratio(1)],
            errors: [0, 1].map(|way| relative(&above[way]) + relative(&below[way])),
            by_damping: [slope(&above[0]) - slope(&below[0]), slope(&below[1]) - slope(&above[1])],
            by_depth: [-below[0].by_radius, below[1].by_radius],
        }
    }

    /// The sum of what belongs to both ways in which a change of R cancels: of the mismatches the gap that no R closes.
    fn of_ways(&self, [down, up]: [f64; 2]) -> f64 {
        let [of_down, of_up] = self.by_depth.map(f64::abs);
        2.0 * of_down.times_plus(up, of_up * down) / (of_down + of_up)
    }

    /// The step of ln R^2 that belongs to one of C, on the way on which ln W^2 feels R more.
    fn deeper(&self, change: f64) -> f64 {
        let way = usize::from(self.by_depth[1].abs() > self.by_depth[0].abs());
        -self.by_damping[way].times_plus(change, self.mismatch[way]) / self.by_depth[way]
    }

    /// The gap that a step in C and ln R^2 leaves, by the change of the derivatives on the `way` here; infinite for a longer
    /// one.
    fn bend(&self, before: &Self, way: [f64; 2], step: [f64; 2]) -> f64 {
        let shorter = step.iter().zip(way).map(|(step, way)| (step / way).abs()).fold(0.0, f64::max);
        let bend = |way: usize| {
            let by_damping = self.by_damping[way] - before.by_damping[way];
            let by_depth = self.by_depth[way] - before.by_depth[way];
            (by_damping * step[0]).abs() + (by_depth * step[1]).abs()
        };
        if shorter <= 1.0 { 0.5 * self.of_ways([bend(0), bend(1)]) * shorter } else { f64::INFINITY }
    }
}

/// An orbit.
struct Before {
    viscous: f64,
    depth: f64,
    meeting: Meeting,
}

/// A law in the form in which quarters follow it.
struct Law<'a> {
    weakening: Option<Arc<Weakening>>,
    stops: Cow<'a, [f64]>,
    layers: Layers,
}

impl<'a> Law<'a> {
    fn of(&Sought { curve, belt_speed, radius, drop, layer, .. }: &Sought<'a>) -> Self {
        // How fast an orbit may slip that friction drives: it changes the speed by 1 at most.
        let fastest = match layer.is_none() && drop == 0.0 {
            true => 2.0 * belt_speed,
            false => belt_speed + radius.hypot(1.0),
        };
        let weakening = (!curve.has_closed_form()).then(|| curve.compiled(2.0 * fastest));
        let stops = weakening.as_ref().map_or_else(|| curve.stops(fastest), |law| curve.stops_of(law));
        let layers = Layers::of(curve, belt_speed, 2.0 * fastest);
        Self { weakening, stops, layers }
    }
}

impl<'a> Search<'a> {
    fn new(sought: &Sought<'a>, law: &'a Law<'a>, tolerance: f64) -> Self {
        let Sought { curve, belt_speed, radius, drop, layer, start, size, bounds, work, sharing } = *sought;
        // Errors are in units of C, or of the weakening rate where that is moderate.
        let size = match layer.is_none() && drop == 0.0 {
            true => [belt_speed - radius, belt_speed, belt_speed + radius]
                .map(|u| curve.weakening(u).abs())
                .into_iter()
                .fold(size, f64::max),
            false => size.max(1e-3 * curve.weakening(belt_speed).abs()),
        }
        .max(LEAST_SIZE);
        let aim = 0.5 * tolerance.min(COARSEST) * size;
        let on_circle = [belt_speed - radius, belt_speed + radius];
        let rounding = || if layer.is_none() { HopfRate::new(curve, belt_speed).rounding() } else { 0.0 };
        let (rate, form, form_of_energy, cost) = match (curve.exponential_fall(), &law.weakening) {
            (Some(fall), _) => (Rate::Exponential(fall), 0.0, 0.0, 1),
            (None, Some(weakening)) => {
                let form = weakening.error(on_circle[0], on_circle[1]).bound();
                // The energy changes by the error of w times W, which the fall of friction bounds.
                let of_energy =
                    2.0 * radius.hypot(1.0) * weakening.integrated_error(on_circle[0], on_circle[1]);
                let is_accurate = form.min(of_energy / (radius * radius)) <= aim.max(WORST * size);
                match is_accurate {
                    true => (Rate::Polynomials(weakening), form, of_energy, 1),
                    false => (Rate::Law(curve), rounding(), f64::INFINITY, curve.cost()),
                }
            }
            (None, None) => (Rate::Law(curve), rounding(), f64::INFINITY, curve.cost()),
        };
        let viscous = start.clamp(bounds[0], bounds[1]);
        let first = Quarter {
            rate,
            stops: &law.stops,
            layers: &law.layers,
            radius,
            slip: belt_speed - radius,
            toward: 1.0,
            speed: drop,
            layer: layer.unwrap_or(radius),
            viscous,
            sign: 1.0,
            allowed: f64::NAN,
            most_steps: 0,
        };
        Self {
            first,
            belt_speed,
            form,
            form_of_energy,
            cost,
            viscous,
            bounds,
            size,
            // Below the error of the law its rounding errors would shorten the steps.
            aim: aim.max(form.min(form_of_energy / (radius * radius))),
            is_accurate: false,
            depth: None,
            // The law may be known up to a slip speed only.
            depths: [f64::NEG_INFINITY, 2.0 * ((curve.fastest() - belt_speed) / radius).ln()],
            above: None,
            before: None,
            square: radius * radius,
            steepness: 6.0,
            rhs: 0,
            work,
            sharing,
        }
    }
}

impl<'a> Search<'a> {
    /// The quarters to be followed next, forward and backward in time: those from above, then those from below, whose
    /// first R follows from the former.
    fn quarters(&self) -> Vec<Quarter<'a>> {
        let requested = if self.is_accurate { self.aim } else { self.aim.max(ROUGH * self.size) };
        let allowed = 0.5 * requested * self.steepness * self.square;
        let most_steps = most_steps(2 * self.work.left() / (4 * self.cost * self.sharing as u64));
        let forward = Quarter { viscous: self.viscous, allowed, most_steps, ..self.first };
        let mut quarters = Vec::with_capacity(4);
        if self.above.is_none() {
            quarters.extend([forward, Quarter { sign: -1.0, speed: 0.0, ..forward }]);
        }
        if let Some(depth) = self.depth {
            let radius = self.first.radius * (0.5 * depth).exp();
            let slip = self.belt_speed + radius;
            let below = Quarter { radius, layer: radius, slip, toward: -1.0, speed: 0.0, ..forward };
            quarters.extend([Quarter { sign: -1.0, ..below }, below]);
        }
        quarters
    }

    /// Goes on from what was found of the quarters; returns the C at which the orbit closes once it is found, or `Err` with
    /// the number of evaluations once it cannot be.
    fn advance(&mut self, found: &[(Option<Arrival>, u64)]) -> Option<Result<Closing, u64>> {
        let spent = found.iter().map(|(_, rhs)| rhs).sum::<u64>();
        self.rhs += spent;
        if self.work.spend_compiled(spent.saturating_mul(self.cost)).is_err() {
            return Some(Err(self.rhs));
        }
        let arrivals: Option<Vec<Arrival>> = found.iter().map(|(found, _)| *found).collect();
        match (arrivals.as_deref(), self.above, self.depth) {
            (Some(&[one, other]), Some(above), Some(depth)) => self.step(above, [one, other], depth),
            (Some(&[forward, backward, one, other]), None, Some(depth)) => {
                self.step([forward, backward], [one, other], depth)
            }
            (Some(&[forward, backward]), None, None) => {
                self.above = Some([forward, backward]);
                // Right to first order in D.
                let of_unit = |square: f64| (square / self.first.radius.powi(2)).ln();
                let depth = match [forward.square, backward.square] {
                    [0.0, square] | [square, 0.0] => of_unit(square),
                    both => 0.5 * both.map(of_unit).iter().sum::<f64>(),
                };
                self.depth = Some(depth.min(self.depths[1] - SHORT_STEP));
                None
            }
            // A rough quarter that nearly creeps up to the equilibrium may tell nothing.
            _ if !self.is_accurate => {
                (self.is_accurate, self.above) = (true, None);
                None
            }
            _ => Some(Err(self.rhs)),
        }
    }

    /// Makes a step of Newton's method.
    fn step(&mut self, above: [Arrival; 2], below: [Arrival; 2], depth: f64) -> Option<Result<Closing, u64>> {
        self.above = None;
        let squares = above.iter().chain(&below).map(|arrival| arrival.square).filter(|square| *square > 0.0);
        self.square = squares.fold(f64::INFINITY, f64::min);
        let meeting = Meeting::of(above, below, self.first.radius.powi(2) * depth.exp_m1());
        if meeting.mismatch.iter().any(|mismatch| mismatch.is_infinite()) {
            return self.halve(&meeting, depth);
        }
        let [gap, error, by_damping] =
            [meeting.mismatch, meeting.errors, meeting.by_damping].map(|ways| meeting.of_ways(ways));
        let viscous = self.viscous;
        self.steepness = by_damping.abs();
        let change = -gap / by_damping;
        let step = [change, meeting.deeper(change)];
        let before = self.before.as_ref();
        let way = before.map(|before| [viscous - before.viscous, depth - before.depth]);
        let bend =
            before.zip(way).map_or(f64::INFINITY, |(before, way)| meeting.bend(&before.meeting, way, step));
        let [length, own, left] = [change.abs() * self.steepness + step[1].abs(), error, CURVATURE * bend]
            .map(|gap| gap / self.steepness);
        self.bound(&meeting, own, depth);
        let floor = 4.0 * f64::EPSILON * viscous.abs();
        let is_near = length <= own || left <= self.aim.max(own) && step[1].abs() <= SHORT_STEP;
        if self.is_accurate && is_near {
            let error = own
                + left.min(length)
                + self.form.min(2.0 * self.form_of_energy / (self.square * self.steepness))
                + floor;
            let found = Closing { viscous: viscous + change, error, rhs: self.rhs, slope: None };
            return Some(if error.is_finite() { Ok(found) } else { Err(self.rhs) });
        }
        let near = NEARLY * (self.aim / self.size).sqrt().sqrt() * self.size;
        self.is_accurate |= change.abs() <= own.max(near) || self.bounds[1] - self.bounds[0] <= floor;
        let [last, last_deeper] = way.unwrap_or([0.0; 2]);
        self.viscous = within(viscous, viscous + not_back(change, last), self.bounds);
        let deeper = meeting.deeper(self.viscous - viscous).clamp(-LONGEST_STEP, LONGEST_STEP);
        self.depth = Some(within(depth, depth + not_back(deeper, last_deeper), self.depths));
        self.before = Some(Before { viscous, depth, meeting });
        None
    }

    /// Narrows the bounds by the signs of the mismatches, as far as their errors `own` of C allow. Returns these signs, 0
    /// where one is uncertain.
    fn bound(&mut self, meeting: &Meeting, own: f64, depth: f64) -> [f64; 2] {
        let Meeting { mismatch, errors, .. } = meeting;
        let [one, other] =
            [0, 1].map(|way| (mismatch[way] / (CERTAIN * errors[way])).clamp(-1.0, 1.0).trunc());
        // A mismatch whose sign is uncertain may be this many errors from 0.
        let farthest = CERTAIN + 1.0;
        if one + other > 0.0 {
            self.bounds[0] = self.bounds[0].max(self.viscous - farthest * own);
        } else if one + other < 0.0 {
            self.bounds[1] = self.bounds[1].min(self.viscous + farthest * own);
        }
        // Where both signs are certain, or a quarter creeps to rest, R need not feel anything of an error.
        let own = match one * other < 0.0 || mismatch.iter().any(|mismatch| mismatch.is_infinite()) {
            true => 0.0,
            false => {
                farthest * (errors[0] + errors[1]) / meeting.by_depth[0].abs().max(meeting.by_depth[1].abs())
            }
        };
        if one > other {
            self.depths[0] = self.depths[0].max(depth - own);
        } else if one < other {
            self.depths[1] = self.depths[1].min(depth + own);
        }
        [one, other]
    }

    /// Goes on where a quarter creeps up to the equilibrium: C by the way on which none does, if there is one, and R half-way
    /// to its bound once C is near.
    fn halve(&mut self, meeting: &Meeting, depth: f64) -> Option<Result<Closing, u64>> {
        let viscous = self.viscous;
        let [down, up] = meeting.mismatch;
        let of_way = |way: usize| {
            let by_damping = meeting.by_damping[way];
            (-meeting.mismatch[way] / by_damping, meeting.errors[way] / by_damping.abs())
        };
        let ((change, own), deeper) = match (down.is_finite(), up.is_finite()) {
            (true, _) => (of_way(0), -up),
            (false, true) => (of_way(1), down),
            (false, false) => (((down + up) * f64::INFINITY, 0.0), down - up),
        };
        let signs = self.bound(meeting, own, depth);
        self.viscous = within(viscous, viscous + change, self.bounds);
        if signs[0] * signs[1] <= 0.0 {
            self.depth = Some(within(depth, depth + deeper.signum() * LONGEST_STEP, self.depths));
        }
        self.before = None;
        (self.viscous == viscous && self.depth == Some(depth)).then_some(Err(self.rhs))
    }
}

/// `next`, or if that is beyond a bound the place half-way there, from the bound itself half-way to the other one.
fn within(now: f64, next: f64, [low, high]: [f64; 2]) -> f64 {
    match (next > low, next < high) {
        (true, true) => next,
        (false, _) if now > low => 0.5 * (low + now),
        (_, false) if now < high => 0.5 * (now + high),
        _ if (high - low).is_finite() => 0.5 * (low + high),
        _ => now,
    }
}

/// A step after the `last` one: back at most half as far, lest two orbits follow one another for ever.
fn not_back(step: f64, last: f64) -> f64 {
    if step * last < 0.0 { step.abs().min(0.5 * last.abs()).copysign(step) } else { step }
}

/// The C at which many orbits close, with errors of about `tolerance` in units of C; `Err` with the number of evaluations
/// where the form does not apply.
///
/// An orbit's answer does not depend on its neighbours in the slice, nor on the machine's vector width.
pub fn closing_dampings_by_quarters(sought: &[Sought], tolerance: f64) -> Vec<Result<Closing, u64>> {
    let forms: Vec<Law> = sought.iter().map(Law::of).collect();
    let mut answers = vec![Err(0); sought.len()];
    let mut searches: Vec<(usize, Search)> = Vec::with_capacity(sought.len());
    for (number, (sought, law)) in sought.iter().zip(&forms).enumerate() {
        let [low, high] = sought.bounds;
        let &Sought { curve, belt_speed, radius, .. } = sought;
        if radius == belt_speed && curve.is_hidden_by_rounding(belt_speed) {
            continue;
        }
        let may_begin = sought.work.left() > 0;
        if may_begin && sought.start.is_finite() && low.is_finite() && high.is_finite() && low <= high {
            searches.push((number, Search::new(sought, law, tolerance)));
        }
    }
    for _ in 0..MOST_ORBITS {
        let asked: Vec<Vec<Quarter>> = searches.iter().map(|(_, search)| search.quarters()).collect();
        let found = vectorized(
            #[inline(always)]
            || follow(&asked.concat()),
        );
        let (mut found, mut numbers) = (&found[..], asked.iter().map(Vec::len));
        searches.retain_mut(|(number, search)| {
            let own = found.split_off(..numbers.next().unwrap_or(0)).unwrap_or_default();
            let answer = search.advance(own);
            answers[*number] = answer.unwrap_or(Err(search.rhs));
            answer.is_none()
        });
        if searches.is_empty() {
            break;
        }
    }
    answers
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::Piece;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_model::point::LawParameters;
    use slipmap_numbers::random::Random;

    /// Constant divergence: W at x2 = 0 is a exp(D t/2), t = atan2(om, D/2)/om, om^2 = 1 - D^2/4, with its derivatives.
    #[test]
    fn quarters_of_constant_divergence_are_within_their_error() {
        let law = Law::Expression(Expression::new("1", 1.0).unwrap());
        let curve = law.curve(1.0, &LawParameters::new(&[]));
        for d in [-1.9, -1.0, -0.7655, -0.3, -0.01, 0.0, 0.2, 0.7655, 1.5, 1.95] {
            for allowed in [1e-6, 1e-9, 1e-11, 1e-13, 1e-14] {
                for (sign, toward) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    let quarter = Quarter {
                        rate: Rate::Law(&curve),
                        stops: &[],
                        layers: &Layers::of(&curve, 1.0, 4.0),
                        radius: 1.0,
                        slip: 2.0,
                        toward,
                        speed: 0.0,
                        layer: 1.0,
                        viscous: -sign * d,
                        sign,
                        allowed,
                        most_steps: u32::MAX,
                    };
                    let arrival = follow(&[quarter])[0].0.unwrap();
                    let om = (1.0 - 0.25 * d * d).sqrt();
                    let time = f64::atan2(om, 0.5 * d) / om;
                    let exact = 0.5 * ((d * time).exp() - 1.0);
                    let off = (arrival.h - exact).abs();
                    assert!(
                        off <= arrival.error && arrival.error < 2.0 * allowed + 2e-13,
                        "{d} {allowed} {sign} {off}: {arrival:?}"
                    );
                }
            }
        }
    }

    /// Orbits over narrow steps of friction, many of them overdamped outside the step: wherever the search begins, they
    /// close at the same C.
    #[test]
    fn where_an_orbit_closes_does_not_depend_on_the_start() {
        let mut random = Random(95);
        let mut lost = 0;
        // Of the first law a quarter is next to an equilibrium at which D = 0 where it begins to creep; of the second one the
        // search passes through nodes, up to which quarters creep.
        let mut laws = vec![
            (0.097_148_262_405_178_07, 0.319_553_018_821_381_54, 0.958_950_5, 0.017_245_2),
            (0.333_225_066_565_656_04, 0.154_016_051_087_569_63, 1.008_947_863_3, 0.006_071_762_8),
        ];
        laws.extend((0..12).map(|_| {
            let mut between = |from: f64, to: f64| from + (to - from) * random.unit();
            let width = 10_f64.powf(between(-2.0, -1.0));
            (10_f64.powf(between(-1.0, 0.0)), between(0.05, 0.45), between(0.05, 1.95), width)
        }));
        for (belt_speed, fall, place, width) in laws {
            let place = place * belt_speed;
            let width = width * place;
            let text = format!("1 - {fall}*(tanh((u - {place})/{width}) + tanh({place}/{width}))/2");
            let law = Law::Expression(Expression::new(&text, 1.0).unwrap());
            let curve = law.curve(1.0, &LawParameters::new(&[]));
            for share in [0.059_04, 0.1, 0.308_66, 0.4, 0.8, 0.961_94, 1.0] {
                let hopf = curve.weakening(belt_speed);
                let starts = [None, Some(0.0), Some(0.5), Some(2.0), Some(2.68), Some(hopf)];
                let works = starts.map(|start| (start, Work::of(Piece::Critical, &curve)));
                let sought = works.each_ref().map(|(start, work)| {
                    Sought::of_amplitude(&curve, belt_speed, share * belt_speed, *start, work)
                });
                let found = closing_dampings_by_quarters(&sought, 1e-9);
                let closed: Vec<&Closing> = found.iter().flatten().collect();
                lost += found.len() - closed.len();
                for pair in closed.windows(2) {
                    let apart = (pair[0].viscous - pair[1].viscous).abs();
                    assert!(apart <= pair[0].error + pair[1].error, "{text} {belt_speed} {share}: {found:?}");
                    assert!(
                        pair[0].error < 1e-6 * (1.0 + pair[0].viscous.abs()),
                        "{text} {belt_speed}: {found:?}"
                    );
                }
            }
        }
        assert_eq!(lost, 0, "of 588");
    }

    /// Two orbits whose first, rough quarters are misleading: of one the sign of a mismatch is uncertain, of the other a
    /// quarter nearly creeps up to the equilibrium.
    #[test]
    fn rough_quarters_do_not_mislead_the_search() {
        let step = |[fall, place, width]: [f64; 3]| {
            format!(" - {fall}*(tanh((u - {place})/{width}) + tanh({place}/{width}))/2")
        };
        let uncertain = [
            [0.181_573_520_211_791_54, 0.319_212_401_278_765_2, 0.011_132_041_057_913_574],
            [0.183_671_500_843_599_57, 0.068_656_494_365_300_37, 0.000_858_022_603_627_715_8],
        ];
        let creeping = [
            [0.170_504_226_457_859_04, 0.072_545_499_062_986_63, 0.000_796_169_032_147_189_4],
            [0.103_945_283_393_816_3, 0.050_200_385_831_729_79, 0.000_853_262_634_006_854_1],
        ];
        for (steps, belt_speed, radius, guess, exact) in [
            (
                uncertain,
                0.328_571_428_571_428_57,
                0.040_874_134_575_568_884,
                3.178_555_843_456_401,
                3.178_528_071_6,
            ),
            (creeping, 0.05, 0.020_122_741_949_596_797, 3.260_688_038_339, 4.197_166_37),
        ] {
            let law =
                Law::Expression(Expression::new(&format!("1{}", steps.map(step).concat()), 1.0).unwrap());
            let curve = law.curve(1.0, &LawParameters::new(&[]));
            let work = Work::of(Piece::Critical, &curve);
            let sought = Sought::of_amplitude(&curve, belt_speed, radius, Some(guess), &work);
            let found = closing_dampings_by_quarters(&[sought], 1e-9)[0].unwrap();
            assert!((found.viscous - exact).abs() < found.error + 1e-8 * exact, "{found:?}");
        }
    }
}

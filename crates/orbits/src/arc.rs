//! Orbits in the Liénard form, on one side of the belt line at a time, with the data for their stability.
//!
//! With v = x2, w = x2' the flow on either side is v' = w, w' = -v + D(u) w, u = |v - V| (theory, "Two forms
//! of the slip flow"), and x1 follows from x2' = w. The state includes `growth`, the integral of D: by
//! Liouville's formula the flow stretches areas by exp(growth), which is the multiplier of a cycle up to the
//! angles at which its orbit passes the sections.
//!
//! Backward in time, with -w for w, the flow has the same form with -D for D. A cycle that repels then
//! attracts, and is followed without loss of digits.
//!
//! **Error.** By the same formula the error d of a state, to first order, has with the velocity f = (v', w')
//! the cross product d x f = (d x f at an earlier time) exp(growth since then). `spread` adds up the products
//! of the local errors so. It gives the error of what follows from the orbit: where the orbit meets a line,
//! the place on it is off by `spread` over the speed across the line. That is w at the belt line, and |v| at
//! a turn. The local errors are estimates: those of the embedded method, and the rounding of the state; and what the law's
//! form is off by, over the time of the step.

use std::borrow::Cow;
use std::f64::consts::TAU;
use std::sync::Arc;

use super::dop853::{Field, STAGES, step};
use super::work::{Piece, Work};
use slipmap_model::corners::{self, End, Layers};
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::Failure;
use slipmap_model::friction::Range;
use slipmap_model::friction::Weakening;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::{Aligned, vectorized};

/// A step this much shorter than the time scale of the flow has underflowed.
const SHORTEST_STEP: f64 = 1e-14;
/// Number of roundings of the slip speed in a step.
const ROUNDED_SLIPS: f64 = 8.0;
/// Distance from the equilibrium, in units of V, at which an orbit rests: turns of a nearly critical node
/// take the state below the smallest number.
const AT_REST: f64 = 1e-200;
/// Largest number of trials that locate a point within a step; three are usual, and every eighth bisects, which alone
/// would end after 52.
const TRIALS: u32 = 8 * 52;

/// A state on an orbit.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct State {
    /// x2.
    pub v: f64,
    /// x2', by the field of the side on which the orbit is, with the opposite sign where time runs backward.
    pub w: f64,
    /// Integral of the divergence since the start.
    pub growth: f64,
    /// Time since the start.
    pub time: f64,
    /// x2 less the walk's origin.
    x: f64,
    /// The divergence here, with the sign of the direction of time.
    divergence: f64,
    /// Bound of |error x velocity|, by the local error estimates.
    pub spread: f64,
    /// Estimate of the local error of the step that ends here.
    local: f64,
}

impl State {
    /// w'.
    pub fn slope(&self) -> f64 {
        self.divergence.times_plus(self.w, -self.v)
    }

    /// |(v', w')|.
    fn pace(&self) -> f64 {
        self.w.hypot(self.slope())
    }

    /// Bound of |error x velocity| for errors of v and w.
    fn across(&self, [of_v, of_w]: [f64; 2]) -> f64 {
        of_v * self.slope().abs() + of_w * self.w.abs()
    }
}

/// The end of an arc below the belt line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LowerEnd {
    /// x2 has a maximum below V here.
    Turns(State),
    /// The orbit returns to x2 = V here.
    Meets(State),
    /// The orbit tends to the equilibrium without another maximum of x2.
    Rests,
}

/// One turn below the belt line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlipTurn {
    /// x2 has its next maximum below V.
    Returns {
        /// The maximum, P(r).
        radius: f64,
        /// P'(r).
        slope: f64,
        /// Time of the turn.
        time: f64,
    },
    /// The orbit reaches the belt line.
    MeetsBelt {
        /// Distance of (x2, x2') from the origin there, at least V.
        radius: f64,
    },
    /// The orbit tends to the equilibrium without another maximum of x2.
    Rests,
}

/// An orbit on one side of the belt line.
#[derive(Clone, Debug)]
pub struct Walk<'a> {
    oscillator: &'a Oscillator,
    side: Side,
    /// The value of x2 from which states are measured: 0, or V nearer to the line, so that slip speeds and states near
    /// the equilibrium have all their digits.
    origin: f64,
    /// The pieces of the law, of which a step passes over none.
    layers: Layers,
    /// 1, or -1 where time runs backward.
    direction: f64,
    /// The law's compiled polynomials, where they are faster and their error is below that of the orbit.
    weakening: Option<Arc<Weakening>>,
    /// The error of the divergence.
    form: f64,
    /// Slip speeds at which steps end, increasing.
    stops: Cow<'a, [f64]>,
    /// Local error allowed per unit of time.
    allowed: f64,
    /// The state that it has reached.
    pub here: State,
    next_step: f64,
    /// Distance from the equilibrium at which the orbit may have come to rest.
    rest: f64,
    work: &'a Work,
    is_given_up: bool,
}

/// 0, or V where x2 is nearer to the belt speed.
fn nearest_origin(v: f64, belt_speed: f64) -> f64 {
    if v > 0.5 * belt_speed { belt_speed } else { 0.0 }
}

/// The field in the state [v - origin, w, growth].
struct Lienard<'a>(&'a Walk<'a>);

impl Field<3> for Lienard<'_> {
    #[inline(always)]
    fn slope(&mut self, _stage: usize, &Aligned([x, w, _]): &Aligned<3>) -> Aligned<3> {
        let d = self.0.divergence(x);
        Aligned([w, d.times_plus(w, -(self.0.origin + x)), d])
    }
}

/// The root in [0, 1] of the cubic with these values and slopes at 0 and 1, the values of opposite signs: from that of the
/// chord by three steps of Newton's method.
fn root_of_cubic([first, rise, last, fall]: [f64; 4]) -> f64 {
    let (c2, c3) = (3.0 * (last - first) - 2.0 * rise - fall, rise + fall - 2.0 * (last - first));
    let mut x = first / (first - last);
    for _ in 0..3 {
        let (value, slope) = (first + x * (rise + x * (c2 + x * c3)), rise + x * (2.0 * c2 + 3.0 * x * c3));
        x = (x - value / slope).clamp(0.0, 1.0);
    }
    x
}

impl<'a> Walk<'a> {
    /// An orbit that starts at (v, w). The local errors of a turn add up to about `tolerance` times `scale`,
    /// a velocity. Its steps draw on `work`.
    pub fn new(
        oscillator: &'a Oscillator,
        side: Side,
        [v, w]: [f64; 2],
        tolerance: f64,
        scale: f64,
        work: &'a Work,
    ) -> Self {
        let tolerance = tolerance.max(1e-14);
        let curve = &oscillator.curve;
        // Most orbits slip no faster than this: friction changes x2 by 1 at most.
        let fastest = oscillator.belt_speed + v.hypot(w).max(oscillator.belt_speed).hypot(1.0);
        let reaches = [2.0 * fastest, 4.0 * oscillator.belt_speed].into_iter();
        // An error e of the divergence changes x2'' by e x2': e per unit of time, in units of x2'.
        let error_of = |form: &Arc<Weakening>| form.error(0.0, form.reach()).bound();
        let is_accurate = |form: &Arc<Weakening>| error_of(form) <= tolerance / TAU;
        let weakening =
            reaches.filter(|_| curve.cost() > 1).map(|reach| curve.compiled(reach)).find(is_accurate);
        let form = weakening.as_ref().map_or(0.0, error_of) + curve.sampling_error();
        let origin = nearest_origin(v, oscillator.belt_speed);
        let mut walk = Self {
            oscillator,
            side,
            origin,
            layers: Layers::of(curve, oscillator.belt_speed, 4.0 * scale.max(oscillator.belt_speed).max(1.0)),
            direction: 1.0,
            weakening,
            form,
            stops: curve.stops(scale.max(oscillator.belt_speed)),
            allowed: tolerance * scale / TAU,
            here: State { v, w, x: v - origin, ..State::default() },
            rest: 0.0,
            next_step: 1e-3 * oscillator.belt_speed / (v.abs() + w.abs()),
            work,
            is_given_up: false,
        };
        walk.here.divergence = walk.divergence(walk.here.x);
        walk
    }

    /// The orbit that starts on the belt line with x2' = `w`, with errors as in [`Walk::new`] in units of V.
    pub fn from_line(oscillator: &'a Oscillator, side: Side, w: f64, tolerance: f64, work: &'a Work) -> Self {
        let belt_speed = oscillator.belt_speed;
        Self::new(oscillator, side, [belt_speed, w], tolerance, belt_speed, work)
    }

    /// The walk backward in time.
    pub fn backward(self) -> Self {
        let here = State { divergence: -self.here.divergence, ..self.here };
        Self { direction: -1.0, here, ..self }
    }

    /// Gives up the orbit: its next step fails.
    pub fn give_up(&mut self) {
        self.is_given_up = true;
    }

    /// The walk that ends once it is within `radius` of the equilibrium, if it seems to stay there.
    pub fn resting_at(self, radius: f64) -> Self {
        Self { rest: radius, ..self }
    }

    /// The walk whose first state, on the belt line, has the error `error` along the line.
    pub fn starting_with(mut self, error: f64) -> Self {
        self.here.spread = error * self.here.w.abs();
        self
    }

    /// x2 - V at x2 = origin + `x`.
    #[inline(always)]
    fn beyond(&self, x: f64) -> f64 {
        x - self.origin_of_slips()
    }

    /// D at x2 = origin + `x`, with the sign of the direction of time. Beyond the belt line it is constant; as
    /// steps that pass the line are shortened to it, D only has to be bounded there.
    #[inline(always)]
    fn divergence(&self, x: f64) -> f64 {
        let slip = match self.side {
            Side::Below => -self.beyond(x),
            Side::Above => self.beyond(x),
        };
        let slip = slip.max(0.0);
        let divergence = match &self.weakening {
            Some(form) => form.at(slip) - self.oscillator.viscous,
            None => self.oscillator.divergence(slip),
        };
        self.direction * divergence
    }

    /// The local error allowed in a step between two states. It is at least the rounding error of the state.
    /// Without that floor no step would be short enough just before a data point of a measured law where the
    /// slope of D changes much, because steps end there up to rounding only; nor where a steep law falls next
    /// to the belt line, since the slip speed is rounded as V is: over a step that moves w by as much as D
    /// changes.
    fn allowed_in(&self, from: &State, to: &State) -> f64 {
        let [of_v, of_w] = self.rounding(from, to);
        (self.allowed * (to.time - from.time)).max(of_v + of_w)
    }

    /// The rounding errors of v and w in a step between two states. Slip speeds are rounded as the states are.
    fn rounding(&self, from: &State, to: &State) -> [f64; 2] {
        let size = if self.origin == 0.0 { self.oscillator.belt_speed } else { from.x.abs().max(to.x.abs()) };
        let steep = (to.divergence - from.divergence).abs() * size;
        let of_origin = self.origin * (to.time - from.time);
        [from.x.abs(), from.w.abs() + of_origin + ROUNDED_SLIPS * steep].map(|size| 0.5 * f64::EPSILON * size)
    }

    /// The speed whose rounding slip speeds have.
    #[inline(always)]
    fn origin_of_slips(&self) -> f64 {
        self.oscillator.belt_speed - self.origin
    }

    /// Replaces the slip speeds at which steps end, which by default include the law's corners.
    pub fn stopping_at(self, stops: &'a [f64]) -> Self {
        Self { stops: Cow::Borrowed(stops), ..self }
    }

    /// x1 at a state, from x2' = w.
    pub fn x1(&self, state: &State) -> f64 {
        let Oscillator { curve, viscous, belt_speed } = self.oscillator;
        let friction = match self.side {
            Side::Below => curve.phi((belt_speed - state.v).max(0.0)),
            Side::Above => -curve.phi((state.v - belt_speed).max(0.0)),
        };
        friction - viscous * state.v - self.direction * state.w
    }

    /// The derivative of x1 by the walk's time.
    pub fn pace_of_x1(&self, state: &State) -> f64 {
        self.direction * state.v
    }

    /// The state a time `h` after `from`.
    pub fn after(&self, from: &State, h: f64) -> State {
        let (Aligned([x, w, growth]), error) = vectorized(
            #[inline(always)]
            || step(h, &Aligned([from.x, from.w, from.growth]), &mut Lienard(self)),
        );
        self.work.count(STAGES as u64 + 1);
        let (v, time, divergence) = (self.origin + x, from.time + h, self.divergence(x));
        let mut to =
            State { v, w, growth, time, x, divergence, spread: 0.0, local: error[0].hypot(error[1]) };
        let [of_v, of_w] = self.rounding(from, &to);
        let of_form = self.form * h * from.w.abs().max(w.abs());
        let local = [error[0] + of_v, error[1] + of_w + of_form];
        let across = match self.oscillator.curve.corners().is_empty() {
            true => from.across(local).max(to.across(local)),
            // Next to a corner the estimates are too small, among 240 random laws by up to a half.
            false => 2.0 * local[0].hypot(local[1]) * from.pace().max(to.pace()),
        };
        to.spread = from.spread * (growth - from.growth).exp() + across;
        to
    }

    /// The slip speed at a state.
    pub fn slip(&self, state: &State) -> End {
        match self.side {
            Side::Below => End { slip: -self.beyond(state.x), rate: -state.w },
            Side::Above => End { slip: self.beyond(state.x), rate: state.w },
        }
    }

    /// The longest step that resolves the law. It changes the slip speed by at most the slip speed or V, whichever is
    /// greater, or half of that on the way to the line: larger steps of orbits far out would miss features of the law.
    fn longest_resolving(&self, from: &State) -> f64 {
        let end = self.slip(from);
        let change = end.slip.max(self.oscillator.belt_speed);
        let turning = from.slope().abs();
        // To second order, since the rate vanishes where an orbit without a drop leaves the line.
        let longest = match end.rate < 0.0 {
            true => 0.5 * change / -end.rate,
            false => 2.0 * change / (end.rate + end.rate.hypot((2.0 * turning).sqrt() * change.sqrt())),
        };
        longest.min(self.layers.longest(end, turning))
    }

    /// Takes one step, and returns the state at its beginning. The direction of (v, w) turns at the rate 1 +
    /// D sin cos <= 1 + |D|/2; steps are short enough that x2' changes its sign at most once.
    pub fn advance(&mut self) -> Result<State, Failure> {
        if self.is_given_up {
            return Err(Failure::StepBudget);
        }
        let (v, belt_speed) = (self.here.v, self.oscillator.belt_speed);
        if self.origin != nearest_origin(v, belt_speed) {
            self.origin = nearest_origin(v, belt_speed);
            self.here.x = v - self.origin;
        }
        let from = self.here;
        let scale = 1.0 / (1.0 + 0.5 * from.divergence.abs());
        let scale = scale.min(self.longest_resolving(&from));
        let mut h = self.next_step.min(scale);
        // Length of the step that follows one shortened to end at a narrow feature.
        let mut beyond_stop = 0.0;
        let mut failure = Failure::StepUnderflow;
        loop {
            match self.weakening {
                Some(_) => self.work.spend_compiled(STAGES as u64)?,
                None => self.work.spend(STAGES as u64)?,
            }
            if !(h > SHORTEST_STEP * scale) {
                return Err(if h.is_nan() { Failure::NotFinite } else { failure });
            }
            let to = self.after(&from, h);
            if !(to.v.is_finite() && to.w.is_finite()) {
                h *= 0.1;
                failure = Failure::NotFinite;
                continue;
            }
            let ends = [self.slip(&from), self.slip(&to)];
            let least = corners::LEAST_STEP * scale;
            if h > least
                && let Some(shorter) = corners::shortened(&self.stops, self.origin_of_slips(), ends, h)
            {
                // After a corner the error of a step does not predict that of the next.
                if self.oscillator.curve.corners().is_empty() {
                    beyond_stop = f64::max(beyond_stop, h);
                }
                h = shorter.max(least);
                continue;
            }
            if h > least
                && let Some(shorter) = self.layers.shortened(ends, h)
            {
                h = shorter.max(least);
                continue;
            }
            let allowed = self.allowed_in(&from, &to);
            let factor = (0.9 * (allowed / to.local).powf(1.0 / 7.0)).clamp(0.2, 5.0);
            // A step across the belt line meets a kink of the continued field; the accuracy that matters is
            // that of the shorter step to the line, see `is_accurate`.
            if to.local <= allowed || ends[1].slip < 0.0 {
                if to.local <= allowed {
                    self.next_step = (h * factor).max(beyond_stop);
                }
                self.here = to;
                return Ok(from);
            }
            h *= factor.min(0.9);
            beyond_stop = 0.0;
        }
    }

    /// The state between the ends of a step at which `value` passes through zero, where it has opposite signs (or
    /// is zero) at the ends; `value` returns its derivative by time, too. Trials are steps from `from`, by Newton's
    /// method, first to the root of the cubic through both ends; they end where the value is zero but for the rounding
    /// of the state.
    pub fn locate(&self, from: &State, to: &State, value: impl Fn(&Self, &State) -> [f64; 2]) -> State {
        let h = to.time - from.time;
        let ([first, rise], [last, fall]) = (value(self, from), value(self, to));
        let rounding = f64::EPSILON * (from.x.abs() + from.w.abs() + h * self.origin);
        let shortest = f64::EPSILON * h;
        let (mut low, mut high) = (0.0, h);
        let mut next = h * root_of_cubic([first, rise * h, last, fall * h]);
        let mut at = *to;
        if last == 0.0 {
            return at;
        }
        for trial in 1..=TRIALS {
            let inside = next > low && next < high && trial % 8 != 0;
            let middle = if inside { next } else { 0.5 * (low + high) };
            at = self.after(from, middle);
            let [here, slope] = value(self, &at);
            *(if (here > 0.0) == (last > 0.0) { &mut high } else { &mut low }) = middle;
            if here.abs() <= rounding + shortest * slope.abs() || high - low <= 2.0 * shortest {
                break;
            }
            next = middle - here / slope;
        }
        at
    }

    /// Follows an arc from a state on or below the belt line to the next maximum of x2 or to the line,
    /// whichever comes first. `visit` is called with the two ends of every step.
    pub fn lower_arc(
        &mut self,
        mut visit: impl FnMut(&mut Self, &State, &State),
    ) -> Result<LowerEnd, Failure> {
        let belt_speed = self.oscillator.belt_speed;
        loop {
            let from = self.advance()?;
            let mut to = self.here;
            let turns = from.w > 0.0 && to.w <= 0.0;
            if turns {
                to = self.locate(&from, &to, |_, state| [state.w, state.slope()]);
                to.w = 0.0;
            }
            let beyond = self.beyond(to.x);
            let meets = beyond > 0.0 || (beyond == 0.0 && to.w >= 0.0);
            if meets {
                to = self.locate(&from, &to, |walk, state| [walk.beyond(state.x), state.w]);
                to.v = belt_speed;
            }
            if (meets || turns) && !self.is_accurate(&from, &to) {
                continue;
            }
            self.here = to;
            visit(self, &from, &to);
            if meets {
                return Ok(LowerEnd::Meets(to));
            }
            if turns {
                return Ok(LowerEnd::Turns(to));
            }
            if self.rests() {
                return Ok(LowerEnd::Rests);
            }
        }
    }

    /// Follows an arc above the belt line, which starts on it with x2' > 0, back to the line.
    pub fn upper_arc(&mut self, mut visit: impl FnMut(&mut Self, &State, &State)) -> Result<State, Failure> {
        let belt_speed = self.oscillator.belt_speed;
        loop {
            let from = self.advance()?;
            let mut to = self.here;
            let meets = self.beyond(to.x) <= 0.0;
            if meets {
                // The height over the line divided by the time has a simple root even for the shortest arc.
                let (start, time) = (self.beyond(from.x), from.time);
                to = self.locate(&from, &to, |walk, state| {
                    let (elapsed, beyond) = (state.time - time, walk.beyond(state.x));
                    match (start > 0.0, elapsed > 0.0) {
                        (true, _) => [beyond, state.w],
                        (false, true) => [beyond / elapsed, (state.w - beyond / elapsed) / elapsed],
                        (false, false) => [state.w, 0.5 * state.slope()],
                    }
                });
                to.v = belt_speed;
                if !self.is_accurate(&from, &to) {
                    continue;
                }
            }
            self.here = to;
            visit(self, &from, &to);
            if meets {
                return Ok(to);
            }
        }
    }

    /// Returns whether a located event is accurate. If the step to it misses the tolerance, the orbit is
    /// reset to the beginning of the step, to continue with a shorter one.
    fn is_accurate(&mut self, from: &State, to: &State) -> bool {
        let h = to.time - from.time;
        // A law that is steep next to the belt line may change on the last part of the step alone.
        let steepest = from.divergence.abs().max(to.divergence.abs());
        let scale = 1.0 / (1.0 + 0.5 * steepest);
        let accurate = to.local <= self.allowed_in(from, to) || h <= 1e-6 * scale;
        if !accurate {
            self.here = *from;
            self.next_step = 0.5 * h;
        }
        accurate
    }

    /// Returns whether the orbit has come to rest, or has no later maximum of x2 above its distance r from the
    /// equilibrium. Proved, or for laws without proved bounds judged by samples:
    ///
    /// * r^2 = v^2 + w^2 obeys r r' = D w^2, so that it never grows where D <= 0 within r of the equilibrium;
    ///   asked for below the distance `rest` alone.
    /// * Where D <= -2 between here and the equilibrium, the wedge between w = 0 and w = -v is never left,
    ///   and |v| falls in it monotonically.
    fn rests(&self) -> bool {
        let State { v, w, .. } = self.here;
        let (belt_speed, radius) = (self.oscillator.belt_speed, v.hypot(w));
        if radius <= AT_REST * belt_speed {
            return true;
        }
        if self.side == Side::Above || self.direction < 0.0 {
            return false;
        }
        let is_trapped = radius <= self.rest.min(belt_speed)
            && self.oscillator.divergence_seems_at_most(0.0, belt_speed - radius, belt_speed + radius);
        let slip = belt_speed - v;
        let (near, far) = (slip.max(0.0).min(belt_speed), slip.max(belt_speed));
        let in_wedge = v * w < 0.0 && w.abs() < v.abs() - 2.0 * self.here.spread / self.here.pace();
        is_trapped || in_wedge && self.oscillator.divergence_seems_at_most(-2.0, near, far)
    }
}

/// Follows the turn below the belt line that starts at a maximum `radius` of x2, 0 < `radius` <= V, with the
/// error `tolerance` relative to it.
///
/// # Errors
/// [`Failure`].
pub fn turn(oscillator: &Oscillator, radius: f64, tolerance: f64) -> Result<SlipTurn, Failure> {
    let work = Work::of(Piece::SlipCycles, &oscillator.curve);
    let mut walk = Walk::new(oscillator, Side::Below, [radius, 0.0], tolerance, radius, &work);
    Ok(SlipTurn::of(radius, &walk.lower_arc(|_, _, _| ())?))
}

impl SlipTurn {
    /// The turn that starts at a maximum `radius` of x2 and ends as `end`.
    pub fn of(radius: f64, end: &LowerEnd) -> Self {
        match end {
            LowerEnd::Turns(end) => {
                Self::Returns { radius: end.v, slope: radius / end.v * end.growth.exp(), time: end.time }
            }
            LowerEnd::Meets(end) => Self::MeetsBelt { radius: end.v.hypot(end.w) },
            LowerEnd::Rests => Self::Rests,
        }
    }
}

/// The extremes of x1 and x2 on an orbit, updated step by step.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    /// Of x2.
    pub velocity: Range,
    /// Of x1.
    pub displacement: Range,
}

impl Default for Extent {
    /// The extent of no orbit.
    fn default() -> Self {
        Self { velocity: Range::EMPTY, displacement: Range::EMPTY }
    }
}

impl Extent {
    /// Extremes of x2 lie at x2' = 0, those of x1 at x2 = 0; steps are short enough to contain at most one of
    /// each.
    pub fn step(&mut self, walk: &Walk, from: &State, to: &State) {
        self.velocity = self.velocity.hull(Range::of([from.v, to.v]));
        if from.w * to.w < 0.0 {
            let at = walk.locate(from, to, |_, state| [state.w, state.slope()]);
            self.velocity = self.velocity.hull(Range::of([at.v]));
        }
        if from.v * to.v <= 0.0 && from.v != to.v {
            let at = walk.locate(from, to, |_, state| [state.v, state.w]);
            self.displacement = self.displacement.hull(Range::of([walk.x1(&at)]));
        }
    }
}

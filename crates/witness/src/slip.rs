//! Integrates slipping on one side of the belt line, step by step, with its two events: the orbit returns to
//! the line, or turns away again before it.
//!
//! **Why no event is missed.** With v = x2, w = x2' the flow is v' = w, w' = -v + D w, so the direction
//! of (v, w) turns at the rate 1 + D sin cos <= 1 + |D|/2, and always forward where w = 0. Two sign
//! changes of w are therefore half a turn apart, at least pi / (1 + |D|/2) in time. Steps are at most
//! 1 / (1 + |D|/2) long, with D from the left end, which may triple inside the step before two sign
//! changes fit in. Between sign changes x2 is monotone, so the values of x2 and w at the ends of a step
//! determine what happens inside, however shallow the contact.
//!
//! **Beyond the belt line.** A step that contains an event, and the margin of an orbit that lands, need the
//! field of one side continued past x2 = V, where the friction formula has a pole at a slip speed u < 0 that
//! depends on the law. Steps are shortened so that no stage lies farther beyond the line than
//! [`Slip::reach`], over which the continuation changes slowly.
//!
//! **Next to the belt line.** A law may be steep there and flat elsewhere. A step that goes past the steep
//! part may have no stage in it, and its error estimate is meaningless. Steps between the line and places far
//! from it therefore at most double, or halve, the distance from the line, from [`Slip::reach`] or from the onset of
//! the law on ([`slipmap_model::friction::Curve::onset`]).

use super::dop853::{self, Compensated, ROUNDING_AMPLIFICATION};
use super::orbit::{Contact, Event, Motion, Overshoot, Rest, State};
use slipmap_model::corners::{self, End};
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::Failure;
use std::borrow::Cow;
use std::f64::consts::TAU;

/// Largest number of trial steps, of eleven evaluations of the Stribeck law each; a turn takes about 20 to
/// 200.
const STEP_BUDGET: u32 = 100_000;
/// Least number of trial steps, however expensive the law is.
const FEWEST_STEPS: u32 = 5_000;

/// Largest number of trial steps beyond the belt line, up to a small distance from it.
const OVERSHOOT_BUDGET: u32 = 2_000;

/// Share by which an orbit changes its distance from the belt line or its acceleration while it moves. Next
/// to a slow curve steps are 2/|D| long, and each changes x2 by the share 2/D^2: for |D| > 4500 no more than
/// this in [`STILL_STEPS`], and by 1/100 in the whole budget.
const STILL: f64 = 1e-4;
/// Number of steps after which an orbit that has not moved is given up.
const STILL_STEPS: u32 = 1_000;

/// A step this much shorter than the time in which the direction can turn by a radian has underflowed.
const SHORTEST_STEP: f64 = 1e-14;

/// An event is located once the correction to its time is this small against the time scale of the flow; the
/// correction is still applied, to second order, which leaves its cube: 1e-18.
const EVENT_WINDOW: f64 = 1e-6;

/// Largest ratio of the distances from the belt line, if they exceed [`Slip::onset`], of the ends of a step.
const LARGEST_RATIO: f64 = 2.0;
/// Rounding error of that distance on the way back to the line, in units of V.
const ROUNDED: f64 = 16.0 * f64::EPSILON;

/// The largest tolerance that takes effect: the geometry of a turn must be resolved in any case.
const LOOSEST: f64 = 1e-3;

/// An event inside a step, to be located.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Target {
    /// x2' = 0.
    Turn,
    /// x2 = V, on the way back to the line.
    BeltLine,
}

/// An orbit being integrated on one side of the belt line.
#[derive(Clone, Debug)]
pub(super) struct Slip<'a> {
    pub(super) oscillator: &'a Oscillator,
    exit_x1: f64,
    /// Slip speeds at which steps end, increasing.
    stops: Cow<'a, [f64]>,
    /// The side of the belt line on which the orbit slips.
    pub(super) side: Side,
    /// Largest distance beyond the belt line at which a field is evaluated.
    reach: f64,
    /// The distance from the line up to which steps resolve the law.
    onset: f64,
    /// The sum of the local errors of x2 allowed in one turn, in units of V, in [0, 1e-3].
    pub(super) tolerance: f64,
    /// The largest angle by which a step may turn, radians.
    longest_turn: f64,
    pub(super) here: State,
    motion: Motion,
    next_step: f64,
    /// Length and estimated error of the last accepted step; the error is zero where an arc begins.
    last_step: f64,
    last_error: f64,
    /// Bound on the distance of `here` from the exact orbit, by the local error estimates.
    pub(super) error: f64,
    /// Evaluations of the right-hand side so far.
    pub(super) rhs: u64,
    steps_left: u32,
    /// x2 - V and x2' where the orbit last moved, and the number of steps since.
    mark: [f64; 2],
    still: u32,
}

impl<'a> Slip<'a> {
    /// The orbit from the exit point, where it leaves the belt downward.
    ///
    /// Without a drop the start is a tangency, x2 - V = x2' = 0, and both are set, not computed; x2'' = -V there,
    /// so the orbit moves away below the line. With the drop j, x2' = -j.
    pub(super) fn from_exit(oscillator: &'a Oscillator, tolerance: f64) -> Self {
        let reach = continuation_reach(oscillator);
        let mut slip = Self {
            oscillator,
            exit_x1: oscillator.exit_x1(),
            stops: oscillator.curve.stops(oscillator.belt_speed),
            side: Side::Below,
            reach,
            onset: reach.min(oscillator.curve.onset(oscillator.belt_speed)),
            tolerance: if tolerance > 0.0 { tolerance.min(LOOSEST) } else { 0.0 },
            longest_turn: 1.0,
            here: State { offset: [Compensated::default(); 2], w: 0.0, divergence: 0.0, time: 0.0 },
            motion: Motion::Away,
            next_step: 0.0,
            last_step: 1.0,
            last_error: 0.0,
            error: 0.0,
            rhs: 0,
            steps_left: u32::try_from(u64::from(STEP_BUDGET) / oscillator.curve.cost())
                .unwrap_or(STEP_BUDGET)
                .max(FEWEST_STEPS),
            mark: [f64::NAN; 2],
            still: 0,
        };
        slip.leave_exit(0.0);
        slip
    }

    /// Limits the angle by which a step may turn, in radians, below the one radian that is the default, and
    /// the number of steps.
    pub(super) fn sampled(mut self, angle: f64, steps: u32) -> Self {
        self.longest_turn = angle.min(1.0);
        self.steps_left = self.steps_left.min(steps);
        self
    }

    /// Moves to the exit point at `time`, to slip from there.
    pub(super) fn leave_exit(&mut self, time: f64) {
        self.side = Side::Below;
        let offset = [Compensated::default(); 2];
        let (w, divergence) = (0.0 - self.oscillator.drop(), self.oscillator.divergence(0.0));
        self.begin(State { offset, w, divergence, time }, Motion::Away);
    }

    /// Crosses the belt line at `at`, to slip on the other side.
    pub(super) fn cross(&mut self, at: &State) {
        self.side = match self.side {
            Side::Below => Side::Above,
            Side::Above => Side::Below,
        };
        let state = self.state(at.offset, at.time);
        self.begin(state, Motion::Away);
    }

    /// Moves to any state off the belt line, or on it where the orbit crosses, at `time`.
    pub(super) fn place(&mut self, x1: f64, x2: f64, side: Side, time: f64) {
        self.side = side;
        let offset = [x1 - self.exit_x1, x2 - self.oscillator.belt_speed].map(Compensated::from);
        let state = self.state(offset, time);
        // At x2' = 0 the second derivative is -x2.
        let pull = if state.w == 0.0 { -x2 } else { state.w };
        let on_line = state.x2_offset() == 0.0;
        let motion = if on_line || self.outward() * pull > 0.0 { Motion::Away } else { Motion::Back };
        self.begin(state, motion);
    }

    fn begin(&mut self, state: State, motion: Motion) {
        self.here = state;
        self.motion = motion;
        self.last_error = 0.0;
        // A small first step; the error control adapts it.
        self.next_step = 0.2 * self.time_scale(&state);
    }

    /// Distance of a state from the belt line; negative beyond it.
    fn depth(&self, state: &State) -> f64 {
        self.outward() * state.x2_offset()
    }

    /// Rate of change of the depth.
    fn outward_speed(&self, state: &State) -> f64 {
        self.outward() * state.w
    }

    /// Direction of x2 away from the belt line.
    fn outward(&self) -> f64 {
        match self.side {
            Side::Below => -1.0,
            Side::Above => 1.0,
        }
    }

    /// A time in which the direction of (v, w) turns by at most one radian.
    fn time_scale(&self, state: &State) -> f64 {
        1.0 / (1.0 + 0.5 * state.divergence.abs())
    }

    /// x2'' = -x2 + D x2'.
    fn jerk(&self, state: &State) -> f64 {
        state.divergence * state.w - (self.oscillator.belt_speed + state.x2_offset())
    }

    fn acceleration(&mut self, offset: [f64; 2]) -> f64 {
        self.rhs += 1;
        let [x1, x2] = [self.exit_x1 + offset[0], self.oscillator.belt_speed + offset[1]];
        self.oscillator.acceleration(self.side, x1, x2)
    }

    /// Completes a state from its position.
    fn state(&mut self, offset: [Compensated; 2], time: f64) -> State {
        let values = offset.map(Compensated::value);
        let w = self.acceleration(values);
        State { offset, w, divergence: self.oscillator.divergence(self.outward() * values[1]), time }
    }

    /// Scale of the rounding errors of x2', in units of 2^-53: the terms that cancel in it, and x2, whose own
    /// rounding acts through the slope of the friction law.
    fn magnitude(&self, state: &State) -> f64 {
        let x2 = (self.oscillator.belt_speed + state.x2_offset()).abs().max(self.oscillator.belt_speed);
        let x1 = (self.exit_x1 + state.x1_offset()).abs();
        let terms = x1 + state.w.abs() + (self.oscillator.viscous + state.divergence.abs()) * x2;
        terms.max(x2).max(1.0)
    }

    /// The state a time `h` after `from`, and the estimate of the local error.
    ///
    /// # Errors
    /// [`Failure::StepUnderflow`] where the field would be evaluated too far beyond the belt line, which only
    /// a shorter step may avoid; [`Failure::NotFinite`].
    fn after(&mut self, from: &State, h: f64) -> Result<(State, f64), Failure> {
        let belt_speed = self.oscillator.belt_speed;
        let first = [belt_speed + from.x2_offset(), from.w];
        let increment = dop853::step(from.offset, first, h, |offset| {
            self.within_reach(offset[1])?;
            let w = self.acceleration(offset);
            if w.is_finite() { Ok([belt_speed + offset[1], w]) } else { Err(Failure::NotFinite) }
        })?;
        let offset = [from.offset[0].plus(increment.by[0]), from.offset[1].plus(increment.by[1])];
        self.within_reach(offset[1].value())?;
        let state = self.state(offset, from.time + h);
        let finite = state.w.is_finite() && increment.error.is_finite();
        if finite { Ok((state, increment.error)) } else { Err(Failure::NotFinite) }
    }

    fn within_reach(&self, x2_offset: f64) -> Result<(), Failure> {
        let beyond = -self.outward() * x2_offset;
        if beyond > self.reach { Err(Failure::StepUnderflow) } else { Ok(()) }
    }

    /// One accepted step, not beyond `end_time`.
    pub(super) fn advance(&mut self, end_time: f64) -> Result<Event, Failure> {
        let before = (self.here, self.motion, self.error);
        loop {
            let left = self.here;
            let right = self.accepted_step(&left, end_time)?;
            if let Some(event) = self.event_between(&left, &right) {
                return Ok(event);
            }
            // The field leads out of reach between two stages of the step.
            (self.here, self.motion, self.error) = before;
            self.next_step = 0.5 * (right.time - left.time);
        }
    }

    /// Moves to the end of an accepted step and returns its event. `None` if an event cannot be located
    /// because the field would have to be evaluated out of reach.
    fn event_between(&mut self, left: &State, right: &State) -> Option<Event> {
        self.here = *right;
        let speed = self.outward_speed(right);
        let lands = |at, turn| Some(Event::Landed(Contact { at, turn, beyond: *right }));
        match self.motion {
            Motion::Away if speed >= 0.0 => Some(Event::Moved),
            Motion::Away => {
                self.motion = Motion::Back;
                if self.depth(right) >= 0.0 {
                    return Some(Event::Moved);
                }
                // The whole excursion fits into this step: after a crossing near the upper tangency.
                let far = self.locate(Target::Turn, left, [left, right])?;
                lands(self.locate(Target::BeltLine, left, [&far, right])?, None)
            }
            Motion::Back if speed <= 0.0 && self.depth(right) > 0.0 => Some(Event::Moved),
            Motion::Back if speed <= 0.0 => lands(self.locate(Target::BeltLine, left, [left, right])?, None),
            Motion::Back => {
                let near = self.locate(Target::Turn, left, [left, right])?;
                if self.depth(&near) > 0.0 {
                    self.motion = Motion::Away;
                    return Some(Event::NearMiss(near));
                }
                lands(self.locate(Target::BeltLine, left, [left, &near])?, Some(near))
            }
        }
    }

    /// Follows the continued field from beyond the belt line to the extremum of x2, if that lies within
    /// reach. The orbit's own state is lost.
    pub(super) fn overshoot(mut self, beyond: State) -> (Overshoot, Self) {
        let mut farthest = beyond;
        self.steps_left = self.steps_left.min(OVERSHOOT_BUDGET);
        self.next_step = self.time_scale(&beyond);
        // An orbit that still rises this close to the limit would take ever shorter steps.
        while self.depth(&farthest) > -0.9 * self.reach {
            let Ok(right) = self.accepted_step(&farthest, f64::INFINITY) else { break };
            if self.outward_speed(&right) <= 0.0 {
                farthest = right;
            } else if let Some(turn) = self.locate(Target::Turn, &farthest, [&farthest, &right]) {
                return (Overshoot::Turns(turn), self);
            } else {
                self.next_step = 0.5 * (right.time - farthest.time);
            }
        }
        (Overshoot::Farther(farthest), self)
    }

    /// Lower bound of the further rise of an orbit on its way back: half its speed squared over the greatest
    /// deceleration, with the divergence taken as constant.
    pub(super) fn further_rise(&self, state: &State) -> f64 {
        let speed = state.w.abs();
        let x2 = (self.oscillator.belt_speed + state.x2_offset()).abs();
        0.5 * speed * speed / (x2 + self.reach + speed * (-state.divergence).max(0.0))
    }

    /// Fails where the orbit has hardly moved for so long that the budget will not suffice.
    fn note_progress(&mut self, at: &State) -> Result<(), Failure> {
        let here = [at.x2_offset(), at.w];
        let is_still = here.iter().zip(self.mark).all(|(now, then)| (now - then).abs() <= STILL * then.abs());
        (self.mark, self.still) = if is_still { (self.mark, self.still + 1) } else { (here, 0) };
        if self.still > STILL_STEPS { Err(Failure::StepBudget) } else { Ok(()) }
    }

    /// The longest step from `left` that meets the tolerance and stays within reach.
    fn accepted_step(&mut self, left: &State, end_time: f64) -> Result<State, Failure> {
        let scale = self.time_scale(left);
        if !(scale.is_finite() && left.w.is_finite()) {
            return Err(Failure::NotFinite);
        }
        self.note_progress(left)?;
        // The slopes of a step have independent rounding errors of about 2^-53 of their terms.
        let rounding_rate = ROUNDING_AMPLIFICATION * 0.5 * f64::EPSILON * self.magnitude(left);
        // A turn lasts about 2 pi, so that its local errors add up to the tolerance.
        let allowed_rate = (self.tolerance * self.oscillator.belt_speed / TAU).max(rounding_rate);
        let resolving = self.longest_resolving(left);
        let longest = (self.longest_turn * scale).min(resolving);
        let scale = scale.min(resolving);
        let mut h = self.next_step.min(longest).min(end_time - left.time);
        let mut failure = Failure::StepUnderflow;
        let mut at_stop = false;
        loop {
            let clipped = h >= end_time - left.time;
            if h <= SHORTEST_STEP * scale && !clipped {
                return Err(failure);
            }
            self.steps_left = self.steps_left.checked_sub(1).ok_or(Failure::StepBudget)?;
            let (right, error) = match self.after(left, h) {
                Ok(reached) => reached,
                Err(why) => {
                    failure = why;
                    h = self.shortened(left, h);
                    continue;
                }
            };
            let ends =
                [left, &right].map(|state| End { slip: self.depth(state), rate: self.outward_speed(state) });
            let least = corners::LEAST_STEP * scale;
            if h > least
                && let Some(shorter) = corners::shortened(&self.stops, 0.0, ends, h)
            {
                h = shorter.max(least);
                // After a corner the error of a step does not predict that of the next.
                at_stop = self.oscillator.curve.corners().is_empty();
                continue;
            }
            let allowed = allowed_rate * h;
            // An error estimate may vanish where the error does not, so the previous one counts, too.
            let last = self.last_error * (h / self.last_step).powi(8);
            let likely = error.max(last);
            // The error per unit step falls like the 7th power of the step.
            let factor = (0.9 * (allowed / likely).powf(1.0 / 7.0)).clamp(0.2, 5.0);
            if error <= allowed {
                (self.last_step, self.last_error) = (h, error);
                // In the Euclidean norm of (x1, x2) neighbouring orbits separate at most at the rate D.
                let growth = left.divergence.max(right.divergence).max(0.0);
                let local = likely.min(allowed) + rounding_rate * h;
                self.error = self.error * (growth * h).exp() + local;
                // A step cut by an event or the end of time gives no information about the next one.
                let before = if at_stop { self.next_step } else { self.next_step.min(h * 5.0) };
                self.next_step = (h * factor).max(before);
                return Ok(right);
            }
            h *= factor.min(0.9);
            at_stop = false;
            self.next_step = h;
        }
    }

    /// The longest step that resolves the change of friction near the belt line, to second order. The stages
    /// of a step from the line to far away, or back, may all miss a law that is steep only near the line.
    fn longest_resolving(&self, left: &State) -> f64 {
        let depth = self.depth(left);
        let (speed, curvature) = (self.outward_speed(left), self.outward() * self.jerk(left));
        let (change, speed, curvature) = if speed >= 0.0 {
            (LARGEST_RATIO * depth.max(self.onset) - depth, speed, curvature)
        } else if depth > LARGEST_RATIO * self.onset.max(ROUNDED * self.oscillator.belt_speed) {
            (depth - depth / LARGEST_RATIO, -speed, -curvature)
        } else {
            return f64::INFINITY;
        };
        let speed_after = (speed * speed + 2.0 * curvature * change).sqrt();
        if speed_after.is_finite() { 2.0 * change / (speed + speed_after) } else { f64::INFINITY }
    }

    /// A shorter step than `h` from `left`, after `h` led out of reach or to infinity: about to the line, if
    /// the orbit approaches it.
    fn shortened(&self, left: &State, h: f64) -> f64 {
        let (depth, speed) = (self.depth(left), self.outward_speed(left));
        let to_line = (depth + 0.5 * self.reach) / -speed;
        if speed < 0.0 && to_line > 0.0 { to_line.min(0.5 * h) } else { 0.5 * h }
    }

    /// Locates the event that lies between two states of the step from `left`: x2' changes its sign, or
    /// x2 comes back through V.
    ///
    /// Every trial is a step from the left end, so the state at the event is as accurate as that at the end
    /// of a step. The corrections are Newton's for x2' and, for x2 (which at a grazing contact has nearly a
    /// double root), those of its quadratic Taylor polynomial; a bracket safeguards both.
    ///
    /// `None` if a trial leads out of reach.
    fn locate(&mut self, target: Target, left: &State, within: [&State; 2]) -> Option<State> {
        let mut bracket = within.map(|state| state.time - left.time);
        let value = |slip: &Self, state: &State| match target {
            Target::Turn => slip.outward_speed(state),
            Target::BeltLine => slip.depth(state),
        };
        // The value changes from this sign to the other.
        let before = match target {
            Target::BeltLine => 1.0,
            Target::Turn if self.outward_speed(within[1]) < 0.0 => 1.0,
            Target::Turn => -1.0,
        };
        let nearer = value(self, within[0]).abs() <= value(self, within[1]).abs();
        let mut state = *within[usize::from(!nearer)];
        let window = EVENT_WINDOW * self.time_scale(&state);
        // Every third trial bisects, which alone would end after 52.
        for trial in 1..=3 * 52 {
            let offset = self.correction(target, &state);
            let at = state.time - left.time;
            if before * value(self, &state) > 0.0 {
                bracket[0] = bracket[0].max(at);
            } else {
                bracket[1] = bracket[1].min(at);
            }
            if offset.abs() <= window {
                return Some(self.shifted(target, &state, offset));
            }
            let mut next = at + offset;
            let inside = next > bracket[0] && next < bracket[1];
            if !inside || trial % 3 == 0 {
                next = 0.5 * (bracket[0] + bracket[1]);
            }
            (state, _) = self.after(left, next).ok()?;
        }
        // The bracket is down to neighbouring numbers.
        Some(self.shifted(target, &state, 0.0))
    }

    /// The time from `state` to the event, to the order of the method in [`Slip::locate`]; NaN if the
    /// polynomial has no root.
    fn correction(&self, target: Target, state: &State) -> f64 {
        match target {
            Target::Turn => -state.w / self.jerk(state),
            Target::BeltLine => {
                let (depth, speed) = (self.depth(state), self.outward_speed(state));
                let curvature = self.outward() * self.jerk(state);
                // The root on the way back to the line, in the form without cancellation.
                2.0 * depth / ((speed * speed - 2.0 * curvature * depth).sqrt() - speed)
            }
        }
    }

    /// The state a very short time `tau` after `state`, with the values known at the event set exactly.
    fn shifted(&mut self, target: Target, state: &State, tau: f64) -> State {
        let x2 = self.oscillator.belt_speed + state.x2_offset();
        let x1 = state.offset[0].plus(tau * (x2 + 0.5 * tau * state.w));
        let time = state.time + tau;
        match target {
            Target::Turn => {
                let x2 = state.offset[1].plus(tau * (state.w + 0.5 * tau * self.jerk(state)));
                State { offset: [x1, x2], w: 0.0, time, ..*state }
            }
            Target::BeltLine => self.state([x1, Compensated::default()], time),
        }
    }

    /// The reason if the orbit is known to stay below the belt line for ever (for laws given by functions: if
    /// many samples indicate it); spirals are checked only within `radius` of the equilibrium.
    pub(super) fn rest(&self, radius: f64) -> Option<Rest> {
        let belt_speed = self.oscillator.belt_speed;
        let (v, w) = (belt_speed + self.here.x2_offset(), self.here.w);
        if self.side == Side::Above || v.abs() > belt_speed {
            return None;
        }
        let r = v.hypot(w);
        if r <= radius.min(belt_speed)
            && self.oscillator.divergence_seems_at_most(0.0, belt_speed - r, belt_speed + r)
        {
            return Some(Rest::Trapped { radius: r });
        }
        let u = belt_speed - v;
        let in_wedge = v * w < 0.0 && w.abs() < v.abs() - 2.0 * self.error;
        let creeps =
            in_wedge && self.oscillator.divergence_seems_at_most(-2.0, u.min(belt_speed), u.max(belt_speed));
        creeps.then_some(Rest::Creeping)
    }
}

/// Smallest ratio of the divergence's changes over a distance and over half of it.
const SMALLEST_GROWTH: f64 = 1.25;

/// Distance beyond the belt line to which the field of one side can be continued: at most V/8, and less if
/// the divergence changes there much faster than on the near side, or if it changes on the near side over
/// shorter distances.
///
/// The divergence is compared at equal distances d on both sides of the line: its changes from the line
/// itself may differ by a factor of four. With a pole 1/(d - p)^2 that holds for d up to 0.42 p, and as d is
/// doubled from a tiny value upwards it cannot jump over the pole. Where friction is even in d both changes
/// are equal; there d ends before the change stops growing: at 0.25 p for poles +- i p of a Lorentzian.
fn continuation_reach(oscillator: &Oscillator) -> f64 {
    let at_line = oscillator.divergence(0.0);
    let rounding = 16.0 * f64::EPSILON * (at_line.abs() + oscillator.viscous);
    let change = |d: f64| (oscillator.divergence(d) - at_line).abs();
    let changes_slowly = |d: f64| {
        let near = change(d);
        change(-d) <= 4.0 * near + rounding && near + rounding >= SMALLEST_GROWTH * change(0.5 * d)
    };
    let mut reach = oscillator.belt_speed / f64::from(1_u32 << 30);
    // Counted, since doubling a reach that underflowed to zero does not come to an end.
    for _ in 3..30 {
        if !changes_slowly(2.0 * reach) {
            break;
        }
        reach *= 2.0;
    }
    reach
}

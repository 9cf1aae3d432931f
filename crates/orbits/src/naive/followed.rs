//! `smoothed`, `stick_band` and `fixed_step`: one field for the whole plane; sticking is detected from the
//! states at which the field is evaluated.

use super::runge_kutta::{Control, State, classical, dormand_prince};
use super::{Followed, NaiveKnobs, NaiveVerdict, enough_time, rhs_budget};
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::Failure;
use slipmap_numbers::TimesPlus as _;

/// Slip speed in units of d above which tanh counts as saturated: tanh 5 = 0.9999. On a sticking orbit the
/// friction balances the other forces, which near the exit point takes slip speeds of several d.
const SATURATION: f64 = 5.0;

/// Observes an orbit turn by turn.
struct Observer {
    /// Number of turns left.
    turns: u32,
    /// Time limit.
    end: f64,
    /// Whether the orbit has stuck since the last turn began.
    stuck: bool,
    /// Time at which it last stuck, and the slip time before that.
    last_stick: f64,
    slip_time: f64,
    /// Time of the last turn, and since the one before.
    last_turn: Option<f64>,
    period: Option<f64>,
}

impl Observer {
    fn new(oscillator: &Oscillator, knobs: &NaiveKnobs) -> Self {
        let turns = knobs.turns.max(1);
        let end = enough_time(oscillator, turns);
        Self { turns, end, stuck: false, last_stick: 0.0, slip_time: 0.0, last_turn: None, period: None }
    }

    /// Records a step of length `h` that ends at `time`, in which the orbit `sticks` or not; returns the verdict, once
    /// there is one.
    fn step(&mut self, [from, to]: [&State; 2], [h, time]: [f64; 2], sticks: bool) -> Option<NaiveVerdict> {
        if sticks {
            if !self.stuck {
                self.slip_time = time - self.last_stick;
            }
            self.stuck = true;
            self.last_stick = time;
        }
        let turned = from[1] > 0.0 && to[1] <= 0.0;
        if turned {
            self.turns -= 1;
            let at = time - h * (1.0 - share_at_zero(from, to, h));
            self.period = self.last_turn.map(|before| at - before);
            self.last_turn = Some(at);
        }
        let in_time = time < self.end;
        if self.turns == 0 || !in_time {
            // An orbit that does not turn is decided by the second half of its time.
            let still = self.stuck && (in_time || self.last_stick > 0.5 * self.end);
            let Self { slip_time, period, .. } = *self;
            return Some(match still {
                true => NaiveVerdict::Sticks { slip_time, period },
                false => NaiveVerdict::NeverSticks,
            });
        }
        if turned {
            self.stuck = false;
        }
        None
    }
}

/// The share of a step at which x2 falls through zero: of the parabola through its ends whose integral is the change of x1.
fn share_at_zero([x1, from]: &State, [to_x1, to]: &State, h: f64) -> f64 {
    let bend = 3.0 * (from + to) - 6.0 * (to_x1 - x1) / h;
    let slope = to - from - bend;
    let root = (slope * slope - 4.0 * bend * from).max(0.0).sqrt();
    (2.0 * from / (root - slope)).clamp(0.0, 1.0)
}

/// A sticking state in the middle of the stick segment.
fn sticking_state(oscillator: &Oscillator) -> State {
    [-oscillator.viscous * oscillator.belt_speed, oscillator.belt_speed]
}

/// Returns whether static friction could hold the mass at this state.
fn holds(oscillator: &Oscillator, [x1, x2]: &State) -> bool {
    oscillator.viscous.times_plus(*x2, *x1).abs() < 1.0
}

/// The field with tanh((x2 - V)/d) for the sign.
pub(super) fn smoothed(oscillator: &Oscillator, knobs: &NaiveKnobs, rhs: &mut u64) -> Followed {
    let d = knobs.smoothing_width;
    adaptive(oscillator, knobs, rhs, |state| {
        let [x1, x2] = *state;
        let s = x2 - oscillator.belt_speed;
        let friction = (s / d).tanh() * oscillator.curve.phi(s.abs());
        let slope = [x2, -x1 - oscillator.viscous * x2 - friction];
        (slope, s.abs() <= SATURATION * d && holds(oscillator, state))
    })
}

/// The switch model: in the band, static friction balances the other forces if it can and then drives the
/// slip speed to zero at the oscillator's own frequency (stick); if it cannot, it acts with full force
/// (transition). Outside the band the mass slips.
pub(super) fn stick_band(oscillator: &Oscillator, knobs: &NaiveKnobs, rhs: &mut u64) -> Followed {
    let eta = knobs.stick_band_width;
    adaptive(oscillator, knobs, rhs, |state| {
        let [x1, x2] = *state;
        let s = x2 - oscillator.belt_speed;
        let applied = -x1 - oscillator.viscous * x2;
        if s.abs() >= eta {
            let side = if s > 0.0 { Side::Above } else { Side::Below };
            ([x2, oscillator.acceleration(side, x1, x2)], false)
        } else if holds(oscillator, state) {
            ([oscillator.belt_speed, -s], true)
        } else {
            ([x2, applied - applied.signum()], false)
        }
    })
}

/// Adaptive steps of a field that also returns whether it treats a state as sticking.
fn adaptive(
    oscillator: &Oscillator,
    knobs: &NaiveKnobs,
    rhs: &mut u64,
    field: impl Fn(&State) -> (State, bool),
) -> Followed {
    let mut watch = Observer::new(oscillator, knobs);
    let budget = rhs_budget(oscillator);
    let mut control = Control::new(knobs.tolerance, 5.0);
    let (mut state, mut time) = (sticking_state(oscillator), 0.0);
    loop {
        let h = control.step.min(knobs.longest_step);
        let mut sticks = false;
        let (next, error) = dormand_prince(&state, h, &mut |at| {
            *rhs += 1;
            let (slope, stuck) = field(at);
            sticks |= stuck;
            slope
        });
        if *rhs > budget {
            return Err(Failure::StepBudget);
        }
        if control.accepts(h, [&state, &next], &error, time)? {
            time += h;
            let verdict = watch.step([&state, &next], [h, time], sticks);
            state = next;
            if let Some(verdict) = verdict {
                return Ok(verdict);
            }
        }
    }
}

/// Fixed steps of the field with the sign function, sign(0) = 0.
pub(super) fn fixed_step(oscillator: &Oscillator, knobs: &NaiveKnobs, rhs: &mut u64) -> Followed {
    let (h, budget) = (knobs.step, rhs_budget(oscillator));
    let mut watch = Observer::new(oscillator, knobs);
    let (mut state, mut time) = (sticking_state(oscillator), 0.0);
    loop {
        let (mut below, mut above, mut held) = (false, false, false);
        let next = classical(&state, h, &mut |at| {
            *rhs += 1;
            let [x1, x2] = *at;
            let s = x2 - oscillator.belt_speed;
            below |= s <= 0.0;
            above |= s >= 0.0;
            held |= holds(oscillator, at);
            if s > 0.0 {
                [x2, oscillator.acceleration(Side::Above, x1, x2)]
            } else if s < 0.0 {
                [x2, oscillator.acceleration(Side::Below, x1, x2)]
            } else {
                [x2, -x1 - oscillator.viscous * x2]
            }
        });
        if *rhs > budget {
            return Err(Failure::StepBudget);
        }
        if !(next[0].is_finite() && next[1].is_finite()) {
            return Err(Failure::NotFinite);
        }
        time += h;
        let verdict = watch.step([&state, &next], [h, time], below && above && held);
        state = next;
        if let Some(verdict) = verdict {
            return Ok(verdict);
        }
    }
}

//! `event_step`: large steps of the field on the side where the orbit was last seen, with events found at
//! their ends.

use super::super::dop853::{Field, step};
use super::runge_kutta::Control;
use super::{Followed, NaiveKnobs, NaiveVerdict, enough_time, rhs_budget};
use slipmap_model::filippov::{BeltRegion, Oscillator, Side};
use slipmap_model::flow::Failure;
use slipmap_numbers::Aligned;

/// Number of bisections that locate an event inside a step, to the last bits of its time.
const BISECTIONS: u32 = 52;

/// The field of one side, continued across the belt line.
struct OneSided<'a> {
    oscillator: &'a Oscillator,
    side: Side,
    rhs: &'a mut u64,
}

impl Field<2> for OneSided<'_> {
    fn slope(&mut self, _stage: usize, &Aligned([x1, x2]): &Aligned<2>) -> Aligned<2> {
        *self.rhs += 1;
        Aligned([x2, self.oscillator.acceleration(self.side, x1, x2)])
    }
}

/// Follows the orbit from the exit point to where it sticks, by the event rule of `solve_ivp`: an event lies
/// in a step if x2 - V has opposite signs, or is zero, at its ends.
pub(super) fn decide(oscillator: &Oscillator, knobs: &NaiveKnobs, rhs: &mut u64) -> Followed {
    let belt_speed = oscillator.belt_speed;
    let end = enough_time(oscillator, knobs.turns.max(1));
    let budget = rhs_budget(oscillator);
    let mut control = Control::new(knobs.tolerance, 8.0);
    let (mut state, mut time) = (Aligned([oscillator.exit_x1(), belt_speed]), 0.0);
    let (mut side, mut last_event, mut turns) = (Side::Below, 0.0, 0);
    loop {
        let h = control.step.min(knobs.longest_step);
        let (next, error) = step(h, &state, &mut OneSided { oscillator, side, rhs });
        if *rhs > budget {
            return Err(Failure::StepBudget);
        }
        if !control.accepts(h, [&state, &next], &error, time)? {
            continue;
        }
        let (before, after) = (state[1] - belt_speed, next[1] - belt_speed);
        let changes = (before <= 0.0 && after >= 0.0) || (before >= 0.0 && after <= 0.0);
        if !changes || time < last_event + knobs.start_pause {
            turns += u32::from(state[1] > 0.0 && next[1] <= 0.0);
            (state, time) = (next, time + h);
            if turns > knobs.turns || time >= end {
                return Ok(NaiveVerdict::NeverSticks);
            }
            continue;
        }
        let (mut short, mut long) = (0.0, h);
        let mut at = state;
        if before == 0.0 {
            // The root finder accepts the left end.
            long = 0.0;
        } else {
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (short + long);
                at = step(middle, &state, &mut OneSided { oscillator, side, rhs }).0;
                let same = (at[1] - belt_speed) * before > 0.0;
                *(if same { &mut short } else { &mut long }) = middle;
            }
        }
        time += long;
        match oscillator.belt_region(at[0]) {
            BeltRegion::Sliding | BeltRegion::ExitPoint => {
                let period = time + (oscillator.exit_x1() - at[0]) / belt_speed;
                return Ok(NaiveVerdict::Sticks { slip_time: time, period: Some(period) });
            }
            // The orbit would stop at the same event for ever.
            _ if long == 0.0 => return Err(Failure::StepUnderflow),
            BeltRegion::CrossingDown | BeltRegion::CrossingUp | BeltRegion::UpperTangency => {}
        }
        side = if after > 0.0 { Side::Above } else { Side::Below };
        (state, last_event) = (Aligned([at[0], belt_speed]), time);
        control.step = 1e-3;
    }
}

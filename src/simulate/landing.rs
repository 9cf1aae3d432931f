//! The point and time at which the returning orbit meets the belt line, in the polar form.
//!
//! The orbit and its time are integrated together; the landing is the root of x2 = V on the last quarter
//! turn, found by repeating the step that passes it with other widths, so that it has the full order of the
//! method. The angle as independent variable cannot miss a double crossing: the orbit's maximum of x2 is at
//! the angle 2 pi exactly. [`super::arc`] finds the same point for cycles, but in x2 itself: at a margin
//! of 2e-17 it found a landing speed of 4e-17 in place of 1e-9. Here the state is the margin.

use std::f64::consts::TAU;

use super::dop853::{Field, NODES, step};
use crate::filippov::Oscillator;

/// Number of steps per turn of the first attempt; doubled until the error estimate is met.
const STEPS: usize = 32;
/// Number of steps per turn of the last attempt.
const MOST_STEPS: usize = 2048;

/// The orbit at the belt line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrival {
    /// x2' at the belt line on the lower side, wL >= 0.
    pub(crate) speed: f64,
    /// Time since the exit point.
    pub(crate) time: f64,
}

/// Outcome of following the orbit to the belt line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Approach {
    /// It reaches the belt line.
    Arrives(Arrival),
    /// It completes the turn below the belt line.
    StaysBelow,
    /// The polar angle is not monotone in time (an overdamped node), or the tolerance was not met.
    NoAnswer,
}

/// The polar field of one orbit in the state [delta, time], within the step from `from` of width `h`.
struct Timed<'a> {
    oscillator: &'a Oscillator,
    from: f64,
    h: f64,
    /// Least dth/dt so far.
    slowest: &'a mut f64,
    rhs: &'a mut u64,
}

impl Field<2> for Timed<'_> {
    fn slope(&mut self, stage: usize, state: &[f64; 2]) -> [f64; 2] {
        *self.rhs += 1;
        let (sin, cos) = NODES[stage].mul_add(self.h, self.from).sin_cos();
        let r = 1.0 + state[0];
        let d = self.oscillator.divergence(self.oscillator.belt_speed * (-r).mul_add(cos, 1.0));
        let turning = d.mul_add(sin * cos, 1.0);
        *self.slowest = self.slowest.min(turning);
        [r * d * sin * sin / turning, 1.0 / turning]
    }
}

/// Follows the orbit from the exit point to its first return to the belt line with the scaled error
/// `tolerance`, and counts right-hand sides.
pub(super) fn approach(oscillator: &Oscillator, tolerance: f64, rhs: &mut u64) -> Approach {
    if !oscillator.curve.stops(oscillator.belt_speed).is_empty() {
        // Equal steps cannot end at stops.
        return Approach::NoAnswer;
    }
    let mut steps = STEPS;
    while steps <= MOST_STEPS {
        match attempt(oscillator, steps, tolerance, rhs) {
            Some(answer) => return answer,
            None => steps *= 2,
        }
    }
    Approach::NoAnswer
}

/// One attempt with equal steps; `None` if the estimate misses the tolerance.
fn attempt(oscillator: &Oscillator, steps: usize, tolerance: f64, rhs: &mut u64) -> Option<Approach> {
    let h = TAU / steps as f64;
    let mut state = [0.0, 0.0];
    let mut slowest = f64::INFINITY;
    let mut error = 0.0;
    for i in 0..steps {
        let from = i as f64 * h;
        let take = |h: f64, slowest: &mut f64, rhs: &mut u64| {
            step(h, &state, &mut Timed { oscillator, from, h, slowest, rhs })
        };
        let (next, local) = take(h, &mut slowest, rhs);
        let past_belt = 4 * (i + 1) > 3 * steps && height(&next, from + h) >= 0.0;
        if !past_belt {
            // Beyond the belt line the field is continued and may be singular, so only errors of steps that
            // end below it are counted here.
            error += local[0] + local[1];
            if !(error <= tolerance && slowest > 0.05) {
                return None;
            }
            state = next;
            continue;
        }
        // Illinois iteration on the width of the step: the height is negative at the left end.
        let (mut short, mut low) = (0.0, height(&state, from));
        let (mut long, mut high) = (h, height(&next, from + h));
        let mut landed = (state, 0.0);
        let mut last_below = None;
        while long - short > 4.0 * f64::EPSILON * TAU {
            let width = (short * high - long * low) / (high - low);
            let width = if width > short && width < long { width } else { 0.5 * (short + long) };
            let (at, local) = take(width, &mut slowest, rhs);
            let here = height(&at, from + width);
            if here < 0.0 {
                landed = (at, local[0] + local[1]);
                (short, low) = (width, here);
                if last_below == Some(true) {
                    high *= 0.5;
                }
                last_below = Some(true);
            } else if here > 0.0 {
                (long, high) = (width, here);
                if last_below == Some(false) {
                    low *= 0.5;
                }
                last_below = Some(false);
            } else {
                landed = (at, local[0] + local[1]);
                short = width;
                break;
            }
        }
        let (landed, local) = landed;
        if !(error + local <= tolerance) {
            return None;
        }
        let speed = -oscillator.belt_speed * (1.0 + landed[0]) * (from + short).sin();
        return Some(Approach::Arrives(Arrival { speed: speed.max(0.0), time: landed[1] }));
    }
    Some(Approach::StaysBelow)
}

/// v/V - 1 at an angle, without cancellation next to grazing.
fn height(state: &[f64; 2], theta: f64) -> f64 {
    let half = (0.5 * theta).sin();
    state[0].mul_add(theta.cos(), -2.0 * half * half)
}

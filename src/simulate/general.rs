//! One turn of the lower flow, and its critical damping, for any friction law: the polar form, one orbit at a
//! time, with steps that follow the law. The vectorised kernels of [`super::return_map`] and
//! [`super::critical`] know the Stribeck law only.
//!
//! **Error.** The sum of the local error estimates, each carried to the end of the turn by the slope of the
//! flow between rays, which Liouville's formula gives without a derivative of the law: from the ray at theta
//! to the end it is (r dth/dt) / (r_end) exp(integral of D dt).

use std::f64::consts::{PI, TAU};

use super::corners::{self, End};
use super::critical::CriticalDamping;
use super::dop853::{Field, NODES, STAGES, step};
use super::return_map::Turn;
use crate::filippov::Oscillator;
use crate::friction::Column;

/// As in the vectorised kernel: below this dth/dt the angle is no clock.
const SLOWEST_TURN: f64 = 0.05;
/// Longest step, so that no stage pattern straddles half an orbit.
const LONGEST_STEP: f64 = 0.5;
const FIRST_STEP: f64 = 0.02;
const SHORTEST_STEP: f64 = 1e-9;
const STEP_BUDGET: u32 = 20_000;
/// Share of the tolerance that the local error estimates may add up to.
const SHARE: f64 = 0.3;
/// Turns after which the search for a root gives up; five are usual.
const MOST_TURNS: u32 = 60;

/// The polar field in the state [delta, integral of D dt], see [`super::polar`].
struct Polar<'a> {
    oscillator: &'a Oscillator,
    from: f64,
    h: f64,
    slowest: f64,
    /// Largest |D| met.
    steepest: f64,
}

impl Field<2> for Polar<'_> {
    fn slope(&mut self, stage: usize, state: &[f64; 2]) -> [f64; 2] {
        let (sin, cos) = NODES[stage].mul_add(self.h, self.from).sin_cos();
        let r = 1.0 + state[0];
        let d = self.oscillator.divergence(self.oscillator.belt_speed * (-r).mul_add(cos, 1.0));
        let turning = d.mul_add(sin * cos, 1.0);
        // NaN must not pass as the larger of two numbers.
        self.slowest = if turning >= self.slowest { self.slowest } else { turning };
        self.steepest = self.steepest.max(d.abs());
        [r * d * sin * sin / turning, d / turning]
    }
}

/// The slip speed at an angle, and its rate of change with it.
fn slip(oscillator: &Oscillator, theta: f64, state: &[f64; 2]) -> End {
    let (sin, cos) = theta.sin_cos();
    let r = 1.0 + state[0];
    let slip = oscillator.belt_speed * (-r).mul_add(cos, 1.0);
    let turning = oscillator.divergence(slip).mul_add(sin * cos, 1.0);
    End { slip, rate: oscillator.belt_speed * r * sin / turning }
}

/// One turn of the orbit from the exit point, with an error of at most `tolerance` where that can be had.
pub(super) fn turn(oscillator: &Oscillator, tolerance: f64) -> Turn {
    let mut rhs = 0;
    let mut state = [0.0, 0.0];
    let (mut theta, mut h) = (0.0, FIRST_STEP);
    let mut error = 0.0;
    let mut steepest: f64 = 0.0;
    for _ in 0..STEP_BUDGET {
        let last = theta + h >= TAU;
        let width = if last { TAU - theta } else { h };
        let mut field = Polar { oscillator, from: theta, h: width, slowest: f64::INFINITY, steepest };
        let (next, local) = step(width, &state, &mut field);
        // Estimates pass through zero where errors do not: that of the other component does so elsewhere.
        let local = local[0].hypot(local[1]);
        rhs += STAGES as u32;
        let inside = field.slowest > SLOWEST_TURN && next[0].is_finite();
        if inside {
            let ends = [slip(oscillator, theta, &state), slip(oscillator, theta + width, &next)];
            if let Some(shorter) = corners::shortened(&oscillator.curve, oscillator.belt_speed, ends, width) {
                h = shorter;
                continue;
            }
        }
        // Round-off is all that is left below a few units in the last place of the increments.
        let floor = 4.0 * f64::EPSILON * field.steepest.max(next[0].abs());
        let allowed = (SHARE * tolerance / TAU).max(floor) * width;
        if !inside || local > allowed {
            let factor =
                if inside { (0.9 * (allowed / local).powf(1.0 / 7.0)).clamp(0.1, 0.9) } else { 0.25 };
            h = width * factor;
            if !(h > SHORTEST_STEP) {
                return Turn::HandOver { rhs };
            }
            continue;
        }
        steepest = field.steepest;
        // Carried across this step, then joined by its own error.
        let speed = |theta: f64, state: &[f64; 2]| {
            let (sin, cos) = theta.sin_cos();
            let r = 1.0 + state[0];
            let d = oscillator.divergence(oscillator.belt_speed * (-r).mul_add(cos, 1.0));
            r * d.mul_add(sin * cos, 1.0)
        };
        let carry = speed(theta, &state) / speed(theta + width, &next) * (next[1] - state[1]).exp();
        error = error * carry.abs() + local;
        state = next;
        theta += width;
        if last {
            let round_off = 16.0 * f64::EPSILON * state[0].abs().max(steepest);
            return Turn::Complete { margin: state[0], error: error / SHARE + round_off, rhs };
        }
        let grown = if local > 0.0 { 0.9 * (allowed / local).powf(1.0 / 7.0) } else { 5.0 };
        h = (width * grown.clamp(0.2, 5.0)).min(LONGEST_STEP);
    }
    Turn::HandOver { rhs }
}

/// The critical damping of a column by the margin's root, between the bounds from the even part of the
/// divergence (theory, "The tests"); `Err` with the cost where a turn on the way has no answer.
pub(super) fn critical_damping(column: &Column, tolerance: f64) -> Result<CriticalDamping, u64> {
    let bounds = column.curve.even_weakening_range(column.belt_speed);
    let start = column.curve.mean_weakening(column.belt_speed);
    let size = bounds.lo.abs().max(bounds.hi.abs());
    if !(size.is_finite() && start.is_finite()) {
        return Err(0);
    }
    // The turn's accuracy is that of C; signs at the bounds are not trusted to the last digit.
    let accuracy = (0.1 * tolerance * size).max(1e-16);
    let pad = 1e-9 * (bounds.hi - bounds.lo) + 1e-13 * size;
    let (mut low, mut high) = (bounds.lo - pad, bounds.hi + pad);
    let mut rhs = 0;
    let mut viscous = start.clamp(low, high);
    let mut before: Option<(f64, f64)> = None;
    for _ in 0..MOST_TURNS {
        let oscillator = Oscillator { curve: column.curve.clone(), viscous, belt_speed: column.belt_speed };
        let (margin, error) = match turn(&oscillator, accuracy) {
            Turn::Complete { margin, error, rhs: cost } => {
                rhs += u64::from(cost);
                (margin, error)
            }
            Turn::HandOver { rhs: cost } => return Err(rhs + u64::from(cost)),
        };
        if margin > 0.0 {
            low = low.max(viscous);
        } else {
            high = high.min(viscous);
        }
        // To first order a turn loses pi C; from the second turn on the secant knows better.
        let secant = before.map(|(c, m): (f64, f64)| (margin - m) / (viscous - c));
        let slope = secant.filter(|slope| *slope < 0.0 && slope.is_finite()).unwrap_or(-PI);
        let newton = viscous - margin / slope;
        let converged = margin.abs() <= error || (newton - viscous).abs() <= 4.0 * f64::EPSILON * size;
        if converged || high - low <= 4.0 * f64::EPSILON * size {
            let uncertain = (margin.abs() + error) / slope.abs() + 4.0 * f64::EPSILON * size;
            let (c, error) = (viscous / column.epsilon, uncertain / column.epsilon);
            return Ok(CriticalDamping { c, error, rhs });
        }
        before = Some((viscous, margin));
        viscous = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
    }
    Err(rhs)
}

//! One turn of the orbit from the exit point, for any friction law.
//!
//! In the polar form of [`super::polar`], with R = r / r(0), the orbit obeys
//!
//! ```text
//! dR/dth = D R sin^2 th / (1 + D sin th cos th),    D = w(V - r cos th) - C
//! ```
//!
//! with steps that follow the law and end at its corners.
//!
//! **Weights.** Let Q(th) be the factor by which a small change of ln r at the start has grown at th. By
//! Liouville's formula Q needs no derivative of the law: Q = exp(integral of D dt) / (R^2 dth/dt), as areas
//! are r^2 d ln r dth and R^2 dth/dt = 1 at the start. A change dD along the orbit therefore moves ln R(2 pi)
//! by Q(2 pi) times the integral of `dD W`,
//!
//! ```text
//! W = sin^2 th / (dth/dt)^2 / Q = sin^2 th R^2 exp(-integral of D dt) / (dth/dt) >= 0,
//! ```
//!
//! and so does an error of the law's polynomials.
//!
//! **Error.** The sum of the local error estimates of R, each carried to the end of the turn by Q(2 pi) / Q
//! times R(2 pi) / R.

use std::f64::consts::TAU;

use super::dop853::{Field, NODES, STAGES, step};
use super::polar::Turn;
use slipmap_model::corners::{self, End, Layers};
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Weakening;
use slipmap_numbers::elementary::sin_cos_of_turn;
use slipmap_numbers::{Aligned, vectorized};

/// Least dth/dt, as in the vectorised kernel: below it the polar angle may not be monotone in time.
const SLOWEST_TURN: f64 = 0.05;
/// Longest step, so that the stages of a step do not span half an orbit.
const LONGEST_STEP: f64 = 0.5;
const FIRST_STEP: f64 = 0.02;
const SHORTEST_STEP: f64 = 1e-9;
/// Shortest step after one that leaves the domain of the polar form. Most such orbits leave it, too, and
/// shorter steps would only come closer to its border; an orbit that does not is followed by another engine.
const SHORTEST_STEP_AT_BORDER: f64 = 1e-4;
const STEP_BUDGET: u32 = 20_000;
/// Number of roundings that a step counts for in the error, with a drop.
const ROUNDINGS: f64 = 4.0;
/// Share of the tolerance for the sum of the local error estimates.
const SHARE: f64 = 0.3;

/// The polar field in the state [R - 1, integral of D dt, integral of W].
struct Polar<'a> {
    oscillator: &'a Oscillator,
    radius: f64,
    weakening: &'a Weakening,
    from: f64,
    h: f64,
    slowest: f64,
    /// Largest |D| so far.
    steepest: f64,
}

impl Polar<'_> {
    /// Slip speed, D and dth/dt.
    #[inline(always)]
    fn at(&self, [sin, cos]: [f64; 2], r: f64) -> [f64; 3] {
        let slip = (-self.radius * r).mul_add(cos, self.oscillator.belt_speed);
        let d = self.weakening.at(slip) - self.oscillator.viscous;
        [slip, d, d.mul_add(sin * cos, 1.0)]
    }
}

impl Field<3> for Polar<'_> {
    #[inline(always)]
    fn slope(&mut self, stage: usize, state: &Aligned<3>) -> Aligned<3> {
        let [sin, cos] = sin_cos_of_turn(NODES[stage].mul_add(self.h, self.from));
        let r = 1.0 + state[0];
        let [_, d, turning] = self.at([sin, cos], r);
        // Keeps NaN, which `f64::min` would drop.
        self.slowest = if turning >= self.slowest { self.slowest } else { turning };
        self.steepest = self.steepest.max(d.abs());
        let weight = sin * sin * r * r * (-state[1]).exp() / turning;
        Aligned([r * d * sin * sin / turning, d / turning, weight])
    }
}

/// Where a turn starts.
#[derive(Clone, Copy, Debug)]
struct Start {
    /// r and th.
    radius: f64,
    angle: f64,
    /// r / V - 1.
    excess: f64,
}

/// One turn of the orbit from the exit point, (x2, x2') = (V, -j), with an error of the margin r(2 pi) / V - 1 of at most
/// `tolerance` where that can be reached. It is handed over where the polar form does not apply, or the finest step
/// misses the tolerance.
pub(super) fn turn(oscillator: &Oscillator, tolerance: f64) -> Turn {
    let (belt_speed, drop) = (oscillator.belt_speed, oscillator.drop());
    let ratio = drop / belt_speed;
    // Not a difference of radii: that of small drops would have no digits.
    let excess = ratio * (ratio / (1.0 + ratio.hypot(1.0)));
    let start = Start { radius: belt_speed.hypot(drop), angle: drop.atan2(belt_speed), excess };
    vectorized(
        #[inline(always)]
        || turn_by_steps(oscillator, start, tolerance),
    )
}

#[inline(always)]
fn turn_by_steps(oscillator: &Oscillator, start: Start, tolerance: f64) -> Turn {
    let Start { radius, angle, excess } = start;
    let mut rhs = 0;
    let mut state = Aligned::default();
    let mut theta = angle;
    let mut error = 0.0;
    // Length of the step that follows one shortened to end at a stop.
    let mut beyond_stop = 0.0_f64;
    let fastest = radius.max(oscillator.belt_speed);
    let weakening = &*oscillator.curve.compiled(2.0 * (oscillator.belt_speed + fastest));
    let stops = oscillator.curve.stops(fastest);
    let layers =
        Layers::of(&oscillator.curve, oscillator.belt_speed, 2.0 * (oscillator.belt_speed + fastest));
    let leaving = End { slip: 0.0, rate: oscillator.drop() };
    let mut h = FIRST_STEP.min(layers.longest(leaving, radius));
    let mut field =
        Polar { oscillator, radius, weakening, from: 0.0, h, slowest: f64::INFINITY, steepest: 0.0 };
    for _ in 0..STEP_BUDGET {
        let last = theta + h >= TAU;
        let width = if last { TAU - theta } else { h };
        let steepest = field.steepest;
        (field.from, field.h, field.slowest) = (theta, width, f64::INFINITY);
        let (next, local) = step(width, &state, &mut field);
        // An error estimate may vanish where the error does not; the other component's vanishes elsewhere.
        let local = local[0].hypot(local[1]);
        rhs += STAGES as u32;
        let inside = field.slowest > SLOWEST_TURN && next[0].is_finite();
        let ends = [(theta, &state), (theta + width, &next)].map(|(theta, state)| {
            let [sin, cos] = sin_cos_of_turn(theta);
            let r = 1.0 + state[0];
            let [slip, _, turning] = field.at([sin, cos], r);
            // The slip speed with its rate by the angle, and R dth/dt.
            (End { slip, rate: radius * r * sin / turning }, r * turning)
        });
        if inside {
            let slips = ends.map(|(end, _)| end);
            if let Some(shorter) = corners::shortened(&stops, oscillator.belt_speed, slips, width) {
                // After a corner the error of a step does not predict that of the next.
                if oscillator.curve.corners().is_empty() {
                    beyond_stop = beyond_stop.max(width);
                }
                h = shorter;
                continue;
            }
            if width > corners::LEAST_STEP
                && let Some(shorter) = layers.shortened(slips, width)
            {
                h = shorter.max(corners::LEAST_STEP);
                continue;
            }
        }
        // Below a few units in the last place of the increments there is only round-off.
        let floor = 4.0 * f64::EPSILON * field.steepest.max(next[0].abs());
        // With a drop R moves by more than a little: rounding errors of it, and of the angle at which a step ends,
        // do not shrink with the step. Among two hundred reference dampings the error was up to twice their sum.
        let rounding = match angle > 0.0 {
            true => f64::EPSILON * (next[0].abs() + theta * (next[0] - state[0]).abs() / width),
            false => 0.0,
        };
        let allowed = ((SHARE * tolerance / TAU).max(floor) * width).max(rounding);
        if !inside || local > allowed {
            let factor =
                if inside { (0.9 * (allowed / local).powf(1.0 / 7.0)).clamp(0.1, 0.9) } else { 0.25 };
            h = width * factor;
            beyond_stop = 0.0;
            field.steepest = steepest;
            if !(h > if inside { SHORTEST_STEP } else { SHORTEST_STEP_AT_BORDER }) {
                return Turn::HandOver { rhs };
            }
            continue;
        }
        // The earlier error is carried across this step, and the step's own is added.
        let carry = ends[0].1 / ends[1].1 * (next[1] - state[1]).exp();
        error = error * carry.abs() + local + ROUNDINGS * rounding;
        state = next;
        theta += width;
        if last {
            let round_off = 16.0 * f64::EPSILON * state[0].abs().max(field.steepest);
            let by_rate = state[1].exp() / (1.0 + state[0]).powi(2) * state[2];
            let form = weakening.error(0.0, weakening.reach()).bound() + oscillator.curve.sampling_error();
            let margin = state[0] * (1.0 + excess) + excess;
            let error = (error / SHARE + round_off + form * by_rate.abs()) * (1.0 + excess);
            return Turn::Complete { margin, error, rhs };
        }
        let grown = if local > 0.0 { 0.9 * (allowed / local).powf(1.0 / 7.0) } else { 5.0 };
        h = (width * grown.clamp(0.2, 5.0)).max(beyond_stop).min(LONGEST_STEP);
        h = h.min(layers.longest(ends[1].0, radius).max(corners::LEAST_STEP));
        beyond_stop = 0.0;
    }
    Turn::HandOver { rhs }
}

//! Many halves, followed together in vector lanes to their lowest points.

use std::f64::consts::{FRAC_PI_2, PI};

use super::half::{Half, Orbit, Rate, SHARE};
use crate::dop853::{Field, NODES, STAGES, step};
use crate::elements::sin_cos;
use crate::polar::{LANES, exp_falling};
use slipmap_model::corners::{self, End};
use slipmap_model::friction::ExponentialFall;

/// Least dth/dt in the half where x2 < 0.
const SLOWEST_TURN: f64 = 0.05;
/// Longest step in the polar angle.
const LONGEST_STEP: f64 = 0.5;
/// Longest step in q, in units of q.
const LONGEST_RATIO: f64 = 1.0;
/// Shortest step, relative to the variable.
const SHORTEST_STEP: f64 = 1e-13;
/// Largest number of steps of a half.
const STEP_BUDGET: u32 = 20_000;
/// Largest local error of W^2 where it vanishes later.
const ACCURATE: f64 = 1e-3;
/// Largest weight of a stage at an end of a step.
const KINK: f64 = 0.1;
/// Number of roundings that a step counts for in the error.
const ROUNDINGS: f64 = 4.0;

/// The state at the lowest point of a half.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lowest {
    pub(super) h: f64,
    pub(super) by_damping: f64,
    pub(super) error: f64,
}

/// Numbers of [`LANES`] halves.
type Lanes = [f64; LANES];
/// h, dh/dC and the integral of s D of all lanes.
type State = [f64; 3 * LANES];

/// Halves that are followed together, each by steps of its own.
#[derive(Default)]
struct Together<'a> {
    halves: [Option<Half<'a>>; LANES],
    /// Numbers of the halves in the list.
    numbers: [usize; LANES],
    sign: Lanes,
    viscous: Lanes,
    belt_speed: Lanes,
    radius: Lanes,
    /// The parameters of an exponential fall; 0 in other lanes.
    steepest: Lanes,
    rate: Lanes,
    rise: Lanes,
    /// 1 where its exponent is 2, and 0 where it is 1.
    squared: Lanes,
    has_others: bool,
    /// Whether x2 < 0: the variable is the polar angle th; before that it is q = (2 radius)^(1/2) sin(th / 2) by its own
    /// angle th.
    is_left: [bool; LANES],
    x: Lanes,
    /// Length of the step that is made, and of the next one.
    h: Lanes,
    width: Lanes,
    end: Lanes,
    state: State,
    error: Lanes,
    room: Lanes,
    first: Lanes,
    beyond_stop: Lanes,
    steps: [u32; LANES],
    rhs: [u64; LANES],
}

/// Places of the lanes in their variables: slip speed, W^2, s D and the time by the variable.
struct Places {
    slip: Lanes,
    square: Lanes,
    rate: Lanes,
    time: Lanes,
    room: Lanes,
}

impl<'a> Together<'a> {
    fn new() -> Self {
        Self { belt_speed: [1.0; LANES], radius: [1.0; LANES], ..Self::default() }
    }

    /// Puts a half into a lane.
    fn load(&mut self, lane: usize, number: usize, half: Half<'a>) {
        let Half { orbit: Orbit { rate, belt_speed, radius, .. }, viscous, sign, .. } = half;
        let (start, rhs) = half.start();
        let fall = match rate {
            Rate::Exponential(fall) => fall,
            _ => ExponentialFall { steepest: 0.0, rate: 0.0, rise: 0.0, is_squared: false },
        };
        self.halves[lane] = Some(half);
        self.numbers[lane] = number;
        (self.sign[lane], self.viscous[lane]) = (sign, viscous);
        (self.belt_speed[lane], self.radius[lane]) = (belt_speed, radius);
        (self.steepest[lane], self.rate[lane], self.rise[lane]) = (fall.steepest, fall.rate, fall.rise);
        self.squared[lane] = f64::from(u8::from(fall.is_squared));
        self.is_left[lane] = false;
        let angle = |q: f64| 2.0 * (q / (2.0 * radius).sqrt()).asin();
        (self.x[lane], self.end[lane]) = (angle(start.q), FRAC_PI_2);
        self.width[lane] = start.step * (2.0 / radius).sqrt();
        self.first[lane] = self.width[lane];
        for (part, value) in [start.h, start.by_damping, 0.0].into_iter().enumerate() {
            self.state[part * LANES + lane] = value;
        }
        (self.error[lane], self.beyond_stop[lane]) = (start.error, 0.0);
        (self.steps[lane], self.rhs[lane]) = (0, rhs);
        self.has_others =
            self.halves.iter().flatten().any(|half| !matches!(half.orbit.rate, Rate::Exponential(_)));
    }

    #[inline(always)]
    fn places(&self, x: &Lanes, state: &State) -> Places {
        let [mut slip, mut square, mut w, mut root] = [[0.0; LANES]; 4];
        let [mut sin, mut cos] = [[0.0; LANES]; 2];
        for lane in 0..LANES {
            // The sines of the angle and of its half have no rounding errors but relative ones.
            let [sin_4, cos_4] = sin_cos(0.25 * x[lane]);
            let sin_2 = 2.0 * sin_4 * cos_4;
            let cos_2 = (-2.0 * sin_4).mul_add(sin_4, 1.0);
            let versine = 2.0 * sin_2 * sin_2;
            (sin[lane], cos[lane]) = (2.0 * sin_2 * cos_2, 1.0 - versine);
            let radius = self.radius[lane];
            let of_r = radius.mul_add(radius, 2.0 * state[lane]);
            let height = radius * sin[lane];
            let of_w = height.mul_add(height, 2.0 * state[lane]);
            let left = self.is_left[lane];
            root[lane] = (if left { of_r } else { of_w }).sqrt();
            square[lane] = if left { of_r * sin[lane] * sin[lane] } else { of_w };
            let on_left = (-root[lane]).mul_add(cos[lane], self.belt_speed[lane]);
            let on_right = radius.mul_add(versine, self.belt_speed[lane] - radius);
            slip[lane] = if left { on_left } else { on_right };
            // In a loop of its own, which the compiler unrolls, this would not be vectorised.
            let (x, squared) = (self.rate[lane] * slip[lane], self.squared[lane]);
            let fading = exp_falling(-x * squared.mul_add(x, 1.0 - squared));
            let lower = squared.mul_add(2.0 * x, 1.0 - squared);
            w[lane] = (self.steepest[lane] * lower).mul_add(fading, -self.rise[lane]);
        }
        if self.has_others {
            for lane in 0..LANES {
                if let Some(half) = &self.halves[lane]
                    && !matches!(half.orbit.rate, Rate::Exponential(_))
                {
                    w[lane] = half.orbit.rate.at(slip[lane]);
                }
            }
        }
        let [mut rate, mut time, mut room] = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            rate[lane] = self.sign[lane] * (w[lane] - self.viscous[lane]);
            let turn = rate[lane].mul_add(sin[lane] * cos[lane], 1.0);
            let left = self.is_left[lane];
            let is_start = x[lane] == 0.0;
            let below = if left { turn } else { root[lane] };
            let above = if left { 1.0 } else { self.radius[lane] * sin[lane] };
            // At the start of a half without a drop W ~ radius sin th.
            time[lane] = if is_start && root[lane] == 0.0 { 1.0 } else { above / below };
            let on_left = turn - SLOWEST_TURN;
            room[lane] = if left { on_left } else { square[lane] };
            room[lane] = if is_start { 1.0 } else { room[lane] };
        }
        Places { slip, square, rate, time, room }
    }

    /// Tries a step in every lane, and takes it where it is accurate. Calls `done` with the number of each half that
    /// ends, its lowest point and the number of evaluations.
    #[inline(always)]
    fn advance(&mut self, mut done: impl FnMut(usize, Option<Lowest>, u64)) {
        for lane in 0..LANES {
            let rest = self.end[lane] - self.x[lane];
            self.h[lane] = if self.width[lane] >= rest { rest } else { self.width[lane] };
        }
        self.room = [f64::INFINITY; LANES];
        let state = self.state;
        let (next, local) = step(1.0, &state, self);
        let to: [f64; LANES] = std::array::from_fn(|lane| {
            let is_last = self.width[lane] >= self.end[lane] - self.x[lane];
            if is_last { self.end[lane] } else { self.x[lane] + self.h[lane] }
        });
        let there = self.places(&to, &next);
        let here = if self.halves.iter().flatten().any(|half| !half.orbit.stops.is_empty()) {
            Some(self.places(&self.x, &state))
        } else {
            None
        };
        for lane in 0..LANES {
            let Some(half) = self.halves[lane] else { continue };
            self.rhs[lane] += STAGES as u64;
            self.steps[lane] += 1;
            if self.steps[lane] > STEP_BUDGET {
                done(self.numbers[lane], None, self.rhs[lane]);
                self.halves[lane] = None;
                continue;
            }
            let [from, h, to] = [self.x[lane], self.h[lane], to[lane]];
            let scale = from.max(self.first[lane]);
            let [before, after] =
                [&state, &next].map(|state| [0, 1, 2].map(|part| state[part * LANES + lane]));
            let room = self.room[lane].min(there.room[lane]);
            let inside = room > 0.0 && after[0].is_finite() && after[1].is_finite();
            let least = corners::LEAST_STEP * scale;
            if let Some(here) = here.as_ref().filter(|_| inside && h > least) {
                let ends = [here, &there].map(|places| End {
                    slip: places.slip[lane],
                    rate: places.square[lane].max(0.0).sqrt() * places.time[lane],
                });
                if let Some(shorter) =
                    corners::shortened(half.orbit.stops, half.orbit.belt_speed - half.orbit.radius, ends, h)
                {
                    self.beyond_stop[lane] = self.beyond_stop[lane].max(h);
                    self.width[lane] = shorter.max(least);
                    continue;
                }
            }
            let square = there.square[lane];
            // The estimate of one part of the state may vanish where the error does not.
            let [of_h, of_slope, of_growth] = [0, 1, 2].map(|part| local[part * LANES + lane]);
            let found = of_h + half.viscous.abs() * of_slope + square * of_growth;
            // Where the orbit is driven an error of h grows like W on the way; where it is braked it vanishes.
            let share = match self.is_left[lane] || there.rate[lane] < 0.0 {
                true => (ACCURATE * square / (SHARE * half.allowed)).min(1.0),
                false => (square.sqrt() / half.orbit.radius).min(1.0),
            };
            // Also that of the angle at which the step ends, which does not shrink with the step.
            let moved = (after[0] - before[0]).abs();
            let rounding = 0.5 * f64::EPSILON * (after[0].abs() + moved * (1.0 + to / h));
            let enough = (SHARE * half.allowed * share).max(rounding);
            let ratio = 0.9 * (enough / found).sqrt().sqrt().sqrt();
            if !inside || !(found <= enough) {
                self.width[lane] = h * if inside { ratio.clamp(0.1, 0.9) } else { 0.25 };
                self.beyond_stop[lane] = 0.0;
                if !(self.width[lane] > SHORTEST_STEP * scale) {
                    done(self.numbers[lane], None, self.rhs[lane]);
                    self.halves[lane] = None;
                }
                continue;
            }
            // A step that begins just before a corner has a first stage of the other side, one that ends just beyond it a last
            // one.
            let kink = here.as_ref().map_or(0.0, |here| {
                let bend = (there.rate[lane] - here.rate[lane]).abs();
                KINK * corners::WIDTH * bend * square * there.time[lane]
            });
            let carried = self.error[lane] * (after[2] - before[2]).exp();
            self.error[lane] = carried + found + ROUNDINGS * rounding + kink;
            for (part, value) in after.into_iter().enumerate() {
                self.state[part * LANES + lane] = value;
            }
            self.x[lane] = to;
            self.width[lane] = (h * ratio.clamp(0.2, 5.0)).max(self.beyond_stop[lane]);
            self.beyond_stop[lane] = 0.0;
            if to == PI {
                let lowest = Lowest { h: after[0], by_damping: after[1], error: self.error[lane] };
                done(self.numbers[lane], Some(lowest), self.rhs[lane]);
                self.halves[lane] = None;
                continue;
            }
            if to == FRAC_PI_2 {
                (self.is_left[lane], self.end[lane]) = (true, PI);
            }
            let longest =
                if self.is_left[lane] { LONGEST_STEP } else { self.first[lane] + LONGEST_RATIO * to };
            self.width[lane] = self.width[lane].min(longest).min(LONGEST_STEP);
        }
    }
}

impl Field<{ 3 * LANES }> for Together<'_> {
    #[inline(always)]
    fn slope(&mut self, stage: usize, state: &State) -> State {
        let x = std::array::from_fn(|lane| NODES[stage].mul_add(self.h[lane], self.x[lane]));
        let Places { square, rate, time, room, .. } = self.places(&x, state);
        let mut slope = [0.0; 3 * LANES];
        for lane in 0..LANES {
            // Keeps NaN, which `f64::min` would drop.
            self.room[lane] = if room[lane] >= self.room[lane] { self.room[lane] } else { room[lane] };
            let by = self.h[lane] * time[lane];
            slope[lane] = rate[lane] * square[lane] * by;
            slope[LANES + lane] =
                rate[lane].mul_add(state[LANES + lane], -self.sign[lane] * square[lane]) * by;
            slope[2 * LANES + lane] = rate[lane] * by;
        }
        slope
    }
}

/// Follows halves; returns the lowest point of each, where it was reached, and the number of evaluations.
#[inline(always)]
pub(super) fn follow(halves: &[Half]) -> Vec<(Option<Lowest>, u64)> {
    let mut found = vec![(None, 0); halves.len()];
    let mut together = Together::new();
    let mut next = 0;
    loop {
        for lane in 0..LANES {
            if together.halves[lane].is_none()
                && let Some(half) = halves.get(next)
            {
                together.load(lane, next, *half);
                next += 1;
            }
        }
        if together.halves.iter().all(Option::is_none) {
            return found;
        }
        together.advance(|number, lowest, rhs| found[number] = (lowest, rhs));
    }
}

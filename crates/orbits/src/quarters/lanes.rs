//! Many quarters, followed together in vector lanes to x2 = 0.

use std::f64::consts::FRAC_PI_2;

use super::quarter::{Quarter, Rate, SHARE};
use crate::dop853::{Field, NODES, STAGES, step};
use crate::polar::{LANES, Vector};
use slipmap_model::corners::{self, End};
use slipmap_model::friction::ExponentialFall;
use slipmap_numbers::Aligned;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::elementary::{exp_falling, sin_cos};

/// Longest step in the angle.
const LONGEST_STEP: f64 = 0.5;
/// Largest error of W^2/2 where x2 = 0 is reached, in units of W^2.
const LARGEST_ERROR: f64 = 0.1;
/// Angle beyond which, and W^2/a^2 up to which a quarter of larger errors, or one that cannot be followed further, has crept
/// up to the equilibrium.
const NEARLY_THERE: f64 = 1.5;
const AT_REST: f64 = 1e-8;
/// Longest step, in units of the angle.
const LONGEST_RATIO: f64 = 1.0;
/// Shortest step, relative to the variable.
const SHORTEST_STEP: f64 = 1e-13;
/// Largest number of steps of a quarter.
const STEP_BUDGET: u64 = 100_000;
/// Largest local error of W^2 where it vanishes later.
const ACCURATE: f64 = 1e-3;
/// Largest weight of a stage at an end of a step.
const KINK: f64 = 0.1;
/// Number of roundings that a step counts for in the error.
const ROUNDINGS: f64 = 4.0;

/// The number of steps that as many evaluations allow a quarter.
pub(super) fn most_steps(evaluations: u64) -> u32 {
    (evaluations / STAGES as u64).min(STEP_BUDGET) as u32
}

/// The state of a quarter at x2 = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arrival {
    /// W^2, and its half beyond that of the start.
    pub(super) square: f64,
    pub(super) h: f64,
    /// The derivatives of h by C, and of ln W^2 by ln radius^2.
    pub(super) by_damping: f64,
    pub(super) by_radius: f64,
    /// Error of h.
    pub(super) error: f64,
}

impl Arrival {
    /// That of a quarter that creeps up to the equilibrium: W = 0.
    fn at_rest(radius: f64) -> Self {
        Self { square: 0.0, h: -0.5 * radius * radius, by_damping: 0.0, by_radius: 0.0, error: 0.0 }
    }
}

/// h, dh/dC and the integral of s D of all lanes.
type State = Aligned<{ 3 * LANES }>;

/// Quarters that are followed together, each by steps of its own.
#[derive(Default)]
struct Together<'a> {
    quarters: [Option<Quarter<'a>>; LANES],
    /// Numbers of the quarters in the list.
    numbers: [usize; LANES],
    sign: Vector,
    viscous: Vector,
    radius: Vector,
    allowed: Vector,
    /// The slip speed at the start, and how far it goes from there.
    slip: Vector,
    way: Vector,
    /// The parameters of an exponential fall; 0 in other lanes.
    steepest: Vector,
    rate: Vector,
    rise: Vector,
    /// 1 where its exponent is 2, and 0 where it is 1.
    squared: Vector,
    has_others: bool,
    /// The angle.
    x: Vector,
    /// Length of the step that is made, and of the next one.
    h: Vector,
    width: Vector,
    state: State,
    error: Vector,
    room: Vector,
    first: Vector,
    beyond_stop: Vector,
    steps: [u32; LANES],
    rhs: [u64; LANES],
}

/// Places of the lanes in their variables: slip speed, W^2, s D and the time by the variable.
struct Places {
    slip: Vector,
    square: Vector,
    rate: Vector,
    time: Vector,
    room: Vector,
}

/// The local error of a step, the largest that is accepted, by what the next step is longer, and the rounding error.
struct Errors {
    found: Vector,
    enough: Vector,
    ratio: Vector,
    rounding: Vector,
}

impl<'a> Together<'a> {
    fn new() -> Self {
        Self { slip: Aligned::all(1.0), radius: Aligned::all(1.0), ..Self::default() }
    }

    /// Puts a quarter into a lane.
    fn load(&mut self, lane: usize, number: usize, quarter: Quarter<'a>) {
        let Quarter { rate, radius, slip, toward, viscous, sign, allowed, .. } = quarter;
        let (start, rhs) = quarter.start();
        let fall = match rate {
            Rate::Exponential(fall) => fall,
            _ => ExponentialFall { steepest: 0.0, rate: 0.0, rise: 0.0, is_squared: false },
        };
        self.quarters[lane] = Some(quarter);
        self.numbers[lane] = number;
        (self.sign[lane], self.viscous[lane], self.allowed[lane]) = (sign, viscous, allowed);
        (self.radius[lane], self.slip[lane], self.way[lane]) = (radius, slip, toward * radius);
        (self.steepest[lane], self.rate[lane], self.rise[lane]) = (fall.steepest, fall.rate, fall.rise);
        self.squared[lane] = f64::from(u8::from(fall.is_squared));
        self.x[lane] = 2.0 * (start.q / (2.0 * radius).sqrt()).asin();
        self.width[lane] = start.step * (2.0 / radius).sqrt();
        self.first[lane] = self.width[lane];
        self.width[lane] = self.width[lane].min(quarter.longest(self.x[lane]));
        for (part, value) in [start.h, start.by_damping, 0.0].into_iter().enumerate() {
            self.state[part * LANES + lane] = value;
        }
        (self.error[lane], self.beyond_stop[lane]) = (start.error, 0.0);
        (self.steps[lane], self.rhs[lane]) = (0, rhs);
        self.has_others =
            self.quarters.iter().flatten().any(|quarter| !matches!(quarter.rate, Rate::Exponential(_)));
    }

    #[inline(always)]
    fn places(&self, x: &Vector, state: &State) -> Places {
        let [mut slip, mut square, mut w, mut sin] = [Vector::default(); 4];
        for lane in 0..LANES {
            // The sines of the angle and of its half have no rounding errors but relative ones.
            let [sin_4, cos_4] = sin_cos(0.25 * x[lane]);
            let sin_2 = 2.0 * sin_4 * cos_4;
            let cos_2 = (-2.0 * sin_4).times_plus(sin_4, 1.0);
            sin[lane] = 2.0 * sin_2 * cos_2;
            let height = self.radius[lane] * sin[lane];
            square[lane] = height.times_plus(height, 2.0 * state[lane]);
            slip[lane] = self.way[lane].times_plus(2.0 * sin_2 * sin_2, self.slip[lane]);
            // In a loop of its own, which the compiler unrolls, this would not be vectorised.
            let (x, squared) = (self.rate[lane] * slip[lane], self.squared[lane]);
            let fading = exp_falling(-x * squared.times_plus(x, 1.0 - squared));
            let lower = squared.times_plus(2.0 * x, 1.0 - squared);
            w[lane] = (self.steepest[lane] * lower).times_plus(fading, -self.rise[lane]);
        }
        if self.has_others {
            for lane in 0..LANES {
                if let Some(quarter) = &self.quarters[lane]
                    && !matches!(quarter.rate, Rate::Exponential(_))
                {
                    w[lane] = quarter.rate.at(slip[lane]);
                }
            }
        }
        let [mut rate, mut time, mut room] = [Vector::default(); 3];
        for lane in 0..LANES {
            rate[lane] = self.sign[lane] * (w[lane] - self.viscous[lane]);
            let (is_start, speed) = (x[lane] == 0.0, square[lane].sqrt());
            // At the start of a quarter without a drop W ~ radius sin th.
            time[lane] = if is_start && speed == 0.0 { 1.0 } else { self.radius[lane] * sin[lane] / speed };
            room[lane] = if is_start { 1.0 } else { square[lane] };
        }
        Places { slip, square, rate, time, room }
    }

    /// The arrival of a quarter that cannot be followed further, where it has crept up to the equilibrium.
    fn crept(&self, lane: usize) -> Option<Arrival> {
        let height = self.radius[lane] * self.x[lane].sin();
        let square = height.times_plus(height, 2.0 * self.state[lane]);
        let is_there = self.x[lane] > NEARLY_THERE && square < AT_REST * self.radius[lane].powi(2);
        is_there.then(|| Arrival::at_rest(self.radius[lane]))
    }

    /// The errors of the step to these angles.
    #[inline(always)]
    fn errors(&self, next: &State, local: &State, there: &Places, to: &Vector) -> Errors {
        let [mut found, mut enough, mut ratio, mut rounding] = [Vector::default(); 4];
        for lane in 0..LANES {
            let (square, allowed) = (there.square[lane], SHARE * self.allowed[lane]);
            // The estimate of one part of the state may vanish where the error does not.
            let [of_h, of_slope, of_growth] = [0, 1, 2].map(|part| local[part * LANES + lane]);
            found[lane] = of_h + self.viscous[lane].abs() * of_slope + square * of_growth;
            // Where the orbit is driven an error of h grows like W on the way; where it is braked it vanishes.
            let braked = (ACCURATE * square / allowed).min(1.0);
            let driven = (square.sqrt() / self.radius[lane]).min(1.0);
            let share = if there.rate[lane] < 0.0 { braked } else { driven };
            // Also that of the angle at which the step ends, which does not shrink with the step.
            let moved = (next[lane] - self.state[lane]).abs();
            rounding[lane] =
                0.5 * f64::EPSILON * (next[lane].abs() + moved * (1.0 + to[lane] / self.h[lane]));
            enough[lane] = (allowed * share).max(rounding[lane]);
            ratio[lane] = 0.9 * (enough[lane] / found[lane]).sqrt().sqrt().sqrt();
        }
        Errors { found, enough, ratio, rounding }
    }

    /// Tries a step in every lane, and takes it where it is accurate. Calls `done` with the number of each quarter that
    /// ends, its arrival and the number of evaluations.
    #[inline(always)]
    fn advance(&mut self, mut done: impl FnMut(usize, Option<Arrival>, u64)) {
        for lane in 0..LANES {
            let rest = FRAC_PI_2 - self.x[lane];
            self.h[lane] = if self.width[lane] >= rest { rest } else { self.width[lane] };
        }
        self.room = Aligned::all(f64::INFINITY);
        let state = self.state;
        let (next, local) = step(1.0, &state, self);
        let to = Vector::from_fn(|lane| {
            let is_last = self.width[lane] >= FRAC_PI_2 - self.x[lane];
            if is_last { FRAC_PI_2 } else { self.x[lane] + self.h[lane] }
        });
        let there = self.places(&to, &next);
        let here = if self.quarters.iter().flatten().any(|quarter| !quarter.stops.is_empty()) {
            Some(self.places(&self.x, &state))
        } else {
            None
        };
        let Errors { found, enough, ratio, rounding } = self.errors(&next, &local, &there, &to);
        for lane in 0..LANES {
            let Some(quarter) = self.quarters[lane] else { continue };
            self.rhs[lane] += STAGES as u64;
            self.steps[lane] += 1;
            if self.steps[lane] > quarter.most_steps {
                done(self.numbers[lane], self.crept(lane), self.rhs[lane]);
                self.quarters[lane] = None;
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
                if let Some(shorter) = corners::shortened(quarter.stops, quarter.slip, ends, h) {
                    self.beyond_stop[lane] = self.beyond_stop[lane].max(h);
                    self.width[lane] = shorter.max(least);
                    continue;
                }
            }
            let square = there.square[lane];
            let [found, enough, ratio, rounding] = [found, enough, ratio, rounding].map(|of| of[lane]);
            if !inside || !(found <= enough) {
                self.width[lane] = h * if inside { ratio.clamp(0.1, 0.9) } else { 0.25 };
                self.beyond_stop[lane] = 0.0;
                if !(self.width[lane] > SHORTEST_STEP * scale) {
                    done(self.numbers[lane], self.crept(lane), self.rhs[lane]);
                    self.quarters[lane] = None;
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
            if to == FRAC_PI_2 {
                let arrival = Arrival {
                    square,
                    h: after[0],
                    by_damping: after[1],
                    by_radius: quarter.radius * quarter.radius * after[2].exp() / square,
                    error: self.error[lane],
                };
                let is_known = arrival.error < LARGEST_ERROR * square;
                let arrival = if is_known { Some(arrival) } else { self.crept(lane) };
                done(self.numbers[lane], arrival, self.rhs[lane]);
                self.quarters[lane] = None;
                continue;
            }
            if there.rate[lane] < -2.0
                && self.steps[lane].is_power_of_two()
                && quarter.creeps_to_rest(to, square.sqrt())
            {
                done(self.numbers[lane], Some(Arrival::at_rest(quarter.radius)), self.rhs[lane]);
                self.quarters[lane] = None;
                continue;
            }
            let longest = (self.first[lane] + LONGEST_RATIO * to).min(LONGEST_STEP);
            self.width[lane] = self.width[lane].min(longest).min(quarter.longest(to));
        }
    }
}

impl Field<{ 3 * LANES }> for Together<'_> {
    #[inline(always)]
    fn slope(&mut self, stage: usize, state: &State) -> State {
        let x = Vector::from_fn(|lane| NODES[stage].times_plus(self.h[lane], self.x[lane]));
        let Places { square, rate, time, room, .. } = self.places(&x, state);
        let mut slope = State::default();
        for lane in 0..LANES {
            // Keeps NaN, which `f64::min` would drop.
            self.room[lane] = if room[lane] >= self.room[lane] { self.room[lane] } else { room[lane] };
            let by = self.h[lane] * time[lane];
            slope[lane] = rate[lane] * square[lane] * by;
            slope[LANES + lane] =
                rate[lane].times_plus(state[LANES + lane], -self.sign[lane] * square[lane]) * by;
            slope[2 * LANES + lane] = rate[lane] * by;
        }
        slope
    }
}

/// Follows quarters; returns the arrival of each, where there is one, and the number of evaluations.
#[inline(always)]
pub(super) fn follow(quarters: &[Quarter]) -> Vec<(Option<Arrival>, u64)> {
    let mut found = vec![(None, 0); quarters.len()];
    let mut together = Together::new();
    let mut next = 0;
    loop {
        for lane in 0..LANES {
            if together.quarters[lane].is_none()
                && let Some(quarter) = quarters.get(next)
            {
                together.load(lane, next, *quarter);
                next += 1;
            }
        }
        if together.quarters.iter().all(Option::is_none) {
            return found;
        }
        together.advance(|number, arrival, rhs| found[number] = (arrival, rhs));
    }
}

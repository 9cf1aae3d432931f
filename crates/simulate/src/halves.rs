//! The damping at which an orbit closes, from its two halves: for laws that fall steeply next to the belt line, and
//! for friction that drops as slip begins. The polar angle of such an orbit is not monotone in time, or hardly so.
//!
//! The orbit that starts at (x2, x2') = (`radius`, -j) and ends at the maximum `radius` of x2 is followed from both ends
//! to its lowest point, forward and backward in time. With s = 1 forward and -1 backward, W = |x2'| and the slip speed
//! u = V - x2, either half obeys, while x2 > 0 and u rises from its least value u0 = V - radius,
//!
//! ```text
//! dW/du = s D(u) + (V - u)/W,    W(u0) = j forward and 0 backward,    D = w(u) - C
//! ```
//!
//! so that the distance of two solutions at the same slip speed never grows: both halves are stable, however steep
//! the law. Forward alone the end of the orbit is not: where friction is steep, it creeps up to the belt line along an
//! unstable curve of equilibria. The state is the energy beyond that of the start, h = (x2^2 + W^2 - radius^2)/2,
//! with its derivative by C:
//!
//! ```text
//! dh/dt = s D W^2,    d(dh/dC)/dt = s (D dh/dC - W^2),    t the time along the half
//! ```
//!
//! up to the lowest point. The orbit closes where both halves have the same h there. Newton's method needs the
//! derivative at fixed slip speed alone, because h is stationary in u at the lowest point.
//!
//! **Steps.** The variable is the angle th of u = u0 + radius (1 - cos th) while x2 > 0, in which W is smooth at the
//! start, then the polar angle. Steps grow in geometric progression out of the layer in which the law is steep: their number grows like the
//! logarithm of its width.
//!
//! **The creeping end.** Where -s D is large, W follows (u - V)/(s D), and forgets its start. The half starts so late
//! that it forgets this start as far as the tolerance needs, and early steps are not stiff.
//!
//! **Error.** The sum of the local error estimates of h, each carried to the lowest point by the exponential of
//! the integral of s D over the time between (Liouville's formula, at fixed u), divided by the derivative by C.

use std::f64::consts::{FRAC_PI_2, PI};

use super::dop853::{Field, NODES, STAGES, step};
use super::elements::sin_cos;
use super::polar::{Closing, LANES, exp_falling};
use super::work::Work;
use slipmap_model::corners::{self, End};
use slipmap_model::friction::{Curve, ExponentialFall, Range, Weakening};

/// Rate of the polar angle by the law, from which on the halves are followed.
const STEEP: f64 = 0.6;
/// Share of that rate which is more than it, where sin and cos are those of a small angle.
const CERTAINLY: f64 = 1.5;
/// Least dth/dt in the half where x2 < 0.
const SLOWEST_TURN: f64 = 0.05;
/// Largest relative error of W where a half starts late, and the ratio of the slip speeds at which such a place is
/// sought.
const BALANCED: f64 = 0.1;
const SAMPLES_RATIO: f64 = 0.84;
/// Largest such ratio. Smaller ratios of the brakings at two such places, and a smaller effect of braking between them,
/// tell nothing new.
const FINEST_RATIO: f64 = 0.9999;
const BRAKED: f64 = 2.0;
/// Longest step in the polar angle.
const LONGEST_STEP: f64 = 0.5;
/// Longest step in q, in units of q.
const LONGEST_RATIO: f64 = 1.0;
/// First step, in units of the width of the layer in q.
const FIRST_STEP: f64 = 0.2;
/// Shortest step, relative to the variable.
const SHORTEST_STEP: f64 = 1e-13;
/// Largest number of steps of a half.
const STEP_BUDGET: u32 = 20_000;
/// Share of the tolerance for the local error estimate of one step.
const SHARE: f64 = 0.04;
/// Largest local error of W^2 where it vanishes later.
const ACCURATE: f64 = 1e-3;
/// Largest weight of a stage at an end of a step.
const KINK: f64 = 0.1;
/// Number of roundings that a step counts for in the error.
const ROUNDINGS: f64 = 4.0;
/// Error of C of the first orbits, which only lead near a root, in units of C.
const ROUGH: f64 = 1e-5;
/// Largest tolerance: of 3,600 coarser orbits two had an error of twice the estimate.
const COARSEST: f64 = 1e-9;
/// Change of C, in units of C and of the fourth root of the tolerance, after which the next orbit is the last one.
const NEARLY: f64 = 5.0;
/// Least distance, in units of C, from an orbit that does not turn to one that may.
const NEAREST_RETREAT: f64 = 0.02;
/// Largest number of orbits in the search for a root; three are usual.
const MOST_ORBITS: u32 = 40;
/// Safety factor of the error left by a step of Newton's method.
const CURVATURE: f64 = 4.0;

/// The weakening rate.
#[derive(Clone, Copy)]
enum Rate<'a> {
    Exponential(ExponentialFall),
    Law(&'a Curve),
    Polynomials(&'a Weakening),
}

impl Rate<'_> {
    fn at(&self, u: f64) -> f64 {
        match self {
            Rate::Exponential(ExponentialFall { steepest, rate, rise }) => {
                steepest * (-rate * u).exp() - rise
            }
            Rate::Law(curve) => curve.weakening(u),
            Rate::Polynomials(weakening) => weakening.at(u),
        }
    }

    /// Bounds over slip speeds; of an exponential fall its values at the ends.
    fn range(&self, lo: f64, hi: f64) -> Range {
        match self {
            Rate::Exponential(_) => Range { lo: self.at(hi), hi: self.at(lo) },
            Rate::Law(curve) => curve.weakening_range(lo, hi),
            Rate::Polynomials(weakening) => weakening.range(lo, hi),
        }
    }
}

/// An orbit that is to close.
#[derive(Clone, Copy)]
struct Orbit<'a> {
    rate: Rate<'a>,
    stops: &'a [f64],
    belt_speed: f64,
    /// x2 at the start and at the end.
    radius: f64,
    /// -x2' at the start.
    drop: f64,
    /// See [`layer`]; `radius` where the law is not steep.
    layer: f64,
}

/// The least slip speed beyond `least` = V - `radius`, to a factor of two, at which |w sin cos| of the polar angle comes near
/// 1: where the layer begins that is too steep for the polar form of the orbit through the maximum `radius` of x2.
/// `None` where the law is not too steep.
fn layer(curve: &Curve, belt_speed: f64, radius: f64) -> Option<f64> {
    let least = belt_speed - radius;
    let size = |range: Range| range.hi.abs().max(range.lo.abs());
    // Where a rate this large is too steep, if it is so from `from` on.
    let steep_from = |from: f64, rate: f64| {
        let beyond = from.max(0.5 * radius * (CERTAINLY * STEEP / rate).powi(2));
        let v = radius - beyond;
        let sin_cos = (beyond * (radius + v)).sqrt() * v / (radius * radius);
        (v > 0.0 && rate * sin_cos > STEEP).then_some(beyond)
    };
    if curve.has_closed_form() {
        let first = steep_from(0.0, size(curve.weakening_range(least, belt_speed)))?;
        let octaves = std::iter::successors(Some(first), |beyond| Some(2.0 * beyond));
        let mut octaves = octaves.take_while(|beyond| *beyond < radius);
        return octaves.find_map(|beyond| {
            let range = curve.weakening_range(least + beyond, least + 2.0 * beyond);
            steep_from(beyond, size(range)).filter(|from| *from < 2.0 * beyond)
        });
    }
    let weakening = curve.compiled(4.0 * belt_speed);
    weakening.sizes().find_map(|([from, to], rate)| {
        steep_from((from - least).max(0.0), rate).filter(|beyond| *beyond < to - least)
    })
}

/// Where a half starts.
#[derive(Clone, Copy)]
struct Start {
    q: f64,
    h: f64,
    by_damping: f64,
    /// Error of h.
    error: f64,
    /// Length of the first step.
    step: f64,
}

/// A half to be followed to its lowest point.
#[derive(Clone, Copy)]
struct Half<'a> {
    orbit: Orbit<'a>,
    viscous: f64,
    /// 1 forward in time, -1 backward.
    sign: f64,
    /// Error allowed of h at the lowest point.
    allowed: f64,
}

impl Half<'_> {
    /// The start, with the number of evaluations.
    fn start(&self) -> (Start, u64) {
        let Self { orbit: Orbit { rate, belt_speed, radius, drop, layer, .. }, viscous, sign, allowed } =
            *self;
        let least = belt_speed - radius;
        let braking = |u: f64| -sign * (rate.at(u) - viscous);
        let speed = if sign > 0.0 { drop } else { 0.0 };
        // A drop is felt until W by the spring, (2 radius)^(1/2) q, exceeds it.
        let of_drop = if speed > 0.0 { speed / (2.0 * radius).sqrt() } else { f64::INFINITY };
        let step = FIRST_STEP * layer.sqrt().min(of_drop);
        let immediate = Start { q: 0.0, h: 0.5 * speed * speed, by_damping: 0.0, error: 0.0, step };
        // The most braking between two places.
        let most = |from: f64, to: f64| {
            let Range { lo, hi } = rate.range(least + from, least + to);
            if sign > 0.0 { viscous - lo } else { hi - viscous }
        };
        if speed > 0.0 || most(layer.min(0.5 * radius), 0.5 * radius) <= BRAKED {
            return (immediate, 2);
        }
        // W by the balance of braking and spring, from the middle towards the start, and its change by u.
        let (mut beyond, mut forgotten) = (0.5 * radius, 0.0);
        let (mut farther, mut before) = (f64::INFINITY, 0.0_f64);
        let (mut rhs, mut ratio, mut width) = (0, SAMPLES_RATIO, 0.0);
        // Whether a step would forget much more than the braking `here` at its beginning tells.
        let is_hidden = |from: f64, to: f64, here: f64| {
            let most = most(from, to);
            let forgotten = most * most / (radius - from) * (to - from);
            most > BRAKED * here && forgotten > BRAKED && most.is_finite()
        };
        while beyond > layer {
            let here = braking(least + beyond);
            rhs += 1;
            let speed = if here > 0.0 { (radius - beyond) / here } else { f64::INFINITY };
            let stiffness = (radius - beyond) / (speed * speed);
            // Both fall exponentially where the law does.
            let rise = stiffness / before;
            let mean = if rise > 2.0 { (stiffness - before) / rise.ln() } else { stiffness.min(before) };
            forgotten += mean * width;
            let off = (farther - speed).abs() / (width * here);
            let error = speed * speed * off;
            if off < BALANCED && error < SHARE * allowed * f64::exp(forgotten) {
                let h = 0.5 * speed.mul_add(speed, -beyond * (2.0 * radius - beyond));
                let (q, by_damping) = (beyond.sqrt(), -sign * speed * speed / here);
                return (Start { q, h, by_damping, error, step: 0.5 / (stiffness * q) }, rhs);
            }
            (farther, before) = (speed, stiffness);
            // Steps are short where a law begins to brake, or would be passed over.
            ratio = (ratio * ratio).max(SAMPLES_RATIO);
            let is_known = matches!(rate, Rate::Exponential(_));
            while !is_known && ratio < FINEST_RATIO && is_hidden(ratio * beyond, beyond, here) {
                ratio = ratio.sqrt();
            }
            width = beyond * (1.0 - ratio);
            beyond *= ratio;
        }
        (immediate, rhs)
    }
}

/// The state at the lowest point of a half.
#[derive(Clone, Copy, Debug)]
struct Lowest {
    h: f64,
    by_damping: f64,
    error: f64,
}

/// Numbers of [`LANES`] halves.
type Lanes = [f64; LANES];
/// h, dh/dC and the integral of s D of all lanes.
type State = [f64; 3 * LANES];

/// Halves that are followed together, each by steps of its own.
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
        let zero = [0.0; LANES];
        Self {
            halves: [None; LANES],
            numbers: [0; LANES],
            sign: zero,
            viscous: zero,
            belt_speed: [1.0; LANES],
            radius: [1.0; LANES],
            steepest: zero,
            rate: zero,
            rise: zero,
            has_others: false,
            is_left: [false; LANES],
            x: zero,
            h: zero,
            width: zero,
            end: zero,
            state: [0.0; 3 * LANES],
            error: zero,
            room: zero,
            first: zero,
            beyond_stop: zero,
            steps: [0; LANES],
            rhs: [0; LANES],
        }
    }

    /// Puts a half into a lane.
    fn load(&mut self, lane: usize, number: usize, half: Half<'a>) {
        let Half { orbit: Orbit { rate, belt_speed, radius, .. }, viscous, sign, .. } = half;
        let (start, rhs) = half.start();
        let fall = match rate {
            Rate::Exponential(fall) => fall,
            _ => ExponentialFall { steepest: 0.0, rate: 0.0, rise: 0.0 },
        };
        self.halves[lane] = Some(half);
        self.numbers[lane] = number;
        (self.sign[lane], self.viscous[lane]) = (sign, viscous);
        (self.belt_speed[lane], self.radius[lane]) = (belt_speed, radius);
        (self.steepest[lane], self.rate[lane], self.rise[lane]) = (fall.steepest, fall.rate, fall.rise);
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
            let fading = exp_falling(-self.rate[lane] * slip[lane]);
            w[lane] = self.steepest[lane].mul_add(fading, -self.rise[lane]);
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
            let inside = self.room[lane] > 0.0 && after[0].is_finite() && after[1].is_finite();
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

/// Arguments of [`Together::advance`] for all halves of a list, for the function whose vector width pulp selects at run
/// time.
struct Follow<'a, 'b> {
    halves: &'b [Half<'a>],
}

impl pulp::WithSimd for Follow<'_, '_> {
    /// The lowest point of each half, where it was reached, and the number of evaluations.
    type Output = Vec<(Option<Lowest>, u64)>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Self::Output {
        let mut found = vec![(None, 0); self.halves.len()];
        let mut together = Together::new();
        let mut next = 0;
        loop {
            for lane in 0..LANES {
                if together.halves[lane].is_none()
                    && let Some(half) = self.halves.get(next)
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
}

/// An orbit whose C is sought: a column's law, and the maximum of x2 at which the orbit closes.
pub(super) struct Sought<'a> {
    curve: &'a Curve,
    belt_speed: f64,
    radius: f64,
    layer: Option<f64>,
    start: f64,
    bounds: [f64; 2],
}

impl<'a> Sought<'a> {
    /// The orbit from the exit point, where friction drops as slip begins or falls so steeply that the polar angle is not
    /// monotone; `None` elsewhere. The search begins at `start` and stays within bounds.
    pub(super) fn from_exit(
        curve: &'a Curve,
        belt_speed: f64,
        start: impl FnOnce() -> f64,
        bounds: impl FnOnce() -> [f64; 2],
    ) -> Option<Self> {
        let layer = layer(curve, belt_speed, belt_speed);
        if layer.is_none() && curve.drop() == 0.0 || curve.is_hidden_by_rounding(belt_speed) {
            return None;
        }
        Some(Self { curve, belt_speed, radius: belt_speed, layer, start: start(), bounds: bounds() })
    }
}

/// The state of a search.
struct Search<'a> {
    orbit: Orbit<'a>,
    /// Bound of the error of h by that of the law's polynomials.
    form: f64,
    viscous: f64,
    bounds: [f64; 2],
    /// Unit of C, and its accuracy.
    size: f64,
    aim: f64,
    is_accurate: bool,
    /// C and the derivative by C of the orbit before.
    before: Option<[f64; 2]>,
    /// -dh/dC, and the change of its logarithm by C.
    steepness: f64,
    curvature: f64,
    rhs: u64,
    work: Work,
}

impl Search<'_> {
    /// The halves to be followed next.
    fn halves(&self) -> [Half<'_>; 2] {
        let requested = if self.is_accurate { self.aim } else { self.aim.max(ROUGH * self.size) };
        let allowed = requested * self.steepness;
        [1.0, -1.0].map(|sign| Half { orbit: self.orbit, viscous: self.viscous, sign, allowed })
    }

    /// Makes a step of Newton's method; returns the C at which the orbit closes once it is found, or `Err` with the
    /// number of evaluations once it cannot be.
    fn advance(&mut self, [forward, backward]: [(Option<Lowest>, u64); 2]) -> Option<Result<Closing, u64>> {
        let spent = forward.1 + backward.1;
        self.rhs += spent;
        let within = self.work.spend_compiled(spent).is_ok();
        if !within {
            return Some(Err(self.rhs));
        }
        let Some((forward, backward)) = forward.0.zip(backward.0) else {
            // So far beyond the root that the orbit does not turn.
            let nearer = self.before.map_or(self.bounds[0].max(0.0), |[at, _]| at);
            if !((self.viscous - nearer).abs() > NEAREST_RETREAT * self.size) {
                return Some(Err(self.rhs));
            }
            self.viscous = 0.5 * (nearer + self.viscous);
            return None;
        };
        let (gap, error) = (forward.h - backward.h, forward.error + backward.error);
        let by_damping = forward.by_damping - backward.by_damping;
        let viscous = self.viscous;
        let [low, high] = &mut self.bounds;
        if gap > error {
            *low = low.max(viscous);
        } else if gap < -error {
            *high = high.min(viscous);
        }
        if let Some([at, slope]) = self.before
            && at != viscous
        {
            self.curvature = 0.5 * ((by_damping - slope) / ((viscous - at) * by_damping)).abs();
        }
        self.before = Some([viscous, by_damping]);
        self.steepness = by_damping.abs();
        let newton = viscous - gap / by_damping;
        let change = (newton - viscous).abs();
        let own = error / self.steepness;
        let left = (CURVATURE * self.curvature * change * change).min(change);
        let floor = 4.0 * f64::EPSILON * viscous.abs();
        if self.is_accurate && (change <= own || left <= self.aim.max(own)) {
            let error = own + left + self.form / self.steepness + floor;
            let found = Closing { viscous: newton, error, rhs: self.rhs, slope: None };
            return Some(if error.is_finite() { Ok(found) } else { Err(self.rhs) });
        }
        let near = NEARLY * (self.aim / self.size).sqrt().sqrt() * self.size;
        self.is_accurate |= change <= own.max(near) || *high - *low <= floor;
        let inside = newton > *low && newton < *high;
        self.viscous = if inside { newton } else { 0.5 * (*low + *high) };
        None
    }
}

/// The C at which many orbits close, with errors of about `tolerance` in units of C; `Err` with the number of evaluations
/// where the form does not apply.
///
/// An orbit's answer does not depend on its neighbours in the slice, nor on the machine's vector width.
pub(super) fn closing_dampings_by_halves(sought: &[Sought], tolerance: f64) -> Vec<Result<Closing, u64>> {
    let forms: Vec<_> = sought
        .iter()
        .map(|Sought { curve, belt_speed, radius, .. }| {
            let fastest = belt_speed + radius.hypot(1.0);
            let weakening = (!curve.has_closed_form()).then(|| curve.compiled(2.0 * fastest));
            (weakening, curve.stops(fastest))
        })
        .collect();
    let mut answers = vec![Err(0); sought.len()];
    let mut searches: Vec<(usize, Search)> = Vec::with_capacity(sought.len());
    for (number, (sought, (weakening, stops))) in sought.iter().zip(&forms).enumerate() {
        let Sought { curve, belt_speed, radius, layer, start, bounds } = *sought;
        if !(start.is_finite() && bounds.iter().all(|bound| bound.is_finite())) {
            continue;
        }
        let (rate, form) = match (curve.exponential_fall(), weakening) {
            (Some(fall), _) => (Rate::Exponential(fall), 0.0),
            (None, Some(weakening)) => {
                let error = weakening.integrated_error(belt_speed - radius, belt_speed + radius);
                // The energy changes by the error of w times W, which the fall of friction bounds.
                (Rate::Polynomials(weakening), 2.0 * radius.hypot(1.0) * error)
            }
            (None, None) => (Rate::Law(curve), 0.0),
        };
        let drop = if radius == belt_speed { curve.drop() } else { 0.0 };
        let orbit = Orbit { rate, stops, belt_speed, radius, drop, layer: layer.unwrap_or(radius) };
        let viscous = start.clamp(bounds[0], bounds[1]);
        let size = start.abs().max(1e-3 * curve.weakening(belt_speed).abs());
        let search = Search {
            orbit,
            form,
            viscous,
            bounds,
            size,
            aim: 0.5 * tolerance.min(COARSEST) * size,
            is_accurate: false,
            before: None,
            steepness: 3.0 * radius * radius,
            curvature: f64::INFINITY,
            rhs: 0,
            work: Work::of_question(curve),
        };
        searches.push((number, search));
    }
    let arch = pulp::Arch::new();
    for _ in 0..MOST_ORBITS {
        let halves: Vec<Half> = searches.iter().flat_map(|(_, search)| search.halves()).collect();
        let found = arch.dispatch(Follow { halves: &halves });
        let mut ends = found.chunks_exact(2).map(|ends| [ends[0], ends[1]]);
        searches.retain_mut(|(number, search)| {
            let answer = ends.next().and_then(|ends| search.advance(ends));
            answers[*number] = answer.unwrap_or(Err(search.rhs));
            answer.is_none()
        });
        if searches.is_empty() {
            break;
        }
    }
    answers
}

//! Orbits of the flow, turned, in plain numbers: what curves are made of. Nothing here is trusted.
//!
//! The flow is *turned* by kappa in the metric (a u, y), a = sqrt(1 + D^2): `v' = y +- kappa F_y / a`,
//! `y' = F_y -+ kappa a y`, with the upper signs for curves that orbits cross outwards. On its orbits
//! `S = +- kappa (F_y^2 / a + a y^2)`, of one sign everywhere. Steps are Gragg's, extrapolated.

use std::cell::Cell;

use super::check::Field;
use slipmap_model::friction::Polynomial;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::jet::Real as _;

/// Numbers of intervals of the modified midpoint rule: 2, 4, .., twice this.
const LEVELS: usize = 7;
/// Error of a step, relative to the size of the state.
const SHARPNESS: f64 = 3e-14;
/// Share of the belt speed to which the state counts at least.
const FLOOR: f64 = 0.01;
/// Largest number of steps of an orbit.
const MOST_STEPS: usize = 4000;
/// Distance from the equilibrium, in belt speeds, at which an orbit is said to creep into it.
const CREEPS: f64 = 1e-3;
/// First step in time, and the largest.
const STEPS: [f64; 2] = [1e-3, 0.3];

/// A state (u, y).
pub(super) type State = [f64; 2];

/// The flow of a field, turned.
#[derive(Clone, Copy, Debug)]
pub(super) struct Turned<'a> {
    pub(super) field: &'a Field,
    /// kappa, negative for curves that orbits cross outwards.
    pub(super) kappa: f64,
    /// The corners of the law between which it is; beyond them the polynomials there continue the law, so
    /// that no step feels a corner that it ends at.
    section: [f64; 2],
    /// The steps that are left to the curves of a column.
    work: &'a Cell<u64>,
}

/// Where an orbit is followed to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Until {
    /// y = 0 left of the equilibrium.
    Turns,
    /// The belt line, above.
    Lands,
}

/// How an orbit ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum End {
    /// At a state, after a time.
    At { state: State, time: f64 },
    /// Beyond the slip speeds of the law.
    Beyond,
    /// Near the equilibrium, or it turns before it comes there, or takes too many steps.
    Creeps,
}

impl<'a> Turned<'a> {
    pub(super) fn new(field: &'a Field, kappa: f64, work: &'a Cell<u64>) -> Self {
        Self { field, kappa, section: [0.0, f64::INFINITY], work }
    }

    /// Whether no steps are left: then orbits are not followed farther.
    fn is_spent(&self) -> bool {
        self.work.get() == 0
    }

    /// The flow between the corners next to a state, from which it goes in the direction of time that `sign`
    /// has.
    pub(super) fn near(&self, [u, y]: State, sign: f64) -> Self {
        let corners = self.field.law.corners();
        // u' = -y. At a corner the section is the one that it enters.
        let rises = sign * y < 0.0;
        let above = corners.partition_point(|corner| if rises { *corner <= u } else { *corner < u });
        let lo = above.checked_sub(1).map_or(0.0, |below| corners[below]);
        let hi = corners.get(above).copied().unwrap_or(f64::INFINITY);
        Self { section: [lo, hi], ..*self }
    }

    /// A time in which a state hardly goes beyond its section, at its speed: in a longer step it might leave the section
    /// and come back, by a law that is not the one there.
    pub(super) fn room(&self, state: State, sign: f64) -> f64 {
        let ([lo, hi], speed) = (self.section, sign * self.rate(state)[0]);
        let time = if speed > 0.0 { (hi - state[0]) / speed } else { (lo - state[0]) / speed };
        let is_bounded = time > 0.0 && (speed > 0.0 || lo > 0.0);
        if is_bounded { 1.5 * time } else { f64::INFINITY }
    }

    /// The state on the way from one to a later one at which the flow leaves its section, and the time from
    /// the later one to it, which is negative in the direction `sign`; `None` where it does not leave, or the
    /// way is hardly across.
    pub(super) fn leaves(&self, later: State, sign: f64) -> Option<(State, f64)> {
        let [lo, hi] = self.section;
        let corner = if later[0] > hi {
            hi
        } else if later[0] < lo && lo > 0.0 {
            lo
        } else {
            return None;
        };
        let (mut state, mut time) = (later, 0.0);
        for _ in 0..8 {
            let back = (corner - state[0]) / self.rate(state)[0];
            if !back.is_finite() {
                return None;
            }
            state = self.step(state, back).0;
            time += sign * back;
        }
        let is_found = (state[0] - corner).abs() <= 1e-12 * corner && time <= 0.0;
        is_found.then_some(([corner, state[1]], time))
    }
    /// a at a slip speed.
    pub(super) fn metric(&self, u: f64) -> f64 {
        let d = self.divergence(u);
        (1.0 + d * d).sqrt()
    }

    fn divergence(&self, u: f64) -> f64 {
        let (law, [lo, hi]) = (&self.field.law, self.section);
        let beyond = |end: f64| {
            let Polynomial { middle, scale, c } = law.polynomial(law.piece_of(end.min(law.reach())));
            ((u - middle) * scale).polynomial(c)
        };
        let w = if u <= 0.0 {
            law.at(0.0)
        } else if u < lo {
            beyond(lo)
        } else if u >= hi {
            beyond(hi.next_down())
        } else {
            law.at(u)
        };
        w - self.field.viscous
    }

    /// F_y and a.
    pub(super) fn force(&self, [u, y]: State) -> [f64; 2] {
        let d = self.divergence(u);
        [u - self.field.belt_speed + d * y, (1.0 + d * d).sqrt()]
    }

    /// u' and y'.
    fn rate(&self, state: State) -> State {
        let [force, a] = self.force(state);
        let y = state[1];
        [-y + self.kappa * force / a, force + self.kappa * a * y]
    }

    /// The modified midpoint rule with `count` intervals over a time.
    fn midpoint(&self, from: State, rate: State, time: f64, count: usize) -> State {
        let h = time / count as f64;
        let step = |a: State, rate: State, h: f64| [h.times_plus(rate[0], a[0]), h.times_plus(rate[1], a[1])];
        let (mut before, mut now) = (from, step(from, rate, h));
        for _ in 1..count {
            (before, now) = (now, step(before, self.rate(now), 2.0 * h));
        }
        let end = step(before, self.rate(now), h);
        [0.5 * (now[0] + end[0]), 0.5 * (now[1] + end[1])]
    }

    /// The state after a time, and its error by the last two extrapolations in units of what is allowed.
    fn step(&self, from: State, time: f64) -> (State, f64) {
        self.work.set(self.work.get().saturating_sub(1));
        let rate = self.rate(from);
        let mut row: [State; LEVELS] = [from; LEVELS];
        let mut error = f64::INFINITY;
        for level in 0..LEVELS {
            let mut value = self.midpoint(from, rate, time, 2 * (level + 1));
            for k in 1..=level {
                let ratio = (level + 1) as f64 / (level + 1 - k) as f64;
                let weight = 1.0 / (ratio * ratio - 1.0);
                let lower = row[k - 1];
                row[k - 1] = value;
                let better = [0, 1].map(|i| (value[i] - lower[i]).times_plus(weight, value[i]));
                error = self.apart(better, value);
                value = better;
            }
            row[level] = value;
        }
        (row[LEVELS - 1], error)
    }

    fn apart(&self, one: State, two: State) -> f64 {
        let floor = FLOOR * self.field.belt_speed;
        let part = |i: usize| (one[i] - two[i]).abs() / (SHARPNESS * (one[i].abs() + floor));
        part(0).max(part(1))
    }

    /// Whether an orbit cannot be followed farther.
    fn end(&self, [u, y]: State) -> Option<End> {
        let belt_speed = self.field.belt_speed;
        if !(u <= self.field.law.reach() && y.is_finite()) {
            return Some(End::Beyond);
        }
        ((u - belt_speed).hypot(y) < CREEPS * belt_speed).then_some(End::Creeps)
    }

    /// The orbit from a state to the place `until`, in the direction of time that `sign` has.
    pub(super) fn follow(&self, from: State, sign: f64, until: Until) -> End {
        let (mut state, mut time, mut h) = (from, 0.0, STEPS[0]);
        let mut has_turned = false;
        for _ in 0..MOST_STEPS {
            if self.is_spent() {
                break;
            }
            let flow = self.near(state, sign);
            h = h.min(flow.room(state, sign));
            let (mut next, error) = flow.step(state, sign * h);
            if !(error <= 1.0) && h > 1e-12 {
                h *= if error.is_finite() { (0.8 * error.powf(-1.0 / 13.0)).clamp(0.1, 0.7) } else { 0.1 };
                continue;
            }
            let mut taken = h;
            if let Some((corner, back)) = flow.leaves(next, sign).filter(|(_, back)| -back < h) {
                (next, taken) = (corner, h + back);
            }
            // Above or below at first, by the direction; then past y = 0, or past the line above.
            let is_past = match until {
                Until::Turns => next[0] > self.field.belt_speed && sign * next[1] >= 0.0,
                Until::Lands => next[1] > 0.0 && next[0] <= 0.0,
            };
            if is_past {
                return flow.located(next, time + taken, sign, until);
            }
            // An orbit that shall land may turn again before the line.
            has_turned |= next[1] > 0.0;
            if has_turned && until == Until::Lands && next[1] < 0.0 {
                return End::Creeps;
            }
            if let Some(end) = self.end(next) {
                return end;
            }
            (state, time) = (next, time + taken);
            h = (h * (0.9 * error.max(1e-10).powf(-1.0 / 13.0)).clamp(0.2, 3.0)).min(STEPS[1]);
        }
        End::Creeps
    }

    /// The place next to a state, by Newton's method in time.
    fn located(&self, near: State, time: f64, sign: f64, until: Until) -> End {
        let axis = usize::from(until == Until::Turns);
        let (mut state, mut time) = (near, time);
        for _ in 0..8 {
            let back = -state[axis] / self.rate(state)[axis];
            if !back.is_finite() {
                return End::Creeps;
            }
            state = self.step(state, back).0;
            time += sign * back;
        }
        state[axis] = 0.0;
        End::At { state, time }
    }

    /// The state after a time, in as many steps as it takes.
    pub(super) fn after(&self, from: State, time: f64) -> Option<State> {
        let (mut state, mut count) = (from, 1_u32);
        let (whole, error) = self.step(from, time);
        if error <= 1.0 {
            return Some(whole);
        }
        while count <= 256 && !self.is_spent() {
            count *= 4;
            let (mut worst, h) = (0.0_f64, time / f64::from(count));
            state = from;
            for _ in 0..count {
                let (next, error) = self.step(state, h);
                (state, worst) = (next, worst.max(error));
            }
            if worst <= 1.0 {
                return Some(state);
            }
        }
        state.iter().all(|x| x.is_finite()).then_some(state)
    }
}

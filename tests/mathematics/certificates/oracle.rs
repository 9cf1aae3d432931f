//! v' = w, w' = -v + D(|v - V|) w on both sides of the belt line, by the classical Runge-Kutta method.

use super::TAU;
use crate::runge_kutta;
use crate::sample::Sample;

/// The fate of the orbit from the exit point (V, 0).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Fate {
    /// x2 turns at this value before the belt line, or tends to the equilibrium.
    Inward(f64),
    /// It reaches the belt line from below with this x2' < 2 and sticks.
    Sticks(f64),
    /// It crosses with this x2' >= 2, comes back from above with x2' in (-2, 0) and sticks.
    SticksFromAbove(f64),
    /// It crosses with this x2' >= 2, and crosses again on the way back.
    Crosses(f64),
}

pub struct Turn {
    pub fate: Fate,
    /// The largest -x2.
    pub amplitude: f64,
}

pub const STEPS_PER_TURN: u32 = 2000;

fn step(p: &Sample, (v, w): (f64, f64), h: f64) -> (f64, f64) {
    let rate = |[v, w]: [f64; 2]| [w, -v + p.divergence((v - p.belt_speed).abs()) * w];
    runge_kutta::step(&rate, [v, w], h).into()
}

/// The state where `done` becomes true within one step.
fn locate(p: &Sample, from: (f64, f64), h: f64, done: impl Fn((f64, f64)) -> bool) -> (f64, f64) {
    let (mut before, mut after) = (0.0, h);
    for _ in 0..60 {
        let middle = 0.5 * (before + after);
        if done(step(p, from, middle)) {
            after = middle;
        } else {
            before = middle;
        }
    }
    step(p, from, after)
}

pub fn turn(p: &Sample, steps_per_turn: u32) -> Turn {
    let h = TAU / f64::from(steps_per_turn);
    let mut state = (p.belt_speed, 0.0);
    let mut amplitude = 0.0f64;
    // A weak node needs much time; thirty turns are far longer than any turn here.
    for _ in 0..30 * steps_per_turn {
        let next = step(p, state, h);
        let rising = state.1 > 0.0;
        if !rising && next.1 > 0.0 {
            amplitude = -locate(p, state, h, |s| s.1 > 0.0).0;
        }
        // Near grazing the orbit may cross and come back within one step: look at the turning point.
        if rising && next.1 <= 0.0 {
            let top = locate(p, state, h, |s| s.1 <= 0.0);
            if top.0 < p.belt_speed {
                return Turn { fate: Fate::Inward(top.0), amplitude };
            }
        }
        if rising && (next.0 >= p.belt_speed || next.1 <= 0.0) {
            let speed = locate(p, state, h, |s| s.0 >= p.belt_speed || s.1 <= 0.0).1;
            let fate = if speed < 2.0 { Fate::Sticks(speed) } else { above(p, speed, h) };
            return Turn { fate, amplitude };
        }
        state = next;
    }
    Turn { fate: Fate::Inward(state.0), amplitude }
}

fn above(p: &Sample, speed: f64, h: f64) -> Fate {
    let mut state = (p.belt_speed, speed - 2.0);
    loop {
        let next = step(p, state, h);
        if next.1 < 0.0 && next.0 <= p.belt_speed {
            let back = locate(p, state, h, |s| s.1 < 0.0 && s.0 <= p.belt_speed);
            return if back.1 > -2.0 { Fate::SticksFromAbove(speed) } else { Fate::Crosses(speed) };
        }
        state = next;
    }
}

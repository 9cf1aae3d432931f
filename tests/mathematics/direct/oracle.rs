//! Slow references for the direct engine, which share only D(u) with it: the scalar polar form and the
//! Liénard form of the flow, by the classical Runge-Kutta method with tiny fixed steps.

use crate::runge_kutta::{change, step};
use slipmap::filippov::Oscillator;

/// A number with a bound on its error.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    pub value: f64,
    pub error: f64,
}

/// The scaled grazing margin from dr/dth = D r sin^2 th / (1 + D sin th cos th), r(0) = V, over one turn.
///
/// `None` if |D| >= 2 on the way, where the polar angle is not monotone in time, or if the steps are too
/// coarse for 1e-12. The relative radius is summed with compensation: what remains are the rounding errors of
/// some thousand slopes of size |D|, averaged over the turn, a few 1e-16.
pub fn polar_margin(oscillator: &Oscillator) -> Option<Known> {
    let [coarse, middle, fine] = [1000, 2000, 4000].map(|steps| polar_turn(oscillator, steps));
    // Richardson's extrapolation removes the h^4 term of the error.
    let better = [middle + (middle - coarse) / 15.0, fine + (fine - middle) / 15.0];
    let error = (better[1] - better[0]).abs() + 1e-15 * (1.0 + better[1].abs());
    (error < 1e-12).then_some(Known { value: better[1], error })
}

fn polar_turn(oscillator: &Oscillator, steps: u32) -> f64 {
    // q = r/V - 1 at the angle th.
    let slope = |angle: f64, [q]: [f64; 1]| {
        let (sin, cos) = angle.sin_cos();
        let d = oscillator.divergence(oscillator.belt_speed * (1.0 - (1.0 + q) * cos));
        [if d.abs() < 2.0 { d * (1.0 + q) * sin * sin / (1.0 + d * sin * cos) } else { f64::NAN }]
    };
    let h = std::f64::consts::TAU / f64::from(steps);
    let (mut q, mut carry) = (0.0_f64, 0.0_f64);
    for i in 0..steps {
        let [change] = change(&slope, f64::from(i) * h, [q], h);
        let add = change + carry;
        let sum = q + add;
        carry = add - (sum - q);
        q = sum;
    }
    q
}

/// The fate of the orbit from the exit point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// It turns short of the belt line; the value is the margin.
    Short,
    /// It sticks from below; the value is the landing speed w.
    Sticks,
    /// It sticks from above; the value is w - 2 on the way down, at the line.
    SticksFromAbove,
    /// It crosses downward; the value is w - 2 there.
    Crosses,
    /// Nothing has happened after a time of 40.
    Rests,
}

/// Follows v' = w, w' = -v + D w in steps of about `turn` radians, and half of that. `None` if the steps are
/// too coarse to decide.
pub fn lienard(
    divergence: &impl Fn(f64) -> f64,
    belt_speed: f64,
    turn: f64,
) -> Option<(Outcome, Known, Known)> {
    let flow = |turn| lienard_flow(divergence, belt_speed, turn);
    let [(kind, coarse), (finer_kind, fine)] = [turn, 0.5 * turn].map(flow);
    let known = |i: usize| {
        let difference = fine[i] - coarse[i];
        Known { value: fine[i] + difference / 15.0, error: difference.abs() + 1e-14 * (1.0 + fine[i].abs()) }
    };
    (kind == finer_kind).then(|| (kind, known(0), known(1)))
}

/// The outcome, and its value and time.
fn lienard_flow(divergence: &impl Fn(f64) -> f64, belt_speed: f64, turn: f64) -> (Outcome, [f64; 2]) {
    let steepest = divergence(0.0).abs().max(divergence(2.0 * belt_speed).abs());
    let h = turn / (1.0 + steepest);
    let below = |[v, w]: [f64; 2]| [w, -v + divergence(belt_speed - v) * w];
    let above = |[v, w]: [f64; 2]| [w, -v + divergence(v - belt_speed) * w];

    let mut state = [belt_speed, 0.0];
    let mut time = 0.0;
    let landing = loop {
        let next = step(&below, state, h);
        let turns = state[1] > 0.0 && next[1] <= 0.0;
        let top = if turns { bisect(h, |t| step(&below, state, t)[1] > 0.0) } else { h };
        let highest = step(&below, state, top)[0];
        if highest >= belt_speed && state[1] > 0.0 {
            let tau = bisect(top, |t| step(&below, state, t)[0] < belt_speed);
            time += tau;
            break step(&below, state, tau)[1];
        }
        if turns {
            return (Outcome::Short, [highest / belt_speed - 1.0, time + top]);
        }
        state = next;
        time += h;
        if time > 40.0 {
            return (Outcome::Rests, [0.0, time]);
        }
    };
    if landing < 2.0 {
        return (Outcome::Sticks, [landing, time]);
    }
    let mut state = [belt_speed, landing - 2.0];
    loop {
        let next = step(&above, state, h);
        if next[0] < belt_speed {
            let top = bisect(h, |t| step(&above, state, t)[1] > 0.0);
            let rest = step(&above, state, top);
            let tau = bisect(h - top, |t| step(&above, rest, t)[0] > belt_speed);
            let w = step(&above, rest, tau)[1];
            let kind = if w > -2.0 { Outcome::SticksFromAbove } else { Outcome::Crosses };
            return (kind, [w, time + top + tau]);
        }
        state = next;
        time += h;
    }
}

/// The largest t in [0, end] up to which `holds`, if it holds up to some t and no farther.
pub fn bisect(end: f64, holds: impl Fn(f64) -> bool) -> f64 {
    let (mut lo, mut hi) = (0.0, end);
    for _ in 0..60 {
        let middle = 0.5 * (lo + hi);
        if holds(middle) { lo = middle } else { hi = middle }
    }
    0.5 * (lo + hi)
}

//! Slow references for the direct engine, which share only D(u) with it: the scalar polar form and the
//! Liénard form of the flow, by the classical Runge-Kutta method with tiny fixed steps.

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
    let slope = |angle: f64, q: f64| {
        let (sin, cos) = angle.sin_cos();
        let d = oscillator.divergence(oscillator.belt_speed * (1.0 - (1.0 + q) * cos));
        if d.abs() < 2.0 { d * (1.0 + q) * sin * sin / (1.0 + d * sin * cos) } else { f64::NAN }
    };
    let h = std::f64::consts::TAU / f64::from(steps);
    let (mut q, mut carry) = (0.0_f64, 0.0_f64);
    for step in 0..steps {
        let angle = f64::from(step) * h;
        let k1 = slope(angle, q);
        let k2 = slope(angle + 0.5 * h, q + 0.5 * h * k1);
        let k3 = slope(angle + 0.5 * h, q + 0.5 * h * k2);
        let k4 = slope(angle + h, q + h * k3);
        let add = h / 6.0 * (k1 + 2.0 * (k2 + k3) + k4) + carry;
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
        let next = runge_kutta(&below, state, h);
        let turns = state[1] > 0.0 && next[1] <= 0.0;
        let top = if turns { bisect(h, |t| runge_kutta(&below, state, t)[1] > 0.0) } else { h };
        let highest = runge_kutta(&below, state, top)[0];
        if highest >= belt_speed && state[1] > 0.0 {
            let tau = bisect(top, |t| runge_kutta(&below, state, t)[0] < belt_speed);
            time += tau;
            break runge_kutta(&below, state, tau)[1];
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
        let next = runge_kutta(&above, state, h);
        if next[0] < belt_speed {
            let top = bisect(h, |t| runge_kutta(&above, state, t)[1] > 0.0);
            let rest = runge_kutta(&above, state, top);
            let tau = bisect(h - top, |t| runge_kutta(&above, rest, t)[0] > belt_speed);
            let w = runge_kutta(&above, rest, tau)[1];
            let kind = if w > -2.0 { Outcome::SticksFromAbove } else { Outcome::Crosses };
            return (kind, [w, time + top + tau]);
        }
        state = next;
        time += h;
    }
}

fn runge_kutta(field: &impl Fn([f64; 2]) -> [f64; 2], z: [f64; 2], h: f64) -> [f64; 2] {
    let along = |k: [f64; 2], t: f64| field([z[0] + t * k[0], z[1] + t * k[1]]);
    let k1 = field(z);
    let k2 = along(k1, 0.5 * h);
    let k3 = along(k2, 0.5 * h);
    let k4 = along(k3, h);
    [0, 1].map(|i| z[i] + h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
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

//! Averages of a law over the grazing circle.

/// Numbers of nodes of the coarsest and of the finest rule over half a turn.
const NODES: [u32; 2] = [16, 1 << 14];

/// The mean over a turn of a function of cos t, given by its values at t in [0, pi]. The trapezoidal rule,
/// doubled until it no longer changes: for smooth functions it converges faster than any power.
pub(super) fn mean_over_turn(f: impl Fn(f64) -> f64) -> f64 {
    let at = |i: u32, n: u32| f(std::f64::consts::PI * f64::from(i) / f64::from(n));
    let mut n = NODES[0];
    let ends = 0.5 * (at(0, 1) + at(1, 1));
    let sum = |from: u32, step: usize, n: u32| {
        (from..n).step_by(step).map(|i| at(i, n)).fold((0.0, 0.0), |(s, size), x| (s + x, size + x.abs()))
    };
    let (mut total, mut size) = sum(1, 1, n);
    total += ends;
    size += ends.abs();
    loop {
        let before = total / f64::from(n);
        n *= 2;
        let (odd, odd_size) = sum(1, 2, n);
        total += odd;
        size += odd_size;
        let now = total / f64::from(n);
        // NaN ends the loop as well.
        if !((now - before).abs() > 2.0 * f64::EPSILON * size / f64::from(n)) || n >= NODES[1] {
            return now;
        }
    }
}

/// The weakening rate averaged over the grazing circle with weight sin^2 t / pi, see
/// [`super::Curve::mean_weakening`].
pub(super) fn mean_weakening(weakening: impl Fn(f64) -> f64, belt_speed: f64) -> f64 {
    2.0 * mean_over_turn(|t| {
        let (half, sin) = ((0.5 * t).sin(), t.sin());
        weakening(2.0 * belt_speed * half * half) * sin * sin
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn averages_of_powers() {
        // u^2 = V^2 (1 - cos t)^2 weighted with sin^2 / pi: V^2 (1 + 1/4).
        let mean = mean_weakening(|u| u * u, 3.0);
        assert!((mean - 9.0 * 1.25).abs() <= 32.0 * f64::EPSILON * 9.0, "{mean}");
    }
}

//! The classical Runge-Kutta method, by which references are followed in small fixed steps.

/// The change of `z` over a step of length `h` from `t` on, of z' = `slope`(t, z).
pub fn change<const N: usize>(
    slope: &impl Fn(f64, [f64; N]) -> [f64; N],
    t: f64,
    z: [f64; N],
    h: f64,
) -> [f64; N] {
    let along = |k: [f64; N], h: f64| std::array::from_fn(|i| z[i] + h * k[i]);
    let k1 = slope(t, z);
    let k2 = slope(t + 0.5 * h, along(k1, 0.5 * h));
    let k3 = slope(t + 0.5 * h, along(k2, 0.5 * h));
    let k4 = slope(t + h, along(k3, h));
    std::array::from_fn(|i| h / 6.0 * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]))
}

/// The state after a step of length `h` from `z`, of z' = `slope`(z).
pub fn step<const N: usize>(slope: &impl Fn([f64; N]) -> [f64; N], z: [f64; N], h: f64) -> [f64; N] {
    let change = change(&|_, z| slope(z), 0.0, z, h);
    std::array::from_fn(|i| z[i] + change[i])
}

/// The state after `steps` steps from `from` to `to`.
pub fn follow<const N: usize>(
    slope: &impl Fn(f64, [f64; N]) -> [f64; N],
    (from, to): (f64, f64),
    start: [f64; N],
    steps: u32,
) -> [f64; N] {
    let h = (to - from) / f64::from(steps);
    (0..steps).fold(start, |z, i| {
        let change = change(slope, from + f64::from(i) * h, z, h);
        std::array::from_fn(|i| z[i] + change[i])
    })
}

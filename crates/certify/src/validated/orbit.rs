//! An approximate grazing orbit in plain f64, without any claim of accuracy: the guess whose error the proof
//! then bounds.
//!
//! At the critical damping the orbit from the exit point closes: r is a periodic function of the angle with
//! r(0) = 1. On N equal angles, sweep
//!
//! ```text
//! g = D r sin^2 / (1 + D sin cos),     C <- C + mean(g) / mean(-dg/dC),     r <- 1 + antiderivative of g
//! ```
//!
//! with trigonometric interpolation, and take more angles until the Fourier coefficients have decayed.
//! `orbits::circle` sweeps likewise, and is not used: proofs and simulation agree without sharing code.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use super::circle::walk;

/// Numbers of angles, coarse to fine.
const SIZES: [usize; 11] = [16, 24, 32, 48, 64, 96, 128, 192, 256, 384, 512];
/// Number of sweeps after which the iteration counts as divergent.
const MOST_SWEEPS: usize = 80;
/// How far the harmonics of the law fall on the first mesh, as an exponent: of 20 to 80, this took the least time
/// over 3000 random columns; 45 and 80 took a tenth more.
const DECAY: f64 = 60.0;
/// Size of a coefficient, relative to the divergence, that counts as round-off.
const NEGLIGIBLE: f64 = 4e-16;

/// The groups A, k, b of a column as plain numbers.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guess {
    pub(super) a: f64,
    pub(super) k: f64,
    pub(super) b: f64,
}

/// r = 1 + sum over n of `cosines[n-1]` (cos n theta - 1) + `sines[n-1]` sin n theta, and its damping.
#[derive(Clone, Debug)]
pub(super) struct Orbit {
    pub(super) viscous: f64,
    pub(super) cosines: Vec<f64>,
    pub(super) sines: Vec<f64>,
}

impl Orbit {
    /// r - 1 at the angle theta_j of equal angles whose cosines are given.
    fn growth(&self, cosines: &[f64], j: usize) -> f64 {
        let mut growth = 0.0;
        for ((a, b), (cos, sin)) in self.cosines.iter().zip(&self.sines).zip(walk(cosines, j, j)) {
            growth += a * (cos - 1.0) + b * sin;
        }
        growth
    }
}

/// N equal angles.
struct Mesh {
    cos: Vec<f64>,
    sin: Vec<f64>,
    /// Column by column, the matrix from samples of a function of zero mean to its antiderivative from angle
    /// 0.
    antiderivative: Vec<f64>,
}

impl Mesh {
    fn get(which: usize) -> &'static Mesh {
        static MESHES: [OnceLock<Mesh>; SIZES.len()] = [const { OnceLock::new() }; SIZES.len()];
        MESHES[which].get_or_init(|| Mesh::new(SIZES[which]))
    }

    fn new(size: usize) -> Self {
        let angle = |j: usize| TAU * (j % size) as f64 / size as f64;
        let cos = (0..size).map(|j| angle(j).cos()).collect();
        let sin: Vec<f64> = (0..size).map(|j| angle(j).sin()).collect();
        // The interpolant of a unit sample at angle j is the sum of cos n(theta - theta_j), times 2/N, over
        // the harmonics n < N/2; the last cannot be integrated and is dropped.
        let integral: Vec<f64> = (0..size)
            .map(|d| (1..size / 2).map(|n| sin[n * d % size] / n as f64).sum::<f64>() * 2.0 / size as f64)
            .collect();
        let antiderivative = (0..size * size)
            .map(|at| (at % size, at / size))
            .map(|(i, j)| integral[(size + i - j) % size] + integral[j])
            .collect();
        Self { cos, sin, antiderivative }
    }

    fn size(&self) -> usize {
        self.cos.len()
    }
}

/// The grazing orbit of a column; `None` where the iteration does not converge, as outside the domain of the
/// polar form.
pub(super) fn approximate(groups: Guess) -> Option<Orbit> {
    let Guess { a, k, b } = groups;
    let scale = a.max(b);
    if !(scale > 0.0) {
        return Some(Orbit { viscous: 0.0, cosines: Vec::new(), sines: Vec::new() });
    }
    let q = (1.0 + 2.0 * k).sqrt();
    let viscous = 2.0 * a / (q * (1.0 + k + q)) - 2.0 * b;
    let mut orbit = Orbit { viscous, cosines: Vec::new(), sines: Vec::new() };
    // 1/(1 + k s) is analytic in the angle up to a distance of arcosh(1 + 1/k): harmonics fall that fast. N
    // angles tell less than N/2 harmonics apart.
    let harmonics = DECAY / (1.0 + 1.0 / k).acosh();
    let first = SIZES.iter().position(|&n| n as f64 >= 2.0 * harmonics).unwrap_or(SIZES.len() - 1);
    let mut settled = false;
    for which in first..SIZES.len() {
        let mesh = Mesh::get(which);
        // More angles may converge where these do not.
        let Some((growth, viscous)) = settle(groups, mesh, &orbit, scale) else { continue };
        settled = true;
        let all = transform(mesh, &growth, viscous);
        let negligible = |n: &usize| all.cosines[*n].abs().max(all.sines[*n].abs()) <= NEGLIGIBLE * scale;
        let count = all.cosines.len();
        let kept = (0..count).rev().take_while(negligible).last().unwrap_or(count);
        orbit = Orbit { viscous, cosines: all.cosines[..kept].to_vec(), sines: all.sines[..kept].to_vec() };
        // Some harmonics at the end must be small.
        if kept + 2 <= count {
            break;
        }
    }
    settled.then_some(orbit)
}

/// Sweeps from `orbit` until the changes are round-off; returns r - 1, which keeps the digits of small
/// changes, and the damping.
fn settle(groups: Guess, mesh: &Mesh, orbit: &Orbit, scale: f64) -> Option<(Vec<f64>, f64)> {
    let Guess { a, k, b } = groups;
    let size = mesh.size();
    let mut c = orbit.viscous;
    let mut growth: Vec<f64> = (0..size).map(|j| orbit.growth(&mesh.cos, j)).collect();
    let mut next = vec![0.0; size];
    let (mut g, mut by_c) = (vec![0.0; size], vec![0.0; size]);
    let mut last = f64::INFINITY;
    for _ in 0..MOST_SWEEPS {
        let (mut mean, mut mean_by_c) = (0.0, 0.0);
        for j in 0..size {
            let (cos, sin) = (mesh.cos[j], mesh.sin[j]);
            let r = 1.0 + growth[j];
            let s = 1.0 - r * cos;
            let q = 1.0 + k * s;
            let d = a / (q * q) - 2.0 * b * s - c;
            let speed = 1.0 + d * sin * cos;
            if !(speed > 0.0 && q > 0.0) {
                return None;
            }
            g[j] = d * r * sin * sin / speed;
            by_c[j] = r * sin * sin / (speed * speed);
            mean += g[j];
            mean_by_c += by_c[j];
        }
        let step = mean / mean_by_c;
        c += step;
        next.fill(0.0);
        for ((weights, g), by_c) in mesh.antiderivative.chunks_exact(size).zip(&g).zip(&by_c) {
            let g = g - step * by_c;
            for (next, weight) in next.iter_mut().zip(weights) {
                *next += weight * g;
            }
        }
        let change =
            growth.iter().zip(&next).fold(step.abs(), |most, (old, new)| most.max((new - old).abs()));
        std::mem::swap(&mut growth, &mut next);
        if !change.is_finite() {
            return None;
        }
        // Near convergence, stop when only round-off changes.
        if change <= 2.0 * f64::EPSILON * scale || (change <= 1e-12 * scale && change >= 0.5 * last) {
            return Some((growth, c));
        }
        last = change;
    }
    None
}

/// Fourier coefficients of the samples of r - 1.
fn transform(mesh: &Mesh, growth: &[f64], viscous: f64) -> Orbit {
    let size = mesh.size();
    let (mut cosines, mut sines) = (Vec::with_capacity(size / 2), Vec::with_capacity(size / 2));
    for n in 1..size / 2 {
        // r - 1 is 0 at angle 0.
        let (mut cosine, mut sine) = (0.0, 0.0);
        for (growth, (cos, sin)) in growth[1..].iter().zip(walk(&mesh.cos, n, n)) {
            cosine += growth * cos;
            sine += growth * sin;
        }
        cosines.push(cosine * 2.0 / size as f64);
        sines.push(sine * 2.0 / size as f64);
    }
    Orbit { viscous, cosines, sines }
}

//! The nodes at which the polar field is evaluated, and the quadrature over one turn.
//!
//! With xi = theta - pi in [-pi, pi], functions are interpolated by polynomials in X = sin(beta xi) / STRETCH
//! with beta = arcsin(STRETCH) / pi. This resolves oscillations almost as evenly as Fourier's angles, but
//! does not need periodicity, which only the grazing orbit has. The nodes are Gauss's for the weight sin^2
//! theta that every integrand here has: 2 M of them integrate sin^2 theta p(X) exactly for degrees below 4 M,
//! and no nodes are spent at theta = 0 and pi, where the weight vanishes.
//!
//! Nodes come in pairs pi -+ xi. Sums and differences over a pair sample an even and an odd function, whose
//! antiderivatives are odd and even, so that integration takes two matrices of a quarter of the size.

use std::f64::consts::PI;

/// The sine of beta pi, see the module. 0 gives Gauss-Legendre nodes, 1 those of trigonometric polynomials of
/// twice the period; values in between need fewer nodes.
const STRETCH: f64 = 0.85;

/// Largest number of pairs of nodes of a rung.
pub(super) const MOST_PAIRS: usize = 20;

/// Number of harmonics on which the quadrature is checked: those that dominate along an orbit near the
/// circle.
const HARMONICS: u32 = 4;

/// Weights of one pair's values in the antiderivative at another.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Weight of the sum g(early) + g(late), in the odd part of the antiderivative of sin^2 theta g.
    pub(crate) even: f64,
    /// Weight of the difference g(late) - g(early), in the even part, which vanishes at the ends of the turn.
    pub(crate) odd: f64,
}

/// Nodes, weights and matrices; the late node of each pair first.
pub(super) struct Nodes {
    /// xi of the late node of each pair, in (0, pi).
    pub(crate) xi: Vec<f64>,
    /// cos theta, the same at both nodes.
    pub(crate) cos: Vec<f64>,
    /// sin theta at the early node, minus that at the late one.
    pub(crate) sin: Vec<f64>,
    /// The integral over the turn of sin^2 theta g is the sum of these times g(early) + g(late).
    pub(crate) weight: Vec<f64>,
    /// Largest error of the quadrature over the turn for the lowest harmonics, which are not polynomials in
    /// X.
    pub(crate) harmonic_error: f64,
    /// Weights of all pairs in the antiderivative at the first pair, at the second, and so on.
    pub(crate) matrix: Vec<Entry>,
    /// Functions that the first guess combines: cos theta and cos^2 theta, even in xi, xi cos theta / pi and
    /// sin theta, odd (and given at the late node).
    pub(crate) guess: Vec<[f64; 4]>,
    /// Their antiderivatives with weight sin^2 theta at the late node, less half the integral over the turn.
    pub(crate) guess_integral: Vec<[f64; 4]>,
    /// Half the integral over the turn of cos^2 theta; those of the others vanish.
    pub(crate) guess_half: f64,
    /// Rows of a matrix from sums to the coefficients of g along the last of the even orthonormal
    /// polynomials.
    pub(crate) tail_of_sums: Vec<f64>,
    /// Rows of a matrix from differences to the coefficients along the last of the odd polynomials.
    pub(crate) tail_of_differences: Vec<f64>,
}

impl Nodes {
    /// Computes `pairs` pairs of nodes.
    pub(super) fn new(pairs: usize) -> Self {
        let size = 2 * pairs;
        let polynomials = Polynomials::new(size);
        let xi: Vec<f64> = (0..pairs).map(|i| polynomials.root(i)).collect();
        let values: Vec<Vec<f64>> = xi.iter().map(|&xi| polynomials.at(xi)).collect();
        let weight: Vec<f64> =
            values.iter().map(|p| p[..size].iter().map(|p| p * p).sum::<f64>().recip()).collect();
        // The coefficient of g along polynomial l is the sum of weight * p_l * g over the nodes.
        let row = |parity: usize, from: f64, to: f64| -> Vec<f64> {
            let integrals = polynomials.integrals(from, to);
            let entry = |j: usize| {
                let terms = (parity..size).step_by(2).rev().map(|l| values[j][l] * integrals[l]);
                weight[j] * terms.sum::<f64>()
            };
            (0..pairs).map(entry).collect()
        };
        let rows: Vec<(Vec<f64>, Vec<f64>)> =
            xi.iter().map(|&xi| (row(0, 0.0, xi), row(1, PI, xi))).collect();
        let matrix = rows
            .iter()
            .flat_map(|(even, odd)| even.iter().zip(odd).map(|(&even, &odd)| Entry { even, odd }))
            .collect();
        let guess: Vec<[f64; 4]> =
            xi.iter().map(|xi| [-xi.cos(), xi.cos() * xi.cos(), -xi.cos() * xi / PI, -xi.sin()]).collect();
        let guess_integral = rows
            .iter()
            .map(|(even, odd)| {
                std::array::from_fn(|f| {
                    let row = if f < 2 { even } else { odd };
                    row.iter().zip(&guess).map(|(entry, guess)| 2.0 * entry * guess[f]).sum()
                })
            })
            .collect();
        let guess_half = weight.iter().zip(&guess).map(|(weight, guess)| weight * guess[1]).sum();
        let harmonic_error = (1..=HARMONICS)
            .map(|l| {
                let terms = xi.iter().zip(&weight).map(|(xi, w)| 2.0 * w * (f64::from(l) * xi).cos());
                let exact = if l == 2 { -0.5 * PI } else { 0.0 };
                (terms.sum::<f64>() - exact).abs()
            })
            .fold(0.0, f64::max);
        let tail = |degrees: std::ops::Range<usize>| -> Vec<f64> {
            degrees
                .step_by(2)
                .flat_map(|l| (0..pairs).map(move |i| (l, i)))
                .map(|(l, i)| weight[i] * values[i][l])
                .collect()
        };
        let from = size - Self::tail(pairs);
        let (tail_of_sums, tail_of_differences) = (tail(from..size), tail(from + 1..size));
        let (cos, sin) = xi.iter().map(|xi| (-xi.cos(), xi.sin())).unzip();
        Self {
            xi,
            cos,
            sin,
            weight,
            harmonic_error,
            matrix,
            guess,
            guess_integral,
            guess_half,
            tail_of_sums,
            tail_of_differences,
        }
    }

    /// Number of coefficients that measure the resolution: enough that not all vanish by chance, and a
    /// quarter of all on finer nodes, whose coefficients oscillate slowly.
    fn tail(pairs: usize) -> usize {
        if pairs <= 10 { 4 } else { 2 * (pairs / 4) }
    }

    #[inline(always)]
    pub(super) fn pairs(&self) -> usize {
        self.xi.len()
    }
}

/// The orthonormal polynomials in X with weight sin^2 xi d xi on [-pi, pi]:
/// X p_j = b_{j+1} p_{j+1} + b_j p_{j-1}.
struct Polynomials {
    /// b_0 = 0 to b_size.
    b: Vec<f64>,
    /// Nodes and weights on [-1, 1] of a rule that integrates all products to rounding.
    rule: Vec<(f64, f64)>,
}

impl Polynomials {
    /// Polynomials up to degree `size`, by Stieltjes's procedure.
    fn new(size: usize) -> Self {
        // The integrands are entire functions of xi of type (2 size + 1) beta + 2 < size + 2.
        let rule = fejer(2 * size + 64);
        let points: Vec<(f64, f64)> =
            rule.iter().map(|&(t, w)| (argument(PI * t), w * PI * (PI * t).sin().powi(2))).collect();
        let mut b = vec![0.0];
        let mut last = vec![0.0; points.len()];
        let mut this = vec![constant(); points.len()];
        for j in 0..size {
            let mut next: Vec<f64> =
                (0..points.len()).map(|i| points[i].0 * this[i] - b[j] * last[i]).collect();
            let norm = next.iter().zip(&points).map(|(p, (_, w))| w * p * p).sum::<f64>().sqrt();
            next.iter_mut().for_each(|p| *p /= norm);
            b.push(norm);
            (last, this) = (this, next);
        }
        Self { b, rule }
    }

    /// The values of all polynomials at xi.
    fn at(&self, xi: f64) -> Vec<f64> {
        let x = argument(xi);
        let mut p = vec![constant()];
        for j in 1..self.b.len() {
            let before = if j == 1 { 0.0 } else { self.b[j - 1] * p[j - 2] };
            p.push((x * p[j - 1] - before) / self.b[j]);
        }
        p
    }

    /// The i-th positive root of the last polynomial, smallest first. The number of roots greater than xi is
    /// the number of sign changes of the sequence of polynomials at xi.
    fn root(&self, i: usize) -> f64 {
        let beyond = self.b.len() / 2 - i;
        let (mut low, mut high) = (0.0, PI);
        loop {
            let middle = 0.5 * (low + high);
            if middle <= low || middle >= high {
                return middle;
            }
            let changes = self.at(middle).windows(2).filter(|p| (p[0] < 0.0) != (p[1] < 0.0)).count();
            if changes >= beyond { low = middle } else { high = middle }
        }
    }

    /// Integrals of sin^2 xi times each polynomial.
    fn integrals(&self, from: f64, to: f64) -> Vec<f64> {
        let mut sums = vec![0.0; self.b.len()];
        for &(t, w) in &self.rule {
            let xi = 0.5 * ((to + from) + (to - from) * t);
            let w = 0.5 * w * (to - from) * xi.sin().powi(2);
            for (sum, p) in sums.iter_mut().zip(self.at(xi)) {
                *sum += w * p;
            }
        }
        sums
    }
}

fn argument(xi: f64) -> f64 {
    (STRETCH.asin() / PI * xi).sin() / STRETCH
}

/// The polynomial of degree 0: the weight integrates to pi.
fn constant() -> f64 {
    PI.sqrt().recip()
}

/// Fejer's first rule on [-1, 1]: nodes and weights.
fn fejer(size: usize) -> Vec<(f64, f64)> {
    (0..size)
        .map(|i| {
            let angle = (i as f64 + 0.5) * PI / size as f64;
            let terms = (1..=size / 2).rev().map(|j| (2.0 * j as f64 * angle).cos() / (4 * j * j - 1) as f64);
            (angle.cos(), 2.0 / size as f64 * (1.0 - 2.0 * terms.sum::<f64>()))
        })
        .collect()
}

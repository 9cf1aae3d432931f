//! The universal surface C*(A, k, b): a table of the critical damping of every Stribeck oscillator.
//!
//! By scaling (theory, "Scaling") the six-parameter boundary of stick-slip is one surface over three numbers.
//! It lies just below the harmonic-balance surface C_HB, so the small difference is tabulated,
//!
//! ```text
//! C* = C_HB(A, k, b) - A^3 R(A, k, y),      y = b / b0(A, k),      C_HB(A, k, b0) = 0,
//! ```
//!
//! with R a tensor Chebyshev interpolant over 0 <= A <= A_max, 0 <= k <= k_max, 0 <= y <= 1 (beyond y = 1
//! there is no critical damping c >= 0). R is analytic in the box, so about a thousand coefficients reach the
//! accuracy of the solver that samples it. The table is computed on first use, in milliseconds.
//!
//! A value takes 0.2 microseconds, a twentieth of the solver's.
//!
//! Guarantee: numerical. Each box has a bound on |error of R|, twice the largest error found when the test
//! `bounds_hold` compared it with the solver on random points of the box.

use std::sync::LazyLock;

use super::critical::{CriticalDamping, critical_dampings};
use crate::friction::{Column, Law};
use crate::point::{LawParameters, Point, ScaledGroups};

/// Number of Chebyshev polynomials in y.
const ALONG_Y: usize = 8;

/// Extent, resolution and accuracy of an interpolant.
struct Extent {
    a_max: f64,
    k_max: f64,
    /// Number of Chebyshev polynomials in A and in k.
    size: [usize; 2],
    /// Bound on the error of R.
    bound: f64,
}

/// The extents of the tables, from small and accurate to large and less accurate.
const EXTENTS: [Extent; 2] = [
    Extent { a_max: 0.2, k_max: 0.3, size: [8, 12], bound: 1e-10 },
    Extent { a_max: 0.5, k_max: 1.0, size: [10, 16], bound: 1e-8 },
];

/// Round-off of C* in units of A: a sum of up to 1280 terms of the size of C_HB - C*, which is far below A.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SurfacePoint {
    /// C* = eps c*.
    pub(crate) viscous: f64,
    /// Bound on its absolute error.
    pub(crate) error: f64,
}

/// An interpolant of R over one box.
struct Interpolant {
    extent: &'static Extent,
    /// Coefficients, A slowest, y fastest.
    coefficients: Vec<[f64; ALONG_Y]>,
}

/// C_HB at b = 0; b0 is half of it.
fn harmonic_balance(a: f64, k: f64) -> f64 {
    let q = (1.0 + 2.0 * k).sqrt();
    2.0 * a / (q * (1.0 + k + q))
}

/// T_0(x), T_1(x), ... for x in [-1, 1].
fn chebyshev(x: f64, values: &mut [f64]) {
    let (mut previous, mut current) = (x, 1.0);
    for value in values {
        *value = current;
        (previous, current) = (current, 2.0 * x * current - previous);
    }
}

/// Chebyshev nodes of the first kind, `size` of them on [-1, 1].
fn nodes(size: usize) -> impl Iterator<Item = f64> {
    (0..size).map(move |i| (std::f64::consts::PI * (i as f64 + 0.5) / size as f64).cos())
}

/// Replaces samples at the Chebyshev nodes by coefficients, along an axis of length `size` whose elements
/// are `stride` apart.
fn to_coefficients(data: &mut [f64], size: usize, stride: usize) {
    let mut basis = vec![0.0; size];
    for block in data.chunks_exact_mut(size * stride) {
        for offset in 0..stride {
            let mut sums = vec![0.0; size];
            for (i, node) in nodes(size).enumerate() {
                chebyshev(node, &mut basis);
                for (sum, t) in sums.iter_mut().zip(&basis) {
                    *sum += block[offset + i * stride] * t;
                }
            }
            for (j, sum) in sums.into_iter().enumerate() {
                let norm = if j == 0 { 1.0 } else { 2.0 };
                block[offset + j * stride] = norm * sum / size as f64;
            }
        }
    }
}

impl Interpolant {
    fn new(extent: &'static Extent) -> Self {
        let [along_a, along_k] = extent.size;
        let onto = |x: f64, max: f64| 0.5 * (1.0 + x) * max;
        let mut groups = Vec::with_capacity(along_a * along_k * ALONG_Y);
        for a in nodes(along_a) {
            for k in nodes(along_k) {
                for y in nodes(ALONG_Y) {
                    let (a, k) = (onto(a, extent.a_max), onto(k, extent.k_max));
                    let b = onto(y, 0.5 * harmonic_balance(a, k));
                    groups.push(ScaledGroups { a, k, b, c: 0.0 });
                }
            }
        }
        let columns: Vec<Column> = groups.iter().map(oscillators_like).collect();
        let mut samples: Vec<f64> = critical_dampings(&columns, f64::EPSILON)
            .into_iter()
            .zip(&groups)
            .map(|(critical, g)| {
                let Ok(critical) = critical else {
                    unreachable!("the divergence stays far below 2 in the box of the table")
                };
                (harmonic_balance(g.a, g.k) - 2.0 * g.b - critical.c) / (g.a * g.a * g.a)
            })
            .collect();
        to_coefficients(&mut samples, ALONG_Y, 1);
        to_coefficients(&mut samples, along_k, ALONG_Y);
        to_coefficients(&mut samples, along_a, along_k * ALONG_Y);
        let coefficients = samples.chunks_exact(ALONG_Y).map(|row| std::array::from_fn(|i| row[i])).collect();
        Self { extent, coefficients }
    }

    /// R at a point of the box.
    fn value(&self, a: f64, k: f64, y: f64) -> f64 {
        let [along_a, along_k] = self.extent.size;
        let (mut in_a, mut in_k, mut in_y) = ([0.0; 16], [0.0; 16], [0.0; ALONG_Y]);
        chebyshev(2.0 * a / self.extent.a_max - 1.0, &mut in_a[..along_a]);
        chebyshev(2.0 * k / self.extent.k_max - 1.0, &mut in_k[..along_k]);
        chebyshev(2.0 * y - 1.0, &mut in_y);
        let mut total = [0.0; ALONG_Y];
        for (rows, t_a) in self.coefficients.chunks_exact(along_k).zip(&in_a) {
            for (row, t_k) in rows.iter().zip(&in_k) {
                let weight = t_a * t_k;
                for (sum, coefficient) in total.iter_mut().zip(row) {
                    *sum += weight * coefficient;
                }
            }
        }
        total.iter().zip(&in_y).map(|(sum, t)| sum * t).sum()
    }
}

/// A column with the given groups: eps = 1, alpha = 0.
fn oscillators_like(groups: &ScaledGroups) -> Column {
    let belt_speed = groups.k / groups.a;
    let law = LawParameters::new(&[0.0, groups.b / belt_speed, groups.a]);
    Law::Stribeck.column(&Point { epsilon: 1.0, law, belt_speed, damping: 0.0 })
}

/// C* at the groups (A, k, b), for any C; `None` outside the tabulated boxes.
pub(crate) fn lookup(groups: &ScaledGroups) -> Option<SurfacePoint> {
    static TABLES: LazyLock<[Interpolant; EXTENTS.len()]> =
        LazyLock::new(|| std::array::from_fn(|i| Interpolant::new(&EXTENTS[i])));
    let &ScaledGroups { a, k, b, .. } = groups;
    let number = EXTENTS.iter().position(|extent| a <= extent.a_max && k <= extent.k_max)?;
    let without_b = harmonic_balance(a, k);
    let y = 2.0 * b / without_b;
    // A = 0 has no boundary; the comparison also refuses NaN.
    if !(a > 0.0 && y <= 1.0) {
        return None;
    }
    let cube = a * a * a;
    Some(SurfacePoint {
        viscous: without_b - 2.0 * b - cube * TABLES[number].value(a, k, y),
        error: EXTENTS[number].bound * cube + ROUND_OFF * a,
    })
}

/// c* of a column from the table: its value and error, in units of c; `None` outside the tabulated boxes.
#[must_use]
pub fn critical_damping(column: &Column) -> Option<CriticalDamping> {
    let law = column.curve.stribeck()?;
    let SurfacePoint { viscous, error } = lookup(&law.scaled(column.belt_speed, 0.0))?;
    Some(CriticalDamping { c: viscous / column.epsilon, error: error / column.epsilon, rhs: 0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers in [0, 1) from a Weyl sequence: fills a box evenly and reproducibly.
    fn spread(i: usize, axis: usize) -> f64 {
        const RATIOS: [f64; 3] = [0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_2];
        (0.5 + (i + 1) as f64 * RATIOS[axis]).fract()
    }

    #[test]
    fn bounds_hold() {
        for extent in &EXTENTS {
            let groups: Vec<ScaledGroups> = (0..4000)
                .map(|i| {
                    let (a, k) =
                        (extent.a_max * spread(i, 0).max(1e-3), extent.k_max * spread(i, 1).max(1e-6));
                    ScaledGroups { a, k, b: 0.5 * spread(i, 2) * harmonic_balance(a, k), c: 0.0 }
                })
                .collect();
            let columns: Vec<Column> = groups.iter().map(oscillators_like).collect();
            let mut worst: f64 = 0.0;
            for (groups, solved) in groups.iter().zip(critical_dampings(&columns, f64::EPSILON)) {
                let (found, solved) = (lookup(groups).unwrap(), solved.unwrap());
                let error = (found.viscous - solved.c).abs();
                assert!(error <= found.error + solved.error, "{groups:?} {found:?} {solved:?}");
                worst = worst.max((error - solved.error).max(0.0) / groups.a.powi(3));
            }
            assert!(2.0 * worst <= extent.bound, "{worst:e}");
        }
    }

    #[test]
    fn outside_is_none() {
        for (a, k, b) in
            [(0.0, 0.1, 0.0), (0.6, 0.1, 0.0), (0.1, 1.1, 0.0), (0.1, 0.1, 0.2), (f64::NAN, 0.1, 0.0)]
        {
            assert_eq!(lookup(&ScaledGroups { a, k, b, c: 0.0 }), None, "{a} {k} {b}");
        }
    }
}

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
//! Guarantee: numerical. Each box has an estimate of |error of R|: twice the largest error found when the
//! test `errors_hold_at_samples` compared it with the solver at some thousand points of the box. It is
//! sampled, and no bound.

use std::sync::LazyLock;

use super::critical::{CriticalDamping, critical_dampings};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::{LawParameters, ScaledGroups};
use slipmap_numbers::chebyshev::{Side, Tensor};

/// Number of Chebyshev polynomials in y.
const ALONG_Y: usize = 8;

/// Extent, resolution and accuracy of an interpolant.
struct Extent {
    a_max: f64,
    k_max: f64,
    /// Number of Chebyshev polynomials in A and in k.
    size: [usize; 2],
    /// Estimate of the error of R, from samples.
    error: f64,
}

/// The extents of the tables, from small and accurate to large and less accurate.
const EXTENTS: [Extent; 2] = [
    Extent { a_max: 0.2, k_max: 0.3, size: [8, 12], error: 1e-10 },
    Extent { a_max: 0.5, k_max: 1.0, size: [10, 16], error: 1e-8 },
];

/// Round-off of C* in units of A: a sum of up to 1280 terms of the size of C_HB - C*, which is far below A.
const ROUND_OFF: f64 = 8.0 * f64::EPSILON;

/// C_HB at b = 0; b0 is half of it.
fn harmonic_balance(a: f64, k: f64) -> f64 {
    let q = (1.0 + 2.0 * k).sqrt();
    2.0 * a / (q * (1.0 + k + q))
}

impl Extent {
    /// The interpolant of R over A, k and y.
    fn interpolant(&self) -> Tensor {
        let [along_a, along_k] = self.size;
        let side = |most: f64, count: usize| Side { range: [0.0, most], count };
        let sides = [side(self.a_max, along_a), side(self.k_max, along_k), side(1.0, ALONG_Y)];
        let groups = |point: Vec<f64>| {
            let (a, k) = (point[0], point[1]);
            ScaledGroups { a, k, b: 0.5 * point[2] * harmonic_balance(a, k), c: 0.0 }
        };
        let groups: Vec<ScaledGroups> = Tensor::points(&sides).into_iter().map(groups).collect();
        let columns: Vec<Column> = groups.iter().map(oscillators_like).collect();
        let gap = |(critical, g): (Result<CriticalDamping, _>, &ScaledGroups)| {
            let Ok(critical) = critical else {
                unreachable!("the divergence stays far below 2 in the box of the table")
            };
            (harmonic_balance(g.a, g.k) - 2.0 * g.b - critical.c) / (g.a * g.a * g.a)
        };
        let critical = critical_dampings(&columns, f64::EPSILON).into_iter();
        Tensor::through(&sides, critical.zip(&groups).map(gap).collect())
    }
}

/// A column with the given groups: eps = 1, alpha = 0.
fn oscillators_like(groups: &ScaledGroups) -> Column {
    let belt_speed = groups.k / groups.a;
    let law = LawParameters::new(&[0.0, groups.b / belt_speed, groups.a]);
    Column { curve: Law::Stribeck.curve(1.0, &law), epsilon: 1.0, belt_speed, unit: 1.0 }
}

/// C* at the groups (A, k, b), for any C, and an estimate of its error; `None` outside the tabulated boxes.
fn lookup(groups: &ScaledGroups) -> Option<[f64; 2]> {
    static TABLES: LazyLock<[Tensor; EXTENTS.len()]> =
        LazyLock::new(|| EXTENTS.each_ref().map(Extent::interpolant));
    let &ScaledGroups { a, k, b, .. } = groups;
    let number = EXTENTS.iter().position(|extent| a <= extent.a_max && k <= extent.k_max)?;
    let without_b = harmonic_balance(a, k);
    let y = 2.0 * b / without_b;
    // A = 0 has no boundary; the comparison also refuses NaN.
    if !(a > 0.0 && y <= 1.0) {
        return None;
    }
    let cube = a * a * a;
    let viscous = without_b - 2.0 * b - cube * TABLES[number].at(&[a, k, y]);
    Some([viscous, EXTENTS[number].error * cube + ROUND_OFF * a])
}

/// c* of a column from the table: its value and error, in units of c; `None` outside the tabulated boxes.
#[must_use]
pub fn critical_damping(column: &Column) -> Option<CriticalDamping> {
    let law = column.curve.stribeck()?;
    let [viscous, error] = lookup(&law.scaled(column.belt_speed, 0.0))?;
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
    fn errors_hold_at_samples() {
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
                let error = (found[0] - solved.c).abs();
                assert!(error <= found[1] + solved.error, "{groups:?} {found:?} {solved:?}");
                worst = worst.max((error - solved.error).max(0.0) / groups.a.powi(3));
            }
            assert!(2.0 * worst <= extent.error, "{worst:e}");
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

//! Sums and products that vectorise over the nodes of an element.

use slipmap_model::friction::Polynomial;
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::gauss::MOST;

/// Sine and cosine of the sum of two angles.
#[inline(always)]
pub(super) fn turned([sin, cos]: [f64; 2], [sin_by, cos_by]: [f64; 2]) -> [f64; 2] {
    [sin * cos_by + cos * sin_by, cos * cos_by - sin * sin_by]
}

/// w and w' by the polynomial of a piece, at places x within it.
#[inline(always)]
pub(super) fn weakening<const N: usize>(piece: &Polynomial, x: &[f64; N]) -> [[f64; N]; 2] {
    let [mut value, mut slope] = [[0.0; N]; 2];
    for c in piece.c.iter().rev() {
        for j in 0..N {
            slope[j] = x[j].times_plus(slope[j], value[j]);
            value[j] = x[j].times_plus(value[j], *c);
        }
    }
    [value, slope.map(|slope| slope * piece.scale)]
}

/// `matrix` applied to `values`.
#[inline(always)]
pub(super) fn apply<const N: usize>(matrix: &[[f64; N]; N], values: &[f64; N]) -> [f64; N] {
    let mut sum = [0.0; N];
    for (row, value) in matrix.iter().zip(values) {
        for j in 0..N {
            sum[j] = row[j].times_plus(*value, sum[j]);
        }
    }
    sum
}

#[inline(always)]
pub(super) fn dot<const N: usize>(weights: &[f64; N], values: &[f64; N]) -> f64 {
    let mut terms = [0.0; N];
    for j in 0..N {
        terms[j] = weights[j] * values[j];
    }
    terms.iter().sum()
}

/// The first N values.
#[inline(always)]
pub(super) fn first<const N: usize>(values: &[f64; MOST]) -> [f64; N] {
    std::array::from_fn(|j| values[j])
}

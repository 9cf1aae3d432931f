//! Elementary functions and sums that vectorise over the nodes of an element.

use crate::polar::INVERSE_FACTORIALS;
use slipmap_model::friction::Polynomial;
use slipmap_numbers::gauss::MOST;

/// sin(z) and cos(z) for |z| <= pi / 4, by the Taylor series up to z^17 / 17! and z^16 / 16!, of which
/// Horner's rule takes the coefficients 1 / n! from the last one to the first.
#[inline(always)]
pub(crate) fn sin_cos(z: f64) -> [f64; 2] {
    let y = -z * z;
    let [mut sin, mut cos] = [INVERSE_FACTORIALS[17], INVERSE_FACTORIALS[16]];
    for n in (0..8).rev() {
        sin = y.mul_add(sin, INVERSE_FACTORIALS[2 * n + 1]);
        cos = y.mul_add(cos, INVERSE_FACTORIALS[2 * n]);
    }
    [z * sin, cos]
}

/// sin(z) and cos(z) for z from 0 to 2 pi and a few roundings beyond, to about a unit in the last place.
#[inline(always)]
pub(crate) fn sin_cos_of_turn(z: f64) -> [f64; 2] {
    // pi / 2 as a sum of two numbers, of which the first has zeros at its end.
    const QUARTER: [f64; 2] = [1.570_796_251_296_997, 7.549_789_415_861_596e-8];
    let quarters = (z * std::f64::consts::FRAC_2_PI + 0.5).floor();
    let [sin, cos] = sin_cos(quarters.mul_add(-QUARTER[1], quarters.mul_add(-QUARTER[0], z)));
    match quarters as i32 & 3 {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

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
            slope[j] = x[j].mul_add(slope[j], value[j]);
            value[j] = x[j].mul_add(value[j], *c);
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
            sum[j] = row[j].mul_add(*value, sum[j]);
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

//! Interpolation by polynomials through the Chebyshev points cos(pi i / size), i = 0 ..= size, of [-1, 1].

use std::f64::consts::PI;

/// cos(pi i / size), exact at the ends and in the middle. Points of half as many intervals are the same
/// numbers.
pub(crate) fn node(i: usize, size: usize) -> f64 {
    (PI * (size as f64 - 2.0 * i as f64) / (2.0 * size as f64)).sin()
}

fn half_at_ends(i: usize, size: usize) -> f64 {
    if i == 0 || i == size { 0.5 } else { 1.0 }
}

/// Chebyshev coefficients of the polynomial through `values` at the points.
pub(crate) fn coefficients(values: &[f64]) -> Vec<f64> {
    Transform::new(values.len() - 1).coefficients(values).collect()
}

/// Coefficients of many polynomials through values at the same points.
#[derive(Debug)]
pub(crate) struct Transform {
    /// One row for each coefficient.
    rows: Vec<f64>,
    count: usize,
}

impl Transform {
    pub(crate) fn new(size: usize) -> Self {
        let cosines: Vec<f64> = (0..2 * size).map(|i| node(i, size)).collect();
        let row = |k: usize| {
            let scale = half_at_ends(k, size) * 2.0 / size as f64;
            // cos(pi i k / size), reduced to one period.
            let cosines = &cosines;
            (0..=size).map(move |i| scale * half_at_ends(i, size) * cosines[(i * k) % (2 * size)])
        };
        Self { rows: (0..=size).flat_map(row).collect(), count: size + 1 }
    }

    /// The coefficients, by increasing degree.
    pub(crate) fn coefficients(&self, values: &[f64]) -> impl Iterator<Item = f64> {
        let sum = move |row: &[f64]| row.iter().zip(values).map(|(weight, value)| weight * value).sum();
        self.rows.chunks_exact(self.count).map(sum)
    }
}

/// The sum of the series at x, by Clenshaw's recurrence.
pub(crate) fn sum(series: &[f64], x: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for &c in series[1..].iter().rev() {
        (b1, b2) = (c + 2.0 * x * b1 - b2, b1);
    }
    series[0] + x * b1 - b2
}

/// The sums of the series at many places, as [`sum`]; several at a time take little longer than one.
pub(crate) fn sums(series: &[f64], places: &[f64]) -> Vec<f64> {
    const TOGETHER: usize = 8;
    let mut sums = Vec::with_capacity(places.len());
    for places in places.chunks(TOGETHER) {
        let mut x = [0.0; TOGETHER];
        x[..places.len()].copy_from_slice(places);
        let [mut b1, mut b2] = [[0.0; TOGETHER]; 2];
        for &c in series[1..].iter().rev() {
            for j in 0..TOGETHER {
                (b1[j], b2[j]) = (c + 2.0 * x[j] * b1[j] - b2[j], b1[j]);
            }
        }
        sums.extend((0..places.len()).map(|j| series[0] + x[j] * b1[j] - b2[j]));
    }
    sums
}

/// The weights of the values at the points in the value of the polynomial at x: the barycentric formula.
pub(crate) fn weights(size: usize, x: f64) -> Vec<f64> {
    let distances: Vec<f64> = (0..=size).map(|i| x - node(i, size)).collect();
    if let Some(at) = distances.iter().position(|distance| *distance == 0.0) {
        return (0..=size).map(|i| if i == at { 1.0 } else { 0.0 }).collect();
    }
    let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let terms: Vec<f64> = distances
        .iter()
        .enumerate()
        .map(|(i, distance)| sign(i) * half_at_ends(i, size) / distance)
        .collect();
    let whole: f64 = terms.iter().sum();
    terms.into_iter().map(|term| term / whole).collect()
}

/// Bound of the largest factor by which errors of the values grow, the Lebesgue constant of the points.
pub(crate) fn lebesgue(size: usize) -> f64 {
    1.0 + 2.0 / PI * (size as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_their_own_interpolants() {
        let f = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x * x;
        for size in [4, 8, 16] {
            let values: Vec<f64> = (0..=size).map(|i| f(node(i, size))).collect();
            let series = coefficients(&values);
            for x in [-1.0, -0.3, 0.2, node(1, size), 1.0] {
                let weighted: f64 =
                    weights(size, x).iter().zip(&values).map(|(weight, value)| weight * value).sum();
                assert!((sum(&series, x) - f(x)).abs() < 1e-14, "{size} {x}");
                assert!((weighted - f(x)).abs() < 1e-14, "{size} {x}");
            }
            let places: Vec<f64> = (0..21).map(|i| -1.0 + 0.1 * f64::from(i)).collect();
            let one_by_one: Vec<f64> = places.iter().map(|x| sum(&series, *x)).collect();
            assert_eq!(sums(&series, &places), one_by_one);
            assert!(series[4..].iter().all(|c| c.abs() < 1e-15), "{series:?}");
        }
    }
}

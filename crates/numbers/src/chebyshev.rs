//! Interpolation by polynomials through the Chebyshev points cos(pi i / size), i = 0 ..= size, which include the ends.

use std::f64::consts::PI;
use std::sync::OnceLock;

use super::jet::Real;

/// cos(pi i / size), exact at the ends and in the middle. The points of half as many intervals are among
/// them, bit for bit.
pub fn node(i: usize, size: usize) -> f64 {
    (PI * (size as f64 - 2.0 * i as f64) / (2.0 * size as f64)).sin()
}

/// The angle of point `j` of as many as `count` of the first kind, which do not include the ends.
fn angle(j: usize, count: usize) -> f64 {
    PI * (j as f64 + 0.5) / count as f64
}

/// The points of the first kind.
pub fn points<const N: usize>() -> [f64; N] {
    std::array::from_fn(|j| angle(j, N).cos())
}

/// The weights of values at the points of the first kind in each Chebyshev coefficient.
pub fn transform<const N: usize>() -> [[f64; N]; N] {
    std::array::from_fn(|k| {
        let weight = if k == 0 { 1.0 } else { 2.0 } / N as f64;
        std::array::from_fn(|j| weight * (k as f64 * angle(j, N)).cos())
    })
}

fn half_at_ends(i: usize, size: usize) -> f64 {
    if i == 0 || i == size { 0.5 } else { 1.0 }
}

/// One `T` for each power of two, made on first use.
type ForPowers<T> = [OnceLock<T>; usize::BITS as usize];

/// Chebyshev coefficients of the polynomial through `values` at the points of a power of two of intervals.
pub fn coefficients(values: &[f64]) -> Vec<f64> {
    static ALL: ForPowers<Transform> = [const { OnceLock::new() }; usize::BITS as usize];
    let size = values.len() - 1;
    assert!(size.is_power_of_two());
    ALL[size.ilog2() as usize].get_or_init(|| Transform::new(size)).coefficients(values).collect()
}

/// Coefficients of many polynomials through values at the same points.
#[derive(Debug)]
pub struct Transform {
    /// One row for each coefficient.
    rows: Vec<f64>,
    count: usize,
}

impl Transform {
    /// The transform for `size` intervals between Chebyshev points.
    pub fn new(size: usize) -> Self {
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
    pub fn coefficients(&self, values: &[f64]) -> impl Iterator<Item = f64> {
        let sum = move |row: &[f64]| row.iter().zip(values).map(|(weight, value)| weight * value).sum();
        self.rows.chunks_exact(self.count).map(sum)
    }
}

/// The sum of the series at x, by Clenshaw's recurrence.
pub fn sum<T: Real>(series: &[f64], x: T) -> T {
    let constant = T::constant;
    let [mut b1, mut b2] = [constant(0.0); 2];
    for &c in series[1..].iter().rev() {
        (b1, b2) = (constant(c) + constant(2.0) * x * b1 - b2, b1);
    }
    constant(series[0]) + x * b1 - b2
}

/// The sums of the series at many places, as [`sum`]; several at a time take little longer than one.
pub fn sums(series: &[f64], places: &[f64]) -> Vec<f64> {
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
pub fn weights(size: usize, x: f64) -> Vec<f64> {
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

/// The values half-way, in angle, between the points, by the polynomial with given values at all points and
/// given slopes at all but the last, -1. Interpolation through the resulting values at all 2 `size` + 1
/// points amplifies errors of the data no more than interpolation of data at those points.
#[derive(Debug)]
pub struct Between {
    /// The weights of the values and those of the slopes, for each place.
    rows: Vec<[Vec<f64>; 2]>,
}

impl Between {
    /// The table for `size` intervals, a power of two; computed once.
    pub fn of(size: usize) -> &'static Self {
        static ALL: ForPowers<Between> = [const { OnceLock::new() }; usize::BITS as usize];
        assert!(size.is_power_of_two());
        ALL[size.ilog2() as usize].get_or_init(|| Self::new(size))
    }

    fn new(size: usize) -> Self {
        let points: Vec<f64> = (0..size).map(|k| node(k, size)).collect();
        let others =
            |k: usize| points.iter().enumerate().filter(move |(j, _)| *j != k).map(|(_, other)| *other);
        let row = |i: usize| {
            let x = node(2 * i + 1, 2 * size);
            let basis = |(k, &point): (usize, &f64)| {
                let lagrange: f64 = others(k).map(|other| (x - other) / (point - other)).product();
                let bend: f64 = others(k).map(|other| 1.0 / (point - other)).sum();
                let (square, last) = (lagrange * lagrange * (1.0 + x) / (1.0 + point), 1.0 / (1.0 + point));
                (square * (1.0 - (x - point) * (2.0 * bend + last)), (x - point) * square)
            };
            let (mut values, slopes): (Vec<f64>, Vec<f64>) = points.iter().enumerate().map(basis).unzip();
            values.push(points.iter().map(|point| ((x - point) / (1.0 + point)).powi(2)).product());
            [values, slopes]
        };
        Self { rows: (0..size).map(row).collect() }
    }

    /// The value half-way between points `i` and `i` + 1.
    pub fn value(&self, i: usize, values: &[f64], slopes: &[f64]) -> f64 {
        let dot = |weights: &[f64], numbers: &[f64]| -> f64 {
            weights.iter().zip(numbers).map(|(weight, number)| weight * number).sum()
        };
        let [of_values, of_slopes] = &self.rows[i];
        dot(of_values, values) + dot(of_slopes, slopes)
    }

    /// The largest error of a value due to `errors` of the slopes.
    pub fn error(&self, errors: &[f64]) -> f64 {
        let of_row =
            |[_, weights]: &[Vec<f64>; 2]| weights.iter().zip(errors).map(|(w, error)| w.abs() * error).sum();
        self.rows.iter().map(of_row).fold(0.0, f64::max)
    }
}

/// Bound of the largest factor by which errors of the values grow, the Lebesgue constant of the points.
pub fn lebesgue(size: usize) -> f64 {
    1.0 + 2.0 / PI * (size as f64).ln()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_between_the_points_follow_from_slopes() {
        // A polynomial of degree 2 size, by its slopes at all points but the last.
        for size in [4_usize, 8, 32] {
            let of = |x: f64| sum(&vec![1.0; 2 * size + 1], x);
            let slope = |x: f64| (of(x + 1e-6) - of(x - 1e-6)) / 2e-6;
            let points: Vec<f64> = (0..=size).map(|i| node(i, size)).collect();
            let values: Vec<f64> = points.iter().map(|x| of(*x)).collect();
            let slopes: Vec<f64> = points[..size].iter().map(|x| slope(*x)).collect();
            let between = Between::of(size);
            for i in 0..size {
                let exact = of(node(2 * i + 1, 2 * size));
                assert!(
                    (between.value(i, &values, &slopes) - exact).abs() < 1e-6 * size as f64,
                    "{size} {i}"
                );
            }
            // Errors of values grow no more than by interpolation at all points.
            let growth = |[values, _]: &[Vec<f64>; 2]| values.iter().map(|w| w.abs()).sum();
            assert!(between.rows.iter().map(growth).fold(0.0, f64::max) < lebesgue(2 * size));
            assert!(between.error(&vec![1.0; size]) < 0.5);
        }
    }
}

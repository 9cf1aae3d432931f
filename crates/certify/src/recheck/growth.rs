//! The least growth h of a barrier: a lower bound of H over cells.

use super::ball::Ball;
use super::{MODES, products, scale};
use crate::validated::tile::Tile;

/// Cells of the angle, a multiple of 4.
const ANGLES: usize = 512;
/// Cells of A, k and b.
const PARTS: [usize; 3] = [4, 8, 2];

/// A cell of the box.
struct Cell {
    a: Ball,
    k: Ball,
    b: Ball,
    /// The value of every mode.
    weights: Vec<Ball>,
}

/// Lower bound of H for |t| <= `tube` over all angles and the whole box; `None` if it is not positive, or if
/// the curve is not a barrier.
pub(super) fn least(tile: &Tile, tube: f64) -> Option<f64> {
    let cells = cells(tile);
    // Sizes of r0' and r0'': sums of |coefficients| times orders.
    let sums = |power: i32| -> f64 {
        let rows = tile.cosines.iter().zip(&tile.sines).enumerate();
        let size = |row: &[f64]| row.iter().map(|c| c.abs()).sum::<f64>();
        rows.map(|(n, (a, b))| ((n + 1) as f64).powi(power) * (size(a) + size(b))).sum::<f64>() * (1.0 + 1e-9)
    };
    let (first, second) = (sums(1), sums(2));
    // Half a cell. The points below are at equal angles up to some units of rounding, as their distances
    // prove.
    let half = std::f64::consts::PI / ANGLES as f64 * (1.0 + 1e-5);
    let points = points()?;
    let mut least = f64::INFINITY;
    for (cos, sin) in points {
        // Values at the middle of the cell by modes, from the powers of e^(i theta). Each power multiplies
        // the error of the last by 1 + 1e-15 and adds 1e-15: after at most 512 powers it is below 1e-12.
        let (mut r, mut slope) = ([0.0; MODES], [0.0; MODES]);
        let (mut c, mut s) = (1.0, 0.0);
        for (n, (a, b)) in tile.cosines.iter().zip(&tile.sines).enumerate() {
            (c, s) = (c * cos - s * sin, s * cos + c * sin);
            let order = (n + 1) as f64;
            for mode in 0..MODES {
                r[mode] += a[mode] * (c - 1.0) + b[mode] * s;
                slope[mode] += order * (b[mode] * c - a[mode] * s);
            }
        }
        // Values elsewhere in the cell differ by at most a slope times half a cell; 1e-10 of the sizes covers
        // the errors of powers and sums.
        let (r_off, slope_off) = (first * (half + 1e-10), second * (half + 1e-10));
        let around = |middle: f64| Ball::new(middle, half + 1e-10);
        let (cos, product, square) = (around(cos), around(sin * cos), around(sin * sin));
        for cell in &cells {
            let sum = |values: &[f64], off: f64| {
                let terms = values.iter().zip(&cell.weights);
                terms.fold(Ball::new(0.0, off), |sum, (value, weight)| sum + *weight * *value)
            };
            let (r0, slope) = (sum(&r, r_off) + Ball::exact(1.0), sum(&slope, slope_off));
            let damping = sum(&tile.viscous, tube);
            let here = growth(cell, r0, slope, damping, tube, [cos, product, square])?;
            // Written so that NaN is kept.
            least = if here >= least { least } else { here };
        }
    }
    (least > 0.0).then_some(least)
}

/// The lower bound of H in one cell.
fn growth(
    cell: &Cell,
    r0: Ball,
    slope: Ball,
    damping: Ball,
    tube: f64,
    [cos, product, square]: [Ball; 3],
) -> Option<f64> {
    let one = Ball::exact(1.0);
    let Cell { a, k, b, .. } = *cell;
    let sigma = product * -0.5;
    let sigma_slope = square - Ball::exact(0.5);
    let t = Ball::new(0.0, tube);
    let (rho, rho_slope) = (r0 + t * sigma, slope + t * sigma_slope);
    let s = one - rho * cos;
    let q = one + k * s;
    if !(rho.least() > 0.0 && q.least() > 0.0) {
        return None;
    }
    let q2 = q * q;
    let along = sigma * cos;
    let e = damping + b * s * 2.0;
    let n = a - q2 * e;
    let q2_dot = k * q * along * -2.0;
    let push = (one + b * along * 2.0) * q2; // -q^2 E.
    let n_dot = push - q2_dot * e;
    // q^2 (rho sin^2 - sigma') with sigma' = sin^2 - 1/2.
    let main = q2 * (Ball::exact(0.5) + (rho - one) * square);
    let rest = (n_dot - q2) * rho * square + n * sigma * square
        - sigma_slope * n * product
        - rho_slope * (q2_dot + n_dot * product);
    Some((main + rest).least())
}

fn cells(tile: &Tile) -> Vec<Cell> {
    let ranges = tile.domain.ranges();
    let cells = [0, 1, 2].map(|axis| if ranges[axis][0] == ranges[axis][1] { 1 } else { PARTS[axis] });
    let all = cells.iter().product::<usize>();
    (0..all)
        .map(|at| {
            let index = [at % cells[0], at / cells[0] % cells[1], at / (cells[0] * cells[1])];
            let axes = [0, 1, 2].map(|axis| {
                let edge = |i: usize| 2.0 * i as f64 / cells[axis] as f64 - 1.0;
                // Quarters and eighths are exact.
                let x = Ball::between(edge(index[axis]), edge(index[axis] + 1));
                let (middle, half) = scale(ranges[axis]);
                (middle + half * x, modes(x))
            });
            let [(a, in_a), (k, in_k), (b, in_b)] = axes;
            Cell { a, k, b, weights: products([&in_a, &in_k, &in_b]) }
        })
        .collect()
}

/// T_0, T_1, .. over an interval: the slope of T_n is at most n^2.
fn modes(x: Ball) -> [Ball; super::HIGHEST + 1] {
    let middle = super::chebyshev(x.middle);
    std::array::from_fn(|n| {
        let off = (n * n) as f64 * x.radius;
        let whole = Ball::new(0.0, 1.0);
        match n {
            0 => Ball::exact(1.0),
            1 => x,
            _ if off + middle[n].size() >= 1.0 && off >= 0.5 => whole,
            _ => middle[n] + Ball::new(0.0, off),
        }
    })
}

/// Middles of the cells of the angle: points on the circle to within 1e-14, neighbours no further apart than
/// a cell.
fn points() -> Option<Vec<(f64, f64)>> {
    let quarter = ANGLES / 4;
    // One quarter is computed and rotated to the other three: the points go once around.
    let first = (0..quarter).map(|j| (std::f64::consts::TAU * j as f64 / ANGLES as f64).sin_cos());
    let first: Vec<(f64, f64)> = first.map(|(sin, cos)| (cos, sin)).collect();
    let turned = |(c, s): (f64, f64), turns: usize| match turns {
        0 => (c, s),
        1 => (-s, c),
        2 => (-c, -s),
        _ => (s, -c),
    };
    let points: Vec<(f64, f64)> =
        (0..4).flat_map(|turns| first.iter().map(move |&p| turned(p, turns))).collect();
    let cell = std::f64::consts::TAU / ANGLES as f64;
    let sound = (0..ANGLES).all(|j| {
        let ((c, s), (next_c, next_s)) = (points[j], points[(j + 1) % ANGLES]);
        // A chord is shorter than its arc, here by less than 1e-5 of it.
        let chord = ((next_c - c).powi(2) + (next_s - s).powi(2)).sqrt();
        (c * c + s * s - 1.0).abs() < 1e-14 && chord > 0.5 * cell && chord < cell * (1.0 + 1e-9)
    });
    sound.then_some(points)
}

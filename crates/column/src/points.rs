//! Points of codimension two: where a degeneracy vanishes on a curve of codimension one.
//!
//! | point | on the curve | what vanishes there | around it |
//! | --- | --- | --- | --- |
//! | Bautin | Hopf | w''(V): near the equilibrium C(r) = w(V) + w''(V) r^2 / 8 | slip cycles are born repelling on one side, attracting on the other; a fold curve begins |
//! | fold at grazing | grazing | dC/dr at r = V | a fold curve ends: from there on the cycle that grazes is the only one nearby |
//! | Hopf at grazing | Hopf | C(V) - w(V) | both curves cross: four regimes meet |
//! | cusp | fold | dC/dr and its derivative | two fold curves begin: three slip cycles between them, one outside |
//!
//! With a drop of friction C(V) is no curve, and the two points at grazing are not asked for. A landing curve meets no grazing
//! curve: an orbit that grazes comes back with x2' = 0, and the far end of the stick segment takes 2 - j.
//!
//! Two points of the curve at which the degeneracy has different signs, both beyond their errors, enclose a point;
//! a cusp is sought where a fold curve ends. Newton's method finds where all functions vanish; its error is theirs,
//! by the inverse of their derivatives, and the last step. Of a table w'' is a constant between two rows, and no
//! Bautin point is told.

use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Column;
use slipmap_orbits::Closing;
use slipmap_orbits::elements::closed_orbit;

use super::bifurcation::column_of;
use super::continuation::{Branch, CurvePoint, TestFunction, TestValue};

/// Least and greatest distance of the differences that give derivatives, and their share of the distance of two points.
const DIFFERENCES: [f64; 2] = [1e-5, 1e-3];
const SHARE: f64 = 0.01;
/// Largest number of steps of Newton's method; three are usual.
const MOST_STEPS: u32 = 12;
/// Last step, in sides of the plane, and the largest error of a point that is told.
const LAST_STEP: f64 = 1e-10;
const LARGEST_ERROR: f64 = 1e-4;
/// Farthest that a point may be from the two that enclose it, in units of their distance.
const FARTHEST: f64 = 4.0;
/// Distance in ln r of the orbits whose slopes dC/d ln r give the derivative of the slope.
const APART: f64 = 0.02;
/// Tolerance of orbits at cusps.
const TOLERANCE: f64 = 1e-13;
/// Farthest that a cusp may be from the end of a fold curve, in sides of the plane.
const NEAR_ENDS: f64 = 0.02;

/// The points on a curve of `along` at which `degeneracy` vanishes, too.
pub fn points_on(curve: &Branch, along: TestFunction, degeneracy: TestFunction) -> Vec<CurvePoint> {
    let mut found: Vec<CurvePoint> = Vec::new();
    let mut last: Option<(CurvePoint, f64)> = None;
    for point in &curve.points {
        let Some(TestValue { value, error }) = degeneracy(point.place) else {
            last = None;
            continue;
        };
        if !(value.abs() > error) {
            continue;
        }
        if let Some((before, of_before)) = last
            && of_before * value < 0.0
        {
            found.extend(between([before.place, point.place], [of_before, value], along, degeneracy));
        }
        last = Some((*point, value));
    }
    found
}

/// The place where both functions vanish, next to the chord between two places at which the second has these values.
fn between(
    [from, to]: [[f64; 2]; 2],
    [of_from, of_to]: [f64; 2],
    along: TestFunction,
    degeneracy: TestFunction,
) -> Option<CurvePoint> {
    let apart = (to[0] - from[0]).hypot(to[1] - from[1]);
    let share = of_from / (of_from - of_to);
    let start = [0, 1].map(|side| from[side] + share * (to[side] - from[side]));
    let step = (SHARE * apart).clamp(DIFFERENCES[0], DIFFERENCES[1]);
    let both = |place: [f64; 2]| Some([along(place)?, degeneracy(place)?]);
    let (place, errors) = newton(start, [step; 2], [[0.0, 1.0]; 2], both)?;
    let error = errors[0].hypot(errors[1]);
    let off = (place[0] - start[0]).hypot(place[1] - start[1]);
    (off <= FARTHEST * apart && error <= LARGEST_ERROR).then_some(CurvePoint { place, error })
}

/// Where functions vanish, by Newton's method with central differences at these `steps`, within `bounds`; with the
/// errors of the coordinates.
fn newton<const N: usize>(
    start: [f64; N],
    steps: [f64; N],
    bounds: [[f64; 2]; N],
    all: impl Fn([f64; N]) -> Option<[TestValue; N]>,
) -> Option<([f64; N], [f64; N])> {
    let mut place = start;
    let mut shortest = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        // Differences stay within the bounds.
        let middle: [f64; N] =
            std::array::from_fn(|i| place[i].clamp(bounds[i][0] + steps[i], bounds[i][1] - steps[i]));
        let here = all(place)?;
        let mut derivatives = [[0.0; N]; N];
        for i in 0..N {
            let (mut low, mut high) = (middle, middle);
            (low[i], high[i]) = (low[i] - steps[i], high[i] + steps[i]);
            let [low, high] = [all(low)?, all(high)?];
            for of in 0..N {
                derivatives[of][i] = (high[of].value - low[of].value) / (2.0 * steps[i]);
            }
        }
        let inverse = inverse(derivatives)?;
        let by = |i: usize, of: &dyn Fn(f64, TestValue) -> f64| -> f64 {
            inverse[i].iter().zip(here).map(|(share, value)| of(*share, value)).sum()
        };
        let change: [f64; N] = std::array::from_fn(|i| by(i, &|share, here| -share * here.value));
        let length = change.iter().map(|part| part * part).sum::<f64>().sqrt();
        if !length.is_finite() {
            return None;
        }
        place = std::array::from_fn(|i| (place[i] + change[i]).clamp(bounds[i][0], bounds[i][1]));
        if length <= LAST_STEP || length >= shortest {
            let error = |i: usize| by(i, &|share, here| (share * here.error).abs());
            return Some((place, std::array::from_fn(|i| error(i) + length + 4.0 * f64::EPSILON)));
        }
        shortest = length;
    }
    None
}

/// The inverse of a matrix, by elimination with pivots; `None` of a singular one.
fn inverse<const N: usize>(mut left: [[f64; N]; N]) -> Option<[[f64; N]; N]> {
    let mut right = [[0.0; N]; N];
    (0..N).for_each(|i| right[i][i] = 1.0);
    for i in 0..N {
        let pivot = (i..N).max_by(|a, b| left[*a][i].abs().total_cmp(&left[*b][i].abs()))?;
        left.swap(i, pivot);
        right.swap(i, pivot);
        let by = left[i][i];
        if !(by.abs() > 0.0) {
            return None;
        }
        (0..N).for_each(|k| (left[i][k], right[i][k]) = (left[i][k] / by, right[i][k] / by));
        let (row, of_row) = (left[i], right[i]);
        for j in (0..N).filter(|j| *j != i) {
            let times = left[j][i];
            for k in 0..N {
                left[j][k] -= times * row[k];
                right[j][k] -= times * of_row[k];
            }
        }
    }
    Some(right)
}

/// The orbit that closes at an amplitude; `None` where it leaves the polar form.
fn closing(column: &Column, radius: f64, tolerance: f64) -> Option<Closing> {
    let weakening = column.curve.compiled(4.0 * column.belt_speed);
    Some(closed_orbit(&weakening, column.belt_speed, radius, tolerance).ok()?.closing)
}

/// dC/d ln r at an amplitude, in units of C, with its error.
pub(super) fn slope(column: &Column, radius: f64, tolerance: f64) -> Option<TestValue> {
    let [value, error] = closing(column, radius, tolerance)?.slope?;
    Some(TestValue { value, error })
}

/// The cusp of the oscillators `at` the places of the unit square, near a place and an amplitude over the belt speed:
/// where the orbit closes, and the slope of the backbone and its derivative vanish.
pub fn cusp(
    at: &dyn Fn([f64; 2]) -> Option<Oscillator>,
    place: [f64; 2],
    amplitude: f64,
) -> Option<CurvePoint> {
    let all = |[x, y, log]: [f64; 3]| {
        let oscillator = at([x, y])?;
        let column = column_of(&oscillator);
        let radius = |log: f64| log.exp() * column.belt_speed;
        let of = |log: f64| slope(&column, radius(log), TOLERANCE);
        let [inner, low, high, outer] = [-2.0, -1.0, 1.0, 2.0].map(|times| of(log + times * APART));
        let [inner, low, high, outer] = [inner?, low?, high?, outer?];
        // Of the fourth order.
        let value = (8.0 * (high.value - low.value) - (outer.value - inner.value)) / (12.0 * APART);
        let coarse = (outer.value - inner.value) / (4.0 * APART);
        let bend = (outer.value - 2.0 * (high.value - low.value) - inner.value) / (2.0 * APART);
        let rounding = [inner, low, high, outer].iter().map(|of| of.error).sum::<f64>() / APART;
        let error = rounding + APART.powi(2) * bend.abs().max((coarse - value).abs());
        let here = closing(&column, radius(log), TOLERANCE)?;
        let excess = TestValue { value: here.viscous - oscillator.viscous, error: here.error };
        Some([excess, of(log)?, TestValue { value, error }])
    };
    // Orbits on both sides of the amplitude stay below the belt line.
    let bounds = [[0.0, 1.0], [0.0, 1.0], [f64::NEG_INFINITY, -3.0 * APART]];
    let [x, y] = place;
    let start = [x, y, amplitude.ln().min(bounds[2][1])];
    let (found, errors) = newton(start, [DIFFERENCES[1], DIFFERENCES[1], 0.1 * APART], bounds, all)?;
    let error = errors[0].hypot(errors[1]);
    let off = (found[0] - x).hypot(found[1] - y);
    let is_told = error <= LARGEST_ERROR && off <= NEAR_ENDS;
    is_told.then_some(CurvePoint { place: [found[0], found[1]], error })
}

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
//! Two points of the curve at which the degeneracy has different signs, both beyond their errors, enclose a point. Newton's
//! method finds where both functions vanish; its error is theirs, by the inverse of their derivatives, and the last step.

use slipmap_model::friction::Column;
use slipmap_orbits::elements::{Closed, closed_orbit};

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
/// Ends of two fold curves this near, in sides of the plane, may be those at a cusp.
pub const NEAR_ENDS: f64 = 0.02;

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

/// Where two functions vanish, by Newton's method with central differences at these `steps`, within `bounds`; with the errors
/// of both coordinates.
fn newton(
    start: [f64; 2],
    steps: [f64; 2],
    bounds: [[f64; 2]; 2],
    both: impl Fn([f64; 2]) -> Option<[TestValue; 2]>,
) -> Option<([f64; 2], [f64; 2])> {
    let mut place = start;
    let mut shortest = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        // Differences stay within the bounds.
        let middle = [0, 1].map(|i| place[i].clamp(bounds[i][0] + steps[i], bounds[i][1] - steps[i]));
        let [here, there] = both(place)?;
        let mut columns = [[0.0; 2]; 2];
        for (i, column) in columns.iter_mut().enumerate() {
            let (mut low, mut high) = (middle, middle);
            (low[i], high[i]) = (low[i] - steps[i], high[i] + steps[i]);
            let [low, high] = [both(low)?, both(high)?];
            *column = [0, 1].map(|of| (high[of].value - low[of].value) / (2.0 * steps[i]));
        }
        let [[a, c], [b, d]] = columns;
        let determinant = a * d - b * c;
        let solve = |f: f64, g: f64| [(d * f - b * g) / determinant, (a * g - c * f) / determinant];
        let change = solve(-here.value, -there.value);
        let next = [0, 1].map(|i| (place[i] + change[i]).clamp(bounds[i][0], bounds[i][1]));
        let length = change[0].hypot(change[1]);
        if !length.is_finite() {
            return None;
        }
        place = next;
        if length <= LAST_STEP || length >= shortest {
            let of = |i: usize| {
                let by = [solve(here.error, 0.0)[i], solve(0.0, there.error)[i]];
                by[0].abs() + by[1].abs() + length + 4.0 * f64::EPSILON
            };
            return Some((place, [of(0), of(1)]));
        }
        shortest = length;
    }
    None
}

/// dC/d ln r at an amplitude, in units of C, with its error; `None` where its orbit leaves the polar form.
pub(super) fn slope(column: &Column, radius: f64, tolerance: f64) -> Option<TestValue> {
    let weakening = column.curve.compiled(4.0 * column.belt_speed);
    let Closed { closing, .. } = closed_orbit(&weakening, column.belt_speed, radius, tolerance).ok()?;
    let [value, error] = closing.slope?;
    Some(TestValue { value, error })
}

/// A cusp of fold curves of a family of columns.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cusp {
    /// Its place among the columns, with its error.
    pub share: [f64; 2],
    /// C there, with its error.
    pub viscous: [f64; 2],
    /// The amplitude, over the belt speed.
    pub amplitude: f64,
}

/// The cusp of the columns `at` places between 0 and 1, near a place and an amplitude over the belt speed: where the slope of
/// the backbone and its derivative vanish.
pub fn cusp(at: &dyn Fn(f64) -> Option<Column>, share: f64, amplitude: f64) -> Option<Cusp> {
    let both = |[share, log]: [f64; 2]| {
        let column = at(share)?;
        let of = |log: f64| slope(&column, log.exp() * column.belt_speed, TOLERANCE);
        let [inner, low, high, outer] = [-2.0, -1.0, 1.0, 2.0].map(|times| of(log + times * APART));
        let [inner, low, high, outer] = [inner?, low?, high?, outer?];
        // Of the fourth order.
        let value = (8.0 * (high.value - low.value) - (outer.value - inner.value)) / (12.0 * APART);
        let coarse = (outer.value - inner.value) / (4.0 * APART);
        let bend = (outer.value - 2.0 * (high.value - low.value) - inner.value) / (2.0 * APART);
        let rounding = [inner, low, high, outer].iter().map(|of| of.error).sum::<f64>() / APART;
        let error = rounding + APART.powi(2) * bend.abs().max((coarse - value).abs());
        Some([of(log)?, TestValue { value, error }])
    };
    // Orbits on both sides of the amplitude stay below the belt line.
    let bounds = [[0.0, 1.0], [f64::NEG_INFINITY, -3.0 * APART]];
    let start = [share, amplitude.ln().min(bounds[1][1])];
    let (place, errors) = newton(start, [DIFFERENCES[1], 0.1 * APART], bounds, both)?;
    let column = at(place[0])?;
    let weakening = column.curve.compiled(4.0 * column.belt_speed);
    let radius = place[1].exp() * column.belt_speed;
    let here = closed_orbit(&weakening, column.belt_speed, radius, TOLERANCE).ok()?.closing;
    // C changes along the columns alone, since its slope vanishes.
    let aside = (place[0] + DIFFERENCES[1]).min(1.0);
    let beside = at(aside).and_then(|column| {
        let weakening = column.curve.compiled(4.0 * column.belt_speed);
        closed_orbit(&weakening, column.belt_speed, place[1].exp() * column.belt_speed, TOLERANCE).ok()
    })?;
    let rate = (beside.closing.viscous - here.viscous) / (aside - place[0]).max(f64::MIN_POSITIVE);
    let is_told = errors[0] <= LARGEST_ERROR && (start[0] - place[0]).abs() <= NEAR_ENDS;
    is_told.then_some(Cusp {
        share: [place[0], errors[0]],
        viscous: [here.viscous, here.error + (rate * errors[0]).abs()],
        amplitude: place[1].exp(),
    })
}

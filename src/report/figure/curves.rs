//! Critical dampings along one parameter, and how curves are drawn.

use super::axis::{Panel, Scale};
use super::palette::{self, MethodStyle};
use super::scene::{Place, Scene, Stroke};
use super::slice::point;
use crate::friction::Column;
use crate::map::{Axis, Method};
use crate::simulate::critical::critical_dampings;
use crate::store::MapFile;

/// Number of points of a curve.
const POINTS: usize = 160;
/// Number of marks on a curve.
const MARKS: usize = 6;
/// Accuracy of critical dampings in figures, far below the width of a line.
const TOLERANCE: f64 = 1e-9;
/// Number of columns without an answer after which a curve ends: each of them takes up to a second.
const MOST_FAILURES: usize = 4;
/// Number of evaluations of the right-hand side after which a curve ends: some hundred times those of an
/// ordinary curve.
const MOST_WORK: u64 = 20_000_000;
/// Number of columns that are solved together: few, since all of them may fail.
const TOGETHER: usize = 2;

/// Evenly spaced numbers on a scale.
pub(super) fn samples(scale: Scale) -> Vec<f64> {
    (0..=POINTS).map(|i| scale.value(i as f64 / POINTS as f64)).collect()
}

/// A scale without the part at its end where no value is positive; unchanged if no value is positive
/// anywhere. `most` is the largest value at each sample of the scale.
pub(super) fn cut(scale: Scale, samples: &[f64], most: impl Fn(usize) -> f64) -> Scale {
    match (0..samples.len()).rev().find(|&i| most(i) > 0.0) {
        Some(last) => {
            let end = (1.05 * scale.unit(samples[last]) + 0.02).min(1.0);
            Scale { to: scale.value(end), ..scale }
        }
        None => scale,
    }
}

/// The columns of a map's law in which `axis` takes the given values and the others are fixed at nodes.
pub(super) fn columns(map: &MapFile, index: &[usize], axis: usize, values: &[f64]) -> Vec<Column> {
    let axes: &[Axis] = map.grid().axes();
    values
        .iter()
        .map(|&value| {
            let mut at: Vec<f64> = axes.iter().zip(index).map(|(axis, &i)| axis.values[i]).collect();
            at[axis] = value;
            map.grid().law().column(&point(&at))
        })
        .collect()
}

/// The exact critical damping of each column; NaN where there is none, and after [`MOST_FAILURES`] columns
/// without an answer, or [`MOST_WORK`].
pub(super) fn exact(columns: &[Column]) -> Vec<f64> {
    let (mut found, mut failures, mut work) = (Vec::with_capacity(columns.len()), 0, 0);
    for some in columns.chunks(TOGETHER) {
        if failures >= MOST_FAILURES || work >= MOST_WORK {
            break;
        }
        let roots = critical_dampings(some, TOLERANCE);
        failures += roots.iter().filter(|root| root.is_err()).count();
        work += roots.iter().flatten().map(|root| root.rhs).sum::<u64>();
        found.extend(roots.into_iter().map(|root| root.map_or(f64::NAN, |root| root.c)));
    }
    found.resize(columns.len(), f64::NAN);
    found
}

/// The damping at which the equilibrium changes its stability: the divergence there is
/// weakening(V) - eps c.
pub(super) fn stability(column: &Column) -> f64 {
    column.curve.weakening(column.belt_speed) / column.epsilon
}

/// The boundary of each method of a map that this program knows, the simulation last.
pub(super) fn by_method(map: &MapFile, columns: &[Column]) -> Vec<(String, Vec<f64>)> {
    let mut curves: Vec<(String, Vec<f64>)> = map
        .methods()
        .iter()
        .filter_map(|method| match Method::by_name(&method.name)? {
            Method::Test(test) => {
                let edges = columns.iter().map(|column| (test.claim)(column).present_below);
                Some((method.name.clone(), edges.map(|c| if c.is_finite() { c } else { f64::NAN }).collect()))
            }
            Method::Simulation | Method::Naive(..) => None,
        })
        .collect();
    curves.push((super::super::SIMULATION.into(), exact(columns)));
    curves
}

/// Draws the curve of a method with its marks. Curves with different `turn` have their marks at different
/// places.
pub(super) fn draw(scene: &mut Scene, panel: &Panel, x: &[f64], y: &[f64], style: &MethodStyle, turn: usize) {
    let places: Vec<Place> = x.iter().zip(y).map(|(&x, &y)| panel.place(x, y)).collect();
    scene.clipped(panel.rect, |scene| scene.line(&places, &style.stroke));
    let step = places.len() / MARKS;
    let inside = |place: &Place| {
        let r = panel.rect;
        (r.x..=r.x + r.w).contains(&place.0) && (r.y..=r.y + r.h).contains(&place.1)
    };
    for place in places.iter().skip(step * (turn % 7) / 7 + step / 8).step_by(step.max(1)) {
        if inside(place) {
            scene.marker(style.marker, *place, 4.2, style.stroke.color, false);
        }
    }
}

/// A guide line, less prominent than the data.
pub(super) const GUIDE: Stroke = Stroke { color: palette::GREY, width: 0.7, dash: &[3.0, 2.0] };

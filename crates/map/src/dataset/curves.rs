//! The curves of codimension one as two tables, along planes and along points.

use super::Contents::{Integers, Reals};
use super::{Series, si_name};
use crate::{Axis, Grid, Plane, PlaneCurves};

/// Dimension of the planes.
pub const PLANE: &str = "plane";
/// Dimension of the points.
pub const POINT: &str = "point";

/// Name of the column with the values at which an axis is held fixed.
pub fn held(axis: &Axis) -> String {
    format!("held_{}", axis.name)
}

/// The columns of both tables.
pub fn columns(grid: &Grid, planes: &[PlaneCurves]) -> Vec<Series> {
    let axes = grid.axes();
    let word = |position: fn(&Plane) -> usize| -> Vec<&str> {
        planes.iter().map(|curves| axes[position(&curves.plane)].name.as_str()).collect()
    };
    let mut columns = vec![
        Series::of_words(PLANE, "plane_x", "first axis of the plane", &word(|plane| plane.x)),
        Series::of_words(PLANE, "plane_y", "second axis of the plane", &word(|plane| plane.y)),
    ];
    for (position, axis) in axes.iter().enumerate() {
        let values = planes.iter().map(|PlaneCurves { plane, .. }| match position {
            shown if shown == plane.x || shown == plane.y => f64::NAN,
            _ => axis.values[plane.held[position]],
        });
        let long_name = format!("value at which {} is held, NaN in the plane", axis.name);
        let units = si_name(axis.unit);
        columns.push(Series::new(PLANE, &held(axis), &long_name, &units, Reals(values.collect())));
    }
    if planes.iter().any(|curves| curves.points() > 0) {
        columns.extend(points(axes, planes));
    }
    columns
}

/// Columns along the dimension `point`.
fn points(axes: &[Axis], planes: &[PlaneCurves]) -> Vec<Series> {
    let (mut number, mut curve, mut branch, mut error) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    let mut values = vec![Vec::new(); axes.len()];
    for (plane_number, curves) in (1..).zip(planes) {
        let plane = &curves.plane;
        for (branch_number, line) in curves.numbered() {
            for point in &line.points {
                number.push(plane_number);
                curve.push(line.bifurcation.name());
                branch.push(i32::try_from(branch_number).unwrap_or(i32::MAX));
                error.push(point.error);
                for (position, column) in values.iter_mut().enumerate() {
                    column.push(match position {
                        x if x == plane.x => point.x,
                        y if y == plane.y => point.y,
                        _ => axes[position].values[plane.held[position]],
                    });
                }
            }
        }
    }
    let of_branch = "number of the connected curve in its plane and kind";
    let mut columns = vec![
        Series::new(POINT, "plane_number", "number of the plane", "1", Integers(number)),
        Series::of_words(POINT, "curve", "what happens on the curve", &curve),
        Series::new(POINT, "branch", of_branch, "1", Integers(branch)),
    ];
    for (axis, values) in axes.iter().zip(values) {
        let units = si_name(axis.unit);
        columns.push(Series::new(POINT, &axis.name, &axis.long_name, &units, Reals(values)));
    }
    let long_name = "estimate of the distance from the curve, in sides of the plane, which is logarithmic along axes of \
                     equal ratios";
    columns.push(Series::new(POINT, "error", long_name, "1", Reals(error)));
    columns
}

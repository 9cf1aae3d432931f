//! Curves of codimension one in a plane of parameters.

use numpy::PyArray1;
use pyo3::prelude::*;
use slipmap::map::{Plane, PlaneCurves};

use crate::law::Law;
use crate::map::grid_of;
use crate::work::run;

/// One connected curve: its kind, its points, and estimates of their distances from the exact curve.
type Curve<'py> =
    (&'static str, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>);

/// The curves in the plane of the axes `x` and `y` of the grid with these nodes, through its first nodes
/// elsewhere.
#[pyfunction]
pub(crate) fn curves<'py>(
    py: Python<'py>,
    law: &Law,
    nodes: Vec<Vec<f64>>,
    x: usize,
    y: usize,
    threads: Option<usize>,
) -> PyResult<Vec<Curve<'py>>> {
    let grid = grid_of(&law.law, nodes)?;
    let plane = Plane::new(x, y, vec![0; grid.axes().len()]);
    let found = run(py, threads, None, |steering| PlaneCurves::of(&grid, plane, &steering.stop))?;
    let column = |values: Vec<f64>| PyArray1::from_vec(py, values);
    let curve = |it: &slipmap::map::PlaneCurve| {
        let points = &it.points;
        (
            it.bifurcation.name(),
            column(points.iter().map(|point| point.x).collect()),
            column(points.iter().map(|point| point.y).collect()),
            column(points.iter().map(|point| point.error).collect()),
        )
    };
    Ok(found.curves.iter().map(curve).collect())
}

//! Backbones: the damping of the slip cycle of each amplitude.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use slipmap::column::backbone::Backbone;

use crate::columns::Arguments;
use crate::law::Law;
use crate::point::check_tolerance;

/// Dampings c = C(r) / eps at the amplitudes r / V, one row per column, and the error estimate of each
/// column; NaN where an orbit could not be followed or an argument is NaN.
#[pyfunction]
#[pyo3(signature = (law, arrays, amplitudes, tolerance, threads=None))]
pub(crate) fn backbone<'py>(
    py: Python<'py>,
    law: &Law,
    arrays: Vec<PyReadonlyArray1<'py, f64>>,
    amplitudes: Vec<f64>,
    tolerance: f64,
    threads: Option<usize>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray1<f64>>)> {
    check_tolerance(tolerance)?;
    let family = &law.law;
    let arguments = Arguments::new(py, family, &arrays)?;
    let unknown = (vec![f64::NAN; amplitudes.len()], f64::NAN);
    let found = arguments.each(py, threads, &unknown, |point| {
        let column = family.column(point);
        let Ok(backbone) = Backbone::of(&column, tolerance) else { return unknown.clone() };
        let damping = |ratio: &f64| backbone.viscous(ratio * column.belt_speed) / column.epsilon;
        (amplitudes.iter().map(damping).collect(), backbone.error / column.epsilon)
    })?;
    let (rows, errors): (Vec<Vec<f64>>, Vec<f64>) = found.into_iter().unzip();
    Ok((PyArray2::from_vec2(py, &rows)?, PyArray1::from_vec(py, errors)))
}

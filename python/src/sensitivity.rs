//! Sensitivities of the critical damping.

use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use slipmap::column::sensitivity::{self as engine, Estimate, Sensitivity};
use slipmap::friction::Law as Family;

use crate::columns::Arguments;
use crate::law::{Law, point_of};

/// Derivatives by the arguments, in their order, and the standard error due to the errors of the data (NaN
/// for a law without standard errors).
fn row(law: &Family, found: &Sensitivity) -> Vec<Estimate> {
    const NONE: Estimate = Estimate { value: f64::NAN, error: f64::NAN };
    let mut row: Vec<Estimate> = found.named(law).map(|(_, by)| by).collect();
    row.push(found.standard_error.unwrap_or(NONE));
    row
}

/// A row for each argument, with the derivatives of the critical damping by it, and a last one with the
/// standard error that the data's errors make; and estimates of the errors of all. NaN where there is no
/// critical damping or an argument is NaN.
#[pyfunction]
#[pyo3(signature = (law, arrays, threads=None))]
pub(crate) fn sensitivity<'py>(
    py: Python<'py>,
    law: &Law,
    arrays: Vec<PyReadonlyArray1<'py, f64>>,
    threads: Option<usize>,
) -> PyResult<(Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<f64>>)> {
    let family = &law.law;
    let arguments = Arguments::new(py, family, &arrays)?;
    let found =
        arguments.each(py, threads, &None, |point| engine::sensitivity(&family.column(point)).ok())?;
    let rows: Vec<Option<Vec<Estimate>>> =
        found.iter().map(|found| found.as_ref().map(|found| row(family, found))).collect();
    let table = |of: fn(&Estimate) -> f64| {
        let number = |row: &Option<Vec<Estimate>>, i: usize| row.as_ref().map_or(f64::NAN, |row| of(&row[i]));
        let column = |i: usize| rows.iter().map(|row| number(row, i)).collect();
        let columns: Vec<Vec<f64>> = (0..=arrays.len()).map(column).collect();
        PyArray2::from_vec2(py, &columns)
    };
    Ok((table(|it| it.value)?, table(|it| it.error)?))
}

/// The weight of the friction's slope: the edges of equal ranges of slip speeds, and their shares.
#[pyfunction]
pub(crate) fn influence<'py>(
    py: Python<'py>,
    law: &Law,
    mut values: Vec<f64>,
    parts: usize,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
    // A column has no damping of its own; a point has one.
    values.push(0.0);
    let column = law.law.column(&point_of(&law.law, &values)?);
    let found = py.detach(|| engine::influence(&column, parts));
    let found = found.map_err(|problem| PyValueError::new_err(problem.to_string()))?;
    let edges = found.first().map(|part| part.from).into_iter().chain(found.iter().map(|part| part.to));
    let shares = found.iter().map(|part| part.share);
    Ok((PyArray1::from_iter(py, edges), PyArray1::from_iter(py, shares)))
}

//! Every answer about one point.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::prelude::*;
use slipmap::column::Method;
use slipmap::probe::{Answer, Probe};

use crate::law::{Law, point_of};
use crate::work::run;

/// What `slipmap probe --json` prints of the point with these values, in the order of the law's axes.
#[pyfunction]
pub(crate) fn probe(py: Python<'_>, law: &Law, values: Vec<f64>, tolerance: f64) -> PyResult<String> {
    check_tolerance(tolerance)?;
    let point = point_of(&law.law, &values)?;
    let family = law.law.clone();
    let probe = run(py, None, None, |_| {
        let (answer, direct) = Answer::of_both_engines(&family, &point, tolerance, Method::all());
        Probe::new(&answer, &direct)
    })?;
    json(&probe)
}

/// An answer as JSON.
pub(crate) fn json(answer: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(answer)
        .map_err(|error| PyRuntimeError::new_err(format!("cannot form the JSON: {error}")))
}

/// Refuses tolerances that no engine can meet.
pub(crate) fn check_tolerance(tolerance: f64) -> PyResult<()> {
    slipmap::config::check_tolerance(tolerance).map_err(PyValueError::new_err)
}

//! Sampled orbits.

use numpy::PyArray1;
use pyo3::prelude::*;
use slipmap::filippov::{Oscillator, Side};
use slipmap::witness::{Ending, Phase, Start, trace};

use crate::law::{Law, point_of};
use crate::point::check_tolerance;
use crate::work::run;

/// Time, x1, x2 and phase (-1 slower than the belt, 0 sticking, 1 faster) of every sample, how the orbit
/// ends, and the period where it closes.
type Sampled<'py> = (
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<i8>>,
    String,
    Option<f64>,
);

/// The orbit from `start`, or from the exit point.
#[pyfunction]
pub(crate) fn orbit<'py>(
    py: Python<'py>,
    law: &Law,
    values: Vec<f64>,
    start: Option<(f64, f64)>,
    tolerance: f64,
    max_time: f64,
) -> PyResult<Sampled<'py>> {
    check_tolerance(tolerance)?;
    let point = point_of(&law.law, &values)?;
    let family = law.law.clone();
    let start = start.map_or(Start::ExitPoint, |(x1, x2)| Start::State { x1, x2 });
    let traced =
        run(py, Some(1), None, |_| trace(&Oscillator::new(&family, &point), start, tolerance, max_time))?;
    let column = |of: fn(&slipmap::witness::Sample) -> f64| {
        PyArray1::from_vec(py, traced.samples.iter().map(of).collect())
    };
    let phase = |sample: &slipmap::witness::Sample| match sample.phase {
        Phase::Slip(Side::Below) => -1,
        Phase::Stick => 0,
        Phase::Slip(Side::Above) => 1,
    };
    let (ending, period) = match traced.ending {
        Ending::Closes { period } => ("closes".to_owned(), Some(period)),
        Ending::Settles => ("settles".to_owned(), None),
        Ending::OutOfTime => ("out_of_time".to_owned(), None),
        Ending::Failed(failure) => (format!("failed: {failure}"), None),
    };
    let phases = PyArray1::from_vec(py, traced.samples.iter().map(phase).collect());
    Ok((column(|it| it.t), column(|it| it.x1), column(|it| it.x2), phases, ending, period))
}

//! Machines in SI units.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use slipmap::behaviour::behaviour;
use slipmap::machine::{Machine, Model, Motion};
use slipmap::map::Method;
use slipmap::probe::{Answer, MachineResult, Probe};
use slipmap::witness;

use crate::law::Law;
use crate::point::{check_tolerance, json};
use crate::work::run;

fn machine_of(law: &Law, motion: &str, numbers: [f64; 9]) -> PyResult<Machine> {
    let known = Motion::ALL.into_iter().find(|it| it.name() == motion);
    let motion = known.ok_or_else(|| {
        let names = Motion::ALL.map(|it| it.name()).join(", ");
        PyValueError::new_err(format!("there is no motion `{motion}`; choose from: {names}"))
    })?;
    Ok(Machine::from_array(motion, law.law.clone(), numbers))
}

fn no_coefficients(law: &Law) -> PyErr {
    PyValueError::new_err(format!(
        "the law `{}` has no coefficients of friction; use stribeck, exponential, lorentzian or coulomb with a machine, or \
         describe it in a configuration, for slipmap.run or slipmap probe --machine",
        law.law.name()
    ))
}

/// The point of a machine (epsilon, the law's parameters, V, c), and the units of time, length, velocity,
/// force and damping.
#[pyfunction]
pub(crate) fn machine_point(law: &Law, motion: &str, numbers: [f64; 9]) -> PyResult<(Vec<f64>, [f64; 5])> {
    let machine = machine_of(law, motion, numbers)?;
    let Model { point, .. } = machine.model().ok_or_else(|| no_coefficients(law))?;
    let values = std::iter::once(point.epsilon())
        .chain(point.law().as_slice().iter().copied())
        .chain([point.belt_speed(), point.damping()]);
    let units = machine.units();
    Ok((values.collect(), [units.time, units.length, units.velocity, units.force, units.damping]))
}

/// What `slipmap probe --machine --json` prints.
#[pyfunction]
pub(crate) fn machine_probe(
    py: Python<'_>,
    law: &Law,
    motion: &str,
    numbers: [f64; 9],
    tolerance: f64,
) -> PyResult<String> {
    check_tolerance(tolerance)?;
    let machine = machine_of(law, motion, numbers)?;
    let model = machine.model().ok_or_else(|| no_coefficients(law))?;
    let probe = run(py, None, None, |_| {
        let answer = Answer::of(&model.law, &model.point, tolerance, Method::all());
        let direct = witness::flow(&answer.oscillator, tolerance);
        let mut probe = Probe::new(&answer, &direct);
        probe.machine = Some(MachineResult::new(&machine, &behaviour(&model, tolerance)));
        probe
    })?;
    json(&probe)
}

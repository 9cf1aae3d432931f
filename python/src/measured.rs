//! Measured friction: a law through its rows, and one fitted to them.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use slipmap::config::{How, Measured, OfMachine, law_of};
use slipmap::friction::{Expression, Law as Family};

use crate::law::{Law, level, told};
use crate::point::json;

fn read(name: &str, rows: &[u8], forces: Option<bool>, how: [Option<&str>; 3]) -> PyResult<Measured> {
    let machine = Some(OfMachine { motion: None, forces });
    let how = How::named(how[0], how[1], how[2]).map_err(told)?.of(machine);
    Measured::of_bytes(name, rows, how).map_err(told)
}

/// The law through the rows of a file, in SI units, and whether they are forces.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // those of Python
pub(crate) fn measured(
    name: &str,
    rows: &[u8],
    static_level: Option<f64>,
    at_peak: bool,
    forces: Option<bool>,
    kind: Option<&str>,
    direction: Option<&str>,
    column: Option<&str>,
) -> PyResult<(Law, bool)> {
    let level = level(static_level, at_peak)?;
    let measured = read(name, rows, forces, [kind, direction, column])?;
    let law = Family::Table(measured.table(level).map_err(told)?);
    Ok((Law { law }, measured.holds_forces()))
}

/// The law fitted to the rows of a file, what `slipmap fit --json` prints of it, and the table `[friction]` of a
/// configuration.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // those of Python
pub(crate) fn fit(
    py: Python<'_>,
    name: &str,
    rows: &[u8],
    law: Option<&str>,
    forces: Option<bool>,
    kind: Option<&str>,
    direction: Option<&str>,
    column: Option<&str>,
) -> PyResult<(Law, String, String)> {
    let measured = read(name, rows, forces, [kind, direction, column])?;
    let law = law.map(law_of).transpose().map_err(told)?;
    let fits = py.detach(|| measured.fits(law)).map_err(told)?;
    let chosen = fits.chosen();
    let formula = measured.named(&chosen.form.formula());
    // Without a drop, friction at rest is that at the onset of slip.
    let law = match chosen.at_rest {
        Some([level, _]) => Expression::with_static(&formula, level),
        None => Expression::new(&formula, chosen.friction(0.0)),
    };
    let law = law.map_err(|error| PyValueError::new_err(error.problem))?;
    let law = Law { law: Family::Expression(law) };
    Ok((law, json(&measured.fitted(&fits))?, measured.to_toml(chosen)))
}

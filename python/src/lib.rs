//! The compiled part of the Python package `slipmap`: the functions that would be slow in Python.
//!
//! The Python part broadcasts, names and documents; this extension takes and returns flat arrays. Every long
//! function releases the GIL, uses all cores, and can be interrupted by Ctrl-C.

// Signatures name the types of Python.
#![allow(clippy::type_complexity)]

mod backbone;
mod columns;
mod curves;
mod law;
mod machine;
mod map;
mod measured;
mod orbit;
mod point;
mod sensitivity;
mod work;

use pyo3::prelude::*;
use slipmap::column::{Method, Regime, Verdict};
use slipmap::machine::Machine;
use slipmap::map::Field;

/// The compiled part of slipmap.
#[pymodule]
fn _core(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("SCHEMA", slipmap::dataset::SCHEMA)?;
    module.add("VERDICTS", Verdict::ALL.map(|verdict| (verdict.name(), verdict.code())).to_vec())?;
    let regimes = Regime::ALL.map(|it| (it.name(), it.code(), slipmap::probe::regime_words(it)));
    module.add("REGIMES", regimes.to_vec())?;
    let methods = Method::all().map(|it| (it.name(), it.long_name(), it.guarantee().name(), it.equation()));
    module.add("METHODS", methods.collect::<Vec<_>>())?;
    module.add("USUAL_METHODS", Method::usual().map(|it| it.name()).collect::<Vec<_>>())?;
    module.add("FIELDS", Field::ALL.map(Field::name).to_vec())?;
    module.add("OWN_QUANTITIES", Machine::own_names().collect::<Vec<_>>())?;
    module.add_class::<law::Law>()?;
    module.add_class::<machine::Machine>()?;
    module.add_class::<map::Map>()?;
    module.add_function(wrap_pyfunction!(machine::with_deviation, module)?)?;
    module.add_function(wrap_pyfunction!(machine::share, module)?)?;
    module.add_function(wrap_pyfunction!(columns::critical_c, module)?)?;
    module.add_function(wrap_pyfunction!(columns::verdicts, module)?)?;
    module.add_function(wrap_pyfunction!(columns::regime, module)?)?;
    module.add_function(wrap_pyfunction!(backbone::backbone, module)?)?;
    module.add_function(wrap_pyfunction!(sensitivity::sensitivity, module)?)?;
    module.add_function(wrap_pyfunction!(sensitivity::influence, module)?)?;
    module.add_function(wrap_pyfunction!(point::probe, module)?)?;
    module.add_function(wrap_pyfunction!(orbit::orbit, module)?)?;
    module.add_function(wrap_pyfunction!(curves::curves, module)?)?;
    module.add_function(wrap_pyfunction!(map::compute_map, module)?)?;
    module.add_function(wrap_pyfunction!(map::run_config, module)?)?;
    module.add_function(wrap_pyfunction!(measured::measured, module)?)?;
    module.add_function(wrap_pyfunction!(measured::fit, module)?)?;
    Ok(())
}

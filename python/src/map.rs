//! Grids.

use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use slipmap::friction::Law as Family;
use slipmap::map::Grid;

/// The grid with these nodes, in the order of the law's axes.
pub(crate) fn grid_of(law: &Family, nodes: Vec<Vec<f64>>) -> PyResult<Grid> {
    let axes = Grid::axis_names(law);
    if nodes.len() != axes.len() {
        return Err(PyValueError::new_err(format!("give nodes for each axis: {}", axes.join(", "))));
    }
    Grid::new(law.clone(), nodes).map_err(|error| PyValueError::new_err(error.to_string()))
}

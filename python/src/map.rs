//! Maps in memory: the run of the library with arrays as its sink.

use std::ffi::CString;
use std::ops::Range;
use std::path::Path;
use std::sync::{Mutex, PoisonError};

use numpy::ndarray::ArrayD;
use numpy::{PyArray1, PyArrayMethods, ToPyArray};
use pyo3::exceptions::{PyKeyboardInterrupt, PyMemoryError, PyRuntimeError, PyUserWarning, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use slipmap::config::Job;
use slipmap::dataset::attributes::{self, Outcome};
use slipmap::dataset::{Auxiliary, Contents, Provenance, Schema, Series, Value, auxiliary, curves, si_name};
use slipmap::friction::Law as Family;
use slipmap::map::{Chances, ComputeError, Control, Each, Field, Grid, Plan, PlaneCurves, TileData};
use slipmap::risk::{NoRisk, Uncertain};

use crate::columns::method;
use crate::law::{Law, choose};
use crate::work::run;

/// The grid with these nodes, in the order of the law's axes.
pub(crate) fn grid_of(law: &Family, nodes: Vec<Vec<f64>>) -> PyResult<Grid> {
    let axes = law.axis_names();
    if nodes.len() != axes.len() {
        return Err(PyValueError::new_err(format!("give nodes for each axis: {}", axes.join(", "))));
    }
    Grid::new(law.clone(), nodes).map_err(|error| PyValueError::new_err(error.to_string()))
}

/// All cells of a variable.
enum Cells {
    Codes(ArrayD<i8>),
    Reals(ArrayD<f64>),
}

/// Receives tiles into arrays of the whole grid.
struct Memory {
    schema: Schema,
    cells: Vec<Mutex<Cells>>,
}

impl Memory {
    fn new(plan: &Plan) -> PyResult<Self> {
        let schema = Schema::of(plan);
        let empty = |variable| {
            let shape = schema.shape(variable);
            Ok(Mutex::new(match variable.codes() {
                Some(_) => Cells::Codes(filled(&shape, variable.fill_code())?),
                None => Cells::Reals(filled(&shape, f64::NAN)?),
            }))
        };
        let cells = schema.variables.iter().map(empty).collect::<PyResult<_>>()?;
        Ok(Self { schema, cells })
    }

    /// Copies the tile to its place: workers fill different cells.
    fn fill(&self, data: &TileData) {
        for (position, variable) in self.schema.filled_by(data.tile.number) {
            let ranges = &data.tile.ranges;
            let mut cells = self.cells[position].lock().unwrap_or_else(PoisonError::into_inner);
            match (&mut *cells, variable.cells(data)) {
                (Cells::Codes(all), slipmap::dataset::Cells::Codes(codes)) => {
                    fill(all, ranges, codes.values());
                }
                (Cells::Reals(all), slipmap::dataset::Cells::Reals(reals)) => {
                    fill(all, ranges, reals.iter().copied());
                }
                _ => unreachable!("codes are codes and real numbers are real numbers"),
            }
        }
    }
}

/// An array of one value, or Python's error where there is no memory for it.
fn filled<T: Clone>(shape: &[usize], value: T) -> PyResult<ArrayD<T>> {
    let too_large =
        || PyMemoryError::new_err(format!("an array of {shape:?} cells does not fit into memory"));
    let count = shape.iter().try_fold(1usize, |all, &len| all.checked_mul(len)).ok_or_else(too_large)?;
    let mut cells = Vec::new();
    cells.try_reserve_exact(count).map_err(|_| too_large())?;
    cells.resize(count, value);
    ArrayD::from_shape_vec(shape, cells).map_err(|_| too_large())
}

/// Copies the cells of a box, row-major, into an array; a variable may lack the last axis.
fn fill<T>(all: &mut ArrayD<T>, ranges: &[Range<usize>], mut cells: impl Iterator<Item = T>) {
    let mut part = all.slice_each_axis_mut(|axis| ranges[axis.axis.index()].clone().into());
    for mut row in part.rows_mut() {
        row.iter_mut().zip(&mut cells).for_each(|(place, cell)| *place = cell);
    }
}

/// A computed map.
#[pyclass(frozen, module = "slipmap._core")]
pub(crate) struct Map {
    schema: Schema,
    cells: Vec<Cells>,
    attributes: Vec<(String, Value)>,
    curves: Vec<PlaneCurves>,
    /// What is stored in one piece: the quantities of a machine that do not vary, the probability of stick-slip.
    pieces: Vec<Auxiliary>,
}

fn attribute<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    Ok(match value {
        Value::Text(text) => text.into_pyobject(py)?.into_any(),
        // A single number is a scalar, as readers of the file have it.
        Value::Codes(codes) if codes.len() == 1 => PyArray1::from_slice(py, codes).get_item(0)?,
        Value::Codes(codes) => PyArray1::from_slice(py, codes).into_any(),
        Value::Integers(numbers) if numbers.len() == 1 => PyArray1::from_slice(py, numbers).get_item(0)?,
        Value::Integers(numbers) => PyArray1::from_slice(py, numbers).into_any(),
        Value::Reals(numbers) if numbers.len() == 1 => PyArray1::from_slice(py, numbers).get_item(0)?,
        Value::Reals(numbers) => PyArray1::from_slice(py, numbers).into_any(),
    })
}

fn attribute_dict<'py, 'a>(
    py: Python<'py>,
    attributes: impl IntoIterator<Item = (&'a str, &'a Value)>,
) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    for (name, value) in attributes {
        if !matches!(value, Value::Text(text) if text.is_empty()) {
            dict.set_item(name, attribute(py, value)?)?;
        }
    }
    Ok(dict)
}

type Column<'py> = (&'static str, String, Bound<'py, PyDict>, Bound<'py, PyAny>);

#[pymethods]
impl Map {
    /// Name, attributes and nodes of every axis.
    #[getter]
    fn axes<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(String, Bound<'py, PyDict>, Bound<'py, PyArray1<f64>>)>> {
        let axis = |axis: &slipmap::map::Axis| {
            let attributes = PyDict::new(py);
            attributes.set_item("long_name", &axis.long_name)?;
            attributes.set_item("units", si_name(axis.unit))?;
            Ok((axis.name.clone(), attributes, PyArray1::from_slice(py, &axis.values)))
        };
        self.schema.grid.axes().iter().map(axis).collect()
    }

    /// Name, attributes and values of what is stored in one piece: single numbers, or cells.
    #[getter]
    fn pieces<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(&'static str, Bound<'py, PyDict>, Bound<'py, PyAny>)>> {
        let grid = &self.schema.grid;
        let one = |of: &Auxiliary| {
            let attributes = of.attributes.iter().map(|(name, value)| (*name, value));
            let shape = grid.shape()[..auxiliary::rank_of(of.name, grid)].to_vec();
            let values = PyArray1::from_slice(py, &of.values).reshape(shape)?.into_any();
            Ok((of.name, attribute_dict(py, attributes)?, values))
        };
        self.pieces.iter().map(one).collect()
    }

    /// Name, attributes and cells of every variable.
    #[getter]
    fn variables<'py>(
        &self,
        py: Python<'py>,
    ) -> PyResult<Vec<(String, Bound<'py, PyDict>, Bound<'py, PyAny>)>> {
        let variables = self.schema.variables.iter().zip(&self.cells).map(|(variable, cells)| {
            let attributes = variable.attributes.iter().map(|(name, value)| (*name, value));
            let array = match cells {
                Cells::Codes(codes) => codes.to_pyarray(py).into_any(),
                Cells::Reals(reals) => reals.to_pyarray(py).into_any(),
            };
            Ok((variable.name.clone(), attribute_dict(py, attributes)?, array))
        });
        variables.collect()
    }

    /// Attributes of the map: where it comes from, and what its run counted.
    #[getter]
    fn attributes<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        attribute_dict(py, self.attributes.iter().map(|(name, value)| (name.as_str(), value)))
    }

    /// Shape of the tiles over which fingerprints are taken.
    #[getter]
    fn tile_shape(&self) -> Vec<usize> {
        self.schema.tile_shape.clone()
    }

    /// Dimension, name, attributes and numbers of every column of the tables of curves; `None` where none were asked for.
    #[getter]
    fn curves<'py>(&self, py: Python<'py>) -> PyResult<Option<Vec<Column<'py>>>> {
        let one = |series: &Series| {
            let values = match &series.contents {
                Contents::Reals(values) => PyArray1::from_slice(py, values).into_any(),
                Contents::Integers(values) => PyArray1::from_slice(py, values).into_any(),
                Contents::Codes(codes) => PyArray1::from_slice(py, codes).into_any(),
            };
            let attributes =
                attribute_dict(py, series.attributes.iter().map(|(name, value)| (*name, value)))?;
            Ok((series.dimension, series.name.clone(), attributes, values))
        };
        let columns = || curves::columns(&self.schema.grid, &self.curves);
        (!self.curves.is_empty()).then(|| columns().iter().map(one).collect()).transpose()
    }
}

/// Warns as the program does on its standard error.
fn warn(py: Python<'_>, words: &str) -> PyResult<()> {
    let words = CString::new(words)?;
    PyErr::warn(py, &py.get_type::<PyUserWarning>(), &words, 1)
}

/// Computes the map of a plan.
fn compute(
    py: Python<'_>,
    plan: &Plan,
    uncertain: &[Uncertain],
    provenance: &Provenance,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Map> {
    let memory = py.detach(|| Memory::new(plan))?;
    // The run of the library creates its own threads.
    let summary = run(py, Some(1), progress.as_ref(), |steering| {
        let on_cells = |cells| steering.advance(cells);
        let control = Control { threads, on_cells: &on_cells, stop: &steering.stop, ..Control::default() };
        let summary = slipmap::map::run(plan, &Each(|data| memory.fill(data)), &control)?;
        let chances = Chances::of(&plan.grid, uncertain);
        let found = chances.map(|chances| (chances.probabilities(threads, &steering.stop), chances.draws));
        Ok((summary, found))
    })?;
    let (summary, found) = summary.map_err(|error| match error {
        ComputeError::Interrupted => PyKeyboardInterrupt::new_err("the map was interrupted"),
        ComputeError::Threads(why) => PyRuntimeError::new_err(why),
        ComputeError::Sink(never) => match never {},
    })?;
    let Memory { schema, cells } = memory;
    let cells = cells.into_iter().map(|cells| cells.into_inner().unwrap_or_else(PoisonError::into_inner));
    // The attributes of the map file, in its order.
    let mut all = attributes::opening(plan, provenance);
    all.push(("history".to_owned(), attributes::history(provenance).into()));
    let outcome = Outcome::of(plan, &summary);
    all.extend(attributes::closing(&outcome));
    let (curves, mut pieces) = (outcome.curves, outcome.auxiliary);
    match found {
        Some((Ok(found), draws)) => {
            if found.failed > 0 {
                let all = draws * plan.grid.column_count();
                let why = "since the critical damping was not found";
                warn(py, &format!("{} of {all} draws without an answer, {why}", found.failed))?;
            }
            pieces.extend(auxiliary::probabilities(found.values, found.by_itself, draws));
        }
        Some((Err(NoRisk::Interrupted), _)) => {
            return Err(PyKeyboardInterrupt::new_err("the map was interrupted"));
        }
        Some((Err(why), _)) => warn(py, &format!("{why}; the map has no probability"))?,
        None => {}
    }
    Ok(Map { schema, cells: cells.collect(), attributes: all, curves, pieces })
}

/// The map of a grid.
#[pyfunction]
#[allow(clippy::too_many_arguments)] // those of the Python function, which have names there
pub(crate) fn compute_map(
    py: Python<'_>,
    law: &Law,
    nodes: Vec<Vec<f64>>,
    methods: Option<Vec<String>>,
    fields: Vec<String>,
    tolerance: f64,
    audit_cells: usize,
    proof_boxes: usize,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Map> {
    let problem = |error: slipmap::map::PlanError| PyValueError::new_err(error.to_string());
    let grid = grid_of(&law.law, nodes)?;
    let field = |name: &String| choose("field", name, Field::ALL, |field| field.name());
    let fields: Vec<Field> = fields.iter().map(field).collect::<PyResult<_>>()?;
    let mut builder = Plan::builder(grid)
        .fields(fields)
        .tolerance(tolerance)
        .audit_cells(audit_cells)
        .proof_boxes(proof_boxes);
    if let Some(methods) = methods {
        builder = builder.methods(methods.iter().map(|name| method(name)).collect::<PyResult<Vec<_>>>()?);
    }
    let plan = builder.build().map_err(problem)?;
    let provenance = Provenance { command_line: "slipmap.map".into(), ..Provenance::default() };
    compute(py, &plan, &[], &provenance, threads, progress)
}

/// The map of a configuration. `progress_of` gives for a number of cells what is called with those done, or nothing.
#[pyfunction]
pub(crate) fn run_config(
    py: Python<'_>,
    path: &str,
    sets: Vec<String>,
    threads: Option<usize>,
    progress_of: &Bound<'_, PyAny>,
) -> PyResult<Map> {
    let job = Job::load(Path::new(path), &sets).map_err(|error| PyValueError::new_err(error.to_string()))?;
    let progress = progress_of.call1((job.plan.grid.cells(),))?.extract()?;
    let provenance = Provenance {
        title: job.title,
        config_path: job.config_file.display().to_string(),
        config_text: job.config_text,
        command_line: "slipmap.run".into(),
        git: slipmap::GIT.into(),
        threads: 1,
    };
    compute(py, &job.plan, &job.uncertain, &provenance, threads, progress)
}

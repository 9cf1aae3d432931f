//! Elementwise functions: flat arrays in, flat arrays out.

use std::collections::HashMap;

use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use rayon::prelude::*;
use slipmap::column::critical::{CriticalDamping, critical_dampings};
use slipmap::column::{Method, Regime, Verdict, regime as regime_of};
use slipmap::config::point_of;
use slipmap::filippov::Oscillator;
use slipmap::friction::{Column, Law as Family};
use slipmap::map::decide;
use slipmap::orbits::flow;
use slipmap::point::Point;
use slipmap::witness;

use crate::law::{Law, check_law, choose, legal_point};
use crate::point::check_tolerance;
use crate::work::{FEW, Steering, run};

/// Number of elements in a task: many vectors of columns, but little time.
const TASK: usize = 256;

/// Largest number of elements at which a law with its own check is checked, evenly spread over all.
const CHECKED: usize = 256;

/// Number of elements that are checked between two checks for signals.
const BETWEEN_SIGNALS: usize = 1 << 16;

/// Arguments of an elementwise function, in the order of the law's axes: one value for all elements, or one
/// each.
pub(crate) struct Arguments<'a> {
    law: &'a Family,
    values: Vec<&'a [f64]>,
    pub(crate) len: usize,
}

impl<'a> Arguments<'a> {
    /// Checks lengths and domains. An element with a NaN among its arguments is legal, and has no answer.
    pub(crate) fn new(
        py: Python<'_>,
        law: &'a Family,
        arrays: &'a [PyReadonlyArray1<'_, f64>],
    ) -> PyResult<Self> {
        let (values, len) = columns_of(arrays)?;
        let arguments = Self { law, values, len };
        arguments.check(py)?;
        Ok(arguments)
    }

    /// The point of an element, which is legal; `None` if an argument is NaN.
    fn point(&self, i: usize, element: &mut Vec<f64>) -> Option<Point> {
        self.element(i, element);
        point_of(self.law, element).ok()
    }

    /// Applies `of` to the point of each element, in parallel for many; `unknown` where an argument is NaN.
    pub(crate) fn each<T: Clone + Send + Sync>(
        &self,
        py: Python<'_>,
        threads: Option<usize>,
        unknown: &T,
        of: impl Fn(&Point) -> T + Sync,
    ) -> PyResult<Vec<T>> {
        in_tasks(py, self.len, threads, None, |task| {
            let mut element = Vec::new();
            task.map(|i| self.point(i, &mut element).map_or_else(|| unknown.clone(), |point| of(&point)))
                .collect()
        })
    }

    fn element(&self, i: usize, into: &mut Vec<f64>) {
        into.clear();
        into.extend(self.values.iter().map(|values| if values.len() == 1 { values[0] } else { values[i] }));
        // A column has no damping of its own; a point has one.
        into.resize(self.law.parameters().len() + 3, 0.0);
    }

    fn check(&self, py: Python<'_>) -> PyResult<()> {
        let single = self.len == 1;
        let mut element = Vec::new();
        for i in 0..self.len {
            if i % BETWEEN_SIGNALS == 0 {
                py.check_signals()?;
            }
            self.element(i, &mut element);
            if element.iter().any(|value| value.is_nan()) {
                continue;
            }
            let place = || if single { String::new() } else { format!(" (element {i})") };
            legal_point(self.law, &element, place)?;
        }
        let checked = self.len.min(CHECKED);
        for i in 0..checked {
            let place = if checked > 1 { i * (self.len - 1) / (checked - 1) } else { 0 };
            if let Some(point) = self.point(place, &mut element) {
                check_law(self.law, &point)?;
            }
        }
        Ok(())
    }
}

/// Arrays of length 1 or of the common length, and that length.
pub(crate) fn columns_of<'a>(arrays: &'a [PyReadonlyArray1<'_, f64>]) -> PyResult<(Vec<&'a [f64]>, usize)> {
    let values: Vec<&[f64]> = arrays.iter().map(|array| array.as_slice()).collect::<Result<_, _>>()?;
    let len = values.iter().map(|values| values.len()).find(|&len| len != 1).unwrap_or(1);
    if values.iter().any(|values| values.len() != 1 && values.len() != len) {
        return Err(PyValueError::new_err("arrays of different lengths"));
    }
    Ok((values, len))
}

/// Applies `each` to tasks of consecutive elements, in parallel for many, or where `progress` is told.
pub(crate) fn in_tasks<T: Send>(
    py: Python<'_>,
    len: usize,
    threads: Option<usize>,
    progress: Option<&Py<PyAny>>,
    each: impl Fn(std::ops::Range<usize>) -> Vec<T> + Sync,
) -> PyResult<Vec<T>> {
    if len <= FEW && progress.is_none() {
        return Ok(py.detach(|| each(0..len)));
    }
    run(py, threads, progress, |steering: &Steering| {
        let tasks = len.div_ceil(TASK);
        let done: Vec<Vec<T>> = (0..tasks)
            .into_par_iter()
            .map(|task| match steering.stopped() {
                true => Vec::new(),
                false => {
                    let done = each(task * TASK..((task + 1) * TASK).min(len));
                    steering.advance(done.len());
                    done
                }
            })
            .collect();
        done.into_iter().flatten().collect()
    })
}

/// Critical damping, NaN where none is known to 1 %, and its error estimate, NaN where none was found. By the
/// comparison lemma an error of the law's weakening rate moves epsilon c* by at most that error.
#[pyfunction]
#[pyo3(signature = (law, arrays, tolerance, threads=None, progress=None))]
pub(crate) fn critical_c<'py>(
    py: Python<'py>,
    law: &Law,
    arrays: Vec<PyReadonlyArray1<'py, f64>>,
    tolerance: f64,
    threads: Option<usize>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
    check_tolerance(tolerance)?;
    let family = &law.law;
    let law_error = law.error();
    let arguments = Arguments::new(py, family, &arrays)?;
    let found = in_tasks(py, arguments.len, threads, progress.as_ref(), |task| {
        let mut element = Vec::new();
        let mut columns: Vec<Column> = Vec::with_capacity(task.len());
        let mut known = Vec::with_capacity(task.len());
        for i in task {
            let point = arguments.point(i, &mut element);
            known.push(point.is_some());
            columns.extend(point.map(|point| family.column(&point)));
        }
        let mut answers = critical_dampings(&columns, tolerance).into_iter();
        let mut epsilons = columns.iter().map(|column| column.epsilon);
        let answer = |known: bool| {
            let epsilon = known.then(|| epsilons.next()).flatten()?;
            let found = answers.next()?.ok()?;
            let found = CriticalDamping { error: found.error + law_error / epsilon, ..found };
            Some((found.known().map_or(f64::NAN, |known| known.c), found.error))
        };
        known.into_iter().map(answer).map(|it| it.unwrap_or((f64::NAN, f64::NAN))).collect()
    })?;
    let (values, errors): (Vec<f64>, Vec<f64>) = found.into_iter().unzip();
    Ok((PyArray1::from_vec(py, values), PyArray1::from_vec(py, errors)))
}

/// Elements that share all parameters but the damping, with their dampings, which grow.
struct Group {
    point: Point,
    elements: Vec<(usize, f64)>,
}

/// Verdict codes, one row per method; `not_computed` where an argument is NaN.
#[pyfunction]
#[pyo3(signature = (law, arrays, methods, tolerance, threads=None))]
pub(crate) fn verdicts<'py>(
    py: Python<'py>,
    law: &Law,
    arrays: Vec<PyReadonlyArray1<'py, f64>>,
    methods: Vec<String>,
    tolerance: f64,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray2<i8>>> {
    check_tolerance(tolerance)?;
    let family = &law.law;
    let arguments = Arguments::new(py, family, &arrays)?;
    let methods: Vec<Method> = methods.iter().map(|name| method(name)).collect::<PyResult<_>>()?;
    let groups = py.detach(|| groups(&arguments));
    let decide_group = |group: &Group| -> Vec<Vec<i8>> {
        let column = family.column(&group.point);
        let dampings: Vec<f64> = group.elements.iter().map(|(_, damping)| *damping).collect();
        methods.iter().map(|method| of_method(method, &column, &dampings, tolerance)).collect()
    };
    let decided = if groups.len() <= 1 && arguments.len <= FEW {
        py.detach(|| groups.iter().map(decide_group).collect::<Vec<_>>())
    } else {
        run(py, threads, None, |steering| {
            let each = |group: &Group| match steering.stopped() {
                true => Vec::new(),
                false => decide_group(group),
            };
            groups.par_iter().map(each).collect::<Vec<_>>()
        })?
    };
    let mut codes = vec![vec![Verdict::NotComputed.code(); arguments.len]; methods.len()];
    for (group, rows) in groups.iter().zip(decided) {
        for (row, verdicts) in codes.iter_mut().zip(rows) {
            for (&(i, _), code) in group.elements.iter().zip(verdicts) {
                row[i] = code;
            }
        }
    }
    Ok(PyArray2::from_vec2(py, &codes)?)
}

pub(crate) fn method(name: &str) -> PyResult<Method> {
    choose("method", name, Method::all(), |method| method.name())
}

/// Elements without a NaN, by column; within a column by growing damping.
fn groups(arguments: &Arguments<'_>) -> Vec<Group> {
    let mut known: HashMap<Vec<u64>, usize> = HashMap::new();
    let mut groups: Vec<Group> = Vec::new();
    let mut element = Vec::new();
    for i in 0..arguments.len {
        let Some(point) = arguments.point(i, &mut element) else { continue };
        element.pop();
        let key = element.iter().map(|value| value.to_bits()).collect();
        let group = *known.entry(key).or_insert_with(|| {
            groups.push(Group { point, elements: Vec::new() });
            groups.len() - 1
        });
        groups[group].elements.push((i, point.damping));
    }
    for group in &mut groups {
        group.elements.sort_by(|(_, one), (_, other)| one.total_cmp(other));
    }
    groups
}

/// The verdict codes of a method on a column at increasing dampings.
fn of_method(method: &Method, column: &Column, dampings: &[f64], tolerance: f64) -> Vec<i8> {
    let each = |verdict: &dyn Fn(&Oscillator) -> Verdict| {
        dampings.iter().map(|&c| verdict(&Oscillator::in_column(column, c)).code()).collect()
    };
    match method {
        Method::Test(test) => {
            let claim = test.claim(column);
            dampings.iter().map(|&c| Verdict::from(claim.decide(c)).code()).collect()
        }
        Method::Simulation => {
            decide(std::slice::from_ref(column), dampings, tolerance).into_iter().map(Verdict::code).collect()
        }
        Method::Direct => {
            each(&|oscillator| Verdict::from(&witness::decisive_flow(oscillator, tolerance).fate))
        }
        Method::Naive(naive, knobs) => each(&|oscillator| naive.decide(oscillator, knobs).verdict.into()),
    }
}

/// Regime codes; `failed` where an argument is NaN.
#[pyfunction]
#[pyo3(signature = (law, arrays, tolerance, threads=None))]
pub(crate) fn regime<'py>(
    py: Python<'py>,
    law: &Law,
    arrays: Vec<PyReadonlyArray1<'py, f64>>,
    tolerance: f64,
    threads: Option<usize>,
) -> PyResult<Bound<'py, PyArray1<i8>>> {
    check_tolerance(tolerance)?;
    let family = &law.law;
    let arguments = Arguments::new(py, family, &arrays)?;
    let codes = arguments.each(py, threads, &Regime::Failed.code(), |point| {
        let oscillator = Oscillator::new(family, point);
        regime_of(&oscillator, &flow(&oscillator, tolerance)).code()
    })?;
    Ok(PyArray1::from_vec(py, codes))
}

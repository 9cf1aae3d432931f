//! Machines in SI units.

use std::collections::HashMap;
use std::path::Path;
use std::time::Duration;

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyNotImplementedError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use slipmap::assessment::{StandardErrors, assess_fitted, with_errors};
use slipmap::behaviour::behaviour;
use slipmap::column::critical::{NoCriticalDamping, critical_dampings};
use slipmap::column::{Method, Regime, long_run};
use slipmap::config::{conversion, load_machine, machine_of};
use slipmap::filippov::Oscillator;
use slipmap::friction::{Column, Expression, Law as Family};
use slipmap::machine::{self as engine, Coefficients, Friction, Model, Motion, NORMAL_FORCE, RADIUS};
use slipmap::map::{Grid, Shown};
use slipmap::orbits::flow;
use slipmap::probe::{Answer, MachineResult, Probe};
use slipmap::risk::{NoRisk, Spread, Uncertain, is_uncertain, risk, uncertain_critical_damping};
use slipmap_explore::{Engine, Start, WASM, page};
use slipmap_page::{MachinePage, Subject, to_json};

use crate::columns::{columns_of, in_tasks};
use crate::law::{Law, motion_of, of_wrong};
use crate::point::{check_tolerance, json};
use crate::work::run;

/// A machine with the distributions of its uncertain quantities.
#[pyclass(frozen, module = "slipmap._core")]
pub(crate) struct Machine {
    machine: engine::Machine,
    uncertain: Vec<Uncertain>,
    /// The units in which its numbers were written.
    written: Vec<(&'static str, Option<Shown>)>,
}

/// A number in SI units, or text with a unit, written as in a configuration.
#[derive(FromPyObject)]
enum Written {
    Number(f64),
    Text(String),
}

impl std::fmt::Debug for Written {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Written::Number(number) => number.fmt(to),
            Written::Text(text) => text.fmt(to),
        }
    }
}

/// The value and the standard deviation of a text such as `12 bar +- 10 %`.
#[pyfunction]
pub(crate) fn with_deviation(text: &str) -> Option<(String, String)> {
    slipmap::config::with_deviation(text)
}

/// A percentage, over 100.
#[pyfunction]
pub(crate) fn share(text: &str) -> Option<f64> {
    slipmap::config::share(text)
}

/// A spread as Python has it: a standard deviation, both ends of a range, or the row of correlated errors.
type Numbers = Vec<f64>;

fn spread_of(numbers: &[f64]) -> Option<Spread> {
    match *numbers {
        [sd] => Some(Spread::Normal { sd }),
        [min, max] => Some(Spread::Uniform { min, max }),
        _ => Some(Spread::Joint { row: numbers.try_into().ok()? }),
    }
}

/// Refuses a law that is not the friction of a machine.
fn check_friction(law: &Family) -> PyResult<()> {
    match law.as_written() {
        Family::Expression(_) | Family::Table(_) => Ok(()),
        law if Family::BUILT_IN.map(Family::with_exponent).contains(&law.clone().with_exponent()) => Ok(()),
        law => Err(PyValueError::new_err(format!(
            "friction: a machine has the friction of a built-in law, a formula or a table, not of {} with more",
            law.name()
        ))),
    }
}

impl Machine {
    fn model(&self) -> PyResult<Model> {
        let leaves = || {
            PyValueError::new_err("the friction leaves the numbers in dimensionless terms; check the units")
        };
        self.machine.model().ok_or_else(leaves)
    }
}

/// A machine with other values of some quantities, element by element.
struct Elements<'a> {
    machine: &'a engine::Machine,
    names: &'a [String],
    values: Vec<&'a [f64]>,
    len: usize,
}

impl<'a> Elements<'a> {
    /// Refuses what is no quantity of the machine, or no legal value.
    fn new(
        py: Python<'_>,
        machine: &'a engine::Machine,
        names: &'a [String],
        arrays: &'a [PyReadonlyArray1<'_, f64>],
        threads: Option<usize>,
    ) -> PyResult<Self> {
        let (values, len) = columns_of(arrays)?;
        let known = |name: &String| match machine.with(name, 1.0) {
            Some(_) if name == NORMAL_FORCE && !machine.normal_force_is_known => Err(PyValueError::new_err(
                "the friction of this machine is a force already: leave the normal force out\n  help: friction divided by \
                 the normal force at which it was measured is a coefficient, which has any normal force",
            )),
            Some(_) => Ok(()),
            None => Err(PyTypeError::new_err(format!("`{name}` is no quantity of this machine"))),
        };
        names.iter().try_for_each(known)?;
        let all = Self { machine, names, values, len };
        let illegal = in_tasks(py, len, threads, None, |mut task| {
            let first = task.find_map(|i| Some((i, all.at(i).as_ref()?.illegal()?)));
            first.into_iter().collect()
        })?;
        match illegal.first() {
            Some((i, (name, value, wanted))) => {
                Err(PyValueError::new_err(format!("{name} (element {i}) = {value}: must be {wanted}")))
            }
            None => Ok(all),
        }
    }

    /// The machine of an element; `None` where a number is NaN.
    fn at(&self, i: usize) -> Option<engine::Machine> {
        let mut machine = self.machine.clone();
        for (name, values) in self.names.iter().zip(&self.values) {
            let value = if values.len() == 1 { values[0] } else { values[i] };
            if value.is_nan() {
                return None;
            }
            machine = machine.with(name, value)?;
        }
        Some(machine)
    }
}

#[pymethods]
impl Machine {
    /// A machine of the numbers `quantities`; `uncertain` has the spread of some.
    /// Without a normal force, friction is a force.
    #[new]
    fn new(
        law: &Law,
        motion: &str,
        quantities: HashMap<String, f64>,
        uncertain: Vec<(String, Numbers)>,
        written: HashMap<String, (String, f64)>,
    ) -> PyResult<Self> {
        let motion = motion_of(motion)?;
        check_friction(&law.law)?;
        // That of a disc is no quantity.
        let disc = quantities.get(RADIUS).copied().filter(|_| motion == Motion::Translation);
        let value = |name: &str| quantities.get(name).copied().filter(|_| disc.is_none() || name != RADIUS);
        let law = match (value(Coefficients::EXPONENT), law.law.as_written()) {
            (Some(_), _) => law.law.clone().with_exponent(),
            // A fit is in units of its own value at rest; the formula of a machine is the coefficient itself.
            (None, Family::Expression(formula)) if !formula.may_drop() && formula.static_level() != 1.0 => {
                let formula = Expression::new(&formula.text(), 1.0);
                Family::Expression(formula.map_err(|error| PyValueError::new_err(error.problem))?)
            }
            (None, _) => law.law.clone(),
        };
        let names = engine::Machine::names(&law, |name| value(name).is_some());
        let missing = names.iter().find(|name| **name != NORMAL_FORCE && value(name).is_none());
        if let Some(missing) = missing {
            let remedy = match *missing {
                "stribeck_velocity" => ", or friction=Law.coulomb(), which drops as slip begins",
                _ => "",
            };
            return Err(PyTypeError::new_err(format!("the machine also needs {missing}{remedy}")));
        }
        let is_known = |name: &str| names.contains(&name) || disc.is_some() && name == RADIUS;
        if let Some(unknown) = quantities.keys().find(|name| !is_known(name)) {
            let of = law.name();
            let known = names.join(", ");
            return Err(PyTypeError::new_err(format!(
                "`{unknown}` is no quantity of a machine of the law `{of}` beside the others; it has: {known}"
            )));
        }
        let formula = match law.as_written() {
            Family::Expression(formula) => formula.text().into_owned(),
            _ => String::new(),
        };
        let mut machine = machine_of(motion, &law, value, value).map_err(|wrong| match value(wrong.key) {
            Some(given) => PyValueError::new_err(format!("{} = {given}: {}", wrong.key, wrong.problem)),
            None => of_wrong(&wrong, &formula),
        })?;
        machine.given = machine.given.on_disc(disc);
        // In the order given, which is that of the random numbers.
        let spread = |(name, numbers): &(String, Numbers)| {
            Some((names.iter().copied().find(|known| known == name)?, spread_of(numbers)?))
        };
        let uncertain = uncertain.iter().filter_map(spread).collect();
        let written = names.into_iter().filter_map(|name| {
            let (unit, size) = written.get(name)?.clone();
            Some((name, Some(Shown { unit, size })))
        });
        let written = written.collect();
        Ok(Self { machine, uncertain, written })
    }

    /// The machine of a configuration, with other values of some quantities.
    #[staticmethod]
    fn from_toml(path: &str, values: Vec<(String, Written)>) -> PyResult<Self> {
        let job = load_machine(Path::new(path), &values)
            .map_err(|error| PyValueError::new_err(error.to_string()))?;
        if let Some((name, values)) = job.varied.first() {
            let (count, first) = (values.len(), values[0]);
            return Err(PyValueError::new_err(format!(
                "{path}: {name} has {count} values; choose one, for example {name}={first}"
            )));
        }
        Ok(Self { machine: job.machine, uncertain: job.uncertain, written: job.units })
    }

    #[getter]
    fn motion(&self) -> &'static str {
        self.machine.motion.name()
    }

    /// Its friction as a law, of the slip speed in SI units.
    #[getter]
    fn friction(&self) -> Law {
        Law { law: self.machine.law() }
    }

    /// Its numbers; the normal force only if it is known.
    #[getter]
    fn quantities(&self) -> Vec<(&'static str, f64)> {
        let disc = self.machine.given.disc().map(|radius| (RADIUS, radius));
        self.machine.quantities().into_iter().chain(disc).collect()
    }

    /// Whether its friction is a force, since no normal force is known.
    #[getter]
    fn holds_forces(&self) -> bool {
        !self.machine.normal_force_is_known
    }

    /// The units in which its numbers were written, with their sizes in SI, as the constructor takes them.
    #[getter]
    fn written(&self) -> HashMap<&'static str, (String, f64)> {
        let shown = |(name, shown): &(&'static str, Option<Shown>)| {
            let Shown { unit, size } = shown.clone()?;
            Some((*name, (unit, size)))
        };
        self.written.iter().filter_map(shown).collect()
    }

    /// The uncertain quantities, as the constructor takes them.
    #[getter]
    fn uncertain(&self) -> Vec<(&'static str, Numbers)> {
        let numbers = |spread: &Spread| match *spread {
            Spread::Normal { sd } | Spread::Relative { sd } => vec![sd],
            Spread::Uniform { min, max } => vec![min, max],
            Spread::Joint { row } => row.to_vec(),
        };
        self.uncertain.iter().map(|(name, spread)| (*name, numbers(spread))).collect()
    }

    /// What the program tells of what it read: other units in SI, and how measured friction was understood.
    #[getter]
    fn notes(&self) -> Vec<String> {
        let mut notes = Vec::new();
        for (name, shown) in &self.written {
            let told = shown.as_ref().map(|of| conversion(&of.unit, of.size, self.machine.unit(name)));
            notes.extend(told.filter(|told| !notes.contains(told)));
        }
        if let Friction::Measured(table) = &self.machine.friction {
            notes.extend(table.source().told.clone());
        }
        notes
    }

    /// What the program would warn of: numbers that suggest other units.
    #[getter]
    fn doubts(&self) -> Vec<String> {
        self.machine.doubts()
    }

    /// The dimensionless law, the point (epsilon, the law's parameters, V, c), and the units of time, length, velocity,
    /// force and damping.
    fn point(&self) -> PyResult<(Law, Vec<f64>, [f64; 5])> {
        let Model { law, point, si } = self.model()?;
        let values = std::iter::once(point.epsilon)
            .chain(point.law.as_slice().iter().copied())
            .chain([point.belt_speed, point.damping]);
        let units = [si.time, si.length, si.velocity, si.force, si.damping];
        Ok((Law { law }, values.collect(), units))
    }

    /// What `slipmap probe --machine --json` prints.
    fn probe(&self, py: Python<'_>, tolerance: f64) -> PyResult<String> {
        check_tolerance(tolerance)?;
        let model = self.model()?;
        let probe = run(py, None, None, |_| {
            let (answer, direct) =
                Answer::of_both_engines(&model.law, &model.point, tolerance, Method::all());
            let mut probe = Probe::new(&answer, &direct);
            let behaviour = behaviour(&model, tolerance);
            let errors = StandardErrors::of_dampings(&self.machine, &self.uncertain);
            probe.machine = Some(MachineResult::new(&self.machine, &behaviour, errors.as_ref()));
            probe
        })?;
        json(&probe)
    }

    /// Where quantities have other values: the code of the regime, the kicks of steady slip with the belt and against it,
    /// and the damping below which steady slip is unstable. A kick is 0 where none is needed, infinite where none starts a
    /// vibration, and NaN where it is not known. Only the last is found where not `all`.
    #[allow(clippy::too_many_arguments)] // those of the Python interface
    fn behaviour<'py>(
        &self,
        py: Python<'py>,
        names: Vec<String>,
        arrays: Vec<PyReadonlyArray1<'py, f64>>,
        all: bool,
        tolerance: f64,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyArray1<i8>>, Vec<Bound<'py, PyArray1<f64>>>)> {
        check_tolerance(tolerance)?;
        let elements = Elements::new(py, &self.machine, &names, &arrays, threads)?;
        let unknown = (Regime::Failed.code(), [f64::NAN; 3]);
        let one = |i: usize| {
            let Some(Model { law, point, si }) = elements.at(i).and_then(|machine| machine.model()) else {
                return unknown;
            };
            let column = law.column(&point);
            let unstable_below = column.curve.weakening(column.belt_speed) / column.epsilon * si.damping;
            if !all {
                return (Regime::Failed.code(), [f64::NAN, f64::NAN, unstable_below]);
            }
            let oscillator = Oscillator::new(&law, &point);
            let found = long_run(&oscillator, &flow(&oscillator, tolerance), tolerance);
            let [forward, backward] = match (&found.basin, found.regime) {
                (Some(basin), _) => [basin.kick.forward, basin.kick.backward].map(|kick| kick * si.velocity),
                (None, Regime::Failed | Regime::Neutral) => [f64::NAN; 2],
                (None, Regime::Equilibrium) => [f64::INFINITY; 2],
                (None, regime) if !regime.attractors().equilibrium => [0.0; 2],
                (None, _) => [f64::NAN; 2],
            };
            (found.regime.code(), [forward, backward, unstable_below])
        };
        let found = in_tasks(py, elements.len, threads, progress.as_ref(), |task| task.map(one).collect())?;
        let column = |k: usize| PyArray1::from_vec(py, found.iter().map(|(_, numbers)| numbers[k]).collect());
        let codes = found.iter().map(|(code, _)| *code).collect();
        Ok((PyArray1::from_vec(py, codes), (0..3).map(column).collect()))
    }

    /// The probability that it may stick-slip, and the dampings that make it rare, as JSON.
    fn risk(
        &self,
        py: Python<'_>,
        draws: Option<usize>,
        rare: Vec<f64>,
        seconds: Option<f64>,
    ) -> PyResult<String> {
        let time = seconds.map(Duration::try_from_secs_f64).transpose();
        let time =
            time.map_err(|_| PyValueError::new_err(format!("seconds = {seconds:?}: must be at least 0")))?;
        if !is_uncertain(&self.machine, &self.uncertain) {
            return Err(PyValueError::new_err(
                "nothing of the machine is uncertain; give quantities as {\"value\": 2.0, \"sd\": 0.1} or {\"min\": 1.8, \"max\": 2.2}",
            ));
        }
        let found = run(py, None, None, |_| risk(&self.machine, &self.uncertain, draws, &rare, time))?;
        let found = found.map_err(|why| PyValueError::new_err(why.to_string()))?;
        json(&found)
    }

    /// The page: as HTML, and what `slipmap machine --json` prints.
    fn page(
        &self,
        py: Python<'_>,
        title: &str,
        draws: Option<usize>,
        rare: Vec<f64>,
    ) -> PyResult<(String, String)> {
        self.model()?;
        let source = concat!("slipmap ", env!("CARGO_PKG_VERSION"));
        let made = run(py, None, None, |_| {
            let all =
                assess_fitted(&self.machine, &self.uncertain).ok_or("the friction leaves the numbers")?;
            let uncertain = is_uncertain(&self.machine, &self.uncertain);
            let found = uncertain.then(|| risk(&self.machine, &self.uncertain, draws, &rare, None));
            let risk = match found.transpose() {
                Ok(found) => found,
                // The rest of the page does not depend on it.
                Err(NoRisk::NoneFound | NoRisk::NoneFollowed) => None,
                Err(why) => return Err(why.to_string()),
            };
            let subject = Subject {
                title,
                uncertain: &self.uncertain,
                units: &self.written,
                speeds: None,
                risk: risk.as_ref(),
                source,
            };
            let html = MachinePage::html(&[MachinePage::new(&all, &subject)]);
            Ok((html, to_json(&all, risk.as_ref()).to_string()))
        })?;
        made.map_err(PyValueError::new_err)
    }

    /// The explorer that begins with the machine: a document that computes in the browser.
    fn explorer(&self, title: &str) -> PyResult<String> {
        self.model()?;
        if WASM.is_empty() {
            let why = "this package was built without its part for browsers\n  help: `rustup target add \
                       wasm32-unknown-unknown`, and build it by scripts/wheel";
            return Err(PyNotImplementedError::new_err(why));
        }
        let grid = Grid::of_machine(&self.machine, &[]);
        let grid = grid.map_err(|why| PyValueError::new_err(why.to_string()))?;
        Ok(page(&Start::of(&grid, title, &self.written, &self.uncertain), Engine::Browser))
    }

    /// Critical damping coefficients and the estimates of their errors, as `critical_c` gives them, where the quantities
    /// of these names have other values; and the first element without one, with the reason. The errors are the standard
    /// errors by measured or fitted friction, where these are asked for and larger than those of the computation.
    #[pyo3(signature = (names, arrays, tolerance, by_friction, threads=None, progress=None))]
    #[allow(clippy::too_many_arguments)] // as in map.rs
    fn critical_damping<'py>(
        &self,
        py: Python<'py>,
        names: Vec<String>,
        arrays: Vec<PyReadonlyArray1<'py, f64>>,
        tolerance: f64,
        by_friction: bool,
        threads: Option<usize>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>, Option<(usize, String)>)> {
        check_tolerance(tolerance)?;
        let elements = Elements::new(py, &self.machine, &names, &arrays, threads)?;
        let len = elements.len;
        let machine_at = |i: usize| elements.at(i);
        // A quantity that is given has no error of the fit.
        let is_left = |(name, _): &&Uncertain| !names.iter().any(|given| given == name);
        let uncertain: Vec<Uncertain> = self.uncertain.iter().filter(is_left).copied().collect();
        let error_of = |machine: &engine::Machine| {
            let Friction::Measured(table) = &machine.friction else {
                return uncertain_critical_damping(machine, &uncertain);
            };
            let friction = Friction::Measured(with_errors(table)?.0);
            uncertain_critical_damping(&engine::Machine { friction, ..machine.clone() }, &[])
        };
        // Value, error, and the reason where there is no value though all numbers are given.
        type Answer = (f64, f64, Option<String>);
        let found = in_tasks(py, len, threads, progress.as_ref(), |task| {
            let models: Vec<Option<Model>> = task.clone().map(|i| machine_at(i)?.model()).collect();
            let columns: Vec<Column> = models.iter().flatten().map(Model::column).collect();
            let mut answers = critical_dampings(&columns, tolerance).into_iter();
            let answer = |(i, model): (usize, Option<Model>)| -> Option<Answer> {
                let Some(Model { si, .. }) = model else {
                    let machine = machine_at(i)?;
                    let words = machine.words_of_friction();
                    return Some((
                        f64::NAN,
                        f64::NAN,
                        Some(format!("the {words} leaves the numbers; check the units")),
                    ));
                };
                let unit = si.damping;
                let found = match answers.next()? {
                    Ok(found) => found,
                    Err(why) => return Some((f64::NAN, f64::NAN, Some(why.to_string()))),
                };
                let of_friction =
                    machine_at(i).filter(|_| by_friction).and_then(|machine| error_of(&machine));
                let error = of_friction.map_or(0.0, |of| of.standard_error).max(found.error * unit);
                match found.known() {
                    Ok(known) => Some((known.c * unit, error, None)),
                    Err(NoCriticalDamping::Inaccurate { error: off }) => {
                        let why = NoCriticalDamping::Inaccurate { error: off * unit };
                        Some((f64::NAN, error, Some(why.to_string())))
                    }
                    Err(why) => Some((f64::NAN, error, Some(why.to_string()))),
                }
            };
            task.zip(models).map(answer).map(|it| it.unwrap_or((f64::NAN, f64::NAN, None))).collect()
        })?;
        let unknown = found.iter().enumerate().find_map(|(i, (.., why))| Some((i, why.clone()?)));
        let (values, errors): (Vec<f64>, Vec<f64>) =
            found.into_iter().map(|(value, error, _)| (value, error)).unzip();
        Ok((PyArray1::from_vec(py, values), PyArray1::from_vec(py, errors), unknown))
    }
}

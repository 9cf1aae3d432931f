//! Friction laws.

use numpy::{PyArray1, PyReadonlyArray1};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use slipmap::config::{self, About, LawText, Level, Origin, Wrong, number_in, size, size_on_disc, with_unit};
use slipmap::friction::{Function, Law as Family, PointError};
use slipmap::machine::{Coefficients, DAMPING_RATIO, Dimension, Motion, Normal, unit};
use slipmap::point::{LawParameters, MAX_LAW_PARAMETERS, Point};

/// A family of friction laws; its parameters are given at every call.
#[pyclass(frozen, module = "slipmap._core")]
pub(crate) struct Law {
    pub(crate) law: Family,
}

#[pymethods]
impl Law {
    /// The law of this name: "stribeck", "exponential", "lorentzian" or "coulomb".
    #[staticmethod]
    fn built_in(name: &str) -> PyResult<Self> {
        Ok(Self { law: choose("law", name, Family::BUILT_IN, |law| law.name())? })
    }

    /// A law given as a formula.
    #[staticmethod]
    fn expression(formula: &str, static_level: Option<f64>, at_peak: bool) -> PyResult<Self> {
        let text = LawText { name: "expression".into(), phi: Some(formula.into()), ..LawText::default() };
        made(text, static_level, at_peak)
    }

    /// A law given by data.
    #[staticmethod]
    fn table(
        u: PyReadonlyArray1<'_, f64>,
        friction: PyReadonlyArray1<'_, f64>,
        errors: Option<PyReadonlyArray1<'_, f64>>,
        static_level: Option<f64>,
        at_peak: bool,
        origin: &str,
    ) -> PyResult<Self> {
        let mut rows: Vec<Vec<f64>> =
            u.as_array().iter().zip(friction.as_array()).map(|(u, friction)| vec![*u, *friction]).collect();
        if let Some(errors) = errors {
            rows.iter_mut().zip(errors.as_array()).for_each(|(row, error)| row.push(*error));
        }
        let source = Some(Origin { file: origin.into(), ..Origin::default() });
        // In units of friction at rest: of the first row.
        let first = rows.first().map(|row| row[1]).filter(|level| !at_peak && *level > 0.0);
        let level = static_level.or(first);
        let text = LawText { name: "table".into(), rows: Some(rows), source, ..LawText::default() };
        made(text, level, at_peak)
    }

    /// Whether the law is a table with standard errors.
    #[getter]
    fn has_standard_errors(&self) -> bool {
        matches!(&self.law, Family::Table(table) if table.standard_errors().is_some())
    }

    /// A law given as a function of the slip speed, sampled once up to `fastest`.
    #[staticmethod]
    fn function(
        function: &Bound<'_, PyAny>,
        fastest: f64,
        corners: Vec<f64>,
        origin: &str,
    ) -> PyResult<Self> {
        let mut raised = None;
        let number = |value: Bound<'_, PyAny>| {
            let problem =
                || format!("the function gives {value}, and one number is needed at each slip speed");
            value.extract::<f64>().map_err(|_| PyTypeError::new_err(problem()))
        };
        let call = |u: f64| match function.call1((u,)).and_then(number) {
            Ok(value) => value,
            Err(error) => {
                // The first error is the one that is raised; NaN ends the sampling soon.
                raised.get_or_insert(error);
                f64::NAN
            }
        };
        let law = Function::new(origin, call, fastest, &corners);
        match (raised, law) {
            (Some(error), _) => Err(error),
            (None, Err(error)) => Err(PyValueError::new_err(error.to_string())),
            (None, Ok(law)) => Ok(Self { law: Family::Function(law) }),
        }
    }

    /// How far the weakening rate may be from that of the function that was sampled; 0 for other laws.
    #[getter]
    pub(crate) fn error(&self) -> f64 {
        match &self.law {
            Family::Function(law) => law.error(),
            _ => 0.0,
        }
    }

    /// The exponential law with the parameter `exponent`.
    fn with_exponent(&self) -> Self {
        Self { law: self.law.clone().with_exponent() }
    }

    /// The law with the parameter `drop`.
    fn with_drop(&self) -> PyResult<Self> {
        if self.law.parameters().len() >= MAX_LAW_PARAMETERS && !self.law.may_drop() {
            return Err(PyValueError::new_err("the law has no room for another parameter"));
        }
        Ok(Self { law: self.law.clone().with_drop() })
    }

    /// The law read as 1 + eps F(u).
    fn read_as_small(&self) -> Self {
        Self { law: self.law.clone().read_as_small() }
    }

    #[getter]
    fn is_read_as_small(&self) -> bool {
        self.law.is_read_as_small()
    }

    /// The law of a name and the definition that [`Law::definition`] gave.
    #[staticmethod]
    fn from_definition(name: &str, definition: &str) -> PyResult<Self> {
        let law = Family::from_definition(name, definition);
        let law = law.ok_or_else(|| PyValueError::new_err(format!("this defines no law `{name}`")))?;
        Ok(Self { law })
    }

    /// How to make the law again, for pickle.
    fn __reduce__<'py>(&self, py: Python<'py>) -> PyResult<(Bound<'py, PyAny>, (&'static str, String))> {
        let again = py.get_type::<Self>().getattr("from_definition")?;
        Ok((again, (self.name(), self.definition())))
    }

    #[getter]
    fn name(&self) -> &'static str {
        self.law.name()
    }

    #[getter]
    fn definition(&self) -> String {
        self.law.definition()
    }

    /// Name, description, least and greatest legal value of each parameter, and these in words.
    #[getter]
    fn parameters(&self) -> Vec<(&str, &str, f64, f64, String)> {
        self.law.parameters().iter().map(|it| (it.name, it.long_name, it.min, it.max, it.domain())).collect()
    }

    /// Whether epsilon matters: it is in the law, or the law is read by it.
    #[getter]
    fn needs_epsilon(&self) -> bool {
        self.law.depends_on_epsilon() || self.law.is_read_as_small()
    }

    /// What was understood of the file of a table; `None` where it needed no words, and for other laws.
    #[getter]
    fn told(&self) -> Option<&str> {
        match self.law.as_written() {
            Family::Table(table) => table.source().told.as_deref(),
            _ => None,
        }
    }

    /// The SI unit of a quantity of a machine with this friction: "" for a pure number, `None` for a name in a formula
    /// and for what is no quantity.
    fn unit_of(&self, quantity: &str, motion: &str, normal: &str) -> PyResult<Option<&'static str>> {
        let is_own = matches!(self.law.as_written(), Family::Expression(_))
            && self.law.parameters().iter().any(|parameter| parameter.name == quantity);
        let unit = unit(quantity, motion_of(motion)?, &self.law, normal_of(normal));
        let is_known =
            !unit.is_empty() || quantity == DAMPING_RATIO || Coefficients::NAMES.contains(&quantity);
        Ok(Some(unit).filter(|_| is_known && !is_own))
    }

    /// The number of such a quantity in SI units, of a text with its unit, and that unit; `radius` is that of a disc.
    fn number_of(
        &self,
        text: &str,
        quantity: &str,
        motion: &str,
        normal: &str,
        radius: Option<f64>,
    ) -> PyResult<(f64, String)> {
        let motion_is = motion_of(motion)?;
        if let (Some(radius), Some((number, unit))) = (radius, with_unit(text))
            && Dimension::of_quantity(quantity) == Some(Dimension::Velocity)
            && let Some(size) = size_on_disc(unit, motion_is, radius)
        {
            return Ok((number * size, unit.to_owned()));
        }
        let known = |si| match number_in(text, si) {
            Ok((number, unit)) => Ok((number, unit.to_owned())),
            Err(why) => Err(format!("{quantity}: {why}")),
        };
        let unknown = || format!("{quantity} = {text:?}: write a number");
        let unit = self.unit_of(quantity, motion, normal)?;
        // A parameter of a formula has the unit that it is written with.
        let of_formula = with_unit(text).filter(|_| unit.is_none());
        if let Some((number, unit, size)) =
            of_formula.and_then(|(number, unit)| Some((number, unit, size(unit)?)))
        {
            return Ok((number * size, unit.to_owned()));
        }
        unit.ok_or_else(unknown).and_then(known).map_err(PyValueError::new_err)
    }

    /// The law as a formula; `None` for data and functions.
    #[getter]
    fn formula(&self) -> Option<String> {
        match self.law.as_written() {
            Family::Expression(law) => Some(format!("\u{3c6}(u) = {}", law.text())),
            law => slipmap_page::formula::of_law(law).map(|formula| formula.plain),
        }
    }

    /// Names of the axes of a map of this law, slowest first.
    #[getter]
    fn axes(&self) -> Vec<&'static str> {
        self.law.axis_names()
    }

    /// phi and -phi' at the slip speeds `u`.
    fn evaluate<'py>(
        &self,
        py: Python<'py>,
        u: PyReadonlyArray1<'py, f64>,
        epsilon: f64,
        parameters: Vec<f64>,
    ) -> PyResult<(Bound<'py, PyArray1<f64>>, Bound<'py, PyArray1<f64>>)> {
        // At any belt speed and damping.
        legal_point(&self.law, &[&[epsilon], &parameters[..], &[1.0, 0.0]].concat(), String::new)?;
        let curve = self.law.curve(epsilon, &LawParameters::new(&parameters));
        let u = u.as_array();
        let phi: Vec<f64> = u.iter().map(|&u| curve.phi(u)).collect();
        let weakening: Vec<f64> = u.iter().map(|&u| curve.weakening(u)).collect();
        Ok((PyArray1::from_vec(py, phi), PyArray1::from_vec(py, weakening)))
    }
}

/// The one of `all` with this name.
pub(crate) fn choose<T>(
    kind: &str,
    name: &str,
    all: impl IntoIterator<Item = T>,
    name_of: impl Fn(&T) -> &str,
) -> PyResult<T> {
    let mut all: Vec<T> = all.into_iter().collect();
    let Some(found) = all.iter().position(|one| name_of(one) == name) else {
        let known: Vec<&str> = all.iter().map(name_of).collect();
        let problem = format!("there is no {kind} `{name}`; choose from: {}", known.join(", "));
        return Err(PyValueError::new_err(problem));
    };
    Ok(all.swap_remove(found))
}

/// The motion of this name.
pub(crate) fn motion_of(name: &str) -> PyResult<Motion> {
    Motion::ALL.into_iter().find(|motion| motion.name() == name).ok_or_else(|| {
        let names = Motion::ALL.map(|it| it.name()).join(", ");
        PyValueError::new_err(format!("motion: there is no motion `{name}`; choose from: {names}"))
    })
}

/// Where the normal force of a machine is, by its name in Python.
fn normal_of(name: &str) -> Normal {
    match name {
        "at_radius" => Normal::AtRadius,
        "in_friction" => Normal::InFriction,
        _ => Normal::Alone,
    }
}

/// The friction at rest of a law.
pub(crate) fn level(given: Option<f64>, at_peak: bool) -> PyResult<Level> {
    match given {
        Some(level) if level > 0.0 && level.is_finite() => Ok(Level::Given(level)),
        Some(level) => {
            let problem = "the friction at slip speed 0 must be greater than 0";
            Err(PyValueError::new_err(format!("static = {level}: {problem}")))
        }
        None if at_peak => Ok(Level::Peak),
        None => Ok(Level::First),
    }
}

/// The law that is described.
fn made(text: LawText, static_level: Option<f64>, at_peak: bool) -> PyResult<Law> {
    let text = LawText { static_level, rest: at_peak.then(|| "peak".to_owned()), ..text };
    let wrong = |wrong: Wrong| of_wrong(&wrong, text.phi.as_deref().unwrap_or_default());
    Ok(Law { law: text.law(About::Oscillator).map_err(wrong)? })
}

/// What is wrong, with its key, and the remedy.
pub(crate) fn of_wrong(wrong: &Wrong, formula: &str) -> PyErr {
    told((format!("{}: {}", wrong.key, wrong.words(formula)), wrong.remedy.clone()))
}

/// The point of values in the order of [`Law::axis_names`], `place` being where the caller has them.
pub(crate) fn legal_point(law: &Family, values: &[f64], place: impl Fn() -> String) -> PyResult<Point> {
    config::point_of(law, values).map_err(|error| {
        PyValueError::new_err(match error {
            PointError::OutOfDomain { name, value, domain } => {
                format!("{name}{} = {value}: it must be {domain}", place())
            }
            error @ PointError::ParameterCount { .. } => error.to_string(),
        })
    })
}

/// The point of values in the order of [`Law::axis_names`], at which the law is legal.
pub(crate) fn point_of(law: &Family, values: &[f64]) -> PyResult<Point> {
    let point = legal_point(law, values, String::new)?;
    check_law(law, &point)?;
    Ok(point)
}

/// Checks that the law is legal at the slip speeds of a point.
pub(crate) fn check_law(law: &Family, point: &Point) -> PyResult<()> {
    let formula = |law: &Family| match law.as_written() {
        Family::Expression(formula) => formula.text().into_owned(),
        _ => String::new(),
    };
    config::check_law(law, point).map_err(|wrong| told((wrong.words(&formula(law)), wrong.remedy)))
}

/// What is wrong, and the remedy.
pub(crate) fn told((problem, remedy): (String, String)) -> PyErr {
    PyValueError::new_err(format!("{problem}\n  help: {remedy}"))
}

const _: () = assert!(MAX_LAW_PARAMETERS == 8, "the stub file says 8");

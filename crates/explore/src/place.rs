//! The parameter point of a request: the friction law, and a value for each of its axes; or a machine in SI
//! units, whose quantities are the axes.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde_json::{Value, json};

use super::quantities;
use super::refusal::Refusal;
use slipmap_config::{Level, Measured, OfMachine, point_of};
use slipmap_machine::{BELT_SPEED, Coefficients, DAMPING, Dimension, Machine, Motion};
use slipmap_map::Shown;
use slipmap_model::friction::{Law, Table};
use slipmap_model::point::{MAX_LAW_PARAMETERS, Point};
use slipmap_page::units::UnitSystem;

/// Largest number of characters of a formula.
const LONGEST_FORMULA: usize = 4096;

/// A friction law as the page sends it.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(default)]
pub(super) struct LawText {
    /// One of [`Law::names`].
    name: String,
    /// The formula of the law `expression`.
    phi: String,
    /// The rows of the law `table`, as CSV.
    table: String,
    /// Name of the table's file.
    file: String,
    /// Friction at slip speed 0, by which formula and table are divided; 1 if there is none.
    #[serde(rename = "static")]
    static_level: Option<f64>,
    /// Whether it is read as 1 + eps F(u).
    pub(super) small: bool,
    /// Those of the parameters `exponent` and `drop` that a map of the law has; of a machine the quantities that stand
    /// in place of others, and the exponent.
    pub(super) axes: Vec<String>,
}

impl LawText {
    pub(super) fn law(&self) -> Result<Law, Refusal> {
        self.law_of(None)
    }

    /// The law; its table may be that of a machine.
    fn law_of(&self, machine: Option<OfMachine>) -> Result<Law, Refusal> {
        if let Some(level) = self.static_level.filter(|level| !(*level > 0.0 && level.is_finite())) {
            let problem = format!("the friction at rest is {level}; it must be greater than 0");
            return Err(Refusal::bad_input(problem, "write it in the units of the law"));
        }
        let built_in = Law::BUILT_IN.into_iter().find(|law| law.name() == self.name);
        let level = match self.static_level {
            Some(level) => Level::Given(level),
            None if machine.is_some() => Level::First,
            None => Level::One,
        };
        let law = match (self.name.as_str(), built_in) {
            (_, Some(law)) => law,
            ("expression", None) if self.phi.len() > LONGEST_FORMULA => {
                let problem = format!("the formula has more than {LONGEST_FORMULA} characters");
                return Err(Refusal::bad_input(problem, "give the law as a table"));
            }
            ("expression", None) => level.formula(&self.phi)?,
            ("table", None) => {
                let file = if self.file.is_empty() { "table" } else { &self.file };
                let table = Measured::of_bytes(file, self.table.as_bytes(), machine)
                    .and_then(|read| read.table(level));
                Law::Table(table.map_err(|(problem, remedy)| Refusal::bad_input(problem, remedy))?)
            }
            (name, None) => {
                let names: Vec<&str> = Law::names().collect();
                let problem = format!("there is no law `{name}`");
                return Err(Refusal::bad_input(problem, format!("choose from: {}", names.join(", "))));
            }
        };
        Ok(if self.small { law.read_as_small() } else { law })
    }

    /// The law of a machine: coefficients of friction, whatever they are at slip speed 0.
    pub(super) fn in_si_units(&self, motion: Motion) -> Result<Law, Refusal> {
        let plain = Self { static_level: None, ..self.clone() };
        let law = plain.law_of(Some(OfMachine { motion: Some(motion), forces: Some(false) }))?;
        quantities::check_names(&law)?;
        Ok(if plain.axes.iter().any(|name| name == Coefficients::EXPONENT) {
            law.with_exponent()
        } else {
            law
        })
    }
}

/// A law and a value for each of its axes, by name; with a motion, a machine in SI units. Other names are
/// ignored: they belong to the law that was shown before.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct Place {
    pub(super) law: LawText,
    pub(super) at: BTreeMap<String, f64>,
    /// The motion of a machine: then the law and the values are in SI units.
    #[serde(default)]
    pub(super) motion: Option<String>,
    /// The units of its figures, by quantity, where they are not those of SI: name and size.
    #[serde(default)]
    units: BTreeMap<String, (String, f64)>,
}

impl Place {
    /// The machine, if the place has a motion.
    pub(super) fn machine(&self) -> Result<Option<Machine>, Refusal> {
        let Some(motion) = &self.motion else { return Ok(None) };
        let motion = quantities::motion_of(motion)?;
        quantities::machine(&self.law.in_si_units(motion)?, motion, &self.law.axes, &self.at).map(Some)
    }

    /// The units of the numbers of its figures.
    pub(super) fn units(&self) -> Result<UnitSystem, Refusal> {
        let Some(machine) = self.machine()? else { return Ok(UnitSystem::default()) };
        let shown = [(Dimension::Velocity, BELT_SPEED), (Dimension::Damping, DAMPING)].into_iter();
        let shown = shown.filter_map(|(dimension, name)| {
            let (unit, size) = self.units.get(name)?.clone();
            Some((dimension, Shown { unit, size }))
        });
        Ok(UnitSystem::of_machine(machine.units()).shown_in(shown.collect()))
    }

    /// The dimensionless law and the values of its axes in their order, each legal. It has the parameters
    /// `exponent` and `drop` if they are `wanted` as axes, or are not what a law without them has.
    pub(super) fn read(&self, wanted: &[&str]) -> Result<(Law, Vec<f64>), Refusal> {
        if let Some(machine) = self.machine()? {
            let (law, values) = quantities::dimensionless(&machine)?;
            // Units that are far too large or small give numbers that are illegal for every law.
            point_of(&law, &values)?;
            return Ok((law, values));
        }
        let differs = |name: &str, from: f64| self.at.get(name).is_some_and(|value| *value != from);
        let law = with_all(self.law.law()?, |name| {
            let is_axis = self.law.axes.iter().any(|axis| axis == name) || wanted.contains(&name);
            is_axis || differs(name, if name == "drop" { 0.0 } else { 1.0 })
        });
        let value = |name: &&str| {
            let missing = || Refusal::malformed(format!("the law `{}` also needs {name}", law.name()));
            self.at.get(*name).copied().ok_or_else(missing)
        };
        let values = law.axis_names().iter().map(value).collect::<Result<Vec<f64>, Refusal>>()?;
        point_of(&law, &values)?;
        Ok((law, values))
    }

    /// The law and the point, at which the law is legal.
    pub(super) fn point(&self) -> Result<(Law, Point), Refusal> {
        let (law, values) = self.read(&[])?;
        let point = point_of(&law, &values)?;
        // The law of a machine has been checked in SI units.
        if self.motion.is_none() {
            check_law(&law, &point)?;
        }
        Ok((law, point))
    }
}

/// The law with the parameters `exponent` and `drop`, each if it is `wanted` and the law may have it.
pub(super) fn with_all(law: Law, wanted: impl Fn(&str) -> bool) -> Law {
    let law = if wanted("exponent") { law.with_exponent() } else { law };
    let may_drop = law.may_drop() || law.parameters().len() >= MAX_LAW_PARAMETERS;
    if wanted("drop") && !may_drop { law.with_drop() } else { law }
}

/// The values of a point by the names of the law's axes.
pub(super) fn at_json(law: &Law, point: &Point) -> Value {
    law.coordinates(&point).into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect()
}

/// Checks that the law is legal at a point for the slip speeds that every orbit and every test uses.
pub(super) fn check_law(law: &Law, point: &Point) -> Result<(), Refusal> {
    let fastest = 2.0 * point.belt_speed;
    match law.as_written() {
        Law::Expression(law) => Ok(law.check(point.epsilon, &point.law, fastest)?),
        Law::Table(table) => check_reach(table, fastest),
        _ => Ok(()),
    }
}

/// Checks that data reach to a slip speed, twice that of the belt.
pub(super) fn check_reach(table: &Table, fastest: f64) -> Result<(), Refusal> {
    let (origin, end) = (table.origin(), table.fastest());
    let problem =
        || format!("the data of {origin} end at slip speed {end}, below twice the belt speed: {fastest}");
    let remedy = "choose a lower belt speed, or measure farther";
    if end < fastest { Err(Refusal::bad_input(problem(), remedy)) } else { Ok(()) }
}

/// A law as the page sends it, the reverse of [`LawText::law`].
pub(super) fn law_json(law: &Law) -> Value {
    let mut object = json!({ "name": law.name() });
    match law.as_written() {
        Law::Expression(formula) => {
            object["phi"] = formula.text().into();
            object["static"] = formula.static_level().into();
        }
        Law::Table(table) => {
            let errors = table.standard_errors();
            let rows = table.data().enumerate().map(|(i, (u, friction))| match errors {
                Some(errors) => format!("{u},{friction},{}\n", errors[i]),
                None => format!("{u},{friction}\n"),
            });
            object["table"] = rows.collect::<String>().into();
            object["file"] = table.origin().into();
            object["static"] = table.static_level().into();
        }
        _ => {}
    }
    let axes = ["exponent", "drop"];
    object["axes"] = law.parameters().iter().map(|of| of.name).filter(|name| axes.contains(name)).collect();
    if law.is_read_as_small() {
        object["small"] = true.into();
    }
    object
}

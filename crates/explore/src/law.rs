//! A friction law as the page sends it, and back.

use serde::Deserialize;
use serde_json::{Value, json};

use super::refusal::Refusal;
use slipmap_config::{How, Kind, Level, Measured, OfMachine};
use slipmap_machine::{Coefficients, Motion};
use slipmap_model::friction::{Law, Table};

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
                let (rows, errors) = self.rows();
                let how = How { machine, kind: Some(Kind::Rows), ..How::default() };
                let table = Measured::of_bytes(file, rows.as_bytes(), how).and_then(|read| read.table(level));
                let table = table.map_err(|(problem, remedy)| Refusal::bad_input(problem, remedy))?;
                let table = match errors.last().map(Vec::len) {
                    None => Ok(table),
                    Some(1) => table.with_standard_errors(&errors.concat()),
                    Some(_) => table.with_root_of_covariance(errors),
                };
                Law::Table(table.map_err(|error| Refusal::bad_input(error.problem, error.remedy))?)
            }
            (name, None) => {
                let names: Vec<&str> = Law::names().collect();
                let problem = format!("there is no law `{name}`");
                return Err(Refusal::bad_input(problem, format!("choose from: {}", names.join(", "))));
            }
        };
        Ok(if self.small { law.read_as_small() } else { law })
    }

    /// The rows of the table, and the errors beside them as [`law_json`] writes them: that of each, or the root of their covariance,
    /// which has one number more in each row than in the row before.
    fn rows(&self) -> (String, Vec<Vec<f64>>) {
        let parts = |line: &str| line.split(',').map(|part| part.trim().parse().ok()).collect();
        let rows: Option<Vec<Vec<f64>>> = self.table.lines().map(parts).collect();
        let are_errors = |rows: &Vec<Vec<f64>>| {
            let is =
                |length: fn(usize) -> usize| rows.iter().enumerate().all(|(i, row)| row.len() == length(i));
            is(|_| 3) || is(|i| i + 3)
        };
        let Some(rows) = rows.filter(are_errors) else { return (self.table.clone(), Vec::new()) };
        let plain = rows.iter().map(|row| format!("{},{}\n", row[0], row[1])).collect();
        (plain, rows.into_iter().map(|row| row[2..].to_vec()).collect())
    }

    /// The law of a machine: coefficients of friction, whatever they are at slip speed 0.
    pub(super) fn in_si_units(&self, motion: Motion) -> Result<Law, Refusal> {
        let plain = Self { static_level: None, ..self.clone() };
        let law = plain.law_of(Some(OfMachine { motion: Some(motion), forces: Some(false) }))?;
        check_names(&law)?;
        Ok(if plain.axes.iter().any(|name| name == Coefficients::EXPONENT) {
            law.with_exponent()
        } else {
            law
        })
    }
}

/// Refuses a formula that uses the name of a quantity of the machine.
pub(super) fn check_names(law: &Law) -> Result<(), Refusal> {
    match law.as_written() {
        Law::Expression(formula) => Ok(slipmap_config::check_names(formula)?),
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
            object["table"] = table.rows().map(|row| row + "\n").collect::<String>().into();
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

#[cfg(test)]
mod tests {
    use super::*;

    /// The page sends a table back with the errors that it was sent, correlated or not.
    #[test]
    fn a_table_keeps_its_errors() {
        let data = [(0.0, 0.5), (0.1, 0.4), (0.4, 0.3), (0.9, 0.25)];
        let table = Table::new("a rig", &data, 0.5).unwrap();
        let root = (0..4).map(|i| (0..=i).map(|j| 1e-3 * f64::from(1 + 2 * i + j)).collect()).collect();
        for table in [
            table.with_standard_errors(&[1e-3, 2e-3, 1e-3, 4e-3]).unwrap(),
            table.with_root_of_covariance(root).unwrap(),
        ] {
            let sent: LawText = serde_json::from_value(law_json(&Law::Table(table.clone()))).unwrap();
            let Ok(Law::Table(again)) = sent.law() else { panic!("{}", sent.table) };
            assert_eq!(again.data().collect::<Vec<_>>(), data);
            assert_eq!(again.root_of_covariance(), table.root_of_covariance());
            assert_eq!(again.standard_errors(), table.standard_errors());
        }
    }
}

//! A friction law as it is written, whatever it is read from: the table `[friction]` of a configuration, options of
//! the command line, the page's JSON, or arguments of Python. One function makes the law of it, another writes a law
//! so that what is read again is the same law.

use serde::{Deserialize, Serialize};
use slipmap_machine::risk::{MOST_JOINT, Spread, Uncertain};
use slipmap_machine::{Machine, Motion};
use slipmap_model::friction::{Expression, ExpressionError, Law, Source, Table};
use slipmap_model::point::MAX_LAW_PARAMETERS;

use super::law::OF_MACHINE;
use super::measured::{How, Level, Measured, OfMachine};
use super::nearest;

/// What is wrong with something that was described.
#[derive(Clone, Debug, PartialEq)]
pub struct Wrong {
    /// The key of a configuration at which it is: of the friction, or a quantity of a machine.
    pub key: &'static str,
    /// What is wrong; that the key is missing where this is empty.
    pub problem: String,
    /// What to do instead.
    pub remedy: String,
    /// The place in a formula, from the first character to one past the last.
    pub place: Option<[usize; 2]>,
}

impl Wrong {
    pub(super) fn new(key: &'static str, problem: impl Into<String>, remedy: impl Into<String>) -> Self {
        Self { key, problem: problem.into(), remedy: remedy.into(), place: None }
    }

    pub(super) fn missing(key: &'static str, remedy: impl Into<String>) -> Self {
        Self::new(key, "", remedy)
    }

    /// The error of a formula.
    pub(super) fn in_formula(error: ExpressionError) -> Self {
        Self { place: Some([error.from, error.to]), ..Self::new("phi", error.problem, error.remedy) }
    }

    /// The problem; with its place marked in the formula in which it is.
    #[must_use]
    pub fn words(&self, formula: &str) -> String {
        match self.place {
            Some([from, to]) => {
                let (problem, remedy) = (self.problem.clone(), String::new());
                super::point_into(formula, &ExpressionError { from, to, problem, remedy })
            }
            None if self.problem.is_empty() => format!("`{}` is missing", self.key),
            None => self.problem.clone(),
        }
    }
}

/// What the numbers of a law are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum About {
    /// The dimensionless oscillator: phi(0) = 1.
    Oscillator,
    /// A machine with this motion, in SI units: a coefficient of friction or a force, with any value at rest.
    Machine(Motion),
}

/// A friction law as it is written. The fields are the keys of `[friction]`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct LawText {
    /// One of [`Law::names`].
    pub name: String,
    /// The formula of the law `expression`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub phi: Option<String>,
    /// Friction at rest.
    #[serde(rename = "static", skip_serializing_if = "Option::is_none")]
    pub static_level: Option<f64>,
    /// `peak` for the law beyond its first peak.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rest: Option<String>,
    /// The name of the file of the law `table`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// What is in it, where it was read by another program.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub table: Option<String>,
    /// The rows of the law `table` in place of a file: slip speed, friction, perhaps its standard error; of correlated
    /// errors the rows of the root of their covariance, each with one number more. They are taken as they are.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rows: Option<Vec<Vec<f64>>>,
    /// What is known of the rows.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub source: Option<Origin>,
    /// What the rows of the file are, one of the names of [`super::RowKind`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kind: Option<String>,
    /// Of which direction of slip, one of the names of [`super::Direction`].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<String>,
    /// Which columns of the file are read: `speed=NAME, friction=NAME`, and `error`, `time`, `position`, `normal`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// `force` or `coefficient`: the friction of a machine.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub quantity: Option<String>,
    /// Whether it is read as 1 + eps F(u).
    #[serde(skip_serializing_if = "is_false")]
    pub small: bool,
    /// The fit of which the formula is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub fit: Option<FitText>,
    /// Those of the parameters `exponent` and `drop` that the law has, and of a machine the quantities that stand in
    /// place of others. In a configuration they have values.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub axes: Vec<String>,
}

#[allow(clippy::trivially_copy_pass_by_ref)] // as serde calls it
fn is_false(value: &bool) -> bool {
    !value
}

/// What is known of the rows of a table.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default)]
pub struct Origin {
    /// The file, in messages.
    pub file: String,
    /// The line of each row; 0 for a mean of many.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub lines: Vec<usize>,
    /// Number of readings of which the rows are means.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub readings: Option<usize>,
    /// What was understood of the file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub told: Option<String>,
    /// Whether the first row is on the line through the next two, and moves with them.
    #[serde(skip_serializing_if = "is_false")]
    pub no_rest: bool,
    /// Whether the file named the column of the standard errors.
    #[serde(skip_serializing_if = "is_false")]
    pub named_errors: bool,
}

/// Values of the names in a formula, with their covariance.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FitText {
    /// The names, in the order of the covariance.
    pub names: Vec<String>,
    /// Their values.
    pub values: Vec<f64>,
    /// Row by row.
    pub covariance: Vec<Vec<f64>>,
}

impl FitText {
    /// The values with their errors; `None` if the covariance is none.
    #[must_use]
    pub fn spreads(&self) -> Option<Vec<(&str, f64, Spread)>> {
        let factor = super::fitted::factor(&self.covariance)?;
        let spread = |of_value: Vec<f64>| {
            let mut row = [0.0; MOST_JOINT];
            row[..of_value.len()].copy_from_slice(&of_value);
            Spread::Joint { row }
        };
        let both = self.names.iter().zip(&self.values).zip(factor);
        Some(both.map(|((name, value), row)| (name.as_str(), *value, spread(row))).collect())
    }

    /// The fit of the quantities whose errors are correlated; `None` where there are none.
    fn of(machine: &Machine, uncertain: &[Uncertain]) -> Option<Self> {
        let quantities = machine.quantities();
        let joint = uncertain.iter().filter_map(|(name, spread)| match spread {
            Spread::Joint { row } => {
                let value = quantities.iter().find(|(known, _)| known == name)?.1;
                Some(((*name).to_owned(), value, *row))
            }
            _ => None,
        });
        let (names, (values, rows)): (Vec<_>, (Vec<_>, Vec<[f64; MOST_JOINT]>)) =
            joint.map(|(name, value, row)| (name, (value, row))).unzip();
        let product =
            |a: &[f64; MOST_JOINT], b: &[f64; MOST_JOINT]| a.iter().zip(b).map(|(a, b)| a * b).sum();
        let covariance = rows.iter().map(|a| rows.iter().map(|b| product(a, b)).collect()).collect();
        (!names.is_empty()).then_some(Self { names, values, covariance })
    }
}

/// Refuses a friction at rest that is none.
fn level_of(level: f64) -> Result<Level, Wrong> {
    let legal = level > 0.0 && level.is_finite();
    let wrong = || {
        Wrong::new(
            "static",
            format!("the friction at rest is {level}; it must be greater than 0"),
            "write it in the units of the law",
        )
    };
    legal.then_some(Level::Given(level)).ok_or_else(wrong)
}

impl LawText {
    /// The law.
    ///
    /// # Errors
    /// What is wrong, with its key.
    pub fn law(&self, about: About) -> Result<Law, Wrong> {
        self.law_of(about, |how| {
            let file = self.file.as_deref().filter(|file| !file.is_empty()).unwrap_or("table");
            Measured::of_bytes(file, self.table.as_deref().unwrap_or_default().as_bytes(), how)
        })
    }

    /// The law, whose file `measured` reads.
    ///
    /// # Errors
    /// As [`LawText::law`].
    pub fn law_of(
        &self,
        about: About,
        measured: impl FnOnce(How) -> Result<Measured, (String, String)>,
    ) -> Result<Law, Wrong> {
        let name = if self.name.is_empty() { Law::Stribeck.name() } else { self.name.as_str() };
        let built_in = Law::BUILT_IN.into_iter().find(|law| law.name() == name);
        let level = self.level(about)?;
        let law = match (name, built_in) {
            (_, Some(law)) => law,
            ("expression", None) => self.formula(level, about)?,
            ("table", None) => Law::Table(self.table_of(level, about, measured)?),
            (_, None) => {
                let names: Vec<_> = Law::names().collect();
                return Err(Wrong::new("law", format!("unknown law `{name}`"), nearest("law", name, &names)));
            }
        };
        self.refuse_foreign(&law, about)?;
        let law = with_axes(law, |wanted| self.axes.iter().any(|it| it == wanted))?;
        Ok(if self.small { law.read_as_small() } else { law })
    }

    /// The friction at rest.
    fn level(&self, about: About) -> Result<Level, Wrong> {
        if let Some(word) = &self.rest {
            if word != "peak" {
                return Err(Wrong::new(
                    "rest",
                    "rest can be peak only",
                    "write the friction at rest as static",
                ));
            }
            if self.static_level.is_some() {
                let problem = "friction at rest is written twice: here, and as static";
                return Err(Wrong::new("rest", problem, "leave one of them out"));
            }
            return Ok(Level::Peak);
        }
        match (self.static_level, about) {
            (Some(level), _) => level_of(level),
            (None, About::Machine(_)) => Ok(Level::First),
            (None, About::Oscillator) => Ok(Level::One),
        }
    }

    fn formula(&self, level: Level, about: About) -> Result<Law, Wrong> {
        let Some(phi) = &self.phi else {
            let remedy = match about {
                About::Oscillator => "write for example phi = \"mu + (1 - mu)*exp(-u/vs)\"".to_owned(),
                About::Machine(_) => format!(
                    "write the coefficient of friction against the slip speed u in m/s, for example phi = \"0.3 + \
                     0.1*exp(-u/vs)\"; each name in it, as vs here, is a key of [machine]; {OF_MACHINE}"
                ),
            };
            return Err(Wrong::missing("phi", remedy));
        };
        let law = level.formula(phi).map_err(Wrong::in_formula)?;
        match (about, level, law.as_written()) {
            // A machine's formula is the coefficient itself.
            (About::Machine(_), Level::Peak, Law::Expression(formula)) => {
                let formula = Expression::new(&formula.text(), 1.0);
                formula.map(Law::Expression).map_err(Wrong::in_formula)
            }
            _ => Ok(law),
        }
    }

    fn table_of(
        &self,
        level: Level,
        about: About,
        measured: impl FnOnce(How) -> Result<Measured, (String, String)>,
    ) -> Result<Table, Wrong> {
        if let Some(rows) = &self.rows {
            return self.of_rows(rows, level);
        }
        if self.file.is_none() && self.table.is_none() {
            let remedy = match about {
                About::Oscillator => "name a CSV file with the columns slip speed and friction".to_owned(),
                About::Machine(_) => format!(
                    "name a CSV file with the columns slip speed in m/s, coefficient of friction, and perhaps its \
                     standard error; quantity = \"force\" if it holds forces in N; {OF_MACHINE}"
                ),
            };
            return Err(Wrong::missing("file", remedy));
        }
        let forces = self.quantity.as_ref().map(|word| word == FORCE);
        let machine = match about {
            About::Oscillator => None,
            About::Machine(motion) => Some(OfMachine { motion: Some(motion), forces }),
        };
        let [kind, direction, column] = [&self.kind, &self.direction, &self.column].map(Option::as_deref);
        let how = How::named(kind, direction, column);
        let how = how.map_err(|(problem, remedy)| {
            let key = match () {
                () if How::named(kind, None, None).is_err() => "kind",
                () if How::named(None, direction, None).is_err() => "direction",
                () => "column",
            };
            Wrong::new(key, problem, remedy)
        })?;
        let table = measured(how.of(machine)).and_then(|measured| measured.table(level));
        table.map_err(|(problem, remedy)| Wrong::new("file", problem, remedy))
    }

    /// The table of rows.
    fn of_rows(&self, rows: &[Vec<f64>], level: Level) -> Result<Table, Wrong> {
        let origin = self.source.clone().unwrap_or_default();
        let name = if origin.file.is_empty() { "rows" } else { &origin.file };
        let width = rows.first().map_or(2, Vec::len);
        let is_root = rows.len() > 1 && width == 3 && rows[1].len() == 4;
        let wanted = |at: usize| if is_root { at + 3 } else { width };
        if let Some(at) =
            (0..rows.len()).find(|&at| rows[at].len() != wanted(at) || !(2..=3).contains(&width))
        {
            let problem = format!("row {at} has {} numbers", rows[at].len());
            return Err(Wrong::new(
                "rows",
                problem,
                "write [slip speed, friction] or [slip speed, friction, error]",
            ));
        }
        let data: Vec<(f64, f64)> = rows.iter().map(|row| (row[0], row[1])).collect();
        let root = is_root.then(|| rows.iter().map(|row| row[2..].to_vec()).collect());
        let errors: Option<Vec<f64>> =
            (width == 3 && !is_root).then(|| rows.iter().map(|row| row[2]).collect());
        let first = data.first().map_or(1.0, |(_, friction)| *friction);
        let table = match level {
            Level::One => Table::new(name, &data, 1.0),
            Level::First => Table::new(name, &data, first),
            Level::Given(level) => Table::with_static(name, &data, level),
            Level::Peak => Table::with_rest_at_peak(name, &data),
        };
        let table = table.and_then(|table| match (root, errors) {
            (Some(root), _) => table.with_root_of_covariance(root),
            // With the rest at the peak the rows below it are one row.
            (None, Some(errors)) => {
                table.with_standard_errors(&errors[errors.len() - table.data().count()..])
            }
            (None, None) => Ok(table),
        });
        let source = Source {
            lines: origin.lines.clone(),
            readings: origin.readings.unwrap_or(data.len()),
            told: origin.told.clone(),
            forces: self.quantity.as_deref() == Some(FORCE),
            no_rest: origin.no_rest,
            named_errors: origin.named_errors,
        };
        let table = table.map_err(|error| {
            let row = error.row.map_or(String::new(), |row| format!("row {row}: "));
            Wrong::new("rows", format!("{row}{}", error.problem), error.remedy)
        })?;
        Ok(table.with_error_of_curve().with_source(source))
    }

    /// Refuses what belongs to another law.
    fn refuse_foreign(&self, law: &Law, about: About) -> Result<(), Wrong> {
        let name = law.name();
        if about == About::Oscillator && self.quantity.is_some() {
            let problem = "only the friction of a machine is a coefficient or a force";
            let remedy = "leave it out: phi is friction in units of that at rest";
            return Err(Wrong::new("quantity", problem, remedy));
        }
        let of_data = self.file.is_some() || self.table.is_some();
        for (key, is_there, of) in [
            ("phi", self.phi.is_some(), "expression"),
            ("file", of_data, "table"),
            ("rows", self.rows.is_some(), "table"),
            ("source", self.source.is_some(), "table"),
            ("kind", self.kind.is_some(), "table"),
            ("direction", self.direction.is_some(), "table"),
            ("column", self.column.is_some(), "table"),
        ] {
            if is_there && name != of {
                let problem = format!("the law `{name}` has no {key}");
                return Err(Wrong::new(key, problem, format!("leave it out, or set law = \"{of}\"")));
            }
        }
        if of_data && self.rows.is_some() {
            let remedy = "leave one of them out; rows are taken as they are, and a file is read";
            return Err(Wrong::new("rows", "the friction is written twice: here, and in a file", remedy));
        }
        let given = [("static", self.static_level.is_some()), ("rest", self.rest.is_some())];
        if let (Some(_), Some((key, _))) = (law.built_in(), given.into_iter().find(|(_, is_there)| *is_there))
        {
            let problem = format!("friction at rest is 1 already in the law `{name}`");
            let remedy = "leave it out; where friction drops as slip begins, write drop in [grid], or --drop";
            return Err(Wrong::new(key, problem, remedy));
        }
        match (&self.fit, law.as_written()) {
            (Some(_), law) if !matches!(law, Law::Expression(_)) => {
                let remedy = "leave it out, or set law = \"expression\"";
                Err(Wrong::new("fit", "only a formula has a fit", remedy))
            }
            _ => Ok(()),
        }
    }

    /// A law as it is written; `None` for a function and a law of a program, which cannot be.
    #[must_use]
    pub fn of(law: &Law, about: About) -> Option<Self> {
        let axes = ["exponent", "drop"];
        let axes = law.parameters().iter().map(|of| of.name).filter(|name| axes.contains(name));
        let of_law = Self {
            name: law.name().to_owned(),
            small: law.is_read_as_small(),
            // Two coefficients have a drop in any case.
            axes: axes.filter(|_| *law.as_written() != Law::Coulomb).map(str::to_owned).collect(),
            ..Self::default()
        };
        Some(match law.as_written() {
            Law::Expression(formula) => {
                let is_own =
                    !formula.may_drop() && (formula.static_level() == 1.0 || about != About::Oscillator);
                Self {
                    phi: Some(formula.text().into_owned()),
                    static_level: (!is_own).then_some(formula.static_level()),
                    ..of_law
                }
            }
            Law::Table(table) => {
                let (errors, root) = (table.standard_errors(), table.root_of_covariance());
                let row = |(i, (u, friction)): (usize, (f64, f64))| match (root, errors) {
                    (Some(root), _) => [&[u, friction], &root[i][..]].concat(),
                    (None, Some(errors)) => vec![u, friction, errors[i]],
                    (None, None) => vec![u, friction],
                };
                let rows: Vec<Vec<f64>> = table.data().enumerate().map(row).collect();
                let own = if about == About::Oscillator { 1.0 } else { rows[0][1] };
                let Source { lines, readings, told, forces, no_rest, named_errors } = table.source().clone();
                let readings = Some(readings).filter(|readings| *readings != rows.len());
                let file = table.origin().to_owned();
                Self {
                    static_level: Some(table.static_level()).filter(|level| *level != own),
                    rows: Some(rows),
                    source: Some(Origin { file, lines, readings, told, no_rest, named_errors }),
                    quantity: (forces && about != About::Oscillator).then(|| FORCE.to_owned()),
                    ..of_law
                }
            }
            law if law.built_in().is_some() => of_law,
            _ => return None,
        })
    }

    /// The friction of a machine as it is written; `None` as for [`LawText::of`].
    #[must_use]
    pub fn of_machine(machine: &Machine, uncertain: &[Uncertain]) -> Option<Self> {
        let law = machine.law();
        let of_law = Self::of(&law, About::Machine(machine.motion))?;
        let names: Vec<&str> = machine.quantities().into_iter().map(|(name, _)| name).collect();
        let usual = Machine::names(&law, |_| false);
        let is_other = |name: &&str| !usual.contains(name);
        let mut axes = of_law.axes;
        axes.extend(names.iter().filter(|name| is_other(name)).map(|name| (*name).to_owned()));
        // A frequency stands for the mass where the stiffness is given.
        axes.extend(names.iter().filter(|name| **name == "stiffness").map(|name| (*name).to_owned()));
        axes.dedup();
        Some(Self {
            axes,
            quantity: (!machine.normal_force_is_known).then(|| FORCE.to_owned()),
            fit: FitText::of(machine, uncertain),
            ..of_law
        })
    }

    /// Whether the friction of a machine is a force, and has no normal force.
    #[must_use]
    pub fn holds_forces(&self, law: &Law) -> bool {
        match law.as_written() {
            Law::Table(table) => table.source().forces,
            _ => self.quantity.as_deref() == Some(FORCE),
        }
    }
}

/// The word for friction that is a force.
pub(super) const FORCE: &str = "force";

/// The law with the parameters `exponent` and `drop`, each if it is `wanted`.
///
/// # Errors
/// The law has a drop by its friction at rest, or no room for one.
pub fn with_axes(law: Law, wanted: impl Fn(&str) -> bool) -> Result<Law, Wrong> {
    let law = if wanted("exponent") { law.with_exponent() } else { law };
    if !wanted("drop") || law.parameters().iter().any(|parameter| parameter.name == "drop") {
        return Ok(law);
    }
    if law.may_drop() {
        let remedy = "leave out one of them: friction at rest above the law at u -> 0 is a drop, too";
        return Err(Wrong::new("drop", "the drop is written twice: here, and as friction at rest", remedy));
    }
    if law.parameters().len() < MAX_LAW_PARAMETERS {
        return Ok(law.with_drop());
    }
    let problem = format!("the law has {MAX_LAW_PARAMETERS} parameters, and no room for a drop");
    let remedy = "write some of them as numbers, or the drop as friction at rest";
    Err(Wrong::new("drop", problem, remedy))
}

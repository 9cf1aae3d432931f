//! Measured friction as rigs and spreadsheets write it: read where it has one meaning, refused with its line where
//! it has two.

mod columns;
mod fit;
mod reduced;
mod rows;
mod slopes;
mod table;
mod text;

use std::io::Read as _;
use std::path::Path;

use super::units::number_in;
use slipmap_machine::{Dimension, Motion};

pub use fit::{Fits, Fitted, FittedLaw, ONE_AT_REST, law_of, words_of};
pub use table::Level;

/// Largest size in bytes of a file of measured friction.
const LONGEST: u64 = 16 << 20;

/// A problem of a file, with its line, and a remedy.
pub(super) struct Refused {
    line: Option<usize>,
    problem: String,
    remedy: String,
}

impl Refused {
    /// A problem of the whole file.
    fn whole(problem: &str, remedy: &str) -> Self {
        Self { line: None, problem: problem.to_owned(), remedy: remedy.to_owned() }
    }

    /// No row has two numbers.
    fn no_numbers() -> Self {
        Self::whole(
            "no row has two numbers",
            "write slip speed and friction as numbers alone, separated by a comma; units belong into the header, standard \
             errors into a column of their own",
        )
    }

    /// The problem with its place in the file `name`, and the remedy.
    fn told(self, name: &str) -> (String, String) {
        let line = self.line.map_or(String::new(), |line| format!(":{line}"));
        (format!("{name}{line}: {}", self.problem), self.remedy)
    }
}

/// What the friction of a machine is, as far as the caller knows.
#[derive(Clone, Copy, Debug)]
pub struct OfMachine {
    /// Whether the machine moves along a line or turns; by the unit of the slip speeds if it is `None`.
    pub motion: Option<Motion>,
    /// Whether it holds forces (of a rotation torques) instead of coefficients; by the unit if it is `None`.
    pub forces: Option<bool>,
}

/// What the rows of a file are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RowKind {
    /// A record over time, in which neighbours are not independent.
    Record,
    /// Independent readings, in any order.
    Curve,
    /// The law itself: nothing is reduced.
    Rows,
}

impl RowKind {
    /// All of them, by name.
    pub const NAMES: [(&'static str, Self); 3] =
        [("record", Self::Record), ("curve", Self::Curve), ("rows", Self::Rows)];
}

/// Of which direction of slip friction is taken.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Direction {
    /// Forward slip alone.
    Forward,
    /// Backward slip alone.
    Backward,
    /// The mean of both.
    #[default]
    Mean,
}

impl Direction {
    /// All of them, by name.
    pub const NAMES: [(&'static str, Self); 3] =
        [("forward", Self::Forward), ("backward", Self::Backward), ("mean", Self::Mean)];
}

/// How a file is to be read.
#[derive(Clone, Debug, Default)]
pub struct How {
    /// The machine whose friction it is, in SI units; `None` for that of the oscillator.
    pub machine: Option<OfMachine>,
    /// What the rows are; as the file has it if it is `None`.
    pub kind: Option<RowKind>,
    /// Of which direction of slip.
    pub direction: Direction,
    /// The columns that were chosen.
    chosen: columns::Chosen,
}

impl How {
    /// The same for the friction of a machine.
    #[must_use]
    pub fn of(self, machine: Option<OfMachine>) -> Self {
        Self { machine, ..self }
    }

    /// The kind of rows and the direction of these names, and the columns of `speed=NAME, friction=NAME`.
    ///
    /// # Errors
    /// The name that there is not, and those that there are.
    pub fn named(
        kind: Option<&str>,
        direction: Option<&str>,
        column: Option<&str>,
    ) -> Result<Self, (String, String)> {
        fn of<T: Copy>(
            what: &str,
            name: Option<&str>,
            names: &[(&str, T)],
        ) -> Result<Option<T>, (String, String)> {
            let find = |name: &str| {
                let found = names.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
                let known: Vec<&str> = names.iter().map(|(known, _)| *known).collect();
                let refused =
                    || (format!("there is no {what} `{name}`"), format!("choose from: {}", known.join(", ")));
                found.ok_or_else(refused)
            };
            name.map(find).transpose()
        }
        let direction = of("direction", direction, &Direction::NAMES)?.unwrap_or_default();
        let chosen = column.map_or(Ok(Vec::new()), columns::chosen)?;
        Ok(Self { machine: None, kind: of("kind of rows", kind, &RowKind::NAMES)?, direction, chosen })
    }
}

/// A reading of the friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeasuredReading {
    /// Slip speed, at least 0.
    pub speed: f64,
    /// Friction against slip.
    pub friction: f64,
    /// Its standard error; NaN where the file has none.
    pub error: f64,
    /// Its line in the file.
    pub line: usize,
    /// The visit of a record over time to which it belongs: a time at one speed, or a sweep of the speed up or down.
    pub visit: usize,
    /// Whether slip is backward.
    pub backward: bool,
}

/// Measured friction; of a machine in SI units.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The file's name in messages.
    pub name: String,
    /// Readings at rest, at slip speed 0: of a record over time the friction at which each phase of rest ends.
    pub at_rest: Vec<MeasuredReading>,
    /// Readings in slip, by increasing speed.
    pub in_slip: Vec<MeasuredReading>,
    /// Whether the file has standard errors.
    pub has_errors: bool,
    /// Whether the rows are a record over time, in which neighbours are not independent.
    pub is_record: bool,
    /// Whether the friction is a force, or of a rotation a torque; `None` where nothing says so.
    pub forces: Option<bool>,
    /// The normal force by which the forces of the file were divided.
    pub normal_force: Option<f64>,
    /// Whether the slip speeds are those of a rotation.
    pub motion: Motion,
    /// Whether the rows are the law itself, as those of an oscillator are.
    pub is_law: bool,
    /// The standard error of the slip speeds that follow from positions; 0 for others.
    pub error_of_speed: f64,
    /// What has been understood, one phrase each.
    pub said: Vec<String>,
}

impl Measured {
    /// Reads the file at `path`.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn read(path: &Path, how: How) -> Result<Self, (String, String)> {
        let name = path.display().to_string();
        let mut bytes = Vec::new();
        // The length is limited because some files never end.
        std::fs::File::open(path).and_then(|open| open.take(LONGEST + 1).read_to_end(&mut bytes)).map_err(
            |error| {
                let problem = match error.kind() {
                    std::io::ErrorKind::NotFound => format!("{name} cannot be read: there is no such file"),
                    _ => format!("{name} cannot be read: {error}"),
                };
                (problem, "check the path".to_owned())
            },
        )?;
        if bytes.len() as u64 > LONGEST {
            let problem = format!("{name} is longer than {} MiB, and no measured friction", LONGEST >> 20);
            return Err((problem, "name a CSV file with the columns slip speed and friction".into()));
        }
        Self::of_bytes(&name, &bytes, how)
    }

    /// Reads the bytes of a file of this `name`, as [`Measured::read`] does.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn of_bytes(name: &str, bytes: &[u8], how: How) -> Result<Self, (String, String)> {
        rows::read(name, bytes, how).map_err(|refused| refused.told(name))
    }

    /// Coefficients in place of the forces, at the normal force of this text: "5 kN". That of a rotation is a torque.
    ///
    /// # Errors
    /// The friction is none, or the text, and a remedy.
    pub fn over(mut self, text: &str) -> Result<Self, (String, String)> {
        let unit = self.motion.unit(Dimension::Force);
        let number =
            number_in(text, unit).map(|(number, _)| number).or_else(|why| text.parse().map_err(|_| why));
        let normal_force =
            number.map_err(|why| (format!("the normal force: {why}"), format!("write it as 5000 {unit}")))?;
        if !(normal_force > 0.0 && normal_force.is_finite()) {
            return Err((
                format!("the normal force is {normal_force}"),
                "give one that is greater than 0".into(),
            ));
        }
        if self.forces == Some(false) {
            let problem = format!("{}: the friction is a coefficient already", self.name);
            return Err((problem, "leave the normal force out".into()));
        }
        for row in self.at_rest.iter_mut().chain(&mut self.in_slip) {
            row.friction /= normal_force;
            row.error /= normal_force;
        }
        self.said.push(format!("coefficients: the friction over {normal_force} {unit}"));
        (self.forces, self.normal_force) = (Some(false), Some(normal_force));
        Ok(self)
    }

    /// What has been understood of the file, in one line; `None` for a file as the documentation has it.
    pub fn told(&self) -> Option<String> {
        (!self.said.is_empty()).then(|| format!("{}: {}", self.name, self.said.join("; ")))
    }
}

#[cfg(test)]
mod coverage;
#[cfg(test)]
mod tests;

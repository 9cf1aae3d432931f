//! Measured friction as rigs and spreadsheets write it: read where it has one meaning, refused with its line where
//! it has two.

mod columns;
mod fit;
mod readings;
mod rows;
mod table;
mod text;

use std::io::Read as _;
use std::path::Path;

use slipmap_machine::Motion;

pub use fit::{Fits, Fitted, FittedLaw, law_of, words_of};
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

/// A reading of the friction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Slip speed, at least 0.
    pub speed: f64,
    /// Friction against slip.
    pub friction: f64,
    /// Its standard error; NaN where the file has none.
    pub error: f64,
    /// Its line in the file.
    pub line: usize,
    /// The passage of a record over time to which it belongs: one sweep of the speed up or down.
    pub passage: usize,
}

/// Measured friction; of a machine in SI units.
#[derive(Clone, Debug)]
pub struct Measured {
    /// The file's name in messages.
    pub name: String,
    /// Readings at rest, at slip speed 0: of a record over time the largest friction of each phase of rest.
    pub at_rest: Vec<Reading>,
    /// Readings in slip, by increasing speed.
    pub in_slip: Vec<Reading>,
    /// Whether the file has standard errors.
    pub has_errors: bool,
    /// Whether the rows are a record over time, in which neighbours are not independent.
    pub is_record: bool,
    /// Whether the friction is a force, or of a rotation a torque; `None` where nothing says so.
    pub forces: Option<bool>,
    /// Whether the slip speeds are those of a rotation.
    pub motion: Motion,
    /// What has been understood, one phrase each.
    pub said: Vec<String>,
}

impl Measured {
    /// Reads the file at `path`; `machine` where its friction is that of a machine, in SI units.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn read(path: &Path, machine: Option<OfMachine>) -> Result<Self, (String, String)> {
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
        Self::of_bytes(&name, &bytes, machine)
    }

    /// Reads the bytes of a file of this `name`, as [`Measured::read`] does.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn of_bytes(name: &str, bytes: &[u8], machine: Option<OfMachine>) -> Result<Self, (String, String)> {
        rows::read(name, bytes, machine).map_err(|refused| refused.told(name))
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

//! Variables of a machine's map beside those of its cells: the quantities that do not vary, and the probability
//! of stick-slip. Each is stored in one piece.

use super::value::{Value, si_name};
use crate::Grid;

/// A variable that is stored in one piece.
#[derive(Clone, Debug, PartialEq)]
pub struct Auxiliary {
    /// Its name, one of [`names`].
    pub name: &'static str,
    /// Its values, row-major along its axes.
    pub values: Vec<f64>,
    /// Its attributes, apart from fingerprints.
    pub attributes: Vec<(&'static str, Value)>,
}

/// Name of the variable with the probability that a machine with uncertain quantities may stick-slip, over all
/// axes.
pub const PROBABILITY: &str = "stick_slip_probability";

/// Name of that with the probability that it vibrates by itself, since steady slip is unstable.
pub const BY_ITSELF: &str = "vibration_by_itself_probability";
/// Both.
pub const PROBABILITIES: [&str; 2] = [PROBABILITY, BY_ITSELF];

/// The names of all such variables that a map of this grid may have.
pub fn names(grid: &Grid) -> Vec<&'static str> {
    let fixed = grid.fixed().into_iter().map(|(name, _)| name);
    fixed.chain(grid.machine().into_iter().flat_map(|_| PROBABILITIES)).collect()
}

/// Number of the axes of such a variable: all, or none.
pub fn rank_of(name: &str, grid: &Grid) -> usize {
    if PROBABILITIES.contains(&name) { grid.axes().len() } else { 0 }
}

/// The variables with the probabilities that a machine may stick-slip and that it vibrates by itself, row-major along all
/// axes, from a number of draws for each damping's column.
pub fn probabilities(may_stick: Vec<f64>, by_itself: Vec<f64>, draws: usize) -> [Auxiliary; 2] {
    let one = |name, words: &str, values| Auxiliary {
        name,
        values,
        attributes: vec![
            ("long_name", words.into()),
            ("units", "1".into()),
            ("draws", Value::Integers(vec![i64::try_from(draws).unwrap_or(i64::MAX)])),
            ("standard_error_at_most", (0.5 / (draws as f64).sqrt()).into()),
        ],
    };
    [
        one(PROBABILITY, "probability that the machine may stick-slip", may_stick),
        one(BY_ITSELF, "probability that the machine vibrates by itself", by_itself),
    ]
}

/// The quantities of a machine that do not vary: scalar coordinates, by the CF conventions.
pub fn fixed(grid: &Grid) -> Vec<Auxiliary> {
    let one = |(name, value): (&'static str, f64)| {
        let machine = grid.machine()?;
        let attributes =
            vec![("long_name", machine.words(name).into()), ("units", si_name(machine.unit(name)).into())];
        Some(Auxiliary { name, values: vec![value], attributes })
    };
    grid.fixed().into_iter().filter_map(one).collect()
}

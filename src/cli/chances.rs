//! The probability of stick-slip over the map of a machine with uncertain quantities.

use std::sync::atomic::AtomicBool;

use super::output::{count, number_of};
use super::say;
use slipmap_config::Job;
use slipmap_map::dataset::{Auxiliary, auxiliary};
use slipmap_map::map::{Grid, unravel};
use slipmap_map::risk::{NoRisk, Uncertain, is_uncertain, probabilities};

/// Number of draws for the whole map.
const DRAWS: usize = 1_000_000;
/// Least number of draws in each column: the standard error of a probability is then at most 0.005.
const FEWEST_DRAWS: usize = 10_000;

/// Computes the probability of stick-slip in each cell of a map.
pub(super) struct Chances<'a> {
    grid: &'a Grid,
    uncertain: &'a [Uncertain],
    /// Number of draws in each column.
    pub(super) draws: usize,
}

impl<'a> Chances<'a> {
    /// `None` for a job without a machine or without uncertain quantities.
    pub(super) fn of(job: &'a Job) -> Option<Self> {
        let (grid, uncertain) = (job.plan.grid(), &job.uncertain);
        grid.machine().filter(|machine| is_uncertain(machine, uncertain))?;
        let draws = (DRAWS / grid.column_count()).max(FEWEST_DRAWS);
        Some(Self { grid, uncertain, draws })
    }

    /// Computes the variable of the map, and prints a note on illegal draws and on those without an answer.
    pub(super) fn variable(&self, threads: Option<usize>, stop: &AtomicBool) -> Result<Auxiliary, NoRisk> {
        let Self { grid, uncertain, draws } = *self;
        let (shape, dampings) = (grid.shape(), grid.dampings());
        let machine =
            |column: usize| grid.machine_at(&grid.values(&unravel(column * dampings.len(), &shape)));
        let machines = (0..grid.column_count()).filter_map(machine);
        let find = || probabilities(machines, uncertain, dampings, draws, stop);
        // If no pool can be created, the global pool is used.
        let found = match slipmap_map::map::pool(threads) {
            Ok(pool) => pool.install(find),
            Err(_) => find(),
        }?;
        for note in notes_on_draws(draws * grid.column_count(), found.failed, found.redrawn) {
            say(&format!("note: {note}"));
        }
        Ok(auxiliary::probability(found.values, draws))
    }
}

/// Notes on draws that were illegal and on draws without an answer.
pub(super) fn notes_on_draws(draws: usize, failed: usize, redrawn: usize) -> Vec<String> {
    let mut notes = Vec::new();
    if redrawn > 0 {
        notes.push(format!(
            "{} of illegal values, such as a negative mass or damping, do not count; {} do",
            number_of(redrawn, "draw"),
            count(draws)
        ));
    }
    if failed > 0 {
        notes.push(format!(
            "{} of {} without an answer, since the critical damping was not found",
            count(failed),
            number_of(draws, "draw")
        ));
    }
    notes
}

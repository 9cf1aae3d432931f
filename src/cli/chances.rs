//! The probability of stick-slip over the map of a machine with uncertain quantities.

use std::sync::atomic::AtomicBool;

use super::output::{count, number_of};
use super::say;
use slipmap_config::Job;
use slipmap_map::dataset::{Auxiliary, auxiliary};
use slipmap_map::machine::Machine;
use slipmap_map::risk::{NoRisk, Uncertain, is_uncertain, probabilities};

/// Number of draws for the whole map.
const DRAWS: usize = 1_000_000;
/// Least number of draws at each belt speed: the standard error of a probability is then at most 0.005.
const FEWEST_DRAWS: usize = 10_000;

/// Computes the probability of stick-slip at each belt speed and damping of a map.
pub(super) struct Chances<'a> {
    machine: &'a Machine,
    uncertain: &'a [Uncertain],
    belt_speeds: Vec<f64>,
    dampings: Vec<f64>,
    /// Number of draws at each belt speed.
    pub(super) draws: usize,
}

impl<'a> Chances<'a> {
    /// `None` for a job without a machine or without uncertain quantities.
    pub(super) fn of(job: &'a Job) -> Option<Self> {
        let uncertain = &job.uncertain;
        let machine = job.machine.as_ref().filter(|machine| is_uncertain(machine, uncertain))?;
        let [belt_speeds, dampings]: [Auxiliary; 2] =
            auxiliary::coordinates(&job.plan.grid, &machine.si()).try_into().ok()?;
        let (belt_speeds, dampings) = (belt_speeds.values, dampings.values);
        let draws = (DRAWS / belt_speeds.len()).max(FEWEST_DRAWS);
        Some(Self { machine, uncertain, belt_speeds, dampings, draws })
    }

    /// Computes the variable of the map, and prints a note on illegal draws and on those without an answer.
    pub(super) fn variable(&self, threads: Option<usize>, stop: &AtomicBool) -> Result<Auxiliary, NoRisk> {
        let Self { machine, uncertain, belt_speeds, dampings, draws } = self;
        let find = || probabilities(machine, uncertain, belt_speeds, dampings, *draws, stop);
        // If no pool can be created, the global pool is used.
        let found = match slipmap_map::map::pool(threads) {
            Ok(pool) => pool.install(find),
            Err(_) => find(),
        }?;
        let draws = self.draws * self.belt_speeds.len();
        for note in notes_on_draws(draws, found.failed, found.redrawn) {
            say(&format!("note: {note}"));
        }
        Ok(auxiliary::probability(found.values, self.draws))
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

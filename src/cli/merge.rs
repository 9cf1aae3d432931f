//! `slipmap merge`: makes a map of the tiles that processes have left in their journals.

use clap::Args;

use super::complete::{self, Asked};
use super::configuration::Configuration;
use super::output::{count, number_of};
use super::preflight::{Permission, Preflight};
use super::run::{abandon_in_time, complete_already, provenance, refused, report_loss, with_how_to_continue};
use super::{Ended, Failure, NOTHING_LEFT, interrupt, threads};
use slipmap_format::Journals;
use slipmap_map::ComputeError;

/// Make the map of what shards have computed.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap merge configs/paper.toml
  slipmap merge configs/paper.toml --set output.path=results/paper.h5

Every variable of the map equals that of one process, bit for bit. Curves, proofs and probabilities are computed here. The shards' \
journals, NAME.part.LETTERS, are kept until the map is complete, sealed and on disk; then they are removed. If \
tiles are missing, the shards that have them are named, and nothing is changed. It may be repeated.")]
pub(super) struct Arguments {
    #[command(flatten)]
    configuration: Configuration,
    /// Number of threads for curves and proofs; default: one per core
    #[arg(long, value_name = "NUMBER", value_parser = threads::parse)]
    threads: Option<usize>,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let stop = interrupt::flag();
    let job = arguments.configuration.load()?;
    Preflight::check(&job, Permission::Resume)?;
    let found = Journals::beside(&job.output, &job.plan, &provenance(&job), None).map_err(refused)?;
    let Some(found) = found else {
        slipmap_format::remove_parts(&job.output).map_err(refused)?;
        complete_already(&job, arguments.json)?;
        return Ok(Ended::Fine);
    };
    report_loss(&found);
    if found.finished_tiles() < found.tiles() {
        let missing = number_of(found.tiles() - found.finished_tiles(), "tile");
        return Err(Failure::bad_input(
            format!("{}: {missing} of {} missing", job.output.display(), count(found.tiles())),
            how_to_compute(&found, &arguments.configuration.words()),
        ));
    }
    abandon_in_time(Some(job.output.clone()));
    let &Arguments { threads, json, quiet, .. } = arguments;
    let asked = Asked { threads, replaces_proof: true, json, quiet };
    let none = || Ok((slipmap_map::Account::none(&job.plan), found.threads));
    let stopped = |error: &ComputeError<_>| match error {
        ComputeError::Threads(why) => threads::not_started(why),
        _ => Failure::Interrupted(NOTHING_LEFT.into()),
    };
    let computed = complete::compute(&asked, &job, &found, stop, none, stopped)?;
    found
        .finish(&computed.outcome)
        .map_err(|error| Failure::Broken(with_how_to_continue(&error, &job.output)))?;
    complete::report(&asked, &job, &computed)
}

/// What computes the missing tiles: the shards, of as many as there were, or the rest of a run.
pub(super) fn how_to_compute(found: &Journals, config: &str) -> String {
    match found.shards {
        None => format!("slipmap run {config} --resume"),
        Some(of) => {
            let missing = ranges(&found.missing_shards(of));
            format!("slipmap run {config} --shard K/{of} for K = {missing}")
        }
    }
}

/// Numbers as ranges, in the form of Slurm's `--array`: "1-3,7".
pub(super) fn ranges(numbers: &[usize]) -> String {
    let runs = numbers.chunk_by(|one, next| one + 1 == *next);
    let text = |run: &[usize]| match run {
        [first, .., last] => format!("{first}-{last}"),
        one => one.iter().map(usize::to_string).collect(),
    };
    runs.map(text).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_listed_as_ranges() {
        assert_eq!(ranges(&[]), "");
        assert_eq!(ranges(&[1, 2, 3, 7, 9, 10]), "1-3,7,9-10");
    }
}

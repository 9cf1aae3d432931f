//! `slipmap run`: computes a map, or a shard of one.

use std::cell::Cell;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

use clap::Args;
use serde_json::json;

use super::complete::{self, Asked};
use super::configuration::{Configuration, quoted};
use super::output::{bytes, count, number_of};
use super::preflight::{Permission, Preflight, create_folders};
use super::report::existing;
use super::{Ended, Failure, GIT, estimate, interrupt, notes, output, progress, say, threads};
use slipmap_config::Job;
use slipmap_format::{Journals, PartialMap, Provenance, StoreError};
use slipmap_map::{ComputeError, Control, Queue, Shard};

/// Compute a map from a configuration file.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap run configs/quickstart.toml
  slipmap run configs/paper.toml --dry-run
  slipmap run configs/paper.toml --set grid.V=2.5 --set output.path=results/fast-belt.h5 --threads 8
  slipmap run configs/paper.toml --resume
  slipmap run configs/paper.toml --shard 3/64 --time-limit 55m

The configuration is explained in configs/quickstart.toml. The map appears under its name only when it is \
complete; the folders that its path names are created. Finished tiles are kept in NAME.part.LETTERS beside it \
until then: a run that was stopped, by whatever, goes on with --resume as if nothing had happened.

With --shard K/N any number of processes, on any machines that share the folder, compute a map together: \
each its part of the tiles. Shards resume by themselves. `slipmap merge` makes the map when all are done.")]
pub(super) struct Arguments {
    #[command(flatten)]
    configuration: Configuration,
    /// Number of threads; default: one per core
    #[arg(long, value_name = "NUMBER", value_parser = threads::parse)]
    threads: Option<usize>,
    /// Print how large the map would be and how long it would take, and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Continue an interrupted run; starts one if there is none, and does nothing if the map is complete
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Compute part K of N, and leave the map to `slipmap merge`
    #[arg(long, value_name = "K/N", conflicts_with_all = ["overwrite", "resume"])]
    shard: Option<Shard>,
    /// Stop after this time (55m, 2h 30min), with exit code 75: finished tiles are kept, run it again
    #[arg(long, value_name = "TIME", value_parser = humantime::parse_duration)]
    time_limit: Option<Duration>,
    /// Replace the map, or what interrupted runs have left of it
    #[arg(long)]
    overwrite: bool,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let stop = interrupt::flag();
    if let Some(limit) = arguments.time_limit.filter(|_| !arguments.dry_run) {
        interrupt::after(limit);
    }
    let Some((job, map)) = prepare(arguments, arguments.configuration.load()?)? else {
        return Ok(Ended::Fine);
    };
    match arguments.shard {
        Some(shard) => compute_shard(arguments, &job, &map, shard, stop),
        None => compute(arguments, &job, map, stop),
    }
}

/// Does everything before the computation; `None` if nothing is left to compute.
fn prepare(arguments: &Arguments, job: Job) -> Result<Option<(Job, PartialMap)>, Failure> {
    let resume = arguments.resume || arguments.shard.is_some();
    let permission = match (arguments.overwrite, resume) {
        (true, _) => Permission::Overwrite,
        (false, true) => Permission::Resume,
        (false, false) => Permission::None,
    };
    notes::tell_units(&job.conversions);
    let preflight = Preflight::check(&job, permission)?;
    match job.plan.grid.machine() {
        Some(machine) => notes::warn(machine),
        None => notes::warn_of_law(job.plan.grid.law()),
    }
    if arguments.dry_run {
        if let Some(refused) = &preflight.refuses {
            say(&format!("note: the run itself would be refused: {refused}"));
        }
        estimate::run(&job, &preflight, arguments.threads, arguments.shard, arguments.json)?;
        return Ok(None);
    }
    if let Some(refused) = &preflight.refuses {
        return Err(Failure::BadInput(refused.clone()));
    }
    if permission != Permission::Resume && preflight.may_not_fit(&job) {
        preflight.verdict(
            &job,
            estimate::sampled(&job.plan, arguments.threads.unwrap_or_else(threads::cores)).packed,
        )?;
    }
    create_folders(&job.output)?;
    let threads = arguments.threads.unwrap_or_else(threads::cores);
    let provenance = Provenance { threads, ..provenance(&job) };
    let map = if resume {
        let map = PartialMap::resume(&job.output, &job.plan, &provenance, arguments.shard);
        let Some(map) = map.map_err(refused)? else {
            complete_already(&job, arguments.json)?;
            return Ok(None);
        };
        map
    } else {
        for replaced in preflight.replaces.iter().flatten() {
            say(&format!("note: {replaced} will be replaced"));
        }
        PartialMap::begin(&job.output, &job.plan, &provenance, existing(arguments.overwrite))
            .map_err(refused)?
    };
    report_resumption(&map.found, arguments.resume);
    // A shard makes no map, and leaves alone what others make.
    let makes = arguments.shard.is_none();
    abandon_in_time(makes.then(|| job.output.clone()));
    Ok(Some((job, map)))
}

/// Tells that there is nothing to do.
pub(super) fn complete_already(job: &Job, as_json: bool) -> Result<(), Failure> {
    say(&format!("note: {} is complete already; nothing was computed", job.output.display()));
    if as_json {
        output::print_json(&json!({ "output": job.output.to_string_lossy(), "complete_already": true }))?;
    }
    Ok(())
}

/// Computes the missing tiles, completes the map, and reports.
fn compute(arguments: &Arguments, job: &Job, map: PartialMap, stop: &AtomicBool) -> Result<Ended, Failure> {
    let bar = progress::bar(arguments.quiet, Some(job.plan.grid.cells() as u64), "cells");
    bar.inc(map.found.account.cells);
    let queue = Queue::new(map.found.tiles(), map.found.finished());
    let on_cells = |cells| bar.inc(cells as u64);
    let control = Control { threads: arguments.threads, on_cells: &on_cells, stop, ..Control::default() };
    let tiles = || {
        let computed = slipmap_map::compute_tiles(&job.plan, &map, &control, &|| queue.take());
        bar.finish_and_clear();
        computed
    };
    let Arguments { threads, overwrite, resume, json, quiet, .. } = *arguments;
    let asked = Asked { threads, replaces_proof: overwrite || resume, json, quiet };
    let made = Cell::new(false);
    let stopped = |error: &ComputeError<StoreError>| {
        let by_others = |error| map.found.is_made_meanwhile(error);
        made.set(matches!(error, ComputeError::Sink(error) if by_others(error)));
        stopped(&map, error, &job.output)
    };
    let computed = match complete::compute(&asked, job, &map.found, stop, tiles, stopped) {
        Err(_) if made.get() => {
            complete_already(job, json)?;
            return Ok(Ended::Fine);
        }
        computed => computed?,
    };
    map.finish(&computed.outcome)
        .map_err(|error| Failure::Broken(with_how_to_continue(&error, &job.output)))?;
    complete::report(&asked, job, &computed)
}

/// Computes the missing tiles of a shard.
fn compute_shard(
    arguments: &Arguments,
    job: &Job,
    map: &PartialMap,
    shard: Shard,
    stop: &AtomicBool,
) -> Result<Ended, Failure> {
    let (all, of_shard) = (map.found.tiles(), shard.tiles(map.found.tiles()));
    let before = map.found.finished_tiles();
    let cells = (of_shard - before) as u64;
    let bar = progress::bar(arguments.quiet, Some(cells), "tiles");
    let queue = Queue::new(all, map.found.finished()).of_shard(shard);
    let on_cells = |_| bar.inc(1);
    let control = Control { threads: arguments.threads, on_cells: &on_cells, stop, ..Control::default() };
    let computed = slipmap_map::compute_tiles(&job.plan, map, &control, &|| queue.take());
    bar.finish_and_clear();
    match computed {
        Ok(_) => {}
        // Other processes have computed all tiles, and the map has been made.
        Err(ComputeError::Sink(error)) if map.found.is_made_meanwhile(&error) => {
            complete_already(job, arguments.json)?;
            return Ok(Ended::Fine);
        }
        Err(error) => return Err(stopped(map, &error, &job.output)),
    }
    map.sync().map_err(|error| Failure::Broken(with_how_to_continue(&error, &job.output)))?;
    if arguments.json {
        output::print_json(&json!({
            "output": job.output.to_string_lossy(),
            "shard": shard.to_string(),
            "tiles": of_shard,
            "resumed_tiles": before,
            "all_tiles": all,
        }))?;
        return Ok(Ended::Fine);
    }
    say(&format!(
        "shard {shard} is finished: {} of {}\n  when all shards are: slipmap merge {}",
        number_of(of_shard, "tile"),
        count(all),
        arguments.configuration.words()
    ));
    Ok(Ended::Fine)
}

/// Prints the state of the run to be continued.
pub(super) fn report_resumption(found: &Journals, resume: bool) {
    let (done, all) = (found.finished_tiles(), found.tiles());
    if done > 0 {
        say(&format!("note: resuming with {} of {} finished", count(done), number_of(all, "tile")));
    } else if resume {
        say("note: there is nothing to resume; starting from the beginning");
    }
    report_loss(found);
}

/// Tells of tiles that were finished and cannot be used.
pub(super) fn report_loss(found: &Journals) {
    if found.lost > 0 {
        say(&format!(
            "note: {} of the finished tiles are cut short or damaged; they are computed again",
            bytes(found.lost.into())
        ));
    }
}

/// Abandons tiles that take too long after an interruption, and the map at the output if one is being made. The
/// journal holds each tile whole or not at all, whatever other threads are doing.
pub(super) fn abandon_in_time(output: Option<PathBuf>) {
    let left = format!("the tiles in work were given up, finished ones are kept\n{}", how_to_continue());
    let tidy = move || output.iter().for_each(|output| slipmap_format::remove_unfinished(output));
    interrupt::on_abandonment(left, tidy);
}

/// The failure for a run that ended early.
fn stopped(map: &PartialMap, error: &ComputeError<StoreError>, output: &Path) -> Failure {
    // An error of syncing is ignored in favour of the error that stopped the run.
    let _ = map.sync();
    let (done, all) = (map.tiles(), map.found.tiles());
    match error {
        ComputeError::Interrupted if done == 0 => Failure::Interrupted("no tile was finished".into()),
        ComputeError::Interrupted => Failure::Interrupted(format!(
            "{} of {} finished and kept\n{}",
            count(done),
            number_of(all, "tile"),
            how_to_continue()
        )),
        ComputeError::Threads(why) => threads::not_started(why),
        // The journal of a map without a tile ends with the run.
        ComputeError::Sink(error) if done == 0 => Failure::Broken(error.to_string()),
        ComputeError::Sink(error) => Failure::Broken(with_how_to_continue(error, output)),
    }
}

/// An error of the file system, and whether finished tiles are kept.
pub(super) fn with_how_to_continue(error: &StoreError, output: &Path) -> String {
    let kept = match slipmap_format::any_tile(output) {
        Ok(Some(_)) => "finished tiles are kept; when the cause is fixed",
        Err(StoreError::Lost { .. }) => "the finished tiles that reached it are kept; when it is back",
        _ => return error.to_string(),
    };
    format!("{error}\n  {kept},\n{}", how_to_continue())
}

/// The command that continues this one.
fn how_to_continue() -> String {
    let mut arguments = command_line();
    let is_run = arguments.get(1).is_some_and(|command| command == "run");
    let resumes = |argument: &String| argument == "--resume" || argument.starts_with("--shard");
    if is_run && !arguments.iter().any(resumes) {
        arguments.retain(|argument| argument != "--overwrite");
        arguments.push("--resume".into());
    }
    format!("  to continue: {}", arguments.join(" "))
}

/// Failures to create or find the map are bad input; later failures are not.
pub(super) fn refused(error: StoreError) -> Failure {
    let help = match error {
        StoreError::Unfinished { .. } => {
            "\n  help: add --resume to continue it, or --overwrite to start anew"
        }
        StoreError::Damaged { .. } => {
            "\n  help: `slipmap check` on it tells where; take an undamaged copy, or start anew with --overwrite"
        }
        StoreError::Changed { .. } => "\n  help: go back to what it was, or start anew with --overwrite",
        StoreError::Io { ref source, .. } if source.kind() == io::ErrorKind::InvalidFilename => {
            return Failure::BadInput(format!(
                "{error}\n  help: choose a shorter name with --set output.path=.."
            ));
        }
        _ => "",
    };
    match error {
        StoreError::Exists { .. }
        | StoreError::NoFolder { .. }
        | StoreError::NoPermission { .. }
        | StoreError::Unfinished { .. }
        | StoreError::Changed { .. }
        | StoreError::Damaged { .. }
        | StoreError::NotAMap { .. } => Failure::BadInput(format!("{error}{help}")),
        _ => Failure::Broken(error.to_string()),
    }
}

/// Provenance of the files that this command computes from a configuration.
pub(super) fn provenance(job: &Job) -> Provenance {
    Provenance {
        title: job.title.clone(),
        config_path: job.config_file.display().to_string(),
        config_text: job.config_text.clone(),
        command_line: command_line().join(" "),
        git: GIT.into(),
        threads: 0,
    }
}

/// The words of the command line, quoted for a shell where needed.
fn command_line() -> Vec<String> {
    let arguments = std::env::args_os().skip(1).map(|argument| quoted(&argument.to_string_lossy()));
    std::iter::once("slipmap".to_owned()).chain(arguments).collect()
}

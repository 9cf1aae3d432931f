//! `slipmap run`: computes a map.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use clap::Args;
use indicatif::ProgressBar;
use serde_json::json;

use super::chances::Chances;
use super::output::{bytes, count, number_of};
use super::preflight::{Permission, Preflight, create_folders};
use super::report::existing;
use super::summary::{self, RunReport};
use super::{Ended, Failure, GIT, estimate, interrupt, output, progress, proof, say, threads};
use slipmap_config::Job;
use slipmap_format::{Left, Outcome, PartialMap, Provenance, Resumed, StoreError};
use slipmap_map::clock::process_time;
use slipmap_map::map::{self, ComputeError, Control, Earlier, Queue};
use slipmap_map::risk::NoRisk;

/// Compute a map from a configuration file.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap run configs/quickstart.toml
  slipmap run configs/paper.toml --dry-run
  slipmap run configs/paper.toml --set grid.V=2.5 --set output.path=results/fast-belt.h5 --threads 8
  slipmap run configs/paper.toml --resume

The configuration is explained in configs/quickstart.toml. The map appears under its name only when it is
complete; the folders that its path names are created. Finished tiles are kept in NAME.part beside it until
then: a run that was stopped, by whatever, goes on with --resume as if nothing had happened.")]
pub(super) struct Arguments {
    /// The configuration
    #[arg(value_name = "CONFIG.toml")]
    config: PathBuf,
    /// Replace one value of the configuration; may be repeated. The value is TOML; a bare word is text
    #[arg(long = "set", value_name = "key.path=value")]
    sets: Vec<String>,
    /// Number of threads; default: one per core, at most 16 per core. With --dry-run: of any machine
    #[arg(long, value_name = "NUMBER", value_parser = threads::parse_anywhere)]
    threads: Option<usize>,
    /// Print how large the map would be and how long it would take, and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Continue an interrupted run; starts one if there is none, and does nothing if the map is complete
    #[arg(long, conflicts_with = "overwrite")]
    resume: bool,
    /// Replace the map, or what an interrupted run has left of it
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
    if !arguments.dry_run {
        threads::check(arguments.threads)?;
    }
    match prepare(arguments, Job::load(&arguments.config, &arguments.sets)?)? {
        None => Ok(Ended::Fine),
        Some((job, map)) => compute(arguments, &job, map, stop),
    }
}

/// Does everything before the computation; `None` if nothing is left to compute.
fn prepare(arguments: &Arguments, job: Job) -> Result<Option<(Job, PartialMap)>, Failure> {
    let permission = match (arguments.overwrite, arguments.resume) {
        (true, _) => Permission::Overwrite,
        (false, true) => Permission::Resume,
        (false, false) => Permission::None,
    };
    tell_units(&job.conversions);
    let preflight = Preflight::check(&job, permission)?;
    match job.plan.grid().machine() {
        Some(machine) => super::probe_machine::warn(machine),
        None => super::probe_machine::warn_of_law(job.plan.grid().law()),
    }
    if arguments.dry_run {
        if let Some(refused) = &preflight.refuses {
            say(&format!("note: the run itself would be refused: {refused}"));
        }
        estimate::run(&job, &preflight, arguments.threads, arguments.json)?;
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
    let name = job.output.display();
    let provenance = provenance(&job);
    let map = if arguments.resume {
        match PartialMap::resume(&job.output, &job.plan, &provenance).map_err(create_failure)? {
            Resumed::Partial(map) => *map,
            Resumed::Complete => {
                say(&format!("note: {name} is complete already; nothing was computed"));
                if arguments.json {
                    output::print_json(
                        &json!({ "output": job.output.to_string_lossy(), "complete_already": true }),
                    )?;
                }
                return Ok(None);
            }
        }
    } else {
        for replaced in preflight.replaces.iter().chain(&preflight.replaces_proof) {
            say(&format!("note: {replaced} will be replaced"));
        }
        PartialMap::begin(&job.output, &job.plan, &provenance, existing(arguments.overwrite))
            .map_err(create_failure)?
    };
    report_resumption(&map, arguments.resume);
    abandon_in_time(job.output.clone());
    Ok(Some((job, map)))
}

/// Computes the missing tiles, completes the map, and reports.
fn compute(arguments: &Arguments, job: &Job, map: PartialMap, stop: &AtomicBool) -> Result<Ended, Failure> {
    let start = Instant::now();
    let bar = progress::bar(arguments.quiet, Some(job.plan.grid.cells() as u64), "cells");
    let planes = std::sync::OnceLock::new();
    bar.inc(map.account().cells);
    let resumed_tiles = map.tiles();
    let queue = Queue::new(map.finished().to_vec());
    let on_cells = |cells| bar.inc(cells as u64);
    let on_plane = || planes.get().map_or((), |bar: &ProgressBar| bar.inc(1));
    let threads = arguments.threads;
    let control = Control { threads, on_cells: &on_cells, on_plane: &on_plane, stop };
    let earlier_seconds = map.found.seconds;
    let earlier = Earlier { account: map.account().clone(), seconds: earlier_seconds };
    let computed = map::run_with(&job.plan, &control, earlier, || {
        let computed = map::compute_tiles(&job.plan, &map, &control, &|| queue.take());
        bar.finish_and_clear();
        let count = job.plan.planes.len() as u64;
        planes.get_or_init(|| progress::bar(arguments.quiet || count == 0, Some(count), "planes of curves"));
        computed
    });
    if let Some(bar) = planes.get() {
        bar.finish_and_clear();
    }
    let summary = match computed {
        Ok(summary) => summary,
        Err(error) => return Err(stopped(&map, &error, &job.output)),
    };
    if let (Some(path), Some(proved)) = (&job.proof, &summary.proved) {
        proof::write(&proved.proof, &job.identity(GIT), path, arguments.overwrite)?;
    }
    let mut outcome = Outcome::of(&job.plan, &summary);
    let mut probability_seconds = 0.0;
    if let Some(chances) = Chances::of(job) {
        let processor = process_time();
        match chances.variable(threads, stop) {
            Ok(variable) => outcome.auxiliary.push(variable),
            Err(NoRisk::Interrupted) => return Err(stopped(&map, &ComputeError::Interrupted, &job.output)),
            Err(why) => say(&format!("note: {why}; the map has no probability")),
        }
        probability_seconds = (process_time() - processor).as_secs_f64();
    }
    map.finish(&outcome).map_err(|error| Failure::Broken(with_how_to_continue(&error, &job.output)))?;

    let seconds = earlier_seconds + start.elapsed().as_secs_f64();
    let report = RunReport { job, summary: &summary, probability_seconds, seconds, resumed_tiles };
    let printed = match arguments.json {
        true => summary::json(&report),
        false => summary::print(&report, &mut io::stdout().lock()),
    };
    match printed {
        // A flawed map is reported even if standard output was closed.
        Ok(()) | Err(Failure::ReaderGone) if report.is_flawed() => Ok(Ended::Flawed),
        Ok(()) => Ok(Ended::Fine),
        Err(failure) => Err(failure),
    }
}

/// Prints what units in the configuration are in SI.
pub(super) fn tell_units(conversions: &[String]) {
    if !conversions.is_empty() {
        say(&format!("note: {}", conversions.join(", ")));
    }
}

/// Prints the state of the run to be continued, and whether it is locked.
fn report_resumption(map: &PartialMap, resume: bool) {
    let (done, all) = (map.tiles(), map.finished().len());
    if done > 0 {
        say(&format!("note: resuming with {} of {} finished", count(done), number_of(all, "tile")));
    } else if resume {
        say("note: there is nothing to resume; starting from the beginning");
    }
    if map.found.lost > 0 {
        say(&format!(
            "note: the last {} of the finished tiles are cut short or damaged; they are computed again",
            bytes(map.found.lost.into())
        ));
    }
    if !map.is_locked() {
        say("warning: this file system knows no locks; take care that no second run writes the same map");
    }
}

/// Abandons tiles that take too long after an interruption. The journal holds each tile whole or not at all,
/// whatever other threads are doing.
fn abandon_in_time(output: PathBuf) {
    let left = format!("the tiles in work were given up, finished ones are kept\n{}", how_to_continue());
    interrupt::on_abandonment(left, move || slipmap_format::remove_unfinished(&output));
}

/// The failure for a run that ended early.
fn stopped(map: &PartialMap, error: &ComputeError<StoreError>, output: &Path) -> Failure {
    // An error of syncing is ignored in favour of the error that stopped the run.
    let _ = map.sync();
    let (done, all) = (map.tiles(), map.finished().len());
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
fn with_how_to_continue(error: &StoreError, output: &Path) -> String {
    match slipmap_format::left(output) {
        Left::Nothing => error.to_string(),
        Left::Journal => {
            format!("{error}\n  finished tiles are kept; when the cause is fixed,\n{}", how_to_continue())
        }
        Left::OutOfReach => {
            format!(
                "{error}\n  the finished tiles that reached it are kept; when it is back,\n{}",
                how_to_continue()
            )
        }
    }
}

/// The command that continues this run.
fn how_to_continue() -> String {
    let mut arguments = command_line();
    if !arguments.contains(&"--resume".to_owned()) {
        arguments.retain(|argument| argument != "--overwrite");
        arguments.push("--resume".into());
    }
    format!("  to continue: {}", arguments.join(" "))
}

/// Failures to create the map are bad input; later failures are not.
fn create_failure(error: StoreError) -> Failure {
    let help = match error {
        StoreError::Unfinished { .. } => {
            "\n  help: add --resume to continue it, or --overwrite to start anew"
        }
        StoreError::Unusable { .. } => "\n  help: start anew with --overwrite",
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
        | StoreError::Busy { .. }
        | StoreError::InTheWay { .. }
        | StoreError::Unfinished { .. }
        | StoreError::Unusable { .. }
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
    }
}

/// The words of the command line, quoted for a shell where needed.
fn command_line() -> Vec<String> {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    let quoted = std::env::args_os().skip(1).map(|argument| {
        let text = argument.to_string_lossy().into_owned();
        if !text.is_empty() && text.chars().all(plain) {
            text
        } else {
            format!("'{}'", text.replace('\'', "'\\''"))
        }
    });
    std::iter::once("slipmap".to_owned()).chain(quoted).collect()
}

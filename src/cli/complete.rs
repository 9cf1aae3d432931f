//! What `run` and `merge` do when all tiles are there: the curves and proofs of the whole, and the report.

use std::io;
use std::sync::OnceLock;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use indicatif::ProgressBar;

use super::chances::notes_on_draws;
use super::summary::{self, RunReport};
use super::{Ended, Failure, WRITTEN_BY, progress, proof, say};
use slipmap_certify::certificate::Certificate;
use slipmap_config::Job;
use slipmap_format::{Journals, Outcome, StoreError};
use slipmap_machine::risk::NoRisk;
use slipmap_map::clock::process_time;
use slipmap_map::dataset::auxiliary;
use slipmap_map::{Account, Chances, ComputeError, Control, Earlier, Summary};

/// Options of a command that makes a map.
pub(super) struct Asked {
    pub(super) threads: Option<usize>,
    /// Whether an existing certificate is replaced; that of a run that goes on may be its own.
    pub(super) replaces_proof: bool,
    pub(super) json: bool,
    pub(super) quiet: bool,
}

/// A map that lacks nothing but its file.
pub(super) struct Computed {
    start: Instant,
    summary: Summary,
    pub(super) outcome: Outcome,
    /// Processor seconds of the probabilities.
    probability_seconds: f64,
    /// Seconds of the processes that computed tiles before this one, and the number of these tiles.
    earlier: (f64, usize),
}

/// The certificate of every column of a map.
fn of_columns(job: &Job, threads: Option<usize>) -> Result<Certificate, Failure> {
    let Some((law, columns)) = slipmap_map::columns(&job.plan.grid) else {
        let problem = "the friction law in dimensionless form differs from column to column".to_owned();
        return Err(Failure::bad_input(problem, "leave validated.proof out"));
    };
    let certificate = || Certificate::of_columns(&law, &columns, WRITTEN_BY);
    slipmap_map::pool(threads)
        .map(|pool| pool.install(certificate))
        .map_err(|error| Failure::Broken(format!("cannot start threads: {error}")))
}

/// Computes the missing tiles by `tiles`, and all that a map holds beside its cells. `stopped` makes the failure
/// of a computation that ended early.
pub(super) fn compute(
    asked: &Asked,
    job: &Job,
    found: &Journals,
    stop: &AtomicBool,
    tiles: impl FnOnce() -> Result<(Account, usize), ComputeError<StoreError>>,
    stopped: impl Fn(&ComputeError<StoreError>) -> Failure,
) -> Result<Computed, Failure> {
    let start = Instant::now();
    let planes = OnceLock::new();
    let on_plane = || planes.get().map_or((), |bar: &ProgressBar| bar.inc(1));
    let proofs = OnceLock::new();
    let all = job.plan.proof_boxes as u64;
    let on_boxes = |tried: usize| {
        let bar = proofs.get_or_init(|| progress::bar(asked.quiet, Some(all), "boxes of parameters"));
        bar.set_position(tried as u64);
    };
    let threads = asked.threads;
    let control = Control { threads, on_plane: &on_plane, on_boxes: &on_boxes, stop, ..Control::default() };
    let earlier = Earlier { account: found.account.clone(), seconds: found.seconds };
    let computed = slipmap_map::run_with(&job.plan, &control, earlier, || {
        // Of all processes that had tiles.
        let computed = tiles().map(|(account, threads)| (account, threads.max(found.threads)));
        let count = job.plan.planes.len() as u64;
        planes.get_or_init(|| progress::bar(asked.quiet || count == 0, Some(count), "planes of curves"));
        computed
    });
    for bar in planes.get().into_iter().chain(proofs.get()) {
        bar.finish_and_clear();
    }
    let summary = computed.map_err(|error| stopped(&error))?;
    if let Some(path) = &job.proof {
        let certificate = match &summary.proved {
            Some(proved) => Certificate::of_box(&proved.proof, WRITTEN_BY),
            None => of_columns(job, asked.threads)?,
        };
        proof::write(&certificate, path, asked.replaces_proof)?;
    }
    let mut outcome = Outcome::of(&job.plan, &summary);
    let mut probability_seconds = 0.0;
    if let Some(chances) = Chances::of(&job.plan.grid, &job.uncertain) {
        let processor = process_time();
        match chances.probabilities(asked.threads, stop) {
            Ok(found) => {
                let draws = chances.draws * job.plan.grid.column_count();
                for note in notes_on_draws(draws, found.failed, found.redrawn) {
                    say(&format!("note: {note}"));
                }
                let pieces = auxiliary::probabilities(found.values, found.by_itself, chances.draws);
                outcome.auxiliary.extend(pieces);
            }
            Err(NoRisk::Interrupted) => return Err(stopped(&ComputeError::Interrupted)),
            Err(why) => say(&format!("note: {why}; the map has no probability")),
        }
        probability_seconds = (process_time() - processor).as_secs_f64();
    }
    let earlier = (found.seconds, found.finished_tiles());
    Ok(Computed { start, summary, outcome, probability_seconds, earlier })
}

/// Reports on a map that was made.
pub(super) fn report(asked: &Asked, job: &Job, computed: &Computed) -> Result<Ended, Failure> {
    let &Computed { start, ref summary, probability_seconds, earlier: (before, resumed_tiles), .. } =
        computed;
    let seconds = before + start.elapsed().as_secs_f64();
    let report = RunReport { job, summary, probability_seconds, seconds, resumed_tiles };
    let printed = match asked.json {
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

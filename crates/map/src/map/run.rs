//! A whole run: every cell of the map, the curves in its planes, and the proofs between its nodes.

use std::sync::atomic::Ordering;
use std::time::Instant;

use super::account::Account;
use super::engine::{ComputeError, Control, Queue, Summary, compute_tiles};
use super::{Plan, Sink, curves_of, prove};
use crate::clock::process_time;

/// The work of earlier runs of the same plan, for a resumed run.
#[derive(Clone, Debug)]
pub struct Earlier {
    /// The sum of the accounts of the tiles that they finished.
    pub account: Account,
    /// Wall-clock seconds that they took.
    pub seconds: f64,
}

impl Earlier {
    /// No earlier runs.
    pub(crate) fn none(plan: &Plan) -> Self {
        Self { account: Account::none(plan), seconds: 0.0 }
    }
}

/// Computes everything that `plan` requests: cells go into `sink`, all other results into the summary.
///
/// # Errors
/// [`ComputeError`]; the sink then holds an incomplete map.
pub fn run<S: Sink>(plan: &Plan, sink: &S, control: &Control) -> Result<Summary, ComputeError<S::Error>> {
    let queue = Queue::new(vec![false; plan.tile_count()]);
    let tiles = || compute_tiles(plan, sink, control, &|| queue.take());
    run_with(plan, control, Earlier::none(plan), tiles)
}

/// As [`run`], with tiles computed by the function `tiles`, after `earlier` runs have finished some of them.
/// `tiles` returns the sum of the accounts of its tiles, and the number of workers.
///
/// # Errors
/// Those of `tiles`, and [`ComputeError`].
pub fn run_with<E: std::error::Error>(
    plan: &Plan,
    control: &Control,
    earlier: Earlier,
    tiles: impl FnOnce() -> Result<(Account, usize), ComputeError<E>>,
) -> Result<Summary, ComputeError<E>> {
    let (start, processor) = (Instant::now(), process_time());
    let (mut account, threads) = tiles()?;
    let rest = (process_time() - processor).as_secs_f64() - account.processor_seconds();
    account.stages.other += rest.max(0.0);
    account.add(earlier.account);
    let mut summary = Summary::new(account, threads, earlier.seconds + start.elapsed().as_secs_f64());
    if !plan.planes.is_empty() {
        let (start, processor) = (Instant::now(), process_time());
        let curves = curves_of(&plan.grid, &plan.planes, control.threads, control.on_plane, control.stop);
        summary.curves = curves.ok_or_else(|| ComputeError::Threads("for the curves".into()))?;
        summary.curves_seconds = start.elapsed().as_secs_f64();
        summary.account.stages.curves += (process_time() - processor).as_secs_f64();
    }
    let processor = process_time();
    summary.proved = prove(plan, control.threads, control.stop);
    summary.account.stages.proofs += (process_time() - processor).as_secs_f64();
    if control.stop.load(Ordering::Relaxed) {
        return Err(ComputeError::Interrupted);
    }
    Ok(summary)
}

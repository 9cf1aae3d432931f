//! A whole run: every cell of the map, the curves in its planes, and the proofs between its nodes.

use std::collections::HashSet;
use std::sync::atomic::Ordering;
use std::time::Instant;

use super::account::Account;
use super::engine::{ComputeError, Control, Queue, Summary, compute_tiles};
use super::proved::prove;
use super::{Plan, Plane, PlaneCurves, Sink, pool};
use crate::clock::process_time;
use rayon::prelude::*;

/// The work of earlier runs of the same plan, for a resumed run.
#[derive(Clone, Debug)]
pub struct Earlier {
    /// The sum of the accounts of the tiles that they finished.
    pub account: Account,
    /// Wall-clock seconds that they took.
    pub seconds: f64,
}

/// Computes everything that `plan` requests: cells go into `sink`, all other results into the summary.
///
/// # Errors
/// [`ComputeError`]; the sink then holds an incomplete map.
pub fn run<S: Sink>(plan: &Plan, sink: &S, control: &Control) -> Result<Summary, ComputeError<S::Error>> {
    let queue = Queue::new(plan.tile_count(), HashSet::new());
    let tiles = || compute_tiles(plan, sink, control, &|| queue.take());
    run_with(plan, control, Earlier { account: Account::none(plan), seconds: 0.0 }, tiles)
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
    account.audit.sort();
    let mut summary = Summary {
        seconds: earlier.seconds + start.elapsed().as_secs_f64(),
        threads,
        account,
        proved: None,
        curves: Vec::new(),
        curves_seconds: 0.0,
    };
    if !plan.planes.is_empty() {
        let (start, processor) = (Instant::now(), process_time());
        let pool = pool(control.threads).map_err(|_| ComputeError::Threads("for the curves".into()))?;
        let of = |plane: &Plane| {
            let curves = PlaneCurves::of(&plan.grid, plane.clone(), control.stop);
            (control.on_plane)();
            curves
        };
        summary.curves = pool.install(|| plan.planes.par_iter().map(of).collect());
        summary.curves_seconds = start.elapsed().as_secs_f64();
        summary.account.stages.curves += (process_time() - processor).as_secs_f64();
    }
    let processor = process_time();
    summary.proved = prove(plan, control);
    summary.account.stages.proofs += (process_time() - processor).as_secs_f64();
    if control.stop.load(Ordering::Relaxed) {
        return Err(ComputeError::Interrupted);
    }
    Ok(summary)
}

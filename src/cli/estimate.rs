//! Estimates the size of a map and the duration of its run from a sample of its columns: for
//! `slipmap run --dry-run`, and for the check of the disk's free space. What is computed beside the cells is
//! told by its budget.

use std::io::{self, Write as _};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde_json::json;

use super::output::{self, Align, TextTable, bytes, count, duration, number_of, object};
use super::preflight::{Preflight, peak, sizes};
use super::threads::cores;
use super::{Ended, Failure};
use slipmap_column::bifurcation::MOST_CURVE_WORK;
use slipmap_column::continuation::MOST_POINTS;
use slipmap_config::Job;
use slipmap_format::LengthSink;
use slipmap_map::clock::process_time;
use slipmap_map::dataset::Schema;
use slipmap_map::{Chances, Control, Grid, Plan, Shard};
use slipmap_numbers::text::short;

/// Duration above which a sample is extrapolated.
const ENOUGH: Duration = Duration::from_millis(200);
/// Duration after which a sample is stopped.
const TOO_LONG: Duration = Duration::from_secs(1);
/// Factor from the number of columns of a sample to that of the next.
const GROWTH: usize = 4;

/// Bytes of a map beside its tiles, measured on maps of one cell: of the file, and of each variable (its
/// attributes and the index of its chunks).
const FILE_BYTES: u128 = 24_000;
const VARIABLE_BYTES: u128 = 5_500;

/// Estimates from a sample of a plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampled {
    /// Processor seconds of the cells of the map.
    processor_seconds: f64,
    /// Bytes of the file.
    pub(super) packed: u128,
    /// Whether these are upper bounds: the sample is smaller than a tile, whose initial work then counts more,
    /// or its columns lie too far apart to be interpolated as those of the map are.
    at_most: bool,
}

/// What a run computes beside the cells, as far as it is requested, each with its bound.
fn budgets(job: &Job) -> Vec<(&'static str, String)> {
    let plan = &job.plan;
    let audited = plan.audit_cells.min(plan.grid.cells());
    let mut budgets = Vec::new();
    if audited > 0 {
        budgets.push(("audit", format!("of {} by the independent engine", number_of(audited, "cell"))));
    }
    if !plan.planes.is_empty() {
        let planes = number_of(plan.planes.len(), "plane");
        let each = format!("at most {} points", count(MOST_POINTS));
        let work = MOST_CURVE_WORK as f64;
        budgets.push(("curves", format!("in {planes}, of each kind {each} and {work:.1e} right-hand sides")));
    }
    if plan.proof_boxes > 0 {
        budgets.push(("proof", format!("at most {} boxes", count(plan.proof_boxes))));
    }
    if let Some(chances) = Chances::of(&job.plan.grid, &job.uncertain) {
        let draws = number_of(chances.draws, "draw");
        budgets.push(("probability", format!("of stick-slip, {draws} in each column")));
    }
    budgets
}

/// Reports on `job` without computing its map.
pub(super) fn run(
    job: &Job,
    preflight: &Preflight,
    threads: Option<usize>,
    shard: Option<Shard>,
    as_json: bool,
) -> Result<Ended, Failure> {
    let plan = &job.plan;
    let grid = &plan.grid;
    let (columns, tiles) = (grid.column_count(), plan.tile_count());
    let threads = threads.unwrap_or_else(cores);
    let Sampled { processor_seconds, packed, at_most } = sampled(plan, threads.min(cores()));
    let own_tiles = shard.map_or(tiles, |shard| shard.tiles(tiles));
    // A tile is computed by one thread; the last tiles keep the others waiting.
    let rounds = own_tiles.div_ceil(threads);
    let seconds = processor_seconds * rounds as f64 / tiles.max(1) as f64;
    let budgets = budgets(job);
    if as_json {
        let axes = object(grid.axes().iter().map(|axis| (axis.name.as_str(), axis.values.len())));
        output::print_json(&json!({
            "title": job.title,
            "output": job.output.to_string_lossy(),
            "replaces": preflight.replaces[0].is_some(),
            "replaces_proof": preflight.replaces[1].is_some(),
            "axes": axes,
            "cells": grid.cells(),
            "columns": columns,
            "tiles": tiles,
            "bytes": u64::try_from(plan.bytes()).ok(),
            "packed_bytes": u64::try_from(packed).ok(),
            "peak_bytes": u64::try_from(peak(packed)).ok(),
            "free_bytes": preflight.free,
            "threads": threads,
            "shard": shard.map(|shard| shard.to_string()),
            "shard_tiles": shard.map(|_| own_tiles),
            "seconds": seconds,
            "at_most": at_most,
            "most_rhs": plan.most_work() as f64,
            "beside": object(budgets),
            "would_be_refused": preflight.refuses.is_some(),
        }))?;
        return preflight.verdict(job, packed);
    }
    let mut out = io::stdout().lock();
    writeln!(out, "{} (dry run: nothing is written)", job.title)?;
    let mut table = TextTable::new(&[("", Align::Left), ("", Align::Left)]);
    let mut line = |name: &str, text: String| table.row([name.to_owned(), text]);
    line("grid", sizes(grid));
    line(
        "cells",
        format!("{} in {}, {}", count(grid.cells()), number_of(columns, "column"), number_of(tiles, "tile")),
    );
    line("methods", plan.methods.iter().map(|method| method.name()).collect::<Vec<_>>().join(", "));
    line("fields", plan.fields.iter().map(|field| field.name()).collect::<Vec<_>>().join(", "));
    line("output", job.output.display().to_string());
    for replaced in preflight.replaces.iter().flatten() {
        line("replaces", replaced.clone());
    }
    let about = if at_most { "at most" } else { "about" };
    line(
        "size",
        format!("{} of numbers, as a compressed file {about} {}", bytes(plan.bytes()), bytes(packed)),
    );
    line("disk", format!("{about} {} while it runs: journal and map", bytes(peak(packed))));
    line("free", preflight.free.map_or("unknown".into(), |free| bytes(free.into())));
    let on = number_of(threads, "core");
    let of =
        shard.map_or(String::new(), |shard| format!(" of shard {shard} ({})", number_of(own_tiles, "tile")));
    line("time", format!("{about} {} on {on} for the cells{of}, from a sample of them", duration(seconds)));
    line(
        "bound",
        format!(
            "{} right-hand sides, if every search of a cell takes its whole budget",
            short(plan.most_work() as f64)
        ),
    );
    for (what, budget) in budgets {
        line("beside", format!("{what} {budget}"));
    }
    table.write(&mut out)?;
    drop(out);
    preflight.verdict(job, packed)
}

/// Estimates the size of a map, and the processor time of its cells, on this number of threads. Coarser grids
/// grow until one takes long enough to be extrapolated.
pub(super) fn sampled(plan: &Plan, threads: usize) -> Sampled {
    let beside = FILE_BYTES + VARIABLE_BYTES * Schema::of(plan).variables.len() as u128;
    let mut wanted = 1;
    loop {
        let sample = sample(&plan.grid, wanted);
        let Timed { cells, elapsed, seconds, packed } = timed(plan, &sample, threads);
        let whole = sample.column_count() == plan.grid.column_count();
        if seconds >= ENOUGH.as_secs_f64() || elapsed >= TOO_LONG || whole {
            let share = plan.grid.cells() as f64 / cells.max(1) as f64;
            return Sampled {
                processor_seconds: seconds * share,
                packed: (packed as f64 * share).min(plan.bytes() as f64) as u128 + beside,
                at_most: !whole && (plan.interpolates() || cells < plan.tile_shape.iter().product::<usize>()),
            };
        }
        wanted *= GROWTH;
    }
}

/// A coarser grid of at most `wanted` columns (at least one), spread over the whole grid. All dampings are
/// kept, since methods work on whole columns.
fn sample(grid: &Grid, wanted: usize) -> Grid {
    let mut kept = grid.shape();
    let outer = kept.len() - 1;
    while kept[..outer].iter().product::<usize>() > wanted {
        match kept[..outer].iter_mut().max() {
            Some(longest) if *longest > 1 => *longest = longest.div_ceil(2),
            _ => break,
        }
    }
    let nodes = grid.axes().iter().zip(&kept).map(|(axis, &kept)| spread(&axis.values, kept)).collect();
    // Nodes taken from a legal grid make a legal grid.
    grid.with_nodes(nodes).unwrap_or_else(|_| grid.clone())
}

/// Selects `kept` of the values, evenly spread: the middle of each of `kept` equal parts.
fn spread(values: &[f64], kept: usize) -> Vec<f64> {
    (0..kept).map(|i| values[(2 * i + 1) * values.len() / (2 * kept)]).collect()
}

/// Result of computing a sample.
struct Timed {
    cells: usize,
    /// Wall-clock time, to which the limits of a sample apply.
    elapsed: Duration,
    /// Seconds that it takes one core.
    seconds: f64,
    /// Packed bytes.
    packed: u64,
}

/// Computes and packs a sample.
fn timed(plan: &Plan, sample: &Grid, workers: usize) -> Timed {
    // Enough tiles to keep every thread busy.
    let tile = (sample.cells() / (4 * workers)).max(sample.dampings().len());
    let tile_shape = sample.tile_shape(tile.min(plan.tile_shape.iter().product()));
    let grid = sample.clone();
    let plan = Plan { grid, audit_cells: 0, proof_boxes: 0, planes: Vec::new(), tile_shape, ..plan.clone() };
    let (done, stop) = (AtomicUsize::new(0), AtomicBool::new(false));
    // Processor time does not grow when another program is busy.
    let (start, process) = (Instant::now(), process_time());
    let on_cells = |cells| {
        done.fetch_add(cells, Ordering::Relaxed);
        if start.elapsed() > TOO_LONG {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let packed = AtomicU64::new(0);
    let sink = LengthSink::new(&plan, |length| {
        packed.fetch_add(length as u64, Ordering::Relaxed);
    });
    let control = Control { threads: Some(workers), on_cells: &on_cells, stop: &stop, ..Control::default() };
    // An interrupted sample counts as far as it went.
    let _ = slipmap_map::run(&plan, &sink, &control);
    let elapsed = start.elapsed();
    let seconds = match cfg!(unix) {
        true => (process_time() - process).as_secs_f64(),
        false => elapsed.as_secs_f64() * workers as f64,
    };
    Timed { cells: done.load(Ordering::Relaxed), elapsed, seconds, packed: packed.load(Ordering::Relaxed) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::Law;

    #[test]
    fn samples_are_coarser_grids_with_whole_columns() {
        let nodes = |n: u32| (1..=n).map(|i| f64::from(i) / 16.0).collect::<Vec<_>>();
        let grid = Grid::new(Law::Stribeck, [3, 10, 1, 16, 5, 7].map(nodes).to_vec()).unwrap();
        for wanted in [1, 4, 16, 64, 256, 1024, 4096] {
            let sample = sample(&grid, wanted);
            assert!(sample.column_count() <= wanted.min(grid.column_count()), "{wanted}");
            assert_eq!(sample.dampings(), grid.dampings());
            for (coarse, fine) in sample.axes().iter().zip(grid.axes()) {
                assert!(coarse.values.iter().all(|value| fine.values.contains(value)));
            }
        }
        assert_eq!(sample(&grid, grid.column_count()), grid);
    }
}

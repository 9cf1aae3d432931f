//! Estimates the size of a map and the duration of its run from a sample of cells: for
//! `slipmap run --dry-run`, and for the check of the disk's free space.

use std::io::{self, Write as _};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde_json::json;

use super::chances::Chances;
use super::output::{self, Align, Table, bytes, count, duration, number_of, object};
use super::preflight::{Preflight, peak, sizes};
use super::threads::cores;
use super::{Ended, Failure};
use slipmap_config::Job;
use slipmap_format::LengthSink;
use slipmap_map::clock::{process_time, thread_time};
use slipmap_map::dataset::Schema;
use slipmap_map::map::{self, Control, Grid, Method, Plan};
use slipmap_model::filippov::Oscillator;
use slipmap_simulate::continuation::MOST_POINTS;
use slipmap_simulate::folds::MOST_SECTIONS;

/// Duration above which a sample is extrapolated.
const ENOUGH: Duration = Duration::from_millis(200);
/// Duration after which a sample is stopped.
const TOO_LONG: Duration = Duration::from_secs(1);
/// Factor from the number of columns of a sample to that of the next.
const GROWTH: usize = 4;
/// Largest number of tiles whose interpolation is timed.
const TILES: usize = 16;
/// Number of audited cells that are timed.
const AUDITED: usize = 8;

/// Duration for which the proof is sampled.
const PROOF: Duration = Duration::from_millis(500);
/// Duration after which the curves are given up: then only a lower bound of their time is known.
const CURVES: Duration = Duration::from_secs(4);

/// Bytes of a map beside its tiles, measured on maps of one cell: of the file, of each variable (its
/// attributes and the index of its chunks), and of the curves.
const FILE_BYTES: u128 = 24_000;
const VARIABLE_BYTES: u128 = 5_500;
const CURVES_BYTES: u128 = 16_000;

/// Estimates from a sample of a plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sampled {
    /// Wall-clock seconds of the cells of the map.
    seconds: f64,
    /// Bytes of the file.
    pub(super) packed: u128,
    /// Whether the sample is smaller than a tile, so that `seconds` and `packed` are upper bounds: small
    /// tiles are packed less densely, and their initial work counts more.
    at_most: bool,
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

/// The threads of the estimated run, which has a core for each, and those that compute the samples here.
#[derive(Clone, Copy, Debug)]
struct Threads {
    run: usize,
    here: usize,
}

impl Threads {
    /// All cores of this machine if `None`.
    fn of(wanted: Option<usize>) -> Self {
        let run = wanted.unwrap_or_else(cores);
        Self { run, here: run.min(cores()) }
    }

    /// The threads of the run that have work: a tile is computed by one.
    fn busy(self, plan: &Plan) -> f64 {
        self.run.min(plan.tile_count()).max(1) as f64
    }
}

/// A clock of the processor time of all threads, which, unlike wall-clock time, does not grow when another
/// program is busy.
struct Clock {
    start: Instant,
    process: Duration,
}

impl Clock {
    fn start() -> Self {
        Self { start: Instant::now(), process: process_time() }
    }

    /// Seconds of one core so far, with `workers` threads here.
    fn seconds(&self, workers: usize) -> f64 {
        if cfg!(not(unix)) {
            return self.start.elapsed().as_secs_f64() * workers as f64;
        }
        (process_time() - self.process).as_secs_f64()
    }
}

/// Estimated time of the curves.
#[derive(Clone, Copy, Debug)]
struct CurvesTime {
    /// Wall-clock seconds.
    seconds: f64,
    /// Whether they were found in that time; else it is a lower bound.
    is_complete: bool,
}

/// Reports on `job` without computing its map.
pub(super) fn run(
    job: &Job,
    preflight: &Preflight,
    threads: Option<usize>,
    as_json: bool,
) -> Result<Ended, Failure> {
    let plan = &job.plan;
    let grid = &plan.grid;
    let columns = grid.column_count();
    let tiles = plan.tile_count();
    let threads = Threads::of(threads);
    let sampled = sampled(plan, threads.run);
    let proof = proof_seconds(plan, threads);
    let chances = Chances::of(job);
    let faster = threads.run as f64 / threads.here as f64;
    let probability = chances.as_ref().map(|chances| chances.seconds(Some(threads.here)) / faster);
    let curves = curves_time(plan, Some(threads.here));
    let seconds = sampled.seconds
        + audit_seconds(plan, threads)
        + curves.map_or(0.0, |curves| curves.seconds)
        + proof.unwrap_or(0.0)
        + probability.unwrap_or(0.0);

    if as_json {
        let axes = object(grid.axes().iter().map(|axis| (axis.name.as_str(), axis.values.len())));
        output::print_json(&json!({
            "title": job.title,
            "output": job.output.to_string_lossy(),
            "replaces": preflight.replaces.is_some(),
            "replaces_proof": preflight.replaces_proof.is_some(),
            "axes": axes,
            "cells": grid.cells(),
            "columns": columns,
            "tiles": tiles,
            "bytes": u64::try_from(plan.bytes()).ok(),
            "packed_bytes": u64::try_from(sampled.packed).ok(),
            "peak_bytes": u64::try_from(peak(sampled.packed)).ok(),
            "free_bytes": preflight.free,
            "threads": threads.run,
            "seconds": seconds,
            "at_most": sampled.at_most,
            "curves_seconds": curves.map(|curves| curves.seconds),
            "curves_seconds_at_least": curves.map(|curves| !curves.is_complete),
            "proof_seconds": proof,
            "probability_seconds": probability,
            "would_be_refused": preflight.refuses.is_some(),
        }))?;
        return preflight.verdict(job, sampled.packed);
    }

    let mut out = io::stdout().lock();
    writeln!(out, "{} (dry run: nothing is written)", job.title)?;
    let mut table = Table::new(&[("", Align::Left), ("", Align::Left)]);
    let mut line = |name: &str, text: String| table.row([name.to_owned(), text]);
    line("grid", sizes(grid));
    line(
        "cells",
        format!("{} in {}, {}", count(grid.cells()), number_of(columns, "column"), number_of(tiles, "tile")),
    );
    line("methods", plan.methods.iter().map(|method| method.name()).collect::<Vec<_>>().join(", "));
    line("fields", plan.fields.iter().map(|field| field.name()).collect::<Vec<_>>().join(", "));
    if !plan.planes.is_empty() {
        let planes = number_of(plan.planes.len(), "plane");
        let (points, folds) = (count(MOST_POINTS), count(MOST_SECTIONS));
        line(
            "curves",
            format!("in {planes}, at most {points} points of each kind, {folds} of each fold curve"),
        );
    }
    line("output", job.output.display().to_string());
    for replaced in preflight.replaces.iter().chain(&preflight.replaces_proof) {
        line("replaces", replaced.clone());
    }
    let about = if sampled.at_most { "at most" } else { "about" };
    line(
        "size",
        format!("{} of numbers, as a compressed file {about} {}", bytes(plan.bytes()), bytes(sampled.packed)),
    );
    line("disk", format!("{about} {} while it runs: journal and map", bytes(peak(sampled.packed))));
    line("free", preflight.free.map_or("unknown".into(), |free| bytes(free.into())));
    if let Some(chances) = &chances {
        let draws = number_of(chances.draws, "draw");
        line(
            "probability",
            format!("of stick-slip, from {draws} of the uncertain quantities at each belt speed"),
        );
    }
    let part = |what: &str, seconds: Option<f64>| {
        seconds.map_or(String::new(), |seconds| format!(", {} of it for the {what}", duration(seconds)))
    };
    let (proof, probability) = (part("proof", proof), part("probability", probability));
    let unfinished = curves.is_some_and(|curves| !curves.is_complete);
    let (about, more) = if unfinished { ("more than", "more than ") } else { (about, "") };
    let curves = curves
        .map_or(String::new(), |curves| format!(", {more}{} of it for the curves", duration(curves.seconds)));
    let how = if sampled.at_most { "a sample smaller than a tile" } else { "the processor time of a sample" };
    let on = match threads.run > threads.here {
        true => format!(" on {} such as this machine's", number_of(threads.run, "core")),
        false => String::new(),
    };
    line("time", format!("{about} {}{on}{curves}{proof}{probability}; from {how}", duration(seconds)));
    table.write(&mut out)?;
    drop(out);
    preflight.verdict(job, sampled.packed)
}

/// Estimates size of the map, and its duration with `threads` threads.
pub(super) fn sampled(plan: &Plan, threads: usize) -> Sampled {
    let threads = Threads::of(Some(threads));
    let Sampled { seconds, packed, at_most } = by_columns(plan, threads);
    let packed = packed + fixed_bytes(plan);
    if !plan.interpolates() {
        return Sampled { seconds, packed, at_most };
    }
    // Columns that lie far apart are not interpolated: the sample gives the time of the undecided ones.
    let tests: Vec<Method> =
        plan.methods.iter().copied().filter(|method| *method != Method::Simulation).collect();
    let fields = plan.fields.iter().copied().filter(|field| !field.needs_flow()).collect();
    let rest = match tests.is_empty() {
        true => 0.0,
        false => by_columns(&Plan { methods: tests, fields, ..plan.clone() }, threads).seconds,
    };
    let (share, interpolating) = interpolated(plan, threads);
    Sampled { seconds: rest + share * (seconds - rest).max(0.0) + interpolating, packed, at_most }
}

/// The share of the map's cells that interpolation does not decide, and the duration of interpolation, from
/// tiles spread over the map.
fn interpolated(plan: &Plan, threads: Threads) -> (f64, f64) {
    let tiles = plan.tile_count();
    let chosen: Vec<usize> = match tiles <= TILES {
        true => (0..tiles).collect(),
        // The fractional parts of multiples of the golden ratio are spread evenly for every number of them.
        false => (1..=TILES)
            .map(|i| ((i as f64 * 0.618_033_988_749_894_9).fract() * tiles as f64) as usize)
            .collect(),
    };
    let clock = Clock::start();
    let mut shares = Vec::new();
    for some in chosen.chunks(threads.here) {
        shares.par_extend(some.par_iter().map(|&tile| map::open_share(plan, tile)));
        if clock.start.elapsed() > TOO_LONG {
            break;
        }
    }
    let seconds = clock.seconds(threads.here) / shares.len() as f64 * tiles as f64 / threads.busy(plan);
    (shares.iter().sum::<f64>() / shares.len() as f64, seconds)
}

/// Estimates duration and packed tiles of the map. Coarser grids grow until one takes long enough to be
/// extrapolated.
fn by_columns(plan: &Plan, threads: Threads) -> Sampled {
    let mut wanted = 1;
    loop {
        let sample = sample(&plan.grid, wanted);
        let Timed { cells, elapsed, seconds, packed } = timed(plan, &sample, threads.here);
        let whole = sample.column_count() == plan.grid.column_count();
        if seconds >= ENOUGH.as_secs_f64() || elapsed >= TOO_LONG || whole {
            let share = plan.grid.cells() as f64 / cells.max(1) as f64;
            return Sampled {
                seconds: seconds * share / threads.busy(plan),
                packed: (packed as f64 * share).min(plan.bytes() as f64) as u128,
                at_most: !whole && cells < plan.tile_shape.iter().product(),
            };
        }
        wanted *= GROWTH;
    }
}

/// Bytes of a map beside its tiles.
fn fixed_bytes(plan: &Plan) -> u128 {
    let curves = if plan.planes.is_empty() { 0 } else { CURVES_BYTES };
    FILE_BYTES + VARIABLE_BYTES * Schema::of(plan).variables.len() as u128 + curves
}

/// The time of the curves, found as a run would find them, but given up after [`CURVES`]; `None` where no
/// curves are requested.
fn curves_time(plan: &Plan, threads: Option<usize>) -> Option<CurvesTime> {
    if plan.planes.is_empty() {
        return None;
    }
    let find = |stop: &AtomicBool| {
        map::curves_of(&plan.grid, &plan.planes, threads, &|| (), stop);
    };
    let (start, (is_complete, ())) = (Instant::now(), within(CURVES, find));
    Some(CurvesTime { seconds: start.elapsed().as_secs_f64(), is_complete })
}

/// Runs `work` and sets its stop flag after `time`; returns whether it ended before, and its result.
fn within<T: Send + Default>(time: Duration, work: impl FnOnce(&AtomicBool) -> T + Send) -> (bool, T) {
    let stop = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let Ok(worker) = std::thread::Builder::new().spawn_scoped(scope, || work(&stop)) else {
            return (false, T::default());
        };
        let start = Instant::now();
        while !worker.is_finished() && start.elapsed() < time {
            std::thread::sleep(Duration::from_millis(5));
        }
        let in_time = worker.is_finished();
        stop.store(true, Ordering::Relaxed);
        // A panic is a bug and is propagated.
        (in_time, worker.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
    })
}

/// Estimated duration in seconds of the proof that the plan requests, from a sample that takes [`PROOF`].
fn proof_seconds(plan: &Plan, threads: Threads) -> Option<f64> {
    let proved = within(PROOF, |stop| map::prove(plan, Some(threads.here), stop)).1?;
    let boxes = map::boxes_to_try(plan);
    let tried = proved.volumes.tiles.clamp(1, boxes);
    Some(proved.seconds * boxes as f64 / tried as f64 * threads.here as f64 / threads.run as f64)
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
    Grid::new(grid.law().clone(), nodes).unwrap_or_else(|_| grid.clone())
}

/// Selects `kept` of the values, evenly spread: the middle of each of `kept` equal parts.
fn spread(values: &[f64], kept: usize) -> Vec<f64> {
    (0..kept).map(|i| values[(2 * i + 1) * values.len() / (2 * kept)]).collect()
}

/// Computes and packs a sample.
fn timed(plan: &Plan, sample: &Grid, workers: usize) -> Timed {
    // Enough tiles to keep every thread busy.
    let tile = (sample.cells() / (4 * workers)).max(sample.dampings().len());
    let tile_shape = sample.tile_shape(tile.min(plan.tile_shape.iter().product()));
    let grid = sample.clone();
    let plan = Plan { grid, audit_cells: 0, proof_boxes: 0, planes: Vec::new(), tile_shape, ..plan.clone() };
    let (done, stop, clock) = (AtomicUsize::new(0), AtomicBool::new(false), Clock::start());
    let on_cells = |cells| {
        done.fetch_add(cells, Ordering::Relaxed);
        if clock.start.elapsed() > TOO_LONG {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let packed = AtomicU64::new(0);
    let sink = LengthSink::new(&plan, |length| {
        packed.fetch_add(length as u64, Ordering::Relaxed);
    });
    let control = Control { threads: Some(workers), on_cells: &on_cells, stop: &stop, ..Control::default() };
    // An interrupted sample counts as far as it went.
    let _ = map::run(&plan, &sink, &control);
    Timed {
        cells: done.load(Ordering::Relaxed),
        elapsed: clock.start.elapsed(),
        seconds: clock.seconds(workers),
        packed: packed.load(Ordering::Relaxed),
    }
}

/// Estimated duration of the audit, from a few cells of it.
fn audit_seconds(plan: &Plan, threads: Threads) -> f64 {
    let cells = plan.audit_cells.min(plan.grid.cells());
    if cells == 0 {
        return 0.0;
    }
    let grid = sample(&plan.grid, AUDITED);
    let (start, mut timed) = (thread_time(), 0);
    let all = vec![1; grid.axes().len()];
    for number in (0..grid.cells()).step_by((grid.cells() / AUDITED).max(1)) {
        let tile = grid.tile(&all, number);
        let index: Vec<usize> = tile.ranges.iter().map(|range| range.start).collect();
        let oscillator = Oscillator::new(grid.law(), &grid.point(&index));
        std::hint::black_box(slipmap_witness::flow(&oscillator, plan.tolerance));
        timed += 1;
        if thread_time() - start > ENOUGH {
            break;
        }
    }
    (thread_time() - start).as_secs_f64() / f64::from(timed) * cells as f64 / threads.busy(plan)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};

    #[test]
    fn the_open_share_is_that_of_the_run() {
        let nodes = |n: u32| (1..=n).map(|i| f64::from(i) / 64.0).collect::<Vec<_>>();
        let formula = Expression::new("1 - a*u*exp(-u)", 1.0).unwrap();
        let grid = Grid::new(Law::Expression(formula), [1, 50, 120, 2].map(nodes).to_vec()).unwrap();
        let plan = Plan::builder(grid).build().unwrap();
        assert!(plan.interpolates());
        let (share, _) = interpolated(&plan, Threads::of(Some(1)));
        assert!((0.0..0.5).contains(&share), "{share}");
    }

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

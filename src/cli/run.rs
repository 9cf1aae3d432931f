//! `slipmap run`: computes a map.

use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use clap::Args;

use super::output::{bytes, count};
use super::summary::{self, Report};
use super::{Ended, Failure, estimate, interrupt, progress, proof, say};
use crate::config::Job;
use crate::map::{self, ComputeError, Control, Grid, Method, Sink, Summary, TileData, Verdict};
use crate::point::Point;
use crate::store::{self, Existing, MapWriter, Outcome, Provenance, StoreError};

/// Compute a map from a configuration file.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap run configs/quickstart.toml
  slipmap run configs/paper.toml --dry-run
  slipmap run configs/paper.toml --set grid.V=2.5 --set output.path=results/fast-belt.h5 --threads 8

The configuration is explained in configs/quickstart.toml. The map appears under its name only when it is
complete; the folders that its path names are created.")]
pub(super) struct Arguments {
    /// The configuration
    #[arg(value_name = "CONFIG.toml")]
    config: PathBuf,
    /// Replace one value of the configuration; may be repeated. The value is TOML; a bare word is text
    #[arg(long = "set", value_name = "key.path=value")]
    sets: Vec<String>,
    /// Number of threads; default: one per core
    #[arg(long, value_parser = clap::value_parser!(u16).range(1..))]
    threads: Option<u16>,
    /// Say how large the map would be and how long it would take, and write nothing
    #[arg(long)]
    dry_run: bool,
    /// Replace the map if it exists
    #[arg(long)]
    overwrite: bool,
    /// Print the summary as JSON
    #[arg(long)]
    json: bool,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let job = Job::load(&arguments.config, &arguments.sets)?;
    let room = Room::check(&job, arguments.overwrite)?;
    let threads = arguments.threads.map(usize::from);
    let stop = interrupt::flag();
    if arguments.dry_run {
        return estimate::run(&job, &room, threads, arguments.json);
    }

    create_folders(&job.output)?;
    if let Some(size) = room.replaces {
        say(&format!("note: {} ({}) will be replaced", job.output.display(), bytes(size.into())));
    }
    let existing = if arguments.overwrite { Existing::Replace } else { Existing::Refuse };
    let writer =
        MapWriter::create(&job.output, &job.plan, &provenance(&job), existing).map_err(create_failure)?;

    let bar = progress::bar(arguments.quiet, Some(job.plan.grid.cells() as u64), "cells");
    let watch = Watch { sink: &writer, grid: &job.plan.grid, found: Mutex::new(Vec::new()) };
    let control = Control { threads, on_cells: &|cells| bar.inc(cells as u64), stop };
    let computed = map::compute(&job.plan, &watch, &control);
    bar.finish_and_clear();
    let failed_cells = watch.found();
    let summary = match computed {
        Ok(summary) => summary,
        // Dropping the writer removes the temporary file.
        Err(ComputeError::Interrupted) => return Err(Failure::Interrupted),
        Err(error @ ComputeError::Threads(_)) => return Err(Failure::Broken(error.to_string())),
        Err(ComputeError::Sink(error)) => return Err(Failure::Broken(error.to_string())),
    };
    if let (Some(path), Some(proved)) = (&job.proof, &summary.proved) {
        proof::write(&proved.surface, path, arguments.overwrite)?;
    }
    writer.finish(&outcome(&job, &summary)).map_err(|error| Failure::Broken(error.to_string()))?;

    let report = Report { job: &job, summary: &summary, failed_cells: &failed_cells };
    let printed = match arguments.json {
        true => summary::json(&report),
        false => summary::print(&report, &mut io::stdout().lock()),
    };
    match printed {
        // What is wrong with the map is wrong whether or not someone reads about it.
        Ok(()) | Err(Failure::ReaderGone) if report.is_flawed() => Ok(Ended::Flawed),
        Ok(()) => Ok(Ended::Fine),
        Err(failure) => Err(failure),
    }
}

/// What is at the place of the output, and how much room there is.
#[derive(Debug)]
pub(super) struct Room {
    /// Size of the map that will be replaced, if there is one.
    pub(super) replaces: Option<u64>,
    /// Free bytes on its disk, if the system tells.
    pub(super) free: Option<u64>,
}

impl Room {
    /// Refuses an output that cannot be written, before anything is computed or created.
    fn check(job: &Job, overwrite: bool) -> Result<Self, Failure> {
        let name = job.output.display();
        let replaces = match job.output.symlink_metadata() {
            Err(_) => None,
            Ok(_) if !overwrite => {
                return Err(Failure::BadInput(format!(
                    "{name} exists already\n  help: add --overwrite to replace it, or choose another place with --set output.path=.."
                )));
            }
            Ok(metadata) => Some(metadata.len()),
        };
        if let Some(proof) = job.proof.as_ref().filter(|proof| !overwrite && proof.symlink_metadata().is_ok())
        {
            return Err(Failure::BadInput(format!(
                "{} exists already\n  help: add --overwrite to replace it, or choose another place with --set validated.proof=..",
                proof.display()
            )));
        }
        let same =
            |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
        if same(&job.output, &job.config_file) {
            return Err(Failure::BadInput(format!(
                "{name} is the configuration itself\n  help: choose another place with --set output.path=.."
            )));
        }
        let folder = first_folder(&job.output);
        // The only sure way to know whether one may write somewhere is to try; the file has no name.
        tempfile::tempfile_in(&folder).map_err(|error| {
            Failure::BadInput(format!(
                "{name}: cannot write into the folder {}: {error}\n  help: choose another place with --set output.path=..",
                folder.display()
            ))
        })?;
        let free = fs4::available_space(&folder).ok();
        let needed = job.plan.bytes();
        if let Some(free) = free.filter(|&free| needed > u128::from(free)) {
            let grid = &job.plan.grid;
            let sizes: Vec<String> = grid
                .axes()
                .iter()
                .map(|axis| format!("{} {}", axis.name, count(axis.values.len())))
                .collect();
            return Err(Failure::BadInput(format!(
                "{}: the grid has {} cells ({}), {} before compression, but {} is free for {name}\n  \
                 help: take fewer points on the longest axes or fewer output.fields, or choose another disk",
                job.config_file.display(),
                count(grid.cells()),
                sizes.join(" x "),
                bytes(needed),
                bytes(free.into())
            )));
        }
        Ok(Self { replaces, free })
    }
}

/// The folder of `output`, or the nearest above it that exists.
fn first_folder(output: &Path) -> PathBuf {
    let mut folder = output.parent();
    while let Some(path) = folder.filter(|path| !path.as_os_str().is_empty()) {
        if path.symlink_metadata().is_ok() {
            return path.to_owned();
        }
        folder = path.parent();
    }
    PathBuf::from(".")
}

fn create_folders(output: &Path) -> Result<(), Failure> {
    match output.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => std::fs::create_dir_all(folder).map_err(|error| {
            Failure::BadInput(format!(
                "the folder {} cannot be created: {error}\n  help: choose another place with --set output.path=..",
                folder.display()
            ))
        }),
        _ => Ok(()),
    }
}

/// An output that cannot be begun is bad input, a failure later is not.
fn create_failure(error: StoreError) -> Failure {
    match error {
        StoreError::Exists { .. } | StoreError::NoFolder { .. } | StoreError::NoPermission { .. } => {
            Failure::BadInput(error.to_string())
        }
        _ => Failure::Broken(error.to_string()),
    }
}

fn provenance(job: &Job) -> Provenance {
    Provenance {
        title: job.title.clone(),
        config_path: job.config_file.display().to_string(),
        config_text: job.config_text.clone(),
        command_line: command_line(),
    }
}

/// The command as one would type it.
pub(super) fn command_line() -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    let quoted = std::env::args_os().skip(1).map(|argument| {
        let text = argument.to_string_lossy().into_owned();
        if !text.is_empty() && text.chars().all(plain) {
            text
        } else {
            format!("'{}'", text.replace('\'', "'\\''"))
        }
    });
    std::iter::once("slipmap".to_owned()).chain(quoted).collect::<Vec<_>>().join(" ")
}

fn outcome(job: &Job, summary: &Summary) -> Outcome {
    let audited = job.plan.audit_cells > 0;
    Outcome {
        threads: summary.threads,
        wall_seconds: summary.seconds,
        seconds: summary.methods.iter().map(|method| (method.method, method.seconds)).collect(),
        audit: audited.then_some(store::Audit {
            cells: summary.audit.cells,
            disagreements: summary.audit.disagreements.len() as u64,
        }),
        not_computed: None,
        extra: summary
            .paths
            .named()
            .into_iter()
            .map(|(path, cells)| (format!("cells_by_{path}"), cells.cast_signed().into()))
            .chain([
                ("rhs".to_owned(), summary.rhs.cast_signed().into()),
                ("audit_seconds".to_owned(), summary.audit_seconds.into()),
                ("pack_seconds".to_owned(), summary.pack_seconds.into()),
            ])
            .chain(summary.proved.iter().flat_map(|proved| {
                let volumes = &proved.volumes;
                [
                    ("proved_present", volumes.present.into()),
                    ("proved_absent", volumes.absent.into()),
                    ("proved_undecided", volumes.undecided.into()),
                    ("proved_undecided_at_most", volumes.undecided_at_most.into()),
                    ("proved_boxes", store::Value::from(volumes.tiles.cast_signed() as i64)),
                    ("proved_seconds", proved.seconds.into()),
                ]
                .map(|(name, value)| (name.to_owned(), value))
            }))
            .collect(),
    }
}

/// A cell on which a method broke down.
#[derive(Clone, Debug)]
pub(super) struct FailedCell {
    /// Where.
    pub(super) point: Point,
    /// The method.
    pub(super) method: Method,
}

/// Notes the first failed cells on their way to the map.
struct Watch<'a, S> {
    sink: &'a S,
    grid: &'a Grid,
    /// With the number of the tile, since tiles come in any order.
    found: Mutex<Vec<(usize, FailedCell)>>,
}

/// How many failed cells are listed one by one, and noted of each tile.
pub(super) const LISTED: usize = 10;

impl<S> Watch<'_, S> {
    /// The first of the failed cells, in the order of the grid.
    fn found(&self) -> Vec<FailedCell> {
        let mut found = self.found.lock().unwrap_or_else(PoisonError::into_inner).clone();
        found.sort_by_key(|(tile, _)| *tile);
        found.into_iter().map(|(_, cell)| cell).take(LISTED).collect()
    }
}

impl<S: Sink> Sink for Watch<'_, S> {
    type Packed = S::Packed;
    type Error = S::Error;

    fn pack(&self, data: &TileData) -> Result<S::Packed, S::Error> {
        let dampings = data.tile.damping_range();
        let failed = data.methods.iter().flat_map(|cells| {
            let codes = cells.verdicts.iter().enumerate();
            codes.filter(|(_, code)| **code == Verdict::Failed.code()).map(|(cell, _)| {
                let mut index = data.tile.column_index(cell / dampings.len());
                if let Some(last) = index.last_mut() {
                    *last += cell % dampings.len();
                }
                (data.tile.number, FailedCell { point: self.grid.point(&index), method: cells.method })
            })
        });
        let failed: Vec<_> = failed.take(LISTED).collect();
        if !failed.is_empty() {
            self.found.lock().unwrap_or_else(PoisonError::into_inner).extend(failed);
        }
        self.sink.pack(data)
    }

    fn write(&self, packed: S::Packed) -> Result<(), S::Error> {
        self.sink.write(packed)
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;
    use crate::friction::Law;
    use crate::map::{MethodCells, Tile};

    /// A sink that takes anything.
    struct Anything;

    impl Sink for Anything {
        type Packed = usize;
        type Error = Infallible;

        fn pack(&self, data: &TileData) -> Result<usize, Infallible> {
            Ok(data.tile.number)
        }

        fn write(&self, _: usize) -> Result<(), Infallible> {
            Ok(())
        }
    }

    fn tile_data(tile: Tile, failed: &[usize]) -> TileData {
        let mut verdicts = vec![Verdict::Absent.code(); tile.cells()];
        for &cell in failed {
            verdicts[cell] = Verdict::Failed.code();
        }
        let methods = vec![MethodCells {
            method: Method::Simulation,
            verdicts,
            margins: Vec::new(),
            critical: Vec::new(),
        }];
        TileData { tile, methods, regime: Vec::new(), quantities: Vec::new() }
    }

    #[test]
    fn failed_cells_are_found_with_their_points() {
        let axis = |values: &[f64]| values.to_vec();
        let nodes =
            [&[0.1, 0.2][..], &[0.5], &[0.0], &[1.0, 2.0, 3.0], &[1.0], &[0.0, 0.5, 1.0, 1.5]].map(axis);
        let grid = Grid::new(Law::Stribeck, nodes.to_vec()).unwrap();
        // Two columns a tile, and a tile of one at the end of each gamma axis.
        let shape = [1, 1, 1, 2, 1, 4];
        let watch = Watch { sink: &Anything, grid: &grid, found: Mutex::new(Vec::new()) };
        let last = grid.tile_count(&shape) - 1;
        // Tiles come in any order; those found are in the grid's.
        watch.pack(&tile_data(grid.tile(&shape, last), &[2])).unwrap();
        watch.pack(&tile_data(grid.tile(&shape, 0), &[1, 7])).unwrap();
        let points: Vec<Point> = watch.found().into_iter().map(|cell| cell.point).collect();
        let at = |index: &[usize]| grid.point(index);
        assert_eq!(points, [at(&[0, 0, 0, 0, 0, 1]), at(&[0, 0, 0, 1, 0, 3]), at(&[1, 0, 0, 2, 0, 2])]);
    }
}

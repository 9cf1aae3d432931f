//! `slipmap status`: tells how far the computation of a map is.

use std::io::{self, Write as _};

use clap::Args;
use serde_json::json;

use super::configuration::Configuration;
use super::merge::{how_to_compute, ranges};
use super::output::{self, count, duration, number_of};
use super::run::{provenance, refused, report_loss};
use super::{Ended, Failure};
use slipmap_column::Verdict;
use slipmap_format::Journals;

/// Tell how far a map is.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap status configs/paper.toml
  slipmap status configs/paper.toml --json

Reads the journals beside the output, while processes write to them, and changes nothing.")]
pub(super) struct Arguments {
    #[command(flatten)]
    configuration: Configuration,
    /// Print the state as JSON
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let job = arguments.configuration.load()?;
    let found = Journals::beside(&job.output, &job.plan, &provenance(&job), None).map_err(refused)?;
    let name = job.output.to_string_lossy();
    let Some(found) = found else {
        let tiles = job.plan.tile_count();
        return match arguments.json {
            true => output::print_json(&json!({
                "output": name, "complete": true, "tiles": tiles, "done": tiles, "left": 0, "seconds_left": 0.0,
            })),
            false => Ok(writeln!(io::stdout(), "{name}: complete, {}", number_of(tiles, "tile"))?),
        }
        .map(|()| Ended::Fine);
    };
    report_loss(&found);
    let (tiles, done) = (found.tiles(), found.finished_tiles());
    let left = tiles - done;
    let failed: u64 = found.account.methods.iter().map(|method| method.cells_with(Verdict::Failed)).sum();
    // Tiles cost alike, as far as is known before they are computed.
    let seconds_left = (done > 0).then(|| found.account.processor_seconds() * left as f64 / done as f64);
    let missing = found.shards.map(|of| (of, found.missing_shards(of)));
    if arguments.json {
        output::print_json(&json!({
            "output": name,
            "complete": false,
            "tiles": tiles,
            "done": done,
            "left": left,
            "failed_cells": failed,
            "seconds_left": seconds_left,
            "journals": found.journals(),
            "shards": missing.as_ref().map(|(of, _)| of),
            "missing_shards": missing.as_ref().map(|(_, missing)| missing),
        }))?;
        return Ok(Ended::Fine);
    }
    let mut out = io::stdout().lock();
    let journals = number_of(found.journals(), "journal");
    writeln!(out, "{name}: {} of {} finished, in {journals}", count(done), number_of(tiles, "tile"))?;
    if failed > 0 {
        writeln!(out, "failed: {}", number_of(failed, "cell"))?;
    }
    if let Some((of, missing)) = missing.filter(|(_, missing)| !missing.is_empty()) {
        writeln!(out, "missing: tiles of shards {} of {of}", ranges(&missing))?;
    }
    if let Some(seconds) = seconds_left.filter(|_| left > 0) {
        writeln!(out, "left: {}, about {} of one core", number_of(left, "tile"), duration(seconds))?;
    }
    let config = arguments.configuration.words();
    match left {
        0 => writeln!(out, "to make the map: slipmap merge {config}")?,
        _ => writeln!(out, "to continue: {}", how_to_compute(&found, &config))?,
    }
    Ok(Ended::Fine)
}

//! `slipmap check`: verifies a stored map or a stored proof.

use std::cell::OnceCell;
use std::io;
use std::path::{Path, PathBuf};

use clap::Args;
use serde_json::json;

use super::output::{checked, number_of};
use super::report::unreadable;
use super::{Ended, Failure, progress, proof};

/// Verify a map file (completeness, checksums, schema), or a stored proof.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap check results/quickstart.h5
  slipmap check --proof results/validated/box.json

Exit codes: 0 sound, 1 something is wrong with it, 2 it cannot be read as a map or proof")]
pub(super) struct Arguments {
    /// The map
    #[arg(value_name = "MAP.h5", required_unless_present = "proof")]
    map: Option<PathBuf>,
    /// Prove every claim of this certificate again, by its curves
    #[arg(long, value_name = "FILE", conflicts_with = "map")]
    proof: Option<PathBuf>,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    match (&arguments.map, &arguments.proof) {
        (Some(map), _) => check_map(map, arguments.json),
        (None, Some(file)) => proof::check(file, arguments.json),
        (None, None) => Err(Failure::bad_input("nothing to check", "name a map, or a proof with --proof")),
    }
}

fn check_map(map: &Path, as_json: bool) -> Result<Ended, Failure> {
    let name = map.display();
    if map.metadata().is_err_and(|error| error.kind() == io::ErrorKind::NotFound) {
        return Err(Failure::bad_input(format!("{name}: there is no such file"), "check the path"));
    }
    if map.is_dir() {
        return Err(Failure::bad_input(format!("{name}: this is a folder"), "name a map file inside it"));
    }
    if slipmap_format::is_journal(map) {
        let problem = format!("{name}: these are the tiles of a run that was interrupted, not yet a map");
        return Err(Failure::bad_input(problem, "end it by the command that began it, with --resume"));
    }
    let bar = OnceCell::new();
    let on_chunk = |all| bar.get_or_init(|| progress::bar(false, Some(all as u64), "chunks")).inc(1);
    let report = slipmap_format::check(map, &on_chunk).map_err(|error| unreadable(&error))?;
    if let Some(bar) = bar.get() {
        bar.finish_and_clear();
    }
    let problems: Vec<String> = report.problems.iter().map(ToString::to_string).collect();
    if report.variables == 0 {
        let problem = format!("{name} cannot be read as a map:\n  {}", problems.join("\n  "));
        return Err(Failure::bad_input(problem, "name a file written by `slipmap run`"));
    }
    let json = json!({
        "map": map.to_string_lossy(),
        "sound": report.is_sound(),
        "variables": report.variables,
        "cells": report.cells,
        "tiles": report.tiles,
        "problems": problems,
    });
    let what = format!(
        "{name}: {} over {} in {}\n\
         checked: the seal of the whole file, layout and attributes, fingerprints, that every cell is legal",
        number_of(report.variables, "variable"),
        number_of(report.cells, "cell"),
        number_of(report.tiles, "tile")
    );
    checked(as_json, &json, &what, &problems, "the map is complete and unchanged since its run")
}

//! `slipmap check`: verifies a stored map.

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::output::{count, json, tame};
use super::{Ended, Failure};
use crate::store;

/// Verify a map file: completeness, checksums, schema.
#[derive(Debug, Args)]
#[command(after_help = "\
Example:
  slipmap check results/quickstart.h5

Exit codes: 0 sound, 1 something is wrong with it, 2 it cannot be read as a map")]
pub(super) struct Arguments {
    /// The map
    #[arg(value_name = "MAP.h5")]
    map: PathBuf,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let name = arguments.map.display();
    if !arguments.map.exists() {
        return Err(Failure::BadInput(format!("{name}: there is no such file\n  help: check the path")));
    }
    if arguments.map.is_dir() {
        return Err(Failure::BadInput(format!(
            "{name}: this is a folder\n  help: name a map file inside it"
        )));
    }
    let report = store::check(&arguments.map).map_err(|error| Failure::BadInput(error.to_string()))?;
    let problems: Vec<String> = report.problems.iter().map(ToString::to_string).collect();
    if report.variables == 0 {
        return Err(Failure::BadInput(format!(
            "{name} cannot be read as a map:\n  {}\n  help: name a file written by `slipmap run`",
            problems.join("\n  ")
        )));
    }
    if arguments.json {
        json(&json!({
            "map": arguments.map.to_string_lossy(),
            "sound": report.is_sound(),
            "variables": report.variables,
            "cells": report.cells,
            "tiles": report.tiles,
            "problems": problems,
        }))?;
    } else {
        let mut out = io::stdout().lock();
        writeln!(
            out,
            "{name}: {} variables over {} cells in {} tiles\n\
             checked: the seal of the whole file, layout and attributes, fingerprints, that every cell is legal",
            report.variables,
            count(report.cells),
            count(report.tiles)
        )?;
        match problems.len() {
            0 => writeln!(out, "sound: the map is complete and unchanged since its run")?,
            n => writeln!(out, "{n} problem{}:", if n == 1 { "" } else { "s" })?,
        }
        for problem in &problems {
            writeln!(out, "  {}", tame(problem))?;
        }
    }
    Ok(if report.is_sound() { Ended::Fine } else { Ended::Flawed })
}

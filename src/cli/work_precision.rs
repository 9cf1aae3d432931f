//! `slipmap work-precision`: measures speed against accuracy.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

use clap::Args;

use super::configuration::Configuration;
use super::replace::Files;
use super::report::{existing, failure};
use super::width::{TWO, width};
use super::{Ended, Failure, interrupt, progress};
use slipmap_report::figure::Width;
use slipmap_report::work_precision::{add_peers, write_study};
use slipmap_study::benchmark::{Study, contestants};

/// Chart the time per cell of every method and engine against its error, each over its own knob, on the same
/// cells, against a reference of more than 20 digits.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap work-precision configs/work-precision.toml
  slipmap work-precision configs/work-precision.toml --set work_precision.cells=256 --out quick

Cells are drawn from the box that the configuration's [grid] spans. Writes work-precision.csv and .tex, the \
chart as .svg, .pdf and .png, and cells.csv, on which `scripts/study peers --cells-from DIR/cells.csv --out \
DIR/peers.csv` measures other people's integrators. Run this command again afterwards, and they are in the chart.")]
pub(super) struct Arguments {
    #[command(flatten)]
    configuration: Configuration,
    /// The folder to write; default: results/ and the name of the configuration
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Width of the chart, in columns of a journal
    #[arg(long, value_parser = width(), default_value = TWO)]
    width: Width,
    /// Replace the files of an earlier study
    #[arg(long)]
    overwrite: bool,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let job = arguments.configuration.load()?;
    super::summary::refuse_machine(&job)?;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let name = arguments.configuration.config.file_stem().unwrap_or_default();
        Path::new("results").join(name)
    });
    let config = [&arguments.configuration.config];
    Files::reading(config)
        .law(job.plan.grid.law())
        .writing("--out", Some(&folder))
        .check(arguments.overwrite)?;
    let who = contestants();
    let bar = progress::bar(arguments.quiet, Some(who.len() as u64), "settings");
    let on_row = |done: usize| bar.set_position(done as u64);
    let stop = interrupt::flag();
    let go_on = || !stop.load(Ordering::Relaxed);
    let mut study = Study::run(&job.plan.grid, job.work_precision, &who, &on_row, &go_on).map_err(failure)?;
    bar.finish_and_clear();
    add_peers(&mut study, &folder).map_err(failure)?;
    let existing = existing(arguments.overwrite);
    write_study(&study, &folder, existing, arguments.width).map_err(failure)?;
    writeln!(io::stdout().lock(), "{}", folder.join("work-precision.csv").display())?;
    Ok(Ended::Fine)
}

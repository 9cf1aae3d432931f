//! `slipmap plot`: one variable on one slice of a stored map.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use super::output::{exact, short};
use super::replace::{self, Kind};
use super::report::{existing, failure, open};
use super::{Ended, Failure, say};
use crate::report::figure::{self, Plot, Width};
use crate::report::{Existing, ReportError, write_figure, write_file};

/// Draw one slice of a map.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap plot results/quickstart.h5 --x gamma --y c --out slice.svg
  slipmap plot results/quickstart.h5 --x alpha --y gamma --at c=0.5 --at V=2 --variable regime --out slice.png
  slipmap plot results/brake_pad.h5 --x V --y c --variable regime --curves --out brake.pdf

An axis that is neither shown nor given with --at is held at its middle node. Of an axis of more than 1,000
nodes evenly many are drawn, and it is said how many.")]
pub(super) struct Arguments {
    /// The map
    #[arg(value_name = "MAP.h5")]
    map: PathBuf,
    /// Axis across
    #[arg(long, value_name = "AXIS")]
    x: String,
    /// Axis upwards
    #[arg(long, value_name = "AXIS")]
    y: String,
    /// Hold an axis at the node nearest to a value; may be repeated
    #[arg(long, value_name = "AXIS=VALUE", value_parser = parse_at)]
    at: Vec<(String, f64)>,
    /// What to draw, for instance verdict_symmetric, critical_c_simulation, margin_simulation or regime;
    /// default: verdict_simulation
    #[arg(long, value_name = "NAME")]
    variable: Option<String>,
    /// Also draw where the behaviour changes, by continuation: Hopf bifurcations, grazing, landings past the stick
    /// segment, crossings that never end, and folds of slip cycles. Their points go to FILE.csv: curve, branch, both
    /// axes, and the distance from the curve in sides of the figure. Curves that the map stores are drawn without
    /// being asked for
    #[arg(long)]
    curves: bool,
    /// The figure; .svg, .pdf or .png
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Width of the figure: one column of a journal (84 mm) or two (174 mm)
    #[arg(long, value_enum, default_value_t = Columns::One)]
    columns: Columns,
    /// Replace the figure if it exists
    #[arg(long)]
    overwrite: bool,
}

#[derive(Clone, Copy, Debug, ValueEnum)]
enum Columns {
    #[value(name = "1")]
    One,
    #[value(name = "2")]
    Two,
}

fn parse_at(text: &str) -> Result<(String, f64), String> {
    let help = "write the name of an axis, =, and a number, for instance gamma=2.0";
    let (axis, value) = text.split_once('=').ok_or(help)?;
    let value = value.trim().parse::<f64>().map_err(|_| help)?;
    Ok((axis.trim().into(), value))
}

/// Runs the command.
pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let map = open(&arguments.map)?;
    let table = arguments.out.with_extension("csv");
    let existing = existing(arguments.overwrite);
    if arguments.overwrite {
        replace::check(&arguments.out, Some(&arguments.map), Kind::Figure)?;
        if arguments.curves {
            replace::check(&table, Some(&arguments.map), Kind::Table("curve"))?;
        }
    }
    // Known before the work is done.
    if arguments.curves && existing == Existing::Refuse && table.symlink_metadata().is_ok() {
        return Err(failure(ReportError::Exists { path: table }));
    }
    let plot = Plot {
        x: &arguments.x,
        y: &arguments.y,
        at: &arguments.at,
        variable: arguments.variable.as_deref(),
        curves: arguments.curves,
        width: match arguments.columns {
            Columns::One => Width::OneColumn,
            Columns::Two => Width::TwoColumns,
        },
    };
    let plotted = figure::plot(&map, &plot).map_err(failure)?;
    write_figure(&plotted.scene, &plotted.caption, &arguments.out, existing).map_err(failure)?;
    if let Some(curves) = plotted.curves.filter(|_| arguments.curves) {
        let text = figure::bifurcations::csv(map.grid().axes(), &curves);
        write_file(text.as_bytes(), &table, existing).map_err(failure)?;
    }
    for held in &plotted.held {
        let why = match held.wanted {
            None => " (the middle node)".into(),
            Some(wanted) if wanted == held.used => String::new(),
            Some(wanted) => format!(" (the node nearest to {})", exact(wanted)),
        };
        say(&format!("{} = {}{why}", held.axis, short(held.used)));
    }
    for (axis, step) in &plotted.thinned {
        say(&format!("{axis}: one node in {step} is drawn"));
    }
    Ok(Ended::Fine)
}

//! `slipmap plot`: variables of a stored map, over a plane or over one axis.

use std::path::PathBuf;

use clap::Args;

use super::output::{exact, short};
use super::replace::Files;
use super::report::{existing, failure, open};
use super::width::{ONE, width};
use super::{Ended, Failure, marks, say};
use slipmap_figure::write_figure;
use slipmap_files::write_file;
use slipmap_report::figure::plot::At;
use slipmap_report::figure::{self, DiagramPlot, Plot, Width, diagram};
use slipmap_report::{ReportError, View};

/// Draw variables of a map.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap plot results/quickstart.h5 --x gamma --y c --out slice.svg
  slipmap plot results/quickstart.h5 --x alpha --y gamma --at c=0.5 --at V=2 --variable regime --out slice.png
  slipmap plot results/quickstart.h5 --x gamma --y c --panels epsilon=0.1,0.2 --out panels.pdf
  slipmap plot results/quickstart.h5 --x gamma --at V=1,2,4 --variable verdict_simulation --out strips.svg
  slipmap plot results/brake_pad.h5 --x belt_speed --variable critical_damping_simulation --out c.svg --data c.csv
  slipmap plot results/brake_pad.h5 --x damping --diagram --at belt_speed=0.2 --out diagram.svg
  slipmap plot results/brake_pad.h5 --x belt_speed --y damping --variable regime --curves --out brake.pdf
  slipmap plot results/brake_pad.h5 --x belt_speed --y damping --variable regime --mark measured.csv --out marked.svg

Without --y, variables are drawn over one axis: numbers as curves, verdicts and regimes as rows of cells. An axis that \
is neither shown nor given with --at is held at its middle node. Axes of a machine are drawn, and held, in the units that \
the configuration has them in, such as rpm, all else in SI units. Of an axis of more than 1,000 nodes evenly many are \
drawn, and it is said how many.")]
pub(super) struct Arguments {
    /// The map
    #[arg(value_name = "MAP.h5")]
    map: PathBuf,
    /// Axis across
    #[arg(long, value_name = "AXIS")]
    x: String,
    /// Axis upwards; without one, variables are drawn over the axis across alone
    #[arg(long, value_name = "AXIS")]
    y: Option<String>,
    /// Hold an axis at the node nearest to a value; may be repeated. Without --y one axis may have several
    /// values, with a curve for each: --at V=1,2,4
    #[arg(long, value_name = "AXIS=VALUE", value_parser = parse_at)]
    at: Vec<At>,
    /// What to draw, for instance verdict_symmetric, critical_c_simulation, margin_simulation or regime;
    /// without --y several, with commas between them; default: verdict_simulation
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    variable: Vec<String>,
    /// A panel for each of these values of an axis: --panels beta=0,0.1,0.2,0.4
    #[arg(long, value_name = "AXIS=VALUES", value_parser = parse_at)]
    panels: Option<At>,
    /// Also draw where the behaviour changes, by continuation: Hopf bifurcations, grazing, landings past the
    /// stick segment, crossings that never end, and folds of slip cycles. Their points go to FILE.csv: curve,
    /// branch, both axes, and the distance from the curve in sides of the figure. Curves that the map stores, and those
    /// of the regimes of a machine, are drawn without being asked for
    #[arg(long, requires = "y")]
    curves: bool,
    /// Draw regimes as cells, without the curves between them
    #[arg(long, conflicts_with = "curves")]
    no_curves: bool,
    /// Mark points of a table, such as published or measured ones: below one line of headers, which may name the axes and
    /// their units, the values across and upwards, in the units of the figure, and perhaps a word for what was observed.
    /// May be repeated. The legend has the name of the file, and the words
    #[arg(long, value_name = "FILE.csv", requires = "y")]
    mark: Vec<PathBuf>,
    /// Draw the bifurcation diagram over the axis across: the amplitude of the equilibrium and of every
    /// cycle, attracting ones solid, repelling ones dashed
    #[arg(long, conflicts_with_all = ["y", "variable", "panels", "curves"])]
    diagram: bool,
    /// Ends of the diagram; default: those of the axis
    #[arg(long, value_name = "FROM,TO", value_parser = parse_range, requires = "diagram")]
    range: Option<(f64, f64)>,
    /// The figure; .svg, .pdf or .png
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Also write the numbers of the figure
    #[arg(long, value_name = "FILE.csv")]
    data: Option<PathBuf>,
    /// Width of the figure, in columns of a journal
    #[arg(long, value_parser = width(), default_value = ONE)]
    width: Width,
    /// Replace files that exist
    #[arg(long)]
    overwrite: bool,
    /// Say nothing but errors
    #[arg(long)]
    quiet: bool,
}

fn parse_at(text: &str) -> Result<At, String> {
    let help = "write the name of an axis, =, and a number, for instance gamma=2.0";
    let (axis, values) = text.split_once('=').ok_or(help)?;
    let values = values.split(',').map(|value| value.trim().parse::<f64>().map_err(|_| help));
    Ok((axis.trim().into(), values.collect::<Result<_, _>>()?))
}

fn parse_range(text: &str) -> Result<(f64, f64), String> {
    let number = |text: &str| text.trim().parse::<f64>().ok();
    let ends = text.split_once(',').and_then(|(from, to)| number(from).zip(number(to)));
    ends.ok_or_else(|| "write two numbers, for example 0.1,2".into())
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let map = open(&arguments.map)?;
    let view = View::new(&map);
    let table = arguments.out.with_extension("csv");
    let existing = existing(arguments.overwrite);
    let mut written: Vec<&PathBuf> = vec![&arguments.out];
    written.extend(arguments.curves.then_some(&table));
    written.extend(&arguments.data);
    // Checked before the work starts.
    Files::reading(arguments.mark.iter().chain([&arguments.map]))
        .writing("--out", Some(&arguments.out))
        .writing("--curves", arguments.curves.then_some(&table))
        .writing("--data", arguments.data.as_deref())
        .check(arguments.overwrite)?;
    let axes = [arguments.x.as_str(), arguments.y.as_deref().unwrap_or_default()];
    let marks = arguments.mark.iter().map(|path| marks::read(path, &view, axes));
    let marks = marks.collect::<Result<Vec<_>, Failure>>()?.concat();
    let finds = View::finds_curves(arguments.variable.first().map(String::as_str));
    let plot = Plot {
        x: &arguments.x,
        y: arguments.y.as_deref(),
        at: &arguments.at,
        variables: &arguments.variable,
        panels: arguments.panels.as_ref(),
        curves: arguments.curves || (finds && !arguments.no_curves),
        marks: &marks,
        width: arguments.width,
    };
    let plotted = match arguments.diagram {
        false => figure::plot(&view, &plot),
        true => figure::plot::one_each(&arguments.at).map_err(ReportError::from).and_then(|at| {
            let (x, width) = (arguments.x.as_str(), arguments.width);
            diagram(&view, &DiagramPlot { x, at: &at, range: arguments.range, width })
        }),
    };
    let plotted = plotted.map_err(|error| match error {
        ReportError::Choice(why) => Failure::BadInput(format!("{}: {why}", arguments.map.display())),
        error => failure(error),
    })?;
    write_figure(&plotted.scene, &plotted.caption, &arguments.out, existing).map_err(failure)?;
    if let Some(curves) = plotted.curves.filter(|_| arguments.curves) {
        let text = figure::bifurcations::data(&view, &curves).csv();
        write_file(text.as_bytes(), &table, existing).map_err(failure)?;
    }
    if let Some(path) = &arguments.data {
        write_file(plotted.data.csv().as_bytes(), path, existing).map_err(failure)?;
    }
    if arguments.quiet {
        return Ok(Ended::Fine);
    }
    for note in &plotted.notes {
        say(note);
    }
    for held in &plotted.held {
        let why = match held.wanted {
            None => " (the middle node)".into(),
            // Round-off of a conversion of units is not reported as a distance.
            Some(wanted) if (wanted - held.used).abs() <= 1e-9 * held.used.abs() => String::new(),
            Some(wanted) => format!(
                " (the node nearest to {}, {} away; nothing between the nodes is stored)",
                exact(wanted),
                short((wanted - held.used).abs())
            ),
        };
        say(&format!("{} = {}{why}", held.axis, short(held.used)));
    }
    for (axis, step) in &plotted.thinned {
        say(&format!("{axis}: one node in {step} is drawn"));
    }
    let paths: Vec<String> = written.iter().map(|path| path.display().to_string()).collect();
    say(&format!("wrote {}", paths.join(" and ")));
    Ok(Ended::Fine)
}

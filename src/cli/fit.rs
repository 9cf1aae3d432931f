//! `slipmap fit`: a friction law from measured friction.

use std::io::{self, Write as _};
use std::path::PathBuf;

use clap::Args;

use super::output::{Align, TextTable, print_json};
use super::replace::Files;
use super::report::{existing, failure};
use super::{Ended, Failure, say};
use slipmap_config::{How, Measured, ONE_AT_REST, OfMachine, law_of, words_of};
use slipmap_figure::text::rich;
use slipmap_figure::write_figure;
use slipmap_files::write_file;
use slipmap_fit::{Fit, Form};
use slipmap_numbers::text::{rounded, short, with_error};
use slipmap_page::FitFigure;

/// Fit friction laws to measured friction.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap fit brake.csv
  slipmap fit brake.csv --out friction.toml --figure fit.pdf
  slipmap init machine && slipmap fit brake.csv --machine machine.toml --out brake.toml && slipmap machine brake.toml

The laws F_k + (F_s - F_k) g(u/v_s) + B u with g exponential, gaussian, stretched (exp(-(u/v_s)^delta)), lorentzian or \
hyperbolic, two coefficients, and constant, with and without the viscous part B and, if there are readings at rest, a drop \
as slip begins. The best law by Akaike's criterion is written as a table [friction], with --machine beside the rest of a \
configuration, without its coefficients, and of forces without its normal force. Answers carry the covariance of the fit.")]
pub(super) struct Arguments {
    /// Measured friction: slip speed and friction, perhaps their standard error or the time, with units in the header
    #[arg(value_name = "DATA.csv")]
    data: PathBuf,
    /// Write the law as a table [friction] of a configuration
    #[arg(long, value_name = "FILE.toml")]
    out: Option<PathBuf>,
    /// Write the law into a copy of this configuration, in place of its friction; the copy is the file of --out
    #[arg(long, value_name = "CONFIG.toml", requires = "out")]
    machine: Option<PathBuf>,
    /// Draw the readings and the law with a band of two standard errors; .pdf, .svg or .png
    #[arg(long, value_name = "FILE")]
    figure: Option<PathBuf>,
    /// Take this law instead of the best one, by its name in the table of laws
    #[arg(long, value_name = "NAME", value_parser = parse_law)]
    law: Option<Form>,
    /// What the friction is where the header has no unit
    #[arg(long, value_name = "coefficient|force", value_parser = ["coefficient", "force"])]
    quantity: Option<String>,
    /// Divide the friction by this normal force, of a rotation a torque: the law has coefficients
    #[arg(long, value_name = "\"5 kN\"")]
    normal_force: Option<String>,
    /// Read the rows as a record over time
    #[arg(long, conflicts_with = "curve")]
    record: bool,
    /// Read the rows as independent readings, in any order
    #[arg(long)]
    curve: bool,
    /// Of which direction of slip the friction is
    #[arg(long, value_name = "forward|backward|mean", value_parser = ["forward", "backward", "mean"])]
    direction: Option<String>,
    /// Which columns are read, by name or number: speed=NAME,friction=NAME, and error, time, position, normal
    #[arg(long, value_name = "speed=NAME,friction=NAME")]
    column: Option<String>,
    /// Print JSON instead of text
    #[arg(long)]
    json: bool,
    /// Replace the files if they exist
    #[arg(long)]
    overwrite: bool,
}

/// Number of standard deviations by which residuals follow smooth curves more than by chance.
const SYSTEMATIC: f64 = 3.0;
/// Number of points of the drawn law.
const POINTS: usize = 400;

fn parse_law(name: &str) -> Result<Form, String> {
    law_of(name).map_err(|(problem, remedy)| format!("{problem}; {remedy}"))
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    Files::reading(arguments.machine.iter().chain([&arguments.data]))
        .writing("--out", arguments.out.as_deref())
        .writing("--figure", arguments.figure.as_deref())
        .check(arguments.overwrite)?;
    let forces = arguments.quantity.as_ref().map(|quantity| quantity == "force");
    let bad = |(problem, remedy): (String, String)| Failure::bad_input(problem, remedy);
    let machine = Some(OfMachine { motion: None, forces });
    let kind = match (arguments.record, arguments.curve) {
        (true, _) => Some("record"),
        (_, true) => Some("curve"),
        _ => None,
    };
    let named = How::named(kind, arguments.direction.as_deref(), arguments.column.as_deref());
    let how = named.map_err(bad)?.of(machine);
    let mut measured = Measured::read(&arguments.data, how).map_err(bad)?;
    if let Some(normal_force) = &arguments.normal_force {
        measured = measured.over(normal_force).map_err(bad)?;
    }
    if let Some(told) = measured.told() {
        say(&format!("read: {told}"));
    }
    let fits = measured.fits(arguments.law).map_err(bad)?;
    let (chosen, found) = (fits.chosen(), &fits.all);
    let existing = existing(arguments.overwrite);
    if let Some(path) = &arguments.out {
        let text = match &arguments.machine {
            None => measured.to_toml(chosen),
            Some(machine) => {
                let of_machine =
                    |(problem, remedy)| bad((format!("{}: {problem}", machine.display()), remedy));
                let text = std::fs::read_to_string(machine)
                    .map_err(|why| of_machine((why.to_string(), "name a file that can be read".into())))?;
                let (text, left_out) = measured.into_configuration(chosen, &text).map_err(of_machine)?;
                if !left_out.is_empty() {
                    say(&format!("left out, since the friction is a force: {left_out}"));
                }
                text
            }
        };
        write_file(text.as_bytes(), path, existing).map_err(failure)?;
    }
    if let Some(path) = &arguments.figure {
        write_figure(&figure(&measured, chosen).scene(), &rich("a fit of friction"), path, existing)
            .map_err(failure)?;
    }
    if arguments.json {
        print_json(&measured.fitted(&fits))?;
        return Ok(Ended::Fine);
    }
    print(&measured, chosen, found, fits.about_as_good())?;
    Ok(Ended::Fine)
}

fn print(measured: &Measured, chosen: &Fit, found: &[Fit], as_good: usize) -> io::Result<()> {
    let mut out = io::stdout().lock();
    let (slip, rest) = (measured.in_slip.len(), measured.at_rest.len());
    writeln!(out, "{}: {slip} readings in slip, {rest} at rest\n", measured.name)?;
    let (unit, best) = (measured.friction_unit(), found[0].aicc);
    let residual = format!("residual{}", bracket(unit));
    let columns =
        [("law", Align::Left), ("AICc less the best", Align::Right), (residual.as_str(), Align::Right)];
    let mut table = TextTable::new(&columns);
    for fit in found {
        table.row([words_of(fit.form), format!("{:.1}", fit.aicc - best), rounded(fit.residual, 3)]);
    }
    table.write(&mut out)?;
    if as_good > 0 {
        let (laws, are) = if as_good == 1 { ("law", "is") } else { ("laws", "are") };
        writeln!(
            out,
            "\n{as_good} more {laws} {are} about as good: take each in turn with --law, and compare the answers"
        )?;
    }
    writeln!(out, "\n{}: {}", words_of(chosen.form), measured.named(&chosen.form.formula()))?;
    let names = chosen.form.names();
    let mut headings = vec![("", Align::Left), ("value", Align::Right)];
    headings.extend((1..names.len()).map(|i| (if i == 1 { "correlation" } else { "" }, Align::Right)));
    let mut table = TextTable::new(&headings);
    for (i, (name, error)) in names.iter().zip(chosen.errors()).enumerate() {
        let value = with_error(chosen.values[i], error);
        let cells = [format!("{}{}", measured.named(name), bracket(measured.unit_of(name))), value];
        table.row(cells.into_iter().chain((0..i).map(|j| format!("{:.2}", chosen.correlation(i, j)))));
    }
    if let Some([level, _]) = chosen.at_rest {
        let of_one = || format!("{} {ONE_AT_REST}", short(level));
        let told = measured.error_at_rest(chosen).map_or_else(of_one, |error| with_error(level, error));
        table.row([format!("at rest{}", bracket(unit)), told]);
    }
    table.write(&mut out)?;
    if let Some(words) = measured.no_stick_slip(chosen) {
        writeln!(out, "\n{words}")?;
    }
    if let Some(reduced) = chosen.reduced {
        writeln!(out, "\nresiduals: {} times the standard errors", rounded(reduced.sqrt(), 2))?;
    }
    if chosen.lack > SYSTEMATIC {
        let by = rounded(chosen.lack, 2);
        writeln!(
            out,
            "\nThe residuals follow a smooth curve, {by} standard deviations more than by chance: the law does not follow the \
             readings. Take law = \"table\", or fit the slip speeds that matter."
        )?;
    }
    Ok(())
}

fn bracket(unit: &str) -> String {
    if unit.is_empty() { String::new() } else { format!(" [{unit}]") }
}

fn figure(measured: &Measured, fit: &Fit) -> FitFigure {
    let fastest = measured.in_slip.last().map_or(1.0, |row| row.speed);
    // Friction falls next to rest: points are dense there.
    let speed = |i: usize| fastest * (i as f64 / POINTS as f64).powi(2);
    let readings = measured.at_rest.iter().chain(&measured.in_slip);
    FitFigure {
        title: format!("{}: {}", words_of(fit.form), measured.named(&fit.form.formula())),
        speed: format!("slip speed, {}", measured.speed_unit()),
        friction: match measured.friction_unit() {
            "" => "friction".to_owned(),
            unit => format!("friction, {unit}"),
        },
        readings: readings.map(|row| [row.speed, row.friction, row.error]).collect(),
        law: (0..=POINTS).map(speed).map(|u| [u, fit.friction(u), fit.error(u)]).collect(),
    }
}

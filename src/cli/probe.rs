//! `slipmap probe`: every answer about one point.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::print_json;
use super::plot::{ONE, width};
use super::point::{LawArguments, PointArguments};
use super::probe_table::About;
use super::replace::Files;
use super::report::{existing, failure};
use super::{Ended, Failure, WRITTEN_BY, probe_table, proof};
use slipmap_certify::certificate::Format as _;
use slipmap_certify::point_certificate::PointCertificate;
use slipmap_column::Method;
use slipmap_config::{MachineJob, check_tolerance, load_machine};
use slipmap_figure::scene::Width;
use slipmap_figure::write_figure;
use slipmap_files::write_file;
use slipmap_machine::Model;
use slipmap_machine::assessment::StandardErrors;
use slipmap_machine::behaviour::behaviour;
use slipmap_machine::probe::{Answer, MachineResult, Probe};
use slipmap_map::Quantity;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_page::orbit::{OrbitPlot, orbit_figure};
use slipmap_page::units::UnitSystem;
use slipmap_witness::Start;

/// Ask every method about one point, or about each row of a table.
#[derive(Debug, Args)]
#[command(after_help = format!("{EXAMPLES}\n{}", about_tables()))]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) point: PointArguments,
    #[command(flatten)]
    law: LawArguments,
    /// The machine in SI units described in the tables [machine] and [friction] of a configuration, in place
    /// of the point; --set belt_speed=.. and --set damping=.. choose others than the file's
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["law", "phi", "table"])]
    machine: Option<PathBuf>,
    /// Bound on the error of the scaled grazing margin m / V that the simulation aims at
    #[arg(long, value_name = "NUMBER", value_parser = parse_tolerance, default_value = "1e-9")]
    pub(super) tolerance: f64,
    /// Print JSON instead of text; an infinite number is the text "inf" or "-inf", and null is none
    #[arg(long, conflicts_with = "points")]
    json: bool,
    /// Draw the phase portrait, and position and velocity against time; .svg, .pdf or .png
    #[arg(long, value_name = "FILE", conflicts_with = "points")]
    figure: Option<PathBuf>,
    /// Width of the figure, in columns of a journal
    #[arg(long, value_parser = width(), default_value = ONE, requires = "figure")]
    width: Width,
    /// Write the orbit: t, x1, x2, and whether the mass slips or sticks from there on; in SI units with
    /// --machine
    #[arg(long, value_name = "FILE.csv", conflicts_with = "points")]
    orbit: Option<PathBuf>,
    /// Start of the orbit that is drawn and written; default: the exit point, where sticking ends
    #[arg(long, value_name = "X1,X2", value_parser = parse_start, allow_hyphen_values = true,
          conflicts_with = "points")]
    from: Option<(f64, f64)>,
    /// For how long that orbit is followed, unless it settles before; default: until it closes, settles, or
    /// has made four turns
    #[arg(long, value_name = "TIME", value_parser = parse_duration, conflicts_with = "points")]
    duration: Option<f64>,
    /// Keep what `validated` proves of the point, for `slipmap check --proof`
    #[arg(long, value_name = "FILE.json", conflicts_with = "points")]
    proof: Option<PathBuf>,
    /// Read points from this table, `-` for standard input; its header names a column for each parameter, in
    /// any order; other columns are kept; what all rows share may be given here instead, as --epsilon 0.1
    #[arg(long, value_name = "IN.csv", requires = "out")]
    pub(super) points: Option<PathBuf>,
    /// Write the table with the answers appended here, `-` for standard output
    #[arg(long, value_name = "OUT.csv", requires = "points")]
    pub(super) out: Option<PathBuf>,
    /// Replace OUT.csv, the figure, the orbit or the proof if it exists
    #[arg(long)]
    pub(super) overwrite: bool,
    /// Number of threads for a table; default: one per core
    #[arg(long, requires = "points", value_name = "NUMBER", value_parser = super::threads::parse)]
    pub(super) threads: Option<usize>,
    /// Also append epsilon_limit_METHOD: up to which epsilon each method says what the simulation says; takes
    /// some twenty times as long
    #[arg(long, requires = "points")]
    pub(super) epsilon_limits: bool,
    /// Also append verdict_validated and margin_validated, by computer-assisted proofs; takes three times as
    /// long for the paper's law, some seventy times for others
    #[arg(long, requires = "points")]
    pub(super) validated: bool,
    /// No progress bar
    #[arg(long, requires = "points")]
    pub(super) quiet: bool,
}

const EXAMPLES: &str = "\
Examples:
  slipmap probe --epsilon 0.1 --alpha 0.3 --beta 0.1 --gamma 2 --V 1 --c 0.5
  slipmap probe --epsilon 0.1 --alpha 0.3 --beta 0.1 --gamma 2 --V 1 --c 0.5 --figure portrait.svg
  slipmap probe --epsilon 0.1 --alpha 0.3 --beta 0.1 --gamma 2 --V 1 --c 0.5 \\
      --orbit orbit.csv --from 0.5,0 --duration 40
  slipmap probe --epsilon 0.1 --alpha 0.3 --beta 0.1 --gamma 2 --V 1 --c 0.5 --proof point.json
  slipmap probe --law lorentzian --epsilon 1 --mu 0.5 --vs 1 --eta 0 --V 0.6 --c 0.2
  slipmap probe --phi 'mu + (1 - mu)*exp(-u/vs)' --epsilon 1 --set mu=0.5 --set vs=1 --V 0.6 --c 0.1
  slipmap probe --machine configs/brake_pad.toml --set belt_speed=0.05 --set damping=20
  slipmap probe --points points.csv --out answers.csv
  slipmap probe --machine configs/brake_pad.toml --set damping=20 --points speeds.csv --out answers.csv
";

/// The columns that a table of points gains.
fn about_tables() -> String {
    let names: Vec<&str> = Quantity::of_orbits().map(Quantity::name).collect();
    let (last, others) = names.split_last().unwrap_or((&"", &[]));
    format!(
        "A table with the header epsilon,alpha,beta,gamma,V,c (and any other columns) gains the columns \
         verdict_METHOD and margin_METHOD of the closed-form tests and of the simulation, critical_c, \
         critical_c_error, regime, {} and {last}. A cell is empty where there is no such number. Parameters that \
         are given as options are those of every row. Of a machine the header names any of its quantities, in SI \
         units or with a unit (belt_speed [rpm], damping, mass, ..; of what rotates inertia, too), and the answers are in SI \
         units; of measured or fitted friction with critical_damping_standard_error and regimes_left_open_by_data. To draw a plane of two quantities give them ranges in [machine], and call slipmap run and slipmap plot.",
        others.join(", ")
    )
}

fn parse_tolerance(text: &str) -> Result<f64, String> {
    let value = text.parse().map_err(|_| "this is not a number; write for example 1e-9".to_owned())?;
    check_tolerance(value).map(|()| value)
}

fn parse_start(text: &str) -> Result<(f64, f64), String> {
    let help = "write position and velocity, for example 0.5,-1.2";
    let number = |text: &str| text.trim().parse::<f64>().ok().filter(|number| number.is_finite());
    let (x1, x2) = text.split_once(',').ok_or(help)?;
    number(x1).zip(number(x2)).ok_or_else(|| help.into())
}

fn parse_duration(text: &str) -> Result<f64, String> {
    let duration = text.parse::<f64>().ok().filter(|duration| duration.is_finite() && *duration > 0.0);
    duration.ok_or_else(|| "write a number greater than 0".into())
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    if let Some(file) = &arguments.machine {
        return probe_machine(arguments, file);
    }
    let law = arguments.law.law(&arguments.point)?;
    super::probe_machine::warn_of_law(&law);
    if arguments.points.is_some() {
        let given = |name: &&str| arguments.point.given.iter().any(|(known, _)| known == name);
        if law.axis_names().iter().all(given) {
            let help = "leave out the parameters that are columns of the table";
            return Err(Failure::bad_input("both a point and a table were given", help));
        }
        arguments.point.refuse_foreign(&law)?;
        return probe_table::run(arguments, About::Law(law));
    }
    let point = arguments.point.point(&law)?;
    probe_point(arguments, &law, &point, None, Files::default().law(&law))
}

fn probe_machine(arguments: &Arguments, file: &Path) -> Result<Ended, Failure> {
    if arguments.points.is_some() {
        let job = load_machine(file, &arguments.point.settings())?;
        super::run::tell_units(&job.conversions);
        super::probe_machine::warn(&job.machine);
        return probe_table::run(arguments, About::Machine(&job, file));
    }
    let job = super::probe_machine::load(file, &arguments.point.settings())?;
    let leaves = || Failure::bad_input("the friction leaves the numbers", "check the units");
    let model = job.machine.model().ok_or_else(leaves)?;
    let files = Files::reading([file]).machine(&job.machine);
    probe_point(arguments, &model.law, &model.point, Some((&job, &model)), files)
}

/// Probes one point, which may be a machine's.
fn probe_point(
    arguments: &Arguments,
    law: &Law,
    point: &Point,
    machine: Option<(&MachineJob, &Model)>,
    files: Files,
) -> Result<Ended, Failure> {
    let tolerance = arguments.tolerance;
    files
        .writing("--figure", arguments.figure.as_deref())
        .writing("--orbit", arguments.orbit.as_deref())
        .writing("--proof", arguments.proof.as_deref())
        .check(arguments.overwrite)?;
    if let Some(path) = &arguments.proof {
        proof::write_text(PointCertificate::of(law, point, WRITTEN_BY).text(), path, arguments.overwrite)?;
    }
    write_orbit(arguments, law, point, machine.map(|(_, model)| model))?;
    let answer = Answer::of(law, point, tolerance, Method::all());
    let direct = slipmap_witness::flow(&answer.oscillator, tolerance);
    let behaviour = machine.map(|(job, model)| {
        let errors = StandardErrors::of_dampings(&job.machine, &job.uncertain);
        (job, behaviour(model, tolerance), errors)
    });
    if arguments.json {
        let mut whole = Probe::new(&answer, &direct);
        whole.machine = behaviour
            .map(|(job, behaviour, errors)| MachineResult::new(&job.machine, &behaviour, errors.as_ref()));
        print_json(&whole)?;
    } else {
        let mut out = io::stdout().lock();
        if let Some((job, behaviour, errors)) = &behaviour {
            let (errors, shown) = (errors.as_ref(), job.units.as_slice());
            super::probe_machine::write(&mut out, &job.machine, behaviour, errors, shown)?;
            writeln!(out, "\nThe same machine in dimensionless terms")?;
        }
        super::probe_text::write(&mut out, &answer, &direct)?;
    }
    Ok(Ended::Fine)
}

/// Writes the figure and the table of the orbit, if they were requested.
fn write_orbit(
    arguments: &Arguments,
    law: &Law,
    point: &Point,
    model: Option<&Model>,
) -> Result<(), Failure> {
    if arguments.figure.is_none() && arguments.orbit.is_none() {
        let help = "add --orbit FILE.csv or --figure FILE";
        return match arguments.from.is_some() || arguments.duration.is_some() {
            true => Err(Failure::bad_input("--from and --duration are about an orbit", help)),
            false => Ok(()),
        };
    }
    let units = model.map_or_else(UnitSystem::default, |model| UnitSystem::of_machine(model.si));
    let start = match arguments.from {
        None => Start::ExitPoint,
        Some((x1, x2)) => Start::State { x1: x1 / units.x1().factor, x2: x2 / units.x2().factor },
    };
    let plot = OrbitPlot {
        law,
        point,
        start,
        duration: arguments.duration.map(|duration| duration / units.time().factor),
        units: &units,
        width: arguments.width,
    };
    let drawn = orbit_figure(&plot);
    if let Some(path) = &arguments.figure {
        write_figure(&drawn.scene, &drawn.caption, path, existing(arguments.overwrite)).map_err(failure)?;
    }
    if let Some(path) = &arguments.orbit {
        write_file(drawn.data.csv().as_bytes(), path, existing(arguments.overwrite)).map_err(failure)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;
    use slipmap_column::DEFAULT_TOLERANCE;

    use crate::cli::output::exact;

    #[test]
    fn help_names_the_default_tolerance() {
        let help =
            crate::cli::Arguments::command().find_subcommand_mut("probe").unwrap().render_help().to_string();
        assert!(help.contains(&format!("[default: {}]", exact(DEFAULT_TOLERANCE))), "{help}");
    }
}

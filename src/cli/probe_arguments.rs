//! The options of `slipmap probe`.

use std::path::PathBuf;

use clap::Args;

use super::point::{LawArguments, PointArguments};
use super::width::{ONE, width};
use slipmap_config::check_tolerance;
use slipmap_figure::scene::Width;
use slipmap_map::Quantity;

/// Ask every method about one point, or about each row of a table.
#[derive(Debug, Args)]
#[command(after_help = format!("{EXAMPLES}\n{}", about_tables()))]
pub(super) struct Arguments {
    #[command(flatten)]
    pub(super) point: PointArguments,
    #[command(flatten)]
    pub(super) law: LawArguments,
    /// The machine in SI units described in the tables [machine] and [friction] of a configuration, in place
    /// of the point; --set belt_speed=.. and --set damping=.. choose others than the file's
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["law", "phi", "table"])]
    pub(super) machine: Option<PathBuf>,
    /// Bound on the error of the scaled grazing margin m / V that the simulation aims at
    #[arg(long, value_name = "NUMBER", value_parser = parse_tolerance, default_value = "1e-9")]
    pub(super) tolerance: f64,
    /// Print JSON instead of text; an infinite number is the text "inf" or "-inf", and null is none
    #[arg(long, conflicts_with = "points")]
    pub(super) json: bool,
    /// Draw the phase portrait, and position and velocity against time; .svg, .pdf or .png
    #[arg(long, value_name = "FILE", conflicts_with = "points")]
    pub(super) figure: Option<PathBuf>,
    /// Width of the figure, in columns of a journal
    #[arg(long, value_parser = width(), default_value = ONE, requires = "figure")]
    pub(super) width: Width,
    /// Write the orbit: t, x1, x2, and whether the mass slips or sticks from there on; in SI units with
    /// --machine
    #[arg(long, value_name = "FILE.csv", conflicts_with = "points")]
    pub(super) orbit: Option<PathBuf>,
    /// Start of the orbit that is drawn and written; default: the exit point, where sticking ends
    #[arg(long, value_name = "X1,X2", value_parser = parse_start, allow_hyphen_values = true,
          conflicts_with = "points")]
    pub(super) from: Option<(f64, f64)>,
    /// For how long that orbit is followed, unless it settles before; default: until it closes, settles, or
    /// has made four turns
    #[arg(long, value_name = "TIME", value_parser = parse_duration, conflicts_with = "points")]
    pub(super) duration: Option<f64>,
    /// Keep what `validated` proves of the point, for `slipmap check --proof`
    #[arg(long, value_name = "FILE.json", conflicts_with = "points")]
    pub(super) proof: Option<PathBuf>,
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

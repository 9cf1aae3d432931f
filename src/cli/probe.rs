//! `slipmap probe`: every answer about one point.

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use clap::Args;

use super::output::{Align, Table, count, exact, print_json, short, signed};
use super::plot::{ONE, width};
use super::point::{LawArguments, PointArguments};
use super::probe_table::About;
use super::replace;
use super::report::{existing, failure};
use super::{Ended, Failure, WRITTEN_BY, probe_table, proof};
use slipmap_certify::certificate::Format as _;
use slipmap_certify::point_certificate::PointCertificate;
use slipmap_certify::slip_count::{SlipCount, proves_absence};
use slipmap_config::{MachineJob, check_tolerance, load_machine};
use slipmap_map::assessment::StandardErrors;
use slipmap_map::behaviour::behaviour;
use slipmap_map::machine::Model;
use slipmap_map::map::limits::{HIGHEST, Limit, Unknown};
use slipmap_map::map::{BasinBoundary, Grid, Method, Quantity};
use slipmap_map::probe::{Answer, MachineResult, Probe, equilibrium_type, fate_name, regime_words};
use slipmap_model::filippov::Eigenvalues;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_numbers::text::{known_part, rounded, with_error};
use slipmap_report::figure::{OrbitPlot, Width, orbit_figure};
use slipmap_report::{UnitSystem, write_figure, write_file};
use slipmap_simulate::crossing::CrossingCycles;
use slipmap_simulate::sensitivity::NoSensitivity;
use slipmap_simulate::{Cycle, Fate, Flow, Neighbour, Range, separates};
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
        if Grid::axis_names(&law).iter().all(given) {
            let help = "leave out the parameters that are columns of the table";
            return Err(Failure::bad_input("both a point and a table were given", help));
        }
        arguments.point.refuse_foreign(&law)?;
        return probe_table::run(arguments, About::Law(law));
    }
    let point = arguments.point.point(&law)?;
    probe_point(arguments, &law, &point, None)
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
    probe_point(arguments, &model.law, &model.point, Some((&job, &model)))
}

/// Probes one point, which may be a machine's.
fn probe_point(
    arguments: &Arguments,
    law: &Law,
    point: &Point,
    machine: Option<(&MachineJob, &Model)>,
) -> Result<Ended, Failure> {
    let tolerance = arguments.tolerance;
    if let Some(path) = &arguments.proof {
        replace::check("--proof", path, None, arguments.overwrite)?;
        proof::write_text(PointCertificate::of(law, point, WRITTEN_BY).text(), path, arguments.overwrite)?;
    }
    write_orbit(arguments, law, point, machine.map(|(_, model)| model))?;
    let (answer, direct) = Answer::of_both_engines(law, point, tolerance, Method::all());
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
        write(&mut out, &answer, &direct)?;
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
    for (option, path) in [("--figure", &arguments.figure), ("--orbit", &arguments.orbit)] {
        path.iter().try_for_each(|path| replace::check(option, path, None, arguments.overwrite))?;
    }
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

/// Prints the answer as text.
fn write(out: &mut dyn Write, answer: &Answer, direct: &Flow) -> io::Result<()> {
    use Align::{Left, Right};

    writeln!(out, "Point of the law `{}`", answer.law.name())?;
    let words: Vec<String> = Grid::coordinates(&answer.law, &answer.point)
        .into_iter()
        .map(|(name, value)| format!("{name} = {}", exact(value)))
        .collect();
    writeln!(out, "  {}\n", words.join("   "))?;

    writeln!(out, "Does a stick-slip limit cycle exist?")?;
    let mut table = Table::new(&[
        ("method", Left),
        ("verdict", Left),
        ("margin", Right),
        ("critical c", Right),
        ("epsilon limit", Right),
        ("guarantee", Left),
        ("equation", Left),
    ]);
    let limits = answer.limits(false);
    for (method, limit) in answer.methods.iter().zip(&limits) {
        table.row([
            method.method.name().into(),
            method.verdict.name().into(),
            signed(method.margin),
            method.critical_c.map_or("-".into(), |c| match method.critical_c_error {
                Some(error) => short(known_part(c, error)[0]),
                None => short(c),
            }),
            short(limit.value()),
            method.method.guarantee().name().into(),
            method.method.equation_for(&answer.law).into_owned(),
        ]);
    }
    table.write(out)?;
    writeln!(
        out,
        "  (margin: in c to the edge of presence, or m/V of the simulation; positive means presence)\n  \
         (epsilon limit: says what the simulation says at every smaller epsilon; +inf: up to {} at least)",
        short(HIGHEST)
    )?;
    for method in &answer.methods {
        if let Some(reason) = &method.reason {
            writeln!(out, "  {}: {} because {reason}", method.method.name(), method.verdict.name())?;
        }
    }

    for (why, names) in unknown_limits(answer, &limits) {
        writeln!(out, "  no epsilon limit of {names}: {why}")?;
    }

    writeln!(out, "\nThe flow from the exit point, tolerance {}", short(answer.tolerance))?;
    let mut table = Table::new(&[
        ("engine", Left),
        ("fate", Left),
        ("margin m/V", Right),
        ("error", Right),
        ("right-hand sides", Right),
    ]);
    for (name, flow) in [("return map", &answer.told), ("direct", direct)] {
        table.row([
            name.into(),
            fate_name(&flow.fate).replace('_', " "),
            signed(flow.margin),
            short(flow.margin_error),
            count(flow.rhs),
        ]);
    }
    table.write(out)?;

    writeln!(out)?;
    let mut table = Table::new(&[("", Left), ("", Left)]);
    let mut line = |name: &str, text: String| table.row([name.to_owned(), text]);
    let oscillator = &answer.oscillator;
    let belt = short(oscillator.belt_speed);
    line(
        "critical damping",
        match &answer.critical {
            Ok(_) if answer.critical_is_zero() => {
                "c* = 0 within rounding: no cycle at any damping above 0".into()
            }
            Ok(root) => match root.known() {
                Ok(_) => format!(
                    "c* = {} ({} right-hand sides){}",
                    with_error(root.c, root.error),
                    count(root.rhs),
                    if root.c < 0.0 { ": no cycle at any damping" } else { "" }
                ),
                Err(why) => format!("not told: {why} ({} right-hand sides)", count(root.rhs)),
            },
            Err(why) => format!("none: {why}"),
        },
    );
    match answer.sensitivity() {
        Ok(found) => {
            let derivatives = found.named(&answer.law);
            let derivatives = derivatives.map(|(name, by)| match by.value.is_nan() {
                true => {
                    format!("an amount that is not known by {name} (its error is {})", rounded(by.error, 2))
                }
                false => format!("{} by {name}", with_error(by.value, by.error)),
            });
            line("c* moves by", derivatives.collect::<Vec<_>>().join(", "));
            if let Some(standard) = found.standard_error {
                line(
                    "standard error of c*",
                    format!("{}, from those of the data, at this V", short(standard.value)),
                );
            }
        }
        // A missing critical damping was reported above.
        Err(NoSensitivity::Critical(_) | NoSensitivity::Negative) => {}
        Err(why) => line("c* moves by", format!("not known: {why}")),
    }
    line("regime", format!("{}: {}", answer.regime.name(), regime_words(answer.regime)));
    if let Some(known) = answer.known_of_regime() {
        line("what is known of it", known);
    }
    let eigenvalues = match oscillator.eigenvalues() {
        Eigenvalues::Complex { re, im } => format!("{} +- {} i", short(re), short(im)),
        Eigenvalues::Real { slow, fast } => format!("{} and {}", short(slow), short(fast)),
    };
    line(
        "equilibrium",
        format!(
            "({}, 0), {}, eigenvalues {eigenvalues}",
            short(oscillator.equilibrium_x1()),
            equilibrium_type(oscillator)
        ),
    );
    line(
        "stick segment",
        format!(
            "{} < x1 < {}, x2 = {belt}",
            short(oscillator.upper_tangency_x1()),
            short(oscillator.exit_x1())
        ),
    );
    line("exit point", format!("({}, {belt})", short(oscillator.exit_x1())));
    match answer.slip_cycles() {
        Err(why) => line("slip cycles", format!("not determined: {}", answer.why_unknown(why))),
        Ok(cycles) => {
            let count = answer.slip_count();
            let absent = match proves_absence(&answer.oscillator, &count) {
                true => "; since the equilibrium is stable, that proves that no stick-slip cycle exists",
                false => "",
            };
            line("slip cycles", format!("{}{absent}", slip_count_words(cycles.len(), &count)));
            if let Some(assumed) = answer.conjecture(count.exact()) {
                line("the regime assumes", assumed.into());
            }
            for (i, cycle) in cycles.iter().enumerate() {
                let parts = separates(i, cycles.len(), &answer.flow.fate).map(neighbour_words);
                let (kind, sides) = if cycle.is_stable() {
                    ("attracts", String::new())
                } else {
                    ("repels", format!(": inside it orbits tend to {}, outside it to {}", parts[0], parts[1]))
                };
                let shape = cycle_words(cycle);
                line("slip cycle", format!("{kind}, {shape}{sides}"));
            }
        }
    }
    if let Some(left_out) = answer.left_out() {
        line("left out", left_out);
    }
    let CrossingCycles { cycles, unknown } = answer.crossing_cycles();
    for cycle in &cycles {
        let kind = if cycle.is_stable() { "attracts" } else { "repels" };
        let shape = cycle_words(cycle);
        line("crossing cycle", format!("{kind}, {shape}"));
    }
    if let Some(why) = unknown {
        let which = if cycles.is_empty() { "crossing cycles" } else { "other crossing cycles" };
        line(which, format!("not determined: {}", answer.why_unknown(why)));
    }
    match answer.flow.landing() {
        None => line(
            "landing",
            match answer.flow.fate {
                Fate::SpiralsInward | Fate::CrossesForever => {
                    "none: the orbit from the exit point never sticks"
                }
                Fate::Sticks(_) | Fate::TooCloseToCall | Fate::Failed(_) => "not determined",
            }
            .into(),
        ),
        Some(landing) => {
            let after = match landing.crossings {
                Some(crossings) => format!("after {crossings} crossings"),
                None => "within its error of the end of the stick segment: after 0 or 1 crossings".into(),
            };
            line("landing", format!("({}, {belt}), {after}", short(landing.x1)));
            line("slip time", short(landing.slip_time));
            line("stick time", short(landing.stick_time));
        }
    }
    let range = |range: Range| format!("{} to {}", short(range.lo), short(range.hi));
    if let Some(cycle) = &answer.cycle {
        let shape = format!("x1 from {}, x2 from {}", range(cycle.displacement), range(cycle.velocity));
        let multiplier = short(cycle.multiplier);
        line("attracting cycle", format!("period {}, {shape}, multiplier {multiplier}", short(cycle.period)));
    }
    if let Some([from, to, error]) = answer.bistable_band() {
        line("both attract for c", format!("{} to {}", exact(from), with_error(to, error)));
    }
    if let Some(BasinBoundary { kick, cycle, separates: [_, outside], .. }) = &answer.basin {
        let edge = match cycle {
            Some(_) => "the outermost slip cycle that repels",
            None => "the orbit that grazes the belt line",
        };
        line(
            "kick that starts it",
            format!(
                "of velocity {} with the belt, or {} against it, from steady slip onto {edge}; a slightly larger one leads to {}",
                short(kick.forward),
                short(kick.backward),
                neighbour_words(*outside)
            ),
        );
    }
    table.write(out)
}

/// Describes an attractor.
fn neighbour_words(neighbour: Neighbour) -> &'static str {
    match neighbour {
        Neighbour::Equilibrium => "the equilibrium",
        Neighbour::SlipCycle => "the next slip cycle",
        Neighbour::StickSlip => "stick-slip",
        Neighbour::Crossing => "crossing for ever",
        Neighbour::Unknown => "an attractor that is not known",
    }
}

fn cycle_words(Cycle { displacement, velocity, multiplier, period, .. }: &Cycle) -> String {
    format!(
        "amplitude {}, {} <= x2 <= {}, multiplier {}, period {}",
        short(0.5 * (displacement.hi - displacement.lo)),
        short(velocity.lo),
        short(velocity.hi),
        short(*multiplier),
        short(*period)
    )
}

/// Describes the number of slip cycles found, and the bounds that are proved for it.
fn slip_count_words(found: usize, count: &SlipCount) -> String {
    let number = |n: u32| if n == 0 { "none".to_owned() } else { n.to_string() };
    if let Some(exact) = count.exact() {
        return match usize::try_from(exact) {
            Ok(exact) if exact == found => format!("{}, count proved", number(count.at_least)),
            _ => format!("{found} found, but {} proved: try a smaller tolerance", number(count.at_least)),
        };
    }
    let open = count.open.iter().map(|open| format!("{} to {}", short(open.lo), short(open.hi)));
    let open: Vec<String> = open.collect();
    let mut words = format!("{found} found, count not proved");
    if !open.is_empty() {
        words.push_str(&format!(": nothing is proved where the maximum of x2 is in {}", open.join(", ")));
    } else if let Some(most) = count.at_most {
        words.push_str(&format!(": {} to {most} are possible", count.at_least));
    }
    words
}

/// Reasons why limits in eps are unknown, each with the names of its methods.
fn unknown_limits(answer: &Answer, limits: &[Limit]) -> Vec<(Unknown, String)> {
    let of = |why: Unknown| {
        let methods = answer.methods.iter().zip(limits).filter(|(_, limit)| limit.unknown() == Some(why));
        let names: Vec<&str> = methods.map(|(answer, _)| answer.method.name()).collect();
        (!names.is_empty()).then(|| (why, names.join(", ")))
    };
    [Unknown::NoFlow, Unknown::GivenUp, Unknown::NotSought].into_iter().filter_map(of).collect()
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory as _;
    use slipmap_map::map::DEFAULT_TOLERANCE;

    use super::*;

    #[test]
    fn help_names_the_default_tolerance() {
        let help =
            crate::cli::Arguments::command().find_subcommand_mut("probe").unwrap().render_help().to_string();
        assert!(help.contains(&format!("[default: {}]", exact(DEFAULT_TOLERANCE))), "{help}");
    }
}

//! `slipmap probe`: every answer about one point.

use std::io::{self, Write};
use std::path::Path;

use super::output::{Align, Table, count, exact, print_json, short, signed};
pub(super) use super::probe_arguments::Arguments;
use super::probe_table::About;
use super::replace::Files;
use super::report::{existing, failure};
use super::{Ended, Failure, WRITTEN_BY, probe_table, proof};
use slipmap_certify::certificate::Format as _;
use slipmap_certify::point_certificate::PointCertificate;
use slipmap_certify::slip_count::{SlipCount, proves_absence};
use slipmap_column::crossing::CrossingCycles;
use slipmap_column::limits::{HIGHEST, Limit, Unknown};
use slipmap_column::sensitivity::NoSensitivity;
use slipmap_column::{BasinBoundary, Method, Neighbour, separates};
use slipmap_config::{MachineJob, load_machine};
use slipmap_figure::write_figure;
use slipmap_files::write_file;
use slipmap_machine::Model;
use slipmap_machine::assessment::StandardErrors;
use slipmap_machine::behaviour::behaviour;
use slipmap_machine::probe::{Answer, MachineResult, Probe, equilibrium_type, fate_name, regime_words};
use slipmap_model::filippov::Eigenvalues;
use slipmap_model::flow::{Fate, Flow};
use slipmap_model::friction::Law;
use slipmap_model::friction::Range;
use slipmap_model::point::Point;
use slipmap_numbers::text::{known_part, rounded, with_error};
use slipmap_orbits::Cycle;
use slipmap_page::orbit::{OrbitPlot, orbit_figure};
use slipmap_page::units::UnitSystem;
use slipmap_witness::Start;

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    if let Some(file) = &arguments.machine {
        return probe_machine(arguments, file);
    }
    let law = arguments.law.law(&arguments.point)?;
    super::notes::warn_of_law(&law);
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
        super::notes::tell_units(&job.conversions);
        super::notes::warn(&job.machine);
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
    let words: Vec<String> = answer
        .law
        .coordinates(&answer.point)
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
        "  (margin: in c to the edge of presence; positive means presence)\n  \
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
    for (name, flow) in [("arcs", &answer.told), ("direct", direct)] {
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
    match &answer.slip {
        Err(why) => line("slip cycles", format!("not determined: {}", answer.why_unknown(*why))),
        Ok(cycles) => {
            let count = answer.slip_count();
            let absent = match proves_absence(&answer.oscillator, count) {
                true => "; since the equilibrium is stable, that proves that no stick-slip cycle exists",
                false => "",
            };
            line("slip cycles", format!("{}{absent}", slip_count_words(cycles.len(), count)));
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
    if let Some(band) = answer.bistable_band() {
        let to = with_error(band.to_c, band.error);
        let [low, high] = band.from_c_between;
        let words = match band.from_c_reason {
            None => format!("{} to {to}", exact(high)),
            Some(why) => format!(
                "from between {} and {} to {to}; where it begins is not known closer: {why}",
                short(low),
                short(high)
            ),
        };
        line("both attract for c", words);
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
    use slipmap_column::DEFAULT_TOLERANCE;

    use super::*;

    #[test]
    fn help_names_the_default_tolerance() {
        let help =
            crate::cli::Arguments::command().find_subcommand_mut("probe").unwrap().render_help().to_string();
        assert!(help.contains(&format!("[default: {}]", exact(DEFAULT_TOLERANCE))), "{help}");
    }
}

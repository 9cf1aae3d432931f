//! `slipmap probe`: every answer about one point.

use std::io::{self, Write};
use std::path::Path;

use super::output::print_json;
pub(super) use super::probe_arguments::Arguments;
use super::probe_table::About;
use super::replace::Files;
use super::report::{existing, failure};
use super::{Ended, Failure, WRITTEN_BY, probe_table, proof};
use slipmap_certify::certificate::Certificate;
use slipmap_column::Method;
use slipmap_config::{MachineJob, load_machine};
use slipmap_figure::write_figure;
use slipmap_files::write_file;
use slipmap_machine::Model;
use slipmap_machine::assessment::StandardErrors;
use slipmap_machine::behaviour::behaviour;
use slipmap_machine::probe::{Answer, MachineResult, Probe};
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
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
        proof::write(&Certificate::of_point(law, point, WRITTEN_BY), path, arguments.overwrite)?;
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

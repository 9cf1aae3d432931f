//! `slipmap probe --machine`: what a machine does, in SI units.

use std::io::{self, Write};
use std::path::Path;

use super::Failure;
use super::output::{Align, Table, short};
use super::point::PointArguments;
use crate::config::load_machine;
use crate::friction::Law;
use crate::machine::{Behaviour, Machine};
use crate::probe::regime_words;

/// Reads the machine of a file, with the belt speed and the damping chosen by `--set`.
pub(super) fn load(file: &Path, chosen: &PointArguments) -> Result<(Law, Machine), Failure> {
    let job = load_machine(file)?;
    let mut machine = job.machine;
    let settings = chosen.given();
    if let Some((name, _)) =
        settings.iter().find(|(name, _)| !["belt_speed", "damping"].contains(&name.as_str()))
    {
        return Err(Failure::BadInput(format!(
            "{name} is given together with --machine\n  help: with a machine, only --set belt_speed=.. and --set \
             damping=.. can be chosen"
        )));
    }
    for (name, values, value) in [
        ("belt_speed", &job.belt_speeds, &mut machine.belt_speed),
        ("damping", &job.dampings, &mut machine.damping),
    ] {
        match settings.iter().find(|(given, _)| given == name) {
            Some((_, chosen)) => {
                let legal = chosen.is_finite() && (*chosen > 0.0 || (name == "damping" && *chosen == 0.0));
                if !legal {
                    return Err(Failure::BadInput(format!(
                        "--set {name}={chosen}: it must be greater than 0\n  help: give it in SI units"
                    )));
                }
                *value = *chosen;
            }
            None if values.len() > 1 => {
                return Err(Failure::BadInput(format!(
                    "{}: {name} has {} values\n  help: choose one, for example --set {name}={}",
                    file.display(),
                    values.len(),
                    short(values[0])
                )));
            }
            None => {}
        }
    }
    Ok((job.law, machine))
}

/// A number with its unit, or a dash.
fn quantity(value: Option<f64>, unit: &str) -> String {
    value.map_or("-".into(), |value| format!("{} {unit}", short(value)))
}

/// Prints it for a person.
pub(super) fn write(out: &mut dyn Write, machine: &Machine, behaviour: &Behaviour) -> io::Result<()> {
    writeln!(out, "\nThe machine, in SI units")?;
    let (units, motion) = (machine.units(), machine.motion);
    let mut table = Table::new(&[("", Align::Left), ("", Align::Left)]);
    let [slip, stick] = behaviour.slip_and_stick_time.map_or([None; 2], |times| times.map(Some));
    for (name, text) in [
        ("belt speed", quantity(Some(machine.belt_speed), motion.velocity())),
        ("critical belt speed", quantity(behaviour.critical_belt_speed, motion.velocity())),
        ("damping", quantity(Some(machine.damping), motion.damping())),
        ("critical damping", quantity(behaviour.critical_damping, motion.damping())),
        ("damping ratio", short(behaviour.damping_ratio)),
        ("critical damping ratio", quantity(behaviour.critical_damping_ratio, "")),
        ("natural frequency", quantity(Some(behaviour.natural_frequency), "Hz")),
        ("regime", regime_words(behaviour.regime).to_owned()),
        ("slip time", quantity(slip, "s")),
        ("stick time", quantity(stick, "s")),
        ("amplitude", quantity(behaviour.amplitude, motion.length())),
        ("unit of time", quantity(Some(units.time), "s")),
        ("unit of length", quantity(Some(units.length), motion.length())),
        ("unit of velocity", quantity(Some(units.velocity), motion.velocity())),
    ] {
        table.row([name.to_owned(), text.trim_end().to_owned()]);
    }
    table.write(out)
}

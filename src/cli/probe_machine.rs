//! `slipmap probe --machine`: the behaviour of a machine, in SI units.

use std::io::{self, Write};
use std::path::Path;

use super::output::{Align, TextTable, short};
use super::point::Setting;
use super::{Failure, notes, say};
use slipmap_column::Regime;
use slipmap_config::{MachineJob, load_machine};
use slipmap_machine::assessment::StandardErrors;
use slipmap_machine::behaviour::{Limit, MachineBehaviour};
use slipmap_machine::probe::regime_words;
use slipmap_machine::{BELT_SPEED, Dimension, Machine};
use slipmap_map::Shown;
use slipmap_numbers::text::{rounded, with_error};

/// Reads the machine of a file with the quantities set by `--set`; belt speed and damping have one value
/// each.
pub(super) fn load(file: &Path, settings: &[(String, Setting)]) -> Result<MachineJob, Failure> {
    let job = load_machine(file, settings)?;
    check_single(&job, file, |_| false)?;
    notes::tell_units(&job.conversions);
    notes::warn(&job.machine);
    Ok(job)
}

/// The same, but that the belt speed may have several: the machine is that at the first, which is told.
pub(super) fn load_over_speeds(file: &Path, settings: &[(String, Setting)]) -> Result<MachineJob, Failure> {
    let job = load_machine(file, settings)?;
    check_single(&job, file, |name| name == BELT_SPEED)?;
    notes::tell_units(&job.conversions);
    notes::warn(&job.machine);
    if job.varied.iter().any(|(name, _)| *name == BELT_SPEED) {
        say("note: the numbers below are those of the least belt speed; --set belt_speed=.. chooses another");
    }
    Ok(job)
}

/// Refuses quantities with several values, except for one that is set elsewhere.
pub(super) fn check_single(
    job: &MachineJob,
    file: &Path,
    is_chosen: impl Fn(&str) -> bool,
) -> Result<(), Failure> {
    let several = job.varied.iter().filter(|(name, _)| !is_chosen(name));
    let several: Vec<_> = several.collect();
    if !several.is_empty() {
        let join = |each: &dyn Fn(&str, &[f64]) -> String, separator: &str| {
            several.iter().map(|(name, values)| each(name, values)).collect::<Vec<_>>().join(separator)
        };
        let counts = join(&|name, values| format!("{name} has {} values", values.len()), ", ");
        let shown = |name: &str| job.units.iter().find(|(known, _)| *known == name)?.1.as_ref();
        let first = |name: &str, values: &[f64]| match shown(name) {
            Some(Shown { unit, size }) => format!("--set '{name}={} {unit}'", short(values[0] / size)),
            None => format!("--set {name}={}", short(values[0])),
        };
        let sets = join(&first, " ");
        let help = match several.len() {
            1 => format!("choose one, for example {sets}"),
            _ => format!("choose one of each, for example {sets}"),
        };
        return Err(Failure::bad_input(format!("{}: {counts}", file.display()), help));
    }
    Ok(())
}

/// A number with its unit, or a dash.
fn quantity(value: Option<f64>, unit: &str) -> String {
    value.map_or("-".into(), |value| format!("{} {unit}", short(value)))
}

/// A limit with its unit, or what is known of it.
fn limit(limit: Limit, unit: &str) -> String {
    match limit {
        Limit::Below(value) => format!("{} {unit}", short(value)),
        Limit::Between(low, high) => {
            format!("between {} and {} {unit}, not known closer", short(low), short(high))
        }
        Limit::AtLeast(value) => format!("at least {} {unit}", short(value)),
        Limit::NoneUpTo(value) => format!("none up to {} {unit}", short(value)),
        Limit::NotDetermined => "not determined".into(),
    }
}

/// Prints the machine and its behaviour as text.
pub(super) fn write(
    out: &mut dyn Write,
    machine: &Machine,
    behaviour: &MachineBehaviour,
    errors: Option<&StandardErrors>,
    units: &[(&'static str, Option<Shown>)],
) -> io::Result<()> {
    let written = |name: &str| units.iter().find(|(known, _)| *known == name)?.1.clone();
    let in_si = ["belt_speed", "damping"].iter().all(|name| written(name).is_none());
    writeln!(out, "The machine{}", if in_si { ", in SI units" } else { "" })?;
    let (units, motion) = (machine.units(), machine.motion);
    let mut table = TextTable::new(&[("", Align::Left), ("", Align::Left)]);
    // In the units of the file.
    let unit_of = |name: &str, dimension: Dimension| {
        written(name).unwrap_or_else(|| Shown { unit: motion.unit(dimension).into(), size: 1.0 })
    };
    let Shown { unit: velocity, size: of_velocity } = unit_of("belt_speed", Dimension::Velocity);
    let Shown { unit: damping_unit, size: of_damping } = unit_of("damping", Dimension::Damping);
    let of_data = errors.and_then(|errors| errors.critical_damping).map(|of| of.standard_error);
    let critical = match (behaviour.critical_damping, behaviour.critical_damping_error) {
        (Some(damping), Some(error)) => match of_data.filter(|of_data| *of_data >= error) {
            Some(of_data) => {
                let from = errors.map_or("", |errors| errors.from.in_words());
                format!("{} {damping_unit} by {from}", with_error(damping / of_damping, of_data / of_damping))
            }
            None => format!("{} {damping_unit}", with_error(damping / of_damping, error / of_damping)),
        },
        (None, Some(error)) => {
            let error = rounded(error / of_damping, 2);
            format!("not told: its error, {error} {damping_unit}, is more than 1 % of it")
        }
        _ => "-".into(),
    };
    let speed = motion.words("belt_speed");
    let critical_speed = format!("critical {speed}");
    let [slip, stick] = behaviour.slip_and_stick_time.map_or([None; 2], |times| times.map(Some));
    let needed = behaviour.needed_slip_speed.map(|needed| {
        let needed = rounded(needed / of_velocity, 3);
        ("measure friction up to", format!("about {needed} {velocity}: the orbit leaves the data"))
    });
    let unit = 2.0 * (machine.stiffness * machine.mass).sqrt();
    let error =
        behaviour.critical_damping_error.map(|error| of_data.map_or(error, |of_data| of_data.max(error)));
    let ratio = behaviour.critical_damping_ratio.zip(error);
    let ratio = ratio.map_or("-".into(), |(ratio, error)| with_error(ratio, error / unit));
    let open = errors.map(|errors| errors.leave_open(machine.damping, behaviour.regime));
    let words = |regime| regime_words(regime).into();
    let regime = open.map_or_else(|| regime_words(behaviour.regime).to_owned(), |open| open.in_words(words));
    let regime = match (behaviour.regime, slip) {
        (Regime::Neutral, Some(_)) => format!("{regime}; the stick-slip cycle attracts"),
        _ => regime,
    };
    let mut fastest = limit(behaviour.critical_belt_speed.times(of_velocity.recip()), &velocity);
    if let (Some(_), Limit::Below(_)) = (errors, behaviour.critical_belt_speed) {
        fastest += "; errors by those of the friction: slipmap machine";
    }
    let does = [
        (speed.as_str(), quantity(Some(machine.belt_speed / of_velocity), &velocity)),
        (&critical_speed, fastest),
        ("damping", quantity(Some(machine.damping / of_damping), &damping_unit)),
        ("critical damping", critical),
        ("damping ratio", short(behaviour.damping_ratio)),
        ("critical damping ratio", ratio),
        ("natural frequency", quantity(Some(behaviour.natural_frequency), "Hz")),
        ("regime", regime),
        ("slip time", quantity(slip, "s")),
        ("stick time", quantity(stick, "s")),
        ("growth time of steady slip", quantity(behaviour.growth_time, "s")),
        ("amplitude", quantity(behaviour.amplitude, motion.unit(Dimension::Length))),
    ];
    let units = [
        ("unit of time", quantity(Some(units.time), "s")),
        ("unit of length", quantity(Some(units.length), motion.unit(Dimension::Length))),
        ("unit of velocity", quantity(Some(units.velocity), motion.unit(Dimension::Velocity))),
    ];
    for (name, text) in does.into_iter().chain(needed).chain(units) {
        table.row([name.to_owned(), text.trim_end().to_owned()]);
    }
    table.write(out)
}

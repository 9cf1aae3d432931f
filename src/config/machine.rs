//! The machine of a configuration, in SI units: instead of `[grid]`.

use std::path::Path;

use super::source::{ConfigError, Node, Section, Source};
use super::{axis, choice, law, refuse_unknown_keys};
use crate::friction::Law;
use crate::machine::{Machine, Motion};
use crate::map::Grid;

/// The keys of `[machine]`.
pub(super) const KEYS: [&str; 10] = [
    "motion",
    "mass",
    "stiffness",
    "damping",
    "normal_force",
    "static_friction",
    "kinetic_friction",
    "stribeck_velocity",
    "strengthening",
    "belt_speed",
];

/// A machine with the belt speeds and damping coefficients that are asked about.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineJob {
    /// The machine at the first of them.
    pub machine: Machine,
    /// Its friction law.
    pub law: Law,
    /// Belt speeds, m/s.
    pub belt_speeds: Vec<f64>,
    /// Damping coefficients, N s/m.
    pub dampings: Vec<f64>,
}

/// Reads the laws and the machine of `file` alone.
///
/// # Errors
/// The first thing wrong, with its place, its value and a remedy.
pub fn load_machine(file: &Path) -> Result<MachineJob, ConfigError> {
    let source = Source::load(file, &[])?;
    let root = source.root();
    let law = law::read(&root.section("friction")?, file.parent().unwrap_or(Path::new("")))?;
    let section = root.section("machine")?;
    if !section.is_present() {
        return Err(section.missing("mass", "describe the machine in a table [machine]".into()));
    }
    refuse_unknown_keys(&section, &KEYS)?;
    read(&section, &law)
}

/// Reads `[machine]`.
pub(super) fn read(section: &Section, law: &Law) -> Result<MachineJob, ConfigError> {
    let node = |key: &str| -> Result<Node, ConfigError> {
        let how = match key {
            "belt_speed" | "damping" => "write a number in SI units, a list, or a range",
            _ => "write a number in SI units",
        };
        section.get(key).ok_or_else(|| section.missing(key, how.into()))
    };
    let check = |node: &Node, key: &str, value: f64, legal: bool, wanted: &str| {
        if legal && value.is_finite() {
            Ok(value)
        } else {
            Err(node.error(&format!("{key} must be {wanted}"), "mind the units: kg, N/m, N s/m, N, m/s; of a rotation kg m^2, N m/rad, N m s/rad, N m, rad/s"))
        }
    };
    let positive = |key: &str| {
        let node = node(key)?;
        let value = node.number()?;
        check(&node, key, value, value > 0.0, "greater than 0")
    };
    let many = |key: &str, least: f64, wanted: &str| {
        let node = node(key)?;
        let values = axis::nodes(&node)?;
        for &value in &values {
            check(&node, key, value, value >= least, wanted)?;
        }
        match values.windows(2).find(|pair| pair[0] >= pair[1]) {
            Some(pair) => Err(node
                .error(&format!("{} follows {}", pair[1], pair[0]), "sort the values, without repetition")),
            None => Ok(values),
        }
    };
    let belt_speeds = many("belt_speed", f64::MIN_POSITIVE, "greater than 0")?;
    let dampings = many("damping", 0.0, "at least 0")?;
    let static_friction = positive("static_friction")?;
    let kinetic = node("kinetic_friction")?;
    let kinetic_friction = kinetic.number()?;
    let legal = (0.0..=static_friction).contains(&kinetic_friction);
    check(&kinetic, "kinetic_friction", kinetic_friction, legal, "from 0 to static_friction")?;
    let strengthening = match section.get("strengthening") {
        None => 0.0,
        Some(node) => {
            let value = node.number()?;
            check(&node, "strengthening", value, value >= 0.0, "at least 0")?
        }
    };
    let motions = Motion::ALL.map(|motion| (motion.name(), motion));
    let motion =
        section.get("motion").map_or(Ok(Motion::Translation), |node| choice(&node, &motions, "motion"))?;
    let machine = Machine {
        motion,
        mass: positive("mass")?,
        stiffness: positive("stiffness")?,
        damping: dampings[0],
        normal_force: positive("normal_force")?,
        static_friction,
        kinetic_friction,
        stribeck_velocity: positive("stribeck_velocity")?,
        strengthening,
        belt_speed: belt_speeds[0],
    };
    if machine.point(law).is_none() {
        let problem = format!("the law `{}` has no coefficients of friction", law.name());
        let remedy = "use stribeck, exponential or lorentzian with [machine], or give the axes in [grid]";
        return Err(node("static_friction")?.error(&problem, remedy));
    }
    Ok(MachineJob { machine, law: law.clone(), belt_speeds, dampings })
}

/// The dimensionless grid of a machine.
pub(super) fn grid(section: &Section, job: &MachineJob) -> Result<Grid, ConfigError> {
    let units = job.machine.units();
    let scaled = |values: &[f64], unit: f64| values.iter().map(|value| value / unit).collect::<Vec<f64>>();
    let point = job.machine.point(&job.law);
    let parameters = point.iter().flat_map(|point| point.law.as_slice().to_vec());
    let mut nodes = vec![vec![1.0]];
    nodes.extend(parameters.map(|value| vec![value]));
    nodes.push(scaled(&job.belt_speeds, units.velocity));
    nodes.push(scaled(&job.dampings, units.damping));
    Grid::new(job.law.clone(), nodes).map_err(|error| {
        section.missing("belt_speed", format!("in dimensionless terms, {error}; check the units"))
    })
}

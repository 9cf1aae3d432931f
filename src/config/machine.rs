//! The machine of a configuration, in SI units; replaces `[grid]`.

use std::path::Path;

use super::source::{ConfigError, Node, Section, Shape, Source};
use super::{axis, choice, law, refuse_unknown_keys};
use crate::friction::Law;
use crate::machine::{Machine, Motion};
use crate::map::Grid;
use crate::risk::{Quantity, Spread};

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

/// A machine with the belt speeds and damping coefficients of a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineJob {
    /// The machine at the first belt speed and damping.
    pub machine: Machine,
    /// Its friction law.
    pub law: Law,
    /// Belt speeds, m/s.
    pub belt_speeds: Vec<f64>,
    /// Damping coefficients, N s/m.
    pub dampings: Vec<f64>,
    /// The uncertain quantities and their distributions.
    pub spreads: Vec<(Quantity, Spread)>,
    /// Title of the configuration, if it has one.
    pub title: Option<String>,
}

/// The keys that every machine needs.
const REQUIRED: [&str; 8] = [
    "mass",
    "stiffness",
    "damping",
    "normal_force",
    "static_friction",
    "kinetic_friction",
    "stribeck_velocity",
    "belt_speed",
];

/// Refuses a machine that lacks keys, naming all of them at once.
fn check_complete(section: &Section, law: &Law) -> Result<(), ConfigError> {
    let missing: Vec<&str> = REQUIRED.into_iter().filter(|key| section.get(key).is_none()).collect();
    let Some((first, others)) = missing.split_first() else { return Ok(()) };
    let also = match others {
        [] => String::new(),
        others => format!("; a machine of the law `{}` also lacks {}", law.name(), others.join(", ")),
    };
    Err(section.missing(first, format!("write numbers in SI units{also}")))
}

/// Reads an uncertain quantity, { value = 2.0, sd = 0.1 } or { min = 1.8, max = 2.2 }: its nominal value and
/// its spread; `None` for anything else.
fn uncertain(node: &Node) -> Result<Option<(f64, Spread)>, ConfigError> {
    let Shape::Table(table) = node.shape() else { return Ok(None) };
    let keys = table.keys();
    let has = |key: &str| keys.iter().any(|other| other == key);
    if !["value", "sd", "min", "max"].into_iter().any(has) {
        return Ok(None);
    }
    let number = |key: &str| {
        let remedy = "write { value = 2.0, sd = 0.1 } or { min = 1.8, max = 2.2 }";
        table.get(key).ok_or_else(|| table.missing(key, remedy.into()))?.number()
    };
    if has("value") || has("sd") {
        refuse_unknown_keys(&table, &["value", "sd"])?;
        let (value, sd) = (number("value")?, number("sd")?);
        return match sd.is_finite() && sd >= 0.0 {
            true => Ok(Some((value, Spread::Normal { sd }))),
            false => Err(node.error("the standard deviation must be at least 0", "choose another sd")),
        };
    }
    refuse_unknown_keys(&table, &["min", "max"])?;
    let (min, max) = (number("min")?, number("max")?);
    match min.is_finite() && max.is_finite() && min <= max {
        true => Ok(Some((0.5 * (min + max), Spread::Uniform { min, max }))),
        false => Err(node.error("min must be at most max", "swap them")),
    }
}

/// Reads the law and the machine of `file` alone, under the overrides `sets`, each `key.path=value`.
///
/// # Errors
/// The first error, with its place, its value and a remedy.
pub fn load_machine(file: &Path, sets: &[String]) -> Result<MachineJob, ConfigError> {
    let source = Source::load(file, sets)?;
    let root = source.root();
    let law = law::read(&root.section("friction")?, file.parent().unwrap_or(Path::new("")))?;
    let section = root.section("machine")?;
    if !section.is_present() {
        return Err(section.missing("mass", "describe the machine in a table [machine]".into()));
    }
    refuse_unknown_keys(&section, &KEYS)?;
    let title = root.get("title").map(|node| super::line(&node).map(str::to_owned)).transpose()?;
    Ok(MachineJob { title, ..read(&section, &law)? })
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
    check_complete(section, law)?;
    let spreads = std::cell::RefCell::new(Vec::new());
    // The nominal value of a quantity that may be uncertain.
    let nominal = |key: &str, node: &Node| -> Result<f64, ConfigError> {
        let Some((value, spread)) = uncertain(node)? else { return node.number() };
        let quantity = Quantity::ALL.into_iter().find(|quantity| quantity.name() == key);
        spreads.borrow_mut().extend(quantity.map(|quantity| (quantity, spread)));
        Ok(value)
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
        let value = nominal(key, &node)?;
        check(&node, key, value, value > 0.0, "greater than 0")
    };
    let many = |key: &str, least: f64, wanted: &str| {
        let node = node(key)?;
        let values = match uncertain(&node)? {
            Some(_) => vec![nominal(key, &node)?],
            None => axis::nodes(&node)?,
        };
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
    let kinetic_friction = nominal("kinetic_friction", &kinetic)?;
    let legal = (0.0..=static_friction).contains(&kinetic_friction);
    check(&kinetic, "kinetic_friction", kinetic_friction, legal, "from 0 to static_friction")?;
    let strengthening = match section.get("strengthening") {
        None => 0.0,
        Some(node) => {
            let value = nominal("strengthening", &node)?;
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
    let spreads = spreads.into_inner();
    Ok(MachineJob { machine, law: law.clone(), belt_speeds, dampings, spreads, title: None })
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

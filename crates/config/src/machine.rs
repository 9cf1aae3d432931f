//! The machine of a configuration, in SI units; replaces `[grid]`.

use std::cell::RefCell;
use std::path::Path;

use super::law::{About, at_formula};
use super::source::{ConfigError, Node, Section, Shape, Source};
use super::units::{Match, Wanted, compare, conversion, converted, with_unit};
use super::{axis, choice, fitted, law, nearest, refuse_unknown_keys};
use slipmap_map::machine::{
    BELT_SPEED, Coefficients, DAMPING, Dimension, Friction, INERTIA, MASS, Machine, Motion, requirement,
};
use slipmap_map::map::Grid;
use slipmap_map::risk::{Spread, Uncertain};
use slipmap_model::friction::{Expression, ExpressionError, Law, Table};
use slipmap_model::point::LawParameters;

/// A machine, of which any quantities may vary.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineJob {
    /// The machine at the first value of every quantity.
    pub machine: Machine,
    /// The quantities with several values: increasing, in SI units.
    pub varied: Vec<(&'static str, Vec<f64>)>,
    /// The uncertain quantities and their distributions.
    pub uncertain: Vec<Uncertain>,
    /// What units in the file are in SI: "1 rpm is 0.10472 rad/s".
    pub conversions: Vec<String>,
    /// The title of its page.
    pub title: Option<String>,
}

/// The keys of `[machine]` under `law`: the motion and the quantities.
pub fn keys(law: &Law) -> Vec<&'static str> {
    std::iter::once("motion").chain(Machine::names(law)).collect()
}

/// The keys of [`keys`], and `inertia`, the other name of the mass.
pub(super) fn known_keys(law: &Law) -> Vec<&'static str> {
    keys(law).into_iter().chain([INERTIA]).collect()
}

/// Refuses a formula that uses the name of a quantity of the machine.
pub fn check_names(formula: &Expression) -> Result<(), ExpressionError> {
    let mut names = formula.parameters().iter().map(|parameter| parameter.name);
    let machine = keys(&Law::Coulomb);
    let is_taken =
        |name: &&str| machine.contains(name) && !Coefficients::NAMES.contains(name) || *name == INERTIA;
    let Some(name) = names.find(is_taken) else { return Ok(()) };
    let (from, to) = formula.place_of(name).unwrap_or_default();
    let problem = format!("`{name}` is a quantity of the machine");
    let remedy = "give the parameter of the friction another name".to_owned();
    Err(ExpressionError { from, to, problem, remedy })
}

/// The remedy for an unknown key of `[machine]`.
pub(super) fn remedy(key: &str, law: &Law) -> String {
    match key {
        // A tap test measures the damping ratio.
        "damping_ratio" => {
            "write damping = 2 * damping_ratio * sqrt(stiffness * mass), a number in N s/m".into()
        }
        "frequency" => "write stiffness = mass * (2 * pi * frequency)^2, a number in N/m".into(),
        key if Coefficients::NAMES.contains(&key) => {
            let laws = Law::BUILT_IN.iter().filter(|law| Coefficients::names(law).any(|name| name == key));
            let laws: Vec<&str> = laws.map(Law::name).collect();
            let (last, others) = laws.split_last().unwrap_or((&"", &[]));
            format!(
                "leave it out: it belongs to the laws {} and {last}, and the law `{}` has its own friction at every speed",
                others.join(", "),
                law.name()
            )
        }
        key => nearest("key", key, &keys(law)),
    }
}

/// The key that gives the mass; for a rotation it may be `inertia`.
fn key_of_mass(section: &Section, motion: Motion) -> Result<&'static str, ConfigError> {
    match (section.get(INERTIA), section.get(MASS), motion) {
        (None, ..) => Ok(MASS),
        (Some(node), Some(_), _) => {
            Err(node.error("mass and inertia are the same quantity", "leave one of them out"))
        }
        (Some(_), None, Motion::Rotation) => Ok(INERTIA),
        (Some(node), None, Motion::Translation) => {
            let remedy = "write motion = \"rotation\", or mass = .. in kg for what moves along a line";
            Err(node.error("only what rotates has a moment of inertia", remedy))
        }
    }
}

/// Refuses a machine that lacks keys, naming all of them at once.
fn check_complete(section: &Section, law: &Law, forces: bool) -> Result<(), ConfigError> {
    let optional = |key: &str| match key {
        "motion" | "strengthening" => true,
        "normal_force" => forces,
        MASS => section.get(INERTIA).is_some(),
        _ => false,
    };
    let missing = keys(law).into_iter().filter(|key| !optional(key) && section.get(key).is_none());
    let missing: Vec<&str> = missing.collect();
    let Some((first, others)) = missing.split_first() else { return Ok(()) };
    let also = match others {
        [] => String::new(),
        others => format!("; a machine of the law `{}` also lacks {}", law.name(), others.join(", ")),
    };
    let remedy =
        format!("write numbers in SI units{also}; a whole machine is written by: slipmap init machine");
    Err(section.missing(first, remedy))
}

/// Reads an uncertain quantity, { value = 2.0, sd = 0.1 } or { min = 1.8, max = 2.2 }: its nominal value and
/// its spread; `None` for anything else. What a fit gives is { value = 2.0, joint = [..] }.
fn uncertain(node: &Node, read: axis::Number) -> Result<Option<(f64, Spread)>, ConfigError> {
    let Shape::Table(table) = node.shape() else { return Ok(None) };
    let keys = table.keys();
    let has = |key: &str| keys.iter().any(|other| other == key);
    if let (Some(value), Some(row)) = (table.get("value"), table.get(fitted::JOINT)) {
        return Ok(Some((value.number()?, Spread::Joint { row: fitted::row(&row)? })));
    }
    if !["value", "sd", "min", "max"].into_iter().any(has) || axis::RANGE_KEYS.into_iter().any(has) {
        return Ok(None);
    }
    let number = |key: &str| {
        let remedy = "write { value = 2.0, sd = 0.1 } or { min = 1.8, max = 2.2 }";
        read(&table.get(key).ok_or_else(|| table.missing(key, remedy.into()))?)
    };
    if has("value") || has("sd") {
        refuse_unknown_keys(&table, &["value", "sd"])?;
        let value = number("value")?;
        number("sd")?;
        return Ok(normal(&table, read)?.map(|spread| (value, spread)));
    }
    refuse_unknown_keys(&table, &["min", "max"])?;
    let (min, max) = (number("min")?, number("max")?);
    match min.is_finite() && max.is_finite() && min <= max {
        true => Ok(Some((0.5 * (min + max), Spread::Uniform { min, max }))),
        false => Err(node.error("min must be at most max", "swap them")),
    }
}

/// The normal spread of a table with the key `sd`; `None` without it.
fn normal(table: &Section, read: axis::Number) -> Result<Option<Spread>, ConfigError> {
    let Some(node) = table.get("sd") else { return Ok(None) };
    let sd = read(&node)?;
    match sd.is_finite() && sd >= 0.0 {
        true => Ok(Some(Spread::Normal { sd })),
        false => Err(node.error("the standard deviation must be at least 0", "choose another sd")),
    }
}

/// Reads the law and the machine of `file`, with `values` instead of the values in the file. A quantity
/// with a standard deviation keeps it around its new value. The file is validated as for a run.
///
/// # Errors
/// The first error, with its place, its value and a remedy.
pub fn load_machine(file: &Path, values: &[(String, f64)]) -> Result<MachineJob, ConfigError> {
    let written = Source::load(file, &[])?;
    let written = written.root().section("machine")?;
    let sd_of = |name: &str| match written.get(name)?.shape() {
        Shape::Table(table) => {
            let node = table.get("sd")?;
            node.number()
                .map(|sd| format!("{sd:?}"))
                .or_else(|_| node.text().map(|sd| format!("{sd:?}")))
                .ok()
        }
        _ => None,
    };
    // The mass is set under the key that the file uses.
    let names = [MASS, INERTIA];
    let in_file = names.into_iter().find(|name| written.get(name).is_some());
    let set = |(name, value): &(String, f64)| {
        let name = in_file.filter(|_| names.contains(&name.as_str())).unwrap_or(name);
        match sd_of(name) {
            Some(sd) => format!("machine.{name}={{ value = {value:?}, sd = {sd} }}"),
            None => format!("machine.{name}={value:?}"),
        }
    };
    let source = Source::load(file, &values.iter().map(set).collect::<Vec<_>>())?;
    let root = source.root();
    super::refuse_unknown_sections(&root)?;
    let section = root.section("machine")?;
    if !written.is_present() {
        return Err(root.missing(
            "machine",
            "name a configuration that describes a machine in a table [machine]".into(),
        ));
    }
    let friction = root.section("friction")?;
    let about = About::Machine(motion_of(&section)?);
    let law = law::read(&friction, file.parent().unwrap_or(Path::new("")), about)?;
    let known = known_keys(&law);
    if let Some(key) = section.keys().iter().find(|key| !known.contains(&key.as_str())) {
        return Err(section.unknown(key, remedy(key, &law)));
    }
    let title = root.get("title").map(|node| super::line(&node).map(str::to_owned)).transpose()?;
    let job = MachineJob { title, ..read(&section, &friction, &law)? };
    // What is wrong in the rest of the file, or replaced by `values`, is an error of a run, so it is one
    // here.
    let only_set = values.iter().filter(|(name, _)| match names.contains(&name.as_str()) {
        true => in_file.is_none(),
        false => written.get(name).is_none(),
    });
    super::Job::load(file, &only_set.map(set).collect::<Vec<_>>())?;
    Ok(job)
}

/// Reads the kind of motion.
pub(super) fn motion_of(section: &Section) -> Result<Motion, ConfigError> {
    let motions = Motion::ALL.map(|motion| (motion.name(), motion));
    section.get("motion").map_or(Ok(Motion::Translation), |node| choice(&node, &motions, "motion"))
}

/// Reads `[machine]`; `law` is in SI units.
pub(super) fn read(section: &Section, friction: &Section, law: &Law) -> Result<MachineJob, ConfigError> {
    let forces = law::holds_forces(friction, law)?;
    check_complete(section, law, forces)?;
    let motion = motion_of(section)?;
    let (varied, uncertain, conversions) = (Vec::new(), Vec::new(), RefCell::default());
    let mut reader = Reader { section, motion, conversions, varied, uncertain };
    let belt_speed = reader.number(BELT_SPEED)?;
    let fastest = 2.0 * reader.values(BELT_SPEED, belt_speed).last().copied().unwrap_or(belt_speed);
    let damping = reader.number(DAMPING)?;
    let mass = reader.number_that(key_of_mass(section, motion)?, MASS, |mass| requirement(MASS, mass))?;
    // Measured forces belong to the normal force of the measurement, or to an unknown one.
    let normal_force = match section.get("normal_force") {
        None => 1.0,
        Some(node) if forces && matches!(law.as_written(), Law::Expression(_)) => {
            return Err(node.error("the formula is a force already", "leave normal_force out"));
        }
        Some(_) => reader.number("normal_force")?,
    };
    if let Some(node) = section.get("normal_force").filter(|_| forces && reader.varies("normal_force")) {
        let problem = "measured forces belong to one normal force, that of the measurement";
        return Err(node.error(problem, "divide the data by it, and leave quantity = \"force\" out"));
    }
    let known = match law.as_written() {
        Law::Expression(formula) => reader.formula(friction, formula, fastest)?,
        Law::Table(table) => {
            let unit = if forces { normal_force } else { 1.0 };
            measured(friction, table, unit, fastest, motion)?
        }
        law => Friction::Coefficients(law.clone(), reader.coefficients(law)?),
    };
    let machine = Machine {
        motion,
        mass,
        stiffness: reader.number("stiffness")?,
        damping,
        normal_force,
        normal_force_is_known: section.get("normal_force").is_some(),
        friction: known,
        small: law.is_read_as_small(),
        belt_speed,
    };
    let Reader { varied, uncertain, conversions, .. } = reader;
    if machine.model().is_none() {
        let node = friction.get("phi").or_else(|| friction.get("file"));
        let (problem, remedy) = (
            "it leaves the numbers, or is too long, in dimensionless terms",
            "check the units, or simplify it",
        );
        return Err(node.map_or_else(
            || section.missing("mass", format!("{problem}; {remedy}")),
            |node| node.error(problem, remedy),
        ));
    }
    Ok(MachineJob { machine, varied, uncertain, conversions: conversions.into_inner(), title: None })
}

/// Reads numbers of `[machine]`.
struct Reader<'a> {
    section: &'a Section<'a>,
    motion: Motion,
    /// What units in the file are in SI.
    conversions: RefCell<Vec<String>>,
    /// The quantities with several values.
    varied: Vec<(&'static str, Vec<f64>)>,
    /// The uncertain quantities found.
    uncertain: Vec<Uncertain>,
}

impl<'a> Reader<'a> {
    fn node(&self, key: &str) -> Result<Node<'a>, ConfigError> {
        let how = "write a number in SI units";
        self.section.get(key).ok_or_else(|| self.section.missing(key, how.into()))
    }

    /// Reads a quantity that may vary or be uncertain; returns its first or nominal value.
    fn number(&mut self, key: &'static str) -> Result<f64, ConfigError> {
        self.number_that(key, key, |value| requirement(key, value))
    }

    /// Reads `quantity` from the entry `key`: a number, a list, a range, or an uncertain number; returns the first
    /// or nominal one. A range may have a standard deviation, which applies to each of its values.
    fn number_that(
        &mut self,
        key: &'static str,
        quantity: &'static str,
        requirement: impl Fn(f64) -> (bool, &'static str),
    ) -> Result<f64, ConfigError> {
        let node = self.node(key)?;
        let read = |node: &Node| self.in_si(node, quantity);
        let (values, spread) = match (uncertain(&node, &read)?, node.shape()) {
            (Some((value, spread)), _) => (vec![value], Some(spread)),
            (None, Shape::Table(range)) if range.get("sd").is_some() => {
                if quantity == DAMPING {
                    let remedy = "leave sd out, or write one value: { value = 50.0, sd = 5.0 }";
                    return Err(node.error("a range of these has no standard deviation", remedy));
                }
                let known: Vec<&str> = axis::RANGE_KEYS.into_iter().chain(["sd"]).collect();
                refuse_unknown_keys(&range, &known)?;
                (axis::nodes_of_range(&node, &range, &read)?, normal(&range, &read)?)
            }
            (None, _) => (axis::nodes_by(&node, &read)?, None),
        };
        for &value in &values {
            check(&node, key, value, requirement(value))?;
        }
        if let Some(pair) = values.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(node
                .error(&format!("{} follows {}", pair[1], pair[0]), "sort the values, without repetition"));
        }
        self.uncertain.extend(spread.map(|spread| (quantity, spread)));
        let first = values[0];
        if values.len() > 1 {
            self.varied.push((quantity, values));
        }
        Ok(first)
    }

    /// Reads a number in SI units, or a text with a number and its unit.
    fn in_si(&self, node: &Node, quantity: &str) -> Result<f64, ConfigError> {
        let wanted = match Dimension::of_quantity(quantity) {
            Some(dimension) => Some(Wanted::Si(self.motion, dimension)),
            None => ["static_friction", "kinetic_friction"].contains(&quantity).then_some(Wanted::Number),
        };
        let written = node.text().ok().and_then(with_unit);
        let (Some(wanted), Some((number, unit))) = (wanted, written) else { return node.number() };
        let si = if wanted.name().is_empty() { "1" } else { wanted.name() };
        match compare(unit, wanted) {
            Match::Same => Ok(number),
            Match::Factor(factor) => {
                let told = conversion(unit, factor, wanted);
                let mut all = self.conversions.borrow_mut();
                if !all.contains(&told) {
                    all.push(told);
                }
                Ok(converted(number, factor))
            }
            Match::Other => Err(node.error(
                &format!("{unit} is no unit of {}", quantity.replace('_', " ")),
                format!("write it in {si}, or in a unit of the same kind"),
            )),
            Match::Unknown => {
                Err(node.error(&format!("the unit {unit} is not known"), format!("write the number in {si}")))
            }
        }
    }

    fn varies(&self, quantity: &str) -> bool {
        self.varied.iter().any(|(name, _)| *name == quantity)
    }

    /// The values of a quantity that was read; `first` alone if it does not vary.
    fn values(&self, quantity: &str, first: f64) -> Vec<f64> {
        let varied = self.varied.iter().find(|(name, _)| *name == quantity);
        varied.map_or_else(|| vec![first], |(_, values)| values.clone())
    }

    fn coefficients(&mut self, law: &Law) -> Result<Coefficients, ConfigError> {
        let has_velocity = Coefficients::names(law).any(|name| name == "stribeck_velocity");
        // The least one, which is the first.
        let static_friction = self.number("static_friction")?;
        let kinetic = |value| ((0.0..=static_friction).contains(&value), Coefficients::KINETIC);
        Ok(Coefficients {
            static_friction,
            kinetic_friction: self.number_that("kinetic_friction", "kinetic_friction", kinetic)?,
            stribeck_velocity: if has_velocity { self.number("stribeck_velocity")? } else { 1.0 },
            strengthening: match self.section.get("strengthening") {
                None => 0.0,
                Some(_) => self.number("strengthening")?,
            },
        })
    }

    /// Reads the values of a formula's names and checks that it is legal on slip speeds up to `fastest`.
    fn formula(
        &mut self,
        friction: &Section,
        formula: &Expression,
        fastest: f64,
    ) -> Result<Friction, ConfigError> {
        let Some(phi) = friction.get("phi") else { return Err(friction.missing("phi", String::new())) };
        check_names(formula).map_err(|error| at_formula(&phi, &error))?;
        let mut values = Vec::new();
        for parameter in formula.parameters() {
            values.push(self.number_that(parameter.name, parameter.name, |_| (true, "a number"))?);
        }
        let known = Friction::Formula(formula.clone(), LawParameters::new(&values));
        let rest = known.at_rest();
        if !known.is_legal_at_rest() {
            let problem = format!("the coefficient of friction at rest, u = 0, is {rest}");
            return Err(phi.error(&problem, "write a formula that is greater than 0 there"));
        }
        let divided = Expression::with_static(formula.text(), rest);
        let checked = divided.and_then(|law| law.check(1.0, &LawParameters::new(&values), fastest));
        checked.map(|()| known).map_err(|error| at_formula(&phi, &error))
    }
}

/// Measured friction, divided by `unit` to give coefficients; it must cover slip speeds up to `fastest`.
fn measured(
    friction: &Section,
    table: &Table,
    unit: f64,
    fastest: f64,
    motion: Motion,
) -> Result<Friction, ConfigError> {
    let Some(file) = friction.get("file") else { return Err(friction.missing("file", String::new())) };
    if table.fastest() < fastest {
        let velocity = motion.unit(Dimension::Velocity);
        let problem = format!(
            "the data end at slip speed {} {velocity}, and belt speeds up to {} {velocity} need it up to {fastest} {velocity}",
            table.fastest(),
            0.5 * fastest
        );
        return Err(file.error(&problem, "measure farther, or choose lower belt speeds"));
    }
    let coefficients = table.in_units(1.0, unit);
    coefficients.map(Friction::Measured).map_err(|error| file.error(&error.problem, error.remedy))
}

fn check(node: &Node, key: &str, value: f64, (legal, wanted): (bool, &str)) -> Result<(), ConfigError> {
    match legal && value.is_finite() {
        true => Ok(()),
        false => Err(node.error(
            &format!("{key} must be {wanted}"),
            "mind the units: kg, N/m, N s/m, N, m/s; of a rotation kg m^2, N m/rad, N m s/rad, N m, rad/s",
        )),
    }
}

/// The grid of a machine.
pub(super) fn grid(section: &Section, job: &MachineJob) -> Result<Grid, ConfigError> {
    Grid::of_machine(&job.machine, &job.varied).map_err(|error| {
        let name = job.varied.first().map_or(BELT_SPEED, |(name, _)| name);
        let remedy = "check the units and the values";
        section.get(name).map_or_else(
            || section.missing(name, format!("{error}; {remedy}")),
            |node| node.error(&error.to_string(), remedy),
        )
    })
}

//! The machine of a configuration, in SI units; replaces `[grid]`.

use std::cell::RefCell;
use std::fmt::Debug;
use std::path::Path;

use super::described::{About, FitText, Wrong};
use super::source::{ConfigError, ConfigFile, Node, Section, Shape};
use super::uncertain::{normal, uncertain, with_deviation};
use super::units::{Match, compare, conversion, converted, meant, size, size_on_disc, with_unit};
use super::{axis, choice, fitted, law, nearest, refuse_unknown_keys};
use slipmap_machine::risk::{Spread, Uncertain};
use slipmap_machine::{
    AREA, BELT_SPEED, Coefficients, DAMPING, DAMPING_RATIO, Dimension, FREQUENCY, Friction, Given, INERTIA,
    MASS, Machine, Motion, NORMAL_FORCE, Normal, PRESSURE, RADIUS, STATIC_FRICTION, requirement, unit,
};
use slipmap_map::{Grid, Shown};
use slipmap_model::friction::{Expression, ExpressionError, Law, Source, Table};

/// A machine, of which any quantities may vary.
#[derive(Clone, Debug, PartialEq)]
pub struct MachineJob {
    /// The machine at the first value of every quantity.
    pub machine: Machine,
    /// The quantities with several values: increasing, in SI units.
    pub varied: Vec<(&'static str, Vec<f64>)>,
    /// The uncertain quantities and their distributions.
    pub uncertain: Vec<Uncertain>,
    /// The units of the file, by quantity, the first of each; `None` is the SI unit.
    pub units: Vec<(&'static str, Option<Shown>)>,
    /// What units in the file are in SI: "1 rpm is 0.10472 rad/s".
    pub conversions: Vec<String>,
    /// The title of its page.
    pub title: Option<String>,
}

/// The keys of `[machine]` under `law`: the motion and the quantities, if those that `is_given` stand in place of
/// others.
pub fn keys(law: &Law, is_given: impl Fn(&str) -> bool) -> Vec<&'static str> {
    std::iter::once("motion").chain(Machine::names(law, is_given)).collect()
}

/// All keys that `[machine]` may have: those of [`keys`], what may stand in their place, and `inertia`, the other name
/// of the mass.
pub(super) fn known_keys(law: &Law) -> Vec<&'static str> {
    let keys = keys(&law.clone().with_exponent(), |_| false).into_iter();
    keys.chain(Given::NAMES).chain([INERTIA]).collect()
}

/// Refuses a formula that uses the name of a quantity of the machine.
pub fn check_names(law: &Law) -> Result<(), Wrong> {
    let Law::Expression(formula) = law.as_written() else { return Ok(()) };
    if formula.depends_on_epsilon() && !law.is_read_as_small() {
        let remedy = "give the parameter of the friction another name";
        return Err(Wrong::new(
            "phi",
            "eps is reserved: it is the size of the small terms, which a machine has not",
            remedy,
        ));
    }
    let mut names = formula.parameters().iter().map(|parameter| parameter.name);
    let machine = known_keys(&Law::Coulomb);
    let is_taken = |name: &&str| machine.contains(name) && !Coefficients::NAMES.contains(name);
    let Some(name) = names.find(is_taken) else { return Ok(()) };
    let (from, to) = formula.place_of(name).unwrap_or_default();
    let problem = format!("`{name}` is a quantity of the machine");
    let remedy = "give the parameter of the friction another name".to_owned();
    Err(Wrong::in_formula(ExpressionError { from, to, problem, remedy }))
}

/// The remedy for an unknown key of `[machine]`.
pub(super) fn remedy(key: &str, law: &Law) -> String {
    match key {
        "eps" | "epsilon" | "u" | "v" | "e" | "pi" => {
            format!("`{key}` is reserved in formulas; give the parameter another name")
        }
        Coefficients::EXPONENT => {
            format!("leave it out, or set law = \"exponential\": the law `{}` has no exponent", law.name())
        }
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
        key => nearest("key", key, &known_keys(law)),
    }
}

/// Refuses quantities that exclude each other.
fn check_places(section: &Section, motion: Motion, forces: bool) -> Result<(), ConfigError> {
    let both =
        |first: &str, second: &str| section.get(first).is_some().then(|| section.get(second)).flatten();
    let of_mass = |name: &str| section.get(name).or_else(|| section.get(INERTIA));
    if let (Some(_), Some(node)) = (of_mass(MASS), both("stiffness", FREQUENCY)) {
        let problem = "the mass and the stiffness have a frequency already";
        return Err(node.error(problem, "leave one of the three out"));
    }
    for (one, other) in Given::IN_PLACE {
        if let Some(node) = both(one, other) {
            let problem = format!("{other} stands in place of {one}, which is there, too");
            return Err(node.error(&problem, "leave one of them out"));
        }
    }
    let of_rotation = (motion == Motion::Rotation).then_some(RADIUS);
    let mut others = [Some(PRESSURE), Some(AREA), of_rotation].into_iter().flatten();
    let others = others.find_map(|name| section.get(name));
    match others.filter(|_| forces) {
        Some(node) => {
            Err(node.error("friction that is a force already has one normal force", "leave this out"))
        }
        None => Ok(()),
    }
}

/// Whether a text is a number in a unit of force or torque.
pub fn is_force(text: &str) -> bool {
    let is_of = |unit: &str, motion: Motion| {
        matches!(compare(unit, motion.unit(Dimension::Force)), Match::Same | Match::Factor(_))
    };
    with_unit(text).is_some_and(|(_, unit)| Motion::ALL.into_iter().any(|motion| is_of(unit, motion)))
}

/// Whether the coefficients of a law are written as forces or torques.
fn has_forces(section: &Section, law: &Law) -> bool {
    let first = |text: &str| with_deviation(text).map_or(text.to_owned(), |(value, _)| value);
    let is_force = |text: &str| is_force(&first(text));
    law.built_in().is_some() && section.get(STATIC_FRICTION).is_some_and(|node| node.has_text(is_force))
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

/// Whether a quantity is written, the mass perhaps by its other name.
fn is_given(section: &Section, name: &str) -> bool {
    section.get(name).is_some() || name == MASS && section.get(INERTIA).is_some()
}

/// Refuses a machine that lacks keys, naming all of them at once; those that `is_fitted` may be left out.
fn check_complete(
    section: &Section,
    law: &Law,
    forces: bool,
    is_fitted: impl Fn(&str) -> bool,
) -> Result<(), ConfigError> {
    let optional = |key: &str| match key {
        "motion" | "strengthening" => true,
        NORMAL_FORCE => forces,
        MASS => section.get(INERTIA).is_some(),
        _ => false,
    };
    let keys = keys(law, |name| is_given(section, name)).into_iter();
    let missing = keys.filter(|key| !optional(key) && !is_fitted(key) && section.get(key).is_none());
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

/// Reads the law and the machine of `file`, with `values` instead of the values in the file: numbers in SI units, or
/// texts with another unit. A quantity with a standard deviation keeps it around its new value. The file is validated as
/// for a run.
///
/// # Errors
/// The first error, with its place, its value and a remedy.
pub fn load_machine<V: Debug>(file: &Path, values: &[(String, V)]) -> Result<MachineJob, ConfigError> {
    let written = ConfigFile::load(file, &[])?;
    let written = written.root().section("machine")?;
    let text_of = |node: &Node| node.text().map(str::to_owned).ok();
    let sd_of = |name: &str| match written.get(name)?.shape() {
        Shape::Table(table) => {
            let node = table.get("sd")?;
            node.number()
                .map_or_else(|_| Some(format!("{:?}", text_of(&node)?)), |sd| Some(format!("{sd:?}")))
        }
        _ => with_deviation(&text_of(&written.get(name)?)?).map(|(_, sd)| format!("{sd:?}")),
    };
    // The mass is set under the key that the file uses.
    let names = [MASS, INERTIA];
    let in_file = names.into_iter().find(|name| written.get(name).is_some());
    // Numbers and texts are written in TOML as in Rust.
    let set = |(name, value): &(String, V)| {
        let name = in_file.filter(|_| names.contains(&name.as_str())).unwrap_or(name);
        let has_own = with_deviation(&format!("{value:?}")).is_some();
        match sd_of(name).filter(|_| !has_own) {
            Some(sd) => format!("machine.{name}={{ value = {value:?}, sd = {sd} }}"),
            None => format!("machine.{name}={value:?}"),
        }
    };
    let source = ConfigFile::load(file, &values.iter().map(set).collect::<Vec<_>>())?;
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
    let law = law::read(&friction, &section, file.parent().unwrap_or(Path::new("")), about)?;
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
    let forces = law::holds_forces(friction, law)? || has_forces(section, law);
    let motion = motion_of(section)?;
    check_places(section, motion, forces)?;
    let wrong = |wrong: Wrong| law::at(friction, section, wrong);
    check_names(law).map_err(wrong)?;
    let fit = fitted::values(friction);
    let fitted = fit.as_ref().and_then(FitText::spreads).unwrap_or_default();
    let of_fit = |name: &str| fitted.iter().find(|(known, ..)| *known == name);
    check_complete(section, law, forces, |name| of_fit(name).is_some())?;
    if let Some(node) = section.get(NORMAL_FORCE).filter(|_| forces) {
        if !matches!(law.as_written(), Law::Table(_)) {
            return Err(node.error("the friction is a force already", "leave normal_force out"));
        }
        if axis::nodes_by(&node, &|_| Ok(0.0)).is_ok_and(|nodes| nodes.len() > 1) {
            let problem = "measured forces belong to one normal force, that of the measurement";
            return Err(node.error(problem, "divide the data by it, and leave quantity = \"force\" out"));
        }
    }
    // That of a disc is no quantity.
    let is_quantity = |name: &str| name != RADIUS || motion == Motion::Rotation;
    let mut names = Machine::names(law, |name| is_quantity(name) && is_given(section, name));
    // In the order of the random numbers of what is uncertain.
    names.sort_by_key(|name| match *name {
        BELT_SPEED => 0,
        DAMPING | DAMPING_RATIO => 1,
        MASS => 2,
        "stiffness" => 4,
        _ => 3,
    });
    let mass = key_of_mass(section, motion)?;
    let mut reader = Reader::new(section, motion, law, forces);
    reader.find_radius()?;
    let mut values = Vec::new();
    for name in names {
        let key = if name == MASS { mass } else { name };
        match (section.get(key), of_fit(name)) {
            (Some(node), _) => values.push((name, reader.number_that(&node, key, name)?)),
            (None, Some(&(_, value, spread))) => {
                values.push((name, value));
                // Of exact readings a parameter has no error.
                if !matches!(spread, Spread::Joint { row } if row.iter().all(|part| *part == 0.0)) {
                    reader.uncertain.push((name, spread));
                }
            }
            (None, None) => {}
        }
    }
    let Reader { varied, uncertain, units, conversions, radius, .. } = reader;
    let known = |name: &str| values.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
    let largest = |name: &str| {
        let several = varied.iter().find(|(known, _)| *known == name);
        several.and_then(|(_, values)| values.last().copied()).or_else(|| known(name))
    };
    let value = |name: &str| known(name).or_else(|| (name == "strengthening").then_some(0.0));
    let mut machine = machine_of(motion, law, value, largest).map_err(wrong)?;
    machine.given = machine.given.on_disc(radius.filter(|_| motion == Motion::Translation));
    let (units, conversions) = (units.into_inner(), conversions.into_inner());
    Ok(MachineJob { machine, varied, uncertain, units, conversions, title: None })
}

/// Reads numbers of `[machine]`.
struct Reader<'a> {
    section: &'a Section<'a>,
    motion: Motion,
    law: &'a Law,
    normal: Normal,
    /// m: the radius that makes rotary speeds of speeds along a line, and back.
    radius: Option<f64>,
    /// The units of the file, by quantity, the first of each; `None` is the SI unit.
    units: RefCell<Vec<(&'static str, Option<Shown>)>>,
    /// What they are in SI.
    conversions: RefCell<Vec<String>>,
    /// The quantities with several values.
    varied: Vec<(&'static str, Vec<f64>)>,
    /// The uncertain quantities found.
    uncertain: Vec<Uncertain>,
}

/// Reads a number of `quantity` elsewhere than in `[machine]`, which is `section`.
pub(super) fn in_si(
    section: &Section,
    law: &Law,
    node: &Node,
    quantity: &'static str,
) -> Result<f64, ConfigError> {
    let forces = has_forces(section, law);
    let mut reader = Reader::new(section, motion_of(section)?, law, forces);
    reader.find_radius()?;
    reader.in_si(node, quantity)
}

impl<'a> Reader<'a> {
    fn new(section: &'a Section<'a>, motion: Motion, law: &'a Law, forces: bool) -> Self {
        let (units, conversions) = Default::default();
        let normal = Normal::of(forces, section.get(RADIUS).is_some());
        Self {
            section,
            motion,
            law,
            normal,
            radius: None,
            units,
            conversions,
            varied: Vec::new(),
            uncertain: Vec::new(),
        }
    }

    /// Reads the radius, of which the units of speed may depend; of a rotation that varies there is none.
    fn find_radius(&mut self) -> Result<(), ConfigError> {
        let Some(node) = self.section.get(RADIUS) else { return Ok(()) };
        let is_one = matches!(node.shape(), Shape::Number | Shape::Text);
        let of_disc = self.motion == Motion::Translation;
        if of_disc && !is_one {
            return Err(
                node.error("the radius of a disc is one number", "let belt_speed vary, or have the sd")
            );
        }
        if is_one && !node.has_text(|text| with_deviation(text).is_some()) {
            let radius = self.in_si(&node, RADIUS)?;
            check(&node, RADIUS, radius, requirement(RADIUS, radius))?;
            self.radius = Some(radius);
        }
        Ok(())
    }

    /// Reads `quantity` from the entry `node`, of the name `key`: a number, a list, a range, or an uncertain number;
    /// returns the first or nominal one. A range may have a standard deviation, which applies to each of its values.
    fn number_that(
        &mut self,
        node: &Node,
        key: &'static str,
        quantity: &'static str,
    ) -> Result<f64, ConfigError> {
        let is_of_formula = self.is_of_formula(quantity);
        let requirement = |value| match is_of_formula {
            true => (true, "a number"),
            false => requirement(quantity, value),
        };
        let read = |node: &Node| self.in_si(node, quantity);
        let read_part = |node: &Node, part: Option<&str>| match part {
            Some(part) => self.of_text(node, part, quantity),
            None => read(node),
        };
        let (values, spread) = match (uncertain(node, &read_part)?, node.shape()) {
            (Some((value, spread)), _) => (vec![value], Some(spread)),
            (None, Shape::Table(range)) if range.get("sd").is_some() => {
                if [DAMPING, DAMPING_RATIO].contains(&quantity) {
                    let remedy = "leave sd out, or write one value: { value = 50.0, sd = 5.0 }";
                    return Err(node.error("a range of these has no standard deviation", remedy));
                }
                let known: Vec<&str> = axis::RANGE_KEYS.into_iter().chain(["sd"]).collect();
                refuse_unknown_keys(&range, &known)?;
                (axis::nodes_of_range(node, &range, &read)?, normal(&range, None, &read_part)?)
            }
            (None, _) => (axis::nodes_by(node, &read)?, None),
        };
        for &value in &values {
            check(node, key, value, requirement(value))?;
        }
        if let Some(pair) = values.windows(2).find(|pair| pair[0] >= pair[1]) {
            return Err(node
                .error(&format!("{} follows {}", pair[1], pair[0]), "sort the values, without repetition"));
        }
        self.uncertain.extend(spread.map(|spread| (quantity, spread)));
        let first = values[0];
        self.tell_bare(key, quantity, first);
        if values.len() > 1 {
            self.varied.push((quantity, values));
        }
        Ok(first)
    }

    /// Tells that a number without a unit is in SI units where the file has another unit, in place of which it was set.
    fn tell_bare(&self, key: &'static str, quantity: &'static str, value: f64) {
        let si = unit(quantity, self.motion, self.law, self.normal);
        let is_bare = self.units.borrow().iter().any(|(known, shown)| *known == quantity && shown.is_none());
        let other = |text: &str| {
            with_unit(text).is_some_and(|(_, unit)| matches!(compare(unit, si), Match::Factor(_)))
        };
        let in_file = self.section.text_in_file(key, other).and_then(with_unit);
        if let Some((_, unit)) =
            in_file.filter(|_| is_bare && !self.is_of_formula(quantity) && !si.is_empty())
        {
            let told =
                format!("{key} = {value} is in {si}; for {unit} write --set 'machine.{key}={value} {unit}'");
            self.conversions.borrow_mut().push(told);
        }
    }

    /// Whether this is the name of a formula's parameter.
    fn is_of_formula(&self, quantity: &str) -> bool {
        let is_formula = matches!(self.law.as_written(), Law::Expression(_));
        is_formula && self.law.parameters().iter().any(|parameter| parameter.name == quantity)
    }

    /// Notes the first unit of a quantity.
    fn note(&self, quantity: &'static str, shown: Option<Shown>) {
        let mut units = self.units.borrow_mut();
        if units.iter().all(|(known, _)| *known != quantity) {
            units.push((quantity, shown));
        }
    }

    fn tell(&self, told: String) {
        let mut all = self.conversions.borrow_mut();
        if !all.contains(&told) {
            all.push(told);
        }
    }

    /// Reads a number in SI units, or a text with a number and its unit.
    fn in_si(&self, node: &Node, quantity: &'static str) -> Result<f64, ConfigError> {
        match node.text().ok().filter(|text| with_unit(text).is_some()) {
            Some(text) => self.of_text(node, text, quantity),
            None => {
                self.note(quantity, None);
                node.number()
            }
        }
    }

    /// Reads a number in SI units, or with its unit, from a text of a node.
    fn of_text(&self, node: &Node, text: &str, quantity: &'static str) -> Result<f64, ConfigError> {
        let wanted = unit(quantity, self.motion, self.law, self.normal);
        let note = |shown: Option<Shown>| self.note(quantity, shown);
        let Some((number, unit)) = with_unit(text) else {
            note(None);
            return text.parse().map_err(|_| node.wrong_kind("a number"));
        };
        // A parameter of a formula has the unit that it is written with.
        if self.is_of_formula(quantity)
            && let Some(size) = size(unit)
        {
            note(Some(Shown { unit: unit.into(), size }));
            return Ok(converted(number, size));
        }
        let si = if wanted.is_empty() { "1" } else { wanted };
        let is_speed = Dimension::of_quantity(quantity) == Some(Dimension::Velocity);
        let on_disc =
            self.radius.filter(|_| is_speed).and_then(|radius| size_on_disc(unit, self.motion, radius));
        if let Some(size) = on_disc {
            self.tell(conversion(unit, size, wanted));
            note(Some(Shown { unit: unit.into(), size }));
            return Ok(number * size);
        }
        match compare(unit, wanted) {
            Match::Same => {
                note(None);
                Ok(number)
            }
            Match::Factor(factor) => {
                self.tell(conversion(unit, factor, wanted));
                note(Some(Shown { unit: unit.into(), size: factor }));
                Ok(converted(number, factor))
            }
            Match::Other => {
                let force = Motion::Translation.unit(Dimension::Force);
                let is_force = quantity == NORMAL_FORCE && compare(unit, force) != Match::Other;
                let of_disc = is_speed && size_on_disc(unit, self.motion, 1.0).is_some();
                let radius = match () {
                    () if is_force => "; with radius = .. it is a force, not times the arm",
                    () if of_disc => "; with radius = .. a disc's speed may be in either",
                    () => "",
                };
                let torque = self.motion.unit(Dimension::Force);
                let of_friction =
                    Coefficients::NAMES.contains(&quantity) && compare(unit, torque) != Match::Other;
                let friction = if of_friction {
                    "; where static_friction has a unit, all friction is a force"
                } else {
                    ""
                };
                Err(node.error(
                    &format!("{unit} is no unit of {}", quantity.replace('_', " ")),
                    format!("write it in {si}, or in a unit of the same kind{radius}{friction}"),
                ))
            }
            Match::Unknown => {
                let remedy = match unit.strip_prefix(',') {
                    Some(decimals) => format!("write decimals with a point: {number}.{decimals}"),
                    None => format!(
                        "write {}",
                        meant(unit, wanted).unwrap_or_else(|| format!("the number in {si}"))
                    ),
                };
                Err(node.error(&format!("the unit {unit} is not known"), remedy))
            }
        }
    }
}

/// The machine of a law in SI units with these values of its quantities; `largest` is the largest value of one that
/// varies. Measured forces are divided by the normal force, if there is one. Every number is one of a machine, and the
/// friction is known and legal up to twice the belt speed.
///
/// # Errors
/// The first quantity that is missing or illegal, or what is wrong with the friction.
pub fn machine_of(
    motion: Motion,
    law: &Law,
    value: impl Fn(&str) -> Option<f64>,
    largest: impl Fn(&str) -> Option<f64>,
) -> Result<Machine, Wrong> {
    check_names(law)?;
    let fastest = 2.0 * largest(BELT_SPEED).unwrap_or(f64::NAN);
    let (law, unit) = match law.as_written() {
        Law::Table(table) => {
            check_reach(table, fastest, motion)?;
            let unit = Some(NORMAL_FORCE).filter(|_| table.source().forces).and_then(&value);
            let source = Source { forces: table.source().forces && unit.is_none(), ..table.source().clone() };
            let table = table.in_units(1.0, unit.unwrap_or(1.0));
            let table = table.map_err(|error| Wrong::new("file", error.problem, error.remedy))?;
            let table = Law::Table(table.with_source(source));
            (if law.is_read_as_small() { table.read_as_small() } else { table }, "file")
        }
        _ => (law.clone(), "phi"),
    };
    let machine = Machine::new(motion, &law, &value).ok_or_else(|| {
        let names = Machine::names(&law, |name| value(name).is_some());
        let missing = names.into_iter().find(|name| *name != NORMAL_FORCE && value(name).is_none());
        Wrong::missing(missing.unwrap_or(MASS), "write a number in SI units")
    })?;
    if let Some((name, value, wanted)) = machine.illegal() {
        let at_most = largest("static_friction").unwrap_or(0.0);
        // Some static friction exceeds it.
        if name != "kinetic_friction" || !(0.0..=at_most).contains(&value) {
            return Err(Wrong::new(name, format!("{name} must be {wanted}"), UNITS));
        }
    }
    let rest = machine.friction.at_rest();
    if !machine.friction.is_legal_at_rest() {
        let problem = format!("the coefficient of friction at rest, u = 0, is {rest}");
        return Err(Wrong::new(unit, problem, "write friction that is greater than 0 there"));
    }
    if let Friction::Formula(formula, parameters) = &machine.friction {
        let divided = Expression::with_static(&formula.text(), rest);
        let checked = divided.and_then(|law| law.check(1.0, parameters, fastest));
        checked.map_err(Wrong::in_formula)?;
    }
    match machine.model() {
        Some(_) => Ok(machine),
        None => {
            let problem = "it leaves the numbers, or is too long, in dimensionless terms";
            let key = if law.built_in().is_some() { MASS } else { unit };
            Err(Wrong::new(key, problem, "check the units, or simplify it"))
        }
    }
}

/// Checks that measured friction of a machine reaches to a slip speed.
fn check_reach(table: &Table, fastest: f64, motion: Motion) -> Result<(), Wrong> {
    if !(table.fastest() < fastest) {
        return Ok(());
    }
    let velocity = motion.unit(Dimension::Velocity);
    let problem = format!(
        "the data end at slip speed {} {velocity}, and belt speeds up to {} {velocity} need it up to {fastest} {velocity}",
        table.fastest(),
        0.5 * fastest
    );
    Err(Wrong::new("file", problem, "measure farther, or choose lower belt speeds"))
}

/// The remedy for an illegal number.
const UNITS: &str =
    "mind the units: kg, N/m, N s/m, N, m/s; of a rotation kg m^2, N m/rad, N m s/rad, N m, rad/s";

fn check(node: &Node, key: &str, value: f64, (legal, wanted): (bool, &str)) -> Result<(), ConfigError> {
    match legal && value.is_finite() {
        true => Ok(()),
        false => Err(node.error(&format!("{key} must be {wanted}"), UNITS)),
    }
}

/// The grid of a machine.
pub(super) fn grid(section: &Section, job: &MachineJob) -> Result<Grid, ConfigError> {
    let unit = |name: &str| job.units.iter().find(|(known, _)| *known == name)?.1.clone();
    let grid = Grid::of_machine(&job.machine, &job.varied);
    grid.map(|grid| grid.shown_in(unit)).map_err(|error| {
        let name = job.varied.first().map_or(BELT_SPEED, |(name, _)| name);
        let remedy = "check the units and the values";
        section.get(name).map_or_else(
            || section.missing(name, format!("{error}; {remedy}")),
            |node| node.error(&error.to_string(), remedy),
        )
    })
}

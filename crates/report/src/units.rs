//! The units in which the numbers of a map are shown: those of its machine, or none.

use slipmap_model::friction::Law;
use std::sync::OnceLock;

use slipmap_figure::text::{Piece, Rich, rich};
use slipmap_format::{MapFile, Value};
use slipmap_map::dataset::auxiliary::PROBABILITY;
use slipmap_map::machine::{
    Coefficients, Dimension, MOTION_ATTRIBUTE, Model, Motion, SI_ATTRIBUTE, SiUnits, UNITS_ATTRIBUTE, Units,
};
use slipmap_map::map::{Axis, AxisRole, Field, Quantity, dimension};

/// A map and the units in which its numbers are shown.
#[derive(Clone, Debug)]
pub struct View<'a> {
    /// The map.
    pub map: &'a MapFile,
    pub units: UnitSystem,
    /// See [`View::informative_nodes`].
    pub(super) informative: OnceLock<Vec<usize>>,
}

impl<'a> View<'a> {
    /// The map in the SI units of its machine, or dimensionless if it has none.
    #[must_use]
    pub fn new(map: &'a MapFile) -> Self {
        Self { map, units: UnitSystem { machine: units_of(map) }, informative: OnceLock::new() }
    }

    /// The map in dimensionless numbers, even if it is about a machine.
    pub fn dimensionless(map: &'a MapFile) -> Self {
        Self { map, units: UnitSystem::default(), informative: OnceLock::new() }
    }

    /// The name of an axis with its unit.
    pub(crate) fn axis(&self, axis: &Axis) -> Label {
        self.units.axis(axis)
    }

    /// "ε = 0.1, β = 0.5": the value of every axis at the nodes `index`, except those in `shown`. For a
    /// machine, words for its friction replace eps and the law's parameters with a single node.
    pub fn held(&self, index: &[usize], shown: &[usize]) -> Rich {
        let axes = self.map.grid().axes();
        let mut parts = Vec::new();
        for (i, axis) in axes.iter().enumerate().filter(|(i, _)| !shown.contains(i)) {
            let constant =
                matches!(axis.role, AxisRole::Epsilon | AxisRole::Law(_)) && axis.values.len() == 1;
            if self.units.machine.is_none() || !constant {
                parts.push(self.axis(axis).equals(axis.values[index[i]]));
            }
        }
        if let Some(si) = &self.units.machine {
            parts.extend(friction_words(self.map, si));
        }
        join(parts)
    }

    /// The oscillator of the map's machine at the middle node of every axis, the upper one of two: the first
    /// damping is often 0, and an undamped machine is of little interest. `None` for a dimensionless map.
    pub(crate) fn model(&self) -> Option<Model> {
        let si = self.units.machine?;
        let grid = self.map.grid();
        let middle: Vec<usize> = grid.axes().iter().map(|axis| axis.values.len() / 2).collect();
        Some(Model { law: grid.law().clone(), point: grid.point(&middle), si })
    }
}

/// Joins parts by commas, without those that are empty.
pub fn join(parts: impl IntoIterator<Item = Rich>) -> Rich {
    let mut text = Rich::default();
    for part in parts.into_iter().filter(|part| !part.pieces.is_empty()) {
        let separator = rich(if text.pieces.is_empty() { "" } else { ", " });
        text = text.then(separator).then(part);
    }
    text
}

/// The description of a machine's friction.
fn friction_words(map: &MapFile, si: &SiUnits) -> Vec<Rich> {
    let Some(numbers) = machine_numbers(map) else {
        return vec![match map.grid().law().as_written() {
            Law::Table(table) => rich("friction of ").then(Rich::foreign(table.origin())),
            Law::Expression(_) => rich("friction by formula"),
            law => rich("friction by ").then(Rich::foreign(law.name())),
        }];
    };
    let [_, _, _, _, rest, kinetic, width, strengthening, _] = numbers;
    let of = Coefficients::from_array([rest, kinetic, width, strengthening]);
    let velocity = si.unit(Dimension::Velocity);
    let number = |name: &str, value: f64, unit: &str| rich(name).then(Rich::number(value, 4)).with_unit(unit);
    let mut words = vec![
        number("friction at rest ", of.static_friction, ""),
        number("kinetic ", of.kinetic_friction, ""),
    ];
    if Coefficients::names(map.grid().law()).any(|name| name == "stribeck_velocity") {
        words.push(number("Stribeck velocity ", of.stribeck_velocity, velocity));
    }
    if of.strengthening > 0.0 {
        words.push(number("strengthening ", of.strengthening, ""));
    }
    words
}

/// The numbers of a machine whose friction is given by coefficients.
fn machine_numbers(map: &MapFile) -> Option<[f64; 9]> {
    let Some(Value::Reals(numbers)) = map.attributes().get(SI_ATTRIBUTE) else { return None };
    numbers.as_slice().try_into().ok()
}

/// The units of the machine that a map is about; `None` for a map in dimensionless terms.
fn units_of(map: &MapFile) -> Option<SiUnits> {
    let name = map.text(MOTION_ATTRIBUTE)?;
    let motion = Motion::ALL.into_iter().find(|motion| motion.name() == name)?;
    let units = match map.attributes().get(UNITS_ATTRIBUTE) {
        Some(Value::Reals(numbers)) => Units::from_array(numbers.as_slice().try_into().ok()?),
        // Maps of versions before 0.2.
        _ => {
            let [mass, stiffness, _, force, rest, ..] = machine_numbers(map)?;
            Units::of(mass, stiffness, rest * force)
        }
    };
    Some(SiUnits { motion, units })
}

/// Dimensionless numbers, or the SI units of a machine.
#[derive(Clone, Debug, Default)]
pub struct UnitSystem {
    /// The units, if they are those of a machine.
    pub(crate) machine: Option<SiUnits>,
}

/// Name and unit of a quantity, and the factor that converts dimensionless numbers to the unit.
#[derive(Clone, Debug, PartialEq)]
pub struct Label {
    /// The name in text and figures.
    pub name: Rich,
    /// The name in CSV headers, without the unit.
    pub key: String,
    /// The unit; empty for pure numbers.
    pub unit: &'static str,
    /// Factor by which dimensionless numbers are multiplied.
    pub factor: f64,
}

impl UnitSystem {
    pub fn of_machine(si: SiUnits) -> Self {
        Self { machine: Some(si) }
    }

    /// The label of a quantity of this dimension; `symbol` is its name in dimensionless numbers.
    pub fn quantity(&self, words: &str, symbol: Rich, key: &str, dimension: Option<Dimension>) -> Label {
        match (&self.machine, dimension) {
            (Some(si), Some(dimension)) => Label {
                name: rich(words),
                key: key.into(),
                unit: si.unit(dimension),
                factor: si.factor(dimension),
            },
            _ => Label { name: symbol, key: key.into(), unit: "", factor: 1.0 },
        }
    }

    /// The name of an axis with its unit.
    pub(crate) fn axis(&self, axis: &Axis) -> Label {
        let dimension = dimension::of_axis(axis.role);
        let (words, key) = match axis.role {
            AxisRole::BeltSpeed => ("belt speed", "belt_speed"),
            AxisRole::Damping => ("damping", "damping"),
            AxisRole::Epsilon | AxisRole::Law(_) => (axis.name.as_str(), axis.name.as_str()),
        };
        let symbol = Rich::symbol(&axis.name);
        match self.machine {
            Some(_) if dimension.is_some() => self.quantity(words, symbol, key, dimension),
            _ => Label { name: symbol, key: axis.name.clone(), unit: "", factor: 1.0 },
        }
    }

    /// The name of a variable of a map with its unit.
    pub fn variable(&self, name: &str) -> Label {
        let words = variable_words(name);
        let dimension = dimension::of_variable(name);
        Label { name: words.clone(), ..self.quantity("", words, name, dimension) }
    }

    /// Position of the mass.
    pub fn x1(&self) -> Label {
        self.quantity("displacement", rich("{x_1}"), "x1", Some(Dimension::Length))
    }

    /// Velocity of the mass.
    pub fn x2(&self) -> Label {
        self.quantity("velocity", rich("{x_2}"), "x2", Some(Dimension::Velocity))
    }

    pub fn time(&self) -> Label {
        self.quantity("time", rich("{t}"), "t", Some(Dimension::Time))
    }
}

impl Label {
    /// "damping, N s/m": for axes and headings.
    pub fn text(&self) -> Rich {
        let mut text = self.name.clone();
        match (self.unit, text.pieces.last_mut()) {
            ("", _) => text,
            // One piece of text, so that it can be searched in a figure.
            (unit, Some(Piece::Words(words))) => {
                words.push_str(&format!(", {unit}"));
                text
            }
            (unit, _) => text.then(Rich::foreign(&format!(", {unit}"))),
        }
    }

    /// "damping [N s/m]": for headers of CSV files.
    pub(crate) fn header(&self) -> String {
        match self.unit {
            "" => self.key.clone(),
            unit => format!("{} [{unit}]", self.key),
        }
    }

    /// "damping = 20 N s/m", of a dimensionless value.
    pub(crate) fn equals(&self, value: f64) -> Rich {
        self.extent(&[value], 4)
    }

    /// "damping from 0 to 20 N s/m", of the nodes of an axis; "damping = 20 N s/m" of one.
    pub(crate) fn extent(&self, nodes: &[f64], digits: usize) -> Rich {
        let number = |node: f64| Rich::number(node * self.factor, digits);
        let name = self.name.clone();
        let text = match nodes {
            [first, .., last] => name.then(" from ").then(number(*first)).then(" to ").then(number(*last)),
            _ => name.then(" = ").then(number(nodes[0])),
        };
        text.with_unit(self.unit)
    }
}

/// Variables that a map has for each method: the beginning of their names, what they are, and the word before
/// the method.
const OF_METHODS: [(&str, &str, &str); 5] = [
    ("verdict_", "verdict", " of "),
    ("margin_", "margin", " of "),
    (Field::CRITICAL_ERROR, "error of the critical damping", " of "),
    ("critical_c_", "critical damping", " of "),
    ("epsilon_limit_", "largest {epsilon} of agreement", ", "),
];

/// What a variable of a method is, without the method: "critical damping"; `None` for the other variables.
pub(crate) fn kind_of_variable(name: &str) -> Option<&'static str> {
    OF_METHODS.iter().find(|(prefix, ..)| name.starts_with(prefix)).map(|(_, words, _)| *words)
}

fn variable_words(name: &str) -> Rich {
    for (prefix, words, of) in OF_METHODS {
        if let Some(method) = name.strip_prefix(prefix) {
            return rich(words).then(of).then(Rich::foreign(&method.replace('_', " ")));
        }
    }
    match Quantity::by_name(name) {
        Some(quantity) => rich(quantity.about().label),
        None if name == PROBABILITY => rich("probability that it may stick-slip"),
        None => Rich::foreign(&name.replace('_', " ")),
    }
}

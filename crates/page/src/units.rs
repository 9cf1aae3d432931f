//! The units in which numbers are shown: those of a machine, or none.

use std::borrow::Cow;

pub use slipmap_figure::text::join;
use slipmap_figure::text::{Piece, Rich, rich};
use slipmap_machine::{DAMPING_RATIO, Dimension, Units};
use slipmap_map::dataset::auxiliary::{BY_ITSELF, PROBABILITY};
use slipmap_map::{Axis, Field, Grid, Quantity, Shown, dimension};

/// Dimensionless numbers, or the SI units of a machine.
#[derive(Clone, Debug, Default)]
pub struct UnitSystem {
    /// The units, if they are those of a machine.
    pub machine: Option<Units>,
    /// Whether dampings are ratios, which have no unit.
    has_ratio: bool,
    /// Units in place of those of SI.
    shown: Vec<(Dimension, Shown)>,
}

/// Name and unit of a quantity, and the factor that converts dimensionless numbers to the unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Label {
    /// The name in text and figures.
    pub name: Rich,
    /// The name in CSV headers, without the unit.
    pub key: String,
    /// The unit; empty for pure numbers.
    pub unit: Cow<'static, str>,
    /// Factor by which dimensionless numbers, or those in SI, are multiplied.
    pub factor: f64,
}

impl UnitSystem {
    pub fn of_machine(si: Units) -> Self {
        Self { machine: Some(si), ..Self::default() }
    }

    /// The same with the numbers of this machine.
    pub fn with_machine(self, machine: Option<Units>) -> Self {
        Self { machine, ..self }
    }

    /// The same with velocities and dampings in other units than those of SI.
    pub fn shown_in(self, shown: Vec<(Dimension, Shown)>) -> Self {
        Self { shown, ..self }
    }

    /// The units of the numbers of a map: those of a machine's are in SI units already.
    pub fn of_grid(grid: &Grid) -> Self {
        let machine = grid.machine().map(|machine| Units::si(machine.motion));
        let has_ratio = grid.machine().is_some_and(|of| of.damping_name() == DAMPING_RATIO);
        Self { machine, has_ratio, shown: Vec::new() }
    }

    /// The label of a quantity of this dimension; `symbol` is its name in dimensionless numbers.
    pub fn quantity(&self, words: &str, symbol: Rich, key: &str, dimension: Option<Dimension>) -> Label {
        match (&self.machine, dimension) {
            (Some(si), Some(dimension)) => {
                let shown = self.shown.iter().find(|(of, _)| *of == dimension);
                let (unit, size) = match shown {
                    Some((_, Shown { unit, size })) => (unit.clone().into(), *size),
                    None => (si.unit(dimension).into(), 1.0),
                };
                Label { name: rich(words), key: key.into(), unit, factor: si.factor(dimension) / size }
            }
            _ => Label { name: symbol, key: key.into(), unit: "".into(), factor: 1.0 },
        }
    }

    /// The name of an axis with the unit in which it is shown.
    pub fn axis(&self, axis: &Axis) -> Label {
        let name = match self.machine {
            Some(_) => Rich::foreign(&axis.long_name),
            None => Rich::symbol(&axis.name),
        };
        let (unit, factor) = match &axis.shown {
            Some(Shown { unit, size }) => (unit.clone().into(), size.recip()),
            None => (axis.unit.into(), 1.0),
        };
        Label { name, key: axis.name.clone(), unit, factor }
    }

    /// The name of a variable of a map with its unit.
    pub fn variable(&self, name: &str) -> Label {
        let words = variable_words(name);
        let is_pure = |dimension: &Dimension| self.has_ratio && *dimension == Dimension::Damping;
        let dimension = dimension::of_variable(name).filter(|dimension| !is_pure(dimension));
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
        match (&*self.unit, text.pieces.last_mut()) {
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
    pub fn header(&self) -> String {
        match &*self.unit {
            "" => self.key.clone(),
            unit => format!("{} [{unit}]", self.key),
        }
    }

    /// "damping = 20 N s/m", of a dimensionless value.
    pub fn equals(&self, value: f64) -> Rich {
        self.extent(&[value], 4)
    }

    /// "damping from 0 to 20 N s/m", of the nodes of an axis; "damping = 20 N s/m" of one.
    pub fn extent(&self, nodes: &[f64], digits: usize) -> Rich {
        let number = |node: f64| Rich::number(node * self.factor, digits);
        let name = self.name.clone();
        let text = match nodes {
            [first, .., last] => name.then(" from ").then(number(*first)).then(" to ").then(number(*last)),
            _ => name.then(" = ").then(number(nodes[0])),
        };
        text.with_unit(&self.unit)
    }
}

/// "ε = 0.1".
pub fn equals(axis: &str, value: f64) -> Rich {
    Rich::symbol(axis).then(" = ").then(Rich::number(value, 4))
}

/// Variables that a map has for each method: the beginning of their names, what they are, and the word before
/// the method.
const OF_METHODS: [(&str, &str, &str); 9] = [
    ("verdict_", "verdict", " of "),
    ("margin_", "margin", " of "),
    (Field::CRITICAL_ERROR[0], "error of the critical damping", " of "),
    (Field::CRITICAL_ERROR[1], "error of the critical damping ratio", " of "),
    (Field::CRITICAL_ERROR[2], "error of the critical damping", " of "),
    (Field::CRITICAL[0], "critical damping", " of "),
    (Field::CRITICAL[1], "critical damping ratio", " of "),
    (Field::CRITICAL[2], "critical damping", " of "),
    ("epsilon_limit_", "largest {epsilon} of agreement", ", "),
];

/// What a variable of a method is, without the method: "critical damping"; `None` for the other variables.
pub fn kind_of_variable(name: &str) -> Option<&'static str> {
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
        None if name == BY_ITSELF => rich("probability that it vibrates by itself"),
        None => Rich::foreign(&name.replace('_', " ")),
    }
}

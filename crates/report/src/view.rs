//! A map and the units in which its numbers are shown.

use std::sync::OnceLock;

use slipmap_figure::text::{Rich, join, rich};
use slipmap_format::MapFile;
use slipmap_machine::{Coefficients, Friction, Machine, Model};
use slipmap_map::Axis;
use slipmap_page::formula;
use slipmap_page::units::{Label, UnitSystem};

/// A map and the units in which its numbers are shown.
#[derive(Clone, Debug)]
pub struct View<'a> {
    pub map: &'a MapFile,
    pub units: UnitSystem,
    /// See [`View::informative_nodes`].
    pub(super) informative: OnceLock<Vec<usize>>,
}

impl<'a> View<'a> {
    /// The map in the SI units of its machine, or dimensionless if it has none.
    pub fn new(map: &'a MapFile) -> Self {
        Self { map, units: UnitSystem::of_grid(map.grid()), informative: OnceLock::new() }
    }

    /// The name of an axis with its unit.
    pub(crate) fn axis(&self, axis: &Axis) -> Label {
        self.units.axis(axis)
    }

    /// "ε = 0.1, β = 0.5": the value of every axis at the nodes `index`, except those in `shown`. For a machine
    /// also words for its friction.
    pub fn held(&self, index: &[usize], shown: &[usize]) -> Rich {
        let axes = self.map.grid().axes();
        let held = axes.iter().enumerate().filter(|(i, _)| !shown.contains(i));
        let mut parts: Vec<Rich> =
            held.map(|(i, axis)| self.axis(axis).equals(axis.values[index[i]])).collect();
        if let Some(machine) = self.map.grid().machine() {
            parts.extend(friction_words(self.map, machine));
        }
        join(parts)
    }

    /// Whether the curves of a figure of this variable are found without being asked for: those at which regimes
    /// change, where the kicks of machines end, too.
    #[must_use]
    pub fn finds_curves(variable: Option<&str>) -> bool {
        variable.is_some_and(|name| name == "regime" || name.starts_with("kick_"))
    }

    /// The units of dimensionless numbers at these nodes.
    pub(crate) fn units_at(&self, index: &[usize]) -> UnitSystem {
        let grid = self.map.grid();
        UnitSystem::of_grid(grid).with_machine(grid.si(&grid.values(index)))
    }

    /// The nodes at which the figures hold the axes, but of the damping that in the middle, the upper one of two: the first
    /// is often 0, and an undamped machine is of little interest.
    fn model_nodes(&self) -> Vec<usize> {
        let axes = self.map.grid().axes();
        let mut nodes = self.informative_nodes();
        nodes[axes.len() - 1] = axes[axes.len() - 1].values.len() / 2;
        nodes
    }

    /// The oscillator of the map's machine at the nodes of its figures; `None` for a dimensionless map.
    pub(crate) fn model(&self) -> Option<Model> {
        let grid = self.map.grid();
        let (law, point, si) = grid.place(&grid.values(&self.model_nodes()))?;
        Some(Model { law, point, si: si? })
    }

    /// What [`View::model`] holds beside belt speed and damping, where such axes vary.
    pub(crate) fn model_words(&self) -> Option<Rich> {
        let axes = self.map.grid().axes();
        let others = axes.len() - 2;
        let varies = axes[..others].iter().any(|axis| axis.values.len() > 1);
        varies.then(|| self.held(&self.model_nodes(), &[others, others + 1]))
    }
}

/// Longest formula in the heading of a figure.
const SHORT: usize = 48;

/// The description of the part of a machine's friction that does not vary.
fn friction_words(map: &MapFile, machine: &Machine) -> Vec<Rich> {
    let fixed = map.grid().fixed();
    match &machine.friction {
        Friction::Measured(table) => vec![rich("friction of ").then(Rich::foreign(table.origin()))],
        Friction::Formula(..) => match formula::of_machine(machine) {
            Some(set) if set.plain.chars().count() <= SHORT => vec![Rich::formula(set)],
            _ => vec![rich("friction by formula")],
        },
        Friction::Coefficients(..) => fixed
            .iter()
            .filter(|(name, value)| {
                Coefficients::NAMES.contains(name) && (*name != "strengthening" || *value > 0.0)
            })
            .map(|(name, value)| {
                let words = machine.words(name).replace("static friction", "friction at rest");
                let words = words.replace("kinetic friction", "kinetic");
                rich(&words).then(" ").then(Rich::number(*value, 4)).with_unit(machine.unit(name))
            })
            .collect(),
    }
}

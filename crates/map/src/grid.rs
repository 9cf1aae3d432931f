//! The grid of a map and its division into tiles.
//!
//! A grid has the axes of a friction law in dimensionless numbers, or those quantities of a machine in SI units
//! that vary. Either way a node of all axes but the damping is a [`Column`]: a law in dimensionless form, V, and
//! the factor from its dampings to those of the oscillator. All else sees columns.

mod columns;
mod tile;

pub use tile::{Tile, unravel};

use std::ops::Range;

use slipmap_machine::{BELT_SPEED as SPEED, Machine, Model, Units, requirement};
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::{Column, Law, Parameter};
use slipmap_model::point::{LawParameters, MAX_LAW_PARAMETERS, Point};
use slipmap_numbers::spacing::is_logarithmic;

/// The parameter that an axis varies. A map's dimensions are, slowest first: eps, the law's parameters in the
/// law's order, V, c; of a machine the quantities that vary, the belt speed, the damping. The damping is fastest
/// because verdicts are step functions along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisRole {
    /// eps.
    Epsilon,
    /// The parameter at this position in the law's list.
    Law(usize),
    /// Another quantity of a machine, of the axis's name.
    Quantity,
    /// The belt speed V, or a machine's.
    BeltSpeed,
    /// The damping c, or a machine's.
    Damping,
}

impl AxisRole {
    /// The value of this parameter at a point.
    ///
    /// # Panics
    /// If the point's law does not have this parameter, and for quantities of a machine.
    pub fn of(self, point: &Point) -> f64 {
        match self {
            AxisRole::Epsilon => point.epsilon,
            AxisRole::Law(position) => point.law.as_slice()[position],
            AxisRole::Quantity => unreachable!("a point has dimensionless parameters"),
            AxisRole::BeltSpeed => point.belt_speed,
            AxisRole::Damping => point.damping,
        }
    }

    /// Sets this parameter of a point.
    fn set(self, point: &mut Point, value: f64) {
        match self {
            AxisRole::Epsilon => point.epsilon = value,
            AxisRole::Law(position) => point.law.set(position, value),
            AxisRole::Quantity => unreachable!("a point has dimensionless parameters"),
            AxisRole::BeltSpeed => point.belt_speed = value,
            AxisRole::Damping => point.damping = value,
        }
    }
}

/// One axis of the grid: strictly increasing values of one parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct Axis {
    /// Name of the dimension in configurations and map files.
    pub name: String,
    /// One phrase for a figure's axis.
    pub long_name: String,
    /// Its unit in SI; empty for pure numbers.
    pub unit: &'static str,
    /// The unit in which it is shown; `None` for the SI unit.
    pub shown: Option<Shown>,
    /// The parameter that the axis varies.
    pub role: AxisRole,
    /// The nodes, finite and strictly increasing.
    pub values: Vec<f64>,
}

/// A unit in which numbers are shown.
#[derive(Clone, Debug, PartialEq)]
pub struct Shown {
    /// Its name, as the configuration has it.
    pub unit: String,
    /// Its size in SI.
    pub size: f64,
}

impl Axis {
    /// Returns whether the axis has more than two nodes, and neighbouring nodes have equal ratios.
    pub fn is_logarithmic(&self) -> bool {
        self.values.len() > 2 && is_logarithmic(&self.values)
    }

    /// The range from the first to the last node.
    pub fn extent(&self) -> Extent {
        let (from, to) = (self.values[0], self.values[self.values.len() - 1]);
        Extent { from, to, logarithmic: self.is_logarithmic() }
    }

    /// Index of the middle node; of the lower one if there are two.
    pub fn middle(&self) -> usize {
        (self.values.len() - 1) / 2
    }

    /// Index of the node nearest to a value.
    #[must_use]
    pub fn nearest(&self, value: f64) -> usize {
        let distance = |i: &usize| (self.values[*i] - value).abs();
        (0..self.values.len()).min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(0)
    }
}

/// The range of an axis, or of a part of it.
#[derive(Clone, Copy, Debug)]
pub struct Extent {
    pub(crate) from: f64,
    pub(crate) to: f64,
    pub(crate) logarithmic: bool,
}

impl Extent {
    /// The value at a share of the range, from 0 to 1: linear or, if the range is logarithmic, geometric.
    pub fn value(self, share: f64) -> f64 {
        let Self { from, to, logarithmic } = self;
        let value = if logarithmic { from * (to / from).powf(share) } else { from + (to - from) * share };
        value.clamp(from, to)
    }

    /// The inverse of [`Extent::value`], also for values beyond the ends of the range.
    pub(crate) fn share(self, value: f64) -> f64 {
        let Self { from, to, logarithmic } = self;
        if logarithmic { (value / from).ln() / (to / from).ln() } else { (value - from) / (to - from) }
    }
}

/// Reason why a grid cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GridError {
    /// The number of lists of nodes differs from the number of axes of the law.
    #[error("a grid of the law {law} has {wanted} axes, and the nodes of {given} are given")]
    AxisCount {
        /// Name of the law.
        law: &'static str,
        /// Number of axes of the law, see [`Law::axis_names`].
        wanted: usize,
        /// Number of lists of nodes that were given.
        given: usize,
    },
    /// The axis has no nodes.
    #[error("axis {axis} has no values")]
    Empty {
        /// Name of the axis.
        axis: String,
    },
    /// Nodes are not strictly increasing.
    #[error("axis {axis} must increase strictly, but {next} follows {previous}")]
    NotIncreasing {
        /// Name of the axis.
        axis: String,
        /// A value.
        previous: f64,
        /// The value after it.
        next: f64,
    },
    /// A node is NaN or infinite, or outside the parameter's legal domain.
    #[error("axis {axis} has the value {value}; it must be {domain}")]
    OutOfDomain {
        /// Name of the axis.
        axis: String,
        /// The value.
        value: f64,
        /// The domain in words.
        domain: String,
    },
    /// A machine has no such quantity.
    #[error("the machine has no quantity {0}")]
    NoQuantity(String),
    /// A machine of the grid is not one.
    #[error("at {at} {why}")]
    Machine {
        /// The values of its quantities.
        at: String,
        /// What is wrong there.
        why: String,
    },
    /// The number of cells overflows.
    #[error("the grid has more cells than can be counted")]
    TooLarge,
}

/// The axes of a law with their roles, in the order of a map's dimensions.
fn axes_of(law: &Law) -> impl Iterator<Item = (AxisRole, &Parameter)> {
    let own = (0..law.parameters().len()).map(AxisRole::Law);
    let roles = std::iter::once(AxisRole::Epsilon).chain(own).chain([AxisRole::BeltSpeed, AxisRole::Damping]);
    roles.zip(law.coordinate_parameters())
}

/// The grid of a map: a friction law and one axis for each parameter (six axes for the Stribeck law), or a
/// machine and an axis for each of its quantities that varies.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// That of a machine is in SI units.
    law: Law,
    /// The machine at the first node of every axis.
    machine: Option<Box<Machine>>,
    axes: Vec<Axis>,
    /// What is wrong with a machine at some nodes, if there are such nodes.
    gap: Option<Gap>,
}

/// Nodes at which a machine is none, because its quantities exclude each other.
#[derive(Clone, Debug, PartialEq)]
struct Gap {
    /// Where one of them is, and why.
    why: String,
    /// The column of a node without such a fault.
    legal: Box<Column>,
}

impl Grid {
    /// Builds the grid from the nodes of each axis, in the order of [`Law::axis_names`].
    ///
    /// # Errors
    /// A [`GridError`].
    pub fn new(law: Law, nodes: Vec<Vec<f64>>) -> Result<Self, GridError> {
        let (wanted, given) = (axes_of(&law).count(), nodes.len());
        if wanted != given {
            return Err(GridError::AxisCount { law: law.name(), wanted, given });
        }
        let mut axes = Vec::with_capacity(nodes.len());
        for ((role, parameter), values) in axes_of(&law).zip(nodes) {
            let &Parameter { name, long_name, .. } = parameter;
            check_nodes(name, &values, |value| (!parameter.admits(value)).then(|| parameter.domain()))?;
            axes.push(Axis {
                name: name.into(),
                long_name: long_name.into(),
                unit: "",
                shown: None,
                role,
                values,
            });
        }
        Self { law, machine: None, axes, gap: None }.counted()
    }

    /// The grid of a machine in which these quantities vary; belt speed and damping are axes in any case. The
    /// axes are in the order of [`Machine::quantities`], but the damping is the last. Nodes at which the quantities
    /// exclude each other have no column.
    ///
    /// # Errors
    /// A [`GridError`], also if no node has a column.
    pub fn of_machine(machine: &Machine, varied: &[(&str, Vec<f64>)]) -> Result<Self, GridError> {
        let quantities = machine.quantities();
        if let Some((name, _)) = varied.iter().find(|(name, _)| quantities.iter().all(|(it, _)| it != name)) {
            return Err(GridError::NoQuantity((*name).into()));
        }
        let law = machine.law();
        let is_named = |name: &str| law.parameters().iter().any(|parameter| parameter.name == name);
        let mut first = machine.clone();
        let mut axes = Vec::new();
        for (name, value) in quantities {
            let role = match name {
                SPEED => AxisRole::BeltSpeed,
                name if name == machine.damping_name() => AxisRole::Damping,
                _ => AxisRole::Quantity,
            };
            let values = match varied.iter().find(|(known, _)| *known == name) {
                Some((_, values)) => values.clone(),
                None if role == AxisRole::Quantity => continue,
                None => vec![value],
            };
            let is_of_formula = matches!(law.as_written(), Law::Expression(_)) && is_named(name);
            check_nodes(name, &values, |value| {
                let (legal, wanted) = requirement(name, value);
                (!(legal || is_of_formula)).then(|| wanted.into())
            })?;
            first.set(name, values[0]);
            let (long_name, unit) = (machine.words(name), machine.unit(name));
            axes.push(Axis { name: name.into(), long_name, unit, shown: None, role, values });
        }
        axes.sort_by_key(|axis| axis.role == AxisRole::Damping);
        let mut grid = Self { law, machine: Some(Box::new(first)), axes, gap: None }.counted()?;
        grid.gap = grid.find_gap()?;
        Ok(grid)
    }

    /// A fault at an end of any axis, or at a node of a formula's parameters. Between these the conditions on the
    /// quantities hold where they hold at the ends.
    ///
    /// # Errors
    /// There is a fault at every node.
    fn find_gap(&self) -> Result<Option<Gap>, GridError> {
        let is_formula = matches!(self.law.as_written(), Law::Expression(_));
        let of_formula =
            |axis: &Axis| is_formula && self.law.parameters().iter().any(|it| it.name == axis.name);
        let outer = &self.axes[..self.axes.len() - 1];
        let nodes: Vec<Vec<usize>> = outer
            .iter()
            .map(|axis| match axis.values.len() {
                count if of_formula(axis) => (0..count).collect(),
                1 => vec![0],
                count => vec![0, count - 1],
            })
            .collect();
        let shape: Vec<usize> = nodes.iter().map(Vec::len).collect();
        let count = shape.iter().product();
        let ends = (0..count)
            .map(|number| unravel(number, &shape).iter().zip(&nodes).map(|(&at, nodes)| nodes[at]).collect());
        let all_shape: Vec<usize> = outer.iter().map(|axis| axis.values.len()).collect();
        let (mut fault, mut legal) = (None, None);
        // The other nodes only where no end is legal.
        let all = ends.chain((0..self.column_count()).map(|number| unravel(number, &all_shape)));
        for (seen, outer) in all.enumerate() {
            if seen >= count && (fault.is_none() || legal.is_some()) {
                break;
            }
            let index: Vec<usize> = [outer, vec![0]].concat();
            match self.column(&index) {
                Ok(column) => legal = legal.or(Some(Box::new(column))),
                Err(why) => fault = fault.or(Some((index, why))),
            }
        }
        let Some((index, why)) = fault else { return Ok(None) };
        let values = self.values(&index);
        let varies = |(axis, _): &(&Axis, &f64)| axis.values.len() > 1;
        let at: Vec<String> = (self.axes.iter().zip(&values).filter(varies))
            .map(|(axis, value)| format!("{} = {value}", axis.name))
            .collect();
        let at = if at.is_empty() { "the machine's numbers".into() } else { at.join(", ") };
        let error = GridError::Machine { at, why };
        match legal {
            Some(legal) => Ok(Some(Gap { why: error.to_string(), legal })),
            None => Err(error),
        }
    }

    /// What is wrong with the machine at some nodes; `None` if every node has a column.
    pub fn gap(&self) -> Option<&str> {
        self.gap.as_ref().map(|gap| gap.why.as_str())
    }

    /// A column that the grid has: the first, if all nodes have one.
    pub fn some_column(&self) -> Column {
        match &self.gap {
            Some(gap) => Column::clone(&gap.legal),
            None => self.column(&vec![0; self.axes.len()]).unwrap_or_else(|why| unreachable!("{why}")),
        }
    }

    /// The grid, if its cells can be counted.
    fn counted(self) -> Result<Self, GridError> {
        let cells = self.shape().iter().try_fold(1usize, |n, &len| n.checked_mul(len));
        cells.map(|_| self).ok_or(GridError::TooLarge)
    }

    /// The same grid with other legal nodes, one list for each axis.
    ///
    /// # Errors
    /// A [`GridError`].
    pub fn with_nodes(&self, nodes: Vec<Vec<f64>>) -> Result<Self, GridError> {
        let Some(machine) = &self.machine else { return Self::new(self.law.clone(), nodes) };
        let names = self.axes.iter().map(|axis| axis.name.as_str());
        let same = Self::of_machine(machine, &names.zip(nodes).collect::<Vec<_>>())?;
        Ok(same.shown_in(|name| self.axes.iter().find(|axis| axis.name == name)?.shown.clone()))
    }

    /// The grid of these of the nodes of an axis, which may all be without a column.
    #[must_use]
    pub fn part(mut self, axis: usize, nodes: Range<usize>) -> Self {
        self.axes[axis].values.truncate(nodes.end);
        self.axes[axis].values.drain(..nodes.start);
        self
    }

    /// The grid with the units in which its axes are shown.
    #[must_use]
    pub fn shown_in(mut self, unit: impl Fn(&str) -> Option<Shown>) -> Self {
        self.axes.iter_mut().for_each(|axis| axis.shown = unit(&axis.name));
        self
    }

    /// The friction law; that of a machine is in SI units.
    #[must_use]
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// The machine at the first node of every axis; `None` for a grid in dimensionless numbers.
    #[must_use]
    pub fn machine(&self) -> Option<&Machine> {
        self.machine.as_deref()
    }

    /// The quantities of the machine that do not vary: those without an axis.
    pub fn fixed(&self) -> Vec<(&'static str, f64)> {
        let quantities = self.machine.iter().flat_map(|machine| machine.quantities());
        quantities.filter(|(name, _)| self.axes.iter().all(|axis| axis.name != *name)).collect()
    }

    /// Position of the axis eps; a machine has none.
    #[must_use]
    pub fn epsilon_axis(&self) -> Option<usize> {
        self.axes.iter().position(|axis| axis.role == AxisRole::Epsilon)
    }

    /// The nodes of eps; 1 alone for a machine.
    #[must_use]
    pub fn epsilons(&self) -> &[f64] {
        self.epsilon_axis().map_or(&[1.0], |axis| &self.axes[axis].values)
    }

    /// An index with another node of eps; the same index for a machine.
    #[must_use]
    pub fn at_epsilon(&self, index: &[usize], node: usize) -> Vec<usize> {
        let mut index = index.to_vec();
        if let Some(axis) = self.epsilon_axis() {
            index[axis] = node;
        }
        index
    }

    /// Whether columns that differ in eps alone, along the slowest axis, have the same law.
    pub(crate) fn shares_laws(&self) -> bool {
        self.machine.is_none() && !self.law.depends_on_epsilon()
    }

    /// The axes, slowest first; the last is the damping.
    #[must_use]
    pub fn axes(&self) -> &[Axis] {
        &self.axes
    }

    /// Number of nodes of each axis, slowest first.
    #[must_use]
    pub fn shape(&self) -> Vec<usize> {
        self.axes.iter().map(|axis| axis.values.len()).collect()
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.shape().iter().product()
    }

    /// Number of columns.
    pub fn column_count(&self) -> usize {
        self.cells() / self.dampings().len().max(1)
    }

    /// The nodes of the axis c.
    pub fn dampings(&self) -> &[f64] {
        self.axes.last().map_or(&[], |axis| &axis.values)
    }

    /// The values at the given index on each axis.
    #[must_use]
    pub fn values(&self, index: &[usize]) -> Vec<f64> {
        self.axes.iter().zip(index).map(|(axis, &i)| axis.values[i]).collect()
    }

    /// The law in dimensionless form, the point and the units at these values of the axes, which need not be
    /// nodes; units only of a machine. `None` if they are not those of a machine.
    pub fn place(&self, values: &[f64]) -> Option<(Law, Point, Option<Units>)> {
        let Some(machine) = self.machine_at(values) else {
            return Some((self.law.clone(), self.assemble(values), None));
        };
        let Model { law, point, si } = machine.model()?;
        Some((law, point, Some(si)))
    }

    /// The units of the dimensionless numbers at these values of the axes; `None` if they have none.
    pub fn si(&self, values: &[f64]) -> Option<Units> {
        self.machine_at(values).map(|machine| machine.units())
    }

    /// The point at the given index on each axis, in dimensionless numbers.
    ///
    /// # Panics
    /// If the numbers of a machine leave the range of numbers there.
    #[must_use]
    pub fn point(&self, index: &[usize]) -> Point {
        self.point_of(&self.values(index))
    }

    /// The point at these values of the axes, which need not be nodes, in dimensionless numbers.
    ///
    /// # Panics
    /// As [`Grid::point`].
    #[must_use]
    pub fn point_of(&self, values: &[f64]) -> Point {
        self.place(values).unwrap_or_else(|| panic!("the friction leaves the numbers at {values:?}")).1
    }

    /// The machine at these values of the axes.
    pub fn machine_at(&self, values: &[f64]) -> Option<Machine> {
        let mut machine = self.machine.as_deref()?.clone();
        self.axes.iter().zip(values).for_each(|(axis, &value)| {
            machine.set(&axis.name, value);
        });
        Some(machine)
    }

    fn assemble(&self, values: &[f64]) -> Point {
        let law = LawParameters::new(&[0.0; MAX_LAW_PARAMETERS][..self.axes.len() - 3]);
        let mut point = Point { epsilon: 0.0, law, belt_speed: 0.0, damping: 0.0 };
        self.axes.iter().zip(values).for_each(|(axis, &value)| axis.role.set(&mut point, value));
        point
    }

    /// The column at the given index on each axis (the last, that of the damping, is ignored).
    ///
    /// # Errors
    /// As of [`Grid::column_of`].
    pub fn column(&self, index: &[usize]) -> Result<Column, String> {
        self.column_of(&self.values(index))
    }

    /// The column at these values of the axes, which need not be nodes.
    ///
    /// # Errors
    /// Why there is none: the value that is not legal.
    pub fn column_of(&self, values: &[f64]) -> Result<Column, String> {
        if self.machine.is_some() {
            return self.machine_column(values);
        }
        let point = self.assemble(values);
        self.law.check(&point).map_err(|error| error.to_string())?;
        Ok(self.law.column(&point))
    }

    fn machine_column(&self, values: &[f64]) -> Result<Column, String> {
        let machine = self.machine_at(values).ok_or("there is no machine")?;
        if let Some((name, value, wanted)) = machine.illegal() {
            return Err(format!("{name} is {value}; it must be {wanted}"));
        }
        if !machine.friction.is_legal_at_rest() {
            return Err(format!(
                "the friction at rest is {}; it must be greater than 0",
                machine.friction.at_rest()
            ));
        }
        let model = machine.model().ok_or("the friction leaves the numbers in dimensionless terms")?;
        model.law.check(&model.point).map_err(|error| error.to_string())?;
        Ok(model.column().in_unit(machine.damping_unit()))
    }

    /// The oscillator at these values of the axes, which need not be nodes.
    ///
    /// # Errors
    /// As of [`Grid::column_of`].
    pub fn oscillator_of(&self, values: &[f64]) -> Result<Oscillator, String> {
        Ok(Oscillator::in_column(&self.column_of(values)?, values.last().copied().unwrap_or(0.0)))
    }
}

/// Refuses nodes that are not finite and strictly increasing, and those of which `wanted` tells what they must be.
fn check_nodes(name: &str, values: &[f64], wanted: impl Fn(f64) -> Option<String>) -> Result<(), GridError> {
    if values.is_empty() {
        return Err(GridError::Empty { axis: name.into() });
    }
    for &value in values {
        let domain = if value.is_finite() { wanted(value) } else { Some("finite".into()) };
        if let Some(domain) = domain {
            return Err(GridError::OutOfDomain { axis: name.into(), value, domain });
        }
    }
    match values.windows(2).find(|pair| pair[0] >= pair[1]) {
        Some(pair) => Err(GridError::NotIncreasing { axis: name.into(), previous: pair[0], next: pair[1] }),
        None => Ok(()),
    }
}

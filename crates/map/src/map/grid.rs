//! The grid of a map and its division into tiles.

use std::ops::Range;

use slipmap_model::friction::domain::{BELT_SPEED, DAMPING, EPSILON};
use slipmap_model::friction::{Column, Law, Parameter};
use slipmap_model::point::{LawParameters, MAX_LAW_PARAMETERS, Point};
use slipmap_numbers::spacing::{is_linear, is_logarithmic};

/// The parameter that an axis varies. A map's dimensions are, slowest first: eps, the law's parameters in the
/// law's order, V, c. The damping c is fastest because verdicts are step functions along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AxisRole {
    /// eps.
    Epsilon,
    /// The parameter at this position in the law's list.
    Law(usize),
    /// The belt speed V.
    BeltSpeed,
    /// The damping c.
    Damping,
}

impl AxisRole {
    /// The value of this parameter at a point.
    ///
    /// # Panics
    /// If the point's law does not have this parameter.
    pub fn of(self, point: &Point) -> f64 {
        match self {
            AxisRole::Epsilon => point.epsilon,
            AxisRole::Law(position) => point.law.as_slice()[position],
            AxisRole::BeltSpeed => point.belt_speed,
            AxisRole::Damping => point.damping,
        }
    }

    /// Sets this parameter of a point.
    ///
    /// # Panics
    /// As [`AxisRole::of`].
    pub fn set(self, point: &mut Point, value: f64) {
        match self {
            AxisRole::Epsilon => point.epsilon = value,
            AxisRole::Law(position) => point.law.set(position, value),
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
    /// The parameter that the axis varies.
    pub role: AxisRole,
    /// The nodes, finite and strictly increasing.
    pub values: Vec<f64>,
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
        /// Number of axes of the law, see [`Grid::axis_names`].
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
    /// A node is NaN or infinite.
    #[error("axis {axis} has the value {value}; values must be finite")]
    NotFinite {
        /// Name of the axis.
        axis: String,
        /// The value.
        value: f64,
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
    /// A node is outside the parameter's legal domain.
    #[error("axis {axis} has the value {value}; it must be {domain}")]
    OutOfDomain {
        /// Name of the axis.
        axis: String,
        /// The value.
        value: f64,
        /// The domain in words.
        domain: String,
    },
    /// The number of cells overflows.
    #[error("the grid has more cells than can be counted")]
    TooLarge,
}

impl GridError {
    /// For a value that is not legal: its axis, the value, and the condition that it violates; `None` for
    /// other errors.
    pub fn illegal(&self) -> Option<(&str, f64, &str)> {
        match self {
            GridError::OutOfDomain { axis, value, domain } => Some((axis, *value, domain)),
            GridError::NotFinite { axis, value } => Some((axis, *value, "finite")),
            _ => None,
        }
    }
}

/// The axes of a law with their roles, in the order of a map's dimensions.
fn axes_of(law: &Law) -> impl Iterator<Item = (AxisRole, &Parameter)> {
    let own = law.parameters().iter().enumerate().map(|(i, parameter)| (AxisRole::Law(i), parameter));
    std::iter::once((AxisRole::Epsilon, &EPSILON))
        .chain(own)
        .chain([(AxisRole::BeltSpeed, &BELT_SPEED), (AxisRole::Damping, &DAMPING)])
}

/// The grid of a map: a friction law and one axis for each parameter (six axes for the Stribeck law).
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    law: Law,
    axes: Vec<Axis>,
}

impl Grid {
    /// Names of the axes of `law`, slowest dimension first.
    #[must_use]
    pub fn axis_names(law: &Law) -> Vec<&'static str> {
        axes_of(law).map(|(_, parameter)| parameter.name).collect()
    }

    /// The name of each axis of `law` and its value at a point, in the order of [`Grid::axis_names`].
    #[must_use]
    pub fn coordinates(law: &Law, point: &Point) -> Vec<(&'static str, f64)> {
        axes_of(law).map(|(role, parameter)| (parameter.name, role.of(point))).collect()
    }

    /// Checks one value of one axis against its legal domain.
    ///
    /// # Errors
    /// [`GridError::NotFinite`] or [`GridError::OutOfDomain`].
    pub fn check_value(law: &Law, role: AxisRole, axis: &str, value: f64) -> Result<(), GridError> {
        if !value.is_finite() {
            return Err(GridError::NotFinite { axis: axis.into(), value });
        }
        let parameter = match role {
            AxisRole::Epsilon => &EPSILON,
            AxisRole::BeltSpeed => &BELT_SPEED,
            AxisRole::Damping => &DAMPING,
            AxisRole::Law(i) => &law.parameters()[i],
        };
        if parameter.admits(value) {
            return Ok(());
        }
        Err(GridError::OutOfDomain { axis: axis.into(), value, domain: parameter.domain() })
    }

    /// Builds the grid from the nodes of each axis, in the order of [`Grid::axis_names`].
    ///
    /// # Errors
    /// A [`GridError`].
    pub fn new(law: Law, nodes: Vec<Vec<f64>>) -> Result<Self, GridError> {
        let (wanted, given) = (axes_of(&law).count(), nodes.len());
        if wanted != given {
            return Err(GridError::AxisCount { law: law.name(), wanted, given });
        }
        let mut axes = Vec::with_capacity(nodes.len());
        for ((role, &Parameter { name, long_name, .. }), values) in axes_of(&law).zip(nodes) {
            if values.is_empty() {
                return Err(GridError::Empty { axis: name.into() });
            }
            for &value in &values {
                Self::check_value(&law, role, name, value)?;
            }
            if let Some(pair) = values.windows(2).find(|pair| pair[0] >= pair[1]) {
                return Err(GridError::NotIncreasing { axis: name.into(), previous: pair[0], next: pair[1] });
            }
            axes.push(Axis { name: name.into(), long_name: long_name.into(), role, values });
        }
        let grid = Self { law, axes };
        let cells = grid.shape().iter().try_fold(1usize, |n, &len| n.checked_mul(len));
        match cells {
            Some(_) => Ok(grid),
            None => Err(GridError::TooLarge),
        }
    }

    /// The friction law.
    #[must_use]
    pub fn law(&self) -> &Law {
        &self.law
    }

    /// The axes, slowest first; the last is c.
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

    /// The point at the given index on each axis.
    #[must_use]
    pub fn point(&self, index: &[usize]) -> Point {
        self.assemble(self.axes.iter().zip(index).map(|(axis, &i)| axis.values[i]))
    }

    /// The point with the given value on each axis, which need not be a node.
    pub fn point_of(&self, values: &[f64]) -> Point {
        self.assemble(values.iter().copied())
    }

    fn assemble(&self, values: impl Iterator<Item = f64>) -> Point {
        let law = LawParameters::new(&[0.0; MAX_LAW_PARAMETERS][..self.axes.len() - 3]);
        let mut point = Point { epsilon: 0.0, law, belt_speed: 0.0, damping: 0.0 };
        self.axes.iter().zip(values).for_each(|(axis, value)| axis.role.set(&mut point, value));
        point
    }

    /// The column at the given index on each axis (the last, that of c, is ignored).
    #[must_use]
    pub fn column(&self, index: &[usize]) -> Column {
        self.law.column(&self.point(index))
    }

    /// The columns of a tile, in row-major order.
    pub(crate) fn columns<'a>(&'a self, tile: &'a Tile) -> impl Iterator<Item = Column> + 'a {
        let mut index: Vec<usize> = tile.ranges.iter().map(|range| range.start).collect();
        let mut point = self.point(&index);
        (0..tile.columns()).map(move |_| {
            let column = self.law.column(&point);
            // Increments the index, beginning with the fastest axis other than c.
            let outer = self.axes.len().saturating_sub(1);
            for axis in (0..outer).rev() {
                index[axis] += 1;
                let ended = index[axis] == tile.ranges[axis].end;
                if ended {
                    index[axis] = tile.ranges[axis].start;
                }
                self.axes[axis].role.set(&mut point, self.axes[axis].values[index[axis]]);
                if !ended {
                    break;
                }
            }
            column
        })
    }

    /// The nodes of a tile along each axis other than c, as coordinates in which equal ratios are equal
    /// steps: the logarithms of nodes that have equal ratios.
    pub(crate) fn coordinates_of(&self, tile: &Tile) -> Vec<Vec<f64>> {
        let of_axis = |(axis, range): (&Axis, &Range<usize>)| {
            let values = &axis.values[range.clone()];
            let is_logarithmic = values[0] > 0.0 && !is_linear(values) && is_logarithmic(values);
            if is_logarithmic { values.iter().map(|value| value.ln()).collect() } else { values.to_vec() }
        };
        self.axes.iter().zip(&tile.ranges).take(tile.ranges.len() - 1).map(of_axis).collect()
    }

    /// Shape of a tile of at most `target_cells` cells, which contains as many whole axes as fit, the fastest
    /// first. The chunks of the map file have the same shape, so that one tile fills one chunk.
    #[must_use]
    pub fn tile_shape(&self, target_cells: usize) -> Vec<usize> {
        let mut room = target_cells.max(1);
        let mut shape: Vec<usize> = self
            .shape()
            .iter()
            .rev()
            .map(|&len| {
                let taken = len.min(room);
                room = if taken == len { room / len } else { 1 };
                taken
            })
            .collect();
        shape.reverse();
        shape
    }

    /// Shape of a tile of at most `target_cells` cells with sides as equal as possible, for interpolation
    /// along all axes. The side of eps, the slowest axis, is cut last if the law does not contain eps:
    /// columns that differ only in eps then share their cycles.
    #[must_use]
    pub(crate) fn even_tile_shape(&self, target_cells: usize) -> Vec<usize> {
        let mut shape = self.shape();
        let shared = !self.law.depends_on_epsilon();
        while shape.iter().map(|&side| side as f64).product::<f64>() > target_cells.max(1) as f64 {
            let (last, others) = shape.split_at_mut(usize::from(shared));
            let longest = others.iter_mut().max().filter(|side| **side > 1).or(last.first_mut());
            longest.into_iter().for_each(|side| *side = side.div_ceil(2));
        }
        shape
    }

    /// Number of tiles of the given shape that cover the grid.
    #[must_use]
    pub fn tile_count(&self, tile_shape: &[usize]) -> usize {
        self.shape().iter().zip(tile_shape).map(|(&len, &tile)| len.div_ceil(tile)).product()
    }

    /// The tile with a given number, 0 <= number < [`Grid::tile_count`].
    #[must_use]
    pub fn tile(&self, tile_shape: &[usize], number: usize) -> Tile {
        let shape = self.shape();
        let counts: Vec<usize> =
            shape.iter().zip(tile_shape).map(|(&len, &tile)| len.div_ceil(tile)).collect();
        let place = unravel(number, &counts);
        let ranges = shape.iter().zip(tile_shape).zip(place);
        let ranges = ranges.map(|((&len, &tile), at)| at * tile..((at + 1) * tile).min(len));
        Tile { number, ranges: ranges.collect() }
    }
}

/// The index, slowest axis first, of the element with this number in a row-major array of this shape.
pub fn unravel(number: usize, shape: &[usize]) -> Vec<usize> {
    let mut index = vec![0; shape.len()];
    let mut rest = number;
    for (at, &length) in index.iter_mut().zip(shape).rev() {
        *at = rest % length;
        rest /= length;
    }
    index
}

/// A box of cells: one range of indices per axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Tile {
    /// Its number, row-major over the grid of tiles.
    pub number: usize,
    /// Index ranges, slowest axis first; clipped to the grid.
    pub ranges: Vec<Range<usize>>,
}

impl Tile {
    /// Number of cells on each axis.
    pub(crate) fn shape(&self) -> Vec<usize> {
        self.ranges.iter().map(ExactSizeIterator::len).collect()
    }

    /// Number of cells.
    #[must_use]
    pub fn cells(&self) -> usize {
        self.ranges.iter().map(ExactSizeIterator::len).product()
    }

    /// Number of columns, whole or partial.
    pub(crate) fn columns(&self) -> usize {
        let outer = self.ranges.len() - 1;
        self.ranges[..outer].iter().map(ExactSizeIterator::len).product()
    }

    /// Positions of the columns, in an order in which columns that differ only in eps are neighbours.
    pub(crate) fn columns_by_epsilon(&self) -> impl Iterator<Item = usize> + use<> {
        // eps is the slowest axis.
        let epsilons = self.ranges[0].len();
        let others = self.columns() / epsilons.max(1);
        (0..others).flat_map(move |other| (0..epsilons).map(move |epsilon| epsilon * others + other))
    }

    pub(crate) fn damping_range(&self) -> Range<usize> {
        self.ranges.last().cloned().unwrap_or(0..0)
    }

    /// Grid index of the tile's column with position `column` (row-major), at the tile's first damping.
    pub(crate) fn column_index(&self, column: usize) -> Vec<usize> {
        let mut lengths = self.shape();
        if let Some(dampings) = lengths.last_mut() {
            *dampings = 1;
        }
        let place = unravel(column, &lengths);
        self.ranges.iter().zip(place).map(|(range, at)| range.start + at).collect()
    }

    /// Grid index of the tile's cell with position `cell` (row-major).
    pub(crate) fn cell_index(&self, cell: usize) -> Vec<usize> {
        let place = unravel(cell, &self.shape());
        self.ranges.iter().zip(place).map(|(range, at)| range.start + at).collect()
    }
}

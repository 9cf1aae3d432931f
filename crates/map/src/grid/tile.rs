//! The division of a grid into tiles.

use std::ops::Range;

use super::Grid;

impl Grid {
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
        let shared = self.shares_laws();
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
    pub(crate) fn columns_by_epsilon(&self, grid: &Grid) -> impl Iterator<Item = usize> + use<> {
        // eps is the slowest axis.
        let epsilons = grid.epsilon_axis().map_or(1, |axis| self.ranges[axis].len());
        let others = self.columns() / epsilons.max(1);
        (0..others).flat_map(move |other| (0..epsilons).map(move |epsilon| epsilon * others + other))
    }

    pub(crate) fn damping_range(&self) -> Range<usize> {
        self.ranges.last().cloned().unwrap_or(0..0)
    }

    /// Grid index of the tile's column with position `column` (row-major), at the tile's first damping.
    pub(crate) fn column_index(&self, column: usize) -> Vec<usize> {
        self.cell_index(column * self.damping_range().len())
    }

    /// Grid index of the tile's cell with position `cell` (row-major).
    pub(crate) fn cell_index(&self, cell: usize) -> Vec<usize> {
        let place = unravel(cell, &self.shape());
        self.ranges.iter().zip(place).map(|(range, at)| range.start + at).collect()
    }
}

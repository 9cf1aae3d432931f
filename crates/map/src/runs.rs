//! Run-length encoded values of cells.

use std::ops::Range;

/// The values of the cells of a tile, row-major, as runs of equal values.
///
/// A method's verdict changes a few times along a column, so a tile of many thousand cells has a few runs per
/// column, or one run in all. Neighbouring runs always differ, so equal sequences of values have equal runs.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Runs<T> {
    /// For each run its value, and the position after its last cell.
    runs: Vec<(T, u32)>,
}

impl<T> Default for Runs<T> {
    fn default() -> Self {
        Self { runs: Vec::new() }
    }
}

impl<T: Copy + PartialEq> Runs<T> {
    /// No cells.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Appends `count` cells of equal value.
    ///
    /// # Panics
    /// If there are 2^32 cells or more, which no tile has.
    pub fn push(&mut self, value: T, count: usize) {
        if count == 0 {
            return;
        }
        let Ok(end) = u32::try_from(self.len() + count) else {
            panic!("a tile of {} cells; at most {} are possible", self.len() + count, u32::MAX);
        };
        match self.runs.last_mut() {
            Some((last, last_end)) if *last == value => *last_end = end,
            _ => self.runs.push((value, end)),
        }
    }

    /// Whether there are no cells.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Number of cells.
    #[must_use]
    pub fn len(&self) -> usize {
        self.runs.last().map_or(0, |&(_, end)| end as usize)
    }

    /// The runs in order: value, and positions of its cells.
    pub fn iter(&self) -> impl Iterator<Item = (T, Range<usize>)> + '_ {
        let starts = std::iter::once(0).chain(self.runs.iter().map(|&(_, end)| end));
        self.runs.iter().zip(starts).map(|(&(value, end), start)| (value, start as usize..end as usize))
    }

    /// The runs in order: value, and position after the last cell.
    pub(super) fn as_slice(&self) -> &[(T, u32)] {
        &self.runs
    }

    /// The values cell by cell.
    pub fn values(&self) -> impl Iterator<Item = T> + '_ {
        self.iter().flat_map(|(value, cells)| std::iter::repeat_n(value, cells.len()))
    }

    /// The value of the cell at `position`; `None` beyond the last cell.
    pub(crate) fn get(&self, position: usize) -> Option<T> {
        let run = self.runs.partition_point(|&(_, end)| end as usize <= position);
        self.runs.get(run).map(|&(value, _)| value)
    }

    /// Position of the last cell of the run that contains `position`; `None` beyond the last cell.
    pub(crate) fn run_end(&self, position: usize) -> Option<usize> {
        let run = self.runs.partition_point(|&(_, end)| end as usize <= position);
        self.runs.get(run).map(|&(_, end)| end as usize - 1)
    }

    /// Number of cells for which `wanted` holds.
    pub fn count(&self, wanted: impl Fn(T) -> bool) -> u64 {
        self.iter().filter(|(value, _)| wanted(*value)).map(|(_, cells)| cells.len() as u64).sum()
    }

    /// Applies `to` to each value.
    #[must_use]
    pub fn map<U: Copy + PartialEq>(&self, to: impl Fn(T) -> U) -> Runs<U> {
        let mut mapped = Runs { runs: Vec::with_capacity(self.runs.len()) };
        self.iter().for_each(|(value, cells)| mapped.push(to(value), cells.len()));
        mapped
    }
}

impl<T: Copy + PartialEq> Extend<T> for Runs<T> {
    fn extend<I: IntoIterator<Item = T>>(&mut self, values: I) {
        values.into_iter().for_each(|value| self.push(value, 1));
    }
}

impl<T: Copy + PartialEq> FromIterator<T> for Runs<T> {
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        let mut runs = Self::new();
        runs.extend(values);
        runs
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_hold_the_values_they_were_made_of() {
        let values = [1, 1, 2, 3, 3, 3, 1];
        let runs: Runs<i8> = values.into_iter().collect();
        assert_eq!(runs.values().collect::<Vec<_>>(), values);
        assert_eq!(runs.iter().collect::<Vec<_>>(), [(1, 0..2), (2, 2..3), (3, 3..6), (1, 6..7)]);
        assert_eq!((runs.len(), runs.count(|value| value == 1)), (7, 3));
        for (position, &value) in values.iter().enumerate() {
            assert_eq!(runs.get(position), Some(value));
        }
        assert_eq!((runs.get(7), runs.run_end(3), runs.run_end(7)), (None, Some(5), None));
    }

    #[test]
    fn equal_values_make_equal_runs() {
        let mut pieces = Runs::new();
        for (value, count) in [(1, 2), (1, 0), (1, 1), (2, 3), (2, 2)] {
            pieces.push(value, count);
        }
        assert_eq!(pieces, [1, 1, 1, 2, 2, 2, 2, 2].into_iter().collect());
        assert_eq!(pieces.map(|_| 0), Runs::from_iter([0; 8]));
    }
}

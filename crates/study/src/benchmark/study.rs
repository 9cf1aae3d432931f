//! A study of speed against accuracy: every method and engine measured on the same cells at each of its
//! settings.

use slipmap_config::StudySettings;

use super::{Cell, Contestant, Row, cells, measure, pareto};
use slipmap_map::Grid;

/// Reason why there is no study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// There is no reference to compare with.
    #[error(
        "there is no reference to measure against: the law `{law}` has none, or every cell of the box lies outside its \
         domain; the laws `stribeck`, `exponential` and `coulomb` have one where friction does not fall too steeply"
    )]
    NoReference {
        /// The friction law.
        law: &'static str,
    },
    /// The caller interrupted the study.
    #[error("interrupted")]
    Interrupted,
}

/// A finished study.
#[derive(Clone, Debug)]
pub struct Study {
    pub settings: StudySettings,
    /// The grid whose box the cells are drawn from.
    pub grid: Grid,
    /// The cells.
    pub cells: Vec<Cell>,
    /// The measurements, methods in their order, each from coarse to fine.
    pub rows: Vec<Row>,
}

/// Errors below this count as none: a double next to 1 has an error of 1e-16, but errors of small margins are
/// smaller.
const NO_ERROR: f64 = 1e-18;

impl Study {
    /// Draws the cells and measures `contestants` on them. `on_row` is called before each with its number.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn run(
        grid: &Grid,
        settings: StudySettings,
        contestants: &[Contestant],
        on_row: &dyn Fn(usize),
        go_on: &dyn Fn() -> bool,
    ) -> Result<Self, StudyError> {
        let cells = cells::draw(grid, settings.cells, settings.near);
        if cells.is_empty() {
            return Err(StudyError::NoReference { law: grid.law().name() });
        }
        let mut rows = Vec::with_capacity(contestants.len());
        for (number, contestant) in contestants.iter().enumerate() {
            if !go_on() {
                return Err(StudyError::Interrupted);
            }
            on_row(number);
            rows.push(measure(contestant, &cells, settings.seconds));
        }
        let mut study = Self { settings, grid: grid.clone(), cells, rows };
        study.mark_fronts();
        Ok(study)
    }

    /// Computes the Pareto fronts again.
    pub fn mark_fronts(&mut self) {
        let worst = |row: &Row| row.margin.map(|errors| (row.seconds, errors.worst.max(NO_ERROR)));
        let missed = |row: &Row| row.near.and_then(|labels| Some((row.seconds, labels.missed()?)));
        let by_error = pareto(&self.rows.iter().map(worst).collect::<Vec<_>>());
        let by_labels = pareto(&self.rows.iter().map(missed).collect::<Vec<_>>());
        for (row, (error, labels)) in self.rows.iter_mut().zip(by_error.into_iter().zip(by_labels)) {
            (row.front_error, row.front_labels) = (error, labels);
        }
    }

    /// The cells as a table for `scripts/study peers`, with the reference margin.
    #[must_use]
    pub fn cells_csv(&self) -> String {
        let axes = self.grid.axes();
        let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).chain(["near", "margin"]).collect();
        let mut text = names.join(",") + "\n";
        for cell in &self.cells {
            for axis in axes {
                text.push_str(&format!("{:?},", axis.role.of(&cell.point)));
            }
            let margin = cell.reference.margin.map_or(f64::NAN, |margin| margin.value.value());
            text.push_str(&format!("{},{margin:?}\n", u8::from(cell.near)));
        }
        text
    }
}

//! A study of speed against accuracy: the cells, and every method and engine measured on them at each of its
//! settings.

use super::{Cell, Contestant, Errors, Kind, Labels, Measurement, cells, measure, pareto};
use crate::map::Grid;

/// Why there is no study.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum StudyError {
    /// Work and precision can only be compared where there is a reference.
    #[error(
        "there is no reference to measure against: the law `{law}` has none, or every cell of the box lies outside its \
         domain; the law `stribeck` at moderate epsilon has one"
    )]
    NoReference {
        /// The friction law.
        law: &'static str,
    },
    /// The caller asked for an end.
    #[error("interrupted")]
    Interrupted,
}

/// What a study is to do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Number of cells, half of them next to the boundary as far as there is one.
    pub cells: usize,
    /// Largest distance in c from the boundary of the cells next to it.
    pub near: f64,
    /// Seconds of processor time that slow methods may take at each setting.
    pub seconds: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { cells: 1024, near: 0.01, seconds: 1.0 }
    }
}

/// Somebody at one setting, and what was measured.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// What it is.
    pub kind: Kind,
    /// Its name.
    pub name: String,
    /// Its knob and where that stands.
    pub setting: Option<(String, f64)>,
    /// Cells that it was asked about.
    pub cells: usize,
    /// Processor time per cell in seconds.
    pub seconds: f64,
    /// Sizes of the error of the scaled margin.
    pub margin: Option<Errors>,
    /// Sizes of the error of the critical damping.
    pub critical: Option<Errors>,
    /// Cells without an answer.
    pub unanswered: usize,
    /// Labels next to the boundary; `None` if it was not asked about such cells.
    pub near: Option<Labels>,
    /// Labels anywhere.
    pub anywhere: Option<Labels>,
    /// Whether it is on the Pareto front of time and largest error.
    pub front_error: bool,
    /// Whether it is on the Pareto front of time and share of cells not labelled right.
    pub front_labels: bool,
}

/// A finished study.
#[derive(Clone, Debug)]
pub struct Study {
    /// What was asked for.
    pub settings: Settings,
    /// The box.
    pub grid: Grid,
    /// The cells.
    pub cells: Vec<Cell>,
    /// The measurements, methods in their order, each from coarse to fine.
    pub rows: Vec<Row>,
    /// Where the peers' rows come from, and whether they are about the same cells.
    pub peers: Option<(String, bool)>,
}

/// The smallest error that is told apart from none: what a double next to 1 can differ by is 1e-16; errors of
/// small margins are smaller.
const NO_ERROR: f64 = 1e-18;

impl Study {
    /// Draws the cells and measures `who` on them. `on_row` is called before each with its number and name.
    ///
    /// # Errors
    /// [`StudyError`].
    pub fn run(
        grid: &Grid,
        settings: Settings,
        who: &[Contestant],
        on_row: &dyn Fn(usize, &str),
        go_on: &dyn Fn() -> bool,
    ) -> Result<Self, StudyError> {
        let cells = cells::draw(grid, settings.cells, settings.near);
        if cells.is_empty() {
            return Err(StudyError::NoReference { law: grid.law().name() });
        }
        let mut rows = Vec::with_capacity(who.len());
        for (number, contestant) in who.iter().enumerate() {
            if !go_on() {
                return Err(StudyError::Interrupted);
            }
            on_row(number, contestant.name);
            let Measurement { cells, seconds, margin, critical, unanswered, near, anywhere } =
                measure(contestant, &cells, settings.seconds);
            rows.push(Row {
                kind: contestant.kind,
                name: contestant.name.into(),
                setting: contestant.knob.map(|knob| (knob.into(), contestant.setting)),
                cells,
                seconds,
                margin,
                critical,
                unanswered,
                near: Some(near),
                anywhere: Some(anywhere),
                front_error: false,
                front_labels: false,
            });
        }
        let mut study = Self { settings, grid: grid.clone(), cells, rows, peers: None };
        study.mark_fronts();
        Ok(study)
    }

    /// Finds anew who is on the fronts.
    pub(crate) fn mark_fronts(&mut self) {
        let worst = |row: &Row| row.margin.map(|errors| (row.seconds, errors.worst.max(NO_ERROR)));
        let missed = |row: &Row| row.near.and_then(|labels| Some((row.seconds, labels.missed()?)));
        let by_error = pareto(&self.rows.iter().map(worst).collect::<Vec<_>>());
        let by_labels = pareto(&self.rows.iter().map(missed).collect::<Vec<_>>());
        for (row, (error, labels)) in self.rows.iter_mut().zip(by_error.into_iter().zip(by_labels)) {
            (row.front_error, row.front_labels) = (error, labels);
        }
    }

    /// The cells as a table for `scripts/peers`.
    #[must_use]
    pub fn cells_csv(&self) -> String {
        let axes = self.grid.axes();
        let names: Vec<&str> = axes.iter().map(|axis| axis.name.as_str()).chain(["near"]).collect();
        let mut text = names.join(",") + "\n";
        for cell in &self.cells {
            for axis in axes {
                text.push_str(&format!("{:?},", axis.role.of(&cell.point)));
            }
            text.push_str(if cell.near { "1\n" } else { "0\n" });
        }
        text
    }
}

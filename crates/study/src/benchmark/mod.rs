//! Speed against accuracy: every method and engine at several settings, on the same cells, against a
//! reference of some 25 digits. The data of the work-precision chart.
//!
//! * Cells, `cells::draw`: half anywhere in the box of the configuration's grid, half within a stated
//!   distance in c of the boundary.
//! * Reference, [`reference::reference`]: margin and critical damping in double-double arithmetic.
//! * Time: processor time of one thread from the cell's friction curve to its answer; unlike in maps, nothing
//!   is shared between the cells of a column.
//! * Error: that of the scaled grazing margin m/V where a method gives one; else that of the critical
//!   damping, times |dm/dc|/V at the boundary: the error of the margin of the orbit that the method takes for
//!   the grazing one.
//! * Labels: verdicts on the cells near the boundary: right, wrong, or none.

pub(crate) mod cells;
mod contestants;
pub mod double_double;
mod measure;
pub mod reference;
pub(crate) mod study;

pub use cells::Cell;
pub use contestants::{Contestant, ContestantKind, contestants};
pub(crate) use measure::measure;
pub use measure::{Errors, Labels, Row};
pub use study::Study;
pub use study::StudyError;

/// Marks the points of the Pareto front: those that no different point equals or undercuts in both time and
/// error. `None` is never on the front.
pub(crate) fn pareto(points: &[Option<(f64, f64)>]) -> Vec<bool> {
    let beats = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && a != b;
    points
        .iter()
        .map(|point| point.is_some_and(|point| !points.iter().flatten().any(|other| beats(*other, point))))
        .collect()
}

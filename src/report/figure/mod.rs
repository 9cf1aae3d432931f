//! Figures, one file each. Every figure is a function from data to a [`Scene`].

pub mod axis;
pub mod bifurcations;
pub mod bistable;
pub mod critical;
mod curves;
pub mod deciders;
pub mod errors;
pub mod exact;
pub mod legend;
pub mod palette;
pub mod paper;
pub mod plot;
pub mod portrait;
pub mod region;
pub mod render;
pub mod scene;
pub mod slice;
pub mod slices;
pub mod work_precision;

pub use bifurcations::PlaneCurves;
pub use plot::{Plot, plot};
pub use portrait::portrait;
pub use scene::{Scene, Width};
pub use slice::{ChoiceError, Held, Slice};

use super::text::Rich;
use super::{Report, ReportError};
use crate::store::MapFile;

/// A finished figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of its files.
    pub name: String,
    /// What it shows.
    pub caption: Rich,
    /// The figure at each width.
    pub scenes: Vec<(Width, Scene)>,
}

/// All figures of a report, in its order.
///
/// # Errors
/// [`ReportError::Map`] if the map cannot be read.
pub fn all(map: &MapFile, report: &Report) -> Result<Vec<Figure>, ReportError> {
    let mut figures = slices::slices(map)?;
    figures.push(deciders::deciders(map, report)?);
    figures.push(critical::critical(map));
    figures.extend(errors::errors(map, report));
    figures.push(bistable::bistable(map));
    figures.extend(portrait::portraits(map));
    figures.extend(paper::figures());
    Ok(figures)
}

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
pub mod planes;
pub mod plot;
pub mod portrait;
pub mod region;
pub mod render;
pub mod scene;
pub mod slice;
pub mod slices;
pub mod work_precision;

pub use plot::{Plot, plot};
pub use portrait::portrait;
pub use scene::{Scene, Width};
pub use slice::{ChoiceError, Held, Slice};

use rayon::prelude::*;

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

/// All figures of a report, in its order, made by all cores.
///
/// # Errors
/// [`ReportError::Map`] if the map cannot be read.
pub fn all(map: &MapFile, report: &Report) -> Result<Vec<Figure>, ReportError> {
    type Maker<'a> = &'a (dyn Fn() -> Result<Vec<Figure>, ReportError> + Sync);
    let makers: [Maker; 8] = [
        &|| slices::slices(map),
        &|| planes::planes(map),
        &|| Ok(vec![deciders::deciders(map, report)?]),
        &|| Ok(vec![critical::critical(map)]),
        &|| Ok(errors::errors(map, report).into_iter().collect()),
        &|| Ok(vec![bistable::bistable(map)]),
        &|| Ok(portrait::portraits(map).into_iter().collect()),
        &|| Ok(paper::figures()),
    ];
    let figures: Vec<Vec<Figure>> = makers.into_par_iter().map(|make| make()).collect::<Result<_, _>>()?;
    Ok(figures.into_iter().flatten().collect())
}

//! Figures, one file each: every figure is a function from data to a [`Scene`].

pub mod area;
pub mod axis;
pub mod bifurcations;
pub mod bistable;
pub mod critical;
pub mod curve_planes;
mod curves;
pub mod data;
pub mod deciders;
pub mod diagram;
pub mod errors;
pub mod exact;
pub mod legend;
pub mod lines;
pub mod orbit;
pub mod palette;
pub mod paper;
pub mod plot;
pub mod portrait;
pub mod portraits;
pub mod region;
pub mod render;
pub mod scene;
pub mod slice;
pub mod strips;
pub mod verdict_panels;
pub mod work_precision;

pub use data::Data;
pub use diagram::{DiagramPlot, diagram};
pub use orbit::{OrbitFigure, OrbitPlot, orbit_figure};
pub use plot::{Plot, plot};
pub use scene::{Scene, Width};
pub use slice::{ChoiceError, Held, Slice};

use rayon::prelude::*;

use super::text::Rich;
use super::units::View;
use super::{Report, ReportError};

/// A finished figure.
#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of its files.
    pub name: String,
    /// Its caption.
    pub caption: Rich,
    /// The figure at each width.
    pub scenes: Vec<(Width, Scene)>,
    /// Its numbers.
    pub data: Data,
}

/// All figures of a report in its order, drawn by all cores.
///
/// # Errors
/// [`ReportError::Map`] if the map cannot be read.
pub fn all(view: &View, report: &Report) -> Result<Vec<Figure>, ReportError> {
    type Maker<'a> = &'a (dyn Fn() -> Result<Vec<Figure>, ReportError> + Sync);
    let makers: [Maker; 7] = [
        &|| curve_planes::curve_planes(view),
        &|| verdict_panels::verdict_panels(view),
        &|| Ok(deciders::deciders(view, report)?.into_iter().collect()),
        &|| Ok(vec![critical::critical(view)]),
        &|| Ok(errors::errors(view, report).into_iter().collect()),
        &|| Ok(vec![bistable::bistable(view)]),
        &|| Ok(portraits::portraits(view).into_iter().collect()),
    ];
    let figures: Vec<Vec<Figure>> = makers.into_par_iter().map(|make| make()).collect::<Result<_, _>>()?;
    Ok(figures.into_iter().flatten().collect())
}

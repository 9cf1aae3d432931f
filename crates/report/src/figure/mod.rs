//! Figures, one file each: every figure is a function from data to a `Scene`.

pub(crate) mod area;
pub mod bifurcations;
pub(crate) mod critical;
pub(crate) mod curve_planes;
mod curves;
pub(crate) mod deciders;
pub mod diagram;
pub(crate) mod errors;
pub mod plot;
pub(crate) mod portraits;
pub(crate) mod slice;
pub(crate) mod verdict_panels;
pub mod work_precision;

pub use area::Marks;
pub use diagram::{DiagramPlot, diagram};
pub use plot::{Plot, plot};
pub use slice::ChoiceError;
pub(super) use slice::{nearest_node, picks};
pub use slipmap_figure::data::Data;
pub use slipmap_figure::scene::{Scene, Width};

use rayon::prelude::*;

use super::view::View;
use super::{Report, ReportError};
use slipmap_figure::text::Rich;

#[derive(Clone, Debug)]
pub struct Figure {
    /// Name of its files.
    pub name: String,
    pub caption: Rich,
    pub scene: Scene,
    pub(crate) data: Data,
}

/// All figures of a report in its order, drawn by all cores.
///
/// # Errors
/// [`ReportError::Map`] if the map cannot be read.
pub fn all(view: &View, report: &Report, width: Width) -> Result<Vec<Figure>, ReportError> {
    type Maker<'a> = &'a (dyn Fn() -> Result<Vec<Figure>, ReportError> + Sync);
    let makers: [Maker; 8] = [
        &|| Ok(plot::probability(view, width)?.into_iter().collect()),
        &|| curve_planes::curve_planes(view, width),
        &|| Ok(plot::regimes(view, width)?.into_iter().collect()),
        &|| verdict_panels::verdict_panels(view, width),
        &|| Ok(deciders::deciders(view, report, width)?.into_iter().collect()),
        &|| Ok(critical::critical(view, width).into_iter().collect()),
        &|| Ok(errors::errors(view, report, width).into_iter().collect()),
        &|| Ok(portraits::portraits(view, width).into_iter().collect()),
    ];
    // Several figures need these nodes; computed here, no figure waits for another.
    view.informative_nodes();
    let figures: Vec<Vec<Figure>> = makers.into_par_iter().map(|make| make()).collect::<Result<_, _>>()?;
    Ok(figures.into_iter().flatten().collect())
}

//! The planes whose curves of codimension one a map stores, each with its curves over the long-run behaviour.

use super::super::ReportError;
use super::super::text::Rich;
use super::Figure;
use super::plot::{Plot, plot};
use super::scene::Width;
use crate::store::MapFile;

/// One figure for each plane.
///
/// # Errors
/// [`ReportError::Map`] if the map cannot be read.
pub fn planes(map: &MapFile) -> Result<Vec<Figure>, ReportError> {
    let axes = map.grid().axes();
    let mut figures: Vec<Figure> = Vec::new();
    for curves in map.curves() {
        let plane = &curves.plane;
        let held = axes.iter().zip(&plane.held).enumerate();
        let at: Vec<(String, f64)> = held
            .filter(|(axis, _)| *axis != plane.x && *axis != plane.y)
            .map(|(_, (axis, &node))| (axis.name.clone(), axis.values[node]))
            .collect();
        let (x, y) = (&axes[plane.x].name, &axes[plane.y].name);
        let (mut scenes, mut caption) = (Vec::new(), Rich::default());
        for width in Width::ALL {
            let variable = map.has("regime").then_some("regime");
            let plotted = plot(map, &Plot { x, y, at: &at, variable, curves: false, width })?;
            caption = plotted.caption;
            scenes.push((width, plotted.scene));
        }
        let name = format!("curves-{x}-{y}");
        // Several planes may differ in where they hold the other axes alone.
        let others = figures.iter().filter(|figure| figure.name.starts_with(&name)).count();
        let name = if others == 0 { name } else { format!("{name}-{}", others + 1) };
        figures.push(Figure { name, caption, scenes });
    }
    Ok(figures)
}

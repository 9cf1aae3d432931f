//! The planes whose curves of codimension one a map stores, each with its curves over the long-run behaviour.

use super::super::ReportError;
use super::super::view::View;
use super::{Figure, bifurcations, plot};
use slipmap_figure::scene::Width;

pub(crate) fn curve_planes(view: &View, width: Width) -> Result<Vec<Figure>, ReportError> {
    let map = view.map;
    let axes = map.grid().axes();
    let mut figures: Vec<Figure> = Vec::new();
    for curves in map.curves() {
        let plane = &curves.plane;
        let name = format!("curves-{}-{}", axes[plane.x].name, axes[plane.y].name);
        // Several planes may differ only in the values of the fixed axes.
        let others = figures.iter().filter(|figure| figure.name.starts_with(&name)).count();
        let name = if others == 0 { name } else { format!("{name}-{}", others + 1) };
        let regime = map.has("regime").then_some("regime");
        let figure = plot::over_nodes(view, name, regime, [plane.x, plane.y], &plane.held, width)?;
        figures.push(Figure { data: bifurcations::data(view, curves), ..figure });
    }
    Ok(figures)
}

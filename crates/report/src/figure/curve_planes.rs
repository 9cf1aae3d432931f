//! The planes whose curves of codimension one a map stores, each with its curves over the long-run behaviour.

use super::super::ReportError;
use super::super::units::View;
use super::Figure;
use super::bifurcations;
use super::plot::{self, At, Plot};
use slipmap_figure::scene::Width;

pub(crate) fn curve_planes(view: &View, width: Width) -> Result<Vec<Figure>, ReportError> {
    let map = view.map;
    let axes = map.grid().axes();
    let mut figures: Vec<Figure> = Vec::new();
    for curves in map.curves() {
        let plane = &curves.plane;
        let held = axes.iter().zip(&plane.held).enumerate();
        let at: Vec<At> = held
            .filter(|(axis, _)| *axis != plane.x && *axis != plane.y)
            .map(|(_, (axis, &node))| (axis.name.clone(), vec![axis.values[node] * view.axis(axis).factor]))
            .collect();
        let (x, y) = (&axes[plane.x].name, &axes[plane.y].name);
        let variables: Vec<String> = map.has("regime").then(|| "regime".to_owned()).into_iter().collect();
        let variables = &variables[..];
        let wanted =
            Plot { x, y: Some(y), at: &at, variables, panels: None, curves: false, marks: None, width };
        let name = format!("curves-{x}-{y}");
        // Several planes may differ only in the values of the fixed axes.
        let others = figures.iter().filter(|figure| figure.name.starts_with(&name)).count();
        let name = if others == 0 { name } else { format!("{name}-{}", others + 1) };
        let data = bifurcations::data(view, curves);
        figures.push(Figure { data, ..plot::figure(view, name, &wanted)? });
    }
    Ok(figures)
}

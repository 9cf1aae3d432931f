//! Curves of codimension one in the plane of a slice: as a table, and drawn.

use std::fmt::Write as _;

use super::super::text::rich;
use super::axis::Panel;
use super::legend::{Legend, Sample};
use super::palette;
use super::scene::{Place, Scene, Stroke};
use super::slices::{EXACT, HALO};
use crate::map::{Axis, PlaneCurves};
use crate::simulate::bifurcation::Bifurcation;

/// All points as a table: the curve, the number of its branch from 1, the values of both axes, and the error,
/// a distance in sides of the plotted rectangle.
#[must_use]
pub fn csv(axes: &[Axis], curves: &PlaneCurves) -> String {
    let [x, y] = [curves.plane.x, curves.plane.y].map(|axis| &axes[axis].name);
    let mut text = format!("curve,branch,{x},{y},error\n");
    for (number, curve) in curves.numbered() {
        let name = curve.bifurcation.name();
        for point in &curve.points {
            // Writing to a string does not fail.
            let _ = writeln!(text, "{name},{number},{:?},{:?},{:e}", point.x, point.y, point.error);
        }
    }
    text
}

/// Draws curves into the panel of their plane.
pub(super) fn draw(scene: &mut Scene, panel: &Panel, curves: &PlaneCurves, legend: &mut Legend) {
    for bifurcation in Bifurcation::ALL {
        let stroke = style(bifurcation);
        let of_kind = || curves.curves.iter().filter(|curve| curve.bifurcation == bifurcation);
        if of_kind().next().is_none() {
            continue;
        }
        scene.clipped(panel.rect, |scene| {
            for curve in of_kind() {
                let places: Vec<Place> =
                    curve.points.iter().map(|point| panel.place(point.x, point.y)).collect();
                scene.line(&places, &HALO);
                scene.line(&places, &stroke);
            }
        });
        legend.add(Sample::Line(stroke), rich(words(bifurcation)));
    }
}

/// Lines that differ in their dashes; colours must show on every area.
fn style(bifurcation: Bifurcation) -> Stroke {
    match bifurcation {
        Bifurcation::Hopf => Stroke { color: palette::BLACK, width: 1.0, dash: &[5.0, 2.0] },
        Bifurcation::GrazingSliding => EXACT,
        Bifurcation::Landing => Stroke { color: palette::VERMILION, width: 1.2, dash: &[1.4, 1.4] },
        Bifurcation::Crossing => Stroke { color: palette::BLUE, width: 1.2, dash: &[3.0, 1.4] },
        Bifurcation::Fold => Stroke { color: palette::PURPLE, width: 1.2, dash: &[6.0, 1.6, 1.2, 1.6] },
    }
}

fn words(bifurcation: Bifurcation) -> &'static str {
    match bifurcation {
        Bifurcation::Hopf => "Hopf",
        Bifurcation::GrazingSliding => "grazing",
        Bifurcation::Landing => "landing",
        Bifurcation::Crossing => "crossing",
        Bifurcation::Fold => "fold",
    }
}

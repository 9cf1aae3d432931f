//! Curves of codimension one, drawn.

use slipmap_column::bifurcation::Bifurcation;
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::Panel;
use slipmap_figure::scene::{Marker, Place, Rect, Scene, Stroke};
use slipmap_figure::style;
use slipmap_figure::text::rich;
use slipmap_map::{PlaneCurve, PlaneCurves};

/// The exact boundary, and the halo that it has.
pub const EXACT: Stroke = Stroke::solid(style::BLACK, 1.0);
pub const HALO: Stroke = Stroke::solid(style::WHITE, 1.8);

/// The places of curves in a panel of their plane.
pub fn places(curves: &PlaneCurves, panel: &Panel) -> Vec<Vec<Place>> {
    let line = |curve: &PlaneCurve| curve.points.iter().map(|p| panel.place(p.x, p.y)).collect();
    curves.curves.iter().map(line).collect()
}

/// The drawing order: a fold on a Hopf curve shows in the gaps between the dashes of the Hopf curve.
const ORDER: [Bifurcation; 5] = [
    Bifurcation::Fold,
    Bifurcation::GrazingSliding,
    Bifurcation::Landing,
    Bifurcation::Crossing,
    Bifurcation::Hopf,
];

/// Draws curves into the panel of their plane. The legend names the visible ones. `over_numbers`: over colours, where
/// black curves have halos too; over regimes they are visible without, and a halo would hide a thin strip between two.
pub fn draw(scene: &mut Scene, panel: &Panel, curves: &PlaneCurves, legend: &mut Legend, over_numbers: bool) {
    let places = |bifurcation: Bifurcation| {
        let of_kind = curves.curves.iter().filter(move |curve| curve.bifurcation == bifurcation);
        of_kind.map(|curve| curve.points.iter().map(|p| panel.place(p.x, p.y)).collect::<Vec<Place>>())
    };
    scene.clipped(panel.rect, |scene| {
        // The white halos of all curves come first, so that no halo covers a curve.
        let has_halo = |kind: &&Bifurcation| over_numbers || line_style(**kind).0.color != style::BLACK;
        for bifurcation in ORDER.iter().filter(has_halo) {
            places(*bifurcation).for_each(|line| scene.line(&line, &HALO));
        }
        for bifurcation in ORDER {
            places(bifurcation).for_each(|line| scene.line(&line, &line_style(bifurcation).0));
        }
    });
    for point in curves.curves.iter().filter(|curve| curve.bifurcation.along().is_some()) {
        let (marker, words) = mark(point.bifurcation);
        for at in point.points.iter().map(|p| panel.place(p.x, p.y)) {
            scene.marker(marker, at, MARK, style::BLACK, false);
        }
        legend.add(Sample::Mark(marker, style::BLACK, false), rich(words));
    }
    // A curve along the frame cannot be seen.
    let Rect { x, y, w, h } = panel.rect;
    let inner = Rect { x: x + 0.5, y: y + 0.5, w: w - 1.0, h: h - 1.0 };
    for bifurcation in ORDER {
        if places(bifurcation).any(|line| line.iter().filter(|p| inner.contains(**p)).count() > 1) {
            let (stroke, words) = line_style(bifurcation);
            legend.add(Sample::Line(stroke), rich(words));
        }
    }
}

/// Size of the mark of a point of codimension two.
const MARK: f64 = 5.0;

/// The mark and the legend text of a bifurcation of codimension two.
fn mark(bifurcation: Bifurcation) -> (Marker, &'static str) {
    match bifurcation {
        Bifurcation::Bautin => (Marker::Circle, "Bautin point"),
        Bifurcation::HopfAtGrazing => (Marker::Diamond, "Hopf at grazing"),
        Bifurcation::FoldAtGrazing => (Marker::Triangle, "fold at grazing"),
        _ => (Marker::Square, "cusp of folds"),
    }
}

/// Line style and legend text of the curve of a bifurcation. Lines differ in their dashes, in colours visible
/// on every area.
pub fn line_style(bifurcation: Bifurcation) -> (Stroke, &'static str) {
    match bifurcation {
        Bifurcation::Hopf => (Stroke { color: style::BLACK, width: 1.0, dash: &[5.0, 2.0] }, "Hopf curve"),
        Bifurcation::GrazingSliding => (EXACT, "grazing curve"),
        Bifurcation::Landing => {
            (Stroke { color: style::VERMILION, width: 1.2, dash: &[1.4, 1.4] }, "landing curve")
        }
        Bifurcation::Crossing => {
            (Stroke { color: style::BLUE, width: 1.2, dash: &[3.0, 1.4] }, "crossing curve")
        }
        Bifurcation::Fold => (Stroke::solid(style::WINE, 1.2), "fold curve"),
        point => (EXACT, mark(point).1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_figure::axis::Scale;
    use slipmap_map::{Plane, PlanePoint};

    #[test]
    fn no_halo_of_a_black_curve_hides_a_strip_of_regimes() {
        let rect = Rect { x: 0.0, y: 0.0, w: 100.0, h: 100.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 1.0), y: Scale::linear(0.0, 1.0) };
        let halos = |bifurcation: Bifurcation, over_numbers: bool| {
            let points = [0.1, 0.9].map(|x| PlanePoint { x, y: x, error: 0.0 }).into();
            let plane = Plane::new(0, 1, vec![0, 0]);
            let curves =
                PlaneCurves { plane, curves: vec![PlaneCurve { bifurcation, points }], cut: Vec::new() };
            let (mut scene, mut legend) = (Scene::new(100.0, 100.0), Legend::default());
            draw(&mut scene, &panel, &curves, &mut legend, over_numbers);
            scene.svg("curves", &rich("curves")).matches(&format!("stroke=\"{}\"", style::WHITE)).count()
        };
        assert_eq!([false, true].map(|numbers| halos(Bifurcation::Hopf, numbers)), [0, 1]);
        assert_eq!(halos(Bifurcation::Crossing, false), 1);
    }
}

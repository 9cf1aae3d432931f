//! Line plots: curves over one axis, those of the same unit in one panel.

use super::axis::{Scale, TEXT, extremes};
use super::legend::{Legend, Sample};
use super::panels::{Labels, Panel, Panels, TITLE_MARGIN};
use super::scene::{Place, Scene, Width, text_width};
use super::style::LineStyle;
use super::text::{Rich, rich};

/// Number of points of a curve above which only some of them have marks, and the number of these.
const MARKED: usize = 30;
const MARKS: usize = 6;

#[derive(Clone, Debug)]
pub struct Curve {
    /// Its name in the legend; empty for none.
    pub name: Rich,
    pub style: LineStyle,
    /// Its points; one that is not finite interrupts it.
    pub points: Vec<Place>,
    pub marks: bool,
}

/// Curves that share a vertical axis.
#[derive(Clone, Debug)]
pub struct Chart {
    /// Name of the vertical axis, with its unit.
    pub name: Rich,
    pub title: Rich,
    /// Factor by which the numbers of the curves are multiplied where they are written.
    pub factor: f64,
    /// The vertical axis; by default that of all numbers of the curves, and of 0 if it is near.
    pub y: Option<Scale>,
    pub curves: Vec<Curve>,
}

/// The least and the greatest finite coordinate of the points of curves.
pub fn extent(curves: &[Curve], of: fn(&Place) -> f64) -> (f64, f64) {
    extremes(curves.iter().flat_map(|curve| &curve.points).map(of).filter(|number| number.is_finite()))
}

impl Chart {
    fn scale(&self) -> Scale {
        let (low, high) = extent(&self.curves, |point| point.1);
        let span = high - low;
        let fitting = || match span > 0.0 {
            _ if low > high => Scale::linear(0.0, 1.0),
            true if low >= 0.0 && low < span => Scale::linear(0.0, high + 0.05 * span),
            true => Scale::linear(low - 0.05 * span, high + 0.05 * span),
            false => Scale::linear(low, high),
        };
        self.y.unwrap_or_else(fitting).in_unit(self.factor)
    }
}

/// Draws charts over a common horizontal axis, with one legend: one below the other, or in two columns if they share their
/// vertical axis too and the figure is wide.
pub fn draw(heading: &Rich, x: Scale, x_name: &Rich, charts: &[Chart], width: Width) -> Scene {
    let vertical = |chart: &Chart| (chart.name.clone(), chart.y);
    let share =
        charts.len() > 1 && charts.iter().all(|it| it.y.is_some() && vertical(it) == vertical(&charts[0]));
    let (columns, aspect) = match (width, charts.len()) {
        (Width::OneColumn, 1) => (1, 0.72),
        (Width::OneColumn, _) => (1, 0.6),
        (Width::TwoColumns, 1) => (1, 0.5),
        (Width::TwoColumns, _) if share => (2, 0.66),
        (Width::TwoColumns, _) => (1, 0.35),
    };
    let mut scene = Scene::new(width.points(), 0.0);
    let mut legend = Legend::default();
    // Panels of equal size, with space for the widest numbers.
    let widest = charts.iter().map(Chart::scale).max_by(|a, b| {
        let width = |scale: &Scale| Panel::y_labels_width(*scale, 120.0);
        width(a).total_cmp(&width(b))
    });
    let y = widest.unwrap_or(Scale::linear(0.0, 1.0));
    let panels = Panels::below(&mut scene, heading, columns, charts.len(), aspect, (x, y));
    for (number, (chart, panel)) in charts.iter().zip(&panels.panels).enumerate() {
        let panel = Panel { y: chart.scale(), ..*panel };
        for (turn, curve) in chart.curves.iter().enumerate() {
            let places: Vec<Place> = curve.points.iter().map(|p| panel.place(p.0, p.1)).collect();
            scene.clipped(panel.rect, |scene| scene.line(&places, &curve.style.stroke));
            if curve.marks {
                // Curves in turn have their marks at different places.
                let step = if places.len() > MARKED { places.len() / MARKS } else { 1 };
                let color = curve.style.stroke.color;
                let marked = places.iter().skip(step * (turn % 7) / 7 + step / 8).step_by(step);
                for place in marked.filter(|place| panel.rect.contains(**place)) {
                    scene.marker(curve.style.marker, *place, 4.0, color, false);
                }
            }
            if !curve.name.pieces.is_empty() {
                let sample = match curve.marks {
                    true => Sample::Method(curve.style),
                    false => Sample::Line(curve.style.stroke),
                };
                legend.add(sample, curve.name.clone());
            }
        }
        let labels = panels.labels(number);
        let labels = Labels { y: labels.y || !share, ..labels };
        panel.axes(&mut scene, labels);
        if !labels.y {
            panel.title(&mut scene, &chart.title);
        } else if text_width(&chart.name, TEXT) <= panel.rect.h + TITLE_MARGIN {
            panel.y_name(&mut scene, &chart.name, panels.labels_width);
            panel.title(&mut scene, &chart.title);
        } else {
            // The name would overlap that of the next panel.
            let begun = chart.title.plain();
            let between = if begun.is_empty() || begun.ends_with(' ') { "" } else { ": " };
            panel.title(&mut scene, &chart.title.clone().then(between).then(chart.name.clone()));
        }
        if labels.x {
            panel.x_name(&mut scene, x_name);
        }
    }
    let left = panels.panels.first().map_or(0.0, |panel| panel.rect.x);
    if legend.is_empty() {
        scene.height = panels.bottom + 4.0;
    } else {
        legend.below(&mut scene, left, panels.bottom);
    }
    scene
}

/// The letter of a panel: "(a) ".
pub fn letter(number: usize) -> Rich {
    rich(&format!("({}) ", char::from(b'a' + (number % 26) as u8)))
}

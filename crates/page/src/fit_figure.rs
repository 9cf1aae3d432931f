//! The figure of a fit: the readings, the law, and the band of two standard errors.

use slipmap_figure::axis::{SMALL_TEXT, Scale, extremes};
use slipmap_figure::panels::{BOTTOM_MARGIN, Panel, TITLE_MARGIN, left_margin};
use slipmap_figure::paragraph::paragraph;
use slipmap_figure::scene::{Anchor, Fill, Marker, Rect, Scene, Stroke, Width};
use slipmap_figure::style;
use slipmap_figure::text::Rich;

/// A fit as it is drawn.
pub struct FitFigure {
    /// The law, and the words for the axes with their units.
    pub title: String,
    pub speed: String,
    pub friction: String,
    /// Slip speed, friction and standard error, NaN where unknown, of each reading.
    pub readings: Vec<[f64; 3]>,
    /// Slip speed, friction and its standard error along the law.
    pub law: Vec<[f64; 3]>,
}

const HEIGHT: f64 = 150.0;
const MOST_LINES: usize = 3;
const RIGHT_MARGIN: f64 = 12.0;
/// Number of readings up to which each has a large mark.
const FEW: usize = 100;

impl FitFigure {
    pub fn scene(&self) -> Scene {
        let known = |error: f64| if error > 0.0 { error } else { 0.0 };
        let of_readings =
            self.readings.iter().flat_map(|[_, f, error]| [f - known(*error), f + known(*error)]);
        let of_law = self.law.iter().flat_map(|[_, f, error]| [f - 2.0 * error, f + 2.0 * error]);
        let (least, most) = extremes(of_readings.chain(of_law));
        let room = 0.05 * (most - least);
        let fastest = self.law.iter().map(|[speed, ..]| *speed).fold(0.0, f64::max);
        // Readings at rest and at the last speed are seen whole.
        let (x, y) =
            (Scale::linear(-0.02 * fastest, 1.02 * fastest), Scale::linear(least - room, most + room));
        let labels = Panel::y_labels_width(y, HEIGHT);
        let left = left_margin(labels);
        let width = Width::OneColumn.points();
        let title = paragraph(&Rich::foreign(&self.title), SMALL_TEXT, width - left, MOST_LINES);
        let line = SMALL_TEXT + 2.0;
        let top = TITLE_MARGIN + line * (title.len() - 1) as f64;
        let rect = Rect { x: left, y: top, w: width - left - RIGHT_MARGIN, h: HEIGHT };
        let panel = Panel { rect, x, y };
        let mut scene = Scene::new(width, top + HEIGHT + BOTTOM_MARGIN + SMALL_TEXT);
        for (number, words) in title.iter().rev().enumerate() {
            scene.text((left, top - 3.0 - line * number as f64), words, SMALL_TEXT, Anchor::Start);
        }
        let edge =
            |sign: f64| self.law.iter().map(move |[u, f, error]| panel.place(*u, f + 2.0 * sign * error));
        let band: Vec<_> = edge(1.0).chain(edge(-1.0).rev()).collect();
        scene.clipped(rect, |scene| {
            scene.area(&[band], Fill::plain(style::SKY));
            let few = self.readings.len() <= FEW;
            for [u, f, error] in &self.readings {
                if known(*error) > 0.0 {
                    let ends = [f - error, f + error].map(|friction| panel.place(*u, friction));
                    scene.line(&ends, &Stroke::solid(style::BLACK, 0.7));
                }
                scene.marker(
                    Marker::Circle,
                    panel.place(*u, *f),
                    if few { 2.6 } else { 1.2 },
                    style::BLACK,
                    true,
                );
            }
            let curve: Vec<_> = self.law.iter().map(|[u, f, _]| panel.place(*u, *f)).collect();
            scene.line(&curve, &Stroke::solid(style::BLUE, 1.4));
        });
        panel.named_axes(&mut scene, &Rich::foreign(&self.speed), &Rich::foreign(&self.friction), labels);
        scene
    }
}

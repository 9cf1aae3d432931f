//! Legends: samples of lines and areas with their names, in rows below the panels.

use super::super::text::Rich;
use super::axis::{AXIS, SMALL_TEXT};
use super::palette::MethodStyle;
use super::scene::{Anchor, Fill, Rect, Scene, Stroke, text_width};

/// What is shown beside a name.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sample {
    /// An area.
    Area(Fill),
    /// A line.
    Line(Stroke),
    /// A line with marks.
    Method(MethodStyle),
    /// A mark alone.
    Mark(super::scene::Marker, &'static str, bool),
}

/// A legend.
#[derive(Clone, Debug, Default)]
pub struct Legend {
    entries: Vec<(Sample, Rich)>,
}

const ROW: f64 = SMALL_TEXT + 4.0;
const SAMPLE: f64 = 20.0;
const GAP: f64 = 12.0;

impl Legend {
    /// Adds an entry.
    pub fn add(&mut self, sample: Sample, name: Rich) {
        self.entries.push((sample, name));
    }

    /// Whether there is nothing in it.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Entries in columns of equal width, as many as fit.
    fn columns(&self, width: f64) -> (usize, f64) {
        let widest = self.entries.iter().map(|(_, name)| text_width(name, SMALL_TEXT)).fold(0.0, f64::max)
            + SAMPLE
            + 3.0
            + GAP;
        let columns = (((width + GAP) / widest).floor() as usize).clamp(1, self.entries.len().max(1));
        // No more columns than the same number of rows needs.
        let rows = self.entries.len().div_ceil(columns);
        (self.entries.len().div_ceil(rows.max(1)).max(1), widest)
    }

    /// Height that it takes.
    #[must_use]
    pub fn height(&self, width: f64) -> f64 {
        self.entries.len().div_ceil(self.columns(width).0) as f64 * ROW
    }

    /// Draws it below the panels of a figure, and ends the figure there.
    pub fn below(&self, scene: &mut Scene, left: f64, top: f64) {
        // Flush with the panels if it fits there in as few rows as over the whole width.
        let whole = scene.width - 8.0;
        let room = scene.width - left - 4.0;
        let (left, room) = if self.height(room) > self.height(whole) { (4.0, whole) } else { (left, room) };
        scene.height = top + if self.is_empty() { 0.0 } else { self.height(room) } + 4.0;
        self.draw(scene, left, top, room);
    }

    /// Draws it with its upper left corner at a place.
    pub fn draw(&self, scene: &mut Scene, left: f64, top: f64, width: f64) {
        let (columns, cell) = self.columns(width);
        let rows = self.entries.len().div_ceil(columns);
        for (i, (sample, name)) in self.entries.iter().enumerate() {
            let x = left + (i / rows) as f64 * cell;
            let y = top + (i % rows) as f64 * ROW;
            let middle = y + 0.5 * ROW;
            match sample {
                Sample::Area(fill) => {
                    let rect = Rect { x: x + 4.0, y: y + 2.0, w: SAMPLE - 6.0, h: ROW - 4.0 };
                    scene.rect(rect, *fill);
                    scene.frame(rect, &Stroke { width: 0.4, ..AXIS });
                }
                Sample::Line(stroke) => scene.line(&[(x, middle), (x + SAMPLE, middle)], stroke),
                Sample::Method(style) => {
                    scene.line(&[(x, middle), (x + SAMPLE, middle)], &style.stroke);
                    scene.marker(style.marker, (x + 0.5 * SAMPLE, middle), 5.0, style.stroke.color, false);
                }
                Sample::Mark(marker, color, filled) => {
                    scene.marker(*marker, (x + 0.5 * SAMPLE, middle), 5.0, color, *filled);
                }
            }
            scene.text((x + SAMPLE + 3.0, middle + 0.36 * SMALL_TEXT), name, SMALL_TEXT, Anchor::Start);
        }
    }
}

//! Legends: samples of lines and areas with their names, in rows below the panels.

use super::axis::{AXIS, SMALL_TEXT};
use super::scene::{Anchor, Fill, Rect, Scene, Stroke, text_width};
use super::style::LineStyle;
use super::text::Rich;

/// The sample shown beside a name.
#[derive(Clone, Debug, PartialEq)]
pub enum Sample {
    Area(Fill),
    /// An area of any colour.
    Color(String),
    Line(Stroke),
    /// A line with marks.
    Method(LineStyle),
    /// A mark alone.
    Mark(super::scene::Marker, &'static str, bool),
    /// A text beside marks.
    Text(Rich),
}

#[derive(Clone, Debug, Default)]
pub struct Legend {
    entries: Vec<(Sample, Rich)>,
}

const ROW: f64 = SMALL_TEXT + 4.0;
const SAMPLE: f64 = 20.0;
const GAP: f64 = 12.0;

impl Legend {
    /// Adds an entry, unless the legend has it already.
    pub fn add(&mut self, sample: Sample, name: Rich) {
        let entry = (sample, name);
        if !self.entries.contains(&entry) {
            self.entries.push(entry);
        }
    }

    /// Adds the areas that are drawn.
    pub fn add_used(&mut self, kinds: &[(Fill, Rich)], used: &[bool]) {
        for ((fill, name), _) in kinds.iter().zip(used).filter(|(_, used)| **used) {
            self.add(Sample::Area(*fill), name.clone());
        }
    }

    /// Returns whether the legend has no entries.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// The number of rows and the widths of the columns, filled one after the other, each as wide as its
    /// widest entry: with as few rows as fit.
    fn layout(&self, width: f64) -> (usize, Vec<f64>) {
        let widths: Vec<f64> =
            self.entries.iter().map(|(_, name)| text_width(name, SMALL_TEXT) + SAMPLE + 3.0 + GAP).collect();
        let layout = |rows: usize| -> Vec<f64> {
            widths.chunks(rows).map(|column| column.iter().copied().fold(0.0, f64::max)).collect()
        };
        let fits = |columns: &[f64]| columns.iter().sum::<f64>() <= width + GAP;
        let all = self.entries.len().max(1);
        let rows = (1..all).find(|&rows| fits(&layout(rows))).unwrap_or(all);
        (rows, layout(rows))
    }

    pub fn height(&self, width: f64) -> f64 {
        if self.is_empty() { 0.0 } else { self.layout(width).0 as f64 * ROW }
    }

    /// Draws the legend below the panels of a figure, and ends the figure there.
    pub fn below(&self, scene: &mut Scene, left: f64, top: f64) {
        // Aligned with the panels if that takes no more rows than the whole width.
        let whole = scene.width - 8.0;
        let room = scene.width - left - 4.0;
        let (left, room) = if self.height(room) > self.height(whole) { (4.0, whole) } else { (left, room) };
        scene.height = top + self.height(room) + 4.0;
        self.draw(scene, left, top, room);
    }

    /// Draws the legend with its upper left corner at a place.
    pub fn draw(&self, scene: &mut Scene, left: f64, top: f64, width: f64) {
        let (rows, columns) = self.layout(width);
        for (i, (sample, name)) in self.entries.iter().enumerate() {
            let x = left + columns[..i / rows].iter().sum::<f64>();
            let y = top + (i % rows) as f64 * ROW;
            let middle = y + 0.5 * ROW;
            let swatch = Rect { x: x + 4.0, y: y + 2.0, w: SAMPLE - 6.0, h: ROW - 4.0 };
            match sample {
                Sample::Area(fill) => {
                    scene.rect(swatch, *fill);
                    scene.frame(swatch, &Stroke { width: 0.4, ..AXIS });
                }
                Sample::Color(color) => {
                    scene.pixel(swatch, color);
                    scene.frame(swatch, &Stroke { width: 0.4, ..AXIS });
                }
                Sample::Line(stroke) => scene.line(&[(x, middle), (x + SAMPLE, middle)], stroke),
                Sample::Method(style) => {
                    scene.line(&[(x, middle), (x + SAMPLE, middle)], &style.stroke);
                    scene.marker(style.marker, (x + 0.5 * SAMPLE, middle), 5.0, style.stroke.color, false);
                }
                Sample::Mark(marker, color, filled) => {
                    scene.marker(*marker, (x + 0.5 * SAMPLE, middle), 5.0, color, *filled);
                }
                Sample::Text(text) => {
                    let at = (x + 0.5 * SAMPLE, middle + 0.36 * SMALL_TEXT);
                    scene.text(at, text, SMALL_TEXT, Anchor::Middle);
                }
            }
            scene.text((x + SAMPLE + 3.0, middle + 0.36 * SMALL_TEXT), name, SMALL_TEXT, Anchor::Start);
        }
    }
}

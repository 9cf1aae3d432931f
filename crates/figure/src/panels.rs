//! Panels: frames with two axes, their ticks, numbers and names, alone or in rows on a page.

use super::axis::{AXIS, SMALL_TEXT, Scale, TEXT, Tick, text_width_of};
use super::paragraph::lines_of;
use super::scene::{Anchor, Place, Rect, Scene};
use super::text::{Piece, Rich};

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Panel {
    pub rect: Rect,
    pub x: Scale,
    pub y: Scale,
}

/// Largest distance of a place from its panel, in sides of it: rasterisers and dashes take time and memory in proportion
/// to lengths, and coordinates have single precision.
const BEYOND: f64 = 100.0;

/// The parts of a panel's axes that are labelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Labels {
    /// Numbers along the horizontal axis.
    pub x: bool,
    /// Numbers along the vertical axis.
    pub y: bool,
}

impl Panel {
    /// The position of a pair of numbers on the page, or far beyond the panel on the same side.
    pub fn place(&self, x: f64, y: f64) -> Place {
        let Rect { x: left, y: top, w, h } = self.rect;
        let near = |unit: f64| if unit.is_finite() { unit.clamp(-BEYOND, BEYOND) } else { unit };
        (left + w * near(self.x.unit(x)), top + h * (1.0 - near(self.y.unit(y))))
    }

    /// Draws frame, ticks and numbers.
    pub fn axes(&self, scene: &mut Scene, labels: Labels) {
        let Rect { x, y, h, .. } = self.rect;
        scene.frame(self.rect, &AXIS);
        self.x_axis(scene, labels);
        for tick in self.y_ticks() {
            let at = y + h * (1.0 - self.y.unit(tick.value));
            scene.line(&[(x, at), (x + tick.length(), at)], &AXIS);
            if labels.y {
                scene.text((x - 3.0, at + 0.36 * SMALL_TEXT), &tick.label, SMALL_TEXT, Anchor::End);
            }
        }
    }

    /// Draws both axes with their numbers, as wide as `labels_width` on the left, and their names.
    pub fn named_axes(&self, scene: &mut Scene, x_name: &Rich, y_name: &Rich, labels_width: f64) {
        self.axes(scene, Labels { x: true, y: true });
        self.x_name(scene, x_name);
        self.y_name(scene, y_name, labels_width);
    }

    /// Draws ticks and numbers of the horizontal axis.
    pub fn x_axis(&self, scene: &mut Scene, labels: Labels) {
        let Rect { x, y, w, h } = self.rect;
        for tick in self.x_ticks() {
            let at = x + w * self.x.unit(tick.value);
            scene.line(&[(at, y + h), (at, y + h - tick.length())], &AXIS);
            if labels.x {
                scene.text((at, y + h + SMALL_TEXT + 1.5), &tick.label, SMALL_TEXT, Anchor::Middle);
            }
        }
    }

    /// Horizontal ticks, as many as fit without their numbers touching.
    fn x_ticks(&self) -> Vec<Tick> {
        let mut most = 9;
        loop {
            let ticks = self.x.ticks(most);
            let widest = text_width_of(&ticks);
            let places: Vec<f64> = ticks
                .iter()
                .filter(|tick| !tick.label.pieces.is_empty())
                .map(|tick| self.rect.w * self.x.unit(tick.value))
                .collect();
            if most <= 2 || places.windows(2).all(|pair| pair[1] - pair[0] > widest + 0.8 * SMALL_TEXT) {
                return ticks;
            }
            most -= 1;
        }
    }

    fn y_ticks(&self) -> Vec<Tick> {
        let most = (self.rect.h / (2.4 * SMALL_TEXT)) as usize;
        self.y.ticks(most.clamp(2, 7))
    }

    /// Width of the numbers along the vertical axis.
    pub fn y_labels_width(y: Scale, height: f64) -> f64 {
        let panel = Panel { rect: Rect { x: 0.0, y: 0.0, w: 1.0, h: height }, x: Scale::linear(0.0, 1.0), y };
        text_width_of(&panel.y_ticks())
    }

    /// Writes the name of the horizontal axis below its numbers.
    pub fn x_name(&self, scene: &mut Scene, name: &Rich) {
        let Rect { x, y, w, h } = self.rect;
        scene.text((x + 0.5 * w, y + h + SMALL_TEXT + TEXT + 3.5), name, TEXT, Anchor::Middle);
    }

    /// Writes the name of the vertical axis left of its numbers, rotated: an upright letter beside a number
    /// would read as a product.
    pub fn y_name(&self, scene: &mut Scene, name: &Rich, labels_width: f64) {
        let Rect { x, y, h, .. } = self.rect;
        scene.text_up((x - labels_width - 7.5, y + 0.5 * h), name, TEXT, Anchor::Middle);
    }

    /// Writes a title above the panel.
    pub fn title(&self, scene: &mut Scene, title: &Rich) {
        scene.text((self.rect.x, self.rect.y - 3.0), title, SMALL_TEXT, Anchor::Start);
    }
}

/// Room left of a panel for numbers and the axis' name.
pub fn left_margin(labels_width: f64) -> f64 {
    labels_width + TEXT + 8.5
}

/// Room below a panel for numbers and the axis' name.
pub const BOTTOM_MARGIN: f64 = SMALL_TEXT + TEXT + 7.0;
/// Room above a panel for its title.
pub const TITLE_MARGIN: f64 = SMALL_TEXT + 4.5;

/// Least distance between panels.
const GAP: f64 = 9.0;
/// Largest height of the panels, in points, so that figure, legend and caption fit on a page: 205 mm.
const MOST_HEIGHT: f64 = 580.0;
/// Smallest ratio of height to width before panels are put side by side.
const FLATTEST: f64 = 0.5;

/// Panels of equal size in rows, sharing their axes' names.
#[derive(Clone, Debug)]
pub struct Panels {
    /// The panels, row by row.
    pub panels: Vec<Panel>,
    columns: usize,
    pub labels_width: f64,
    /// Lower end of the panels and their axes.
    pub bottom: f64,
}

/// Room above a row of panels beyond their own height.
const ROW_MARGIN: f64 = TITLE_MARGIN + 4.0;

impl Panels {
    /// `count` panels in `columns` columns over the width of a figure; each is `aspect` times as high as
    /// wide. If they would be higher than a page, they are flattened, or there are more columns.
    pub fn new(width: f64, columns: usize, count: usize, aspect: f64, x: Scale, y: Scale) -> Self {
        let mut columns = columns.clamp(1, count.max(1));
        loop {
            let rows = count.div_ceil(columns) as f64;
            let room = MOST_HEIGHT / rows.max(1.0) - ROW_MARGIN;
            let panels = Self::sized(width, columns, count, aspect, x, y);
            let Rect { w, h, .. } =
                panels.panels.first().map_or(Rect { x: 0.0, y: 0.0, w: 1.0, h: 0.0 }, |p| p.rect);
            if h <= room {
                return panels;
            }
            if room >= FLATTEST * w || columns >= count {
                return Self::sized(width, columns, count, room / w, x, y);
            }
            columns += 1;
        }
    }

    /// Panels as by [`Panels::new`], below a heading that is drawn at the top of the figure.
    pub fn below(
        scene: &mut Scene,
        heading: &Rich,
        columns: usize,
        count: usize,
        aspect: f64,
        (x, y): (Scale, Scale),
    ) -> Self {
        let mut panels = Self::new(scene.width, columns, count, aspect, x, y);
        let left = panels.panels.first().map_or(0.0, |panel| panel.rect.x);
        let height = write_heading(scene, left, heading);
        panels.shift((0.0, height));
        panels
    }

    fn sized(width: f64, columns: usize, count: usize, aspect: f64, x: Scale, y: Scale) -> Self {
        let widest = text_width_of(&x.ticks(9)).max(8.0);
        // Browsers may use a wider font for numbers.
        let (right, gap) = (0.5 * widest + 2.0, (widest + 5.0).max(GAP));
        let size = |labels_width: f64| {
            let left = left_margin(labels_width);
            let w = (width - left - right - gap * (columns - 1) as f64) / columns as f64;
            (left, w, aspect * w)
        };
        // The numbers depend on the height and the height on the numbers; two rounds are enough.
        let labels_width = Panel::y_labels_width(y, size(20.0).2);
        let labels_width = Panel::y_labels_width(y, size(labels_width).2);
        let (left, w, h) = size(labels_width);
        let row = h + ROW_MARGIN;
        let panels = (0..count)
            .map(|i| {
                let (column, line) = ((i % columns) as f64, (i / columns) as f64);
                let rect = Rect { x: left + column * (w + gap), y: TITLE_MARGIN + line * row, w, h };
                Panel { rect, x, y }
            })
            .collect();
        let rows = count.div_ceil(columns) as f64;
        Self { panels, columns, labels_width, bottom: rows * row - 4.0 + BOTTOM_MARGIN }
    }

    pub fn shift(&mut self, (right, down): Place) {
        for panel in &mut self.panels {
            panel.rect.x += right;
            panel.rect.y += down;
        }
        self.bottom += down;
    }

    /// What is labelled of a panel that shares its axes with the others: on the left and at the bottom only.
    pub fn labels(&self, number: usize) -> Labels {
        Labels { x: number + self.columns >= self.panels.len(), y: number.is_multiple_of(self.columns) }
    }

    /// Draws the axes: names and numbers on the left and at the bottom only.
    pub fn axes(&self, scene: &mut Scene, x_name: &Rich, y_name: &Rich) {
        for (i, panel) in self.panels.iter().enumerate() {
            let labels = self.labels(i);
            panel.axes(scene, labels);
            if labels.x {
                panel.x_name(scene, x_name);
            }
            if labels.y {
                panel.y_name(scene, y_name, self.labels_width);
            }
        }
    }
}

/// Writes a heading of small text at the top of a figure, in as many lines as it needs; returns its height.
pub fn write_heading(scene: &mut Scene, left: f64, heading: &Rich) -> f64 {
    if heading.pieces.is_empty() {
        return 0.0;
    }
    let mut height = 2.0;
    for line in wrap(heading, scene.width - left - 4.0) {
        height += SMALL_TEXT + 2.0;
        scene.text((left, height - 2.0), &line, SMALL_TEXT, Anchor::Start);
    }
    height
}

/// Breaks "a = 1, b = 2, ..." into lines that fit: its parts end with ", ".
fn wrap(text: &Rich, width: f64) -> Vec<Rich> {
    let is_comma = |piece: &Piece| matches!(piece, Piece::Words(words) if words == ", ");
    let parts = text.pieces.split_inclusive(is_comma).map(|pieces| Rich { pieces: pieces.to_vec() });
    lines_of(parts, SMALL_TEXT, width)
}

#[cfg(test)]
mod tests {
    use super::super::scene::Width;
    use super::*;

    #[test]
    fn panels_fit_on_a_page_and_their_numbers_do_not_touch() {
        for (columns, count) in [(1, 1), (1, 4), (2, 12), (4, 30), (1, 9)] {
            for width in [Width::OneColumn, Width::TwoColumns] {
                let (x, y) = (Scale::logarithmic(0.1, 100.0), Scale::linear(0.0, 0.4));
                let panels = Panels::new(width.points(), columns, count, 0.8, x, y);
                assert!(panels.bottom <= MOST_HEIGHT + BOTTOM_MARGIN, "{count} panels: {}", panels.bottom);
                let last = panels.panels.iter().map(|p| p.rect.x + p.rect.w).fold(0.0, f64::max);
                let widest = text_width_of(&x.ticks(9));
                assert!(last + 0.5 * widest <= width.points() + 1e-9);
                if let [first, second, ..] = panels.panels[..]
                    && second.rect.x > first.rect.x
                {
                    assert!(second.rect.x - first.rect.x - first.rect.w > widest);
                }
            }
        }
    }
}

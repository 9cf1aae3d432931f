//! Axes: scales, ticks and the frame of a panel.

use super::super::text::{Piece, Rich, Symbol};
use super::scene::{Anchor, Place, Rect, Scene, Stroke, text_width};
use crate::map::is_logarithmic;

/// Size of the numbers at ticks and in legends, in points.
pub(crate) const SMALL_TEXT: f64 = 7.0;
/// Size of axis labels and panel titles, in points.
pub(crate) const TEXT: f64 = 8.0;

/// Lines of frames and ticks.
pub(crate) const AXIS: Stroke = Stroke::solid("#000000", 0.6);

/// Length of a tick, inward.
const TICK: f64 = 3.0;

/// The map from numbers to positions along an axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scale {
    /// Number at the start.
    pub(crate) from: f64,
    /// Number at the end.
    pub(crate) to: f64,
    /// Whether it is logarithmic.
    pub(crate) log: bool,
    /// Factor by which numbers are multiplied where they are written.
    pub(crate) shown: f64,
}

/// A tick.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tick {
    /// Its number on the scale.
    pub(crate) value: f64,
    /// Its label; empty for a minor tick.
    pub(crate) label: Rich,
}

impl Tick {
    /// Length of its line; minor ticks are shorter.
    fn length(&self) -> f64 {
        if self.label.pieces.is_empty() { 0.6 * TICK } else { TICK }
    }
}

impl Scale {
    /// A linear scale; a single number gets a range around it.
    pub(crate) fn linear(from: f64, to: f64) -> Self {
        if to > from {
            return Self { from, to, log: false, shown: 1.0 };
        }
        let room = if from == 0.0 { 1.0 } else { 0.5 * from.abs() };
        Self { from: from - room, to: from + room, log: false, shown: 1.0 }
    }

    /// A logarithmic scale of positive numbers; a single number gets a range around it. Ends beyond the smallest
    /// and the largest double are moved there.
    pub(crate) fn logarithmic(from: f64, to: f64) -> Self {
        let [from, to] = if to > from { [from, to] } else { [from / 2.0, from * 2.0] };
        Self { from: from.max(f64::from_bits(1)), to: to.min(f64::MAX), log: true, shown: 1.0 }
    }

    /// The scale that fits the nodes of an axis.
    pub(crate) fn of_nodes(values: &[f64]) -> Self {
        let (first, last) = (values[0], values[values.len() - 1]);
        if values.len() > 2 && is_logarithmic(values) {
            Self::logarithmic(first, last)
        } else {
            Self::linear(first, last)
        }
    }

    /// Position of a number: 0 at the start, 1 at the end.
    pub(crate) fn unit(&self, value: f64) -> f64 {
        if self.log {
            // Differences of logarithms, because the ratio of two numbers may overflow.
            (value.ln() - self.from.ln()) / (self.to.ln() - self.from.ln())
        } else {
            // Halves, because the difference of two numbers may overflow.
            let span = self.to - self.from;
            if span.is_finite() {
                (value - self.from) / span
            } else {
                (0.5 * value - 0.5 * self.from) / (0.5 * self.to - 0.5 * self.from)
            }
        }
    }

    /// The number at a position, inverse of [`Scale::unit`].
    pub(crate) fn value(&self, unit: f64) -> f64 {
        if self.log {
            (self.from.ln() * (1.0 - unit) + self.to.ln() * unit).exp().clamp(self.from, self.to)
        } else {
            self.from * (1.0 - unit) + self.to * unit
        }
    }

    /// The same scale, with its numbers written in another unit.
    #[must_use]
    pub(crate) fn in_unit(self, shown: f64) -> Self {
        Self { shown, ..self }
    }

    /// Ticks, about `most` of them labelled.
    pub(crate) fn ticks(&self, most: usize) -> Vec<Tick> {
        let written = Self { from: self.from * self.shown, to: self.to * self.shown, shown: 1.0, ..*self };
        let ticks = if self.log { written.log_ticks(most.max(2)) } else { written.linear_ticks(most.max(2)) };
        ticks.into_iter().map(|tick| Tick { value: tick.value / self.shown, ..tick }).collect()
    }

    /// Ticks at the two ends only, where no round numbers lie between: next to the smallest or the largest
    /// doubles, or if the ends are almost equal.
    fn end_ticks(&self) -> Vec<Tick> {
        let tick = |value: f64| Tick { value, label: Rich::number(value, 3) };
        vec![tick(self.from), tick(self.to)]
    }

    fn linear_ticks(&self, most: usize) -> Vec<Tick> {
        let span = self.to - self.from;
        let rough = span / most as f64;
        let resolved = 1e3 * f64::EPSILON * self.from.abs().max(self.to.abs());
        if !(rough >= f64::MIN_POSITIVE && rough > resolved && span.is_finite()) {
            return self.end_ticks();
        }
        let power = 10.0_f64.powf(rough.log10().floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|m| m * power).into_iter().find(|step| *step >= rough);
        let step = step.unwrap_or(10.0 * power);
        let slack = 1e-9 * span;
        let first = (self.from / step - slack / step).ceil() as i64;
        let last = (self.to / step + slack / step).floor() as i64;
        let values: Vec<f64> = (first..=last).map(|i| i as f64 * step).collect();
        let largest = values.iter().fold(0.0_f64, |a, v| a.max(v.abs()));
        let decimals = (-step.log10().floor()).max(0.0) as usize;
        values
            .into_iter()
            .map(|value| {
                let label = if (1e-4..1e5).contains(&largest) && decimals < 5 {
                    Rich::foreign(&format!("{value:.decimals$}").replace('-', "−"))
                } else {
                    let digits = 1 + (largest / step).log10().ceil().max(0.0) as usize;
                    Rich::number(if value.abs() < slack { 0.0 } else { value }, digits)
                };
                Tick { value, label }
            })
            .collect()
    }

    fn log_ticks(&self, most: usize) -> Vec<Tick> {
        let (low, high) = (self.from * (1.0 - 1e-9), self.to * (1.0 + 1e-9));
        let (first, last) = (low.log10().floor() as i32, high.log10().ceil() as i32);
        let decades = high.log10() - low.log10();
        if !(decades > 0.0 && decades.is_finite()) {
            return self.end_ticks();
        }
        // Labels at powers of ten; on short axes also at 2 and 5 times these.
        let every = ((decades / most as f64).ceil() as i32).max(1);
        let labelled: &[u8] = match decades {
            d if d < 0.8 => &[1, 2, 3, 4, 5, 6, 8],
            d if d < 1.7 && most > 3 => &[1, 2, 5],
            _ => &[1],
        };
        let mut ticks = Vec::new();
        for exponent in first..=last {
            for factor in 1..10u8 {
                let value = f64::from(factor) * 10.0_f64.powi(exponent);
                if !(low..=high).contains(&value) || (every > 1 && factor > 1) {
                    continue;
                }
                let label = if labelled.contains(&factor) && (factor > 1 || exponent.rem_euclid(every) == 0) {
                    log_label(factor, exponent, (self.from, self.to))
                } else {
                    Rich::default()
                };
                ticks.push(Tick { value, label });
            }
        }
        if ticks.len() < 2 { self.end_ticks() } else { ticks }
    }
}

/// The label of a tick on a logarithmic axis: plain numbers if all are short.
fn log_label(factor: u8, exponent: i32, (from, to): (f64, f64)) -> Rich {
    if from > 0.8e-3 && to < 1.2e3 {
        return Rich::number(f64::from(factor) * 10.0_f64.powi(exponent), 3);
    }
    let exponent = exponent.to_string().replace('-', "−");
    let power =
        Rich { pieces: vec![Piece::Symbol(Symbol { base: "10".into(), index: String::new(), exponent })] };
    if factor == 1 { power } else { Rich::foreign(&format!("{factor} × ")).then(power) }
}

/// A panel with two axes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Panel {
    /// The frame.
    pub(crate) rect: Rect,
    /// Horizontal scale.
    pub(crate) x: Scale,
    /// Vertical scale.
    pub(crate) y: Scale,
}

/// The parts of a panel's axes that are labelled.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Labels {
    /// Numbers along the horizontal axis.
    pub(crate) x: bool,
    /// Numbers along the vertical axis.
    pub(crate) y: bool,
}

impl Panel {
    /// The position of a pair of numbers on the page.
    pub(crate) fn place(&self, x: f64, y: f64) -> Place {
        let Rect { x: left, y: top, w, h } = self.rect;
        (left + w * self.x.unit(x), top + h * (1.0 - self.y.unit(y)))
    }

    /// Draws frame, ticks and numbers.
    pub(crate) fn axes(&self, scene: &mut Scene, labels: Labels) {
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

    /// Draws ticks and numbers of the horizontal axis.
    pub(crate) fn x_axis(&self, scene: &mut Scene, labels: Labels) {
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
            let widest = ticks.iter().map(|tick| text_width(&tick.label, SMALL_TEXT)).fold(0.0, f64::max);
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
    pub(crate) fn y_labels_width(y: Scale, height: f64) -> f64 {
        let panel = Panel { rect: Rect { x: 0.0, y: 0.0, w: 1.0, h: height }, x: Scale::linear(0.0, 1.0), y };
        panel.y_ticks().iter().map(|tick| text_width(&tick.label, SMALL_TEXT)).fold(0.0, f64::max)
    }

    /// Writes the name of the horizontal axis below its numbers.
    pub(crate) fn x_name(&self, scene: &mut Scene, name: &Rich) {
        let Rect { x, y, w, h } = self.rect;
        scene.text((x + 0.5 * w, y + h + SMALL_TEXT + TEXT + 3.5), name, TEXT, Anchor::Middle);
    }

    /// Writes the name of the vertical axis left of its numbers, rotated: an upright letter beside a number
    /// would read as a product.
    pub(crate) fn y_name(&self, scene: &mut Scene, name: &Rich, labels_width: f64) {
        let Rect { x, y, h, .. } = self.rect;
        scene.text_up((x - labels_width - 7.5, y + 0.5 * h), name, TEXT, Anchor::Middle);
    }

    /// Writes a title above the panel.
    pub(crate) fn title(&self, scene: &mut Scene, title: &Rich) {
        scene.text((self.rect.x, self.rect.y - 3.0), title, SMALL_TEXT, Anchor::Start);
    }
}

/// Room left of a panel for numbers and the axis' name.
pub(crate) fn left_margin(labels_width: f64) -> f64 {
    labels_width + TEXT + 8.5
}

/// Room below a panel for numbers and the axis' name.
pub(crate) const BOTTOM_MARGIN: f64 = SMALL_TEXT + TEXT + 7.0;
/// Room above a panel for its title.
pub(crate) const TITLE_MARGIN: f64 = SMALL_TEXT + 4.5;

/// Least distance between panels.
const GAP: f64 = 9.0;
/// Largest height of the panels, in points, so that figure, legend and caption fit on a page: 205 mm.
const MOST_HEIGHT: f64 = 580.0;
/// Smallest ratio of height to width before panels are put side by side.
const FLATTEST: f64 = 0.5;

/// Width of the widest number at ticks.
fn text_width_of(ticks: &[Tick]) -> f64 {
    ticks.iter().map(|tick| text_width(&tick.label, SMALL_TEXT)).fold(0.0, f64::max)
}

/// Panels of equal size in rows, sharing their axes' names.
#[derive(Clone, Debug)]
pub(crate) struct Panels {
    /// The panels, row by row.
    pub(crate) panels: Vec<Panel>,
    columns: usize,
    labels_width: f64,
    /// Lower end of the panels and their axes.
    pub(crate) bottom: f64,
}

/// Room above a row of panels beyond their own height.
const ROW_MARGIN: f64 = TITLE_MARGIN + 4.0;

impl Panels {
    /// `count` panels in `columns` columns over the width of a figure; each is `aspect` times as high as
    /// wide. If they would be higher than a page, they are flattened, or there are more columns.
    pub(crate) fn new(width: f64, columns: usize, count: usize, aspect: f64, x: Scale, y: Scale) -> Self {
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

    /// The same below a heading, which is drawn at the top of the figure.
    pub(crate) fn below(
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

    /// Room for the numbers left of the panels.
    pub(crate) fn labels_width(&self) -> f64 {
        self.labels_width
    }

    /// Moves all panels.
    pub(crate) fn shift(&mut self, (right, down): Place) {
        for panel in &mut self.panels {
            panel.rect.x += right;
            panel.rect.y += down;
        }
        self.bottom += down;
    }

    /// Draws the axes: names and numbers on the left and at the bottom only.
    pub(crate) fn axes(&self, scene: &mut Scene, x_name: &Rich, y_name: &Rich) {
        for (i, panel) in self.panels.iter().enumerate() {
            let labels = Labels { x: i + self.columns >= self.panels.len(), y: i % self.columns == 0 };
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
pub(crate) fn write_heading(scene: &mut Scene, left: f64, heading: &Rich) -> f64 {
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

/// Breaks "a = 1, b = 2, ..." into lines that fit.
pub(crate) fn wrap(text: &Rich, width: f64) -> Vec<Rich> {
    let mut lines: Vec<Rich> = Vec::new();
    let mut line = Rich::default();
    // Pieces come in groups that end with ", ".
    let mut group = Rich::default();
    let mut groups = Vec::new();
    for piece in &text.pieces {
        group.pieces.push(piece.clone());
        if matches!(piece, Piece::Words(words) if words == ", ") {
            groups.push(std::mem::take(&mut group));
        }
    }
    groups.push(group);
    for group in groups {
        let longer = line.clone().then(group.clone());
        if !line.pieces.is_empty() && text_width(&longer, SMALL_TEXT) > width {
            lines.push(std::mem::replace(&mut line, group));
        } else {
            line = longer;
        }
    }
    lines.push(line);
    lines
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn panels_fit_on_a_page_and_their_numbers_do_not_touch() {
        for (columns, count) in [(1, 1), (1, 4), (2, 12), (4, 30), (1, 9)] {
            for width in super::super::scene::Width::ALL {
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

    #[test]
    fn ranges_around_extreme_numbers_are_ranges_of_numbers() {
        for [from, to] in [[1.9e306, f64::INFINITY], [f64::MAX; 2], [0.0, 4e-323], [f64::from_bits(1); 2]] {
            let scale = Scale::logarithmic(from, to);
            let values = [0.0, 0.5, 1.0].map(|unit| scale.value(unit));
            assert!(values.iter().all(|value| *value > 0.0 && value.is_finite()), "{values:?}");
            assert!(values[0] < values[2]);
        }
    }

    fn labels(scale: Scale, most: usize) -> Vec<String> {
        let ticks = scale.ticks(most);
        ticks.iter().map(|tick| tick.label.plain()).filter(|label| !label.is_empty()).collect()
    }

    #[test]
    fn ticks_are_round_numbers_of_the_unit_that_is_shown() {
        // A velocity of 0.4 m/s as the unit: ticks at full tenths of m/s, positioned on the scale.
        let scale = Scale::linear(0.0, 1.0).in_unit(0.4);
        assert_eq!(labels(scale, 4), ["0.0", "0.1", "0.2", "0.3", "0.4"]);
        let places: Vec<f64> = scale.ticks(4).iter().map(|tick| tick.value).collect();
        // The rounding errors of a multiplication and a division.
        for (place, expected) in places.iter().zip([0.0, 0.25, 0.5, 0.75, 1.0]) {
            assert!((place - expected).abs() <= 4.0 * f64::EPSILON, "{places:?}");
        }
        assert_eq!(labels(Scale::logarithmic(1.0, 100.0).in_unit(10.0), 4), ["10", "100", "1000"]);
    }

    #[test]
    fn ticks_are_few_and_finite_on_any_axis() {
        let extremes = [5e-324, 1e-310, 1e-300, 1e-5, 1.0, 1.0 + 1e-15, 1e5, 1e16, 2e16, 1e300, 1e308];
        for from in [f64::MIN, -1e-300, 0.0].into_iter().chain(extremes) {
            for to in extremes.into_iter().chain([f64::MAX]).filter(|to| *to > from) {
                let mut scales = vec![Scale::linear(from, to)];
                if from > 0.0 {
                    scales.push(Scale::logarithmic(from, to));
                }
                for scale in scales {
                    let ticks = scale.ticks(7);
                    assert!((2..=6000).contains(&ticks.len()), "{scale:?}: {}", ticks.len());
                    let labelled = labels(scale, 7).len();
                    assert!((1..=14).contains(&labelled), "{scale:?}: {labelled}");
                    for tick in ticks {
                        let unit = scale.unit(tick.value);
                        assert!((-0.01..=1.01).contains(&unit), "{scale:?} {tick:?} at {unit}");
                    }
                    assert!((from..=to).contains(&scale.value(0.5)), "{scale:?}");
                }
            }
        }
    }

    #[test]
    fn ticks_are_round_numbers() {
        assert_eq!(labels(Scale::linear(0.0, 1.0), 5), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        assert_eq!(labels(Scale::linear(-1.0, 3.0), 4), ["−1", "0", "1", "2", "3"]);
        assert_eq!(labels(Scale::logarithmic(0.1, 10.0), 5), ["0.1", "1", "10"]);
        assert_eq!(labels(Scale::logarithmic(1e-9, 1e-3), 3), ["10−9", "10−6", "10−3"]);
        // A single number has an axis around it.
        assert!(labels(Scale::linear(2.0, 2.0), 4).contains(&"2.0".to_owned()));
        assert!(labels(Scale::logarithmic(0.5, 0.5), 4).contains(&"0.5".to_owned()));
    }

    #[test]
    fn scales_go_there_and_back() {
        for scale in [Scale::linear(-2.0, 5.0), Scale::logarithmic(1e-3, 20.0)] {
            for unit in [0.0, 0.3, 1.0] {
                // Two roundings of numbers near 1.
                assert!((scale.unit(scale.value(unit)) - unit).abs() < 1e-14);
            }
        }
    }
}

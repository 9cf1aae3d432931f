//! Scenes: drawings in points (1/72 inch), written as SVG. Text stays text.

use std::collections::BTreeSet;
use std::fmt::Write as _;

use super::advances::advance;
use super::text::{Piece, Rich, Symbol, html};
use slipmap_numbers::text::without_zeros;

/// A position on the page, in points from the left and from the top.
pub type Place = (f64, f64);

/// Points in a millimetre.
const POINTS: f64 = 72.0 / 25.4;

/// Font families in order of preference. The widths of the first one determine the layout, and PNG and PDF
/// use it; the others have similar widths.
const FONTS: &str = "Noto Sans, Helvetica, Arial, Liberation Sans, sans-serif";

/// Shift of indices and exponents, and their size, in units of the text's size.
const LOWERED: f64 = 0.22;
const RAISED: f64 = 0.38;
const SMALL: f64 = 0.72;

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Width {
    /// One column of a journal, 84 mm.
    OneColumn,
    /// Two columns of a journal, 174 mm.
    TwoColumns,
}

impl Width {
    /// The first of two choices for one column, the second for two.
    pub fn select<T>(self, one_column: T, two_columns: T) -> T {
        match self {
            Width::OneColumn => one_column,
            Width::TwoColumns => two_columns,
        }
    }

    pub fn points(self) -> f64 {
        POINTS * self.select(84.0, 174.0)
    }
}

/// A rectangle: its upper left corner, width and height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub x: f64,
    pub y: f64,
    pub w: f64,
    pub h: f64,
}

impl Rect {
    /// Returns whether a place lies in it or on its edge.
    pub fn contains(&self, place: Place) -> bool {
        let Rect { x, y, w, h } = *self;
        (x..=x + w).contains(&place.0) && (y..=y + h).contains(&place.1)
    }
}

/// Lines of a hatching; they rise or fall to the right.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Hatch {
    Rising,
    Falling,
    Crossed,
    Dots,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Fill {
    /// Colour of the ground, `none` for none.
    pub ground: &'static str,
    /// Hatching and its colour.
    pub hatch: Option<(Hatch, &'static str)>,
}

impl Fill {
    pub const fn plain(ground: &'static str) -> Self {
        Self { ground, hatch: None }
    }

    pub const fn hatched(ground: &'static str, hatch: Hatch, ink: &'static str) -> Self {
        Self { ground, hatch: Some((hatch, ink)) }
    }
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stroke {
    pub color: &'static str,
    /// Width in points.
    pub width: f64,
    /// Lengths of dashes and gaps in points; empty for a solid line.
    pub dash: &'static [f64],
}

impl Stroke {
    pub const fn solid(color: &'static str, width: f64) -> Self {
        Self { color, width, dash: &[] }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    Circle,
    Square,
    Diamond,
    Triangle,
    TriangleDown,
    Cross,
    Plus,
}

/// The part of a text that is placed at its position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    Start,
    Middle,
    End,
}

#[derive(Clone, Debug)]
pub struct Scene {
    /// Width in points.
    pub width: f64,
    /// Height in points.
    pub height: f64,
    body: String,
    /// Hatchings in use. In `body` they are marked, like clips, by a control character, which no text
    /// contains.
    hatchings: BTreeSet<(Hatch, &'static str)>,
    clips: Vec<Rect>,
}

impl Scene {
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, body: String::new(), hatchings: BTreeSet::new(), clips: Vec::new() }
    }

    fn path(&mut self, d: &str, attributes: &str) {
        let _ = writeln!(self.body, "<path d=\"{d}\" {attributes}/>");
    }

    /// Draws a line through points; one that is not finite interrupts it.
    pub fn line(&mut self, points: &[Place], stroke: &Stroke) {
        let finite = |p: &Place| p.0.is_finite() && p.1.is_finite();
        for part in points.split(|p| !finite(p)).filter(|part| part.len() > 1) {
            self.path(&path(part, false), &format!("fill=\"none\" {}", stroke_attributes(stroke)));
        }
    }

    /// Draws the head of an arrow with its tip at a place.
    pub fn arrow_head(&mut self, tip: Place, direction: Place, color: &'static str, size: f64) {
        let length = direction.0.hypot(direction.1);
        if !(length > 0.0 && length.is_finite()) {
            return;
        }
        let (ux, uy) = (direction.0 / length, direction.1 / length);
        let at = |along: f64, across: f64| {
            (tip.0 - size * (along * ux - across * uy), tip.1 - size * (along * uy + across * ux))
        };
        let outline = path(&[tip, at(1.0, 0.42), at(0.75, 0.0), at(1.0, -0.42)], true);
        self.path(&outline, &format!("fill=\"{color}\""));
    }

    /// Fills the area inside closed outlines; outlines inside others are holes.
    pub fn area(&mut self, outlines: &[Vec<Place>], fill: Fill) {
        if outlines.is_empty() {
            return;
        }
        let d: String = outlines.iter().map(|outline| path(outline, true)).collect();
        if fill.ground != "none" {
            self.path(&d, &format!("fill-rule=\"evenodd\" fill=\"{}\"", fill.ground));
        }
        if let Some(hatching) = fill.hatch {
            self.path(&d, &format!("fill-rule=\"evenodd\" fill=\"url(#\u{1}{})\"", hatch_id(hatching)));
            self.hatchings.insert(hatching);
        }
    }

    pub fn rect(&mut self, rect: Rect, fill: Fill) {
        self.area(&[corners(rect)], fill);
    }

    /// Fills a rectangle with any colour, without smoothing its edges.
    pub fn pixel(&mut self, rect: Rect, color: &str) {
        let Rect { x, y, w, h } = rect;
        let _ = writeln!(
            self.body,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\" shape-rendering=\"crispEdges\"/>",
            number(x),
            number(y),
            number(w),
            number(h),
            html(color)
        );
    }

    pub fn frame(&mut self, rect: Rect, stroke: &Stroke) {
        self.path(&path(&corners(rect), true), &format!("fill=\"none\" {}", stroke_attributes(stroke)));
    }

    /// Draws a mark, at a finite place. `size` is about its diameter in points.
    pub fn marker(&mut self, marker: Marker, at: Place, size: f64, color: &'static str, filled: bool) {
        if !(at.0.is_finite() && at.1.is_finite()) {
            return;
        }
        let r = 0.5 * size;
        let p = |x: f64, y: f64| (at.0 + r * x, at.1 + r * y);
        let fill = if filled { color } else { "#ffffff" };
        let d = match marker {
            Marker::Circle => {
                let _ = writeln!(
                    self.body,
                    "<circle cx=\"{}\" cy=\"{}\" r=\"{}\" fill=\"{fill}\" stroke=\"{color}\" stroke-width=\"0.7\"/>",
                    number(at.0),
                    number(at.1),
                    number(0.9 * r)
                );
                return;
            }
            Marker::Square => path(&[p(-0.8, -0.8), p(0.8, -0.8), p(0.8, 0.8), p(-0.8, 0.8)], true),
            Marker::Diamond => path(&[p(0.0, -1.1), p(1.1, 0.0), p(0.0, 1.1), p(-1.1, 0.0)], true),
            Marker::Triangle => path(&[p(0.0, -1.1), p(1.0, 0.7), p(-1.0, 0.7)], true),
            Marker::TriangleDown => path(&[p(0.0, 1.1), p(1.0, -0.7), p(-1.0, -0.7)], true),
            Marker::Cross => {
                path(&[p(-0.8, -0.8), p(0.8, 0.8)], false) + &path(&[p(-0.8, 0.8), p(0.8, -0.8)], false)
            }
            Marker::Plus => {
                path(&[p(-1.0, 0.0), p(1.0, 0.0)], false) + &path(&[p(0.0, -1.0), p(0.0, 1.0)], false)
            }
        };
        self.path(&d, &format!("fill=\"{fill}\" stroke=\"{color}\" stroke-width=\"0.7\""));
    }

    /// Draws a text with its baseline at a place.
    pub fn text(&mut self, at: Place, text: &Rich, size: f64, anchor: Anchor) {
        self.write_text(at, text, size, anchor, "");
    }

    /// Draws a text that reads upwards.
    pub fn text_up(&mut self, at: Place, text: &Rich, size: f64, anchor: Anchor) {
        let turn = format!(" transform=\"rotate(-90 {} {})\"", number(at.0), number(at.1));
        self.write_text(at, text, size, anchor, &turn);
    }

    fn write_text(&mut self, at: Place, text: &Rich, size: f64, anchor: Anchor, turn: &str) {
        let anchor = match anchor {
            Anchor::Start => "start",
            Anchor::Middle => "middle",
            Anchor::End => "end",
        };
        let mut spans = String::new();
        // Indices and exponents shift the baseline; the next span shifts it back.
        let mut shift = 0.0;
        let mut span = |words: &str, italic: bool, small: bool, baseline: f64| {
            let dy = size * (baseline - shift);
            shift = baseline;
            let style = if italic { " font-style=\"italic\"" } else { "" };
            let dy = if dy == 0.0 { String::new() } else { format!(" dy=\"{}\"", number(dy)) };
            let small =
                if small { format!(" font-size=\"{}\"", number(SMALL * size)) } else { String::new() };
            let _ = write!(spans, "<tspan{style}{dy}{small}>{}</tspan>", html(words));
        };
        for piece in &text.pieces {
            match piece {
                Piece::Words(words) => span(words, false, false, 0.0),
                Piece::Formula(formula) => span(&formula.plain, false, false, 0.0),
                Piece::Symbol(symbol) => {
                    span(&symbol.base, symbol.is_letter(), false, 0.0);
                    if !symbol.index.is_empty() {
                        span(&symbol.index, false, true, LOWERED);
                    }
                    if !symbol.exponent.is_empty() {
                        span(&symbol.exponent, false, true, -RAISED);
                    }
                }
            }
        }
        let _ = writeln!(
            self.body,
            "<text x=\"{}\" y=\"{}\" font-size=\"{}\" text-anchor=\"{anchor}\" xml:space=\"preserve\"{turn}>{spans}</text>",
            number(at.0),
            number(at.1),
            number(size)
        );
    }

    /// Draws another figure with its upper left corner at a place.
    pub fn place(&mut self, at: Place, other: &Scene) {
        let first = self.clips.len();
        self.clips.extend(&other.clips);
        self.hatchings.extend(&other.hatchings);
        let mut body = other.body.clone();
        // In reverse order, so that no number is changed twice.
        for number in (0..other.clips.len()).rev() {
            body = body.replace(&format!("(#\u{1}clip{number})"), &format!("(#\u{1}clip{})", first + number));
        }
        let (x, y) = (number(at.0), number(at.1));
        let _ = writeln!(self.body, "<g transform=\"translate({x} {y})\">\n{body}</g>");
    }

    pub fn clipped(&mut self, rect: Rect, draw: impl FnOnce(&mut Self)) {
        let number = self.clips.len();
        self.clips.push(rect);
        let _ = writeln!(self.body, "<g clip-path=\"url(#\u{1}clip{number})\">");
        draw(self);
        self.body.push_str("</g>\n");
    }

    /// The figure as SVG. `name` makes its identifiers unique on a page with several figures; `description`
    /// is for readers who cannot see it.
    pub fn svg(&self, name: &str, description: &Rich) -> String {
        let prefix: String = name.chars().map(|c| if c.is_ascii_alphanumeric() { c } else { '-' }).collect();
        let prefix = format!("f-{prefix}-");
        let (w, h) = (number(self.width), number(self.height));
        let mut svg = format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}pt\" height=\"{h}pt\" viewBox=\"0 0 {w} {h}\" \
             font-family=\"{FONTS}\" fill=\"#000000\" role=\"img\">\n<title>{}</title>\n<defs>\n",
            html(&description.plain())
        );
        for hatching in &self.hatchings {
            svg.push_str(&pattern(*hatching, &prefix));
        }
        for (i, rect) in self.clips.iter().enumerate() {
            let outline = path(&corners(*rect), true);
            let _ = writeln!(svg, "<clipPath id=\"{prefix}clip{i}\"><path d=\"{outline}\"/></clipPath>");
        }
        let _ = writeln!(svg, "</defs>\n<rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>");
        svg.push_str(&self.body.replace("(#\u{1}", &format!("(#{prefix}")));
        svg.push_str("</svg>\n");
        svg
    }
}

fn corners(rect: Rect) -> Vec<Place> {
    let Rect { x, y, w, h } = rect;
    vec![(x, y), (x + w, y), (x + w, y + h), (x, y + h)]
}

/// A coordinate to a hundredth of a point.
fn number(value: f64) -> String {
    let text = format!("{value:.2}");
    let text = without_zeros(&text);
    if text == "-0" { "0".into() } else { text.into() }
}

fn path(points: &[Place], closed: bool) -> String {
    let mut d = String::new();
    for (i, (x, y)) in points.iter().enumerate() {
        let _ = write!(d, "{}{} {}", if i == 0 { "M" } else { "L" }, number(*x), number(*y));
    }
    if closed {
        d.push('Z');
    }
    d
}

fn stroke_attributes(stroke: &Stroke) -> String {
    let mut text = format!(
        "stroke=\"{}\" stroke-width=\"{}\" stroke-linejoin=\"round\"",
        stroke.color,
        number(stroke.width)
    );
    if !stroke.dash.is_empty() {
        let lengths: Vec<String> = stroke.dash.iter().map(|length| number(*length)).collect();
        let _ = write!(text, " stroke-dasharray=\"{}\"", lengths.join(" "));
    }
    text
}

fn hatch_id((hatch, ink): (Hatch, &'static str)) -> String {
    format!("{hatch:?}-{}", ink.trim_start_matches('#'))
}

fn pattern(hatching: (Hatch, &'static str), prefix: &str) -> String {
    let (hatch, ink) = hatching;
    let lines = |d: &str| format!("<path d=\"{d}\" stroke=\"{ink}\" stroke-width=\"0.6\" fill=\"none\"/>");
    // Diagonals of a tile of 4 points, and the corners of those next to it.
    let rising = lines("M-1 1L1 -1M0 4L4 0M3 5L5 3");
    let falling = lines("M-1 3L1 5M0 0L4 4M3 -1L5 1");
    let dot = |x: u8, y: u8| format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"0.5\" fill=\"{ink}\"/>");
    let content = match hatch {
        Hatch::Rising => rising,
        Hatch::Falling => falling,
        Hatch::Crossed => rising + &falling,
        Hatch::Dots => dot(1, 1) + &dot(3, 3),
    };
    let id = hatch_id(hatching);
    format!(
        "<pattern id=\"{prefix}{id}\" width=\"4\" height=\"4\" patternUnits=\"userSpaceOnUse\">{content}</pattern>\n"
    )
}

/// Width of a text in points.
pub fn text_width(text: &Rich, size: f64) -> f64 {
    // Another font draws a letter of which nothing is known; most are about this wide.
    let words =
        |words: &str, italic: bool| -> f64 { words.chars().map(|c| advance(c, italic).unwrap_or(0.6)).sum() };
    let symbol = |symbol: &Symbol| {
        words(&symbol.base, symbol.is_letter())
            + SMALL * (words(&symbol.index, false) + words(&symbol.exponent, false))
    };
    let pieces = text.pieces.iter().map(|piece| match piece {
        Piece::Words(text) => words(text, false),
        Piece::Symbol(s) => symbol(s),
        Piece::Formula(formula) => words(&formula.plain, false),
    });
    size * pieces.sum::<f64>()
}

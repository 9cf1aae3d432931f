//! Colours, lines and markers that can be distinguished with colour-blind eyes and in greyscale.
//!
//! The colours are those of Okabe and Ito. Lines differ in dash and marker as well, areas in lightness or
//! hatching.

use super::scene::{Marker, Stroke};

pub const BLACK: &str = "#000000";
pub const WHITE: &str = "#ffffff";
/// For less important elements.
pub const GREY: &str = "#8c8c8c";
/// Light grey, for guides.
pub const LIGHT_GREY: &str = "#c8c8c8";
pub const ORANGE: &str = "#e69f00";
pub const SKY: &str = "#56b4e9";
pub const GREEN: &str = "#009e73";
pub const YELLOW: &str = "#f0e442";
pub const BLUE: &str = "#0072b2";
pub const VERMILION: &str = "#d55e00";
pub const PURPLE: &str = "#cc79a7";
/// Wine, darker than all the colours above but black.
pub const WINE: &str = "#882255";

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LineStyle {
    pub stroke: Stroke,
    pub marker: Marker,
}

pub const fn style(color: &'static str, width: f64, dash: &'static [f64], marker: Marker) -> LineStyle {
    LineStyle { stroke: Stroke { color, width, dash }, marker }
}

/// The style of the line with this number: dotted, distinguished by its colour and its mark.
pub fn numbered(number: usize) -> LineStyle {
    const MARKERS: [Marker; 7] = [
        Marker::Circle,
        Marker::Square,
        Marker::Triangle,
        Marker::Diamond,
        Marker::TriangleDown,
        Marker::Plus,
        Marker::Cross,
    ];
    const COLORS: [&str; 7] = [VERMILION, BLUE, BLACK, ORANGE, GREEN, PURPLE, GREY];
    let number = number % MARKERS.len();
    style(COLORS[number], 0.8, &[1.0, 1.4], MARKERS[number])
}

/// The style of the curve with this number in a plot of several.
pub fn curve(number: usize) -> LineStyle {
    const STYLES: [LineStyle; 7] = [
        style(BLUE, 1.2, &[], Marker::Circle),
        style(VERMILION, 1.2, &[5.0, 2.0], Marker::Square),
        style(GREEN, 1.2, &[1.5, 1.5], Marker::Triangle),
        style(PURPLE, 1.2, &[5.0, 1.6, 1.2, 1.6], Marker::Diamond),
        style(BLACK, 1.2, &[2.6, 1.4], Marker::TriangleDown),
        style(ORANGE, 1.2, &[8.0, 2.0, 1.2, 2.0, 1.2, 2.0], Marker::Cross),
        style(SKY, 1.2, &[], Marker::Plus),
    ];
    STYLES[number % STYLES.len()]
}

/// Anchors of the colour map `viridis` of matplotlib, whose lightness rises evenly.
const VIRIDIS: [[u8; 3]; 11] = [
    [68, 1, 84],
    [72, 36, 117],
    [65, 68, 135],
    [53, 95, 141],
    [42, 120, 142],
    [33, 145, 140],
    [34, 168, 132],
    [68, 191, 112],
    [122, 209, 81],
    [189, 223, 38],
    [253, 231, 37],
];

/// Vermilion below, blue above, light in the middle: blue is presence, as in verdicts.
const DIVERGING: [[u8; 3]; 3] = [[213, 94, 0], [247, 247, 247], [0, 114, 178]];

fn between(anchors: &[[u8; 3]], unit: f64) -> String {
    let last = anchors.len() - 1;
    let at = unit.clamp(0.0, 1.0) * last as f64;
    let i = (at.floor() as usize).min(last.saturating_sub(1));
    let f = at - i as f64;
    let mix = |channel: usize| {
        let (a, b) = (f64::from(anchors[i][channel]), f64::from(anchors[(i + 1).min(last)][channel]));
        (a + f * (b - a)).round() as u8
    };
    format!("#{:02x}{:02x}{:02x}", mix(0), mix(1), mix(2))
}

/// The colour of a quantity between its minimum (0) and its maximum (1).
pub fn sequential(unit: f64) -> String {
    between(&VIRIDIS, unit)
}

/// The colour of a quantity with a sign: -1 to 1 is mapped to 0 to 1.
pub fn diverging(unit: f64) -> String {
    between(&DIVERGING, unit)
}

//! Colours, hatchings, dashes and markers that can be distinguished with colour-blind eyes and in greyscale.
//!
//! The colours are those of Okabe and Ito. Lines differ in dash and marker as well, areas in lightness or
//! hatching.

use std::borrow::Cow;

use super::scene::{Fill, Hatch, Marker, Stroke};
use slipmap_map::map::{Method, Regime, Verdict};

pub const BLACK: &str = "#000000";
pub(crate) const WHITE: &str = "#ffffff";
/// For less important elements.
pub const GREY: &str = "#8c8c8c";
/// Light grey, for guides.
pub(crate) const LIGHT_GREY: &str = "#c8c8c8";
pub(crate) const ORANGE: &str = "#e69f00";
pub(crate) const SKY: &str = "#56b4e9";
pub const GREEN: &str = "#009e73";
pub(crate) const YELLOW: &str = "#f0e442";
pub const BLUE: &str = "#0072b2";
pub const VERMILION: &str = "#d55e00";
pub(crate) const PURPLE: &str = "#cc79a7";
/// Wine, darker than all the colours above but black.
pub(crate) const WINE: &str = "#882255";

/// Style of a method's lines and marks.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MethodStyle {
    pub stroke: Stroke,
    pub marker: Marker,
}

const fn style(color: &'static str, width: f64, dash: &'static [f64], marker: Marker) -> MethodStyle {
    MethodStyle { stroke: Stroke { color, width, dash }, marker }
}

/// The style of a method. Those without one here have the style of a number, their place among all methods;
/// methods that this program does not know share one.
pub(crate) fn method(name: &str) -> MethodStyle {
    match name {
        "simulation" => style(BLACK, 1.3, &[], Marker::Circle),
        "perturbation" => style(VERMILION, 1.2, &[5.0, 2.0], Marker::Square),
        "instability" => style(SKY, 1.2, &[], Marker::Diamond),
        "bendixson_leading" => style(ORANGE, 1.2, &[1.2, 1.6], Marker::Cross),
        "bendixson" => style(PURPLE, 1.2, &[5.0, 1.6, 1.2, 1.6], Marker::TriangleDown),
        "symmetric" => style(BLUE, 1.2, &[2.6, 1.4], Marker::Triangle),
        "harmonic_balance" => style(GREEN, 1.2, &[8.0, 2.0, 1.2, 2.0, 1.2, 2.0], Marker::Plus),
        "validated" => style(WINE, 1.2, &[1.2, 1.2, 4.0, 1.2], Marker::Square),
        "universal_surface" => style(BLUE, 1.0, &[], Marker::Circle),
        "critical_surface" => style(GREEN, 1.0, &[], Marker::Diamond),
        "return_map" => style(BLACK, 1.0, &[], Marker::Circle),
        "auto" => style(PURPLE, 1.0, &[], Marker::TriangleDown),
        "direct" => style(VERMILION, 1.0, &[], Marker::Square),
        "smoothed" => style(ORANGE, 1.0, &[3.0, 1.5], Marker::Plus),
        "stick_band" => style(PURPLE, 1.0, &[3.0, 1.5], Marker::Diamond),
        "fixed_step" => style(SKY, 1.0, &[3.0, 1.5], Marker::Cross),
        "event_step" => style(GREEN, 1.0, &[3.0, 1.5], Marker::Triangle),
        _ => Method::all()
            .position(|method| method.name() == name)
            .map_or(style(GREY, 1.0, &[1.0, 1.0], Marker::Circle), numbered),
    }
}

/// The style of the method with this number: dotted, distinguished by its colour and its mark.
pub(crate) fn numbered(number: usize) -> MethodStyle {
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

pub const PRESENT: Fill = Fill::plain(BLUE);
pub const ABSENT: Fill = Fill::plain("#f7e3bf");
pub const UNDECIDED: Fill = Fill::hatched(WHITE, Hatch::Rising, "#b4b4b4");
/// Claims a cycle that does not exist.
pub const WRONG_PRESENCE: Fill = Fill::hatched(VERMILION, Hatch::Falling, WHITE);
/// Denies a cycle that exists.
pub const WRONG_ABSENCE: Fill = Fill::hatched(PURPLE, Hatch::Crossed, BLACK);
pub const FAILED: Fill = Fill::plain(BLACK);
pub const NOT_COMPUTED: Fill = Fill::hatched(WHITE, Hatch::Dots, BLACK);

/// The kind of a cell: its code in the map, its name there, its fill, and its name in legends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Kind {
    pub code: i8,
    pub name: &'static str,
    pub fill: Fill,
    pub words: Cow<'static, str>,
}

pub(crate) fn verdict(verdict: Verdict) -> Kind {
    let (fill, words) = match verdict {
        Verdict::Present => (PRESENT, "cycle exists"),
        Verdict::Absent => (ABSENT, "no cycle"),
        Verdict::Undecided => (UNDECIDED, "not decided"),
        Verdict::Failed => (FAILED, "failed"),
        Verdict::NotComputed => (NOT_COMPUTED, "not computed"),
    };
    Kind { code: verdict.code(), name: verdict.name(), fill, words: words.into() }
}

pub(crate) fn regime(regime: Regime) -> Kind {
    use Hatch::*;
    use Regime::*;
    let hatched = Fill::hatched;
    let (fill, words) = match regime {
        StickSlip => (PRESENT, "stick-slip"),
        Equilibrium => (ABSENT, "equilibrium (steady slip)"),
        Bistable => (hatched(SKY, Rising, BLACK), "bistable"),
        PureSlip => (hatched(GREEN, Falling, WHITE), "slip cycle"),
        Crossing => (hatched(VERMILION, Crossed, WHITE), "crossing for ever"),
        Failed => (FAILED, "failed"),
        Neutral => (hatched(WHITE, Dots, BLUE), "neutral steady slip"),
        PureSlipAndStickSlip => (hatched(YELLOW, Dots, BLACK), "slip cycle or stick-slip"),
        PureSlipAndEquilibrium => (hatched(WHITE, Falling, GREEN), "slip cycle or equilibrium"),
        EquilibriumPureSlipAndStickSlip => {
            (hatched(SKY, Crossed, GREEN), "equilibrium, slip cycle or stick-slip")
        }
        EquilibriumAndCrossing => (hatched(VERMILION, Rising, BLACK), "equilibrium or crossing for ever"),
        PureSlipAndCrossing => (hatched(VERMILION, Falling, GREEN), "slip cycle or crossing for ever"),
        EquilibriumPureSlipAndCrossing => {
            (hatched(VERMILION, Crossed, GREEN), "equilibrium, slip cycle or crossing for ever")
        }
        StickSlipAndCrossing => (hatched(BLUE, Crossed, VERMILION), "stick-slip or crossing for ever"),
        EquilibriumStickSlipAndCrossing => {
            (hatched(SKY, Crossed, VERMILION), "equilibrium, stick-slip or crossing for ever")
        }
        PureSlipStickSlipAndCrossing => {
            (hatched(YELLOW, Crossed, VERMILION), "slip cycle, stick-slip or crossing for ever")
        }
        EquilibriumPureSlipStickSlipAndCrossing => {
            (hatched(SKY, Dots, VERMILION), "equilibrium, slip cycle, stick-slip or crossing for ever")
        }
    };
    Kind { code: regime.code(), name: regime.name(), fill, words: words.into() }
}

pub fn verdicts() -> Vec<Kind> {
    Verdict::ALL.map(verdict).into()
}

pub fn regimes() -> Vec<Kind> {
    Regime::ALL.map(regime).into()
}

/// The kinds of cells of a variable of codes; `None` if it holds real numbers.
pub fn kinds(variable: &str) -> Option<Vec<Kind>> {
    match variable {
        "regime" => Some(regimes()),
        _ if variable.starts_with("verdict_") => Some(verdicts()),
        _ => None,
    }
}

/// Fill of the area in which a method decides: the colour of its lines, hatched to be distinguished in
/// greyscale. Plain blue means a cycle in other figures, and here a method decides its absence as well.
pub fn method_area(name: &str) -> Fill {
    match name {
        "instability" => Fill::hatched(SKY, Hatch::Rising, WHITE),
        "bendixson" => Fill::hatched(PURPLE, Hatch::Dots, BLACK),
        "symmetric" => Fill::hatched(WHITE, Hatch::Crossed, BLUE),
        "validated" => Fill::hatched(WINE, Hatch::Crossed, WHITE),
        "simulation" => Fill::hatched(WHITE, Hatch::Dots, BLACK),
        _ => Fill::hatched(method(name).stroke.color, Hatch::Falling, WHITE),
    }
}

/// The style of the curve with this number in a plot of several.
pub(crate) fn curve(number: usize) -> MethodStyle {
    const STYLES: [MethodStyle; 7] = [
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

//! The fills and lines of verdicts, regimes and methods.

use std::borrow::Cow;

use slipmap_column::{Method, Regime, Verdict};
use slipmap_figure::scene::{Fill, Hatch, Marker};
use slipmap_figure::style::{
    BLACK, BLUE, GREEN, GREY, LineStyle, ORANGE, PURPLE, SKY, VERMILION, WHITE, WINE, YELLOW, style,
};

/// The style of a method; those without one here share one.
pub fn method(name: &str) -> LineStyle {
    match name {
        "simulation" => style(BLACK, 1.3, &[], Marker::Circle),
        "perturbation" => style(VERMILION, 1.2, &[5.0, 2.0], Marker::Square),
        "instability" => style(SKY, 1.2, &[], Marker::Diamond),
        "bendixson_leading" => style(ORANGE, 1.2, &[1.2, 1.6], Marker::Cross),
        "bendixson" => style(PURPLE, 1.2, &[5.0, 1.6, 1.2, 1.6], Marker::TriangleDown),
        "symmetric" => style(BLUE, 1.2, &[2.6, 1.4], Marker::Triangle),
        "harmonic_balance" => style(GREEN, 1.2, &[8.0, 2.0, 1.2, 2.0, 1.2, 2.0], Marker::Plus),
        "validated" => style(WINE, 1.2, &[1.2, 1.2, 4.0, 1.2], Marker::Square),
        "critical_damping" => style(GREEN, 1.0, &[], Marker::Diamond),
        "direct" => style(VERMILION, 1.0, &[], Marker::Square),
        "smoothed" => style(ORANGE, 1.0, &[3.0, 1.5], Marker::Plus),
        "stick_band" => style(PURPLE, 1.0, &[3.0, 1.5], Marker::Diamond),
        "fixed_step" => style(SKY, 1.0, &[3.0, 1.5], Marker::Cross),
        "event_step" => style(GREEN, 1.0, &[3.0, 1.5], Marker::Triangle),
        _ => style(GREY, 1.0, &[1.0, 1.0], Marker::Circle),
    }
}

pub const PRESENT: Fill = Fill::plain(BLUE);
pub const ABSENT: Fill = Fill::plain("#f7e3bf");
pub const UNDECIDED: Fill = Fill::hatched(WHITE, Hatch::Rising, "#b4b4b4");
/// Claims a cycle that does not exist.
pub const WRONG_PRESENCE: Fill = Fill::hatched(VERMILION, Hatch::Falling, WHITE);
/// Denies a cycle that exists.
pub const WRONG_ABSENCE: Fill = Fill::hatched(PURPLE, Hatch::Crossed, BLACK);
/// Whether a fill is that of a wrong claim.
pub fn is_wrong(fill: Fill) -> bool {
    [WRONG_PRESENCE, WRONG_ABSENCE].contains(&fill)
}

pub const FAILED: Fill = Fill::plain(BLACK);
pub const NOT_COMPUTED: Fill = Fill::hatched(WHITE, Hatch::Dots, BLACK);

/// The kind of a cell: its code in the map, its name there, its fill, and its name in legends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct CellKind {
    pub code: i8,
    pub name: &'static str,
    pub fill: Fill,
    pub words: Cow<'static, str>,
}

pub fn verdict(verdict: Verdict) -> CellKind {
    let (fill, words) = match verdict {
        Verdict::Present => (PRESENT, "cycle exists"),
        Verdict::Absent => (ABSENT, "no cycle"),
        Verdict::Undecided => (UNDECIDED, "not decided"),
        Verdict::Failed => (FAILED, "failed"),
        Verdict::NotComputed => (NOT_COMPUTED, "not computed"),
    };
    CellKind { code: verdict.code(), name: verdict.name(), fill, words: words.into() }
}

pub fn regime(regime: Regime) -> CellKind {
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
    CellKind { code: regime.code(), name: regime.name(), fill, words: words.into() }
}

pub fn verdicts() -> Vec<CellKind> {
    Verdict::ALL.map(verdict).into()
}

pub fn regimes() -> Vec<CellKind> {
    Regime::ALL.map(regime).into()
}

/// The kinds of cells of a variable of codes; `None` if it holds real numbers.
pub fn kinds(variable: &str) -> Option<Vec<CellKind>> {
    match variable {
        "regime" => Some(regimes()),
        _ if variable.starts_with("verdict_") => Some(verdicts()),
        _ => None,
    }
}

/// The kinds of cells by the first of these methods that decides them: its position, else one of two negative codes, see
/// [`decider`].
pub fn deciders(methods: &[Method]) -> Vec<CellKind> {
    let decided = methods.iter().enumerate().map(|(code, method)| CellKind {
        code: code as i8,
        name: method.name(),
        fill: method_area(method.name()),
        words: match method {
            Method::Simulation => "simulation only".into(),
            _ => method.name().replace('_', " ").into(),
        },
    });
    let open = CellKind { code: NONE_DECIDES, name: "none", fill: UNDECIDED, words: "none of them".into() };
    let failed = CellKind { code: ONE_FAILS, ..verdict(Verdict::Failed) };
    decided.chain([open, failed]).collect()
}

/// Codes of cells that no method decides, and of those among them at which one fails.
const NONE_DECIDES: i8 = -1;
const ONE_FAILS: i8 = -2;

/// The code of a cell among [`deciders`], by the codes of the methods' verdicts in their order.
pub fn decider(verdicts: impl Iterator<Item = i8> + Clone) -> i8 {
    let decides = |code: i8| Verdict::of_code(code).is_some_and(Verdict::is_decision);
    match verdicts.clone().position(decides) {
        Some(first) => first as i8,
        None if verdicts.into_iter().any(|code| code == Verdict::Failed.code()) => ONE_FAILS,
        None => NONE_DECIDES,
    }
}

/// Fill of the area in which a method decides: the colour of its lines, hatched to be distinguished in
/// greyscale. Plain blue means a cycle in other figures, and here a method decides its absence as well.
fn method_area(name: &str) -> Fill {
    match name {
        "instability" => Fill::hatched(SKY, Hatch::Rising, WHITE),
        "bendixson" => Fill::hatched(PURPLE, Hatch::Dots, BLACK),
        "symmetric" => Fill::hatched(WHITE, Hatch::Crossed, BLUE),
        "validated" => Fill::hatched(WINE, Hatch::Crossed, WHITE),
        "simulation" => Fill::hatched(WHITE, Hatch::Dots, BLACK),
        _ => Fill::hatched(method(name).stroke.color, Hatch::Falling, WHITE),
    }
}

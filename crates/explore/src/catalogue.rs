//! The catalogue of the page: laws, methods, variables, and their colours.

use serde_json::{Value, json};

use super::place::with_all;
use slipmap_column::Method;
use slipmap_figure::scene::Fill;
use slipmap_figure::style;
pub use slipmap_figure::text::Rich;
use slipmap_map::Quantity;
use slipmap_model::friction::Law;
use slipmap_page::palette::{self, CellKind};
pub use slipmap_page::units::UnitSystem;

/// Meanings of the codes of a comparison of two methods.
pub(super) fn differences(a: &str, b: &str) -> Vec<CellKind> {
    let (a, b) = (a.replace('_', " "), b.replace('_', " "));
    let kinds = [
        ("both_present", "both: cycle exists".into(), palette::PRESENT),
        ("both_absent", "both: no cycle".into(), palette::ABSENT),
        ("only_first_present", format!("{a}: cycle exists, {b}: none"), palette::WRONG_PRESENCE),
        ("only_second_present", format!("{a}: no cycle, {b}: one exists"), palette::WRONG_ABSENCE),
        ("undecided", "one of them does not decide".into(), palette::UNDECIDED),
        ("failed", "one of them failed".into(), palette::FAILED),
    ];
    let kind = |(code, (name, words, fill)): (usize, (&'static str, String, Fill))| CellKind {
        code: code as i8,
        name,
        words: words.into(),
        fill,
    };
    kinds.into_iter().enumerate().map(kind).collect()
}

/// Codes and their meanings as JSON.
pub(super) fn kinds_json(kinds: &[CellKind]) -> Value {
    let one = |kind: &CellKind| {
        json!({
            "code": kind.code,
            "name": kind.name,
            "words": kind.words,
            "ground": kind.fill.ground,
            "hatch": kind.fill.hatch.map(|(hatch, _)| format!("{hatch:?}").to_lowercase()),
            "ink": kind.fill.hatch.map(|(_, ink)| ink),
        })
    };
    kinds.iter().map(one).collect()
}

/// Range and initial value of an axis' slider.
fn range_of(law: &Law, axis: &str) -> (f64, f64, f64) {
    let stribeck = *law.as_written() == Law::Stribeck;
    match axis {
        "epsilon" if stribeck => (0.0, 1.0, 0.2),
        "epsilon" => (0.0, 2.0, 1.0),
        "alpha" => (0.0, 1.0, 0.3),
        "beta" => (0.0, 0.5, 0.0),
        "gamma" => (0.0, 8.0, 2.0),
        "mu" if !matches!(law.as_written(), Law::Table(_)) => (0.0, 1.0, 0.5),
        "vs" => (0.0, 2.0, 0.5),
        "exponent" => (1.0, 4.0, 1.0),
        "drop" if *law.as_written() == Law::Coulomb => (0.0, 1.0, 0.3),
        "drop" => (0.0, 1.0, 0.0),
        "eta" => (0.0, 0.5, 0.0),
        "V" => (0.0, 3.0, 1.0),
        "c" if stribeck => (0.0, 4.0, 0.5),
        "c" => (0.0, 1.0, 0.1),
        // A name in a formula.
        _ => (0.0, 2.0, 0.5),
    }
}

/// The axes of a law and those that it may have besides, with the ranges of their sliders.
pub(super) fn axes(law: &Law) -> Value {
    let law = &with_all(law.clone(), |_| true);
    let grid_names = law.axis_names();
    let parameter = |name: &str| law.parameters().iter().find(|parameter| parameter.name == name);
    let fastest = match law.as_written() {
        Law::Table(table) => 0.5 * table.fastest(),
        _ => f64::INFINITY,
    };
    let one = |name: &&str| {
        let (from, to, value) = range_of(law, name);
        let (least, most, words) = match (*name, parameter(name)) {
            ("c", _) => (0.0, f64::INFINITY, "viscous damping"),
            ("V", _) => (0.0, fastest, "belt speed"),
            ("epsilon", _) => (0.0, f64::INFINITY, "size of the small terms"),
            (_, Some(parameter)) => (parameter.min, parameter.max, parameter.long_name),
            (_, None) => (f64::MIN, f64::MAX, ""),
        };
        let finite = |x: f64| (x.abs() < 1e300).then_some(x);
        // The smallest positive number stands for 0, which is illegal.
        let open = matches!(*name, "V" | "epsilon") || least == f64::MIN_POSITIVE;
        let least = if open { 0.0 } else { least };
        let to = to.min(most);
        json!({
            "name": name,
            "symbol": Rich::symbol(name).plain(),
            "words": words,
            // Legal values; null for no bound.
            "least": finite(least),
            "most": finite(most),
            "open": open,
            "from": from.max(least),
            "to": to,
            "value": value.min(0.5 * (from + to)),
        })
    };
    grid_names.iter().map(one).collect()
}

/// Everything that the page loads once.
pub(super) fn catalogue() -> Value {
    let law = |law: &Law| {
        let formula = slipmap_page::formula::of_law(law).map_or(String::new(), |formula| formula.plain);
        json!({ "name": law.name(), "formula": formula, "axes": axes(law) })
    };
    let quantities = Quantity::of_orbits().map(|quantity| {
        let words = UnitSystem::default().variable(quantity.name()).name.plain();
        json!({ "name": quantity.name(), "words": words })
    });
    let anchors = |color: fn(f64) -> String, count: u8| -> Vec<String> {
        (0..=count).map(|i| color(f64::from(i) / f64::from(count))).collect()
    };
    json!({
        "laws": Law::BUILT_IN.iter().map(law).collect::<Vec<_>>(),
        "methods": Method::all().map(|method| method.name()).collect::<Vec<_>>(),
        "quantities": quantities.collect::<Vec<_>>(),
        "regimes": kinds_json(&palette::regimes()),
        "verdicts": kinds_json(&palette::verdicts()),
        "sequential": anchors(style::sequential, 10),
        "diverging": anchors(style::diverging, 2),
    })
}

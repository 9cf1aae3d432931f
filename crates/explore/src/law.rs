//! A friction law as the page sends it, and back.

use serde_json::Value;

use super::refusal::Refusal;
use slipmap_config::{About, LawText};
use slipmap_model::friction::Law;

/// Largest number of characters of a formula.
const LONGEST_FORMULA: usize = 4096;

/// The law that the page describes.
pub(super) fn law_of(text: &LawText, about: About) -> Result<Law, Refusal> {
    if text.phi.as_ref().is_some_and(|phi| phi.len() > LONGEST_FORMULA) {
        let problem = format!("the formula has more than {LONGEST_FORMULA} characters");
        return Err(Refusal::bad_input(problem, "give the law as a table"));
    }
    // Axes that the law has not belong to the one before.
    let known = |axis: &&String| *axis != "drop" || may_have_drop(text, about);
    let axes = text.axes.iter().filter(known).cloned().collect();
    Ok(LawText { axes, ..text.clone() }.law(about)?)
}

/// Whether the law has room for the parameter `drop`, which is none of a machine.
fn may_have_drop(text: &LawText, about: About) -> bool {
    let plain = LawText { axes: Vec::new(), ..text.clone() };
    let has_room = |law: Law| slipmap_config::with_axes(law, |name| name == "drop").is_ok();
    about == About::Oscillator && plain.law(about).is_ok_and(has_room)
}

/// A dimensionless law as the page sends it.
pub(super) fn law_json(law: &Law) -> Value {
    json(LawText::of(law, About::Oscillator))
}

/// A law that was described; null if it cannot be.
pub(super) fn json(text: Option<LawText>) -> Value {
    text.and_then(|text| serde_json::to_value(text).ok()).unwrap_or_default()
}

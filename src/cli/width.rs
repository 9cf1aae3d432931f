//! The width of a figure, in columns of a journal.

use clap::builder::{PossibleValue, PossibleValuesParser, TypedValueParser};
use slipmap_figure::scene::Width;

/// The values of `--width`.
pub(super) const ONE: &str = "one-column";
pub(super) const TWO: &str = "two-columns";

/// Reads the width of a figure.
pub(super) fn width() -> impl TypedValueParser<Value = Width> {
    let width = |name: String| if name == ONE { Width::OneColumn } else { Width::TwoColumns };
    let values = [(ONE, "84 mm"), (TWO, "174 mm")];
    PossibleValuesParser::new(values.map(|(name, help)| PossibleValue::new(name).help(help))).map(width)
}

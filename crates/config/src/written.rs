//! Descriptions written as a configuration, so that the same is read again: to the last bit, but for a covariance,
//! which rounds.

use std::fmt::Write as _;

use slipmap_machine::RADIUS;
use slipmap_machine::risk::{Spread, Uncertain};
use slipmap_map::Shown;
use toml_edit::{Key, Value};

use super::axis::range_nodes;
use super::described::{FitText, LawText, Origin};
use super::machine::MachineJob;
use super::units::converted;

/// A text in quotes.
#[must_use]
pub fn quoted(text: &str) -> String {
    Value::from(text).to_string()
}

fn list(numbers: &[f64]) -> String {
    let numbers: Vec<String> = numbers.iter().map(|number| format!("{number:?}")).collect();
    format!("[{}]", numbers.join(", "))
}

/// Lines `key = value`.
#[derive(Default)]
struct Lines(String);

impl Lines {
    fn add(&mut self, key: &str, value: impl std::fmt::Display) {
        // Writing to a text cannot fail.
        let _ = writeln!(self.0, "{} = {value}", Key::new(key));
    }

    fn text(&mut self, key: &str, text: Option<&str>) {
        if let Some(text) = text {
            self.add(key, quoted(text));
        }
    }

    fn rows(&mut self, key: &str, rows: &[Vec<f64>]) {
        let rows: String = rows.iter().map(|row| format!("    {},\n", list(row))).collect();
        self.add(key, format_args!("[\n{rows}]"));
    }
}

impl LawText {
    /// The table `[friction]`; its axes have their values elsewhere.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut lines = Lines("[friction]\n".to_owned());
        lines.text("law", Some(&self.name));
        lines.text("phi", self.phi.as_deref());
        lines.text("file", self.file.as_deref());
        lines.text("quantity", self.quantity.as_deref());
        if let Some(level) = self.static_level {
            lines.add("static", format_args!("{level:?}"));
        }
        lines.text("rest", self.rest.as_deref());
        lines.text("small", self.small.then_some("eps"));
        if let Some(rows) = &self.rows {
            lines.rows("rows", rows);
        }
        if let Some(source) = &self.source {
            lines.0.push_str("\n[friction.source]\n");
            source.write(&mut lines);
        }
        if let Some(FitText { names, values, covariance }) = &self.fit {
            lines.0.push_str("\n[friction.fit]\n");
            names.iter().zip(values).for_each(|(name, value)| lines.add(name, format_args!("{value:?}")));
            lines.rows("covariance", covariance);
        }
        lines.0
    }
}

impl Origin {
    fn write(&self, lines: &mut Lines) {
        lines.text("file", Some(&self.file));
        if !self.lines.is_empty() {
            lines.add("lines", format_args!("{:?}", self.lines));
        }
        if let Some(readings) = self.readings {
            lines.add("readings", readings);
        }
        lines.text("told", self.told.as_deref());
        if self.named_errors {
            lines.add("named_errors", true);
        }
        if self.no_rest {
            lines.add("no_rest", true);
        }
    }
}

/// A number in SI units in the unit in which it is shown, if the same number is read again.
fn number(value: f64, shown: Option<&Shown>) -> String {
    let in_unit = shown.and_then(|Shown { unit, size }| {
        let near = value / size;
        let rounded = format!("{near:.11e}").parse().unwrap_or(near);
        let all = [rounded, near, near.next_up(), near.next_down()];
        let same = all.into_iter().find(|number| converted(*number, *size) == value)?;
        Some(quoted(&format!("{same:?} {unit}")))
    });
    in_unit.unwrap_or_else(|| format!("{value:?}"))
}

/// The nodes of an axis: a number, a range that has them, or a list.
#[must_use]
pub fn nodes(values: &[f64], shown: Option<&Shown>) -> String {
    let number = |value: f64| number(value, shown);
    let [first, .., last] = values else { return number(values[0]) };
    let spacings = [(false, ""), (true, ", spacing = \"log\"")];
    let is_range = |(log, _): &(bool, &str)| {
        (!log || *first > 0.0) && range_nodes(*first, *last, values.len(), *log) == values
    };
    match spacings.into_iter().find(is_range) {
        Some((_, spacing)) => {
            let (from, to, points) = (number(*first), number(*last), values.len());
            format!("{{ from = {from}, to = {to}, points = {points}{spacing} }}")
        }
        None => format!("[{}]", values.iter().copied().map(number).collect::<Vec<_>>().join(", ")),
    }
}

impl MachineJob {
    /// The configuration of the machine: its title, `[friction]` and `[machine]`; `None` where its friction cannot be
    /// written. What varies has no standard deviation.
    #[must_use]
    pub fn to_toml(&self) -> Option<String> {
        let law = LawText::of_machine(&self.machine, &self.uncertain)?;
        let mut lines = Lines::default();
        lines.text("title", self.title.as_deref());
        lines.0.push('\n');
        lines.0.push_str(&law.to_toml());
        lines.0.push_str("\n[machine]\n");
        lines.text("motion", Some(self.machine.motion.name()));
        if let Some(radius) = self.machine.given.disc() {
            lines.add(RADIUS, format_args!("{radius:?}"));
        }
        for (name, value) in self.machine.quantities() {
            let shown =
                self.units.iter().find(|(known, _)| *known == name).and_then(|(_, shown)| shown.as_ref());
            let varied = self.varied.iter().find(|(known, _)| *known == name);
            let written = match (varied, spread_of(&self.uncertain, name).map(|spread| spread.at(value))) {
                (Some((_, values)), _) => nodes(values, shown),
                // The fit has it.
                (None, Some(Spread::Joint { .. })) => continue,
                (None, Some(Spread::Normal { sd } | Spread::Relative { sd })) => {
                    format!("{{ value = {}, sd = {} }}", number(value, shown), number(sd, shown))
                }
                (None, Some(Spread::Uniform { min, max })) => {
                    let ends = format!("min = {}, max = {}", number(min, shown), number(max, shown));
                    match value == 0.5 * (min + max) {
                        true => format!("{{ {ends} }}"),
                        false => format!("{{ value = {}, {ends} }}", number(value, shown)),
                    }
                }
                (None, None) => number(value, shown),
            };
            lines.add(name, written);
        }
        Some(lines.0)
    }
}

fn spread_of(uncertain: &[Uncertain], name: &str) -> Option<Spread> {
    uncertain.iter().find(|(known, _)| *known == name).map(|(_, spread)| *spread)
}

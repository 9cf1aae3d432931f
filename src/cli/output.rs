//! Printing of numbers, aligned tables and JSON.

use std::io::{self, Write};

use indicatif::DecimalBytes;
use serde::Serialize;
use serde_json::{Value, json};

use super::{Ended, Failure};
pub(super) use slipmap_numbers::text::{count, exact, number_of, short, signed};

/// Formats a number of bytes in a fitting unit.
pub(super) fn bytes(n: u128) -> String {
    DecimalBytes(u64::try_from(n).unwrap_or(u64::MAX)).to_string()
}

/// Formats a duration in fitting units.
pub(super) fn duration(seconds: f64) -> String {
    if seconds < 1.0 {
        format!("{:.0} ms", seconds * 1e3)
    } else if seconds < 100.0 {
        format!("{seconds:.1} s")
    } else if seconds < 5400.0 {
        format!("{:.0} min", seconds / 60.0)
    } else if seconds < 172_800.0 {
        format!("{:.1} h", seconds / 3600.0)
    } else {
        format!("{:.1} days", seconds / 86_400.0)
    }
}

/// Replaces control characters, which a terminal would execute, in a text that may quote a file or a name.
pub(super) fn without_control_characters(text: &str) -> String {
    let obeyed = |c: char| c.is_control() && c != '\n' && c != '\t';
    text.chars().map(|c| if obeyed(c) { char::REPLACEMENT_CHARACTER } else { c }).collect()
}

/// Alignment of a column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Align {
    /// Words.
    Left,
    /// Numbers.
    Right,
}

/// A table whose columns are as wide as their widest cell.
#[derive(Debug)]
pub(super) struct TextTable {
    align: Vec<Align>,
    rows: Vec<Vec<String>>,
}

impl TextTable {
    /// A table with the given columns; an empty heading everywhere means none.
    pub(super) fn new(columns: &[(&str, Align)]) -> Self {
        let headings: Vec<String> = columns.iter().map(|(heading, _)| (*heading).to_owned()).collect();
        let rows = if headings.iter().all(String::is_empty) { Vec::new() } else { vec![headings] };
        Self { align: columns.iter().map(|(_, align)| *align).collect(), rows }
    }

    pub(super) fn row(&mut self, cells: impl IntoIterator<Item = String>) {
        self.rows.push(cells.into_iter().collect());
    }

    /// Writes the table, indented by two spaces.
    pub(super) fn write(&self, out: &mut dyn Write) -> io::Result<()> {
        let width = |column: usize| {
            self.rows.iter().filter_map(|row| row.get(column)).map(|cell| cell.chars().count()).max()
        };
        let widths: Vec<usize> = (0..self.align.len()).map(|column| width(column).unwrap_or(0)).collect();
        for row in &self.rows {
            let mut line = String::new();
            for ((cell, &width), align) in row.iter().zip(&widths).zip(&self.align) {
                line.push_str("  ");
                match align {
                    Align::Left => line.push_str(&format!("{cell:<width$}")),
                    Align::Right => line.push_str(&format!("{cell:>width$}")),
                }
            }
            writeln!(out, "{}", line.trim_end())?;
        }
        Ok(())
    }
}

/// Prints what a check has found: as JSON, or as text, `what` was checked and its problems, or, without
/// problems, the text `sound`.
pub(super) fn checked(
    as_json: bool,
    json: &Value,
    what: &str,
    problems: &[String],
    sound: &str,
) -> Result<Ended, Failure> {
    if as_json {
        print_json(json)?;
    } else {
        let mut out = io::stdout().lock();
        match problems.len() {
            0 => writeln!(out, "{what}\nsound: {sound}")?,
            n => writeln!(out, "{what}\n{}:", number_of(n, "problem"))?,
        }
        problems.iter().try_for_each(|problem| writeln!(out, "  {}", without_control_characters(problem)))?;
    }
    Ok(if problems.is_empty() { Ended::Fine } else { Ended::Flawed })
}

/// A JSON object with these entries, in their order.
pub(super) fn object<'a, V: Serialize>(entries: impl IntoIterator<Item = (&'a str, V)>) -> Value {
    entries.into_iter().map(|(name, value)| (name.to_owned(), json!(value))).collect()
}

/// Prints `value` as JSON. Numbers that are not finite become null.
pub(super) fn print_json(value: &impl Serialize) -> Result<(), Failure> {
    let text = serde_json::to_string_pretty(value)
        .map_err(|error| Failure::Broken(format!("cannot form the JSON: {error}")))?;
    Ok(writeln!(io::stdout().lock(), "{text}")?)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn counts_and_sizes_read_well() {
        assert_eq!(count(1_234_567_u64), "1,234,567");
        assert_eq!(count(999_u64), "999");
        assert_eq!(bytes(1_234_567), "1.23 MB");
    }

    #[test]
    fn tables_align() {
        let mut table = TextTable::new(&[("name", Align::Left), ("n", Align::Right)]);
        table.row(["a".into(), "10".into()]);
        table.row(["longer".into(), "1".into()]);
        let mut text = Vec::new();
        table.write(&mut text).unwrap();
        assert_eq!(String::from_utf8(text).unwrap(), "  name     n\n  a       10\n  longer   1\n");
    }
}

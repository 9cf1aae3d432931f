//! Tables as CSV, harmless for terminals and spreadsheets.

/// A table as CSV: its heading and its rows, of the same length. No cell is a formula for a spreadsheet.
pub fn csv_text(heading: Vec<String>, rows: impl Iterator<Item = Vec<String>>) -> String {
    let mut writer = csv::Writer::from_writer(Vec::new());
    for record in std::iter::once(heading).chain(rows) {
        // Writing to memory does not fail.
        let _ = writer.write_record(record.iter().map(|cell| csv_cell(cell)));
    }
    let bytes = writer.into_inner().unwrap_or_default();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Words in a cell of a CSV file, made harmless for terminals and spreadsheets: no control characters, and an
/// apostrophe before text that a spreadsheet would take for a formula.
fn csv_cell(words: &str) -> String {
    let text: String = words.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    if is_formula(&text) { format!("'{text}") } else { text }
}

/// Returns whether a spreadsheet would take a cell for a formula: what begins as one, but for numbers and
/// ranges of numbers.
pub fn is_formula(cell: &str) -> bool {
    let cell = cell.trim();
    match cell.chars().next() {
        Some('=' | '@') => true,
        Some('+' | '-') => cell.len() > 1 && cell.split(" to ").any(|part| part.parse::<f64>().is_err()),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_in_csv_are_not_executed() {
        for formula in
            ["=cmd|' /C calc'!A0", " @x", "-2+3+cmd|' /C calc'!A0", "+1-1+x!A0", "-.5e3*A1", "-x", "-1 to A1"]
        {
            assert_eq!(csv_cell(formula), format!("'{formula}"));
        }
        assert_eq!(csv_cell("\x1b[2J\n@x"), " [2J @x");
        for plain in ["-0.5 to 1", "+.5", "-1.5e-300", "a = b", "-", ""] {
            assert_eq!(csv_cell(plain), plain);
        }
        let rows = [vec!["-2+3+cmd|x!A0".into(), "-1e-5".into()]].into_iter();
        let text = csv_text(vec!["=x".into(), "y".into()], rows);
        assert_eq!(text, "'=x,y\n'-2+3+cmd|x!A0,-1e-5\n", "cells of every table, and of its heading");
    }
}

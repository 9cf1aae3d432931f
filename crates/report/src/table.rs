//! A table independent of formats, and its formats: HTML, LaTeX and CSV.

mod latex;

use slipmap_figure::text::{Rich, html, rich};
use slipmap_numbers::text::{in_groups, scientific, without_zeros};

#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Words, possibly from the map file.
    Words(String),
    Rich(Rich),
    Count(u64),
    Real(f64),
    Missing,
}

impl From<Option<f64>> for Cell {
    fn from(value: Option<f64>) -> Self {
        value.filter(|value| value.is_finite()).map_or(Cell::Missing, Cell::Real)
    }
}

impl From<Option<u64>> for Cell {
    fn from(value: Option<u64>) -> Self {
        value.map_or(Cell::Missing, Cell::Count)
    }
}

/// Format of the numbers of a column. It does not apply to CSV, which holds all digits.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Show {
    /// Words or counts.
    AsIs,
    Significant(usize),
    /// At most this many significant digits, zeros at the end dropped: for parameters.
    Trimmed(usize),
    Decimals(usize),
    /// With a power of ten.
    Scientific(usize),
}

#[derive(Clone, Debug)]
pub struct Column {
    /// Its name in CSV files.
    pub key: String,
    pub(crate) heading: Rich,
    /// Format of its numbers.
    pub(crate) show: Show,
}

impl Column {
    /// A column with a name for CSV files and a heading for the other formats.
    pub(crate) fn new(key: &str, heading: &str, show: Show) -> Self {
        Self { key: key.into(), heading: rich(heading), show }
    }
}

#[derive(Clone, Debug)]
pub struct Table {
    /// Name of its files, and of its label in LaTeX.
    pub name: &'static str,
    pub(crate) caption: Rich,
    pub columns: Vec<Column>,
    /// The rows, each with one cell per column.
    pub rows: Vec<Vec<Cell>>,
    /// Remarks below it.
    pub(crate) notes: Vec<Rich>,
}

/// A column of a table with a row for each `T`: its name for CSV files, its heading, the format of its
/// numbers, and its cell.
pub(crate) type ColumnOf<'a, T> = (&'a str, &'a str, Show, &'a dyn Fn(&T) -> Cell);

/// A number as shown: a decimal, and a power of ten if that is not 0.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Decimal {
    mantissa: String,
    exponent: i32,
}

/// Range of numbers that are shown without a power of ten. In LaTeX, where numbers are aligned, one number
/// outside of it gives the whole column a power of ten.
const PLAIN: std::ops::Range<f64> = 1e-3..1e6;

impl Table {
    /// A table with a row for each item, without notes.
    pub(crate) fn of<T>(name: &'static str, caption: Rich, items: &[T], columns: &[ColumnOf<T>]) -> Self {
        let row = |item: &T| columns.iter().map(|(.., cell)| cell(item)).collect();
        Self {
            name,
            caption,
            columns: columns.iter().map(|(key, heading, show, _)| Column::new(key, heading, *show)).collect(),
            rows: items.iter().map(row).collect(),
            notes: Vec::new(),
        }
    }

    /// Drops a column, if the table has it.
    pub(crate) fn drop_column(&mut self, key: &str) {
        let Some(at) = self.columns.iter().position(|column| column.key == key) else { return };
        self.columns.remove(at);
        self.rows.iter_mut().for_each(|row| drop(row.remove(at)));
    }

    /// Keeps the rows of these methods and eps, of all where a list is empty. One eps moves from its column to the
    /// caption.
    pub(crate) fn keep(&mut self, methods: &[String], epsilons: &[f64]) {
        let column = |key: &str| self.columns.iter().position(|column| column.key == key);
        if let Some(at) = column("method").filter(|_| !methods.is_empty()) {
            self.rows.retain(|row| methods.iter().any(|method| row[at] == Cell::Words(method.clone())));
        }
        let Some(at) = column("epsilon").filter(|_| !epsilons.is_empty()) else { return };
        self.rows.retain(|row| epsilons.iter().any(|epsilon| row[at] == Cell::Real(*epsilon)));
        if let [epsilon] = epsilons {
            self.drop_column("epsilon");
            self.caption = std::mem::take(&mut self.caption)
                .then(rich(" At {epsilon} = "))
                .then(Rich::number(*epsilon, 4))
                .then(".");
        }
    }

    /// Returns whether a column holds numbers.
    fn is_numeric(&self, column: usize) -> bool {
        self.rows.iter().any(|row| matches!(row[column], Cell::Count(_) | Cell::Real(_)))
            && !self.rows.iter().any(|row| matches!(row[column], Cell::Words(_) | Cell::Rich(_)))
    }

    /// The format of the numbers of a column that are aligned; `None` for words.
    fn aligned(&self, column: usize) -> Option<Show> {
        let plain = self.rows.iter().all(|row| match row[column] {
            Cell::Real(value) => is_plain(value),
            _ => true,
        });
        self.is_numeric(column).then(|| match self.columns[column].show {
            Show::Significant(digits) | Show::Trimmed(digits) if !plain => Show::Scientific(digits),
            show => show,
        })
    }

    pub fn html(&self) -> String {
        let classes: Vec<&str> = (0..self.columns.len())
            .map(|column| if self.is_numeric(column) { " class=\"number\"" } else { "" })
            .collect();
        // Words longer than a line may be broken anywhere; others may not.
        let is_long = |words: &str| words.split(' ').any(|word| word.chars().count() > LONGEST_WORD);
        let mut text = format!("<table>\n<caption>{}</caption>\n<thead><tr>", self.caption.html());
        for (column, class) in self.columns.iter().zip(&classes) {
            text.push_str(&format!("<th scope=\"col\"{class}>{}</th>", column.heading.html()));
        }
        text.push_str("</tr></thead>\n<tbody>\n");
        for row in &self.rows {
            text.push_str("<tr>");
            for ((cell, column), class) in row.iter().zip(&self.columns).zip(&classes) {
                let shown = match cell {
                    Cell::Words(words) => html(words),
                    Cell::Rich(text) => text.html(),
                    _ => shown(cell, column.show),
                };
                let class = match cell {
                    Cell::Words(words) if is_long(words) => " class=\"long\"",
                    _ => class,
                };
                text.push_str(&format!("<td{class}>{shown}</td>"));
            }
            text.push_str("</tr>\n");
        }
        text.push_str("</tbody>\n</table>\n");
        for note in &self.notes {
            text.push_str(&format!("<p class=\"note\">{}</p>\n", note.html()));
        }
        text
    }

    /// As CSV, numbers with all digits.
    pub fn csv(&self) -> String {
        let heading = self.columns.iter().map(|column| column.key.clone()).collect();
        slipmap_files::csv::csv_text(heading, self.rows.iter().map(|row| row.iter().map(in_full).collect()))
    }
}

/// Longest word that is not broken; longer ones, such as fingerprints, may be broken anywhere.
const LONGEST_WORD: usize = 40;

/// A cell of a CSV file.
fn in_full(cell: &Cell) -> String {
    match cell {
        Cell::Words(words) => words.clone(),
        Cell::Rich(text) => text.plain(),
        Cell::Count(count) => count.to_string(),
        Cell::Real(value) => format!("{value:?}"),
        Cell::Missing => String::new(),
    }
}

/// Returns whether a number is shown without a power of ten.
fn is_plain(value: f64) -> bool {
    value == 0.0 || PLAIN.contains(&value.abs())
}

/// A number in the format of its column.
fn decimal(cell: &Cell, show: Show) -> Option<Decimal> {
    let plain = |mantissa: String| Some(Decimal { mantissa, exponent: 0 });
    let power = |value: f64, digits: usize| {
        let (mantissa, exponent) = scientific(value, digits);
        Some(Decimal { mantissa, exponent })
    };
    let value = match *cell {
        Cell::Count(count) if show == Show::AsIs => return plain(count.to_string()),
        Cell::Count(count) => count as f64,
        Cell::Real(value) if value.is_finite() => value,
        Cell::Real(_) | Cell::Words(_) | Cell::Rich(_) | Cell::Missing => return None,
    };
    match show {
        Show::AsIs => plain(format!("{value}")),
        Show::Decimals(digits) => plain(format!("{value:.digits$}")),
        Show::Significant(_) | Show::Trimmed(_) | Show::Scientific(_) if value == 0.0 => plain("0".into()),
        Show::Significant(digits) | Show::Trimmed(digits) if !is_plain(value) => power(value, digits),
        Show::Trimmed(digits) => {
            plain(without_zeros(&decimal(cell, Show::Significant(digits))?.mantissa).to_owned())
        }
        Show::Significant(digits) => {
            let exponent = scientific(value, digits).1;
            let decimals = (digits as i32 - 1 - exponent).max(0) as usize;
            plain(format!("{value:.decimals$}"))
        }
        Show::Scientific(digits) => power(value, digits),
    }
}

/// Digits in groups of three, set apart by thin spaces.
fn grouped(mantissa: &str) -> String {
    let (whole, decimals) = mantissa.split_once('.').map_or((mantissa, None), |(w, d)| (w, Some(d)));
    let digits = whole.trim_start_matches('-');
    let text = if digits.len() > 4 { in_groups(digits, '\u{202f}') } else { digits.to_owned() };
    let sign = if whole.starts_with('-') { "−" } else { "" };
    match decimals {
        Some(decimals) => format!("{sign}{text}.{decimals}"),
        None => format!("{sign}{text}"),
    }
}

/// A number in HTML, with its power of ten if there is one.
fn shown(cell: &Cell, show: Show) -> String {
    match decimal(cell, show) {
        None => "–".into(),
        Some(Decimal { mantissa, exponent: 0 }) => grouped(&mantissa),
        Some(Decimal { mantissa, exponent }) => grouped(&mantissa) + &html_power(exponent),
    }
}

fn html_power(exponent: i32) -> String {
    let sign = if exponent < 0 { "−" } else { "" };
    format!(" × 10<sup>{sign}{}</sup>", exponent.unsigned_abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn table() -> Table {
        let column = Column::new;
        Table {
            name: "example",
            caption: rich("Errors in {c}."),
            columns: vec![
                column("method", "method", Show::AsIs),
                column("cells", "cells", Show::AsIs),
                column("share", "%", Show::Decimals(1)),
                column("error", "error", Show::Significant(3)),
            ],
            rows: vec![
                vec![
                    Cell::Words("a_b".into()),
                    Cell::Count(1_234_567),
                    Cell::Real(12.345),
                    Cell::Real(-1.5e-7),
                ],
                vec![Cell::Words("c|d".into()), Cell::Count(0), Cell::Missing, Cell::Real(0.25)],
            ],
            notes: vec![],
        }
    }

    #[test]
    fn each_format_has_the_same_contents() {
        let table = table();
        let html = table.html();
        let number = |text: &str| format!("<td class=\"number\">{text}</td>");
        let row = ["1\u{202f}234\u{202f}567", "12.3", "−1.50 × 10<sup>−7</sup>"].map(number).concat();
        assert!(html.contains(&format!("<td>a_b</td>{row}")), "{html}");
        assert!(
            html.contains(&format!("<td>c|d</td>{}", ["0", "–", "0.250"].map(number).concat())),
            "{html}"
        );
        let latex = table.latex();
        assert!(latex.contains("a\\_b & 1234567 & 12.3 & -1.50e-7 \\\\"), "{latex}");
        assert!(latex.contains("c\\textbar{}d & 0 & {--} & 2.50e-1 \\\\"), "{latex}");
        assert!(
            latex.contains("{lS[table-format=7.0]S[table-format=2.1]S[table-format=-1.2e-1]}"),
            "{latex}"
        );
        assert_eq!(
            table.csv(),
            "method,cells,share,error\na_b,1234567,12.345,-1.5e-7\nc|d,0,,0.25\n",
            "CSV holds numbers in full"
        );
    }

    /// Six eps and eight methods: two parts, cut between two eps, with one label.
    #[test]
    fn a_tall_table_has_parts_and_rows_can_be_chosen() {
        let mut table = table();
        table.columns.insert(0, Column::new("epsilon", "{epsilon}", Show::Trimmed(4)));
        table.rows = (0..48_u32)
            .map(|row| {
                let (epsilon, method) = (0.1 * f64::from(row / 8 + 1), format!("m{}", row % 8));
                vec![Cell::Real(epsilon), Cell::Words(method), Cell::Count(1), Cell::Real(1.0), Cell::Missing]
            })
            .collect();
        let latex = table.latex();
        let parts: Vec<&str> = latex.split("\\end{table").collect();
        let rows = |part: &str| part.lines().filter(|line| line.contains(" & m")).count();
        assert_eq!((rows(parts[0]), rows(parts[1]), parts.len()), (40, 8, 3), "{latex}");
        assert_eq!(latex.matches("\\label{").count(), 1);

        table.keep(&["m3".into(), "m5".into()], &[0.1, 0.2]);
        assert_eq!((table.rows.len(), table.columns.len()), (4, 5));
        table.keep(&[], &[0.2]);
        let left: Vec<&Cell> = table.rows.iter().map(|row| &row[0]).collect();
        assert_eq!(left, [&Cell::Words("m3".into()), &Cell::Words("m5".into())]);
        assert!(table.caption.plain().ends_with("= 0.2."), "{:?}", table.caption);
    }
}

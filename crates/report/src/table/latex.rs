//! A table in LaTeX, as wide as a column of a two-column article or, where it needs them, as both.
//!
//! The width is estimated from the numbers of characters. Headings are broken into lines as wide as their
//! columns; long words share the width that numbers leave, in paragraphs.

use super::{Cell, Decimal, LONGEST_WORD, Show, Table, decimal};
use slipmap_figure::text::{Piece, Rich, latex};

/// Most rows of a part of a table: with heading, caption and notes they fill a page of an article.
const MOST_ROWS: usize = 42;
/// A power of ten takes as much room as this many characters.
const POWER: usize = 6;
/// Longest words that are kept on one line.
const SHORT: usize = 22;
/// Fewest characters of a paragraph, and most lines.
const NARROWEST: f64 = 15.0;
const MOST_LINES: f64 = 5.0;

/// A layout; lengths in points.
struct Layout {
    environment: &'static str,
    font: &'static str,
    /// Width of a line.
    line: f64,
    /// Gap between columns.
    gap: f64,
    /// Mean width of a character.
    character: f64,
}

/// In one column of a two-column article.
const ONE_COLUMN: Layout =
    Layout { environment: "table", font: "footnotesize", line: 229.0, gap: 3.0, character: 4.5 };
/// Over both columns, in a font in which the widest table fits.
const BOTH_COLUMNS: Layout =
    Layout { environment: "table*", font: "scriptsize", line: 469.0, gap: 1.5, character: 4.2 };

/// A column before the layout is chosen.
struct Width {
    /// Its type in `tabular`, unless it is set in paragraphs.
    kind: String,
    /// Number of characters of its widest cell.
    cells: usize,
    /// Whether its cells may be set in paragraphs.
    breaks: bool,
    heading: Vec<Rich>,
}

impl Width {
    fn characters(&self) -> usize {
        self.heading.iter().map(|line| line.plain().chars().count()).fold(self.cells, usize::max)
    }
}

/// The share of a line that each paragraph gets, or `None` if there are none, and whether the table fits.
fn fit(columns: &[Width], layout: &Layout) -> (Option<f64>, bool) {
    let Layout { line, gap, character, .. } = *layout;
    let gaps = 2.0 * gap * columns.len() as f64;
    let width = |of: &[&Width]| of.iter().map(|of| of.characters() as f64 * character).sum::<f64>();
    let (long, short): (Vec<&Width>, Vec<&Width>) = columns.iter().partition(|of| of.breaks);
    let room = line - gaps - width(&short);
    if long.is_empty() || width(&long) <= room {
        return (None, width(&long) <= room);
    }
    let each = room / long.len() as f64;
    let lines = long.iter().map(|of| of.cells as f64 * character / each).fold(0.0, f64::max);
    let fits = each >= NARROWEST * character && lines <= MOST_LINES;
    (Some((each.max(NARROWEST * character) + 2.0 * gap) / line), fits)
}

impl Table {
    /// As a LaTeX `table` for `\input`; needs `booktabs` and `siunitx`.
    pub fn latex(&self) -> String {
        let shows: Vec<Option<Show>> = (0..self.columns.len()).map(|column| self.aligned(column)).collect();
        let columns: Vec<Width> =
            shows.iter().enumerate().map(|(column, show)| self.width(column, *show)).collect();
        let layout = if fit(&columns, &ONE_COLUMN).1 { ONE_COLUMN } else { BOTH_COLUMNS };
        let share = fit(&columns, &layout).0;
        let Layout { environment, font, line, gap, character } = layout;
        let begin = format!(
            "\\begin{{{environment}}}\n\\centering\n\\{font}\n\\setlength{{\\tabcolsep}}{{{gap}pt}}\n\
             \\setlength{{\\belowcaptionskip}}{{4pt}}\n\\emergencystretch=2em\n"
        );
        let mut head = String::from("\\begin{tabular}{");
        // Characters of the longest word that is not broken, by column.
        let longest = |of: &Width| match share {
            Some(share) if of.breaks => ((share * line / character) as usize).min(LONGEST_WORD),
            _ => LONGEST_WORD,
        };
        for of in &columns {
            match share {
                // The gaps on both sides are part of the line, too.
                Some(share) if of.breaks => head.push_str(&format!(
                    ">{{\\raggedright\\arraybackslash}}p{{\\dimexpr{share:.3}\\linewidth-2\\tabcolsep\\relax}}"
                )),
                _ => head.push_str(&of.kind),
            }
        }
        head.push_str("}\n\\toprule\n");
        let headings: Vec<String> = columns.iter().map(stacked).collect();
        head.push_str(&format!("{} \\\\\n\\midrule\n", headings.join(" & ")));
        let line_of = |row: &Vec<Cell>| {
            let cells: Vec<String> = row
                .iter()
                .zip(&shows)
                .zip(&columns)
                .map(|((cell, show), of)| match cell {
                    Cell::Words(words) => breakable(words, longest(of)),
                    Cell::Rich(text) => text.latex(),
                    Cell::Missing if show.is_none() => "--".into(),
                    Cell::Missing => "{--}".into(),
                    _ => match decimal(cell, show.unwrap_or(Show::AsIs)) {
                        Some(Decimal { mantissa, exponent: 0 })
                            if !matches!(show, Some(Show::Scientific(_))) =>
                        {
                            mantissa
                        }
                        Some(Decimal { mantissa, exponent }) => format!("{mantissa}e{exponent}"),
                        None => "{--}".into(),
                    },
                })
                .collect();
            format!("{} \\\\\n", cells.join(" & "))
        };
        let notes = self
            .notes
            .iter()
            .map(|note| format!("\\par\\smallskip{{\\footnotesize {}\\par}}\n", note.latex()));
        let notes: String = notes.collect();
        let parts = parts(&self.rows);
        let mut text = String::from("% Needs \\usepackage{booktabs} and \\usepackage{siunitx}.\n");
        for (number, rows) in parts.iter().enumerate() {
            let caption = match number {
                0 => format!("\\caption{{{}}}\n\\label{{tab:slipmap-{}}}\n", self.caption.latex(), self.name),
                _ => "\\addtocounter{table}{-1}\n\\caption{(continued)}\n".to_owned(),
            };
            let rows: String = rows.iter().map(line_of).collect();
            let notes = if number + 1 == parts.len() { notes.as_str() } else { "" };
            text.push_str(&format!(
                "{begin}{caption}{head}{rows}\\bottomrule\n\\end{{tabular}}\n{notes}\\end{{{environment}}}\n"
            ));
        }
        text
    }

    /// The width of a column, and its type in `tabular`: that which fits the widest number.
    fn width(&self, column: usize, show: Option<Show>) -> Width {
        let heading = &self.columns[column].heading;
        let Some(show) = show else {
            let lengths = self.rows.iter().map(|row| match &row[column] {
                Cell::Words(words) => words.chars().count(),
                Cell::Rich(text) => text.plain().chars().count(),
                Cell::Count(count) => count.to_string().len(),
                _ => 2,
            });
            let cells = lengths.max().unwrap_or(0);
            let heading = lines_of(heading, cells);
            return Width { kind: "l".into(), cells, breaks: cells > SHORT, heading };
        };
        let numbers: Vec<Decimal> = self.rows.iter().filter_map(|row| decimal(&row[column], show)).collect();
        let widest = |count: fn(&Decimal) -> usize| numbers.iter().map(count).max().unwrap_or(1);
        let whole = widest(|n| n.mantissa.trim_start_matches('-').split('.').next().map_or(1, str::len));
        let decimals = widest(|n| n.mantissa.split_once('.').map_or(0, |(_, decimals)| decimals.len()));
        let exponent = widest(|n| n.exponent.unsigned_abs().to_string().len());
        let sign = if numbers.iter().any(|n| n.mantissa.starts_with('-')) { "-" } else { "" };
        let mut cells = 2 * sign.len() + whole + usize::from(decimals > 0) + decimals;
        let kind = match show {
            Show::Scientific(_) => {
                let down = if numbers.iter().any(|n| n.exponent < 0) { "-" } else { "" };
                cells += POWER;
                format!("S[table-format={sign}{whole}.{decimals}e{down}{exponent}]")
            }
            _ => format!("S[table-format={sign}{whole}.{decimals}]"),
        };
        Width { kind, cells, breaks: false, heading: lines_of(heading, cells) }
    }
}

/// The rows of each part of a table, none taller than a page; cut where the first cell changes, if it does.
fn parts(rows: &[Vec<Cell>]) -> Vec<&[Vec<Cell>]> {
    let (mut parts, mut rest) = (Vec::new(), rows);
    while rest.len() > MOST_ROWS {
        let changes = |row: &usize| rest[*row][0] != rest[row - 1][0];
        let cut = (1..=MOST_ROWS).rev().find(changes).unwrap_or(MOST_ROWS);
        let (part, after) = rest.split_at(cut);
        parts.push(part);
        rest = after;
    }
    parts.push(rest);
    parts
}

/// A heading in lines of at most `width` characters, but for longer words. What follows the last comma, a
/// unit, is not broken.
fn lines_of(heading: &Rich, width: usize) -> Vec<Rich> {
    let mut words: Vec<Rich> = vec![Rich::default()];
    let last = heading.pieces.len().saturating_sub(1);
    for (number, piece) in heading.pieces.iter().enumerate() {
        let Piece::Words(text) = piece else {
            words.last_mut().into_iter().for_each(|word| word.pieces.push(piece.clone()));
            continue;
        };
        let (name, unit) = match text.rsplit_once(", ") {
            Some((name, unit)) if number == last => (format!("{name},"), Some(unit)),
            _ => (text.clone(), None),
        };
        for (i, part) in name.split(' ').chain(unit).enumerate() {
            if i > 0 {
                words.push(Rich::default());
            }
            if !part.is_empty() {
                words.last_mut().into_iter().for_each(|word| word.pieces.push(Piece::Words(part.to_owned())));
            }
        }
    }
    let length = |text: &Rich| text.plain().chars().count();
    let widest = words.iter().map(length).fold(width, usize::max);
    let mut lines: Vec<Rich> = Vec::new();
    for word in words.into_iter().filter(|word| !word.pieces.is_empty()) {
        match lines.last_mut() {
            Some(line) if length(line) + 1 + length(&word) <= widest => {
                *line = std::mem::take(line).then(" ").then(word);
            }
            _ => lines.push(word),
        }
    }
    lines
}

/// The heading of a column, in as many lines as it has.
fn stacked(of: &Width) -> String {
    let side = if of.kind == "l" { "l" } else { "c" };
    match of.heading.as_slice() {
        [] => "{}".into(),
        [line] => format!("{{{}}}", line.latex()),
        lines => {
            let lines: Vec<String> = lines.iter().map(Rich::latex).collect();
            format!("{{\\begin{{tabular}}[b]{{@{{}}{side}@{{}}}}{}\\end{{tabular}}}}", lines.join("\\\\"))
        }
    }
}

/// Words for LaTeX, with places at which words longer than `longest` characters may be broken.
fn breakable(words: &str, longest: usize) -> String {
    let parts = words.split(' ').map(|word| match word.is_ascii() && word.len() > longest {
        true => {
            word.as_bytes().chunks(8).map(|part| latex(&String::from_utf8_lossy(part))).collect::<Vec<_>>()
        }
        false => vec![latex(word)],
    });
    parts.map(|parts| parts.join("\\allowbreak{}")).collect::<Vec<_>>().join(" ")
}

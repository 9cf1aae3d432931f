//! Measured data as text: the encoding, the separator of columns, the decimal sign, the fields.

use super::{Refused, columns};

/// The fields of one line.
pub(super) struct Line {
    /// Its number in the file, from 1.
    pub(super) number: usize,
    pub(super) fields: Vec<String>,
}

/// A file as fields.
pub(super) struct Fields {
    /// The lines that are neither empty nor comments.
    pub(super) lines: Vec<Line>,
    /// The position of the first one that has numbers where most have.
    pub(super) first: usize,
    pub(super) decimal: Decimal,
    /// The comments, each as it is divided by several separators: one may be the header.
    pub(super) comments: Vec<Vec<Line>>,
    /// What is unusual in it: "separated by semicolons".
    pub(super) said: Vec<String>,
}

/// The sign before the decimals; the other one separates thousands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Decimal {
    Point,
    Comma,
}

/// The bytes from 0x80 on in which windows-1252 differs from Latin 1.
const WINDOWS_1252: &str = "€\u{81}‚ƒ„…†‡ˆ‰Š‹Œ\u{8d}Ž\u{8f}\u{90}‘’“”•–—˜™š›œ\u{9d}žŸ";

/// The text of a file, and the encoding if it is not UTF-8.
pub(super) fn decode(bytes: &[u8]) -> Result<(String, Option<String>), Refused> {
    let refuse = |problem: &str, remedy: &str| Err(Refused::whole(problem, remedy));
    if bytes.starts_with(b"PK\x03\x04") || bytes.starts_with(b"\xd0\xcf\x11\xe0") {
        return refuse("this is the file of a spreadsheet program, not a table in text", "save it as CSV");
    }
    let of_two = |name, number: fn([u8; 2]) -> u16| {
        let (pairs, rest) = bytes.as_chunks();
        let text = char::decode_utf16(pairs.iter().map(|pair| number(*pair))).collect::<Result<_, _>>();
        (Some(name), text.ok().filter(|_| rest.is_empty()))
    };
    let (encoding, text) = match (bytes, std::str::from_utf8(bytes)) {
        ([0xff, 0xfe, ..], _) => of_two("UTF-16LE", u16::from_le_bytes),
        ([0xfe, 0xff, ..], _) => of_two("UTF-16BE", u16::from_be_bytes),
        (_, Ok(text)) if !text.contains('\0') => return Ok((text.to_owned(), None)),
        (_, Ok(_)) | ([0xef, 0xbb, 0xbf, ..], Err(_)) => (None, None),
        (_, Err(_)) => {
            let letter = |byte: u8| {
                let special = byte.checked_sub(0x80).and_then(|i| WINDOWS_1252.chars().nth(i.into()));
                special.unwrap_or(char::from(byte))
            };
            (Some("windows-1252"), Some(bytes.iter().map(|byte| letter(*byte)).collect()))
        }
    };
    let is_odd = |c: char| c.is_control() && !c.is_whitespace();
    match text.filter(|text: &String| !text.contains(is_odd)) {
        Some(text) => Ok((text.trim_start_matches('\u{feff}').to_owned(), encoding.map(str::to_owned))),
        None => refuse("this is not a text", "name a CSV file"),
    }
}

/// The separators that are tried, in this order, with their names.
const SEPARATORS: [(char, &str); 5] = [
    ('\t', "separated by tabs"),
    (';', "separated by semicolons"),
    ('|', "separated by bars"),
    (' ', "separated by spaces"),
    (',', ""),
];

/// The signs between thousands that separate nothing else.
const BETWEEN_THOUSANDS: [char; 5] = [' ', '\u{a0}', '\u{202f}', '\'', '’'];

/// A field without spaces around it, and without apostrophes or spaces between thousands.
fn joined(field: &str) -> String {
    let field = field.trim();
    let whole = field.split(['.', ',']).next().unwrap_or_default();
    match BETWEEN_THOUSANDS.into_iter().find(|sign| whole.contains(*sign)) {
        Some(sign) if may_be_thousands(whole, sign) => field.replace(sign, ""),
        _ => field.to_owned(),
    }
}

/// Whether a field looks like a number, with any decimal sign.
fn looks_like_a_number(field: &str) -> bool {
    let field = joined(field);
    let is_part = |c: char| c.is_ascii_digit() || "+-−.,eEdD".contains(c);
    field.starts_with(|c: char| c.is_ascii_digit() || "+-−.".contains(c))
        && field.ends_with(|c: char| c.is_ascii_digit() || c == '.')
        && field.chars().all(is_part)
}

/// The fields of a line.
fn split(line: &str, separator: char) -> Vec<String> {
    if separator == ' ' {
        return line.split_whitespace().map(str::to_owned).collect();
    }
    // A reader of its own for each line takes longer than all else.
    if !line.contains('"') {
        return line.split(separator).map(|field| field.trim().to_owned()).collect();
    }
    let mut reader = csv::ReaderBuilder::new()
        .has_headers(false)
        .delimiter(separator as u8)
        .trim(csv::Trim::All)
        .buffer_capacity(line.len().max(16))
        .from_reader(line.as_bytes());
    let mut record = csv::StringRecord::new();
    match reader.read_record(&mut record) {
        Ok(_) => record.iter().map(str::to_owned).collect(),
        Err(_) => vec![line.to_owned()],
    }
}

/// Number of lines by which the separator is chosen.
const TRIED: usize = 500;

/// Divides a text into fields. The separator is the first one by which about as many lines begin with numbers as
/// by any other.
pub(super) fn fields(text: &str) -> Result<Fields, Refused> {
    let text = text.trim_start_matches('\u{feff}').replace("\r\n", "\n").replace('\r', "\n");
    let is_data = |line: &str| !line.trim().is_empty() && !line.starts_with(['#', '%']);
    let lines = || text.split('\n').enumerate().filter(|(_, line)| is_data(line));
    let score = |separator: char| {
        let of = lines().take(TRIED).map(|(_, line)| split(line, separator));
        of.filter(|fields| {
            let first = if separator == ' ' { 2 } else { fields.len() };
            fields.iter().take(first).filter(|field| looks_like_a_number(field)).count() >= 2
        })
        .count()
    };
    let scores = SEPARATORS.map(|(separator, _)| score(separator));
    let best = scores.into_iter().max().unwrap_or(0);
    let chosen = SEPARATORS.iter().zip(scores).find(|(_, score)| *score > 0 && 2 * score >= best);
    let Some((&(separator, words), _)) = chosen else {
        return Err(Refused::no_numbers());
    };
    let lines: Vec<Line> =
        lines().map(|(i, line)| Line { number: i + 1, fields: split(line, separator) }).collect();
    let comments = text.split('\n').enumerate().filter(|(_, line)| line.starts_with(['#', '%']));
    let comments = comments.map(|(i, line)| {
        let line = line.trim_start_matches(['#', '%', ' ']);
        let by = |separator: char| Line { number: i + 1, fields: split(line, separator) };
        [separator, ',', ';', '\t'].map(by).into()
    });
    let comments = comments.collect();
    let Some(first) = first_row(&lines) else { return Err(Refused::no_numbers()) };
    let (decimal, sign) = decimal(&lines[first..])?;
    let said = [words, sign].into_iter().filter(|words| !words.is_empty()).map(str::to_owned).collect();
    Ok(Fields { lines, first, decimal, comments, said })
}

/// The first line that has numbers where most lines with two of them have, below the line of the names if there is one: above
/// are titles, and the settings of a program, as `key:;value;value`.
fn first_row(lines: &[Line]) -> Option<usize> {
    let place = |line: &Line| {
        let numbers = line.fields.iter().take(64).map(|field| looks_like_a_number(field));
        numbers.enumerate().fold(0_u64, |places, (i, is_number)| places | u64::from(is_number) << i)
    };
    let places: Vec<u64> = lines.iter().map(place).collect();
    let mut counts: Vec<(u64, usize)> = Vec::new();
    for &at in places.iter().filter(|places| places.count_ones() >= 2) {
        match counts.iter_mut().find(|(known, _)| *known == at) {
            Some((_, count)) => *count += 1,
            None => counts.push((at, 1)),
        }
    }
    // Of equally many the first.
    let (most, _) = counts.into_iter().rev().max_by_key(|(_, count)| *count)?;
    let mut with_places = lines.iter().zip(&places);
    let are_names = |(line, places): (&Line, &u64)| *places == 0 && columns::are_names(&line.fields);
    let names = with_places.position(are_names).unwrap_or(0);
    // Without a number in its first field a line above the names is none of the rows.
    let from = if places[..names].iter().any(|places| places & 1 == 1) { 0 } else { names };
    let is_row = |places: &u64| places & most == most;
    places[from..].iter().position(is_row).map(|at| from + at)
}

/// Whether `sign` in a number may separate thousands: 1,234 or 12,345,678.
fn may_be_thousands(number: &str, sign: char) -> bool {
    let mut groups = number.trim_start_matches(['+', '-', '−']).split(sign);
    let first = groups.next().unwrap_or_default();
    let is_digits = |group: &str| group.chars().all(|c| c.is_ascii_digit());
    (1..=3).contains(&first.len())
        && is_digits(first)
        && !first.starts_with('0')
        && groups.all(|group| group.len() == 3 && is_digits(group))
}

/// Whether the column of a number with a point, between what may be thousands, has whole numbers without one.
fn has_whole_beside(lines: &[Line], (number, field): (usize, &str)) -> bool {
    let of = lines.iter().find(|line| line.number == number);
    let Some(column) = of.and_then(|line| line.fields.iter().position(|other| other == field)) else {
        return false;
    };
    let is_whole = |field: &String| field.len() > 1 && field.chars().all(|c| c.is_ascii_digit());
    lines.iter().filter_map(|line| line.fields.get(column)).any(is_whole)
}

/// The decimal sign of a file, and the words for an unusual one.
fn decimal(lines: &[Line]) -> Result<(Decimal, &'static str), Refused> {
    // The first number that has each sign before its decimals, and that may have it between thousands.
    let (mut decimals, mut thousands) = ([None, None], [None, None]);
    for line in lines {
        let numbers: Vec<&String> = line.fields.iter().filter(|field| looks_like_a_number(field)).collect();
        // Above the rows there may be a date or a version beside a word.
        for field in numbers.iter().filter(|_| numbers.len() >= 2) {
            let found = (line.number, field.as_str());
            match (field.rfind('.'), field.rfind(',')) {
                (None, None) => {}
                (Some(point), Some(comma)) => {
                    decimals[usize::from(comma > point)].get_or_insert(found);
                }
                (point, _) => {
                    let (of, sign) = if point.is_some() { (0, '.') } else { (1, ',') };
                    let may_be_thousands = may_be_thousands(field, sign);
                    // A date has two signs.
                    if may_be_thousands || field.matches(sign).count() == 1 {
                        let kind = if may_be_thousands { &mut thousands } else { &mut decimals };
                        kind[of].get_or_insert(found);
                    }
                }
            }
        }
    }
    let refuse = |(line, number): (usize, &str), problem: String, remedy: String| {
        Err(Refused { line: Some(line), problem: format!("`{number}`: {problem}"), remedy })
    };
    match (decimals, thousands) {
        ([Some((line, point)), Some(comma)], _) => refuse(
            comma,
            format!("a decimal comma, and `{point}` in line {line} has a decimal point"),
            "write all decimals with a point, or all with a comma".into(),
        ),
        ([None, Some(_)], _) => Ok((Decimal::Comma, "decimal commas")),
        ([None, None], [Some(point), None]) if has_whole_beside(lines, point) => {
            let [without, comma] = ["", ","].map(|sign| point.1.replace('.', sign));
            refuse(
                point,
                "the point may separate thousands or decimals, beside whole numbers".into(),
                format!("write {without} or, of decimals, {comma} in all rows or one more digit"),
            )
        }
        ([None, None], [point, Some((line, number))]) => {
            let [without, with] = ["", "."].map(|sign| number.replace(',', sign));
            let also = point.map_or(String::new(), |(_, other)| format!(", beside `{other}`"));
            refuse(
                (line, number),
                format!("the comma may separate thousands or decimals{also}"),
                format!("write {without} or {with}"),
            )
        }
        _ => Ok((Decimal::Point, "")),
    }
}

/// The number in a field; `None` for other texts.
pub(super) fn number(field: &str, decimal: Decimal) -> Option<f64> {
    // Fortran writes D before an exponent.
    let plain = joined(field).replace('−', "-").replace(['d', 'D'], "e");
    let plain = match decimal {
        Decimal::Point if may_be_thousands(plain.split('.').next().unwrap_or_default(), ',') => {
            plain.replace(',', "")
        }
        Decimal::Point => plain,
        Decimal::Comma => plain.replace('.', "").replace(',', "."),
    };
    plain.parse().ok()
}

/// Whether a field says that there is no number.
pub(super) fn is_missing(field: &str) -> bool {
    let words = ["", "-", "--", "na", "n/a", "nan", "null", "none"];
    // #DIV/0!, and what other errors a spreadsheet has.
    field.starts_with('#') || words.contains(&field.trim().to_lowercase().as_str())
}

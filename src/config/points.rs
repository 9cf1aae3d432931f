//! Tables of points: CSV files with one column for every axis of a law; other columns are kept.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use csv::{ByteRecord, ReaderBuilder};

use super::source::ConfigError;
use crate::friction::Law;
use crate::map::{Grid, GridError};
use crate::point::Point;

/// Number of rows handed out at a time: keeps all cores busy and fits into memory.
const BATCH: usize = 8192;

/// Largest number of bytes of rows held at a time.
const HELD: u64 = 1 << 26;

/// Largest number of bytes of a row. A longer row is not one of numbers, and would fill the memory before it
/// could be refused.
const LONGEST_ROW: u64 = 1 << 20;

/// Reader of a table of points.
pub struct PointTable {
    name: String,
    law: Law,
    reader: csv::Reader<Rows>,
    header: ByteRecord,
    /// Names of the axes of the law, and the column of each.
    axes: Vec<(&'static str, usize)>,
    parsed: Arc<AtomicU64>,
}

impl PointTable {
    /// Opens the table at `path` (`-`: standard input), and finds the columns of the axes of `law` by its
    /// header.
    ///
    /// # Errors
    /// The file cannot be read, or a column is missing or occurs twice.
    pub fn open(path: &Path, law: &Law) -> Result<Self, ConfigError> {
        let (name, source): (String, Box<dyn Read + Send + Sync>) = if path == Path::new("-") {
            ("standard input".into(), Box::new(io::stdin()))
        } else {
            let name = path.display().to_string();
            if path.is_dir() {
                return Err(error(name, "this is a folder", "name a CSV file"));
            }
            let file = File::open(path).map_err(|cause| match cause.kind() {
                io::ErrorKind::NotFound => error(name.clone(), "there is no such file", "check the path"),
                _ => error(name.clone(), format!("cannot be read: {cause}"), "check its permissions"),
            })?;
            (name, Box::new(BufReader::new(file)))
        };
        let parsed = Arc::new(AtomicU64::new(0));
        let source = Rows { source, read: 0, parsed: Arc::clone(&parsed) };
        let mut reader = ReaderBuilder::new().from_reader(source);
        let mut header = reader.byte_headers().map_err(|error| read_error(&name, &error))?.clone();
        // Some spreadsheets write a byte order mark, which is not part of the first name.
        if let Some(first) = header.get(0).and_then(|first| first.strip_prefix("\u{feff}".as_bytes())) {
            header = std::iter::once(first).chain(header.iter().skip(1)).collect();
        }
        let axes = find_axes(&name, &header, law)?;
        Ok(Self { name, law: law.clone(), reader, header, axes, parsed })
    }

    /// The file's name in messages.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The header: names of the columns.
    #[must_use]
    pub fn header(&self) -> &ByteRecord {
        &self.header
    }

    /// Reads the next rows, some thousand at most; empty at the end.
    ///
    /// # Errors
    /// A row with another number of fields than the header, or of more than a mebibyte; or the file system's
    /// reasons.
    pub fn rows(&mut self) -> Result<Vec<ByteRecord>, ConfigError> {
        let mut rows = Vec::new();
        let start = self.reader.position().byte();
        while rows.len() < BATCH && self.reader.position().byte() - start < HELD {
            let mut row = ByteRecord::new();
            let more = self.reader.read_byte_record(&mut row);
            if !more.map_err(|error| read_error(&self.name, &error))? {
                break;
            }
            self.parsed.store(self.reader.position().byte(), Ordering::Relaxed);
            rows.push(row);
        }
        Ok(rows)
    }

    /// The point of a row.
    ///
    /// # Errors
    /// A field of an axis that is not a number, or not legal on the axis.
    pub fn point(&self, row: &ByteRecord) -> Result<Point, ConfigError> {
        let bad = |name: &str, text: &str, problem: String, remedy: &str| {
            error(self.place(row), format!("column {name}: `{}` {problem}", short(text)), remedy)
        };
        let mut values = Vec::with_capacity(self.axes.len());
        let mut texts = Vec::with_capacity(self.axes.len());
        for &(name, position) in &self.axes {
            let text = String::from_utf8_lossy(row.get(position).unwrap_or_default()).trim().to_owned();
            let value: f64 = text.parse().map_err(|_| {
                bad(name, &text, "is not a number".into(), "write a number such as 0.5 or 1e-3")
            })?;
            values.push(value);
            texts.push(text);
        }
        point_of(&self.law, &values).map_err(|error| {
            let (name, wanted) = match &error {
                GridError::OutOfDomain { axis, domain, .. } => (axis.as_str(), domain.clone()),
                GridError::NotFinite { axis, .. } => (axis.as_str(), "finite".to_owned()),
                // A grid of one cell has no other errors.
                other => ("", other.to_string()),
            };
            let text = self.axes.iter().position(|(axis, _)| *axis == name).map_or("", |i| &texts[i]);
            let problem = format!("is out of range: {name} must be {wanted}");
            bad(name, text, problem, "correct or remove this row")
        })
    }

    /// File and line of a row.
    #[must_use]
    pub fn place(&self, row: &ByteRecord) -> String {
        format!("{}:{}", self.name, row.position().map_or(0, csv::Position::line))
    }
}

/// The point with the given value on each axis of `law`, in the order of [`Grid::axis_names`].
///
/// # Errors
/// The first value that is not legal on its axis.
pub fn point_of(law: &Law, values: &[f64]) -> Result<Point, GridError> {
    // A point is legal exactly when the grid of this one cell is.
    let grid = Grid::new(law.clone(), values.iter().map(|&value| vec![value]).collect())?;
    Ok(grid.point(&vec![0; values.len()]))
}

fn error(place: String, problem: impl Into<String>, remedy: impl Into<String>) -> ConfigError {
    ConfigError { place, problem: problem.into(), remedy: remedy.into() }
}

/// A field, shortened for a message.
fn short(text: &str) -> String {
    match text.char_indices().nth(40) {
        Some((end, _)) => format!("{}..", &text[..end]),
        None => text.to_owned(),
    }
}

/// Finds the columns of the axes.
fn find_axes(name: &str, header: &ByteRecord, law: &Law) -> Result<Vec<(&'static str, usize)>, ConfigError> {
    let header: Vec<String> =
        header.iter().map(|field| String::from_utf8_lossy(field).trim().to_owned()).collect();
    let names = Grid::axis_names(law);
    let bad = |problem: String, remedy: String| Err(error(format!("{name}:1"), problem, remedy));
    let mut axes = Vec::with_capacity(names.len());
    for axis in &names {
        let mut found = (0..header.len()).filter(|&i| header[i] == *axis);
        let Some(position) = found.next() else {
            let remedy = match header.as_slice() {
                [] => format!("the first line must name the columns: {}", names.join(",")),
                [only] if only.contains([';', '\t']) => "separate the columns by commas".into(),
                _ => format!(
                    "the first line must name a column for each of {}; it names {}",
                    names.join(", "),
                    header.join(", ").chars().take(200).collect::<String>()
                ),
            };
            return bad(format!("the column `{axis}` is missing"), remedy);
        };
        if found.next().is_some() {
            return bad(format!("the column `{axis}` is there twice"), "take one of them out".into());
        }
        axes.push((*axis, position));
    }
    Ok(axes)
}

/// Byte source that returns an error if a row is too long.
struct Rows {
    source: Box<dyn Read + Send + Sync>,
    /// Number of bytes passed on.
    read: u64,
    /// Number of bytes of the rows parsed so far.
    parsed: Arc<AtomicU64>,
}

impl Read for Rows {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.read > self.parsed.load(Ordering::Relaxed) + LONGEST_ROW {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!(
                    "a row is longer than {} MiB: a quote is never closed, or this is not a table",
                    LONGEST_ROW >> 20
                ),
            ));
        }
        let read = self.source.read(buffer)?;
        self.read += read as u64;
        Ok(read)
    }
}

/// Converts an error of the CSV reader, with its line.
fn read_error(name: &str, cause: &csv::Error) -> ConfigError {
    let place = format!("{name}:{}", cause.position().map_or(1, csv::Position::line));
    match cause.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => error(
            place,
            format!("the row has {len} fields, the header {expected_len}"),
            "give every row as many fields as the header",
        ),
        _ => error(place, format!("cannot be read: {cause}"), "check the file"),
    }
}

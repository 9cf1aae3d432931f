//! Tables of points: CSV with one column for every axis of a law, and any others.

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

/// Rows handed out at a time: enough to keep all cores busy, little enough to hold.
const BATCH: usize = 8192;

/// Bytes of rows held at a time.
const HELD: u64 = 1 << 26;

/// Bytes of a row. A longer one is no row of numbers, and would fill the memory before it could be refused.
const LONGEST_ROW: u64 = 1 << 20;

/// A table of points being read.
pub struct PointTable {
    name: String,
    law: Law,
    reader: csv::Reader<Rows>,
    header: ByteRecord,
    /// Names of the axes of the law, and the column of each.
    axes: Vec<(&'static str, usize)>,
    understood: Arc<AtomicU64>,
}

impl PointTable {
    /// Opens the table at `path` (`-`: standard input), and finds the columns of the axes of `law` in its
    /// header.
    ///
    /// # Errors
    /// The file cannot be read, or a column is missing, or there twice.
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
        let understood = Arc::new(AtomicU64::new(0));
        let source = Rows { source, read: 0, understood: Arc::clone(&understood) };
        let mut reader = ReaderBuilder::new().from_reader(source);
        let mut header = reader.byte_headers().map_err(|error| read_error(&name, &error))?.clone();
        // Some spreadsheets begin a file with a byte order mark, which is no part of the first name.
        if let Some(first) = header.get(0).and_then(|first| first.strip_prefix("\u{feff}".as_bytes())) {
            header = std::iter::once(first).chain(header.iter().skip(1)).collect();
        }
        let axes = find_axes(&name, &header, law)?;
        Ok(Self { name, law: law.clone(), reader, header, axes, understood })
    }

    /// The file's name, for messages.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The first row, which names the columns.
    #[must_use]
    pub fn header(&self) -> &ByteRecord {
        &self.header
    }

    /// The next rows, some thousand at most; none at the end.
    ///
    /// # Errors
    /// A row of another length than the header, or of more than a mebibyte, or the file system's reasons.
    pub fn rows(&mut self) -> Result<Vec<ByteRecord>, ConfigError> {
        let mut rows = Vec::new();
        let start = self.reader.position().byte();
        while rows.len() < BATCH && self.reader.position().byte() - start < HELD {
            let mut row = ByteRecord::new();
            let more = self.reader.read_byte_record(&mut row);
            if !more.map_err(|error| read_error(&self.name, &error))? {
                break;
            }
            self.understood.store(self.reader.position().byte(), Ordering::Relaxed);
            rows.push(row);
        }
        Ok(rows)
    }

    /// The point that a row describes.
    ///
    /// # Errors
    /// A field of an axis that is no number, or none that the axis may have.
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
                // A grid of one cell has no other faults.
                other => ("", other.to_string()),
            };
            let text = self.axes.iter().position(|(axis, _)| *axis == name).map_or("", |i| &texts[i]);
            let problem = format!("is out of range: {name} must be {wanted}");
            bad(name, text, problem, "mend or remove this row")
        })
    }

    /// Where a row stands: file and line.
    #[must_use]
    pub fn place(&self, row: &ByteRecord) -> String {
        format!("{}:{}", self.name, row.position().map_or(0, csv::Position::line))
    }
}

/// The point with the given value on each axis of `law`, in the order of [`Grid::axis_names`].
///
/// # Errors
/// The first value that its axis may not have.
pub fn point_of(law: &Law, values: &[f64]) -> Result<Point, GridError> {
    // A point is legal exactly when the grid of this one cell is.
    let grid = Grid::new(law.clone(), values.iter().map(|&value| vec![value]).collect())?;
    Ok(grid.point(&vec![0; values.len()]))
}

fn error(place: String, problem: impl Into<String>, remedy: impl Into<String>) -> ConfigError {
    ConfigError { place, problem: problem.into(), remedy: remedy.into() }
}

/// A field as far as it fits into a message.
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

/// A source that ends with an error where a row seems never to end.
struct Rows {
    source: Box<dyn Read + Send + Sync>,
    /// Bytes handed on.
    read: u64,
    /// Bytes of the rows that the reader has understood.
    understood: Arc<AtomicU64>,
}

impl Read for Rows {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.read > self.understood.load(Ordering::Relaxed) + LONGEST_ROW {
            return Err(io::Error::new(
                io::ErrorKind::InvalidData,
                format!(
                    "a row is longer than {} MiB: a quote is never closed, or this is no table",
                    LONGEST_ROW >> 20
                ),
            ));
        }
        let read = self.source.read(buffer)?;
        self.read += read as u64;
        Ok(read)
    }
}

/// An error of the table itself, with its line.
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

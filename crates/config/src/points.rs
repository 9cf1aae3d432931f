//! Tables of points: CSV files with one column for every axis of a law. Other columns are kept if they hold text,
//! if they number the rows, or if their names begin with `#`.

use std::fs::File;
use std::io::{self, BufReader, Read};
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use csv::{ByteRecord, ReaderBuilder};

use super::described::{Wrong, with_axes};
use super::nearest;
use super::source::{ConfigError, decimal_comma};
use super::units::{Match, bracketed, compare, conversion, converted, has_unit, meant};
use slipmap_machine::{DAMPING_RATIO, Friction, INERTIA, MASS, Machine};
use slipmap_model::friction::{Law, PointError};
use slipmap_model::point::Point;

/// Number of rows handed out at a time: keeps all cores busy and fits into memory.
const BATCH: usize = 8192;

/// Names of columns that number the rows.
const NUMBERED: [&str; 5] = ["id", "no", "nr", "row", "index"];

/// Largest number of bytes of rows held at a time.
const HELD: u64 = 1 << 26;

/// Largest number of bytes of a row. A longer row is not a row of numbers, and would fill the memory before
/// it could be refused.
const LONGEST_ROW: u64 = 1 << 20;

/// Reader of a table of points, or of machines.
pub struct PointTable {
    /// The file's name in messages.
    pub name: String,
    reader: csv::Reader<Rows>,
    /// The names of its columns.
    pub header: ByteRecord,
    /// What may be read.
    names: Vec<&'static str>,
    columns: Vec<Column>,
    /// What the units of its columns are in SI: "1 rpm is 0.10472 rad/s".
    pub conversions: Vec<String>,
    /// The parameters that all rows share.
    shared: Vec<(String, f64)>,
    parsed: Arc<AtomicU64>,
    /// Whether lines end as on Windows.
    carriage_returns: Arc<AtomicBool>,
    /// The columns that are not read and had no text yet; `None` before the first row.
    unread: Option<Vec<usize>>,
}

/// A column that is read.
struct Column {
    /// The name of the parameter or quantity.
    name: &'static str,
    position: usize,
    /// The factor to SI.
    factor: f64,
}

impl PointTable {
    /// Opens the table at `path` (`-`: standard input), where all rows share the values `shared` of some axes, and
    /// finds the columns of the other axes of `law` by its header. Returns the law, too: with the parameters
    /// `exponent` and `drop` where there are such columns.
    ///
    /// # Errors
    /// The file cannot be read, a column is missing or occurs twice, or a shared axis has a column too.
    pub fn open(path: &Path, law: &Law, shared: &[(String, f64)]) -> Result<(Self, Law), ConfigError> {
        let table = Self::with_header(path)?;
        table.refuse_columns_of(shared.iter().map(|(name, _)| name.as_str()))?;
        let has = |name: &str| table.header.iter().any(|field| base(&field_text(field)) == name);
        let law = with_axes(law.clone(), has)
            .map_err(|wrong| ConfigError::new(format!("{}:1", table.name), wrong.words(""), wrong.remedy))?;
        let is_shared = |name: &str| shared.iter().any(|(given, _)| given == name);
        let names: Vec<&str> = law.axis_names().into_iter().filter(|name| !is_shared(name)).collect();
        let columns = find_axes(&table.name, &table.header, &names, None)?.0;
        Ok((Self { names, columns, shared: shared.to_vec(), ..table }, law))
    }

    /// Opens a table of machines. Its header must name at least one of the `quantities`; quantities `given`
    /// elsewhere must have no column. A name may be followed by its unit, as in the tables that the program
    /// writes: `damping [N s/m]`, `belt_speed [rpm]`; it is converted to SI.
    ///
    /// # Errors
    /// The file cannot be read, has no such column, has one of them twice or in the unit of another quantity, or has a
    /// column of a given quantity.
    pub fn of_machines(
        path: &Path,
        quantities: &[&'static str],
        machine: &Machine,
        given: &[String],
    ) -> Result<Self, ConfigError> {
        let table = Self::with_header(path)?;
        let (columns, mut conversions) = find_axes(&table.name, &table.header, quantities, Some(machine))?;
        conversions.dedup();
        let table = Self { names: quantities.to_vec(), columns, conversions, ..table };
        table.refuse_columns_of(given.iter().map(String::as_str))?;
        if table.has(MASS) && table.has(INERTIA) {
            let problem = "the columns `mass` and `inertia` are the same quantity";
            return Err(ConfigError::new(format!("{}:1", table.name), problem, "take one of them out"));
        }
        Ok(table)
    }

    /// Refuses columns of quantities that are given for all rows.
    fn refuse_columns_of<'b>(&self, mut given: impl Iterator<Item = &'b str>) -> Result<(), ConfigError> {
        let header: Vec<String> = self.header.iter().map(field_text).collect();
        let named = |name: &str| header.iter().any(|field| field == name || base(field) == name);
        let same = |name: &'static str, other: &str| [MASS, INERTIA].contains(&other).then_some(name);
        let column = given.find_map(|name| {
            let names = [Some(name), same(MASS, name), same(INERTIA, name)];
            names.into_iter().flatten().find(|name| named(name)).map(|column| (name, column))
        });
        let Some((name, column)) = column else { return Ok(()) };
        let problem =
            format!("the column `{column}` is there, and {name} is given on the command line for all rows");
        Err(ConfigError::new(format!("{}:1", self.name), problem, "leave one of them out"))
    }

    /// Opens a table and reads its header.
    fn with_header(path: &Path) -> Result<Self, ConfigError> {
        let (name, source): (String, Box<dyn Read + Send + Sync>) = if path == Path::new("-") {
            ("standard input".into(), Box::new(io::stdin()))
        } else {
            let name = path.display().to_string();
            if path.is_dir() {
                return Err(ConfigError::new(name, "this is a folder", "name a CSV file"));
            }
            let file = File::open(path).map_err(|cause| {
                let (problem, remedy) = match cause.kind() {
                    io::ErrorKind::NotFound => ("there is no such file".into(), "check the path"),
                    _ => (format!("cannot be read: {cause}"), "check its permissions"),
                };
                ConfigError::new(name.clone(), problem, remedy)
            })?;
            (name, Box::new(BufReader::new(file)))
        };
        let parsed = Arc::new(AtomicU64::new(0));
        let carriage_returns = Arc::new(AtomicBool::new(false));
        let source = Rows {
            source,
            read: 0,
            parsed: Arc::clone(&parsed),
            carriage_returns: Arc::clone(&carriage_returns),
        };
        let mut reader = ReaderBuilder::new().from_reader(source);
        let mut header = reader.byte_headers().map_err(|error| read_error(&name, 1, &error))?.clone();
        // Some spreadsheets write a byte order mark, which is not part of the first name.
        if let Some(first) = header.get(0).and_then(|first| first.strip_prefix("\u{feff}".as_bytes())) {
            header = std::iter::once(first).chain(header.iter().skip(1)).collect();
        }
        Ok(Self {
            name,
            reader,
            header,
            names: Vec::new(),
            columns: Vec::new(),
            conversions: Vec::new(),
            shared: Vec::new(),
            parsed,
            carriage_returns,
            unread: None,
        })
    }

    /// Returns whether the table has a column of this parameter or quantity.
    pub fn has(&self, name: &str) -> bool {
        self.columns.iter().any(|column| column.name == name)
    }

    /// Reads the next rows, some thousand at most; empty at the end.
    ///
    /// # Errors
    /// A row has another number of fields than the header or is longer than a mebibyte, or the file cannot be
    /// read.
    pub fn rows(&mut self) -> Result<Vec<ByteRecord>, ConfigError> {
        let mut rows = Vec::new();
        let start = self.reader.position().byte();
        while rows.len() < BATCH && self.reader.position().byte() - start < HELD {
            let mut row = ByteRecord::new();
            let before = self.reader.position().line();
            let more = self.reader.read_byte_record(&mut row);
            // The reader's position of a row is before the empty lines above; with Windows line ends it is
            // before the end of the previous line.
            let inside = row.as_slice().iter().filter(|byte| **byte == b'\n').count() as u64;
            let end = u64::from(!self.carriage_returns.load(Ordering::Relaxed));
            let line = before.max(self.reader.position().line().saturating_sub(inside + end));
            if !more.map_err(|error| read_error(&self.name, line, &error))? {
                break;
            }
            let mut position = self.reader.position().clone();
            position.set_line(line);
            row.set_position(Some(position));
            self.parsed.store(self.reader.position().byte(), Ordering::Relaxed);
            self.refuse_unread(&row)?;
            rows.push(row);
        }
        Ok(rows)
    }

    /// Refuses a column of numbers that is not read: its numbers would not be those of the answers. The first field that
    /// is not empty tells whether a column holds numbers or text.
    fn refuse_unread(&mut self, row: &ByteRecord) -> Result<(), ConfigError> {
        let header = |position: usize| field_text(self.header.get(position).unwrap_or_default());
        let is_kept = |name: &str| name.starts_with('#') || NUMBERED.contains(&name);
        let is_read = |position: usize| self.columns.iter().any(|column| column.position == position);
        let all = || (0..self.header.len()).filter(|at| !is_read(*at) && !is_kept(&header(*at))).collect();
        let mut unread: Vec<usize> = self.unread.take().unwrap_or_else(all);
        if unread.is_empty() {
            self.unread = Some(unread);
            return Ok(());
        }
        let field = |position: usize| field_text(row.get(position).unwrap_or_default());
        if let Some(position) = unread.iter().copied().find(|at| field(*at).parse::<f64>().is_ok()) {
            let name = header(position);
            let problem = format!("column {}: the numbers of `{name}` are not read", position + 1);
            let remedy = format!(
                "to keep the column unread, call it `#{name}`; {}",
                nearest("column", base(&name), &self.names)
            );
            return Err(ConfigError::new(format!("{}:1", self.name), problem, remedy));
        }
        unread.retain(|at| field(*at).is_empty());
        self.unread = Some(unread);
        Ok(())
    }

    /// The point of `law` in a row.
    ///
    /// # Errors
    /// The field of an axis is not a number, or not legal on the axis.
    pub fn point(&self, row: &ByteRecord, law: &Law) -> Result<Point, ConfigError> {
        let values = self.values(row)?;
        let of_row = |name: &str| values.iter().find(|(known, _)| *known == name).map(|(_, value)| *value);
        let of_all =
            |name: &str| self.shared.iter().find(|(known, _)| known == name).map(|(_, value)| *value);
        let values: Vec<f64> =
            law.axis_names().into_iter().filter_map(|name| of_row(name).or_else(|| of_all(name))).collect();
        point_of(law, &values).map_err(|error| {
            let PointError::OutOfDomain { name, value, domain: wanted } = error else {
                unreachable!("{error}")
            };
            match of_all(name) {
                None => self.illegal(row, name, &format!("is out of range: {name} must be {wanted}")),
                Some(_) => {
                    let problem = format!("{name} = {value}, given for all rows, is out of range");
                    ConfigError::new("the command line", problem, format!("{name} must be {wanted}"))
                }
            }
        })
    }

    /// The numbers of a row by the names of their columns, of a machine in SI units.
    pub fn values(&self, row: &ByteRecord) -> Result<Vec<(&'static str, f64)>, ConfigError> {
        let number = |&Column { name, factor, .. }: &Column| {
            let text = self.text(row, name);
            text.parse().map(|value| (name, converted(value, factor))).map_err(|_| {
                let problem = format!("column {name}: `{}` is not a number", text);
                let in_header =
                    || has_unit(&text).then(|| "write the unit into the header, in brackets".to_owned());
                let remedy = decimal_comma(&text).or_else(in_header);
                let remedy = remedy.unwrap_or("write a number such as 0.5 or 1e-3".into());
                ConfigError::new(self.place(row), problem, remedy)
            })
        };
        self.columns.iter().map(number).collect()
    }

    /// The error for the number of a row in this column.
    pub fn illegal(&self, row: &ByteRecord, name: &str, problem: &str) -> ConfigError {
        let problem = format!("column {name}: `{}` {problem}", self.text(row, name));
        ConfigError::new(self.place(row), problem, "correct or remove this row")
    }

    fn text(&self, row: &ByteRecord, name: &str) -> String {
        let column = self.columns.iter().find(|column| column.name == name);
        field_text(column.and_then(|column| row.get(column.position)).unwrap_or_default())
    }

    /// File and line of a row.
    pub fn place(&self, row: &ByteRecord) -> String {
        format!("{}:{}", self.name, row.position().map_or(0, csv::Position::line))
    }
}

/// The point with the given value on each axis of `law`, in the order of [`Law::axis_names`].
///
/// # Errors
/// The first value that is not legal on its axis.
pub fn point_of(law: &Law, values: &[f64]) -> Result<Point, PointError> {
    match values {
        &[epsilon, ref own @ .., belt_speed, damping] => law.point(epsilon, own, belt_speed, damping),
        _ => Err(PointError::ParameterCount { law: law.name(), wanted: law.parameters().len(), given: 0 }),
    }
}

/// Checks that a law is legal at a point for the slip speeds that every orbit and every test uses.
///
/// # Errors
/// What is wrong with it.
pub fn check_law(law: &Law, point: &Point) -> Result<(), Wrong> {
    let fastest = 2.0 * point.belt_speed;
    let (end, remedy) = match law.as_written() {
        Law::Expression(law) => {
            return law.check(point.epsilon, &point.law, fastest).map_err(Wrong::in_formula);
        }
        Law::Table(table) if table.fastest() < fastest => (
            format!("the data of {} end at slip speed {}", table.origin(), table.fastest()),
            "choose a lower belt speed",
        ),
        Law::Function(function) if function.fastest() < fastest => (
            format!("{} was sampled up to slip speed {}", function.origin(), function.fastest()),
            "choose a lower belt speed, or sample farther",
        ),
        _ => return Ok(()),
    };
    Err(Wrong::new("V", format!("V = {}: {end}, below 2 V", point.belt_speed), remedy))
}

/// The remedy for a table with semicolons or decimal commas, as spreadsheets of some countries write them.
pub(super) const SEPARATE: &str = "separate the columns by commas, and write decimals with a point: 0.5,0.8";

fn field_text(field: &[u8]) -> String {
    String::from_utf8_lossy(field).trim().to_owned()
}

/// A column's name without the text in brackets after it.
fn base(field: &str) -> &str {
    bracketed(field).map_or(field, |(base, _)| base)
}

/// Finds the columns of `names`: all of them, or, for a machine, at least one.
fn find_axes(
    name: &str,
    header: &ByteRecord,
    names: &[&'static str],
    machine: Option<&Machine>,
) -> Result<(Vec<Column>, Vec<String>), ConfigError> {
    let all = machine.is_none();
    let header: Vec<String> = header.iter().map(field_text).collect();
    let bad = |problem: String, remedy: String| Err(ConfigError::new(format!("{name}:1"), problem, remedy));
    let words = if all { "a column for each of" } else { "one or more of" };
    let remedy = match header.as_slice() {
        [first, ..] if first.contains('\0') => "save it as UTF-8; it seems to be written in UTF-16".into(),
        [] => format!("the first line must name the columns: {}", names.join(",")),
        [only] if only.contains([';', '\t']) => SEPARATE.into(),
        _ => format!(
            "the first line must name {words} {}; it names {}",
            names.join(", "),
            header.join(", ").chars().take(200).collect::<String>()
        ),
    };
    let mut columns = Vec::with_capacity(names.len());
    let mut conversions = Vec::new();
    for axis in names {
        let mut found = (0..header.len()).filter(|&i| header[i] == *axis || base(&header[i]) == *axis);
        match found.next() {
            None if all => {
                let remedy = format!("{remedy}; what all rows share may be given as an option instead");
                return bad(format!("the column `{axis}` is missing"), remedy);
            }
            None => {}
            Some(_) if found.next().is_some() => {
                return bad(format!("the column `{axis}` is there twice"), "take one of them out".into());
            }
            Some(position) => {
                let factor = match bracketed(&header[position]) {
                    None => 1.0,
                    Some((_, unit)) => match factor_of(axis, unit, machine, &mut conversions) {
                        Ok(factor) => factor,
                        Err((problem, remedy)) => {
                            return bad(format!("column {}: {problem}", position + 1), remedy);
                        }
                    },
                };
                columns.push(Column { name: axis, position, factor });
            }
        }
    }
    if columns.is_empty() {
        return bad("no column is a quantity of the machine".into(), remedy);
    }
    Ok((columns, conversions))
}

/// The factor from the unit in a header to that in which the column is read; with words for one that is not 1.
///
/// # Errors
/// The unit is not known, or that of another quantity: the problem and a remedy.
fn factor_of(
    name: &str,
    unit: &str,
    machine: Option<&Machine>,
    conversions: &mut Vec<String>,
) -> Result<f64, (String, String)> {
    let wanted = match machine.map(|machine| (machine, machine.unit(name))) {
        None => "",
        // A name in a formula is in whatever units the formula has.
        Some((machine, "")) if matches!(machine.friction, Friction::Formula(..)) && name != DAMPING_RATIO => {
            let problem = format!("the unit of `{name}` is not known here, and the header says `{unit}`");
            return Err((problem, format!("write `{name}` alone, in the units of the configuration")));
        }
        Some((_, unit)) => unit,
    };
    let read = match wanted {
        "" => format!("{name} is a number without a unit"),
        unit => format!("{name} is read in {unit}"),
    };
    match compare(unit, wanted) {
        Match::Same => Ok(1.0),
        Match::Factor(factor) if machine.is_some() => {
            conversions.push(conversion(unit, factor, wanted));
            Ok(factor)
        }
        read_as @ (Match::Factor(_) | Match::Other | Match::Unknown) => Err((
            format!("{read}, and the header says `{unit}`"),
            match read_as {
                Match::Unknown => meant(unit, wanted).map(|meant| format!("write {meant}")),
                _ => None,
            }
            .unwrap_or("convert the column, or correct the header".into()),
        )),
    }
}

/// Byte source that returns an error if a row is too long.
struct Rows {
    source: Box<dyn Read + Send + Sync>,
    /// Number of bytes passed on.
    read: u64,
    /// Number of bytes of the rows parsed so far.
    parsed: Arc<AtomicU64>,
    /// Whether lines end as on Windows.
    carriage_returns: Arc<AtomicBool>,
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
        if buffer[..read].windows(2).any(|pair| pair == b"\r\n") {
            self.carriage_returns.store(true, Ordering::Relaxed);
        }
        Ok(read)
    }
}

/// Converts an error of the CSV reader in this line.
fn read_error(name: &str, line: u64, cause: &csv::Error) -> ConfigError {
    let place = format!("{name}:{line}");
    match cause.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => ConfigError::new(
            place,
            format!("the row has {len} fields, the header {expected_len}"),
            "give every row as many fields as the header",
        ),
        _ => ConfigError::new(place, format!("cannot be read: {cause}"), "check the file"),
    }
}

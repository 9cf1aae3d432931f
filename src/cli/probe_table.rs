//! `slipmap probe --points`: every answer about each row of a table.

use std::fs::File;
use std::io::{self, BufReader, BufWriter, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use csv::{ByteRecord, ReaderBuilder, WriterBuilder};
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::answer::Answer;
use super::output::exact;
use super::{Ended, Failure, interrupt, point};
use crate::friction::Law;
use crate::map::{Description, Field, Grid, Method, Quantity};

/// Rows computed between reading and writing: enough to keep all cores busy, little enough to hold.
const BATCH: usize = 8192;

/// Answers for standard output are held in memory up to this size, then in a temporary file.
const SPOOL: usize = 16 << 20;

/// What to do.
#[derive(Debug)]
pub(super) struct Job<'a> {
    /// The table of points, `-` for standard input.
    pub(super) input: &'a Path,
    /// The table to write, `-` for standard output.
    pub(super) output: &'a Path,
    /// Whether to replace the output.
    pub(super) overwrite: bool,
    /// The friction law.
    pub(super) law: Law,
    /// Bound on the error of the scaled grazing margin.
    pub(super) tolerance: f64,
    /// Number of threads; `None` for one per core.
    pub(super) threads: Option<usize>,
    /// Whether to append the limits in eps.
    pub(super) epsilon_limits: bool,
    /// Whether to leave out the progress bar.
    pub(super) quiet: bool,
}

/// Runs the command.
pub(super) fn run(job: &Job) -> Result<Ended, Failure> {
    // Listening comes first, so that an interruption at any time removes the temporary file.
    let stop = interrupt::flag();
    let input = Input::open(job.input)?;
    let mut output = Output::open(job.output, job.overwrite)?;
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(job.threads.unwrap_or(0))
        .build()
        .map_err(|error| Failure::Broken(format!("cannot start the threads: {error}")))?;
    let bar = super::progress::bar(job.quiet, None, "rows");
    pool.install(|| convert(job, input, &mut output, stop, &bar))?;
    bar.finish_and_clear();
    output.publish()?;
    Ok(Ended::Fine)
}

/// Reads, computes and writes batch after batch.
fn convert(
    job: &Job,
    mut input: Input,
    output: &mut Output,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> Result<(), Failure> {
    let columns = Columns::find(&mut input, job)?;
    let mut header = input.header.clone();
    for name in answer_columns(job.epsilon_limits) {
        header.push_field(name.as_bytes());
    }
    let mut writer = WriterBuilder::new().from_writer(&mut output.file);
    let write_error =
        |error: csv::Error| Failure::Broken(format!("cannot write {}: {error}", job.output.display()));
    writer.write_byte_record(&header).map_err(write_error)?;
    loop {
        let batch = input.batch()?;
        if batch.is_empty() {
            break;
        }
        let answered: Vec<ByteRecord> = batch
            .into_par_iter()
            .map(|row| {
                if stop.load(Ordering::Relaxed) {
                    return Err(Failure::Interrupted(super::NOTHING_LEFT.into()));
                }
                columns.answer(row, job, &input.name)
            })
            .collect::<Vec<_>>()
            .into_iter()
            .collect::<Result<_, _>>()?;
        for row in &answered {
            writer.write_byte_record(row).map_err(write_error)?;
        }
        bar.inc(answered.len() as u64);
    }
    writer.flush().map_err(|error| write_error(error.into()))
}

/// Names of the columns that are added.
fn answer_columns(epsilon_limits: bool) -> Vec<String> {
    let mut names = Vec::new();
    for method in Method::usual() {
        names.push(format!("verdict_{}", method.name()));
        names.push(format!("margin_{}", method.name()));
    }
    names.extend(["critical_c", "regime"].map(str::to_owned));
    names
        .extend(QUANTITIES.into_iter().flat_map(|field| Quantity::of(field, 0)).map(|q| q.name().to_owned()));
    if epsilon_limits {
        names.extend(Method::usual().map(|method| format!("epsilon_limit_{}", method.name())));
    }
    names
}

/// The fields of a map whose quantities are added.
const QUANTITIES: [Field; 3] = [Field::Landing, Field::Cycle, Field::Basin];

/// Where the parameters stand in a row.
struct Columns {
    names: Vec<&'static str>,
    positions: Vec<usize>,
}

impl Columns {
    /// Finds the columns of the parameters in the header.
    fn find(input: &mut Input, job: &Job) -> Result<Self, Failure> {
        let header: Vec<String> =
            input.header.iter().map(|field| String::from_utf8_lossy(field).trim().to_owned()).collect();
        let names = Grid::axis_names(job.law);
        let bad = |problem: String, remedy: String| {
            Failure::BadInput(format!("{}:1: {problem}\n  help: {remedy}", input.name))
        };
        let mut positions = Vec::with_capacity(names.len());
        for name in &names {
            let mut found = (0..header.len()).filter(|&i| header[i] == *name);
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
                return Err(bad(format!("the column `{name}` is missing"), remedy));
            };
            if found.next().is_some() {
                return Err(bad(
                    format!("the column `{name}` is there twice"),
                    "take one of them out".into(),
                ));
            }
            positions.push(position);
        }
        if let Some(taken) = answer_columns(job.epsilon_limits).into_iter().find(|name| header.contains(name))
        {
            return Err(bad(
                format!("the column `{taken}` is there already, and would be added"),
                "rename it or take it out".into(),
            ));
        }
        Ok(Self { names, positions })
    }

    /// The row with its answers appended.
    fn answer(&self, mut row: ByteRecord, job: &Job, input: &str) -> Result<ByteRecord, Failure> {
        let line = row.position().map_or(0, csv::Position::line);
        let bad = |name: &str, value: &str, problem: &str, remedy: &str| {
            Failure::BadInput(format!("{input}:{line}: column {name}: `{value}` {problem}\n  help: {remedy}"))
        };
        let mut values = Vec::with_capacity(self.names.len());
        for (name, &position) in self.names.iter().zip(&self.positions) {
            let text = String::from_utf8_lossy(row.get(position).unwrap_or_default());
            let text = text.trim();
            let value: f64 = text
                .parse()
                .map_err(|_| bad(name, text, "is not a number", "write a number such as 0.5 or 1e-3"))?;
            values.push(value);
        }
        let point = point::from_values(job.law, &values).map_err(|error| {
            let (name, value, wanted) = point::complaint(&error);
            bad(
                &name,
                &value,
                &format!("is out of range: {name} must be {wanted}"),
                "mend or remove this row",
            )
        })?;

        point::check_law(job.law, &point)
            .map_err(|problem| Failure::BadInput(format!("{input}:{line}: {problem}")))?;

        let answer = Answer::of(job.law, &point, job.tolerance, Method::usual());
        let number = |x: f64| if x.is_nan() { String::new() } else { exact(x) };
        for method in &answer.methods {
            row.push_field(method.verdict.name().as_bytes());
            row.push_field(number(method.margin).as_bytes());
        }
        let critical = answer.critical.as_ref().ok().map(|root| root.c).filter(|&root| root >= 0.0);
        row.push_field(critical.map_or(String::new(), number).as_bytes());
        row.push_field(answer.regime.name().as_bytes());
        let described =
            Description { landing: answer.landing(), cycle: answer.cycle, boundary: answer.basin };
        for quantity in QUANTITIES.into_iter().flat_map(|field| Quantity::of(field, 0)) {
            row.push_field(number(described.value(quantity)).as_bytes());
        }
        if job.epsilon_limits {
            for limit in answer.limits() {
                row.push_field(number(limit.equal.value()).as_bytes());
            }
        }
        Ok(row)
    }
}

/// Bytes of a row. A longer one is no row of numbers, and would fill the memory before it could be refused.
const LONGEST_ROW: u64 = 1 << 20;

/// Bytes of rows held at a time.
const HELD: u64 = 1 << 26;

/// A source that ends with an error where a row seems never to end.
struct Rows<R> {
    source: R,
    /// Bytes handed on.
    read: u64,
    /// Bytes of the rows that the reader has understood.
    understood: Arc<AtomicU64>,
}

impl<R: Read> Read for Rows<R> {
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

/// The table being read.
struct Input {
    name: String,
    reader: csv::Reader<Box<dyn Read + Send>>,
    header: ByteRecord,
    understood: Arc<AtomicU64>,
}

impl Input {
    fn open(path: &Path) -> Result<Self, Failure> {
        let (name, source): (String, Box<dyn Read + Send>) = if path == Path::new("-") {
            ("standard input".into(), Box::new(io::stdin()))
        } else {
            let name = path.display().to_string();
            if path.is_dir() {
                return Err(Failure::BadInput(format!("{name}: this is a folder\n  help: name a CSV file")));
            }
            let file = File::open(path).map_err(|error| match error.kind() {
                io::ErrorKind::NotFound => {
                    Failure::BadInput(format!("{name}: there is no such file\n  help: check the path"))
                }
                _ => Failure::BadInput(format!(
                    "{name}: cannot be read: {error}\n  help: check its permissions"
                )),
            })?;
            (name, Box::new(BufReader::new(file)))
        };
        let understood = Arc::new(AtomicU64::new(0));
        let source: Box<dyn Read + Send> =
            Box::new(Rows { source, read: 0, understood: Arc::clone(&understood) });
        let mut reader = ReaderBuilder::new().from_reader(source);
        let mut header = reader.byte_headers().map_err(|error| read_error(&name, &error))?.clone();
        // Some spreadsheets begin a file with a byte order mark, which is no part of the first name.
        if let Some(first) = header.get(0).and_then(|first| first.strip_prefix("\u{feff}".as_bytes())) {
            let fields = std::iter::once(first).chain(header.iter().skip(1));
            header = fields.collect();
        }
        Ok(Self { name, reader, header, understood })
    }

    /// The next rows, at most [`BATCH`]; none at the end.
    fn batch(&mut self) -> Result<Vec<ByteRecord>, Failure> {
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
}

/// An error of the table itself, with its line.
fn read_error(name: &str, error: &csv::Error) -> Failure {
    let line = error.position().map_or(1, csv::Position::line);
    match error.kind() {
        csv::ErrorKind::UnequalLengths { expected_len, len, .. } => Failure::BadInput(format!(
            "{name}:{line}: the row has {len} fields, the header {expected_len}\n  help: give every row as many fields as the header"
        )),
        _ => Failure::BadInput(format!("{name}:{line}: cannot be read: {error}\n  help: check the file")),
    }
}

/// The table being written, out of sight until it is complete.
struct Output {
    file: Spool,
    overwrite: bool,
}

enum Spool {
    /// Beside its final place.
    Beside { file: BufWriter<tempfile::NamedTempFile>, path: PathBuf },
    /// Bound for standard output.
    Standard(tempfile::SpooledTempFile),
}

impl Write for Spool {
    fn write(&mut self, buffer: &[u8]) -> io::Result<usize> {
        match self {
            Spool::Beside { file, .. } => file.write(buffer),
            Spool::Standard(file) => file.write(buffer),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Spool::Beside { file, .. } => file.flush(),
            Spool::Standard(file) => file.flush(),
        }
    }
}

impl Output {
    fn open(path: &Path, overwrite: bool) -> Result<Self, Failure> {
        if path == Path::new("-") {
            return Ok(Self { file: Spool::Standard(tempfile::spooled_tempfile(SPOOL)), overwrite });
        }
        let name = path.display();
        if path.is_dir() {
            return Err(Failure::BadInput(format!(
                "--out {name}: this is a folder\n  help: name a CSV file"
            )));
        }
        if !overwrite && path.symlink_metadata().is_ok() {
            return Err(exists(path));
        }
        let folder = match path.parent() {
            Some(folder) if !folder.as_os_str().is_empty() => folder,
            _ => Path::new("."),
        };
        let mut builder = tempfile::Builder::new();
        builder.prefix(".slipmap-").suffix(".csv.part");
        #[cfg(unix)]
        {
            use std::os::unix::fs::PermissionsExt as _;
            // Those of any new file; the default of temporary files is readable by their owner only.
            builder.permissions(std::fs::Permissions::from_mode(0o666));
        }
        let file = builder.tempfile_in(folder).map_err(|error| {
            Failure::BadInput(format!(
                "--out {name}: cannot write into the folder {}: {error}\n  help: choose a folder that exists and is yours",
                folder.display()
            ))
        })?;
        Ok(Self { file: Spool::Beside { file: BufWriter::new(file), path: path.to_owned() }, overwrite })
    }

    /// Gives the complete table its name.
    fn publish(self) -> Result<(), Failure> {
        match self.file {
            Spool::Standard(mut file) => {
                file.seek(SeekFrom::Start(0))?;
                let mut out = io::stdout().lock();
                io::copy(&mut file, &mut out)?;
                Ok(out.flush()?)
            }
            Spool::Beside { file, path } => {
                let failed =
                    |error: io::Error| Failure::Broken(format!("cannot write {}: {error}", path.display()));
                let file = file.into_inner().map_err(|error| failed(error.into_error()))?;
                let named = if self.overwrite { file.persist(&path) } else { file.persist_noclobber(&path) };
                match named {
                    Ok(_) => Ok(()),
                    Err(error) if error.error.kind() == io::ErrorKind::AlreadyExists => Err(exists(&path)),
                    Err(error) => Err(failed(error.error)),
                }
            }
        }
    }
}

fn exists(path: &Path) -> Failure {
    Failure::BadInput(format!(
        "--out {}: the file exists already\n  help: choose another name, or add --overwrite to replace it",
        path.display()
    ))
}

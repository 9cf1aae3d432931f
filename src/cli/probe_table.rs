//! `slipmap probe --points`: every answer about each row of a table.

use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use csv::{ByteRecord, WriterBuilder};
use indicatif::ProgressBar;
use rayon::prelude::*;

use super::notes::tell_units;
use super::output::{exact, short};
use super::point::check_law;
use super::probe_arguments::Arguments;
use super::replace::{self, Files};
use super::report::{existing, unwritten};
use super::threads::not_started;
use super::{Ended, Failure, interrupt, probe_machine};
use slipmap_column::{Method, slip_cycle_count};
use slipmap_config::{MachineJob, PointTable};
use slipmap_files::csv::is_formula;
use slipmap_files::{folder_of, publish_file, temporary_in};
use slipmap_machine::assessment::StandardErrors;
use slipmap_machine::behaviour::growth_time;
use slipmap_machine::probe::Answer;
use slipmap_machine::risk::Spread;
use slipmap_machine::{Dimension, Friction, INERTIA, Machine, Motion};
use slipmap_map::{Description, Quantity, dimension};
use slipmap_model::friction::Law;
use slipmap_model::point::Point;

/// Answers for standard output are held in memory up to this size, then in a temporary file.
const SPOOL: usize = 16 << 20;

/// What is written of the rows.
struct Job<'a> {
    arguments: &'a Arguments,
    /// The table to write, `-` for standard output.
    output: &'a Path,
    about: About<'a>,
    /// The methods whose verdicts are appended.
    methods: Vec<Method>,
}

/// Contents of the rows of a table.
#[derive(Debug)]
pub(super) enum About<'a> {
    /// Points of a law.
    Law(Law),
    /// Machines: the machine of this file, with the quantities given in the table.
    Machine(&'a MachineJob, &'a Path),
}

impl About<'_> {
    /// The files that are read, `points` among them.
    fn files<'b>(&'b self, points: &'b Path) -> Files<'b> {
        match self {
            About::Law(law) => Files::reading([points]).law(law),
            About::Machine(job, file) => Files::reading([points, file]).machine(&job.machine),
        }
    }
}

pub(super) fn run(arguments: &Arguments, mut about: About) -> Result<Ended, Failure> {
    let (Some(input), Some(output)) = (&arguments.points, &arguments.out) else {
        return Err(Failure::bad_input("--points needs --out", "name the table to be written"));
    };
    let stop = interrupt::flag();
    let table = match &about {
        About::Law(law) => {
            let (table, law) = PointTable::open(input, law, &arguments.point.given)?;
            about = About::Law(law);
            table
        }
        About::Machine(of, file) => {
            let quantities = of.machine.quantities().into_iter().map(|(name, _)| name);
            let rotates = of.machine.motion == Motion::Rotation;
            let quantities: Vec<&str> = quantities.chain(rotates.then_some(INERTIA)).collect();
            let given: Vec<String> = arguments.point.settings().into_iter().map(|(name, _)| name).collect();
            let table = PointTable::of_machines(input, &quantities, &of.machine, &given)?;
            tell_units(&table.conversions);
            probe_machine::check_single(of, file, |name| table.has(name))?;
            table
        }
    };
    let methods = Method::usual().chain(arguments.validated.then(Method::validated)).collect();
    let job = Job { arguments, output, about, methods };
    check_header(&table, &job)?;
    let mut output = Output::open(output, job.about.files(input), arguments.overwrite)?;
    let pool = slipmap_map::pool(arguments.threads).map_err(not_started)?;
    let bar = super::progress::bar(arguments.quiet, None, "rows");
    pool.install(|| convert(&job, table, &mut output, stop, &bar))?;
    bar.finish_and_clear();
    output.publish()?;
    Ok(Ended::Fine)
}

/// Reads, computes and writes rows batch by batch.
fn convert(
    job: &Job,
    mut table: PointTable,
    output: &mut Output,
    stop: &AtomicBool,
    bar: &ProgressBar,
) -> Result<(), Failure> {
    let mut header = without_formulas(&table.header);
    for name in answer_columns(job) {
        header.push_field(name.as_bytes());
    }
    let mut writer = WriterBuilder::new().from_writer(output.writer());
    let write_error = |error: csv::Error| match error.into_kind() {
        csv::ErrorKind::Io(error) => unwritten(job.output, &error),
        other => Failure::Broken(format!("cannot write {}: {other:?}", job.output.display())),
    };
    writer.write_byte_record(&header).map_err(write_error)?;
    loop {
        let batch = table.rows()?;
        if batch.is_empty() {
            break;
        }
        let answered: Vec<ByteRecord> = batch
            .into_par_iter()
            .map(|row| {
                if stop.load(Ordering::Relaxed) {
                    return Err(Failure::Interrupted(super::NOTHING_LEFT.into()));
                }
                answer(&table, &row, job)
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

/// The machine of the rows, if its friction was measured or fitted, and so has errors of its own.
fn with_errors<'a>(job: &'a Job) -> Option<&'a MachineJob> {
    let About::Machine(of, _) = &job.about else { return None };
    let is_fitted = of.uncertain.iter().any(|(_, spread)| matches!(spread, Spread::Joint { .. }));
    (is_fitted || matches!(of.machine.friction, Friction::Measured(_))).then_some(of)
}

/// Names of the appended columns; for a machine with their units.
fn answer_columns(job: &Job) -> Vec<String> {
    let unit = |name: &str| match (&job.about, dimension::of_variable(name)) {
        (About::Machine(of, _), Some(dimension)) => format!("{name} [{}]", of.machine.motion.unit(dimension)),
        _ => name.to_owned(),
    };
    let mut names = Vec::new();
    for method in &job.methods {
        names.push(format!("verdict_{}", method.name()));
        names.push(unit(&format!("margin_{}", method.name())));
    }
    let critical = match &job.about {
        About::Law(_) => ["critical_c", "critical_c_error"].map(str::to_owned),
        About::Machine(of, _) => {
            let unit = of.machine.motion.unit(Dimension::Damping);
            ["critical_damping", "critical_damping_error"].map(|name| format!("{name} [{unit}]"))
        }
    };
    names.extend(critical);
    if let Some(of) = with_errors(job) {
        let unit = of.machine.motion.unit(Dimension::Damping);
        names.push(format!("critical_damping_standard_error [{unit}]"));
        names.push("regimes_left_open_by_data".to_owned());
    }
    names.push("regime".to_owned());
    names.extend(Quantity::of_orbits().map(|quantity| unit(quantity.name())));
    if job.arguments.epsilon_limits {
        names.extend(job.methods.iter().map(|method| format!("epsilon_limit_{}", method.name())));
    }
    names
}

/// Refuses a table that already has a column with an appended name.
fn check_header(table: &PointTable, job: &Job) -> Result<(), Failure> {
    let header: Vec<_> = table.header.iter().map(|field| String::from_utf8_lossy(field)).collect();
    match answer_columns(job).into_iter().find(|name| header.iter().any(|field| field.trim() == name)) {
        Some(taken) => Err(Failure::bad_input(
            format!("{}:1: the column `{taken}` is there already, and would be added", table.name),
            "rename it or take it out",
        )),
        None => Ok(()),
    }
}

/// The oscillator of a row, and the machine if it is one's.
fn oscillator(
    table: &PointTable,
    row: &ByteRecord,
    about: &About,
) -> Result<(Law, Point, Option<Machine>), Failure> {
    let at = |problem: String| Failure::BadInput(format!("{}: {problem}", table.place(row)));
    match about {
        About::Law(law) => {
            let point = table.point(row, law)?;
            check_law(law, &point).map_err(at)?;
            Ok((law.clone(), point, None))
        }
        About::Machine(of, _) => {
            let mut machine = of.machine.clone();
            // Checked when all are set: a row may change both coefficients of friction.
            let values = table.values(row)?;
            let is_known = values.iter().all(|(name, value)| machine.set(name, *value));
            if !(is_known && machine.is_legal()) {
                let illegal = machine.illegal().map(|(name, ..)| name);
                let of_row = |name: &&str| values.iter().any(|(known, _)| known == name);
                let last = values.last().map_or("", |(name, _)| name);
                let problem = "makes no machine: masses, stiffnesses, forces and speeds are greater than 0";
                return Err(table.illegal(row, illegal.filter(of_row).unwrap_or(last), problem).into());
            }
            if let Friction::Measured(data) = &machine.friction
                && data.fastest() < 2.0 * machine.belt_speed
            {
                let (end, speed) = (data.fastest(), machine.belt_speed);
                let origin = data.origin();
                return Err(at(format!(
                    "the data of {origin} end at slip speed {end}, below twice the belt speed {speed}"
                )));
            }
            let leaves = || at("the friction leaves the numbers\n  help: check the units".into());
            let model = machine.model().ok_or_else(leaves)?;
            Ok((model.law, model.point, Some(machine)))
        }
    }
}

/// The cells of the input as they are copied: with an apostrophe before what a spreadsheet would take for a
/// formula.
fn without_formulas(row: &ByteRecord) -> ByteRecord {
    row.iter()
        .map(|cell| match is_formula(&String::from_utf8_lossy(cell)) {
            true => [b"'", cell].concat(),
            false => cell.to_vec(),
        })
        .collect()
}

fn answer(table: &PointTable, row: &ByteRecord, job: &Job) -> Result<ByteRecord, Failure> {
    let (law, point, machine) = oscillator(table, row, &job.about)?;
    let si = machine.as_ref().map(Machine::units);
    let mut row = without_formulas(row);
    let answer = Answer::of(&law, &point, job.arguments.tolerance, job.methods.iter().copied());
    let number = |x: f64| if x.is_nan() { String::new() } else { exact(x) };
    let factor = |name: &str| {
        let dimension = dimension::of_variable(name);
        si.zip(dimension).map_or(1.0, |(si, dimension)| si.factor(dimension))
    };
    for method in &answer.methods {
        row.push_field(method.verdict.name().as_bytes());
        let name = format!("margin_{}", method.method.name());
        row.push_field(number(method.margin * factor(&name)).as_bytes());
    }
    let damping = si.map_or(1.0, |si| si.damping);
    let root = answer.critical.ok();
    let scaled = |of: Option<f64>| of.map_or(f64::NAN, |x| x * damping);
    let critical = scaled(root.and_then(|root| root.known().ok()).map(|root| root.c));
    let error = scaled(root.map(|root| root.error));
    row.push_field(number(critical).as_bytes());
    row.push_field(if error.is_nan() { String::new() } else { short(error) }.as_bytes());
    if let (Some(of), Some(machine)) = (with_errors(job), &machine) {
        let errors = StandardErrors::of_dampings(machine, &of.uncertain);
        let critical = errors.and_then(|errors| errors.critical_damping);
        row.push_field(critical.map_or_else(String::new, |of| short(of.standard_error)).as_bytes());
        let open = errors.map(|errors| errors.leave_open(machine.damping, answer.regime).names().join(" "));
        row.push_field(open.unwrap_or_default().as_bytes());
    }
    row.push_field(answer.regime.name().as_bytes());
    let described = Description {
        landing: answer.flow.landing(),
        slip_cycles: slip_cycle_count(&answer.oscillator, &answer.flow),
        cycle: answer.cycle,
        boundary: answer.basin,
        growth_time: growth_time(&answer.oscillator),
    };
    for quantity in Quantity::of_orbits() {
        row.push_field(number(described.value(quantity) * factor(quantity.name())).as_bytes());
    }
    if job.arguments.epsilon_limits {
        for limit in answer.limits(true) {
            row.push_field(number(limit.value()).as_bytes());
        }
    }
    Ok(row)
}

/// The table being written, under a temporary name until it is complete.
enum Output {
    /// In a temporary file beside its final path.
    Beside { file: BufWriter<tempfile::NamedTempFile>, path: PathBuf, overwrite: bool },
    /// For standard output.
    Standard(tempfile::SpooledTempFile),
}

impl Output {
    fn writer(&mut self) -> &mut dyn Write {
        match self {
            Output::Beside { file, .. } => file,
            Output::Standard(file) => file,
        }
    }

    fn open(path: &Path, files: Files, overwrite: bool) -> Result<Self, Failure> {
        if path == Path::new("-") {
            return Ok(Self::Standard(tempfile::spooled_tempfile(SPOOL)));
        }
        let name = path.display();
        if path.is_dir() {
            return Err(Failure::bad_input(format!("--out {name}: this is a folder"), "name a CSV file"));
        }
        files.writing("--out", Some(path)).check(overwrite)?;
        let folder = folder_of(path);
        let file = temporary_in(folder).map_err(|error| {
            let problem = format!("--out {name}: cannot write into the folder {}: {error}", folder.display());
            Failure::bad_input(problem, "choose a folder that exists and is yours")
        })?;
        let temporary = file.path().to_owned();
        interrupt::on_abandonment(super::NOTHING_LEFT.to_owned(), move || {
            // An error of removing the file is ignored.
            let _ = std::fs::remove_file(temporary);
        });
        Ok(Self::Beside { file: BufWriter::new(file), path: path.to_owned(), overwrite })
    }

    /// Gives the complete table its name, or copies it to standard output.
    fn publish(self) -> Result<(), Failure> {
        match self {
            Output::Standard(mut file) => {
                file.seek(SeekFrom::Start(0))?;
                let mut out = io::stdout().lock();
                io::copy(&mut file, &mut out)?;
                Ok(out.flush()?)
            }
            Output::Beside { file, path, overwrite } => {
                let failed = |error: io::Error| unwritten(&path, &error);
                let file = file.into_inner().map_err(|error| failed(error.into_error()))?;
                publish_file(file, &path, existing(overwrite)).map_err(|error| match error.kind() {
                    io::ErrorKind::AlreadyExists => replace::exists(path.display()),
                    _ => failed(error),
                })
            }
        }
    }
}

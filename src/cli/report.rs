//! `slipmap report`: tables and figures from a stored map.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::Args;

use super::replace::{self, Files};
use super::width::{TWO, width};
use super::{Ended, Failure, interrupt, progress, say};
use slipmap_figure::FigureError;
use slipmap_files::{Existing, WriteError};
use slipmap_format::{MapFile, StoreError};
use slipmap_map::Control;
use slipmap_report::figure::Width;
use slipmap_report::{Report, ReportError, ReportOptions, View};
use slipmap_study::benchmark::StudyError;

/// Write tables and figures that compare the methods of a map.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap report results/quickstart.h5
  slipmap report results/quickstart.h5 --out paper/map
  slipmap report results/paper.h5 --data
  slipmap report results/paper.h5 --methods symmetric,validated --epsilon 0.1

Writes report.html, report.tex, tables/NAME.tex and .csv, and figures/NAME.svg, \
.pdf and .png.")]
pub(super) struct Arguments {
    /// The map
    #[arg(value_name = "MAP.h5")]
    map: PathBuf,
    /// The folder to write; default: MAP-report beside the map
    #[arg(long, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Every figure also writes its numbers: figures/NAME.csv
    #[arg(long)]
    data: bool,
    /// Width of figures and tables, in columns of a journal
    #[arg(long, value_parser = width(), default_value = TWO)]
    width: Width,
    /// The methods in the tables, as for a table that fits a column
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    methods: Vec<String>,
    /// The values of epsilon in the tables
    #[arg(long, value_name = "VALUE", value_delimiter = ',')]
    epsilon: Vec<f64>,
    /// Replace the files of an earlier report
    #[arg(long)]
    overwrite: bool,
    /// No progress bar
    #[arg(long)]
    quiet: bool,
}

pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let map = open(&arguments.map)?;
    let folder = arguments.out.clone().unwrap_or_else(|| {
        let mut name = arguments.map.file_stem().unwrap_or_default().to_owned();
        name.push("-report");
        arguments.map.with_file_name(name)
    });
    // Checked before the work starts.
    Files::reading([&arguments.map]).writing("--out", Some(&folder)).check(arguments.overwrite)?;
    if folder.is_file() {
        let problem = format!("--out {}: this is a file", folder.display());
        return Err(Failure::bad_input(problem, "name a folder"));
    }
    if map.grid().machine().is_some() && !arguments.epsilon.is_empty() {
        return Err(Failure::bad_input(
            "--epsilon: the map of a machine has no axis epsilon",
            "leave it out",
        ));
    }
    let bar = progress::bar(arguments.quiet, Some(map.grid().cells() as u64), "cells");
    let on_cells = |cells| bar.inc(cells as u64);
    let control = Control { on_cells: &on_cells, stop: interrupt::flag(), ..Control::default() };
    let report = Report::gather(&map, &control).map_err(failure)?;
    bar.finish_and_clear();
    let view = View::new(&map);
    let Arguments { data, width, overwrite, .. } = *arguments;
    let (methods, epsilons) = (arguments.methods.clone(), arguments.epsilon.clone());
    let options = ReportOptions { existing: existing(overwrite), data, width, methods, epsilons };
    slipmap_report::write(&view, &report, &folder, &options).map_err(failure)?;
    writeln!(io::stdout().lock(), "{}", folder.join("report.html").display())?;
    Ok(Ended::Fine)
}

/// Opens and verifies a map; one that cannot be read or is damaged is bad input.
pub(super) fn open(path: &Path) -> Result<MapFile, Failure> {
    let map = MapFile::open(path).map_err(|error| unreadable(&error))?;
    if !map.sealed {
        say(&format!(
            "note: {} has no seal, since another program has written to it or copied it; its cells were \
             compared with their fingerprints instead, its attributes are taken as they are",
            path.display()
        ));
    }
    Ok(map)
}

/// Converts an error of opening or reading a map.
pub(super) fn unreadable(error: &StoreError) -> Failure {
    if let StoreError::Io { path, source, .. } = error
        && source.kind() == io::ErrorKind::NotFound
    {
        let problem = format!("{}: there is no such file", path.display());
        return Failure::bad_input(problem, "check the path; `slipmap run` prints that of its map");
    }
    let help = match error {
        StoreError::NotAMap { .. } => "\n  help: name a file written by `slipmap run`".into(),
        StoreError::Damaged { path, .. } => format!(
            "\n  help: `slipmap check {}` tells where; take an undamaged copy, or compute the map again with \
             `slipmap run ... --overwrite`",
            path.display()
        ),
        _ => String::new(),
    };
    Failure::BadInput(format!("{error}{help}"))
}

pub(super) fn existing(overwrite: bool) -> Existing {
    if overwrite { Existing::Replace } else { Existing::Refuse }
}

/// The failure to write a file, with what to do about it.
pub(super) fn unwritten(path: &Path, error: &io::Error) -> Failure {
    use io::ErrorKind::{
        AlreadyExists, FileTooLarge, InvalidFilename, IsADirectory, NotADirectory, PermissionDenied,
        QuotaExceeded, ReadOnlyFilesystem, StorageFull,
    };
    // Without a number of the system the text names a temporary file.
    let why = error.raw_os_error().map_or_else(|| error.kind().to_string(), |_| error.to_string());
    let problem = format!("cannot write {}: {why}", path.display());
    let (is_input, help) = match error.kind() {
        StorageFull | QuotaExceeded | FileTooLarge => {
            (false, "free space, raise the quota or the limit on file sizes (ulimit -f), or write elsewhere")
        }
        PermissionDenied | ReadOnlyFilesystem => (true, "choose a folder that is yours"),
        AlreadyExists | NotADirectory | IsADirectory => {
            (true, "a file is where a folder is needed, or the reverse; choose another name")
        }
        InvalidFilename => (true, "choose a shorter name"),
        _ => (false, "choose another place"),
    };
    match is_input {
        true => Failure::bad_input(problem, help),
        false => Failure::Broken(format!("{problem}\n  help: {help}")),
    }
}

pub(super) fn failure(error: impl Into<ReportError>) -> Failure {
    match error.into() {
        ReportError::Write(error) | ReportError::Figure(FigureError::Write(error)) => match error {
            WriteError::Exists(path) => replace::exists(path.display()),
            WriteError::NoFolder { .. } | WriteError::NotYours { .. } => Failure::BadInput(error.to_string()),
            WriteError::Io { path, source } => unwritten(&path, &source),
        },
        ReportError::Map(error) => unreadable(&error),
        ReportError::Interrupted | ReportError::Study(StudyError::Interrupted) => {
            Failure::Interrupted(super::NOTHING_LEFT.into())
        }
        error @ (ReportError::Figure(FigureError::Format(_))
        | ReportError::Choice(_)
        | ReportError::Study(StudyError::NoReference { .. })
        | ReportError::Peers { .. }) => Failure::BadInput(error.to_string()),
        error => Failure::Broken(error.to_string()),
    }
}

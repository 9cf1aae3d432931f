//! Reports of stored maps for papers: numbers, tables and figures that compare the methods.
//!
//! Numbers are gathered tile by tile ([`Report::gather`]), so maps may be far larger than memory. Every table
//! is made once, independent of formats ([`tables`]), and written as HTML, LaTeX and CSV; every
//! figure is drawn once as a scene ([`figure`]) and written as SVG, PDF and PNG.

// Only the program and its tests use this crate.
#![allow(missing_docs)]

mod boundary;
mod document;
pub mod figure;
mod fit_figure;
pub mod proved;
mod stale;
mod summary;
mod table;
pub mod tables;
mod units;
mod verdicts;
pub mod work_precision;
mod write;

use std::io;
use std::path::PathBuf;
use std::sync::atomic::Ordering;

pub use boundary::{Boundaries, MethodBoundary};
pub use fit_figure::FitFigure;
pub use slipmap_figure::csv::{csv_text, is_formula};
pub use slipmap_figure::text::{Rich, rich};
pub use table::{Cell, Table};
pub use units::View;
pub use units::{Label, UnitSystem};
pub use verdicts::{Confusion, Verdicts};
pub use write::{ReportOptions, write};
pub use write::{write_figure, write_file};

pub use slipmap_format::files::Existing;
use slipmap_format::{MapFile, StoreError};
use slipmap_map::map::Control;
pub use slipmap_page::{MachinePage, Subject, formula, to_json};
pub use slipmap_study::benchmark::StudyError;

/// Name of the method with which all others are compared.
pub(crate) const SIMULATION: &str = "simulation";

/// Reason why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    /// The map cannot be read.
    #[error(transparent)]
    Map(#[from] StoreError),
    /// This output exists already.
    #[error("{0} exists already; choose another place, or ask for it to be replaced")]
    Exists(PathBuf),
    /// The folder of the output does not exist.
    #[error("{path}: there is no folder {folder}; create it, or choose another place")]
    NoFolder {
        /// The output.
        path: PathBuf,
        /// The folder.
        folder: PathBuf,
    },
    /// The folder of the output cannot be written.
    #[error("{path}: cannot write into the folder {folder}: {source}; choose a folder that is yours")]
    NotYours {
        /// The output.
        path: PathBuf,
        /// The folder.
        folder: PathBuf,
        /// The file system's reason.
        source: io::Error,
    },
    /// The extension of this figure's name is not that of a known format.
    #[error("{0} does not end in .svg, .pdf or .png; give the figure one of these endings")]
    Format(PathBuf),
    /// A file could not be written.
    #[error("cannot write {path}: {source}")]
    Io {
        /// The file to be written.
        path: PathBuf,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A figure could not be converted from SVG.
    #[error(transparent)]
    Render(#[from] slipmap_figure::render::RenderError),
    /// The map has no such axis, variable or the like.
    #[error(transparent)]
    Choice(#[from] figure::ChoiceError),
    /// There is no study to report.
    #[error(transparent)]
    Study(#[from] StudyError),
    /// The peers' measurements cannot be read.
    #[error("{path}: {why}; make it anew with scripts/study peers, or name another file")]
    Peers {
        /// The file.
        path: PathBuf,
        /// The problem.
        why: String,
    },
    /// [`Control::stop`] was set.
    #[error("interrupted")]
    Interrupted,
}

/// Returns [`ReportError::Interrupted`] if [`Control::stop`] is set.
fn check(control: &Control) -> Result<(), ReportError> {
    match control.stop.load(Ordering::Relaxed) {
        true => Err(ReportError::Interrupted),
        false => Ok(()),
    }
}

/// All numbers of a report.
#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    /// Statistics of the verdicts.
    pub verdicts: Verdicts,
    /// Errors of the boundaries.
    pub boundaries: Boundaries,
}

impl Report {
    /// Reads a map tile by tile and reports the number of cells read to `control`.
    ///
    /// # Errors
    /// [`ReportError::Map`] if the map cannot be read, [`ReportError::Interrupted`].
    pub fn gather(map: &MapFile, control: &Control) -> Result<Self, ReportError> {
        Ok(Self { verdicts: Verdicts::read(map, control)?, boundaries: Boundaries::read(map, control)? })
    }
}

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
use slipmap_map::Control;
pub use slipmap_page::{MachinePage, Subject, formula, to_json};
pub use slipmap_study::benchmark::StudyError;

/// Name of the method with which all others are compared.
pub(crate) const SIMULATION: &str = "simulation";

/// Reason why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error(transparent)]
    Map(#[from] StoreError),
    #[error("{0} exists already; choose another place, or ask for it to be replaced")]
    Exists(PathBuf),
    #[error("{path}: there is no folder {folder}; create it, or choose another place")]
    NoFolder { path: PathBuf, folder: PathBuf },
    #[error("{path}: cannot write into the folder {folder}: {source}; choose a folder that is yours")]
    NotYours { path: PathBuf, folder: PathBuf, source: io::Error },
    #[error("{0} does not end in .svg, .pdf or .png; give the figure one of these endings")]
    Format(PathBuf),
    #[error("cannot write {path}: {source}")]
    Io { path: PathBuf, source: std::io::Error },
    #[error(transparent)]
    Render(#[from] slipmap_figure::render::RenderError),
    #[error(transparent)]
    Choice(#[from] figure::ChoiceError),
    #[error(transparent)]
    Study(#[from] StudyError),
    #[error("{path}: {why}; make it anew with scripts/study peers, or name another file")]
    Peers { path: PathBuf, why: String },
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

#[derive(Clone, Debug, PartialEq)]
pub struct Report {
    pub verdicts: Verdicts,
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

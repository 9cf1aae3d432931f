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
pub mod proved;
mod stale;
mod summary;
mod table;
pub mod tables;
mod verdicts;
mod view;
pub mod work_precision;
mod write;

use std::path::PathBuf;
use std::sync::atomic::Ordering;

pub use boundary::{Boundaries, MethodBoundary};
pub use table::{Cell, Table};
pub use verdicts::{Confusion, Verdicts};
pub use view::View;
pub use write::{ReportOptions, write};

use slipmap_figure::FigureError;
use slipmap_files::WriteError;
use slipmap_format::{MapFile, StoreError};
use slipmap_map::Control;
pub use slipmap_study::benchmark::StudyError;

/// Name of the method with which all others are compared.
pub(crate) const SIMULATION: &str = "simulation";

/// Reason why there is no report.
#[derive(Debug, thiserror::Error)]
pub enum ReportError {
    #[error(transparent)]
    Map(#[from] StoreError),
    #[error(transparent)]
    Render(#[from] slipmap_figure::render::RenderError),
    #[error(transparent)]
    Write(#[from] WriteError),
    #[error(transparent)]
    Figure(#[from] FigureError),
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

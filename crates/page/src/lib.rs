//! The page of a machine, as a picture, as HTML and as JSON, and figures of an orbit and of a fit, without HDF5; with the
//! units, fills and lines of regimes and curves that all figures share.

// Only the program and the Python package use this crate.
#![allow(missing_docs)]

pub mod curves;
mod fit_figure;
pub mod formula;
pub mod html;
mod json;
mod machine_page;
pub mod orbit;
pub mod palette;
pub mod portrait;
pub mod units;

pub use fit_figure::FitFigure;
pub use json::to_json;
pub use machine_page::{MachinePage, Subject, Written, percent};

//! The page of a machine, as a picture, as HTML and as JSON, without HDF5; with the fills and lines of regimes and curves
//! that all figures share.

// Only the program and the Python package use this crate.
#![allow(missing_docs)]

pub mod curves;
pub mod formula;
pub mod html;
mod json;
mod machine_page;
pub mod palette;

pub use json::to_json;
pub use machine_page::{MachinePage, Subject, Written, percent};

//! Drawing: scenes with axes, panels and legends, texts with mathematical symbols, and the files that they become
//! (SVG, PDF, PNG, CSV). It knows nothing of friction.

// Only the program and the Python package use this crate.
#![allow(missing_docs)]

mod advances;
pub mod axis;
pub mod data;
pub mod legend;
pub mod lines;
pub mod panels;
pub mod paragraph;
pub mod region;
#[cfg(feature = "files")]
pub mod render;
pub mod scene;
pub mod strips;
pub mod style;
pub mod text;
#[cfg(feature = "files")]
mod write;

#[cfg(feature = "files")]
pub use write::{FigureError, write_figure};

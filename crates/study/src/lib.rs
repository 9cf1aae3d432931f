//! The studies that a paper needs: where methods fail, and speed against accuracy.

// Only the program and its tests use this crate.
#![allow(missing_docs)]

pub mod benchmark;
pub mod failures;

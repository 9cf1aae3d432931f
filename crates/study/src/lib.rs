//! The studies that a paper needs: where methods fail, and speed against accuracy.

pub mod benchmark;
pub mod failures;

//! The map file.

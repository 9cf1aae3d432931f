//! The map file and its readers, without the program.
//!
//! To run one part alone: `cargo test --test files store::`.

#![cfg(all(unix, feature = "cli"))]
// clippy.toml exempts only test functions, not their helpers.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod fuzz;
mod store;

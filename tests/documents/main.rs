//! Checks the statements of the documents about the sources and the program.
//!
//! To run one part alone: `cargo test --test documents architecture::`.

#![cfg(all(unix, feature = "cli"))]
// clippy.toml exempts only test functions, not their helpers.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod architecture;
mod guide;
mod package;
mod results;

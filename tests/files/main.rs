//! The map file and what reads it, without the program around it.
//!
//! One part alone: `cargo test --test files store::`.

#![cfg(all(unix, feature = "cli"))]
// clippy.toml exempts only test functions, and not what helps them.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod fuzz;
mod messages;
mod store;
mod writer_rate;

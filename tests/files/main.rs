//! The map file and what reads it, without the program around it.
//!
//! One part alone: `cargo test --test files store::`.

#![cfg(all(unix, feature = "cli"))]
#![allow(clippy::unwrap_used, clippy::expect_used)] // helpers of tests, which clippy.toml exempts only inside test functions

mod fuzz;
mod messages;
mod store;
mod writer_rate;

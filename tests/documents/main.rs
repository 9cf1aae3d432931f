//! What the documents say of the sources and of the program is true.
//!
//! One part alone: `cargo test --test documents architecture::`.

#![cfg(all(unix, feature = "cli"))]
#![allow(clippy::unwrap_used, clippy::expect_used)] // helpers of tests, which clippy.toml exempts only inside test functions

mod architecture;
mod guide;
mod package;

//! What the documents say of the sources and of the program is true.
//!
//! One part alone: `cargo test --test documents architecture::`.

#![cfg(all(unix, feature = "cli"))]
// clippy.toml exempts only test functions, and not what helps them.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod architecture;
mod guide;
mod package;

//! The program as its users run it: commands, messages, exit codes, what is written and what survives.
//!
//! One part alone: `cargo test --test program resume::`.

#![cfg(all(unix, feature = "cli"))]
// clippy.toml exempts only test functions, and not what helps them.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod benchmark;
mod catalogue;
mod command;
mod config;
mod curves;
mod damage;
mod explore;
mod extremes;
mod hostile;
mod latex;
mod laws;
mod long_axes;
mod machine;
mod map_equal;
#[cfg(target_os = "linux")]
mod mounts;
#[cfg(all(target_os = "linux", feature = "mpi"))]
mod mpi;
mod probe;
mod proofs;
mod reference_page;
mod replace;
mod report;
mod resume;
mod run;

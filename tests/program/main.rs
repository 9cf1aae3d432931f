//! The program as users run it: commands, messages, exit codes, output files and resumed runs.
//!
//! To run one part alone: `cargo test --test program resume::`.

#![cfg(all(unix, feature = "cli"))]
// clippy.toml exempts only test functions, not their helpers.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod benchmark;
mod catalogue;
mod command;
mod config;
mod curves;
mod damage;
mod errors;
mod explore;
mod extremes;
mod fit;
mod hostile;
mod init;
mod latex;
mod laws;
mod long_axes;
mod machine;
mod machine_axes;
mod machine_laws;
mod machine_limits;
mod map_equal;
#[cfg(target_os = "linux")]
mod mounts;
mod neutral;
mod parity;
mod probe;
mod proofs;
mod reference_page;
mod replace;
mod report;
mod resume;
mod run;
mod shards;
mod two_coefficients;

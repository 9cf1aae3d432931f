//! The mathematics: every statement of the theory, every method and every engine, against exact identities,
//! against each other and against tables in extended precision.
//!
//! One part alone: `cargo test --test mathematics identities::`.

#![cfg(feature = "cli")]
// which brings the csv reader of the tables
// clippy.toml exempts only test functions, and not what helps them.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod agreement;
mod backbone;
mod budgets;
mod certificates;
mod claims;
mod columns;
mod curves;
mod direct;
mod failures;
mod forger;
mod forms;
mod identities;
mod laws;
mod limits;
mod reference;
mod reference_data;
mod regimes;
mod return_map;
mod sample;
mod sensitivity;
mod slip_count;
mod slip_laws;
mod theory;
mod validated;

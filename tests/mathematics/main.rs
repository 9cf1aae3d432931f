//! The mathematics: every statement of the theory, every method and every engine, compared with exact
//! identities, with each other and with tables in extended precision.
//!
//! To run one part alone: `cargo test --test mathematics identities::`.

#![cfg(feature = "config")]
// The tables are read with csv, of the feature `config`, and serde. clippy.toml exempts only test functions,
// not their helpers.
#![allow(clippy::unwrap_used, clippy::expect_used)]

mod agreement;
mod backbone;
mod budgets;
mod certificates;
mod claims;
mod closing;
mod columns;
mod crossing;
mod curves;
mod direct;
mod drop;
mod failures;
mod flow;
#[cfg(feature = "cli")]
mod forger;
mod forms;
mod growth;
mod identities;
mod interpolation;
mod law_survey;
mod laws;
mod limits;
mod machines;
mod points;
mod reference;
mod reference_data;
mod regimes;
mod runge_kutta;
mod sample;
mod sensitivity;
mod slip_count;
mod slip_laws;
mod steep_laws;
mod theory;

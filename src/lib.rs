//! Where in parameter space a dry-friction oscillator on a moving belt stick-slips, which mathematical
//! test proves it, where each test fails, and what each answer costs.
//!
//! A mass on a spring rides on a belt of speed V. Friction that weakens with the slip speed can drive it
//! into a cycle of sticking and slipping. Six numbers decide: eps, the alpha, beta and gamma of the
//! friction law, V, and the damping c. This crate answers the question "does a stick-slip cycle exist?" by
//! closed-form tests ([`certify`]) and by the simulated flow ([`simulate`]), at one point or at every cell of
//! a grid ([`map`]). The mathematics is in [`theory`].
//!
//! # One point
//! ```
//! use slipmap::certify::{self, Decision, Guarantee};
//! use slipmap::filippov::Oscillator;
//! use slipmap::friction::Law;
//! use slipmap::simulate::{Fate, critical_damping, flow};
//!
//! // eps; alpha, beta, gamma; V; c.
//! let point = Law::Stribeck.point(0.1, &[0.4, 0.2, 2.0], 1.0, 0.6)?;
//!
//! // The simulated flow: the orbit that leaves the belt spirals inward, so there is no cycle.
//! let answer = flow(&Oscillator::new(&Law::Stribeck, &point), 1e-9);
//! assert_eq!(answer.fate, Fate::SpiralsInward);
//! assert!(answer.margin < -answer.margin_error);
//!
//! // The paper's first-order test claims one; the test that is a theorem at every eps denies it.
//! let column = Law::Stribeck.column(&point);
//! let decide = |test: &certify::Test| (test.claim)(&column).decide(point.damping());
//! assert_eq!(decide(&certify::perturbation::TEST), Decision::Present);
//! assert_eq!(decide(&certify::symmetric::TEST), Decision::Absent);
//! assert_eq!(certify::symmetric::TEST.guarantee, Guarantee::FiniteEpsilon);
//!
//! // All dampings at once: the cycle exists below the critical damping and not above it.
//! let critical = critical_damping(&column, 1e-12)?;
//! assert!((certify::instability::TEST.claim)(&column).present_below < critical.c);
//! assert!(critical.c < (certify::symmetric::TEST.claim)(&column).absent_above);
//! let slower = point.at_damping(0.9 * critical.c)?;
//! match flow(&Oscillator::new(&Law::Stribeck, &slower), 1e-9).fate {
//!     Fate::Sticks(landing) => {
//!         let period = landing.slip_time + landing.stick_time;
//!         assert!((period - 2.0 * std::f64::consts::PI).abs() < 0.1);
//!     }
//!     other => panic!("{other:?}"),
//! }
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! # Features
//! `store` (the map file, with the HDF5 library), `report` (tables and figures), `config` (configuration
//! files), `cli` (the program) and `explore` (its web page) are on by default; `serde` makes results
//! serialisable. With none of them, or only `config` and `serde`, the crate is pure Rust.
//!
//! The modules `assessment`, `benchmark`, `cli`, `explore` and `report` belong to the program. They are
//! public for its tests only, are not documented here, and may change at any time.

// `pub` items are reachable by users of the library; the compiler reports unused items, all `pub(crate)`.
#![warn(unreachable_pub)]
// Without the program, the items that only it uses are unused. Unused items are reported with all features.
#![cfg_attr(not(feature = "explore"), allow(dead_code, unused_imports))]

/// Tries the code of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
mod readme {}

#[cfg(feature = "report")]
#[doc(hidden)]
pub mod assessment;
pub mod behaviour;
#[doc(hidden)]
pub mod benchmark;
pub mod certify;
#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;
mod clock;
#[cfg(feature = "config")]
pub mod config;
pub mod dataset;
mod enclosure;
#[cfg(feature = "explore")]
#[doc(hidden)]
pub mod explore;
#[cfg(feature = "store")]
mod files;
pub mod filippov;
pub mod friction;
pub mod machine;
pub mod map;
mod named;
mod number;
pub mod point;
pub mod probe;
mod random;
#[cfg(feature = "report")]
#[doc(hidden)]
pub mod report;
pub mod risk;
pub mod simulate;
#[cfg(feature = "store")]
pub mod store;
#[doc = include_str!("architecture.md")]
pub mod architecture {}
#[doc = include_str!("theory.md")]
pub mod theory {}

//! Where in parameter space a dry-friction oscillator on a moving belt stick-slips, which mathematical
//! test proves it, where each test fails, and what each answer costs.

#[cfg(feature = "report")]
pub mod benchmark;
pub mod certify;
#[cfg(feature = "cli")]
pub mod cli;
#[cfg(feature = "cli")]
pub mod config;
pub mod filippov;
pub mod friction;
pub mod machine;
pub mod map;
pub mod point;
#[cfg(feature = "report")]
pub mod report;
pub mod simulate;
#[cfg(feature = "store")]
pub mod store;

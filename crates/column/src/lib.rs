//! A column asked: one friction curve at one belt speed, at every damping.
//!
//! [`critical_damping`] tells where the orbit from the exit point stops to return, [`backbone`] at which dampings
//! slip orbits close, [`Change`]s at which dampings anything changes, [`regime`] what attracts, [`crossing`] what crosses the belt line, [`bifurcation`] and
//! [`graphs`] the curves in planes along which these change, [`limits`] the eps up to which methods agree.

pub mod backbone;
mod behaviour;
pub mod bifurcation;
mod changes;
pub mod continuation;
pub mod critical;
pub mod crossing;
mod end;
pub mod graphs;
pub mod limits;
mod method;
mod neighbours;
pub mod points;
pub mod sensitivity;
pub mod slip_cycle;
mod verdict;

pub use behaviour::{At, BasinBoundary, Behaviour, Behaviours, LongRun, long_run};
pub use behaviour::{left_out, regime, slip_cycle_count, slip_cycles};
pub use changes::{Change, ChangeKind};
pub use critical::{CriticalDamping, HALVINGS, NoCriticalDamping, SticksFrom, critical_damping, sticks_from};
pub use end::End;
pub use method::Method;
pub use neighbours::{Neighbour, crossing_separates, separates};
pub use verdict::{Attractors, Regime, Verdict};

/// Default bound on the error of the scaled grazing margin.
pub const DEFAULT_TOLERANCE: f64 = 1e-9;
/// Legal tolerances: from the smallest that double precision can meet for a margin of order one, to the
/// largest error that is small compared with such a margin.
pub const TOLERANCES: std::ops::RangeInclusive<f64> = 1e-14..=1e-2;

//! Maps: axes, grid, tiles, the parallel engine, and what a sink of cells is.

mod account;
mod audit;
mod curves;
mod engine;
pub mod failures;
mod grid;
pub mod limits;
mod method;
mod plan;
mod proved;
mod quantity;
mod runs;
mod simulation;
mod sink;
mod verdict;

pub use account::{Account, FailedCell, LISTED, MethodAccount};
pub use audit::{Audit, Disagreement};
pub use curves::{CURVE_COLUMNS, Plane, PlaneCurve, PlaneCurves, PlanePoint, curves_of};
pub use engine::{ComputeError, Control, MethodSummary, Queue, Summary, compute, compute_tiles, regime};
pub use grid::{Axis, AxisRole, Grid, GridError, Tile, is_linear, is_logarithmic};
pub use method::Method;
pub use plan::{Engine, Field, Plan};
pub use proved::{Proved, prove};
pub use quantity::{AttractingCycle, Description, Quantity, attracting_cycle, basin_boundary};
pub use runs::Runs;
pub use simulation::{Paths, decide};
pub use sink::{MethodCells, Sink, TileData};
pub use verdict::{Regime, Verdict};

//! Maps: axes, grid, tiles, the parallel engine, and the interface of a sink of tiles.

mod account;
mod audit;
mod behaviour;
mod contradictions;
mod curves;
pub mod dimension;
mod engine;
pub mod failures;
mod field;
mod grid;
mod interpolation;
pub mod limits;
mod method;
mod plan;
mod proved;
mod quantity;
mod run;
mod runs;
mod simulation;
mod sink;
mod tile_data;
mod tiles;
mod verdict;

pub use account::{Account, FailedCell, MethodAccount, Stages};
pub use audit::{Audit, Disagreement};
pub use behaviour::{
    AttractingCycle, LongRun, attracting_cycle, basin_boundary, long_run, regime, slip_cycle_count,
};
pub use contradictions::{Contradiction, Contradictions};
pub use curves::{CURVE_COLUMNS, Plane, PlaneCurve, PlaneCurves, PlanePoint, curves_of};
pub use engine::{ComputeError, Control, MethodSummary, Summary};
#[doc(hidden)] // the program shares tiles out to the processes of a run
pub use engine::{Queue, compute_tiles};
pub use field::{Field, Quantity};
pub use grid::{Axis, AxisRole, Grid, GridError, Tile, is_linear, is_logarithmic, unravel};
pub use method::Method;
pub use plan::{
    DEFAULT_AUDIT_CELLS, DEFAULT_COMPRESSION, DEFAULT_PROOF_BOXES, DEFAULT_TOLERANCE, Engine,
    MOST_AUDIT_CELLS, Plan, PlanBuilder, PlanError, TOLERANCES,
};
pub use proved::{Proved, prove};
pub use quantity::Description;
pub use run::{Earlier, run, run_with};
pub use runs::Runs;
pub use simulation::{Paths, decide};
pub use sink::Sink;
pub(crate) use tile_data::LISTED;
pub use tile_data::{MethodCells, TileData};
pub use verdict::{Attractors, Outside, Regime, Verdict};

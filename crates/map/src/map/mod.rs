//! Maps: axes, grid, tiles, the parallel engine, and the interface of a sink of tiles.

mod account;
mod audit;
mod behaviour;
mod contradictions;
mod curves;
pub mod dimension;
mod end;
mod engine;
mod field;
mod grid;
mod interpolation;
pub mod limits;
mod method;
mod plan;
mod pool;
mod proved;
mod quantity;
mod run;
mod runs;
mod shard;
mod simulation;
mod sink;
mod tile_data;
mod tiles;
mod verdict;

pub use account::{Account, FailedCell, MethodAccount, Stages, Unknown};
pub use audit::{Audit, Disagreement};
pub(crate) use audit::{Opinion, Witness};
pub use behaviour::{BasinBoundary, Behaviour, LongRun, long_run};
pub use behaviour::{left_out, regime, slip_cycle_count};
pub use contradictions::{Contradiction, Contradictions};
pub use curves::{CURVE_COLUMNS, Plane, PlaneCurve, PlaneCurves, PlanePoint};
pub use engine::{ComputeError, Control, Queue, Summary, compute_tiles};
pub use field::{Field, Quantity};
pub use grid::unravel;
pub use grid::{Axis, AxisRole, Grid, GridError, Shown, Tile};
pub use method::Method;
pub use plan::{
    DEFAULT_AUDIT_CELLS, DEFAULT_COMPRESSION, DEFAULT_PROOF_BOXES, DEFAULT_TOLERANCE, MOST_AUDIT_CELLS,
    TOLERANCES,
};
pub use plan::{Engine, Plan, PlanBuilder, PlanError};
pub use pool::pool;
pub use proved::{Proofs, boxes_to_try, prove};
pub use quantity::Description;
pub use run::run;
pub use run::{Earlier, run_with};
pub use runs::Runs;
pub use shard::Shard;
pub use simulation::{Paths, decide};
pub use sink::{Each, Sink};
pub use tile_data::LISTED;
pub use tile_data::{MethodCells, TileData};
pub use verdict::{Attractors, Regime, Verdict};

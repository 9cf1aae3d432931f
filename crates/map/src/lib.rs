//! Maps: axes, grid, tiles, the parallel engine with its audit, the interface of a sink of tiles, and the contents of a
//! map, independent of the file format.

mod account;
mod audit;
mod chances;
pub mod clock;
mod contradictions;
mod curves;
pub mod dataset;
pub mod dimension;
mod engine;
mod field;
mod grid;
mod interpolation;
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

pub use account::{Account, FailedCell, MethodAccount, Stages, Unknown};
pub use audit::{Audit, Disagreement};
pub use chances::{Chances, Probabilities};
pub use contradictions::{Contradiction, Contradictions};
pub use curves::{CURVE_COLUMNS, Plane, PlaneCurve, PlaneCurves, PlanePoint};
pub use engine::{ComputeError, Control, Queue, Summary, compute_tiles};
pub use field::{Field, Quantity};
pub use grid::unravel;
pub use grid::{Axis, AxisRole, Grid, GridError, Shown, Tile};
pub use plan::{DEFAULT_AUDIT_CELLS, DEFAULT_COMPRESSION, DEFAULT_PROOF_BOXES, MOST_AUDIT_CELLS};
pub use plan::{Plan, PlanBuilder, PlanError};
pub use pool::pool;
pub use proved::{ProvedColumn, columns};
pub use quantity::Description;
pub use run::run;
pub use run::{Earlier, run_with};
pub use runs::Runs;
pub use shard::Shard;
pub use simulation::{Paths, decide};
pub use sink::{Each, Sink};
pub use tile_data::LISTED;
pub use tile_data::{MethodCells, TileData};

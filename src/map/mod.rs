//! Maps: axes, grid, tiles, the parallel engine, and what a sink of cells is.

mod grid;
mod method;
mod plan;
mod sink;
mod verdict;

pub use grid::{Axis, AxisRole, Grid, GridError, Tile};
pub use method::Method;
pub use plan::{Engine, Field, Plan};
pub use sink::{MethodCells, Sink, TileData};
pub use verdict::{Regime, Verdict};

//! The map file: HDF5 that is also valid NetCDF-4. The only place that knows HDF5.

mod check;
mod error;
mod pack;
mod provenance;
mod reader;
mod schema;
mod seal;
mod sys;
mod value;
mod writer;

pub use check::{CheckReport, Problem, check};
pub use error::StoreError;
pub use pack::PackedTile;
pub use provenance::{Audit, Outcome, Provenance};
pub use reader::MapFile;
pub use schema::MethodInfo;
pub use value::Value;
pub use writer::{Existing, MapWriter};

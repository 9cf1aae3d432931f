//! The contents of a map, independent of the file format: dimensions, variables with their attributes,
//! attributes of the file, fingerprints. The HDF5 file is written and read from this description.

pub mod attributes;
pub mod auxiliary;
pub mod curves;
pub mod fingerprint;
mod schema;
mod series;
mod value;

pub use attributes::{Outcome, Provenance};
pub use auxiliary::Auxiliary;
pub use fingerprint::Fingerprint;
pub use schema::{Cells, Schema, Variable};
pub use schema::{Content, SCHEMA};
pub use series::{Contents, Series};
pub use value::{Value, si_name};

/// Lower-case hexadecimal digits.
pub fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

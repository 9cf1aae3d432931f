//! The contents of a map, independent of the file format: dimensions, variables with their attributes,
//! attributes of the file, fingerprints. The HDF5 file is written and read from this description.

pub mod attributes;
pub mod auxiliary;
pub(crate) mod fingerprint;
mod schema;
mod value;

pub use attributes::{Outcome, Provenance};
pub(crate) use auxiliary::Auxiliary;
pub(crate) use fingerprint::Fingerprint;
pub use schema::{Cells, MethodInfo, Schema, Variable};
pub(crate) use schema::{Content, SCHEMA};
pub use value::Value;

/// Lower-case hexadecimal digits.
pub(crate) fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

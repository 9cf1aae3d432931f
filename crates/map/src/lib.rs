//! Maps: grid, tiles, the parallel engine and the audit; machines in SI units, their behaviour and their risk;
//! all answers about one point; the contents of a map, independent of the file format.

pub mod assessment;
pub mod behaviour;
pub mod clock;
pub mod dataset;
mod intervals;
pub mod machine;
pub mod map;
pub mod probe;
pub mod risk;

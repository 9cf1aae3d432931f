//! The map file: HDF5 that is also valid NetCDF-4. This is the only module that uses HDF5.
//!
//! # The format
//!
//! Each axis of the grid is a one-dimensional `f64` dataset of its name and an HDF5 dimension scale, in the
//! order eps, the law's parameters, V, c (slowest first). Over these lie the variables of the fields that `docs/configuration.md`
//! lists, verdicts and regimes as codes (`i8`), all others as real numbers (`f64`); critical dampings without the axis c.
//!
//! All have `long_name` and `units`; variables of a method have its `guarantee` and `equation`; codes have
//! `flag_values`, `flag_meanings` and `flag_counts` (number of cells with each code). No variable has a
//! `_FillValue`, which would make readers convert codes to floating-point numbers. Chunks have the shape of
//! the engine's tiles (attribute `tile_shape`); codes are compressed by deflate, real numbers by shuffle and
//! deflate. The file's own attributes record its provenance ([`Provenance`]) and the course of the run
//! ([`Outcome`]); `complete` = 1 is written last. Texts have fixed lengths, since not every NetCDF tool reads
//! variable-length ones.
//!
//! # Machines
//!
//! The map of a machine has all numbers in SI units, by the attribute `units`. Its axes are the quantities that
//! vary, under their names in configurations and in their order there, then `belt_speed` and `damping`, which are
//! axes in any case. An axis that the configuration has in another unit, such as rpm, is shown in it in figures and
//! tables: `shown_units`, and the size of that unit, `shown_units_in_si`. The other quantities are scalars; the CF attribute `coordinates` of every variable lists them,
//! and xarray makes coordinates of them. Critical dampings are `critical_damping_METHOD`, with the errors
//! `critical_damping_error_simulation`. `stick_slip_probability` and `vibration_by_itself_probability`,
//! over all axes, are there if quantities are uncertain.
//! The file has the attribute `machine_motion`, translation or rotation; its `law_definition` is in SI units.
//! For a table the last line of `law_definition` tells what else is known of it: the lines of its rows in its file, the number
//! of readings, `no_rest` where no row was at rest and friction there is on the line through the first two.
//!
//! # Curves
//!
//! If the configuration has `[curves]`, the group `curves` holds the curves of codimension one in planes of
//! the grid, as two tables with the dimensions `plane` and `point`;
//! `xarray.open_dataset(file, group="curves")` reads them.
//!
//! | variable | along | type | contents |
//! | --- | --- | --- | --- |
//! | `plane_x`, `plane_y` | `plane` | `i8` | the two axes of the plane, by `flag_meanings` |
//! | `held_AXIS` | `plane` | `f64` | the node at which the axis is fixed; NaN for the two axes of the plane |
//! | `plane_number` | `point` | `i32` | the plane, from 1 |
//! | `curve` | `point` | `i8` | kind of curve, by `flag_meanings`: hopf, grazing_sliding, landing, crossing, fold; of points of codimension two, each a branch of its own: bautin, hopf_at_grazing, fold_at_grazing, cusp |
//! | `branch` | `point` | `i32` | number of the connected curve among those of its plane and kind, from 1 |
//! | `AXIS` | `point` | `f64` | the point's parameters, all of them |
//! | `error` | `point` | `f64` | estimate of its distance from the curve, in sides of the plane |
//!
//! Points are in order along their curves; a closed curve ends with its first point. The sides of a plane run
//! from the first to the last node, logarithmically if the nodes are logarithmic. If no plane has a curve,
//! there is no dimension `point`. If the budget of a search was spent, the attribute `incomplete` of the group names the
//! curves. For the `sha256` of these variables, each of them counts as one tile.
//!
//! # Protection against damage
//!
//! - [`MapFile::open`] verifies a map before any of it is used (of a map of more than 256 MiB all but its cells, and
//!   those when they are read, by the checksums of their tiles): by its seal or, where another program has
//!   removed the seal, by the fingerprints of its numbers; attributes are then taken as they are. These detect accidents, not forgery: a person who changes a map
//!   on purpose can seal it again.
//!
//! - A map has a temporary name, `NAME.part-map.LETTERS`, until it is complete, sealed and on disk. A killed run
//!   may leave that file and `NAME.part.LETTERS`, the journal of its finished tiles ([`Journals`]), but nothing
//!   under the map's own name.
//! - `sha256` of a variable: SHA-256 of the concatenated SHA-256s of its tiles, row-major, each over the
//!   tile's cells (not the padding of its chunk), little-endian, with one bit pattern for NaN. It depends
//!   neither on the number of threads nor on the compression, and survives copying by other tools.
//! - The seal: a line of text after the end of the HDF5 file with the SHA-256 of every byte before it. HDF5
//!   readers ignore it. It detects a change of any byte; a program that opens the map for writing removes it.

mod check;
mod codec;
mod create;
mod curves;
mod error;
pub mod identity;
mod journal;
mod journals;
mod layout;
mod open;
mod pack;
mod partial;
mod reader;
mod records;
mod seal;
mod sys;
mod value;
mod writer;

pub use check::{CheckReport, Problem, check};
pub use error::StoreError;
pub use journal::{is_journal, journals};
pub use journals::{Journals, any_tile, remove_parts, remove_unfinished};
pub use pack::LengthSink;
pub use pack::PackedTile;
pub use partial::PartialMap;
pub use reader::SIGNATURE;
pub use reader::{MapFile, Pick};
pub use slipmap_map::dataset::attributes::fingerprint;
pub use slipmap_map::dataset::{Outcome, Provenance, Value};

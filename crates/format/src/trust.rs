//! Validates an untrusted map before it is read.
//!
//! A few bytes of an HDF5 file can declare more cells than memory can hold, numbers of another type, or
//! numbers that are stored in other files of the reader's machine. These functions refuse, with the reason,
//! content that no finished map has. Reading the rest takes memory and time in proportion to its length.

use std::path::Path;

use hdf5::plist::dataset_create::Layout;
use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use hdf5::{Dataset, Group, IndexType, IterationOrder, LinkType};

use slipmap_map::dataset::{Schema, Variable};

/// Largest compression ratio of deflate: 258 bytes in two bits. A cell takes at least one byte before
/// compression.
const DEFLATE_RATIO: u64 = 1032;

/// Largest number of cells of a chunk or a tile. Maps made by slipmap have at most 2^20.
const MOST_CHUNK_CELLS: usize = 1 << 24;

/// Number of nodes of an axis up to which it is not compared with the file's length.
const UNCHECKED_NODES: usize = 1 << 20;

/// Largest length of a name in bytes.
const LONGEST_NAME: usize = 64;

/// Refuses a pipe, which could block a reader, and a device, which may never end.
///
/// # Errors
/// The inner error is the reason for the refusal, the outer one the file system's.
pub(super) fn plain_file(path: &Path) -> std::io::Result<Result<(), String>> {
    let metadata = path.metadata()?;
    Ok(match metadata.file_type() {
        // For a folder the later open gives the better message.
        kind if kind.is_file() || kind.is_dir() => Ok(()),
        _ => Err("it is a pipe or a device, not a file on a disk".into()),
    })
}

/// Reason why a part of a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unfit {
    /// The library returned an error.
    #[error("unreadable: {0}")]
    Unreadable(#[from] hdf5::Error),
    /// No map that slipmap writes contains such a part; with the reason.
    #[error("{0}")]
    Foreign(String),
}

/// Returns [`Unfit::Foreign`] with the reason `why` unless `legal`.
fn require(legal: bool, why: impl FnOnce() -> String) -> Result<(), Unfit> {
    if legal { Ok(()) } else { Err(Unfit::Foreign(why())) }
}

/// Refuses links to other objects or files.
pub(super) fn own_members(group: &Group) -> Result<(), Unfit> {
    let leads_away = group.find_link(IndexType::Name, IterationOrder::Native, |name, link| {
        Ok((link.link_type != LinkType::Hard).then(|| name.to_owned()))
    })?;
    match leads_away {
        None => Ok(()),
        Some(name) => {
            Err(Unfit::Foreign(format!("`{name}` is a link to something else; a map holds its own numbers")))
        }
    }
}

/// Refuses method names that no map uses, since names become parts of file names and of labels.
pub(super) fn name(name: &str) -> Result<(), String> {
    let plain = |byte: u8| byte.is_ascii_alphanumeric() || byte == b'_';
    if name.is_empty() || name.len() > LONGEST_NAME || !name.bytes().all(plain) {
        return Err(format!("{name:?} is not the name of a method"));
    }
    Ok(())
}

/// Refuses an axis that is not a list of numbers stored in this file.
pub(super) fn axis(dataset: &Dataset, name: &str, length: u64) -> Result<(), Unfit> {
    own_numbers(dataset, name)?;
    require(dataset.ndim() == 1, || {
        format!("its axis {name} has {} dimensions instead of one", dataset.ndim())
    })?;
    let nodes = dataset.shape()[0];
    let holds = usize::try_from(length / 8).unwrap_or(usize::MAX);
    require(nodes <= UNCHECKED_NODES.max(holds), || {
        format!("its axis {name} declares {nodes} nodes, more than {length} bytes can hold")
    })?;
    holds_reals(dataset, || format!("its axis {name}"))
}

/// Refuses a grid that a file of this length cannot fill.
pub(super) fn grid(schema: &Schema, length: u64) -> Result<(), String> {
    let cells = schema.grid.cells();
    let tile: usize = schema.tile_shape.iter().fold(1, |n, &len| n.saturating_mul(len));
    if tile > MOST_CHUNK_CELLS {
        return Err(format!("its tiles have {tile} cells, which no version of slipmap writes"));
    }
    if cells as u64 > length.saturating_mul(DEFLATE_RATIO) || schema.tiles() as u64 > length {
        return Err(format!("it declares {cells} cells, more than {length} bytes can hold"));
    }
    Ok(())
}

/// Refuses a variable whose shape or type does not follow from the file's attributes.
pub(super) fn variable(dataset: &Dataset, schema: &Schema, variable: &Variable) -> Result<(), Unfit> {
    let name = &variable.name;
    own_numbers(dataset, name)?;
    has_shape(dataset, name, &schema.shape(variable))?;
    let (stored, expected) = (kind(dataset)?, kind_of(variable));
    require(stored == expected, || format!("{name} holds {stored} instead of {expected}"))
}

/// Refuses an auxiliary variable that is not an array of this shape of real numbers.
pub(super) fn auxiliary(dataset: &Dataset, name: &str, shape: &[usize]) -> Result<(), Unfit> {
    own_numbers(dataset, name)?;
    has_shape(dataset, name, shape)?;
    holds_reals(dataset, || name.to_owned())
}

fn holds_reals(dataset: &Dataset, what: impl Fn() -> String) -> Result<(), Unfit> {
    let is_real = kind(dataset)? == TypeDescriptor::Float(FloatSize::U8);
    require(is_real, || format!("{} does not hold 64-bit floating-point numbers", what()))
}

fn has_shape(dataset: &Dataset, name: &str, shape: &[usize]) -> Result<(), Unfit> {
    let stored = dataset.shape();
    require(stored == shape, || format!("{name} has the shape {stored:?} instead of {shape:?}"))
}

/// Number type of a variable of the schema.
pub(super) fn kind_of(variable: &Variable) -> TypeDescriptor {
    match variable.codes() {
        Some(_) => TypeDescriptor::Integer(IntSize::U1),
        None => TypeDescriptor::Float(FloatSize::U8),
    }
}

/// Number type of a stored dataset; an error for a type that the `hdf5` crate does not support.
fn kind(dataset: &Dataset) -> hdf5::Result<TypeDescriptor> {
    dataset.dtype()?.to_descriptor()
}

/// Refuses numbers that are stored in other files, and chunks that would fill the memory.
pub(super) fn own_numbers(dataset: &Dataset, name: &str) -> Result<(), Unfit> {
    let plist = dataset.dcpl()?;
    let here = matches!(plist.get_layout()?, Layout::Compact | Layout::Contiguous | Layout::Chunked);
    require(here && plist.get_external()?.is_empty(), || {
        format!("the numbers of {name} lie in other files; a map holds its own")
    })?;
    let chunk = dataset.chunk().unwrap_or_default();
    let cells = chunk.iter().fold(1usize, |n, &len| n.saturating_mul(len));
    require(cells <= MOST_CHUNK_CELLS, || {
        format!("{name} has chunks of shape {chunk:?}, which no version of slipmap writes")
    })
}

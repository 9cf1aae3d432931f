//! Validates an untrusted map before it is read.
//!
//! A few bytes of an HDF5 file can declare more cells than memory can hold, numbers of another type, or
//! numbers that are stored in other files of the reader's machine. These functions refuse, with the reason,
//! content that no finished map has. Reading the rest takes memory and time in proportion to its length.

use std::collections::HashSet;
use std::ops::Range;
use std::path::Path;

use hdf5::filters::Filter;
use hdf5::plist::dataset_create::Layout;
use hdf5::types::{FloatSize, IntSize, TypeDescriptor};
use hdf5::{Dataset, Group, IndexType, IterationOrder, LinkType, ObjectReference1};
use libdeflater::{DecompressionError, Decompressor};

use slipmap_map::dataset::{Schema, Variable};
use slipmap_map::map::unravel;

use super::sys;

/// Largest compression ratio of deflate: 258 bytes in two bits. A cell takes at least one byte before
/// compression.
const DEFLATE_RATIO: u64 = 1032;

/// Largest number of cells of a chunk or a tile. Maps made by slipmap have at most 2^20.
const MOST_CHUNK_CELLS: usize = 1 << 21;

/// Largest number of bytes that the HDF5 library may inflate from one chunk without having been told.
const MOST_INFLATED: u64 = 1 << 26;

/// Number of nodes of an axis up to which it is not compared with the file's length.
const UNCHECKED_NODES: usize = 1 << 20;

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

/// Refuses variables that are one object under several names, each of which would be read.
pub(super) fn distinct(group: &Group, schema: &Schema) -> Result<(), Unfit> {
    let mut seen = HashSet::new();
    for Variable { name, .. } in schema.variables.iter().filter(|variable| group.link_exists(&variable.name))
    {
        let address = sys::address(group.reference::<ObjectReference1>(name)?);
        require(seen.insert(address), || format!("{name} is another variable too"))?;
    }
    Ok(())
}

/// Refuses an axis that is not a list of numbers stored in this file.
pub(super) fn axis(dataset: &Dataset, name: &str, file: FileFacts) -> Result<(), Unfit> {
    let length = file.length;
    own_numbers(dataset, name, file)?;
    require(dataset.ndim() == 1, || {
        format!("its axis {name} has {} dimensions instead of one", dataset.ndim())
    })?;
    let nodes = dataset.shape()[0];
    let holds = usize::try_from(length / 8).unwrap_or(usize::MAX);
    require(nodes <= UNCHECKED_NODES.max(holds), || {
        format!("its axis {name} declares {nodes} nodes, more than {length} bytes can hold")
    })?;
    holds_reals(dataset, || format!("its axis {name}"))?;
    require(stores(dataset)?, || format!("its axis {name} declares {nodes} nodes, more than it stores"))
}

/// Whether a dataset stores as many bytes as its numbers need at least.
pub(super) fn stores(dataset: &Dataset) -> hdf5::Result<bool> {
    let ratio = if dataset.dcpl()?.get_filters()?.is_empty() { 1 } else { DEFLATE_RATIO };
    Ok(bytes(dataset)? <= dataset.storage_size().saturating_mul(ratio))
}

/// The size of a dataset's numbers in bytes, before compression.
pub(super) fn bytes(dataset: &Dataset) -> hdf5::Result<u64> {
    Ok((dataset.size() as u64).saturating_mul(dataset.dtype()?.size() as u64))
}

/// Refuses a grid that a file of this length cannot fill.
pub(super) fn grid(schema: &Schema, length: u64) -> Result<(), String> {
    let cells = schema.grid.cells();
    // One byte for each code, eight for each real number.
    let size = |of: &Variable| if of.codes().is_some() { 1 } else { 8 };
    let cells_of =
        |of: &Variable| schema.shape(of).iter().fold(size(of), |n: u64, &len| n.saturating_mul(len as u64));
    let bytes = schema.variables.iter().map(cells_of).fold(0, u64::saturating_add);
    let tile: usize = schema.tile_shape.iter().fold(1, |n, &len| n.saturating_mul(len));
    if tile > MOST_CHUNK_CELLS {
        return Err(format!("its tiles have {tile} cells, which no version of slipmap writes"));
    }
    if bytes > length.saturating_mul(DEFLATE_RATIO) || schema.tiles() as u64 > length {
        return Err(format!("it declares {cells} cells, more than {length} bytes can hold"));
    }
    Ok(())
}

/// Refuses a variable whose shape or type does not follow from the file's attributes.
pub(super) fn variable(
    dataset: &Dataset,
    schema: &Schema,
    variable: &Variable,
    file: FileFacts,
) -> Result<(), Unfit> {
    let name = &variable.name;
    own_numbers(dataset, name, file)?;
    has_shape(dataset, name, &schema.shape(variable))?;
    let (stored, expected) = (kind(dataset)?, kind_of(variable));
    require(stored == expected, || format!("{name} holds {stored} instead of {expected}"))
}

/// Refuses an auxiliary variable that is not an array of this shape of real numbers.
pub(super) fn auxiliary(
    dataset: &Dataset,
    name: &str,
    shape: &[usize],
    file: FileFacts,
) -> Result<(), Unfit> {
    own_numbers(dataset, name, file)?;
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

/// Number type of a stored dataset; an error for a type that no map uses.
pub(super) fn kind(dataset: &Dataset) -> hdf5::Result<TypeDescriptor> {
    sys::descriptor(&dataset.dtype()?)
}

/// What is known of a file before its numbers are read.
#[derive(Clone, Copy)]
pub(super) struct FileFacts {
    /// Its length in bytes.
    pub(super) length: u64,
    /// Whether the chunks of variables over the grid are looked at when they are read, not all at once.
    pub(super) by_parts: bool,
}

/// Refuses numbers that are stored in other files, that other filters than those of this program have packed,
/// and chunks that would fill the memory.
pub(super) fn own_numbers(dataset: &Dataset, name: &str, file: FileFacts) -> Result<(), Unfit> {
    let plist = dataset.dcpl()?;
    let here = matches!(plist.get_layout()?, Layout::Compact | Layout::Contiguous | Layout::Chunked);
    require(here && plist.get_external()?.is_empty(), || {
        format!("the numbers of {name} lie in other files; a map holds its own")
    })?;
    let chunk = dataset.chunk().unwrap_or_default();
    let cells = chunk.iter().fold(1usize, |n, &len| n.saturating_mul(len));
    require(cells <= MOST_CHUNK_CELLS, || {
        format!("{name} has chunks of shape {chunk:?}, which no version of slipmap writes")
    })?;
    let filters = plist.get_filters()?;
    let known = matches!(
        filters.as_slice(),
        [] | [Filter::Shuffle] | [Filter::Deflate(_)] | [Filter::Shuffle, Filter::Deflate(_)]
    );
    require(known, || format!("{name} is packed by {filters:?}, which no version of slipmap uses"))?;
    let deflated = filters.iter().any(|filter| matches!(filter, Filter::Deflate(_)));
    if deflated && !file.by_parts && dataset.storage_size().saturating_mul(DEFLATE_RATIO) > MOST_INFLATED {
        let all: Vec<Range<usize>> = dataset.shape().iter().map(|&len| 0..len).collect();
        inflates_to_its_size(dataset, name, &all, file)?;
    }
    Ok(())
}

/// Refuses chunks in this box of cells that inflate to more than their declared size: the HDF5 library inflates a
/// stream to its end, however long that is. Streams that are too short for much are left to it.
pub(super) fn inflates_to_its_size(
    dataset: &Dataset,
    name: &str,
    ranges: &[Range<usize>],
    file: FileFacts,
) -> Result<(), Unfit> {
    let Some(chunk) = dataset.chunk() else { return Ok(()) };
    // The chunks along each dimension.
    let chunks = |(range, part): (&Range<usize>, &usize)| range.start / part..range.end.div_ceil(*part);
    let chunks: Vec<Range<usize>> = ranges.iter().zip(&chunk).map(chunks).collect();
    let counts: Vec<usize> = chunks.iter().map(ExactSizeIterator::len).collect();
    let all = counts.iter().fold(1usize, |n, &count| n.saturating_mul(count));
    require(all as u64 <= file.length, || {
        format!("{name} declares {all} chunks, more than {} bytes can hold", file.length)
    })?;
    let mut inflated = vec![0; chunk.iter().product::<usize>() * dataset.dtype()?.size()];
    let mut decompressor = Decompressor::new();
    for number in 0..all {
        let at = unravel(number, &counts);
        let start: Vec<u64> = at
            .iter()
            .zip(&chunks)
            .zip(&chunk)
            .map(|((at, chunks), len)| ((chunks.start + at) * len) as u64)
            .collect();
        let size = sys::chunk_size(dataset, &start)?;
        if size.saturating_mul(DEFLATE_RATIO) <= MOST_INFLATED {
            continue;
        }
        require(size <= file.length, || format!("{name} has a chunk of {size} bytes, more than the file"))?;
        let stream = sys::read_chunk(dataset, &start, size as usize)?;
        // Of a stream that is broken before it is too long, the library says so.
        let end = decompressor.zlib_decompress(&stream, &mut inflated);
        require(end != Err(DecompressionError::InsufficientSpace), || {
            format!("{name} has a chunk that inflates to more than its size")
        })?;
    }
    Ok(())
}

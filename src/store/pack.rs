//! From computed cells to the bytes of a chunk.

use std::borrow::Cow;

use libdeflater::{CompressionLvl, Compressor};
use sha2::{Digest, Sha256};

use crate::map::TileData;

use super::schema::{Cells, Schema, Variable};
use super::value::{Value, hex};

/// A SHA-256 fingerprint.
pub(super) type Fingerprint = [u8; 32];

/// One chunk as it is to lie in the file, and what is known of its cells.
#[derive(Debug)]
pub(super) struct PackedChunk {
    /// Position of the variable in the schema.
    pub(super) variable: usize,
    /// Number of the chunk, row-major over the variable's chunks.
    pub(super) number: usize,
    /// Index of its first cell.
    pub(super) offset: Vec<usize>,
    /// The filtered bytes.
    pub(super) bytes: Vec<u8>,
    /// Fingerprint of its cells.
    pub(super) fingerprint: Fingerprint,
    /// Number of cells with each of the variable's codes.
    pub(super) counts: Vec<u64>,
}

/// A tile ready to be written.
#[derive(Debug)]
pub struct PackedTile {
    /// Its number.
    pub(super) number: usize,
    /// Its chunks.
    pub(super) chunks: Vec<PackedChunk>,
}

/// Makes the chunks of one tile.
///
/// # Panics
/// If the tile brings another number of cells than the plan asks for: a bug of the engine.
pub(super) fn pack(schema: &Schema, level: u8, data: &TileData) -> PackedTile {
    let mut deflate = (level > 0).then(|| Deflate::new(level));
    let mut chunks = Vec::with_capacity(schema.variables.len());
    for (position, variable) in schema.variables.iter().enumerate() {
        let Some(number) = schema.chunk_number(variable, data.tile.number) else { continue };
        let chunk_shape = schema.chunk(variable);
        let ranges = &data.tile.ranges[..chunk_shape.len()];
        let shape: Vec<usize> = ranges.iter().map(ExactSizeIterator::len).collect();
        let cells = variable.cells(data);
        let (fingerprint, counts, plain) = match cells {
            Cells::Codes(codes) => {
                let full = pad(codes, &shape, &chunk_shape, variable.fill_code());
                let plain = match full {
                    Cow::Borrowed(codes) => Cow::Borrowed(bytemuck::cast_slice(codes)),
                    Cow::Owned(codes) => Cow::Owned(bytemuck::allocation::cast_vec(codes)),
                };
                (fingerprint_codes(codes), count(variable, codes), plain)
            }
            Cells::Reals(reals) => {
                let full = pad(reals, &shape, &chunk_shape, f64::NAN);
                let plain =
                    if level > 0 { shuffle(&full) } else { full.iter().flat_map(|&v| stored(v)).collect() };
                (fingerprint_reals(reals), Vec::new(), Cow::Owned(plain))
            }
        };
        let bytes = match &mut deflate {
            Some(deflate) => deflate.stream(&plain),
            None => plain.into_owned(),
        };
        let offset = schema.offset(variable, data.tile.number);
        chunks.push(PackedChunk { variable: position, number, offset, bytes, fingerprint, counts });
    }
    PackedTile { number: data.tile.number, chunks }
}

/// Fingerprint of codes, one byte each.
pub(super) fn fingerprint_codes(codes: &[i8]) -> Fingerprint {
    Sha256::digest(bytemuck::cast_slice::<i8, u8>(codes)).into()
}

/// Fingerprint of real numbers as little-endian IEEE doubles; every NaN counts as the same one.
pub(super) fn fingerprint_reals(reals: &[f64]) -> Fingerprint {
    let mut hash = Sha256::new();
    let mut buffer = Vec::with_capacity(8 * 4096);
    for part in reals.chunks(4096) {
        buffer.clear();
        part.iter().for_each(|&v| buffer.extend_from_slice(&canonical(v).to_le_bytes()));
        hash.update(&buffer);
    }
    hash.finalize().into()
}

/// Fingerprint of whole numbers as little-endian 32-bit ones.
pub(super) fn fingerprint_integers(integers: &[i32]) -> Fingerprint {
    Sha256::digest(integers.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()).into()
}

/// The attribute `sha256` of a variable that is stored in one piece.
pub(super) fn one_tile(fingerprint: &Fingerprint) -> Value {
    hex(&combine([fingerprint])).into()
}

/// Fingerprint of a variable: that of its chunks' fingerprints, in their order.
pub(super) fn combine<'a>(fingerprints: impl IntoIterator<Item = &'a Fingerprint>) -> Fingerprint {
    let mut hash = Sha256::new();
    fingerprints.into_iter().for_each(|fingerprint| hash.update(fingerprint));
    hash.finalize().into()
}

/// Number of cells with each code of `variable`, in the order of its `flag_values`.
pub(super) fn count(variable: &Variable, codes: &[i8]) -> Vec<u64> {
    // Sums of 255 comparisons fit a byte, so that whole vector registers of cells are compared at once:
    // a dozen times faster than counting into 64-bit numbers one by one.
    let count = |code: i8| -> u64 {
        codes
            .chunks(255)
            .map(|part| u64::from(part.iter().map(|&cell| u8::from(cell == code)).sum::<u8>()))
            .sum()
    };
    variable.codes().unwrap_or_default().into_iter().map(|(code, _)| count(code)).collect()
}

/// The one NaN that is stored, so that maps do not depend on which instruction made it.
fn canonical(value: f64) -> f64 {
    if value.is_nan() { f64::NAN } else { value }
}

/// A number's bytes in the file, whose datatype is that of the machine.
fn stored(value: f64) -> [u8; 8] {
    canonical(value).to_ne_bytes()
}

/// What HDF5's shuffle filter makes: first every number's first byte, then every second byte, and so on.
fn shuffle(values: &[f64]) -> Vec<u8> {
    let mut out = vec![0u8; 8 * values.len()];
    if values.is_empty() {
        return out;
    }
    for (place, plane) in out.chunks_exact_mut(values.len()).enumerate() {
        for (byte, &value) in plane.iter_mut().zip(values) {
            *byte = stored(value)[place];
        }
    }
    out
}

/// Makes the zlib streams of HDF5's deflate filter.
struct Deflate {
    compressor: Compressor,
    scratch: Vec<u8>,
}

impl Deflate {
    fn new(level: u8) -> Self {
        // Both scales go from 1, fast, to 9, small; libdeflate's continues to 12.
        let level = CompressionLvl::new(level.into()).unwrap_or_default();
        Self { compressor: Compressor::new(level), scratch: Vec::new() }
    }

    fn stream(&mut self, plain: &[u8]) -> Vec<u8> {
        let bound = self.compressor.zlib_compress_bound(plain.len());
        if self.scratch.len() < bound {
            self.scratch.resize(bound, 0);
        }
        // The bound holds by the library's contract, so that this fails for no input.
        match self.compressor.zlib_compress(plain, &mut self.scratch) {
            Ok(length) => self.scratch[..length].to_vec(),
            Err(error) => panic!("libdeflate broke its own bound of {bound} bytes: {error}"),
        }
    }
}

/// The cells of a tile of the given shape as a whole chunk; borrowed where the tile is one.
fn pad<'a, T: Copy>(cells: &'a [T], shape: &[usize], chunk: &[usize], fill: T) -> Cow<'a, [T]> {
    assert_eq!(cells.len(), shape.iter().product::<usize>(), "cells of a tile of shape {shape:?}");
    if shape == chunk {
        return Cow::Borrowed(cells);
    }
    let mut full = vec![fill; chunk.iter().product()];
    let row = shape.last().copied().unwrap_or(1);
    for (number, from) in cells.chunks_exact(row).enumerate() {
        // The row's place: its index in the tile, read off from the second fastest axis up.
        let (mut rest, mut start, mut stride) = (number, 0, chunk.last().copied().unwrap_or(1));
        for (&len, &whole) in shape.iter().zip(chunk).rev().skip(1) {
            start += (rest % len) * stride;
            rest /= len;
            stride *= whole;
        }
        full[start..start + row].copy_from_slice(from);
    }
    Cow::Owned(full)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn padding_keeps_every_cell_at_its_index() {
        let (shape, chunk) = ([2, 1, 3], [2, 2, 4]);
        let cells: Vec<i8> = (1..=6).collect();
        let full = pad(&cells, &shape, &chunk, 0);
        assert_eq!(full.as_ref(), [1, 2, 3, 0, 0, 0, 0, 0, 4, 5, 6, 0, 0, 0, 0, 0]);
        assert!(matches!(pad(&cells, &shape, &shape, 0), Cow::Borrowed(_)));
    }

    #[test]
    fn every_nan_is_the_same() {
        let odd = f64::from_bits(0xfff8_0000_0000_0001);
        assert_eq!(fingerprint_reals(&[odd, 1.0]), fingerprint_reals(&[f64::NAN, 1.0]));
        assert_eq!(shuffle(&[odd]), shuffle(&[f64::NAN]));
        assert_ne!(fingerprint_reals(&[0.0]), fingerprint_reals(&[-0.0]));
    }
}

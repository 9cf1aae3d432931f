//! Packs computed cells into the bytes of HDF5 chunks.

use std::borrow::Cow;
use std::collections::HashMap;
use std::convert::Infallible;
use std::io::Write as _;
use std::sync::{Arc, Mutex, PoisonError};

use flate2::Compression;
use flate2::write::ZlibEncoder;
use serde::{Deserialize, Serialize};

use slipmap_map::dataset::fingerprint::{self, canonical};
use slipmap_map::dataset::{Cells, Fingerprint, Schema, Variable};
use slipmap_map::{Account, Plan, Runs, Sink, TileData};

use super::codec::to_bytes;

/// A chunk as stored in the file, with the fingerprint and the counts of its cells.
#[derive(Debug, Serialize, Deserialize)]
pub(super) struct PackedChunk {
    pub(super) fingerprint: Fingerprint,
    /// Number of cells with each of the variable's codes.
    pub(super) counts: Vec<u64>,
    #[serde(with = "serde_bytes")]
    pub(super) bytes: Vec<u8>,
}

/// A tile ready to be written: one chunk of each variable of `Schema::filled_by`.
#[derive(Debug, Serialize, Deserialize)]
pub struct PackedTile {
    pub(super) number: usize,
    pub(super) chunks: Vec<PackedChunk>,
}

/// Packs tiles of an unfinished map.
#[derive(Debug)]
pub(super) struct Packer {
    pub(super) plan: Plan,
    schema: Schema,
    /// Cache of chunks with few runs.
    known: Mutex<HashMap<ChunkKey, Arc<KnownChunk>>>,
}

/// The data on which the bytes of a chunk of codes depend: its codes, its shape without the padding, the code
/// of the padding.
type ChunkKey = (Runs<i8>, Vec<usize>, i8);

/// The bytes of a chunk and the fingerprint of its cells.
type KnownChunk = (Vec<u8>, Fingerprint);

/// Largest number of runs of a cached chunk: constant chunks, and chunks in which one axis alone decides.
/// Other chunks hardly ever occur again.
const RUNS_OF_KNOWN: usize = 64;
/// Largest number of cached chunks: some MB.
const MOST_KNOWN: usize = 4096;

impl Packer {
    /// Packer for the map of `plan`.
    pub(super) fn new(plan: &Plan) -> Self {
        Self { plan: plan.clone(), schema: Schema::of(plan), known: Mutex::default() }
    }

    /// Packs a tile.
    ///
    /// # Panics
    /// If the tile does not have the number of cells that the plan requires, which is a bug of the engine.
    pub(super) fn pack(&self, data: &TileData) -> PackedTile {
        let schema = &self.schema;
        let mut work = Work::new(self.plan.compression);
        let mut chunks: Vec<PackedChunk> = Vec::with_capacity(schema.variables.len());
        // Codes packed so far in this tile, with the code of their padding and their chunk.
        let mut packed: Vec<(Runs<i8>, i8, usize)> = Vec::new();
        for (_, variable) in schema.filled_by(data.tile.number) {
            let chunk = schema.chunk(variable);
            let shape: Vec<usize> =
                data.tile.ranges[..chunk.len()].iter().map(ExactSizeIterator::len).collect();
            let (bytes, fingerprint, counts) = match variable.cells(data) {
                Cells::Codes(codes) => {
                    let counts = count(variable, |wanted| codes.count(|code| code == wanted));
                    let fill = variable.fill_code();
                    // Two methods often give the same verdicts.
                    let equal = packed.iter().find(|(other, padding, _)| *padding == fill && *other == codes);
                    let (bytes, fingerprint) = match equal {
                        Some(&(_, _, chunk)) => (chunks[chunk].bytes.clone(), chunks[chunk].fingerprint),
                        None => self.codes(&codes, &shape, &chunk, fill, &mut work),
                    };
                    packed.push((codes, fill, chunks.len()));
                    (bytes, fingerprint, counts)
                }
                Cells::Reals(reals) => {
                    let full = pad(reals, &shape, &chunk, f64::NAN);
                    let bytes = match &mut work.deflate {
                        Some(deflate) => stream(deflate, &shuffle(&full)),
                        None => full.iter().flat_map(|&value| stored(value)).collect(),
                    };
                    (bytes, fingerprint::reals(reals), Vec::new())
                }
            };
            chunks.push(PackedChunk { fingerprint, counts, bytes });
        }
        PackedTile { number: data.tile.number, chunks }
    }

    /// Bytes and fingerprint of a chunk of codes, from the cache if it contains them.
    fn codes(
        &self,
        codes: &Runs<i8>,
        shape: &[usize],
        chunk: &[usize],
        fill: i8,
        work: &mut Work,
    ) -> (Vec<u8>, Fingerprint) {
        let make = |codes: &Runs<i8>, shape: &[usize], work: &mut Work| {
            let cells = work.plain.cells(codes);
            let fingerprint = fingerprint::codes(cells);
            let full = pad(cells, shape, chunk, fill);
            let plain: &[u8] = bytemuck::cast_slice(&full);
            let bytes =
                work.deflate.as_mut().map_or_else(|| plain.to_vec(), |deflate| stream(deflate, plain));
            (bytes, fingerprint)
        };
        if codes.iter().nth(RUNS_OF_KNOWN).is_some() {
            return make(codes, shape, work);
        }
        let key = (codes.clone(), shape.to_vec(), fill);
        let lock = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        // Computed outside of the lock, perhaps twice, which does no harm: equal codes make equal bytes.
        let known = lock().get(&key).cloned();
        let found = known.unwrap_or_else(|| {
            let made = Arc::new(make(&key.0, &key.1, work));
            let mut known = lock();
            if known.len() < MOST_KNOWN {
                known.insert(key, Arc::clone(&made));
            }
            made
        });
        (found.0.clone(), found.1)
    }
}

/// A sink that forgets the tiles, and passes on the length of each in the journal.
pub struct LengthSink<F> {
    packer: Packer,
    receive: F,
}

impl<F: Fn(usize) + Sync> LengthSink<F> {
    /// The sink of the tiles of `plan` that calls `receive` with the length of each tile in bytes.
    pub fn new(plan: &Plan, receive: F) -> Self {
        Self { packer: Packer::new(plan), receive }
    }
}

impl<F: Fn(usize) + Sync> Sink for LengthSink<F> {
    type Packed = PackedTile;
    type Error = Infallible;

    fn pack(&self, data: &TileData) -> Result<PackedTile, Infallible> {
        Ok(self.packer.pack(data))
    }

    fn write(&self, packed: PackedTile, account: &Account) -> Result<(), Infallible> {
        (self.receive)(to_bytes(&(packed, account)).len());
        Ok(())
    }
}

/// The compressor of chunks.
type Deflate = ZlibEncoder<Vec<u8>>;

/// What a worker reuses for every chunk of a tile.
struct Work {
    /// The compressor, unless compression is off.
    deflate: Option<Deflate>,
    plain: Plain,
}

impl Work {
    fn new(level: u8) -> Self {
        let deflate = (level > 0).then(|| Deflate::new(Vec::new(), Compression::new(level.into())));
        Self { deflate, plain: Plain::default() }
    }
}

/// The buffer of the cells of runs.
#[derive(Default)]
struct Plain(Vec<i8>);

/// Number of cells that are written at once at the start of a run; the next run overwrites the excess.
const STRETCH: usize = 64;

impl Plain {
    fn cells(&mut self, codes: &Runs<i8>) -> &[i8] {
        let length = codes.len();
        if self.0.len() < length + STRETCH {
            self.0.resize(length + STRETCH, 0);
        }
        for (code, cells) in codes.iter() {
            self.0[cells.start..cells.start + STRETCH].copy_from_slice(&[code; STRETCH]);
            if cells.len() > STRETCH {
                self.0[cells.start + STRETCH..cells.end].fill(code);
            }
        }
        &self.0[..length]
    }
}

/// Number of cells with each code of `variable`, in the order of its `flag_values`; `count` counts one code.
pub(super) fn count(variable: &Variable, count: impl Fn(i8) -> u64) -> Vec<u64> {
    variable.codes().unwrap_or_default().into_iter().map(|(code, _)| count(code)).collect()
}

/// A number's bytes in the file, in the machine's own datatype.
fn stored(value: f64) -> [u8; 8] {
    canonical(value).to_ne_bytes()
}

/// HDF5's shuffle filter: first the first byte of every number, then every second byte, and so on.
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

/// The zlib stream of HDF5's deflate filter.
fn stream(deflate: &mut Deflate, plain: &[u8]) -> Vec<u8> {
    match deflate.write_all(plain).and_then(|()| deflate.reset(Vec::new())) {
        Ok(stream) => stream,
        Err(error) => panic!("a vector takes no bytes: {error}"),
    }
}

/// Pads the cells of a tile of the given shape to a whole chunk; borrows them if the tile is a whole chunk.
fn pad<'a, T: Copy>(cells: &'a [T], shape: &[usize], chunk: &[usize], fill: T) -> Cow<'a, [T]> {
    assert_eq!(cells.len(), shape.iter().product::<usize>(), "cells of a tile of shape {shape:?}");
    if shape == chunk {
        return Cow::Borrowed(cells);
    }
    let mut full = vec![fill; chunk.iter().product()];
    let row = shape.last().copied().unwrap_or(1);
    for (number, from) in cells.chunks_exact(row.max(1)).enumerate() {
        let (mut start, mut stride, mut rest) = (0, chunk.last().copied().unwrap_or(1), number);
        for (length, of_chunk) in shape.iter().zip(chunk).rev().skip(1) {
            start += rest % length * stride;
            stride *= of_chunk;
            rest /= length;
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
    fn runs_give_their_cells() {
        let cells: Vec<i8> = (0..1000).map(|cell| [1, 0, -1][(cell / 7 + cell / 300) % 3]).collect();
        let mut plain = Plain::default();
        assert_eq!(plain.cells(&cells.iter().copied().collect()), cells);
        let long: Vec<i8> = [[1; 500], [-1; 500]].concat();
        assert_eq!(plain.cells(&long.iter().copied().collect()), long);
    }

    #[test]
    fn every_nan_is_the_same() {
        let odd = f64::from_bits(0xfff8_0000_0000_0001);
        assert_eq!(fingerprint::reals(&[odd, 1.0]), fingerprint::reals(&[f64::NAN, 1.0]));
        assert_eq!(shuffle(&[odd]), shuffle(&[f64::NAN]));
        assert_ne!(fingerprint::reals(&[0.0]), fingerprint::reals(&[-0.0]));
    }
}

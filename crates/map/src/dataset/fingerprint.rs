//! Fingerprints of cells: the attribute `sha256` of a variable.
//!
//! The fingerprint of a variable is the SHA-256 of its tiles' fingerprints, row-major, each the SHA-256 of
//! the tile's cells, little-endian, with one bit pattern for NaN. It depends neither on the number of threads
//! nor on compression.

use sha2::{Digest, Sha256};

use super::{Value, hex};

/// A SHA-256 fingerprint.
pub type Fingerprint = [u8; 32];

/// Fingerprint of codes, one byte each.
pub fn codes(codes: &[i8]) -> Fingerprint {
    Sha256::digest(bytemuck::cast_slice::<i8, u8>(codes)).into()
}

/// Fingerprint of real numbers as little-endian IEEE doubles; all NaNs count as equal.
pub fn reals(reals: &[f64]) -> Fingerprint {
    let mut hash = Sha256::new();
    let mut buffer = Vec::with_capacity(8 * 4096);
    for part in reals.chunks(4096) {
        buffer.clear();
        part.iter().for_each(|&v| buffer.extend_from_slice(&canonical(v).to_le_bytes()));
        hash.update(&buffer);
    }
    hash.finalize().into()
}

/// Fingerprint of integers, as little-endian 32-bit numbers.
pub fn integers(integers: &[i32]) -> Fingerprint {
    Sha256::digest(integers.iter().flat_map(|v| v.to_le_bytes()).collect::<Vec<u8>>()).into()
}

/// The attribute `sha256` of a variable that is stored in one piece.
pub fn of_one_tile(fingerprint: &Fingerprint) -> Value {
    hex(&combine([fingerprint])).into()
}

/// Fingerprint of a variable from the fingerprints of its chunks, in their order.
pub fn combine<'a>(fingerprints: impl IntoIterator<Item = &'a Fingerprint>) -> Fingerprint {
    let mut hash = Sha256::new();
    fingerprints.into_iter().for_each(|fingerprint| hash.update(fingerprint));
    hash.finalize().into()
}

/// Gives every NaN the same bit pattern, so that maps do not depend on the instruction that made it.
pub fn canonical(value: f64) -> f64 {
    if value.is_nan() { f64::NAN } else { value }
}

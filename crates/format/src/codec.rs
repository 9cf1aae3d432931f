//! The contents of the journal as bytes: attributes, tiles and accounts, by serde in the
//! format of `postcard`. Only bytes that match their SHA-256 are decoded.

use serde::{Deserialize, Serialize};

pub(crate) fn to_bytes(value: &impl Serialize) -> Vec<u8> {
    match postcard::to_stdvec(value) {
        Ok(bytes) => bytes,
        Err(error) => panic!("lists of known length can be written to memory: {error}"),
    }
}

/// Decodes the bytes of a value of this type; `None` for other bytes.
pub(crate) fn from_bytes<'a, T: Deserialize<'a>>(bytes: &'a [u8]) -> Option<T> {
    postcard::take_from_bytes(bytes).ok().filter(|(_, rest)| rest.is_empty()).map(|(value, _)| value)
}

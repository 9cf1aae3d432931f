//! The contents of the journal as bytes: attributes, tiles and accounts, by serde in the
//! format of `postcard`.
//!
//! Decoded data are not trusted: every length is compared with the number of bytes that are left before
//! memory is allocated for it, and every number is compared with the plan.

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

#[cfg(test)]
mod tests {
    use super::super::pack::PackedTile;
    use super::*;
    use slipmap_map::dataset::Value;

    #[test]
    fn absurd_lengths_are_refused_before_room_is_made_for_them() {
        for length in [1, 1 << 20, u64::MAX / 16, u64::MAX] {
            let bytes = to_bytes(&length);
            assert_eq!(from_bytes::<Vec<(String, Value)>>(&bytes), None);
            assert_eq!(from_bytes::<Vec<f64>>(&bytes), None);
            assert!(from_bytes::<PackedTile>(&to_bytes(&(0, length))).is_none());
        }
    }
}

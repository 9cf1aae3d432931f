//! Parts of the tiles of a map, for many processes that know nothing of each other.

use std::fmt;
use std::str::FromStr;

/// The shard `number` of `of`: every tile whose number leaves the remainder `number - 1` when divided by `of`.
/// Neighbouring tiles cost alike, so shards do too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shard {
    number: usize,
    of: usize,
}

impl Shard {
    /// The shard `number` of `of`; `None` unless `1 <= number <= of`.
    #[must_use]
    pub fn new(number: usize, of: usize) -> Option<Self> {
        (1..=of).contains(&number).then_some(Self { number, of })
    }

    /// Number of shards.
    #[must_use]
    pub fn of(self) -> usize {
        self.of
    }

    /// All tiles.
    pub(super) const WHOLE: Self = Self { number: 1, of: 1 };

    /// The tile of the shard at this position, from 0; `None` beyond all numbers.
    pub(super) fn tile(self, position: usize) -> Option<usize> {
        position.checked_mul(self.of)?.checked_add(self.number - 1)
    }

    /// Returns whether the tile belongs to the shard.
    #[must_use]
    pub fn has(self, tile: usize) -> bool {
        tile % self.of == self.number - 1
    }

    /// Number of tiles of the shard, of `all`.
    #[must_use]
    pub fn tiles(self, all: usize) -> usize {
        (all + self.of - self.number) / self.of
    }
}

/// `K/N`, as it is written on a command line.
impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parse = || {
            let (number, of) = text.split_once('/')?;
            Self::new(number.parse().ok()?, of.parse().ok()?)
        };
        parse().ok_or_else(|| "this is not K/N with 1 <= K <= N, as 3/64".into())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_divide_the_tiles() {
        for (tiles, of) in [(0, 1), (10, 1), (10, 3), (10, 10), (3, 7)] {
            let shards: Vec<Shard> = (1..=of).map(|number| Shard::new(number, of).unwrap()).collect();
            for tile in 0..tiles {
                assert_eq!(shards.iter().filter(|shard| shard.has(tile)).count(), 1, "{tile} of {of}");
            }
            for shard in shards {
                assert_eq!(shard.tiles(tiles), (0..tiles).filter(|&tile| shard.has(tile)).count(), "{shard}");
                assert_eq!(shard.to_string().parse(), Ok(shard));
            }
        }
        for wrong in ["", "1", "0/4", "5/4", "-1/4", "1/0", "1/4/2", "a/b"] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}

//! How large the tiles of a grid are.

/// A tile is a task of one worker and a chunk of the map file. At most 64 KiB of verdicts, 512 KiB of a
/// real field, which suits readers of HDF5 ..
const MOST_TILE_CELLS: usize = 1 << 16;
/// .. but for grids beyond 10^10 cells, whose tiles are so many that the one process that writes them could
/// not follow hundreds of cores (see [`crate::clusters`]) ..
const MOST_TILES: usize = 1 << 20;
/// .. at most 1 MiB of verdicts, the size of HDF5's cache of chunks ..
const MOST_TILE_CELLS_OF_ALL: usize = 1 << 20;
/// .. at least so much that a tile's own costs do not show, which is little where each cell takes orbits of
/// its own: there a tile may take seconds, and finished ones are what an interruption leaves ..
const LEAST_TILE_CELLS: usize = 1 << 12;
const LEAST_TILE_CELLS_WITH_ORBITS: usize = 1 << 4;
/// .. and in between so many tiles that workers finish together and an interruption is heeded soon. All of
/// them depend on the plan alone, so that maps do not depend on the machine.
const TILES: usize = 256;

/// Cells of a tile of a grid of so many cells; `orbits` says whether cells take orbits of their own.
pub(super) fn cells(all: usize, orbits: bool) -> usize {
    let most = (all / MOST_TILES).clamp(MOST_TILE_CELLS, MOST_TILE_CELLS_OF_ALL);
    let least = if orbits { LEAST_TILE_CELLS_WITH_ORBITS } else { LEAST_TILE_CELLS };
    (all / TILES).clamp(least, most)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_neither_too_small_nor_too_many() {
        let cases = [
            (1, 1 << 12),
            (1 << 22, 1 << 14),
            (1_000_000_000, 1 << 16),
            (10_000_000_000, 1 << 16),
            (1 << 37, 1 << 17),
            (1_000_000_000_000, 953_674),
            (usize::MAX, 1 << 20),
        ];
        for (all, tile) in cases {
            assert_eq!(cells(all, false), tile, "{all} cells");
        }
        for (all, tile) in [(306, 16), (1 << 14, 64), (1 << 22, 1 << 14), (1_000_000_000, 1 << 16)] {
            assert_eq!(cells(all, true), tile, "{all} cells with orbits");
        }
    }
}

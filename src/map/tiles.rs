//! How large the tiles of a grid are.

/// A tile is a task of one worker and a chunk of the map file. At most 64 KiB of verdicts, 512 KiB of a
/// real field, which suits readers of HDF5 ..
const MOST_TILE_CELLS: usize = 1 << 16;
/// .. but for grids beyond 10^10 cells, whose tiles are so many that the one process that writes them could
/// not follow hundreds of cores (see [`crate::clusters`]) ..
const MOST_TILES: usize = 1 << 20;
/// .. at most 1 MiB of verdicts, the size of HDF5's cache of chunks ..
const MOST_TILE_CELLS_OF_ALL: usize = 1 << 20;
/// .. at least so much that a tile's own costs do not show ..
const LEAST_TILE_CELLS: usize = 1 << 12;
/// .. and in between so many tiles that workers finish together and an interruption is heeded soon. All of
/// them depend on the grid alone, so that maps do not depend on the machine.
const TILES: usize = 256;

/// Cells of a tile of a grid of so many cells.
pub(super) fn cells(all: usize) -> usize {
    let most = (all / MOST_TILES).clamp(MOST_TILE_CELLS, MOST_TILE_CELLS_OF_ALL);
    (all / TILES).clamp(LEAST_TILE_CELLS, most)
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
            assert_eq!(cells(all), tile, "{all} cells");
        }
    }
}

//! The size of the tiles of a grid. It depends on the plan alone, so that maps do not depend on the machine.

/// Usual largest number of cells of a tile, which is a task of one worker and a chunk of the map file: 64 KiB
/// of verdicts and 512 KiB of a real field suit readers of HDF5.
const MOST_TILE_CELLS: usize = 1 << 16;
/// Largest number of tiles up to which [`MOST_TILE_CELLS`] applies. Grids beyond 10^10 cells have larger
/// tiles, since the one thread that writes them could not keep up with many cores (docs/clusters.md).
const MOST_TILES: usize = 1 << 20;
/// Largest number of cells of a tile of any grid: 1 MiB of verdicts, the size of HDF5's cache of chunks.
const MOST_TILE_CELLS_OF_ALL: usize = 1 << 20;
/// Least number of cells of a tile, so that the overhead per tile is small.
const LEAST_TILE_CELLS: usize = 1 << 12;
/// Least number of cells of a tile where each cell needs orbits of its own: such a tile may take seconds, and
/// an interruption loses unfinished tiles.
const LEAST_TILE_CELLS_WITH_ORBITS: usize = 1 << 4;
/// Least number of cells of a tile where columns are interpolated: each tile has its own nodes.
pub(super) const LEAST_CELLS_INTERPOLATED: usize = 1 << 14;
/// Target for the number of tiles within these limits: workers then finish together, and an interruption
/// takes effect soon.
const TILES: usize = 256;

/// Largest number of cells of a tile of a grid of `all` cells.
fn most(all: usize) -> usize {
    (all / MOST_TILES).clamp(MOST_TILE_CELLS, MOST_TILE_CELLS_OF_ALL)
}

/// Number of cells of a tile of a grid of `all` cells; `orbits` is true if cells need orbits of their own.
pub(super) fn cells(all: usize, orbits: bool) -> usize {
    let least = if orbits { LEAST_TILE_CELLS_WITH_ORBITS } else { LEAST_TILE_CELLS };
    (all / TILES).clamp(least, most(all))
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

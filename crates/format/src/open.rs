//! Opens a map: verifies the whole file before any part is used.

use std::path::Path;

use super::error::StoreError;
use super::layout;
use super::reader::MapFile;
use super::seal::{self, Seal};
use super::{check, curves};

/// Length in bytes of a map up to which it is verified as a whole when it is opened: a part of a second.
const LARGE: u64 = 1 << 28;

impl MapFile {
    /// Opens the map at `path`, which may be any file. Refuses files that changed after their run.
    ///
    /// The seal is checked first: every byte is read once, before the HDF5 library opens the file. A map that
    /// another program has written to or copied has no seal; then all cells and attributes are compared with
    /// their fingerprints.
    ///
    /// Of a sealed map of more than 256 MiB no more is read than is asked for: now the attributes, the
    /// axes and the curves, each with its checksum, and the tiles later. The stream of a tile ends with a checksum
    /// of 32 bits, which the HDF5 library compares; `check` verifies all by the seal and by SHA-256.
    ///
    /// # Errors
    /// [`StoreError::NotAMap`] for a file that no version of this program wrote, or that this version cannot
    /// read; [`StoreError::Damaged`] for a map that was changed; otherwise the error of the file system or of
    /// the library.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        Self::open_beyond(path, LARGE)
    }

    /// As [`MapFile::open`], where a map of more than `large` bytes is a large one.
    fn open_beyond(path: &Path, large: u64) -> Result<Self, StoreError> {
        let damaged = |what: String| StoreError::Damaged { path: path.to_path_buf(), what };
        let mut seal = seal::of(path, large)?;
        let mut map = None;
        if seal == Seal::NotCompared {
            let mut large = Self::open_layout(path)?;
            match large.number("compression") {
                Some(level) if level > 0.0 => {
                    large.by_parts = true;
                    map = Some(large);
                }
                // Its tiles have no checksums.
                _ => seal = seal::of(path, u64::MAX)?,
            }
        }
        if seal == Seal::Broken {
            return Err(damaged(seal::BROKEN.into()));
        }
        let mut map = match map {
            Some(map) => map,
            None => Self::open_layout(path)?,
        };
        map.sealed = seal != Seal::Missing;
        for variable in &map.schema.variables {
            let dataset = map.dataset(&variable.name)?;
            layout::variable(&dataset, &map.schema, variable)
                .map_err(|unfit| StoreError::unfit(format!("read {} in", variable.name), path, unfit))?;
        }
        map.curves = curves::read(&map.file, &map.schema.grid)
            .map_err(|unfit| StoreError::unfit(format!("read {} in", curves::GROUP), path, unfit))?;
        let report = match (map.sealed, map.by_parts) {
            (true, false) => return Ok(map),
            (true, true) => check::contents(&map, None),
            (false, _) => check::contents(&map, Some(&|_| {})),
        };
        match report.problems.first() {
            None => Ok(map),
            Some(problem) => Err(damaged(problem.to_string())),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;
    use crate::{Journals, Outcome, PartialMap, Provenance};
    use slipmap_column::{Method, Verdict};
    use slipmap_files::Existing;
    use slipmap_map::{Account, Field, Grid, MethodCells, Plan, Runs, Sink, TileData};
    use slipmap_model::friction::Law;

    /// A map of eight tiles with margins.
    fn write(path: &Path, compression: u8) {
        let nodes = [4usize, 1, 1, 1, 16, 32].map(|len| (1..=len).map(|i| i as f64 / 64.0).collect());
        let grid = Grid::new(Law::Stribeck, nodes.into()).unwrap();
        let tile_shape = grid.tile_shape(8 * 32);
        let method = Method::Simulation;
        let plan = Plan::builder(grid).methods([method]).fields([Field::Margin]).audit_cells(0);
        let plan = plan.tile_shape(tile_shape).compression(compression).build().unwrap();
        let provenance = Provenance { git: "a commit".into(), ..Provenance::default() };
        let map = PartialMap::begin(path, &plan, &provenance, Existing::Refuse).unwrap();
        for number in 0..plan.tile_count() {
            let tile = plan.grid.tile(&plan.tile_shape, number);
            let cells = tile.cells();
            let verdicts = (0..cells).map(|cell| [Verdict::Present, Verdict::Absent][cell / 7 % 2]).collect();
            let margins = (0..cells).map(|cell| (cell as f64 + number as f64).sin()).collect();
            let cells = MethodCells { margins, ..MethodCells::new(method, verdicts) };
            let data = TileData { methods: vec![cells], regime: Runs::new(), quantities: vec![], tile };
            map.write(map.pack(&data).unwrap(), &Account::none(&plan)).unwrap();
        }
        let numbers = ["threads", "wall_seconds"].map(|name| (name.to_owned(), 1.0.into()));
        map.finish(&Outcome { attributes: numbers.into(), ..Outcome::default() }).unwrap();
        assert!(Journals::beside(path, &plan, &provenance, None).unwrap().is_none());
    }

    #[test]
    fn a_large_map_is_verified_where_it_is_read() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.h5");
        write(&path, 4);
        let whole = fs::read(&path).unwrap();
        let name = "margin_simulation";
        let tiles = |map: &MapFile| -> Vec<Option<Vec<f64>>> {
            let cells =
                |ranges: &[_]| map.reals(name, ranges).ok().map(|cells| cells.into_raw_vec_and_offset().0);
            map.tiles().map(|tile| cells(&tile.ranges)).collect()
        };
        let open = || MapFile::open_beyond(&path, 0);
        let (expected, chunks) = {
            let map = open().unwrap();
            assert!(map.by_parts && map.sealed);
            let dataset = map.file.dataset(name).unwrap();
            let chunk = |number| dataset.chunk_info(number).unwrap();
            let place = |number| (chunk(number).addr as usize, chunk(number).size as usize);
            (tiles(&map), (0..8).map(place).collect::<Vec<_>>())
        };
        for (tile, (start, length)) in chunks.into_iter().enumerate() {
            for place in (start..start + length).step_by(length / 5) {
                let mut bytes = whole.clone();
                bytes[place] ^= 1 << (place % 8);
                fs::write(&path, bytes).unwrap();
                assert!(matches!(MapFile::open(&path), Err(StoreError::Damaged { .. })));
                let found = tiles(&open().unwrap());
                for (number, (found, expected)) in found.iter().zip(&expected).enumerate() {
                    assert_eq!(found.as_ref(), expected.as_ref().filter(|_| number != tile), "tile {number}");
                }
                assert!(!check::check(&path, &|_| {}).unwrap().is_sound());
            }
        }
        // Without compression tiles have no checksums, and without a seal nothing tells that it was not changed.
        fs::remove_file(&path).unwrap();
        write(&path, 0);
        assert!(!open().unwrap().by_parts);
        let mut bytes = fs::read(&path).unwrap();
        bytes.truncate(bytes.len() - 1);
        fs::write(&path, bytes).unwrap();
        let map = open().unwrap();
        assert!(!map.by_parts && !map.sealed);
    }
}

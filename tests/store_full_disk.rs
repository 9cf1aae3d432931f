//! A full disk is reported, and nothing is left but the journal of what was computed.
//!
//! A separate program, because it starts processes, which inherit the locks of all files that HDF5 has
//! open.

#![cfg(all(unix, feature = "store"))]
// clippy.toml exempts only test functions, not their helpers.
#![allow(clippy::expect_used)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use slipmap::friction::Law;
use slipmap::map::{Account, Field, Grid, Method, MethodCells, Plan, Runs, Sink, TileData, Verdict};
use slipmap::store::{Existing, Outcome, PartialMap, Provenance, StoreError};
use slipmap_numbers::random::Random;
use tempfile::TempDir;

/// The environment variable with the output folder, for this program started again under a limit on the size
/// of files.
const FOLDER: &str = "SLIPMAP_TEST_FULL_DISK";

/// Writes a map of eight tiles whose margins are incompressible.
fn write(path: &Path) -> Result<(), StoreError> {
    let nodes = [4usize, 1, 1, 1, 16, 32].map(|len| (1..=len).map(|i| i as f64 / 64.0).collect());
    let grid = Grid::new(Law::Stribeck, nodes.into()).expect("legal axes");
    let tile_shape = grid.tile_shape(8 * 32);
    let method = Method::Simulation;
    let plan = Plan::builder(grid)
        .methods([method])
        .fields([Field::Margin])
        .audit_cells(0)
        .tile_shape(tile_shape)
        .build()
        .expect("a legal plan");
    let writer = PartialMap::begin(path, &plan, &Provenance::default(), Existing::Refuse)?;
    let mut random = Random(1);
    for number in 0..plan.tile_count() {
        let tile = plan.grid.tile(&plan.tile_shape, number);
        // Numbers that do not compress.
        let margins = (0..tile.cells()).map(|_| f64::from_bits(random.bits() >> 2));
        let margins = margins.collect();
        let verdicts = std::iter::repeat_n(Verdict::Present, tile.cells()).collect();
        let data = TileData {
            methods: vec![MethodCells {
                method,
                verdicts,
                margins,
                critical: vec![],
                critical_errors: vec![],
            }],
            regime: Runs::new(),
            quantities: vec![],
            tile,
        };
        writer.write(writer.pack(&data)?, &Account::none(&plan))?;
    }
    writer.finish(&Outcome::default())
}

#[test]
fn a_full_disk_is_reported_and_leaves_no_part_of_a_map() {
    if let Some(folder) = std::env::var_os(FOLDER) {
        let error = write(&PathBuf::from(folder).join("map.h5")).expect_err("there is no room");
        assert!(matches!(error, StoreError::DiskFull { .. }), "{error}");
        return;
    }
    let folder = TempDir::new().expect("a scratch folder");
    let path = folder.path().join("map.h5");
    write(&path).expect("there is room");
    // The shell counts in blocks of 512 bytes; the last one is not full, or just full.
    let blocks = (fs::metadata(&path).expect("it was written").len() - 1) / 512;
    // Space for nothing, for some chunks, for all chunks, for all but the seal.
    for limit in [0, blocks / 4, blocks / 2, 3 * blocks / 4, blocks - 1, blocks] {
        let folder = TempDir::new().expect("a scratch folder");
        let child = Command::new("sh")
            .args([
                "-c",
                "trap '' XFSZ; ulimit -f $1; exec \"$0\" --exact a_full_disk_is_reported_and_leaves_no_part_of_a_map",
            ])
            .arg(std::env::current_exe().expect("this program"))
            .arg(limit.to_string())
            .env(FOLDER, folder.path())
            .output()
            .expect("the shell runs");
        assert!(
            child.status.success(),
            "limit of {limit} blocks: {}",
            String::from_utf8_lossy(&child.stdout)
        );
        let left = fs::read_dir(folder.path()).expect("the folder is there");
        let mut left = left.map(|entry| entry.expect("it can be listed").file_name());
        assert!(
            left.all(|name| name.to_string_lossy().starts_with("map.h5.part.")),
            "limit of {limit} blocks"
        );
        assert_eq!(String::from_utf8_lossy(&child.stderr), "", "HDF5 is to be silent");
    }
}

//! Map files: any bytes as the file of `slipmap check`, `report` and `plot`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use slipmap::store::{MapFile, check};
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().expect("a scratch folder"));

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("map.h5");
    std::fs::write(&path, bytes).expect("room for a file");
    let _ = check(&path);
    if let Ok(map) = MapFile::open(&path) {
        for variable in map.variables() {
            let _ = map.counts(variable);
            for tile in map.tiles() {
                let _ = map.codes(variable, &tile.ranges);
                let _ = map.reals(variable, &tile.ranges);
            }
        }
    }
});

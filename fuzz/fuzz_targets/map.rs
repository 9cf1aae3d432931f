//! Map files: any bytes as the file of `slipmap check`, `report` and `plot`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use sha2::{Digest as _, Sha256};
use slipmap::store::{MapFile, check};
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().expect("a scratch folder"));

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("map.h5");
    std::fs::write(&path, bytes).expect("room for a file");
    let _ = check(&path);
    // Whoever changes a map on purpose can seal it as well.
    let digits: String = Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect();
    let seal = format!("\nslipmap seal, sha256 of every byte before this line: {digits}\n");
    std::fs::write(&path, [bytes, seal.as_bytes()].concat()).expect("room for a file");
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

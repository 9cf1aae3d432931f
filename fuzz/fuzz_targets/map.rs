//! Map files: arbitrary bytes as the file of `slipmap check`, `report` and `plot`.
//!
//! The seal would reveal damage before anything else is read, so every file gets a valid seal, like one that
//! was forged.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use sha2::{Digest, Sha256};
use slipmap::store::{MapFile, check};
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().expect("a scratch folder"));

const LABEL: &[u8] = b"\nslipmap seal, sha256 of every byte before this line: ";

fn sealed(bytes: &[u8]) -> Vec<u8> {
    let end = bytes.windows(LABEL.len()).rposition(|part| part == LABEL).unwrap_or(bytes.len());
    let mut file = bytes[..end].to_vec();
    let digits: String = Sha256::digest(&file).iter().map(|byte| format!("{byte:02x}")).collect();
    file.extend_from_slice(LABEL);
    file.extend_from_slice(digits.as_bytes());
    file.push(b'\n');
    file
}

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("map.h5");
    std::fs::write(&path, sealed(bytes)).expect("room for a file");
    let _ = check(&path, &|_| {});
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

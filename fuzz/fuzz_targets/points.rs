//! Tables of points: arbitrary bytes as the CSV of `slipmap probe --points`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use slipmap::config::PointTable;
use slipmap::friction::Law;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().expect("a scratch folder"));

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("points.csv");
    std::fs::write(&path, bytes).expect("room for a file");
    for law in [Law::Stribeck, Law::Exponential] {
        let Ok((mut table, law)) = PointTable::open(&path, &law, &[]) else { continue };
        while let Ok(rows) = table.rows() {
            if rows.is_empty() {
                break;
            }
            for row in &rows {
                if let Ok(point) = table.point(row, &law) {
                    assert!(point.epsilon > 0.0 && point.belt_speed > 0.0 && point.damping >= 0.0);
                }
            }
        }
    }
});

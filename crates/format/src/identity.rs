//! Compares the plan of an unfinished or finished run with a new one, to decide whether it may be resumed.

use std::collections::BTreeMap;
use std::path::Path;

use imara_diff::{Algorithm, Diff, InternedInput};

use slipmap_map::dataset::Value;
use slipmap_map::dataset::attributes::PLAN;

use super::error::StoreError;
use super::reader::MapFile;

/// Attributes that are compared to explain why two fingerprints of plans differ, in the order in which
/// differences are shown.
const SHOWN: [&str; 11] = [
    "config",
    "crate_version",
    "git",
    "schema",
    "law",
    "law_definition",
    "methods",
    "fields",
    "tolerance",
    "tile_shape",
    "compression",
];

/// Returns an error unless the finished map at `path` is the one that `opening` describes.
pub(super) fn check_finished(path: &Path, opening: &[(String, Value)]) -> Result<(), StoreError> {
    let map = MapFile::open(path).map_err(|error| match error {
        // Slipmap never writes a file that the library cannot read here.
        StoreError::Hdf5 { doing, path, detail } => {
            StoreError::NotAMap { path, why: format!("cannot {doing} it: {detail}") }
        }
        other => other,
    })?;
    match difference(map.attributes(), opening) {
        None => Ok(()),
        Some(difference) => Err(StoreError::Changed { path: path.to_path_buf(), difference }),
    }
}

/// Differences of two plans, line by line; `None` if their fingerprints are equal.
pub(super) fn difference(then: &BTreeMap<String, Value>, now: &[(String, Value)]) -> Option<String> {
    let of_now = |name| now.iter().find(|(known, _)| known == name).map(|(_, value)| value);
    if then.get(PLAN) == of_now(PLAN) {
        return None;
    }
    let mut lines = Vec::new();
    for name in SHOWN.into_iter().chain([PLAN]) {
        let (Some(old), Some(new)) = (then.get(name), of_now(name)) else { continue };
        if old == new || (name == PLAN && !lines.is_empty()) {
            continue;
        }
        let (old, new) = (shown(old), shown(new));
        lines.push(format!("  {name}"));
        let texts = InternedInput::new(old.as_str(), new.as_str());
        let line = |token| texts.interner[token].trim_end();
        for hunk in Diff::compute(Algorithm::Myers, &texts).hunks() {
            let [from, to] =
                [&hunk.before, &hunk.after].map(|lines| lines.start as usize..lines.end as usize);
            lines.extend(texts.before[from].iter().map(|&old| format!("    - {}", line(old))));
            lines.extend(texts.after[to].iter().map(|&new| format!("    + {}", line(new))));
        }
    }
    (!lines.is_empty()).then(|| lines.join("\n"))
}

fn shown(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        Value::Integers(values) => format!("{values:?}"),
        Value::Codes(values) => format!("{values:?}"),
        Value::Reals(values) => format!("{values:?}"),
    }
}

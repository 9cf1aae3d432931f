//! What tells one computation from another: may a run be resumed as this one?

use std::path::Path;

use similar::{ChangeTag, TextDiff};

use crate::dataset::Value;
use crate::dataset::attributes::fingerprint;
use crate::map::{Method, Plan};

use super::error::StoreError;
use super::reader::MapFile;

/// In the journal's header: fingerprint of all that the result depends on.
pub(super) const PLAN: &str = "plan_sha256";
/// Attributes that tell one computation from another, in the order in which differences are shown.
const IDENTITY: [&str; 14] = [
    "config",
    "crate_version",
    "git",
    "schema",
    "law",
    "law_definition",
    "methods",
    "fields",
    "engine",
    "tolerance",
    "tile_shape",
    "compression",
    "title",
    PLAN,
];

/// Fingerprint of all that the cells of a map depend on: the plan but for what is proved between the cells, and the
/// program that computes it.
#[must_use]
pub fn plan_digest(plan: &Plan) -> String {
    let Plan {
        grid,
        methods,
        fields,
        engine,
        tolerance,
        audit_cells,
        proof_boxes: _,
        tile_shape,
        compression,
    } = plan;
    let methods: Vec<String> = methods
        .iter()
        .map(|method| match method {
            Method::Test(_) | Method::Simulation => method.name().to_owned(),
            Method::Naive(naive, knobs) => format!("{naive:?} {knobs:?}"),
        })
        .collect();
    // The text that Rust gives a number reads back as the same number, so that equal texts are equal plans.
    fingerprint(&format!(
        "{} {} {grid:?} {methods:?} {fields:?} {engine:?} {tolerance:?} {audit_cells} {tile_shape:?} {compression}",
        env!("CARGO_PKG_VERSION"),
        env!("SLIPMAP_GIT")
    ))
}

/// Refuses a finished map that is not the one that `opening` describes.
pub(super) fn check_finished(path: &Path, opening: &[(String, Value)]) -> Result<(), StoreError> {
    let map = MapFile::open(path).map_err(|error| match error {
        // What the library cannot read here, slipmap has not written.
        StoreError::Hdf5 { doing, path, detail } => {
            StoreError::NotAMap { path, why: format!("cannot {doing} it: {detail}") }
        }
        other => other,
    })?;
    let then: Vec<(String, Value)> =
        map.attributes().iter().map(|(name, value)| (name.clone(), value.clone())).collect();
    match difference(&then, opening) {
        None => Ok(()),
        Some(difference) => Err(StoreError::Changed { path: path.to_path_buf(), difference }),
    }
}

pub(super) fn get<'a>(attributes: &'a [(String, Value)], name: &str) -> Option<&'a Value> {
    attributes.iter().find(|(known, _)| known == name).map(|(_, value)| value)
}

/// In what two computations differ, line by line; `None` if in nothing that both tell of.
pub(super) fn difference(then: &[(String, Value)], now: &[(String, Value)]) -> Option<String> {
    let mut lines = Vec::new();
    for name in IDENTITY {
        let (Some(old), Some(new)) = (get(then, name), get(now, name)) else { continue };
        if old == new || (name == PLAN && !lines.is_empty()) {
            continue;
        }
        let (old, new) = (shown(old), shown(new));
        lines.push(format!("  {name}"));
        let changes = TextDiff::from_lines(&old, &new);
        lines.extend(changes.iter_all_changes().filter_map(|change| match change.tag() {
            ChangeTag::Delete => Some(format!("    - {}", change.value().trim_end())),
            ChangeTag::Insert => Some(format!("    + {}", change.value().trim_end())),
            ChangeTag::Equal => None,
        }));
    }
    (!lines.is_empty()).then(|| lines.join("\n"))
}

/// A value as text of lines.
fn shown(value: &Value) -> String {
    match value {
        Value::Text(text) => text.clone(),
        Value::Integers(values) => format!("{values:?}"),
        Value::Codes(values) => format!("{values:?}"),
        Value::Reals(values) => format!("{values:?}"),
    }
}

//! Tables of the provenance of a map: costs, failures, methods, axes and the run.

use super::super::Report;
use super::super::table::{Cell, Column, Show, Table};
use super::super::text::{Rich, rich};
use super::super::units::View;
use super::words;
use crate::map::{Verdict, is_linear, is_logarithmic};
use crate::store::{MapFile, Value};

/// Processor time of each method.
#[must_use]
pub fn cost(map: &MapFile) -> Table {
    let cells = map.grid().cells() as u64;
    let rows = map.methods().iter().map(|method| {
        let seconds = map.number(&format!("seconds_{}", method.name));
        let rate = seconds.filter(|seconds| *seconds > 0.0).map(|seconds| cells as f64 / seconds);
        vec![words(&method.name), Cell::Count(cells), seconds.into(), rate.into()]
    });
    let mut notes = vec![rich("Seconds are summed over all threads; packing and auditing are not in them.")];
    let paths: Vec<String> = map
        .attributes()
        .iter()
        .filter_map(|(name, value)| match (name.strip_prefix("cells_by_"), value) {
            (Some(path), Value::Integers(count)) if count.iter().any(|count| *count > 0) => {
                Some(format!("{} {}", path.replace('_', " "), count[0]))
            }
            _ => None,
        })
        .collect();
    if !paths.is_empty() {
        let text = format!("Cells that the simulation decided by each of its paths: {}.", paths.join(", "));
        notes.push(Rich::foreign(&text));
    }
    Table {
        name: "cost",
        caption: rich("Processor time of each method."),
        columns: vec![
            Column::new("method", "method", Show::AsIs),
            Column::new("cells", "cells", Show::AsIs),
            Column::new("seconds", "seconds", Show::Significant(3)),
            Column::new("cells_per_second", "cells per second", Show::Significant(3)),
        ],
        rows: rows.collect(),
        notes,
    }
}

/// Failures during the run.
#[must_use]
pub fn failures(map: &MapFile, report: &Report) -> Table {
    let mut rows = Vec::new();
    for (method, confusion) in map.methods().iter().zip(&report.verdicts.confusion) {
        for (what, verdict) in [("failed", Verdict::Failed), ("not computed", Verdict::NotComputed)] {
            let cells: u64 = confusion.iter().map(|counts| counts.method(verdict)).sum();
            if cells > 0 {
                rows.push(vec![words(&format!("{}: cells {what}", method.name)), Cell::Count(cells)]);
            }
        }
    }
    if rows.is_empty() {
        rows.push(vec![words("cells without an answer, of all methods"), Cell::Count(0)]);
    }
    let count = |name: &str| map.number(name).map(|number| number as u64);
    rows.push(vec![words("audit: cells decided again by the direct engine"), count("audit_cells").into()]);
    rows.push(vec![words("audit: verdicts contradicted"), count("audit_disagreements").into()]);
    let contradicted = count("contradicted_cells").into();
    rows.push(vec![
        words("cells in which theorems, proofs or simulation contradict each other"),
        contradicted,
    ]);
    let mut notes = Vec::new();
    if count("audit_cells").is_none() {
        notes.push(rich("The run had no audit."));
    }
    if let Some(reason) = map.text("not_computed") {
        notes.push(rich("Why cells were not computed: ").then(Rich::foreign(reason)));
    }
    Table {
        name: "failures",
        caption: rich("Failures, and the audit by the independent engine."),
        columns: vec![Column::new("what", "what", Show::AsIs), Column::new("count", "count", Show::AsIs)],
        rows,
        notes,
    }
}

pub(crate) fn methods(map: &MapFile) -> Table {
    let rows = map.methods().iter().map(|method| {
        vec![
            words(&method.name),
            words(&method.long_name),
            words(&method.guarantee.replace('_', " ")),
            words(&method.equation),
        ]
    });
    Table {
        name: "methods",
        caption: rich("The methods of the map."),
        columns: vec![
            Column::new("method", "method", Show::AsIs),
            Column::new("long_name", "what it is", Show::AsIs),
            Column::new("guarantee", "guarantee", Show::AsIs),
            Column::new("equation", "equation", Show::AsIs),
        ],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

/// The axes of the map.
#[must_use]
pub fn axes(view: &View) -> Table {
    let rows = view.map.grid().axes().iter().map(|axis| {
        let label = view.axis(axis);
        let last = axis.values[axis.values.len() - 1];
        vec![
            words(&axis.name),
            words(&axis.long_name),
            Cell::Count(axis.values.len() as u64),
            Cell::Real(axis.values[0] * label.factor),
            Cell::Real(last * label.factor),
            words(if label.unit.is_empty() { "1" } else { label.unit }),
            words(match axis.values.len() {
                1 => "one value",
                _ if is_linear(&axis.values) => "equal steps",
                _ if is_logarithmic(&axis.values) => "equal ratios",
                _ => "list",
            }),
        ]
    });
    Table {
        name: "axes",
        caption: rich("The axes of the map, slowest first."),
        columns: vec![
            Column::new("axis", "axis", Show::AsIs),
            Column::new("long_name", "what it is", Show::AsIs),
            Column::new("nodes", "nodes", Show::AsIs),
            Column::new("from", "from", Show::Trimmed(6)),
            Column::new("to", "to", Show::Trimmed(6)),
            Column::new("unit", "unit", Show::AsIs),
            Column::new("spacing", "spacing", Show::AsIs),
        ],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

/// Provenance of the map.
#[must_use]
pub fn provenance(map: &MapFile) -> Table {
    let entries = [
        ("title", "title"),
        ("map file", ""),
        ("cells", ""),
        ("written by", "history"),
        ("sources", "git"),
        ("machine", "machine"),
        ("threads", "threads"),
        ("wall-clock seconds", "wall_seconds"),
        ("friction law", "law"),
        ("engine", "engine"),
        ("tolerance", "tolerance"),
        ("fields", "fields"),
        ("configuration", "config_path"),
        ("SHA-256 of the configuration", "config_sha256"),
        ("SHA-256 of the map's attributes", "sha256_attributes"),
        ("references", "references"),
        ("reported by", ""),
    ];
    let rows = entries.iter().filter_map(|&(what, attribute)| {
        let cell = match what {
            "map file" => {
                let name = map.path().file_name().unwrap_or(map.path().as_os_str());
                Cell::Words(name.to_string_lossy().into_owned())
            }
            "cells" => Cell::Words(map.grid().cells().to_string()),
            "reported by" => Cell::Words(format!("slipmap {}", env!("CARGO_PKG_VERSION"))),
            _ => match map.attributes().get(attribute)? {
                Value::Text(text) => Cell::Words(text.clone()),
                Value::Integers(numbers) => Cell::Words(format!("{}", numbers.first()?)),
                Value::Reals(numbers) => Cell::Words(format!("{:?}", numbers.first()?)),
                Value::Codes(_) => return None,
            },
        };
        Some(vec![words(what), cell])
    });
    Table {
        name: "provenance",
        caption: rich("Where the map comes from."),
        columns: vec![Column::new("what", "what", Show::AsIs), Column::new("value", "value", Show::AsIs)],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

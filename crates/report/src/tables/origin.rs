//! Tables of the provenance of a map: costs, failures, methods, axes and the run.

use super::super::Report;
use super::super::table::{Cell, Column, ColumnOf, Show, Table};
use super::super::view::View;
use super::words;
use slipmap_column::{Method, Regime, Verdict};
use slipmap_figure::text::{Rich, rich};
use slipmap_format::{MapFile, Value};
use slipmap_map::{Axis, AxisRole};
use slipmap_numbers::spacing::{is_linear, is_logarithmic};
use slipmap_page::units::Label;

pub fn cost(map: &MapFile) -> Table {
    let cells = map.grid().cells() as u64;
    let seconds = |method: &Method| map.number(&format!("seconds_{}", method.name()));
    let rate = |method: &Method| {
        seconds(method).filter(|seconds| *seconds > 0.0).map(|seconds| cells as f64 / seconds)
    };
    let mut notes = vec![rich(
        "Seconds of the verdicts, summed over all threads; fields, curves, packing and auditing are not in them.",
    )];
    let proofs = map.number("proved_boxes").zip(map.number("proved_seconds"));
    if let Some((boxes, seconds)) = proofs {
        notes.push(rich(&format!(
            "Beside them, validated took {seconds:.1} s of wall-clock time to prove {boxes} boxes of parameters."
        )));
    }
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
        let text = format!(
            "Cells that the simulation decided by each of its paths: {}. Certificate: a theorem. Critical surface, \
             interpolation: the critical damping of the column, from its own search, or interpolated between columns. Order: between two cells of equal fate. Orbit: its own.",
            paths.join(", ")
        );
        notes.push(Rich::foreign(&text));
    }
    let by = |paths: &[&str]| -> f64 {
        paths.iter().filter_map(|path| map.number(&format!("cells_by_{path}"))).sum::<f64>() * 100.0
            / cells as f64
    };
    let theorem = by(&["certificate"]);
    let compared = by(&["interpolation", "critical_surface", "order"]);
    if theorem + compared > 0.0 {
        notes.push(rich(&format!(
            "What the simulation owes to theorems: {theorem:.1} % of its verdicts are those of symmetric, so that to agree \
             with it is no evidence there; {compared:.1} % compare {{c}} with the critical damping of the column or stand between two of equal fate, which \
             Theorem 1 allows. The method direct integrates every cell."
        )));
    }
    let columns: [ColumnOf<Method>; 4] = [
        ("method", "method", Show::AsIs, &|method| words(method.name())),
        ("cells", "cells", Show::AsIs, &|_| Cell::Count(cells)),
        ("seconds", "seconds", Show::Significant(3), &|method| seconds(method).into()),
        ("cells_per_second", "cells per second", Show::Significant(3), &|method| rate(method).into()),
    ];
    Table { notes, ..Table::of("cost", rich("Processor time of each method."), map.methods(), &columns) }
}

/// Number of cells whose regime is not determined; `None` for a map without regimes.
pub(crate) fn undetermined_regimes(map: &MapFile) -> Option<u64> {
    let position = Regime::ALL.iter().position(|regime| *regime == Regime::Failed)?;
    map.counts("regime").ok()?.get(position).copied()
}

/// Failures during the run.
pub fn failures(map: &MapFile, report: &Report) -> Table {
    let mut rows: Vec<(String, Option<u64>)> = Vec::new();
    for (method, confusion) in map.methods().iter().zip(&report.verdicts.confusion) {
        for (what, verdict) in [("failed", Verdict::Failed), ("not computed", Verdict::NotComputed)] {
            let cells: u64 = confusion.iter().map(|counts| counts.method(verdict)).sum();
            if cells > 0 {
                rows.push((format!("{}: cells {what}", method.name()), Some(cells)));
            }
        }
    }
    if rows.is_empty() {
        rows.push(("cells without an answer, of all methods".into(), Some(0)));
    }
    if let Some(cells) = undetermined_regimes(map) {
        rows.push(("cells whose regime is not determined".into(), Some(cells)));
    }
    let count = |name: &str| map.number(name).map(|number| number as u64);
    let recorded = [
        ("audit: cells decided again by the direct engine", "audit_cells"),
        ("audit: verdicts contradicted", "audit_disagreements"),
        ("cells in which theorems, proofs or simulation contradict each other", "contradicted_cells"),
    ];
    rows.extend(recorded.map(|(what, attribute)| (what.to_owned(), count(attribute))));
    let mut notes = Vec::new();
    if count("audit_cells").is_none() {
        notes.push(rich("The run had no audit."));
    }
    let columns: [ColumnOf<(String, Option<u64>)>; 2] = [
        ("what", "what", Show::AsIs, &|(what, _)| words(what)),
        ("count", "count", Show::AsIs, &|(_, count)| (*count).into()),
    ];
    let caption = rich("Failures, and the audit by the independent engine.");
    Table { notes, ..Table::of("failures", caption, &rows, &columns) }
}

pub(crate) fn methods(map: &MapFile) -> Table {
    let law = map.grid().law();
    let columns: [ColumnOf<Method>; 4] = [
        ("method", "method", Show::AsIs, &|method| words(method.name())),
        ("long_name", "what it is", Show::AsIs, &|method| words(method.long_name())),
        ("guarantee", "guarantee", Show::AsIs, &|method| words(&method.guarantee().name().replace('_', " "))),
        ("equation", "equation", Show::AsIs, &|method| words(&method.equation_for(law))),
    ];
    Table::of("methods", rich("The methods of the map."), map.methods(), &columns)
}

/// The axes of the map, and the quantities of a machine that do not vary.
pub fn axes(view: &View) -> Table {
    let grid = view.map.grid();
    let axes = grid.axes().iter().map(|axis| {
        let Label { unit, factor, .. } = view.axis(axis);
        (axis.clone(), unit.into_owned(), factor)
    });
    let held = grid.fixed().into_iter().filter_map(|(name, value)| {
        let machine = grid.machine()?;
        let unit = machine.unit(name);
        let axis = Axis {
            name: name.into(),
            long_name: machine.words(name),
            unit,
            shown: None,
            role: AxisRole::Quantity,
            values: vec![value],
        };
        Some((axis, unit.to_owned(), 1.0))
    });
    let all: Vec<(Axis, String, f64)> = axes.chain(held).collect();
    let spacing = |axis: &Axis| match axis.values.len() {
        1 => "one value",
        _ if is_linear(&axis.values) => "equal steps",
        _ if is_logarithmic(&axis.values) => "equal ratios",
        _ => "list",
    };
    let columns: [ColumnOf<(Axis, String, f64)>; 7] = [
        ("axis", "axis", Show::AsIs, &|(axis, ..)| words(&axis.name)),
        ("long_name", "what it is", Show::AsIs, &|(axis, ..)| words(&axis.long_name)),
        ("nodes", "nodes", Show::AsIs, &|(axis, ..)| Cell::Count(axis.values.len() as u64)),
        ("from", "from", Show::Trimmed(6), &|(axis, _, factor)| Cell::Real(axis.values[0] * factor)),
        ("to", "to", Show::Trimmed(6), &|(axis, _, factor)| {
            Cell::Real(axis.values[axis.values.len() - 1] * factor)
        }),
        ("unit", "unit", Show::AsIs, &|(_, unit, _)| words(if unit.is_empty() { "1" } else { unit })),
        ("spacing", "spacing", Show::AsIs, &|(axis, ..)| words(spacing(axis))),
    ];
    let caption = match grid.machine() {
        Some(_) => "The axes of the map, slowest first, and the quantities that do not vary.",
        None => "The axes of the map, slowest first.",
    };
    Table::of("axes", rich(caption), &all, &columns)
}

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
        ("tolerance", "tolerance"),
        ("fields", "fields"),
        ("configuration", "config_path"),
        ("SHA-256 of the configuration", "config_sha256"),
        ("references", "references"),
        ("reported by", ""),
    ];
    let rows = entries.iter().filter_map(|&(what, attribute)| {
        let cell = match what {
            "map file" => {
                let name = map.path.file_name().unwrap_or(map.path.as_os_str());
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

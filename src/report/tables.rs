//! The tables of a report.

mod machine;

use super::table::{Cell, Column, Show, Table};
use super::text::{Rich, rich};
use super::{Confusion, Report};
use crate::map::Verdict;
use crate::store::{MapFile, Value};

/// All tables, in the order of the report.
#[must_use]
pub fn all(map: &MapFile, report: &Report) -> Vec<Table> {
    let mut tables = vec![
        volume(map, report),
        agreement(map, report),
        boundary(map, report),
        order(map, report),
        cost(map),
        failures(map, report),
        methods(map),
        axes(map),
        provenance(map),
    ];
    // What an engineer looks for comes first.
    if let Some(table) = machine::machine(map) {
        tables.insert(0, table);
    }
    tables
}

fn column(key: &'static str, heading: &str, show: Show) -> Column {
    Column { key, heading: rich(heading), show }
}

fn words(text: &str) -> Cell {
    Cell::Words(text.into())
}

fn epsilons(map: &MapFile) -> &[f64] {
    &map.grid().axes()[0].values
}

/// Significant digits with which eps is shown.
const EPSILON_DIGITS: Show = Show::Trimmed(4);

fn percent(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| 100.0 * part / whole)
}

/// Certified volume of each method at each eps.
#[must_use]
pub fn volume(map: &MapFile, report: &Report) -> Table {
    let verdicts = &report.verdicts;
    let mut rows = Vec::new();
    for (e, &epsilon) in epsilons(map).iter().enumerate() {
        let reference = verdicts.simulation.map(|method| verdicts.volumes[method][e]);
        for (method, volumes) in map.methods().iter().zip(&verdicts.volumes) {
            let volume = volumes[e];
            let relative = reference.filter(|reference| reference.claimed > 0.0);
            // The quotient of two uncertain volumes, at its worst.
            let relative_error = relative.map(|reference| {
                let middle = volume.claimed / reference.claimed;
                let (error, error_of_reference) = (volume.error_in_c, reference.error_in_c);
                let high = (volume.claimed + error) / (reference.claimed - error_of_reference).max(0.0);
                let low = (volume.claimed - error).max(0.0) / (reference.claimed + error_of_reference);
                100.0 * (high - middle).max(middle - low)
            });
            rows.push(vec![
                Cell::Real(epsilon),
                words(&method.name),
                Cell::Real(volume.claimed),
                Cell::Real(volume.error_in_c),
                Cell::Real(volume.error),
                percent(volume.claimed, verdicts.box_volume).into(),
                relative.and_then(|reference| percent(volume.claimed, reference.claimed)).into(),
                relative_error
                    .filter(|_| Some(&method.name) != simulation_name(map, verdicts.simulation))
                    .into(),
                relative.and_then(|reference| percent(volume.confirmed, reference.claimed)).into(),
            ]);
        }
    }
    let mut notes = vec![rich(
        "The volume is that of the points at which a method claims a stick-slip cycle, by the trapezoidal rule \
         over the axes of more than one node except {epsilon}. Its error is bounded twice: along {c} alone, the nodes \
         of the other axes taken as they are, by half of every step of {c} over which the verdict changes; and along \
         all axes by the boxes between neighbouring nodes whose corners do not all have the same verdict, a bound that \
         is wide where an axis has few nodes. The error of the percentage of the simulation is that along {c}.",
    )];
    if verdicts.dimensions == 0 {
        notes.push(rich(
            "No axis but that of {epsilon} has more than one node: the volume is 1 where the cycle is claimed, else 0.",
        ));
    }
    notes.extend(no_simulation(report));
    Table {
        name: "volume",
        caption: rich("Volume of parameter space in which each method claims a stick-slip cycle: ")
            .then(extents(map))
            .then(rich(".")),
        columns: vec![
            column("epsilon", "{epsilon}", EPSILON_DIGITS),
            column("method", "method", Show::AsIs),
            column("volume", "volume", Show::Significant(4)),
            column("volume_error_in_c", "± in {c}", Show::Significant(2)),
            column("volume_error", "± in all", Show::Significant(2)),
            column("percent_of_box", "% of the box", Show::Decimals(2)),
            column("percent_of_simulation", "% of simulation", Show::Decimals(2)),
            column("percent_of_simulation_error", "±", Show::Decimals(2)),
            column("percent_of_simulation_confirmed", "% confirmed", Show::Decimals(2)),
        ],
        rows,
        notes,
    }
}

fn simulation_name(map: &MapFile, position: Option<usize>) -> Option<&String> {
    position.map(|position| &map.methods()[position].name)
}

/// "0 <= alpha <= 0.9, gamma = 2" for every axis but eps.
fn extents(map: &MapFile) -> Rich {
    let mut text = Rich::default();
    for (i, axis) in map.grid().axes()[1..].iter().enumerate() {
        if i > 0 {
            text = text.then(rich(", "));
        }
        let (first, last) = (axis.values[0], axis.values[axis.values.len() - 1]);
        let symbol = Rich::symbol(&axis.name);
        text = text.then(match axis.values.len() {
            1 => symbol.then(rich(&format!(" = {first}"))),
            _ => symbol.then(rich(&format!(" from {first} to {last}"))),
        });
    }
    text
}

fn no_simulation(report: &Report) -> Option<Rich> {
    report.verdicts.simulation.is_none().then(|| {
        rich("The simulation is not among the methods of this map, so there is nothing to compare them with.")
    })
}

/// Agreement with the simulation, cell by cell.
#[must_use]
pub fn agreement(map: &MapFile, report: &Report) -> Table {
    let verdicts = &report.verdicts;
    let mut rows = Vec::new();
    let mut add = |epsilon: Cell, name: &str, counts: &Confusion| {
        let compared = counts.simulation(Verdict::Present) + counts.simulation(Verdict::Absent);
        let pair = |simulation, method| match verdicts.simulation {
            Some(_) => Cell::Count(counts.pair(simulation, method)),
            None => Cell::Missing,
        };
        let decided: u64 = counts.method(Verdict::Present) + counts.method(Verdict::Absent);
        rows.push(vec![
            epsilon,
            words(name),
            Cell::Count(counts.method(Verdict::Present)),
            Cell::Count(counts.method(Verdict::Absent)),
            Cell::Count(counts.method(Verdict::Undecided)),
            Cell::Count(counts.method(Verdict::Failed) + counts.method(Verdict::NotComputed)),
            pair(Verdict::Absent, Verdict::Present),
            pair(Verdict::Present, Verdict::Absent),
            match verdicts.simulation {
                Some(_) => Cell::Count(counts.total() - compared),
                None => Cell::Missing,
            },
            percent(decided as f64, counts.total() as f64).into(),
        ]);
    };
    let epsilons = epsilons(map);
    for (e, &epsilon) in epsilons.iter().enumerate() {
        for (method, confusion) in map.methods().iter().zip(&verdicts.confusion) {
            add(Cell::Real(epsilon), &method.name, &confusion[e]);
        }
    }
    if epsilons.len() > 1 {
        for (method, confusion) in map.methods().iter().zip(&verdicts.confusion) {
            let mut sum = Confusion::default();
            confusion.iter().for_each(|counts| sum.add(counts));
            add(Cell::Missing, &method.name, &sum);
        }
    }
    let mut notes = vec![rich(
        "Wrong presence: the method claims a cycle where the simulation finds none; wrong absence: the opposite. \
         Not compared: the simulation itself gives no verdict.",
    )];
    if epsilons.len() > 1 {
        notes.push(rich("Rows without {epsilon} are the sums over all {epsilon}."));
    }
    notes.extend(no_simulation(report));
    Table {
        name: "agreement",
        caption: rich(
            "Verdicts of each method, in cells of the map, and their agreement with the simulation.",
        ),
        columns: vec![
            column("epsilon", "{epsilon}", EPSILON_DIGITS),
            column("method", "method", Show::AsIs),
            column("present", "present", Show::AsIs),
            column("absent", "absent", Show::AsIs),
            column("undecided", "undecided", Show::AsIs),
            column("failed", "failed", Show::AsIs),
            column("wrong_presence", "wrong presence", Show::AsIs),
            column("wrong_absence", "wrong absence", Show::AsIs),
            column("not_compared", "not compared", Show::AsIs),
            column("percent_decided", "% decided", Show::Decimals(2)),
        ],
        rows,
        notes,
    }
}

/// Error of each method's boundary in c.
#[must_use]
pub fn boundary(map: &MapFile, report: &Report) -> Table {
    let boundaries = &report.boundaries;
    let axes = map.grid().axes();
    let parameters = &axes[1..axes.len() - 1];
    let mut rows = Vec::new();
    for (e, &epsilon) in epsilons(map).iter().enumerate() {
        for method in &boundaries.methods {
            let errors = &method.errors[e];
            let mut row = vec![
                Cell::Real(epsilon),
                words(&method.method),
                Cell::Count(errors.sizes.count()),
                errors.sizes.quantile(0.5).into(),
                errors.sizes.quantile(0.95).into(),
                errors.worst.as_ref().map(|worst| worst.error).into(),
                percent(errors.beyond as f64, errors.sizes.count() as f64).into(),
                Cell::Count(errors.only_exact),
                Cell::Count(errors.only_method),
            ];
            for (axis, parameter) in parameters.iter().enumerate() {
                let worst = errors.worst.as_ref().map(|worst| parameter.values[worst.column[axis + 1]]);
                row.push(worst.into());
            }
            rows.push(row);
        }
    }
    let mut columns = vec![
        column("epsilon", "{epsilon}", EPSILON_DIGITS),
        column("method", "method", Show::AsIs),
        column("columns", "columns", Show::AsIs),
        column("median_error", "median", Show::Significant(3)),
        column("percentile_95_error", "95 %", Show::Significant(3)),
        column("worst_error", "worst", Show::Significant(3)),
        column("percent_beyond", "% beyond", Show::Decimals(1)),
        column("only_exact", "none claimed", Show::AsIs),
        column("only_method", "none exists", Show::AsIs),
    ];
    for parameter in parameters {
        let heading = rich("worst ").then(Rich::symbol(&parameter.name));
        // Column names of CSV files are fixed for each law; leaking a few of them would be no harm, but the
        // laws' own names are static.
        columns.push(Column { key: worst_key(map, &parameter.name), heading, show: Show::Trimmed(4) });
    }
    let origin = if boundaries.stored { "read from the map" } else { "computed again for this report" };
    let mut notes = vec![rich(&format!(
        "Error: the damping {{c}} up to which the method claims the cycle minus the exact critical damping {{c^*}} \
         ({origin}), over the columns of the map (all parameters but {{c}} fixed) in which both are at least 0; median \
         and 95 % are of its size. Beyond: columns in which the method claims too much. None claimed, none exists: \
         columns in which only {{c^*}}, or only the method's boundary, is at least 0."
    ))];
    notes.extend(unknown(report));
    Table {
        name: "boundary",
        caption: rich("Error in {c} of the boundary of each method, against the exact critical damping."),
        columns,
        rows,
        notes,
    }
}

/// The name of a parameter's column.
fn worst_key(map: &MapFile, parameter: &str) -> &'static str {
    let law = map.grid().law().parameters().iter().map(|parameter| parameter.name);
    law.chain(["V"]).find(|name| *name == parameter).unwrap_or("parameter")
}

fn unknown(report: &Report) -> Option<Rich> {
    let unknown = &report.boundaries.unknown;
    (!unknown.is_empty()).then(|| {
        rich("Left out, because the map does not store their boundary: ")
            .then(Rich::foreign(&unknown.join(", ")))
            .then(rich("."))
    })
}

/// The order in eps of the boundary's error.
#[must_use]
pub fn order(map: &MapFile, report: &Report) -> Table {
    let rows = report.boundaries.methods.iter().map(|method| {
        let order = method.order;
        vec![
            words(&method.method),
            order.map(|order| order.order).into(),
            order.and_then(|order| order.half_width).into(),
            order.map(|order| order.smallest).into(),
            Cell::Count(order.map_or(0, |order| order.points as u64)),
        ]
    });
    let epsilons = epsilons(map).len();
    let note = match epsilons {
        1 => "The map has one {epsilon}: no order can be fitted.",
        2 => "The map has two {epsilon}: an order, but no confidence interval.",
        _ => {
            "Least squares of the logarithm of the median error on the logarithm of {epsilon}, over the columns that \
             have both boundaries at every {epsilon}; ± is half the 95 % confidence interval. Medians below the error \
             of {c^*} itself are left out; without two others there is no order."
        }
    };
    Table {
        name: "order",
        caption: rich("Order {p} of the boundary's error in {c}, which falls like {epsilon^p}."),
        columns: vec![
            column("method", "method", Show::AsIs),
            column("order", "{p}", Show::Decimals(2)),
            column("order_error", "±", Show::Decimals(2)),
            column("order_smallest", "{p} at the two smallest {epsilon}", Show::Decimals(2)),
            column("epsilons", "{epsilon} in the fit", Show::AsIs),
        ],
        rows: rows.collect(),
        notes: vec![rich(note)],
    }
}

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
            column("method", "method", Show::AsIs),
            column("cells", "cells", Show::AsIs),
            column("seconds", "seconds", Show::Significant(3)),
            column("cells_per_second", "cells per second", Show::Significant(3)),
        ],
        rows: rows.collect(),
        notes,
    }
}

/// What went wrong during the run.
#[must_use]
pub fn failures(map: &MapFile, report: &Report) -> Table {
    let mut rows = Vec::new();
    for (method, confusion) in map.methods().iter().zip(&report.verdicts.confusion) {
        for (what, verdict) in [("failed", Verdict::Failed), ("not computed", Verdict::NotComputed)] {
            let cells = confusion.iter().map(|counts| counts.method(verdict)).sum();
            rows.push(vec![words(&format!("{}: cells {what}", method.name)), Cell::Count(cells)]);
        }
    }
    let count = |name: &str| map.number(name).map(|number| number as u64);
    rows.push(vec![words("audit: cells decided again by the direct engine"), count("audit_cells").into()]);
    rows.push(vec![words("audit: verdicts contradicted"), count("audit_disagreements").into()]);
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
        columns: vec![column("what", "what", Show::AsIs), column("count", "count", Show::AsIs)],
        rows,
        notes,
    }
}

/// What the methods are.
#[must_use]
pub fn methods(map: &MapFile) -> Table {
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
            column("method", "method", Show::AsIs),
            column("long_name", "what it is", Show::AsIs),
            column("guarantee", "guarantee", Show::AsIs),
            column("equation", "equation", Show::AsIs),
        ],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

/// The axes of the map.
#[must_use]
pub fn axes(map: &MapFile) -> Table {
    let rows = map.grid().axes().iter().map(|axis| {
        let last = axis.values[axis.values.len() - 1];
        vec![
            words(&axis.name),
            words(&axis.long_name),
            Cell::Count(axis.values.len() as u64),
            Cell::Real(axis.values[0]),
            Cell::Real(last),
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
            column("axis", "axis", Show::AsIs),
            column("long_name", "what it is", Show::AsIs),
            column("nodes", "nodes", Show::AsIs),
            column("from", "from", Show::Trimmed(6)),
            column("to", "to", Show::Trimmed(6)),
            column("spacing", "spacing", Show::AsIs),
        ],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

/// Whether nodes have equal steps, up to the rounding of decimal input.
pub(super) fn is_linear(values: &[f64]) -> bool {
    let (first, last) = (values[0], values[values.len() - 1]);
    let step = (last - first) / (values.len().max(2) - 1) as f64;
    values.iter().enumerate().all(|(i, value)| (value - first - step * i as f64).abs() <= 1e-6 * step)
}

/// Whether nodes have equal ratios.
pub(super) fn is_logarithmic(values: &[f64]) -> bool {
    values[0] > 0.0 && is_linear(&values.iter().map(|value| value.ln()).collect::<Vec<_>>())
}

/// Where the map comes from.
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
        columns: vec![column("what", "what", Show::AsIs), column("value", "value", Show::AsIs)],
        rows: rows.collect(),
        notes: Vec::new(),
    }
}

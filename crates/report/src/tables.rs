//! The tables of a report.

mod boundaries;
mod law;
mod machine;
mod origin;

pub use boundaries::{boundary, order};
pub(crate) use law::friction;
pub(crate) use origin::methods;
pub(crate) use origin::undetermined_regimes;
pub use origin::{axes, cost, failures, provenance};

use super::proved;
use super::table::{Cell, Column, ColumnOf, Show, Table};
use super::view::View;
use super::{Confusion, Report, SIMULATION};
use slipmap_column::Verdict;
use slipmap_figure::text::join;
use slipmap_figure::text::{Rich, rich};
use slipmap_format::MapFile;
use slipmap_page::units::Label;

/// All tables, in the order of the report.
pub fn all(view: &View, report: &Report) -> Vec<Table> {
    let map = view.map;
    // An engineer's tables come first.
    let mut tables: Vec<Table> = machine::machine(view).into_iter().collect();
    tables.push(law::law(view));
    tables.push(volume(view, report));
    tables.extend(proved::volume(map));
    tables.push(agreement(map, report));
    tables.push(boundary(view, report));
    // One eps gives no order.
    tables.extend((map.grid().epsilons().len() > 1).then(|| order(report)));
    tables.extend([cost(map), failures(map, report), methods(map), axes(view), provenance(map)]);
    if map.grid().epsilon_axis().is_none() {
        tables.iter_mut().for_each(|table| table.drop_column("epsilon"));
    }
    tables
}

/// A column of a quantity with its unit; `key` names it in CSV files and `heading` in the other formats.
fn column_of(label: &Label, key: &str, heading: &str, show: Show) -> Column {
    let label = Label { name: rich(heading), key: key.into(), ..label.clone() };
    Column { key: label.header(), heading: label.text(), show }
}

/// A dimensionless number in the unit of a label.
fn in_unit(value: Option<f64>, label: &Label) -> Cell {
    value.map(|value| value * label.factor).into()
}

fn words(text: &str) -> Cell {
    Cell::Words(text.into())
}

/// Number of significant digits of eps.
const EPSILON_DIGITS: Show = Show::Trimmed(4);

fn percent(part: f64, whole: f64) -> Option<f64> {
    (whole > 0.0).then(|| 100.0 * part / whole)
}

pub fn volume(view: &View, report: &Report) -> Table {
    let map = view.map;
    let verdicts = &report.verdicts;
    let share = |volume: f64| percent(volume, verdicts.box_volume).into();
    let one_damping = map.grid().dampings().len() == 1;
    let mut rows = Vec::new();
    for (e, &epsilon) in map.grid().epsilons().iter().enumerate() {
        let reference = verdicts.simulation.map(|method| verdicts.volumes[method][e]);
        for (method, volumes) in map.methods().iter().zip(&verdicts.volumes) {
            let volume = volumes[e];
            let relative = reference.filter(|reference| reference.claimed > 0.0);
            // The largest error of the quotient of two uncertain volumes.
            let relative_error = relative.map(|reference| {
                let middle = volume.claimed / reference.claimed;
                let (error, error_of_reference) = (volume.error_in_c, reference.error_in_c);
                let high = (volume.claimed + error) / (reference.claimed - error_of_reference).max(0.0);
                let low = (volume.claimed - error).max(0.0) / (reference.claimed + error_of_reference);
                100.0 * (high - middle).max(middle - low)
            });
            rows.push(vec![
                Cell::Real(epsilon),
                words(method.name()),
                share(volume.claimed),
                if one_damping { Cell::Missing } else { share(volume.error_in_c) },
                share(volume.error),
                relative.and_then(|reference| percent(volume.claimed, reference.claimed)).into(),
                relative_error.filter(|_| method.name() != SIMULATION && !one_damping).into(),
                relative.and_then(|reference| percent(volume.confirmed, reference.claimed)).into(),
            ]);
        }
    }
    let c = if view.units.machine.is_some() { "damping" } else { "{c}" };
    let mut notes = vec![rich(&format!(
        "By the trapezoidal rule over the axes of more than one node except {{epsilon}}. The error is bounded twice: along \
         {c} alone, the nodes of the other axes taken as they are, by half of every step of {c} over which the verdict \
         changes; and along all axes by the boxes between neighbouring nodes whose corners do not all have the same \
         verdict, a bound that is wide where an axis has few nodes. The error of the percentage of the simulation is \
         that along {c}. What a method claims beyond the ends of the axes, as above the largest {c}, is not counted. \
         Confirmed: what the simulation finds, too."
    ))];
    if verdicts.dimensions == 0 {
        notes.push(rich(
            "No axis but that of {epsilon} has more than one node: the share is 100 % where the cycle is claimed, else 0.",
        ));
    }
    notes.extend(no_simulation(report));
    Table {
        name: "volume",
        caption: rich("Share of the box of all axes in which each method claims a stick-slip cycle: ")
            .then(extents(view))
            .then("."),
        columns: vec![
            Column::new("epsilon", "{epsilon}", EPSILON_DIGITS),
            Column::new("method", "method", Show::AsIs),
            Column::new("percent_of_box", "% of the box", Show::Significant(4)),
            Column::new("percent_of_box_error_in_c", &format!("± in {c}"), Show::Significant(2)),
            Column::new("percent_of_box_error", "± in all", Show::Significant(2)),
            Column::new("percent_of_simulation", "% of simulation", Show::Decimals(2)),
            Column::new("percent_of_simulation_error", "±", Show::Decimals(2)),
            Column::new("percent_of_simulation_confirmed", "confirmed", Show::Decimals(2)),
        ],
        rows,
        notes,
    }
}

/// "alpha from 0 to 0.9, gamma = 2" for every axis but eps.
fn extents(view: &View) -> Rich {
    let grid = view.map.grid();
    let axes = grid.axes().iter().enumerate().filter(|(i, _)| Some(*i) != grid.epsilon_axis());
    join(axes.map(|(_, axis)| view.axis(axis).extent(&axis.values, 6)))
}

fn no_simulation(report: &Report) -> Option<Rich> {
    report.verdicts.simulation.is_none().then(|| {
        rich("The simulation is not among the methods of this map, so there is nothing to compare them with.")
    })
}

pub fn agreement(map: &MapFile, report: &Report) -> Table {
    let verdicts = &report.verdicts;
    let epsilons = map.grid().epsilons();
    // Eps, the method and its verdicts; `None` for eps marks the sums over all eps.
    let mut rows: Vec<(Option<f64>, &str, Confusion)> = Vec::new();
    for (e, &epsilon) in epsilons.iter().enumerate() {
        let methods = map.methods().iter().zip(&verdicts.confusion);
        rows.extend(methods.map(|(method, confusion)| (Some(epsilon), method.name(), confusion[e])));
    }
    if epsilons.len() > 1 {
        for (method, confusion) in map.methods().iter().zip(&verdicts.confusion) {
            let mut sum = Confusion::default();
            confusion.iter().for_each(|counts| sum.add(counts));
            rows.push((None, method.name(), sum));
        }
    }
    let compared = |count: u64| Cell::from(verdicts.simulation.map(|_| count));
    // A method that claims nothing is not right either.
    let pair = |counts: &Confusion, simulation, method| match counts.claims() {
        0 => Cell::Missing,
        _ => compared(counts.pair(simulation, method)),
    };
    let not_compared = |counts: &Confusion| {
        let simulated = counts.simulation(Verdict::Present) + counts.simulation(Verdict::Absent);
        compared(counts.total() - simulated)
    };
    let decided = |counts: &Confusion| percent(counts.claims() as f64, counts.total() as f64).into();
    let cells = |counts: &Confusion, verdict| Cell::Count(counts.method(verdict));
    let failed = |counts: &Confusion| {
        Cell::Count(counts.method(Verdict::Failed) + counts.method(Verdict::NotComputed))
    };
    use Verdict::{Absent, Present, Undecided};
    let columns: [ColumnOf<(Option<f64>, &str, Confusion)>; 10] = [
        ("epsilon", "{epsilon}", EPSILON_DIGITS, &|(epsilon, ..)| (*epsilon).into()),
        ("method", "method", Show::AsIs, &|(_, method, _)| words(method)),
        ("present", "present", Show::AsIs, &|(.., counts)| cells(counts, Present)),
        ("absent", "absent", Show::AsIs, &|(.., counts)| cells(counts, Absent)),
        ("undecided", "undecided", Show::AsIs, &|(.., counts)| cells(counts, Undecided)),
        ("failed", "failed", Show::AsIs, &|(.., counts)| failed(counts)),
        ("wrong_presence", "wrong presence", Show::AsIs, &|(.., counts)| pair(counts, Absent, Present)),
        ("wrong_absence", "wrong absence", Show::AsIs, &|(.., counts)| pair(counts, Present, Absent)),
        ("not_compared", "not compared", Show::AsIs, &|(.., counts)| not_compared(counts)),
        ("percent_decided", "% decided", Show::Decimals(2), &|(.., counts)| decided(counts)),
    ];
    let mut notes = vec![rich(
        "Wrong presence: the method claims a cycle where the simulation finds none; wrong absence: the opposite. \
         Not compared: the simulation itself gives no verdict.",
    )];
    if epsilons.len() > 1 {
        notes.push(rich("Rows without {epsilon} are the sums over all {epsilon}."));
    }
    notes.extend(no_simulation(report));
    let caption = "Verdicts of each method, in cells of the map, and their agreement with the simulation.";
    Table { notes, ..Table::of("agreement", rich(caption), &rows, &columns) }
}

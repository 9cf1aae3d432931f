//! The friction law: its formula, its parameters, friction at rest and as slip begins.

use super::super::table::{Cell, Column, Show, Table};
use super::super::view::View;
use super::words;
use slipmap_figure::axis::extremes;
use slipmap_figure::text::{Rich, rich};
use slipmap_machine::Coefficients;
use slipmap_map::Grid;
use slipmap_model::friction::{Law, Table as Data};
use slipmap_page::formula;

/// Longest formula that is set in a line; longer ones are shown as they were written.
const LONGEST: usize = 100;

/// The formula of a map's law, or the words for data; in SI units of a machine.
pub(crate) fn friction(view: &View) -> Rich {
    let grid = view.map.grid();
    let set = match grid.machine() {
        Some(machine) => formula::of_machine(machine),
        None => formula::of_law(grid.law()),
    };
    match (set, grid.law().as_written()) {
        (Some(set), _) if set.plain.chars().count() <= LONGEST => Rich::formula(set),
        (_, Law::Expression(formula)) => Rich::foreign(&formula.text()),
        (_, Law::Table(table)) => of_rows(table),
        _ => rich("a function of a program, which was sampled"),
    }
}

/// "the curve through 9 rows of measured.csv, means of 300 readings".
fn of_rows(table: &Data) -> Rich {
    let rows = table.data().count();
    let origin = Rich::foreign(table.origin());
    let text = rich(&format!("the curve through {rows} rows of ")).then(origin);
    match table.source().readings {
        readings if readings > rows => text.then(Rich::foreign(&format!(", means of {readings} readings"))),
        _ => text,
    }
}

/// The least and the greatest finite value at the first and the last nodes of all axes.
fn over_corners(grid: &Grid, value: impl Fn(&[f64]) -> Option<f64>) -> (f64, f64) {
    let axes = grid.axes();
    let corners = (0..1_usize << axes.len()).map(|corner| {
        let ends = axes.iter().enumerate();
        let end = ends.map(|(i, axis)| axis.values[((corner >> i) & 1) * (axis.values.len() - 1)]);
        end.collect::<Vec<f64>>()
    });
    extremes(corners.filter_map(|at| value(&at)))
}

/// "0.4", or "from 0.3 to 0.5".
fn range((least, most): (f64, f64)) -> Rich {
    let number = |x: f64| Rich::number(x, 6);
    match most - least <= 1e-12 * most.abs() {
        true => number(least),
        false => rich("from ").then(number(least)).then(" to ").then(number(most)),
    }
}

pub(super) fn law(view: &View) -> Table {
    let grid = view.map.grid();
    let (law, machine) = (grid.law(), grid.machine());
    let mut rows: Vec<[Cell; 4]> = Vec::new();
    let mut row = |what: &str, symbol: Rich, value: Rich, unit: &str| {
        rows.push([words(what), Cell::Rich(symbol), Cell::Rich(value), words(unit)]);
    };
    let force = match machine {
        Some(machine) if !machine.normal_force_is_known => machine.unit("normal_force"),
        _ => "1",
    };
    let one = |unit: &str| if unit.is_empty() { "1".to_owned() } else { unit.to_owned() };
    row("friction in slip, at slip speed u", Rich::default(), friction(view), force);
    match machine {
        None => {
            for parameter in law.parameters() {
                let axis = grid.axes().iter().find(|axis| axis.name == parameter.name);
                let Some(axis) = axis.filter(|axis| !axis.values.is_empty()) else { continue };
                let ends = (axis.values[0], axis.values[axis.values.len() - 1]);
                row(parameter.long_name, Rich::symbol(parameter.name), range(ends), "1");
            }
        }
        Some(machine) => {
            let names: Vec<&str> = match law.as_written() {
                Law::Expression(formula) => formula.parameters().iter().map(|it| it.name).collect(),
                Law::Table(_) => Vec::new(),
                _ => Coefficients::names(law).collect(),
            };
            for (name, value) in machine.quantities().into_iter().filter(|(name, _)| names.contains(name)) {
                let axis = grid.axes().iter().find(|axis| axis.name == name);
                let (ends, unit) = match axis {
                    Some(axis) => {
                        let label = view.axis(axis);
                        let shown = axis.values.iter().map(|value| value * label.factor);
                        (extremes(shown), label.unit.into_owned())
                    }
                    None => ((value, value), machine.unit(name).to_owned()),
                };
                let (what, symbol) = (machine.words(name), Rich::symbol(formula::symbol(name)));
                row(&what, symbol, range(ends), &one(&unit));
            }
        }
    }
    let rest = |at: &[f64]| machine.map_or(Some(1.0), |_| Some(grid.machine_at(at)?.friction.at_rest()));
    let onset = |at: &[f64]| Some(rest(at)? * (1.0 - grid.column_of(at).ok()?.curve.drop()));
    let name = match machine {
        None => "phi",
        Some(_) if force == "1" => "mu",
        Some(_) => "F",
    };
    let at = |speed: &'static str| Rich::symbol(name).then(speed);
    row("friction at rest", at("(0)"), range(over_corners(grid, rest)), force);
    row("friction as slip begins", at("(0+)"), range(over_corners(grid, onset)), force);
    let drop = over_corners(grid, |at| Some(rest(at)? - onset(at)?));
    row("drop, the difference of these", Rich::default(), range(drop), force);
    let mut notes = Vec::new();
    if machine.is_none() {
        notes.push(rich("Friction in units of that at rest, slip speed in units of friction at rest over the root of stiffness times mass."));
    }
    if law.is_read_as_small() {
        notes.push(rich("By tests to first order in {epsilon} the law is read as 1 + {epsilon} {F}({u})."));
    }
    Table {
        name: "law",
        caption: rich("The friction law, ").then(Rich::foreign(law.name())).then("."),
        columns: vec![
            Column::new("what", "what", Show::AsIs),
            Column::new("symbol", "symbol", Show::AsIs),
            Column::new("value", "value", Show::AsIs),
            Column::new("unit", "unit", Show::AsIs),
        ],
        rows: rows.into_iter().map(Vec::from).collect(),
        notes,
    }
}

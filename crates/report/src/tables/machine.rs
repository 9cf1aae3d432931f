//! A machine in SI units, if the map is about one.

use super::super::table::{Cell, Column, Show, Table};
use super::super::view::View;
use super::words;
use slipmap_figure::text::{Rich, rich};
use slipmap_machine::behaviour::{MachineBehaviour, behaviour};
use slipmap_machine::{Dimension, Model};
use slipmap_map::AxisRole;
use slipmap_model::point::Point;

/// Largest number of belt speeds shown.
const ROWS: usize = 12;
/// Bound on the error of the scaled grazing margin.
const TOLERANCE: f64 = 1e-9;

/// The behaviour of a map's machine at its belt speeds and its middle damping; `None` for a map in
/// dimensionless terms.
pub(super) fn machine(view: &View) -> Option<Table> {
    let map = view.map;
    let model = view.model()?;
    let units = model.si;
    let [length, velocity, damping] =
        [Dimension::Length, Dimension::Velocity, Dimension::Damping].map(|of| units.unit(of));
    let speed_axis = map.grid().axes().iter().find(|axis| axis.role == AxisRole::BeltSpeed)?;
    let (speeds, speed_name) = (&speed_axis.values, view.axis(speed_axis).name.plain());
    let shown = speeds.len().min(ROWS);
    let rows = (0..shown).map(|i| {
        let belt_speed = speeds[if shown > 1 { i * (speeds.len() - 1) / (shown - 1) } else { 0 }];
        let here = Model {
            point: Point { belt_speed: belt_speed / units.velocity, ..model.point },
            ..model.clone()
        };
        let does: MachineBehaviour = behaviour(&here, TOLERANCE);
        let [slip, stick] = does.slip_and_stick_time.map_or([None; 2], |times| times.map(Some));
        vec![
            Cell::Real(belt_speed),
            does.critical_damping.into(),
            does.critical_damping_error.into(),
            does.critical_damping_ratio.into(),
            words(&does.regime.name().replace('_', " ")),
            slip.into(),
            stick.into(),
            does.amplitude.into(),
        ]
    });
    let rows: Vec<_> = rows.collect();
    let critical = behaviour(&model, TOLERANCE).critical_belt_speed.value();
    let quantity = |name: &str, value: f64, unit: &str| {
        rich(name).then(Rich::number(value, 4)).then(rich(&format!(" {unit}")))
    };
    let at = model.point.damping * units.damping;
    let mut notes = vec![
        rich("Units of the map: ")
            .then(quantity("time ", units.time, "s, "))
            .then(quantity("length ", units.length, &format!("{}, ", length)))
            .then(quantity("velocity ", units.velocity, &format!("{}, ", velocity)))
            .then(quantity("damping ", units.damping, &format!("{}.", damping))),
    ];
    if let Some(speed) = critical {
        let name = format!("Critical {speed_name} at this damping: ");
        notes.push(quantity(&name, speed, &format!("{velocity}.")));
    }
    if shown < speeds.len() {
        notes.push(rich(&format!("Rows: {shown} of the {} nodes of {speed_name}.", speeds.len())));
    }
    let held = view.model_words().map_or(rich(""), |held| rich(", ").then(held));
    Some(Table {
        name: "machine",
        caption: quantity("What the machine does at damping ", at, damping).then(held).then(rich(
            ", in SI units: above the critical damping a mass that leaves the belt does not come back to it.",
        )),
        columns: vec![
            quantity_column("belt_speed", velocity, Show::Trimmed(4)),
            quantity_column("critical_damping", damping, Show::Significant(4)),
            quantity_column("critical_damping_error", damping, Show::Significant(2)),
            Column::new("critical_damping_ratio", "critical damping ratio", Show::Significant(3)),
            Column::new("regime", "regime", Show::AsIs),
            quantity_column("slip_time", "s", Show::Significant(4)),
            quantity_column("stick_time", "s", Show::Significant(4)),
            quantity_column("amplitude", length, Show::Significant(4)),
        ],
        rows,
        notes,
    })
}

/// A column with its unit in heading and key.
fn quantity_column(key: &str, unit: &str, show: Show) -> Column {
    Column::new(&format!("{key} [{unit}]"), &format!("{}, {unit}", key.replace('_', " ")), show)
}

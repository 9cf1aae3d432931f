//! A machine in SI units, if the map is about one.

use super::super::si;
use super::super::table::{Cell, Show, Table};
use super::super::text::{Rich, rich};
use super::{column, words};
use crate::machine::{Behaviour, Machine, behaviour};
use crate::map::AxisRole;
use crate::store::MapFile;

/// Belt speeds shown at most.
const ROWS: usize = 12;
/// Bound on the error of the scaled grazing margin.
const TOLERANCE: f64 = 1e-9;

/// What the machine of a map does at its belt speeds; `None` for a map in dimensionless terms.
pub(super) fn machine(map: &MapFile) -> Option<Table> {
    let machine = si::machine(map)?;
    let (units, motion) = (machine.units(), machine.motion);
    let speeds = &map.grid().axes().iter().find(|axis| axis.role == AxisRole::BeltSpeed)?.values;
    let shown = speeds.len().min(ROWS);
    let law = map.grid().law();
    let rows = (0..shown).filter_map(|i| {
        let speed = speeds[if shown > 1 { i * (speeds.len() - 1) / (shown - 1) } else { 0 }];
        let here = Machine { belt_speed: speed * units.velocity, ..machine };
        let does: Behaviour = behaviour(&here, law, TOLERANCE)?;
        let [slip, stick] = does.slip_and_stick_time.map_or([None; 2], |times| times.map(Some));
        Some(vec![
            Cell::Real(here.belt_speed),
            does.critical_damping.into(),
            does.critical_damping_ratio.into(),
            words(&does.regime.name().replace('_', " ")),
            slip.into(),
            stick.into(),
            does.amplitude.into(),
        ])
    });
    let rows: Vec<_> = rows.collect();
    let critical = behaviour(&machine, law, TOLERANCE).and_then(|does| does.critical_belt_speed);
    let quantity = |name: &str, value: f64, unit: &str| {
        rich(name).then(Rich::number(value, 4)).then(rich(&format!(" {unit}")))
    };
    let mut notes = vec![
        quantity(
            "Damping ",
            machine.damping,
            &format!("{} where not stated otherwise; units of the map: ", motion.damping()),
        )
        .then(quantity("time ", units.time, "s, "))
        .then(quantity("length ", units.length, &format!("{}, ", motion.length())))
        .then(quantity("velocity ", units.velocity, &format!("{}, ", motion.velocity())))
        .then(quantity("damping ", units.damping, &format!("{}.", motion.damping()))),
    ];
    if let Some(speed) = critical {
        notes.push(quantity(
            "Critical belt speed at that damping: ",
            speed,
            &format!("{}.", motion.velocity()),
        ));
    }
    Some(Table {
        name: "machine",
        caption: rich(
            "What the machine does, in SI units: above the critical damping a mass that leaves the belt does not come \
             back to it.",
        ),
        columns: vec![
            column("belt_speed", &format!("belt speed, {}", motion.velocity()), Show::Trimmed(4)),
            column(
                "critical_damping",
                &format!("critical damping, {}", motion.damping()),
                Show::Significant(4),
            ),
            column("critical_damping_ratio", "critical damping ratio", Show::Significant(3)),
            column("regime", "regime", Show::AsIs),
            column("slip_time", "slip time, s", Show::Significant(4)),
            column("stick_time", "stick time, s", Show::Significant(4)),
            column("amplitude", &format!("amplitude, {}", motion.length()), Show::Significant(4)),
        ],
        rows,
        notes,
    })
}

//! The initial contents of the page: default, a configuration, or a map.

use serde_json::json;

use super::place::law_json;
use slipmap_map::machine::Machine;
use slipmap_map::map::{AxisRole, Grid};
use slipmap_simulate::critical::{critical_damping, known_or_nan};

/// Factor by which the damping axis extends beyond the larger of two dampings.
const ROOM: f64 = 1.2;
/// Accuracy of the critical damping, for the end of an axis.
const TOLERANCE: f64 = 1e-6;

/// The argument of the command.
#[derive(Debug, Default)]
pub struct Start {
    grid: Option<Grid>,
    title: String,
}

impl Start {
    /// The plane of a configuration or a map.
    pub fn of(grid: &Grid, title: &str) -> Self {
        Self { grid: Some(grid.clone()), title: title.into() }
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let Some(grid) = &self.grid else { return serde_json::Value::Null };
        let machine = grid.machine();
        let axis = |axis: &slipmap_map::map::Axis| {
            json!({
                "name": axis.name,
                "from": axis.values[0],
                "to": axis.values[axis.values.len() - 1],
                "value": axis.values[axis.middle()],
                "nodes": axis.values.len(),
                "log": axis.is_logarithmic(),
            })
        };
        let single =
            |role: AxisRole| grid.axes().iter().all(|axis| axis.role != role || axis.values.len() == 1);
        // A machine with one belt speed and one damping is a working point.
        let pinned = machine.is_some() && [AxisRole::BeltSpeed, AxisRole::Damping].into_iter().all(single);
        json!({
            "title": self.title,
            "pinned": pinned,
            "most_damping": machine.and_then(most_damping).map(rounded),
            "motion": machine.map(|machine| machine.motion.name()),
            "at": machine.map(super::quantities::at_json),
            "law": match machine {
                Some(machine) => super::quantities::law_json(machine),
                None => law_json(grid.law()),
            },
            "axes": grid.axes().iter().map(axis).collect::<Vec<_>>(),
        })
    }
}

/// The upper end of a machine's damping axis: `ROOM` times the larger of its own and the critical damping.
fn most_damping(machine: &Machine) -> Option<f64> {
    let model = machine.model()?;
    let critical = known_or_nan(critical_damping(&model.column(), TOLERANCE));
    let most = ROOM * model.point.damping.max(critical) * machine.damping_unit();
    (most > 0.0).then_some(most)
}

/// A number to twelve significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

//! The initial contents of the page: default, a configuration, or a map.

use serde_json::json;

use super::machine;
use super::place::law_json;
use slipmap_config::Job;
use slipmap_format::{MapFile, Value};
use slipmap_map::machine::{MOTION_ATTRIBUTE, Machine, Motion, SI_ATTRIBUTE};
use slipmap_map::map::{AxisRole, Grid};
use slipmap_model::friction::Law;
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
    map: Option<MapFile>,
    machine: Option<Machine>,
}

impl Start {
    /// The plane of a configuration.
    pub fn of_job(job: &Job) -> Self {
        Self {
            grid: Some(job.plan.grid().clone()),
            title: job.title.clone(),
            map: None,
            machine: job.machine.clone(),
        }
    }

    /// The plane of a map, whose cells stay on disk until they are shown.
    pub fn of_map(map: MapFile) -> Self {
        let title = map.text("title").unwrap_or_default().into();
        let machine = match map.attributes().get(SI_ATTRIBUTE) {
            Some(Value::Reals(numbers)) => numbers.as_slice().try_into().ok(),
            _ => None,
        };
        let named = |motion: &Motion| map.text(MOTION_ATTRIBUTE) == Some(motion.name());
        let motion = Motion::ALL.into_iter().find(named);
        let law = map.grid().law().as_written().clone();
        // Maps keep the machine's numbers where its friction is given by coefficients.
        let law = (!matches!(law, Law::Expression(_) | Law::Table(_))).then_some(law);
        let numbers = motion.zip(machine).zip(law);
        let machine = numbers.map(|((motion, numbers), law)| Machine::from_array(motion, law, numbers));
        Self { grid: Some(map.grid().clone()), title, map: Some(map), machine }
    }

    /// The map, if one was given.
    pub(super) fn map(&self) -> Option<&MapFile> {
        self.map.as_ref()
    }

    pub(super) fn to_json(&self) -> serde_json::Value {
        let Some(grid) = &self.grid else { return serde_json::Value::Null };
        let units = self.machine.as_ref().map(Machine::units);
        let axis = |axis: &slipmap_map::map::Axis| {
            let (name, factor) = match (axis.role, &units) {
                (AxisRole::BeltSpeed, Some(units)) => (machine::BELT_SPEED, units.velocity),
                (AxisRole::Damping, Some(units)) => (machine::DAMPING, units.damping),
                _ => (axis.name.as_str(), 1.0),
            };
            // Digits beyond those of the conversion are noise.
            let shown = |value: f64| if factor == 1.0 { value } else { rounded(value * factor) };
            json!({
                "name": name,
                "from": shown(axis.values[0]),
                "to": shown(axis.values[axis.values.len() - 1]),
                "value": shown(axis.values[axis.middle()]),
                "nodes": axis.values.len(),
                "log": axis.is_logarithmic(),
            })
        };
        let single =
            |role: AxisRole| grid.axes().iter().all(|axis| axis.role != role || axis.values.len() == 1);
        // A machine with one belt speed and one damping is a working point.
        let pinned =
            self.machine.is_some() && [AxisRole::BeltSpeed, AxisRole::Damping].into_iter().all(single);
        json!({
            "title": self.title,
            "pinned": pinned,
            "most_damping": self.machine.as_ref().and_then(most_damping).map(rounded),
            "motion": self.machine.as_ref().map(|machine| machine.motion.name()),
            "at": self.machine.as_ref().map(machine::at_json),
            "variables": self.map.as_ref().map(|map| map.variables().collect::<Vec<_>>()),
            "law": match &self.machine {
                Some(machine) => law_json(&machine::law_of(&machine.friction)),
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
    let most = ROOM * machine.damping.max(critical * model.si.units.damping);
    (most > 0.0).then_some(most)
}

/// A number to twelve significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

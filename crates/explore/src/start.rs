//! The initial contents of the page: default, a configuration, or a map.

use serde_json::{Map, Value, json};

use super::law::{json as json_of, law_json};
use slipmap_column::critical::{critical_damping, known_or_nan};
use slipmap_config::LawText;
use slipmap_machine::risk::{Spread, Uncertain};
use slipmap_machine::{DAMPING, Machine};
use slipmap_map::{AxisRole, Grid, Shown};

/// Factor by which the damping axis extends beyond the larger of two dampings.
const ROOM: f64 = 1.2;
/// Accuracy of the critical damping, for the end of an axis.
const TOLERANCE: f64 = 1e-6;

/// The argument of the command.
#[derive(Debug, Default)]
pub struct Start {
    grid: Option<Grid>,
    /// The units of a machine's quantities, where they are not those of SI.
    units: Vec<(String, Shown)>,
    title: Option<String>,
    uncertain: Vec<Uncertain>,
}

impl Start {
    /// The plane of a configuration or a map; `held` are the units of what is no axis of it.
    pub fn of(
        grid: &Grid,
        title: &str,
        held: &[(&'static str, Option<Shown>)],
        uncertain: &[Uncertain],
    ) -> Self {
        let axes = grid.axes().iter().map(|axis| (axis.name.as_str(), &axis.shown));
        let all = axes.chain(held.iter().map(|(name, shown)| (*name, shown)));
        let units = all.filter_map(|(name, shown)| Some((name.to_owned(), shown.clone()?))).collect();
        Self { grid: Some(grid.clone()), units, title: Some(title.to_owned()), uncertain: uncertain.to_vec() }
    }

    pub(super) fn to_json(&self) -> Value {
        let Some(grid) = &self.grid else { return Value::Null };
        let machine = grid.machine();
        let size = |name: &str| {
            self.units.iter().find(|(known, _)| known == name).map_or(1.0, |(_, shown)| shown.size)
        };
        // Conversion to SI has left round-off in the last digit.
        let shown = |name: &str, value: f64| match size(name) {
            1.0 => value,
            size => rounded(value / size),
        };
        let axis = |axis: &slipmap_map::Axis| {
            let node = |node: usize| shown(&axis.name, axis.values[node]);
            json!({
                "name": axis.name,
                "from": node(0),
                "to": node(axis.values.len() - 1),
                "value": node(axis.middle()),
                "nodes": axis.values.len(),
                "log": axis.is_logarithmic(),
            })
        };
        let single =
            |role: AxisRole| grid.axes().iter().all(|axis| axis.role != role || axis.values.len() == 1);
        // A machine with one belt speed and one damping is a working point.
        let pinned = machine.is_some() && [AxisRole::BeltSpeed, AxisRole::Damping].into_iter().all(single);
        let units: Map<String, Value> =
            self.units.iter().map(|(name, of)| (name.clone(), json!([of.unit, of.size]))).collect();
        let quantities = machine.into_iter().flat_map(Machine::quantities);
        let value = |name: &str| {
            let of_name =
                machine.map(Machine::quantities).into_iter().flatten().find(|(known, _)| *known == name);
            of_name.map_or(f64::NAN, |(_, value)| value)
        };
        let spread = self.uncertain.iter().filter_map(|(name, spread)| {
            let numbers = match spread.at(value(name)) {
                Spread::Normal { sd } | Spread::Relative { sd } => vec![sd],
                Spread::Uniform { min, max } => vec![min, max],
                // The fit of the law has them.
                Spread::Joint { .. } => return None,
            };
            Some(((*name).to_owned(), json!(numbers)))
        });
        let spread: Map<String, Value> = spread.collect();
        let at: Map<String, Value> =
            quantities.map(|(name, value)| (name.to_owned(), shown(name, value).into())).collect();
        json!({
            "pinned": pinned,
            "most_damping": machine.and_then(most_damping).map(|most| rounded(most / size(DAMPING))),
            "motion": machine.map(|machine| machine.motion.name()),
            "title": self.title,
            "units": units,
            "spread": spread,
            "at": at,
            "law": match machine {
                Some(machine) => json_of(LawText::of_machine(machine, &self.uncertain)),
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

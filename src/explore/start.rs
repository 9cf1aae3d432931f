//! The initial contents of the page: default, a configuration, or a map.

use serde_json::json;

use super::si::MachineText;
use crate::config::Job;
use crate::machine::{MOTION_ATTRIBUTE, Motion, SI_ATTRIBUTE};
use crate::map::Grid;
use crate::store::{MapFile, Value};

/// The argument of the command.
#[derive(Debug, Default)]
pub struct Start {
    grid: Option<Grid>,
    title: String,
    map: Option<MapFile>,
    machine: Option<MachineText>,
}

impl Start {
    /// The plane of a configuration.
    #[must_use]
    pub fn of_job(job: &Job) -> Self {
        Self {
            grid: Some(job.plan.grid().clone()),
            title: job.title.clone(),
            map: None,
            machine: job.machine.as_ref().and_then(MachineText::of),
        }
    }

    /// The plane of a map, whose cells stay on disk until they are shown.
    #[must_use]
    pub fn of_map(map: MapFile) -> Self {
        let title = map.text("title").unwrap_or_default().into();
        let machine = match map.attributes().get(SI_ATTRIBUTE) {
            Some(Value::Reals(numbers)) => numbers.as_slice().try_into().ok(),
            _ => None,
        };
        let named = |motion: &Motion| map.text(MOTION_ATTRIBUTE) == Some(motion.name());
        let motion = Motion::ALL.into_iter().find(named);
        let machine = motion.zip(machine).map(|(motion, numbers)| MachineText::of_array(motion, numbers));
        Self { grid: Some(map.grid().clone()), title, map: Some(map), machine }
    }

    /// The map, if one was given.
    pub(super) fn map(&self) -> Option<&MapFile> {
        self.map.as_ref()
    }

    /// The contents as JSON.
    pub(super) fn to_json(&self) -> serde_json::Value {
        let Some(grid) = &self.grid else { return serde_json::Value::Null };
        let axis = |axis: &crate::map::Axis| {
            json!({
                "name": axis.name,
                "from": axis.values[0],
                "to": axis.values[axis.values.len() - 1],
                "value": axis.values[axis.middle()],
                "nodes": axis.values.len(),
                "log": axis.is_logarithmic(),
            })
        };
        json!({
            "title": self.title,
            "machine": self.machine,
            "variables": self.map.as_ref().map(|map| map.variables().collect::<Vec<_>>()),
            "law": super::place::law_json(grid.law()),
            "axes": grid.axes().iter().map(axis).collect::<Vec<_>>(),
        })
    }
}

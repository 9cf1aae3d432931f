//! With what the page begins: nothing, a configuration, or a map.

use serde_json::{Value, json};

use super::si::MachineText;
use crate::config::Job;
use crate::machine::Machine;
use crate::map::Grid;
use crate::report::View;
use crate::store::MapFile;

/// What the command was given.
#[derive(Debug, Default)]
pub struct Start {
    grid: Option<Grid>,
    title: String,
    map: Option<MapFile>,
    machine: Option<Machine>,
}

impl Start {
    /// The plane of a configuration.
    #[must_use]
    pub fn of_job(job: &Job) -> Self {
        Self {
            grid: Some(job.plan.grid().clone()),
            title: job.title.clone(),
            map: None,
            machine: job.machine,
        }
    }

    /// The plane of a map, whose cells stay on disk until they are shown.
    #[must_use]
    pub fn of_map(map: MapFile) -> Self {
        let title = map.text("title").unwrap_or_default().into();
        let machine = View::new(&map).units.machine().copied();
        Self { grid: Some(map.grid().clone()), title, map: Some(map), machine }
    }

    /// The map, if one was given.
    pub(super) fn map(&self) -> Option<&MapFile> {
        self.map.as_ref()
    }

    /// As the page reads it.
    pub(super) fn to_json(&self) -> Value {
        let Some(grid) = &self.grid else { return Value::Null };
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
            "machine": self.machine.as_ref().map(MachineText::of),
            "variables": self.map.as_ref().map(|map| map.variables().collect::<Vec<_>>()),
            "law": super::place::law_json(grid.law()),
            "axes": grid.axes().iter().map(axis).collect::<Vec<_>>(),
        })
    }
}

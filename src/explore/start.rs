//! With what the page begins: nothing, a configuration, or a map.

use serde_json::{Value, json};

use crate::config::Job;
use crate::map::Grid;

/// What the command was given.
#[derive(Clone, Debug, Default)]
pub struct Start {
    grid: Option<Grid>,
    title: String,
}

impl Start {
    /// The plane of a configuration.
    #[must_use]
    pub fn of_job(job: &Job) -> Self {
        Self { grid: Some(job.plan.grid().clone()), title: job.title.clone() }
    }

    /// The plane of a map.
    #[must_use]
    pub fn of_grid(grid: &Grid, title: &str) -> Self {
        Self { grid: Some(grid.clone()), title: title.into() }
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
            "law": super::place::law_json(grid.law()),
            "axes": grid.axes().iter().map(axis).collect::<Vec<_>>(),
        })
    }
}

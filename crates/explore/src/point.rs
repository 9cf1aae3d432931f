//! One point: the answer of every method, everything that `slipmap probe` prints, and figures.

use std::sync::atomic::{AtomicBool, Ordering};

use serde::Deserialize;
use serde_json::{Value, json};

use super::figures;
use super::place::Place;
use super::refusal::Refusal;
use slipmap_column::{DEFAULT_TOLERANCE, Method};
use slipmap_config::MachineJob;
use slipmap_machine::assessment::{StandardErrors, sensitivities};
use slipmap_machine::behaviour::behaviour;
use slipmap_machine::probe::{Answer, MachineResult, Probe, regime_words};

#[derive(Clone, Debug, Deserialize)]
pub(super) struct PointRequest {
    #[serde(flatten)]
    place: Place,
    #[serde(default)]
    figure: String,
    /// Start of the orbit of the portrait; by default the exit point.
    #[serde(default)]
    start: Option<[f64; 2]>,
}

fn to_json(value: &impl serde::Serialize) -> Result<Value, Refusal> {
    serde_json::to_value(value).map_err(|error| Refusal::broken(error.to_string()))
}

/// Refuses to go on where nobody waits any more.
fn awaited(stop: &AtomicBool) -> Result<(), Refusal> {
    match stop.load(Ordering::Relaxed) {
        true => Err(Refusal::stopped()),
        false => Ok(()),
    }
}

impl PointRequest {
    /// The answers of the default methods, for a moving pointer.
    pub(super) fn glance(&self, stop: &AtomicBool) -> Result<Value, Refusal> {
        let (law, point) = self.place.point()?;
        // Between two methods the work can stop.
        let methods = Method::usual().take_while(|_| awaited(stop).is_ok());
        let answer = Answer::of(&law, &point, DEFAULT_TOLERANCE, methods);
        awaited(stop)?;
        let methods =
            answer.methods.iter().map(|of_method| (of_method.method.name(), of_method.verdict.name()));
        Ok(json!({ "words": regime_words(answer.regime), "methods": methods.collect::<Vec<_>>() }))
    }

    /// The output of `slipmap probe --json`; for a machine also the sensitivities of its page.
    pub(super) fn probe(&self, stop: &AtomicBool) -> Result<Value, Refusal> {
        let (law, point) = self.place.point()?;
        let methods = Method::all().take_while(|_| awaited(stop).is_ok());
        let (answer, direct) = Answer::of_both_engines(&law, &point, DEFAULT_TOLERANCE, methods);
        awaited(stop)?;
        let mut whole = Probe::new(&answer, &direct);
        if let Some(MachineJob { machine, uncertain, .. }) = self.place.job()? {
            awaited(stop)?;
            let behaviour = machine.model().map(|model| behaviour(&model, DEFAULT_TOLERANCE));
            awaited(stop)?;
            let errors = StandardErrors::of_dampings(&machine, &uncertain);
            let result = |behaviour| MachineResult::new(&machine, &behaviour, errors.as_ref());
            whole.machine = behaviour.map(result);
            awaited(stop)?;
            let mut answer = to_json(&whole)?;
            answer["machine"]["sensitivities"] = to_json(&sensitivities(&machine))?;
            return Ok(answer);
        }
        to_json(&whole)
    }

    /// A figure as SVG, with the map from its coordinates to numbers.
    pub(super) fn figure(&self, stop: &AtomicBool) -> Result<Value, Refusal> {
        let (law, point) = self.place.point()?;
        let start = self.start.filter(|start| start.iter().all(|x| x.is_finite()));
        let units = self.place.units()?;
        match self.figure.as_str() {
            "orbit" => Ok(figures::orbit(&law, &point, &units, start)),
            "friction" => Ok(figures::friction(&law, &point, &units)),
            "backbone" => figures::backbone(&law, &point, &units, stop),
            other => Err(Refusal::malformed(format!("there is no figure `{other}`"))),
        }
    }
}

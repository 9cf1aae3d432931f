//! The dimensionless point of a machine, and the units that convert it to SI.

use serde::Deserialize;
use serde_json::{Value, json};

use super::place::{LawText, at_json};
use super::refusal::Refusal;
use super::si::MachineText;
use crate::config::point_of;
use crate::friction::Law;
use crate::machine::Dimension;
use crate::map::Grid;

/// The request for the dimensionless point of a machine.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct MachineRequest {
    law: LawText,
    machine: MachineText,
}

impl MachineRequest {
    /// The values of the law's axes at the machine's working point, and the units that convert them to SI.
    pub(super) fn point(&self) -> Result<Value, Refusal> {
        let law = self.law.law()?;
        let machine = self.machine.machine(&law)?;
        let point = machine.model().ok_or_else(|| no_machine(&law))?.point;
        let values: Vec<f64> = Grid::coordinates(&law, &point).into_iter().map(|(_, value)| value).collect();
        // Units that are far too large or small give numbers that are illegal for every law.
        point_of(&law, &values)?;
        let units = machine.units();
        let axis = |words: &str, dimension: Dimension| json!({ "words": words, "unit": machine.motion.unit(dimension), "factor": units.factor(dimension) });
        let unit = |dimension: Dimension| machine.motion.unit(dimension);
        Ok(json!({
            "at": at_json(&law, &point),
            "axes": { "V": axis("belt speed", Dimension::Velocity), "c": axis("damping", Dimension::Damping) },
            "units": {
                "mass": unit(Dimension::Mass),
                "stiffness": unit(Dimension::Stiffness),
                "normal_force": unit(Dimension::Force),
                "stribeck_velocity": unit(Dimension::Velocity),
            },
        }))
    }
}

fn no_machine(law: &Law) -> Refusal {
    let problem = format!("the law `{}` has no coefficients of friction", law.name());
    Refusal::bad_input(problem, "use stribeck, exponential or lorentzian")
}

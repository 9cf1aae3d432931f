//! A machine in SI units: its quantities in place of a law's parameters.

use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use super::place::{LawText, at_json};
use super::refusal::Refusal;
use crate::config::point_of;
use crate::friction::Law;
use crate::machine::{Dimension, Machine, Motion};
use crate::map::Grid;
use crate::point::Point;

/// A machine as a page says it, by the keys of `[machine]`.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(super) struct MachineText {
    motion: String,
    mass: f64,
    stiffness: f64,
    damping: f64,
    normal_force: f64,
    static_friction: f64,
    kinetic_friction: f64,
    stribeck_velocity: f64,
    strengthening: f64,
    belt_speed: f64,
}

/// What the page asks: the dimensionless point of a machine.
#[derive(Clone, Debug, Deserialize)]
pub(super) struct MachineRequest {
    law: LawText,
    machine: MachineText,
}

impl MachineText {
    pub(super) fn of(machine: &Machine) -> Self {
        Self {
            motion: machine.motion.name().into(),
            mass: machine.mass,
            stiffness: machine.stiffness,
            damping: machine.damping,
            normal_force: machine.normal_force,
            static_friction: machine.static_friction,
            kinetic_friction: machine.kinetic_friction,
            stribeck_velocity: machine.stribeck_velocity,
            strengthening: machine.strengthening,
            belt_speed: machine.belt_speed,
        }
    }

    /// The machine, each quantity legal.
    fn machine(&self) -> Result<Machine, Refusal> {
        let motion = Motion::ALL.into_iter().find(|motion| motion.name() == self.motion);
        let unknown = || Refusal::malformed(format!("there is no motion `{}`", self.motion));
        let positive = [
            ("mass", self.mass),
            ("stiffness", self.stiffness),
            ("normal_force", self.normal_force),
            ("static_friction", self.static_friction),
            ("stribeck_velocity", self.stribeck_velocity),
            ("belt_speed", self.belt_speed),
        ];
        let bad = |name: &str, value: f64, wanted: &str| {
            Refusal::bad_input(format!("{name} is {value}; it must be {wanted}"), "choose another value")
        };
        if let Some((name, value)) =
            positive.into_iter().find(|(_, value)| !(*value > 0.0 && value.is_finite()))
        {
            return Err(bad(name, value, "greater than 0"));
        }
        let others = [("damping", self.damping), ("strengthening", self.strengthening)];
        if let Some((name, value)) =
            others.into_iter().find(|(_, value)| !(*value >= 0.0 && value.is_finite()))
        {
            return Err(bad(name, value, "at least 0"));
        }
        if !(0.0..=self.static_friction).contains(&self.kinetic_friction) {
            return Err(bad("kinetic_friction", self.kinetic_friction, "from 0 to static_friction"));
        }
        Ok(Machine {
            motion: motion.ok_or_else(unknown)?,
            mass: self.mass,
            stiffness: self.stiffness,
            damping: self.damping,
            normal_force: self.normal_force,
            static_friction: self.static_friction,
            kinetic_friction: self.kinetic_friction,
            stribeck_velocity: self.stribeck_velocity,
            strengthening: self.strengthening,
            belt_speed: self.belt_speed,
        })
    }

    /// The machine at a dimensionless point, with the belt speed and the damping of the point.
    pub(super) fn at(&self, point: &Point) -> Result<Machine, Refusal> {
        let machine = self.machine()?;
        let units = machine.units();
        let damping = point.epsilon * point.damping * units.damping;
        Ok(Machine { belt_speed: point.belt_speed * units.velocity, damping, ..machine })
    }
}

impl MachineRequest {
    /// The values of the law's axes at the machine's working point, and what leads from them to SI.
    pub(super) fn point(&self) -> Result<Value, Refusal> {
        let law = self.law.law()?;
        let machine = self.machine.machine()?;
        let point = machine.point(&law).ok_or_else(|| no_machine(&law))?;
        let values: Vec<f64> = Grid::coordinates(&law, &point).into_iter().map(|(_, value)| value).collect();
        // Units that are far too large or small make numbers that no law can have.
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

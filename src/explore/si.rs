//! A machine in SI units: its quantities in place of a law's parameters.

use serde::{Deserialize, Serialize};

use super::refusal::Refusal;
use crate::friction::Law;
use crate::machine::{Machine, Motion};
use crate::point::Point;

/// A machine as the page sends it, by the keys of `[machine]`.
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

impl MachineText {
    /// The request's form of a machine; `None` if its friction is not given by coefficients.
    pub(super) fn of(machine: &Machine) -> Option<Self> {
        Some(Self::of_array(machine.motion, machine.to_array()?))
    }

    /// As [`MachineText::of`], from the numbers of a machine stored in a map, [`Machine::to_array`].
    pub(super) fn of_array(motion: Motion, numbers: [f64; 9]) -> Self {
        let [mass, stiffness, damping, normal_force, static_friction, kinetic_friction, rest @ ..] = numbers;
        let [stribeck_velocity, strengthening, belt_speed] = rest;
        Self {
            motion: motion.name().into(),
            mass,
            stiffness,
            damping,
            normal_force,
            static_friction,
            kinetic_friction,
            stribeck_velocity,
            strengthening,
            belt_speed,
        }
    }

    /// The machine under a law with coefficients, each quantity legal.
    pub(super) fn machine(&self, law: &Law) -> Result<Machine, Refusal> {
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
        let numbers = [
            self.mass,
            self.stiffness,
            self.damping,
            self.normal_force,
            self.static_friction,
            self.kinetic_friction,
            self.stribeck_velocity,
            self.strengthening,
            self.belt_speed,
        ];
        Ok(Machine::from_array(motion.ok_or_else(unknown)?, law.clone(), numbers))
    }

    /// The machine at a dimensionless point, with the belt speed and the damping of the point.
    pub(super) fn at(&self, law: &Law, point: &Point) -> Result<Machine, Refusal> {
        let machine = self.machine(law)?;
        let units = machine.units();
        let damping = point.epsilon * point.damping * units.damping;
        Ok(Machine { belt_speed: point.belt_speed * units.velocity, damping, ..machine })
    }
}

//! A machine in SI units, and its dimensionless oscillator.
//!
//! A mass m on a spring k with a damper d is pressed with the force N onto a belt of speed v; the coefficient
//! of friction mu depends on the slip speed:
//!
//! ```text
//! m x'' + d x' + k x = -sign(x' - v) N mu(|x' - v|)
//! ```
//!
//! In units of the static force F = mu(0) N, the length F / k and the time sqrt(m / k) this is the crate's
//! oscillator, with eps = 1, V = v / U, c = d / sqrt(k m) and U = F / sqrt(k m) the unit of velocity:
//!
//! | law | its parameters |
//! | --- | --- |
//! | `stribeck` | alpha = mu_k / mu_s, gamma = U / v_s, beta = strengthening U^2 / mu_s |
//! | `exponential`, `lorentzian` | mu = mu_k / mu_s, vs = v_s / U, eta = strengthening U / mu_s |
//! | `expression` | its own; phi(u) = mu(U u) / mu(0) |
//! | `table` | none; phi(u) = mu(U u) / mu(0) |
//!
//! Every oscillator can be written with eps = 1 (theory, "Scaling"). A rotation ([`Motion`]) has the same
//! equation, with the moment of inertia (kg m^2) as the mass, N m/rad and N m s/rad as the units of stiffness
//! and damping, the normal force times its lever arm (N m) as the force, and angles as lengths.

pub mod assessment;
pub mod behaviour;
mod doubts;
mod friction;
mod given;
mod intervals;
mod method_answer;
pub mod probe;
pub mod risk;
pub mod second_opinion;

pub use doubts::{negative, scatter};
pub use friction::{Coefficients, Friction};
pub use given::{AREA, DAMPING_RATIO, FREQUENCY, Given, PRESSURE, RADIUS};

use slipmap_model::friction::{Column, Law, Strengthening};
use slipmap_model::point::Point;
use slipmap_numbers::named;

named! {
    /// Kind of motion of a machine, which determines its units; with its name in configurations and maps.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Motion {
        /// Along a line.
        Translation => "translation",
        /// About an axis: moments of inertia, torques and angles instead of masses, forces and lengths.
        Rotation => "rotation",
    }
}

impl Motion {
    /// The SI unit of a dimension; for a rotation the unit of an angle, a torque or a moment of inertia.
    #[must_use]
    pub fn unit(self, dimension: Dimension) -> &'static str {
        let [translation, rotation] = match dimension {
            Dimension::Time => ["s", "s"],
            Dimension::Length => ["m", "rad"],
            Dimension::Velocity => ["m/s", "rad/s"],
            Dimension::Force => ["N", "N m"],
            Dimension::Damping => ["N s/m", "N m s/rad"],
            Dimension::Mass => ["kg", "kg m²"],
            Dimension::Stiffness => ["N/m", "N m/rad"],
            Dimension::Impulse => ["N s", "N m s"],
        };
        match self {
            Motion::Translation => translation,
            Motion::Rotation => rotation,
        }
    }

    /// The SI unit of a parameter of a fitted law, by its name there; `forces` is whether its friction is a force.
    pub fn unit_of_fitted(self, parameter: &str, forces: bool) -> &'static str {
        match (parameter, forces, self) {
            ("v_s", ..) => self.unit(Dimension::Velocity),
            ("delta", ..) => "",
            ("B", true, _) => self.unit(Dimension::Damping),
            ("B", false, Motion::Rotation) => "s/rad",
            ("B", false, Motion::Translation) => "s/m",
            (_, true, _) => self.unit(Dimension::Force),
            (_, false, _) => "",
        }
    }

    /// The words for a quantity of [`Machine::quantities`] that does not belong to the friction.
    pub fn words(self, quantity: &str) -> String {
        match (self, quantity) {
            (Motion::Rotation, "mass") => "moment of inertia".into(),
            (Motion::Rotation, "normal_force") => "normal force times arm".into(),
            (Motion::Rotation, "belt_speed") => "rotary speed".into(),
            (_, name) => name.replace('_', " "),
        }
    }
}

/// The physical dimension of a quantity; for a rotation, angles are lengths and torques are forces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Dimension {
    Time,
    Length,
    Velocity,
    Force,
    Damping,
    Mass,
    Stiffness,
    Impulse,
}

impl Dimension {
    /// The dimension of a quantity of a machine; `None` for a coefficient, and for a name in a formula.
    pub fn of_quantity(name: &str) -> Option<Self> {
        match name {
            MASS | INERTIA => Some(Dimension::Mass),
            STIFFNESS => Some(Dimension::Stiffness),
            DAMPING => Some(Dimension::Damping),
            NORMAL_FORCE => Some(Dimension::Force),
            "stribeck_velocity" | BELT_SPEED => Some(Dimension::Velocity),
            _ => None,
        }
    }
}

/// Whether a quantity of a machine may have a finite value, by its sign; and what it must be.
pub fn requirement(quantity: &str, value: f64) -> (bool, &'static str) {
    match quantity {
        MASS | STIFFNESS | NORMAL_FORCE | "static_friction" | "stribeck_velocity" | BELT_SPEED
        | FREQUENCY | PRESSURE | AREA | RADIUS => (value > 0.0, "greater than 0"),
        DAMPING | DAMPING_RATIO | "strengthening" => (value >= 0.0, "at least 0"),
        Coefficients::EXPONENT => ((1.0..=100.0).contains(&value), "from 1 to 100"),
        _ => (true, "a number"),
    }
}

/// A machine, in SI units; for a rotation kg m^2 replaces kg, N m replaces N and rad replaces m.
#[derive(Clone, Debug, PartialEq)]
pub struct Machine {
    /// Kind of motion.
    pub motion: Motion,
    /// m > 0, kg.
    pub mass: f64,
    /// k > 0, N/m.
    pub stiffness: f64,
    /// d >= 0, N s/m.
    pub damping: f64,
    /// N > 0, N.
    pub normal_force: f64,
    /// Whether the normal force is known. If not, it is 1 N, and the friction is the friction force in N.
    pub normal_force_is_known: bool,
    /// The coefficient of friction.
    pub friction: Friction,
    /// Whether its law is read as 1 + eps F(u).
    pub small: bool,
    /// v > 0, m/s.
    pub belt_speed: f64,
    /// What was given in place of the mass, the stiffness, the damping or the normal force.
    pub given: Given,
}

/// The dimensionless oscillator of a machine, with the units that convert its numbers to SI.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// The friction law.
    pub law: Law,
    /// The parameter point.
    pub point: Point,
    /// The SI units of the dimensionless numbers.
    pub si: Units,
}

/// The units of the dimensionless oscillator, in SI.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Units {
    /// Whether the machine moves along a line or turns.
    #[serde(skip)]
    pub motion: Motion,
    /// s.
    pub time: f64,
    /// m.
    pub length: f64,
    /// m/s.
    pub velocity: f64,
    /// N.
    pub force: f64,
    /// N s/m: the damping d at c = 1 and eps = 1. It is not serialised, since it is force over velocity.
    #[serde(skip)]
    pub damping: f64,
}

impl Units {
    /// Those of SI: numbers in SI units stay as they are.
    pub const fn si(motion: Motion) -> Self {
        Self { motion, time: 1.0, length: 1.0, velocity: 1.0, force: 1.0, damping: 1.0 }
    }

    /// The units of a mass (kg) on a spring of this stiffness (N/m) with this static friction force (N).
    pub fn of(motion: Motion, mass: f64, stiffness: f64, force: f64) -> Self {
        let damping = (stiffness * mass).sqrt();
        Self {
            motion,
            time: (mass / stiffness).sqrt(),
            length: force / stiffness,
            velocity: force / damping,
            force,
            damping,
        }
    }

    /// The factor from a dimensionless number of this dimension to SI.
    pub fn factor(&self, dimension: Dimension) -> f64 {
        match dimension {
            Dimension::Time => self.time,
            Dimension::Length => self.length,
            Dimension::Velocity => self.velocity,
            Dimension::Force => self.force,
            Dimension::Damping => self.damping,
            Dimension::Mass => self.damping * self.time,
            Dimension::Stiffness => self.damping / self.time,
            Dimension::Impulse => self.force * self.time,
        }
    }

    /// The name of the unit of this dimension.
    pub fn unit(&self, dimension: Dimension) -> &'static str {
        self.motion.unit(dimension)
    }
}

/// Name of the attribute in which a map keeps the motion of its machine, as [`Motion::name`].
#[doc(hidden)]
pub const MOTION_ATTRIBUTE: &str = "machine_motion";

/// The name of the mass as a key of configurations and as a column of tables.
pub const MASS: &str = "mass";
const STIFFNESS: &str = "stiffness";
/// The name of the friction at rest of a law with coefficients, as that of the normal force.
pub const STATIC_FRICTION: &str = "static_friction";
const KINETIC_FRICTION: &str = "kinetic_friction";
/// The name of the normal force, as that of the mass.
pub const NORMAL_FORCE: &str = "normal_force";
/// The name of the belt speed as a key of configurations and as an axis of maps.
pub const BELT_SPEED: &str = "belt_speed";
/// The name of the damping, as that of the belt speed.
pub const DAMPING: &str = "damping";
/// The other name of the mass, for a machine that rotates.
pub const INERTIA: &str = "inertia";

impl Machine {
    /// Names of all quantities that do not belong to the friction of a machine.
    pub fn own_names() -> impl Iterator<Item = &'static str> {
        [MASS, STIFFNESS, DAMPING, NORMAL_FORCE, BELT_SPEED].into_iter().chain(Given::NAMES)
    }

    /// Names of the quantities of a machine under a law, in their order, if those that `is_given` stand in place of
    /// others.
    pub fn names(law: &Law, is_given: impl Fn(&str) -> bool) -> Vec<&'static str> {
        let mut names = given::own_names(is_given);
        match law.as_written() {
            Law::Expression(formula) => {
                names.extend(formula.parameters().iter().map(|parameter| parameter.name));
            }
            Law::Table(_) => {}
            law => names.extend(Coefficients::names(law)),
        }
        names.push(BELT_SPEED);
        names
    }

    /// The machine of a law in SI units with these values of its quantities; those of [`Given::NAMES`] stand in place
    /// of others where they are there. The normal force may be absent, then the friction is a force. `None` where
    /// another value is.
    pub fn new(motion: Motion, law: &Law, value: impl Fn(&str) -> Option<f64>) -> Option<Self> {
        let is_given = |name: &str| value(name).is_some();
        let known = Self::names(law, is_given);
        if known.iter().any(|name| *name != NORMAL_FORCE && !is_given(name)) {
            return None;
        }
        // What is not given follows.
        let own = |name: &str| value(name).filter(|_| known.contains(&name)).unwrap_or(1.0);
        let mut machine = Self {
            motion,
            mass: own(MASS),
            stiffness: own(STIFFNESS),
            damping: own(DAMPING),
            normal_force: own(NORMAL_FORCE),
            normal_force_is_known: is_given(NORMAL_FORCE) || is_given(PRESSURE),
            friction: Friction::new(law, &value)?,
            small: law.is_read_as_small(),
            belt_speed: own(BELT_SPEED),
            given: Given::new(|name| value(name).filter(|_| known.contains(&name))),
        };
        machine.follow();
        Some(machine)
    }

    /// The machine with these numbers: mass, stiffness, damping, normal force, the four coefficients of friction
    /// of one of the laws with coefficients, and belt speed.
    #[must_use]
    pub fn from_array(motion: Motion, law: Law, numbers: [f64; 9]) -> Self {
        let [mass, stiffness, damping, normal_force, rest, kinetic, velocity, strengthening, belt_speed] =
            numbers;
        let coefficients = Coefficients::from_array([rest, kinetic, velocity, strengthening, 1.0]);
        Self {
            motion,
            mass,
            stiffness,
            damping,
            normal_force,
            normal_force_is_known: true,
            friction: Friction::Coefficients(law, coefficients),
            small: false,
            belt_speed,
            given: Given::default(),
        }
    }

    /// The law of its friction in SI units, as its quantities give it.
    pub fn law(&self) -> Law {
        let law = match &self.friction {
            Friction::Coefficients(law, _) => law.clone(),
            Friction::Formula(formula, _) => Law::Expression(formula.clone()),
            Friction::Measured(table) => Law::Table(table.clone()),
        };
        if self.small { law.read_as_small() } else { law }
    }

    /// All numbers of the machine that it is given by, with their names in configurations; the normal force only if it
    /// is known.
    pub fn quantities(&self) -> Vec<(&'static str, f64)> {
        let own = given::own_names(|name| self.is_given(name)).into_iter();
        let known = own.filter(|name| *name != NORMAL_FORCE || self.normal_force_is_known);
        let own = known.filter_map(|name| Some((name, self.value(name)?)));
        own.chain(self.friction.quantities()).chain([(BELT_SPEED, self.belt_speed)]).collect()
    }

    /// The machine with another value of one of its quantities; `None` if it has no such quantity.
    pub fn with(&self, name: &str, value: f64) -> Option<Machine> {
        let mut machine = self.clone();
        machine.set(name, value).then_some(machine)
    }

    /// Sets one of its quantities, and what follows from it; returns whether it has it.
    pub fn set(&mut self, name: &str, value: f64) -> bool {
        if self.set_own(if name == INERTIA { MASS } else { name }, value) {
            return true;
        }
        let names = self.friction.quantities();
        let Some(position) = names.iter().position(|(known, _)| *known == name) else { return false };
        self.friction.set(position, value);
        true
    }

    /// The SI unit of one of its quantities; empty for a pure number, and for a name in a formula.
    pub fn unit(&self, quantity: &str) -> &'static str {
        unit(quantity, self.motion, &self.law(), self.normal())
    }

    /// Where its normal force is.
    pub fn normal(&self) -> Normal {
        Normal::of(!self.normal_force_is_known, self.given.has_radius())
    }

    /// The words for one of its quantities. Names in a formula stay as they are written.
    pub fn words(&self, quantity: &str) -> String {
        match &self.friction {
            Friction::Formula(formula, _) if formula.parameters().iter().any(|of| of.name == quantity) => {
                quantity.to_owned()
            }
            _ if quantity == NORMAL_FORCE && self.given.has_radius() => "normal force".into(),
            _ => self.motion.words(quantity).replace("stribeck", "Stribeck"),
        }
    }

    /// The words for its friction, measured or by formula: a force or torque if no normal force is known.
    pub fn words_of_friction(&self) -> &'static str {
        match (self.normal_force_is_known, self.motion) {
            (true, _) => "coefficient of friction",
            (false, Motion::Translation) => "friction force",
            (false, Motion::Rotation) => "friction torque",
        }
    }

    /// The first quantity that has an illegal value: its name, its value, and what it must be.
    pub fn illegal(&self) -> Option<(&'static str, f64, &'static str)> {
        let of_formula = |name: &str| {
            matches!(self.friction, Friction::Formula(..)) && Coefficients::NAMES.contains(&name)
        };
        let illegal = self.quantities().into_iter().find_map(|(name, value)| {
            let (legal, wanted) = requirement(name, value);
            let legal = (legal || of_formula(name)) && value.is_finite();
            (!legal).then_some((name, value, wanted))
        });
        match &self.friction {
            Friction::Coefficients(_, of) if !(0.0..=of.static_friction).contains(&of.kinetic_friction) => {
                illegal.or(Some(("kinetic_friction", of.kinetic_friction, Coefficients::KINETIC)))
            }
            _ => illegal,
        }
    }

    /// Whether every number is one of a machine.
    pub fn is_legal(&self) -> bool {
        self.illegal().is_none() && self.friction.is_legal_at_rest() && self.friction.has_slope_at_rest()
    }

    /// The units of the dimensionless oscillator.
    #[must_use]
    pub fn units(&self) -> Units {
        Units::of(self.motion, self.mass, self.stiffness, self.friction.at_rest() * self.normal_force)
    }

    /// The dimensionless oscillator; `None` if a formula or data overflow in these units.
    #[must_use]
    pub fn model(&self) -> Option<Model> {
        let si = self.units();
        let (law, parameters) = self.friction.dimensionless(&si)?;
        let point = Point {
            epsilon: 1.0,
            law: parameters,
            belt_speed: self.belt_speed / si.velocity,
            damping: self.damping / si.damping,
        };
        let law = if self.small { law.read_as_small() } else { law };
        Some(Model { law, point, si })
    }
}

/// Where the normal force of a machine is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normal {
    /// A number, for a rotation times its arm.
    Alone,
    /// A number, at the radius of a rotation.
    AtRadius,
    /// In the friction, which is a force.
    InFriction,
}

impl Normal {
    /// Where it is, of a machine whose friction is a force, or which has a radius.
    pub fn of(friction_is_force: bool, has_radius: bool) -> Self {
        match (friction_is_force, has_radius) {
            (true, _) => Self::InFriction,
            (false, true) => Self::AtRadius,
            (false, false) => Self::Alone,
        }
    }
}

/// The SI unit of a quantity of a machine under a law; empty for a pure number, and for a name in a formula.
pub fn unit(quantity: &str, motion: Motion, law: &Law, normal: Normal) -> &'static str {
    match quantity {
        NORMAL_FORCE if normal == Normal::AtRadius => Motion::Translation.unit(Dimension::Force),
        STATIC_FRICTION | KINETIC_FRICTION if normal == Normal::InFriction => motion.unit(Dimension::Force),
        "strengthening" if normal == Normal::InFriction => {
            match (law.built_in().map(|law| law.strengthening), motion) {
                (Some(Strengthening::Quadratic), Motion::Translation) => "N s²/m²",
                (Some(Strengthening::Quadratic), Motion::Rotation) => "N m s²/rad²",
                (Some(Strengthening::Linear) | None, motion) => motion.unit(Dimension::Damping),
            }
        }
        "strengthening" => match (law.built_in().map(|law| law.strengthening), motion) {
            (Some(Strengthening::Quadratic), Motion::Translation) => "s²/m²",
            (Some(Strengthening::Quadratic), Motion::Rotation) => "s²/rad²",
            (Some(Strengthening::Linear) | None, Motion::Translation) => "s/m",
            (Some(Strengthening::Linear) | None, Motion::Rotation) => "s/rad",
        },
        FREQUENCY => "Hz",
        PRESSURE => "Pa",
        AREA => "m²",
        RADIUS => "m",
        _ => Dimension::of_quantity(quantity).map_or("", |dimension| motion.unit(dimension)),
    }
}

impl Model {
    /// The column of parameter space that contains the model's point.
    #[must_use]
    pub fn column(&self) -> Column {
        self.law.column(&self.point)
    }
}

#[cfg(test)]
pub(crate) fn example(law: Law) -> Machine {
    // Two coefficients have no Stribeck velocity.
    let stribeck_velocity = if law == Law::Coulomb { 1.0 } else { 0.25 };
    let values = [2.0, 800.0, 4.0, 50.0, 0.4, 0.3, stribeck_velocity, 0.02, 0.1];
    Machine::from_array(Motion::Translation, law, values)
}

/// A machine with this friction, mass, stiffness, normal force, belt speed and damping.
#[cfg(test)]
pub(crate) fn example_of(friction: Friction, numbers: [f64; 5]) -> Machine {
    let [mass, stiffness, normal_force, belt_speed, damping] = numbers;
    Machine { friction, mass, stiffness, normal_force, belt_speed, damping, ..example(Law::Stribeck) }
}

/// The friction of a formula without names in it.
#[cfg(test)]
pub(crate) fn formula(text: &str) -> Friction {
    let formula = slipmap_model::friction::Expression::new(text, 1.0).unwrap();
    Friction::Formula(formula, slipmap_model::point::LawParameters::new(&[]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_and_back() {
        for law in Law::BUILT_IN {
            let machine = example(law.clone());
            let value = |name: &str| machine.quantities().into_iter().find(|(known, _)| *known == name);
            let again = Machine::new(machine.motion, &machine.law(), |name| Some(value(name)?.1));
            assert_eq!(again.unwrap().quantities(), machine.quantities());
            for (name, value) in machine.quantities() {
                assert_eq!(machine.with(name, value).unwrap(), machine);
                assert_ne!(machine.with(name, 2.0 * value).unwrap(), machine);
            }
        }
    }
}

//! A machine in SI units and its dimensionless oscillator.
//!
//! A mass m on a spring k with a damper d is pressed with the force N onto a belt of speed v; the coefficient
//! of friction is mu_s at rest and falls to mu_k over the Stribeck velocity:
//!
//! ```text
//! m x'' + d x' + k x = -sign(x' - v) N mu(|x' - v|)
//! ```
//!
//! In units of the static force F = mu_s N, the length F / k and the time sqrt(m / k) this is the crate's
//! oscillator, with eps = 1, V = v / U, c = d / sqrt(k m) and U = F / sqrt(k m) the unit of velocity:
//!
//! | law | its parameters |
//! | --- | --- |
//! | `stribeck` | alpha = mu_k / mu_s, gamma = U / v_s, beta = strengthening U^2 / mu_s |
//! | `exponential`, `lorentzian` | mu = mu_k / mu_s, vs = v_s / U, eta = strengthening U / mu_s |
//!
//! Every oscillator can be written with eps = 1 (theory, "Scaling"). A rotation ([`Motion`]) is the same with
//! the moment of inertia (kg m^2) for the mass, N m/rad and N m s/rad for stiffness and damping, the normal
//! force times its lever arm (N m) for the force, and angles for lengths.

use crate::friction::Law;
use crate::point::{LawParameters, Point};

/// Kind of motion of a machine, which determines its units.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Along a line.
    Translation,
    /// Around an axis: moments of inertia, torques and angles for masses, forces and lengths.
    Rotation,
}

impl Motion {
    /// Both.
    pub const ALL: [Motion; 2] = [Self::Translation, Self::Rotation];

    /// Its name in configurations and maps.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Motion::Translation => "translation",
            Motion::Rotation => "rotation",
        }
    }

    /// The SI unit of a dimension: of a rotation those of angles, torques and moments of inertia.
    #[must_use]
    pub fn unit(self, dimension: Dimension) -> &'static str {
        match (self, dimension) {
            (_, Dimension::Time) => "s",
            (Motion::Translation, Dimension::Length) => "m",
            (Motion::Rotation, Dimension::Length) => "rad",
            (Motion::Translation, Dimension::Velocity) => "m/s",
            (Motion::Rotation, Dimension::Velocity) => "rad/s",
            (Motion::Translation, Dimension::Force) => "N",
            (Motion::Rotation, Dimension::Force) => "N m",
            (Motion::Translation, Dimension::Damping) => "N s/m",
            (Motion::Rotation, Dimension::Damping) => "N m s/rad",
            (Motion::Translation, Dimension::Mass) => "kg",
            (Motion::Rotation, Dimension::Mass) => "kg m^2",
            (Motion::Translation, Dimension::Stiffness) => "N/m",
            (Motion::Rotation, Dimension::Stiffness) => "N m/rad",
        }
    }
}

/// The physical dimension of a quantity; of a rotation, angles for lengths and torques for forces.
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
}

/// A machine, in SI units; for a rotation kg m^2 replaces kg, N m replaces N and rad replaces m.
#[derive(Clone, Copy, Debug, PartialEq)]
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
    /// mu_s > 0.
    pub static_friction: f64,
    /// mu_k in [0, mu_s].
    pub kinetic_friction: f64,
    /// v_s > 0, m/s.
    pub stribeck_velocity: f64,
    /// Rise of the coefficient of friction at high speed, >= 0: per (m/s)^2 in the law `stribeck`, per m/s in
    /// the others.
    pub strengthening: f64,
    /// v > 0, m/s.
    pub belt_speed: f64,
}

/// The units of the dimensionless oscillator, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// s.
    pub time: f64,
    /// m.
    pub length: f64,
    /// m/s.
    pub velocity: f64,
    /// N.
    pub force: f64,
    /// N s/m: d of c = 1 at eps = 1.
    pub damping: f64,
}

impl Units {
    /// The factor from a dimensionless number of this dimension to SI.
    #[must_use]
    pub fn factor(&self, dimension: Dimension) -> f64 {
        match dimension {
            Dimension::Time => self.time,
            Dimension::Length => self.length,
            Dimension::Velocity => self.velocity,
            Dimension::Force => self.force,
            Dimension::Damping => self.damping,
            Dimension::Mass => self.damping * self.time,
            Dimension::Stiffness => self.damping / self.time,
        }
    }

    /// As stored in maps: time, length, velocity, force, damping.
    #[must_use]
    pub fn to_array(&self) -> [f64; 5] {
        [self.time, self.length, self.velocity, self.force, self.damping]
    }
}

/// Name of the attribute in which a map keeps the units of its machine, as [`Units::to_array`].
pub const UNITS_ATTRIBUTE: &str = "machine_units";
/// Name of the attribute in which a map keeps its machine, as [`Machine::to_array`].
pub const SI_ATTRIBUTE: &str = "machine_si";
/// Name of the attribute in which it keeps its motion, as [`Motion::name`].
pub const MOTION_ATTRIBUTE: &str = "machine_motion";

impl Machine {
    /// All quantities in the order of the fields, without the motion.
    #[must_use]
    pub fn to_array(&self) -> [f64; 9] {
        [
            self.mass,
            self.stiffness,
            self.damping,
            self.normal_force,
            self.static_friction,
            self.kinetic_friction,
            self.stribeck_velocity,
            self.strengthening,
            self.belt_speed,
        ]
    }

    /// The machine of such an array.
    #[must_use]
    pub fn from_array(motion: Motion, numbers: [f64; 9]) -> Self {
        let [mass, stiffness, damping, normal_force, static_friction, kinetic_friction, rest @ ..] = numbers;
        let [stribeck_velocity, strengthening, belt_speed] = rest;
        Self {
            motion,
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

    /// The units of the dimensionless oscillator.
    #[must_use]
    pub fn units(&self) -> Units {
        let force = self.static_friction * self.normal_force;
        let damping = (self.stiffness * self.mass).sqrt();
        Units {
            time: (self.mass / self.stiffness).sqrt(),
            length: force / self.stiffness,
            velocity: force / damping,
            force,
            damping,
        }
    }

    /// The dimensionless point; `None` for laws given as text or data, which have no coefficients of
    /// friction.
    #[must_use]
    pub fn point(&self, law: &Law) -> Option<Point> {
        let Units { velocity, damping, .. } = self.units();
        let ratio = self.kinetic_friction / self.static_friction;
        let rise = self.strengthening / self.static_friction;
        let law = match law.as_written() {
            Law::Stribeck => [ratio, rise * velocity * velocity, velocity / self.stribeck_velocity],
            Law::Exponential | Law::Lorentzian => [ratio, self.stribeck_velocity / velocity, rise * velocity],
            _ => return None,
        };
        Some(Point {
            epsilon: 1.0,
            law: LawParameters::new(&law),
            belt_speed: self.belt_speed / velocity,
            damping: self.damping / damping,
        })
    }

    /// The machine of a dimensionless point, with the mass, stiffness, normal force and static friction of
    /// this one; `None` as in [`Machine::point`].
    #[must_use]
    pub fn at(&self, law: &Law, point: &Point) -> Option<Machine> {
        let Units { velocity, damping, .. } = self.units();
        let eps = point.epsilon;
        let (ratio, stribeck_velocity, rise) = match (law.as_written(), point.law.as_slice()) {
            (Law::Stribeck, &[alpha, beta, gamma]) => {
                (alpha, velocity / (eps * gamma), eps * beta / (velocity * velocity))
            }
            (Law::Exponential | Law::Lorentzian, &[mu, vs, eta]) => (mu, vs * velocity, eta / velocity),
            _ => return None,
        };
        Some(Machine {
            kinetic_friction: ratio * self.static_friction,
            stribeck_velocity,
            strengthening: rise * self.static_friction,
            belt_speed: point.belt_speed * velocity,
            damping: eps * point.damping * damping,
            ..*self
        })
    }
}

/// An example machine for tests.
#[cfg(test)]
pub(crate) fn example() -> Machine {
    Machine {
        motion: Motion::Translation,
        mass: 2.0,
        stiffness: 800.0,
        damping: 4.0,
        normal_force: 50.0,
        static_friction: 0.4,
        kinetic_friction: 0.3,
        stribeck_velocity: 0.25,
        strengthening: 0.02,
        belt_speed: 0.1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn by_hand() {
        // F = 20 N, sqrt(k m) = 40 N s/m, so that U = 0.5 m/s, the length 25 mm and the time 50 ms.
        let units = example().units();
        let hand = Units { time: 0.05, length: 0.025, velocity: 0.5, force: 20.0, damping: 40.0 };
        assert_eq!(units, hand);
        let point = example().point(&Law::Stribeck).unwrap();
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 4.0 * f64::EPSILON * b, "{a} {b}");
        for (a, b) in point.law.as_slice().iter().zip([0.75, 0.0125, 2.0]) {
            close(*a, b);
        }
        close(point.belt_speed, 0.2);
        close(point.damping, 0.1);
        let point = example().point(&Law::Exponential).unwrap();
        for (a, b) in point.law.as_slice().iter().zip([0.75, 0.5, 0.025]) {
            close(*a, b);
        }
    }

    #[test]
    fn there_and_back() {
        for law in Law::BUILT_IN {
            let machine = example();
            let back = machine.at(&law, &machine.point(&law).unwrap()).unwrap();
            for (a, b) in [
                (back.damping, machine.damping),
                (back.kinetic_friction, machine.kinetic_friction),
                (back.stribeck_velocity, machine.stribeck_velocity),
                (back.strengthening, machine.strengthening),
                (back.belt_speed, machine.belt_speed),
            ] {
                assert!((a - b).abs() <= 8.0 * f64::EPSILON * b, "{a} {b}");
            }
        }
    }
}

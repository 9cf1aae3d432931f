//! Quantities that people have in place of a machine's own. They are inputs, and so axes, like those that they stand
//! for: whoever sets one changes what follows from it.
//!
//! | given | in place of | which follows |
//! | --- | --- | --- |
//! | `frequency` f, Hz, of the undamped mass on its spring | the mass or the stiffness | k = m (2 pi f)^2 |
//! | `damping_ratio` zeta | the damping | d = 2 zeta sqrt(k m) |
//! | `pressure` p and `area` A | the normal force | N = p A |
//! | `radius` r, of a rotation | | the torque of friction is mu(u) N r: N is a force |
//! | `radius` r, of what slides on a disc | | speeds may be written per angle, and are shown so, too: v = r omega |

use std::f64::consts::TAU;

use super::{BELT_SPEED, DAMPING, MASS, Machine, NORMAL_FORCE, STIFFNESS};

/// The undamped natural frequency, in place of the mass or the stiffness.
pub const FREQUENCY: &str = "frequency";
/// The damping over that at which the mass on its spring alone no longer oscillates.
pub const DAMPING_RATIO: &str = "damping_ratio";
/// The pressure on an area, in place of the normal force.
pub const PRESSURE: &str = "pressure";
/// The area under pressure.
pub const AREA: &str = "area";
/// The radius at which the normal force presses on what rotates.
pub const RADIUS: &str = "radius";

/// Values of what is given in place of a machine's own quantities.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given {
    /// Hz, and whether it stands for the mass instead of the stiffness.
    frequency: Option<(f64, bool)>,
    damping_ratio: Option<f64>,
    /// Pa and m^2.
    pressure: Option<[f64; 2]>,
    /// m and N: the radius and the normal force there.
    radius: Option<[f64; 2]>,
    /// m: the radius at which a disc moves what slides on it. No quantity: the belt speed is known.
    disc: Option<f64>,
}

impl Given {
    /// All names of such quantities.
    pub const NAMES: [&str; 5] = [FREQUENCY, DAMPING_RATIO, PRESSURE, AREA, RADIUS];

    /// The quantities that exclude each other: one, and what stands in its place.
    pub const IN_PLACE: [(&str, &str); 3] =
        [(DAMPING, DAMPING_RATIO), (NORMAL_FORCE, PRESSURE), (NORMAL_FORCE, AREA)];

    /// Of the quantities with these values.
    pub(super) fn new(value: impl Fn(&str) -> Option<f64>) -> Self {
        let both = |a: &str, b: &str| Some([value(a)?, value(b)?]);
        Self {
            frequency: value(FREQUENCY).map(|frequency| (frequency, value(MASS).is_none())),
            damping_ratio: value(DAMPING_RATIO),
            pressure: both(PRESSURE, AREA),
            radius: value(RADIUS).map(|radius| [radius, value(NORMAL_FORCE).unwrap_or(1.0)]),
            disc: None,
        }
    }

    /// The same on a disc, at this radius.
    #[must_use]
    pub fn on_disc(self, radius: Option<f64>) -> Self {
        Self { disc: radius, ..self }
    }

    /// The radius at which a disc moves what slides on it.
    pub fn disc(&self) -> Option<f64> {
        self.disc
    }

    /// The radius that makes rotary speeds of speeds along a line, and back.
    pub fn radius_of_speeds(&self) -> Option<f64> {
        self.disc.or(self.radius.map(|[radius, _]| radius))
    }

    /// Whether the damping is given by its ratio.
    pub(super) fn has_ratio(&self) -> bool {
        self.damping_ratio.is_some()
    }

    /// Whether the normal force is that at a radius.
    pub(super) fn has_radius(&self) -> bool {
        self.radius.is_some()
    }
}

/// The names of the quantities of a machine before those of its friction, in their order, if those that `is_given`
/// are given.
pub(super) fn own_names(is_given: impl Fn(&str) -> bool) -> Vec<&'static str> {
    let has_frequency = is_given(FREQUENCY);
    let of_mass = has_frequency && is_given(STIFFNESS) && !is_given(MASS);
    let mut names = Vec::new();
    names.extend((!of_mass).then_some(MASS));
    names.extend((!has_frequency || of_mass).then_some(STIFFNESS));
    names.extend(has_frequency.then_some(FREQUENCY));
    names.push(if is_given(DAMPING_RATIO) { DAMPING_RATIO } else { DAMPING });
    match is_given(PRESSURE) || is_given(AREA) {
        true => names.extend([PRESSURE, AREA]),
        false => names.push(NORMAL_FORCE),
    }
    names.extend(is_given(RADIUS).then_some(RADIUS));
    names
}

impl Machine {
    /// The value of one of its quantities other than those of the friction.
    pub(super) fn value(&self, name: &str) -> Option<f64> {
        let given = &self.given;
        Some(match name {
            MASS => self.mass,
            STIFFNESS => self.stiffness,
            FREQUENCY => given.frequency?.0,
            DAMPING => self.damping,
            DAMPING_RATIO => given.damping_ratio?,
            NORMAL_FORCE => given.radius.map_or(self.normal_force, |[_, force]| force),
            PRESSURE => given.pressure?[0],
            AREA => given.pressure?[1],
            RADIUS => given.radius?[0],
            BELT_SPEED => self.belt_speed,
            _ => return None,
        })
    }

    /// Whether a quantity is one that it is given by; of two that exclude each other one is.
    pub(super) fn is_given(&self, name: &str) -> bool {
        match name {
            MASS => !self.given.frequency.is_some_and(|(_, of_mass)| of_mass),
            STIFFNESS => self.given.frequency.is_none_or(|(_, of_mass)| of_mass),
            DAMPING => !self.given.has_ratio(),
            NORMAL_FORCE => self.given.pressure.is_none(),
            name => self.value(name).is_some(),
        }
    }

    /// Sets a quantity other than those of the friction; returns whether it has it. A quantity for which another was
    /// given takes its place again.
    pub(super) fn set_own(&mut self, name: &str, value: f64) -> bool {
        let given = &mut self.given;
        match name {
            MASS => {
                self.mass = value;
                given.frequency = given.frequency.filter(|(_, of_mass)| !of_mass);
            }
            STIFFNESS => {
                self.stiffness = value;
                given.frequency = given.frequency.filter(|(_, of_mass)| *of_mass);
            }
            DAMPING => (self.damping, given.damping_ratio) = (value, None),
            NORMAL_FORCE => {
                given.pressure = None;
                *given.radius.as_mut().map_or(&mut self.normal_force, |[_, force]| force) = value;
            }
            BELT_SPEED => self.belt_speed = value,
            _ => {
                let place = match name {
                    FREQUENCY => given.frequency.as_mut().map(|(frequency, _)| frequency),
                    DAMPING_RATIO => given.damping_ratio.as_mut(),
                    PRESSURE => given.pressure.as_mut().map(|[pressure, _]| pressure),
                    AREA => given.pressure.as_mut().map(|[_, area]| area),
                    RADIUS => given.radius.as_mut().map(|[radius, _]| radius),
                    _ => None,
                };
                let Some(place) = place else { return false };
                *place = value;
            }
        }
        self.follow();
        true
    }

    /// Computes what follows from what is given.
    pub(super) fn follow(&mut self) {
        let given = &mut self.given;
        if let Some((frequency, of_mass)) = given.frequency {
            let square = (TAU * frequency).powi(2);
            match of_mass {
                true => self.mass = self.stiffness / square,
                false => self.stiffness = self.mass * square,
            }
        }
        if let Some(ratio) = given.damping_ratio {
            self.damping = 2.0 * ratio * (self.stiffness * self.mass).sqrt();
        }
        let force = given.pressure.map(|[pressure, area]| pressure * area);
        match &mut given.radius {
            Some([radius, at_radius]) => {
                *at_radius = force.unwrap_or(*at_radius);
                self.normal_force = *at_radius * *radius;
            }
            None => self.normal_force = force.unwrap_or(self.normal_force),
        }
    }

    /// The name of its damping among its quantities.
    pub fn damping_name(&self) -> &'static str {
        if self.given.has_ratio() { DAMPING_RATIO } else { DAMPING }
    }

    /// The damping, as it is given, of a machine whose dimensionless damping is 1: in N s/m, or 1/2 of a ratio.
    pub fn damping_unit(&self) -> f64 {
        if self.given.has_ratio() { 0.5 } else { self.units().damping }
    }

    /// The damping in N s/m where that given is 1.
    pub fn si_damping(&self) -> f64 {
        self.units().damping / self.damping_unit()
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Motion, example};
    use super::*;
    use slipmap_model::friction::Law;

    /// By hand, from 2 kg, 800 N/m, 4 N s/m and 50 N: 20 rad/s and a ratio of 4/80.
    #[test]
    fn a_machine_is_the_same_by_what_stands_for_its_quantities() {
        let plain = example(Law::Exponential);
        let known = |name: &str| plain.quantities().into_iter().find(|(it, _)| *it == name).map(|it| it.1);
        let (frequency, area) = (20.0 / TAU, 1e-3);
        let by = |instead: &[(&str, f64)], without: &[&str]| {
            let value = |name: &str| match instead.iter().find(|(it, _)| *it == name) {
                Some((_, value)) => Some(*value),
                None => known(name).filter(|_| !without.contains(&name)),
            };
            Machine::new(Motion::Rotation, &plain.law(), value).unwrap()
        };
        for (instead, without) in [
            (&[(FREQUENCY, frequency)][..], &[STIFFNESS][..]),
            (&[(FREQUENCY, frequency)], &[MASS]),
            (&[(DAMPING_RATIO, 0.05)], &[DAMPING]),
            (&[(PRESSURE, 5e4), (AREA, area)], &[NORMAL_FORCE]),
            (&[(RADIUS, 0.1), (NORMAL_FORCE, 500.0)], &[]),
            (
                &[(RADIUS, 0.1), (PRESSURE, 5e5), (AREA, area), (DAMPING_RATIO, 0.05)],
                &[NORMAL_FORCE, DAMPING],
            ),
        ] {
            let machine = by(instead, without);
            let names: Vec<&str> = machine.quantities().into_iter().map(|(name, _)| name).collect();
            assert_eq!(names, Machine::names(&machine.law(), |name| names.contains(&name)));
            assert!(without.iter().all(|name| !names.contains(name)), "{names:?}");
            let all =
                |machine: &Machine| [machine.mass, machine.stiffness, machine.damping, machine.normal_force];
            let same = |one: &Machine| {
                // A square and a product round.
                let pairs = all(one).into_iter().zip(all(&plain));
                pairs.into_iter().all(|(a, b)| (a / b - 1.0).abs() < 8.0 * f64::EPSILON)
            };
            assert!(same(&machine), "{machine:?}");
            // What is set takes its effect, and is what is told.
            for (name, value) in machine.quantities() {
                let again = machine.with(name, 2.0 * value).unwrap();
                assert!(again != machine && again.with(name, value).unwrap() == machine, "{name}");
                assert!(again.quantities().contains(&(name, 2.0 * value)));
            }
        }
        // The ratio stays where the mass changes; the damping that replaces it does not.
        let ratio = by(&[(DAMPING_RATIO, 0.05)], &[DAMPING]);
        assert_eq!(ratio.with(MASS, 8.0).unwrap().damping, 8.0);
        assert_eq!(ratio.with(DAMPING, 4.0).unwrap().with(MASS, 8.0).unwrap().damping, 4.0);
        assert!(plain.with(DAMPING_RATIO, 0.05).is_none());
    }
}

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
//! Every oscillator can be written with eps = 1 (theory, "Scaling"). A rotation ([`Motion`]) is the same with the
//! moment of inertia (kg m^2) for the mass, N m/rad and N m s/rad for stiffness and damping, the normal force
//! times its lever arm (N m) for the force, and angles for lengths.

use crate::filippov::Oscillator;
use crate::friction::Law;
use crate::map::{Regime, regime};
use crate::point::{LawParameters, Point};
use crate::simulate::crossing::stick_slip_cycle;
use crate::simulate::slip_cycle::slip_cycles;
use crate::simulate::{Fate, critical_damping, flow};

/// How a machine moves, which names its units.
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

    /// The SI unit of lengths, or of angles.
    #[must_use]
    pub fn length(self) -> &'static str {
        match self {
            Motion::Translation => "m",
            Motion::Rotation => "rad",
        }
    }

    /// The SI unit of velocities.
    #[must_use]
    pub fn velocity(self) -> &'static str {
        match self {
            Motion::Translation => "m/s",
            Motion::Rotation => "rad/s",
        }
    }

    /// The SI unit of damping coefficients.
    #[must_use]
    pub fn damping(self) -> &'static str {
        match self {
            Motion::Translation => "N s/m",
            Motion::Rotation => "N m s/rad",
        }
    }
}

/// A machine, in SI units; those of a rotation are kg m^2 for kg, N m for N and rad for m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Machine {
    /// How it moves.
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

    /// The units in which it is measured.
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

    /// The dimensionless point; `None` for laws given as text or data, which have no coefficients of their own.
    #[must_use]
    pub fn point(&self, law: &Law) -> Option<Point> {
        let Units { velocity, damping, .. } = self.units();
        let ratio = self.kinetic_friction / self.static_friction;
        let rise = self.strengthening / self.static_friction;
        let law = match law {
            Law::Stribeck => [ratio, rise * velocity * velocity, velocity / self.stribeck_velocity],
            Law::Exponential | Law::Lorentzian => [ratio, self.stribeck_velocity / velocity, rise * velocity],
            Law::Expression(_) | Law::Table(_) => return None,
        };
        Some(Point {
            epsilon: 1.0,
            law: LawParameters::new(&law),
            belt_speed: self.belt_speed / velocity,
            damping: self.damping / damping,
        })
    }

    /// The machine of a dimensionless point, with the mass, stiffness, normal force and static friction of this
    /// one; `None` as in [`Machine::point`].
    #[must_use]
    pub fn at(&self, law: &Law, point: &Point) -> Option<Machine> {
        let Units { velocity, damping, .. } = self.units();
        let eps = point.epsilon;
        let (ratio, stribeck_velocity, rise) = match (law, point.law.as_slice()) {
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

/// What an engineer asks, in SI units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Behaviour {
    /// Undamped natural frequency, Hz.
    pub natural_frequency: f64,
    /// Damping ratio d / (2 sqrt(k m)).
    pub damping_ratio: f64,
    /// The belt speed above which the mass that leaves the belt does not come back to it, m/s: the highest one
    /// within a factor of 1000 of the machine's; `None` if there is none.
    pub critical_belt_speed: Option<f64>,
    /// The damping coefficient above which the same holds, N s/m; `None` if no damping is needed, or none found.
    pub critical_damping: Option<f64>,
    /// The same as a damping ratio.
    pub critical_damping_ratio: Option<f64>,
    /// Long-run behaviour.
    pub regime: Regime,
    /// Slip and stick time of the stick-slip cycle, s.
    pub slip_and_stick_time: Option<[f64; 2]>,
    /// Half the distance between the extremes of x of the cycle that attracts: the stick-slip cycle's, else
    /// the largest stable slip cycle's, m.
    pub amplitude: Option<f64>,
}

/// Belt speeds are sought in these steps per factor of ten.
const STEPS_PER_DECADE: i32 = 8;
const DECADES: i32 = 3;

/// The highest belt speed, within three decades, at which c* passes the point's damping.
fn critical_belt_speed(law: &Law, point: &Point, tolerance: f64) -> Option<f64> {
    let returns = |belt_speed: f64| {
        let column = law.column(&Point { belt_speed, ..*point });
        critical_damping(&column, tolerance).ok().map(|root| root.c > point.damping)
    };
    let range = DECADES * STEPS_PER_DECADE;
    let at = |i: i32| point.belt_speed * 10f64.powf(f64::from(i) / f64::from(STEPS_PER_DECADE));
    let mut high = None;
    for i in (-range..=range).rev() {
        match (returns(at(i)), high) {
            (Some(false), _) => high = Some(at(i)),
            (Some(true), Some(mut high)) => {
                let mut low = at(i);
                while high - low > 1e-12 * high {
                    let middle = 0.5 * (low + high);
                    if middle <= low || middle >= high {
                        break;
                    }
                    match returns(middle) {
                        Some(true) => low = middle,
                        Some(false) => high = middle,
                        None => return None,
                    }
                }
                return Some(0.5 * (low + high));
            }
            (Some(true), None) => return None,
            (None, _) => high = None,
        }
    }
    None
}

/// What the machine does under `law`; `None` as in [`Machine::point`].
#[must_use]
pub fn behaviour(machine: &Machine, law: &Law, tolerance: f64) -> Option<Behaviour> {
    let point = machine.point(law)?;
    let units = machine.units();
    let oscillator = Oscillator::new(law, &point);
    let flow = flow(&oscillator, tolerance);
    let half = |range: crate::friction::Range| 0.5 * (range.hi - range.lo) * units.length;
    let stick_slip = stick_slip_cycle(&oscillator, &flow, tolerance).ok().flatten();
    let slip = || slip_cycles(&oscillator, tolerance).ok()?.into_iter().rfind(|cycle| cycle.is_stable());
    let amplitude = stick_slip.map(|cycle| half(cycle.displacement));
    let amplitude = amplitude.or_else(|| slip().map(|cycle| half(cycle.displacement)));
    let critical = critical_damping(&law.column(&point), tolerance).ok().map(|root| root.c);
    let critical = critical.filter(|c| *c >= 0.0);
    let times = match flow.fate {
        Fate::Sticks(landing) => Some([landing.slip_time * units.time, landing.stick_time * units.time]),
        Fate::SpiralsInward | Fate::CrossesForever | Fate::TooCloseToCall | Fate::Failed(_) => None,
    };
    Some(Behaviour {
        natural_frequency: 1.0 / (std::f64::consts::TAU * units.time),
        damping_ratio: 0.5 * point.damping,
        critical_belt_speed: critical_belt_speed(law, &point, tolerance).map(|speed| speed * units.velocity),
        critical_damping: critical.map(|c| c * units.damping),
        critical_damping_ratio: critical.map(|c| 0.5 * c),
        regime: regime(&oscillator, &flow),
        slip_and_stick_time: times,
        amplitude,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn machine() -> Machine {
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

    #[test]
    fn by_hand() {
        // F = 20 N, sqrt(k m) = 40 N s/m, so that U = 0.5 m/s, the length 25 mm and the time 50 ms.
        let units = machine().units();
        let hand = Units { time: 0.05, length: 0.025, velocity: 0.5, force: 20.0, damping: 40.0 };
        assert_eq!(units, hand);
        let point = machine().point(&Law::Stribeck).unwrap();
        let close = |a: f64, b: f64| assert!((a - b).abs() <= 4.0 * f64::EPSILON * b, "{a} {b}");
        for (a, b) in point.law.as_slice().iter().zip([0.75, 0.0125, 2.0]) {
            close(*a, b);
        }
        close(point.belt_speed, 0.2);
        close(point.damping, 0.1);
        let point = machine().point(&Law::Exponential).unwrap();
        for (a, b) in point.law.as_slice().iter().zip([0.75, 0.5, 0.025]) {
            close(*a, b);
        }
    }

    #[test]
    fn there_and_back() {
        for law in Law::BUILT_IN {
            let machine = machine();
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

    #[test]
    fn critical_values_are_those_of_the_machine_itself() {
        for law in Law::BUILT_IN {
            let here = behaviour(&machine(), &law, 1e-10).unwrap();
            let (Some(speed), Some(damping)) = (here.critical_belt_speed, here.critical_damping) else {
                continue;
            };
            let sticks = |machine: Machine| {
                let flow = flow(&Oscillator::new(&law, &machine.point(&law).unwrap()), 1e-11);
                matches!(flow.fate, Fate::Sticks(_))
            };
            assert!(sticks(Machine { belt_speed: speed * (1.0 - 1e-6), ..machine() }), "{law:?}");
            assert!(!sticks(Machine { belt_speed: speed * (1.0 + 1e-6), ..machine() }), "{law:?}");
            assert!(sticks(Machine { damping: damping * (1.0 - 1e-6), ..machine() }), "{law:?}");
            assert!(!sticks(Machine { damping: damping * (1.0 + 1e-6), ..machine() }), "{law:?}");
            let [slip, stick] = here.slip_and_stick_time.unwrap();
            // While it sticks the mass travels with the belt, at most from end to end of its motion.
            assert!(stick * 0.1 <= 2.0 * here.amplitude.unwrap() && slip > 0.0, "{here:?}");
        }
        let stribeck = behaviour(&machine(), &Law::Stribeck, 1e-10).unwrap();
        assert!(stribeck.critical_belt_speed.is_some() && stribeck.critical_damping.is_some());
    }
}

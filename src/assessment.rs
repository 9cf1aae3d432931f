//! The engineer's assessment of a machine at its working point, in SI units: the speeds and dampings at which
//! it stick-slips and may stick-slip, the motion, its sensitivities, and what is proved.

use crate::behaviour::{Behaviour, behaviour, highest_belt_speed};
use crate::certify::{Decision, Guarantee, TESTS, validated};
use crate::filippov::Oscillator;
use crate::machine::{Machine, Model};
use crate::map::{self, Regime};
use crate::simulate::slip_count::{count_slip_cycles, proves_absence};
use crate::simulate::{critical_damping, flow, sensitivity};

/// Accuracy of the scaled grazing margin.
const TOLERANCE: f64 = 1e-9;

/// Sensitivity of the critical damping to a quantity of the machine.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub(crate) struct Sensitivity {
    /// Name of the quantity, as in configurations.
    pub(crate) quantity: &'static str,
    /// Per cent by which the critical damping (in N s/m) changes when the quantity grows by one per cent.
    pub(crate) critical_damping: f64,
}

/// Weight of one slip speed in the critical damping.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub(crate) struct Influence {
    /// Slip speed, m/s: the middle of one of the equal parts from 0 to the largest on the orbit.
    pub(crate) slip_speed: f64,
    /// Share of this part; the shares add up to 1.
    pub share: f64,
}

/// Verdict of a rigorous test at the working point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub(crate) struct Proof {
    /// Name of the test.
    pub(crate) test: &'static str,
    /// "present", "absent" or "undecided".
    pub(crate) verdict: &'static str,
}

/// The assessment. Speeds in m/s, dampings in N s/m, lengths in m, times in s; of a rotation rad for m and N
/// m for N.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Assessment {
    /// The machine at its working point.
    pub(crate) machine: Machine,
    /// Its behaviour there.
    pub(crate) behaviour: Behaviour,
    /// Belt speed below which it stick-slips from every initial state, at the working damping: steady slip is
    /// unstable. `None` if steady slip is stable at every speed.
    pub(crate) always_below_speed: Option<f64>,
    /// Damping below which it stick-slips from every initial state, at the working speed; `None` if there is
    /// none.
    pub(crate) always_below_damping: Option<f64>,
    /// Period of the attracting motion, s.
    pub(crate) period: Option<f64>,
    /// Half the range of velocities of that motion, m/s.
    pub(crate) velocity_amplitude: Option<f64>,
    /// The sudden changes of velocity with the belt, and against it, that start stick-slip from steady slip.
    pub(crate) kick: Option<[f64; 2]>,
    /// Sensitivities of the critical damping at the working speed.
    pub(crate) sensitivities: Vec<Sensitivity>,
    /// Weights of slip speeds of the friction curve in the critical damping; empty where the polar angle of
    /// the orbit is not monotone in time.
    pub(crate) influence: Vec<Influence>,
    /// Verdicts of the rigorous tests at the working point.
    pub(crate) proofs: Vec<Proof>,
}

impl Assessment {
    /// The working damping in units of the critical one: above 1 no orbit that has left the belt returns to
    /// it.
    pub(crate) fn safety_margin(&self) -> Option<f64> {
        self.behaviour.critical_damping.filter(|d| *d > 0.0).map(|critical| self.machine.damping / critical)
    }
}

/// Assesses a machine; `None` as in [`Machine::model`].
pub(crate) fn assess(machine: &Machine) -> Option<Assessment> {
    let model = machine.model()?;
    let Model { law, point, si } = &model;
    let units = si.units;
    let behaviour = behaviour(&model, TOLERANCE);
    let column = model.column();
    let oscillator = Oscillator::new(law, point);
    let flow = flow(&oscillator, TOLERANCE);
    // Beyond the data of a measured law phi is undefined.
    let weakening = |belt_speed: f64| Some(column.curve.weakening(belt_speed)).filter(|w| !w.is_nan());
    let always_below_speed =
        highest_belt_speed(point.belt_speed, |speed| Some(weakening(speed)? > oscillator.viscous));
    let hopf = column.curve.weakening(point.belt_speed);
    let cycle = map::attracting_cycle(&oscillator, &flow, TOLERANCE);
    let kick = match behaviour.regime {
        Regime::Bistable => map::basin_boundary(&oscillator, &flow, TOLERANCE),
        _ => None,
    };
    let theorems = TESTS.iter().filter(|test| test.guarantee != Guarantee::Asymptotic);
    let proofs = theorems.chain([&validated::TEST]).map(|test| Proof {
        test: test.name,
        verdict: match (test.claim)(&column).decide(point.damping) {
            Decision::Present => "present",
            Decision::Absent => "absent",
            Decision::Undecided => "undecided",
        },
    });
    let mut proofs: Vec<Proof> = proofs.collect();
    // Far from the boundary a count is enough; it takes longer than the tests.
    let undecided = proofs.iter().all(|proof| proof.verdict == "undecided");
    if undecided && proves_absence(&oscillator, &count_slip_cycles(&oscillator)) {
        proofs.push(Proof { test: "number_of_slip_cycles", verdict: "absent" });
    }
    Some(Assessment {
        machine: machine.clone(),
        always_below_speed: always_below_speed.map(|speed| speed * units.velocity),
        always_below_damping: (hopf > 0.0).then_some(hopf * units.damping),
        period: cycle.map(|cycle| cycle.period * units.time),
        velocity_amplitude: cycle.map(|c| 0.5 * (c.velocity.hi - c.velocity.lo) * units.velocity),
        kick: kick.map(|(_, kick)| [kick.forward * units.velocity, kick.backward * units.velocity]),
        sensitivities: sensitivities(machine),
        influence: influence(&model).unwrap_or_default(),
        proofs,
        behaviour,
    })
}

/// Accuracies of the critical damping, and the relative steps of the central differences that go with them:
/// the
/// error of a derivative is the step squared, and the accuracy divided by the step. The second pair is for
/// laws whose orbits cannot be followed to the first accuracy.
const ACCURACIES_AND_STEPS: [(f64, f64); 2] = [(1e-12, 1e-4), (1e-10, 1e-3)];

/// Logarithmic derivatives of the critical damping by each quantity of a machine that is not zero, to about
/// 1e-6; without those for which no critical damping was found next to the machine.
pub(crate) fn sensitivities(machine: &Machine) -> Vec<Sensitivity> {
    let critical = |machine: &Machine, accuracy: f64| -> Option<f64> {
        let model = machine.model()?;
        let root = critical_damping(&model.column(), accuracy).ok()?.c;
        (root > 0.0).then_some(root * model.si.units.damping)
    };
    let here = ACCURACIES_AND_STEPS.map(|(accuracy, _)| critical(machine, accuracy));
    let derivative = |(quantity, value): (&'static str, f64)| {
        let by = |((accuracy, step), here): ((f64, f64), Option<f64>)| {
            let here = here?;
            let at = |factor: f64| critical(&machine.with(quantity, value * factor)?, accuracy);
            let critical_damping = (at(1.0 + step)? - at(1.0 - step)?) / (2.0 * step * here);
            Some(Sensitivity { quantity, critical_damping })
        };
        ACCURACIES_AND_STEPS.into_iter().zip(here).find_map(by)
    };
    let quantities = machine.quantities().into_iter();
    quantities.filter(|(name, value)| *name != "damping" && *value != 0.0).filter_map(derivative).collect()
}

/// Number of parts of the range of slip speeds.
const PARTS: usize = 40;

/// The weight of each slip speed on the grazing orbit at the critical damping; `None` where there is none.
fn influence(model: &Model) -> Option<Vec<Influence>> {
    let parts = sensitivity::influence(&model.column(), PARTS).ok()?;
    let velocity = model.si.units.velocity;
    let of_machine = parts
        .into_iter()
        .map(|part| Influence { slip_speed: 0.5 * (part.from + part.to) * velocity, share: part.share });
    Some(of_machine.collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::Law;
    use crate::machine::example;

    fn machine(law: &Law) -> Machine {
        example(law.clone()).with("strengthening", 0.0).unwrap()
    }

    #[test]
    fn scaling_laws_hold_for_the_sensitivities() {
        // The critical damping is a force divided by a velocity: it grows by one per cent when the forces do
        // (normal force and, at fixed mass times stiffness, nothing else that sets velocities), and by minus
        // one per cent when all velocities do. Times enter through sqrt(k m) alone.
        for law in Law::BUILT_IN {
            let found = assess(&machine(&law)).unwrap().sensitivities;
            let of = |name: &str| found.iter().find(|s| s.quantity == name).unwrap().critical_damping;
            assert!((of("mass") - of("stiffness")).abs() < 1e-5, "{law:?}: {found:?}");
            assert!(found.iter().all(|s| s.quantity != "strengthening"), "it is zero");
            // sqrt(k m), the normal force and the critical damping have the dimensions of a force by a
            // velocity, a force, and a force by a velocity; v and v_s those of a velocity. Forces and
            // velocities may be scaled apart.
            let forces = of("mass") + of("stiffness") + of("normal_force");
            let velocities = -(of("mass") + of("stiffness")) + of("belt_speed") + of("stribeck_velocity");
            assert!((forces - 1.0).abs() < 1e-5, "{law:?}: {forces}");
            assert!((velocities + 1.0).abs() < 1e-5, "{law:?}: {velocities}");
        }
    }

    #[test]
    fn influence_predicts_what_a_change_of_the_law_does() {
        // The weakening of the exponential law is (mu_s - mu_k) / v_s exp(-u / v_s): its derivative by mu_k
        // is known, and its mean with the weight is the derivative of the critical damping. Parts of the
        // range are 1/40 wide, their middles stand for all of them.
        let machine = machine(&Law::Exponential);
        let [kinetic_friction, stribeck_velocity] = [0.3, 0.25];
        let all = assess(&machine).unwrap();
        assert!((all.influence.iter().map(|i| i.share).sum::<f64>() - 1.0).abs() < 1e-12);
        let kinetic = all.sensitivities.iter().find(|s| s.quantity == "kinetic_friction").unwrap();
        let critical = all.behaviour.critical_damping.unwrap();
        let slope = kinetic.critical_damping * critical / kinetic_friction;
        let change = |u: f64| -machine.normal_force / stribeck_velocity * (-u / stribeck_velocity).exp();
        let predicted: f64 = all.influence.iter().map(|i| i.share * change(i.slip_speed)).sum();
        assert!((predicted / slope - 1.0).abs() < 2e-3, "{predicted} {slope}");
    }

    #[test]
    fn the_thresholds_are_those_of_the_machine() {
        for law in Law::BUILT_IN {
            let all = assess(&machine(&law)).unwrap();
            let stable = |name: &str, value: f64| {
                let model = machine(&law).with(name, value).unwrap().model().unwrap();
                Oscillator::new(&model.law, &model.point).eigenvalues().is_stable()
            };
            if let Some(damping) = all.always_below_damping {
                assert!(!stable("damping", 0.999 * damping), "{law:?}");
                assert!(stable("damping", 1.001 * damping), "{law:?}");
            }
            if let Some(belt_speed) = all.always_below_speed {
                assert!(!stable("belt_speed", 0.999 * belt_speed), "{law:?}");
                assert!(stable("belt_speed", 1.001 * belt_speed), "{law:?}");
            }
        }
    }
}

//! The engineer's assessment of a machine at its working point, in SI units: the speeds and dampings at which
//! it stick-slips or may stick-slip, the motion, the sensitivities, and the verdicts of rigorous tests.

mod data_errors;
mod sensitivities;

use crate::behaviour::{self, MachineBehaviour};
use crate::intervals::{self, Limit, TOLERANCE};
pub use crate::intervals::{End, Intervals, Statement};
use crate::method_answer::of_test;
use crate::risk::Uncertain;
use crate::{Dimension, Friction, Machine, Model};
pub use data_errors::{DampingLimit, ErrorsFrom, LeftOpen, StandardErrors, with_errors};
use sensitivities::influence;
pub use sensitivities::sensitivities_to;
pub use sensitivities::{QuantitySensitivity, SpeedInfluence, sensitivities};
use slipmap_certify::{Guarantee, TESTS, validated};
use slipmap_column::crossing::crossing_cycles;
use slipmap_column::slip_cycle::{CyclesUnknown, Kick};
use slipmap_column::{LongRun, Regime, Verdict};
use slipmap_model::filippov::{HopfRate, Oscillator, Stability};
use slipmap_model::flow::{Failure, Fate, Flow};
use slipmap_model::friction::Law;
use slipmap_numbers::text::{rounded, short};
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::flow;

/// Verdict of a rigorous test at the working point.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Proof {
    /// Name of the test.
    pub test: &'static str,
    /// "present", "absent" or "undecided".
    pub verdict: &'static str,
    /// Reason why it is undecided.
    pub reason: Option<String>,
}

/// The known properties of a working point whose regime is not determined, and the reasons why it is not.
#[derive(Clone, Debug, PartialEq)]
pub struct Undetermined {
    /// Whether the stick-slip cycle attracts; `None` if that is unknown.
    pub sticks: Option<bool>,
    /// What small disturbances of steady slip do.
    pub stability: Stability,
    /// The unknown attractors, each with the reason.
    pub reasons: Vec<String>,
}

/// The assessment. Speeds are in m/s, dampings in N s/m, lengths in m, times in s; for a rotation rad
/// replaces m and N m replaces N.
#[derive(Clone, Debug, PartialEq)]
pub struct Assessment {
    /// The machine at its working point.
    pub machine: Machine,
    /// The behaviour at the working point.
    pub behaviour: MachineBehaviour,
    /// The belt speeds at which each of [`Statement::ALL`] holds, at the working damping.
    pub speeds: [Intervals; Statement::ALL.len()],
    /// The dampings at which each of [`Statement::ALL`] holds, at the working speed.
    pub dampings: [Intervals; Statement::ALL.len()],
    /// Belt speed below which it stick-slips from every initial state, at the working damping.
    pub always_below_speed: Limit,
    /// Damping below which it stick-slips from every initial state, at the working speed.
    pub always_below_damping: Limit,
    /// Damping below which steady slip is unstable, at the working speed; it may be negative.
    pub hopf_damping: f64,
    /// Least damping above which steady slip is the only attractor, at the working speed: the largest of the
    /// Hopf damping, the critical damping and the dampings of folds, or zero. `None` where it is unknown.
    pub vibrates_below_damping: Option<f64>,
    /// Slip speed, m/s, up to which measured friction should be known for the highest belt speed at which it may
    /// stick-slip; `None` where that is known.
    pub needed_for_speeds: Option<f64>,
    /// Standard errors that follow from those of the data; `None` where none are known.
    pub standard_errors: Option<StandardErrors>,
    /// Reason why slip cycles are unknown where the regime is known but not all that depends on them.
    pub slip_cycles_unknown: Option<String>,
    /// The known properties where the regime is not determined; `None` where it is.
    pub undetermined: Option<Undetermined>,
    /// Period of the attracting motion, s.
    pub period: Option<f64>,
    /// Half the range of velocities of the attracting motion, m/s.
    pub velocity_amplitude: Option<f64>,
    /// Severity of the attracting motion: (largest - smallest) / (2 mean) of the slip speed, which is the speed of
    /// a bit that turns in rock at rest. Its mean is the belt speed.
    pub severity: Option<f64>,
    /// Kicks, m/s, of steady slip onto the outermost unstable slip cycle; slightly larger ones start the
    /// motion.
    pub kick: Option<Kick>,
    /// The part of the stick phase, s, in which any disturbance against the belt ends stick-slip: how long
    /// before the end of the phase it begins, and how long it lasts. `None` where there is none.
    pub fragile: Option<[f64; 2]>,
    /// Sensitivities of the critical damping at the working speed.
    pub sensitivities: Vec<QuantitySensitivity>,
    /// Weights of slip speeds of the friction curve in the critical damping; empty where the polar angle of
    /// the orbit is not monotone in time.
    pub influence: Vec<SpeedInfluence>,
    /// Verdicts of the rigorous tests at the working point.
    pub proofs: Vec<Proof>,
}

/// The kick of steady slip that starts the motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum NeededKick {
    /// A kick slightly larger than this one.
    Kick(Kick),
    /// The motion starts by itself.
    NotNeeded,
    /// No kick of steady slip starts it.
    None,
    /// Whether there is one is not determined, or the errors of the data leave it open.
    NotDetermined,
}

impl Assessment {
    /// The kick from steady slip that starts stick-slip.
    pub fn needed_kick(&self) -> NeededKick {
        match (self.kick, self.behaviour.regime) {
            _ if self.is_left_open() => NeededKick::NotDetermined,
            (Some(kick), _) => NeededKick::Kick(kick),
            (None, Regime::StickSlip | Regime::PureSlip | Regime::Crossing) => NeededKick::NotNeeded,
            (None, Regime::Equilibrium) => NeededKick::None,
            // A cycle that crosses the belt line may be started by a kick that is not computed.
            (None, _) => NeededKick::NotDetermined,
        }
    }

    /// The damping above which it stick-slips from no start: the end of the highest interval in which it may. That is the
    /// critical damping, unless at every damping below that orbits cross the belt line for ever.
    pub fn may_stick_below_damping(&self) -> Limit {
        let intervals = &self.dampings[Statement::MayStick as usize];
        match (self.behaviour.critical_damping, intervals.holds.last()) {
            (None, _) if self.behaviour.critical_damping_is_known => Limit::NoneUpTo(0.0),
            (None, _) => Limit::NotDetermined,
            (Some(_), Some([_, End::At { value, .. }])) => Limit::Below(*value),
            (Some(_), _) => intervals.highest(),
        }
    }

    /// The working damping divided by the critical damping: above 1 no orbit that has left the belt returns.
    pub fn safety_margin(&self) -> Option<f64> {
        self.behaviour.critical_damping.filter(|d| *d > 0.0).map(|critical| self.machine.damping / critical)
    }
}

/// Relative distance up to which two limits are taken as equal.
const SAME: f64 = 1e-6;

/// The reason why the orbit of measured friction fails: the data end. States how far they should reach.
fn beyond_data(machine: &Machine, behaviour: &MachineBehaviour) -> Option<String> {
    let Friction::Measured(table) = &machine.friction else { return None };
    let unit = machine.motion.unit(Dimension::Velocity);
    let (end, needed) = (short(table.fastest()), rounded(behaviour.needed_slip_speed?, 3));
    Some(format!(
        "the orbit leaves the data, which end at slip speed {end} {unit}; measure up to about {needed} {unit}"
    ))
}

/// The reason why cycles are unknown; `beyond_data`, if any, where their orbits leave the data.
fn why_unknown(why: CyclesUnknown, beyond_data: Option<&String>) -> String {
    let beyond = beyond_data.filter(|_| why == CyclesUnknown::Orbit(Failure::NotFinite));
    beyond.map_or_else(|| why.to_string(), Clone::clone)
}

/// The known properties of a working point. `beyond_data`, if any, is the reason why its orbits fail.
fn undetermined(
    oscillator: &Oscillator,
    flow: &Flow,
    slip: Option<CyclesUnknown>,
    beyond_data: Option<&String>,
) -> Undetermined {
    let mut reasons = Vec::new();
    if let Fate::Failed(why) = flow.fate {
        reasons.push(format!("stick-slip: {}", beyond_data.map_or_else(|| why.to_string(), Clone::clone)));
    }
    if let Some(why) = slip {
        reasons.push(format!("slip cycles: {}", why_unknown(why, beyond_data)));
    }
    let far = FarLoops::where_friction_resists(&oscillator.curve, oscillator.belt_speed);
    if let Some(why) = crossing_cycles(oscillator, &far, TOLERANCE).unknown {
        reasons.push(format!("crossing cycles: {}", why_unknown(why, beyond_data)));
    }
    let sticks = Verdict::from(&flow.fate).presence();
    Undetermined { sticks, stability: oscillator.stability(), reasons }
}

/// Without damping two coefficients make circles around steady slip: one that reaches the belt speed sticks.
fn undamped_kick(machine: &Machine, flow: &Flow) -> Option<Kick> {
    let Friction::Coefficients(Law::Coulomb, of) = &machine.friction else { return None };
    let is_circle = machine.damping == 0.0 && of.strengthening == 0.0;
    let speed = machine.belt_speed;
    (is_circle && matches!(flow.fate, Fate::Sticks(_))).then_some(Kick { forward: speed, backward: speed })
}

/// Assesses a machine; `None` as in [`Machine::model`].
pub fn assess(machine: &Machine) -> Option<Assessment> {
    assess_fitted(machine, &[])
}

/// Assesses a machine whose friction may be a fit: its covariance is among the `uncertain` quantities.
pub fn assess_fitted(machine: &Machine, uncertain: &[Uncertain]) -> Option<Assessment> {
    let model = machine.model()?;
    let Model { law, point, si: units } = &model;
    let column = model.column();
    let oscillator = Oscillator::new(law, point);
    let flow = flow(&oscillator, TOLERANCE);
    // One backbone serves all dampings.
    let attractors = slipmap_column::Behaviour::new(&column.curve, column.belt_speed);
    let long_run = attractors.long_run(&oscillator, &flow, TOLERANCE);
    let (behaviour, stick_slip) = behaviour::with_speeds(&model, &flow, &long_run, TOLERANCE);
    let LongRun { cycle, basin, slip, .. } = long_run;
    let hopf = HopfRate::new(&column.curve, column.belt_speed).value();
    let theorems = TESTS.iter().filter(|test| test.guarantee != Guarantee::Asymptotic);
    let proofs = theorems.chain([&validated::TEST]).map(|test| {
        let answer = of_test(test, &column, point.damping);
        Proof { test: test.name, verdict: answer.verdict.name(), reason: answer.reason }
    });
    let proofs: Vec<Proof> = proofs.collect();
    let (dampings, vibrates_below) = intervals::of_dampings(&attractors, units.damping / point.epsilon);
    let has_kick = basin.is_some()
        || matches!(
            behaviour.regime,
            Regime::Equilibrium | Regime::PureSlip | Regime::StickSlip | Regime::Crossing
        );
    let beyond_data = beyond_data(machine, &behaviour);
    let is_missing = vibrates_below.is_none() || !has_kick;
    let slip_cycles_unknown = is_missing
        .then(|| {
            slip.as_ref().err().copied().or_else(|| attractors.backbone().err().map(CyclesUnknown::from))
        })
        .flatten()
        .map(|why| format!("slip cycles: {}", why_unknown(why, beyond_data.as_ref())));
    let highest = stick_slip.holds.last().map(|[_, end]| *end);
    // Orbits of faster belts may leave the data, at once or beyond speeds at which it does not stick-slip.
    let needed_for_speeds = match highest {
        Some(End::Open(from)) => behaviour::needed_for_stick_slip(law, point, from, true),
        _ => {
            let unknown = stick_slip.unknown.last().map(|ends| ends[1]);
            unknown
                .filter(|end| highest.is_none_or(|highest| *end > highest.value()))
                .and_then(|end| behaviour::needed_for_stick_slip(law, point, end, false))
        }
    };
    let highest = highest.and_then(|end| Some(end.located()?[0] * units.velocity));
    let speeds = intervals::of_speeds(law, point, units.velocity, stick_slip);
    Some(Assessment {
        machine: machine.clone(),
        always_below_speed: speeds[Statement::AlwaysSticks as usize].lowest(),
        always_below_damping: match hopf > 0.0 {
            true => dampings[Statement::AlwaysSticks as usize].lowest(),
            // Steady slip attracts at every damping above 0.
            false => Limit::NoneUpTo(0.0),
        },
        speeds,
        dampings,
        hopf_damping: hopf / point.epsilon * units.damping,
        vibrates_below_damping: vibrates_below,
        slip_cycles_unknown,
        standard_errors: StandardErrors::of(machine, uncertain, highest, basin.is_some()),
        needed_for_speeds: needed_for_speeds.map(|speed| speed * units.velocity),
        undetermined: matches!(behaviour.regime, Regime::Failed | Regime::Neutral)
            .then(|| undetermined(&oscillator, &flow, slip.err(), beyond_data.as_ref())),
        period: cycle.map(|cycle| cycle.period * units.time),
        velocity_amplitude: cycle.map(|c| 0.5 * (c.velocity.hi - c.velocity.lo) * units.velocity),
        severity: cycle.map(|cycle| 0.5 * (cycle.velocity.hi - cycle.velocity.lo) / column.belt_speed),
        fragile: basin
            .and_then(|basin| basin.fragile_time)
            .map(|lasts| [column.curve.drop() / column.belt_speed, lasts].map(|time| time * units.time)),
        kick: basin
            .map(|slipmap_column::BasinBoundary { kick, .. }| Kick {
                forward: kick.forward * units.velocity,
                backward: kick.backward * units.velocity,
            })
            .or_else(|| undamped_kick(machine, &flow)),
        sensitivities: sensitivities(machine),
        influence: influence(&model).unwrap_or_default(),
        proofs,
        behaviour,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Friction, example, example_of, formula};
    use slipmap_column::slip_cycles;
    use slipmap_model::friction::Table;
    use slipmap_model::point::Point;
    use slipmap_numbers::random::Random;

    fn regime_at(law: &Law, point: &Point) -> Regime {
        let oscillator = Oscillator::new(law, point);
        slipmap_column::regime(&oscillator, &flow(&oscillator, TOLERANCE))
    }

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
            // Coulomb's law has no Stribeck velocity.
            let of =
                |name: &str| found.iter().find(|s| s.quantity == name).map_or(0.0, |s| s.critical_damping);
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

    /// Next to a limit of a quantity both steps are on the side that is legal. The derivatives that one orbit has are others.
    #[test]
    fn sensitivities_next_to_limits_are_those_of_the_orbit() {
        for exponent in [1.0, 1.000_05, 7.0, 100.0] {
            let machine = machine(&Law::Stretched).with("exponent", exponent).unwrap();
            let found = sensitivities(&machine);
            let found = found.iter().find(|it| it.quantity == "exponent").unwrap();
            let Model { law, point, .. } = machine.model().unwrap();
            let of_orbit = slipmap_column::sensitivity::sensitivity(&law.column(&point)).unwrap();
            let (_, by_exponent) = of_orbit.named(&law).find(|(name, _)| *name == "exponent").unwrap();
            let expected = exponent * by_exponent.value / of_orbit.critical.c;
            let off = (found.critical_damping - expected).abs();
            assert!(off <= found.critical_damping_error, "{exponent}: {found:?} {expected}");
        }
        // Kinetic friction that is all but static: a step of either leads beyond the other.
        let static_friction = machine(&Law::Stretched).friction.at_rest();
        let equal =
            machine(&Law::Stretched).with("kinetic_friction", static_friction * (1.0 - 1e-5)).unwrap();
        sensitivities(&equal);
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
    fn nothing_vibrates_above_the_last_limit() {
        // Steady slip is unstable beyond the critical damping: a slip cycle attracts there.
        let bell = example_of(formula("0.25 + 0.15*exp(-(u/0.05)^2)"), [2.0, 5e5, 1000.0, 0.06, 4.0]);
        let mut beyond_critical = 0;
        for machine in Law::BUILT_IN.iter().map(machine).chain([bell]) {
            let all = assess(&machine).unwrap();
            let limit = all.vibrates_below_damping.unwrap();
            let regime = |damping: f64| {
                let model = machine.with("damping", damping).unwrap().model().unwrap();
                regime_at(&model.law, &model.point)
            };
            assert_eq!(regime(1.001 * limit), Regime::Equilibrium, "{machine:?}");
            assert_ne!(regime(0.999 * limit), Regime::Equilibrium, "{machine:?}");
            beyond_critical += i32::from(all.behaviour.critical_damping.is_some_and(|it| limit > 1.01 * it));
        }
        assert!(beyond_critical > 0);
    }

    #[test]
    fn the_hopf_damping_has_the_errors_of_the_data() {
        let errors = [0.001, 0.004, 0.002, 0.005, 0.003, 0.004];
        let data = [(0.0, 0.4), (0.05, 0.36), (0.12, 0.33), (0.3, 0.31), (0.8, 0.3), (2.0, 0.3)];
        let of = |data: &[(f64, f64)]| {
            let table = Table::new("a test", data, data[0].1).unwrap().with_standard_errors(&errors).unwrap();
            let friction = Friction::Measured(table);
            Machine { friction, belt_speed: 0.15, ..example(Law::Stribeck) }
        };
        let hopf = |machine: &Machine| {
            let model = machine.model().unwrap();
            let column = model.column();
            HopfRate::new(&column.curve, column.belt_speed).value() * model.si.damping
        };
        let here = assess(&of(&data)).unwrap();
        let moved = errors.iter().enumerate().map(|(i, error)| {
            let mut data = data;
            data[i].1 += 1e-3 * error;
            1e3 * (hopf(&of(&data)) - here.hopf_damping)
        });
        let expected = moved.map(|moved| moved * moved).sum::<f64>().sqrt();
        let found = here.standard_error_of(here.hopf_damping).unwrap();
        // The slope is linear in the data but where they are not monotone.
        assert!((found / expected - 1.0).abs() < 1e-2 && found > 0.0, "{found} {expected}");
        let critical = here.behaviour.critical_damping.unwrap();
        assert!(here.standard_error_of(critical).is_some_and(|error| error != found));
        assert_eq!(here.standard_error_of(0.5 * critical), None);
    }

    #[test]
    fn limits_of_the_speed_do_not_depend_on_the_working_speed() {
        let data = [(0.0, 0.4), (0.05, 0.36), (0.12, 0.33), (0.3, 0.31), (0.8, 0.3), (2.0, 0.3)];
        let table = Table::new("a test", &data, data[0].1).unwrap();
        let machines = [
            machine(&Law::Exponential),
            Machine { friction: formula("0.25 + 0.15*exp(-(u/0.05)^2)"), ..machine(&Law::Stribeck) },
            Machine { friction: Friction::Measured(table), ..machine(&Law::Stribeck) },
        ];
        for machine in machines {
            let limits = [0.0213, 0.1, 0.47].map(|speed| {
                let all = assess(&machine.with("belt_speed", speed).unwrap()).unwrap();
                (all.always_below_speed, all.behaviour.critical_belt_speed)
            });
            assert!(limits.iter().all(|of| *of == limits[0]), "{limits:?}");
            assert!(matches!(limits[0].1, Limit::Below(_)), "{limits:?}");
        }
    }

    /// A table that falls steeply from rest, with scatter: orbits over its first rows are outside the polar
    /// form and exhaust the budget of an accurate backbone.
    #[test]
    fn a_steep_noisy_table_has_kicks_and_limits() {
        let speeds = [
            0.0, 0.003, 0.0038927, 0.0050511, 0.0065542, 0.0085046, 0.011035, 0.014319, 0.01858, 0.024109,
            0.031284, 0.040593, 0.052673, 0.068347, 0.088685, 0.11508, 0.14932, 0.19375, 0.25141, 0.32622,
            0.4233, 0.54927, 0.71271, 0.9248, 1.2,
        ];
        let friction = [
            0.451, 0.4459, 0.4384, 0.4356, 0.43430, 0.4253, 0.4208, 0.4159, 0.407, 0.3943, 0.3831, 0.359,
            0.3541, 0.3326, 0.3145, 0.3078, 0.298, 0.2882, 0.2828, 0.2857, 0.2864, 0.2938, 0.2924, 0.2943,
            0.3022,
        ];
        let data: Vec<(f64, f64)> = speeds.into_iter().zip(friction).collect();
        let friction = Friction::Measured(Table::new("a pad", &data, data[0].1).unwrap());
        let machine = example_of(friction, [1.8, 4.2e5, 900.0, 0.1, 300.0]);
        let all = assess(&machine).unwrap();
        assert_eq!(all.behaviour.regime, Regime::Bistable);
        assert_eq!(all.slip_cycles_unknown, None);
        // No slip cycle lies beyond the grazing orbit: the critical damping is the last limit.
        assert_eq!(all.vibrates_below_damping, all.behaviour.critical_damping);
        let Model { law, point, .. } = machine.model().unwrap();
        let oscillator = Oscillator::new(&law, &point);
        let cycles = slip_cycles(&oscillator, &flow(&oscillator, TOLERANCE), TOLERANCE).unwrap();
        // By turns of another program, with the interpolation and the method of Runge and Kutta of SciPy.
        assert!(cycles.len() == 1 && !cycles[0].is_stable(), "{cycles:?}");
        assert!((cycles[0].velocity.hi - 0.046_691_803).abs() < 2e-9, "{cycles:?}");
        let kick = all.kick.unwrap();
        assert!(kick.forward > 0.02 && kick.forward < 0.025, "{kick:?}");
    }

    /// Steps between scattered rows make most orbits overdamped somewhere; all of them close.
    #[test]
    fn scattered_data_leave_nothing_undetermined() {
        let mut random = Random(3);
        let data: Vec<(f64, f64)> = (0..197)
            .map(|i| {
                let u = 1.2 * f64::from(i) / 196.0;
                (u, 0.25 + 0.18 * (-u / 0.08).exp() + 0.01 * u + 0.006 * random.normal())
            })
            .collect();
        let friction = Friction::Measured(Table::new("a ramp", &data, data[0].1).unwrap());
        let machine = example_of(friction, [2.0, 5e5, 1000.0, 0.15, 30.0]);
        let Model { law, point, .. } = machine.model().unwrap();
        let oscillator = Oscillator::new(&law, &point);
        let flow = flow(&oscillator, TOLERANCE);
        let slip = slipmap_column::slip_cycles(&oscillator, &flow, TOLERANCE).err();
        let found = undetermined(&oscillator, &flow, slip, None);
        assert_eq!(found.sticks, Some(true), "{found:?}");
        assert!(found.reasons.is_empty(), "{found:?}");
    }

    /// Friction that rises at first, falls, and rises again with a viscous part.
    fn stribeck_curve() -> Machine {
        let friction = formula("0.1 + 0.05*exp(-(u/0.005)^2) + 0.5*u*exp(-u/1e-4) + 0.4*u");
        example_of(friction, [20.0, 1e6, 200.0, 0.002, 30.0])
    }

    /// The intervals against the regimes at values of their own.
    #[test]
    fn intervals_hold_inside_and_not_outside() {
        let mut windows = 0;
        for machine in [machine(&Law::Exponential), stribeck_curve()] {
            let all = assess(&machine).unwrap();
            for (name, intervals) in [("belt_speed", &all.speeds), ("damping", &all.dampings)] {
                let within = |of: &Intervals, value: f64| {
                    let inside = |ends: &[End; 2]| ends[0].value() <= value && value <= ends[1].value();
                    of.holds.iter().any(inside)
                };
                let [least, most] = intervals[0].tried.map(|end| end.max(1e-3 * machine.damping));
                for i in 0..40 {
                    let value = least * (most / least).powf((f64::from(i) + 0.5) / 40.0);
                    let model = machine.with(name, value).unwrap().model().unwrap();
                    let regime = regime_at(&model.law, &model.point);
                    let attractors = regime.attractors();
                    let truth = [
                        regime == Regime::StickSlip,
                        attractors.stick_slip,
                        attractors.slip,
                        attractors.crossing,
                    ];
                    assert_eq!(intervals.each_ref().map(|of| within(of, value)), truth, "{name} {value}");
                }
                let starts = intervals.iter().flat_map(|of| &of.holds).filter_map(|ends| ends[0].located());
                windows += starts.filter(|[value, error]| *error < 5e-6 * value).count();
            }
        }
        // Of the Stribeck curve all three begin at speeds above 0, and slip cycles at a damping above 0.
        assert!(windows >= 4, "{windows}");
    }

    /// Two ends of closed form: v_s ln(N (mu_s - mu_k) / (v_s d)) where steady slip becomes stable, and of two
    /// coefficients lambda (mu_s - mu_k) N / sqrt(k m), with lambda at the damping ratio 0.05 to 15 digits.
    #[test]
    fn ends_of_intervals_have_their_errors() {
        let near = |[value, error]: [f64; 2], expected: f64| {
            assert!((value - expected).abs() <= error && error <= 5e-6 * value, "{value} {error} {expected}");
        };
        let end = |all: &Assessment, statement: Statement| {
            all.speeds[statement as usize].holds.last().unwrap()[1].located().unwrap()
        };
        let falls = assess(&machine(&Law::Exponential)).unwrap();
        // N (mus - muk) / (v_s d) is 50 * 0.1 / (0.25 * 4).
        near(end(&falls, Statement::AlwaysSticks), 0.25 * 5_f64.ln());
        let coulomb = assess(&machine(&Law::Coulomb)).unwrap();
        // sqrt(k m) = 40 N s/m: the damping ratio of 4 N s/m is 0.05.
        near(end(&coulomb, Statement::MayStick), 1.098_092_624_115_87 * 50.0 * 0.1 / 40.0);
        assert!(coulomb.speeds[Statement::AlwaysSticks as usize].holds.is_empty());
    }

    /// On a fast belt orbits cross the belt line for ever but at dampings in a narrow window below the critical one.
    #[test]
    fn what_overtakes_the_belt_for_ever_does_not_stick_slip() {
        let like = machine(&Law::Exponential).with("kinetic_friction", 0.1).unwrap();
        let fast = like.with("stribeck_velocity", 25.0).unwrap().with("belt_speed", 75.0).unwrap();
        let all = assess(&fast.with("damping", 0.02).unwrap()).unwrap();
        let critical = all.behaviour.critical_damping.unwrap();
        let [[from, to]] = all.dampings[Statement::MayStick as usize].holds[..] else {
            panic!("{:?}", all.dampings)
        };
        let ([from, _], [to, error]) = (from.located().unwrap(), to.located().unwrap());
        assert!(
            0.9 * critical < from && from < to && (to - critical).abs() <= error,
            "{from} {to} {critical}"
        );
        let sticks = |damping: f64| {
            let model = fast.with("damping", damping).unwrap().model().unwrap();
            regime_at(&model.law, &model.point).attractors().stick_slip
        };
        let dampings = [0.02, 0.9999 * from, 1.0001 * from, 0.9999 * to, 1.0001 * to];
        assert_eq!(dampings.map(sticks), [false, false, true, true, false]);
        assert_eq!(all.may_stick_below_damping(), Limit::Below(to));
    }

    /// Undamped circles around steady slip stick from the belt speed on.
    #[test]
    fn undamped_coefficients_need_a_kick_of_the_belt_speed() {
        let machine = Machine { damping: 0.0, ..example(Law::Coulomb) }.with("strengthening", 0.0).unwrap();
        let all = assess(&machine).unwrap();
        let NeededKick::Kick(kick) = all.needed_kick() else { panic!("{:?}", all.needed_kick()) };
        assert_eq!([kick.forward, kick.backward], [machine.belt_speed; 2]);
    }

    /// At ten times the unit of speed an orbit of this cubic takes more than a small effort: the even part decides.
    #[test]
    fn a_theorem_decides_where_an_orbit_takes_too_long() {
        let cubic = formula("0.4 - 0.225*(2*u - (2*u)^3/3)");
        let all = assess(&example_of(cubic, [1.0, 1.0, 1.0, 0.42, 0.1])).unwrap();
        let Limit::Below(speed) = all.behaviour.critical_belt_speed else {
            panic!("{:?}", all.behaviour.critical_belt_speed)
        };
        // Thomsen and Fidlin's v_b0, by a critical damping equal to the damping.
        assert!((speed - 0.395_790_28).abs() < 1e-7, "{speed}");
    }

    /// Friction that falls in a straight line is neutral at one damping, which is tried and is the limit.
    #[test]
    fn a_limit_that_is_tried_is_no_gap() {
        let machine = example_of(formula("1 - u"), [1.0, 1.0, 1.0, 0.45, 0.3]);
        let all = assess(&machine).unwrap();
        assert_eq!(all.behaviour.regime, Regime::StickSlip);
        let of = &all.dampings[Statement::AlwaysSticks as usize];
        assert!(of.unknown.is_empty(), "{of:?}");
        assert!(
            matches!(of.holds.last(), Some([_, End::At { value, .. }]) if (value - 1.0).abs() < 1e-4),
            "{of:?}"
        );
    }
}

//! Friction that drops as slip begins (theory, "Breakaway"): closed forms, tables in extended precision, and limits.
//! Random laws with a drop are among those of the test over every engine.

use std::f64::consts::TAU;

use slipmap::certify::curve;
use slipmap::certify::symmetric;
use slipmap::column::critical_damping;
use slipmap::filippov::Oscillator;
use slipmap::flow::Fate;
use slipmap::friction::{Column, Curve, Expression, Law};
use slipmap::orbits::flow;
use slipmap::witness::{self, Ending, Phase, Start, trace};

use crate::crossing::{Loop, crossing_loop};
use crate::runge_kutta::step;
use crate::sample::{Random, Sampling, at_one, returns};

fn column(law: &Law, parameters: &[f64], belt_speed: f64) -> Column {
    law.column(&law.point(1.0, parameters, belt_speed, 0.0).unwrap())
}

fn coulomb(drop: f64, belt_speed: f64) -> Column {
    column(&Law::Coulomb, &[drop, 0.0], belt_speed)
}

fn formula(text: &str, level: f64) -> Law {
    Law::Expression(Expression::with_static(text, level).unwrap())
}

/// Two coefficients: damping ratio, and V/j at which it is the critical one, computed with 150 bits from the
/// closed form.
const TWO_COEFFICIENTS: [[f64; 2]; 7] = [
    [0.001, 8.893_273_134_421_56],
    [0.01, 2.739_240_416_787_74],
    [0.02, 1.883_279_914_472_74],
    [0.05, 1.098_092_624_115_87],
    [0.1, 0.680_217_603_892_278],
    [0.2, 0.366_973_926_704_089],
    [0.5, 0.082_063_104_590_103_7],
];

#[test]
fn two_coefficients_have_the_closed_critical_damping() {
    for [ratio, speed] in TWO_COEFFICIENTS {
        for drop in [0.02, 0.5, 0.9] {
            let column = coulomb(drop, speed * drop);
            let found = critical_damping(&column, 1e-13).unwrap();
            let missed = (found.c - 2.0 * ratio).abs();
            assert!(missed <= 1e-12 && missed <= found.error + 1e-14, "{ratio} {drop}: {found:?}");
            // At this distance from the boundary every engine is right.
            for (factor, back) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
                let oscillator = Oscillator::in_column(&column, 2.0 * ratio * factor);
                let fates = [flow(&oscillator, 1e-13).fate, witness::flow(&oscillator, 1e-13).fate];
                for fate in fates {
                    assert_eq!(returns(&fate), Some(back), "{ratio} {drop} {factor}: {fates:?}");
                }
            }
            let proof = curve::prove(&column).critical();
            assert!(proof.lo <= 2.0 * ratio + 1e-14 && 2.0 * ratio - 1e-14 <= proof.hi, "{ratio}: {proof:?}");
            assert!(proof.hi - proof.lo < 5e-6 * ratio, "{ratio} {drop}: {proof:?}");
        }
    }
    // As damping vanishes, V/j -> 1 / sqrt(4 pi zeta).
    let zeta: f64 = 1e-7;
    let found = critical_damping(&coulomb(0.1, 0.1 / (2.0 * TAU * zeta).sqrt()), 1e-12).unwrap();
    assert!((found.c / (2.0 * zeta) - 1.0).abs() < 1e-3, "{found:?}");
}

/// A law that drops and falls: c* and C(V), the damping at which the orbit through (V, 0) closes, computed with
/// 150 bits.
const WITH_A_FALL: [[f64; 3]; 4] = [
    [0.2, 0.384_512_018_599, 0.273_521_183_196],
    [0.5, 0.190_135_702_572, 0.166_291_675_432],
    [1.0, 0.092_766_515_918, 0.086_058_195_709],
    [2.0, 0.037_514_153_700, 0.035_731_251_403],
];

#[test]
fn a_law_that_drops_and_falls_is_that_of_the_table() {
    let law = formula("0.6 + 0.2*exp(-u/0.5)", 1.0);
    for [belt_speed, critical, grazing] in WITH_A_FALL {
        let with = column(&law, &[], belt_speed);
        let without = Column { curve: with.curve.without_drop(), ..with.clone() };
        for (column, known) in [(with, critical), (without, grazing)] {
            let found = critical_damping(&column, 1e-13).unwrap();
            assert!((found.c - known).abs() <= 1e-12, "{belt_speed}: {found:?} {known}");
        }
    }
}

/// The orbit that grazes the belt line at (V, 0), followed backward for one turn: g, where it left the line at x2' =
/// -g. By the Lienard form and the classical Runge-Kutta method.
fn backward_turn(curve: &Curve, belt_speed: f64, c: f64, steps: u32) -> f64 {
    let rate = |[v, w]: [f64; 2]| [-w, v - (curve.weakening((belt_speed - v).max(0.0)) - c) * w];
    let h = TAU / f64::from(steps);
    let mut state = step(&rate, [belt_speed, 0.0], h);
    for _ in 0..2 * steps {
        let next = step(&rate, state, h);
        if next[0] >= belt_speed {
            break;
        }
        state = next;
    }
    // Newton's method for the time to the line.
    for _ in 0..6 {
        state = step(&rate, state, (belt_speed - state[0]) / -state[1]);
    }
    -state[1]
}

/// In the band above C(V) the backward turn from the line leads to the smallest drop that sustains stick-slip.
#[test]
fn the_backward_turn_is_the_inverse_of_the_critical_damping() {
    for (law, parameters, belt_speed) in [
        (Law::Exponential, vec![0.4, 0.5, 0.02], 0.7),
        (Law::Stribeck, vec![0.3, 0.05, 2.0], 1.5),
        (Law::Lorentzian, vec![0.5, 0.8, 0.0], 0.6),
    ] {
        let base = column(&law, &parameters, belt_speed);
        let grazing = critical_damping(&base, 1e-13).unwrap().c;
        let dropping = law.with_drop();
        let with = |drop: f64| {
            let all: Vec<f64> = parameters.iter().copied().chain([drop]).collect();
            critical_damping(&column(&dropping, &all, belt_speed), 1e-12).unwrap().c
        };
        let mut before = grazing;
        for drop in [0.01, 0.1, 0.3] {
            let critical = with(drop);
            assert!(critical > before, "C(V) < eps c*, which rises with the drop");
            before = critical;
            let g = backward_turn(&base.curve, belt_speed, critical, 4000);
            assert!((g - drop).abs() < 1e-9, "{g} {drop}");
        }
    }
}

/// Stick-slip and an attractor outside without a repelling crossing cycle between: at the orbit through the far end
/// of the stick segment the return map jumps. Distances are those of the slip system, x2' below the line.
#[test]
fn loops_may_lead_outward_where_nothing_repels() {
    let law = formula("0.7 + 1.54255992*(exp(-u/0.0270794132) - 1)", 1.0);
    let oscillator = at_one(&law, &[], 5.899_526_36, 0.02);
    let drop = oscillator.drop();
    let end = |y: f64| match crossing_loop(&oscillator, y - drop, 1e-11).unwrap() {
        Loop::Crosses(beyond_exit) => Some(beyond_exit + drop),
        Loop::Sticks => None,
        Loop::SpiralsInward => panic!("it returns"),
    };
    let (mut sticks, mut crosses) = (drop, 0.4);
    while crosses - sticks > 1e-9 {
        let middle = 0.5 * (sticks + crosses);
        *(if end(middle).is_some() { &mut crosses } else { &mut sticks }) = middle;
    }
    assert!((crosses - 0.365_457_1).abs() < 1e-7, "{crosses}");
    let beyond = end(crosses).unwrap();
    assert!((beyond - 1.707_6).abs() < 5e-4, "{beyond}");
}

/// The witness leaves the exit point with x2' = -j, and the mass sticks longer than friction in slip could hold it:
/// from the landing to the place where friction at rest is exhausted.
#[test]
fn a_mass_sticks_until_friction_at_rest_is_exhausted() {
    let (drop, belt_speed) = (0.4, 1.0);
    let oscillator = Oscillator::in_column(&coulomb(drop, belt_speed), 0.02);
    let cycle = trace(&oscillator, Start::ExitPoint, 1e-12, 100.0);
    let Ending::Closes { period } = cycle.ending else { panic!("{:?}", cycle.ending) };
    let Fate::Sticks(landing) = flow(&oscillator, 1e-12).fate else { panic!("it sticks") };
    assert!((landing.slip_time + landing.stick_time - period).abs() < 1e-9, "{landing:?} {period}");
    let held = cycle.samples.iter().find(|sample| sample.phase == Phase::Stick).unwrap();
    assert!((held.x1 - landing.x1).abs() < 1e-9, "{held:?} {landing:?}");
    // It sticks for (wL + j)/V, and slides from friction at rest.
    let last = cycle.samples.last().unwrap();
    assert!((last.x1 - oscillator.exit_x1()).abs() < 1e-12, "{last:?}");
    assert!(landing.stick_time > drop / belt_speed);
    // Held against friction in slip: x1 between 1 - j and 1 on the belt line.
    let x1 = oscillator.exit_x1() - 0.5 * drop;
    let held = trace(&oscillator, Start::State { x1, x2: belt_speed }, 1e-9, 10.0);
    assert_eq!(held.samples[0].phase, Phase::Stick);
    assert!((held.samples[1].t - 0.5 * drop / belt_speed).abs() < 1e-12);
}

/// The test `symmetric` denies a cycle with a drop beyond its own edge without one; between the two there are cycles.
#[test]
fn absence_by_the_even_part_takes_more_damping_with_a_drop() {
    let (mut seen, mut random) = (0, Random(4802));
    while seen < 50 {
        let belt_speed = random.log(0.1, 3.0);
        let parameters = [random.unit(), random.log(0.2, 2.0), 0.0];
        let drop = (0.5 * random.unit()).min(0.5 * belt_speed);
        let base = Law::Exponential;
        let without = symmetric::TEST.claim(&column(&base, &parameters, belt_speed));
        let dropping = column(&base.with_drop(), &[parameters[0], parameters[1], 0.0, drop], belt_speed);
        let with = symmetric::TEST.claim(&dropping);
        assert_eq!(with.present_below, without.present_below);
        assert!(
            with.absent_above > without.absent_above,
            "{parameters:?} {belt_speed} {drop}: {with:?} {without:?}"
        );
        let critical = critical_damping(&dropping, 1e-11).unwrap();
        assert!(critical.c < with.absent_above, "{critical:?} {with:?}");
        seen += u32::from(critical.c > without.absent_above);
    }
}

//! Friction that drops as slip begins (theory, "Breakaway"): closed forms, tables in extended precision, limits,
//! and every engine and test against the others on random laws.

use std::f64::consts::TAU;

use slipmap::certify::validated::any_law;
use slipmap::certify::{Decision, Guarantee, TESTS, symmetric, validated};
use slipmap::filippov::Oscillator;
use slipmap::friction::{Column, Curve, Expression, Law, Table};
use slipmap::simulate::{Fate, critical_damping, flow};
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

/// What a fate says of a stick-slip cycle; `None` where it says nothing.
fn says(fate: &Fate) -> Option<Decision> {
    match fate {
        Fate::Sticks(_) => Some(Decision::Present),
        Fate::SpiralsInward | Fate::CrossesForever => Some(Decision::Absent),
        Fate::TooCloseToCall | Fate::Failed(_) => None,
    }
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
fn two_coefficients_have_the_critical_damping_of_the_closed_form() {
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
            let proof = any_law::prove(&column).critical;
            assert!(proof.lo <= 2.0 * ratio + 1e-14 && 2.0 * ratio - 1e-14 <= proof.hi, "{ratio}: {proof:?}");
            assert!(proof.hi - proof.lo < 1e-11, "{ratio} {drop}: {proof:?}");
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

/// A random law with a drop, and a column of it.
fn anything(random: &mut Random) -> (String, Column) {
    let belt_speed = random.log(0.02, 40.0);
    let drop = if random.unit() < 0.3 { random.log(1e-4, 0.9) } else { 0.9 * random.unit() };
    let onset = 1.0 - drop;
    // Velocities of the law, on the scale of the orbit.
    let size = belt_speed + drop;
    let width = size * random.log(0.02, 2.0);
    let fall = onset * random.unit();
    let rise = if random.unit() < 0.5 { 0.0 } else { random.log(1e-3, 0.3) };
    let (law, parameters) = match (6.0 * random.unit()) as u32 {
        0 => {
            // Viscous parts up to nodes.
            let eta = if random.unit() < 0.5 { rise } else { 3.0 * random.unit() };
            (Law::Coulomb, vec![drop, eta])
        }
        1 => (Law::Stribeck.with_drop(), vec![random.unit(), rise / size, 1.0 / width, 0.0]),
        2 => (Law::Exponential.with_drop(), vec![random.unit(), width, rise, 0.0]),
        3 => (Law::Lorentzian.with_drop(), vec![random.unit(), width, rise, 0.0]),
        4 => {
            let text = match (5.0 * random.unit()) as u32 {
                0 => format!("{onset} - {fall}*tanh(u/{width}) + {rise}*u"),
                1 => format!("{onset} + {fall}*(exp(-(u/{width})^2) - 1)"),
                2 => format!("{onset} - {fall}*tanh(u/{width}) + {}*sin(u/{width})^2", 0.2 * fall),
                // It rises first.
                3 => format!("{onset} + {rise}*u*exp(-u/{width}) + 0.01*u"),
                // It pushes at high slip speeds.
                _ => format!("{onset} - {}*u/({width} + u)", onset + random.unit()),
            };
            (formula(&text, 1.0), vec![])
        }
        _ => {
            let step = 0.1 * width;
            let mut u = 0.0;
            let mut data = vec![(0.0, onset)];
            while u < 5.0 * size {
                u += (step + 0.1 * u) * (0.5 + random.unit());
                let noise = 0.01 * fall * (random.unit() - 0.5);
                data.push((u, onset - fall * (u / width).tanh() + rise * u + noise));
            }
            (Law::Table(Table::with_static("random", &data, 1.0).unwrap()), vec![])
        }
    };
    // The drop of laws that have it as a parameter.
    let mut parameters: Vec<f64> = parameters;
    if let [.., last] = parameters.as_mut_slice()
        && law != Law::Coulomb
    {
        *last = drop;
    }
    let epsilon = random.log(0.1, 1.0);
    let point = law.point(epsilon, &parameters, belt_speed, 0.0).unwrap();
    (format!("{law:?} {parameters:?} eps {epsilon} V {belt_speed}"), law.column(&point))
}

/// What random columns showed.
#[derive(Debug, Default)]
struct Tally {
    columns: u32,
    without_critical: u32,
    fates: [u32; 2],
    from_above: u32,
    cross_for_ever: u32,
    undecided: u32,
    presence: u32,
    absence: u32,
    enclosed: u32,
}

/// Compares all engines and tests on random columns with a drop.
fn survey(seed: u64, count: u32) -> Tally {
    let mut random = Random(seed);
    let mut tally = Tally::default();
    for number in 0..count {
        let (name, column) = anything(&mut random);
        tally.columns += 1;
        let claims: Vec<_> = (TESTS.iter())
            .filter(|test| test.guarantee == Guarantee::FiniteEpsilon)
            .map(|test| (test.name, (test.claim)(&column)))
            .collect();
        let critical =
            critical_damping(&column, 1e-10).ok().filter(|it| it.error < 1e-3 * it.c.abs().max(1e-3));
        let (near, error) = match critical {
            Some(found) => (found.c.max(0.0), found.error),
            None => {
                tally.without_critical += 1;
                (0.1 * random.unit() / column.epsilon, f64::INFINITY)
            }
        };
        if let Some(found) = critical {
            for (test, claim) in &claims {
                assert!(
                    claim.present_below <= found.c + found.error
                        && claim.absent_above >= found.c - found.error,
                    "{name}: {test} {claim:?} {found:?}"
                );
            }
        }
        if number % 16 == 0 {
            let claim = (validated::TEST.claim)(&column);
            if let Some(found) = critical {
                let slack = 2.0 * found.error + 1e-13 * (1.0 + found.c.abs());
                assert!(
                    claim.present_below <= found.c + slack && found.c - slack <= claim.absent_above,
                    "{name}: {claim:?} {found:?}"
                );
                tally.enclosed += u32::from(claim.absent_above - claim.present_below < 1e-6 * found.c.abs());
            }
        }
        let share = random.log(1e-6, 1.0) * if random.unit() < 0.5 { -1.0 } else { 1.0 };
        for c in [near * (1.0 + share), 1.5 * near * random.unit()] {
            let oscillator = Oscillator::in_column(&column, c);
            let (own, other) =
                (flow(&oscillator, 1e-10).fate, witness::decisive_flow(&oscillator, 1e-10).fate);
            let (Some(one), Some(two)) = (returns(&own), returns(&other)) else {
                tally.undecided += 1;
                continue;
            };
            assert_eq!((one, says(&own)), (two, says(&other)), "{name} at {c}: {own:?} {other:?}");
            if let (Fate::Sticks(own), Fate::Sticks(other)) = (&own, &other) {
                let exit = oscillator.exit_x1();
                assert!(own.x1 > exit - 2.0 - 1e-9 && own.x1 < exit + 1e-9, "{name} at {c}: {own:?}");
                assert!(
                    (own.x1 + column.belt_speed * own.stick_time - exit).abs() < 1e-9 * (1.0 + exit.abs())
                );
                assert_eq!(own.crossings, other.crossings, "{name} at {c}");
                // The witness tells no error; next to grazing the landing has half the digits.
                assert!((own.x1 - other.x1).abs() < 1e-4, "{name} at {c}: {own:?} {other:?}");
                tally.from_above += u32::from(own.crossings == Some(1));
            }
            if let Some(found) = critical
                && (c - found.c).abs() > error
            {
                assert_eq!(one, c < found.c, "{name} at {c}: {own:?} {found:?}");
            }
            tally.fates[usize::from(one)] += 1;
            tally.cross_for_ever += u32::from(own == Fate::CrossesForever);
            for (test, claim) in &claims {
                match claim.decide(c) {
                    Decision::Undecided => continue,
                    decided => {
                        assert_eq!(Some(decided), says(&other), "{name} at {c}: {test} {claim:?} {other:?}")
                    }
                }
                match claim.decide(c) {
                    Decision::Present => tally.presence += 1,
                    _ => tally.absence += 1,
                }
            }
        }
    }
    tally
}

#[test]
fn engines_and_tests_agree_on_random_laws_with_a_drop() {
    let tally = survey(4801, 250);
    let Tally { columns, fates, from_above, cross_for_ever, presence, absence, enclosed, .. } = tally;
    assert!(fates.iter().all(|&count| count > columns / 4), "{tally:?}");
    assert!(
        from_above > 0 && cross_for_ever > 0 && presence > 30 && absence > 30 && enclosed > 5,
        "{tally:?}"
    );
    assert!(10 * tally.without_critical < columns && 20 * tally.undecided < columns, "{tally:?}");
}

#[test]
#[ignore = "minutes: SLIPMAP_POINTS='10000 7' cargo test --test mathematics drop:: -- --ignored --nocapture"]
fn engines_and_tests_agree_on_many_random_laws_with_a_drop() {
    let given = std::env::var("SLIPMAP_POINTS").unwrap_or("10000 7".into());
    let [count, seed] = given.split_whitespace().map(|n| n.parse().unwrap()).collect::<Vec<u64>>()[..] else {
        panic!("SLIPMAP_POINTS is a number of columns and a seed");
    };
    println!("{:?}", survey(seed, count as u32));
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
        let without = (symmetric::TEST.claim)(&column(&base, &parameters, belt_speed));
        let dropping = column(&base.with_drop(), &[parameters[0], parameters[1], 0.0, drop], belt_speed);
        let with = (symmetric::TEST.claim)(&dropping);
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

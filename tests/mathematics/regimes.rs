//! The flow's attractors and the cycles between them, compared with the direct engine, closed forms and the
//! small-eps limit.

use std::f64::consts::{PI, TAU};

use crate::sample::slip_cycles;
use slipmap::certify;
use slipmap::column;
use slipmap::column::crossing::stick_slip_cycle;
use slipmap::column::slip_cycle::{Kick, kick_onto};
use slipmap::column::{Attractors, Behaviour, ChangeKind, End, Regime};
use slipmap::column::{Neighbour, critical_damping, crossing_separates, separates};
use slipmap::filippov::{Eigenvalues, Oscillator, Side, Stability};
use slipmap::flow::{Failure, Fate, Flow};
use slipmap::friction::{Column, Expression, Law, Table};
use slipmap::orbits::arc::{SlipTurn, turn};
use slipmap::orbits::{Cycle, flow};
use slipmap::point::Point;
use slipmap::witness::{self, Ending, Phase, Start, Trace, trace};

use crate::agreement::law;
use crate::crossing::{Loop, crossing_cycles, crossing_loop};
use crate::sample::{Random, Sampling, at_one, formula};

fn point(epsilon: f64, law: [f64; 3], belt_speed: f64, damping: f64) -> Point {
    Law::Stribeck.point(epsilon, &law, belt_speed, damping).unwrap()
}

/// Columns with a wide bistable band: k = eps gamma V of order one.
fn columns() -> Vec<Column> {
    [
        (0.4, [0.2, 0.1, 2.0], 1.0),
        (0.2, [0.0, 0.0, 5.0], 1.5),
        (0.7, [0.5, 0.3, 4.0], 0.6),
        (0.05, [0.1, 0.02, 10.0], 3.0),
        (1.0, [0.3, 0.0, 6.0], 0.2),
    ]
    .map(|(epsilon, law, speed)| Law::Stribeck.column(&point(epsilon, law, speed, 0.0)))
    .to_vec()
}

/// c(instability), where the divergence at the equilibrium changes its sign.
fn instability(column: &Column) -> f64 {
    certify::instability::TEST.claim(column).present_below
}

fn critical(column: &Column) -> f64 {
    critical_damping(column, 1e-13).unwrap().c
}

/// The damping at a fraction of the band between c(instability) and c*.
fn in_band(column: &Column, fraction: f64) -> Oscillator {
    let (low, high) = (instability(column), critical(column));
    assert!(low < high, "the band is not empty");
    Oscillator::in_column(column, low + fraction * (high - low))
}

/// The complete dynamics, where every part is known.
#[derive(Debug)]
struct Known {
    equilibrium: Eigenvalues,
    stick_slip: Option<Cycle>,
    slip: Vec<Cycle>,
    crossing: Vec<Cycle>,
    kick: Option<Kick>,
}

impl Known {
    fn of(oscillator: &Oscillator, flow: &Flow, tolerance: f64) -> Self {
        let slip = slip_cycles(oscillator, 1e-13).unwrap();
        let repels = slip.iter().rfind(|cycle| !cycle.is_stable());
        Self {
            equilibrium: oscillator.eigenvalues(),
            stick_slip: stick_slip_cycle(oscillator, flow, tolerance).unwrap(),
            crossing: crossing_cycles(oscillator, tolerance).unwrap(),
            kick: repels.map(|cycle| kick_onto(oscillator, cycle, 1e-13).unwrap()),
            slip,
        }
    }
}

fn all(oscillator: &Oscillator) -> Known {
    Known::of(oscillator, &flow(oscillator, 1e-12), 1e-12)
}

/// x1 at a maximum (or minimum) x2 = v of an orbit below the belt line: x2' = 0 there.
fn x1_of_extremum(oscillator: &Oscillator, v: f64) -> f64 {
    oscillator.curve.phi(oscillator.belt_speed - v) - oscillator.viscous * v
}

#[test]
fn one_unstable_slip_cycle_inside_the_band_and_none_outside() {
    for column in columns() {
        let mut amplitudes = vec![0.0];
        for fraction in [0.01, 0.2, 0.4, 0.6, 0.8, 0.99] {
            let oscillator = in_band(&column, fraction);
            let found = all(&oscillator);
            let [cycle] = found.slip.as_slice() else { panic!("{} slip cycles", found.slip.len()) };
            assert!(!cycle.is_stable() && found.equilibrium.is_stable() && found.stick_slip.is_some());
            assert!(found.kick.is_some());
            amplitudes.push(cycle.velocity.hi);
        }
        amplitudes.push(column.belt_speed);
        // It grows from nothing at c(instability) to the grazing orbit at c*.
        assert!(amplitudes.windows(2).all(|pair| pair[0] < pair[1]), "{amplitudes:?}");
        for fraction in [-0.5, -0.01, 1.01, 1.5] {
            let found = all(&in_band(&column, fraction));
            assert!(found.slip.is_empty(), "{fraction} {:?}", found.slip);
            assert!(found.kick.is_none());
        }
    }
}

#[test]
fn orbits_beside_the_unstable_cycle_end_as_the_regime_says() {
    for column in columns() {
        for fraction in [0.3, 0.7] {
            let oscillator = in_band(&column, fraction);
            let found = all(&oscillator);
            assert_eq!(column::regime(&oscillator, &flow(&oscillator, 1e-12)), Regime::Bistable);
            let (cycle, kick) = (found.slip[0], found.kick.unwrap());
            let rest = oscillator.equilibrium_x1();
            let starts = |factor: f64| {
                let v = cycle.velocity.hi * factor;
                [
                    (x1_of_extremum(&oscillator, v), v),
                    (rest, kick.forward * factor),
                    (rest, -kick.backward * factor),
                ]
            };
            // A start off the cycle by 1e-3 departs from it by the factor of the multiplier in each turn, and
            // what comes near the equilibrium shrinks by exp(pi D(V)).
            let decay = -PI * oscillator.divergence(oscillator.belt_speed);
            let turns = 20.0 + 3.0 * 1e3_f64.ln() * (1.0 / cycle.multiplier.ln() + 1.0 / decay);
            let end = |(x1, x2)| trace(&oscillator, Start::State { x1, x2 }, 1e-10, TAU * turns).ending;
            for start in starts(1.0 - 1e-3) {
                assert_eq!(end(start), Ending::Settles, "{start:?} {oscillator:?}");
            }
            for start in starts(1.0 + 1e-3) {
                let ending = end(start);
                assert!(matches!(ending, Ending::Closes { .. }), "{ending:?} {start:?} {oscillator:?}");
            }
        }
    }
}

/// The maximum of x2 one turn after the maximum `r`, by the direct engine: the time of the trace is moved to
/// where x2' vanishes, by Newton's method from the highest sample.
fn direct_return(oscillator: &Oscillator, r: f64) -> f64 {
    let start = Start::State { x1: x1_of_extremum(oscillator, r), x2: r };
    let until = |time| trace(oscillator, start, 1e-14, time).samples;
    let samples = until(9.0);
    let later = samples.iter().filter(|sample| sample.t > 3.0);
    let top = later.max_by(|a, b| a.x2.total_cmp(&b.x2)).unwrap();
    let mut time = top.t;
    for _ in 0..4 {
        let end = *until(time).last().unwrap();
        let w = oscillator.acceleration(Side::Below, end.x1, end.x2);
        let slip = oscillator.belt_speed - end.x2;
        let to_top = w / (end.x2 - oscillator.divergence(slip) * w);
        if to_top.abs() < 1e-6 {
            // The remaining change of x2 is of second order, and is added.
            return end.x2 + 0.5 * w * to_top;
        }
        time += to_top;
    }
    panic!("Newton's method does not converge");
}

#[test]
fn the_multiplier_is_the_slope_of_the_direct_return_map() {
    for column in columns() {
        let oscillator = in_band(&column, 0.5);
        let cycle = all(&oscillator).slip[0];
        let returns = |r: f64| direct_return(&oscillator, r);
        let r = cycle.velocity.hi;
        // The direct flow comes back to where it started: both engines' errors are some 1e-13, which the
        // cycle's amplitude magnifies by 1/(multiplier - 1).
        let off = (returns(r) - r).abs() / r;
        assert!(off < 1e-12, "{off}");
        // Central differences at two widths, extrapolated. What is left is of order (h/r)^4, with a factor of
        // 1e3 for the largest multiplier here, and the turns' errors of 1e-13 over h/r.
        let slope_at = |r: f64| {
            let difference = |h: f64| (returns(r + h) - returns(r - h)) / (2.0 * h);
            let h = 5e-4 * r;
            (4.0 * difference(0.5 * h) - difference(h)) / 3.0
        };
        let slope = slope_at(r);
        assert!((slope - cycle.multiplier).abs() < 1e-8, "{slope} {}", cycle.multiplier);
        // The fast turn agrees with the direct one away from the cycle, and so does its slope.
        for factor in [0.3, 0.8, 0.95] {
            let SlipTurn::Returns { radius, slope, .. } = turn(&oscillator, factor * r, 1e-13).unwrap()
            else {
                panic!("inside an unstable cycle orbits stay below the belt");
            };
            assert!((radius - returns(factor * r)).abs() < 1e-12 * r);
            let direct = slope_at(factor * r);
            assert!((slope - direct).abs() < 1e-8, "{slope} {direct}");
        }
    }
}

#[test]
fn small_eps_limit_of_the_unstable_cycle() {
    // Averaging the even part of D to lowest order (the odd part only shifts the phase), the cycle of
    // amplitude a has D(V) = -(3/4) eps^3 gamma^3 (1-alpha) a^2 (1 + O(eps)) and the multiplier
    // 1 - 2 pi D(V) (1 + O(eps)). Halving eps must divide the relative departures by about 2, or more.
    let (law, belt_speed): ([f64; 3], f64) = ([0.3, 0.2, 2.0], 1.2);
    let [alpha, _, gamma] = law;
    let departures = [0.04, 0.02, 0.01].map(|epsilon: f64| {
        let column = Law::Stribeck.column(&point(epsilon, law, belt_speed, 0.0));
        let oscillator = in_band(&column, 0.5);
        let cycle = slip_cycles(&oscillator, 1e-14).unwrap()[0];
        let d = oscillator.divergence(belt_speed);
        let amplitude = cycle.velocity.hi;
        let predicted = -0.75 * (epsilon * gamma).powi(3) * (1.0 - alpha) * amplitude * amplitude;
        [d / predicted - 1.0, (cycle.multiplier - 1.0) / (-TAU * d) - 1.0, cycle.period / TAU - 1.0]
    });
    for which in 0..2 {
        for pair in departures.windows(2) {
            assert!((pair[0][which] / pair[1][which]) > 1.6, "{which} {departures:?}");
        }
    }
    // The period departs by D^2/8 and the like, D of order eps: halving eps divides that by 4.
    for pair in departures.windows(2) {
        assert!(pair[0][2] / pair[1][2] > 3.0, "{departures:?}");
    }
}

/// Oscillators on fast belts whose orbits cross for ever.
fn crossing_oscillators() -> Vec<Oscillator> {
    [
        (0.0358, [0.0375, 0.0, 8.285], 8.403, 0.0),
        (0.0174, [0.0, 0.0, 5.227], 9.942, 0.068),
        (0.3, [0.1, 0.0, 1.5], 12.0, 0.02),
        (0.1, [0.0, 0.0, 3.0], 20.0, 0.0),
    ]
    .map(|(epsilon, law, speed, c)| Oscillator::new(&Law::Stribeck, &point(epsilon, law, speed, c)))
    .to_vec()
}

/// The downward crossings of the belt line on a traced orbit, as x1 less that of the exit point, in order.
fn crossings_down(oscillator: &Oscillator, traced: &Trace) -> Vec<f64> {
    let below = |phase: Phase| phase == Phase::Slip(Side::Below);
    let at = traced.samples.iter().skip(1);
    at.filter(|sample| sample.x2 == oscillator.belt_speed && below(sample.phase))
        .map(|sample| sample.x1 - oscillator.exit_x1())
        .collect()
}

#[test]
fn crossing_cycles_attract_the_orbit_from_the_exit_point() {
    for oscillator in crossing_oscillators() {
        assert_eq!(witness::flow(&oscillator, 1e-12).fate, Fate::CrossesForever);
        let cycles = crossing_cycles(&oscillator, 1e-12).unwrap();
        let cycle = cycles[0];
        assert!(cycle.is_stable());
        let multiplier = cycle.multiplier;

        // The orbit from E approaches it by the multiplier in each loop, until the engines' errors show.
        let loops = 3.0 + 27.0 / -multiplier.ln();
        let traced = trace(&oscillator, Start::ExitPoint, 1e-13, loops * cycle.period);
        let seen = crossings_down(&oscillator, &traced);
        let last = seen.last().unwrap();
        let scale = oscillator.belt_speed;
        let beyond_exit = cycle.beyond_exit.unwrap();
        assert!((last - beyond_exit).abs() < 1e-9 * scale, "{last} {beyond_exit}");

        // Its multiplier is the slope of the direct flow's loop map.
        let next = |y: f64| {
            let start = Start::State { x1: oscillator.exit_x1() + y, x2: oscillator.belt_speed };
            crossings_down(&oscillator, &trace(&oscillator, start, 1e-14, 1.2 * cycle.period))[0]
        };
        let y = cycle.beyond_exit.unwrap();
        // Central differences at two widths, extrapolated: what is left is h^4 / y^4, and 1e-13 V / h.
        let difference = |h: f64| (next(y + h) - next(y - h)) / (2.0 * h);
        let h = 2e-2 * y;
        let slope = (4.0 * difference(0.5 * h) - difference(h)) / 3.0;
        assert!((slope - multiplier).abs() < 1e-6, "{slope} {multiplier}");

        // The loop map is monotone, as orbits do not cross.
        let mut last = 0.0;
        for i in 1..=40 {
            let Loop::Crosses(beyond_exit) =
                crossing_loop(&oscillator, 0.1 * y * f64::from(i), 1e-11).unwrap()
            else {
                panic!("beyond the exit point orbits cross for ever here");
            };
            assert!(beyond_exit > last);
            last = beyond_exit;
        }
    }
}

/// The shape of a stick-slip cycle is that of the trace of the direct engine.
fn assert_traced(oscillator: &Oscillator, cycle: &Cycle) {
    let traced = trace(oscillator, Start::ExitPoint, 1e-11, 1e3);
    let Ending::Closes { period } = traced.ending else { panic!("{:?}", traced.ending) };
    // A landing's error is V^2/wL times that of the margin; 1e-4 V is the smallest wL met here.
    assert!((cycle.period - period).abs() < 1e-6 * period, "{} {period}", cycle.period);
    let range = |value: fn(&witness::Sample) -> f64| {
        let values = traced.samples.iter().map(value);
        values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), x| (lo.min(x), hi.max(x)))
    };
    // Samples are up to 0.1 rad from the extremes, which they miss by 1 - cos 0.05 = 1.25e-3 at most, of
    // an amplitude that the range of the values bounds.
    for (range, computed) in [(range(|s| s.x1), cycle.displacement), (range(|s| s.x2), cycle.velocity)] {
        let slack = 1.3e-3 * (computed.hi - computed.lo) + 1e-9;
        assert!(computed.lo <= range.0 + 1e-9 && range.0 <= computed.lo + slack, "{range:?} {computed:?}");
        assert!(computed.hi >= range.1 - 1e-9 && range.1 >= computed.hi - slack, "{range:?} {computed:?}");
    }
}

/// Friction that falls within 10^-7 of the belt speed and less: the slip speed is rounded as the belt speed is.
#[test]
fn friction_that_falls_next_to_rest_has_a_regime() {
    for share in [1e-7, 1e-8] {
        for (damping, wanted) in
            [(1e-5, Regime::Bistable), (0.1, Regime::Equilibrium), (1.0, Regime::Equilibrium)]
        {
            let oscillator = at_one(&Law::Exponential, &[0.2, 5.0 * share, 0.0], 5.0, damping);
            let flow = flow(&oscillator, 1e-9);
            assert_eq!(column::regime(&oscillator, &flow), wanted, "{share} {damping}: {flow:?}");
        }
    }
}

#[test]
fn the_stick_slip_cycle_is_the_traced_one() {
    let mut seed = Random(7);
    let mut compared = 0;
    while compared < 60 {
        let mut between = |lo: f64, hi: f64| seed.between(lo, hi);
        let epsilon = 10_f64.powf(between(-2.0, 0.0));
        let gamma = between(0.5, 8.0);
        let law = [between(0.0, 0.8), between(0.0, 0.2), gamma];
        let belt_speed = 10_f64.powf(between(-1.0, 1.0));
        let oscillator = Oscillator::new(&Law::Stribeck, &point(epsilon, law, belt_speed, between(0.0, 0.5)));
        let answer = flow(&oscillator, 1e-11);
        let Some(cycle) = stick_slip_cycle(&oscillator, &answer, 1e-11).unwrap() else { continue };
        compared += 1;
        assert_traced(&oscillator, &cycle);
    }
}

/// A step of friction of 1/500 of the belt speed, which takes most of an orbit's velocity, and one of 1/230
/// of it on a slow belt, at eight times the belt speed.
#[test]
fn the_stick_slip_cycle_over_a_narrow_step_is_the_traced_one() {
    let law = formula("1-a*u/(u+b)+d*(tanh((u-p)/w)+tanh(p/w))");
    let wide = [0.0465, 1.0588, -0.10803, 2.5246, 0.00358];
    let slow = [0.5994, 0.02144, 0.086614, 0.42859, 0.000213];
    for (parameters, belt_speed, damping) in [(wide, 1.909, 0.0305), (slow, 0.0496, 0.00226554)] {
        let oscillator = at_one(&law, &parameters, belt_speed, damping);
        let answer = flow(&oscillator, 1e-11);
        assert_traced(&oscillator, &stick_slip_cycle(&oscillator, &answer, 1e-11).unwrap().unwrap());
    }
}

#[test]
fn cycles_and_regimes_are_consistent_at_random_points() {
    let mut seed = Random(11);
    let mut met = [0; Regime::ALL.len()];
    for _ in 0..300 {
        let mut between = |lo: f64, hi: f64| seed.between(lo, hi);
        let epsilon = 10_f64.powf(between(-3.0, 0.0));
        let gamma = 10_f64.powf(between(-1.0, 1.0));
        let at_limit = between(0.0, 1.0);
        let alpha = if at_limit < 0.1 { 0.0 } else { between(0.0, 1.0) };
        let beta = if at_limit < 0.2 { 0.0 } else { between(0.0, 0.5) };
        let belt_speed = 10_f64.powf(between(-1.0, 1.0));
        let mut damping = if at_limit < 0.3 { 0.0 } else { gamma * (1.0 - alpha) * between(0.0, 1.2) };
        let law = [alpha, beta, gamma];
        let column = Law::Stribeck.column(&point(epsilon, law, belt_speed, 0.0));
        if at_limit > 0.8 && instability(&column) > 0.0 {
            // In the bistable band, which random dampings hardly ever hit.
            damping = instability(&column) + between(0.05, 0.95) * (critical(&column) - instability(&column));
        }
        let oscillator = Oscillator::in_column(&column, damping);
        let answer = flow(&oscillator, 1e-12);
        let found = Known::of(&oscillator, &answer, 1e-10);
        let regime = column::regime(&oscillator, &answer);
        let label = format!("{regime:?} {found:?} at {epsilon} {law:?} {belt_speed} {damping}");
        met[Regime::ALL.iter().position(|r| *r == regime).unwrap()] += 1;

        // Attractors and repellers alternate outward from the equilibrium.
        let mut stable = found.equilibrium.is_stable();
        for cycle in &found.slip {
            assert_ne!(cycle.is_stable(), stable, "{label}");
            assert!(cycle.velocity.hi < belt_speed && cycle.velocity.lo < 0.0, "{label}");
            stable = cycle.is_stable();
        }
        match regime {
            Regime::Equilibrium => assert!(found.slip.is_empty() && found.crossing.is_empty(), "{label}"),
            Regime::StickSlip => assert!(found.slip.is_empty() && found.stick_slip.is_some(), "{label}"),
            Regime::Bistable => {
                let kick = found.kick.unwrap();
                let cycle = found.slip[0];
                assert!(found.slip.len() == 1 && found.stick_slip.is_some(), "{label}");
                assert!(kick.forward > 0.0 && kick.forward <= cycle.velocity.hi * (1.0 + 1e-12), "{label}");
                assert!(
                    kick.backward > 0.0 && kick.backward <= -cycle.velocity.lo * (1.0 + 1e-12),
                    "{label}"
                );
            }
            Regime::Crossing => assert!(found.crossing[0].is_stable(), "{label}"),
            Regime::EquilibriumAndCrossing => {
                assert!(
                    found.slip.len() == 1 && found.kick.is_some() && found.crossing[0].is_stable(),
                    "{label}"
                );
            }
            Regime::Neutral => assert_eq!(oscillator.stability(), Stability::Neutral, "{label}"),
            Regime::Failed => assert_eq!(answer.fate, Fate::TooCloseToCall, "{label}"),
            // For this law no stable slip cycle is known, and no crossing cycle around the stick-slip cycle.
            _ => panic!("{label}"),
        }
    }
    assert!(met[..3].iter().all(|&n| n > 10), "{met:?}");
}

/// The attractor beyond an orbit of unknown fate is reported as unknown.
#[test]
fn an_uncertain_exit_orbit_leaves_neighbours_unknown() {
    for fate in [Fate::TooCloseToCall, Fate::Failed(Failure::StepBudget)] {
        assert_eq!(separates(0, 1, &fate), [Neighbour::Equilibrium, Neighbour::Unknown]);
        assert_eq!(crossing_separates(0, 1, 0, &fate), [Neighbour::Unknown; 2]);
    }
    let inward = Fate::SpiralsInward;
    assert_eq!(crossing_separates(0, 2, 0, &inward), [Neighbour::Equilibrium, Neighbour::Crossing]);
    assert_eq!(crossing_separates(0, 2, 2, &inward), [Neighbour::SlipCycle, Neighbour::Crossing]);
}

#[test]
fn the_half_turn_of_an_undamped_oscillator_is_exact() {
    // D = 0: circles, with period 2 pi and multiplier 1.
    let oscillator = Oscillator::new(&Law::Stribeck, &point(0.1, [1.0, 0.0, 1.0], 1.0, 0.0));
    for radius in [0.1, 0.5, 0.9] {
        let SlipTurn::Returns { radius: next, slope, time } = turn(&oscillator, radius, 1e-13).unwrap()
        else {
            panic!("circles inside the belt line");
        };
        // The error of the turn is the requested one.
        assert!((next / radius - 1.0).abs() < 1e-13 && (slope - 1.0).abs() < 1e-13);
        assert!((time - 2.0 * PI).abs() < 1e-12);
    }
}

/// A stable focus, inside an unstable slip cycle, inside a stable one, inside an unstable one, inside the
/// stick-slip cycle.
#[test]
fn three_attractors_have_a_name() {
    let law = Expression::new("1-a*u*exp(-u/s)+h*sin(w*u)+d*u", 1.0).unwrap();
    let names: Vec<&str> = law.parameters().iter().map(|parameter| parameter.name).collect();
    assert_eq!(names, ["a", "s", "h", "w", "d"]);
    let parameters =
        [1.4011736523425116, 1.5163622676000161, 0.1959638787725319, 7.376007337016889, -0.05998217920725249];
    let (belt_speed, damping) = (1.6725777145060758, 0.17025221378214433);
    let law = Law::Expression(law);
    let oscillator = at_one(&law, &parameters, belt_speed, damping);
    let answer = flow(&oscillator, 1e-10);
    assert!(matches!(answer.fate, Fate::Sticks(_)) && oscillator.eigenvalues().is_stable());
    let cycles = slip_cycles(&oscillator, 1e-12).unwrap();
    let stable: Vec<bool> = cycles.iter().map(Cycle::is_stable).collect();
    assert_eq!(stable, [false, true, false], "{cycles:?}");
    assert_eq!(column::regime(&oscillator, &answer), Regime::EquilibriumPureSlipAndStickSlip);
    let sides: Vec<[Neighbour; 2]> = [0, 2].map(|i| separates(i, 3, &answer.fate)).to_vec();
    assert_eq!(
        sides,
        [[Neighbour::Equilibrium, Neighbour::SlipCycle], [Neighbour::SlipCycle, Neighbour::StickSlip]]
    );
    // Turns between the cycles lead in the directions that the cycles' stability demands.
    let [first, second, third] = [0, 1, 2].map(|i| cycles[i].velocity.hi);
    let outward = |radius: f64| match turn(&oscillator, radius, 1e-12).unwrap() {
        SlipTurn::Returns { radius: next, .. } => next > radius,
        SlipTurn::MeetsBelt { .. } => true,
        SlipTurn::Rests => false,
    };
    let radii = [0.9 * first, 0.5 * (first + second), 0.5 * (second + third), 0.5 * (third + belt_speed)];
    assert_eq!(radii.map(outward), [false, true, false, true]);
}

/// Every set of attractors has its own regime, with its own name and code.
#[test]
fn regimes_are_sets_of_attractors() {
    let mut seen = vec![Regime::Failed];
    for set in 1..16 {
        let has = |bit: u8| set & bit != 0;
        seen.push(Regime::of(Attractors {
            equilibrium: has(1),
            slip: has(2),
            stick_slip: has(4),
            crossing: has(8),
        }));
    }
    assert!(seen.iter().all(|regime| Regime::of(regime.attractors()) == *regime));
    let mut codes: Vec<i8> = seen.iter().map(|regime| regime.code()).collect();
    codes.push(Regime::Neutral.code());
    codes.sort_unstable();
    assert_eq!(codes, Regime::ALL.map(Regime::code));
    let names: std::collections::HashSet<&str> = seen.iter().map(|regime| regime.name()).collect();
    assert_eq!(names.len(), Regime::ALL.len() - 1);
}

/// Where friction is constant next to the belt speed and there is no damping, orbits about the equilibrium
/// are closed: it neither attracts nor repels.
#[test]
fn steady_slip_among_orbits_that_close_is_neutral() {
    let data = [(0.0, 1.0), (0.5, 0.7), (1.0, 0.5), (2.0, 0.5), (3.0, 0.5), (6.0, 0.5)];
    let law = Law::Table(Table::new("flat", &data, 1.0).unwrap());
    let regime = |c: f64| {
        let oscillator = at_one(&law, &[], 1.5, c);
        column::regime(&oscillator, &flow(&oscillator, 1e-10))
    };
    assert_eq!(regime(0.0), Regime::Neutral);
    assert_eq!(regime(1e-3), Regime::Bistable);
}

/// Belts slower and faster than a narrow smooth step of the friction by some of its widths, or by ten: the polar form
/// does not apply to orbits that reach the step, each of them is expensive, and no polynomial follows how C rises there.
#[test]
fn regimes_next_to_a_narrow_step_are_known() {
    let law = formula("1 - a*(tanh((u-1)/w) + tanh(1/w)) + b*u");
    for (step, width, rise, speed, damping) in [
        (0.1, 0.01, 0.0, 0.95, 0.1),
        (0.1, 0.01, 0.0, 1.05, 0.1),
        (0.1, 0.005, 0.0, 0.98, 0.1),
        (0.2, 0.004, 0.01, 1.05, 0.05),
    ] {
        let point = law.point(1.0, &[step, width, rise], speed, damping).unwrap();
        let oscillator = Oscillator::new(&law, &point);
        let answer = flow(&oscillator, 1e-9);
        assert!(oscillator.eigenvalues().is_stable() && matches!(answer.fate, Fate::Sticks(_)), "{answer:?}");
        assert_eq!(column::regime(&oscillator, &answer), Regime::Bistable, "{point:?}");
    }
}

/// At the critical damping to first order in eps the margin is of second order: far below the rounding errors
/// of 1.
#[test]
fn small_terms_are_resolved_to_second_order() {
    for epsilon in [1e-14, 1e-13, 1e-12, 1e-10, 1e-8, 1e-4] {
        for (law, speed, damping) in
            [([0.0, 0.1, 1.0], 1.0, 0.8), ([0.3, 0.1, 2.0], 1.0, 1.2), ([0.3, 0.1, 1.0], 3.0, 0.1)]
        {
            let point = point(epsilon, law, speed, damping);
            let column = Law::Stribeck.column(&point);
            let claim = certify::symmetric::TEST.claim(&column);
            assert!(claim.absent_above < damping, "{epsilon} {claim:?}");
            let oscillator = Oscillator::new(&Law::Stribeck, &point);
            let answer = flow(&oscillator, 1e-9);
            assert_eq!(answer.fate, Fate::SpiralsInward, "{epsilon} {answer:?}");
            assert_eq!(column::regime(&oscillator, &answer), Regime::Equilibrium, "{epsilon}");
        }
    }
}

/// Next to a cusp of folds three slip cycles lie within a small range of dampings. That there are three
/// follows from integrations in extended precision, which change sign three times.
#[test]
fn three_cycles_next_to_a_cusp_of_folds_are_counted() {
    let rational = "1 - 0.5942742260704288*u^2/(0.35014300930538617^2 + u^2) \
                    + 0.36322055137844617*u^3/(0.35036123294133537^3 + u^3) + 0.01093637427960839*u";
    let exponential = "0.3778616602770418 + 0.6221383397229582*exp(-u/0.35657089132543723) \
                       - 0.39625712515479883*u^2*exp(-(u/0.5150121896981549)^2) \
                       + 0.1977730614587374*u^2*exp(-(u/0.8659285546875)^2)";
    for (text, belt_speed, damping) in
        [(rational, 1.3660416626980523, 0.039217813867361076), (exponential, 1.88767, 0.04428947537349257)]
    {
        let law = formula(text);
        let oscillator = at_one(&law, &[], belt_speed, damping);
        let answer = flow(&oscillator, 1e-9);
        assert_eq!(column::slip_cycle_count(&oscillator, &answer), Some(3), "{text}");
        assert_eq!(column::regime(&oscillator, &answer), Regime::EquilibriumPureSlipAndStickSlip, "{text}");
        assert_eq!(slip_cycles(&oscillator, 1e-10).unwrap().len(), 3, "{text}");
    }
}

/// Measured friction that falls steeply from rest and scatters: many orbits of its backbone are followed in
/// (x2, x2'), since their polar angle is not monotone in time. Without a guess of the damping at which each
/// closes the backbone took more than its budget.
#[test]
fn regimes_of_scattered_data_next_to_the_boundary_are_known() {
    // Slip speeds in 1e-4 of the unit of velocity, friction in 1e-4 of that at rest.
    let speeds = [0, 19, 33, 55, 94, 160, 271, 461, 782, 1329, 2257, 3834];
    let friction = [10000, 9199, 9265, 8907, 8549, 8097, 7394, 7008, 6526, 6676, 6408, 6517];
    let rows = speeds.into_iter().zip(friction);
    let data: Vec<(f64, f64)> = rows.map(|(u, phi)| (1e-4 * f64::from(u), 1e-4 * f64::from(phi))).collect();
    let law = Law::Table(Table::new("scattered", &data, 1.0).unwrap());
    let column = law.column(&law.point(1.0, &[], 0.048, 0.0).unwrap());
    let critical = critical_damping(&column, 1e-9).unwrap().c;
    for (share, expected) in [
        (0.85, Regime::StickSlip),
        (0.999, Regime::Bistable),
        (1.001, Regime::Equilibrium),
        (1.1, Regime::Equilibrium),
    ] {
        let oscillator = Oscillator::in_column(&column, share * critical);
        assert_eq!(column::regime(&oscillator, &flow(&oscillator, 1e-9)), expected, "{share} of {critical}");
    }
}

/// Rows that fall and rise steeply: the error of the backbone is larger than its estimate, and no orbit closes within that.
#[test]
fn every_cycle_that_is_told_closes() {
    let rows = [
        (0.0, 1.0),
        (0.085755, 0.69383),
        (0.13657, 0.685699),
        (0.15226, 0.482434),
        (0.2444, 0.672325),
        (0.42999, 0.642009),
        (0.536053, 0.628703),
    ];
    let law = Law::Table(Table::new("falls and rises", &rows, 1.0).unwrap());
    let oscillator = at_one(&law, &[], 0.0893421, 0.790186443677);
    let by_map = column::slip_cycles(&oscillator, &flow(&oscillator, 1e-9), 1e-9).unwrap();
    for cycles in [slip_cycles(&oscillator, 1e-11).unwrap(), by_map] {
        // By turns with SciPy, of its interpolant and its method of Runge and Kutta.
        assert!(cycles.len() == 1 && (cycles[0].velocity.hi - 0.041_155_946_6).abs() < 1e-9, "{cycles:?}");
    }
}

/// Between two changes of a column nothing changes: the regime and the end of the orbit are those of orbits at dampings there.
#[test]
fn nothing_changes_between_changes() {
    let mut random = Random(0xc4a6e);
    let mut seen = [0; ChangeKind::ALL.len()];
    let fast = [(0.3, 25.0, 75.0), (0.05, 3.0, 12.0)].map(|(mu, width, belt_speed)| {
        Law::Exponential.column(&Law::Exponential.point(1.0, &[mu, width, 0.0], belt_speed, 0.0).unwrap())
    });
    let falls = formula("1 - 0.3*tanh((u - 0.25)/0.05) - 0.3*tanh(5)");
    let folds = falls.column(&falls.point(1.0, &[], 0.2, 0.0).unwrap());
    let drops = Law::Exponential.with_drop();
    let drops = drops.column(&drops.point(1.0, &[0.6, 0.2, 0.0, 0.2], 0.4, 0.0).unwrap());
    let usual = (0..24).map(|_| {
        let (_, law, values) = law(&mut random, [0.05, 0.95], [0.15, 1.5]);
        law.column(&law.point(1.0, &values, random.log(0.05, 4.0), 0.0).unwrap())
    });
    for column in usual.chain(fast).chain([folds, drops]).collect::<Vec<_>>() {
        let asked = Behaviour::new(&column.curve, column.belt_speed);
        let changes = asked.changes();
        assert!(changes.windows(2).all(|pair| pair[0].viscous <= pair[1].viscous), "{changes:?}");
        let mut ends: Vec<f64> = changes.iter().flat_map(|change| change.between).collect();
        ends.extend([0.0, 2.0 * ends.iter().copied().fold(0.1, f64::max)]);
        ends.retain(|end| *end >= 0.0);
        ends.sort_by(f64::total_cmp);
        for pair in ends.windows(2).filter(|pair| pair[1] - pair[0] > 1e-6) {
            let viscous = random.between(pair[0] + 1e-3 * (pair[1] - pair[0]), pair[1]);
            let oscillator = Oscillator::in_column(&column, viscous);
            let answer = flow(&oscillator, 1e-9);
            let by_list = (asked.end_at(viscous), asked.regime_at(viscous));
            let is_known = changes.iter().all(|change| change.is_above(viscous).is_some());
            let by_orbit = (End::of(&answer), column::regime(&oscillator, &answer));
            assert!(!is_known || by_list == by_orbit, "{viscous} {by_list:?} {by_orbit:?} {changes:?}");
        }
        changes.iter().for_each(|change| seen[change.kind as usize] += 1);
    }
    let of = |kind: ChangeKind| seen[kind as usize];
    assert!(
        of(ChangeKind::Fold) > 0 && of(ChangeKind::Crossing) > 0 && of(ChangeKind::Grazing) > 0,
        "{seen:?}"
    );
}

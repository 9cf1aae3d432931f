//! Cycles that cross the belt line, and loops beyond the exit point, which tend to them or inward.

use crate::sample::slip_cycles;
use slipmap::column;
use slipmap::column::crossing::{self, reach, some_cross_for_ever, stick_slip_cycle};
use slipmap::column::slip_cycle::CyclesUnknown;
use slipmap::column::{Attractors, Regime};
use slipmap::column::{Neighbour, crossing_separates};
use slipmap::filippov::Oscillator;
use slipmap::flow::Failure;
use slipmap::friction::Law;
use slipmap::orbits::far_loops::FarLoops;
use slipmap::orbits::{Cycle, Piece, Work, flow};

use crate::sample::{Random, Sample, Sampling, at_one, formula};

/// The end of a loop that began on the belt line beyond the exit point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Loop {
    /// It crosses again, at this distance beyond the exit point.
    Crosses(f64),
    Sticks,
    SpiralsInward,
}

/// Follows the loop from `beyond_exit` beyond the exit point.
pub fn crossing_loop(oscillator: &Oscillator, beyond_exit: f64, tolerance: f64) -> Result<Loop, Failure> {
    let fastest = oscillator.fastest_sticking();
    Ok(match reach(oscillator, beyond_exit, tolerance)? {
        0.0 => Loop::SpiralsInward,
        reach if reach <= 2.0 * fastest => Loop::Sticks,
        reach => Loop::Crosses(reach - 2.0 * fastest),
    })
}

/// All crossing cycles, of loops of every size.
pub fn crossing_cycles(oscillator: &Oscillator, tolerance: f64) -> Result<Vec<Cycle>, CyclesUnknown> {
    let far = FarLoops::new(&oscillator.curve, oscillator.belt_speed);
    crossing::crossing_cycles(oscillator, &far, tolerance).all()
}

/// The regime of a point with all of its loops, also those that reach slip speeds at which friction pushes, which
/// [`column::regime`] leaves out.
fn regime_of_all_loops(oscillator: &Oscillator) -> Regime {
    let attractors = column::regime(oscillator, &flow(oscillator, 1e-9)).attractors();
    if attractors == Regime::Failed.attractors() {
        return Regime::Failed;
    }
    let far = FarLoops::new(&oscillator.curve, oscillator.belt_speed);
    let work = Work::of(Piece::Loops, &oscillator.curve);
    let some = || some_cross_for_ever(oscillator, &far, &work);
    let crossing = if attractors.crossing { Ok(true) } else { some() };
    crossing.map_or(Regime::Failed, |crossing| Regime::of(Attractors { crossing, ..attractors }))
}

/// Friction that pushes at some slip speeds: a repelling and an attracting cycle as close as 4.6 per cent to
/// each other. Their reference places come from the classical Runge-Kutta method in (x1, x2) with steps of
/// 5e-4.
#[test]
fn narrow_pairs_of_crossing_cycles_are_found() {
    let law = formula("1-a*exp(-((u-m)/s)^2)");
    let at = |a: f64| at_one(&law, &[a, 20.0, 3.0], 1.0, 0.0);
    for (a, places) in [(2.1, [19.2815, 21.6682]), (2.01, [19.8805, 21.0246]), (2.0005, [19.9925, 20.9068])] {
        let oscillator = at(a);
        let cycles = crossing_cycles(&oscillator, 1e-9).unwrap();
        assert!(cycles.len() == 2 && !cycles[0].is_stable() && cycles[1].is_stable(), "{a} {cycles:?}");
        for (cycle, place) in cycles.iter().zip(places) {
            assert!((cycle.beyond_exit.unwrap() - place).abs() < 1e-3, "{a} {cycles:?}");
        }
        assert_eq!(regime_of_all_loops(&oscillator), Regime::StickSlipAndCrossing, "{a}");
    }
    // Down to the fold, where the two cycles meet, the pair is found or not known: its multipliers tend to 1.
    let (mut without, mut with, mut unknown, mut last) = (1.9, 2.0005, 0, Vec::new());
    for _ in 0..40 {
        let a = 0.5 * (without + with);
        match crossing_cycles(&at(a), 1e-9) {
            Ok(cycles) if cycles.is_empty() => without = a,
            Ok(cycles) => (with, last) = (a, cycles),
            Err(CyclesUnknown::TooClose) => (with, unknown) = (a, unknown + 1),
            Err(failure) => panic!("{a} {failure}"),
        }
    }
    assert!(last.len() == 2 && unknown > 0, "{last:?} {unknown}");
    assert!(last.iter().all(|cycle| (cycle.multiplier - 1.0).abs() < 0.01), "{last:?}");
}

/// Friction that pushes at high slip speeds, and little damping: cycles far beyond the exit point. The places
/// are those of loops by a Runge-Kutta method of order 5 in (x1, x2) in long double.
#[test]
fn crossing_cycles_far_out_are_found() {
    let at = |phi: &str, damping: f64| {
        let law = formula(phi);
        at_one(&law, &[], 1.0, damping)
    };
    let step = "0.6+0.4*exp(-u)-0.45*(1+tanh((u-300)/20))";
    let cases: [(&str, f64, Regime, &[f64]); 7] = [
        ("1-1.2*tanh(2*u)", 0.001, Regime::Crossing, &[253.642_573_440]),
        ("1-1.2*(1-exp(-2*u))", 1e-6, Regime::Crossing, &[254_646.908_942]),
        (step, 0.0002, Regime::StickSlipAndCrossing, &[450.592_188_442, 1_831.242_466_438]),
        // Without damping friction pushes for ever: beyond the repelling cycle orbits grow.
        (step, 0.0, Regime::StickSlipAndCrossing, &[403.192_322_713]),
        ("0.5+0.5*exp(-u)-0.01*u", 0.005, Regime::StickSlipAndCrossing, &[126.319_182_659]),
        // The damping exceeds what friction pushes.
        ("0.5+0.5*exp(-u)-0.01*u", 0.02, Regime::StickSlip, &[]),
        // Friction that vanishes never pushes, although its terms cancel.
        ("1-u/(1+u)", 0.0, Regime::StickSlip, &[]),
    ];
    for (phi, damping, regime, places) in cases {
        let oscillator = at(phi, damping);
        assert_eq!(regime_of_all_loops(&oscillator), regime, "{phi} {damping}");
        let cycles = crossing_cycles(&oscillator, 1e-12).unwrap();
        assert_eq!(cycles.len(), places.len(), "{phi} {damping} {cycles:?}");
        for (cycle, place) in cycles.iter().zip(places) {
            assert!((cycle.beyond_exit.unwrap() / place - 1.0).abs() < 2e-9, "{phi} {damping} {cycles:?}");
        }
    }
    // A narrow dip far out, between the samples of the law.
    let dip = at("0.5+0.5*exp(-u)-60*exp(-((u-3000)/20)^2)", 0.0001);
    assert_eq!(regime_of_all_loops(&dip), Regime::StickSlipAndCrossing);
    // It vanishes far out, and pushes nearer: no place is known from which on loops lead inward. Some lead
    // outward all the same.
    let vanishing = at("exp(-u)-0.3*exp(-(u-5)^2)", 0.0);
    assert_eq!(regime_of_all_loops(&vanishing), Regime::StickSlipAndCrossing);
    assert_eq!(crossing_cycles(&vanishing, 1e-9), Err(CyclesUnknown::FarOut));
    let hardly = at("exp(-u)-0.003*exp(-(u-9)^2)", 0.0);
    assert_eq!(regime_of_all_loops(&hardly), Regime::Failed);
}

/// A regime says nothing of orbits that reach friction that pushes: those of [`crossing_cycles_far_out_are_found`], whose
/// friction is 0.5 + 0.5 exp(-u) - u/100, pass the slip speed 50 at which it vanishes.
#[test]
fn regimes_leave_out_loops_that_reach_friction_that_pushes() {
    let law = formula("0.5+0.5*exp(-u)-0.01*u");
    let oscillator = at_one(&law, &[], 1.0, 0.005);
    assert_eq!(column::regime(&oscillator, &flow(&oscillator, 1e-9)), Regime::StickSlip);
    let from = FarLoops::where_friction_resists(&oscillator.curve, 1.0).left_out_from();
    assert!(from.is_some_and(|from| (from - 50.0).abs() < 1e-3), "{from:?}");
}

/// Laws that fall by W in all, some of them in steps.
fn falling(random: &mut Random, fall: f64) -> (Law, Vec<f64>) {
    let phi = "1-w*(p*(tanh((u-m)/s)+tanh(m/s))/(1+tanh(m/s))+(1-p)*(1-exp(-u/n)))";
    let m = random.log(0.01, 100.0);
    // In the order in which the formula names them.
    let values = vec![fall, random.unit(), m, m * random.log(0.02, 1.0), random.log(0.01, 100.0)];
    (formula(phi), values)
}

#[test]
fn loops_lead_inward_where_friction_falls_little() {
    let mut random = Random(0x100b5);
    for i in 0..40 {
        let fall = random.log(0.01, 0.99);
        let (law, values) = falling(&mut random, fall);
        // Up to the bound; half of them without damping.
        let belt_speed = 4.0 * (1.0 - fall) / fall * random.log(0.01, 0.999);
        let damping = if i % 2 == 0 { 0.0 } else { random.log(1e-3, 1.0) };
        let oscillator = at_one(&law, &values, belt_speed, damping);
        assert_eq!(crossing_cycles(&oscillator, 1e-9), Ok(Vec::new()), "{values:?} {belt_speed} {damping}");
        for _ in 0..4 {
            let y = random.log(1e-3, 100.0) * belt_speed.max(1.0);
            let end = crossing_loop(&oscillator, y, 1e-8).unwrap();
            let outward = matches!(end, Loop::Crosses(beyond_exit) if beyond_exit >= y);
            assert!(!outward, "{values:?} {belt_speed} {damping}: {y} {end:?}");
        }
    }
}

/// The search for cycles from outside, compared with loops of every size.
#[test]
fn regimes_have_a_crossing_cycle_where_some_loop_leads_outward() {
    let (mut random, mut found) = (Random(0xc405), [0; 2]);
    for _ in 0..24 {
        // Friction that changes its sign, on fast belts: crossing cycles are not rare.
        let fall = 0.9 + random.unit();
        let (law, values) = falling(&mut random, fall);
        let belt_speed = random.log(0.5, 30.0);
        let damping = random.log(1e-3, 0.3);
        let oscillator = at_one(&law, &values, belt_speed, damping);
        let regime = regime_of_all_loops(&oscillator);
        // The farthest cycle lies within 4 / (pi c), which is less than 1300.
        let outward = (-12..=13).any(|i| {
            let y = belt_speed.max(1.0) * 10_f64.powf(f64::from(i) / 4.0);
            matches!(crossing_loop(&oscillator, y, 1e-8), Ok(Loop::Crosses(beyond_exit)) if beyond_exit > y)
        });
        if regime == Regime::Failed {
            // Where orbits grow without bound slip cycles may have no answer.
            continue;
        }
        assert_eq!(
            regime.name().contains("crossing"),
            outward,
            "{values:?} {belt_speed} {damping}: {regime:?}"
        );
        found[usize::from(outward)] += 1;
    }
    assert!(found.iter().all(|count| *count > 4), "{found:?}");
}

#[test]
fn without_positive_divergence_nothing_crosses_for_ever() {
    let (mut random, mut contracting) = (Random(0xd1), 0);
    for _ in 0..300 {
        let sample = random.anywhere();
        // From half the damping at which the divergence is nowhere positive to twice that.
        let damping = sample.gamma * (1.0 - sample.alpha) * random.log(0.5, 2.0);
        let point = Sample { damping, ..sample };
        let oscillator = point.oscillator();
        if oscillator.divergence(0.0) > 0.0 {
            continue;
        }
        contracting += 1;
        assert_eq!(crossing_cycles(&oscillator, 1e-9), Ok(Vec::new()), "{point:?}");
        // Loops all lead inward, as far as they are followed.
        for size in [0.01, 1.0, 10.0] {
            let end = crossing_loop(&oscillator, size, 1e-9).unwrap();
            let inward = match end {
                Loop::Crosses(beyond_exit) => beyond_exit < size,
                Loop::Sticks | Loop::SpiralsInward => true,
            };
            assert!(inward, "{point:?} {size}: {end:?}");
        }
    }
    assert!(contracting > 100, "{contracting}");
}

/// Where friction vanishes at large slip speeds, it changes a large loop by less than the error of a turn.
#[test]
fn loops_within_their_error_are_no_crossing_cycles() {
    let point = Law::Lorentzian.point(1.0, &[0.0, 0.778296192924968, 0.0], 18.91061728510668, 0.0).unwrap();
    let cycles = crossing_cycles(&Oscillator::new(&Law::Lorentzian, &point), 1e-9).unwrap();
    assert!(cycles.len() == 1 && cycles[0].is_stable(), "{cycles:?}");
}

/// A repelling cycle that crosses the belt line, between stick-slip and an attracting cycle that crosses.
#[test]
fn a_repelling_crossing_cycle_separates_its_neighbours() {
    let law = formula("1-a*(tanh((u-m)/s)+tanh(m/s))");
    let oscillator = at_one(&law, &[1.0, 20.5, 1.0], 10.0, 0.002);
    let answer = flow(&oscillator, 1e-10);
    let cycles = crossing_cycles(&oscillator, 1e-10).unwrap();
    assert!(cycles.len() == 2 && !cycles[0].is_stable() && cycles[1].is_stable(), "{cycles:?}");
    assert_eq!(
        crossing_separates(0, cycles.len(), 1, &answer.fate),
        [Neighbour::StickSlip, Neighbour::Crossing]
    );
    // The ends of loops that start on either side of the cycle.
    let ends = [-1e-3, 1e-3].map(|shift| {
        let mut y = cycles[0].beyond_exit.unwrap() * (1.0 + shift);
        for _ in 0..1000 {
            match crossing_loop(&oscillator, y, 1e-9).unwrap() {
                Loop::Crosses(beyond_exit) => y = beyond_exit,
                Loop::Sticks => return 0.0,
                Loop::SpiralsInward => return f64::NAN,
            }
        }
        y
    });
    assert_eq!(ends[0], 0.0);
    assert!(
        ends[1] > 2.0 * cycles[0].beyond_exit.unwrap() && ends[1] < cycles[1].beyond_exit.unwrap(),
        "{ends:?}"
    );
}

/// The stick-slip cycle and the crossing cycle both attract, up to the damping at which the crossing cycles
/// vanish.
#[test]
fn crossing_around_stick_slip_belongs_to_the_regime() {
    let law = formula("1-a*(tanh((u-m)/s)+tanh(m/s))");
    let at = |c: f64| {
        let oscillator = at_one(&law, &[1.0, 20.5, 1.0], 10.0, c);
        let cycles = crossing_cycles(&oscillator, 1e-10).unwrap();
        (regime_of_all_loops(&oscillator), cycles.len())
    };
    assert_eq!(at(0.002), (Regime::EquilibriumStickSlipAndCrossing, 2));
    let (regime, cycles) = at(0.2);
    assert!(cycles == 0 && !regime.name().contains("crossing"), "{regime:?}");
    let (mut last, mut both) = (2, 0);
    for i in 0..20 {
        let (regime, cycles) = at(0.002 + 0.002 * f64::from(i));
        assert_eq!(regime.name().contains("crossing"), cycles > 0, "{i}: {regime:?}");
        assert!(cycles <= last, "{i}: {cycles}");
        last = cycles;
        both += cycles / 2;
    }
    assert!((1..20).contains(&both), "{both}");
}

/// Far from the belt line the divergence is -2 up to exp(-2V): an orbit turns once in exp(V) units of time,
/// while its distance from the equilibrium falls below the smallest positive double.
#[test]
fn orbits_of_nearly_critical_damping_come_to_rest() {
    let law = formula("exp(-2*u)");
    for belt_speed in [5.0, 10.0, 15.0] {
        for damping in [1.999_999, 2.0, 2.000_001] {
            let oscillator = at_one(&law, &[], belt_speed, damping);
            assert_eq!(
                crossing_loop(&oscillator, 0.1, 1e-8),
                Ok(Loop::SpiralsInward),
                "{belt_speed} {damping}"
            );
            assert_eq!(crossing_cycles(&oscillator, 1e-9), Ok(Vec::new()), "{belt_speed} {damping}");
            let regime = column::regime(&oscillator, &flow(&oscillator, 1e-9));
            assert_eq!(regime, Regime::Equilibrium, "{belt_speed} {damping}");
        }
    }
}

/// Two crossing cycles within the error of each other leave the other cycles known.
#[test]
fn cycles_are_known_where_those_of_another_kind_are_not() {
    let law = formula("1-a*exp(-((u-20)/3)^2)");
    let at = |a: f64| at_one(&law, &[a], 1.0, 0.0);
    let (mut without, mut with) = (1.9, 2.0005);
    let meeting = loop {
        let oscillator = at(0.5 * (without + with));
        match crossing_cycles(&oscillator, 1e-9) {
            Ok(cycles) => {
                *(if cycles.is_empty() { &mut without } else { &mut with }) = 0.5 * (without + with)
            }
            Err(unknown) => {
                assert_eq!(unknown, CyclesUnknown::TooClose);
                break oscillator;
            }
        }
    };
    let stick_slip = stick_slip_cycle(&meeting, &flow(&meeting, 1e-9), 1e-9);
    assert!(matches!(stick_slip, Ok(Some(_))), "{stick_slip:?}");
    assert_eq!(slip_cycles(&meeting, 1e-13), Ok(Vec::new()));
}

/// Friction that falls without end, a little slower than the damping rises: all loops lead inward. With so
/// little friction the backbone is that of circles, 0.01 (1 - 1.5 cos(7.2) 2 J1(x)/x), x = 7.2 r, which has
/// its maximum at 0.0112, at x = 5.14.
#[test]
fn damping_may_outweigh_friction_that_falls_without_end() {
    let law = formula("1 - 0.01*(u - 1.5*sin(7.2*u)/7.2)");
    let slips = Regime::PureSlipAndEquilibrium;
    for (damping, regime) in [(0.0102, slips), (0.0105, slips), (0.0115, Regime::Equilibrium)] {
        let oscillator = at_one(&law, &[], 1.0, damping);
        assert_eq!(crossing_cycles(&oscillator, 1e-9), Ok(Vec::new()), "{damping}");
        assert_eq!(regime_of_all_loops(&oscillator), regime, "{damping}");
    }
}

/// A step of friction of 1/1300 of the belt speed, below zero: loops from 0.326181 beyond the exit point on
/// grow without bound, by a Runge-Kutta method of order 8 in long double whose steps end around the step of
/// friction.
#[test]
fn loops_see_narrow_steps() {
    let law = formula("1-a*u/(u+b)-d*(tanh((u-p)/w)+tanh(p/w))/2");
    let parameters = [
        0.3701101710434796,
        0.4727132847066705,
        0.8229831512781614,
        0.5532940419756395,
        0.0008720825005406945,
    ];
    let oscillator = at_one(&law, &parameters, 1.1200212344136085, 0.000130602506763018);
    assert_eq!(regime_of_all_loops(&oscillator), Regime::StickSlipAndCrossing);
    for (beyond_exit, grows) in [(0.3261, false), (0.3263, true)] {
        let found = crossing_loop(&oscillator, beyond_exit, 1e-10).unwrap();
        let outward = matches!(found, Loop::Crosses(next) if next > beyond_exit);
        assert_eq!(outward, grows, "{beyond_exit} {found:?}");
    }
}

//! Orbits that cross, cycles, basins, and the cost of flows.

use super::{Six, anywhere, contacts, coulomb, oscillator, overshooting};
use crate::sample::Random;
use slipmap::filippov::Side;
use slipmap::flow::Fate;
use slipmap::witness::{Ending, Phase, Start, flow, trace};

/// An orbit that crosses back never sticks: its downward crossings move outward for ever.
#[test]
fn crossing_orbits_are_nested_and_never_stick() {
    let mut random = Random(31);
    let (mut followed, mut turns) = (0, 0);
    while followed < 2000 {
        let oscillator = oscillator(overshooting(&mut random));
        if flow(&oscillator, 1e-10).fate != Fate::CrossesForever {
            continue;
        }
        followed += 1;
        let traced = trace(&oscillator, Start::ExitPoint, 1e-10, 200.0);
        assert_eq!(traced.ending, Ending::OutOfTime);
        assert!(traced.samples.iter().all(|sample| sample.phase != Phase::Stick));
        let contacts = contacts(&traced, oscillator.belt_speed);
        // The exit point itself comes first.
        let down: Vec<f64> =
            contacts.iter().filter(|s| s.phase == Phase::Slip(Side::Below)).map(|s| s.x1).collect();
        assert_eq!(down[0], oscillator.exit_x1());
        turns += down.len() - 1;
        for pair in down.windows(2) {
            // Once on the crossing cycle, differences are errors: 1e-10 V a turn, seen at |w| > 2.
            let noise = 1e-8 * oscillator.belt_speed * (1.0 + oscillator.belt_speed);
            assert!(pair[1] > pair[0] - noise, "{oscillator:?}: {down:?}");
        }
        assert!(down[1] > down[0], "{oscillator:?}: {down:?}");
    }
    println!("{followed} orbits, {turns} turns");
}

#[test]
fn a_traced_cycle_closes_with_the_period_of_the_flow() {
    let mut random = Random(32);
    let mut cycles = 0;
    while cycles < 100 {
        let oscillator = oscillator(anywhere(&mut random));
        let Fate::Sticks(landing) = flow(&oscillator, 1e-11).fate else { continue };
        let period = landing.slip_time + landing.stick_time;
        // An event that is too close to call may have either outcome.
        if oscillator.exit_x1() - landing.x1 < 1e-3 {
            continue;
        }
        cycles += 1;
        let traced = trace(&oscillator, Start::ExitPoint, 1e-11, 1000.0);
        let Ending::Closes { period: traced_period } = traced.ending else {
            panic!("{oscillator:?}: {:?}", traced.ending)
        };
        let slack = 1e-7 * (1.0 + 1.0 / oscillator.belt_speed);
        assert!((traced_period - period).abs() < slack, "{traced_period} against {period}");
        let (first, last) = (traced.samples[0], traced.samples[traced.samples.len() - 1]);
        assert_eq!((first.x1, first.x2, first.t), (oscillator.exit_x1(), oscillator.belt_speed, 0.0));
        assert_eq!((last.x1, last.x2, last.t), (first.x1, first.x2, traced_period));
        for pair in traced.samples.windows(2) {
            assert!(pair[0].t < pair[1].t, "{pair:?}");
            let slips = pair[0].phase != Phase::Stick;
            assert!(!slips || pair[1].t - pair[0].t <= 0.1 + 1e-12, "{pair:?}");
            let below = pair[0].phase == Phase::Slip(Side::Below);
            assert!(!below || pair[1].x2 <= oscillator.belt_speed, "{pair:?}");
        }
    }
}

#[test]
fn a_trace_may_end_while_the_mass_sticks() {
    let short = trace(&coulomb(0.1, 1.0), Start::State { x1: -0.5, x2: 1.0 }, 1e-10, 0.25);
    assert_eq!(short.ending, Ending::OutOfTime);
    let last = short.samples[short.samples.len() - 1];
    assert_eq!((last.t, last.x2, last.phase), (0.25, 1.0, Phase::Stick));
    assert!((last.x1 + 0.25).abs() < 1e-15);
}

#[test]
fn slow_creep_is_recognised_when_steps_run_out() {
    let oscillator = coulomb(1e5, 1.0);
    let traced = trace(&oscillator, Start::State { x1: 1.0, x2: 0.9 }, 1e-9, 1e7);
    assert_eq!(traced.ending, Ending::Settles);
}

/// Numbers of right-hand sides of a few flows at tolerances 1e-9 and 1e-12: a change of this table is a
/// change of cost, to be made deliberately.
#[test]
fn the_work_of_reference_flows_is_known() {
    let cases: [(&str, Six, [u64; 2]); 5] = [
        ("spirals inward", [0.1, 0.4, 0.2, 2.0, 1.0, 1.0], [288, 720]),
        ("double crossing", [1e-4, 0.5, 0.2, 2.0, 1.0, 0.1], [313, 733]),
        ("sticks", [0.05, 0.1, 0.1, 8.0, 1.0, 2.0], [301, 800]),
        ("overshoots", [1.0, 0.0, 0.0, 0.1, 30.0, 0.0], [447, 987]),
        ("creeps", [1.0, 0.5, 0.1, 1.0, 1.0, 5.0], [12, 24]),
    ];
    let counted = cases.map(|(_, point, _)| [1e-9, 1e-12].map(|tol| flow(&oscillator(point), tol).rhs));
    assert_eq!(counted, cases.map(|(_, _, expected)| expected));
}

//! Linear orbits, whose solutions are known, and points at which other solvers fail.

use super::oracle::bisect;
use super::{Six, contacts, coulomb, oscillator};
use slipmap::filippov::Side;
use slipmap::flow::{Failure, Fate, Flow, Landing};
use slipmap::witness::{Phase, Start, flow, trace};
use std::f64::consts::{PI, TAU};

fn landing(answer: &Flow) -> Landing {
    match answer.fate {
        Fate::Sticks(landing) => landing,
        fate => panic!("it does not stick: {fate:?}"),
    }
}

/// v = x2 and w = x2' after a time `t` of v'' + `viscous` v' + v = 0, `viscous` < 2.
fn linear(viscous: f64, [v, w]: [f64; 2], t: f64) -> [f64; 2] {
    let half = 0.5 * viscous;
    let omega = (1.0 - half * half).sqrt();
    let (sin, cos) = (omega * t).sin_cos();
    let decay = (-half * t).exp();
    let rate = (w + half * v) / omega;
    let across = -half * rate - omega * v;
    [decay * (v * cos + rate * sin), decay * (w * cos + across * sin)]
}

/// After one turn of 2 pi / omega the linear orbit is back at the same angle, scaled by
/// exp(-pi viscous / omega).
fn linear_margin(viscous: f64) -> f64 {
    (-PI * viscous / (1.0 - 0.25 * viscous * viscous).sqrt()).exp_m1()
}

#[test]
fn coulomb_friction_with_damping_has_the_closed_margin() {
    for belt_speed in [0.1, 1.0, 7.3] {
        for viscous in [1e-9, 1e-6, 1e-3, 0.1, 0.7, 1.5, 1.9] {
            for tolerance in [1e-6, 1e-9, 1e-12, 1e-13] {
                let answer = flow(&coulomb(viscous, belt_speed), tolerance);
                let error = (answer.margin - linear_margin(viscous)).abs();
                let context = format!("V {belt_speed}, C {viscous}, tolerance {tolerance}: {answer:?}");
                assert!(error <= answer.margin_error, "error {error:e}, {context}");
                // The tolerance, or the rounding errors, about 3e-14 max(1, 1/V): both per 2 pi of time.
                let turns = 1.0 / (1.0 - 0.25 * viscous * viscous).sqrt();
                let floor = 3e-14 * (1.0 / belt_speed).max(1.0);
                assert!(answer.margin_error <= turns * (tolerance + floor), "{context}");
                let expected = match answer.margin {
                    margin if margin < -answer.margin_error => Fate::SpiralsInward,
                    _ => Fate::TooCloseToCall,
                };
                assert_eq!(answer.fate, expected, "{context}");
            }
        }
    }
}

#[test]
fn overdamped_orbits_creep_into_the_equilibrium() {
    for viscous in [2.0, 2.0 + 1e-9, 3.0, 10.0, 1000.0, 1e6] {
        for belt_speed in [0.1, 1.0, 10.0] {
            let answer = flow(&coulomb(viscous, belt_speed), 1e-9);
            assert_eq!((answer.fate, answer.margin), (Fate::SpiralsInward, -1.0), "{answer:?}");
            assert!(answer.margin_error <= 1e-9);
        }
    }
    // Just below critical damping the turn takes 2 pi / omega = 1e5 and the orbit decays to nothing.
    let answer = flow(&coulomb(2.0 - 1e-9, 1.0), 1e-9);
    assert_eq!(answer.fate, Fate::SpiralsInward);
    assert!((answer.margin + 1.0).abs() <= answer.margin_error && answer.margin_error < 1e-8);
}

/// Coulomb friction with negative damping: the orbit grows by a known factor, lands, and if the belt is fast
/// enough crosses.
#[test]
fn growing_linear_orbits_land_cross_and_return_as_they_must() {
    let mut seen = [0; 3];
    for viscous in [-1e-3, -0.01, -0.03, -0.05, -0.1, -0.3] {
        for belt_speed in [0.2, 1.0, 5.0, 10.0, 20.0, 50.0, 200.0] {
            let oscillator = coulomb(viscous, belt_speed);
            let answer = flow(&oscillator, 1e-12);
            let margin = linear_margin(viscous);
            if margin < 0.1 {
                let error = (answer.margin - margin).abs();
                assert!(error <= answer.margin_error && answer.margin_error < 2e-12, "{answer:?}");
            } else {
                assert!(answer.margin.is_nan(), "{answer:?}");
            }
            // On its way up the orbit meets the line in the last quarter turn.
            let omega = (1.0 - 0.25 * viscous * viscous).sqrt();
            let at = |t: f64| linear(viscous, [belt_speed, 0.0], t);
            let quarter = 0.25 * TAU / omega;
            let slip_time = 3.0 * quarter + bisect(quarter, |t| at(3.0 * quarter + t)[0] < belt_speed);
            let speed = at(slip_time)[1];
            // The time of landing has the error of x2 over the speed; V of it becomes x1.
            let accuracy = 1e-11 * belt_speed * (1.0 + belt_speed / speed);
            let context = format!("C {viscous}, V {belt_speed}: {answer:?}, landing speed {speed}");
            if speed < 2.0 {
                seen[0] += 1;
                let landing = landing(&answer);
                assert_eq!(landing.crossings, Some(0), "{context}");
                assert!((landing.slip_time - slip_time).abs() < accuracy, "{context}");
                assert!((landing.x1 - (oscillator.exit_x1() - speed)).abs() < accuracy, "{context}");
                assert!((landing.stick_time - speed / belt_speed).abs() < accuracy, "{context}");
                continue;
            }
            // Above the line v'' + C v' + v = 0 as well, with w less by 2.
            let up = |t: f64| linear(viscous, [belt_speed, speed - 2.0], t);
            let top = bisect(quarter, |t| up(t)[1] > 0.0);
            let arc = top + bisect(2.0 * quarter, |t| up(top + t)[0] > belt_speed);
            let back = up(arc)[1];
            if back > -2.0 {
                seen[1] += 1;
                let landing = landing(&answer);
                assert_eq!(landing.crossings, Some(1), "{context}");
                assert!((landing.slip_time - slip_time - arc).abs() < 2.0 * accuracy, "{context}");
                let x1 = oscillator.exit_x1() - 2.0 - back;
                assert!((landing.x1 - x1).abs() < 2.0 * accuracy, "{context}, expected {x1}");
            } else {
                seen[2] += 1;
                assert_eq!(answer.fate, Fate::CrossesForever, "{context}");
            }
        }
    }
    assert!(seen.iter().all(|&n| n >= 3), "sticks, sticks from above, crosses: {seen:?}");
}

#[test]
fn dry_friction_alone_shrinks_crossing_orbits_by_four() {
    // Circles about x1 = 1 below and x1 = -1 above the line: x1 = 1 + a goes to 1 - a, then to a - 3.
    for belt_speed in [0.3, 1.0, 8.0] {
        let oscillator = coulomb(0.0, belt_speed);
        let start = Start::State { x1: 1.0 + 11.3, x2: belt_speed };
        let traced = trace(&oscillator, start, 1e-12, 1000.0);
        let met: Vec<_> = contacts(&traced, belt_speed).iter().map(|s| (s.x1, s.phase)).collect();
        let (below, above) = (Phase::Slip(Side::Below), Phase::Slip(Side::Above));
        let expected = [
            (12.3, below),
            (-10.3, above),
            (8.3, below),
            (-6.3, above),
            (4.3, below),
            (-2.3, above),
            (0.3, Phase::Stick),
            (1.0, below),
        ];
        for ((x1, phase), (exact, expected)) in met.iter().zip(expected) {
            assert_eq!(*phase, expected);
            // 1e-12 V per turn, seen under the angle of the slowest contact, |w| = 0.3 or more.
            assert!((x1 - exact).abs() < 1e-10 * belt_speed.max(1.0), "{met:?}");
        }
        // Then the orbit from the exit point touches the line for ever, so that its fate is undecided.
        assert!(met.len() >= expected.len());
    }
}

#[test]
fn traces_from_anywhere_follow_the_damped_linear_solution() {
    let (viscous, belt_speed) = (0.2, 1.5);
    let oscillator = coulomb(viscous, belt_speed);
    let mut all = 0;
    for (x1, x2) in [(-3.0, 0.0), (2.5, -1.0), (0.0, -4.0), (-2.5, 4.0), (4.0, 1.6), (1.0, 1.4)] {
        let traced = trace(&oscillator, Start::State { x1, x2 }, 1e-12, 30.0);
        let side = if x2 > belt_speed { Side::Above } else { Side::Below };
        let start = [x2, oscillator.acceleration(side, x1, x2)];
        let first_arc = traced.samples.iter().take_while(|s| s.x2 != belt_speed);
        let mut followed = 0;
        for sample in first_arc {
            let [v, w] = linear(viscous, start, sample.t);
            let friction = if side == Side::Below { 1.0 } else { -1.0 };
            assert!((sample.x2 - v).abs() < 2e-11, "{sample:?} instead of v = {v}");
            assert!((sample.x1 - (friction - viscous * v - w)).abs() < 2e-11, "{sample:?}");
            assert_eq!(sample.phase, Phase::Slip(side));
            followed += 1;
        }
        assert!(followed >= 1);
        all += followed;
        if let Some(contact) = contacts(&traced, belt_speed).first() {
            let v = linear(viscous, start, contact.t)[0];
            assert!((v - belt_speed).abs() < 2e-11, "contact at {} has v = {v}", contact.t);
        }
    }
    assert!(all > 100, "only {all} samples");
}

#[test]
fn hostile_points_end_with_a_reason() {
    let nan = f64::NAN;
    let points: [Six; 21] = [
        [1.0, 0.0, 0.0, 100.0, 10.0, 0.0],
        [1.0, 0.0, 0.0, 100.0, 10.0, 1000.0],
        [1.0, 0.5, 1.0, 100.0, 10.0, 1000.0],
        [1.0, 0.0, 0.0, 2000.0, 10.0, 1000.0],
        [1.0, 0.0, 100.0, 0.0, 10.0, 0.0],
        [1e-3, 0.0, 0.0, 1e9, 1.0, 0.0],
        [1e8, 0.0, 0.0, 1.0, 1.0, 0.0],
        [1e8, 0.0, 0.0, 1e8, 1.0, 0.0],
        [1e4, 0.0, 0.0, 1.0, 1e-4, 9e3],
        [1e-4, 0.5, 0.2, 2.0, 1e-6, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e-15, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e-300, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 8.903e-321, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e8, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e300, 0.1],
        [1.0, 1.0, 0.0, 0.0, 1.0, 1e12],
        [1.0, 1.0, 0.0, 0.0, 1.0, -2.0],
        [1.0, 1.0, 0.0, 0.0, 1.0, -1e6],
        [nan, 1.0, 0.0, 0.0, 1.0, 1.0],
        [1.0, 1.0, 0.0, 0.0, nan, 1.0],
        [1.0, 1.0, 0.0, 0.0, f64::INFINITY, 1.0],
    ];
    for point in points {
        let oscillator = oscillator(point);
        for tolerance in [1e-9, 0.0, -1.0, nan, f64::INFINITY] {
            let answer = flow(&oscillator, tolerance);
            // The step budget of 100,000, twelve right-hand sides each.
            assert!(answer.rhs <= 1_200_000, "{point:?}: {answer:?}");
            if point.iter().any(|x| x.is_nan()) {
                assert_eq!(answer.fate, Fate::Failed(Failure::NotFinite), "{point:?}");
            }
        }
        let traced = trace(&oscillator, Start::State { x1: 0.3, x2: 1.0 }, 1e-9, 10.0);
        assert!(traced.samples.len() <= 200_000);
    }
    // At a divergence of 2 and more the orbit diverges without turning.
    assert_eq!(flow(&coulomb(-2.0, 1.0), 1e-9).fate, Fate::Failed(Failure::NotFinite));
    assert_eq!(flow(&coulomb(-2.5, 1.0), 1e-9).fate, Fate::Failed(Failure::NotFinite));
    assert_eq!(flow(&oscillator(points[1]), 1e-9).fate, Fate::SpiralsInward);
    assert_eq!(flow(&oscillator(points[3]), 1e-9).fate, Fate::SpiralsInward);
}

/// Far too stiff orbits: the budget of steps would pass without a change of x2 or x2' in the sixth digit.
#[test]
fn orbits_that_hardly_move_are_given_up_early() {
    for damping in [0.0, 1e-300, 1.0 / 15.0] {
        let answer = flow(&oscillator([1e300, 0.3, 0.1, 1.0, 1.0, damping]), 1e-9);
        assert!(matches!(answer.fate, Fate::Failed(_) | Fate::TooCloseToCall), "{answer:?}");
        assert!(answer.rhs < 100_000, "{answer:?}");
    }
}

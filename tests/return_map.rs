//! The return map and the critical damping against the extended-precision reference.

mod common;

use common::{ReferenceFate, critical_points, margin_points};
use slipmap::filippov::Oscillator;
use slipmap::friction::Law;
use slipmap::simulate::return_map::{Turn, turns_of};
use slipmap::simulate::{Fate, critical_damping, flow};

#[test]
fn critical_damping_to_twelve_digits() {
    let mut worst: f64 = 0.0;
    for point in critical_points() {
        let found = critical_damping(&Law::Stribeck.column(&point.at(0.0)), 1e-15).unwrap();
        let error = (found.c - point.critical_c).abs();
        assert!(error <= found.error, "{point:?}: {found:?} is off by {error:e}");
        // c* is the difference of terms of size A / eps; twelve digits of it, or of those where they cancel.
        worst = worst.max(error / point.critical_c);
    }
    assert!(worst < 1e-12, "{worst:e}");
}

#[test]
fn critical_damping_keeps_its_promise_at_every_tolerance() {
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12] {
        for point in critical_points() {
            let found = critical_damping(&Law::Stribeck.column(&point.at(0.0)), tolerance).unwrap();
            let error = (found.c - point.critical_c).abs();
            assert!(error <= found.error, "{tolerance:e} {point:?}: {found:?} is off by {error:e}");
        }
    }
}

#[test]
fn verdicts_next_to_the_boundary() {
    for point in critical_points() {
        for (factor, sticks) in [(1.0 - 1e-9, true), (1.0 + 1e-9, false)] {
            let at = point.at(point.critical_c * factor);
            let answer = flow(&Oscillator::new(Law::Stribeck, &at), 1e-9);
            match answer.fate {
                Fate::Sticks(_) => assert!(sticks, "{at:?} {answer:?}"),
                Fate::SpiralsInward => assert!(!sticks, "{at:?} {answer:?}"),
                Fate::CrossesForever | Fate::TooCloseToCall | Fate::Failed(_) => {
                    panic!("{at:?} {answer:?}")
                }
            }
        }
    }
}

#[test]
fn margins_are_within_their_error() {
    let mut checked = 0;
    for tolerance in [1e-6, 1e-9, 1e-12] {
        for point in margin_points() {
            let Some(margin) = point.margin else { continue };
            let at = point.point();
            let turn = turns_of(&Law::Stribeck.column(&at), &[at.damping], tolerance)[0];
            let Turn::Complete { margin: found, error, .. } = turn else { continue };
            checked += 1;
            assert!((found - margin).abs() <= error, "{tolerance:e} {point:?}: {turn:?}");
            assert!(error <= 2.0 * tolerance, "{tolerance:e} {point:?}: {turn:?}");
        }
    }
    assert!(checked > 600, "{checked}");
}

#[test]
fn fates_and_landings() {
    for point in margin_points() {
        let oscillator = Oscillator::new(Law::Stribeck, &point.point());
        let answer = flow(&oscillator, 1e-10);
        match (answer.fate, point.fate) {
            (Fate::Sticks(landing), ReferenceFate::Sticks | ReferenceFate::SticksFromAbove) => {
                assert_eq!(landing.crossings, u32::from(point.fate == ReferenceFate::SticksFromAbove));
                for (found, expected) in [
                    (landing.x1, point.landing_x1),
                    (landing.slip_time, point.slip_time),
                    (landing.stick_time, point.stick_time),
                ] {
                    // Next to grazing the landing is the root of a double zero: the square root of the
                    // tolerance is all that the flow's tolerance promises.
                    let expected = expected.unwrap();
                    assert!(
                        (found - expected).abs() <= 1e-5 * (1.0 + expected.abs()),
                        "{point:?} {answer:?}"
                    );
                }
            }
            (Fate::SpiralsInward, ReferenceFate::Inward)
            | (Fate::CrossesForever, ReferenceFate::CrossesForever) => {}
            _ => panic!("{point:?} {answer:?}"),
        }
    }
}

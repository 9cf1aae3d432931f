//! The orbit from the exit point and the critical damping compared with the extended-precision reference.

use crate::reference::{ReferenceFate, critical_points, margin_points};
use crate::sample::{ENGINES, at_one, formula};
use slipmap::column::critical_damping;
use slipmap::filippov::Oscillator;
use slipmap::flow::{Fate, Flow};
use slipmap::friction::{Column, Expression, Law};
use slipmap::orbits::flow;
use slipmap::point::Point;

/// Within its error at every tolerance, too.
#[test]
fn critical_damping_to_twelve_digits() {
    for tolerance in [1e-4, 1e-6, 1e-8, 1e-10, 1e-12, 1e-15] {
        for point in critical_points() {
            let found = critical_damping(&Law::Stribeck.column(&point.at(0.0)), tolerance).unwrap();
            let error = (found.c - point.critical_c).abs();
            assert!(error <= found.error, "{tolerance:e} {point:?}: {found:?} is off by {error:e}");
            // c* is the difference of terms of size A / eps; twelve digits of it, or of those where they
            // cancel.
            assert!(tolerance > 1e-15 || error < 1e-12 * point.critical_c, "{point:?}: {error:e}");
        }
    }
}

/// Next to grazing the landing speed is that of the margin, x2'^2 = V^2 m (2 + m), but for the growth on the
/// last arc: an orbit followed to the belt line has lost the digits of the margin. At the first of these
/// points it was 1.6 times as large.
#[test]
fn landings_next_to_grazing_are_those_of_the_margin() {
    let laws = [
        (Law::Exponential, [0.150_201_7, 1.500_303_5, 0.008_349_5], 0.729_302_7),
        (Law::Exponential, [0.489_692_2, 1.846_561_4, 0.048_654_9], 1.132_166_2),
        (Law::Lorentzian, [0.904_668_6, 0.338_066_0, 0.081_674_8], 0.111_497_6),
        (Law::Stribeck, [0.624_267_5, 0.061_294_3, 0.863_320_0], 0.486_640_6),
    ];
    let mut landed = 0;
    for (law, parameters, belt_speed) in laws {
        let at = |damping: f64| law.point(1.0, &parameters, belt_speed, damping).unwrap();
        let critical = critical_damping(&law.column(&at(0.0)), 1e-15).unwrap();
        for share in [1e-12, 3e-12, 1e-11, 1e-10, 1e-8] {
            let answer = flow(&Oscillator::new(&law, &at(critical.c * (1.0 - share))), 1e-9);
            let Fate::Sticks(landing) = answer.fate else { continue };
            let angle = (answer.margin * (2.0 + answer.margin)).sqrt();
            let off = (landing.stick_time - angle).abs();
            assert!(off <= 2.0 * answer.margin_error / angle + angle * angle, "{law:?} {share} {answer:?}");
            landed += 1;
        }
    }
    assert!(landed > 15, "{landed}");
}

/// Orbits on very slow belts are those of slow ones in units of the belt speed; the divergence is 0.2 on
/// both.
#[test]
fn landings_on_very_slow_belts_are_those_of_slow_ones() {
    let stick_time = |belt_speed: f64| {
        let point = Law::Stribeck.point(1.0, &[0.0, 0.0, 0.3], belt_speed, 0.1).unwrap();
        match flow(&Oscillator::new(&Law::Stribeck, &point), 1e-9).fate {
            Fate::Sticks(landing) => landing.stick_time,
            fate => panic!("{belt_speed:e}: {fate:?}"),
        }
    };
    let expected = stick_time(1e-20);
    for belt_speed in [1e-100, 1e-170, 1e-250] {
        let found = stick_time(belt_speed);
        assert!((found / expected - 1.0).abs() < 1e-9, "{belt_speed:e}: {found} {expected}");
    }
}

/// Of Stribeck's law as it is built in, and as text.
#[test]
fn margins_are_within_their_error() {
    let law = formula("(1 - alpha)/(1 + eps*gamma*u) + alpha + eps*beta*u^2");
    let as_text = |at: &Point| {
        let &[alpha, beta, gamma] = at.law.as_slice() else { panic!("three parameters") };
        law.column(&law.point(at.epsilon, &[alpha, gamma, beta], at.belt_speed, at.damping).unwrap())
    };
    let built_in = |at: &Point| Law::Stribeck.column(at);
    for (column, least) in [(&built_in as &dyn Fn(&Point) -> Column, 600), (&as_text, 200)] {
        let mut checked = [0; 2];
        for tolerance in [1e-6, 1e-9, 1e-12] {
            for point in margin_points() {
                let Some(margin) = point.margin else { continue };
                let at = point.point();
                let told = flow(&Oscillator::in_column(&column(&at), at.damping), tolerance);
                let Flow { margin: found, margin_error: error, .. } = told;
                if found.is_nan() {
                    continue;
                }
                checked[usize::from(found > 0.0)] += 1;
                assert!((found - margin).abs() <= error, "{tolerance:e} {point:?}: {told:?}");
                // The series of a margin far beyond the belt line has an error of its own.
                assert!(error <= 2.0 * tolerance || found > 1e-6, "{tolerance:e} {point:?}: {told:?}");
            }
        }
        assert!(checked.iter().sum::<u32>() > least && checked.iter().all(|&of| of > 100), "{checked:?}");
    }
}

/// An orbit that lands next to the end of the stick segment: by 128 bits at wL = 2.0000000012596, so that it
/// crosses once. That is within the error of the witness, not of the arcs. A little more damping, or less,
/// leaves no doubt.
#[test]
fn crossings_within_the_error_of_the_landing_are_not_told() {
    let c = 0.008_231_009_388_862_14;
    let point = |c: f64| {
        let law = [0.0, 6.595376183578907e-06, 0.5064229895966048];
        at_one(&Law::Stribeck, &law, 27.350261448670107, c)
    };
    let crossings = |fate: Fate| match fate {
        Fate::Sticks(landing) => landing.crossings,
        fate => panic!("{fate:?}"),
    };
    for ((_, answer), next_to) in ENGINES.into_iter().zip([Some(1), None]) {
        assert_eq!(crossings(answer(&point(c), 1e-9).fate), next_to);
        for (factor, known) in [(1.0 + 1e-6, 0), (1.0 - 1e-6, 1)] {
            assert_eq!(crossings(answer(&point(c * factor), 1e-9).fate), Some(known));
        }
    }
}

#[test]
fn fates_and_landings() {
    for point in margin_points() {
        let oscillator = Oscillator::new(&Law::Stribeck, &point.point());
        let answer = flow(&oscillator, 1e-10);
        match (answer.fate, point.fate) {
            (Fate::Sticks(landing), ReferenceFate::Sticks | ReferenceFate::SticksFromAbove) => {
                assert_eq!(landing.crossings, Some(u32::from(point.fate == ReferenceFate::SticksFromAbove)));
                for (found, expected) in [
                    (landing.x1, point.landing_x1),
                    (landing.slip_time, point.slip_time),
                    (landing.stick_time, point.stick_time),
                ] {
                    // Near grazing the landing is a nearly double root: only the square root of the flow's
                    // tolerance is guaranteed.
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

/// A kink beyond twice the belt speed, which the orbit reaches just before it turns: steps end there. The numbers are those of
/// scripts/evidence/survey.c.
#[test]
fn no_step_passes_over_a_kink_far_out() {
    let formula = "1 - 0.45474*(1 - exp(-u/0.1636809462)) + 0.24524*(abs(u - 0.32808) - 0.32808) + 0.24524*u";
    let law = Law::Expression(Expression::new(formula, 1.0).unwrap());
    let oscillator = Oscillator::new(&law, &law.point(1.0, &[], 0.072_718, 0.551_95).unwrap());
    let landing = flow(&oscillator, 1e-9).landing().unwrap();
    let off = [landing.x1 - 0.491_862_235_346_526_4, landing.slip_time - 4.359_499_805_488_844];
    assert!(off.iter().all(|off| off.abs() < 1e-8), "{landing:?} {off:?}");
}

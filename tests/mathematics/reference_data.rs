//! The crate's closed-form tests and the simulated flow compared with the reference tables.

use slipmap::certify::{Decision, Test, harmonic_balance, instability, symmetric};
use slipmap::filippov::Oscillator;
use slipmap::friction::Law;
use slipmap::point::Point;
use slipmap::simulate::{Fate, Landing, flow};

use crate::reference::{CriticalPoint, MarginPoint, ReferenceFate, critical_points, margin_points};

/// Rounding of a closed form that is a difference of two terms of this size, neither of which took more than
/// ten rounded operations.
fn rounding(p: &CriticalPoint) -> f64 {
    11.0 * 0.5 * f64::EPSILON * (p.gamma * (1.0 - p.alpha) + 2.0 * p.beta * p.belt_speed)
}

fn claim(test: &Test, point: &Point) -> slipmap::certify::Claim {
    (test.claim)(&Law::Stribeck.column(point))
}

#[test]
fn critical_damping_lies_between_instability_and_harmonic_balance() {
    let points = critical_points();
    assert!(points.len() >= 260);
    for p in &points {
        let [lo, mid, hi] = [&instability::TEST, &harmonic_balance::TEST, &symmetric::TEST]
            .map(|test| claim(test, &p.at(0.0)));
        let error = rounding(p);
        assert!(lo.present_below <= p.critical_c + error, "instability above critical: {p:?}");
        assert!(p.critical_c <= mid.absent_above + error, "harmonic balance below critical: {p:?}");
        assert_eq!(mid.present_below, mid.absent_above, "the balance leaves no gap: {p:?}");
        assert!(mid.absent_above <= hi.absent_above + error, "{p:?}");
    }
    let small = points.iter().filter(|p| p.critical_c < 0.01).count();
    assert!(small >= 15, "the table keeps small critical dampings, found {small}");
}

/// With D(1 - x) = d0 + d1 x + d2 x^2 + ... about the equilibrium, in scaled groups,
/// `eps (c* - c_HB) = -(13/576) d1^2 d2 (1 + O(d2/d1) + O(k^2))`, where d2/d1 <= 3k/2: to leading order in
/// eps `c* - c_HB = -(13/48) eps^4 gamma^3 (1-alpha) V^4 (beta + eps gamma^2 (1-alpha))^2`.
#[test]
fn harmonic_balance_misses_by_its_leading_term() {
    let mut seen = 0;
    for p in critical_points() {
        let k = p.epsilon * p.gamma * p.belt_speed;
        let (a, b) = (p.epsilon * p.gamma * (1.0 - p.alpha), p.epsilon * p.beta * p.belt_speed);
        let d1 = 2.0 * (a * k / (1.0 + k).powi(3) + b);
        let d2 = 3.0 * a * k * k / (1.0 + k).powi(4);
        let leading = -13.0 / 576.0 * d1 * d1 * d2 / p.epsilon;
        if k < 0.3 && leading.abs() > 1e3 * rounding(&p) {
            seen += 1;
            let ratio = (p.critical_c - claim(&harmonic_balance::TEST, &p.at(0.0)).present_below) / leading;
            // The corrections are of order k with coefficients below one; rounding stays below 1e-3.
            assert!((ratio - 1.0).abs() < k + 1e-3, "ratio {ratio}, k {k} at {p:?}");
        }
    }
    assert!(seen >= 50, "only {seen} rows resolve the leading term");
}

/// Theorems compared with fates in extended precision; the table has rows of every fate and of every legal
/// limit.
#[test]
fn theorems_agree_with_the_reference_fates() {
    let points = margin_points();
    for p in &points {
        let sticks = matches!(p.fate, ReferenceFate::Sticks | ReferenceFate::SticksFromAbove);
        for test in [&instability::TEST, &symmetric::TEST] {
            match claim(test, &p.point()).decide(p.damping) {
                Decision::Present => assert!(sticks, "{}: {p:?}", test.name),
                Decision::Absent => assert!(!sticks, "{}: {p:?}", test.name),
                Decision::Undecided => {}
            }
        }
    }
    let count = |wanted: &dyn Fn(&MarginPoint) -> bool| points.iter().filter(|&p| wanted(p)).count();
    for fate in [
        ReferenceFate::Sticks,
        ReferenceFate::SticksFromAbove,
        ReferenceFate::CrossesForever,
        ReferenceFate::Inward,
    ] {
        assert!(count(&|p| p.fate == fate) >= 15, "{fate:?}");
    }
    assert!(count(&|p| p.alpha == 0.0) >= 5);
    assert!(count(&|p| p.alpha == 1.0) >= 5);
    assert!(count(&|p| p.beta == 0.0) >= 5);
    assert!(count(&|p| p.gamma == 0.0) >= 5);
    assert!(count(&|p| p.damping == 0.0) >= 5);
    assert!(count(&|p| p.margin.is_none() && p.fate != ReferenceFate::Inward) >= 5);
}

/// The crate's landing: on the stick segment, with the time from there to the exit point; and from below at
/// `x1 = 1 - eps c V - wL`, with the landing speed wL of the table.
#[test]
fn landings_lie_on_the_stick_segment() {
    // Near grazing the landing is a nearly double root: only the square root of the flow's tolerance is
    // guaranteed.
    let (tolerance, landing_error) = (1e-10, 1e-5);
    let mut landed = 0;
    for p in margin_points() {
        let oscillator = Oscillator::new(&Law::Stribeck, &p.point());
        let Fate::Sticks(Landing { x1, slip_time, stick_time, crossings }) =
            flow(&oscillator, tolerance).fate
        else {
            continue;
        };
        landed += 1;
        let exit = oscillator.exit_x1();
        assert!(exit - 2.0 < x1 && x1 < exit, "{p:?}");
        assert!(slip_time > 0.0 && stick_time > 0.0, "{p:?}");
        // x1 and the times are of size 1 to 20 and the identity takes five roundings.
        let size = 1.0 + x1.abs() + exit.abs();
        assert!((x1 + p.belt_speed * stick_time - exit).abs() <= 8.0 * f64::EPSILON * size, "{p:?}");
        if crossings == Some(0) {
            assert_eq!(p.fate, ReferenceFate::Sticks, "{p:?}");
            let speed = p.landing_speed.unwrap();
            assert!((exit - speed - x1).abs() <= landing_error * (1.0 + speed), "{p:?}: {x1}");
        } else {
            assert_eq!(p.fate, ReferenceFate::SticksFromAbove, "{p:?}");
        }
    }
    assert!(landed >= 100, "only {landed} rows land");
}

//! The reference tables parse, cover what they promise, and obey the theory's closed-form orderings. The
//! formulas are written out here, apart from the crate's, so that this checks the theory and the tables.

use crate::reference::{MarginPoint, ReferenceFate, critical_points, margin_points};

/// A closed form's value, and a bound of its rounding error.
struct Rounded {
    value: f64,
    error: f64,
}

/// `weakening - strengthening`, where neither term took more than ten rounded operations.
fn difference(weakening: f64, strengthening: f64) -> Rounded {
    let error = 11.0 * 0.5 * f64::EPSILON * (weakening + strengthening);
    Rounded { value: weakening - strengthening, error }
}

/// Zero divergence at the equilibrium.
fn instability(epsilon: f64, alpha: f64, beta: f64, gamma: f64, v: f64) -> Rounded {
    difference(gamma * (1.0 - alpha) / (1.0 + epsilon * gamma * v).powi(2), 2.0 * beta * v)
}

/// Energy balance on the grazing circle.
fn harmonic_balance(epsilon: f64, alpha: f64, beta: f64, gamma: f64, v: f64) -> Rounded {
    let k = epsilon * gamma * v;
    let q = (1.0 + 2.0 * k).sqrt();
    difference(2.0 * gamma * (1.0 - alpha) / (q * (1.0 + k + q)), 2.0 * beta * v)
}

/// Largest even part of the divergence.
fn symmetric_absence(epsilon: f64, alpha: f64, beta: f64, gamma: f64, v: f64) -> Rounded {
    let far = 1.0 + 2.0 * epsilon * gamma * v;
    difference(0.5 * gamma * (1.0 - alpha) * (1.0 + 1.0 / (far * far)), 2.0 * beta * v)
}

#[test]
fn critical_damping_lies_between_instability_and_harmonic_balance() {
    let points = critical_points();
    assert!(points.len() >= 260);
    for p in &points {
        let (lo, mid, hi) = (
            instability(p.epsilon, p.alpha, p.beta, p.gamma, p.belt_speed),
            harmonic_balance(p.epsilon, p.alpha, p.beta, p.gamma, p.belt_speed),
            symmetric_absence(p.epsilon, p.alpha, p.beta, p.gamma, p.belt_speed),
        );
        assert!(lo.value - lo.error <= p.critical_c, "instability above critical: {p:?}");
        assert!(p.critical_c <= mid.value + mid.error, "harmonic balance below critical: {p:?}");
        assert!(mid.value - mid.error <= hi.value + hi.error, "{p:?}");
    }
    let small = points.iter().filter(|p| p.critical_c < 0.01).count();
    assert!(small >= 15, "the table keeps small critical dampings, found {small}");
}

/// With D(1 - x) = d0 + d1 x + d2 x^2 + ... about the equilibrium, in scaled groups,
/// `eps (c* - c_HB) = -(13/576) d1^2 d2 (1 + O(d2/d1) + O(k^2))`, where d2/d1 <= 3k/2: to leading order in eps
/// `c* - c_HB = -(13/48) eps^4 gamma^3 (1-alpha) V^4 (beta + eps gamma^2 (1-alpha))^2`.
#[test]
fn harmonic_balance_misses_by_its_leading_term() {
    let mut seen = 0;
    for p in critical_points() {
        let k = p.epsilon * p.gamma * p.belt_speed;
        let (a, b) = (p.epsilon * p.gamma * (1.0 - p.alpha), p.epsilon * p.beta * p.belt_speed);
        let d1 = 2.0 * (a * k / (1.0 + k).powi(3) + b);
        let d2 = 3.0 * a * k * k / (1.0 + k).powi(4);
        let leading = -13.0 / 576.0 * d1 * d1 * d2 / p.epsilon;
        let closed = harmonic_balance(p.epsilon, p.alpha, p.beta, p.gamma, p.belt_speed);
        if k < 0.3 && leading.abs() > 1e3 * closed.error {
            seen += 1;
            let ratio = (p.critical_c - closed.value) / leading;
            // The corrections are of order k with coefficients below one; rounding stays below 1e-3.
            assert!((ratio - 1.0).abs() < k + 1e-3, "ratio {ratio}, k {k} at {p:?}");
        }
    }
    assert!(seen >= 50, "only {seen} rows resolve the leading term");
}

#[test]
fn every_fate_and_limit_is_in_the_table() {
    let points = margin_points();
    let count = |wanted: &dyn Fn(&MarginPoint) -> bool| points.iter().filter(|&p| wanted(p)).count();
    assert_eq!(points.len(), 400);
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

#[test]
fn margins_fates_and_certificates_agree() {
    for p in margin_points() {
        let returns = p.fate != ReferenceFate::Inward;
        if let Some(margin) = p.margin {
            assert_eq!(margin > 0.0, returns, "{p:?}");
        }
        let certified = instability(p.epsilon, p.alpha, p.beta, p.gamma, p.belt_speed);
        let excluded = symmetric_absence(p.epsilon, p.alpha, p.beta, p.gamma, p.belt_speed);
        assert!(returns || p.damping >= certified.value - certified.error, "{p:?}");
        assert!(!returns || p.damping <= excluded.value + excluded.error, "{p:?}");
    }
}

#[test]
fn landings_lie_on_the_stick_segment() {
    // x1 and the times are of size 1 to 20 and the identities take five roundings.
    let close = |a: f64, b: f64| (a - b).abs() <= 8.0 * f64::EPSILON * (1.0 + a.abs() + b.abs());
    for p in margin_points() {
        let sticks = matches!(p.fate, ReferenceFate::Sticks | ReferenceFate::SticksFromAbove);
        assert_eq!(p.landing_speed.is_some(), p.fate != ReferenceFate::Inward, "{p:?}");
        assert_eq!(sticks, p.landing_x1.is_some() && p.stick_time.is_some() && p.slip_time.is_some());
        let exit = 1.0 - p.epsilon * p.damping * p.belt_speed;
        if let (Some(x1), Some(stick), Some(slip)) = (p.landing_x1, p.stick_time, p.slip_time) {
            assert!(exit - 2.0 < x1 && x1 < exit, "{p:?}");
            assert!(close(x1 + p.belt_speed * stick, exit), "{p:?}");
            assert!(slip > 0.0 && stick > 0.0, "{p:?}");
            if p.fate == ReferenceFate::Sticks {
                let speed = p.landing_speed.unwrap();
                assert!(0.0 < speed && speed < 2.0 && close(exit - speed, x1), "{p:?}");
            }
        }
        if p.fate == ReferenceFate::SticksFromAbove || p.fate == ReferenceFate::CrossesForever {
            assert!(p.landing_speed.unwrap() >= 2.0, "{p:?}");
        }
    }
}

//! The backbone C(r), the damping at which the orbit of each amplitude closes, and the cycles read from it.

use crate::sample::slip_cycles;
use slipmap::column::backbone::Backbone;
use slipmap::column::critical_damping;
use slipmap::filippov::Oscillator;
use slipmap::friction::{Column, Expression, Law, Table};
use slipmap::orbits::Cycle;
use slipmap::orbits::arc::{SlipTurn, turn};

fn column(law: &Law, epsilon: f64, parameters: &[f64], belt_speed: f64) -> Column {
    law.column(&law.point(epsilon, parameters, belt_speed, 0.0).unwrap())
}

fn formula(text: &str, parameters: &[f64], belt_speed: f64) -> Column {
    column(&Law::Expression(Expression::new(text, 1.0).unwrap()), 1.0, parameters, belt_speed)
}

/// Columns of every kind of law; the last two have folds.
fn columns() -> Vec<Column> {
    let data: Vec<(f64, f64)> = (0..60)
        .map(|i| 0.05 * f64::from(i))
        .map(|u| (u, 0.7 + 0.3 / (1.0 + 4.0 * u * u) + 0.05 * u))
        .collect();
    vec![
        column(&Law::Stribeck, 0.4, &[0.2, 0.1, 2.0], 1.0),
        column(&Law::Stribeck, 0.9, &[0.1, 0.0, 3.0], 0.5),
        column(&Law::Exponential, 1.0, &[0.5, 0.5, 0.05], 0.8),
        column(&Law::Lorentzian, 1.0, &[0.4, 0.6, 0.1], 0.4),
        column(&Law::Table(Table::new("test", &data, 1.0).unwrap()), 1.0, &[], 0.7),
        formula("1 - s*(u - a*sin(k*u)/k)", &[0.01, 1.5, 7.2], 1.0),
        formula("1-a*u*exp(-u/s)+h*sin(w*u)+d*u", &[1.4, 1.5, 0.2, 7.4, -0.06], 1.67),
    ]
}

fn oscillator(column: &Column, viscous: f64) -> Oscillator {
    Oscillator { curve: column.curve.clone(), viscous, belt_speed: column.belt_speed }
}

/// ln of the ratio of the amplitudes after and before a turn, by the flow in (x2, x2').
fn growth(column: &Column, viscous: f64, radius: f64) -> f64 {
    let oscillator = oscillator(column, viscous);
    // Where steps cannot be that fine, a hundred times coarser ones are accepted.
    let found = turn(&oscillator, radius, 1e-12).or_else(|_| turn(&oscillator, radius, 1e-10));
    match found.unwrap() {
        SlipTurn::Returns { radius: next, .. } => (next / radius).ln(),
        SlipTurn::MeetsBelt { .. } => f64::INFINITY,
        SlipTurn::Rests => f64::NEG_INFINITY,
    }
}

#[test]
fn orbits_close_at_the_damping_of_their_amplitude() {
    for column in columns() {
        let backbone = Backbone::of(&column, 1e-10).unwrap();
        let size = column.curve.weakening(0.0).abs().max(column.curve.weakening(column.belt_speed).abs());
        let smooth = column.curve.corners().is_empty();
        assert!(backbone.error < if smooth { 1e-9 } else { 1e-6 } * size, "{column:?} {}", backbone.error);
        for i in 1..=20 {
            let radius = column.belt_speed * f64::from(i) / 20.5;
            let viscous = backbone.viscous(radius);
            // A turn loses about pi C.
            let error = 2.0 * backbone.error + 1e-11;
            assert!(growth(&column, viscous - error, radius) > 0.0, "{column:?} {radius} {backbone:?}");
            assert!(growth(&column, viscous + error, radius) < 0.0, "{column:?} {radius} {backbone:?}");
        }
    }
}

#[test]
fn the_backbone_ends_at_hopf_and_grazing() {
    for column in columns() {
        let backbone = Backbone::of(&column, 1e-10).unwrap();
        let points = backbone.turning_points();
        let [first, last] = [points[0], points[points.len() - 1]];
        assert_eq!((first.radius, first.viscous), (0.0, column.curve.weakening(column.belt_speed)));
        let critical = critical_damping(&column, 1e-12).unwrap();
        assert_eq!(last.radius, column.belt_speed);
        let off = (last.viscous - column.epsilon * critical.c).abs();
        assert!(off <= backbone.error + column.epsilon * critical.error, "{column:?} {off:e}");
    }
}

#[test]
fn the_even_part_encloses_the_backbone() {
    for column in columns() {
        let backbone = Backbone::of(&column, 1e-10).unwrap();
        // Over |v| <= r, by samples; between two samples E is assumed to change by at most their difference.
        let speed = column.belt_speed;
        let even = |v: f64| 0.5 * (column.curve.weakening(speed - v) + column.curve.weakening(speed + v));
        let (mut lo, mut hi, mut step): (f64, f64, f64) = (even(0.0), even(0.0), 0.0);
        for i in 1..=4000 {
            let v = speed * f64::from(i) / 4000.0;
            let here = even(v);
            step = step.max((here - even(speed * f64::from(i - 1) / 4000.0)).abs());
            (lo, hi) = (lo.min(here), hi.max(here));
            if i % 100 == 0 {
                let (viscous, error) = (backbone.viscous(v), backbone.error + step);
                assert!(lo - error <= viscous && viscous <= hi + error, "{column:?} {v}");
            }
        }
    }
}

#[test]
fn cycles_read_off_the_backbone_are_those_that_turns_show() {
    let mut counts = std::collections::BTreeMap::new();
    for column in columns() {
        let backbone = Backbone::of(&column, 1e-10).unwrap();
        let values: Vec<f64> =
            (0..=200).map(|i| backbone.viscous(column.belt_speed * f64::from(i) / 200.0)).collect();
        let (lo, hi) = values
            .iter()
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), &value| (lo.min(value), hi.max(value)));
        for i in 0..=8 {
            let viscous = lo + (hi - lo) * (f64::from(i) / 8.0 * 1.2 - 0.07);
            let radius = |i: i32| column.belt_speed * f64::from(i) / 66.0;
            let signs: Vec<bool> = (1..66).map(|i| growth(&column, viscous, radius(i)) > 0.0).collect();
            let stable = oscillator(&column, viscous).eigenvalues().is_stable();
            let cycles = backbone.cycles(viscous, stable, *signs.last().unwrap()).unwrap();
            let changes: Vec<bool> = std::iter::once(&!stable)
                .chain(&signs)
                .zip(&signs)
                .filter(|(before, after)| before != after)
                .map(|(before, _)| *before)
                .collect();
            let stables: Vec<bool> = cycles.iter().map(|cycle| cycle.is_stable).collect();
            assert_eq!(stables, changes, "{column:?} {viscous} {backbone:?}");
            *counts.entry(cycles.len()).or_insert(0) += 1;
        }
    }
    assert!(counts.contains_key(&3) && counts.contains_key(&2) && counts.contains_key(&1), "{counts:?}");
}

/// For a constant divergence every orbit closes at the same damping.
#[test]
fn a_linear_law_has_a_flat_backbone() {
    let column = formula("1 - a*u", &[0.3], 1.0);
    let backbone = Backbone::of(&column, 1e-10).unwrap();
    assert!(backbone.folds().is_empty());
    assert!((backbone.viscous(0.5) - 0.3).abs() < 1e-14);
}

/// A measured law with a jump over a short range of slip speeds: its corners change C(r) abruptly, and a
/// single polynomial through C missed both cycles. The expected amplitudes and multipliers come from an
/// event-exact integrator in SciPy, at two tolerances.
#[test]
fn slip_cycles_of_rough_measured_friction_are_found() {
    // In m/s and units of the normal force, for a mass whose unit of velocity is 0.0931441 m/s.
    let speeds = [0.0000000, 0.0243980, 0.0396312, 0.0628787, 0.0631642, 0.0723846, 0.0905262, 0.1129858];
    let forces = [0.5872603, 0.4313061, 0.3857187, 0.3747530, 0.3348087, 0.3731622, 0.3063811, 0.3099550];
    let rows = speeds.into_iter().zip(forces);
    let data: Vec<(f64, f64)> = rows.map(|(v, force)| (v / 0.0931441, force / 0.5872603)).collect();
    let law = Law::Table(Table::new("measured", &data, 1.0).unwrap());
    let column = column(&law, 1.0, &[], 0.037544347 / 0.0931441);
    let found = slip_cycles(&oscillator(&column, 0.266_281_5), 1e-11).unwrap();
    let shape = |cycle: &Cycle| [cycle.velocity.hi / column.belt_speed, cycle.multiplier];
    let shapes: Vec<[f64; 2]> = found.iter().map(shape).collect();
    let expected = [[0.0567, 0.9837], [0.1028, 1.0230]];
    assert_eq!(shapes.len(), expected.len(), "{shapes:?}");
    for (shape, expected) in shapes.iter().zip(expected) {
        assert!(shape.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-3), "{shapes:?}");
    }
}

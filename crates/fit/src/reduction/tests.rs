use super::*;

/// As `noise` of scripts/evidence/reduction.py.
fn noise(count: usize, remembers: &[f64]) -> Vec<f64> {
    let (mut state, mut drawn) = (1_u64, Vec::<f64>::new());
    for _ in 0..count {
        let mut total = 0.0;
        for _ in 0..12 {
            state = (1_103_515_245 * state + 12345) % (1 << 31);
            total += state as f64 / (1_u64 << 31) as f64;
        }
        let known: f64 = remembers.iter().zip(drawn.iter().rev()).map(|(phi, e)| phi * e).sum();
        drawn.push(total - 6.0 + known);
    }
    drawn
}

type Case = (Vec<f64>, Vec<f64>, Option<Vec<usize>>);

fn case(name: &str) -> Case {
    let law = |u: f64| 15.0 + 12.0 * (-u / 0.03).exp() + 40.0 * u;
    let noisy = |speeds: Vec<f64>, scale: f64, remembers: &[f64], visits| {
        let noise = noise(speeds.len(), remembers);
        let friction = speeds.iter().zip(noise).map(|(u, e)| law(*u) + scale * e).collect();
        (speeds, friction, visits)
    };
    let numbers = |count: u32| (0..count).map(f64::from);
    match name {
        "table" => noisy(numbers(40).map(|i| 0.4 * ((i + 1.0) / 40.0).powi(2)).collect(), 0.1, &[], None),
        "staircase" => {
            let visits: Vec<usize> = (0..108).map(|i| i / 12).collect();
            let speeds = visits.iter().map(|visit| 0.005 * 64_f64.powf(*visit as f64 / 8.0)).collect();
            noisy(speeds, 0.05, &[0.6], Some(visits))
        }
        "memory" => {
            let visits: Vec<usize> = (0..320).map(|i| i / 8).collect();
            let speeds = visits.iter().map(|visit| 0.005 * 64_f64.powf(*visit as f64 / 39.0)).collect();
            noisy(speeds, 0.05, &[0.9], Some(visits))
        }
        "ramps" => {
            let speeds = numbers(400).map(|i| 0.001 + 0.4 * (i / 200.0).min(2.0 - i / 200.0)).collect();
            noisy(speeds, 0.05, &[0.5, 0.35], Some((0..400).map(|i| usize::from(i > 200)).collect()))
        }
        _ => {
            let speeds: Vec<f64> = numbers(25).map(|i| 0.4 * (i + 1.0) / 25.0).collect();
            let friction = speeds.iter().map(|u| 5.0 + 3.0 / (1.0 + (u / 0.05).powi(2))).collect();
            (speeds, friction, None)
        }
    }
}

fn rows((speeds, friction, visits): &Case) -> Rows<'_> {
    let last = speeds.iter().copied().fold(0.0, f64::max);
    Rows { speeds, friction, errors: None, visits: visits.as_deref(), aside: None, last, told_at: &[] }
}

fn of(case: &Case) -> Reduced {
    reduce(rows(case))
}

/// Numbers of another program: those of scripts/evidence/reduction.py, which has another interpolant for the residuals.
#[test]
fn curves_are_those_of_another_program() {
    for line in include_str!("expected.txt").lines() {
        let [name, knot, numbers @ ..] = &line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
        let [speed, mean, error, with_12, scatter] =
            numbers.iter().map(|text| text.parse::<f64>().unwrap()).collect::<Vec<_>>()[..]
        else {
            panic!("{line}")
        };
        let knot: usize = knot.parse().unwrap();
        let found = of(&case(name));
        let found_error = found.covariance[(knot, knot)].sqrt();
        assert!((found.speeds[knot] - speed).abs() <= 1e-8 * speed, "{line}");
        assert!((found.friction[knot] - mean).abs() < 1e-3 * error, "{line}: {}", found.friction[knot]);
        assert!((found_error / error - 1.0).abs() < 2e-3, "{line}: {found_error}");
        let off = found.covariance[(knot, 12)] - with_12;
        assert!(off.abs() < 2e-3 * error * found.covariance[(12, 12)].sqrt(), "{line}: {off}");
        assert!((found.scatter / scatter - 1.0).abs() < 2e-3, "{line}: {}", found.scatter);
    }
}

/// The rows of a table are a set.
#[test]
fn the_order_of_rows_says_nothing() {
    let rows = case("table");
    let order = |values: &[f64]| (0..40).map(|i| values[(7 * i + 3) % 40]).collect::<Vec<_>>();
    let [one, other] = [of(&rows), of(&(order(&rows.0), order(&rows.1), None))];
    let off = (one.friction - other.friction).amax();
    assert!(off < 1e-6 * one.covariance.diagonal().min().sqrt(), "{off}");
}

/// Equal errors change nothing if readings scatter more than these, and are the scatter if they do less.
#[test]
fn readings_scatter_at_least_as_their_errors_say() {
    let case = case("table");
    let with = |error: f64| reduce(Rows { errors: Some(&[error; 40]), ..rows(&case) });
    let without = of(&case);
    let [small, large] = [1e-3, 1.0].map(with);
    let sd = |of: &Reduced| of.covariance[(12, 12)].sqrt();
    assert!((sd(&small) / sd(&without) - 1.0).abs() < 1e-6, "{} {}", sd(&small), sd(&without));
    assert!((large.scatter - 1.0).abs() < 1e-12 && sd(&large) > 3.0 * sd(&without), "{}", large.scatter);
}

/// The half of the difference of two directions is put aside: the curve is that of their mean.
#[test]
fn a_difference_of_directions_is_no_slope() {
    let (speeds, friction, _) = case("sharp");
    let sign = |i: usize| if i.is_multiple_of(2) { 1.0 } else { -1.0 };
    let moved: Vec<f64> = friction.iter().enumerate().map(|(i, f)| f * (1.0 + 0.1 * sign(i))).collect();
    let aside: Vec<f64> = friction.iter().enumerate().map(|(i, f)| f * sign(i)).collect();
    let one = (speeds, friction, None);
    let [mean, ignored] =
        [Some(&aside[..]), None].map(|aside| reduce(Rows { friction: &moved, aside, ..rows(&one) }));
    let of = |found: &Reduced| found.covariance[(12, 12)].sqrt();
    assert!(
        (mean.friction[12] - 6.080).abs() < 2.0 * of(&mean) && (mean.aside - 0.1).abs() < 1e-4,
        "{mean:?}"
    );
    assert!(of(&ignored) > 20.0 * of(&mean));
}

/// A phase of rest ends half a sample after the last one; a value of the curve that is known changes the others.
#[test]
fn friction_at_rest_is_that_at_breakaway() {
    let parabola: Vec<f64> = (0..9).map(|i| 3.0 + 2.0 * f64::from(i) - 0.1 * f64::from(i * i)).collect();
    assert!((breakaway(&parabola) - (3.0 + 17.0 - 7.225)).abs() < 1e-12);
    assert!((breakaway(&[1.0, 2.0, 3.0]) - 3.5).abs() < 1e-15 && breakaway(&[4.0]) == 4.0);
    let mut curve = of(&case("table"));
    let before = curve.covariance[(1, 1)];
    curve.begin_at(27.0, 0.0);
    assert!((curve.friction[0] - 27.0).abs() < 1e-12 && curve.covariance[(1, 1)] < before);
    let root = curve.root(2).unwrap();
    let again = &root * root.transpose() - curve.covariance.view((2, 2), (22, 22));
    assert!(again.amax() < 1e-12);
}

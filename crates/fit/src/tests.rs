//! Fits of readings of known laws.

use super::*;
use slipmap_numbers::random::Random;

fn form(shape: Shape, drop: bool) -> Form {
    Form { shape, viscous: true, drop }
}

/// True values of the parameters, in the order of the names.
fn truth(shape: Shape) -> Vec<f64> {
    match shape {
        Shape::Stretched => vec![1200.0, 700.0, 0.05, 1.5, 20.0],
        _ => vec![1200.0, 700.0, 0.05, 20.0],
    }
}

fn readings(form: Form, count: i32, noise: f64, error: f64, random: &mut Random) -> Vec<Reading> {
    let values = truth(form.shape);
    (1..=count)
        .map(|i| {
            let speed = 3.0 * (f64::from(i) / f64::from(count)).powi(3);
            Reading { speed, friction: form.friction(&values, speed) + noise * random.normal(), error }
        })
        .collect()
}

/// Readings without noise have the parameters of their law, and no other law is as good.
#[test]
fn exact_readings_are_those_of_their_law() {
    for shape in [Shape::Exponential, Shape::Gaussian, Shape::Stretched, Shape::Lorentzian, Shape::Hyperbolic]
    {
        let form = form(shape, false);
        let data = readings(form, 40, 0.0, 1.0, &mut Random(1));
        let found = fits(&data, &[], None).unwrap();
        let best = found.iter().find(|fit| fit.form == form).unwrap();
        for (value, expected) in best.values.iter().zip(truth(shape)) {
            assert!((value / expected - 1.0).abs() < 1e-6, "{shape:?}: {:?}", best.values);
        }
        assert!(found[0].form.shape == shape || found[0].form.shape == Shape::Stretched, "{:?}", found[0]);
    }
}

/// The derivatives by the parameters are those of differences.
#[test]
fn gradients_are_differences() {
    for form in Form::all() {
        let values: Vec<f64> = match form.names().len() {
            1 => vec![700.0],
            2 => vec![700.0, 20.0],
            _ => truth(form.shape)[..form.names().len()].to_vec(),
        };
        for speed in [0.0, 0.01, 0.07, 1.0] {
            let gradient = form.gradient(&values, speed);
            for (i, found) in gradient.iter().enumerate() {
                let step = 1e-6 * values[i];
                let at = |by: f64| {
                    let mut moved = values.clone();
                    moved[i] += by;
                    form.friction(&moved, speed)
                };
                let expected = (at(step) - at(-step)) / (2.0 * step);
                // Rounding of the friction divided by the step.
                assert!(
                    (found - expected).abs() <= 1e-6 * expected.abs() + 1e-9 * 1200.0 / step,
                    "{form:?} {i}"
                );
            }
        }
    }
}

/// The stated errors are those of repeated measurements: the mean square of the deviations in units of the errors is
/// 1 within four standard deviations of such a mean.
#[test]
fn errors_are_those_of_repeated_measurements() {
    let form = form(Shape::Exponential, false);
    let mut random = Random(7);
    for (noise, error) in [(10.0, 10.0), (10.0, f64::NAN)] {
        const REPEATED: i32 = 400;
        let mut squares = [0.0; 4];
        for _ in 0..REPEATED {
            let data = readings(form, 40, noise, error, &mut random);
            let fit = fit(form, &data, &[], None).unwrap();
            let deviations = fit.values.iter().zip(truth(form.shape)).zip(fit.errors());
            for (sum, ((value, expected), error)) in squares.iter_mut().zip(deviations) {
                *sum += ((value - expected) / error).powi(2) / f64::from(REPEATED);
            }
        }
        // The variance is at least 1 in units of the errors, and Student's distribution widens it.
        let wide = if error > 0.0 { 1.1 } else { widening(36.0) };
        let sampling = 4.0 * (2.0 / f64::from(REPEATED)).sqrt();
        for square in squares {
            assert!((square * wide - 1.0).abs() < sampling + 0.05, "{squares:?} {wide}");
        }
    }
}

/// Of readings of the law the lack of fit is a normal deviate, also of those on a curve with correlated errors; a law of two
/// scales, that none has, is found out.
#[test]
fn a_law_that_does_not_follow_is_found_out() {
    let form = form(Shape::Exponential, false);
    let mut random = Random(3);
    let root = DMatrix::from_fn(60, 60, |i, j| if i >= j { 5.0 * 0.6_f64.powi((i - j) as i32) } else { 0.0 });
    for (error, root) in [(f64::NAN, None), (5.0, None), (5.0, Some(&root))] {
        const REPEATED: usize = 300;
        let (mut above, mut found) = (0, 0);
        for _ in 0..REPEATED {
            let mut data = readings(form, 60, 0.0, error, &mut random);
            let noise = DVector::from_fn(60, |_, _| random.normal());
            let noise = root.map_or_else(|| &noise * 5.0, |root| root * &noise);
            data.iter_mut().zip(&noise).for_each(|(reading, noise)| reading.friction += noise);
            above += usize::from(fit(form, &data, &[], root).unwrap().lack > 2.0);
            data.iter_mut().for_each(|it| it.friction += 80.0 * (-it.speed / 0.6).exp());
            found += usize::from(fit(form, &data, &[], root).is_none_or(|fit| fit.lack > 3.0));
        }
        // Of 300 some 7 are above two deviations: at most 17 within four of the binomial law.
        assert!(above <= 17 && 2 * found > REPEATED, "{error} {above} {found}");
    }
}

/// What other laws say of the slope is in the errors: what damps an orbit at 0.05 and 0.2 is within two of them where the law is
/// not known, and those of the law alone are hardly less.
#[test]
fn errors_know_of_other_laws() {
    let form = form(Shape::Exponential, false);
    let mut random = Random(9);
    let damping = |of: &dyn Fn(f64) -> f64, v: f64| {
        let angle = |i: i32| (f64::from(i) + 0.5) / 200.0 * std::f64::consts::PI;
        (0..200).map(angle).map(|t| of(v * (1.0 - t.cos())) * t.cos()).sum::<f64>() / (100.0 * v)
    };
    let (mut outside, mut wider) = (0, 0.0);
    for _ in 0..60 {
        let data = readings(form, 40, 20.0, f64::NAN, &mut random);
        let all = fits(&data, &[], None).unwrap();
        let best = &all[0];
        for v in [0.05, 0.2] {
            let by = |i: usize| damping(&|u| best.form.gradient(&best.values, u)[i], v);
            let by = DVector::from_fn(best.values.len(), |i, _| by(i));
            let off = damping(&|u| best.friction(u) - form.friction(&truth(form.shape), u), v);
            outside += i32::from(off.abs() > 1.96 * by.dot(&(&best.covariance * &by)).sqrt());
        }
        let alone = fit(best.form, &data, &[], None).unwrap();
        wider += best.errors()[1] / alone.errors()[1] / 60.0;
    }
    // Of 120 intervals of 95 % 6 miss: at most 13 within three deviations of the binomial law.
    assert!(outside <= 13 && (1.0..1.5).contains(&wider), "{outside} {wider}");
}

/// With a drop the readings at rest are a friction of their own.
#[test]
fn a_drop_is_found() {
    let form = form(Shape::Exponential, true);
    let mut random = Random(5);
    let data = readings(form, 60, 5.0, f64::NAN, &mut random);
    let rest: Vec<Reading> = (0..6)
        .map(|_| Reading { speed: 0.0, friction: 1500.0 + 20.0 * random.normal(), error: f64::NAN })
        .collect();
    let best = &fits(&data, &rest, None).unwrap()[0];
    let [level, error] = best.at_rest.unwrap();
    assert!((level - 1500.0).abs() < 4.0 * error && error < 20.0, "{level} {error}");
    assert!((best.values[0] - 1200.0).abs() < 4.0 * best.errors()[0], "{best:?}");
}

/// The quantiles of Student's distribution, from tables.
#[test]
fn two_standard_errors_are_those_of_student() {
    for (freedom, quantile) in [(3.0, 3.182_446), (10.0, 2.228_139), (30.0, 2.042_272)] {
        let found = widening(freedom).sqrt() * 1.959_964;
        assert!((found / quantile - 1.0).abs() < 0.01, "{freedom}: {found}");
    }
}

/// Readings that say little of where friction falls still give covariances: positive, or no fit.
#[test]
fn covariances_are_positive_definite() {
    let mut random = Random(11);
    for form in Form::all().filter(|form| form.shape != Shape::None) {
        for from in [0.0, 0.1, 0.3, 0.5, 0.8] {
            let values = &truth(form.shape)[..form.names().len()];
            let reading = |i: i32| {
                let speed = from + 0.02 * f64::from(i);
                let friction = form.friction(values, speed) + 5.0 * random.normal();
                Reading { speed, friction, error: f64::NAN }
            };
            let data: Vec<Reading> = (0..40).map(reading).collect();
            for fit in fits(&data, &[], None).unwrap_or_default() {
                let covariance = &fit.covariance;
                assert_eq!(*covariance, covariance.transpose(), "{:?}", fit.form);
                assert!(covariance.clone().cholesky().is_some(), "{:?} {covariance}", fit.form);
            }
        }
    }
}

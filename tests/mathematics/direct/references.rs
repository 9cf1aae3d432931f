//! Comparison with identities of the theory, and with integrations in other variables by other methods.

use super::oracle;
use super::oracle::Outcome;
use super::{anywhere, oscillator, overshooting};
use crate::sample::{Random, Sampling, formula};
use slipmap::filippov::Oscillator;
use slipmap::flow::Fate;
use slipmap::friction::Law;
use slipmap::witness::flow;

#[test]
fn margins_and_their_error_estimates_agree_with_the_polar_form() {
    let mut random = Random(21);
    let mut points = 0;
    let mut errors = Vec::new();
    let (mut too_small, mut estimates) = (0, 0);
    while points < 1200 {
        let point = anywhere(&mut random);
        let oscillator = oscillator(point);
        let Some(exact) = oracle::polar_margin(&oscillator) else { continue };
        points += 1;
        for tolerance in [1e-6, 1e-9, 1e-11, 1e-13] {
            let answer = flow(&oscillator, tolerance);
            let context = format!("{point:?}, tolerance {tolerance}: {answer:?}, exact {exact:?}");
            match answer.fate {
                Fate::SpiralsInward => assert!(exact.value < exact.error, "{context}"),
                Fate::Sticks(_) | Fate::CrossesForever => assert!(exact.value > -exact.error, "{context}"),
                Fate::TooCloseToCall => assert!(exact.value.abs() < 2.0 * answer.margin_error, "{context}"),
                Fate::Failed(_) => panic!("{context}"),
            }
            if answer.margin.is_nan() {
                // The continuation ends at V/8, or nearer to the belt line if the law has a pole near it.
                assert!(exact.value > 0.0, "{context}");
                continue;
            }
            let error = (answer.margin - exact.value).abs();
            estimates += 1;
            too_small += u32::from(error > answer.margin_error + exact.error);
            if tolerance == 1e-13 && exact.error < 3e-15 {
                errors.push(error);
            }
            // Even an estimate that is too small is not far off.
            assert!(error <= 10.0 * answer.margin_error + exact.error, "error {error:e}, {context}");
        }
    }
    errors.sort_by(f64::total_cmp);
    let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
    println!("{too_small} of {estimates} estimates too small; at 1e-13: median {median:e}, worst {worst:e}");
    assert!(f64::from(too_small) < 1e-3 * f64::from(estimates), "{too_small} of {estimates}");
    // Rounding errors of x2' of 1e-16 each, averaged over the turn, over V >= 0.1; 1e-13 itself at worst.
    assert!(median < 2e-15 && worst < 1e-13, "median {median:e}, worst {worst:e}");
}

/// Friction that is even in the slip speed falls within a thin layer next to a fast belt. Steps once went
/// past the layer, with an error of 190 times the stated one.
#[test]
fn thin_even_layers_are_resolved() {
    let mut random = Random(0x1a7e);
    for _ in 0..300 {
        let belt_speed = random.log(0.1, 1e5);
        let vs = belt_speed * random.log(1e-8, 1.0);
        let point = Law::Lorentzian.point(1.0, &[random.unit(), vs, 0.0], belt_speed, 0.0).unwrap();
        let oscillator = Oscillator::new(&Law::Lorentzian, &point);
        let by_turn = slipmap::orbits::flow(&oscillator, 1e-12);
        let answer = flow(&oscillator, 1e-9);
        let error = (answer.margin - by_turn.margin).abs();
        // An orbit that runs far past the line has no margin.
        assert!(!(error > answer.margin_error + by_turn.margin_error), "{point:?}: {answer:?}, {by_turn:?}");
    }
}

/// Long steps once went past narrow steps and dips of formulas without a sample in them, in both engines.
#[test]
fn narrow_features_of_formulas_are_not_passed() {
    let step = "1-a*u/(u+b)+d*(tanh((u-p)/w)+tanh(p/w))";
    let dip = "1-a*u/(u+b)+d*(exp(-((u-p)/w)^2)-exp(-(p/w)^2))";
    let mut random = Random(55);
    let law = [0.30135194653846287, 0.13165127963643292, -0.05091184669065055, 4.562735948812542];
    let deep = [0.7987842186731005, 0.08242952218788625, -0.12453712627731364, 3.685191679745314];
    let flat = [0.6190806032095593, 0.43263437880203015, -0.02303530867497021, 2.254321289209317];
    // At seven times the speed of a slow belt.
    let slow = [0.7309736177362021, 0.09008563837128651, -0.04817470764372872, 0.40766317891330117];
    // The formula, its a, b, d, e and w, belt speed and damping; all of these were passed.
    let mut cases = vec![
        (step, law, 0.0085, 3.92, 0.026),
        (step, law, 0.002, 3.92, 0.028),
        (dip, deep, 0.0091, 4.252, 0.030553),
        (dip, flat, 0.01286, 4.4256, 0.03892),
        (dip, slow, 0.00013786238325675865, 0.05913246269465955, 0.13228981699320888),
    ];
    for n in 0..6 {
        let mut between = |lo: f64, hi: f64| random.between(lo, hi);
        let belt_speed = between(1.0, 5.0);
        let place = between(0.3, 1.9) * belt_speed;
        let law = [between(0.1, 0.8), between(0.05, 1.0), between(-0.15, 0.15), place];
        let width = belt_speed * 2e-3 * 10_f64.powf(between(0.0, 1.0));
        cases.push((if n % 2 == 0 { step } else { dip }, law, width, belt_speed, between(0.0, 0.1)));
    }
    let mut sticking = 0;
    for (text, [a, b, d, e], w, belt_speed, damping) in cases {
        let law = formula(text);
        let point = law.point(1.0, &[a, b, d, e, w], belt_speed, damping).unwrap();
        let oscillator = Oscillator::new(&law, &point);
        // The reference has the derivative by hand, which is quick, too.
        let divergence = |u: f64| {
            let t = (u - e) / w;
            let feature = if text == step { t.cosh().powi(-2) } else { -2.0 * t * (-t * t).exp() };
            a * b / ((u + b) * (u + b)) - d / w * feature - damping
        };
        let (outcome, value, _) = oracle::lienard(&divergence, belt_speed, 0.1 * w / belt_speed).unwrap();
        for answer in [flow(&oscillator, 1e-10), slipmap::orbits::flow(&oscillator, 1e-10)] {
            let context = format!("{point:?}: {answer:?}, reference {outcome:?} {value:?}");
            match (answer.fate, outcome) {
                (Fate::SpiralsInward, Outcome::Short) => {
                    let error = (answer.margin - value.value).abs();
                    assert!(error <= answer.margin_error + value.error + 1e-9, "{context}");
                }
                (Fate::Sticks(landing), Outcome::Sticks) => {
                    sticking += 1;
                    let error = (oscillator.exit_x1() - landing.x1 - value.value).abs();
                    assert!(error <= value.error + 1e-7, "{context}");
                }
                (Fate::SpiralsInward, Outcome::Rests) | (Fate::CrossesForever, Outcome::Crosses) => {}
                _ => panic!("{context}"),
            }
        }
    }
    assert!(sticking >= 6, "{sticking}");
}

#[test]
fn outcomes_and_landings_agree_with_the_lienard_form() {
    let mut random = Random(22);
    let mut seen = [0; 5];
    for n in 0..600 {
        let point = if n % 2 == 0 { anywhere(&mut random) } else { overshooting(&mut random) };
        let oscillator = oscillator(point);
        let answer = flow(&oscillator, 1e-12);
        let Some((outcome, value, time)) = oracle::lienard(&|u| oscillator.divergence(u), point[4], 0.01)
        else {
            continue;
        };
        let context = format!("{point:?}: {answer:?}, reference {outcome:?} {value:?} {time:?}");
        let belt_speed = oscillator.belt_speed;
        match (answer.fate, outcome) {
            (Fate::TooCloseToCall, _) => continue,
            (Fate::SpiralsInward, Outcome::Short) => {
                seen[0] += 1;
                let error = (answer.margin - value.value).abs();
                assert!(error <= answer.margin_error + value.error, "{context}");
            }
            (Fate::SpiralsInward, Outcome::Rests) => {
                seen[1] += 1;
                assert!(answer.margin < -0.9, "{context}");
            }
            (Fate::Sticks(landing), Outcome::Sticks | Outcome::SticksFromAbove) => {
                let from_above = outcome == Outcome::SticksFromAbove;
                seen[2 + usize::from(from_above)] += 1;
                assert_eq!(landing.crossings, Some(u32::from(from_above)), "{context}");
                let lift = if from_above { 2.0 } else { 0.0 };
                let speed = oscillator.exit_x1() - landing.x1;
                let slowest = value.value.abs().min(speed);
                let error = answer.margin_error * belt_speed * (1.0 + belt_speed / slowest);
                assert!((speed - value.value - lift).abs() <= error + value.error, "{context}");
                let late = (landing.slip_time - time.value).abs();
                assert!(late <= error * (1.0 + 1.0 / slowest) + time.error, "{context}");
                assert!((landing.stick_time * belt_speed - speed).abs() <= 1e-12 * belt_speed.max(1.0));
            }
            (Fate::CrossesForever, Outcome::Crosses) => seen[4] += 1,
            _ => panic!("{context}"),
        }
    }
    println!("short, at rest, sticks, sticks from above, crosses: {seen:?}");
    assert!(seen.iter().all(|&n| n >= 10), "{seen:?}");
}

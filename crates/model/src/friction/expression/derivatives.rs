//! Compares every derivative of random formulas with the differences of the one below it.
//!
//! All are enclosed by intervals with outward rounding, so no tolerance is needed: by the mean value theorem the quotient
//! of differences over a short range is the derivative somewhere in it.

use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;

/// The length of the range, of slip speed and of eps.
const STEP: f64 = 1.0 / 65536.0;

fn formula() -> impl Strategy<Value = String> {
    let number = (1..40_u32).prop_map(|x| format!("{}", f64::from(x) / 8.0));
    let leaf = prop_oneof![3 => Just("u".to_owned()), 2 => Just("eps".to_owned()), 1 => Just("a".to_owned()), 2 => number];
    let functions = ["exp", "ln", "sqrt", "sin", "cos", "tan", "sinh", "cosh", "tanh", "atan"];
    leaf.prop_recursive(4, 10, 2, move |part| {
        let join = (part.clone(), prop::sample::select(vec!['+', '-', '*', '/']), part.clone());
        let call = (prop::sample::select(functions.to_vec()), part.clone());
        prop_oneof![
            4 => join.prop_map(|(a, sign, b)| format!("({a}{sign}{b})")),
            3 => call.prop_map(|(function, of)| format!("{function}({of})")),
            1 => part.clone().prop_map(|of| format!("(-({of}))")),
            1 => (part.clone(), -3..5).prop_map(|(base, exponent)| format!("(({base})^({exponent}))")),
            1 => (part.clone(), part).prop_map(|(base, exponent)| format!("(({base})^({exponent}))")),
        ]
    })
}

proptest! {
    #![proptest_config(ProptestConfig {
        cases: 400, max_global_rejects: 4000, rng_seed: RngSeed::Fixed(1), failure_persistence: None,
        ..ProptestConfig::default()
    })]

    #[test]
    fn derivatives_are_limits_of_differences(text in formula(), u in 0.1..2.0, epsilon in 0.1..1.0, a in 0.5..3.0) {
        let law = Expression::new(&text, 1.0).unwrap();
        let curve = law.curve(epsilon, &LawParameters::new(&[a][..law.parameters().len()]));
        // The derivatives by u of the orders 0 to 3, of each that by eps of the orders 0 and 1.
        let over = |u, epsilon| {
            let slip = Jet::<Jet<Interval, 2>, 4>::variable(Jet::of(u), 1.0);
            let series = curve.run(slip, Jet::of(Jet::variable(epsilon, 1.0)), |_, _| ());
            [0, 1, 2, 3].map(|order| series.derivative(order).0)
        };
        let range = |x: f64| (Interval::of(x), Interval::of(x + STEP), Interval { lo: x, hi: x + STEP });
        let ((u0, u1, all_u), (e0, e1, all_e)) = (range(u), range(epsilon));
        let here = over(u0, e0);
        let (by_u, by_e) = (over(u1, e0), over(u0, e1));
        let (along_u, along_e) = (over(all_u, e0), over(u0, all_e));
        let mut pairs = Vec::new();
        for k in 0..4 {
            pairs.push(((by_e[k][0] - here[k][0]) / (e1 - e0), along_e[k][1]));
            if k < 3 {
                pairs.extend([0, 1].map(|j| ((by_u[k][j] - here[k][j]) / (u1 - u0), along_u[k + 1][j])));
            }
        }
        for (quotient, derivative) in pairs {
            // Outside the domain of a function neither has bounds.
            prop_assume!(quotient.is_bounded() && derivative.is_bounded());
            let both = format!("{text} at {u} {epsilon} {a}: {quotient:?} {derivative:?}");
            prop_assert!(quotient.lo.max(derivative.lo) <= quotient.hi.min(derivative.hi), "{}", both);
            // They agree in some digits, except where a formula cancels.
            let largest = derivative.lo.abs().max(derivative.hi.abs()).max(1.0);
            let widest = (quotient.hi - quotient.lo).max(derivative.hi - derivative.lo);
            prop_assume!(widest <= 1e-2 * largest);
        }
        let slip = Jet::<Jet<f64, 2>, 4>::variable(Jet::of(u), 1.0);
        let rounded = curve.run(slip, Jet::of(Jet::variable(epsilon, 1.0)), |_, _| ());
        for (k, series) in here.iter().enumerate() {
            for (j, enclosed) in series.iter().enumerate() {
                let plain = rounded.derivative(k).0[j];
                prop_assert!((enclosed.lo..=enclosed.hi).contains(&plain), "{} {} {}: {:?} {}", text, k, j, enclosed, plain);
            }
        }
    }
}

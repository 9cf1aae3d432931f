//! Compares derivatives by Taylor series with the formulas that the crate `exmex` derives.
//!
//! Both are evaluated over intervals with outward rounding, so no tolerance is needed: two enclosures of one
//! number intersect, and an enclosure contains the result of the same operations with rounding to nearest.

use std::str::FromStr;

use exmex::{BinOp, Differentiate, Express, FlatEx, MakeOperators, NumberMatcher, Operator};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;

use super::*;

/// An interval in the form that exmex needs.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Enclosed(Interval);

impl Default for Enclosed {
    fn default() -> Self {
        Self::from(0)
    }
}

impl From<f32> for Enclosed {
    fn from(x: f32) -> Self {
        Self(Interval::of(x.into()))
    }
}

impl From<u8> for Enclosed {
    fn from(x: u8) -> Self {
        Self(Interval::of(x.into()))
    }
}

impl FromStr for Enclosed {
    type Err = std::num::ParseFloatError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        text.parse().map(|x| Self(Interval::of(x)))
    }
}

#[derive(Clone, Debug)]
struct Operators;

impl MakeOperators<Enclosed> for Operators {
    fn make<'a>() -> Vec<Operator<'a, Enclosed>> {
        let bin =
            |apply: fn(Enclosed, Enclosed) -> Enclosed, prio| BinOp { apply, prio, is_commutative: false };
        vec![
            Operator::make_bin_unary("+", bin(|a, b| Enclosed(a.0 + b.0), 0), |a| a),
            Operator::make_bin_unary("-", bin(|a, b| Enclosed(a.0 - b.0), 1), |a| Enclosed(-a.0)),
            Operator::make_bin("*", bin(|a, b| Enclosed(a.0 * b.0), 2)),
            Operator::make_bin("/", bin(|a, b| Enclosed(a.0 / b.0), 3)),
            Operator::make_bin("^", bin(power, 4)),
            Operator::make_unary("exp", |a| Enclosed(call(Function::Exp, a.0))),
            Operator::make_unary("ln", |a| Enclosed(call(Function::Ln, a.0))),
            Operator::make_unary("sqrt", |a| Enclosed(call(Function::Sqrt, a.0))),
            Operator::make_unary("sin", |a| Enclosed(call(Function::Sin, a.0))),
            Operator::make_unary("cos", |a| Enclosed(call(Function::Cos, a.0))),
            Operator::make_unary("tan", |a| Enclosed(call(Function::Tan, a.0))),
            Operator::make_unary("sinh", |a| Enclosed(call(Function::Sinh, a.0))),
            Operator::make_unary("cosh", |a| Enclosed(call(Function::Cosh, a.0))),
            Operator::make_unary("tanh", |a| Enclosed(call(Function::Tanh, a.0))),
            Operator::make_unary("atan", |a| Enclosed(call(Function::Atan, a.0))),
        ]
    }
}

fn power(base: Enclosed, exponent: Enclosed) -> Enclosed {
    let Interval { lo, hi } = exponent.0;
    if lo == hi && lo.fract() == 0.0 && lo.abs() <= 64.0 {
        Enclosed(base.0.powi(lo as i32))
    } else {
        Enclosed((exponent.0 * base.0.ln()).exp())
    }
}

type Formula = FlatEx<Enclosed, Operators, NumberMatcher>;

/// Fully parenthesised formulas, since the two parsers differ in how tightly signs bind.
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

#[test]
fn derivatives_are_those_of_the_formulas() {
    // exmex recurses for each level of a formula, and formulas of fourth derivatives have thousands. Every
    // run tests the same formulas, since a deeper one could overflow any stack.
    let config = ProptestConfig {
        cases: 200,
        max_global_rejects: 2000,
        rng_seed: RngSeed::Fixed(1),
        ..ProptestConfig::default()
    };
    let room = std::thread::Builder::new().stack_size(1 << 29);
    let trial = room.spawn(move || {
        proptest!(config, |(text in formula(), u in 0.1..2.0, epsilon in 0.1..1.0, a in 0.5..3.0)| {
            check(&text, u, epsilon, a)?;
        });
    });
    trial.unwrap().join().unwrap();
}

fn check(text: &str, u: f64, epsilon: f64, a: f64) -> Result<(), TestCaseError> {
    let law = Expression::new(text, 1.0).unwrap();
    let curve = law.curve(epsilon, &LawParameters::new(&[a][..law.parameters().len()]));
    let slip = Jet::<Jet<Interval, 2>, 4>::variable(Jet::of(Interval::of(u)), 1.0);
    let size = Jet::of(Jet::variable(Interval::of(epsilon), 1.0));
    let series = curve.run(slip, size, |_, _| ());
    let rounded = curve.run(
        Jet::<Jet<f64, 2>, 4>::variable(Jet::of(u), 1.0),
        Jet::of(Jet::variable(epsilon, 1.0)),
        |_, _| (),
    );

    let whole = Formula::parse(text).unwrap();
    let names = whole.var_names().to_vec();
    let values: Vec<Enclosed> = names
        .iter()
        .map(|name| match name.as_str() {
            "u" => u,
            "eps" => epsilon,
            _ => a,
        })
        .map(|x| Enclosed(Interval::of(x)))
        .collect();
    for by_epsilon in 0..2 {
        for by_u in 0..4 {
            let ours = series.derivative(by_u).0[by_epsilon];
            let plain = rounded.derivative(by_u).0[by_epsilon];
            let index = |name: &str| names.iter().position(|known| known == name);
            let order = [("u", by_u), ("eps", by_epsilon)];
            let symbolic = if order.iter().any(|(name, times)| *times > 0 && index(name).is_none()) {
                Interval::of(0.0)
            } else {
                let each = order.iter().flat_map(|(name, times)| std::iter::repeat_n(index(name), *times));
                let each: Vec<usize> = each.flatten().collect();
                whole.clone().partial_iter(each.into_iter()).unwrap().eval(&values).unwrap().0
            };
            // Outside the domain of a function neither has bounds.
            prop_assume!(ours.is_bounded() && symbolic.is_bounded());
            let both =
                format!("{text} by u {by_u} and eps {by_epsilon} times: {ours:?} {symbolic:?} {plain}");
            prop_assert!(ours.lo.max(symbolic.lo) <= ours.hi.min(symbolic.hi), "{}", both);
            prop_assert!((ours.lo..=ours.hi).contains(&plain), "{}", both);
            // They agree in many digits, except where a formula cancels.
            let largest = ours.lo.abs().max(ours.hi.abs()).max(1.0);
            prop_assume!((ours.hi - ours.lo).max(symbolic.hi - symbolic.lo) <= 1e-6 * largest);
        }
    }
    Ok(())
}

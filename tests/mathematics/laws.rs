//! Friction laws beyond the paper's: their definitions, their gradients, laws given as functions, and tables in
//! extended precision.

use crate::reference;
use crate::runge_kutta::step;
use crate::sample::{Random, Sampling, formula};
use slipmap::certify::{Decision, Guarantee, TESTS, Test};
use slipmap::certify::{curve, validated};
use slipmap::column::critical_damping;
use slipmap::filippov::{Eigenvalues, Oscillator};
use slipmap::flow::Fate;
use slipmap::friction::{Accuracy, Column, CustomLaw, Expression, Function, Law, Parameter, Table};
use slipmap::orbits::flow;
use slipmap::point::LawParameters;
use slipmap::witness;
use slipmap::witness::{Start, trace};

/// Relative difference of two numbers that may be infinite.
fn apart(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()).max(1.0) }
}

/// Columns of every other law.
fn columns(count: usize) -> Vec<(Law, Column)> {
    let mut random = Random(66);
    let wavy = Expression::new("1 - d*tanh(u/w) + p*sin(3*u)^2", 1.0).unwrap();
    let data: Vec<(f64, f64)> =
        (0..60).map(|i| 0.2 * f64::from(i)).map(|u| (u, 0.6 + 0.4 * (-u).exp() + 0.02 * u)).collect();
    let measured = Table::new("sampled", &data, 1.0).unwrap();
    let laws = [Law::Exponential, Law::Lorentzian, Law::Expression(wavy), Law::Table(measured)];
    (0..count)
        .map(|i| {
            let law = &laws[i % laws.len()];
            let parameters = match law {
                Law::Expression(_) => {
                    vec![random.between(0.0, 0.5), random.log(0.2, 2.0), random.between(0.0, 0.1)]
                }
                Law::Table(_) => vec![],
                _ => vec![random.between(0.0, 1.0), random.log(0.2, 3.0), random.between(0.0, 0.1)],
            };
            let (epsilon, belt_speed) = (random.log(0.1, 1.0), random.log(0.1, 3.0));
            (law.clone(), law.column(&law.point(epsilon, &parameters, belt_speed, 0.0).unwrap()))
        })
        .collect()
}

#[test]
fn definitions_make_the_same_law_again() {
    let table = Table::new("a file.csv", &[(0.0, 0.4), (0.5, 0.31), (2.0, 0.3)], 0.4).unwrap();
    let text = Expression::new("0.4*exp(-u/vs)", 0.4).unwrap();
    let uncertain = table.with_standard_errors(&[0.0, 0.01, 0.02]).unwrap();
    let function = Function::new("a function", |u| 0.5 + 0.5 * (-u).exp(), 8.0, &[2.0]).unwrap();
    let others = [Law::Table(table), Law::Expression(text), Law::Table(uncertain), Law::Function(function)];
    let stretched =
        [Law::Stretched, Law::Exponential.read_as_small().with_exponent(), Law::Stretched.with_drop()];
    for law in Law::BUILT_IN.into_iter().chain(others).chain(stretched) {
        assert_eq!(Law::from_definition(law.name(), &law.definition()), Some(law));
    }
    assert_eq!(Law::from_definition("unheard of", ""), None);
    // Read as small at most once, however often a forger wrote it.
    let small = |times: usize| "small eps\n".repeat(times) + "1\nexp(-u)";
    assert!(Law::from_definition("expression", &small(1)).is_some());
    assert_eq!(Law::from_definition("expression", &small(2)), None);
    assert_eq!(Law::from_definition("expression", &small(300_000)), None);
    assert_eq!(Law::from_definition("expression", "1\n1 +"), None);
}

#[test]
fn a_law_given_as_a_function_is_the_law_built_in() {
    let function = Function::new("exponential", |u| 0.5 + 0.5 * (-u).exp(), 16.0, &[]).unwrap();
    assert!(function.error() > 0.0);
    let (own, built_in) = (Law::Function(function), Law::Exponential);
    for i in 1..=16 {
        let belt_speed = 0.2 * f64::from(i);
        let column =
            |law: &Law, values: &[f64]| law.column(&law.point(0.5, values, belt_speed, 0.0).unwrap());
        let found = critical_damping(&column(&own, &[]), 1e-12).unwrap();
        let exact = critical_damping(&column(&built_in, &[0.5, 1.0, 0.0]), 1e-12).unwrap();
        assert!(
            (found.c - exact.c).abs() <= found.error + exact.error,
            "V = {belt_speed}: {found:?} {exact:?}"
        );
    }
    // The comparison lemma: an error delta of the weakening rate moves eps c* by at most delta. Friction that is constant
    // but for the rounding of its samples has no cycle, and no proof of one.
    let wavy = |u: f64| if u > 0.0 { 1.0 - 1e-16 * (1e3 * u).sin() } else { 1.0 };
    for function in [Function::new("flat", |_| 1.0, 8.0, &[]), Function::new("wavy", wavy, 8.0, &[])] {
        let law = Law::Function(function.unwrap());
        for epsilon in [0.1, 1.0] {
            let column = law.column(&law.point(epsilon, &[], 0.3, 0.0).unwrap());
            let found = critical_damping(&column, 1e-12).unwrap();
            assert!(found.c.abs() <= found.error, "{found:?}");
            nothing_is_proved(&column);
        }
    }
}

/// No test claims a theorem about the column.
fn nothing_is_proved(column: &Column) {
    let is_theorem = |test: &&Test| test.guarantee.is_rigorous();
    for test in TESTS.iter().filter(is_theorem) {
        let claim = test.claim(column);
        let silent = claim.present_below == f64::NEG_INFINITY && claim.absent_above == f64::INFINITY;
        assert!(silent, "{}: {claim:?}", test.name);
    }
}

/// A law given by its friction and its slope as functions of u and of its parameters.
#[derive(Debug)]
struct ByFunctions {
    parameters: Vec<Parameter>,
    phi: fn(f64, &[f64]) -> f64,
    slope: fn(f64, &[f64]) -> f64,
}

impl ByFunctions {
    fn law(
        names: &[&'static str],
        phi: fn(f64, &[f64]) -> f64,
        slope: fn(f64, &[f64]) -> f64,
    ) -> Option<Law> {
        let parameter = |&name: &&'static str| Parameter { name, long_name: name, min: 0.0, max: 1e9 };
        Law::custom(Self { parameters: names.iter().map(parameter).collect(), phi, slope }).ok()
    }
}

impl CustomLaw for ByFunctions {
    fn name(&self) -> &'static str {
        "functions"
    }

    fn parameters(&self) -> &[Parameter] {
        &self.parameters
    }

    fn phi(&self, u: f64, _epsilon: f64, parameters: &[f64]) -> f64 {
        (self.phi)(u, parameters)
    }

    fn slope(&self, u: f64, _epsilon: f64, parameters: &[f64]) -> f64 {
        (self.slope)(u, parameters)
    }
}

/// The law of the text `1 - d*tanh(u/w)`, with parameters of these names.
fn hyperbolic(names: &[&'static str]) -> Option<Law> {
    ByFunctions::law(
        names,
        |u, p| 1.0 - p[0] * (u / p[1]).tanh(),
        |u, p| -p[0] / p[1] / (u / p[1]).cosh().powi(2),
    )
}

#[test]
fn functions_are_simulated_as_their_formula_unproved() {
    let text = formula("1 - d*tanh(u/w)");
    let law = hyperbolic(&["d", "w"]).unwrap();
    let mut random = Random(70);
    for _ in 0..30 {
        let parameters = [random.between(0.1, 0.6), random.log(0.3, 2.0)];
        let point = law.point(1.0, &parameters, random.log(0.1, 2.0), 0.0).unwrap();
        let columns = [&law, &text].map(|law| law.column(&point));
        let [a, b] = columns.each_ref().map(|column| critical_damping(column, 1e-12));
        match [a, b] {
            [Ok(a), Ok(b)] => assert!((a.c - b.c).abs() <= a.error + b.error, "{point:?}: {a:?} {b:?}"),
            _ => assert_eq!(a, b, "{point:?}"),
        }
        let reach = 2.0 * point.belt_speed;
        assert!(
            matches!(columns[0].curve.compiled(reach).error(0.0, reach), Accuracy::Sampled(e) if e < 1e-11)
        );
        assert!(
            matches!(columns[1].curve.compiled(reach).error(0.0, reach), Accuracy::Proved(e) if e < 1e-11)
        );
        nothing_is_proved(&columns[0]);
    }
    assert!(matches!(hyperbolic(&[]), Some(Law::Custom(_))));
    // The belt speed is no parameter of a law.
    assert!(hyperbolic(&["V"]).is_none());
}

/// The oscillator of Leine and others with the damping of a node, by functions: nothing proves its divergence
/// negative, and orbits creep.
#[test]
fn nodes_of_a_law_given_by_functions_are_followed_to_rest() {
    let slope = |u: f64, a: &[f64]| -a[0] / (1.0 + a[0] * u).powi(2);
    let law = ByFunctions::law(&["a"], |u, a| 1.0 / (1.0 + a[0] * u), slope).unwrap();
    let text = formula("1/(1 + a*u)");
    let point = law.point(1.0, &[3.0], 0.2, 0.0).unwrap();
    let [found, exact] = [&law, &text].map(|law| critical_damping(&law.column(&point), 1e-12).unwrap());
    assert!((found.c - exact.c).abs() <= found.error + exact.error, "{found:?} {exact:?}");
    for c in [3.2, 3.5, 3.9] {
        let oscillator = Oscillator::in_column(&law.column(&point), c);
        assert!(!matches!(oscillator.eigenvalues(), Eigenvalues::Complex { .. }));
        let fate = witness::flow(&oscillator, 1e-10).fate;
        assert_eq!(fate, Fate::SpiralsInward, "{c}");
    }
}

#[test]
fn a_law_is_read_as_small_on_request() {
    for (law, column) in columns(80) {
        let by_name =
            |name: &str, column: &Column| TESTS.iter().find(|test| test.name == name).unwrap().claim(column);
        assert_eq!(by_name("perturbation", &column).present_below, f64::NEG_INFINITY, "{}", law.name());
        let epsilon = column.epsilon;
        let parameters = &[0.3, 0.7, 0.02][..law.parameters().len()];
        let point = law.point(epsilon, parameters, column.belt_speed, 0.0).unwrap();
        let (written, small) = (law.column(&point), law.clone().read_as_small().column(&point));
        // (6) with F = (phi - 1) / eps is the energy balance.
        let (balance, first) = (by_name("harmonic_balance", &written), by_name("perturbation", &small));
        assert!(apart(balance.present_below, first.present_below) <= 1e-13, "{balance:?} {first:?}");
        assert!(apart(balance.absent_above, first.absent_above) <= 1e-13, "{balance:?} {first:?}");
        let least = written.curve.weakening_range(0.0, 2.0 * column.belt_speed).lo / epsilon;
        assert!(apart(by_name("bendixson_leading", &small).present_below, least) <= 1e-13);
        // Nothing else changes.
        for test in TESTS.iter().filter(|test| test.guarantee == Guarantee::FiniteEpsilon) {
            assert_eq!(test.claim(&written), test.claim(&small), "{}", test.name);
        }
        let small = law.read_as_small();
        assert_eq!(Law::from_definition(small.name(), &small.definition()), Some(small));
    }
}

#[test]
fn gradients_of_the_weakening_rate_are_its_differences() {
    let formula = formula("1 - d*tanh(u/w) + eps*p*sin(3*u)^2");
    let laws = [
        (Law::Stribeck, vec![0.3, 0.1, 2.0]),
        (Law::Exponential, vec![0.3, 0.7, 0.1]),
        (Law::Stretched, vec![0.3, 0.7, 0.1, 1.5]),
        (Law::Stretched, vec![0.3, 0.7, 0.1, 2.5]),
        (Law::Lorentzian, vec![0.3, 0.7, 0.1]),
        (formula, vec![0.3, 0.7, 0.1]),
        (hyperbolic(&["d", "w"]).unwrap(), vec![0.3, 0.7]),
    ];
    let epsilon = 0.4;
    for (law, parameters) in laws {
        for u in [0.0, 0.1, 0.6, 1.3, 5.0] {
            let at = |epsilon: f64, parameters: &[f64]| {
                law.curve(epsilon, &LawParameters::new(parameters)).weakening(u)
            };
            let gradient = law.curve(epsilon, &LawParameters::new(&parameters)).weakening_gradient(u);
            // Truncation of the second order with third derivatives up to some hundreds; round-off over the
            // step.
            let step = 1e-5;
            let close = |a: f64, b: f64| (a - b).abs() <= 1e-7 * (1.0 + a.abs());
            let by_epsilon =
                (at(epsilon + step, &parameters) - at(epsilon - step, &parameters)) / (2.0 * step);
            assert!(close(gradient.epsilon, by_epsilon), "{} {u}: {gradient:?} {by_epsilon}", law.name());
            for i in 0..parameters.len() {
                let moved = |step: f64| {
                    let mut moved = parameters.clone();
                    moved[i] += step;
                    at(epsilon, &moved)
                };
                let difference = (moved(step) - moved(-step)) / (2.0 * step);
                let found = gradient.parameters.as_slice()[i];
                assert!(close(found, difference), "{} {u}, parameter {i}: {found} {difference}", law.name());
            }
        }
    }
}

/// R. I. Leine, D. H. van Campen, A. de Kraker, L. van den Steen, "Stick-slip vibrations induced by alternate
/// friction models", Nonlinear Dynamics 16 (1998) 41-54: unit mass and stiffness, friction 1 / (1 + 3 |v|),
/// belt speed 0.2. Their cycle in all digits, by other programs: period 12.00103129, greatest displacement
/// 1.13394467.
#[test]
fn the_stick_slip_cycle_of_leine_and_others() {
    let law = formula("1/(1 + 3*u)");
    let point = law.point(1.0, &[], 0.2, 0.0).unwrap();
    let oscillator = Oscillator::new(&law, &point);
    for answer in [flow(&oscillator, 1e-12), witness::flow(&oscillator, 1e-12)] {
        let Fate::Sticks(landing) = answer.fate else { panic!("{answer:?}") };
        // Half a unit of the last digit given.
        assert!((landing.slip_time + landing.stick_time - 12.001_031_29).abs() <= 0.5e-8, "{landing:?}");
    }
    // The turning point by the classical Runge-Kutta method from the exit point (1, 0.2) to x2 = 0: with
    // steps of 1e-4 its error is far below the last digit; the step that passes the turning point is bisected
    // until it vanishes.
    let rate = |[x1, x2]: [f64; 2]| [x2, 1.0 / (1.0 + 3.0 * (0.2 - x2)) - x1];
    let (mut state, mut h) = ([1.0, 0.2], 1e-4);
    while h > 1e-12 {
        let next = step(&rate, state, h);
        if next[1] < 0.0 {
            h *= 0.5;
        } else {
            state = next;
        }
    }
    let [x1, _] = state;
    let greatest =
        trace(&oscillator, Start::ExitPoint, 1e-12, 20.0).samples.iter().map(|s| s.x1).fold(0.0, f64::max);
    // Their last digit is truncated.
    assert!((0.0..1e-8).contains(&(x1 - 1.133_944_67)), "{x1}");
    // Samples are at most 0.1 rad apart.
    assert!(greatest <= x1 + 1e-9 && x1 - greatest <= 0.2 * 0.05, "{greatest} {x1}");
}

/// A row of `law_dampings.csv` or of `drop_dampings.csv`.
#[derive(serde::Deserialize)]
struct ReferenceLaw {
    kind: String,
    law: String,
    /// Friction at rest where it drops as slip begins.
    #[serde(rename = "static")]
    level: Option<f64>,
    #[serde(rename = "V")]
    belt_speed: f64,
    critical: f64,
}

impl ReferenceLaw {
    /// The law, and the parameters of one built in.
    fn law(&self) -> (Law, Vec<f64>) {
        let level = self.level.unwrap_or(1.0);
        let number = |text: &str| text.parse::<f64>().unwrap();
        match self.kind.as_str() {
            "coulomb" => (Law::Coulomb, self.law.split(' ').map(number).collect()),
            "formula" => (Law::Expression(Expression::with_static(&self.law, level).unwrap()), vec![]),
            _ => {
                let pair = |pair: &str| {
                    let (u, phi) = pair.split_once(':').unwrap();
                    (number(u), number(phi))
                };
                let data: Vec<(f64, f64)> = self.law.split(';').map(pair).collect();
                (Law::Table(Table::with_static("random", &data, level).unwrap()), vec![])
            }
        }
    }
}

/// Five hundred random laws, two hundred of them with a drop, compared with independent 128-bit arithmetic.
#[test]
fn critical_dampings_of_random_laws_are_those_of_the_reference() {
    for (file, counts) in [("law_dampings.csv", [0, 200, 100]), ("drop_dampings.csv", [50, 100, 50])] {
        let mut seen = [0; 3];
        for row in reference::rows::<ReferenceLaw>(file) {
            let (law, parameters) = row.law();
            let column = law.column(&law.point(1.0, &parameters, row.belt_speed, 0.0).unwrap());
            let found = critical_damping(&column, 1e-13).unwrap();
            let missed = (found.c - row.critical).abs();
            assert!(
                missed <= 1e-11 * row.critical && missed <= found.error + 1e-15,
                "{} at V = {}: {found:?} {}",
                row.law,
                row.belt_speed,
                row.critical
            );
            // Every theorem is on the right side of it, or leaves it in its undecided gap.
            for test in TESTS.iter().filter(|test| test.guarantee == Guarantee::FiniteEpsilon) {
                let claim = test.claim(&column);
                let holds = claim.present_below <= row.critical && claim.absent_above >= row.critical;
                assert!(holds, "{} of {}: {claim:?} {}", test.name, row.law, row.critical);
            }
            seen[["coulomb", "formula", "table"].iter().position(|kind| *kind == row.kind).unwrap()] += 1;
        }
        assert_eq!(seen, counts, "{file}");
    }
}

/// The method `validated` on laws other than Stribeck's: the critical damping of the simulation is inside,
/// and no claim is contradicted by the direct engine.
#[test]
fn validated_encloses_every_law() {
    let mut random = Random(68);
    let (mut sharp, mut all) = (0, 0);
    for (law, column) in columns(8) {
        let proof = curve::prove(&column).critical();
        let [lo, hi] = [proof.lo, proof.hi];
        if let Ok(found) = critical_damping(&column, 1e-11) {
            let slack = 2.0 * found.error + 1e-14 * found.c.abs();
            assert!(
                lo <= found.c + slack && found.c - slack <= hi,
                "{law:?} {column:?}: {proof:?} {found:?}"
            );
        }
        all += 1;
        let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
        sharp +=
            u32::from(column.epsilon * (proof.hi - proof.lo) < 1e-7 * range.hi.abs().max(range.lo.abs()));
        let claim = validated::TEST.claim(&column);
        for _ in 0..2 {
            let c = random.between(0.0, 1.2) * range.hi.max(0.01) / column.epsilon;
            let fate = witness::flow(&Oscillator::in_column(&column, c), 1e-10).fate;
            let contradicted = match claim.decide(c) {
                Decision::Present => matches!(fate, Fate::SpiralsInward | Fate::CrossesForever),
                Decision::Absent => matches!(fate, Fate::Sticks(_) | Fate::CrossesForever),
                Decision::Undecided => false,
            };
            assert!(!contradicted, "{law:?} {column:?} at {c}: {claim:?} {fate:?}");
        }
    }
    assert!(sharp > 0, "none of {all} is sharp");
}

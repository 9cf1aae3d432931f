//! Friction laws beyond the paper's: the same Stribeck law by closed form and as text, certificates of every
//! law against the simulated flow, and the engines against each other.

use crate::sample::Random;
use slipmap::certify::validated::{self, any_law};
use slipmap::certify::{Decision, TESTS};
use slipmap::filippov::Oscillator;
use slipmap::friction::{Column, Expression, Law, Table};
use slipmap::point::{LawParameters, Point};
use slipmap::simulate::{Fate, critical_damping, direct, flow};

const STRIBECK: &str = "(1 - alpha)/(1 + eps*gamma*u) + alpha + eps*beta*u^2";

/// The Stribeck law as text; its parameters appear in the order alpha, gamma, beta.
fn stribeck_as_text() -> Law {
    Law::Expression(Expression::new(STRIBECK, 1.0).unwrap())
}

fn between(random: &mut Random, lo: f64, hi: f64) -> f64 {
    lo + (hi - lo) * random.unit()
}

/// Relative difference of two numbers that may be infinite.
fn apart(a: f64, b: f64) -> f64 {
    if a == b { 0.0 } else { (a - b).abs() / a.abs().max(b.abs()).max(1.0) }
}

#[test]
fn stribeck_as_text_gives_the_same_verdicts_and_margins() {
    let mut random = Random(6);
    for _ in 0..150 {
        let (epsilon, belt_speed) = (random.log(1e-3, 1.0), random.log(0.1, 5.0));
        let (alpha, beta, gamma) =
            (between(&mut random, 0.0, 1.0), between(&mut random, 0.0, 0.3), between(&mut random, 0.1, 8.0));
        let damping = between(&mut random, 0.0, 1.2) * gamma * (1.0 - alpha);
        let point = |law: [f64; 3]| Point { epsilon, law: LawParameters::new(&law), belt_speed, damping };
        let built_in = point([alpha, beta, gamma]);
        let as_text = point([alpha, gamma, beta]);
        let columns = [Law::Stribeck.column(&built_in), stribeck_as_text().column(&as_text)];
        for test in &TESTS {
            let claims = columns.clone().map(|column| (test.claim)(&column));
            assert_eq!(claims[0].decide(damping), claims[1].decide(damping), "{} at {built_in:?}", test.name);
            let margins = claims.map(|claim| claim.margin(damping));
            assert!(apart(margins[0], margins[1]) <= 1e-12, "{} at {built_in:?}: {margins:?}", test.name);
        }
        let flows = columns.clone().map(|column| flow(&Oscillator::in_column(&column, damping), 1e-12));
        let decided = |fate: &Fate| std::mem::discriminant(fate);
        assert_eq!(decided(&flows[0].fate), decided(&flows[1].fate), "{built_in:?}: {flows:?}");
        let margins = flows.map(|flow| flow.margin);
        let both_nan = margins[0].is_nan() && margins[1].is_nan();
        // Two kernels, each within its error estimate.
        let allowed = 1e-12 + flows[0].margin_error + flows[1].margin_error;
        assert!(both_nan || (margins[0] - margins[1]).abs() <= allowed, "{built_in:?}: {flows:?}");
        let roots = columns.map(|column| critical_damping(&column, 1e-12).map(|root| root.c));
        if let [Ok(a), Ok(b)] = roots {
            assert!(apart(a, b) <= 1e-10, "{built_in:?}: {a} {b}");
        }
    }
}

/// Columns of every other law.
fn columns(count: usize) -> Vec<(Law, Column)> {
    let mut random = Random(66);
    let wavy = Expression::new("1 - d*tanh(u/w) + e*sin(3*u)^2", 1.0).unwrap();
    let data: Vec<(f64, f64)> =
        (0..60).map(|i| 0.2 * f64::from(i)).map(|u| (u, 0.6 + 0.4 * (-u).exp() + 0.02 * u)).collect();
    let measured = Table::new("sampled", &data, 1.0).unwrap();
    let laws = [Law::Exponential, Law::Lorentzian, Law::Expression(wavy), Law::Table(measured)];
    (0..count)
        .map(|i| {
            let law = &laws[i % laws.len()];
            let parameters = match law {
                Law::Expression(_) => {
                    vec![between(&mut random, 0.0, 0.5), random.log(0.2, 2.0), between(&mut random, 0.0, 0.1)]
                }
                Law::Table(_) => vec![],
                _ => {
                    vec![between(&mut random, 0.0, 1.0), random.log(0.2, 3.0), between(&mut random, 0.0, 0.1)]
                }
            };
            let (epsilon, belt_speed) = (random.log(0.1, 1.0), random.log(0.1, 3.0));
            let law_parameters = LawParameters::new(&parameters);
            (law.clone(), law.column(&Point { epsilon, law: law_parameters, belt_speed, damping: 0.0 }))
        })
        .collect()
}

#[test]
fn theorems_hold_for_every_law() {
    let mut random = Random(67);
    let (mut proved, mut absent) = (0, 0);
    for (law, column) in columns(240) {
        let claims: Vec<_> = TESTS
            .iter()
            .filter(|test| test.guarantee == slipmap::certify::Guarantee::FiniteEpsilon)
            .map(|test| (test.name, (test.claim)(&column)))
            .collect();
        let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
        for _ in 0..4 {
            let c = between(&mut random, 0.0, 1.2) * range.hi.max(0.01) / column.epsilon;
            let answer = direct::flow(&Oscillator::in_column(&column, c), 1e-10);
            for (name, claim) in &claims {
                let found = match answer.fate {
                    Fate::Sticks(_) => Decision::Present,
                    Fate::SpiralsInward | Fate::CrossesForever => Decision::Absent,
                    Fate::TooCloseToCall | Fate::Failed(_) => continue,
                };
                match claim.decide(c) {
                    Decision::Undecided => {}
                    decided => {
                        assert_eq!(
                            decided,
                            found,
                            "{name} of {} at c = {c}: {column:?} {answer:?}",
                            law.name()
                        );
                        proved += usize::from(decided == Decision::Present);
                        absent += usize::from(decided == Decision::Absent);
                    }
                }
            }
        }
    }
    assert!(proved > 200 && absent > 200, "{proved} proofs of presence, {absent} of absence");
}

#[test]
fn engines_agree_for_every_law() {
    let mut random = Random(68);
    for (law, column) in columns(160) {
        let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
        let c = between(&mut random, 0.0, 1.2) * range.hi.max(0.01) / column.epsilon;
        let oscillator = Oscillator::in_column(&column, c);
        let (map, direct) = (flow(&oscillator, 1e-10), direct::flow(&oscillator, 1e-10));
        let open = |fate: &Fate| matches!(fate, Fate::TooCloseToCall | Fate::Failed(_));
        if open(&map.fate) || open(&direct.fate) {
            continue;
        }
        let same = std::mem::discriminant(&map.fate) == std::mem::discriminant(&direct.fate);
        assert!(same, "{}: {column:?} c = {c}: {map:?} {direct:?}", law.name());
        if map.margin.is_finite() && direct.margin.is_finite() && map.margin < 0.0 {
            // Below the line nothing is continued. Each engine is within its own error.
            let allowed = map.margin_error + direct.margin_error;
            assert!((map.margin - direct.margin).abs() <= allowed, "{}: {map:?} {direct:?}", law.name());
        }
    }
}

#[test]
fn critical_damping_is_where_the_direct_engine_changes_its_mind() {
    let mut found = 0;
    for (law, column) in columns(60) {
        let Ok(root) = critical_damping(&column, 1e-10) else { continue };
        let fate = |c: f64| direct::flow(&Oscillator::in_column(&column, c), 1e-11).fate;
        let step = 1e-6 * root.c.abs() + 10.0 * root.error;
        let (below, above) = (fate(root.c - step), fate(root.c + step));
        assert!(!matches!(below, Fate::SpiralsInward), "{}: {column:?} {root:?} {below:?}", law.name());
        assert!(
            matches!(above, Fate::SpiralsInward | Fate::TooCloseToCall),
            "{}: {column:?} {above:?}",
            law.name()
        );
        found += 1;
    }
    assert!(found > 40, "only {found} roots");
}

#[test]
fn definitions_make_the_same_law_again() {
    let table = Table::new("a file.csv", &[(0.0, 0.4), (0.5, 0.31), (2.0, 0.3)], 0.4).unwrap();
    let text = Expression::new("0.4*exp(-u/vs)", 0.4).unwrap();
    for law in Law::BUILT_IN.into_iter().chain([Law::Table(table), Law::Expression(text)]) {
        assert_eq!(Law::from_definition(law.name(), &law.definition()), Some(law));
    }
    assert_eq!(Law::from_definition("unheard of", ""), None);
    assert_eq!(Law::from_definition("expression", "1\n1 +"), None);
}

#[test]
fn errors_are_within_their_estimates() {
    let mut random = Random(69);
    for (law, column) in columns(240) {
        let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
        let c = between(&mut random, 0.0, 1.2) * range.hi.max(0.01) / column.epsilon;
        let oscillator = Oscillator::in_column(&column, c);
        let reference = flow(&oscillator, 1e-15);
        for tolerance in [1e-6, 1e-9, 1e-12] {
            for answer in [flow(&oscillator, tolerance), direct::flow(&oscillator, tolerance)] {
                // NaN where an engine does not continue the field beyond the belt line.
                let missed = (answer.margin - reference.margin).abs();
                let allowed = answer.margin_error + reference.margin_error;
                assert!(
                    missed.is_nan() || missed <= allowed,
                    "{} c = {c}: {answer:?} {reference:?}",
                    law.name()
                );
            }
        }
    }
}

/// The method `validated` on laws other than Stribeck's: the critical damping of the simulation is inside, and no claim
/// is contradicted by the direct engine.
#[test]
fn validated_encloses_every_law() {
    let mut random = Random(68);
    let (mut sharp, mut all) = (0, 0);
    for (law, column) in columns(80) {
        let proof = any_law::prove(&column);
        let [lo, hi] = [proof.critical.lo, proof.critical.hi].map(|viscous| viscous / column.epsilon);
        if let Ok(found) = critical_damping(&column, 1e-11) {
            let slack = 2.0 * found.error + 1e-14 * found.c.abs();
            assert!(
                lo <= found.c + slack && found.c - slack <= hi,
                "{law:?} {column:?}: {proof:?} {found:?}"
            );
        }
        all += 1;
        let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
        sharp += u32::from(proof.critical.hi - proof.critical.lo < 1e-9 * range.hi.abs().max(range.lo.abs()));
        let claim = (validated::TEST.claim)(&column);
        for _ in 0..2 {
            let c = between(&mut random, 0.0, 1.2) * range.hi.max(0.01) / column.epsilon;
            let fate = direct::flow(&Oscillator::in_column(&column, c), 1e-10).fate;
            let contradicted = match claim.decide(c) {
                Decision::Present => matches!(fate, Fate::SpiralsInward | Fate::CrossesForever),
                Decision::Absent => matches!(fate, Fate::Sticks(_) | Fate::CrossesForever),
                Decision::Undecided => false,
            };
            assert!(!contradicted, "{law:?} {column:?} at {c}: {claim:?} {fate:?}");
        }
    }
    assert!(10 * sharp > 7 * all, "{sharp} of {all}");
}

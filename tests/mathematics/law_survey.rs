//! Random pairs of a friction law and a point: every verdict of the map and every claim of a theorem compared
//! with the direct engine, which shares nothing with them but the law.

use crate::sample::Random;
use rayon::prelude::*;
use slipmap::certify::{Decision, Guarantee, TESTS};
use slipmap::filippov::Oscillator;
use slipmap::friction::{Column, Expression, Law, Table};
use slipmap::map::{Engine, Verdict, decide};
use slipmap::simulate::return_map::{Turn, turns_of};
use slipmap::simulate::{Fate, Flow, critical_damping};
use slipmap::witness;
use std::collections::BTreeMap;

/// The tolerance of maps.
const TOLERANCE: f64 = 1e-9;

fn between(random: &mut Random, lo: f64, hi: f64) -> f64 {
    lo + (hi - lo) * random.unit()
}

/// A random law, with its kind.
fn law(random: &mut Random) -> (&'static str, Law, Vec<f64>) {
    let kind = (6.0 * random.unit()) as usize;
    let (drop, scale) = (between(random, 0.05, 0.95), random.log(0.15, 1.5));
    let (rise, wave) = (between(random, 0.0, 0.03), random.log(1.0, 6.0));
    let formula = |text: String| Law::Expression(Expression::new(&text, 1.0).unwrap());
    match kind {
        0 => ("stribeck", Law::Stribeck, vec![1.0 - drop, rise, 1.0 / scale]),
        1 => ("exponential", Law::Exponential, vec![1.0 - drop, scale, rise]),
        2 => ("lorentzian", Law::Lorentzian, vec![1.0 - drop, scale, rise]),
        3 => ("formula", formula(format!("1 - {drop}*tanh(u/{scale}) + {rise}*sin({wave}*u)")), vec![]),
        4 => ("formula", formula(format!("1 - {drop}*atan(u/{scale}) + {rise}*u^2")), vec![]),
        _ => {
            let (spacing, noise) = (random.log(0.05, 0.4), random.log(1e-5, 1e-2));
            let mut data = vec![(0.0, 1.0)];
            while data[data.len() - 1].0 < 12.0 {
                let u = data[data.len() - 1].0 + spacing * between(random, 0.5, 1.5);
                let scatter = noise * between(random, -1.0, 1.0);
                data.push((u, 1.0 - drop + drop * (-u / scale).exp() + rise * u + scatter));
            }
            ("table", Law::Table(Table::new("random", &data, 1.0).unwrap()), vec![])
        }
    }
}

/// A damping of the column: half of them anywhere, the others near the critical one.
fn damping(column: &Column, random: &mut Random) -> f64 {
    let range = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
    let anywhere = between(random, 0.0, 1.2) * range.hi.max(0.01) / column.epsilon;
    let distance = between(random, -1.0, 1.0) * random.log(1e-6, 1.0);
    match critical_damping(column, TOLERANCE) {
        Ok(found) if found.c > 0.0 && random.unit() < 0.5 => (found.c * (1.0 + distance)).max(0.0),
        _ => anywhere,
    }
}

fn verdict(flow: &Flow) -> Verdict {
    match flow.fate {
        Fate::Sticks(_) => Verdict::Present,
        Fate::SpiralsInward | Fate::CrossesForever => Verdict::Absent,
        Fate::TooCloseToCall => Verdict::Undecided,
        Fate::Failed(_) => Verdict::Failed,
    }
}

fn decided(verdict: Verdict) -> bool {
    matches!(verdict, Verdict::Present | Verdict::Absent)
}

/// Counts by kind of law, and the violations.
#[derive(Default)]
struct Tally {
    /// By kind and verdicts of the map and of the direct engine.
    verdicts: BTreeMap<(&'static str, &'static str, &'static str), u64>,
    /// Verdicts of theorems that the direct engine confirmed.
    confirmed: u64,
    problems: Vec<String>,
    /// Points without a verdict.
    open: Vec<String>,
}

impl Tally {
    fn of(number: u64) -> Self {
        let mut random = Random(0x5eed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let (kind, law, parameters) = law(&mut random);
        // From belts so slow that orbits creep to those so fast that they cross. Tables end at 12.
        let belt_speed = random.log(0.03, if kind == "table" { 4.0 } else { 300.0 });
        let epsilon = random.log(0.1, 1.0);
        let column = law.column(&law.point(epsilon, &parameters, belt_speed, 0.0).unwrap());
        let c = damping(&column, &mut random);
        let map = decide(std::slice::from_ref(&column), &[c], Engine::Auto, TOLERANCE)[0];
        // As an audit does: smaller steps before a contradiction is reported.
        let oscillator = Oscillator::in_column(&column, c);
        let mut answer = witness::flow(&oscillator, TOLERANCE);
        if decided(map) && decided(verdict(&answer)) && verdict(&answer) != map {
            answer = witness::flow(&oscillator, 1e-3 * TOLERANCE);
        }
        let direct = verdict(&answer);
        let mut tally = Self::default();
        tally.verdicts.insert((kind, map.name(), direct.name()), 1);
        if decided(map) && decided(direct) && map != direct {
            tally.problems.push(format!("{kind} {number}: {map:?} {answer:?}"));
        }
        if !decided(map) {
            tally.open.push(format!("{kind} {number}: {map:?} {answer:?}, V {belt_speed}, eps {epsilon}, c {c}, {law:?} {parameters:?}"));
        }
        for test in TESTS.iter().filter(|test| test.guarantee == Guarantee::FiniteEpsilon) {
            let claimed = match (test.claim)(&column).decide(c) {
                Decision::Present => Verdict::Present,
                Decision::Absent => Verdict::Absent,
                Decision::Undecided => continue,
            };
            if decided(direct) && claimed != direct {
                tally.problems.push(format!("{} of {kind} {number}: {claimed:?} {answer:?}", test.name));
            }
            tally.confirmed += u64::from(claimed == direct);
        }
        tally
    }

    fn plus(mut self, other: Self) -> Self {
        for (verdicts, count) in other.verdicts {
            *self.verdicts.entry(verdicts).or_insert(0) += count;
        }
        self.confirmed += other.confirmed;
        self.problems.extend(other.problems);
        self.open.extend(other.open);
        self
    }
}

fn survey(count: u64) {
    let tally = (0..count).into_par_iter().map(Tally::of).reduce(Tally::default, Tally::plus);
    for ((kind, map, direct), count) in &tally.verdicts {
        println!("{kind}: {count} points {map} by the map, {direct} by the direct engine");
    }
    println!("{} verdicts of theorems confirmed", tally.confirmed);
    assert!(tally.problems.is_empty(), "{}", tally.problems.join("\n"));
    let open = tally.open.len();
    assert!(
        1000 * open as u64 <= count,
        "{open} of {count} points have no verdict:\n{}",
        tally.open.join("\n")
    );
    assert!(2 * tally.confirmed > count, "{} verdicts of theorems", tally.confirmed);
}

/// The margin of one turn by the engine of maps, at several tolerances, and by the direct engine.
fn margins_are_within_their_error(count: u64) {
    let compare = |number: u64| {
        let mut random = Random(0xface ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let (kind, law, parameters) = law(&mut random);
        let (belt_speed, epsilon) = (random.log(0.05, 4.0), random.log(0.02, 1.0));
        let column = law.column(&law.point(epsilon, &parameters, belt_speed, 0.0).unwrap());
        let c = damping(&column, &mut random);
        let direct = witness::flow(&Oscillator::in_column(&column, c), 1e-12);
        let mut compared = [0; 3];
        for (compared, tolerance) in compared.iter_mut().zip([1e-6, 1e-9, 1e-11]) {
            let [Turn::Complete { margin, error, .. }] = turns_of(&column, &[c], tolerance)[..] else {
                continue;
            };
            let off = (margin - direct.margin).abs();
            assert!(
                !(off > error + direct.margin_error),
                "{kind} {number} at {tolerance:e}: {margin} +- {error:e}, {direct:?}"
            );
            *compared += u64::from(off.is_finite() && error <= tolerance);
        }
        compared
    };
    // The last is an orbit that turns just before a corner, where the end of a span lies beyond its turning
    // point.
    let all = (0..count).into_par_iter().chain([3082]).map(compare);
    let compared = all.reduce(|| [0; 3], |a, b| std::array::from_fn(|i| a[i] + b[i]));
    assert!(compared.iter().all(|compared| 10 * compared > 6 * count), "{compared:?}");
}

#[test]
fn margins_of_random_laws_are_those_of_the_direct_engine() {
    margins_are_within_their_error(600);
}

#[test]
#[ignore = "minutes: cargo test --test mathematics law_survey:: -- --ignored --nocapture"]
fn ten_thousand_margins_of_random_laws_are_those_of_the_direct_engine() {
    margins_are_within_their_error(10_000);
}

#[test]
fn verdicts_of_random_laws_are_those_of_the_direct_engine() {
    survey(600);
}

/// Formulas with steps narrow beside the belt speed, so that the orbit is that of the direct engine, whose
/// error at the tolerance of maps exceeds the margin.
#[test]
fn margins_below_the_error_of_the_direct_engine_have_a_verdict() {
    for number in [770, 1769, 2926, 3417, 3904, 4314] {
        let open = Tally::of(number).open;
        assert!(open.is_empty(), "{open:?}");
    }
}

#[test]
#[ignore = "minutes: cargo test --test mathematics law_survey:: -- --ignored --nocapture"]
fn a_hundred_thousand_verdicts_of_random_laws_are_those_of_the_direct_engine() {
    survey(100_000);
}

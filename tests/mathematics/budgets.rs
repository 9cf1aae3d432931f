//! Every computation at a point has a budget of work: it ends even at the ends of the range of numbers, and
//! either its answer is right or it reports that there is none.

use slipmap::certify::Guarantee;
use slipmap::column::{Method, Verdict};
use slipmap::flow::Fate;
use slipmap::friction::{Law, Table};
use slipmap::point::Point;
use slipmap::probe::{Answer, Probe};
use slipmap::witness;
use slipmap_map::clock::thread_time;

use crate::sample::{Random, Sampling, formula};

const TOLERANCE: f64 = 1e-9;

/// Laws of every kind, the parameters of formulas fixed.
fn laws() -> Vec<Law> {
    let data: Vec<(f64, f64)> = (0..40)
        .map(|i| {
            let u = 0.25 * f64::from(i);
            (u, 0.6 + 0.4 * (-u).exp() + 0.01 * u)
        })
        .collect();
    vec![
        Law::Stribeck,
        Law::Stribeck,
        Law::Exponential,
        Law::Lorentzian,
        formula("0.7 + 0.3*exp(-2*u) + 0.02*u^2"),
        formula("1 - 0.1*sin(1000*u)"),
        formula("1 - eps*u/(1 + u)"),
        Law::Table(Table::new("data", &data, 1.0).unwrap()),
    ]
}

/// Any legal point: V from 1e-8 to 1e8, c from 0 to 1e8, eps from 1e-300 to 1e3, rates of the law to 1e8.
fn point(random: &mut Random, law: &Law) -> Point {
    let scale = |random: &mut Random, limit: f64| match random.unit() {
        u if u < 0.1 => 0.0,
        u if u < 0.4 => 10.0 * random.unit(),
        _ => random.log(1e-8, limit),
    };
    let epsilon = match random.unit() {
        u if u < 0.4 => random.log(1e-3, 10.0),
        u if u < 0.7 => random.log(1e-12, 1e3),
        _ => random.log(1e-300, 1e3),
    };
    let parameters: Vec<f64> = law
        .parameters()
        .iter()
        .map(|parameter| match parameter.max {
            // A fraction, such as alpha.
            max if max <= 1.0 => random.unit() * max,
            _ => scale(random, 1e8).max(parameter.min),
        })
        .collect();
    let belt_speed = if random.unit() < 0.5 { random.log(1e-8, 1e8) } else { random.log(0.05, 20.0) };
    let belt_speed = match law {
        // A table is undefined beyond its data.
        Law::Table(table) => belt_speed.min(0.5 * table.fastest()),
        _ => belt_speed,
    };
    law.point(epsilon, &parameters, belt_speed, scale(random, 1e8)).unwrap()
}

/// Runs all computations; returns the problem, if any, and the processor time.
fn ask(law: &Law, point: &Point) -> (Option<String>, f64) {
    let start = thread_time();
    let answer = Answer::of(law, point, TOLERANCE, Method::all());
    let direct = witness::flow(&answer.oscillator, TOLERANCE);
    let probe = Probe::new(&answer, &direct);
    let seconds = (thread_time() - start).as_secs_f64();
    std::hint::black_box(probe);
    let truth = match direct.fate {
        Fate::Sticks(_) => Some(Verdict::Present),
        Fate::SpiralsInward | Fate::CrossesForever => Some(Verdict::Absent),
        Fate::TooCloseToCall | Fate::Failed(_) => None,
    };
    let close = direct.margin.abs() <= direct.margin_error + TOLERANCE;
    let promising = answer.methods.iter().filter(|answer| match answer.method.guarantee() {
        Guarantee::FiniteEpsilon | Guarantee::Numerical | Guarantee::Validated => true,
        Guarantee::Asymptotic | Guarantee::None => false,
    });
    let decided: Vec<(&str, Verdict)> = promising
        .filter(|answer| matches!(answer.verdict, Verdict::Present | Verdict::Absent))
        .map(|answer| (answer.method.name(), answer.verdict))
        .chain(truth.filter(|_| !close).map(|truth| ("direct", truth)))
        .collect();
    let wrong = decided.iter().any(|(_, verdict)| *verdict != decided[0].1);
    let coordinates = law.coordinates(point);
    (wrong.then(|| format!("{} {coordinates:?}: {decided:?}, direct {direct:?}", law.definition())), seconds)
}

/// Asks about points, whose answers must agree; returns them with their times, the longest first.
fn ask_many(points: usize, seed: u64) -> Vec<(f64, String)> {
    let (laws, mut random) = (laws(), Random(seed));
    let (mut wrong, mut times) = (Vec::new(), Vec::new());
    for i in 0..points {
        let law = &laws[i % laws.len()];
        let point = point(&mut random, law);
        let (problem, seconds) = ask(law, &point);
        let name = format!("{} {:?}", law.definition(), law.coordinates(&point));
        // Printed at once, so that a long run that is cut short has reported its problems.
        if seconds > LONGEST || problem.is_some() {
            println!("{i}: {seconds:.2} s, {problem:?}: {name}");
        }
        wrong.extend(problem);
        times.push((seconds, name));
    }
    times.sort_by(|a, b| b.0.total_cmp(&a.0));
    for (seconds, point) in times.iter().take(10) {
        println!("{seconds:.2} s: {point}");
    }
    assert!(wrong.is_empty(), "{} wrong:\n{}", wrong.len(), wrong.join("\n"));
    times
}

#[test]
fn extreme_points_have_answers_that_agree() {
    ask_many(16, 0x5eed);
}

/// Processor seconds that a point may take in a release build.
const LONGEST: f64 = 2.0;

/// The acceptance test of the budgets: ten thousand points, or the number and the seed that SLIPMAP_POINTS
/// gives.
#[test]
#[ignore = "an hour: SLIPMAP_POINTS='1000 7' cargo test --release --test mathematics budgets:: -- --ignored --nocapture"]
fn ten_thousand_extreme_points_end_within_two_seconds_each() {
    let asked = std::env::var("SLIPMAP_POINTS").unwrap_or("10000 44238".into());
    let (points, seed) = asked.split_once(' ').expect("a number and a seed");
    let times = ask_many(points.parse().unwrap(), seed.parse().unwrap());
    println!("{} points, {:.0} s", times.len(), times.iter().map(|(seconds, _)| seconds).sum::<f64>());
    let slow = times.iter().filter(|(seconds, _)| *seconds > LONGEST).count();
    assert_eq!(slow, 0, "points that took longer than two seconds");
}

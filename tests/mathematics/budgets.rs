//! Every piece of knowledge has a fixed quota of work: it ends even at the ends of the range of numbers, and
//! either its answer is right or it reports that there is none. The same question has the same answer in any order.

use slipmap::certify::Guarantee;
use slipmap::column::backbone::Backbone;
use slipmap::column::slip_cycle::CyclesUnknown;
use slipmap::column::{self, Behaviour, Method, NoCriticalDamping, Verdict, critical_damping};
use slipmap::filippov::Oscillator;
use slipmap::flow::{Failure, Fate};
use slipmap::friction::{Expression, Law, Table};
use slipmap::orbits::{Piece, Work, flow};
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

/// A formula that is hard on every engine: fast waves, many waves, poles, narrow steps, terms that cancel, corners, growth, and
/// all of these of one another.
fn hostile(random: &mut Random) -> String {
    let f = term(random, 2);
    let share = random.log(1e-4, 2.0);
    format!("1 - {share:.6}*(({f}) - ({}))", f.replace('u', "(0)"))
}

fn term(random: &mut Random, depth: u32) -> String {
    let mut number = |least: f64, most: f64| format!("{:.6e}", random.log(least, most));
    let [fast, size, place, width, rate] =
        [(10.0, 1e6), (1e-3, 10.0), (1e-3, 1e3), (1e-7, 1.0), (0.1, 50.0)].map(|(a, b)| number(a, b));
    let inner =
        if depth > 0 && random.unit() < 0.5 { format!("({})", term(random, depth - 1)) } else { "u".into() };
    match (random.unit() * 10.0) as u32 {
        0 => format!("sin({fast}*{inner})"),
        1 => {
            let wave = |i: u32| format!("sin({}*u)/{}", 11 + (37 * i) % 1000, i + 1);
            (0..2 + (60.0 * random.unit()) as u32).map(wave).collect::<Vec<_>>().join(" + ")
        }
        2 => format!("{inner}/(1 - {inner}/{place})"),
        3 => format!("tanh(({inner} - {place})/{width})"),
        4 => format!("(1e9 + {size}*{inner}) - 1e9"),
        5 => format!("abs(sin({rate}*{inner}))"),
        6 => format!("exp({rate}*{inner})"),
        7 => format!("{inner}^{}", 2 + (8.0 * random.unit()) as u32),
        8 => format!("sin(1/({inner} + {width}))"),
        _ => format!("exp(-({inner}/{width})^2) + {size}*{inner}"),
    }
}

/// The hostile law of a number, with a point.
fn hostile_point(number: u64) -> Option<(Law, Point)> {
    let mut random = Random(0xbad + number);
    let law = Law::Expression(Expression::new(&hostile(&mut random), 1.0).ok()?);
    let point = law.point(1.0, &[], random.log(1e-2, 100.0), random.log(1e-3, 3.0)).ok()?;
    Some((law, point))
}

/// What a quota ends says so, and no piece takes much more than its own.
fn keeps_to_quotas(law: &Law, point: &Point) {
    let (column, oscillator) = (law.column(point), Oscillator::new(law, point));
    let (found, cost) = (flow(&oscillator, TOLERANCE), column.curve.cost());
    // The evaluations of the law itself count so many times, those of its polynomials once.
    let most = |piece: Piece| 3 * piece.quota();
    assert!(found.rhs <= most(Piece::Fate), "{} {found:?} {cost}", law.definition());
    match critical_damping(&column, TOLERANCE) {
        Ok(found) => assert!(found.rhs <= most(Piece::Critical), "{} {found:?}", law.definition()),
        Err(why) => assert!(matches!(why, NoCriticalDamping::Quota | NoCriticalDamping::NotFollowed)),
    }
}

#[test]
fn hostile_formulas_keep_to_their_quotas() {
    let points: Vec<(Law, Point)> = (0..24).filter_map(hostile_point).collect();
    assert!(points.len() > 12, "{}", points.len());
    for (law, point) in &points {
        keeps_to_quotas(law, point);
    }
    // What comes before an orbit has the same quota: the search for a later start of its quarters.
    let steps = "1 - 0.001*(tanh((tanh((sin(1e4*u) - 1.36)/2e-4) - 0.92)/1e-6) - tanh((tanh(-1.36/2e-4) - 0.92)/1e-6))";
    let law = formula(steps);
    let column = law.column(&law.point(1.0, &[], 1.0, 0.0).unwrap());
    let work = Work::of(Piece::CoarseBackbones, &column.curve);
    let found = Backbone::coarsest(&column.curve, 1.0, 1e-5, &work);
    assert!(found.is_err() && work.spent() < 6 * Piece::CoarseBackbones.quota(), "{}", work.spent());
    // Too many waves: the quota is the reason.
    let law = formula("1 - 0.001*sin(30000*u)");
    let point = law.point(1.0, &[], 1.0, 0.1).unwrap();
    let oscillator = Oscillator::new(&law, &point);
    let found = flow(&oscillator, TOLERANCE);
    assert_eq!(found.fate, Fate::Failed(Failure::Quota));
    assert_eq!(critical_damping(&law.column(&point), TOLERANCE), Err(NoCriticalDamping::Quota));
    let slip = column::slip_cycles(&oscillator, &found, TOLERANCE);
    assert_eq!(slip, Err(CyclesUnknown::Orbit(Failure::Quota)));
}

#[test]
#[ignore = "minutes: cargo test --release --test mathematics hostile -- --ignored --nocapture"]
fn five_hundred_hostile_formulas_end_within_two_seconds_each() {
    let mut times = Vec::new();
    for number in 0.. {
        let Some((law, point)) = hostile_point(number) else { continue };
        let methods = Method::all().filter(|method| *method != Method::validated());
        let start = thread_time();
        let (answer, direct) = Answer::of_both_engines(&law, &point, TOLERANCE, methods);
        let answered = thread_time() - start;
        // The count is a proof.
        answer.slip_count();
        let start = thread_time();
        let probe = Probe::new(&answer, &direct);
        let seconds = (answered + thread_time() - start).as_secs_f64();
        std::hint::black_box(probe);
        if seconds > LONGEST {
            println!("{number}: {seconds:.2} s: {} {point:?}", law.definition());
        }
        times.push(seconds);
        if times.len() == 500 {
            break;
        }
    }
    times.sort_by(f64::total_cmp);
    println!("median {:.3} s, 95 % {:.3} s, largest {:.3} s", times[250], times[475], times[499]);
    assert!(times[499] <= LONGEST, "{}", times[499]);
}

/// Two threads that ask one column the same questions, each in an order of its own, have the answers of columns that were
/// asked nothing else.
#[test]
fn answers_depend_neither_on_order_nor_on_thread() {
    let mut random = Random(71);
    let wavy = "1 - 1.4012*u*exp(-u/1.51636) + 0.19596*sin(7.376*u) - 0.06*u";
    let laws = [
        (formula("1 - 0.001*sin(30000*u)"), 1.0, 0.3),
        (formula(wavy), 1.6726, 0.4),
        (formula("0.4 + 0.6*exp(-u/0.3) + 0.05*sin(9*u)"), 0.8, 1.2),
        (formula("1 - 0.2*u*exp(-u/30)"), 20.0, 0.2),
        (Law::Exponential.with_drop(), 0.5, 0.8),
    ];
    for (law, belt_speed, most) in &laws {
        let parameters: &[f64] = if matches!(law, Law::Expression(_)) { &[] } else { &[0.5, 0.2, 0.0, 0.1] };
        let at = |c: f64| law.point(1.0, parameters, *belt_speed, c).unwrap();
        let oscillators: Vec<Oscillator> =
            (0..5).map(|i| Oscillator::new(law, &at(most * f64::from(i) / 4.0))).collect();
        let flows: Vec<_> = oscillators.iter().map(|it| flow(it, TOLERANCE)).collect();
        // Each question as text, since answers may contain NaN.
        let answer = |column: &Behaviour, question: usize| {
            let (number, piece) = (question / 4, question % 4);
            let (oscillator, flow) = (&oscillators[number], &flows[number]);
            match piece {
                0 => format!("{:?}", column.regime_of(oscillator, flow)),
                1 => format!("{:?}", column.slip_cycles(oscillator, flow, TOLERANCE)),
                2 => format!("{:?}", column.long_run(oscillator, flow, TOLERANCE)),
                _ => format!("{:?}", column.backbone()),
            }
        };
        let fresh = || law.column(&at(0.0)).curve;
        let questions = 4 * oscillators.len();
        let expected: Vec<String> =
            (0..questions).map(|question| answer(&Behaviour::new(&fresh(), *belt_speed), question)).collect();
        let curve = fresh();
        let column = Behaviour::new(&curve, *belt_speed);
        let mut orders: [Vec<usize>; 2] = std::array::from_fn(|_| (0..questions).collect());
        for order in &mut orders {
            for i in (1..questions).rev() {
                order.swap(i, (random.unit() * (i + 1) as f64) as usize);
            }
        }
        std::thread::scope(|scope| {
            let (answer, column, expected) = (&answer, &column, &expected);
            for order in &orders {
                scope.spawn(move || {
                    for &question in order {
                        assert_eq!(answer(column, question), expected[question], "{question}");
                    }
                });
            }
        });
    }
}

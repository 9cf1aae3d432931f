//! The two engines, which share nothing but the friction law, asked the same question at random points, and
//! the theorems asked with them.

mod sample;

use rayon::prelude::*;
use sample::{Random, Sample};
use slipmap::certify::{Decision, Guarantee, TESTS};
use slipmap::simulate::{Fate, Flow, direct, flow};

const TOLERANCE: f64 = 1e-9;

/// What an engine says, as far as two engines must agree on it.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Answer {
    Sticks { crossings: u32 },
    Inward,
    Crosses,
}

/// `None` where the engine does not commit itself.
fn answer(flow: &Flow) -> Option<Answer> {
    match flow.fate {
        Fate::Sticks(landing) => Some(Answer::Sticks { crossings: landing.crossings }),
        Fate::SpiralsInward => Some(Answer::Inward),
        Fate::CrossesForever => Some(Answer::Crosses),
        Fate::TooCloseToCall | Fate::Failed(_) => None,
    }
}

/// Counts over a sample of points.
#[derive(Debug, Default)]
struct Counts {
    sticks: u64,
    from_above: u64,
    inward: u64,
    crosses: u64,
    too_close: u64,
    failed: u64,
    /// Margins further apart than the sum of their error estimates.
    margins_apart: u64,
    most_rhs: u64,
}

/// Asks both engines and all tests at one point; panics on a contradiction.
fn check(sample: Sample) -> Counts {
    let oscillator = sample.oscillator();
    let (direct, map) = (direct::flow(&oscillator, TOLERANCE), flow(&oscillator, TOLERANCE));
    if let (Some(a), Some(b)) = (answer(&direct), answer(&map)) {
        assert_eq!(a, b, "{sample:?}\n{direct:?}\n{map:?}");
    }
    let mut counts = Counts { most_rhs: direct.rhs.max(map.rhs), ..Counts::default() };
    for flow in [&direct, &map] {
        assert!(flow.margin_error >= 0.0 || flow.margin.is_nan(), "{sample:?} {flow:?}");
    }
    let apart = (direct.margin - map.margin).abs() / (direct.margin_error + map.margin_error);
    if apart > 1.0 {
        // The estimates are estimates: rarely, on the stiffest orbits (k above 20), too small by a few times.
        assert!(apart < 10.0, "{apart} {sample:?}\n{direct:?}\n{map:?}");
        counts.margins_apart = 1;
    }
    for test in TESTS.iter().filter(|test| test.guarantee == Guarantee::FiniteEpsilon) {
        let decision = (test.claim)(&sample.column()).decide(sample.damping);
        for flow in [&direct, &map] {
            match (decision, answer(flow)) {
                (Decision::Present, Some(found)) => {
                    assert_eq!(found, Answer::Sticks { crossings: 0 }, "{} {sample:?}", test.name);
                }
                (Decision::Absent, Some(found)) => {
                    assert_eq!(found, Answer::Inward, "{} {sample:?}", test.name);
                }
                (Decision::Undecided, _) | (_, None) => {}
            }
        }
    }
    match map.fate {
        Fate::Sticks(landing) if landing.crossings > 0 => counts.from_above = 1,
        Fate::Sticks(_) => counts.sticks = 1,
        Fate::SpiralsInward => counts.inward = 1,
        Fate::CrossesForever => counts.crosses = 1,
        Fate::TooCloseToCall => counts.too_close = 1,
        Fate::Failed(_) => counts.failed = 1,
    }
    counts
}

fn survey(points: u64) -> Counts {
    (0..points)
        .into_par_iter()
        .map(|i| {
            let mut random = Random(i.wrapping_mul(0xd134_2543_de82_ef95));
            check(if i % 2 == 0 { random.anywhere() } else { random.near_boundary() })
        })
        .reduce(Counts::default, |a, b| Counts {
            sticks: a.sticks + b.sticks,
            from_above: a.from_above + b.from_above,
            inward: a.inward + b.inward,
            crosses: a.crosses + b.crosses,
            too_close: a.too_close + b.too_close,
            failed: a.failed + b.failed,
            margins_apart: a.margins_apart + b.margins_apart,
            most_rhs: a.most_rhs.max(b.most_rhs),
        })
}

fn assert_survey(points: u64) {
    let counts = survey(points);
    println!("{points} points: {counts:?}");
    assert_eq!(counts.failed, 0, "{counts:?}");
    assert!(counts.margins_apart * 1000 < points, "{counts:?}");
    // Every fate but the rarest is met often, so that the agreement means something.
    assert!(
        counts.sticks > points / 10 && counts.inward > points / 10 && counts.from_above > 0,
        "{counts:?}"
    );
    // Ties: half of the points are drawn within 1e-12 to 1 of the boundary, by decades.
    assert!(counts.too_close < points / 5, "{counts:?}");
}

#[test]
fn engines_and_theorems_agree_at_100_000_points() {
    assert_survey(100_000);
}

#[test]
#[ignore = "a minute or more; cargo test --release --test agreement -- --ignored --nocapture"]
fn engines_and_theorems_agree_at_1_000_000_points() {
    assert_survey(1_000_000);
}

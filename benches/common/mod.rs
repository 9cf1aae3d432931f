//! The cells of the benchmarks, and the right answers.

#![allow(dead_code)] // every bench compiles this module and uses its own part
#![allow(clippy::expect_used)] // a bench whose points are wrong stops

use slipmap::friction::{Column, Law};
use slipmap::point::{Point, ScaledGroups};
use slipmap_numbers::random::Random;

/// The tolerance of maps.
pub const TOLERANCE: f64 = 1e-9;

/// Random points of the box for which speeds are stated: eps = 0.05, alpha in [0, 1], beta in [0, 0.5], gamma
/// in [0, 4], c in [0, 1], V in [0.2, 1.5].
pub fn points(count: usize) -> Vec<Point> {
    let mut random = Random(20_260_414);
    (0..count)
        .map(|_| {
            let law = [random.unit(), 0.5 * random.unit(), 4.0 * random.unit()];
            let (damping, belt_speed) = (random.unit(), 0.2 + 1.3 * random.unit());
            Law::Stribeck.point(0.05, &law, belt_speed, damping).expect("a legal point")
        })
        .collect()
}

/// Their friction curves.
pub fn columns(points: &[Point]) -> Vec<Column> {
    points.iter().map(|point| Law::Stribeck.column(point)).collect()
}

/// Their scaled groups.
pub fn groups(points: &[Point]) -> Vec<ScaledGroups> {
    points
        .iter()
        .map(|point| {
            let &[alpha, beta, gamma] = point.law().as_slice() else {
                unreachable!("Stribeck's law has three")
            };
            ScaledGroups {
                a: point.epsilon() * gamma * (1.0 - alpha),
                k: point.epsilon() * gamma * point.belt_speed(),
                b: point.epsilon() * beta * point.belt_speed(),
                c: point.epsilon() * point.damping(),
            }
        })
        .collect()
}

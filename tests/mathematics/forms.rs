//! The Lienard form, the scalar form and the half maps of the slip flow (theory, "Two forms of the slip
//! flow"), compared with the direct engine's traces, which do not use them.

use crate::runge_kutta::follow;
use crate::sample::{Random, Sample, Sampling};
use slipmap::filippov::Side;
use slipmap::witness::{Phase, Start, trace};
use std::f64::consts::TAU;

/// The result of the classical Runge-Kutta method and a bound on its error: the difference of two step sizes, of which the
/// finer has a sixteenth.
fn integrate(
    range: (f64, f64),
    start: [f64; 2],
    slope: impl Fn(f64, [f64; 2]) -> [f64; 2],
) -> ([f64; 2], f64) {
    let [coarse, fine] = [20, 40].map(|steps| follow(&slope, range, start, steps));
    (fine, (fine[0] - coarse[0]).abs().max((fine[1] - coarse[1]).abs()))
}

/// A point anywhere; fast belts, undamped, of strong weakening, are crossed.
fn some_crossing(random: &mut Random, crossed: bool) -> Sample {
    let sample = random.anywhere();
    match crossed {
        true => Sample { belt_speed: random.log(5.0, 50.0), beta: 0.0, damping: 0.0, alpha: 0.0, ..sample },
        false => sample,
    }
}

/// Every slip phase of the direct engine's traces, between neighbouring samples, against
/// v' = w, w' = -v + D w with v = x2, w = x2', and below the belt line against the scalar form
/// dr/dth = D r sin^2 th / (1 + D sin th cos th), dt/dth = 1 / (1 + D sin th cos th).
#[test]
fn traces_obey_the_lienard_form_and_the_scalar_form() {
    let mut random = Random(6);
    let (mut lienard, mut above, mut polar) = (0, 0, 0);
    for n in 0..300 {
        let sample = some_crossing(&mut random, n % 3 == 0);
        let oscillator = sample.oscillator();
        let belt_speed = sample.belt_speed;
        let traced = trace(&oscillator, Start::ExitPoint, 1e-12, 20.0);
        for pair in traced.samples.windows(2) {
            let Phase::Slip(side) = pair[0].phase else { continue };
            let divergence = |v: f64| oscillator.divergence((belt_speed - v).abs());
            let [from, to] =
                [0, 1].map(|i| [pair[i].x2, oscillator.acceleration(side, pair[i].x1, pair[i].x2)]);
            // The engine's local errors add up to 1e-12 V a turn; w is a sum of terms of the size of x1, 1
            // and D v, each rounded.
            let rounding = 16.0 * f64::EPSILON * (1.0 + pair[0].x1.abs() + pair[0].x2.abs() + belt_speed);
            let times = (pair[0].t, pair[1].t);
            let slope = |_: f64, [v, w]: [f64; 2]| [w, -v + divergence(v) * w];
            let ([v, w], error) = integrate(times, from, slope);
            let bound = error + 1e-12 * belt_speed + rounding;
            assert!(
                (v - to[0]).abs() <= bound && (w - to[1]).abs() <= bound * (1.0 + divergence(v).abs()),
                "{sample:?} {pair:?}: {v} {w} instead of {to:?}, {bound:e}"
            );
            lienard += 1;
            above += usize::from(side == Side::Above);

            let turns = [from, to].map(|[v, w]| ((-w).atan2(v) + TAU) % TAU);
            let steep = divergence(v).abs().max(divergence(from[0]).abs()) >= 1.8;
            if side == Side::Above || steep || turns[1] <= turns[0] {
                continue;
            }
            let radii = [from, to].map(|[v, w]| v.hypot(w));
            let slope = |th: f64, [r, _]: [f64; 2]| {
                let (sin, cos) = th.sin_cos();
                let d = divergence(r * cos);
                let turning = 1.0 + d * sin * cos;
                [d * r * sin * sin / turning, 1.0 / turning]
            };
            let ([r, t], error) = integrate((turns[0], turns[1]), [radii[0], pair[0].t], slope);
            // An error of the angle is one of w over r, and dr/dth <= 10 r and dt/dth <= 10 here.
            let small = 10.0 * (error + bound * (1.0 + 1.0 / radii[0])) * (1.0 + radii[0]);
            assert!(
                (r - radii[1]).abs() <= small && (t - pair[1].t).abs() <= small,
                "{sample:?} {pair:?}: r {r} instead of {}, t {t}; {small:e}",
                radii[1]
            );
            polar += 1;
        }
    }
    println!("{lienard} pairs of samples, {above} above the belt line, {polar} in polar form");
    assert!(lienard > 10_000 && above > 300 && polar > 5_000, "{lienard} {above} {polar}");
}

/// Back at the belt line from below with wL the mass lands at x1 = 1 - eps c V - wL; if wL >= 2 it goes on
/// above with W = wL - 2, and comes back to x1 = 1 - eps c V - (W + 2) with W < 0.
#[test]
fn landings_follow_the_half_maps() {
    let mut random = Random(7);
    let mut seen = [0; 2];
    for n in 0..400 {
        let sample = some_crossing(&mut random, n % 2 == 0);
        let oscillator = sample.oscillator();
        let (belt_speed, exit) = (sample.belt_speed, oscillator.exit_x1());
        let traced = trace(&oscillator, Start::ExitPoint, 1e-12, 20.0);
        for pair in traced.samples.windows(2) {
            let [before, contact] = [pair[0], pair[1]];
            let Phase::Slip(side) = before.phase else { continue };
            if contact.x2 != belt_speed {
                continue;
            }
            let start = [before.x2, oscillator.acceleration(side, before.x1, before.x2)];
            let slope =
                |_: f64, [v, w]: [f64; 2]| [w, -v + oscillator.divergence((belt_speed - v).abs()) * w];
            let ([v, w], error) = integrate((before.t, contact.t), start, slope);
            let rounding = 16.0 * f64::EPSILON * (1.0 + before.x1.abs() + belt_speed);
            let bound = (error + 1e-12 * belt_speed + rounding) * (1.0 + oscillator.divergence(0.0).abs());
            // w on the lower side is W + 2 on the upper.
            let lower = match side {
                Side::Below => w,
                Side::Above => w + 2.0,
            };
            assert!((v - belt_speed).abs() <= bound, "{sample:?} {pair:?}: {v}");
            // The time of the contact is off by the error of x2 over w.
            let along = bound * (1.0 + belt_speed / w.abs());
            assert!((contact.x1 - (exit - lower)).abs() <= along, "{sample:?} {pair:?}: w = {lower}");
            let sticks = match side {
                Side::Below => lower < 2.0,
                Side::Above => w > -2.0 && w < 0.0,
            };
            let near_end = (lower - 2.0).abs() <= along || lower.abs() <= along;
            assert!(near_end || sticks == (contact.phase == Phase::Stick), "{sample:?} {pair:?}: w = {w}");
            seen[usize::from(side == Side::Above)] += 1;
        }
    }
    println!("{} contacts from below, {} from above", seen[0], seen[1]);
    assert!(seen.iter().all(|&n| n > 50), "{seen:?}");
}

/// With only the part of D that is odd about the equilibrium, the orbit from (V, 0) closes: the reference of
/// the test `symmetric`.
#[test]
fn the_odd_part_of_the_divergence_closes_the_orbit() {
    let mut random = Random(8);
    for _ in 0..100 {
        let oscillator = random.anywhere().oscillator();
        let belt_speed = oscillator.belt_speed;
        let odd =
            |v: f64| 0.5 * (oscillator.divergence(belt_speed - v) - oscillator.divergence(belt_speed + v));
        if (0..=20).any(|i| odd(0.05 * f64::from(i) * belt_speed).abs() >= 1.0) {
            continue;
        }
        let slope = |th: f64, [r]: [f64; 1]| {
            let (sin, cos) = th.sin_cos();
            let d = odd(r * cos);
            [d * r * sin * sin / (1.0 + d * sin * cos)]
        };
        let [coarse, fine] = [4000, 8000].map(|n| follow(&slope, (0.0, TAU), [belt_speed], n)[0]);
        // 8000 steps of a few roundings each.
        let bound = (coarse - fine).abs() + 8000.0 * f64::EPSILON * belt_speed;
        assert!((fine - belt_speed).abs() <= bound, "{oscillator:?}: {fine} {bound:e}");
    }
}

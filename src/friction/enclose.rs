//! What a law given by its formula owes the tests: sign-certain bounds over intervals, and averages.
//!
//! Bounds come from branch and bound with enclosures of the function and two derivatives: a piece is done
//! where it is certainly monotone or cannot contain a new extreme, and is halved otherwise. They exceed the
//! true range by a few units in the last place of the values met (more only where the budget of pieces runs
//! out), and never fall short of it.

use super::Range;
use super::interval::Interval;

/// A function and its first two derivatives on an interval.
pub(super) type Enclosure = [Interval; 3];

/// Pieces examined before the rest is bounded as it stands.
const BUDGET: u32 = 4000;

/// A piece of the domain with what is known at its ends.
struct Piece {
    ends: [f64; 2],
    slopes: [Interval; 2],
}

/// Bounds of f over [`lo`, `hi`] from `enclose`, which returns f, f' and f'' on any part of it.
pub(super) fn range(enclose: impl Fn(Interval) -> Enclosure, lo: f64, hi: f64) -> Range {
    let [at_lo, at_hi] = [lo, hi].map(|x| enclose(Interval::thin(x)));
    let mut found = at_lo[0].hull(at_hi[0]);
    // Bounds of the extremes from inside: values that are attained.
    let (mut least, mut greatest) = (at_lo[0].hi.min(at_hi[0].hi), at_lo[0].lo.max(at_hi[0].lo));
    let mut noise = (at_lo[0].hi - at_lo[0].lo).max(at_hi[0].hi - at_hi[0].lo);
    let mut pieces = vec![Piece { ends: [lo, hi], slopes: [at_lo[1], at_hi[1]] }];
    let mut left = BUDGET;
    while let Some(Piece { ends: [a, b], slopes }) = pieces.pop() {
        if !(found.lo > f64::NEG_INFINITY || found.hi < f64::INFINITY) {
            break;
        }
        if !(b > a) {
            continue;
        }
        let [value, slope, curvature] = enclose(Interval::new(a, b));
        let bends = !curvature.contains_zero();
        let turns_inside = slopes[0].lo.min(slopes[1].lo) < 0.0 && slopes[0].hi.max(slopes[1].hi) > 0.0;
        let monotone = slope.lo >= 0.0 || slope.hi <= 0.0;
        if monotone || (bends && !turns_inside) {
            // Monotone: the extremes are at the ends, which are in `found` already.
            continue;
        }
        let middle = 0.5 * (a + b);
        let at_middle = enclose(Interval::thin(middle));
        // The value as it stands, or by the mean value theorem.
        let swing = slope * Interval::new(a - middle, b - middle);
        let by_slope = at_middle[0] + swing;
        let value = Interval::new(value.lo.max(by_slope.lo), value.hi.min(by_slope.hi));
        if at_middle[0].is_bounded() {
            found = found.hull(at_middle[0]);
            least = least.min(at_middle[0].hi);
            greatest = greatest.max(at_middle[0].lo);
            noise = noise.max(at_middle[0].hi - at_middle[0].lo);
        }
        let enough = noise.max(8.0 * f64::EPSILON * least.abs().max(greatest.abs()));
        left = left.saturating_sub(1);
        let settled = value.lo >= least - enough && value.hi <= greatest + enough;
        if settled || left == 0 || middle <= a || middle >= b {
            found = found.hull(value);
            continue;
        }
        pieces.push(Piece { ends: [a, middle], slopes: [slopes[0], at_middle[1]] });
        pieces.push(Piece { ends: [middle, b], slopes: [at_middle[1], slopes[1]] });
    }
    found.into()
}

/// Bounds over 0 <= |v| <= `reach` of the even part in v of f(`belt_speed` - v).
pub(super) fn even_range(enclose: impl Fn(Interval) -> Enclosure, belt_speed: f64, reach: f64) -> Range {
    let half = Interval::thin(0.5);
    let belt = Interval::thin(belt_speed);
    let even = |v: Interval| {
        let below = belt - v;
        let near = enclose(Interval::new(below.lo.max(0.0), below.hi.max(0.0)));
        let far = enclose(belt + v);
        // By symmetry the slope vanishes at v = 0 exactly.
        let slope = if v == Interval::thin(0.0) { Interval::thin(0.0) } else { half * (far[1] - near[1]) };
        [half * (near[0] + far[0]), slope, half * (near[2] + far[2])]
    };
    range(even, 0.0, reach)
}

/// Nodes of the coarsest and of the finest rule over half a turn.
const NODES: [u32; 2] = [16, 1 << 14];

/// The mean over a turn, t in [0, 2 pi], of a function of cos t that is given at t, half the turn being the
/// mirror image of the other. The trapezoidal rule, doubled until it stands still: for smooth functions it
/// converges faster than any power.
pub(super) fn mean_over_turn(f: impl Fn(f64) -> f64) -> f64 {
    let at = |i: u32, n: u32| f(std::f64::consts::PI * f64::from(i) / f64::from(n));
    let mut n = NODES[0];
    let ends = 0.5 * (at(0, 1) + at(1, 1));
    let sum = |from: u32, step: usize, n: u32| {
        (from..n).step_by(step).map(|i| at(i, n)).fold((0.0, 0.0), |(s, size), x| (s + x, size + x.abs()))
    };
    let (mut total, mut size) = sum(1, 1, n);
    total += ends;
    size += ends.abs();
    loop {
        let before = total / f64::from(n);
        n *= 2;
        let (odd, odd_size) = sum(1, 2, n);
        total += odd;
        size += odd_size;
        let now = total / f64::from(n);
        // NaN ends the loop as well.
        if !((now - before).abs() > 2.0 * f64::EPSILON * size / f64::from(n)) || n >= NODES[1] {
            return now;
        }
    }
}

/// The weakening rate averaged over the grazing circle with weight sin^2 t / pi, see
/// [`super::Curve::mean_weakening`].
pub(super) fn mean_weakening(weakening: impl Fn(f64) -> f64, belt_speed: f64) -> f64 {
    2.0 * mean_over_turn(|t| {
        let (half, sin) = ((0.5 * t).sin(), t.sin());
        weakening(2.0 * belt_speed * half * half) * sin * sin
    })
}

#[cfg(test)]
mod tests {
    use super::super::jet::{Jet, Real};
    use super::*;

    fn enclosure(f: impl Fn(Jet<Interval, 3>) -> Jet<Interval, 3>) -> impl Fn(Interval) -> Enclosure {
        move |x| {
            let jet = f(Jet::variable(x, 1.0));
            [0, 1, 2].map(|order| jet.derivative(order))
        }
    }

    fn check(range: Range, lo: f64, hi: f64) {
        let slack = 64.0 * f64::EPSILON * lo.abs().max(hi.abs()).max(1.0);
        assert!(range.lo <= lo && lo - range.lo <= slack, "{range:?} {lo}");
        assert!(range.hi >= hi && range.hi - hi <= slack, "{range:?} {hi}");
    }

    #[test]
    fn bounds_are_certain_and_tight() {
        // Interior extremes of both kinds, and one at an end.
        let f = |x: Jet<Interval, 3>| x.sin_cos().0 * x;
        let turning: f64 = 2.028_757_838_110_434; // tan x = -x
        check(range(enclosure(f), 0.0, 3.0), 0.0, turning * turning.sin());
        // x^3 - x on [-1, 1].
        let f = |x: Jet<Interval, 3>| x.powi(3) - x;
        let turning = 1.0 / 3f64.sqrt();
        check(range(enclosure(f), -1.0, 1.0), -2.0 / 3.0 * turning, 2.0 / 3.0 * turning);
        // An extreme at which the curvature vanishes as well.
        let f = |x: Jet<Interval, 3>| x.powi(4);
        let found = range(enclosure(f), -1.0, 1.0);
        assert!(found.lo <= 0.0 && found.lo >= -1e-12 && (found.hi - 1.0).abs() < 1e-14, "{found:?}");
    }

    #[test]
    fn a_pole_has_no_bounds() {
        let f = |x: Jet<Interval, 3>| Jet::constant(1.0) / (x - Jet::constant(0.3));
        let found = range(enclosure(f), 0.0, 1.0);
        assert_eq!(found, Range { lo: f64::NEG_INFINITY, hi: f64::INFINITY });
    }

    #[test]
    fn the_even_part_of_a_parabola_is_flat_and_of_a_quartic_is_not() {
        // f = u^2: the even part of (V - v)^2 is V^2 + v^2.
        let f = |x: Jet<Interval, 3>| x * x;
        check(even_range(enclosure(f), 2.0, 2.0), 4.0, 8.0);
        // f = u^2 (u - 2)^2 at V = 1: even part (1 - v^2)^2.
        let f = |x: Jet<Interval, 3>| x * x * (x - Jet::constant(2.0)) * (x - Jet::constant(2.0));
        let found = even_range(enclosure(f), 1.0, 1.0);
        assert!(found.lo <= 0.0 && found.lo > -1e-14 && (found.hi - 1.0).abs() < 1e-14, "{found:?}");
    }

    #[test]
    fn averages_of_powers() {
        // u^2 = V^2 (1 - cos t)^2 weighted with sin^2 / pi: V^2 (1 + 1/4).
        let mean = mean_weakening(|u| u * u, 3.0);
        assert!((mean - 9.0 * 1.25).abs() <= 32.0 * f64::EPSILON * 9.0, "{mean}");
    }
}

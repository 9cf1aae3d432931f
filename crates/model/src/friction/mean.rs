//! Averages of a law over the grazing circle.

use std::sync::OnceLock;

/// Number of intervals of the coarsest rule over half a turn, and the largest number of its doublings.
const INTERVALS: u32 = 16;
const DOUBLINGS: usize = 10;

/// A node of a rule: (1 - cos t) / 2 and sin^2 t.
type Node = [f64; 2];

/// The nodes between t = 0 and pi of the coarsest rule, or those that a doubling adds.
fn nodes(doublings: usize) -> &'static [Node] {
    static RULES: [OnceLock<Vec<Node>>; DOUBLINGS + 1] = [const { OnceLock::new() }; DOUBLINGS + 1];
    RULES[doublings].get_or_init(|| {
        let intervals = INTERVALS << doublings;
        let step = if doublings == 0 { 1 } else { 2 };
        let node = |i: u32| {
            let t = std::f64::consts::PI * f64::from(i) / f64::from(intervals);
            let (half, sin) = ((0.5 * t).sin(), t.sin());
            [half * half, sin * sin]
        };
        (1..intervals).step_by(step).map(node).collect()
    })
}

/// The weakening rate averaged over the grazing circle with weight sin^2 t / pi, see
/// [`super::Curve::mean_weakening`]. By the trapezoidal rule, doubled until the result no longer changes: for
/// smooth functions it converges faster than any power. At both ends the weight is zero.
pub(super) fn mean_weakening(weakening: impl Fn(f64) -> f64, belt_speed: f64) -> f64 {
    doubled(weakening, belt_speed, 1, 2.0 * f64::EPSILON)
}

/// As [`mean_weakening`] for a formula that is not compiled: at no fewer angles than see a feature that is not
/// [narrow](super::Weakening::narrow), and with an allowance for the rounding of the formula.
pub(super) fn of_formula(weakening: impl Fn(f64) -> f64, belt_speed: f64) -> f64 {
    doubled(weakening, belt_speed, 3, 64.0 * f64::EPSILON)
}

/// As [`mean_weakening`], to a hundredth: at no fewer angles than see a feature that is not
/// [narrow](super::Weakening::narrow).
pub(super) fn rough(weakening: impl Fn(f64) -> f64, belt_speed: f64) -> f64 {
    doubled(weakening, belt_speed, 3, 1e-2)
}

/// The rule after `least` doublings or more, of which the last changes the result by at most `enough` times
/// the size of the terms.
fn doubled(weakening: impl Fn(f64) -> f64, belt_speed: f64, least: usize, enough: f64) -> f64 {
    let (mut total, mut size, mut before) = (0.0, 0.0, f64::NAN);
    for doublings in 0..=DOUBLINGS {
        for [share, weight] in nodes(doublings) {
            let term = weakening(2.0 * belt_speed * share) * weight;
            total += term;
            size += term.abs();
        }
        let intervals = f64::from(INTERVALS << doublings);
        let now = total / intervals;
        let changes = (now - before).abs() > enough * size / intervals;
        // NaN ends the loop as well.
        if doublings >= least && !changes {
            return 2.0 * now;
        }
        before = now;
    }
    2.0 * before
}

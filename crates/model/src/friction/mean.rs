//! Averages of a law over the grazing circle v = V cos t, with weight sin^2 t / pi, see
//! [`super::Curve::mean_weakening`].

use std::f64::consts::{FRAC_2_PI, FRAC_PI_4, PI};
use std::sync::{LazyLock, OnceLock};

use slipmap_numbers::gauss::Rule;

/// Number of intervals of the coarsest trapezoidal rule over half a turn, and the largest number of its doublings.
const INTERVALS: u32 = 16;
const DOUBLINGS: usize = 10;

/// A node of a rule: (1 - cos t) / 2 and sin^2 t.
type Node = [f64; 2];

/// Gauss's rule for the angles between two slip speeds.
static GAUSS: LazyLock<Rule<16>> = LazyLock::new(Rule::gauss);
/// The rule for slip speeds between two ends, of a mean to about a hundredth.
static ROUGH: LazyLock<Rule<4>> = LazyLock::new(Rule::gauss);
/// Largest angle between the ends of a rule. On a piece w is a polynomial of degree 11 or less in the slip speed, so it has
/// frequencies up to 13 with the weight, which the rule integrates to all digits over this angle.
const WIDEST: f64 = FRAC_PI_4;
/// Largest number of bisections of an interval of angles: the integral over what is left is below rounding.
pub(super) const HALVINGS: u32 = 64;

/// The angle t of a slip speed u = V (1 - cos t).
pub(super) fn angle(u: f64, belt_speed: f64) -> f64 {
    2.0 * (0.5 * u / belt_speed).sqrt().min(1.0).asin()
}

/// The part of the angles from `from` to `to` in the mean of a function of the slip speed.
fn part(of: impl Fn(f64) -> f64, [from, to]: [f64; 2], belt_speed: f64) -> f64 {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let terms = GAUSS.nodes.iter().zip(&GAUSS.weights).map(|(x, weight)| {
        // sin^2 t and the slip speed from sin^2 (t / 2).
        let sin_half = (0.5 * (middle + half * x)).sin();
        let square = sin_half * sin_half;
        weight * of(2.0 * belt_speed * square) * 4.0 * square * (1.0 - square)
    });
    FRAC_2_PI * half * terms.sum::<f64>()
}

/// The mean of a function that is smooth between neighbouring `ends` of slip speeds, from 0 to the first that is not below
/// 2 V; `of` is asked with the number of the end before, too.
pub(super) fn between(ends: &[f64], of: impl Fn(usize, f64) -> f64, belt_speed: f64) -> f64 {
    let mut from = 0.0;
    let mut total = 0.0;
    for (i, end) in ends[1..].iter().enumerate() {
        let to = angle(*end, belt_speed);
        let parts = ((to - from) / WIDEST).ceil().max(1.0);
        let place = |k: u8| from + (to - from) * f64::from(k) / parts;
        let of_part = |k| part(|u| of(i, u), [place(k), place(k + 1)], belt_speed);
        total += (0..parts as u8).map(of_part).sum::<f64>();
        from = to;
    }
    total
}

/// As [`between`], to about a hundredth: the weight of du is 2 sqrt(u (2 V - u)) / (pi V^2).
pub(super) fn rough(ends: &[f64], of: impl Fn(usize, f64) -> f64, belt_speed: f64) -> f64 {
    let mut total = 0.0;
    for (i, ends) in ends.windows(2).enumerate() {
        let [from, to] = [ends[0], ends[1].min(2.0 * belt_speed)];
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        for (x, weight) in ROUGH.nodes.iter().zip(&ROUGH.weights) {
            let u = middle + half * x;
            let share = u / belt_speed;
            total += half * weight * of(i, u) * (share * (2.0 - share)).sqrt();
        }
    }
    FRAC_2_PI * total / belt_speed
}

/// The mean over slip speeds up to `end` of a function >= 0 that rises up to about `peak` and falls from there: intervals of
/// angles are halved until that changes the mean by no more than rounding does. At rest the function may be any power >= 0 of the slip speed.
///
/// Without `halvings` of intervals it is a rough mean.
pub(super) fn about_peak(
    of: impl Fn(f64) -> f64,
    peak: f64,
    end: f64,
    belt_speed: f64,
    halvings: u32,
) -> f64 {
    let of = |ends: [f64; 2]| part(&of, ends, belt_speed);
    let [peak, end] = [peak, end].map(|u| angle(u, belt_speed));
    let mut rough = of([0.0, peak]) + of([peak, end]);
    if halvings == 0 {
        return rough;
    }
    let mut waiting = vec![([0.0, peak], halvings), ([peak, end], halvings)];
    let mut total = 0.0;
    while let Some((ends, left)) = waiting.pop() {
        let middle = 0.5 * (ends[0] + ends[1]);
        let halves = [[ends[0], middle], [middle, ends[1]]];
        let [whole, fine] = [of(ends), halves.into_iter().map(of).sum()];
        rough = rough.max(total + fine);
        if left > 0 && (fine - whole).abs() > 8.0 * f64::EPSILON * rough {
            waiting.extend(halves.map(|half| (half, left - 1)));
        } else {
            total += fine;
        }
    }
    total
}

/// The nodes between t = 0 and pi of the coarsest rule, or those that a doubling adds.
fn nodes(doublings: usize) -> &'static [Node] {
    static RULES: [OnceLock<Vec<Node>>; DOUBLINGS + 1] = [const { OnceLock::new() }; DOUBLINGS + 1];
    RULES[doublings].get_or_init(|| {
        let intervals = INTERVALS << doublings;
        let step = if doublings == 0 { 1 } else { 2 };
        let node = |i: u32| {
            let t = PI * f64::from(i) / f64::from(intervals);
            let (half, sin) = ((0.5 * t).sin(), t.sin());
            [half * half, sin * sin]
        };
        (1..intervals).step_by(step).map(node).collect()
    })
}

/// The mean of a weakening rate that is an entire function of the slip speed and no narrower than some of the first
/// intervals: by the trapezoidal rule, which converges faster than any power, doubled until the result no longer changes.
pub(super) fn of_wide(weakening: impl Fn(f64) -> f64, belt_speed: f64) -> f64 {
    doubled(weakening, belt_speed, 1, 2.0 * f64::EPSILON)
}

/// As [`of_wide`] for a formula that is not compiled: at no fewer angles than see a feature that is not
/// [narrow](super::Weakening::narrow), and with an allowance for the rounding of the formula.
pub(super) fn of_formula(weakening: impl Fn(f64) -> f64, belt_speed: f64) -> f64 {
    doubled(weakening, belt_speed, 3, 64.0 * f64::EPSILON)
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

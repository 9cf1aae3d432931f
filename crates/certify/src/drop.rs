//! What a drop of friction as slip begins adds to the closed-form tests.
//!
//! Friction at rest is 1, friction in slip begins at 1 - j. In the notation of [`super`] the orbit from the
//! exit point starts at s = -V with p = j, not 0; arriving with `wL` it sticks iff `wL` < 2 - j. Proofs of
//! presence compare with an orbit that starts from p = 0, and hold as they stand. Proofs of absence do not: the
//! orbit must lose what the drop gives it. Let r0 = hypot(V, j).
//!
//! Both statements are proved in the theory, Theorem 5.
//!
//! **Constant divergence.** For D = -d, 0 <= d < 2, J = j/V and omega = sqrt(1 - d^2/4) the orbit returns to the belt line
//! iff
//!
//! ```text
//! F(d) = ln(1 - d J + J^2) + (d / omega) (atan((J - d/2) / omega) + atan((d/2) / omega) - 2 pi) > 0,
//! ```
//!
//! and at d >= 2 it does not. F has one zero, the *sustained damping* d*(J), and d* = 0 for J = 0. So, by the comparison
//! lemma, the orbit returns where D >= -d > -d* at all slip speeds up to V + R, R its amplitude; and it does not where D <= -d <=
//! -d*, not with equality throughout, at all slip speeds up to V + r0.
//!
//! **Even part of the divergence.** Let w(V - v) = O(v) + E(v) as in [`super::symmetric`], E - eps c <= -e < 0 and
//! |O| <= o on 0 < |v| <= V, and
//!
//! ```text
//! A(s) = sqrt(r0^2 - s^2) + o (V - s),    G(s) = exp(integral of t / A(t)^2 over [s, V]),    K = integral of G over [0, V].
//! ```
//!
//! The orbit does not return if 2 e K >= j; nor if 4 e K > j, and D <= 0 at slip speeds from 2 V to V + r0.
//!
//! G is concave, as A^4 G'' / G = s^2 - A^2 + 2 s A A' and -A' >= s/A: the trapezoidal rule is a lower bound of K. Its
//! nodes are r0 sin of angles that lie closer towards V; on each interval o (V - t) is replaced by its value at the left end,
//! and the integral of t / A^2 is then elementary.

use slipmap_model::friction::{Column, Range};

/// Relative width of a sustained damping, far above its rounding error.
const ROUNDING: f64 = 1e-12;
/// Largest J at which F is evaluated.
const FAR: f64 = 1e100;
/// Number of bisections for d* < 2: to its last digit, also where it is small.
const HALVINGS: u32 = 1100;
/// Number of intervals of the trapezoidal rule.
const NODES: u32 = 64;

/// Bounds of the damping d* that the drop of friction alone sustains. Both are 0 without a drop.
pub(crate) fn sustained(drop: f64, belt_speed: f64) -> Range {
    let ratio = drop / belt_speed;
    if drop == 0.0 || ratio.is_nan() {
        return Range { lo: 0.0, hi: if drop == 0.0 { 0.0 } else { 2.0 } };
    }
    let near = sustained_by(ratio.min(FAR));
    let hi = if ratio <= FAR { (near * (1.0 + ROUNDING) + f64::MIN_POSITIVE).min(2.0) } else { 2.0 };
    Range { lo: near * (1.0 - ROUNDING), hi }
}

/// d*(J), as computed.
fn sustained_by(ratio: f64) -> f64 {
    let excess = |d: f64| {
        let omega = ((1.0 - 0.5 * d) * (1.0 + 0.5 * d)).sqrt();
        let angle = ((ratio - 0.5 * d) / omega).atan() + (0.5 * d / omega).atan() - std::f64::consts::TAU;
        (ratio * (ratio - d)).ln_1p() + d / omega * angle
    };
    let (mut low, mut high) = (0.0, 2.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        if !(low < middle && middle < high) {
            break;
        }
        *(if excess(middle) > 0.0 { &mut low } else { &mut high }) = middle;
    }
    low
}

/// The largest slip speed of an orbit from the exit point whose distance from the equilibrium falls, V + r0.
pub(crate) fn fastest(column: &Column) -> f64 {
    let belt_speed = column.belt_speed;
    (belt_speed + belt_speed.hypot(column.curve.drop())) * (1.0 + 4.0 * f64::EPSILON)
}

/// eps c above which the orbit does not return, by the even part of the weakening rate, at most `even`.
pub(crate) fn even_absence(column: &Column, even: f64) -> f64 {
    let Column { curve, belt_speed, .. } = column;
    let of_whole = curve.weakening_range(0.0, 2.0 * belt_speed);
    let odd = 0.5 * (of_whole.hi - of_whole.lo);
    let least = least_gain(curve.drop(), *belt_speed, odd.max(0.0));
    let needed = |times: f64| even + curve.drop() / (times * least) * (1.0 + ROUNDING);
    let beyond = curve.weakening_range(2.0 * belt_speed, fastest(column)).hi;
    // Written so that a NaN claims nothing.
    let (once, twice) = (needed(2.0), needed(4.0).max(beyond));
    match (once.is_nan(), twice.is_nan() || beyond.is_nan()) {
        (true, _) => f64::INFINITY,
        (false, true) => once,
        (false, false) => once.min(twice),
    }
}

/// A lower bound of K.
fn least_gain(drop: f64, belt_speed: f64, odd: f64) -> f64 {
    let radius = belt_speed.hypot(drop);
    let last = belt_speed.atan2(drop);
    // s, and sqrt(r0^2 - s^2).
    let node = |i: u32| match i {
        NODES => [belt_speed, drop],
        _ => {
            let rest = 1.0 - f64::from(i) / f64::from(NODES);
            let (sin, cos) = (last * (1.0 - rest * rest)).sin_cos();
            [radius * sin, radius * cos]
        }
    };
    let (mut exponent, mut sum) = (0.0_f64, 0.0);
    for i in (0..NODES).rev() {
        let ([from, x], [to, y]) = (node(i), node(i + 1));
        let lift = odd * (belt_speed - from);
        let right = exponent.exp();
        exponent += ((x + lift) / (y + lift)).ln() + lift * ((x + lift).recip() - (y + lift).recip());
        sum += 0.5 * (to - from) * (right + exponent.exp());
    }
    sum * (1.0 - ROUNDING)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// V/j at which a damping ratio is sustained, by arithmetic of 150 bits (theory, "Breakaway").
    const KNOWN: [[f64; 2]; 7] = [
        [0.001, 8.893_273_134_421_56],
        [0.01, 2.739_240_416_787_74],
        [0.02, 1.883_279_914_472_74],
        [0.05, 1.098_092_624_115_87],
        [0.1, 0.680_217_603_892_278],
        [0.2, 0.366_973_926_704_089],
        [0.5, 0.082_063_104_590_103_7],
    ];

    #[test]
    fn the_sustained_damping_is_the_closed_form() {
        for [zeta, ratio] in KNOWN {
            let Range { lo, hi } = sustained(0.5, 0.5 * ratio);
            let slack = 4.0 * ROUNDING;
            assert!(
                (lo / (2.0 * zeta) - 1.0).abs() < slack && (hi / (2.0 * zeta) - 1.0).abs() < slack,
                "{zeta} {lo}"
            );
        }
        // Small drops: d* -> J^2 / (2 pi), from below.
        for j in [1e-150, 1e-20, 1e-9, 1e-3, 0.1, 1.0, 3.0] {
            let (found, limit) = (sustained(j, 1.0), j * j / TAU);
            assert!(
                found.hi <= limit * (1.0 + 2.0 * ROUNDING) + 2.0 * f64::MIN_POSITIVE,
                "{j}: {found:?} {limit}"
            );
            assert!(j > 0.01 || found.lo >= limit * (1.0 - j - 2.0 * ROUNDING), "{j}: {found:?} {limit}");
        }
        assert_eq!(sustained(0.0, 1.0), Range { lo: 0.0, hi: 0.0 });
        let far = sustained(0.5, 1e-200);
        assert!(far.lo > 1.99 && far.hi == 2.0, "{far:?}");
    }

    /// Without an odd part K has a closed form; with one it is compared with the midpoint rule.
    #[test]
    fn the_bound_of_the_gain_is_below_and_near() {
        for (drop, belt_speed) in [(0.5, 1.0), (0.1, 3.0), (0.9, 0.2), (0.01, 10.0)] {
            let squared: f64 = belt_speed * belt_speed + drop * drop;
            let exact = (belt_speed * drop + squared * (belt_speed / drop).atan()) / (2.0 * drop);
            let bound = least_gain(drop, belt_speed, 0.0);
            assert!(bound <= exact && bound > 0.999 * exact, "{drop} {belt_speed}: {bound} {exact}");
            let odd = 0.3;
            let n = 20_000;
            let (mut exponent, mut sum) = (0.0_f64, 0.0);
            // Substituted s = V (1 - x^2), which resolves the end.
            for i in 0..n {
                let x = (f64::from(i) + 0.5) / f64::from(n);
                let s = belt_speed * (1.0 - x * x);
                let a = (squared - s * s).sqrt() + odd * (belt_speed - s);
                let width = 2.0 * belt_speed * x / f64::from(n);
                exponent += 0.5 * width * s / (a * a);
                sum += width * exponent.exp();
                exponent += 0.5 * width * s / (a * a);
            }
            let bound = least_gain(drop, belt_speed, odd);
            assert!(bound <= sum * (1.0 + 1e-6) && bound > 0.95 * sum, "{drop} {belt_speed}: {bound} {sum}");
        }
    }
}

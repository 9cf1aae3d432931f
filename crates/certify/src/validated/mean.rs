//! Means over a part of a box of parameters of a damping clamped to an interval.
//!
//! With an affine function u + sum_i g_i xi_i, xi uniform in [-1, 1]^d, integrating d times gives
//!
//! ```text
//! mean of (u + sum g_i xi_i)_+  =  sum over s in {-1, 1}^d of (prod s_i) (u + sum s_i g_i)_+^(d+1) / ((d+1)! 2^d prod g_i),
//! ```
//!
//! where x_+ = max(x, 0) and d >= 1. Small g_i would cancel all digits, so they are left out. Since x_+ is
//! convex and its second integral has at most the density 1 / (2 g) of the widest term, leaving out terms of
//! variance sigma^2 lowers the mean, by at most sigma^2 / (4 g) (Jensen). The second-order term of a function
//! is bounded over the whole part, except for functions that are not clamped there, for which the mean of
//! that term is used.

use super::expansion::Expansion;
use slipmap_numbers::interval::Interval;

/// Terms smaller than this fraction of the largest are left out.
const SMALL: f64 = 1.0 / 64.0;

/// The slopes of an affine function sorted by size, without the small ones.
struct Slopes {
    kept: Vec<f64>,
    /// Sum of squares of the omitted slopes, rounded up.
    rest_squares: f64,
    /// Sum of all slopes, rounded up.
    sum: f64,
}

impl Slopes {
    fn of<const N: usize>(sizes: [f64; N]) -> Self {
        let largest = sizes.into_iter().fold(0.0, f64::max);
        let (kept, small): (Vec<f64>, Vec<f64>) =
            sizes.into_iter().filter(|&g| g > 0.0).partition(|&g| g >= SMALL * largest);
        Self {
            rest_squares: small.iter().fold(Interval::ZERO, |sum, &g| sum + Interval::of(g).square()).hi,
            sum: sizes.into_iter().fold(Interval::ZERO, |sum, g| sum + Interval::of(g)).hi,
            kept,
        }
    }

    /// Sum over the corners of the signs times the power d + 1 of the positive part, divided by (d + 1)! 2^d prod g.
    fn corners(&self, u: f64) -> Interval {
        let power = self.kept.len() + 1;
        let mut sum = Interval::ZERO;
        for corner in 0..1_usize << self.kept.len() {
            let mut x = Interval::of(u);
            for (i, &g) in self.kept.iter().enumerate() {
                x = if corner >> i & 1 == 1 { x - Interval::of(g) } else { x + Interval::of(g) };
            }
            let x = x.at_least_zero();
            let term = (1..power).fold(x, |product, _| (product * x).at_least_zero());
            sum = if corner.count_ones() % 2 == 1 { sum - term } else { sum + term };
        }
        let factorial: f64 = (1..=power).map(|n| n as f64).product();
        let scale = self.kept.iter().fold(Interval::of(factorial), |scale, &g| scale * Interval::of(2.0 * g));
        sum.over(scale)
    }

    /// The mean of the positive part.
    fn positive_part(&self, u: Interval) -> Interval {
        // The result rises with u, and is at least the positive part of the mean. If the function has one
        // sign, the result is the mean or 0.
        let mean = u.at_least_zero();
        if u.lo >= self.sum || !(u.hi > -self.sum) {
            return mean;
        }
        let Some(widest) = self.kept.iter().copied().reduce(f64::max) else { return mean };
        let more = Interval::of(self.rest_squares).over(Interval::of(12.0) * Interval::of(widest));
        let (least, most) = (self.corners(u.lo), self.corners(u.hi) + Interval::of(more.hi));
        // The result is at most the largest value.
        let top = (Interval::of(u.hi) + Interval::of(self.sum)).at_least_zero();
        Interval::new(least.lo.max(mean.lo), most.hi.min(top.hi))
    }
}

/// The mean over the part of min(max(f + e, `lo`), `hi`), where e is any number within `error`; `lo` <= `hi`.
/// f + e is known to lie in `range`.
pub(super) fn mean_cut<const N: usize>(
    f: &Expansion<N>,
    error: Interval,
    range: Interval,
    [lo, hi]: [f64; 2],
) -> Interval {
    let (least, most) = (Interval::of(lo), Interval::of(hi));
    let spread = f.spread();
    let reach = (f.value + Interval::new(-spread.hi, spread.hi) + error).intersection(range);
    if !(reach.lo.is_finite() && reach.hi.is_finite()) {
        return least.hull(most);
    }
    if reach.hi <= lo {
        return least;
    }
    if reach.lo >= hi {
        return most;
    }
    let mean = if reach.lo >= lo && reach.hi <= hi {
        f.value + f.mean_remainder() + error
    } else {
        // The affine part. Uncertainties of the slopes are added to its value.
        let mut u = f.value + (f.remainder() + error);
        let slopes = Slopes::of(f.slope.map(|slope| {
            let middle = 0.5 * (slope.lo + slope.hi);
            let off = (slope - Interval::of(middle)).size();
            u = u + Interval::new(-off, off);
            middle.abs()
        }));
        // min(max(x, lo), hi) = lo + (x - lo)_+ - (x - hi)_+, which rises with x, so that each end of u gives
        // one end of the mean.
        let ends = [u.lo, u.hi].map(|u| {
            let above = |level: Interval| slopes.positive_part(Interval::of(u) - level);
            least + above(least) - above(most)
        });
        ends[0].hull(ends[1])
    };
    let [least, most] = [range.lo, range.hi].map(|x| x.clamp(lo, hi));
    Interval::new(mean.lo.clamp(least, most), mean.hi.clamp(least, most))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The mean of the positive part over a mesh of `n` midpoints per axis.
    fn by_mesh(u: f64, g: &[f64], n: usize) -> f64 {
        let all = n.pow(g.len() as u32);
        let sum: f64 = (0..all)
            .map(|i| {
                let at = |axis: usize| (2 * (i / n.pow(axis as u32) % n) + 1) as f64 / n as f64 - 1.0;
                (u + g.iter().enumerate().map(|(axis, g)| g * at(axis)).sum::<f64>()).max(0.0)
            })
            .sum();
        sum / all as f64
    }

    fn slopes(g: &[f64]) -> Slopes {
        Slopes::of::<5>(std::array::from_fn(|axis| g.get(axis).copied().unwrap_or(0.0)))
    }

    #[test]
    fn means_of_affine_functions() {
        for g in [&[0.5][..], &[0.5, 0.2], &[0.3, 1.0, 0.2], &[0.3, 1.0, 0.02, 0.5]] {
            let slopes = slopes(g);
            for u in [-1.4, -0.7, -0.1, 0.0, 0.3, 0.9] {
                let n = if g.len() < 3 { 1000 } else { 40 };
                // The midpoint rule errs by h^2 g^2 times a density of at most 1 / (2 g).
                let slack = 2.0 * g.iter().map(|g| g * g).sum::<f64>() / (n * n) as f64;
                let found = slopes.positive_part(Interval::of(u));
                let mean = by_mesh(u, g, n);
                assert!(found.lo <= mean + slack && mean - slack <= found.hi, "{g:?} {u}: {found:?} {mean}");
                // Omitted terms widen it, by their variance over four times the largest term.
                assert!(found.hi - found.lo < 2e-4, "{g:?} {u}: {found:?}");
            }
        }
    }

    #[test]
    fn without_slopes_the_value_decides() {
        let none = slopes(&[]);
        assert_eq!(none.positive_part(Interval::of(0.5)), Interval::of(0.5));
        assert_eq!(none.positive_part(Interval::of(-0.5)), Interval::ZERO);
    }
}

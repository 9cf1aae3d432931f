//! Equal angles on the circle with enclosed sines and cosines, and the bound of a trigonometric polynomial by
//! its samples.

use std::sync::OnceLock;

use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::Real as _;

/// Numbers of angles: 2^m and 3 2^m, which the half-angle formulas reach from exact values.
const SIZES: [usize; 14] = [32, 48, 64, 96, 128, 192, 256, 384, 512, 768, 1024, 1536, 2048, 4096];

/// The angles theta_j = 2 pi j / N, j = 0 .. N - 1.
pub(super) struct Circle {
    cosines: Vec<Interval>,
    /// The middles of `cosines`, for arithmetic that bounds its errors separately.
    pub(super) cosine_middles: Vec<f64>,
    /// Bound on the distance of a middle from its cosine.
    pub(super) middle_error: f64,
}

impl Circle {
    /// The smallest circle with at least `least` angles; `None` beyond the largest.
    pub(super) fn with_at_least(least: usize) -> Option<&'static Circle> {
        static TABLES: [OnceLock<Circle>; SIZES.len()] = [const { OnceLock::new() }; SIZES.len()];
        let which = SIZES.iter().position(|&size| size >= least)?;
        Some(TABLES[which].get_or_init(|| Circle::new(SIZES[which])))
    }

    fn new(size: usize) -> Self {
        // cos and sin of 2 pi / size by halving from pi/2 or from 2 pi / 3, where both are known; all halves
        // are in the first quadrant.
        let half = Interval::of(0.5);
        let (mut cos, mut sin, mut reached) = if size.is_multiple_of(3) {
            (-half, Interval::of(3.0).sqrt() * half, 3)
        } else {
            (Interval::ZERO, Interval::ONE, 4)
        };
        let mut steps = vec![(cos, sin)];
        while reached < size {
            cos = ((Interval::ONE + cos) * half).sqrt();
            sin = sin.over(cos + cos);
            reached *= 2;
            steps.push((cos, sin));
        }
        steps.reverse();
        // Now steps[i] is the cosine and sine of 2^i times 2 pi / size. theta_j as a sum of steps by the
        // addition formulas; symmetries give the rest of the circle from the first quadrant.
        let turn_by = |j: usize| {
            let (mut c, mut s) = (Interval::ONE, Interval::ZERO);
            for (i, &(dc, ds)) in steps.iter().enumerate() {
                if j >> i & 1 == 1 {
                    (c, s) = (c * dc - s * ds, s * dc + c * ds);
                }
            }
            (c, s)
        };
        let quarter = size / 4;
        let first: Vec<(Interval, Interval)> = (0..=quarter)
            .map(|j| match j {
                0 => (Interval::ONE, Interval::ZERO),
                _ if j == quarter => (Interval::ZERO, Interval::ONE),
                _ => turn_by(j),
            })
            .collect();
        let cosines: Vec<Interval> = (0..size)
            .map(|j| {
                let (quadrant, rest) = (j / quarter, j % quarter);
                match quadrant {
                    0 => first[rest].0,
                    1 => -first[rest].1,
                    2 => -first[rest].0,
                    _ => first[rest].1,
                }
            })
            .collect();
        let cosine_middles: Vec<f64> = cosines.iter().map(|c| 0.5 * (c.lo + c.hi)).collect();
        let middle_error = cosines
            .iter()
            .zip(&cosine_middles)
            .map(|(&c, &middle)| (c - Interval::of(middle)).size())
            .fold(0.0, f64::max);
        Self { cosines, cosine_middles, middle_error }
    }

    pub(super) fn size(&self) -> usize {
        self.cosines.len()
    }

    /// cos theta_j.
    #[inline]
    pub(super) fn cos(&self, j: usize) -> Interval {
        self.cosines[j % self.size()]
    }

    /// sin theta_j.
    #[inline]
    pub(super) fn sin(&self, j: usize) -> Interval {
        // cos(theta_j - pi/2).
        let size = self.size();
        self.cosines[(j + size - size / 4) % size]
    }
}

/// The cosines and sines of the angles number `from`, `from` + `step`, .. of equal angles whose cosines are
/// given; their number is divisible by 4. A division to find each index would cost more than all the rest of a
/// sum.
#[inline(always)] // into functions whose vector width is selected at run time
pub(super) fn walk(cosines: &[f64], from: usize, step: usize) -> impl Iterator<Item = (f64, f64)> {
    let size = cosines.len();
    let wrapped = move |index: usize| if index < size { index } else { index - size };
    let (from, step) = (from % size, step % size);
    // sin theta = cos(theta - pi/2).
    let (mut at, mut quarter_before) = (from, wrapped(from + size - size / 4));
    std::iter::from_fn(move || {
        let pair = (cosines[at], cosines[quarter_before]);
        (at, quarter_before) = (wrapped(at + step), wrapped(quarter_before + step));
        Some(pair)
    })
}

/// Bound on the ratio of a trigonometric polynomial's largest absolute value to that on samples: 1 /
/// cos(`reach` `degree`), where every angle is within `reach` of a sample. Infinite if the samples are too
/// few.
///
/// **Proof** (M. Riesz). Let T have degree at most d, |T| <= 1 and T(0) = 1. The claim is T(t) >= cos d t for
/// |t| <= pi/d, so that |T| at the sample nearest to a maximum is at least that share of it. Suppose T(t) <
/// cos d t, say with 0 < t < pi/d, and let h(x) = cos d x - T(x) and x_k = k pi/d. Since cos d x_k = (-1)^k
/// and |T| <= 1, h has a zero in each of the 2 d - 2 intervals [x_k, x_k+1], k = 1 .. 2 d - 2 (a zero at a
/// common end is double, if it serves both); a double zero at 0, where both functions are 1 with slope 0; and
/// one more in (t, x_1], since h(t) > 0 while h(x_1) is not positive. That is 2 d + 1 zeros of a
/// trigonometric polynomial of degree d: h = 0, a contradiction.
pub(super) fn riesz_factor(degree: usize, reach: Interval) -> f64 {
    let x = Interval::of(degree as f64) * reach;
    // Taylor's polynomial up to x^6 is a lower bound as long as the cosine is not negative.
    let y = x.square();
    let cos = Interval::ONE - y * Interval::of(0.5) + y.square().over(Interval::of(24.0))
        - (y.square() * y).over(Interval::of(720.0));
    // Below pi/2; beyond it the samples are too few.
    if x.hi < 1.5 { Interval::ONE.over(cos).hi } else { f64::INFINITY }
}

/// Half the distance of neighbouring angles on a circle of `size` angles.
pub(super) fn reach(size: usize) -> Interval {
    Interval::pi().over(Interval::of(size as f64))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_hold_the_cosines() {
        for size in SIZES {
            let circle = Circle::with_at_least(size).unwrap();
            assert_eq!(circle.size(), size);
            // A few dozen roundings on numbers of size one.
            assert!(circle.middle_error < 128.0 * f64::EPSILON, "{size}: {}", circle.middle_error);
            for j in 0..size {
                let (cos, sin) = (circle.cos(j), circle.sin(j));
                let unit = cos.square() + sin.square();
                assert!(unit.lo <= 1.0 && 1.0 <= unit.hi, "{size} {j}: {unit:?}");
            }
            for step in [0, 1, 7, size / 2, size - 1, size + 3] {
                // The library's functions are accurate to an ulp, and so is the angle.
                for (n, (cos, sin)) in
                    (0..=2 * size + 5).zip(walk(&circle.cosine_middles, 3 * size + 5, step))
                {
                    let angle = std::f64::consts::TAU * ((5 + n * step) % size) as f64 / size as f64;
                    assert!((angle.cos() - cos).abs() < circle.middle_error + 4e-15, "{size} {step} {n}");
                    assert!((angle.sin() - sin).abs() < circle.middle_error + 4e-15, "{size} {step} {n}");
                }
            }
            // cos 3x = 4 cos^3 x - 3 cos x pins the table to the angle without any library.
            for j in 0..size {
                let (c, triple) = (circle.cos(j), circle.cos(3 * j));
                let formula = Interval::of(4.0) * c * c.square() - Interval::of(3.0) * c;
                assert!(formula.lo <= triple.hi && triple.lo <= formula.hi, "{size} {j}");
            }
        }
    }

    #[test]
    fn samples_bound_polynomials() {
        // cos(d x + phase), sampled where it is smallest, attains the factor.
        for (degree, size) in [(5, 32), (20, 64), (40, 96), (45, 96)] {
            let factor = riesz_factor(degree, reach(size));
            let half = std::f64::consts::PI / size as f64;
            let seen = (0..size)
                .map(|j| (degree as f64 * (2.0 * j as f64 + 1.0) * half).cos().abs())
                .fold(0.0, f64::max);
            assert!(factor * seen >= 1.0 - 1e-12, "{degree} {size}: {factor} {seen}");
            let exact = 1.0 / (degree as f64 * half).cos();
            assert!(factor >= exact && factor < 1.1 * exact, "{degree} {size}");
        }
        assert_eq!(riesz_factor(16, reach(32)), f64::INFINITY);
    }
}

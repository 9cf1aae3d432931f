//! Functions of the parameters over a part of their box, such as those of the scaled groups, as enclosed second-order
//! expansions.
//!
//! In coordinates xi of [-1, 1]^N that scale the part, a function f of N parameters is
//!
//! ```text
//! f = f0 + sum_i g_i xi_i + 1/2 sum_ij q_ij xi_i xi_j,
//! ```
//!
//! with f0 and g_i taken at the middle of the part and q_ij at some other point of it, which depends on xi
//! (Taylor). All three are enclosed.

use super::tile::{DEGREES, HIGHEST, MODES, Tile, degrees};
use slipmap_numbers::interval::Interval;

/// Number of parameters of the Stribeck oscillator without its damping: epsilon, alpha, beta, gamma, V.
pub(super) const AXES: usize = 5;

/// Ranges of the five parameters.
pub(super) type Ranges = [[f64; 2]; AXES];

/// Axes narrower than this are treated as having no width, as are those narrower than `ROUNDED` of their values: the
/// rounding of a value moves it by more than a tenth of such a width.
const THIN: f64 = 1e-150;
const ROUNDED: f64 = 1e-14;
/// Farthest distance outside a tile, in units of its half-width, at which it is evaluated.
const FARTHEST: f64 = 1.5;

/// A function with its first and second derivatives by the N parameters, enclosed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Expansion<const N: usize> {
    pub(super) value: Interval,
    pub(super) slope: [Interval; N],
    pub(super) bend: [[Interval; N]; N],
}

impl<const N: usize> Expansion<N> {
    pub(super) fn constant(value: Interval) -> Self {
        Self { value, slope: [Interval::ZERO; N], bend: [[Interval::ZERO; N]; N] }
    }

    pub(super) fn parameter(value: Interval, axis: usize) -> Self {
        let mut own = Self::constant(value);
        own.slope[axis] = Interval::ONE;
        own
    }

    pub(super) fn times(&self, other: &Self) -> Self {
        let mut product = Self::constant(self.value * other.value);
        for i in 0..N {
            product.slope[i] = self.slope[i] * other.value + self.value * other.slope[i];
            for j in 0..=i {
                let mixed = self.slope[i] * other.slope[j] + self.slope[j] * other.slope[i];
                let bend = self.bend[i][j] * other.value + self.value * other.bend[i][j] + mixed;
                product.bend[i][j] = bend;
                product.bend[j][i] = bend;
            }
        }
        product
    }

    /// The difference of two functions.
    pub(super) fn minus(&self, other: &Self) -> Self {
        let mut difference = Self::constant(self.value - other.value);
        for i in 0..N {
            difference.slope[i] = self.slope[i] - other.slope[i];
            for j in 0..N {
                difference.bend[i][j] = self.bend[i][j] - other.bend[i][j];
            }
        }
        difference
    }

    /// Its reciprocal; it must be positive.
    pub(super) fn inverse(&self) -> Self {
        let one = Interval::ONE.over(self.value);
        let (two, three) = (one * one, one * one * one);
        let mut inverse = Self::constant(one);
        for i in 0..N {
            inverse.slope[i] = -(two * self.slope[i]);
            for j in 0..N {
                let square = self.slope[i] * self.slope[j] * three;
                inverse.bend[i][j] = square + square - two * self.bend[i][j];
            }
        }
        inverse
    }

    /// Bound of the difference from the value at the middle.
    pub(super) fn spread(&self) -> Interval {
        let first = self.slope.iter().fold(Interval::ZERO, |sum, g| sum + Interval::of(g.size()));
        first + Interval::of(self.remainder().size())
    }

    /// The second-order term, enclosed over the part.
    pub(super) fn remainder(&self) -> Interval {
        let half = Interval::of(0.5);
        let mut sum = Interval::ZERO;
        for i in 0..N {
            // xi_i^2 is in [0, 1], xi_i xi_j in [-1, 1].
            sum = sum + half * self.bend[i][i] * Interval::new(0.0, 1.0);
            for j in 0..i {
                let size = self.bend[i][j].size();
                sum = sum + Interval::new(-size, size);
            }
        }
        sum
    }

    /// The mean of the second-order term over the part.
    pub(super) fn mean_remainder(&self) -> Interval {
        let (sixth, quarter) = (Interval::ONE.over(Interval::of(6.0)), Interval::of(0.25));
        let mut sum = Interval::ZERO;
        for i in 0..N {
            // The mean of xi_i^2 is 1/3; that of xi_i xi_j vanishes, and that of its size is 1/4.
            sum = sum + sixth * self.bend[i][i];
            for j in 0..i {
                let Interval { lo, hi } = self.bend[i][j];
                let width = Interval::of(hi) - Interval::of(lo);
                sum = sum + quarter * (Interval::of(0.5) * Interval::new(-width.hi, width.hi));
            }
        }
        sum
    }
}

/// A part of the parameter box: its middle, its ranges and its half-widths.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    middle: [Interval; AXES],
    whole: [Interval; AXES],
    half: [Interval; AXES],
}

impl Part {
    pub(super) fn new(ranges: &Ranges) -> Self {
        let (half, ends) = (Interval::of(0.5), ranges.map(|ends| ends.map(Interval::of)));
        Self {
            middle: ends.map(|[lo, hi]| if lo == hi { lo } else { half * (lo + hi) }),
            whole: ranges.map(|[lo, hi]| Interval::new(lo, hi)),
            half: ends.map(|[lo, hi]| if lo == hi { Interval::ZERO } else { half * (hi - lo) }),
        }
    }

    /// The range of epsilon.
    pub(super) fn epsilon(&self) -> Interval {
        self.whole[0]
    }

    /// The function `of` of the groups divided by epsilon: a damping c.
    pub(super) fn damping(&self, of: &Function) -> Expansion<AXES> {
        let at = |point: &[Interval; AXES]| {
            let [epsilon, alpha, beta, gamma, speed] =
                std::array::from_fn(|i| Expansion::parameter(point[i], i));
            let drop = Expansion::constant(Interval::ONE).minus(&alpha);
            let rate = epsilon.times(&gamma);
            let groups = [rate.times(&drop), rate.times(&speed), epsilon.times(&beta).times(&speed)];
            of.along(&groups).times(&epsilon.inverse())
        };
        let mut expansion = at(&self.middle);
        let whole = at(&self.whole);
        for i in 0..AXES {
            expansion.slope[i] = expansion.slope[i] * self.half[i];
            for j in 0..AXES {
                expansion.bend[i][j] = whole.bend[i][j] * self.half[i] * self.half[j];
            }
        }
        expansion
    }
}

/// A function of A, k and b.
#[derive(Clone, Copy, Debug)]
pub(super) enum Function<'a> {
    Polynomial(&'a Tile),
    /// A bound of C* by the even part of the divergence.
    Even(Extreme),
}

/// Whether a bound of C* is a lower or an upper one.
#[derive(Clone, Copy, Debug)]
pub(super) enum Extreme {
    /// By the even part A / (1 + k)^2 - 2 b.
    Least,
    /// By the even part (A / 2) (1 + 1 / (1 + 2 k)^2) - 2 b.
    Most,
}

/// Value, slopes and second derivatives by A, k, b, at orders of derivatives [i][j][l] with i + j + l <= 2.
type Derivatives = [[[Interval; 3]; 3]; 3];

impl Function<'_> {
    /// The composition with `groups`, which are functions of the parameters.
    fn along(&self, groups: &[Expansion<AXES>; 3]) -> Expansion<AXES> {
        let d = self.derivatives(groups.map(|group| group.value));
        let first = [d[1][0][0], d[0][1][0], d[0][0][1]];
        let second = [
            [d[2][0][0], d[1][1][0], d[1][0][1]],
            [d[1][1][0], d[0][2][0], d[0][1][1]],
            [d[1][0][1], d[0][1][1], d[0][0][2]],
        ];
        let mut result = Expansion::constant(d[0][0][0]);
        for i in 0..AXES {
            for (group, by_group) in groups.iter().zip(first) {
                result.slope[i] = result.slope[i] + by_group * group.slope[i];
            }
            for j in 0..=i {
                let mut bend = Interval::ZERO;
                for (x, row) in groups.iter().zip(&second) {
                    for (y, by_both) in groups.iter().zip(row) {
                        bend = bend + *by_both * x.slope[i] * y.slope[j];
                    }
                }
                for (group, by_group) in groups.iter().zip(first) {
                    bend = bend + by_group * group.bend[i][j];
                }
                result.bend[i][j] = bend;
                result.bend[j][i] = bend;
            }
        }
        result
    }

    /// Enclosures over ranges of A, k, b.
    fn derivatives(&self, [a, k, b]: [Interval; 3]) -> Derivatives {
        let (base, bend) = match self {
            Function::Polynomial(tile) => return polynomial(tile, [a, k, b]),
            Function::Even(Extreme::Least) => (Interval::ONE + k, 6.0),
            Function::Even(Extreme::Most) => (Interval::ONE + k + k, 12.0),
        };
        let one = Interval::ONE.over(base);
        let (two, three) = (one.square(), one.square() * one);
        let (half, minus_two) = (Interval::of(0.5), Interval::of(-2.0));
        let mut d = [[[Interval::ZERO; 3]; 3]; 3];
        [d[0][0][0], d[1][0][0]] = match self {
            Function::Even(Extreme::Most) => {
                [half * a * (Interval::ONE + two) - (b + b), half * (Interval::ONE + two)]
            }
            _ => [a * two - (b + b), two],
        };
        d[0][1][0] = minus_two * a * three;
        d[1][1][0] = minus_two * three;
        d[0][2][0] = Interval::of(bend) * a * two.square();
        d[0][0][1] = minus_two;
        d
    }
}

/// The polynomial of a tile and its derivatives over ranges of A, k, b, which may extend a little beyond the
/// tile; the whole line where they extend far.
pub(super) fn polynomial(tile: &Tile, at: [Interval; 3]) -> Derivatives {
    let mut along = [[[Interval::ZERO; HIGHEST + 1]; 3]; 3];
    for (axis, (range, degree)) in tile.domain.ranges().into_iter().zip(DEGREES).enumerate() {
        chebyshev(at[axis], range, degree, &mut along[axis]);
    }
    let [along_a, along_k, along_b] = &along;
    // Sums over the modes of k first, then of A, then of b, at all orders of derivatives.
    let mut by_k = [[[Interval::ZERO; 3]; 3]; 3];
    for (mode, &c) in tile.viscous.iter().take(MODES).enumerate().filter(|(_, c)| **c != 0.0) {
        let [i, j, l] = degrees(mode);
        for (order, sum) in by_k[i][l].iter_mut().enumerate() {
            *sum = *sum + Interval::of(c) * along_k[order][j];
        }
    }
    let mut d = [[[Interval::ZERO; 3]; 3]; 3];
    for l in 0..3 {
        for order_a in 0..3 {
            for order_k in 0..3 - order_a {
                let sum =
                    (0..3).fold(Interval::ZERO, |sum, i| sum + by_k[i][l][order_k] * along_a[order_a][i]);
                for order_b in 0..3 - order_a - order_k {
                    let term = sum * along_b[order_b][l];
                    d[order_a][order_k][order_b] = d[order_a][order_k][order_b] + term;
                }
            }
        }
    }
    d
}

/// T_0 to T_`degree` and their first two derivatives by the parameter `at`, T being scaled to [-1, 1] over a
/// range. Plain loops: an iterator over arrays of intervals is compiled apart from its users.
fn chebyshev(at: Interval, [lo, hi]: [f64; 2], degree: usize, values: &mut [[Interval; HIGHEST + 1]; 3]) {
    let whole = Interval::new(-1.0, 1.0);
    let (low, high) = (Interval::of(lo), Interval::of(hi));
    if !(hi - lo > THIN.max(ROUNDED * hi.abs().max(lo.abs()))) && lo <= at.lo && at.hi <= hi {
        // An axis without width: the polynomials are constants.
        values[0][0] = Interval::ONE;
        values[0][1..=degree].fill(if lo == hi { Interval::ZERO } else { whole });
        return;
    }
    let x = (at + at - low - high).over(high - low);
    let scale = Interval::of(2.0).over(high - low);
    if !(x.size() <= FARTHEST) {
        for values in values {
            values[..=degree].fill(Interval::ENTIRE);
        }
        return;
    }
    // Values at the middle, and bounds of the derivatives over all of x: T_n and its derivatives are largest
    // in size at the ends of [-1, 1] and beyond.
    let middle = 0.5 * (x.lo + x.hi);
    let off = Interval::of((x - Interval::of(middle)).size());
    let (here, most) = (recurrence(middle, degree, 2), recurrence(x.size().max(1.0), degree, 3));
    let mut power = Interval::ONE;
    for order in 0..3 {
        for n in 0..=degree {
            let change = (off * Interval::of(most[order + 1][n].hi)).hi;
            let (near, far) = (here[order][n] + Interval::new(-change, change), most[order][n].hi);
            values[order][n] = near.intersection(Interval::new(-far, far)) * power;
        }
        power = power * scale;
    }
}

/// T_0 to T_`degree` and their derivatives up to the order `orders` at a number.
fn recurrence(x: f64, degree: usize, orders: usize) -> [[Interval; HIGHEST + 1]; 4] {
    let twice = Interval::of(x) + Interval::of(x);
    let mut t = [[Interval::ZERO; HIGHEST + 1]; 4];
    t[0][0] = Interval::ONE;
    t[0][1] = Interval::of(x);
    t[1][1] = Interval::ONE;
    for n in 2..=degree {
        // T_n = 2 x T_n-1 - T_n-2, differentiated.
        for order in 0..=orders {
            let inner = match order {
                0 => Interval::ZERO,
                _ => Interval::of(2.0 * order as f64) * t[order - 1][n - 1],
            };
            t[order][n] = inner + twice * t[order][n - 1] - t[order][n - 2];
        }
    }
    t
}

#[cfg(test)]
impl Tile {
    /// An enclosure of C* at groups inside the box.
    pub(super) fn critical(&self, groups: &super::defect::Groups) -> Interval {
        let [[[value, ..], ..], ..] = polynomial(self, [groups.a, groups.k, groups.b]);
        value + Interval::new(-self.radius, self.radius)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::validated::defect::Groups;
    use crate::validated::tile::GroupBox;

    fn holds(interval: Interval, x: f64) -> bool {
        interval.lo <= x && x <= interval.hi
    }

    /// Values at points of a part lie within the expansion about its middle.
    #[test]
    fn expansions_hold_the_values() {
        let tile = Tile::prove(GroupBox { a: [0.06, 0.12], k: [0.08, 0.18], b: [0.0, 0.013] }).unwrap();
        let ranges: Ranges = [[0.045, 0.055], [0.25, 0.35], [0.1, 0.2], [2.2, 2.8], [0.9, 1.1]];
        let part = Part::new(&ranges);
        let c = |value: f64| Interval::of(value);
        let even = [Extreme::Least, Extreme::Most].map(Function::Even);
        for function in [Function::Polynomial(&tile)].into_iter().chain(even) {
            let expansion = part.damping(&function);
            assert!(expansion.remainder().size() < 0.3 * expansion.spread().hi, "{expansion:?}");
            for i in 0..3_usize.pow(5) {
                let xi: [f64; 5] =
                    std::array::from_fn(|axis| (i / 3_usize.pow(axis as u32) % 3) as f64 - 1.0);
                let at: [f64; 5] = std::array::from_fn(|axis| {
                    let [lo, hi] = ranges[axis];
                    0.5 * (lo + hi) + 0.5 * (hi - lo) * xi[axis]
                });
                let [epsilon, alpha, beta, gamma, speed] = at;
                let groups =
                    [epsilon * gamma * (1.0 - alpha), epsilon * gamma * speed, epsilon * beta * speed];
                let value = match function {
                    Function::Polynomial(tile) => {
                        let [a, k, b] = groups.map(Interval::of);
                        let found = tile.critical(&Groups { a, k, b });
                        0.5 * (found.lo + found.hi)
                    }
                    Function::Even(Extreme::Least) => groups[0] / (1.0 + groups[1]).powi(2) - 2.0 * groups[2],
                    Function::Even(Extreme::Most) => {
                        0.5 * groups[0] * (1.0 + (1.0 + 2.0 * groups[1]).powi(-2)) - 2.0 * groups[2]
                    }
                } / epsilon;
                let mut bound = expansion.value;
                for i in 0..AXES {
                    bound = bound + expansion.slope[i] * c(xi[i]);
                    for j in 0..AXES {
                        bound = bound + c(0.5) * expansion.bend[i][j] * c(xi[i] * xi[j]);
                    }
                }
                // The points themselves are rounded: a few units of 5.
                let slack = Interval::new(-1e-14, 1e-14);
                assert!(holds(bound + slack, value), "{function:?} {xi:?}: {bound:?} {value}");
                let rough =
                    expansion.value.lo - expansion.spread().hi..=expansion.value.hi + expansion.spread().hi;
                assert!(rough.contains(&value));
            }
        }
    }

    #[test]
    fn derivatives_of_chebyshev_polynomials() {
        // T_3 = 4 x^3 - 3 x over [1, 3], also outside of it.
        for u in [1.0, 1.7, 2.2, 3.0, 3.4] {
            let x: f64 = u - 2.0;
            let values = |at: Interval| {
                let mut values = [[Interval::ZERO; HIGHEST + 1]; 3];
                chebyshev(at, [1.0, 3.0], HIGHEST, &mut values);
                values
            };
            let found = values(Interval::of(u));
            let exact = [4.0 * x.powi(3) - 3.0 * x, 12.0 * x * x - 3.0, 24.0 * x];
            for (order, exact) in exact.into_iter().enumerate() {
                let Interval { lo, hi } = found[order][3];
                assert!(
                    lo <= exact + 1e-13 && exact - 1e-13 <= hi && hi - lo < 1e-12,
                    "{u} {order}: {lo} {hi}"
                );
            }
            let wide = values(Interval::new(u - 0.1, u + 0.1));
            for order in 0..3 {
                assert!(wide[order][3].lo <= exact[order] && exact[order] <= wide[order][3].hi);
            }
        }
    }
}

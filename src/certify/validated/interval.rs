//! Intervals with outward rounding, in plain f64.
//!
//! Every operation computes in the processor's round-to-nearest mode, whose error is at most half a unit in
//! the last place, and moves both ends outwards by at least a whole one, underflow included. It depends on no
//! compiler flag and no processor state. The crate `inari` was not used because it needs AVX and FMA enabled
//! for the whole build, and GMP.

use std::ops::{Add, Mul, Neg, Sub};

/// A closed interval of real numbers. An operation that fails (division by an interval around zero, overflow)
/// gives the whole line, never an empty or a wrong interval.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Interval {
    pub(super) lo: f64,
    pub(super) hi: f64,
}

#[cfg(test)]
thread_local! {
    /// Switches the outward rounding off, for tests that must then fail.
    pub(super) static BROKEN: std::cell::Cell<bool> = const { std::cell::Cell::new(false) };
}

/// A number above `x` by one to two units in the last place: |x| epsilon is that much, and the smallest
/// normal number exceeds every error of underflow.
#[inline]
fn up(x: f64) -> f64 {
    #[cfg(test)]
    if BROKEN.get() {
        return x;
    }
    x + (x.abs() * f64::EPSILON + f64::MIN_POSITIVE)
}

#[inline]
fn down(x: f64) -> f64 {
    -up(-x)
}

// Unlike the library's, these compile to one instruction; no operand is ever NaN.
#[inline]
fn min(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline]
fn max(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

impl Interval {
    pub(super) const WHOLE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    pub(super) const ZERO: Interval = Interval::of(0.0);
    pub(super) const ONE: Interval = Interval::of(1.0);

    /// One real number.
    #[inline]
    pub(super) const fn of(x: f64) -> Self {
        Self { lo: x, hi: x }
    }

    #[inline]
    pub(super) const fn new(lo: f64, hi: f64) -> Self {
        Self { lo, hi }
    }

    /// All numbers within `radius` of `middle`.
    #[inline]
    pub(super) fn ball(middle: f64, radius: f64) -> Self {
        Self::outwards(middle - radius, middle + radius)
    }

    /// The computed ends, moved outwards; the whole line if one is not finite.
    #[inline]
    fn outwards(lo: f64, hi: f64) -> Self {
        if lo.abs() + hi.abs() < f64::INFINITY { Self { lo: down(lo), hi: up(hi) } } else { Self::WHOLE }
    }

    /// Largest absolute value.
    #[inline]
    pub(super) fn size(self) -> f64 {
        max(self.lo.abs(), self.hi.abs())
    }

    /// The nonnegative part, for quantities that are never negative.
    #[inline]
    pub(super) fn at_least_zero(self) -> Self {
        Self { lo: max(self.lo, 0.0), hi: max(self.hi, 0.0) }
    }

    /// The smallest interval around both.
    #[inline]
    pub(super) fn hull(self, other: Self) -> Self {
        Self { lo: min(self.lo, other.lo), hi: max(self.hi, other.hi) }
    }

    /// The intersection of two enclosures of the same number.
    #[inline]
    pub(super) fn intersection(self, other: Self) -> Self {
        Self { lo: max(self.lo, other.lo), hi: min(self.hi, other.hi) }
    }

    #[inline]
    pub(super) fn square(self) -> Self {
        let least = if self.lo <= 0.0 && self.hi >= 0.0 { 0.0 } else { min(self.lo.abs(), self.hi.abs()) };
        let most = self.size();
        let Self { lo, hi } = Self::outwards(least * least, most * most);
        Self { lo: max(lo, 0.0), hi }
    }

    /// The quotient; the whole line unless the divisor is positive throughout.
    #[inline]
    pub(super) fn over(self, divisor: Self) -> Self {
        if !(divisor.lo > 0.0) || divisor.hi == f64::INFINITY {
            return Self::WHOLE;
        }
        let lo = self.lo / if self.lo < 0.0 { divisor.lo } else { divisor.hi };
        let hi = self.hi / if self.hi < 0.0 { divisor.hi } else { divisor.lo };
        Self::outwards(lo, hi)
    }

    /// The square root of the nonnegative part.
    #[inline]
    pub(super) fn sqrt(self) -> Self {
        let Self { lo, hi } = Self::outwards(max(self.lo, 0.0).sqrt(), max(self.hi, 0.0).sqrt());
        Self { lo: max(lo, 0.0), hi }
    }

    /// Upper bound of e^x for a number x: e^x <= (1 - x/64)^-64 for x < 64.
    pub(super) fn exp_bound(x: f64) -> f64 {
        let mut power = Self::ONE.over(Self::ONE - Self::of(x) * Self::of(1.0 / 64.0));
        for _ in 0..6 {
            power = power.square();
        }
        if x < 64.0 { power.hi } else { f64::INFINITY }
    }

    /// pi.
    pub(super) fn pi() -> Self {
        // The f64 nearest to pi is below it.
        Self { lo: std::f64::consts::PI, hi: std::f64::consts::PI.next_up() }
    }
}

impl Add for Interval {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self::outwards(self.lo + other.lo, self.hi + other.hi)
    }
}

impl Sub for Interval {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self::outwards(self.lo - other.hi, self.hi - other.lo)
    }
}

impl Neg for Interval {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Mul for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        let [a, b, c, d] = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        // Zero times infinity is NaN, which min and max would ignore.
        if (a + b + c + d).is_nan() {
            return Self::WHOLE;
        }
        Self::outwards(min(min(a, b), min(c, d)), max(max(a, b), max(c, d)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Random(u64);

    impl Random {
        /// Magnitude from 2^-60 to 2^60, either sign, sometimes zero.
        fn number(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            let bits = self.0 >> 11;
            if bits.is_multiple_of(61) {
                return 0.0;
            }
            let exponent = (bits % 121) as i32 - 60;
            let sign = if bits & 1024 == 0 { 1.0 } else { -1.0 };
            sign * (1.0 + bits as f64 / (1u64 << 53) as f64) * 2f64.powi(exponent)
        }
    }

    /// Returns whether the interval holds `value + error`, |error| being below a unit of `value`.
    fn holds(interval: Interval, value: f64, error: f64) -> bool {
        let Interval { lo, hi } = interval;
        (lo < value || (lo == value && error >= 0.0)) && (value < hi || (value == hi && error <= 0.0))
    }

    /// Counts the sums, products, quotients and roots that exclude the exact result, which double arithmetic
    /// gives as a value and an error: Knuth's two-sum, and the fused remainders of product, quotient and
    /// root.
    fn wrong_operations(seed: u64) -> u32 {
        let mut random = Random(seed);
        let mut wrong = 0;
        for _ in 0..20_000 {
            let (x, y) = (random.number(), random.number());
            let (a, b) = (Interval::of(x), Interval::of(y));
            let sum = x + y;
            let part = sum - x;
            let error = (x - (sum - part)) + (y - part);
            wrong += u32::from(!holds(a + b, sum, error));
            let difference = x - y;
            let part = difference - x;
            let error = (x - (difference - part)) + (-y - part);
            wrong += u32::from(!holds(a - b, difference, error));
            let product = x * y;
            wrong += u32::from(!holds(a * b, product, x.mul_add(y, -product)));
            wrong += u32::from(!holds(a.square(), x * x, x.mul_add(x, -(x * x))));
            if y > 0.0 {
                let quotient = x / y;
                wrong += u32::from(!holds(a.over(b), quotient, (-quotient).mul_add(y, x)));
                let root = y.sqrt();
                wrong += u32::from(!holds(b.sqrt(), root, (-root).mul_add(root, y)));
            }
        }
        wrong
    }

    #[test]
    fn operations_hold_the_exact_results() {
        assert_eq!(wrong_operations(1), 0);
    }

    #[test]
    fn broken_rounding_is_caught() {
        BROKEN.set(true);
        let wrong = wrong_operations(1);
        BROKEN.set(false);
        // Nearly every operation rounds, half of them the wrong way.
        assert!(wrong > 20_000, "only {wrong} operations were found wrong");
    }

    #[test]
    fn ends_of_all_signs() {
        let ends = [-3.0, -1.0, 0.0, 2.0, 5.0];
        for (i, &a) in ends.iter().enumerate() {
            for &b in &ends[i..] {
                for (j, &c) in ends.iter().enumerate() {
                    for &d in &ends[j..] {
                        let (x, y) = (Interval::new(a, b), Interval::new(c, d));
                        for u in [a, 0.5 * (a + b), b] {
                            for v in [c, 0.5 * (c + d), d] {
                                let within = |z: Interval, w: f64| z.lo <= w && w <= z.hi;
                                assert!(within(x * y, u * v) && within(x + y, u + v) && within(x - y, u - v));
                                assert!(within(x.square(), u * u) && within(x.hull(y), v));
                                assert!(!(c > 0.0) || within(x.over(y), u / v));
                            }
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn a_failed_operation_is_the_whole_line() {
        let infinite = Interval::new(1.0, f64::INFINITY);
        assert_eq!(infinite + Interval::ONE, Interval::WHOLE);
        assert_eq!(Interval::of(1e200) * Interval::of(1e200), Interval::WHOLE);
        assert_eq!(Interval::ZERO * infinite, Interval::WHOLE);
        assert_eq!(infinite - infinite, Interval::WHOLE);
        assert_eq!(Interval::ONE.over(Interval::new(0.0, 1.0)), Interval::WHOLE);
        assert_eq!(Interval::ONE.over(Interval::new(-1.0, 1.0)), Interval::WHOLE);
        assert_eq!(Interval::of(f64::NAN) + Interval::ONE, Interval::WHOLE);
    }

    #[test]
    fn bounds_of_the_exponential() {
        for x in [0.0, 1e-9, 0.1, 1.0, 5.0, 20.0] {
            let bound = Interval::exp_bound(x);
            // (1 - x/n)^-n <= e^(x + x^2/n) for x <= n/2.
            assert!(bound >= x.exp() && bound <= (x + x * x / 64.0).exp() * (1.0 + 1e-12), "{x}");
        }
        assert_eq!(Interval::exp_bound(64.0), f64::INFINITY);
    }
}

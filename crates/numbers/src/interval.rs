//! Interval arithmetic with outward rounding, in plain f64.
//!
//! Every operation computes in the processor's round-to-nearest mode, whose error is at most half a unit in
//! the last place, and moves both ends outwards by at least a whole unit, underflow included (elementary
//! functions by four: the error of the platform's mathematics library is assumed to be less). So an enclosure
//! is a theorem about the real function, whatever the compiler's flags and the processor's state. Where an
//! operation is not defined on the whole operand, the result is the whole line. The crate `inari` is not used
//! because it requires AVX and FMA for the whole build, and GMP.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::jet::Real;
use crate::Range;

/// A closed interval of real numbers, which may be unbounded; never NaN, never empty.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Lower end.
    pub lo: f64,
    /// Upper end.
    pub hi: f64,
}

/// Widening of elementary functions, in units in the last place.
const FUNCTION_ULPS: u32 = 4;

/// A number above `x` by one to two units in the last place, which is |x| epsilon, and the smallest normal
/// number, which exceeds every error of underflow. NaN at negative infinity, which is no upper end.
#[inline]
fn up(x: f64) -> f64 {
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
    /// All real numbers.
    pub const ENTIRE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };
    /// The number 0.
    pub const ZERO: Interval = Interval::of(0.0);
    /// The number 1.
    pub const ONE: Interval = Interval::of(1.0);

    /// One real number.
    #[inline]
    pub const fn of(x: f64) -> Self {
        Self::new(x, x)
    }

    /// All numbers from `lo` to `hi`; the whole line if one of them is NaN, or they are in the wrong order.
    #[inline]
    pub const fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi { Self { lo, hi } } else { Self::ENTIRE }
    }

    /// All numbers within `radius` of `middle`.
    #[inline]
    pub fn ball(middle: f64, radius: f64) -> Self {
        Self::outwards(middle - radius, middle + radius)
    }

    /// The computed ends, moved outwards.
    #[inline]
    fn outwards(lo: f64, hi: f64) -> Self {
        Self::new(down(lo), up(hi))
    }

    /// The computed ends of an elementary function's image, moved outwards.
    #[inline]
    fn outwards_of_function(mut lo: f64, mut hi: f64) -> Self {
        for _ in 0..FUNCTION_ULPS {
            (lo, hi) = (down(lo), up(hi));
        }
        Self::new(lo, hi)
    }

    /// The image under an increasing function.
    #[inline]
    fn increasing(self, f: impl Fn(f64) -> f64) -> Self {
        Self::outwards_of_function(f(self.lo), f(self.hi))
    }

    /// Whether both ends are finite.
    #[inline]
    pub fn is_bounded(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    /// Whether 0 is one of its numbers.
    #[inline]
    pub fn contains_zero(self) -> bool {
        self.lo <= 0.0 && self.hi >= 0.0
    }

    /// Largest absolute value.
    #[inline]
    pub fn size(self) -> f64 {
        max(self.lo.abs(), self.hi.abs())
    }

    /// The nonnegative part, for quantities that cannot be negative.
    #[inline]
    pub fn at_least_zero(self) -> Self {
        Self { lo: max(self.lo, 0.0), hi: max(self.hi, 0.0) }
    }

    /// The smallest interval that contains both intervals.
    #[inline]
    pub fn hull(self, other: Self) -> Self {
        Self { lo: min(self.lo, other.lo), hi: max(self.hi, other.hi) }
    }

    /// The intersection of two enclosures of the same number.
    #[inline]
    pub fn intersection(self, other: Self) -> Self {
        Self { lo: max(self.lo, other.lo), hi: min(self.hi, other.hi) }
    }

    /// The squares of its numbers.
    #[inline]
    pub fn square(self) -> Self {
        let least = if self.contains_zero() { 0.0 } else { min(self.lo.abs(), self.hi.abs()) };
        let most = self.size();
        let Self { lo, hi } = Self::outwards(least * least, most * most);
        Self { lo: max(lo, 0.0), hi }
    }

    /// The quotient by a number that must be positive; the whole line unless the whole divisor is positive.
    #[inline]
    pub fn over(self, divisor: Self) -> Self {
        if !(divisor.lo > 0.0) {
            return Self::ENTIRE;
        }
        if self.is_zero() {
            return self;
        }
        let lo = self.lo / if self.lo < 0.0 { divisor.lo } else { divisor.hi };
        let hi = self.hi / if self.hi < 0.0 { divisor.hi } else { divisor.lo };
        Self::outwards(lo, hi).above_zero_if(self.lo >= 0.0)
    }

    /// Without the numbers below 0 that outward rounding added, if what is enclosed is at least 0.
    #[inline]
    fn above_zero_if(self, nonnegative: bool) -> Self {
        // Rounding moves an end that is at least 0 below it by this much at most; others are those of the whole line.
        let is_rounding = nonnegative & (self.lo >= -f64::MIN_POSITIVE);
        Self { lo: if is_rounding { max(self.lo, 0.0) } else { self.lo }, ..self }
    }

    /// Upper bound of e^x for a number x, without the platform's exponential: e^x <= (1 - x/64)^-64 for
    /// x < 64.
    #[inline]
    pub fn exp_bound(x: f64) -> f64 {
        let mut power = Self::ONE.over(Self::ONE - Self::of(x) * Self::of(1.0 / 64.0));
        for _ in 0..6 {
            power = power.square();
        }
        if x < 64.0 { power.hi } else { f64::INFINITY }
    }

    #[inline]
    /// An enclosure of pi.
    pub fn pi() -> Self {
        // The f64 nearest to pi is below it.
        Self { lo: std::f64::consts::PI, hi: std::f64::consts::PI.next_up() }
    }
}

impl From<Interval> for Range {
    #[inline]
    fn from(interval: Interval) -> Self {
        Range { lo: interval.lo, hi: interval.hi }
    }
}

impl Neg for Interval {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Add for Interval {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        // A sum with zero is exact, and frequent.
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        let sum = Self::outwards(self.lo + other.lo, self.hi + other.hi);
        // Two numbers that begin at zero add up to one that does: the base of a power next to rest.
        let begins_at_zero = (self.lo == 0.0) & (other.lo == 0.0);
        Self { lo: if begins_at_zero { 0.0 } else { sum.lo }, ..sum }
    }
}

impl Sub for Interval {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Interval {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            // A product with zero is exact, and frequent: derivatives of terms that do not depend on u.
            return Self::ZERO;
        }
        if self.lo >= 0.0 && other.lo >= 0.0 {
            let product = Self::outwards(self.lo * other.lo, self.hi * other.hi).above_zero_if(true);
            if product.is_bounded() {
                return product;
            }
        }
        let [a, b, c, d] = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        // Zero times infinity is NaN, which min and max would ignore; where infinities of both signs cancel
        // here, the product is the whole line too.
        if (a + b + c + d).is_nan() {
            return Self::ENTIRE;
        }
        Self::outwards(min(min(a, b), min(c, d)), max(max(a, b), max(c, d)))
    }
}

impl Div for Interval {
    type Output = Self;
    #[inline]
    fn div(self, other: Self) -> Self {
        if other.hi < 0.0 { (-self).over(-other) } else { self.over(other) }
    }
}

/// Returns whether a point `phase + 2 pi k` may lie in the interval.
fn may_hold(interval: Interval, phase: f64) -> bool {
    const SLACK: f64 = 1e-9;
    let turns = |x: f64| (x - phase) / std::f64::consts::TAU;
    (turns(interval.hi) + SLACK).floor() >= (turns(interval.lo) - SLACK).ceil()
}

impl Real for Interval {
    #[inline]
    fn constant(x: f64) -> Self {
        Self::of(x)
    }

    #[inline]
    fn is_zero(&self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }

    #[inline]
    fn as_constant(&self) -> Option<f64> {
        (self.lo == self.hi).then_some(self.lo)
    }

    #[inline]
    fn exp(self) -> Self {
        let Self { lo, hi } = self.increasing(f64::exp);
        Self { lo: lo.max(0.0), hi }
    }

    #[inline]
    fn is_below(&self, x: f64) -> bool {
        self.hi < x
    }

    fn at_most_exp(self, exponent: Self) -> Self {
        let most = exponent.exp().hi;
        // NaN counts as unknown.
        Self { lo: self.lo.max(-most), hi: self.hi.min(most) }
    }

    #[inline]
    fn ln(self) -> Self {
        if self.lo > 0.0 { self.increasing(f64::ln) } else { Self::ENTIRE }
    }

    #[inline]
    fn sqrt(self) -> Self {
        if !(self.lo >= 0.0) {
            return Self::ENTIRE;
        }
        // IEEE 754 requires a correctly rounded square root.
        let Self { lo, hi } = Self::outwards(self.lo.sqrt(), self.hi.sqrt());
        Self { lo: max(lo, 0.0), hi }
    }

    #[inline]
    fn sin_cos(self) -> (Self, Self) {
        use std::f64::consts::{FRAC_PI_2, PI};
        let all = Self { lo: -1.0, hi: 1.0 };
        // Far from zero the slack of `may_hold` no longer covers the rounding of a turn.
        if !(self.lo.abs().max(self.hi.abs()) < 1e6) {
            return (all, all);
        }
        let wave = |f: fn(f64) -> f64, top: f64| {
            let (a, b) = (f(self.lo), f(self.hi));
            let Self { lo, hi } = Self::outwards_of_function(a.min(b), a.max(b));
            Self {
                lo: if may_hold(self, top + PI) { -1.0 } else { lo.max(-1.0) },
                hi: if may_hold(self, top) { 1.0 } else { hi.min(1.0) },
            }
        };
        (wave(f64::sin, FRAC_PI_2), wave(f64::cos, 0.0))
    }

    #[inline]
    fn tanh(self) -> Self {
        let Self { lo, hi } = self.increasing(f64::tanh);
        Self { lo: lo.max(-1.0), hi: hi.min(1.0) }
    }

    #[inline]
    fn squared(self) -> Self {
        self.square()
    }

    #[inline]
    fn atan(self) -> Self {
        self.increasing(f64::atan)
    }

    #[inline]
    fn abs(self) -> Self {
        if self.lo > 0.0 {
            self
        } else if self.hi < 0.0 {
            -self
        } else {
            Self::ENTIRE
        }
    }

    #[inline]
    fn at_least(self, floor: f64) -> Self {
        Self { lo: Real::at_least(self.lo, floor), hi: Real::at_least(self.hi, floor) }
    }

    #[inline]
    fn rate_at_least(self, floor: f64, rate: Self) -> Self {
        if self.lo >= floor {
            rate
        } else if self.hi <= floor {
            Self::ZERO
        } else {
            Self::ENTIRE
        }
    }

    #[inline]
    fn power(self, exponent: f64) -> Self {
        let Self { lo, hi } = self;
        if !(lo >= 0.0) {
            return Self::ENTIRE;
        }
        // A power is monotone, so it lies between the powers of the ends; that of 0 is exact.
        let of_end = |x: f64| match x == 0.0 {
            true => Self { lo: 0.0, hi: 0.0 },
            false => (Self::of(exponent) * Self::of(x).ln()).exp(),
        };
        let (low, high) = (of_end(lo), of_end(hi));
        match exponent > 0.0 {
            true => Self { lo: low.lo, hi: high.hi },
            false if lo == 0.0 => Self { lo: if hi == 0.0 { 0.0 } else { high.lo }, hi: f64::INFINITY },
            false => Self { lo: high.lo, hi: low.hi },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn images_enclose_and_are_tight() {
        let x = Interval::new(0.3, 0.7);
        type Case = (Interval, fn(f64) -> f64);
        let cases: [Case; 7] = [
            (x.exp(), f64::exp),
            (x.ln(), f64::ln),
            (x.sqrt(), f64::sqrt),
            (x.sin_cos().0, f64::sin),
            (x.sin_cos().1, f64::cos),
            (x.tanh(), f64::tanh),
            (x.atan(), f64::atan),
        ];
        for (image, f) in cases {
            let (a, b) = (f(0.3).min(f(0.7)), f(0.3).max(f(0.7)));
            assert!(image.lo < a && a - image.lo <= 8.0 * f64::EPSILON, "{image:?}");
            assert!(image.hi > b && image.hi - b <= 8.0 * f64::EPSILON, "{image:?}");
        }
    }

    #[test]
    fn extremes_of_waves_are_found() {
        let pi = std::f64::consts::PI;
        assert_eq!(Interval::new(1.0, 2.0).sin_cos().0.hi, 1.0);
        assert_eq!(Interval::new(2.0, 4.0).sin_cos().1.lo, -1.0);
        assert_eq!(Interval::new(-0.1, 0.1).sin_cos().1.hi, 1.0);
        let wide = Interval::new(0.0, 2.0 * pi).sin_cos();
        assert_eq!((wide.0, wide.1), (Interval::new(-1.0, 1.0), Interval::new(-1.0, 1.0)));
    }

    #[test]
    fn undefined_operations_give_the_whole_line() {
        let x = Interval::new(-1.0, 1.0);
        let infinite = Interval::new(1.0, f64::INFINITY);
        let huge = Interval::of(1e200);
        for image in [
            Interval::ONE / x,
            Interval::ONE / Interval::new(0.0, 1.0),
            x.ln(),
            x.sqrt(),
            x.abs(),
            x.rate_at_least(0.5, Interval::ONE),
            Interval::new(f64::NAN, 1.0),
            Interval::of(f64::NAN) + Interval::ONE,
            huge * huge,
            infinite - infinite,
            Interval::new(0.0, 1.0) * infinite,
        ] {
            assert_eq!(image, Interval::ENTIRE);
        }
    }

    /// Magnitude from 2^-60 to 2^60, either sign, sometimes zero.
    fn number(random: &mut Random) -> f64 {
        let bits = random.bits() >> 11;
        if bits.is_multiple_of(61) {
            return 0.0;
        }
        let exponent = (bits % 121) as i32 - 60;
        let sign = if bits & 1024 == 0 { 1.0 } else { -1.0 };
        sign * (1.0 + bits as f64 / (1u64 << 53) as f64) * 2f64.powi(exponent)
    }

    /// Returns whether the interval holds `value + error`, |error| being below a unit of `value`.
    fn holds(interval: Interval, value: f64, error: f64) -> bool {
        let Interval { lo, hi } = interval;
        (lo < value || (lo == value && error >= 0.0)) && (value < hi || (value == hi && error <= 0.0))
    }

    /// No sum, product, quotient or root excludes the exact result, which double arithmetic gives as a value and an
    /// error: Knuth's two-sum, and the fused remainders of product, quotient and root.
    #[test]
    fn operations_hold_the_exact_results() {
        let mut random = Random(1);
        let mut wrong = 0;
        for _ in 0..20_000 {
            let (x, y) = (number(&mut random), number(&mut random));
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
                wrong += u32::from(!holds(a / b, quotient, (-quotient).mul_add(y, x)));
                let root = y.sqrt();
                wrong += u32::from(!holds(b.sqrt(), root, (-root).mul_add(root, y)));
            }
        }
        assert_eq!(wrong, 0);
    }

    #[test]
    fn ends_of_all_signs() {
        let ends = [-3.0, -1.0, 0.0, 2.0, 5.0];
        for (i, &a) in ends.iter().enumerate() {
            for &b in &ends[i..] {
                for (j, &c) in ends.iter().enumerate() {
                    for &d in &ends[j..] {
                        let (x, y) = (Interval::new(a, b), Interval::new(c, d));
                        assert!(a < 0.0 || c < 0.0 || (x + y).lo >= 0.0 && (x * y).lo >= 0.0);
                        assert!(a < 0.0 || !(c > 0.0) || (x / y).lo >= 0.0);
                        for u in [a, 0.5 * (a + b), b] {
                            for v in [c, 0.5 * (c + d), d] {
                                let within = |z: Interval, w: f64| z.lo <= w && w <= z.hi;
                                assert!(within(x * y, u * v) && within(x + y, u + v) && within(x - y, u - v));
                                assert!(within(x.square(), u * u) && within(x.hull(y), v));
                                assert!(!(c > 0.0) || within(x / y, u / v) && within(x.over(y), u / v));
                                assert!(!(d < 0.0) || within(x / y, u / v));
                            }
                        }
                    }
                }
            }
        }
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

    /// What others wrote: the vectors of IEEE 1788 hold, and images of operands on which an operation is defined are wider by
    /// the stated widening alone.
    #[test]
    fn the_public_vectors_of_ieee_1788_hold() {
        let mut bounded = 0;
        for row in include_str!("../itf1788.txt").lines().filter(|row| !row.starts_with('#')) {
            let mut words = row.split(' ');
            let name = words.next().unwrap();
            let ends: Vec<f64> =
                words.map(|digits| f64::from_bits(u64::from_str_radix(digits, 16).unwrap())).collect();
            let intervals: Vec<Interval> =
                ends.chunks(2).map(|ends| Interval::new(ends[0], ends[1])).collect();
            let (x, tightest) = (intervals[0], intervals[intervals.len() - 1]);
            let (image, ulps) = match name {
                "neg" => (-x, 0.0),
                "abs" => (x.abs(), 0.0),
                "add" => (x + intervals[1], 3.0),
                "sub" => (x - intervals[1], 3.0),
                "mul" => (x * intervals[1], 3.0),
                "div" => (x / intervals[1], 3.0),
                "sqr" => (x.squared(), 3.0),
                "sqrt" => (x.sqrt(), 3.0),
                "exp" => (x.exp(), 8.0),
                "log" => (x.ln(), 8.0),
                "sin" => (x.sin_cos().0, 8.0),
                "cos" => (x.sin_cos().1, 8.0),
                "tanh" => (x.tanh(), 8.0),
                "atan" => (x.atan(), 8.0),
                _ => panic!("{row}"),
            };
            assert!(image.lo <= tightest.lo && tightest.hi <= image.hi, "{name} {ends:?}: {image:?}");
            let slack = |end: f64| ulps * (end.abs() * f64::EPSILON + f64::MIN_POSITIVE);
            if image.is_bounded() {
                let [below, above] = [tightest.lo - image.lo, image.hi - tightest.hi];
                assert!(
                    below <= slack(tightest.lo) && above <= slack(tightest.hi),
                    "{name} {ends:?}: {image:?}"
                );
                bounded += 1;
            }
        }
        assert!(bounded > 200, "{bounded}");
    }

    /// The error of the platform's functions, assumed to be below [`FUNCTION_ULPS`] units in the last place: half a unit is that
    /// of the table, which is rounded correctly.
    #[test]
    fn functions_of_the_platform_err_less_than_assumed() {
        for row in include_str!("../elementary.txt").lines().filter(|row| !row.starts_with('#')) {
            let mut words = row.split(' ');
            let name = words.next().unwrap();
            let numbers: Vec<f64> =
                words.map(|digits| f64::from_bits(u64::from_str_radix(digits, 16).unwrap())).collect();
            let (x, exact) = (numbers[0], numbers[numbers.len() - 1]);
            let value = match name {
                "exp" => x.exp(),
                "ln" => x.ln(),
                "sqrt" => x.sqrt(),
                "sin" => x.sin(),
                "cos" => x.cos(),
                "tanh" => x.tanh(),
                "atan" => x.atan(),
                "pow" => x.powf(numbers[1]),
                _ => panic!("{row}"),
            };
            let unit = exact.abs().next_up() - exact.abs();
            let off = (value - exact).abs() / unit + 0.5;
            assert!(off < f64::from(FUNCTION_ULPS), "{name} {numbers:?}: {value}, {off} units");
        }
    }
}

//! Double-double arithmetic, about 31 digits: unevaluated sums of two doubles (T. J. Dekker 1971, D. E.
//! Knuth's exact sum; the algorithms as in Y. Hida, X. S. Li and D. H. Bailey, *Library for double-double and
//! quad-double arithmetic*). Relative errors of the operations are a few times 2^-104. Own code, because the
//! one crate that offers them, `twofloat` 0.8.4, is wrong in the 17th digit of 1/7.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// hi + lo, with |lo| at most half a unit in the last place of hi.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Double2 {
    /// The sum, rounded to a double.
    pub(crate) hi: f64,
    /// The rounding error of that sum.
    pub(crate) lo: f64,
}

/// 2 pi.
pub(crate) const TAU: Double2 = Double2 { hi: std::f64::consts::TAU, lo: 2.449_293_598_294_706_4e-16 };

/// a + b and its rounding error.
fn two_sum(a: f64, b: f64) -> Double2 {
    let hi = a + b;
    let part = hi - a;
    Double2 { hi, lo: (a - (hi - part)) + (b - part) }
}

/// a + b and its rounding error, for |a| >= |b| or a = 0.
fn quick_two_sum(a: f64, b: f64) -> Double2 {
    let hi = a + b;
    Double2 { hi, lo: b - (hi - a) }
}

/// a b and its rounding error.
fn two_product(a: f64, b: f64) -> Double2 {
    let hi = a * b;
    Double2 { hi, lo: a.mul_add(b, -hi) }
}

impl From<f64> for Double2 {
    fn from(hi: f64) -> Self {
        Self { hi, lo: 0.0 }
    }
}

impl<T: Into<Double2>> Add<T> for Double2 {
    type Output = Self;
    fn add(self, other: T) -> Self {
        let other = other.into();
        let (high, low) = (two_sum(self.hi, other.hi), two_sum(self.lo, other.lo));
        let sum = quick_two_sum(high.hi, high.lo + low.hi);
        quick_two_sum(sum.hi, sum.lo + low.lo)
    }
}

impl Neg for Double2 {
    type Output = Self;
    fn neg(self) -> Self {
        Self { hi: -self.hi, lo: -self.lo }
    }
}

impl<T: Into<Double2>> Sub<T> for Double2 {
    type Output = Self;
    fn sub(self, other: T) -> Self {
        self + -other.into()
    }
}

impl<T: Into<Double2>> Mul<T> for Double2 {
    type Output = Self;
    fn mul(self, other: T) -> Self {
        let other = other.into();
        let product = two_product(self.hi, other.hi);
        quick_two_sum(product.hi, product.lo + (self.hi * other.lo + self.lo * other.hi))
    }
}

impl<T: Into<Double2>> Div<T> for Double2 {
    type Output = Self;
    fn div(self, other: T) -> Self {
        // Long division, digit by digit to the base of a double.
        let other = other.into();
        let first = self.hi / other.hi;
        let rest = self - other * first;
        let second = rest.hi / other.hi;
        let third = (rest - other * second).hi / other.hi;
        quick_two_sum(first, second) + third
    }
}

impl Double2 {
    /// The number rounded to a double.
    #[must_use]
    pub fn value(self) -> f64 {
        self.hi
    }

    /// The exponential function of a number from -700 to 1.
    pub(crate) fn exp(self) -> Self {
        // Taylor series at x / 1024 (at most 0.69: x^19 / 19! < 1e-20 times its square), then ten squarings, of e^x - 1,
        // which keeps the accuracy of small numbers.
        let x = self * (1.0 / 1024.0);
        let (mut sum, mut term) = (x, x);
        for n in 2..24 {
            term = term * x / f64::from(n);
            sum = sum + term;
        }
        for _ in 0..10 {
            sum = sum * 2.0 + sum * sum;
        }
        sum + 1.0
    }

    /// The square root of a positive number.
    pub(crate) fn sqrt(self) -> Self {
        // One step of Newton's method doubles the digits of the double.
        let root = Self::from(self.hi.sqrt());
        root + (self - root * root) / (root * 2.0)
    }

    /// (sin, cos) of a number from 0 to 2 pi.
    pub(crate) fn sin_cos(self) -> (Self, Self) {
        // Taylor series at x / 16 (at most 0.4: x^27 / 27! < 2e-39), then four doublings of sin and of 1 -
        // cos, which keeps the accuracy of small angles.
        let x = self * 0.0625;
        let square = x * x;
        let series = |first: Self, from: u32| {
            let (mut sum, mut term) = (first, first);
            for n in (from..from + 26).step_by(2) {
                term = -(term * square) / f64::from(n * (n + 1));
                sum = sum + term;
            }
            sum
        };
        let mut sin = series(x, 2);
        let mut versine = series(square * 0.5, 3);
        for _ in 0..4 {
            (sin, versine) = (sin * 2.0 * (Self::from(1.0) - versine), sin * sin * 2.0);
        }
        (sin, Self::from(1.0) - versine)
    }
}

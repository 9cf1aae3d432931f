//! Truncated Taylor series: derivatives of any order, exact except for rounding, of compositions of
//! elementary functions. Series of [`super::interval::Interval`] enclose the derivatives on a whole interval;
//! nested series give mixed derivatives.

use std::ops::{Add, Div, Mul, Neg, Range, Sub};

/// Below this an exponential underflows, or its powers in a series do.
const FADED: f64 = -300.0;

/// Numbers to which the elementary functions can be applied. Where a function is not defined its value is
/// NaN, or the whole line for intervals.
pub trait Real:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self> + Neg<Output = Self>
{
    /// The number `x`.
    fn constant(x: f64) -> Self;
    /// Whether the number is exactly zero.
    fn is_zero(&self) -> bool;
    /// The value as one number; `None` if it contains several numbers, or depends on a variable.
    fn as_constant(&self) -> Option<f64>;
    /// The exponential function.
    fn exp(self) -> Self;
    /// The natural logarithm.
    fn ln(self) -> Self;
    /// The square root.
    fn sqrt(self) -> Self;
    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
    /// The hyperbolic tangent.
    fn tanh(self) -> Self;
    /// The inverse tangent.
    fn atan(self) -> Self;
    /// The absolute value.
    fn abs(self) -> Self;
    /// The sign of what begins as this number and grows by `next`: 1 or -1, and unknown where it stands for numbers of both
    /// signs.
    fn sign(self, _next: Self) -> Self {
        self.abs() / self
    }
    /// The larger one of the number and `floor`.
    fn at_least(self, floor: f64) -> Self;
    /// Of a number that changes at this `rate`, or of its later Taylor coefficients, that of [`Real::at_least`]: `rate` from
    /// `floor` on and 0 below, and unknown where it stands for numbers on both sides.
    fn rate_at_least(self, floor: f64, rate: Self) -> Self;
    /// A power, with an exponent that is not an integer, of a number >= 0.
    fn power(self, exponent: f64) -> Self;

    /// Whether all numbers that it stands for are below `x`.
    fn is_below(&self, _x: f64) -> bool {
        false
    }

    /// An enclosure of a number that is known to be at most exp(`exponent`) in size.
    #[must_use]
    fn at_most_exp(self, _exponent: Self) -> Self {
        self
    }

    /// An integer power, by squaring.
    fn powi(self, exponent: i32) -> Self {
        let mut power = Self::constant(1.0);
        let mut square = self;
        let mut left = exponent.unsigned_abs();
        let mut first = true;
        while left > 0 {
            if left & 1 == 1 {
                power = if first { square } else { power * square };
                first = false;
            }
            left >>= 1;
            if left > 0 {
                square = square.squared();
            }
        }
        if exponent < 0 { Self::constant(1.0) / power } else { power }
    }

    /// The square.
    fn squared(self) -> Self {
        self * self
    }

    /// The value of a polynomial, whose coefficients begin with that of order zero.
    #[inline]
    fn polynomial(self, coefficients: &[f64]) -> Self {
        coefficients.iter().rev().fold(Self::constant(0.0), |sum, a| sum * self + Self::constant(*a))
    }
}

impl Real for f64 {
    fn constant(x: f64) -> Self {
        x
    }
    fn is_zero(&self) -> bool {
        *self == 0.0
    }
    fn as_constant(&self) -> Option<f64> {
        Some(*self)
    }
    fn exp(self) -> Self {
        f64::exp(self)
    }
    fn ln(self) -> Self {
        if self > 0.0 { f64::ln(self) } else { f64::NAN }
    }
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn sin_cos(self) -> (Self, Self) {
        f64::sin_cos(self)
    }
    fn tanh(self) -> Self {
        f64::tanh(self)
    }
    fn is_below(&self, x: f64) -> bool {
        *self < x
    }
    fn atan(self) -> Self {
        f64::atan(self)
    }
    fn abs(self) -> Self {
        f64::abs(self)
    }
    fn sign(self, next: Self) -> Self {
        let own = if self == 0.0 { next } else { self };
        own.abs() / own
    }
    fn at_least(self, floor: f64) -> Self {
        // Not `f64::max`, which takes the floor for NaN.
        if self < floor { floor } else { self }
    }
    fn rate_at_least(self, floor: f64, rate: Self) -> Self {
        if self < floor { 0.0 } else { rate }
    }
    fn power(self, exponent: f64) -> Self {
        match self == 0.0 {
            true if exponent > 0.0 => 0.0,
            true => f64::INFINITY,
            false => (exponent * Real::ln(self)).exp(),
        }
    }
}

/// Several numbers. Every operation is applied to each of them, so that a formula is interpreted only once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Points<const N: usize>(pub [f64; N]);

impl<const N: usize> Points<N> {
    #[inline]
    fn with(mut self, other: Self, f: impl Fn(f64, f64) -> f64) -> Self {
        for (a, b) in self.0.iter_mut().zip(other.0) {
            *a = f(*a, b);
        }
        self
    }

    #[inline]
    fn map(mut self, f: impl Fn(f64) -> f64) -> Self {
        for a in &mut self.0 {
            *a = f(*a);
        }
        self
    }
}

/// Defines functions of each number.
macro_rules! functions {
    ($($name:ident)*) => {
        $(fn $name(self) -> Self {
            self.map(Real::$name)
        })*
    };
}

/// Defines the operators of two operands.
macro_rules! operators {
    ($($trait:ident $name:ident $op:tt;)*) => {
        $(impl<const N: usize> $trait for Points<N> {
            type Output = Self;
            #[inline]
            fn $name(self, other: Self) -> Self {
                self.with(other, |a, b| a $op b)
            }
        })*
    };
}

operators! {
    Add add +;
    Sub sub -;
    Mul mul *;
    Div div /;
}

impl<const N: usize> Neg for Points<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        self.map(|a| -a)
    }
}

impl<const N: usize> Real for Points<N> {
    fn constant(x: f64) -> Self {
        Self([x; N])
    }
    fn is_zero(&self) -> bool {
        self.0.iter().all(f64::is_zero)
    }
    fn as_constant(&self) -> Option<f64> {
        self.0.iter().all(|x| *x == self.0[0]).then_some(self.0[0])
    }
    functions! { exp ln sqrt tanh atan abs }
    fn sin_cos(self) -> (Self, Self) {
        (self.map(f64::sin), self.map(f64::cos))
    }
    fn is_below(&self, x: f64) -> bool {
        self.0.iter().all(|number| *number < x)
    }
    fn at_least(self, floor: f64) -> Self {
        self.map(|x| x.at_least(floor))
    }
    fn rate_at_least(self, floor: f64, rate: Self) -> Self {
        self.with(rate, |x, rate| x.rate_at_least(floor, rate))
    }
    fn sign(self, next: Self) -> Self {
        self.with(next, |x, next| x.sign(next))
    }
    fn power(self, exponent: f64) -> Self {
        self.map(|x| x.power(exponent))
    }
}

/// Argument from which on the series of the hyperbolic tangent is that of what it lacks to 1.
const SATURATED: f64 = 3.0;

/// The first N Taylor coefficients of a function: f, f', f''/2, ...
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet<T, const N: usize>(pub [T; N]);

impl<T: Real, const N: usize> Jet<T, N> {
    /// The series of a variable with value `x` and derivative `slope`.
    pub fn variable(x: T, slope: f64) -> Self {
        let mut jet = Self::of(x);
        if N > 1 {
            jet.0[1] = T::constant(slope);
        }
        jet
    }

    /// The series of the constant `x`.
    pub fn of(x: T) -> Self {
        let mut coefficients = [T::constant(0.0); N];
        coefficients[0] = x;
        Self(coefficients)
    }

    /// The number of coefficients up to the last nonzero one. Products skip the others, since constants and
    /// the slip speed itself are frequent factors.
    #[inline]
    fn length(&self) -> usize {
        let mut length = N;
        while length > 0 && self.0[length - 1].is_zero() {
            length -= 1;
        }
        length
    }

    /// The derivative of this order.
    pub fn derivative(&self, order: usize) -> T {
        let factorial: f64 = (1..=order).map(|k| k as f64).product();
        self.0[order] * T::constant(factorial)
    }

    /// The coefficients times their orders, j g_j, and the number of them up to the last nonzero one.
    #[inline]
    fn slopes(&self) -> ([T; N], usize) {
        let mut slopes = self.0;
        for (j, slope) in slopes.iter_mut().enumerate() {
            *slope = T::constant(j as f64) * *slope;
        }
        (slopes, self.length())
    }

    /// The series with first coefficient `start` whose derivative is g' times a rate, g = `self`. `rate`
    /// returns coefficient k of the rate, which may depend on the coefficients of the result up to k.
    fn integrate(&self, start: T, mut rate: impl FnMut(&[T; N], usize) -> T) -> Self {
        let mut sum = [T::constant(0.0); N];
        sum[0] = start;
        let (slopes, length) = self.slopes();
        let mut rates = [T::constant(0.0); N];
        for k in 1..N {
            rates[k - 1] = rate(&sum, k - 1);
            sum[k] = convolved(&slopes, &rates, k, 1..length.min(k + 1)) / T::constant(k as f64);
        }
        Self(sum)
    }

    /// The Taylor series of a polynomial around `x`, by repeated synthetic division.
    pub fn around(x: T, coefficients: &[f64]) -> Self {
        let mut series = [T::constant(0.0); N];
        for coefficient in coefficients.iter().rev() {
            for k in (1..N).rev() {
                series[k] = series[k] * x + series[k - 1];
            }
            series[0] = series[0] * x + T::constant(*coefficient);
        }
        Self(series)
    }
}

/// The sum of a_j b_(k-j) over a range of j; 0 where it is empty.
#[inline]
fn convolved<T: Real, const N: usize>(a: &[T; N], b: &[T; N], k: usize, range: Range<usize>) -> T {
    if range.is_empty() {
        return T::constant(0.0);
    }
    let mut sum = a[range.start] * b[k - range.start];
    for j in range.start + 1..range.end {
        sum = sum + a[j] * b[k - j];
    }
    sum
}

// Plain loops: adapters of the standard library, such as `array::from_fn`, may be compiled in another codegen
// unit than the body of the loop, and then nothing is inlined.
impl<T: Real, const N: usize> Neg for Jet<T, N> {
    type Output = Self;
    #[inline]
    fn neg(mut self) -> Self {
        for a in &mut self.0 {
            *a = -*a;
        }
        self
    }
}

impl<T: Real, const N: usize> Add for Jet<T, N> {
    type Output = Self;
    #[inline]
    fn add(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k] + other.0[k];
        }
        self
    }
}

impl<T: Real, const N: usize> Sub for Jet<T, N> {
    type Output = Self;
    #[inline]
    fn sub(mut self, other: Self) -> Self {
        for k in 0..N {
            self.0[k] = self.0[k] - other.0[k];
        }
        self
    }
}

impl<T: Real, const N: usize> Mul for Jet<T, N> {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let (long, short) = (self.length(), other.length());
        let mut product = [T::constant(0.0); N];
        for (k, coefficient) in product.iter_mut().enumerate() {
            let terms = (k + 1).saturating_sub(short)..long.min(k + 1);
            *coefficient = convolved(&self.0, &other.0, k, terms);
        }
        Self(product)
    }
}

impl<T: Real, const N: usize> Div for Jet<T, N> {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        let length = other.length();
        let mut quotient = [T::constant(0.0); N];
        for k in 0..N {
            let mut rest = self.0[k];
            for j in 1..length.min(k + 1) {
                rest = rest - other.0[j] * quotient[k - j];
            }
            quotient[k] = rest / other.0[0];
        }
        Self(quotient)
    }
}

impl<T: Real, const N: usize> Real for Jet<T, N> {
    fn constant(x: f64) -> Self {
        Self::of(T::constant(x))
    }

    fn is_zero(&self) -> bool {
        self.0.iter().all(T::is_zero)
    }

    fn as_constant(&self) -> Option<f64> {
        self.0[1..].iter().all(T::is_zero).then(|| self.0[0].as_constant())?
    }

    fn exp(self) -> Self {
        let mut series = self.integrate(self.0[0].exp(), |exp, k| exp[k]);
        if self.0[0].is_below(FADED) {
            // With S = sum of |j g_j| coefficient k is at most (1 + S)^k exp(g_0), by induction.
            let slopes = self.slopes().0.into_iter().filter(|slope| !slope.is_zero());
            let most = slopes.fold(T::constant(1.0), |sum, slope| sum + slope.abs()).ln();
            let mut exponent = self.0[0];
            for coefficient in &mut series.0 {
                *coefficient = coefficient.at_most_exp(exponent);
                exponent = exponent + most;
            }
        }
        series
    }

    fn ln(self) -> Self {
        // g' / g, whose coefficients follow from those of 1/g.
        let inverse = Self::constant(1.0) / self;
        self.integrate(self.0[0].ln(), |_, k| inverse.0[k])
    }

    fn sqrt(self) -> Self {
        let mut root = [T::constant(0.0); N];
        root[0] = self.0[0].sqrt();
        let twice = root[0] + root[0];
        for k in 1..N {
            let mut rest = self.0[k];
            for j in 1..k {
                rest = rest - root[j] * root[k - j];
            }
            root[k] = rest / twice;
        }
        Self(root)
    }

    fn sin_cos(self) -> (Self, Self) {
        let (mut sin, mut cos) = ([T::constant(0.0); N], [T::constant(0.0); N]);
        (sin[0], cos[0]) = self.0[0].sin_cos();
        let (slopes, length) = self.slopes();
        for k in 1..N {
            let (terms, order) = (1..length.min(k + 1), T::constant(k as f64));
            let (s, c) = (convolved(&slopes, &cos, k, terms.clone()), convolved(&slopes, &sin, k, terms));
            (sin[k], cos[k]) = (s / order, -c / order);
        }
        (Self(sin), Self(cos))
    }

    fn tanh(self) -> Self {
        // Next to 1 the difference 1 - tanh^2 has no digits. (Next to -1 it is left so: a law that rises out of nothing would
        // be resolved from nothing on.)
        if (-self.0[0]).is_below(-SATURATED) {
            let fading = (self * Self::constant(-2.0)).exp();
            return Self::constant(1.0) - (fading + fading) / (Self::constant(1.0) + fading);
        }
        // tanh' = 1 - tanh^2.
        self.integrate(self.0[0].tanh(), |tanh, k| {
            let one = if k == 0 { T::constant(1.0) } else { T::constant(0.0) };
            one - convolved(tanh, tanh, k, 0..k + 1)
        })
    }

    fn atan(self) -> Self {
        let rate = Self::constant(1.0) / (Self::constant(1.0) + self * self);
        self.integrate(self.0[0].atan(), |_, k| rate.0[k])
    }

    fn abs(self) -> Self {
        // |g| = g sign(g), at a kink that from there on.
        let sign = self.0[0].sign(self.0.get(1).copied().unwrap_or(self.0[0]));
        let mut series = self.0.map(|x| x * sign);
        series[0] = self.0[0].abs();
        Self(series)
    }

    fn at_least(self, floor: f64) -> Self {
        let mut series = self.rate_at_least(floor, self);
        series.0[0] = self.0[0].at_least(floor);
        series
    }

    fn rate_at_least(self, floor: f64, rate: Self) -> Self {
        Self(rate.0.map(|rate| self.0[0].rate_at_least(floor, rate)))
    }

    fn power(self, exponent: f64) -> Self {
        // By (g^p)' = p g^(p-1) g': first g^(p-n) with one coefficient, then g^(p-n+1) with two, and so on.
        // So at g = 0 all derivatives that exist are computed as finite numbers.
        let (slopes, length) = self.slopes();
        let mut lower = [T::constant(0.0); N];
        for order in (0..N).rev() {
            let p = exponent - order as f64;
            let mut series = [T::constant(0.0); N];
            series[0] = self.0[0].power(p);
            for (k, coefficient) in series.iter_mut().enumerate().take(N - order).skip(1) {
                let total = convolved(&slopes, &lower, k, 1..length.min(k + 1));
                *coefficient = T::constant(p) * total / T::constant(k as f64);
            }
            lower = series;
        }
        Self(lower)
    }

    /// The Taylor series of the polynomial around the value of this series, then a polynomial in what this
    /// series adds to that value.
    fn polynomial(self, coefficients: &[f64]) -> Self {
        let around = Self::around(self.0[0], coefficients);
        // Horner's rule. The sum at order j is yet multiplied j times by a series that begins at order 1.
        let length = self.length();
        let mut sum = [T::constant(0.0); N];
        for (j, a) in around.0.iter().enumerate().rev() {
            for k in (1..N - j).rev() {
                sum[k] = convolved(&self.0, &sum, k, 1..length.min(k + 1));
            }
            sum[0] = *a;
        }
        Self(sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::interval::Interval;

    /// Far from its feature an exponential is enclosed as narrowly as next to it: a formula that falls within 1e-9 of the
    /// slip speed is compiled to few pieces.
    #[test]
    fn exponentials_that_have_faded_are_narrow() {
        let x = Jet::<Interval, 14>::variable(Interval::new(0.5, 0.6), 0.05) * Jet::constant(1e9);
        for faded in [(-x).exp(), (-(x.powi(6))).exp()] {
            assert!(faded.0.iter().all(|c| c.size() < 1e-300 && c.lo <= 0.0 && c.hi > 0.0), "{faded:?}");
        }
        let tanh = x.tanh();
        assert!(tanh.0[0].lo <= 1.0 && 1.0 <= tanh.0[0].hi && tanh.0[0].hi - tanh.0[0].lo < 1e-15);
        assert!(tanh.0[1..].iter().all(|c| c.size() < 1e-300 && c.lo <= 0.0 && c.hi >= 0.0), "{tanh:?}");
        // The series is that of the recursion where that is narrow.
        let x = Jet::<Interval, 6>::variable(Interval::of(3.5), 1.0);
        let exact = -Jet::<f64, 6>::variable(-3.5, -1.0).tanh();
        for (c, exact) in x.tanh().0.iter().zip(exact.0) {
            assert!((c.lo - exact).abs() < 1e-14 && (c.hi - exact).abs() < 1e-14, "{c:?} {exact}");
        }
    }

    /// A polynomial of a series, by its Taylor expansion, is that of Horner's rule; the expansion consists of
    /// the derivatives.
    #[test]
    fn polynomials_of_series_are_those_of_horner() {
        let coefficients = [0.3, -1.2, 0.5, 0.7, -0.4, 0.9];
        let x = Jet::<f64, 4>::variable(0.7, 2.0).sin_cos().0;
        let horner = coefficients
            .iter()
            .rev()
            .fold(Jet::constant(0.0), |sum, a| sum * x + Jet::<f64, 4>::constant(*a));
        for (found, exact) in x.polynomial(&coefficients).0.into_iter().zip(horner.0) {
            // Some twenty roundings of terms of at most ten units.
            assert!((found - exact).abs() <= 200.0 * f64::EPSILON, "{found} {exact}");
        }
        // Of an interval: the series of its numbers, also beyond the degree.
        let wide = Jet::<Interval, 7>::variable(Interval::new(0.6, 0.8), 2.0).sin_cos().0;
        let wide = (wide.polynomial(&coefficients), Jet::<Interval, 7>::around(wide.0[0], &coefficients));
        for i in 0..=10 {
            let x = Jet::<f64, 7>::variable(0.6 + 0.02 * f64::from(i), 2.0).sin_cos().0;
            let one = (x.polynomial(&coefficients), Jet::<f64, 7>::around(x.0[0], &coefficients));
            for (wide, one) in [(wide.0, one.0), (wide.1, one.1)] {
                let holds = |k: usize| wide.0[k].lo <= one.0[k] && one.0[k] <= wide.0[k].hi;
                assert!((0..7).all(holds), "{wide:?} {one:?}");
            }
        }
        // p'' / 2 at 2: 0.5 + 3 * 0.7 * 2 - 6 * 0.4 * 4 + 10 * 0.9 * 8.
        let around = Jet::<f64, 3>::around(2.0, &coefficients);
        assert!((around.0[2] - (0.5 + 4.2 - 9.6 + 72.0)).abs() < 1e-13, "{around:?}");
    }

    /// At 0 a power has as many derivatives as it has.
    #[test]
    fn powers_at_zero_have_finite_derivatives_up_to_their_order() {
        let x = Jet::<f64, 4>::variable(0.0, 1.0);
        for (exponent, finite) in [(0.5, 1), (1.5, 2), (2.5, 3), (3.5, 4)] {
            let found = x.power(exponent).0;
            assert!(found[..finite].iter().all(|it| *it == 0.0), "{exponent} {found:?}");
            assert!(found[finite..].iter().all(|it| !it.is_finite()), "{exponent} {found:?}");
        }
        assert_eq!(Jet::<f64, 2>::variable(0.0, 1.0).powi(1).0, [0.0, 1.0]);
    }
}

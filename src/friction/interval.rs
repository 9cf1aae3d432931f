//! Interval arithmetic with outward rounding, for friction laws.
//!
//! Every operation widens its result by one unit in the last place (elementary functions by four: the error
//! of the platform's mathematics library is assumed to be less), so that an enclosure is a theorem about the
//! real function. Where an operation is not defined on the whole operand, the result is the whole line.

use std::ops::{Add, Div, Mul, Neg, Sub};

use super::Range;
use super::jet::Real;

/// A closed interval; never NaN.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Interval {
    pub(crate) lo: f64,
    pub(crate) hi: f64,
}

/// Widening of elementary functions, in units in the last place.
const FUNCTION_ULPS: u32 = 4;

impl Interval {
    pub(crate) const ENTIRE: Interval = Interval { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

    pub(crate) fn new(lo: f64, hi: f64) -> Self {
        if lo <= hi { Self { lo, hi } } else { Self::ENTIRE }
    }

    pub(crate) fn thin(x: f64) -> Self {
        Self::new(x, x)
    }

    pub(crate) fn is_bounded(self) -> bool {
        self.lo.is_finite() && self.hi.is_finite()
    }

    pub(crate) fn contains_zero(self) -> bool {
        self.lo <= 0.0 && self.hi >= 0.0
    }

    /// The smallest interval that contains both.
    pub(crate) fn hull(self, other: Self) -> Self {
        Self { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    fn outward(lo: f64, hi: f64, ulps: u32) -> Self {
        let (mut lo, mut hi) = (lo, hi);
        for _ in 0..ulps {
            (lo, hi) = (lo.next_down(), hi.next_up());
        }
        Self::new(lo, hi)
    }

    /// The image under an increasing function.
    fn increasing(self, f: impl Fn(f64) -> f64) -> Self {
        Self::outward(f(self.lo), f(self.hi), FUNCTION_ULPS)
    }
}

impl From<Interval> for Range {
    fn from(interval: Interval) -> Self {
        Range { lo: interval.lo, hi: interval.hi }
    }
}

impl Neg for Interval {
    type Output = Self;
    fn neg(self) -> Self {
        Self { lo: -self.hi, hi: -self.lo }
    }
}

impl Add for Interval {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        // Exact, and frequent, as in products.
        if self.is_zero() {
            return other;
        }
        if other.is_zero() {
            return self;
        }
        Self::outward(self.lo + other.lo, self.hi + other.hi, 1)
    }
}

impl Sub for Interval {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        if other.is_zero() {
            return self;
        }
        Self::outward(self.lo - other.hi, self.hi - other.lo, 1)
    }
}

/// The hull of four numbers, rounded outward; the whole line if one is NaN.
fn hull_of(values: [f64; 4]) -> Interval {
    if values.iter().any(|x| x.is_nan()) {
        return Interval::ENTIRE;
    }
    let lo = values.iter().copied().fold(f64::INFINITY, f64::min);
    let hi = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    Interval::outward(lo, hi, 1)
}

impl Mul for Interval {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        if self.is_zero() || other.is_zero() {
            // Exact, and frequent: derivatives of terms that do not depend on u.
            return Self::constant(0.0);
        }
        let products = [self.lo * other.lo, self.lo * other.hi, self.hi * other.lo, self.hi * other.hi];
        if !(self.is_bounded() && other.is_bounded()) {
            return hull_of(products);
        }
        // No product is NaN; this is the hot path.
        let order = |a: f64, b: f64| if a < b { (a, b) } else { (b, a) };
        let [(a, b), (c, d)] = [order(products[0], products[1]), order(products[2], products[3])];
        Self { lo: order(a, c).0.next_down(), hi: order(b, d).1.next_up() }
    }
}

impl Div for Interval {
    type Output = Self;
    fn div(self, other: Self) -> Self {
        if other.contains_zero() {
            return Self::ENTIRE;
        }
        if self.is_zero() {
            return self;
        }
        hull_of([self.lo / other.lo, self.lo / other.hi, self.hi / other.lo, self.hi / other.hi])
    }
}

/// Returns whether a point `phase + 2 pi k` may lie in the interval.
fn may_hold(interval: Interval, phase: f64) -> bool {
    const SLACK: f64 = 1e-9;
    let turns = |x: f64| (x - phase) / std::f64::consts::TAU;
    (turns(interval.hi) + SLACK).floor() >= (turns(interval.lo) - SLACK).ceil()
}

impl Real for Interval {
    fn constant(x: f64) -> Self {
        Self { lo: x, hi: x }
    }

    fn is_zero(&self) -> bool {
        self.lo == 0.0 && self.hi == 0.0
    }

    fn exp(self) -> Self {
        let Self { lo, hi } = self.increasing(f64::exp);
        Self { lo: lo.max(0.0), hi }
    }

    fn ln(self) -> Self {
        if self.lo > 0.0 { self.increasing(f64::ln) } else { Self::ENTIRE }
    }

    fn sqrt(self) -> Self {
        if !(self.lo >= 0.0) {
            return Self::ENTIRE;
        }
        let Self { lo, hi } = self.increasing(f64::sqrt);
        Self { lo: lo.max(0.0), hi }
    }

    fn sin_cos(self) -> (Self, Self) {
        use std::f64::consts::{FRAC_PI_2, PI};
        let all = Self { lo: -1.0, hi: 1.0 };
        // Far from zero the slack of `may_hold` no longer covers the rounding of a turn.
        if !(self.lo.abs().max(self.hi.abs()) < 1e6) {
            return (all, all);
        }
        let wave = |f: fn(f64) -> f64, top: f64| {
            let (a, b) = (f(self.lo), f(self.hi));
            let Self { lo, hi } = Self::outward(a.min(b), a.max(b), FUNCTION_ULPS);
            Self {
                lo: if may_hold(self, top + PI) { -1.0 } else { lo.max(-1.0) },
                hi: if may_hold(self, top) { 1.0 } else { hi.min(1.0) },
            }
        };
        (wave(f64::sin, FRAC_PI_2), wave(f64::cos, 0.0))
    }

    fn tanh(self) -> Self {
        let Self { lo, hi } = self.increasing(f64::tanh);
        Self { lo: lo.max(-1.0), hi: hi.min(1.0) }
    }

    fn atan(self) -> Self {
        self.increasing(f64::atan)
    }

    fn abs(self) -> Self {
        if self.lo > 0.0 {
            self
        } else if self.hi < 0.0 {
            -self
        } else {
            Self::ENTIRE
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

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
        for image in [Interval::thin(1.0) / x, x.ln(), x.sqrt(), x.abs(), Interval::new(f64::NAN, 1.0)] {
            assert_eq!(image, Interval::ENTIRE);
        }
    }
}

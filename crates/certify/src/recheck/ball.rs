//! Numbers with a bound on their error: a middle and a radius.

use std::ops::{Add, Mul, Neg, Sub};

/// All real numbers within `radius` of `middle`. An infinite or NaN radius means that nothing is known; every
/// comparison is written so that such a ball proves nothing.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ball {
    pub(super) middle: f64,
    pub(super) radius: f64,
}

impl Ball {
    pub(super) fn exact(middle: f64) -> Self {
        Self { middle, radius: 0.0 }
    }

    pub(super) fn new(middle: f64, radius: f64) -> Self {
        Self { middle, radius }
    }

    /// The middle is a sum or product rounded once, wrong by at most half of |middle| epsilon or, below the
    /// normal numbers, by less than the least of these. The radius is a sum of at most eight positive terms
    /// and products, each rounded with half a unit: sixteen units cover that.
    fn rounded(middle: f64, radius: f64) -> Self {
        let radius = radius + middle.abs() * f64::EPSILON + f64::MIN_POSITIVE;
        Self { middle, radius: radius * (1.0 + 16.0 * f64::EPSILON) }
    }

    /// A number below all of the ball; NaN if nothing is known.
    pub(super) fn least(self) -> f64 {
        let least = self.middle - self.radius;
        least - (least.abs() * f64::EPSILON + f64::MIN_POSITIVE)
    }

    /// A bound on the absolute value.
    pub(super) fn size(self) -> f64 {
        Self::rounded(0.0, self.middle.abs() + self.radius).radius
    }

    /// All numbers between `lo` and `hi`.
    pub(super) fn between(lo: f64, hi: f64) -> Self {
        let middle = 0.5 * lo + 0.5 * hi;
        Self::rounded(middle, (hi - middle).max(middle - lo))
    }
}

impl Add for Ball {
    type Output = Self;
    fn add(self, other: Self) -> Self {
        Self::rounded(self.middle + other.middle, self.radius + other.radius)
    }
}

impl Neg for Ball {
    type Output = Self;
    fn neg(self) -> Self {
        Self { middle: -self.middle, radius: self.radius }
    }
}

impl Sub for Ball {
    type Output = Self;
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl Mul for Ball {
    type Output = Self;
    fn mul(self, other: Self) -> Self {
        let cross = self.middle.abs() * other.radius + self.radius * other.middle.abs();
        Self::rounded(self.middle * other.middle, cross + self.radius * other.radius)
    }
}

impl Mul<f64> for Ball {
    type Output = Self;
    fn mul(self, other: f64) -> Self {
        self * Ball::exact(other)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn balls_hold_exact_sums_and_products() {
        let mut random = slipmap_numbers::random::Random(7);
        let mut number = || random.unit() - 0.5;
        for _ in 0..10_000 {
            let (x, y) = (number(), number());
            let (p, s) = (Ball::exact(x) * Ball::exact(y), Ball::exact(x) + Ball::exact(y));
            // The fused remainder of a product, and Knuth's of a sum, are exact.
            assert!(x.mul_add(y, -p.middle).abs() <= p.radius);
            let part = s.middle - x;
            assert!(((x - (s.middle - part)) + (y - part)).abs() <= s.radius);
            let (wide, other) = (Ball::between(x.min(y), x.max(y)), Ball::new(y, 0.25));
            for (u, v) in [(x, y - 0.25), (y, y + 0.25), (0.5 * (x + y), y)] {
                let off = |ball: Ball, value: f64| (ball.middle - value).abs() > ball.radius;
                assert!(!off(wide * other, u * v) && !off(wide - other, u - v));
                assert!(wide.least() <= u && u.abs() <= wide.size());
            }
        }
    }

    #[test]
    fn unknown_numbers_prove_nothing() {
        let unknown = Ball::exact(f64::MAX) * Ball::exact(f64::MAX) - Ball::exact(f64::INFINITY);
        assert!(!(unknown.least() > 0.0) && !(unknown.size() < 1.0));
    }
}

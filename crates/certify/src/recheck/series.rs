//! Fourier series of finite length, with a bound on the sum of the absolute errors of their coefficients.
//!
//! The sum of the absolute values of the coefficients bounds the function, and the norm of a product is at
//! most the product of norms. So one number per series accounts for all rounding errors.

use super::ball::Ball;

/// The function sum over |n| <= degree of (re + i im)\[n + degree\] e^(i n theta).
#[derive(Clone, Debug)]
pub(super) struct Series {
    re: Vec<f64>,
    im: Vec<f64>,
    /// Bound on the sum of the coefficients' errors.
    error: f64,
}

/// Factor that covers the roundings in the computation of a bound from some hundred positive terms.
const LOOSE: f64 = 1.0 + 1e-9;

impl Series {
    /// sum of a_n cos n theta + b_n sin n theta from n = 0 (b_0 is ignored), with a bound on the sum of the
    /// errors of all a_n and b_n.
    pub(super) fn real(cosines: &[f64], sines: &[f64], error: f64) -> Self {
        let degree = cosines.len() - 1;
        let (mut re, mut im) = (vec![0.0; 2 * degree + 1], vec![0.0; 2 * degree + 1]);
        re[degree] = cosines[0];
        for n in 1..=degree {
            // Halves are exact.
            let (a, b) = (0.5 * cosines[n], 0.5 * sines[n]);
            (re[degree + n], im[degree + n]) = (a, -b);
            (re[degree - n], im[degree - n]) = (a, b);
        }
        Self { re, im, error }
    }

    fn degree(&self) -> usize {
        self.re.len() / 2
    }

    /// Bound on the sum of the absolute values of the coefficients as stored.
    fn stored_norm(&self) -> f64 {
        let sum: f64 = self.re.iter().zip(&self.im).map(|(re, im)| (re * re + im * im).sqrt()).sum();
        // Squares may have underflowed; their roots are below 1e-150.
        sum * LOOSE + 1e-140
    }

    /// Bound on the function.
    pub(super) fn norm(&self) -> f64 {
        (self.stored_norm() + self.error) * LOOSE
    }

    /// The product.
    pub(super) fn times(&self, other: &Series) -> Series {
        let (long, short) = if self.re.len() < other.re.len() { (other, self) } else { (self, other) };
        let length = long.re.len() + short.re.len() - 1;
        let (mut re, mut im) = (vec![0.0; length], vec![0.0; length]);
        for (k, (&a, &b)) in short.re.iter().zip(&short.im).enumerate() {
            if a == 0.0 && b == 0.0 {
                continue;
            }
            let (re, im) = (&mut re[k..k + long.re.len()], &mut im[k..k + long.re.len()]);
            for (((re, im), c), d) in re.iter_mut().zip(im).zip(&long.re).zip(&long.im) {
                *re += a * c - b * d;
                *im += a * d + b * c;
            }
        }
        // A real part is a sum of at most 2 n products, n terms of the shorter series: its error is at most
        // (2 n + 2) units of 2^-53 times the sum of their sizes, which is at most the product of the moduli
        // summed, times sqrt(2). The bound holds for the imaginary part, too.
        let (one, two) = (self.stored_norm(), other.stored_norm());
        let rounding = (4 * short.re.len() + 8) as f64 * f64::EPSILON * one * two;
        let error = one * other.error + self.error * two + self.error * other.error + rounding;
        Series { re, im, error: error * LOOSE + f64::MIN_POSITIVE * 1e6 }
    }

    /// The product with a number.
    pub(super) fn scaled(mut self, factor: Ball) -> Series {
        let norm = self.stored_norm();
        for x in self.re.iter_mut().chain(&mut self.im) {
            *x *= factor.middle;
        }
        let error = self.error * factor.size() + norm * (factor.radius + factor.middle.abs() * f64::EPSILON);
        self.error = error * LOOSE + f64::MIN_POSITIVE * 1e6;
        self
    }

    /// The sum.
    pub(super) fn plus(&self, other: &Series) -> Series {
        let (long, short) = if self.re.len() < other.re.len() { (other, self) } else { (self, other) };
        let mut sum = long.clone();
        let shift = long.degree() - short.degree();
        for (k, (re, im)) in short.re.iter().zip(&short.im).enumerate() {
            sum.re[shift + k] += re;
            sum.im[shift + k] += im;
        }
        let rounding = 2.0 * f64::EPSILON * (self.stored_norm() + other.stored_norm());
        sum.error = (self.error + other.error + rounding) * LOOSE;
        sum
    }

    /// The sum with a number.
    pub(super) fn plus_number(mut self, number: Ball) -> Series {
        let at = self.degree();
        let sum = Ball::exact(self.re[at]) + number;
        self.re[at] = sum.middle;
        self.error = (self.error + sum.radius) * LOOSE;
        self
    }

    /// The derivative by theta.
    pub(super) fn derivative(&self) -> Series {
        let degree = self.degree();
        let order = |k: usize| k as f64 - degree as f64;
        let re = self.im.iter().enumerate().map(|(k, im)| -order(k) * im).collect();
        let im = self.re.iter().enumerate().map(|(k, re)| order(k) * re).collect();
        let rounding = 2.0 * f64::EPSILON * self.stored_norm();
        Series { re, im, error: (self.error + rounding) * degree as f64 * LOOSE }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 2 + cos - 3 sin 2 theta at an angle, from its coefficients.
    fn value(series: &Series, angle: f64) -> f64 {
        let degree = series.degree() as f64;
        let terms = series.re.iter().zip(&series.im).enumerate();
        terms
            .map(|(k, (re, im))| {
                let phase = (k as f64 - degree) * angle;
                re * phase.cos() - im * phase.sin()
            })
            .sum()
    }

    #[test]
    fn the_algebra_is_that_of_functions() {
        let f = Series::real(&[2.0, 1.0, 0.0], &[0.0, 0.0, -3.0], 0.0);
        let g = Series::real(&[0.5, 0.0, 0.0, 2.0], &[0.0, 1.0, 0.0, 0.25], 0.0);
        for angle in [0.0_f64, 0.3, 1.7, 4.0] {
            let (x, y): (f64, f64) = (
                2.0 + angle.cos() - 3.0 * (2.0 * angle).sin(),
                0.5 + angle.sin() + 2.0 * (3.0 * angle).cos() + 0.25 * (3.0 * angle).sin(),
            );
            let slope = -angle.sin() - 6.0 * (2.0 * angle).cos();
            for (series, expected) in [
                (f.times(&g), x * y),
                (g.times(&f), x * y),
                (f.plus(&g), x + y),
                (f.clone().scaled(Ball::exact(3.0)).plus_number(Ball::exact(1.0)), 3.0 * x + 1.0),
                (f.derivative(), slope),
            ] {
                // Some dozens of roundings on numbers below 50.
                assert!((value(&series, angle) - expected).abs() < 1e-12, "{angle}");
                assert!(expected.abs() <= series.norm() && series.error < 1e-11);
            }
        }
    }

    #[test]
    fn errors_are_passed_on() {
        let (f, off) =
            (Series::real(&[1.0, 2.0], &[0.0, 1.0], 0.0), Series::real(&[1.0, 2.01], &[0.0, 1.0], 0.0));
        let uncertain = Series::real(&[1.0, 2.0], &[0.0, 1.0], 0.0101); // 2.01 is rounded
        let difference = |one: Series, two: &Series| one.plus(&two.clone().scaled(Ball::exact(-1.0))).norm();
        let cube = |s: &Series| s.times(s).times(s);
        assert!(difference(cube(&off), &cube(&f)) <= cube(&uncertain).error);
        assert!(difference(off.derivative(), &f.derivative()) <= uncertain.derivative().error);
        let k = Ball::new(2.0, 0.1);
        assert!(
            difference(off.scaled(Ball::exact(2.1)), &f.scaled(Ball::exact(2.0)))
                <= uncertain.scaled(k).error
        );
    }
}

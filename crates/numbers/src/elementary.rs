//! Elementary functions that vectorise: without branches and calls, to a few units in the last place.

use crate::TimesPlus as _;

/// 1 / n!, n from 0.
pub const INVERSE_FACTORIALS: [f64; 18] = {
    let mut inverses = [1.0; 18];
    let (mut factorial, mut n) = (1.0, 1);
    while n < inverses.len() {
        factorial *= n as f64;
        inverses[n] = 1.0 / factorial;
        n += 1;
    }
    inverses
};

/// exp(x) by its Taylor series to degree 9 at x / 2^`HALVINGS`, then as many squarings: to a few units in the
/// last place for |x| <= 0.09 * 2^`HALVINGS`, to 1e-8 for |x| <= 0.5 * 2^`HALVINGS`.
#[inline(always)]
pub fn exp<const HALVINGS: u32>(x: f64) -> f64 {
    let y = x / f64::from(1_u32 << HALVINGS);
    let mut sum = INVERSE_FACTORIALS[9];
    for n in (1..9).rev() {
        sum = y.times_plus(sum, INVERSE_FACTORIALS[n]);
    }
    // expm1 keeps the accuracy of small arguments through the squarings: e(2y) = e(y) (2 + e(y)).
    let mut expm1 = y * sum;
    for _ in 0..HALVINGS {
        expm1 *= 2.0 + expm1;
    }
    1.0 + expm1
}

/// exp(x) for x <= 0 by its Taylor series to degree 13 at the remainder of x by ln 2; to a few units in the last place, and
/// not below the normal numbers.
#[inline(always)]
pub fn exp_falling(x: f64) -> f64 {
    // ln 2 as a sum of two numbers, of which the first has zeros at its end.
    const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
    // A number of this size has no fraction; its last bits are those of the exponent.
    const WHOLE: f64 = 6_755_399_441_055_744.0 + 1023.0;
    let x = if x > -708.0 { x } else { -708.0 };
    let shifted = x.times_plus(std::f64::consts::LOG2_E, WHOLE);
    let whole = shifted - WHOLE;
    let rest = whole.times_plus(-LN_2[1], whole.times_plus(-LN_2[0], x));
    let mut sum = INVERSE_FACTORIALS[13];
    for n in (0..13).rev() {
        sum = rest.times_plus(sum, INVERSE_FACTORIALS[n]);
    }
    sum * f64::from_bits(shifted.to_bits() << 52)
}

/// sin(z) and cos(z) for |z| <= pi / 4, by the Taylor series up to z^17 / 17! and z^16 / 16!, of which
/// Horner's rule takes the coefficients 1 / n! from the last one to the first.
#[inline(always)]
pub fn sin_cos(z: f64) -> [f64; 2] {
    let y = -z * z;
    let [mut sin, mut cos] = [INVERSE_FACTORIALS[17], INVERSE_FACTORIALS[16]];
    for n in (0..8).rev() {
        sin = y.times_plus(sin, INVERSE_FACTORIALS[2 * n + 1]);
        cos = y.times_plus(cos, INVERSE_FACTORIALS[2 * n]);
    }
    [z * sin, cos]
}

/// sin(z) and cos(z) for z from 0 to 2 pi and a few roundings beyond, to about a unit in the last place.
#[inline(always)]
pub fn sin_cos_of_turn(z: f64) -> [f64; 2] {
    // pi / 2 as a sum of two numbers, of which the first has zeros at its end.
    const QUARTER: [f64; 2] = [1.570_796_251_296_997, 7.549_789_954_891_882e-8];
    let quarters = (z * std::f64::consts::FRAC_2_PI + 0.5).floor();
    let [sin, cos] = sin_cos(quarters.times_plus(-QUARTER[1], quarters.times_plus(-QUARTER[0], z)));
    match quarters as i32 & 3 {
        0 => [sin, cos],
        1 => [cos, -sin],
        2 => [-sin, -cos],
        _ => [-cos, sin],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Against values that are rounded correctly: a few units in the last place, of a sine or cosine of any angle of its size 1.
    #[test]
    fn functions_are_within_a_few_units() {
        let mut compared = [0; 3];
        for row in include_str!("../elementary.txt").lines().filter(|row| !row.starts_with('#')) {
            let words: Vec<&str> = row.split(' ').collect();
            let number = |digits: &str| f64::from_bits(u64::from_str_radix(digits, 16).unwrap());
            let (x, exact) = (number(words[1]), number(words[words.len() - 1]));
            let near = |value: f64, ulps: f64, size: f64| {
                let off = (value - exact).abs() / (f64::EPSILON * size);
                assert!(off <= ulps, "{row}: {x} {value} {exact} {off}");
            };
            match words[0] {
                "exp" if (-700.0..=0.0).contains(&x) => {
                    near(exp_falling(x), 4.0, exact);
                    compared[0] += 1;
                }
                "exp" if x.abs() < 0.36 => {
                    near(exp::<2>(x), 4.0, exact);
                    compared[0] += 1;
                }
                "sin" | "cos" if x.abs() < std::f64::consts::FRAC_PI_4 => {
                    near(sin_cos(x)[usize::from(words[0] == "cos")], 2.0, exact.abs());
                    compared[1] += 1;
                }
                "sin" | "cos" if (0.0..std::f64::consts::TAU).contains(&x) => {
                    near(sin_cos_of_turn(x)[usize::from(words[0] == "cos")], 1.0, 1.0);
                    compared[2] += 1;
                }
                _ => {}
            }
        }
        assert!(compared[0] > 50 && compared[1] > 100 && compared[2] > 2, "{compared:?}");
    }
}

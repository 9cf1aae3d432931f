//! Root search in a bracket.

/// A bracket of a root of a falling function.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bracket {
    /// Lower end, where it is positive, and the value there.
    pub low: (f64, f64),
    /// Upper end, where it is negative, and the value there.
    pub high: (f64, f64),
}

impl Bracket {
    /// The distance of its ends.
    pub fn width(&self) -> f64 {
        self.high.0 - self.low.0
    }

    fn middle(&self) -> f64 {
        0.5 * (self.low.0 + self.high.0)
    }

    /// Slope of the secant, as a positive number.
    pub fn steepness(&self) -> f64 {
        (self.low.1 - self.high.1) / self.width()
    }
}

/// Narrows `bracket` to `enough` by the ITP method of Oliveira and Takahashi
/// (ACM Trans. Math. Softw. 47, 2020), which is as fast as the secant where the function is smooth and never
/// slower than bisection where only its sign is known. Returns the middle of the bracket, or a place where
/// the function is zero and its sign therefore unknown, and the bracket.
pub fn falling_root<E>(
    mut bracket: Bracket,
    enough: f64,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<(f64, Bracket), E> {
    let truncation = 0.2 / bracket.width();
    // Half the width that bisection alone would leave, with one step to spare.
    let mut allowance = bracket.width();
    while bracket.width() > enough {
        let (middle, width) = (bracket.middle(), bracket.width());
        let Bracket { low: (low, at_low), high: (high, at_high) } = bracket;
        if middle <= low || middle >= high {
            break;
        }
        let secant = (at_low * high - at_high * low) / (at_low - at_high);
        let towards = (middle - secant).signum();
        let shift = truncation * width * width;
        let moved = if shift <= (middle - secant).abs() { secant + towards * shift } else { middle };
        let reach = (allowance - 0.5 * width).max(0.0);
        allowance *= 0.5;
        let next = if (moved - middle).abs() <= reach { moved } else { middle - towards * reach };
        // Keeps the secant away from the ends in spite of round-off.
        let next = if next > low && next < high { next } else { middle };
        match f(next)? {
            found if found > 0.0 => bracket.low = (next, found),
            found if found < 0.0 => bracket.high = (next, found),
            _ => return Ok((next, bracket)),
        }
    }
    Ok((bracket.middle(), bracket))
}

/// Largest number of Newton steps and bisections for a fixed point.
const MOST_TRIALS: u32 = 100;

/// The fixed point of a return map between two places, at one of which it leads outward and at the other
/// inward, to a relative error of a tenth of `tolerance`: by Newton's method where that stays between, else
/// bisection. `map` returns whether it leads outward and, where the orbit returns, the next place and the
/// slope; and what else it finds, which is returned for the last place tried, which is that near.
pub fn fixed_point<T, E>(
    [mut low, mut high]: [f64; 2],
    low_outward: bool,
    tolerance: f64,
    mut map: impl FnMut(f64) -> Result<(bool, Option<[f64; 2]>, T), E>,
) -> Result<(f64, T), E> {
    let mut here = 0.5 * (low + high);
    let mut trial = 0;
    loop {
        let (outward, returns, found) = map(here)?;
        trial += 1;
        *(if outward == low_outward { &mut low } else { &mut high }) = here;
        let newton = returns.map_or(f64::NAN, |[next, slope]| here + (next - here) / (1.0 - slope));
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        let moved = (next - here).abs();
        here = next;
        if moved <= 0.1 * tolerance * here || next <= low || next >= high || trial == MOST_TRIALS {
            return Ok((here, found));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn smooth_functions_and_mere_signs_are_solved() {
        let root = 0.3_f64.sqrt();
        for sign_only in [false, true] {
            let mut calls = 0;
            let f = |x: f64| {
                calls += 1;
                let value = 0.3 - x * x;
                Ok::<f64, ()>(if sign_only { value.signum() } else { value })
            };
            let start = Bracket { low: (0.0, 0.3), high: (2.0, -3.7) };
            let (found, Bracket { low, high }) = falling_root(start, 1e-12, f).unwrap();
            assert!(low.0 <= root && root <= high.0 && calls < 45, "{low:?} {high:?} {calls}");
            assert!((found - root).abs() < 1e-12, "{found}");
        }
    }
}

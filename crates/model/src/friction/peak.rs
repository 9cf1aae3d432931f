//! Smoothed laws, such as `tanh(30*u)*(0.6 + 0.4*exp(-u))`: friction rises from 0 to a first peak, instead of holding at
//! rest. As written they have no rest: the rise is a viscous contact. Read with the rest at the peak, friction is that of
//! the peak from rest up to it, and beyond it the law as written: friction in steady slip beyond the peak stays the same.

use std::convert::Infallible;

use super::expression::{Expression, ExpressionError};
use super::table::{Table, TableError};
use crate::point::LawParameters;
use slipmap_numbers::roots::{Bracket, falling_root};

/// Slip speeds between which a peak is looked for, and their number per factor of two.
const OCTAVES: std::ops::Range<i32> = -40..20;
const PER_OCTAVE: i32 = 32;

impl Expression {
    /// The law with its rest at its first peak: the formula with `max(u, peak)` for u, divided by its value there.
    ///
    /// # Errors
    /// [`ExpressionError`] if the formula has parameters or eps, or no peak.
    pub fn with_rest_at_peak(&self) -> Result<Self, ExpressionError> {
        let error = |problem: String, remedy: &str| ExpressionError {
            from: 0,
            to: self.text().chars().count(),
            problem,
            remedy: remedy.to_owned(),
        };
        if !self.parameters().is_empty() || self.depends_on_epsilon() {
            return Err(error(
                "a law with its rest at the peak has no parameters and no eps".into(),
                "write numbers for them, or divide the law beyond the peak by hand",
            ));
        }
        let curve = self.curve(1.0, &LawParameters::new(&[]));
        let slope = |u: f64| -curve.weakening(u);
        let speed = |i: i32| 2_f64.powf(f64::from(i) / f64::from(PER_OCTAVE));
        let speeds: Vec<(f64, f64)> = (PER_OCTAVE * OCTAVES.start..=PER_OCTAVE * OCTAVES.end)
            .map(|i| (speed(i), slope(speed(i))))
            .collect();
        // Between the last speed where friction rises and the first one where it falls, a level part may lie.
        let falling = speeds.iter().position(|(_, slope)| *slope < 0.0).filter(|_| speeds[0].1 > 0.0);
        let around = falling.and_then(|falling| {
            let rising = speeds[..falling].iter().rposition(|(_, slope)| *slope > 0.0)?;
            Some(Bracket { low: speeds[rising], high: speeds[falling] })
        });
        let Some(bracket) = around else {
            return Err(error(
                "the friction does not rise from rest to a peak".into(),
                "leave out rest; friction that only rises has no stick-slip, and smoothed two coefficients are the law coulomb",
            ));
        };
        let found: Result<_, Infallible> = falling_root(bracket, 0.0, |u| Ok(slope(u)));
        let Ok((peak, _)) = found;
        let level = curve.phi(peak);
        let text = self.with_slip(|slip| format!("max({slip}, {peak:?})"));
        Self::new(&text, level * self.static_level())
            .map_err(|problem| error(problem.problem, &problem.remedy))
    }
}

impl Table {
    /// The table with its rest at its first peak: friction from rest up to it is that of the peak.
    ///
    /// # Errors
    /// [`TableError`] if friction does not rise from the first row to a peak.
    pub fn with_rest_at_peak(origin: &str, data: &[(f64, f64)]) -> Result<Self, TableError> {
        let peak = data.windows(2).position(|pair| pair[1].1 < pair[0].1).filter(|peak| *peak > 0);
        let Some(peak) = peak else {
            return Err(TableError {
                row: None,
                problem: "the friction does not rise from rest to a peak".into(),
                remedy: "leave out rest".into(),
            });
        };
        let rest = std::iter::once((0.0, data[peak].1));
        let rows: Vec<(f64, f64)> = rest.chain(data[peak..].iter().copied()).collect();
        Self::new(origin, &rows, data[peak].1)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Law;
    use super::*;

    /// A bow's law, whose peak is 1 at u = 1/sqrt(200).
    #[test]
    fn friction_is_that_of_the_peak_up_to_it_and_as_written_beyond() {
        let law = Expression::new("sqrt(200)*u*exp(-100*u^2 + 1/2)", 1.0).unwrap();
        let at_peak = law.with_rest_at_peak().unwrap();
        let peak = 200_f64.sqrt().recip();
        at_peak.check(1.0, &LawParameters::new(&[]), 2.0).unwrap();
        let law = Law::Expression(at_peak);
        assert_eq!(Law::from_definition(law.name(), &law.definition()), Some(law.clone()));
        let curve = law.curve(1.0, &LawParameters::new(&[]));
        assert!((curve.corners()[0] - peak).abs() < 1e-9);
        let (below, beyond) =
            (curve.weakening_range(0.0, 0.99 * peak), curve.weakening_range(0.0, 8.0 * peak));
        assert!(below.lo >= -1e-300 && below.hi <= 1e-300, "{below:?}");
        assert!(beyond.lo > -1e-12 && beyond.hi.is_finite(), "{beyond:?}");
        for (u, phi) in [
            (0.0, 1.0),
            (0.5 * peak, 1.0),
            (2.0 * peak, 2.0 * (-1.5_f64).exp()),
            (3.0 * peak, 3.0 * (-4.0_f64).exp()),
        ] {
            assert!((curve.phi(u) - phi).abs() < 1e-12, "{u}");
        }
        for (text, words) in
            [("tanh(u)", "to a peak"), ("1 - u/9", "to a peak"), ("a*u*exp(-u)", "no parameters")]
        {
            let error = Expression::new(text, 1.0).unwrap().with_rest_at_peak().unwrap_err();
            assert!(error.problem.contains(words), "{text}: {error}");
        }
    }

    /// A smoothing so steep that the peak is level to the last bit: a small peak far beyond it is not the first.
    #[test]
    fn a_level_peak_is_a_peak() {
        let beyond = "1 - 0.3*(1 + tanh((u - 1)/0.03))/2 + 0.2*exp(-((u - 5)/0.05)^2)";
        let smoothed = Expression::new(&format!("tanh(1e4*u)*({beyond})"), 1.0).unwrap();
        let [law, written] = [smoothed.with_rest_at_peak(), Expression::new(beyond, 1.0)]
            .map(|law| Law::Expression(law.unwrap()).curve(1.0, &LawParameters::new(&[])));
        for u in [0.0, 0.5, 0.9, 0.99, 1.0, 1.1, 3.0, 5.0] {
            assert!((law.phi(u) - written.phi(u)).abs() < 1e-12, "{u}");
        }
        let flat = Expression::new("tanh(1e4*u)", 1.0).unwrap();
        assert!(flat.with_rest_at_peak().is_err());
    }

    /// The corner is that of the slip speed, whose unit is another one; a kink is refused.
    #[test]
    fn max_of_slip_speed_and_a_number_has_a_corner() {
        let law = Expression::new("2 - exp(-(max(u, 0.5) - 0.5)^2)", 1.0).unwrap();
        let none = LawParameters::new(&[]);
        let in_units = law.in_units(4.0, 1.0);
        for law in [&in_units, &Expression::new(&in_units.text(), 1.0).unwrap()] {
            law.check(1.0, &none, 3.0).unwrap();
            let curve = Law::Expression(law.clone()).curve(1.0, &none);
            assert_eq!(curve.corners(), [0.125]);
            assert_eq!((curve.phi(0.1), curve.weakening(0.1)), (1.0, 0.0));
            assert_eq!(curve.weakening(0.25), -4.0 * (-0.25_f64).exp());
        }
        let kink = Expression::new("exp(-max(u, 0.5) + 0.5)", 1.0).unwrap();
        kink.check(1.0, &none, 0.4).unwrap();
        let error = kink.check(1.0, &none, 1.0).unwrap_err();
        assert!((error.from, error.to) == (5, 16) && error.problem.contains("a kink at u = 0.5"), "{error}");
    }
}

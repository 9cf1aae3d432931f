//! The weakening rate of a law over boxes of its parameters, enclosed: what proofs between the nodes of a map
//! need.

use super::Law;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::Jet;

/// A range of values, and the range of their derivatives along one direction.
pub type Slope = Jet<Interval, 2>;
/// The same, and the derivatives of both by the slip speed.
pub(super) type Series = Jet<Slope, 2>;

impl Law {
    /// phi at slip speed `u`, eps and parameters; `None` for laws that are no formulas.
    fn phi_at(&self, u: Series, epsilon: Series, parameters: &[Series]) -> Option<Series> {
        match self.as_written() {
            Law::Expression(law) => Some(law.phi_at(u, epsilon, parameters)),
            law => (law.built_in()?.phi_at)(u, epsilon, parameters),
        }
    }

    /// Returns whether boxes of parameters can be proved: the weakening rate has enclosures over them, and
    /// friction does not drop as slip begins.
    pub fn is_enclosed_over_boxes(&self) -> bool {
        !self.may_drop() && !matches!(self.as_written(), Law::Function(_) | Law::Custom(_))
    }

    /// Encloses the weakening rate -phi' and its derivative, where the slip speed `u` and `x`, eps and the
    /// law's parameters, change along one direction. Below u = 0 the weakening rate is that at rest; at
    /// corners the derivatives of both sides are enclosed. `None` where no bounds are known.
    pub fn weakening_over(&self, mut u: Slope, x: &[Slope]) -> Option<Slope> {
        if u.0[0].lo < 0.0 {
            u.0 = [u.0[0].at_least_zero(), u.0[1].hull(Interval::ZERO)];
        }
        let law = self.as_written();
        let rate = match law {
            Law::Table(table) => {
                let [value, slope] = table.rates(u.0[0])?;
                Jet([value, slope * u.0[1]])
            }
            _ => {
                // The weakening rate does not depend on the parameter of `with_drop`, which comes last.
                let own = law.parameters().len();
                let parameters: Vec<_> = x[1..=own].iter().map(|x| Series::of(*x)).collect();
                -self.phi_at(Jet::variable(u, 1.0), Jet::of(x[0]), &parameters)?.0[1]
            }
        };
        (rate.0[0].is_bounded() && rate.0[1].is_bounded()).then_some(rate)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Expression, Table};
    use super::*;
    use crate::point::LawParameters;
    use slipmap_numbers::jet::Real as _;
    use slipmap_numbers::random::Random;

    fn laws() -> Vec<(Law, Vec<[f64; 2]>)> {
        let formula = Expression::new("mu + (1-mu)*exp(-(u/vs)^2) + 0.1*epsilon*u", 1.0).unwrap();
        let table = Table::new("data", &[(0.0, 1.0), (0.3, 0.8), (1.0, 0.6), (2.0, 0.65)], 1.0).unwrap();
        vec![
            (Law::Stribeck, vec![[0.1, 0.2], [0.3, 0.4], [0.0, 0.2], [1.0, 3.0]]),
            (Law::Exponential, vec![[1.0, 1.0], [0.3, 0.4], [0.4, 0.5], [0.0, 0.1]]),
            (Law::Stretched, vec![[1.0, 1.0], [0.3, 0.4], [0.4, 0.5], [0.0, 0.1], [1.2, 1.3]]),
            (Law::Lorentzian.read_as_small(), vec![[1.0, 1.0], [0.3, 0.4], [0.4, 0.5], [0.0, 0.1]]),
            (Law::Expression(formula), vec![[0.1, 0.3], [0.3, 0.4], [0.4, 0.5]]),
            (Law::Table(table), vec![[0.5, 2.0]]),
        ]
    }

    /// The direction along which only the number `i` changes, with slope 1; the slip speed is number 0.
    fn along(i: usize, u: Interval, ranges: &[[f64; 2]]) -> (Slope, Vec<Slope>) {
        let number =
            |j: usize, range: Interval| if i == j { Jet::variable(range, 1.0) } else { Jet::of(range) };
        let x = ranges.iter().enumerate().map(|(j, [lo, hi])| number(j + 1, Interval::new(*lo, *hi)));
        (number(0, u), x.collect())
    }

    #[test]
    fn enclosures_hold_values_and_differences_inside() {
        let mut random = Random(7);
        let holds = |bounds: Interval, x: f64, slack: f64| bounds.lo - slack <= x && x <= bounds.hi + slack;
        for (law, ranges) in laws() {
            for _ in 0..100 {
                let (from, width) = (1.5 * random.unit(), 0.2 * random.unit());
                let u = Interval::new(from, from + width);
                let mut inside = |[lo, hi]: [f64; 2]| lo + random.unit() * (hi - lo);
                // Differences over 1e-6 have rounding errors of 1e-9.
                let h = 1e-6;
                let start = inside([u.lo, u.hi - h]);
                let at: Vec<f64> =
                    ranges.iter().map(|[lo, hi]| if lo < hi { inside([*lo, hi - h]) } else { *lo }).collect();
                let weakening =
                    |u: f64, at: &[f64]| law.curve(at[0], &LawParameters::new(&at[1..])).weakening(u);
                let here = weakening(start, &at);
                for i in (0..=ranges.len()).filter(|&i| i == 0 || ranges[i - 1][0] < ranges[i - 1][1]) {
                    let (u, x) = along(i, u, &ranges);
                    let Jet([value, slope]) = law.weakening_over(u, &x).unwrap();
                    assert!(holds(value, here, 1e-12), "{law:?} {u:?} {at:?}");
                    let (mut slip, mut moved) = (start, at.clone());
                    *(if i == 0 { &mut slip } else { &mut moved[i - 1] }) += h;
                    let difference = (weakening(slip, &moved) - here) / h;
                    assert!(holds(slope, difference, 1e-6), "{law:?} {i} {u:?} {difference} {slope:?}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_known_has_no_enclosure() {
        let (table, ranges) = laws().pop().unwrap();
        let (u, x) = along(0, Interval::new(1.9, 2.1), &ranges);
        assert!(table.weakening_over(u, &x).is_none());
        let root = Law::Expression(Expression::new("1 - 0.1*sqrt(u)", 1.0).unwrap());
        let of =
            |lo: f64| root.weakening_over(Jet::variable(Interval::new(lo, 0.2), 1.0), &[Jet::constant(1.0)]);
        assert!(of(0.0).is_none() && of(0.1).is_some());
        // Below rest the weakening rate is that at rest.
        let (u, x) = along(0, Interval::new(-0.2, 0.0), &[[1.0; 2], [0.5; 2], [0.5; 2], [0.0; 2]]);
        let Jet([value, slope]) = Law::Exponential.weakening_over(u, &x).unwrap();
        assert!(value.lo <= 1.0 && 1.0 <= value.hi && value.hi - value.lo < 1e-12 && slope.contains_zero());
    }
}

//! Friction over boxes of a law's parameters, enclosed: what proofs between the nodes of a map need.

use super::Law;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real as _};

/// Number of Taylor coefficients of friction along a curve.
pub const TERMS: usize = 13;
/// A range of values, and the ranges of their first two Taylor coefficients along a direction of parameters.
pub type Slope = Jet<Interval, 3>;
/// Taylor coefficients along a curve, each with those along a direction of parameters.
pub type Series = Jet<Slope, TERMS>;

impl Law {
    /// Returns whether friction is known over boxes of parameters: whether the law is a formula.
    pub fn is_enclosed_over_boxes(&self) -> bool {
        self.built_in().is_some() || matches!(self.as_written(), Law::Expression(_))
    }

    /// Friction in slip along a curve of slip speeds `u`, where eps and the law's parameters `x` change along
    /// a direction, up to a constant; `None` for laws that are no formulas.
    pub fn friction_along(&self, u: Series, x: &[Slope]) -> Option<Series> {
        let law = self.as_written();
        // The parameter of `with_drop`, which comes last, is such a constant.
        let own = law.parameters().len();
        let [epsilon, parameters @ ..] = x else { return None };
        let parameters: Vec<_> = parameters.get(..own)?.iter().map(|x| Series::of(*x)).collect();
        match law {
            Law::Expression(law) => Some(law.phi_at(u, Series::of(*epsilon), &parameters)),
            law => (law.built_in()?.phi_at)(u, Series::of(*epsilon), &parameters),
        }
    }

    /// The drop of friction as slip begins, where eps and the law's parameters `x` change along a direction.
    pub fn drop_over(&self, x: &[Slope]) -> Option<Slope> {
        let added = match x.last() {
            Some(last) if matches!(self.without_small(), Law::Dropping(_)) => *last,
            _ => Slope::constant(0.0),
        };
        if !self.as_written().may_drop() {
            return Some(added);
        }
        let rest = self.friction_along(Series::constant(0.0), x)?.0[0];
        Some(Slope::constant(1.0) - rest + added)
    }

    fn without_small(&self) -> &Law {
        if let Law::Small(law) = self { law } else { self }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Expression;
    use super::*;
    use crate::point::LawParameters;
    use slipmap_numbers::random::Random;

    /// The range and the derivatives along a straight line hold friction at random places of a box.
    #[test]
    fn enclosures_hold_values_and_differences_inside() {
        let formula = Expression::new("mu + (1-mu)*exp(-(u/vs)^2) + 0.1*epsilon*u", 1.0).unwrap();
        let laws = [
            (Law::Stribeck, vec![[0.1, 0.2], [0.3, 0.4], [0.0, 0.2], [1.0, 3.0]]),
            (Law::Exponential, vec![[1.0, 1.0], [0.3, 0.4], [0.4, 0.5], [0.0, 0.1]]),
            (Law::Stretched, vec![[1.0, 1.0], [0.3, 0.4], [0.4, 0.5], [0.0, 0.1], [1.2, 1.3]]),
            (Law::Lorentzian.read_as_small(), vec![[1.0, 1.0], [0.3, 0.4], [0.4, 0.5], [0.0, 0.1]]),
            (Law::Expression(formula), vec![[0.1, 0.3], [0.3, 0.4], [0.4, 0.5]]),
        ];
        let mut random = Random(7);
        let holds = |bounds: Interval, x: f64, slack: f64| bounds.lo - slack <= x && x <= bounds.hi + slack;
        for (law, ranges) in laws {
            for _ in 0..100 {
                let (from, width) = (0.05 + 1.5 * random.unit(), 0.2 * random.unit());
                let mut inside = |[lo, hi]: [f64; 2]| lo + random.unit() * (hi - lo);
                // Differences over 1e-6 have rounding errors of 1e-9.
                let h = 1e-6;
                let start = inside([from, from + width]);
                let at: Vec<f64> =
                    ranges.iter().map(|[lo, hi]| if lo < hi { inside([*lo, hi - h]) } else { *lo }).collect();
                let friction = |at: &[f64]| law.curve(at[0], &LawParameters::new(&at[1..])).phi(start);
                let weakening = law.curve(at[0], &LawParameters::new(&at[1..])).weakening(start);
                for i in (0..ranges.len()).filter(|&i| ranges[i][0] < ranges[i][1]) {
                    let x: Vec<Slope> = ranges
                        .iter()
                        .enumerate()
                        .map(|(j, [lo, hi])| {
                            let range = Interval::new(*lo, *hi);
                            if i == j { Jet::variable(range, 1.0) } else { Jet::of(range) }
                        })
                        .collect();
                    let u = Jet::variable(Slope::of(Interval::new(from, from + width)), 1.0);
                    let found = law.friction_along(u, &x).unwrap();
                    let mut moved = at.clone();
                    moved[i] += h;
                    let difference = (friction(&moved) - friction(&at)) / h;
                    assert!(holds(found.0[0].0[0], friction(&at), 1e-12), "{law:?} {at:?}");
                    assert!(holds(found.0[1].0[0], -weakening, 1e-12), "{law:?} {at:?}");
                    assert!(holds(found.0[0].0[1], difference, 1e-6), "{law:?} {i} {difference}");
                }
            }
        }
    }
}

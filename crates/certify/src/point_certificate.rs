//! Certificates of one point of any law: the curves that prove its verdict, in JSON text.
//!
//! [`PointCertificate::check`] trusts nothing: it compares the statement with that of the format, rebuilds
//! the law from its definition, and proves again that orbits cross each curve one way ([`super::curve`]).

use serde::{Deserialize, Serialize};

use super::certificate::Format;
use super::certificate::list::List;
use super::curve::{self, OneWay};
use super::{Claim, Decision};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::{MAX_LAW_PARAMETERS, Point};

/// Largest number of curves: one of each kind is enough.
const MOST_CURVES: usize = 3;

/// A certificate that has been parsed but not verified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PointCertificate {
    format: String,
    statement: String,
    written_by: String,
    law: String,
    law_definition: String,
    parameters: List<f64, MAX_LAW_PARAMETERS>,
    epsilon: f64,
    #[serde(rename = "V")]
    belt_speed: f64,
    #[serde(rename = "c")]
    damping: f64,
    /// The bounds of the critical damping that it claims.
    pub critical_c: [Option<f64>; 2],
    /// The verdict that it claims.
    pub verdict: String,
    curves: List<OneWay, MOST_CURVES>,
}

impl Format for PointCertificate {
    const NAME: &'static str = "slipmap proof of a point 2";
    const STATEMENT: &'static str = "With x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(|x2 - V|), friction up to 1 at \
        rest, and the friction law phi of the given name, definition and parameters in slip, plus a constant on each of its \
        pieces that makes it continuous and phi(0+) = 1 - j, j the drop of the law as slip begins, the orbit that leaves the exit point \
        (1 - epsilon c V, V) with x2' = -j comes back to the belt line (or runs away) for c < critical_c[0] and does not for \
        c > critical_c[1]; null claims nothing on its side. Verdict present: a stick-slip limit cycle exists at the given c. \
        Absent: none exists. Undecided: nothing is claimed of that. Each of the curves consists of Bezier polynomials with control \
        points (V - x2, x2'), run clockwise, which orbits at epsilon c = viscous cross one way: outwards if it returns, \
        inwards if it is absent or lands. A curve that returns proves that the orbit comes back or runs away at epsilon c <= \
        viscous; one that is absent, that it does not come back at epsilon c >= viscous; one that lands, that it is bounded, and \
        sticks if it comes back, at epsilon c >= viscous.";

    fn head(&self) -> [&str; 2] {
        [&self.format, &self.statement]
    }
}

impl PointCertificate {
    /// Certifies what curves prove of a point, written by this program.
    pub fn of(law: &Law, point: &Point, written_by: &str) -> Self {
        let column = law.column(point);
        let proof = curve::prove(&column);
        let claim = proof.claim(&column);
        Self {
            format: Self::NAME.into(),
            statement: Self::STATEMENT.into(),
            written_by: written_by.into(),
            law: law.name().into(),
            law_definition: law.definition(),
            parameters: point.law.as_slice().iter().copied().collect(),
            epsilon: point.epsilon,
            belt_speed: point.belt_speed,
            damping: point.damping,
            critical_c: critical(&claim),
            verdict: claim.decide(point.damping).name().into(),
            curves: proof.curves.into_iter().collect(),
        }
    }

    /// Proves every claim again; returns the problems, none if the certificate is sound.
    #[must_use]
    pub fn check(&self) -> Vec<String> {
        let mut problems = self.other_statement();
        let Some(law) = Law::from_definition(&self.law, &self.law_definition) else {
            return vec!["its friction law does not exist".into()];
        };
        let point = match law.point(self.epsilon, &self.parameters, self.belt_speed, self.damping) {
            Ok(point) => point,
            Err(error) => return vec![format!("its point is not one of the law: {error}")],
        };
        if let Law::Expression(formula) = law.as_written()
            && let Err(error) = formula.check(point.epsilon, &point.law, 2.0 * point.belt_speed)
        {
            return vec![format!("its formula is no friction law: {}", error.problem)];
        }
        let column = law.column(&point);
        let claim = self.proved(&column, &mut problems);
        let [below, above] = critical(&claim);
        let follows = |claimed: Option<f64>, proved: Option<f64>, order: fn(&f64, &f64) -> bool| {
            claimed.is_none_or(|claimed| proved.is_some_and(|proved| order(&claimed, &proved)))
        };
        let [lo, hi] = self.critical_c;
        if !(follows(lo, below, f64::le) && follows(hi, above, f64::ge)) {
            let [below, above] = [below, above].map(|c| c.map_or("unknown".into(), |c| c.to_string()));
            problems.push(format!("the critical damping is proved to lie in {below} to {above} only"));
        }
        let proved = claim.decide(point.damping).name();
        if self.verdict != proved && self.verdict != Decision::Undecided.name() {
            problems.push(format!("the verdict that is proved is {proved}"));
        }
        problems
    }

    /// The claim that its curves prove, and the problems of those that prove nothing.
    fn proved(&self, column: &Column, problems: &mut Vec<String>) -> Claim {
        if !column.curve.is_normal() {
            return Claim::NOTHING;
        }
        let mut sound = Vec::new();
        for (number, curve) in (1..).zip(self.curves.iter()) {
            match curve.check(column) {
                Ok(_) => sound.push(curve.clone()),
                Err(fault) => problems.push(format!("curve {number} is no proof: {fault}")),
            }
        }
        curve::claim(column, &sound)
    }
}

/// The bounds of the critical damping in a claim.
fn critical(claim: &Claim) -> [Option<f64>; 2] {
    [claim.present_below, claim.absent_above].map(|c| c.is_finite().then_some(c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::Expression;

    fn of(law: &Law, epsilon: f64, parameters: &[f64], belt_speed: f64, c: f64) -> PointCertificate {
        PointCertificate::of(law, &law.point(epsilon, parameters, belt_speed, c).unwrap(), "a program")
    }

    #[test]
    fn altered_certificates_are_refused_unless_true() {
        let one = of(&Law::Stribeck, 0.1, &[0.3, 0.1, 2.0], 1.0, 0.5);
        let [lo, hi] = one.critical_c;
        let wider = PointCertificate { critical_c: [lo.map(|c| c - 0.1), None], ..one.clone() };
        assert_eq!(wider.check(), Vec::<String>::new());
        let mut fewer = one.clone();
        fewer.curves.pop();
        for forged in [
            PointCertificate { verdict: "absent".into(), ..one.clone() },
            PointCertificate { verdict: "Present".into(), ..one.clone() },
            PointCertificate { damping: 3.0, ..one.clone() },
            PointCertificate { damping: f64::NAN, ..one.clone() },
            PointCertificate { damping: -1.0, ..one.clone() },
            PointCertificate { belt_speed: -1.0, ..one.clone() },
            PointCertificate { epsilon: 0.0, ..one.clone() },
            PointCertificate { critical_c: [lo.map(f64::next_up), hi], ..one.clone() },
            PointCertificate { critical_c: [lo, hi.map(f64::next_down)], ..one.clone() },
            PointCertificate { critical_c: [lo, Some(f64::NAN)], ..one.clone() },
            PointCertificate { law: "exponential".into(), ..one.clone() },
            PointCertificate { law: "none".into(), ..one.clone() },
            PointCertificate { law_definition: "phi = 1 + u for ever".into(), ..one.clone() },
            PointCertificate { parameters: [0.3, 0.1].into_iter().collect(), ..one.clone() },
            PointCertificate { parameters: [0.3, 0.1, 0.5].into_iter().collect(), ..one.clone() },
            PointCertificate { statement: one.statement.replace("does not", "does"), ..one.clone() },
            PointCertificate { curves: std::iter::empty().collect(), ..one.clone() },
            fewer,
        ] {
            assert_ne!(forged.check(), Vec::<String>::new(), "{forged:?}");
        }
    }

    /// The same friction in slip with friction at rest above it is another law: a claim about one is refused
    /// for the other.
    #[test]
    fn a_claim_that_ignores_the_drop_is_refused() {
        let flat = Law::Expression(Expression::new("1 - s*tanh(u)", 1.0).unwrap());
        let dropping = Law::Expression(Expression::with_static("0.7 - s*tanh(u)", 1.0).unwrap());
        let [[_, Some(above)], [Some(below), _]] =
            [&flat, &dropping].map(|law| of(law, 1.0, &[0.2], 1.0, 0.0).critical_c)
        else {
            panic!("both are enclosed");
        };
        let [without, with] = [&flat, &dropping].map(|law| of(law, 1.0, &[0.2], 1.0, 0.5 * (above + below)));
        assert_eq!((without.verdict.as_str(), with.verdict.as_str()), ("absent", "present"));
        for one in [&without, &with] {
            assert_eq!(one.check(), Vec::<String>::new());
        }
        let definition = |one: &PointCertificate| one.law_definition.clone();
        for forged in [
            PointCertificate { law_definition: definition(&with), ..without.clone() },
            PointCertificate { law_definition: definition(&without), ..with.clone() },
            PointCertificate { curves: without.curves.clone(), ..with.clone() },
            PointCertificate { critical_c: without.critical_c, ..with.clone() },
        ] {
            assert_ne!(forged.check(), Vec::<String>::new(), "{forged:?}");
        }
        let box_of = [[1.0, 1.0], [0.2, 0.21], [0.0, 0.1], [1.0, 1.01]];
        let law = flat.with_drop();
        assert!(!law.is_enclosed_over_boxes());
        assert!(crate::validated::barrier::Tile::prove(&law, &box_of).is_none());
    }

    /// From slow belts the orbit reaches slip speeds of many times the belt's before it lands.
    #[test]
    fn the_landing_is_proved_from_slow_belts() {
        let law =
            Law::Expression(Expression::with_static("0.7*(1 - 0.4*tanh(3*u) + 0.01*u^2)", 0.8).unwrap());
        let one = of(&law, 1.0, &[], 0.12, 0.001);
        assert_eq!((one.verdict.as_str(), one.check()), ("present", Vec::new()));
    }
}

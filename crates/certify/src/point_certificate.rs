//! Certificates of one point of any law: text with the statements that `validated` proves about the point,
//! which the same prover can prove again; there is no second argument.
//!
//! [`PointCertificate::check`] trusts nothing: it compares the statement with that of the format, rebuilds
//! the law from its definition, and proves every claim about the point again.

use serde::{Deserialize, Serialize};

use super::certificate::Format;
use super::certificate::list::List;
use super::{Claim, Decision, validated};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::{MAX_LAW_PARAMETERS, Point};

/// The statement where friction drops as slip begins.
const STATEMENT_WITH_DROP: &str = "With x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(|x2 - V|), friction up to 1 at \
    rest, and the friction law phi of the given name, definition and parameters in slip, plus a constant on each of its pieces \
    that makes it continuous and phi(0+) = 1 - j, j the drop of the law in double precision, the orbit that leaves \
    the exit point (1 - epsilon c V, V) with x2' = -j comes back to the belt line (or runs away) for c < critical_c[0] and does \
    not for c > critical_c[1]; null claims nothing on its side. Verdict present: a stick-slip limit cycle exists at the given \
    c. Absent: none exists. Undecided: nothing is claimed of that.";

fn statement(column: &Column) -> &'static str {
    if column.curve.drop() > 0.0 { STATEMENT_WITH_DROP } else { PointCertificate::STATEMENT }
}

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
}

impl Format for PointCertificate {
    const NAME: &'static str = "slipmap proof of a point 1";
    const STATEMENT: &'static str = "With x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(|x2 - V|) and the \
        friction law phi of the given name, definition and parameters, plus a constant on each of its pieces that makes it \
        continuous and phi(0) = 1, the orbit from the exit point (1 - epsilon c V, V) comes back to the belt line (or runs \
        away) for c < critical_c[0] and does not for c > critical_c[1]; null claims nothing on its side. Verdict present: a \
        stick-slip limit cycle exists at the given c. Absent: none exists. Undecided: nothing is claimed of that.";

    fn head(&self) -> [&str; 2] {
        [&self.format, &self.statement]
    }
}

impl PointCertificate {
    /// Certifies the statements that `validated` proves of a point, written by this program.
    pub fn of(law: &Law, point: &Point, written_by: &str) -> Self {
        let column = law.column(point);
        let claim = validated::TEST.claim(&column);
        Self {
            format: Self::NAME.into(),
            statement: statement(&column).into(),
            written_by: written_by.into(),
            law: law.name().into(),
            law_definition: law.definition(),
            parameters: point.law.as_slice().iter().copied().collect(),
            epsilon: point.epsilon,
            belt_speed: point.belt_speed,
            damping: point.damping,
            critical_c: critical(&claim),
            verdict: claim.decide(point.damping).name().into(),
        }
    }

    /// Proves every claim again; returns the problems, none if the certificate is sound.
    #[must_use]
    pub fn check(&self) -> Vec<String> {
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
        let mut problems = Vec::new();
        if self.statement != statement(&column) {
            problems.push("its statement is not the one that this format proves".into());
        }
        let claim = validated::TEST.claim(&column);
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
        ] {
            assert_ne!(forged.check(), Vec::<String>::new(), "{forged:?}");
        }
    }

    /// The same friction in slip with friction at rest above it is another law: a claim about one is refused for
    /// the other.
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
            PointCertificate { statement: without.statement.clone(), ..with.clone() },
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

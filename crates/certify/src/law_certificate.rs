//! Certificates of the critical damping of any law over a box of parameters: JSON text that the
//! same prover can prove again; there is no second argument.
//!
//! [`LawCertificate::check`] trusts nothing: it compares the statement with that of the format, rebuilds the
//! law from its definition, checks that the boxes divide the domain, and proves every claim again.

use serde::{Deserialize, Serialize};

use super::certificate::list::List;
use super::certificate::{Checked, Format, MOST_BOXES};
use super::validated::barrier::Tile;
use super::validated::law_boxes::LawProof;
use slipmap_model::friction::Law;
use slipmap_model::point::{LawParameters, MAX_LAW_PARAMETERS};
use slipmap_numbers::interval::Interval;

/// A certificate that has been parsed but not verified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LawCertificate {
    format: String,
    statement: String,
    written_by: String,
    law: String,
    law_definition: String,
    /// The names of the axes: epsilon, the law's parameters, V.
    pub axes: List<String, MOST_AXES>,
    /// The parameters that it speaks of.
    pub domain: Ranges,
    open: List<Ranges, MOST_BOXES>,
    tiles: List<Claim, MOST_BOXES>,
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Claim {
    domain: Ranges,
    viscous: f64,
    slopes: List<f64, MOST_AXES>,
    radius: f64,
}

/// Largest number of axes: epsilon, the law's parameters, V.
const MOST_AXES: usize = MAX_LAW_PARAMETERS + 2;
/// Ranges along the axes.
type Ranges = List<[f64; 2], MOST_AXES>;

/// The names of the axes of a law's boxes.
fn axes(law: &Law) -> List<String, MOST_AXES> {
    let own = law.parameters().iter().map(|parameter| parameter.name);
    std::iter::once("epsilon").chain(own).chain(["V"]).map(str::to_owned).collect()
}

impl Format for LawCertificate {
    const NAME: &'static str = "slipmap proof of a law 1";
    const STATEMENT: &'static str = "With x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(|x2 - V|) and the \
        friction law phi of the given name and definition, the orbit from the exit point (1 - epsilon c V, V) comes back to \
        the belt line (or runs away) for epsilon c < C* and not for epsilon c > C*. For all epsilon, parameters of the law \
        and V in the domain of a tile at which phi(0) is 1 up to rounding, which a constant takes out, \
        |C* - (viscous + sum of slopes[i] z[i])| <= radius, z[i] running from -1 to 1 along axis i of the domain. In the \
        boxes `open` nothing is claimed.";

    fn head(&self) -> [&str; 2] {
        [&self.format, &self.statement]
    }
}

impl LawCertificate {
    /// The certificate of a proof, written by this program.
    pub fn of(proof: &LawProof, written_by: &str) -> Self {
        let claim = |tile: &Tile| Claim {
            domain: tile.ranges.iter().copied().collect(),
            viscous: tile.viscous,
            slopes: tile.slopes.iter().copied().collect(),
            radius: tile.radius,
        };
        Self {
            format: Self::NAME.into(),
            statement: Self::STATEMENT.into(),
            written_by: written_by.into(),
            law: proof.law.name().into(),
            law_definition: proof.law.definition(),
            axes: axes(&proof.law),
            domain: proof.ranges.iter().copied().collect(),
            open: proof.open().map(|one| one.iter().copied().collect()).collect(),
            tiles: proof.tiles().map(claim).collect(),
        }
    }

    /// Proves every claim again.
    pub fn check(&self) -> Checked {
        let mut problems = self.other_statement();
        let law = Law::from_definition(&self.law, &self.law_definition).filter(Law::is_enclosed_over_boxes);
        let law = match law {
            Some(law) if axes(&law) == self.axes && law.admits_box(&self.domain) => law,
            other => {
                problems.push(match other {
                    None => "its friction law does not exist".into(),
                    Some(_) => "its domain is not a box of parameters of the law".into(),
                });
                let [largest_radius, mean_radius] = [f64::INFINITY; 2];
                let tiles = self.tiles.len();
                return Checked {
                    tiles,
                    confirmed: 0,
                    largest_radius,
                    mean_radius,
                    open_share: 1.0,
                    problems,
                };
            }
        };
        let stated = |claim: &Claim| (claim.domain.clone(), claim.radius);
        let doubt = |claim: &Claim| claim.doubt(&law).map(|doubt| format!("({:?}) {doubt}", claim.domain));
        Checked::tiles(problems, &self.domain, &self.tiles, stated, self.open.iter().cloned(), doubt)
    }
}

impl Claim {
    /// The reason why the claim is not confirmed; `None` if it follows from what is proved anew.
    fn doubt(&self, law: &Law) -> Option<String> {
        if !law.admits_box(&self.domain) {
            return Some("is about no parameters of the law".into());
        }
        if let Law::Expression(formula) = law.as_written() {
            let middle: Vec<f64> = self.domain.iter().map(|[lo, hi]| lo + 0.5 * (hi - lo)).collect();
            let [epsilon, parameters @ .., belt_speed] = middle.as_slice() else { return None };
            let checked = formula.check(*epsilon, &LawParameters::new(parameters), 2.0 * belt_speed);
            if let Err(error) = checked {
                return Some(format!("is about no friction law: {}", error.problem));
            }
        }
        let Some(proved) = Tile::prove(law, &self.domain) else {
            return Some("claims what is not proved".into());
        };
        let apart = |one: f64, two: f64| (Interval::of(one) - Interval::of(two)).size();
        let slopes = self.slopes.iter().zip(&proved.slopes);
        let distance = slopes.fold(
            Interval::of(proved.radius) + Interval::of(apart(self.viscous, proved.viscous)),
            |sum, (one, two)| sum + Interval::of(apart(*one, *two)),
        );
        // What is proved is less than the proved radius by a thousand times this tolerance, see `Tile::prove`.
        let follows = self.slopes.len() == proved.slopes.len() && distance.hi <= self.radius * (1.0 + 1e-9);
        (!follows).then(|| format!("claims a radius of {:e}, and {:e} is proved", self.radius, distance.hi))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::Expression;

    fn honest() -> LawCertificate {
        let law = Law::Expression(Expression::new("mu + (1-mu)*exp(-u)", 1.0).unwrap());
        let mut proof = LawProof::new(&law, vec![[1.0, 1.0], [0.6, 0.7], [1.0, 1.2]], [0.0, 0.3]);
        proof.refine(40, &|| true);
        LawCertificate::of(&proof, "a program")
    }

    #[test]
    fn altered_certificates_are_refused() {
        let one = honest();
        let Checked { tiles, confirmed, open_share, problems, .. } = one.check();
        assert_eq!((confirmed, problems), (tiles, Vec::new()));
        assert!(tiles > 10 && open_share < 0.5, "{tiles} {open_share}");
        // A weaker claim follows from a stronger one.
        let mut wider = one.clone();
        wider.tiles[0].viscous += 0.5 * wider.tiles[0].radius;
        wider.tiles[0].radius *= 2.0;
        assert_eq!(wider.check().problems, Vec::<String>::new());
        let altered = |change: &dyn Fn(&mut LawCertificate)| {
            let mut other = one.clone();
            change(&mut other);
            other
        };
        let forged = [
            altered(&|it| it.tiles[0].radius *= 0.5),
            altered(&|it| it.tiles[0].viscous += 1e-3),
            altered(&|it| it.tiles[0].slopes[1] += 1e-3),
            altered(&|it| it.tiles[0].slopes.clear()),
            altered(&|it| it.tiles[0].radius = f64::NAN),
            altered(&|it| drop(it.tiles.pop())),
            altered(&|it| it.open.push(it.tiles[0].domain.clone())),
            altered(&|it| it.domain[1] = [0.5, 0.7]),
            altered(&|it| it.domain[0] = [-1.0, -1.0]),
            altered(&|it| it.axes.swap(0, 1)),
            altered(&|it| it.law = "exponential".into()),
            altered(&|it| it.law_definition = it.law_definition.replace("exp(-u)", "exp(-2*u)")),
            altered(&|it| it.law_definition.push(')')),
            altered(&|it| it.law_definition.push_str("-0.9*((1e16+1)-1e16)+0.9")),
            altered(&|it| it.statement = it.statement.replace("not for", "for")),
        ];
        for other in forged {
            assert_ne!(other.check().problems, Vec::<String>::new(), "{other:?}");
        }
    }
}

//! Certificates: the curves that prove a point, columns, or a box of parameters, in JSON text. One format for all.
//!
//! A certificate may come from anybody, so it proves nothing until it is checked. [`Certificate::check`] trusts nothing: it
//! compares the statement with that of the format, rebuilds the law from its definition, and proves again that orbits cross
//! each curve one way ([`super::curve`]). `written_by` records where a certificate comes from and is not verified. Parts of a
//! box are told by cuts, so that they cannot overlap or leave gaps.
//!
//! Numbers mean the nearest doubles. The values count, not the bytes: another program may have written the text again, with
//! its own order of keys and spaces.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::Decision;
use super::curve::{self, BoxProof, MOST_AXES, OneWay, Region, Shares};
use list::List;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_numbers::interval::Interval;

pub(super) mod list;

const FORMAT: &str = "slipmap proof 3";
const STATEMENT: &str = "With x1' = x2, x2' = -x1 - epsilon c x2 - sign(x2 - V) phi(|x2 - V|), friction up to 1 at rest, and \
    the friction law phi of the given name and definition in slip, plus a constant on each of its pieces that makes it \
    continuous and phi(0+) = 1 - j, j the drop of the law as slip begins: of the points of each part, its domain, the ranges \
    of the axes, times its range of c, a stick-slip limit cycle exists in a share of at least `present`, and none in a share \
    of at least `absent`. A range of one value counts as a whole. A proof cuts its domain at a place of an axis, into a part \
    below and one above, or consists of curves. Damping c and control points (V - x2, x2') of a curve are those \
    given plus z[i] times those along axis i of the axes on which its domain is wide, where z[i] runs from -1 to 1; \
    control points then times V over that in the middle. Each curve \
    consists of Bezier polynomials, run clockwise, which orbits at its damping cross one way: outwards if it returns, inwards \
    if it is absent or lands. A curve that returns proves that the orbit from the exit point (1 - epsilon c V, V) with x2' = -j \
    comes back to the belt line (or runs away) at its damping and below; one that is absent, that it does not come back at its \
    damping and above; one that lands, that it is bounded, and sticks if it comes back, at its damping and above.";

/// Largest number of parts.
const MOST_PARTS: usize = 1 << 20;
/// Largest number of curves of a box: one of each kind is enough.
const MOST_CURVES: usize = 3;
/// Largest number of cuts, one inside the other.
pub(super) const MOST_CUTS: usize = 40;

/// A certificate that has been parsed but not verified.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Certificate {
    format: String,
    statement: String,
    written_by: String,
    law: String,
    law_definition: String,
    /// The names of the axes of domains: epsilon, the law's parameters, V.
    pub axes: List<String, MOST_AXES>,
    /// What is proved.
    pub parts: List<Part, MOST_PARTS>,
}

/// What a certificate claims of a box of parameters, or of a point.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Ranges of the axes.
    pub domain: List<[f64; 2], MOST_AXES>,
    /// The range of the damping.
    pub c: [f64; 2],
    /// The share in which the cycle exists, at least.
    pub present: f64,
    /// The share in which it does not, at least.
    pub absent: f64,
    proof: Node,
}

/// A proof of a box: a cut, or curves.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Node {
    #[serde(default, skip_serializing_if = "Option::is_none")]
    cut: Option<Box<Cut>>,
    #[serde(default, skip_serializing_if = "is_empty")]
    curves: List<OneWay, MOST_CURVES>,
}

fn is_empty(curves: &List<OneWay, MOST_CURVES>) -> bool {
    curves.is_empty()
}

#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Cut {
    axis: String,
    at: f64,
    below: Node,
    above: Node,
}

/// A box that is not cut.
struct Leaf<'a> {
    ranges: Vec<[f64; 2]>,
    /// Its share of the part's volume.
    share: Interval,
    curves: &'a [OneWay],
}

impl Node {
    pub(super) fn proved(curves: &[OneWay]) -> Self {
        Self { cut: None, curves: curves.iter().cloned().collect() }
    }

    pub(super) fn cut(axis: &str, at: f64, [below, above]: [Node; 2]) -> Self {
        Self {
            cut: Some(Box::new(Cut { axis: axis.into(), at, below, above })),
            curves: std::iter::empty().collect(),
        }
    }

    /// The boxes that it does not cut; `None` where a cut is outside its box.
    fn leaves(&self, domain: &[[f64; 2]], law: &Law) -> Option<Vec<Leaf<'_>>> {
        let mut leaves = Vec::new();
        self.collect(domain.to_vec(), Interval::ONE, &law.axis_names(), MOST_CUTS, &mut leaves)?;
        Some(leaves)
    }

    fn collect<'a>(
        &'a self,
        ranges: Vec<[f64; 2]>,
        share: Interval,
        axes: &[&str],
        cuts: usize,
        leaves: &mut Vec<Leaf<'a>>,
    ) -> Option<()> {
        let Some(cut) = &self.cut else {
            leaves.push(Leaf { ranges, share, curves: &self.curves });
            return Some(());
        };
        let Cut { axis, at, below, above } = cut.as_ref();
        let axis = axes.iter().position(|name| name == axis)?;
        let [lo, hi] = *ranges.get(axis)?;
        if !(lo < *at && *at < hi) || cuts == 0 || !self.curves.is_empty() {
            return None;
        }
        let [from, to, between] = [lo, hi, *at].map(Interval::of);
        for (node, range, width) in [(below, [lo, *at], between - from), (above, [*at, hi], to - between)] {
            let mut half = ranges.clone();
            half[axis] = range;
            node.collect(half, share * width.over(to - from), axes, cuts - 1, leaves)?;
        }
        Some(())
    }

    /// The shares of a box that its curves prove, if each of them proves what it claims.
    pub(super) fn shares(&self, domain: &[[f64; 2]], law: &Law, damping: [f64; 2]) -> Shares {
        let leaves = self.leaves(domain, law).unwrap_or_default();
        summed(leaves.iter().map(|leaf| (leaf.share, Shares::of(leaf.curves, damping))))
    }
}

/// Shares of boxes, added up.
fn summed(all: impl Iterator<Item = (Interval, Shares)>) -> Shares {
    // A part that is not cut is the whole, exactly.
    let of = |share: Interval, of: f64| {
        if share == Interval::ONE { Interval::of(of) } else { share * Interval::of(of) }
    };
    let [present, absent] = all
        .fold([Interval::ZERO; 2], |[present, absent], (share, shares)| {
            [present + of(share, shares.present), absent + of(share, shares.absent)]
        })
        .map(|sum| sum.lo.clamp(0.0, 1.0));
    Shares { present, absent }
}

/// Reason why a text is not a certificate.
#[derive(Debug, thiserror::Error)]
pub enum NoCertificate {
    /// The text is not JSON, or has other keys or values than a certificate.
    #[error("is not a proof: {0}")]
    Malformed(#[from] serde_json::Error),
    /// The certificate has another version of the format.
    #[error("is a proof of another format: {0}")]
    OtherFormat(String),
}

/// The result of a check.
#[derive(Clone, Debug, PartialEq)]
pub struct Checked {
    /// Number of boxes and points.
    pub boxes: usize,
    /// What is proved of each part.
    pub parts: Vec<Shares>,
    /// All problems; the certificate is sound if there are none.
    pub problems: Vec<String>,
}

impl Certificate {
    fn about(law: &Law, parts: impl Iterator<Item = Part>, written_by: &str) -> Self {
        let mut axes = law.axis_names();
        axes.pop();
        Self {
            format: FORMAT.into(),
            statement: STATEMENT.into(),
            written_by: written_by.into(),
            law: law.name().into(),
            law_definition: law.definition(),
            axes: axes.into_iter().map(str::to_owned).collect(),
            parts: parts.collect(),
        }
    }

    /// Certifies what curves prove of points, each at a range of dampings.
    #[must_use]
    pub fn of_columns(law: &Law, columns: &[(Point, [f64; 2])], written_by: &str) -> Self {
        let part = |(point, c): &(Point, [f64; 2])| {
            let curves = curve::prove(&law.column(point)).curves;
            let Shares { present, absent } = Shares::of(&curves, *c);
            Part { domain: ranges(law, point), c: *c, present, absent, proof: Node::proved(&curves) }
        };
        let parts: Vec<Part> = columns.par_iter().map(part).collect();
        Self::about(law, parts.into_iter(), written_by)
    }

    /// Certifies what curves prove of a point.
    #[must_use]
    pub fn of_point(law: &Law, point: &Point, written_by: &str) -> Self {
        Self::of_columns(law, &[(*point, [point.damping; 2])], written_by)
    }

    /// Certifies what is proved of a box.
    #[must_use]
    pub fn of_box(proof: &BoxProof, written_by: &str) -> Self {
        let Shares { present, absent } = proof.shares();
        let domain = proof.ranges.iter().copied().collect();
        let part = Part { domain, c: proof.damping, present, absent, proof: proof.node() };
        Self::about(&proof.law, std::iter::once(part), written_by)
    }

    /// Parses a certificate without verifying its claims.
    ///
    /// # Errors
    /// [`NoCertificate`].
    pub fn parse(text: &str) -> Result<Self, NoCertificate> {
        #[derive(Deserialize)]
        struct Named {
            format: String,
        }
        let Named { format } = serde_json::from_str(text)?;
        if format != FORMAT {
            return Err(NoCertificate::OtherFormat(format));
        }
        Ok(serde_json::from_str(text)?)
    }

    /// Its JSON text, with one line per curve so that differences can be read.
    ///
    /// # Errors
    /// None is known: the numbers of a certificate are finite.
    pub fn text(&self) -> serde_json::Result<String> {
        Ok(serde_json::to_string(self)?.replace("{\"kind\"", "\n{\"kind\"") + "\n")
    }

    /// Proves every claim again.
    #[must_use]
    pub fn check(&self) -> Checked {
        let mut problems = Vec::new();
        if self.statement != STATEMENT {
            problems.push("its statement is not the one that this format proves".into());
        }
        let law = Law::from_definition(&self.law, &self.law_definition);
        let Some(law) = law.filter(|law| law.axis_names().iter().zip(self.axes.iter()).all(|(a, b)| a == b))
        else {
            problems.push("its friction law, with these axes, does not exist".into());
            return Checked { boxes: 0, parts: Vec::new(), problems };
        };
        let checked: Vec<_> = self.parts.par_iter().map(|part| part.check(&law)).collect();
        let mut boxes = 0;
        let mut parts = Vec::new();
        for (number, (count, shares, found)) in (1..).zip(checked) {
            boxes += count;
            parts.push(shares);
            let named =
                |problem| if self.parts.len() > 1 { format!("part {number}: {problem}") } else { problem };
            problems.extend(found.into_iter().map(named));
        }
        Checked { boxes, parts, problems }
    }
}

/// The ranges of a point.
fn ranges(law: &Law, point: &Point) -> List<[f64; 2], MOST_AXES> {
    let mut at = law.coordinates(point);
    at.pop();
    at.into_iter().map(|(_, x)| [x; 2]).collect()
}

impl Part {
    /// The enclosure of c* that the curves of a point claim; `None` for boxes.
    #[must_use]
    pub fn critical(&self) -> Option<[f64; 2]> {
        let is_point = self.domain.iter().all(|[lo, hi]| lo == hi) && self.proof.cut.is_none();
        let claim = curve::claim(&self.proof.curves);
        is_point.then_some([claim.present_below, claim.absent_above])
    }

    /// The decision about a point; `None` for boxes and for several dampings.
    #[must_use]
    pub fn decision(&self) -> Option<Decision> {
        self.critical().filter(|_| self.c[0] == self.c[1])?;
        Some(match [self.present, self.absent] {
            [1.0, _] => Decision::Present,
            [_, 1.0] => Decision::Absent,
            _ => Decision::Undecided,
        })
    }

    /// Proves it again: the number of boxes, the shares that are proved, and the problems.
    fn check(&self, law: &Law) -> (usize, Shares, Vec<String>) {
        let nothing = Shares { present: 0.0, absent: 0.0 };
        let problem = |text: &str| (0, nothing, vec![text.to_owned()]);
        let [lo, hi] = self.c;
        if !(law.admits_box(&self.domain) && lo >= 0.0 && lo <= hi && hi.is_finite()) {
            return problem("its domain is not a box of parameters of the law");
        }
        let Some(leaves) = self.proof.leaves(&self.domain, law) else {
            return problem("a cut does not divide its box");
        };
        let checked: Vec<(Shares, Option<String>)> = leaves
            .par_iter()
            .map(|leaf| match leaf.check(law) {
                Ok(()) => (Shares::of(leaf.curves, self.c), None),
                Err(why) => (nothing, Some(why)),
            })
            .collect();
        let named = |(i, why): (usize, &String)| {
            if leaves.len() > 1 { format!("box {}: {why}", i + 1) } else { why.clone() }
        };
        let doubts = checked.iter().enumerate().filter_map(|(i, (_, why))| Some((i, why.as_ref()?)));
        let mut problems: Vec<String> = doubts.map(named).collect();
        let proved = summed(leaves.iter().zip(&checked).map(|(leaf, (shares, _))| (leaf.share, *shares)));
        for (what, claimed, proved) in
            [("present", self.present, proved.present), ("absent", self.absent, proved.absent)]
        {
            if !(claimed <= proved) {
                problems
                    .push(format!("the share {what} is proved to be at least {proved} only, not {claimed}"));
            }
        }
        (leaves.len(), proved, problems)
    }
}

impl Leaf<'_> {
    /// Proves its curves again.
    fn check(&self, law: &Law) -> Result<(), String> {
        if self.curves.is_empty() {
            return Ok(());
        }
        let region = Region::new(law, &self.ranges).map_err(|why| why.to_string())?;
        for (number, one) in (1..).zip(self.curves) {
            region.check(one).map_err(|fault| format!("curve {number} is no proof: {fault}"))?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::Expression;

    fn of(law: &Law, epsilon: f64, parameters: &[f64], belt_speed: f64, c: f64) -> Certificate {
        Certificate::of_point(law, &law.point(epsilon, parameters, belt_speed, c).unwrap(), "a program")
    }

    fn decision(certificate: &Certificate) -> Option<Decision> {
        certificate.parts[0].decision()
    }

    /// The same friction in slip with friction at rest above it is another law: a claim about one is refused
    /// for the other.
    #[test]
    fn a_claim_that_ignores_the_drop_is_refused() {
        let flat = Law::Expression(Expression::new("1 - s*tanh(u)", 1.0).unwrap());
        let dropping = Law::Expression(Expression::with_static("0.7 - s*tanh(u)", 1.0).unwrap());
        let critical = |law: &Law| of(law, 1.0, &[0.2], 1.0, 0.0).parts[0].critical().unwrap();
        let between = 0.5 * (critical(&flat)[1] + critical(&dropping)[0]);
        let [without, with] = [&flat, &dropping].map(|law| of(law, 1.0, &[0.2], 1.0, between));
        assert_eq!([&without, &with].map(decision), [Some(Decision::Absent), Some(Decision::Present)]);
        for one in [&without, &with] {
            assert_eq!(one.check().problems, Vec::<String>::new());
        }
        for (one, other) in [(&without, &with), (&with, &without)] {
            let forged = Certificate { law_definition: other.law_definition.clone(), ..one.clone() };
            assert_ne!(forged.check().problems, Vec::<String>::new());
        }
    }

    /// From slow belts the orbit reaches slip speeds of many times the belt's before it lands.
    #[test]
    fn the_landing_is_proved_from_slow_belts() {
        let law =
            Law::Expression(Expression::with_static("0.7*(1 - 0.4*tanh(3*u) + 0.01*u^2)", 0.8).unwrap());
        let one = of(&law, 1.0, &[], 0.12, 0.001);
        assert_eq!((decision(&one), one.check().problems), (Some(Decision::Present), Vec::new()));
    }
}

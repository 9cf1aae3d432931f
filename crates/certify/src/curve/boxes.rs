//! Boxes of eps, a law's parameters and the belt speed, proved by curves that change linearly over each of its parts.
//!
//! In a part the damping of a curve is c(z), linear in the part's coordinates z: the cycle is present where c is above that of
//! the curve that lands and at most that of the one that returns, absent where c is at least that of the curve that is
//! absent. [`Shares`] bounds the volumes of these sets.

use rayon::prelude::*;

use super::column::{Stop, critical, prove};
use super::find::{Finder, Found};
use super::region::Region;
use super::{Along, CurveKind, OneWay};
use crate::certificate::{MOST_CUTS, Node};
use slipmap_model::friction::Law;
use slipmap_numbers::interval::Interval;

/// Distance of the first curves from the linear part of c*, in units of how far c* bends away from it, and least distance in
/// units of c*.
const FIRST: f64 = 4.0;
const LEAST: f64 = 1e-4;
/// Distances of the next ones, in units of what the first one lacks.
const NEXT: [f64; 3] = [1.5, 2.0, 3.0];
/// Largest distance, in units of the range of dampings: beyond it little is decided.
const MOST: f64 = 0.5;
/// Shares of c* at which a landing is tried, after the smallest damping.
const LANDINGS: [f64; 4] = [0.25, 0.5, 0.75, 0.9];

/// Proved shares of a volume.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Shares {
    /// Lower bound of the share proved present.
    pub present: f64,
    /// Lower bound of the share proved absent.
    pub absent: f64,
}

impl Shares {
    /// The share of which nothing is proved, at most.
    #[must_use]
    pub fn undecided(&self) -> f64 {
        let rest = Interval::ONE - Interval::of(self.present) - Interval::of(self.absent);
        rest.hi.clamp(0.0, 1.0)
    }

    /// Those of a part of a box that curves prove, at dampings in a range, in units of the part's volume.
    ///
    /// **Proof.** With f(z) linear, the mean of min(max(f, lo), hi) is at least max(lo, f(0) - (max f - hi)_+), since the mean
    /// of f is f(0) and clamping takes away no more than max f - hi. []
    pub(crate) fn of(curves: &[OneWay], [lo, hi]: [f64; 2]) -> Self {
        let bounds = |curve: &OneWay| {
            let sizes = curve.along.iter().map(|along| Interval::of(along.c.abs()));
            let spread = sizes.fold(Interval::ZERO, |sum, size| sum + size);
            (Interval::of(curve.c) - spread).hull(Interval::of(curve.c) + spread)
        };
        let at = |kind: CurveKind| curves.iter().filter(move |curve| curve.kind == kind);
        let from = at(CurveKind::Lands).map(|curve| bounds(curve).hi).fold(f64::INFINITY, f64::min).max(lo);
        let share = |of: Interval| of.over(Interval::of(hi) - Interval::of(lo)).lo.clamp(0.0, 1.0);
        let present = |curve: &OneWay| {
            if lo == hi {
                return f64::from(u8::from(from <= lo && lo <= bounds(curve).lo));
            }
            let cut = (Interval::of(bounds(curve).hi) - Interval::of(hi)).at_least_zero();
            let top = (Interval::of(curve.c) - cut).lo.max(bounds(curve).lo.min(hi));
            share(Interval::of(top) - Interval::of(from))
        };
        let absent = |curve: &OneWay| {
            if lo == hi {
                return f64::from(u8::from(bounds(curve).hi <= lo));
            }
            let cut = (Interval::of(lo) - Interval::of(bounds(curve).lo)).at_least_zero();
            let bottom = (Interval::of(curve.c) + cut).hi.min(bounds(curve).hi.max(lo));
            share(Interval::of(hi) - Interval::of(bottom))
        };
        Self {
            present: at(CurveKind::Returns).map(present).fold(0.0, f64::max),
            absent: at(CurveKind::Absent).map(absent).fold(0.0, f64::max),
        }
    }
}

/// A box, and the proofs over its parts so far.
#[derive(Clone, Debug, PartialEq)]
pub struct BoxProof {
    pub(crate) law: Law,
    /// Ranges of eps, of the law's parameters and of V.
    pub(crate) ranges: Vec<[f64; 2]>,
    pub(crate) damping: [f64; 2],
    parts: Vec<Part>,
    /// Number of parts of which a proof was tried.
    pub tried: usize,
}

/// A part of a box.
#[derive(Clone, Debug, PartialEq)]
struct Part {
    ranges: Vec<[f64; 2]>,
    /// The cuts that lead to it: axis, place, and whether it is on the upper side.
    cuts: Vec<(usize, f64, bool)>,
    /// Its share of the volume.
    share: f64,
    curves: Vec<OneWay>,
    /// Its undecided share of the whole volume.
    undecided: f64,
    /// The axis along which it is best cut.
    cut: Option<usize>,
    /// Why more is not proved.
    stop: Option<Stop>,
}

impl BoxProof {
    /// A box of these exact ranges of eps, the law's parameters and V, and of the damping, without any proof.
    pub fn new(law: &Law, ranges: Vec<[f64; 2]>, damping: [f64; 2]) -> Self {
        let mut proof = Self { law: law.clone(), ranges, damping, parts: Vec::new(), tried: 1 };
        proof.parts = vec![proof.proved(proof.ranges.clone(), Vec::new(), 1.0)];
        proof
    }

    /// Tries proofs of up to `boxes` parts in all, or until `go_on` returns false, which is told how many were tried: in each
    /// round of a quarter of the parts, those with the largest undecided shares. The result does not depend on the number of
    /// threads.
    pub fn refine(&mut self, boxes: usize, go_on: &dyn Fn(usize) -> bool) {
        while self.tried + 2 <= boxes && go_on(self.tried) {
            self.parts.sort_by(|one, two| two.undecided.total_cmp(&one.undecided));
            let most = ((boxes - self.tried) / 2).min(self.parts.len().div_ceil(4));
            let is_open = |part: &&Part| part.undecided > 0.0 && part.halves().is_some();
            let count = self.parts.iter().take(most).take_while(is_open).count();
            if count == 0 {
                return;
            }
            let heavy: Vec<Part> = self.parts.drain(..count).collect();
            let halves: Vec<_> = heavy.iter().filter_map(Part::halves).flatten().collect();
            self.tried += halves.len();
            let proved = halves.into_par_iter().map(|(ranges, cuts, share)| self.proved(ranges, cuts, share));
            let proved: Vec<Part> = proved.collect();
            self.parts.extend(proved);
        }
    }

    /// The shares proved so far.
    #[must_use]
    pub fn shares(&self) -> Shares {
        self.node().shares(&self.ranges, &self.law, self.damping)
    }

    /// Why the largest undecided part is not decided.
    #[must_use]
    pub fn stop(&self) -> Option<Stop> {
        let stopped = self.parts.iter().filter(|part| part.stop.is_some());
        stopped.max_by(|one, two| one.undecided.total_cmp(&two.undecided))?.stop
    }

    /// The parts as a tree of cuts.
    pub(crate) fn node(&self) -> Node {
        fn node(parts: &[&Part], axes: &[&str], depth: usize) -> Node {
            let Some(&(axis, at, _)) = parts.first().and_then(|part| part.cuts.get(depth)) else {
                return Node::proved(parts.first().map_or(&[], |part| part.curves.as_slice()));
            };
            let (upper, lower): (Vec<&Part>, Vec<&Part>) = parts.iter().partition(|part| part.cuts[depth].2);
            Node::cut(axes[axis], at, [node(&lower, axes, depth + 1), node(&upper, axes, depth + 1)])
        }
        node(&self.parts.iter().collect::<Vec<_>>(), &self.law.axis_names(), 0)
    }

    fn proved(&self, ranges: Vec<[f64; 2]>, cuts: Vec<(usize, f64, bool)>, share: f64) -> Part {
        let width =
            |axis: usize| (ranges[axis][1] - ranges[axis][0]) / (self.ranges[axis][1] - self.ranges[axis][0]);
        let wide = (0..ranges.len()).filter(|&axis| ranges[axis][0] < ranges[axis][1]);
        let cut = wide.max_by(|&one, &two| width(one).total_cmp(&width(two)));
        let mut part = Part { ranges, cuts, share, curves: Vec::new(), undecided: share, cut, stop: None };
        part.stop = part.prove(&self.law, self.damping).err();
        part.undecided = share * Shares::of(&part.curves, self.damping).undecided();
        part
    }
}

type Half = (Vec<[f64; 2]>, Vec<(usize, f64, bool)>, f64);

impl Part {
    fn halves(&self) -> Option<[Half; 2]> {
        let axis = self.cut?;
        let [lo, hi] = self.ranges[axis];
        let at = lo + 0.5 * (hi - lo);
        let half = |range: [f64; 2], upper: bool| {
            let (mut ranges, mut cuts) = (self.ranges.clone(), self.cuts.clone());
            ranges[axis] = range;
            cuts.push((axis, at, upper));
            (ranges, cuts, 0.5 * self.share)
        };
        (lo < at && at < hi && self.cuts.len() < MOST_CUTS)
            .then(|| [half([lo, at], false), half([at, hi], true)])
    }

    /// Finds and checks the curves of the part.
    fn prove(&mut self, law: &Law, damping: [f64; 2]) -> Result<(), Stop> {
        let region = Region::new(law, &self.ranges)?;
        if region.axes.is_empty() {
            let proof = prove(&law.column(&region.point(&[])));
            self.curves = proof.curves;
            return proof.stop.map_or(Ok(()), Err);
        }
        let whole = Whole::of(law, &region, damping)?;
        let (mut stop, mut lacks) = (None, vec![1.0; region.axes.len()]);
        for kind in [CurveKind::Returns, CurveKind::Absent] {
            if whole.is_of_use(kind) {
                match whole.close(kind, &mut lacks) {
                    Ok(curve) => self.curves.push(curve),
                    Err(why) => stop = Some(why),
                }
            }
        }
        if let Some(most) = self.at(CurveKind::Returns) {
            match whole.land(most) {
                Ok(curve) => self.curves.push(curve),
                Err(why) => stop = Some(why),
            }
        }
        let width = damping[1] - damping[0];
        let both = self.at(CurveKind::Absent).zip(self.at(CurveKind::Returns));
        let gap = both.map_or(width, |(absent, returns)| absent - returns);
        self.cut = whole.best_cut(gap, &lacks, stop.is_some());
        stop.map_or(Ok(()), Err)
    }

    /// The damping of the curve of a kind.
    fn at(&self, kind: CurveKind) -> Option<f64> {
        self.curves.iter().find(|curve| curve.kind == kind).map(|curve| curve.c)
    }
}

/// A number with few digits: certificates are shorter, and derivatives need no more.
fn short(x: f64) -> f64 {
    format!("{x:.7e}").parse().unwrap_or(x)
}

/// The first that is found, or why the last one is not, or there is none.
fn first<T>(mut stop: Stop, all: impl Iterator<Item = Result<T, Stop>>) -> Result<T, Stop> {
    for found in all {
        match found {
            Ok(found) => return Ok(found),
            Err(why) => stop = why,
        }
    }
    Err(stop)
}

/// What curves over a part are made of: the finders in its middle and at both ends of each axis, and c* there.
struct Whole<'a> {
    region: &'a Region<'a>,
    damping: [f64; 2],
    finder: Finder,
    ends: Vec<[Finder; 2]>,
    epsilon: f64,
    /// c* in the middle, how it changes along the axes, and how it bends.
    critical: f64,
    slopes: Vec<f64>,
    bends: Vec<f64>,
}

impl<'a> Whole<'a> {
    fn of(law: &Law, region: &'a Region, damping: [f64; 2]) -> Result<Self, Stop> {
        let axes = region.axes.len();
        let at = |axis: usize, z: f64| -> Result<(Finder, f64), Stop> {
            let mut place = vec![0.0; axes];
            place.iter_mut().skip(axis).take(1).for_each(|it| *it = z);
            let column = law.column(&region.point(&place));
            let finder = Finder::new(&column);
            let critical = critical(&column, &finder)?;
            Ok((finder, critical))
        };
        let (finder, critical) = at(axes, 0.0)?;
        let (mut ends, mut slopes, mut bends) = (Vec::new(), Vec::new(), Vec::new());
        for axis in 0..axes {
            let [(low, below), (high, above)] = [at(axis, -1.0)?, at(axis, 1.0)?];
            ends.push([low, high]);
            slopes.push(0.5 * (above - below));
            bends.push(0.5 * (above + below) - critical);
        }
        let epsilon = region.point(&[]).epsilon;
        let mut whole = Self { region, damping, finder, ends, epsilon, critical, slopes, bends };
        whole.widen_drops();
        Ok(whole)
    }

    /// A curve starts on its side of the drop over the whole box, on which that is not quite linear.
    fn widen_drops(&mut self) {
        let drop = |finder: &Finder| finder.field().drop.hi;
        let speeds = self.ends.iter().flatten().map(|finder| finder.field().belt_speed);
        let belt_speed = self.finder.field().belt_speed;
        let off = speeds.map(|speed| (speed / belt_speed - 1.0).abs()).fold(0.0, f64::max);
        let moves = self.ends.iter().map(|[low, high]| (drop(high) - drop(low)).abs()).sum::<f64>();
        let slack = 4.0 * (drop(&self.finder) * off * off + moves * off);
        for finder in self.ends.iter_mut().flatten().chain([&mut self.finder]) {
            finder.widen_drop(slack);
        }
    }

    /// The least distance of curves from c*.
    fn least(&self) -> f64 {
        LEAST * self.critical.abs().max(self.damping[1] - self.damping[0])
    }

    /// How far c* bends away from its linear part, at least that.
    fn size(&self) -> f64 {
        self.bends.iter().map(|bend| bend.abs()).sum::<f64>() + self.least()
    }

    /// How far c* is from that in the middle.
    fn spread(&self) -> f64 {
        self.slopes.iter().map(|slope| slope.abs()).sum::<f64>() + self.size()
    }

    /// Whether a curve of a kind decides something in the range of dampings.
    fn is_of_use(&self, kind: CurveKind) -> bool {
        match kind {
            CurveKind::Returns => self.critical + self.spread() > self.damping[0],
            _ => self.critical - self.spread() < self.damping[1],
        }
    }

    /// The curve of a kind next to c*; tells what each axis lacks.
    fn close(&self, kind: CurveKind, lacks: &mut Vec<f64>) -> Result<OneWay, Stop> {
        let side = -kind.sign();
        let bent = self.bends.iter().map(|bend| (side * bend).max(0.0)).sum::<f64>();
        let at = |off: f64| {
            let (damping, guess) = (self.critical + side * off, 0.5 * self.epsilon * off);
            self.curve(self.finder.closed(kind, damping, guess)?, &self.slopes)
        };
        let first_off = bent + FIRST * self.size();
        let lack = at(first_off).ok().and_then(|curve| self.region.lack(&curve)).ok_or(Stop::TooWide)?;
        *lacks = lack.axes;
        // kappa, and so S(0), rises with the distance; what is beyond S(0) hardly does.
        let offs = NEXT.map(|next| (next * lack.ratio * first_off).max(bent + self.least()));
        let most = bent + MOST * (self.damping[1] - self.damping[0]).max(self.critical.abs());
        let few = offs.into_iter().filter(|off| *off < most);
        first(Stop::TooWide, few.map(|off| self.proved(at(off)?)))
    }

    /// The curve that lands at the smallest damping found, below `most`.
    fn land(&self, most: f64) -> Result<OneWay, Stop> {
        let tried = std::iter::once(self.damping[0]).chain(LANDINGS.map(|share| share * most));
        let tried = tried.filter(|c| (self.damping[0]..most).contains(c));
        let level = vec![0.0; self.slopes.len()];
        first(Stop::NotClosed, tried.map(|c| self.proved(self.curve(self.finder.landing(c)?, &level)?)))
    }

    /// The axis along which to cut: what it has of the gap between the curves, and of dampings beyond their range.
    fn best_cut(&self, gap: f64, lacks: &[f64], has_stopped: bool) -> Option<usize> {
        let ([lo, hi], spread) = (self.damping, self.spread());
        let beyond = (self.critical + spread - hi).max(lo - self.critical + spread);
        let beyond = beyond.clamp(0.0, 2.0 * spread).max(if has_stopped { gap } else { 0.0 });
        let share = |of: &[f64], axis: usize| {
            of[axis].abs() / of.iter().map(|x| x.abs()).sum::<f64>().max(f64::MIN_POSITIVE)
        };
        let weight = |axis: usize| gap * share(lacks, axis) + beyond * share(&self.slopes, axis);
        let axes = 0..self.slopes.len();
        let best = axes.max_by(|&one, &two| weight(one).total_cmp(&weight(two)))?;
        Some(self.region.axes[best])
    }

    /// The curve over the part that is a given one in its middle, with these slopes of its damping.
    fn curve(&self, found: Found, slopes: &[f64]) -> Result<OneWay, Stop> {
        let middle = &found.curve;
        let along = self.ends.iter().zip(slopes).map(|([low, high], &slope)| {
            // In units of the belt speed.
            let units = [low, high].map(|end| self.finder.field().belt_speed / end.field().belt_speed);
            let low = low.again(&found, middle.c - slope)?;
            let high = high.again(&found, middle.c + slope)?;
            let pieces = low.iter().zip(&high).map(|(low, high)| {
                let half =
                    |i: usize, axis: usize| short(0.5 * (units[1] * high[i][axis] - units[0] * low[i][axis]));
                (0..low.len()).map(|i| [half(i, 0), half(i, 1)]).collect()
            });
            Some(Along { c: slope, pieces: pieces.collect() })
        });
        let along = along.collect::<Option<_>>().ok_or(Stop::NotClosed)?;
        Ok(OneWay { along, ..middle.clone() })
    }

    /// A curve, if it is a proof.
    fn proved(&self, curve: OneWay) -> Result<OneWay, Stop> {
        self.region.check_with_room(&curve).map_err(Stop::Refused)?;
        Ok(curve)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve::prove;
    use slipmap_model::friction::Expression;
    use slipmap_model::point::{LawParameters, Point};

    fn proved(law: &Law, ranges: &[[f64; 2]], damping: [f64; 2], boxes: usize) -> BoxProof {
        let mut proof = BoxProof::new(law, ranges.to_vec(), damping);
        proof.refine(boxes, &|_| true);
        proof
    }

    /// With a constant weakening rate a the critical damping is a / eps, whatever V.
    #[test]
    fn volumes_of_known_sets() {
        let formula = |text: &str| Law::Expression(Expression::new(text, 1.0).unwrap());
        let ranges = [[1.0, 1.0], [0.1, 0.3], [0.19, 0.21]];
        for (law, ranges, damping, boxes, exact, most) in [
            // The mean of a is 0.2, of c in [0, 0.4].
            (formula("1 - a*u"), ranges, [0.0, 0.4], 4, 0.5, 0.05),
            // Only above 0.2 is c cut off: the mean of the smaller of a and 0.2 is 0.175.
            (formula("1 - a*u"), ranges, [0.1, 0.2], 8, 0.75, 0.03),
            // a is above 0.15 in three quarters.
            (formula("1 - a*u"), ranges, [0.15, 0.15], 16, 0.75, 0.2),
            // A law that contains eps: c* = a, and C* = eps a.
            (formula("1 - epsilon*a*u"), [[0.5, 0.6], [0.1, 0.3], [0.2, 0.2]], [0.0, 0.4], 16, 0.5, 0.05),
        ] {
            let found = proved(&law, &ranges, damping, boxes).shares();
            assert!(found.present <= exact && exact <= 1.0 - found.absent, "{found:?}");
            assert!(found.undecided() < most, "{found:?}");
        }
    }

    /// The curves over a box enclose what those of points inside it do, with a drop that changes, too; more boxes decide more.
    #[test]
    fn boxes_hold_the_points_inside() {
        let dropping = Law::Exponential.with_drop();
        for (law, ranges) in [
            (Law::Stribeck, vec![[0.1, 0.1], [0.3, 0.32], [0.1, 0.1], [2.0, 2.05], [1.0, 1.02]]),
            (dropping, vec![[1.0, 1.0], [0.8, 0.8], [0.05, 0.05], [0.0, 0.0], [0.3, 0.31], [0.5, 0.5]]),
        ] {
            let proof = proved(&law, &ranges, [0.0, 2.0], 1);
            assert!(proof.shares().undecided() < 0.05, "{:?} {:?}", proof.shares(), proof.stop());
            for share in [0.0, 0.3, 1.0] {
                let at: Vec<f64> = ranges.iter().map(|[lo, hi]| lo + share * (hi - lo)).collect();
                let point = Point {
                    epsilon: at[0],
                    law: LawParameters::new(&at[1..at.len() - 1]),
                    belt_speed: at[at.len() - 1],
                    damping: 0.0,
                };
                let known = prove(&law.column(&point)).critical();
                for curve in &proof.parts[0].curves {
                    let c = curve.along.iter().fold(curve.c, |c, along| c + (2.0 * share - 1.0) * along.c);
                    let holds = match curve.kind {
                        CurveKind::Returns => c < known.hi,
                        CurveKind::Absent => c > known.lo,
                        CurveKind::Lands => true,
                    };
                    assert!(holds, "{:?} {c} {known:?}", curve.kind);
                }
            }
            let more = proved(&law, &ranges, [0.0, 2.0], 4).shares();
            assert!(more.undecided() < proof.shares().undecided());
        }
    }

    #[test]
    fn a_box_is_the_same_for_any_number_of_threads() {
        let refined = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| {
                proved(
                    &Law::Exponential,
                    &[[1.0; 2], [0.6, 0.7], [0.3; 2], [0.0; 2], [0.5; 2]],
                    [0.0, 1.0],
                    6,
                )
            })
        };
        assert_eq!(refined(1), refined(3));
    }
}

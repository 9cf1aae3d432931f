//! Proved shares of the volume of a box of any law's parameters.
//!
//! The box is cut into parts, each with a `Tile` that encloses C* over it, or without a proof; see
//! [`super::volumes`]. The bounds are linear in the part's coordinates, and divided by eps; `mean` encloses their means cut
//! off at the ends of the range of c, so that the shares are lower bounds. Nothing is sampled.
//!
//! The statements hold wherever the law is legal: phi(0) = 1, and D a Lipschitz function of the slip speed. A law whose
//! friction may drop as slip begins has no tiles.

use super::barrier::{Domain, Ranges, Tile};
use super::expansion::Expansion;
use super::mean::mean_cut;
use super::volumes::{self, Shares, Volumes};
use slipmap_model::friction::{Law, Slope};
use slipmap_model::point::MAX_LAW_PARAMETERS;
use slipmap_numbers::interval::Interval;

/// Largest number of axes: eps, the law's parameters, V.
const AXES: usize = MAX_LAW_PARAMETERS + 2;
/// Width of a range of eps, in units of eps, that is not halved, and that in units of the whole range.
const NARROW: f64 = 1.0 / 32.0;
const NEGLIGIBLE: f64 = 1e-5;

/// A box of parameters, and the proofs over it so far.
#[derive(Clone, Debug, PartialEq)]
pub struct LawProof {
    pub(crate) law: Law,
    /// Ranges of eps, of the law's parameters and of V.
    pub(crate) ranges: Ranges,
    pub(crate) damping: [f64; 2],
    parts: Vec<Part>,
    tried: usize,
}

#[derive(Clone, Debug, PartialEq)]
struct Part {
    ranges: Ranges,
    tile: Option<Tile>,
    shares: Shares,
}

impl LawProof {
    /// A box without any proof.
    pub fn new(law: &Law, ranges: Ranges, damping: [f64; 2]) -> Self {
        let whole = Part { ranges: ranges.clone(), tile: None, shares: Shares::open(1.0) };
        Self { law: law.clone(), ranges, damping, parts: vec![whole], tried: 0 }
    }

    /// Tries proofs of up to `boxes` parts, or until `go_on` returns false: in each round of a quarter of the
    /// parts, those with the largest undecided shares. The result does not depend on the number of threads.
    pub fn refine(&mut self, boxes: usize, go_on: &(dyn Fn() -> bool + Sync)) {
        if self.tried == 0 && boxes > 0 {
            self.parts = vec![self.proved(self.ranges.clone())];
            self.tried = 1;
        }
        while self.tried < boxes && go_on() {
            let mut parts = std::mem::take(&mut self.parts);
            let most = (boxes - self.tried).div_ceil(2);
            let weight = |part: &Part| part.shares.undecided;
            let cut = volumes::halve_heaviest(&mut parts, weight, most, |part| self.halves(part));
            self.parts = parts;
            self.tried += 2 * cut;
            if cut == 0 {
                return;
            }
        }
    }

    /// The proofs of both halves of a part; the part itself if it is a point.
    fn halves(&self, part: Part) -> Vec<Part> {
        let share = |axis: usize| {
            let [[lo, hi], [from, to]] = [part.ranges[axis], self.ranges[axis]];
            (hi - lo) / (to - from)
        };
        let weight = |axis: usize| part.tile.as_ref().map_or(share(axis), |tile| tile.by_axis[axis]);
        let wide = (0..part.ranges.len()).filter(|&axis| part.ranges[axis][0] < part.ranges[axis][1]);
        let cut = wide.max_by(|&i, &j| weight(i).total_cmp(&weight(j)).then(share(i).total_cmp(&share(j))));
        let Some(axis) = cut else { return vec![part] };
        let [lo, hi] = part.ranges[axis];
        let middle = lo + 0.5 * (hi - lo);
        if !(lo < middle && middle < hi) {
            return vec![part];
        }
        let half = |range: [f64; 2]| {
            let mut ranges = part.ranges.clone();
            ranges[axis] = range;
            self.proved(ranges)
        };
        vec![half([lo, middle]), half([middle, hi])]
    }

    /// A part with its proof.
    fn proved(&self, ranges: Ranges) -> Part {
        let share = volumes::share(&ranges, &self.ranges);
        let Some(tile) = Tile::prove(&self.law, &ranges) else {
            return Part { ranges, tile: None, shares: Shares::open(share.hi.min(1.0)) };
        };
        let domain = Domain::new(&ranges);
        let bound = |sign: f64| LinearBound {
            domain: &domain,
            viscous: Interval::of(tile.viscous) + Interval::of(sign * tile.radius),
            slopes: &tile.slopes,
        };
        let x = &domain.all;
        let (parameters, belt_speed) = x.split_at(x.len() - 1);
        let own: Vec<Slope> = parameters.iter().map(|x| Slope::of(*x)).collect();
        let highest = |least: Interval, most: Interval| {
            let [least, most] = [least, most].map(|slip| belt_speed[0] * slip);
            let weakening =
                self.law.weakening_over(Slope::of(Interval::new(least.lo.max(0.0), most.hi)), &own);
            weakening.map_or(f64::INFINITY, |weakening| weakening.0[0].hi)
        };
        let from = volumes::sticks_from(highest, x[0], belt_speed[0], self.damping);
        let [least, most] = [-1.0, 1.0].map(bound);
        let epsilon = ranges[0];
        let means = [&least, &most].map(|bound| move |range| bound.mean_cut(epsilon, range));
        let shares = volumes::decided(share, self.damping, from, [&means[0], &means[1]]);
        Part { ranges, tile: Some(tile), shares }
    }

    /// The volumes proved so far.
    pub fn volumes(&self) -> Volumes {
        Volumes::of(self.parts.iter().map(|part| part.shares), self.tried)
    }

    pub(crate) fn tiles(&self) -> impl Iterator<Item = &Tile> {
        self.parts.iter().filter_map(|part| part.tile.as_ref())
    }

    /// The parts without a proof.
    pub(crate) fn open(&self) -> impl Iterator<Item = &Ranges> {
        self.parts.iter().filter(|part| part.tile.is_none()).map(|part| &part.ranges)
    }
}

/// A bound of C* over a part, linear in its coordinates.
struct LinearBound<'a> {
    domain: &'a Domain,
    viscous: Interval,
    slopes: &'a [f64],
}

impl LinearBound<'_> {
    /// The mean, over the part with eps in this range, of the bound of c* cut off at both ends of a range. Ranges of eps are
    /// halved until 1/eps is nearly linear over each, as [`mean_cut`] takes it.
    fn mean_cut(&self, epsilon: [f64; 2], cut: [f64; 2]) -> Interval {
        let [lo, hi] = epsilon;
        let center = lo + 0.5 * (hi - lo);
        let whole = self.domain.all[0];
        let enough = (NARROW * lo).max(NEGLIGIBLE * (whole.hi - whole.lo));
        if hi - lo > enough && lo < center && center < hi {
            let width = |[from, to]: [f64; 2]| Interval::of(to) - Interval::of(from);
            let [one, two] = [[lo, center], [center, hi]].map(|half| width(half) * self.mean_cut(half, cut));
            return (one + two).over(width(epsilon));
        }
        let Domain { all, middle, half, .. } = self.domain;
        let half_of = |x: Interval| Interval::of(0.5) * x;
        // The bound in coordinates that run from -1 to 1 over this range of eps, and over the others as they are: the
        // middles and the half-widths of the part are rounded.
        let mut linear = Expansion::<AXES>::constant(self.viscous);
        for (axis, &slope) in self.slopes.iter().enumerate().filter(|(_, slope)| **slope != 0.0) {
            let ends = if axis == 0 { epsilon } else { [all[axis].lo, all[axis].hi] };
            let coordinate =
                |x: f64| (Interval::of(x) - Interval::of(middle[axis])).over(Interval::of(half[axis]));
            let ([from, to], slope) = (ends.map(coordinate), Interval::of(slope));
            linear.value = linear.value + slope * half_of(from + to);
            linear.slope[axis] = slope * half_of(to - from);
        }
        let [from, to] = epsilon.map(Interval::of);
        let whole_epsilon = from.hull(to);
        let over_epsilon = |value: Interval, epsilon: Interval| {
            let mut divisor = Expansion::parameter(epsilon, 0);
            divisor.slope[0] = half_of(to - from);
            Expansion { value, ..linear }.times(&divisor.inverse())
        };
        let spread = linear.spread().hi;
        let whole = linear.value + Interval::new(-spread, spread);
        let Expansion { bend, .. } = over_epsilon(whole, whole_epsilon);
        let bound = Expansion { bend, ..over_epsilon(linear.value, half_of(from + to)) };
        mean_cut(&bound, Interval::ZERO, whole.over(whole_epsilon), cut)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve;
    use slipmap_model::friction::{Expression, Table};
    use slipmap_model::point::{LawParameters, Point};

    fn formula(text: &str) -> Law {
        Law::Expression(Expression::new(text, 1.0).unwrap())
    }

    fn volumes(law: &Law, ranges: Ranges, damping: [f64; 2], boxes: usize) -> Volumes {
        let mut proof = LawProof::new(law, ranges, damping);
        proof.refine(boxes, &|| true);
        proof.volumes()
    }

    /// With a constant weakening rate a the critical damping is a / eps, whatever V.
    #[test]
    fn volumes_of_known_sets() {
        let law = formula("1 - a*u");
        let ranges = vec![[1.0, 1.0], [0.1, 0.3], [0.1, 0.3]];
        // The mean of a is 0.2, of c in [0, 0.4].
        let found = volumes(&law, ranges.clone(), [0.0, 0.4], 32);
        assert!(found.present <= 0.5 && 0.5 <= 1.0 - found.absent && found.undecided < 0.02, "{found:?}");
        // a is above 0.15 in three quarters.
        let found = volumes(&law, ranges.clone(), [0.15, 0.15], 32);
        assert!(found.present <= 0.75 && 0.75 <= 1.0 - found.absent && found.undecided < 0.05, "{found:?}");
        // Only above 0.2 is c cut off: the mean of the smaller of a and 0.2 is 0.175.
        let found = volumes(&law, ranges, [0.1, 0.2], 32);
        assert!(found.present <= 0.75 && 0.75 <= 1.0 - found.absent && found.undecided < 0.05, "{found:?}");
        // A law that contains eps: c* = a, and C* = eps a.
        let small = formula("1 - epsilon*a*u");
        let found = volumes(&small, vec![[0.5, 1.0], [0.1, 0.3], [0.2, 0.2]], [0.0, 0.4], 128);
        assert!(found.present <= 0.5 && 0.5 <= 1.0 - found.absent && found.undecided < 0.06, "{found:?}");
    }

    /// The proved shares enclose those of columns in the middle of many small boxes; more boxes decide more.
    #[test]
    fn proved_volumes_enclose_the_true_ones() {
        let table = Table::new("data", &[(0.0, 1.0), (0.2, 0.9), (0.7, 0.7), (1.5, 0.6), (3.0, 0.62)], 1.0);
        let cases = [
            (formula("0.5 + 0.5*exp(-u/vs)"), vec![[1.0, 1.0], [0.8, 1.0], [0.6, 0.8]]),
            (Law::Table(table.unwrap()), vec![[1.0, 1.0], [0.5, 1.0]]),
        ];
        for (law, ranges) in cases {
            let mut proof = LawProof::new(&law, ranges.clone(), [0.0, 0.5]);
            let [few, more] = [40, 120].map(|boxes| {
                proof.refine(boxes, &|| true);
                proof.volumes()
            });
            assert!(more.undecided < few.undecided && more.undecided < 0.2, "{few:?} {more:?}");
            // The midpoint rule with steps of a sixth of each axis: its error is far below the undecided
            // share.
            let wide: Vec<usize> =
                (0..ranges.len()).filter(|&axis| ranges[axis][0] < ranges[axis][1]).collect();
            let columns = 6_usize.pow(wide.len() as u32);
            let share = |number: usize| {
                let mut x: Vec<f64> = ranges.iter().map(|[lo, _]| *lo).collect();
                for (place, &axis) in wide.iter().enumerate() {
                    let step = number / 6_usize.pow(place as u32) % 6;
                    x[axis] += (step as f64 + 0.5) / 6.0 * (ranges[axis][1] - ranges[axis][0]);
                }
                let [epsilon, own @ .., belt_speed] = x.as_slice() else { unreachable!() };
                let law_parameters = LawParameters::new(own);
                let point =
                    Point { epsilon: *epsilon, law: law_parameters, belt_speed: *belt_speed, damping: 0.0 };
                let critical = curve::prove(&law.column(&point)).critical();
                (0.5 * (critical.lo + critical.hi)).clamp(0.0, 0.5) / 0.5
            };
            let present = (0..columns).map(share).sum::<f64>() / columns as f64;
            for found in [few, more] {
                let error = 2e-3;
                assert!(
                    found.present <= present + error && present <= 1.0 - found.absent + error,
                    "{found:?} {present}"
                );
            }
        }
    }

    #[test]
    fn a_box_without_proof_is_undecided() {
        // D is not bounded at rest.
        let found = volumes(&formula("1 - 0.1*sqrt(u)"), vec![[1.0, 1.0], [0.5, 1.0]], [0.0, 1.0], 8);
        assert_eq!((found.present, found.absent), (0.0, 0.0));
        assert!(found.undecided >= 1.0 - 1e-12, "{found:?}");
    }
}

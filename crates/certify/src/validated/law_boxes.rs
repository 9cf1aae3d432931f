//! Proved shares of the volume of a box of any law's parameters.
//!
//! The box is cut into parts, each with a `Tile` that encloses C* over it, or without a proof; see
//! [`super::volumes`]. The bounds are linear in the part's coordinates; the means of c cut off by them are
//! integrated in interval arithmetic, so that the shares are lower bounds. Nothing is sampled.
//!
//! The statements hold wherever the law is legal: phi(0) = 1, and D a Lipschitz function of the slip speed. A law whose
//! friction may drop as slip begins has no tiles.

use rayon::prelude::*;

use super::barrier::{Ranges, Tile};
use super::volumes::{self, Volumes};
use slipmap_model::friction::{Law, Slope};
use slipmap_numbers::interval::Interval;

/// Number of times that a part is halved to integrate where a bound meets the ends of the range of c.
const DEPTH: u32 = 12;

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
    /// Lower bounds of the shares of the whole proved present and absent.
    decided: [f64; 2],
    /// Upper bound of the rest.
    undecided: f64,
}

impl LawProof {
    /// A box without any proof.
    pub fn new(law: &Law, ranges: Ranges, damping: [f64; 2]) -> Self {
        let whole = Part { ranges: ranges.clone(), tile: None, decided: [0.0; 2], undecided: 1.0 };
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
            parts.sort_by(|one, two| two.undecided.total_cmp(&one.undecided));
            let most = (parts.len() / 4).max(1).min((boxes - self.tried).div_ceil(2));
            let mut rest = parts.split_off(most);
            let halves: Vec<Vec<Part>> = parts.into_par_iter().map(|part| self.halves(part)).collect();
            let cut = halves.iter().filter(|halves| halves.len() > 1).count();
            self.tried += 2 * cut;
            rest.extend(halves.into_iter().flatten());
            self.parts = rest;
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
            return Part { ranges, tile: None, decided: [0.0; 2], undecided: share.hi.min(1.0) };
        };
        let bound = |sign: f64| LinearBound {
            epsilon: ranges[0],
            viscous: Interval::of(tile.viscous) + Interval::of(sign * tile.radius),
            slopes: tile.slopes.clone(),
            depth: DEPTH,
        };
        let x: Vec<Interval> = ranges.iter().map(|[lo, hi]| Interval::new(*lo, *hi)).collect();
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
        let means = [&least, &most].map(|bound| move |range| bound.mean_cut(range));
        let decided = volumes::decided(share, self.damping, from, [&means[0], &means[1]]);
        let [present, absent] = decided.map(Interval::of);
        let undecided = (share - present - absent).hi.max(0.0);
        Part { ranges, tile: Some(tile), decided, undecided }
    }

    /// The volumes proved so far.
    pub fn volumes(&self) -> Volumes {
        let decided: Vec<[f64; 2]> = self.parts.iter().map(|part| part.decided).collect();
        Volumes::of(&decided, self.tried)
    }

    pub(crate) fn tiles(&self) -> impl Iterator<Item = &Tile> {
        self.parts.iter().filter_map(|part| part.tile.as_ref())
    }

    /// The parts without a proof.
    pub(crate) fn open(&self) -> impl Iterator<Item = &Ranges> {
        self.parts.iter().filter(|part| part.tile.is_none()).map(|part| &part.ranges)
    }
}

/// A bound of C*, linear in coordinates from -1 to 1, over a range of eps, the first of them.
#[derive(Clone)]
struct LinearBound {
    epsilon: [f64; 2],
    viscous: Interval,
    slopes: Vec<f64>,
    /// How often it may be halved.
    depth: u32,
}

impl LinearBound {
    /// The range of C* / eps.
    fn range(&self) -> Interval {
        let spread = self.slopes.iter().fold(Interval::ZERO, |sum, slope| sum + Interval::of(slope.abs())).hi;
        self.over_epsilon(self.viscous + Interval::new(-spread, spread))
    }

    fn over_epsilon(&self, viscous: Interval) -> Interval {
        viscous.over(Interval::new(self.epsilon[0], self.epsilon[1]))
    }

    /// The halves of the part, across the axis along which the bound changes most.
    fn halves(&self) -> [Self; 2] {
        let [lo, hi] = self.epsilon;
        let range = self.range();
        let by_epsilon = range.size() * (hi - lo) / hi;
        let size = |axis: usize| {
            let by_itself = 2.0 * self.slopes[axis].abs() / lo;
            if axis == 0 { by_itself.max(by_epsilon) } else { by_itself }
        };
        let axis = (0..self.slopes.len()).max_by(|&i, &j| size(i).total_cmp(&size(j))).unwrap_or(0);
        [-0.5, 0.5].map(|shift| {
            let mut half = self.clone();
            half.viscous = half.viscous + Interval::of(shift) * Interval::of(half.slopes[axis]);
            half.slopes[axis] *= 0.5;
            half.depth -= 1;
            if axis == 0 {
                let middle = lo + 0.5 * (hi - lo);
                half.epsilon = if shift < 0.0 { [lo, middle] } else { [middle, hi] };
            }
            half
        })
    }

    /// The mean over the part of the bound of c* cut off at both ends of a range.
    fn mean_cut(&self, [lo, hi]: [f64; 2]) -> Interval {
        let range = self.range();
        if range.hi <= lo {
            return Interval::of(lo);
        }
        if range.lo >= hi {
            return Interval::of(hi);
        }
        let is_inside = lo <= range.lo && range.hi <= hi;
        if is_inside && self.epsilon[0] == self.epsilon[1] {
            // The mean of the coordinates is 0 up to the rounding of the box's half-widths.
            let slack = 4.0 * f64::EPSILON * range.size();
            return self.over_epsilon(self.viscous) + Interval::new(-slack, slack);
        }
        if self.depth == 0 {
            return Interval::new(range.lo.clamp(lo, hi), range.hi.clamp(lo, hi));
        }
        let [one, two] = self.halves().map(|half| half.mean_cut([lo, hi]));
        Interval::of(0.5) * (one + two)
    }
}

#[cfg(test)]
mod tests {
    use super::super::any_law;
    use super::*;
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
                let critical = any_law::prove(&law.column(&point)).critical;
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

//! Proved shares of the volume of a box of parameters, as stated in [`super::boxes`], summed over its parts, in
//! each of which c* lies between two functions of the parameters other than c.

use rayon::prelude::*;

use super::least_proved;
use crate::landing::Flow;
use slipmap_numbers::interval::Interval;

/// Number of bisections: the damping from which the landing is proved is located to 2^-6 of the range of c.
const HALVINGS: u32 = 6;
/// Width of the range that stands for a single damping, in units of it or of 0.01, whichever is greater: thin against the
/// range of c* over a part, and wide against the rounding of the two means whose difference is divided by it.
const THIN: f64 = 1e-4;

/// Shares of the box's volume, each with its proved bound.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Volumes {
    /// Lower bound of the share proved present, rounded down.
    pub present: f64,
    /// Lower bound of the share proved absent, rounded down.
    pub absent: f64,
    /// Upper bound of the undecided share, rounded up. The three add up to 1, except for rounding.
    pub undecided: f64,
    /// Number of proofs of tiles tried.
    pub tiles: usize,
    /// Number of parts of the parameter box.
    pub parts: usize,
}

/// What is proved of a part, as shares of the whole box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shares {
    /// Lower bounds of those proved present and absent.
    decided: [f64; 2],
    /// Upper bound of the rest.
    pub(super) undecided: f64,
}

impl Shares {
    /// Those of a part that is `share` of the whole, without any proof.
    pub(super) fn open(share: f64) -> Self {
        Self { decided: [0.0; 2], undecided: share }
    }
}

impl Volumes {
    /// The sum over parts.
    pub(super) fn of(parts: impl ExactSizeIterator<Item = Shares>, tiles: usize) -> Self {
        let count = parts.len();
        let [present, absent] = parts
            .fold([Interval::ZERO; 2], |[present, absent], Shares { decided: [more, other], .. }| {
                [present + Interval::of(more), absent + Interval::of(other)]
            })
            .map(|sum| sum.lo.clamp(0.0, 1.0));
        let undecided = Interval::ONE - Interval::of(present) - Interval::of(absent);
        Self { present, absent, undecided: undecided.hi.clamp(0.0, 1.0), tiles, parts: count }
    }
}

/// Halves up to `most` of a quarter of the parts, the heaviest, and moves the halves behind the others; returns how many
/// were cut. The order does not depend on the number of threads.
pub(super) fn halve_heaviest<P: Send>(
    parts: &mut Vec<P>,
    weight: impl Fn(&P) -> f64,
    most: usize,
    halves: impl Fn(P) -> Vec<P> + Sync,
) -> usize {
    parts.sort_by(|one, two| weight(two).total_cmp(&weight(one)));
    let count = parts.len();
    let heavy: Vec<P> = parts.drain(..most.min((count / 4).max(1))).collect();
    parts.par_extend(heavy.into_par_iter().flat_map_iter(&halves));
    parts.len() - count
}

/// What is proved of a part that is `share` of the whole, where the landing is proved `from` a damping on. `least` and
/// `most` are the means over the part of a lower and of an upper bound of c*, cut off at both ends of a range.
pub(super) fn decided(
    share: Interval,
    damping: [f64; 2],
    from: Option<f64>,
    [least, most]: [&dyn Fn([f64; 2]) -> Interval; 2],
) -> Shares {
    // A cycle exists below c* and none above: the shares at a single damping are at least their means over dampings
    // above it, and below it.
    let thin = |side: f64| if damping[0] == damping[1] { side * THIN * damping[0].max(0.01) } else { 0.0 };
    let above = |from: f64| {
        let to = damping[1] + thin(1.0);
        (least([from, to]) - Interval::of(from)).over(Interval::of(to) - Interval::of(damping[0]))
    };
    let [lo, hi] = [damping[0] + thin(-1.0), damping[1]];
    let absent = (Interval::of(hi) - most([lo, hi])).over(Interval::of(hi) - Interval::of(lo));
    let of_part = [from.map_or(Interval::ZERO, above), absent];
    let decided = of_part.map(|of_part| (of_part * share).lo.max(0.0));
    let [present, absent] = decided.map(Interval::of);
    Shares { decided, undecided: (share - present - absent).hi.max(0.0) }
}

/// The smallest damping found, within a range, from which on the landing is proved in a whole part; `None` if
/// there is none. `highest` bounds the weakening rate between two slip speeds in units of the belt speed.
pub(super) fn sticks_from(
    highest: impl Fn(Interval, Interval) -> f64,
    epsilon: Interval,
    belt_speed: Interval,
    damping: [f64; 2],
) -> Option<f64> {
    let lands = |c: f64| Flow::new(belt_speed, 0.0, epsilon * Interval::of(c), &highest).lands();
    least_proved(&lands, damping, HALVINGS)
}

/// Volume of a part as a share of the whole; axes without a width do not count.
pub(super) fn share(part: &[[f64; 2]], whole: &[[f64; 2]]) -> Interval {
    let wide = part.iter().zip(whole).filter(|(_, [lo, hi])| lo < hi);
    wide.fold(Interval::ONE, |share, ([lo, hi], [from, to])| {
        let width = Interval::of(*hi) - Interval::of(*lo);
        share * width.over(Interval::of(*to) - Interval::of(*from))
    })
}

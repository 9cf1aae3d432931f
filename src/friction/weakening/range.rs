//! Proved bounds from coefficients: of the weakening rate over slip speeds, and of its even part about the
//! belt speed.

use super::{Bend, COUNT, Piece, Weakening};
use crate::friction::Range;

/// Number of pieces with a common hull, see [`Weakening::range`].
pub(super) const BLOCK: usize = 32;

/// The hulls of the ranges of all blocks of pieces.
pub(super) fn blocks(pieces: &[Piece]) -> Vec<Range> {
    let hull = |block: &[Piece]| block.iter().map(|piece| piece.range).reduce(Range::hull);
    pieces.chunks(BLOCK).filter_map(hull).collect()
}

const NOTHING: Range = Range { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

/// Number of bisections in the search for a polynomial's extreme, which is then known to the square of 2^-26.
const HALVINGS: u32 = 26;

impl Range {
    /// The smallest range that contains both.
    fn hull(self, other: Range) -> Range {
        Range { lo: self.lo.min(other.lo), hi: self.hi.max(other.hi) }
    }

    /// Widened on both sides.
    fn widened(self, by: f64) -> Range {
        Range { lo: (self.lo - by).next_down(), hi: (self.hi + by).next_up() }
    }
}

impl Piece {
    /// Proved bounds of w on a part [a, b] of the piece.
    pub(super) fn range_on(&self, a: f64, b: f64) -> Range {
        if !self.error.is_finite() {
            return NOTHING;
        }
        if self.monotone {
            let [at_a, at_b] = [a, b].map(|u| self.at(u));
            return Range { lo: at_a.min(at_b), hi: at_a.max(at_b) }.widened(self.error);
        }
        let [from, to] = [a, b].map(|u| (u - self.middle) * self.scale);
        range_of_polynomial(&self.shifted(from, to), HALVINGS).widened(self.error)
    }

    /// The polynomial in z from -1 to 1, where x runs from `from` to `to`.
    fn shifted(&self, from: f64, to: f64) -> Local {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        Local { c: self.c, noise: 0.0 }.shifted(middle, half)
    }
}

/// A polynomial on [-1, 1] and the rounding of its coefficients, as a bound of the polynomial's error.
#[derive(Clone, Copy)]
struct Local {
    c: [f64; COUNT],
    noise: f64,
}

impl Local {
    /// In z with x = middle + half z, all of |x|, |z| <= 1, by repeated synthetic division.
    ///
    /// Coefficient k is the sum over j of c_j binomial(j, k) middle^(j-k), made with at most 2 (j - k) + 2
    /// roundings of terms that add up, with z = +-1, to at most |c_j| (|middle| + |half|)^j <= |c_j|, but for
    /// rounding.
    fn shifted(mut self, middle: f64, half: f64) -> Local {
        let size: f64 = self.c.iter().map(|c| c.abs()).sum();
        for k in 0..COUNT {
            for i in (k..COUNT - 1).rev() {
                self.c[i] += middle * self.c[i + 1];
            }
        }
        let mut power = 1.0;
        for c in &mut self.c {
            *c *= power;
            power *= half;
        }
        Local { c: self.c, noise: self.noise + 2.0 * COUNT as f64 * f64::EPSILON * size }
    }

    fn plus(self, other: Local) -> Local {
        let c = std::array::from_fn(|k| self.c[k] + other.c[k]);
        let size: f64 = self.c.iter().zip(&other.c).map(|(a, b)| a.abs() + b.abs()).sum();
        Local { c, noise: self.noise + other.noise + f64::EPSILON * size }
    }
}

/// Proved bounds of a polynomial on [-1, 1].
fn range_of_polynomial(polynomial: &Local, halvings: u32) -> Range {
    let c = &polynomial.c;
    let sum = |from: usize, weight: fn(f64) -> f64| -> f64 {
        c.iter().enumerate().skip(from).map(|(k, c)| weight(k as f64) * c.abs()).sum()
    };
    let round_off = 8.0 * COUNT as f64 * f64::EPSILON * sum(0, |_| 1.0) + polynomial.noise;
    let swing = sum(2, |_| 1.0);
    if c[1].abs() >= sum(2, |k| k) * (1.0 + 1e-12) {
        // Monotone.
        let [even, odd] = [0, 1].map(|from| c.iter().skip(from).step_by(2).sum::<f64>());
        return Range { lo: even - odd.abs(), hi: even + odd.abs() }.widened(round_off);
    }
    let whole = Range { lo: c[0] - (c[1].abs() + swing), hi: c[0] + (c[1].abs() + swing) }.widened(round_off);
    if halvings == 0 || c[1].abs() + swing <= round_off {
        return whole;
    }
    let halves = [-0.5, 0.5].map(|middle| polynomial.shifted(middle, 0.5));
    let [left, right] = halves.map(|half| range_of_polynomial(&half, halvings - 1));
    let both = left.hull(right);
    Range { lo: both.lo.max(whole.lo), hi: both.hi.min(whole.hi) }
}

impl Weakening {
    /// Proved bounds of w over slip speeds in [`lo`, `hi`], 0 <= lo <= hi; infinite where there are none, for
    /// instance beyond the reach.
    #[must_use]
    pub fn range(&self, lo: f64, hi: f64) -> Range {
        if !(0.0 <= lo && lo <= hi && hi <= self.reach()) {
            return NOTHING;
        }
        let pieces = self.pieces_between(lo, hi);
        let (first, last) = (*pieces.start(), *pieces.end());
        let part = |i: usize| {
            let (a, b) = (self.breaks[i].max(lo), self.breaks[i + 1].min(hi));
            let whole = self.breaks[i] >= lo && self.breaks[i + 1] <= hi;
            if whole { self.pieces[i].range } else { self.pieces[i].range_on(a, b) }
        };
        let mut range = part(first);
        if last > first {
            range = range.hull(part(last));
        }
        let mut i = first + 1;
        while i < last {
            let whole_block = i % BLOCK == 0 && i + BLOCK <= last;
            range = range.hull(if whole_block { self.blocks[i / BLOCK] } else { self.pieces[i].range });
            i += if whole_block { BLOCK } else { 1 };
        }
        range
    }

    /// Proved bounds, over 0 <= v <= `within` <= V, of the even part in v of w(V - v); infinite where there
    /// are none.
    #[must_use]
    pub fn even_range(&self, belt_speed: f64, within: f64) -> Range {
        let farthest = belt_speed + within;
        if !(within >= 0.0 && within <= belt_speed && farthest <= self.reach()) {
            return NOTHING;
        }
        let nearest = belt_speed - within;
        let pieces = &self.pieces[self.pieces_between(nearest, farthest.next_up().min(self.reach()))];
        let Some(bend) = pieces.first().map(|piece| piece.bend) else { return NOTHING };
        // The even part of a function that is convex, or concave, everywhere is monotone in |v|. At corners w
        // is continuous, and its slope must jump the same way.
        if bend != Bend::Unknown && pieces.iter().all(|piece| piece.bend == bend) && self.corners().is_empty()
        {
            let ends = [0.0, within].map(|v| self.even_at(belt_speed, v));
            return ends[0].hull(ends[1]);
        }
        self.even_range_by_pieces(belt_speed, within)
    }

    /// Bounds of the even part at one v.
    fn even_at(&self, belt_speed: f64, v: f64) -> Range {
        // The slip speeds are rounded.
        let near = self.range((belt_speed - v).next_down().max(0.0), (belt_speed - v).next_up());
        let far =
            self.range((belt_speed + v).next_down().max(0.0), (belt_speed + v).next_up().min(self.reach()));
        Range { lo: 0.5 * (near.lo + far.lo), hi: 0.5 * (near.hi + far.hi) }.widened(0.0)
    }

    /// The same, piece by piece between all ends on both sides of the belt speed, over slip speeds u below
    /// it; the far side has 2 V - u.
    fn even_range_by_pieces(&self, belt_speed: f64, within: f64) -> Range {
        let nearest = if within == belt_speed { 0.0 } else { (belt_speed - within).next_down() };
        let inside = |u: &f64| nearest < *u && *u < belt_speed;
        let mirrored = self.breaks.iter().map(|end| belt_speed - (end - belt_speed));
        let mut ends: Vec<f64> = self.breaks.iter().copied().chain(mirrored).filter(inside).collect();
        ends.extend([nearest, belt_speed]);
        ends.sort_by(f64::total_cmp);
        let parts = ends.windows(2).map(|pair| self.even_on(belt_speed, pair[0], pair[1]));
        parts.reduce(Range::hull).unwrap_or(NOTHING)
    }

    /// Bounds of the even part for slip speeds in [a, b] on the near side, within which no piece ends.
    fn even_on(&self, belt_speed: f64, a: f64, b: f64) -> Range {
        let mirror = |u: f64| belt_speed + (belt_speed - u);
        let piece = |u: f64| &self.pieces[self.piece_of(u.clamp(0.0, self.reach()))];
        let middle = 0.5 * (a + b);
        let (near, far) = (piece(middle), piece(mirror(middle)));
        // The far ends are rounded twice, by a unit in the last place of 2 V in all, which moves w in
        // proportion.
        let slip = 2.0 * f64::EPSILON * (belt_speed + belt_speed) * far.scale;
        let steepest: f64 = far.c.iter().zip(0_u8..).map(|(c, k)| f64::from(k) * c.abs()).sum();
        let error = 0.5 * (near.error + far.error + slip * steepest);
        if !error.is_finite() {
            return NOTHING;
        }
        let local = |piece: &Piece, from: f64, to: f64| {
            let [from, to] = [from, to].map(|u| (u - piece.middle) * piece.scale);
            piece.shifted(from, to)
        };
        let sum = local(near, a, b).plus(local(far, mirror(a), mirror(b)));
        let both = range_of_polynomial(&sum, HALVINGS);
        Range { lo: 0.5 * both.lo, hi: 0.5 * both.hi }.widened(error)
    }
}

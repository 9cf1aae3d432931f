//! Proved bounds, from coefficients, of the weakening rate over slip speeds and of its even part about the
//! belt speed.

use super::{COUNT, Piece, Sign, Weakening};
use crate::friction::Range;
use slipmap_numbers::jet::Real;

/// Number of pieces with a common hull, see [`Weakening::range`].
pub(super) const BLOCK: usize = 32;

/// The hulls of the ranges of all blocks of pieces.
pub(super) fn blocks(pieces: &[Piece]) -> Vec<Range> {
    let hull = |block: &[Piece]| block.iter().map(|piece| piece.range).reduce(Range::hull);
    pieces.chunks(BLOCK).filter_map(hull).collect()
}

const UNKNOWN: Range = Range { lo: f64::NEG_INFINITY, hi: f64::INFINITY };

/// Largest number of bisections in the search for a polynomial's extremes.
const HALVINGS: u32 = 26;
/// Width of the bounds of a piece, in units of its error, that is rounding: w is within 1 of the polynomial.
const ROUNDINGS: f64 = 4.0;
/// Largest number of steps of Newton's method to an extreme.
const STEPS: u32 = 8;

impl Piece {
    /// Proved bounds of w on the whole piece [a, b].
    pub(super) fn range_on(&self, a: f64, b: f64) -> Range {
        match self.slope {
            _ if !self.error.is_finite() => UNKNOWN,
            Sign::NotNegative | Sign::NotPositive => self.near(a).hull(self.near(b)),
            Sign::Unknown => self.range_between(a, b),
        }
    }

    /// Whether bounds on a part of the piece are not worth their time: w hardly changes on all of it beyond rounding errors, as
    /// where a steep law has fallen, or it has none.
    #[inline]
    fn is_flat(&self) -> bool {
        let Range { lo, hi } = self.range;
        !self.error.is_finite() || hi - lo <= (ROUNDINGS * self.error).max(f64::EPSILON * self.size)
    }

    /// Proved bounds of w at one slip speed.
    #[inline]
    fn near(&self, u: f64) -> Range {
        let value = self.at(u);
        Range { lo: value, hi: value }.widened(self.error)
    }

    /// Proved bounds of w on a part [a, b], whatever its trend.
    fn range_between(&self, a: f64, b: f64) -> Range {
        let [from, to] = [a, b].map(|u| (u - self.middle) * self.scale);
        range_of_polynomial(&self.shifted(from, to), HALVINGS).widened(self.error)
    }

    /// The polynomial in z, where x runs from `from` to `to` as z runs from -1 to 1.
    fn shifted(&self, from: f64, to: f64) -> Local {
        let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
        Local { c: self.c, noise: 0.0 }.shifted(middle, half)
    }
}

/// A polynomial on [-1, 1], and `noise`, a bound of its error due to the rounding of its coefficients.
#[derive(Clone, Copy)]
struct Local {
    c: [f64; COUNT],
    noise: f64,
}

impl Local {
    /// The polynomial in z with x = middle + half z, |x|, |z| <= 1, by repeated synthetic division.
    ///
    /// Coefficient k is half^k times the sum over j of c_j binomial(j, k) middle^(j-k), with at most
    /// 2 (j - k) + 2 roundings. With z = +-1 the moduli of the terms of one j sum to at most
    /// |c_j| (|middle| + |half|)^j <= |c_j|, up to rounding.
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

/// Proved bounds of a polynomial p on [-1, 1].
///
/// Where |p''| >= m > 0, an extreme of p exceeds p(z) by at most p'(z)^2 / (2 m): by Taylor's theorem the
/// excess at any z' is at most |p'(z) (z' - z)| - m (z' - z)^2 / 2, whose largest value this is.
fn range_of_polynomial(polynomial: &Local, halvings: u32) -> Range {
    let c = &polynomial.c;
    let [mut size, mut slope, mut bend] = [0.0; 3];
    for (k, c) in (2_u8..).map(f64::from).zip(&c[2..]) {
        size += c.abs();
        slope += k * c.abs();
        bend += k * (k - 1.0) * c.abs();
    }
    let unit = 8.0 * COUNT as f64 * f64::EPSILON;
    let swing = c[1].abs() + size;
    // The total error of products that underflow is less than the smallest normal number.
    let round_off = unit * (c[0].abs() + swing) + polynomial.noise + f64::MIN_POSITIVE;
    let [even, odd] = [0, 1].map(|from| c.iter().skip(from).step_by(2).sum::<f64>());
    let mut found = Range { lo: even - odd.abs(), hi: even + odd.abs() };
    if c[1].abs() >= slope * (1.0 + 1e-12) {
        // Monotone.
        return found.widened(round_off);
    }
    let least_bend = 4.0 * c[2].abs() - bend * (1.0 + 1e-12);
    if least_bend > 0.0 {
        let (z, slope_at) = flattest(c);
        let slope_at = slope_at.abs() + unit * (c[1].abs() + slope);
        let beyond = 0.5 * slope_at * slope_at / least_bend;
        if beyond <= 0.01 * round_off {
            let value = z.polynomial(c);
            if c[2] > 0.0 {
                found.lo = found.lo.min(value - beyond);
            } else {
                found.hi = found.hi.max(value + beyond);
            }
            return found.widened(round_off);
        }
    }
    let whole = Range { lo: c[0] - swing, hi: c[0] + swing }.widened(round_off);
    if halvings == 0 || swing <= round_off {
        return whole;
    }
    let halves = [-0.5, 0.5].map(|middle| polynomial.shifted(middle, 0.5));
    let [left, right] = halves.map(|half| range_of_polynomial(&half, halvings - 1));
    let both = left.hull(right);
    Range { lo: both.lo.max(whole.lo), hi: both.hi.min(whole.hi) }
}

/// By Newton's method, a place in [-1, 1] and the slope of the polynomial there. The slope is close to zero
/// if there is such a place with a second derivative that is not.
fn flattest(c: &[f64; COUNT]) -> (f64, f64) {
    let mut z: f64 = 0.0;
    let mut steps = 0;
    loop {
        let (mut slope, mut bend) = (0.0, 0.0);
        for (k, c) in c.iter().enumerate().skip(1).rev() {
            bend = bend * z + slope;
            slope = slope * z + k as f64 * c;
        }
        let next = (z - slope / bend).clamp(-1.0, 1.0);
        // NaN ends the loop as well.
        if steps == STEPS || !((next - z).abs() > f64::EPSILON) {
            return (z, slope);
        }
        (z, steps) = (next, steps + 1);
    }
}

impl Weakening {
    /// Proved bounds of w over slip speeds in [`lo`, `hi`], 0 <= lo <= hi; infinite if there are none, for
    /// instance beyond the reach.
    #[must_use]
    pub fn range(&self, lo: f64, hi: f64) -> Range {
        self.bounds(lo, hi)
    }

    /// Returns whether w is proved to be convex, or concave, on [0, `hi`].
    pub(crate) fn bends_one_way(&self, hi: f64) -> bool {
        let pieces = || self.pieces[..=self.piece_of(hi.min(self.reach()))].iter();
        let is_everywhere = |sign: Sign| pieces().all(|piece| piece.bend == sign);
        // The slope may jump the other way at a corner.
        hi <= self.reach()
            && self.corners().first().is_none_or(|corner| *corner >= hi)
            && [Sign::NotNegative, Sign::NotPositive].into_iter().any(is_everywhere)
    }

    /// The upper bound of [`Weakening::range`], at half the cost.
    pub(crate) fn highest(&self, lo: f64, hi: f64) -> f64 {
        self.bounds(lo, hi).hi
    }

    #[inline(always)]
    fn bounds(&self, lo: f64, hi: f64) -> Range {
        if !(0.0 <= lo && lo <= hi && hi <= self.reach()) {
            return UNKNOWN;
        }
        let (first, last) = (self.piece_of(lo), self.piece_of(hi));
        let mut range = self.part(first, lo, hi);
        if last > first {
            range = range.hull(self.part(last, lo, hi));
        }
        let mut i = first + 1;
        while i < last {
            let whole_block = i % BLOCK == 0 && i + BLOCK <= last;
            range = range.hull(if whole_block { self.blocks[i / BLOCK] } else { self.pieces[i].range });
            i += if whole_block { BLOCK } else { 1 };
        }
        range
    }

    /// Proved bounds of w on the part of a piece in [`lo`, `hi`], which must not be empty.
    #[inline(always)]
    fn part(&self, piece: usize, lo: f64, hi: f64) -> Range {
        let [start, end] = [self.breaks[piece], self.breaks[piece + 1]];
        let piece = &self.pieces[piece];
        // At the ends of a monotone piece the bounds are those of the whole piece.
        let low = || if lo > start { piece.near(lo) } else { piece.range };
        let high = || if hi < end { piece.near(hi) } else { piece.range };
        match piece.slope {
            Sign::NotNegative => Range { lo: low().lo, hi: high().hi },
            Sign::NotPositive => Range { lo: high().lo, hi: low().hi },
            Sign::Unknown if lo <= start && end <= hi || piece.is_flat() => piece.range,
            Sign::Unknown => piece.range_between(lo.max(start), hi.min(end)),
        }
    }

    /// Proved bounds, over 0 <= v <= `within` <= V, of the even part in v of w(V - v); infinite where there
    /// are none.
    #[must_use]
    pub fn even_range(&self, belt_speed: f64, within: f64) -> Range {
        let farthest = belt_speed + within;
        if !(within >= 0.0 && within <= belt_speed && farthest <= self.reach()) {
            return UNKNOWN;
        }
        let nearest = belt_speed - within;
        let pieces = &self.pieces[self.pieces_between(nearest, farthest.next_up().min(self.reach()))];
        let Some(bend) = pieces.first().map(|piece| piece.bend) else { return UNKNOWN };
        // The even part of a function that is convex, or concave, everywhere is monotone in |v|. A law with
        // corners is excluded, since its slope may jump the other way there.
        if bend != Sign::Unknown && pieces.iter().all(|piece| piece.bend == bend) && self.corners().is_empty()
        {
            let ends = [0.0, within].map(|v| self.even_at(belt_speed, v));
            return ends[0].hull(ends[1]);
        }
        self.even_range_by_pieces(belt_speed, within)
    }

    /// Bounds of the even part at one v.
    fn even_at(&self, belt_speed: f64, v: f64) -> Range {
        // The computed slip speeds are rounded, so they are enclosed.
        let near = self.range((belt_speed - v).next_down().max(0.0), (belt_speed - v).next_up());
        let far =
            self.range((belt_speed + v).next_down().max(0.0), (belt_speed + v).next_up().min(self.reach()));
        Range { lo: 0.5 * (near.lo + far.lo), hi: 0.5 * (near.hi + far.hi) }.widened(0.0)
    }

    /// The bounds of [`Weakening::even_range`], part by part. The parts are ranges of slip speeds u below the
    /// belt speed; each lies between neighbouring ends of pieces, as does its mirror image 2 V - u.
    fn even_range_by_pieces(&self, belt_speed: f64, within: f64) -> Range {
        let nearest = if within == belt_speed { 0.0 } else { (belt_speed - within).next_down() };
        let far_end = |end: &f64| belt_speed - (end - belt_speed);
        let [first, middle] = [nearest, belt_speed].map(|u| self.piece_of(u));
        let last = self.piece_of((belt_speed + within).min(self.reach()));
        let inside = |u: &f64| nearest < *u && *u < belt_speed;
        let near = self.breaks[first..=middle].iter().copied();
        let far = self.breaks[middle..=last + 1].iter().map(far_end);
        let mut ends: Vec<f64> = near.chain(far).filter(inside).collect();
        ends.extend([nearest, belt_speed]);
        ends.sort_by(f64::total_cmp);
        let parts: Vec<EvenPart> =
            ends.windows(2).map(|pair| EvenPart::new(self, belt_speed, pair[0], pair[1])).collect();
        let highest = parts.iter().max_by(|a, b| a.coarse.hi.total_cmp(&b.coarse.hi));
        let lowest = parts.iter().min_by(|a, b| a.coarse.lo.total_cmp(&b.coarse.lo));
        let mut found: Option<Range> = None;
        // Most other parts cannot exceed the range of these two.
        for part in highest.into_iter().chain(lowest).chain(&parts) {
            found = match found {
                Some(range) if range.contains(part.coarse) => Some(range),
                Some(range) => Some(range.hull(part.range())),
                None => Some(part.range()),
            };
        }
        found.unwrap_or(UNKNOWN)
    }
}

/// A range of slip speeds [a, b] below the belt speed. No piece ends within it, or within its mirror image,
/// from 2 V - b to 2 V - a, beyond the belt speed.
struct EvenPart<'a> {
    near: &'a Piece,
    far: &'a Piece,
    /// [a, b], and 2 V - a, 2 V - b.
    ends: [[f64; 2]; 2],
    /// Bounds of the even part that follow from the bounds of w on both pieces.
    coarse: Range,
    error: f64,
}

impl<'a> EvenPart<'a> {
    fn new(law: &'a Weakening, belt_speed: f64, a: f64, b: f64) -> Self {
        let mirror = |u: f64| belt_speed + (belt_speed - u);
        let piece = |u: f64| &law.pieces[law.piece_of(u.clamp(0.0, law.reach()))];
        let middle = 0.5 * (a + b);
        let (near, far) = (piece(middle), piece(mirror(middle)));
        // The far ends are rounded twice, by a unit in the last place of 2 V in all; the change of w is
        // bounded by this times its steepest slope.
        let slip = 2.0 * f64::EPSILON * (belt_speed + belt_speed) * far.scale;
        let steepest: f64 = far.c.iter().zip(0_u8..).map(|(c, k)| f64::from(k) * c.abs()).sum();
        let error = 0.5 * (near.error + far.error + slip * steepest);
        let [lo, hi] = [near.range.lo + far.range.lo, near.range.hi + far.range.hi];
        let coarse = Range { lo: 0.5 * lo, hi: 0.5 * hi }.widened(0.5 * slip * steepest);
        Self { near, far, ends: [[a, b], [mirror(a), mirror(b)]], coarse, error }
    }

    /// Bounds of the even part.
    fn range(&self) -> Range {
        if !self.error.is_finite() {
            return UNKNOWN;
        }
        let local = |piece: &Piece, ends: [f64; 2]| {
            let [from, to] = ends.map(|u| (u - piece.middle) * piece.scale);
            piece.shifted(from, to)
        };
        let sum = local(self.near, self.ends[0]).plus(local(self.far, self.ends[1]));
        let both = range_of_polynomial(&sum, HALVINGS);
        Range { lo: 0.5 * both.lo, hi: 0.5 * both.hi }.widened(self.error)
    }
}

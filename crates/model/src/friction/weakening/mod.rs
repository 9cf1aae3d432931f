//! The compiled weakening rate: w(u) = -phi'(u) of one curve as polynomials on pieces of slip speeds. Engines
//! and tests use every friction law in this form.
//!
//! A curve is compiled once ([`super::Curve::compiled`]) for all belt speeds and dampings, since w does not
//! depend on them. The polynomials have a bound of `|w - polynomial|` that includes the round-off of
//! [`Weakening::at`]. By the comparison lemma of [`slipmap_certify`] an error delta of w moves the critical
//! damping, and the damping at which an orbit of any amplitude closes, by at most delta / eps (theory, "One
//! form for every law").
//!
//! **Error.** A formula is interpolated at the n = [`COUNT`] Chebyshev points of each piece, of half-width h.
//! The error of the exact interpolant is at most `max |w^(n)| / n! * 2 (h / 2)^n`, where interval arithmetic
//! on Taylor series bounds the derivative over the whole piece. A polynomial that misses the values at the
//! points by at most r differs from the exact interpolant by at most Lambda r; the Lebesgue constant of these
//! points is at most Lambda = 1 + (2/pi) ln n. (L. N. Trefethen, Approximation Theory and Approximation
//! Practice, SIAM 2013, chapters 8 and 15.) A table's weakening rate is a parabola on each piece, exact
//! except for rounding. Where the law has no enclosure, or would need too many pieces, the error is not
//! proved but [`Accuracy::Sampled`].

mod compile;
mod range;

use super::{Form, Range, mean};
use slipmap_numbers::interval::Interval;

pub(super) use compile::{compile, compile_in_unit};

/// Length of a first piece, in units of the reach, that only a law without derivatives at rest has.
const NO_LENGTH: f64 = 1e-18;
/// Error, in units of the largest |w|, above which a polynomial does not resolve the law.
const RESOLVED: f64 = 0.1;

/// Number of coefficients of a piece.
pub const COUNT: usize = 12;

/// The distance of the polynomials from the law.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Accuracy {
    /// A proved bound, round-off included; see [`Weakening::error`] for the first piece of a power of the slip speed.
    Proved(f64),
    /// An estimate by comparison at some slip speeds.
    Sampled(f64),
}

impl Accuracy {
    /// The bound or estimate.
    pub fn bound(self) -> f64 {
        match self {
            Accuracy::Proved(bound) | Accuracy::Sampled(bound) => bound,
        }
    }
}

/// The weakening rate of one curve on slip speeds from 0 up to `Weakening::reach`.
#[derive(Clone, Debug)]
pub struct Weakening {
    /// The law itself, for slip speeds outside the pieces.
    law: Form,
    /// Ends of the pieces: the first is 0, the last the reach.
    breaks: Vec<f64>,
    pieces: Vec<Piece>,
    /// The slip speed up to which the law was compiled at once. From there on it was compiled in steps that
    /// double the reach, so that forms with a smaller reach are beginnings of this one.
    base: f64,
    places: Places,
    /// Hulls of the ranges of [`range::BLOCK`] pieces each, which make bounds over many pieces fast.
    blocks: Vec<Range>,
    /// Sizes of the jumps of w' at the ends of the pieces; empty where the law has no corners.
    jumps: Vec<f64>,
    /// See [`Weakening::narrow`].
    narrow: Vec<f64>,
    /// See [`Weakening::layers`].
    layers: Vec<f64>,
    /// Number of coefficients up to the last that is not zero in all pieces: at most three for a table.
    terms: usize,
}

/// Largest length of a narrow piece, in units of its upper end.
const NARROW: f64 = 1.0 / 200.0;
/// Place below 0 at which the law is compared with the polynomial of the first piece, in units of its length,
/// and the largest difference of one that continues the other, in units of the largest |w|. The polynomial
/// itself errs by a hundred times its error on the piece.
const BELOW: f64 = 0.05;
const LARGEST_OFF: f64 = 1e-11;
/// Number of neighbouring narrow pieces after which integrators must end a step.
const NARROW_TOGETHER: usize = 6;

/// The ends of each range of neighbouring narrow pieces, and some of the ends inside it.
fn narrow_ends(breaks: &[f64]) -> Vec<f64> {
    let mut count = 0;
    let ends = breaks.windows(2).filter_map(|ends| {
        let (is_narrow, was_narrow) = (ends[1] - ends[0] < NARROW * ends[1], count > 0);
        count = if is_narrow { count + 1 } else { 0 };
        (is_narrow != was_narrow || count % NARROW_TOGETHER == 1).then_some(ends[0])
    });
    ends.collect()
}

/// Number of neighbouring pieces in a layer. A bump of w that polynomials follow to rounding has a dozen or more, and a step
/// of an integrator has a stage in every third of it.
const IN_LAYER: usize = 3;

/// The ends of layers: of neighbouring pieces, together with those before them on which friction changes by no more than
/// rounding.
fn layers(sizes: impl Iterator<Item = ([f64; 2], f64)>) -> Vec<f64> {
    let (mut change, mut pieces) = (0.0, 0);
    let ends = sizes.filter_map(|([from, to], size)| {
        change += size * (to - from);
        pieces = if change > f64::EPSILON { pieces + 1 } else { 0 };
        let is_whole = pieces == IN_LAYER;
        (change, pieces) = if is_whole { (0.0, 0) } else { (change, pieces) };
        is_whole.then_some(to)
    });
    ends.collect()
}

/// Sizes of the jumps of w' at the breaks of a law with corners; empty for other laws.
fn jumps(law: &Form, breaks: &[f64], pieces: &[Piece]) -> Vec<f64> {
    if law.corners().is_empty() {
        return Vec::new();
    }
    let jump = |i: usize| (pieces[i].slope_at(breaks[i]) - pieces[i - 1].slope_at(breaks[i])).abs();
    (0..breaks.len()).map(|i| if i == 0 || i == pieces.len() { 0.0 } else { jump(i) }).collect()
}

/// A piece: a polynomial in x = (u - middle) * scale, x in [-1, 1], and proved properties of w there.
#[derive(Clone, Debug)]
struct Piece {
    middle: f64,
    scale: f64,
    /// Coefficients of 1, x, x^2, ...
    c: [f64; COUNT],
    /// Proved bound of |w - [`Piece::at`]|; infinite where there is none.
    error: f64,
    /// Sampled estimate of that distance.
    estimate: f64,
    /// Proved bounds of w; infinite where there are none.
    range: Range,
    /// Sign of w' on the whole piece.
    slope: Sign,
    /// Sign of w'' on the whole piece.
    bend: Sign,
    /// Largest |w| at the points of this piece and of all pieces before it.
    size: f64,
}

/// A piece for proofs: a polynomial, and a bound of its distance from w.
#[derive(Clone, Copy, Debug)]
pub struct ProvedPiece<'a> {
    /// Slip speeds on which the bound holds. The first piece reaches to minus infinity: below 0 its
    /// polynomial continues the law.
    pub ends: [f64; 2],
    /// The variable of the polynomial is x = (u - middle) * scale.
    pub middle: f64,
    /// See `middle`.
    pub scale: f64,
    /// Coefficients of 1, x, x^2, ...
    pub c: &'a [f64; COUNT],
    /// Bound of |w - polynomial| for u >= 0, both exact; infinite where there is none.
    pub error: f64,
}

/// The polynomial of a piece, in x = (u - middle) * scale.
#[derive(Clone, Copy, Debug)]
pub struct Polynomial<'a> {
    /// The slip speed at x = 0.
    pub middle: f64,
    /// The change of x per slip speed.
    pub scale: f64,
    /// Coefficients of 1, x, x^2, ... up to the last that is not zero.
    pub c: &'a [f64],
}

/// What is proved of the sign of a derivative on a piece.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sign {
    /// It is >= 0.
    NotNegative,
    /// It is <= 0.
    NotPositive,
    /// Nothing.
    Unknown,
}

impl Sign {
    /// The sign of what lies in `within`.
    fn of(within: Interval) -> Self {
        match within {
            _ if within.lo >= 0.0 => Sign::NotNegative,
            _ if within.hi <= 0.0 => Sign::NotPositive,
            _ => Sign::Unknown,
        }
    }
}

impl Piece {
    /// The polynomial at slip speed `u`. Even and odd powers are summed separately, which halves the chain of
    /// operations. No operation is fused, so that results do not depend on the machine.
    #[inline(always)]
    fn at(&self, u: f64) -> f64 {
        let x = (u - self.middle) * self.scale;
        let y = x * x;
        let c = &self.c;
        let even = c[0] + y * (c[2] + y * (c[4] + y * (c[6] + y * (c[8] + y * c[10]))));
        let odd = c[1] + y * (c[3] + y * (c[5] + y * (c[7] + y * (c[9] + y * c[11]))));
        even + x * odd
    }

    /// Derivative of the polynomial with respect to u.
    fn slope_at(&self, u: f64) -> f64 {
        let x = (u - self.middle) * self.scale;
        let terms = self.c.iter().enumerate().skip(1).rev();
        terms.fold(0.0, |sum, (k, c)| sum * x + k as f64 * c) * self.scale
    }

    /// Bound of the round-off of [`Piece::at`] for x within [-1, 1].
    ///
    /// x carries two roundings and its square one more, so that a term of order k carries at most 2 + 3 k;
    /// each of the six levels of the two chains adds two, and their sum adds two. In all, this is less than
    /// 6 (k + 3) units of 2^-53.
    fn round_off(c: &[f64; COUNT]) -> f64 {
        let sum: f64 = c.iter().zip(3_u8..).map(|(c, k)| c.abs() * f64::from(k)).sum();
        3.0 * f64::EPSILON * sum
    }
}

/// Index of the pieces: the leading bits of a slip speed, in floating-point representation, lead to a piece
/// at or before that slip speed.
#[derive(Debug, Default, Clone)]
struct Places {
    /// Key of the first entry.
    first: u64,
    /// For each key the number of a piece that does not begin beyond the least slip speed of the key.
    pieces: Vec<u32>,
}

/// Number of bits of the mantissa in a key: 2^5 keys for each power of two.
const KEY_BITS: u32 = 5;
/// Number of octaves below the reach that have keys.
const KEY_OCTAVES: u64 = 32;

impl Places {
    /// The key of |u|, so that -0 has the key of 0.
    fn key(u: f64) -> u64 {
        u.abs().to_bits() >> (52 - KEY_BITS)
    }

    fn of(breaks: &[f64]) -> Self {
        let reach = breaks[breaks.len() - 1];
        let last = Self::key(reach);
        let first = last.saturating_sub(KEY_OCTAVES << KEY_BITS);
        let mut piece = 0;
        let pieces = (first..=last).map(|key| {
            let least = f64::from_bits(key << (52 - KEY_BITS));
            while piece + 2 < breaks.len() && breaks[piece + 1] <= least {
                piece += 1;
            }
            piece as u32
        });
        Self { first, pieces: pieces.collect() }
    }

    /// A piece that does not begin beyond `u`, 0 <= u <= reach; `None` if u is below all keys.
    #[inline(always)]
    fn guess(&self, u: f64) -> Option<usize> {
        let key = Self::key(u).checked_sub(self.first)?;
        Some(self.pieces[key as usize] as usize)
    }
}

impl Weakening {
    /// The slip speed up to which there are pieces.
    pub fn reach(&self) -> f64 {
        self.breaks[self.breaks.len() - 1]
    }

    /// Ends of the pieces, from 0 to the reach. Except at [`corners`](Weakening::corners) the law is smooth
    /// there, and neighbouring polynomials agree within their errors.
    pub fn breaks(&self) -> &[f64] {
        &self.breaks
    }

    /// Slip speeds > 0, increasing, at which the slope of w jumps.
    pub fn corners(&self) -> &[f64] {
        self.law.corners()
    }

    /// Slip speeds, increasing, in and around features of the law that are narrow compared with the slip
    /// speed: a long step of an integrator may pass one without a sample in it. Empty for tables.
    pub(crate) fn narrow(&self) -> &[f64] {
        &self.narrow
    }

    /// Slip speeds, increasing, between which there are a few pieces each: a step of an integrator that goes from one such layer
    /// beyond the next may miss a feature of the law.
    pub(crate) fn layers(&self) -> &[f64] {
        &self.layers
    }

    /// Returns whether the formula below 0 continues the polynomial there, and nothing is narrow.
    pub(crate) fn is_analytic(&self) -> bool {
        self.narrow.is_empty() && self.is_continued()
    }

    /// Returns whether the formula below 0 continues the polynomial there. A formula with |u|, or with a root or a
    /// power of u, has another continuation.
    pub(crate) fn is_continued(&self) -> bool {
        let Piece { size, .. } = self.pieces[0];
        let below = -BELOW * self.breaks[1];
        let off = self.law.weakening(below) - self.pieces[0].at(below);
        off.abs() <= LARGEST_OFF * size && self.breaks[1] >= NO_LENGTH * self.reach()
    }

    /// The size of the jump of w' at the break with this number, for a law with corners.
    #[inline(always)]
    pub fn jump(&self, number: usize) -> f64 {
        self.jumps[number]
    }

    /// The number of the piece that contains `u`, 0 <= u <= reach.
    #[inline(always)]
    pub fn piece_of(&self, u: f64) -> usize {
        let Some(mut piece) = self.places.guess(u) else { return self.piece_next_to_zero(u) };
        while piece + 1 < self.pieces.len() && self.breaks[piece + 1] <= u {
            piece += 1;
        }
        piece
    }

    /// As `piece_of` below all keys, where a law that is steep at rest may have a thousand octaves of pieces.
    #[cold]
    fn piece_next_to_zero(&self, u: f64) -> usize {
        let below_keys = self.places.pieces[0] as usize;
        self.breaks[1..=below_keys].partition_point(|end| *end <= u)
    }

    /// The polynomial of a piece, see [`Weakening::piece_of`].
    #[inline(always)]
    pub fn polynomial(&self, piece: usize) -> Polynomial<'_> {
        let Piece { middle, scale, ref c, .. } = self.pieces[piece];
        Polynomial { middle, scale, c: &c[..self.terms] }
    }

    /// w(u): within [0, reach] from the polynomials, else from the law (below 0, its continuation).
    #[inline(always)]
    pub fn at(&self, u: f64) -> f64 {
        if u >= 0.0 && u <= self.reach() {
            self.pieces[self.piece_of(u)].at(u)
        } else {
            self.law.weakening(u)
        }
    }

    /// w'(u) by the polynomials; outside of [0, reach] that at the nearer end.
    pub fn slope(&self, u: f64) -> f64 {
        let u = u.clamp(0.0, self.reach());
        self.pieces[self.piece_of(u)].slope_at(u)
    }

    /// The ends of each piece, with a bound of |w| on it; by its coefficients where nothing is proved.
    pub fn sizes(&self) -> impl Iterator<Item = ([f64; 2], f64)> {
        self.breaks.windows(2).zip(&self.pieces).map(|(ends, Piece { range, c, .. })| {
            let size = range.lo.abs().max(range.hi.abs());
            ([ends[0], ends[1]], if size.is_finite() { size } else { c.iter().map(|c| c.abs()).sum() })
        })
    }

    /// The pieces that meet [`lo`, `hi`], 0 <= lo <= hi <= reach.
    fn pieces_between(&self, lo: f64, hi: f64) -> std::ops::RangeInclusive<usize> {
        self.piece_of(lo)..=self.piece_of(hi)
    }

    /// The pieces that meet [`lo`, `hi`], lo <= hi, up to the reach.
    pub fn proved_pieces(&self, lo: f64, hi: f64) -> impl Iterator<Item = ProvedPiece<'_>> {
        let [lo, hi] = [lo, hi].map(|u| u.clamp(0.0, self.reach()));
        self.pieces_between(lo, hi).map(|i| {
            let Piece { middle, scale, ref c, error, .. } = self.pieces[i];
            let from = if i == 0 { f64::NEG_INFINITY } else { self.breaks[i] };
            // The bound of the piece holds for the computed polynomial, and exceeds its round-off.
            ProvedPiece { ends: [from, self.breaks[i + 1]], middle, scale, c, error: 2.0 * error }
        })
    }

    /// Returns whether the polynomials resolve the law for slip speeds in [`lo`, `hi`], up to the reach. They
    /// do not if the law has more waves than there may be pieces.
    pub fn is_resolved(&self, lo: f64, hi: f64) -> bool {
        let largest = self.pieces[self.piece_of(hi.clamp(0.0, self.reach()))].size;
        self.error(lo, hi).bound() <= RESOLVED * largest
    }

    /// The same polynomials, with `error` as the bound of their error.
    #[must_use]
    pub fn with_error(self, error: f64) -> Self {
        let pieces = self.pieces.into_iter().map(|piece| Piece { error, ..piece }).collect();
        Self { pieces, ..self }
    }

    /// The integral over slip speeds in [`lo`, `hi`], up to the reach, of the distance of the polynomials from the law: a bound
    /// where each piece has one, else an estimate.
    #[must_use]
    pub fn integrated_error(&self, lo: f64, hi: f64) -> f64 {
        let [lo, hi] = [lo, hi].map(|u| u.clamp(0.0, self.reach()));
        let of = |i: usize| {
            let Piece { error, estimate, .. } = self.pieces[i];
            let width = self.breaks[i + 1].min(hi) - self.breaks[i].max(lo);
            width.max(0.0) * if error.is_finite() { error } else { estimate }
        };
        self.pieces_between(lo, hi).map(of).sum()
    }

    /// The mean of w over the grazing circle, see [`super::Curve::mean_weakening`], by its polynomials, and how far that of the
    /// law may be from it, rounding apart: the mean of their distances, by samples where a law has no formula. NaN where the pieces end below twice the belt speed.
    pub(super) fn mean(&self, belt_speed: f64) -> [f64; 2] {
        let is_sampled = matches!(self.law, Form::Function(_) | Form::Custom(_));
        let Some(ends) = self.ends_of_turn(belt_speed) else { return [f64::NAN; 2] };
        let distance = |i: usize, _| {
            let Piece { error, estimate, .. } = self.pieces[i];
            // Samples miss what is narrower than a piece.
            if is_sampled { estimate } else { error }
        };
        let mean = mean::between(ends, |i, u| self.pieces[i].at(u), belt_speed);
        [mean, mean::rough(ends, distance, belt_speed)]
    }

    /// About the mean, for searches to begin with.
    pub(super) fn rough_mean(&self, belt_speed: f64) -> f64 {
        let ends = self.ends_of_turn(belt_speed);
        ends.map_or(f64::NAN, |ends| mean::rough(ends, |i, u| self.pieces[i].at(u), belt_speed))
    }

    /// The ends of the pieces that meet the slip speeds of the grazing circle.
    fn ends_of_turn(&self, belt_speed: f64) -> Option<&[f64]> {
        let is_known = 2.0 * belt_speed <= self.reach();
        is_known.then(|| &self.breaks[..=self.piece_of(2.0 * belt_speed) + 1])
    }

    /// The distance of the polynomials from the law for slip speeds in [`lo`, `hi`], up to the reach.
    ///
    /// Next to rest a power of the slip speed that is not whole has a distance which does not fall to the rounding
    /// errors, however short the first piece, [0, h]. As C moves by the mean of the distance over a turn with the weight
    /// sin^2 th, and th moves at least by the square root of 2 h / V while the slip speed passes h, a first piece of
    /// almost no length counts as far as it moves C, and so do all others together: the mean over it is less than 2 h / V of
    /// the distance, and the reach is at most 8 V.
    #[must_use]
    pub fn error(&self, lo: f64, hi: f64) -> Accuracy {
        let [lo, hi] = [lo, hi].map(|u| u.clamp(0.0, self.reach()));
        let share = self.breaks[1] / self.reach();
        let share = if share < NO_LENGTH { 16.0 * share } else { 1.0 };
        let largest = |of: fn(&Piece) -> f64| {
            let (first, pieces) = (&self.pieces[0], self.pieces_between(lo, hi));
            let of_first = if *pieces.start() == 0 { share * of(first) } else { 0.0 };
            let of_others = pieces.filter(|i| *i > 0).map(|i| of(&self.pieces[i])).fold(0.0, f64::max);
            if share < 1.0 { of_first + of_others } else { of_first.max(of_others) }
        };
        match largest(|piece| piece.error) {
            proved if proved.is_finite() => Accuracy::Proved(proved),
            _ => Accuracy::Sampled(largest(|piece| piece.estimate)),
        }
    }
}

#[cfg(test)]
mod tests;

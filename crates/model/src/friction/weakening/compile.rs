//! Compiles the weakening rate of a curve to piecewise polynomials with bounds or estimates of their errors.

use std::sync::{Arc, LazyLock};

use super::{COUNT, Piece, Places, Sign, Weakening};
use crate::friction::{Form, Range, Table};
use slipmap_numbers::chebyshev::{points, transform};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::Jet;

/// Largest number of pieces of a curve, and its quota of work in evaluations of the Stribeck law: a fifth of a second. The
/// remaining ranges are then accepted, whatever their errors.
const MOST_PIECES: usize = 4096;
const QUOTA: u64 = 4_000_000;
/// Number of pieces above which forms of one curve, with different reaches, are no longer kept: some ten megabytes.
const MOST_KEPT: usize = 16 * MOST_PIECES;
/// Largest number of bisections of the first piece.
const MOST_HALVINGS: u32 = 64;
/// Least reach of a form that may be the beginning of a longer one.
const LEAST_SHARED: f64 = 0.03125;
/// Target of the truncation error, in units of the largest |w| so far.
const SHARPNESS: f64 = 2.0 * f64::EPSILON;
/// Width of the enclosure of a coefficient that leaves the normal numbers, after a few hundred operations.
/// Shorter pieces do not reduce this width.
const UNDERFLOW: f64 = 256.0 * f64::MIN_POSITIVE;
/// Change of phi over half a piece below which a residual of w may be due to the rounding of its values.
const ROUNDED: f64 = 64.0 * f64::EPSILON;
/// Bound of the Lebesgue constant of the points, 1 + (2 / pi) ln 12 = 2.582, with an allowance for the
/// rounding of the points.
const LEBESGUE: f64 = 2.6;
/// Allowance for the rounding of the points in the product of the distances to them.
const ROOM: f64 = 1.001;

/// The Chebyshev points of the first kind in [-1, 1]. They do not include the ends of a piece, where a formula may be
/// undefined.
static POINTS: LazyLock<[f64; COUNT]> = LazyLock::new(points);
/// Chebyshev coefficient k as a sum of the values at the points.
static TRANSFORM: LazyLock<[[f64; COUNT]; COUNT]> = LazyLock::new(transform);
/// Coefficients of the Chebyshev polynomials, which are integers.
static POWERS: LazyLock<[[f64; COUNT]; COUNT]> = LazyLock::new(|| {
    let mut powers = [[0.0; COUNT]; COUNT];
    (powers[0][0], powers[1][1]) = (1.0, 1.0);
    for k in 2..COUNT {
        for i in 0..COUNT {
            let shifted = if i > 0 { powers[k - 1][i - 1] } else { 0.0 };
            powers[k][i] = 2.0 * shifted - powers[k - 2][i];
        }
    }
    powers
});

/// The polynomial through values at the points, and the sum of its last two |Chebyshev coefficients|.
fn fit(values: &[f64; COUNT]) -> ([f64; COUNT], f64) {
    let chebyshev: [f64; COUNT] =
        std::array::from_fn(|k| TRANSFORM[k].iter().zip(values).map(|(weight, value)| weight * value).sum());
    let mut c = [0.0; COUNT];
    for (coefficient, powers) in chebyshev.iter().zip(POWERS.iter()) {
        for (c, power) in c.iter_mut().zip(powers) {
            *c += coefficient * power;
        }
    }
    (c, chebyshev[COUNT - 2].abs() + chebyshev[COUNT - 1].abs())
}

/// Compiles `law` up to the slip speed `reach`; a table up to its end.
///
/// Up to half the reach the pieces are those of the form with half the reach, unless one piece is enough for
/// the whole. They are taken, if possible, from `known`, the forms of this law, to which the result is added.
pub(in crate::friction) fn compile(
    law: &Form,
    reach: f64,
    known: &mut Vec<Arc<Weakening>>,
) -> Arc<Weakening> {
    if let Some(known) = known.iter().find(|known| known.reach() == reach) {
        return Arc::clone(known);
    }
    let most = MOST_PIECES.min((QUOTA / law.work_of_piece()) as usize);
    let mut compiler = Compiler { law, breaks: vec![0.0], pieces: Vec::new(), size: 0.0, most };
    let base = match law {
        Form::Table(table) => {
            compile_table(table, &mut compiler.breaks, &mut compiler.pieces);
            f64::INFINITY
        }
        law if law.seams().is_empty() => compiler.compile_doubled(reach, known),
        _ => {
            compiler.compile(reach);
            f64::INFINITY
        }
    };
    let Compiler { breaks, pieces, .. } = compiler;
    keep(Weakening::of(law, breaks, pieces, base), known)
}

/// Adds a form to those that are kept of a curve.
fn keep(compiled: Weakening, known: &mut Vec<Arc<Weakening>>) -> Arc<Weakening> {
    let compiled = Arc::new(compiled);
    while known.iter().map(|form| form.pieces.len()).sum::<usize>() > MOST_KEPT
        && let Some(shortest) =
            (0..known.len()).min_by(|&i, &j| known[i].reach().total_cmp(&known[j].reach()))
    {
        // Longer forms contain the pieces of shorter ones.
        known.swap_remove(shortest);
    }
    known.push(Arc::clone(&compiled));
    compiled
}

/// The form of a formula whose slip speed is in units of `unit`, up to at least `reach`, of the `written` form of the formula
/// itself: the form of the formula is made once for all units.
pub(in crate::friction) fn compile_in_unit(
    law: &Form,
    unit: f64,
    written: &Weakening,
    known: &mut Vec<Arc<Weakening>>,
) -> Arc<Weakening> {
    let reach = speed_in(unit, written.reach());
    match known.iter().find(|known| known.reach() == reach) {
        Some(known) => Arc::clone(known),
        None => keep(written.in_unit(law, unit), known),
    }
}

/// A slip speed in this unit, rounded down.
fn speed_in(unit: f64, speed: f64) -> f64 {
    (speed / unit).next_down()
}

impl Weakening {
    fn of(law: &Form, breaks: Vec<f64>, pieces: Vec<Piece>, base: f64) -> Self {
        let places = Places::of(&breaks);
        let blocks = super::range::blocks(&pieces);
        let jumps = super::jumps(law, &breaks, &pieces);
        let narrow = match law {
            Form::Table(_) => Vec::new(),
            _ => super::narrow_ends(&breaks),
        };
        let of_piece = |piece: &Piece| piece.c.iter().rposition(|c| *c != 0.0).map_or(1, |last| last + 1);
        let terms = pieces.iter().map(of_piece).max().unwrap_or(COUNT);
        let layers = Vec::new();
        let form =
            Self { law: law.clone(), breaks, pieces, base, places, blocks, jumps, narrow, layers, terms };
        Self { layers: super::layers(form.sizes()), ..form }
    }

    /// The form of the `law` that is this one with its slip speed in units of `unit`: `unit` w(`unit` u).
    ///
    /// Ends, middles and scales are rounded. So x moves by the rounding error of one number that is about the largest slip
    /// speed of the piece times its scale, and a piece may reach beyond its end by that of the end: there w is within the
    /// errors of the polynomial of the neighbour, which moves by less than its steepest slope times that reach. No slip
    /// speed lies beyond the last end.
    fn in_unit(&self, law: &Form, unit: f64) -> Self {
        // |dp/dx| where |x| <= 1 + 1/64: |x|^10 < 1.25.
        let steepest = |piece: &Piece| -> f64 {
            1.25 * piece.c.iter().zip(0_u8..).map(|(c, k)| f64::from(k) * c.abs()).sum::<f64>()
        };
        let scaled = |i: usize| {
            let piece = &self.pieces[i];
            let [from, to] = [self.breaks[i], self.breaks[i + 1]];
            let moved = f64::EPSILON * (1.0 + to * piece.scale) * steepest(piece);
            let beyond = |neighbour: Option<&Piece>, end: f64| {
                neighbour
                    .map_or([0.0; 2], |it| [2.0 * it.error, f64::EPSILON * end * it.scale * steepest(it)])
            };
            let before = beyond(i.checked_sub(1).map(|i| &self.pieces[i]), from);
            let after = beyond(self.pieces.get(i + 1), to);
            let is_wide = f64::EPSILON * to * piece.scale < 1.0 / 64.0;
            let c = piece.c.map(|c| c * unit);
            let rounded = f64::MIN_POSITIVE + f64::EPSILON * c.iter().map(|c| c.abs()).sum::<f64>();
            let moved = moved + before[1].max(after[1]);
            let error = ROOM * (unit * (piece.error + before[0].max(after[0]) + moved) + rounded);
            let error = if is_wide { error } else { f64::INFINITY };
            Piece {
                middle: piece.middle / unit,
                scale: piece.scale * unit,
                c,
                error,
                estimate: unit * (piece.estimate + moved),
                range: Range { lo: piece.range.lo * unit, hi: piece.range.hi * unit }.widened(error),
                size: piece.size * unit,
                ..*piece
            }
        };
        let pieces = (0..self.pieces.len()).map(scaled).collect();
        let mut breaks: Vec<f64> = self.breaks.iter().map(|end| end / unit).collect();
        if let Some(last) = breaks.last_mut() {
            *last = speed_in(unit, self.reach());
        }
        Self::of(law, breaks, pieces, f64::INFINITY)
    }
}

struct Compiler<'a> {
    law: &'a Form,
    breaks: Vec<f64>,
    pieces: Vec<Piece>,
    /// Largest |w| so far.
    size: f64,
    /// Largest number of pieces.
    most: usize,
}

impl Compiler<'_> {
    /// Compiles a law with seams from 0 to `reach`, from seam to seam.
    fn compile(&mut self, reach: f64) {
        let seams = self.law.seams().iter().copied().filter(|seam| 0.0 < *seam && *seam < reach);
        let mut from = 0.0;
        for end in seams.chain([reach]) {
            self.extend(from, end, 0);
            from = end;
        }
    }

    /// Compiles a law without seams, beginning with a known form of half the reach, or a quarter, and so on,
    /// or with part of a longer form. Returns the slip speed up to which the law was compiled at once.
    fn compile_doubled(&mut self, reach: f64, known: &[Arc<Weakening>]) -> f64 {
        let mut ends = vec![];
        let mut end = reach;
        let base = loop {
            let begins_with = |known: &&Arc<Weakening>| {
                known.reach() == end
                    || known.base < end && known.breaks.binary_search_by(|b| b.total_cmp(&end)).is_ok()
            };
            if let Some(known) = known.iter().find(begins_with) {
                let pieces = known.pieces.len().min(known.piece_of(end.next_down()) + 1);
                self.pieces.extend_from_slice(&known.pieces[..pieces]);
                self.breaks = known.breaks[..=pieces].to_vec();
                self.size = self.pieces.last().map_or(0.0, |piece| piece.size);
                break known.base;
            }
            if 0.5 * end < LEAST_SHARED {
                self.extend(0.0, end, 0);
                break end;
            }
            let mut size = 0.0;
            if let Some(piece) = piece(self.law, 0.0, end, &mut size, false) {
                self.pieces.push(piece);
                self.breaks.push(end);
                self.size = size;
                break end;
            }
            ends.push(end);
            end *= 0.5;
        };
        for end in ends.into_iter().rev() {
            self.extend(0.5 * end, end, 1);
        }
        base
    }

    /// Appends the pieces of [from, to], a range after `halvings` bisections in which the law is smooth.
    fn extend(&mut self, from: f64, to: f64, halvings: u32) {
        // A stack: the last range is the next one.
        let mut waiting = vec![(from, to, halvings)];
        while let Some((a, b, halvings)) = waiting.pop() {
            let middle = 0.5 * (a + b);
            let last = halvings >= MOST_HALVINGS
                || !(a < middle && middle < b)
                || self.pieces.len() + waiting.len() >= self.most;
            match piece(self.law, a, b, &mut self.size, last) {
                Some(piece) => {
                    self.pieces.push(piece);
                    self.breaks.push(b);
                }
                None => waiting.extend([(middle, b, halvings + 1), (a, middle, halvings + 1)]),
            }
        }
    }
}

/// The piece [a, b] of a law that is smooth there; `None` if it must be halved for accuracy. A piece that is
/// the `last` of its bisections is always returned.
fn piece(law: &Form, a: f64, b: f64, size: &mut f64, last: bool) -> Option<Piece> {
    let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
    let points = POINTS.map(|x| (middle + half * x).clamp(a, b));
    let values = law.weakenings(points);
    let largest =
        values.iter().map(|value| value.abs()).fold(0.0, |a, b| if b > a || b.is_nan() { b } else { a });
    let (c, tail) = fit(&values);
    let scale = 1.0 / half;
    let mut piece = Piece::new(middle, scale, c, *size);
    if !(largest.is_finite() && scale.is_finite()) {
        return last.then_some(piece);
    }
    let size_here = size.max(largest);
    let aim = SHARPNESS * size_here + UNDERFLOW * scale;
    // Where phi is nearly constant before it falls, w is small, and its values are rounded by more than
    // `aim`.
    let is_rounding = |rest: f64| {
        rest * half <= ROUNDED && rest <= rounding(law, [points[0], points[COUNT / 2], points[COUNT - 1]])
    };
    // The last coefficients fall by an order of magnitude each where the piece is short enough.
    let resolved = tail <= 16.0 * aim || is_rounding(tail / 16.0);
    if !resolved && !last {
        return None;
    }
    let round_off = Piece::round_off(&piece.c);
    // The series is in units of the half-width, so that no power of it leaves the normal numbers.
    if let Some(phi) = law.series(Interval::new(a, b), half.next_up()) {
        // w = -phi', so its coefficients follow from those of phi.
        let highest = Interval::of(COUNT as f64 + 1.0) * phi.0[COUNT + 1] / Interval::of(half);
        // Of a law that jumps or has a kink there, higher derivatives may have bounds beside it.
        let is_smooth = phi.0.iter().all(|derivative| derivative.is_bounded());
        let highest = if is_smooth { highest.lo.abs().max(highest.hi.abs()) } else { f64::INFINITY };
        let remainder = ROOM * 2.0 * 0.5f64.powi(COUNT as i32) * highest;
        let reached = remainder <= aim || is_rounding(remainder);
        if !reached && !last {
            return None;
        }
        let residual = points.iter().map(|&u| {
            let exact = law.series::<2>(Interval::of(u), 1.0).map_or(Interval::ENTIRE, |phi| -phi.0[1]);
            let found = piece.at(u);
            (exact.hi - found).abs().max((found - exact.lo).abs())
        });
        // Keeps a NaN, which results from an enclosure without bounds.
        let residual = residual.fold(0.0, |a: f64, b| if b > a || b.is_nan() { b } else { a });
        let error = ROOM * (remainder + LEBESGUE * (residual + round_off)) + round_off;
        if error.is_finite() {
            piece.error = error;
            piece.describe(law, a, b, &phi);
        } else if let Some(bounds) = law.series::<2>(Interval::new(a, b), 1.0).map(|phi| -phi.0[1])
            && bounds.is_bounded()
        {
            // Higher derivatives may have no bounds, as those of a power next to rest, where w has bounds.
            piece.error = ROOM * (bounds.size() + piece.c.iter().map(|c| c.abs()).sum::<f64>());
            piece.range = bounds.into();
        }
    }
    // The error of an interpolant is largest between the points.
    let between: [f64; COUNT - 1] = std::array::from_fn(|i| 0.5 * (points[i] + points[i + 1]));
    let off = between.iter().zip(law.weakenings(between)).map(|(&u, w)| (piece.at(u) - w).abs());
    piece.estimate = 2.0 * off.fold(0.0, f64::max) + round_off;
    (*size, piece.size) = (size_here, size_here);
    Some(piece)
}

/// The largest width of the enclosures of w at the slip speeds `at`, the limit of its accuracy; 0 if none.
fn rounding(law: &Form, at: [f64; 3]) -> f64 {
    let width = |u: f64| law.series::<2>(Interval::of(u), 1.0).map_or(0.0, |phi| phi.0[1].hi - phi.0[1].lo);
    at.map(width).into_iter().filter(|width| width.is_finite()).fold(0.0, f64::max)
}

impl Piece {
    /// A polynomial of which nothing is proved.
    fn new(middle: f64, scale: f64, c: [f64; COUNT], size: f64) -> Self {
        Self {
            middle,
            scale,
            c,
            error: f64::INFINITY,
            estimate: f64::INFINITY,
            range: Range { lo: f64::NEG_INFINITY, hi: f64::INFINITY },
            slope: Sign::Unknown,
            bend: Sign::Unknown,
            size,
        }
    }

    /// Sets the bounds of w and the signs of its derivatives on [a, b], from the series `phi` there.
    fn describe(&mut self, law: &Form, a: f64, b: f64, phi: &Jet<Interval, { COUNT + 2 }>) {
        let (slope, bend) = (-phi.derivative(2), -phi.derivative(3));
        self.bend = Sign::of(bend);
        self.slope = Sign::of(slope);
        if self.slope == Sign::Unknown && self.bend != Sign::Unknown {
            // The slope is monotone, so it lies between its values at the ends.
            let [at_a, at_b] = [a, b].map(|u| law.series::<3>(Interval::of(u), 1.0));
            if let Some((at_a, at_b)) = at_a.zip(at_b) {
                self.slope = Sign::of((-at_a.derivative(2)).hull(-at_b.derivative(2)));
            }
        }
        self.range = self.range_on(a, b);
    }
}

/// The parabolas of a table: exact except for the rounding of their coefficients. They are cut at their
/// extremes, so that each piece is monotone.
fn compile_table(table: &Table, breaks: &mut Vec<f64>, pieces: &mut Vec<Piece>) {
    for parabola in table.parabolas() {
        let [from, to] = parabola.ends;
        let turn = parabola.extreme().filter(|u| from < *u && *u < to);
        for [a, b] in turn.map_or(vec![[from, to]], |turn| vec![[from, turn], [turn, to]]) {
            let (middle, half) = (0.5 * (a + b), 0.5 * (b - a));
            let scale = 1.0 / half;
            // w in x, with t = u - from = start + x / scale.
            let start = Interval::of(middle) - Interval::of(from);
            let width = Interval::of(1.0) / Interval::of(scale);
            let [w0, w1, w2] = parabola.coefficients;
            let exact = [
                w0 + start * (w1 + start * w2),
                width * (w1 + Interval::of(2.0) * start * w2),
                width * width * w2,
            ];
            let mut c = [0.0; COUNT];
            let mut error = 0.0;
            for (c, exact) in c.iter_mut().zip(exact) {
                *c = 0.5 * (exact.lo + exact.hi);
                error += (exact.hi - *c).max(*c - exact.lo);
            }
            let round_off = Piece::round_off(&c);
            let mut piece = Piece {
                // The cut at an extreme is rounded; the value there exceeds the extreme by less than this.
                error: ROOM * (error + 2.0 * round_off),
                estimate: error + round_off,
                // There is no extreme inside, so the slope in the middle has the sign of the whole piece.
                slope: Sign::of(exact[1]),
                bend: Sign::of(w2),
                ..Piece::new(middle, scale, c, 0.0)
            };
            piece.range = piece.range_on(a, b);
            let before = pieces.last().map_or(0.0, |piece| piece.size);
            piece.size = before.max(piece.range.lo.abs()).max(piece.range.hi.abs());
            pieces.push(piece);
            breaks.push(b);
        }
    }
}

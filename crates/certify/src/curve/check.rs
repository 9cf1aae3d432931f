//! The checker: from the law and the numbers of a curve alone it proves what the curve claims, or says what
//! fails.
//!
//! The sign of S is proved cell by cell. The Taylor series of S about the middle of a cell, with the last
//! coefficient over the whole cell, bounds S; a cell without a sign is halved. Of each polynomial of the law
//! whose slip speeds the cell may pass, S has the sign on the whole cell: so at each of its points, at
//! corners and jumps of the law with both limits. A cell that lies on one side of a break of the law and
//! touches it counts with the limit from its own side: the orbit there meets the curve with the flow of that
//! side only, or both are vertical, and S does not depend on w.

use super::{Along, CurveKind, MOST_DEGREE, OneWay};
use slipmap_model::friction::{COUNT, Column, ProvedPiece, Range, Weakening};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};
use std::sync::Arc;

/// Number of Taylor coefficients: more than a piece has, so that its derivative is exact in them.
const ORDER: usize = 12;
/// Largest number of halvings of a piece, and of cells of a curve.
pub(super) const MOST_HALVINGS: u32 = 14;
const MOST_CELLS: usize = 50_000;
/// Largest number of the law's polynomials that one cell may meet.
const MOST_TOGETHER: usize = 6;
/// Bound of what the roundings of the law's own coefficients change, in units of its largest weakening rate:
/// some ten roundings of a closed form, whose slope with respect to the logarithm of any coefficient is at
/// most a few times that rate.
const COEFFICIENTS: f64 = 64.0 * f64::EPSILON;
/// Roundings of the drop, which is computed from friction of size 1.
const DROP: f64 = 4.0 * f64::EPSILON;

type Points = Vec<Interval>;

/// One coordinate of a part of a piece: its value at the start, and the differences of its control points.
/// Rounding errors are relative to the differences, so that short parts have slopes as accurate as long ones.
pub(super) struct Part {
    pub(super) from: Interval,
    rises: Points,
}

impl Part {
    pub(super) fn of(points: &[[f64; 2]], axis: usize) -> Self {
        let at = |point: &[f64; 2]| Interval::of(point[axis]);
        Self {
            from: at(&points[0]),
            rises: points.windows(2).map(|ends| at(&ends[1]) - at(&ends[0])).collect(),
        }
    }

    /// Values that contain those of the part.
    pub(super) fn hull(&self) -> Interval {
        let mut at = self.from;
        self.rises.iter().fold(at, |hull, rise| {
            at = at + *rise;
            hull.hull(at)
        })
    }

    pub(super) fn halves(&self) -> [Self; 2] {
        let half = Interval::of(0.5);
        let [left, right] =
            halves(&self.rises).map(|rises| rises.into_iter().map(|rise| rise * half).collect());
        let left = Self { from: self.from, rises: left };
        let middle = left.rises.iter().fold(left.from, |sum, rise| sum + *rise);
        [left, Self { from: middle, rises: right }]
    }

    /// The coefficients of the powers of t, which runs from 0 to 1: integrals of those of the slope, which
    /// are binomials times differences.
    pub(super) fn coefficients(&self) -> Points {
        let degree = self.rises.len();
        let (mut row, mut binomial, mut found) = (self.rises.clone(), degree as f64, vec![self.from]);
        for k in 0..degree {
            found.push(Interval::of(binomial) * row[0] / Interval::of((k + 1) as f64));
            row = row.windows(2).map(|ends| ends[1] - ends[0]).collect();
            binomial = binomial * (degree - 1 - k) as f64 / (k + 1) as f64;
        }
        found
    }
}

/// What a curve does not prove.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Fault {
    /// Number of control points, an infinite number.
    #[error("piece {piece} is no polynomial of degree 1 to 9")]
    Malformed {
        /// Number of the piece, from 1.
        piece: usize,
    },
    /// A piece does not begin where the one before ends.
    #[error("piece {piece} does not begin where the one before ends")]
    Gap {
        /// Number of the piece, from 1.
        piece: usize,
    },
    /// Above the belt line, or beyond the law.
    #[error("piece {piece} leaves the slip speeds at which the law is known")]
    Domain {
        /// Number of the piece, from 1.
        piece: usize,
    },
    /// Neither left of the equilibrium, nor below it with u rising, nor above it.
    #[error("piece {piece} does not lead once around the equilibrium")]
    Around {
        /// Number of the piece, from 1.
        piece: usize,
    },
    /// Its first or last point is not one of its kind.
    #[error("it does not begin or end where its kind asks")]
    Ends,
    /// The sign of S.
    #[error("orbits are not proved to cross piece {piece} its way")]
    Sign {
        /// Number of the piece, from 1.
        piece: usize,
    },
    /// No proved polynomials.
    #[error("the law has no proved bounds at slip speed {at:.3e}")]
    NoEnclosure {
        /// The slip speed.
        at: f64,
    },
    /// The number of cells.
    #[error("the curve takes too many cells")]
    TooMuchWork,
}

/// The flow of one column at one damping.
#[derive(Clone, Debug)]
pub(super) struct Field {
    pub(super) law: Arc<Weakening>,
    pub(super) belt_speed: f64,
    epsilon: f64,
    /// c.
    pub(super) damping: f64,
    /// C = eps c, rounded, and enclosed.
    pub(super) viscous: f64,
    exact_viscous: Interval,
    pub(super) drop: Interval,
    /// Added to the errors of the law's polynomials.
    rounding: f64,
}

/// What the roundings of a table's friction, in units of that at rest, change in its secants and slopes.
fn of_differences(column: &Column) -> f64 {
    let Some(table) = column.curve.table() else { return 0.0 };
    let data: Vec<(f64, f64)> = table.data().collect();
    let most = data.iter().map(|(_, friction)| friction.abs() / table.static_level()).fold(0.0, f64::max);
    let narrowest = data.windows(2).map(|ends| ends[1].0 - ends[0].0).fold(f64::INFINITY, f64::min);
    // Half a unit each; slopes are at most three times a secant, and the parabola between them three times as
    // steep.
    16.0 * f64::EPSILON * most / narrowest
}

/// The cells that a check may yet take.
pub(super) struct Budget(pub(super) usize);

impl Budget {
    pub(super) fn of_a_curve() -> Self {
        Self(MOST_CELLS)
    }
}

impl Field {
    pub(super) fn new(column: &Column) -> Self {
        let law = column.curve.compiled(super::reach(column));
        let sizes =
            law.proved_pieces(0.0, law.reach()).map(|piece| piece.c.iter().map(|c| c.abs()).sum::<f64>());
        let rounding = (COEFFICIENTS * sizes.fold(0.0, f64::max) + of_differences(column)).next_up();
        let drop = column.curve.drop();
        let drop = if drop > 0.0 { Interval::ball(drop, DROP).at_least_zero() } else { Interval::ZERO };
        let (belt_speed, epsilon) = (column.belt_speed, column.epsilon);
        let [damping, viscous] = [0.0; 2];
        Self { law, belt_speed, epsilon, damping, viscous, exact_viscous: Interval::ZERO, drop, rounding }
    }

    /// The same at another damping c.
    pub(super) fn at(&self, damping: f64) -> Self {
        let (viscous, exact_viscous) =
            (self.epsilon * damping, Interval::of(self.epsilon) * Interval::of(damping));
        Self { damping, viscous, exact_viscous, ..self.clone() }
    }

    /// What the lemma asks of a curve's place.
    fn setting(&self) -> Setting {
        Setting {
            known: self.law.reach(),
            belt_speed: Interval::of(self.belt_speed),
            drop: self.drop,
            drops: Vec::new(),
        }
    }

    /// Where a piece lies; `None` if it proves nothing there.
    pub(super) fn place(&self, piece: &[[f64; 2]]) -> Option<Place> {
        let points: Vec<_> = piece.iter().map(|point| point.map(Interval::of)).collect();
        place(&points, piece.windows(2).all(|ends| ends[0][0] < ends[1][0]), Interval::of(self.belt_speed))
    }

    /// Proves that S has the `sign` on a whole piece.
    pub(super) fn crosses(&self, piece: &[[f64; 2]], sign: f64, budget: &mut Budget) -> Result<(), Cell> {
        let [u, y] = [0, 1].map(|axis| Part::of(piece, axis));
        let speeds = piece.iter().map(|point| Interval::of(point[0]));
        let Some(speeds) = speeds.reduce(Interval::hull) else { return Err(Cell::Sign) };
        let task = Task { speeds, sign };
        self.cell([u, y], &task, MOST_HALVINGS, budget)
    }

    fn cell(&self, [u, y]: [Part; 2], task: &Task, halvings: u32, budget: &mut Budget) -> Result<(), Cell> {
        budget.0 = budget.0.checked_sub(1).ok_or(Cell::TooMuchWork)?;
        let (sign, hull) = (task.sign, u.hull().intersection(task.speeds));
        let [[u_left, u_right], [y_left, y_right]] = [u.halves(), y.halves()];
        let [u_middle, y_middle] = [u_right.coefficients(), y_right.coefficients()];
        let mut is_proved = true;
        let meets = self.law.proved_pieces(hull.lo, hull.hi);
        let meets = meets.filter(|piece| piece.ends[0] < hull.hi || hull.lo == hull.hi);
        for (number, piece) in meets.enumerate() {
            if !piece.error.is_finite() {
                return Err(Cell::NoEnclosure(piece.ends[0].max(0.0)));
            }
            if number == MOST_TOGETHER {
                // Next to rest a law may have a thousand pieces: its range is enough where that hardly
                // changes.
                is_proved = self.lowest_by_range(hull, [&u_middle, &y_middle], sign) > 0.0;
                break;
            }
            let lowest = self.lowest(&piece, [&u_middle, &y_middle], sign);
            is_proved &= lowest > 0.0;
        }
        if is_proved {
            return Ok(());
        }
        if halvings == 0 || self.is_wrong(u_right.from, &u_middle, &y_middle, sign) {
            return Err(Cell::Sign);
        }
        self.cell([u_left, y_left], task, halvings - 1, budget)?;
        self.cell([u_right, y_right], task, halvings - 1, budget)
    }

    /// Whether S has the wrong sign in the middle of a cell, so that halving is of no use.
    fn is_wrong(&self, u: Interval, u_middle: &Points, y_middle: &Points, sign: f64) -> bool {
        let mut pieces = self.law.proved_pieces(u.lo.max(0.0), u.hi.max(0.0));
        pieces.all(|piece| {
            let [u, y] = [u_middle, y_middle].map(|c| around::<_, 2>(Interval::ZERO, c));
            let s = Interval::of(sign) * self.crossing(&piece, u, y).0[0];
            s.hi <= 0.0
        })
    }

    /// A lower bound of S times the sign over a cell, where w is the polynomial of a piece of the law, up to
    /// its error.
    fn lowest(&self, piece: &ProvedPiece, [u, y]: [&Points; 2], sign: f64) -> f64 {
        let whole = Interval::new(-1.0, 1.0);
        let [along, wide] = [Interval::ZERO, whole].map(|at| {
            let [u, y] = [u, y].map(|c| around::<_, ORDER>(at, c));
            (self.crossing(piece, u, y), u, y)
        });
        let (wide_s, wide_u, wide_y) = wide;
        let mut s = wide_s.0[ORDER - 1];
        for k in (0..ORDER - 1).rev() {
            s = along.0.0[k] + whole * s;
        }
        let error = Interval::of(piece.error) + Interval::of(self.rounding);
        let off = error * Interval::of(wide_u.0[1].size()) * Interval::of(wide_y.0[0].size());
        let lowest = (Interval::of(sign) * s - off).lo;
        if lowest.is_nan() { f64::NEG_INFINITY } else { lowest }
    }

    /// The same where w lies in its range over the slip speeds of the cell.
    fn lowest_by_range(&self, speeds: Interval, cell: [&Points; 2], sign: f64) -> f64 {
        let Range { lo, hi } = self.law.range(speeds.lo, speeds.hi);
        let (middle, half) = (0.5 * (lo + hi), (0.5 * (hi - lo)).next_up());
        let mut c = [0.0; COUNT];
        c[0] = middle;
        // The middle is rounded by less than this.
        let error = half + f64::EPSILON * middle.abs();
        let piece = ProvedPiece { ends: [speeds.lo, speeds.hi], middle: 0.0, scale: 1.0, c: &c, error };
        self.lowest(&piece, cell, sign)
    }

    /// The series of S.
    fn crossing<const N: usize>(
        &self,
        piece: &ProvedPiece,
        u: Jet<Interval, N>,
        y: Jet<Interval, N>,
    ) -> Jet<Interval, N> {
        let c = Jet::<Interval, N>::constant;
        let w = ((u - c(piece.middle)) * c(piece.scale)).polynomial(piece.c);
        let force = u - c(self.belt_speed) + (w - Jet::of(self.exact_viscous)) * y;
        -(slopes(&u) * force) - slopes(&y) * y
    }
}

impl Cell {
    pub(super) fn fault(self, piece: usize) -> Fault {
        match self {
            Cell::Sign => Fault::Sign { piece },
            Cell::NoEnclosure(at) => Fault::NoEnclosure { at },
            Cell::TooMuchWork => Fault::TooMuchWork,
        }
    }
}

/// What is asked of a piece: the sign of S. Its control points bound the slip speeds.
struct Task {
    speeds: Interval,
    sign: f64,
}

/// Where a piece lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Place {
    /// v < 0.
    Left,
    /// y < 0 but for ends, and u rises.
    Below,
    /// y > 0 but for ends.
    Above,
}

/// Why a piece is refused.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Cell {
    Sign,
    NoEnclosure(f64),
    TooMuchWork,
}

/// Where a piece lies, by its control points, which bound it, and whether u rises along them; `None` if it proves
/// nothing there.
pub(super) fn place(points: &[[Interval; 2]], rises: bool, belt_speed: Interval) -> Option<Place> {
    let (first, last) = (points.first()?[1], points.last()?[1]);
    let has_sign = |flip: fn(Interval) -> f64| {
        let inner = &points[1..points.len() - 1];
        let [first, last] = [first, last].map(flip);
        inner.iter().all(|point| flip(point[1]) > 0.0) && first.min(last) >= 0.0 && first.max(last) > 0.0
    };
    if points.iter().all(|point| point[0].lo > belt_speed.hi) {
        Some(Place::Left)
    } else if has_sign(|y| y.lo) {
        Some(Place::Above)
    } else {
        (has_sign(|y| -y.hi) && rises).then_some(Place::Below)
    }
}

/// The series of the derivative of a polynomial of a degree below N - 1.
pub(super) fn slopes<T: Real, const N: usize>(series: &Jet<T, N>) -> Jet<T, N> {
    let mut slopes = Jet::of(T::constant(0.0));
    for k in 1..N {
        slopes.0[k - 1] = T::constant(k as f64) * series.0[k];
    }
    slopes
}

/// The series of a polynomial at all places in `at`, from its coefficients.
pub(super) fn around<T: Real, const N: usize>(at: T, coefficients: &[T]) -> Jet<T, N> {
    let mut series = [T::constant(0.0); N];
    for coefficient in coefficients.iter().rev() {
        for k in (1..N).rev() {
            series[k] = series[k] * at + series[k - 1];
        }
        series[0] = series[0] * at + *coefficient;
    }
    Jet(series)
}

/// The control points of the halves of a polynomial (de Casteljau).
fn halves(points: &Points) -> [Points; 2] {
    let half = Interval::of(0.5);
    let (mut row, mut left, mut right) = (points.clone(), Vec::new(), Vec::new());
    while let [first, .., last] | [first @ last] = row.as_slice() {
        left.push(*first);
        right.push(*last);
        row = row.windows(2).map(|ends| (ends[0] + ends[1]) * half).collect();
    }
    right.reverse();
    [left, right]
}

/// What the lemma asks of a curve's place, over all of a box.
pub(super) struct Setting {
    /// The slip speed up to which the law is known.
    pub(super) known: f64,
    pub(super) belt_speed: Interval,
    /// The drop in the middle of the box, and its derivatives along the axes.
    pub(super) drop: Interval,
    pub(super) drops: Vec<Interval>,
}

/// A piece over all of a box: its control points, and whether u rises along them.
struct Outline {
    points: Vec<[Interval; 2]>,
    rises: bool,
}

impl OneWay {
    /// Proves the claim of the curve about the orbit of a column at its damping; returns the number of cells.
    ///
    /// # Errors
    /// [`Fault`]: what is not proved.
    pub fn check(&self, column: &Column) -> Result<usize, Fault> {
        let field = Field::new(column).at(self.c);
        self.lies_well(&field.setting())?;
        let mut budget = Budget::of_a_curve();
        for (piece, points) in (1..).zip(self.pieces.iter()) {
            let crosses = field.crosses(points, self.kind.sign(), &mut budget);
            crosses.map_err(|cell| cell.fault(piece))?;
        }
        Ok(MOST_CELLS - budget.0)
    }

    /// As [`OneWay::lies_well`], of a curve of one column.
    pub(super) fn lies_well_in(&self, field: &Field) -> Result<(), Fault> {
        self.lies_well(&field.setting())
    }

    /// The pieces over all of a box on which it has `axes` axes.
    fn outlines(&self, axes: usize) -> Result<Vec<Outline>, Fault> {
        let malformed = |piece| Fault::Malformed { piece };
        let is_list = |of: &Along| of.pieces.len() == self.pieces.len() && of.c.is_finite();
        if !(self.c.is_finite() && self.along.len() == axes && self.along.iter().all(is_list)) {
            return Err(malformed(1));
        }
        let outline = |(i, points): (usize, &super::Piece)| {
            let along: Vec<_> = self.along.iter().map(|along| &along.pieces[i]).collect();
            let is_polynomial = (2..=MOST_DEGREE + 1).contains(&points.len())
                && along.iter().all(|along| along.len() == points.len())
                && along
                    .iter()
                    .copied()
                    .chain([points])
                    .flat_map(|it| it.iter().flatten())
                    .all(|x| x.is_finite());
            if !is_polynomial {
                return Err(malformed(i + 1));
            }
            let at = |k: usize, axis: usize| spread(points[k][axis], along.iter().map(|it| it[k][axis]));
            let rise = |k: usize| {
                let rise = |it: &super::Piece| Interval::of(it[k + 1][0]) - Interval::of(it[k][0]);
                let sizes = along.iter().map(|it| rise(it).size());
                rise(points).lo > sizes.fold(Interval::ZERO, |sum, size| sum + Interval::of(size)).hi
            };
            Ok(Outline {
                points: (0..points.len()).map(|k| [at(k, 0), at(k, 1)]).collect(),
                rises: (0..points.len() - 1).all(rise),
            })
        };
        self.pieces.iter().enumerate().map(outline).collect()
    }

    /// All that the lemma asks of the curve but the sign of S.
    pub(super) fn lies_well(&self, setting: &Setting) -> Result<(), Fault> {
        let Setting { known, belt_speed, drops, .. } = setting;
        let outlines = self.outlines(drops.len())?;
        let mut places = Vec::new();
        for (piece, outline) in (1..).zip(&outlines) {
            if outline.points.iter().any(|[u, _]| !(u.lo >= 0.0 && u.hi <= *known)) {
                return Err(Fault::Domain { piece });
            }
            places.push(place(&outline.points, outline.rises, *belt_speed).ok_or(Fault::Around { piece })?);
        }
        let lists = self.along.iter().map(|along| &along.pieces).chain([&self.pieces]);
        for pieces in lists {
            for (piece, ends) in (2..).zip(pieces.windows(2)) {
                if ends[0].last() != ends[1].first() {
                    return Err(Fault::Gap { piece });
                }
            }
        }
        for (piece, outline) in (2..).zip(outlines.iter().skip(1)) {
            // The curve meets y = 0 between pieces left of the equilibrium only.
            let [u, y] = outline.points[0];
            if y.contains_zero() && u.lo <= belt_speed.hi {
                return Err(Fault::Around { piece });
            }
        }
        let ends = outlines.first().zip(outlines.last()).filter(|(first, last)| {
            let is_around = [places.first(), places.last()] == [Some(&Place::Below), Some(&Place::Above)];
            is_around && self.ends_well(setting, first.points[0], last.points[last.points.len() - 1])
        });
        ends.map(|_| ()).ok_or(Fault::Ends)
    }

    fn ends_well(&self, setting: &Setting, [u0, y0]: [Interval; 2], [u1, y1]: [Interval; 2]) -> bool {
        let line = |u: Interval| u == Interval::ZERO;
        // How much the start falls below the drop differs along the axes.
        let along = self.along.iter().zip(&setting.drops);
        let off = along.map(|(along, drop)| (Interval::of(along.pieces[0][0][1]) + *drop).size());
        let off = off
            .fold(0.0, |sum, off| if off == 0.0 { sum } else { (Interval::of(sum) + Interval::of(off)).hi });
        let drop = if off == 0.0 { setting.drop } else { Interval::ball(0.0, off) + setting.drop };
        let start = -self.pieces[0][0][1];
        let starts = match self.kind {
            CurveKind::Returns => y0.hi <= 0.0 && start <= drop.lo,
            // Of a drop of 0 the start lies below E; above 0 it may be at E, and the bound of the drop is
            // above it.
            _ => y0.hi < 0.0 && start >= drop.hi,
        };
        let drops = setting.drops.iter().fold(setting.drop, |sum, drop| match drop.size() {
            0.0 => sum,
            size => sum + Interval::new(-size, size),
        });
        let ends = match self.kind {
            CurveKind::Returns => line(u1) && y1.lo > 0.0,
            CurveKind::Absent => u1.lo > 0.0 && u1.hi < setting.belt_speed.lo && y1 == Interval::ZERO,
            CurveKind::Lands => line(u1) && y1.lo > 0.0 && y1.hi < (Interval::of(2.0) - drops).lo,
        };
        line(u0) && starts && ends
    }
}

/// All values of a number that changes by these along the axes.
fn spread(middle: f64, along: impl Iterator<Item = f64>) -> Interval {
    along.filter(|x| *x != 0.0).fold(Interval::of(middle), |sum, x| sum + Interval::new(-x.abs(), x.abs()))
}

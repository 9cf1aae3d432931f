//! The checker over a box of eps, the law's parameters and the belt speed: one curve for all of them.
//!
//! Let z_i run from -1 to 1 along the axes on which the box is wide. Damping and control points, these times V / V(0), are linear
//! in z. By Taylor's theorem
//!
//! ```text
//! S(z)  in  S(0) + sum of z_i dS/dz_i(0) + sum of z_i z_j (d2S/dz_i dz_j)(box) / 2,
//! ```
//!
//! term by term in the Taylor form of a cell, in which S(0) and the derivatives are series along the curve; mixed derivatives are
//! those along z_i + z_j less those along z_i and z_j. With `S = u_s (V - u + C y) + y d(phi(u))/ds - y_s y` no derivative of
//! friction is needed but that along the curve: friction is the formula of the law, not its compiled form. Laws by data are not
//! proved over boxes.

use super::check::{Budget, Cell, Fault, MOST_HALVINGS, Part, Setting, around, slopes};
use super::{OneWay, Stop};
use slipmap_model::friction::{Law, Series, Slope, TERMS};
use slipmap_model::point::{LawParameters, Point};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real as _};

/// All of [-1, 1].
const WHOLE: Interval = Interval::new(-1.0, 1.0);
/// Largest number of cells of a curve.
const MOST_CELLS: usize = 4000;
/// Factor of the terms beyond S(0) that leaves room for another checker.
const ROOM: f64 = 1.25;
/// Number of halvings of a piece into the cells of [`Region::lack`].
const LACK_HALVINGS: u32 = 2;

/// A law over a box.
#[derive(Clone, Debug)]
pub(crate) struct Region<'a> {
    law: &'a Law,
    /// Ranges of eps, the law's parameters, V.
    ranges: &'a [[f64; 2]],
    /// The axes on which it is wide.
    pub(crate) axes: Vec<usize>,
    /// Factor of the terms beyond S(0).
    room: f64,
}

/// Where parameters are, and the axes along which they change together.
#[derive(Clone, Copy, Debug)]
struct Place {
    /// All over the box, or in its middle.
    is_all: bool,
    along: [Option<usize>; 2],
}

impl Place {
    const MIDDLE: Self = Self { is_all: false, along: [None; 2] };

    /// A number that is linear in z, along the direction.
    fn linear(&self, middle: Interval, along: &[Interval]) -> Slope {
        let is_all = self.is_all;
        let value = if is_all { along.iter().fold(middle, |sum, x| sum + WHOLE * *x) } else { middle };
        let slope = self.along.iter().flatten().fold(Interval::ZERO, |sum, &axis| sum + along[axis]);
        Jet([value, slope, Interval::ZERO])
    }
}

/// One coordinate of a part of a piece: in the middle of the box, and its derivatives along the axes.
struct Coordinate {
    middle: Part,
    along: Vec<Part>,
}

impl Coordinate {
    fn halves(&self) -> [Self; 2] {
        let [left, right] = self.middle.halves();
        let (lefts, rights) = self.along.iter().map(Part::halves).map(|[left, right]| (left, right)).unzip();
        [Self { middle: left, along: lefts }, Self { middle: right, along: rights }]
    }

    fn hull(&self) -> Interval {
        self.along.iter().fold(self.middle.hull(), |sum, part| sum + WHOLE * part.hull())
    }

    /// The coefficients of its powers, in the middle and along the axes.
    fn coefficients(&self) -> Powers {
        (self.middle.coefficients(), self.along.iter().map(Part::coefficients).collect())
    }
}

/// Coefficients of the powers of a place, in the middle and along each axis.
type Powers = (Vec<Interval>, Vec<Vec<Interval>>);

/// A cell: the coefficients of u and y about its middle, and bounds of u.
struct Around {
    coefficients: [Powers; 2],
    speeds: Interval,
}

impl<'a> Region<'a> {
    /// A box of eps, the law's parameters and V.
    ///
    /// # Errors
    /// [`Stop`]: why nothing can be proved over it.
    pub(crate) fn new(law: &'a Law, ranges: &'a [[f64; 2]]) -> Result<Self, Stop> {
        let axes: Vec<_> = (0..ranges.len()).filter(|&axis| ranges[axis][0] < ranges[axis][1]).collect();
        if !(law.admits_box(ranges) && (axes.is_empty() || law.is_enclosed_over_boxes())) {
            return Err(Stop::NoFormula);
        }
        let region = Self { law, ranges, axes, room: 1.0 };
        let point = region.point(&[]);
        if let Law::Expression(formula) = law.as_written()
            && formula.check(point.epsilon, &point.law, 2.0 * point.belt_speed).is_err()
        {
            return Err(Stop::NoLaw);
        }
        if law.column(&point).curve.is_normal() { Ok(region) } else { Err(Stop::NoLaw) }
    }

    /// The point of the box at these z, and at 0 along further axes.
    pub(crate) fn point(&self, z: &[f64]) -> Point {
        let mut at: Vec<f64> = self.ranges.iter().map(|[lo, hi]| lo + 0.5 * (hi - lo)).collect();
        for (&axis, z) in self.axes.iter().zip(z) {
            let [lo, hi] = self.ranges[axis];
            at[axis] = (at[axis] + 0.5 * z * (hi - lo)).clamp(lo, hi);
        }
        let last = at.len() - 1;
        let law = LawParameters::new(&at[1..last]);
        Point { epsilon: at[0], law, belt_speed: at[last], damping: 0.0 }
    }

    /// A parameter.
    fn parameter(&self, axis: usize, place: Place) -> Slope {
        let [lo, hi] = self.ranges[axis].map(Interval::of);
        let half = Interval::of(0.5);
        let Some(number) = self.axes.iter().position(|wide| *wide == axis) else { return Slope::of(lo) };
        let mut slope = Slope::of((lo + hi) * half);
        if place.is_all {
            slope.0[0] = lo.hull(hi);
        }
        if place.along.contains(&Some(number)) {
            slope.0[1] = (hi - lo) * half;
        }
        slope
    }

    /// eps and the law's parameters, and V in units of that in the middle.
    fn parameters(&self, place: Place) -> (Vec<Slope>, Slope) {
        let last = self.ranges.len() - 1;
        let own = (0..last).map(|axis| self.parameter(axis, place)).collect();
        let [lo, hi] = self.ranges[last];
        let unit = self.parameter(last, place) / Slope::of(self.belt_speed());
        (own, if lo == hi { Slope::constant(1.0) } else { unit })
    }

    /// V in the middle.
    fn belt_speed(&self) -> Interval {
        self.parameter(self.ranges.len() - 1, Place::MIDDLE).0[0]
    }

    fn setting(&self) -> Option<Setting> {
        let drop = |place| {
            let (x, unit) = self.parameters(place);
            Some(self.law.drop_over(&x)? / unit)
        };
        let along = |axis| Place { is_all: true, along: [Some(axis), None] };
        let drops = (0..self.axes.len()).map(|axis| Some(drop(along(axis))?.0[1]));
        let setting = Setting {
            known: f64::INFINITY,
            belt_speed: self.belt_speed(),
            drop: drop(Place::MIDDLE)?.0[0],
            drops: drops.collect::<Option<_>>()?,
        };
        (setting.drop.lo >= 0.0).then_some(setting)
    }

    /// As [`Region::check`], with room for another checker, whose bounds may be wider.
    ///
    /// # Errors
    /// [`Fault`]: what is not proved.
    pub(crate) fn check_with_room(&self, curve: &OneWay) -> Result<(), Fault> {
        Self { room: ROOM, ..self.clone() }.check(curve)
    }

    /// Proves what a curve claims of all points of the box.
    ///
    /// # Errors
    /// [`Fault`]: what is not proved.
    pub(crate) fn check(&self, curve: &OneWay) -> Result<(), Fault> {
        if self.axes.is_empty() {
            return curve.check(&self.law.column(&self.point(&[]))).map(|_| ());
        }
        curve.lies_well(&self.setting().ok_or(Fault::NoEnclosure { at: 0.0 })?)?;
        let mut budget = Budget(MOST_CELLS);
        for i in 0..curve.pieces.len() {
            let (task, [u, y]) = self.task(curve, i);
            task.cell([u, y], MOST_HALVINGS, &mut budget).map_err(|cell| cell.fault(i + 1))?;
        }
        Ok(())
    }

    fn task<'b>(&'b self, curve: &'b OneWay, piece: usize) -> (Task<'b>, [Coordinate; 2]) {
        let [u, y] = [0, 1].map(|axis| Coordinate {
            middle: Part::of(&curve.pieces[piece], axis),
            along: curve.along.iter().map(|along| Part::of(&along.pieces[piece], axis)).collect(),
        });
        (Task { region: self, curve, bounds: u.hull().at_least_zero() }, [u, y])
    }

    /// How far a curve is from being crossed one way over the box, estimated on cells; `None` where S is not known.
    pub(crate) fn lack(&self, curve: &OneWay) -> Option<Lack> {
        let mut lack = Lack::default();
        for i in 0..curve.pieces.len() {
            let (task, whole) = self.task(curve, i);
            let mut parts = vec![whole];
            for _ in 0..LACK_HALVINGS {
                let halves = parts.iter().flat_map(|[u, y]| {
                    let ([u, more_u], [y, more_y]) = (u.halves(), y.halves());
                    [[u, y], [more_u, more_y]]
                });
                parts = halves.collect();
            }
            for part in parts {
                let (cell, ..) = task.around(part);
                let (_, [middle, _]) = task.taylor(&cell, Place::MIDDLE, 0)?;
                let rest = task.rest(&cell)?;
                let ratio = rest.iter().map(|(_, rest)| rest.size()).sum::<f64>() / middle.size();
                if ratio > lack.ratio {
                    let of = |axis: usize| {
                        let own = rest.iter().filter(|(axes, _)| axes.contains(&axis));
                        own.map(|(_, rest)| rest.size()).sum::<f64>()
                    };
                    lack = Lack { ratio, axes: (0..self.axes.len()).map(of).collect() };
                }
            }
        }
        Some(lack)
    }
}

/// How far S is from its sign over a box.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lack {
    /// The largest ratio of what the terms beyond S(0) take away to S(0), in the middles of cells.
    pub(crate) ratio: f64,
    /// What each axis has of it.
    pub(crate) axes: Vec<f64>,
}

/// What is asked of a piece of a curve over a box.
struct Task<'a> {
    region: &'a Region<'a>,
    curve: &'a OneWay,
    /// Bounds of u.
    bounds: Interval,
}

impl Task<'_> {
    fn cell(&self, [u, y]: [Coordinate; 2], halvings: u32, budget: &mut Budget) -> Result<(), Cell> {
        budget.0 = budget.0.checked_sub(1).ok_or(Cell::TooMuchWork)?;
        let (cell, left, right) = self.around([u, y]);
        if self.has_sign(&cell)? {
            return Ok(());
        }
        if halvings == 0 {
            return Err(Cell::Sign);
        }
        self.cell(left, halvings - 1, budget)?;
        self.cell(right, halvings - 1, budget)
    }

    /// The series about the middle of a part, and its halves.
    fn around(&self, [u, y]: [Coordinate; 2]) -> (Around, [Coordinate; 2], [Coordinate; 2]) {
        let speeds = u.hull().intersection(self.bounds);
        let ([u_left, u_right], [y_left, y_right]) = (u.halves(), y.halves());
        let cell = Around { coefficients: [u_right.coefficients(), y_right.coefficients()], speeds };
        (cell, [u_left, y_left], [u_right, y_right])
    }

    /// Whether S is proved to have its sign on a whole cell over the whole box.
    fn has_sign(&self, cell: &Around) -> Result<bool, Cell> {
        let none = Cell::NoEnclosure(cell.speeds.lo);
        let sign = Interval::of(self.curve.kind.sign());
        let taylor = |place: Place, order: usize| self.taylor(cell, place, order).ok_or(none);
        let (mut bound, [middle, _]) = taylor(Place::MIDDLE, 0)?;
        // Halving is of no use where S has the wrong sign in the middle.
        if (sign * middle).hi <= 0.0 {
            return Err(Cell::Sign);
        }
        for axis in 0..self.region.axes.len() {
            // Where the law has few derivatives its values may do.
            let (_, [_, all]) = taylor(Place { is_all: true, along: [Some(axis), None] }, 2)?;
            if (sign * all).lo > 0.0 {
                return Ok(true);
            }
        }
        for (_, rest) in self.rest(cell).ok_or(none)? {
            bound = bound + Interval::of(self.region.room) * rest;
        }
        Ok((sign * bound).lo > 0.0)
    }

    /// What the terms beyond S(0) add over the box, each with its axes.
    fn rest(&self, cell: &Around) -> Option<Vec<([usize; 2], Interval)>> {
        let (mut found, mut squares) = (Vec::new(), Vec::new());
        let axes = self.region.axes.len();
        for axis in 0..axes {
            let along = [Some(axis), None];
            let (slope, _) = self.taylor(cell, Place { is_all: false, along }, 1)?;
            let (square, _) = self.taylor(cell, Place { is_all: true, along }, 2)?;
            found.push(([axis; 2], WHOLE * slope + Interval::new(0.0, 1.0) * square));
            squares.push(square);
        }
        for (one, two) in (0..axes).flat_map(|one| (0..one).map(move |two| (one, two))) {
            let (both, _) = self.taylor(cell, Place { is_all: true, along: [Some(one), Some(two)] }, 2)?;
            found.push(([one, two], WHOLE * (both - squares[one] - squares[two])));
        }
        Some(found)
    }

    /// The Taylor form of a coefficient along a direction; S at the middle of the cell and all over it.
    fn taylor(&self, cell: &Around, place: Place, order: usize) -> Option<(Interval, [Interval; 2])> {
        let [along, wide] = self.crossing(cell, place)?;
        Some((taylor(&along, &wide, order), [along.0[0].0[0], wide.0[0].0[0]]))
    }

    /// The series of S about the middle of a cell, and at all its places.
    fn crossing(&self, cell: &Around, place: Place) -> Option<[Series; 2]> {
        let (x, unit) = self.region.parameters(place);
        let unit = Series::of(unit);
        let along: Vec<_> = self.curve.along.iter().map(|along| Interval::of(along.c)).collect();
        let c = place.linear(Interval::of(self.curve.c), &along);
        let viscous = Series::of(c * x[0]);
        let belt_speed = Series::of(Slope::of(self.region.belt_speed()));
        let at = |at: Interval| {
            let [mut u, y]: [Series; 2] = [0, 1].map(|axis| {
                let (middle, along) = &cell.coefficients[axis];
                let of = |k: usize| {
                    let along: Vec<_> = along.iter().map(|along| along[k]).collect();
                    place.linear(middle[k], &along)
                };
                let coefficients: Vec<Slope> = (0..middle.len()).map(of).collect();
                around::<_, TERMS>(Slope::of(at), &coefficients)
            });
            u.0[0].0[0] = u.0[0].0[0].intersection(cell.speeds);
            let friction = slopes(&self.region.law.friction_along(unit * u, &x)?) / unit;
            Some(slopes(&u) * (belt_speed - u + viscous * y) + y * friction - slopes(&y) * y)
        };
        Some([at(Interval::ZERO)?, at(WHOLE)?])
    }
}

/// The Taylor form over a cell, of values or of a coefficient along a direction. The last coefficient of a derivative along the
/// curve is not known.
fn taylor(along: &Series, wide: &Series, of: usize) -> Interval {
    const LAST: usize = TERMS - 2;
    (0..LAST).rev().fold(wide.0[LAST].0[of], |sum, k| along.0[k].0[of] + WHOLE * sum)
}

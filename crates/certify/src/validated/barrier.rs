//! The critical damping of any law over a box of parameters, enclosed by barriers.
//!
//! # Statement
//! A [`Tile`] claims: for all eps, parameters of the law and V in its box, with coordinates z that run from
//! -1 to 1 along each axis, `|C* - (C0 + sum of slope_i z_i)| <= radius`, C* = eps c*.
//!
//! # Proof
//! **Barriers.** In units of the belt speed, v = r cos th, x2'/V = -r sin th and D = w(V (1 - v)) - C (see
//! [`super`]). Let rho be a positive function with rho(0) = rho(2 pi) = 1, piecewise smooth; the closed curve
//! r = rho(th) bounds a region around the equilibrium. Orbits cross it outward where G < 0, and inward where
//! G > 0,
//!
//! ```text
//! G = rho' (1 + D sin th cos th) - D rho sin^2 th.
//! ```
//!
//! If G < 0 on the whole curve the orbit from the exit point (1, 0) comes back to the belt line or runs away;
//! if G > 0 it does neither. [`crate::recheck`] proves that for Stribeck's law; of the law the proof
//! uses only that D is a Lipschitz function of v. Above the belt line the law may be continued in any such
//! way: w(u) = w(0) for u < 0. Neither does the angle have to be monotone in time, nor is an orbit followed.
//!
//! **The curves.** Let R be a curve and C0 a damping, both linear in z: the witness. With rho = R + t sigma
//! and C = C0
//! - t, sigma(0) = sigma(2 pi) = 0,
//!
//! ```text
//! H = -dG/dt = -sigma' (1 + D sin cos) + D' (rho sin^2 - rho' sin cos) + D sigma sin^2,
//! D' = dD/dt = 1 - w'(u) V sigma cos th.
//! ```
//!
//! Let |G| <= g at t = 0, and H >= h > 0 for |t| <= radius. Then G < 0 at t = radius > g / h, and G > 0 at t
//! = -radius: the claim follows, since the orbit comes back at all dampings below C* and at none above. []
//!
//! **The bounds.** On each cell of angles R and sigma are cubic polynomials with given values and slopes at
//! its ends. By the mean value theorem G differs from its value in the middle of the cell and of the box by
//! at most the sum of the sizes of its derivatives by the angle and by each z_i, which are enclosed over the
//! cell and the box. H is enclosed as it stands. g and 1/h are the largest over all cells.
//!
//! **The witness** needs no accuracy: R and C0 pass through closed orbits in the middle of the box and at the
//! ends of its axes, found in plain numbers; sigma solves H = const along the one in the middle. If all are
//! accurate, the radius is of second order in the extent of the box.

use std::f64::consts::TAU;

use slipmap_model::friction::{Curve, Law, Slope};
use slipmap_model::point::LawParameters;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::Real as _;

/// Numbers of cells of the angle, tried in this order.
const CELLS: [usize; 3] = [48, 96, 192];
/// Share of the defect in the middle of the box above which more cells are tried.
const OWN_SHARE: f64 = 0.5;
/// How often a cell is halved where its bounds are wide.
const MOST_HALVINGS: u32 = 5;
/// Share of the best bound that is good enough.
const WORTHWHILE: f64 = 0.7;
/// Largest number of steps of the secant method to a closed orbit.
const MOST_STEPS: usize = 40;
/// Least dth/dt on orbits of a witness.
const SLOWEST: f64 = 0.02;
/// First guess of the radius, in units of the defect: H is about 1/2 where D is small.
const FIRST_RADIUS: f64 = 4.0;
/// How often a larger radius is tried.
const TRIALS: usize = 3;
/// Factor on a radius that covers its own rounding, and differences of the platform's functions between
/// machines.
const ROUNDING: f64 = 1.0 + 1e-6;
/// The coordinate along an axis of a box, or within a cell.
const UNIT: Interval = Interval::new(-1.0, 1.0);

/// Ranges of eps, of the law's parameters and of V, in this order.
pub(crate) type Ranges = Vec<[f64; 2]>;

/// A proved enclosure of the critical damping over a box.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    pub(crate) ranges: Ranges,
    /// C0, about C* = eps c* in the middle.
    pub(crate) viscous: f64,
    /// Its change from the middle of each axis to its end.
    pub(crate) slopes: Vec<f64>,
    /// Bound on the error of C*.
    pub(crate) radius: f64,
    /// Largest change of the weakening rate along each axis.
    pub(crate) by_axis: Vec<f64>,
}

/// A box, and its coordinates: from its middle in units of half its width.
pub(super) struct Domain {
    pub(super) all: Vec<Interval>,
    pub(super) middle: Vec<f64>,
    /// Half of each axis's width, rounded up.
    pub(super) half: Vec<f64>,
    /// The axes along which the box has an extent.
    wide: Vec<usize>,
}

impl Domain {
    pub(super) fn new(ranges: &[[f64; 2]]) -> Self {
        let middle: Vec<f64> = ranges.iter().map(|[lo, hi]| lo + 0.5 * (hi - lo)).collect();
        let half = ranges.iter().zip(&middle);
        let half: Vec<f64> =
            half.map(|([lo, hi], middle)| (hi - middle).max(middle - lo).next_up()).collect();
        Self {
            all: ranges.iter().map(|[lo, hi]| Interval::new(*lo, *hi)).collect(),
            middle,
            half,
            wide: (0..ranges.len()).filter(|&axis| ranges[axis][0] < ranges[axis][1]).collect(),
        }
    }
}

/// sin and cos of an angle, which is `number` half cells of `cells`; exact at the ends.
fn sin_cos(number: usize, cells: usize) -> [f64; 2] {
    if number == 0 || number == 2 * cells {
        return [0.0, 1.0];
    }
    let (sin, cos) = (TAU * number as f64 / (2 * cells) as f64).sin_cos();
    [sin, cos]
}

/// A function of the angle by its values and slopes at the ends of the cells.
#[derive(Clone)]
struct Spline {
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Spline {
    fn map(&self, other: &Self, f: impl Fn(f64, f64) -> f64) -> Self {
        let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| f(*a, *b)).collect();
        Self { values: pairs(&self.values, &other.values), slopes: pairs(&self.slopes, &other.slopes) }
    }

    /// The value and the slope in the middle of a cell, whose length is `step`.
    fn middle(&self, cell: usize, step: f64) -> [f64; 2] {
        let [p, q] = [self.values[cell], self.values[cell + 1]];
        let [a, b] = [self.slopes[cell], self.slopes[cell + 1]];
        [0.5 * (p + q) + 0.125 * step * (a - b), 1.5 * (q - p) / step - 0.25 * (a + b)]
    }
}

/// A closed orbit in plain numbers, without any claim of accuracy.
struct ClosedOrbit {
    /// eps c.
    viscous: f64,
    radius: Spline,
}

/// The flow of a law at fixed parameters.
struct Flow {
    curve: Curve,
    belt_speed: f64,
    cells: usize,
}

impl Flow {
    fn new(law: &Law, x: &[f64], cells: usize) -> Self {
        let (parameters, belt_speed) = (&x[1..x.len() - 1], x[x.len() - 1]);
        Self { curve: law.curve(x[0], &LawParameters::new(parameters)), belt_speed, cells }
    }

    fn weakening(&self, u: f64) -> f64 {
        self.curve.weakening(u.max(0.0))
    }

    /// dr/dth, NaN where the angle does not advance.
    fn rate(&self, half_cell: usize, r: f64, viscous: f64) -> f64 {
        let [sin, cos] = sin_cos(half_cell, self.cells);
        let d = self.weakening(self.belt_speed * (1.0 - r * cos)) - viscous;
        let pace = 1.0 + d * sin * cos;
        if pace > SLOWEST { d * r * sin * sin / pace } else { f64::NAN }
    }

    /// The states and their slopes at the nodes of one turn, by the classical method of Runge and Kutta.
    fn follow<const N: usize>(
        &self,
        start: [f64; N],
        rates: impl Fn(usize, [f64; N]) -> [f64; N],
    ) -> Vec<[[f64; N]; 2]> {
        let h = TAU / self.cells as f64;
        let mut nodes = vec![[start, rates(0, start)]];
        for cell in 0..self.cells {
            let [y, k1] = nodes[cell];
            let moved = |k: [f64; N], by: f64| std::array::from_fn(|i| y[i] + by * k[i]);
            let k2 = rates(2 * cell + 1, moved(k1, 0.5 * h));
            let k3 = rates(2 * cell + 1, moved(k2, 0.5 * h));
            let k4 = rates(2 * cell + 2, moved(k3, h));
            let y = std::array::from_fn(|i| y[i] + h / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]));
            nodes.push([y, rates(2 * cell + 2, y)]);
        }
        nodes
    }

    /// One turn from r = 1.
    fn turn(&self, viscous: f64) -> Spline {
        let nodes = self.follow([1.0], |half_cell, [r]| [self.rate(half_cell, r, viscous)]);
        let (values, slopes) = nodes.into_iter().map(|[[r], [slope]]| (r, slope)).unzip();
        Spline { values, slopes }
    }

    /// The orbit that closes, by the secant method; `None` where none is found.
    fn closed(&self, guess: f64) -> Option<ClosedOrbit> {
        let (mut viscous, mut last) = (guess, None);
        for _ in 0..MOST_STEPS {
            let mut radius = self.turn(viscous);
            let growth = radius.values[self.cells].ln();
            // ln r falls by about pi for each unit of C.
            let slope = match last {
                Some((other, growth_there)) if other != viscous => {
                    (growth - growth_there) / (viscous - other)
                }
                _ => -std::f64::consts::PI,
            };
            let step = -growth / if slope < 0.0 { slope } else { -std::f64::consts::PI };
            if !step.is_finite() {
                return None;
            }
            if growth.abs() < 1e-13 || step.abs() <= 1e-15 * viscous.abs() {
                radius.values[self.cells] = 1.0;
                return Some(ClosedOrbit { viscous, radius });
            }
            last = Some((viscous, growth));
            viscous += step;
        }
        None
    }

    /// The mean of w over the grazing circle with the weight sin^2.
    fn mean_weakening(&self) -> f64 {
        let terms = (0..2 * self.cells).map(|half| {
            let [sin, cos] = sin_cos(half, self.cells);
            sin * sin * self.weakening(self.belt_speed * (1.0 - cos))
        });
        terms.sum::<f64>() / self.cells as f64
    }

    /// sigma with H = const along an orbit.
    fn spread(&self, orbit: &ClosedOrbit) -> Spline {
        let h = TAU / self.cells as f64;
        // q, the coefficient of sigma, and 1 + D sin cos.
        let coefficients = |half_cell: usize| {
            let [sin, cos] = sin_cos(half_cell, self.cells);
            let cell = half_cell / 2;
            let [r, slope] = match half_cell.is_multiple_of(2) {
                true => [orbit.radius.values[cell], orbit.radius.slopes[cell]],
                false => orbit.radius.middle(cell, h),
            };
            let u = self.belt_speed * (1.0 - r * cos);
            let (d, step) = (self.weakening(u) - orbit.viscous, 1e-6 * (1.0 + u.abs()));
            let bend = (self.weakening(u + step) - self.weakening(u - step)) / (2.0 * step);
            let q = r * sin * sin - slope * sin * cos;
            [q, d * sin * sin - bend * self.belt_speed * cos * q, 1.0 + d * sin * cos]
        };
        // sigma = p - kappa q, both from 0.
        let rates = |half_cell: usize, [p, k]: [f64; 2]| {
            let [q, a, m] = coefficients(half_cell);
            [(q + a * p) / m, (1.0 + a * k) / m]
        };
        let nodes = self.follow([0.0; 2], rates);
        let [[p, k], _] = nodes[self.cells];
        let kappa = p / k;
        let of_node = |node: [[f64; 2]; 2]| <(f64, f64)>::from(node.map(|[p, k]| p - kappa * k));
        let (mut values, slopes): (Vec<f64>, Vec<f64>) = nodes.into_iter().map(of_node).unzip();
        values[self.cells] = 0.0;
        Spline { values, slopes }
    }
}

/// The curves and the damping of a proof, in numbers that are exact by definition.
struct Witness {
    cells: usize,
    viscous: f64,
    slopes: Vec<f64>,
    radius: Spline,
    /// The change of the curve along each wide axis.
    changes: Vec<Spline>,
    sigma: Spline,
    /// Largest change of the weakening rate from one end of each axis to the other.
    by_axis: Vec<f64>,
}

impl Witness {
    /// `None` where an orbit is not found.
    fn new(law: &Law, domain: &Domain, cells: usize) -> Option<Self> {
        let flow = Flow::new(law, &domain.middle, cells);
        let middle = flow.closed(flow.mean_weakening())?;
        let sigma = flow.spread(&middle);
        let (mut viscous, mut radius) = (middle.viscous, middle.radius.clone());
        let [mut slopes, mut by_axis] = [(); 2].map(|()| vec![0.0; domain.middle.len()]);
        let mut changes = Vec::new();
        for &axis in &domain.wide {
            let ends = [domain.all[axis].lo, domain.all[axis].hi].map(|end| {
                let mut x = domain.middle.clone();
                x[axis] = end;
                let flow = Flow::new(law, &x, cells);
                let orbit = flow.closed(middle.viscous)?;
                Some((orbit.viscous, orbit.radius, flow))
            });
            let [Some((low, before, first)), Some((high, after, last))] = ends else { return None };
            let change = |node: usize| {
                let part = 1.0 - sin_cos(2 * node, cells)[1] * middle.radius.values[node];
                let [one, two] = [&first, &last].map(|flow| flow.weakening(flow.belt_speed * part));
                (two - one).abs()
            };
            by_axis[axis] = (0..cells).map(change).fold(0.0, f64::max);
            // Halfway between the chord and the middle, the error of a parabola is least.
            viscous += 0.25 * (low + high - 2.0 * middle.viscous);
            slopes[axis] = 0.5 * (high - low);
            let bend = before.map(&after, |a, b| 0.25 * (a + b)).map(&middle.radius, |sum, r| sum - 0.5 * r);
            radius = radius.map(&bend, |r, bend| r + bend);
            changes.push(after.map(&before, |b, a| 0.5 * (b - a)));
        }
        for spline in [&mut radius].into_iter().chain(&mut changes) {
            // The ends of the curves are exact.
            let whole = spline.values[0].round();
            for end in [0, cells] {
                (spline.values[end], spline.slopes[end]) = (whole, 0.0);
            }
        }
        let all = [&radius, &sigma].into_iter().chain(&changes);
        let is_finite = |spline: &Spline| spline.values.iter().chain(&spline.slopes).all(|x| x.is_finite());
        let fine = all.into_iter().all(is_finite) && viscous.is_finite();
        fine.then_some(Self { cells, viscous, slopes, radius, changes, sigma, by_axis })
    }
}

/// A cubic polynomial in the coordinate -1 <= y <= 1 of a cell.
struct Cubic([Interval; 4]);

impl Cubic {
    fn of(spline: &Spline, cell: usize, half: Interval) -> Self {
        let [p, q] = [spline.values[cell], spline.values[cell + 1]].map(Interval::of);
        let [a, b] = [spline.slopes[cell], spline.slopes[cell + 1]].map(|slope| Interval::of(slope) * half);
        let quarter = Interval::of(0.25);
        let c = Interval::constant;
        Self([
            c(0.5) * (p + q) + quarter * (a - b),
            c(0.75) * (q - p) - quarter * (a + b),
            quarter * (b - a),
            quarter * (p - q + a + b),
        ])
    }

    fn value(&self, y: Slope) -> Slope {
        let [a0, a1, a2, a3] = self.0.map(Slope::of);
        a0 + y * (a1 + y * (a2 + y * a3))
    }

    /// The derivative by y.
    fn slope(&self, y: Slope) -> Slope {
        let [_, a1, a2, a3] = self.0.map(Slope::of);
        let c = Slope::constant;
        a1 + y * (c(2.0) * a2 + y * (c(3.0) * a3))
    }
}

/// Cubics of the witness on one cell of angles.
struct Cell {
    /// The angle in the middle, and half the length.
    middle: Interval,
    half: Interval,
    radius: Cubic,
    /// The change of the curve along each wide axis.
    changes: Vec<Cubic>,
    sigma: Cubic,
}

impl Cell {
    fn new(witness: &Witness, number: usize) -> Self {
        // The last cell ends at 2 pi itself.
        let end = |number: usize| match number == witness.cells {
            true => Interval::new(TAU, TAU.next_up()),
            false => Interval::of(TAU * number as f64 / witness.cells as f64),
        };
        let (from, to) = (end(number), end(number + 1));
        let half = Interval::of(0.5) * (to - from);
        let cubic = |spline: &Spline| Cubic::of(spline, number, half);
        Self {
            middle: from + half,
            half,
            radius: cubic(&witness.radius),
            changes: witness.changes.iter().map(cubic).collect(),
            sigma: cubic(&witness.sigma),
        }
    }
}

/// Coordinates: y in a cell, and z along the wide axes of the box.
#[derive(Clone, Copy)]
enum Coordinates {
    /// The middle of the box at one y.
    Middle(f64),
    /// The whole box at the given y, and the derivative by the coordinate of this number: y first, then the
    /// axes.
    Whole(Interval, usize),
}

/// The curve, the law's parameters and the damping somewhere in a cell and in the box.
struct Place {
    sin: Slope,
    cos: Slope,
    /// The curve for t = 0, and its derivative by the angle.
    rho: Slope,
    slope: Slope,
    /// eps and the law's parameters.
    x: Vec<Slope>,
    belt_speed: Slope,
    /// C0 over the box.
    viscous: Slope,
}

struct Barrier<'a> {
    law: &'a Law,
    domain: &'a Domain,
    witness: &'a Witness,
}

impl Barrier<'_> {
    fn place(&self, cell: &Cell, coordinates: Coordinates) -> Place {
        let (of, c) = (Slope::of, Slope::constant);
        let coordinate = |number: usize| match coordinates {
            Coordinates::Middle(y) => c(if number == 0 { y } else { 0.0 }),
            Coordinates::Whole(y, along) => {
                let range = if number == 0 { y } else { UNIT };
                if number == along { Slope::variable(range, 1.0) } else { of(range) }
            }
        };
        let y = coordinate(0);
        let (sin, cos) = (of(cell.middle) + of(cell.half) * y).sin_cos();
        let (mut rho, mut slope) = (cell.radius.value(y), cell.radius.slope(y));
        let Domain { middle, half, wide, .. } = self.domain;
        let mut x: Vec<Slope> = middle.iter().map(|x| c(*x)).collect();
        let mut viscous = c(self.witness.viscous);
        for (i, (&axis, change)) in wide.iter().zip(&cell.changes).enumerate() {
            let z = coordinate(i + 1);
            (rho, slope) = (rho + z * change.value(y), slope + z * change.slope(y));
            x[axis] = x[axis] + c(half[axis]) * z;
            viscous = viscous + c(self.witness.slopes[axis]) * z;
        }
        let belt_speed = x.pop().unwrap_or(c(0.0));
        Place { sin, cos, rho, slope: slope / of(cell.half), x, belt_speed, viscous }
    }

    /// G for t = 0, with a derivative.
    fn defect(&self, cell: &Cell, coordinates: Coordinates) -> Option<Slope> {
        let Place { sin, cos, rho, slope, x, belt_speed, viscous } = self.place(cell, coordinates);
        let one = Slope::constant(1.0);
        let d = self.law.weakening_over(belt_speed * (one - rho * cos), &x)? - viscous;
        Some(slope * (one + d * sin * cos) - d * rho * sin * sin)
    }

    /// Bound on |G| for t = 0 in the box, at angles within `half` of `middle` in units of the cell: without
    /// the changes along the axes of the box, and with them.
    fn bound(&self, cell: &Cell, middle: f64, half: f64) -> Option<[f64; 2]> {
        let y = Interval::ball(middle, half);
        let change = |number: usize| Some(self.defect(cell, Coordinates::Whole(y, number))?.0[1]);
        let along =
            self.defect(cell, Coordinates::Middle(middle))?.0[0] + UNIT * change(0)? * Interval::of(half);
        let mut sum = Interval::of(along.size());
        for number in 1..=cell.changes.len() {
            sum = sum + Interval::of(change(number)?.size());
        }
        Some([along.size(), sum.hi])
    }

    /// The bound of [`Barrier::bound`] for a part of a cell. Parts whose bound exceeds `enough` are halved,
    /// `halvings` times at most.
    fn largest_defect(&self, cell: &Cell, [from, to]: [f64; 2], enough: f64, halvings: u32) -> Option<f64> {
        let middle = 0.5 * (from + to);
        let found = self.bound(cell, middle, 0.5 * (to - from)).map(|[_, sum]| sum);
        if halvings == 0 || found.is_some_and(|bound| bound <= enough) {
            return found;
        }
        let halves = [[from, middle], [middle, to]];
        let [one, two] = halves.map(|half| self.largest_defect(cell, half, enough, halvings - 1));
        Some(larger(one?, two?))
    }

    /// H for |t| <= `radius` in the box at the angles of a part of a cell.
    fn growth(&self, cell: &Cell, y: Interval, radius: f64) -> Option<Interval> {
        let place = self.place(cell, Coordinates::Whole(y, usize::MAX));
        let [sin, cos, rho, slope] = [place.sin, place.cos, place.rho, place.slope].map(|slope| slope.0[0]);
        let (one, t) = (Interval::ONE, Interval::new(-radius, radius));
        let [spread, spread_slope] = [cell.sigma.value(Slope::of(y)), cell.sigma.slope(Slope::of(y))];
        let (spread, spread_slope) = (spread.0[0], spread_slope.0[0].over(cell.half));
        let (rho, slope) = (rho + t * spread, slope + t * spread_slope);
        if !(rho.lo > 0.0) {
            return None;
        }
        let slip = place.belt_speed.0[0] * (one - rho * cos);
        let Slope { 0: [weakening, by_slip] } =
            self.law.weakening_over(Slope::variable(slip, 1.0), &place.x)?;
        let d = weakening - place.viscous.0[0] + t;
        let d_by = one - by_slip * place.belt_speed.0[0] * spread * cos;
        let swept = rho * sin.square() - slope * sin * cos;
        Some(d_by * swept + d * spread * sin.square() - spread_slope * (one + d * sin * cos))
    }

    /// Lower bound of H in a part of a cell. Parts are halved, `halvings` times at most, where that may raise
    /// it much; `None` where the curve is no barrier.
    fn least_growth(&self, cell: &Cell, [from, to]: [f64; 2], radius: f64, halvings: u32) -> Option<f64> {
        let middle = 0.5 * (from + to);
        let found =
            self.growth(cell, Interval::new(from, to), radius).map_or(f64::NEG_INFINITY, |found| found.lo);
        let there = self.growth(cell, Interval::of(middle), radius)?.lo;
        if !(there > 0.0) {
            return None;
        }
        if halvings == 0 || found >= WORTHWHILE * there {
            return (found > 0.0).then_some(found);
        }
        let halves = [[from, middle], [middle, to]];
        let [one, two] = halves.map(|half| self.least_growth(cell, half, radius, halvings - 1));
        Some(one?.min(two?))
    }
}

/// The larger of two bounds; NaN if one of them is.
fn larger(one: f64, two: f64) -> f64 {
    if one >= two { one } else { two }
}

impl Tile {
    /// Encloses the critical damping over a box; `None` where the proof does not go through, and for laws whose
    /// friction may drop as slip begins: the orbit from the exit point starts elsewhere then.
    pub(crate) fn prove(law: &Law, ranges: &[[f64; 2]]) -> Option<Self> {
        if law.may_drop() {
            return None;
        }
        let domain = Domain::new(ranges);
        for (rung, cells) in CELLS.into_iter().enumerate() {
            let witness = Witness::new(law, &domain, cells)?;
            let barrier = Barrier { law, domain: &domain, witness: &witness };
            let cells: Vec<Cell> = (0..cells).map(|number| Cell::new(&witness, number)).collect();
            // Most boxes that are too large for a proof fail here.
            if !cells.iter().all(|cell| barrier.growth(cell, Interval::ZERO, 0.0).is_some_and(|h| h.lo > 0.0))
            {
                return None;
            }
            let (mut along, mut least) = (0.0, 0.0);
            for cell in &cells {
                let [along_orbit, sum] = barrier.bound(cell, 0.0, 0.0)?;
                (along, least) = (larger(along, along_orbit), larger(least, sum));
            }
            if along > OWN_SHARE * least && rung + 1 < CELLS.len() {
                continue;
            }
            let radius = radius(&barrier, &cells, least)?;
            let Witness { viscous, slopes, by_axis, .. } = witness;
            return Some(Self { ranges: ranges.to_vec(), viscous, slopes, radius, by_axis });
        }
        None
    }
}

/// The radius that a witness proves, where the defect is at least `least`.
fn radius(barrier: &Barrier, cells: &[Cell], least: f64) -> Option<f64> {
    let mut defect = 0.0;
    for cell in cells {
        defect =
            larger(defect, barrier.largest_defect(cell, [-1.0, 1.0], least / WORTHWHILE, MOST_HALVINGS)?);
    }
    let mut radius = FIRST_RADIUS * defect + f64::MIN_POSITIVE;
    for _ in 0..TRIALS {
        let mut growth = f64::INFINITY;
        for cell in cells {
            growth = growth.min(barrier.least_growth(cell, [-1.0, 1.0], radius, MOST_HALVINGS)?);
        }
        let proved = ROUNDING * Interval::of(defect).over(Interval::of(growth)).hi + f64::MIN_POSITIVE;
        if proved <= radius {
            return Some(proved);
        }
        radius = 1.5 * proved;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::curve;
    use slipmap_model::friction::{Expression, Table};
    use slipmap_model::point::Point;
    use slipmap_numbers::random::Random;

    fn boxes() -> Vec<(Law, Ranges)> {
        let formula = Expression::new("mu + (1-mu)*exp(-u/vs) + 0.05*u^2", 1.0).unwrap();
        let table = Table::new("data", &[(0.0, 1.0), (0.2, 0.9), (0.7, 0.7), (1.5, 0.6), (3.0, 0.62)], 1.0);
        vec![
            (Law::Stribeck, vec![[0.1, 0.11], [0.3, 0.32], [0.1, 0.12], [2.0, 2.1], [1.0, 1.05]]),
            (Law::Exponential, vec![[1.0, 1.0], [0.4, 0.45], [0.5, 0.55], [0.0, 0.0], [0.9, 1.0]]),
            (Law::Lorentzian, vec![[0.5, 0.52], [0.4, 0.41], [0.5, 0.51], [0.01, 0.01], [0.9, 0.92]]),
            (Law::Expression(formula), vec![[1.0, 1.0], [0.4, 0.45], [0.8, 0.85], [0.9, 0.92]]),
            (Law::Table(table.unwrap()), vec![[1.0, 1.0], [0.5, 0.55]]),
        ]
    }

    #[test]
    fn tiles_hold_the_points_inside() {
        let mut random = Random(5);
        for (law, ranges) in boxes() {
            let tile = Tile::prove(&law, &ranges).unwrap_or_else(|| panic!("{law:?}"));
            let domain = Domain::new(&ranges);
            for i in 0..6 {
                let unit = || if i < 4 { random.unit().round() } else { random.unit() };
                let unit = std::iter::repeat_with(unit).take(ranges.len());
                let x: Vec<f64> =
                    ranges.iter().zip(unit).map(|([lo, hi], unit)| lo + unit * (hi - lo)).collect();
                let point = Point {
                    epsilon: x[0],
                    law: LawParameters::new(&x[1..x.len() - 1]),
                    belt_speed: x[x.len() - 1],
                    damping: 0.0,
                };
                let own = curve::prove(&law.column(&point)).critical();
                let linear = (0..x.len())
                    .map(|axis| tile.slopes[axis] * (x[axis] - domain.middle[axis]) / domain.half[axis]);
                let middle = tile.viscous + linear.sum::<f64>();
                assert!(own.hi - own.lo < 1e-7, "{own:?}");
                assert!(
                    (own.lo - middle).abs() <= tile.radius && (own.hi - middle).abs() <= tile.radius,
                    "{x:?} {own:?} {middle} {}",
                    tile.radius
                );
            }
        }
    }
}

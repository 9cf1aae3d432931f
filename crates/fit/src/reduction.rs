//! Measured friction reduced to a curve with the covariance of its values.
//!
//! Where to bend and how sure are two questions. The friction is
//!
//! ```text
//! f(u) = a + b u + c g(u / v) + deviation(u)
//! ```
//!
//! with g one of the functions of [`fall`], v on a grid of logarithms, and a deviation of cubic B-splines in ln(1 + u / u0), u0 on a grid,
//! whose first and second differences are penalised, by eight weights each. Nothing is optimised: the curve is the mean
//! over all of these by marginal likelihood, and its covariance that of the mixture. The rows of a table are independent,
//! and a set; those of a record follow one another with an error that remembers, and one that is common to a visit of a
//! range of speeds.

mod noise;

use nalgebra::{Cholesky, Const, DMatrix, DVector, Dyn, OMatrix, SMatrix, SVector, SymmetricEigen};
use noise::{Gram, Row, autoregression, filtered, grams};

/// Number of splines.
const K: usize = 20;
/// Length in ln(1 + u / u0) beyond which first differences are penalised more than second ones.
const LENGTH: f64 = 1.5;
/// Scale of the deviation, of the range of the readings: without it short tables have errors without bound.
const DEVIATION: f64 = 0.1;
/// Least range, of the largest reading: of constant friction, too, there is a curve.
const LEAST_RANGE: f64 = 1e-6;
/// Number of weights of the penalty, and of values of v: at first and refined.
const WEIGHTS: usize = 8;
const SPEEDS: usize = 20;
const REFINED: usize = 24;
/// Logarithms of the likelihood, below the largest, down to which the curve is a mean, values of v are refined,
/// and choices of u0 and of the noise are kept.
const KEPT: [f64; 3] = [11.0, 12.0, 14.0];
/// Number of slip speeds of the curve.
const KNOTS: usize = 24;
/// What splines and slip speeds leave, of the range of the readings.
const FLOOR: f64 = 3e-4;
/// What the rows tell of a direction, of what they and the penalty do, up to which it is rounding.
const ROUNDED: f64 = 1e-8;
/// Least difference of slip speeds at which the rows are told, of the larger one.
const CLOSEST: f64 = 1e-3;
/// Largest slip speed over u0.
const STRETCHES: [f64; 4] = [1000.0, 100.0, 30.0, 10.0];
/// Correlations of neighbouring rows of a record, and those after a filter of several rows.
const RHOS: [f64; 9] = [0.0, 0.3, 0.5, 0.7, 0.8, 0.87, 0.92, 0.96, 0.985];
const RHOS_AFTER: [f64; 6] = [-0.3, -0.15, 0.0, 0.15, 0.3, 0.5];
/// Least number of visits that have an error of their own, and their largest number per row.
const FEWEST_VISITS: usize = 4;
const VISITS_PER_ROW: f64 = 0.4;

/// Number of falls g: three rational ones, and exp(-z^k) with k from 0.5 to 2, eight of them to a factor of 2.
const SHAPES: usize = 20;
const RATIONAL: usize = 3;
/// Weight of one exponent, in units of that of a rational fall.
const OF_EXPONENT: f64 = 0.25;

/// The fall g of this number.
fn fall(shape: usize, z: f64) -> f64 {
    match shape {
        0 => 1.0 / (1.0 + z),
        1 => 1.0 / (1.0 + z * z),
        2 => (1.0 + z).powi(-2),
        power => (-z.powf(0.5 * (0.125 * (power - RATIONAL) as f64).exp2())).exp(),
    }
}

type Square = SMatrix<f64, K, K>;
type Vector = SVector<f64, K>;
type Values = OMatrix<f64, Dyn, Const<K>>;

/// Readings in slip.
#[derive(Clone, Copy, Debug)]
pub struct Rows<'a> {
    /// Slip speeds, greater than 0.
    pub speeds: &'a [f64],
    /// Friction.
    pub friction: &'a [f64],
    /// Standard errors, greater than 0, if they are known.
    pub errors: Option<&'a [f64]>,
    /// Of a record the number of the visit to which each row belongs, from 0 on, by time.
    pub visits: Option<&'a [usize]>,
    /// Numbers of which an unknown multiple is part of the friction, and not of the curve.
    pub aside: Option<&'a [f64]>,
    /// The last slip speed of the curve.
    pub last: f64,
    /// Slip speeds up to the last one at which the rows are told without a law, beside those of the curve.
    pub told_at: &'a [f64],
}

/// The curve of the friction.
#[derive(Clone, Debug)]
pub struct Reduced {
    /// Slip speeds, from 0 to the largest.
    pub speeds: Vec<f64>,
    /// The friction there.
    pub friction: DVector<f64>,
    /// Its covariance.
    pub covariance: DMatrix<f64>,
    /// The part of it that comes from what is smoothed, not from the errors of the rows.
    smoothed: DMatrix<f64>,
    /// Slip speeds, the friction there and its covariance without the law of a small family, and hardly smoothed: what the rows
    /// say, for a law that is fitted to them.
    pub by_rows: (Vec<f64>, DVector<f64>, DMatrix<f64>),
    /// Standard deviation of a reading; in units of its error where that is known.
    pub scatter: f64,
    /// The multiple of what is put aside.
    pub aside: f64,
    /// The probability that visits have an error of their own.
    of_visits: f64,
}

/// Reduces readings at six slip speeds at least, all of which are finite.
pub fn reduce(rows: Rows) -> Reduced {
    let Some(given) = rows.visits else { return posterior(rows, &[], &[]) };
    let count = given.iter().max().map_or(0, |last| last + 1);
    let one = vec![0; given.len()];
    let are_many = count < FEWEST_VISITS || count as f64 > VISITS_PER_ROW * given.len() as f64;
    let visits = if are_many { &one } else { given };
    let rows = Rows { visits: Some(visits), ..rows };
    let first = posterior(rows, &[], &RHOS);
    // Without their means errors that remember look as if they did less.
    let phi = autoregression(&first.residuals(rows), visits, first.of_visits > 0.5);
    if phi.len() > 1 { posterior(rows, &phi, &RHOS_AFTER) } else { first }
}

impl Reduced {
    /// The curve, given that the friction at rest is `level` with this variance.
    pub fn begin_at(&mut self, level: f64, variance: f64) {
        let with_first = self.covariance.column(0) / (self.covariance[(0, 0)] + variance);
        self.friction += &with_first * (level - self.friction[0]);
        self.covariance -= &with_first * self.covariance.row(0).into_owned();
    }

    /// Adds what errors of the slip speeds make of the curve: they are white and of this standard deviation, so that it is the
    /// true one and half of its second derivative times their variance, to first order.
    pub fn smear(&mut self, deviation: f64) {
        let last = self.speeds.len() - 1;
        let bias = DVector::from_fn(self.speeds.len(), |i, _| {
            let at = i.clamp(1, last - 1);
            let slope =
                |i: usize| (self.friction[i] - self.friction[i - 1]) / (self.speeds[i] - self.speeds[i - 1]);
            let width = 0.5 * (self.speeds[at + 1] - self.speeds[at - 1]);
            0.5 * deviation * deviation * (slope(at + 1) - slope(at)) / width
        });
        self.covariance.ger(1.0, &bias, &bias, 1.0);
        let bias: Vec<f64> = bias.iter().copied().collect();
        let bias = self.by_rows.0.iter().map(|speed| between(*speed, &self.speeds, &bias));
        let bias = DVector::from_vec(bias.collect());
        self.by_rows.2.ger(1.0, &bias, &bias, 1.0);
    }

    /// The mean of two curves of one shape at the same slip speeds: the errors of their rows are independent, and what is
    /// smoothed is the same in both.
    pub fn mean(self, other: Self) -> Self {
        let smoothed = (self.smoothed + other.smoothed) * 0.5;
        Self {
            friction: (self.friction + other.friction) * 0.5,
            covariance: (self.covariance + other.covariance) * 0.25 + &smoothed * 0.5,
            smoothed,
            by_rows: (
                self.by_rows.0,
                (self.by_rows.1 + other.by_rows.1) * 0.5,
                (self.by_rows.2 + other.by_rows.2) * 0.25,
            ),
            scatter: 0.5 * (self.scatter + other.scatter),
            ..self
        }
    }

    /// The standard errors of the friction.
    pub fn errors(&self) -> Vec<f64> {
        self.covariance.diagonal().iter().map(|variance| variance.max(0.0).sqrt()).collect()
    }

    /// The root of the covariance, a lower triangle, from the slip speed of number `from` on; `None` where it has none.
    pub fn root(&self, from: usize) -> Option<DMatrix<f64>> {
        let count = self.speeds.len() - from;
        // An exact value has no variance: what rounding leaves of it is no error.
        let least = f64::EPSILON * self.covariance.diagonal().max();
        let part =
            self.covariance.view((from, from), (count, count)) + DMatrix::identity(count, count) * least;
        part.cholesky().map(|factor| factor.l())
    }

    /// The curve at a slip speed: the cubic through the next four values.
    pub fn at(&self, speed: f64) -> f64 {
        let x = |u: f64| (u / self.speeds[1]).ln_1p();
        let after = self.speeds.partition_point(|knot| *knot <= speed);
        let from = after.saturating_sub(2).min(self.speeds.len() - 4);
        let term = |i: usize| {
            let [own, at] = [x(self.speeds[i]), x(speed)];
            let others = (from..from + 4).filter(|j| *j != i).map(|j| x(self.speeds[j]));
            self.friction[i] * others.map(|other| (at - other) / (own - other)).product::<f64>()
        };
        (from..from + 4).map(term).sum()
    }

    /// Readings less the curve, in units of their errors where these are known.
    fn residuals(&self, rows: Rows) -> Vec<f64> {
        let unit = |i: usize| rows.errors.map_or(1.0, |errors| errors[i]);
        let pairs = rows.speeds.iter().zip(rows.friction).enumerate();
        let aside = |i: usize| rows.aside.map_or(0.0, |aside| self.aside * aside[i]);
        pairs.map(|(i, (speed, friction))| (friction - self.at(*speed) - aside(i)) / unit(i)).collect()
    }
}

/// The friction at which a phase of rest ends: that of a parabola through its samples, half a sample after the last one.
pub fn breakaway(samples: &[f64]) -> f64 {
    let n = samples.len() as f64;
    let end = 0.5 * n;
    // Orthogonal on evenly spaced samples.
    let powers = |t: f64| [1.0, t, t * t - (n * n - 1.0) / 12.0];
    let squares = [n, n * (n * n - 1.0) / 12.0, n * (n * n - 1.0) * (n * n - 4.0) / 180.0];
    // Of three samples and fewer a parabola is all chance.
    let terms = samples.len().saturating_sub(1).clamp(1, 3);
    let product = |term: usize| {
        let of = |(i, sample): (usize, &f64)| powers(i as f64 - 0.5 * (n - 1.0))[term] * sample;
        samples.iter().enumerate().map(of).sum::<f64>()
    };
    (0..terms).map(|term| product(term) / squares[term] * powers(end)[term]).sum()
}

/// Evenly spaced numbers.
fn even(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..count).map(|i| from + (to - from) * i as f64 / (count - 1) as f64).collect()
}

/// The splines that are not 0 at x: the first of four, and their values.
fn splines(x: f64, largest: f64) -> (usize, [f64; 4]) {
    let pieces = (K - 3) as f64;
    let z = (x / largest * pieces).clamp(0.0, pieces - 1e-12);
    let (i, t) = (z.floor(), z.fract());
    let (t2, t3) = (t * t, t * t * t);
    let values = [(1.0 - t).powi(3), 3.0 * t3 - 6.0 * t2 + 4.0, -3.0 * t3 + 3.0 * t2 + 3.0 * t + 1.0, t3];
    (i as usize, values.map(|value| value / 6.0))
}

/// The splines in ln(1 + u / u0).
struct Basis {
    u0: f64,
    largest: f64,
    /// Slip speeds at which functions are approximated, and the solution of least squares.
    grid: Vec<f64>,
    normal: Cholesky<f64, Const<K>>,
    /// The penalty of a deviation, 0 for constants and lines.
    penalty: Square,
}

impl Basis {
    fn new(u0: f64, fastest: f64) -> Option<Self> {
        let largest = (fastest / u0).ln_1p();
        let count = 4 * K;
        let grid: Vec<f64> =
            (0..count).map(|i| u0 * ((i as f64 + 0.5) / count as f64 * largest).exp_m1()).collect();
        let mut normal = Square::zeros();
        for speed in &grid {
            let (first, values) = splines((speed / u0).ln_1p(), largest);
            for (i, a) in values.iter().enumerate() {
                values.iter().enumerate().for_each(|(j, b)| normal[(first + i, first + j)] += a * b);
            }
        }
        let spacing = largest / (K - 3) as f64;
        let mut penalty = Square::zeros();
        let mut add = |first: usize, difference: &[f64], scale: f64| {
            for (i, a) in difference.iter().enumerate() {
                difference
                    .iter()
                    .enumerate()
                    .for_each(|(j, b)| penalty[(first + i, first + j)] += a * b * scale);
            }
        };
        (0..K - 2).for_each(|first| add(first, &[1.0, -2.0, 1.0], spacing.powi(-3)));
        (0..K - 1).for_each(|first| add(first, &[-1.0, 1.0], 1.0 / spacing / (LENGTH * LENGTH)));
        let mut basis = Self { u0, largest, grid, normal: normal.cholesky()?, penalty };
        let line = basis.penalty * basis.of(|speed| speed / fastest);
        let share = basis.of(|speed| speed / fastest).dot(&line);
        basis.penalty -= line * line.transpose() / share;
        Some(basis)
    }

    /// The coefficients of a function.
    fn of(&self, function: impl Fn(f64) -> f64) -> Vector {
        let mut sums = Vector::zeros();
        for speed in &self.grid {
            let (first, values) = self.at(*speed);
            let value = function(*speed);
            values.iter().enumerate().for_each(|(i, spline)| sums[first + i] += spline * value);
        }
        self.normal.solve(&sums)
    }

    /// The splines at slip speeds, row by row.
    fn values(&self, speeds: &[f64]) -> Values {
        let mut values = Values::zeros(speeds.len());
        for (row, speed) in speeds.iter().enumerate() {
            let (first, splines) = self.at(*speed);
            splines.iter().enumerate().for_each(|(i, value)| values[(row, first + i)] = *value);
        }
        values
    }

    fn at(&self, speed: f64) -> (usize, [f64; 4]) {
        splines((speed / self.u0).ln_1p(), self.largest)
    }

    /// The rows as splines and friction, in units of their errors.
    fn rows(&self, rows: Rows) -> Vec<Row> {
        let of = |i: usize| {
            let unit = rows.errors.map_or(1.0, |errors| errors[i]);
            let (first, values) = self.at(rows.speeds[i]);
            let mut row = [0.0; K + 2];
            row[first..first + 4].iter_mut().zip(values).for_each(|(to, value)| *to = value / unit);
            row[K] = rows.friction[i] / unit;
            row[K + 1] = rows.aside.map_or(0.0, |aside| aside[i] / unit);
            row
        };
        (0..rows.speeds.len()).map(of).collect()
    }
}

/// One choice of u0 and of the noise: the deviation in coordinates in which both the rows and the penalty are diagonal.
struct Model {
    basis: usize,
    /// Whether visits have an error of their own.
    of_visits: bool,
    /// To the coordinates, and back.
    into: Square,
    back: Square,
    /// What the rows tell of each coordinate, and the penalty.
    known: Vector,
    penalty: Vector,
    /// Weights of the penalty, and 1 / (known + weight * penalty).
    weights: Vec<f64>,
    inverse: Vec<Vector>,
    /// The rows' products with the friction, and of the friction with itself.
    product: Vector,
    square: f64,
    /// What is left of the square at each weight, without g.
    rest: Vec<f64>,
    /// What does not depend on g, of the logarithm of the likelihood.
    base: Vec<f64>,
    freedom: f64,
    unit: f64,
}

/// Value of a function that is linear between its points, by increasing x.
fn between(at: f64, x: &[f64], y: &[f64]) -> f64 {
    let after = x.partition_point(|x| *x <= at);
    if after == 0 || after == x.len() {
        return y[after.min(y.len() - 1)];
    }
    let share = (at - x[after - 1]) / (x[after] - x[after - 1]);
    y[after - 1] + share * (y[after] - y[after - 1])
}

impl Model {
    fn new(
        basis: (usize, &Basis),
        (gram, log_determinant, of_visits): &(Gram, f64, bool),
        count: usize,
    ) -> Option<Self> {
        let (basis, Basis { penalty: of_basis, .. }) = basis;
        let rows: Square = gram.fixed_view::<K, K>(0, 0).into_owned();
        let with_friction: Vector = gram.fixed_view::<K, 1>(0, K).into_owned();
        let unit = 1e-3 * rows.trace() / of_basis.trace();
        let whole = rows + of_basis * unit + Square::identity() * (1e-11 * rows.trace() / K as f64);
        let inverse_factor = whole.cholesky()?.l().try_inverse()?;
        let eigen = SymmetricEigen::new(inverse_factor * rows * inverse_factor.transpose());
        let known = eigen.eigenvalues.map(|e| if 1.0 - e < 1e-7 { 1.0 } else { e.max(0.0) });
        let back = inverse_factor.transpose() * eigen.eigenvectors;
        let penalty = known.map(|e| 1.0 - e);
        let free = known.iter().filter(|e| **e == 1.0).count() as f64;
        // Degrees of freedom of the deviation, from small to large weights.
        let logarithms = even(-8.0, 12.0, 81);
        let freedom = |log: &f64| {
            let weight = 10f64.powf(*log);
            free - known.iter().zip(&penalty).map(|(e, p)| e / (e + weight * p)).sum::<f64>()
        };
        let less: Vec<f64> = logarithms.iter().map(freedom).collect();
        let most = -less[0];
        let [low, high] =
            [10f64.min(0.5 * most + 3.0).min(0.9 * most), 0.02].map(|of| between(-of, &less, &logarithms));
        let weights: Vec<f64> =
            even(low, high.max(low + 1.0), WEIGHTS).iter().map(|log| 10f64.powf(*log)).collect();
        let inverse: Vec<Vector> =
            weights.iter().map(|weight| known.zip_map(&penalty, |e, p| 1.0 / (e + weight * p))).collect();
        let product = back.transpose() * with_friction;
        let square = gram[(K, K)];
        let spread = (weights[WEIGHTS - 1] / weights[0]).ln().ln();
        let base = weights.iter().zip(&inverse).map(|(weight, inverse)| {
            let told = (0..K).filter(|i| known[*i] < 1.0 && known[*i] > 1e-12);
            let logs = told.map(|i| (weight * penalty[i] * inverse[i]).max(1e-300).ln());
            0.5 * logs.sum::<f64>() + *log_determinant + spread
        });
        let (base, rest) = (
            base.collect(),
            inverse.iter().map(|inverse| square - inverse.dot(&product.component_mul(&product))).collect(),
        );
        let freedom = (count as f64 - free - 1.0).max(1.0);
        let into = (whole * back).transpose();
        Some(Self {
            basis,
            of_visits: *of_visits,
            into,
            back,
            known,
            penalty,
            weights,
            inverse,
            product,
            square,
            rest,
            base,
            freedom,
            unit,
        })
    }

    /// The fall with these coefficients, at each weight of the penalty.
    fn weigh(&self, fall: &Vector, context: &Context, width: f64) -> [Weighed; WEIGHTS] {
        let Self { known, penalty, product, .. } = self;
        let g = self.into * fall;
        let told = g.component_mul(&g).component_mul(known);
        let limit: f64 = told.iter().zip(known).map(|(told, e)| if *e < 1.0 { *told } else { 0.0 }).sum();
        let of_penalty = told.component_mul(penalty);
        let with_friction = g.component_mul(penalty).component_mul(product);
        std::array::from_fn(|l| {
            let (weight, inverse) = (self.weights[l], &self.inverse[l]);
            let share = of_penalty.dot(inverse);
            let size = weight / share.max(1e-300);
            let fitted = with_friction.dot(inverse);
            let left = (self.rest[l] - size * fitted * fitted).max(1e-13 * self.square);
            let by_rows = left / self.freedom;
            // Rows scatter at least as much as their errors say.
            let variance = if context.errors_known { by_rows.max(1.0) } else { by_rows };
            let likelihood =
                -0.5 * self.freedom * ((variance * self.freedom).ln() + by_rows / variance - 1.0)
                    + self.base[l]
                    - 0.5 * ((weight * share).max(1e-300) / limit).ln()
                    - (variance / (weight * self.unit) / (DEVIATION * DEVIATION * context.span)).ln_1p()
                    + width.ln();
            Weighed { likelihood, variance, size, fitted }
        })
    }
}

/// What all models have in common.
struct Context {
    /// Square of the range of the readings.
    span: f64,
    errors_known: bool,
}

/// A choice of the law and of the penalty.
#[derive(Clone, Copy)]
struct Weighed {
    likelihood: f64,
    variance: f64,
    /// Variance of the coefficient of g in units of that of the rows, and its product with the friction.
    size: f64,
    fitted: f64,
}

/// Logarithms of v for one shape.
struct Grid {
    shape: usize,
    logs: Vec<f64>,
}

impl Grid {
    /// The weight of each of its speeds.
    fn width(&self) -> f64 {
        let share = if self.shape < RATIONAL { 1.0 } else { OF_EXPONENT };
        share * (self.logs[1] - self.logs[0])
    }

    /// The coefficients of g for all v, in each basis.
    fn falls(&self, bases: &[Basis]) -> Vec<Vec<Vector>> {
        let of = |basis: &Basis| {
            let of_speed = |log: &f64| {
                let speed = log.exp();
                basis.of(|u| fall(self.shape, u / speed))
            };
            self.logs.iter().map(of_speed).collect()
        };
        bases.iter().map(of).collect()
    }
}

/// Sums of products for any multiple of what is put aside.
fn without_aside((gram, log, of_visits): (Gram, f64, bool)) -> (Gram, f64, bool) {
    let aside = gram.column(K + 1).into_owned();
    let square = aside[K + 1];
    (gram - aside * aside.transpose() / square, log - 0.5 * square.ln(), of_visits)
}

fn posterior(rows: Rows, phi: &[f64], rhos: &[f64]) -> Reduced {
    let fastest = rows.speeds.iter().copied().fold(0.0, f64::max);
    let slowest = rows.speeds.iter().copied().fold(f64::INFINITY, f64::min).max(fastest / 3000.0);
    let [least, most] =
        [f64::min, f64::max].map(|of| rows.friction.iter().copied().reduce(of).unwrap_or(0.0));
    let range = (most - least).max(LEAST_RANGE * most.abs().max(least.abs()));
    let context = Context { span: range * range, errors_known: rows.errors.is_some() };
    let mut starts: Vec<f64> =
        STRETCHES.iter().map(|of| fastest / of).filter(|u0| *u0 >= 0.5 * slowest).collect();
    if starts.is_empty() {
        starts.push(fastest / 3.0);
    }
    let bases: Vec<Basis> = starts.into_iter().filter_map(|u0| Basis::new(u0, fastest)).collect();
    let mut models: Vec<Model> = Vec::new();
    for (i, basis) in bases.iter().enumerate() {
        let (filtered, visits) = filtered(basis.rows(rows), rows.visits, phi);
        let all = grams(&filtered, visits, rhos);
        let freedom = filtered.len() - usize::from(rows.aside.is_some());
        let all = all.into_iter().map(|all| if rows.aside.is_some() { without_aside(all) } else { all });
        models.extend(all.filter_map(|of| Model::new((i, basis), &of, freedom)));
    }
    let range = [(0.5 * slowest).max(fastest / 1000.0).ln(), fastest.ln()];
    let grids = (0..SHAPES).map(|shape| Grid { shape, logs: even(range[0], range[1], SPEEDS) });
    let grids = refined(&bases, &mut models, grids.collect(), &context);
    let mut found = mixture(&bases, &models, &grids, &context, rows);
    if let Some(aside) = rows.aside {
        let weights = |i: usize| aside[i] / rows.errors.map_or(1.0, |errors| errors[i]).powi(2);
        let sums =
            found.residuals(rows).into_iter().enumerate().fold([0.0; 2], |[over, under], (i, residual)| {
                let unit = rows.errors.map_or(1.0, |errors| errors[i]);
                [over + weights(i) * unit * residual, under + weights(i) * aside[i]]
            });
        found.aside = sums[0] / sums[1];
    }
    found
}

/// The grids of v, refined where the likelihood is not small; drops models for which it is.
fn refined(bases: &[Basis], models: &mut Vec<Model>, mut grids: Vec<Grid>, context: &Context) -> Vec<Grid> {
    const ROUNDS: usize = 4;
    for round in 0..ROUNDS {
        let mut best: Vec<Vec<f64>> =
            grids.iter().map(|grid| vec![f64::NEG_INFINITY; grid.logs.len()]).collect();
        let mut tops = vec![f64::NEG_INFINITY; models.len()];
        for (grid, best) in grids.iter().zip(&mut best) {
            let falls = grid.falls(bases);
            for (model, top) in models.iter().zip(&mut tops) {
                for (fall, best) in falls[model.basis].iter().zip(best.iter_mut()) {
                    let all = model.weigh(fall, context, grid.width());
                    let largest = all.iter().map(|of| of.likelihood).fold(f64::NEG_INFINITY, f64::max);
                    *best = best.max(largest);
                    *top = top.max(largest);
                }
            }
        }
        let top = tops.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let mut tops = tops.into_iter();
        models.retain(|_| tops.next().is_some_and(|of| of > top - KEPT[2]));
        let (mut next, mut done) = (Vec::new(), true);
        for (grid, best) in grids.iter().zip(&best) {
            let is_likely = |likelihood: &f64| *likelihood > top - KEPT[1];
            let (Some(first), Some(last)) =
                (best.iter().position(is_likely), best.iter().rposition(is_likely))
            else {
                continue;
            };
            let (logs, end) = (&grid.logs, grid.logs.len() - 1);
            let (from, to) = (logs[first.saturating_sub(1)], logs[(last + 1).min(end)]);
            let narrows = round == 0 || to - from < 0.6 * (logs[end] - logs[0]);
            done &= !narrows;
            let logs = if narrows { even(from, to, REFINED) } else { logs.clone() };
            next.push(Grid { shape: grid.shape, logs });
        }
        if done || round + 1 == ROUNDS {
            break;
        }
        grids = next;
    }
    grids
}

/// The mean of all models, falls and penalties, and its covariance.
fn mixture(bases: &[Basis], models: &[Model], grids: &[Grid], context: &Context, rows: Rows) -> Reduced {
    let scale = rows.last / 30.0;
    let speeds: Vec<f64> =
        even(0.0, (rows.last / scale).ln_1p(), KNOTS).iter().map(|x| scale * x.exp_m1()).collect();
    let mut all: Vec<(usize, usize, Vector, Weighed)> = Vec::new();
    for grid in grids {
        let falls = grid.falls(bases);
        for (m, model) in models.iter().enumerate() {
            for fall in &falls[model.basis] {
                let weighed = model.weigh(fall, context, grid.width());
                all.extend(weighed.into_iter().enumerate().map(|(l, of)| (m, l, *fall, of)));
            }
        }
    }
    let top = all.iter().map(|(.., of)| of.likelihood).fold(f64::NEG_INFINITY, f64::max);
    all.retain(|(.., of)| of.likelihood > top - KEPT[0]);
    let total: f64 = all.iter().map(|(.., of)| (of.likelihood - top).exp()).sum();
    let at_knots: Vec<Values> =
        models.iter().map(|model| bases[model.basis].values(&speeds) * model.back).collect();
    let mut covariance = DMatrix::zeros(KNOTS, KNOTS);
    let (mut means, mut variance) = (Vec::new(), 0.0);
    let mut of_rows = vec![[0.0; WEIGHTS]; models.len()];
    for (m, l, fall, of) in &all {
        let model = &models[*m];
        let weight = (of.likelihood - top).exp() / total;
        let inverse = &model.inverse[*l];
        let g = (model.into * fall).component_mul(&model.penalty).component_mul(inverse);
        let by_fall = &at_knots[*m] * g;
        let mean = &at_knots[*m] * inverse.component_mul(&model.product) + &by_fall * (of.size * of.fitted);
        covariance.ger(weight * of.variance * of.size, &by_fall, &by_fall, 1.0);
        of_rows[*m][*l] += weight * of.variance;
        variance += weight * of.variance;
        means.push((weight, mean));
    }
    let mut smoothed = DMatrix::zeros(KNOTS, KNOTS);
    for ((model, values), weights) in models.iter().zip(&at_knots).zip(&of_rows) {
        let of_penalty = model.inverse.iter().zip(&model.weights).zip(weights);
        for ((inverse, penalty), weight) in of_penalty.filter(|(_, weight)| **weight > 0.0) {
            let scaled = values * Square::from_diagonal(&(inverse * *weight));
            covariance += &scaled * values.transpose();
            let share = inverse.component_mul(&model.penalty) * *penalty;
            smoothed += scaled * Square::from_diagonal(&share) * values.transpose();
        }
    }
    let mut friction = DVector::zeros(KNOTS);
    means.iter().for_each(|(weight, mean)| friction.axpy(*weight, mean, 1.0));
    for (weight, mean) in &means {
        let off = mean - &friction;
        covariance.ger(*weight, &off, &off, 1.0);
    }
    (0..KNOTS).for_each(|i| covariance[(i, i)] += FLOOR * FLOOR * context.span);
    // For each model the sum of its weights, and the mean variance.
    let shares = (0..models.len()).map(|m| {
        let of_model = all.iter().filter(|(of, ..)| *of == m);
        let [weight, variance] = of_model.fold([0.0; 2], |sums, (.., of)| {
            let weight = (of.likelihood - top).exp() / total;
            [sums[0] + weight, sums[1] + weight * of.variance]
        });
        [weight, variance / weight]
    });
    let shares: Vec<[f64; 2]> = shares.collect();
    let of_visits = models.iter().zip(&shares).filter(|(model, _)| model.of_visits);
    let of_visits = of_visits.map(|(_, [weight, _])| weight).sum();
    let told_at: Vec<f64> = speeds.iter().chain(rows.told_at).copied().collect();
    let by_rows = without_law(bases, models, &shares, context, told_at);
    Reduced {
        speeds,
        friction,
        covariance,
        smoothed,
        by_rows,
        scatter: variance.sqrt(),
        aside: 0.0,
        of_visits,
    }
}

/// What the rows say without a law, by models with these weights and variances of a row: that of the basis with the largest
/// weight, since where no row is splines in another variable go another way.
fn without_law(
    bases: &[Basis],
    models: &[Model],
    shares: &[[f64; 2]],
    context: &Context,
    mut speeds: Vec<f64>,
) -> (Vec<f64>, DVector<f64>, DMatrix<f64>) {
    speeds.sort_by(f64::total_cmp);
    speeds.dedup_by(|next, one| *next - *one < CLOSEST * *next);
    let of_basis = |basis: usize| {
        let all = models.iter().zip(shares);
        all.filter(move |(model, [weight, _])| model.basis == basis && *weight > 0.0)
    };
    let weight_of = |basis: usize| of_basis(basis).map(|(_, [weight, _])| weight).sum::<f64>();
    let best =
        (0..bases.len()).max_by(|one, other| weight_of(*one).total_cmp(&weight_of(*other))).unwrap_or(0);
    let splines = bases[best].values(&speeds);
    let parts = of_basis(best).map(|(model, [weight, variance])| {
        // The deviation may be as large as the range of the readings.
        let penalty = variance / (model.unit * context.span);
        // Of exact rows what rounding leaves of the other directions is no knowledge.
        let known = model.known.map(|e| if e < ROUNDED { 0.0 } else { e });
        let inverse = known.zip_map(&model.penalty, |e, p| 1.0 / (e + penalty * p));
        let product = model.product.zip_map(&known, |product, e| if e > 0.0 { product } else { 0.0 });
        let values = &splines * model.back;
        let covariance = &values * Square::from_diagonal(&(inverse * *variance)) * values.transpose();
        (weight / weight_of(best), values * inverse.component_mul(&product), covariance)
    });
    let parts: Vec<_> = parts.collect();
    let count = speeds.len();
    let mut friction = DVector::zeros(count);
    let mut covariance = DMatrix::identity(count, count) * (FLOOR * FLOOR * context.span);
    parts.iter().for_each(|(share, mean, _)| friction.axpy(*share, mean, 1.0));
    for (share, mean, of_mean) in &parts {
        let off = mean - &friction;
        covariance += of_mean * *share;
        covariance.ger(*share, &off, &off, 1.0);
    }
    (speeds, friction, covariance)
}

#[cfg(test)]
mod tests;

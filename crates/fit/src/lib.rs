//! Least-squares fits of friction laws to measured friction.
//!
//! Every law is
//!
//! ```text
//! F(u) = F_k + (F_o - F_k) g(u / v_s) + B u
//! ```
//!
//! with one of the shapes g of [`Shape`], with or without the viscous part, and with or without a drop: readings at
//! rest are F_o without a drop, else the friction at rest of its own. The parameters are those of least squares, by
//! the algorithm of Levenberg and Marquardt as in MINPACK (More, LNM 630, 1978), from the best of some starts. Laws
//! are compared by Akaike's criterion for small samples (Hurvich and Tsai, Biometrika 76, 1989).
//!
//! Errors are those to first order: the inverse of the matrix of normal equations, times the variance of the
//! residuals. Where the readings have standard errors, the variance is at least 1 in units of these; where they have
//! none, it comes from the residuals, and two standard errors are made those of 95 % by Student's distribution.
//!
//! Which law it is, is not known either: to the covariance of each law is added what the others say of its slope, by Akaike's
//! weights (after Buckland, Burnham and Augustin, Biometrics 53, 1997), along the moves of the parameters that make it. So
//! errors are larger than those of the law alone where others are about as good. Slopes, because they are what makes a
//! machine vibrate.

mod model;
mod reduction;

pub use model::{Form, Shape};
pub use reduction::{Reduced, Rows, breakaway, reduce};

use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use model::FALL;
use nalgebra::{DMatrix, DVector, Dyn, Owned};

/// A reading of friction in slip.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Slip speed, at least 0.
    pub speed: f64,
    /// Friction.
    pub friction: f64,
    /// Standard error; NaN where unknown. Either all readings have one, greater than 0, or none.
    pub error: f64,
}

/// A law fitted to readings.
#[derive(Clone, Debug)]
pub struct Fit {
    /// The law.
    pub form: Form,
    /// The values of its parameters, in the order of [`Form::names`].
    pub values: Vec<f64>,
    /// Their covariance.
    pub covariance: DMatrix<f64>,
    /// The friction at rest with its standard error; `None` without a drop.
    pub at_rest: Option<[f64; 2]>,
    /// Akaike's criterion for small samples; only differences between fits of the same readings mean anything.
    pub aicc: f64,
    /// Root mean square of the residuals in slip, in units of the friction.
    pub residual: f64,
    /// The sum of the squares of the residuals in units of the standard errors, divided by the degrees of freedom;
    /// `None` for readings without standard errors, and on a curve.
    pub reduced: Option<f64>,
    /// Readings less friction, in the order of the readings in slip.
    pub residuals: Vec<f64>,
    /// How much more the residuals follow smooth curves than by chance, in standard deviations: far above 0 where the law does
    /// not follow the readings.
    pub lack: f64,
}

/// Reason why there is no fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFit {
    /// There are too few readings at different slip speeds: fewer than so many in slip.
    TooFew(usize),
    /// Friction is negative at every slip speed.
    Negative,
    /// No law follows from the readings.
    None,
}

/// Number of slip speeds over which friction falls that are tried as starts, over the range of the readings.
const STARTS: i32 = 12;
/// Least drop as slip begins, in units of its standard error: that of the friction at rest is no parameter of the fit,
/// so a smaller one would be taken for sure.
const SURE_DROP: f64 = 4.0;
/// Least part of a parameter's effect that no others have, of its whole effect on the readings: below it, their
/// covariance has no digits.
const LEAST_PIVOT: f64 = 1e-6;
/// Relative step of slopes.
const STEP: f64 = 1e-3;
/// Number of slip speeds at which laws are compared.
const COMPARED: i32 = 40;
/// Number of waves of smooth curves that residuals may follow.
const WAVES: usize = 6;
/// Root mean square of residuals in units of the largest friction up to which readings are exact: the search ends there.
const EXACT: f64 = 1e-7;
/// Residuals of exact readings, in units of the rounding of the largest one.
const ROUNDING: f64 = 16.0;
/// Readings from which that friction does not fall is a law beside those that do, in units of those for one of these: of fewer
/// Akaike's correction for small samples is larger than what they say.
const FEWEST_THAT_TELL: usize = 2;
/// Least number of readings at rest whose own scatter is their error.
const FEWEST_AT_REST: usize = 3;

/// Fits every law to the readings, and sorts them by Akaike's criterion, the best one first. Readings in slip whose errors
/// are correlated have the `root` of their covariance, a lower triangle.
///
/// # Errors
/// [`NoFit`].
pub fn fits(
    in_slip: &[Reading],
    at_rest: &[Reading],
    root: Option<&DMatrix<f64>>,
) -> Result<Vec<Fit>, NoFit> {
    let mut speeds: Vec<f64> = in_slip.iter().map(|reading| reading.speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    // A law that falls, without more; readings at rest are one for it.
    let falls = Form { shape: Shape::Exponential, viscous: false, drop: false };
    let fewest = fewest(falls, is_known(in_slip, at_rest)) - usize::from(!at_rest.is_empty());
    if speeds.len() < 3 {
        return Err(NoFit::TooFew(fewest));
    }
    let fitted = |falls: bool| {
        let forms =
            Form::all().filter(move |form| form.falls() == falls && (!form.drop || !at_rest.is_empty()));
        forms.filter_map(|form| fit(form, in_slip, at_rest, root))
    };
    let mut fits: Vec<Fit> = fitted(true).collect();
    // Few readings are no sign that friction does not fall, unless no law that falls is one of them.
    let tell = if fits.is_empty() { fewest } else { FEWEST_THAT_TELL * fewest };
    if in_slip.len() >= tell {
        fits.extend(fitted(false));
    }
    fits.sort_by(|one, other| one.aicc.total_cmp(&other.aicc));
    if fits.is_empty() {
        let is_negative = in_slip.iter().all(|reading| reading.friction < 0.0);
        return Err(match in_slip.len() < fewest {
            _ if is_negative => NoFit::Negative,
            true => NoFit::TooFew(fewest),
            false => NoFit::None,
        });
    }
    let (slowest, fastest) =
        (speeds.iter().copied().find(|speed| *speed > 0.0).unwrap_or(0.0), speeds[speeds.len() - 1]);
    let more: Vec<DMatrix<f64>> =
        fits.iter().map(|fit| fit.by_other_laws(&fits, [slowest, fastest])).collect();
    fits.iter_mut().zip(more).for_each(|(fit, more)| fit.covariance += more);
    Ok(fits)
}

/// (JᵀJ)⁻¹, symmetric and positive definite, from the triangular factor of the Jacobian with columns of unit length:
/// JᵀJ itself would square the condition, and its inverse could have negative variances. `None` where the readings do
/// not tell the parameters apart.
fn inverse_of_normal_equations(mut jacobian: DMatrix<f64>) -> Option<DMatrix<f64>> {
    let lengths: Vec<f64> = jacobian.column_iter().map(|column| column.norm()).collect();
    for (mut column, length) in jacobian.column_iter_mut().zip(&lengths) {
        column.unscale_mut(*length);
    }
    let factor = jacobian.qr().r();
    let count = lengths.len();
    if factor.diagonal().iter().any(|pivot| !(pivot.abs() >= LEAST_PIVOT)) {
        return None;
    }
    let inverse = factor.solve_upper_triangular(&DMatrix::identity(count, count))?;
    // Each pair once, so that the matrix is symmetric to the last bit.
    let entry = |i: usize, j: usize| inverse.row(i).dot(&inverse.row(j)) / (lengths[i] * lengths[j]);
    Some(DMatrix::from_fn(count, count, |i, j| entry(i.min(j), i.max(j))))
}

/// Whether all readings have standard errors.
fn is_known(in_slip: &[Reading], at_rest: &[Reading]) -> bool {
    in_slip.iter().chain(at_rest).all(|reading| reading.error > 0.0)
}

/// The least number of readings for which Akaike's criterion for small samples of a law is a number; without errors that
/// are `known` the variance is a parameter, too.
fn fewest(form: Form, known: bool) -> usize {
    form.names().len() + 2 + usize::from(!known)
}

/// Fits one law; `None` where it has too many parameters for the readings, or none that are legal.
pub fn fit(form: Form, in_slip: &[Reading], at_rest: &[Reading], root: Option<&DMatrix<f64>>) -> Option<Fit> {
    let known = is_known(in_slip, at_rest);
    let mut readings: Vec<Reading> = in_slip.to_vec();
    // Breakaway scatters more than slip does: readings at rest are one, with its own error.
    let of_rest: Vec<[f64; 2]> = at_rest.iter().map(|reading| [reading.friction, reading.error]).collect();
    let own = known || at_rest.len() >= FEWEST_AT_REST;
    let rest = mean(&of_rest).map(|[friction, error]| {
        let error = if own { error } else { f64::NAN };
        Reading { speed: 0.0, friction, error }
    });
    if !form.drop {
        readings.extend(rest);
    }
    let (n, p) = (readings.len(), form.names().len());
    if n < fewest(form, known) {
        return None;
    }
    let each = match known {
        true => readings.iter().map(|reading| 1.0 / reading.error).collect(),
        false => vec![1.0; n],
    };
    let mut weights = Weights { each, root };
    let mut problem = Problem::start(form, &readings, weights.clone())?.minimised()?;
    if let (false, Some(rest), false) = (known, rest, form.drop)
        && rest.error > 0.0
    {
        // The weight of the reading at rest follows from the scatter in slip.
        let squares = problem.residuals.iter().take(in_slip.len()).map(|residual| residual * residual);
        let scatter = (squares.sum::<f64>() / (in_slip.len() - p.min(in_slip.len() - 1)) as f64).sqrt();
        if let Some(last) = weights.each.last_mut() {
            *last = scatter / rest.error;
        }
        problem = Problem::start(form, &readings, weights)?.minimised()?;
    }
    let squares: f64 = problem.residuals.norm_squared();
    let freedom = (n - p) as f64;
    let inverse = inverse_of_normal_equations(problem.natural_jacobian())?;

    let reduced = squares / freedom;
    let variance = if known { reduced.max(1.0) } else { reduced * widening(freedom) };
    let values = form.values(&problem.parameters);
    let covariance = inverse * variance;
    let legal = form.is_legal(&values) && covariance.iter().all(|value| value.is_finite());
    // The error of a drop is that of the friction at rest, which no parameter of the law has.
    let at_rest = match form.drop {
        false => None,
        true => {
            let rest = rest?;
            let spread = if rest.error > 0.0 { rest.error } else { (squares / freedom).sqrt() };
            Some([rest.friction, spread])
        }
    };
    let drops = at_rest.is_none_or(|[level, error]| {
        let onset = covariance[(0, 0)];
        level - form.friction(&values, 0.0) > SURE_DROP * (error * error + onset).sqrt()
    });
    let parameters = (p + usize::from(at_rest.is_some())) as f64;
    let count = (n + usize::from(at_rest.is_some())) as f64;
    // Exact readings have what rounding leaves.
    let largest = readings.iter().map(|reading| reading.friction.abs()).fold(0.0, f64::max);
    let least = (ROUNDING * f64::EPSILON * largest).powi(2);
    let likelihood = if known { squares } else { count * (squares / count).max(least).ln() };
    let k = parameters + if known { 0.0 } else { 1.0 };
    let correction = 2.0 * k * (k + 1.0) / (count - k - 1.0);
    let aicc = likelihood + 2.0 * k + correction;
    let residuals: Vec<f64> =
        in_slip.iter().map(|reading| reading.friction - form.friction(&values, reading.speed)).collect();
    let residual = (residuals.iter().map(|r| r * r).sum::<f64>() / residuals.len() as f64).sqrt();
    let lack = if residual > EXACT * largest { problem.lack(known) } else { 0.0 };
    (legal && drops && aicc.is_finite()).then(|| Fit {
        form,
        values,
        covariance,
        at_rest,
        aicc,
        residual,
        // Neighbours on a curve are hardly more than its few degrees of freedom.
        reduced: (known && root.is_none()).then_some(reduced),
        lack,
        residuals,
    })
}

impl Fit {
    /// The friction at a slip speed.
    pub fn friction(&self, speed: f64) -> f64 {
        self.form.friction(&self.values, speed)
    }

    /// The standard error of the friction at a slip speed.
    pub fn error(&self, speed: f64) -> f64 {
        let gradient = DVector::from_vec(self.form.gradient(&self.values, speed));
        gradient.dot(&(&self.covariance * &gradient)).max(0.0).sqrt()
    }

    /// The slope of the friction at a slip speed, and its derivatives by the parameters.
    fn slope(&self, speed: f64) -> (f64, DVector<f64>) {
        let ends = [speed * (1.0 - STEP), speed * (1.0 + STEP)];
        let width = ends[1] - ends[0];
        let [before, after] = ends.map(|speed| DVector::from_vec(self.form.gradient(&self.values, speed)));
        ((self.friction(ends[1]) - self.friction(ends[0])) / width, (after - before) / width)
    }

    /// The covariance that comes from what other laws say of the slope, by the logarithm of the speed, between two slip speeds:
    /// with Akaike's weight of each law the move of the parameters that is the likeliest one along the difference of the slopes,
    /// and as large as that difference.
    fn by_other_laws(&self, fits: &[Fit], [slowest, fastest]: [f64; 2]) -> DMatrix<f64> {
        let weights: Vec<f64> = fits.iter().map(|fit| (0.5 * (fits[0].aicc - fit.aicc)).exp()).collect();
        let total: f64 = weights.iter().sum();
        let speeds: Vec<f64> = (0..COMPARED)
            .map(|i| slowest * (fastest / slowest).powf(f64::from(i) / f64::from(COMPARED - 1)))
            .collect();
        let own: Vec<(f64, DVector<f64>)> = speeds.iter().map(|speed| self.slope(*speed)).collect();
        let count = self.values.len();
        let mut more = DMatrix::zeros(count, count);
        for (fit, weight) in fits.iter().zip(&weights).filter(|(fit, _)| fit.form != self.form) {
            let off: Vec<f64> =
                speeds.iter().zip(&own).map(|(u, (slope, _))| u * (fit.slope(*u).0 - slope)).collect();
            let mut along = DVector::zeros(count);
            for ((u, (_, by)), off) in speeds.iter().zip(&own).zip(&off) {
                along.axpy(u * off, by, 1.0);
            }
            let step = &self.covariance * along;
            let made: f64 = speeds.iter().zip(&own).map(|(u, (_, by))| (u * by.dot(&step)).powi(2)).sum();
            let scale = weight / total * off.iter().map(|off| off * off).sum::<f64>() / made;
            if scale.is_finite() {
                let step = step * scale.sqrt();
                more.ger(1.0, &step, &step, 1.0);
            }
        }
        more
    }

    /// The standard errors of the parameters.
    pub fn errors(&self) -> Vec<f64> {
        self.covariance.diagonal().iter().map(|variance| variance.sqrt()).collect()
    }

    /// The correlation of two parameters.
    pub fn correlation(&self, one: usize, other: usize) -> f64 {
        let errors = self.errors();
        self.covariance[(one, other)] / (errors[one] * errors[other])
    }
}

/// The mean of readings with their standard errors, and its own: weighted by those that are known, so that exact readings have
/// all weight; where they are NaN by the scatter, which a single reading has not. `None` of no reading.
pub fn mean(readings: &[[f64; 2]]) -> Option<[f64; 2]> {
    let (reference, count) = (readings.first()?[0], readings.len() as f64);
    let are_exact = readings.iter().any(|[_, error]| *error == 0.0);
    let weight = |error: f64| match are_exact {
        true => f64::from(error == 0.0),
        false if error.is_nan() => 1.0,
        false => error.powi(-2),
    };
    let total: f64 = readings.iter().map(|[_, error]| weight(*error)).sum();
    // From the first one, so that the mean of equal readings is that.
    let off: f64 = readings.iter().map(|[value, error]| weight(*error) * (value - reference)).sum();
    let mean = reference + off / total;
    let squares: f64 = readings.iter().map(|[value, _]| (value - mean).powi(2)).sum();
    let error = match readings[0][1] {
        _ if are_exact => 0.0,
        error if error.is_nan() => (squares / (count - 1.0) / count).sqrt(),
        _ => total.powf(-0.5),
    };
    Some([mean, error])
}

/// The square of the 97.5 % quantile of Student's distribution, in units of that of the normal one: the expansion of
/// Cornish and Fisher, with an error below a per cent from three degrees of freedom.
pub fn widening(freedom: f64) -> f64 {
    let z: f64 = 1.959_963_984_540_054;
    let z2 = z * z;
    let first = (z2 + 1.0) / 4.0;
    let second = ((5.0 * z2 + 16.0) * z2 + 3.0) / 96.0;
    let third = (((3.0 * z2 + 19.0) * z2 + 17.0) * z2 - 15.0) / 384.0;
    (1.0 + first / freedom + second / freedom.powi(2) + third / freedom.powi(3)).powi(2)
}

/// What makes the errors of readings independent, and 1.
#[derive(Clone)]
struct Weights<'a> {
    each: Vec<f64>,
    /// The root of the covariance of the first ones, in place of their weights.
    root: Option<&'a DMatrix<f64>>,
}

impl Weights<'_> {
    /// Columns of numbers, one for each reading, in units of their errors.
    fn weighted(&self, mut columns: DMatrix<f64>) -> DMatrix<f64> {
        let joint = self.root.map_or(0, DMatrix::nrows);
        if let Some(root) = self.root {
            // A root of a covariance has no 0 in its diagonal.
            root.solve_lower_triangular_mut(&mut columns.rows_mut(0, joint));
        }
        for (mut row, weight) in columns.row_iter_mut().zip(&self.each).skip(joint) {
            row.scale_mut(*weight);
        }
        columns
    }
}

/// The least-squares problem of a law, in the parameters of [`Point`].
struct Problem<'a> {
    form: Form,
    readings: &'a [Reading],
    weights: Weights<'a>,
    parameters: DVector<f64>,
    residuals: DVector<f64>,
}

impl<'a> Problem<'a> {
    /// The best of some starts: for a given fall of friction the law is linear in all else.
    fn start(form: Form, readings: &'a [Reading], weights: Weights<'a>) -> Option<Self> {
        let fastest = readings.iter().map(|reading| reading.speed).fold(0.0, f64::max);
        let slowest =
            readings.iter().map(|reading| reading.speed).filter(|speed| *speed > 0.0).fold(fastest, f64::min);
        let range = (fastest / (0.3 * slowest)).ln();
        let log = |i: i32| (0.3 * slowest).ln() + range * f64::from(i) / f64::from(STARTS - 1);
        let count = if form.shape == Shape::None { 1 } else { STARTS };
        let names = form.names();
        let linear: Vec<usize> =
            (0..names.len()).filter(|at| !["v_s", "delta"].contains(&names[*at])).collect();
        let starts = (0..count).filter_map(|i| {
            let mut point = form.with_fall(log(i));
            let values = form.values(&point);
            let gradients: Vec<Vec<f64>> =
                readings.iter().map(|reading| form.gradient(&values, reading.speed)).collect();
            let columns = DMatrix::from_fn(readings.len(), linear.len() + 1, |row, column| {
                linear.get(column).map_or(readings[row].friction, |at| gradients[row][*at])
            });
            let mut matrix = weights.weighted(columns);
            let target = matrix.column(linear.len()).into_owned();
            matrix = matrix.remove_column(linear.len());
            let solved = matrix.clone().svd(true, true).solve(&target, 1e-12).ok()?;
            let squares = (matrix * &solved - target).norm_squared();
            linear.iter().zip(&solved).for_each(|(at, value)| point[*at] = *value);
            Some((squares, point))
        });
        let best = starts.min_by(|one, other| one.0.total_cmp(&other.0))?.1;
        let residuals = DVector::zeros(readings.len());
        let mut problem = Self { form, readings, weights, parameters: best.clone(), residuals };
        problem.set_params(&best);
        Some(problem)
    }

    /// The problem at its minimum; `None` where it was not reached.
    fn minimised(self) -> Option<Self> {
        let (problem, report) = LevenbergMarquardt::new().with_patience(200).minimize(self);
        (report.termination.was_successful() && problem.residuals.iter().all(|r| r.is_finite()))
            .then_some(problem)
    }

    /// How much more the residuals follow smooth curves than by chance: the sum of squares that the first waves over the order
    /// of the speeds take, beyond what the parameters do, in units of what is left. It has Fisher's distribution, and is told as
    /// a normal deviate (Paulson, Ann. Math. Stat. 13, 1942).
    fn lack(&self, known: bool) -> f64 {
        let jacobian = self.natural_jacobian();
        let (n, p) = jacobian.shape();
        let waves = WAVES.min((n - p) / 3);
        if waves == 0 {
            return 0.0;
        }
        let mut speeds: Vec<f64> = self.readings.iter().map(|reading| reading.speed).collect();
        speeds.sort_by(f64::total_cmp);
        let place = |speed: f64| {
            let [from, to] =
                [false, true].map(|with| speeds.partition_point(|it| *it < speed || with && *it == speed));
            0.5 * (from + to) as f64 / n as f64
        };
        let places: Vec<f64> =
            self.readings.iter().map(|reading| std::f64::consts::PI * place(reading.speed)).collect();
        let waves_at = DMatrix::from_fn(n, waves, |row, wave| ((wave + 1) as f64 * places[row]).cos());
        let mut columns = jacobian.resize_horizontally(p + waves, 0.0);
        columns.columns_mut(p, waves).copy_from(&self.weights.weighted(waves_at));
        for mut column in columns.column_iter_mut() {
            let length = column.norm();
            column.unscale_mut(length);
        }
        let taken = columns.qr().q().columns(p, waves).tr_mul(&self.residuals).norm_squared();
        let freedom = (n - p - waves) as f64;
        let left = (self.residuals.norm_squared() - taken) / freedom;
        let waves = waves as f64;
        let ratio = taken / waves / if known { left.max(1.0) } else { left };
        let [of_taken, of_left] =
            [waves, if known { f64::INFINITY } else { freedom }].map(|freedom| 2.0 / (9.0 * freedom));
        let root = ratio.cbrt();
        ((1.0 - of_left) * root - (1.0 - of_taken)) / (of_taken + root * root * of_left).sqrt()
    }

    /// The derivatives of the weighted residuals by the parameters of the law, in natural units.
    fn natural_jacobian(&self) -> DMatrix<f64> {
        let values = self.form.values(&self.parameters);
        let rows = self.readings.iter().flat_map(|reading| self.form.gradient(&values, reading.speed));
        self.weights.weighted(DMatrix::from_row_iterator(self.readings.len(), values.len(), rows))
    }
}

impl LeastSquaresProblem<f64, Dyn, Dyn> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Dyn>;
    type ParameterStorage = Owned<f64, Dyn>;

    fn set_params(&mut self, parameters: &DVector<f64>) {
        self.parameters = parameters.clone();
        let values = self.form.values(parameters);
        let miss =
            self.readings.iter().map(|reading| self.form.friction(&values, reading.speed) - reading.friction);
        let miss = DMatrix::from_iterator(self.readings.len(), 1, miss);
        self.residuals = self.weights.weighted(miss).column(0).into_owned();
    }

    fn params(&self) -> DVector<f64> {
        self.parameters.clone()
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.residuals.clone())
    }

    fn jacobian(&self) -> Option<DMatrix<f64>> {
        let mut jacobian = self.natural_jacobian();
        if self.form.shape != Shape::None {
            // The fall is a logarithm.
            let fall = self.parameters[FALL].exp();
            jacobian.column_mut(FALL).scale_mut(fall);
        }
        Some(jacobian)
    }
}

#[cfg(test)]
mod tests;

//! A measured law: phi(u) at increasing slip speeds, interpolated by shape-preserving cubics.
//!
//! The slopes at the data are those of Fritsch and Butland (SIAM J. Sci. Stat. Comput. 5, 1984): phi is
//! monotone between neighbouring data, and phi' and D are continuous. Beyond the last datum the law is
//! unknown: phi is NaN there, orbits that reach it fail, and tests that need it are undecided.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::{NO_REST, REST_AT_PEAK, Range, mean};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};
use slipmap_numbers::random::Random;

/// Median of the absolute values of normal numbers.
const MEDIAN_SIZE: f64 = 0.674_489_750_196_081_7;
/// Tolerance of phi(0) = 1: measured values are rounded.
const STATIC_SLACK: f64 = 1e-9;

/// Reason why a table is not a friction law.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{problem}\n  help: {remedy}")]
pub struct TableError {
    /// The datum concerned, from 0; `None` for the whole table.
    pub row: Option<usize>,
    /// What is wrong.
    pub problem: String,
    /// The remedy.
    pub remedy: String,
}

fn error(row: Option<usize>, problem: String, remedy: &str) -> Result<Table, TableError> {
    Err(TableError { row, problem, remedy: remedy.to_owned() })
}

/// A law given by data. Clones share it.
#[derive(Clone, Debug)]
pub struct Table(Arc<Cubics>);

impl PartialEq for Table {
    fn eq(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0) || self.0 == other.0
    }
}

#[derive(Clone, Debug, PartialEq)]
struct Cubics {
    /// The source of the data.
    origin: String,
    /// Friction at rest.
    static_level: f64,
    /// Whether friction in slip may begin below the friction at rest.
    may_drop: bool,
    /// Friction as given.
    friction: Vec<f64>,
    /// Slip speeds, from 0, and friction in units of the static friction.
    u: Vec<f64>,
    phi: Vec<f64>,
    /// phi' at the data.
    slope: Vec<f64>,
    /// Standard errors of the friction, in the units of `friction`.
    errors: Option<Vec<f64>>,
    /// Where the errors are correlated, the lower triangle whose product with its transpose is their covariance.
    root: Option<Vec<Vec<f64>>>,
    /// Whether answers have the error of the curve between the rows, see [`Table::with_error_of_curve`].
    curve_errs: bool,
    source: Source,
}

/// What is known of the file of measured data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Source {
    /// The line of each datum; 0 for a mean of many, empty for data that are not from a file.
    pub lines: Vec<usize>,
    /// Number of readings of which the data are means; the number of data where none are.
    pub readings: usize,
    /// What has been understood of the file, in one line; `None` if it is as the documentation has it.
    pub told: Option<String>,
    /// Whether the friction is a force.
    pub forces: bool,
    /// Whether no row is at rest: the first datum is on the line through the next two, and moves with them.
    pub no_rest: bool,
    /// Whether the file names the column of the standard errors, which otherwise is the third one.
    pub named_errors: bool,
}

/// What a definition says of a table beside its data.
#[derive(Serialize, Deserialize)]
struct Known {
    source: Source,
    curve_errs: bool,
}

/// phi on one piece as phi_0 + t (s_0 + t (c_2 + t c_3)), t = u - u_0: these coefficients.
type Cubic<T> = [T; 4];

/// -phi' at t.
fn weakening([_, slope, c2, c3]: Cubic<f64>, t: f64) -> f64 {
    -(slope + t * (2.0 * c2 + t * (3.0 * c3)))
}

/// -phi' on one piece, in t = u - ends[0].
pub(super) struct Parabola {
    /// Slip speeds at which the parabola begins and ends.
    pub(super) ends: [f64; 2],
    /// Coefficients of 1, t and t^2.
    pub(super) coefficients: [Interval; 3],
}

impl Parabola {
    /// The slip speed of its extreme, up to rounding.
    pub(super) fn extreme(&self) -> Option<f64> {
        let [_, slope, bend] = self.coefficients.map(|x| 0.5 * (x.lo + x.hi));
        let at = self.ends[0] - 0.5 * slope / bend;
        at.is_finite().then_some(at)
    }
}

impl Table {
    /// Makes a law from measured pairs (u, friction); phi is the friction divided by `static_level` > 0.
    /// `origin` is the name of the data in messages.
    ///
    /// # Errors
    /// [`TableError`].
    pub fn new(origin: &str, data: &[(f64, f64)], static_level: f64) -> Result<Self, TableError> {
        Self::of_data(origin, data, static_level, false)
    }

    /// As [`Table::new`] of friction in slip, with the friction `static_level` > 0 at rest: at least the first
    /// datum. Where that is less, friction drops as slip begins, see [`super::Curve::drop`].
    ///
    /// # Errors
    /// [`TableError`].
    pub fn with_static(origin: &str, data: &[(f64, f64)], static_level: f64) -> Result<Self, TableError> {
        Self::of_data(origin, data, static_level, true)
    }

    fn of_data(
        origin: &str,
        data: &[(f64, f64)],
        static_level: f64,
        may_drop: bool,
    ) -> Result<Self, TableError> {
        if data.len() < 3 {
            let rows = if data.len() == 1 { "is only one row" } else { "are only two rows" };
            return error(None, format!("there {rows}"), "give at least three");
        }
        for (row, &(u, phi)) in data.iter().enumerate() {
            if !(u.is_finite() && phi.is_finite()) {
                return error(Some(row), "a datum is not finite".into(), "correct or remove this row");
            }
            if row > 0 && u == data[row - 1].0 {
                let problem = format!("the slip speed {u} is that of the row before");
                let remedy = match u {
                    0.0 => "leave the friction of slip there, and give that at rest as static",
                    _ => "average the rows of one slip speed into one, with the standard error of their mean",
                };
                return error(Some(row), problem, remedy);
            }
            if row > 0 && u < data[row - 1].0 {
                let problem = format!("the slip speed {u} follows {}", data[row - 1].0);
                return error(Some(row), problem, "sort the rows by slip speed, the first column");
            }
        }
        if data[0].0 != 0.0 {
            let problem = format!("the first slip speed is {}, not 0", data[0].0);
            return error(Some(0), problem, "begin with the static friction, at slip speed 0");
        }
        if data[0].1 == 0.0 {
            return error(Some(0), NO_REST.to_owned(), REST_AT_PEAK);
        }
        let phi: Vec<f64> = data.iter().map(|(_, phi)| phi / static_level).collect();
        if may_drop && !(phi[0] > 0.0 && phi[0] <= 1.0 + STATIC_SLACK) {
            let problem =
                format!("friction in slip begins at {}, and at rest it is {static_level}", data[0].1);
            let remedy = "friction in slip begins above 0 and at most at the friction at rest: raise static";
            return error(Some(0), problem, remedy);
        }
        if !may_drop && !((phi[0] - 1.0).abs() <= STATIC_SLACK) {
            let problem = format!("phi(0) is {}, not 1", phi[0]);
            let remedy = format!(
                "write the friction at rest with the key static: static = {} if friction falls from there, more if it \
                 drops as slip begins",
                data[0].1
            );
            return error(Some(0), problem, &remedy);
        }
        let u: Vec<f64> = data.iter().map(|(u, _)| *u).collect();
        let friction = data.iter().map(|(_, friction)| *friction).collect();
        let series: Vec<Jet<f64, 1>> = phi.iter().map(|&phi| Jet::of(phi)).collect();
        let slope = slopes(&u, &series).into_iter().map(|slope| slope.0[0]).collect();
        Ok(Self(Arc::new(Cubics {
            origin: origin.to_owned(),
            static_level,
            may_drop: may_drop && phi[0] < 1.0 - STATIC_SLACK,
            friction,
            u,
            phi,
            slope,
            errors: None,
            root: None,
            curve_errs: false,
            source: Source { readings: data.len(), ..Source::default() },
        })))
    }

    /// The same table with what is known of its file.
    pub fn with_source(&self, source: Source) -> Self {
        Self(Arc::new(Cubics { source, ..Cubics::clone(&self.0) }))
    }

    /// What is known beside the data, as text; `None` where nothing is.
    pub(super) fn known(&self) -> Option<String> {
        let Cubics { u, source, curve_errs, .. } = &*self.0;
        let nothing = Source { readings: u.len(), ..Source::default() };
        let known = Known { source: source.clone(), curve_errs: *curve_errs };
        (known.curve_errs || known.source != nothing).then(|| serde_json::to_string(&known).ok()).flatten()
    }

    /// The same table with what [`Table::known`] told; `None` if the text is none.
    pub(super) fn with_known(&self, text: &str) -> Option<Self> {
        let Known { source, curve_errs } = serde_json::from_str(text).ok()?;
        Some(Self(Arc::new(Cubics { source, curve_errs, ..Cubics::clone(&self.0) })))
    }

    /// What is known of its file.
    pub fn source(&self) -> &Source {
        &self.0.source
    }

    /// The same table with the standard error of each friction value, in the units of the friction.
    ///
    /// # Errors
    /// [`TableError`] unless there is one finite and nonnegative error for each datum.
    pub fn with_standard_errors(&self, errors: &[f64]) -> Result<Self, TableError> {
        if errors.len() != self.0.u.len() {
            let problem = format!("there are {} data and {} standard errors", self.0.u.len(), errors.len());
            return error(None, problem, "give one for each datum");
        }
        if let Some(row) = errors.iter().position(|error| !(*error >= 0.0 && error.is_finite())) {
            let problem = format!("the standard error {} is not a valid error bar", errors[row]);
            return error(
                Some(row),
                problem,
                "write a finite number that is at least 0, in the units of the friction",
            );
        }
        let errors = Some(errors.to_vec());
        Ok(Self(Arc::new(Cubics { errors, root: None, ..Cubics::clone(&self.0) })))
    }

    /// The same table with correlated errors, as the rows of a lower triangle whose product with its transpose is their
    /// covariance: row i has i + 1 numbers.
    ///
    /// # Errors
    /// [`TableError`] unless there is one such row of finite numbers for each datum.
    pub fn with_root_of_covariance(&self, root: Vec<Vec<f64>>) -> Result<Self, TableError> {
        if let Some(row) = (0..root.len()).find(|row| root[*row].len() != row + 1) {
            return error(Some(row), "its errors are no row of a triangle".into(), "write one number more");
        }
        let errors: Vec<f64> =
            root.iter().map(|row| row.iter().map(|part| part * part).sum::<f64>().sqrt()).collect();
        let Self(table) = self.with_standard_errors(&errors)?;
        Ok(Self(Arc::new(Cubics { root: Some(root), ..Cubics::clone(&table) })))
    }

    /// Where the errors are correlated, the root of their covariance, see [`Table::with_root_of_covariance`].
    pub fn root_of_covariance(&self) -> Option<&[Vec<f64>]> {
        self.0.root.as_deref()
    }

    /// The variance of a sum of the data, each times a number of `by`; 0 without errors.
    pub fn variance_of_sum(&self, by: &[f64]) -> f64 {
        let squares = |parts: &mut dyn Iterator<Item = f64>| parts.map(|part| part * part).sum();
        match (&self.0.root, &self.0.errors) {
            (Some(root), _) => {
                squares(&mut (0..root.len()).map(|j| (j..root.len()).map(|k| by[k] * root[k][j]).sum()))
            }
            (None, Some(errors)) => squares(&mut by.iter().zip(errors).map(|(by, error)| by * error)),
            (None, None) => 0.0,
        }
    }

    /// How data move whose errors are drawn from `normal`, from the datum `first` on.
    fn moves(&self, data: std::ops::Range<usize>, mut normal: impl FnMut() -> f64) -> Vec<f64> {
        let Cubics { errors, root, .. } = &*self.0;
        if let Some(root) = root {
            let drawn: Vec<f64> = (0..data.end).map(|_| normal()).collect();
            return data.map(|k| root[k].iter().zip(&drawn).map(|(part, z)| part * z).sum()).collect();
        }
        errors.iter().flat_map(|errors| &errors[data.clone()]).map(|error| error * normal()).collect()
    }

    /// The table of another measurement: each friction value moved by its standard error times a number of `normal`. The
    /// friction at rest moves with the first datum where friction does not drop.
    ///
    /// # Errors
    /// [`TableError`] if that is no law.
    pub fn drawn(&self, mut normal: impl FnMut() -> f64) -> Result<Self, TableError> {
        let mut moved = self.moves(0..self.0.u.len(), &mut normal);
        moved[0] = self.of_first(&moved);
        let data: Vec<(f64, f64)> =
            self.data().zip(moved).map(|((u, level), moved)| (u, level + moved)).collect();
        let rest = if self.0.may_drop { self.static_level().max(data[0].1) } else { data[0].1 };
        Self::of_data(self.origin(), &data, rest, self.0.may_drop)
    }

    /// The same law with its slip speeds and its friction in units of `speed` and `friction` > 0.
    ///
    /// # Errors
    /// [`TableError`] if two slip speeds become equal, or one overflows.
    pub fn in_units(&self, speed: f64, friction: f64) -> Result<Self, TableError> {
        let data: Vec<(f64, f64)> = self.data().map(|(u, level)| (u / speed, level / friction)).collect();
        let table = Self::of_data(self.origin(), &data, self.static_level() / friction, self.0.may_drop)?;
        let scaled = |errors: &Vec<f64>| errors.iter().map(|error| error / friction).collect();
        let Cubics { errors, root, curve_errs, source, .. } = &*self.0;
        let (errors, source) = (errors.as_ref().map(scaled), source.clone());
        let root = root.as_ref().map(|root| root.iter().map(scaled).collect());
        let curve_errs = *curve_errs;
        Ok(Self(Arc::new(Cubics { errors, root, curve_errs, source, ..Cubics::clone(&table.0) })))
    }

    /// Standard errors of the friction as given, one for each datum.
    #[must_use]
    pub fn standard_errors(&self) -> Option<&[f64]> {
        self.0.errors.as_deref()
    }

    /// Derivatives of the first datum by the first three: by itself, or by the two rows through which its line goes.
    #[must_use]
    pub fn first_by_data(&self) -> [f64; 3] {
        if !self.0.source.no_rest {
            return [1.0, 0.0, 0.0];
        }
        let share = self.0.u[1] / (self.0.u[2] - self.0.u[1]);
        [0.0, 1.0 + share, -share]
    }

    /// The change of the first datum where the data are moved by `moved`.
    fn of_first(&self, moved: &[f64]) -> f64 {
        self.first_by_data().iter().zip(moved).map(|(by, moved)| by * moved).sum()
    }

    /// Derivatives of -phi' at slip speed `u` with respect to the data next to it. Returns the index of the
    /// first of these data, and the derivatives with respect to its friction value, as given, and those of
    /// the next three data; zero for data that do not exist, and for a first one that moves with the next.
    #[must_use]
    pub fn weakening_by_data(&self, u: f64) -> (usize, [f64; 4]) {
        let Cubics { u: knots, phi, static_level, .. } = &*self.0;
        let i = self.piece_at(u);
        // The slopes at the ends of the piece follow from these data alone.
        let (first, last) = (i.saturating_sub(1), (i + 3).min(knots.len()));
        let derivative = |datum: usize| {
            let weight = |k: usize| if k == datum { 1.0 } else { 0.0 };
            let near: Vec<Jet<f64, 2>> = (first..last).map(|k| Jet::variable(phi[k], weight(k))).collect();
            let slope = slopes(&knots[first..last], &near);
            let [s0, s1] = [i, i + 1].map(|k| slope[k - first].0[1]);
            let h = knots[i + 1] - knots[i];
            let secant = (weight(i + 1) - weight(i)) / h;
            -hermite_slope((u - knots[i]) / h, secant, s0, s1) / static_level
        };
        let mut by = std::array::from_fn(|k| if first + k < last { derivative(first + k) } else { 0.0 });
        if first == 0 {
            let of_first = std::mem::take(&mut by[0]);
            by.iter_mut().zip(self.first_by_data()).for_each(|(by, part)| *by += of_first * part);
        }
        (first, by)
    }

    /// Standard error of -phi' at slip speed `u` with the unit of friction held fixed; `None` without standard
    /// errors of the data. See [`Table::standard_errors_of_data`].
    pub fn standard_error_of_weakening(&self, u: f64) -> Option<f64> {
        let mut by_data = vec![0.0; self.0.u.len()];
        let (first, by) = self.weakening_by_data(u);
        by_data[first..].iter_mut().zip(by).for_each(|(sum, by)| *sum = by);
        let [(of_data, _), _] = self.standard_errors_of_data(&[(u, 1.0)], &by_data)?;
        Some(of_data.hypot(self.error_of_slope(u)))
    }

    /// Standard errors of the sum of -phi' times a weight over `points`, pairs of slip speed and weight, by the errors
    /// of the data, each with its sampling error: with the unit of friction held fixed, and with the first datum as the
    /// unit; `None` without standard errors of the data. `by_data` are the derivatives of the sum by the data, with the
    /// unit held fixed.
    ///
    /// The slopes of the interpolant are not linear in the data: they vanish where the data turn, as nearly
    /// equal data do within their errors. So the variance is that of random data, with the variance to first
    /// order as control variate.
    pub fn standard_errors_of_data(&self, points: &[(f64, f64)], by_data: &[f64]) -> Option<[(f64, f64); 2]> {
        const DRAWS: u32 = 4096;
        let Cubics { u: knots, friction, static_level, source, .. } = &*self.0;
        let errors = self.0.errors.as_ref()?;
        if errors.iter().all(|error| *error == 0.0) {
            return Some([(0.0, 0.0); 2]);
        }
        // On each piece -phi' is linear in the secant and in the slopes at the ends.
        let mut by_secant = vec![0.0; knots.len()];
        let mut by_slope = vec![0.0; knots.len()];
        let (mut first, mut last) = (knots.len(), 0);
        for &(u, weight) in points {
            let i = self.piece_at(u);
            let x = (u - knots[i]) / (knots[i + 1] - knots[i]);
            by_secant[i] -= weight * hermite_slope(x, 1.0, 0.0, 0.0);
            by_slope[i] -= weight * hermite_slope(x, 0.0, 1.0, 0.0);
            by_slope[i + 1] -= weight * hermite_slope(x, 0.0, 0.0, 1.0);
            // The slopes at the ends of the piece follow from these data alone.
            (first, last) = (first.min(i.saturating_sub(1)), last.max((i + 3).min(knots.len())));
        }
        if source.no_rest {
            first = 0;
        }
        let knots = &knots[first..last];
        let sum = |friction: &[Jet<f64, 1>]| {
            let of_slopes = slopes(knots, friction).into_iter().zip(&by_slope[first..]);
            let secants = friction.windows(2).zip(knots.windows(2));
            let of_secants = secants.map(|(f, u)| (f[1].0[0] - f[0].0[0]) / (u[1] - u[0]));
            of_slopes.map(|(slope, by)| slope.0[0] * by).sum::<f64>()
                + of_secants.zip(&by_secant[first..]).map(|(secant, by)| secant * by).sum::<f64>()
        };
        let nominal: Vec<Jet<f64, 1>> = friction[first..last].iter().map(|&f| Jet::of(f)).collect();
        let nominal = sum(&nominal);
        let by_unit = -nominal / static_level / friction[0];
        let mut random = Random(16);
        let mut near = vec![Jet::of(0.0); last - first];
        // Sums of the excess over first order, of the squares x of the sum and y of that to first order, and of
        // x x, x y and y y.
        let mut sums = [[0.0; 6]; 2];
        // The first datum is the unit; correlated ones are drawn together.
        let from = if self.0.root.is_some() { 0 } else { first };
        for _ in 0..DRAWS {
            let own = (from > 0).then(|| errors[0] * random.normal());
            let all = self.moves(from..last, || random.normal());
            let mut of_unit = own.unwrap_or(all[0]);
            let mut moved = all[first - from..].to_vec();
            if first == 0 {
                of_unit = self.of_first(&moved);
                moved[0] = of_unit;
            }
            let mut linear = 0.0;
            for ((k, near), moved) in (first..last).zip(&mut near).zip(&moved) {
                *near = Jet::of(friction[k] + moved);
                linear += by_data[k] * moved;
            }
            let drawn = (sum(&near) - nominal) / static_level;
            for (sums, unit) in sums.iter_mut().zip([0.0, by_unit * of_unit]) {
                let (x, y) = ((drawn + unit).powi(2), (linear + unit).powi(2));
                sums.iter_mut()
                    .zip([drawn - linear, x, y, x * x, x * y, y * y])
                    .for_each(|(sum, x)| *sum += x);
            }
        }
        let with_unit = |unit: f64, sums: [f64; 6]| {
            let of_first = self.first_by_data().into_iter().chain(std::iter::repeat(0.0));
            let by: Vec<f64> =
                by_data.iter().zip(of_first).map(|(by, of_first)| by + unit * of_first).collect();
            let linear = self.variance_of_sum(&by);
            let [mean, x, y, xx, xy, yy] = sums.map(|sum| sum / f64::from(DRAWS));
            // The mean of y is known, so that of x moves with the one drawn, as the regression of x on y tells.
            let [of_x, of_both, of_y] = [xx - x * x, xy - x * y, yy - y * y];
            let slope = if of_y > 0.0 { of_both / of_y } else { 0.0 };
            let value = (x + slope * (linear - y) - mean * mean).max(0.0).sqrt();
            let of_variance = ((of_x - slope * of_both).max(0.0) / f64::from(DRAWS)).sqrt();
            (value, if of_variance > 0.0 { 0.5 * of_variance / value } else { 0.0 })
        };
        Some([with_unit(0.0, sums[0]), with_unit(by_unit, sums[1])])
    }

    /// The source of the data.
    #[must_use]
    pub fn origin(&self) -> &str {
        &self.0.origin
    }

    /// Friction at rest, by which the data are divided.
    pub fn static_level(&self) -> f64 {
        self.0.static_level
    }

    /// Whether friction in slip may begin below the friction at rest.
    pub fn may_drop(&self) -> bool {
        self.0.may_drop
    }

    /// The friction at rest less that in slip at u -> 0, in units of the friction at rest.
    pub(super) fn drop(&self) -> f64 {
        let drop = if self.0.may_drop { 1.0 - self.0.phi[0] } else { 0.0 };
        if drop.abs() <= STATIC_SLACK { 0.0 } else { drop }
    }

    /// The data as given: slip speed and friction.
    pub fn data(&self) -> impl Iterator<Item = (f64, f64)> {
        self.0.u.iter().copied().zip(self.0.friction.iter().copied())
    }

    /// The data as text, with their errors: those of each, or the rows of the root of the covariance.
    pub fn rows(&self) -> impl Iterator<Item = String> {
        let Cubics { errors, root, .. } = &*self.0;
        self.data().enumerate().map(move |(i, (u, friction))| {
            let parts =
                root.as_ref().map(|root| &root[i][..]).or(errors.as_ref().map(|errors| &errors[i..=i]));
            let parts: String = parts.unwrap_or_default().iter().map(|part| format!(",{part}")).collect();
            format!("{u},{friction}{parts}")
        })
    }

    /// Number of rows at which friction changes from rising to falling, or from falling to rising.
    pub fn turns(&self) -> usize {
        let steps: Vec<f64> = self.0.friction.windows(2).map(|ends| ends[1] - ends[0]).collect();
        steps.windows(2).filter(|steps| steps[0] * steps[1] < 0.0).count()
    }

    /// The standard deviation of the friction about the straight line through the rows before and after,
    /// which is that of independent errors where the curve hardly bends between rows (Gasser, Sroka and
    /// Jennen-Steinmetz, Biometrika 73, 1986); by the median, since it may bend at some. In the units of the friction.
    pub fn scatter(&self) -> f64 {
        let Cubics { u, friction, source, .. } = &*self.0;
        let size = |i: usize| {
            let after = (u[i] - u[i - 1]) / (u[i + 1] - u[i - 1]);
            let before = 1.0 - after;
            let miss = before * friction[i - 1] + after * friction[i + 1] - friction[i];
            miss.abs() / (before * before + after * after + 1.0).sqrt()
        };
        // Of the slowest row after one that is on its line nothing is missed.
        let first = 1 + usize::from(source.no_rest);
        let mut sizes: Vec<f64> = (first..self.pieces()).map(size).collect();
        sizes.sort_by(f64::total_cmp);
        let count = sizes.len();
        0.5 * (sizes[(count - 1) / 2] + sizes[count / 2]) / MEDIAN_SIZE
    }

    /// The largest slip speed for which the law is known.
    #[must_use]
    pub fn fastest(&self) -> f64 {
        self.0.u[self.0.u.len() - 1]
    }

    /// The same law, continued in a straight line to slip speed `fastest` beyond its data, to estimate how
    /// far the data should reach. `None` if the continued law is not legal.
    pub fn continued(&self, fastest: f64) -> Option<Self> {
        let end = self.fastest();
        let mut data: Vec<(f64, f64)> = self.0.u.iter().map(|&u| (u, self.phi(u))).collect();
        let friction = self.phi(end) - self.weakening(end) * (fastest - end);
        data.push((fastest, friction.max(0.0)));
        Self::of_data(self.origin(), &data, 1.0, self.0.may_drop).ok()
    }

    /// Slip speeds at which two cubics meet.
    pub(super) fn corners(&self) -> &[f64] {
        &self.0.u[1..self.pieces()]
    }

    fn pieces(&self) -> usize {
        self.0.u.len() - 1
    }

    /// Index of the piece that contains `u`; the first one below zero.
    fn piece_at(&self, u: f64) -> usize {
        let after = self.0.u.partition_point(|knot| *knot <= u);
        after.saturating_sub(1).min(self.pieces() - 1)
    }

    /// The cubic of a piece, in any arithmetic. The law is defined by the stored values and slopes at the
    /// data.
    #[inline]
    fn cubic<T: Real>(&self, i: usize) -> Cubic<T> {
        let Cubics { u, phi, slope, .. } = &*self.0;
        let c = T::constant;
        let h = c(u[i + 1]) - c(u[i]);
        let secant = (c(phi[i + 1]) - c(phi[i])) / h;
        let [from, to] = [c(slope[i]), c(slope[i + 1])];
        let c2 = (c(3.0) * secant - c(2.0) * from - to) / h;
        let c3 = (from + to - c(2.0) * secant) / (h * h);
        [c(phi[i]), from, c2, c3]
    }

    /// phi(u); below u = 0, where the flow is continued, by the first cubic.
    pub(super) fn phi(&self, u: f64) -> f64 {
        if u > self.fastest() {
            return f64::NAN;
        }
        let piece = self.piece_at(u);
        let [phi, slope, c2, c3]: Cubic<f64> = self.cubic(piece);
        let t = u - self.0.u[piece];
        phi + t * (slope + t * (c2 + t * c3))
    }

    /// -phi'(u).
    pub(super) fn weakening(&self, u: f64) -> f64 {
        if u > self.fastest() {
            return f64::NAN;
        }
        let piece = self.piece_at(u);
        weakening(self.cubic(piece), u - self.0.u[piece])
    }

    /// The rounding error of -phi' at `u`: its slopes are quotients of differences of data next to it.
    pub(super) fn rounding_of_weakening(&self, u: f64) -> f64 {
        let i = self.piece_at(u);
        let near = i.saturating_sub(1)..(i + 3).min(self.0.u.len());
        let step =
            self.0.u[near.clone()].windows(2).map(|ends| ends[1] - ends[0]).fold(f64::INFINITY, f64::min);
        let largest = self.0.phi[near].iter().fold(0.0, |largest: f64, phi| largest.max(phi.abs()));
        4.0 * f64::EPSILON * largest / step
    }

    /// The parabolas of -phi', piece by piece, with enclosures of their coefficients.
    pub(super) fn parabolas(&self) -> impl Iterator<Item = Parabola> {
        (0..self.pieces()).map(|i| {
            let ([_, slope, c2, c3], c) = (self.cubic::<Interval>(i), Interval::constant);
            let coefficients = [-slope, -(c(2.0) * c2), -(c(3.0) * c3)];
            Parabola { ends: [self.0.u[i], self.0.u[i + 1]], coefficients }
        })
    }

    /// Bounds of phi on [lo, hi]. The cubics are monotone between the data.
    pub(super) fn friction_range(&self, lo: f64, hi: f64) -> Range {
        let Cubics { u, phi, .. } = &*self.0;
        let between = u.partition_point(|knot| *knot < lo)..u.partition_point(|knot| *knot <= hi);
        let ends = Range { lo: self.phi(lo).min(self.phi(hi)), hi: self.phi(lo).max(self.phi(hi)) };
        phi[between]
            .iter()
            .fold(ends, |range, value| Range { lo: range.lo.min(*value), hi: range.hi.max(*value) })
    }

    /// The mean weakening rate by Gauss quadrature between the data, where the integrand is smooth.
    pub(super) fn mean_weakening(&self, belt_speed: f64) -> f64 {
        if !(2.0 * belt_speed <= self.fastest()) {
            return f64::NAN;
        }
        let ends = &self.0.u[..=self.piece_at(2.0 * belt_speed) + 1];
        let rate = |i: usize, u: f64| weakening(self.cubic(i), u - self.0.u[i]);
        mean::between(ends, rate, belt_speed)
    }
}

/// Slopes at the data by Fritsch and Butland: zero at extremes, else a harmonic mean of the secants; at the
/// ends those of a one-sided parabola, limited to keep the shape. Each slope is a series of the order of
/// `phi`.
fn slopes<const N: usize>(u: &[f64], phi: &[Jet<f64, N>]) -> Vec<Jet<f64, N>> {
    type Series<const N: usize> = Jet<f64, N>;
    let (number, value) = (Series::<N>::constant, |series: Series<N>| series.0[0]);
    let h: Vec<f64> = u.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let secant: Vec<Series<N>> =
        phi.windows(2).zip(&h).map(|(pair, h)| (pair[1] - pair[0]) / number(*h)).collect();
    let end = |h0: f64, h1: f64, s0: Series<N>, s1: Series<N>| {
        let slope = (number(2.0 * h0 + h1) * s0 - number(h0) * s1) / number(h0 + h1);
        if value(slope) * value(s0) <= 0.0 {
            number(0.0)
        } else if value(s0) * value(s1) <= 0.0 && value(slope).abs() > 3.0 * value(s0).abs() {
            number(3.0) * s0
        } else {
            slope
        }
    };
    let last = h.len() - 1;
    let mut slopes = vec![end(h[0], h[1], secant[0], secant[1])];
    for i in 1..=last {
        let (before, after) = (secant[i - 1], secant[i]);
        slopes.push(if value(before) * value(after) <= 0.0 {
            number(0.0)
        } else {
            let (w1, w2) = (2.0 * h[i] + h[i - 1], h[i] + 2.0 * h[i - 1]);
            number(w1 + w2) / (number(w1) / before + number(w2) / after)
        });
    }
    slopes.push(end(h[last], h[last - 1], secant[last], secant[last - 1]));
    slopes
}

/// The slope of a cubic at share `x` of its piece, from the slope of the chord and the slopes at both ends.
fn hermite_slope(x: f64, secant: f64, s0: f64, s1: f64) -> f64 {
    6.0 * x * (1.0 - x) * secant + (1.0 - x) * (1.0 - 3.0 * x) * s0 + x * (3.0 * x - 2.0) * s1
}

mod between;
#[cfg(test)]
mod tests;

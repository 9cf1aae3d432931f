//! Measured friction as a law: readings reduced to a curve, few of them averaged, and the friction at rest.

use super::{Measured, MeasuredReading, ONE_AT_REST};
use slipmap_fit::{Reduced, mean, widening};
use slipmap_model::friction::{Expression, ExpressionError, Law, Source, Table};
use slipmap_numbers::text::{rounded, short, with_error};

/// The friction at rest of a table or of a formula.
#[derive(Clone, Copy, Debug)]
pub enum Level {
    /// 1, or the larger of two rows at slip speed 0. Of a formula its value there.
    One,
    /// That of the rows at rest, or the larger of two.
    First,
    /// A given one, at least that of friction in slip.
    Given(f64),
    /// That of the first peak, also at lower slip speeds.
    Peak,
}

impl Level {
    /// The law of a formula with this friction at rest.
    ///
    /// # Errors
    /// The formula is no friction law; what is wrong and where.
    pub fn formula(self, phi: &str) -> Result<Law, ExpressionError> {
        match self {
            Level::Given(level) => Expression::with_static(phi, level).map(Law::Expression),
            Level::Peak => Expression::new(phi, 1.0)?.with_rest_at_peak().map(Law::Expression),
            Level::One | Level::First => Expression::new(phi, 1.0).map(Law::Expression),
        }
    }
}

/// Largest ratio of two readings at rest that are averaged. While it sticks, the friction is what the spring
/// pulls: a record of that is no friction law.
const WIDEST_AT_REST: f64 = 2.0;
/// Standard errors from which friction at rest is more than that as slip begins, or less.
const SURE: f64 = 2.0;

type Told = (String, String);

/// Slip speeds and friction.
fn pairs(rows: &[MeasuredReading]) -> Vec<(f64, f64)> {
    rows.iter().map(|row| (row.speed, row.friction)).collect()
}

/// Friction and standard errors.
fn with_errors(rows: &[MeasuredReading]) -> Vec<[f64; 2]> {
    rows.iter().map(|row| [row.friction, row.error]).collect()
}

impl Measured {
    /// The law of the curve to which the readings are reduced, or of few the one that goes through them, or through the means
    /// of those of one slip speed. Two rows at rest, where no other speed is repeated, are the two coefficients: the
    /// larger one is the friction at rest, and friction in slip begins at the smaller one. Without a row at rest
    /// friction in slip begins on the line through the slowest ones.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn table(&self, level: Level) -> Result<Table, Told> {
        let mut said = self.said.clone();
        let (level, onset) = self.rest(level)?;
        if let Some(curve) = self.reduced() {
            return self.table_of(curve, level, &onset, said);
        }
        let mut rows = self.averaged(&onset);
        let no_rest = onset.is_empty()
            && !matches!(level, Level::Peak)
            && self.continue_to_rest(&mut rows, level, &mut said)?;
        let place = |row: Option<usize>| {
            let line = row.and_then(|row| rows.get(row)).map(|row| row.line).filter(|line| *line > 0);
            line.map_or_else(|| self.name.clone(), |line| format!("{}:{line}", self.name))
        };
        let first = rows[0].friction;
        if !(first > 0.0) && matches!(level, Level::First | Level::Given(_)) {
            let problem = format!("{}: the friction at rest is {first}", place(Some(0)));
            let remedy = "begin with the friction at rest, greater than 0; of a smoothed law that of the peak, and the \
                          rows beyond";
            return Err((problem, remedy.into()));
        }
        let has_errors = rows.iter().all(|row| !row.error.is_nan());
        let data = pairs(&rows);
        let table = match level {
            Level::One => Table::new(&self.name, &data, 1.0),
            Level::First => Table::new(&self.name, &data, first),
            Level::Given(level) => Table::with_static(&self.name, &data, level),
            Level::Peak => Table::with_rest_at_peak(&self.name, &data),
        };
        // The rows below a peak are one row.
        let kept = table.as_ref().map_or(rows.len(), |table| table.data().count());
        let kept = &rows[rows.len() - kept..];
        let errors: Vec<f64> = kept.iter().map(|row| row.error).collect();
        let source = Source {
            lines: kept.iter().map(|row| row.line).collect(),
            readings: self.at_rest.len() + self.in_slip.len() - usize::from(onset.len() < self.at_rest.len()),
            told: (!said.is_empty()).then(|| format!("{}: {}", self.name, said.join("; "))),
            forces: self.forces == Some(true),
            no_rest,
            named_errors: self.has_errors,
        };
        table
            .and_then(|table| if has_errors { table.with_standard_errors(&errors) } else { Ok(table) })
            .map(|table| table.with_error_of_curve().with_source(source))
            .map_err(|error| (format!("{}: {}", place(error.row), error.problem), error.remedy))
    }

    /// The friction at rest, and the readings at slip speed 0 at which friction in slip begins.
    fn rest(&self, level: Level) -> Result<(Level, Vec<MeasuredReading>), Told> {
        let mut onset = self.at_rest.clone();
        let repeated = self.in_slip.windows(2).any(|rows| rows[0].speed == rows[1].speed);
        if let [one, other] = onset[..]
            && one.friction != other.friction
            && !repeated
            && !self.is_record
            && !matches!(level, Level::Peak)
        {
            if let Level::Given(_) = level {
                let problem = format!(
                    "{}:{}: friction at rest is written twice: here, and as static",
                    self.name, one.line
                );
                let remedy = "leave out static, or the larger of the two rows at slip speed 0";
                return Err((problem, remedy.into()));
            }
            let held = usize::from(one.friction < other.friction);
            let level = onset.remove(held).friction;
            return Ok((Level::Given(level), onset));
        }
        let [least, most] = [f64::min, f64::max]
            .map(|of| onset.iter().map(|reading| reading.friction).reduce(of).unwrap_or(0.0));
        if least < most && most > WIDEST_AT_REST * least {
            let problem = format!(
                "{}:{}: the friction at slip speed 0 goes from {least} to {most}",
                self.name, onset[0].line
            );
            return Err((problem, "write the one at which it breaks loose, and below it that at which slip begins, if it is less".into()));
        }
        Ok((level, onset))
    }

    /// The rows of the law, means of those of one speed, with NaN for unknown standard errors. Without standard errors of their
    /// own all readings are taken to scatter alike about these means, since two or three of one speed tell little of it.
    pub(super) fn averaged(&self, onset: &[MeasuredReading]) -> Vec<MeasuredReading> {
        let all: Vec<MeasuredReading> = onset.iter().chain(&self.in_slip).copied().collect();
        let of_one_speed = || all.chunk_by(|one, next| one.speed == next.speed);
        let row = |same: &[MeasuredReading]| {
            let [friction, error] = mean(&with_errors(same)).unwrap_or([f64::NAN; 2]);
            MeasuredReading { friction, error, ..same[0] }
        };
        let mut rows: Vec<MeasuredReading> = of_one_speed().map(row).collect();
        if !self.has_errors {
            let of_same = |(same, mean): (&[MeasuredReading], &MeasuredReading)| {
                same.iter().map(|row| (row.friction - mean.friction).powi(2)).sum::<f64>()
            };
            let squares: f64 = of_one_speed().zip(&rows).map(of_same).sum();
            let variance = squares / (all.len() - rows.len()) as f64;
            // Rows written twice tell of no scatter.
            let of = |count: usize| if variance > 0.0 { (variance / count as f64).sqrt() } else { f64::NAN };
            rows.iter_mut().zip(of_one_speed()).for_each(|(row, same)| row.error = of(same.len()));
        }
        rows
    }

    /// The law of a curve. Friction at rest is that as slip begins unless the readings at rest say surely that it is more.
    fn table_of(
        &self,
        mut curve: Reduced,
        level: Level,
        onset: &[MeasuredReading],
        mut said: Vec<String>,
    ) -> Result<Table, Told> {
        let told = |friction: f64, error: f64| match self.say_their_error(onset) {
            true => with_error(friction, error),
            false => format!("{} {ONE_AT_REST}", short(friction)),
        };
        said.push(format!("{} readings in slip reduced to a curve with errors", self.in_slip.len()));
        let rest = self.at_breakaway(onset, curve.scatter);
        let level = match (level, rest) {
            (Level::Peak, _) => level,
            (Level::Given(level), rest) => {
                // The lower of two rows at rest is where slip begins, which is at most at the friction at rest.
                if let Some([friction, error]) = rest {
                    curve.begin_at(friction, error * error);
                }
                if curve.friction[0] > level {
                    curve.begin_at(level, 0.0);
                }
                Level::Given(level)
            }
            (_, None) => Level::First,
            (_, Some([friction, error])) if self.is_record && !self.is_of_both(onset) => {
                said.push(format!("friction at rest is {} in one direction", told(friction, error)));
                Level::First
            }
            (_, Some([friction, error])) => {
                let off = friction - curve.friction[0];
                said.push(format!("friction at rest is {}", told(friction, error)));
                // Slip begins at most at the friction at rest.
                if off < 0.0 {
                    curve.begin_at(friction, error * error);
                }
                let is_sure = off > SURE * error.hypot(curve.covariance[(0, 0)].sqrt());
                if is_sure { Level::Given(friction) } else { Level::First }
            }
        };
        let begins = with_error(curve.friction[0], curve.covariance[(0, 0)].max(0.0).sqrt());
        let no_rest = if rest.is_none() { "no row at rest: " } else { "" };
        said.push(format!("{no_rest}friction in slip begins at {begins}"));
        let data: Vec<(f64, f64)> =
            curve.speeds.iter().copied().zip(curve.friction.iter().copied()).collect();
        let table = match level {
            Level::Given(level) => Table::with_static(&self.name, &data, level),
            Level::Peak => Table::with_rest_at_peak(&self.name, &data),
            Level::One | Level::First => Table::new(&self.name, &data, data[0].1),
        };
        let source = Source {
            readings: self.at_rest.len() + self.in_slip.len(),
            told: Some(format!("{}: {}", self.name, said.join("; "))),
            forces: self.forces == Some(true),
            ..Source::default()
        };
        // The rows below a peak are one row.
        let of = |table: Table| {
            let root = curve.root(data.len() - table.data().count());
            let rows = root.iter().flat_map(|root| root.row_iter().enumerate());
            let rows = rows.map(|(i, row)| row.iter().take(i + 1).copied().collect()).collect();
            table.with_root_of_covariance(rows)
        };
        let table = table.and_then(of).map(|table| table.with_source(source));
        table.map_err(|error| (format!("{}: {}", self.name, error.problem), error.remedy))
    }

    /// Whether readings at rest are of both directions of slip if those in slip are: else they say nothing of the mean.
    fn is_of_both(&self, onset: &[MeasuredReading]) -> bool {
        let has = |rows: &[MeasuredReading], backward: bool| rows.iter().any(|row| row.backward == backward);
        [false, true].into_iter().all(|of| has(onset, of) || !has(&self.in_slip, of))
    }

    /// The friction at rest with its standard error, two of which are those of 95 %: the mean of readings at rest, of two directions
    /// that of theirs. Of one in each the error is not known, but at least the `scatter` in slip.
    pub(super) fn at_breakaway(&self, onset: &[MeasuredReading], scatter: f64) -> Option<[f64; 2]> {
        let (one, other): (Vec<MeasuredReading>, Vec<MeasuredReading>) =
            onset.iter().partition(|row| row.backward);
        let all = [one, other].map(|rows| with_errors(&rows));
        let of_each: Vec<(&[[f64; 2]], [f64; 2])> =
            all.iter().filter_map(|rows| Some((&rows[..], mean(rows)?))).collect();
        let freedom = onset.len() as f64 - of_each.len() as f64;
        let squares =
            of_each.iter().flat_map(|(rows, [mean, _])| rows.iter().map(move |row| (row[0] - mean).powi(2)));
        let variance = match freedom > 0.0 {
            true => squares.sum::<f64>() / freedom * widening(freedom),
            false => scatter * scatter,
        };
        let of_mean = |(rows, [_, error]): &(&[[f64; 2]], [f64; 2])| match self.has_errors {
            true => error * error,
            false => variance / rows.len() as f64,
        };
        let directions = of_each.len() as f64;
        let friction = of_each.iter().map(|(_, [mean, _])| mean).sum::<f64>() / directions;
        let error = of_each.iter().map(of_mean).sum::<f64>().sqrt() / directions;
        (!onset.is_empty()).then_some([friction, error])
    }

    /// Whether readings at rest have errors, or some of one direction: else they do not say theirs.
    pub(super) fn say_their_error(&self, onset: &[MeasuredReading]) -> bool {
        self.has_errors
            || [true, false].into_iter().any(|of| onset.iter().filter(|row| row.backward == of).count() > 1)
    }

    /// Without a row at rest friction in slip begins on the line through the two slowest ones, or at the friction at
    /// rest where that is less, which is exact. Returns whether it is the line.
    fn continue_to_rest(
        &self,
        rows: &mut Vec<MeasuredReading>,
        level: Level,
        said: &mut Vec<String>,
    ) -> Result<bool, Told> {
        let [near, far, ..] = rows[..] else {
            return Err((
                format!("{}: there is only one slip speed", self.name),
                "give at least three".into(),
            ));
        };
        if let Level::One = level {
            let problem =
                format!("{}:{}: the first slip speed is {}, not 0", self.name, near.line, near.speed);
            let remedy = "begin with the friction at rest, at slip speed 0, or write it with the key static";
            return Err((problem, remedy.into()));
        }
        let share = near.speed / (far.speed - near.speed);
        let line = near.friction + share * (near.friction - far.friction);
        let error = ((1.0 + share) * near.error).hypot(share * far.error);
        // What is given is exact; without errors of the rows it has none either, which is NaN.
        let (friction, error, is_line) = match level {
            Level::Given(level) if level < line => (level, 0.0 * error, false),
            _ => (line, error, true),
        };
        said.push(format!(
            "no row at rest: friction in slip begins at {}, on the line through the two slowest",
            rounded(friction, 4)
        ));
        rows.insert(0, MeasuredReading { speed: 0.0, friction, error, ..near });
        Ok(is_line)
    }
}

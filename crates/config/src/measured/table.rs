//! Measured friction as a law: repeated and scattered readings averaged, and the friction at rest.

use super::readings::{Knot, means, segments};
use super::{Measured, Reading};
use slipmap_model::friction::{Expression, ExpressionError, Law, Source, Table};

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
/// Number of rows from which those that scatter are averaged, and the share of them at
/// which the friction turns that is scatter. With independent errors alone, two thirds of the rows have a turn.
const FEWEST_SCATTERED: usize = 40;
const SHARE_OF_TURNS: f64 = 0.25;

type Told = (String, String);

/// Slip speeds and friction.
fn pairs(rows: &[Reading]) -> Vec<(f64, f64)> {
    rows.iter().map(|row| (row.speed, row.friction)).collect()
}

impl Measured {
    /// The law that goes through the readings, or through their means: those of one slip speed are averaged, and
    /// so are many that scatter. Two rows at rest, where no other speed is repeated, are the two coefficients: the
    /// larger one is the friction at rest, and friction in slip begins at the smaller one. Without a row at rest
    /// friction in slip begins on the line through the slowest ones.
    ///
    /// # Errors
    /// The problem with its line, and a remedy.
    pub fn table(&self, level: Level) -> Result<Table, Told> {
        let mut said = self.said.clone();
        let (level, onset) = self.rest(level)?;
        let mut rows = self.averaged(&onset, &mut said);
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
        };
        table
            .and_then(|table| if has_errors { table.with_standard_errors(&errors) } else { Ok(table) })
            .map(|table| table.with_error_of_curve().with_source(source))
            .map_err(|error| (format!("{}: {}", place(error.row), error.problem), error.remedy))
    }

    /// The friction at rest, and the readings at slip speed 0 at which friction in slip begins.
    fn rest(&self, level: Level) -> Result<(Level, Vec<Reading>), Told> {
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

    /// The rows of the law, with NaN for unknown standard errors.
    fn averaged(&self, onset: &[Reading], said: &mut Vec<String>) -> Vec<Reading> {
        let row = |speed, friction, error, line| Reading { speed, friction, error, line, passage: 0 };
        let in_slip = pairs(&self.in_slip);
        if self.is_record || scatters(&in_slip) {
            let mut rows = Vec::new();
            let (knots, spread) = self.segments();
            if let [first, ..] = onset {
                let all = pairs(onset);
                let mean = all.iter().map(|(_, friction)| friction).sum::<f64>() / all.len() as f64;
                let own = means(&all).and_then(|means| means.standard_errors).map(|errors| errors[0]);
                rows.push(row(0.0, mean, own.unwrap_or(spread), first.line));
            }
            rows.extend(knots.iter().map(|knot| row(knot.speed, knot.friction, knot.error, 0)));
            said.push(format!(
                "{} readings in slip reduced to {} slip speeds with standard errors",
                in_slip.len(),
                knots.len()
            ));
            return rows;
        }
        let all: Vec<Reading> = onset.iter().chain(&self.in_slip).copied().collect();
        if self.has_errors {
            return all.chunk_by(|one, next| one.speed == next.speed).map(weighted).collect();
        }
        let Some(means) = means(&pairs(&all)) else { return all };
        let error = |at: usize| means.standard_errors.as_ref().map_or(f64::NAN, |errors| errors[at]);
        let of = |(at, &(speed, friction))| row(speed, friction, error(at), all[means.first[at]].line);
        means.data.iter().enumerate().map(of).collect()
    }

    /// The readings in slip as those of segments, and the standard deviation of one of the slowest.
    pub(super) fn segments(&self) -> (Vec<Knot>, f64) {
        let passages: Vec<usize> = self.in_slip.iter().map(|row| row.passage).collect();
        segments(&pairs(&self.in_slip), self.is_record.then_some(&passages))
    }

    /// Without a row at rest friction in slip begins on the line through the two slowest ones, or at the friction at
    /// rest where that is less, which is exact. Returns whether it is the line.
    fn continue_to_rest(
        &self,
        rows: &mut Vec<Reading>,
        level: Level,
        said: &mut Vec<String>,
    ) -> Result<bool, Told> {
        let [near, far, ..] = rows[..] else {
            return Err((
                format!("{}: there are only {} slip speeds", self.name, rows.len()),
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
            slipmap_numbers::text::rounded(friction, 4)
        ));
        rows.insert(0, Reading { speed: 0.0, friction, error, ..near });
        Ok(is_line)
    }
}

/// The mean of readings with standard errors, weighted by these.
fn weighted(same: &[Reading]) -> Reading {
    if let [one] = same {
        return *one;
    }
    if same.iter().any(|row| row.error == 0.0) {
        let exact: Vec<&Reading> = same.iter().filter(|row| row.error == 0.0).collect();
        let friction = exact.iter().map(|row| row.friction).sum::<f64>() / exact.len() as f64;
        return Reading { friction, error: 0.0, ..same[0] };
    }
    let weights = || same.iter().map(|row| row.error.powi(-2));
    let total: f64 = weights().sum();
    let mean = same.iter().zip(weights()).map(|(row, weight)| weight * row.friction).sum::<f64>() / total;
    Reading { friction: mean, error: total.powf(-0.5), ..same[0] }
}

/// Whether readings are many and go up and down from one to the next.
fn scatters(readings: &[(f64, f64)]) -> bool {
    let steps: Vec<f64> = readings.windows(2).map(|pair| pair[1].1 - pair[0].1).collect();
    let turns = steps.windows(2).filter(|steps| steps[0] * steps[1] < 0.0).count();
    readings.len() >= FEWEST_SCATTERED && turns as f64 >= SHARE_OF_TURNS * readings.len() as f64
}

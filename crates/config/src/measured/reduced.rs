//! Readings in slip reduced to a curve: those of each direction for themselves, and those of a record by time.

use super::{Measured, MeasuredReading};
use slipmap_fit::{Reduced, Rows, reduce};

/// Least number of readings in slip and of their slip speeds: fewer are taken as they are.
const FEWEST: usize = 8;
const FEWEST_SPEEDS: usize = 6;
/// Least ratio of the largest slip speeds of two directions that are reduced each for itself.
const AS_FAST: f64 = 0.9;
/// Number of slip speeds at which the rows are told without a law.
const TOLD: usize = 40;
/// Number of times that the difference of two directions is estimated with the curve that follows from it.
const ROUNDS: usize = 3;

/// Whether readings have enough slip speeds for a curve.
fn are_enough(rows: &[&MeasuredReading]) -> bool {
    let mut speeds: Vec<f64> = rows.iter().map(|row| row.speed).collect();
    speeds.sort_by(f64::total_cmp);
    speeds.dedup();
    rows.len() >= FEWEST && speeds.len() >= FEWEST_SPEEDS
}

fn fastest(rows: &[&MeasuredReading]) -> f64 {
    rows.iter().map(|row| row.speed).fold(0.0, f64::max)
}

impl Measured {
    /// The curve of the readings in slip, with the error that those of the speeds make of it; `None` where they are taken as they are: few, all equal, or exact.
    pub(super) fn reduced(&self) -> Option<Reduced> {
        let mut curve = self.of_rows()?;
        if self.error_of_speed > 0.0 {
            curve.smear(self.error_of_speed);
        }
        Some(curve)
    }

    fn of_rows(&self) -> Option<Reduced> {
        let mut rows: Vec<&MeasuredReading> = self.in_slip.iter().collect();
        let is_constant = rows.windows(2).all(|pair| pair[0].friction == pair[1].friction);
        let is_exact = self.in_slip.iter().any(|row| row.error == 0.0);
        if self.is_law || is_constant || is_exact || !are_enough(&rows) {
            return None;
        }
        if self.is_record {
            rows.sort_by_key(|row| row.line);
        }
        let [forward, backward] =
            [false, true].map(|of| rows.iter().copied().filter(|row| row.backward == of).collect::<Vec<_>>());
        if forward.is_empty() || backward.is_empty() {
            let last = fastest(&rows);
            return Some(self.curve(&rows, last, None));
        }
        let ends = [&forward, &backward].map(|rows| fastest(rows));
        let last = ends[0].min(ends[1]);
        if are_enough(&forward) && are_enough(&backward) && last >= AS_FAST * ends[0].max(ends[1]) {
            return Some(self.curve(&forward, last, None).mean(self.curve(&backward, last, None)));
        }
        // One curve for both, which differ by the same share at all speeds: that of their mean.
        let sign = |row: &MeasuredReading| if row.backward { -1.0 } else { 1.0 };
        let last = ends[0].max(ends[1]);
        let mut aside: Vec<f64> = rows.iter().map(|row| sign(row) * row.friction).collect();
        let mut curve = self.curve(&rows, last, Some(&aside));
        for _ in 1..ROUNDS {
            aside = rows.iter().map(|row| sign(row) * curve.at(row.speed)).collect();
            curve = self.curve(&rows, last, Some(&aside));
        }
        Some(curve)
    }

    /// The slip speeds of which there are as many rows between: those of the steps of a staircase.
    fn told_at(&self, last: f64) -> Vec<f64> {
        let count = self.in_slip.len();
        let at = (0..TOLD).map(|i| self.in_slip[(2 * i + 1) * count / (2 * TOLD)].speed);
        at.filter(|speed| *speed <= last).collect()
    }

    fn curve(&self, rows: &[&MeasuredReading], last: f64, aside: Option<&[f64]>) -> Reduced {
        let of = |value: fn(&MeasuredReading) -> f64| rows.iter().map(|row| value(row)).collect::<Vec<f64>>();
        let (speeds, friction, errors) = (of(|row| row.speed), of(|row| row.friction), of(|row| row.error));
        let mut visits = Vec::new();
        for (i, row) in rows.iter().enumerate() {
            let before = visits.last().copied().unwrap_or(0);
            visits.push(before + usize::from(i > 0 && rows[i - 1].visit != row.visit));
        }
        reduce(Rows {
            speeds: &speeds,
            friction: &friction,
            errors: self.has_errors.then_some(&errors[..]),
            visits: self.is_record.then_some(&visits[..]),
            aside,
            last,
            told_at: &self.told_at(last),
        })
    }
}

//! The critical damping c* of a column: the root of the grazing margin.
//!
//! At c* the orbit from the exit point grazes the belt line: it closes with the maximum V of x2. The search
//! is that of `closing`; columns outside the domain of the polar form are searched with [`flow`].

use std::cell::Cell;

use super::closing::closing_dampings;
use super::polar::Closing;
use super::roots::{Found, falling_bracket, falling_root};
use super::{Fate, Landing, flow};
use crate::filippov::Oscillator;
use crate::friction::{Column, Curve};

/// The critical damping of a column.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CriticalDamping {
    /// c*: the orbit from the exit point returns to the belt line for c < c* and not for c > c*. Negative
    /// where it does not return for any legal damping.
    pub c: f64,
    /// Estimate of the absolute error of `c`.
    pub error: f64,
    /// Number of evaluations of the right-hand side.
    pub rhs: u64,
}

/// Reason why a column has no critical damping.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoCriticalDamping {
    /// The engines gave no verdict where the search needed one.
    #[error("the simulated flow gives no verdict next to the boundary")]
    NoVerdict,
}

/// The critical damping of many columns.
///
/// `tolerance` is relative to the size of the divergence: about the error of the scaled grazing margin
/// that the error of c* amounts to.
#[must_use]
pub fn critical_dampings(
    columns: &[Column],
    tolerance: f64,
) -> Vec<Result<CriticalDamping, NoCriticalDamping>> {
    let orbits: Vec<(&Curve, f64, f64)> =
        columns.iter().map(|column| (&column.curve, column.belt_speed, column.belt_speed)).collect();
    let found = closing_dampings(&orbits, tolerance, None);
    let answer = |(column, found): (&Column, Result<Closing, u64>)| match found {
        Ok(Closing { viscous, error, rhs }) => {
            Ok(CriticalDamping { c: viscous / column.epsilon, error: error / column.epsilon, rhs })
        }
        Err(rhs) => search(column, tolerance, rhs),
    };
    columns.iter().zip(found).map(answer).collect()
}

/// The critical damping of one column, see [`critical_dampings`].
///
/// # Errors
/// [`NoCriticalDamping`] where the flow gives no verdict next to the boundary.
pub fn critical_damping(column: &Column, tolerance: f64) -> Result<CriticalDamping, NoCriticalDamping> {
    critical_dampings(std::slice::from_ref(column), tolerance)[0]
}

/// Number of evaluations of the right-hand side of the Stribeck law after which the search of a column ends:
/// reached by orbits so stiff that one of them takes a million.
const WORK: u64 = 4_000_000;

/// Searches a column with the simulated flow, which also decides overdamped points.
fn search(column: &Column, tolerance: f64, rhs: u64) -> Result<CriticalDamping, NoCriticalDamping> {
    let (mut rhs, before) = (rhs, rhs);
    // Error of the margin of an orbit that is too close to call.
    let undecided = Cell::new(0.0);
    let budget = WORK / column.curve.cost();
    let mut margin = |c: f64| {
        if rhs - before > budget {
            return Err(NoCriticalDamping::NoVerdict);
        }
        let oscillator = Oscillator::in_column(column, c);
        let answer = flow(&oscillator, 1e-12);
        rhs += answer.rhs;
        let size = if answer.margin.is_finite() { answer.margin.abs().min(1.0) } else { 1.0 };
        match answer.fate {
            // Where the flow cannot be continued beyond the line, r at the landing is about what it would be after
            // the turn.
            Fate::Sticks(Landing { x1, crossings: 0, .. }) if answer.margin.is_nan() => {
                let speed = (oscillator.exit_x1() - x1) / column.belt_speed;
                Ok((speed * speed / (1.0 + speed.hypot(1.0))).clamp(f64::MIN_POSITIVE, 1.0))
            }
            Fate::Sticks(_) | Fate::CrossesForever => Ok(size),
            Fate::SpiralsInward => Ok(-size),
            Fate::TooCloseToCall => {
                undecided.set(answer.margin_error);
                Ok(0.0)
            }
            Fate::Failed(_) => Err(NoCriticalDamping::NoVerdict),
        }
    };
    // The even part of the divergence brackets the root (theory, "The tests"); the signs are checked
    // nevertheless.
    let range = column.curve.even_weakening_range(column.belt_speed);
    let width = (range.hi - range.lo).abs() / column.epsilon;
    let pad = 1e-6 * width + 1e-12 * (range.hi.abs() + range.lo.abs()) / column.epsilon;
    let (low, high) = (range.lo / column.epsilon - pad, range.hi / column.epsilon + pad);
    if low < 0.0 && high > 0.0 && margin(0.0)? < 0.0 {
        // No legal damping is small enough; the value of a negative c* is not needed.
        let half = 0.5 * low.max(f64::MIN);
        return Ok(CriticalDamping { c: half, error: -half, rhs });
    }
    let from = if high > 0.0 { low.max(0.0) } else { low };
    let mean = column.curve.mean_weakening(column.belt_speed) / column.epsilon;
    let start = if mean.is_finite() { mean.clamp(from, high) } else { 0.5 * (from + high) };
    let Some(bracket) = falling_bracket(start, [from, high], &mut margin)? else {
        return Err(NoCriticalDamping::NoVerdict);
    };
    let enough = tolerance.max(4.0 * f64::EPSILON) * (low.abs() + high.abs());
    let (c, bracket) = match falling_root(bracket, enough, &mut margin)? {
        Found::Between(bracket) => {
            return Ok(CriticalDamping { c: bracket.middle(), error: bracket.width(), rhs });
        }
        Found::Zero(c, bracket) => (c, bracket),
    };
    // The resolution of the flow limits the error, though a secant may have left the other end of the bracket
    // far away: the error is the distance of the nearest dampings, on either side, that the flow
    // distinguishes.
    let mut near = (2.0 * undecided.get() / bracket.steepness()).max(enough);
    while near < bracket.width() {
        let told_below = c - near <= bracket.low.0 || margin(c - near)? > 0.0;
        let told_above = c + near >= bracket.high.0 || margin(c + near)? < 0.0;
        if told_below && told_above {
            return Ok(CriticalDamping { c, error: near, rhs });
        }
        near *= 2.0;
    }
    Ok(CriticalDamping { c, error: bracket.width(), rhs })
}

//! How narrow smoothed friction must be: the widths at which it is a per cent off.
//!
//! With tanh(s/d) for sign(s) nothing sticks. Where the belt asks for the share f of the friction at rest, the mass
//! slides at the speed u at which tanh(u/d) phi(u) = f: at d artanh f for narrow d (theory, "Where methods fail").

use std::sync::atomic::Ordering;

use rayon::prelude::*;

use super::{Comparison, Interrupted};
use slipmap_column::{Method, Verdict, critical_damping};
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Fate;
use slipmap_model::friction::{Column, Curve};
use slipmap_model::point::Point;
use slipmap_numbers::named;
use slipmap_orbits::flow;
use slipmap_orbits::naive::{NaiveKnobs, NaiveMethod, NaiveVerdict};

/// What counts as wrong.
const OFF: f64 = 0.01;
/// Share of the friction at rest at which the creep is told.
const SHARE: f64 = 0.5;
/// Number of cells that are asked, at most.
const MOST: usize = 24;
/// The first width that is tried, in belt speeds, and the least and the greatest.
const FIRST: f64 = 1e-3;
const WIDTHS: [f64; 2] = [1e-6, 1.0];
/// Number of halvings, on a logarithmic scale, of the factor of two that encloses a width: to 4 %.
const HALVINGS: u32 = 4;

named! {
    /// What smoothing changes.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Changed {
        /// The verdict, at dampings a per cent below and above the critical one.
        Verdict => "verdict",
        /// The period of the stick-slip cycle.
        Period => "period",
        /// The slip speed at half of the friction at rest, in belt speeds.
        Creep => "creep",
    }
}

/// The widths at which smoothed friction is a per cent off, in belt speeds.
#[derive(Clone, Debug, PartialEq)]
pub struct Widths {
    pub of: Changed,
    /// In increasing order; of cells at which no width is, or which would take too many steps, none.
    pub found: Vec<f64>,
}

/// The width, in units of speed, at which friction that is smoothed creeps at 1 % of the belt speed under half of the
/// friction at rest; `None` of friction that has fallen below that there.
pub fn creep_width(curve: &Curve, belt_speed: f64) -> Option<f64> {
    let speed = OFF * belt_speed;
    let share = SHARE / curve.phi(speed);
    (share < 1.0).then(|| speed / share.atanh())
}

/// The widths over some of the cells with a stick-slip cycle; `None` where `smoothed` is not among the methods.
pub(super) fn widths(
    sticking: &[Point],
    comparison: &Comparison,
) -> Result<Option<[Widths; 3]>, Interrupted> {
    let knobs = comparison.methods.iter().find_map(|method| match method {
        Method::Naive(NaiveMethod::Smoothed, knobs) => Some(*knobs),
        _ => None,
    });
    let Some(knobs) = knobs else { return Ok(None) };
    let step = sticking.len().div_ceil(MOST).max(1);
    let points: Vec<&Point> = sticking.iter().step_by(step).collect();
    let of_point = |point: &&Point| {
        if comparison.stop.load(Ordering::Relaxed) {
            return Err(Interrupted);
        }
        let column = comparison.law.column(point);
        Ok(Changed::ALL.map(|of| match of {
            Changed::Verdict => of_verdict(&column, comparison.tolerance, knobs),
            Changed::Period => of_period(&column, point.damping, comparison.tolerance, knobs),
            Changed::Creep => {
                creep_width(&column.curve, column.belt_speed).map(|width| width / column.belt_speed)
            }
        }))
    };
    let found = points.par_iter().map(of_point).collect::<Result<Vec<_>, _>>()?;
    let mut all = Changed::ALL.map(|of| Widths { of, found: Vec::new() });
    for of_point in found {
        all.iter_mut().zip(of_point).for_each(|(widths, width)| widths.found.extend(width));
    }
    all.iter_mut().for_each(|widths| widths.found.sort_by(f64::total_cmp));
    Ok(Some(all))
}

/// What the smoothed method says of an oscillator at this width, in belt speeds.
fn smoothed(oscillator: &Oscillator, width: f64, knobs: NaiveKnobs) -> NaiveVerdict {
    let knobs = NaiveKnobs { smoothing_width: width * oscillator.belt_speed, ..knobs };
    NaiveMethod::Smoothed.decide(oscillator, &knobs).verdict
}

fn of_verdict(column: &Column, tolerance: f64, knobs: NaiveKnobs) -> Option<f64> {
    let critical = critical_damping(column, tolerance).ok()?.c;
    let sides = [(1.0 - OFF, Verdict::Present), (1.0 + OFF, Verdict::Absent)];
    let is_right = |width: f64| {
        let says = |share: f64| match smoothed(&Oscillator::in_column(column, share * critical), width, knobs)
        {
            NaiveVerdict::Failed(_) => None,
            said => Some(Verdict::from(said)),
        };
        let said = sides.map(|(share, truth)| says(share).map(|said| said == truth));
        Some(said[0]? && said[1]?)
    };
    (critical > 0.0).then(|| width_of(is_right))?
}

fn of_period(column: &Column, damping: f64, tolerance: f64, knobs: NaiveKnobs) -> Option<f64> {
    let oscillator = Oscillator::in_column(column, damping);
    let Fate::Sticks(landing) = flow(&oscillator, tolerance).fate else { return None };
    let known = landing.slip_time + landing.stick_time;
    width_of(|width| match smoothed(&oscillator, width, knobs) {
        NaiveVerdict::Failed(_) => None,
        NaiveVerdict::Sticks { period: Some(period), .. } => Some((period - known).abs() <= OFF * known),
        NaiveVerdict::Sticks { period: None, .. } | NaiveVerdict::NeverSticks => Some(false),
    })
}

/// The width below which the method is right; `None` where it is right or wrong at all widths that can be tried.
fn width_of(is_right: impl Fn(f64) -> Option<bool>) -> Option<f64> {
    let mut right = FIRST;
    let factor = if is_right(right)? { 2.0 } else { 0.5 };
    loop {
        let next = factor * right;
        if !(WIDTHS[0]..=WIDTHS[1]).contains(&next) {
            return None;
        }
        let is_next = is_right(next)?;
        if is_next == (factor < 1.0) {
            right = right.min(next);
            break;
        }
        right = next;
    }
    let mut wrong = 2.0 * right;
    for _ in 0..HALVINGS {
        let middle = (right * wrong).sqrt();
        *(if is_right(middle)? { &mut right } else { &mut wrong }) = middle;
    }
    Some((right * wrong).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::Law;

    /// The defaults of the method: a tenth narrower it is right, a tenth wider wrong.
    #[test]
    fn widths_are_where_answers_become_a_per_cent_wrong() {
        let law = Law::Exponential;
        let point = law.point(1.0, &[0.5, 0.5, 0.0], 0.3, 0.1).unwrap();
        let (column, knobs) = (law.column(&point), NaiveKnobs::default());
        let oscillator = Oscillator::in_column(&column, point.damping);
        let Fate::Sticks(landing) = flow(&oscillator, 1e-12).fate else { panic!() };
        let known = landing.slip_time + landing.stick_time;
        let width = of_period(&column, point.damping, 1e-9, knobs).unwrap();
        let off = |width: f64| match smoothed(&oscillator, width, knobs) {
            NaiveVerdict::Sticks { period: Some(period), .. } => (period / known - 1.0).abs(),
            said => panic!("{said:?}"),
        };
        assert!(off(0.9 * width) < OFF && off(1.1 * width) > OFF, "{width}");

        let critical = critical_damping(&column, 1e-9).unwrap().c;
        let width = of_verdict(&column, 1e-9, knobs).unwrap();
        let present = |share: f64, width: f64| {
            let said = smoothed(&Oscillator::in_column(&column, share * critical), width, knobs);
            Verdict::from(said) == Verdict::Present
        };
        let is_right = |width: f64| present(1.0 - OFF, width) && !present(1.0 + OFF, width);
        assert!(is_right(0.9 * width) && !is_right(1.1 * width), "{width}");
    }
}

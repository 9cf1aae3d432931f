//! The return map of the lower flow: one turn of the orbit from the exit point, for many orbits together.
//! Orbits near the circle use the few evaluations of `collocation`, the others the steps of `stepping`.
//!
//! The sign of the grazing margin m/V = delta(2 pi) is the verdict: negative, the orbit closes inside itself;
//! positive, it returns to the belt line (theory, "Two forms of the slip flow"). No event needs to be
//! located.

pub use super::polar::Turn;

use super::arc::{LowerEnd, Walk};
use super::closed_orbit::Lap;
use super::crossing::JUMP;
use super::work::Work;
use super::{Fate, Flow, Landing, closed_orbit, collocation, stepping};
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::friction::Column;
use slipmap_model::point::ScaledGroups;

/// Margins of many orbits, each with an error estimate of at most `tolerance` where that can be reached.
///
/// An orbit's answer does not depend on its neighbours in the slice, nor on the machine's vector width.
#[must_use]
pub fn turns(groups: &[ScaledGroups], tolerance: f64) -> Vec<Turn> {
    let mut turns = collocation::turns(groups, tolerance);
    let far: Vec<usize> =
        (0..turns.len()).filter(|&orbit| matches!(turns[orbit], Turn::HandOver { .. })).collect();
    let far_groups: Vec<ScaledGroups> = far.iter().map(|&orbit| groups[orbit]).collect();
    for (orbit, stepped) in far.into_iter().zip(stepping::turns(&far_groups, tolerance)) {
        let (Turn::HandOver { rhs: before } | Turn::Complete { rhs: before, .. }) = turns[orbit];
        turns[orbit] = match stepped {
            Turn::Complete { margin, error, rhs } => Turn::Complete { margin, error, rhs: rhs + before },
            Turn::HandOver { rhs } => Turn::HandOver { rhs: rhs + before },
        };
    }
    turns
}

/// Margins of one column's orbits at the dampings `cs`, see [`turns`]; one by one for laws other than
/// Stribeck's.
#[must_use]
pub fn turns_of(column: &Column, cs: &[f64], tolerance: f64) -> Vec<Turn> {
    turns_of_orbits(cs.iter().map(|&c| (column, c)), tolerance)
}

/// As [`turns_of`], for orbits of several columns, each at its damping.
pub(super) fn turns_of_orbits<'a>(
    orbits: impl Iterator<Item = (&'a Column, f64)> + Clone,
    tolerance: f64,
) -> Vec<Turn> {
    let scaled = |(column, c): (&Column, f64)| {
        column.curve.stribeck().map(|law| law.scaled(column.belt_speed, column.epsilon * c))
    };
    match orbits.clone().map(scaled).collect::<Option<Vec<_>>>() {
        Some(groups) => turns(&groups, tolerance),
        None => orbits.map(|(column, c)| turn_of(&Oscillator::in_column(column, c), tolerance)).collect(),
    }
}

/// One turn of one orbit; for laws other than Stribeck's by steps that follow the compiled law.
pub(super) fn turn_of(oscillator: &Oscillator, tolerance: f64) -> Turn {
    let Oscillator { curve, viscous, belt_speed } = oscillator;
    if let Some(law) = curve.stribeck() {
        return turns(&[law.scaled(*belt_speed, *viscous)], tolerance)[0];
    }
    match closed_orbit::turn(oscillator, *belt_speed, tolerance) {
        Ok(Lap { margin, error, rhs, .. }) => Turn::Complete { margin, error, rhs },
        Err(rhs) => Turn::HandOver { rhs },
    }
}

/// The smallest useful tolerance, for divergences of the size 1: below it round-off dominates.
const FINEST_TOLERANCE: f64 = 1e-16;
/// The largest tolerance by which one orbit is decided: coarser turns may agree by chance, and a column has
/// few such orbits.
const COARSEST_DECISIVE: f64 = 1e-9;

/// A larger error of the margin is accepted only up to `UNRESOLVED_SHARE` of the margin: the finest steps do
/// not resolve the orbit, and their error estimate is not asymptotic.
pub(super) const UNRESOLVED: f64 = 1e-8;
const UNRESOLVED_SHARE: f64 = 0.01;

/// Returns whether the margin's sign can be trusted, if it exceeds its error.
pub fn is_resolved(margin: f64, error: f64) -> bool {
    error <= UNRESOLVED || error <= UNRESOLVED_SHARE * margin.abs()
}

/// One turn of one orbit, at tolerances down to [`FINEST_TOLERANCE`] by the size of the divergence until the
/// margin's sign is certain.
pub(super) fn decisive_turn(oscillator: &Oscillator, tolerance: f64) -> Turn {
    let mut tolerance = tolerance.min(COARSEST_DECISIVE);
    let mut spent = 0;
    loop {
        match turn_of(oscillator, tolerance) {
            Turn::Complete { margin, error, rhs } => {
                spent += rhs;
                if !is_resolved(margin, error) {
                    return Turn::HandOver { rhs: spent };
                }
                let finest = || FINEST_TOLERANCE * oscillator.divergence_size().min(1.0);
                if margin.abs() > error || error == 0.0 || tolerance <= finest() {
                    return Turn::Complete { margin, error, rhs: spent };
                }
                // The margin's size is now known to be about `error` or less.
                tolerance = (1e-3 * tolerance).max(finest());
            }
            Turn::HandOver { rhs } => return Turn::HandOver { rhs: spent + rhs },
        }
    }
}

/// Largest tolerance for orbits that are handed over: they are far from circles, and error estimates need
/// finer steps there.
const COARSEST_HANDED_OVER: f64 = 1e-12;

/// Largest tolerance of the orbit to the landing: next to grazing the landing speed magnifies its errors.
const LANDING: f64 = 1e-12;
/// Largest error of the orbit to the landing, in units of its tolerance.
const OF_LANDING: f64 = 10.0;
/// Largest margin from which the landing speed follows, where the divergence at the belt line is small.
const NEXT_TO_GRAZING: f64 = 1e-8;

/// The landing of the orbit from the exit point, where the return map gives it.
struct LandingSpeed {
    /// x2', and an estimate of its error.
    speed: f64,
    error: f64,
    time: f64,
}

/// The landing speed x2' and the time of the orbit from the exit point, whose margin is `margin` > 0, and the
/// number of evaluations; the first is `None` where the orbit could not be followed.
///
/// Next to grazing the margin has more digits than the orbit. On the last arc, of the angle a, the radius
/// grows by the factor 1 + D a^3 / 3 up to V (1 + m), and x2'^2 = r^2 - V^2 at its beginning: with a = sqrt(m
/// (2 + m)) the speed is V a (1 - D a / 3), up to the order a^3.
///
/// An error e of the orbit is one of (1 + V / x2') e of the speed, because r^2 = V^2 + x2'^2.
fn landing(
    oscillator: &Oscillator,
    [margin, margin_error]: [f64; 2],
    tolerance: f64,
) -> (Option<LandingSpeed>, u64) {
    let belt_speed = oscillator.belt_speed;
    let work = Work::of_question(&oscillator.curve);
    let (start, tolerance) = ([belt_speed, 0.0], tolerance.min(LANDING));
    let mut walk = Walk::new(oscillator, Side::Below, start, tolerance, belt_speed, &work);
    let (angle, divergence) = ((margin * (2.0 + margin)).sqrt(), oscillator.divergence(0.0));
    let is_near = margin * (1.0 + divergence * divergence) < NEXT_TO_GRAZING;
    let found = match walk.lower_arc(|_, _, _| ()) {
        Ok(LowerEnd::Meets(end) | LowerEnd::Turns(end)) if is_near => {
            let speed = belt_speed * angle * (1.0 - angle * divergence / 3.0);
            let of_series = angle.powi(3) * (1.0 + divergence * divergence);
            let error = belt_speed * (margin_error * (1.0 + margin) / angle + of_series);
            Some(LandingSpeed { speed, error, time: end.time + (end.w - speed) / belt_speed })
        }
        Ok(LowerEnd::Meets(end)) => {
            let of_orbit = OF_LANDING * tolerance * belt_speed * end.growth.exp().max(1.0);
            Some(LandingSpeed { speed: end.w, error: of_orbit * (1.0 + belt_speed / end.w), time: end.time })
        }
        Ok(LowerEnd::Turns(_) | LowerEnd::Rests) | Err(_) => None,
    };
    (found, work.spent())
}

/// As [`flow`], where a turn at this tolerance gave `margin`, NaN if it was handed over.
pub fn flow_after_turn(oscillator: &Oscillator, margin: f64, tolerance: f64) -> Flow {
    // At a coarse tolerance the finer turn that decides may be complete.
    if margin.is_nan() && tolerance <= COARSEST_DECISIVE {
        directly(oscillator, tolerance)
    } else {
        flow(oscillator, tolerance)
    }
}

/// The flow of an orbit to which the return map does not apply.
fn directly(oscillator: &Oscillator, tolerance: f64) -> Flow {
    slipmap_witness::flow(oscillator, tolerance.min(COARSEST_HANDED_OVER))
}

/// The fate of the orbit from the exit point, by the return map; handed over to [`slipmap_witness::flow`] where the
/// polar form does not apply, or the orbit lands beyond the stick segment or cannot be followed to the
/// landing.
///
/// `tolerance` bounds the error of the scaled grazing margin m/V and of the landing.
#[must_use]
pub fn flow(oscillator: &Oscillator, tolerance: f64) -> Flow {
    let turn = decisive_turn(oscillator, tolerance);
    let (margin, margin_error, rhs) = match turn {
        Turn::Complete { margin, error, rhs } => (margin, error, rhs),
        Turn::HandOver { rhs } => {
            let answer = directly(oscillator, tolerance);
            return Flow { rhs: u64::from(rhs) + answer.rhs, ..answer };
        }
    };
    let rhs = u64::from(rhs);
    let answer = |fate, rhs| Flow { fate, margin, margin_error, rhs };
    if margin < -margin_error {
        return answer(Fate::SpiralsInward, rhs);
    }
    if margin.abs() <= margin_error {
        return answer(Fate::TooCloseToCall, rhs);
    }
    let (landing, spent) = landing(oscillator, [margin, margin_error], tolerance);
    match landing {
        // At a speed of 2 the orbit lands at the end of the stick segment; a little faster it crosses there,
        // and is back at once.
        Some(LandingSpeed { speed, error, time: slip_time }) if speed < JUMP + error => {
            let (x1, stick_time) = (oscillator.exit_x1() - speed, speed / oscillator.belt_speed);
            let crossings = (speed < JUMP - error).then_some(0);
            answer(Fate::Sticks(Landing { x1, slip_time, stick_time, crossings }), rhs + spent)
        }
        Some(_) | None => {
            // The margin, which is known better, may be below this tolerance.
            let direct = slipmap_witness::decisive_flow(oscillator, tolerance);
            answer(direct.fate, rhs + spent + direct.rhs)
        }
    }
}

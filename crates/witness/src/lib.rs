//! The independent engine: integrates the Filippov system in its original variables (x1, x2).
//!
//! This engine follows the field of [`Oscillator::acceleration`] itself, event by event on one side of the
//! belt line after the other, and uses none of the reductions of the rest of the crate: no polar coordinates,
//! no scaling, no half maps. It is slow, and audits use it as the reference. The compiled form of a formula
//! decides where steps end ([`slipmap_model::friction::Curve`]); the friction force itself is that of the formula.
//!
//! Accuracy: the Dormand-Prince method of order 8 with error control per unit time; states are offsets
//! from the exit point (1 - eps c V, V), summed with compensation. Departures from the paper: none.

mod dop853;
mod orbit;
mod slip;
mod trace;

pub use trace::{Ending, Phase, Sample, Start, Trace, trace};

use orbit::{Contact, Event, Overshoot, Rest, State};
use slip::Slip;
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::{Failure, Fate, Flow, Landing};

/// Width of the stick segment in x1: the force of static friction acts both ways.
const SLIDING_WIDTH: f64 = 2.0;

/// Errors greater than this, in belt speeds, come from orbits that separate so fast (at strong nodes) that
/// errors are no longer proportional to their causes.
const LINEAR: f64 = 1e-4;
/// Factor by which errors above [`LINEAR`] are multiplied before they decide a verdict.
const LARGE_ERRORS: f64 = 8.0;

/// The fate of the orbit from the exit point.
///
/// `tolerance` is the target error of the scaled margin m / V: the estimated local errors of one turn add up
/// to it. Values from 1e-3 down to about 1e-14 max(1, 1/V), the rounding errors of the right-hand side, take
/// effect; a NaN counts as zero.
///
/// **Guarantee.** None is proved. `margin_error` is the sum of the local error estimates and of the expected
/// rounding errors, each magnified by exp of the integral of max(D, 0) over the rest of the orbit, the most
/// by which neighbouring orbits can separate (the Euclidean logarithmic norm of the Jacobian is max(D, 0)).
/// Against slow references it held in all but one of 188,000 flows (17,128 points with V from 1e-3 to 100,
/// tolerances from 1e-4 to 1e-14), where it was too small by a fifth. It is too small by up to some fifty
/// times where a law oscillates, by less than the tolerance V, with a period that steps pass over. Verdicts
/// inside it are [`Fate::TooCloseToCall`]; so are orbits that come back from above within that distance of
/// the exit point. A landing state is less accurate than the margin: its x1 has the error V `margin_error`
/// (1 + V / wL), wL the landing speed x2', large near grazing.
///
/// **The belt line.** With the drop j of friction as slip begins the orbit leaves the exit point with x2' = -j.
/// Where |x1 + eps c V| < 1 friction at rest holds every arrival, also those that friction in slip would let
/// pass: an orbit that arrives from below beyond 1 - eps c V - 2 crosses upward, and one from above beyond the
/// exit point downward.
///
/// **Margin.** -1 for an orbit that tends to the equilibrium without another maximum of x2, the limit of
/// ever smaller maxima; the error is then a bound on them. NaN if the continued lower field carries the
/// orbit farther beyond the line than V/8, or than the friction law can be continued; `margin_error`
/// is then that of the last state.
///
/// **An orbit that crosses back never sticks.** Let the orbit from E = (e, V) cross the line upward at A
/// and come back down at B with x1(B) > e. The closed curve G made of this orbit and of the segment BE
/// encloses the whole stick segment, and the equilibrium. The flow passes BE downward, also with a drop, to the
/// outside of G, and cannot pass the orbit itself: what has left G never returns, so B's orbit never slides. In
/// terms of the return map on the downward crossings x1 > e: it is monotone, as planar orbits do not
/// cross, and P(e) > e, so all iterates stay beyond e.
///
/// **Failure.** [`Failure::StepBudget`] where an orbit neither turns nor settles in 100,000 steps (stiff
/// and nowhere certainly overdamped), or hardly moves in 1,000; [`Failure::NotFinite`],
/// [`Failure::StepUnderflow`].
#[must_use]
pub fn flow(oscillator: &Oscillator, tolerance: f64) -> Flow {
    let mut slip = Slip::from_exit(oscillator, tolerance);
    let first_turn = first_turn(&mut slip);
    let belt_speed = oscillator.belt_speed;
    let answer = |fate, height: f64, error: f64, rhs| Flow {
        fate,
        margin: height / belt_speed,
        margin_error: error / belt_speed,
        rhs,
    };
    match first_turn {
        Err(failure) => answer(Fate::Failed(failure), f64::NAN, slip.error, slip.rhs),
        Ok(FirstTurn::Rests { later_maxima }) => {
            answer(Fate::SpiralsInward, -belt_speed, slip.error + later_maxima, slip.rhs)
        }
        Ok(FirstTurn::Short(turn)) => {
            let height = turn.x2_offset();
            let too_close = -height <= LARGE_ERRORS * slip.error && slip.error > LINEAR * belt_speed;
            let too_close = too_close || -height <= slip.error;
            let fate = if too_close { Fate::TooCloseToCall } else { Fate::SpiralsInward };
            answer(fate, height, slip.error, slip.rhs)
        }
        Ok(FirstTurn::Lands(contact)) => {
            let rise = rise(&slip, &contact);
            slip.rhs += rise.rhs;
            // Below the line x1 = 1 - eps c V - j - x2' there: an orbit that rises to it lands short of the exit
            // point. In the first steps along a steep law rounding may carry it back to where it began.
            let is_lost = contact.at.x1_offset() >= -oscillator.drop();
            let fate = if rise.at_least <= rise.error || is_lost {
                Fate::TooCloseToCall
            } else {
                after_landing(oscillator, &mut slip, &contact.at)
            };
            answer(fate, rise.turn, rise.error, slip.rhs)
        }
    }
}

/// The smallest tolerance at which round-off does not affect the steps.
pub const FINEST: f64 = 1e-13;

/// As [`flow`]; reduces the tolerance while the point lies within the error of a boundary.
#[must_use]
pub fn decisive_flow(oscillator: &Oscillator, tolerance: f64) -> Flow {
    let (mut tolerance, mut rhs) = (tolerance, 0);
    loop {
        let answer = flow(oscillator, tolerance);
        rhs += answer.rhs;
        if answer.fate != Fate::TooCloseToCall || tolerance <= FINEST {
            return Flow { rhs, ..answer };
        }
        tolerance = (1e-2 * tolerance).max(FINEST);
    }
}

/// Outcome of the first turn below the belt line.
enum FirstTurn {
    /// The orbit has no later maximum of x2 above this.
    Rests { later_maxima: f64 },
    /// It has its maximum of x2 below the line.
    Short(State),
    /// It returns to the line.
    Lands(Contact),
}

/// Follows the orbit from the exit point until its first turn is decided.
fn first_turn(slip: &mut Slip) -> Result<FirstTurn, Failure> {
    // The rest of an orbit this close to the equilibrium is below the tolerance.
    let radius = slip.tolerance * slip.oscillator.belt_speed;
    loop {
        match slip.advance(f64::INFINITY)? {
            Event::NearMiss(turn) => return Ok(FirstTurn::Short(turn)),
            Event::Landed(contact) => return Ok(FirstTurn::Lands(contact)),
            Event::Moved => match slip.rest(radius) {
                Some(Rest::Trapped { radius }) => return Ok(FirstTurn::Rests { later_maxima: radius }),
                Some(Rest::Creeping) => return Ok(FirstTurn::Rests { later_maxima: 0.0 }),
                None => {}
            },
        }
    }
}

/// The height above the belt line to which an orbit that returns would be carried.
struct Rise {
    /// Proved lower bound of the height, up to rounding.
    at_least: f64,
    /// Height of the turn of the continued field; NaN if out of reach.
    turn: f64,
    /// Error of both heights.
    error: f64,
    /// Number of evaluations of the right-hand side.
    rhs: u64,
}

/// Follows the continued field beyond the belt line.
fn rise(slip: &Slip, contact: &Contact) -> Rise {
    if let Some(turn) = contact.turn {
        return Rise { at_least: turn.x2_offset(), turn: turn.x2_offset(), error: slip.error, rhs: 0 };
    }
    let (overshoot, followed) = slip.clone().overshoot(contact.beyond);
    let (at_least, turn) = match overshoot {
        Overshoot::Turns(turn) => (turn.x2_offset(), turn.x2_offset()),
        Overshoot::Farther(state) => (state.x2_offset() + followed.further_rise(&state), f64::NAN),
    };
    Rise { at_least, turn, error: followed.error, rhs: followed.rhs - slip.rhs }
}

/// The fate of the orbit that has reached the belt line at `at`.
fn after_landing(oscillator: &Oscillator, slip: &mut Slip, at: &State) -> Fate {
    // An error across the line becomes one along it through the angle at which the orbit meets the line.
    let error = |slip: &Slip, at: &State| slip.error * (1.0 + oscillator.belt_speed / at.w.abs());
    let beyond_segment = -SLIDING_WIDTH - at.x1_offset();
    // A little beyond the segment the orbit crosses, and is back at once. With a drop it is not: it leaves the
    // line with x2' = j.
    if beyond_segment.abs() <= error(slip, at) {
        return if oscillator.drop() > 0.0 { Fate::TooCloseToCall } else { sticks(oscillator, at, None) };
    }
    if beyond_segment < 0.0 {
        return sticks(oscillator, at, Some(0));
    }
    slip.cross(at);
    let back = loop {
        match slip.advance(f64::INFINITY) {
            Ok(Event::Landed(contact)) => break contact.at,
            // Above the line every maximum of x2 is the only one of its arc.
            Ok(Event::Moved | Event::NearMiss(_)) => {}
            Err(failure) => return Fate::Failed(failure),
        }
    };
    let error = error(slip, &back);
    let beyond_exit = back.x1_offset();
    if beyond_exit.abs() <= error {
        Fate::TooCloseToCall
    } else if beyond_exit < 0.0 {
        sticks(oscillator, &back, Some(1))
    } else {
        Fate::CrossesForever
    }
}

/// The mass sticks at `at`, moves with the belt and leaves it at the exit point.
fn sticks(oscillator: &Oscillator, at: &State, crossings: Option<u32>) -> Fate {
    let x1 = oscillator.exit_x1() + at.x1_offset();
    let stick_time = -at.x1_offset() / oscillator.belt_speed;
    Fate::Sticks(Landing { x1, slip_time: at.time, stick_time, crossings })
}

//! The fate of the orbit from the exit point by arcs of the Liénard form: below the belt line, and where the
//! orbit lands beyond the stick segment, above it.
//!
//! Next to grazing C* tells whether they return, see [`flow`](super::flow). Only these words are shared with the witness, which follows the same orbits in
//! (x1, x2) and judges them in audits.
//!
//! **After the landing.** With the drop j the orbit leaves the exit point e with x2' = -j. It arrives with
//! x2' = w, and sticks at e - w - j for w < 2 - j. Beyond that x2' above the line is w - 2 (1 - j), and the
//! orbit comes back there with x2' = W < 0. For W > -(2 - j) it sticks. Else it is beyond the exit point,
//! where it goes below the line outside its own first arc: orbits do not cross, so it never sticks (theory,
//! "Fates of an orbit").
//!
//! **Errors.** The place at which the orbit meets the belt line has the error `spread` over the speed there,
//! see [`arc`](super::arc). It is of first order, and no bound: where it exceeds `SMALL` it counts
//! `NOT_SMALL` times. A fate within the error of its boundary is followed again with a finer tolerance, down
//! to `FINEST`, and then [`Fate::TooCloseToCall`].

use super::arc::Extent;
use super::arc::{LowerEnd, State, Walk};
use super::work::Work;
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::{Failure, Fate, Flow, Landing};

/// The smallest tolerance that takes effect: below it the rounding of states decides.
pub(super) const FINEST: f64 = 1e-14;
/// Factor of the tolerance from one attempt to the next.
const FINER: f64 = 1e-2;
/// Largest tolerance of an orbit to its landing: next to grazing the landing speed magnifies its errors.
pub(super) const LANDING: f64 = 1e-12;
/// Errors up to this, in belt speeds, count once; larger ones are not of first order, and count more.
const SMALL: f64 = 1e-4;
const NOT_SMALL: f64 = 8.0;
/// Largest margin from which the landing speed follows, where the divergence at the belt line is small.
pub(super) const NEXT_TO_GRAZING: f64 = 1e-8;
/// Largest error of a margin that is told for an orbit that lands, relative to the margin.
const KNOWN: f64 = 0.01;
/// Largest ratio of the changes of D at equal distances beyond the belt line and before it: that of a pole
/// 1/(u + p)^2 at the distance 0.42 p.
const BEYOND: f64 = 4.0;

/// An orbit that changes neither x2 nor x2' by this share in [`STILL_STEPS`] steps is given up. Along a slow
/// curve a step of the length 2/|D| changes x2 by the share 2/D^2, so that this excludes |D| > 4500.
const STILL: f64 = 1e-4;
const STILL_STEPS: u32 = 1_000;

/// The arrival at the belt line from below.
#[derive(Clone, Copy, Debug, PartialEq)]
struct LandingSpeed {
    /// x2': the distance of the landing from the exit point.
    speed: f64,
    /// Estimate of its error.
    error: f64,
    /// Time since the exit point.
    time: f64,
}

/// The end of the orbit's first turn.
#[derive(Clone, Copy, Debug)]
enum FirstTurn {
    Returns(LandingSpeed),
    /// It does not return, or is too close to call.
    Stays(Fate),
}

/// An error with its weight in decisions.
fn weighed(error: f64, belt_speed: f64) -> f64 {
    if error > SMALL * belt_speed { NOT_SMALL * error } else { error }
}

/// What is called with the two ends of every step.
trait Visit: FnMut(&mut Walk, &State, &State) {}
impl<F: FnMut(&mut Walk, &State, &State)> Visit for F {}

/// The fate of the orbit from the exit point with the local errors `tolerance` V, and its margin, see
/// [`Flow::margin`]: of an orbit that lands it is told where it is small.
pub(super) fn flow(oscillator: &Oscillator, tolerance: f64, work: &Work) -> Flow {
    visited(oscillator, tolerance, work, &mut |_, _, _| ())
}

fn visited(oscillator: &Oscillator, tolerance: f64, work: &Work, visit: &mut impl Visit) -> Flow {
    let mut margin = [f64::NAN, 0.0];
    let fate = first_turn(oscillator, tolerance, work, &mut margin, visit)
        .map(|turn| match turn {
            FirstTurn::Returns(arrival) => after_landing(oscillator, arrival, tolerance, work, visit),
            FirstTurn::Stays(fate) => fate,
        })
        .unwrap_or_else(Fate::Failed);
    Flow { fate, margin: margin[0], margin_error: margin[1], rhs: 0 }
}

/// The fate of an orbit that returns, whose extent it finds; `None` next to grazing, where its margin has more digits, and where
/// it does not return.
pub(super) fn fate_away_from_grazing(
    oscillator: &Oscillator,
    tolerance: f64,
    extent: &mut Extent,
    work: &Work,
) -> Option<Fate> {
    let fate = refined(tolerance, |tolerance| {
        *extent = Extent::default();
        let mut visit = |walk: &mut Walk, from: &State, to: &State| extent.step(walk, from, to);
        visited(oscillator, tolerance, work, &mut visit).fate
    });
    let speed = match fate {
        Fate::Sticks(Landing { x1, crossings: Some(0), .. }) => oscillator.exit_x1() - x1 - oscillator.drop(),
        Fate::Sticks(_) | Fate::CrossesForever => oscillator.fastest_sticking(),
        Fate::SpiralsInward | Fate::TooCloseToCall | Fate::Failed(_) => return None,
    };
    let (s, d) = (speed / oscillator.belt_speed, oscillator.divergence(0.0));
    (0.5 * s * s * (1.0 + d * d) >= NEXT_TO_GRAZING).then_some(fate)
}

/// The fate of the orbit that is known to return with the `margin` > 0 and its error.
pub(super) fn fate_of_returning(
    oscillator: &Oscillator,
    margin: [f64; 2],
    tolerance: f64,
    work: &Work,
) -> Fate {
    refined(tolerance, |tolerance| {
        let arrival = landing(oscillator, margin, tolerance, work);
        let after = |at| after_landing(oscillator, at, tolerance, work, &mut |_, _, _| ());
        arrival.map(|arrival| arrival.map_or(Fate::TooCloseToCall, after)).unwrap_or_else(Fate::Failed)
    })
}

/// Reduces the tolerance while the fate is within its error of a boundary.
fn refined(tolerance: f64, mut follow: impl FnMut(f64) -> Fate) -> Fate {
    let mut tolerance = tolerance.min(LANDING);
    loop {
        let fate = follow(tolerance);
        if fate != Fate::TooCloseToCall || tolerance <= FINEST {
            return fate;
        }
        tolerance = (FINER * tolerance).max(FINEST);
    }
}

/// Follows the orbit below the belt line, and tells the margin with its error.
fn first_turn(
    oscillator: &Oscillator,
    tolerance: f64,
    work: &Work,
    margin: &mut [f64; 2],
    visit: &mut impl Visit,
) -> Result<FirstTurn, Failure> {
    let belt_speed = oscillator.belt_speed;
    let mut walk = leaving(oscillator, tolerance, work)?;
    let end = walk.lower_arc(patience(visit));
    margin[1] = walk.here.spread / (belt_speed * belt_speed);
    Ok(match end? {
        LowerEnd::Rests => {
            // Later maxima are below its distance from the equilibrium, up to `tolerance` V.
            *margin = [-1.0, margin[1] + tolerance];
            FirstTurn::Stays(Fate::SpiralsInward)
        }
        LowerEnd::Turns(end) => {
            let error = end.spread / end.v;
            *margin = [(end.v - belt_speed) / belt_speed, error / belt_speed];
            let is_clear = belt_speed - end.v > weighed(error, belt_speed);
            FirstTurn::Stays(if is_clear { Fate::SpiralsInward } else { Fate::TooCloseToCall })
        }
        LowerEnd::Meets(end) => {
            *margin = continued(oscillator, end.w, end.spread);
            // The height above the line to which the orbit would rise at least, and its error, times V.
            let damped = 1.0 + end.w * (-oscillator.divergence(0.0)).max(0.0) / belt_speed;
            let is_clear =
                0.5 * end.w * end.w > damped * weighed(end.spread / belt_speed, belt_speed) * belt_speed;
            match is_clear {
                true => FirstTurn::Returns(LandingSpeed::at(&end)),
                false => FirstTurn::Stays(Fate::TooCloseToCall),
            }
        }
    })
}

/// The margin, and its error, of an orbit that arrives with x2' = `speed`, continued beyond the belt line by
/// the lower field; NaN where the series does not give it to about [`KNOWN`].
///
/// In units of V, with s the speed: r = sqrt(1 + s^2) on the line, and r r' = D w^2. With D constant, w' + 1 =
/// D w up to the order s^2, so that ln r grows by D s^3 / 3 + D^2 s^4 / 4 + O(D^3 s^5) + O(D s^5) up to the
/// turn. Its change on s^2 / 2 beyond the line is taken to be at most [`BEYOND`] times that before it.
fn continued(oscillator: &Oscillator, speed: f64, spread: f64) -> [f64; 2] {
    let belt_speed = oscillator.belt_speed;
    let (s, d) = (speed / belt_speed, oscillator.divergence(0.0));
    let radius = s * s / (1.0 + s.hypot(1.0));
    let growth = s.powi(3) * d * (1.0 / 3.0 + 0.25 * d * s);
    let margin = radius + (1.0 + radius) * growth.exp_m1();
    let change = (oscillator.divergence(0.5 * belt_speed * s * s) - d).abs();
    let of_series = s.powi(3) * (d.abs() * (d * d + 1.0) * s * s + BEYOND * change);
    let error = spread / (belt_speed * belt_speed);
    if of_series <= KNOWN * radius { [margin, error + of_series] } else { [f64::NAN, error] }
}

/// The arrival of the orbit that is known to return with the `margin` > 0; `None` where the arcs lose it.
///
/// Next to grazing the margin has more digits than the orbit. On the last arc, of the angle a, the radius
/// grows by the factor 1 + D a^3 / 3 up to V (1 + m), and x2'^2 = r^2 - V^2 at its beginning: with a = sqrt(m
/// (2 + m)) the speed is V a (1 - D a / 3), up to the order a^3.
fn landing(
    oscillator: &Oscillator,
    [margin, margin_error]: [f64; 2],
    tolerance: f64,
    work: &Work,
) -> Result<Option<LandingSpeed>, Failure> {
    let belt_speed = oscillator.belt_speed;
    let end = leaving(oscillator, tolerance, work)?.lower_arc(patience(&mut |_, _, _| ()))?;
    let (angle, divergence) = ((margin * (2.0 + margin)).sqrt(), oscillator.divergence(0.0));
    let is_near = margin * (1.0 + divergence * divergence) < NEXT_TO_GRAZING;
    Ok(match end {
        LowerEnd::Meets(end) | LowerEnd::Turns(end) if is_near => {
            let speed = belt_speed * angle * (1.0 - angle * divergence / 3.0);
            let of_series = angle.powi(3) * (1.0 + divergence * divergence);
            let error = belt_speed * (margin_error * (1.0 + margin) / angle + of_series);
            Some(LandingSpeed { speed, error, time: end.time + (end.w - speed) / belt_speed })
        }
        LowerEnd::Meets(end) => Some(LandingSpeed::at(&end)),
        LowerEnd::Turns(_) | LowerEnd::Rests => None,
    })
}

impl LandingSpeed {
    fn at(end: &State) -> Self {
        Self { speed: end.w, error: end.spread / end.w, time: end.time }
    }
}

/// The orbit from the exit point, where rounding shows the friction that it meets.
fn leaving<'a>(oscillator: &'a Oscillator, tolerance: f64, work: &'a Work) -> Result<Walk<'a>, Failure> {
    if oscillator.curve.is_hidden_by_rounding(oscillator.belt_speed) {
        return Err(Failure::StepUnderflow);
    }
    let walk = Walk::from_line(oscillator, Side::Below, -oscillator.drop(), tolerance, work);
    Ok(walk.resting_at(tolerance * oscillator.belt_speed))
}

/// The fate of the orbit that arrives at the belt line.
fn after_landing(
    oscillator: &Oscillator,
    arrival: LandingSpeed,
    tolerance: f64,
    work: &Work,
    visit: &mut impl Visit,
) -> Fate {
    let (exit, belt_speed) = (oscillator.exit_x1(), oscillator.belt_speed);
    let sticks = |from_exit: f64, slip_time: f64, crossings: Option<u32>| {
        Fate::Sticks(Landing {
            x1: exit - from_exit,
            slip_time,
            stick_time: from_exit / belt_speed,
            crossings,
        })
    };
    let LandingSpeed { speed, error, time } = arrival;
    // A little beyond the stick segment the orbit crosses, and is back at once.
    let error = weighed(error, belt_speed);
    let (drop, fastest) = (oscillator.drop(), oscillator.fastest_sticking());
    let beyond = speed - fastest;
    if beyond < -error || drop == 0.0 && beyond <= error {
        return sticks(speed.min(fastest) + drop, time, (beyond < -error).then_some(0));
    }
    // With a drop it does not come back at once.
    if beyond <= error {
        return Fate::TooCloseToCall;
    }
    let rise = speed - oscillator.jump();
    let mut walk =
        Walk::from_line(oscillator, Side::Above, rise, tolerance, work).starting_with(arrival.error);
    let back = match walk.upper_arc(patience(visit)) {
        Ok(back) => back,
        Err(failure) => return Fate::Failed(failure),
    };
    let error = weighed(back.spread / -back.w, belt_speed);
    let beyond_exit = -(back.w + fastest);
    if beyond_exit.abs() <= error {
        Fate::TooCloseToCall
    } else if beyond_exit < 0.0 {
        sticks(-beyond_exit, time + back.time, Some(1))
    } else {
        Fate::CrossesForever
    }
}

/// Gives up an orbit that hardly moves.
fn patience(visit: &mut impl Visit) -> impl Visit {
    let (mut mark, mut still) = ([f64::NAN; 2], 0);
    move |walk: &mut Walk, from: &State, to: &State| {
        let here = [to.v, to.w];
        let is_still =
            here.iter().zip(mark).all(|(now, then): (&f64, f64)| (now - then).abs() <= STILL * then.abs());
        (mark, still) = if is_still { (mark, still + 1) } else { (here, 0) };
        if still > STILL_STEPS {
            walk.give_up();
        }
        visit(walk, from, to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::Piece;

    /// Jump of x2' across the belt line without a drop.
    const JUMP: f64 = 2.0;
    use slipmap_model::friction::Law;
    use std::f64::consts::PI;

    const TOLERANCES: [f64; 4] = [1e-6, 1e-9, 1e-12, FINEST];
    const SPEEDS: [f64; 5] = [0.1, 1.0, 10.0, 100.0, 1e4];

    /// Constant friction, with the divergence `d` = -eps c, also positive.
    fn linear(d: f64, belt_speed: f64) -> Oscillator {
        let point = Law::Stribeck.point(1.0, &[1.0, 0.0, 0.0], belt_speed, 0.0).unwrap();
        Oscillator { viscous: -d, ..Oscillator::new(&Law::Stribeck, &point) }
    }

    /// An arc of v'' - D v' + v = 0 from (V, `w`) back to the line, where w is returned: below the line for w
    /// <= 0, above it for w > 0. |D| < 2.
    fn arc(d: f64, belt_speed: f64, w: f64) -> f64 {
        let h = 0.5 * d;
        let omega = (1.0 - h * h).sqrt();
        let at = |t: f64| {
            let (sin, cos) = (omega * t).sin_cos();
            let grown = (h * t).exp();
            let v = grown * (belt_speed * cos + (w - h * belt_speed) / omega * sin);
            [v - belt_speed, grown * (w * cos + (h * w - belt_speed) / omega * sin)]
        };
        // The extremum of the arc, and the next one.
        let first = w.atan2((belt_speed - h * w) / omega).rem_euclid(PI) / omega;
        let first = if w == 0.0 { PI / omega } else { first };
        let (mut low, mut high) = (first, first + PI / omega);
        let side = at(low)[0].signum();
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            *(if at(middle)[0].signum() == side { &mut low } else { &mut high }) = middle;
        }
        at(low)[1]
    }

    #[test]
    fn landings_of_constant_divergence_are_within_their_error() {
        for d in [0.01, 0.1, 0.5, 1.0, 1.9] {
            for belt_speed in SPEEDS {
                let oscillator = linear(d, belt_speed);
                let up = arc(d, belt_speed, 0.0);
                // Roundings of the closed form.
                let rounding = 1e-14 * (belt_speed + up) * (1.0 + belt_speed / up);
                for tolerance in TOLERANCES {
                    let work = Work::of(Piece::Fate, &oscillator.curve);
                    let turn = first_turn(&oscillator, tolerance, &work, &mut [0.0; 2], &mut |_, _, _| ());
                    let FirstTurn::Returns(found) = turn.unwrap() else { panic!("{oscillator:?}") };
                    let off = (found.speed - up).abs();
                    let context = format!("{d} {belt_speed} {tolerance:e}: {found:?}, off by {off:e}");
                    assert!(off <= found.error + rounding, "{context}");
                    // A turn magnifies errors by exp(pi D / omega), and the slope at the landing by V / w.
                    let most = 100.0 * tolerance.max(1e-13) * (belt_speed + up) * (1.0 + belt_speed / up);
                    assert!(found.error <= most * (d * PI / (1.0 - 0.25 * d * d).sqrt()).exp(), "{context}");
                    let Flow { fate, .. } = crate::flow(&oscillator, tolerance);
                    let down = if up > JUMP { arc(d, belt_speed, up - JUMP) } else { 0.0 };
                    let from_exit = if up > JUMP { JUMP + down } else { up };
                    match fate {
                        Fate::Sticks(landing) => {
                            assert_eq!(landing.crossings, Some(u32::from(up > JUMP)), "{context}");
                            let off = (oscillator.exit_x1() - landing.x1 - from_exit).abs();
                            assert!(off <= 10.0 * found.error + rounding, "{context} {landing:?}");
                        }
                        fate => assert!(fate == Fate::CrossesForever && down < -JUMP, "{context} {fate:?}"),
                    }
                }
            }
        }
    }

    #[test]
    fn turns_of_constant_divergence_are_within_their_error() {
        let flow = |oscillator: &Oscillator, tolerance: f64| {
            flow(oscillator, tolerance, &Work::of(Piece::Fate, &oscillator.curve))
        };
        for d in [-1e-6, -0.01, -0.5, -1.0, -1.9] {
            let exact = (PI * d / (1.0 - 0.25 * d * d).sqrt()).exp_m1();
            for belt_speed in SPEEDS {
                for tolerance in TOLERANCES {
                    let found = flow(&linear(d, belt_speed), tolerance);
                    let off = (found.margin - exact).abs();
                    assert!(off <= found.margin_error, "{d} {belt_speed} {tolerance:e}: {found:?} {off:e}");
                    let is_clear = -exact > 2.0 * found.margin_error;
                    assert!(found.fate == Fate::SpiralsInward || !is_clear, "{d}: {found:?}");
                }
            }
        }
        // Nodes have no later maximum; a stiff one is given up.
        for d in [-2.0, -3.0, -1e3] {
            let found = crate::flow(&linear(d, 1.0), 1e-9);
            assert_eq!((found.fate, found.margin), (Fate::SpiralsInward, -1.0), "{d}");
        }
        assert_eq!(crate::flow(&linear(0.0, 1.0), 1e-9).fate, Fate::TooCloseToCall);
        assert_eq!(flow(&linear(1e7, 1.0), 1e-9).fate, Fate::Failed(Failure::Quota));
    }
}

//! The return map of the lower flow: one turn of the orbit from the exit point, in the polar form, eight
//! orbits side by side.
//!
//! The sign of the grazing margin m/V = delta(2 pi) is the verdict: negative, the orbit closes inside
//! itself; positive, it comes back to the belt line (theory, section 3). No event is located for that.

use std::sync::{LazyLock, OnceLock};

use super::dop853::{Field, NODES, STAGES, step};
use super::landing::{Approach, Arrival, approach};
use super::polar::{Angle, LANES, Lanes};
use super::{Fate, Flow, Landing, direct, general};
use crate::filippov::Oscillator;
use crate::friction::{Column, Curve};
use crate::point::ScaledGroups;

/// Numbers of equal steps per turn, coarse to fine. Lanes of one vector share their angles, so their
/// sines come from one table per rung.
const LADDER: [usize; 13] = [4, 6, 8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256];

/// Error of a turn in units of its distance from the turn one rung below. The method has order 8 and a
/// rung is at most 3/4 of the next, so the distance is asymptotically at least ten times the error; coarse
/// rungs are far from asymptotic, and three times the distance is kept.
const ERROR_PER_DISTANCE: f64 = 3.0;

/// Share of the embedded error estimate (of lower order, hence pessimistic) that is added, so that a chance
/// agreement of two coarse turns is not taken for accuracy.
const ERROR_PER_EMBEDDED: f64 = 0.1;

/// A turn that leaves the domain of the polar form on a rung below this one is tried again on it: coarse
/// steps may stray out of a domain in which the orbit itself stays.
const RETRY_RUNG: usize = 6;

/// The answer of one turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// The orbit turned once around.
    Complete {
        /// m / V.
        margin: f64,
        /// Estimate of the absolute error of the margin.
        error: f64,
        /// Evaluations of the right-hand side, failed attempts included.
        rhs: u32,
    },
    /// The polar form does not apply (an overdamped node, or an orbit that runs far past the belt line),
    /// or the finest step misses the tolerance.
    HandOver {
        /// Evaluations spent to find that out.
        rhs: u32,
    },
}

/// Angles at the stages of every step of a rung.
fn angles(rung: usize) -> &'static [[Angle; STAGES]] {
    static TABLES: LazyLock<Vec<OnceLock<Vec<[Angle; STAGES]>>>> =
        LazyLock::new(|| LADDER.iter().map(|_| OnceLock::new()).collect());
    TABLES[rung].get_or_init(|| {
        let steps = LADDER[rung];
        let h = std::f64::consts::TAU / steps as f64;
        (0..steps).map(|i| std::array::from_fn(|stage| Angle::new((i as f64 + NODES[stage]) * h))).collect()
    })
}

/// The polar field within one step.
struct Polar<'a> {
    lanes: &'a Lanes,
    angles: &'a [Angle; STAGES],
    room: &'a mut [f64; LANES],
}

impl Field<LANES> for Polar<'_> {
    #[inline(always)]
    fn slope(&mut self, stage: usize, delta: &[f64; LANES]) -> [f64; LANES] {
        self.lanes.slope(self.angles[stage], delta, self.room)
    }
}

/// What one turn yields in each lane.
struct Lap {
    /// The margin m / V.
    delta: [f64; LANES],
    /// Sum of the local error estimates.
    error: [f64; LANES],
    /// Room inside the domain of the polar form, see [`Lanes::slope`].
    room: [f64; LANES],
}

/// One turn of [`LANES`] orbits.
#[inline(always)]
fn turn(lanes: &Lanes, angles: &[[Angle; STAGES]]) -> Lap {
    let h = std::f64::consts::TAU / angles.len() as f64;
    let mut delta = [0.0; LANES];
    let mut total = [0.0; LANES];
    let mut room = [f64::INFINITY; LANES];
    for angles in angles {
        let mut field = Polar { lanes, angles, room: &mut room };
        let (next, error) = step(h, &delta, &mut field);
        delta = next;
        for (sum, e) in total.iter_mut().zip(error) {
            *sum += e;
        }
    }
    Lap { delta, error: total, room }
}

/// Carries [`turn`] into the function whose vector width pulp picks at run time.
struct Dispatched<'a> {
    lanes: &'a Lanes,
    angles: &'a [[Angle; STAGES]],
}

impl pulp::WithSimd for Dispatched<'_> {
    type Output = Lap;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Lap {
        turn(self.lanes, self.angles)
    }
}

/// The rung to try first, from the size of the divergence and how fast it changes along the orbit. Fitted
/// by counting evaluations over random points; a wrong guess costs one more turn, not accuracy.
fn first_rung(groups: &ScaledGroups, tolerance: f64) -> usize {
    let strength = groups.divergence(0.0).abs().max(groups.divergence(2.0).abs());
    let steps = 0.9 * (1.0 + groups.k).sqrt() * (strength / tolerance).powf(0.125);
    LADDER.iter().position(|&n| n as f64 >= steps).unwrap_or(LADDER.len() - 2).min(LADDER.len() - 2)
}

/// Round-off of a turn: each of the steps adds an increment with a few roundings, relative to the state's
/// size so far, which the margin itself and the divergence bound.
fn round_off(delta: f64, groups: &ScaledGroups) -> f64 {
    let size = delta.abs().max(groups.divergence(0.0).abs()).max(groups.divergence(2.0).abs());
    16.0 * f64::EPSILON * size
}

/// Margins of many orbits, each with its error estimate at most `tolerance` where that can be had.
///
/// An orbit's answer does not depend on its neighbours in the slice, nor on the machine's vector width.
pub fn turns(groups: &[ScaledGroups], tolerance: f64) -> Vec<Turn> {
    let arch = pulp::Arch::new();
    let mut answers = vec![Turn::HandOver { rhs: 0 }; groups.len()];
    let mut waiting: [Vec<usize>; LADDER.len()] = Default::default();
    for (orbit, groups) in groups.iter().enumerate() {
        waiting[first_rung(groups, tolerance)].push(orbit);
    }
    for rung in 0..LADDER.len() {
        for orbits in std::mem::take(&mut waiting[rung]).chunks(LANES) {
            let lanes = Lanes::new(|lane| &groups[orbits[lane.min(orbits.len() - 1)]]);
            let lap = arch.dispatch(Dispatched { lanes: &lanes, angles: angles(rung) });
            for (lane, &orbit) in orbits.iter().enumerate() {
                let rung_cost = (STAGES * LADDER[rung]) as u32;
                let margin = lap.delta[lane];
                let inside = lap.room[lane] > 0.0 && margin.is_finite();
                let (rhs, error) = match answers[orbit] {
                    Turn::HandOver { rhs } => (rhs, f64::INFINITY),
                    Turn::Complete { margin: coarser, rhs, .. } => (
                        rhs,
                        ERROR_PER_DISTANCE * (margin - coarser).abs() + ERROR_PER_EMBEDDED * lap.error[lane],
                    ),
                };
                let rhs = rhs + rung_cost;
                let next = if inside {
                    answers[orbit] =
                        Turn::Complete { margin, error: error + round_off(margin, &groups[orbit]), rhs };
                    if error <= tolerance { LADDER.len() } else { rung + 1 }
                } else {
                    answers[orbit] = Turn::HandOver { rhs };
                    if rung < RETRY_RUNG { RETRY_RUNG } else { LADDER.len() }
                };
                if next < LADDER.len() {
                    waiting[next].push(orbit);
                }
            }
        }
    }
    answers
}

/// Margins of one column's orbits at the dampings `cs`, see [`turns`]; one by one for laws other than
/// Stribeck's.
#[must_use]
pub fn turns_of(column: &Column, cs: &[f64], tolerance: f64) -> Vec<Turn> {
    let at = |&c: &f64| Oscillator::in_column(column, c);
    match &column.curve {
        Curve::Stribeck(law) => {
            let scaled = |c| law.scaled(column.belt_speed, at(c).viscous);
            turns(&cs.iter().map(scaled).collect::<Vec<_>>(), tolerance)
        }
        Curve::Exponential(_) | Curve::Lorentzian(_) | Curve::Expression(_) | Curve::Table(_) => {
            cs.iter().map(|c| general::turn(&at(c), tolerance)).collect()
        }
    }
}

/// One turn of one orbit.
fn turn_of(oscillator: &Oscillator, tolerance: f64) -> Turn {
    match &oscillator.curve {
        Curve::Stribeck(law) => turns(&[law.scaled(oscillator.belt_speed, oscillator.viscous)], tolerance)[0],
        Curve::Exponential(_) | Curve::Lorentzian(_) | Curve::Expression(_) | Curve::Table(_) => {
            general::turn(oscillator, tolerance)
        }
    }
}

/// The smallest tolerance worth asking for: round-off takes over.
const FINEST_TOLERANCE: f64 = 1e-16;

/// One turn of one orbit, at tolerances down to [`FINEST_TOLERANCE`] until the margin's sign is certain.
fn decisive_turn(oscillator: &Oscillator, tolerance: f64) -> Turn {
    let mut tolerance = tolerance;
    let mut spent = 0;
    loop {
        match turn_of(oscillator, tolerance) {
            Turn::Complete { margin, error, rhs } => {
                spent += rhs;
                if margin.abs() > error || tolerance <= FINEST_TOLERANCE {
                    return Turn::Complete { margin, error, rhs: spent };
                }
                // The margin's size is now known to be about `error` or less.
                tolerance = (1e-3 * tolerance).max(FINEST_TOLERANCE);
            }
            Turn::HandOver { rhs } => return Turn::HandOver { rhs: spent + rhs },
        }
    }
}

/// What becomes of the orbit from the exit point, by the return map; handed over to
/// [`direct::flow`] where the polar form does not apply or the orbit lands beyond the stick segment.
///
/// `tolerance` bounds the error of the scaled grazing margin m/V and of the landing.
#[must_use]
pub fn flow(oscillator: &Oscillator, tolerance: f64) -> Flow {
    let turn = decisive_turn(oscillator, tolerance);
    let (margin, margin_error, rhs) = match turn {
        Turn::Complete { margin, error, rhs } => (margin, error, rhs),
        Turn::HandOver { rhs } => {
            let answer = direct::flow(oscillator, tolerance);
            return Flow { rhs: u64::from(rhs) + answer.rhs, ..answer };
        }
    };
    let mut rhs = u64::from(rhs);
    let answer = |fate, rhs| Flow { fate, margin, margin_error, rhs };
    if margin < -margin_error {
        return answer(Fate::SpiralsInward, rhs);
    }
    if margin.abs() <= margin_error {
        return answer(Fate::TooCloseToCall, rhs);
    }
    match approach(oscillator, tolerance, &mut rhs) {
        Approach::Arrives(Arrival { speed, time }) if speed < 2.0 => {
            let landing = Landing {
                x1: oscillator.exit_x1() - speed,
                slip_time: time,
                stick_time: speed / oscillator.belt_speed,
                crossings: 0,
            };
            answer(Fate::Sticks(landing), rhs)
        }
        Approach::Arrives(_) | Approach::StaysBelow | Approach::NoAnswer => {
            let direct = direct::flow(oscillator, tolerance);
            answer(direct.fate, rhs + direct.rhs)
        }
    }
}

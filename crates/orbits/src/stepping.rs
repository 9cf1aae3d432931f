//! One turn of many orbits of Stribeck's law by equal steps in the polar angle, eight orbits together, far
//! from the circle: 3 microseconds a turn there, where the steps of [`super::turn`], for any law,
//! take some 45.

use std::sync::{LazyLock, OnceLock};

use super::dop853::{Field, NODES, STAGES, step};
use super::polar::{Angle, LANES, Lanes, Turn, Vector};
use slipmap_model::point::ScaledGroups;
use slipmap_numbers::vectorized;

/// Numbers of equal steps per turn, coarse to fine. The lanes of a vector share their angles, so their sines
/// come from one table per rung.
const LADDER: [usize; 11] = [8, 12, 16, 24, 32, 48, 64, 96, 128, 192, 256];

/// Error of a turn in units of its distance from the turn one rung below. The method has order 8 and a rung
/// is at most 3/4 of the next, so the distance is asymptotically at least nine times the error; coarse rungs
/// are far from asymptotic, and six times the distance is used.
const ERROR_PER_DISTANCE: f64 = 6.0;

/// Share of the embedded error estimate (of lower order, hence pessimistic) that is added, so that a chance
/// agreement of two coarse turns is not taken for accuracy.
const ERROR_PER_EMBEDDED: f64 = 0.5;

/// Number of steps per turn that resolves the pole of the divergence, sqrt(2 / k) from the start, in units of
/// sqrt(1 + k).
const STEPS_PER_POLE: f64 = 8.0;

/// A turn that leaves the domain of the polar form on a rung below this one is repeated on it: coarse steps
/// may leave a domain in which the orbit itself stays.
const RETRY_RUNG: usize = 4;

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
    room: &'a mut Vector,
}

impl Field<LANES> for Polar<'_> {
    #[inline(always)]
    fn slope(&mut self, stage: usize, delta: &Vector) -> Vector {
        self.lanes.slope(self.angles[stage], delta, self.room)
    }
}

/// The result of one turn in each lane.
struct Lap {
    /// The margin m / V.
    delta: Vector,
    /// Sum of the local error estimates.
    error: Vector,
    /// Distance from the border of the domain of the polar form, see [`Lanes::slope`].
    room: Vector,
}

/// One turn of [`LANES`] orbits.
#[inline(always)]
fn turn(lanes: &Lanes, angles: &[[Angle; STAGES]]) -> Lap {
    let h = std::f64::consts::TAU / angles.len() as f64;
    let mut delta = Vector::default();
    let mut total = Vector::default();
    let mut room = Vector::all(f64::INFINITY);
    for angles in angles {
        let mut field = Polar { lanes, angles, room: &mut room };
        let (next, error) = step(h, &delta, &mut field);
        delta = next;
        for lane in 0..LANES {
            total[lane] += error[lane];
        }
    }
    Lap { delta, error: total, room }
}

/// The rung to try first, from the size of the divergence and its rate of change along the orbit. Fitted by
/// counting evaluations over random points; a wrong guess costs one more turn, not accuracy. `None` where no
/// rung resolves the pole of the divergence: then the estimate is not reliable either.
fn first_rung(groups: &ScaledGroups, tolerance: f64) -> Option<usize> {
    let strength = groups.divergence(0.0).abs().max(groups.divergence(2.0).abs());
    let pole = (1.0 + groups.k).sqrt();
    let fewest = STEPS_PER_POLE * pole;
    if !(fewest <= LADDER[LADDER.len() - 1] as f64) {
        return None;
    }
    let steps = fewest.max(0.9 * pole * (strength / tolerance).powf(0.125));
    Some(LADDER.iter().position(|&n| n as f64 >= steps).unwrap_or(LADDER.len() - 2).min(LADDER.len() - 2))
}

/// Round-off of a turn: each of the steps adds an increment with a few roundings, relative to the state's
/// size so far, which the margin itself and the divergence bound.
fn round_off(delta: f64, groups: &ScaledGroups) -> f64 {
    let size = delta.abs().max(groups.divergence(0.0).abs()).max(groups.divergence(2.0).abs());
    16.0 * f64::EPSILON * size
}

/// Margins of many orbits, each with an error estimate of at most `tolerance` where that can be reached.
///
/// An orbit's answer does not depend on its neighbours in the slice, nor on the machine's vector width.
pub(super) fn turns(groups: &[ScaledGroups], tolerance: f64) -> Vec<Turn> {
    let mut answers = vec![Turn::HandOver { rhs: 0 }; groups.len()];
    let mut waiting: [Vec<usize>; LADDER.len()] = Default::default();
    for (orbit, groups) in groups.iter().enumerate() {
        if let Some(rung) = first_rung(groups, tolerance) {
            waiting[rung].push(orbit);
        }
    }
    for rung in 0..LADDER.len() {
        for orbits in std::mem::take(&mut waiting[rung]).chunks(LANES) {
            let lanes = Lanes::new(|lane| groups[orbits[lane.min(orbits.len() - 1)]]);
            let lap = vectorized(
                #[inline(always)]
                || turn(&lanes, angles(rung)),
            );
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

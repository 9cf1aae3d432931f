//! The amplitudes at which closed orbits begin to reach the corners of a law.
//!
//! A slip cycle covers the slip speeds from V - r to V + d, with its lowest velocity x2 = -d. It reaches a corner below V
//! from r = V - corner on, and one above V from the amplitude on at which d = corner - V. Just above such an amplitude C(r)
//! is a series in the root of the distance from it, for the part of the orbit beyond the corner lasts as long as that root
//! is large; between two of them it is smooth.

use super::super::Failure;
use super::super::arc::Walk;
use super::Solver;
use crate::filippov::{Oscillator, Side};

/// Largest number of corners that an orbit can reach: more of them lie so close together that C is smooth on the scale of
/// the others.
const MOST: usize = 40;
/// Accuracy of an amplitude, relative to V: what is not smooth within it is smaller by several powers of it.
const ACCURACY: f64 = 1e-6;
/// Largest number of orbits to find one.
const MOST_ORBITS: u32 = 12;
/// Error of these orbits.
const TOLERANCE: f64 = 1e-8;

/// These amplitudes between 0 and V, increasing; none where they are too many.
pub(super) fn corner_amplitudes(solver: &mut Solver) -> Result<Vec<f64>, Failure> {
    let belt_speed = solver.belt_speed;
    let corners = solver.curve.corners();
    if corners.is_empty() {
        return Ok(Vec::new());
    }
    let deepest = depth(solver, belt_speed)?;
    let below = corners.iter().filter(|corner| **corner < belt_speed).map(|corner| belt_speed - corner);
    let above: Vec<f64> =
        corners.iter().map(|corner| corner - belt_speed).filter(|&d| d > 0.0 && d < deepest).collect();
    let mut amplitudes: Vec<f64> = below.collect();
    if amplitudes.len() + above.len() > MOST {
        return Ok(Vec::new());
    }
    for wanted in above {
        // The depth is nearly proportional to the amplitude.
        let mut amplitude = belt_speed * wanted / deepest;
        for _ in 0..MOST_ORBITS {
            let next = (amplitude * wanted / depth(solver, amplitude)?).min(belt_speed);
            let step = (next - amplitude).abs();
            amplitude = next;
            if step <= ACCURACY * belt_speed {
                break;
            }
        }
        amplitudes.push(amplitude);
    }
    let inside = |amplitude: &f64| *amplitude > ACCURACY * belt_speed && *amplitude < belt_speed;
    amplitudes.retain(inside);
    amplitudes.sort_by(f64::total_cmp);
    amplitudes.dedup_by(|next, last| *next - *last <= ACCURACY * belt_speed);
    Ok(amplitudes)
}

/// -x2 at the lowest point of the closed orbit of an amplitude.
fn depth(solver: &mut Solver, amplitude: f64) -> Result<f64, Failure> {
    let viscous = solver.at(&[amplitude])?[0];
    let oscillator = Oscillator { curve: solver.curve.clone(), viscous, belt_speed: solver.belt_speed };
    // Steps need not end at corners, which is hard where the orbit only touches one.
    let mut walk = Walk::new(&oscillator, Side::Below, [amplitude, 0.0], TOLERANCE, amplitude, solver.work)
        .stopping_at(&[]);
    let mut lowest = 0.0;
    walk.lower_arc(|walk, from, to| {
        if from.w < 0.0 && to.w >= 0.0 {
            lowest = walk.locate(from, to.time - from.time, |_, state| state.w).v;
        }
    })?;
    Ok(-lowest)
}

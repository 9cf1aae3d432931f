//! The amplitudes at which closed orbits begin to reach the corners of a law.
//!
//! A slip cycle covers the slip speeds from V - r to V + d, where -d is its lowest velocity x2. It reaches a
//! corner below V from r = V - corner on, and one above V from the amplitude on at which d = corner - V. Just
//! above such an amplitude C(r) is a series in the square root of the distance from it, because the time that
//! the orbit spends beyond the corner is proportional to that root. Between two such amplitudes C is smooth.

use super::panel::Solver;
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::Failure;
use slipmap_orbits::Closing;
use slipmap_orbits::arc::Walk;
use slipmap_orbits::elements::{Closed, closed_orbit};

/// Largest number of corners at which C is cut. More of them lie so close together that C is smooth on the
/// scale of the others.
const MOST: usize = 40;
/// Least error of an amplitude, relative to V.
const FINEST: f64 = 1e-6;
/// Largest number of orbits to find one amplitude.
const MOST_ORBITS: u32 = 12;
/// Number of known orbits from which an amplitude is guessed.
const NEAREST: usize = 4;
/// Tolerance of orbits that are followed to find their depth.
const TOLERANCE: f64 = 1e-8;

/// An amplitude with its orbit.
pub(super) type End = (f64, Closing);

/// The corner amplitudes between 0 and V, increasing, followed by V; `None` where there are none or too many.
pub(super) fn corner_amplitudes(solver: &mut Solver) -> Result<Option<Vec<End>>, Failure> {
    let belt_speed = solver.belt_speed;
    // At a distance d beyond a corner the change of C is of the order d^(3/2).
    let accuracy = belt_speed * (0.1 * solver.tolerance.powf(2.0 / 3.0)).max(FINEST);
    let corners = solver.curve.stops(belt_speed);
    if corners.is_empty() {
        return Ok(None);
    }
    let (at_belt_speed, deepest) = orbit(solver, belt_speed)?;
    let below = corners.iter().map(|corner| belt_speed - corner).filter(|amplitude| *amplitude > 0.0);
    let below: Vec<f64> = below.collect();
    let depths = corners.iter().map(|corner| corner - belt_speed).filter(|d| *d > 0.0 && *d < deepest);
    let depths: Vec<f64> = depths.collect();
    if below.len() + depths.len() > MOST {
        return Ok(None);
    }
    let mut ends: Vec<End> = below.iter().copied().zip(solver.at(&below)?).collect();
    // Depths, each with the ratio of amplitude to depth, which changes little and is 1 for small orbits.
    let mut known = vec![(0.0, 1.0), (deepest, belt_speed / deepest)];
    for wanted in depths {
        let others = known.len();
        let mut found = (belt_speed, at_belt_speed);
        for _ in 0..MOST_ORBITS {
            let amplitude = amplitude_at(&known, wanted);
            let (closed, depth) = orbit(solver, amplitude)?;
            found = (amplitude, closed);
            known.truncate(others);
            known.push((depth, amplitude / depth));
            if (depth - wanted).abs() <= accuracy {
                break;
            }
        }
        ends.push(found);
    }
    ends.retain(|(amplitude, _)| *amplitude > accuracy && *amplitude < belt_speed - accuracy);
    ends.sort_by(|one, other| one.0.total_cmp(&other.0));
    ends.dedup_by(|next, last| next.0 - last.0 <= accuracy);
    if ends.is_empty() {
        return Ok(None);
    }
    ends.push((belt_speed, at_belt_speed));
    Ok(Some(ends))
}

/// Estimates the amplitude of a depth: by the polynomial through the nearest ratios or, where that lies
/// outside the amplitudes of the two nearest depths, by the line between them.
fn amplitude_at(known: &[(f64, f64)], depth: f64) -> f64 {
    let nearest = |is_there: &dyn Fn(f64) -> bool| {
        let there = known.iter().filter(|pair| is_there(pair.0));
        there.min_by(|one, other| (one.0 - depth).abs().total_cmp(&(other.0 - depth).abs()))
    };
    let guess = depth * ratio_at(known.to_vec(), depth);
    let (Some(low), Some(high)) = (nearest(&|it| it < depth), nearest(&|it| it >= depth)) else {
        return guess;
    };
    let [from, to] = [low, high].map(|(depth, ratio)| depth * ratio);
    if from < guess && guess <= to { guess } else { from + (to - from) * (depth - low.0) / (high.0 - low.0) }
}

/// The value at `depth` of the polynomial through the nearest of the known pairs, by Neville's scheme.
fn ratio_at(mut known: Vec<(f64, f64)>, depth: f64) -> f64 {
    known.sort_by(|one, other| (one.0 - depth).abs().total_cmp(&(other.0 - depth).abs()));
    let near = &known[..known.len().min(NEAREST)];
    let mut values: Vec<f64> = near.iter().map(|pair| pair.1).collect();
    for order in 1..near.len() {
        for i in 0..near.len() - order {
            let (from, to) = (near[i].0, near[i + order].0);
            values[i] = ((to - depth) * values[i] + (depth - from) * values[i + 1]) / (to - from);
        }
    }
    values[0]
}

/// The closed orbit of an amplitude, and its depth: -x2 at its lowest point.
fn orbit(solver: &mut Solver, amplitude: f64) -> Result<(Closing, f64), Failure> {
    let weakening = solver.curve.compiled(4.0 * solver.belt_speed);
    if let Ok(Closed { closing, depth }) =
        closed_orbit(&weakening, solver.belt_speed, amplitude, solver.tolerance)
    {
        solver.work.spend_compiled(closing.rhs)?;
        (solver.rhs, solver.error) = (solver.rhs + closing.rhs, solver.error.max(closing.error));
        return Ok((closing, depth));
    }
    let closing = solver.at(&[amplitude])?[0];
    Ok((closing, depth(solver, amplitude, closing.viscous)?))
}

/// The depth of the orbit of an amplitude at this C.
fn depth(solver: &Solver, amplitude: f64, viscous: f64) -> Result<f64, Failure> {
    let oscillator = Oscillator { curve: solver.curve.clone(), viscous, belt_speed: solver.belt_speed };
    // Steps need not end at corners, which is hard where the orbit only touches one.
    let mut walk = Walk::new(&oscillator, Side::Below, [amplitude, 0.0], TOLERANCE, amplitude, solver.work)
        .stopping_at(&[]);
    let mut lowest = 0.0;
    walk.lower_arc(|walk, from, to| {
        if from.w < 0.0 && to.w >= 0.0 {
            lowest = walk.locate(from, to, |_, state| [state.w, state.slope()]).v;
        }
    })?;
    Ok(-lowest)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_numbers::random::Random;

    /// Amplitudes are guessed between those of the nearest depths, also where the polynomial through some
    /// ratios leads below 0.
    #[test]
    fn guesses_stay_between_the_nearest_known_amplitudes() {
        let mut random = Random(95);
        let mut corrected = 0;
        for _ in 0..1_000 {
            let (mut depth, mut amplitude) = (0.0, 0.0);
            let mut known = vec![(0.0, 1.0)];
            for _ in 0..4 {
                depth += random.unit().max(1e-3);
                amplitude += random.unit().max(1e-3);
                known.push((depth, amplitude / depth));
            }
            let wanted = depth * random.unit().max(1e-6);
            let above = known.partition_point(|pair| pair.0 < wanted);
            let [low, high] = [known[above - 1], known[above]].map(|(depth, ratio)| depth * ratio);
            let found = amplitude_at(&known, wanted);
            assert!(low < found && found <= high, "{known:?} {wanted}: {found}");
            corrected += u32::from(!(wanted * ratio_at(known.clone(), wanted) > 0.0));
        }
        assert!(corrected > 10, "{corrected}");
    }
}

//! The return map of the lower flow: one turn of the orbit from the exit point, for many orbits together.
//! Orbits near the circle use the few evaluations of `collocation`, the others the steps of `stepping`.
//!
//! The sign of the grazing margin m/V = delta(2 pi) is the verdict: negative, the orbit closes inside itself;
//! positive, it returns to the belt line (theory, "Two forms of the slip flow"). No event needs to be
//! located.

pub use super::polar::Turn;

use super::arc::Extent;
use super::{collocation, exit_orbit, stepping, turn};
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::{Fate, Flow};
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
pub fn turns_of_orbits<'a>(
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
pub fn turn_of(oscillator: &Oscillator, tolerance: f64) -> Turn {
    let Oscillator { curve, viscous, belt_speed } = oscillator;
    if let Some(law) = curve.stribeck() {
        return turns(&[law.scaled(*belt_speed, *viscous)], tolerance)[0];
    }
    if curve.is_hidden_by_rounding(*belt_speed) {
        return Turn::HandOver { rhs: 0 };
    }
    turn::turn(oscillator, tolerance)
}

/// The smallest useful tolerance, for divergences of the size 1: below it round-off dominates.
const FINEST_TOLERANCE: f64 = 1e-16;
/// The largest tolerance by which one orbit is decided: coarser turns may agree by chance, and a column has
/// few such orbits.
const COARSEST_DECISIVE: f64 = 1e-9;

/// A larger error of the margin is accepted only up to `UNRESOLVED_SHARE` of the margin: the finest steps do
/// not resolve the orbit, and their error estimate is not asymptotic.
pub const UNRESOLVED: f64 = 1e-8;
const UNRESOLVED_SHARE: f64 = 0.01;

/// Returns whether the margin's sign can be trusted, if it exceeds its error.
pub fn is_resolved(margin: f64, error: f64) -> bool {
    error <= UNRESOLVED || error <= UNRESOLVED_SHARE * margin.abs()
}

/// One turn of one orbit, at tolerances down to [`FINEST_TOLERANCE`] by the size of the divergence until the
/// margin's sign is certain.
fn decisive_turn(oscillator: &Oscillator, tolerance: f64) -> Turn {
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
                tolerance = (1e-3 * tolerance).min(error).max(finest());
            }
            Turn::HandOver { rhs } => return Turn::HandOver { rhs: spent + rhs },
        }
    }
}

/// As [`flow`], where a turn at this tolerance gave `margin`, NaN if it was handed over.
pub fn flow_after_turn(oscillator: &Oscillator, margin: f64, tolerance: f64) -> Flow {
    // At a coarse tolerance the finer turn that decides may be complete.
    if margin.is_nan() && tolerance <= COARSEST_DECISIVE {
        exit_orbit::decisive_flow(oscillator, tolerance)
    } else {
        flow(oscillator, tolerance)
    }
}

/// The fate of an orbit that is known to return to the belt line, with its extent: next to grazing alone it needs a turn.
pub fn fate_and_extent(oscillator: &Oscillator, tolerance: f64) -> (Fate, Extent) {
    let mut extent = Extent::default();
    let away = exit_orbit::fate_away_from_grazing(oscillator, tolerance, &mut extent);
    (away.unwrap_or_else(|| flow(oscillator, tolerance).fate), extent)
}

/// The fate of the orbit from the exit point: by the return map, and by the arcs of `exit_orbit` where the
/// polar form does not apply, and from the return to the belt line on.
///
/// `tolerance` bounds the error of the scaled grazing margin m/V and of the landing.
#[must_use]
pub fn flow(oscillator: &Oscillator, tolerance: f64) -> Flow {
    let (margin, margin_error, rhs) = match decisive_turn(oscillator, tolerance) {
        Turn::Complete { margin, error, rhs } => (margin, error, u64::from(rhs)),
        Turn::HandOver { rhs } => {
            let answer = exit_orbit::decisive_flow(oscillator, tolerance);
            return Flow { rhs: u64::from(rhs) + answer.rhs, ..answer };
        }
    };
    let (fate, spent) = if margin < -margin_error {
        (Fate::SpiralsInward, 0)
    } else if margin.abs() <= margin_error {
        (Fate::TooCloseToCall, 0)
    } else {
        exit_orbit::fate_of_returning(oscillator, [margin, margin_error], tolerance)
    };
    Flow { fate, margin, margin_error, rhs: rhs + spent }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};

    /// Steps end at the kink, beyond 2 V, of a formula whose weakening rate jumps there. x1 of the landing is that of orbits of
    /// either formula, joined at the kink.
    #[test]
    fn a_slow_belt_slips_beyond_a_kink() {
        let text = "0.2 + 0.8*exp(-u/0.03) + 0.2*(abs(u - 0.4) + u - 0.4)";
        let law = Law::Expression(Expression::new(text, 1.0).unwrap());
        let oscillator = Oscillator::new(&law, &law.point(1.0, &[], 0.1, 0.05).unwrap());
        let Flow { fate: Fate::Sticks(landing), .. } = flow(&oscillator, 1e-9) else {
            panic!("{:?}", flow(&oscillator, 1e-9))
        };
        assert!((landing.x1 + 0.361_235_982_67).abs() < 1e-9, "{landing:?}");
    }
}

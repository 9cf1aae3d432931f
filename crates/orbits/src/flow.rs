//! The fate of the orbit from the exit point: by arcs, and next to grazing by comparison with C*.
//!
//! Every orbit shrinks as C grows, so that the orbit returns to the belt line below C* and spirals inward above it
//! (theory, "Monotonicity"). Arcs tell the fate and the margin of most orbits. Where the orbit grazes the belt line
//! within their error, C* is known with more digits: the margin is C* - C times the slope of the margin there.

use super::arc::Extent;
use super::exit_orbit::{self, FINEST, LANDING, NEXT_TO_GRAZING};
use super::grazing::grazing_dampings;
use super::polar::Closing;
use super::work::{Effort, Piece, Work};
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::{Fate, Flow};

/// The tolerance of C* next to grazing.
const TOLERANCE: f64 = 1e-13;
/// Distance below C* of the orbit that tells the slope of the margin, where D is small at the belt line.
const SECANT: f64 = 1e-6;
/// Curvature of the margin over its slope, where D is small at the belt line.
const CURVATURE: f64 = 4.0;

/// The fate of an orbit that is known to return to the belt line, with its extent: next to grazing alone it needs C*.
pub fn fate_and_extent(oscillator: &Oscillator, tolerance: f64) -> (Fate, Extent) {
    let mut extent = Extent::default();
    let work = Work::of(Piece::Fate, &oscillator.curve);
    let away = exit_orbit::fate_away_from_grazing(oscillator, tolerance, &mut extent, &work);
    (away.unwrap_or_else(|| flow(oscillator, tolerance).fate), extent)
}

/// The fate of the orbit from the exit point.
///
/// `tolerance` bounds the error of the scaled grazing margin m/V and of the landing.
#[must_use]
pub fn flow(oscillator: &Oscillator, tolerance: f64) -> Flow {
    flow_with(Effort::Whole, oscillator, tolerance)
}

/// [`flow`] with an effort.
#[must_use]
pub fn flow_with(effort: Effort, oscillator: &Oscillator, tolerance: f64) -> Flow {
    flow_within(oscillator, tolerance, &Work::with(effort, Piece::Fate, &oscillator.curve))
}

/// [`flow`] within a quota.
#[must_use]
pub fn flow_within(oscillator: &Oscillator, tolerance: f64, work: &Work) -> Flow {
    let before = work.done();
    let answer = answer(oscillator, tolerance, work);
    Flow { rhs: work.done() - before, ..answer }
}

fn answer(oscillator: &Oscillator, tolerance: f64, work: &Work) -> Flow {
    let by_arcs = exit_orbit::flow(oscillator, tolerance.min(LANDING), work);
    let size = 1.0 + oscillator.divergence(0.0).powi(2);
    // A margin that is not told is that of an orbit far past the belt line.
    let is_clear = !(by_arcs.margin.abs() * size < NEXT_TO_GRAZING);
    match by_arcs.fate {
        Fate::Sticks(_) | Fate::CrossesForever | Fate::SpiralsInward if is_clear => return by_arcs,
        // It returns, perhaps to the exit point.
        Fate::TooCloseToCall if is_clear && by_arcs.margin > by_arcs.margin_error => {
            return exit_orbit::flow(oscillator, FINEST, work);
        }
        _ => {}
    }
    let Oscillator { curve, belt_speed, viscous } = oscillator;
    let found = grazing_dampings(&[(curve, *belt_speed, work)], TOLERANCE)[0];
    let (Ok(Closing { rhs, .. }) | Err(rhs)) = found;
    work.count(rhs);
    let Ok(critical) = found else { return decided_by_arcs(oscillator, by_arcs, work) };
    let distance = critical.viscous - viscous;
    if !(distance.abs() > critical.error) {
        let by_arcs = decided_by_arcs(oscillator, by_arcs, work);
        return match (by_arcs.fate, margin(oscillator, &critical, work)) {
            (Fate::TooCloseToCall, [margin, margin_error]) if !margin.is_nan() => {
                Flow { margin, margin_error, ..by_arcs }
            }
            _ => by_arcs,
        };
    }
    if let (Fate::Failed(_), true) = (by_arcs.fate, distance > 0.0) {
        return by_arcs;
    }
    let [margin, margin_error] = margin(oscillator, &critical, work);
    let fate = match distance > 0.0 {
        true => exit_orbit::fate_of_returning(oscillator, [margin, margin_error], tolerance, work),
        false => Fate::SpiralsInward,
    };
    Flow { fate, margin, margin_error, rhs: 0 }
}

/// The flow where C* decides nothing: that of arcs, with a finer tolerance where they do not decide either.
fn decided_by_arcs(oscillator: &Oscillator, by_arcs: Flow, work: &Work) -> Flow {
    match by_arcs.fate {
        Fate::TooCloseToCall => exit_orbit::flow(oscillator, FINEST, work),
        _ => by_arcs,
    }
}

/// The margin next to grazing with its error, by the secant of the margin from C* down; NaN farther away.
fn margin(oscillator: &Oscillator, critical: &Closing, work: &Work) -> [f64; 2] {
    let size = 1.0 + oscillator.divergence(0.0).powi(2);
    let (step, distance) = (SECANT / size, critical.viscous - oscillator.viscous);
    if distance.abs() > step {
        return [f64::NAN; 2];
    }
    let below = Oscillator { viscous: critical.viscous - step, ..oscillator.clone() };
    let found = exit_orbit::flow(&below, FINEST, work);
    let slope = found.margin / step;
    let of_slope =
        found.margin_error / found.margin + critical.error / step + CURVATURE * found.margin * size;
    let margin = slope * distance;
    [margin, slope * critical.error + of_slope * margin.abs()]
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

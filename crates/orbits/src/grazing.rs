//! C*, the damping at which the orbit from the exit point closes with the maximum V of x2: it grazes the belt line.
//!
//! The search is that of [`super::closing`], or that of [`super::quarters`] where friction drops or falls steeply next to
//! the belt line. Every orbit from the exit point returns below C* and spirals inward above it.

use std::f64::consts::TAU;

use super::closing::{Amplitude, closing_dampings};
use super::polar::Closing;
use super::quarters::{Sought, WIDE, closing_dampings_by_quarters};
use super::work::Work;
use slipmap_model::friction::Curve;

/// A friction curve, a belt speed, and the quota of its C*.
pub type Belt<'a> = (&'a Curve, f64, &'a Work);

/// C* of many belts; `Err` with the number of evaluations where the orbit cannot be followed, or the quota is spent.
///
/// `tolerance` is relative to the size of the divergence: about the error of the scaled grazing margin that
/// corresponds to the error of C*.
#[must_use]
pub fn grazing_dampings(belts: &[Belt], tolerance: f64) -> Vec<Result<Closing, u64>> {
    let mut found: Vec<Result<Closing, u64>> = vec![Err(0); belts.len()];
    let mut by_quarters: Vec<(usize, Sought)> = Vec::new();
    let mut smooth: Vec<(usize, Amplitude)> = Vec::new();
    for (number, &belt) in belts.iter().enumerate() {
        let (curve, belt_speed, work) = belt;
        match if curve.stribeck().is_some() { None } else { sought_by_quarters(belt) } {
            Some(sought) => by_quarters.push((number, sought)),
            None => smooth.push((number, Amplitude::new(curve, belt_speed, belt_speed, work))),
        }
    }
    let (numbers, orbits): (Vec<usize>, Vec<Amplitude>) = smooth.into_iter().unzip();
    for (number, closing) in numbers.into_iter().zip(closing_dampings(&orbits, tolerance)) {
        found[number] = closing;
    }
    let (numbers, sought): (Vec<usize>, Vec<Sought>) = by_quarters.into_iter().unzip();
    for (number, closing) in numbers.into_iter().zip(closing_dampings_by_quarters(&sought, tolerance)) {
        found[number] = closing;
    }
    let answer = |&belt: &Belt, found: Result<Closing, u64>| {
        let (curve, belt_speed, _) = belt;
        let found = match found {
            Err(rhs) if curve.is_hidden_by_rounding(belt_speed) => hidden(belt, rhs),
            other => other?,
        };
        // An error delta of the weakening rate, of the samples of a function, moves C* by at most delta.
        Ok(Closing { error: found.error + curve.sampling_error(), ..found })
    };
    belts.iter().zip(found).map(|(belt, found)| answer(belt, found)).collect()
}

/// What is known of a fall that rounding hides from all orbits: the balance of energy, and that no orbit returns that is
/// damped critically.
fn hidden(belt: Belt, rhs: u64) -> Closing {
    let balance = energy_balance(belt);
    Closing { viscous: balance, error: 2.0 + balance.abs(), rhs, slope: None }
}

fn sought_by_quarters(belt: Belt<'_>) -> Option<Sought<'_>> {
    let (curve, belt_speed, work) = belt;
    Sought::from_exit(curve, belt_speed, work, || energy_balance(belt), || search_bounds(belt))
}

/// About C* by the balance of energy on the grazing circle, to first order in the weakening rate, with what the drop
/// supplies (theory, "Breakaway").
fn energy_balance((curve, belt_speed, _): Belt) -> f64 {
    let mean = curve.rough_mean_weakening(belt_speed);
    let drop = of_drop(curve.drop() / belt_speed);
    // A law that falls steeply acts as one that drops. Where neither is small the cube root of the sum of cubes is next to
    // C*, found by trial.
    let steep = of_drop((1.0 - curve.phi(belt_speed)) / belt_speed) - drop;
    let larger = mean.abs().max(steep.abs()).max(f64::MIN_POSITIVE);
    drop + larger * ((mean / larger).powi(3) + (steep / larger).powi(3)).cbrt()
}

/// About C* of friction that drops by j = `drop` V to a constant: from (V, -j) to (V, 0) v^2 + C v w + w^2 falls by the
/// factor exp(-C t), and the tangent of the phase is -(w + C v/2) / (omega v), omega^2 = 1 - C^2/4. At most 1.9: an orbit
/// that is damped critically, at C = 2, does not return.
fn of_drop(drop: f64) -> f64 {
    let next = |c: f64| {
        let omega = (1.0 - 0.25 * c * c).sqrt();
        let phase = TAU - (0.5 * c / omega).atan() - ((drop - 0.5 * c) / omega).atan();
        ((drop * (drop - c)).ln_1p() * omega / phase).min(1.9)
    };
    // Half of each change: whole ones swing about the solution where the drop is large.
    (0..3).fold(next(0.0), |c, _| 0.5 * (c + next(c)))
}

/// Two dampings around C*, by the even part of the divergence (theory, "The tests"), widened a little. With a
/// drop C* may be larger: D <= -2 at all slip speeds that the orbit can reach excludes a return.
fn bounds((curve, belt_speed, _): Belt) -> [f64; 2] {
    let mut range = curve.even_weakening_range(belt_speed);
    let drop = curve.drop();
    if drop > 0.0 {
        let fastest = belt_speed + belt_speed.hypot(drop);
        range.hi = curve.weakening_range(0.0, fastest).hi + 2.0;
    }
    let width = (range.hi - range.lo).abs();
    let pad = 1e-6 * width + 1e-12 * (range.hi.abs() + range.lo.abs());
    [range.lo - pad, range.hi + pad]
}

/// Two dampings between which C* is sought: [`bounds`], or where nothing proves any, such as of laws given as
/// functions, some that lie far around the balance of energy.
fn search_bounds(belt: Belt) -> [f64; 2] {
    let [low, high] = bounds(belt);
    let far = |sign: f64| {
        let balance = energy_balance(belt);
        balance + sign * WIDE * (1.0 + balance.abs())
    };
    [if low.is_finite() { low } else { far(-1.0) }, if high.is_finite() { high } else { far(1.0) }]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::work::Piece;
    use slipmap_model::friction::Law;

    /// Friction that drops to a constant: the search begins next to C*, of which phi(V) as rounded tells nothing more.
    #[test]
    fn the_balance_of_a_drop_is_next_to_its_critical_damping() {
        for drop in (1..100).map(|percent| f64::from(percent) / 100.0) {
            for belt_speed in [0.01, 0.1, 0.3, 1.0, 3.0] {
                let point = Law::Coulomb.point(1.0, &[drop, 0.0], belt_speed, 0.0).unwrap();
                let curve = Law::Coulomb.column(&point).curve;
                let belt = (&curve, belt_speed, &Work::of(Piece::Critical, &curve));
                let found = grazing_dampings(&[belt], 1e-9)[0].unwrap();
                let balance = energy_balance(belt);
                assert!(
                    (balance / found.viscous - 1.0).abs() < 0.05,
                    "{drop} {belt_speed}: {balance} {found:?}"
                );
            }
        }
    }
}

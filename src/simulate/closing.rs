//! The damping at which the orbit of an amplitude closes, for every friction law: by [`super::circle`] for
//! Stribeck's law, by [`super::elements`] for all others, or else by turns.

use super::circle::{Spectral, spectral};
use super::closed_orbit::closing_damping_by_turns;
use super::elements::closing_damping;
use super::polar::Closing;
use super::work::Work;
use crate::friction::{Curve, Stribeck};
use crate::point::ScaledGroups;

/// The C at which orbits close, each given by its curve, the belt speed V and its maximum r of x2, 0 < r <=
/// V, with errors of about `tolerance` in units of the weakening rate; `Err` with the number of evaluations
/// where the polar form does not apply. The orbits share the budget `work`, or each has its own.
pub(super) fn closing_dampings(
    orbits: &[(&Curve, f64, f64)],
    tolerance: f64,
    work: Option<&Work>,
) -> Vec<Result<Closing, u64>> {
    let scaled = |&(curve, belt_speed, radius): &(&Curve, f64, f64)| {
        curve.stribeck().map(|law| amplitude(law, belt_speed, radius))
    };
    let amplitudes: Vec<Amplitude> = orbits.iter().filter_map(scaled).collect();
    let starts: Vec<ScaledGroups> = amplitudes.iter().map(|amplitude| amplitude.groups).collect();
    let mut vectorised = spectral(&starts, tolerance).into_iter().zip(&amplitudes);
    let by_law = |&(curve, belt_speed, radius): &(&Curve, f64, f64)| {
        let weakening = curve.compiled(4.0 * belt_speed);
        let own = Work::of_question(curve);
        let work = work.unwrap_or(&own);
        let found = closing_damping(&weakening, belt_speed, radius, tolerance);
        let (Ok(Closing { rhs: spent, .. }) | Err(spent)) = found;
        work.spend_compiled(spent).map_err(|_| spent)?;
        found.or_else(|_| {
            let found = closing_damping_by_turns(curve, belt_speed, radius, tolerance, work);
            found.map(|found| Closing { rhs: found.rhs + spent, ..found }).map_err(|rhs| rhs + spent)
        })
    };
    let answer = |orbit: &(&Curve, f64, f64)| {
        if orbit.0.stribeck().is_none() {
            return by_law(orbit);
        }
        match vectorised.next() {
            Some((Spectral::Root { viscous, error, rhs }, amplitude)) => {
                Ok(Closing { viscous: viscous - amplitude.constant, error, rhs })
            }
            Some((Spectral::NoAnswer { rhs }, _)) => Err(rhs),
            None => Err(0),
        }
    };
    orbits.iter().map(answer).collect()
}

/// An orbit of Stribeck's law as a grazing one of another.
struct Amplitude {
    /// The groups of the other law, with C near the damping at which the orbit closes.
    groups: ScaledGroups,
    /// C of the other law less that of this one.
    constant: f64,
}

/// With v = r R cos th, rho = r / V and s = 1 - rho R cos th, 1 + k s = (1 + k (1 - rho)) (1 + k' (1 - R cos
/// th)), k' = k rho / (1 + k (1 - rho)): in units of its amplitude the orbit is a grazing one with A' = A /
/// (1 + k (1 - rho))^2, b' = b rho and C' = C + 2 b (1 - rho).
fn amplitude(law: &Stribeck, belt_speed: f64, radius: f64) -> Amplitude {
    let ScaledGroups { a, k, b, .. } = law.scaled(belt_speed, 0.0);
    let (rho, rest) = (radius / belt_speed, (belt_speed - radius) / belt_speed);
    let slowest = k.mul_add(rest, 1.0);
    let groups = ScaledGroups { a: a / (slowest * slowest), k: k * rho / slowest, b: b * rho, c: 0.0 };
    // The energy balance.
    let q = (1.0 + 2.0 * groups.k).sqrt();
    let c = 2.0 * groups.a / (q * (1.0 + groups.k + q)) - 2.0 * groups.b;
    Amplitude { groups: ScaledGroups { c, ..groups }, constant: 2.0 * b * rest }
}

//! The direct engine compared with exact solutions, identities of the theory and slow references.

mod exact;
pub mod oracle;
mod orbits;
mod references;

use crate::sample::{Random, Sample, Sampling};
use slipmap::filippov::Oscillator;
use slipmap::friction::Law;
use slipmap::point::LawParameters;
use slipmap::witness::{Sample as Contact, Trace};

/// epsilon, alpha, beta, gamma, V, c.
type Six = [f64; 6];

/// The oscillator at any six numbers, legal or not: the engine must end at each.
fn oscillator([epsilon, alpha, beta, gamma, belt_speed, damping]: Six) -> Oscillator {
    let curve = Law::Stribeck.curve(epsilon, &LawParameters::new(&[alpha, beta, gamma]));
    Oscillator { curve, viscous: epsilon * damping, belt_speed }
}

/// Dry friction of constant size, with the given coefficient of viscous damping: a linear oscillator on each
/// side of the belt line, with divergence -`viscous`. Negative damping makes orbits grow.
fn coulomb(viscous: f64, belt_speed: f64) -> Oscillator {
    Oscillator { viscous, ..oscillator([1.0, 1.0, 0.0, 0.0, belt_speed, 0.0]) }
}

/// A random point of the box of the samples.
fn anywhere(random: &mut Random) -> Six {
    let Sample { epsilon, alpha, beta, gamma, belt_speed, damping } = random.anywhere();
    [epsilon, alpha, beta, gamma, belt_speed, damping]
}

/// Fast belts and strong weakening (A = eps gamma, k = eps gamma V up to 10): many orbits overshoot.
fn overshooting(random: &mut Random) -> Six {
    let belt_speed = random.log(3.0, 300.0);
    let k = random.log(0.03, 10.0);
    let viscous = if random.unit() < 0.3 { 0.0 } else { 0.5 * random.unit() * k / belt_speed };
    [1.0, 0.3 * random.unit(), 0.0, k / belt_speed, belt_speed, viscous]
}

/// Points at which a trace meets or leaves the belt line.
fn contacts(trace: &Trace, belt_speed: f64) -> Vec<Contact> {
    trace.samples.iter().copied().filter(|sample| sample.x2 == belt_speed).collect()
}

//! Probability that a machine with uncertain quantities may stick-slip, and the damping that lowers it to a
//! given probability.
//!
//! Every draw of the uncertain quantities has its own critical damping, found by the same root search as
//! everywhere. The machine may stick-slip (for some initial state) if its damping is below it. So the share
//! of such draws is the probability, and a quantile of "critical damping less the deviation of the damping"
//! is the nominal damping for a given probability. Both have 95 % confidence limits for the sampling.

use rayon::prelude::*;

use crate::friction::Law;
use crate::machine::Machine;
use crate::random::Random;
use crate::simulate::critical::critical_dampings;

/// Distribution of an uncertain quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Normal, with this standard deviation around the machine's value; illegal values are drawn again.
    Normal {
        /// Standard deviation.
        sd: f64,
    },
    /// Uniform between two values.
    Uniform {
        /// The smaller one.
        min: f64,
        /// The larger one.
        max: f64,
    },
}

/// A quantity of a machine, named as in configurations.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[allow(missing_docs)]
pub enum Quantity {
    Mass,
    Stiffness,
    Damping,
    NormalForce,
    StaticFriction,
    KineticFriction,
    StribeckVelocity,
    Strengthening,
    BeltSpeed,
}

impl Quantity {
    /// All of them.
    pub const ALL: [Quantity; 9] = [
        Quantity::Mass,
        Quantity::Stiffness,
        Quantity::Damping,
        Quantity::NormalForce,
        Quantity::StaticFriction,
        Quantity::KineticFriction,
        Quantity::StribeckVelocity,
        Quantity::Strengthening,
        Quantity::BeltSpeed,
    ];

    /// Its key in `[machine]`.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Quantity::Mass => "mass",
            Quantity::Stiffness => "stiffness",
            Quantity::Damping => "damping",
            Quantity::NormalForce => "normal_force",
            Quantity::StaticFriction => "static_friction",
            Quantity::KineticFriction => "kinetic_friction",
            Quantity::StribeckVelocity => "stribeck_velocity",
            Quantity::Strengthening => "strengthening",
            Quantity::BeltSpeed => "belt_speed",
        }
    }

    /// The quantity's field in a machine.
    pub fn of(self, machine: &mut Machine) -> &mut f64 {
        match self {
            Quantity::Mass => &mut machine.mass,
            Quantity::Stiffness => &mut machine.stiffness,
            Quantity::Damping => &mut machine.damping,
            Quantity::NormalForce => &mut machine.normal_force,
            Quantity::StaticFriction => &mut machine.static_friction,
            Quantity::KineticFriction => &mut machine.kinetic_friction,
            Quantity::StribeckVelocity => &mut machine.stribeck_velocity,
            Quantity::Strengthening => &mut machine.strengthening,
            Quantity::BeltSpeed => &mut machine.belt_speed,
        }
    }
}

/// A number with its 95 % confidence limits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Estimate {
    /// The estimate.
    pub value: f64,
    /// The limits.
    pub limits: [f64; 2],
}

/// The nominal damping for a given probability of stick-slip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct RareBy {
    /// The given probability.
    pub probability: f64,
    /// The damping, N s/m (of a rotation N m s/rad); `None` where there are too few draws for limits.
    pub damping: Option<Estimate>,
}

/// The result of the draws.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Risk {
    /// Number of draws with an answer.
    pub draws: usize,
    /// Number of draws whose critical damping was not found; they are left out.
    pub failed: usize,
    /// The probability that the machine may stick-slip.
    pub probability: Estimate,
    /// The dampings for the given probabilities.
    pub rare_by: Vec<RareBy>,
}

/// Number of draws that share a stream of random numbers and a call of the root search.
const CHUNK: usize = 2048;
/// Accuracy of the critical dampings, far below any tolerance of a machine.
const TOLERANCE: f64 = 1e-7;
/// Largest number of times that an illegal value is drawn again; beyond it the spread is too wide for the
/// quantity.
const TRIES: usize = 1000;
/// 97.5 % quantile of the normal distribution.
const NORMAL: f64 = 1.959_963_984_540_054;

/// Returns whether all quantities are legal.
fn is_legal(machine: &Machine) -> bool {
    let positive = [
        machine.mass,
        machine.stiffness,
        machine.normal_force,
        machine.static_friction,
        machine.stribeck_velocity,
        machine.belt_speed,
    ];
    positive.iter().all(|value| *value > 0.0)
        && machine.damping >= 0.0
        && machine.strengthening >= 0.0
        && (0.0..=machine.static_friction).contains(&machine.kinetic_friction)
}

fn draw(machine: &Machine, spreads: &[(Quantity, Spread)], random: &mut Random) -> Option<Machine> {
    (0..TRIES).find_map(|_| {
        let mut drawn = *machine;
        for (quantity, spread) in spreads {
            let value = quantity.of(&mut drawn);
            *value = match spread {
                Spread::Normal { sd } => *value + sd * random.normal(),
                Spread::Uniform { min, max } => min + (max - min) * random.unit(),
            };
        }
        is_legal(&drawn).then_some(drawn)
    })
}

/// Draws `draws` machines and computes the critical damping of each. The result does not depend on the number
/// of threads. `None` where a machine under `law` has no point (see [`Machine::point`]) or the spreads have
/// hardly any legal values.
#[must_use]
pub fn risk(
    machine: &Machine,
    law: &Law,
    spreads: &[(Quantity, Spread)],
    draws: usize,
    rare: &[f64],
) -> Option<Risk> {
    // For each draw the nominal damping above which it would not stick-slip, at its own deviation.
    let chunks: Vec<Option<(Vec<f64>, usize)>> = (0..draws.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            // Each chunk has a stream of its own, so the result does not depend on threads.
            let mut random = Random(0x5115_ca9e ^ (chunk as u64).wrapping_mul(0xd134_2543_de82_ef95));
            let count = CHUNK.min(draws - chunk * CHUNK);
            let machines: Vec<Machine> =
                (0..count).map(|_| draw(machine, spreads, &mut random)).collect::<Option<_>>()?;
            let columns = machines.iter().map(|machine| Some(law.column(&machine.point(law)?)));
            let columns = columns.collect::<Option<Vec<_>>>()?;
            let roots = critical_dampings(&columns, TOLERANCE);
            let needed = machines.iter().zip(&roots).filter_map(|(drawn, root)| {
                let critical = root.as_ref().ok()?.c * drawn.units().damping;
                Some(critical - (drawn.damping - machine.damping))
            });
            let needed: Vec<f64> = needed.collect();
            let failed = count - needed.len();
            Some((needed, failed))
        })
        .collect();
    let (mut needed, mut failed) = (Vec::with_capacity(draws), 0);
    for chunk in chunks {
        let (some, lost) = chunk?;
        needed.extend(some);
        failed += lost;
    }
    if needed.is_empty() {
        return None;
    }
    needed.sort_by(f64::total_cmp);
    let n = needed.len();
    let below = n - needed.partition_point(|damping| *damping <= machine.damping);
    let rare_by =
        rare.iter().map(|&probability| RareBy { probability, damping: quantile(&needed, probability) });
    Some(Risk { draws: n, failed, probability: share(below, n), rare_by: rare_by.collect() })
}

/// A share with the limits of Wilson's score interval.
fn share(count: usize, of: usize) -> Estimate {
    let (n, p) = (of as f64, count as f64 / of as f64);
    let z = NORMAL * NORMAL / n;
    let middle = (p + 0.5 * z) / (1.0 + z);
    let half = NORMAL / (1.0 + z) * (p * (1.0 - p) / n + 0.25 * z / n).sqrt();
    Estimate { value: p, limits: [(middle - half).max(0.0), (middle + half).min(1.0)] }
}

/// The number that a share `probability` of the sorted numbers exceeds, with the limits of order statistics.
fn quantile(sorted: &[f64], probability: f64) -> Option<Estimate> {
    let n = sorted.len() as f64;
    let rank = |p: f64| (p * n).floor();
    let half = NORMAL * (n * probability * (1.0 - probability)).sqrt();
    let (low, high) = (rank(1.0 - probability) - half, rank(1.0 - probability) + half + 1.0);
    let inside = low >= 0.0 && high < n;
    let at = |rank: f64| sorted[(rank as usize).min(sorted.len() - 1)].max(0.0);
    inside.then(|| Estimate { value: at(rank(1.0 - probability)), limits: [at(low), at(high)] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine::example;
    use crate::simulate::critical_damping;

    fn machine() -> Machine {
        Machine { strengthening: 0.0, ..example() }
    }

    #[test]
    fn an_uncertain_damping_alone_has_a_known_probability() {
        // Its critical damping is one number d*, so that P = P(d < d*), evenly spread between two values.
        let law = Law::Exponential;
        let mut machine = machine();
        let critical = critical_damping(&law.column(&machine.point(&law).unwrap()), 1e-10).unwrap().c
            * machine.units().damping;
        machine.damping = critical;
        let (min, max) = (0.9 * critical, 1.3 * critical);
        let spreads = [(Quantity::Damping, Spread::Uniform { min, max })];
        let found = risk(&machine, &law, &spreads, 20_000, &[0.05]).unwrap();
        // Four standard errors of a share.
        let error = |p: f64| 4.0 * (p * (1.0 - p) / 20_000.0_f64).sqrt();
        let [low, high] = found.probability.limits;
        assert!((found.probability.value - 0.25).abs() < error(0.25), "{found:?}");
        // The limits are 1.96 standard errors to both sides.
        assert!((0.5 * (high - low) / error(0.25) - 1.96 / 4.0).abs() < 0.02, "{found:?}");
        // The nominal damping is d*; deviations go from -0.1 to 0.3 of it. To exceed d* in all but 5 % of the
        // draws, it has to be d* (1 + 0.1 - 0.05 * 0.4).
        let damping = found.rare_by[0].damping.unwrap();
        let exact = critical * (1.0 + 0.1 - 0.02);
        assert!((damping.value - exact).abs() < 0.4 * critical * error(0.05), "{damping:?} {exact}");
        assert!(damping.limits[0] < damping.value && damping.value < damping.limits[1], "{damping:?}");
        assert!((found.failed, found.draws) == (0, 20_000));
    }

    #[test]
    fn probabilities_agree_with_a_separate_count() {
        let (machine, law) = (machine(), Law::Stribeck);
        let spreads = [
            (Quantity::NormalForce, Spread::Normal { sd: 20.0 }),
            (Quantity::KineticFriction, Spread::Normal { sd: 0.05 }),
            (Quantity::BeltSpeed, Spread::Uniform { min: 0.05, max: 0.4 }),
        ];
        let found = risk(&machine, &law, &spreads, 4000, &[0.1]).unwrap();
        let mut random = Random(7);
        let sticks = (0..2000)
            .filter(|_| {
                let drawn = draw(&machine, &spreads, &mut random).unwrap();
                let point = drawn.point(&law).unwrap();
                critical_damping(&law.column(&point), 1e-9).unwrap().c > point.damping
            })
            .count() as f64
            / 2000.0;
        // Four standard errors of the difference of two shares.
        let error = (0.25 / 4000.0 + 0.25 / 2000.0_f64).sqrt();
        assert!((found.probability.value - sticks).abs() < 4.0 * error, "{found:?} {sticks}");
        // With that damping the probability is as asked.
        let rare = Machine { damping: found.rare_by[0].damping.unwrap().value, ..machine };
        let again = risk(&rare, &law, &spreads, 4000, &[]).unwrap();
        assert!((again.probability.value - 0.1).abs() < 2e-3, "{again:?}");
    }
}

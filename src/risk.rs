//! Probability that a machine with uncertain quantities may stick-slip, and the damping that lowers this
//! probability to a given value.
//!
//! Every draw of the uncertain quantities has its own critical damping, by a root search or interpolated
//! between searches. The machine may stick-slip (for some initial state) if its damping is below it. So the
//! probability is the share of such draws, and the nominal damping for a given probability is a quantile of
//! the critical damping less the deviation of the damping. Both have 95 % confidence limits for the sampling.
//!
//! Friction that was measured with standard errors is uncertain too. The errors of its data are independent
//! and normal. To first order in them the critical damping of a draw is normal around that of the data as
//! measured, with a known standard deviation (`Risk::standard_error`). Each draw has such a deviation.

mod surface;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use crate::machine::Machine;
use crate::random::Random;
pub(crate) use surface::standard_error;
use surface::{Groups, has_standard_errors};

/// Distribution of an uncertain quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Normal, with this standard deviation around the machine's value. Illegal values, except of the
    /// damping, are drawn again.
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

impl Spread {
    /// Its standard deviation.
    pub(crate) fn sd(&self) -> f64 {
        match *self {
            Spread::Normal { sd } => sd,
            Spread::Uniform { min, max } => (max - min) / 12f64.sqrt(),
        }
    }
}

/// An estimate of a number, with its 95 % confidence limits.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub(crate) struct Estimate {
    /// The estimate.
    pub value: f64,
    pub(crate) limits: [f64; 2],
}

/// The nominal damping for a given probability of stick-slip.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub(crate) struct RareBy {
    pub(crate) probability: f64,
    /// The damping, N s/m (for a rotation N m s/rad); `None` if there are too few draws for limits.
    pub(crate) damping: Option<Estimate>,
}

/// The result of the draws.
#[derive(Clone, Debug, PartialEq)]
#[cfg_attr(feature = "serde", derive(serde::Serialize))]
pub struct Risk {
    /// Number of draws that are legal and whose critical damping was found.
    pub(crate) draws: usize,
    /// Number of draws without a critical damping; the limits of all estimates hold whatever it is.
    pub(crate) failed: usize,
    /// Number of illegal machines that were drawn: those of illegal damping were left out; others, such as
    /// one of negative mass, were drawn again.
    pub(crate) redrawn: usize,
    /// Largest error of the critical dampings found, N s/m (for a rotation N m s/rad).
    pub(crate) critical_damping_error: f64,
    /// Standard error of the critical damping of the machine as given, N s/m (for a rotation N m s/rad), due
    /// to those of its measured friction, which the draws include. `None` for friction without them.
    pub(crate) standard_error: Option<f64>,
    /// The probability that the machine may stick-slip.
    pub(crate) probability: Estimate,
    /// The dampings for the given probabilities.
    pub(crate) rare_by: Vec<RareBy>,
}

/// Number of draws that share a stream of random numbers.
const CHUNK: usize = 2048;
/// Largest number of machines that are drawn for one legal machine. If none of them is legal, the spreads are
/// too wide for the quantities.
const TRIES: usize = 1000;
/// Largest number of iterations for a nominal damping, since the set of legal draws depends on it.
const MOST_ROUNDS: usize = 100;
/// 97.5 % quantile of the normal distribution.
const NORMAL: f64 = 1.959_963_984_540_054;

/// An uncertain quantity of a machine: its name and its distribution.
pub(crate) type Uncertain = (&'static str, Spread);

/// Reason why there are no probabilities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoRisk {
    /// The spreads have hardly any legal values.
    #[error("hardly any draw of the uncertain quantities is a legal machine")]
    Illegal,
    /// The critical damping of no draw was found.
    #[error("the critical damping of no draw of the uncertain quantities was found")]
    NoneFound,
    /// The run was interrupted.
    #[error("the draws of the uncertain quantities were interrupted")]
    Interrupted,
}

/// A machine that was drawn.
struct Draw {
    /// The machine, with the nominal damping.
    machine: Machine,
    /// Deviation of its damping, N s/m. Whether it is legal depends on the nominal damping.
    of_damping: f64,
    /// Number of illegal machines that were drawn before it.
    redrawn: usize,
}

/// Draws a machine that is legal, except perhaps for its damping; `None` after [`TRIES`] illegal ones.
fn draw(machine: &Machine, uncertain: &[Uncertain], random: &mut Random) -> Option<Draw> {
    let values: Vec<f64> = uncertain.iter().map(|(name, _)| value_of(machine, name)).collect();
    let drawn = |random: &mut Random| {
        let (mut drawn, mut of_damping) = (machine.clone(), 0.0);
        for ((name, spread), nominal) in uncertain.iter().zip(&values) {
            let value = match spread {
                Spread::Normal { sd } => nominal + sd * random.normal(),
                Spread::Uniform { min, max } => min + (max - min) * random.unit(),
            };
            match *name {
                "damping" => of_damping = value - nominal,
                name => drawn = drawn.with(name, value)?,
            }
        }
        drawn.is_legal().then_some((drawn, of_damping))
    };
    (0..TRIES).find_map(|redrawn| {
        let (machine, of_damping) = drawn(random)?;
        Some(Draw { machine, of_damping, redrawn })
    })
}

fn value_of(machine: &Machine, name: &str) -> f64 {
    machine.quantities().into_iter().find(|(known, _)| *known == name).map_or(f64::NAN, |(_, value)| value)
}

/// Returns whether a machine is uncertain: it has uncertain quantities, or measured friction with standard
/// errors.
pub(crate) fn is_uncertain(machine: &Machine, uncertain: &[Uncertain]) -> bool {
    !uncertain.is_empty() || has_standard_errors(machine)
}

/// For each draw the nominal damping above which it does not stick-slip, given the deviation of its damping.
struct Needed {
    /// The draws, sorted by that damping.
    draws: Vec<NeededDraw>,
    /// The largest `legal_from` of the draws: at this nominal damping, N s/m, and above all draws are legal.
    all_legal_from: f64,
    failed: usize,
    redrawn: usize,
    error: f64,
}

#[derive(Clone, Copy, Debug)]
struct NeededDraw {
    damping: f64,
    legal_from: f64,
}

/// A part of the draws.
struct Drawn<'a> {
    groups: Groups<'a>,
    /// Deviations of the damping, N s/m, and of the measured friction, in standard deviations, of each draw.
    deviations: Vec<[f64; 2]>,
    redrawn: usize,
}

impl<'a> Drawn<'a> {
    fn none(machine: &'a Machine, uncertain: &[Uncertain]) -> Self {
        let names: Vec<&str> = uncertain.iter().map(|(name, _)| *name).collect();
        Self { groups: Groups::new(machine, &names), deviations: Vec::new(), redrawn: 0 }
    }

    fn draw(mut self, uncertain: &[Uncertain], draws: usize, mut random: Random) -> Result<Self, NoRisk> {
        let machine = self.groups.nominal;
        let measured = has_standard_errors(machine);
        for _ in 0..draws {
            let drawn = draw(machine, uncertain, &mut random).ok_or(NoRisk::Illegal)?;
            self.groups.push(&drawn.machine);
            let of_friction = if measured { random.normal() } else { 0.0 };
            self.deviations.push([drawn.of_damping, of_friction]);
            self.redrawn += drawn.redrawn;
        }
        Ok(self)
    }
}

impl Needed {
    fn of(machine: &Machine, uncertain: &[Uncertain], draws: usize) -> Result<Self, NoRisk> {
        let chunks: Vec<Result<Drawn, NoRisk>> = (0..draws.div_ceil(CHUNK))
            .into_par_iter()
            .map(|chunk| {
                // Each chunk has its own stream of random numbers, so the result does not depend on threads.
                let random = Random(0x5115_ca9e ^ (chunk as u64).wrapping_mul(0xd134_2543_de82_ef95));
                Drawn::none(machine, uncertain).draw(uncertain, CHUNK.min(draws - chunk * CHUNK), random)
            })
            .collect();
        let mut all = Drawn::none(machine, uncertain);
        for chunk in chunks {
            let mut chunk = chunk?;
            all.groups.append(chunk.groups);
            all.deviations.append(&mut chunk.deviations);
            all.redrawn += chunk.redrawn;
        }
        let found = all.groups.critical_dampings();
        let needed = found.dampings.iter().zip(&found.deviations).zip(&all.deviations);
        let needed = needed.map(|((critical, spread), [of_damping, of_friction])| NeededDraw {
            damping: critical + spread * of_friction - of_damping,
            legal_from: -of_damping,
        });
        let mut needed: Vec<NeededDraw> = needed.filter(|draw| !draw.damping.is_nan()).collect();
        needed.sort_unstable_by(|one, other| one.damping.total_cmp(&other.damping));
        let failed = draws - needed.len();
        if needed.is_empty() {
            return Err(NoRisk::NoneFound);
        }
        let all_legal_from = needed.iter().map(|draw| draw.legal_from).fold(f64::NEG_INFINITY, f64::max);
        let needed = Self { draws: needed, all_legal_from, failed, redrawn: all.redrawn, error: found.error };
        match needed.legal_of(&needed.draws, machine.damping) {
            0 => Err(NoRisk::Illegal),
            legal => Ok(Self { redrawn: needed.redrawn + needed.draws.len() - legal, ..needed }),
        }
    }

    /// Number of these draws, all or some of them, that are legal at this nominal damping.
    fn legal_of(&self, draws: &[NeededDraw], damping: f64) -> usize {
        match self.all_legal_from <= damping {
            true => draws.len(),
            false => draws.iter().filter(|draw| draw.legal_from <= damping).count(),
        }
    }

    /// Probability that the machine may stick-slip at this nominal damping. The value is that of the draws
    /// whose critical damping is known; the limits hold whatever the critical dampings of the others are.
    fn probability(&self, damping: f64) -> Estimate {
        let more = &self.draws[self.draws.partition_point(|draw| draw.damping <= damping)..];
        let (count, of) = (self.legal_of(more, damping), self.legal_of(&self.draws, damping));
        let [none, all] = [count, count + self.failed].map(|count| share(count, of + self.failed).limits);
        Estimate { limits: [none[0], all[1]], ..share(count, of) }
    }

    /// The nominal damping at which the machine may stick-slip with this probability.
    fn quantile(&self, probability: f64) -> Option<Estimate> {
        // The set of legal draws depends on the damping, so it is found by iteration.
        let mut damping = f64::INFINITY;
        let mut found = None;
        for _ in 0..MOST_ROUNDS {
            let legal = self.draws.iter().filter(|draw| draw.legal_from <= damping);
            let dampings: Vec<f64> = legal.map(|draw| draw.damping).collect();
            found = quantile(&dampings, self.failed, probability);
            let next = found.as_ref().map_or(damping, |found| found.value);
            if next == damping || next >= self.all_legal_from {
                break;
            }
            damping = next;
        }
        found
    }
}

/// The default number of draws: as many as take some seconds.
pub(crate) fn usual_draws(machine: &Machine, uncertain: &[Uncertain]) -> usize {
    let names: Vec<&str> = uncertain.iter().map(|(name, _)| *name).collect();
    if Groups::new(machine, &names).can_be_interpolated(&names) { 1_000_000 } else { 10_000 }
}

/// Draws `draws` machines and computes the critical damping of each. The result does not depend on the number
/// of threads.
///
/// # Errors
/// [`NoRisk`].
pub fn risk(machine: &Machine, uncertain: &[Uncertain], draws: usize, rare: &[f64]) -> Result<Risk, NoRisk> {
    let needed = Needed::of(machine, uncertain, draws)?;
    let rare_by =
        rare.iter().map(|&probability| RareBy { probability, damping: needed.quantile(probability) });
    Ok(Risk {
        draws: needed.legal_of(&needed.draws, machine.damping),
        failed: needed.failed,
        redrawn: needed.redrawn,
        critical_damping_error: needed.error,
        standard_error: machine.model().as_ref().and_then(standard_error),
        probability: needed.probability(machine.damping),
        rare_by: rare_by.collect(),
    })
}

/// The probability that a machine may stick-slip, over a map.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Probabilities {
    /// Probabilities, row-major over belt speeds (slower) and dampings; NaN where no draw has an answer.
    pub(crate) values: Vec<f64>,
    /// Number of draws, over all belt speeds, whose critical damping was not found; they are left out.
    pub(crate) failed: usize,
    /// Number of illegal machines that were drawn, see [`Risk::redrawn`].
    pub(crate) redrawn: usize,
}

/// The probability that a machine may stick-slip, over belt speeds (slower) and dampings, in SI units. Every
/// belt speed has `draws` draws, from the same random numbers. Ends with an error once `stop` is true.
///
/// # Errors
/// [`NoRisk`].
pub(crate) fn probabilities(
    machine: &Machine,
    uncertain: &[Uncertain],
    belt_speeds: &[f64],
    dampings: &[f64],
    draws: usize,
    stop: &AtomicBool,
) -> Result<Probabilities, NoRisk> {
    let mut all = Probabilities { values: Vec::new(), failed: 0, redrawn: 0 };
    for &belt_speed in belt_speeds {
        if stop.load(Ordering::Relaxed) {
            return Err(NoRisk::Interrupted);
        }
        let machine = machine.with("belt_speed", belt_speed).ok_or(NoRisk::Illegal)?;
        match Needed::of(&machine, uncertain, draws) {
            Ok(needed) => {
                all.values.extend(dampings.iter().map(|&damping| needed.probability(damping).value));
                all.failed += needed.failed;
                all.redrawn += needed.redrawn;
            }
            Err(NoRisk::NoneFound) => {
                all.values.extend(dampings.iter().map(|_| f64::NAN));
                all.failed += draws;
            }
            Err(why) => return Err(why),
        }
    }
    Ok(all)
}

/// A share with the limits of Wilson's score interval.
fn share(count: usize, of: usize) -> Estimate {
    let (n, p) = (of as f64, count as f64 / of as f64);
    let z = NORMAL * NORMAL / n;
    let middle = (p + 0.5 * z) / (1.0 + z);
    let half = NORMAL / (1.0 + z) * (p * (1.0 - p) / n + 0.25 * z / n).sqrt();
    // At the ends of the range the limits are exact; computed ones would differ by rounding.
    let low = if count == 0 { 0.0 } else { (middle - half).max(0.0) };
    let high = if count == of { 1.0 } else { (middle + half).min(1.0) };
    Estimate { value: p, limits: [low, high] }
}

/// The number that a share `probability` of the sorted numbers exceeds, with the limits of order statistics.
/// A further `unknown` numbers may be below or above all sorted ones.
fn quantile(sorted: &[f64], unknown: usize, probability: f64) -> Option<Estimate> {
    let (known, all) = (sorted.len() as f64, (sorted.len() + unknown) as f64);
    let rank = |n: f64| ((1.0 - probability) * n).floor();
    let half = NORMAL * (all * probability * (1.0 - probability)).sqrt();
    let (low, high) = (rank(all) - unknown as f64 - half, rank(all) + half + 1.0);
    let inside = low >= 0.0 && high < known;
    let at = |rank: f64| sorted[(rank as usize).min(sorted.len() - 1)].max(0.0);
    inside.then(|| Estimate { value: at(rank(known)), limits: [at(low), at(high)] })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::{Expression, Law, Table};
    use crate::machine::{Friction, example};
    use crate::point::LawParameters;
    use crate::simulate::critical_damping;

    /// The critical damping in SI units, by a root search for this machine alone.
    fn critical(machine: &Machine) -> f64 {
        let model = machine.model().unwrap();
        critical_damping(&model.column(), 1e-10).unwrap().c * model.si.units.damping
    }

    fn machine(law: Law) -> Machine {
        example(law).with("strengthening", 0.0).unwrap()
    }

    #[test]
    fn an_uncertain_damping_alone_has_a_known_probability() {
        // Its critical damping is one number d*, so that P = P(d < d*), evenly spread between two values.
        let machine = machine(Law::Exponential);
        let critical = critical(&machine);
        let machine = machine.with("damping", critical).unwrap();
        let (min, max) = (0.9 * critical, 1.3 * critical);
        let uncertain = [("damping", Spread::Uniform { min, max })];
        let found = risk(&machine, &uncertain, 20_000, &[0.05]).unwrap();
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
    fn a_rare_damping_next_to_zero_has_its_probability() {
        // Negative dampings are illegal: how many draws that concerns depends on the nominal damping.
        let machine = machine(Law::Exponential);
        let critical = critical(&machine);
        let uncertain = [
            ("damping", Spread::Normal { sd: 0.4 * critical }),
            ("belt_speed", Spread::Uniform { min: 0.1, max: 0.4 }),
        ];
        let found = risk(&machine.with("damping", 0.01 * critical).unwrap(), &uncertain, 20_000, &[0.3, 0.1])
            .unwrap();
        assert!(found.draws < 12_000 && found.draws + found.redrawn == 20_000, "{found:?}");
        for RareBy { probability, damping } in found.rare_by {
            let nominal = machine.with("damping", damping.unwrap().value).unwrap();
            let there = risk(&nominal, &uncertain, 20_000, &[]).unwrap().probability;
            assert!((there.value - probability).abs() < 2e-3, "{probability} {there:?}");
        }
    }

    /// Machines of every kind of friction, with their uncertain quantities.
    fn uncertain_machines() -> Vec<(Machine, Vec<Uncertain>)> {
        let always = [
            ("normal_force", Spread::Normal { sd: 12.0 }),
            ("mass", Spread::Uniform { min: 1.6, max: 2.5 }),
            ("belt_speed", Spread::Uniform { min: 0.05, max: 0.4 }),
        ];
        let with = |more: &[Uncertain]| always.iter().chain(more).copied().collect::<Vec<_>>();
        let coefficients = [
            ("kinetic_friction", Spread::Normal { sd: 0.05 }),
            ("strengthening", Spread::Uniform { min: 0.0, max: 0.04 }),
        ];
        // The built-in laws but Stribeck's take the path of formulas.
        let mut all = vec![(example(Law::Stribeck), with(&coefficients))];
        let formula = Expression::new("muk + (0.4 - muk)*exp(-(u/vs))", 1.0).unwrap();
        let formula = Friction::Formula(formula, LawParameters::new(&[0.3, 0.25]));
        let vs = ("vs", Spread::Uniform { min: 0.2, max: 0.3 });
        all.push((Machine { friction: formula, ..example(Law::Stribeck) }, with(&[vs])));
        let data = [(0.0, 0.4), (0.1, 0.36), (0.25, 0.33), (0.6, 0.31), (2.0, 0.3), (4.0, 0.3)];
        let table = Friction::Measured(Table::new("a test", &data, 0.4).unwrap());
        all.push((Machine { friction: table, ..example(Law::Stribeck) }, with(&[])));
        all
    }

    #[test]
    fn interpolated_critical_dampings_are_those_of_each_machine() {
        for (machine, uncertain) in uncertain_machines() {
            let names: Vec<&str> = uncertain.iter().map(|(name, _)| *name).collect();
            let mut random = Random(11);
            let mut groups = Groups::new(&machine, &names);
            let drawn: Vec<Machine> =
                (0..12_000).map(|_| draw(&machine, &uncertain, &mut random).unwrap().machine).collect();
            drawn.iter().for_each(|machine| groups.push(machine));
            let found = groups.critical_dampings();
            let law = machine.model().unwrap().law;
            for (machine, damping) in drawn.iter().zip(&found.dampings).step_by(331) {
                let exact = critical(machine);
                // The error is known at the samples of a box only; other machines in it may have a few times
                // that error.
                let bound = 10.0 * found.error + 1e-7 * exact.abs();
                assert!((damping - exact).abs() < bound, "{law:?}: {damping} {exact} {}", found.error);
            }
            assert!(found.error < 1e-5 * critical(&machine), "{law:?}: {}", found.error);
        }
    }

    /// A machine with measured friction, each datum with its standard error, and the data.
    fn measured_machine() -> (Machine, Vec<(f64, f64)>, Vec<f64>) {
        let data: Vec<(f64, f64)> = [0.0, 0.05, 0.12, 0.25, 0.45, 0.8, 2.0, 4.0]
            .map(|u: f64| (u, 0.3 + 0.1 * (-u / 0.25).exp()))
            .into();
        let errors: Vec<f64> = (0..8).map(|i| 2e-4 * f64::from(1 + i % 3)).collect();
        let table = Table::new("a test", &data, data[0].1).unwrap().with_standard_errors(&errors).unwrap();
        (Machine { friction: Friction::Measured(table), ..example(Law::Stribeck) }, data, errors)
    }

    #[test]
    fn measured_friction_is_as_uncertain_as_tables_of_other_measurements() {
        let (machine, data, errors) = measured_machine();
        let nominal = critical(&machine);
        let machine = machine.with("damping", 1.01 * nominal).unwrap();
        let mut random = Random(5);
        let n = 300;
        let others: Vec<f64> = (0..n)
            .map(|_| {
                let mut data = data.clone();
                data.iter_mut().zip(&errors).for_each(|((_, mu), error)| *mu += error * random.normal());
                let table = Table::new("another", &data, data[0].1).unwrap();
                critical(&Machine { friction: Friction::Measured(table), ..machine.clone() })
            })
            .collect();
        let spread =
            (others.iter().map(|other| (other - nominal).powi(2)).sum::<f64>() / f64::from(n)).sqrt();
        let found = risk(&machine, &[], 20_000, &[]).unwrap();
        // Four standard errors of a standard deviation and of a share; the critical damping's second order in
        // the errors of the data is far below them.
        let standard_error = found.standard_error.unwrap();
        assert!(
            (spread / standard_error - 1.0).abs() < 4.0 / f64::from(2 * n).sqrt(),
            "{spread} {standard_error}"
        );
        let share = others.iter().filter(|other| **other > machine.damping).count() as f64 / f64::from(n);
        let p = found.probability.value;
        assert!((share - p).abs() < 4.0 * (p * (1.0 - p) / f64::from(n)).sqrt(), "{share} {p}");
        assert!(0.05 < p && p < 0.45, "the case is a test: {p}");
    }

    /// Friction that rises within its standard errors may fall: the probability has no step where the critical
    /// damping of the data passes zero.
    #[test]
    fn friction_that_rises_within_its_errors_may_stick_slip() {
        let speeds = [0.0, 0.05, 0.1, 0.2, 0.5, 1.2];
        let of = |slope: f64| {
            let data = speeds.map(|u| (u, 0.3 + slope * u));
            let table =
                Table::new("flat", &data, data[0].1).unwrap().with_standard_errors(&[0.01; 6]).unwrap();
            Machine {
                friction: Friction::Measured(table),
                mass: 1.8,
                stiffness: 4.2e5,
                normal_force: 900.0,
                belt_speed: 0.2,
                damping: 1.0,
                ..example(Law::Stribeck)
            }
        };
        let found = |slope: f64| risk(&of(slope), &[], 20_000, &[]).unwrap();
        let [rises, falls] = [1e-4, -1e-4].map(|slope| found(slope).probability.value);
        assert!((rises - falls).abs() < 0.02 && (0.4..0.6).contains(&rises), "{rises} {falls}");
        let rising = found(0.005);
        // Of 300 tables with other errors.
        let machine = of(0.005);
        let mut random = Random(8);
        let n = 300;
        let may = (0..n).filter(|_| {
            let data = speeds.map(|u| (u, 0.3 + 0.005 * u + 0.01 * random.normal()));
            let table = Table::new("another", &data, data[0].1).unwrap();
            critical(&Machine { friction: Friction::Measured(table), ..machine.clone() }) > machine.damping
        });
        let share = may.count() as f64 / f64::from(n);
        let p = rising.probability.value;
        assert!((share - p).abs() < 4.0 * (p * (1.0 - p) / f64::from(n)).sqrt(), "{share} {p}");
        assert!(rising.failed == 0 && rising.standard_error.is_some_and(|error| error > 10.0), "{rising:?}");
        // It does not where friction rises by far more than its errors.
        let steep = found(1.0);
        assert!(steep.failed == 0 && steep.probability.value == 0.0, "{steep:?}");
    }

    #[test]
    fn steep_scattered_data_have_a_standard_error_too() {
        // Rows as a rig gives them: near rest friction falls so fast that the orbit is outside the polar form.
        let data = [
            (0.0, 0.3736),
            (0.002, 0.3481),
            (0.00254, 0.3523),
            (0.00411, 0.3525),
            (0.00664, 0.3299),
            (0.01074, 0.3228),
            (0.01735, 0.3029),
            (0.03566, 0.2798),
            (0.07327, 0.2473),
            (0.15055, 0.2313),
            (0.5, 0.2418),
        ];
        let table =
            Table::new("a rig", &data, data[0].1).unwrap().with_standard_errors(&[0.004; 11]).unwrap();
        let machine = Machine {
            friction: Friction::Measured(table),
            mass: 1.2,
            stiffness: 9e4,
            normal_force: 250.0,
            belt_speed: 0.1,
            ..example(Law::Stribeck)
        };
        let uncertain = [("normal_force", Spread::Normal { sd: 10.0 })];
        let found = risk(&machine, &uncertain, 60, &[]).unwrap();
        assert!(found.failed == 0 && found.standard_error.is_some_and(|error| error > 0.0), "{found:?}");
    }

    /// The formula of a machine in three parameters: with the speed and the mass they are too many to interpolate.
    #[test]
    fn fewer_draws_are_usual_where_each_needs_a_search() {
        let formula = Expression::new("muk + (mus - muk)*exp(-u/vs)", 1.0).unwrap();
        let friction = Friction::Formula(formula, LawParameters::new(&[0.25, 0.4, 0.05]));
        let machine = Machine { friction, ..example(Law::Stribeck) };
        let all = ["muk", "mus", "vs", "belt_speed", "mass", "stiffness"];
        let usual = |names: &[&'static str]| {
            let spreads: Vec<Uncertain> =
                names.iter().map(|name| (*name, Spread::Normal { sd: 0.01 })).collect();
            usual_draws(&machine, &spreads)
        };
        assert_eq!(usual(&all), 10_000);
        assert_eq!((usual(&all[..4]), usual(&all[1..])), (1_000_000, 1_000_000));
        assert_eq!(usual_draws(&example(Law::Stribeck), &[("mass", Spread::Normal { sd: 0.01 })]), 1_000_000);
    }

    #[test]
    fn illegal_draws_and_failed_ones_are_counted_apart() {
        let machine = machine(Law::Exponential);
        let uncertain = [("mass", Spread::Normal { sd: 0.8 * machine.mass })];
        let found = risk(&machine, &uncertain, 1000, &[]).unwrap();
        // A normal number is more than 1.25 standard deviations below its mean in 10.6 % of all draws: of those
        // until 1000 are legal, 118 on average.
        assert!((60..180).contains(&found.redrawn), "{}", found.redrawn);
        assert_eq!((found.draws, found.failed), (1000, 0));
    }

    #[test]
    fn limits_hold_whatever_draws_without_an_answer_do() {
        let needed = |failed| Needed {
            draws: (1..=1000)
                .map(|i| NeededDraw { damping: f64::from(i), legal_from: f64::NEG_INFINITY })
                .collect(),
            all_legal_from: f64::NEG_INFINITY,
            failed,
            redrawn: 0,
            error: 0.0,
        };
        let (all, some) = (needed(0).probability(900.0), needed(250).probability(900.0));
        assert!(all.value == 0.1 && all.limits[0] > 0.08 && all.limits[1] < 0.125, "{all:?}");
        // 100 of 1250 at least, 350 at most, and the limits of a share of so many draws.
        assert!(some.value == 0.1 && (0.06..0.08).contains(&some.limits[0]), "{some:?}");
        assert!((0.28..0.31).contains(&some.limits[1]), "{some:?}");
        // All of those without an answer may need more damping than any other.
        assert!(needed(0).quantile(0.1).is_some() && needed(250).quantile(0.1).is_none());
        let half = needed(250).quantile(0.5).unwrap();
        assert!(half.limits[0] < 380.0 && half.limits[1] > 620.0 && half.value == 501.0, "{half:?}");
    }

    #[test]
    fn interpolated_standard_errors_are_those_of_each_machine() {
        let (machine, ..) = measured_machine();
        let uncertain = [
            ("normal_force", Spread::Normal { sd: 12.0 }),
            ("belt_speed", Spread::Uniform { min: 0.05, max: 0.4 }),
        ];
        let mut groups = Groups::new(&machine, &["normal_force", "belt_speed"]);
        let mut random = Random(11);
        let drawn: Vec<Machine> =
            (0..500).map(|_| draw(&machine, &uncertain, &mut random).unwrap().machine).collect();
        drawn.iter().for_each(|machine| groups.push(machine));
        let found = groups.critical_dampings();
        for (machine, deviation) in drawn.iter().zip(&found.deviations).step_by(97) {
            let exact = standard_error(&machine.model().unwrap()).unwrap();
            // To a few times the accuracy at the samples of a box.
            assert!((deviation / exact - 1.0).abs() < 0.05, "{deviation} {exact}");
        }
    }

    #[test]
    fn probabilities_agree_with_a_separate_count() {
        const DRAWN: u32 = 200;
        let (machine, uncertain) = uncertain_machines().swap_remove(0);
        let found = risk(&machine, &uncertain, 2000, &[0.1]).unwrap();
        let mut random = Random(7);
        let sticks = (0..DRAWN)
            .filter(|_| {
                let drawn = draw(&machine, &uncertain, &mut random).unwrap();
                critical(&drawn.machine) > machine.damping + drawn.of_damping
            })
            .count() as f64
            / f64::from(DRAWN);
        // Four standard errors of the difference of two shares.
        let error = (0.25 / 2000.0 + 0.25 / f64::from(DRAWN)).sqrt();
        assert!((found.probability.value - sticks).abs() < 4.0 * error, "{found:?} {sticks}");
        // With that damping the probability is the requested one.
        let rare = machine.with("damping", found.rare_by[0].damping.unwrap().value).unwrap();
        let again = risk(&rare, &uncertain, 2000, &[]).unwrap();
        assert!((again.probability.value - 0.1).abs() < 2e-3, "{again:?}");
    }

    #[test]
    fn a_map_of_probabilities_has_each_of_its_points() {
        let machine = machine(Law::Stribeck);
        let uncertain = [("normal_force", Spread::Normal { sd: 10.0 })];
        let (speeds, dampings) = ([0.1, 0.3], [0.0, 2.0, 4.0]);
        let stop = AtomicBool::new(false);
        let map = probabilities(&machine, &uncertain, &speeds, &dampings, 3000, &stop).unwrap().values;
        for (i, speed) in speeds.into_iter().enumerate() {
            for (j, damping) in dampings.into_iter().enumerate() {
                let here = machine.with("belt_speed", speed).unwrap().with("damping", damping).unwrap();
                let alone = risk(&here, &uncertain, 3000, &[]).unwrap().probability;
                assert_eq!(map[3 * i + j], alone.value, "{speed} {damping}");
            }
        }
        assert!(map[0] == 1.0 && map[5] < map[3], "{map:?}");
    }
}

//! Probability that a machine with uncertain quantities may stick-slip, and the damping that lowers this
//! probability to a given value.
//!
//! Every draw of the uncertain quantities has its own critical damping, by a root search, and on fast belts another one,
//! below which its orbits cross the belt line for ever. The machine may stick-slip (for some initial state) if its damping
//! is between the two. So the probability is the share of such draws. The nominal damping for a given probability is the
//! one above which it is below: a quantile of the critical damping less the deviation of the damping, or on fast belts
//! less than that. Both have 95 % confidence limits for the sampling.
//!
//! Friction that was measured with standard errors is uncertain too, and so is friction that was fitted: each draw has
//! data of its own, whose errors are independent and normal, or parameters with the covariance of the fit. What the
//! curve between measured rows could be moves the critical damping by a normal number, with the standard deviation at the
//! nominal machine, in proportion to the normal force. An orbit that leaves the data is taken to stick below the critical
//! damping.

mod errors;

use std::time::{Duration, Instant};

use rayon::prelude::*;

use crate::{Friction, Machine, Model};
use errors::has_standard_errors;
pub(crate) use errors::{Moved, joint};
pub use errors::{WithError, uncertain_critical_damping};
use slipmap_certify::landing::amplitude_bounds;
use slipmap_column::critical::{CriticalDamping, critical_damping, critical_dampings_with};
use slipmap_column::sticks_from;
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::{Column, Table};
use slipmap_numbers::random::Random;
use slipmap_orbits::far_loops::FarLoops;
use slipmap_orbits::{Effort, flow};

/// Distribution of an uncertain quantity.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Spread {
    /// Normal, with this standard deviation around the machine's value. Illegal values, except of the
    /// damping, are drawn again.
    Normal {
        /// Standard deviation.
        sd: f64,
    },
    /// Normal, with this standard deviation over the value: of a quantity with several values.
    Relative {
        /// Standard deviation over the value.
        sd: f64,
    },
    /// Uniform between two values.
    Uniform {
        /// The smaller one.
        min: f64,
        /// The larger one.
        max: f64,
    },
    /// Normal, and correlated with the other quantities that have such a spread: the deviation is the sum of these
    /// numbers, each times a normal number that these quantities share.
    Joint {
        /// The row of the quantity in the Cholesky factor of the covariance; zeros after it.
        row: [f64; MOST_JOINT],
    },
}

/// Largest number of quantities whose errors are correlated.
pub const MOST_JOINT: usize = 6;

impl Spread {
    /// The spread around this value.
    #[must_use]
    pub fn at(self, value: f64) -> Self {
        match self {
            Spread::Relative { sd } => Spread::Normal { sd: sd * value.abs() },
            other => other,
        }
    }

    /// Its standard deviation around this value.
    pub fn sd(&self, value: f64) -> f64 {
        match self.at(value) {
            Spread::Normal { sd } | Spread::Relative { sd } => sd,
            Spread::Uniform { min, max } => (max - min) / 12f64.sqrt(),
            Spread::Joint { row } => row.iter().map(|part| part * part).sum::<f64>().sqrt(),
        }
    }
}

/// An estimate of a number, with its 95 % confidence limits.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct WithLimits {
    /// The estimate.
    pub value: f64,
    /// Smallest and largest legal value.
    #[serde(rename = "limits_95")]
    pub limits: [f64; 2],
}

/// The nominal damping for a given probability of stick-slip.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct RareBy {
    /// Its probability.
    pub probability: f64,
    /// The damping, N s/m (for a rotation N m s/rad); `None` if there are too few draws for limits.
    pub damping: Option<WithLimits>,
}

/// The result of the draws.
#[derive(Clone, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Risk {
    /// Number of draws that are legal and whose critical damping was found.
    pub draws: usize,
    /// Number of draws without a critical damping; the limits of all estimates hold whatever it is.
    pub failed: usize,
    /// Number of illegal machines that were drawn: those of illegal damping were left out; others, such as
    /// one of negative mass, were drawn again.
    pub redrawn: usize,
    /// Whether there are fewer draws than usual, since each takes long.
    #[serde(rename = "fewer_than_usual")]
    pub fewer: bool,
    /// Largest error of the critical dampings found, N s/m (for a rotation N m s/rad).
    pub critical_damping_error: f64,
    /// Standard error of the critical damping of the machine as given, N s/m (for a rotation N m s/rad), due
    /// to those of its measured friction, which the draws include. `None` for friction without them.
    #[serde(rename = "critical_damping_standard_error")]
    pub standard_error: Option<f64>,
    /// The probability that the machine may stick-slip.
    pub probability: WithLimits,
    /// The probability that it vibrates by itself: steady slip is unstable, and every start but that ends in a vibration.
    pub by_itself: WithLimits,
    /// The dampings for the given probabilities.
    pub rare_by: Vec<RareBy>,
}

/// Number of draws that share a stream of random numbers.
const CHUNK: usize = 2048;
/// Number of draws by default; fewer, down to [`FEWEST_DRAWS`], where their searches would take more evaluations of the
/// right-hand side of the Stribeck law: some seconds.
pub const USUAL_DRAWS: usize = 100_000;
/// The fewest draws by default.
pub const FEWEST_DRAWS: usize = 100;
/// Largest number of draws, which take less than a gigabyte.
pub const MOST_DRAWS: usize = 10_000_000;
const WORK: u64 = 100_000_000;
/// Work counted for a search that fails.
const FAILURE: u64 = 100_000;
/// Tolerance of the root search for a critical damping.
const TOLERANCE: f64 = 1e-9;
/// Number of machines in one call of the root search.
const SEARCHED_TOGETHER: usize = 64;
/// Number of draws that tell whether orbits of some may cross the belt line for ever.
const TRIED: usize = 64;
/// Number of strips of a quarter turn whose bound tells that an orbit stays in the data.
const STRIPS: u32 = 8;
/// Number of bisections for the damping below which they do: a thousandth of the critical one.
const HALVINGS: u32 = 11;
/// Largest number of machines that are drawn for one legal machine. If none of them is legal, the spreads are
/// too wide for the quantities.
const TRIES: usize = 1000;
/// 97.5 % quantile of the normal distribution.
pub(crate) const NORMAL: f64 = 1.959_963_984_540_054;

/// An uncertain quantity of a machine: its name and its distribution.
pub type Uncertain = (&'static str, Spread);

/// Reason why there are no probabilities.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum NoRisk {
    /// The spreads have hardly any legal values.
    #[error("hardly any draw of the uncertain quantities is a legal machine")]
    Illegal,
    /// The critical damping of no draw was found.
    #[error("the critical damping of no draw of the uncertain quantities was found")]
    NoneFound,
    /// At the given damping it is unknown of every draw whether it sticks.
    #[error("at this damping the orbit of no draw of the uncertain quantities could be followed")]
    NoneFollowed,
    /// More draws than memory is taken for.
    #[error("more than ten million draws")]
    TooMany,
    /// The run was interrupted.
    #[error("the draws of the uncertain quantities were interrupted")]
    Interrupted,
}

/// A machine that was drawn.
struct Draw {
    /// The machine, with the nominal damping.
    machine: Machine,
    /// Deviation of its damping, as it is given. Whether it is legal depends on the nominal damping.
    of_damping: f64,
    /// Deviation of its critical damping by the curve between measured rows, in units of [`Draws::of_curve`].
    of_curve: f64,
    /// Number of illegal machines that were drawn before it.
    redrawn: usize,
}

/// What is drawn.
struct Draws<'a> {
    machine: &'a Machine,
    uncertain: &'a [Uncertain],
    /// The value of each of these quantities.
    nominal: Vec<f64>,
    /// Data with standard errors.
    measured: Option<&'a Table>,
    /// Standard deviation of the critical damping by the curve between the rows, per normal force.
    of_curve: f64,
}

impl<'a> Draws<'a> {
    fn of(machine: &'a Machine, uncertain: &'a [Uncertain]) -> Self {
        let nominal = uncertain.iter().map(|(name, _)| value_of(machine, name)).collect();
        let measured = match &machine.friction {
            Friction::Measured(table) if table.standard_errors().is_some() => Some(table),
            _ => None,
        };
        let of_curve = error_by_curve(machine) / machine.normal_force;
        Self { machine, uncertain, nominal, measured, of_curve }
    }

    /// Draws a machine that is legal, except perhaps for its damping; `None` after [`TRIES`] illegal ones.
    fn draw(&self, random: &mut Random) -> Option<Draw> {
        (0..TRIES).find_map(|redrawn| self.try_draw(redrawn, random))
    }

    fn try_draw(&self, redrawn: usize, random: &mut Random) -> Option<Draw> {
        let Self { machine, uncertain, nominal, measured, of_curve } = self;
        let mut drawn = Machine::clone(machine);
        let mut of_damping = 0.0;
        let has_joint = uncertain.iter().any(|(_, spread)| matches!(spread, Spread::Joint { .. }));
        let joint: [f64; MOST_JOINT] = std::array::from_fn(|_| if has_joint { random.normal() } else { 0.0 });
        // All numbers of a draw are drawn, so that the next one begins alike.
        let values: Vec<f64> = uncertain
            .iter()
            .zip(nominal)
            .map(|((_, spread), nominal)| match spread.at(*nominal) {
                Spread::Normal { sd } | Spread::Relative { sd } => nominal + sd * random.normal(),
                Spread::Uniform { min, max } => min + (max - min) * random.unit(),
                Spread::Joint { row } => {
                    nominal + row.iter().zip(joint).map(|(part, z)| part * z).sum::<f64>()
                }
            })
            .collect();
        let friction = measured.map(|table| table.drawn(|| random.normal()));
        let of_curve = if *of_curve > 0.0 { random.normal() } else { 0.0 };
        for (((name, _), nominal), value) in uncertain.iter().zip(nominal).zip(values) {
            match *name {
                name if name == machine.damping_name() => of_damping = value - nominal,
                name => drawn = drawn.with(name, value)?,
            }
        }
        if let Some(table) = friction {
            drawn.friction = Friction::Measured(table.ok()?);
        }
        drawn.is_legal().then_some(Draw { machine: drawn, of_damping, of_curve, redrawn })
    }

    /// What is found of some draws, in SI units; `may_cross` is whether orbits may cross the belt line for ever.
    fn search(&self, draws: &[Draw], may_cross: bool) -> Vec<Option<Found>> {
        let models: Vec<Option<Model>> = draws.iter().map(|draw| draw.machine.model()).collect();
        let columns: Vec<Column> = models.iter().flatten().map(Model::column).collect();
        let mut found = critical_dampings_with(Effort::Small, &columns, TOLERANCE).into_iter().zip(&columns);
        let of = |(draw, model): (&Draw, &Option<Model>)| {
            let unit = model.as_ref()?.si.damping;
            let (found, column) = found.next()?;
            let known = found.and_then(CriticalDamping::known).ok()?;
            let off = draw.of_curve * self.of_curve * draw.machine.normal_force;
            let is_known = !may_cross && stays_in_data(column);
            let from = if is_known { [f64::NEG_INFINITY; 2] } else { sticks_between(column, known.c) };
            Some(Found {
                critical: known.c * unit + off,
                error: known.error * unit,
                unstable_below: column.curve.weakening(column.belt_speed) / column.epsilon * unit,
                sticks_between: from.map(|from| from * unit + off),
            })
        };
        draws.iter().zip(&models).map(of).collect()
    }
}

/// The standard deviation of the critical damping by the curve between rows of data with standard errors, N s/m.
pub(crate) fn error_by_curve(machine: &Machine) -> f64 {
    let of = || {
        let Friction::Measured(table) = &machine.friction else { return None };
        table.standard_errors()?;
        let exact = table.with_standard_errors(&vec![0.0; table.data().count()]).ok()?;
        let machine = Machine { friction: Friction::Measured(exact), ..machine.clone() };
        uncertain_critical_damping(&machine, &[])
    };
    of().map_or(0.0, |of| of.standard_error)
}

/// What is found of a draw, in SI units.
struct Found {
    critical: f64,
    error: f64,
    /// The damping below which steady slip is unstable: the slope by which friction falls, times the normal force.
    unstable_below: f64,
    /// The damping below which the orbit from the exit point crosses the belt line for ever, and that from which it
    /// sticks; -infinity where it crosses at no legal one.
    sticks_between: [f64; 2],
}

/// Whether some orbit of a column may cross the belt line for ever.
fn may_cross(column: &Column) -> bool {
    FarLoops::where_friction_resists(&column.curve, column.belt_speed).inward_from(0.0) > 0.0
}

/// Whether the first turn of the orbit from the exit point is proved to stay in the data of friction at every damping.
fn stays_in_data(column: &Column) -> bool {
    let fastest = column.curve.fastest();
    fastest == f64::INFINITY || column.belt_speed + amplitude_bounds([(column, 0.0)], STRIPS)[0] <= fastest
}

/// The damping c of a column below which the orbit from the exit point crosses the belt line for ever, `critical` being
/// c*, and that from which it sticks; -infinity where it crosses at no damping, and for the first where that is not known.
fn sticks_between(column: &Column, critical: f64) -> [f64; 2] {
    let range = [0.0, critical];
    let found =
        (critical > 0.0).then(|| sticks_from(Effort::Small, column, range, HALVINGS, TOLERANCE).between);
    found.unwrap_or_default().map(|from| if from > 0.0 { from } else { f64::NEG_INFINITY })
}

fn value_of(machine: &Machine, name: &str) -> f64 {
    machine.quantities().into_iter().find(|(known, _)| *known == name).map_or(f64::NAN, |(_, value)| value)
}

/// The damping of a machine as it is given, in N s/m or as a ratio.
fn given_damping(machine: &Machine) -> f64 {
    value_of(machine, machine.damping_name())
}

/// Returns whether a machine is uncertain: it has uncertain quantities, or measured friction with standard
/// errors.
pub fn is_uncertain(machine: &Machine, uncertain: &[Uncertain]) -> bool {
    !uncertain.is_empty() || has_standard_errors(machine)
}

/// For each draw the nominal damping, as it is given, above which it does not stick-slip, given the deviation of its
/// damping.
pub struct Needed {
    /// The draws, sorted by that damping.
    draws: Vec<NeededDraw>,
    /// The largest `legal_from` of the draws: at this nominal damping and above all draws are legal.
    all_legal_from: f64,
    /// Number of draws whose critical damping was not found.
    pub failed: usize,
    /// As [`Risk::redrawn`].
    pub redrawn: usize,
    error: f64,
}

#[derive(Clone, Copy, Debug)]
struct NeededDraw {
    damping: f64,
    /// The nominal damping below which it vibrates by itself.
    unstable_below: f64,
    /// The nominal damping below which its orbits cross the belt line for ever, and that from which they stick.
    sticks_between: [f64; 2],
    legal_from: f64,
}

impl Needed {
    /// Draws `draws` machines and solves for each.
    ///
    /// # Errors
    /// [`NoRisk`].
    pub fn of(machine: &Machine, uncertain: &[Uncertain], draws: usize) -> Result<Self, NoRisk> {
        Self::until(machine, uncertain, draws, None)
    }

    /// The same, with fewer draws if `end` comes first; the first [`SEARCHED_TOGETHER`] are drawn in any case.
    fn until(
        machine: &Machine,
        uncertain: &[Uncertain],
        draws: usize,
        end: Option<Instant>,
    ) -> Result<Self, NoRisk> {
        if draws > MOST_DRAWS {
            return Err(NoRisk::TooMany);
        }
        let all = Draws::of(machine, uncertain);
        let drawn = |chunk: usize| {
            // Each chunk has its own stream of random numbers, so the result does not depend on threads.
            let mut random = Random(0x5115_ca9e ^ (chunk as u64).wrapping_mul(0xd134_2543_de82_ef95));
            let count = CHUNK.min(draws - chunk * CHUNK);
            let drawn = (0..count).map(|_| all.draw(&mut random).ok_or(NoRisk::Illegal));
            drawn.collect::<Result<Vec<Draw>, NoRisk>>()
        };
        // As far as some of the first tell.
        let first = drawn(0)?;
        let some = first.iter().step_by(first.len().div_ceil(TRIED).max(1));
        let mut models = some.filter_map(|draw| draw.machine.model());
        let may_cross = models.any(|model| may_cross(&model.column()));
        // The machines of a chunk are gone before most others are drawn: they take ten times as much memory as what is kept.
        let is_late = || end.is_some_and(|end| Instant::now() >= end);
        let chunk = |chunk: usize| {
            if chunk > 0 && is_late() {
                return Ok((Vec::new(), 0, 0.0, 0));
            }
            let drawn = drawn(chunk)?;
            let search = |(part, some): (usize, &'_ [Draw])| match chunk + part > 0 && is_late() {
                true => (0, Vec::new()),
                false => (part * SEARCHED_TOGETHER, all.search(some, may_cross)),
            };
            let found: Vec<(usize, Vec<Option<Found>>)> =
                drawn.par_chunks(SEARCHED_TOGETHER).enumerate().map(search).collect();
            let searched = || {
                let of = |(from, found): &'_ (usize, Vec<Option<Found>>)| (*from, found.len());
                found.iter().map(of).flat_map(|(from, count)| &drawn[from..from + count])
            };
            let redrawn: usize = searched().map(|draw| draw.redrawn).sum();
            let found = || found.iter().flat_map(|(_, found)| found);
            let error = found().flatten().map(|found| found.error).fold(0.0, f64::max);
            let known = searched().zip(found()).filter_map(|(draw, found)| Some((draw, found.as_ref()?)));
            let needed = known.map(|(Draw { machine, of_damping, .. }, found)| {
                let nominal = |damping: f64| damping / machine.si_damping() - of_damping;
                NeededDraw {
                    damping: nominal(found.critical),
                    unstable_below: nominal(found.unstable_below),
                    sticks_between: found.sticks_between.map(nominal),
                    legal_from: -of_damping,
                }
            });
            Ok((needed.collect::<Vec<_>>(), redrawn, error, found().count()))
        };
        let chunks: Vec<_> =
            (0..draws.div_ceil(CHUNK)).into_par_iter().map(chunk).collect::<Result<_, NoRisk>>()?;
        let (mut needed, mut redrawn, mut error) = (Vec::with_capacity(draws), 0, 0.0);
        let draws: usize = chunks.iter().map(|(.., searched)| searched).sum();
        for (some, redrawn_here, error_here, _) in chunks {
            needed.extend(some);
            redrawn += redrawn_here;
            error = f64::max(error, error_here);
        }
        needed.sort_unstable_by(|one: &NeededDraw, other| one.damping.total_cmp(&other.damping));
        if needed.is_empty() {
            return Err(NoRisk::NoneFound);
        }
        let all_legal_from = needed.iter().map(|draw| draw.legal_from).fold(f64::NEG_INFINITY, f64::max);
        let needed = Self { failed: draws - needed.len(), draws: needed, all_legal_from, redrawn, error };
        match needed.legal_of(&needed.draws, given_damping(machine)) {
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
    pub fn probability(&self, damping: f64) -> WithLimits {
        let more = &self.draws[self.draws.partition_point(|draw| draw.damping <= damping)..];
        let below = |end: usize| {
            let is_below =
                |draw: &&NeededDraw| draw.legal_from <= damping && damping < draw.sticks_between[end];
            more.iter().filter(is_below).count()
        };
        let [crossing, not_sticking] = [0, 1].map(below);
        let failed = self.failed + not_sticking - crossing;
        let count = self.legal_of(more, damping) - not_sticking;
        let of = self.legal_of(&self.draws, damping) + self.failed - failed;
        let [none, all] = [count, count + failed].map(|count| share(count, of + failed).limits);
        WithLimits { limits: [none[0], all[1]], ..share(count, of) }
    }

    /// Probability that the machine vibrates by itself at this nominal damping, with limits as of
    /// [`Needed::probability`].
    pub fn by_itself(&self, damping: f64) -> WithLimits {
        let does = |draw: &&NeededDraw| draw.legal_from <= damping && damping < draw.unstable_below;
        let (count, of) = (self.draws.iter().filter(does).count(), self.legal_of(&self.draws, damping));
        let [none, all] = [count, count + self.failed].map(|count| share(count, of + self.failed).limits);
        WithLimits { limits: [none[0], all[1]], ..share(count, of) }
    }

    /// How many draws are legal, how many of those are known to stick-slip, and of how many that is unknown, just below each
    /// nominal damping at which that changes, from infinity down to 0.
    fn counts(&self) -> Vec<(f64, [i32; 3])> {
        let mut changes = vec![(f64::INFINITY, [self.draws.len() as i32, 0, 0])];
        let mut add = |damping: f64, change| changes.extend((damping > 0.0).then_some((damping, change)));
        for &NeededDraw { damping, sticks_between, legal_from, .. } in self.draws.iter().rev() {
            let [crosses_below, from] = sticks_between.map(|from| from.max(legal_from).min(damping));
            if from < damping {
                add(damping, [0, 1, 0]);
                add(from, [0, -1, 0]);
            }
            if crosses_below < from {
                add(from, [0, 0, 1]);
                add(crosses_below, [0, 0, -1]);
            }
            add(legal_from, [-1, 0, 0]);
        }
        changes.sort_by(|one, other| other.0.total_cmp(&one.0));
        let sum = |counts: &mut [i32; 3], (damping, change): (f64, [i32; 3])| {
            counts.iter_mut().zip(change).for_each(|(count, change)| *count += change);
            Some((damping, *counts))
        };
        changes.into_iter().scan([0; 3], sum).collect()
    }

    /// The nominal damping above which the machine may stick-slip with less than this probability. Its limits are where
    /// those of [`Needed::probability`] are this probability, up to whole draws; `None` if there are too few for limits.
    fn quantile(&self, probability: f64) -> Option<WithLimits> {
        let counts = self.counts();
        // The largest damping at which all legal draws but the least `rank` may stick-slip; 0 if there is none.
        let largest = |rank: &dyn Fn(f64) -> f64, counted: fn([i32; 3]) -> [i32; 2]| {
            for &(damping, counts) in &counts {
                let [of, sticking] = counted(counts);
                let rank = rank(of as f64);
                if !(0.0..of as f64).contains(&rank) {
                    return None;
                }
                if sticking >= of - rank as i32 {
                    return Some(damping);
                }
            }
            Some(0.0)
        };
        let failed = self.failed as f64;
        let rank = |n: f64| ((1.0 - probability) * n).floor();
        let half = |n: f64| NORMAL * (n * probability * (1.0 - probability)).sqrt();
        let low = |n: f64| rank(n + failed) - failed - half(n + failed);
        let high = |n: f64| rank(n + failed) + half(n + failed) + 1.0;
        // Those of which it is unknown are left out, or none or all of them may stick-slip.
        let value = largest(&rank, |[legal, sticking, unknown]| [legal - unknown, sticking])?;
        let low = largest(&low, |[legal, sticking, _]| [legal, sticking])?;
        let high = largest(&high, |[legal, sticking, unknown]| [legal, sticking + unknown])?;
        Some(WithLimits { value, limits: [low, high] })
    }
}

/// The default number of draws, judged by the nominal machine.
pub fn usual_draws(machine: &Machine) -> usize {
    let Some(column) = machine.model().map(|model| model.column()) else { return FEWEST_DRAWS };
    let search = critical_damping(&column, TOLERANCE).map_or(FAILURE, |root| root.rhs);
    let crossing = match may_cross(&column) || !stays_in_data(&column) {
        true => u64::from(HALVINGS) * flow(&Oscillator::in_column(&column, 0.0), TOLERANCE).rhs,
        false => 0,
    };
    let work = search + crossing + column.curve.compiling_work(column.belt_speed);
    ((WORK / work.max(1)) as usize).clamp(FEWEST_DRAWS, USUAL_DRAWS)
}

/// Draws machines and computes the critical damping of each: `draws` of them, or as many as take some seconds; fewer if
/// `time` is over first. Without it the result does not depend on the number of threads, nor on the time.
///
/// # Errors
/// [`NoRisk`].
pub fn risk(
    machine: &Machine,
    uncertain: &[Uncertain],
    draws: Option<usize>,
    rare: &[f64],
    time: Option<Duration>,
) -> Result<Risk, NoRisk> {
    let usual = usual_draws(machine);
    let end = time.and_then(|time| Instant::now().checked_add(time));
    let needed = Needed::until(machine, uncertain, draws.unwrap_or(usual), end)?;
    let (damping, unit) = (given_damping(machine), machine.si_damping());
    let in_si = |found: WithLimits| WithLimits {
        value: found.value * unit,
        limits: found.limits.map(|it| it * unit),
    };
    let probability = needed.probability(damping);
    if probability.value.is_nan() {
        return Err(NoRisk::NoneFollowed);
    }
    let rare_by = rare
        .iter()
        .map(|&probability| RareBy { probability, damping: needed.quantile(probability).map(in_si) });
    Ok(Risk {
        draws: needed.legal_of(&needed.draws, damping),
        failed: needed.failed,
        redrawn: needed.redrawn,
        fewer: draws.is_none() && usual < USUAL_DRAWS,
        critical_damping_error: needed.error,
        standard_error: uncertain_critical_damping(machine, uncertain).map(|of| of.standard_error),
        probability,
        by_itself: needed.by_itself(damping),
        rare_by: rare_by.collect(),
    })
}

/// A share with the limits of Wilson's score interval.
fn share(count: usize, of: usize) -> WithLimits {
    let (n, p) = (of as f64, count as f64 / of as f64);
    let z = NORMAL * NORMAL / n;
    let middle = (p + 0.5 * z) / (1.0 + z);
    let half = NORMAL / (1.0 + z) * (p * (1.0 - p) / n + 0.25 * z / n).sqrt();
    // At the ends of the range the limits are exact; computed ones would differ by rounding.
    let low = if count == 0 { 0.0 } else { (middle - half).max(0.0) };
    let high = if count == of { 1.0 } else { (middle + half).min(1.0) };
    WithLimits { value: p, limits: [low, high] }
}

#[cfg(test)]
mod tests;

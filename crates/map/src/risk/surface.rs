//! The critical dampings of many machines that differ in a few numbers.
//!
//! With the time in units of sqrt(m / k) the divergence of the flow is (theory, "Scaling")
//!
//! ```text
//! D = N / sqrt(k m) w(u) - d / sqrt(k m),    w = -mu'(u)
//! ```
//!
//! So the critical damping is `sqrt(k m) A y` with a function y of few groups of the machine's numbers:
//!
//! | friction | A | y depends on |
//! | --- | --- | --- |
//! | `stribeck` | N (mu_s - mu_k) / (v_s sqrt(k m)) | A, v / v_s, strengthening v_s^2 / (mu_s - mu_k) |
//! | `coulomb` | - | V / j alone; the damping falls by N strengthening |
//! | `exponential`, `lorentzian` | the same | A, v / v_s, an exponent that varies; the damping falls by N strengthening |
//! | formula, data | N / sqrt(k m) | A, v, and the formula's parameters that vary |
//!
//! y is smooth. It is computed at Chebyshev nodes of the box that contains the machines, and interpolated. A
//! box in which the interpolant differs from samples by more than a set accuracy is cut in two, down to boxes
//! with so few machines that each has its own search. A box in which no search succeeds is not cut. The
//! samples are few, and may miss a feature that is as narrow as that of an outlier of measured friction. So the
//! mean weakening rate, which is y to first order, is compared at many more machines. The guarantee is
//! numerical; [`Found::error`] is the largest error at the samples.
//!
//! Where some orbits may cross the belt line for ever, so does the one from the exit point below another damping, which is
//! above 0 on fast belts only ([`Found::sticks_from`]). It scales as y, and is interpolated from the same nodes.
//!
//! Standard errors of measured friction make y uncertain. The standard deviation of y is another function of
//! the same groups (theory, "Any friction law"). The same orbits give y and its deviation, which is
//! interpolated from the same nodes.

use std::sync::atomic::{AtomicUsize, Ordering};

use rayon::prelude::*;
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::{Column, Law, Strengthening};

use super::{MOST_JOINT, Spread, Uncertain};
use crate::machine::{AREA, BELT_SPEED, Coefficients, FREQUENCY, Friction, Machine, Model, PRESSURE, RADIUS};
use slipmap_numbers::chebyshev::{Side, Tensor};
use slipmap_simulate::critical::{critical_damping, critical_dampings, known_or_nan};
use slipmap_simulate::far_loops::FarLoops;
use slipmap_simulate::sensitivity::sensitivity_of_any_sign;
use slipmap_simulate::{Fate, flow};

/// Tolerance of the root search for a critical damping.
const TOLERANCE: f64 = 1e-9;
/// Largest errors at the samples, in units of the size of the values: of the interpolated y, far below any
/// tolerance of a machine, of its standard deviation, which is an error itself, and of the damping from which on orbits
/// stick.
const ACCURACIES: Values = [1e-6, 1e-2, 1e-3];
/// Largest error of y at the samples in units of its standard deviation, if that is larger: surfaces of rough
/// measured friction have kinks that are far smaller than its standard error.
const ACCURACY_IN_DEVIATIONS: f64 = 3e-3;
/// Number of machines in a box whose critical damping is searched to test the interpolant.
const SAMPLES: usize = 8;
/// Number of machines in a box at which the mean weakening rate tests its interpolant, and the largest error
/// there, in units of the accuracy of y.
const MEANS: usize = 1024;
const MEAN_OFF: f64 = 3.0;
/// Number of nodes along each axis, by the number of axes along which the box has an extent.
const NODES: [usize; 5] = [1, 6, 9, 7, 5];
/// Number of machines in one call of the root search.
const SEARCHED_TOGETHER: usize = 64;
/// Least number of machines per node in a box that is interpolated.
const MACHINES_PER_NODE: usize = 4;

/// Work of the searches of all draws by default, in evaluations of the right-hand side of the Stribeck law:
/// about a minute.
const WORK: u64 = 1_000_000_000;
/// Work counted for a search that fails.
const FAILURE: u64 = 100_000;
/// Work of a search with the derivatives by all data, in units of that of the search alone.
const WITH_DERIVATIVES: u64 = 3;
/// Number of machines of which it is tried whether orbits may cross for ever, and of bisections for the damping from which
/// on they stick.
const TRIED: usize = 64;
const HALVINGS: u32 = 20;

/// Machines, represented by the groups on which y depends.
pub(super) struct Groups<'a> {
    pub(super) nominal: &'a Machine,
    /// Quantities with the errors of a fit.
    joint: Joint,
    /// Positions, among the quantities of the friction, of a formula's parameters, or of the exponent, that vary.
    varied: Vec<usize>,
    /// Number of groups of each machine.
    size: usize,
    /// The groups, machine by machine.
    values: Vec<f64>,
    /// Factor and summand that convert y to the critical damping in SI units.
    scales: Vec<[f64; 2]>,
    /// Whether orbits of some of them may cross the belt line for ever.
    may_cross: bool,
}

/// The critical dampings that were found.
pub(super) struct Found {
    /// The critical damping of each machine, in SI units; NaN if the search failed.
    pub(super) dampings: Vec<f64>,
    /// Largest error of the interpolated dampings at the samples, in SI units.
    pub(super) error: f64,
    /// Their standard deviations due to the standard errors of measured friction, in SI units; NaN where
    /// unknown, 0 for friction without standard errors.
    pub(super) deviations: Vec<f64>,
    /// The dampings, in SI units, below which the orbit from the exit point crosses the belt line for ever; -infinity
    /// where it does at no legal one.
    pub(super) sticks_from: Vec<f64>,
}

/// The searches that are left. Whether they suffice depends on their number alone, not on the threads.
pub(super) struct Searches(AtomicUsize);

impl Searches {
    pub(super) fn new(number: usize) -> Self {
        Self(AtomicUsize::new(number))
    }

    /// Takes this many; `None` once there are not as many left.
    fn take(&self, number: usize) -> Option<()> {
        let less = |left: usize| left.checked_sub(number);
        // What was refused ends the whole answer, so nothing is taken after it.
        match self.0.fetch_update(Ordering::Relaxed, Ordering::Relaxed, less) {
            Ok(_) => Some(()),
            Err(_) => {
                self.0.store(0, Ordering::Relaxed);
                None
            }
        }
    }
}

/// y of one machine, and its standard deviation.
type Pair = [f64; 2];
/// The same, and the damping from which on the orbit from the exit point sticks, in the units of y; -infinity where none
/// is sought.
type Values = [f64; 3];

/// A machine with its values, and the largest error of y at the samples of its box.
struct Placed {
    machine: usize,
    values: Values,
    error: f64,
}

/// A number and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WithError {
    /// The estimate.
    pub value: f64,
    /// Its standard error.
    pub standard_error: f64,
}

/// The critical damping of a machine, which may be negative, and its standard error, in SI units, by the
/// standard errors of its measured friction or by the covariance of a fit among the `uncertain` quantities. `None`
/// if the friction has neither, or the critical damping has no derivatives.
pub fn uncertain_critical_damping(machine: &Machine, uncertain: &[Uncertain]) -> Option<WithError> {
    let joint = joint(uncertain);
    let model = machine.model()?;
    let unit = model.si.units.damping;
    let [value, standard_error] = match (has_standard_errors(machine), joint.is_empty()) {
        (true, _) => of_measured(&model).map(|c| c * unit),
        (false, false) => of_fitted(machine, &joint),
        (false, true) => return None,
    };
    (standard_error >= 0.0).then_some(WithError { value, standard_error })
}

/// Quantities with correlated errors, each with its row of the Cholesky factor.
pub(crate) type Joint = Vec<(&'static str, [f64; MOST_JOINT])>;

/// The quantities whose errors are correlated.
pub(crate) fn joint(uncertain: &[Uncertain]) -> Joint {
    let row = |&(name, spread): &Uncertain| match spread {
        Spread::Joint { row } => Some((name, row)),
        Spread::Normal { .. } | Spread::Uniform { .. } => None,
    };
    uncertain.iter().filter_map(row).collect()
}

/// Machines whose quantities are moved along each independent error.
pub(crate) struct Moved {
    /// By which share of its standard deviation.
    share: f64,
    /// The machines moved forward and backward.
    ends: Vec<[Machine; 2]>,
}

/// Shares of a standard deviation that are tried: wide errors reach machines that are none.
const SHARES: [f64; 4] = [1.0, 0.25, 0.0625, 0.015_625];

impl Moved {
    /// The machines moved as far as they are legal; `None` where that is nowhere.
    pub(crate) fn of(machine: &Machine, joint: &Joint) -> Option<Self> {
        let directions: Vec<usize> =
            (0..joint.len()).filter(|&k| joint.iter().any(|(_, row)| row[k] != 0.0)).collect();
        let moved = |k: usize, by: f64| {
            joint.iter().try_fold(machine.clone(), |machine, (name, row)| {
                let value = machine.quantities().into_iter().find(|(known, _)| known == name)?.1;
                machine.with(name, value + by * row[k]).filter(Machine::is_legal)
            })
        };
        SHARES.into_iter().find_map(|share| {
            let ends = directions.iter().map(|&k| Some([moved(k, share)?, moved(k, -share)?]));
            Some(Self { share, ends: ends.collect::<Option<_>>()? })
        })
    }

    /// The standard error of a number of the machine; `None` where it is unknown of one of them.
    pub(crate) fn error(&self, of: impl Fn(&Machine) -> Option<f64>) -> Option<f64> {
        let half = |[after, before]: &[Machine; 2]| Some(0.5 * (of(after)? - of(before)?) / self.share);
        let halves = self.ends.iter().map(half).collect::<Option<Vec<f64>>>()?;
        Some(halves.iter().map(|half| half * half).sum::<f64>().sqrt())
    }
}

/// The critical damping of a machine with fitted friction, and its standard deviation by the covariance of the fit,
/// from differences over a standard deviation; both in SI units, NaN where unknown.
fn of_fitted(machine: &Machine, joint: &Joint) -> Pair {
    let critical = |machine: &Machine| {
        let model = machine.model()?;
        Some(known_or_nan(critical_damping(&model.column(), TOLERANCE)) * model.si.units.damping)
    };
    let error = Moved::of(machine, joint).and_then(|moved| moved.error(critical));
    [critical(machine), error].map(|value| value.unwrap_or(f64::NAN))
}

/// The critical damping of a machine with measured friction, and its standard deviation by the standard
/// errors of the data; both dimensionless, NaN where unknown. A negative critical damping has a deviation,
/// too: other data may have a positive one.
fn of_measured(model: &Model) -> Pair {
    let column = model.column();
    match sensitivity_of_any_sign(&column) {
        Ok(found) => {
            let critical = found.critical;
            // In SI the unit of friction is not the static friction. A search may end with a negative
            // critical damping that is known to be negative only.
            let deviation = found.standard_error_in_fixed_unit.filter(|_| critical.is_located());
            [critical.c, deviation.map_or(f64::NAN, |deviation| deviation.value)]
        }
        Err(_) => [known_or_nan(critical_damping(&column, TOLERANCE)), f64::NAN],
    }
}

/// The damping c of a column below which the orbit from the exit point crosses the belt line for ever, `critical` being
/// c*: bisected from there to 0 and as far beyond. Where the orbit leaves the data it is taken to stick.
fn sticks_from(column: &Column, critical: f64) -> f64 {
    let crosses = |c: f64| {
        let fate = flow(&Oscillator::in_column(column, c), TOLERANCE).fate;
        matches!(fate, Fate::CrossesForever)
    };
    let (mut low, mut high) = (critical - 2.0 * critical.abs(), critical);
    if !crosses(low) {
        return low;
    }
    for _ in 0..HALVINGS {
        let middle = 0.5 * (low + high);
        *(if crosses(middle) { &mut low } else { &mut high }) = middle;
    }
    high
}

impl<'a> Groups<'a> {
    /// An empty collection of machines that differ from `nominal` only in the quantities `uncertain`.
    pub(super) fn new(nominal: &'a Machine, uncertain: &[Uncertain]) -> Self {
        let (joint, uncertain) = (joint(uncertain), varying(uncertain));
        let is_group = |name: &str| match &nominal.friction {
            Friction::Formula(..) => true,
            _ => name == Coefficients::EXPONENT,
        };
        let names = nominal.friction.quantities().into_iter().enumerate();
        let varied = names.filter(|(_, (name, _))| is_group(name) && uncertain.contains(name));
        let varied: Vec<usize> = varied.map(|(i, _)| i).collect();
        let size = 2 + varied.len() + usize::from(strengthening(nominal) == Some(Strengthening::Quadratic));
        Self { nominal, joint, varied, size, values: Vec::new(), scales: Vec::new(), may_cross: false }
    }

    /// Whether the friction has errors of its own: those of data, or of a fit.
    pub(super) fn has_errors(&self) -> bool {
        has_standard_errors(self.nominal) || !self.joint.is_empty()
    }

    /// Returns whether so few groups vary with the `uncertain` quantities that y can be interpolated. If not,
    /// each machine has its own search.
    pub(super) fn can_be_interpolated(&self, uncertain: &[Uncertain]) -> bool {
        let uncertain = varying(uncertain);
        let any = |names: &[&str]| usize::from(names.iter().any(|name| uncertain.contains(name)));
        let forces = ["mass", "stiffness", "normal_force", FREQUENCY, PRESSURE, AREA, RADIUS];
        match &self.nominal.friction {
            Friction::Formula(..) => {
                let wide = any(&forces) + any(&[BELT_SPEED]) + self.varied.len();
                wide < NODES.len()
            }
            Friction::Coefficients(..) | Friction::Measured(_) => true,
        }
    }

    /// The number of searches that take as much work as may be spent by default, judged by the nominal machine.
    pub(super) fn affordable(&self) -> usize {
        let Some(column) = self.nominal.model().map(|model| model.column()) else { return 0 };
        let rhs = critical_damping(&column, TOLERANCE).map_or(FAILURE, |root| root.rhs);
        let of_data = if has_standard_errors(self.nominal) { WITH_DERIVATIVES } else { 1 };
        let orbits = of_data + 2 * self.joint.len() as u64;
        (WORK / (orbits * rhs.max(1) * column.curve.cost())) as usize
    }

    pub(super) fn push(&mut self, machine: &Machine) {
        let root = (machine.stiffness * machine.mass).sqrt();
        let (force, speed) = (machine.normal_force / root, machine.belt_speed);
        let (a, shift) = match &machine.friction {
            // Slip motion is linear: the drop of the force and the belt speed enter by their ratio alone.
            Friction::Coefficients(law, of) if *law.as_written() == Law::Coulomb => {
                let drop = force * (of.static_friction - of.kinetic_friction);
                self.values.extend([0.0, (speed / drop).ln()]);
                (if drop > 0.0 { 1.0 } else { 0.0 }, -machine.normal_force * of.strengthening)
            }
            Friction::Coefficients(_, of) => {
                let fall = of.static_friction - of.kinetic_friction;
                let width = of.stribeck_velocity;
                let a = force * fall / width;
                self.values.extend([a.ln(), (speed / width).ln()]);
                self.values.extend(self.varied.iter().map(|_| of.exponent));
                match strengthening(machine) {
                    Some(Strengthening::Quadratic) => {
                        self.values.push(of.strengthening * width * width / fall);
                        (a, 0.0)
                    }
                    Some(Strengthening::Linear) | None => (a, -machine.normal_force * of.strengthening),
                }
            }
            Friction::Formula(_, parameters) => {
                self.values.extend([force.ln(), speed.ln()]);
                self.values.extend(self.varied.iter().map(|&position| parameters.as_slice()[position]));
                (force, 0.0)
            }
            Friction::Measured(_) => {
                self.values.extend([force.ln(), speed.ln()]);
                (force, 0.0)
            }
        };
        self.scales.push([root * a, shift]);
    }

    /// Appends the machines of another collection.
    pub(super) fn append(&mut self, mut others: Groups) {
        self.values.append(&mut others.values);
        self.scales.append(&mut others.scales);
    }

    fn of(&self, machine: usize) -> &[f64] {
        &self.values[machine * self.size..(machine + 1) * self.size]
    }

    /// The nominal machine changed to these groups; `None` if that machine is not legal, for instance if the
    /// nominal friction does not fall.
    fn machine_with(&self, groups: &[f64]) -> Option<Machine> {
        let mut machine = self.nominal.clone();
        let root = (machine.stiffness * machine.mass).sqrt();
        let (a, speed) = (groups[0].exp(), groups[1].exp());
        match &mut machine.friction {
            Friction::Coefficients(law, of) if *law.as_written() == Law::Coulomb => {
                let drop = machine.normal_force / root * (of.static_friction - of.kinetic_friction);
                of.strengthening = 0.0;
                machine.belt_speed = speed * drop;
            }
            Friction::Coefficients(_, of) => {
                let fall = of.static_friction - of.kinetic_friction;
                let width = of.stribeck_velocity;
                // The quadratic law has no exponent.
                match groups.get(2) {
                    Some(&exponent) if !self.varied.is_empty() => {
                        (of.exponent, of.strengthening) = (exponent, 0.0)
                    }
                    strengthening => {
                        of.strengthening = strengthening.map_or(0.0, |b| b * fall / (width * width))
                    }
                }
                machine.normal_force = a * width * root / fall;
                machine.belt_speed = speed * width;
            }
            Friction::Formula(_, parameters) => {
                machine.normal_force = a * root;
                machine.belt_speed = speed;
                for (&position, &value) in self.varied.iter().zip(&groups[2..]) {
                    parameters.set(position, value);
                }
            }
            Friction::Measured(_) => {
                machine.normal_force = a * root;
                machine.belt_speed = speed;
            }
        }
        machine.is_legal().then_some(machine)
    }

    /// The nominal machine changed to these groups, and y in units of its dimensionless critical damping.
    fn model_with(&self, groups: &[f64]) -> Option<(Model, f64)> {
        let machine = self.machine_with(groups)?;
        let factor = (machine.stiffness * machine.mass).sqrt() * groups[0].exp();
        let model = machine.model()?;
        let scale = model.si.units.damping / factor;
        Some((model, scale))
    }

    /// y at these groups to first order: from the mean weakening rate over the grazing circle.
    fn mean(&self, groups: &[f64]) -> f64 {
        self.model_with(groups).map_or(f64::NAN, |(model, scale)| {
            let column = model.column();
            column.curve.mean_weakening_of_many(column.belt_speed) / column.epsilon * scale
        })
    }

    /// y, its standard deviation and the damping from which on orbits stick, by searches for each of these groups; NaN
    /// if the search failed.
    fn searched(&self, groups: &[&[f64]]) -> Vec<Values> {
        let pairs = self.searched_pairs(groups);
        let of_one = |(groups, [y, deviation]): (&&[f64], Pair)| {
            let sticks_from = match self.may_cross {
                true => self
                    .model_with(groups)
                    .map_or(f64::NAN, |(model, scale)| scale * sticks_from(&model.column(), y / scale)),
                false => f64::NEG_INFINITY,
            };
            [y, deviation, sticks_from]
        };
        groups.par_iter().zip(pairs).map(of_one).collect()
    }

    /// Whether some orbit of one of the machines may cross the belt line for ever, as far as a part of them tell.
    fn some_may_cross(&self) -> bool {
        let tried = (0..self.scales.len()).step_by(self.scales.len().div_ceil(TRIED).max(1));
        let may = |machine: usize| {
            self.model_with(self.of(machine)).is_some_and(|(model, _)| {
                let column = model.column();
                FarLoops::where_friction_resists(&column.curve, column.belt_speed).inward_from(0.0) > 0.0
            })
        };
        tried.into_iter().any(may)
    }

    fn searched_pairs(&self, groups: &[&[f64]]) -> Vec<Pair> {
        if has_standard_errors(self.nominal) {
            let of_one = |groups: &&[f64]| {
                self.model_with(groups)
                    .map_or([f64::NAN; 2], |(model, scale)| of_measured(&model).map(|x| x * scale))
            };
            return groups.par_iter().map(of_one).collect();
        }
        if !self.joint.is_empty() {
            let of_one = |groups: &&[f64]| {
                self.machine_with(groups).map_or([f64::NAN; 2], |machine| {
                    let factor = (machine.stiffness * machine.mass).sqrt() * groups[0].exp();
                    of_fitted(&machine, &self.joint).map(|x| x / factor)
                })
            };
            return groups.par_iter().map(of_one).collect();
        }
        let of_some = |groups: &[&[f64]]| {
            let models: Vec<Option<(Model, f64)>> =
                groups.iter().map(|groups| self.model_with(groups)).collect();
            let columns: Vec<Column> = models.iter().flatten().map(|(model, _)| model.column()).collect();
            let mut roots = critical_dampings(&columns, TOLERANCE).into_iter();
            let mut y = |(_, scale): &(Model, f64)| roots.next().map_or(f64::NAN, known_or_nan) * scale;
            let y = |model: &Option<(Model, f64)>| [model.as_ref().map_or(f64::NAN, &mut y), 0.0];
            models.iter().map(y).collect::<Vec<Pair>>()
        };
        groups.par_chunks(SEARCHED_TOGETHER).flat_map_iter(of_some).collect()
    }

    /// y and its standard deviation for these machines, each by a root search.
    fn exact(&self, machines: &[usize]) -> Vec<Values> {
        self.searched(&machines.iter().map(|&machine| self.of(machine)).collect::<Vec<_>>())
    }

    /// The critical damping of every machine; `None` where the budget does not suffice.
    pub(super) fn critical_dampings(&mut self, budget: &Searches) -> Option<Found> {
        self.may_cross = self.some_may_cross();
        let all: Vec<usize> = (0..self.scales.len()).collect();
        let (mut known, mut unknown): (Vec<usize>, Vec<usize>) =
            all.into_iter().partition(|&machine| self.of(machine).iter().all(|group| group.is_finite()));
        let mut dampings = vec![f64::NAN; self.scales.len()];
        let mut deviations = vec![0.0; self.scales.len()];
        let mut sticks_from = vec![f64::NEG_INFINITY; self.scales.len()];
        let mut largest = 0.0_f64;
        for Placed { machine, values: [y, deviation, from], error } in self.boxed(&mut known, budget)? {
            let [factor, shift] = self.scales[machine];
            dampings[machine] = factor * y + shift;
            sticks_from[machine] = factor * from + shift;
            deviations[machine] = if deviation < 0.0 { 0.0 } else { factor * deviation };
            largest = largest.max((factor * error).abs());
        }
        // Friction that does not fall with speed has a factor <= 0: no damping is needed.
        unknown.retain(|&machine| self.scales[machine][0] <= 0.0);
        for machine in unknown {
            dampings[machine] = self.scales[machine][1].min(0.0);
        }
        Some(Found { dampings, error: largest, deviations, sticks_from })
    }

    /// The values of these machines, interpolated over their box, over its parts, or by a search for each;
    /// `None` where the budget does not suffice.
    fn boxed(&self, machines: &mut [usize], budget: &Searches) -> Option<Vec<Placed>> {
        let Some((sides, nodes)) =
            self.sides(machines).filter(|(_, nodes)| machines.len() > MACHINES_PER_NODE * nodes)
        else {
            budget.take(machines.len())?;
            let values = self.exact(machines).into_iter();
            let placed = machines.iter().zip(values);
            return Some(placed.map(|(&machine, values)| Placed { machine, values, error: 0.0 }).collect());
        };
        budget.take(nodes + SAMPLES)?;
        // Equally spaced samples of the machines, which are in the order of the draws.
        let step = machines.len() / SAMPLES;
        let samples: Vec<usize> = (0..SAMPLES).map(|i| machines[i * step]).collect();
        let points = Tensor::points(&sides);
        let all: Vec<&[f64]> =
            points.iter().map(Vec::as_slice).chain(samples.iter().map(|&machine| self.of(machine))).collect();
        let values = self.searched(&all);
        let (at_nodes, at_samples) = values.split_at(nodes);
        let surfaces =
            [0, 1, 2].map(|of| Tensor::through(&sides, at_nodes.iter().map(|values| values[of]).collect()));
        let errors = [0, 1, 2].map(|of| {
            let missed = samples.iter().zip(at_samples);
            let missed = missed.map(|(&m, exact)| (surfaces[of].at(self.of(m)) - exact[of]).abs());
            missed.fold(0.0, |most: f64, miss| if miss.is_nan() { f64::INFINITY } else { most.max(miss) })
        });
        let enough = [0, 1, 2].map(|of| ACCURACIES[of] * surfaces[of].size());
        let enough = [enough[0].max(ACCURACY_IN_DEVIATIONS * surfaces[1].size()), enough[1], enough[2]];
        let tested = if self.may_cross { 3 } else { 2 };
        let rough = (0..tested).find(|&of| {
            let unknown = values.iter().all(|values| values[of].is_nan());
            // A node without an answer makes the size NaN, so such a box is cut too.
            !unknown && !(errors[of] <= enough[of])
        });
        let found_none = values.iter().all(|values| values[0].is_nan());
        let rough = rough.map(|of| surfaces[of].roughest()).or_else(|| {
            if found_none {
                return None;
            }
            let means = Tensor::through(&sides, points.iter().map(|point| self.mean(point)).collect());
            let tested: Vec<&usize> = machines.iter().step_by(machines.len().div_ceil(MEANS)).collect();
            let misses = |machine: &&usize| {
                let groups = self.of(**machine);
                !((means.at(groups) - self.mean(groups)).abs() <= MEAN_OFF * enough[0])
            };
            tested.par_iter().any(misses).then(|| means.roughest())
        });
        let Some(axis) = rough else {
            let measured = self.has_errors();
            let values = |point: &[f64]| {
                let deviation = if measured { surfaces[1].at(point) } else { 0.0 };
                let from = if self.may_cross { surfaces[2].at(point) } else { f64::NEG_INFINITY };
                [surfaces[0].at(point), deviation, from]
            };
            let placed =
                |&machine: &usize| Placed { machine, values: values(self.of(machine)), error: errors[0] };
            return Some(machines.iter().map(placed).collect());
        };
        let middle = machines.len() / 2;
        let place = |machine: &usize| self.of(*machine)[axis];
        machines.select_nth_unstable_by(middle, |a, b| place(a).total_cmp(&place(b)).then(a.cmp(b)));
        let (below, above) = machines.split_at_mut(middle);
        below.sort_unstable();
        above.sort_unstable();
        let (below, above) = rayon::join(|| self.boxed(below, budget), || self.boxed(above, budget));
        let (mut below, mut above) = below.zip(above)?;
        below.append(&mut above);
        Some(below)
    }

    /// The smallest box that contains these machines, and its number of nodes; `None` if it has too many
    /// axes.
    fn sides(&self, machines: &[usize]) -> Option<(Vec<Side>, usize)> {
        let mut sides = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.size];
        for &machine in machines {
            for (side, &value) in sides.iter_mut().zip(self.of(machine)) {
                *side = [side[0].min(value), side[1].max(value)];
            }
        }
        // Values that differ only by round-off are taken as equal.
        for side in &mut sides {
            if side[1] - side[0] <= 1e-12 * (1.0 + side[0].abs()) {
                side[1] = side[0];
            }
        }
        let wide = sides.iter().filter(|[lo, hi]| hi > lo).count();
        let along = *NODES.get(wide)?;
        let side = |range: [f64; 2]| Side { range, count: if range[1] > range[0] { along } else { 1 } };
        Some((sides.into_iter().map(side).collect(), along.pow(wide as u32)))
    }
}

/// Returns whether the friction was measured with standard errors.
pub(super) fn has_standard_errors(machine: &Machine) -> bool {
    matches!(&machine.friction, Friction::Measured(table) if table.standard_errors().is_some())
}

/// The names of the quantities that draws change.
fn varying(uncertain: &[Uncertain]) -> Vec<&'static str> {
    let is_drawn = |(_, spread): &&Uncertain| !matches!(spread, Spread::Joint { .. });
    uncertain.iter().filter(is_drawn).map(|(name, _)| *name).collect()
}

/// How the friction rises at high slip speed; `None` for formulas and data.
fn strengthening(machine: &Machine) -> Option<Strengthening> {
    match &machine.friction {
        Friction::Coefficients(law, _) => law.built_in().map(|law| law.strengthening),
        Friction::Formula(..) | Friction::Measured(_) => None,
    }
}

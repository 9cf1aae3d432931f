//! Sensitivities of the critical damping to the friction law's parameters, eps, the belt speed, each slip
//! speed of the friction curve, and each datum of a measured one.
//!
//! A change dw of the weakening rate moves C = eps c by its **weighted mean** over the grazing orbit (theory, "Any
//! friction law"),
//!
//! ```text
//! dC = integral of W dw dt / integral of W dt,    W = x2'^2 exp(-G) >= 0,    G(t) = integral of D from 0 to t.
//! ```
//!
//! **A drop** j of friction as slip begins moves the start of the orbit, (V, -j). Its derivative is dC/dj = j /
//! (integral of W dt), and dC/dV has the further term -(j^2 / V) / (integral of W dt).
//!
//! **Accuracy.** The integrals use Gauss's rule of five points on each step of the orbit. Errors are
//! estimated from two orbits, one much coarser, and from the error of the critical damping.

use std::sync::LazyLock;

use super::critical::is_known;
use super::{CriticalDamping, NoCriticalDamping, critical_damping};
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::flow::Failure;
use slipmap_model::friction::{Column, Law, Table};
use slipmap_numbers::gauss::Rule;
use slipmap_numbers::jet::Jet;
use slipmap_orbits::arc::{LowerEnd, State, Walk};
use slipmap_orbits::dop853::STAGES;
use slipmap_orbits::{Piece, Work};

/// Error of the critical damping, in units of the divergence.
const CRITICAL: f64 = 1e-13;
/// Tolerances of the two orbits.
const TOLERANCES: [f64; 2] = [1e-13, 1e-10];
/// Round-off of a mean, relative to the largest term.
const ROUND_OFF: f64 = 64.0 * f64::EPSILON;

/// A number with its error.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, schemars::JsonSchema)]
pub struct Estimate {
    /// The number; of a derivative by a parameter, V or eps NaN where its error is more than 1 % of it and
    /// 1e-9.
    #[schemars(with = "Option<f64>")]
    pub value: f64,
    /// Estimate of its absolute error.
    pub error: f64,
}

/// The derivatives of the critical damping.
#[derive(Clone, Debug, PartialEq)]
pub struct Sensitivity {
    /// The critical damping c* itself.
    pub critical: CriticalDamping,
    /// dc*/d eps.
    pub by_epsilon: Estimate,
    /// dc*/dV.
    pub by_belt_speed: Estimate,
    /// dc*/dp for each parameter p, in the order of [`slipmap_model::friction::Law::parameters`].
    pub by_parameters: Vec<Estimate>,
    /// dc*/df for each friction value f of a table with standard errors, in the units of its data and with
    /// the unit of friction held fixed; empty for other laws.
    pub by_data: Vec<Estimate>,
    /// The standard error of c* by the independent standard errors of a table's data, the first of which is
    /// the unit of friction; `None` where the law has none. To first order in the change of the weakening
    /// rate, which itself is that of random data.
    pub standard_error: Option<Estimate>,
    /// The same with the unit of friction held fixed.
    pub standard_error_in_fixed_unit: Option<Estimate>,
}

impl Sensitivity {
    /// The derivatives by eps, by the parameters of `law` and by V, each with the name of its axis.
    pub fn named(&self, law: &Law) -> impl Iterator<Item = (&'static str, Estimate)> {
        let parameters = law.parameters().iter().map(|parameter| parameter.name);
        std::iter::once(("epsilon", self.by_epsilon))
            .chain(parameters.zip(self.by_parameters.iter().copied()))
            .chain([("V", self.by_belt_speed)])
    }
}

/// The weight of a range of slip speeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Influence {
    /// Lower end of the range.
    pub from: f64,
    /// Upper end of the range.
    pub to: f64,
    /// Share of the weight: a change of the weakening rate by dw throughout the range moves eps c* by the
    /// share times dw. All shares add up to one.
    pub share: f64,
}

/// Reason why the critical damping has no derivatives.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum NoSensitivity {
    /// There is no critical damping.
    #[error(transparent)]
    Critical(#[from] NoCriticalDamping),
    /// c* < 0: the orbit returns for no legal damping.
    #[error("the critical damping is negative: no legal damping lets the orbit come back")]
    Negative,
    /// The grazing orbit could not be followed.
    #[error("the grazing orbit could not be followed: {0}")]
    Orbit(#[from] Failure),
}

/// The derivatives of the critical damping of a column.
///
/// # Errors
/// [`NoSensitivity`].
pub fn sensitivity(column: &Column) -> Result<Sensitivity, NoSensitivity> {
    at(column, legal_critical_damping(column)?)
}

/// The derivatives of the critical damping, also of a negative one, at which a grazing orbit closes, too.
///
/// # Errors
/// [`NoSensitivity`], but not [`NoSensitivity::Negative`].
pub fn sensitivity_of_any_sign(column: &Column) -> Result<Sensitivity, NoSensitivity> {
    at(column, critical_damping(column, CRITICAL)?.known()?)
}

/// The derivatives on the orbit that grazes at the damping `critical`.
fn at(column: &Column, critical: CriticalDamping) -> Result<Sensitivity, NoSensitivity> {
    let work = Work::of(Piece::Sensitivity, &column.curve);
    // What the curve between rows could be jumps within their pieces.
    let edges = column.curve.table().map(Table::meets).unwrap_or_default();
    let orbit = |c: f64, tolerance: f64| grazing_orbit(column, c, tolerance, &edges, &work);
    let c = beyond(critical);
    let Weighted { samples, total } = orbit(c, TOLERANCES[0])?;
    let fine = means(column, critical.c, &samples, total);
    let rough = orbit(c + critical.error, TOLERANCES[1])?;
    let coarse = means(column, c, &rough.samples, rough.total);
    let estimates = |fine: &[Term], coarse: &[Term]| -> Vec<Estimate> {
        let pairs = fine.iter().zip(coarse);
        let estimate = |(fine, coarse): (&Term, &Term)| Estimate {
            value: fine.value,
            error: (fine.value - coarse.value).abs() + ROUND_OFF * fine.size,
        };
        pairs.map(estimate).collect()
    };
    let by_data = estimates(&fine.by_data, &coarse.by_data);
    let mut estimates = estimates(&fine.by_parameters, &coarse.by_parameters);
    for Estimate { value, error } in &mut estimates {
        if !is_known(*value, *error) {
            *value = f64::NAN;
        }
    }
    let standard_errors = standard_errors(column, [&samples, &rough.samples], &by_data);
    Ok(Sensitivity {
        critical,
        by_epsilon: estimates[0],
        by_belt_speed: estimates[1],
        by_parameters: estimates[2..].to_vec(),
        by_data,
        standard_error_in_fixed_unit: standard_errors.map(|[fixed, _]| fixed),
        standard_error: standard_errors.map(|[_, moved]| moved),
    })
}

/// Standard errors of c* by those of a table's data and the curve between them, with the unit of friction held fixed and
/// moved, on the first of two orbits; the other one is much coarser. `None` without errors of the data.
fn standard_errors(
    column: &Column,
    orbits: [&[(f64, f64)]; 2],
    by_data: &[Estimate],
) -> Option<[Estimate; 2]> {
    let (table, epsilon) = (column.curve.table()?, column.epsilon);
    let errors = table.standard_errors()?;
    let of_rate: Vec<f64> = by_data.iter().map(|by| by.value * epsilon).collect();
    // Of a drop, the start of the orbit moves with the first datum, too: to first order.
    let found = match column.curve.drop() > 0.0 {
        true => [(table.variance_of_sum(&of_rate).sqrt(), 0.0); 2],
        false => table.standard_errors_of_data(orbits[0], &of_rate)?,
    };
    let [of_curve, coarse] = orbits.map(|orbit| table.error_of_curve(orbit));
    // The root of a sum of squares changes at most by that of the changes.
    let of_orbit =
        by_data.iter().zip(errors).map(|(by, error)| (by.error * error).powi(2)).sum::<f64>().sqrt();
    Some(found.map(|(of_data, sampling)| {
        let value = of_data.hypot(of_curve);
        let sampling = if value > 0.0 { sampling * (of_data / value) } else { 0.0 };
        let of_orbit = of_orbit + (of_curve - coarse).abs() / epsilon;
        Estimate { value: value / epsilon, error: sampling / epsilon + of_orbit }
    }))
}

/// The weight of the friction's slope for the critical damping, on `parts` equal ranges of slip speeds from 0
/// to the fastest on the grazing orbit.
///
/// # Errors
/// [`NoSensitivity`].
pub fn influence(column: &Column, parts: usize) -> Result<Vec<Influence>, NoSensitivity> {
    let critical = legal_critical_damping(column)?;
    let work = Work::of(Piece::Sensitivity, &column.curve);
    let c = beyond(critical);
    let fastest = fastest(&grazing_orbit(column, c, TOLERANCES[0], &[], &work)?.samples);
    let edge = |part: usize| part as f64 / parts as f64 * fastest;
    let edges: Vec<f64> = (1..parts).map(edge).collect();
    let orbit = grazing_orbit(column, c, TOLERANCES[0], &edges, &work)?;
    let mut shares = vec![0.0; parts];
    for (slip, weight) in &orbit.samples {
        let part = (slip / fastest * parts as f64) as usize;
        shares[part.min(parts - 1)] += weight;
    }
    let parts = shares.into_iter().enumerate();
    Ok(parts.map(|(part, share)| Influence { from: edge(part), to: edge(part + 1), share }).collect())
}

/// The damping at which the grazing orbit is followed: where it grazes within rounding, whether it meets the belt line
/// before its maximum takes a thousand times the work to find, and often all that is allowed.
fn beyond(critical: CriticalDamping) -> f64 {
    critical.c + critical.error
}

fn legal_critical_damping(column: &Column) -> Result<CriticalDamping, NoSensitivity> {
    let critical = critical_damping(column, CRITICAL)?.known()?;
    if critical.c < 0.0 { Err(NoSensitivity::Negative) } else { Ok(critical) }
}

/// Length of pieces of a law, in units of V, below which steps also end at every second end of a piece: the
/// integrands change as fast as the law does, and faster than the orbit.
const FINE: f64 = 0.01;

/// An orbit as a quadrature rule.
struct Weighted {
    /// The slip speed at each point, and its share of the weight.
    samples: Vec<(f64, f64)>,
    /// The integral of W.
    total: f64,
}

/// The grazing orbit, from the exit point to its next maximum of x2. Steps also end at the slip speeds `edges`.
fn grazing_orbit(
    column: &Column,
    c: f64,
    tolerance: f64,
    edges: &[f64],
    work: &Work,
) -> Result<Weighted, Failure> {
    let oscillator = Oscillator::in_column(column, c);
    let belt_speed = oscillator.belt_speed;
    let mut stops = [&column.curve.stops(belt_speed), edges].concat();
    if !column.curve.has_known_features() {
        let weakening = column.compiled();
        let pieces = weakening.breaks().windows(2).filter(|ends| ends[1] - ends[0] < FINE * belt_speed);
        stops.extend(pieces.map(|ends| ends[1]).step_by(2));
    }
    stops.sort_by(f64::total_cmp);
    let walk = Walk::from_line(&oscillator, Side::Below, -column.curve.drop(), tolerance, work);
    let mut walk = walk.stopping_at(&stops);
    static RULE: LazyLock<Rule<5>> = LazyLock::new(Rule::gauss);
    let rule = &*RULE;
    // Slip speeds, weights without exp(-G), and -G, which may exceed the range of the exponential.
    let mut points = Vec::new();
    let end = walk.lower_arc(|walk, from: &State, to: &State| {
        let h = to.time - from.time;
        for (node, weight) in rule.nodes.into_iter().zip(rule.weights) {
            // If this exceeds the budget, the next step of the walk fails.
            let _ = work.spend(STAGES as u64);
            let state = walk.after(from, 0.5 * (1.0 + node) * h);
            points.push((walk.slip(&state).slip.max(0.0), weight * h * state.w * state.w, -state.growth));
        }
    })?;
    if end == LowerEnd::Rests {
        // The orbit does not return, so it does not graze: the angle advances too slowly.
        return Err(Failure::StepUnderflow);
    }
    let largest = points.iter().map(|point| point.2).fold(f64::NEG_INFINITY, f64::max);
    let weights: Vec<f64> = points.iter().map(|(_, weight, log)| weight * (log - largest).exp()).collect();
    let total: f64 = weights.iter().sum();
    if !(total > 0.0 && total.is_finite()) {
        return Err(Failure::NotFinite);
    }
    let samples = points.iter().zip(&weights).map(|((slip, ..), weight)| (*slip, weight / total));
    // The weights of the rule add up to 2 on each step.
    Ok(Weighted { samples: samples.collect(), total: 0.5 * total * largest.exp() })
}

fn fastest(orbit: &[(f64, f64)]) -> f64 {
    orbit.iter().map(|(slip, _)| *slip).fold(0.0, f64::max)
}

/// A derivative of c*, and the mean size of its terms.
#[derive(Clone, Copy, Debug, Default)]
struct Term {
    value: f64,
    size: f64,
}

impl Term {
    fn add(&mut self, x: f64) {
        self.value += x;
        self.size += x.abs();
    }

    fn over(self, epsilon: f64) -> Self {
        Self { value: self.value / epsilon, size: self.size / epsilon }
    }
}

/// Derivatives of c*.
struct Means {
    /// Derivatives by eps, V and the law's parameters.
    by_parameters: Vec<Term>,
    /// Derivatives by a table's data, with the unit of friction held fixed.
    by_data: Vec<Term>,
}

/// The derivatives; `total`, the integral of W, of the orbit from the exit point.
fn means(column: &Column, c: f64, orbit: &[(f64, f64)], total: f64) -> Means {
    let Column { curve, epsilon, belt_speed, .. } = column;
    let weakening = curve.compiled((4.0 * belt_speed).max(1.01 * fastest(orbit)));
    let mut terms = vec![Term::default(); 2];
    terms[0].add(-c);
    let measured = curve.table().and_then(|table| Some((table, table.standard_errors()?.len())));
    let mut data = vec![Term::default(); measured.map_or(0, |(_, data)| data)];
    for &(slip, weight) in orbit {
        let gradient = curve.weakening_gradient(slip);
        let by_parameters = gradient.parameters.as_slice();
        terms.resize(2 + by_parameters.len(), Term::default());
        // A formula's own series is used, since the digits of the polynomials depend on earlier compilations.
        let slope = match curve.formula(Jet::<f64, 3>::variable(slip, 1.0)) {
            Some(phi) => -2.0 * phi.0[2],
            None => weakening.slope(slip),
        };
        terms[0].add(weight * gradient.epsilon);
        terms[1].add(weight * slope * slip / belt_speed);
        for (term, by) in terms[2..].iter_mut().zip(by_parameters) {
            term.add(weight * by);
        }
        if let Some((table, _)) = measured {
            let (first, by_data) = table.weakening_by_data(slip);
            for (sum, by) in data[first..].iter_mut().zip(by_data) {
                sum.add(weight * by);
            }
        }
    }
    if curve.drop() > 0.0 {
        let by_drop = curve.drop() / total;
        terms[1].add(-by_drop * curve.drop() / belt_speed);
        let of_drop = curve.drop_gradient();
        terms[0].add(by_drop * of_drop.epsilon);
        for (term, by) in terms[2..].iter_mut().zip(of_drop.parameters.as_slice()) {
            term.add(by_drop * by);
        }
        if let Some((table, _)) = measured {
            for (sum, by) in data.iter_mut().zip(table.first_by_data()) {
                sum.add(-by_drop / table.static_level() * by);
            }
        }
    }
    let over = |terms: Vec<Term>| terms.into_iter().map(|term| term.over(*epsilon)).collect();
    Means { by_parameters: over(terms), by_data: over(data) }
}

//! The backbone C(r) of a column: for each amplitude r in (0, V] the one damping at which the orbit with
//! maximum x2 = r closes.
//!
//! The right side of the scalar form increases with D at every angle, so the return map P(r; C) falls
//! strictly with C, and P(r; C) = r has one root C(r) (theory, "The backbone"). Every slip cycle of every
//! damping of the column lies on this curve: at C = eps c they are the solutions of C(r) = C; a cycle
//! attracts where C falls with r and repels where it rises. C(0+) is the weakening rate at belt speed (Hopf),
//! C(V) is eps c* (grazing), and the extremes between are folds.
//!
//! C is interpolated in r by Chebyshev polynomials through nodes that are doubled until the coefficients have
//! decayed.
//!
//! **Error.** Twice the sum of the sizes of the last quarter of the coefficients, with the largest error of
//! the nodes times the Lebesgue constant. It is numerical, not a bound: [`super::slip_count`] proves counts.

use std::f64::consts::PI;

use super::Failure;
use super::closed_orbit::closing_damping_of_node;
use super::closing::closing_dampings;
use super::polar::Closing;
use super::work::Work;
use crate::friction::{Column, Curve};

/// Least and largest number of intervals between nodes.
const SIZES: [usize; 2] = [8, 128];
/// The largest where the law has corners: C is then smooth to finite order only, and more nodes gain
/// little.
const FINEST_WITH_CORNERS: usize = 64;

/// Largest error, relative to the largest |C|, of a backbone that is clear about the number of cycles.
/// Interpolants through nine nodes counted eleven of 120,000 cases of rough random laws wrong, each with an
/// error above 8e-3 of that size.
const CLEAR: f64 = 1e-3;

/// An extreme of C(r), or one of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningPoint {
    /// The amplitude r: largest x2 on the orbit.
    pub radius: f64,
    /// C = eps c there.
    pub viscous: f64,
}

/// A slip cycle at some damping, as read from the backbone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// Bounds of its amplitude, between which there is no other cycle.
    pub between: [f64; 2],
    /// Whether it attracts.
    pub is_stable: bool,
}

/// The backbone of a column, for 0 <= r <= V.
#[derive(Clone, Debug, PartialEq)]
pub struct Backbone {
    curve: Curve,
    belt_speed: f64,
    /// Accuracy asked of it.
    tolerance: f64,
    /// C at the nodes, from r = V down to 0.
    values: Vec<f64>,
    /// Largest error of these.
    node_error: f64,
    /// Whether more nodes would gain nothing.
    is_resolved: bool,
    /// Coefficients of C along the Chebyshev polynomials in 2 r / V - 1.
    series: Vec<f64>,
    turning_points: Vec<TurningPoint>,
    /// C at the extremes of the interpolant that may be due to its error.
    doubtful: Vec<f64>,
    /// Estimate of the absolute error of C at any r.
    pub error: f64,
    /// Number of evaluations of the right-hand side, where the polar form was used.
    pub rhs: u64,
}

/// Computes C at amplitudes.
struct Solver<'a> {
    curve: &'a Curve,
    belt_speed: f64,
    tolerance: f64,
    work: &'a Work,
    /// Largest error so far.
    error: f64,
    rhs: u64,
}

impl Solver<'_> {
    fn at(&mut self, radii: &[f64]) -> Result<Vec<f64>, Failure> {
        let (curve, belt_speed, tolerance, work) = (self.curve, self.belt_speed, self.tolerance, self.work);
        let orbits: Vec<(&Curve, f64, f64)> =
            radii.iter().map(|radius| (curve, belt_speed, *radius)).collect();
        let found = closing_dampings(&orbits, tolerance, Some(work)).into_iter().zip(radii);
        found
            .map(|(found, radius)| {
                let (Ok(Closing { rhs, .. }) | Err(rhs)) = found;
                self.rhs += rhs;
                let Closing { viscous, error, .. } = match found {
                    Ok(found) => found,
                    Err(_) => {
                        // On the belt line itself the orbit is followed from just below: C is continuous.
                        let radius = radius.min(belt_speed * (1.0 - f64::EPSILON));
                        closing_damping_of_node(curve, belt_speed, radius, tolerance, work)?
                    }
                };
                self.error = self.error.max(error);
                Ok(viscous)
            })
            .collect()
    }
}

/// cos(pi i / size), exact at the ends and in the middle.
fn node(i: usize, size: usize) -> f64 {
    (PI * (size as f64 - 2.0 * i as f64) / (2.0 * size as f64)).sin()
}

/// Chebyshev coefficients of the polynomial through `values` at the nodes cos(pi i / size), i = 0 ..= size.
fn coefficients(values: &[f64]) -> Vec<f64> {
    let size = values.len() - 1;
    let half_at_ends = |i: usize| if i == 0 || i == size { 0.5 } else { 1.0 };
    let cosines: Vec<f64> = (0..2 * size).map(|i| node(i, size)).collect();
    (0..=size)
        .map(|k| {
            let terms = values.iter().enumerate().map(|(i, value)| {
                // cos(pi i k / size), reduced to one period.
                half_at_ends(i) * value * cosines[(i * k) % (2 * size)]
            });
            half_at_ends(k) * 2.0 / size as f64 * terms.sum::<f64>()
        })
        .collect()
}

/// The sum of the series at x, by Clenshaw's recurrence.
fn sum(series: &[f64], x: f64) -> f64 {
    let (mut b1, mut b2) = (0.0, 0.0);
    for &c in series[1..].iter().rev() {
        (b1, b2) = (c + 2.0 * x * b1 - b2, b1);
    }
    series[0] + x * b1 - b2
}

impl Backbone {
    /// Computes the backbone of a column, with an error of about `tolerance` in units of the weakening rate
    /// where that can be reached.
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn of(column: &Column, tolerance: f64) -> Result<Self, Failure> {
        Self::of_curve(&column.curve, column.belt_speed, tolerance)
    }

    /// As [`Backbone::of`].
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn of_curve(curve: &Curve, belt_speed: f64, tolerance: f64) -> Result<Self, Failure> {
        Self::within(curve, belt_speed, tolerance, &Work::of_backbone(curve))
    }

    /// As [`Backbone::of`], within a budget of work.
    pub(super) fn within(
        curve: &Curve,
        belt_speed: f64,
        tolerance: f64,
        work: &Work,
    ) -> Result<Self, Failure> {
        let mut backbone = Self::begun_within(curve, belt_speed, tolerance, work)?;
        while let Some(finer) = backbone.refined_within(work)? {
            backbone = finer;
        }
        Ok(backbone)
    }

    /// The backbone through the fewest nodes: [`Backbone::refined`] leads to that of [`Backbone::of_curve`].
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn begun(curve: &Curve, belt_speed: f64, tolerance: f64) -> Result<Self, Failure> {
        Self::begun_within(curve, belt_speed, tolerance, &Work::of_backbone(curve))
    }

    fn begun_within(curve: &Curve, belt_speed: f64, tolerance: f64, work: &Work) -> Result<Self, Failure> {
        let mut solver = Solver { curve, belt_speed, tolerance, work, error: 0.0, rhs: 0 };
        let ends = [solver.at(&[belt_speed])?[0], curve.weakening(belt_speed)];
        Self::through(&ends, SIZES[0], solver)
    }

    /// The same through twice as many nodes; `None` where they would gain nothing.
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn refined(&self) -> Result<Option<Self>, Failure> {
        self.refined_within(&Work::of_backbone(&self.curve))
    }

    fn refined_within(&self, work: &Work) -> Result<Option<Self>, Failure> {
        if self.is_resolved {
            return Ok(None);
        }
        let Self { ref curve, belt_speed, tolerance, node_error: error, rhs, .. } = *self;
        let solver = Solver { curve, belt_speed, tolerance, work, error, rhs };
        Self::through(&self.values, 2 * (self.values.len() - 1), solver).map(Some)
    }

    /// Through `intervals` + 1 nodes, of which every so many have known values.
    fn through(known: &[f64], intervals: usize, mut solver: Solver) -> Result<Self, Failure> {
        let stride = intervals / (known.len() - 1);
        let radius = |i: usize| 0.5 * solver.belt_speed * (1.0 + node(i, intervals));
        let unknown: Vec<usize> = (0..=intervals).filter(|i| i % stride != 0).collect();
        let radii: Vec<f64> = unknown.iter().map(|&i| radius(i)).collect();
        let found = solver.at(&radii)?;
        let mut values = vec![0.0; intervals + 1];
        for (i, value) in known.iter().enumerate() {
            values[i * stride] = *value;
        }
        for (i, value) in unknown.into_iter().zip(found) {
            values[i] = value;
        }
        let Solver { curve, belt_speed, tolerance, error: node_error, rhs, .. } = solver;
        let size = values.iter().map(|value| value.abs()).fold(0.0, f64::max);
        let series = coefficients(&values);
        let last = &series[intervals + 1 - (intervals / 4).max(3)..];
        let tail = 2.0 * last.iter().map(|c| c.abs()).sum::<f64>();
        let lebesgue = 1.0 + 2.0 / PI * (intervals as f64).ln();
        let nodes = lebesgue * node_error + 4.0 * f64::EPSILON * size;
        let finest = if curve.corners().is_empty() { SIZES[1] } else { FINEST_WITH_CORNERS };
        let ends = [values[intervals], values[0]];
        let mut backbone = Self {
            curve: curve.clone(),
            belt_speed,
            tolerance,
            values,
            node_error,
            is_resolved: tail <= (tolerance * size).max(nodes) || intervals >= finest,
            series,
            turning_points: Vec::new(),
            doubtful: Vec::new(),
            error: tail + nodes,
            rhs,
        };
        (backbone.turning_points, backbone.doubtful) = backbone.find_turning_points(ends);
        Ok(backbone)
    }

    /// C at an amplitude 0 <= `radius` <= V.
    #[must_use]
    pub fn viscous(&self, radius: f64) -> f64 {
        sum(&self.series, 2.0 * radius / self.belt_speed - 1.0)
    }

    /// The ends r = 0 and r = V, and the folds between them, by increasing r. Between neighbours C is
    /// monotone; extremes within its error are left out.
    #[must_use]
    pub fn turning_points(&self) -> &[TurningPoint] {
        &self.turning_points
    }

    /// The folds: where two slip cycles meet.
    #[must_use]
    pub fn folds(&self) -> &[TurningPoint] {
        &self.turning_points[1..self.turning_points.len() - 1]
    }

    /// The turning points, and C at those that were left out.
    fn find_turning_points(&self, [at_rest, at_belt]: [f64; 2]) -> (Vec<TurningPoint>, Vec<f64>) {
        // Twice as many intervals as the highest polynomial has extremes.
        let places = 4 * (self.series.len() - 1);
        let radius = |i: usize| 0.5 * self.belt_speed * (1.0 - node(i, places));
        let mut found = vec![TurningPoint { radius: 0.0, viscous: at_rest }];
        let values: Vec<f64> = (0..=places).map(|i| self.viscous(radius(i))).collect();
        for i in 1..places {
            let [left, here, right] = [values[i - 1], values[i], values[i + 1]];
            let (up, down) = (here > left && here >= right, here < left && here <= right);
            if up || down {
                let sign = if up { 1.0 } else { -1.0 };
                let best = golden(|r| sign * self.viscous(r), [radius(i - 1), radius(i + 1)]);
                found.push(TurningPoint { radius: best, viscous: self.viscous(best) });
            }
        }
        found.push(TurningPoint { radius: self.belt_speed, viscous: at_belt });
        let mut doubtful = Vec::new();
        // Remove the smallest step between neighbours: both its ends, or the one that is not an end of the
        // curve.
        while let Some(i) = (1..found.len())
            .filter(|&i| {
                found.len() > 2 && (found[i].viscous - found[i - 1].viscous).abs() <= 2.0 * self.error
            })
            .min_by(|&i, &j| {
                let step = |i: usize| (found[i].viscous - found[i - 1].viscous).abs();
                step(i).total_cmp(&step(j))
            })
        {
            let removed = match i {
                1 => 1..2,
                i if i + 1 == found.len() => i - 1..i,
                i => i - 1..i + 1,
            };
            doubtful.extend(found.drain(removed).map(|point| point.viscous));
        }
        (found, doubtful)
    }

    /// Returns whether the error of C is small, and C = `viscous` farther than three times that from both
    /// ends and from every extreme, also from those that are too small to be counted: if not, a more accurate
    /// backbone may show other cycles.
    #[must_use]
    pub fn is_clear(&self, viscous: f64) -> bool {
        let size = self.values.iter().map(|value| value.abs()).fold(0.0, f64::max);
        if self.error > CLEAR * size {
            return false;
        }
        let turns = self.turning_points.iter().map(|point| point.viscous);
        turns.chain(self.doubtful.iter().copied()).all(|extreme| (extreme - viscous).abs() > 3.0 * self.error)
    }

    /// The slip cycles at C = `viscous`, by increasing amplitude. The stability of the equilibrium and
    /// whether the orbit from the exit point returns to the belt line fix the parity of their number. `None`
    /// where C is within the error of a fold's.
    #[must_use]
    pub fn cycles(&self, viscous: f64, equilibrium_is_stable: bool, returns: bool) -> Option<Vec<Crossing>> {
        if self.folds().iter().any(|fold| (fold.viscous - viscous).abs() <= self.error) {
            return None;
        }
        let last = self.turning_points.len() - 1;
        // Returns whether orbits of this amplitude shrink.
        let inward = |i: usize| match i {
            0 => equilibrium_is_stable,
            i if i == last => !returns,
            i => viscous > self.turning_points[i].viscous,
        };
        let cycles = (1..=last).filter(|&i| inward(i - 1) != inward(i)).map(|i| Crossing {
            between: [self.turning_points[i - 1].radius, self.turning_points[i].radius],
            is_stable: inward(i),
        });
        Some(cycles.collect())
    }

    /// Narrower bounds of a cycle's amplitude at C = `viscous`, as far as the error of C allows.
    pub(crate) fn narrowed(&self, cycle: &Crossing, viscous: f64) -> [f64; 2] {
        let [from, to] = cycle.between;
        let rises = !cycle.is_stable;
        // Radii on either side of the crossing, at a distance of the error.
        let bound = |shift: f64| {
            let (mut low, mut high) = (from, to);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                let passed = if rises {
                    self.viscous(middle) + shift > viscous
                } else {
                    self.viscous(middle) - shift < viscous
                };
                *(if passed { &mut high } else { &mut low }) = middle;
            }
            [low, high]
        };
        let pad = 2.0 * self.error;
        let [low, high] = [bound(pad)[0], bound(-pad)[1]];
        // An allowance for rounding errors of the interpolant's own root.
        let allowance = 1e-9 * (to - from);
        [(low - allowance).max(from), (high + allowance).min(to)]
    }
}

/// The maximum of `f`, which rises and then falls between two places, by golden section.
fn golden(f: impl Fn(f64) -> f64, [mut low, mut high]: [f64; 2]) -> f64 {
    let share = 0.5 * (3.0 - 5.0_f64.sqrt());
    let (mut a, mut b) = (low + share * (high - low), high - share * (high - low));
    let (mut at_a, mut at_b) = (f(a), f(b));
    for _ in 0..60 {
        if at_a >= at_b {
            (high, b, at_b) = (b, a, at_a);
            a = low + share * (high - low);
            at_a = f(a);
        } else {
            (low, a, at_a) = (a, b, at_b);
            b = high - share * (high - low);
            at_b = f(b);
        }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn polynomials_are_their_own_series() {
        let f = |x: f64| 1.0 - 2.0 * x + 0.5 * x * x * x;
        for size in [4, 8, 16] {
            let values: Vec<f64> = (0..=size).map(|i| f(node(i, size))).collect();
            let series = coefficients(&values);
            for x in [-1.0, -0.3, 0.2, 1.0] {
                assert!((sum(&series, x) - f(x)).abs() < 1e-14, "{size} {x}");
            }
            assert!(series[4..].iter().all(|c| c.abs() < 1e-15), "{series:?}");
        }
    }
}

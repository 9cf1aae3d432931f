//! The panels of a backbone, each a polynomial C(r) on a range of amplitudes, and the solver for C at an
//! amplitude.

use super::{FINEST_OF_MANY, SIZES};
use slipmap_model::flow::Failure;
use slipmap_model::friction::Curve;
use slipmap_numbers::chebyshev::{Between, coefficients, lebesgue, node, sum, sums};
use slipmap_orbits::Closing;
use slipmap_orbits::closing::{Amplitude, closing_dampings};
use slipmap_orbits::work::Work;

/// Number of samples for each interval between nodes among which extremes are searched: twice as many as the
/// highest polynomial has extremes.
pub(super) const SAMPLES_PER_INTERVAL: usize = 4;

/// A range of amplitudes on which C is one polynomial.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Panel {
    pub(super) from: f64,
    pub(super) to: f64,
    /// Whether C is a polynomial in the square root of the distance from the lower end, not in the distance.
    pub(super) in_root: bool,
    /// C at the nodes, from the upper end down.
    pub(super) values: Vec<f64>,
    /// The orbits of these amplitudes, as far as they were computed.
    pub(super) orbits: Vec<Option<Closing>>,
    /// Coefficients of C along the Chebyshev polynomials.
    pub(super) series: Vec<f64>,
}

impl Panel {
    /// A range of amplitudes between two of which the orbits are known, with no polynomial as yet.
    pub(super) fn between_ends(
        [(from, lower), (to, upper)]: [(f64, Closing); 2],
        in_root: bool,
        intervals: usize,
    ) -> Self {
        let mut orbits = vec![None; intervals + 1];
        (orbits[0], orbits[intervals]) = (Some(upper), Some(lower));
        Self { from, to, in_root, values: Vec::new(), orbits, series: Vec::new() }
    }

    /// The range with a polynomial of as many nodes as C needs there, if one of [`FINEST_OF_MANY`] intervals follows it.
    pub(super) fn resolved(self, size: f64, solver: &mut Solver) -> Result<Self, Failure> {
        let mut panel = Self::through([self.from, self.to], self.in_root, self.orbits, solver)?;
        while !panel.follows(size, solver) && panel.values.len() <= FINEST_OF_MANY {
            panel = panel.refined(solver)?;
        }
        Ok(panel)
    }

    /// Whether the polynomial follows C as accurately as the solver computes it, in units of `size`.
    pub(super) fn follows(&self, size: f64, solver: &Solver) -> bool {
        let node_error = node_error_of(&self.values, solver.error + solver.slope_error);
        truncation_error(&self.series) <= (solver.tolerance * size).max(node_error)
    }

    /// The panel through the orbits at the nodes. Missing orbits are computed: every second one where the
    /// values at the others follow from slopes.
    pub(super) fn through(
        [from, to]: [f64; 2],
        in_root: bool,
        orbits: Vec<Option<Closing>>,
        solver: &mut Solver,
    ) -> Result<Self, Failure> {
        let mut panel = Self { from, to, in_root, values: Vec::new(), orbits, series: Vec::new() };
        // Next to a corner the slope does not predict C.
        let follow = if solver.knows_slopes() && (in_root || solver.curve.corners().is_empty()) {
            panel.complete(2, solver)?;
            panel.between(solver)
        } else {
            None
        };
        if follow.is_none() {
            panel.complete(1, solver)?;
        }
        let mut follow = follow.into_iter().flatten();
        let known = panel.orbits.iter().enumerate();
        panel.values = known
            .filter_map(|(i, orbit)| {
                let between = if i % 2 == 1 { follow.next() } else { None };
                orbit.map(|orbit| orbit.viscous).or(between)
            })
            .collect();
        panel.series = coefficients(&panel.values);
        Ok(panel)
    }

    /// Computes the missing orbits at every `step`-th node.
    pub(super) fn complete(&mut self, step: usize, solver: &mut Solver) -> Result<(), Failure> {
        let last = self.orbits.len() - 1;
        let missing: Vec<usize> = (0..=last).step_by(step).filter(|&i| self.orbits[i].is_none()).collect();
        let radii: Vec<f64> = missing.iter().map(|&i| self.radius(node(i, last))).collect();
        for (i, orbit) in missing.into_iter().zip(solver.at(&radii)?) {
            self.orbits[i] = Some(orbit);
        }
        Ok(())
    }

    /// C at every second node by the values and slopes at the others; `None` where these are too inaccurate.
    pub(super) fn between(&self, solver: &mut Solver) -> Option<Vec<f64>> {
        let last = self.orbits.len() - 1;
        let known: Vec<Closing> = self.orbits.iter().step_by(2).copied().collect::<Option<_>>()?;
        let values: Vec<f64> = known.iter().map(|orbit| orbit.viscous).collect();
        let slope = |(i, orbit): (usize, &Closing)| {
            // dr / dx over r.
            let x = node(2 * i, last);
            let rate =
                (self.to - self.from) * if self.in_root { 0.5 * (1.0 + x) } else { 0.5 } / self.radius(x);
            orbit.slope.map(|[slope, error]| (rate * slope, rate * error))
        };
        let with_slopes = known[..last / 2].iter().enumerate();
        let (slopes, errors): (Vec<f64>, Vec<f64>) =
            with_slopes.map(slope).collect::<Option<Vec<_>>>()?.into_iter().unzip();
        let between = Between::of(last / 2);
        let error = between.error(&errors);
        if !(error <= solver.tolerance * largest(&values)) {
            return None;
        }
        solver.slope_error = solver.slope_error.max(error);
        Some((0..last / 2).map(|i| between.value(i, &values, &slopes)).collect())
    }

    /// The panel through twice as many nodes.
    pub(super) fn refined(&self, solver: &mut Solver) -> Result<Self, Failure> {
        let mut orbits: Vec<Option<Closing>> = self.orbits.iter().flat_map(|orbit| [*orbit, None]).collect();
        orbits.pop();
        Self::through([self.from, self.to], self.in_root, orbits, solver)
    }

    /// The halves of its range, each with half as many intervals; `None` if the orbits at their ends are not known.
    pub(super) fn halves(&self) -> Option<[Self; 2]> {
        let last = self.orbits.len() - 1;
        let end = |i: usize| Some((self.radius(node(i, last)), self.orbits[i]?));
        let [lower, middle, upper] = [end(last)?, end(last / 2)?, end(0)?];
        let half = |ends| Self::between_ends(ends, self.in_root, (last / 2).max(SIZES[0]));
        Some([half([lower, middle]), half([middle, upper])])
    }

    /// The amplitude at -1 <= `x` <= 1.
    pub(super) fn radius(&self, x: f64) -> f64 {
        let share = 0.5 * (1.0 + x);
        self.from + (self.to - self.from) * if self.in_root { share * share } else { share }
    }

    /// The place x of an amplitude, -1 <= x <= 1.
    pub(super) fn place(&self, radius: f64) -> f64 {
        let share = (radius - self.from) / (self.to - self.from);
        2.0 * if self.in_root { share.max(0.0).sqrt() } else { share } - 1.0
    }

    pub(super) fn viscous(&self, radius: f64) -> f64 {
        sum(&self.series, self.place(radius))
    }

    /// The amplitudes at which extremes are searched, increasing, without the lower end, and C there.
    pub(super) fn samples(&self) -> (Vec<f64>, Vec<f64>) {
        let samples = SAMPLES_PER_INTERVAL * (self.series.len() - 1);
        let radii: Vec<f64> = (1..=samples).map(|i| self.radius(-node(i, samples))).collect();
        let places: Vec<f64> = radii.iter().map(|radius| self.place(*radius)).collect();
        let values = sums(&self.series, &places);
        (radii, values)
    }
}

/// Computes C at amplitudes.
pub(super) struct Solver<'a> {
    pub(super) curve: &'a Curve,
    pub(super) belt_speed: f64,
    pub(super) tolerance: f64,
    pub(super) work: &'a Work,
    /// The amplitudes computed so far with their C, by increasing amplitude.
    pub(super) known: Vec<(f64, f64)>,
    /// Largest error so far of computed values, and of values by slopes.
    pub(super) error: f64,
    pub(super) slope_error: f64,
    pub(super) rhs: u64,
}

impl<'a> Solver<'a> {
    pub(super) fn new(curve: &'a Curve, belt_speed: f64, tolerance: f64, work: &'a Work) -> Self {
        let known = vec![(0.0, curve.weakening(belt_speed))];
        Self { curve, belt_speed, tolerance, work, known, error: 0.0, slope_error: 0.0, rhs: 0 }
    }

    /// Estimates C at an amplitude by the line through two known ones.
    fn guess(&self, radius: f64) -> Option<f64> {
        let after = self.known.partition_point(|known| known.0 < radius);
        let first = after.saturating_sub(1).min(self.known.len().checked_sub(2)?);
        let [(from, low), (to, high)] = [self.known[first], self.known[first + 1]];
        Some(low + (radius - from) / (to - from) * (high - low))
    }

    /// Whether orbits are computed with their slopes.
    pub(super) fn knows_slopes(&self) -> bool {
        self.curve.stribeck().is_none()
    }

    /// The equilibrium, as the orbit of amplitude 0.
    pub(super) fn at_rest(&self) -> Closing {
        Closing { viscous: self.curve.weakening(self.belt_speed), error: 0.0, rhs: 0, slope: None }
    }

    pub(super) fn at(&mut self, radii: &[f64]) -> Result<Vec<Closing>, Failure> {
        let (curve, belt_speed, tolerance, work) = (self.curve, self.belt_speed, self.tolerance, self.work);
        let orbits: Vec<Amplitude> = (radii.iter())
            .map(|&radius| Amplitude {
                guess: self.guess(radius),
                ..Amplitude::new(curve, belt_speed, radius, work)
            })
            .collect();
        let found = closing_dampings(&orbits, tolerance).into_iter().zip(radii);
        found
            .map(|(found, radius)| {
                let (Ok(Closing { rhs, .. }) | Err(rhs)) = found;
                self.rhs += rhs;
                // Friction changes the speed by 1 at most.
                let leaves_data = || curve.fastest() < belt_speed + radius.hypot(1.0);
                let closed = found.map_err(|_| match work.why_not_closed() {
                    Failure::StepUnderflow if leaves_data() => Failure::NotFinite,
                    why => why,
                })?;
                self.error = self.error.max(closed.error);
                let place = self.known.partition_point(|known| known.0 < *radius);
                if self.known.get(place).is_none_or(|known| known.0 > *radius) {
                    self.known.insert(place, (*radius, closed.viscous));
                }
                Ok(closed)
            })
            .collect()
    }
}

pub(super) fn largest(values: &[f64]) -> f64 {
    values.iter().map(|value| value.abs()).fold(0.0, f64::max)
}

/// The error of the interpolant due to that of the values.
pub(super) fn node_error_of(values: &[f64], node_error: f64) -> f64 {
    lebesgue(values.len() - 1) * node_error + 4.0 * f64::EPSILON * largest(values)
}

/// Estimate of the sum of the terms beyond the end of the series.
pub(super) fn truncation_error(series: &[f64]) -> f64 {
    let last = &series[series.len() - ((series.len() - 1) / 4).max(3)..];
    2.0 * last.iter().map(|c| c.abs()).sum::<f64>()
}

//! The backbone C(r) of a column: for each amplitude r in (0, V] the one damping at which the orbit with
//! maximum x2 = r closes.
//!
//! The right side of the scalar form increases with D at every angle, so the return map P(r; C) falls
//! strictly with C, and P(r; C) = r has one root C(r) (theory, "The backbone"). Every slip cycle of every
//! damping of the column lies on this curve: at C = eps c they are the solutions of C(r) = C; a cycle
//! attracts where C falls with r and repels where it rises. C(0+) is the weakening rate at belt speed (Hopf),
//! C(V) is eps c* (grazing), and the extremes between are folds.
//!
//! C is interpolated in r at Chebyshev nodes, whose number is doubled until the coefficients have decayed.
//! One polynomial covers all amplitudes or, where the law has corners, each range between two amplitudes at
//! which orbits begin to reach one (`backbone/corners.rs`). Ranges that no polynomial follows are halved.
//!
//! **Error.** Twice the sum of the sizes of the last quarter of the coefficients, plus the largest error of
//! the nodes times the Lebesgue constant. It is an estimate; `slip_count` proves counts.

mod by_slopes;
mod corners;
mod extremes;
mod hidden;
mod interpolated;
mod panel;

use by_slopes::Monotone;
use corners::corner_amplitudes;
use hidden::Hidden;
pub use interpolated::{BackboneNodes, InterpolatedBackbone};
use panel::{Panel, Solver, largest, node_error_of, truncation_error};
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Failure;
use slipmap_model::friction::{Column, Curve};
use slipmap_numbers::chebyshev::coefficients;
use slipmap_orbits::{Effort, Piece, Work};

/// Tolerance, in units of the weakening rate, of the coarse backbones that are tried first where only the number of
/// cycles is needed: few dampings of a column lie that close to an extreme of the backbone.
pub const COARSE: f64 = 1e-5;

/// Least and largest number of intervals between nodes.
const SIZES: [usize; 2] = [8, 128];
/// Largest number of intervals of one polynomial across corners: C is then smooth to finite order only, and
/// more nodes gain little.
const FINEST_WITH_CORNERS: usize = 64;
/// Number of intervals of one polynomial across corners above which C is cut at the corners if possible.
const FINEST_BEFORE_CUT: usize = 32;
/// Largest number of intervals of one of several panels.
const FINEST_OF_MANY: usize = 32;
/// Largest number of halvings of the panels: some twenty on both sides of one place.
const MOST_HALVES: usize = 50;
/// Amplitude, in units of V, at which the backbone is tested for flatness next to the equilibrium.
const CLOSE: f64 = 0.01;

/// Least tolerance where there are corners: orbits that only touch one take many steps.
const LEAST_TOLERANCE_WITH_CORNERS: f64 = 1e-8;

/// Tolerance of the second attempt where a backbone exceeds its quota. A steep law with corners has orbits
/// outside the polar form, each of which takes as long as a hundred others, and whose errors stay above the
/// least tolerance; panels are refined in vain then.
const SECOND_TOLERANCE: f64 = 1e-6;

/// Largest error, relative to the largest |C|, of a backbone from which the number of cycles is read.
/// Interpolants through nine nodes gave wrong counts in eleven of 120,000 cases of rough random laws, each
/// with an error above 8e-3 of that size.
const LARGEST_ERROR: f64 = 2e-3;

/// Least error, relative to the largest |C|, of a coarse backbone that is far above [`COARSE`].
const ROUGH: f64 = 1e-3;

/// Least distance of a damping from an end and from an extreme, in units of the error, at which cycles are
/// counted.
const FAR: f64 = 3.0;
/// Least distance from an extreme of one polynomial across corners, in units of the error, which is less
/// certain.
const FAR_ACROSS_CORNERS: f64 = 5.0;

/// Least change of C between neighbouring nodes, in units of its error, for which that error cannot cause an
/// extreme between them.
const STEEP: f64 = 20.0;

/// An extreme of C(r), or one of its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TurningPoint {
    /// The amplitude r: largest x2 on the orbit.
    pub radius: f64,
    /// C = eps c there.
    pub viscous: f64,
}

/// A slip cycle at one damping, as read from the backbone.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CycleRange {
    /// Bounds of its amplitude, between which there is no other cycle.
    pub between: [f64; 2],
    /// Bounds by the error of the backbone, between which it is sought first.
    pub near: [f64; 2],
    /// Whether it attracts.
    pub is_stable: bool,
}

impl CycleRange {
    /// A cycle of which no more than these bounds is known.
    #[must_use]
    pub fn between(between: [f64; 2], is_stable: bool) -> Self {
        Self { between, near: between, is_stable }
    }
}

/// The backbone of a column, for 0 <= r <= V.
#[derive(Clone, Debug, PartialEq)]
pub struct Backbone {
    belt_speed: f64,
    /// The panels, by increasing r.
    panels: Vec<Panel>,
    /// Largest error of the values at the nodes.
    node_error: f64,
    /// Largest |C| at the nodes.
    size: f64,
    /// Whether one polynomial serves both sides of a corner.
    crosses_corners: bool,
    /// Bound of the error of C due to features of the law between the nodes, see [`Hidden`].
    hidden: f64,
    turning_points: Vec<TurningPoint>,
    /// Ranges of r on which slopes at the nodes show that C is monotone.
    monotone: Vec<Monotone>,
    /// See [`Self::uncertain`].
    uncertain: Vec<[f64; 2]>,
    /// Whether no extreme of C is missing, or due to its error.
    has_all_extremes: bool,
    /// Estimate of the absolute error of C at any r.
    pub error: f64,
    /// Number of evaluations of the right-hand side, where the polar form was used.
    pub rhs: u64,
}

impl Backbone {
    /// Computes the backbone of a column, with an error of about `tolerance` in units of the weakening rate
    /// where that can be reached; its `error` says where it cannot.
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn of(column: &Column, tolerance: f64) -> Result<Self, Failure> {
        Self::of_curve(&column.curve, column.belt_speed, tolerance)
    }

    /// Computes the backbone of a curve at a belt speed, as [`Backbone::of`].
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn of_curve(curve: &Curve, belt_speed: f64, tolerance: f64) -> Result<Self, Failure> {
        Self::with(Effort::Whole, curve, belt_speed, tolerance)
    }

    /// [`Backbone::of_curve`] with an effort: a less accurate one where that exceeds its quota.
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn with(effort: Effort, curve: &Curve, belt_speed: f64, tolerance: f64) -> Result<Self, Failure> {
        let of = |piece: Piece, tolerance: f64| {
            Self::within(curve, belt_speed, tolerance, &Work::with(effort, piece, curve))
        };
        match of(Piece::FineBackbone, tolerance) {
            Err(why) if why != Failure::NotFinite && tolerance < SECOND_TOLERANCE => {
                of(Piece::RoughBackbone, SECOND_TOLERANCE)
            }
            found => found,
        }
    }

    /// The first of the coarse backbones, each with more nodes, that is enough, or that of `tolerance` where none is;
    /// `is_enough` is told whether there is no further coarse one.
    pub fn enough(
        oscillator: &Oscillator,
        tolerance: f64,
        work: &Work,
        is_enough: impl Fn(&Self, bool) -> bool,
    ) -> Result<Self, Failure> {
        let Oscillator { curve, belt_speed, .. } = oscillator;
        let mut coarse = Self::coarsest(curve, *belt_speed, COARSE, work)?;
        while !is_enough(&coarse, false) {
            match coarse.refined(curve, COARSE, work)? {
                Some(finer) => coarse = finer,
                None if is_enough(&coarse, true) => break,
                None => return Self::within(curve, *belt_speed, tolerance, work),
            }
        }
        Ok(coarse)
    }

    /// Whether a finer tolerance would hardly improve it, the last of the coarse backbones: that of a law with corners,
    /// with an error far above the tolerance, such as of scattered data. A fine one takes twice as long and has about the
    /// same error.
    #[must_use]
    pub fn is_rough(&self, curve: &Curve) -> bool {
        let size = self.turning_points.iter().map(|turn| turn.viscous.abs()).fold(0.0, f64::max);
        !curve.corners().is_empty() && self.error > ROUGH * size
    }

    fn within(curve: &Curve, belt_speed: f64, tolerance: f64, work: &Work) -> Result<Self, Failure> {
        if !curve.corners().is_empty()
            && let Some(backbone) = Self::cut(curve, belt_speed, tolerance, work)?
        {
            return Ok(backbone);
        }
        let mut backbone = Self::with_intervals(curve, belt_speed, tolerance, SIZES[0], work)?;
        while let Some(finer) = backbone.refined(curve, tolerance, work)? {
            backbone = finer;
        }
        Ok(backbone)
    }

    /// The backbone divided at the amplitudes at which orbits begin to reach a corner; `None` where there are no such
    /// amplitudes or too many.
    fn cut(curve: &Curve, belt_speed: f64, tolerance: f64, work: &Work) -> Result<Option<Self>, Failure> {
        let reachable = tolerance.max(LEAST_TOLERANCE_WITH_CORNERS);
        let mut solver = Solver::new(curve, belt_speed, reachable, work);
        let Some(ends) = corner_amplitudes(&mut solver)? else { return Ok(None) };
        let (mut panels, mut lower) = (Vec::with_capacity(ends.len()), (0.0, solver.at_rest()));
        let scale = ends.iter().map(|end| end.1.viscous.abs()).fold(lower.1.viscous.abs(), f64::max);
        for upper in ends {
            let range = Panel::between_ends([lower, upper], true, SIZES[0]);
            panels.push(range.resolved(scale, &mut solver)?);
            lower = upper;
        }
        Ok(Some(Self::of_panels(panels, solver)))
    }

    /// The backbone with the panels halved whose polynomials do not follow C, until they do; `None` where all do.
    fn halved(&self, curve: &Curve, tolerance: f64, work: &Work) -> Result<Option<Self>, Failure> {
        let Self { belt_speed, node_error: error, rhs, size, .. } = *self;
        let mut solver = Solver { error, rhs, ..Solver::new(curve, belt_speed, tolerance, work) };
        let mut panels = Vec::with_capacity(self.panels.len());
        // The next one is the last.
        let mut left: Vec<Panel> = self.panels.iter().rev().cloned().collect();
        let most = left.len() + MOST_HALVES;
        while let Some(panel) = left.pop() {
            if panel.follows(size, &solver) {
                panels.push(panel);
                continue;
            }
            if panels.len() + left.len() > most {
                return Err(Failure::StepBudget);
            }
            let Some(halves) = panel.halves() else { return Ok(None) };
            for half in halves.into_iter().rev() {
                left.push(half.resolved(size, &mut solver)?);
            }
        }
        Ok((panels.len() > self.panels.len()).then(|| Self::of_panels(panels, solver)))
    }

    /// The backbone through the fewest nodes; [`Backbone::refined`] leads from it to that of
    /// [`Backbone::of_curve`].
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn coarsest(curve: &Curve, belt_speed: f64, tolerance: f64, work: &Work) -> Result<Self, Failure> {
        Self::with_intervals(curve, belt_speed, tolerance, SIZES[0], work)
    }

    /// The backbone through a number of nodes, one more than `intervals`, a power of two.
    fn with_intervals(
        curve: &Curve,
        belt_speed: f64,
        tolerance: f64,
        intervals: usize,
        work: &Work,
    ) -> Result<Self, Failure> {
        let mut solver = Solver::new(curve, belt_speed, tolerance, work);
        let mut orbits = vec![None; intervals];
        orbits.push(Some(solver.at_rest()));
        let panel = Panel::through([0.0, belt_speed], false, orbits, &mut solver)?;
        Ok(Self::of_panels(vec![panel], solver))
    }

    /// The backbone of the same curve through twice as many nodes, or cut at the amplitudes at which orbits
    /// begin to reach a corner where that takes fewer nodes, or halved where no polynomial follows it; `None` where nothing
    /// would improve it.
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn refined(&self, curve: &Curve, tolerance: f64, work: &Work) -> Result<Option<Self>, Failure> {
        let has_corners = !curve.corners().is_empty();
        let finest = if has_corners { FINEST_WITH_CORNERS } else { SIZES[1] };
        // Several panels are not refined further.
        let [panel] = &self.panels[..] else { return Ok(None) };
        let intervals = panel.values.len() - 1;
        let enough = (tolerance * largest(&panel.values)).max(node_error_of(&panel.values, self.node_error));
        let Self { belt_speed, node_error: error, rhs, .. } = *self;
        let cut = || Self::cut(curve, belt_speed, tolerance, work);
        if truncation_error(&panel.series).max(self.hidden) <= enough {
            return Ok(None);
        }
        if intervals >= finest {
            // Features that are still hidden, or that no polynomial follows, are narrow. Cutting fails if they have too
            // many ends or orbits that touch them are too hard to compute.
            let cut = cut().ok().flatten().filter(|cut| cut.error < self.error);
            let best = cut.as_ref().unwrap_or(self);
            if has_corners || best.hidden > enough {
                return Ok(cut);
            }
            let halved = work.optional(|| best.halved(curve, tolerance, work)).flatten();
            return Ok(halved.filter(|halved| halved.error < best.error).or(cut));
        }
        if intervals >= FINEST_BEFORE_CUT
            && self.crosses_corners
            && let Some(cut) = cut()?
        {
            return Ok(Some(cut));
        }
        let mut solver = Solver { error, rhs, ..Solver::new(curve, belt_speed, tolerance, work) };
        let finer = panel.refined(&mut solver)?;
        Ok(Some(Self::of_panels(vec![finer], solver)))
    }

    /// The backbone of a law without corners through known values of C at the nodes, from r = V down to 0,
    /// with errors of at most `node_error`.
    fn of_values(belt_speed: f64, values: Vec<f64>, node_error: f64) -> Self {
        let series = coefficients(&values);
        let panel = Panel { from: 0.0, to: belt_speed, in_root: false, values, orbits: Vec::new(), series };
        Self::new(vec![panel], node_error, false, 0.0, None)
    }

    fn of_panels(
        panels: Vec<Panel>,
        Solver { curve, belt_speed, error, slope_error, rhs, .. }: Solver,
    ) -> Self {
        let crosses_corners = !(panels[0].in_root || curve.corners().is_empty());
        let distances = curve.corners().iter().map(|corner| (corner - belt_speed).abs());
        let nearest_corner = distances.fold(f64::INFINITY, f64::min);
        let hidden = match &panels[..] {
            [Panel { in_root: false, values, .. }] => Hidden::of(curve, belt_speed, values.len() - 1),
            _ => None,
        };
        Self { rhs, ..Self::new(panels, error + slope_error, crosses_corners, nearest_corner, hidden) }
    }

    fn new(
        panels: Vec<Panel>,
        node_error: f64,
        crosses_corners: bool,
        nearest_corner: f64,
        hidden: Option<Hidden>,
    ) -> Self {
        let error_of =
            |panel: &Panel| truncation_error(&panel.series) + node_error_of(&panel.values, node_error);
        let error = panels.iter().map(error_of).fold(0.0, f64::max);
        let belt_speed = panels[panels.len() - 1].to;
        let monotone = Self::monotone_ranges(&panels, error, nearest_corner);
        let size = panels.iter().map(|panel| largest(&panel.values)).fold(0.0, f64::max);
        let mut backbone = Self {
            belt_speed,
            panels,
            node_error,
            size,
            crosses_corners,
            hidden: 0.0,
            turning_points: Vec::new(),
            monotone,
            uncertain: Vec::new(),
            has_all_extremes: true,
            error,
            rhs: 0,
        };
        let (turning_points, mut unresolved) = backbone.find_turning_points();
        backbone.turning_points = turning_points;
        let mut flat = Vec::new();
        if crosses_corners {
            unresolved.extend(Self::extremes_by_slopes(&backbone.panels));
            flat = backbone.flat_between_nodes();
        } else if !backbone.panels[0].in_root {
            flat = backbone.flat_at_samples();
        }
        if let Some(Hidden { error, amplitudes }) = hidden {
            backbone.hidden = error;
            backbone.error = backbone.error.max(error);
            unresolved.extend(amplitudes.into_iter().map(|r| backbone.viscous(r)));
        }
        backbone.with_uncertain(&unresolved, flat)
    }

    /// C at an amplitude 0 <= `radius` <= V.
    #[must_use]
    pub fn viscous(&self, radius: f64) -> f64 {
        let panel = self.panels.partition_point(|panel| panel.to < radius);
        self.panels[panel.min(self.panels.len() - 1)].viscous(radius)
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

    /// Returns whether the number of cycles at C = `viscous` is reliable: the error of C is small, and
    /// [`Self::cycles`] tells them. If not reliable, a more accurate backbone may show other cycles.
    #[must_use]
    pub fn is_reliable_at(&self, viscous: f64) -> bool {
        self.error <= LARGEST_ERROR * self.size && self.is_apart(viscous)
    }

    /// Returns whether `viscous` lies outside of [`Self::uncertain`].
    fn is_apart(&self, viscous: f64) -> bool {
        !self.uncertain.iter().any(|[low, high]| (*low..=*high).contains(&viscous))
    }

    /// Ranges of C in which it does not tell the number of cycles: flat pieces, and what is closer than three times the error
    /// to an end or an extreme (to one across corners, five times). Extremes within the error count, too. Ends, extremes
    /// within the error and flat pieces are exempt where slopes show that C is monotone.
    #[must_use]
    pub fn uncertain(&self) -> &[[f64; 2]] {
        &self.uncertain
    }

    /// Returns whether it shows every extreme of C with certainty.
    pub fn has_all_extremes(&self) -> bool {
        self.has_all_extremes
    }

    /// With the ranges of C in which it does not tell the number of cycles: about its extremes, those at C = `unresolved` that
    /// it may lack, its ends, and `flat` pieces.
    fn with_uncertain(self, unresolved: &[f64], flat: Vec<[f64; 2]>) -> Self {
        let distance = FAR * self.error;
        let from_extremes = if self.crosses_corners { FAR_ACROSS_CORNERS * self.error } else { distance };
        let around = |viscous: f64, distance: f64| [viscous - distance, viscous + distance];
        let mut uncertain: Vec<_> =
            self.folds().iter().map(|fold| around(fold.viscous, from_extremes)).collect();
        uncertain.extend(unresolved.iter().map(|viscous| around(*viscous, from_extremes)));
        // Where C is steep next to r = V, its error, which vanishes at the nodes, causes no extreme.
        let highest = &self.panels[self.panels.len() - 1].values;
        let is_steep = (highest[0] - highest[1]).abs() > STEEP * self.error;
        let rises_or_falls = |range: Option<&Monotone>, end: f64| {
            range.is_some_and(|it| (it.from == end || it.to == end) && it.change() > 2.0 * distance)
        };
        let [first, .., last] = &self.turning_points[..] else {
            unreachable!("both ends are turning points")
        };
        if !rises_or_falls(self.monotone.first(), 0.0) {
            uncertain.push(around(first.viscous, distance));
        }
        if !(is_steep || rises_or_falls(self.monotone.last(), self.belt_speed)) {
            uncertain.push(around(last.viscous, distance));
        }
        let has_all_extremes = unresolved.is_empty() && flat.is_empty();
        uncertain.extend(flat);
        Self { uncertain, has_all_extremes, ..self }
    }

    /// The slip cycles at C = `viscous`, by increasing amplitude. The stability of the equilibrium and
    /// whether the orbit from the exit point returns to the belt line fix the parity of their number. `None`
    /// where `viscous` is closer to an end or an extreme than their error tells apart, or is the C of the Hopf bifurcation
    /// and the backbone is flat there, so that orbits about the equilibrium close.
    #[must_use]
    pub fn cycles(
        &self,
        viscous: f64,
        equilibrium_is_stable: bool,
        returns: bool,
    ) -> Option<Vec<CycleRange>> {
        let at_hopf = viscous == self.turning_points[0].viscous;
        let is_flat = || (self.viscous(CLOSE * self.belt_speed) - viscous).abs() <= self.error;
        if at_hopf && is_flat() || !self.is_apart(viscous) {
            return None;
        }
        let last = self.turning_points.len() - 1;
        // Returns whether orbits of this amplitude shrink.
        let inward = |i: usize| match i {
            0 => equilibrium_is_stable,
            i if i == last => !returns,
            i => viscous > self.turning_points[i].viscous,
        };
        let cycles = (1..=last).filter(|&i| inward(i - 1) != inward(i)).map(|i| {
            CycleRange::between([self.turning_points[i - 1].radius, self.turning_points[i].radius], inward(i))
        });
        Some(cycles.collect())
    }

    /// The cycle at C = `viscous` with bounds as narrow as the error of C allows.
    #[must_use]
    pub fn narrowed(&self, cycle: CycleRange, viscous: f64) -> CycleRange {
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
        CycleRange { near: [(low - allowance).max(from), (high + allowance).min(to)], ..cycle }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};
    use slipmap_model::point::LawParameters;
    use slipmap_numbers::chebyshev::node;

    /// Within three errors of an extreme, and where it is flat, a backbone tells no number of cycles.
    #[test]
    fn no_cycles_are_told_within_a_large_error_of_an_extreme() {
        // C = 1 + 4 x (1 - x), x = r / V: it rises from 1 to 2 at half the belt speed and falls back.
        let c = |x: f64| 1.0 + 4.0 * x * (1.0 - x);
        let values: Vec<f64> = (0..=8).map(|i| c(0.5 * (1.0 + node(i, 8)))).collect();
        for node_error in [1e-6, 1e-5, 1e-4] {
            let backbone = Backbone::of_values(1.0, values.clone(), node_error);
            let error = backbone.error;
            assert!(error >= node_error && error < 0.3, "{error}");
            assert_eq!(backbone.folds().len(), 1, "{error}");
            for share in [-2.9, -0.5, 0.0, 0.5, 2.9] {
                assert_eq!(backbone.cycles(2.0 + share * error, true, false), None, "{error} {share}");
            }
            let cycles = backbone.cycles(2.0 - 100.0 * error, true, false).unwrap();
            assert!(cycles.len() == 2 && !cycles[0].is_stable && cycles[1].is_stable, "{cycles:?}");
            assert_eq!(backbone.cycles(2.0 + 3.1 * error, true, false), Some(Vec::new()));
        }
    }

    /// Plateaus of C, between which it has bends of all widths: no polynomial of 129 nodes follows them, halves do.
    #[test]
    fn halves_follow_plateaus() {
        let step = |fall: f64, place: f64, width: f64| format!("{fall}*(tanh((u - {place})/{width}) + 1)/2");
        let text = format!("1 - {} - {}", step(0.295, 0.0234, 0.0014), step(0.236, 0.133, 0.0018));
        let law = Law::Expression(Expression::new(&text, 1.0).unwrap());
        let (curve, belt_speed) = (law.curve(1.0, &LawParameters::new(&[])), 0.886);
        let (work, tolerance) = (Work::of(Piece::FineBackbone, &curve), 1e-9);
        let one = Backbone::with_intervals(&curve, belt_speed, tolerance, SIZES[1], &work).unwrap();
        let halves = one.refined(&curve, tolerance, &work).unwrap().unwrap();
        assert!(one.error > 1e-3 && halves.error < 1e-6, "{} {}", one.error, halves.error);
        let radii: Vec<f64> = (1..100).map(|i| 0.01 * f64::from(i) * belt_speed).collect();
        let exact = Solver::new(&curve, belt_speed, tolerance, &work).at(&radii).unwrap();
        for (radius, exact) in radii.iter().zip(exact) {
            let apart = (halves.viscous(*radius) - exact.viscous).abs();
            assert!(apart <= halves.error + exact.error, "{radius}: {apart} {exact:?} {}", halves.error);
        }
    }
}

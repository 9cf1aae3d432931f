//! The bifurcations of codimension one, each as a test function that changes its sign there, and their curves
//! in any plane of two parameters; and [those of codimension two](super::points) on these curves.
//!
//! | bifurcation | test function | what happens |
//! | --- | --- | --- |
//! | Hopf | D(V), the trace at the equilibrium | the equilibrium changes its stability, a slip cycle is born |
//! | grazing-sliding | c* - c, times pi eps | the orbit from the exit point comes back to the belt line, or not |
//! | landing | `crossing::reach` less 2; with a drop j the landing speed less 2 - j | it lands on the stick segment, or beyond and crosses |
//! | crossing | `crossing::reach` less 2 (2 - j) | it sticks after one crossing, or crosses for ever |
//! | fold | C - eps c at the extreme of the backbone C(r) that is nearest to eps c | two slip cycles meet and vanish |

use std::f64::consts::PI;
use std::sync::atomic::{AtomicU64, Ordering};

use super::backbone::Backbone;
use super::continuation::{BATCH, TestValue};
use super::critical::{CriticalDamping, NoCriticalDamping, critical_damping};
use super::crossing::{beyond_landing, reach_within};
use super::points::slope;
use slipmap_model::filippov::{HopfRate, Oscillator};
use slipmap_model::flow::Failure;
use slipmap_model::friction::Column;
use slipmap_numbers::jet::Jet;
use slipmap_numbers::named;
use slipmap_orbits::{Piece, Work};

/// Factor from the tolerance to a coarser one: the difference of the two values is taken as the error.
const COARSER: f64 = 100.0;
/// Work counted for a closed orbit with its slope.
const COUNTED: u64 = 2_000;
/// Number of roundings that count in the error of a third derivative.
const ROUNDINGS: f64 = 64.0;
/// Error of a compiled law, in units of the weakening rate at the belt speed, up to which orbits follow it.
const ACCURATE: f64 = 1e-9;

named! {
    /// A bifurcation of codimension one or two, with its name in tables.
    #[derive(Clone, Copy, Debug, PartialEq, Eq)]
    pub enum Bifurcation {
        /// The trace of the linearisation at the equilibrium vanishes.
        Hopf => "hopf",
        /// The orbit from the exit point grazes the belt line.
        GrazingSliding => "grazing_sliding",
        /// The orbit from the exit point comes back to the far end of the stick segment.
        Landing => "landing",
        /// The orbit from the exit point, having crossed the belt line, comes back through the exit point.
        Crossing => "crossing",
        /// Two slip cycles meet and vanish.
        Fold => "fold",
        /// On a Hopf curve: the slip cycle that is born there changes its stability.
        Bautin => "bautin",
        /// Hopf curve and grazing curve cross.
        HopfAtGrazing => "hopf_at_grazing",
        /// On a grazing curve: a fold curve ends there.
        FoldAtGrazing => "fold_at_grazing",
        /// Two fold curves meet.
        Cusp => "cusp",
    }
}

impl Bifurcation {
    /// Those of codimension one.
    pub const CURVES: [Self; 5] =
        [Self::Hopf, Self::GrazingSliding, Self::Landing, Self::Crossing, Self::Fold];

    /// The curve on which it lies, of one of codimension two.
    #[must_use]
    pub fn along(self) -> Option<Self> {
        match self {
            Self::Bautin | Self::HopfAtGrazing => Some(Self::Hopf),
            Self::FoldAtGrazing => Some(Self::GrazingSliding),
            Self::Cusp => Some(Self::Fold),
            Self::Hopf | Self::GrazingSliding | Self::Landing | Self::Crossing | Self::Fold => None,
        }
    }
}

/// The budget of the curves of one kind in a plane, in evaluations of the right-hand side of the Stribeck law or of a
/// compiled one: some four seconds. The curves of the gallery are complete within it.
pub const CURVE_WORK: u64 = 14 * TEST_WORK;
/// Work of one test at the most.
const TEST_WORK: u64 = Piece::Test.quota();
/// The most work for the curves of a kind: the tests of one batch may exceed the budget.
pub const MOST_CURVE_WORK: u64 = CURVE_WORK + BATCH as u64 * TEST_WORK;

/// The work of the tests for the curves of a kind in a plane.
#[derive(Debug, Default)]
pub struct CurveWork(AtomicU64);

impl CurveWork {
    fn add(&self, evaluations: u64) {
        self.0.fetch_add(evaluations, Ordering::Relaxed);
    }

    /// Whether the budget [`CURVE_WORK`] is spent.
    pub fn is_spent(&self) -> bool {
        self.0.load(Ordering::Relaxed) >= CURVE_WORK
    }

    /// Adds the work of a backbone, which may have failed.
    pub fn add_backbone(&self, found: &Result<Backbone, Failure>) {
        self.add(found.as_ref().map_or(TEST_WORK, |backbone| backbone.rhs));
    }

    /// Adds the work of a search for the critical damping of a column. One that failed may have taken all of its budget.
    pub fn add_critical(&self, column: &Column, found: &Result<CriticalDamping, NoCriticalDamping>) {
        self.add(found.map_or(TEST_WORK, |found| work_of(column, &found)));
    }
}

impl Bifurcation {
    /// The test function, of codimension two the degeneracy, with an accuracy of about `tolerance`; `None` where it is
    /// undefined or unknown, and of a cusp, which is [sought](super::points::cusp) otherwise. Its work is added to `work`.
    pub fn test(self, oscillator: &Oscillator, tolerance: f64, work: &CurveWork) -> Option<TestValue> {
        let own = Work::of(Piece::Test, &oscillator.curve);
        let value = self.test_within(oscillator, tolerance, &own);
        work.add(1 + own.spent());
        value
    }

    fn test_within(self, oscillator: &Oscillator, tolerance: f64, work: &Work) -> Option<TestValue> {
        let fastest = oscillator.fastest_sticking();
        // What a landing at the exit point, or none, has for the landing and the crossing.
        let stays = |reach: f64| Some(TestValue { value: -reach, error: 4.0 * f64::EPSILON });
        match self {
            Bifurcation::Landing if is_overdamped(oscillator) => stays(fastest),
            Bifurcation::Crossing if is_overdamped(oscillator) => stays(2.0 * fastest),
            Bifurcation::Hopf => {
                let value = oscillator.divergence(oscillator.belt_speed);
                // D(V), up to the rounding of the difference.
                let error = 4.0 * f64::EPSILON * (value.abs() + oscillator.viscous.abs());
                let rate = HopfRate::new(&oscillator.curve, oscillator.belt_speed).value();
                // A damping that is not distinguishable from 0 is no curve.
                (rate != 0.0).then_some(TestValue { value, error })
            }
            Bifurcation::GrazingSliding => margin(oscillator, tolerance, work),
            // With a drop the reach jumps at the landing.
            Bifurcation::Landing if oscillator.drop() > 0.0 => with_error(tolerance, |tolerance| {
                let beyond = beyond_landing(oscillator, tolerance, work)?;
                Ok(beyond.unwrap_or(-oscillator.fastest_sticking()))
            }),
            Bifurcation::Landing => with_error(tolerance, |tolerance| {
                Ok(reach_within(oscillator, 0.0, tolerance, work)? - fastest)
            }),
            Bifurcation::Crossing => with_error(tolerance, |tolerance| {
                Ok(reach_within(oscillator, 0.0, tolerance, work)? - 2.0 * fastest)
            }),
            Bifurcation::Cusp => None,
            Bifurcation::Bautin => bend(oscillator),
            // C(V) is no curve then.
            Bifurcation::HopfAtGrazing | Bifurcation::FoldAtGrazing if oscillator.drop() > 0.0 => None,
            Bifurcation::HopfAtGrazing => {
                let hopf = HopfRate::new(&oscillator.curve, oscillator.belt_speed);
                let at_hopf = Oscillator { viscous: hopf.value(), ..oscillator.clone() };
                margin(&at_hopf, tolerance, work)
            }
            Bifurcation::FoldAtGrazing => {
                let column = column_of(oscillator);
                work.spend(COUNTED).ok()?;
                slope(&column, column.belt_speed, tolerance)
            }
            // None can meet.
            Bifurcation::Fold if oscillator.curve.has_one_slip_cycle_at_most(oscillator.belt_speed) => None,
            // For planes without the damping; in planes with it the extremes are followed (`graphs`).
            Bifurcation::Fold => {
                let backbone = enough_backbone(oscillator, tolerance, work)?;
                let excess = backbone.folds().iter().map(|fold| fold.viscous - oscillator.viscous);
                let value = excess.min_by(|a, b| a.abs().total_cmp(&b.abs()))?;
                Some(TestValue { value, error: backbone.error })
            }
        }
    }
}

/// Whether D <= -2 at all slip speeds that the orbit from the exit point can reach, so that it never returns (theory,
/// "Breakaway"): there its steps would be short.
fn is_overdamped(oscillator: &Oscillator) -> bool {
    let Oscillator { curve, viscous, belt_speed } = oscillator;
    let fastest = belt_speed + belt_speed.hypot(oscillator.drop());
    *viscous > 2.0 && curve.weakening_range(0.0, fastest).hi - viscous <= -2.0
}

/// The coarsest backbone that has all extremes, none of them next to the damping of the oscillator, or that of this
/// tolerance.
fn enough_backbone(oscillator: &Oscillator, tolerance: f64, work: &Work) -> Option<Backbone> {
    let is_enough = |it: &Backbone, _: bool| it.has_all_extremes() && it.is_reliable_at(oscillator.viscous);
    Backbone::enough(oscillator, tolerance, work, is_enough).ok()
}

/// A test function, with its difference from that at a coarser tolerance as the error.
fn with_error(tolerance: f64, value: impl Fn(f64) -> Result<f64, Failure>) -> Option<TestValue> {
    let (fine, coarse) = (value(tolerance).ok()?, value(COARSER * tolerance).ok()?);
    Some(TestValue { value: fine, error: (fine - coarse).abs() + 4.0 * f64::EPSILON })
}

/// The work of a search for a critical damping: its orbits follow the compiled law where that is accurate.
fn work_of(Column { curve, belt_speed, .. }: &Column, found: &CriticalDamping) -> u64 {
    let form = curve.compiled(4.0 * belt_speed).error(0.0, 2.0 * belt_speed).bound();
    let is_accurate = form <= ACCURATE * curve.weakening(*belt_speed).abs();
    found.rhs * if is_accurate { 1 } else { curve.cost() }
}

/// The column of an oscillator, with eps c as its damping.
pub(super) fn column_of(Oscillator { curve, belt_speed, .. }: &Oscillator) -> Column {
    Column { curve: curve.clone(), epsilon: 1.0, belt_speed: *belt_speed, unit: 1.0 }
}

/// w''(V) V^2, with its rounding; `None` of a law without a formula.
fn bend(Oscillator { curve, belt_speed, .. }: &Oscillator) -> Option<TestValue> {
    let phi = curve.formula(Jet::<f64, 4>::variable(*belt_speed, 1.0))?.0;
    let of = |order: usize, factor: f64| factor * phi[order] * belt_speed.powi(2);
    let size = phi.iter().enumerate().map(|(order, term)| (term * belt_speed.powi(order as i32 - 1)).abs());
    Some(TestValue { value: -of(3, 6.0), error: ROUNDINGS * f64::EPSILON * size.sum::<f64>() })
}

/// The distance from the critical damping, which has the zero and the sign of the grazing margin, and about its size.
fn margin(oscillator: &Oscillator, tolerance: f64, work: &Work) -> Option<TestValue> {
    let (column, viscous) = (column_of(oscillator), oscillator.viscous);
    let found = critical_damping(&column, tolerance);
    // A search that failed may have taken all of its budget.
    work.spend_compiled(found.map_or(Piece::Critical.quota(), |found| work_of(&column, &found))).ok()?;
    let critical = found.and_then(CriticalDamping::known).ok()?;
    Some(TestValue { value: PI * (critical.c - viscous), error: PI * critical.error })
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::{Expression, Law};

    /// Slip cycles of the first law do not meet, which takes no orbit to know; those of the second, whose friction falls
    /// fastest beyond the belt speed, do.
    #[test]
    fn no_backbone_is_followed_where_slip_cycles_cannot_meet() {
        let fold = |formula: &str| {
            let law = Law::Expression(Expression::new(formula, 1.0).unwrap());
            let work = CurveWork::default();
            let oscillator = Oscillator::new(&law, &law.point(1.0, &[], 0.2, 0.5).unwrap());
            let found = Bifurcation::Fold.test(&oscillator, 1e-9, &work);
            (found.is_some(), work.0.into_inner())
        };
        assert_eq!(fold("0.35 + 0.25*exp(-u/0.1) + 0.4*exp(-u/0.5)"), (false, 1));
        let (is_found, work) = fold("1 - 0.3*tanh((u - 0.25)/0.05) - 0.3*tanh(5)");
        assert!(is_found && work > 1000, "{is_found} {work}");
    }

    /// Orbits of rosin that graze the belt line leave the polar form, and so does the margin on the side where they stick: on both
    /// sides of its curve the test function has one slope.
    #[test]
    fn grazing_is_followed_beyond_the_polar_form() {
        let formula = "0.4*exp(-47.7*u) + 0.45*exp(-4.77*u) + 0.35";
        let law = Law::Expression(Expression::new(formula, 1.2).unwrap());
        let at = |c: f64| law.point(1.0, &[], 0.25, c).unwrap();
        let critical = critical_damping(&law.column(&at(0.0)), 1e-9).unwrap().c;
        for distance in [1e-2, 1e-4, 1e-6] {
            for from in [-distance, distance] {
                let oscillator = Oscillator::new(&law, &at(critical + from));
                let test = Bifurcation::GrazingSliding.test(&oscillator, 1e-10, &CurveWork::default());
                let slope = test.unwrap().value / from;
                assert!((slope / PI + 1.0).abs() < 1e-2, "{slope} at {from}");
            }
        }
    }
}

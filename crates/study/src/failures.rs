//! The catalogue of failures: compares every method with the simulated flow, cell by cell, and attributes
//! every failure to a mechanism.
//!
//! **Truth** at a point is the verdict on which the two engines of the simulated flow agree. No method is
//! compared at points on which they disagree, or which are closer to the boundary than their errors.
//!
//! **Mechanisms** are attributed by removal: a defect explains a failure if the method without this defect
//! does not fail there. Without the expansion in eps `perturbation` is `harmonic_balance`, and
//! `bendixson_leading` is `bendixson`. A naive method is run again after a change of the parameter that
//! causes the defect. A failure that remains after every removal is `unexplained`. The reason
//! why a test leaves a cell undecided follows from its claim.

mod mechanism;
mod smoothing;

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

pub(crate) use mechanism::Mechanism;
pub use smoothing::{Changed, Widths, creep_width};

use slipmap_column::HALVINGS;
use slipmap_column::limits::Ray;
use slipmap_column::{Method, Verdict, critical_damping, sticks_from};
use slipmap_map::{Grid, unravel};
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Fate;
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::Point;
use slipmap_numbers::{named, named_sums};
use slipmap_orbits::{Effort, flow};

named! {
    /// Kind of failure of a method at a cell.
    #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
    pub enum FailureKind {
        /// The verdict is present, and no stick-slip cycle exists.
        WrongPresence => "wrong_presence",
        /// The verdict is absent, and a stick-slip cycle exists.
        WrongAbsence => "wrong_absence",
        /// The verdict is undecided.
        Undecided => "undecided",
        /// The method breaks down.
        Failed => "failed",
    }
}

impl FailureKind {
    /// The failure of the verdict `claimed`; `None` if it is right.
    fn of(claimed: Verdict, truth: Verdict) -> Option<FailureKind> {
        match claimed {
            Verdict::Present if truth == Verdict::Absent => Some(FailureKind::WrongPresence),
            Verdict::Absent if truth == Verdict::Present => Some(FailureKind::WrongAbsence),
            Verdict::Present | Verdict::Absent => None,
            Verdict::Undecided | Verdict::NotComputed => Some(FailureKind::Undecided),
            Verdict::Failed => Some(FailureKind::Failed),
        }
    }

    /// Returns whether the method gives a wrong answer.
    fn is_wrong(self) -> bool {
        matches!(self, FailureKind::WrongPresence | FailureKind::WrongAbsence)
    }
}

/// The cells at which one method fails in one way by one mechanism.
#[derive(Clone, Debug, PartialEq)]
pub struct Class {
    pub kind: FailureKind,
    pub mechanism: Mechanism,
    pub cells: u64,
    /// The largest distance |c - c'| to the nearest damping c' at which the verdict of the simulated flow
    /// changes; NaN where there is none.
    pub farthest_c: f64,
    /// Estimate of the error of `farthest_c`: that of c'.
    pub farthest_c_error: f64,
    /// The largest distance in eps to the nearest such change at eps <= 10; NaN where
    /// there is none, and for undecided cells, for which it is not computed.
    pub farthest_epsilon: f64,
    /// The cell of `farthest_c`, or the first cell.
    pub example: Point,
}

#[derive(Clone, Debug, PartialEq)]
pub struct MethodFailures {
    pub method: Method,
    /// Number of cells at which the method was compared.
    pub cells: u64,
    /// Its classes of failure, ordered by kind, within a kind the largest first.
    pub classes: Vec<Class>,
}

impl MethodFailures {
    /// Number of cells with one kind of failure.
    pub fn count(&self, kind: FailureKind) -> u64 {
        self.classes.iter().filter(|class| class.kind == kind).map(|class| class.cells).sum()
    }

    /// Number of cells on which the method is right.
    pub fn right(&self) -> u64 {
        self.cells - self.classes.iter().map(|class| class.cells).sum::<u64>()
    }

    /// The largest distances from the true boundary at which the method answers wrongly: in c, the error of
    /// that, and in eps; NaN where it never does.
    pub fn farthest_wrong(&self) -> [f64; 3] {
        let wrong = self.classes.iter().filter(|class| class.kind.is_wrong());
        wrong.fold([f64::NAN; 3], |[c, error, epsilon], class| {
            let [c, error] = farther([c, error], [class.farthest_c, class.farthest_c_error]);
            [c, error, epsilon.max(class.farthest_epsilon)]
        })
    }
}

named_sums! {
    /// Numbers of cells by their true answer.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    pub struct Truth of u64 {
        /// A stick-slip cycle exists.
        pub present,
        /// The orbit from the exit point spirals inward.
        pub inward,
        /// The orbit from the exit point crosses the belt line for ever.
        pub crossing,
        /// An engine's margin is within its error.
        pub too_close,
        /// An engine gives no answer, or the two engines contradict each other.
        pub open,
    }
}

/// The catalogue of failures over a set of points.
#[derive(Clone, Debug, PartialEq)]
pub struct Catalogue {
    /// Numbers of points by their true answer.
    pub truth: Truth,
    pub methods: Vec<MethodFailures>,
    /// Of smoothed friction, if it is among the methods.
    pub smoothing: Option<[Widths; 3]>,
}

/// The error of a catalogue that was stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("interrupted")]
pub struct Interrupted;

/// Arguments of a catalogue.
#[derive(Clone, Copy)]
pub struct Comparison<'a> {
    pub law: &'a Law,
    pub methods: &'a [Method],
    /// Bound on the error of the scaled grazing margin that the engines aim at.
    pub tolerance: f64,
    /// Called after every point, from any thread of the current pool.
    pub on_point: &'a (dyn Fn() + Sync),
    /// Set to true to stop.
    pub stop: &'a AtomicBool,
}

/// One failure of one method at one point.
struct Finding {
    method: usize,
    kind: FailureKind,
    mechanism: Mechanism,
}

/// The result at one point.
struct Examined {
    truth: Truth,
    findings: Vec<Finding>,
    /// Distance in c to the nearest change, and its error.
    distance_c: [f64; 2],
    distance_epsilon: f64,
}

/// The larger of two distances, each with its error; NaN is no distance.
fn farther(a: [f64; 2], b: [f64; 2]) -> [f64; 2] {
    if a[0] >= b[0] || b[0].is_nan() { a } else { b }
}

pub fn points_of(grid: &Grid) -> Vec<Point> {
    let shape = grid.shape();
    (0..grid.cells()).map(|cell| grid.point(&unravel(cell, &shape))).collect()
}

/// Compares every method with the simulated flow at every point. The result depends on the points and their
/// order, not on the number of threads.
pub fn catalogue(points: &[Point], comparison: &Comparison) -> Result<Catalogue, Interrupted> {
    let examined: Vec<Examined> = points
        .par_iter()
        .map(|point| {
            if comparison.stop.load(Ordering::Relaxed) {
                return Err(Interrupted);
            }
            let examined = examine(point, comparison);
            (comparison.on_point)();
            Ok(examined)
        })
        .collect::<Result<_, _>>()?;
    let mut truth = Truth::default();
    let mut methods: Vec<MethodFailures> = comparison
        .methods
        .iter()
        .map(|&method| MethodFailures { method, cells: 0, classes: Vec::new() })
        .collect();
    for (point, examined) in points.iter().zip(&examined) {
        truth.add(&examined.truth);
        for finding in &examined.findings {
            methods[finding.method].add(point, examined, finding);
        }
    }
    for method in &mut methods {
        method.cells = truth.present + truth.inward + truth.crossing;
        method.classes.sort_by_key(|class| (class.kind, std::cmp::Reverse(class.cells)));
    }
    let sticks = |(point, examined): (&Point, &Examined)| (examined.truth.present > 0).then_some(*point);
    let sticking: Vec<Point> = points.iter().zip(&examined).filter_map(sticks).collect();
    Ok(Catalogue { truth, methods, smoothing: smoothing::widths(&sticking, comparison)? })
}

impl MethodFailures {
    fn add(&mut self, point: &Point, examined: &Examined, finding: &Finding) {
        let Finding { kind, mechanism, .. } = *finding;
        let place = self.classes.iter().position(|class| class.kind == kind && class.mechanism == mechanism);
        let place = place.unwrap_or_else(|| {
            self.classes.push(Class {
                kind,
                mechanism,
                cells: 0,
                farthest_c: f64::NAN,
                farthest_c_error: f64::NAN,
                farthest_epsilon: f64::NAN,
                example: *point,
            });
            self.classes.len() - 1
        });
        let class = &mut self.classes[place];
        class.cells += 1;
        let before = class.farthest_c;
        [class.farthest_c, class.farthest_c_error] =
            farther([before, class.farthest_c_error], examined.distance_c);
        if class.farthest_c.to_bits() != before.to_bits() {
            class.example = *point;
        }
        if kind != FailureKind::Undecided {
            class.farthest_epsilon = class.farthest_epsilon.max(examined.distance_epsilon);
        }
    }
}

fn examine(point: &Point, comparison: &Comparison) -> Examined {
    let column = comparison.law.column(point);
    let oscillator = Oscillator::in_column(&column, point.damping);
    let tolerance = comparison.tolerance;
    let mut examined = Examined {
        truth: Truth::default(),
        findings: Vec::new(),
        distance_c: [f64::NAN; 2],
        distance_epsilon: f64::NAN,
    };
    let (first, second) =
        (flow(&oscillator, tolerance).fate, slipmap_witness::flow(&oscillator, tolerance).fate);
    if first == Fate::TooCloseToCall || second == Fate::TooCloseToCall {
        examined.truth.too_close = 1;
        return examined;
    }
    let truth = Verdict::from(&first);
    if truth == Verdict::Failed || truth != Verdict::from(&second) {
        examined.truth.open = 1;
        return examined;
    }
    match first {
        Fate::Sticks(_) => examined.truth.present = 1,
        Fate::SpiralsInward => examined.truth.inward = 1,
        Fate::CrossesForever | Fate::TooCloseToCall | Fate::Failed(_) => examined.truth.crossing = 1,
    }
    for (number, method) in comparison.methods.iter().enumerate() {
        let claimed = match method {
            Method::Test(test) => test.claim(&column).decide(point.damping).into(),
            Method::Naive(naive, knobs) => naive.decide(&oscillator, knobs).verdict.into(),
            Method::Simulation | Method::Direct => truth,
        };
        if let Some(kind) = FailureKind::of(claimed, truth) {
            let mechanism = mechanism::of(*method, &column, point.damping, kind, &first);
            examined.findings.push(Finding { method: number, kind, mechanism });
        }
    }
    if !examined.findings.is_empty() {
        examined.distance_c = distance_in_c(&column, point.damping, &first, tolerance);
    }
    if examined.findings.iter().any(|finding| finding.kind != FailureKind::Undecided) {
        let change = Ray::new(comparison.law, point, tolerance).nearest_change(point.epsilon);
        examined.distance_epsilon = change.map_or(f64::NAN, |change| (change - point.epsilon).abs());
    }
    examined
}

/// The distance from `c` to the nearest damping at which the simulated verdict changes: the critical damping,
/// which may be negative, or the damping below which orbits cross for ever; and its error. NaN if there is
/// neither.
fn distance_in_c(column: &Column, c: f64, fate: &Fate, tolerance: f64) -> [f64; 2] {
    let Ok(critical) = critical_damping(column, tolerance) else { return [f64::NAN; 2] };
    let to_grazing = [(critical.c - c).abs(), critical.error];
    let undamped = 0.0;
    let range = match fate {
        Fate::CrossesForever => [c, critical.c],
        Fate::Sticks(_) if c > undamped => [undamped, c],
        _ => return to_grazing,
    };
    let middle = |tolerance: f64| {
        let [low, high] = sticks_from(Effort::Whole, column, range, HALVINGS, tolerance).between;
        [0.5 * (low + high), 0.5 * (high - low)]
    };
    let [from, half] = middle(tolerance);
    if from == undamped {
        return to_grazing;
    }
    // What a coarser search is in doubt about, and the last bracket of the search.
    let error = (from - middle(COARSER * tolerance)[0]).abs() + half + 1e-12 * (range[1] - range[0]);
    let to_crossing = [(from - c).abs(), error];
    let [distance, error] = to_crossing;
    if distance - error < to_grazing[0] { to_crossing } else { to_grazing }
}

/// Factor of the tolerance of the search that shows the error of another.
const COARSER: f64 = 10.0;

#[cfg(test)]
mod tests {
    use super::*;

    /// The critical damping of an overdamped column is below every legal one.
    #[test]
    fn the_distance_to_a_negative_critical_damping_is_measured() {
        let point = Law::Stribeck.point(1.0, &[0.0, 0.1, 8.0], 2.0, 7.0).unwrap();
        let column = Law::Stribeck.column(&point);
        let [distance, error] = distance_in_c(&column, point.damping, &Fate::SpiralsInward, 1e-9);
        // The direct engine changes its verdict at c* = -0.28495104.
        for (c, returns) in [(7.0 - distance - 1e-6, true), (7.0 - distance + 1e-6, false)] {
            let fate = slipmap_witness::flow(&Oscillator::in_column(&column, c), 1e-9).fate;
            assert_eq!(fate != Fate::SpiralsInward, returns, "{c}");
        }
        assert!((distance - 7.284951037970746).abs() <= error && error < 1e-6, "{distance} {error}");
    }

    /// On a fast belt orbits cross for ever at small damping.
    #[test]
    fn the_distance_to_the_crossing_orbits_is_measured() {
        let point = Law::Stribeck.point(1.0, &[0.0, 0.0, 0.1], 30.0, 0.0).unwrap();
        let column = Law::Stribeck.column(&point);
        let fate = |c: f64| flow(&Oscillator::in_column(&column, c), 1e-9).fate;
        let [from, error] = distance_in_c(&column, 0.0, &fate(0.0), 1e-9);
        assert_eq!(fate(from - 1e-6), Fate::CrossesForever);
        assert!(matches!(fate(from + 1e-6), Fate::Sticks(_)));
        let c = from + 1e-4;
        assert!((distance_in_c(&column, c, &fate(c), 1e-9)[0] - 1e-4).abs() < 1e-9);
        let [better, _] = distance_in_c(&column, 0.0, &fate(0.0), 1e-12);
        assert!((from - better).abs() <= error && error < 1e-6, "{from} {better} {error}");
    }
}

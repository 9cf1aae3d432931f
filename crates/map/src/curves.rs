//! Curves of codimension one in planes of a grid: the boundaries of the long-run behaviour, located also
//! between the nodes.
//!
//! Curves are found and followed in the unit square of the plane, whose sides run from the first to the last
//! node of an axis, linearly or, if the nodes are logarithmic, logarithmically. Errors are distances in the
//! square. On the curves lie points of codimension two (`column::points`). Where the damping is one of the axes, the grazing
//! curve is the critical damping, and fold curves are the extremes of the backbone, as functions of the other axis
//! (`column::graphs`). All other curves are found by continuation.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::grid::Extent;
use super::{AxisRole, Grid};
use slipmap_column::backbone::{Backbone, TurningPoint};
use slipmap_column::bifurcation::{Bifurcation, CurveWork};
use slipmap_column::continuation::{Branch, CurvePoint, zero_curves};
use slipmap_column::critical::{CriticalDamping, critical_damping};
use slipmap_column::graphs::{Extreme, graphs};
use slipmap_column::points::{cusp, points_on};
use slipmap_model::filippov::{HopfRate, Oscillator};
use slipmap_model::friction::Column;

/// Tolerance of the test functions and of the backbones.
const TOLERANCE: f64 = 1e-10;
/// Distance, in sides of the plane, beside their errors, of cusps that are one.
const SAME: f64 = 1e-6;

/// Names of the columns of stored curves that are not axes. If curves are stored, no axis may have one of
/// these names.
pub const CURVE_COLUMNS: [&str; 8] =
    ["plane", "point", "plane_x", "plane_y", "plane_number", "curve", "branch", "error"];

/// A plane of a grid: two axes that vary, and a node of each other axis.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Plane {
    /// Position of the first axis, horizontal in figures.
    pub x: usize,
    /// Position of the second axis.
    pub y: usize,
    /// Node of each fixed axis; 0, without meaning, for the two axes of the plane.
    pub held: Vec<usize>,
}

/// A point of a curve in a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlanePoint {
    /// Value of the first axis.
    pub x: f64,
    /// Value of the second axis.
    pub y: f64,
    /// Estimate of its distance from the curve, in units of the sides of the plane.
    pub error: f64,
}

/// A connected curve in a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneCurve {
    /// Its kind.
    pub bifurcation: Bifurcation,
    /// Its points in order; a closed curve ends with its first point.
    pub points: Vec<PlanePoint>,
}

/// The curves of a plane.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneCurves {
    /// The plane.
    pub plane: Plane,
    /// Its curves, in the order of `Bifurcation::ALL`; points of codimension two, as curves of one point, last.
    pub curves: Vec<PlaneCurve>,
    /// The kinds whose curves are incomplete, since the budget of their search or of their points was spent.
    pub cut: Vec<Bifurcation>,
}

impl Plane {
    /// The plane of two axes through the given node of each other axis.
    #[must_use]
    pub fn new(x: usize, y: usize, mut held: Vec<usize>) -> Self {
        held[x] = 0;
        held[y] = 0;
        Self { x, y, held }
    }

    /// The plane with its axes exchanged.
    pub fn turned(&self) -> Self {
        Self { x: self.y, y: self.x, held: self.held.clone() }
    }
}

impl PlaneCurves {
    /// Finds and follows the curves of a plane of `grid` whose two axes have several nodes each. When `stop`
    /// is set, the curves end at once.
    #[must_use]
    pub fn of(grid: &Grid, plane: Plane, stop: &AtomicBool) -> Self {
        Self::of_kinds(&Bifurcation::ALL, grid, plane, stop)
    }

    /// As [`PlaneCurves::of`], for the given kinds only: points of codimension two on curves among these.
    pub fn of_kinds(kinds: &[Bifurcation], grid: &Grid, plane: Plane, stop: &AtomicBool) -> Self {
        let frame = Frame::new(grid, &plane);
        let of_kind = |&bifurcation: &Bifurcation| {
            let kinds = kinds.iter().copied().filter(|kind| kind.along() == Some(bifurcation));
            let work = CurveWork::default();
            let test = |place: [f64; 2]| match stop.load(Ordering::Relaxed) {
                true => None,
                false => bifurcation.test(&frame.oscillator(place)?, TOLERANCE, &work),
            };
            let curve = |branch: Branch| PlaneCurve {
                bifurcation,
                points: branch.points.iter().map(|found| frame.point(found)).collect(),
            };
            let extremes = |damping: usize, share: f64| match (stop.load(Ordering::Relaxed), bifurcation) {
                (true, _) => Vec::new(),
                (_, Bifurcation::Fold) => frame.extremes(damping, share, &work).unwrap_or_default(),
                _ => frame.grazing(damping, share, &work).into_iter().collect(),
            };
            let (found, is_cut) = match (bifurcation, frame.damping_axis()) {
                (Bifurcation::Fold | Bifurcation::GrazingSliding, Some(axis)) => {
                    (graphs(&|share| extremes(axis, share), axis, &|| work.is_spent()), work.is_spent())
                }
                _ => zero_curves(&test, &|| work.is_spent()),
            };
            let cut = is_cut.then_some(bifurcation);
            let points = kinds.flat_map(|kind| {
                let work = CurveWork::default();
                let points = match kind {
                    Bifurcation::Cusp => frame.cusps(&found, &work),
                    _ => {
                        let degeneracy =
                            |place: [f64; 2]| match stop.load(Ordering::Relaxed) || work.is_spent() {
                                true => None,
                                false => kind.test(&frame.oscillator(place)?, TOLERANCE, &work),
                            };
                        found.iter().flat_map(|branch| points_on(branch, &test, &degeneracy)).collect()
                    }
                };
                let one =
                    |point: CurvePoint| PlaneCurve { bifurcation: kind, points: vec![frame.point(&point)] };
                points.into_iter().map(one).collect::<Vec<_>>()
            });
            let points: Vec<PlaneCurve> = points.collect();
            (found.into_iter().map(curve).collect::<Vec<_>>(), points, cut)
        };
        let curves: Vec<Bifurcation> = kinds.iter().copied().filter(|kind| kind.along().is_none()).collect();
        let found: Vec<_> = curves.par_iter().map(of_kind).collect();
        let (mut curves, mut points, mut cut) = (Vec::new(), Vec::new(), Vec::new());
        for (of_kind, on_it, is_cut) in found {
            curves.extend(of_kind);
            points.extend(on_it);
            cut.extend(is_cut);
        }
        curves.extend(points);
        Self { plane, curves, cut }
    }

    /// The same curves in the plane with its axes exchanged.
    pub fn turned(&self) -> Self {
        let turned = |point: &PlanePoint| PlanePoint { x: point.y, y: point.x, error: point.error };
        let curves = self.curves.iter().map(|curve| PlaneCurve {
            bifurcation: curve.bifurcation,
            points: curve.points.iter().map(turned).collect(),
        });
        Self { plane: self.plane.turned(), curves: curves.collect(), cut: self.cut.clone() }
    }

    /// "Curves that may end early or be missing, because their search reached its limit: fold curve", if any are.
    #[must_use]
    pub fn cut_in_words(&self) -> Option<String> {
        let kinds: Vec<String> =
            self.cut.iter().map(|kind| format!("{} curve", kind.name().replace('_', " "))).collect();
        let all = kinds.join(", ");
        (!kinds.is_empty()).then(|| {
            format!("Curves that may end early or be missing, because their search reached its limit: {all}")
        })
    }

    /// Number of points of all curves.
    #[must_use]
    pub fn points(&self) -> usize {
        self.curves.iter().map(|curve| curve.points.len()).sum()
    }

    /// The curves, each with its number among the curves of its kind, counted from 1.
    pub fn numbered(&self) -> impl Iterator<Item = (usize, &PlaneCurve)> {
        let of_kind = |curve: &PlaneCurve, position: usize| {
            self.curves[..position].iter().filter(|other| other.bifurcation == curve.bifurcation).count()
        };
        self.curves.iter().enumerate().map(move |(position, curve)| (of_kind(curve, position) + 1, curve))
    }
}

/// The backbone of a column that may have extremes; `None` of others, and where it is unknown.
fn backbone(column: &Column, work: &CurveWork) -> Option<Backbone> {
    if column.curve.has_one_slip_cycle_at_most(column.belt_speed) {
        return None;
    }
    let found = Backbone::of(column, TOLERANCE);
    work.add_backbone(&found);
    found.ok()
}

/// The unit square of a plane.
struct Frame<'a> {
    grid: &'a Grid,
    plane: &'a Plane,
    sides: [Extent; 2],
}

impl<'a> Frame<'a> {
    fn new(grid: &'a Grid, plane: &'a Plane) -> Self {
        let sides = [plane.x, plane.y].map(|axis| grid.axes()[axis].extent());
        Self { grid, plane, sides }
    }

    fn oscillator(&self, place: [f64; 2]) -> Option<Oscillator> {
        self.grid.oscillator_of(&self.at(place)).ok()
    }

    fn at(&self, place: [f64; 2]) -> Vec<f64> {
        let mut values = self.grid.values(&self.plane.held);
        for ((axis, side), share) in [self.plane.x, self.plane.y].into_iter().zip(self.sides).zip(place) {
            values[axis] = side.value(share);
        }
        values
    }

    /// The position, 0 or 1, of the damping among the two axes; `None` if it is neither.
    fn damping_axis(&self) -> Option<usize> {
        [self.plane.x, self.plane.y].iter().position(|axis| self.grid.axes()[*axis].role == AxisRole::Damping)
    }

    /// The extremes of the backbone at a place of the other axis; `None` if there are none or it is unknown.
    fn extremes(&self, damping_axis: usize, share: f64, work: &CurveWork) -> Option<Vec<Extreme>> {
        let column = self.column(damping_axis, share)?;
        let backbone = backbone(&column, work)?;
        let extreme = |turns: &[TurningPoint]| {
            let [damping, error] = [turns[1].viscous, backbone.error].map(|viscous| viscous / column.epsilon);
            let (height, error) = self.height(damping_axis, damping, error);
            let amplitude = turns[1].radius / column.belt_speed;
            Extreme { amplitude, height, error, is_maximum: turns[1].viscous > turns[0].viscous }
        };
        Some(backbone.turning_points().windows(3).map(extreme).collect())
    }

    /// The critical damping at a place of the other axis, as an extreme at the belt line; `None` if it is unknown or
    /// that of flat friction.
    fn grazing(&self, damping_axis: usize, share: f64, work: &CurveWork) -> Option<Extreme> {
        let column = self.column(damping_axis, share)?;
        let found = critical_damping(&column, TOLERANCE);
        work.add_critical(&column, &found);
        let critical = found.and_then(CriticalDamping::known).ok()?;
        // That of flat friction is no curve, as its Hopf damping.
        let is_flat = || HopfRate::new(&column.curve, column.belt_speed).value() == 0.0;
        if critical.c.abs() <= critical.error && is_flat() {
            return None;
        }
        let (height, error) = self.height(damping_axis, critical.c, critical.error);
        Some(Extreme { amplitude: 1.0, height, error, is_maximum: true })
    }

    /// The cusps at which these fold curves end: one of the two may have been missed, since they leave at a tangent.
    fn cusps(&self, folds: &[Branch], work: &CurveWork) -> Vec<CurvePoint> {
        let apart = |a: CurvePoint, b: CurvePoint| (a.place[0] - b.place[0]).hypot(a.place[1] - b.place[1]);
        let ends = folds.iter().filter(|branch| !branch.closed).flat_map(|branch| {
            [branch.points.first().copied(), branch.points.last().copied()].into_iter().flatten()
        });
        let mut found: Vec<CurvePoint> = Vec::new();
        for end in ends.filter(|end| end.place.iter().all(|side| *side > 0.0 && *side < 1.0)) {
            let is_new = |point: &CurvePoint| {
                found.iter().all(|other| apart(*point, *other) > point.error + other.error + SAME)
            };
            let point = self.cusp(end, work).filter(is_new);
            found.extend(point);
        }
        found
    }

    /// The cusp next to the end of a fold curve: between two extremes that nearly meet there.
    fn cusp(&self, end: CurvePoint, work: &CurveWork) -> Option<CurvePoint> {
        let oscillator = self.oscillator(end.place)?;
        let column = self.grid.column_of(&self.at(end.place)).ok()?;
        let backbone = backbone(&column, work)?;
        let off = |pair: &&[TurningPoint]| {
            pair.iter().map(|it| (it.viscous - oscillator.viscous).abs()).fold(0.0, f64::max)
        };
        let pair = backbone.folds().windows(2).min_by(|a, b| off(a).total_cmp(&off(b)))?;
        let amplitude = 0.5 * (pair[0].radius + pair[1].radius) / column.belt_speed;
        cusp(&|place| self.oscillator(place), end.place, amplitude)
    }

    /// The column at a place of the other axis.
    fn column(&self, damping_axis: usize, share: f64) -> Option<Column> {
        let mut place = [share; 2];
        place[damping_axis] = 0.0;
        self.grid.column_of(&self.at(place)).ok()
    }

    /// A damping and its error in sides of the plane. On a logarithmic axis, dampings that are not positive get a share far
    /// below 0.
    fn height(&self, damping_axis: usize, damping: f64, error: f64) -> (f64, f64) {
        let height = |damping: f64| self.sides[damping_axis].share(damping).max(-1e9);
        (height(damping), (height(damping + error) - height(damping)).abs())
    }

    fn point(&self, found: &CurvePoint) -> PlanePoint {
        let [s, t] = found.place;
        PlanePoint { x: self.sides[0].value(s), y: self.sides[1].value(t), error: found.error }
    }
}

//! The boundaries of the long-run behaviour in a plane.

use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::json;

use super::machine::{BELT_SPEED, DAMPING, is_shared};
use super::plane::{PlaneRequest, Slice};
use super::refusal::Refusal;
use slipmap_map::machine::{Machine, Model, Units};
use slipmap_map::map::{Plane, PlaneCurve, PlaneCurves, PlanePoint};
use slipmap_model::filippov::HopfRate;
use slipmap_model::friction::Column;
use slipmap_report::figure::bifurcations::line_style;
use slipmap_simulate::bifurcation::Bifurcation;
use slipmap_simulate::critical::{CriticalDamping, critical_dampings};

impl PlaneRequest {
    /// The boundaries of the long-run behaviour.
    pub(super) fn boundaries(&self, stop: &AtomicBool) -> Result<serde_json::Value, Refusal> {
        // The nodes between the ends show whether an axis is logarithmic. The ends themselves may be illegal.
        const NODES: usize = 9;
        const ROOM: f64 = 1e-4;
        if let Some(machine) = self.place.machine()? {
            return self.boundaries_of_machine(&machine, NODES, ROOM, stop);
        }
        self.curves_in(&self.slice(|side| side.between(NODES, ROOM))?, [1.0, 1.0], stop)
    }

    /// The boundaries in a plane of a machine, in SI units: all of them over belt speed and damping; over
    /// damping and another quantity the Hopf and the grazing curve, which are one damping for each value;
    /// else none.
    fn boundaries_of_machine(
        &self,
        machine: &Machine,
        nodes: usize,
        room: f64,
        stop: &AtomicBool,
    ) -> Result<serde_json::Value, Refusal> {
        let sides = self.sides(|side| side.between(nodes, room))?;
        let is = |side: usize, name: &str| sides[side].0.axis == name;
        if let Some(up) = [1, 0].into_iter().find(|&side| is(side, DAMPING) && !is(1 - side, BELT_SPEED)) {
            if self.folds {
                return Ok(curves_json(&[], [1.0, 1.0]));
            }
            let (other, highest) = (sides[1 - up].0, sides[up].0.to);
            let found = limits(machine, &other.axis, &other.between(LIMITS, room)?, highest, up == 0);
            return Ok(curves_json(&found, [1.0, 1.0]));
        }
        if !sides.iter().all(|(side, _)| is_shared(&side.axis)) {
            return Ok(curves_json(&[], [1.0, 1.0]));
        }
        let Units { velocity, damping, .. } = machine.units();
        let units = if is(0, BELT_SPEED) { [velocity, damping] } else { [damping, velocity] };
        self.curves_in(&self.of_machine(machine, &[&sides[0], &sides[1]])?, units, stop)
    }

    /// The requested curves in a plane, found by continuation, in the units `units` of the two axes.
    fn curves_in(
        &self,
        Slice { grid, x, y, .. }: &Slice,
        units: [f64; 2],
        stop: &AtomicBool,
    ) -> Result<serde_json::Value, Refusal> {
        let kinds: Vec<Bifurcation> =
            Bifurcation::ALL.into_iter().filter(|kind| (*kind == Bifurcation::Fold) == self.folds).collect();
        let plane = Plane::new(*x, *y, vec![0; grid.axes().len()]);
        let found = PlaneCurves::of_kinds(&kinds, grid, plane, stop);
        match stop.load(Ordering::Relaxed) {
            true => Err(Refusal::overtaken()),
            false => Ok(curves_json(&found.curves, units)),
        }
    }
}

/// Number of values of a quantity at which the limits of the damping are computed first, and their accuracy.
const LIMITS: usize = 33;
const ACCURACY: f64 = 1e-8;
/// Where a curve bends by more than `BEND` of the picture, values are added, at most `REFINEMENTS` times.
const BEND: f64 = 2e-3;
const REFINEMENTS: usize = 8;

/// The Hopf damping and the critical damping at a value of another quantity, each with its error, in SI units;
/// NaN where there is none.
#[derive(Clone, Copy)]
struct Limit {
    value: f64,
    hopf: [f64; 2],
    grazing: [f64; 2],
}

impl Limit {
    /// The limits at those of `values` for which the machine is legal.
    fn of(machine: &Machine, name: &str, values: &[f64]) -> Vec<Self> {
        let model = |&value: &f64| {
            let machine = machine.with(name, value).filter(Machine::is_legal)?;
            Some((value, machine.model()?))
        };
        let models: Vec<_> = values.iter().filter_map(model).collect();
        let columns: Vec<_> = models.iter().map(|(_, model)| model.column()).collect();
        let roots = critical_dampings(&columns, ACCURACY).into_iter().map(|root| {
            let known = root.and_then(CriticalDamping::known);
            known.map_or([f64::NAN; 2], |root| [root.c, root.error])
        });
        let limit = |(((value, model), column), root): ((&(f64, Model), &Column), [f64; 2])| {
            let in_si = |number: f64| number * model.si.units.damping;
            let hopf = HopfRate::new(&column.curve, column.belt_speed);
            Self { value: *value, hopf: [hopf.value(), hopf.rounding()].map(in_si), grazing: root.map(in_si) }
        };
        models.iter().zip(&columns).zip(roots).map(limit).collect()
    }

    /// Distance of this limit from the straight line between its neighbours, in damping.
    fn bend(self, before: Self, after: Self) -> f64 {
        let share = (self.value - before.value) / (after.value - before.value);
        let off = |of: fn(Self) -> f64| (of(before) + share * (of(after) - of(before)) - of(self)).abs();
        off(|limit| limit.hopf[0]).max(off(|limit| limit.grazing[0]))
    }
}

/// The Hopf and the grazing curve of a machine over another quantity, in a picture with dampings up to
/// `highest`; `turned` if the damping is the horizontal axis.
fn limits(machine: &Machine, name: &str, values: &[f64], highest: f64, turned: bool) -> Vec<PlaneCurve> {
    let mut found = Limit::of(machine, name, values);
    for _ in 0..REFINEMENTS {
        let bent = found.windows(3).filter(|near| near[1].bend(near[0], near[2]) > BEND * highest);
        let middle = |a: Limit, b: Limit| 0.5 * (a.value + b.value);
        let mut more: Vec<f64> =
            bent.flat_map(|near| [middle(near[0], near[1]), middle(near[1], near[2])]).collect();
        more.dedup();
        if more.is_empty() {
            break;
        }
        found.append(&mut Limit::of(machine, name, &more));
        found.sort_by(|a, b| a.value.total_cmp(&b.value));
    }
    let curve = |bifurcation, of: fn(&Limit) -> [f64; 2]| {
        let points = found.iter().filter(|limit| of(limit)[0] >= 0.0).map(|limit| {
            let [damping, error] = of(limit);
            let (x, y) = if turned { (damping, limit.value) } else { (limit.value, damping) };
            PlanePoint { x, y, error: error / highest }
        });
        PlaneCurve { bifurcation, points: points.collect() }
    };
    vec![
        curve(Bifurcation::Hopf, |limit| limit.hopf),
        curve(Bifurcation::GrazingSliding, |limit| limit.grazing),
    ]
}

/// Curves with their style, their points multiplied by the units of the axes, and the error of each point as a
/// share of the picture's sides.
fn curves_json(curves: &[PlaneCurve], [across, up]: [f64; 2]) -> serde_json::Value {
    let one = |curve: &PlaneCurve| {
        let (stroke, words) = line_style(curve.bifurcation);
        let points: Vec<[f64; 2]> =
            curve.points.iter().map(|point| [point.x * across, point.y * up]).collect();
        json!({
            "name": curve.bifurcation.name(),
            "words": words,
            "color": stroke.color,
            "width": stroke.width,
            "dash": stroke.dash,
            "points": points,
            "errors": curve.points.iter().map(|point| point.error).collect::<Vec<f64>>(),
        })
    };
    json!({ "curves": curves.iter().map(one).collect::<Vec<_>>() })
}

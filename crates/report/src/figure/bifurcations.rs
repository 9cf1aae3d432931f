//! Curves of codimension one in the plane of a slice.

use std::sync::atomic::AtomicBool;

use rayon::prelude::*;

use super::super::view::View;
use super::slice::Slice;
use slipmap_column::bifurcation::Bifurcation;
use slipmap_figure::data::Data;
use slipmap_map::PlaneCurves;
use slipmap_orbits::flow;
pub(crate) use slipmap_page::curves::{draw, places};

/// Number of points along each axis whose orbits tell how long a boundary takes.
const SAMPLE: usize = 5;
/// Largest mean work of their orbits, in evaluations of the right-hand side of the Stribeck law (see
/// [`slipmap_model::friction::Curve::cost`]): a boundary takes some thousand orbits, and about a second.
const WORK: u64 = 40_000;
/// Accuracy of the orbits of the sample.
const TOLERANCE: f64 = 1e-9;

/// The boundary of the set of points of a slice whose orbit sticks again: the grazing and the crossing curve.
/// Empty also where stiff orbits would take too long.
pub(crate) fn boundary(slice: &Slice) -> PlaneCurves {
    let (grid, plane) = (slice.view.map.grid(), slice.plane());
    let kinds = [Bifurcation::GrazingSliding, Bifurcation::Crossing];
    match mean_work(slice) <= WORK {
        true => PlaneCurves::of_kinds(&kinds, grid, plane, &AtomicBool::new(false)),
        false => PlaneCurves { plane, curves: Vec::new(), cut: Vec::new() },
    }
}

/// The mean work of the orbits of a sample.
fn mean_work(slice: &Slice) -> u64 {
    let [x, y] = slice.scales().map(|(scale, _)| scale);
    // Along axes of the law's parameters every point has its own law, which is compiled for it.
    let law_axes = 0..slice.view.map.grid().axes().len() - 2;
    let compiles = law_axes.contains(&slice.x) || law_axes.contains(&slice.y);
    let at = |i: usize| (i as f64 + 0.5) / SAMPLE as f64;
    let work = |n: usize| {
        let Some(oscillator) = slice.oscillator(x.value(at(n / SAMPLE)), y.value(at(n % SAMPLE))) else {
            return 0;
        };
        let compiling = if compiles { oscillator.curve.compiling_work(oscillator.belt_speed) } else { 0 };
        let orbit = flow(&oscillator, TOLERANCE).rhs.saturating_mul(oscillator.curve.cost());
        orbit.saturating_add(compiling) / (SAMPLE * SAMPLE) as u64
    };
    (0..SAMPLE * SAMPLE).into_par_iter().map(work).reduce(|| 0, u64::saturating_add)
}

/// All points as a table: the curve, the number of its branch from 1, the values of both axes, and the error,
/// a distance in sides of the plotted rectangle.
pub fn data(view: &View, curves: &PlaneCurves) -> Data {
    let axes = view.map.grid().axes();
    let [x, y] = [curves.plane.x, curves.plane.y].map(|axis| view.axis(&axes[axis]));
    let points = || {
        let curves = curves.numbered();
        curves.flat_map(|(number, curve)| curve.points.iter().map(move |point| (number, curve, point)))
    };
    Data::default()
        .words("curve", points().map(|(_, curve, _)| curve.bifurcation.name().into()).collect())
        .words("branch", points().map(|(number, ..)| number.to_string()).collect())
        .reals(x.header(), points().map(|(.., point)| point.x * x.factor).collect())
        .reals(y.header(), points().map(|(.., point)| point.y * y.factor).collect())
        .reals("error", points().map(|(.., point)| point.error).collect())
}

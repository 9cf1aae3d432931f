//! The boundaries of the long-run behaviour in a plane.

use std::sync::atomic::{AtomicBool, Ordering};

use serde_json::json;

use super::plane::{PlaneRequest, Slice};
use super::refusal::Refusal;
use slipmap_column::bifurcation::Bifurcation;
use slipmap_map::{Plane, PlaneCurve, PlaneCurves};
use slipmap_page::curves::line_style;

impl PlaneRequest {
    /// The boundaries of the long-run behaviour.
    pub(super) fn boundaries(&self, stop: &AtomicBool) -> Result<serde_json::Value, Refusal> {
        // The nodes between the ends show whether an axis is logarithmic. The ends themselves may be illegal.
        const NODES: usize = 9;
        const ROOM: f64 = 1e-4;
        let Slice { grid, x, y, .. } = self.slice(|side| side.between(NODES, ROOM))?;
        // A point of codimension two comes with its curve.
        let is_fold = |kind: Bifurcation| kind.along().unwrap_or(kind) == Bifurcation::Fold;
        let kinds: Vec<Bifurcation> =
            Bifurcation::ALL.into_iter().filter(|kind| is_fold(*kind) == self.folds).collect();
        let plane = Plane::new(x, y, vec![0; grid.axes().len()]);
        let found = PlaneCurves::of_kinds(&kinds, &grid, plane, stop);
        match stop.load(Ordering::Relaxed) {
            true => Err(Refusal::stopped()),
            false => Ok(curves_json(&found.curves)),
        }
    }
}

/// Curves with their style, their points, and the error of each point as a share of the picture's sides.
fn curves_json(curves: &[PlaneCurve]) -> serde_json::Value {
    let one = |curve: &PlaneCurve| {
        let (stroke, words) = line_style(curve.bifurcation);
        let points: Vec<[f64; 2]> = curve.points.iter().map(|point| [point.x, point.y]).collect();
        json!({
            "name": curve.bifurcation.name(),
            "words": words,
            "color": stroke.color,
            "width": stroke.width,
            "dash": stroke.dash,
            "mark": curve.bifurcation.along().is_some(),
            "points": points,
            "errors": curve.points.iter().map(|point| point.error).collect::<Vec<f64>>(),
        })
    };
    json!({ "curves": curves.iter().map(one).collect::<Vec<_>>() })
}

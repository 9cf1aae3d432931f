//! Proofs by the method `validated` over the whole box of parameters, the points between the nodes included.

use std::sync::atomic::Ordering;
use std::time::Instant;

use super::{Axis, Control, Grid, Plan, unravel};
use slipmap_certify::curve::BoxProof;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;

/// The proofs over the box of all parameters, from the first to the last node of every axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Proved {
    /// What is proved.
    pub proof: BoxProof,
    /// Wall-clock seconds that the proofs took.
    pub seconds: f64,
}

/// The law in dimensionless form, and the ranges of eps, its parameters, V and c.
fn parameters(plan: &Plan) -> Option<(Law, Vec<[f64; 2]>)> {
    let ends = |last: bool| {
        let end = |axis: &Axis| axis.values[if last { axis.values.len() - 1 } else { 0 }];
        plan.grid.place(&plan.grid.axes().iter().map(end).collect::<Vec<_>>())
    };
    let (law, first, _) = ends(false)?;
    let (_, last, _) = ends(true)?;
    let [first, last] = [first, last].map(|point| law.coordinates(&point));
    let ranges = first.into_iter().zip(last).map(|((_, from), (_, to))| [from, to]);
    Some((law.clone(), ranges.collect()))
}

/// A point and a range of dampings.
pub type ProvedColumn = (Point, [f64; 2]);

/// The law in dimensionless form, and the point of each column with its range of dampings; `None` where the law differs from
/// column to column.
pub fn columns(grid: &Grid) -> Option<(Law, Vec<ProvedColumn>)> {
    let axes = grid.axes();
    let outer: Vec<usize> = axes[..axes.len() - 1].iter().map(|axis| axis.values.len()).collect();
    let mut law = None;
    let column = |number: usize| {
        let mut values = grid.values(&[unravel(number, &outer), vec![0]].concat());
        let (own, point, _) = grid.place(&values)?;
        *values.last_mut()? = *grid.dampings().last()?;
        let (_, last, _) = grid.place(&values)?;
        (*law.get_or_insert_with(|| own.clone()) == own).then_some((point, [point.damping, last.damping]))
    };
    let columns = (0..grid.column_count()).map(column).collect::<Option<_>>()?;
    Some((law?, columns))
}

/// Computes the proofs that the plan requests; stops early if told so. `None` if the plan requests no proofs, or if the threads cannot be started. The proofs do
/// not depend on the number of threads.
pub(crate) fn prove(plan: &Plan, control: &Control) -> Option<Proved> {
    if plan.proof_boxes == 0 {
        return None;
    }
    let pool = super::pool(control.threads).ok()?;
    let start = Instant::now();
    let go_on = |tried: usize| {
        (control.on_boxes)(tried);
        !control.stop.load(Ordering::Relaxed)
    };
    let (law, mut ranges) = parameters(plan)?;
    let damping = ranges.pop()?;
    let mut proof = pool.install(|| BoxProof::new(&law, ranges, damping));
    pool.install(|| proof.refine(plan.proof_boxes, &go_on));
    Some(Proved { proof, seconds: start.elapsed().as_secs_f64() })
}

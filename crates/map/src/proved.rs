//! Proofs by the method `validated` over the whole box of parameters, the points between the nodes included.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::{Axis, Plan};
use slipmap_certify::validated::boxes::BoxProof;
use slipmap_certify::validated::law_boxes::LawProof;
use slipmap_certify::validated::surface::Surface;
use slipmap_certify::validated::volumes::Volumes;
use slipmap_model::friction::Law;

/// Number of boxes of another law for each that a plan requests: a box of Stribeck's law takes some fifty
/// times as long, and covers more.
const BOXES_OF_OTHER_LAWS: usize = 25;

/// The proofs over the box of all parameters, from the first to the last node of every axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Proved {
    /// Proved volumes, as shares of the box.
    pub volumes: Volumes,
    /// Wall-clock seconds that the proofs took.
    pub seconds: f64,
    pub proof: Proofs,
}

/// What is proved.
#[derive(Clone, Debug, PartialEq)]
pub enum Proofs {
    /// The universal surface of Stribeck's law.
    Surface(Surface),
    /// The critical damping of another law.
    Law(Box<LawProof>),
}

/// Number of boxes that a plan tries to prove.
pub fn boxes_to_try(plan: &Plan) -> usize {
    match plan.grid.law().as_written() {
        Law::Stribeck => plan.proof_boxes,
        _ => plan.proof_boxes.saturating_mul(BOXES_OF_OTHER_LAWS),
    }
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

/// Computes the proofs that the plan requests with `threads` threads (all cores if `None`); stops early if
/// `stop` is set. `None` if the plan requests no proofs, or if the threads cannot be started. The proofs do
/// not depend on the number of threads.
pub fn prove(plan: &Plan, threads: Option<usize>, stop: &AtomicBool) -> Option<Proved> {
    if plan.proof_boxes == 0 {
        return None;
    }
    let pool = super::pool(threads).ok()?;
    let start = Instant::now();
    let go_on = || !stop.load(Ordering::Relaxed);
    let (law, ranges) = parameters(plan)?;
    let (volumes, proof) = match (law.as_written(), ranges.as_slice()) {
        (Law::Stribeck, &[epsilon, alpha, beta, gamma, belt_speed, damping]) => {
            let mut proof = BoxProof::new([epsilon, alpha, beta, gamma, belt_speed], damping);
            pool.install(|| proof.refine(plan.proof_boxes, &go_on));
            (proof.volumes(), Proofs::Surface(proof.surface))
        }
        (law, [parameters @ .., damping]) => {
            let mut proof = LawProof::new(law, parameters.to_vec(), *damping);
            pool.install(|| proof.refine(boxes_to_try(plan), &go_on));
            (proof.volumes(), Proofs::Law(Box::new(proof)))
        }
        _ => return None,
    };
    Some(Proved { volumes, seconds: start.elapsed().as_secs_f64(), proof })
}

//! Proofs by the method `validated` over the whole box of parameters, between the nodes of the grid too.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use super::{Method, Plan};
use crate::certify::validated;
use crate::certify::validated::boxes::{BoxProof, Budget, ParameterBox, Volumes};
use crate::certify::validated::surface::Surface;
use crate::friction::Law;

/// A box of parameters, and the proofs over it.
#[derive(Clone, Debug, PartialEq)]
pub struct Proved {
    /// From the first to the last node of every axis.
    pub parameters: ParameterBox,
    /// Proved volumes, as shares of the box.
    pub volumes: Volumes,
    /// Wall-clock seconds.
    pub seconds: f64,
    /// The proofs.
    pub surface: Surface,
}

/// Proves with `threads` workers (all cores if `None`) what the plan asks for, or less if `stop` is set;
/// `None` if it asks for nothing, or if the workers cannot be started.
#[must_use]
pub fn prove(plan: &Plan, threads: Option<usize>, stop: &AtomicBool) -> Option<Proved> {
    let asked = plan.proof_boxes > 0 && plan.methods.contains(&Method::Test(&validated::TEST));
    let parameters = asked.then(|| parameters(plan))??;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build().ok()?;
    Some(pool.install(|| subdivide(plan, parameters, stop)))
}

fn subdivide(plan: &Plan, parameters: ParameterBox, stop: &AtomicBool) -> Proved {
    let start = Instant::now();
    let mut proof = BoxProof::new(&parameters);
    proof.refine(Budget::of_boxes(plan.proof_boxes), &|| !stop.load(Ordering::Relaxed));
    let (volumes, seconds) = (proof.volumes(), start.elapsed().as_secs_f64());
    Proved { parameters, volumes, seconds, surface: proof.into_surface() }
}

/// The whole box; `None` for laws whose boxes are not proved.
fn parameters(plan: &Plan) -> Option<ParameterBox> {
    let ranges: Vec<[f64; 2]> =
        plan.grid.axes().iter().map(|axis| [axis.values[0], axis.values[axis.values.len() - 1]]).collect();
    match plan.grid.law().as_written() {
        // The order of the axes: eps, the law's parameters, V, c.
        Law::Stribeck => Some(ParameterBox {
            epsilon: ranges[0],
            alpha: ranges[1],
            beta: ranges[2],
            gamma: ranges[3],
            belt_speed: ranges[4],
            damping: ranges[5],
        }),
        _ => None,
    }
}

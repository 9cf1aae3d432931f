//! Proofs by the method `validated` over the whole box of parameters, the points between the nodes included.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use rayon::ThreadPool;

use super::{Method, Plan};
use crate::certify::validated;
use crate::certify::validated::boxes::{BoxProof, Budget, ParameterBox, Volumes};
use crate::certify::validated::prover::{Prover, Threads};
use crate::certify::validated::surface::Surface;
use crate::certify::validated::tile::{GroupBox, Tile};
use crate::friction::Law;

/// A box of parameters, and the proofs over it.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Proved {
    /// The box: from the first to the last node of every axis.
    pub(crate) parameters: ParameterBox,
    /// Proved volumes, as shares of the box.
    pub(crate) volumes: Volumes,
    /// Wall-clock seconds that the proofs took.
    pub(crate) seconds: f64,
    pub(crate) surface: Surface,
}

/// Computes the proofs that the plan requests with `threads` workers (all cores if `None`) and `others`;
/// stops early if `stop` is set. `None` if the plan requests no proofs, or if the workers cannot be started.
/// The proofs do not depend on the number of workers.
pub(crate) fn prove(
    plan: &Plan,
    threads: Option<usize>,
    others: Option<&dyn Prover>,
    stop: &AtomicBool,
) -> Option<Proved> {
    let wanted = plan.proof_boxes > 0 && plan.methods.contains(&Method::Test(&validated::TEST));
    let parameters = wanted.then(|| parameters(plan))??;
    let pool = super::pool(threads).ok()?;
    let start = Instant::now();
    let Budget { tiles, parts } = Budget::of_boxes(plan.proof_boxes);
    let go_on = || !stop.load(Ordering::Relaxed);
    let mut proof = BoxProof::new(&parameters);
    // Other processes are reached from the calling thread only.
    match others {
        Some(others) => proof.refine_surface(tiles, &Shared { pool: &pool, others }, &go_on),
        None => pool.install(|| proof.refine_surface(tiles, &Threads, &go_on)),
    }
    pool.install(|| proof.refine_parts(parts, &go_on));
    let (volumes, seconds) = (proof.volumes(), start.elapsed().as_secs_f64());
    Some(Proved { parameters, volumes, seconds, surface: proof.surface })
}

/// The threads of this process, and the workers of other processes.
struct Shared<'a> {
    pool: &'a ThreadPool,
    others: &'a dyn Prover,
}

impl Prover for Shared<'_> {
    fn workers(&self) -> usize {
        self.pool.current_num_threads() + self.others.workers()
    }

    fn prove(&self, domains: &[GroupBox]) -> Vec<Option<Tile>> {
        let own = (domains.len() * self.pool.current_num_threads()).div_ceil(self.workers());
        let (own, theirs) = domains.split_at(own);
        if theirs.is_empty() {
            return self.pool.install(|| Threads.prove(own));
        }
        std::thread::scope(|scope| {
            let own = scope.spawn(|| self.pool.install(|| Threads.prove(own)));
            let theirs = self.others.prove(theirs);
            let mut proofs = own.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic));
            proofs.extend(theirs);
            proofs
        })
    }
}

/// The box of all parameters; `None` for laws other than Stribeck's, whose boxes are not proved.
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

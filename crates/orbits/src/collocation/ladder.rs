//! The choice of a rung (numbers of nodes and sweeps) for an orbit: the cheapest expected to reach the
//! tolerance, then more expensive ones until the error estimate does.

use std::sync::{LazyLock, OnceLock};

use super::nodes::Nodes;
use super::{Lap, Laps};
use crate::polar::Turn;
use slipmap_model::point::ScaledGroups;

/// Numbers of pairs of nodes, and log2 of the truncation error on them as about
/// `[0] + [1] log2(variation of D) + [2] k / (1 + k)`. Chosen for the fewest evaluations over random points;
/// a wrong guess costs one more lap, not accuracy.
const TRUNCATION: [(usize, [f64; 3]); 10] = [
    (4, [-4.8, 1.0, 0.0]),
    (5, [-11.7, 1.1, 18.8]),
    (6, [-12.4, 1.5, 17.0]),
    (7, [-14.2, 1.3, 2.5]),
    (8, [-22.9, 1.3, 10.9]),
    (9, [-25.0, 2.0, 32.0]),
    (11, [-24.5, 2.0, 17.8]),
    (14, [-31.9, 2.5, 15.6]),
    (17, [-25.0, 5.0, 9.3]),
    (20, [-27.5, 7.1, 15.2]),
];

/// Least number of evaluations of H per node.
const FEWEST: u32 = 2;

/// log2 of the error after 2, 3 and 4 evaluations of H per node as about `[0] + [1] log2(variation of D) +
/// [2] log2(variation + size of D)`.
const ITERATION: [[f64; 3]; 3] = [[-8.2, 3.7, 1.8], [-11.2, 4.2, 3.3], [-18.8, 6.3, 5.3]];

/// Largest divergence at belt speed of orbits that are not handed over at once.
const NEAR: f64 = 0.5;
/// Largest k of such orbits: beyond it the pole of the divergence is so close to the ends of the turn that
/// the nodes do not resolve it.
const GREATEST_K: f64 = 4.0;

/// Largest error estimate of ln r that is reliable.
const MEANINGFUL: f64 = 0.01;

/// log2(x) of a positive number, to 0.09.
fn rough_log2(x: f64) -> f64 {
    x.to_bits() as f64 * 2f64.powi(-52) - 1023.0
}

/// The rung of an orbit: indices into [`TRUNCATION`] and [`ITERATION`].
#[derive(Clone, Copy, Debug, PartialEq)]
struct Rung {
    size: usize,
    sweeps: usize,
}

impl Rung {
    /// The rung to try first; `None` far from the circle.
    fn first(groups: &ScaledGroups, tolerance: f64) -> Option<Self> {
        let at_belt_speed = groups.divergence(1.0);
        if !(at_belt_speed.abs() <= NEAR && groups.k <= GREATEST_K) {
            return None;
        }
        let ends = [0.0, 2.0].map(|s| (groups.divergence(s) - at_belt_speed).abs());
        let variation = ends[0].max(ends[1]).max(f64::MIN_POSITIVE);
        let log_variation = rough_log2(variation);
        let log_size = rough_log2(variation + at_belt_speed.abs());
        let log_tolerance = rough_log2(tolerance.max(f64::MIN_POSITIVE));
        let hyperbolic = groups.k / (1.0 + groups.k);
        let exceeds =
            |fit: &[f64; 3], other: f64| fit[0] + fit[1] * log_variation + fit[2] * other > log_tolerance;
        let size = TRUNCATION.iter().position(|(_, fit)| !exceeds(fit, hyperbolic))?;
        let sweeps = ITERATION.iter().position(|fit| !exceeds(fit, log_size))?;
        Some(Self { size, sweeps })
    }

    /// The next rung with more nodes.
    fn finer(self) -> Option<Self> {
        (self.size + 1 < TRUNCATION.len()).then_some(Self { size: self.size + 1, ..self })
    }

    /// The next rung with more sweeps.
    fn longer(self) -> Option<Self> {
        (self.sweeps + 1 < ITERATION.len()).then_some(Self { sweeps: self.sweeps + 1, ..self })
    }

    fn nodes(self) -> &'static Nodes {
        static NODES: LazyLock<[OnceLock<Nodes>; TRUNCATION.len()]> = LazyLock::new(Default::default);
        NODES[self.size].get_or_init(|| Nodes::new(TRUNCATION[self.size].0))
    }

    /// Number of evaluations of H per node.
    fn evaluations(self) -> u32 {
        FEWEST + self.sweeps as u32
    }

    /// Number of evaluations of H in all.
    fn cost(self) -> u32 {
        2 * TRUNCATION[self.size].0 as u32 * self.evaluations()
    }
}

/// Number of orbits that are processed together: enough to fill the vectors of every rung, few enough for
/// their data to stay in the cache.
const TOGETHER: usize = 2048;

/// One turn of every orbit, each with an error estimate of at most `tolerance`, or of the rounding error
/// where that is greater; an orbit for which no rung achieves that is handed over.
///
/// An orbit's answer does not depend on its neighbours in the slice, nor on the machine's vector width.
pub(crate) fn turns(groups: &[ScaledGroups], tolerance: f64) -> Vec<Turn> {
    let mut turns = vec![Turn::HandOver { rhs: 0 }; groups.len()];
    let mut ladder = Ladder::default();
    for (groups, turns) in groups.chunks(TOGETHER).zip(turns.chunks_mut(TOGETHER)) {
        ladder.compute(groups, tolerance, turns);
    }
    turns
}

/// Orbits sorted by rung.
#[derive(Default)]
struct Ladder {
    waiting: [[Vec<u32>; ITERATION.len()]; TRUNCATION.len()],
    laps: Vec<Lap>,
}

impl Ladder {
    /// Computes every orbit, on ever more expensive rungs until the error is small enough.
    fn compute(&mut self, groups: &[ScaledGroups], tolerance: f64, turns: &mut [Turn]) {
        for (orbit, groups) in (0..).zip(groups) {
            if let Some(rung) = Rung::first(groups, tolerance) {
                self.waiting[rung.size][rung.sweeps].push(orbit);
            }
        }
        for size in 0..TRUNCATION.len() {
            for sweeps in 0..ITERATION.len() {
                let rung = Rung { size, sweeps };
                let mut orbits = std::mem::take(&mut self.waiting[size][sweeps]);
                if orbits.is_empty() {
                    continue;
                }
                self.laps.clear();
                pulp::Arch::new().dispatch(Laps {
                    nodes: rung.nodes(),
                    evaluations: rung.evaluations(),
                    groups,
                    orbits: &orbits,
                    laps: &mut self.laps,
                });
                for (&orbit, lap) in orbits.iter().zip(&self.laps) {
                    let turn = &mut turns[orbit as usize];
                    let (Turn::HandOver { rhs } | Turn::Complete { rhs, .. }) = *turn;
                    let rhs = rhs + rung.cost();
                    *turn = Turn::HandOver { rhs };
                    let next = match judge(lap, tolerance) {
                        Outcome::Enough { error } => {
                            *turn = Turn::Complete { margin: lap.margin, error, rhs };
                            None
                        }
                        Outcome::MoreNodes => rung.finer(),
                        Outcome::MoreSweeps => rung.longer(),
                        Outcome::Outside => None,
                    };
                    if let Some(next) = next {
                        self.waiting[next.size][next.sweeps].push(orbit);
                    }
                }
                // Keep the capacity of the list for the next orbits.
                orbits.clear();
                self.waiting[size][sweeps] = orbits;
            }
        }
    }
}

/// Consequence of a lap.
enum Outcome {
    /// The margin has this error, which is small enough.
    Enough {
        error: f64,
    },
    MoreNodes,
    MoreSweeps,
    /// The orbit is not near the circle, and is handed over.
    Outside,
}

fn judge(lap: &Lap, tolerance: f64) -> Outcome {
    // Errors of ln r, for which the estimates are made; they are not reliable where they are not small.
    let error = lap.truncation + lap.iteration;
    if !(lap.room > 0.0 && error < MEANINGFUL) {
        return Outcome::Outside;
    }
    let reach = 1.0 + lap.margin;
    if reach * error <= tolerance.max(reach * lap.rounding) {
        Outcome::Enough { error: reach * (error + lap.rounding) }
    } else if lap.iteration > lap.truncation {
        Outcome::MoreSweeps
    } else {
        Outcome::MoreNodes
    }
}

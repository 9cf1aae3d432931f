//! Number of verdicts of the method `validated` per second and core: single points, each in its own column.
//!
//! ```sh
//! cargo bench --bench point_verdicts
//! ```

#![allow(clippy::expect_used)] // a bench whose points are wrong stops

use std::time::Instant;

use slipmap::certify::{Decision, validated};
use slipmap::friction::Law;
use slipmap::point::Point;
use slipmap_numbers::random::Random;

fn main() {
    let mut random = Random(1);
    let mut unit = || random.unit();
    // The box of configs/validated.toml.
    let mut points = |count: usize| -> Vec<Point> {
        let between = |unit: f64, lo: f64, hi: f64| lo + (hi - lo) * unit;
        (0..count)
            .map(|_| {
                let law = [between(unit(), 0.0, 0.95), between(unit(), 0.0, 0.5), between(unit(), 0.1, 4.0)];
                let (belt_speed, damping) = (between(unit(), 0.2, 1.5), between(unit(), 0.0, 2.0));
                Law::Stribeck.point(0.05, &law, belt_speed, damping).expect("a legal point")
            })
            .collect()
    };
    for round in 0..3 {
        let points = points(100_000);
        let start = Instant::now();
        let mut counts = [0; 3];
        for point in &points {
            let claim = (validated::TEST.claim)(&Law::Stribeck.column(point));
            let which = match claim.decide(point.damping()) {
                Decision::Present => 0,
                Decision::Absent => 1,
                Decision::Undecided => 2,
            };
            counts[which] += 1;
        }
        let anywhere = points.len() as f64 / start.elapsed().as_secs_f64();
        // Near the boundary no shortcut decides.
        let start = Instant::now();
        let near = &points[..10_000];
        let mut decided = 0;
        for point in near {
            let column = Law::Stribeck.column(point);
            let Some(enclosed) = validated::Enclosed::of(&column) else { continue };
            let critical = enclosed.critical();
            let c = critical.lo / point.epsilon() * (1.0 - 1e-9);
            let claim = (validated::TEST.claim)(&column);
            decided += usize::from(claim.decide(c.max(0.0)) != Decision::Undecided);
        }
        // Two proofs each.
        let proofs = 2.0 * near.len() as f64 / start.elapsed().as_secs_f64();
        println!(
            "round {round}: {anywhere:.0} points a second anywhere in the box (present, absent, undecided {counts:?}); \
             {proofs:.0} proofs a second next to the boundary, {decided} of {} decided",
            near.len()
        );
    }
}

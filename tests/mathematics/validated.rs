//! The validated method compared with references in 150-bit arithmetic.

use crate::reference::{ReferenceFate, critical_points, margin_points};
use slipmap::certify::{Claim, Decision, validated};
use slipmap::friction::Law;
use slipmap::point::Point;

fn claim(point: &Point) -> Claim {
    (validated::TEST.claim)(&Law::Stribeck.column(point))
}

#[test]
fn every_reference_critical_damping_is_enclosed() {
    for row in critical_points() {
        let claim = claim(&row.at(0.0));
        // The reference is the f64 nearest to the root.
        let (low, high) = (row.critical_c.next_down(), row.critical_c.next_up());
        assert!(claim.present_below <= high && low <= claim.absent_above, "{row:?} {claim:?}");
        // The enclosure is narrow: some hundred roundings of the terms whose difference c* is, amplified by
        // the samples' factor and by Gronwall's exponentials, each below 20 in this table.
        let size = row.gamma * (1.0 - row.alpha) + 2.0 * row.beta * row.belt_speed;
        assert!(claim.absent_above - claim.present_below < 1e-11 * size, "{row:?} {claim:?}");
    }
}

#[test]
fn no_reference_fate_is_contradicted() {
    let (mut decided, mut all) = (0, 0);
    for row in margin_points() {
        let point = row.point();
        all += 1;
        match claim(&point).decide(point.damping) {
            Decision::Present => {
                assert_eq!(row.fate, ReferenceFate::Sticks, "{row:?}");
                decided += 1;
            }
            Decision::Absent => {
                assert_eq!(row.fate, ReferenceFate::Inward, "{row:?}");
                decided += 1;
            }
            // Orbits that cross the belt line are undecided, as are landings next to the end of the segment.
            Decision::Undecided => {}
        }
    }
    let crossing = margin_points().iter().filter(|row| row.landing_speed.is_some_and(|w| w > 1.98)).count();
    assert!(decided + crossing + all / 50 >= all, "{decided} and {crossing} of {all}");
}

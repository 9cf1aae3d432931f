//! Theorems and proofs compared with references in 150-bit arithmetic.

use slipmap::certify::{Claim, Decision, Test, instability, symmetric, validated};
use slipmap::friction::Law;
use slipmap::point::Point;

use crate::reference::{MarginPoint, ReferenceFate, critical_points, margin_points};

fn claim(test: &Test, point: &Point) -> Claim {
    test.claim(&Law::Stribeck.column(point))
}

#[test]
fn every_reference_critical_damping_is_enclosed() {
    for row in critical_points() {
        let claim = claim(&validated::TEST, &row.at(0.0));
        // The reference is the f64 nearest to the root.
        let (low, high) = (row.critical_c.next_down(), row.critical_c.next_up());
        assert!(claim.present_below <= high && low <= claim.absent_above, "{row:?} {claim:?}");
        // The enclosure is narrow: curves 1e-8 c* apart on either side, and more where they are not found so near.
        let size = row.gamma * (1.0 - row.alpha) + 2.0 * row.beta * row.belt_speed;
        assert!(claim.absent_above - claim.present_below < 1e-5 * size, "{row:?} {claim:?}");
    }
}

/// The table has rows of every fate and of every legal limit.
#[test]
fn theorems_agree_with_the_reference_fates() {
    let points = margin_points();
    for test in [&instability::TEST, &symmetric::TEST, &validated::TEST] {
        let mut decided = 0;
        for p in &points {
            let decision = claim(test, &p.point()).decide(p.damping);
            match decision {
                Decision::Present => assert_eq!(p.fate, ReferenceFate::Sticks, "{}: {p:?}", test.name),
                Decision::Absent => assert_eq!(p.fate, ReferenceFate::Inward, "{}: {p:?}", test.name),
                Decision::Undecided => {}
            }
            decided += usize::from(decision != Decision::Undecided);
        }
        // Orbits that cross the belt line are undecided, as are landings next to the end of the segment.
        let crossing = points.iter().filter(|p| p.landing_speed.is_some_and(|w| w > 1.98)).count();
        let decides_most = decided + crossing + points.len() / 50 >= points.len();
        assert!(test.name != "validated" || decides_most, "{decided} and {crossing} of {}", points.len());
    }
    let count = |wanted: &dyn Fn(&MarginPoint) -> bool| points.iter().filter(|&p| wanted(p)).count();
    for fate in [
        ReferenceFate::Sticks,
        ReferenceFate::SticksFromAbove,
        ReferenceFate::CrossesForever,
        ReferenceFate::Inward,
    ] {
        assert!(count(&|p| p.fate == fate) >= 15, "{fate:?}");
    }
    assert!(count(&|p| p.alpha == 0.0) >= 5);
    assert!(count(&|p| p.alpha == 1.0) >= 5);
    assert!(count(&|p| p.beta == 0.0) >= 5);
    assert!(count(&|p| p.gamma == 0.0) >= 5);
    assert!(count(&|p| p.damping == 0.0) >= 5);
    assert!(count(&|p| p.margin.is_none() && p.fate != ReferenceFate::Inward) >= 5);
}

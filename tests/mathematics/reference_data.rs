//! The theorems compared with the fates of the reference table.

use slipmap::certify::{Decision, Test, instability, symmetric};
use slipmap::friction::Law;
use slipmap::point::Point;

use crate::reference::{MarginPoint, ReferenceFate, margin_points};

fn claim(test: &Test, point: &Point) -> slipmap::certify::Claim {
    (test.claim)(&Law::Stribeck.column(point))
}

/// Theorems compared with fates in extended precision; the table has rows of every fate and of every legal
/// limit.
#[test]
fn theorems_agree_with_the_reference_fates() {
    let points = margin_points();
    for p in &points {
        let sticks = matches!(p.fate, ReferenceFate::Sticks | ReferenceFate::SticksFromAbove);
        for test in [&instability::TEST, &symmetric::TEST] {
            match claim(test, &p.point()).decide(p.damping) {
                Decision::Present => assert!(sticks, "{}: {p:?}", test.name),
                Decision::Absent => assert!(!sticks, "{}: {p:?}", test.name),
                Decision::Undecided => {}
            }
        }
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

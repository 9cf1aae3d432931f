//! The validated method compared with references in 150-bit arithmetic and with the direct engine, with which
//! it shares only the law.

use crate::reference::{ReferenceFate, critical_points, margin_points};
use crate::sample::{Random, Sampling};
use slipmap::certify::{Claim, Decision, Guarantee, validated};
use slipmap::filippov::Oscillator;
use slipmap::friction::Law;
use slipmap::point::Point;
use slipmap::simulate::Fate;
use slipmap::witness;

fn claim(point: &Point) -> Claim {
    (validated::TEST.claim)(&Law::Stribeck.column(point))
}

#[test]
fn its_guarantee_is_validated() {
    assert_eq!(validated::TEST.guarantee, Guarantee::Validated);
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
        match claim(&point).decide(point.damping()) {
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

/// The reference's c* is the truth for a whole column: points at all distances from it, more than a thousand
/// within 1e-10.
#[test]
fn ten_thousand_points_agree_with_the_reference_boundary() {
    let mut random = Random(8);
    let (mut points, mut near, mut undecided) = (0, 0, 0);
    for row in critical_points() {
        let claim = claim(&row.at(0.0));
        for i in 0..39 {
            let sign = if random.unit() < 0.5 { -1.0 } else { 1.0 };
            let distance = if i < 5 { random.log(1e-15, 1e-10) } else { random.log(1e-10, 1.0) };
            let c = (row.critical_c * (1.0 + sign * distance)).max(0.0);
            if (c - row.critical_c).abs() <= 4.0 * f64::EPSILON * row.critical_c {
                continue; // the reference is known to an ulp
            }
            points += 1;
            near += u32::from(i < 5);
            let decision = claim.decide(c);
            match decision {
                Decision::Absent => assert!(c > row.critical_c, "{row:?} {c}"),
                Decision::Present => {
                    assert!(c < row.critical_c, "{row:?} {c}");
                    // Landing speeds rise as c falls, so one check per column at the fastest orbit is enough.
                    if i == 38 {
                        let flow = witness::flow(&Oscillator::new(&Law::Stribeck, &row.at(c)), 1e-10);
                        assert!(matches!(flow.fate, Fate::Sticks(_) | Fate::TooCloseToCall), "{row:?} {c}");
                    }
                }
                Decision::Undecided => {
                    let close = (c - row.critical_c).abs() < 1e-11 * (row.gamma + row.beta * row.belt_speed);
                    let fast = c < claim.sticks_from;
                    assert!(close || fast, "{row:?} {c} {claim:?}");
                    undecided += 1;
                }
            }
        }
    }
    assert!(points >= 10_000 && near >= 1_000, "{points} {near}");
    assert!(undecided < points / 10, "{undecided}");
}

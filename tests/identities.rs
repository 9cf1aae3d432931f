//! Exact identities and asymptotic orders of the theory, on the real engines.

mod sample;

use std::f64::consts::PI;

use sample::{Random, Sample};
use slipmap::certify::{Decision, TESTS};
use slipmap::simulate::return_map::{Turn, turns_of};
use slipmap::simulate::{Fate, critical_damping, direct, flow};

/// Points whose first-order terms are small enough for the polar form.
fn moderate(count: u64) -> impl Iterator<Item = Sample> {
    (0..count).map(|i| {
        let mut random = Random(i.wrapping_mul(0x9e6c_63d0_876a_3f6b) + 1);
        Sample {
            epsilon: random.log(1e-3, 0.1),
            alpha: random.unit(),
            beta: 0.5 * random.unit(),
            gamma: 5.0 * random.unit(),
            belt_speed: random.log(0.1, 2.0),
            damping: 2.0 * random.unit(),
        }
    })
}

fn margin(sample: Sample) -> (f64, f64) {
    match turns_of(&sample.column(), &[sample.damping], 1e-13)[0] {
        Turn::Complete { margin, error, .. } => (margin, error),
        Turn::HandOver { .. } => panic!("outside the polar form: {sample:?}"),
    }
}

fn critical(sample: Sample) -> f64 {
    critical_damping(&sample.column(), 1e-15).map_or(f64::NAN, |critical| critical.c)
}

/// Rounding of the parameters themselves moves the margin by a few ulps of the divergence over a turn.
fn rounding(sample: Sample) -> f64 {
    64.0 * f64::EPSILON * sample.epsilon * (sample.gamma + sample.damping + 2.0 * sample.beta)
}

#[test]
fn scaling_leaves_verdicts_and_margins() {
    for (i, sample) in moderate(400).enumerate() {
        let scaled = sample.rescaled([0.125, 0.37, 3.0, 8.0][i % 4]);
        let ((m, error), (m_scaled, error_scaled)) = (margin(sample), margin(scaled));
        assert!((m - m_scaled).abs() <= error + error_scaled + rounding(sample), "{sample:?} {m} {m_scaled}");
        let (a, b) = (direct::flow(&sample.oscillator(), 1e-12), direct::flow(&scaled.oscillator(), 1e-12));
        assert!(!((a.margin - b.margin).abs() > a.margin_error + b.margin_error), "{sample:?} {a:?} {b:?}");
        for test in &TESTS {
            let l = sample.damping / scaled.damping.max(f64::MIN_POSITIVE);
            let (claim, claim_scaled) = ((test.claim)(&sample.column()), (test.claim)(&scaled.column()));
            let (edge, edge_scaled) = (claim.present_below, l * claim_scaled.present_below);
            // Bendixson's edge is a root, located to 1e-9 of the size of its terms.
            let ulps = if test.name == "bendixson" { 1e-8 } else { 64.0 * f64::EPSILON };
            let size = sample.gamma + 4.0 * sample.beta * sample.belt_speed;
            let equal = edge == edge_scaled || (edge - edge_scaled).abs() <= ulps * size;
            assert!(equal, "{} {sample:?} {edge} {edge_scaled}", test.name);
        }
    }
}

#[test]
fn only_the_scaled_groups_matter() {
    for sample in moderate(200) {
        // Another belt speed and eps with the same A, k, b, C.
        let factor = 1.7;
        let other = Sample {
            belt_speed: factor * sample.belt_speed,
            gamma: sample.gamma / factor,
            alpha: 1.0 - factor * (1.0 - sample.alpha),
            beta: sample.beta / factor,
            ..sample
        };
        // alpha below 0 is no legal point but the same oscillator.
        let ((m, error), (m_other, error_other)) = (margin(sample), margin(other));
        assert!((m - m_other).abs() <= error + error_other + 4.0 * rounding(sample), "{sample:?}");
    }
}

#[test]
fn margin_falls_with_damping_and_beta_and_alpha() {
    for sample in moderate(400) {
        let step = 0.01;
        for larger in [
            sample.at(sample.damping + step),
            Sample { beta: sample.beta + step, ..sample },
            Sample { alpha: sample.alpha + 0.5 * (1.0 - sample.alpha), ..sample },
        ] {
            let ((m, error), (m_larger, error_larger)) = (margin(sample), margin(larger));
            assert!(m_larger <= m + error + error_larger, "{sample:?} {larger:?}");
        }
    }
}

#[test]
fn coulomb_friction_alone_never_stick_slips() {
    for (i, sample) in moderate(300).enumerate() {
        let sample = if i % 2 == 0 {
            Sample { alpha: 1.0, beta: 0.0, ..sample }
        } else {
            Sample { gamma: 0.0, beta: 0.0, ..sample }
        };
        for damping in [0.0, sample.damping] {
            let sample = sample.at(damping);
            for test in &TESTS {
                assert_ne!(
                    (test.claim)(&sample.column()).decide(damping),
                    Decision::Present,
                    "{}",
                    test.name
                );
            }
            for answer in [flow(&sample.oscillator(), 1e-9), direct::flow(&sample.oscillator(), 1e-9)] {
                match answer.fate {
                    Fate::SpiralsInward => {}
                    // Without damping the orbit is a circle that grazes the belt at the exit point.
                    Fate::TooCloseToCall => assert!(damping == 0.0 || answer.margin.abs() < 1e-8),
                    Fate::Sticks(_) | Fate::CrossesForever | Fate::Failed(_) => {
                        panic!("{sample:?} {answer:?}")
                    }
                }
            }
        }
    }
}

#[test]
fn harmonic_balance_lies_above_critical_damping_for_small_k() {
    // Not for all k: see the next test.
    for sample in moderate(400).filter(|sample| sample.k() < 1.0 && sample.drop_rate() > 0.0) {
        let size = sample.drop_rate() + 2.0 * sample.beta * sample.belt_speed;
        assert!(critical(sample) <= sample.balance_edge() + 1e-13 * size, "{sample:?}");
        assert!(critical(sample) >= sample.divergence_edge() - 1e-13 * size, "{sample:?}");
    }
}

#[test]
fn harmonic_balance_is_no_bound_for_large_k() {
    // A counterexample to c* <= c_HB: at k = 56.7 the orbit still sticks at damping c_HB, with a margin that
    // both engines put 1e5 times above their errors.
    let sample = Sample {
        epsilon: 0.793_767_262_661_818_6,
        alpha: 0.326_587_324_988_081_4,
        beta: 0.0,
        gamma: 9.526_237_102_701_42,
        belt_speed: 7.494_859_277_790_09,
        damping: 0.0,
    };
    let sample = sample.at(sample.balance_edge() * (1.0 + 1e-10));
    for answer in [flow(&sample.oscillator(), 1e-10), direct::flow(&sample.oscillator(), 1e-10)] {
        assert!(matches!(answer.fate, Fate::Sticks(_)), "{answer:?}");
        assert!((answer.margin - 2.7406e-4).abs() < 1e-7 && answer.margin_error < 1e-8, "{answer:?}");
    }
}

/// Fits p in error ~ eps^p over halvings of eps and compares the last constant with `constant`.
fn assert_order(sample: Sample, p: f64, constant: f64, error: impl Fn(Sample) -> f64) {
    let ratio = |epsilon: f64| {
        let sample = Sample { epsilon, ..sample };
        error(sample) / (constant * epsilon.powf(p))
    };
    // The error is constant eps^p (1 + O(eps)): halving eps halves the distance of the ratio from 1.
    let distances: Vec<f64> = (0..4).map(|i| (ratio(0.02 / f64::from(1 << i)) - 1.0).abs()).collect();
    for pair in distances.windows(2) {
        let halving = pair[0] / pair[1];
        assert!((1.6..2.5).contains(&halving), "{sample:?} {distances:?}");
    }
}

#[test]
fn orders_in_eps() {
    let sample = Sample { epsilon: 0.1, alpha: 0.3, beta: 0.25, gamma: 1.6, belt_speed: 1.1, damping: 0.0 };
    let Sample { alpha, beta, gamma, belt_speed: v, .. } = sample;
    let drop = 1.0 - alpha;
    assert_order(sample, 1.0, -2.0 * gamma.powi(2) * drop * v, |s| critical(s) - s.first_order_edge());
    assert_order(sample, 2.0, 0.75 * gamma.powi(3) * drop * v * v, |s| critical(s) - s.divergence_edge());
    // The fourth-order constant of harmonic balance, whose own next order is the factor
    // (1 + eps gamma^2 drop / beta)^2 of scripts/theory_check.py.
    assert_order(sample, 4.0, 1.0, |s| {
        let next = (beta + s.epsilon * gamma.powi(2) * drop).powi(2);
        (critical(s) - s.balance_edge()) / (-13.0 / 48.0 * gamma.powi(3) * drop * v.powi(4) * next)
    });
}

#[test]
fn the_double_crossing_next_to_grazing_is_found() {
    let sample = Sample { epsilon: 1e-4, alpha: 0.5, beta: 0.2, gamma: 2.0, belt_speed: 1.0, damping: 0.1 };
    let kappa = sample.first_order_edge() - sample.damping;
    let root = (2.0 * PI * kappa * sample.epsilon).sqrt();
    for answer in [flow(&sample.oscillator(), 1e-10), direct::flow(&sample.oscillator(), 1e-10)] {
        let Fate::Sticks(landing) = answer.fate else { panic!("{answer:?}") };
        assert_eq!(landing.crossings, 0);
        let speed = landing.stick_time * sample.belt_speed;
        // First order of theory section 4; the next is smaller by sqrt(eps) = 0.01.
        assert!((speed / (sample.belt_speed * root) - 1.0).abs() < 0.02, "{answer:?}");
        assert!((landing.slip_time - (2.0 * PI - root)).abs() < 0.02 * root, "{answer:?}");
        assert!((landing.x1 - (sample.oscillator().exit_x1() - speed)).abs() < 1e-9, "{answer:?}");
    }
}

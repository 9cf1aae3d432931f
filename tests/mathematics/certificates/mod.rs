//! The closed-form tests compared with identities derived by hand and with the orbits of the witness, which share
//! no code with them. That they contradict no engine is part of the test over every engine.

use crate::sample::{Random, Sample};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use slipmap::certify::{Claim, Decision, Guarantee, TESTS, by_name, landing};
use slipmap::flow::{Fate, Landing};
use slipmap::witness::{Start, flow, trace};
use std::f64::consts::{PI, TAU};

impl Sample {
    fn claim(&self, test: &str) -> Claim {
        let Some(test) = by_name(test) else { panic!("no test is called {test}") };
        test.claim(&self.column())
    }

    fn decide(&self, test: &str) -> Decision {
        self.claim(test).decide(self.damping)
    }

    /// D(u), from the derivative of the law.
    fn divergence(&self, u: f64) -> f64 {
        let Self { epsilon, alpha, beta, gamma, damping, .. } = *self;
        let q = 1.0 + epsilon * gamma * u;
        epsilon * (gamma * (1.0 - alpha) / (q * q) - 2.0 * beta * u - damping)
    }

    /// Bound on the round-off of a threshold that is a difference of two terms, the larger of which are
    /// gamma (1 - alpha) and 4 beta V, each computed with at most 32 roundings of half a unit.
    fn threshold_error(&self) -> f64 {
        16.0 * f64::EPSILON * (self.drop_rate() + 4.0 * self.beta * self.belt_speed)
    }
}

/// eps in [1e-3, 1] and V in [0.1, 10] spread over their decades, the others evenly.
fn point(random: &mut Random) -> Sample {
    Sample {
        epsilon: 10f64.powf(-3.0 * random.unit()),
        belt_speed: 10f64.powf(2.0 * random.unit() - 1.0),
        alpha: random.unit(),
        beta: random.unit(),
        gamma: 10.0 * random.unit(),
        damping: 3.0 * random.unit(),
    }
}

fn points(seed: u64, count: usize) -> impl Iterator<Item = Sample> {
    let mut random = Random(seed);
    (0..count).map(move |_| point(&mut random))
}

/// Whether the orbit from the exit point sticks at once.
fn sticks(p: &Sample) -> bool {
    matches!(flow(&p.oscillator(), 1e-9).fate, Fate::Sticks(Landing { crossings: Some(0), .. }))
}

/// Bound on the error of x2 in units of V, far above that of the witness.
const ERROR: f64 = 1e-7;

/// What the samples of a trace, up to 0.1 rad apart, may miss of the largest -x2: 1 - cos 0.05 of it.
const MISSED: f64 = 1.3e-3;

/// The largest -x2 among the samples of the first turn.
fn amplitude(p: &Sample) -> f64 {
    let traced = trace(&p.oscillator(), Start::ExitPoint, 1e-9, 10.0);
    let turns = traced.samples.windows(2).find(|pair| pair[1].x2 > pair[0].x2);
    -turns.map_or(traced.samples[traced.samples.len() - 1], |pair| pair[0]).x2
}

/// Columns with a fast belt, where the orbit overshoots at small damping and sticks at larger.
#[test]
fn presence_begins_where_the_orbit_lands_on_the_stick_segment() {
    let mut random = Random(3);
    let mut lost = Vec::new();
    for _ in 0..10_000 {
        let base = Sample { belt_speed: 1.0 + 9.0 * random.unit(), ..point(&mut random) };
        let claim = base.claim("symmetric");
        let (from, to) = (claim.sticks_from, claim.present_below);
        if !(from > 0.0 && from < to) {
            continue;
        }
        for c in [0.0, 0.5 * from, from, 0.5 * (from + to), from + 0.999 * (to - from)] {
            let p = base.at(c);
            let sticks = sticks(&p);
            assert!(sticks || c < from, "{p:?}");
            for test in ["instability", "bendixson", "symmetric"] {
                let present = p.decide(test) == Decision::Present;
                assert!(sticks || !present, "{test} ignores the landing: {p:?}");
            }
        }
        // The true end of the stick segment, by bisection.
        let (mut low, mut high) = (0.0, from);
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if sticks(&base.at(middle)) { high = middle } else { low = middle }
        }
        lost.push((from - high) / to);
    }
    lost.sort_by(f64::total_cmp);
    let columns = lost.len();
    assert!(columns > 50, "only {columns} such columns");
    println!(
        "{columns} columns; share of [0, edge) lost to the landing bound: median {:.4}, 90 % {:.4}",
        lost[columns / 2],
        lost[columns * 9 / 10]
    );
}

#[test]
fn bounds_on_the_turn_hold_and_tighten() {
    let mut excess: [Vec<f64>; 4] = Default::default();
    let strips = [2, 8, 48, 96];
    for p in points(2, 1000) {
        let speed = match flow(&p.oscillator(), 1e-9).fate {
            Fate::Sticks(Landing { crossings: Some(0), stick_time, .. }) => p.belt_speed * stick_time,
            // It lands with this speed, or more.
            Fate::Sticks(_) | Fate::CrossesForever => 2.0,
            Fate::SpiralsInward | Fate::TooCloseToCall | Fate::Failed(_) => 0.0,
        };
        let least = amplitude(&p);
        // To first order the square of the landing speed is 2 V times the height above the belt line that the orbit
        // would reach.
        let squared_error = 2.0 * ERROR * p.belt_speed * p.belt_speed;
        let column = p.column();
        for (n, excess) in strips.into_iter().zip(&mut excess) {
            let amplitude = landing::amplitude_bounds([(&column, p.damping)], n)[0];
            assert!(amplitude >= least - ERROR * p.belt_speed, "{p:?} {n}: {amplitude} {least}");
            let bound = landing::speed_bound(&column, p.damping, n);
            assert!(bound * bound >= speed * speed - squared_error, "{p:?} {n}: {bound} {speed}");
            if p.decide("instability") == Decision::Present {
                excess.push(bound / speed - 1.0);
            }
        }
    }
    let medians = excess.map(|mut values| {
        values.sort_by(f64::total_cmp);
        (values[values.len() / 2], values[values.len() * 9 / 10])
    });
    for (n, (median, ninety)) in strips.iter().zip(medians) {
        println!("{n} strips a quarter: landing speed over by {median:.4} (median), {ninety:.4} (90 %)");
    }
    // First order in the width of the strips: twice the strips, half the excess. The next order is 1/48 of
    // it.
    let ratio = medians[2].0 / medians[3].0;
    assert!((ratio - 2.0).abs() < 0.1, "{ratio}");
}

/// At the edge of the claim of `bendixson`, the divergence is positive on [0, V + R] with the orbit's
/// amplitude R, and the edge is not far from where that ends.
#[test]
fn bendixson_claims_presence_by_positive_divergence() {
    let mut gaps = Vec::new();
    for p in points(8, 3000) {
        let edge = p.claim("bendixson").present_below;
        if edge <= 0.0 {
            continue;
        }
        let at = p.at(edge);
        let amplitude = amplitude(&at);
        assert!(
            amplitude >= p.belt_speed * (1.0 - MISSED),
            "positive divergence cannot shrink the orbit: {p:?}"
        );
        // The divergence of this law falls with u, and by no more than this per unit of u.
        let slope = p.epsilon * (2.0 * p.epsilon * p.gamma * p.gamma * (1.0 - p.alpha) + 2.0 * p.beta);
        let least = at.divergence(p.belt_speed + amplitude);
        let error = slope * ERROR * p.belt_speed + p.epsilon * p.threshold_error();
        assert!(least >= -error, "{p:?} at c = {edge}: {least:e}");
        gaps.push(least / (p.epsilon * edge));
    }
    assert!(gaps.len() > 500, "only {} columns have an edge", gaps.len());
    gaps.sort_by(f64::total_cmp);
    let [median, ninety] = [2, 10].map(|n| gaps[gaps.len() - gaps.len() / n]);
    println!("the divergence left at the edge, in parts of c: {median:e} (median), {ninety:e} (90 %)");
    assert!(median < 0.01 && ninety < 0.1, "{median:e} {ninety:e}");
}

/// Theory: `symmetric` decides more than nine points in ten.
#[test]
fn share_of_points_that_symmetric_decides() {
    let decided = points(5, 20_000).filter(|p| p.decide("symmetric") != Decision::Undecided).count();
    assert!(decided > 18_000, "{decided}");
}

fn any_point() -> impl Strategy<Value = Sample> {
    (-3.0..0.0, 0.0..=1.0, 0.0..=1.0, 0.0..=10.0, 0.0..3.0, -1.0..1.0).prop_map(
        |(e, alpha, beta, gamma, damping, v)| {
            let (epsilon, belt_speed) = (10f64.powf(e), 10f64.powf(v));
            Sample { epsilon, alpha, beta, gamma, belt_speed, damping }
        },
    )
}

proptest! {
    #![proptest_config(ProptestConfig {
        failure_persistence: Some(Box::new(FileFailurePersistence::WithSource("regressions"))),
        ..ProptestConfig::default()
    })]

    #[test]
    fn edges_are_ordered(p in any_point()) {
        let error = p.threshold_error();
        let edge = |test: &str| p.claim(test).present_below;
        let chain = ["bendixson", "instability", "harmonic_balance", "perturbation"].map(edge);
        prop_assert!(chain.windows(2).all(|pair| pair[0] <= pair[1] + error), "{chain:?}");
        prop_assert!(edge("bendixson") <= edge("bendixson_leading") + error);
        prop_assert!(edge("bendixson_leading") <= edge("perturbation") + error);
        // (14) is the presence edge of `symmetric`, to the last bit.
        prop_assert_eq!(edge("instability"), edge("symmetric"));
        // Absence: the critical damping is below both edges.
        let absence = ["harmonic_balance", "symmetric", "bendixson"].map(|test| p.claim(test).absent_above);
        prop_assert!(absence.windows(2).all(|pair| pair[0] <= pair[1] + error), "{absence:?}");
        prop_assert_eq!(edge("harmonic_balance"), absence[0]);
    }

    /// Scaling by a power of two commutes with rounding, so that claims scale to the last bit.
    #[test]
    fn claims_scale_exactly_with_powers_of_two(p in any_point(), power in -8i32..=8) {
        let l = 2f64.powi(power);
        let scaled = p.rescaled(l);
        for test in &TESTS {
            let (claim, expected) = (test.claim(&scaled.column()), test.claim(&p.column()));
            let expected = Claim {
                sticks_from: expected.sticks_from / l,
                present_below: expected.present_below / l,
                absent_above: expected.absent_above / l,
            };
            prop_assert_eq!(claim, expected, "{}", test.name);
        }
    }

    /// At fixed eps gamma (1 - alpha), eps gamma V and eps beta V the edges do not depend on V.
    #[test]
    fn edges_depend_on_the_scaled_groups_only(p in any_point(), numerator in 512u32..=1024) {
        let alpha = f64::from(numerator) / 1024.0;
        let p = Sample { alpha, ..p };
        let faster = Sample { belt_speed: 2.0 * p.belt_speed, gamma: 0.5 * p.gamma, beta: 0.5 * p.beta, ..p };
        // Twice the drop 1 - alpha, at half the rate gamma.
        let faster = Sample { alpha: 1.0 - 2.0 * (1.0 - alpha), ..faster };
        for test in &TESTS {
            let (slow, fast) = (test.claim(&p.column()), test.claim(&faster.column()));
            prop_assert_eq!(slow.present_below, fast.present_below, "{}", test.name);
            prop_assert_eq!(slow.absent_above, fast.absent_above, "{}", test.name);
        }
    }

    /// The closed form of the energy balance is its integral, by the trapezoidal rule, which converges
    /// geometrically on periodic analytic functions: here like exp(-4096 sqrt(2 / k)).
    #[test]
    fn harmonic_balance_is_the_mean_over_the_grazing_circle(p in any_point()) {
        const NODES: u32 = 4096;
        let undamped = p.at(0.0);
        let sum: f64 = (0..NODES)
            .map(|i| {
                let t = TAU * f64::from(i) / f64::from(NODES);
                undamped.divergence(p.belt_speed - p.belt_speed * t.cos()) * t.sin() * t.sin()
            })
            .sum();
        let mean = sum * TAU / f64::from(NODES) / PI / p.epsilon;
        let edge = p.claim("harmonic_balance").present_below;
        // The sum's round-off: at most one unit of its largest partial sum per term.
        let error = f64::from(NODES) * f64::EPSILON * (p.gamma * (1.0 - p.alpha) + 4.0 * p.beta * p.belt_speed);
        prop_assert!((mean - edge).abs() <= error, "{mean} {edge}");
    }

    /// Coulomb friction alone never sustains a cycle (paper, section 3), nor does any law that only
    /// strengthens.
    #[test]
    fn no_weakening_no_cycle(p in any_point(), by_alpha: bool) {
        let p = if by_alpha { Sample { alpha: 1.0, ..p } } else { Sample { gamma: 0.0, ..p } };
        for strengthening in [p, Sample { beta: 0.0, ..p }] {
            for c in [0.0, p.damping, 100.0] {
                let at = strengthening.at(c);
                for test in &TESTS {
                    let decision = at.decide(test.name);
                    prop_assert_ne!(decision, Decision::Present, "{}", test.name);
                    // With damping or strengthening every test that can deny a cycle does.
                    let denies = !["instability", "bendixson_leading"].contains(&test.name);
                    // `bendixson` needs D(0) < 0, which takes damping.
                    let dissipates = c > 0.0 || (at.beta > 0.0 && test.name != "bendixson");
                    if denies && dissipates {
                        prop_assert_eq!(decision, Decision::Absent, "{} {:?}", test.name, at);
                    }
                }
            }
        }
    }
}

/// Legal limits of the law, and sizes at which a careless formula cancels or overflows.
#[test]
fn degenerate_laws() {
    let base = Sample { epsilon: 0.1, alpha: 0.5, beta: 0.0, gamma: 2.0, belt_speed: 1.0, damping: 0.0 };
    // k -> 0: all finite-eps edges fall onto the first-order one, gamma (1 - alpha) = 1, to O(k).
    for v in [1e-6, 1e-9, 1e-12, 1e-300] {
        let p = Sample { belt_speed: v, ..base };
        let k = p.epsilon * p.gamma * v;
        for test in ["instability", "symmetric", "harmonic_balance", "perturbation", "bendixson"] {
            let edge = p.claim(test).present_below;
            // Slope in k of the fastest-falling edge: 2 (1 + R/V) with R/V < 1.2 at D <= 0.1; the
            // iteration of `bendixson` ends within 1e-9.
            assert!((edge - 1.0).abs() <= 4.4 * k + 2e-9, "{test} at V = {v}: {edge}");
        }
        // Undamped, weakening, slow: certainly present.
        for test in &TESTS {
            assert_eq!(p.decide(test.name), Decision::Present, "{} at V = {v}", test.name);
        }
    }
    // k -> infinity: the even part's minimum falls like k^-2, its maximum stays, the mean falls like k^-3/2.
    for v in [1e8, 1e12] {
        let p = Sample { belt_speed: v, ..base };
        let k = p.epsilon * p.gamma * v;
        let symmetric = p.claim("symmetric");
        let relative = |value: f64, limit: f64| (value / limit - 1.0).abs();
        assert!(relative(symmetric.present_below, k.powi(-2)) < 3.0 / k);
        assert!(relative(symmetric.absent_above, 0.5) < 1.0 / k);
        // 2 / (q (1 + k + q)) with q = sqrt(1 + 2 k): the next order is q / k relative.
        assert!(
            relative(p.claim("harmonic_balance").present_below, 2f64.sqrt() * k.powf(-1.5)) < 2.0 / k.sqrt()
        );
    }
    // Absurd numbers give no claim of presence and no panic.
    for p in [
        Sample { belt_speed: 1e200, ..base },
        Sample { gamma: 1e308, epsilon: 10.0, ..base },
        Sample { gamma: 1e200, belt_speed: 1e200, ..base },
        Sample { beta: 1e308, belt_speed: 1e10, ..base },
    ] {
        for test in TESTS.iter().filter(|test| test.guarantee == Guarantee::FiniteEpsilon) {
            assert_ne!(p.decide(test.name), Decision::Present, "{} {p:?}", test.name);
        }
    }
}

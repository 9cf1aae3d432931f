//! The closed-form tests compared with identities derived by hand and with an independent oracle: a plain
//! fixed-step integration of the slip flow, written here from the equations and sharing no code with the
//! crate.

mod oracle;

use crate::sample::{Random, Sample};
use proptest::prelude::*;
use proptest::test_runner::FileFailurePersistence;
use slipmap::certify::{Claim, Decision, Guarantee, TESTS, by_name, landing};
use std::f64::consts::{PI, TAU};
use std::sync::LazyLock;

impl Sample {
    fn claim(&self, test: &str) -> Claim {
        let Some(test) = by_name(test) else { panic!("no test is called {test}") };
        (test.claim)(&self.column())
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

use oracle::{Fate, STEPS_PER_TURN, Turn};

/// Random points with their turns, which several tests compare with what the closed forms say.
static TURNS: LazyLock<Vec<(Sample, Turn)>> =
    LazyLock::new(|| points(2, 4000).map(|p| (p, oracle::turn(&p, STEPS_PER_TURN))).collect());

/// Bound on the oracle's error in x2 at the end of a turn, in units of V. Measured by `the_oracle_converges`,
/// which leaves a factor of ten for points outside its sample.
const ORACLE_ERROR: f64 = 1e-7;

/// Bound on the oracle's error in the square of the landing speed, which is to first order 2 V times the
/// height above the belt line that the orbit would reach.
fn squared_speed_error(p: &Sample) -> f64 {
    2.0 * ORACLE_ERROR * p.belt_speed * p.belt_speed
}

/// Returns whether the oracle's fate is within its error of the grazing boundary or of the end of the stick
/// segment.
fn too_close(p: &Sample, fate: Fate) -> bool {
    let near = squared_speed_error(p);
    match fate {
        Fate::Inward(top) => p.belt_speed - top < ORACLE_ERROR * p.belt_speed,
        Fate::Sticks(w) | Fate::SticksFromAbove(w) | Fate::Crosses(w) => {
            w * w < near || (w * w - 4.0).abs() < near
        }
    }
}

#[test]
fn the_oracle_converges() {
    let mut worst = 0.0f64;
    for p in points(1, 400) {
        let [coarse, fine] = [1, 2].map(|refine| oracle::turn(&p, refine * STEPS_PER_TURN));
        let difference = match (coarse.fate, fine.fate) {
            (Fate::Inward(a), Fate::Inward(b)) => (a - b).abs() / p.belt_speed,
            (
                Fate::Sticks(a) | Fate::SticksFromAbove(a) | Fate::Crosses(a),
                Fate::Sticks(b) | Fate::SticksFromAbove(b) | Fate::Crosses(b),
            ) => (a * a - b * b).abs() / (2.0 * p.belt_speed * p.belt_speed),
            (a, b) => panic!("{p:?}: {a:?} {b:?}"),
        };
        worst = worst.max(difference).max((coarse.amplitude - fine.amplitude).abs() / p.belt_speed);
    }
    println!("oracle: largest difference on halving the step {worst:.1e}");
    assert!(worst < 0.1 * ORACLE_ERROR, "{worst}");
}

#[test]
fn certificates_are_never_contradicted() {
    let names: Vec<_> = TESTS
        .iter()
        .filter(|test| test.guarantee == Guarantee::FiniteEpsilon)
        .map(|test| test.name)
        .collect();
    assert_eq!(names, ["instability", "bendixson", "symmetric"]);
    let (mut decided, mut skipped, mut nodes) = ([[0u32; 2]; 3], 0, 0);
    for &(p, Turn { fate, .. }) in TURNS.iter() {
        if too_close(&p, fate) {
            skipped += 1;
            continue;
        }
        nodes += u32::from(p.divergence(0.0) >= 2.0);
        for (name, count) in names.iter().zip(&mut decided) {
            match p.decide(name) {
                Decision::Present => {
                    assert!(matches!(fate, Fate::Sticks(_)), "{name} claims a cycle: {p:?} {fate:?}");
                    count[0] += 1;
                }
                Decision::Absent => {
                    assert!(matches!(fate, Fate::Inward(_)), "{name} denies a cycle: {p:?} {fate:?}");
                    count[1] += 1;
                }
                Decision::Undecided => {}
            }
        }
    }
    println!("{skipped} points skipped, {nodes} with D(0) >= 2");
    for (name, [present, absent]) in names.iter().zip(decided) {
        println!("{name}: present {present}, absent {absent}");
        assert!(present > 100, "{name} was hardly tried");
    }
    assert!(decided[1][1] > 100 && decided[2][1] > 100 && nodes > 50);
    assert!(skipped < 10);
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
            let fate = oracle::turn(&p, STEPS_PER_TURN).fate;
            let sticks = matches!(fate, Fate::Sticks(_));
            assert!(sticks || c < from, "{p:?} {fate:?}");
            for test in ["instability", "bendixson", "symmetric"] {
                let present = p.decide(test) == Decision::Present;
                assert!(sticks || !present, "{test} ignores the landing: {p:?} {fate:?}");
            }
        }
        // The true end of the stick segment, by bisection with the oracle.
        let sticks = |c: f64| matches!(oracle::turn(&base.at(c), STEPS_PER_TURN).fate, Fate::Sticks(_));
        let (mut low, mut high) = (0.0, from);
        for _ in 0..12 {
            let middle = 0.5 * (low + high);
            if sticks(middle) { high = middle } else { low = middle }
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
    for (p, turn) in TURNS.iter() {
        let speed = match turn.fate {
            Fate::Inward(_) => 0.0,
            Fate::Sticks(w) | Fate::SticksFromAbove(w) | Fate::Crosses(w) => w,
        };
        let column = p.column();
        for (n, excess) in strips.into_iter().zip(&mut excess) {
            let amplitude = landing::amplitude_bounds([(&column, p.damping)], n)[0];
            assert!(
                amplitude >= turn.amplitude - ORACLE_ERROR * p.belt_speed,
                "{p:?} {n}: {amplitude} {}",
                turn.amplitude
            );
            let bound = landing::speed_bound(&column, p.damping, n);
            assert!(bound * bound >= speed * speed - squared_speed_error(p), "{p:?} {n}: {bound} {speed}");
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

/// At the edge of the claim of `bendixson`, the divergence is positive on [0, V + R] with the oracle's
/// amplitude R, and the edge is not far from where that ends.
#[test]
fn bendixson_claims_presence_where_the_divergence_is_positive_along_the_orbit() {
    let mut gaps = Vec::new();
    for p in points(8, 3000) {
        let edge = p.claim("bendixson").present_below;
        if edge <= 0.0 {
            continue;
        }
        let at = p.at(edge);
        let amplitude = oracle::turn(&at, STEPS_PER_TURN).amplitude;
        assert!(
            amplitude >= p.belt_speed * (1.0 - ORACLE_ERROR),
            "positive divergence cannot shrink the orbit: {p:?}"
        );
        // The divergence of this law falls with u, and by no more than this per unit of u.
        let slope = p.epsilon * (2.0 * p.epsilon * p.gamma * p.gamma * (1.0 - p.alpha) + 2.0 * p.beta);
        let least = at.divergence(p.belt_speed + amplitude);
        let error = slope * ORACLE_ERROR * p.belt_speed + p.epsilon * p.threshold_error();
        assert!(least >= -error, "{p:?} at c = {edge}: {least:e}");
        gaps.push(least / (p.epsilon * edge));
    }
    assert!(gaps.len() > 500, "only {} columns have an edge", gaps.len());
    gaps.sort_by(f64::total_cmp);
    let [median, ninety] = [2, 10].map(|n| gaps[gaps.len() - gaps.len() / n]);
    println!("the divergence left at the edge, in parts of c: {median:e} (median), {ninety:e} (90 %)");
    assert!(median < 0.01 && ninety < 0.1, "{median:e} {ninety:e}");
}

/// Theory: `symmetric` decides more than nine points in ten. The landing condition removes hardly more than
/// it must.
#[test]
fn share_of_points_that_symmetric_decides() {
    let total = 20_000;
    let (mut without, mut with, mut stick_unproved) = (0, 0, 0);
    for p in points(5, total) {
        let claim = p.claim("symmetric");
        let landing_ignored = Claim { sticks_from: f64::NEG_INFINITY, ..claim };
        let (bold, proved) = (landing_ignored.decide(p.damping), claim.decide(p.damping));
        without += usize::from(bold != Decision::Undecided);
        with += usize::from(proved != Decision::Undecided);
        if bold != proved {
            let fate = oracle::turn(&p, STEPS_PER_TURN).fate;
            stick_unproved += usize::from(matches!(fate, Fate::Sticks(_)));
        }
    }
    let share = |count: usize| count as f64 / total as f64;
    println!("symmetric decides {:.4}, without the landing condition {:.4}", share(with), share(without));
    println!("of the {} points between, {stick_unproved} stick at once", without - with);
    assert!(share(with) > 0.9);
}

/// The asymptotic tests compared with the oracle: the counts of their errors at finite eps, and that none of
/// them denies an orbit that returns, at these points. Above k = 15.62 harmonic balance may deny a cycle that
/// exists, see tests/mathematics/identities.rs.
#[test]
fn asymptotic_tests_err_only_where_the_theory_says() {
    let names = ["perturbation", "bendixson_leading", "harmonic_balance"];
    let (mut false_present, mut false_absent) = ([0u32; 3], [0u32; 3]);
    for &(p, Turn { fate, .. }) in TURNS.iter() {
        if too_close(&p, fate) {
            continue;
        }
        let sticks = matches!(fate, Fate::Sticks(_) | Fate::SticksFromAbove(_));
        let returns = !matches!(fate, Fate::Inward(_));
        for (i, name) in names.into_iter().enumerate() {
            match p.decide(name) {
                Decision::Present => false_present[i] += u32::from(!sticks),
                Decision::Absent => {
                    false_absent[i] += u32::from(sticks);
                    assert!(!returns, "{name} denies a return: {p:?} {fate:?}");
                }
                Decision::Undecided => {}
            }
        }
    }
    println!("{names:?}: false presence {false_present:?}, false absence {false_absent:?}");
    assert!(false_present[0] > 0, "the first-order test claims cycles that do not exist");
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
            let (claim, expected) = ((test.claim)(&scaled.column()), (test.claim)(&p.column()));
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
            let (slow, fast) = ((test.claim)(&p.column()), (test.claim)(&faster.column()));
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

//! Limits in eps: the thresholds that [`slipmap::column::limits`] proves, and the limits themselves, compared
//! with fine grids of eps and closed forms.

use crate::sample::{Random, Sample, Sampling};
use slipmap::certify::{self, Decision};
use slipmap::column::critical_damping;
use slipmap::column::limits::{EpsilonLimit, HIGHEST, LOWEST, ProvedThresholds, Ray};
use slipmap::column::{Method, Verdict};
use slipmap::filippov::Oscillator;
use slipmap::flow::Fate;
use slipmap::friction::Law;
use slipmap::orbits::flow;

const TOLERANCE: f64 = 1e-9;

fn method(name: &str) -> Method {
    Method::by_name(name).unwrap()
}

fn ray(sample: &Sample) -> Ray {
    Ray::new(&Law::Stribeck, &sample.point(), TOLERANCE)
}

/// Points of all kinds, and points between the edges of the energy balance and of the divergence, whose
/// verdict depends on eps.
fn samples(n: usize) -> Vec<Sample> {
    let mut random = Random(0x11e5);
    (0..n).map(|i| if i % 2 == 0 { random.anywhere() } else { random.near_boundary() }).collect()
}

#[test]
fn proofs_for_all_eps_hold_at_every_eps_tried() {
    let mut random = Random(5);
    let (mut present, mut absent) = (0, 0);
    for sample in samples(400) {
        let proved = ProvedThresholds::of(&Law::Stribeck, &sample.point());
        assert!(proved.present_below <= proved.absent_above, "{sample:?} {proved:?}");
        for _ in 0..10 {
            let here = Sample { epsilon: random.log(LOWEST, HIGHEST), ..sample };
            // The closed forms round: points next to them are left out.
            let clear = |edge: f64| (here.epsilon / edge - 1.0).abs() > 1e-9;
            if !clear(proved.present_below) || !clear(proved.absent_above) {
                continue;
            }
            let symmetric = certify::symmetric::TEST.claim(&here.column());
            let fate = flow(&here.oscillator(), TOLERANCE).fate;
            if here.epsilon < proved.present_below {
                // The same theorem, evaluated at this eps alone, and the flow.
                assert!(here.damping < symmetric.present_below, "{here:?} {proved:?}");
                assert!(matches!(fate, Fate::Sticks(_) | Fate::TooCloseToCall), "{here:?} {fate:?}");
                present += 1;
            } else if here.epsilon > proved.absent_above {
                assert_eq!(symmetric.decide(here.damping), Decision::Absent, "{here:?} {proved:?}");
                assert!(matches!(fate, Fate::SpiralsInward | Fate::TooCloseToCall), "{here:?} {fate:?}");
                absent += 1;
            }
        }
    }
    assert!(present > 300 && absent > 1000, "{present} {absent}");
}

#[test]
fn the_critical_damping_falls_with_eps() {
    // The assumption of the search between its nodes: one crossing of c = c*(eps), not three.
    let mut random = Random(8);
    for _ in 0..100 {
        let sample = random.anywhere();
        if sample.k() == 0.0 || sample.drop_rate() == 0.0 {
            continue; // c* does not depend on eps
        }
        let mut last = f64::INFINITY;
        for i in 0..12 {
            let epsilon = 1e-4 * 2e4_f64.powf(f64::from(i) / 11.0);
            let column = Sample { epsilon, ..sample }.column();
            let Ok(critical) = critical_damping(&column, 1e-12) else { continue };
            // At small eps it falls by 2 eps gamma^2 (1-alpha) V, less than round-off of c in the end.
            assert!(critical.c - critical.error <= last, "{epsilon} {sample:?} {critical:?} {last}");
            last = critical.c + critical.error;
        }
    }
}

/// The verdicts of the flow on a grid of eps; `None` where it has none.
fn by_grid(sample: &Sample, nodes: u32) -> Vec<(f64, Option<Verdict>)> {
    let grid = (0..=nodes).map(|i| LOWEST * (HIGHEST / LOWEST).powf(f64::from(i) / f64::from(nodes)));
    grid.map(|epsilon| {
        let truth = Verdict::from(&flow(&Sample { epsilon, ..*sample }.oscillator(), TOLERANCE).fate);
        (epsilon, Some(truth).filter(|truth| matches!(truth, Verdict::Present | Verdict::Absent)))
    })
    .collect()
}

#[test]
fn limits_agree_with_a_fine_grid_of_eps() {
    // A ratio of 1.034 between nodes, ten times finer than the search's own.
    const NODES: u32 = 480;
    let ratio = (HIGHEST / LOWEST).powf(1.0 / f64::from(NODES));
    let mut seen_at_once = 0;
    for sample in samples(30) {
        let ray = ray(&sample);
        let truth = by_grid(&sample, NODES);
        for test in &certify::TESTS {
            let method = Method::Test(test);
            let said = |epsilon: f64| {
                let here = Sample { epsilon, ..sample };
                Verdict::from(test.claim(&here.column()).decide(here.damping))
            };
            let limit = ray.limit(method).value();
            let parts = |(epsilon, truth): &&(f64, Option<Verdict>)| {
                truth.is_some_and(|truth| said(*epsilon) != truth)
            };
            let seen = truth.iter().find(parts).map_or(f64::INFINITY, |(epsilon, _)| *epsilon);
            // The verdicts do not differ on the grid before the limit; they differ at its first node beyond,
            // unless they agree again before that.
            let context = format!("{}: {limit:e} {seen:e} {sample:?}", test.name);
            assert!(limit <= seen, "{context}");
            if limit == 0.0 || limit >= HIGHEST {
                assert!(limit == 0.0 || seen == f64::INFINITY, "{context}");
                continue;
            }
            seen_at_once += u32::from(seen <= limit * ratio);
            // At the limit one of the two changes. Both may, closer to each other than can be resolved: the
            // energy balance is O(eps^4) from the flow.
            let changes =
                |says: &dyn Fn(f64) -> Verdict| says(limit * (1.0 - 1e-6)) != says(limit * (1.0 + 1e-6));
            let flow_says = |epsilon: f64| {
                let flow = flow(&Sample { epsilon, ..sample }.oscillator(), 1e-13);
                let absent = flow.margin < 0.0 || flow.fate == Fate::CrossesForever;
                if absent { Verdict::Absent } else { Verdict::Present }
            };
            assert!(changes(&said) || changes(&flow_says), "{context}");
        }
    }
    assert!(seen_at_once > 20, "{seen_at_once}");
}

#[test]
fn closed_forms_of_the_limits() {
    // The first-order test is right until c* falls below c; the margin vanishes there.
    let sample = Sample { epsilon: 1.0, alpha: 0.3, beta: 0.1, gamma: 2.0, belt_speed: 1.0, damping: 0.5 };
    let ray = ray(&sample);
    let EpsilonLimit::UpTo(epsilon) = ray.limit(method("perturbation")) else {
        panic!("it fails at eps = 1")
    };
    let here = Sample { epsilon, ..sample };
    // The bisection leaves an error of 1e-12 of eps; the error of the margin is far below its slope, about 1.
    assert!(flow(&here.oscillator(), 1e-13).margin.abs() < 1e-9);
    assert!((critical_damping(&here.column(), 1e-12).unwrap().c - sample.damping).abs() < 1e-9);
    // The leading order: the width 2 eps gamma^2 (1-alpha) V of the band equals kappa.
    let kappa = sample.drop_rate() - 2.0 * sample.beta * sample.belt_speed - sample.damping;
    let leading = kappa / (2.0 * sample.gamma * sample.drop_rate() * sample.belt_speed);
    assert!(epsilon > leading && epsilon < 2.0 * leading, "{epsilon} {leading}");

    // The divergence test claims presence until gamma (1-alpha)/(1 + eps gamma V)^2 = c + 2 beta V.
    let loss = sample.damping + 2.0 * sample.beta * sample.belt_speed;
    let edge = ((sample.drop_rate() / loss).sqrt() - 1.0) / (sample.gamma * sample.belt_speed);
    let EpsilonLimit::UpTo(limit) = ray.limit(method("instability")) else { panic!("it ends") };
    assert!((limit / edge - 1.0).abs() < 1e-11, "{limit} {edge}");
    assert_eq!(ray.limit(Method::Simulation), EpsilonLimit::Throughout);
}

#[test]
fn where_no_cycle_exists_at_any_eps() {
    // c above gamma (1-alpha) - 2 beta V: absent at every eps, which one-sided tests never claim.
    let sample = Sample { epsilon: 0.1, alpha: 0.5, beta: 0.1, gamma: 2.0, belt_speed: 1.0, damping: 0.9 };
    let ray = ray(&sample);
    assert_eq!(ray.steps(), (Verdict::Absent, &[][..]));
    for name in ["perturbation", "harmonic_balance", "symmetric"] {
        assert_eq!(ray.limit(method(name)), EpsilonLimit::Throughout, "{name}");
    }
    for name in ["instability", "bendixson_leading", "bendixson"] {
        assert_eq!(ray.limit(method(name)), EpsilonLimit::Never, "{name}");
    }
    // `bendixson` does from c = gamma (1-alpha) on.
    let limit = self::ray(&sample.at(1.1)).limit(method("bendixson"));
    assert_eq!(limit, EpsilonLimit::Throughout);
    // No weakening, no damping: every orbit is a circle, and all methods are undecided.
    let circle = Sample { alpha: 1.0, beta: 0.0, damping: 0.0, ..sample };
    assert_eq!(self::ray(&circle).steps(), (Verdict::Undecided, &[][..]));
}

/// Without damping nothing depends on eps where the law does not: limits are 0 or infinite.
#[test]
fn where_nothing_depends_on_eps() {
    let law = Law::Exponential;
    let point = law.point(1.0, &[0.5, 0.5, 0.0], 0.3, 0.0).unwrap();
    let ray = Ray::new(&law, &point, TOLERANCE);
    assert_eq!(ray.steps(), (Verdict::Present, &[][..]));
    for (name, limit) in [
        ("simulation", EpsilonLimit::Throughout),
        ("symmetric", EpsilonLimit::Throughout),
        ("perturbation", EpsilonLimit::Never),
    ] {
        assert_eq!(ray.limit(method(name)), limit, "{name}");
    }
}

#[test]
fn a_fast_belt_ends_the_limits_at_the_landing() {
    // The orbit lands beyond the stick segment, and crosses for ever, long before grazing.
    let sample = Sample { epsilon: 0.1, alpha: 0.0, beta: 0.0, gamma: 3.0, belt_speed: 20.0, damping: 0.0 };
    let ray = ray(&sample);
    let (first, changes) = ray.steps();
    assert_eq!(first, Verdict::Present);
    let (place, verdict) = changes[0];
    assert_eq!(verdict, Verdict::Absent);
    let fate = |epsilon: f64| {
        let here = Sample { epsilon, ..sample };
        flow(&Oscillator::new(&Law::Stribeck, &here.point()), TOLERANCE).fate
    };
    // The landing is located to the tolerance: 1e-6 to either side is certain.
    assert!(matches!(fate(place * (1.0 - 1e-6)), Fate::Sticks(_)), "{:?}", fate(place * (1.0 - 1e-6)));
    assert_eq!(fate(place * (1.0 + 1e-6)), Fate::CrossesForever);
    for name in ["perturbation", "harmonic_balance", "bendixson_leading"] {
        assert_eq!(ray.limit(method(name)), EpsilonLimit::UpTo(place), "{name}");
    }
    // The theorems check the landing: they are undecided before it.
    for name in ["instability", "symmetric"] {
        let limit = ray.limit(method(name));
        let EpsilonLimit::UpTo(silent) = limit else { panic!("{name} {limit:?}") };
        assert!(silent < place, "{name} {limit:?} {place}");
    }
    assert!(ray.nearest_change(place * 1.01) == Some(place));
}

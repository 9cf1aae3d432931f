//! One regression test for each mechanism by which a naive method fails (theory, "Where methods fail"): it fails,
//! and the crate's method does not. Where the first-order test fails is in `claims`, where orbits overshoot the belt
//! in `limits`; nodes and exact grazing are among the orbits of `agreement` and `direct`.

use crate::runge_kutta::step;
use crate::sample::returns;
use std::f64::consts::TAU;

use slipmap::certify;
use slipmap::column::{Verdict, critical_damping};
use slipmap::filippov::Oscillator;
use slipmap::flow::{Fate, Landing};
use slipmap::friction::{Column, Law};
use slipmap::orbits::flow;
use slipmap::orbits::naive::{NaiveKnobs, NaiveMethod, NaiveVerdict};
use slipmap::point::Point;
use slipmap::study::failures::creep_width;
use slipmap::witness;

const TOLERANCE: f64 = 1e-9;

fn point(epsilon: f64, law: [f64; 3], belt_speed: f64, damping: f64) -> Point {
    Law::Stribeck.point(epsilon, &law, belt_speed, damping).unwrap()
}

fn oscillator(point: &Point) -> Oscillator {
    Oscillator::new(&Law::Stribeck, point)
}

fn column(point: &Point) -> Column {
    Law::Stribeck.column(point)
}

/// The verdict on which both engines agree.
fn truth(oscillator: &Oscillator) -> Verdict {
    let [map, direct] = [flow(oscillator, TOLERANCE), witness::flow(oscillator, TOLERANCE)]
        .map(|flow| Verdict::from(&flow.fate));
    assert_eq!(map, direct, "{oscillator:?}");
    map
}

fn landing(oscillator: &Oscillator) -> Landing {
    match flow(oscillator, 1e-12).fate {
        Fate::Sticks(landing) => landing,
        fate => panic!("{fate:?} {oscillator:?}"),
    }
}

fn naive(method: NaiveMethod, oscillator: &Oscillator, knobs: NaiveKnobs) -> Verdict {
    method.decide(oscillator, &knobs).verdict.into()
}

fn test(name: &str, point: &Point) -> Verdict {
    let test = certify::by_name(name).unwrap();
    test.claim(&column(point)).decide(point.damping).into()
}

/// Every theorem that decides agrees with the truth.
fn theorems_hold(point: &Point) {
    let truth = truth(&oscillator(point));
    for name in ["instability", "bendixson", "symmetric"] {
        let said = test(name, point);
        assert!(said == truth || said == Verdict::Undecided, "{name} {said:?} {point:?}");
    }
}

#[test]
fn missed_double_crossing() {
    // kappa = -c + gamma (1-alpha) - 2 beta V = 0.5 at eps = 1e-4: the orbit is above the belt line for about
    // 2 sqrt(2 pi kappa eps) = 0.035, far less than a step of order 8, however tight its tolerance.
    let (epsilon, kappa) = (1e-4, 0.5);
    let oscillator = oscillator(&point(epsilon, [0.5, 0.1, 2.0], 1.0, 0.3));
    let approach = (TAU * kappa * epsilon).sqrt();
    let returns_in_time = |oscillator: &Oscillator, knobs: NaiveKnobs| {
        let verdict = NaiveMethod::EventStep.decide(oscillator, &knobs).verdict;
        matches!(verdict, NaiveVerdict::Sticks { slip_time, .. } if slip_time < TAU)
    };
    // Whether a step ends above the belt line depends on chance: 40 neighbouring dampings.
    let missed = |tolerance: f64| {
        let knobs = NaiveKnobs { tolerance, ..NaiveKnobs::default() };
        let at = |i: u32| point(epsilon, [0.5, 0.1, 2.0], 1.0, 0.3 + 1e-3 * f64::from(i));
        (0..40).filter(|&i| !returns_in_time(&self::oscillator(&at(i)), knobs)).count()
    };
    let (loose, tight) = (missed(1e-8), missed(1e-12));
    assert!(loose > 20 && tight > 0, "{loose} {tight}");
    // Shorter steps detect it, so there is no other cause.
    let knobs = NaiveKnobs { longest_step: 0.25 * approach, ..NaiveKnobs::default() };
    assert!(returns_in_time(&oscillator, knobs));
    // The crate's engines return after 2 pi - sqrt(2 pi kappa eps), up to O(eps).
    assert_eq!(truth(&oscillator), Verdict::Present);
    let slip_time = landing(&oscillator).slip_time;
    assert!((slip_time - (TAU - approach)).abs() < 5.0 * epsilon, "{slip_time}");
}

#[test]
fn start_at_a_tangency() {
    // Without a pause the start itself is an event, which the method misinterprets as sticking.
    let inward = point(0.1, [0.3, 0.1, 2.0], 1.0, 1.3);
    let eager = NaiveKnobs { start_pause: 0.0, ..NaiveKnobs::default() };
    let found = NaiveMethod::EventStep.decide(&oscillator(&inward), &eager).verdict;
    assert_eq!(found, NaiveVerdict::Sticks { slip_time: 0.0, period: Some(0.0) });
    assert_eq!(truth(&oscillator(&inward)), Verdict::Absent);
    theorems_hold(&inward);
    // With a pause the method ignores events after every start on the belt line: on a fast belt the arc above
    // the belt line is shorter than the pause, and its end is missed.
    let above = point(0.1, [0.3, 0.0, 8.0], 2.0, 0.0);
    let arc = landing(&oscillator(&above));
    assert_eq!(arc.crossings, Some(1));
    let blind = naive(NaiveMethod::EventStep, &oscillator(&above), NaiveKnobs::default());
    assert_ne!(blind, Verdict::Present);
    let brief = NaiveKnobs { start_pause: 1e-9, ..NaiveKnobs::default() };
    assert_eq!(naive(NaiveMethod::EventStep, &oscillator(&above), brief), Verdict::Present);
    assert_eq!(truth(&oscillator(&above)), Verdict::Present);
}

/// The damping at which a method's verdict changes from present, at `low`, to another one.
fn edge(column: &Column, mut low: f64, mut high: f64, decide: impl Fn(&Oscillator) -> Verdict) -> f64 {
    let present = |c: f64| decide(&Oscillator::in_column(column, c)) == Verdict::Present;
    assert!(present(low) && !present(high));
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        *(if present(middle) { &mut low } else { &mut high }) = middle;
    }
    0.5 * (low + high)
}

#[test]
fn smoothed_sign() {
    // tanh(x/d) moves the boundary by O(d): ten times the width, ten times the error.
    let column = column(&point(0.05, [0.3, 0.1, 2.0], 1.0, 0.0));
    let critical = critical_damping(&column, 1e-12).unwrap().c;
    let [wide, narrow] = [1e-2, 1e-3].map(|smoothing_width| {
        let knobs = NaiveKnobs { smoothing_width, turns: 400, tolerance: 1e-9, ..NaiveKnobs::default() };
        let decide = |oscillator: &Oscillator| naive(NaiveMethod::Smoothed, oscillator, knobs);
        edge(&column, 0.5 * critical, 2.0 * critical, decide) - critical
    });
    // Here the method misses cycles: a mass that slips along the belt within the width is released early.
    assert!(narrow < 0.0 && (5.0..20.0).contains(&(wide / narrow)), "{wide} {narrow}");
    // Between the two boundaries the method is wrong, and the crate's engines are right.
    let between = Oscillator::in_column(&column, critical + 0.5 * narrow);
    let knobs = NaiveKnobs { turns: 400, tolerance: 1e-9, ..NaiveKnobs::default() };
    assert_eq!(naive(NaiveMethod::Smoothed, &between, knobs), Verdict::Absent);
    assert_eq!(truth(&between), Verdict::Present);
    let ours = edge(&column, 0.5 * critical, 2.0 * critical, truth_of_margin);
    assert!((ours - critical).abs() < 1e-9, "{ours} {critical}");
}

/// Smoothed friction creeps at u, tanh(u/d) phi(u) = f, where the belt asks for the share f of the friction at rest, and so
/// takes longer over the stick segment. The lag of the mass changes f by d V/(1 - f^2), and so u/d by that over 1 - f^2.
#[test]
fn smoothed_friction_creeps() {
    for (law, speed) in [([0.3, 0.0, 0.5], 0.4), ([0.8, 0.1, 2.0], 0.1)] {
        let oscillator = oscillator(&point(0.3, law, speed, 0.2));
        let Oscillator { curve, viscous, belt_speed } = &oscillator;
        let width = creep_width(curve, *belt_speed).unwrap();
        let share = |[x1, x2]: [f64; 2]| x1 + viscous * x2;
        let field = |[x1, x2]: [f64; 2]| {
            let s = x2 - belt_speed;
            [x2, -share([x1, x2]) - (s / width).tanh() * curve.phi(s.abs())]
        };
        let h = 0.02 * width;
        let (mut state, mut time) = ([-viscous * belt_speed, *belt_speed], 0.0);
        let mut to = |until: f64| {
            while share(state) < until {
                state = step(&field, state, h);
                time += h;
            }
            (state, time)
        };
        let lag = |f: f64| width * belt_speed / (1.0 - f * f).powi(2);
        let at_half = to(0.5);
        let creep = (belt_speed - at_half.0[1]) / belt_speed;
        assert!((creep / 0.01 - 1.0).abs() < 2.0 * lag(0.5) / 0.5_f64.atanh(), "{creep}");
        // On to f = 0.8 by the integral of artanh f. In the next order the mass lags, is slower, friction weakens and the
        // damper is relieved.
        let integral = |f: f64| f * f.atanh() + 0.5 * (1.0 - f * f).ln();
        let late = |(state, time): ([f64; 2], f64)| time - share(state) / belt_speed;
        let longer = late(to(0.8)) - late(at_half);
        let first = width / belt_speed.powi(2) * (integral(0.8) - integral(0.5));
        let slower = width / belt_speed * 0.8_f64.atanh();
        let next = lag(0.8) + slower * (1.0 + curve.weakening(0.0) * belt_speed) + viscous * belt_speed;
        assert!((longer / first - 1.0).abs() < 2.0 * next, "{longer} {first} {next}");
    }
}

/// With fine settings the periods that the methods tell are that of the cycle.
#[test]
fn naive_methods_tell_the_period() {
    let oscillator = oscillator(&point(0.3, [0.3, 0.1, 2.0], 0.5, 0.2));
    let Landing { slip_time, stick_time, .. } = landing(&oscillator);
    let fine = NaiveKnobs {
        smoothing_width: 1e-5,
        stick_band_width: 1e-5,
        step: 1e-4,
        turns: 3,
        start_pause: 1e-3,
        ..NaiveKnobs::default()
    };
    for method in NaiveMethod::ALL {
        let said = method.decide(&oscillator, &fine).verdict;
        let NaiveVerdict::Sticks { period: Some(period), .. } = said else { panic!("{method:?} {said:?}") };
        assert!(
            (period - slip_time - stick_time).abs() < 1e-3,
            "{method:?} {period} {slip_time} {stick_time}"
        );
    }
}

/// Whether the orbit returns, by the margin's sign where it is too close to call.
fn truth_of_margin(oscillator: &Oscillator) -> Verdict {
    let answer = flow(oscillator, TOLERANCE);
    if returns(&answer.fate).unwrap_or(answer.margin > 0.0) { Verdict::Present } else { Verdict::Absent }
}

#[test]
fn fixed_steps_blur_the_boundary() {
    // Verdicts along a column change once, from present to absent. Those of fixed steps change back and
    // forth.
    let column = column(&point(0.01, [0.3, 0.1, 2.0], 1.0, 0.0));
    let critical = critical_damping(&column, 1e-12).unwrap().c;
    let cs: Vec<f64> = (0..400).map(|i| critical + ((f64::from(i) + 0.5) / 400.0 - 0.5) * 2e-2).collect();
    let changes = |decide: &dyn Fn(&Oscillator) -> Verdict| {
        let said: Vec<Verdict> = cs.iter().map(|&c| decide(&Oscillator::in_column(&column, c))).collect();
        said.windows(2).filter(|pair| pair[0] != pair[1]).count()
    };
    let fixed = changes(&|oscillator| naive(NaiveMethod::FixedStep, oscillator, NaiveKnobs::default()));
    assert!(fixed > 1, "{fixed}");
    assert_eq!(changes(&truth), 1);
}

#[test]
fn a_stick_band_is_jumped_over() {
    // With a narrow band and unlimited steps the orbit passes both sides of the band within one step.
    let knobs = NaiveKnobs { stick_band_width: 1e-6, ..NaiveKnobs::default() };
    let mut wrong = 0;
    for i in 0..100 {
        let point = point(1e-4, [0.5, 0.1, 2.0], 1.0, 0.3 + 1e-3 * f64::from(i));
        let oscillator = oscillator(&point);
        assert_eq!(truth(&oscillator), Verdict::Present);
        wrong += u32::from(naive(NaiveMethod::StickBand, &oscillator, knobs) != Verdict::Present);
    }
    assert!(wrong > 0);
}

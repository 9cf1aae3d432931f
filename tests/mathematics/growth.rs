//! How fast unstable steady slip is left, by the witness and by the closed form of a machine.

use slipmap::behaviour::growth_time;
use slipmap::filippov::{Eigenvalues, Oscillator, Stability};
use slipmap::friction::Law;
use slipmap::machine::{Machine, Motion};
use slipmap::witness::{Start, trace};

use crate::sample::{Random, at_one};

/// The logarithm of the growth of a disturbance of size `a` after the time `t`. It starts along x1 where
/// disturbances turn and along the fast direction (1, rate) where they do not.
fn grown(oscillator: &Oscillator, rate: f64, turns: bool, a: f64, t: f64) -> f64 {
    let steady = oscillator.equilibrium_x1();
    let [x1, x2] = [a, if turns { 0.0 } else { a * rate }];
    let orbit = trace(oscillator, Start::State { x1: steady + x1, x2 }, 1e-13, t);
    let end = orbit.samples.last().unwrap();
    assert!((end.t - t).abs() < 1e-12 * t, "{end:?} {t}");
    ((end.x1 - steady) / a).ln()
}

#[test]
fn disturbances_grow_at_the_rate_of_the_eigenvalue() {
    let mut random = Random(11);
    let (mut turning, mut not) = (0, 0);
    let mut between = |low: f64, high: f64| low + (high - low) * random.unit();
    for i in 0..60 {
        // Of steep laws steady slip is a node on slow belts.
        let width = if i % 2 == 0 { between(0.1, 1.0) } else { between(0.02, 0.15) };
        let law = [between(0.1, 0.9), width, 0.0];
        let (speed, damping) = (between(0.2, 1.0) * width, between(0.0, 0.5));
        let oscillator = at_one(&Law::Exponential, &law, speed, damping);
        let time = growth_time(&oscillator);
        assert_eq!(time.is_some(), oscillator.stability() == Stability::Repels);
        let Some(time) = time else { continue };
        let (turns, after) = match oscillator.eigenvalues() {
            // After a whole turn of the linear flow the disturbance has its first direction again.
            Eigenvalues::Complex { im, .. } => (true, std::f64::consts::TAU / im),
            Eigenvalues::Real { .. } => (false, time),
        };
        // Long turns grow beyond what is linear.
        if after > 4.0 * time {
            continue;
        }
        *(if turns { &mut turning } else { &mut not }) += 1;
        let a = 1e-4 * speed.min(law[1]) * (-after / time).exp();
        let of = |a: f64| grown(&oscillator, time.recip(), turns, a, after);
        // What is not linear is of the first order in a; the rest is of its square, and the error of the
        // witness, 1e-13 on the way, over a.
        let found = 2.0 * of(0.5 * a) - of(a);
        let tolerance = 1e-7 + 1e-11 / a;
        assert!((found - after / time).abs() < tolerance, "{found} {} {a} {oscillator:?}", after / time);
    }
    assert!(turning > 15 && not > 5, "{turning} {not}");
}

#[test]
fn growth_time_is_twice_the_mass_over_the_feeding() {
    // m x'' = (N (mus - muk)/vs exp(-v/vs) - d) x' - k x about steady slip.
    let [mass, damping, normal, rest, kinetic, width, speed] = [0.4, 20.0, 200.0, 0.6, 0.35, 0.05, 0.15];
    for motion in [Motion::Translation, Motion::Rotation] {
        let numbers = [mass, 3e5, damping, normal, rest, kinetic, width, 0.0, speed];
        let model = Machine::from_array(motion, Law::Exponential, numbers).model().unwrap();
        let feeds = normal * (rest - kinetic) / width * (-speed / width).exp() - damping;
        let time = slipmap::behaviour::behaviour(&model, 1e-9).growth_time.unwrap();
        let expected = 2.0 * mass / feeds;
        // Of differences between numbers some times as large.
        assert!((time / expected - 1.0).abs() < 1e-12, "{time} {expected}");
    }
}

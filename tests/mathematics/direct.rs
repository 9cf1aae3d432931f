//! The direct engine against exact solutions, identities of the theory and slow references.

mod oracle;

use oracle::{Outcome, bisect};
use slipmap::filippov::{Oscillator, Side};
use slipmap::friction::Law;
use slipmap::point::{LawParameters, Point};
use slipmap::simulate::direct::{Ending, Phase, Sample, Start, Trace, flow, trace};
use slipmap::simulate::{Failure, Fate, Flow, Landing};
use std::f64::consts::{PI, TAU};

/// epsilon, alpha, beta, gamma, V, c.
type Six = [f64; 6];

fn oscillator([epsilon, alpha, beta, gamma, belt_speed, damping]: Six) -> Oscillator {
    let law = LawParameters::new(&[alpha, beta, gamma]);
    Oscillator::new(Law::Stribeck, &Point { epsilon, law, belt_speed, damping })
}

/// Dry friction of constant size, with the given coefficient of viscous damping: a linear oscillator on
/// each side of the belt line, of divergence -`viscous`. Negative damping makes orbits grow.
fn coulomb(viscous: f64, belt_speed: f64) -> Oscillator {
    Oscillator { viscous, ..oscillator([1.0, 1.0, 0.0, 0.0, belt_speed, 0.0]) }
}

/// A reproducible stream of points (SplitMix64).
struct Stream(u64);

impl Stream {
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ (z >> 31)) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn log(&mut self, lo: f64, hi: f64) -> f64 {
        lo * (hi / lo).powf(self.unit())
    }

    /// eps in [1e-3, 1], V in [0.1, 10], gamma up to 10, c up to 3, and every limit of the law often.
    fn point(&mut self) -> Six {
        let mut point = [
            self.log(1e-3, 1.0),
            self.unit(),
            self.unit(),
            10.0 * self.unit(),
            self.log(0.1, 10.0),
            3.0 * self.unit(),
        ];
        for (axis, limit) in [(1, 0.0), (1, 1.0), (2, 0.0), (3, 0.0), (5, 0.0)] {
            if self.unit() < 0.08 {
                point[axis] = limit;
            }
        }
        point
    }

    /// Fast belts and strong weakening (A = eps gamma, k = eps gamma V up to 10): many orbits overshoot.
    fn overshooting_point(&mut self) -> Six {
        let belt_speed = self.log(3.0, 300.0);
        let k = self.log(0.03, 10.0);
        let viscous = if self.unit() < 0.3 { 0.0 } else { 0.5 * self.unit() * k / belt_speed };
        [1.0, 0.3 * self.unit(), 0.0, k / belt_speed, belt_speed, viscous]
    }
}

fn landing(answer: &Flow) -> Landing {
    match answer.fate {
        Fate::Sticks(landing) => landing,
        fate => panic!("it does not stick: {fate:?}"),
    }
}

// ---------------------------------------------------------------- exact solutions

/// v = x2 and w = x2' after a time `t` of v'' + `viscous` v' + v = 0, `viscous` < 2.
fn linear(viscous: f64, [v, w]: [f64; 2], t: f64) -> [f64; 2] {
    let half = 0.5 * viscous;
    let omega = (1.0 - half * half).sqrt();
    let (sin, cos) = (omega * t).sin_cos();
    let decay = (-half * t).exp();
    let rate = (w + half * v) / omega;
    let across = -half * rate - omega * v;
    [decay * (v * cos + rate * sin), decay * (w * cos + across * sin)]
}

/// After one turn of 2 pi / omega the linear orbit is back at the same angle, scaled by
/// exp(-pi viscous / omega).
fn linear_margin(viscous: f64) -> f64 {
    (-PI * viscous / (1.0 - 0.25 * viscous * viscous).sqrt()).exp_m1()
}

#[test]
fn coulomb_friction_with_damping_has_the_closed_margin() {
    for belt_speed in [0.1, 1.0, 7.3] {
        for viscous in [1e-9, 1e-6, 1e-3, 0.1, 0.7, 1.5, 1.9] {
            for tolerance in [1e-6, 1e-9, 1e-12, 1e-13] {
                let answer = flow(&coulomb(viscous, belt_speed), tolerance);
                let error = (answer.margin - linear_margin(viscous)).abs();
                let context = format!("V {belt_speed}, C {viscous}, tolerance {tolerance}: {answer:?}");
                assert!(error <= answer.margin_error, "error {error:e}, {context}");
                // The tolerance, or the rounding errors, about 3e-14 max(1, 1/V): both per 2 pi of time.
                let turns = 1.0 / (1.0 - 0.25 * viscous * viscous).sqrt();
                let floor = 3e-14 * (1.0 / belt_speed).max(1.0);
                assert!(answer.margin_error <= turns * (tolerance + floor), "{context}");
                let expected = match answer.margin {
                    margin if margin < -answer.margin_error => Fate::SpiralsInward,
                    _ => Fate::TooCloseToCall,
                };
                assert_eq!(answer.fate, expected, "{context}");
            }
        }
    }
}

#[test]
fn coulomb_friction_alone_grazes_exactly_and_is_not_called() {
    // No cycle for constant friction: the orbit from the exit point is a circle that touches the line.
    for belt_speed in [0.1, 0.5, 1.0, 3.0, 10.0] {
        for tolerance in [1e-6, 1e-9, 1e-12] {
            let answer = flow(&coulomb(0.0, belt_speed), tolerance);
            assert_eq!(answer.fate, Fate::TooCloseToCall, "{answer:?}");
            assert!(answer.margin.abs() <= answer.margin_error);
            let floor = 3e-14 * (1.0 / belt_speed).max(1.0);
            assert!(answer.margin_error <= tolerance + floor, "{answer:?}");
        }
    }
}

#[test]
fn overdamped_orbits_creep_into_the_equilibrium() {
    for viscous in [2.0, 2.0 + 1e-9, 3.0, 10.0, 1000.0, 1e6] {
        for belt_speed in [0.1, 1.0, 10.0] {
            let answer = flow(&coulomb(viscous, belt_speed), 1e-9);
            assert_eq!((answer.fate, answer.margin), (Fate::SpiralsInward, -1.0), "{answer:?}");
            assert!(answer.margin_error <= 1e-9);
        }
    }
    // Just below critical damping the turn takes 2 pi / omega = 1e5 and nothing is left of the orbit.
    let answer = flow(&coulomb(2.0 - 1e-9, 1.0), 1e-9);
    assert_eq!(answer.fate, Fate::SpiralsInward);
    assert!((answer.margin + 1.0).abs() <= answer.margin_error && answer.margin_error < 1e-8);
}

/// Coulomb friction with negative damping: the orbit grows by a known factor, lands, and if the belt is
/// fast enough crosses.
#[test]
fn growing_linear_orbits_land_cross_and_return_as_they_must() {
    let mut seen = [0; 3];
    for viscous in [-1e-3, -0.01, -0.03, -0.05, -0.1, -0.3] {
        for belt_speed in [0.2, 1.0, 5.0, 10.0, 20.0, 50.0, 200.0] {
            let oscillator = coulomb(viscous, belt_speed);
            let answer = flow(&oscillator, 1e-12);
            let margin = linear_margin(viscous);
            if margin < 0.1 {
                let error = (answer.margin - margin).abs();
                assert!(error <= answer.margin_error && answer.margin_error < 2e-12, "{answer:?}");
            } else {
                assert!(answer.margin.is_nan(), "{answer:?}");
            }
            // On its way up the orbit meets the line in the last quarter turn.
            let omega = (1.0 - 0.25 * viscous * viscous).sqrt();
            let at = |t: f64| linear(viscous, [belt_speed, 0.0], t);
            let quarter = 0.25 * TAU / omega;
            let slip_time = 3.0 * quarter + bisect(quarter, |t| at(3.0 * quarter + t)[0] < belt_speed);
            let speed = at(slip_time)[1];
            // The time of landing has the error of x2 over the speed; V of it becomes x1.
            let accuracy = 1e-11 * belt_speed * (1.0 + belt_speed / speed);
            let context = format!("C {viscous}, V {belt_speed}: {answer:?}, landing speed {speed}");
            if speed < 2.0 {
                seen[0] += 1;
                let landing = landing(&answer);
                assert_eq!(landing.crossings, 0, "{context}");
                assert!((landing.slip_time - slip_time).abs() < accuracy, "{context}");
                assert!((landing.x1 - (oscillator.exit_x1() - speed)).abs() < accuracy, "{context}");
                assert!((landing.stick_time - speed / belt_speed).abs() < accuracy, "{context}");
                continue;
            }
            // Above the line v'' + C v' + v = 0 as well, with w less by 2.
            let up = |t: f64| linear(viscous, [belt_speed, speed - 2.0], t);
            let top = bisect(quarter, |t| up(t)[1] > 0.0);
            let arc = top + bisect(2.0 * quarter, |t| up(top + t)[0] > belt_speed);
            let back = up(arc)[1];
            if back > -2.0 {
                seen[1] += 1;
                let landing = landing(&answer);
                assert_eq!(landing.crossings, 1, "{context}");
                assert!((landing.slip_time - slip_time - arc).abs() < 2.0 * accuracy, "{context}");
                let x1 = oscillator.exit_x1() - 2.0 - back;
                assert!((landing.x1 - x1).abs() < 2.0 * accuracy, "{context}, expected {x1}");
            } else {
                seen[2] += 1;
                assert_eq!(answer.fate, Fate::CrossesForever, "{context}");
            }
        }
    }
    assert!(seen.iter().all(|&n| n >= 3), "sticks, sticks from above, crosses: {seen:?}");
}

/// Points at which a trace meets or leaves the belt line.
fn contacts(trace: &Trace, belt_speed: f64) -> Vec<Sample> {
    trace.samples.iter().copied().filter(|sample| sample.x2 == belt_speed).collect()
}

#[test]
fn dry_friction_alone_shrinks_crossing_orbits_by_four() {
    // Circles about x1 = 1 below and x1 = -1 above the line: x1 = 1 + a goes to 1 - a, then to a - 3.
    for belt_speed in [0.3, 1.0, 8.0] {
        let oscillator = coulomb(0.0, belt_speed);
        let start = Start::State { x1: 1.0 + 11.3, x2: belt_speed };
        let traced = trace(&oscillator, start, 1e-12, 1000.0);
        let met: Vec<_> = contacts(&traced, belt_speed).iter().map(|s| (s.x1, s.phase)).collect();
        let (below, above) = (Phase::Slip(Side::Below), Phase::Slip(Side::Above));
        let expected = [
            (12.3, below),
            (-10.3, above),
            (8.3, below),
            (-6.3, above),
            (4.3, below),
            (-2.3, above),
            (0.3, Phase::Stick),
            (1.0, below),
        ];
        for ((x1, phase), (exact, expected)) in met.iter().zip(expected) {
            assert_eq!(*phase, expected);
            // 1e-12 V per turn, seen under the angle of the slowest contact, |w| = 0.3 or more.
            assert!((x1 - exact).abs() < 1e-10 * belt_speed.max(1.0), "{met:?}");
        }
        // Then the orbit from the exit point touches the line without end: too close to call.
        assert!(met.len() >= expected.len());
    }
}

#[test]
fn traces_from_anywhere_follow_the_damped_linear_solution() {
    let (viscous, belt_speed) = (0.2, 1.5);
    let oscillator = coulomb(viscous, belt_speed);
    let mut all = 0;
    for (x1, x2) in [(-3.0, 0.0), (2.5, -1.0), (0.0, -4.0), (-2.5, 4.0), (4.0, 1.6), (1.0, 1.4)] {
        let traced = trace(&oscillator, Start::State { x1, x2 }, 1e-12, 30.0);
        let side = if x2 > belt_speed { Side::Above } else { Side::Below };
        let start = [x2, oscillator.acceleration(side, x1, x2)];
        let first_arc = traced.samples.iter().take_while(|s| s.x2 != belt_speed);
        let mut followed = 0;
        for sample in first_arc {
            let [v, w] = linear(viscous, start, sample.t);
            let friction = if side == Side::Below { 1.0 } else { -1.0 };
            assert!((sample.x2 - v).abs() < 2e-11, "{sample:?} instead of v = {v}");
            assert!((sample.x1 - (friction - viscous * v - w)).abs() < 2e-11, "{sample:?}");
            assert_eq!(sample.phase, Phase::Slip(side));
            followed += 1;
        }
        assert!(followed >= 1);
        all += followed;
        if let Some(contact) = contacts(&traced, belt_speed).first() {
            let v = linear(viscous, start, contact.t)[0];
            assert!((v - belt_speed).abs() < 2e-11, "contact at {} has v = {v}", contact.t);
        }
    }
    assert!(all > 100, "only {all} samples");
}

// ---------------------------------------------------------------- where other solvers fail

#[test]
fn the_double_crossing_that_event_finders_miss() {
    let kappa = 0.5;
    for epsilon in [1e-3, 1e-4, 1e-5, 1e-6] {
        let oscillator = oscillator([epsilon, 0.5, 0.2, 2.0, 1.0, 0.1]);
        for tolerance in [1e-9, 1e-12] {
            let answer = flow(&oscillator, tolerance);
            let landing = landing(&answer);
            let speed = oscillator.exit_x1() - landing.x1;
            let leading = (TAU * kappa * epsilon).sqrt();
            // First order: the corrections are relative O(sqrt eps), with constants of the order of the
            // slopes of D over eps, which are below 5 here.
            assert!((speed / leading - 1.0).abs() < 5.0 * epsilon.sqrt(), "{speed} against {leading}");
            assert!((landing.slip_time - (TAU - leading)).abs() < 5.0 * epsilon, "{landing:?}");
            assert!((landing.slip_time + landing.stick_time - TAU).abs() < 5.0 * epsilon, "{landing:?}");
            assert_eq!(landing.crossings, 0);
            assert!(landing.x1 < oscillator.exit_x1());
        }
    }
}

#[test]
fn hostile_points_end_with_a_reason() {
    let nan = f64::NAN;
    let points: [Six; 20] = [
        [1.0, 0.0, 0.0, 100.0, 10.0, 0.0],
        [1.0, 0.0, 0.0, 100.0, 10.0, 1000.0],
        [1.0, 0.5, 1.0, 100.0, 10.0, 1000.0],
        [1.0, 0.0, 0.0, 2000.0, 10.0, 1000.0],
        [1.0, 0.0, 100.0, 0.0, 10.0, 0.0],
        [1e-3, 0.0, 0.0, 1e9, 1.0, 0.0],
        [1e8, 0.0, 0.0, 1.0, 1.0, 0.0],
        [1e8, 0.0, 0.0, 1e8, 1.0, 0.0],
        [1e4, 0.0, 0.0, 1.0, 1e-4, 9e3],
        [1e-4, 0.5, 0.2, 2.0, 1e-6, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e-15, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e-300, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e8, 0.1],
        [1e-4, 0.5, 0.2, 2.0, 1e300, 0.1],
        [1.0, 1.0, 0.0, 0.0, 1.0, 1e12],
        [1.0, 1.0, 0.0, 0.0, 1.0, -2.0],
        [1.0, 1.0, 0.0, 0.0, 1.0, -1e6],
        [nan, 1.0, 0.0, 0.0, 1.0, 1.0],
        [1.0, 1.0, 0.0, 0.0, nan, 1.0],
        [1.0, 1.0, 0.0, 0.0, f64::INFINITY, 1.0],
    ];
    for point in points {
        let oscillator = oscillator(point);
        for tolerance in [1e-9, 0.0, -1.0, nan, f64::INFINITY] {
            let answer = flow(&oscillator, tolerance);
            // The step budget of 100,000, twelve right-hand sides each.
            assert!(answer.rhs <= 1_200_000, "{point:?}: {answer:?}");
            if point.iter().any(|x| x.is_nan()) {
                assert_eq!(answer.fate, Fate::Failed(Failure::NotFinite), "{point:?}");
            }
        }
        let traced = trace(&oscillator, Start::State { x1: 0.3, x2: 1.0 }, 1e-9, 10.0);
        assert!(traced.samples.len() <= 200_000);
    }
    // The orbit at a divergence of 2 and more runs away without turning.
    assert_eq!(flow(&coulomb(-2.0, 1.0), 1e-9).fate, Fate::Failed(Failure::NotFinite));
    assert_eq!(flow(&coulomb(-2.5, 1.0), 1e-9).fate, Fate::Failed(Failure::NotFinite));
    assert_eq!(flow(&oscillator(points[1]), 1e-9).fate, Fate::SpiralsInward);
    assert_eq!(flow(&oscillator(points[3]), 1e-9).fate, Fate::SpiralsInward);
}

// ---------------------------------------------------------------- identities of the theory

#[test]
fn scaling_the_small_parameter_changes_nothing() {
    let mut stream = Stream(11);
    for _ in 0..300 {
        let point = stream.point();
        let scaled = |l: f64| {
            let [epsilon, alpha, beta, gamma, belt_speed, damping] = point;
            flow(&oscillator([l * epsilon, alpha, beta / l, gamma / l, belt_speed, damping / l]), 1e-11)
        };
        let answer = scaled(1.0);
        // Powers of two scale without rounding: the same bits.
        assert_eq!(format!("{:?}", scaled(0.25)), format!("{answer:?}"));
        let other = scaled(0.3);
        if !(answer.margin.is_nan() || other.margin.is_nan()) {
            let bound = answer.margin_error + other.margin_error;
            assert!((answer.margin - other.margin).abs() <= bound, "{point:?}: {answer:?} {other:?}");
        }
    }
}

#[test]
fn the_margin_depends_on_the_four_scaled_groups_alone() {
    // A = eps gamma (1 - alpha), k = eps gamma V, b = eps beta V and C = eps c are kept while V changes.
    let mut stream = Stream(12);
    for _ in 0..300 {
        let [epsilon, alpha, beta, gamma, belt_speed, damping] = stream.point();
        let s = 0.1 + 0.9 * stream.unit();
        let slower = [epsilon, 1.0 - (1.0 - alpha) * s, beta / s, gamma / s, belt_speed * s, damping];
        let points = [[epsilon, alpha, beta, gamma, belt_speed, damping], slower];
        let [one, two] = points.map(|point| flow(&oscillator(point), 1e-11));
        if !(one.margin.is_nan() || two.margin.is_nan()) {
            let bound = one.margin_error + two.margin_error;
            assert!((one.margin - two.margin).abs() <= bound, "{points:?}: {one:?} {two:?}");
        }
    }
}

#[test]
fn the_margin_falls_with_the_damping() {
    let mut stream = Stream(13);
    for _ in 0..100 {
        let mut point = stream.point();
        let mut last = f64::INFINITY;
        for step in 0..12 {
            point[5] = 0.25 * f64::from(step);
            let answer = flow(&oscillator(point), 1e-11);
            if answer.margin.is_nan() {
                assert!(last > 0.1, "{point:?} overshoots where less damping did not: {answer:?}");
                continue;
            }
            assert!(answer.margin <= last + answer.margin_error, "{point:?}: {answer:?} after {last}");
            // Strictly, unless nothing is left of the orbit or the step in C is below the accuracy.
            let falls = answer.margin < last || answer.margin_error + answer.margin + 1.0 < 1e-9;
            assert!(falls, "{point:?}: {answer:?} after {last}");
            last = answer.margin;
        }
    }
}

// ---------------------------------------------------------------- slow references

#[test]
fn margins_and_their_error_estimates_agree_with_the_polar_form() {
    let mut stream = Stream(21);
    let mut points = 0;
    let mut errors = Vec::new();
    let (mut dishonest, mut estimates) = (0, 0);
    while points < 2500 {
        let point = stream.point();
        let oscillator = oscillator(point);
        let Some(exact) = oracle::polar_margin(&oscillator) else { continue };
        points += 1;
        for tolerance in [1e-6, 1e-9, 1e-11, 1e-13] {
            let answer = flow(&oscillator, tolerance);
            let context = format!("{point:?}, tolerance {tolerance}: {answer:?}, exact {exact:?}");
            match answer.fate {
                Fate::SpiralsInward => assert!(exact.value < exact.error, "{context}"),
                Fate::Sticks(_) | Fate::CrossesForever => assert!(exact.value > -exact.error, "{context}"),
                Fate::TooCloseToCall => assert!(exact.value.abs() < 2.0 * answer.margin_error, "{context}"),
                Fate::Failed(_) => panic!("{context}"),
            }
            if answer.margin.is_nan() {
                // The continuation ends at V/8, or nearer if the law has its pole near.
                assert!(exact.value > 0.0, "{context}");
                continue;
            }
            let error = (answer.margin - exact.value).abs();
            estimates += 1;
            dishonest += u32::from(error > answer.margin_error + exact.error);
            if tolerance == 1e-13 && exact.error < 3e-15 {
                errors.push(error);
            }
            // Even a fooled estimate is not far off.
            assert!(error <= 10.0 * answer.margin_error + exact.error, "error {error:e}, {context}");
        }
    }
    errors.sort_by(f64::total_cmp);
    let (median, worst) = (errors[errors.len() / 2], errors[errors.len() - 1]);
    println!("{dishonest} of {estimates} estimates too small; at 1e-13: median {median:e}, worst {worst:e}");
    assert!(f64::from(dishonest) < 1e-3 * f64::from(estimates), "{dishonest} of {estimates}");
    // Rounding errors of x2' of 1e-16 each, averaged over the turn, over V >= 0.1; 1e-13 itself at worst.
    assert!(median < 2e-15 && worst < 1e-13, "median {median:e}, worst {worst:e}");
}

#[test]
fn outcomes_and_landings_agree_with_the_lienard_form() {
    let mut stream = Stream(22);
    let mut seen = [0; 5];
    for n in 0..600 {
        let point = if n % 2 == 0 { stream.point() } else { stream.overshooting_point() };
        let oscillator = oscillator(point);
        let answer = flow(&oscillator, 1e-12);
        let Some((outcome, value, time)) = oracle::lienard(&oscillator) else { continue };
        let context = format!("{point:?}: {answer:?}, reference {outcome:?} {value:?} {time:?}");
        let belt_speed = oscillator.belt_speed;
        match (answer.fate, outcome) {
            (Fate::TooCloseToCall, _) => continue,
            (Fate::SpiralsInward, Outcome::Short) => {
                seen[0] += 1;
                let error = (answer.margin - value.value).abs();
                assert!(error <= answer.margin_error + value.error, "{context}");
            }
            (Fate::SpiralsInward, Outcome::Rests) => {
                seen[1] += 1;
                assert!(answer.margin < -0.9, "{context}");
            }
            (Fate::Sticks(landing), Outcome::Sticks | Outcome::SticksFromAbove) => {
                let from_above = outcome == Outcome::SticksFromAbove;
                seen[2 + usize::from(from_above)] += 1;
                assert_eq!(landing.crossings, u32::from(from_above), "{context}");
                let lift = if from_above { 2.0 } else { 0.0 };
                let speed = oscillator.exit_x1() - landing.x1;
                let slowest = value.value.abs().min(speed);
                let error = answer.margin_error * belt_speed * (1.0 + belt_speed / slowest);
                assert!((speed - value.value - lift).abs() <= error + value.error, "{context}");
                let late = (landing.slip_time - time.value).abs();
                assert!(late <= error * (1.0 + 1.0 / slowest) + time.error, "{context}");
                assert!((landing.stick_time * belt_speed - speed).abs() <= 1e-12 * belt_speed.max(1.0));
            }
            (Fate::CrossesForever, Outcome::Crosses) => seen[4] += 1,
            _ => panic!("{context}"),
        }
    }
    println!("short, at rest, sticks, sticks from above, crosses: {seen:?}");
    assert!(seen.iter().all(|&n| n >= 10), "{seen:?}");
}

#[test]
fn grazing_points_are_right_or_not_called() {
    let mut stream = Stream(23);
    let (mut tested, mut called) = (0, [0; 2]);
    while tested < 200 {
        let mut point = stream.point();
        let exact = |c: f64| {
            point[5] = c;
            oracle::polar_margin(&oscillator(point))
        };
        let Some(critical) = critical_damping(exact) else { continue };
        tested += 1;
        for (at, tolerance) in [1e-12, 1e-13].into_iter().enumerate() {
            for side in [-1.0, 1.0] {
                point[5] = critical * (1.0 + side * 1e-9);
                let answer = flow(&oscillator(point), tolerance);
                let context = format!("{point:?}, side {side}, {answer:?}");
                match answer.fate {
                    Fate::TooCloseToCall => continue,
                    Fate::SpiralsInward => assert!(side > 0.0, "{context}"),
                    Fate::Sticks(_) | Fate::CrossesForever => assert!(side < 0.0, "{context}"),
                    Fate::Failed(_) => panic!("{context}"),
                }
                called[at] += 1;
            }
        }
    }
    println!("called at tolerance 1e-12 and 1e-13: {called:?} of {}", 2 * tested);
    assert!(called[1] > tested, "{called:?}");
}

/// The root of the margin in c, by bisection and secants, to about 1e-13 of itself; `None` if it is not in
/// [0.05, 3] or out of the polar form's range.
fn critical_damping(mut margin: impl FnMut(f64) -> Option<oracle::Known>) -> Option<f64> {
    let (mut lo, mut hi) = (0.05, 3.0);
    let (mut at_lo, mut at_hi) = (margin(lo)?.value, margin(hi)?.value);
    if !(at_lo > 0.0 && at_hi < 0.0) {
        return None;
    }
    for trial in 0..40 {
        let secant = lo + (hi - lo) * at_lo / (at_lo - at_hi);
        let middle = if trial % 3 == 2 { 0.5 * (lo + hi) } else { secant };
        let known = margin(middle)?;
        // The slope of the margin in c is that of the mean divergence, about -pi eps.
        if known.value.abs() <= known.error {
            return Some(middle);
        }
        if known.value > 0.0 {
            (lo, at_lo) = (middle, known.value)
        } else {
            (hi, at_hi) = (middle, known.value)
        }
    }
    Some(0.5 * (lo + hi))
}

// ---------------------------------------------------------------- nested orbits, traces, work

/// An orbit that crosses back never sticks: its downward crossings move outward for ever.
#[test]
fn crossing_orbits_are_nested_and_never_stick() {
    let mut stream = Stream(31);
    let (mut followed, mut turns) = (0, 0);
    while followed < 2000 {
        let oscillator = oscillator(stream.overshooting_point());
        if flow(&oscillator, 1e-10).fate != Fate::CrossesForever {
            continue;
        }
        followed += 1;
        let traced = trace(&oscillator, Start::ExitPoint, 1e-10, 200.0);
        assert_eq!(traced.ending, Ending::OutOfTime);
        assert!(traced.samples.iter().all(|sample| sample.phase != Phase::Stick));
        let contacts = contacts(&traced, oscillator.belt_speed);
        // The exit point itself comes first.
        let down: Vec<f64> =
            contacts.iter().filter(|s| s.phase == Phase::Slip(Side::Below)).map(|s| s.x1).collect();
        assert_eq!(down[0], oscillator.exit_x1());
        turns += down.len() - 1;
        for pair in down.windows(2) {
            // Once on the crossing cycle, differences are errors: 1e-10 V a turn, seen at |w| > 2.
            let noise = 1e-8 * oscillator.belt_speed * (1.0 + oscillator.belt_speed);
            assert!(pair[1] > pair[0] - noise, "{oscillator:?}: {down:?}");
        }
        assert!(down[1] > down[0], "{oscillator:?}: {down:?}");
    }
    println!("{followed} orbits, {turns} turns");
}

#[test]
fn a_traced_cycle_closes_with_the_period_of_the_flow() {
    let mut stream = Stream(32);
    let mut cycles = 0;
    while cycles < 100 {
        let oscillator = oscillator(stream.point());
        let Fate::Sticks(landing) = flow(&oscillator, 1e-11).fate else { continue };
        let period = landing.slip_time + landing.stick_time;
        // An event too close to call may go either way.
        if oscillator.exit_x1() - landing.x1 < 1e-3 {
            continue;
        }
        cycles += 1;
        let traced = trace(&oscillator, Start::ExitPoint, 1e-11, 1000.0);
        let Ending::Closes { period: traced_period } = traced.ending else {
            panic!("{oscillator:?}: {:?}", traced.ending)
        };
        let slack = 1e-7 * (1.0 + 1.0 / oscillator.belt_speed);
        assert!((traced_period - period).abs() < slack, "{traced_period} against {period}");
        let (first, last) = (traced.samples[0], traced.samples[traced.samples.len() - 1]);
        assert_eq!((first.x1, first.x2, first.t), (oscillator.exit_x1(), oscillator.belt_speed, 0.0));
        assert_eq!((last.x1, last.x2, last.t), (first.x1, first.x2, traced_period));
        for pair in traced.samples.windows(2) {
            assert!(pair[0].t < pair[1].t, "{pair:?}");
            let slips = pair[0].phase != Phase::Stick;
            assert!(!slips || pair[1].t - pair[0].t <= 0.1 + 1e-12, "{pair:?}");
            let below = pair[0].phase == Phase::Slip(Side::Below);
            assert!(!below || pair[1].x2 <= oscillator.belt_speed, "{pair:?}");
        }
    }
}

#[test]
fn a_bistable_point_has_two_basins() {
    // Between c(instability) and the critical damping: the equilibrium attracts, and so does the cycle.
    let point: Six = [0.1, 0.2, 0.0, 4.0, 1.0, 0.0];
    let a = 0.4 * 0.8;
    let instability = a / (1.4 * 1.4) / 0.1;
    let q = 1.8_f64.sqrt();
    let balance = 2.0 * a / (q * (1.4 + q)) / 0.1;
    let mut point = point;
    point[5] = 0.5 * (instability + balance);
    let oscillator = oscillator(point);
    assert!(matches!(flow(&oscillator, 1e-12).fate, Fate::Sticks(_)));
    let from = |x2: f64| {
        let start = Start::State { x1: oscillator.equilibrium_x1(), x2 };
        trace(&oscillator, start, 1e-10, 20_000.0).ending
    };
    assert_eq!(from(0.05), Ending::Settles);
    assert!(matches!(from(0.999), Ending::Closes { .. }));
    assert_eq!(from(0.0), Ending::Settles);
    // From the sliding segment and from far above one reaches the cycle, too.
    let sliding = Start::State { x1: -0.5, x2: 1.0 };
    assert!(matches!(trace(&oscillator, sliding, 1e-10, 1000.0).ending, Ending::Closes { .. }));
    assert!(matches!(from(5.0), Ending::Closes { .. }));
    let short = trace(&oscillator, sliding, 1e-10, 0.25);
    assert_eq!(short.ending, Ending::OutOfTime);
    let last = short.samples[short.samples.len() - 1];
    assert_eq!((last.t, last.x2, last.phase), (0.25, 1.0, Phase::Stick));
    assert!((last.x1 + 0.25).abs() < 1e-15);
}

#[test]
fn slow_creep_is_recognised_when_steps_run_out() {
    let oscillator = coulomb(1e5, 1.0);
    let traced = trace(&oscillator, Start::State { x1: 1.0, x2: 0.9 }, 1e-9, 1e7);
    assert_eq!(traced.ending, Ending::Settles);
}

/// Right-hand sides of a few flows at tolerances 1e-9 and 1e-12: a change of this table is a change of
/// cost, to be made knowingly.
#[test]
fn the_work_of_reference_flows_is_known() {
    let cases: [(&str, Six, [u64; 2]); 5] = [
        ("spirals inward", [0.1, 0.4, 0.2, 2.0, 1.0, 1.0], [288, 720]),
        ("double crossing", [1e-4, 0.5, 0.2, 2.0, 1.0, 0.1], [301, 733]),
        ("sticks", [0.05, 0.1, 0.1, 8.0, 1.0, 2.0], [372, 800]),
        ("overshoots", [1.0, 0.0, 0.0, 0.1, 30.0, 0.0], [459, 987]),
        ("creeps", [1.0, 0.5, 0.1, 1.0, 1.0, 5.0], [12, 24]),
    ];
    let counted = cases.map(|(_, point, _)| [1e-9, 1e-12].map(|tol| flow(&oscillator(point), tol).rhs));
    assert_eq!(counted, cases.map(|(_, _, expected)| expected));
}

/// The cost of a flow over random points: `cargo test --release --test mathematics direct:: -- --ignored --nocapture`.
#[test]
#[ignore = "a measurement, not a test"]
fn cost_per_flow() {
    let mut stream = Stream(41);
    let oscillators: Vec<_> = (0..5000).map(|_| oscillator(stream.point())).collect();
    for tolerance in [1e-6, 1e-9, 1e-12, 1e-13] {
        let start = std::time::Instant::now();
        let mut work: Vec<u64> = oscillators.iter().map(|o| flow(o, tolerance).rhs).collect();
        let each = start.elapsed().as_secs_f64() * 1e6 / work.len() as f64;
        let mean = work.iter().sum::<u64>() as f64 / work.len() as f64;
        work.sort_unstable();
        let median = work[work.len() / 2];
        println!("{tolerance:e}: {each:.1} us, right-hand sides: median {median}, mean {mean:.0}");
    }
}

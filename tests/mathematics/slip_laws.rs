//! Slip cycles of laws whose friction falls and rises again: a published belt oscillator, and a cycle that
//! appears in a Hopf bifurcation and ends at grazing.

use std::f64::consts::PI;

use crate::runge_kutta;
use crate::sample::slip_cycles;
use crate::sample::{Random, Sampling, at_one, formula};
use slipmap::certify::slip_count::count_slip_cycles;
use slipmap::column::critical_damping;
use slipmap::column::slip_cycle::{kick_onto, none_proved};
use slipmap::column::{Regime, regime};
use slipmap::filippov::Oscillator;
use slipmap::flow::Fate;
use slipmap::friction::{Column, Expression, Law};
use slipmap::orbits::flow;
use slipmap::point::LawParameters;
use slipmap::witness::{self, Start, trace};

/// The belt oscillator of J. J. Thomsen and A. Fidlin, "Analytical approximations for stick-slip vibration
/// amplitudes", Int. J. Non-Linear Mech. 38 (2003) 389-403: x'' + 2 beta x' + x + g mu(x' - v) = 0, with
/// mu(v) = mu_s - (3/2) (mu_s - mu_m) (v/v_m - (v/v_m)^3 / 3), of static friction mu_s = 0.4 and least
/// friction mu_m = 0.25 at v_m = 0.5; g is their gamma squared. The numbers are quoted from the paper and not
/// re-checked; the test shows that its formulas below are right to their order.
struct Published {
    g: f64,
    beta: f64,
}

const STATIC: f64 = 0.4;
const LEAST: f64 = 0.25;
const AT: f64 = 0.5;

impl Published {
    /// Speeds here are in units of g mu_s.
    fn unit(&self) -> f64 {
        self.g * STATIC
    }

    fn column(&self, belt: f64) -> Column {
        let law = formula("1 - 1.5*drop*(q*u - (q*u)^3/3)");
        let parameters = [1.0 - LEAST / STATIC, self.unit() / AT];
        law.column(&law.point(1.0, &parameters, belt / self.unit(), 0.0).unwrap())
    }

    fn oscillator(&self, belt: f64) -> Oscillator {
        Oscillator::in_column(&self.column(belt), 2.0 * self.beta)
    }

    /// Their v_b1, above which steady slip is stable.
    fn v_b1(&self) -> f64 {
        AT * (1.0 - 4.0 * self.beta * AT / (3.0 * self.g * (STATIC - LEAST))).sqrt()
    }

    /// Their v_b0 = sqrt(4/5) v_b1, below which the cycle sticks, by first-order averaging.
    fn v_b0(&self) -> f64 {
        0.8f64.sqrt() * self.v_b1()
    }

    /// Their amplitude of pure slip, 2 sqrt(v_b1^2 - v_b^2).
    fn amplitude(&self, belt: f64) -> f64 {
        2.0 * (self.v_b1().powi(2) - belt * belt).sqrt()
    }

    /// The belt speed at which the slip cycle grazes, by the exact flow.
    fn grazing(&self) -> f64 {
        let excess = |belt: f64| critical_damping(&self.column(belt), 1e-12).unwrap().c - 2.0 * self.beta;
        let (mut low, mut high) = (0.5 * self.v_b0(), self.v_b1());
        assert!(excess(low) > 0.0 && excess(high) < 0.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            *if excess(middle) > 0.0 { &mut low } else { &mut high } = middle;
        }
        low
    }
}

#[test]
fn belt_speeds_and_amplitudes_of_thomsen_and_fidlin() {
    let published = Published { g: 1.0, beta: 0.05 };
    // Their formulas at these values.
    assert!((published.v_b1() - 0.440_958_6).abs() < 1e-7 && (published.v_b0() - 0.394_405_3).abs() < 1e-7);
    // Steady slip loses its stability at v_b1 exactly: that is a linear statement.
    assert!(published.oscillator(published.v_b1() * (1.0 + 1e-9)).eigenvalues().is_stable());
    assert!(!published.oscillator(published.v_b1() * (1.0 - 1e-9)).eigenvalues().is_stable());
    // The rest is averaging to first order: the error falls by four when friction and damping are halved.
    let grazing = |p: &Published| p.grazing() / p.v_b0() - 1.0;
    let amplitude = |p: &Published| {
        let belt = 0.5 * (p.v_b0() + p.v_b1());
        let cycles = slip_cycles(&p.oscillator(belt), 1e-12).unwrap();
        assert!(cycles.len() == 1 && cycles[0].is_stable(), "{cycles:?}");
        assert_eq!(count_slip_cycles(&p.oscillator(belt)).exact(), Some(1));
        let range = cycles[0].velocity;
        0.5 * (range.hi - range.lo) * p.unit() / p.amplitude(belt) - 1.0
    };
    let halved = Published { g: 0.5, beta: 0.025 };
    for (name, error) in [("grazing", &grazing as &dyn Fn(&Published) -> f64), ("amplitude", &amplitude)] {
        let [coarse, fine] = [error(&published), error(&halved)];
        // D is at most 0.35 along the orbits: second order means a few per cent.
        assert!(coarse.abs() < 0.04, "{name}: {coarse}");
        assert!((3.0..5.0).contains(&(coarse / fine)), "{name}: {coarse} {fine}");
    }
    // Their three regimes.
    let seen = [1.02 * published.v_b1(), 0.5 * (published.v_b0() + published.v_b1()), 0.9 * published.v_b0()]
        .map(|belt| published.oscillator(belt))
        .map(|oscillator| regime(&oscillator, &flow(&oscillator, 1e-10)));
    assert_eq!(seen, [Regime::Equilibrium, Regime::PureSlip, Regime::StickSlip]);
}

/// The Lorentzian law phi = 1 / (1 + u^2) next to its steepest fall, u = 1/sqrt(3).
fn lorentzian(belt_speed: f64) -> Column {
    Law::Lorentzian.column(&Law::Lorentzian.point(1.0, &[0.0, 1.0, 0.0], belt_speed, 0.0).unwrap())
}

/// Points on each side of each curve.
const POINTS: usize = 1000;

#[test]
fn slip_cycles_begin_at_hopf_and_end_at_grazing() {
    let mut random = Random(31);
    for i in 0..POINTS {
        let column = lorentzian(0.5 + 0.15 * random.unit());
        let hopf = column.curve.weakening(column.belt_speed);
        let grazing = critical_damping(&column, 1e-12).unwrap().c;
        assert!(grazing < 0.97 * hopf, "{column:?}");
        let at = |c: f64| Oscillator::in_column(&column, c);

        // The grazing curve: the direct flow from the exit point.
        let off = random.log(1e-6, 0.05);
        let (below, above) = (at(grazing * (1.0 - off)), at(grazing * (1.0 + off)));
        let [sticks, inward] = [&below, &above].map(|oscillator| witness::flow(oscillator, 1e-11).fate);
        assert!(matches!(sticks, Fate::Sticks(_)), "{column:?} {off} {sticks:?}");
        assert_eq!(inward, Fate::SpiralsInward, "{column:?} {off}");

        // The Hopf curve: a direct orbit from near the equilibrium, over three turns; it must not come within
        // V / 1000, where traces end.
        let off = random.log(0.01, 0.05);
        let change = |oscillator: &Oscillator| {
            let x1 = oscillator.equilibrium_x1() + 0.01 * oscillator.belt_speed;
            let orbit = trace(oscillator, Start::State { x1, x2: 0.0 }, 1e-9, 8.0 * PI);
            let largest = |from: f64| {
                let turn = orbit.samples.iter().filter(|sample| (from..from + 2.0 * PI).contains(&sample.t));
                turn.map(|sample| sample.x2.abs()).fold(0.0, f64::max)
            };
            (largest(6.0 * PI) / largest(0.0)).ln()
        };
        // The growth rate is D/2; samples miss the maximum by a part in 800.
        let expected = 3.0 * PI * off * hopf;
        let [decay, growth] = [at(hopf * (1.0 + off)), at(hopf * (1.0 - off))].map(|o| change(&o));
        assert!((growth - expected).abs() < 0.2 * expected + 0.003, "{column:?} {off}: {growth} {expected}");
        assert!((decay + expected).abs() < 0.2 * expected + 0.003, "{column:?} {off}: {decay} {expected}");

        // Between the curves there is one slip cycle, and it attracts; beyond them there is none.
        if i % 10 == 0 {
            let between = at(grazing + (0.05 + 0.9 * random.unit()) * (hopf - grazing));
            let cycles = slip_cycles(&between, 1e-11).unwrap();
            assert!(cycles.len() == 1 && cycles[0].is_stable(), "{column:?} {cycles:?}");
            let cycle = &cycles[0];
            let top = cycle.velocity.hi;
            let x1 = between.curve.phi(between.belt_speed - top) - between.viscous * top;
            let orbit = trace(&between, Start::State { x1, x2: top }, 1e-11, cycle.period);
            let end = orbit.samples.last().unwrap();
            let missed = (end.x1 - x1).hypot(end.x2 - top);
            // The orbit loses no accuracy on an attracting cycle; the cycle is located to 1e-11 / (1 -
            // multiplier).
            assert!(missed < 1e-9 / (1.0 - cycle.multiplier), "{column:?} {missed} {cycle:?}");
            assert_eq!(regime(&between, &flow(&between, 1e-10)), Regime::PureSlip);
            assert!(slip_cycles(&below, 1e-11).unwrap().is_empty());
            assert!(slip_cycles(&at(1.01 * hopf), 1e-11).unwrap().is_empty());
            if i % 100 == 0 {
                let counts = [&between, &below, &at(1.01 * hopf)].map(|o| count_slip_cycles(o).exact());
                assert_eq!(counts, [Some(1), Some(0), Some(0)], "{column:?}");
            }
        }
    }
}

#[test]
fn a_pair_of_slip_cycles_between_two_signs_is_found() {
    // The weakening e (1 - a cos k u) feeds into a turn of radius r at V = 1, to first order in e,
    // e (1 - a cos(k) g(k r)) pi r^2 with g(x) = 2 J1(x)/x, which falls from 1 to -0.1323 at x = 5.136 and is
    // -0.0013 again at x = 7. With a level between these there are two cycles below the belt line.
    let (e, a) = (0.01, 1.5);
    let law = Expression::new("1 - s*(u - a*sin(k*u)/k)", 1.0).unwrap();
    // 2 J1(x)/x as the mean of cos(x cos t) with weight 2 sin^2 t; the trapezoidal rule is exact to
    // round-off.
    let g = |x: f64| {
        let terms = (0..64).map(|i| f64::from(i) * PI / 32.0).map(|t| (x * t.cos()).cos() * t.sin().powi(2));
        terms.sum::<f64>() / 32.0
    };
    let names: Vec<&str> = law.parameters().iter().map(|parameter| parameter.name).collect();
    assert_eq!(names, ["s", "a", "k"]);
    let mut random = Random(5);
    for _ in 0..40 {
        let (k, level) = (7.0 + 0.4 * random.unit(), -0.12 + 0.1 * random.unit());
        let oscillator = Oscillator {
            curve: Law::Expression(law.clone()).curve(1.0, &LawParameters::new(&[e, a, k])),
            viscous: e * (1.0 - a * k.cos() * level),
            belt_speed: 1.0,
        };
        assert!(!none_proved(&oscillator));
        let cycles = slip_cycles(&oscillator, 1e-11).unwrap();
        assert_eq!(cycles.len(), 2, "{oscillator:?} {cycles:?}");
        for cycle in &cycles {
            // The next order is smaller by a factor of the divergence, e (1 + a) at most, times the slopes of
            // g.
            assert!((g(k * cycle.velocity.hi) - level).abs() < e * (1.0 + a), "{oscillator:?} {cycle:?}");
        }
        // They alternate in stability, the first being opposite to the equilibrium.
        assert_ne!(cycles[0].is_stable(), oscillator.eigenvalues().is_stable());
        assert_ne!(cycles[0].is_stable(), cycles[1].is_stable());
    }
}

/// Runge-Kutta steps in reversed time, in which a repelling cycle attracts. Returns the velocities at which
/// the equilibrium's x1 is passed, up and down, and the time of a turn.
fn reversed(curve: impl Fn(f64) -> f64, [viscous, belt_speed]: [f64; 2], step: f64) -> [f64; 3] {
    let slope = |[x1, x2]: [f64; 2]| [-x2, x1 + viscous * x2 - curve(belt_speed - x2)];
    let rest = curve(belt_speed);
    let mut here = [rest, 0.95 * belt_speed];
    let (mut time, mut passes) = (0.0, Vec::new());
    while passes.len() < 24 {
        let next = runge_kutta::step(&slope, here, step);
        let [from, to] = [here[0] - rest, next[0] - rest];
        if from * to < 0.0 {
            let share = from / (from - to);
            passes.push([time + share * step, here[1] + share * (next[1] - here[1])]);
        }
        (here, time) = (next, time + step);
    }
    let [before, middle, last] = [21, 22, 23].map(|i| passes[i]);
    [last[1].max(middle[1]), -last[1].min(middle[1]), last[0] - before[0]]
}

/// A cycle whose multiplier is so large that forward turns lose all digits is known as accurately as others.
#[test]
fn cycles_that_repel_strongly_are_followed_backward() {
    for [speed, damping] in [[0.001, 0.01], [0.002, 0.02], [0.004, 0.01]] {
        let law = formula(&format!("0.5 + 0.5*exp(-u/{speed})"));
        let oscillator = at_one(&law, &[], 1.0, damping);
        let [cycle] = slip_cycles(&oscillator, 1e-13).unwrap()[..] else { panic!("{speed}") };
        assert!(cycle.multiplier > 1e3, "{speed}: {cycle:?}");
        let phi = |u: f64| 0.5 + 0.5 * (-u / speed).exp();
        let [forward, backward, period] = reversed(phi, [damping, 1.0], 0.02 * speed);
        let kick = kick_onto(&oscillator, &cycle, 1e-13).unwrap();
        let pairs = [[kick.forward, forward], [kick.backward, backward], [cycle.period, period]];
        assert!(pairs.iter().all(|[a, b]| (a - b).abs() < 1e-7), "{speed}: {pairs:?}");
    }
}

//! Proved counts of slip cycles against those that are found.

use std::f64::consts::PI;

use crate::sample::Random;
use slipmap::filippov::Oscillator;
use slipmap::friction::{Expression, Law, Table};
use slipmap::point::{LawParameters, Point};
use slipmap::simulate::critical_damping;
use slipmap::simulate::slip_count::count_slip_cycles;
use slipmap::simulate::slip_cycle::slip_cycles;

fn expression(text: &str, parameters: &[f64], viscous: f64, belt_speed: f64) -> Oscillator {
    let curve =
        Law::Expression(Expression::new(text, 1.0).unwrap()).curve(1.0, &LawParameters::new(parameters));
    Oscillator { curve, viscous, belt_speed }
}

#[test]
fn the_pair_of_the_wavy_law_is_proved() {
    let (e, a, k) = (0.01, 1.5_f64, 7.2_f64);
    let with = |level: f64| {
        let viscous = e * (1.0 - a * k.cos() * level);
        count_slip_cycles(&expression("1 - e*(u - a*sin(k*u)/k)", &[e, a, k], viscous, 1.0))
    };
    for (level, count) in [(-0.10, 2), (-0.05, 2), (-0.15, 0), (0.2, 1), (0.8, 1)] {
        let start = std::time::Instant::now();
        let counted = with(level);
        println!("{level} {counted:?} {:?}", start.elapsed());
        assert_eq!(counted.exact(), Some(count), "{level}: {counted:?}");
    }
}

#[test]
fn random_laws() {
    let mut random = Random(77);
    let (mut proved, mut found, mut all) = (0, 0, 0);
    let begin = std::time::Instant::now();
    for i in 0..300 {
        let belt_speed = random.log(0.3, 2.0);
        let mut between = |lo: f64, hi: f64| lo + (hi - lo) * random.unit();
        let oscillator = match i % 3 {
            0 => {
                let law = LawParameters::new(&[between(0.0, 0.8), between(0.4, 2.0), between(0.0, 0.1)]);
                let column = Law::Lorentzian.column(&Point { epsilon: 1.0, law, belt_speed, damping: 0.0 });
                let c = column.curve.weakening(belt_speed);
                Oscillator::in_column(&column, (c * between(0.7, 1.1)).max(0.0))
            }
            1 => {
                let (e, a, k) = (between(0.02, 0.3), between(0.2, 1.0), between(1.0, 6.0));
                let damping = e * between(0.0, 2.0);
                expression("1 - e*(u - a*sin(k*u)/k)", &[e, a, k], damping, belt_speed)
            }
            _ => {
                let (drop, q) = (between(0.1, 0.5), between(0.4, 1.5));
                expression("1 - 1.5*d*(q*u - (q*u)^3/3)", &[drop, q], between(0.0, 0.5), belt_speed)
            }
        };
        let start = std::time::Instant::now();
        let counted = count_slip_cycles(&oscillator);
        let took = start.elapsed();
        let Ok(cycles) = slip_cycles(&oscillator, 1e-11) else { continue };
        all += 1;
        proved += u32::from(counted.exact().is_some());
        found += u32::from(!cycles.is_empty());
        if counted.exact().is_none() || took.as_millis() > 50 {
            println!("{i} {} {counted:?} {took:?} D(V) {}", cycles.len(), oscillator.divergence(belt_speed));
        }
        let n = cycles.len() as u32;
        assert!(counted.at_least <= n, "{oscillator:?} {counted:?} {cycles:?}");
        assert!(counted.at_most.is_none_or(|most| n <= most), "{oscillator:?} {counted:?} {cycles:?}");
    }
    println!("{proved} of {all} proved, {found} with cycles, {:?}", begin.elapsed());
}

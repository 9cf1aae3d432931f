//! The belt speeds that are tried, and bisection between two of them.

use slipmap_model::friction::{Curve, NOT_NEGATIVE};

/// Number of factors of ten by which the belt speeds that are tried reach beyond the velocities of the
/// machine.
const DECADES: f64 = 3.0;

/// Slip speeds u at which the friction of a law is examined, up to its last one.
fn slip_speeds(curve: &Curve) -> impl DoubleEndedIterator<Item = f64> {
    const PER_DECADE: i32 = 8;
    const EXTENT: i32 = 6;
    let speeds = (-EXTENT * PER_DECADE..=EXTENT * PER_DECADE).map(|i| speed_of(i, PER_DECADE));
    speeds.filter(|u| *u <= curve.fastest())
}

/// The slip speed u at which the friction has fallen by half of its largest fall; 1 if it does not fall.
fn half_fall(curve: &Curve) -> f64 {
    // A formula may be a law up to some slip speed only: friction is positive.
    let onset = 1.0 - curve.drop();
    let falls = slip_speeds(curve).map(|u| (u, onset - curve.phi(u))).take_while(|(_, fall)| *fall < onset);
    let falls: Vec<(f64, f64)> = falls.collect();
    let half = 0.5 * falls.iter().map(|(_, fall)| *fall).fold(0.0, f64::max);
    falls.into_iter().find(|(_, fall)| *fall > 0.0 && *fall >= half).map_or(1.0, |(u, _)| u)
}

/// The slip speed from which on the friction of a law pushes at all others, or is not a number; infinite if
/// there is none.
fn pushes_from(curve: &Curve) -> f64 {
    let resists = |u: f64| curve.phi(u) >= NOT_NEGATIVE;
    let mut pushes = f64::INFINITY;
    for u in slip_speeds(curve).rev() {
        if resists(u) {
            return match pushes.is_finite() {
                true => last_within(1e-12, 12, [u, pushes], |u| Some(resists(u)))[0],
                false => f64::INFINITY,
            };
        }
        pushes = u;
    }
    f64::INFINITY
}

fn speed_of(number: i32, per_decade: i32) -> f64 {
    10f64.powf(f64::from(number) / f64::from(per_decade))
}

/// The belt speeds V that are tried, from the slowest, `per_decade` of them per factor of ten: from a
/// thousandth of the slower to a thousand times the faster of two velocities of the machine, that of the
/// static friction on its mass and spring, V = 1, and that at which its friction falls. A closed orbit
/// reaches about twice the belt speed: data and samples give no answers beyond half their end, and
/// formulas none beyond half the slip speed from which on their friction pushes.
///
/// The speeds do not depend on the belt speed and the damping of the machine, so its limits do not either.
pub(crate) fn belt_speeds(curve: &Curve, per_decade: i32) -> Vec<f64> {
    let fall = half_fall(curve);
    let index = |speed: f64| speed.log10() * f64::from(per_decade);
    let first = (index(fall.min(1.0)) - DECADES * f64::from(per_decade)).floor() as i32;
    let last = (index(fall.max(1.0)) + DECADES * f64::from(per_decade)).ceil() as i32;
    let end = 0.5 * curve.fastest().min(pushes_from(curve));
    let mut speeds: Vec<f64> = (first..=last).map(|i| speed_of(i, per_decade)).collect();
    if speeds.last().is_some_and(|last| *last > end) {
        speeds.retain(|speed| *speed < end);
        speeds.push(end);
    }
    speeds
}

/// By bisection, two values between `low`, where `holds` is true, and `high`, where it is false: it is true at
/// the first, false at the second, and unknown between them unless they agree to within this relative width.
/// There are so many bisections for each end of a range in which it is unknown.
pub(crate) fn last_within(
    width: f64,
    rounds: u32,
    [mut low, mut high]: [f64; 2],
    holds: impl Fn(f64) -> Option<bool>,
) -> [f64; 2] {
    while high - low > width * high {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            break;
        }
        match holds(middle) {
            Some(true) => low = middle,
            Some(false) => high = middle,
            None => {
                let [mut from, mut to] = [middle; 2];
                for _ in 0..rounds {
                    let middle = 0.5 * (low + from);
                    *(if holds(middle) == Some(true) { &mut low } else { &mut from }) = middle;
                    let middle = 0.5 * (to + high);
                    *(if holds(middle) == Some(false) { &mut high } else { &mut to }) = middle;
                }
                break;
            }
        }
    }
    [low, high]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::example;
    use slipmap_model::friction::{Expression, Law};

    /// Friction that falls without end pushes from some slip speed on, which orbits of belts half as fast reach.
    /// Friction that tends to 0 never pushes.
    #[test]
    fn tried_speeds_end_where_orbits_reach_friction_that_pushes() {
        for (phi, end) in [
            ("1 - 0.5*u*exp(-u) - u/16", 8.0),
            // It pushes next to u = 1 as well.
            ("1 - 3*u*exp(-u) - u/50", 25.0),
            ("exp(-u)", 1000.0),
            ("0.5*(1 - u + abs(1 - u))", 1000.0),
        ] {
            let law = Law::Expression(Expression::new(phi, 1.0).unwrap());
            let speeds = belt_speeds(&law.column(&law.point(1.0, &[], 1.0, 0.0).unwrap()).curve, 32);
            let last = speeds[speeds.len() - 1];
            assert!((last / end - 1.0).abs() < 0.1, "{phi}: {last}");
        }
    }

    #[test]
    fn tried_speeds_enclose_the_velocities_of_the_machine() {
        // Friction that falls far below, at, and far above the velocity of its static force.
        for velocity in [1e-4, 1.0, 1e4] {
            let machine = example(Law::Exponential).with("strengthening", 0.0).unwrap();
            let machine = machine.with("stribeck_velocity", velocity).unwrap();
            let model = machine.model().unwrap();
            let speeds = belt_speeds(&model.column().curve, 4);
            let velocity = velocity / model.si.velocity;
            let (slowest, fastest) = (speeds[0], speeds[speeds.len() - 1]);
            assert!(slowest <= 1.1e-3 * velocity.min(1.0), "{velocity}: {slowest}");
            assert!(fastest >= 0.8e3 * velocity.max(1.0), "{velocity}: {fastest}");
            assert!(speeds.len() < 2 * 4 * 6 * 2, "{}", speeds.len());
        }
    }
}

//! The bound of [`crate::landing`] on the landing speed with outward rounding, for boxes of
//! parameters.
//!
//! The statements used are those proved there, in units of the belt speed: in a strip of s where D <= d,
//! e = s^2 + p^2, which starts from 1 + (j/V)^2, goes to at most m^2 + x^2 with x = d h + sqrt((d h)^2 + e - m^2), h the strip's width and
//! m^2 <= s^2 in the sense given there; the orbit turns within the strip if no x >= 0 exists. Here the ends
//! of the strips are exact numbers, everything else is rounded outwards. Two things differ:
//!
//! - D falls with the slip speed, with k, b and C, and rises with A, so that one bound at the worst ends of
//!   A, k, b, C and V covers a box.
//! - The turning point of the lower half is not taken from the closed form of the linear flow but from the
//!   strips themselves: R < rho if no x >= 0 exists for the strip up to rho.

use super::defect::Groups;
use slipmap_model::friction::{Law, Slope, Weakening};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::Real as _;

/// Numbers of strips per quarter turn, tried in this order.
const REFINEMENTS: [u32; 3] = [2, 8, 48];

/// Where the turn is tried to be proved, in units of the distance that is left without divergence: any of them
/// is proved or fails, and a farther one only loosens the bound.
const TURNS: [f64; 7] = [1.0, 1.0 + 1e-3, 1.1, 1.5, 2.0, 3.0, 6.0];

/// Source of an upper bound on the weakening rate.
#[derive(Clone, Copy, Debug)]
pub(super) enum Divergence<'a> {
    /// The scaled groups of Stribeck's law, of which only the ends with the largest divergence are used.
    Groups(Groups),
    /// The polynomials of any law.
    Compiled(&'a Weakening),
    /// Any law over a box of eps and its parameters.
    Box(&'a Law, &'a [Interval]),
}

/// The parameters of a landing, enclosed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Flow<'a> {
    pub(super) divergence: Divergence<'a>,
    pub(super) viscous: Interval,
    pub(super) belt_speed: Interval,
    /// The drop j of friction as slip begins.
    pub(super) drop: f64,
}

impl Flow<'_> {
    /// Returns whether it is proved for all parameters that an orbit which returns to the belt line does so
    /// with a speed below 2 - j, and that none runs away.
    pub(super) fn lands(&self) -> bool {
        let fastest = match self.drop {
            0.0 => 4.0,
            drop => (Interval::of(2.0) - Interval::of(drop)).square().lo,
        };
        REFINEMENTS.iter().any(|&strips| self.speed_squared_bound(strips) < fastest)
    }

    /// Upper bound of the square of the landing speed; infinite where none was found, 0 if no orbit arrives.
    pub(super) fn speed_squared_bound(&self, strips: u32) -> f64 {
        let start = match self.drop {
            0.0 => Interval::ONE,
            drop => Interval::ONE + Interval::of(drop).over(self.belt_speed).square(),
        };
        let fall = self.to_axis(-1.0, start.hi, 1.0, strips);
        let Some(turn) = self.turning_point(fall, strips) else {
            return f64::INFINITY;
        };
        let rise = self.to_axis(-turn, Interval::of(turn).square().hi, -1.0, strips);
        match self.to_belt(rise, strips) {
            None => 0.0,
            Some(energy) => {
                let excess = Interval::of((Interval::of(energy) - Interval::ONE).hi.max(0.0));
                (self.belt_speed.square() * excess).hi
            }
        }
    }

    /// Upper bound of D at slip speeds from `least` to `most`, in units of the belt speed.
    fn divergence_bound(&self, least: Interval, most: Interval) -> f64 {
        let slip = Interval::of(least.lo.max(0.0));
        let weakening = match self.divergence {
            // The weakening rate falls with the slip speed.
            Divergence::Groups(Groups { a, k, b }) => {
                let (a, k, b) = (Interval::of(a.hi), Interval::of(k.lo), Interval::of(b.lo));
                let q = Interval::ONE + k * slip;
                a.over(q.square()) - (b + b) * slip
            }
            Divergence::Compiled(law) => {
                let speeds = Interval::new((self.belt_speed * slip).lo.max(0.0), (self.belt_speed * most).hi);
                let range = law.range(speeds.lo, speeds.hi);
                if !range.hi.is_finite() {
                    return f64::INFINITY;
                }
                Interval::of(range.hi)
            }
            Divergence::Box(law, x) => {
                let speeds = Interval::new((self.belt_speed * slip).lo.max(0.0), (self.belt_speed * most).hi);
                let x: Vec<Slope> = x.iter().map(|x| Slope::of(*x)).collect();
                match law.weakening_over(Slope::of(speeds), &x) {
                    Some(weakening) => weakening.0[0],
                    None => return f64::INFINITY,
                }
            }
        };
        (weakening - Interval::of(self.viscous.lo)).hi
    }

    /// Bounds e at s = 0, from `energy` at s = `start` < 0; the slip speed is 1 + `sign` s.
    fn to_axis(self, start: f64, mut energy: f64, sign: f64, strips: u32) -> f64 {
        let slip = |s: f64| Interval::ONE + Interval::of(sign * s);
        let mut s = start;
        for i in 1..=strips {
            let tau = f64::from(i) / f64::from(strips);
            let next = if i == strips { 0.0 } else { start * (1.0 - tau * tau) };
            // The least slip speed of the strip is at its beginning where sign is positive.
            let (least, most) = if sign > 0.0 { (s, next) } else { (next, s) };
            let d = self.divergence_bound(slip(least), slip(most));
            let h = Interval::of(next) - Interval::of(s);
            let m = if d >= 0.0 {
                Interval::of(0.5) * (Interval::of(s) + Interval::of(next))
            } else {
                Interval::of(s)
            };
            energy = exit_energy(energy, h, m, d).unwrap_or(f64::INFINITY);
            s = next;
        }
        energy
    }

    /// A point before which the lower half turns.
    fn turning_point(&self, at_axis: f64, strips: u32) -> Option<f64> {
        let scale = at_axis.sqrt();
        if !scale.is_finite() {
            return None;
        }
        let slip = |s: f64| Interval::ONE + Interval::of(s);
        let recede =
            |energy: f64, s: f64, to: f64| recede(energy, s, to, self.divergence_bound(slip(s), slip(to)));
        let (mut energy, mut s) = (at_axis, 0.0);
        for i in 1..strips {
            let tau = f64::from(strips - i) / f64::from(strips);
            let next = scale * (1.0 - tau * tau);
            let Some(after) = recede(energy, s, next) else { break };
            energy = after;
            s = next;
        }
        // The energy may have grown: approach the turning point further, then take a strip beyond it.
        for _ in 0..strips {
            let next = s + 0.5 * (energy.sqrt() - s);
            if !(next > s && energy.sqrt() - s > scale / f64::from(strips * strips)) {
                break;
            }
            energy = recede(energy, s, next)?;
            s = next;
        }
        let rest = (energy.sqrt() - s).max(f64::EPSILON * s);
        let mut trials = TURNS.into_iter().map(|factor| (s + factor * rest).next_up());
        trials.find(|&trial| recede(energy, s, trial).is_none())
    }

    /// Bounds e at the belt line s = 1 from its value at s = 0; `None` if the orbit turns before.
    fn to_belt(self, at_axis: f64, strips: u32) -> Option<f64> {
        let (mut energy, mut s) = (at_axis, 0.0);
        for i in 1..=strips {
            let tau = f64::from(strips - i) / f64::from(strips);
            let next = 1.0 - tau * tau;
            let d =
                self.divergence_bound(Interval::ONE - Interval::of(next), Interval::ONE - Interval::of(s));
            energy = recede(energy, s, next, d)?;
            s = next;
        }
        Some(energy)
    }
}

/// Upper bound of e at s = `to` >= `from` >= 0, where D <= `d`; `None` if the orbit turns before.
fn recede(energy: f64, from: f64, to: f64, d: f64) -> Option<f64> {
    let (from, to) = (Interval::of(from), Interval::of(to));
    let m = if d >= 0.0 { Interval::of(0.5) * (from + to) } else { to };
    exit_energy(energy, to - from, m, d)
}

/// m^2 + x^2 for the largest x >= 0 with x^2 - 2 d h x <= e - m^2; `None` if there is none. An infinite
/// result decides nothing.
fn exit_energy(energy: f64, h: Interval, m: Interval, d: f64) -> Option<f64> {
    let kick = Interval::of(d) * h;
    let gap = Interval::of(energy) - m.square();
    let under = if d >= 0.0 { kick.square() + gap } else { gap };
    if under.hi < 0.0 {
        return None;
    }
    let x = kick + (kick.square() + gap).at_least_zero().sqrt();
    let x = Interval::of(x.hi.max(0.0));
    Some((m.square() + x.square()).hi)
}

#[cfg(test)]
mod tests {
    use crate::landing::speed_bound;
    use crate::test_columns::random_columns;
    use crate::validated::Enclosed;

    #[test]
    fn agrees_with_the_bound_in_double_precision() {
        let mut compared = 0;
        for column in random_columns(2000) {
            let enclosed = Enclosed::of(&column).unwrap();
            for c in [0.0, 0.3] {
                let flow = enclosed.flow(c);
                for strips in [8, 48] {
                    let (here, there) =
                        (flow.speed_squared_bound(strips).sqrt(), speed_bound(&column, c, strips));
                    // The turning points are bounded in two ways, each with an excess of first order in the
                    // strips' width; the rest is the same up to round-off.
                    let slack = 3.0 / f64::from(strips);
                    if there.is_finite() && here.is_finite() && there > 0.0 {
                        compared += 1;
                        let energy = |speed: f64| 1.0 + (speed / column.belt_speed).powi(2);
                        let ratio = energy(here) / energy(there);
                        assert!((ratio - 1.0).abs() < slack, "{column:?} {c} {strips}: {here} {there}");
                    }
                }
            }
        }
        assert!(compared > 1000, "{compared}");
    }
}

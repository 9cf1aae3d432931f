//! Verdicts that are theorems, round-off included.
//!
//! A computer-assisted proof encloses the critical damping C* = eps c* of a column between two numbers; below
//! the lower the orbit from the exit point returns to the belt line, above the upper it does not. A bound on
//! the landing speed, rounded outwards as well, decides whether it sticks.
//!
//! # Statements
//! **Scaling.** With v = x2 / V and s = u / V = 1 - v, equation (H) of [`super`] keeps its form with
//!
//! ```text
//! D(s) = -C + A / (1 + k s)^2 - 2 b s,
//! A = eps gamma (1 - alpha),  k = eps gamma V,  b = eps beta V,  C = eps c,
//! ```
//!
//! because D(u) = eps (-c + gamma (1 - alpha) / (1 + eps gamma u)^2 - 2 beta u) and both sides of dp/ds = D -
//! s/p are unchanged when s and p are measured in units of V. The exit point becomes (1, 0), and the mass
//! sticks iff the scaled landing speed is below 2/V. So C* is a function of A, k and b alone. []
//!
//! **Polar form and sufficiency of one turn.** Put v = r cos theta, x2'/V = -r sin theta, theta from 0. Then
//!
//! ```text
//! dr/dtheta = D r sin^2 / (1 + D sin cos),    dtheta/dt = 1 + D sin cos,    r(0) = 1,
//! ```
//!
//! as v' = w, w' = -v + D w give r dr/dt = v w + w (-v + D w) = D w^2, hence dr/dt = D r sin^2, and
//! r^2 dtheta/dt = w^2 - v w' = r^2 (1 + D sin cos). Where the solution exists up to
//! theta = 2 pi with 1 + D sin cos > 0, it is one turn of the orbit. On (0, pi) the velocity v falls, on
//! (pi, 2 pi) it rises to r(2 pi), so that it passes v = 1, the belt line, before the end of the turn iff
//! r(2 pi) > 1. The law of D at s < 0, above the belt line, does not matter for that: two continuations give
//! the same orbit up to the belt line. If r(2 pi) < 1 the orbit closes a turn inside itself, and since orbits
//! do not cross it never leaves the region that the turn and the segment from (r(2 pi), 0) to (1, 0) bound:
//! one turn decides. []
//!
//! **Monotonicity.** By the comparison lemma of [`super`], which holds for nodes as for foci, the set of C at
//! which the orbit comes back or runs away is an interval unbounded below. If the polar form shows r(2 pi) >
//! 1 at C1 and r(2 pi) < 1 at C2, then at every C <= C1 the orbit comes back unless it runs away, which the
//! bound on the landing speed excludes, and at every C >= C2 it does not. The point's own C need not be in
//! the domain of the polar form: |D| >= 2, where the simulation hands over to another flow, needs no special
//! treatment here. Since D falls with b and, at s >= 0, with k, and rises with A, the same lemma makes C*
//! fall with b and k and rise with A. []
//!
//! **With a drop** j of friction as slip begins the orbit starts at (1, -j/V). For the polar form that is the
//! radius hypot(1, j/V) at the angle atan(j/V), all else stands, and the mass sticks iff the scaled landing speed is
//! below (2 - j)/V. Columns are proved so, of any law; boxes of parameters and the surface of the scaled groups are
//! for laws without a drop.
//!
//! **Enclosure.** See [`Enclosed::critical`] and the source of `validated::defect`: a trigonometric
//! polynomial that nearly solves the polar form, its defect bounded through samples by M. Riesz's inequality,
//! and Gronwall's lemma.
//!
//! **Where the enclosure fails** (strongly varying D), and for all other laws, curves that orbits cross one way prove the
//! claims instead: [`super::curve`], which needs no angle. The even part of D, [`super::symmetric`], is cheaper and
//! often decides: A/(1+k)^2 - 2b <= C* <= (A/2)(1 + 1/(1+2k)^2) - 2b.
//!
//! # Arithmetic
//! `friction::interval::Interval` rounds outwards by one unit in the last place around each operation of
//! plain f64; candidates are sampled over vector lanes, each number with a bound of its error
//! (`defect::Balls`). Sines and cosines are enclosed by half-angle formulas from exact values.

pub(crate) mod barrier;
pub mod boxes;
mod circle;
mod defect;
mod expansion;
pub mod law_boxes;
mod mean;
mod orbit;
pub mod surface;
#[doc(hidden)] // what proofs are made of
pub mod tile;
pub mod volumes;

use super::landing::Flow;
use super::{Claim, Decision, Guarantee, Test, curve};
use defect::{Bounds, Candidates, Groups, Sampled, radius_of_proof, sampling};
use orbit::{Guess, approximate};
use slipmap_model::friction::{Column, Range};
use slipmap_numbers::interval::Interval;

/// The method.
pub static TEST: Test = Test {
    name: "validated",
    long_name: "interval proof of the grazing orbit and of the landing",
    equation: "paper, Proposition 1, by a computer-assisted proof",
    guarantee: Guarantee::Validated,
    first_order: false,
    claims: |columns| columns.iter().map(claim).collect(),
};

/// Number of bisections: `sticks_from` is located to 2^-10 of the interval searched.
const HALVINGS: u32 = 10;

/// A column whose parameters are enclosed in intervals.
#[derive(Clone, Copy, Debug)]
pub struct Enclosed {
    groups: Groups,
    epsilon: Interval,
    belt_speed: Interval,
}

impl Enclosed {
    /// The column, with the roundings of its scaled groups enclosed; `None` for laws other than Stribeck's,
    /// for which see [`curve`].
    #[must_use]
    pub fn of(column: &Column) -> Option<Self> {
        let law = column.curve.stribeck()?;
        // 1 - alpha was rounded once, except for 0 and 1, which are exact.
        let drop = match law.drop {
            0.0 => Interval::ZERO,
            drop => Interval::new(drop.next_down(), drop.next_up().min(1.0)),
        };
        // That of the law; dampings may be in another unit.
        let (own, belt_speed) = (Interval::of(law.epsilon), Interval::of(column.belt_speed));
        let rate = own * Interval::of(law.gamma);
        let groups = Groups {
            a: (rate * drop).at_least_zero(),
            k: (rate * belt_speed).at_least_zero(),
            b: (own * Interval::of(law.beta) * belt_speed).at_least_zero(),
        };
        Some(Self { groups, epsilon: Interval::of(column.epsilon), belt_speed })
    }

    /// The critical damping C* = eps c*, enclosed.
    #[must_use]
    pub fn critical(&self) -> Range {
        let even = even_part_bounds(&self.groups);
        self.proved_critical().map_or(even, |proved| enclosed_by_both(proved, even)).into()
    }

    /// The enclosure by the grazing orbit; `None` where the proof fails.
    fn proved_critical(&self) -> Option<Interval> {
        let middle = |x: Interval| 0.5 * (x.lo + x.hi);
        let Groups { a, k, b } = self.groups;
        let orbit = approximate(Guess { a: middle(a), k: middle(k), b: middle(b) })?;
        let (circle, factors) = sampling(orbit.cosines.len())?;
        let one_lane = |row: &[f64]| row.iter().map(|c| [*c]).collect::<Vec<_>>();
        let candidate = Candidates {
            groups: [self.groups],
            viscous: [Interval::of(orbit.viscous)],
            cosines: &one_lane(&orbit.cosines),
            sines: &one_lane(&orbit.sines),
            error: 0.0,
        };
        let sampled = Sampled::of(&candidate, circle);
        let eta = radius_of_proof(&self.groups, &Bounds::new(&sampled, &factors), circle)?;
        Some(Interval::ball(orbit.viscous, eta))
    }

    fn lands(&self, c: f64) -> bool {
        Flow::new(self.belt_speed, 0.0, self.epsilon * Interval::of(c), highest(&self.groups)).lands()
    }
}

/// The largest weakening rate between two slip speeds in units of the belt speed. It falls with the slip speed.
fn highest(groups: &Groups) -> impl Fn(Interval, Interval) -> f64 {
    let (a, k, b) = (Interval::of(groups.a.hi), Interval::of(groups.k.lo), Interval::of(groups.b.lo));
    move |least, _| {
        let slip = Interval::of(least.lo.max(0.0));
        (a.over((Interval::ONE + k * slip).square()) - (b + b) * slip).hi
    }
}

/// The claim about a column whose critical damping lies in `c`, an end of which is infinite where no bound is
/// proved.
fn claim_of(c: Interval, lands: &dyn Fn(f64) -> bool) -> Claim {
    let landing = || least_proved(lands, [0.0, c.lo], HALVINGS).unwrap_or(f64::INFINITY);
    let sticks_from = if c.lo <= 0.0 { 0.0 } else { landing() };
    Claim { sticks_from, present_below: c.lo, absent_above: c.hi }
}

/// The smallest damping found in a range from which on the landing is proved, by `halvings` bisections;
/// `None` if it is not proved even at the upper end.
fn least_proved(lands: &dyn Fn(f64) -> bool, [lo, hi]: [f64; 2], halvings: u32) -> Option<f64> {
    if lands(lo) {
        return Some(lo);
    }
    if lo == hi || !lands(hi) {
        return None;
    }
    let (mut failed, mut verified) = (lo, hi);
    for _ in 0..halvings {
        let middle = 0.5 * (failed + verified);
        if lands(middle) { verified = middle } else { failed = middle }
    }
    Some(verified)
}

/// Bounds of C* over all groups, by the even part of the divergence.
fn even_part_bounds(groups: &Groups) -> Interval {
    let one = Interval::ONE;
    let Groups { a, k, b } = *groups;
    let near = a.over((one + k).square());
    let far = one.over((one + k + k).square());
    let (lo, hi) = (near - (b + b), Interval::of(0.5) * a * (one + far) - (b + b));
    Interval::new(lo.lo, hi.hi)
}

fn claim(column: &Column) -> Claim {
    let by_curves = || curve::prove(column).claim(column);
    let Some(enclosed) = Enclosed::of(column) else { return by_curves() };
    let even = even_part_bounds(&enclosed.groups);
    // Below zero no legal damping is small enough for a cycle, so a sharper enclosure is not needed.
    let proved = if even.hi < 0.0 { Some(even) } else { enclosed.proved_critical() };
    let critical = proved.map_or(even, |proved| enclosed_by_both(proved, even));
    // Below the lower end, eps c < C*. A failed division gives the whole line, which claims nothing.
    let claim = claim_of(critical.over(enclosed.epsilon), &|c| enclosed.lands(c));
    let is_whole = proved.is_some() && claim.sticks_from < f64::INFINITY;
    if is_whole { claim } else { claim.or(&by_curves()) }
}

/// What two proofs enclose.
fn enclosed_by_both(proved: Interval, even: Interval) -> Interval {
    let both = proved.intersection(even);
    // If the two contradict each other, this is the whole line, which claims nothing.
    Interval::new(both.lo, both.hi)
}

/// The decision of [`TEST`] at the damping `c` >= 0. The even part of the divergence often decides it, far cheaper
/// than the enclosure by the grazing orbit.
pub fn decide(column: &Column, c: f64) -> Decision {
    if let Some(enclosed) = Enclosed::of(column) {
        let bounds = even_part_bounds(&enclosed.groups).over(enclosed.epsilon);
        if c > bounds.hi {
            return Decision::Absent;
        }
        // The claim, too, takes a landing that is proved at c = 0 to be proved at every damping.
        if c < bounds.lo && enclosed.lands(0.0) {
            return Decision::Present;
        }
    }
    claim(column).decide(c)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_columns::{random_columns, stribeck};
    use slipmap_numbers::jet::Real as _;

    /// c* <= c_HB is not a theorem: at k = 56 the orbit returns at c_HB. (Its margin is 2.7e-4 V, far more
    /// than the simulation's error, but this is a proof.)
    #[test]
    fn harmonic_balance_is_exceeded_at_large_k() {
        let enclosed = Enclosed::of(&stribeck(0.79377, 0.32659, 0.0, 9.5262, 7.4949)).unwrap();
        let balance = balance_critical(&enclosed.groups);
        assert!(enclosed.critical().lo > balance.hi);
        // The test can fail: below k = 1 the orbit does not return at c_HB.
        for k in [0.1, 0.3, 0.9] {
            let enclosed = Enclosed::of(&stribeck(k, 0.2, 0.1, 1.0, 1.0)).unwrap();
            assert!(enclosed.critical().hi < balance_critical(&enclosed.groups).lo, "{k}");
        }
    }

    /// C at which energy is balanced over the grazing circle, 2 A / (q (1 + k + q)) - 2 b with q^2 = 1 + 2 k.
    fn balance_critical(groups: &Groups) -> Interval {
        let Groups { a, k, b } = *groups;
        let q = (Interval::ONE + k + k).sqrt();
        (a + a).over(q * (Interval::ONE + k + q)) - (b + b)
    }

    #[test]
    fn odd_divergence_has_an_exact_critical_damping() {
        // Without weakening D = -C - 2 b + 2 b v: C* = -2 b, since the rest is odd.
        for (epsilon, beta, v) in [(0.1, 0.3, 1.0), (0.5, 0.5, 1.5), (0.01, 0.1, 0.2)] {
            let exact = -2.0 * epsilon * beta * v;
            let found = Enclosed::of(&stribeck(epsilon, 1.0, beta, 2.0, v)).unwrap().critical();
            assert!(found.lo <= exact && exact <= found.hi, "{found:?} {exact}");
            // Some tens of roundings, amplified by the samples' factor.
            assert!(found.hi - found.lo < 1e-12 * exact.abs(), "{found:?}");
        }
    }

    #[test]
    fn decisions_are_those_of_the_claim() {
        let mut counts = [0; 3];
        for column in random_columns(60) {
            let claim = claim(&column);
            for share in [0.0, 0.3, 0.9, 0.999, 1.0, 1.001, 1.1, 3.0] {
                let c = share * claim.present_below.max(0.0);
                let decision = decide(&column, c);
                assert_eq!(decision, claim.decide(c), "{column:?} {c}");
                counts[decision as usize] += 1;
            }
        }
        assert!(counts.iter().all(|&count| count > 20), "{counts:?}");
    }

    #[test]
    fn most_columns_are_enclosed_sharply() {
        let (mut sharp, mut all) = (0, 0);
        for column in random_columns(2000) {
            let enclosed = Enclosed::of(&column).unwrap();
            let found = enclosed.critical();
            assert!(found.lo <= found.hi);
            all += 1;
            let groups = enclosed.groups;
            sharp += u32::from(found.hi - found.lo < 1e-10 * groups.a.hi.max(groups.b.hi));
        }
        assert!(10 * sharp > 8 * all, "{sharp} of {all}");
    }
}

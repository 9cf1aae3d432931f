//! A proved upper bound on the speed at which the orbit lands on the belt line.
//!
//! An orbit that comes back to the belt line from below with speed x2' = `wL` lands at x1 = 1 - eps c V -
//! `wL`. The stick segment is |x1 + eps c V| < 1, so that the mass sticks iff 0 < `wL` < 2 (`wL` = 0 is
//! grazing). Faster orbits cross. These tests do not follow them above the belt and claim nothing for them.
//! With a drop j of friction as slip begins it lands at x1 = 1 - eps c V - j - `wL`, and sticks iff `wL` < 2 - j.
//!
//! # The bound
//! In the notation of [`super`], e = s^2 + p^2 obeys de/ds = 2 D p. The turn is cut into strips of s. In
//! each, the slip speed u = V + s or V - s is known exactly, so that D <= d, the upper end of
//! `weakening_range` less eps c. By the comparison lemma the flow with D = d, started from an upper bound
//! of e at the strip's entry, is an upper bound at its exit, and that flow itself is bounded by algebra
//! (`approach`, `recede`). No bound on d is needed, so that nodes are covered. Only the turning point of
//! the lower half plane, which is not known beforehand, is reached with the closed form of the linear flow
//! (`turning_point`): that requires d < 2, and the bound is infinite where it fails.
//!
//! All this is done in units of the belt speed, in which the orbit starts from e = 1 + (j/V)^2: nothing overflows
//! unless the law does. The strips' widths fall linearly towards the turning points, as p does. The bound
//! falls to the landing speed like 1 / strips.
//!
//! # Round-off
//! A strip costs some ten operations on terms not larger than its new e, which is therefore inflated by 16
//! units in the last place, as is the turning point. Slip speeds, and D on them, are taken as computed.
//! That makes the bound a theorem evaluated in double precision, not a validated one. [`super::validated`] evaluates the
//! same formulas in interval arithmetic, for one column or over a box of parameters.

use slipmap_model::friction::Column;
use slipmap_model::point::ScaledGroups;
use slipmap_numbers::jet::Real;
use slipmap_numbers::vectorized;

/// Inflation per strip, 1 + 2^-48.
const INFLATE: f64 = 1.0 + 16.0 * f64::EPSILON;

/// Numbers of strips per quarter turn, tried in this order where the largest divergence alone does not
/// decide; the last gives a bound half a per cent above the landing speed (median of random points).
const REFINEMENTS: [u32; 3] = [2, 8, 48];

/// Share of the interval searched to which `sticks_from` is located.
const SHARPNESS: f64 = 1.0 / 1024.0;

/// Distance of a trial from the ends of the interval and from the root of the secant, as a share of the sharpness:
/// below one half, so that trials on both sides of the root end the search.
const APART: f64 = 0.4;

/// Largest number of dampings tried; four to six are usual.
const MOST_TRIALS: u32 = 30;

/// The smallest damping c >= 0 found at which the landing speed is proved below 2 - j, j the drop of friction as
/// slip begins; by monotonicity it is below at every larger one. Searched in [0, `present_below`]; 0 if that is empty, infinity
/// if the bound fails even at `present_below`. Negative infinity where no presence is claimed anywhere.
pub fn sticks_from(column: &Column, present_below: f64) -> f64 {
    if present_below == f64::NEG_INFINITY {
        return f64::NEG_INFINITY;
    }
    if present_below <= 0.0 {
        return 0.0;
    }
    let mut flow = flow(column, 0.0);
    let mut above = flow.excess();
    if above < 0.0 {
        return 0.0;
    }
    // How far the finest bound exceeds the fastest speed that sticks.
    let mut excess = |c: f64| {
        flow.viscous = column.epsilon * c;
        flow.excess_by(REFINEMENTS[2])
    };
    let mut below = excess(present_below);
    if !(below < 0.0) {
        return f64::INFINITY;
    }
    let (mut failed, mut verified) = (0.0, present_below);
    let sharpness = SHARPNESS * present_below;
    for _ in 0..MOST_TRIALS {
        if verified - failed <= sharpness {
            break;
        }
        // A secant, a little beyond the root so that both ends move; a bisection where the bound is infinite.
        let root = failed + above / (above - below) * (verified - failed);
        let trial = if root.is_nan() { 0.5 * (failed + verified) } else { root + APART * sharpness };
        let trial = trial.clamp(failed + APART * sharpness, verified - APART * sharpness);
        let found = excess(trial);
        // The value at the other end counts half, so that this end does not stay (Illinois).
        if found < 0.0 {
            (verified, below, above) = (trial, found, 0.5 * above);
        } else {
            (failed, above, below) = (trial, found, 0.5 * below);
        }
    }
    verified
}

/// An upper bound of the landing speed at damping `c`, from `strips` >= 1 strips per quarter turn. Infinite
/// where none was found; 0 if the bound shows that the orbit does not return to the belt line.
#[must_use]
pub fn speed_bound(column: &Column, c: f64, strips: u32) -> f64 {
    flow(column, c).speed_bound(strips)
}

/// Upper bounds of the amplitude R, the largest -x2 on the lower half of the first turn, of columns at a damping each,
/// from `strips` >= 1 strips per quarter turn. Infinite where none was found.
///
/// A strip waits for the square root of the one before it, so that a processor does those of several columns in the time
/// of one; those of Stribeck's law in the lanes of its vectors.
#[must_use]
pub fn amplitude_bounds<const N: usize>(columns: [(&Column, f64); N], strips: u32) -> [f64; N] {
    let scaled = |(column, c): &(&Column, f64)| {
        column.curve.stribeck().map(|law| law.scaled(column.belt_speed, column.epsilon * c))
    };
    let scaled: Vec<ScaledGroups> = columns.iter().filter_map(scaled).collect();
    let amplitudes = match <[ScaledGroups; N]>::try_from(scaled) {
        // Stribeck's divergence falls with the slip speed.
        Ok(scaled) => {
            let flows =
                scaled.map(|groups| Flow::new(1.0, 0.0, 0.0, move |least: f64, _| groups.divergence(least)));
            vectorized(
                #[inline(always)]
                || amplitudes(&flows, strips),
            )
        }
        Err(_) => amplitudes(&columns.map(|(column, c)| flow(column, c)), strips),
    };
    std::array::from_fn(|lane| columns[lane].0.belt_speed * amplitudes[lane])
}

/// The lower (x2' < 0) and the upper half plane.
#[derive(Clone, Copy, Debug)]
enum Half {
    Lower,
    Upper,
}

/// The flow below the belt line at one damping; speeds are in units of the belt speed.
pub(crate) struct Flow<W> {
    belt_speed: f64,
    /// The drop j of friction as slip begins.
    drop: f64,
    /// e at the start.
    start: f64,
    /// Upper bound of the weakening rate between two slip speeds.
    highest: W,
    /// eps c.
    viscous: f64,
}

/// The flow of a column in double precision.
fn flow(column: &Column, c: f64) -> Flow<impl Fn(f64, f64) -> f64> {
    let Column { belt_speed, curve, .. } = column;
    let reach = (4.0 * belt_speed).max(belt_speed + 2.0 * belt_speed.hypot(curve.drop()));
    let ranges = curve.ranges(reach);
    let highest = move |least: f64, most: f64| ranges.highest(belt_speed * least, belt_speed * most);
    Flow::new(*belt_speed, curve.drop(), column.epsilon * c, highest)
}

impl<W: Fn(f64, f64) -> f64> Flow<W> {
    /// The flow with these bounds `highest` of the weakening rate between two slip speeds, which may be slightly below 0.
    pub(crate) fn new(belt_speed: f64, drop: f64, viscous: f64, highest: W) -> Self {
        let start = if drop == 0.0 { 1.0 } else { ((drop / belt_speed).powi(2) + 1.0) * INFLATE };
        Self { belt_speed, drop, start, highest, viscous }
    }

    /// How far the bound of the landing speed exceeds the fastest speed that sticks: by the largest divergence or by the
    /// fewest strips that prove the landing, else by the most.
    fn excess(&self) -> f64 {
        let fastest = self.fastest();
        let mut excess = self.constant_bound() - fastest;
        for strips in REFINEMENTS {
            if excess < 0.0 {
                break;
            }
            excess = self.excess_by(strips);
        }
        excess
    }

    fn excess_by(&self, strips: u32) -> f64 {
        self.speed_bound(strips) - self.fastest()
    }

    /// 2 - j.
    fn fastest(&self) -> f64 {
        2.0 - self.drop
    }

    /// An upper bound of the landing speed from the largest divergence `d` alone; infinite where there is none.
    ///
    /// With D <= d on slip speeds up to V + 2 r0, r0 = hypot(V, j), 0 < d < 2, the orbit lies inside that of the flow
    /// with D = d. By de/ds = 2 D p its e rises, so that traced back from the start it meets the axis p = 0 at most r0
    /// from the origin; from there on its radius grows by rho = exp(x / 2), x = pi d / omega, omega = sqrt(1 - d^2/4), in
    /// each half turn, as long as it does not leave those slip speeds: rho <= 2. At the second turning point e is at
    /// most rho^4 r0^2 = r0^2 + (e^(2 x) - 1) r0^2, and e^(2 x) - 1 = tanhx (e^(2 x) + 1). Where d <= 0, e does not rise at
    /// all, and the landing speed is at most j.
    fn constant_bound(&self) -> f64 {
        let [one, start] = [1.0, self.start];
        let reach = one + (2.0) * start.sqrt();
        let d = (self.highest)(0.0, reach) - self.viscous;
        if d <= 0.0 {
            return self.drop;
        }
        let half = 0.5 * d;
        let quarter_turn = (2.0) * one.atan();
        let x = 4.0 * half * quarter_turn / ((one - half) * (one + half)).sqrt();
        // Written so that NaN, from d >= 2 or from a law that overflows, gives no bound.
        if x <= 2.0 * std::f64::consts::LN_2 {
            let growth = x.tanh() * ((x + x).exp() + one) * start;
            ((self.belt_speed.squared() * growth + self.drop.squared()) * INFLATE).sqrt()
        } else {
            f64::INFINITY
        }
    }

    /// See [`speed_bound`].
    pub(crate) fn speed_bound(&self, strips: u32) -> f64 {
        let [amplitude] = amplitudes(std::array::from_ref(self), strips);
        if !amplitude.is_finite() {
            return f64::INFINITY;
        }
        let energy = (amplitude).squared();
        let [at_axis] = to_axis(std::array::from_ref(self), Half::Upper, [amplitude], [energy], strips);
        match self.axis_to_belt(at_axis, strips) {
            None => 0.0,
            Some(energy) if energy.is_nan() => f64::INFINITY,
            Some(energy) => {
                let excess = (energy - 1.0).max(0.0);
                self.belt_speed * excess.sqrt()
            }
        }
    }

    /// Upper bound of D between s = `from` and s = `to` > `from`.
    #[inline(always)]
    fn divergence_bound(&self, half: Half, from: f64, to: f64) -> f64 {
        let [one, from, to] = [1.0, from, to];
        let (least, most) = match half {
            Half::Lower => (one + from, one + to),
            Half::Upper => (one - to, one - from),
        };
        (self.highest)(least, most) - self.viscous
    }

    /// Second quarter of the upper half: upper bound of e at the belt line, s = 1; `None` if the orbit turns
    /// before.
    fn axis_to_belt(&self, at_axis: f64, strips: u32) -> Option<f64> {
        let mut energy = at_axis;
        let mut s = 0.0;
        for i in 1..=strips {
            let tau = f64::from(strips - i) / f64::from(strips);
            let next = 1.0 - tau * tau;
            energy = recede(energy, s, next, self.divergence_bound(Half::Upper, s, next))?;
            s = next;
        }
        Some(energy)
    }
}

/// Upper bounds of the turning points of the lower half plane.
#[inline(always)]
fn amplitudes<W: Fn(f64, f64) -> f64, const N: usize>(flows: &[Flow<W>; N], strips: u32) -> [f64; N] {
    let start = std::array::from_fn(|lane| flows[lane].start);
    axis_to_turning(flows, to_axis(flows, Half::Lower, [1.0; N], start, strips), strips)
}

/// First quarter of each half: upper bounds of e at s = 0 on the orbits from s = -`start`, where it is `energy`.
#[inline(always)]
fn to_axis<W: Fn(f64, f64) -> f64, const N: usize>(
    flows: &[Flow<W>; N],
    half: Half,
    start: [f64; N],
    mut energy: [f64; N],
    strips: u32,
) -> [f64; N] {
    assert!(strips > 0);
    let mut s = start.map(|start| -start);
    for i in 1..=strips {
        let tau = f64::from(i) / f64::from(strips);
        for lane in 0..N {
            let next = -start[lane] * (1.0 - tau * tau);
            let d = flows[lane].divergence_bound(half, s[lane], next);
            energy[lane] = approach(energy[lane], s[lane], next, d);
            s[lane] = next;
        }
    }
    energy
}

/// Second quarter of the lower half: upper bounds of the turning points.
#[inline(always)]
fn axis_to_turning<W: Fn(f64, f64) -> f64, const N: usize>(
    flows: &[Flow<W>; N],
    at_axis: [f64; N],
    strips: u32,
) -> [f64; N] {
    // At s = 0, e = p^2. Without divergence the orbit would turn at s = p, which sets the scale.
    let scale = at_axis.map(|energy| energy.sqrt());
    let (mut energy, mut s) = (at_axis, [0.0; N]);
    // Orbits whose bounds are finite and that do not turn in an earlier strip.
    let mut goes_on = scale.map(f64::is_finite);
    for i in 1..strips {
        let tau = f64::from(strips - i) / f64::from(strips);
        for lane in 0..N {
            let next = scale[lane] * (1.0 - tau * tau);
            if goes_on[lane] {
                let d = flows[lane].divergence_bound(Half::Lower, s[lane], next);
                match recede(energy[lane], s[lane], next, d) {
                    Some(after) => (energy[lane], s[lane]) = (after, next),
                    None => goes_on[lane] = false,
                }
            }
        }
    }
    std::array::from_fn(|lane| {
        let s = s[lane];
        let divergence_bound = |trial| flows[lane].divergence_bound(Half::Lower, s, trial);
        if scale[lane].is_finite() { turning_point(energy[lane], s, divergence_bound) } else { f64::INFINITY }
    })
}

/// Upper bound of the turning point of a lower half orbit that passes `s` >= 0 with e <= `energy`, where
/// `divergence_bound` bounds D from `s` to the reach that it is given.
///
/// If D <= 0 up to sqrt(e), e falls and the orbit turns before. Otherwise let D <= d < 2 up to
/// some trial reach. The flow with D = d multiplies q = s^2 - d s p + p^2 by e^(d t), turns at time t
/// = angle / omega, omega = sqrt(1 - d^2/4), and its turning point sqrt(q) e^(d t / 2) is a bound if D <= d up to it.
fn turning_point(energy: f64, s: f64, divergence_bound: impl Fn(f64) -> f64) -> f64 {
    let unforced = energy.sqrt();
    let squared = energy - s.squared();
    if squared < 0.0 {
        // By the bound the orbit does not reach `s`.
        return s;
    }
    let (s, p) = (s, squared.sqrt());
    let mut trial = unforced;
    for _ in 0..8 {
        let d = divergence_bound(trial);
        if d <= 0.0 {
            return unforced * INFLATE;
        }
        if !(d < 2.0) {
            return f64::INFINITY;
        }
        let (half, one) = (0.5 * d, 1.0_f64);
        let omega = ((one - half) * (one + half)).sqrt();
        // The angle from the point to the turning point: a quarter less that whose tangent is x / y.
        let angle = 2.0 * one.atan() - ((s - half * p) / (omega * p)).atan();
        let q = s.squared() - d * s * p + p.squared();
        let turning = (q.sqrt() * (half * angle / omega).exp()) * INFLATE;
        if turning <= trial || turning.is_finite() && divergence_bound(turning) <= d {
            return turning;
        }
        trial = turning + 0.5 * (turning - trial);
    }
    f64::INFINITY
}

/// Bounds e = s^2 + p^2 at s = `to` in (`from`, 0], given its upper bound `energy` at s = `from` < 0 and D <=
/// `d` between.
///
/// Consider the solution with D = d. By de/ds = 2 d p, e(to) = e + 2 d times the integral of
/// p = sqrt(e(s) - s^2). Let h = to - from.
///
/// d >= 0: e(s) <= e(to), and sqrt(e(to) - s^2) is concave, so that its mean is at most its value at the
/// middle, m. With x = sqrt(e(to) - m^2): x^2 - 2 d h x <= e - m^2.
///
/// d < 0: e(s) >= e(to), so that p >= x = sqrt(e(to) - m^2) with m the farther end, m = from, and the same
/// inequality holds; if e(to) < m^2, the bound below holds trivially.
///
/// In both cases e(to) = m^2 + x^2 with x <= d h + sqrt((d h)^2 + e - m^2). Here e >= m^2 up to round-off.
#[inline(always)]
fn approach(energy: f64, from: f64, to: f64, d: f64) -> f64 {
    if cfg!(any(test, debug_assertions)) {
        assert!(from <= to && to <= 0.0);
    }
    let [energy, from, to] = [energy, from, to];
    let m = if d >= 0.0 { (0.5) * (from + to) } else { from };
    let gap = energy - m.squared();
    exit_energy(d * (to - from), if gap < 0.0 { 0.0 } else { gap }, m)
}

/// Bounds e at s = `to` > `from` >= 0 as [`approach`] does. The farther end is `to`, and e >= m^2 need not
/// hold: `None` if no x >= 0 satisfies the inequality, which means that the orbit turns before `to`.
#[inline(always)]
fn recede(energy: f64, from: f64, to: f64, d: f64) -> Option<f64> {
    if cfg!(any(test, debug_assertions)) {
        assert!(0.0 <= from && from <= to);
    }
    let [energy, from, to] = [energy, from, to];
    let kick = d * (to - from);
    let m = if d >= 0.0 { (0.5) * (from + to) } else { to };
    let gap = energy - m.squared();
    let rest = if d >= 0.0 { kick.squared() + gap } else { gap };
    if rest < 0.0 { None } else { Some(exit_energy(kick, gap, m)) }
}

/// m^2 + x^2 with x = kick + sqrt(kick^2 + gap) >= 0, inflated.
#[inline(always)]
fn exit_energy(kick: f64, gap: f64, m: f64) -> f64 {
    let under = kick.squared() + gap;
    let x = kick + under.sqrt();
    // Written so that a NaN passes through and becomes a failed bound.
    let x = if x < 0.0 { 0.0 } else { x };
    (m.squared() + x.squared()) * INFLATE
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_columns::{random_columns, stribeck};

    /// With V this small eps gamma V is below round-off and D = eps gamma (1 - alpha) - eps c is constant.
    const TINY_BELT: f64 = 1e-18;

    /// Integrates s' = p, p' = D p - s from (`s`, `p`) until `done` is true, by the classical Runge-Kutta
    /// method.
    fn integrate(
        (column, viscous): (&Column, f64),
        half: Half,
        state: (f64, f64),
        done: impl Fn(f64, f64) -> bool,
    ) -> (f64, f64) {
        let rate = |s: f64, p: f64| {
            let u = match half {
                Half::Lower => 1.0 + s,
                Half::Upper => 1.0 - s,
            };
            let d = column.curve.weakening(column.belt_speed * u) - viscous;
            (p, d * p - s)
        };
        let step = |(s, p): (f64, f64), h: f64| {
            let (a, b) = rate(s, p);
            let (c, d) = rate(s + 0.5 * h * a, p + 0.5 * h * b);
            let (e, f) = rate(s + 0.5 * h * c, p + 0.5 * h * d);
            let (g, i) = rate(s + h * e, p + h * f);
            (s + h / 6.0 * (a + 2.0 * c + 2.0 * e + g), p + h / 6.0 * (b + 2.0 * d + 2.0 * f + i))
        };
        let (mut state, mut h) = (state, 1e-3);
        while h > 1e-15 {
            let next = step(state, h);
            if done(next.0, next.1) {
                h *= 0.5;
            } else {
                state = next;
            }
        }
        state
    }

    /// Each quarter is tested by itself, so that slack in one cannot hide an error in another.
    #[test]
    fn every_quarter_is_bounded_and_the_bound_is_sharp() {
        // Laws that weaken fast: D changes most where the slip speed is least.
        for (gamma, c) in [(1.0, 0.1), (4.0, 0.0), (10.0, 0.2), (40.0, 0.5)] {
            let column = stribeck(1.0, 0.5, 0.01, gamma, 1.0);
            let flow = flow(&column, c);
            let exact = (&column, c);
            let energy = |(s, p): (f64, f64)| s * s + p * p;
            let check = |name: &str, exact: f64, bound: &dyn Fn(u32) -> f64| {
                let [coarse, fine, finest] = [16, 512, 1024].map(|strips| bound(strips) - exact);
                // The integration's error is a thousandth of the step to the fourth power.
                assert!(coarse >= 0.0 && fine >= 0.0 && finest > -1e-12, "{name}, gamma = {gamma}: {fine}");
                // First order in the strips' width; where D < 0 throughout, up to the inflation.
                assert!(finest <= 0.55 * fine + 1e-11 * exact, "{name}, gamma = {gamma}: {fine} {finest}");
            };
            for (half, start) in [(Half::Lower, 1.0), (Half::Upper, 1.5)] {
                let end = integrate(exact, half, (-start, 0.0), |s, _| s > 0.0);
                check("to the axis", energy(end), &|strips| {
                    to_axis(std::array::from_ref(&flow), half, [start], [start * start], strips)[0]
                });
            }
            let turn = integrate(exact, Half::Lower, (0.0, 1.5), |_, p| p < 0.0);
            check("to the turning point", turn.0, &|strips| {
                axis_to_turning(std::array::from_ref(&flow), [2.25], strips)[0]
            });
            let belt = integrate(exact, Half::Upper, (0.0, 1.5), |s, _| s > 1.0);
            check("to the belt line", energy(belt), &|strips| {
                flow.axis_to_belt(2.25, strips).expect("it arrives")
            });
        }
    }

    /// The first turning point that its own bound covers is told: what the bound is beyond does not matter.
    #[test]
    fn a_turning_point_within_its_bound_is_the_least() {
        let least = turning_point(2.25, 0.0, |_| 0.5);
        assert!(least > 1.5);
        assert_eq!(turning_point(2.25, 0.0, |s| if s <= least { 0.5 } else { 1.5 }), least);
    }

    /// With so slow a belt D is a constant, gamma - c: an unstable node from D = 2 on, whose orbits never turn, and
    /// damped so much below -1.5 that no orbit returns. Squares of the slowest belts are not representable.
    #[test]
    fn bounds_at_the_ends_of_the_domain() {
        let linear = |gamma: f64, belt_speed: f64| stribeck(1.0, 0.0, 0.0, gamma, belt_speed);
        // eps gamma overflows, and D(0) = infinity - c.
        let overflowing = stribeck(10.0, 0.5, 0.5, 1e308, 1.0);
        let (steep, flat) = (linear(3.0, TINY_BELT), linear(1.0, TINY_BELT));
        for (column, c, bound) in [
            (&steep, 0.0, f64::INFINITY),
            (&steep, 1.0, f64::INFINITY),
            (&flat, 2.5, 0.0),
            (&flat, 10.0, 0.0),
            (&overflowing, 0.1, f64::INFINITY),
        ] {
            assert_eq!(speed_bound(column, c, 32), bound, "{column:?} {c}");
        }
        assert!(speed_bound(&steep, 1.5, 32) < 2.0);
        let from = sticks_from(&steep, 3.0);
        assert!(from > 1.0 && from < 1.5, "{from}");
        assert_eq!((sticks_from(&overflowing, 0.1), sticks_from(&flat, -1.0)), (f64::INFINITY, 0.0));
        let at = |v: f64| speed_bound(&linear(1.0, v), 0.5, 16) / v;
        let expected = at(TINY_BELT);
        assert!(expected > 1.0);
        for v in [1e-300, 1e-200] {
            assert!((at(v) / expected - 1.0).abs() < 64.0 * (INFLATE - 1.0));
        }
    }

    #[test]
    fn the_bound_of_the_largest_divergence_is_one() {
        let mut settled = 0;
        for column in random_columns(2000) {
            for c in [0.0, 0.3] {
                let crude = flow(&column, c).constant_bound();
                if crude.is_finite() {
                    // The strips end above the landing speed, so a valid bound may be below theirs: the less,
                    // the finer they are.
                    let fine = speed_bound(&column, c, 2048);
                    // Where e does not rise, the inflation of 6144 strips is left: 1e-11 of e, 1e-5 of a
                    // speed.
                    let slack = 1e-5 * column.belt_speed;
                    assert!(crude + slack >= 0.999 * fine, "{column:?} {c}: {crude} {fine}");
                    settled += u32::from(crude < 2.0);
                }
            }
        }
        assert!(settled > 300, "{settled}");
        // D constant: exact up to the turning point. D = 1, also 2 V away from the belt.
        assert_eq!(flow(&stribeck(1.0, 0.0, 0.0, 3.0, TINY_BELT), 0.5).constant_bound(), f64::INFINITY);
    }
}

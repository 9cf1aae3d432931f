//! Where all loops far beyond the exit point lead.
//!
//! Lemmas 1 to 3 of the theory, "Any friction law", with its names: friction with the viscous force,
//! psi(u) = phi(u) + C u, never pushes, pushes at some slip speeds, or pushes for ever. Its bounds are -P and M, and
//! loops begin y beyond the exit point.
//!
//! A drop j of friction as slip begins is in none of these: x1 at a downward crossing is 1 + y with any j.
//!
//! The bounds of psi that they take come from ranges of friction that are partly sampled, see
//! [`Curve::friction_by_intervals`]: so what this module tells of a law that may push is no theorem.
//!
//! Since loops fall with the damping, those that lead inward at one damping do so at all larger ones.

use slipmap_model::friction::{Curve, NOT_NEGATIVE, Pieces, Range};
use slipmap_numbers::TimesPlus as _;
use slipmap_numbers::interval::Interval;

/// The refinement of a bound ends after a step that leaves more than this share of it.
const WORTHWHILE: f64 = 0.8;

/// Distances greater than this, in units of max(1, V), are of no use: no loop is followed so far out, where it
/// would change by less than its error.
const FARTHEST: f64 = 1e10;

/// Relative accuracy of the slip speed from which on friction pushes.
const RESOLVED: f64 = 1e-6;
/// Number of samples of an interval that bounds leave open.
const SAMPLES: u32 = 256;

/// The friction of a curve far out, for all dampings.
pub struct FarLoops<'a> {
    curve: &'a Curve,
    belt_speed: f64,
    /// The slip speed from which on friction pushes, where loops that reach it are left out.
    left_out_from: Option<f64>,
    /// The distance from which on loops lead inward at every damping, if friction pushes nowhere or is left out
    /// where it does.
    settled: Option<f64>,
    /// Ranges of phi on intervals of slip speed, partly sampled, where friction may push.
    intervals: Vec<([f64; 2], Range)>,
}

/// The slip speeds below U and those above it.
struct Parts {
    /// U.
    from: f64,
    /// Range of psi up to U.
    near: Range,
    /// Range of psi from U on.
    far: Range,
}

impl<'a> FarLoops<'a> {
    /// The far loops of all dampings of one curve and belt speed.
    pub fn new(curve: &'a Curve, belt_speed: f64) -> Self {
        let unit = belt_speed.max(1.0);
        let mut intervals =
            if curve.is_proved_to_resist() { Vec::new() } else { curve.friction_by_intervals(unit) };
        // Friction pushes at no slip speed by its bounds, or by these ranges, which are partly samples.
        let never = intervals.iter().all(|(_, range)| range.lo >= NOT_NEGATIVE);
        let settled = never.then(|| settled(curve, belt_speed, curve.fastest()));
        if never {
            intervals.clear();
        }
        Self { curve, belt_speed, left_out_from: None, settled, intervals }
    }

    /// As [`Self::new`] for the loops that stay at slip speeds below the first at which friction pushes. Few machines
    /// have friction that does: mostly a formula was fitted at lower speeds.
    pub fn where_friction_resists(curve: &'a Curve, belt_speed: f64) -> Self {
        let left_out_from = pushes_from(curve, belt_speed.max(1.0));
        let known = left_out_from.map_or(curve.fastest(), |from| from.min(curve.fastest()));
        let settled = Some(settled(curve, belt_speed, known));
        Self { curve, belt_speed, left_out_from, settled, intervals: Vec::new() }
    }

    /// The slip speed from which on friction pushes, if loops that reach it are left out.
    pub fn left_out_from(&self) -> Option<f64> {
        self.left_out_from
    }

    /// Whether loops may lead outward that are followed only as long as they do not reach friction that pushes.
    pub fn is_cut_short(&self) -> bool {
        let largest = |from| farthest(from, self.belt_speed);
        self.left_out_from.is_some_and(|from| self.settled.is_some_and(|settled| settled >= largest(from)))
    }

    /// Returns whether friction may push at some slip speeds of the loops.
    pub fn may_push(&self) -> bool {
        self.settled.is_none()
    }

    /// The distance y beyond the exit point from which on loops lead inward at eps c = `viscous` and above,
    /// among the loops small enough for the data of a table. It is 0 where no orbit crosses the belt line for
    /// ever, and infinite where no distance is known.
    pub fn inward_from(&self, viscous: f64) -> f64 {
        if let Some(settled) = self.settled {
            return settled;
        }
        let psi = self.psi(viscous);
        let never = psi.iter().all(|(_, range)| range.lo >= 0.0);
        let bound = match never {
            true => {
                let highest = self.curve.friction_range(self.belt_speed, Pieces::Octaves).hi;
                without_pushing(highest + viscous * self.belt_speed, self.belt_speed)
            }
            false => self.least(&psi, |parts| self.inward(parts)),
        };
        let bound = if bound <= FARTHEST * self.belt_speed.max(1.0) { bound } else { f64::INFINITY };
        bound.min(farthest(self.curve.fastest(), self.belt_speed))
    }

    /// The distance y beyond the exit point from which on orbits come back farther out, or not at all;
    /// infinite where no distance is known.
    pub fn outward_from(&self, viscous: f64) -> f64 {
        self.least(&self.psi(viscous), |parts| self.outward(parts))
    }

    /// Ranges of phi + C u on the intervals. Where those of the two terms leave the sign open, phi falls
    /// about as fast as C u rises, and the sum is bounded on parts of the interval.
    fn psi(&self, viscous: f64) -> Vec<(f64, Range)> {
        let bounds = self.intervals.iter().map(|&([from, to], phi)| {
            let apart = Range { lo: viscous.times_plus(from, phi.lo), hi: viscous.times_plus(to, phi.hi) };
            let open = apart.lo < 0.0 && apart.hi > 0.0 && viscous > 0.0 && from < to;
            (from, if open { self.curve.friction_between(from, to, viscous) } else { apart })
        });
        bounds.collect()
    }

    /// The least of the distances that `bound` finds for the slip speeds U at which intervals end. Laws that
    /// are known up to a slip speed only have none.
    fn least(&self, psi: &[(f64, Range)], bound: impl Fn(&Parts) -> Option<f64>) -> f64 {
        if self.curve.fastest() < f64::INFINITY {
            return f64::INFINITY;
        }
        let hull = |of: &[(f64, Range)]| of.iter().map(|(_, range)| *range).fold(Range::EMPTY, Range::hull);
        let bounds = (1..psi.len()).filter(|at| psi[*at].0 >= self.belt_speed).filter_map(|at| {
            let (near, far) = psi.split_at(at);
            bound(&Parts { from: psi[at].0, near: hull(near), far: hull(far) })
        });
        bounds.fold(f64::INFINITY, f64::min)
    }

    fn inward(&self, &Parts { from, near, far }: &Parts) -> Option<f64> {
        let [width, rest] = self.areas(from);
        let (most, push) = (near.hi.max(1.0), (-near.lo).max(0.0));
        let square = (most * self.belt_speed.powi(2) + 2.0 * push * (width + rest)) / (2.0 * far.lo);
        (far.lo > 0.0).then(|| square.max(4.0 / 3.0 * width).sqrt() + most + 3.0 * push - 1.0)
    }

    fn outward(&self, &Parts { from, near, far }: &Parts) -> Option<f64> {
        let [width, rest] = self.areas(from);
        let (most, push) = (near.hi.max(1.0), (-near.lo).max(0.0));
        let square = (1.75 * push * self.belt_speed.powi(2) + 2.0 * most * (width + rest)) / -far.hi;
        (far.hi < 0.0).then(|| square.max(4.0 * width).max(9.0).sqrt() + 2.0 * most.max(push) - 1.0)
    }

    /// G and (U - V)^2.
    fn areas(&self, from: f64) -> [f64; 2] {
        [from * (2.0 * self.belt_speed + from), (from - self.belt_speed).powi(2)]
    }
}

/// Largest distance beyond the exit point from which orbits stay below the slip speed `fastest`.
fn farthest(fastest: f64, belt_speed: f64) -> f64 {
    // From y beyond the exit point orbits stay within about hypot(y, V) + 2 of the lower centre.
    let radius = fastest - belt_speed - 2.0;
    if radius == f64::INFINITY {
        f64::INFINITY
    } else if radius > belt_speed {
        ((radius - belt_speed) * (radius + belt_speed)).sqrt()
    } else {
        0.0
    }
}

/// The bound for friction between 0 and `highest` up to V.
fn without_pushing(highest: f64, belt_speed: f64) -> f64 {
    let most = highest.max(1.0);
    most - 1.0 + 2.0 * (3_f64.sqrt() * belt_speed).hypot(2_f64.sqrt() * most)
}

/// The distance y beyond the exit point from which on loops lead inward at every damping c >= 0, for friction
/// that never pushes. It is 0 where no orbit crosses the belt line for ever.
///
/// Besides the bound of Lemma 1: let phi >= 1 - W at all slip speeds, and phi <= 1 + d up to V. Then y is
/// at most the root of (2 - W + d) (y + 2 - W) = (W + d) (hypot(y, V) + 2 d + W), and 0 if the left side is
/// larger at y = 0. For a law that only weakens, 0 if W V < 4 (1 - W).
///
/// The proof is that of Theorem 4 (theory): its second integral is at most W L + d (L - s) here, and by the energy
/// L <= 2 (hypot(y, V) + 2 d + W). So (2 - W + d) s <= (W + d) L with s >= 2 (y + 2 - W).
///
/// With a drop j the statement holds in units of the friction 1 - j at the onset of slip, in which velocities
/// and distances are larger by 1 / (1 - j), and for the distance (y + j) / (1 - j) from the point where friction
/// in slip would be exhausted.
///
/// Loops from less than y stay at slip speeds up to V + hypot(y, V) + 6 (W + d), by the same energy; W of
/// these slip speeds alone may give a smaller y. Of the loops that stay below the slip speed `known` the statement holds
/// if friction pushes nowhere below it.
fn settled(curve: &Curve, belt_speed: f64, known: f64) -> f64 {
    let onset = 1.0 - curve.drop();
    let farthest = farthest(known, belt_speed);
    let known = known / onset;
    let belt_speed = belt_speed / onset;
    let friction = |fastest: f64, pieces| {
        let Range { lo, hi } = curve.friction_range(fastest * onset, pieces);
        Range { lo: lo / onset, hi: hi / onset }
    };
    let highest = |pieces| friction(belt_speed.min(known), pieces).hi.max(1.0);
    let bound = |pieces| without_pushing(highest(pieces), belt_speed).min((farthest + curve.drop()) / onset);
    let mut settled = bound(Pieces::One);
    if settled == f64::INFINITY {
        settled = bound(Pieces::Octaves);
    }
    for pieces in [Pieces::One, Pieces::Octaves, Pieces::Octaves, Pieces::Octaves, Pieces::Octaves] {
        if settled == 0.0 {
            break;
        }
        let rise = highest(pieces) - 1.0;
        let fastest = (belt_speed + settled.hypot(belt_speed) + 6.0 * (1.0 + rise)).min(known);
        let fall = (1.0 - friction(fastest, pieces).lo).max(0.0);
        let before = settled;
        settled = settled.min(root_of_bounds(fall, rise, belt_speed));
        if pieces == Pieces::Octaves && settled > WORTHWHILE * before {
            break;
        }
    }
    (settled * onset - curve.drop()).max(0.0)
}

/// The root of [`settled`]; infinite where there is none, or a bound is missing.
fn root_of_bounds(fall: f64, rise: f64, belt_speed: f64) -> f64 {
    if !(fall < 1.0 && rise.is_finite()) {
        return f64::INFINITY;
    }
    // p y + k = q hypot(y, V), p > q > 0.
    let (p, q) = (2.0 - fall + rise, fall + rise);
    let k = p * (2.0 - fall) - q * (2.0 * rise + fall);
    if k > q * belt_speed {
        return 0.0;
    }
    let square = (p - q) * (p + q);
    let root = q * k.hypot(square.sqrt() * belt_speed);
    if k > 0.0 {
        (q * belt_speed - k) * (q * belt_speed + k) / (p * k + root)
    } else {
        (root - p * k) / square
    }
}

/// The slip speed from which on friction pushes for the first time, by samples where the ranges of
/// [`Curve::friction_by_intervals`] leave it open; `None` where none is found.
fn pushes_from(curve: &Curve, unit: f64) -> Option<f64> {
    if curve.is_proved_to_resist() {
        return None;
    }
    // Where large terms cancel a value of any sign may be rounding alone.
    let may_resist = |phi: Interval| phi.is_bounded() && phi.hi >= NOT_NEGATIVE;
    let resists =
        |u: f64| curve.phi(u) >= NOT_NEGATIVE || curve.formula(Interval::of(u)).is_some_and(may_resist);
    let open = curve.friction_by_intervals(unit).into_iter().filter(|(_, range)| range.lo < NOT_NEGATIVE);
    for ([from, to], _) in open {
        let place = |i: u32| (to - from).times_plus(f64::from(i) / f64::from(SAMPLES), from);
        if let Some(first) = (0..=SAMPLES).find(|i| !resists(place(*i))) {
            let (mut low, mut high) = (place(first.saturating_sub(1)), place(first));
            while high - low > RESOLVED * high {
                let middle = 0.5 * (low + high);
                *(if resists(middle) { &mut low } else { &mut high }) = middle;
            }
            return Some(high);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::filippov::Oscillator;
    use slipmap_model::friction::{Expression, Law};

    /// A law that is constant far out, of terms that cancel: at u = 7e16 their rounding is of the size of 10, of any sign.
    #[test]
    fn rounding_of_terms_that_cancel_is_no_push() {
        for (text, pushes) in
            [("1 - 0.3*u + 0.3*abs(u-0.8) - 0.24", false), ("1 - 0.3*u + 0.2*abs(u-0.8) - 0.16", true)]
        {
            let law = Law::Expression(Expression::new(text, 1.0).unwrap());
            let column = law.column(&law.point(1.0, &[], 0.1, 0.0).unwrap());
            let left_out = FarLoops::where_friction_resists(&column.curve, 0.1).left_out_from();
            // 1 - 0.1 u - 0.32 from 0.8 on.
            assert_eq!(left_out.is_some_and(|from| (from / 6.8 - 1.0).abs() < 1e-5), pushes, "{left_out:?}");
            assert_eq!(left_out.is_some(), pushes);
        }
    }

    /// Formulas whose terms cancel have wide bounds on the narrowest intervals; nothing is claimed of them then.
    #[test]
    fn formulas_that_cancel_are_bounded_on_a_small_stack() {
        let bounded = || {
            for phi in [
                "0.5+0.5*exp(-u)+(u+1e5)^3-u^3-1e5^3",
                "(1e16+1)-1e16+0.5+0.5*exp(-u)",
                "0.5+0.5*exp(-u)+sin(1e20+u)-sin(1e20+u)",
                "0.5+0.5*exp(-u)+(1e300*u-1e300*u)",
            ] {
                let law = Law::Expression(Expression::new(phi, 1.0).unwrap());
                let point = law.point(1.0, &[], 1.0, 0.05).unwrap();
                let oscillator = Oscillator::new(&law, &point);
                let far = FarLoops::new(&oscillator.curve, 1.0);
                assert!(far.may_push(), "{phi}");
                assert!(far.outward_from(0.0) == f64::INFINITY, "{phi}: {}", far.outward_from(0.0));
            }
        };
        std::thread::Builder::new().stack_size(512 * 1024).spawn(bounded).unwrap().join().unwrap();
    }
}

//! The damping at which an orbit closes, from its two halves: for laws that fall steeply next to the belt line, and
//! for friction that drops as slip begins. The polar angle of such an orbit is not monotone in time, or hardly so.
//!
//! The orbit that starts at (x2, x2') = (`radius`, -j) and ends at the maximum `radius` of x2 is followed from both ends
//! to its lowest point, forward and backward in time. With s = 1 forward and -1 backward, W = |x2'| and the slip speed
//! u = V - x2, either half obeys, while x2 > 0 and u rises from its least value u0 = V - radius,
//!
//! ```text
//! dW/du = s D(u) + (V - u)/W,    W(u0) = j forward and 0 backward,    D = w(u) - C
//! ```
//!
//! so that the distance of two solutions at the same slip speed never grows: both halves are stable, however steep
//! the law. Forward alone the end of the orbit is not: where friction is steep, it creeps up to the belt line along an
//! unstable curve of equilibria. The state is the energy beyond that of the start, h = (x2^2 + W^2 - radius^2)/2,
//! with its derivative by C:
//!
//! ```text
//! dh/dt = s D W^2,    d(dh/dC)/dt = s (D dh/dC - W^2),    t the time along the half
//! ```
//!
//! up to the lowest point, which is at x2 = -R, R^2 = radius^2 + 2 h. The orbit closes where both halves have the same R
//! there. Newton's method for ln R, which is nearly linear in C as that of linear orbits is, needs the derivative at
//! fixed slip speed alone, because h is stationary in u at the lowest point.
//!
//! **Steps.** The variable is the angle th of u = u0 + radius (1 - cos th) while x2 > 0, in which W is smooth at the
//! start, then the polar angle. Steps grow in geometric progression out of the layer in which the law is steep: their number grows like the
//! logarithm of its width.
//!
//! **The creeping end.** Where -s D is large, W follows (u - V)/(s D), and forgets its start. The half starts so late
//! that it forgets this start as far as the tolerance needs, and early steps are not stiff; but not where braking has not
//! yet taken away the speed with which it came.
//!
//! **Error.** The sum of the local error estimates of h, each carried to the lowest point by the exponential of
//! the integral of s D over the time between (Liouville's formula, at fixed u): an error e of h is one of 2 e/R^2 of ln R^2,
//! divided by the derivative of that by C.

mod half;
mod lanes;

use std::borrow::Cow;
use std::sync::Arc;

use super::polar::Closing;
use super::work::Work;
use half::{Half, Orbit, Rate, layer};
use lanes::{Lowest, follow};
use slipmap_model::friction::{Curve, Weakening};
use slipmap_numbers::vectorized;

/// Error of C of the first orbits, which only lead near a root, in units of C.
const ROUGH: f64 = 1e-5;
/// Largest tolerance: of 3,600 coarser orbits two had an error of twice the estimate.
const COARSEST: f64 = 1e-9;
/// Change of C, in units of C and of the fourth root of the tolerance, after which the next orbit is usually the last one.
/// For 12,000 falls of widths from 1e-6 to 0.1 a factor of 5 took up to a fifth more work than 20, one of 60 a tenth.
const NEARLY: f64 = 20.0;
/// Least distance, in units of C, from an orbit that does not turn to one that may.
const NEAREST_RETREAT: f64 = 0.02;
/// Largest number of orbits in the search for a root; three are usual.
const MOST_ORBITS: u32 = 40;
/// Safety factor of the error left by a step of Newton's method.
const CURVATURE: f64 = 4.0;
/// Error of a law's polynomials, in units of the size of C, above which orbits follow the law itself.
const WORST: f64 = 1e-8;
/// Distance of the bounds of a search from the mean weakening rate where nothing proves bounds, absolute and relative.
pub(super) const WIDE: f64 = 4.0;

/// An orbit whose C is sought: a column's law, and the maximum of x2 at which the orbit closes.
#[derive(Clone, Copy)]
pub(super) struct Sought<'a> {
    curve: &'a Curve,
    belt_speed: f64,
    radius: f64,
    /// -x2' at the start.
    drop: f64,
    layer: Option<f64>,
    /// C at which the search begins, and its bounds.
    start: f64,
    bounds: [f64; 2],
}

impl<'a> Sought<'a> {
    /// The orbit from the exit point, where friction drops as slip begins or falls so steeply that the polar angle is not
    /// monotone; `None` elsewhere. The search begins at `start` and stays within bounds.
    pub(super) fn from_exit(
        curve: &'a Curve,
        belt_speed: f64,
        start: impl FnOnce() -> f64,
        bounds: impl FnOnce() -> [f64; 2],
    ) -> Option<Self> {
        let (layer, drop) = (layer(curve, belt_speed, belt_speed), curve.drop());
        if layer.is_none() && drop == 0.0 {
            return None;
        }
        Some(Self { curve, belt_speed, radius: belt_speed, drop, layer, start: start(), bounds: bounds() })
    }

    /// The orbit through the maximum `radius` <= V of x2. Its C lies between the bounds of the even part of the
    /// weakening rate (theory, "The backbone"), and near `guess` where there is one.
    pub(super) fn of_amplitude(curve: &'a Curve, belt_speed: f64, radius: f64, guess: Option<f64>) -> Self {
        let even = curve.even_weakening_range(belt_speed);
        let mean = curve.rough_mean_weakening(belt_speed);
        // Rounding may change the signs at the bounds.
        let pad = 1e-9 * (even.hi - even.lo) + 1e-13 * even.lo.abs().max(even.hi.abs());
        let far = WIDE * (1.0 + mean.abs());
        let low = if even.lo.is_finite() { even.lo - pad } else { mean - far };
        let high = if even.hi.is_finite() { even.hi + pad } else { mean + far };
        let layer = layer(curve, belt_speed, radius);
        let start = guess.unwrap_or(mean);
        Self { curve, belt_speed, radius, drop: 0.0, layer, start, bounds: [low, high] }
    }
}

/// The state of a search.
struct Search<'a> {
    orbit: Orbit<'a>,
    /// Bounds of the errors of C and of h by that of the law's polynomials.
    form: f64,
    form_of_energy: f64,
    /// Cost of an evaluation.
    cost: u64,
    viscous: f64,
    bounds: [f64; 2],
    /// Unit of C, and its accuracy.
    size: f64,
    aim: f64,
    is_accurate: bool,
    /// C and the derivative by C of the orbit before.
    before: Option<[f64; 2]>,
    /// The lesser R^2.
    square: f64,
    /// -d ln(R^2)/dC of the forward half less that of the backward one, and the change of its logarithm by C.
    steepness: f64,
    curvature: f64,
    rhs: u64,
    work: Work,
}

/// A law in the form in which halves follow it.
struct Law<'a> {
    weakening: Option<Arc<Weakening>>,
    stops: Cow<'a, [f64]>,
}

impl<'a> Law<'a> {
    fn of(&Sought { curve, belt_speed, radius, drop, layer, .. }: &Sought<'a>) -> Self {
        // How fast an orbit may slip that friction drives: it changes the speed by 1 at most.
        let fastest = match layer.is_none() && drop == 0.0 {
            true => 2.0 * belt_speed,
            false => belt_speed + radius.hypot(1.0),
        };
        let weakening = (!curve.has_closed_form()).then(|| curve.compiled(2.0 * fastest));
        let stops = weakening.as_ref().map_or_else(|| curve.stops(fastest), |law| curve.stops_of(law));
        Self { weakening, stops }
    }
}

impl<'a> Search<'a> {
    fn new(sought: &Sought<'a>, law: &'a Law<'a>, tolerance: f64) -> Self {
        let Sought { curve, belt_speed, radius, drop, layer, start, bounds } = *sought;
        // Errors are in units of C, or of the weakening rate where that is moderate.
        let size = match layer.is_none() && drop == 0.0 {
            true => [belt_speed - radius, belt_speed, belt_speed + radius]
                .map(|u| curve.weakening(u).abs())
                .into_iter()
                .fold(start.abs(), f64::max),
            false => start.abs().max(1e-3 * curve.weakening(belt_speed).abs()),
        }
        .max(f64::MIN_POSITIVE);
        let aim = 0.5 * tolerance.min(COARSEST) * size;
        let on_circle = [belt_speed - radius, belt_speed + radius];
        let (rate, form, form_of_energy, cost) = match (curve.exponential_fall(), &law.weakening) {
            (Some(fall), _) => (Rate::Exponential(fall), 0.0, 0.0, 1),
            (None, Some(weakening)) => {
                let form = weakening.error(on_circle[0], on_circle[1]).bound();
                // The energy changes by the error of w times W, which the fall of friction bounds.
                let of_energy =
                    2.0 * radius.hypot(1.0) * weakening.integrated_error(on_circle[0], on_circle[1]);
                let is_accurate = form.min(of_energy / (radius * radius)) <= aim.max(WORST * size);
                match is_accurate {
                    true => (Rate::Polynomials(weakening), form, of_energy, 1),
                    false => (Rate::Law(curve), 0.0, 0.0, curve.cost()),
                }
            }
            (None, None) => (Rate::Law(curve), 0.0, 0.0, curve.cost()),
        };
        let layer = layer.unwrap_or(radius);
        Self {
            orbit: Orbit { rate, stops: &law.stops, belt_speed, radius, drop, layer },
            form,
            form_of_energy,
            cost,
            viscous: start.clamp(bounds[0], bounds[1]),
            bounds,
            size,
            aim,
            is_accurate: false,
            before: None,
            square: radius * radius,
            steepness: 6.0,
            curvature: f64::INFINITY,
            rhs: 0,
            work: Work::of_question(curve),
        }
    }
}

impl Search<'_> {
    /// The halves to be followed next.
    fn halves(&self) -> [Half<'_>; 2] {
        let requested = if self.is_accurate { self.aim } else { self.aim.max(ROUGH * self.size) };
        let allowed = 0.5 * requested * self.steepness * self.square;
        [1.0, -1.0].map(|sign| Half { orbit: self.orbit, viscous: self.viscous, sign, allowed })
    }

    /// Makes a step of Newton's method; returns the C at which the orbit closes once it is found, or `Err` with the
    /// number of evaluations once it cannot be.
    fn advance(&mut self, [forward, backward]: [(Option<Lowest>, u64); 2]) -> Option<Result<Closing, u64>> {
        let spent = forward.1 + backward.1;
        self.rhs += spent;
        let within = self.work.spend_compiled(spent.saturating_mul(self.cost)).is_ok();
        if !within {
            return Some(Err(self.rhs));
        }
        let square = |lowest: &Lowest| self.orbit.radius * self.orbit.radius + 2.0 * lowest.h;
        let both = forward.0.zip(backward.0);
        let turn = both.filter(|(forward, backward)| square(forward).min(square(backward)) > 0.0);
        let Some((forward, backward)) = turn else {
            // So far beyond the root that the orbit does not turn.
            let nearer = self.before.map_or(self.bounds[0].max(0.0), |[at, _]| at);
            if !((self.viscous - nearer).abs() > NEAREST_RETREAT * self.size) {
                return Some(Err(self.rhs));
            }
            self.viscous = 0.5 * (nearer + self.viscous);
            return None;
        };
        let [ahead, behind] = [square(&forward), square(&backward)];
        let gap = (2.0 * (forward.h - backward.h) / behind).ln_1p();
        let error = 2.0 * (forward.error / ahead + backward.error / behind);
        let by_damping = 2.0 * (forward.by_damping / ahead - backward.by_damping / behind);
        self.square = ahead.min(behind);
        let viscous = self.viscous;
        let [low, high] = &mut self.bounds;
        if gap > error {
            *low = low.max(viscous);
        } else if gap < -error {
            *high = high.min(viscous);
        }
        if let Some([at, slope]) = self.before
            && at != viscous
        {
            self.curvature = 0.5 * ((by_damping - slope) / ((viscous - at) * by_damping)).abs();
        }
        self.before = Some([viscous, by_damping]);
        self.steepness = by_damping.abs();
        let newton = viscous - gap / by_damping;
        let change = (newton - viscous).abs();
        let own = error / self.steepness;
        let left = (CURVATURE * self.curvature * change * change).min(change);
        let floor = 4.0 * f64::EPSILON * viscous.abs();
        if self.is_accurate && (change <= own || left <= self.aim.max(own)) {
            let error = own
                + left
                + self.form.min(2.0 * self.form_of_energy / (self.square * self.steepness))
                + floor;
            let found = Closing { viscous: newton, error, rhs: self.rhs, slope: None };
            return Some(if error.is_finite() { Ok(found) } else { Err(self.rhs) });
        }
        let near = NEARLY * (self.aim / self.size).sqrt().sqrt() * self.size;
        self.is_accurate |= change <= own.max(near) || *high - *low <= floor;
        let inside = newton > *low && newton < *high;
        self.viscous = if inside { newton } else { 0.5 * (*low + *high) };
        None
    }
}

/// The C at which many orbits close, with errors of about `tolerance` in units of C; `Err` with the number of evaluations
/// where the form does not apply.
///
/// An orbit's answer does not depend on its neighbours in the slice, nor on the machine's vector width.
pub(super) fn closing_dampings_by_halves(sought: &[Sought], tolerance: f64) -> Vec<Result<Closing, u64>> {
    let forms: Vec<Law> = sought.iter().map(Law::of).collect();
    let mut answers = vec![Err(0); sought.len()];
    let mut searches: Vec<(usize, Search)> = Vec::with_capacity(sought.len());
    for (number, (sought, law)) in sought.iter().zip(&forms).enumerate() {
        let [low, high] = sought.bounds;
        let &Sought { curve, belt_speed, radius, .. } = sought;
        if radius == belt_speed && curve.is_hidden_by_rounding(belt_speed) {
            continue;
        }
        if sought.start.is_finite() && low.is_finite() && high.is_finite() && low <= high {
            searches.push((number, Search::new(sought, law, tolerance)));
        }
    }
    for _ in 0..MOST_ORBITS {
        let halves: Vec<Half> = searches.iter().flat_map(|(_, search)| search.halves()).collect();
        let found = vectorized(
            #[inline(always)]
            || follow(&halves),
        );
        let mut ends = found.chunks_exact(2).map(|ends| [ends[0], ends[1]]);
        searches.retain_mut(|(number, search)| {
            let answer = ends.next().and_then(|ends| search.advance(ends));
            answers[*number] = answer.unwrap_or(Err(search.rhs));
            answer.is_none()
        });
        if searches.is_empty() {
            break;
        }
    }
    answers
}

#[cfg(test)]
mod tests {
    use crate::critical_damping;
    use slipmap_model::friction::{Expression, Law};

    /// Next to the most braking, where a half may start late, the speed at which braking and spring balance does not change.
    #[test]
    fn errors_hold_where_the_balance_turns() {
        let law = Law::Expression(Expression::new("0.58 + 0.42*exp(-(u/0.03)^2)", 1.0).unwrap());
        for belt_speed in [0.232_846_642_3, 0.274_968_748_4, 0.325_191_259_6] {
            let column = law.column(&law.point(1.0, &[], belt_speed, 0.0).unwrap());
            let [found, exact] = [1e-9, 1e-12].map(|tolerance| critical_damping(&column, tolerance).unwrap());
            assert!((found.c - exact.c).abs() < found.error + exact.error, "{found:?} {exact:?}");
            assert!(found.error < 1e-9, "{found:?}");
        }
    }

    /// A fall that rounds off at rest tends to a drop as it becomes narrow. Next to rest x2'' = -x2 and friction falls as
    /// u^2 / w^2: the time until it falls, and the error, are of the order w^(2/3).
    #[test]
    fn narrow_falls_that_are_round_at_rest_have_a_critical_damping() {
        let coulomb = Law::Coulomb.column(&Law::Coulomb.point(1.0, &[0.3, 0.0], 1.0, 0.0).unwrap());
        let drop = critical_damping(&coulomb, 1e-12).unwrap().c;
        let law = Law::Expression(Expression::new("1 - 0.3*tanh(u/w)^2", 1.0).unwrap());
        let excess = |width: f64| {
            let column = law.column(&law.point(1.0, &[width], 1.0, 0.0).unwrap());
            let found = critical_damping(&column, 1e-9).unwrap();
            assert!(found.error < 1e-7, "{width}: {found:?}");
            found.c - drop
        };
        // An orbit by arcs gave 0.028750799 +- 1.2e-8.
        assert!((excess(1e-2) + drop - 0.028_750_799).abs() < 1.2e-8);
        for width in [1e-4, 1e-6, 1e-8, 1e-10] {
            let off = excess(width) / width.powf(2.0 / 3.0);
            assert!((0.25..0.3).contains(&off), "{width}: {off}");
        }
    }
}

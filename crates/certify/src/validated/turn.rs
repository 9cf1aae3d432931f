//! One enclosed turn of an orbit of any friction law, and from it an enclosure of a column's critical
//! damping.
//!
//! # Statements
//! **Polar form.** With r in units of V, v = V r cos th, u = V (1 - r cos th) and D = w(u) - C, C = eps c,
//!
//! ```text
//! dr/dth = F(th, r) = D r sin^2 th / (1 + D sin th cos th),      r(0) = 1,
//! ```
//!
//! and the orbit from the exit point comes back to the belt line if r(2 pi) > 1 and does not if r(2 pi) < 1
//! (see [`super`]). A proof of the first at one damping holds at all smaller ones, and one of the second at
//! all larger ones. So an enclosure of r(2 pi) at C1 and at C2 that excludes 1 encloses C* between them. For
//! u < 0 any continuation of w is valid; that of the first polynomial is used. With a drop j of friction as slip
//! begins the orbit starts at (1, -j/V) instead, see [`Orbit::start`].
//!
//! **The law.** On each piece of slip speeds w is a polynomial p up to a proved error
//! ([`slipmap_model::friction::Weakening::proved_pieces`]). A step uses the p of one piece. Where the orbits of the
//! step meet other pieces, q with error e_q, |w - p| <= e_q + max |q - p| there; delta is the largest of
//! these bounds.
//!
//! **A step** is that of `crates/certify/src/enclosure.rs`, with F_p, which has p for w, in place of F. Where |dF/dD| <= M
//! in a tube around the polynomial, |F - F_p| <= M delta there, which adds to the defect: so the bound on the
//! distance holds for the true orbit as long as it stays in the tube, and it does if the bound is below the
//! tube's width. []
//!
//! The law is the stored curve: its coefficients, such as 1 - mu, were rounded when it was made. Sines and
//! cosines are the platform's; their error is assumed to be less than four units in the last place.

use crate::drop::sustained;
use crate::enclosure::{Distance, Enclosure, ORDER, Polar, Polynomial, distance};
use slipmap_model::friction::{COUNT, ProvedPiece, Weakening};
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// Longest and shortest step.
const STEPS: [f64; 2] = [0.2, 1e-13];
/// Length of the first step, and the factor on the length after a step that was taken.
const FIRST_STEP: f64 = 0.05;
const GROWTH: f64 = 1.5;
/// Accuracy, in units of the belt speed and in the angle, of the place at which an orbit leaves a piece.
const PLACE: f64 = 1e-13;
/// Largest number of steps of all turns of a column, a third of a second; most turns take a hundred.
const MOST_STEPS: u32 = 30_000;
/// Largest uncertainty that a step may add per unit of angle, relative to the size of D.
const SHARPNESS: f64 = 1e-12;
/// Uncertainty at which a step of any length is accepted: needed next to corners of the law.
const ENOUGH: f64 = 1e-15;
/// Least dth/dt.
const SLOWEST: f64 = 1e-3;
/// Largest number of turns in the search for the critical damping.
const EVALUATIONS: u32 = 40;

/// Reason why a turn could not be enclosed.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum Obstacle {
    /// The bounds reach beyond the slip speeds at which the law is bounded.
    #[error("the bounds around the orbit reach slip speed {reached:.3e}, those of the law {known:.3e}")]
    BeyondTheLaw {
        /// The slip speed reached.
        reached: f64,
        /// The highest at which the law is bounded.
        known: f64,
    },
    /// The law has no proved enclosure at this slip speed.
    #[error("the law has no proved bounds at slip speed {at:.3e}")]
    NoEnclosure {
        /// The slip speed.
        at: f64,
    },
    /// The polar angle is not monotone: the divergence is too large.
    #[error("the divergence is so large that the orbit may never complete a turn")]
    NoAngle,
    /// The steps would be too short or too many.
    #[error("the bounds around the orbit become too wide, or take too many steps")]
    TooMuchWork,
}

/// The damping and the law of an orbit.
struct Orbit<'a> {
    law: &'a Weakening,
    belt_speed: f64,
    /// The drop j of friction as slip begins.
    drop: f64,
    viscous: f64,
    /// Size of the divergence, which scales negligible quantities.
    size: f64,
}

enum Step {
    /// The orbit after the step: the end of the polynomial, and a bound of the orbit's distance from it.
    Taken { end: Interval, error: f64 },
    /// The step must be shorter: this long.
    Shorter(f64),
}

/// Bound on the difference of two pieces' polynomials between the slip speeds `from` and `to`, which may lie
/// beyond the ends of either piece, by their Taylor series.
fn difference(one: &ProvedPiece, two: &ProvedPiece, from: f64, to: f64) -> f64 {
    let series = |piece: &ProvedPiece| {
        let constant = Jet::<Interval, COUNT>::constant;
        let u = Jet::<Interval, COUNT>::variable(Interval::of(from), 1.0);
        let x = (u - constant(piece.middle)) * constant(piece.scale);
        x.polynomial(piece.c)
    };
    let apart = series(one) - series(two);
    let width = Interval::of(to) - Interval::of(from);
    let sum = apart
        .0
        .iter()
        .rev()
        .fold(0.0, |sum, coefficient| (Interval::of(sum) * width + Interval::of(coefficient.size())).hi);
    if sum.is_finite() { sum } else { f64::INFINITY }
}

/// All numbers within `radius` of `x`.
fn around(x: Interval, radius: f64) -> Interval {
    x + Interval::new(-radius, radius)
}

/// An orbit where w is the polynomial of a piece.
struct OnPiece<'a> {
    orbit: &'a Orbit<'a>,
    piece: &'a ProvedPiece<'a>,
}

impl Polar for OnPiece<'_> {
    /// F, dF/dD and dth/dt, at r.
    fn polar<T: Real>(&self, theta: T, r: T) -> Option<[T; 3]> {
        let Self { orbit: Orbit { belt_speed, viscous, .. }, piece } = *self;
        let c = T::constant;
        let (sin, cos) = theta.sin_cos();
        let x = (c(*belt_speed) - c(*belt_speed) * r * cos - c(piece.middle)) * c(piece.scale);
        let w = x.polynomial(piece.c);
        let d = w - c(*viscous);
        let speed = c(1.0) + d * sin * cos;
        let swept = r * sin * sin / speed;
        Some([d * swept, swept / speed, speed])
    }
}

impl Orbit<'_> {
    /// Slip speeds over angles and radii.
    fn slip(&self, theta: Interval, r: Interval) -> Interval {
        let belt = Interval::of(self.belt_speed);
        belt - belt * r * theta.sin_cos().1
    }

    /// Slip speeds along a polynomial and within `tube` of it: those at the ends of the step, where they are
    /// monotone.
    fn slips(
        &self,
        angles: Interval,
        values: &Jet<Interval, ORDER>,
        ends: [[Interval; 2]; 2],
        tube: f64,
    ) -> Interval {
        let (sin, cos) = angles.sin_cos();
        let rate = values.0[0] * sin - values.0[1] * cos;
        let along = if rate.contains_zero() {
            self.slip(angles, values.0[0])
        } else {
            let [from, to] = ends.map(|[theta, r]| self.slip(theta, r));
            from.hull(to)
        };
        around(along, (self.belt_speed * tube).next_up())
    }

    /// The approximate place on a step at which the polynomial leaves the slip speeds of the piece, if it
    /// does.
    fn crossing(&self, piece: &ProvedPiece, theta: f64, polynomial: &Polynomial, width: f64) -> Option<f64> {
        let slip = |t: f64| self.belt_speed * (1.0 - polynomial.at(t) * (theta + t).cos());
        let slack = PLACE * self.belt_speed;
        let outside = |t: f64| slip(t) < piece.ends[0] - slack || slip(t) > piece.ends[1] + slack;
        if !outside(width) || outside(0.0) {
            return None;
        }
        let (mut inside, mut beyond) = (0.0, width);
        for _ in 0..60 {
            let middle = 0.5 * (inside + beyond);
            if outside(middle) { beyond = middle } else { inside = middle }
        }
        // A place at the end of the step does not count.
        (inside > PLACE && inside < 0.999 * width).then_some(inside)
    }

    /// delta: bound on the distance of w from the polynomial of `piece` at slip speeds in `slip`.
    fn uncertainty(&self, piece: &ProvedPiece, slip: Interval) -> Result<f64, Obstacle> {
        if slip.hi > self.law.reach() {
            return Err(Obstacle::BeyondTheLaw { reached: slip.hi, known: self.law.reach() });
        }
        let mut most: f64 = 0.0;
        for other in self.law.proved_pieces(slip.lo, slip.hi) {
            if !other.error.is_finite() {
                return Err(Obstacle::NoEnclosure { at: other.ends[0] });
            }
            let apart = match other.ends == piece.ends {
                true => 0.0,
                false => difference(piece, &other, other.ends[0].max(slip.lo), other.ends[1].min(slip.hi)),
            };
            most = most.max((other.error + apart).next_up());
        }
        Ok(most)
    }

    /// A step of length `width` from the angle `theta` and from within `error` of `r`.
    fn step(&self, theta: f64, r: f64, error: f64, width: f64) -> Result<Step, Obstacle> {
        let half = Ok(Step::Shorter(0.5 * width));
        let middle = theta + 0.5 * width;
        let near = self.belt_speed * (1.0 - r * middle.cos());
        let Some(piece) = self.law.proved_pieces(near.max(0.0), near.max(0.0)).next() else {
            return Err(Obstacle::BeyondTheLaw { reached: near, known: self.law.reach() });
        };
        let field = OnPiece { orbit: self, piece: &piece };
        let Some(polynomial) = Polynomial::new(&field, theta, r) else { return half };
        if let Some(until) = self.crossing(&piece, theta, &polynomial, width) {
            return Ok(Step::Shorter(until));
        }
        // The angle at the end of the step is a number, and the width is its difference, nearly or exactly.
        let width = Interval::of(theta + width) - Interval::of(theta);
        let angles = Interval::of(theta) + Interval::new(0.0, width.hi);
        let Some(Enclosure { along, end, defect, .. }) = polynomial.enclosed(&field, width) else {
            return half;
        };
        let ends = [[Interval::of(theta), Interval::of(r)], [Interval::of(theta) + width, end]];
        // The tube is guessed and then confirmed.
        let mut tube = 2.0 * error + 4.0 * width.hi * (defect + SHARPNESS * self.size) + 1e-15;
        for _ in 0..3 {
            let radii = around(along.0[0], tube);
            let delta = self.uncertainty(&piece, self.slips(angles, &along, ends, tube))?;
            let angle = Jet::<Interval, 2>::of(angles);
            let Some([f, by_divergence, speed]) = field.polar(angle, Jet::variable(radii, 1.0)) else {
                return half;
            };
            // w itself may differ from the polynomial by delta, and the angle must increase for both.
            if !(speed.0[0].lo - delta > SLOWEST && delta <= SLOWEST) {
                return if width.hi < 1e-3 { Err(Obstacle::NoAngle) } else { half };
            }
            let sweep = by_divergence.0[0].size() * (1.0 + 4.0 * delta / SLOWEST);
            let defect = Interval::of(defect) + Interval::of(sweep) * Interval::of(delta);
            let Distance { added, during, after, .. } = distance(f.0[1], width, Interval::of(error), defect);
            if !during.hi.is_finite() {
                return half;
            }
            if during.hi < tube {
                // No shorter step reduces the uncertainty of the law itself.
                let unavoidable = 2.0 * sweep * piece.error * width.hi;
                let allowed = (SHARPNESS * self.size * width.hi).max(ENOUGH) + unavoidable;
                return if added.hi <= allowed { Ok(Step::Taken { end, error: after.hi }) } else { half };
            }
            tube = 2.0 * during.hi;
        }
        half
    }

    /// The angle, a radius and the orbit's distance from it, where the turn begins.
    ///
    /// With a drop that is next to the exit point: the angle is a number within a few units in the last place of
    /// atan(j/V), over which the radius changes by less than the bound of its slope times that width.
    fn start(&self) -> Result<[f64; 3], Obstacle> {
        if self.drop == 0.0 {
            return Ok([0.0, 1.0, 0.0]);
        }
        let ratio = Interval::of(self.drop).over(Interval::of(self.belt_speed));
        let radius = (Interval::ONE + ratio.square()).sqrt();
        let theta = (self.drop / self.belt_speed).atan();
        let width = 8.0 * f64::EPSILON * theta;
        let (sin, cos) = Interval::new(theta - width, theta + width).sin_cos();
        let beyond = 64.0 * f64::EPSILON * self.belt_speed * (1.0 + radius.hi);
        let weakening = self.law.range(0.0, beyond);
        let d = Interval::new(weakening.lo, weakening.hi) - Interval::of(self.viscous);
        let speed = Interval::ONE + d * sin * cos;
        if !(d.is_bounded() && radius.is_bounded() && speed.lo > SLOWEST) {
            return Err(Obstacle::NoAngle);
        }
        let slope = (d * radius * sin.square()).over(speed).size();
        let r = 0.5 * (radius.lo + radius.hi);
        // Twice the width, for the change of w over it and the roundings of these bounds.
        let error = (radius - Interval::of(r)).size() + 2.0 * width * slope;
        Ok([theta, r, error.next_up()])
    }

    /// Encloses r(2 pi) with at most `steps` steps, which it counts down.
    fn turn(&self, steps: &mut u32) -> Result<Interval, Obstacle> {
        let end = Interval::new(std::f64::consts::TAU, std::f64::consts::TAU.next_up());
        let [mut theta, mut r, mut error] = self.start()?;
        // The usual length of steps, and that of the next one, which may be cut at the end of a piece.
        let (mut usual, mut width) = (FIRST_STEP, FIRST_STEP);
        while *steps > 0 {
            *steps -= 1;
            let rest = end.lo - theta;
            if rest <= 0.0 {
                // Between the number below 2 pi and 2 pi itself, the change of r is of the order of the
                // square of their difference.
                return Ok(around(Interval::of(r), error + f64::EPSILON));
            }
            let last = width >= rest;
            match self.step(theta, r, error, width.min(rest))? {
                Step::Taken { end: reached, error: uncertain } => {
                    theta = if last { end.lo } else { theta + width };
                    r = 0.5 * (reached.lo + reached.hi);
                    error = (uncertain + (reached - Interval::of(r)).size()).next_up();
                    usual = if width < usual { usual } else { (GROWTH * usual).min(STEPS[0]) };
                    width = usual;
                }
                Step::Shorter(length) => {
                    // The usual length is halved; other lengths end at a piece.
                    if length == 0.5 * width.min(rest) {
                        usual = length;
                    }
                    width = length;
                    if width < STEPS[1] {
                        return Err(Obstacle::TooMuchWork);
                    }
                }
            }
        }
        Err(Obstacle::TooMuchWork)
    }
}

/// Enclosure of C* = eps c* at belt speed `belt_speed`, each end a theorem. `bounds` is an earlier enclosure;
/// the second result is the reason if a side could not be improved.
pub(super) fn critical(
    law: &Weakening,
    belt_speed: f64,
    drop: f64,
    bounds: [f64; 2],
) -> ([f64; 2], Option<Obstacle>) {
    let [mut lo, mut hi] = bounds;
    if !(lo.is_finite() && hi.is_finite() && lo < hi) {
        let obstacle =
            (!(lo <= hi && lo.is_finite() && hi.is_finite())).then_some(Obstacle::NoEnclosure { at: 0.0 });
        return (bounds, obstacle);
    }
    let whole = law.range(0.0, 2.0 * belt_speed);
    // With a drop the upper bound is far above.
    let highest = if drop > 0.0 { sustained(drop, belt_speed).hi } else { hi };
    let scale = lo.abs().max(highest.abs()).max(whole.lo.abs()).max(whole.hi.abs()).max(f64::MIN_POSITIVE);
    if !scale.is_finite() {
        return (bounds, Some(Obstacle::NoEnclosure { at: 0.0 }));
    }
    let mut obstacle = None;
    let (mut left, mut steps) = (EVALUATIONS, MOST_STEPS);
    // r(2 pi) - 1 at the ends of the bracket, as far as computed.
    let mut known: [Option<(f64, f64)>; 2] = [None, None];
    let mut at = match drop > 0.0 {
        // The upper bound is far above; the largest weakening on the way is nearer.
        true => (0.5 * (lo + hi) - 1.0 + sustained(drop, belt_speed).lo).clamp(lo, hi),
        false => 0.5 * (lo + hi),
    };
    while left > 0 && hi - lo > 4.0 * f64::EPSILON * scale {
        left -= 1;
        let orbit = Orbit { law, belt_speed, drop, viscous: at, size: scale };
        let margin = match orbit.turn(&mut steps) {
            Ok(end) => end - Interval::of(1.0),
            Err(why) => {
                obstacle = Some(why);
                break;
            }
        };
        let middle = 0.5 * (margin.lo + margin.hi);
        if margin.lo > 0.0 {
            lo = lo.max(at);
        } else if margin.hi < 0.0 {
            hi = hi.min(at);
        }
        known[usize::from(middle < 0.0)] = Some((at, middle));
        let uncertain = 0.5 * (margin.hi - margin.lo);
        // dr(2 pi)/dC is about -pi.
        let slope = match known {
            [Some((a, m)), Some((b, n))] if b > a => (n - m) / (b - a),
            _ => -std::f64::consts::PI,
        };
        let root = at - middle / slope;
        let off = 2.0 * uncertain / slope.abs() + 2.0 * f64::EPSILON * scale;
        // Far from the root its estimate is next; near it, dampings at which the sign must be certain.
        at = if middle.abs() > 16.0 * uncertain {
            root
        } else if lo < root - 4.0 * off {
            root - 1.5 * off
        } else if hi > root + 4.0 * off {
            root + 1.5 * off
        } else {
            break;
        };
        if !(lo < at && at < hi) {
            at = 0.5 * (lo + hi);
        }
    }
    ([lo, hi], obstacle)
}

#[cfg(test)]
mod tests {
    use crate::test_columns::random_columns;
    use crate::validated::{Enclosed, any_law};
    use slipmap_model::friction::{Law, Table};
    use slipmap_model::point::{LawParameters, Point};

    /// Compares the proof for any law, on Stribeck's law, with the special proof, which shares neither
    /// witness nor arithmetic.
    #[test]
    fn two_proofs_of_one_column_agree() {
        let (mut sharp, mut all) = (0, 0);
        for column in random_columns(40) {
            let own = Enclosed::of(&column).unwrap().critical();
            let any = any_law::prove(&column).critical;
            // Both hold C*.
            assert!(any.lo <= own.hi && own.lo <= any.hi, "{column:?}: {own:?} {any:?}");
            all += 1;
            let size = column.curve.weakening_range(0.0, 2.0 * column.belt_speed);
            sharp += u32::from(any.hi - any.lo < 1e-9 * size.hi.abs().max(size.lo.abs()));
        }
        // The proof for any law gives up more of the violent columns: 63 of 120 were sharp.
        assert!(5 * sharp > 2 * all, "{sharp} of {all}");
    }

    /// A law whose weakening rate is a parabola on each piece, with corners on the orbit.
    #[test]
    fn corners_are_passed_and_the_end_of_a_table_is_reported() {
        let data: Vec<(f64, f64)> =
            (0..12).map(|i| 0.25 * f64::from(i)).map(|u| (u, 0.6 + 0.4 * (-u).exp() + 0.02 * u)).collect();
        let law = Law::Table(Table::new("corners", &data, 1.0).unwrap());
        let column = |belt_speed: f64| {
            law.column(&Point { epsilon: 1.0, law: LawParameters::new(&[]), belt_speed, damping: 0.0 })
        };
        let proof = any_law::prove(&column(1.0));
        let width = proof.critical.hi - proof.critical.lo;
        assert!(width > 0.0 && width < 1e-9 && proof.obstacle.is_none(), "{proof:?}");
        // Twice the belt speed is more than 2.75.
        let proof = any_law::prove(&column(1.5));
        assert!(proof.obstacle.is_some() && proof.critical.hi == f64::INFINITY, "{proof:?}");
    }
}

//! The discontinuous oscillator: stick segment, exit point, equilibrium and the two vector fields.
//!
//! ```text
//! x1' = x2
//! x2' = -x1 - eps c x2 - sign(x2 - V) phi(|x2 - V|)
//! ```
//!
//! The belt holds the mass, x2 = V, as long as |x1 + eps c V| < 1: friction at rest is 1. Friction in slip
//! begins at phi(0+) = 1 - j, see [`Curve::drop`](crate::friction::Curve::drop): where j > 0 the segment of
//! sticking is longer than that to which both fields point, and the orbit from the exit point leaves it with
//! x2' = -j.
//!
//! Departures from the paper: its equation (1) misplaces x1; Proposition 1 and section 3 write the exit
//! point as (1 - eps c, V) where (1 - eps c V, V) is meant.

use crate::friction::{Column, Curve, Law, Range};
use crate::point::Point;
use slipmap_numbers::TimesPlus as _;

/// The oscillator with every parameter fixed.
#[derive(Clone, Debug, PartialEq)]
pub struct Oscillator {
    /// The friction curve phi(u).
    pub curve: Curve,
    /// C = eps c, the coefficient of the viscous force.
    pub viscous: f64,
    /// Belt speed V > 0.
    pub belt_speed: f64,
}

/// The two sides of the belt line x2 = V.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// x2 < V: the mass is slower than the belt, friction drives it forward.
    Below,
    /// x2 > V: the mass is faster than the belt, friction holds it back.
    Above,
}

/// The flow at a point (x1, V) of the belt line.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeltRegion {
    /// Both fields push towards the line: the mass sticks and moves with x1' = V.
    Sliding,
    /// Both fields point down.
    CrossingDown,
    /// Both fields point up.
    CrossingUp,
    /// End of the stick segment where the lower field is tangent: sticking orbits leave here.
    ExitPoint,
    /// The other end of the stick segment, where the upper field is tangent.
    UpperTangency,
}

/// Type of the equilibrium from the eigenvalues of its linearisation, lambda^2 - D lambda + 1 = 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Eigenvalues {
    /// A pair `re +- i im`, im > 0: a focus (a centre of the linearisation if re = 0).
    Complex {
        /// Real part, D/2.
        re: f64,
        /// Positive imaginary part.
        im: f64,
    },
    /// Two real eigenvalues, `fast * slow` = 1: a node.
    Real {
        /// The smaller in modulus.
        slow: f64,
        /// The larger in modulus.
        fast: f64,
    },
}

/// What small disturbances of the equilibrium do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stability {
    /// They decay.
    Attracts,
    /// Neither, to first order: the divergence is 0, or not distinguishable from 0 by rounding.
    Neutral,
    /// They grow.
    Repels,
}

/// The weakening rate at the belt speed, which is eps c at the Hopf bifurcation.
pub struct HopfRate<'a> {
    curve: &'a Curve,
    belt_speed: f64,
    rate: f64,
    /// Size of the rates in means over orbits about the equilibrium.
    scale: f64,
}

/// Divergences below this share of the rate and the damping are lost in the rounding of these.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// Divergences above this, in units of the rates and forces on an orbit, are above all rounding errors.
const CLEAR: f64 = 1e-6;

impl<'a> HopfRate<'a> {
    /// The rate at one belt speed.
    pub fn new(curve: &'a Curve, belt_speed: f64) -> Self {
        let (rate, scale) = (curve.weakening(belt_speed), curve.weakening_scale(belt_speed));
        Self { curve, belt_speed, rate, scale }
    }

    /// What small disturbances do at eps c = `viscous`.
    pub fn stability(&self, viscous: f64) -> Stability {
        let divergence = self.rate - viscous;
        let is_noise = || divergence.abs() <= self.rounding_here() + ROUNDING * viscous.abs();
        if divergence.abs() <= CLEAR * (self.scale + viscous.abs() + 1.0 + self.belt_speed.recip())
            && is_noise()
        {
            Stability::Neutral
        } else if divergence < 0.0 {
            Stability::Attracts
        } else {
            Stability::Repels
        }
    }

    /// Size up to which the mean of the rate over an orbit is not distinguishable from 0.
    pub fn rounding(&self) -> f64 {
        self.rounding_of(self.scale)
    }

    /// Bound of the error of the rate. What is known of the rounding of a law that a program gives is the size of its rates.
    /// A rate that means over orbits do not show, as what is left of a fall long before the belt speed, has no sign alone.
    fn rounding_here(&self) -> f64 {
        let (rate, of_means) = (self.rate.abs(), self.rounding());
        match self.curve.is_sampled() {
            true => of_means,
            false => self.rounding_of(rate) + if rate <= of_means { rate } else { 0.0 },
        }
    }

    /// The rounding of a rate or a mean of that size: a few of the smallest numbers where friction is flat, whose bounds are
    /// rounded outwards.
    fn rounding_of(&self, size: f64) -> f64 {
        let rounding = ROUNDING * size + self.curve.weakening_rounding(self.belt_speed);
        rounding.max(8.0 * f64::MIN_POSITIVE)
    }

    /// Bound of the distance of [`Self::value`] from a damping at which small disturbances may be neutral.
    pub fn error(&self) -> f64 {
        (self.rate - self.value()).abs() + self.rounding_here() + 2.0 * ROUNDING * self.rate.abs()
    }

    /// The rate; 0 where it is not distinguishable from 0.
    pub fn value(&self) -> f64 {
        if self.stability(0.0) == Stability::Neutral { 0.0 } else { self.rate }
    }
}

impl Eigenvalues {
    /// Returns whether both eigenvalues have a negative real part.
    #[must_use]
    pub fn is_stable(&self) -> bool {
        match *self {
            Eigenvalues::Complex { re, .. } => re < 0.0,
            Eigenvalues::Real { slow, .. } => slow < 0.0,
        }
    }
}

/// Number of intervals between the samples that judge a divergence without proved bounds.
const SAMPLES: u32 = 256;

impl Oscillator {
    /// The oscillator at a parameter point of `law`.
    ///
    /// # Panics
    /// As [`Law::column`], if the point is not legal.
    #[must_use]
    pub fn new(law: &Law, point: &Point) -> Self {
        Self::in_column(&law.column(point), point.damping)
    }

    /// The oscillator at damping `c` of a column.
    #[must_use]
    pub fn in_column(column: &Column, c: f64) -> Self {
        Self { curve: column.curve.clone(), viscous: column.epsilon * c, belt_speed: column.belt_speed }
    }

    /// The divergence D(u) = -eps c - phi'(u) of the flow at slip speed `u` >= 0, the same on both sides.
    #[must_use]
    #[inline]
    pub fn divergence(&self, u: f64) -> f64 {
        self.curve.weakening(u) - self.viscous
    }

    /// Bound of |D(u)| for slip speeds up to twice the belt speed; infinite or NaN where a law's data end
    /// before.
    pub fn divergence_size(&self) -> f64 {
        let Range { lo, hi } = self.curve.weakening_range(0.0, 2.0 * self.belt_speed);
        lo.abs().max(hi.abs()) + self.viscous
    }

    /// Returns whether the divergence is proved to be at most `bound` for all slip speeds in [`lo`, `hi`], 0
    /// <= lo <= hi.
    pub fn divergence_is_at_most(&self, bound: f64, lo: f64, hi: f64) -> bool {
        // A few values decide for most oscillators; bounds over a range of slip speeds cost much more.
        let at = |share: f64| self.divergence((hi - lo).times_plus(share, lo)) <= bound;
        [0.0, 1.0, 0.5, 0.2, 0.7, 0.35, 0.85].into_iter().all(at)
            && self.curve.weakening_range(lo, hi).hi - self.viscous <= bound
    }

    /// Returns whether the divergence is at most `bound` on [`lo`, `hi`], by proof or, for a law without
    /// proved bounds, by many samples.
    pub fn divergence_seems_at_most(&self, bound: f64, lo: f64, hi: f64) -> bool {
        let at =
            |i: u32| self.divergence((hi - lo).times_plus(f64::from(i) / f64::from(SAMPLES), lo)) <= bound;
        self.divergence_is_at_most(bound, lo, hi) || self.curve.is_sampled() && (0..=SAMPLES).all(at)
    }

    /// x2' on one side of the belt line.
    #[must_use]
    #[inline]
    pub fn acceleration(&self, side: Side, x1: f64, x2: f64) -> f64 {
        let elastic_and_viscous = -x1 - self.viscous * x2;
        match side {
            Side::Below => elastic_and_viscous + self.curve.phi(self.belt_speed - x2),
            Side::Above => elastic_and_viscous - self.curve.phi(x2 - self.belt_speed),
        }
    }

    /// The drop j of friction as slip begins, see [`Curve::drop`].
    #[must_use]
    #[inline]
    pub fn drop(&self) -> f64 {
        self.curve.drop()
    }

    /// Jump of x2' across the belt line, from the field below it to that above: twice the friction at the
    /// onset of slip.
    #[must_use]
    pub fn jump(&self) -> f64 {
        2.0 * (1.0 - self.drop())
    }

    /// The x2' below which an orbit that arrives at the belt line from below sticks, and above whose negative
    /// one that arrives from above does: 2 - j. Friction at rest can hold arrivals with x2' between
    /// [`Oscillator::jump`] and this, which friction in slip would let pass.
    #[must_use]
    pub fn fastest_sticking(&self) -> f64 {
        2.0 - self.drop()
    }

    /// x1 at the exit point E = (1 - eps c V, V), through which every sticking orbit leaves.
    #[must_use]
    pub fn exit_x1(&self) -> f64 {
        1.0 - self.viscous * self.belt_speed
    }

    /// x1 at the other end of the stick segment, -1 - eps c V.
    pub fn upper_tangency_x1(&self) -> f64 {
        -1.0 - self.viscous * self.belt_speed
    }

    /// Classifies the point (x1, V) of the belt line.
    #[must_use]
    pub fn belt_region(&self, x1: f64) -> BeltRegion {
        let exit = self.exit_x1();
        let tangency = self.upper_tangency_x1();
        if x1 > exit {
            BeltRegion::CrossingDown
        } else if x1 == exit {
            BeltRegion::ExitPoint
        } else if x1 > tangency {
            BeltRegion::Sliding
        } else if x1 == tangency {
            BeltRegion::UpperTangency
        } else {
            BeltRegion::CrossingUp
        }
    }

    /// x1 of the equilibrium (phi(V), 0), the state of steady slip.
    #[must_use]
    pub fn equilibrium_x1(&self) -> f64 {
        self.curve.phi(self.belt_speed)
    }

    /// What small disturbances of the equilibrium do, to first order.
    #[must_use]
    pub fn stability(&self) -> Stability {
        HopfRate::new(&self.curve, self.belt_speed).stability(self.viscous)
    }

    /// The divergence at the equilibrium; 0 where it is not distinguishable from 0.
    pub fn equilibrium_divergence(&self) -> f64 {
        if self.stability() == Stability::Neutral { 0.0 } else { self.divergence(self.belt_speed) }
    }

    /// Eigenvalues of the linearisation at the equilibrium.
    #[must_use]
    pub fn eigenvalues(&self) -> Eigenvalues {
        let d = self.equilibrium_divergence();
        if d.abs() < 2.0 {
            Eigenvalues::Complex { re: 0.5 * d, im: ((1.0 - 0.5 * d) * (1.0 + 0.5 * d)).sqrt() }
        } else {
            // The larger root without cancellation; the product of the roots is 1.
            let fast = 0.5 * (d + d.signum() * ((d - 2.0) * (d + 2.0)).sqrt());
            Eigenvalues::Real { slow: 1.0 / fast, fast }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::Expression;
    use crate::point::LawParameters;

    /// The rounding that counts is that of the divergence, whatever the rates elsewhere; where D(V) is the difference of large
    /// terms, or flat friction is undamped, there is no sign.
    #[test]
    fn the_sign_of_the_divergence_counts_not_the_rates_elsewhere() {
        let built_in = |law: Law, parameters: &[f64]| law.curve(1.0, &LawParameters::new(parameters));
        let formula = |text: &str| {
            Law::Expression(Expression::new(text, 1.0).unwrap()).curve(1.0, &LawParameters::new(&[]))
        };
        for (curve, viscous, expected) in [
            // Nothing is left of the fall: D(V) = -eps c.
            (built_in(Law::Exponential, &[0.5, 1e-12, 0.0]), 3e-4, Stability::Attracts),
            (built_in(Law::Exponential, &[0.5, 1e-12, 0.0]), 1e-200, Stability::Attracts),
            (built_in(Law::Exponential, &[0.5, 1e-12, 0.0]), 0.0, Stability::Neutral),
            (formula("0.5 + 0.5*exp(-u/1e-9)"), 1e-9, Stability::Attracts),
            // exp(-200) of a fall is left, which no orbit shows.
            (built_in(Law::Exponential, &[0.5, 5e-3, 0.0]), 0.0, Stability::Neutral),
            (built_in(Law::Exponential, &[0.5, 5e-3, 0.0]), 1e-30, Stability::Attracts),
            // 1e12 / 2 / (1 + 1e12)^2 = 5e-13.
            (built_in(Law::Stribeck, &[0.5, 0.0, 1e12]), 5.1e-13, Stability::Attracts),
            (built_in(Law::Stribeck, &[0.5, 0.0, 1e12]), 4.9e-13, Stability::Repels),
            // 1e-8 / (1 + 1e-16)^2, less a damping that is the same to 16 digits.
            (built_in(Law::Lorentzian, &[0.5, 1e-4, 0.0]), 0.99999998e-8, Stability::Neutral),
            (built_in(Law::Lorentzian, &[0.5, 1e-4, 0.0]), 0.999999e-8, Stability::Repels),
            // 1e6 - 1e6 + 1e-12.
            (formula("1 - 1e6*u + 1e6*sin(u)/cos(1) - 1e-12*u"), 0.0, Stability::Neutral),
            (formula("1 - 0.5*u"), 0.5, Stability::Neutral),
            (formula("1 - 0.5*u"), 0.5 + 1e-14, Stability::Attracts),
        ] {
            let found = HopfRate::new(&curve, 1.0).stability(viscous);
            assert_eq!(found, expected, "{curve:?} {viscous:e}");
        }
    }
}

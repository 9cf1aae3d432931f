//! The exponential law of Tustin and of Bo and Pavelescu, with a viscous part:
//! `phi(u) = mu + (1 - mu) exp(-(u / vs)^delta) + eta u`, the curve of steady slip that engineers write. The
//! exponent delta is 1 unless the law has it as a parameter. It does not depend on eps.
//!
//! Above 1 the law starts flat, and the weakening rate rises to its maximum at u = vs ((delta - 1) / delta)^(1 /
//! delta). Between 1 and 2 its slope has no bound at rest, where it is (u / vs)^(delta - 1) to leading order.

use super::built_in::{BuiltIn, ClosedForm, Fall, ONSET, Strengthening, range_about_peak, rounded};
use super::expression::power;
use super::family::Series;
use super::{Gradient, Parameter, Range, mean};
use crate::point::LawParameters;
use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// The law with the exponent 1.
pub(super) const LAW: BuiltIn = BuiltIn {
    name: "exponential",
    formula: "mu + (1 - mu)*exp(-u/vs) + eta*u",
    of_coefficients: "mu_k + (mu_s - mu_k)*exp(-u/v_s) + eta*u",
    parameters: &PARAMETERS,
    depends_on_epsilon: false,
    phi_at: |u, _, parameters| {
        let &[mu, vs, eta] = parameters else { return None };
        Some(falling_from_one((-u / vs).exp(), u, mu, eta))
    },
    strengthening: Strengthening::Linear,
    parameters_of,
};

/// The law with the exponent as a parameter.
pub(super) const STRETCHED: BuiltIn = BuiltIn {
    formula: "mu + (1 - mu)*exp(-(u/vs)^exponent) + eta*u",
    of_coefficients: "mu_k + (mu_s - mu_k)*exp(-(u/v_s)^delta) + eta*u",
    parameters: &[PARAMETERS[0], PARAMETERS[1], PARAMETERS[2], EXPONENT],
    phi_at: |u, _, parameters| {
        let &[mu, vs, eta, exponent] = parameters else { return None };
        Some(falling_from_one((-power(u / vs, exponent)).exp(), u, mu, eta))
    },
    parameters_of: |friction, velocity| {
        let own = parameters_of(friction, velocity);
        let all: Vec<f64> = own.as_slice().iter().copied().chain([friction.exponent]).collect();
        LawParameters::new(&all)
    },
    ..LAW
};

/// mu, vs, eta, in this order; shared by the laws that fall from 1 to mu over the speed vs.
pub(super) const PARAMETERS: [Parameter; 3] = [
    Parameter { name: "mu", long_name: "kinetic to static friction ratio", min: 0.0, max: 1.0 },
    Parameter { name: "vs", long_name: "Stribeck velocity", min: f64::MIN_POSITIVE, max: f64::INFINITY },
    Parameter { name: "eta", long_name: "viscous strengthening of friction", min: 0.0, max: f64::INFINITY },
];

/// delta. Below 1 friction would fall infinitely fast as slip begins.
pub(super) const EXPONENT: Parameter =
    Parameter { name: "exponent", long_name: "exponent of the fall of friction", min: 1.0, max: 100.0 };

/// The curve at fixed parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exponential {
    /// 1 - mu.
    drop: f64,
    /// 1 / vs.
    rate: f64,
    eta: f64,
    exponent: f64,
    /// The slip speed of the largest weakening rate, in units of vs.
    steepest: f64,
    /// Whether the exponent is a parameter of the law.
    is_stretched: bool,
}

/// phi of a law that falls from 1 to mu as `rest` falls from 1 to 0.
pub(super) fn falling_from_one(rest: Series, u: Series, mu: Series, eta: Series) -> Series {
    mu + (Series::constant(1.0) - mu) * rest + eta * u
}

/// mu, vs and eta of a machine's friction.
pub(super) fn parameters_of(friction: &Fall, velocity: f64) -> LawParameters {
    LawParameters::new(&[friction.kinetic, friction.width / velocity, friction.strengthening * velocity])
}

/// -ln of the smallest normal number, 708.4, with an allowance for rounding.
const FALLEN: f64 = 750.0;

/// The power of the slip speed above which what is left of the fall, 4e-18, is below the rounding of a mean.
const GONE: f64 = 40.0;

/// A weakening rate that falls exponentially, for vectorised engines: with x = `rate` u it is `steepest exp(-x) - rise`, or
/// `steepest 2 x exp(-x^2) - rise`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ExponentialFall {
    /// Its part that falls, at rest.
    pub steepest: f64,
    /// 1 / vs.
    pub rate: f64,
    /// The rise of friction with the slip speed.
    pub rise: f64,
    /// Whether friction falls with the square of the slip speed: the exponent is 2, not 1.
    pub is_squared: bool,
}

impl ExponentialFall {
    /// The weakening rate.
    #[inline]
    #[must_use]
    pub fn at(&self, u: f64) -> f64 {
        let x = self.rate * u;
        let [power, lower] = if self.is_squared { [x * x, 2.0 * x] } else { [x, 1.0] };
        let rest = if power > FALLEN { 0.0 } else { lower * (-power).exp() };
        self.steepest * rest - self.rise
    }

    /// Its range over slip speeds >= 0, up to rounding: it rises up to its maximum, at rest where the exponent is 1, and falls from there.
    #[must_use]
    pub fn range(&self, lo: f64, hi: f64) -> Range {
        let peak = if self.is_squared { std::f64::consts::FRAC_1_SQRT_2 / self.rate } else { 0.0 };
        let at = |u: f64| Range { lo: self.at(u), hi: self.at(u) };
        range_about_peak(at, peak, lo, hi)
    }
}

impl Exponential {
    /// `None` for another exponent than 1 and 2.
    pub(super) fn fall(&self) -> Option<ExponentialFall> {
        let (steepest, is_squared) = (self.drop * self.rate, self.exponent == 2.0);
        let fall = ExponentialFall { steepest, rate: self.rate, rise: self.eta, is_squared };
        (self.exponent == 1.0 || is_squared).then_some(fall)
    }

    pub(super) fn new(parameters: &LawParameters) -> Self {
        let (mu, vs, eta, exponent, is_stretched) = match *parameters.as_slice() {
            [mu, vs, eta] => (mu, vs, eta, 1.0, false),
            [mu, vs, eta, exponent] => (mu, vs, eta, exponent, true),
            _ => unreachable!("an exponential point has mu, vs, eta and perhaps an exponent"),
        };
        let steepest = ((exponent - 1.0) / exponent).powf(1.0 / exponent);
        Self { drop: 1.0 - mu, rate: 1.0 / vs, eta, exponent, steepest, is_stretched }
    }

    /// x^delta and x^(delta - 1) of a slip speed x in units of vs. Below 0, where the flow is continued, powers
    /// that are not whole vanish.
    #[inline]
    fn powers(&self, x: f64) -> [f64; 2] {
        match self.exponent {
            1.0 => [x, 1.0],
            2.0 => [x * x, x],
            exponent if exponent.fract() == 0.0 => {
                let lower = Real::powi(x, exponent as i32 - 1);
                [x * lower, lower]
            }
            _ if x <= 0.0 => [0.0; 2],
            exponent => {
                let lower = x.powf(exponent - 1.0);
                [x * lower, lower]
            }
        }
    }

    /// What is left of the fall at the slip speed x, exp(-x^delta), and x^(delta - 1) times that.
    #[inline]
    fn rest(&self, x: f64) -> [f64; 2] {
        let [power, lower] = self.powers(x);
        // At high slip speed the power overflows, and an exponential that underflows takes ten times as long.
        if power > FALLEN {
            return [0.0; 2];
        }
        let rest = (-power).exp();
        [rest, lower * rest]
    }

    #[inline]
    pub(super) fn phi(&self, u: f64) -> f64 {
        1.0 + self.drop * (-self.powers(self.rate * u)[0]).exp_m1() + self.eta * u
    }

    #[inline]
    pub(super) fn weakening(&self, u: f64) -> f64 {
        self.drop * self.rate * (self.exponent * self.rest(self.rate * u)[1]) - self.eta
    }

    pub(super) fn formula<T: Real>(&self, u: T) -> T {
        let (c, x) = (T::constant, u * T::constant(self.rate));
        let power = if self.exponent == 1.0 { x } else { power(x, c(self.exponent)) };
        c(1.0) - c(self.drop) + c(self.drop) * (-power).exp() + c(self.eta) * u
    }

    /// Enclosures of the Taylor coefficients of phi at all slip speeds in `u`, in powers of the slip speed divided by
    /// `unit`.
    ///
    /// With g = (u / vs)^delta the coefficient k of exp(-g) is at most `(N delta (1 + g) unit / u)^k exp(-g)` in size,
    /// a polynomial in g with coefficients below that times exp(-g). Where that is below the normal numbers, interval
    /// arithmetic would know of exp(-g) only that it is, and multiply it by the powers of g.
    pub(super) fn series<const N: usize>(&self, u: Interval, unit: f64) -> Jet<Interval, N> {
        let variable = Jet::<Interval, N>::variable(u, unit);
        let power = self.powers(self.rate * u.lo)[0].min(f64::MAX);
        let factor = (N as f64 * self.exponent * (1.0 + power) * unit / u.lo).max(1.0);
        // What follows falls as the power grows.
        if !(power > FALLEN + N as f64 * factor.ln() && power > FALLEN + 2.0 * N as f64) {
            return self.formula(variable);
        }
        let c = Jet::constant;
        let Jet(rest) = c(1.0) - c(self.drop) + c(self.eta) * variable;
        let tiny = Interval::new(-f64::MIN_POSITIVE, f64::MIN_POSITIVE);
        Jet(rest.map(|coefficient| coefficient + tiny))
    }

    /// The slip speed at which the fall has come to exp(-`power`).
    fn fallen(&self, power: f64) -> f64 {
        power.powf(self.exponent.recip()) / self.rate
    }

    /// The mean weakening rate, see [`mean::about_peak`].
    pub(super) fn mean(&self, belt_speed: f64, halvings: u32) -> f64 {
        let falls = |u: f64| self.drop * self.rate * (self.exponent * self.rest(self.rate * u)[1]);
        let end = |power| self.fallen(power).min(2.0 * belt_speed);
        mean::about_peak(falls, end(1.0), end(GONE), belt_speed, halvings) - self.eta
    }

    /// Proved bounds of the weakening rate at one slip speed. With d the exponent, in units in the last place: x = u / vs has 1,
    /// x^(d - 1) has 1.5 d + 3 (4 of a power, or half of one for each factor), x^d two more, which the exponential multiplies
    /// by x^d and adds 4 to; 3 are of the factors. Where it is below the normal numbers it is wrong by less than these.
    fn bounds(&self, u: f64) -> Range {
        let x = self.rate * u;
        let scale = self.drop * self.rate * self.exponent;
        let roundings = (1.5 * self.exponent + 10.0) * (1.0 + self.powers(x)[0].min(FALLEN));
        rounded(scale * self.rest(x)[1], roundings, self.eta, scale)
    }

    /// The weakening rate rises up to its maximum, at rest where the exponent is 1, and falls from there.
    pub(super) fn weakening_range(&self, lo: f64, hi: f64) -> Range {
        range_about_peak(|u| self.bounds(u), self.steepest / self.rate, lo, hi)
    }
}

impl ClosedForm for Exponential {
    fn is_normal(&self) -> bool {
        self.rate.is_normal() && (self.drop == 0.0 || (self.drop * self.rate).is_normal())
    }

    fn gradient(&self, u: f64) -> Gradient {
        let x = self.rate * u;
        let ([power, _], [_, fade]) = (self.powers(x), self.rest(x));
        let fade = self.rate * self.exponent * fade;
        // Where the fade vanishes, powers may overflow.
        let faded = |factor: f64| if fade == 0.0 { 0.0 } else { self.drop * fade * factor };
        let by_vs = -self.rate * self.exponent * faded(1.0 - power);
        // At rest it tends to 0, but for the exponent 1, where it has no bound, next to rest only.
        let log = if x > 0.0 { x.ln() } else { 0.0 };
        let by_exponent = faded(1.0 / self.exponent + log * (1.0 - power));
        let all = [-fade, by_vs, -1.0, by_exponent];
        let own = if self.is_stretched { &all[..] } else { &all[..3] };
        Gradient { epsilon: 0.0, parameters: LawParameters::new(own) }
    }

    fn mean_weakening(&self, belt_speed: f64) -> f64 {
        // A fall over half of the circle or more, ten times faster.
        if self.has_known_features() && self.fallen(GONE) >= belt_speed {
            return mean::of_wide(|u| self.weakening(u), belt_speed);
        }
        self.mean(belt_speed, mean::HALVINGS)
    }

    fn cost(&self) -> u64 {
        if self.has_known_features() { 2 } else { 4 }
    }

    fn onset(&self) -> f64 {
        ONSET * self.rate.recip()
    }

    fn weakening_is_convex(&self) -> bool {
        self.exponent == 1.0
    }

    /// With other exponents the law has no derivatives at rest, or falls within a small share of vs.
    fn has_known_features(&self) -> bool {
        self.exponent == 1.0 || self.exponent == 2.0
    }

    /// The even part of exp(-(V - v) / vs) is exp(-V / vs) cosh(v / vs).
    fn even_weakening_range(&self, belt_speed: f64) -> Option<Range> {
        if self.exponent != 1.0 {
            return None;
        }
        let scale = self.drop * self.rate;
        let fade = (-2.0 * self.rate * belt_speed).exp();
        // The fade exp(-x) is wrong by 2 x + 4 units of its last place, less than 5 of 1.
        let hi = rounded(0.5 * scale * (1.0 + fade), 8.0, self.eta, scale).hi;
        Some(Range { lo: self.bounds(belt_speed).lo, hi })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn law(vs: f64, exponent: f64) -> Exponential {
        Exponential::new(&LawParameters::new(&[0.4, vs, 0.02, exponent]))
    }

    /// The maximum of the weakening rate, and values at high slip speed, where powers overflow.
    #[test]
    fn the_weakening_rate_has_one_maximum() {
        for exponent in [1.0, 1.001, 1.5, 2.0, 7.0, 100.0] {
            let law = law(0.5, exponent);
            let range = law.weakening_range(0.0, 4.0);
            let sampled = (0..=40_000).map(|i| law.weakening(1e-4 * f64::from(i))).fold(f64::MIN, f64::max);
            // Half the distance of the samples, squared, times half the curvature at a maximum of that width.
            let missed = 0.5 * (0.5e-4 * exponent / 0.5_f64).powi(2) * range.hi + 1e-4;
            assert!(range.hi >= sampled && range.hi - sampled < missed, "{exponent}: {range:?} {sampled}");
            assert_eq!((law.weakening(1e250), law.gradient(1e250).parameters.as_slice()[1]), (-0.02, 0.0));
        }
    }

    /// Far beyond vs the series are those of what is left, with a bound of the fall.
    #[test]
    fn series_hold_what_is_left_of_the_fall() {
        for (vs, exponent) in [(1e-12, 2.0), (1e-3, 30.0), (0.02, 1.5), (1.0, 1.5)] {
            let law = law(vs, exponent);
            for (lo, hi) in [(0.5, 1.0), (1.0, 1.001), (2.0, 2.0)] {
                let found = law.series::<14>(Interval::new(lo, hi), 0.25);
                for u in [lo, 0.5 * (lo + hi), hi] {
                    let exact = law.formula(Jet::<f64, 14>::variable(u, 0.25));
                    for (bounds, exact) in found.0.iter().zip(exact.0).filter(|(_, exact)| exact.is_finite())
                    {
                        // The formula in numbers is rounded.
                        let slack = 1e-12 * (1.0 + exact.abs());
                        assert!(
                            bounds.lo - slack <= exact && exact <= bounds.hi + slack,
                            "{vs} {exponent} {u}"
                        );
                    }
                }
                let widths = found.0.map(|bounds| bounds.hi - bounds.lo);
                assert!(vs > 0.01 || widths[2..].iter().all(|width| *width < 1e-300), "{widths:?}");
            }
        }
    }
}

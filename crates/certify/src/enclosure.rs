//! One step along an orbit in polar form, with proof: a polynomial that nearly solves dy/dth = F(th, y), and
//! a bound on the distance of orbits from it. The proofs of numbers of slip cycles ([`crate::slip_count`]) are made of such
//! steps.
//!
//! **Polynomial.** The Taylor polynomial of degree 6 of the solution that starts at a given number, with
//! rounded coefficients. Its defect y' - F and the integral of a second function along it are enclosed by
//! their Taylor series at the beginning of the step, the last coefficient over the whole step, in interval
//! arithmetic.
//!
//! **Distance.** Let |defect| <= d, and dF/dy <= L wherever the orbits may be during the step, of length s. A
//! distance e of an orbit from the polynomial grows over the step to at most (Gronwall)
//!
//! ```text
//! exp(L s) e + max(1, exp(L s)) s d.
//! ```

use slipmap_numbers::interval::Interval;
use slipmap_numbers::jet::{Jet, Real};

/// Number of Taylor coefficients of a step.
pub(crate) const ORDER: usize = 7;

/// The equation of an orbit, on numbers, intervals and series.
pub(crate) trait Polar {
    /// F, the function that is integrated along the orbit, and dth/dt; `None` for a law without formula.
    fn polar<T: Real>(&self, theta: T, y: T) -> Option<[T; 3]>;
}

/// The polynomial of a step, in powers of the angle since its beginning.
pub(crate) struct Polynomial {
    theta: f64,
    coefficients: [f64; ORDER],
}

/// Bounds proved along a polynomial over one step.
pub(crate) struct Enclosure {
    /// Taylor series of the polynomial at all angles of the step.
    pub(crate) along: Jet<Interval, ORDER>,
    /// Value of the polynomial at the end of the step.
    pub(crate) end: Interval,
    /// Bound on the size of the defect.
    pub(crate) defect: f64,
    /// The integral of the second function.
    pub(crate) integral: Interval,
    /// Lower bound of dth/dt.
    pub(crate) slowest: f64,
}

impl Polynomial {
    /// The step that begins at the angle `theta` and at `y`.
    pub(crate) fn new(orbit: &impl Polar, theta: f64, y: f64) -> Option<Self> {
        let mut coefficients = [0.0; ORDER];
        coefficients[0] = y;
        let angle = Jet::<f64, ORDER>::variable(theta, 1.0);
        for k in 1..ORDER {
            let [f, ..] = orbit.polar(angle, Jet(coefficients))?;
            coefficients[k] = f.0[k - 1] / k as f64;
        }
        Some(Self { theta, coefficients })
    }

    /// Encloses a step of length `width`; `None` where a bound is infinite.
    pub(crate) fn enclosed(&self, orbit: &impl Polar, width: Interval) -> Option<Enclosure> {
        let parts = |from: Interval| {
            let y = Jet::around(from, &self.coefficients);
            let angle = Jet::variable(Interval::of(self.theta) + from, 1.0);
            let [f, integrand, turning] = orbit.polar(angle, y)?;
            // y has degree ORDER - 1, so the last coefficient of dy/dth is zero.
            let defect: [Interval; ORDER] = std::array::from_fn(|k| match k + 1 < ORDER {
                true => y.0[k + 1] * Interval::of((k + 1) as f64) - f.0[k],
                false => -f.0[k],
            });
            Some((y, defect, integrand.0, turning.0[0].lo))
        };
        let span = Interval::new(0.0, width.hi);
        let (_, defect_0, integrand_0, _) = parts(Interval::of(0.0))?;
        let (along, defect_1, integrand_1, slowest) = parts(span)?;
        let last = ORDER - 1;
        let mut defect = defect_1[last] * span.powi(last as i32);
        let mut integral = integrand_1[last] * width.powi(ORDER as i32) / Interval::of(ORDER as f64);
        for k in 0..last {
            defect = defect + if k == 0 { defect_0[k] } else { defect_0[k] * span.powi(k as i32) };
            integral = integral + integrand_0[k] * width.powi(k as i32 + 1) / Interval::of((k + 1) as f64);
        }
        let end = width.polynomial(&self.coefficients);
        let is_bounded = defect.is_bounded() && integral.is_bounded() && along.0[0].is_bounded();
        is_bounded.then_some(Enclosure { along, end, defect: defect.size(), integral, slowest })
    }
}

/// Bounds on the distance of an orbit from the polynomial.
pub(crate) struct Distance {
    /// Bound during the step.
    pub(crate) during: Interval,
    /// Bound at the end of the step.
    pub(crate) after: Interval,
    /// exp(L s).
    pub(crate) growth: Interval,
}

/// Bounds the distance over a step of length `width` that begins with the distance `before`, where dF/dy lies
/// in `rate`.
pub(crate) fn distance(rate: Interval, width: Interval, before: Interval, defect: Interval) -> Distance {
    let growth = (Interval::of(rate.hi) * width).exp();
    let most = Interval::of(growth.hi.max(1.0));
    let added = most * width * defect;
    let after = Interval::of((growth * before + added).hi);
    Distance { during: most * before + added, after, growth }
}

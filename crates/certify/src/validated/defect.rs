//! From an approximate grazing orbit to a proved enclosure of the critical damping.
//!
//! # The argument
//! In the scaled groups the polar form for y = ln r is y' = F(theta, y, C) with
//!
//! ```text
//! F = D sin^2 / (1 + D sin cos),    D = A/q^2 - 2 b s - C,    q = 1 + k s,    s = 1 - e^y cos theta.
//! ```
//!
//! Let r0 be a trigonometric polynomial of degree M in theta with r0(0) = 1, positive, and C0 a number. Its
//! defect y0' - F(theta, y0, C0), y0 = ln r0, is G / (q^2 r0 (1 + D sin cos)) with
//!
//! ```text
//! G = r0' (q^2 + N sin cos) - N r0 sin^2,     N = A - q^2 (C0 + 2 b s):
//! ```
//!
//! a trigonometric polynomial of degree 4 M + 5, so that its values on enough equal angles bound it
//! everywhere ([`super::circle::riesz_factor`]). So do those of r0 and of r0 cos theta.
//!
//! Let |y - y0| <= [`TUBE`] and |C - C0| <= [`SPAN`] bound a tube. In it,
//!
//! ```text
//! dF/dy = -D'(s) r cos sin^2 / (1 + D sin cos)^2,    dF/dC = -sin^2 / (1 + D sin cos)^2.
//! ```
//!
//! The circle is cut into cells around every [`STRIDES`]-th sampled angle; in each, all quantities are
//! bounded over the tube, 1 + k s and 1 + D sin cos from below by positive numbers. That gives upper bounds
//!
//! ```text
//! L+ and L- of the integrals of the positive and the negative part of dF/dy,
//! X of the integral of |defect|,   S of that of |dF/dC|,   and a lower bound T of the latter.
//! ```
//!
//! Hence, as long as the solution y(theta; C) stays in the tube (Gronwall),
//!
//! ```text
//! |y - y0| <= e^L+ (X + S |C - C0|),      |y(2 pi; C0)| <= e^L+ X =: E,                         (1)
//! -dy(2 pi)/dC >= e^-L- T =: mu.
//! ```
//!
//! If eta > E/mu and the right side of (1) at |C - C0| = eta is below [`TUBE`], solutions cannot leave the
//! tube for |C - C0| <= eta; y(2 pi; C0 - eta) > 0 > y(2 pi; C0 + eta), and the angle increases along all of
//! them (1 + D sin cos > 0), so that they are orbits. At C0 - eta the orbit from the exit point comes back to
//! the belt line, at C0 + eta it does not; by monotonicity ([`super`]) C* lies between. []
//!
//! All numbers may depend on parameters in which r0 and C0 are polynomials, see [`super::tile`]: then samples
//! are taken over the parameters too, and one proof covers a whole box.

use super::circle::{Circle, reach, riesz_factor, walk};
use slipmap_numbers::interval::Interval;

/// Number of candidates that are best sampled together.
pub(super) const LANES: usize = 8;

/// Half-width of the tube in y.
const TUBE: f64 = 1e-3;
/// Half-width of the tube in C.
const SPAN: f64 = 1e-3;

/// Numbers of angles per cell, tried in this order; they divide the sizes of all circles.
const STRIDES: [usize; 2] = [8, 1];
/// Exponent in Gronwall's lemma up to which coarse cells are used.
const COARSE_EXPONENT: f64 = 2.0;

/// The groups A, k, b of a column, enclosed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Groups {
    pub(super) a: Interval,
    pub(super) k: Interval,
    pub(super) b: Interval,
}

/// Approximate grazing orbits, one in each of `L` vector lanes: exactly r0 = 1 + sum of `cosines` (cos n theta
/// - 1) + `sines` sin n theta.
pub(super) struct Candidates<'a, const L: usize> {
    pub(super) groups: [Groups; L],
    pub(super) viscous: [Interval; L],
    pub(super) cosines: &'a [[f64; L]],
    pub(super) sines: &'a [[f64; L]],
    /// Bound on the error of each coefficient.
    pub(super) error: f64,
}

/// The coefficients of a harmonic n of each candidate: a, b, -n a, n b.
type Harmonic<const L: usize> = [[f64; L]; 4];

/// Sums over harmonics at an angle theta, of each candidate: a cos n theta, b sin n theta, -n a sin n theta,
/// n b cos n theta.
type Sums<const L: usize> = [[f64; L]; 4];

impl<const L: usize> Candidates<'_, L> {
    /// Every second harmonic from the number `first` on.
    fn every_second(&self, first: usize) -> Vec<Harmonic<L>> {
        let mut harmonics = Vec::with_capacity(self.cosines.len().div_ceil(2));
        for n in (first..=self.cosines.len()).step_by(2) {
            let (a, b) = (self.cosines[n - 1], self.sines[n - 1]);
            harmonics.push([a, b, a.map(|a| -(n as f64) * a), b.map(|b| n as f64 * b)]);
        }
        harmonics
    }
}

/// A number in each lane, with a bound of its error, up to the rounding of that bound itself: some units for
/// each operation, for which [`SLACK`] is enough.
#[derive(Clone, Copy)]
struct Balls<const L: usize> {
    value: [f64; L],
    error: [f64; L],
}

/// Factor that exceeds the roundings of an error after some dozens of operations on [`Balls`].
const SLACK: f64 = 1.0 + 1024.0 * f64::EPSILON;
/// A sum or product is rounded by at most this share of the result.
const ROUNDING: f64 = 0.5 * f64::EPSILON;

impl<const L: usize> Balls<L> {
    fn of(intervals: [Interval; L]) -> Self {
        Self { value: intervals.map(|x| 0.5 * (x.lo + x.hi)), error: intervals.map(|x| x.hi - x.lo) }
    }

    #[inline(always)]
    fn same(value: f64, error: f64) -> Self {
        Self { value: [value; L], error: [error; L] }
    }

    #[inline(always)]
    fn plus(mut self, other: Self) -> Self {
        for lane in 0..L {
            self.value[lane] += other.value[lane];
            self.error[lane] += other.error[lane] + ROUNDING * self.value[lane].abs();
        }
        self
    }

    #[inline(always)]
    fn minus(self, mut other: Self) -> Self {
        for value in &mut other.value {
            *value = -*value;
        }
        self.plus(other)
    }

    #[inline(always)]
    fn times(mut self, other: Self) -> Self {
        for lane in 0..L {
            let (x, y) = (self.value[lane], other.value[lane]);
            let error = x.abs() * other.error[lane] + self.error[lane] * (y.abs() + other.error[lane]);
            self.value[lane] = x * y;
            // The last term covers underflow.
            self.error[lane] = error + (ROUNDING * (x * y).abs() + f64::MIN_POSITIVE);
        }
        self
    }
}

/// Samples of the candidates at every angle: arguments for the function whose vector width pulp selects at run
/// time.
struct Sampling<'a, const L: usize> {
    odd: &'a [Harmonic<L>],
    even: &'a [Harmonic<L>],
    /// 1 - sum of the cosines' coefficients, with the errors of the sums for r0.
    base: Balls<L>,
    /// Bound on the errors of the sums for r0'.
    slope_error: [f64; L],
    /// A, k and 2 b.
    groups: [Balls<L>; 3],
    viscous: Balls<L>,
    circle: &'a Circle,
}

/// What [`Sampling`] computes, of each candidate.
struct Samples<const L: usize> {
    /// r0 at each angle.
    radius: Vec<[f64; L]>,
    /// Bound on its errors.
    radius_error: [f64; L],
    /// Largest |r0'| and |G|, errors included.
    slope: [f64; L],
    defect: [f64; L],
}

impl<const L: usize> pulp::WithSimd for Sampling<'_, L> {
    type Output = Samples<L>;

    #[inline(always)]
    fn with_simd<S: pulp::Simd>(self, _: S) -> Samples<L> {
        let circle = self.circle;
        let size = circle.size();
        let [a, k, twice_b] = self.groups;
        let one = Balls::same(1.0, 0.0);
        let zeros = [0.0; L];
        let mut samples =
            Samples { radius: vec![zeros; size], radius_error: zeros, slope: zeros, defect: zeros };
        // Zero as long as all numbers are finite, then NaN, which maxima ignore.
        let mut overflow = zeros;
        for (j, (cos, sin)) in (0..=size / 4).zip(walk(&circle.cosine_middles, 0, 1)) {
            let odd = sums(self.odd, circle, j, j);
            let even = sums(self.even, circle, 2 * j, j);
            // The signs of the cosine and of the sine at theta_j, -theta_j, pi - theta_j and pi + theta_j. Those
            // of even harmonics are 1 and their product.
            for (at, [x, y]) in [
                (j, [1.0, 1.0]),
                ((size - j) % size, [1.0, -1.0]),
                (size / 2 - j, [-1.0, 1.0]),
                (size / 2 + j, [-1.0, -1.0]),
            ] {
                let (mut value, mut slope) = (Balls::same(0.0, 0.0), Balls::same(0.0, 0.0));
                slope.error = self.slope_error;
                for lane in 0..L {
                    value.value[lane] =
                        (even[0][lane] + x * odd[0][lane]) + y * (odd[1][lane] + x * even[1][lane]);
                    slope.value[lane] =
                        (even[3][lane] + x * odd[3][lane]) + y * (odd[2][lane] + x * even[2][lane]);
                }
                let cos = Balls::same(x * cos, circle.middle_error);
                let sin = Balls::same(y * sin, circle.middle_error);
                let r = self.base.plus(value);
                let s = one.minus(r.times(cos));
                let q = one.plus(k.times(s));
                let q2 = q.times(q);
                let numerator = a.minus(q2.times(self.viscous.plus(twice_b.times(s))));
                let advance = slope.times(q2.plus(numerator.times(sin.times(cos))));
                let g = advance.minus(numerator.times(r.times(sin.times(sin))));
                samples.radius[at] = r.value;
                for (lane, overflow) in overflow.iter_mut().enumerate() {
                    let largest = |most: &mut f64, x: f64| *most = if x > *most { x } else { *most };
                    let defect = g.value[lane].abs() + g.error[lane];
                    largest(&mut samples.radius_error[lane], r.error[lane]);
                    largest(&mut samples.slope[lane], slope.value[lane].abs() + slope.error[lane]);
                    largest(&mut samples.defect[lane], defect);
                    *overflow += 0.0 * defect;
                }
            }
        }
        for (lane, overflow) in overflow.iter().enumerate() {
            let finite = *overflow == 0.0;
            samples.defect[lane] = if finite { SLACK * samples.defect[lane] } else { f64::INFINITY };
            samples.slope[lane] *= SLACK;
            samples.radius_error[lane] *= SLACK;
        }
        samples
    }
}

/// The sums over harmonics n, n + 2, n + 4, .. at theta_j; `first` is n j.
#[inline(always)]
fn sums<const L: usize>(harmonics: &[Harmonic<L>], circle: &Circle, first: usize, j: usize) -> Sums<L> {
    let [mut even, mut odd, mut slope_odd, mut slope_even] = [[0.0; L]; 4];
    for ([a, b, minus_na, nb], (cos, sin)) in harmonics.iter().zip(walk(&circle.cosine_middles, first, 2 * j))
    {
        for lane in 0..L {
            even[lane] += a[lane] * cos;
            odd[lane] += b[lane] * sin;
            slope_odd[lane] += minus_na[lane] * sin;
            slope_even[lane] += nb[lane] * cos;
        }
    }
    [even, odd, slope_odd, slope_even]
}

/// Bounds on the errors of the sums of a candidate.
struct Errors {
    /// 1 - sum of the cosines' coefficients.
    base: Interval,
    value: f64,
    slope: f64,
}

impl Errors {
    /// Sums of products are computed in plain f64. For n terms c t with |t| <= 1, where t is known to within e
    /// and c to within f, the error is at most (n + 2) u sum|c| + e sum|c| + n f (with u = 2^-53 and (n + 2)^2
    /// u < 1), whatever the order of the sum; doubled, this covers the rounding of the bound itself.
    fn of<const L: usize>(candidates: &Candidates<L>, lane: usize, circle: &Circle) -> Self {
        let Candidates { cosines, sines, error, .. } = *candidates;
        let count = 2.0 * cosines.len() as f64;
        let (mut sum, mut weighted, mut base) = (0.0, 0.0, Interval::ONE);
        for (i, (a, b)) in cosines.iter().zip(sines).enumerate() {
            sum += a[lane].abs() + b[lane].abs();
            weighted += (i + 1) as f64 * (a[lane].abs() + b[lane].abs());
            base = base - Interval::of(a[lane]);
        }
        let unit = (count + 4.0) * 0.5 * f64::EPSILON + circle.middle_error;
        let (loose, tiny) = (error * count, f64::MIN_POSITIVE);
        Self {
            base: base + Interval::new(-loose, loose),
            value: 2.0 * (unit * sum + loose) + tiny,
            slope: 2.0 * (unit * weighted + loose * (cosines.len() as f64 + 1.0)) + tiny,
        }
    }
}

/// Maxima and hulls over the samples of one or many candidates.
#[derive(Clone, Debug)]
pub(super) struct Sampled {
    /// Largest |G|.
    defect: f64,
    /// Hull of r0 at each angle.
    radius: Vec<Interval>,
    /// Largest |r0'|.
    slope: f64,
    /// Hull of C0.
    viscous: Interval,
}

/// Factors from the maxima over samples to bounds everywhere.
#[derive(Clone, Copy, Debug)]
pub(super) struct Factors {
    /// Factor of G.
    pub(super) defect: f64,
    /// Factor of C0, and of r0 at the sampled angles, as functions of the parameters; 1 without parameters.
    pub(super) radius: f64,
    /// Factor of r0'.
    pub(super) slope: f64,
}

/// The circle on which candidates of `harmonics` harmonics are sampled, and its factors.
pub(super) fn sampling(harmonics: usize) -> Option<(&'static Circle, Factors)> {
    // The degree of G.
    let degree = 4 * harmonics + 5;
    let circle = Circle::with_at_least(degree * 5 / 2)?;
    let factor = |degree: usize| riesz_factor(degree, reach(circle.size()));
    Some((circle, Factors { defect: factor(degree), radius: 1.0, slope: factor(harmonics) }))
}

#[cfg(test)]
impl Sampled {
    /// Returns whether every sample lies within the bounds of a candidate that was sampled on the same
    /// angles.
    pub(super) fn is_within(&self, bounds: &Bounds) -> bool {
        let within = |inner: Interval, outer: Interval| outer.lo <= inner.lo && inner.hi <= outer.hi;
        self.defect <= bounds.defect.hi
            && self.slope <= bounds.slope.hi
            && within(self.viscous, bounds.viscous)
            && self.radius.iter().zip(&bounds.radius).all(|(&inner, &outer)| within(inner, outer))
    }
}

impl Sampled {
    /// Samples candidates on the circle; returns the maxima and hulls over all of them.
    pub(super) fn of<const L: usize>(candidates: &Candidates<L>, circle: &Circle) -> Self {
        let errors: [Errors; L] = std::array::from_fn(|lane| Errors::of(candidates, lane, circle));
        let mut base = Balls::of(std::array::from_fn(|lane| errors[lane].base));
        for (error, sums) in base.error.iter_mut().zip(&errors) {
            *error += sums.value;
        }
        let samples = pulp::Arch::new().dispatch(Sampling {
            odd: &candidates.every_second(1),
            even: &candidates.every_second(2),
            base,
            slope_error: std::array::from_fn(|lane| errors[lane].slope),
            groups: [
                Balls::of(candidates.groups.map(|groups| groups.a)),
                Balls::of(candidates.groups.map(|groups| groups.k)),
                Balls::of(candidates.groups.map(|groups| groups.b + groups.b)),
            ],
            viscous: Balls::of(candidates.viscous),
            circle,
        });
        let hull = |intervals: &mut dyn Iterator<Item = Interval>| {
            intervals.reduce(Interval::hull).unwrap_or(Interval::ENTIRE)
        };
        let radius = samples.radius.iter().map(|r| {
            hull(&mut r.iter().zip(samples.radius_error).map(|(r, error)| Interval::ball(*r, error)))
        });
        let most = |bounds: [f64; L]| bounds.into_iter().fold(0.0, f64::max);
        Self {
            defect: most(samples.defect),
            radius: radius.collect(),
            slope: most(samples.slope),
            viscous: hull(&mut candidates.viscous.into_iter()),
        }
    }

    /// The maxima and hulls over the samples of both.
    pub(super) fn with(mut self, other: &Sampled) -> Sampled {
        for (radius, other) in self.radius.iter_mut().zip(&other.radius) {
            *radius = radius.hull(*other);
        }
        Sampled {
            defect: self.defect.max(other.defect),
            radius: self.radius,
            slope: self.slope.max(other.slope),
            viscous: self.viscous.hull(other.viscous),
        }
    }
}

/// Bounds of a candidate at every angle and at all parameters. The proof uses the candidate only through
/// them.
#[derive(Clone, Debug)]
pub(super) struct Bounds {
    /// Bound of |G|.
    defect: Interval,
    /// Enclosure of r0 at each sampled angle.
    radius: Vec<Interval>,
    /// Bound of |r0'|.
    slope: Interval,
    /// Enclosure of C0.
    viscous: Interval,
}

impl Bounds {
    /// Widens samples to bounds: r0 at an angle and C0 are polynomials of the same degrees in the parameters,
    /// whose values between the samples may lie outside the samples' hull.
    pub(super) fn new(sampled: &Sampled, factors: &Factors) -> Self {
        Self {
            defect: Interval::of(sampled.defect) * Interval::of(factors.defect),
            radius: sampled.radius.iter().map(|&hull| widen(hull, factors.radius)).collect(),
            slope: Interval::of(sampled.slope) * Interval::of(factors.slope),
            viscous: widen(sampled.viscous, factors.radius),
        }
    }
}

/// Widens the hull of a polynomial's samples to a bound of the polynomial: the distance from the hull's
/// middle is itself a polynomial.
fn widen(hull: Interval, factor: f64) -> Interval {
    let middle = Interval::of(0.5 * (hull.lo + hull.hi));
    let distance = (hull - middle).size();
    middle + Interval::new(-1.0, 1.0) * (Interval::of(distance) * Interval::of(factor))
}

/// The integrals L+, L-, X, S and T of the module's text, summed over cells of `stride` sampled angles;
/// `None` where the tube leaves the domain of the polar form.
fn integrate(groups: &Groups, bounds: &Bounds, circle: &Circle, stride: usize) -> Option<[Interval; 5]> {
    let one = Interval::ONE;
    let Groups { a, k, b } = *groups;
    let twice_b = b + b;
    let size = circle.size();
    let half_step = reach(size).hi;
    let between = Interval::new(-half_step, half_step);
    let around = between * Interval::of(stride as f64);
    let e_to_the_tube = Interval::ball(1.0, 1.01 * TUBE);
    let change = between * bounds.slope;
    let viscous = bounds.viscous + Interval::new(-SPAN, SPAN);
    let [mut growth, mut decay, mut defect, mut response_most, mut response_least] = [Interval::ZERO; 5];
    for j in (0..size).step_by(stride) {
        // The angles of the cell; all angles of the cell are within half a step of them.
        let angles = (j + size - stride / 2)..=(j + size + stride / 2);
        let radius =
            angles.map(|i| bounds.radius[i % size]).reduce(Interval::hull).unwrap_or(Interval::ENTIRE);
        // Cosine and sine change by at most the angle, their product likewise.
        let (cos, sin) = (circle.cos(j), circle.sin(j));
        let (cos, sin, product) = (cos + around, sin + around, sin * cos + around);
        let sin2 = sin.square();
        let r0 = radius + change;
        let r = r0 * e_to_the_tube;
        let s = one - r * cos;
        let (q, q_most) = (Interval::of((one + k * s).lo), one + k * Interval::of(s.hi));
        if !(r0.lo > 0.0 && q.lo > 0.0) {
            return None;
        }
        // D falls with s.
        let linear = twice_b * s + viscous;
        let most = a.over(q.square()) - linear;
        let least = Interval::of(a.lo).over(q_most.square()) - linear;
        let speed = one + Interval::new(least.lo, most.hi) * product;
        if !(speed.lo > 0.0) {
            return None;
        }
        let speed2 = speed.square();
        let steep = (a * k).over(q.square() * q) + b; // -D'/2 at most, and at least 0
        let slope = (Interval::new(0.0, (steep + steep).hi) * r * cos * sin2).over(speed2);
        let floor = Interval::of((q.square() * r0 * speed).lo);
        let response = sin2.over(speed2);
        growth = growth + Interval::of(slope.hi.max(0.0));
        decay = decay + Interval::of((-slope.lo).max(0.0));
        defect = defect + bounds.defect.over(floor);
        response_most = response_most + Interval::of(response.hi);
        response_least = response_least + Interval::of(response.lo.max(0.0));
    }
    let width = (Interval::pi() + Interval::pi()).over(Interval::of((size / stride) as f64));
    Some([growth, decay, defect, response_most, response_least].map(|sum| sum * width))
}

/// A bound eta on |C* - C0| for all `groups`, whose candidates satisfy `bounds`; `None` where the proof
/// fails.
pub(super) fn radius_of_proof(groups: &Groups, bounds: &Bounds, circle: &Circle) -> Option<f64> {
    let integrals = STRIDES.iter().find_map(|&stride| {
        let is_enough = |[growth, decay, ..]: &[Interval; 5]| growth.hi + decay.hi < COARSE_EXPONENT;
        integrate(groups, bounds, circle, stride).filter(|found| stride == 1 || is_enough(found))
    });
    let [growth, decay, defect, response_most, response_least] = integrals?;
    let exp = |x: Interval| Interval::of(Interval::exp_bound(x.hi));
    let error = exp(growth) * defect;
    // E / mu; the factor makes the inequality strict.
    let eta = (error * exp(decay)).over(Interval::of(response_least.lo)) * Interval::of(1.0 + 1e-9);
    let eta = eta.hi.max(f64::MIN_POSITIVE);
    let excursion = error + exp(growth) * response_most * Interval::of(eta);
    (excursion.hi < TUBE && eta < SPAN).then_some(eta)
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_numbers::random::Random;

    /// Reproducible numbers between -1 and 1, of many sizes.
    fn numbers() -> impl Iterator<Item = f64> {
        let mut random = Random(0x5eed);
        std::iter::from_fn(move || {
            let size = 0.5f64.powi((random.bits() & 7) as i32);
            Some((2.0 * random.unit() - 1.0) * size)
        })
    }

    #[test]
    fn balls_hold_the_exact_results() {
        let mut numbers = numbers();
        let mut next = || numbers.next().unwrap();
        let mut rounded = 0;
        for _ in 0..10_000 {
            let (x, y) = (next(), next());
            let exact = |x: f64| Balls::<1>::same(x, 0.0);
            let product = exact(x).times(exact(y));
            // What rounding takes from a product, and from a sum, is a number itself.
            let lost = x.mul_add(y, -product.value[0]).abs();
            assert!(lost <= product.error[0], "{x} {y}");
            for (sum, y) in [(exact(x).plus(exact(y)), y), (exact(x).minus(exact(y)), -y)] {
                let shifted = sum.value[0] - x;
                let lost = (x - (sum.value[0] - shifted)) + (y - shifted);
                assert!(lost.abs() <= sum.error[0], "{x} {y}");
                rounded += u32::from(lost != 0.0);
            }
            rounded += u32::from(lost != 0.0);
            // Numbers at the ends of balls, with errors far above rounding.
            let (dx, dy) = (1e-3 * next().abs(), 1e-3 * next().abs());
            let (one, two) = (Balls::<1>::same(x, dx), Balls::<1>::same(y, dy));
            for (x, y) in [(x - dx, y - dy), (x - dx, y + dy), (x + dx, y - dy), (x + dx, y + dy)] {
                for (ball, number) in
                    [(one.times(two), x * y), (one.plus(two), x + y), (one.minus(two), x - y)]
                {
                    let distance = (number - ball.value[0]).abs();
                    assert!(distance <= ball.error[0] + 4.0 * f64::EPSILON, "{x} {y}");
                }
            }
        }
        assert!(rounded > 15_000, "{rounded}");
    }

    /// Samples of lanes are those of each alone, and where numbers overflow, or are none, nothing is bounded.
    #[test]
    fn lanes_are_sampled_like_each_alone() {
        let (circle, _) = sampling(5).unwrap();
        let mut numbers = numbers();
        let mut next = || numbers.next().unwrap();
        let mut row =
            |size: f64| (0..5).map(|_| [size * next(), size * next(), size * next()]).collect::<Vec<_>>();
        for size in [0.1, 1e200, f64::NAN] {
            let (cosines, sines) = (row(size), row(size));
            let groups = [0.1, 0.2, 0.3].map(|x| Groups {
                a: Interval::of(x),
                k: Interval::of(2.0 * x),
                b: Interval::new(x, x.next_up()),
            });
            let viscous = [0.01, 0.02, 0.03].map(Interval::of);
            let all = Candidates { groups, viscous, cosines: &cosines, sines: &sines, error: 1e-15 };
            let alone = |lane: usize| {
                let one = |row: &[[f64; 3]]| row.iter().map(|c| [c[lane]]).collect::<Vec<_>>();
                let (cosines, sines) = (one(&cosines), one(&sines));
                let candidates = Candidates {
                    groups: [groups[lane]],
                    viscous: [viscous[lane]],
                    cosines: &cosines,
                    sines: &sines,
                    error: 1e-15,
                };
                Sampled::of(&candidates, circle)
            };
            let (together, merged) = (Sampled::of(&all, circle), alone(0).with(&alone(1)).with(&alone(2)));
            assert_eq!(together.defect, merged.defect);
            assert_eq!(together.slope, merged.slope);
            assert_eq!(together.radius, merged.radius);
            assert_eq!(together.defect.is_finite(), size < 1.0);
        }
    }

    /// r0 at every angle, and the largest |r0'| and |G|, against interval arithmetic with the harmonics summed one
    /// by one.
    #[test]
    fn samples_meet_those_by_intervals() {
        let (circle, _) = sampling(4).unwrap();
        let mut numbers = numbers();
        let mut row = || (0..4).map(|_| [0.2 * numbers.next().unwrap()]).collect::<Vec<_>>();
        let (cosines, sines) = (row(), row());
        let groups = Groups { a: Interval::of(0.3), k: Interval::of(0.7), b: Interval::of(0.1) };
        let viscous = Interval::of(0.05);
        let candidate =
            Candidates { groups: [groups], viscous: [viscous], cosines: &cosines, sines: &sines, error: 0.0 };
        let sampled = Sampled::of(&candidate, circle);
        let (mut largest, mut steepest): (f64, f64) = (0.0, 0.0);
        for j in 0..circle.size() {
            let (mut r, mut slope) = (Interval::ONE, Interval::ZERO);
            for (n, ([a], [b])) in (1..).zip(cosines.iter().zip(&sines)) {
                let (a, b, count) = (Interval::of(*a), Interval::of(*b), Interval::of(n as f64));
                r = r + a * (circle.cos(n * j) - Interval::ONE) + b * circle.sin(n * j);
                slope = slope + count * (b * circle.cos(n * j) - a * circle.sin(n * j));
            }
            let (cos, sin) = (circle.cos(j), circle.sin(j));
            let s = Interval::ONE - r * cos;
            let q2 = (Interval::ONE + groups.k * s).square();
            let numerator = groups.a - q2 * (viscous + (groups.b + groups.b) * s);
            let g = slope * (q2 + numerator * (sin * cos)) - numerator * (r * sin.square());
            let radius = sampled.radius[j];
            assert!(radius.lo <= r.hi && r.lo <= radius.hi, "{j}: {radius:?} {r:?}");
            // A hundred roundings of numbers below 1.
            assert!(radius.hi - radius.lo < 100.0 * f64::EPSILON, "{j}: {radius:?}");
            largest = largest.max(g.lo.abs().min(g.hi.abs()));
            steepest = steepest.max(slope.lo.abs().min(slope.hi.abs()));
        }
        // The tables of cosines alone are known to a hundred roundings at most.
        assert!(
            largest <= sampled.defect && sampled.defect < largest * (1.0 + 1e-12),
            "{largest} {}",
            sampled.defect
        );
        assert!(
            steepest <= sampled.slope && sampled.slope < steepest * (1.0 + 1e-12),
            "{steepest} {}",
            sampled.slope
        );
    }
}

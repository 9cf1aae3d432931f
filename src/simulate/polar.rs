//! The lower flow in polar coordinates (theory, "Two forms of the slip flow"): with v = x2 = r cos th and
//! w = x2' = -r sin th,
//!
//! ```text
//! dr/dth = D r sin^2 th / (1 + D sin th cos th),    dt/dth = 1 / (1 + D sin th cos th),    D = D(V - v)
//! ```
//!
//! The state is delta = r/V - 1, which is zero at the exit point: the margin m/V = delta(2 pi) then has a
//! small *relative* error, which is what decides points next to grazing.

use crate::point::ScaledGroups;

/// The damping at which an orbit closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Closing {
    /// C = eps c.
    pub(super) viscous: f64,
    /// Estimate of its absolute error.
    pub(super) error: f64,
    /// Number of evaluations of the right-hand side.
    pub(super) rhs: u64,
}

/// The result of one turn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turn {
    /// The orbit completed the turn.
    Complete {
        /// m / V.
        margin: f64,
        /// Estimate of the absolute error of the margin.
        error: f64,
        /// Number of evaluations of the right-hand side, failed attempts included.
        rhs: u32,
    },
    /// The polar form does not apply (an overdamped node, or an orbit that runs far past the belt line), or
    /// the finest step misses the tolerance.
    HandOver {
        /// Number of evaluations spent.
        rhs: u32,
    },
}

/// exp(x) by its Taylor series to degree 9 at x / 2^`HALVINGS`, then as many squarings: to a few units in the
/// last place for |x| <= 0.09 * 2^`HALVINGS`, to 1e-8 for |x| <= 0.5 * 2^`HALVINGS`.
#[inline(always)]
pub(super) fn exp<const HALVINGS: u32>(x: f64) -> f64 {
    let y = x / f64::from(1_u32 << HALVINGS);
    let mut sum = 1.0 / 362_880.0;
    for inverse_factorial in
        [1.0 / 40_320.0, 1.0 / 5_040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0]
    {
        sum = y.mul_add(sum, inverse_factorial);
    }
    // expm1 keeps the accuracy of small arguments through the squarings: e(2y) = e(y) (2 + e(y)).
    let mut expm1 = y * sum;
    for _ in 0..HALVINGS {
        expm1 *= 2.0 + expm1;
    }
    1.0 + expm1
}

/// Number of orbits integrated together: two AVX2 registers or one AVX-512 register.
pub(super) const LANES: usize = 8;

/// Least rate of the angle, dth/dt, relative to the undamped oscillator. Near zero the polar angle is not
/// monotone in time (an overdamped node), and the point is handed over.
const SLOWEST_TURN: f64 = 0.05;

/// Trigonometric functions at an angle of the orbit.
#[derive(Clone, Copy, Debug)]
pub(super) struct Angle {
    pub(crate) cos: f64,
    pub(crate) sin_cos: f64,
    pub(crate) sin_squared: f64,
}

impl Angle {
    pub(super) fn new(theta: f64) -> Self {
        let (sin, cos) = theta.sin_cos();
        Self { cos, sin_cos: sin * cos, sin_squared: sin * sin }
    }
}

/// The divergence of [`LANES`] oscillators as a fraction of two polynomials, so that the polar field costs
/// one division.
#[derive(Clone, Debug)]
pub(super) struct Lanes {
    a: [f64; LANES],
    k: [f64; LANES],
    b2: [f64; LANES],
    c: [f64; LANES],
}

impl Lanes {
    /// Lanes of the scaled oscillators that `groups` returns.
    pub(super) fn new<'a>(groups: impl Fn(usize) -> &'a ScaledGroups) -> Self {
        let pick = |value: fn(&ScaledGroups) -> f64| std::array::from_fn(|lane| value(groups(lane)));
        Self { a: pick(|g| g.a), k: pick(|g| g.k), b2: pick(|g| 2.0 * g.b), c: pick(|g| g.c) }
    }

    /// d delta / d theta of every lane.
    ///
    /// `room` accumulates the smallest distance of each lane from the border of the domain of the polar form;
    /// a lane whose room is not positive at the end (or whose state is not finite) has no answer.
    #[inline(always)]
    pub(super) fn slope(&self, angle: Angle, delta: &[f64; LANES], room: &mut [f64; LANES]) -> [f64; LANES] {
        let mut slope = [0.0; LANES];
        for lane in 0..LANES {
            let r = 1.0 + delta[lane];
            let terms = self.terms(lane, angle, r, &mut room[lane]);
            slope[lane] = r * angle.sin_squared * terms.numerator / terms.turn;
        }
        slope
    }

    /// d ln r / d theta of every lane, and its derivatives; that by ln r only with `GROWTH`.
    #[inline(always)]
    pub(super) fn log_slope<const GROWTH: bool>(
        &self,
        angle: Angle,
        r: &[f64; LANES],
        room: &mut [f64; LANES],
    ) -> LogSlope {
        let [mut slope, mut by_c, mut by_log_r] = [[0.0; LANES]; 3];
        for lane in 0..LANES {
            let terms = self.terms(lane, angle, r[lane], &mut room[lane]);
            let inverse = 1.0 / terms.turn;
            let ratio = terms.q2 * inverse;
            slope[lane] = angle.sin_squared * terms.numerator * inverse;
            by_c[lane] = -angle.sin_squared * ratio * ratio;
            if GROWTH {
                // dD / d ln r = r cos theta (2 A k / q^3 + 2 b), and q2 times that without a division.
                let steepness =
                    (2.0 * self.a[lane] * self.k[lane]).mul_add(terms.q, self.b2[lane] * terms.q2 * terms.q2);
                by_log_r[lane] = angle.sin_squared * inverse * inverse * r[lane] * angle.cos * steepness;
            }
        }
        LogSlope { slope, by_c, by_log_r }
    }

    /// Changes C = eps c of every lane.
    #[inline(always)]
    pub(super) fn shift_damping(&mut self, change: &[f64; LANES]) {
        for (c, change) in self.c.iter_mut().zip(change) {
            *c += change;
        }
    }

    /// C = eps c of every lane.
    #[inline(always)]
    pub(super) fn damping(&self) -> &[f64; LANES] {
        &self.c
    }

    /// The divergence at scaled radius `r` as numerator / q2, and turn = q2 dth/dt.
    #[inline(always)]
    fn terms(&self, lane: usize, angle: Angle, r: f64, room: &mut f64) -> Terms {
        let s = (-r).mul_add(angle.cos, 1.0);
        let q = self.k[lane].mul_add(s, 1.0);
        let q2 = q * q;
        let linear = self.b2[lane].mul_add(s, self.c[lane]);
        let numerator = (-linear).mul_add(q2, self.a[lane]);
        let turn = numerator.mul_add(angle.sin_cos, q2);
        // q = 0 is the pole of the lower field continued above the belt line.
        let excess = (-SLOWEST_TURN).mul_add(q2, turn);
        let tightest = if excess < q - SLOWEST_TURN { excess } else { q - SLOWEST_TURN };
        *room = if tightest < *room { tightest } else { *room };
        Terms { numerator, q, q2, turn }
    }
}

/// See [`Lanes::log_slope`].
pub(super) struct LogSlope {
    /// d ln r / d theta.
    pub(crate) slope: [f64; LANES],
    /// Its derivative by C = eps c.
    pub(crate) by_c: [f64; LANES],
    /// Its derivative by ln r; zero if it was not requested.
    pub(crate) by_log_r: [f64; LANES],
}

/// See [`Lanes::terms`].
struct Terms {
    numerator: f64,
    q: f64,
    q2: f64,
    turn: f64,
}

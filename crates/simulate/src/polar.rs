//! The lower flow in polar coordinates (theory, "Two forms of the slip flow"): with v = x2 = r cos th and
//! w = x2' = -r sin th,
//!
//! ```text
//! dr/dth = D r sin^2 th / (1 + D sin th cos th),    dt/dth = 1 / (1 + D sin th cos th),    D = D(V - v)
//! ```
//!
//! The state is delta = r/V - 1, which is zero at the exit point: the margin m/V = delta(2 pi) then has a
//! small *relative* error, which is what decides points next to grazing.

use std::marker::PhantomData;

use slipmap_model::point::ScaledGroups;

/// The damping at which an orbit closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Closing {
    /// C = eps c.
    pub(super) viscous: f64,
    /// Estimate of its absolute error.
    pub(super) error: f64,
    /// Number of evaluations of the right-hand side.
    pub(super) rhs: u64,
    /// dC / d ln r, where it is known, and an estimate of its absolute error.
    pub(super) slope: Option<[f64; 2]>,
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

/// exp(x) for x <= 0 by its Taylor series to degree 13 at the remainder of x by ln 2; to a few units in the last place, and
/// not below the normal numbers.
#[inline(always)]
pub(super) fn exp_falling(x: f64) -> f64 {
    // ln 2 as a sum of two numbers, of which the first has zeros at its end.
    const LN_2: [f64; 2] = [0.693_147_180_369_123_8, 1.908_214_929_270_587_7e-10];
    // A number of this size has no fraction; its last bits are those of the exponent.
    const WHOLE: f64 = 6_755_399_441_055_744.0 + 1023.0;
    let x = if x > -708.0 { x } else { -708.0 };
    let shifted = x.mul_add(std::f64::consts::LOG2_E, WHOLE);
    let whole = shifted - WHOLE;
    let rest = whole.mul_add(-LN_2[1], whole.mul_add(-LN_2[0], x));
    let mut sum = 1.0 / 6_227_020_800.0;
    for inverse_factorial in [
        1.0 / 479_001_600.0,
        1.0 / 39_916_800.0,
        1.0 / 3_628_800.0,
        1.0 / 362_880.0,
        1.0 / 40_320.0,
        1.0 / 5_040.0,
        1.0 / 720.0,
        1.0 / 120.0,
        1.0 / 24.0,
        1.0 / 6.0,
        0.5,
        1.0,
        1.0,
    ] {
        sum = rest.mul_add(sum, inverse_factorial);
    }
    sum * f64::from_bits(shifted.to_bits() << 52)
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

/// A function f(x) of which a law's weakening rate is a multiple, as a fraction of two polynomials, so that
/// the polar field costs one division.
pub(super) trait Shape {
    /// Numerator and denominator of f(x).
    fn fraction(x: f64) -> [f64; 2];

    /// -f'(x) times the square of the denominator.
    fn fall(x: f64) -> f64;

    /// Distance of x from a real pole of f.
    fn distance(x: f64) -> f64;

    /// The least number of equal angles that resolve the poles of f on a circle around the equilibrium.
    fn fewest_angles(divergence: &Divergence) -> f64;
}

/// f(x) = 1 / x^2, of Stribeck's law.
pub(super) enum InverseSquare {}

impl Shape for InverseSquare {
    #[inline(always)]
    fn fraction(x: f64) -> [f64; 2] {
        [1.0, x * x]
    }

    #[inline(always)]
    fn fall(x: f64) -> f64 {
        2.0 * x
    }

    #[inline(always)]
    fn distance(x: f64) -> f64 {
        x
    }

    /// The pole is sqrt(2 / k) from the angle 0.
    fn fewest_angles(divergence: &Divergence) -> f64 {
        (1.0 + divergence.k).sqrt()
    }
}

/// f(x) = x / (1 + x^2)^2, of the Lorentzian law.
pub(super) enum LorentzianSlope {}

impl LorentzianSlope {
    /// Smallest distance of a pole from the real angles at which 256 angles reach rounding errors, which are
    /// exp(-36).
    const NEAREST_POLE: f64 = 36.0 / 256.0;
}

impl Shape for LorentzianSlope {
    #[inline(always)]
    fn fraction(x: f64) -> [f64; 2] {
        let root = x.mul_add(x, 1.0);
        [x, root * root]
    }

    #[inline(always)]
    fn fall(x: f64) -> f64 {
        let square = x * x;
        3.0_f64.mul_add(square, -1.0) * (square + 1.0)
    }

    #[inline(always)]
    fn distance(_: f64) -> f64 {
        f64::INFINITY
    }

    /// The poles x = +-i are at cos th = z, z = (start + k -+ i) / k. Their distance from the real angles is
    /// the arcosh of half the sum of |z - 1| and |z + 1|.
    fn fewest_angles(divergence: &Divergence) -> f64 {
        let Divergence { start, k, .. } = *divergence;
        let [near, far] = [start, start + 2.0 * k].map(|real| real.hypot(1.0) / k);
        let distance = (0.5 * (near + far)).acosh();
        if distance > Self::NEAREST_POLE { 2.0 / distance } else { f64::INFINITY }
    }
}

/// The divergence of an orbit in units of its amplitude, D = a f(start + k s) - b2 s - c with s = 1 - R cos
/// th.
#[derive(Clone, Copy, Debug)]
pub(super) struct Divergence {
    pub(super) a: f64,
    pub(super) start: f64,
    pub(super) k: f64,
    pub(super) b2: f64,
    pub(super) c: f64,
}

impl From<&ScaledGroups> for Divergence {
    /// The divergence of the grazing orbit.
    fn from(groups: &ScaledGroups) -> Self {
        Self { a: groups.a, start: 1.0, k: groups.k, b2: 2.0 * groups.b, c: groups.c }
    }
}

/// The divergences of [`LANES`] orbits.
pub(super) struct Lanes<F> {
    a: [f64; LANES],
    start: [f64; LANES],
    k: [f64; LANES],
    b2: [f64; LANES],
    /// C = eps c.
    pub(super) c: [f64; LANES],
    shape: PhantomData<F>,
}

impl<F: Shape> Lanes<F> {
    /// Lanes of the divergences that `of` returns.
    pub(super) fn new(of: impl Fn(usize) -> Divergence) -> Self {
        let pick = |value: fn(Divergence) -> f64| std::array::from_fn(|lane| value(of(lane)));
        let (a, start, k) = (pick(|of| of.a), pick(|of| of.start), pick(|of| of.k));
        Self { a, start, k, b2: pick(|of| of.b2), c: pick(|of| of.c), shape: PhantomData }
    }

    /// d delta / d theta of every lane.
    ///
    /// `room` accumulates the smallest distance of each lane from the border of the domain of the polar form;
    /// a lane whose room is not positive at the end (or whose state is not finite) is invalid.
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
            let ratio = terms.denominator * inverse;
            slope[lane] = angle.sin_squared * terms.numerator * inverse;
            by_c[lane] = -angle.sin_squared * ratio * ratio;
            if GROWTH {
                // dD / d ln r = r cos theta (b2 - a k f'), and the square of the denominator times that.
                let linear = self.b2[lane] * terms.denominator * terms.denominator;
                let steepness = (self.a[lane] * self.k[lane]).mul_add(F::fall(terms.x), linear);
                by_log_r[lane] = angle.sin_squared * inverse * inverse * r[lane] * angle.cos * steepness;
            }
        }
        LogSlope { slope, by_c, by_log_r }
    }

    /// The divergence at scaled radius `r` as numerator / denominator, and turn = denominator dth/dt.
    #[inline(always)]
    fn terms(&self, lane: usize, angle: Angle, r: f64, room: &mut f64) -> Terms {
        let s = (-r).mul_add(angle.cos, 1.0);
        let x = self.k[lane].mul_add(s, self.start[lane]);
        let [shape, denominator] = F::fraction(x);
        let linear = self.b2[lane].mul_add(s, self.c[lane]);
        let numerator = (-linear).mul_add(denominator, self.a[lane] * shape);
        let turn = numerator.mul_add(angle.sin_cos, denominator);
        // The lower field continued above the belt line may have a pole.
        let excess = (-SLOWEST_TURN).mul_add(denominator, turn);
        let distance = F::distance(x) - SLOWEST_TURN;
        let tightest = if excess < distance { excess } else { distance };
        *room = if tightest < *room { tightest } else { *room };
        Terms { numerator, denominator, turn, x }
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
    denominator: f64,
    turn: f64,
    x: f64,
}

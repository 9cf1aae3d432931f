//! The lower flow in polar coordinates (theory, "Two forms of the slip flow"): with v = x2 = r cos th and
//! w = x2' = -r sin th,
//!
//! ```text
//! dr/dth = D r sin^2 th / (1 + D sin th cos th),    dt/dth = 1 / (1 + D sin th cos th),    D = D(V - v)
//! ```

use slipmap_model::point::ScaledGroups;
use slipmap_numbers::Aligned;
use slipmap_numbers::TimesPlus as _;

/// The damping at which an orbit closes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closing {
    /// C = eps c.
    pub viscous: f64,
    /// Estimate of its absolute error.
    pub error: f64,
    /// Number of evaluations of the right-hand side.
    pub rhs: u64,
    /// dC / d ln r, where it is known, and an estimate of its absolute error.
    pub slope: Option<[f64; 2]>,
}

/// Number of orbits integrated together: two AVX2 registers or one AVX-512 register.
pub const LANES: usize = 8;
/// A number of each of them.
pub type Vector = Aligned<LANES>;

/// Least rate of the angle, dth/dt, relative to the undamped oscillator. Near zero the polar angle is not
/// monotone in time (an overdamped node), and the point is handed over.
const SLOWEST_TURN: f64 = 0.05;

/// Trigonometric functions at an angle of the orbit.
#[derive(Clone, Copy, Debug)]
pub struct Angle {
    pub cos: f64,
    pub sin_cos: f64,
    pub sin_squared: f64,
}

impl Angle {
    pub fn new(theta: f64) -> Self {
        let (sin, cos) = theta.sin_cos();
        Self { cos, sin_cos: sin * cos, sin_squared: sin * sin }
    }
}

/// The divergences of [`LANES`] orbits of Stribeck's law, D = a / (1 + k s)^2 - b2 s - c with s = 1 - R cos th.
pub struct Lanes {
    a: Vector,
    k: Vector,
    b2: Vector,
    /// C = eps c.
    pub c: Vector,
}

impl Lanes {
    /// Lanes of the groups that `of` returns.
    pub fn new(of: impl Fn(usize) -> ScaledGroups) -> Self {
        let pick = |value: fn(ScaledGroups) -> f64| Vector::from_fn(|lane| value(of(lane)));
        Self { a: pick(|of| of.a), k: pick(|of| of.k), b2: pick(|of| 2.0 * of.b), c: pick(|of| of.c) }
    }

    /// d ln r / d theta of every lane, and its derivatives; that by ln r only with `GROWTH`.
    ///
    /// `room` accumulates the smallest distance of each lane from the border of the domain of the polar form;
    /// a lane whose room is not positive at the end (or whose state is not finite) is invalid.
    #[inline(always)]
    pub fn log_slope<const GROWTH: bool>(&self, angle: Angle, r: &Vector, room: &mut Vector) -> LogSlope {
        let [mut slope, mut by_c, mut by_log_r] = [Vector::default(); 3];
        for lane in 0..LANES {
            let terms = self.terms(lane, angle, r[lane], &mut room[lane]);
            let inverse = 1.0 / terms.turn;
            let ratio = terms.denominator * inverse;
            slope[lane] = angle.sin_squared * terms.numerator * inverse;
            by_c[lane] = -angle.sin_squared * ratio * ratio;
            if GROWTH {
                // dD / d ln r = r cos theta (b2 + 2 a k / x^3), and the square of the denominator times that.
                let linear = self.b2[lane] * terms.denominator * terms.denominator;
                let steepness = (self.a[lane] * self.k[lane]).times_plus(2.0 * terms.x, linear);
                by_log_r[lane] = angle.sin_squared * inverse * inverse * r[lane] * angle.cos * steepness;
            }
        }
        LogSlope { slope, by_c, by_log_r }
    }

    /// The divergence at scaled radius `r` as numerator / denominator, and turn = denominator dth/dt.
    #[inline(always)]
    fn terms(&self, lane: usize, angle: Angle, r: f64, room: &mut f64) -> Terms {
        let s = (-r).times_plus(angle.cos, 1.0);
        let x = self.k[lane].times_plus(s, 1.0);
        let denominator = x * x;
        let linear = self.b2[lane].times_plus(s, self.c[lane]);
        let numerator = (-linear).times_plus(denominator, self.a[lane]);
        let turn = numerator.times_plus(angle.sin_cos, denominator);
        // The lower field continued above the belt line may have a pole.
        let excess = (-SLOWEST_TURN).times_plus(denominator, turn);
        let distance = x - SLOWEST_TURN;
        let tightest = if excess < distance { excess } else { distance };
        *room = if tightest < *room { tightest } else { *room };
        Terms { numerator, denominator, turn, x }
    }
}

/// See [`Lanes::log_slope`].
pub struct LogSlope {
    /// d ln r / d theta.
    pub slope: Vector,
    /// Its derivative by C = eps c.
    pub by_c: Vector,
    /// Its derivative by ln r; zero if it was not requested.
    pub by_log_r: Vector,
}

/// See [`Lanes::terms`].
struct Terms {
    numerator: f64,
    denominator: f64,
    turn: f64,
    x: f64,
}

//! Reference answers to some 25 digits in double-double arithmetic: the scalar form of the laws `stribeck` and `exponential`
//! without a drop, and the closed form of `coulomb`, whose flow is linear.
//!
//! One turn of the polar form (theory, "Two forms of the slip flow") by extrapolation (Gragg, Bulirsch and
//! Stoer): the modified midpoint rule has an error expansion in even powers of its step, so that `SEQUENCE`
//! gives a method of order 24 without tabulated coefficients. The number of equal steps is doubled until two
//! turns agree. The reference shares only the differential equation with the engines measured against it, and
//! that is checked against an integration in other variables (`tests/data/margins.csv`).

use std::sync::{LazyLock, OnceLock};

use super::double_double::{Double2, TAU};
use slipmap_model::friction::Law;
use slipmap_model::point::Point;

/// Numbers of midpoint steps.
const SEQUENCE: [usize; 12] = [2, 4, 6, 8, 10, 12, 14, 16, 18, 20, 22, 24];
/// Numbers of extrapolated steps per turn.
const STEPS: [usize; 5] = [8, 16, 32, 64, 128];
/// Two turns that agree to this tolerance are accurate to it. Rounding errors: a few thousand times 2^-106.
const AGREEMENT: f64 = 1e-24;
/// Least speed of the angle, and least distance from the pole of the friction law, for which the polar form
/// is used; as in the return map.
const SLOWEST_TURN: f64 = 0.05;
/// Number of Newton steps to a root: each nearly doubles the 16 digits at the start.
const ROOT_STEPS: usize = 3;

/// The divergence at s = u / V of an oscillator, computed without rounding to double precision.
#[derive(Clone, Copy, Debug)]
enum Divergence {
    /// A / (1 + k s)^2 - 2 b s - C.
    Stribeck { a: Double2, k: Double2, b: Double2, c: Double2 },
    /// A exp(-k s) - C.
    Exponential { a: Double2, k: Double2, c: Double2 },
}

/// A number to more digits than a double has, with a bound on its error.
#[derive(Clone, Copy, Debug)]
pub struct Exact {
    /// The number.
    pub value: Double2,
    /// Bound on its error.
    pub error: f64,
}

impl Exact {
    /// Distance of the double `from` from this number.
    pub(crate) fn distance(&self, from: f64) -> f64 {
        (self.value - from).value().abs()
    }
}

/// The reference answers of a column and of a cell.
#[derive(Clone, Copy, Debug)]
pub struct Reference {
    /// The scaled grazing margin m/V; `None` where the polar form does not apply.
    pub margin: Option<Exact>,
    /// The critical damping c* of the point's column, if there is one at c >= 0.
    pub critical: Option<Exact>,
    /// |dm/dc| / V at c*: the factor from an error of c to an error of the margin.
    pub slope: Option<f64>,
}

/// cos, sin cos and sin^2 at an angle.
type Angle = [Double2; 3];

/// The angles of every midpoint rule of one step.
type Rules = Vec<Vec<Angle>>;

/// The angles of every step.
fn angles(rung: usize) -> &'static [Rules] {
    static TABLES: LazyLock<[OnceLock<Vec<Rules>>; STEPS.len()]> = LazyLock::new(Default::default);
    TABLES[rung].get_or_init(|| {
        let angle = |step: usize, of: usize, parts: usize| -> Angle {
            let turns = Double2::from((step * parts + of) as f64) / (STEPS[rung] * parts) as f64;
            let (sin, cos) = (TAU * turns).sin_cos();
            [cos, sin * cos, sin * sin]
        };
        (0..STEPS[rung])
            .map(|step| {
                let rule = |&parts: &usize| (0..=parts).map(|of| angle(step, of, parts)).collect();
                SEQUENCE.iter().map(rule).collect()
            })
            .collect()
    })
}

/// The scaled grazing margin of the law `coulomb`, with friction 1 - drop + eta u in slip: x2 = exp(-h t) (V cos w t +
/// (h V - drop) / w sin w t) with 2 h = eta + eps c and w^2 = 1 - h^2, at its largest after the first minimum.
fn coulomb(point: &Point, damping: Double2) -> Option<Exact> {
    let &[drop, eta] = point.law.as_slice() else { return None };
    let h = (damping * point.epsilon + eta) * 0.5;
    let w = (Double2::from(1.0) - h * h).value();
    if w <= 0.0 || drop == 0.0 && h.value() == 0.0 {
        return None;
    }
    let w = (Double2::from(1.0) - h * h).sqrt();
    let (even, odd) = (Double2::from(point.belt_speed), (h * point.belt_speed - drop) / w);
    // x2' = exp(-h t) (p cos w t + q sin w t) vanishes where tan w t = -p / q: at the minimum, and half a turn later.
    let (p, q) = (odd * w - even * h, -(even * w) - odd * h);
    let mut angle = if drop == 0.0 {
        TAU
    } else {
        Double2::from((-p.value()).atan2(q.value()).rem_euclid(std::f64::consts::PI)) + TAU * 0.5
    };
    for _ in 0..2 {
        let (sin, cos) = angle.sin_cos();
        angle = angle - (p * cos + q * sin) / (q * cos - p * sin);
    }
    let (sin, cos) = angle.sin_cos();
    let x2 = (-(h * angle / w)).exp() * (even * cos + odd * sin);
    Some(Exact { value: x2 / point.belt_speed - 1.0, error: AGREEMENT })
}

impl Divergence {
    fn of(law: &Law, point: &Point, damping: Double2) -> Option<Self> {
        let epsilon = Double2::from(point.epsilon);
        let c = epsilon * damping;
        let one = Double2::from(1.0);
        match (law, point.law.as_slice()) {
            (Law::Stribeck, &[alpha, beta, gamma]) => {
                let rate = epsilon * gamma;
                let (a, k) = (rate * (one - alpha), rate * point.belt_speed);
                Some(Self::Stribeck { a, k, b: epsilon * beta * point.belt_speed, c })
            }
            // Without a drop, of exponent 1.
            (Law::Exponential, &[mu, vs, eta]) => Some(Self::Exponential {
                a: (one - mu) / vs,
                k: Double2::from(point.belt_speed) / vs,
                c: c + eta,
            }),
            _ => None,
        }
    }

    /// The divergence, and its distance from the pole of the law.
    fn at(&self, s: Double2) -> (Double2, f64) {
        match *self {
            Self::Stribeck { a, k, b, c } => {
                let q = Double2::from(1.0) + k * s;
                (a / (q * q) - c - b * s * 2.0, q.value())
            }
            Self::Exponential { a, k, c } => (a * (-(k * s)).exp() - c, 1.0),
        }
    }

    /// d delta / d theta with delta = r/V - 1; `None` outside the domain of the polar form.
    fn slope(&self, [cos, sin_cos, sin_squared]: &Angle, delta: Double2) -> Option<Double2> {
        let one = Double2::from(1.0);
        let r = one + delta;
        let (divergence, distance) = self.at(one - r * *cos);
        let turn = one + divergence * *sin_cos;
        // Written so that NaN is refused too.
        (turn.value() > SLOWEST_TURN && distance > SLOWEST_TURN).then(|| divergence * r * *sin_squared / turn)
    }

    /// delta after one turn.
    fn turn(&self, rung: usize) -> Option<Double2> {
        let step = TAU / STEPS[rung] as f64;
        let mut delta = Double2::from(0.0);
        for rules in angles(rung) {
            let mut row: Vec<Double2> = Vec::with_capacity(SEQUENCE.len());
            for (i, rule) in rules.iter().enumerate() {
                // Gragg's modified midpoint rule, then Aitken's and Neville's scheme in its step squared.
                let h = step / SEQUENCE[i] as f64;
                let (mut before, mut at) = (delta, delta + h * self.slope(&rule[0], delta)?);
                for angle in &rule[1..SEQUENCE[i]] {
                    (before, at) = (at, before + h * 2.0 * self.slope(angle, at)?);
                }
                let mut better = at;
                for (back, coarse) in (1..=i).zip(&mut row) {
                    let ratio = Double2::from(SEQUENCE[i] as f64) / SEQUENCE[i - back] as f64;
                    let next = better + (better - *coarse) / (ratio * ratio - 1.0);
                    *coarse = better;
                    better = next;
                }
                row.push(better);
            }
            delta = row[SEQUENCE.len() - 1];
        }
        Some(delta)
    }

    /// The scaled grazing margin m/V.
    fn margin(&self) -> Option<Exact> {
        let mut coarse = self.turn(0);
        for rung in 1..STEPS.len() {
            let fine = self.turn(rung);
            if let (Some(coarse), Some(fine)) = (coarse, fine) {
                let error = (fine - coarse).value().abs();
                if error <= AGREEMENT {
                    return Some(Exact { value: fine, error: error.max(AGREEMENT) });
                }
            }
            coarse = fine;
        }
        None
    }
}

/// The reference at a point of a law that has one. The root search of its column starts at `near`, a critical
/// damping in double precision.
#[must_use]
pub fn reference(law: &Law, point: &Point, near: Option<f64>) -> Reference {
    let margin = |damping: Double2| match law {
        Law::Coulomb => coulomb(point, damping),
        _ => Divergence::of(law, point, damping)?.margin(),
    };
    let own = margin(Double2::from(point.damping));
    let root = near.filter(|c| *c >= 0.0).and_then(|near| {
        let mut c = Double2::from(near);
        // One slope is enough: each step multiplies the error by the relative error of the slope.
        let apart = 1e-7 * near.max(1e-3);
        let slope = (margin(c + apart)?.value - margin(c - apart)?.value) / (2.0 * apart);
        let mut last = f64::INFINITY;
        for _ in 0..ROOT_STEPS {
            let change = margin(c)?.value / slope;
            c = c - change;
            last = change.value().abs();
        }
        let slope = slope.value().abs();
        Some((Exact { value: c, error: last + AGREEMENT / slope }, slope))
    });
    Reference { margin: own, critical: root.map(|(c, _)| c), slope: root.map(|(_, slope)| slope) }
}

//! Features of a law that the nodes of a backbone do not show.
//!
//! The error of a backbone is estimated from its last coefficients, which miss a change of C between two
//! nodes only. To first order C(r) is the mean of w over the circle of radius r with the weight sin^2,
//!
//! ```text
//! C(r) = 4 / (pi r) * integral from 0 to r of e(s) sqrt(1 - s^2 / r^2) ds,    e(s) = (w(V - s) + w(V + s)) / 2
//! ```
//!
//! Where e is a polynomial, C is one of the same degree. So the backbone misses at most 4 / pi times the mean
//! over [0, r] of the distance of e from the polynomial through its values at the nodes. That distance is
//! taken at the ends of the law's pieces and half-way between them, as densely as its features require. Where
//! the last coefficients of e show an error of that size, so do those of C.

use std::f64::consts::PI;

use super::panel::{largest, truncation_error};
use slipmap_model::friction::Curve;
use slipmap_numbers::chebyshev::{coefficients, node, sum};

/// Size of a missed feature, in units of the largest |e|, that is within the errors of the law's polynomials.
const ROUNDING: f64 = 1e-9;

/// Features of a law that a backbone may miss.
pub(super) struct Hidden {
    /// Bound of their effect on C.
    pub(super) error: f64,
    /// The amplitudes at which orbits touch them.
    pub(super) amplitudes: Vec<f64>,
}

impl Hidden {
    /// Features that the nodes of a backbone with one polynomial may miss; `None` if there are none. Closed
    /// forms have none: their one scale begins at rest. Nor have data, which are as dense as their corners.
    pub(super) fn of(curve: &Curve, belt_speed: f64, intervals: usize) -> Option<Self> {
        if curve.has_known_features() {
            return None;
        }
        let weakening = curve.compiled(4.0 * belt_speed);
        let even = |r: f64| 0.5 * (weakening.at(belt_speed - r) + weakening.at(belt_speed + r));
        let radius = |x: f64| 0.5 * belt_speed * (1.0 + x);
        let values: Vec<f64> = (0..=intervals).map(|i| even(radius(node(i, intervals)))).collect();
        let series = coefficients(&values);
        let known = truncation_error(&series).max(ROUNDING * largest(&values));
        let mut ends: Vec<f64> = weakening.breaks().iter().map(|end| (end - belt_speed).abs()).collect();
        ends.retain(|amplitude| 0.0 < *amplitude && *amplitude < belt_speed);
        ends.push(belt_speed);
        ends.sort_by(f64::total_cmp);
        let (mut error, mut amplitudes) = (0.0, Vec::new());
        let (mut integral, mut last) = (0.0_f64, [0.0, 0.0]);
        for end in ends {
            for r in [0.5 * (last[0] + end), end] {
                let distance = (even(r) - sum(&series, 2.0 * r / belt_speed - 1.0)).abs();
                integral += 0.5 * (r - last[0]) * (distance + last[1]);
                error = f64::max(error, 4.0 / PI * integral / r);
                if distance > known {
                    amplitudes.push(r);
                }
                last = [r, distance];
            }
        }
        (error > known).then_some(Self { error, amplitudes })
    }
}

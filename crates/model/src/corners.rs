//! Shortens steps so that they end at the corners of a measured law, and pass over no layer of a smooth one.
//!
//! Where phi is given by data, D is continuous and piecewise smooth. A step across a corner of D has an error
//! of low order that the embedded estimates, made for smooth fields, may miss by orders of magnitude. So
//! steps are shortened until they end at the corner, as they are at any other event.
//!
//! A smooth law may be flat but for a layer. A step that passes over the layer has no stage in it, and its error estimate
//! tells nothing of it. So a step ends in the layer of the compiled law, a few pieces, in which it begins, or in the next one:
//! every layer is seen by a stage.

use super::friction::{Curve, Weakening};
use slipmap_numbers::TimesPlus as _;
use std::sync::Arc;

/// A step meets a corner if it ends this close to it: `WIDTH` in the variable of integration, `ROUNDING`
/// relative to the speeds whose difference is the slip speed. D is wrong by its change of slope times the
/// distance, for the time that the orbit takes for it: the effect is of second order in `WIDTH`.
pub const WIDTH: f64 = 1e-9;
const ROUNDING: f64 = 1e-13;

/// The shortest step to a corner, in units of the time scale of the flow: over a shorter one the change of D
/// is as small as its rounding errors, and the corner may be passed.
pub const LEAST_STEP: f64 = 1e-11;

/// Ratio of the slip speeds, from [`Curve::onset`] on, at the ends of a step of a law with one scale.
const RATIO: f64 = 4.0;
/// Rounding error of a slip speed on the way back to the belt line, in units of V.
const ROUNDED_SLIP: f64 = 16.0 * f64::EPSILON;
/// Share of the way to the farthest end that a shortened step is meant to go, so that one trial is enough.
const SHORT_OF_END: f64 = 0.9;

/// The pieces of a law, of which a step passes over none.
#[derive(Clone, Debug)]
pub struct Layers {
    /// The compiled law; `None` for a law with one scale at rest, whose pieces are factors of [`RATIO`].
    compiled: Option<Arc<Weakening>>,
    onset: f64,
    /// The slip speed below which there is rounding alone on the way back to the line.
    rounded: f64,
}

impl Layers {
    /// Those of a law for orbits up to the slip speed `fastest`.
    pub fn of(curve: &Curve, belt_speed: f64, fastest: f64) -> Self {
        Self {
            compiled: (!curve.has_known_features()).then(|| curve.compiled(fastest)),
            onset: curve.onset(belt_speed),
            rounded: ROUNDED_SLIP * belt_speed,
        }
    }

    /// The slip speeds at which a step that begins at the slip speed `slip` may be.
    #[inline]
    pub fn around(&self, slip: f64) -> [f64; 2] {
        let Some(compiled) = &self.compiled else {
            let is_far = slip > RATIO * self.onset.max(self.rounded);
            let low = if is_far { slip / RATIO } else { f64::NEG_INFINITY };
            return [low, RATIO * slip.max(self.onset)];
        };
        // The pieces are [0, end], [end, end], ..., and one beyond the last end.
        let ends = compiled.layers();
        let piece = ends.partition_point(|end| *end <= slip);
        let low = if piece < 2 { f64::NEG_INFINITY } else { ends[piece - 2] };
        [low, ends.get(piece + 1).copied().unwrap_or(f64::INFINITY)]
    }

    /// The longest step from here that passes over no piece, if the rate of the slip speed changes as `turning` > 0 tells.
    #[inline]
    pub fn longest(&self, from: End, turning: f64) -> f64 {
        let [low, high] = self.around(from.slip);
        let (way, bend) =
            if from.rate < 0.0 { (from.slip - low, -turning) } else { (high - from.slip, turning) };
        let root = from.rate.times_plus(from.rate, 2.0 * bend * way);
        // On the way back it may turn before it is there.
        if root >= 0.0 && way.is_finite() {
            2.0 * way / (from.rate.abs() + root.sqrt())
        } else {
            f64::INFINITY
        }
    }

    /// The next trial length if a trial step of length `h` passes over a piece; `None` if it passes over none.
    pub fn shortened(&self, [from, to]: [End; 2], h: f64) -> Option<f64> {
        let [low, high] = self.around(from.slip);
        let turns = h * from.rate / (from.rate - to.rate);
        if to.slip < low || to.slip > high {
            let way = SHORT_OF_END * (if to.slip < low { low } else { high } - from.slip);
            // By the parabola through both ends.
            let bend = (to.slip - from.slip - from.rate * h) / (h * h);
            let root = from.rate.times_plus(from.rate, 4.0 * bend * way).max(0.0).sqrt();
            let next = 2.0 * way / (from.rate + root.copysign(way));
            return Some(if next > 0.0 && next < h { next } else { 0.5 * h });
        }
        // The slip speed has an extreme inside the step. The rates at the ends bound its excess over the ends.
        if from.rate * to.rate < 0.0 && turns > 0.0 && turns < h {
            let excess = (from.rate * turns).abs().min((to.rate * (h - turns)).abs());
            let [least, most] = [from.slip.min(to.slip) - excess, from.slip.max(to.slip) + excess];
            let passes = if from.rate > 0.0 { most > high } else { least < low };
            return passes.then_some(turns);
        }
        None
    }
}

/// One end of a trial step.
#[derive(Clone, Copy, Debug)]
pub struct End {
    /// The slip speed there.
    pub slip: f64,
    /// Its rate of change in the variable of integration.
    pub rate: f64,
}

/// The next trial length if a trial step of length `h` contains one of `corners`, increasing slip speeds;
/// `None` if it contains none.
pub fn shortened(corners: &[f64], belt_speed: f64, [from, to]: [End; 2], h: f64) -> Option<f64> {
    if corners.is_empty() || !(from.slip.is_finite() && to.slip.is_finite()) {
        return None;
    }
    let (low, high) = (from.slip.min(to.slip), from.slip.max(to.slip));
    let rounding = ROUNDING * (belt_speed + high.abs());
    let [after_from, before_to] = [from, to].map(|end| WIDTH * end.rate.abs() + rounding);
    let [after_low, before_high] =
        if from.slip <= to.slip { [after_from, before_to] } else { [before_to, after_from] };
    if let Some(corner) = first_within(corners, from.slip, [low + after_low, high - before_high]) {
        let newton = h - (to.slip - corner) / to.rate;
        let secant = h * (corner - from.slip) / (to.slip - from.slip);
        return Some(if newton > 0.0 && newton < h { newton } else { secant });
    }
    // The slip speed has an extreme inside the step. The rates at the ends bound its excess over the ends.
    let turns = h * from.rate / (from.rate - to.rate);
    if from.rate * to.rate < 0.0 && turns > 0.0 && turns < h {
        let excess = (from.rate * turns).abs().min((to.rate * (h - turns)).abs());
        let outside =
            if from.rate > 0.0 { [high + rounding, high + excess] } else { [low - excess, low - rounding] };
        return first_within(corners, from.slip, outside).map(|_| turns);
    }
    None
}

/// The corner in [lo, hi] that is nearest to `from`, which lies outside.
fn first_within(corners: &[f64], from: f64, [lo, hi]: [f64; 2]) -> Option<f64> {
    let start = corners.partition_point(|corner| *corner < lo);
    let end = corners.partition_point(|corner| *corner <= hi);
    let inside = corners.get(start..end)?;
    if from <= lo { inside.first().copied() } else { inside.last().copied() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_end_at_corners_inside_them() {
        let end = |slip, rate| End { slip, rate };
        let step = |from, to| shortened(&[0.5, 1.0], 1.0, [from, to], 0.2);
        // A corner between the ends of a straight step, none, and one beyond both ends, where the slip speed turns.
        assert!((step(end(0.9, 1.0), end(1.1, 1.0)).unwrap() - 0.1).abs() < 1e-15);
        assert_eq!(step(end(0.6, 1.0), end(0.8, 1.0)), None);
        assert_eq!(step(end(0.95, 1.0), end(0.95, -1.0)), Some(0.1));
        assert_eq!(step(end(0.55, -1.0), end(0.55, 1.0)), Some(0.1));
        assert_eq!(step(end(0.7, -1.0), end(0.7, 1.0)), None);
        assert_eq!(step(end(0.9, 1.0), end(f64::NAN, 1.0)), None);
    }
}

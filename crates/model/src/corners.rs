//! Shortens steps so that they end at the corners of a measured law.
//!
//! Where phi is given by data, D is continuous and piecewise smooth. A step across a corner of D has an error
//! of low order that the embedded estimates, made for smooth fields, may miss by orders of magnitude. So
//! steps are shortened until they end at the corner, as they are at any other event.

/// A step meets a corner if it ends this close to it: `WIDTH` in the variable of integration, `ROUNDING`
/// relative to the speeds whose difference is the slip speed. D is wrong by its change of slope times the
/// distance, for the time that the orbit takes for it: the effect is of second order in `WIDTH`.
pub const WIDTH: f64 = 1e-9;
const ROUNDING: f64 = 1e-13;

/// The shortest step to a corner, in units of the time scale of the flow: over a shorter one the change of D
/// is as small as its rounding errors, and the corner may be passed.
pub const LEAST_STEP: f64 = 1e-11;

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

//! Readings averaged: those at one slip speed, and many that scatter.

use std::collections::HashSet;

/// The means of the readings at each slip speed.
#[derive(Clone, Debug, PartialEq)]
pub struct Means {
    /// Slip speeds and mean friction.
    pub data: Vec<(f64, f64)>,
    /// Standard errors of the means; `None` where all readings of each speed are equal.
    pub standard_errors: Option<Vec<f64>>,
    /// Position of the first reading of each mean.
    pub first: Vec<usize>,
}

/// Averages neighbouring readings at equal slip speeds; `None` if there are none.
///
/// All readings are taken to scatter alike: their variance is that about the means, of all speeds together,
/// since two or three readings of one speed tell little of it. A mean of n readings has the standard error
/// sqrt(variance / n).
pub fn means(readings: &[(f64, f64)]) -> Option<Means> {
    let (mut data, mut first, mut counts) = (Vec::new(), Vec::new(), Vec::new());
    let (mut squares, mut position) = (0.0, 0);
    for same in readings.chunk_by(|one, next| one.0 == next.0) {
        let count = same.len() as f64;
        // From the first reading, so that the mean of equal readings is that reading.
        let reference = same[0].1;
        let mean = reference + same.iter().map(|(_, friction)| friction - reference).sum::<f64>() / count;
        squares += same.iter().map(|(_, friction)| (friction - mean).powi(2)).sum::<f64>();
        data.push((same[0].0, mean));
        first.push(position);
        counts.push(count);
        position += same.len();
    }
    let repeated = readings.len() - data.len();
    let variance = squares / repeated as f64;
    let standard_errors =
        (variance > 0.0).then(|| counts.iter().map(|count| (variance / count).sqrt()).collect());
    (repeated > 0).then_some(Means { data, standard_errors, first })
}

/// An estimate of the friction at one slip speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Knot {
    /// The slip speed.
    pub speed: f64,
    /// The friction there.
    pub friction: f64,
    /// Its standard error.
    pub error: f64,
}

/// Least number of readings of a segment.
const FEWEST: usize = 8;
/// Mean square of the two terms of higher order, in units of the variance of the readings, above which a segment is
/// not straight: about one straight segment in a hundred has more by chance.
const BENT: f64 = 5.0;

/// Divides readings, sorted by slip speed, into segments in which the friction is a straight line within their
/// scatter, and gives each by the values of that line at two slip speeds, whose errors are independent: with the
/// mean m of the speeds, their variance s^2 and n readings of variance v, the values at m - a and m + b have the
/// covariance (1 - a b / s^2) v / n, which vanishes for a b = s^2. The fastest reading is the last such speed. What the
/// segment bends more than by chance, if too little to be divided, is part of the errors.
///
/// Readings of a record over time are not independent where they follow one another: those of each of its
/// `passages`, whose numbers are given, count as one. Also returns the standard deviation of the readings in the
/// slowest segment.
pub fn segments(readings: &[(f64, f64)], passages: Option<&Vec<usize>>) -> (Vec<Knot>, f64) {
    let mut segments = Vec::new();
    divide(readings, 0, passages.map(Vec::as_slice), &mut segments);
    let spread = segments.first().map_or(0.0, |segment| segment.variance.sqrt());
    let last = segments.len() - 1;
    let mut knots: Vec<Knot> = Vec::new();
    for (i, segment) in segments.into_iter().enumerate() {
        let Segment { mean, s2, level, slope, variance, independent, fastest, .. } = segment;
        let after = if i == last { fastest - mean } else { s2.sqrt() };
        if !(s2 > 0.0) {
            let error = (variance / independent).sqrt();
            knots.push(Knot { speed: mean, friction: level, error });
            continue;
        }
        knots.extend([-s2 / after, after].map(|from| Knot {
            speed: mean + from,
            friction: level + slope * from,
            error: (variance / independent * (1.0 + from * from / s2) + segment.bend(mean + from)).sqrt(),
        }));
    }
    // Knots of neighbouring segments of uneven readings may overlap.
    knots.sort_by(|one, other| one.speed.total_cmp(&other.speed));
    knots.dedup_by(|next, one| next.speed <= one.speed);
    knots.retain(|knot| knot.speed > 0.0);
    (knots, spread)
}

/// Readings on a straight line.
struct Segment {
    /// Mean and variance of the slip speeds.
    mean: f64,
    s2: f64,
    /// Friction at the mean, and the slope.
    level: f64,
    slope: f64,
    /// Variance of the readings about the line.
    variance: f64,
    /// Number of independent readings.
    independent: f64,
    fastest: f64,
    /// Middle and half of the range of the speeds, and there the terms of higher order, as coefficients of powers.
    middle: f64,
    half: f64,
    bends: [[f64; TERMS]; 2],
}

impl Segment {
    /// The mean square of what the segment bends away from the line at a slip speed.
    fn bend(&self, speed: f64) -> f64 {
        let x = (speed - self.middle) / self.half;
        let of = |bend: &[f64; TERMS]| bend.iter().rev().fold(0.0, |sum, coefficient| sum * x + coefficient);
        self.bends.iter().map(|bend| of(bend).powi(2)).sum()
    }
}

/// Number of terms of the polynomials, up to the third power.
const TERMS: usize = 4;

/// Appends the segments of the readings, the first of which has the position `from` among all.
fn divide(readings: &[(f64, f64)], from: usize, passages: Option<&[usize]>, segments: &mut Vec<Segment>) {
    let n = readings.len();
    let count = n as f64;
    let independent = passages.map_or(count, |passages| different(&passages[from..from + n]));
    let (low, high) = (readings[0].0, readings[n - 1].0);
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    // Polynomials of degree 0 to 3, orthogonal on the slip speeds; sums of the products with the friction.
    let mut basis: Vec<Vec<f64>> = Vec::new();
    let mut polynomials: Vec<[f64; TERMS]> = Vec::new();
    let mut residual: Vec<f64> = readings.iter().map(|reading| reading.1).collect();
    let mut squares = [0.0; TERMS];
    let mut coefficients = [0.0; TERMS];
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let degree = if half > 0.0 && n > 4 { 3 } else { 0 };
    let mut about_line = f64::NAN;
    for k in 0..=degree {
        let mut next: Vec<f64> = readings
            .iter()
            .map(|(u, _)| ((u - middle) / half.max(f64::MIN_POSITIVE)).powi(k as i32))
            .collect();
        let mut polynomial: [f64; TERMS] = std::array::from_fn(|power| f64::from(u8::from(power == k)));
        for (known, of_known) in basis.iter().zip(&polynomials) {
            let share = dot(&next, known) / dot(known, known);
            next.iter_mut().zip(known).for_each(|(next, known)| *next -= share * known);
            polynomial.iter_mut().zip(of_known).for_each(|(next, known)| *next -= share * known);
        }
        let norm = dot(&next, &next);
        if !(norm > 1e-9) {
            break;
        }
        let coefficient = dot(&residual, &next) / norm;
        residual.iter_mut().zip(&next).for_each(|(rest, next)| *rest -= coefficient * next);
        squares[k] = coefficient * coefficient * norm;
        coefficients[k] = coefficient;
        if k < 2 {
            about_line = dot(&residual, &residual);
        }
        basis.push(next);
        polynomials.push(polynomial);
    }
    let rest = dot(&residual, &residual) / (count - basis.len() as f64).max(1.0);
    let is_bent = 0.5 * (squares[2] + squares[3]) * independent > BENT * rest * count;
    let by_speed = readings.partition_point(|reading| reading.0 < middle);
    // Between two readings of one speed there is no segment.
    let by_count = readings.partition_point(|reading| reading.0 < readings[n / 2].0);
    let cut = [by_speed, by_count].into_iter().find(|cut| FEWEST.min(n) <= *cut && cut + FEWEST <= n);
    if let (true, Some(cut)) = (is_bent, cut) {
        divide(&readings[..cut], from, passages, segments);
        divide(&readings[cut..], from + cut, passages, segments);
        return;
    }
    let mean = readings.iter().map(|reading| reading.0).sum::<f64>() / count;
    let s2 = if degree > 0 {
        readings.iter().map(|reading| (reading.0 - mean).powi(2)).sum::<f64>() / count
    } else {
        0.0
    };
    let variance = about_line / (count - 2.0).max(1.0);
    let slope = if s2 > 0.0 { coefficients[1] / half } else { 0.0 };
    let by_chance = rest * count / independent;
    let bends = [2, 3].map(|k| {
        // The part of the term that is more than chance makes it.
        let share = (1.0 - by_chance / squares[k]).max(0.0).sqrt();
        polynomials.get(k).map_or([0.0; TERMS], |of| of.map(|power| share * coefficients[k] * power))
    });
    let (level, fastest) = (coefficients[0], high);
    segments.push(Segment { mean, s2, level, slope, variance, independent, fastest, middle, half, bends });
}

/// The number of different numbers.
fn different(numbers: &[usize]) -> f64 {
    numbers.iter().collect::<HashSet<_>>().len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn repeated_readings_become_means_with_standard_errors() {
        assert_eq!(means(&[(0.0, 0.4), (0.1, 0.3), (0.5, 0.2)]), None);
        // Squares about the means: 2 (0.01)^2 of the first speed, 2 (0.02)^2 of the last; three readings
        // more than means.
        let readings = [(0.0, 0.41), (0.0, 0.39), (0.1, 0.3), (0.5, 0.22), (0.5, 0.2), (0.5, 0.18)];
        let found = means(&readings).unwrap();
        let sd = (1e-3_f64 / 3.0).sqrt();
        for ((u, mean), expected) in found.data.iter().zip([(0.0, 0.4), (0.1, 0.3), (0.5, 0.2)]) {
            assert!(*u == expected.0 && (mean - expected.1).abs() < 1e-15, "{found:?}");
        }
        for (error, count) in found.standard_errors.unwrap().iter().zip([2.0_f64, 1.0, 3.0]) {
            assert!((error * count.sqrt() / sd - 1.0).abs() < 1e-12, "{error} {count}");
        }
        assert_eq!(found.first, [0, 2, 3]);
        // A row written twice tells of no scatter.
        let twice = means(&[(0.0, 0.4), (0.1, 0.3), (0.1, 0.3), (0.5, 0.2)]).unwrap();
        assert_eq!((twice.standard_errors, twice.data[1]), (None, (0.1, 0.3)));
    }

    /// A parabola that is straight but for 8 / 5 of what chance makes is one segment; its fastest speed lies three
    /// standard errors of the line beside the parabola, and within the error that is told.
    #[test]
    fn what_a_segment_bends_is_in_its_errors() {
        let parabola = |u: f64| 2.68 * u * u;
        let readings: Vec<(f64, f64)> = (1..=200)
            .map(|i| (f64::from(i) / 200.0, i))
            .map(|(u, i)| (u, parabola(u) + if i % 2 == 0 { 1.0 } else { -1.0 }))
            .collect();
        let (knots, _) = segments(&readings, None);
        assert_eq!(knots.len(), 2);
        for Knot { speed, friction, error } in knots {
            assert!(
                (friction - parabola(speed)).abs() < 1.5 * error && error < 0.6,
                "{speed} {friction} {error}"
            );
        }
    }

    /// A bent law is divided where it bends; knots lie on its straight parts.
    #[test]
    fn knots_lie_on_straight_parts() {
        let law = |u: f64| 1.0 - 0.5 * u + if u > 1.0 { u - 1.0 } else { 0.0 };
        let reading = |i: i32| {
            let u = f64::from(i) / 32.0;
            (u, law(u) + if i % 2 == 0 { 1e-6 } else { -1e-6 })
        };
        let (knots, spread) = segments(&(1..=64).map(reading).collect::<Vec<_>>(), None);
        assert!(knots.len() == 4 && (spread / 1e-6 - 1.0).abs() < 0.1, "{knots:?} {spread}");
        for knot in knots {
            assert!((knot.friction - law(knot.speed)).abs() < 1e-6 && knot.error < 1e-6, "{knot:?}");
        }
    }
}

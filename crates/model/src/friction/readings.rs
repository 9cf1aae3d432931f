//! Repeated readings at one slip speed, averaged.

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
}

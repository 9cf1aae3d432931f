//! Speeds as slopes of positions over time.

use super::MeasuredReading;

/// Numbers of rows before and after the one of which the speed is the slope, that are tried.
const HALF_WIDTHS: [usize; 6] = [1, 2, 4, 8, 16, 32];
/// Mean square of a bias that is of second order, in units of that of its difference to the one of half the width.
const OF_HALF: f64 = 16.0 / 9.0;
/// Least number of widths that a run of rows has.
const WIDTHS: usize = 5;
/// Median of the size of a normal deviate, and variance of the third difference of independent ones.
const MEDIAN: f64 = 0.674_489_750_196_081_7;
const OF_THIRD: f64 = 20.0;
/// Errors below which a speed may be 0.
const SURE: f64 = 2.0;

/// The slope at each row but the first and last `half` ones, and the sum of squares of the times about their mean.
fn slopes(times: &[f64], positions: &[f64], half: usize) -> Vec<[f64; 2]> {
    let windows = times.windows(2 * half + 1).zip(positions.windows(2 * half + 1));
    let slope = |(times, positions): (&[f64], &[f64])| {
        let count = times.len() as f64;
        let mean = times.iter().sum::<f64>() / count;
        let squares: f64 = times.iter().map(|t| (t - mean).powi(2)).sum();
        let products: f64 =
            times.iter().zip(positions).map(|(t, x)| (t - mean) * (x - positions[half])).sum();
        [products / squares, squares]
    };
    windows.map(slope).collect()
}

/// Standard error of positions: by the median third difference, and at least that of their resolution, of which third
/// differences are multiples.
fn scatter(runs: &[(Vec<f64>, Vec<f64>)]) -> f64 {
    let all = || runs.iter().map(|(_, positions)| positions);
    let rounding = 8.0 * f64::EPSILON * all().flatten().fold(0.0, |most: f64, x| most.max(x.abs()));
    let thirds = all().flat_map(|x| x.windows(4).map(|x| (x[3] - 3.0 * (x[2] - x[1]) - x[0]).abs()));
    let mut thirds: Vec<f64> = thirds.collect();
    let resolution =
        thirds.iter().copied().filter(|third| *third > rounding).reduce(f64::min).unwrap_or(rounding);
    let middle = thirds.len() / 2;
    let median = *thirds.select_nth_unstable_by(middle, f64::total_cmp).1;
    (median / (MEDIAN * OF_THIRD.sqrt())).max(resolution / 12_f64.sqrt())
}

/// Rows whose speeds are positions, with their times, by the slopes of these: the rows, the number of rows of a slope, and
/// the standard error of a speed. Speeds that may be 0 are rest where it lasts, and left out where it does not. `None` where
/// there are too few rows in order of time.
///
/// A slope over more rows has less scatter, and more of what the motion does meanwhile. Of nested widths the mean square of the
/// difference is that of the biases and, for independent errors, the difference of the two variances: the number of rows is
/// that of the least sum of bias and variance (Mallows, Technometrics 15, 1973).
pub(super) fn speeds(
    rows: Vec<MeasuredReading>,
    times: &[f64],
) -> Option<(Vec<MeasuredReading>, usize, f64)> {
    // Runs may be joined.
    let mut ends: Vec<usize> = (1..rows.len()).filter(|i| !(times[*i] > times[i - 1])).collect();
    ends.push(rows.len());
    let mut start = 0;
    let mut runs = Vec::new();
    for end in ends {
        let of = start..end;
        start = end;
        if of.len() >= 2 * WIDTHS {
            runs.push(of);
        }
    }
    let data = |of: &std::ops::Range<usize>| {
        (times[of.clone()].to_vec(), rows[of.clone()].iter().map(|row| row.speed).collect::<Vec<f64>>())
    };
    let data: Vec<(Vec<f64>, Vec<f64>)> = runs.iter().map(data).collect();
    let shortest = runs.iter().map(|of| of.len()).min()?;
    let variance = scatter(&data).powi(2);
    // For each width the mean square of the bias, and the variance.
    let (mut costs, mut before) = (Vec::new(), None);
    for half in HALF_WIDTHS.into_iter().filter(|half| (2 * half + 1) * WIDTHS <= shortest.max(3 * WIDTHS)) {
        let wide: Vec<_> = data.iter().map(|(times, positions)| slopes(times, positions, half)).collect();
        let count = wide.iter().map(Vec::len).sum::<usize>() as f64;
        let of = |slopes: &[Vec<[f64; 2]>]| {
            slopes.iter().flatten().map(|[_, squares]| variance / squares).sum::<f64>()
        };
        let own = of(&wide) / count;
        let bias = before.take().map_or(0.0, |narrow: Vec<Vec<[f64; 2]>>| {
            let pairs =
                wide.iter().zip(&narrow).flat_map(|(wide, narrow)| wide.iter().zip(&narrow[half / 2..]));
            let off = pairs.map(|([wide, more], [narrow, less])| {
                (wide - narrow).powi(2) - variance * (1.0 / less - 1.0 / more)
            });
            OF_HALF * off.sum::<f64>().max(0.0) / count
        });
        costs.push((half, bias, own));
        before = Some(wide);
    }
    let (half, bias, own) =
        costs.into_iter().min_by(|one, other| (one.1 + one.2).total_cmp(&(other.1 + other.2)))?;
    let error = (bias + own).sqrt();
    let mut found: Vec<MeasuredReading> = Vec::new();
    for (of, (times, positions)) in runs.iter().zip(&data) {
        let slopes = slopes(times, positions, half);
        let inner = &rows[of.start + half..of.end - half];
        let with_speed = inner.iter().zip(slopes).map(|(row, [speed, _])| MeasuredReading { speed, ..*row });
        let all: Vec<MeasuredReading> = with_speed.collect();
        for phase in
            all.chunk_by(|one, next| (one.speed.abs() > SURE * error) == (next.speed.abs() > SURE * error))
        {
            if phase[0].speed.abs() > SURE * error {
                found.extend(phase);
            } else if phase.len() > 2 * half {
                found.extend(phase.iter().map(|row| MeasuredReading { speed: 0.0, ..*row }));
            }
        }
    }
    Some((found, 2 * half + 1, error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_numbers::random::Random;

    /// The speeds of a swing lie about the true ones as far as it says, also with coarse positions; rest is rest.
    #[test]
    fn speeds_have_the_error_that_is_told() {
        for (noise, step) in [(0.0, 1e-9), (2e-5, 1e-9), (0.0, 5e-5)] {
            let mut random = Random(7);
            let times: Vec<f64> = (0..3000).map(|i| 1e-3 * f64::from(i)).collect();
            // It comes to rest at 1 s, until 2 s.
            let phase = |t: f64| std::f64::consts::TAU * (t.min(1.0) + (t - 2.0).max(0.0));
            let speed = |t: f64| if (1.0..2.0).contains(&t) { 0.0 } else { 0.3 * phase(t).sin() };
            let row = |(i, t): (usize, &f64)| {
                let x = 0.3 / std::f64::consts::TAU * (1.0 - phase(*t).cos()) + noise * random.normal();
                let x = (x / step).round() * step;
                MeasuredReading {
                    speed: x,
                    friction: 1.0,
                    error: f64::NAN,
                    line: i,
                    visit: 0,
                    backward: false,
                }
            };
            let rows: Vec<MeasuredReading> = times.iter().enumerate().map(row).collect();
            let (found, width, error) = speeds(rows, &times).unwrap();
            assert!(found.len() > 2600, "{}", found.len());
            let of = |row: &MeasuredReading| row.speed - speed(times[row.line]);
            let slips: Vec<&MeasuredReading> = found.iter().filter(|row| row.speed != 0.0).collect();
            let off = (slips.iter().map(|row| of(row).powi(2)).sum::<f64>() / slips.len() as f64).sqrt();
            println!("{noise} {step}: {width} rows, off by {off:.2e}, told {error:.2e}");
            // Where it comes to rest two rows of exact positions are off by half of what it slows down in one; those of coarse ones
            // have errors that follow one another.
            let most = if step > 1e-6 { 3.0 } else { 1.5 };
            assert!(off < most * error.max(2e-5) && error < 3.0 * off, "{off} {error}");
        }
    }
}

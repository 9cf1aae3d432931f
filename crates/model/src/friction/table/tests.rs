use super::super::Law;
use super::*;

fn falling() -> Table {
    let data = [(0.0, 1.0), (0.1, 0.8), (0.3, 0.65), (0.6, 0.6), (1.0, 0.62), (2.0, 0.7), (4.0, 0.9)];
    Table::new("falling", &data, 1.0).unwrap()
}

#[test]
fn meets_the_data_keeps_the_shape_and_has_a_continuous_slope() {
    let table = falling();
    for (u, phi) in table.data() {
        assert!((table.phi(u) - phi).abs() <= 4.0 * f64::EPSILON, "{u}");
    }
    for i in 1..table.pieces() {
        let knot = table.0.u[i];
        let [left, right] = [i - 1, i].map(|piece| weakening(table.cubic(piece), knot - table.0.u[piece]));
        assert!((left - right).abs() <= 64.0 * f64::EPSILON, "{knot}: {left} {right}");
    }
    // The weighted harmonic mean of Fritsch and Butland, of the secants -2 over 0.1 and -0.75 over 0.2.
    assert!((table.weakening(0.1) - 0.9 / (0.5 / 2.0 + 0.4 / 0.75)).abs() <= 32.0 * f64::EPSILON);
    let at = |i: u32| table.phi(4.0 * f64::from(i) / 4000.0);
    for i in 0..4000 {
        // Falling up to the least datum, rising from there.
        let falls = i < 600;
        assert!((at(i + 1) <= at(i) + 1e-15) == falls || (at(i + 1) - at(i)).abs() < 1e-15, "{i}");
    }
    assert!(table.phi(4.1).is_nan() && table.weakening(4.1).is_nan());
}

/// The derivatives by the data equal differences, and vanish for a change of all data together.
/// Friction in slip begins at the friction at rest or below it, with the drop that is left.
#[test]
fn friction_at_rest_may_lie_above_that_in_slip() {
    let data: Vec<(f64, f64)> = falling().data().collect();
    for (rest, drop) in [(1.0, 0.0), (1.25, 0.2), (4.0, 0.75)] {
        assert!((Table::with_static("drops", &data, rest).unwrap().drop() - drop).abs() < 1e-15, "{rest}");
    }
    let refused = Table::with_static("drops", &data, 0.9).unwrap_err();
    assert_eq!(refused.row, Some(0));
    assert_eq!(Table::new("drops", &data, 1.25).unwrap_err().row, Some(0));
}

#[test]
fn weakening_follows_the_data() {
    let data: Vec<(f64, f64)> = falling().data().map(|(u, phi)| (u, 2.0 * phi)).collect();
    let table = Table::new("falling", &data, 2.0).unwrap();
    for u in [0.0, 0.03, 0.1, 0.2, 0.45, 0.8, 1.7, 3.0, 4.0] {
        let (first, derivatives) = table.weakening_by_data(u);
        for (k, derivative) in derivatives.into_iter().enumerate() {
            // The first datum is the static level, which is fixed.
            if first + k == 0 || first + k >= data.len() {
                continue;
            }
            let moved = |step: f64| {
                let mut data = data.clone();
                data[first + k].1 += step;
                Table::new("falling", &data, 2.0).unwrap().weakening(u)
            };
            // Truncation of the second order, round-off over the step.
            let difference = (moved(1e-6) - moved(-1e-6)) / 2e-6;
            let extreme = first + k == 3;
            assert!(extreme || (derivative - difference).abs() <= 1e-7 * (1.0 + derivative.abs()), "{u} {k}");
        }
    }
}

/// The standard error of the slope is the deviation of the slopes of tables with random data: by a table
/// whose secants are steep, where first order suffices, and by one with equal neighbours, where it is too
/// small.
#[test]
fn the_standard_error_of_the_slope_is_that_of_random_data() {
    let steep = [(0.0, 0.5), (0.1, 0.44), (0.2, 0.40), (0.4, 0.34), (0.8, 0.28), (1.6, 0.25)];
    let equal = [(0.0, 0.5), (0.1, 0.42), (0.2, 0.36), (0.4, 0.36), (0.8, 0.30), (1.6, 0.30)];
    let mut too_small = 0;
    for (data, sd, first_order) in [(steep, 5e-4, true), (equal, 4e-3, false)] {
        let table = Table::new("random", &data, 0.5).unwrap().with_standard_errors(&[sd; 6]).unwrap();
        for u in [0.05, 0.1, 0.15, 0.2, 0.201, 0.3, 0.4, 0.6, 0.8, 1.2] {
            let mut random = Random(7);
            let mut slopes = Vec::new();
            for _ in 0..10_000 {
                let moved = data.map(|(u, friction)| (u, friction + sd * random.normal()));
                let rest = moved[0].1;
                slopes.push(Table::new("moved", &moved, rest).unwrap().weakening(u) * rest / 0.5);
            }
            let count = slopes.len() as f64;
            let mean = slopes.iter().sum::<f64>() / count;
            let deviation = (slopes.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() / count).sqrt();
            let found = table.standard_error_of_weakening(u).unwrap();
            // Deviations of 4,096 and 10,000 draws: of normal numbers their relative errors are
            // 1 / sqrt(2 n), of others more; three times their sum.
            assert!((found / deviation - 1.0).abs() < 0.05, "{u}: {found} {deviation}");
            let (first, by) = table.weakening_by_data(u);
            let linear = by.iter().take(6 - first).map(|by| (by * sd).powi(2)).sum::<f64>().sqrt();
            match first_order {
                true => assert!((linear / deviation - 1.0).abs() < 0.1, "{u}: {linear} {deviation}"),
                false => too_small += u32::from(linear < 0.5 * deviation),
            }
        }
    }
    assert!(too_small > 2, "{too_small}");
}

#[test]
fn standard_errors_are_lengths_one_for_each_datum() {
    let table = falling();
    assert_eq!(table.standard_errors(), None);
    let errors = [0.0, 0.01, 0.02, 0.0, 0.01, 0.01, 0.5];
    assert_eq!(table.with_standard_errors(&errors).unwrap().standard_errors(), Some(&errors[..]));
    assert_eq!(table.with_standard_errors(&errors[1..]).unwrap_err().row, None);
    let negative = [0.0, -0.01, 0.02, 0.0, 0.01, 0.01, 0.5];
    assert_eq!(table.with_standard_errors(&negative).unwrap_err().row, Some(1));
}

#[test]
fn a_cubic_between_dense_data_has_the_mean_of_the_cubic() {
    // phi = 1 - u^2/8 sampled: weakening u/4, whose mean is V/4. The slopes are second order.
    let data: Vec<(f64, f64)> =
        (0..=4000).map(|i| f64::from(i) / 1000.0).map(|u| (u, 1.0 - u * u / 8.0)).collect();
    let table = Table::new("parabola", &data, 1.0).unwrap();
    assert!((table.mean_weakening(1.5) - 0.375).abs() < 1e-5);
}

/// Errors of known size are found in the scatter of the rows, at equal and at unequal distances.
#[test]
fn the_scatter_is_the_deviation_of_the_errors() {
    let mut random = Random(5);
    for power in [1.0, 1.5] {
        let row = |i: i32| {
            let u = 2.0 * (f64::from(i) / 400.0).powf(power);
            (u, 0.3 + 0.1 * (-u / 0.5).exp() + 0.004 * random.normal())
        };
        let data: Vec<(f64, f64)> = (0..=400).map(row).collect();
        let scatter = Table::new("noisy", &data, data[0].1).unwrap().scatter();
        // Neighbouring residuals are correlated: the relative error is about 1 / sqrt(400).
        assert!((scatter / 0.004 - 1.0).abs() < 0.15, "{power}: {scatter}");
    }
    let line: Vec<(f64, f64)> = (0..5).map(|i| f64::from(i) * 0.25).map(|u| (u, 1.0 - 0.5 * u)).collect();
    assert_eq!(Table::new("line", &line, 1.0).unwrap().scatter(), 0.0);
    // Of a first datum on the line through the next two nothing is missed; the third row is off by 1.
    let made = Table::new("made", &[(0.0, 11.0), (1.0, 10.0), (2.0, 9.0), (3.0, 10.0)], 11.0).unwrap();
    let made = made.with_source(Source { no_rest: true, ..Source::default() });
    assert!((made.scatter() - 1.0 / 1.5_f64.sqrt() / MEDIAN_SIZE).abs() < 1e-15);
}

#[test]
fn bad_data_are_refused_with_their_row() {
    let row = |data: &[(f64, f64)], level| Table::new("bad", data, level).unwrap_err().row;
    assert_eq!(row(&[(0.0, 1.0), (1.0, 0.5)], 1.0), None);
    assert_eq!(row(&[(0.0, 1.0), (1.0, 0.5), (1.0, 0.4)], 1.0), Some(2));
    assert_eq!(row(&[(0.0, 1.0), (1.0, 0.5), (0.9, 0.4)], 1.0), Some(2));
    assert_eq!(row(&[(0.0, 1.0), (1.0, f64::NAN), (2.0, 0.4)], 1.0), Some(1));
    assert_eq!(row(&[(0.1, 1.0), (1.0, 0.5), (2.0, 0.4)], 1.0), Some(0));
    let error = Table::new("bad", &[(0.0, 0.4), (1.0, 0.3), (2.0, 0.2)], 1.0).unwrap_err();
    assert!(error.remedy.contains("static = 0.4"), "{error}");
    assert!(Table::new("good", &[(0.0, 0.4), (1.0, 0.3), (2.0, 0.2)], 0.4).is_ok());
}

/// A straight line leaves nothing open. Through (0, 1), (1, 0), (2, -0.5), (3, -0.75), with slopes -1, -0.5 and -0.25,
/// the curve between the second and the third row leaves with the slope -1 for a third of the piece, where the edges
/// meet, and arrives with -0.25; from rest to the second row it may have the slope -0.5.
#[test]
fn the_curve_between_rows_has_an_error() {
    let table = |data: &[(f64, f64)]| Table::new("rows", data, data[0].1).unwrap().with_error_of_curve();
    let line = [(0.0, 1.0), (1.0, 0.9), (2.0, 0.8), (3.0, 0.7)];
    assert!(table(&line).error_of_curve(&[(0.5, 1.0), (1.2, 2.0), (2.5, 1.0)]) < 1e-15);
    let bent = table(&[(0.0, 1.0), (1.0, 0.0), (2.0, -0.5), (3.0, -0.75)]);
    for (u, weight, range) in [(0.5, 1.0, 0.5), (1.3, 2.0, -1.0), (1.4, 2.0, 0.5), (2.5, 1.0, -0.25)] {
        let found = bent.error_of_curve(&[(u, weight)]);
        assert!((found - f64::abs(range) / 12f64.sqrt()).abs() < 1e-15, "{u}: {found}");
    }
    // What the slope gains before the edges meet it loses after: equal weights over the piece leave nothing open.
    let all: Vec<(f64, f64)> = (0..300).map(|i| (1.0 + (f64::from(i) + 0.5) / 300.0, 1.0 / 300.0)).collect();
    assert!(bent.error_of_curve(&all) < 1e-14);
}

/// A line to rest is no measured one: through (1, 1), (2, 0.5) and (3, 0.25) the curve may have the slope of -0.25 for -0.5
/// as far as the second row.
#[test]
fn a_line_to_rest_leaves_the_curve_open() {
    let data = [(0.0, 1.5), (1.0, 1.0), (2.0, 0.5), (3.0, 0.25)];
    let table = Table::new("rows", &data, 1.5).unwrap().with_error_of_curve();
    let table = table.with_source(Source { no_rest: true, ..Source::default() });
    assert!(table.meets().is_empty());
    let found = table.error_of_curve(&[(0.5, 1.0), (1.5, 2.0)]);
    assert!((found - 3.0 * 0.25 / 1.5 / 12f64.sqrt()).abs() < 1e-15, "{found}");
    let exact = table.with_standard_errors(&[0.0; 4]).unwrap();
    for u in [0.0, 0.5, 1.0, 1.999, 2.0, 2.5] {
        let found = exact.standard_error_of_weakening(u).unwrap();
        assert!((found - 0.25 / 1.5 / 12f64.sqrt()).abs() < 1e-15, "{u}: {found}");
    }
}

/// The range of the slope is continuous, so that rounding does not decide. Of the curve of the test before, at the second
/// and the third row it is that of the chords on both sides. Where the edges meet, at 4/3, it is the whole one; halfway
/// the edge is at -0.375, and the slope between -0.75 and -0.25. A curve that bends both ways may be steeper between its
/// rows than any chord.
#[test]
fn the_error_of_the_slope_is_continuous() {
    let one_way = [(0.0, 1.0), (1.0, 0.0), (2.0, -0.5), (3.0, -0.75)];
    let both_ways = [(0.0, 7.0), (1.0, 6.0), (2.0, 3.0), (3.0, 2.0)];
    let [one_way, both_ways] = [&one_way, &both_ways].map(|data| {
        let table = Table::new("rows", data, data[0].1).unwrap().with_error_of_curve();
        table.with_standard_errors(&[0.0; 4]).unwrap()
    });
    let ranges = [(0.5, 0.5), (1.0, 0.5), (4.0 / 3.0, 0.75), (1.5, 0.5), (2.0, 0.25), (2.5, 0.25)];
    for (table, u, range) in ranges.map(|(u, range)| (&one_way, u, range)).into_iter().chain([
        (&both_ways, 1.0, 2.0 / 7.0),
        (&both_ways, 1.5, 4.0 / 7.0),
        (&both_ways, 2.0, 2.0 / 7.0),
    ]) {
        for u in [u - 1e-9, u, u + 1e-9] {
            let found = table.standard_error_of_weakening(u).unwrap();
            // The range changes by at most its size over the shortest way to an end of the piece, 1/2.
            assert!((found - range / 12f64.sqrt()).abs() < 1e-9, "{u}: {found} {range}");
        }
    }
}

/// Correlated errors: of data that move together slopes have none, and of a triangle those of random data. A law is read
/// from its definition with them, and keeps them in other units.
#[test]
fn correlated_errors_are_those_of_data_that_move_together() {
    let data = [(0.0, 0.5), (0.1, 0.44), (0.2, 0.40), (0.4, 0.34), (0.8, 0.28), (1.6, 0.25)];
    let table = |entry: fn(usize, usize) -> f64| {
        let row = |i: usize| (0..=i).map(|j| entry(i, j)).collect();
        Table::new("a rig", &data, 0.5).unwrap().with_root_of_covariance((0..6).map(row).collect()).unwrap()
    };
    let together = table(|_, j| if j == 0 { 1e-3 } else { 0.0 });
    assert!(together.standard_errors().unwrap().iter().all(|error| (error - 1e-3).abs() < 1e-18));
    assert!(together.standard_error_of_weakening(0.3).unwrap() < 1e-12);
    let mixed = table(|i, j| 1e-4 * (1.0 + (3 * i + 5 * j) as f64 % 4.0));
    let mut random = Random(3);
    let drawn: Vec<f64> = (0..10_000)
        .map(|_| {
            let moved = mixed.drawn(|| random.normal()).unwrap();
            moved.weakening(0.3) * moved.static_level() / 0.5
        })
        .collect();
    let mean = drawn.iter().sum::<f64>() / 1e4;
    let deviation = (drawn.iter().map(|slope| (slope - mean).powi(2)).sum::<f64>() / 1e4).sqrt();
    let found = mixed.standard_error_of_weakening(0.3).unwrap();
    assert!((found / deviation - 1.0).abs() < 0.05, "{found} {deviation}");
    assert_eq!(mixed.with_error_of_curve(), mixed);
    let law = Law::Table(mixed.clone());
    assert_eq!(Law::from_definition(law.name(), &law.definition()), Some(law));
    let scaled = mixed.in_units(2.0, 0.5).unwrap();
    assert!(
        (scaled.root_of_covariance().unwrap()[4][2] - 2.0 * mixed.root_of_covariance().unwrap()[4][2]).abs()
            < 1e-18
    );
    let short = vec![vec![0.0]; 6];
    assert_eq!(mixed.with_root_of_covariance(short).unwrap_err().row, Some(1));
}

//! Rows whose errors remember, and are common to a visit.

use super::K;
use nalgebra::SMatrix;

/// A row: the splines, the friction, and what is put aside.
pub(super) type Row = [f64; K + 2];
/// Sums of products of rows.
pub(super) type Gram = SMatrix<f64, { K + 2 }, { K + 2 }>;

/// Variances of the error common to a visit, in units of what a visit of mean length tells of it.
const RATIOS: [f64; 7] = [0.3, 1.0, 4.0, 16.0, 64.0, 256.0, 2000.0];
/// Largest number of rows that are remembered.
const MOST_REMEMBERED: f64 = 20.0;

/// Adds the products of two rows, of which few are not 0.
fn add(sum: &mut Gram, one: &Row, other: &Row, scale: f64) {
    for (j, b) in other.iter().enumerate().filter(|(_, b)| **b != 0.0) {
        for (i, a) in one.iter().enumerate() {
            sum[(i, j)] += scale * a * b;
        }
    }
}

/// The sums of products of the rows for each noise, in which they are independent, with half the logarithm of the determinant,
/// and whether visits have an error of their own. Those of a table are.
pub(super) fn grams(rows: &[Row], visits: Option<&[usize]>, rhos: &[f64]) -> Vec<(Gram, f64, bool)> {
    let mut all = Gram::zeros();
    rows.iter().for_each(|row| add(&mut all, row, row, 1.0));
    let Some(visits) = visits else { return vec![(all, 0.0, false)] };
    // Once as one run over the record, once cut where a visit ends.
    let [mut inner, mut inner_cut] = [all; 2];
    let [mut lagged, mut lagged_cut] = [Gram::zeros(); 2];
    for row in rows.first().into_iter().chain(rows.last()) {
        add(&mut inner, row, row, -1.0);
    }
    let mut parts = Vec::new();
    let mut start = 0;
    for visit in visits.chunk_by(|one, next| one == next) {
        let of = &rows[start..start + visit.len()];
        let (first, last) = (&of[0], &of[of.len() - 1]);
        add(&mut inner_cut, first, first, -1.0);
        if of.len() > 1 {
            add(&mut inner_cut, last, last, -1.0);
        }
        of.windows(2).for_each(|pair| add(&mut lagged_cut, &pair[1], &pair[0], 1.0));
        if start > 0 {
            add(&mut lagged, first, &rows[start - 1], 1.0);
        }
        let mut total = [0.0; K + 2];
        of.iter().for_each(|row| total.iter_mut().zip(row).for_each(|(sum, x)| *sum += x));
        parts.push((of.len() as f64, *first, *last, total));
        start += visit.len();
    }
    lagged += lagged_cut;
    let mut found = Vec::new();
    for &rho in rhos {
        let of =
            |lagged: &Gram, inner: &Gram| all - (lagged + lagged.transpose()) * rho + inner * (rho * rho);
        let one = 0.5 * (1.0 - rho * rho).ln();
        found.push((of(&lagged, &inner), one, false));
        if parts.len() < super::FEWEST_VISITS {
            continue;
        }
        let cut = of(&lagged_cut, &inner_cut);
        let ends = 1.0 - rho * rho;
        let told: Vec<f64> =
            parts.iter().map(|(count, ..)| ends + (count - 1.0) * (1.0 - rho).powi(2)).collect();
        let sums: Vec<Row> = parts
            .iter()
            .map(|(_, first, last, total)| {
                let sum = |i: usize| {
                    ends * first[i] + (1.0 - rho) * (total[i] - first[i] - rho * (total[i] - last[i]))
                };
                std::array::from_fn(sum)
            })
            .collect();
        let mean = told.iter().sum::<f64>() / told.len() as f64;
        for ratio in RATIOS.map(|ratio| ratio / mean) {
            let mut gram = cut;
            let mut log = one * parts.len() as f64 - (RATIOS.len() as f64).ln();
            for (told, sum) in told.iter().zip(&sums) {
                add(&mut gram, sum, sum, -ratio / (1.0 + ratio * told));
                log -= 0.5 * (ratio * told).ln_1p();
            }
            found.push((gram, log, true));
        }
    }
    found
}

/// The rows less what they remember of those before, from the first on that has all of these, and their visits.
pub(super) fn filtered<'a>(
    rows: Vec<Row>,
    visits: Option<&'a [usize]>,
    phi: &[f64],
) -> (Vec<Row>, Option<&'a [usize]>) {
    if phi.is_empty() {
        return (rows, visits);
    }
    let from = phi.len();
    let of = |at: usize| {
        let remembered =
            |i: usize| phi.iter().zip((0..at).rev()).map(|(phi, k)| phi * rows[k][i]).sum::<f64>();
        std::array::from_fn(|i| rows[at][i] - remembered(i))
    };
    ((from..rows.len()).map(of).collect(), visits.map(|visits| &visits[from..]))
}

/// The coefficients of an autoregression of residuals, less the mean of their visit where it has an error of its own; their number by Schwarz's
/// criterion, the coefficients by the algorithm of Levinson and Durbin.
pub(super) fn autoregression(residuals: &[f64], visits: &[usize], own: bool) -> Vec<f64> {
    let n = residuals.len() as f64;
    let count = visits.iter().max().map_or(0, |last| last + 1);
    let (mut lengths, mut sums) = (vec![0.0; count], vec![0.0; count]);
    for (residual, visit) in residuals.iter().zip(visits) {
        lengths[*visit] += 1.0;
        sums[*visit] += residual;
    }
    let mean = |visit: usize| if own { sums[visit] / lengths[visit] } else { 0.0 };
    let e: Vec<f64> = residuals.iter().zip(visits).map(|(residual, visit)| residual - mean(*visit)).collect();
    lengths.sort_by(f64::total_cmp);
    let median = 0.5 * (lengths[(count - 1) / 2] + lengths[count / 2]);
    let most = MOST_REMEMBERED.min(median / 4.0).min(n / 20.0) as usize;
    let covariance = |lag: usize| {
        let same = (lag..e.len()).filter(|i| visits[*i] == visits[i - lag]);
        same.map(|i| e[i] * e[i - lag]).sum::<f64>() / n
    };
    let c: Vec<f64> = (0..=most).map(covariance).collect();
    let (mut variance, mut phi) = (c[0], Vec::new());
    let mut best = (n * variance.ln(), Vec::new());
    for k in 1..=most {
        let known: f64 = phi.iter().zip(c[1..k].iter().rev()).map(|(phi, c)| phi * c).sum();
        let next = (c[k] - known) / variance;
        let reversed: Vec<f64> = phi.iter().rev().copied().collect();
        phi.iter_mut().zip(reversed).for_each(|(phi, other)| *phi -= next * other);
        phi.push(next);
        variance *= 1.0 - next * next;
        let criterion = n * variance.ln() + k as f64 * n.ln();
        if criterion < best.0 {
            best = (criterion, phi.clone());
        }
    }
    best.1
}

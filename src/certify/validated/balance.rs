//! The energy balance as a bound: proofs that C* < C_HB over boxes of (A, k, b).
//!
//! The balance of energy over the grazing circle is reached at ([`super::super::harmonic_balance`])
//!
//! ```text
//! C_HB = A h(k) - 2 b,     h = 2 / (q (1 + k + q)),     q^2 = 1 + 2 k.
//! ```
//!
//! C* <= C_HB is false at large k, and no general proof is known for smaller k. But a [`Tile`] encloses C* by
//! a polynomial, so that a finite computation proves the inequality wherever the gap exceeds the tile's
//! radius. The gap is of fifth order in (A, k, b), so that boxes at A = 0 or k = 0 cannot be proved.
//!
//! C_HB is linear in A and b, and is subtracted from the polynomial mode by mode; along k both are enclosed
//! over intervals, which are bisected until the difference has one sign.

use super::expansion::chebyshev;
use super::tile::{GroupBox, Tile, degrees};
use crate::friction::interval::Interval;
use crate::friction::jet::Real as _;

/// Width of the smallest interval tried of the scaled k, which ranges over [-1, 1].
const FINEST: f64 = 1e-7;
/// Number of cells along A and b.
const CELLS: [usize; 2] = [8, 4];

/// The parts of a box with a proof that C* < C_HB there, and those without.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// C* < C_HB is proved.
    pub(crate) below: Vec<GroupBox>,
    /// C* < C_HB is not proved, whether it is true or false.
    pub(crate) open: Vec<GroupBox>,
}

/// Proves C* < C_HB over parts of `domain`, by at most `tiles` proofs of [`Tile::prove`].
#[must_use]
pub fn compare(domain: GroupBox, tiles: usize) -> Comparison {
    let (mut found, mut queue) = (Comparison { below: Vec::new(), open: Vec::new() }, vec![domain]);
    let mut tried = 0;
    while let Some(part) = queue.pop() {
        if tried == tiles {
            found.open.push(part);
            continue;
        }
        tried += 1;
        let tile = Tile::prove(part);
        if tile.as_ref().is_some_and(is_below) {
            found.below.push(part);
        } else {
            let axis = tile.map_or_else(|| super::surface::widest_axis(&part), |tile| tile.roughest_axis());
            queue.extend(part.halves(axis));
        }
    }
    found
}

/// Returns whether C* < C_HB is proved over the whole tile.
pub(crate) fn is_below(tile: &Tile) -> bool {
    let mut queue = vec![[-1.0, 1.0]];
    while let Some([lo, hi]) = queue.pop() {
        if gap(tile, lo, hi) > 0.0 {
            continue;
        }
        if !(hi - lo > FINEST) {
            return false;
        }
        let middle = 0.5 * (lo + hi);
        queue.extend([[lo, middle], [middle, hi]]);
    }
    true
}

/// Lower bound of C_HB - C* over the part of the tile where the scaled k is between `lo` and `hi`.
fn gap(tile: &Tile, lo: f64, hi: f64) -> f64 {
    let scale = |axis: usize| {
        let [lo, hi] = tile.domain.ranges()[axis].map(Interval::of);
        let half = Interval::of(0.5);
        (half * (lo + hi), half * (hi - lo))
    };
    // T_0, T_1, .. over a part of [-1, 1].
    let along = |lo: f64, hi: f64| chebyshev(Interval::new(lo, hi), [-1.0, 1.0])[0];
    let x = Interval::new(lo, hi);
    let (k_middle, k_half) = scale(1);
    let k = (k_middle + k_half * x).at_least_zero();
    let one = Interval::ONE;
    let q = (one + k + k).sqrt();
    let h = Interval::of(2.0).over(q * (one + k + q));
    let along_k = along(lo, hi);
    let (a_middle, a_half) = scale(0);
    let (b_middle, b_half) = scale(2);
    // C_HB - polynomial = sum of modes[i][l] T_i(A) T_l(b).
    let mut modes = [[Interval::ZERO; 3]; 3];
    modes[0][0] = a_middle * h - (b_middle + b_middle);
    modes[1][0] = a_half * h;
    modes[0][1] = -(b_half + b_half);
    for (mode, &c) in tile.viscous.iter().enumerate().filter(|(_, c)| **c != 0.0) {
        let [i, j, l] = degrees(mode);
        modes[i][l] = modes[i][l] - Interval::of(c) * along_k[j];
    }
    let cells = |axis: usize| {
        let n = CELLS[axis] as f64;
        (0..CELLS[axis]).map(move |i| [i, i + 1].map(|i| 2.0 * i as f64 / n - 1.0))
    };
    let least = |[a_lo, a_hi]: [f64; 2]| {
        cells(1).map(move |[b_lo, b_hi]| {
            let (along_a, along_b) = (along(a_lo, a_hi), along(b_lo, b_hi));
            let mut sum = Interval::ZERO;
            for (i, row) in modes.iter().enumerate() {
                for (l, &mode) in row.iter().enumerate() {
                    sum = sum + mode * (along_a[i] * along_b[l]);
                }
            }
            sum.lo
        })
    };
    let all = cells(0).flat_map(least).fold(f64::INFINITY, f64::min);
    (Interval::of(all) - Interval::of(tile.radius)).lo
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_balance_is_a_bound_over_a_box() {
        let domain = GroupBox { a: [0.4, 0.45], k: [0.6, 0.68], b: [0.0, 0.02] };
        let found = compare(domain, 12);
        assert!(found.open.is_empty(), "{} below, {} open", found.below.len(), found.open.len());
        let below: Vec<_> = found.below.iter().map(GroupBox::ranges).collect();
        assert_eq!(crate::certify::recheck::divides(&domain.ranges(), &below), Ok(()));
    }

    #[test]
    fn a_wrong_bound_is_not_confirmed() {
        let point = |k: f64, a: f64| GroupBox { a: [a, a], k: [k, k], b: [0.0, 0.0] };
        let tile = Tile::prove(point(0.5, 0.4)).unwrap();
        assert!(is_below(&tile));
        // C* raised above the balance by a millionth of it.
        let h = 2.0 / (2f64.sqrt() * (1.5 + 2f64.sqrt()));
        let mut moved = tile.clone();
        moved.viscous[0] = 0.4 * h * (1.0 + 1e-6);
        assert!(!is_below(&moved));
        // Beyond k = 15.6 the statement is false.
        assert!(!Tile::prove(point(24.0, 0.5)).is_some_and(|tile| is_below(&tile)));
    }
}

//! What the curve between the rows of a table could be.
//!
//! Between two rows a curve that bends one way lies between their chord and the two chords next to it, continued until
//! they meet: it leaves with the slope of the piece before and arrives with that of the piece after. How the answer
//! changes from one edge of this triangle to the other is the range that the rows leave open. The interpolant lies
//! somewhere within, and the curve is taken to be anywhere in it, one piece independent of the next: the standard
//! deviation is that of a uniform distribution. Where a curve bends both ways between two rows, what it gains in one
//! half it loses in the other, and the range is taken as empty. Next to an end the triangle is open, and its other edge
//! has the slope of the only piece beside.
//!
//! For exact rows of five laws, even, growing and random, from a tenth of
//! the speed over which friction falls to four times it, the true critical damping was within two such errors in 95
//! of 100. The miss of each row by the curve through the others was tried as well: it covered 92, and was five times
//! too large where rows follow one another in geometric progression.

use std::sync::Arc;

use super::{Cubics, Table};

impl Table {
    /// The same table, whose answers have the error of the curve between the rows beside those of the data. Correlated errors are
    /// those of a curve, and have it.
    #[must_use]
    pub fn with_error_of_curve(&self) -> Self {
        let curve_errs = self.0.root.is_none();
        Self(Arc::new(Cubics { curve_errs, ..Cubics::clone(&self.0) }))
    }

    /// The standard error of the sum of -phi' times a weight over `points`, pairs of slip speed and weight, by what the
    /// curve between the rows could be; 0 without [`Table::with_error_of_curve`].
    pub fn error_of_curve(&self, points: &[(f64, f64)]) -> f64 {
        if !self.0.curve_errs {
            return 0.0;
        }
        let mut ranges = vec![0.0; self.pieces()];
        for &(u, weight) in points {
            let piece = self.measured_piece_at(u);
            ranges[piece] += weight * (self.edge(piece, u) - self.secant(piece));
        }
        (ranges.iter().map(|range| range * range).sum::<f64>() / 12.0).sqrt()
    }

    /// Slip speeds at which the range jumps between two rows: where the edges meet. None without
    /// [`Table::with_error_of_curve`].
    pub fn meets(&self) -> Vec<f64> {
        let pieces = if self.0.curve_errs { 0..self.pieces() } else { 0..0 };
        pieces.filter_map(|piece| self.meet(piece)).collect()
    }

    /// The standard error of -phi' at `u` by what the curve between the rows could be. Where it bends one way, its slope
    /// is between those of the chords from the two rows to the other edge at `u`: at a row between the slopes of the
    /// pieces on both sides, where the edges meet between those of the pieces before and after. The same formula is taken
    /// where it bends both ways, and the slope of the only piece beside one at an end.
    pub(super) fn error_of_slope(&self, u: f64) -> f64 {
        if !self.0.curve_errs {
            return 0.0;
        }
        let piece = self.measured_piece_at(u);
        let ends = &self.0.u[piece..];
        let share = (u - ends[0]) / (ends[1] - ends[0]);
        let off = self.beside(piece).map(|slope| slope.map(|slope| (slope - self.secant(piece)).abs()));
        let range = match off {
            [Some(before), Some(after)] => (before / (1.0 - share)).min(after / share),
            [before, after] => before.or(after).unwrap_or(0.0),
        };
        range / 12f64.sqrt()
    }

    /// The piece of `u` between two rows. A line from the two slowest rows to rest is that of the piece between these.
    fn measured_piece_at(&self, u: f64) -> usize {
        self.piece_at(u).max(self.first_piece())
    }

    /// The first piece between two rows.
    fn first_piece(&self) -> usize {
        usize::from(self.0.source.no_rest)
    }

    fn secant(&self, piece: usize) -> f64 {
        let Cubics { u, phi, .. } = &*self.0;
        (phi[piece + 1] - phi[piece]) / (u[piece + 1] - u[piece])
    }

    /// The slope of the other edge of the triangle: that of the piece before as far as the point where the two edges
    /// meet, and beyond that of the piece after.
    fn edge(&self, piece: usize, u: f64) -> f64 {
        let here = self.secant(piece);
        match (self.beside(piece), self.meet(piece)) {
            ([Some(before), Some(after)], Some(meet)) => {
                if u < meet {
                    before
                } else {
                    after
                }
            }
            ([Some(_), Some(_)], None) => here,
            ([before, after], _) => before.or(after).unwrap_or(here),
        }
    }

    /// The slip speed at which the edges meet; `None` where the curve bends both ways, and next to an end.
    fn meet(&self, piece: usize) -> Option<f64> {
        let [before, after] = self.beside(piece);
        let (before, after) = (before?, after?);
        let share = (self.secant(piece) - after) / (before - after);
        let ends = &self.0.u[piece..];
        (share > 0.0 && share < 1.0).then(|| ends[0] + share * (ends[1] - ends[0]))
    }

    /// The slopes of the pieces before and after, between rows.
    fn beside(&self, piece: usize) -> [Option<f64>; 2] {
        let before = (piece > self.first_piece()).then(|| self.secant(piece - 1));
        [before, (piece + 1 < self.pieces()).then(|| self.secant(piece + 1))]
    }
}

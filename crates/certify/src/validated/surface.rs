//! The universal surface C*(A, k, b), enclosed over a box piece by piece.

use rayon::prelude::*;

use super::defect::Groups;
use super::even_part_bounds;
use super::tile::{GroupBox, Tile};
use slipmap_numbers::interval::Interval;

/// C* over a box of (A, k, b): pieces that cover it, each with a proof of its own or with the bounds by the
/// even part of the divergence alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The whole box.
    pub(crate) domain: GroupBox,
    pieces: Vec<Piece>,
    /// Number of proofs tried so far.
    pub(crate) tried: usize,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) struct Piece {
    domain: GroupBox,
    /// Whether a proof was tried.
    is_tried: bool,
    /// The proof; without one C* has the bounds by the even part of the divergence.
    pub(super) tile: Option<Box<Tile>>,
    /// Bound on the width of the enclosure anywhere in the piece.
    pub(super) width: f64,
    /// The width times the piece's share in the caller's measure: the priority of its refinement.
    weight: f64,
}

impl Surface {
    /// The surface over `domain` as one piece without a proof.
    #[must_use]
    pub fn new(domain: GroupBox) -> Self {
        let width = even_part_width(&domain);
        let whole = Piece { domain, is_tried: false, tile: None, width, weight: width };
        Self { domain, pieces: vec![whole], tried: 0 }
    }

    /// Tries proofs in order of decreasing weight, until `budget` proofs have been tried in all or no piece
    /// weighs more than `enough`. A step tries the heaviest piece itself if it is untried, else its halves.
    /// The weight of a piece is the width of its enclosure times its `share` in the caller's measure. Stops
    /// early where `go_on` returns false. The result does not depend on the number of threads.
    pub fn refine(
        &mut self,
        budget: usize,
        enough: f64,
        share: &dyn Fn(&GroupBox) -> f64,
        go_on: &dyn Fn() -> bool,
    ) {
        while self.tried < budget && go_on() {
            let heavy = self.pieces.iter().enumerate().filter(|(_, piece)| piece.weight > enough);
            let by_weight = |(i, one): &(usize, &Piece), (j, two): &(usize, &Piece)| {
                one.weight.total_cmp(&two.weight).then(j.cmp(i))
            };
            let Some((worst, _)) = heavy.max_by(by_weight) else { return };
            let Piece { domain, is_tried, tile, .. } = self.pieces.swap_remove(worst);
            let axis = tile.map_or_else(|| widest_axis(&domain), |tile| tile.roughest_axis());
            let domains = if is_tried { domain.halves(axis).to_vec() } else { vec![domain] };
            let parts: Vec<(GroupBox, f64)> = domains.into_iter().map(|part| (part, share(&part))).collect();
            self.tried += parts.iter().filter(|(_, share)| *share > 0.0).count();
            let parts: Vec<Piece> =
                parts.into_par_iter().map(|(domain, share)| Piece::new(domain, share)).collect();
            self.pieces.extend(parts);
        }
    }

    pub(crate) fn tiles(&self) -> impl Iterator<Item = &Tile> {
        self.pieces.iter().filter_map(|piece| piece.tile.as_deref())
    }

    /// The parts of the box that have no proof.
    pub(crate) fn open(&self) -> impl Iterator<Item = GroupBox> {
        self.pieces.iter().filter(|piece| piece.tile.is_none()).map(|piece| piece.domain)
    }

    pub(super) fn pieces_that_meet(&self, domain: &GroupBox) -> impl Iterator<Item = &Piece> {
        self.pieces.iter().filter(|piece| piece.domain.meets(domain))
    }
}

impl Piece {
    /// The piece over a box with its proof, which is tried unless its share is zero.
    fn new(domain: GroupBox, share: f64) -> Self {
        let is_tried = share > 0.0;
        let tile = is_tried.then(|| Tile::prove(domain)).flatten().map(Box::new);
        let even = even_part_width(&domain);
        let width = tile.as_ref().map_or(even, |tile| (2.0 * tile.radius).min(even));
        Self { domain, is_tried, tile, width, weight: width * share }
    }
}

/// Bound on the distance between the bounds by the even part of the divergence, anywhere in the box: the
/// distance rises with A and with k.
fn even_part_width(domain: &GroupBox) -> f64 {
    let top = |[_, hi]: [f64; 2]| Interval::of(hi);
    let bounds = even_part_bounds(&Groups { a: top(domain.a), k: top(domain.k), b: Interval::ZERO });
    (Interval::of(bounds.hi) - Interval::of(bounds.lo)).hi
}

/// The axis along which D varies most.
fn widest_axis(domain: &GroupBox) -> usize {
    let GroupBox { a, k, b } = domain;
    let widths = [a[1] - a[0], a[1] * (k[1] - k[0]) / (1.0 + k[0]), 2.0 * (b[1] - b[0])];
    (0..3).max_by(|&i, &j| widths[i].total_cmp(&widths[j])).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_is_the_same_for_any_number_of_threads() {
        let domain = GroupBox { a: [0.1, 0.4], k: [0.1, 0.3], b: [0.0, 0.02] };
        let share = |part: &GroupBox| part.a[1] - part.a[0];
        let refined = |threads: usize, tiles: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let mut surface = Surface::new(domain);
            pool.install(|| surface.refine(tiles, 0.0, &share, &|| true));
            surface
        };
        let alone = refined(1, 9);
        assert_eq!(alone.tried, 9);
        assert_eq!(alone, refined(3, 9));
    }
}

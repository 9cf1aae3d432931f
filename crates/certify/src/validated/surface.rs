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
struct Piece {
    domain: GroupBox,
    state: State,
    /// Bound on the width of the enclosure anywhere in the piece.
    width: f64,
    /// The width times the piece's share in the caller's measure: the priority of its refinement.
    weight: f64,
}

/// State of the proof of a piece.
#[derive(Clone, Debug, PartialEq)]
enum State {
    /// No proof was tried.
    Untried,
    /// The proof did not go through.
    Failed,
    Proved(Box<Tile>),
}

/// The enclosure of C* on a piece.
pub(super) enum Enclosure<'a> {
    Tile(&'a Tile),
    /// The bounds by the even part of the divergence, of this width.
    EvenPart(f64),
}

impl Surface {
    /// The surface over `domain` as one piece without a proof.
    #[must_use]
    pub fn new(domain: GroupBox) -> Self {
        let width = even_part_width(&domain);
        Self { domain, pieces: vec![Piece { domain, state: State::Untried, width, weight: width }], tried: 0 }
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
            let Piece { domain, state, .. } = self.pieces.swap_remove(worst);
            let domains = match state {
                State::Untried => vec![domain],
                State::Failed => domain.halves(widest_axis(&domain)).to_vec(),
                State::Proved(tile) => domain.halves(tile.roughest_axis()).to_vec(),
            };
            let parts: Vec<(GroupBox, f64)> = domains.into_iter().map(|part| (part, share(&part))).collect();
            self.tried += parts.iter().filter(|(_, share)| *share > 0.0).count();
            let parts: Vec<Piece> =
                parts.into_par_iter().map(|(domain, share)| Piece::new(domain, share)).collect();
            self.pieces.extend(parts);
        }
    }

    pub(crate) fn tiles(&self) -> impl Iterator<Item = &Tile> {
        self.pieces.iter().filter_map(|piece| match &piece.state {
            State::Proved(tile) => Some(&**tile),
            State::Untried | State::Failed => None,
        })
    }

    /// The parts of the box that have no proof.
    pub(crate) fn open(&self) -> impl Iterator<Item = GroupBox> {
        self.pieces.iter().filter(|piece| !matches!(piece.state, State::Proved(_))).map(|piece| piece.domain)
    }

    /// The enclosure of C* on each piece that meets `domain`.
    pub(super) fn enclosures(&self, domain: &GroupBox) -> impl Iterator<Item = Enclosure<'_>> {
        let domain = *domain;
        self.pieces.iter().filter(move |piece| piece.domain.meets(&domain)).map(|piece| match &piece.state {
            State::Proved(tile) => Enclosure::Tile(tile),
            State::Untried | State::Failed => Enclosure::EvenPart(piece.width),
        })
    }
}

impl Piece {
    /// The piece over a box with its proof, which is tried unless its share is zero.
    fn new(domain: GroupBox, share: f64) -> Self {
        let even = even_part_width(&domain);
        let (state, width) = match (share > 0.0).then(|| Tile::prove(domain)) {
            None => (State::Untried, even),
            Some(None) => (State::Failed, even),
            Some(Some(tile)) => {
                let width = (2.0 * tile.radius).min(even);
                (State::Proved(Box::new(tile)), width)
            }
        };
        Self { domain, state, width, weight: width * share }
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

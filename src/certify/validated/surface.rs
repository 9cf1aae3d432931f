//! The universal surface C*(A, k, b), enclosed over a box piece by piece.

use super::defect::Groups;
use super::even_part_bounds;
use super::interval::Interval;
use super::tile::{GroupBox, Tile};

/// C* over a box of (A, k, b): pieces that cover it, each with a proof of its own or with the bounds from the
/// even part of the divergence alone.
#[derive(Clone, Debug, PartialEq)]
pub struct Surface {
    /// The whole box.
    domain: GroupBox,
    pieces: Vec<Piece>,
    tried: usize,
}

/// A part of a surface.
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
    /// A proof.
    Proved(Box<Tile>),
}

/// The enclosure of C* on a piece.
pub(super) enum Enclosure<'a> {
    /// By a proved tile.
    Tile(&'a Tile),
    /// By the even part of the divergence, of this width.
    EvenPart(f64),
}

impl Surface {
    /// One piece, without a proof.
    #[must_use]
    pub fn new(domain: GroupBox) -> Self {
        let width = even_part_width(&domain);
        Self { domain, pieces: vec![Piece { domain, state: State::Untried, width, weight: width }], tried: 0 }
    }

    /// Tries proofs in order of decreasing weight, until `budget` have been tried in all or no piece weighs
    /// more than `enough`: of the piece itself if it has not been tried, else of its halves. The weight of a
    /// piece is the width of its enclosure times its `share` in the caller's measure. Stops early where
    /// `go_on` returns false.
    pub fn refine(
        &mut self,
        budget: usize,
        enough: f64,
        share: &dyn Fn(&GroupBox) -> f64,
        go_on: &dyn Fn() -> bool,
    ) {
        while self.tried < budget && go_on() {
            let heavier = |i: &usize, j: &usize| {
                self.pieces[*i].weight.total_cmp(&self.pieces[*j].weight).then(j.cmp(i))
            };
            let Some(worst) = (0..self.pieces.len()).max_by(heavier) else { return };
            if !(self.pieces[worst].weight > enough) {
                return;
            }
            let piece = self.pieces.swap_remove(worst);
            let domains = match &piece.state {
                State::Untried => vec![piece.domain],
                State::Failed => piece.domain.halves(widest_axis(&piece.domain)).to_vec(),
                State::Proved(tile) => piece.domain.halves(tile.roughest_axis()).to_vec(),
            };
            for domain in domains {
                let even = even_part_width(&domain);
                let share = share(&domain);
                // No proof is tried where the share is zero.
                let tile = (share > 0.0).then(|| Tile::prove(domain));
                self.tried += usize::from(tile.is_some());
                let (state, width) = match tile {
                    None => (State::Untried, even),
                    Some(None) => (State::Failed, even),
                    Some(Some(tile)) => {
                        let width = (2.0 * tile.radius).min(even);
                        (State::Proved(Box::new(tile)), width)
                    }
                };
                self.pieces.push(Piece { domain, state, width, weight: width * share });
            }
        }
    }

    /// The whole box.
    #[must_use]
    pub fn domain(&self) -> GroupBox {
        self.domain
    }

    /// Number of proofs tried so far.
    #[must_use]
    pub fn tried(&self) -> usize {
        self.tried
    }

    /// The proved tiles.
    pub fn tiles(&self) -> impl Iterator<Item = &Tile> {
        self.pieces.iter().filter_map(|piece| match &piece.state {
            State::Proved(tile) => Some(&**tile),
            State::Untried | State::Failed => None,
        })
    }

    /// The parts of the box that have no proof.
    pub fn open(&self) -> impl Iterator<Item = GroupBox> {
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

    /// Enclosure of C* at one point of the box; the whole line outside.
    #[cfg(test)]
    pub(super) fn critical(&self, groups: &Groups) -> Interval {
        let at = GroupBox::around(groups);
        let met = self.pieces.iter().filter(|piece| piece.domain.meets(&at));
        let even = even_part_bounds(groups);
        met.map(|piece| match &piece.state {
            State::Proved(tile) => tile.critical(groups).intersection(even),
            State::Untried | State::Failed => even,
        })
        .reduce(Interval::hull)
        .unwrap_or(Interval::WHOLE)
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
pub(super) fn widest_axis(domain: &GroupBox) -> usize {
    let GroupBox { a, k, b } = domain;
    let widths = [a[1] - a[0], a[1] * (k[1] - k[0]) / (1.0 + k[0]), 2.0 * (b[1] - b[0])];
    (0..3).max_by(|&i, &j| widths[i].total_cmp(&widths[j])).unwrap_or(0)
}

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
    /// early where `go_on` returns false.
    ///
    /// The next pieces are proved ahead, so that all threads of the current pool are busy. The result does not
    /// depend on their number: a piece is replaced only when it is the heaviest.
    pub fn refine(
        &mut self,
        budget: usize,
        enough: f64,
        share: &dyn Fn(&GroupBox) -> f64,
        go_on: &dyn Fn() -> bool,
    ) {
        let mut ahead: Vec<Replacement> = Vec::new();
        while self.tried < budget && go_on() {
            let Some(worst) = self.by_weight(enough).next() else { return };
            let domain = self.pieces[worst].domain;
            if !ahead.iter().any(|replacement| replacement.of == domain) {
                let threads = rayon::current_num_threads();
                ahead.extend(prove(self.next(budget - self.tried, enough, share, threads, &ahead)));
            }
            let Some(found) = ahead.iter().position(|replacement| replacement.of == domain) else { return };
            let parts = ahead.swap_remove(found).by;
            self.tried += parts.iter().filter(|part| part.state != State::Untried).count();
            self.pieces.swap_remove(worst);
            self.pieces.extend(parts);
        }
    }

    /// The pieces that weigh more than `enough`, heaviest first.
    fn by_weight(&self, enough: f64) -> impl Iterator<Item = usize> {
        let heavy = self.pieces.iter().enumerate().filter(|(_, piece)| piece.weight > enough);
        let mut heavy: Vec<(usize, f64)> = heavy.map(|(i, piece)| (i, piece.weight)).collect();
        heavy.sort_by(|(i, one), (j, two)| two.total_cmp(one).then(i.cmp(j)));
        heavy.into_iter().map(|(i, _)| i)
    }

    /// The heaviest pieces, and the boxes with their shares that replace them: two proofs for each thread as
    /// far as the budget goes, and at least one piece.
    fn next(
        &self,
        left: usize,
        enough: f64,
        share: &dyn Fn(&GroupBox) -> f64,
        threads: usize,
        ahead: &[Replacement],
    ) -> Vec<(GroupBox, Vec<(GroupBox, f64)>)> {
        let most = if threads > 1 { left.min(2 * threads) } else { 1 };
        let (mut next, mut proofs) = (Vec::new(), 0);
        for piece in self.by_weight(enough).map(|i| &self.pieces[i]) {
            if proofs >= most {
                break;
            }
            if ahead.iter().any(|replacement| replacement.of == piece.domain) {
                continue;
            }
            let domains = match &piece.state {
                State::Untried => vec![piece.domain],
                State::Failed => piece.domain.halves(widest_axis(&piece.domain)).to_vec(),
                State::Proved(tile) => piece.domain.halves(tile.roughest_axis()).to_vec(),
            };
            let parts: Vec<(GroupBox, f64)> = domains.into_iter().map(|part| (part, share(&part))).collect();
            proofs += parts.iter().filter(|(_, share)| *share > 0.0).count();
            next.push((piece.domain, parts));
        }
        next
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
        .unwrap_or(Interval::ENTIRE)
    }
}

/// The pieces `by` which the piece over the box `of` is to be replaced.
struct Replacement {
    of: GroupBox,
    by: Vec<Piece>,
}

/// Tries a proof of each of the boxes whose share is not zero.
fn prove(next: Vec<(GroupBox, Vec<(GroupBox, f64)>)>) -> Vec<Replacement> {
    let wanted = next.iter().flat_map(|(_, parts)| parts).filter(|(_, share)| *share > 0.0);
    let wanted: Vec<GroupBox> = wanted.map(|(part, _)| *part).collect();
    let proofs: Vec<Option<Tile>> = wanted.into_par_iter().map(Tile::prove).collect();
    let mut proofs = proofs.into_iter();
    let mut piece = |(domain, share): (GroupBox, f64)| {
        let even = even_part_width(&domain);
        let tried = (share > 0.0).then(|| proofs.next().flatten());
        let (state, width) = match tried {
            None => (State::Untried, even),
            Some(None) => (State::Failed, even),
            Some(Some(tile)) => {
                let width = (2.0 * tile.radius).min(even);
                (State::Proved(Box::new(tile)), width)
            }
        };
        Piece { domain, state, width, weight: width * share }
    };
    next.into_iter()
        .map(|(of, parts)| Replacement { of, by: parts.into_iter().map(&mut piece).collect() })
        .collect()
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
        let ahead = |threads: usize| alone.next(100, 0.0, &share, threads, &[]).len();
        assert!(ahead(1) == 1 && ahead(8) > 1, "eight threads get more than one piece at a time");
    }
}

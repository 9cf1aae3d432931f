//! Interpolation in a box of a grid, from values in a few of its cells that are chosen one after the other.
//!
//! **Nodes.** The nodes of an axis are values of that axis in the order of Leja: each is the value at which
//! the product of the distances from the nodes before it is greatest. Newton's polynomial of rank k, which is
//! that product divided by its value in node k, is 1 there, 0 in the nodes before and at most 1 in size on
//! the whole axis. In several dimensions a node has a rank on each axis, and its polynomial is the product.
//!
//! **Lower sets.** A set that contains, with each node, all nodes of lower ranks determines one polynomial in
//! the span of the nodes' polynomials. The coefficient of a node is its surplus: its value less the
//! polynomial through the nodes of lower ranks. Adding a node changes no other coefficient.
//!
//! **Error.** The frontier consists of the nodes whose next rank on some axis is not in the set. Their
//! contribution is of the size of the error before they were added. The error after that is smaller by the
//! fall of the surpluses from one rank to the next. The root of the sum of the squares of their surpluses is
//! taken to be the error, less where surpluses fall faster than by [`SAFETY`], more where they fall slowly. A
//! surplus may be small by chance, so it counts as at least [`FALL`] times the one before it. Errors of the
//! values appear in the surpluses, enlarged as they are in the polynomial.

use std::rc::Rc;

use slipmap_model::point::MAX_LAW_PARAMETERS;
use slipmap_numbers::{Range, vectorized};

/// Largest number of nodes of an axis.
const MOST: usize = 24;
/// Largest number of dimensions: eps, the law's parameters, V and c.
const DIMENSIONS: usize = MAX_LAW_PARAMETERS + 3;
/// The fastest fall of a surplus from one rank to the next that is accepted.
const FALL: f64 = 0.05;
/// Largest sum of the ranks of the nodes requested first: enough to estimate the fall of the surpluses.
const FIRST_RANKS: u8 = 3;
/// Safety factor on the expected fall of the next surpluses.
const SAFETY: f64 = 8.0;

/// The rank of a node on each axis, slowest first; 0 beyond the axes.
type Ranks = [u8; DIMENSIONS];

/// The values of an axis, or of a part of it.
#[derive(Debug)]
pub(super) struct Side {
    /// The values that may become nodes, by rank.
    nodes: Vec<usize>,
    /// Number of values.
    length: usize,
    /// For each rank its polynomial in all values, and zeros up to a multiple of [`LANES`].
    polynomials: Vec<f64>,
    /// For each rank the polynomials of all ranks in its node.
    at_nodes: Vec<f64>,
}

impl Side {
    /// `None` where a value is not finite, or two are equal.
    pub(super) fn new(values: &[f64]) -> Option<Self> {
        let Range { lo: low, hi: high } = Range::of(values.iter().copied());
        if !values.iter().all(|value| value.is_finite()) {
            return None;
        }
        // On [-2, 2] products of distances stay of the order of one.
        let stretched = |value: &f64| if high > low { 4.0 * (value - low) / (high - low) - 2.0 } else { 0.0 };
        let x: Vec<f64> = values.iter().map(stretched).collect();
        let mut nodes = Vec::new();
        let padded = x.len().next_multiple_of(LANES);
        let mut polynomials: Vec<f64> = Vec::new();
        let mut product: Vec<f64> = vec![1.0; x.len()];
        while nodes.len() < MOST.min(x.len()) {
            let of_size = |&cell: &usize| if nodes.is_empty() { -x[cell].abs() } else { product[cell].abs() };
            let farthest = (0..x.len()).max_by(|i, j| of_size(i).total_cmp(&of_size(j)));
            // Of equal values one can be a node.
            let Some(node) = farthest.filter(|&cell| product[cell] != 0.0) else { break };
            let scale = 1.0 / product[node];
            polynomials.extend(product.iter().map(|product| scale * product));
            polynomials.resize((nodes.len() + 1) * padded, 0.0);
            product.iter_mut().zip(&x).for_each(|(product, at)| *product *= at - x[node]);
            nodes.push(node);
        }
        let at_node = |node: usize| polynomials.chunks_exact(padded).map(move |values| values[node]);
        let at_nodes = nodes.iter().flat_map(|&node| at_node(node)).collect();
        let is_whole = nodes.len() == MOST.min(x.len());
        is_whole.then_some(Self { nodes, length: x.len(), polynomials, at_nodes })
    }

    /// The polynomials of all ranks in the node of a rank.
    fn at_node(&self, rank: usize) -> &[f64] {
        &self.at_nodes[rank * self.nodes.len()..][..self.nodes.len()]
    }

    /// The polynomial of a rank in all values, and zeros up to a multiple of [`LANES`].
    fn polynomial(&self, rank: usize) -> &[f64] {
        let padded = self.length.next_multiple_of(LANES);
        &self.polynomials[rank * padded..][..padded]
    }
}

/// A node.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Its rank on each axis, slowest first; 0 beyond the axes.
    ranks: Ranks,
    /// Its place among all nodes, row-major by their ranks.
    place: usize,
    /// The size of its surplus, raised where its fall is not accepted; 0 while the value is not known.
    size: f64,
}

/// The polynomial through the nodes of a lower set.
#[derive(Debug)]
pub(super) struct LowerSet {
    sides: Vec<Rc<Side>>,
    /// The distance between places of nodes of successive ranks, on each axis.
    strides: Vec<usize>,
    /// For each place the number of the node there, or [`NONE`].
    numbers: Vec<u32>,
    /// The nodes, those of lower ranks first.
    nodes: Vec<Node>,
    /// For each node with a known value, its surpluses on the axes from each axis on, that on all axes first.
    surpluses: Vec<f64>,
    /// Number of nodes whose values are known; those of the others are requested next.
    known: usize,
    /// The numbers of the nodes that were in the frontier before the last were added, and of these.
    frontier: Vec<usize>,
    /// Number of nodes and error of the polynomial, each time that values were taken.
    history: Vec<(f64, f64)>,
}

/// No node.
const NONE: u32 = u32::MAX;

impl LowerSet {
    /// A set that requests the values of the first nodes, those whose ranks have a small sum.
    pub(super) fn new(sides: Vec<Rc<Side>>) -> Self {
        let mut strides = vec![1; sides.len()];
        for axis in (1..sides.len()).rev() {
            strides[axis - 1] = strides[axis] * sides[axis].nodes.len();
        }
        let all = sides.iter().map(|side| side.nodes.len()).product();
        let numbers = vec![NONE; all];
        let (nodes, surpluses, frontier, history) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let mut set = Self { sides, strides, numbers, nodes, surpluses, known: 0, frontier, history };
        set.want([0; DIMENSIONS]);
        let mut from = 0;
        for _ in 0..FIRST_RANKS {
            let to = set.nodes.len();
            for number in from..to {
                set.want_following(number);
            }
            from = to;
        }
        set
    }

    /// The place of the node of the next rank on an axis, if there is one.
    fn following(&self, node: &Node, axis: usize) -> Option<usize> {
        let has_next = usize::from(node.ranks[axis]) + 1 < self.sides[axis].nodes.len();
        has_next.then(|| node.place + self.strides[axis])
    }

    /// Requests the missing nodes of the next rank on each axis.
    fn want_following(&mut self, number: usize) {
        for axis in 0..self.sides.len() {
            let node = &self.nodes[number];
            if self.following(node, axis).is_some_and(|place| self.numbers[place] == NONE) {
                let mut ranks = node.ranks;
                ranks[axis] += 1;
                self.want(ranks);
            }
        }
    }

    /// Requests a missing node, after all missing nodes of lower ranks.
    fn want(&mut self, ranks: Ranks) {
        let place = self.strides.iter().zip(ranks).map(|(stride, rank)| stride * usize::from(rank)).sum();
        for axis in 0..self.sides.len() {
            if ranks[axis] > 0 && self.numbers[place - self.strides[axis]] == NONE {
                let mut before = ranks;
                before[axis] -= 1;
                self.want(before);
            }
        }
        self.numbers[place] = self.nodes.len() as u32;
        self.nodes.push(Node { ranks, place, size: 0.0 });
    }

    /// The cells, numbered row-major in the box, of the nodes whose values are requested.
    pub(super) fn wanted(&self) -> impl Iterator<Item = usize> + '_ {
        self.nodes[self.known..].iter().map(|node| {
            let ranks = self.sides.iter().zip(node.ranks);
            ranks.fold(0, |cell, (side, rank)| cell * side.length + side.nodes[usize::from(rank)])
        })
    }

    /// Number of nodes, requested ones included.
    pub(super) fn nodes(&self) -> usize {
        self.nodes.len()
    }

    /// Takes the values of the requested nodes, and returns the error of the polynomial through all nodes;
    /// see the module.
    pub(super) fn take(&mut self, values: impl IntoIterator<Item = f64>) -> f64 {
        for (number, value) in (self.known..self.nodes.len()).zip(values) {
            self.take_value(number, value);
            self.frontier.push(number);
        }
        self.known = self.nodes.len();
        let mut frontier = std::mem::take(&mut self.frontier);
        frontier.retain(|&number| self.is_in_frontier(&self.nodes[number]));
        self.frontier = frontier;
        let error = self.error();
        self.history.push((self.nodes.len() as f64, error));
        error
    }

    /// The number of nodes at which the error is expected to be small enough, if errors fall and numbers of
    /// nodes grow as they did last. 0 while the history is too short.
    pub(super) fn expected_nodes(&self, enough: f64) -> f64 {
        let [.., (_, before), (fewer, _), (nodes, error)] = self.history[..] else { return 0.0 };
        if !(error < before) {
            return f64::INFINITY;
        }
        let fall = (error / before).sqrt();
        let ranks = f64::from(FIRST_RANKS) + (self.history.len() - 1) as f64;
        let left = (enough / error).ln() / fall.ln();
        let dimension = (nodes / fewer).ln() / (ranks / (ranks - 1.0)).ln();
        nodes * (1.0 + left / ranks).powf(dimension)
    }

    /// The error of the polynomial; see the module.
    fn error(&self) -> f64 {
        let (mut squares, mut squares_before) = (0.0, 0.0);
        for &number in &self.frontier {
            let node = &self.nodes[number];
            let two_before = (self.strides.iter().zip(node.ranks).filter(|(_, rank)| *rank > 1))
                .map(|(stride, _)| self.size_at(node.place - 2 * stride));
            squares += node.size.powi(2);
            squares_before += two_before.fold(node.size, f64::max).powi(2);
        }
        if squares == 0.0 {
            return 0.0;
        }
        // The factor from one rank to the next; 1 or more where surpluses do not fall.
        let fall = (squares / squares_before).sqrt().sqrt();
        squares.sqrt() * (SAFETY * fall).min(1.0) * (fall / (1.0 - fall)).max(1.0)
    }

    /// Computes the surpluses of the next node: its value less the polynomial through the nodes of lower
    /// ranks, axis by axis.
    fn take_value(&mut self, number: usize, value: f64) {
        let axes = self.sides.len();
        let Node { ranks, place, .. } = self.nodes[number];
        let mut surpluses = [0.0; DIMENSIONS];
        let mut surplus = value;
        for (axis, (side, stride)) in self.sides.iter().zip(&self.strides).enumerate().rev() {
            let rank = usize::from(ranks[axis]);
            let mut lower = place - rank * stride;
            for polynomial in &side.at_node(rank)[..rank] {
                surplus -= polynomial * self.surpluses[self.numbers[lower] as usize * axes + axis];
                lower += stride;
            }
            surpluses[axis] = surplus;
        }
        let mut size = surplus.abs();
        for (stride, rank) in self.strides.iter().zip(ranks).filter(|(_, rank)| *rank > 0) {
            let before = |ranks: usize| self.size_at(place - ranks * stride);
            // The mean fall over several ranks, where the frontier has no other surplus to confirm it. This
            // surplus, or that four ranks before, may be small or large by chance: the slower fall of two.
            let mean_fall = |size: f64, before: f64| (size / before).sqrt().sqrt().min(1.0);
            let fall = match rank {
                5.. if axes == 1 => mean_fall(size, before(4)).max(mean_fall(before(1), before(5))),
                _ => FALL,
            };
            size = size.max(fall * before(1));
        }
        self.nodes[number].size = size;
        self.surpluses.extend_from_slice(&surpluses[..axes]);
    }

    /// The size of the surplus of the node at a place.
    fn size_at(&self, place: usize) -> f64 {
        self.surplus(self.numbers[place] as usize).abs()
    }

    /// The surplus of a node on all axes.
    fn surplus(&self, number: usize) -> f64 {
        self.surpluses[number * self.sides.len()]
    }

    /// Returns whether a node has a next one that is not in the set, and that may not even be a node of its
    /// axis.
    fn is_in_frontier(&self, node: &Node) -> bool {
        self.sides.iter().enumerate().any(|(axis, side)| match self.following(node, axis) {
            Some(place) => self.numbers[place] == NONE,
            None => side.nodes.len() < side.length,
        })
    }

    /// Requests the nodes that follow those frontier nodes whose surplus exceeds its share of the error
    /// `enough`.
    pub(super) fn grow(&mut self, enough: f64) {
        let share = enough / (self.frontier.len() as f64).sqrt();
        for at in 0..self.frontier.len() {
            let number = self.frontier[at];
            if self.nodes[number].size > share {
                self.want_following(number);
            }
        }
    }

    /// The values in all cells of the polynomial through other values at the same nodes, in the order in
    /// which they were added.
    pub(super) fn through(&self, values: impl IntoIterator<Item = f64>) -> Vec<f64> {
        let Self { sides, strides, numbers, nodes, .. } = self;
        let (sides, strides, numbers, nodes) =
            (sides.clone(), strides.clone(), numbers.clone(), nodes.clone());
        let (surpluses, frontier, history) = (Vec::new(), Vec::new(), Vec::new());
        let mut other = Self { sides, strides, numbers, nodes, surpluses, known: 0, frontier, history };
        other.take(values);
        other.values()
    }

    /// The values of the polynomial in all cells of the box, row-major.
    pub(super) fn values(&self) -> Vec<f64> {
        let mut most = [0; DIMENSIONS];
        for node in &self.nodes {
            most.iter_mut().zip(node.ranks).for_each(|(most, rank)| *most = rank.max(*most));
        }
        let axes = self.sides.len();
        let mut counts: Vec<usize> = most[..axes].iter().map(|&most| usize::from(most) + 1).collect();
        counts[axes - 1] = counts[axes - 1].next_multiple_of(LANES);
        let mut values = vec![0.0; counts.iter().product()];
        for (number, node) in self.nodes.iter().enumerate() {
            let ranks = counts.iter().zip(node.ranks);
            values[ranks.fold(0, |at, (count, rank)| at * count + usize::from(rank))] = self.surplus(number);
        }
        vectorized(
            #[inline(always)]
            || {
                for (axis, side) in self.sides[..axes - 1].iter().enumerate() {
                    let inner = counts[axis + 1..].iter().product();
                    values = along_axis(&values, side, counts[axis], inner);
                }
                along_last_axis(&values, &self.sides[axes - 1], counts[axes - 1])
            },
        )
    }
}

/// Numbers that are computed together.
type Lanes = [f64; LANES];
const LANES: usize = 8;

/// Transforms coefficients of the first `count` ranks of an axis to values along it, for each index of the
/// axes before, and for `inner` numbers together, a multiple of [`LANES`].
#[inline(always)]
fn along_axis(coefficients: &[f64], side: &Side, count: usize, inner: usize) -> Vec<f64> {
    let mut values = vec![0.0; coefficients.len() / count * side.length];
    let blocks = values.chunks_exact_mut(side.length * inner).zip(coefficients.chunks_exact(count * inner));
    for (values, rows) in blocks {
        for (at, values) in values.chunks_exact_mut(inner).enumerate() {
            for (first, values) in values.chunks_exact_mut(LANES).enumerate() {
                let mut sums = Lanes::default();
                for (rank, row) in rows.chunks_exact(inner).enumerate() {
                    add(&mut sums, side.polynomial(rank)[at], &row[LANES * first..][..LANES]);
                }
                values.copy_from_slice(&sums);
            }
        }
    }
    values
}

/// As [`along_axis`], along the last axis.
#[inline(always)]
fn along_last_axis(coefficients: &[f64], side: &Side, count: usize) -> Vec<f64> {
    let mut values = vec![0.0; coefficients.len() / count * side.length];
    for (values, row) in values.chunks_exact_mut(side.length).zip(coefficients.chunks_exact(count)) {
        for (first, values) in values.chunks_mut(LANES).enumerate() {
            let mut sums = Lanes::default();
            for (rank, &coefficient) in row[..count.min(side.nodes.len())].iter().enumerate() {
                add(&mut sums, coefficient, &side.polynomial(rank)[LANES * first..][..LANES]);
            }
            values.iter_mut().zip(sums).for_each(|(value, sum)| *value = sum);
        }
    }
    values
}

#[inline(always)]
fn add(sums: &mut Lanes, factor: f64, numbers: &[f64]) {
    for (sum, number) in sums.iter_mut().zip(numbers) {
        *sum += factor * number;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn functions_with_a_kink_are_not_interpolated() {
        let value = |i: usize, count: usize| 0.2 + (i as f64 + 0.06 * ((7 * i) % 5) as f64) / count as f64;
        for counts in [&[40][..], &[30, 40]] {
            let axes = counts.iter().map(|&n| (0..n).map(|i| value(i, n)).collect::<Vec<f64>>());
            let mut set = LowerSet::new(axes.map(|axis| Rc::new(Side::new(&axis).unwrap())).collect());
            let inner: usize = counts[1..].iter().product();
            while set.wanted().next().is_some() {
                let kink = |cell: usize| (value(cell / inner, counts[0]) - 0.61).abs();
                let values: Vec<f64> = set.wanted().map(kink).collect();
                assert!(set.take(values) > 1e-9, "{counts:?}");
                set.grow(1e-9);
            }
        }
    }
}

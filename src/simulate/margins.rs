//! Margins along whole columns: the turns of a few cells, and a polynomial in c through them for the others.
//!
//! The margin m/V of a column is analytic in c wherever the orbits complete their turn (theory, "Margins of a
//! column"). The nodes of the polynomial are cells of the column in the order of Leja, each farthest from those
//! before it: one more node leaves the others useful, and a column that is not interpolated has wasted none.
//!
//! **Error.** A new node tells how wrong the polynomial through the nodes before it is, about where it is worst:
//! its surplus. The error of the polynomial through all nodes is taken to be no smaller than the last surplus,
//! though it falls with every node; and no smaller than the surplus before times the slowest fall of all, since
//! one surplus may be small by chance. The errors of the turns are added, times Lebesgue's function. A cell
//! where all that exceeds the tolerance gets a turn of its own.

use std::cell::OnceCell;
use std::f64::consts::PI;

use super::return_map::{Turn, UNRESOLVED, turns_of_orbits};
use crate::friction::Column;

/// Least number of nodes: enough to see how the surpluses fall.
const FEWEST: usize = 5;
/// Largest number of nodes.
const MOST: usize = 24;
/// Largest size of the divergence of interpolated columns. Half of that of a node, and small enough for the
/// margin to follow exp(-pi eps c): no surplus is small for other reasons than that all are.
const NEAR: f64 = 1.0;
/// Shares of the tolerance for the turns at the nodes, whose errors grow with Lebesgue's function, and for the
/// polynomial.
const SHARE_OF_TURNS: f64 = 0.25;
const SHARE_OF_POLYNOMIAL: f64 = 0.5;
/// Rounding errors of the polynomial's value, in units of the largest margin.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// Margins of the orbits of all columns at the dampings `cs`, column by column, each with an error of at most
/// `tolerance` where that can be reached. An interpolated margin has no evaluations of its own.
///
/// A column's margins do not depend on the other columns.
#[must_use]
pub fn margins(columns: &[Column], cs: &[f64], tolerance: f64) -> Vec<Turn> {
    let axis = Axis::new(cs);
    // Larger errors may leave a margin unresolved.
    let goal = tolerance.min(UNRESOLVED);
    let mut turns = vec![Turn::HandOver { rhs: 0 }; columns.len() * cs.len()];
    let (mut growing, mut single): (Vec<Growing>, Vec<usize>) = (Vec::new(), Vec::new());
    for (number, column) in columns.iter().enumerate() {
        let first = number * cs.len();
        match axis.nodes_for(column, SHARE_OF_POLYNOMIAL * goal) {
            Some(wanted) => {
                growing.push(Growing { first, values: [0.0; MOST], count: 0, wanted, error: 0.0 })
            }
            None => single.extend(first..first + cs.len()),
        }
    }
    let turns_at = |cells: &[usize], tolerance: f64| {
        let orbit = |&cell: &usize| (&columns[cell / cs.len()], cs[cell % cs.len()]);
        turns_of_orbits(cells.iter().map(orbit), tolerance)
    };
    let mut nodes = Vec::new();
    while !growing.is_empty() {
        nodes.clear();
        for column in &growing {
            let next = &axis.order[column.count..column.wanted];
            nodes.extend(next.iter().map(|cell| column.first + cell));
        }
        let mut found = turns_at(&nodes, SHARE_OF_TURNS * goal).into_iter();
        growing.retain_mut(|column| {
            let cells = &mut turns[column.first..][..cs.len()];
            match column.grow(&axis, &mut found, cells, goal) {
                Next::MoreNodes => return true,
                Next::Interpolate { error } => column.fill(&axis, error, goal, cells, &mut single),
                Next::OwnTurns { nodes } => {
                    let others = (0..cs.len()).filter(|&cell| axis.rank[cell] >= nodes);
                    single.extend(others.map(|cell| column.first + cell));
                }
            }
            false
        });
    }
    for (&cell, turn) in single.iter().zip(turns_at(&single, tolerance)) {
        turns[cell] = turn;
    }
    turns
}

/// The dampings of a column as nodes.
struct Axis {
    low: f64,
    high: f64,
    /// c of every cell, stretched to [-2, 2]: products of distances from nodes stay of the order of one.
    x: Vec<f64>,
    /// The cells that may become nodes, in the order in which they do: each is, of all cells, where the product of
    /// the distances from those before is greatest.
    order: Vec<usize>,
    /// The place of every cell in that order, or more than any.
    rank: Vec<usize>,
    /// For each node, the polynomial through those before it, there.
    before: Vec<Polynomial>,
    /// The polynomials through as many nodes.
    polynomials: Vec<OnceCell<Polynomial>>,
}

/// The polynomials through the first nodes of an axis, in some cells.
struct Polynomial {
    /// The weight of each node's value in each cell, node by node: Lagrange's polynomials.
    weights: Vec<f64>,
    /// Lebesgue's function in each cell.
    lebesgue: Vec<f64>,
}

impl Polynomial {
    fn new(x: &[f64], nodes: &[usize], cells: &[usize]) -> Self {
        let product = |node: usize, at: f64| -> f64 {
            nodes.iter().filter(|&&other| other != node).map(|&other| at - x[other]).product()
        };
        let mut weights = Vec::with_capacity(nodes.len() * cells.len());
        let mut lebesgue = vec![0.0; cells.len()];
        for &node in nodes {
            let scale = 1.0 / product(node, x[node]);
            for (sum, &cell) in lebesgue.iter_mut().zip(cells) {
                let weight: f64 = scale * product(node, x[cell]);
                *sum += weight.abs();
                weights.push(weight);
            }
        }
        Self { weights, lebesgue }
    }
}

impl Axis {
    fn new(cs: &[f64]) -> Self {
        let [low, high] = [f64::min, f64::max].map(|pick| cs.iter().copied().fold(f64::NAN, pick));
        let x: Vec<f64> = cs.iter().map(|c| 4.0 * (c - low) / (high - low) - 2.0).collect();
        // More nodes would save little.
        let most = (2 * cs.len() / 3).min(MOST);
        let (mut order, mut rank) = (Vec::new(), vec![usize::MAX; x.len()]);
        let mut reach = x.clone();
        while order.len() < most {
            let farthest = (0..x.len()).max_by(|&i, &j| reach[i].abs().total_cmp(&reach[j].abs()));
            // Of equal dampings one can be a node; NaN cannot.
            let Some(next) = farthest.filter(|&cell| reach[cell].abs() > 0.0) else { break };
            for (reach, at) in reach.iter_mut().zip(&x) {
                *reach = if order.is_empty() { 1.0 } else { *reach } * (at - x[next]);
            }
            rank[next] = order.len();
            order.push(next);
        }
        let before =
            order.iter().enumerate().map(|(count, &node)| Polynomial::new(&x, &order[..count], &[node]));
        let before = before.collect();
        let polynomials = (0..=order.len()).map(|_| OnceCell::new()).collect();
        Self { low, high, x, order, rank, before, polynomials }
    }

    /// The number of nodes with which a column starts: where exp(-pi eps c) has Chebyshev coefficients below
    /// `enough`. `None` if the column cannot be interpolated.
    fn nodes_for(&self, column: &Column, enough: f64) -> Option<usize> {
        let [low, high] = [self.low, self.high].map(|c| column.epsilon * c);
        let is_near = |u: f64| {
            let weakening = column.curve.weakening(u);
            (weakening - low).abs() <= NEAR && (weakening - high).abs() <= NEAR
        };
        let reach = [0.0, column.belt_speed, 2.0 * column.belt_speed];
        if self.order.len() < FEWEST || !(column.curve.is_analytic() && reach.into_iter().all(is_near)) {
            return None;
        }
        let quarter = 0.25 * PI * (high - low);
        let mut coefficient = 2.0;
        let last = (1..self.order.len()).find(|&degree| {
            coefficient *= quarter / degree as f64;
            coefficient <= enough
        });
        last.map(|degree| (degree + 1).max(FEWEST))
    }

    /// The polynomial through the first `count` nodes.
    fn polynomial(&self, count: usize) -> &Polynomial {
        self.polynomials[count].get_or_init(|| {
            Polynomial::new(&self.x, &self.order[..count], &(0..self.x.len()).collect::<Vec<_>>())
        })
    }
}

/// What follows from the nodes of a column so far.
enum Next {
    MoreNodes,
    /// The polynomial has this error.
    Interpolate {
        error: f64,
    },
    /// More nodes than the axis has would be needed, or an orbit does not complete its turn.
    OwnTurns {
        /// Number of nodes, which have theirs.
        nodes: usize,
    },
}

/// A column whose polynomial grows.
struct Growing {
    /// Its first cell.
    first: usize,
    /// The margins at its nodes.
    values: [f64; MOST],
    /// Number of nodes, and the number that it is to have next.
    count: usize,
    wanted: usize,
    /// Largest error of a margin at a node.
    error: f64,
}

impl Growing {
    /// Takes the turns of the next nodes.
    fn grow(
        &mut self,
        axis: &Axis,
        found: &mut impl Iterator<Item = Turn>,
        cells: &mut [Turn],
        goal: f64,
    ) -> Next {
        let mut complete = true;
        for (&cell, turn) in axis.order[self.count..self.wanted].iter().zip(found) {
            cells[cell] = turn;
            match turn {
                Turn::Complete { margin, error, .. } if error <= goal => {
                    self.values[self.count] = margin;
                    self.count += 1;
                    self.error = self.error.max(error);
                }
                Turn::Complete { .. } | Turn::HandOver { .. } => complete = false,
            }
        }
        if !complete {
            return Next::OwnTurns { nodes: self.wanted };
        }
        let (fall, error) = self.surplus(axis);
        let enough = SHARE_OF_POLYNOMIAL * goal;
        if error <= enough {
            return Next::Interpolate { error };
        }
        // No more than will be needed.
        let more = if fall < 1.0 { ((enough / error).ln() / fall.ln()).floor().max(1.0) } else { 1.0 };
        self.wanted += more.min(MOST as f64) as usize;
        if self.wanted <= axis.order.len() { Next::MoreNodes } else { Next::OwnTurns { nodes: self.count } }
    }

    /// The slowest fall of the surpluses, per node, over one node or two, as far as errors of the turns do not
    /// explain it; and the error of the polynomial, infinite if they do not fall.
    fn surplus(&self, axis: &Axis) -> (f64, f64) {
        let noise = self.noise();
        let (mut over_one, mut over_two) = (0.0_f64, 0.0_f64);
        let (mut before, mut last) = (f64::INFINITY, f64::INFINITY);
        for (node, polynomial) in axis.before[..self.count].iter().enumerate().skip(1) {
            let terms = polynomial.weights.iter().zip(&self.values);
            let surplus =
                (self.values[node] - terms.map(|(weight, value)| weight * value).sum::<f64>()).abs();
            let unexplained = (surplus - noise * (1.0 + polynomial.lebesgue[0])).max(0.0);
            // NaN, of nothing from nothing, is no fall.
            over_one = over_one.max(unexplained / last);
            over_two = over_two.max(unexplained / before);
            (before, last) = (last, surplus);
        }
        let fall = over_one.max(over_two.sqrt());
        let error = last.max(fall * before) * (fall / (1.0 - fall)).max(1.0);
        (fall, if fall < 1.0 { error } else { f64::INFINITY })
    }

    /// Error of the values.
    fn noise(&self) -> f64 {
        self.error
            + ROUNDING * self.values[..self.count].iter().fold(0.0, |most: f64, value| most.max(value.abs()))
    }

    /// Fills the cells that are not nodes by the polynomial of this error; lists those whose whole error exceeds
    /// the goal.
    fn fill(&self, axis: &Axis, error: f64, goal: f64, cells: &mut [Turn], single: &mut Vec<usize>) {
        let (noise, count) = (self.noise(), self.count);
        let polynomial = axis.polynomial(count);
        let mut margins = vec![0.0; cells.len()];
        for (value, weights) in self.values.iter().zip(polynomial.weights.chunks_exact(cells.len())) {
            margins.iter_mut().zip(weights).for_each(|(margin, weight)| *margin += weight * value);
        }
        for (cell, margin) in margins.into_iter().enumerate().filter(|(cell, _)| axis.rank[*cell] >= count) {
            let error = error + noise * polynomial.lebesgue[cell];
            if error <= goal {
                cells[cell] = Turn::Complete { margin, error, rhs: 0 };
            } else {
                single.push(self.first + cell);
            }
        }
    }
}

//! Margins along whole columns: the turns of a few cells, and a polynomial in c through them for the others.
//!
//! The margin m/V of a column is analytic in c wherever the orbits complete their turn, and 1 + m/V is nearly
//! that of a spiral, an orbit whose divergence stays what it is at belt speed
//! (theory, "Margins of a column"). The polynomial is one through their ratio, less 1. Its nodes are cells of
//! the column in the order of Leja, each farthest from those before it: one more node leaves the others
//! useful, and a column that is not interpolated has wasted none.
//!
//! **Error.** A new node tells how wrong the polynomial through the nodes before it is, about where it is
//! worst: its surplus. Surpluses fall from node to node; the error of the polynomial through all nodes is
//! taken to be the last surplus times eight times their slowest fall, though at most that surplus; where it
//! may be small by chance, the one before times the slowest fall takes its place. The errors of the turns are
//! added, times Lebesgue's function. A cell where all that exceeds the tolerance gets a turn of its own.

use std::cell::OnceCell;
use std::f64::consts::PI;

use super::polar::exp;
use super::return_map::{Turn, UNRESOLVED, turns_of_orbits};
use crate::friction::Column;

/// Least number of nodes: enough to see how the surpluses fall.
const FEWEST: usize = 5;
/// Largest number of nodes.
const MOST: usize = 24;
/// Largest size of the divergence of interpolated columns. Half of that of a node, and small enough for the
/// margin to follow exp(-pi eps c): no surplus is small for other reasons than that all are.
const NEAR: f64 = 1.0;
/// Shares of the tolerance for the turns at the nodes, whose errors grow with Lebesgue's function, and for
/// the polynomial.
const SHARE_OF_TURNS: f64 = 0.3;
const SHARE_OF_POLYNOMIAL: f64 = 0.5;
/// Safety of the fall that is expected of the next surplus.
const SAFETY: f64 = 8.0;
/// Rounding errors of a ratio.
const ROUNDING: f64 = 32.0 * f64::EPSILON;

/// The margins of cells.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Margins {
    /// m/V of each cell; NaN where the return map gives none, see [`Turn::HandOver`].
    pub margins: Vec<f64>,
    /// Estimate of the absolute error of each.
    pub errors: Vec<f64>,
    /// Number of evaluations of the right-hand side for each: none where it was interpolated.
    pub rhs: Vec<u32>,
}

impl Margins {
    /// Of cells of which nothing is known.
    fn none(cells: usize) -> Self {
        Self { margins: vec![f64::NAN; cells], errors: vec![f64::NAN; cells], rhs: vec![0; cells] }
    }

    fn put(&mut self, cell: usize, turn: Turn) {
        let (margin, error, rhs) = match turn {
            Turn::Complete { margin, error, rhs } => (margin, error, rhs),
            Turn::HandOver { rhs } => (f64::NAN, f64::NAN, rhs),
        };
        (self.margins[cell], self.errors[cell]) = (margin, error);
        self.rhs[cell] += rhs;
    }
}

/// Margins of the orbits of all columns at the dampings `cs`, column by column, each with an error of at most
/// `tolerance` where that can be reached.
///
/// A column's margins do not depend on the other columns.
#[must_use]
pub fn margins(columns: &[Column], cs: &[f64], tolerance: f64) -> Margins {
    let axis = Axis::new(cs);
    // Larger errors may leave a margin unresolved.
    let goal = tolerance.min(UNRESOLVED);
    let mut done = Margins::none(columns.len() * cs.len());
    let (mut growing, mut single): (Vec<Growing>, Vec<usize>) = (Vec::new(), Vec::new());
    let spirals = reach_of_spirals(columns, cs);
    for (number, column) in columns.iter().enumerate() {
        let cells = number * cs.len()..(number + 1) * cs.len();
        match Growing::new(&axis, column, cells.start, &spirals[cells.clone()], goal) {
            Some(column) => growing.push(column),
            None => single.extend(cells),
        }
    }
    growing.sort_by(|a, b| a.goal.total_cmp(&b.goal));
    let orbit = |&cell: &usize| (&columns[cell / cs.len()], cs[cell % cs.len()]);
    let (mut nodes, mut found) = (Vec::new(), Vec::new());
    while !growing.is_empty() {
        found.clear();
        for alike in growing.chunk_by(|a, b| a.goal == b.goal) {
            nodes.clear();
            for column in alike {
                let next = &axis.order[column.count..column.wanted];
                nodes.extend(next.iter().map(|cell| column.first + cell));
            }
            found.extend(turns_of_orbits(nodes.iter().map(orbit), SHARE_OF_TURNS * alike[0].goal));
        }
        let mut found = found.iter().copied();
        growing.retain_mut(|column| {
            let spirals = &spirals[column.first..][..cs.len()];
            match column.grow(&axis, spirals, &mut found, &mut done) {
                Next::MoreNodes => return true,
                Next::Interpolate { error } => {
                    column.fill(&axis, spirals, error, &mut done);
                    let cells = column.first..column.first + cs.len();
                    single.extend(cells.filter(|&cell| !(done.errors[cell] <= goal)));
                }
                Next::OwnTurns { nodes } => {
                    let others = (0..cs.len()).filter(|&cell| axis.rank[cell] >= nodes);
                    single.extend(others.map(|cell| column.first + cell));
                }
            }
            false
        });
    }
    for (&cell, turn) in single.iter().zip(turns_of_orbits(single.iter().map(orbit), tolerance)) {
        done.put(cell, turn);
    }
    done
}

/// 1 + m/V of orbits along which the divergence is that at belt speed: exp(pi D / sqrt(1 - D^2/4)).
fn reach_of_spirals(columns: &[Column], cs: &[f64]) -> Vec<f64> {
    let divergences = |column: &Column| {
        let (weakening, epsilon) = (column.curve.weakening(column.belt_speed), column.epsilon);
        cs.iter().map(move |c| weakening - epsilon * c)
    };
    let mut cells: Vec<f64> = columns.iter().flat_map(divergences).collect();
    pulp::Arch::new().dispatch(
        #[inline(always)]
        || {
            for cell in &mut cells {
                *cell = exp::<6>(PI * *cell / (1.0 - 0.25 * *cell * *cell).sqrt());
            }
        },
    );
    cells
}

/// The dampings of a column as nodes.
struct Axis {
    low: f64,
    high: f64,
    /// c of every cell, stretched to [-2, 2]: products of distances from nodes stay of the order of one.
    x: Vec<f64>,
    /// The cells that may become nodes, in the order in which they do: each is, of all cells, where the
    /// product of the distances from those before is greatest.
    order: Vec<usize>,
    /// The place of every cell in that order, or more than any.
    rank: Vec<usize>,
    /// For each node, the weights there of the nodes before it, see [`weights`].
    before: Vec<Vec<f64>>,
    /// The weights in all cells of as many first nodes.
    weights: Vec<OnceCell<Vec<f64>>>,
}

/// The weights of the values at `nodes` in a polynomial's values in `cells`, node by node: Lagrange's
/// polynomials.
fn weights(x: &[f64], nodes: &[usize], cells: &[usize]) -> Vec<f64> {
    let product = |node: usize, at: f64| -> f64 {
        nodes.iter().filter(|&&other| other != node).map(|&other| at - x[other]).product()
    };
    let weights_of = |&node: &usize| {
        let scale = 1.0 / product(node, x[node]);
        cells.iter().map(move |&cell| scale * product(node, x[cell]))
    };
    nodes.iter().flat_map(weights_of).collect()
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
        let before = order.iter().enumerate().map(|(count, &node)| weights(&x, &order[..count], &[node]));
        let before = before.collect();
        let weights = (0..=order.len()).map(|_| OnceCell::new()).collect();
        Self { low, high, x, order, rank, before, weights }
    }

    /// The number of nodes with which a column starts: where exp(-pi eps c), times four variations of the
    /// divergence along the orbit, has Chebyshev coefficients below `enough`. `None` if the column cannot be
    /// interpolated.
    fn nodes_for(&self, column: &Column, enough: f64) -> Option<usize> {
        let [low, high] = [self.low, self.high].map(|c| column.epsilon * c);
        let weakening = [1.0, 0.0, 2.0].map(|x| column.curve.weakening(x * column.belt_speed));
        let near = weakening.iter().all(|at| (at - low).abs() <= NEAR && (at - high).abs() <= NEAR);
        if self.order.len() < FEWEST || !(column.curve.is_analytic() && near) {
            return None;
        }
        let quarter = 0.25 * PI * (high - low);
        let variation = weakening.iter().fold(0.0, |most: f64, at| most.max((at - weakening[0]).abs()));
        let mut coefficient = 8.0 * variation;
        let last = (1..self.order.len()).find(|&degree| {
            coefficient *= quarter / degree as f64;
            coefficient <= enough
        });
        last.map(|degree| (degree + 1).max(FEWEST))
    }

    /// The weights in all cells of the first `count` nodes.
    fn weights(&self, count: usize) -> &[f64] {
        self.weights[count]
            .get_or_init(|| weights(&self.x, &self.order[..count], &(0..self.x.len()).collect::<Vec<_>>()))
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
    /// Largest error of a ratio that is small enough for the margins: the tolerance by the largest reach of a
    /// spiral, to a power of 2, so that many columns have the same.
    goal: f64,
    /// The ratios at its nodes, less 1, and their errors.
    values: [f64; MOST],
    errors: [f64; MOST],
    /// Number of nodes, and the number that it is to have next.
    count: usize,
    wanted: usize,
}

impl Growing {
    /// `None` if the column cannot be interpolated.
    fn new(axis: &Axis, column: &Column, first: usize, spirals: &[f64], goal: f64) -> Option<Self> {
        let reach = spirals.iter().copied().fold(1.0, f64::max);
        let goal = goal / reach.log2().round().exp2();
        let wanted = axis.nodes_for(column, SHARE_OF_POLYNOMIAL * goal)?;
        Some(Self { first, goal, values: [0.0; MOST], errors: [0.0; MOST], count: 0, wanted })
    }

    /// Takes the turns of the next nodes.
    fn grow(
        &mut self,
        axis: &Axis,
        spirals: &[f64],
        found: &mut impl Iterator<Item = Turn>,
        done: &mut Margins,
    ) -> Next {
        let mut complete = true;
        for (&cell, turn) in axis.order[self.count..self.wanted].iter().zip(found) {
            done.put(self.first + cell, turn);
            match turn {
                Turn::Complete { margin, error, .. } if error <= self.goal => {
                    let spiral = spirals[cell];
                    self.values[self.count] = (1.0 + margin - spiral) / spiral;
                    self.errors[self.count] = error / spiral + ROUNDING;
                    self.count += 1;
                }
                Turn::Complete { .. } | Turn::HandOver { .. } => complete = false,
            }
        }
        if !complete {
            return Next::OwnTurns { nodes: self.wanted };
        }
        let (fall, error) = self.surplus(axis);
        let enough = SHARE_OF_POLYNOMIAL * self.goal;
        if error <= enough {
            return Next::Interpolate { error };
        }
        // No more than will be needed.
        let mut more = 1;
        let mut expected = error * fall * fall;
        while fall < 1.0 && expected > enough && more < MOST {
            more += 1;
            expected *= fall;
        }
        self.wanted += more;
        if self.wanted <= axis.order.len() { Next::MoreNodes } else { Next::OwnTurns { nodes: self.count } }
    }

    /// The slowest fall of the surpluses, per node, over one node or two, as far as errors of the turns do
    /// not explain it; and the error of the polynomial, infinite if they do not fall. The first surplus, that
    /// of a constant, may be small where the others are not.
    fn surplus(&self, axis: &Axis) -> (f64, f64) {
        let (mut over_one, mut over_two) = (0.0_f64, 0.0_f64);
        let (mut before, mut last) = (f64::INFINITY, f64::INFINITY);
        for (node, weights) in axis.before[..self.count].iter().enumerate().skip(2) {
            let (mut surplus, mut noise) = (self.values[node], self.errors[node]);
            for ((weight, value), error) in weights.iter().zip(&self.values).zip(&self.errors) {
                surplus -= weight * value;
                noise += weight.abs() * error;
            }
            let surplus = surplus.abs();
            let unexplained = (surplus - noise).max(0.0);
            // NaN, of nothing from nothing, is no fall.
            over_one = over_one.max(unexplained / last);
            over_two = over_two.max(unexplained / before);
            (before, last) = (last, surplus);
        }
        let fall = over_one.max(over_two.sqrt());
        let error = last.max(fall * before) * (SAFETY * fall).min(1.0) * (fall / (1.0 - fall)).max(1.0);
        (fall, if fall < 1.0 { error } else { f64::INFINITY })
    }

    /// Fills the cells by the polynomial of this error, which is that of a turn at a node.
    fn fill(&self, axis: &Axis, spirals: &[f64], error: f64, done: &mut Margins) {
        let cells = self.first..self.first + spirals.len();
        let (margins, errors) = (&mut done.margins[cells.clone()], &mut done.errors[cells]);
        let nodes = self.values[..self.count].iter().zip(&self.errors);
        let weights = axis.weights(self.count).chunks_exact(spirals.len());
        pulp::Arch::new().dispatch(
            #[inline(always)]
            || {
                margins.fill(0.0);
                errors.fill(error);
                for ((value, error), weights) in nodes.zip(weights) {
                    for ((margin, noise), weight) in margins.iter_mut().zip(&mut *errors).zip(weights) {
                        *margin += weight * value;
                        *noise += weight.abs() * error;
                    }
                }
                for ((margin, error), spiral) in margins.iter_mut().zip(errors).zip(spirals) {
                    *margin = (spiral - 1.0) + spiral * *margin;
                    *error *= spiral;
                }
            },
        );
    }
}

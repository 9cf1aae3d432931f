//! Margins of the cells of a grid: the turns of a few cells, and a polynomial through them for the others.
//!
//! The margin m/V is analytic in c, in the belt speed and in the parameters of a law wherever the orbits
//! complete their turn and the law is analytic, and 1 + m/V is nearly that of a spiral, an orbit with the
//! constant divergence D(V) (theory, "Margins of a grid"). The polynomial interpolates their ratio, less 1.
//! Its nodes are cells of the grid, see `crates/orbits/src/lower_set.rs`.
//!
//! A box of columns whose polynomial needs too many nodes is cut into halves, down to single columns, as is
//! one in which an orbit does not complete its turn. Some further cells of each box get a turn: where one of
//! them contradicts the error, the box is cut, too.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::f64::consts::PI;
use std::ops::Range;
use std::rc::Rc;

use super::lower_set::{LowerSet, Side};
use super::return_map::{Turn, UNRESOLVED, turns_of_orbits};
use slipmap_model::friction::Column;
use slipmap_numbers::elementary::exp;
use slipmap_numbers::random::Random;
use slipmap_numbers::vectorized;

/// Largest size of the divergence of interpolated columns. It is half of that of a node, and small enough for
/// the margin to follow exp(-pi eps c): a surplus is small only where all are.
const NEAR: f64 = 1.0;
/// Shares of the tolerance for the turns at the nodes and for the polynomial.
const SHARE_OF_TURNS: f64 = 0.25;
const SHARE_OF_POLYNOMIAL: f64 = 0.5;
/// Factor from the errors of the turns at the nodes to those between them; the errors are independent.
const ENLARGED: f64 = 2.0;
/// Largest share of the cells of a box, and of a column, that may become nodes.
const MOST_NODES: f64 = 1.0 / 3.0;
const MOST_NODES_OF_COLUMN: f64 = 2.0 / 3.0;
/// How many times that number may be expected before the box is cut: early expectations are often too large.
const NODES_EXPECTED: f64 = 2.0;
/// Largest share of all cells that may be nodes of boxes of several columns that were cut.
const MOST_WASTED: f64 = 1.0 / 16.0;
/// Number of cells for each further one that is compared, and the largest number of these.
const CELLS_PER_COMPARED: usize = 64;
const MOST_COMPARED: usize = 8;
/// Number of nodes for each that is compared where that are more.
const NODES_PER_COMPARED: usize = 16;
/// Least error that is stated, in units of the goal: estimates far below it are by few surpluses.
const LEAST_CLAIMED: f64 = 0.01;
/// How much larger than the goal for ratios the errors of the mean weakening rate may be.
const MEAN_OFF: f64 = 3.0;
/// Ratio of the largest error in a box to the largest in the cells that are compared.
const LARGEST_PER_OBSERVED: f64 = 4.0;
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
    /// The margins of cells of which nothing is known.
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
/// `axes` are the values along each axis of the grid that the columns form, slowest first; their numbers
/// multiply to that of the columns. Without axes a column's margins do not depend on the other columns.
#[must_use]
pub fn margins(columns: &[Column], axes: &[Vec<f64>], cs: &[f64], tolerance: f64) -> Margins {
    if axes.is_empty() {
        let numbers = [(0..columns.len()).map(|number| number as f64).collect()];
        let each = (0..columns.len()).map(|number| std::iter::once(number..number + 1).collect());
        return Cells::new(columns, &numbers, cs, tolerance).margins(each.collect());
    }
    let whole = axes.iter().map(|values| 0..values.len()).collect();
    Cells::new(columns, axes, cs, tolerance).margins(vec![whole])
}

/// A range of columns along each axis.
type Ranges = Vec<Range<usize>>;

/// The cells whose margins are computed.
struct Cells<'a> {
    columns: &'a [Column],
    /// The values along each axis of columns.
    axes: &'a [Vec<f64>],
    cs: &'a [f64],
    tolerance: f64,
    /// 1 + m/V of the spiral of each cell.
    spirals: Vec<f64>,
    /// For each column whether it may be interpolated.
    is_smooth: Vec<bool>,
    /// For each column its mean weakening rate over the grazing circle, less that at belt speed; computed on
    /// first use.
    means: OnceCell<Vec<f64>>,
    /// The sides of boxes, by their axis and range; the axis after those of columns is c.
    sides: HashMap<(usize, Range<usize>), Option<Rc<Side>>>,
    /// The turns of the nodes of boxes that were cut.
    turns: HashMap<usize, Turn>,
    done: Margins,
}

impl<'a> Cells<'a> {
    fn new(columns: &'a [Column], axes: &'a [Vec<f64>], cs: &'a [f64], tolerance: f64) -> Self {
        let dampings = slipmap_numbers::Range::of(cs.iter().copied());
        let is_smooth = |column: &Column| {
            let is_near = |x: f64| {
                let weakening = column.curve.weakening(x * column.belt_speed);
                [dampings.lo, dampings.hi].iter().all(|c| (weakening - column.epsilon * c).abs() <= NEAR)
            };
            [0.0, 1.0, 2.0].into_iter().all(is_near) && column.curve.is_analytic(column.belt_speed)
        };
        Self {
            columns,
            axes,
            cs,
            tolerance,
            spirals: reach_of_spirals(columns, cs),
            is_smooth: columns.iter().map(is_smooth).collect(),
            means: OnceCell::new(),
            sides: HashMap::new(),
            turns: HashMap::new(),
            done: Margins::none(columns.len() * cs.len()),
        }
    }

    fn orbit(&self, cell: usize) -> (&'a Column, f64) {
        (&self.columns[cell / self.cs.len()], self.cs[cell % self.cs.len()])
    }

    /// The margins of all cells, by these boxes of columns.
    fn margins(mut self, mut boxes: Vec<Ranges>) -> Margins {
        let (mut growing, mut single): (Vec<Growing>, Vec<usize>) = (Vec::new(), Vec::new());
        loop {
            while let Some(ranges) = boxes.pop() {
                match Growing::new(&mut self, &ranges) {
                    Some(part) => growing.push(part),
                    None => self.cut(&ranges, &mut boxes, &mut single),
                }
            }
            if growing.is_empty() {
                break;
            }
            growing.sort_by(|a, b| a.tolerance.total_cmp(&b.tolerance));
            let mut turns = growing
                .chunk_by(|a, b| a.tolerance == b.tolerance)
                .flat_map(|alike| self.turns_of(alike))
                .collect::<Vec<_>>()
                .into_iter();
            growing.retain_mut(|part| {
                let next = part.take(&mut self, &mut turns);
                if matches!(next, Next::Cut) {
                    self.cut(&part.ranges, &mut boxes, &mut single);
                }
                matches!(next, Next::MoreTurns)
            });
        }
        let orbits = single.iter().map(|&cell| self.orbit(cell));
        let turns = turns_of_orbits(orbits, self.tolerance);
        for (&cell, turn) in single.iter().zip(turns) {
            self.done.put(cell, turn);
        }
        self.done
    }

    /// The turns of the cells that some boxes of one tolerance request next, box by box.
    fn turns_of(&mut self, alike: &[Growing]) -> Vec<Turn> {
        let wanted: Vec<usize> = alike.iter().flat_map(|part| part.wanted(self.cs.len())).collect();
        let new: Vec<usize> = wanted.iter().copied().filter(|cell| !self.turns.contains_key(cell)).collect();
        let found = turns_of_orbits(new.iter().map(|&cell| self.orbit(cell)), alike[0].tolerance);
        for (&cell, turn) in new.iter().zip(&found) {
            let (Turn::Complete { rhs, .. } | Turn::HandOver { rhs }) = turn;
            self.done.rhs[cell] += rhs;
        }
        if new.len() == wanted.len() {
            return found;
        }
        let mut found = found.into_iter();
        wanted.iter().filter_map(|cell| self.turns.get(cell).copied().or_else(|| found.next())).collect()
    }

    /// Cuts the longest side of a box into halves; the cells of single columns, and of columns that cannot be
    /// interpolated, get turns of their own.
    fn cut(&mut self, ranges: &Ranges, boxes: &mut Vec<Ranges>, single: &mut Vec<usize>) {
        let columns = self.columns_of(ranges);
        if columns.len() > 1 && columns.iter().any(|&column| self.is_smooth[column]) {
            let longest = (0..ranges.len()).max_by_key(|&axis| ranges[axis].len()).unwrap_or(0);
            let middle = ranges[longest].start + ranges[longest].len() / 2;
            for half in [ranges[longest].start..middle, middle..ranges[longest].end] {
                let mut part = ranges.clone();
                part[longest] = half;
                boxes.push(part);
            }
            return;
        }
        for cell in columns.iter().flat_map(|column| column * self.cs.len()..(column + 1) * self.cs.len()) {
            match self.turns.get(&cell) {
                Some(&Turn::Complete { margin, error, .. }) if error <= self.tolerance => {
                    (self.done.margins[cell], self.done.errors[cell]) = (margin, error);
                }
                _ => single.push(cell),
            }
        }
    }

    /// The numbers of the columns of a box, row-major.
    fn columns_of(&self, ranges: &Ranges) -> Vec<usize> {
        numbers_in(ranges, self.axes.iter().map(Vec::len))
    }

    /// A side of a box along an axis; `None` where it cannot be interpolated.
    fn side(&mut self, axis: usize, range: Range<usize>) -> Option<Rc<Side>> {
        let values = self.axes.get(axis).map_or(self.cs, Vec::as_slice);
        let new = || Side::new(&values[range.clone()]).map(Rc::new);
        self.sides.entry((axis, range.clone())).or_insert_with(new).clone()
    }
}

/// The numbers, row-major, of the columns in a box of a grid with these numbers of columns along its axes.
pub fn numbers_in(ranges: &[Range<usize>], lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    ranges.iter().zip(lengths).fold(vec![0], |numbers, (range, length)| {
        numbers.iter().flat_map(|start| range.clone().map(move |at| start * length + at)).collect()
    })
}

/// 1 + m/V of orbits along which the divergence is that at belt speed: exp(pi D / sqrt(1 - D^2/4)).
fn reach_of_spirals(columns: &[Column], cs: &[f64]) -> Vec<f64> {
    let mut cells = Vec::with_capacity(columns.len() * cs.len());
    for column in columns {
        let (weakening, epsilon) = (column.curve.weakening(column.belt_speed), column.epsilon);
        cells.extend(cs.iter().map(|c| weakening - epsilon * c));
    }
    vectorized(
        #[inline(always)]
        || {
            for cell in &mut cells {
                *cell = exp::<6>(PI * *cell / (1.0 - 0.25 * *cell * *cell).sqrt());
            }
        },
    );
    cells
}

/// The number of nodes that a column is expected to take: where exp(-pi eps c), times four variations of the
/// divergence along the orbit, has Chebyshev coefficients below `enough`.
fn nodes_along_c(column: &Column, cs: &[f64], enough: f64) -> f64 {
    let dampings = slipmap_numbers::Range::of(cs.iter().copied());
    let quarter = 0.25 * PI * (column.epsilon * dampings.hi - column.epsilon * dampings.lo);
    let weakening = [1.0, 0.0, 2.0].map(|x| column.curve.weakening(x * column.belt_speed));
    let variation = weakening.iter().fold(0.0, |most: f64, at| most.max((at - weakening[0]).abs()));
    let (mut coefficient, mut nodes) = (8.0 * variation, 1.0);
    while coefficient > enough && nodes <= cs.len() as f64 {
        coefficient *= quarter / nodes;
        nodes += 1.0;
    }
    nodes
}

/// The next step for a box, by its turns so far.
enum Next {
    MoreTurns,
    Finished,
    /// The box takes too many nodes, an orbit does not complete its turn, or one contradicts the error.
    Cut,
}

/// A box whose polynomial grows.
struct Growing {
    ranges: Ranges,
    /// The numbers of its columns, row-major.
    columns: Vec<usize>,
    set: LowerSet,
    /// Largest number of nodes.
    most: f64,
    /// Largest error of a ratio that is small enough for the margins: the tolerance divided by the largest
    /// reach of a spiral.
    goal: f64,
    /// The error stated for the ratios.
    stated: f64,
    /// The tolerance of turns: a power of 2, so that many boxes have the same.
    tolerance: f64,
    /// The turns of the nodes.
    turns: Vec<(usize, Turn)>,
    /// Largest error of a ratio at a node.
    node_error: f64,
    /// The cells that are compared once all cells are filled.
    compared: Vec<usize>,
}

impl Growing {
    /// `None` if the box cannot be interpolated.
    fn new(cells: &mut Cells, ranges: &Ranges) -> Option<Self> {
        let columns = cells.columns_of(ranges);
        let dampings = cells.cs.len();
        let is_wasteful = cells.turns.len() as f64 > MOST_WASTED * cells.spirals.len() as f64;
        if !columns.iter().all(|&column| cells.is_smooth[column]) || (columns.len() > 1 && is_wasteful) {
            return None;
        }
        let along_c = std::iter::once((ranges.len(), 0..dampings));
        let sides = ranges.iter().cloned().enumerate().chain(along_c).filter(|(_, range)| range.len() > 1);
        let sides: Vec<Rc<Side>> =
            sides.map(|(axis, range)| cells.side(axis, range)).collect::<Option<_>>()?;
        let share = if columns.len() > 1 { MOST_NODES } else { MOST_NODES_OF_COLUMN };
        let most = share * (columns.len() * dampings) as f64;
        if sides.is_empty() {
            return None;
        }
        let spirals = columns.iter().flat_map(|column| &cells.spirals[column * dampings..][..dampings]);
        let reach = spirals.copied().fold(1.0, f64::max);
        // Larger errors may leave a margin unresolved.
        let goal = cells.tolerance.min(UNRESOLVED) / reach;
        let tolerance = (SHARE_OF_TURNS * goal).log2().floor().exp2();
        if let [column] = columns[..]
            && nodes_along_c(&cells.columns[column], cells.cs, SHARE_OF_POLYNOMIAL * goal) > most
        {
            return None;
        }
        let set = LowerSet::new(sides);
        if set.nodes() as f64 > most {
            return None;
        }
        let ranges = ranges.clone();
        let (turns, compared) = (Vec::new(), Vec::new());
        Some(Self {
            ranges,
            columns,
            set,
            most,
            goal,
            stated: 0.0,
            tolerance,
            turns,
            node_error: 0.0,
            compared,
        })
    }

    /// The cells whose turns are requested next.
    fn wanted(&self, dampings: usize) -> Vec<usize> {
        match self.compared.is_empty() {
            true => self.set.wanted().map(|cell| self.cell(cell, dampings)).collect(),
            false => self.compared.clone(),
        }
    }

    /// The number of a cell of the box among all cells.
    fn cell(&self, cell: usize, dampings: usize) -> usize {
        self.columns[cell / dampings] * dampings + cell % dampings
    }

    /// Takes the turns of the requested cells.
    fn take(&mut self, cells: &mut Cells, turns: &mut impl Iterator<Item = Turn>) -> Next {
        let wanted = self.wanted(cells.cs.len());
        let taken = self.turns.len();
        self.turns.extend(wanted.into_iter().zip(turns));
        let next = match self.compared.is_empty() {
            true => self.take_nodes(cells, taken),
            false => self.compare(cells, taken),
        };
        if matches!(next, Next::Cut) {
            cells.turns.extend(self.turns.drain(..));
        }
        next
    }

    fn take_nodes(&mut self, cells: &mut Cells, taken: usize) -> Next {
        let mut values = Vec::with_capacity(self.turns.len() - taken);
        for &(cell, turn) in &self.turns[taken..] {
            let Turn::Complete { margin, error, .. } = turn else { return Next::Cut };
            let spiral = cells.spirals[cell];
            values.push((1.0 + margin - spiral) / spiral);
            self.node_error = self.node_error.max(error / spiral + ROUNDING);
        }
        let (of_polynomial, of_turns) = (self.set.take(values), ENLARGED * self.node_error);
        let enough = SHARE_OF_POLYNOMIAL * self.goal;
        if of_polynomial <= enough && of_turns <= self.goal - enough {
            // Twice the estimate where that is within the goal.
            let error = (2.0 * of_polynomial + of_turns).clamp(LEAST_CLAIMED * self.goal, self.goal);
            return if self.misses_feature(cells) { Next::Cut } else { self.fill(cells, error) };
        }
        if self.set.expected_nodes(enough) > NODES_EXPECTED * self.most {
            return Next::Cut;
        }
        self.set.grow(enough);
        let can_grow = self.set.wanted().next().is_some() && self.set.nodes() as f64 <= self.most;
        if can_grow { Next::MoreTurns } else { Next::Cut }
    }

    /// Returns whether the law has a feature that the nodes miss: whether the polynomial through the mean
    /// weakening rate at the nodes is off in a column by more than that rate may be for the goal. To first
    /// order the ratio is the exponential of pi times that rate.
    fn misses_feature(&self, cells: &Cells) -> bool {
        if self.columns.len() == 1 {
            return false;
        }
        let mean = |column: &Column| {
            let mean = column.curve.mean_weakening_of_many(column.belt_speed);
            mean - column.curve.weakening(column.belt_speed)
        };
        let means = cells.means.get_or_init(|| cells.columns.iter().map(mean).collect());
        let dampings = cells.cs.len();
        let at_nodes = self.turns.iter().map(|(cell, _)| means[cell / dampings]);
        let found = self.set.through(at_nodes);
        let allowed = MEAN_OFF * self.goal / PI;
        let mut columns = self.columns.iter().zip(found.chunks_exact(dampings));
        !columns.all(|(&column, found)| (found[0] - means[column]).abs() <= allowed)
    }

    /// Fills the cells by the polynomial, whose ratios have this error.
    fn fill(&mut self, cells: &mut Cells, error: f64) -> Next {
        self.stated = error;
        let dampings = cells.cs.len();
        let values = self.set.values();
        vectorized(
            #[inline(always)]
            || {
                for (column, ratios) in self.columns.iter().zip(values.chunks_exact(dampings)) {
                    let cells_of = column * dampings..(column + 1) * dampings;
                    let spirals = &cells.spirals[cells_of.clone()];
                    let margins = &mut cells.done.margins[cells_of.clone()];
                    let errors = &mut cells.done.errors[cells_of];
                    for (((margin, own), spiral), ratio) in
                        margins.iter_mut().zip(errors).zip(spirals).zip(ratios)
                    {
                        *margin = (spiral - 1.0) + spiral * ratio;
                        *own = error * spiral;
                    }
                }
            },
        );
        if self.columns.len() == 1 {
            return Next::Finished;
        }
        let all = values.len();
        let mut random = Random(all as u64);
        let most = MOST_COMPARED.max(self.turns.len() / NODES_PER_COMPARED);
        let count = (all / CELLS_PER_COMPARED).clamp(1, most);
        let compared = (0..count).map(|_| (random.unit() * all as f64) as usize);
        self.compared = compared.map(|cell| self.cell(cell, dampings)).collect();
        Next::MoreTurns
    }

    /// Compares some cells with their turns.
    fn compare(&self, cells: &mut Cells, taken: usize) -> Next {
        let mut observed: f64 = 0.0;
        for &(cell, turn) in &self.turns[taken..] {
            let Turn::Complete { margin, error, .. } = turn else { return Next::Cut };
            let (off, stated) = ((margin - cells.done.margins[cell]).abs(), cells.done.errors[cell]);
            if off > stated + error {
                return Next::Cut;
            }
            observed = observed.max(off / stated);
        }
        let factor = LARGEST_PER_OBSERVED * observed;
        if factor > 1.0 {
            if factor * self.stated > self.goal {
                return Next::Cut;
            }
            let dampings = cells.cs.len();
            for column in &self.columns {
                let errors = &mut cells.done.errors[column * dampings..][..dampings];
                errors.iter_mut().for_each(|error| *error *= factor);
            }
        }
        for &(cell, turn) in &self.turns[taken..] {
            if let Turn::Complete { margin, error, .. } = turn {
                (cells.done.margins[cell], cells.done.errors[cell]) = (margin, error);
            }
        }
        Next::Finished
    }
}

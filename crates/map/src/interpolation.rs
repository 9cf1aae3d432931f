//! Answers for all columns of a tile, interpolated from a few of them.
//!
//! C(r), the damping at which the orbit of amplitude r closes, is as smooth in the law's parameters and the
//! belt speed as the law is. On a box of columns it is interpolated by products of Chebyshev polynomials in
//! the parameters, through node columns that are computed without interpolation. C(V) is eps c*; the values
//! of C at the nodes in r of a backbone, as few as suffice, give the number of slip cycles. The square of the
//! [`reach`] at the least damping is interpolated too, for two orbits. The first starts at the exit point and
//! sticks where its reach is less than 4. The second starts so far beyond the exit point that all farther
//! loops lead inward in every column; where it sticks, no loop inside it crosses the belt line for ever.
//!
//! **Error.** For each axis, twice the sum of the moduli of the last two coefficients, the largest over the
//! box; and the errors of the values at the nodes. The sum is multiplied by the Lebesgue constants of the
//! axes. Two further columns of each box are computed and compared: if one of them contradicts the error, the
//! interpolant is rejected. Like the error of the backbone, this is an estimate and no bound. Cells within
//! three errors of a boundary stay undecided here, and are decided from their own column.
//!
//! A law may have features that are narrower than the distance of the nodes: an outlier of a table, which
//! orbits reach from some belt speed on, or a step of a formula in its parameters. C(V) is the mean of the
//! weakening rate over the grazing circle to first order. So that mean is interpolated, too, and compared in
//! every column: a box in which it differs has no answer, and smaller differences add to the error. A law that
//! is [narrow](slipmap_model::friction::Weakening) within reach of the mean has no answer either.
//!
//! A box in which too many cells stay undecided gets more nodes along the axis with the largest error, and is
//! then cut there, as long as it has several times more columns than nodes.

use std::cell::OnceCell;
use std::collections::HashMap;
use std::ops::Range;

use super::grid::Extent;
use super::{Field, Grid, Plan, Tile};
use slipmap_column::backbone::{BackboneNodes, COARSE, InterpolatedBackbone};
use slipmap_column::crossing::reach;
use slipmap_column::{End, critical_damping};
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Column;
use slipmap_numbers::chebyshev::{self, Transform};
use slipmap_numbers::random::Random;
use slipmap_orbits::far_loops::FarLoops;

/// Tolerance of eps c* where no backbone is needed, in units of the weakening rate, and of the [`reach`].
const TOLERANCE: f64 = 1e-6;
/// Least number of values along an axis for interpolation, and for interpolation of the higher degree.
const FEWEST_VALUES: [usize; 2] = [8, 18];
/// The lower and the higher degree of the polynomials.
const SIZES: [usize; 2] = [4, 8];
/// Least ratio of the number of columns to the number of nodes, in a box and in the tile.
const COLUMNS_PER_NODE: usize = 3;
/// A finer interpolant is tried if there are fewer nodes than this for each undecided cell.
const NODES_PER_OPEN: usize = 2;
/// Number of further columns of a box that are computed and compared with the interpolant.
const COMPARED: usize = 2;
/// Largest distance of the mean weakening rate from its interpolant, in units of its error or that of C.
const MEAN_OFF: f64 = 3.0;
/// Landing speed below which an orbit sticks; laws with a drop are not interpolated.
const STICKS: f64 = 2.0;
/// Square of the reach from which on an orbit does not stick.
const CROSSES: f64 = 4.0 * STICKS * STICKS;
/// Largest number of columns of a box, evenly spread, whose undecided cells are counted.
const COUNTED: usize = 256;
/// Distance from a boundary, in errors, within which a cell is undecided.
const OPEN_WITHIN: f64 = 3.0;

/// The numbers, row-major, of the columns in a box of a grid with these numbers of columns along its axes.
fn numbers_in(ranges: &[Range<usize>], lengths: impl Iterator<Item = usize>) -> Vec<usize> {
    ranges.iter().zip(lengths).fold(vec![0], |numbers, (range, length)| {
        numbers.iter().flat_map(|start| range.clone().map(move |at| start * length + at)).collect()
    })
}

/// The errors of a column's values, infinite where they are unknown.
#[derive(Clone, Copy)]
struct Errors {
    /// Of C at its amplitudes, and between them.
    c: f64,
    between: f64,
    /// Of the squared reach of the orbit from the exit point, and of the farther one.
    near: f64,
    far: f64,
}

/// The values of a column, in the order in which they are stored.
struct Values<'a> {
    /// C at its amplitudes, from r = V down.
    c: &'a [f64],
    /// The squared reach of the orbit from the exit point, and of the farther one.
    near: f64,
    far: f64,
    /// The mean of the weakening rate.
    mean: f64,
}

impl<'a> Values<'a> {
    /// Number of values beside those of C.
    const BESIDE_C: usize = 3;

    /// Reads what is stored of a column: at least the values beside those of C.
    fn of(stored: &'a [f64]) -> Self {
        let (c, beside) = stored.split_at(stored.len() - Self::BESIDE_C);
        Self { c, near: beside[0], far: beside[1], mean: beside[2] }
    }
}

/// The interpolated answers for the columns of a tile.
pub(super) struct Interpolated {
    /// Number of stored values of a column.
    stride: usize,
    values: Vec<f64>,
    /// The errors of each column.
    errors: Vec<Errors>,
    /// The nodes of the backbones; `None` where C is interpolated at r = V alone.
    nodes: Option<BackboneNodes>,
    /// The least damping, at which the reach is computed.
    least: f64,
    /// The distance beyond the exit point from which on loops lead inward, in every column; infinite where
    /// this distance is unknown.
    settled_from: f64,
    /// Number of evaluations of the right-hand side.
    pub(super) rhs: u64,
}

impl Interpolated {
    /// No answers.
    pub(super) fn none() -> Self {
        let (least, settled_from) = (f64::NEG_INFINITY, f64::INFINITY);
        Self { stride: 0, values: Vec::new(), errors: Vec::new(), nodes: None, least, settled_from, rhs: 0 }
    }

    /// Interpolates the answers for the columns of a tile, where that costs less than computing every column.
    pub(super) fn of_tile(plan: &Plan, tile: &Tile, columns: &[Column]) -> Self {
        let mut found = Self::none();
        let Some(first) = columns.first().filter(|_| plan.interpolates()) else { return found };
        let cs = &plan.grid.dampings()[tile.damping_range()];
        let mut intervals = 0;
        if plan.interpolates_backbones(first) {
            let samples = [columns.len() / 2, 0, columns.len() - 1];
            let needed =
                samples.into_iter().map(|at| InterpolatedBackbone::intervals(&columns[at], COARSE).ok()?);
            // Without backbones the critical damping alone may still be interpolated.
            intervals = needed.collect::<Option<Vec<_>>>().into_iter().flatten().max().unwrap_or(0);
            if intervals == 0 && plan.stores(Field::CriticalC) {
                return found;
            }
            found.nodes = (intervals > 0).then(|| BackboneNodes::new(intervals));
        }
        // This distance grows with the belt speed, except for a table that ends early and for friction that is left
        // out where it pushes, and falls with the damping.
        if plan.stores(Field::Regime) && first.curve.fastest() == f64::INFINITY {
            let farthest = |group: &[Column]| {
                let fastest = group.iter().map(|column| column.belt_speed).fold(0.0, f64::max);
                let least = group.iter().map(|column| column.epsilon * cs[0]).fold(f64::INFINITY, f64::min);
                let far = FarLoops::where_friction_resists(&group[0].curve, fastest);
                if far.is_cut_short() { f64::INFINITY } else { far.inward_from(least) }
            };
            let groups = columns.chunk_by(|one, other| one.curve == other.curve);
            found.settled_from = groups.map(farthest).fold(0.0, f64::max);
        }
        found.least = cs[0];
        found.stride = intervals + 1 + Values::BESIDE_C;
        found.values = vec![f64::NAN; found.stride * columns.len()];
        let unknown = f64::INFINITY;
        found.errors =
            vec![Errors { c: unknown, between: unknown, near: unknown, far: unknown }; columns.len()];
        let shape = tile.shape();
        let (shape, means) = (&shape[..shape.len() - 1], OnceCell::new());
        let columns = TileColumns { grid: &plan.grid, tile, columns, cs, intervals, shape, means };
        columns.interpolate_all(&mut found);
        found
    }

    /// The values of a column and their errors; `None` where they are unknown.
    fn of(&self, number: usize) -> Option<(Values<'_>, &Errors)> {
        let errors = self.errors.get(number).filter(|errors| errors.c.is_finite())?;
        Some((Values::of(&self.values[number * self.stride..][..self.stride]), errors))
    }

    /// The end of the orbit from the exit point at damping `c` of a column; `None` where it is undecided.
    pub(super) fn end(&self, number: usize, column: &Column, c: f64) -> Option<End> {
        let (values, errors) = self.of(number)?;
        let end = end(&values, errors, column.epsilon * c)?;
        // At a larger damping an orbit that crosses may stick.
        (end != End::Crosses || c <= self.least).then_some(end)
    }

    /// The backbone of an interpolated column; `None` where it is unknown.
    pub(super) fn backbone(&self, number: usize, column: &Column) -> Option<InterpolatedBackbone<'_>> {
        let (values, errors) = self.of(number)?;
        let error = errors.c.max(errors.between);
        Some(InterpolatedBackbone::new(self.nodes.as_ref()?, column.belt_speed, values.c, error))
    }

    /// Whether it is known that, at all dampings of the tile, no orbit of a column crosses the belt line for
    /// ever, except perhaps the orbit from the exit point.
    pub(super) fn no_other_crosses(&self, number: usize) -> bool {
        let sticks = |(values, errors): (Values, &Errors)| values.far + OPEN_WITHIN * errors.far < CROSSES;
        self.settled_from == 0.0 || self.of(number).is_some_and(sticks)
    }
}

fn end(values: &Values, errors: &Errors, viscous: f64) -> Option<End> {
    let critical = values.c[0];
    if (critical - viscous).abs() <= OPEN_WITHIN * errors.c {
        None
    } else if viscous > critical {
        Some(End::Inward)
    } else if values.near + OPEN_WITHIN * errors.near < CROSSES {
        Some(End::Sticks)
    } else {
        (values.near - OPEN_WITHIN * errors.near > CROSSES).then_some(End::Crosses)
    }
}

/// The columns of a tile, and the values to be interpolated between them.
struct TileColumns<'a> {
    grid: &'a Grid,
    tile: &'a Tile,
    columns: &'a [Column],
    cs: &'a [f64],
    /// Number of intervals between the nodes of backbones; 0 for the critical damping alone.
    intervals: usize,
    /// Number of columns along each axis.
    shape: &'a [usize],
    /// The mean weakening rate of every column, computed on first use.
    means: OnceCell<Vec<f64>>,
}

/// A computed column: its values, and the errors of C at its amplitudes and between them.
type Node = Option<(Vec<f64>, [f64; 2])>;

/// A range of columns along one axis, and the nodes there.
struct Side {
    /// Coordinates of the nodes.
    nodes: Vec<f64>,
    /// For each column the interpolation weights of the nodes.
    weights: Vec<Vec<f64>>,
    /// Whether every column is a node.
    is_exact: bool,
}

impl Side {
    fn new(values: &[f64], is_logarithmic: bool, size: usize) -> Self {
        if values.len() < FEWEST_VALUES[0] {
            let unit = |at: usize| (0..values.len()).map(|i| if i == at { 1.0 } else { 0.0 }).collect();
            let weights = (0..values.len()).map(unit).collect();
            return Self { nodes: values.to_vec(), weights, is_exact: true };
        }
        let extent = Extent { from: values[0], to: values[values.len() - 1], logarithmic: is_logarithmic };
        let node = |i: usize| extent.value(0.5 * (1.0 + chebyshev::node(i, size)));
        let weights = |value: &f64| chebyshev::weights(size, 2.0 * extent.share(*value) - 1.0);
        Self {
            nodes: (0..=size).map(node).collect(),
            weights: values.iter().map(weights).collect(),
            is_exact: false,
        }
    }
}

/// The cells that an interpolant leaves undecided.
struct Open {
    /// Number of undecided cells that a finer interpolant may decide.
    cells: usize,
    /// Whether a compared column contradicts the error.
    is_refuted: bool,
}

impl TileColumns<'_> {
    /// Interpolates box by box.
    fn interpolate_all(&self, found: &mut Interpolated) {
        let mut known = HashMap::new();
        let mut boxes: Vec<Vec<Range<usize>>> = vec![self.shape.iter().map(|&length| 0..length).collect()];
        while let Some(part) = boxes.pop() {
            let mut sizes = vec![SIZES[0]; part.len()];
            // Adds nodes, or cuts the box, as long as that may decide more cells.
            while let Some(worst) = self.interpolate(&part, &sizes, &mut known, found) {
                let length = part[worst].len();
                if sizes[worst] == SIZES[0] && length >= FEWEST_VALUES[1] {
                    sizes[worst] = SIZES[1];
                    continue;
                }
                if length >= 2 * FEWEST_VALUES[0] {
                    let middle = part[worst].start + length / 2;
                    for half in [part[worst].start..middle, middle..part[worst].end] {
                        let mut cut = part.clone();
                        cut[worst] = half;
                        boxes.push(cut);
                    }
                }
                break;
            }
        }
    }

    /// Interpolates a box. Returns the axis along which more nodes may decide more cells, if any.
    fn interpolate(
        &self,
        part: &[Range<usize>],
        sizes: &[usize],
        known: &mut HashMap<Vec<u64>, Node>,
        found: &mut Interpolated,
    ) -> Option<usize> {
        let axes = self.grid.axes();
        let sides: Vec<Side> = (part.iter().zip(sizes).zip(&self.tile.ranges).zip(axes))
            .map(|(((range, &size), tile), axis)| {
                let values = &axis.values[tile.start + range.start..tile.start + range.end];
                Side::new(values, axis.is_logarithmic(), size)
            })
            .collect();
        let longest =
            (0..part.len()).filter(|&axis| !sides[axis].is_exact).max_by_key(|&axis| part[axis].len())?;
        let columns: usize = part.iter().map(ExactSizeIterator::len).product();
        let nodes: usize = sides.iter().map(|side| side.nodes.len()).product();
        let worthwhile = |nodes: usize, columns: usize| COLUMNS_PER_NODE * nodes <= columns;
        if !worthwhile(nodes, columns) || !worthwhile(known.len() + nodes, self.columns.len()) {
            return None;
        }
        let stride = found.stride;
        let mut values = Vec::with_capacity(nodes * stride);
        let (mut node_error, mut between): (f64, f64) = (0.0, 0.0);
        let shape: Vec<usize> = sides.iter().map(|side| side.nodes.len()).collect();
        for number in 0..nodes {
            let place = super::unravel(number, &shape);
            let coordinates: Vec<f64> = sides.iter().zip(place).map(|(side, i)| side.nodes[i]).collect();
            let key = coordinates.iter().map(|value| value.to_bits()).collect();
            let node = known.entry(key).or_insert_with(|| self.node(&coordinates, found));
            let Some((node, [error, hidden])) = node else { return Some(longest) };
            values.extend_from_slice(node);
            (node_error, between) = (node_error.max(*error), between.max(*hidden));
        }
        let (values, [errors, least], worst) = spread(&sides, values, stride, node_error);
        let ([of_c, near, far, of_mean], [least @ .., _]) = (errors, least);
        let mut errors = Errors { c: of_c.max(of_mean), between, near, far };
        let numbers = numbers_in(part, self.shape.iter().copied());
        let means: Vec<f64> = numbers.iter().map(|&number| self.means()[number]).collect();
        let pairs = means.iter().zip(values.chunks(stride).map(Values::of));
        let off = pairs.map(|(mean, values)| (mean - values.mean).abs());
        // A distance that is NaN is the largest.
        let off = off.fold(0.0, |most, off| if off <= most { most } else { off });
        if !(off <= MEAN_OFF * errors.c) {
            let roughest = axis_of_feature(part, &means);
            return Some(if sides[roughest].is_exact { longest } else { roughest });
        }
        errors.c = errors.c.max(off);
        let Open { cells, is_refuted } = self.compare(&numbers, &values, &mut errors, &least, found);
        if is_refuted {
            return Some(longest);
        }
        for (column, values) in numbers.iter().zip(values.chunks(stride)) {
            found.values[column * stride..][..stride].copy_from_slice(values);
            found.errors[*column] = errors;
        }
        (NODES_PER_OPEN * cells > nodes).then_some(worst)
    }

    /// Computes the column at these coordinates.
    fn node(&self, coordinates: &[f64], found: &mut Interpolated) -> Node {
        let mut coordinates = coordinates.to_vec();
        coordinates.push(self.cs[0]);
        self.values_of(&self.grid.column_of(&coordinates).ok()?, found)
    }

    fn values_of(&self, column: &Column, found: &mut Interpolated) -> Node {
        if column.curve.is_narrow_below(2.0 * column.belt_speed) {
            return None;
        }
        let (mut values, errors) = if self.intervals > 0 {
            let (values, errors, spent) = InterpolatedBackbone::values(column, COARSE, self.intervals)?;
            found.rhs += spent;
            (values, errors)
        } else {
            let critical = critical_damping(column, TOLERANCE).ok()?;
            found.rhs += critical.rhs;
            (vec![column.epsilon * critical.c], [column.epsilon * critical.error, 0.0])
        };
        let oscillator = Oscillator::in_column(column, found.least);
        for from in [0.0, found.settled_from] {
            let reach = if from.is_finite() { reach(&oscillator, from, TOLERANCE).ok() } else { None };
            values.push(reach.map_or(f64::INFINITY, |reach| reach * reach));
        }
        values.push(mean(column));
        Some((values, errors))
    }

    /// The mean weakening rate of every column. Columns that differ in eps alone share it, unless the law
    /// contains eps.
    fn means(&self) -> &[f64] {
        self.means.get_or_init(|| {
            let shares = if self.grid.shares_laws() { self.shape[0] } else { 1 };
            let own = &self.columns[..self.columns.len() / shares];
            own.iter().map(mean).collect::<Vec<_>>().repeat(shares)
        })
    }

    /// Counts the cells left undecided, and tests whether columns computed for comparison refute the error.
    fn compare(
        &self,
        numbers: &[usize],
        values: &[f64],
        errors: &mut Errors,
        &[least_c, least_near, least_far]: &[f64; 3],
        found: &mut Interpolated,
    ) -> Open {
        let stride = found.stride;
        if !errors.c.is_finite() {
            return Open { cells: 0, is_refuted: true };
        }
        let mut random = Random(numbers[0] as u64 ^ ((numbers.len() as u64) << 32));
        let refutes = |_| {
            let place = (random.unit() * numbers.len() as f64) as usize;
            let interpolated = Values::of(&values[place * stride..][..stride]);
            let Some((exact, [error, _])) = self.values_of(&self.columns[numbers[place]], found) else {
                return true;
            };
            let exact = Values::of(&exact);
            let differs = |one: f64, other: f64, error: f64| (one - other).abs() > error && error.is_finite();
            if differs(exact.far, interpolated.far, errors.far) {
                errors.far = f64::INFINITY;
            }
            let mut of_c = exact.c.iter().zip(interpolated.c);
            of_c.any(|(one, other)| differs(*one, *other, errors.c + error))
                || differs(exact.near, interpolated.near, errors.near)
        };
        if (0..COMPARED).any(refutes) {
            return Open { cells: 0, is_refuted: true };
        }
        // A finer interpolant's error is taken as a hundredth of this one's, and at least that of the nodes.
        let finer = Errors {
            c: least_c.max(0.01 * errors.c),
            near: least_near.max(0.01 * errors.near),
            far: least_far.max(0.01 * errors.far),
            ..*errors
        };
        let mut cells = 0;
        // An odd step, so that the samples do not all have the same position in their rows.
        let each = numbers.len().div_ceil(COUNTED) | 1;
        for (&number, values) in numbers.iter().zip(values.chunks(stride)).step_by(each) {
            let column = &self.columns[number];
            let values = Values::of(values);
            let backbones = found.nodes.as_ref().map(|nodes| {
                let at_belt_speed = column.curve.weakening(column.belt_speed);
                let backbone = |error: f64| {
                    let error = error.max(errors.between);
                    InterpolatedBackbone::new(nodes, column.belt_speed, values.c, error)
                };
                ([backbone(errors.c), backbone(finer.c)], at_belt_speed)
            });
            for c in self.cs {
                let viscous = column.epsilon * c;
                let Some(fine) = end(&values, &finer, viscous) else { continue };
                let open = match (&backbones, end(&values, errors, viscous)) {
                    (_, None) => true,
                    (None, Some(_)) => false,
                    (Some(([now, finer], at_belt_speed)), Some(end)) => {
                        let is_decided = |backbone: &InterpolatedBackbone, end: End| {
                            let returns = end.returns();
                            returns
                                .and_then(|it| backbone.attracts(viscous, *at_belt_speed < viscous, it))
                                .is_some()
                        };
                        !is_decided(now, end) && is_decided(finer, fine)
                    }
                };
                cells += each * usize::from(open);
            }
        }
        Open { cells, is_refuted: false }
    }
}

/// The mean weakening rate of a column over the grazing circle.
fn mean(column: &Column) -> f64 {
    column.curve.mean_weakening_of_many(column.belt_speed)
}

/// The axis along which the values of the columns of a box bend most.
fn axis_of_feature(part: &[Range<usize>], values: &[f64]) -> usize {
    let bend = |axis: usize| {
        let after: usize = part[axis + 1..].iter().map(ExactSizeIterator::len).product();
        let length = part[axis].len();
        let inner = (0..values.len()).filter(|at| (1..length - 1).contains(&(at / after % length)));
        let bends = inner.map(|at| (values[at - after] - 2.0 * values[at] + values[at + after]).abs());
        bends.fold(0.0, f64::max) * (length as f64).powi(2)
    };
    (0..part.len()).max_by(|&one, &other| bend(one).total_cmp(&bend(other))).unwrap_or(0)
}

/// Returns the interpolant at all columns of a box, its errors of C, of both squares and of the mean, the part of
/// them due to the errors of the nodes, and the axis that contributes most to the errors.
fn spread(
    sides: &[Side],
    values: Vec<f64>,
    stride: usize,
    node_error: f64,
) -> (Vec<f64>, [[f64; 4]; 2], usize) {
    let factors =
        sides.iter().map(|side| if side.is_exact { 1.0 } else { chebyshev::lebesgue(side.nodes.len() - 1) });
    let factor: f64 = factors.product();
    let least = [node_error, TOLERANCE * STICKS * STICKS, TOLERANCE * STICKS * STICKS, 0.0];
    let mut errors = least;
    let mut along = vec![[0.0; 4]; sides.len()];
    let mut after = stride;
    for (tails, side) in along.iter_mut().zip(sides).rev() {
        if !side.is_exact {
            *tails = self::tails(&values, side.nodes.len(), after, stride);
            errors.iter_mut().zip(tails).for_each(|(error, tail)| *error += *tail);
        }
        after *= side.nodes.len();
    }
    // Each axis's share of the errors of C and of the first reach, which leave cells undecided.
    let share =
        |tails: &[f64; 4]| (0..2).map(|kind| tails[kind] / errors[kind]).filter(|it| it.is_finite()).sum();
    let shares: Vec<f64> = along.iter().map(share).collect();
    let worst = (0..sides.len())
        .filter(|&axis| !sides[axis].is_exact)
        .max_by(|&a, &b| shares[a].total_cmp(&shares[b]));
    let worst = worst.unwrap_or(0);
    let mut values = values;
    let mut after = stride;
    for side in sides.iter().rev() {
        let count = side.nodes.len();
        if !side.is_exact {
            let mut spread = Vec::with_capacity(values.len() / count * side.weights.len());
            for block in values.chunks(count * after) {
                for weights in &side.weights {
                    let start = spread.len();
                    spread.resize(start + after, 0.0);
                    let sum = &mut spread[start..];
                    for (weight, row) in weights.iter().zip(block.chunks(after)) {
                        sum.iter_mut().zip(row).for_each(|(sum, value)| *sum += weight * value);
                    }
                }
            }
            values = spread;
        }
        after *= side.weights.len();
    }
    (values, [errors, least].map(|errors| errors.map(|error| factor * error)), worst)
}

/// The largest tails of the series along an axis of `count` nodes, whose values are `after` numbers apart: of
/// C, of the two squares, and of the mean; the last three of each `stride` numbers are no values of C.
fn tails(values: &[f64], count: usize, after: usize, stride: usize) -> [f64; 4] {
    let transform = Transform::new(count - 1);
    let mut tails = [0.0_f64; 4];
    let mut line = vec![0.0; count];
    for block in values.chunks(count * after) {
        for first in 0..after {
            line.iter_mut().zip(block[first..].iter().step_by(after)).for_each(|(to, from)| *to = *from);
            let tail = 2.0 * transform.coefficients(&line).skip(count - 2).map(f64::abs).sum::<f64>();
            let largest = &mut tails[(first % stride + 1 + Values::BESIDE_C).saturating_sub(stride)];
            // A tail that is NaN replaces the largest.
            *largest = if tail <= *largest { *largest } else { tail };
        }
    }
    tails
}

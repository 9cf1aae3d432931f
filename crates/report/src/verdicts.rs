//! Statistics of the verdicts of a map, gathered in one pass: the cells and the volume that each method
//! claims, and its agreement with the simulation.

use std::ops::Range;

use ndarray::{ArrayD, ArrayViewD, Axis as Dim, Slice};

use super::{ReportError, SIMULATION, check};
use slipmap_column::Verdict;
use slipmap_format::MapFile;
use slipmap_map::{AxisRole, Control, Grid, Tile};

/// Numbers of cells by pairs of verdicts, the simulation's and a method's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Confusion {
    /// `cells[simulation][method]`, both in the order of [`Verdict::ALL`]. Without a simulation in the map
    /// all cells count as not simulated.
    pub(crate) cells: [[u64; 5]; 5],
}

impl Confusion {
    /// Number of cells with the given verdicts.
    pub(crate) fn pair(&self, simulation: Verdict, method: Verdict) -> u64 {
        self.cells[place(simulation.code())][place(method.code())]
    }

    /// Number of cells on which the method's verdict is `verdict`.
    pub(crate) fn method(&self, verdict: Verdict) -> u64 {
        self.cells.iter().map(|row| row[place(verdict.code())]).sum()
    }

    /// Number of cells about which the method claims anything.
    pub(crate) fn claims(&self) -> u64 {
        self.method(Verdict::Present) + self.method(Verdict::Absent)
    }

    /// Number of cells on which the simulation's verdict is `verdict`.
    pub(crate) fn simulation(&self, verdict: Verdict) -> u64 {
        self.cells[place(verdict.code())].iter().sum()
    }

    pub(crate) fn total(&self) -> u64 {
        self.cells.iter().flatten().sum()
    }

    /// Adds the cells of another part of the map.
    pub(crate) fn add(&mut self, other: &Confusion) {
        for (sum, more) in self.cells.iter_mut().flatten().zip(other.cells.iter().flatten()) {
            *sum += more;
        }
    }
}

/// Position of the verdict with this code in [`Verdict::ALL`].
fn place(code: i8) -> usize {
    usize::from(code.wrapping_sub(Verdict::Absent.code()).unsigned_abs()).min(4)
}

/// The volume of parameter space on which a method claims presence, at one eps.
///
/// The volume extends over the axes of more than one node except eps. By the trapezoidal rule, a box between
/// neighbouring nodes is weighted with the share of its corners at which presence is claimed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Volume {
    pub claimed: f64,
    /// Bound of its error along c, with the nodes of the other axes fixed: half of every step of c over which
    /// the verdict changes.
    pub error_in_c: f64,
    /// Bound of its error along all axes: the boxes whose corners disagree, each with the larger of the
    /// shares of its corners with and without the claim. Valid if no box whose corners all agree contains a
    /// piece of the boundary. Large where an axis has few nodes.
    pub error: f64,
    /// Volume on which the simulation finds the cycle too.
    pub(crate) confirmed: f64,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Verdicts {
    /// Position of the simulation among the methods of the map.
    pub(crate) simulation: Option<usize>,
    /// `confusion[method][epsilon]`.
    pub(crate) confusion: Vec<Vec<Confusion>>,
    /// Number of cells that one rigorous test at least decides.
    pub(crate) proved: u64,
    /// `volumes[method][epsilon]`.
    pub volumes: Vec<Vec<Volume>>,
    /// Volume of the whole box of the axes.
    pub box_volume: f64,
    /// Number of axes over which the volume extends.
    pub dimensions: usize,
}

impl Verdicts {
    /// Reads every verdict of `map` once, tile by tile; boxes that extend into the next tile read its first
    /// nodes again.
    pub(super) fn read(map: &MapFile, control: &Control) -> Result<Self, ReportError> {
        let axes = map.grid().axes();
        let epsilons = map.grid().epsilons().len();
        let methods = map.methods();
        let simulation = methods.iter().position(|method| method.name() == SIMULATION);
        let extents = axes.iter().filter(|axis| axis.role != AxisRole::Epsilon && axis.values.len() > 1);
        let mut verdicts = Self {
            simulation,
            proved: 0,
            confusion: vec![vec![Confusion::default(); epsilons]; methods.len()],
            volumes: vec![vec![Volume::default(); epsilons]; methods.len()],
            box_volume: extents
                .clone()
                .map(|axis| axis.values[axis.values.len() - 1] - axis.values[0])
                .product(),
            dimensions: extents.count(),
        };
        for tile in map.tiles() {
            check(control)?;
            verdicts.add_tile(map, &tile)?;
            (control.on_cells)(tile.cells());
        }
        Ok(verdicts)
    }

    fn add_tile(&mut self, map: &MapFile, tile: &Tile) -> Result<(), ReportError> {
        let boxes = Boxes::of(map, tile);
        let read =
            |method: usize| map.codes(&format!("verdict_{}", map.methods()[method].name()), &boxes.nodes);
        let simulated = self.simulation.map(read).transpose()?;
        // Without an axis of eps there is one layer.
        let layers = map.grid().epsilon_axis().map_or(0..1, |axis| tile.ranges[axis].clone());
        let mut proved = vec![false; tile.cells()];
        let per_layer = tile.cells() / layers.len().max(1);
        for method in 0..map.methods().len() {
            let own;
            let codes = match (&simulated, self.simulation == Some(method)) {
                (Some(simulated), true) => simulated,
                _ => {
                    own = read(method)?;
                    &own
                }
            };
            for (layer, epsilon) in layers.clone().enumerate() {
                let codes = layer_of(map.grid(), codes, layer);
                let simulated = simulated.as_ref().map(|codes| layer_of(map.grid(), codes, layer));
                let reference = simulated.as_ref().map(|codes| boxes.cells_only(codes));
                let cells = boxes.cells_only(&codes);
                let found = confusion(&cells, reference.as_ref());
                if map.methods()[method].guarantee().is_rigorous() {
                    for (proved, code) in proved[layer * per_layer..].iter_mut().zip(&cells) {
                        *proved |= [Verdict::Absent.code(), Verdict::Present.code()].contains(code);
                    }
                }
                self.confusion[method][epsilon].add(&found);
                let volume = boxes.volume(&codes, simulated.as_ref());
                let sum = &mut self.volumes[method][epsilon];
                sum.claimed += volume.claimed;
                sum.error_in_c += volume.error_in_c;
                sum.error += volume.error;
                sum.confirmed += volume.confirmed;
            }
        }
        self.proved += proved.into_iter().map(u64::from).sum::<u64>();
        Ok(())
    }
}

/// The codes at one eps; all of them for a machine.
fn layer_of<'a>(grid: &Grid, codes: &'a ArrayD<i8>, layer: usize) -> ArrayViewD<'a, i8> {
    match grid.epsilon_axis() {
        Some(axis) => codes.index_axis(Dim(axis), layer),
        None => codes.view(),
    }
}

fn confusion(codes: &ArrayViewD<i8>, simulated: Option<&ArrayViewD<i8>>) -> Confusion {
    let mut confusion = Confusion::default();
    let mut simulated = simulated.map(|codes| codes.iter());
    for &code in codes {
        let simulated = simulated.as_mut().and_then(Iterator::next).map_or(4, |code| place(*code));
        confusion.cells[simulated][place(code)] += 1;
    }
    confusion
}

/// The boxes between neighbouring nodes whose lowest corner lies in a tile, without the axis of eps.
struct Boxes {
    /// Index ranges of the nodes that are corners of these boxes, eps among the axes.
    nodes: Vec<Range<usize>>,
    /// Number of nodes of the tile itself on each axis but eps.
    cells: Vec<usize>,
    /// Lengths of the boxes along each axis but eps; `None` for an axis of one node.
    lengths: Vec<Option<Vec<f64>>>,
}

impl Boxes {
    fn of(map: &MapFile, tile: &Tile) -> Self {
        let axes = map.grid().axes();
        let mut nodes = tile.ranges.clone();
        let mut lengths = Vec::with_capacity(axes.len());
        for (axis, range) in axes.iter().zip(&mut nodes).filter(|(axis, _)| axis.role != AxisRole::Epsilon) {
            range.end = (range.end + 1).min(axis.values.len());
            lengths.push(
                (axis.values.len() > 1)
                    .then(|| axis.values[range.clone()].windows(2).map(|pair| pair[1] - pair[0]).collect()),
            );
        }
        let cells = axes.iter().zip(&tile.ranges).filter(|(axis, _)| axis.role != AxisRole::Epsilon);
        Self { nodes, cells: cells.map(|(_, range)| range.len()).collect(), lengths }
    }

    /// The part of an array over the corners that belongs to the tile.
    fn cells_only<'a>(&self, codes: &ArrayViewD<'a, i8>) -> ArrayViewD<'a, i8> {
        let mut view = codes.clone();
        for (axis, &cells) in self.cells.iter().enumerate() {
            view.slice_axis_inplace(Dim(axis), Slice::from(0..cells));
        }
        view
    }

    fn volume(&self, codes: &ArrayViewD<i8>, simulated: Option<&ArrayViewD<i8>>) -> Volume {
        let shape: Vec<usize> = codes.shape().to_vec();
        let present = |codes: &ArrayViewD<i8>| -> Vec<u16> {
            codes.iter().map(|code| u16::from(*code == Verdict::Present.code())).collect()
        };
        let inside = present(codes);
        let confirmed = simulated.map(|simulated| {
            let mut both = present(simulated);
            for (both, inside) in both.iter_mut().zip(&inside) {
                *both &= inside;
            }
            self.weigh(both, shape.clone(), 0).0
        });
        let damping = self.lengths.len() - 1;
        let error_in_c = self.lengths[damping].as_ref().map_or(0.0, |_| {
            let mut shape = shape.clone();
            let changes = pairs(&inside, &mut shape, damping, |low, high| low ^ high);
            // Each change counts half a step, as each corner of a step does.
            self.weigh(changes, shape, 1).0
        });
        let (claimed, error) = self.weigh(inside, shape, 0);
        Volume { claimed, error_in_c, error, confirmed: confirmed.unwrap_or(0.0) }
    }

    /// Volume of a set given by its indicator at the nodes (1 or 0, row-major), and the bound of its error.
    /// Along the last `done` axes the numbers are per step, not per node.
    fn weigh(&self, inside: Vec<u16>, mut shape: Vec<usize>, done: usize) -> (f64, f64) {
        let mut corners = inside;
        let mut full: u16 = 1 << self.lengths[self.lengths.len() - done..].iter().flatten().count();
        for (axis, lengths) in self.lengths[..self.lengths.len() - done].iter().enumerate() {
            if lengths.is_some() {
                corners = pairs(&corners, &mut shape, axis, |low, high| low + high);
                full *= 2;
            }
        }
        // Products of the lengths along all axes but the last, row-major.
        let outer = self.lengths.len() - 1;
        let mut weights = vec![1.0];
        for lengths in self.lengths[..outer].iter().flatten() {
            weights = weights.iter().flat_map(|w| lengths.iter().map(move |length| w * length)).collect();
        }
        let one = vec![1.0];
        let last = self.lengths[outer].as_ref().unwrap_or(&one);
        let share = 1.0 / f64::from(full);
        let (mut volume, mut error) = (0.0, 0.0);
        for (row, weight) in corners.chunks(last.len().max(1)).zip(weights) {
            let (mut row_volume, mut row_error) = (0.0, 0.0);
            for (&count, length) in row.iter().zip(last) {
                row_volume += f64::from(count) * length;
                if 0 < count && count < full {
                    row_error += f64::from(count.max(full - count)) * length;
                }
            }
            volume += weight * share * row_volume;
            error += weight * share * row_error;
        }
        (volume, error)
    }
}

/// Combines the numbers at neighbours along `axis` of a row-major array: one number fewer along that axis,
/// which `shape` then says.
fn pairs(numbers: &[u16], shape: &mut [usize], axis: usize, combined: impl Fn(u16, u16) -> u16) -> Vec<u16> {
    let inner: usize = shape[axis + 1..].iter().product();
    let (from, to) = (inner * shape[axis], inner * (shape[axis] - 1));
    shape[axis] -= 1;
    let mut pairs = vec![0; shape.iter().product()];
    for (pairs, layers) in pairs.chunks_exact_mut(to.max(1)).zip(numbers.chunks_exact(from.max(1))) {
        for ((pair, low), high) in pairs.iter_mut().zip(layers).zip(&layers[inner..]) {
            *pair = combined(*low, *high);
        }
    }
    pairs
}

//! The error of each method's boundary, measured in the damping c against the exact critical damping.

use std::collections::BTreeMap;
use std::ops::Range;

use rayon::prelude::*;

use super::{ReportError, SIMULATION, check};
use slipmap_certify::{Columns, Test};
use slipmap_column::Method;
use slipmap_column::critical::{CriticalDamping, critical_dampings};
use slipmap_format::MapFile;
use slipmap_map::{Control, Grid, unravel};
use slipmap_model::friction::Column;

/// Accuracy of critical dampings that the map does not store: relative to the divergence, see
/// [`critical_dampings`].
const TOLERANCE: f64 = 1e-12;

/// Number of columns handed to one worker at a time.
const BATCH: usize = 1024;

/// Histogram of the sizes of errors, for quantiles. Its bins have the relative width 2^-10, so its memory
/// does not grow with the map.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Sizes {
    bins: BTreeMap<u64, u64>,
    pub(crate) count: u64,
    largest: f64,
}

impl Sizes {
    /// Number of bits of an f64 below the bin: 10 of the 52 bits of the fraction make bins.
    const DROPPED: u32 = 42;

    fn add(&mut self, size: f64) {
        *self.bins.entry(size.abs().to_bits() >> Self::DROPPED).or_default() += 1;
        self.count += 1;
        self.largest = self.largest.max(size.abs());
    }

    /// The `q` quantile, to one part in 2^11: the middle of its bin, or the largest error if that
    /// is less. `None` if there are no errors.
    pub(crate) fn quantile(&self, q: f64) -> Option<f64> {
        let rank = ((q * self.count as f64).ceil() as u64).max(1);
        let mut seen = 0;
        for (&bin, &count) in &self.bins {
            seen += count;
            if seen >= rank {
                let middle = f64::from_bits((bin << Self::DROPPED) | (1 << (Self::DROPPED - 1)));
                return Some(if bin == 0 { 0.0 } else { middle.min(self.largest) });
            }
        }
        None
    }
}

/// Errors of one method's boundary at one eps, over the columns in which both the method and the flow have
/// a boundary at c >= 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct BoundaryError {
    pub(crate) sizes: Sizes,
    /// Sizes of the errors in those columns that have both boundaries at every eps, for the order.
    pub(crate) common: Sizes,
    /// The error of largest absolute value: the method's boundary minus the exact one, positive where it claims too much.
    pub(crate) worst: Option<f64>,
    /// Number of columns in which the method's boundary exceeds the exact one by more than the error of the
    /// exact one.
    pub(crate) beyond: u64,
    /// Number of columns in which only the flow has a boundary: the method claims no presence there.
    pub(crate) only_exact: u64,
    /// Number of columns in which only the method has one: it claims cycles where there are none.
    pub(crate) only_method: u64,
}

/// The local exponent of an error between two neighbouring eps, from its medians. It is the order p of an error that falls
/// like eps^p where the error is asymptotic.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Order {
    /// The two eps, the smaller first.
    pub epsilons: [f64; 2],
    pub exponent: f64,
    /// How far the exponent is from p: an error C eps^p (1 + a eps) has the exponent p + a L between two eps, where L is
    /// their logarithmic mean, and the next pair's exponent tells a. `None` for the largest pair.
    pub deviation: Option<f64>,
}

impl Order {
    /// The exponent where it is the order, to a tenth.
    #[must_use]
    pub fn asymptotic(&self) -> Option<f64> {
        self.deviation.is_some_and(|deviation| deviation <= 0.1).then_some(self.exponent)
    }
}

#[derive(Clone, Debug, PartialEq)]
pub struct MethodBoundary {
    pub method: String,
    pub(crate) errors: Vec<BoundaryError>,
    /// The order between neighbouring eps, from the smallest on; none if fewer than two eps have a median above the
    /// error of the exact boundary.
    pub orders: Vec<Order>,
}

#[derive(Clone, Debug, PartialEq)]
pub struct Boundaries {
    /// The closed-form methods whose boundary is known.
    pub methods: Vec<MethodBoundary>,
    /// Whether the exact boundary was read from the map rather than computed again.
    pub stored: bool,
    /// Errors of the exact boundary in each column, at each eps.
    pub(crate) exact_error: Vec<Sizes>,
}

enum Origin {
    Stored(String),
    Claim(&'static Test),
}

impl Boundaries {
    /// Reads or computes the boundaries in every column, block by block.
    pub(super) fn read(map: &MapFile, control: &Control) -> Result<Self, ReportError> {
        let epsilons = map.grid().epsilons().len();
        let exact = map.critical(SIMULATION);
        let stored = map.has(&exact);
        let errors = map.critical_error();
        let mut boundaries =
            Self { methods: Vec::new(), stored, exact_error: vec![Sizes::default(); epsilons] };
        let mut sources = Vec::new();
        for method in map.methods() {
            let variable = map.critical(method.name());
            let source = match method {
                Method::Test(_) if map.has(&variable) => Origin::Stored(variable),
                Method::Test(test) => Origin::Claim(test),
                // The exact boundary, and methods that give verdicts, not critical dampings.
                Method::Simulation | Method::Direct | Method::Naive(..) => continue,
            };
            sources.push(source);
            let errors = vec![BoundaryError::default(); epsilons];
            boundaries.methods.push(MethodBoundary {
                method: method.name().into(),
                errors,
                orders: Vec::new(),
            });
        }
        for ranges in blocks(map) {
            check(control)?;
            let columns = Block { grid: map.grid(), ranges };
            let (exact, resolution) = if stored {
                (columns.stored(map, &exact)?, columns.stored(map, &errors)?)
            } else {
                let found = columns.compute([f64::NAN; 2], |columns| {
                    let known = |root: Result<CriticalDamping, _>| {
                        let known = root.and_then(CriticalDamping::known);
                        known.map_or([f64::NAN; 2], |root| [root.c, root.error])
                    };
                    critical_dampings(columns, TOLERANCE).into_iter().map(known).collect()
                });
                found.into_iter().map(|[c, error]| (c, error)).unzip()
            };
            for (value, sizes) in columns.by_epsilon(&resolution).zip(&mut boundaries.exact_error) {
                value.iter().filter(|size| size.is_finite()).for_each(|&size| sizes.add(size));
            }
            for (source, method) in sources.iter().zip(&mut boundaries.methods) {
                let edges = match source {
                    Origin::Stored(variable) => columns.stored(map, variable)?,
                    Origin::Claim(test) => columns.compute(f64::NAN, |columns| {
                        let claims = test.claims(&Columns::new(columns));
                        claims.iter().map(|claim| claim.edge().unwrap_or(f64::NAN)).collect()
                    }),
                };
                method.add(&columns, &edges, &exact, &resolution);
            }
        }
        let axis = map.grid().epsilons();
        for method in &mut boundaries.methods {
            method.orders = orders(axis, &method.errors, &boundaries.exact_error);
        }
        Ok(boundaries)
    }
}

/// The tiles of the map, each extended over all eps and without the damping axis.
fn blocks(map: &MapFile) -> impl Iterator<Item = Vec<Range<usize>>> {
    let grid = map.grid();
    let mut shape = map.tile_shape().to_vec();
    if let Some(axis) = grid.epsilon_axis() {
        shape[axis] = grid.axes()[axis].values.len();
    }
    if let (Some(tile), Some(len)) = (shape.last_mut(), grid.shape().last()) {
        *tile = *len;
    }
    (0..grid.tile_count(&shape)).map(move |number| {
        let mut ranges = grid.tile(&shape, number).ranges;
        ranges.pop();
        ranges
    })
}

/// A box of columns that contains every eps.
struct Block<'a> {
    grid: &'a Grid,
    ranges: Vec<Range<usize>>,
}

impl Block<'_> {
    fn len(&self) -> usize {
        self.ranges.iter().map(ExactSizeIterator::len).product()
    }

    /// Number of columns at one eps.
    fn layer(&self) -> usize {
        self.len() / self.grid.epsilons().len()
    }

    /// Grid index of the column with this position, on each axis but that of c.
    fn index(&self, position: usize) -> Vec<usize> {
        let shape: Vec<usize> = self.ranges.iter().map(ExactSizeIterator::len).collect();
        self.ranges.iter().zip(unravel(position, &shape)).map(|(range, at)| range.start + at).collect()
    }

    fn stored(&self, map: &MapFile, variable: &str) -> Result<Vec<f64>, ReportError> {
        Ok(map.reals(variable, &self.ranges)?.iter().copied().collect())
    }

    /// Computes a number for each column, in parallel; `none` at nodes without one.
    fn compute<T: Copy + Send + Sync>(&self, none: T, of: impl Fn(&[Column]) -> Vec<T> + Sync) -> Vec<T> {
        let starts: Vec<usize> = (0..self.len()).step_by(BATCH).collect();
        let parts: Vec<Vec<T>> = starts
            .into_par_iter()
            .map(|start| {
                let columns: Vec<Option<Column>> = (start..(start + BATCH).min(self.len()))
                    .map(|position| self.grid.column(&[self.index(position), vec![0]].concat()).ok())
                    .collect();
                let known: Vec<bool> = columns.iter().map(Option::is_some).collect();
                let mut found = of(&columns.into_iter().flatten().collect::<Vec<_>>()).into_iter();
                let of_column = |known: bool| if known { found.next().unwrap_or(none) } else { none };
                known.into_iter().map(of_column).collect()
            })
            .collect();
        parts.concat()
    }

    fn by_epsilon<'b>(&self, values: &'b [f64]) -> impl Iterator<Item = &'b [f64]> {
        values.chunks(self.layer().max(1))
    }
}

/// Returns whether `c` is a boundary at c >= 0; maps hold NaN where there is none.
fn is_boundary(c: f64) -> bool {
    (0.0..f64::INFINITY).contains(&c)
}

impl MethodBoundary {
    fn add(&mut self, block: &Block, edges: &[f64], exact: &[f64], resolution: &[f64]) {
        let layer = block.layer();
        let counts = |position: usize| is_boundary(edges[position]) && is_boundary(exact[position]);
        for column in 0..layer {
            let common = (0..self.errors.len()).all(|epsilon| counts(epsilon * layer + column));
            for (epsilon, errors) in self.errors.iter_mut().enumerate() {
                let position = epsilon * layer + column;
                let (edge, root) = (edges[position], exact[position]);
                match (is_boundary(edge), is_boundary(root)) {
                    (true, true) => {
                        let error = edge - root;
                        errors.sizes.add(error);
                        if common {
                            errors.common.add(error);
                        }
                        errors.beyond += u64::from(error > resolution[position]);
                        if errors.worst.is_none_or(|worst| error.abs() > worst.abs()) {
                            errors.worst = Some(error);
                        }
                    }
                    (false, true) => errors.only_exact += 1,
                    (true, false) => errors.only_method += 1,
                    (false, false) => {}
                }
            }
        }
    }
}

/// The orders of the medians in eps, without medians below the error of the exact boundary.
fn orders(epsilons: &[f64], errors: &[BoundaryError], exact_error: &[Sizes]) -> Vec<Order> {
    let medians: Vec<(f64, f64)> = epsilons
        .iter()
        .zip(errors)
        .zip(exact_error)
        .filter_map(|((epsilon, errors), exact)| {
            let median = errors.common.quantile(0.5)?;
            (median > exact.quantile(0.5)?).then_some((*epsilon, median))
        })
        .collect();
    let exponent = |pair: &[(f64, f64)]| {
        let [(from, low), (to, high)] = [pair[0], pair[1]];
        Order { epsilons: [from, to], exponent: (high / low).ln() / (to / from).ln(), deviation: None }
    };
    let mut orders: Vec<Order> = medians.windows(2).map(exponent).collect();
    let mean = |of: &Order| (of.epsilons[1] - of.epsilons[0]) / (of.epsilons[1] / of.epsilons[0]).ln();
    for pair in 1..orders.len() {
        let [own, next] = [mean(&orders[pair - 1]), mean(&orders[pair])];
        let change = orders[pair].exponent - orders[pair - 1].exponent;
        orders[pair - 1].deviation = Some((change * own / (next - own)).abs());
    }
    orders
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Of an error C eps^p (1 + a eps), exactly but for the square of a eps.
    #[test]
    fn an_exponent_is_an_order_where_the_next_one_says_so() {
        let layer = |size: f64| {
            let mut errors = BoundaryError::default();
            errors.common.add(size);
            errors
        };
        let found = |epsilons: &[f64], a: f64| {
            let errors: Vec<_> = epsilons.iter().map(|e| layer(0.3 * e * e * (1.0 + a * e))).collect();
            let mut exact = Sizes::default();
            exact.add(0.0);
            orders(epsilons, &errors, &vec![exact; epsilons.len()])
        };
        let [first, last] = found(&[0.01, 0.1, 0.3], 0.5)[..] else { panic!("two pairs") };
        let deviation = first.deviation.unwrap();
        // The histogram's bins make an exponent uncertain by 1/2048 over the logarithm of the ratio.
        assert!((first.exponent - 2.0 - deviation).abs() < 0.1 * deviation + 1e-3, "{first:?}");
        assert_eq!(first.asymptotic(), Some(first.exponent));
        assert_eq!(last.asymptotic(), None);
        assert_eq!(found(&[0.3, 1.0, 3.0], 1.0)[0].asymptotic(), None);
    }

    #[test]
    fn quantiles_are_within_their_error() {
        let mut sizes = Sizes::default();
        assert_eq!(sizes.quantile(0.5), None);
        let mut all: Vec<f64> = (1..=999).map(|i| 1e-6 * f64::from(i * i)).collect();
        all.iter().for_each(|&x| sizes.add(-x));
        all.sort_by(f64::total_cmp);
        for q in [0.01, 0.5, 0.95, 1.0] {
            let exact = all[((q * 999.0_f64).ceil() as usize).max(1) - 1];
            let found = sizes.quantile(q).unwrap();
            // Half a bin: bins are 2^-10 wide relative to their lower end.
            assert!((found - exact).abs() <= exact / 2048.0, "{q}: {found} against {exact}");
        }
        let mut zero = Sizes::default();
        zero.add(0.0);
        assert_eq!(zero.quantile(0.5), Some(0.0));
    }
}

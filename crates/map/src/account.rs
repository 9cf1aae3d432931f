//! Statistics of tiles: cells counted, processor seconds, audit results.

use super::{Audit, Contradictions, Grid, LISTED, Paths, Plan, Runs, TileData};
use slipmap_column::Verdict;
use slipmap_numbers::named_sums;

/// A cell on which a method failed.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct FailedCell {
    /// Number of the tile.
    pub tile: usize,
    /// Its index in the grid.
    pub index: Vec<usize>,
    /// Position of the method in the plan.
    pub method: usize,
}

/// Statistics of one method.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MethodAccount {
    /// Processor seconds.
    pub seconds: f64,
    /// Number of cells with each verdict, in the order of [`Verdict::ALL`].
    pub counts: [u64; 5],
}

named_sums! {
    /// Processor seconds of the stages of a run that belong to no method.
    #[derive(Clone, Copy, Debug, Default, PartialEq)]
    #[derive(serde::Serialize, serde::Deserialize)]
    pub struct Stages of f64 {
        /// Creating the columns of the tiles with their friction curves.
        pub(crate) columns,
        /// Interpolating critical dampings and backbones between columns.
        pub(crate) interpolation,
        /// Computing the field `regime`.
        pub(crate) regime,
        /// Computing the other fields that follow orbits: landings, cycles, basins, limits in eps; also the
        /// simulation, if it is not among the methods.
        pub(crate) fields,
        /// The self-audit.
        pub audit,
        /// Packing tiles: compression, fingerprints, counts.
        pub pack,
        /// Writing packed tiles.
        pub(crate) write,
        /// The curves of codimension one, on all threads.
        pub(crate) curves,
        /// The proofs between the nodes, on all threads.
        pub(crate) proofs,
        /// The rest: waiting threads, handing out tiles.
        pub(crate) other,
    }
}

named_sums! {
    /// Numbers of values of fields that could not be computed.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
    #[derive(serde::Serialize, serde::Deserialize)]
    pub struct Unknown of u64 {
        /// Cells without a regime.
        pub regimes,
        /// Columns without a critical damping because an engine gave no answer in its search.
        pub critical,
        /// Columns whose critical damping is withheld because its error is more than 1 % of it.
        pub inaccurate,
    }
}

impl MethodAccount {
    /// Number of cells with one verdict.
    #[must_use]
    pub fn cells_with(&self, verdict: Verdict) -> u64 {
        Verdict::ALL.iter().position(|v| *v == verdict).map_or(0, |i| self.counts[i])
    }
}

/// Statistics of one tile, or their sums over several. All but the seconds depend on the plan alone.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Account {
    /// Number of cells computed.
    pub cells: u64,
    /// Number of them at nodes without a column, see [`Grid::gap`](super::Grid::gap).
    pub blank: u64,
    /// One entry per method of the plan.
    pub methods: Vec<MethodAccount>,
    /// Number of cells that each path of `simulation` decided.
    pub paths: Paths,
    /// Number of evaluations of the right-hand side by `simulation`.
    pub rhs: u64,
    /// The self-audit.
    pub audit: Audit,
    /// Cells in which methods with a guarantee contradict each other.
    pub contradictions: Contradictions,
    /// Values of fields that could not be computed.
    pub unknown: Unknown,
    /// The least slip speed from which on the friction of a column pushes, where its regimes leave out orbits that
    /// reach it.
    pub left_out_from: Option<f64>,
    /// Processor seconds of the stages that belong to no method.
    pub stages: Stages,
    /// The first failed cells, at most ten, in the order of tiles.
    pub failed: Vec<FailedCell>,
}

impl Account {
    /// The account of no tiles.
    #[must_use]
    pub fn none(plan: &Plan) -> Self {
        Self { methods: vec![MethodAccount::default(); plan.methods.len()], ..Self::default() }
    }

    /// Processor seconds of all methods and stages.
    #[must_use]
    pub fn processor_seconds(&self) -> f64 {
        let methods = self.methods.iter().map(|method| method.seconds);
        methods.chain(self.stages.named().map(|(_, seconds)| seconds)).sum()
    }

    /// Adds another account.
    pub fn add(&mut self, other: Account) {
        self.cells += other.cells;
        self.blank += other.blank;
        for (sum, method) in self.methods.iter_mut().zip(other.methods) {
            sum.seconds += method.seconds;
            sum.counts.iter_mut().zip(method.counts).for_each(|(total, count)| *total += count);
        }
        self.paths.add(&other.paths);
        self.rhs += other.rhs;
        self.audit.add(other.audit);
        self.contradictions.add(other.contradictions);
        self.unknown.add(&other.unknown);
        let from = [self.left_out_from, other.left_out_from].into_iter().flatten();
        self.left_out_from = from.reduce(f64::min);
        self.stages.add(&other.stages);
        if !other.failed.is_empty() {
            self.failed.extend(other.failed);
            self.failed.sort_by_key(|cell| cell.tile);
            self.failed.truncate(LISTED);
        }
    }
}

/// Number of cells with each verdict, in the order of [`Verdict::ALL`].
pub(super) fn count(verdicts: &Runs<Verdict>) -> [u64; 5] {
    Verdict::ALL.map(|verdict| verdicts.count(|other| other == verdict))
}

/// The first failed cells of a tile, at most ten, method by method.
pub(super) fn failed_cells(grid: &Grid, data: &TileData) -> Vec<FailedCell> {
    let failed = data.methods.iter().enumerate().flat_map(|(method, cells)| {
        let runs = cells.verdicts.iter().filter(|(verdict, _)| *verdict == Verdict::Failed);
        let index = |cell| data.tile.cell_index(cell);
        runs.flat_map(|(_, cells)| cells).map(move |cell| FailedCell {
            tile: data.tile.number,
            index: index(cell),
            method,
        })
    });
    let has_column = |cell: &FailedCell| grid.gap().is_none() || grid.column(&cell.index).is_ok();
    failed.filter(has_column).take(LISTED).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{MethodCells, Tile};
    use slipmap_column::Method;
    use slipmap_model::friction::Law;

    fn tile_data(tile: Tile, failed: &[usize]) -> TileData {
        let verdict = |cell| if failed.contains(&cell) { Verdict::Failed } else { Verdict::Absent };
        let verdicts = (0..tile.cells()).map(verdict).collect();
        let methods = vec![MethodCells::new(Method::Simulation, verdicts)];
        TileData { tile, methods, regime: Runs::new(), quantities: Vec::new() }
    }

    fn simulated(grid: Grid, tile_shape: Vec<usize>) -> Plan {
        Plan::builder(grid).methods([Method::Simulation]).tile_shape(tile_shape).build().unwrap()
    }

    #[test]
    fn failed_cells_are_found_with_their_places() {
        let axis = |values: &[f64]| values.to_vec();
        let nodes =
            [&[0.1, 0.2][..], &[0.5], &[0.0], &[1.0, 2.0, 3.0], &[1.0], &[0.0, 0.5, 1.0, 1.5]].map(axis);
        let grid = Grid::new(Law::Stribeck, nodes.to_vec()).unwrap();
        // Two columns per tile, and a tile of one column at the end of each gamma axis.
        let tile_shape = vec![1, 1, 1, 2, 1, 4];
        let plan = simulated(grid, tile_shape);
        let mut sum = Account::none(&plan);
        let last = plan.grid.tile_count(&plan.tile_shape) - 1;
        // Tiles come in any order; the failed cells are listed in the grid's order.
        for (number, failed) in [(last, &[2][..]), (0, &[1, 7])] {
            let data = tile_data(plan.grid.tile(&plan.tile_shape, number), failed);
            sum.add(Account { failed: failed_cells(&plan.grid, &data), ..Account::none(&plan) });
        }
        let places: Vec<Vec<usize>> = sum.failed.into_iter().map(|cell| cell.index).collect();
        assert_eq!(places, [[0, 0, 0, 0, 0, 1], [0, 0, 0, 1, 0, 3], [1, 0, 0, 2, 0, 2]]);
    }

    #[test]
    fn only_the_first_failed_cells_are_kept() {
        let nodes = [1, 1, 1, 1, 1, 32usize].map(|len| (0..len).map(|i| 0.5 + i as f64).collect());
        let grid = Grid::new(Law::Stribeck, nodes.to_vec()).unwrap();
        let plan = simulated(grid, vec![1, 1, 1, 1, 1, 32]);
        let data = tile_data(plan.grid.tile(&plan.tile_shape, 0), &(0..32).collect::<Vec<_>>());
        let found = failed_cells(&plan.grid, &data);
        assert_eq!(found.len(), LISTED);
        assert_eq!(found[9].index, [0, 0, 0, 0, 0, 9]);
    }
}

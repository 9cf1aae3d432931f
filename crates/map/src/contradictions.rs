//! Finds cells in which methods whose guarantee excludes errors give opposite verdicts, of which at most one
//! is right. Every run reports such cells, whatever the size of its audit.
//!
//! These methods are the tests that are theorems at finite eps, `validated`, and `simulation`.

use super::{LISTED, TileData};
use slipmap_certify::Guarantee;
use slipmap_column::Verdict;

/// A cell in which methods with a guarantee contradict each other.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Contradiction {
    /// The number of its tile.
    pub tile: usize,
    /// Its index in the grid.
    pub index: Vec<usize>,
    /// The verdict of each method of the plan, in the plan's order.
    pub verdicts: Vec<Verdict>,
}

/// The contradictions in the cells of some tiles: their number, and the first ones.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Contradictions {
    /// Number of cells.
    pub cells: u64,
    /// The first cells, at most ten, in the order of tiles.
    pub first: Vec<Contradiction>,
}

impl Contradictions {
    pub(super) fn add(&mut self, other: Contradictions) {
        self.cells += other.cells;
        if !other.first.is_empty() {
            self.first.extend(other.first);
            self.first.sort_by_key(|cell| cell.tile);
            self.first.truncate(LISTED);
        }
    }
}

/// Returns whether this guarantee excludes wrong verdicts.
pub(super) fn excludes_errors(guarantee: Guarantee) -> bool {
    match guarantee {
        Guarantee::FiniteEpsilon | Guarantee::Numerical | Guarantee::Validated => true,
        Guarantee::Asymptotic | Guarantee::None => false,
    }
}

/// The contradictions among the verdicts of a tile.
pub(super) fn contradictions(data: &TileData) -> Contradictions {
    let guaranteed = data.methods.iter().filter(|cells| excludes_errors(cells.method.guarantee()));
    // For each method what is left of its runs: verdict, and position after its last cell.
    let mut left: Vec<&[(Verdict, u32)]> = guaranteed.map(|cells| cells.verdicts.as_slice()).collect();
    let mut found = Contradictions::default();
    let cells = data.tile.cells();
    // Each step goes from one change of any verdict to the next.
    let mut from = 0;
    while from < cells {
        let (mut to, mut present, mut absent) = (cells, false, false);
        for runs in &mut left {
            let Some(&(verdict, end)) = runs.first() else { continue };
            to = to.min(end as usize);
            present |= verdict == Verdict::Present;
            absent |= verdict == Verdict::Absent;
        }
        for runs in &mut left {
            if let Some((&(_, end), rest)) = runs.split_first()
                && end as usize == to
            {
                *runs = rest;
            }
        }
        if present && absent {
            found.cells += (to - from) as u64;
            let room = LISTED - found.first.len();
            found.first.extend((from..to).take(room).map(|cell| contradiction(data, cell)));
        }
        from = to;
    }
    found
}

fn contradiction(data: &TileData, cell: usize) -> Contradiction {
    let verdicts = data.methods.iter().map(|cells| cells.verdicts.get(cell).unwrap_or(Verdict::NotComputed));
    let index = data.tile.cell_index(cell);
    Contradiction { tile: data.tile.number, index, verdicts: verdicts.collect() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Grid, MethodCells, Plan, Runs};
    use slipmap_column::Method;
    use slipmap_model::friction::Law;

    fn verdicts_of(codes: &[i8]) -> Runs<Verdict> {
        codes.iter().map(|code| Verdict::of_code(*code).unwrap()).collect()
    }

    /// The contradictions of one column of cells with the verdicts of four methods.
    fn of(verdicts: [&[i8]; 4]) -> Contradictions {
        let cells = verdicts[0].len();
        let dampings = (0..cells).map(|i| i as f64).collect();
        let nodes = vec![vec![0.1], vec![0.5], vec![0.0], vec![1.0], vec![1.0], dampings];
        let names = ["perturbation", "symmetric", "validated", "simulation"];
        let methods: Vec<Method> = names.iter().filter_map(|name| Method::by_name(name)).collect();
        let grid = Grid::new(Law::Stribeck, nodes).unwrap();
        let shape = grid.shape();
        let plan = Plan::builder(grid).methods(methods).tile_shape(shape).build().unwrap();
        // Methods are in the plan's order; each keeps the verdicts given under its name.
        let methods = plan.methods.iter().map(|&method| {
            let given = names.iter().position(|name| *name == method.name()).unwrap();
            MethodCells::new(method, verdicts_of(verdicts[given]))
        });
        let data = TileData {
            tile: plan.grid.tile(&plan.tile_shape, 0),
            methods: methods.collect(),
            regime: Runs::new(),
            quantities: Vec::new(),
        };
        contradictions(&data)
    }

    #[test]
    fn contradictory_cells_are_counted_and_listed() {
        let clear = of([&[1; 4], &[0, 0, -1, -1], &[2, 3, 0, -1], &[1, 0, -1, -1]]);
        assert_eq!(clear, Contradictions::default(), "the first-order test has no guarantee at finite eps");
        let found = of([&[0; 4], &[1, 0, -1, -1], &[0, 1, 0, 1], &[-1, -1, 1, 0]]);
        assert_eq!(found.cells, 4, "with the simulation or between two theorems");
        let dampings: Vec<usize> = found.first.iter().map(|cell| cell.index[5]).collect();
        assert_eq!(dampings, [0, 1, 2, 3]);
        assert!(found.first[0].verdicts.contains(&Verdict::Present));
        assert!(found.first[0].verdicts.contains(&Verdict::Absent));
    }

    #[test]
    fn all_are_counted_and_the_first_are_kept() {
        // A contradiction in every third cell of a column.
        for cells in [1, 2, 4, 100, 1000] {
            let sign = |i: usize| if i.is_multiple_of(3) { -1 } else { 1 };
            let simulation: Vec<i8> = (0..cells).map(sign).collect();
            let nothing = vec![0; cells];
            let found = of([&nothing, &vec![1; cells], &nothing, &simulation]);
            assert_eq!(found.cells, cells.div_ceil(3) as u64);
            assert_eq!(found.first.len(), LISTED.min(cells.div_ceil(3)));
        }
    }
}

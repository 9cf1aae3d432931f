//! The self-audit: decides random cells again with the independent direct engine.
//!
//! Half of the cells are drawn anywhere, half next to a change of verdict along c, where methods fail. The
//! draw depends on the plan and the verdicts alone, so it is the same for any number of threads. A cell that
//! is drawn twice is decided once. A grid with no more cells than the audit requests is audited completely.
//! Where the engine contradicts a verdict, it is run again with a tolerance a thousand times smaller.

use std::collections::HashMap;

use super::contradictions::excludes_errors;
use super::{Grid, Plan, Runs, Tile};
use slipmap_certify::Guarantee;
use slipmap_column::Verdict;
use slipmap_machine::second_opinion::{Opinion, Witness};
use slipmap_model::flow::Fate;
use slipmap_numbers::random::Random;

/// A verdict that the direct engine contradicts.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Disagreement {
    /// The index of the cell in the grid.
    pub index: Vec<usize>,
    /// Position of the method in the plan.
    pub method: usize,
    /// The verdict in the map.
    pub stored: Verdict,
    /// The fate of the orbit by the direct engine.
    pub direct: Fate,
}

/// Results of the audit. A decision is one method's verdict, present or absent, on one audited cell. Audited
/// methods are `simulation`, `validated` and the tests that are theorems at finite eps.
#[derive(Clone, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Audit {
    /// Number of distinct cells decided again.
    pub cells: u64,
    /// Number of decisions checked.
    pub checked: u64,
    /// Number of decisions that the direct engine confirms.
    pub agreed: u64,
    /// Number of decisions on cells that are closer to the boundary than the error of the direct engine.
    pub within_margin: u64,
    /// Number of decisions on cells for which the direct engine gives no answer.
    pub unresolved: u64,
    /// Decisions that the direct engine contradicts.
    pub disagreements: Vec<Disagreement>,
}

impl Audit {
    pub(super) fn add(&mut self, other: Audit) {
        self.cells += other.cells;
        self.checked += other.checked;
        self.agreed += other.agreed;
        self.within_margin += other.within_margin;
        self.unresolved += other.unresolved;
        self.disagreements.extend(other.disagreements);
    }

    /// Sorts the disagreements in the order of the grid, since tiles come in any order.
    pub(super) fn sort(&mut self) {
        self.disagreements.sort_by(|a, b| a.index.cmp(&b.index).then(a.method.cmp(&b.method)));
    }
}

/// A drawn cell: a column and a position along it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Draw {
    column: usize,
    along: Along,
}

/// Position of an audited cell in its column.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Along {
    /// At this index of the damping axis.
    At(usize),
    /// Next to the first change of verdict, on its lower or upper side.
    NextToBoundary { upper: bool },
}

/// The cells to audit.
#[derive(Debug)]
pub(super) enum Draws {
    /// Every cell.
    All,
    /// Some cells, by tile.
    ByTile(HashMap<usize, Vec<Draw>>),
}

impl Draws {
    pub(super) fn new(plan: &Plan) -> Self {
        let grid: &Grid = &plan.grid;
        if plan.audit_cells >= grid.cells() {
            return Draws::All;
        }
        let tiles = grid.tile_count(&plan.tile_shape);
        let mut by_tile: HashMap<usize, Vec<Draw>> = HashMap::new();
        let mut random = Random(0);
        for i in 0..plan.audit_cells {
            let tile_number = (random.bits() % tiles as u64) as usize;
            let tile = grid.tile(&plan.tile_shape, tile_number);
            let column = (random.bits() % tile.columns() as u64) as usize;
            let node = (random.bits() % tile.damping_range().len() as u64) as usize;
            let along =
                if i % 2 == 0 { Along::At(node) } else { Along::NextToBoundary { upper: i % 4 == 1 } };
            by_tile.entry(tile_number).or_default().push(Draw { column, along });
        }
        Draws::ByTile(by_tile)
    }

    /// Audits the drawn cells of one tile against the verdicts just computed, one [`Runs`] per method.
    pub(super) fn audit(&self, plan: &Plan, tile: &Tile, verdicts: &[&Runs<Verdict>]) -> Audit {
        let mut audit = Audit::default();
        let width = tile.damping_range().len();
        let reference = plan.methods.iter().position(|method| method.guarantee() == Guarantee::Numerical);
        let along = |draw: &Draw| match draw.along {
            Along::At(node) => node,
            Along::NextToBoundary { upper } => {
                let start = draw.column * width;
                let last_equal = verdicts[reference.unwrap_or(0)].run_end(start);
                match last_equal.map(|last| last - start) {
                    Some(lower) if lower + 1 < width => lower + usize::from(upper),
                    _ => width - 1,
                }
            }
        };
        let mut cells: Vec<usize> = match self {
            Draws::All => (0..tile.cells()).collect(),
            Draws::ByTile(draws) => {
                let draws = draws.get(&tile.number).into_iter().flatten();
                draws.map(|draw| draw.column * width + along(draw)).collect()
            }
        };
        cells.sort_unstable();
        cells.dedup();
        for cell in cells {
            let stored = verdicts.iter().filter_map(|verdicts| verdicts.get(cell));
            audit.add(audit_cell(plan, &tile.cell_index(cell), stored));
        }
        audit
    }
}

/// Decides one cell again and compares every method whose guarantee excludes errors. The direct engine's
/// error is an estimate: where the engine contradicts a verdict, it is run again with a smaller tolerance.
fn audit_cell(plan: &Plan, index: &[usize], verdicts: impl Iterator<Item = Verdict>) -> Audit {
    let mut audit = Audit { cells: 1, ..Audit::default() };
    let Ok(oscillator) = plan.grid.oscillator_of(&plan.grid.values(index)) else { return Audit::default() };
    let witness = Witness::of(&oscillator, plan.tolerance);
    for (method, (of, stored)) in plan.methods.iter().zip(verdicts).enumerate() {
        if !(stored.is_decision() && excludes_errors(of.guarantee())) {
            continue;
        }
        audit.checked += 1;
        match witness.asked_about(stored) {
            (_, Opinion::None) => audit.unresolved += 1,
            (_, Opinion::WithinMargin) => audit.within_margin += 1,
            (_, Opinion::Agrees) => audit.agreed += 1,
            (direct, Opinion::Contradicts) => {
                let (index, direct) = (index.to_vec(), direct.fate);
                audit.disagreements.push(Disagreement { index, method, stored, direct });
            }
        }
    }
    audit
}

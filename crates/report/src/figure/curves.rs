//! Critical dampings along one parameter.

use std::cell::Cell;

use slipmap_column::Method;
use slipmap_column::critical::{CriticalDamping, critical_dampings};
use slipmap_figure::axis::Scale;
use slipmap_format::MapFile;
use slipmap_model::filippov::HopfRate;
use slipmap_model::friction::Column;

/// Number of steps of a curve.
const STEPS: usize = 60;
/// Accuracy of critical dampings in figures, far below the width of a line.
const TOLERANCE: f64 = 1e-9;
/// Budget of the curves of a figure: evaluations of the right-hand side of the Stribeck law, a hundred times
/// those that ordinary curves take, and two seconds.
const MOST_WORK: u64 = 8_000_000;
/// Work counted for a column without an answer, which takes up to a second.
const FAILURE: u64 = MOST_WORK / 2;
/// Number of columns that are solved together: few, since all of them may fail.
const TOGETHER: usize = 2;

/// Evenly spaced numbers on a scale.
pub(super) fn samples(scale: Scale) -> Vec<f64> {
    (0..=STEPS).map(|i| scale.value(i as f64 / STEPS as f64)).collect()
}

/// The columns of a map's law in which `axis` takes the given values and the others are fixed at nodes, up to the first
/// value without a column.
pub(super) fn columns(map: &MapFile, index: &[usize], axis: usize, values: &[f64]) -> Vec<Column> {
    let grid = map.grid();
    let mut at = grid.values(index);
    let mut column = |&value: &f64| {
        at[axis] = value;
        grid.column_of(&at).ok()
    };
    values.iter().map_while(&mut column).collect()
}

/// Work left for the curves of one figure, so that a figure takes bounded time for every map. Curves end
/// where it is spent.
pub(super) struct Budget(Cell<u64>);

impl Budget {
    pub(super) fn of_figure() -> Self {
        Self(Cell::new(MOST_WORK))
    }

    fn spend(&self, work: u64) {
        self.0.set(self.0.get().saturating_sub(work));
    }

    /// The exact critical dampings of the first columns, as many as the budget holds, with their errors; NaN
    /// where there is none, or none known to 1 %.
    fn solve(&self, columns: &[Column]) -> Vec<[f64; 2]> {
        let mut found = Vec::with_capacity(columns.len());
        let mut compiled: Option<&Column> = None;
        for some in columns.chunks(TOGETHER) {
            if self.0.get() == 0 {
                break;
            }
            for (column, root) in some.iter().zip(critical_dampings(some, TOLERANCE)) {
                // Columns with V within a factor of two share the compiled form of their law.
                let shares = |other: &Column| {
                    let octaves = (other.belt_speed.log2() - column.belt_speed.log2()).abs();
                    other.curve == column.curve && octaves < 1.0
                };
                if !compiled.is_some_and(shares) {
                    self.spend(column.curve.compiling_work(column.belt_speed));
                    compiled = Some(column);
                }
                self.spend(root.map_or(FAILURE, |root| root.rhs.saturating_mul(column.curve.cost())));
                let known = root.and_then(CriticalDamping::known);
                found.push(known.map_or([f64::NAN; 2], |root| [root.c, root.error]));
            }
        }
        found
    }
}

/// The exact critical damping of each column; NaN where none is known to 1 %, and where the budget is spent.
pub(super) fn exact(columns: &[Column], budget: &Budget) -> Vec<f64> {
    let mut found: Vec<f64> = budget.solve(columns).into_iter().map(|[c, _]| c).collect();
    found.resize(columns.len(), f64::NAN);
    found
}

/// The damping at which the equilibrium changes its stability: the divergence there is
/// weakening(V) - eps c.
pub(super) fn stability(column: &Column) -> f64 {
    HopfRate::new(&column.curve, column.belt_speed).value() / column.epsilon
}

/// The names of methods, and the boundary of each in every column.
pub(super) type Boundaries = Vec<(String, Vec<f64>)>;

/// The boundary of each method of a map that this program knows, the simulation last, then the errors of that;
/// NaN where there is none, and where the budget is spent.
pub(super) fn by_method(
    map: &MapFile,
    columns: &[Column],
    values: usize,
    budget: &Budget,
) -> (Boundaries, Vec<f64>) {
    let simulated = budget.solve(columns);
    let solved = &columns[..simulated.len()];
    let tests = map.methods().iter().filter_map(|method| match method {
        Method::Test(test) => {
            let edges = solved.iter().map(|column| test.claim(column).edge().unwrap_or(f64::NAN));
            Some((method.name().into(), edges.collect()))
        }
        Method::Simulation | Method::Direct | Method::Naive(..) => None,
    });
    let mut curves: Boundaries = tests.collect();
    let [exact, mut errors] = [0, 1].map(|of| simulated.iter().map(|found| found[of]).collect::<Vec<f64>>());
    curves.push((super::super::SIMULATION.into(), exact));
    curves.iter_mut().for_each(|(_, curve)| curve.resize(values, f64::NAN));
    errors.resize(values, f64::NAN);
    (curves, errors)
}

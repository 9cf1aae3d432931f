//! The data computed for one tile.

use super::{Runs, Tile};
use slipmap_column::{Method, Regime, Verdict};

/// Largest number of failed cells, and of contradictions, that are listed, for a tile and for a run.
pub const LISTED: usize = 10;

/// The results of one method on the cells of a tile.
#[derive(Clone, Debug, PartialEq)]
pub struct MethodCells {
    /// The method.
    pub method: Method,
    /// Verdicts, row-major over the tile's shape.
    pub verdicts: Runs<Verdict>,
    /// Margins, row-major over the tile's shape; empty unless stored.
    pub margins: Vec<f64>,
    /// Critical damping of each column, row-major over the tile's shape without the damping axis; empty
    /// unless stored. NaN where the column has no critical damping c >= 0, or none that is known to 1 %.
    pub critical: Vec<f64>,
    /// Estimates of the absolute errors of these, also of those not known to 1 %; empty for all methods but
    /// the simulation, whose critical dampings alone are approximate.
    pub critical_errors: Vec<f64>,
}

impl MethodCells {
    /// Verdicts alone.
    pub fn new(method: Method, verdicts: Runs<Verdict>) -> Self {
        let [margins, critical, critical_errors] = [const { Vec::new() }; 3];
        Self { method, verdicts, margins, critical, critical_errors }
    }
}

/// Everything computed for one tile.
#[derive(Clone, Debug, PartialEq)]
pub struct TileData {
    /// The tile.
    pub tile: Tile,
    /// One entry per method of the plan, in its order.
    pub methods: Vec<MethodCells>,
    /// Regimes, row-major over the tile's shape; empty unless stored.
    pub regime: Runs<Regime>,
    /// The values of each of [`Plan::quantities`](super::Plan::quantities), in that order, row-major over the
    /// tile's shape.
    pub quantities: Vec<Vec<f64>>,
}

impl TileData {
    /// Takes back what was computed in the columns at these positions.
    pub(super) fn blank_out(&mut self, columns: &[usize]) {
        let width = self.tile.damping_range().len();
        if columns.is_empty() || width == 0 {
            return;
        }
        let is_blank = |cell: usize| columns.binary_search(&(cell / width)).is_ok();
        for MethodCells { verdicts, margins, critical, critical_errors, .. } in &mut self.methods {
            *verdicts = without(verdicts, is_blank, Verdict::Failed);
            blank_cells(margins, is_blank);
            for of_columns in [critical, critical_errors] {
                blank_cells(of_columns, |column| is_blank(column * width));
            }
        }
        self.regime = without(&self.regime, is_blank, Regime::Failed);
        self.quantities.iter_mut().for_each(|cells| blank_cells(cells, is_blank));
    }
}

/// The values with `other` in blank cells.
fn without<T: Copy + PartialEq>(values: &Runs<T>, is_blank: impl Fn(usize) -> bool, other: T) -> Runs<T> {
    values.values().enumerate().map(|(cell, value)| if is_blank(cell) { other } else { value }).collect()
}

fn blank_cells(cells: &mut [f64], is_blank: impl Fn(usize) -> bool) {
    let blank = cells.iter_mut().enumerate().filter(|(cell, _)| is_blank(*cell));
    blank.for_each(|(_, value)| *value = f64::NAN);
}

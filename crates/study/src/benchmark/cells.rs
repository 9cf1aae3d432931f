//! The cells on which methods are compared: half of them anywhere in the box of a grid, half near the
//! boundary.

use rayon::prelude::*;

use super::reference::{Reference, reference};
use slipmap_column::{Verdict, critical_damping};
use slipmap_map::Grid;
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Fate;
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::Point;
use slipmap_orbits::flow;

/// A cell with its true answers.
#[derive(Clone, Debug)]
pub struct Cell {
    pub point: Point,
    pub(crate) column: Column,
    /// Whether it was drawn next to the boundary.
    pub near: bool,
    /// The answers to more than double precision.
    pub reference: Reference,
    /// The true verdict: the margin's sign, and for an orbit that comes back whether it sticks.
    pub verdict: Verdict,
}

/// Accuracy of the critical damping from which the reference starts, and of the landing.
const TOLERANCE: f64 = 1e-13;

/// The generator of Kronecker's sequence in d dimensions: the powers of the root of x^(d + 1) = x + 1 (M.
/// Roberts), whose points fill a box evenly for every number of points.
fn generators(dimensions: usize) -> Vec<f64> {
    let root = (0..64).fold(2.0_f64, |x, _| (1.0 + x).powf(1.0 / (dimensions as f64 + 1.0)));
    (1..=dimensions).map(|power| root.powi(-(power as i32))).collect()
}

/// Draws about `count` cells from the box of `grid`, alternately anywhere in it and, where the column has a
/// boundary at c > `near`, at most `near` away from it along c. The sequence depends on the grid alone, and
/// fewer cells are the first of many.
///
/// Cells whose true answer is not certain are left out.
pub(crate) fn draw(grid: &Grid, count: usize, near: f64) -> Vec<Cell> {
    let axes = grid.axes();
    // One dimension for each axis, and one for the distance from the boundary.
    let generators = generators(axes.len() + 1);
    let share = |i: usize, dimension: usize| (0.5 + (i + 1) as f64 * generators[dimension]).fract();
    let columns: Vec<Vec<Cell>> = (0..count.div_ceil(2))
        .into_par_iter()
        .map(|i| {
            let values = axes.iter().enumerate();
            let values: Vec<f64> =
                values.map(|(dimension, axis)| axis.extent().value(share(i, dimension))).collect();
            let Ok(column) = grid.column_of(&values) else { return Vec::new() };
            let point = grid.point_of(&values);
            let critical = critical_damping(&column, TOLERANCE).ok().map(|root| root.c);
            let offset = near * (2.0 * share(i, axes.len()) - 1.0);
            let beside = critical
                .filter(|c| *c > near)
                .and_then(|c| cell(grid.law(), Point { damping: c + offset, ..point }, critical, true));
            [cell(grid.law(), point, critical, false), beside].into_iter().flatten().collect()
        })
        .collect();
    columns.concat()
}

/// A cell with its true answers, if they are certain.
fn cell(law: &Law, point: Point, critical: Option<f64>, near: bool) -> Option<Cell> {
    let column = law.column(&point);
    let reference = reference(law, &point, critical);
    let margin = reference.margin?;
    let value = margin.value.value();
    let verdict = if value.abs() <= 2.0 * margin.error {
        return None;
    } else if value < 0.0 {
        Verdict::Absent
    } else {
        match flow(&Oscillator::in_column(&column, point.damping), TOLERANCE).fate {
            Fate::Sticks(_) => Verdict::Present,
            Fate::CrossesForever => Verdict::Absent,
            // A margin of 1e-15 is certain here but not for the engine; its orbit lands gently.
            Fate::TooCloseToCall => Verdict::Present,
            Fate::SpiralsInward | Fate::Failed(_) => return None,
        }
    };
    Some(Cell { point, column, near, reference, verdict })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grid() -> Grid {
        let nodes =
            [vec![0.05], vec![0.0, 0.9], vec![0.0, 0.3], vec![0.5, 1.0, 2.0], vec![0.2, 1.5], vec![0.0, 2.0]];
        Grid::new(Law::Stribeck, nodes.to_vec()).unwrap()
    }

    #[test]
    fn cells_are_where_they_should_be() {
        let cells = draw(&grid(), 100, 0.01);
        let fewer = draw(&grid(), 20, 0.01);
        assert!(fewer.iter().zip(&cells).all(|(a, b)| a.point == b.point));
        let near: Vec<&Cell> = cells.iter().filter(|cell| cell.near).collect();
        assert!(near.len() > 30 && cells.len() - near.len() == 50, "{} near", near.len());
        for cell in &cells {
            let critical = cell.reference.critical.map(|c| c.value.value());
            let margin = cell.reference.margin.unwrap().value.value();
            if let Some(critical) = critical {
                assert_eq!(margin > 0.0, cell.point.damping < critical, "{cell:?}");
                assert!(!cell.near || (cell.point.damping - critical).abs() <= 0.01);
            }
            assert!((0.5..=2.0).contains(&cell.point.law.as_slice()[2]));
        }
        for verdict in [Verdict::Present, Verdict::Absent] {
            assert!(cells.iter().filter(|cell| cell.verdict == verdict).count() > 20);
        }
    }
}

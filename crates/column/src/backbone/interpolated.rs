//! Backbones between columns of a law without corners, whose values at the nodes are interpolated over the
//! other parameters.

use std::cell::OnceCell;

use super::panel::{SAMPLES_PER_INTERVAL, largest, node_error_of, truncation_error};
use super::{Backbone, FAR, LARGEST_ERROR, SIZES};
use slipmap_model::flow::Failure;
use slipmap_model::friction::Column;
use slipmap_numbers::chebyshev::{Transform, node, weights};
use slipmap_orbits::{Piece, Work};

/// Truncation error, relative to the largest |C|, below which backbones to be interpolated between columns
/// need no further nodes.
const ENOUGH_BETWEEN_COLUMNS: f64 = 1e-4;

/// A backbone whose values at the nodes are interpolated between columns; its extremes are searched only for
/// dampings that need them.
pub struct InterpolatedBackbone<'a> {
    belt_speed: f64,
    values: &'a [f64],
    node_error: f64,
    series: [f64; InterpolatedBackbone::MOST_NODES],
    error: f64,
    nodes: &'a BackboneNodes,
    with_extremes: OnceCell<Backbone>,
}

/// Tables that interpolated backbones with the same nodes share.
pub struct BackboneNodes {
    transform: Transform,
    /// The weights of the nodes at each sample at which extremes are searched, by increasing r.
    weights: Vec<Vec<f64>>,
}

impl BackboneNodes {
    /// The tables for this number of intervals between nodes.
    pub fn new(intervals: usize) -> Self {
        let samples = SAMPLES_PER_INTERVAL * intervals;
        let weights = (0..=samples).map(|i| weights(intervals, -node(i, samples))).collect();
        Self { transform: Transform::new(intervals), weights }
    }

    /// Whether the polynomial through `values` rises from each sample to the next, or falls.
    fn is_monotone(&self, values: &[f64]) -> bool {
        let at = |weights: &Vec<f64>| weights.iter().zip(values).map(|(weight, value)| weight * value).sum();
        let (mut rises, mut falls) = (true, true);
        let mut before: f64 = at(&self.weights[0]);
        for weights in &self.weights[1..] {
            let here = at(weights);
            (rises, falls, before) = (rises && here > before, falls && here < before, here);
        }
        rises || falls
    }
}

impl<'a> InterpolatedBackbone<'a> {
    /// Largest number of nodes.
    const MOST_NODES: usize = 4 * SIZES[0] + 1;

    /// The number of intervals between nodes that this column needs; `None` if the largest is too small.
    ///
    /// # Errors
    /// [`Failure`] of an orbit.
    pub fn intervals(column: &Column, tolerance: f64) -> Result<Option<usize>, Failure> {
        let work = Work::of(Piece::CoarseBackbones, &column.curve);
        let mut backbone = Backbone::coarsest(&column.curve, column.belt_speed, tolerance, &work)?;
        let series = |backbone: &Backbone| truncation_error(&backbone.panels[0].series);
        let nodes = |backbone: &Backbone| backbone.panels[0].values.len();
        while series(&backbone).max(backbone.hidden) > ENOUGH_BETWEEN_COLUMNS * backbone.size
            && nodes(&backbone) < Self::MOST_NODES
        {
            let Some(finer) = backbone.refined(&column.curve, tolerance, &work)? else { break };
            backbone = finer;
        }
        let resolved = series(&backbone).max(backbone.hidden) <= LARGEST_ERROR * backbone.size;
        Ok(resolved.then(|| nodes(&backbone) - 1))
    }

    /// The values of C of a column at the nodes, from r = V down to 0, their largest error, the error of C by
    /// features of the law between the nodes, and the number of evaluations of the right-hand side; `None` where
    /// an orbit fails, or the nodes miss a feature of the law.
    pub fn values(column: &Column, tolerance: f64, intervals: usize) -> Option<(Vec<f64>, [f64; 2], u64)> {
        let work = Work::of(Piece::CoarseBackbones, &column.curve);
        let backbone =
            Backbone::with_intervals(&column.curve, column.belt_speed, tolerance, intervals, &work).ok()?;
        let Backbone { mut panels, node_error, rhs, hidden, size, .. } = backbone;
        (hidden <= LARGEST_ERROR * size).then(|| (panels.swap_remove(0).values, [node_error, hidden], rhs))
    }

    /// Interpolates values of C at the nodes, from r = V down to 0, with errors of at most `node_error`, that of
    /// features between the nodes included.
    pub fn new(nodes: &'a BackboneNodes, belt_speed: f64, values: &'a [f64], node_error: f64) -> Self {
        let mut series = [0.0; Self::MOST_NODES];
        series.iter_mut().zip(nodes.transform.coefficients(values)).for_each(|(c, value)| *c = value);
        let error = truncation_error(&series[..values.len()]) + node_error_of(values, node_error);
        Self { belt_speed, values, node_error, series, error, nodes, with_extremes: OnceCell::new() }
    }

    /// Whether there is an attracting slip cycle at C = `viscous`, given whether the equilibrium attracts and
    /// whether the orbit from the exit point returns; `None` where the backbone is not
    /// [reliable](Backbone::is_reliable_at).
    pub fn attracts(&self, viscous: f64, equilibrium_is_stable: bool, returns: bool) -> Option<bool> {
        let is_accurate = self.error <= LARGEST_ERROR * largest(self.values);
        let near = |value: f64| (value - viscous).abs() <= FAR * self.error;
        let variation: f64 = self.series[1..].iter().map(|c| c.abs()).sum();
        // Where the error is large, only dampings far from all values are decided.
        let distance = if is_accurate { FAR * self.error } else { variation + 10.0 * self.error };
        if (viscous - self.series[0]).abs() > variation + distance {
            return Some(false);
        }
        if !is_accurate {
            return None;
        }
        if self.nodes.is_monotone(self.values) {
            // There is at most one cycle, between the ends.
            let near_end = near(self.values[0]) || near(self.values[self.values.len() - 1]);
            return (!near_end).then_some(equilibrium_is_stable == returns && !returns);
        }
        let make = || Backbone::of_values(self.belt_speed, self.values.to_vec(), self.node_error);
        let backbone = self.with_extremes.get_or_init(make);
        let cycles = backbone
            .is_reliable_at(viscous)
            .then(|| backbone.cycles(viscous, equilibrium_is_stable, returns))??;
        Some(cycles.iter().any(|cycle| cycle.is_stable))
    }
}

//! The exact boundary of the stick-slip region on a slice, as curves from root-finding on the simulated flow.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::axis::Scale;
use super::panels::Panel;
use super::scene::Place;
use super::slice::Slice;
use crate::filippov::Oscillator;
use crate::simulate::{Fate, flow};

/// Number of steps along each axis on which the slice is searched first; parts of the boundary between its
/// nodes are missed.
const STEPS: usize = 48;
/// Number of bisections of a step: to a hundred-thousandth of the panel.
const HALVINGS: usize = 11;
/// Accuracy of the grazing margin, far below the width of a line.
const TOLERANCE: f64 = 1e-9;

/// Budget of a boundary: evaluations of the right-hand side, in units of that of the Stribeck law (see
/// [`crate::friction::Curve::cost`]), a second or so. Where orbits are so stiff that it would cost more, none
/// is drawn.
const WORK: u64 = 100_000_000;
/// Number of nodes along each axis from whose cost that of all nodes is estimated.
const TRIED: usize = 4;

/// An edge between two nodes of the search: its lower node, and whether it is horizontal.
type Edge = (usize, usize, bool);

/// The boundary of the set of points whose orbit sticks again, as curves on the page; empty if the search
/// would exceed its budget.
pub(crate) fn boundary(slice: &Slice, panel: &Panel) -> Vec<Vec<Place>> {
    let sticks = |s: f64, t: f64| sticks(slice, panel.x, panel.y, s, t).0;
    let at = |i: usize| i as f64 / STEPS as f64;
    // The cost of a few nodes represents that of all: independent of the number of threads, and one stiff
    // node is enough to stop.
    let share = WORK * (TRIED * TRIED) as u64 / ((STEPS + 1) * (STEPS + 1)) as u64;
    let tried = |i: usize| i as f64 / (TRIED - 1) as f64;
    let mut cost = 0;
    for i in 0..TRIED * TRIED {
        cost += self::sticks(slice, panel.x, panel.y, tried(i / TRIED), tried(i % TRIED)).1;
        if cost > share {
            return Vec::new();
        }
    }
    let nodes: Vec<Vec<bool>> =
        (0..=STEPS).into_par_iter().map(|i| (0..=STEPS).map(|j| sticks(at(i), at(j))).collect()).collect();
    let mut edges: Vec<Edge> = Vec::new();
    for i in 0..=STEPS {
        for j in 0..=STEPS {
            if i < STEPS && nodes[i][j] != nodes[i + 1][j] {
                edges.push((i, j, true));
            }
            if j < STEPS && nodes[i][j] != nodes[i][j + 1] {
                edges.push((i, j, false));
            }
        }
    }
    let crossings: BTreeMap<Edge, Place> = edges
        .into_par_iter()
        .map(|edge| {
            let (i, j, horizontal) = edge;
            let along = |f: f64| match horizontal {
                true => ((i as f64 + f) / STEPS as f64, at(j)),
                false => (at(i), (j as f64 + f) / STEPS as f64),
            };
            let (mut low, mut high) = (0.0, 1.0);
            for _ in 0..HALVINGS {
                let middle = 0.5 * (low + high);
                let (s, t) = along(middle);
                if sticks(s, t) == nodes[i][j] { low = middle } else { high = middle }
            }
            let (s, t) = along(0.5 * (low + high));
            (edge, panel.place(panel.x.value(s), panel.y.value(t)))
        })
        .collect();
    chains(&crossings).into_iter().map(|chain| chain.iter().map(|edge| crossings[edge]).collect()).collect()
}

/// Returns whether the orbit sticks at a point of the slice, given by its position along both scales, and the
/// cost of the answer.
fn sticks(slice: &Slice, x: Scale, y: Scale, s: f64, t: f64) -> (bool, u64) {
    let point = slice.point(x.value(s), y.value(t));
    let oscillator = Oscillator::new(slice.law(), &point);
    let answer = flow(&oscillator, TOLERANCE);
    // Along axes of the law's parameters every node has a law of its own.
    let law_axes = 0..slice.view.map.grid().axes().len() - 2;
    let compiling = match law_axes.contains(&slice.x) || law_axes.contains(&slice.y) {
        true => oscillator.curve.compiling_work(oscillator.belt_speed),
        false => 0,
    };
    let sticks = match answer.fate {
        Fate::Sticks(_) => true,
        Fate::TooCloseToCall => answer.margin > 0.0,
        Fate::SpiralsInward | Fate::CrossesForever | Fate::Failed(_) => false,
    };
    (sticks, answer.rhs.saturating_mul(oscillator.curve.cost()).saturating_add(compiling))
}

/// Joins the crossed edges of each square of the search into chains.
fn chains(crossings: &BTreeMap<Edge, Place>) -> Vec<Vec<Edge>> {
    let mut neighbours: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    for i in 0..STEPS {
        for j in 0..STEPS {
            let sides = [(i, j, true), (i + 1, j, false), (i, j + 1, true), (i, j, false)];
            let crossed: Vec<Edge> = sides.into_iter().filter(|edge| crossings.contains_key(edge)).collect();
            // Four crossings are a saddle; either pairing is right to within one step.
            for pair in crossed.chunks_exact(2) {
                neighbours.entry(pair[0]).or_default().push(pair[1]);
                neighbours.entry(pair[1]).or_default().push(pair[0]);
            }
        }
    }
    let mut chains = Vec::new();
    // Open chains first, from their ends; the rest are loops.
    while let Some(start) = neighbours
        .iter()
        .find(|(_, next)| next.len() == 1)
        .or_else(|| neighbours.iter().next())
        .map(|(edge, _)| *edge)
    {
        let mut chain = vec![start];
        let mut at = start;
        while let Some(next) = neighbours.get_mut(&at).and_then(Vec::pop) {
            if neighbours.get(&at).is_some_and(Vec::is_empty) {
                neighbours.remove(&at);
            }
            if let Some(back) = neighbours.get_mut(&next) {
                if let Some(place) = back.iter().position(|edge| *edge == at) {
                    back.swap_remove(place);
                }
                if back.is_empty() {
                    neighbours.remove(&next);
                }
            }
            chain.push(next);
            at = next;
        }
        neighbours.remove(&start);
        chains.push(chain);
    }
    chains
}

//! The exact boundary of the stick-slip region on a slice, as curves from root-finding on the simulated flow.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::axis::Scale;
use super::panels::Panel;
use super::scene::Place;
use super::slice::Slice;
use slipmap_model::filippov::Oscillator;
use slipmap_simulate::{Fate, flow};

/// Number of steps along each axis on which the slice is searched first; parts of the boundary between its
/// nodes are missed.
const STEPS: usize = 48;
/// Number of bisections of a step: to a hundred-thousandth of the panel.
const HALVINGS: usize = 11;
/// Accuracy of the grazing margin, far below the width of a line.
const TOLERANCE: f64 = 1e-9;

/// Budget of a boundary, about a second: evaluations of the right-hand side, in units of that of the Stribeck
/// law (see [`slipmap_model::friction::Curve::cost`]). Where stiff orbits would exceed it, no boundary is drawn.
const WORK: u64 = 100_000_000;
/// Number of orbits between checks of the budget: small, but enough to run in parallel.
const TOGETHER: usize = 16;
/// Step between nodes in the order of computation, coprime to their number: the first nodes are spread over
/// the slice, so that their cost predicts the cost of all.
const STRIDE: usize = 1009;

/// An edge between two nodes of the search: its lower node, and whether it is horizontal.
type Edge = (usize, usize, bool);

/// The boundary of the set of points whose orbit sticks again, as curves on the page; empty if the search
/// would exceed its budget.
pub(crate) fn boundary(slice: &Slice, panel: &Panel) -> Vec<Vec<Place>> {
    let sticks = |s: f64, t: f64| sticks(slice, panel.x, panel.y, s, t);
    let at = |i: usize| i as f64 / STEPS as f64;
    let mut budget = WORK;
    let count = (STEPS + 1) * (STEPS + 1);
    let order: Vec<usize> = (0..count).map(|i| i * STRIDE % count).collect();
    let node = |number: &usize| sticks(at(number / (STEPS + 1)), at(number % (STEPS + 1)));
    let Some(labels) = within(&mut budget, &order, node) else { return Vec::new() };
    let mut nodes = vec![[None; STEPS + 1]; STEPS + 1];
    for (number, label) in order.into_iter().zip(labels) {
        nodes[number / (STEPS + 1)][number % (STEPS + 1)] = label;
    }
    // Where an orbit has no answer, no boundary is drawn.
    let differ =
        |one: Option<bool>, other: Option<bool>| one.zip(other).is_some_and(|(one, other)| one != other);
    let mut edges: Vec<Edge> = Vec::new();
    for i in 0..=STEPS {
        for j in 0..=STEPS {
            if i < STEPS && differ(nodes[i][j], nodes[i + 1][j]) {
                edges.push((i, j, true));
            }
            if j < STEPS && differ(nodes[i][j], nodes[i][j + 1]) {
                edges.push((i, j, false));
            }
        }
    }
    let crossing = |edge: &Edge| {
        let (i, j, horizontal) = *edge;
        let along = |f: f64| match horizontal {
            true => ((i as f64 + f) / STEPS as f64, at(j)),
            false => (at(i), (j as f64 + f) / STEPS as f64),
        };
        let (mut low, mut high, mut cost) = (0.0, 1.0, 0_u64);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            let (s, t) = along(middle);
            let (is_low, work) = sticks(s, t);
            cost = cost.saturating_add(work);
            if is_low == nodes[i][j] { low = middle } else { high = middle }
        }
        let (s, t) = along(0.5 * (low + high));
        (panel.place(panel.x.value(s), panel.y.value(t)), cost)
    };
    let Some(places) = within(&mut budget, &edges, crossing) else { return Vec::new() };
    let crossings: BTreeMap<Edge, Place> = edges.into_iter().zip(places).collect();
    chains(&crossings).into_iter().map(|chain| chain.iter().map(|edge| crossings[edge]).collect()).collect()
}

/// Computes the answers, each with its cost, in parallel; returns `None` once the mean cost so far predicts
/// that all exceed the budget. The result does not depend on the number of threads.
fn within<T: Sync, A: Send>(
    budget: &mut u64,
    items: &[T],
    answer: impl Fn(&T) -> (A, u64) + Sync,
) -> Option<Vec<A>> {
    let mut answers = Vec::with_capacity(items.len());
    let mut spent: u64 = 0;
    for some in items.chunks(TOGETHER) {
        let answered: Vec<(A, u64)> = some.par_iter().map(&answer).collect();
        for (answer, cost) in answered {
            spent = spent.saturating_add(cost);
            answers.push(answer);
        }
        if spent as f64 * items.len() as f64 > *budget as f64 * answers.len() as f64 {
            return None;
        }
    }
    *budget -= spent;
    Some(answers)
}

/// Returns whether the orbit sticks at a point of the slice, `None` if not known, and the cost of the answer.
/// `s` and `t` are the positions of the point along the two scales, 0 to 1.
fn sticks(slice: &Slice, x: Scale, y: Scale, s: f64, t: f64) -> (Option<bool>, u64) {
    let point = slice.point(x.value(s), y.value(t));
    let oscillator = Oscillator::new(slice.law(), &point);
    let answer = flow(&oscillator, TOLERANCE);
    // Along axes of the law's parameters every node has its own law, which is compiled for it.
    let law_axes = 0..slice.view.map.grid().axes().len() - 2;
    let compiling = match law_axes.contains(&slice.x) || law_axes.contains(&slice.y) {
        true => oscillator.curve.compiling_work(oscillator.belt_speed),
        false => 0,
    };
    let sticks = match answer.fate {
        Fate::Sticks(_) => Some(true),
        Fate::TooCloseToCall => Some(answer.margin > 0.0),
        Fate::SpiralsInward | Fate::CrossesForever => Some(false),
        Fate::Failed(_) => None,
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

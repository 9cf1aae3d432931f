//! Areas of a slice: cells of one kind as a small number of closed outlines.

use std::collections::BTreeMap;

use super::axis::Scale;
use super::panels::Panel;
use super::scene::Place;

/// Edges of the cells around the nodes of an axis: halfway between neighbours on the axis' scale, limited to
/// the ends of the scale.
pub fn cell_edges(values: &[f64], scale: Scale) -> Vec<f64> {
    let between = |pair: &[f64]| scale.value(0.5 * (scale.unit(pair[0]) + scale.unit(pair[1])));
    std::iter::once(scale.from).chain(values.windows(2).map(between)).chain([scale.to]).collect()
}

/// Outlines on the page of the cells `(i, j)` with `inside(i, j)`; `x` and `y` are the cells' edges.
pub fn outlines(
    panel: &Panel,
    x: &[f64],
    y: &[f64],
    inside: impl Fn(usize, usize) -> bool,
) -> Vec<Vec<Place>> {
    let x: Vec<f64> = x.iter().map(|&x| panel.place(x, y[0]).0).collect();
    let y: Vec<f64> = y.iter().map(|&y| panel.place(panel.x.from, y).1).collect();
    traced(&x, &y, inside)
}

/// Most fine cells along an axis: narrower than a line even in one column of a journal.
const FINE: usize = 400;
/// Most fine cells along one cell.
const PARTS: usize = 8;
/// Largest distance of the node that a fine cell takes, in cells.
const NEAR: usize = 2;
/// Distance on the page, in points, at which a node lies on a curve, which is drawn by chords.
const ON: f64 = 0.1;

/// Cells in finer ones, each of which takes the nearest node that no curve parts from it: areas end on curves instead
/// of halfway between two nodes.
pub struct Cells {
    /// Edges of the fine cells on the page.
    x: Vec<f64>,
    y: Vec<f64>,
    /// The node of each.
    nodes: Vec<(usize, usize)>,
}

impl Cells {
    /// The cells of a panel around `nodes`, with these `edges`, across and up.
    pub fn new(panel: &Panel, nodes: [&[f64]; 2], edges: [&[f64]; 2], curves: &[Vec<Place>]) -> Self {
        let places = |of: [&[f64]; 2]| {
            let across = of[0].iter().map(|&x| panel.place(x, panel.y.from).0);
            let up = of[1].iter().map(|&y| panel.place(panel.x.from, y).1);
            [across.collect::<Vec<f64>>(), up.collect()]
        };
        let (nodes, coarse) = (places(nodes), places(edges));
        let [columns, rows] = nodes.each_ref().map(Vec::len);
        let parts = [columns, rows].map(|cells| match curves.is_empty() {
            true => 1,
            false => (FINE / cells).clamp(1, PARTS),
        });
        let fine = [0, 1].map(|axis| {
            let part = |pair: &[f64], k: usize| pair[0] + (pair[1] - pair[0]) * k as f64 / parts[axis] as f64;
            let cells = coarse[axis].windows(2);
            let mut fine: Vec<f64> =
                cells.flat_map(|pair| (0..parts[axis]).map(move |k| part(pair, k))).collect();
            fine.extend(coarse[axis].last());
            fine
        });
        // The pieces of curves in each cell.
        let mut pieces: Vec<Vec<[Place; 2]>> = vec![Vec::new(); columns * rows];
        let range = |axis: usize, a: f64, b: f64| {
            let edges = &coarse[axis];
            let rises = edges[edges.len() - 1] > edges[0];
            let passed = |place: f64| {
                let inner = edges[1..edges.len() - 1].iter();
                inner.filter(|&&edge| if rises { edge <= place } else { edge >= place }).count()
            };
            let (a, b) = (passed(a), passed(b));
            a.min(b)..=a.max(b)
        };
        for pair in curves.iter().flat_map(|curve| curve.windows(2)) {
            let (a, b) = (pair[0], pair[1]);
            if [a.0, a.1, b.0, b.1].iter().all(|place| place.is_finite()) {
                for i in range(0, a.0, b.0) {
                    range(1, a.1, b.1).for_each(|j| pieces[i * rows + j].push([a, b]));
                }
            }
        }
        let near = |at: usize, cells: usize| at.saturating_sub(NEAR)..(at + NEAR + 1).min(cells);
        let mut taken = vec![(0, 0); columns * rows * parts[0] * parts[1]];
        for i in 0..columns {
            for j in 0..rows {
                let around = || near(i, columns).flat_map(|a| near(j, rows).map(move |b| (a, b)));
                let lines: Vec<[Place; 2]> =
                    around().flat_map(|(a, b)| &pieces[a * rows + b]).copied().collect();
                let [w, h] = [coarse[0][i + 1] - coarse[0][i], coarse[1][j + 1] - coarse[1][j]];
                for (a, b) in (0..parts[0]).flat_map(|a| (0..parts[1]).map(move |b| (a, b))) {
                    let (a, b) = (i * parts[0] + a, j * parts[1] + b);
                    let here = (0.5 * (fine[0][a] + fine[0][a + 1]), 0.5 * (fine[1][b] + fine[1][b + 1]));
                    let node = |(i, j): (usize, usize)| (nodes[0][i], nodes[1][j]);
                    let parted =
                        |at: (usize, usize)| lines.iter().any(|line| parts_from(*line, here, node(at)));
                    let distance = |at: &(usize, usize)| {
                        let (x, y) = node(*at);
                        ((x - here.0) / w).hypot((y - here.1) / h)
                    };
                    // The node of the cell is the nearest of all.
                    let others = || around().filter(|at| !parted(*at));
                    let closest = match parted((i, j)) {
                        true => others().min_by(|a, b| distance(a).total_cmp(&distance(b))),
                        false => None,
                    };
                    taken[a * rows * parts[1] + b] = closest.unwrap_or((i, j));
                }
            }
        }
        let [x, y] = fine;
        Self { x, y, nodes: taken }
    }

    /// Outlines on the page of the cells of the nodes with `inside(i, j)`.
    pub fn outlines(&self, inside: impl Fn(usize, usize) -> bool) -> Vec<Vec<Place>> {
        let rows = self.y.len() - 1;
        traced(&self.x, &self.y, |i, j| {
            let (i, j) = self.nodes[i * rows + j];
            inside(i, j)
        })
    }
}

/// Whether a piece of a curve parts a node from a place: it lies between them, or the node lies on it.
fn parts_from([a, b]: [Place; 2], place: Place, node: Place) -> bool {
    let side = |from: Place, to: Place, of: Place| {
        (to.0 - from.0) * (of.1 - from.1) - (to.1 - from.1) * (of.0 - from.0)
    };
    let of_node = side(a, b, node);
    let between = side(a, b, place) * of_node < 0.0 || of_node.abs() <= ON * (b.0 - a.0).hypot(b.1 - a.1);
    between && side(place, node, a) * side(place, node, b) <= 0.0
}

/// Outlines of the cells between edges on the page.
fn traced(x: &[f64], y: &[f64], inside: impl Fn(usize, usize) -> bool) -> Vec<Vec<Place>> {
    let (columns, rows) = (x.len() - 1, y.len() - 1);
    // Directed edges with the inside on their left, by their start.
    let mut edges: BTreeMap<(usize, usize), Vec<(usize, usize)>> = BTreeMap::new();
    for i in 0..columns {
        for j in 0..rows {
            if !inside(i, j) {
                continue;
            }
            let mut edge = |from, to| edges.entry(from).or_default().push(to);
            if j == 0 || !inside(i, j - 1) {
                edge((i, j), (i + 1, j));
            }
            if i + 1 == columns || !inside(i + 1, j) {
                edge((i + 1, j), (i + 1, j + 1));
            }
            if j + 1 == rows || !inside(i, j + 1) {
                edge((i + 1, j + 1), (i, j + 1));
            }
            if i == 0 || !inside(i - 1, j) {
                edge((i, j + 1), (i, j));
            }
        }
    }
    let straight = |a: (usize, usize), b: (usize, usize), c: (usize, usize)| {
        (a.0 == b.0 && b.0 == c.0) || (a.1 == b.1 && b.1 == c.1)
    };
    let mut outlines = Vec::new();
    while let Some((&start, _)) = edges.iter().next() {
        let mut corners: Vec<(usize, usize)> = Vec::new();
        let mut at = start;
        while let Some(next) = edges.get_mut(&at).and_then(Vec::pop) {
            if edges.get(&at).is_some_and(Vec::is_empty) {
                edges.remove(&at);
            }
            if corners.len() > 1 && straight(corners[corners.len() - 2], corners[corners.len() - 1], at) {
                corners.pop();
            }
            corners.push(at);
            at = next;
            if at == start {
                break;
            }
        }
        // The first corner is the lowest of its column and so a true corner; the last may lie on the straight
        // way to it.
        if let [first, .., before, last] = corners[..]
            && straight(before, last, first)
        {
            corners.pop();
        }
        outlines.push(corners.iter().map(|&(i, j)| (x[i], y[j])).collect());
    }
    outlines
}

#[cfg(test)]
mod tests {
    use super::super::scene::Rect;
    use super::*;

    /// Area by the shoelace formula.
    fn area(outlines: &[Vec<Place>]) -> f64 {
        outlines
            .iter()
            .map(|o| {
                let next = o.iter().cycle().skip(1);
                0.5 * o.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum::<f64>()
            })
            .sum::<f64>()
            .abs()
    }

    #[test]
    fn outlines_enclose_exactly_the_cells() {
        let rect = Rect { x: 0.0, y: 0.0, w: 4.0, h: 3.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 4.0), y: Scale::linear(0.0, 3.0) };
        let (x, y) = ([0.0, 1.0, 2.0, 3.0, 4.0], [0.0, 1.0, 2.0, 3.0]);
        // A ring with a hole, two cells that touch at a corner, all cells, no cells.
        for cells in [0b0111_0101_0111_u32, 0b0000_0010_0001, 0xfff, 0] {
            let inside = |i: usize, j: usize| cells >> (4 * j + i) & 1 == 1;
            let found = outlines(&panel, &x, &y, inside);
            assert_eq!(area(&found), f64::from(cells.count_ones()), "{cells:b}: {found:?}");
        }
        assert_eq!(
            outlines(&panel, &x, &y, |_, _| true),
            [vec![(0.0, 3.0), (4.0, 3.0), (4.0, 0.0), (0.0, 0.0)]]
        );
    }

    /// Areas end on the curve that parts them, to a fine cell, where it is steep, too.
    #[test]
    fn areas_end_on_the_curve_that_parts_them() {
        let rect = Rect { x: 0.0, y: 0.0, w: 1000.0, h: 1000.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 1.0), y: Scale::linear(0.0, 1.0) };
        let nodes: Vec<f64> = (0..=20).map(|n| f64::from(n) / 20.0).collect();
        let edges = cell_edges(&nodes, panel.x);
        let curve = |x: f64| 0.05 + 0.08 / (x + 0.1);
        let points = (0..=200).map(|n| f64::from(n) / 200.0).map(|x| panel.place(x, curve(x))).collect();
        let cells = Cells::new(&panel, [&nodes; 2], [&edges; 2], &[points]);
        let outlines = cells.outlines(|i, j| nodes[j] < curve(nodes[i]));
        let fine = 1.0 / 20.0 / 8.0;
        let places = outlines.iter().flatten().map(|(x, y)| (x / 1000.0, 1.0 - y / 1000.0));
        let inside = places.filter(|(x, y)| *x > 0.0 && *x < 1.0 && *y > 0.0);
        assert!(inside.clone().count() > 50, "{outlines:?}");
        for (x, y) in inside {
            let (least, most) = (curve(x + fine) - fine, curve(x - fine) + fine);
            assert!((least..=most).contains(&y), "({x}, {y})");
        }
    }
}

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
        outlines.push(corners.iter().map(|&(i, j)| panel.place(x[i], y[j])).collect());
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
}

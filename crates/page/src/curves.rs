//! Curves of codimension one, drawn.

use slipmap_column::bifurcation::Bifurcation;
use slipmap_column::regime;
use slipmap_figure::axis::Scale;
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::Panel;
use slipmap_figure::scene::{Marker, Place, Rect, Scene, Stroke};
use slipmap_figure::style;
use slipmap_figure::text::rich;
use slipmap_map::{PlaneCurve, PlaneCurves};
use slipmap_model::filippov::Oscillator;
use slipmap_orbits::flow;

/// The exact boundary, and the halo that it has.
pub const EXACT: Stroke = Stroke::solid(style::BLACK, 1.0);
pub const HALO: Stroke = Stroke::solid(style::WHITE, 1.8);

/// The places of curves in a panel of their plane.
pub fn places(curves: &PlaneCurves, panel: &Panel) -> Vec<Vec<Place>> {
    let line = |curve: &PlaneCurve| curve.points.iter().map(|p| panel.place(p.x, p.y)).collect();
    curves.curves.iter().map(line).collect()
}

/// Cells in finer ones, with the ends of these on both axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Parts {
    /// Ends of the finer cells across and upwards, as values on the axes.
    pub edges: [Vec<f64>; 2],
    /// Their codes, by columns.
    pub cells: Vec<Vec<i8>>,
}

/// Shares of the height at which a curve is at a share of the width.
fn heights(panel: &Panel, line: &PlaneCurve, across: f64) -> Vec<f64> {
    let points: Vec<[f64; 2]> = line.points.iter().map(|p| [panel.x.unit(p.x), panel.y.unit(p.y)]).collect();
    let at = |pair: &[[f64; 2]]| {
        let [[x0, y0], [x1, y1]] = [pair[0], pair[1]];
        ((x0 <= across) != (x1 <= across)).then(|| y0 + (y1 - y0) * (across - x0) / (x1 - x0))
    };
    points.windows(2).filter_map(at).collect()
}

/// Codes at nodes, by columns, in finer cells between the nodes, `parts` of them across and upwards: a change of the code
/// up a column lies on the curve that passes between its two nodes, and halfway where none does. The nodes are at these
/// `shares` of the panel. What no node tells, that of a strip between two curves which is narrower than two gaps, `between`
/// tells at the place of its values. Empty without two nodes on each axis.
pub fn along_curves(
    panel: &Panel,
    codes: &[Vec<i8>],
    shares: &[Vec<f64>; 2],
    parts: [usize; 2],
    lines: &[PlaneCurve],
    between: Between,
) -> Parts {
    let [xs, ys] = shares;
    if codes.len() != xs.len()
        || codes.iter().any(|column| column.len() != ys.len())
        || xs.len().min(ys.len()) < 2
    {
        return Parts { edges: [vec![0.0], vec![0.0]], cells: Vec::new() };
    }
    let at =
        |across: f64| -> Vec<Vec<f64>> { lines.iter().map(|line| heights(panel, line, across)).collect() };
    let nearest = |heights: &[f64], to: f64| {
        heights.iter().copied().min_by(|a, b| (a - to).abs().total_cmp(&(b - to).abs()))
    };
    // The changes of a column: the share of the height, the code above, and the curve.
    let changes = |(i, codes): (usize, &Vec<i8>)| -> Vec<(f64, i8, Option<usize>)> {
        // The curves begin and end with the panel.
        let here = at(xs[i].clamp(4e-4, 1.0 - 1e-9));
        let change = |j: usize| {
            let (middle, width) = (0.5 * (ys[j] + ys[j + 1]), ys[j + 1] - ys[j]);
            let between = |(k, heights): (usize, &Vec<f64>)| {
                let height = nearest(heights, middle)?;
                ((height - middle).abs() <= 0.501 * width).then_some((height, codes[j + 1], Some(k)))
            };
            here.iter().enumerate().find_map(between).unwrap_or((middle, codes[j + 1], None))
        };
        (0..codes.len() - 1).filter(|&j| codes[j] != codes[j + 1]).map(change).collect()
    };
    let changes: Vec<_> = codes.iter().enumerate().map(changes).collect();
    let rows = middles(ys, parts[1]);
    let column = |(k, across): (usize, f64)| {
        let here = at(across);
        let moved = |i: usize| -> (bool, Vec<(f64, i8)>) {
            let height = |(height, _, line): &(f64, i8, Option<usize>)| nearest(&here[(*line)?], *height);
            let ends: Vec<(f64, i8)> =
                changes[i].iter().map(|change| (height(change).unwrap_or(change.0), change.1)).collect();
            // Two changes on one side of a nose are one of the node and one that has left the panel.
            let is_apart = ends.windows(2).all(|pair| pair[0].0 < pair[1].0);
            (is_apart && changes[i].iter().all(|change| height(change).is_some()), ends)
        };
        // A curve may leave the panel between this node and the next: the one with more of them tells.
        let left = k / parts[0];
        let is_left = across - xs[left] < xs[left + 1] - across;
        let (near, far) = if is_left { (left, left + 1) } else { (left + 1, left) };
        let (node, ends) = match moved(far) {
            (true, ends) if ends.len() > changes[near].len() => (far, ends),
            _ => (near, moved(near).1),
        };
        let code = |height: &f64| {
            ends.iter().rev().find(|(end, _)| end <= height).map_or(codes[node][0], |(_, code)| *code)
        };
        rows.iter().map(code).collect()
    };
    let ends = |scale: Scale, nodes: &[f64], parts: usize| -> Vec<f64> {
        let gaps = nodes.windows(2);
        let inner =
            gaps.flat_map(|gap| (0..parts).map(|i| gap[0] + (gap[1] - gap[0]) * i as f64 / parts as f64));
        inner.chain(nodes.last().copied()).map(|share| scale.value(share)).collect()
    };
    let across = middles(xs, parts[0]);
    let mut cells: Vec<Vec<i8>> = across.iter().copied().enumerate().map(column).collect();
    let widest = ys.windows(2).map(|gap| gap[1] - gap[0]).fold(0.0, f64::max);
    fill_strips(&mut cells, panel, [&across, &rows], lines, NARROW * widest, between);
    Parts { edges: [ends(panel.x, xs, parts[0]), ends(panel.y, ys, parts[1])], cells }
}

/// The code of the regime of an oscillator.
pub fn regime_code(oscillator: &Oscillator) -> i8 {
    regime(oscillator, &flow(oscillator, TOLERANCE)).code()
}

/// Tolerance of the orbits of [`regime_code`].
const TOLERANCE: f64 = 1e-9;

/// The code at a place of the plane, if it is known.
pub type Between<'a> = &'a dyn Fn(f64, f64) -> Option<i8>;

/// Height of a strip, in gaps between nodes, below which it may have no node.
const NARROW: f64 = 2.0;

/// Gives the cells between neighbouring curves less than `narrow` apart their code. It is the same as long as the same curves
/// follow each other up the column, and is asked again where they do not.
fn fill_strips(
    cells: &mut [Vec<i8>],
    panel: &Panel,
    [across, rows]: [&[f64]; 2],
    lines: &[PlaneCurve],
    narrow: f64,
    between: Between,
) {
    let (mut before, mut known) = (Vec::new(), Vec::new());
    for (cells, &across) in cells.iter_mut().zip(across) {
        let of_line = |(k, line)| heights(panel, line, across).into_iter().map(move |height| (height, k));
        let mut here: Vec<(f64, usize)> = lines.iter().enumerate().flat_map(of_line).collect();
        // From one border to the other.
        here.extend([0.0, 1.0].map(|border| (border, lines.len())));
        here.sort_by(|a, b| a.0.total_cmp(&b.0));
        let order: Vec<usize> = here.iter().map(|(_, line)| *line).collect();
        if order != before {
            known = vec![None; order.len()];
            before = order;
        }
        for (pair, known) in here.windows(2).zip(&mut known) {
            let [low, high] = [pair[0].0, pair[1].0].map(|height| height.clamp(0.0, 1.0));
            let inside = rows.partition_point(|row| *row <= low)..rows.partition_point(|row| *row < high);
            if high - low >= narrow || inside.is_empty() {
                continue;
            }
            *known = known.or_else(|| between(panel.x.value(across), panel.y.value(0.5 * (low + high))));
            if let Some(code) = *known {
                cells[inside].fill(code);
            }
        }
    }
}

/// The middles of parts of the gaps between nodes.
fn middles(nodes: &[f64], parts: usize) -> Vec<f64> {
    let of = |gap: &[f64]| {
        let [from, to] = [gap[0], gap[1]];
        (0..parts).map(move |i| from + (to - from) * (i as f64 + 0.5) / parts as f64)
    };
    nodes.windows(2).flat_map(of).collect()
}

/// The drawing order: a fold on a Hopf curve shows in the gaps between the dashes of the Hopf curve.
const ORDER: [Bifurcation; 5] = [
    Bifurcation::Fold,
    Bifurcation::GrazingSliding,
    Bifurcation::Landing,
    Bifurcation::Crossing,
    Bifurcation::Hopf,
];

/// Draws curves into the panel of their plane. The legend names the visible ones, and tells which are incomplete.
/// `over_numbers`: over colours, where black curves have halos too; over regimes they are visible without, and a halo
/// would hide a thin strip between two.
pub fn draw(scene: &mut Scene, panel: &Panel, curves: &PlaneCurves, legend: &mut Legend, over_numbers: bool) {
    let places = |bifurcation: Bifurcation| {
        let of_kind = curves.curves.iter().filter(move |curve| curve.bifurcation == bifurcation);
        of_kind.map(|curve| curve.points.iter().map(|p| panel.place(p.x, p.y)).collect::<Vec<Place>>())
    };
    scene.clipped(panel.rect, |scene| {
        // The white halos of all curves come first, so that no halo covers a curve.
        let has_halo = |kind: &&Bifurcation| over_numbers || line_style(**kind).0.color != style::BLACK;
        for bifurcation in ORDER.iter().filter(has_halo) {
            places(*bifurcation).for_each(|line| scene.line(&line, &HALO));
        }
        for bifurcation in ORDER {
            places(bifurcation).for_each(|line| scene.line(&line, &line_style(bifurcation).0));
        }
    });
    for point in curves.curves.iter().filter(|curve| curve.bifurcation.along().is_some()) {
        let (marker, words) = mark(point.bifurcation);
        for at in point.points.iter().map(|p| panel.place(p.x, p.y)) {
            scene.marker(marker, at, MARK, style::BLACK, false);
        }
        legend.add(Sample::Mark(marker, style::BLACK, false), rich(words));
    }
    // A curve along the frame cannot be seen.
    let Rect { x, y, w, h } = panel.rect;
    let inner = Rect { x: x + 0.5, y: y + 0.5, w: w - 1.0, h: h - 1.0 };
    for bifurcation in ORDER {
        if places(bifurcation).any(|line| line.iter().filter(|p| inner.contains(**p)).count() > 1) {
            let (stroke, words) = line_style(bifurcation);
            let is_cut = curves.cut.contains(&bifurcation);
            let note = if is_cut { " (incomplete)" } else { "" };
            legend.add(Sample::Line(stroke), rich(&format!("{words}{note}")));
        }
    }
}

/// Size of the mark of a point of codimension two.
const MARK: f64 = 5.0;

/// The mark and the legend text of a bifurcation of codimension two.
fn mark(bifurcation: Bifurcation) -> (Marker, &'static str) {
    match bifurcation {
        Bifurcation::Bautin => (Marker::Circle, "Bautin point"),
        Bifurcation::HopfAtGrazing => (Marker::Diamond, "Hopf at grazing"),
        Bifurcation::FoldAtGrazing => (Marker::Triangle, "fold at grazing"),
        _ => (Marker::Square, "cusp of folds"),
    }
}

/// Line style and legend text of the curve of a bifurcation. Lines differ in their dashes, in colours visible
/// on every area.
pub fn line_style(bifurcation: Bifurcation) -> (Stroke, &'static str) {
    match bifurcation {
        Bifurcation::Hopf => (Stroke { color: style::BLACK, width: 1.0, dash: &[5.0, 2.0] }, "Hopf curve"),
        Bifurcation::GrazingSliding => (EXACT, "grazing curve"),
        Bifurcation::Landing => {
            (Stroke { color: style::VERMILION, width: 1.2, dash: &[1.4, 1.4] }, "landing curve")
        }
        Bifurcation::Crossing => {
            (Stroke { color: style::BLUE, width: 1.2, dash: &[3.0, 1.4] }, "crossing curve")
        }
        Bifurcation::Fold => (Stroke::solid(style::WINE, 1.2), "fold curve"),
        point => (EXACT, mark(point).1),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_map::{Plane, PlanePoint};

    #[test]
    fn no_halo_of_a_black_curve_hides_a_strip_of_regimes() {
        let rect = Rect { x: 0.0, y: 0.0, w: 100.0, h: 100.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 1.0), y: Scale::linear(0.0, 1.0) };
        let halos = |bifurcation: Bifurcation, over_numbers: bool| {
            let points = [0.1, 0.9].map(|x| PlanePoint { x, y: x, error: 0.0 }).into();
            let plane = Plane::new(0, 1, vec![0, 0]);
            let curves =
                PlaneCurves { plane, curves: vec![PlaneCurve { bifurcation, points }], cut: Vec::new() };
            let (mut scene, mut legend) = (Scene::new(100.0, 100.0), Legend::default());
            draw(&mut scene, &panel, &curves, &mut legend, over_numbers);
            scene.svg("curves", &rich("curves")).matches(&format!("stroke=\"{}\"", style::WHITE)).count()
        };
        assert_eq!([false, true].map(|numbers| halos(Bifurcation::Hopf, numbers)), [0, 1]);
        assert_eq!(halos(Bifurcation::Crossing, false), 1);
    }

    #[test]
    fn the_legend_tells_which_curves_are_incomplete() {
        let rect = Rect { x: 0.0, y: 0.0, w: 100.0, h: 100.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 1.0), y: Scale::linear(0.0, 1.0) };
        let curve = |bifurcation: Bifurcation| {
            let points = [0.1, 0.9].map(|x| PlanePoint { x, y: x, error: 0.0 }).into();
            PlaneCurve { bifurcation, points }
        };
        let told = |cut: Vec<Bifurcation>| {
            let curves = [Bifurcation::Hopf, Bifurcation::Fold].map(curve).into();
            let plane = Plane::new(0, 1, vec![0, 0]);
            let (mut scene, mut legend) = (Scene::new(200.0, 200.0), Legend::default());
            draw(&mut scene, &panel, &PlaneCurves { plane, curves, cut }, &mut legend, false);
            legend.below(&mut scene, 0.0, 100.0);
            let svg = scene.svg("curves", &rich("curves"));
            ["Hopf curve", "fold curve"].map(|name| svg.contains(&format!("{name} (incomplete)")))
        };
        assert_eq!(told(Vec::new()), [false, false]);
        assert_eq!(told(vec![Bifurcation::Fold]), [false, true]);
    }

    /// Two lines less than a gap apart, which cross at one end: few of the nodes lie between them.
    #[test]
    fn a_strip_without_nodes_has_its_code() {
        let rect = Rect { x: 0.0, y: 0.0, w: 1.0, h: 1.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 1.0), y: Scale::linear(0.0, 1.0) };
        let low = |x: f64| 0.31 + 0.3 * x;
        let high = |x: f64| low(x) + 0.03 * (x - 0.2);
        let code = |x: f64, y: f64| match (y > low(x), y > high(x)) {
            (false, false) => 0,
            (true, true) => 3,
            (true, false) => 1,
            (false, true) => 2,
        };
        let at = |i: usize| i as f64 / 20.0;
        let cells: Vec<Vec<i8>> = (0..21).map(|i| (0..21).map(|j| code(at(i), at(j))).collect()).collect();
        let shares = [0, 1].map(|_| (0..21).map(at).collect());
        let line = |height: &dyn Fn(f64) -> f64| {
            let points = [-0.001, 1.001].map(|x| PlanePoint { x, y: height(x), error: 0.0 }).into();
            PlaneCurve { bifurcation: Bifurcation::Hopf, points }
        };
        let asked = std::cell::Cell::new(0);
        let between = |x: f64, y: f64| {
            asked.set(asked.get() + 1);
            Some(code(x, y))
        };
        let fine = along_curves(&panel, &cells, &shares, [20, 20], &[line(&low), line(&high)], &between);
        let size = [fine.cells.len(), fine.cells[0].len()];
        let (mut within, mut wrong) = (0, 0);
        for (i, column) in fine.cells.iter().enumerate() {
            for (j, found) in column.iter().enumerate() {
                let [x, y] = [(i, size[0]), (j, size[1])].map(|(k, of)| (k as f64 + 0.5) / of as f64);
                within += usize::from([1, 2].contains(&code(x, y)));
                wrong += usize::from(*found != code(x, y));
            }
        }
        // One per region.
        assert!(within > 1500 && wrong == 0 && asked.get() == 2, "{within} {wrong} {asked:?}");
    }

    /// A nose whose lower side leaves the panel between two nodes, so that below it no node tells the code, and a lens on the
    /// border that no node sees.
    #[test]
    fn a_strip_along_the_border_has_its_code() {
        let rect = Rect { x: 0.0, y: 0.0, w: 1.0, h: 1.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 1.0), y: Scale::linear(0.0, 1.0) };
        let shares =
            [11, 21].map(|of| (0..of).map(|i| f64::from(i) / f64::from(of - 1)).collect::<Vec<f64>>());
        // Wrong cells, of those right of the node at x = 0.5 and at the bottom.
        let wrong = |code: &dyn Fn(f64, f64) -> i8, points: Vec<[f64; 2]>| {
            let column = |x: &f64| shares[1].iter().map(|y| code(*x, *y)).collect();
            let cells: Vec<Vec<i8>> = shares[0].iter().map(column).collect();
            let points = points.into_iter().map(|[x, y]| PlanePoint { x, y, error: 0.0 }).collect();
            let line = PlaneCurve { bifurcation: Bifurcation::Hopf, points };
            let between = |x: f64, y: f64| Some(code(x, y));
            let fine = along_curves(&panel, &cells, &shares, [20, 20], &[line], &between).cells;
            let size = [fine.len(), fine[0].len()];
            let is_wrong = |&(i, j): &(usize, usize)| {
                let [x, y] = [(i, size[0]), (j, size[1])].map(|(k, of)| (k as f64 + 0.5) / of as f64);
                // But for what the chords of the curve leave out.
                let sides = [-1e-3, 1e-3].map(|off| code(x + off, y));
                sides[0] == sides[1] && fine[i][j] != code(x, y)
            };
            let below = (100..120).flat_map(|i| (0..6).map(move |j| (i, j)));
            below.filter(is_wrong).collect::<Vec<(usize, usize)>>()
        };
        let nose = |y: f64| 0.64 - 0.1 * ((y - 0.1) / 0.09).powi(2);
        let points = (-10..=2000).map(|i| f64::from(i) / 2000.0).map(|y| [nose(y), y]);
        assert_eq!(wrong(&|x, y| i8::from(x < nose(y)), points.collect()), []);
        let lens = |x: f64| 0.01 - 4.5 * (x - 0.55).powi(2);
        let points = (90..=130).map(|i| f64::from(i) / 200.0).map(|x| [x, lens(x)]);
        assert_eq!(wrong(&|x, y| i8::from(y < lens(x)), points.collect()), []);
    }

    /// A line through the panel that leaves it at the top and at the bottom: every finer cell has the code of its side.
    #[test]
    fn areas_follow_the_curve_between_them() {
        const NODES: usize = 51;
        const DAMPINGS: usize = 121;
        let rect = Rect { x: 0.0, y: 0.0, w: 1.0, h: 1.0 };
        let panel = Panel { rect, x: Scale::linear(0.0, 1.0), y: Scale::linear(0.0, 1.0) };
        for slope in [0.3, 3.0, 40.0, -7.0] {
            let height = |x: f64| 0.51 + slope * (x - 0.493);
            let code = |x: f64, y: f64| i8::from(y > height(x));
            let at = |i: usize, of: usize| i as f64 / (of - 1) as f64;
            let column = |i| (0..DAMPINGS).map(|j| code(at(i, NODES), at(j, DAMPINGS))).collect();
            let cells: Vec<Vec<i8>> = (0..NODES).map(column).collect();
            let points = [-0.001, 1.001].map(|x| PlanePoint { x, y: height(x), error: 0.0 }).into();
            let line = PlaneCurve { bifurcation: Bifurcation::Hopf, points };
            let shares = [NODES, DAMPINGS].map(|of| (0..of).map(|i| at(i, of)).collect());
            let fine = along_curves(&panel, &cells, &shares, [8, 4], &[line], &|_, _| None).cells;
            let size = [fine.len(), fine[0].len()].map(|number| number as f64);
            for (i, column) in fine.iter().enumerate() {
                for (j, found) in column.iter().enumerate() {
                    let [x, y] = [(i as f64 + 0.5) / size[0], (j as f64 + 0.5) / size[1]];
                    assert!(*found == code(x, y) || (y - height(x)).abs() < 1e-9, "{slope}: {x} {y}");
                }
            }
        }
    }
}

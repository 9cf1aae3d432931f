//! Which method decides where: each cell shows the weakest rigorous test that decides it.

use super::super::text::{Rich, rich};
use super::super::{Report, ReportError, SIMULATION};
use super::axis::{Panel, Panels};
use super::exact::boundary;
use super::legend::{Legend, Sample};
use super::region::{cell_edges, outlines};
use super::scene::{Fill, Hatch, Rect, Scene, Width};
use super::slice::{Slice, telling};
use super::slices::{EXACT, chosen_epsilons, draw_curves, main_plane, method_title};
use super::{Figure, palette, slice::equals};
use crate::map::Verdict;
use crate::store::MapFile;

/// Fills of the rigorous tests, from the weakest.
const TESTS: [Fill; 6] = [
    Fill::plain(palette::BLUE),
    Fill::hatched(palette::SKY, Hatch::Rising, palette::WHITE),
    Fill::plain(palette::YELLOW),
    Fill::hatched(palette::GREEN, Hatch::Falling, palette::BLACK),
    Fill::hatched(palette::PURPLE, Hatch::Dots, palette::BLACK),
    Fill::plain(palette::ORANGE),
];
const SIMULATED: Fill = Fill::hatched("#f7e3bf", Hatch::Dots, palette::VERMILION);

/// The figure, one panel per eps.
///
/// # Errors
/// [`ReportError::Map`] if the map cannot be read.
pub fn deciders(map: &MapFile, report: &Report) -> Result<Figure, ReportError> {
    let methods = map.methods();
    let decided = |method: usize| -> u64 {
        let counts = &report.verdicts.confusion[method];
        counts.iter().map(|c| c.method(Verdict::Present) + c.method(Verdict::Absent)).sum()
    };
    let mut tests: Vec<usize> = (0..methods.len())
        .filter(|&m| matches!(methods[m].guarantee.as_str(), "finite_epsilon" | "validated"))
        .collect();
    tests.sort_by_key(|&m| (decided(m), m));
    let simulation = methods.iter().position(|method| method.name == SIMULATION);
    let (x, y) = main_plane(map);
    let index = telling(map);
    let epsilons = if x == 0 { vec![index[0]] } else { chosen_epsilons(map) };
    let mut kinds: Vec<(Fill, Rich)> = tests
        .iter()
        .enumerate()
        .map(|(rank, &m)| (TESTS[rank.min(5)], method_title(&methods[m].name)))
        .collect();
    kinds.push((SIMULATED, rich("simulation only")));
    kinds.push((palette::UNDECIDED, rich("none of them")));
    // cells[panel][x, y]: position in `kinds`.
    let mut slices = Vec::new();
    for &epsilon in &epsilons {
        let mut index = index.clone();
        index[0] = epsilon;
        let slice = Slice::new(map, x, y, index);
        let codes = tests
            .iter()
            .chain(&simulation)
            .map(|&m| slice.codes(&format!("verdict_{}", methods[m].name)))
            .collect::<Result<Vec<_>, _>>()?;
        slices.push((slice, codes));
    }
    let decides = |code: i8| code == Verdict::Present.code() || code == Verdict::Absent.code();
    let ((x_scale, x_name), (y_scale, y_name)) = (slices[0].0.x_scale(), slices[0].0.y_scale());
    let (x_nodes, y_nodes) = (slices[0].0.x_nodes(), slices[0].0.y_nodes());
    let (x_edges, y_edges) = (cell_edges(&x_nodes, x_scale), cell_edges(&y_nodes, y_scale));
    // Searched once, in a panel of unit size.
    let unit = Panel { rect: Rect { x: 0.0, y: 0.0, w: 1.0, h: 1.0 }, x: x_scale, y: y_scale };
    let exact: Vec<_> = slices.iter().map(|(slice, _)| boundary(slice, &unit)).collect();
    let mut scenes = Vec::new();
    for width in Width::ALL {
        let mut scene = Scene::new(width.points(), 0.0);
        let columns = match width {
            Width::OneColumn => 1,
            Width::TwoColumns => 2,
        };
        let panels = Panels::new(scene.width, columns, slices.len(), 0.66, x_scale, y_scale);
        let mut used = vec![false; kinds.len()];
        for ((panel, (slice, codes)), curves) in panels.panels.iter().zip(&slices).zip(&exact) {
            for (kind, (fill, _)) in kinds.iter().enumerate() {
                let areas = outlines(panel, &x_edges, &y_edges, |i, j| {
                    let first = codes.iter().position(|codes| decides(codes[[i, j]]));
                    first.unwrap_or(kinds.len() - 1) == kind
                });
                used[kind] |= !areas.is_empty();
                scene.area(&areas, *fill);
            }
            draw_curves(&mut scene, curves, &unit, panel);
            panel.title(&mut scene, &equals("epsilon", map.grid().axes()[0].values[slice.index[0]]));
        }
        panels.axes(&mut scene, &x_name, &y_name);
        let mut legend = Legend::default();
        for ((fill, name), _) in kinds.iter().zip(&used).filter(|(_, used)| **used) {
            legend.add(Sample::Area(*fill), name.clone());
        }
        if exact.iter().any(|curves| !curves.is_empty()) {
            legend.add(Sample::Line(EXACT), rich("exact boundary"));
        }
        legend.below(&mut scene, panels.panels[0].rect.x, panels.bottom);
        scenes.push((width, scene));
    }
    let caption = rich(
        "Which method decides where: each cell shows the first rigorous test that decides it, in the order of the number \
         of cells that they decide in the whole map, fewest first, then the simulation",
    )
    .then(rich("; at "))
    .then(if x == 0 { slices[0].0.held() } else { slices[0].0.held_but_epsilon() })
    .then(rich("."))
    .then(slices[0].0.thinned_words());
    Ok(Figure { name: "deciders".into(), caption, scenes })
}

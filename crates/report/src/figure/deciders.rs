//! The method that decides each cell: the weakest rigorous test that gives a verdict.

use ndarray::Array2;

use super::super::units::View;
use super::super::{Confusion, Report, ReportError, SIMULATION};
use super::bifurcations::boundary;
use super::slice::Slice;
use super::verdict_panels::{
    EXACT, FEWEST_NODES, cell_columns, draw_exact, failed_words, main_plane, method_title, panel_epsilons,
};
use super::{Figure, palette, slice::equals};
use slipmap_certify::Guarantee;
use slipmap_figure::data::Data;
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::Panels;
use slipmap_figure::region::outlines;
use slipmap_figure::scene::{Fill, Scene, Width};
use slipmap_figure::text::{Rich, rich};
use slipmap_map::map::Verdict;

/// The figure, one panel per eps; `None` for a map without a plane.
pub(crate) fn deciders(view: &View, report: &Report, width: Width) -> Result<Option<Figure>, ReportError> {
    let map = view.map;
    let methods = map.methods();
    let decided =
        |method: usize| -> u64 { report.verdicts.confusion[method].iter().map(Confusion::claims).sum() };
    let mut tests: Vec<usize> = (0..methods.len())
        .filter(|&m| matches!(methods[m].guarantee(), Guarantee::FiniteEpsilon | Guarantee::Validated))
        .collect();
    tests.sort_by_key(|&m| (decided(m), m));
    let (x, y) = main_plane(map);
    if [x, y].iter().any(|&axis| map.grid().axes()[axis].values.len() < FEWEST_NODES) {
        return Ok(None);
    }
    let index = view.informative_nodes();
    let epsilons = panel_epsilons(map, &index, &[x]);
    let area = |name: &str| (palette::method_area(name), method_title(name));
    let mut kinds: Vec<(Fill, Rich)> = tests.iter().map(|&m| area(methods[m].name())).collect();
    kinds.push((palette::method_area(SIMULATION), rich("simulation only")));
    let failed = palette::verdict(Verdict::Failed);
    let [none_of_them, fails] = [kinds.len(), kinds.len() + 1];
    kinds.push((palette::UNDECIDED, rich("none of them")));
    kinds.push((failed.fill, rich(&failed.words)));
    // cells[panel][x, y]: position in `kinds`.
    let mut slices = Vec::new();
    for &epsilon in &epsilons {
        let index = map.grid().at_epsilon(&index, epsilon);
        let slice = Slice::new(view, x, y, index);
        let codes = tests
            .iter()
            .chain(&report.verdicts.simulation)
            .map(|&m| slice.codes(&format!("verdict_{}", methods[m].name())))
            .collect::<Result<Vec<_>, _>>()?;
        slices.push((slice, codes));
    }
    let decides = |code: i8| Verdict::of_code(code).is_some_and(Verdict::is_decision);
    // The position in `kinds` of a cell.
    let kind_of = |codes: &[Array2<i8>], i: usize, j: usize| {
        let first = codes.iter().position(|codes| decides(codes[[i, j]]));
        let has_failed = || codes.iter().any(|codes| codes[[i, j]] == failed.code);
        first.unwrap_or_else(|| if has_failed() { fails } else { none_of_them })
    };
    let [(x_scale, x_name), (y_scale, y_name)] = slices[0].0.scales();
    let [x_edges, y_edges] = slices[0].0.edges();
    let held = match slices.len() {
        1 => slices[0].0.held(),
        _ => slices[0].0.held_but_epsilon(),
    };
    let exact: Vec<_> = slices.iter().map(|(slice, ..)| boundary(slice)).collect();
    let mut scene = Scene::new(width.points(), 0.0);
    let columns = width.select(1, 2);
    let panels = Panels::below(&mut scene, &held, columns, slices.len(), 0.66, (x_scale, y_scale));
    let mut used = vec![false; kinds.len()];
    for ((panel, (slice, codes)), curves) in panels.panels.iter().zip(&slices).zip(&exact) {
        for (kind, (fill, _)) in kinds.iter().enumerate() {
            let areas = outlines(panel, &x_edges, &y_edges, |i, j| kind_of(codes, i, j) == kind);
            used[kind] |= !areas.is_empty();
            scene.area(&areas, *fill);
        }
        draw_exact(&mut scene, curves, panel);
        if slices.len() > 1 {
            panel.title(&mut scene, &equals("epsilon", slice.epsilon()));
        }
    }
    panels.axes(&mut scene, &x_name, &y_name);
    let mut legend = Legend::default();
    legend.add_used(&kinds, &used);
    if exact.iter().any(|exact| !exact.curves.is_empty()) {
        legend.add(Sample::Line(EXACT), rich("exact boundary"));
    }
    legend.below(&mut scene, panels.panels[0].rect.x, panels.bottom);
    let caption = rich(
        "Which method decides where: each cell shows the first rigorous test that decides it, in the order of the number \
         of cells that they decide in the whole map, fewest first, then the simulation",
    )
    .then("; at ")
    .then(held)
    .then(".")
    .then(slices[0].0.thinned_words())
    .then(failed_words("cells", slices.iter().flat_map(|(_, codes)| {
        codes[0].indexed_iter().map(|((i, j), _)| kind_of(codes, i, j) == fails)
    })));
    let slice = &slices[0].0;
    let [columns, rows] = slice.nodes().map(|nodes| nodes.len());
    let cells = columns * rows;
    let mut data = Data::default();
    if slices.len() > 1 {
        let each = slices.iter().flat_map(|(slice, ..)| std::iter::repeat_n(slice.epsilon(), cells));
        data = data.reals("epsilon", each.collect());
    }
    let name = |codes: &[Array2<i8>], i: usize, j: usize| match kind_of(codes, i, j) {
        kind if kind == fails => "failed".to_owned(),
        kind if kind == none_of_them => "none".to_owned(),
        first => tests.get(first).map_or(SIMULATION, |&m| methods[m].name()).to_owned(),
    };
    let words = slices
        .iter()
        .flat_map(|(_, codes)| (0..cells).map(move |cell| name(codes, cell / rows, cell % rows)));
    data = data.join(cell_columns(slice, slices.len())).words("decided_by", words.collect());
    Ok(Some(Figure { name: "deciders".into(), caption, scene, data }))
}

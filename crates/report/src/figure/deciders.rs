//! The method that decides each cell: the weakest rigorous test that gives a verdict.

use ndarray::Array2;

use super::super::view::View;
use super::super::{Confusion, Report, ReportError};
use super::Figure;
use super::area::failed_words;
use super::area::{self, Area, Layer};
use super::bifurcations::boundary;
use super::slice::Slice;
use super::slice::{FEWEST_NODES, main_plane};
use super::verdict_panels::panel_epsilons;
use slipmap_column::Method;
use slipmap_figure::scene::Width;
use slipmap_figure::text::{Rich, rich};
use slipmap_page::palette;
use slipmap_page::units::Label;
use slipmap_page::units::equals;

/// The figure, one panel per eps; `None` for a map without a plane.
pub(crate) fn deciders(view: &View, report: &Report, width: Width) -> Result<Option<Figure>, ReportError> {
    let map = view.map;
    let decided =
        |method: usize| -> u64 { report.verdicts.confusion[method].iter().map(Confusion::claims).sum() };
    let mut tests: Vec<usize> =
        (0..map.methods().len()).filter(|&m| map.methods()[m].guarantee().is_rigorous()).collect();
    tests.sort_by_key(|&m| (decided(m), m));
    let methods: Vec<Method> =
        tests.iter().chain(&report.verdicts.simulation).map(|&m| map.methods()[m]).collect();
    let (x, y) = main_plane(map);
    if [x, y].iter().any(|&axis| map.grid().axes()[axis].values.len() < FEWEST_NODES) {
        return Ok(None);
    }
    let index = view.informative_nodes();
    let epsilons = panel_epsilons(map, &index, &[x]);
    let area = |&epsilon: &usize| -> Result<Area, ReportError> {
        let slice = Slice::new(view, x, y, map.grid().at_epsilon(&index, epsilon));
        let verdicts = methods.iter().map(|method| slice.codes(&format!("verdict_{}", method.name())));
        let verdicts = verdicts.collect::<Result<Vec<Array2<i8>>, _>>()?;
        let [columns, rows] = slice.nodes().map(|nodes| nodes.len());
        let cells = Array2::from_shape_fn((columns, rows), |at| {
            palette::decider(verdicts.iter().map(|codes| codes[at]))
        });
        let title = if epsilons.len() > 1 { equals("epsilon", slice.epsilon()) } else { Rich::default() };
        let exact = Some(boundary(&slice));
        let layer = Layer::Codes(cells, palette::deciders(&methods));
        Ok(Area { exact, title, ..Area::new(slice, layer) })
    };
    let areas = epsilons.iter().map(area).collect::<Result<Vec<_>, _>>()?;
    let first = &areas[0].slice;
    let held = if areas.len() > 1 { first.held_but_epsilon() } else { first.held() };
    let label = Label { key: "decided_by".into(), ..Label::default() };
    let scene = area::draw(&areas, &held, &label, false, width);
    let caption = rich(
        "Which method decides where: each cell shows the first rigorous test that decides it, in the order of the number \
         of cells that they decide in the whole map, fewest first, then the simulation",
    )
    .then("; at ")
    .then(held)
    .then(".")
    .then(first.thinned_words())
    .then(failed_words("cells", areas.iter().flat_map(Area::failed)));
    let values: Vec<f64> = areas.iter().map(|area| area.slice.epsilon()).collect();
    let data = area::data(&areas, &label, (areas.len() > 1).then_some(("epsilon", &values)));
    Ok(Some(Figure { name: "deciders".into(), caption, scene, data }))
}

//! Areas: one variable over a plane, in one panel or in several with the same scales.

use ndarray::Array2;

use super::bifurcations::{self, places};
use super::slice::{Slice, drawn};
use slipmap_column::Regime;
use slipmap_figure::axis::{AXIS, SMALL_TEXT, Scale, TEXT, extremes, text_width_of};
use slipmap_figure::data::{Data, Values};
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::{Panel, Panels};
use slipmap_figure::region::outlines;
use slipmap_figure::scene::{Anchor, Fill, Hatch, Marker, Place, Rect, Scene, Stroke, Width};
use slipmap_figure::style;
use slipmap_figure::text::{Rich, rich};
use slipmap_map::PlaneCurves;
use slipmap_numbers::text::count;
use slipmap_page::curves::{EXACT, HALO, Parts, along_curves, regime_code};
use slipmap_page::palette::{self, CellKind};
use slipmap_page::units::Label;

/// The values drawn, cell by cell.
#[derive(Clone, Debug)]
pub enum Layer {
    /// Codes, with the fill and the name of each.
    Codes(Array2<i8>, Vec<CellKind>),
    /// Real numbers by colour.
    Reals(Array2<f64>),
}

/// Points with a name for the legend.
#[derive(Clone, Debug)]
pub struct Marks {
    pub name: String,
    /// Across and upwards, in the units of the figure.
    pub points: Vec<[f64; 2]>,
}

/// A panel's contents.
#[derive(Debug)]
pub struct Area<'a> {
    pub slice: Slice<'a>,
    pub layer: Layer,
    /// The errors of the numbers, which the data have beside them, with their label.
    pub errors: Option<(Label, Array2<f64>)>,
    pub curves: Option<PlaneCurves>,
    /// The exact boundary of the stick-slip region.
    pub exact: Option<PlaneCurves>,
    /// The critical damping of the method whose panel it is, at the nodes of the horizontal axis.
    pub own_edge: Vec<(f64, f64)>,
    /// Points of other origin.
    pub marks: &'a [Marks],
    /// The regimes of numbers that only some of them have.
    pub regimes: Option<Array2<i8>>,
    pub title: Rich,
}

impl<'a> Area<'a> {
    /// The cells alone.
    pub(super) fn new(slice: Slice<'a>, layer: Layer) -> Self {
        let title = Rich::default();
        Self {
            slice,
            layer,
            errors: None,
            curves: None,
            exact: None,
            own_edge: Vec::new(),
            marks: &[],
            regimes: None,
            title,
        }
    }

    /// Whether each cell failed; numbers do not tell.
    pub(super) fn failed(&self) -> Vec<bool> {
        match &self.layer {
            Layer::Codes(cells, kinds) => {
                let failed = kinds.iter().find(|kind| kind.fill == palette::FAILED).map(|kind| kind.code);
                cells.iter().map(|code| Some(*code) == failed).collect()
            }
            Layer::Reals(_) => Vec::new(),
        }
    }
}

/// The critical damping of the method whose panel it is.
const OWN_EDGE: Stroke = Stroke { color: style::BLACK, width: 1.0, dash: &[2.0, 1.6] };
/// Colours for cells without a number.
const NO_NUMBER: Fill = palette::UNDECIDED;
/// Number of steps of a colour scale: more cannot be distinguished, and equal neighbours become one
/// rectangle.
const COLOURS: f64 = 128.0;
const BAR_WIDTH: f64 = 8.0;
/// The looks of points of other origin, of one series after the other.
const MARKS: [(Marker, &str); 6] = [
    (Marker::Circle, style::VERMILION),
    (Marker::Square, style::BLACK),
    (Marker::Triangle, style::GREEN),
    (Marker::Diamond, style::PURPLE),
    (Marker::TriangleDown, style::ORANGE),
    (Marker::Circle, style::BLUE),
];

/// The colour scale of real numbers, common to all panels.
#[derive(Clone, Copy, Debug)]
struct Colours {
    scale: Scale,
    /// Whether the scale has two colours that meet at 0.
    two_sided: bool,
}

impl Colours {
    /// The scale of the finite numbers of all panels; two-sided if `signed` and both signs occur. `None` if
    /// there is no finite number.
    fn of(areas: &[Area], signed: bool, factor: f64) -> Option<Self> {
        let cells = areas.iter().filter_map(|area| match &area.layer {
            Layer::Reals(cells) => Some(cells),
            Layer::Codes(..) => None,
        });
        let (least, most) = extremes(cells.flatten().copied().filter(|value| value.is_finite()));
        let two_sided = signed && least < 0.0 && most > 0.0;
        let size = most.max(-least);
        let (from, to) = if two_sided { (-size, size) } else { (least, most) };
        // For a constant the scale has length zero.
        (least <= most).then(|| {
            let scale = Scale { from, to, ..Scale::linear(0.0, 1.0) }.in_unit(factor);
            Self { scale, two_sided }
        })
    }

    /// Returns whether all numbers are equal.
    fn is_constant(&self) -> bool {
        self.scale.from == self.scale.to
    }

    fn unit(&self, value: f64) -> f64 {
        match value {
            _ if self.is_constant() => 0.5,
            f64::NEG_INFINITY => 0.0,
            value => self.scale.unit(value).clamp(0.0, 1.0),
        }
    }

    fn color(&self, unit: f64) -> String {
        if self.two_sided { style::diverging(unit) } else { style::sequential(unit) }
    }
}

/// Draws areas that share their axes. `label` names the variable for the colour scale; `signed` requests a
/// two-sided colour scale if both signs occur.
pub fn draw(areas: &[Area], heading: &Rich, label: &Label, signed: bool, width: Width) -> Scene {
    let mut scene = Scene::new(width.points(), 0.0);
    let Some(first) = areas.first() else { return scene };
    let [(x_scale, x_name), (y_scale, y_name)] = first.slice.scales();
    let colours = Colours::of(areas, signed, label.factor);
    let bar = colours.filter(|colours| !colours.is_constant());
    let ticks = bar.map(|colours| colours.scale.ticks(6)).unwrap_or_default();
    let numbers = text_width_of(&ticks);
    let bar_room = if bar.is_some() { BAR_WIDTH + numbers + TEXT + 22.0 } else { 0.0 };
    let (columns, aspect) = match (width, areas.len()) {
        (Width::OneColumn, 1) => (1, 0.75),
        (Width::TwoColumns, 1) => (1, 0.55),
        (Width::OneColumn, _) => (2, 0.78),
        (Width::TwoColumns, count) => (count.min(4), 0.78),
    };
    scene.width -= bar_room;
    let panels = Panels::below(&mut scene, heading, columns, areas.len(), aspect, (x_scale, y_scale));
    scene.width += bar_room;
    let mut legend = Legend::default();
    // The legend has the cells of all panels first, in the order of their kinds.
    let mut used = Vec::new();
    for (area, panel) in areas.iter().zip(&panels.panels) {
        draw_cells(&mut scene, panel, area, colours, (&mut legend, &mut used));
    }
    if let Layer::Codes(_, kinds) = &first.layer {
        let looks: Vec<_> = kinds.iter().map(|kind| (kind.fill, rich(&kind.words))).collect();
        let is_used: Vec<bool> = kinds.iter().map(|kind| used.contains(&kind.code)).collect();
        legend.add_used(&looks, &is_used);
    }
    for (area, panel) in areas.iter().zip(&panels.panels) {
        draw_lines(&mut scene, panel, area, &mut legend);
        panel.title(&mut scene, &area.title);
    }
    panels.axes(&mut scene, &x_name, &y_name);
    let rect = panels.panels[0].rect;
    if let Some(colours) = bar {
        let right = panels.panels.iter().map(|panel| panel.rect.x + panel.rect.w).fold(0.0, f64::max);
        let bottom = panels.panels.iter().map(|panel| panel.rect.y + panel.rect.h).fold(0.0, f64::max);
        // The numbers of the panels extend beyond their frames.
        let left = right + 0.5 * (scene.width - bar_room - right).max(8.0) + 5.0;
        let bar = Rect { x: left, y: rect.y, w: BAR_WIDTH, h: bottom - rect.y };
        draw_bar(&mut scene, bar, colours, &label.text(), numbers);
    } else if let Some(colours) = colours {
        let swatch = Sample::Color(style::sequential(0.5));
        let value = Rich::number(colours.scale.from * label.factor, 4);
        legend.add(swatch, rich("everywhere ").then(value).with_unit(&label.unit));
    }
    legend.below(&mut scene, rect.x, panels.bottom);
    scene
}

/// Draws the cells, with the halos of the lines over them; adds to the legend what numbers have, and to `used` the codes
/// that occur.
fn draw_cells(
    scene: &mut Scene,
    panel: &Panel,
    area: &Area,
    colours: Option<Colours>,
    (legend, used): (&mut Legend, &mut Vec<i8>),
) {
    let [x_edges, y_edges] = area.slice.edges();
    match &area.layer {
        Layer::Codes(cells, kinds) => {
            // The verdicts of methods change elsewhere.
            let is_regime = kinds.iter().any(|kind| kind.name == Regime::Bistable.name());
            let fine = if is_regime { finer(panel, area, cells) } else { None };
            let mut fill = |scene: &mut Scene, wrong: bool| {
                for kind in kinds.iter().filter(|kind| palette::is_wrong(kind.fill) == wrong) {
                    let areas = match &fine {
                        Some(Parts { edges: [x, y], cells }) => {
                            outlines(panel, x, y, |i, j| cells[i][j] == kind.code)
                        }
                        None => outlines(panel, &x_edges, &y_edges, |i, j| cells[[i, j]] == kind.code),
                    };
                    if !areas.is_empty() {
                        scene.area(&areas, kind.fill);
                        used.push(kind.code);
                    }
                }
            };
            fill(scene, false);
            // Below the wrong verdicts, which may be a thin strip along a line.
            for (lines, _, _) in boundaries(area, panel) {
                stroke(scene, panel, &lines, &HALO);
            }
            fill(scene, true);
        }
        Layer::Reals(cells) => {
            if let Some(colours) = colours {
                draw_pixels(scene, panel, (&x_edges, &y_edges), cells, colours);
            }
            for (kind, fill, words) in [
                (Empty::Always, palette::PRESENT, "vibrates without a kick"),
                (Empty::Never, palette::ABSENT, "no kick starts it"),
                (Empty::Unknown, NO_NUMBER, if area.regimes.is_some() { "not known" } else { "no number" }),
            ] {
                let empty = outlines(panel, &x_edges, &y_edges, |i, j| {
                    let regime = area.regimes.as_ref().map(|regimes| regimes[[i, j]]);
                    cells[[i, j]].is_nan() && Empty::of(regime) == kind
                });
                if !empty.is_empty() {
                    scene.area(&empty, fill);
                    legend.add(Sample::Area(fill), rich(words));
                }
            }
            if colours.is_some_and(|colours| colours.two_sided) {
                // In greyscale both sides look alike.
                let fill = Fill::hatched("none", Hatch::Falling, "#4a4a4a");
                let negative = outlines(panel, &x_edges, &y_edges, |i, j| cells[[i, j]] < 0.0);
                scene.area(&negative, fill);
                legend.add(Sample::Area(fill), rich("negative"));
            }
        }
    }
}

/// Number of parts of the width and the height of a panel, at least, between which areas follow the curves.
const FINE: usize = 400;

/// Regimes between the nodes, by the curves at which they change; `None` where there are none.
fn finer(panel: &Panel, area: &Area, cells: &Array2<i8>) -> Option<Parts> {
    let curves = area.curves.as_ref().filter(|curves| !curves.curves.is_empty())?;
    let scales = [panel.x, panel.y];
    let axes = area.slice.axes().map(drawn);
    let shares: [Vec<f64>; 2] =
        std::array::from_fn(|i| axes[i].iter().map(|value| scales[i].unit(*value)).collect());
    let codes: Vec<Vec<i8>> = cells.outer_iter().map(|column| column.to_vec()).collect();
    let parts = [0, 1].map(|i| FINE.div_ceil(shares[i].len().saturating_sub(1).max(1)));
    let between = |x: f64, y: f64| area.slice.oscillator(x, y).as_ref().map(regime_code);
    let fine = along_curves(panel, &codes, &shares, parts, &curves.curves, &between);
    (!fine.cells.is_empty()).then_some(fine)
}

/// Why a cell has no kick.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Empty {
    Always,
    Never,
    Unknown,
}

impl Empty {
    /// By the code of the regime.
    fn of(regime: Option<i8>) -> Self {
        let regime = regime.and_then(|code| Regime::ALL.into_iter().find(|regime| regime.code() == code));
        match regime {
            None | Some(Regime::Failed | Regime::Neutral) => Empty::Unknown,
            Some(Regime::Equilibrium) => Empty::Never,
            Some(regime) if !regime.attractors().equilibrium => Empty::Always,
            Some(_) => Empty::Unknown,
        }
    }
}

/// Lines, their look, and their name in the legend, if they are seen.
type Lines = (Vec<Vec<Place>>, Stroke, Option<&'static str>);

/// The lines over the cells of a panel: the exact boundary, and the method's own critical damping.
fn boundaries(area: &Area, panel: &Panel) -> [Lines; 2] {
    let own: Vec<Place> = area.own_edge.iter().map(|&(x, c)| panel.place(x, c)).collect();
    let is_line = own.iter().filter(|place| place.1.is_finite()).count() > 1;
    let exact = area.exact.as_ref().map(|exact| places(exact, panel)).unwrap_or_default();
    let named = (!exact.is_empty()).then_some("exact boundary");
    [(exact, EXACT, named), (vec![own], OWN_EDGE, is_line.then_some("the method's own critical damping"))]
}

fn stroke(scene: &mut Scene, panel: &Panel, lines: &[Vec<Place>], stroke: &Stroke) {
    scene.clipped(panel.rect, |scene| lines.iter().for_each(|line| scene.line(line, stroke)));
}

fn draw_lines(scene: &mut Scene, panel: &Panel, area: &Area, legend: &mut Legend) {
    for (lines, look, name) in boundaries(area, panel) {
        stroke(scene, panel, &lines, &look);
        if let Some(name) = name {
            legend.add(Sample::Line(look), rich(name));
        }
    }
    if let Some(curves) = &area.curves {
        let over_numbers = matches!(area.layer, Layer::Reals(_));
        bifurcations::draw(scene, panel, curves, legend, over_numbers);
    }
    for (number, Marks { name, points }) in area.marks.iter().enumerate() {
        let (marker, colour) = MARKS[number % MARKS.len()];
        // From the units of the figure to those of the map.
        let [across, up] = area.slice.axes().map(|axis| area.slice.view.axis(axis).factor);
        let places = points.iter().map(|[x, y]| panel.place(x / across, y / up));
        for place in places.filter(|place| panel.rect.contains(*place)) {
            scene.marker(marker, place, 4.6, style::WHITE, true);
            scene.marker(marker, place, 3.2, colour, true);
        }
        legend.add(Sample::Mark(marker, colour, true), Rich::foreign(name));
    }
}

impl Area<'_> {
    /// "2 of 3 marks lie outside the figure; write V, then c, in these units", if any do.
    pub(super) fn marks_outside(&self) -> Option<String> {
        let points: Vec<[f64; 2]> = self.marks.iter().flat_map(|marks| marks.points.clone()).collect();
        let [x_edges, y_edges] = self.slice.edges();
        let [across, up] = self.slice.axes().map(|axis| self.slice.view.axis(axis));
        let is_inside = |edges: &[f64], at: f64| (edges[0]..=edges[edges.len() - 1]).contains(&at);
        let lies_inside =
            |[x, y]: &&[f64; 2]| is_inside(&x_edges, x / across.factor) && is_inside(&y_edges, y / up.factor);
        let outside = points.len() - points.iter().filter(lies_inside).count();
        let [across, up] = [across.header(), up.header()];
        (outside > 0).then(|| {
            format!(
                "{outside} of {} marks lie outside the figure; write {across}, then {up}, in these units",
                points.len()
            )
        })
    }
}

/// Draws cells by colour; a run of cells of equal colour in a column is one rectangle.
fn draw_pixels(
    scene: &mut Scene,
    panel: &Panel,
    (x_edges, y_edges): (&[f64], &[f64]),
    cells: &Array2<f64>,
    colours: Colours,
) {
    let step = |value: f64| (!value.is_nan()).then(|| (colours.unit(value) * COLOURS).round());
    let (columns, rows) = cells.dim();
    for i in 0..columns {
        let mut from = 0;
        while from < rows {
            let here = step(cells[[i, from]]);
            let run = (from..rows).take_while(|&j| step(cells[[i, j]]) == here).count();
            if let Some(step) = here {
                let low = panel.place(x_edges[i], y_edges[from]);
                let high = panel.place(x_edges[i + 1], y_edges[from + run]);
                // Slightly wider, so that there is no gap between neighbours.
                let rect = Rect { x: low.0, y: high.1, w: high.0 - low.0 + 0.15, h: low.1 - high.1 + 0.15 };
                scene.pixel(rect, &colours.color(step / COLOURS));
            }
            from += run;
        }
    }
}

/// Draws the colour scale with its numbers and the name of the variable.
fn draw_bar(scene: &mut Scene, bar: Rect, colours: Colours, name: &Rich, numbers: f64) {
    let Rect { x, y, w, h } = bar;
    let step = h / (COLOURS + 1.0);
    for i in 0..=COLOURS as usize {
        let rect = Rect { y: y + h - (i + 1) as f64 * step, h: step + 0.15, ..bar };
        scene.pixel(rect, &colours.color(i as f64 / COLOURS));
    }
    scene.frame(bar, &AXIS);
    for tick in colours.scale.ticks(6) {
        let at = y + h * (1.0 - colours.scale.unit(tick.value));
        scene.line(&[(x + w, at), (x + w + 2.5, at)], &AXIS);
        scene.text((x + w + 4.5, at + 0.36 * SMALL_TEXT), &tick.label, SMALL_TEXT, Anchor::Start);
    }
    scene.text_up((x + w + numbers + 6.0 + TEXT, y + 0.5 * h), name, SMALL_TEXT, Anchor::Middle);
}

/// The coordinates of the cells of a slice, the vertical axis fastest, once for each of `panels`.
pub(super) fn cell_columns(slice: &Slice, panels: usize) -> Data {
    let [x, y] = slice.axes().map(|axis| slice.view.axis(axis));
    let [x_nodes, y_nodes] = slice.nodes();
    let (x_factor, y_factor) = (x.factor, y.factor);
    let cells = x_nodes.iter().flat_map(|a| y_nodes.iter().map(move |b| (a * x_factor, b * y_factor)));
    let (xs, ys): (Vec<f64>, Vec<f64>) = cells.unzip();
    Data::default().reals(x.header(), xs.repeat(panels)).reals(y.header(), ys.repeat(panels))
}

/// The nodes and cells of areas as a table: both axes, the variable, and its errors where they are known; with
/// `panel`, also the axis that differs between the panels, by its header and values.
pub fn data(areas: &[Area], label: &Label, panel: Option<(&str, &[f64])>) -> Data {
    let Some(first) = areas.first() else { return Data::default() };
    let cells = cell_columns(&first.slice, areas.len());
    let mut data = Data::default();
    if let Some((header, values)) = panel {
        let each = |value: &f64| std::iter::repeat_n(*value, cells.rows() / areas.len());
        data = data.reals(header, values.iter().flat_map(each).collect());
    }
    let data = data.join(cells);
    let (mut codes, mut names, mut reals) = (Vec::new(), Vec::new(), Vec::new());
    for area in areas {
        match &area.layer {
            Layer::Codes(cells, kinds) => {
                codes.extend(cells);
                names = kinds.iter().map(|kind| (kind.code, kind.name)).collect();
            }
            Layer::Reals(cells) => reals.extend(cells.iter().map(|value| value * label.factor)),
        }
    }
    let values = if reals.is_empty() { Values::Codes(codes, names) } else { Values::Reals(reals) };
    let data = data.with(label.header(), values);
    let Some((label, _)) = &first.errors else { return data };
    let errors = areas.iter().filter_map(|area| area.errors.as_ref()).flat_map(|(_, errors)| errors);
    data.reals(label.header(), errors.map(|error| error * label.factor).collect())
}

/// The sentence of a caption about the failed ones among what is drawn, cells or verdicts; empty if there are
/// none.
pub(crate) fn failed_words(what: &str, failed: impl Iterator<Item = bool>) -> Rich {
    let (cells, failed) =
        failed.fold((0, 0), |(cells, count), failed| (cells + 1, count + u64::from(failed)));
    match failed {
        0 => Rich::default(),
        _ => rich(&format!(
            " Failed, in black: {} of the {} {what} drawn, for which no answer was found.",
            count(failed),
            count(cells)
        )),
    }
}

//! Slices of the map: one panel per method, with the exact boundary as a curve.

use ndarray::Array2;

use super::super::units::{View, join};
use super::super::{ReportError, SIMULATION};
use super::Figure;
use super::bifurcations::{boundary, places};
use super::palette;
use super::plot::{self, At, Plot};
use super::slice::{Slice, picks};
use slipmap_figure::data::{Data, Values};
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::lines::letter;
use slipmap_figure::panels::{Panel, Panels};
use slipmap_figure::region::outlines;
use slipmap_figure::scene::{Fill, Place, Scene, Stroke, Width};
use slipmap_figure::style;
use slipmap_figure::text::{Rich, rich};
use slipmap_format::MapFile;
use slipmap_map::map::{Axis, PlaneCurves, Verdict};
use slipmap_numbers::text::count;
pub(super) use slipmap_page::curves::{EXACT, HALO};
use slipmap_simulate::critical_damping;

/// Fewest nodes of both axes of an area. Two nodes would fill half of it each, as if what lies between had
/// been computed; they are drawn as rows instead.
pub(super) const FEWEST_NODES: usize = 3;

/// Largest number of eps with slices of their own.
const MOST_EPSILONS: usize = 4;

/// The critical damping of the method whose panel it is.
const OWN_EDGE: Stroke = Stroke { color: style::BLACK, width: 1.0, dash: &[2.0, 1.6] };

/// Meaning of a cell in a method's panel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Claim {
    Verdict(Verdict),
    WrongPresence,
    WrongAbsence,
}

impl Claim {
    const ALL: [Claim; 7] = [
        Claim::Verdict(Verdict::Present),
        Claim::Verdict(Verdict::Absent),
        Claim::Verdict(Verdict::Undecided),
        Claim::WrongPresence,
        Claim::WrongAbsence,
        Claim::Verdict(Verdict::Failed),
        Claim::Verdict(Verdict::NotComputed),
    ];

    fn is_wrong(self) -> bool {
        matches!(self, Claim::WrongPresence | Claim::WrongAbsence)
    }

    fn of(method: i8, simulation: Option<i8>) -> Self {
        let (present, absent) = (Verdict::Present.code(), Verdict::Absent.code());
        match simulation {
            Some(simulation) if method == present && simulation == absent => Claim::WrongPresence,
            Some(simulation) if method == absent && simulation == present => Claim::WrongAbsence,
            _ => Claim::Verdict(Verdict::of_code(method).unwrap_or(Verdict::Failed)),
        }
    }

    /// Its fill, and its name in legends.
    fn look(self) -> (Fill, Rich) {
        match self {
            Claim::Verdict(verdict) => {
                let kind = palette::verdict(verdict);
                (kind.fill, rich(&kind.words))
            }
            Claim::WrongPresence => (palette::WRONG_PRESENCE, rich("wrong: claims a cycle")),
            Claim::WrongAbsence => (palette::WRONG_ABSENCE, rich("wrong: denies a cycle")),
        }
    }
}

/// The plane of a map in which verdicts change most visibly: horizontally the longest axis among the law's
/// and V, vertically c; the two longest axes if c has too few nodes for an area, and they have enough.
pub(crate) fn main_plane(map: &MapFile) -> (usize, usize) {
    let axes = map.grid().axes();
    let c = axes.len() - 1;
    let mut others: Vec<usize> = (0..c).collect();
    // The longest first; among equally long ones the fastest, which is V, then the law's last parameter.
    let epsilon = map.grid().epsilon_axis();
    let is_epsilon = |axis: usize| epsilon == Some(axis);
    others.sort_by_key(|&axis| (std::cmp::Reverse((axes[axis].values.len(), !is_epsilon(axis))), c - axis));
    let longest = others.iter().copied().find(|&axis| !is_epsilon(axis) || axes[axis].values.len() > 1);
    let longest = longest.unwrap_or(others[0]);
    let second = others.iter().copied().find(|&axis| axis != longest).unwrap_or(c);
    let nodes = |axis: usize| axes[axis].values.len();
    if nodes(c) >= FEWEST_NODES || nodes(c) > 1 && nodes(second) < FEWEST_NODES {
        return (longest, c);
    }
    (second.min(longest), second.max(longest))
}

/// The eps at which slices are drawn: all, or evenly selected ones.
pub(crate) fn chosen_epsilons(map: &MapFile) -> Vec<usize> {
    let count = map.grid().epsilons().len();
    if count <= MOST_EPSILONS {
        return (0..count).collect();
    }
    (0..MOST_EPSILONS).map(|i| i * (count - 1) / (MOST_EPSILONS - 1)).collect()
}

/// The eps of the panels of a figure: [`chosen_epsilons`], or that of `index` alone if eps is among the axes
/// `shown`.
pub(crate) fn panel_epsilons(map: &MapFile, index: &[usize], shown: &[usize]) -> Vec<usize> {
    match map.grid().epsilon_axis() {
        Some(axis) if shown.contains(&axis) => vec![index[axis]],
        _ => chosen_epsilons(map),
    }
}

pub(crate) fn verdict_panels(view: &View, width: Width) -> Result<Vec<Figure>, ReportError> {
    let map = view.map;
    let axes = map.grid().axes();
    let c = axes.len() - 1;
    let (x, y) = main_plane(map);
    let index = view.informative_nodes();
    let nodes = |axis: usize| axes[axis].values.len();
    if nodes(x).min(nodes(y)) < FEWEST_NODES {
        let (over, other) = if nodes(x) >= nodes(y) { (x, y) } else { (y, x) };
        return over_one_axis(view, over, other, &index, width);
    }
    let mut planes = vec![(x, y, index.clone())];
    // A second plane, across the law's parameters and V at fixed c.
    let epsilon = map.grid().epsilon_axis();
    let is_other = |&axis: &usize| Some(axis) != epsilon && nodes(axis) >= FEWEST_NODES && axis != x;
    let mut others: Vec<usize> = (0..c).filter(is_other).collect();
    others.sort_by_key(|&axis| std::cmp::Reverse(nodes(axis)));
    if let (Some(&second), true) = (others.first(), y == c && Some(x) != epsilon) {
        let mut index = index;
        index[c] = informative_damping(map, &index);
        planes.push((x.min(second), x.max(second), index));
    }
    let mut slices = Vec::new();
    for (x, y, index) in planes {
        let epsilons = panel_epsilons(map, &map.grid().at_epsilon(&index, 0), &[x]);
        slices.extend(
            epsilons
                .into_iter()
                .map(|epsilon| Slice::new(view, x, y, map.grid().at_epsilon(&index, epsilon))),
        );
    }
    // A plane that has no cycle anywhere is drawn only if there is no other.
    if map.methods().iter().any(|method| method.name() == SIMULATION) {
        let codes = slices.iter().map(|slice| slice.codes(&format!("verdict_{SIMULATION}")));
        let codes = codes.collect::<Result<Vec<_>, _>>()?;
        let may_have_one = |codes: &Array2<i8>| codes.iter().any(|code| *code != Verdict::Absent.code());
        if codes.iter().any(may_have_one) {
            let mut kept = codes.iter().map(may_have_one);
            slices.retain(|_| kept.next() == Some(true));
        } else {
            slices.truncate(1);
        }
    }
    slices.iter().map(|slice| figure(slice, width)).collect()
}

/// The node of c for a plane of fixed c: near half of the critical damping in its middle.
fn informative_damping(map: &MapFile, index: &[usize]) -> usize {
    let axes = map.grid().axes();
    let root = map.grid().column(index).ok().and_then(|column| critical_damping(&column, 1e-6).ok());
    let positive = root.filter(|root| root.c > 0.0);
    positive.map_or(0, |root| axes[axes.len() - 1].nearest(0.5 * root.c))
}

/// The end of the name of a slice, "-epsilon-0.1", with as few digits as tell the nodes apart; empty if there is one.
fn epsilon_name(axis: &Axis, node: usize) -> String {
    if axis.values.len() == 1 {
        return String::new();
    }
    let rounded = |value: f64, digits: usize| format!("{value:.digits$e}").parse().unwrap_or(value);
    let apart = |digits: &usize| {
        axis.values.windows(2).all(|pair| rounded(pair[0], *digits) < rounded(pair[1], *digits))
    };
    let digits = (3..16).find(apart).unwrap_or(16);
    format!("-epsilon-{}", rounded(axis.values[node], digits))
}

/// Verdicts of every method over one axis, with rows for the nodes of the `other` one, which has too few for
/// an area; one figure for each eps.
fn over_one_axis(
    view: &View,
    over: usize,
    other: usize,
    index: &[usize],
    width: Width,
) -> Result<Vec<Figure>, ReportError> {
    let (map, axes) = (view.map, view.map.grid().axes());
    if axes[over].values.len() < 2 {
        return Ok(Vec::new());
    }
    let variables: Vec<String> =
        map.methods().iter().map(|method| format!("verdict_{}", method.name())).collect();
    let epsilons = panel_epsilons(map, index, &[other, over]);
    let figure = |&epsilon: &usize| {
        let index = map.grid().at_epsilon(index, epsilon);
        let at = |(i, axis): (usize, &Axis)| {
            let nodes = match i {
                _ if i == other => axis.values.clone(),
                _ => vec![axis.values[index[i]]],
            };
            (axis.name.clone(), nodes.iter().map(|node| node * view.axis(axis).factor).collect())
        };
        let at: Vec<At> = axes.iter().enumerate().filter(|(i, _)| *i != over).map(at).collect();
        let (x, variables) = (&axes[over].name, &variables[..]);
        let wanted = Plot { x, y: None, at: &at, variables, panels: None, curves: false, marks: None, width };
        let name = match other == 0 || over == 0 {
            true => format!("slice-{x}"),
            false => format!("slice-{x}{}", epsilon_name(&axes[0], epsilon)),
        };
        plot::figure(view, name, &wanted)
    };
    epsilons.iter().map(figure).collect()
}

/// The stored damping up to which a method claims the cycle, over the nodes of a slice with c as the vertical
/// axis: (x, c).
fn stored_edge(slice: &Slice, method: &str) -> Result<Vec<(f64, f64)>, ReportError> {
    let (map, variable) = (slice.view.map, slice.view.map.critical(method));
    let damping = map.grid().axes().len() - 1;
    if slice.y != damping || !map.has(&variable) {
        return Ok(Vec::new());
    }
    let edge = map.real_slice(&variable, &picks(map, &[slice.x], &slice.index, damping))?;
    let [x_nodes, _] = slice.nodes();
    Ok(x_nodes.into_iter().zip(edge.iter().copied()).collect())
}

/// Whether there is a boundary to draw among the points returned by [`stored_edge`].
fn has_edge(edge: &[(f64, f64)]) -> bool {
    edge.iter().filter(|(_, c)| c.is_finite()).count() > 1
}

fn figure(slice: &Slice, width: Width) -> Result<Figure, ReportError> {
    let map = slice.view.map;
    let methods = map.methods();
    let codes = methods
        .iter()
        .map(|method| slice.codes(&format!("verdict_{}", method.name())))
        .collect::<Result<Vec<_>, _>>()?;
    let edges = methods
        .iter()
        .map(|method| match method.name() == SIMULATION {
            // Its panel shows the exact boundary.
            true => Ok(Vec::new()),
            false => stored_edge(slice, method.name()),
        })
        .collect::<Result<Vec<_>, _>>()?;
    let simulation = methods.iter().position(|method| method.name() == SIMULATION);
    let [x, y] = slice.axes();
    let [(x_scale, x_name), (y_scale, y_name)] = slice.scales();
    let [x_edges, y_edges] = slice.edges();
    let claim = |method: usize, i: usize, j: usize| {
        Claim::of(codes[method][[i, j]], simulation.map(|simulation| codes[simulation][[i, j]]))
    };
    let undecided = |cells: &Array2<i8>| cells.iter().all(|code| *code == Verdict::Undecided.code());
    // Methods that are undecided everywhere are listed by name instead of drawn as panels.
    let (empty, shown): (Vec<usize>, Vec<usize>) = (0..methods.len()).partition(|&m| undecided(&codes[m]));
    let (empty, shown) = if shown.is_empty() { (shown, empty) } else { (empty, shown) };
    let left_out = join(empty.iter().map(|&m| method_title(methods[m].name())));
    let words = |text: &str| match empty.is_empty() {
        true => Rich::default(),
        false => rich(text).then(left_out.clone()),
    };
    let held = slice.held();
    let heading = join([held.clone(), words("not drawn, because undecided everywhere: ")]);
    let looks = Claim::ALL.map(Claim::look);
    let exact = boundary(slice);
    let mut scene = Scene::new(width.points(), 0.0);
    let columns = width.select(2, 4);
    let panels = Panels::below(&mut scene, &heading, columns, shown.len(), 0.78, (x_scale, y_scale));
    let mut used = vec![false; looks.len()];
    let mut edged = false;
    for (number, (&m, panel)) in shown.iter().zip(&panels.panels).enumerate() {
        let mut draw = |scene: &mut Scene, wrong: bool| {
            for (n, known) in Claim::ALL.into_iter().enumerate().filter(|(_, it)| it.is_wrong() == wrong) {
                let areas = outlines(panel, &x_edges, &y_edges, |i, j| claim(m, i, j) == known);
                used[n] |= !areas.is_empty();
                scene.area(&areas, looks[n].0);
            }
        };
        let edge: Vec<Place> = edges[m].iter().map(|&(x, c)| panel.place(x, c)).collect();
        edged |= has_edge(&edges[m]);
        let (edge, curves) = ([edge], places(&exact, panel));
        draw(&mut scene, false);
        draw_lines(&mut scene, &edge, panel, &HALO);
        draw_lines(&mut scene, &curves, panel, &HALO);
        draw(&mut scene, true);
        draw_lines(&mut scene, &edge, panel, &OWN_EDGE);
        draw_lines(&mut scene, &curves, panel, &EXACT);
        panel.title(&mut scene, &letter(number).then(method_title(methods[m].name())));
    }
    panels.axes(&mut scene, &x_name, &y_name);
    let mut legend = Legend::default();
    legend.add_used(&looks, &used);
    if !exact.curves.is_empty() {
        legend.add(Sample::Line(EXACT), rich("exact boundary"));
    }
    if edged {
        legend.add(Sample::Line(OWN_EDGE), rich("the method's own critical damping"));
    }
    legend.below(&mut scene, panels.panels[0].rect.x, panels.bottom);
    let epsilon = match map.grid().epsilon_axis() {
        Some(axis) if axis != slice.x => epsilon_name(&map.grid().axes()[axis], slice.index[axis]),
        _ => String::new(),
    };
    let label = |axis| slice.view.axis(axis);
    let mut data = cell_columns(slice, 1);
    let names: Vec<(i8, &'static str)> =
        Verdict::ALL.map(|verdict| (verdict.code(), verdict.name())).to_vec();
    for (method, codes) in methods.iter().zip(&codes) {
        let header = format!("verdict_{}", method.name());
        data = data.with(header, Values::Codes(codes.iter().copied().collect(), names.clone()));
    }
    Ok(Figure {
        name: format!("slice-{}-{}{epsilon}", x.name, y.name),
        caption: rich("Verdicts of each method over ")
            .then(label(x).name)
            .then(" and ")
            .then(label(y).name)
            .then(" at ")
            .then(held)
            .then(match !exact.curves.is_empty() {
                true => ". Black curve: the exact boundary of the stick-slip region, by continuation.",
                false => {
                    ". Without the exact boundary: there is none here, or to find it would take too long. slipmap plot \
                     --curves follows it."
                }
            })
            .then(words(" Not drawn, because undecided in every cell of this plane: "))
            .then(rich(if empty.is_empty() { "" } else { "." }))
            .then(slice.thinned_words())
            .then(failed_words("verdicts", codes.iter().flatten().map(|code| *code == Verdict::Failed.code()))),
        scene,
        data,
    })
}

/// The sentence of a caption about the failed ones among what is drawn, cells or verdicts; empty if there are
/// none.
pub(super) fn failed_words(what: &str, failed: impl Iterator<Item = bool>) -> Rich {
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

/// The coordinates of the cells of a slice, the vertical axis fastest, once for each of `panels`.
pub(super) fn cell_columns(slice: &Slice, panels: usize) -> Data {
    let [x, y] = slice.axes().map(|axis| slice.view.axis(axis));
    let [x_nodes, y_nodes] = slice.nodes();
    let (x_factor, y_factor) = (x.factor, y.factor);
    let cells = x_nodes.iter().flat_map(|a| y_nodes.iter().map(move |b| (a * x_factor, b * y_factor)));
    let (xs, ys): (Vec<f64>, Vec<f64>) = cells.unzip();
    Data::default().reals(x.header(), xs.repeat(panels)).reals(y.header(), ys.repeat(panels))
}

pub(super) fn method_title(name: &str) -> Rich {
    Rich::foreign(&name.replace('_', " "))
}

/// Draws the exact boundary of a slice into its panel.
pub(super) fn draw_exact(scene: &mut Scene, exact: &PlaneCurves, panel: &Panel) {
    let curves = places(exact, panel);
    [HALO, EXACT].iter().for_each(|stroke| draw_lines(scene, &curves, panel, stroke));
}

fn draw_lines(scene: &mut Scene, curves: &[Vec<Place>], panel: &Panel, stroke: &Stroke) {
    scene.clipped(panel.rect, |scene| curves.iter().for_each(|curve| scene.line(curve, stroke)));
}

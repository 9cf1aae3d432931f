//! Slices of the map: one panel per method, with the exact boundary as a curve.

use ndarray::Array2;

use super::super::view::View;
use super::super::{ReportError, SIMULATION};
use super::Figure;
use super::area::{self, Area, Layer, cell_columns, failed_words};
use super::bifurcations::boundary;
use super::plot::{self, At, Plot};
use super::slice::{FEWEST_NODES, Slice, main_plane, picks};
use slipmap_column::{Verdict, critical_damping};
use slipmap_figure::data::Values;
use slipmap_figure::lines::letter;
use slipmap_figure::scene::{Fill, Width};
use slipmap_figure::text::join;
use slipmap_figure::text::{Rich, rich};
use slipmap_format::MapFile;
use slipmap_map::Axis;
use slipmap_page::palette::{self, CellKind};
use slipmap_page::units::Label;

/// Largest number of eps with slices of their own.
const MOST_EPSILONS: usize = 4;

/// Codes of wrong verdicts, beside those of [`Verdict`].
const WRONG_PRESENCE: i8 = 10;
const WRONG_ABSENCE: i8 = 11;

/// The kinds of cells in the panel of a method, in the order of the legend.
fn claims() -> Vec<CellKind> {
    let wrong =
        |code: i8, fill: Fill, words: &'static str| CellKind { code, name: "", fill, words: words.into() };
    let [present, absent, undecided, failed, not_computed] =
        [Verdict::Present, Verdict::Absent, Verdict::Undecided, Verdict::Failed, Verdict::NotComputed]
            .map(palette::verdict);
    let presence = wrong(WRONG_PRESENCE, palette::WRONG_PRESENCE, "wrong: claims a cycle");
    let absence = wrong(WRONG_ABSENCE, palette::WRONG_ABSENCE, "wrong: denies a cycle");
    vec![present, absent, undecided, presence, absence, failed, not_computed]
}

/// The code of a cell among [`claims`], by the verdicts of the method and of the simulation.
fn claim(method: i8, simulation: i8) -> i8 {
    let (present, absent) = (Verdict::Present.code(), Verdict::Absent.code());
    match simulation {
        _ if method == present && simulation == absent => WRONG_PRESENCE,
        _ if method == absent && simulation == present => WRONG_ABSENCE,
        _ => method,
    }
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
        let wanted = Plot { x, y: None, at: &at, variables, panels: None, curves: false, marks: &[], width };
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

fn figure(slice: &Slice, width: Width) -> Result<Figure, ReportError> {
    let map = slice.view.map;
    let methods = map.methods();
    let codes = methods
        .iter()
        .map(|method| slice.codes(&format!("verdict_{}", method.name())))
        .collect::<Result<Vec<_>, _>>()?;
    let simulation = methods.iter().position(|method| method.name() == SIMULATION);
    let [x, y] = slice.axes();
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
    let exact = boundary(slice);
    let area = |(number, &m): (usize, &usize)| -> Result<Area, ReportError> {
        let mut cells = codes[m].clone();
        if let Some(simulation) = simulation {
            cells.zip_mut_with(&codes[simulation], |code, simulated| *code = claim(*code, *simulated));
        }
        let own_edge = match simulation == Some(m) {
            // Its panel shows the exact boundary.
            true => Vec::new(),
            false => stored_edge(slice, methods[m].name())?,
        };
        let title = letter(number).then(method_title(methods[m].name()));
        let layer = Layer::Codes(cells, claims());
        Ok(Area { exact: Some(exact.clone()), own_edge, title, ..Area::new(slice.clone(), layer) })
    };
    let areas = shown.iter().enumerate().map(area).collect::<Result<Vec<_>, _>>()?;
    let scene = area::draw(&areas, &heading, &Label::default(), false, width);
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

pub(super) fn method_title(name: &str) -> Rich {
    Rich::foreign(&name.replace('_', " "))
}

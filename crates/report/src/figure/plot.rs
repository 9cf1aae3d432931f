//! Plots of variables of a map: areas over a plane, curves or strips over one axis.

use std::borrow::Cow;
use std::sync::atomic::AtomicBool;

use super::super::view::View;
use super::super::{ReportError, SIMULATION};
use super::Figure;
use super::area::{self, Area, Layer, Marks, failed_words};
use super::bifurcations::boundary;
use super::slice::{
    ChoiceError, Held, Slice, drawn, errors_of, find_axis, hold, main_plane, middle, nearest_node, picks_of,
    step,
};
use slipmap_figure::axis::Scale;
use slipmap_figure::data::{Data, Values};
use slipmap_figure::lines::{self, Chart, Curve};
use slipmap_figure::scene::{Scene, Width};
use slipmap_figure::strips::{self, Strip};
use slipmap_figure::style;
use slipmap_figure::text::join;
use slipmap_figure::text::{Rich, rich};
use slipmap_format::{MapFile, Pick};
use slipmap_machine::Friction;
use slipmap_map::dataset::auxiliary::{PROBABILITIES, PROBABILITY};
use slipmap_map::{Field, Plane, PlaneCurves};
use slipmap_numbers::text::short;
use slipmap_page::palette::{CellKind, kinds};
use slipmap_page::units::kind_of_variable;

/// Values of fixed axes, by name, in the units of the view.
pub type At = (String, Vec<f64>);

#[derive(Clone, Debug)]
pub struct Plot<'a> {
    pub x: &'a str,
    /// Name of the vertical axis; without one, or if one of the two has a single node, variables are drawn
    /// over the other axis.
    pub y: Option<&'a str>,
    /// Values of the other axes. One of them may have several values if there is no vertical axis: each is a
    /// curve.
    pub at: &'a [At],
    /// The variables, of which only one can be drawn over a plane; none means the verdict of the simulation,
    /// or else of the first method.
    pub variables: &'a [String],
    /// An axis with a panel for each of these values.
    pub panels: Option<&'a At>,
    /// Whether to find the curves of codimension one if the map does not store them; those that it stores are
    /// drawn in any case.
    pub curves: bool,
    /// Points of other origin, marked over a plane: in the units of its axes, with their names.
    pub marks: &'a [Marks],
    pub width: Width,
}

#[derive(Clone, Debug)]
pub struct Plotted {
    pub scene: Scene,
    pub caption: Rich,
    pub data: Data,
    /// The nodes of the other axes.
    pub held: Vec<Held>,
    /// Axes of which not all nodes are drawn, with n where one node in n is.
    pub thinned: Vec<(String, usize)>,
    /// The curves of codimension one of the first panel, if they are stored or were requested.
    pub curves: Option<PlaneCurves>,
    pub notes: Vec<String>,
}

/// Plots variables of a map.
///
/// # Errors
/// [`ReportError::Choice`] for names that the map does not have and for choices that do not fit together,
/// [`ReportError::Map`] if it cannot be read.
pub fn plot(view: &View, plot: &Plot) -> Result<Plotted, ReportError> {
    let x = find_axis(view, plot.x)?;
    let y = plot.y.map(|name| find_axis(view, name)).transpose()?;
    let axes = view.map.grid().axes();
    let single = |axis: usize| axes[axis].values.len() < 2;
    match y {
        Some(y) if x == y => Err(ChoiceError::SameAxis(axes[x].name.clone()).into()),
        Some(y) if single(x) || single(y) => {
            let (shown, other) = if single(x) { (y, x) } else { (x, y) };
            if plot.curves && !View::finds_curves(plot.variables.first().map(String::as_str)) {
                return Err(ChoiceError::OneNode(axes[other].name.clone()).into());
            }
            let mut plotted = over_axis(view, plot, shown)?;
            let [shown, other] = [shown, other].map(|axis| &axes[axis].name);
            let without = if !plot.marks.is_empty() { ", without marks" } else { "" };
            plotted.notes.push(format!("{other} has one node: drawn over {shown} alone{without}"));
            Ok(plotted)
        }
        Some(y) => over_plane(view, plot, x, y),
        None => over_axis(view, plot, x),
    }
}

/// A plot as a figure of a report.
pub(crate) fn figure(view: &View, name: String, wanted: &Plot) -> Result<Figure, ReportError> {
    let Plotted { scene, caption, data, .. } = plot(view, wanted)?;
    Ok(Figure { name, caption, scene, data })
}

/// A figure of a report: a variable, or the default one, over two axes, with the others at the nodes `index`.
pub(crate) fn over_nodes(
    view: &View,
    name: String,
    variable: Option<&str>,
    [x, y]: [usize; 2],
    index: &[usize],
    width: Width,
) -> Result<Figure, ReportError> {
    let axes = view.map.grid().axes();
    let held = axes.iter().zip(index).enumerate().filter(|(axis, _)| *axis != x && *axis != y);
    let at =
        held.map(|(_, (axis, &node))| (axis.name.clone(), vec![axis.values[node] * view.axis(axis).factor]));
    let (at, variables): (Vec<At>, Vec<String>) =
        (at.collect(), variable.map(str::to_owned).into_iter().collect());
    let (x, y) = (&axes[x].name, Some(axes[y].name.as_str()));
    let wanted = Plot {
        x,
        y,
        at: &at,
        variables: &variables,
        panels: None,
        curves: View::finds_curves(variable),
        marks: &[],
        width,
    };
    figure(view, name, &wanted)
}

/// Whether one of two axes has several nodes.
fn is_drawn(view: &View, plane: [usize; 2]) -> bool {
    plane.iter().any(|axis| view.map.grid().axes()[*axis].values.len() > 1)
}

/// The probability that a machine with uncertain quantities may stick-slip, over belt speed and damping;
/// `None` for a map without it, and for one of a single cell.
pub(crate) fn probability(view: &View, width: Width) -> Result<Option<Figure>, ReportError> {
    let axes = view.map.grid().axes();
    let plane = [axes.len() - 2, axes.len() - 1];
    if !view.map.has_probability() || !is_drawn(view, plane) {
        return Ok(None);
    }
    over_nodes(view, "probability".into(), Some(PROBABILITY), plane, &middle(axes), width).map(Some)
}

/// The regimes over the plane of the other figures; `None` for a map without them, for one of a single cell, and for one
/// with curves, of which [`super::curve_planes`] draws the regimes.
pub(crate) fn regimes(view: &View, width: Width) -> Result<Option<Figure>, ReportError> {
    let (map, (x, y)) = (view.map, main_plane(view.map));
    if !map.has("regime") || !map.curves().is_empty() || !is_drawn(view, [x, y]) {
        return Ok(None);
    }
    over_nodes(view, "regimes".into(), Some("regime"), [x, y], &view.informative_nodes(), width).map(Some)
}

/// The requested variables, or the default one.
fn variables<'a>(map: &'a MapFile, requested: &'a [String]) -> Result<Vec<&'a str>, ChoiceError> {
    let default = format!("verdict_{SIMULATION}");
    let probability = map.has_probability().then_some(PROBABILITIES);
    let names: Vec<&str> = map.variables().chain(probability.into_iter().flatten()).collect();
    if let Some(name) = requested.iter().find(|name| !names.contains(&name.as_str())) {
        return Err(match Field::of_variable(name) {
            Some((field, _)) if field != Field::Verdict => ChoiceError::NotStored {
                variable: name.clone(),
                field: field.name_for(map.grid().machine().is_some()),
            },
            _ => ChoiceError::unknown("variable", name, names.iter().copied()),
        });
    }
    if requested.is_empty() {
        let mut names = map.variables();
        let chosen = map.variables().find(|name| *name == default).or_else(|| names.next());
        return Ok(chosen.into_iter().collect());
    }
    Ok(requested.iter().map(String::as_str).collect())
}

/// One value for every fixed axis.
pub fn one_each(at: &[At]) -> Result<Vec<(String, f64)>, ChoiceError> {
    at.iter()
        .map(|(name, values)| match values[..] {
            [value] => Ok((name.clone(), value)),
            _ => Err(ChoiceError::SeveralValues(name.clone())),
        })
        .collect()
}

/// An axis that has several panels or curves, and its node in one of them; `None` where there is only one.
type Chosen = Option<(usize, usize)>;

/// The choices of the axis of panels or curves, which is then shown.
fn choose(view: &View, at: Option<&At>, shown: &mut Vec<usize>) -> Result<Vec<Chosen>, ChoiceError> {
    let Some((name, values)) = at else { return Ok(vec![None]) };
    let axis = find_axis(view, name)?;
    if shown.contains(&axis) {
        return Err(ChoiceError::Shown(name.clone()));
    }
    shown.push(axis);
    values.iter().map(|value| nearest_node(view, axis, *value).map(|node| Some((axis, node)))).collect()
}

/// "ε = 0.1", of a choice.
fn chosen_words(view: &View, (axis, node): (usize, usize)) -> Rich {
    let axis = &view.map.grid().axes()[axis];
    view.axis(axis).equals(axis.values[node])
}

fn over_plane(view: &View, plot: &Plot, x: usize, y: usize) -> Result<Plotted, ReportError> {
    let map = view.map;
    let names = variables(map, plot.variables)?;
    let [variable] = names[..] else { return Err(ChoiceError::SeveralVariables.into()) };
    let at = one_each(plot.at)?;
    let (index, held) = hold(view, &[x, y], &at)?;
    let mut shown = vec![x, y];
    let panels = choose(view, plot.panels, &mut shown)?;
    let axes = map.grid().axes();
    // Critical dampings do not depend on the damping.
    let no_damping = Field::is_critical(variable);
    shown.extend(no_damping.then_some(axes.len() - 1));
    let held: Vec<Held> = held
        .into_iter()
        .filter(|held| shown.iter().all(|&axis| view.axis(&axes[axis]).header() != held.axis))
        .collect();
    let label = view.units.variable(variable);
    let mut areas = Vec::new();
    for (number, panel) in panels.iter().enumerate() {
        let mut index = index.clone();
        let mut title = Rich::default();
        if let Some((axis, node)) = *panel {
            index[axis] = node;
            title = lines::letter(number).then(chosen_words(view, (axis, node)));
        }
        let slice = Slice::new(view, x, y, index);
        let layer = match kinds(variable) {
            Some(kinds) => Layer::Codes(slice.codes(variable)?, kinds),
            None => Layer::Reals(slice.reals(variable)?),
        };
        let errors = slice.errors(variable)?;
        let is_kick =
            map.has("regime") && Field::of_variable(variable).is_some_and(|(field, _)| field == Field::Basin);
        let regimes = if is_kick { Some(slice.codes("regime")?) } else { None };
        let plane = slice.plane();
        let curves = stored(map, &plane)
            .or_else(|| plot.curves.then(|| PlaneCurves::of(map.grid(), plane, &AtomicBool::new(false))));
        let exact = (curves.is_none() && variable.starts_with("verdict_")).then(|| boundary(&slice));
        areas.push(Area {
            errors,
            curves,
            exact,
            regimes,
            marks: plot.marks,
            title,
            ..Area::new(slice, layer)
        });
    }
    let first = &areas[0];
    let at = view.held(&first.slice.index, &shown);
    let heading = join([named(view, label.name.clone()), at.clone()]);
    let scene = area::draw(&areas, &heading, &label, variable.starts_with("margin_"), plot.width);
    let mut caption = label
        .name
        .clone()
        .then(" over ")
        .then(view.axis(&axes[x]).name)
        .then(" and ")
        .then(view.axis(&axes[y]).name)
        .taken_at(at)
        .then(".")
        .then(first.slice.thinned_words())
        .then(failed_words("cells", areas.iter().flat_map(Area::failed)));
    if areas.iter().any(|area| area.curves.as_ref().is_some_and(|curves| !curves.curves.is_empty())) {
        caption = caption.then(" Lines: where the long-run behaviour changes, by continuation.");
    }
    let cut = areas.iter().find_map(|area| area.curves.as_ref()?.cut_in_words());
    if let Some(words) = &cut {
        caption = caption.then(Rich::foreign(&format!(" {words}.")));
    }
    let value = |&(axis, node): &(usize, usize)| axes[axis].values[node] * view.axis(&axes[axis]).factor;
    let values: Vec<f64> = panels.iter().flatten().map(value).collect();
    let header = panels[0].map(|(axis, _)| view.axis(&axes[axis]).header());
    let data = area::data(&areas, &label, header.as_deref().map(|header| (header, values.as_slice())));
    let thinned = first.slice.thinned().map(|(axis, step)| (axis.name.clone(), step)).collect();
    let outside = first.marks_outside();
    let curves = areas.swap_remove(0).curves;
    let mut notes = moved(view, plot.panels, &panels);
    notes.extend(cut);
    notes.extend(outside);
    for (axis, other) in [(x, y), (y, x)].into_iter().filter(|(axis, _)| axes[*axis].values.len() == 2) {
        let (few, [first, second]) = (view.axis(&axes[axis]), [0, 1].map(|i| axes[axis].values[i]));
        let [first, second] = [first, second].map(|node| short(node * few.factor));
        let other = view.axis(&axes[other]).key;
        notes.push(format!(
            "{few} has 2 nodes, and each fills half of the figure; to draw a row or a curve for each: --x {other} --at \
             {few}={first},{second}",
            few = few.key
        ));
    }
    Ok(Plotted { scene, caption, data, held, thinned, curves, notes })
}

/// Largest number of characters of a title in a heading, which has one line for it.
const MOST_OF_TITLE: usize = 30;

/// What is drawn, of a machine with its title and the values of the names in its formula.
fn named(view: &View, what: Rich) -> Rich {
    let grid = view.map.grid();
    let (Some(machine), Some(title)) = (grid.machine(), view.map.text("title")) else { return what };
    // The subject of a long title: what is before its first colon or comma.
    let subject =
        title.split([':', ',']).next().filter(|_| title.chars().count() > MOST_OF_TITLE).unwrap_or(title);
    if subject.chars().count() > MOST_OF_TITLE {
        return what;
    }
    let of_formula: Vec<&str> = match &machine.friction {
        Friction::Formula(formula, _) => formula.parameters().iter().map(|of| of.name).collect(),
        _ => Vec::new(),
    };
    let values = grid.fixed().into_iter().filter(|(name, _)| of_formula.contains(name));
    let values =
        values.map(|(name, value)| Rich::foreign(&format!("{name} = ")).then(Rich::number(value, 4)));
    join(std::iter::once(Rich::foreign(subject).then(": ").then(what)).chain(values))
}

/// A note for each requested value of an axis that was replaced by the nearest node.
fn moved(view: &View, wanted: Option<&At>, chosen: &[Chosen]) -> Vec<String> {
    let note = |(wanted, &(axis, node)): (&f64, &(usize, usize))| {
        let axis = &view.map.grid().axes()[axis];
        let label = view.axis(axis);
        let used = axis.values[node] * label.factor;
        let same = (used - wanted).abs() <= ROUNDING * wanted.abs().max(used.abs());
        (!same)
            .then(|| format!("{} = {}: the node nearest to {}", label.header(), short(used), short(*wanted)))
    };
    let wanted = wanted.into_iter().flat_map(|(_, values)| values);
    wanted.zip(chosen.iter().flatten()).filter_map(note).collect()
}

/// Relative size of round-off in the conversion of units and in decimal input.
const ROUNDING: f64 = 1e-9;

fn stored(map: &MapFile, plane: &Plane) -> Option<PlaneCurves> {
    map.curves().iter().find_map(|curves| match &curves.plane {
        same if same == plane => Some(curves.clone()),
        turned if *turned == plane.turned() => Some(curves.turned()),
        _ => None,
    })
}

/// A curve over one axis: a variable at the nodes `index` of the other axes, in the panel with this number.
struct Line<'a> {
    variable: &'a str,
    index: Vec<usize>,
    panel: usize,
    /// The value of the axis for which there are several curves.
    value: Option<Rich>,
}

impl Line<'_> {
    /// Its name in the legend, with the variable only if there are several.
    fn name(&self, view: &View, with_variable: bool) -> Rich {
        let variable = with_variable.then(|| view.units.variable(self.variable).name);
        join(variable.into_iter().chain(self.value.clone()))
    }
}

fn over_axis(view: &View, plot: &Plot, x: usize) -> Result<Plotted, ReportError> {
    let map = view.map;
    let axes = map.grid().axes();
    if axes[x].values.len() < 2 {
        return Err(ChoiceError::NothingToDraw(axes[x].name.clone()).into());
    }
    let names = variables(map, plot.variables)?;
    let without_damping = names.iter().all(|name| Field::is_critical(name));
    // The axes with several values, each with a curve or a panel.
    let several: Vec<&At> = plot.at.iter().filter(|(_, values)| values.len() != 1).collect();
    if let [_, (second, _), ..] = several[..] {
        return Err(ChoiceError::SeveralValues(second.clone()).into());
    }
    let single: Vec<At> = plot.at.iter().filter(|(_, values)| values.len() == 1).cloned().collect();
    let mut shown = vec![x];
    let curves = choose(view, several.first().copied(), &mut shown)?;
    let panels = choose(view, plot.panels, &mut shown)?;
    let (index, mut held) = hold(view, &shown, &one_each(&single)?)?;
    if without_damping {
        let damping = view.axis(&axes[axes.len() - 1]).header();
        held.retain(|held| held.axis != damping);
        shown.push(axes.len() - 1);
    }
    let mut lines = Vec::new();
    let words = |chosen: &Chosen| chosen.map(|chosen| chosen_words(view, chosen));
    for (panel, in_panel) in panels.iter().enumerate() {
        for &variable in &names {
            for curve in &curves {
                let mut index = index.clone();
                for (axis, node) in [in_panel, curve].into_iter().flatten() {
                    index[*axis] = *node;
                }
                lines.push(Line { variable, index, panel, value: words(curve) });
            }
        }
    }
    let at = view.held(&index, &shown);
    let titles: Vec<Rich> = panels.iter().map(|panel| words(panel).unwrap_or_default()).collect();
    let what = join(names.iter().map(|name| view.units.variable(name).name));
    let caption = what.clone().then(" over ").then(view.axis(&axes[x]).name);
    let caption = caption.taken_at(at.clone()).then(".");
    let heading = match names.len() {
        1 => join([what, at]),
        _ => at,
    };
    let context = Context { view, x, heading, titles, width: plot.width };
    let codes = names.iter().filter(|name| kinds(name).is_some()).count();
    let (scene, columns) = match codes {
        0 => context.curves(&lines)?,
        all if all == names.len() => context.strips(&lines)?,
        _ => return Err(ChoiceError::CodesAndNumbers.into()),
    };
    let step = step(&axes[x]);
    let label = view.axis(&axes[x]);
    let nodes: Vec<f64> = drawn(&axes[x]).into_iter().map(|value| value * label.factor).collect();
    let mut data = Data::default();
    for (axis, _) in [panels[0], curves[0]].into_iter().flatten() {
        let label = view.axis(&axes[axis]);
        let values = lines.iter().flat_map(|line| {
            std::iter::repeat_n(axes[axis].values[line.index[axis]] * label.factor, nodes.len())
        });
        data = data.reals(label.header(), values.collect());
    }
    if names.len() > 1 {
        let each = lines.iter().flat_map(|line| {
            let label = view.units.variable(line.variable);
            std::iter::repeat_n(label.header(), nodes.len())
        });
        data = data.words("variable", each.collect());
    }
    data = data.reals(label.header(), nodes.repeat(lines.len()));
    let header = match names[..] {
        [name] => view.units.variable(name).header(),
        _ => "value".into(),
    };
    data = data.with(header, columns);
    if let Some(errors) = context.errors(&lines)? {
        let header = match names[..] {
            [name] => errors_of(map, name).map(|name| view.units.variable(&name).header()),
            _ => None,
        };
        data = data.reals(header.unwrap_or_else(|| "error".into()), errors);
    }
    let thinned = if step > 1 { vec![(axes[x].name.clone(), step)] } else { Vec::new() };
    let mut notes = moved(view, plot.panels, &panels);
    notes.extend(moved(view, several.first().copied(), &curves));
    Ok(Plotted { scene, caption, data, held, thinned, curves: None, notes })
}

/// Common arguments of all panels of a plot over one axis.
struct Context<'a> {
    view: &'a View<'a>,
    x: usize,
    heading: Rich,
    titles: Vec<Rich>,
    width: Width,
}

impl Context<'_> {
    /// The nodes to read along the axis.
    fn picks(&self, line: &Line) -> Result<Vec<Pick>, ChoiceError> {
        picks_of(self.view.map, line.variable, &[self.x], &line.index)
    }

    fn curves(&self, lines: &[Line]) -> Result<(Scene, Values), ReportError> {
        let map = self.view.map;
        let axis = &map.grid().axes()[self.x];
        let x_label = self.view.axis(axis);
        let nodes = drawn(axis);
        // One chart for each panel and each unit; a pure number shares its chart only with the same kind of
        // number.
        let mut charts: Vec<((usize, Cow<str>), Chart)> = Vec::new();
        let mut numbers = Vec::new();
        let unit = |line: &Line| -> Cow<str> {
            let label = self.view.units.variable(line.variable);
            let pure = || kind_of_variable(line.variable).map_or(label.key.into(), Cow::Borrowed);
            if label.unit.is_empty() { pure() } else { label.unit }
        };
        for line in lines {
            let values = map.real_slice(line.variable, &self.picks(line)?)?;
            let label = self.view.units.variable(line.variable);
            numbers.extend(values.iter().map(|value| value * label.factor));
            let several =
                lines.iter().any(|other| other.variable != line.variable && unit(other) == unit(line));
            let key = (line.panel, unit(line));
            let position = charts.iter().position(|(place, _)| *place == key);
            let position = position.unwrap_or_else(|| {
                // Several variables of one unit, or of one kind.
                let of_all = kind_of_variable(line.variable).filter(|_| label.unit.is_empty());
                let of_all = of_all.map_or(Rich::foreign(&label.unit), rich);
                let chart = Chart {
                    name: if several { of_all } else { label.text() },
                    title: self.titles[line.panel].clone(),
                    factor: label.factor,
                    y: None,
                    curves: Vec::new(),
                };
                charts.push((key, chart));
                charts.len() - 1
            });
            let chart = &mut charts[position].1;
            let number = chart.curves.len();
            chart.curves.push(Curve {
                name: line.name(self.view, several),
                style: style::curve(number),
                points: nodes.iter().copied().zip(values.iter().copied()).collect(),
                marks: true,
            });
        }
        let mut charts: Vec<Chart> = charts.into_iter().map(|(_, chart)| chart).collect();
        if charts.len() > 1 {
            for (number, chart) in charts.iter_mut().enumerate() {
                chart.title = lines::letter(number).then(std::mem::take(&mut chart.title));
            }
        }
        let x = Scale::of_nodes(&axis.values).in_unit(x_label.factor);
        let scene = lines::draw(&self.heading, x, &x_label.text(), &charts, self.width);
        Ok((scene, Values::Reals(numbers)))
    }

    /// The errors of the numbers of all lines, NaN where the map has none; `None` where it has none at all.
    fn errors(&self, lines: &[Line]) -> Result<Option<Vec<f64>>, ReportError> {
        let map = self.view.map;
        let known: Vec<Option<String>> = lines.iter().map(|line| errors_of(map, line.variable)).collect();
        if known.iter().all(Option::is_none) {
            return Ok(None);
        }
        let mut all = Vec::new();
        for (line, known) in lines.iter().zip(known) {
            match known {
                Some(name) => {
                    let factor = self.view.units.variable(&name).factor;
                    let errors = map.real_slice(&name, &self.picks(line)?)?;
                    all.extend(errors.iter().map(|error| error * factor));
                }
                None => all.resize(all.len() + drawn(&map.grid().axes()[self.x]).len(), f64::NAN),
            }
        }
        Ok(Some(all))
    }

    fn strips(&self, lines: &[Line]) -> Result<(Scene, Values), ReportError> {
        let map = self.view.map;
        let axis = &map.grid().axes()[self.x];
        let x_label = self.view.axis(axis);
        let mut kinds_of_all: Vec<CellKind> = Vec::new();
        let mut strips = Vec::new();
        let mut all = Vec::new();
        for line in lines {
            let kinds = kinds(line.variable).unwrap_or_default();
            let codes = map.code_slice(line.variable, &self.picks(line)?)?;
            let start = match kinds_of_all.iter().position(|kind| kinds.first() == Some(kind)) {
                Some(start) => start,
                None => {
                    kinds_of_all.extend(kinds.iter().cloned());
                    kinds_of_all.len() - kinds.len()
                }
            };
            let position = |code: &i8| kinds.iter().position(|kind| kind.code == *code).unwrap_or(0);
            let title = self.titles[line.panel].clone();
            let name = join([title, line.name(self.view, true)]);
            strips.push(Strip { name, kinds: codes.iter().map(|code| start + position(code)).collect() });
            all.extend(codes.iter().map(|code| kinds[position(code)].name.to_owned()));
        }
        let fills: Vec<_> = kinds_of_all.iter().map(|kind| (kind.fill, rich(&kind.words))).collect();
        let nodes = drawn(axis);
        let scale = Scale::of_nodes(&axis.values).in_unit(x_label.factor);
        let x = (scale, &x_label.text());
        let scene = strips::draw(&self.heading, &nodes, x, &strips, &fills, self.width);
        Ok((scene, Values::Words(all)))
    }
}

//! Slices of a map: two axes, the others fixed at nodes.

use ndarray::{Array2, ArrayD, Ix2};

use super::super::view::View;
use super::super::{ReportError, SIMULATION};
use slipmap_column::critical::critical_dampings;
use slipmap_figure::axis::Scale;
use slipmap_figure::region::cell_edges;
use slipmap_figure::text::{Rich, rich};
use slipmap_format::{MapFile, Pick};
use slipmap_map::{Axis, Field, Plane};
use slipmap_model::filippov::Oscillator;
use slipmap_page::units::Label;

/// Fewest nodes of both axes of an area. Two nodes would fill half of it each, as if what lies between had
/// been computed; they are drawn as rows instead.
pub(crate) const FEWEST_NODES: usize = 3;

/// Reason why a slice cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ChoiceError {
    #[error(
        "the map has no {kind} `{name}`; the nearest is `{nearest}`, and there are: {available}; choose one of these"
    )]
    Unknown { kind: &'static str, name: String, nearest: String, available: String },
    #[error("both directions show the axis `{0}`; choose two different axes")]
    SameAxis(String),
    #[error("the axis `{0}` is shown, so it cannot be held at a value; leave one of the two out")]
    Shown(String),
    #[error("the axis `{axis}` cannot be held at {value}; give a finite number")]
    NotFinite { axis: String, value: String },
    #[error("the axis `{axis}` reaches from {first} to {last}, so it cannot be held at {value}")]
    Outside { axis: String, value: String, first: String, last: String },
    #[error("the axis `{axis}` has the value {only} alone, so it cannot be held at {value}; leave it out")]
    OnlyOne { axis: String, value: String, only: String },
    #[error(
        "the axis `{0}` has one node, and curves need a plane; choose another axis, or leave the curves out"
    )]
    OneNode(String),
    #[error(
        "the axis `{0}` has several values; only one axis of a plot without a vertical axis may (each is a curve)"
    )]
    SeveralValues(String),
    #[error("a plane shows one variable; leave the vertical axis out to draw several as curves")]
    SeveralVariables,
    #[error("verdicts and numbers do not fit into one figure; draw them in two")]
    CodesAndNumbers,
    #[error("the axis `{0}` has one node, so there is nothing to draw over it; choose another axis")]
    NothingToDraw(String),
    #[error("a diagram over `{0}` cannot have these ends; give two legal values, the smaller one first")]
    NoRange(String),
    #[error(
        "the map does not store `{variable}`; add \"{field}\" to output.fields of its configuration and compute it again"
    )]
    NotStored { variable: String, field: &'static str },
    #[error(
        "the variable `{variable}` does not vary along `{axis}`; choose another axis or another variable"
    )]
    NotAlong { variable: String, axis: String },
}

impl ChoiceError {
    /// The error for a name that is not among the available ones.
    pub(crate) fn unknown<'a>(
        kind: &'static str,
        name: &str,
        available: impl Iterator<Item = &'a str>,
    ) -> Self {
        let available: Vec<&str> = available.collect();
        let distance =
            |known: &&&str| strsim::damerau_levenshtein(&name.to_lowercase(), &known.to_lowercase());
        let nearest = available.iter().min_by_key(distance).map_or(String::new(), |name| (*name).to_owned());
        Self::Unknown { kind, name: name.into(), nearest, available: available.join(", ") }
    }
}

/// A fixed axis and its value.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    pub axis: String,
    /// The requested value; `None` if there was none, and the middle node was taken.
    pub wanted: Option<f64>,
    /// The node's value.
    pub used: f64,
}

#[derive(Clone, Debug)]
pub struct Slice<'a> {
    pub(crate) view: &'a View<'a>,
    pub x: usize,
    pub y: usize,
    /// Node of each fixed axis; meaningless for the two that are shown.
    pub index: Vec<usize>,
}

impl<'a> Slice<'a> {
    /// The slice along two axes, with the others fixed at the given nodes.
    pub(crate) fn new(view: &'a View<'a>, x: usize, y: usize, index: Vec<usize>) -> Self {
        Self { view, x, y, index }
    }

    /// The eps of the slice.
    pub(crate) fn epsilon(&self) -> f64 {
        let grid = self.view.map.grid();
        grid.epsilon_axis().map_or(1.0, |axis| grid.axes()[axis].values[self.index[axis]])
    }

    /// Its axes, across and up.
    pub(crate) fn axes(&self) -> [&'a Axis; 2] {
        [self.x, self.y].map(|axis| &self.view.map.grid().axes()[axis])
    }

    pub fn plane(&self) -> Plane {
        Plane::new(self.x, self.y, self.index.clone())
    }

    pub(crate) fn scales(&self) -> [(Scale, Rich); 2] {
        self.axes().map(|axis| {
            let label = self.view.axis(axis);
            (Scale::of_nodes(&axis.values).in_unit(label.factor), label.text())
        })
    }

    /// The oscillator of the slice with these coordinates, which need not be nodes.
    /// `None` where there is none.
    pub(crate) fn oscillator(&self, x: f64, y: f64) -> Option<Oscillator> {
        let grid = self.view.map.grid();
        let mut values = grid.values(&self.index);
        for (axis, value) in [(self.x, x), (self.y, y)] {
            let nodes = &grid.axes()[axis].values;
            values[axis] = value.clamp(nodes[0], nodes[nodes.len() - 1]);
        }
        grid.oscillator_of(&values).ok()
    }

    /// The drawn nodes of each axis.
    pub(crate) fn nodes(&self) -> [Vec<f64>; 2] {
        self.axes().map(drawn)
    }

    /// The edges of the drawn cells along each axis.
    pub(crate) fn edges(&self) -> [Vec<f64>; 2] {
        self.axes().map(|axis| cell_edges(&drawn(axis), Scale::of_nodes(&axis.values)))
    }

    /// The axes of which not all nodes are drawn, with n where one node in n is.
    pub(crate) fn thinned(&self) -> impl Iterator<Item = (&'a Axis, usize)> + use<'a> {
        let steps = self.axes().map(|axis| (axis, step(axis)));
        steps.into_iter().filter(|(_, step)| *step > 1)
    }

    /// The sentence of a caption for [`Slice::thinned`]: " One node in 60 of V is drawn."
    pub(crate) fn thinned_words(&self) -> Rich {
        self.thinned().fold(Rich::default(), |text, (axis, step)| {
            let of = rich(&format!(" One node in {step} of "));
            text.then(of).then(Rich::symbol(&axis.name)).then(" is drawn.")
        })
    }

    /// Codes over the drawn nodes of the slice, `[x, y]`.
    pub fn codes(&self, variable: &str) -> Result<Array2<i8>, ReportError> {
        Ok(self.turned(self.view.map.code_slice(variable, &self.picks(variable)?)?))
    }

    /// Real numbers over the drawn nodes of the slice, `[x, y]`.
    pub fn reals(&self, variable: &str) -> Result<Array2<f64>, ReportError> {
        Ok(self.turned(self.view.map.real_slice(variable, &self.picks(variable)?)?))
    }

    /// The errors of a variable over the drawn nodes, `[x, y]`, with their label, where the map has them.
    pub fn errors(&self, variable: &str) -> Result<Option<(Label, Array2<f64>)>, ReportError> {
        let Some(name) = errors_of(self.view.map, variable) else { return Ok(None) };
        Ok(Some((self.view.units.variable(&name), self.reals(&name)?)))
    }

    fn picks(&self, variable: &str) -> Result<Vec<Pick>, ChoiceError> {
        picks_of(self.view.map, variable, &[self.x, self.y], &self.index)
    }

    fn turned<T: Clone>(&self, cells: ArrayD<T>) -> Array2<T> {
        // The reader drops every fixed axis, so two are left.
        let cells = match cells.into_dimensionality::<Ix2>() {
            Ok(cells) => cells,
            Err(_) => unreachable!("two axes of a slice are shown"),
        };
        if self.x > self.y { cells.reversed_axes() } else { cells }
    }

    /// "ε = 0.1, β = 0.5": every fixed axis.
    pub(crate) fn held(&self) -> Rich {
        self.view.held(&self.index, &[self.x, self.y])
    }

    /// "β = 0.5": every fixed axis but eps, for figures with a panel for each eps.
    pub(crate) fn held_but_epsilon(&self) -> Rich {
        let epsilon = self.view.map.grid().epsilon_axis();
        self.view.held(&self.index, &[self.x, self.y, epsilon.unwrap_or(self.x)])
    }
}

/// The variable of a map that holds the errors of this one.
pub(crate) fn errors_of(map: &MapFile, variable: &str) -> Option<String> {
    let name = map.critical_error();
    (variable == map.critical(SIMULATION) && map.has(&name)).then_some(name)
}

/// The position of the axis of this name.
pub(crate) fn find_axis(view: &View, name: &str) -> Result<usize, ChoiceError> {
    let axes = view.map.grid().axes();
    let names = axes.iter().map(|axis| axis.name.as_str());
    let position = axes.iter().position(|axis| axis.name == name);
    position.ok_or_else(|| ChoiceError::unknown("axis", name, names))
}

/// The nodes of the axes that are not `shown`: nearest to the values given for them, in the units of the
/// view, or else the middle ones.
pub(crate) fn hold(
    view: &View,
    shown: &[usize],
    at: &[(String, f64)],
) -> Result<(Vec<usize>, Vec<Held>), ChoiceError> {
    let axes = view.map.grid().axes();
    let mut index = middle(axes);
    let mut wanted = vec![None; axes.len()];
    for (name, value) in at {
        let position = find_axis(view, name)?;
        if shown.contains(&position) {
            return Err(ChoiceError::Shown(name.clone()));
        }
        index[position] = nearest_node(view, position, *value)?;
        wanted[position] = Some(*value);
    }
    // Of a machine with one belt speed or damping that is no choice.
    let constant = |position: usize| {
        view.units.machine.is_some() && axes[position].values.len() == 1 && wanted[position].is_none()
    };
    let held = axes.iter().enumerate().filter(|(i, _)| !shown.contains(i) && !constant(*i));
    let held = held.map(|(i, axis)| {
        let label = view.axis(axis);
        let used = axis.values[index[i]] * label.factor;
        // A single node is not reported as a middle node.
        let only = (axis.values.len() == 1).then_some(used);
        Held { axis: label.header(), wanted: wanted[i].or(only), used }
    });
    let held = held.collect();
    Ok((index, held))
}

/// The node of an axis nearest to a value in the units of the view.
pub(crate) fn nearest_node(view: &View, position: usize, value: f64) -> Result<usize, ChoiceError> {
    let axis = &view.map.grid().axes()[position];
    let label = view.axis(axis);
    if !value.is_finite() {
        return Err(ChoiceError::NotFinite { axis: axis.name.clone(), value: value.to_string() });
    }
    let [first, last] = [axis.values[0], axis.values[axis.values.len() - 1]].map(|node| node * label.factor);
    // Covers round-off in the conversion of units and in decimal input.
    let slack = 1e-9 * (last.abs() + first.abs());
    if axis.values.len() > 1 && !(first - slack..=last + slack).contains(&value) {
        let [first, last] = [first, last].map(|bound| Rich::number(bound, 6).plain());
        return Err(ChoiceError::Outside { axis: label.header(), value: value.to_string(), first, last });
    }
    // The only node may be given as a rounded number.
    if axis.values.len() == 1 && (value - first).abs() > 0.01 * first.abs() {
        let only = Rich::number(first, 6).plain();
        return Err(ChoiceError::OnlyOne { axis: label.header(), value: value.to_string(), only });
    }
    Ok(axis.nearest(value / label.factor))
}

/// Largest number of nodes of an axis that are drawn: as many as a figure of one column has pixels at 300
/// dpi. It bounds the memory of a figure, whatever the map's axes are.
const MOST_NODES: usize = 1000;

/// n, where one node in n of an axis is drawn.
pub(super) fn step(axis: &Axis) -> usize {
    axis.values.len().div_ceil(MOST_NODES)
}

/// The drawn nodes along the first `rank` axes: those along the `shown` ones, and the others' node of
/// `index`.
pub(crate) fn picks(map: &MapFile, shown: &[usize], index: &[usize], rank: usize) -> Vec<Pick> {
    let pick = |(axis, nodes): (usize, &Axis)| match shown.contains(&axis) {
        true => Pick::Every(step(nodes)),
        false => Pick::Node(index[axis]),
    };
    map.grid().axes()[..rank].iter().enumerate().map(pick).collect()
}

/// [`picks`] of all axes of a variable.
pub(crate) fn picks_of(
    map: &MapFile,
    variable: &str,
    shown: &[usize],
    index: &[usize],
) -> Result<Vec<Pick>, ChoiceError> {
    let axes = map.grid().axes();
    let rank = axes.len() - usize::from(Field::is_critical(variable));
    match shown.iter().find(|axis| **axis >= rank) {
        Some(axis) => {
            Err(ChoiceError::NotAlong { variable: variable.into(), axis: axes[*axis].name.clone() })
        }
        None => Ok(picks(map, shown, index, rank)),
    }
}

pub(super) fn drawn(axis: &Axis) -> Vec<f64> {
    axis.values.iter().copied().step_by(step(axis)).collect()
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

pub(crate) fn middle(axes: &[Axis]) -> Vec<usize> {
    axes.iter().map(Axis::middle).collect()
}

impl View<'_> {
    /// The nodes at which figures of the map are drawn, searched once.
    pub(crate) fn informative_nodes(&self) -> Vec<usize> {
        self.informative.get_or_init(|| informative_nodes(self.map)).clone()
    }
}

/// Largest number of axes along which an informative column is searched.
const MOST_VARIED: usize = 4;

/// Nodes of a map for an informative figure: the middle ones if a cycle exists in their column, else those of
/// the most similar column with a cycle among first, middle and last nodes of every axis. Columns with V at
/// its middle come first, then those with fewest axes changed, then those of largest critical damping.
fn informative_nodes(map: &MapFile) -> Vec<usize> {
    let axes = map.grid().axes();
    let middle = middle(axes);
    let mut candidates = vec![middle.clone()];
    let first = map.grid().epsilon_axis().map_or(0, |axis| axis + 1);
    // Few candidates, however many quantities of a machine vary.
    let varied = (first..axes.len() - 1).rev().filter(|&axis| axes[axis].values.len() > 1).take(MOST_VARIED);
    for axis in varied {
        let mut nodes = vec![0, middle[axis], axes[axis].values.len() - 1];
        nodes.dedup();
        candidates = candidates
            .into_iter()
            .flat_map(|candidate| {
                nodes.iter().map(move |&node| {
                    let mut candidate = candidate.clone();
                    candidate[axis] = node;
                    candidate
                })
            })
            .collect();
    }
    let known = candidates.into_iter().filter_map(|nodes| map.grid().column(&nodes).ok().zip(Some(nodes)));
    let (columns, candidates): (Vec<_>, Vec<_>) = known.unzip();
    let roots = critical_dampings(&columns, 1e-6);
    let positive = candidates.into_iter().zip(roots).filter_map(|(candidate, root)| {
        let root = root.ok().filter(|root| root.c > 0.0)?;
        let moved = |axis: usize| candidate[axis] != middle[axis];
        let belt_speed = axes.len() - 2;
        let distance = (moved(belt_speed), (0..belt_speed).filter(|&axis| moved(axis)).count());
        Some((candidate, distance, root.c))
    });
    positive
        .min_by(|a, b| a.1.cmp(&b.1).then(b.2.total_cmp(&a.2)))
        .map_or_else(|| middle.clone(), |(candidate, _, _)| candidate)
}

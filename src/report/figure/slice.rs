//! Slices of a map: two axes, the others held at nodes.

use ndarray::{Array2, ArrayD, Ix2};

use super::super::ReportError;
use super::super::text::{Rich, rich};
use super::super::units::{Label, View};
use super::axis::Scale;
use crate::friction::Law;
use crate::map::{Axis, Plane};
use crate::point::{LawParameters, Point};
use crate::simulate::critical::critical_dampings;
use crate::store::{MapFile, Pick};

/// Why a slice cannot be drawn.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ChoiceError {
    /// A name that the map does not have.
    #[error("the map has no {kind} `{name}`; the nearest is `{nearest}`, and there are: {available}")]
    Unknown {
        /// "axis" or "variable".
        kind: &'static str,
        /// What was asked for.
        name: String,
        /// The most similar name.
        nearest: String,
        /// What there is.
        available: String,
    },
    /// Both directions were to show the same axis.
    #[error("both directions show the axis `{axis}`; choose two different axes")]
    SameAxis {
        /// The axis.
        axis: String,
    },
    /// An axis was to be shown and held.
    #[error("the axis `{axis}` is shown, so it cannot be held at a value; leave one of the two out")]
    Shown {
        /// The axis.
        axis: String,
    },
    /// A value to hold an axis at that is no number.
    #[error("the axis `{axis}` cannot be held at {value}; give a finite number")]
    NotFinite {
        /// The axis.
        axis: String,
        /// The value, in words.
        value: String,
    },
    /// A value to hold an axis at that lies outside of it.
    #[error("the axis `{axis}` reaches from {first} to {last}, so it cannot be held at {value}")]
    Outside {
        /// The axis.
        axis: String,
        /// The value, in words.
        value: String,
        /// The first node.
        first: String,
        /// The last node.
        last: String,
    },
    /// Curves in a plane that does not extend along one of its axes.
    #[error(
        "the axis `{axis}` has one node, and curves need a plane; choose another axis, or leave the curves out"
    )]
    OneNode {
        /// The axis.
        axis: String,
    },
    /// Several values where one is needed.
    #[error(
        "the axis `{axis}` has several values; only one axis of a plot without a vertical axis may (each is a curve)"
    )]
    SeveralValues {
        /// The axis.
        axis: String,
    },
    /// Several variables over a plane.
    #[error("a plane shows one variable; leave the vertical axis out to draw several as curves")]
    SeveralVariables,
    /// Verdicts and numbers in one figure.
    #[error("verdicts and numbers do not fit into one figure; draw them in two")]
    CodesAndNumbers,
    /// An axis of one node alone.
    #[error("the axis `{axis}` has one node, so there is nothing to draw over it; choose another axis")]
    NothingToDraw {
        /// The axis.
        axis: String,
    },
    /// The ends of a diagram.
    #[error("a diagram over `{axis}` cannot have these ends; give two legal values, the smaller one first")]
    NoRange {
        /// The axis.
        axis: String,
    },
    /// A variable that runs store on request, and this map's did not.
    #[error(
        "the map does not store `{variable}`; add \"{field}\" to output.fields of its configuration and compute it again"
    )]
    NotStored {
        /// The variable.
        variable: String,
        /// The field.
        field: &'static str,
    },
    /// An axis that the variable does not have.
    #[error(
        "the variable `{variable}` does not vary along `{axis}`; choose another axis or another variable"
    )]
    NotAlong {
        /// The variable.
        variable: String,
        /// The axis.
        axis: String,
    },
}

impl ChoiceError {
    /// A name that is not among those that there are.
    pub(super) fn unknown<'a>(
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

/// An axis that is held, and where.
#[derive(Clone, Debug, PartialEq)]
pub struct Held {
    /// Name of the axis.
    pub axis: String,
    /// What was asked for; `None` if nothing was, and the middle node was taken.
    pub wanted: Option<f64>,
    /// The node's value.
    pub used: f64,
}

/// A slice of a map.
#[derive(Clone, Debug)]
pub struct Slice<'a> {
    /// The map and its units.
    pub view: &'a View<'a>,
    /// Position of the horizontal axis.
    pub x: usize,
    /// Position of the vertical axis.
    pub y: usize,
    /// Node at which each axis is held; meaningless for the two that are shown.
    pub index: Vec<usize>,
}

impl<'a> Slice<'a> {
    /// The slice along two axes, the others held at the given nodes.
    #[must_use]
    pub fn new(view: &'a View<'a>, x: usize, y: usize, index: Vec<usize>) -> Self {
        Self { view, x, y, index }
    }

    /// The slice along the axes of these names. Other axes are held at the node nearest to the value given
    /// for them, or else at their middle node.
    ///
    /// # Errors
    /// [`ChoiceError`].
    pub fn choose(
        view: &'a View<'a>,
        x: &str,
        y: &str,
        at: &[(String, f64)],
    ) -> Result<(Self, Vec<Held>), ChoiceError> {
        let (x, y) = (find_axis(view, x)?, find_axis(view, y)?);
        if x == y {
            return Err(ChoiceError::SameAxis { axis: view.map.grid().axes()[x].name.clone() });
        }
        let (index, held) = hold(view, &[x, y], at)?;
        Ok((Self::new(view, x, y, index), held))
    }

    /// The friction law.
    #[must_use]
    pub fn law(&self) -> &Law {
        self.view.map.grid().law()
    }

    /// The horizontal axis.
    #[must_use]
    pub fn x_axis(&self) -> &'a Axis {
        &self.view.map.grid().axes()[self.x]
    }

    /// The vertical axis.
    #[must_use]
    pub fn y_axis(&self) -> &'a Axis {
        &self.view.map.grid().axes()[self.y]
    }

    /// Its plane in the grid.
    #[must_use]
    pub fn plane(&self) -> Plane {
        Plane::new(self.x, self.y, self.index.clone())
    }

    /// The scale and the name of the horizontal axis.
    #[must_use]
    pub fn x_scale(&self) -> (Scale, Rich) {
        scale(self.view, self.x_axis())
    }

    /// The scale and the name of the vertical axis.
    #[must_use]
    pub fn y_scale(&self) -> (Scale, Rich) {
        scale(self.view, self.y_axis())
    }

    /// The point of the slice with these coordinates, which need not be nodes.
    #[must_use]
    pub fn point(&self, x: f64, y: f64) -> Point {
        let axes = self.view.map.grid().axes();
        let clamp = |axis: &Axis, value: f64| value.clamp(axis.values[0], axis.values[axis.values.len() - 1]);
        let mut values: Vec<f64> = axes.iter().zip(&self.index).map(|(axis, &i)| axis.values[i]).collect();
        values[self.x] = clamp(&axes[self.x], x);
        values[self.y] = clamp(&axes[self.y], y);
        point(&values)
    }

    /// Nodes of the horizontal axis that are drawn.
    #[must_use]
    pub fn x_nodes(&self) -> Vec<f64> {
        drawn(self.x_axis())
    }

    /// Nodes of the vertical axis that are drawn.
    #[must_use]
    pub fn y_nodes(&self) -> Vec<f64> {
        drawn(self.y_axis())
    }

    /// Axes of which not all nodes are drawn, and one node in how many is.
    pub fn thinned(&self) -> impl Iterator<Item = (&'a Axis, usize)> + use<'a> {
        let steps = [self.x_axis(), self.y_axis()].map(|axis| (axis, step(axis)));
        steps.into_iter().filter(|(_, step)| *step > 1)
    }

    /// What a caption says of that: " One node in 60 of V is drawn."
    #[must_use]
    pub fn thinned_words(&self) -> Rich {
        self.thinned().fold(Rich::default(), |text, (axis, step)| {
            let of = rich(&format!(" One node in {step} of "));
            text.then(of).then(Rich::symbol(&axis.name)).then(rich(" is drawn."))
        })
    }

    /// Codes over the drawn nodes of the slice, `[x, y]`.
    ///
    /// # Errors
    /// [`ReportError::Map`], [`ReportError::Choice`].
    pub fn codes(&self, variable: &str) -> Result<Array2<i8>, ReportError> {
        Ok(self.turned(
            self.view
                .map
                .code_slice(variable, &self.selection(variable, self.view.map.grid().axes().len())?)?,
        ))
    }

    /// Real numbers over the drawn nodes of the slice, `[x, y]`.
    ///
    /// # Errors
    /// [`ReportError::Map`], [`ReportError::Choice`].
    pub fn reals(&self, variable: &str) -> Result<Array2<f64>, ReportError> {
        let axes = self.view.map.grid().axes().len();
        let rank = if variable.starts_with("critical_c_") { axes - 1 } else { axes };
        Ok(self.turned(self.view.map.real_slice(variable, &self.selection(variable, rank)?)?))
    }

    fn selection(&self, variable: &str, rank: usize) -> Result<Vec<Pick>, ChoiceError> {
        for axis in [self.x, self.y] {
            if axis >= rank {
                let axis = self.view.map.grid().axes()[axis].name.clone();
                return Err(ChoiceError::NotAlong { variable: variable.into(), axis });
            }
        }
        let axes = self.view.map.grid().axes();
        let pick = |axis| match axis == self.x || axis == self.y {
            true => Pick::Every(step(&axes[axis])),
            false => Pick::Node(self.index[axis]),
        };
        Ok((0..rank).map(pick).collect())
    }

    fn turned<T: Clone>(&self, cells: ArrayD<T>) -> Array2<T> {
        // The reader drops every held axis, so two are left.
        let cells = match cells.into_dimensionality::<Ix2>() {
            Ok(cells) => cells,
            Err(_) => unreachable!("two axes of a slice are shown"),
        };
        if self.x > self.y { cells.reversed_axes() } else { cells }
    }

    /// "ε = 0.1, β = 0.5", every axis that is held.
    #[must_use]
    pub fn held(&self) -> Rich {
        self.view.held(&self.index, &[self.x, self.y])
    }

    /// The same without eps, for figures with a panel for each.
    #[must_use]
    pub fn held_but_epsilon(&self) -> Rich {
        self.view.held(&self.index, &[self.x, self.y, 0])
    }
}

/// The position of the axis of this name. Machines' axes also have the names that configurations give them.
///
/// # Errors
/// [`ChoiceError::Unknown`].
pub fn find_axis(view: &View, name: &str) -> Result<usize, ChoiceError> {
    let axes = view.map.grid().axes();
    let labels: Vec<Label> = axes.iter().map(|axis| view.axis(axis)).collect();
    let names = axes.iter().map(|axis| axis.name.as_str());
    let position = axes.iter().zip(&labels).position(|(axis, label)| axis.name == name || label.key == name);
    position.ok_or_else(|| ChoiceError::unknown("axis", name, names))
}

/// The nodes at which the axes that are not `shown` are held: nearest to the values given for them, in the units of
/// the view, or else the middle ones.
///
/// # Errors
/// [`ChoiceError`].
pub fn hold(
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
            return Err(ChoiceError::Shown { axis: name.clone() });
        }
        index[position] = nearest_node(view, position, *value)?;
        wanted[position] = Some(*value);
    }
    // A machine's friction is no choice of the user's.
    let constant = |position: usize| {
        view.units.machine().is_some() && axes[position].values.len() == 1 && wanted[position].is_none()
    };
    let held = axes.iter().enumerate().filter(|(i, _)| !shown.contains(i) && !constant(*i));
    let held = held.map(|(i, axis)| {
        let label = view.axis(axis);
        Held { axis: label.header(), wanted: wanted[i], used: axis.values[index[i]] * label.factor }
    });
    let held = held.collect();
    Ok((index, held))
}

/// The node of an axis nearest to a value in the units of the view.
///
/// # Errors
/// [`ChoiceError::NotFinite`], [`ChoiceError::Outside`].
pub fn nearest_node(view: &View, position: usize, value: f64) -> Result<usize, ChoiceError> {
    let axis = &view.map.grid().axes()[position];
    let label = view.axis(axis);
    if !value.is_finite() {
        return Err(ChoiceError::NotFinite { axis: axis.name.clone(), value: value.to_string() });
    }
    let [first, last] = [axis.values[0], axis.values[axis.values.len() - 1]].map(|node| node * label.factor);
    // Round-off in the conversion of units and in decimal input.
    let slack = 1e-9 * (last.abs() + first.abs());
    if axis.values.len() > 1 && !(first - slack..=last + slack).contains(&value) {
        let [first, last] = [first, last].map(|bound| Rich::number(bound, 6).plain());
        return Err(ChoiceError::Outside { axis: label.header(), value: value.to_string(), first, last });
    }
    Ok(axis.nearest(value / label.factor))
}

/// Nodes of an axis that are drawn at most: as many as a figure of one column has pixels at 300 dpi. They bound
/// the memory that a figure takes, whatever the map's axes are.
const MOST_NODES: usize = 1000;

/// Of an axis, one node in so many is drawn.
pub(super) fn step(axis: &Axis) -> usize {
    axis.values.len().div_ceil(MOST_NODES)
}

fn drawn(axis: &Axis) -> Vec<f64> {
    axis.values.iter().copied().step_by(step(axis)).collect()
}

/// The scale and the name of an axis.
fn scale(view: &View, axis: &Axis) -> (Scale, Rich) {
    let label = view.axis(axis);
    (Scale::of_nodes(&axis.values).in_unit(label.factor), label.text())
}

/// "ε = 0.1".
#[must_use]
pub fn equals(axis: &str, value: f64) -> Rich {
    Rich::symbol(axis).then(rich(" = ")).then(Rich::number(value, 4))
}

/// The middle node of each axis.
#[must_use]
pub fn middle(axes: &[Axis]) -> Vec<usize> {
    axes.iter().map(Axis::middle).collect()
}

/// Nodes of a map at which there is something to see: the middle ones if a cycle exists in their column,
/// else those of the most similar column among first, middle and last nodes of every axis that has one:
/// with V in its middle if possible, few axes moved, and the largest critical damping of these.
#[must_use]
pub fn informative_nodes(map: &MapFile) -> Vec<usize> {
    let axes = map.grid().axes();
    let middle = middle(axes);
    let mut candidates = vec![middle.clone()];
    for axis in 1..axes.len() - 1 {
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
    let columns: Vec<_> = candidates.iter().map(|candidate| map.grid().column(candidate)).collect();
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

/// The point with the given value on each axis, in the order of the map.
pub(super) fn point(values: &[f64]) -> Point {
    let last = values.len() - 1;
    Point {
        epsilon: values[0],
        law: LawParameters::new(&values[1..last - 1]),
        belt_speed: values[last - 1],
        damping: values[last],
    }
}

//! Bifurcation diagrams: the amplitude of the equilibrium and of every cycle against one parameter.
//!
//! At each value of the parameter every cycle is searched independently. Where their number or stability
//! changes between two values, the change is located by bisection, so that folds and ends of branches are at
//! their exact places.

use rayon::prelude::*;

use super::super::ReportError;
use super::super::text::{Rich, rich};
use super::super::units::View;
use super::axis::Scale;
use super::data::Data;
use super::lines::{self, Chart, Curve};
use super::palette::{self, MethodStyle};
use super::plot::Plotted;
use super::scene::{Marker, Stroke, Width};
use super::slice::{ChoiceError, find_axis, hold};
use crate::filippov::Oscillator;
use crate::machine::Dimension;
use crate::map::Grid;
use crate::simulate::{Range, dynamics, flow};

/// Number of values of the parameter at which cycles are searched; a branch that exists only between two of
/// them is missed.
const VALUES: usize = 121;
/// Number of bisections that locate a change: to a ten-millionth of a step.
const BISECTIONS: usize = 24;
/// Accuracy of the orbits.
const TOLERANCE: f64 = 1e-9;

#[derive(Clone, Debug)]
pub(crate) struct DiagramPlot<'a> {
    /// Name of the horizontal axis; its nodes are not used.
    pub(crate) x: &'a str,
    /// Values of the other axes, in the units of the view.
    pub(crate) at: &'a [(String, f64)],
    /// The ends of the diagram, in the units of the view; those of the axis if `None`.
    pub(crate) range: Option<(f64, f64)>,
    pub(crate) width: Width,
}

/// Kind of an equilibrium or cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
enum Kind {
    Equilibrium,
    SlipCycle,
    StickSlipCycle,
    CrossingCycle,
}

impl Kind {
    const ALL: [Kind; 4] = [Kind::Equilibrium, Kind::SlipCycle, Kind::StickSlipCycle, Kind::CrossingCycle];

    /// Its name and its colour.
    fn look(self) -> (&'static str, &'static str) {
        match self {
            Kind::Equilibrium => ("equilibrium", palette::BLACK),
            Kind::SlipCycle => ("slip cycle", palette::GREEN),
            Kind::StickSlipCycle => ("stick-slip cycle", palette::BLUE),
            Kind::CrossingCycle => ("crossing cycle", palette::VERMILION),
        }
    }
}

/// An equilibrium or cycle at one value of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    kind: Kind,
    attracts: bool,
    /// Half the range of x1.
    amplitude: f64,
}

/// All of them at one value of the parameter, by kind and increasing amplitude; `None` where an orbit failed.
type Found = Option<Vec<State>>;

fn find(oscillator: &Oscillator) -> Found {
    let all = dynamics(oscillator, &flow(oscillator, TOLERANCE), TOLERANCE).ok()?;
    let rest = [(Kind::Equilibrium, all.equilibrium.is_stable(), Range { lo: 0.0, hi: 0.0 })].into_iter();
    let slip = all.slip.iter().map(|cycle| (Kind::SlipCycle, cycle.is_stable(), cycle.displacement));
    let stick_slip = all.stick_slip.iter().map(|cycle| (Kind::StickSlipCycle, true, cycle.displacement));
    let crossing =
        all.crossing.iter().map(|cycle| (Kind::CrossingCycle, cycle.is_stable(), cycle.displacement));
    let found = rest.chain(slip).chain(stick_slip).chain(crossing);
    let amplitude = |x1: Range| 0.5 * (x1.hi - x1.lo);
    Some(found.map(|(kind, attracts, x1)| State { kind, attracts, amplitude: amplitude(x1) }).collect())
}

/// Returns whether two values of the parameter have the same kinds of cycles with the same stability.
fn same_kinds(a: &Found, b: &Found) -> bool {
    let kinds = |found: &Found| -> Option<Vec<(Kind, bool)>> {
        found.as_ref().map(|states| states.iter().map(|state| (state.kind, state.attracts)).collect())
    };
    kinds(a) == kinds(b)
}

/// A branch: its kind, and its points (parameter, amplitude).
#[derive(Clone, Debug)]
struct Branch {
    kind: Kind,
    attracts: bool,
    points: Vec<(f64, f64)>,
}

/// Joins the cycles found at increasing values of the parameter into branches.
fn branches(found: &[(f64, Found)]) -> Vec<Branch> {
    let mut done: Vec<Branch> = Vec::new();
    let mut open: Vec<Branch> = Vec::new();
    let mut last: &Found = &None;
    for (value, states) in found {
        if !same_kinds(last, states) {
            done.append(&mut open);
            open = states
                .iter()
                .flatten()
                .map(|state| Branch { kind: state.kind, attracts: state.attracts, points: Vec::new() })
                .collect();
        }
        for (branch, state) in open.iter_mut().zip(states.iter().flatten()) {
            branch.points.push((*value, state.amplitude));
        }
        last = states;
    }
    done.append(&mut open);
    done
}

/// Draws a bifurcation diagram of the law and the parameters of a map.
pub(crate) fn diagram(view: &View, plot: &DiagramPlot) -> Result<Plotted, ReportError> {
    let grid = view.map.grid();
    let axes = grid.axes();
    let x = find_axis(view, plot.x)?;
    let (index, held) = hold(view, &[x], plot.at)?;
    let label = view.axis(&axes[x]);
    let nodes = &axes[x].values;
    let scale = match plot.range {
        Some((from, to)) => {
            let (from, to) = (from / label.factor, to / label.factor);
            let legal = |end: f64| Grid::check_value(grid.law(), axes[x].role, &axes[x].name, end).is_ok();
            if !(legal(from) && legal(to) && from < to) {
                return Err(ChoiceError::NoRange(label.header()).into());
            }
            Scale::linear(from, to)
        }
        None if nodes.len() < 2 => {
            return Err(ChoiceError::NothingToDraw(axes[x].name.clone()).into());
        }
        None => Scale::of_nodes(nodes),
    };
    let find_at = |unit: f64| -> (f64, Found) {
        let (value, mut point) = (scale.value(unit), grid.point(&index));
        axes[x].role.set(&mut point, value);
        (value, find(&Oscillator::new(grid.law(), &point)))
    };
    let units: Vec<f64> = (0..VALUES).map(|i| i as f64 / (VALUES - 1) as f64).collect();
    let coarse: Vec<(f64, Found)> = units.par_iter().map(|unit| find_at(*unit)).collect();
    let pieces: Vec<Vec<(f64, Found)>> = (0..VALUES - 1)
        .into_par_iter()
        .map(|i| {
            let mut piece = vec![coarse[i].clone()];
            if !same_kinds(&coarse[i].1, &coarse[i + 1].1) {
                let (mut low, mut high) = (units[i], units[i + 1]);
                let (mut below, mut above) = (None, None);
                for _ in 0..BISECTIONS {
                    let middle = 0.5 * (low + high);
                    let here = find_at(middle);
                    if same_kinds(&here.1, &coarse[i].1) {
                        (low, below) = (middle, Some(here));
                    } else {
                        (high, above) = (middle, Some(here));
                    }
                }
                piece.extend(below);
                piece.extend(above);
            }
            piece
        })
        .collect();
    let mut found: Vec<(f64, Found)> = pieces.into_iter().flatten().collect();
    found.extend(coarse.last().cloned());
    let failed = found.iter().filter(|(_, states)| states.is_none()).count();
    let branches = branches(&found);

    let amplitude =
        view.units.quantity("amplitude", rich("amplitude of {x_1}"), "amplitude", Some(Dimension::Length));
    let mut curves = Vec::new();
    for kind in Kind::ALL {
        for branch in branches.iter().filter(|branch| branch.kind == kind) {
            let dash: &'static [f64] = if branch.attracts { &[] } else { &[3.0, 2.0] };
            let words = if branch.attracts { "attracting" } else { "repelling" };
            let (name, color) = kind.look();
            curves.push(Curve {
                name: rich(&format!("{words} {name}")),
                style: MethodStyle { stroke: Stroke { color, width: 1.3, dash }, marker: Marker::Circle },
                points: branch.points.clone(),
                marks: false,
            });
        }
    }
    let chart = Chart {
        name: amplitude.text(),
        title: Rich::default(),
        factor: amplitude.factor,
        drawn_at_zero: true,
        curves,
    };
    let at = view.held(&index, &[x]);
    let scene = lines::draw(&at, scale.in_unit(label.factor), &label.text(), &[chart], plot.width);
    let caption = rich(
        "Bifurcation diagram: half the peak-to-peak displacement of the equilibrium and of every \
                            cycle against ",
    )
    .then(label.name.clone())
    .taken_at(at)
    .then(". Solid: attracts; dashed: repels.");
    let points = || {
        let numbered = branches.iter().enumerate();
        numbered.flat_map(|(number, branch)| branch.points.iter().map(move |point| (number, branch, *point)))
    };
    let data = Data::default()
        .words("branch", points().map(|(number, ..)| (number + 1).to_string()).collect())
        .words("kind", points().map(|(_, branch, _)| branch.kind.look().0.replace([' ', '-'], "_")).collect())
        .words("attracts", points().map(|(_, branch, _)| branch.attracts.to_string()).collect())
        .reals(label.header(), points().map(|(.., point)| point.0 * label.factor).collect())
        .reals(amplitude.header(), points().map(|(.., point)| point.1 * amplitude.factor).collect());
    let notes = match failed {
        0 => Vec::new(),
        failed => {
            vec![format!("orbits failed at {failed} values of {}; nothing is drawn there", axes[x].name)]
        }
    };
    Ok(Plotted { scene, caption, data, held, thinned: Vec::new(), curves: None, notes })
}

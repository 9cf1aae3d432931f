//! Bifurcation diagrams: the amplitude of the equilibrium and of every cycle against one parameter.
//!
//! At each value of the parameter every cycle is searched independently. Where their number or stability
//! changes between two values, each change is located by bisection, so that folds and ends of branches are at
//! their exact places.

use rayon::prelude::*;

use super::super::ReportError;
use super::super::view::View;
use super::plot::Plotted;
use super::slice::{ChoiceError, find_axis, hold};
use slipmap_column::crossing::beyond_slip;
use slipmap_column::slip_cycle::TIGHT;
use slipmap_column::slip_cycles;
use slipmap_figure::axis::Scale;
use slipmap_figure::data::Data;
use slipmap_figure::lines::{self, Chart, Curve};
use slipmap_figure::scene::{Marker, Stroke, Width};
use slipmap_figure::style;
use slipmap_figure::style::LineStyle;
use slipmap_figure::text::{Rich, rich};
use slipmap_machine::Dimension;
use slipmap_model::filippov::{Oscillator, Stability};
use slipmap_model::friction::Range;
use slipmap_orbits::flow;

/// Number of values of the parameter at which cycles are searched; a branch that exists only between two of
/// them is missed.
const VALUES: usize = 121;
/// Number of bisections that locate a change, to a ten-millionth of a step.
const BISECTIONS: usize = 24;
/// Largest number of changes that are located between two values.
const MOST_CHANGES: usize = 8;
const TOLERANCE: f64 = 1e-9;

#[derive(Clone, Debug)]
pub struct DiagramPlot<'a> {
    /// Name of the horizontal axis; its nodes are not used.
    pub x: &'a str,
    /// Values of the other axes, in the units of the view.
    pub at: &'a [(String, f64)],
    /// The ends of the diagram, in the units of the view; those of the axis if `None`.
    pub range: Option<(f64, f64)>,
    pub width: Width,
}

/// Kind of an equilibrium or cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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
            Kind::Equilibrium => ("equilibrium", style::BLACK),
            Kind::SlipCycle => ("slip cycle", style::GREEN),
            Kind::StickSlipCycle => ("stick-slip cycle", style::BLUE),
            Kind::CrossingCycle => ("crossing cycle", style::VERMILION),
        }
    }
}

/// An equilibrium or cycle at one value of the parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    attracts: bool,
    /// Half the range of x1, or of a machine in SI units.
    amplitude: f64,
}

/// The states of each kind at one value of the parameter, by increasing amplitude, in the order of
/// [`Kind::ALL`]; `None` for a kind that could not be determined there.
type Found = [Option<Vec<State>>; 4];

/// Finds the states; `length` is the unit of the amplitudes.
fn find(oscillator: &Oscillator, length: f64) -> Found {
    let state = |attracts: bool, x1: Range| State { attracts, amplitude: 0.5 * (x1.hi - x1.lo) * length };
    let equilibrium = match oscillator.stability() {
        Stability::Neutral => None,
        stability => Some(vec![State { attracts: stability == Stability::Attracts, amplitude: 0.0 }]),
    };
    let slip = slip_cycles(oscillator, &flow(oscillator, TOLERANCE), TIGHT).ok();
    let (sticks, crossing) = beyond_slip(oscillator, TOLERANCE);
    [
        equilibrium,
        slip.map(|all| all.iter().map(|cycle| state(cycle.is_stable(), cycle.displacement)).collect()),
        sticks.map(|all| all.iter().map(|cycle| state(true, cycle.displacement)).collect()),
        crossing.map(|all| all.iter().map(|cycle| state(cycle.is_stable(), cycle.displacement)).collect()),
    ]
}

/// Returns whether two values have equally many states of a kind, with equal stability.
fn alike(a: &Option<Vec<State>>, b: &Option<Vec<State>>) -> bool {
    let attract = |states: &Option<Vec<State>>| -> Option<Vec<bool>> {
        states.as_ref().map(|states| states.iter().map(|state| state.attracts).collect())
    };
    attract(a) == attract(b)
}

/// Returns whether two values are [`alike`] in every kind.
fn same_kinds(a: &Found, b: &Found) -> bool {
    a.iter().zip(b).all(|(a, b)| alike(a, b))
}

/// Both sides of every change between two values of the parameter, in order, by bisection: from each change on to the
/// end. Changes that undo each other are not seen.
fn changes(
    [mut start, end]: [f64; 2],
    first: &Found,
    last: &Found,
    find_at: impl Fn(f64) -> (f64, Found),
) -> Vec<(f64, Found)> {
    let (mut sides, mut from) = (Vec::new(), first.clone());
    for _ in 0..MOST_CHANGES {
        if same_kinds(&from, last) {
            break;
        }
        let (mut low, mut high) = (start, end);
        let (mut below, mut above) = (None, None);
        for _ in 0..BISECTIONS {
            let middle = 0.5 * (low + high);
            let here = find_at(middle);
            if same_kinds(&here.1, &from) {
                (low, below) = (middle, Some(here));
            } else {
                (high, above) = (middle, Some(here));
            }
        }
        sides.extend(below);
        // Without a value above it the change lies at the end, whose states are known.
        let Some(above) = above else { break };
        (start, from) = (high, above.1.clone());
        sides.push(above);
    }
    sides
}

/// A branch: its kind, and its points (parameter, amplitude).
#[derive(Clone, Debug)]
struct Branch {
    kind: Kind,
    attracts: bool,
    points: Vec<(f64, f64)>,
}

/// Joins the cycles found at increasing values of the parameter into branches, kind by kind.
fn branches(found: &[(f64, Found)]) -> Vec<Branch> {
    let mut done: Vec<Branch> = Vec::new();
    for (number, kind) in Kind::ALL.into_iter().enumerate() {
        let mut open: Vec<Branch> = Vec::new();
        let mut last: &Option<Vec<State>> = &None;
        for (value, states) in found {
            let states = &states[number];
            if !alike(last, states) {
                done.append(&mut open);
                let begin = |state: &State| Branch { kind, attracts: state.attracts, points: Vec::new() };
                open = states.iter().flatten().map(begin).collect();
            }
            for (branch, state) in open.iter_mut().zip(states.iter().flatten()) {
                branch.points.push((*value, state.amplitude));
            }
            last = states;
        }
        done.append(&mut open);
    }
    done
}

/// The kinds that could not be determined at some values of a parameter, in words.
fn unknown(found: &[(f64, Found)], parameter: &str) -> Vec<String> {
    let of_kind = |(number, kind): (usize, Kind)| {
        let values = found.iter().filter(|(_, states)| states[number].is_none()).count();
        let words = format!(
            "every {} at {values} of {} values of {parameter} is missing: it is not known there",
            kind.look().0,
            found.len()
        );
        (values > 0).then_some(words)
    };
    Kind::ALL.into_iter().enumerate().filter_map(of_kind).collect()
}

/// Draws a bifurcation diagram of the law and the parameters of a map.
pub fn diagram(view: &View, plot: &DiagramPlot) -> Result<Plotted, ReportError> {
    let grid = view.map.grid();
    let axes = grid.axes();
    let x = find_axis(view, plot.x)?;
    let (index, held) = hold(view, &[x], plot.at)?;
    let label = view.axis(&axes[x]);
    let nodes = &axes[x].values;
    let scale = match plot.range {
        Some((from, to)) => {
            let (from, to) = (from / label.factor, to / label.factor);
            let legal = |end: f64| {
                let mut values = grid.values(&index);
                values[x] = end;
                grid.oscillator_of(&values).is_ok()
            };
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
        let (value, mut values) = (scale.value(unit), grid.values(&index));
        values[x] = value;
        let length = grid.si(&values).map_or(1.0, |si| si.factor(Dimension::Length));
        let unknown = [const { None }; 4];
        (value, grid.oscillator_of(&values).map_or(unknown, |oscillator| find(&oscillator, length)))
    };
    let units: Vec<f64> = (0..VALUES).map(|i| i as f64 / (VALUES - 1) as f64).collect();
    let coarse: Vec<(f64, Found)> = units.par_iter().map(|unit| find_at(*unit)).collect();
    let pieces: Vec<Vec<(f64, Found)>> = (0..VALUES - 1)
        .into_par_iter()
        .map(|i| {
            let mut piece = vec![coarse[i].clone()];
            piece.extend(changes([units[i], units[i + 1]], &coarse[i].1, &coarse[i + 1].1, find_at));
            piece
        })
        .collect();
    let mut found: Vec<(f64, Found)> = pieces.into_iter().flatten().collect();
    found.extend(coarse.last().cloned());
    let notes = unknown(&coarse, &axes[x].name);
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
                style: LineStyle { stroke: Stroke { color, width: 1.3, dash }, marker: Marker::Circle },
                points: branch.points.clone(),
                marks: false,
            });
        }
    }
    // The equilibrium must not lie on the frame.
    let most = lines::extent(&curves, |point| point.1).1.max(0.0);
    let y = Some(Scale::linear(-0.05 * most, 1.05 * most));
    let chart = Chart { name: amplitude.text(), title: Rich::default(), factor: amplitude.factor, y, curves };
    let at = view.held(&index, &[x]);
    let scene = lines::draw(&at, scale.in_unit(label.factor), &label.text(), &[chart], plot.width);
    let caption = rich(
        "Bifurcation diagram: half the peak-to-peak displacement of the equilibrium and of every \
                            cycle against ",
    )
    .then(label.name.clone())
    .taken_at(at)
    .then(". Solid: attracts; dashed: repels.");
    let caption =
        notes.iter().fold(caption, |caption, note| caption.then(Rich::foreign(&format!(" Note: {note}."))));
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
    Ok(Plotted { scene, caption, data, held, thinned: Vec::new(), curves: None, notes })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repelling slip cycle meets an attracting one that was born at 0.3, and both end at 0.30002; stick-slip ends at 0.8.
    #[test]
    fn every_change_between_two_values_is_located() {
        let states = |attracts: &[bool]| -> Option<Vec<State>> {
            Some(attracts.iter().map(|attracts| State { attracts: *attracts, amplitude: 1.0 }).collect())
        };
        let find_at = |c: f64| -> (f64, Found) {
            let slip: &[bool] = match c {
                ..0.3 => &[false],
                ..0.30002 => &[false, true],
                _ => &[],
            };
            let sticks: &[bool] = if c < 0.8 { &[true] } else { &[] };
            (c, [states(&[true]), states(slip), states(sticks), states(&[])])
        };
        let found = changes([0.0, 1.0], &find_at(0.0).1, &find_at(1.0).1, find_at);
        let places = [0.3, 0.3, 0.30002, 0.30002, 0.8, 0.8];
        assert_eq!(found.len(), places.len());
        for ((c, states), place) in found.iter().zip(places) {
            assert!((c - place).abs() < 1e-7, "{c} is not {place}");
            assert!(same_kinds(states, &find_at(*c).1));
        }
    }

    /// A kind that is not known at one value interrupts only its own branches and is reported.
    #[test]
    fn what_is_known_is_drawn_where_other_kinds_are_not() {
        let state = |amplitude: f64| Some(vec![State { attracts: true, amplitude }]);
        let found: Vec<(f64, Found)> = (0..5)
            .map(|i| {
                let value = f64::from(i);
                let slip = if i == 2 { None } else { state(0.5 + value) };
                (value, [state(0.0), slip, state(1.0 + value), Some(Vec::new())])
            })
            .collect();
        let points = |kind: Kind| -> Vec<usize> {
            branches(&found).iter().filter(|it| it.kind == kind).map(|it| it.points.len()).collect()
        };
        assert_eq!(points(Kind::Equilibrium), [5]);
        assert_eq!(points(Kind::StickSlipCycle), [5]);
        assert_eq!(points(Kind::SlipCycle), [2, 2]);
        assert!(points(Kind::CrossingCycle).is_empty());
        let words = unknown(&found, "c");
        assert!(words.len() == 1 && words[0].contains("every slip cycle at 1 of 5 values of c"), "{words:?}");
    }
}

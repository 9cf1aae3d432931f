//! Slices of the map: one panel per method, with the exact boundary as a curve.

use super::super::text::{Rich, rich};
use super::super::{ReportError, SIMULATION};
use super::Figure;
use super::axis::{Panel, Panels};
use super::exact::boundary;
use super::legend::{Legend, Sample};
use super::palette;
use super::region::{cell_edges, outlines};
use super::scene::{Fill, Place, Scene, Stroke, Width};
use super::slice::{Slice, telling};
use crate::map::Verdict;
use crate::simulate::critical_damping;
use crate::store::MapFile;

/// At most so many eps get slices of their own.
const MOST_EPSILONS: usize = 4;

/// The exact boundary: black, on white so that it shows on dark areas.
pub(super) const EXACT: Stroke = Stroke::solid(palette::BLACK, 1.0);
pub(super) const HALO: Stroke = Stroke::solid(palette::WHITE, 2.4);

/// What a cell of a method's panel says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Verdict(Verdict),
    WrongPresence,
    WrongAbsence,
}

impl Kind {
    const ALL: [Kind; 7] = [
        Kind::Verdict(Verdict::Present),
        Kind::Verdict(Verdict::Absent),
        Kind::Verdict(Verdict::Undecided),
        Kind::WrongPresence,
        Kind::WrongAbsence,
        Kind::Verdict(Verdict::Failed),
        Kind::Verdict(Verdict::NotComputed),
    ];

    fn of(method: i8, simulation: Option<i8>) -> Self {
        let (present, absent) = (Verdict::Present.code(), Verdict::Absent.code());
        match simulation {
            Some(simulation) if method == present && simulation == absent => Kind::WrongPresence,
            Some(simulation) if method == absent && simulation == present => Kind::WrongAbsence,
            _ => Kind::Verdict(
                Verdict::ALL.into_iter().find(|verdict| verdict.code() == method).unwrap_or(Verdict::Failed),
            ),
        }
    }

    fn fill(self) -> Fill {
        match self {
            Kind::Verdict(verdict) => palette::verdict(verdict),
            Kind::WrongPresence => palette::WRONG_PRESENCE,
            Kind::WrongAbsence => palette::WRONG_ABSENCE,
        }
    }

    fn name(self) -> &'static str {
        match self {
            Kind::Verdict(Verdict::Present) => "cycle exists",
            Kind::Verdict(Verdict::Absent) => "no cycle",
            Kind::Verdict(Verdict::Undecided) => "not decided",
            Kind::Verdict(Verdict::Failed) => "failed",
            Kind::Verdict(Verdict::NotComputed) => "not computed",
            Kind::WrongPresence => "wrong: claims a cycle",
            Kind::WrongAbsence => "wrong: denies a cycle",
        }
    }
}

/// The plane of a map in which verdicts change most visibly: the longest axis of the law or V across,
/// c upwards; the two longest axes if c has one node.
#[must_use]
pub fn main_plane(map: &MapFile) -> (usize, usize) {
    let axes = map.grid().axes();
    let c = axes.len() - 1;
    let mut others: Vec<usize> = (0..c).collect();
    // The longest first; of equally long ones the fastest, which is V, then the law's last parameter.
    others.sort_by_key(|&axis| (std::cmp::Reverse((axes[axis].values.len(), axis.min(1))), c - axis));
    let longest =
        others.iter().copied().find(|&axis| axis > 0 || axes[0].values.len() > 1).unwrap_or(others[0]);
    if axes[c].values.len() > 1 {
        return (longest, c);
    }
    let second = others.iter().copied().find(|&axis| axis != longest).unwrap_or(c);
    (second.min(longest), second.max(longest))
}

/// The eps at which slices are drawn: all, or evenly chosen ones.
#[must_use]
pub fn chosen_epsilons(map: &MapFile) -> Vec<usize> {
    let count = map.grid().axes()[0].values.len();
    if count <= MOST_EPSILONS {
        return (0..count).collect();
    }
    (0..MOST_EPSILONS).map(|i| i * (count - 1) / (MOST_EPSILONS - 1)).collect()
}

/// The slices of a report.
///
/// # Errors
/// [`ReportError::Map`] if the map cannot be read.
pub fn slices(map: &MapFile) -> Result<Vec<Figure>, ReportError> {
    let axes = map.grid().axes();
    let c = axes.len() - 1;
    let (x, y) = main_plane(map);
    let index = telling(map);
    let mut planes = vec![(x, y, index.clone())];
    // A second plane, across the law's parameters and V at fixed c.
    let mut others: Vec<usize> = (1..c).filter(|&axis| axes[axis].values.len() > 1 && axis != x).collect();
    others.sort_by_key(|&axis| std::cmp::Reverse(axes[axis].values.len()));
    if let (Some(&second), true) = (others.first(), y == c && x > 0) {
        let mut index = index;
        index[c] = telling_damping(map, &index);
        planes.push((x.min(second), x.max(second), index));
    }
    let mut figures = Vec::new();
    for (x, y, index) in planes {
        let epsilons = if x == 0 { vec![0] } else { chosen_epsilons(map) };
        for epsilon in epsilons {
            let mut index = index.clone();
            index[0] = epsilon;
            figures.push(figure(map, &Slice::new(map, x, y, index))?);
        }
    }
    Ok(figures)
}

/// The node of c at which a plane of fixed c tells most: half of the critical damping in its middle.
fn telling_damping(map: &MapFile, index: &[usize]) -> usize {
    let axes = map.grid().axes();
    match critical_damping(&map.grid().column(index), 1e-6) {
        Ok(root) if root.c > 0.0 => axes[axes.len() - 1].nearest(0.5 * root.c),
        Ok(_) | Err(_) => 0,
    }
}

fn figure(map: &MapFile, slice: &Slice) -> Result<Figure, ReportError> {
    let methods = map.methods();
    let codes = methods
        .iter()
        .map(|method| slice.codes(&format!("verdict_{}", method.name)))
        .collect::<Result<Vec<_>, _>>()?;
    let simulation = methods.iter().position(|method| method.name == SIMULATION);
    let (x, y) = (slice.x_axis(), slice.y_axis());
    let ((x_scale, x_name), (y_scale, y_name)) = (slice.x_scale(), slice.y_scale());
    let (x_edges, y_edges) = (cell_edges(&slice.x_nodes(), x_scale), cell_edges(&slice.y_nodes(), y_scale));
    let kind = |method: usize, i: usize, j: usize| {
        Kind::of(codes[method][[i, j]], simulation.map(|simulation| codes[simulation][[i, j]]))
    };
    let mut scenes = Vec::new();
    let mut exact: Option<(Panel, Vec<Vec<Place>>)> = None;
    for width in Width::ALL {
        let columns = match width {
            Width::OneColumn => 2,
            Width::TwoColumns => 4,
        };
        let mut scene = Scene::new(width.points(), 0.0);
        let panels = Panels::new(scene.width, columns, methods.len(), 0.78, x_scale, y_scale);
        let mut used = [false; Kind::ALL.len()];
        for (m, (method, panel)) in methods.iter().zip(&panels.panels).enumerate() {
            for (n, known) in Kind::ALL.into_iter().enumerate() {
                let areas = outlines(panel, &x_edges, &y_edges, |i, j| kind(m, i, j) == known);
                used[n] |= !areas.is_empty();
                scene.area(&areas, known.fill());
            }
            // The boundary is searched once and moved from panel to panel.
            let (drawn, curves) = exact.get_or_insert_with(|| (*panel, boundary(slice, panel)));
            draw_curves(&mut scene, curves, drawn, panel);
            let letter = char::from(b'a' + (m % 26) as u8);
            panel.title(&mut scene, &rich(&format!("({letter}) ")).then(method_title(&method.name)));
        }
        panels.axes(&mut scene, &x_name, &y_name);
        let mut legend = Legend::default();
        for (kind, used) in Kind::ALL.into_iter().zip(used) {
            if used {
                legend.add(Sample::Area(kind.fill()), rich(kind.name()));
            }
        }
        if exact.as_ref().is_some_and(|(_, curves)| !curves.is_empty()) {
            legend.add(Sample::Line(EXACT), rich("exact boundary"));
        }
        legend.below(&mut scene, panels.panels[0].rect.x, panels.bottom);
        scenes.push((width, scene));
    }
    let epsilon = match slice.x {
        0 => String::new(),
        _ => format!("-{}", slice.index[0] + 1),
    };
    Ok(Figure {
        name: format!("slice-{}-{}{epsilon}", x.name, y.name),
        caption: rich("Verdicts of each method over ")
            .then(Rich::symbol(&x.name))
            .then(rich(" and "))
            .then(Rich::symbol(&y.name))
            .then(rich(" at "))
            .then(slice.held())
            .then(rich(". Black curve: the exact boundary of the stick-slip region, by root-finding on the simulated flow."))
            .then(slice.thinned_words()),
        scenes,
    })
}

/// A place of one panel in another one of the same scales.
fn moved((x, y): Place, from: &Panel, to: &Panel) -> Place {
    let unit = ((x - from.rect.x) / from.rect.w, (y - from.rect.y) / from.rect.h);
    (to.rect.x + unit.0 * to.rect.w, to.rect.y + unit.1 * to.rect.h)
}

/// The name of a method for people.
pub(super) fn method_title(name: &str) -> Rich {
    Rich::foreign(&name.replace('_', " "))
}

/// Draws boundaries that were searched in another panel of the same scales.
pub(super) fn draw_curves(scene: &mut Scene, curves: &[Vec<Place>], from: &Panel, to: &Panel) {
    scene.clipped(to.rect, |scene| {
        for curve in curves {
            let moved: Vec<Place> = curve.iter().map(|place| moved(*place, from, to)).collect();
            scene.line(&moved, &HALO);
            scene.line(&moved, &EXACT);
        }
    });
}

/// Draws the exact boundary of a slice into its panel; `false` if there is none.
pub(super) fn draw_exact(scene: &mut Scene, slice: &Slice, panel: &Panel) -> bool {
    let curves = boundary(slice, panel);
    draw_curves(scene, &curves, panel, panel);
    !curves.is_empty()
}

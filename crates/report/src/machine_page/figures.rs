//! The figures of the page: the regimes around the working point, and the friction that makes them.

use slipmap_model::friction::Column;
use std::convert::Infallible;
use std::sync::{Mutex, PoisonError};

use super::super::figure::bifurcations;
use super::super::figure::palette;
use super::super::units::UnitSystem;
use slipmap_figure::axis::{SMALL_TEXT, Scale, extremes};
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::{BOTTOM_MARGIN, Labels, Panel, TITLE_MARGIN, left_margin};
use slipmap_figure::region::{cell_edges, outlines};
use slipmap_figure::scene::{Fill, Marker, Rect, Scene, Stroke};
use slipmap_figure::style;
use slipmap_figure::text::{Rich, rich};
use slipmap_map::assessment::Assessment;
use slipmap_map::machine::{Dimension, Friction, Model};
use slipmap_map::map::{
    self, Account, Control, Field, Grid, Method, Plan, Plane, PlaneCurve, PlaneCurves, PlanePoint, Regime,
    Sink, TileData,
};
use slipmap_model::point::Point;
use slipmap_simulate::bifurcation::Bifurcation;
use slipmap_simulate::critical::{critical_dampings, known_or_nan};

/// Number of nodes of the regime figure along each axis.
const NODES: usize = 41;
/// Accuracy of its cells.
const TOLERANCE: f64 = 1e-8;
/// Width of a figure on the page, in points.
pub(super) const FIGURE: f64 = 252.0;
/// Room right of a panel.
const RIGHT_MARGIN: f64 = 12.0;
const BELT_SPEED: &str = "belt_speed";

/// Codes of regimes, column by column.
#[derive(Default)]
struct Columns(Mutex<Vec<(usize, Vec<i8>)>>);

impl Sink for Columns {
    type Packed = (usize, Vec<i8>);
    type Error = Infallible;

    fn pack(&self, data: &TileData) -> Result<Self::Packed, Infallible> {
        Ok((data.tile.number, data.regime.values().map(Regime::code).collect()))
    }

    fn write(&self, column: Self::Packed, _: &Account) -> Result<(), Infallible> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).push(column);
        Ok(())
    }
}

/// Codes of the regimes over belt speeds (slower) and dampings.
fn regimes_over(grid: &Grid) -> Option<Vec<Vec<i8>>> {
    let mut column = vec![1; grid.axes().len()];
    *column.last_mut()? = grid.dampings().len();
    let plan = Plan::builder(grid.clone())
        .methods([Method::Simulation])
        .fields([Field::Verdict, Field::Regime])
        .tolerance(TOLERANCE)
        .audit_cells(0)
        .tile_shape(column)
        .build();
    let columns = Columns::default();
    map::run(&plan.ok()?, &columns, &Control::default()).ok()?;
    let mut columns = columns.0.into_inner().unwrap_or_else(PoisonError::into_inner);
    columns.sort_unstable();
    Some(columns.into_iter().map(|(_, codes)| codes).collect())
}

/// The Hopf damping and the critical damping over belt speeds. This is fast for every law; continuation in
/// the plane is not.
fn limits(grid: &Grid, point: &Point, speeds: &[f64]) -> Vec<PlaneCurve> {
    let columns: Vec<Column> =
        speeds.iter().map(|&belt_speed| grid.law().column(&Point { belt_speed, ..*point })).collect();
    let hopf = columns.iter().map(|column| column.curve.weakening(column.belt_speed) / column.epsilon);
    let grazing = critical_dampings(&columns, TOLERANCE).into_iter().map(known_or_nan);
    let curve = |bifurcation, dampings: Vec<f64>| {
        let all = speeds.iter().zip(dampings).filter(|(_, damping)| damping.is_finite());
        let points = all.map(|(&x, y)| PlanePoint { x, y, error: TOLERANCE }).collect();
        PlaneCurve { bifurcation, points }
    };
    vec![curve(Bifurcation::Hopf, hopf.collect()), curve(Bifurcation::GrazingSliding, grazing.collect())]
}

/// The fastest belt speed of the regime figure, in SI units: somewhat beyond the machine's and the critical one.
/// Orbits reach slip speeds of twice the belt speed and somewhat more, so beyond half the end of measured data
/// they would fail.
fn fastest_shown(all: &Assessment) -> f64 {
    let machine = &all.machine;
    let must = all.behaviour.critical_belt_speed.value().unwrap_or(0.0).max(machine.belt_speed);
    let end = match &machine.friction {
        Friction::Measured(table) => 0.47 * table.fastest(),
        Friction::Coefficients(..) | Friction::Formula(..) => f64::INFINITY,
    };
    (1.4 * must).min(end.max(must))
}

/// The regimes around the working point, with the curves between them, in a panel of height `height`.
pub(super) fn regimes(all: &Assessment, height: f64) -> Scene {
    let machine = &all.machine;
    let units = machine.units();
    let does = &all.behaviour;
    let speed = fastest_shown(all);
    let damping =
        does.critical_damping.unwrap_or(machine.damping).max(machine.damping).max(1e-3 * units.damping) * 1.6;
    let nodes = |to: f64, least: f64| -> Vec<f64> {
        (0..NODES).map(|i| (i as f64 / (NODES - 1) as f64 * to).max(least)).collect()
    };
    let speeds = nodes(speed / units.velocity, 0.02 * speed / units.velocity / NODES as f64);
    let dampings = nodes(damping / units.damping, 0.0);
    let system = UnitSystem::of_machine(machine.si());
    let velocity =
        system.quantity(&machine.motion.words(BELT_SPEED), Rich::default(), "", Some(Dimension::Velocity));
    let friction = system.quantity("damping", Rich::default(), "", Some(Dimension::Damping));
    let x = Scale::linear(speeds[0], speeds[NODES - 1]).in_unit(velocity.factor);
    let y = Scale::linear(0.0, dampings[NODES - 1]).in_unit(friction.factor);
    let mut scene = Scene::new(FIGURE, 0.0);
    let labels = Panel::y_labels_width(y, height);
    let left = left_margin(labels);
    let rect = Rect { x: left, y: TITLE_MARGIN, w: FIGURE - left - RIGHT_MARGIN, h: height };
    let panel = Panel { rect, x, y };
    let of_curve = match machine.friction {
        Friction::Measured(_) => " of the curve through the data",
        Friction::Coefficients(..) | Friction::Formula(..) => "",
    };
    panel.title(&mut scene, &Rich::foreign(&format!("Regimes{of_curve}; diamond: working point")));
    let mut legend = Legend::default();
    let Some(Model { law, point, .. }) = machine.model() else { return scene };
    let mut axes = vec![vec![1.0]];
    axes.extend(point.law.as_slice().iter().map(|value| vec![*value]));
    axes.extend([speeds.clone(), dampings.clone()]);
    let grid = Grid::new(law, axes).ok();
    let cells = grid.as_ref().and_then(regimes_over).unwrap_or_default();
    let code = |i: usize, j: usize| cells.get(i).and_then(|column: &Vec<i8>| column.get(j)).copied();
    let edges = (cell_edges(&speeds, x), cell_edges(&dampings, y));
    for kind in palette::regimes() {
        let areas = outlines(&panel, &edges.0, &edges.1, |i, j| code(i, j) == Some(kind.code));
        if !areas.is_empty() {
            scene.area(&areas, kind.fill);
            legend.add(Sample::Area(kind.fill), rich(&kind.words));
        }
    }
    if let Some(grid) = grid {
        let last = grid.axes().len() - 1;
        let plane = Plane::new(last - 1, last, vec![0; last + 1]);
        let curves = PlaneCurves { plane, curves: limits(&grid, &point, &speeds) };
        bifurcations::draw(&mut scene, &panel, &curves, &mut legend);
    }
    let here = panel.place(machine.belt_speed / units.velocity, machine.damping / units.damping);
    scene.marker(Marker::Diamond, here, 8.0, style::WHITE, true);
    scene.marker(Marker::Diamond, here, 6.0, style::VERMILION, true);
    panel.named_axes(&mut scene, &velocity.text(), &friction.text(), labels);
    legend.below(&mut scene, panel.rect.x, panel.rect.y + panel.rect.h + BOTTOM_MARGIN);
    scene
}

/// Number of points of the friction curve.
const POINTS: usize = 200;
/// Height of the panel of weights in units of that of friction.
const WEIGHTS: f64 = 0.7;
/// Room above the second of two panels.
const BETWEEN: f64 = TITLE_MARGIN + 4.0;

/// The friction at the slip speeds of the vibration and, where known, the weight of its slope there for the
/// critical damping, in panels of total height `height`.
pub(super) fn friction(all: &Assessment, height: f64) -> Scene {
    let mut scene = Scene::new(FIGURE, 0.0);
    let machine = &all.machine;
    let Some(model) = machine.model() else { return scene };
    let table = match &machine.friction {
        Friction::Measured(table) => Some(table),
        _ => None,
    };
    let weights = &all.influence;
    // The middle of the first part is half its width.
    let fastest = match weights.first() {
        Some(first) => first.slip_speed * 2.0 * weights.len() as f64,
        None => 2.0 * machine.belt_speed,
    };
    let x = Scale::linear(0.0, fastest);
    let (curve, rest) = (model.column().curve, machine.friction.at_rest());
    let end = table.map_or(fastest, |table| table.fastest().min(fastest));
    let friction = |u: f64| rest * curve.phi(u / model.si.units.velocity);
    let line: Vec<(f64, f64)> =
        (0..=POINTS).map(|i| end * i as f64 / POINTS as f64).map(|u| (u, friction(u))).collect();
    let errors =
        |row: usize| table.and_then(|table| table.standard_errors()).map_or(0.0, |errors| errors[row]);
    let data = table.into_iter().flat_map(|table| table.data()).enumerate();
    let data: Vec<(f64, f64, f64)> =
        data.map(|(row, (u, friction))| (u, friction, errors(row))).filter(|(u, ..)| *u <= fastest).collect();
    let ends = data.iter().flat_map(|(_, friction, error)| [friction - error, friction + error]);
    let (least, most) = extremes(ends.chain(line.iter().map(|(_, friction)| *friction)));
    let room = 0.08 * (most - least);
    let y = Scale::linear(least - room, most + room);
    let largest = weights.iter().map(|part| part.share).fold(0.0, f64::max);
    let shares = Scale::linear(0.0, 105.0 * largest);

    let [upper, lower] = match weights.is_empty() {
        true => [height, 0.0],
        false => [1.0, WEIGHTS].map(|share| share * (height - BETWEEN) / (1.0 + WEIGHTS)),
    };
    let left = Panel::y_labels_width(y, upper).max(Panel::y_labels_width(shares, lower.max(1.0))) + 8.0;
    let panel = |top: f64, height: f64, y: Scale| {
        let rect = Rect { x: left, y: top, w: FIGURE - left - RIGHT_MARGIN, h: height };
        Panel { rect, x, y }
    };
    let curve_panel = panel(TITLE_MARGIN, upper, y);
    let at_belt = curve_panel.place(machine.belt_speed, 0.0).0;
    let Rect { y: top, h, .. } = curve_panel.rect;
    let guide = Stroke { color: style::GREY, width: 0.7, dash: &[3.0, 2.0] };
    scene.line(&[(at_belt, top), (at_belt, top + h)], &guide);
    let places: Vec<_> = line.iter().map(|(u, friction)| curve_panel.place(*u, *friction)).collect();
    scene.line(&places, &Stroke::solid(style::BLUE, 1.2));
    for (u, friction, error) in data {
        if error > 0.0 {
            let ends = [friction - error, friction + error].map(|friction| curve_panel.place(u, friction));
            scene.line(&ends, &Stroke::solid(style::BLACK, 0.7));
        }
        scene.marker(Marker::Circle, curve_panel.place(u, friction), 2.6, style::BLACK, true);
    }
    let with_errors = table.is_some_and(|table| table.standard_errors().is_some());
    let errors = if with_errors { " ± standard error" } else { "" };
    let unit = if machine.normal_force_is_known { "" } else { machine.motion.unit(Dimension::Force) };
    let unit = if unit.is_empty() { String::new() } else { format!(", {unit}") };
    let name = machine.words_of_friction();
    let name = name[..1].to_uppercase() + &name[1..];
    let speed = machine.motion.words(BELT_SPEED);
    curve_panel.title(&mut scene, &Rich::foreign(&format!("{name}{unit}{errors}; dashed: the {speed}")));
    let mut lowest = curve_panel;
    if !weights.is_empty() {
        let panel = panel(TITLE_MARGIN + upper + BETWEEN, lower, shares);
        for part in weights {
            let half = weights[0].slip_speed;
            let low = panel.place(part.slip_speed - half, 0.0);
            let high = panel.place(part.slip_speed + half, 100.0 * part.share);
            let rect = Rect { x: low.0, y: high.1, w: high.0 - low.0, h: low.1 - high.1 };
            scene.rect(rect, Fill::plain(style::SKY));
        }
        curve_panel.axes(&mut scene, Labels { x: false, y: true });
        panel.title(&mut scene, &rich("Weight of the friction's slope at each slip speed, %"));
        lowest = panel;
    }
    lowest.axes(&mut scene, Labels { x: true, y: true });
    let velocity = machine.motion.unit(Dimension::Velocity);
    lowest.x_name(&mut scene, &Rich::foreign(&format!("slip speed, {velocity}")));
    scene.height = lowest.rect.y + lowest.rect.h + BOTTOM_MARGIN + SMALL_TEXT;
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine_page::tests::example;
    use slipmap_map::assessment::assess;
    use slipmap_map::machine::Machine;
    use slipmap_model::friction::{Law, Table};

    #[test]
    fn the_regimes_end_where_the_data_do() {
        let phi = |u: f64| 0.29 + 0.15 * (-u / 0.05).exp() - 0.01 * u;
        let of = |end: f64| {
            let data: Vec<(f64, f64)> =
                [0.0, 0.03, 0.06, 0.1, 0.2, 0.4, 1.0].map(|share| (share * end, phi(share * end))).into();
            let friction = Friction::Measured(Table::new("a pad", &data, data[0].1).unwrap());
            let [mass, stiffness, normal_force, belt_speed, damping] = [1.8, 4.2e5, 900.0, 0.1, 80.0];
            let like = example(Law::Stribeck);
            assess(&Machine { friction, mass, stiffness, normal_force, belt_speed, damping, ..like }).unwrap()
        };
        let all = of(1.2);
        let critical = all.behaviour.critical_belt_speed.value().unwrap();
        assert!(critical > 0.43 && critical < 0.5, "else the data do not end the picture: {critical}");
        assert!((fastest_shown(&all) - 0.47 * 1.2).abs() < 1e-9);
        // Without data the picture goes on beyond the critical speed.
        let all = assess(&example(Law::Exponential)).unwrap();
        let critical = all.behaviour.critical_belt_speed.value().unwrap();
        assert!((fastest_shown(&all) / critical - 1.4).abs() < 1e-9);
    }
}

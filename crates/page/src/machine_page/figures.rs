//! The figures of the page: the regimes around the working point, and the friction that makes them.

use std::sync::atomic::AtomicBool;
use std::sync::{Mutex, PoisonError};

use super::units::{Unit, Written};
use crate::curves::{self, Parts, along_curves};
use crate::palette;
use slipmap_column::bifurcation::Bifurcation;
use slipmap_column::{Method, Regime};
use slipmap_figure::axis::{SMALL_TEXT, Scale, extremes};
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::{BOTTOM_MARGIN, Labels, Panel, TITLE_MARGIN, left_margin};
use slipmap_figure::region::outlines;
use slipmap_figure::scene::{Fill, Marker, Rect, Scene, Stroke};
use slipmap_figure::style;
use slipmap_figure::text::{Rich, capital, rich};
use slipmap_machine::assessment::{Assessment, Statement};
use slipmap_machine::{Dimension, Friction, Model};
use slipmap_map::{Control, Each, Field, Grid, Plan, Plane, PlaneCurves, TileData};

/// Number of belt speeds of the regime figure.
const NODES: usize = 51;
/// Number of its dampings, which cost little: a column of them is decided at once.
const DAMPINGS: usize = 121;
/// Accuracy of its cells.
const TOLERANCE: f64 = 1e-8;
/// Width of a figure on the page, in points.
pub(super) const FIGURE: f64 = 252.0;
/// Room right of a panel.
const RIGHT_MARGIN: f64 = 12.0;
const BELT_SPEED: &str = "belt_speed";

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
    let columns = Mutex::new(Vec::new());
    let sink = Each(|data: &TileData| {
        let codes: Vec<i8> = data.regime.values().map(Regime::code).collect();
        columns.lock().unwrap_or_else(PoisonError::into_inner).push((data.tile.number, codes));
    });
    slipmap_map::run(&plan.ok()?, &sink, &Control::default()).ok()?;
    let mut columns = columns.into_inner().unwrap_or_else(PoisonError::into_inner);
    columns.sort_unstable();
    Some(columns.into_iter().map(|(_, codes)| codes).collect())
}

/// The belt speed at a share of the axis: the belt does not stand still.
fn speed_at(x: Scale, share: f64) -> f64 {
    x.value(share).max(3e-4 * x.to)
}

/// Ratio of two values of a quantity from which on an axis that must show both is logarithmic.
const DECADES: f64 = 8.0;

/// Parts of the cells across and up, by which areas follow the curves between them.
const PARTS: [usize; 2] = [8, 4];

/// The range of an axis that shows some values, with room beside them: from 0, or logarithmic where they differ by
/// more than [`DECADES`] and none is 0.
fn range(shown: &[f64], room: f64) -> Scale {
    let (least, most) = extremes(shown.iter().copied());
    match least > 0.0 && most > DECADES * least {
        true => Scale::logarithmic(least / (2.0 * room), most * room),
        false => Scale::linear(0.0, most * room),
    }
}

/// The ends of the intervals of belt speed in which it always and in which it may stick-slip, in SI units.
fn ends_of_speeds(all: &Assessment) -> Vec<f64> {
    let stick_slip = [Statement::AlwaysSticks, Statement::MayStick].map(|of| &all.speeds[of as usize].holds);
    let ends = stick_slip.into_iter().flatten().flatten();
    ends.filter_map(|end| Some(end.located()?[0])).collect()
}

/// The belt speeds of the regime figure, in SI units: those of the machine and of its limits. Orbits reach slip
/// speeds of twice the belt speed and somewhat more, so beyond half the end of measured data they would fail.
fn speeds_shown(all: &Assessment) -> Scale {
    let machine = &all.machine;
    let mut shown = ends_of_speeds(all);
    shown.push(machine.belt_speed);
    let scale = range(&shown, 1.4);
    match &machine.friction {
        Friction::Measured(table) => {
            let end = scale.to.min((0.47 * table.fastest()).max(machine.belt_speed));
            Scale { to: end, ..scale }
        }
        Friction::Coefficients(..) | Friction::Formula(..) => scale,
    }
}

/// Its dampings, in SI units: that of the machine, and its limits at the machine's speed.
fn dampings_shown(all: &Assessment) -> Scale {
    let (machine, does) = (&all.machine, &all.behaviour);
    let limits = [does.critical_damping, all.vibrates_below_damping, Some(all.hopf_damping)];
    let mut shown: Vec<f64> = limits.into_iter().flatten().filter(|limit| *limit > 0.0).collect();
    shown.push(machine.damping);
    if extremes(shown.iter().copied()).1 <= 0.0 {
        shown = vec![1e-3 * machine.units().damping];
    }
    range(&shown, 1.6)
}

/// The regimes around the working point, with the curves between them, in a panel of height `height`.
pub(super) fn regimes(all: &Assessment, written: &Written, height: f64) -> Scene {
    let machine = &all.machine;
    let units = machine.units();
    let label = |words: &str, shown: &Unit| Rich::foreign(&format!("{words}, {}", shown.name));
    let speed = Unit::of(machine, written, BELT_SPEED);
    let damping = Unit::of(machine, written, "damping");
    let in_units = |scale: Scale, unit: f64, shown: &Unit| {
        Scale { from: scale.from / unit, to: scale.to / unit, ..scale }.in_unit(unit / shown.size)
    };
    let x = in_units(speeds_shown(all), units.velocity, &speed);
    let y = in_units(dampings_shown(all), units.damping, &damping);
    let log = |scale: Scale| if scale.log { " (log scale)" } else { "" };
    let velocity = label(&machine.motion.words(BELT_SPEED), &speed).then(log(x));
    let friction = label("damping", &damping).then(log(y));
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
    let nodes = |number: usize| (0..number).map(move |i| i as f64 / (number - 1) as f64);
    let speeds: Vec<f64> = nodes(NODES).map(|share| speed_at(x, share)).collect();
    let dampings: Vec<f64> = nodes(DAMPINGS).map(|share| y.value(share)).collect();
    let mut axes = vec![vec![1.0]];
    axes.extend(point.law.as_slice().iter().map(|value| vec![*value]));
    axes.extend([speeds.clone(), dampings.clone()]);
    let grid = Grid::new(law, axes).ok();
    if let Some(grid) = grid {
        let last = grid.axes().len() - 1;
        let plane = Plane::new(last - 1, last, vec![0; last + 1]);
        let mut kinds = vec![Bifurcation::Hopf, Bifurcation::GrazingSliding];
        // Many backbones, which take long where the law has corners.
        if grid.law().curve(1.0, &point.law).corners().is_empty() {
            kinds.extend([Bifurcation::Crossing, Bifurcation::Fold]);
        }
        let lines = PlaneCurves::of_kinds(&kinds, &grid, plane, &AtomicBool::new(false));
        let shares = [NODES, DAMPINGS].map(|number| nodes(number).collect::<Vec<f64>>());
        let cells = regimes_over(&grid).unwrap_or_default();
        let between = |x: f64, y: f64| {
            let mut values = grid.values(&lines.plane.held);
            (values[last - 1], values[last]) = (x, y);
            grid.oscillator_of(&values).ok().as_ref().map(curves::regime_code)
        };
        let Parts { edges, cells } = along_curves(&panel, &cells, &shares, PARTS, &lines.curves, &between);
        for kind in palette::regimes() {
            let inside = |i: usize, j: usize| cells.get(i).is_some_and(|column| column[j] == kind.code);
            let areas = outlines(&panel, &edges[0], &edges[1], inside);
            if !areas.is_empty() {
                scene.area(&areas, kind.fill);
                legend.add(Sample::Area(kind.fill), rich(&kind.words));
            }
        }
        curves::draw(&mut scene, &panel, &lines, &mut legend, false);
    }
    let here = panel.place(machine.belt_speed / units.velocity, machine.damping / units.damping);
    scene.marker(Marker::Diamond, here, 8.0, style::WHITE, true);
    scene.marker(Marker::Diamond, here, 6.0, style::VERMILION, true);
    panel.named_axes(&mut scene, &velocity, &friction, labels);
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
pub(super) fn friction(all: &Assessment, written: &Written, height: f64) -> Scene {
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
    let speed_unit = Unit::of(machine, written, BELT_SPEED);
    let x = Scale::linear(0.0, fastest).in_unit(speed_unit.size.recip());
    let (curve, rest) = (model.column().curve, machine.friction.at_rest());
    let end = table.map_or(fastest, |table| table.fastest().min(fastest));
    let friction = |u: f64| rest * curve.phi(u / model.si.velocity);
    let line: Vec<(f64, f64)> =
        (0..=POINTS).map(|i| end * i as f64 / POINTS as f64).map(|u| (u, friction(u))).collect();
    let errors =
        |row: usize| table.and_then(|table| table.standard_errors()).map_or(0.0, |errors| errors[row]);
    let data = table.into_iter().flat_map(|table| table.data()).enumerate();
    let data: Vec<(f64, f64, f64)> =
        data.map(|(row, (u, friction))| (u, friction, errors(row))).filter(|(u, ..)| *u <= fastest).collect();
    let ends = data.iter().flat_map(|(_, friction, error)| [friction - error, friction + error]);
    let at_rest = (curve.drop() > 0.0).then_some(rest);
    let (least, most) = extremes(ends.chain(line.iter().map(|(_, friction)| *friction)).chain(at_rest));
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
    if let Some(rest) = at_rest {
        // The drop as slip begins.
        let [from, to] = [rest, line[0].1].map(|friction| curve_panel.place(0.0, friction));
        scene.line(&[from, to], &Stroke { color: style::BLUE, width: 1.2, dash: &[1.4, 1.4] });
        scene.marker(Marker::Circle, from, 4.0, style::BLUE, true);
    }
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
    let name = capital(machine.words_of_friction());
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
    lowest.x_name(&mut scene, &Rich::foreign(&format!("slip speed, {}", speed_unit.name)));
    scene.height = lowest.rect.y + lowest.rect.h + BOTTOM_MARGIN + SMALL_TEXT;
    scene
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::machine_page::tests::example;
    use slipmap_machine::Machine;
    use slipmap_machine::assessment::assess;
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
        assert!((speeds_shown(&all).to - 0.47 * 1.2).abs() < 1e-9);
        // Without data the picture goes on beyond the critical speed.
        let all = assess(&example(Law::Exponential)).unwrap();
        let critical = all.behaviour.critical_belt_speed.value().unwrap();
        assert!((speeds_shown(&all).to / critical - 1.4).abs() < 1e-9);
    }
}

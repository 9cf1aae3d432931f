//! The paper's figures 2 to 5, redrawn from computed orbits.
//!
//! Departures: the paper's sketches of impossible cases cannot be computed. Figure 3's false orbit is that of
//! negative damping, figure 4 shows the three cases that occur as c falls through the critical damping, and
//! figure 5 shows the closed orbit where it exists: unstable, in the bistable band.

use std::f64::consts::TAU;

use super::super::text::{Rich, rich};
use super::axis::{SMALL_TEXT, Scale};
use super::curves::Budget;
use super::legend::{Legend, Sample};
use super::panels::{BOTTOM_MARGIN, Panel, Panels, TITLE_MARGIN};
use super::portrait::{BELT, ORBIT, OTHER, SEGMENT, equal_scales, orbit};
use super::scene::{Anchor, Marker, Place, Rect, Scene, Stroke};
use super::{Data, Figure, at_each_width, curves, palette};
use slipmap_model::filippov::{Oscillator, Side};
use slipmap_model::friction::{Column, Law};
use slipmap_model::point::{LawParameters, Point};
use slipmap_witness::{Ending, Phase, Start, trace};

/// Accuracy of the orbits.
const TOLERANCE: f64 = 1e-10;

/// The oscillator of the figures.
fn column(epsilon: f64, [alpha, beta, gamma]: [f64; 3]) -> Column {
    Law::Stribeck.column(&Point {
        epsilon,
        law: LawParameters::new(&[alpha, beta, gamma]),
        belt_speed: 1.0,
        damping: 0.0,
    })
}

pub(crate) fn figures() -> Vec<Figure> {
    vec![fields(), coulomb(), cases(), divergence()]
}

/// A figure of one panel with equal units along both axes.
fn single(
    name: &str,
    caption: Rich,
    extent: [f64; 4],
    draw: impl Fn(&mut Scene, &Panel, &mut Legend),
) -> Figure {
    let scenes = at_each_width(|scene, _| {
        let labels_width = 18.0;
        let left = super::panels::left_margin(labels_width);
        let w = scene.width - left - 10.0;
        let (x, y, h) = equal_scales(extent, w, (0.25, 0.8));
        let panel = Panel { rect: Rect { x: left, y: TITLE_MARGIN - 4.0, w, h }, x, y };
        let mut legend = Legend::default();
        draw(scene, &panel, &mut legend);
        panel.named_axes(scene, &rich("{x_1}"), &rich("{x_2}"), labels_width);
        legend.below(scene, left, panel.rect.y + h + BOTTOM_MARGIN);
    });
    Figure { name: name.into(), caption, scenes, data: Data::default() }
}

/// The belt line with its stick segment.
fn belt(scene: &mut Scene, panel: &Panel, oscillator: &Oscillator) {
    let v = oscillator.belt_speed;
    scene.clipped(panel.rect, |scene| {
        scene.line(&[panel.place(panel.x.from, v), panel.place(panel.x.to, v)], &BELT);
        let (from, to) = (oscillator.upper_tangency_x1(), oscillator.exit_x1());
        scene.line(&[panel.place(from, v), panel.place(to, v)], &SEGMENT);
    });
}

fn exit_point(scene: &mut Scene, panel: &Panel, oscillator: &Oscillator) {
    let at = panel.place(oscillator.exit_x1(), oscillator.belt_speed);
    scene.marker(Marker::Circle, at, 5.0, palette::BLACK, true);
}

/// Figure 2: the two fields along the belt line.
fn fields() -> Figure {
    const LENGTH: f64 = 0.27;
    let oscillator = Oscillator::in_column(&column(0.1, [0.3, 0.1, 2.0]), 0.5);
    let v = oscillator.belt_speed;
    let caption = rich(
        "The vector fields on both sides of the belt line {x_2} = {V} (the paper's figure 2). On the stick segment both \
         point to the line; {epsilon} = 0.1, {alpha} = 0.3, {beta} = 0.1, {gamma} = 2, {V} = 1, {c} = 0.5.",
    );
    single("paper-figure-2", caption, [-2.2, 2.2, v - 0.45, v + 0.45], |scene, panel, legend| {
        belt(scene, panel, &oscillator);
        let above = Stroke::solid(palette::VERMILION, 0.9);
        let below = Stroke::solid(palette::BLUE, 0.9);
        for i in -6..=6 {
            let x1 = 0.34 * f64::from(i);
            for (side, stroke, from) in [(Side::Above, &above, 0.08), (Side::Below, &below, -0.08)] {
                let (dx, dy) = (v, oscillator.acceleration(side, x1, v));
                let scale = LENGTH / dx.hypot(dy);
                let (dx, dy) = (scale * dx, scale * dy);
                // Arrows towards the line end there, the others start there.
                let towards = (dy < 0.0) == (from > 0.0);
                let start = (x1 - 0.5 * dx, if towards { v + from - dy } else { v + from });
                let end = (start.0 + dx, start.1 + dy);
                scene.clipped(panel.rect, |scene| {
                    scene.arrow(panel.place(start.0, start.1), panel.place(end.0, end.1), stroke);
                });
            }
        }
        exit_point(scene, panel, &oscillator);
        legend.add(Sample::Line(above), rich("field above the belt line"));
        legend.add(Sample::Line(below), rich("field below the belt line"));
        legend.add(Sample::Line(SEGMENT), rich("stick segment"));
        legend.add(Sample::Mark(Marker::Circle, palette::BLACK, true), rich("exit point"));
    })
}

/// Figure 3: Coulomb friction alone has no stick-slip cycle.
fn coulomb() -> Figure {
    let mut oscillator = Oscillator::in_column(&column(0.1, [1.0, 0.0, 0.0]), 1.2);
    let inward = trace(&oscillator, Start::ExitPoint, TOLERANCE, 2.2 * TAU);
    let damped = oscillator.clone();
    oscillator.viscous = -oscillator.viscous;
    let outward = trace(&oscillator, Start::ExitPoint, TOLERANCE, TAU);
    let caption = rich(
        "Coulomb friction alone (the paper's figure 3): the orbit from the exit point spirals inward. The dashed orbit, \
         which would come back to the belt, is that of the same system with negative damping; {epsilon} {c} = 0.12, {V} = 1.",
    );
    single("paper-figure-3", caption, [-1.2, 2.2, -1.15, 1.2], |scene, panel, legend| {
        belt(scene, panel, &damped);
        scene.clipped(panel.rect, |scene| {
            orbit(scene, panel, &oscillator, &outward.samples, &OTHER);
            orbit(scene, panel, &damped, &inward.samples, &ORBIT);
        });
        exit_point(scene, panel, &damped);
        let equilibrium = panel.place(damped.equilibrium_x1(), 0.0);
        scene.marker(Marker::Square, equilibrium, 5.0, palette::BLACK, true);
        legend.add(Sample::Line(ORBIT), rich("true orbit"));
        legend.add(Sample::Line(OTHER), rich("false orbit"));
        legend.add(Sample::Line(SEGMENT), rich("stick segment"));
        legend.add(Sample::Mark(Marker::Square, palette::BLACK, true), rich("equilibrium"));
    })
}

/// Figure 4: the return of the orbit to the belt line as c falls.
fn cases() -> Figure {
    let column = column(0.1, [0.3, 0.1, 2.0]);
    let critical = curves::exact(std::slice::from_ref(&column), &Budget::of_figure())[0];
    let cases = [(1.8, "{c} > {c^*}"), (1.0, "{c} = {c^*}"), (0.55, "{c} < {c^*}")];
    let unperturbed: Vec<Place> = (0..=200)
        .map(|i| {
            let t = TAU * f64::from(i) / 200.0;
            (1.0 + t.sin(), t.cos())
        })
        .collect();
    let circle = Stroke { color: palette::GREY, width: 0.9, dash: &[4.0, 2.0] };
    let scenes = at_each_width(|scene, width| {
        let columns = width.select(1, 3);
        let (x, y) = (Scale::linear(0.25, 1.35), Scale::linear(0.72, 1.06));
        let panels = Panels::new(scene.width, columns, 3, 0.62, x, y);
        for (((factor, name), panel), letter) in
            cases.iter().zip(&panels.panels).zip(["(a) ", "(b) ", "(c) "])
        {
            let oscillator = Oscillator::in_column(&column, factor * critical);
            let orbit_of = trace(&oscillator, Start::ExitPoint, TOLERANCE, 1.08 * TAU);
            belt(scene, panel, &oscillator);
            scene.clipped(panel.rect, |scene| {
                let places: Vec<Place> = unperturbed.iter().map(|p| panel.place(p.0, p.1)).collect();
                scene.line(&places, &circle);
                let slipping: Vec<_> = orbit_of
                    .samples
                    .iter()
                    .copied()
                    .take_while(|s| s.t == 0.0 || s.phase != Phase::Stick)
                    .collect();
                let end = (slipping.len() + 1).min(orbit_of.samples.len());
                orbit(scene, panel, &oscillator, &orbit_of.samples[..end], &ORBIT);
                if let Some(landing) = orbit_of.samples.iter().find(|s| s.t > 0.0 && s.phase == Phase::Stick)
                {
                    let at = panel.place(landing.x1, landing.x2);
                    scene.marker(Marker::Triangle, at, 6.0, palette::VERMILION, true);
                }
            });
            exit_point(scene, panel, &oscillator);
            panel.title(scene, &rich(letter).then(rich(name)));
        }
        panels.axes(scene, &rich("{x_1}"), &rich("{x_2}"));
        let mut legend = Legend::default();
        legend.add(Sample::Line(ORBIT), rich("orbit from the exit point"));
        legend.add(Sample::Line(circle), rich("the same at {epsilon} = 0"));
        legend.add(Sample::Line(SEGMENT), rich("stick segment"));
        legend.add(Sample::Mark(Marker::Triangle, palette::VERMILION, true), rich("landing"));
        legend.add(Sample::Mark(Marker::Circle, palette::BLACK, true), rich("exit point"));
        legend.below(scene, panels.panels[0].rect.x, panels.bottom);
    });
    let caption = rich(
        "The orbit from the exit point near its return to the belt line (after the paper's figure 4): (a) it stays short \
         of the line, (b) it grazes the line at the exit point, (c) it lands on the stick segment; {epsilon} = 0.1, \
         {alpha} = 0.3, {beta} = 0.1, {gamma} = 2, {V} = 1.",
    );
    Figure { name: "paper-figure-4".into(), caption, scenes, data: Data::default() }
}

/// Figure 5: the closed orbit below the belt line.
fn divergence() -> Figure {
    let column = column(0.5, [0.0, 0.0, 2.0]);
    let (low, high) =
        (curves::stability(&column), curves::exact(std::slice::from_ref(&column), &Budget::of_figure())[0]);
    let c = 0.5 * (low + high);
    let oscillator = Oscillator::in_column(&column, c);
    let (centre, exit) = (oscillator.equilibrium_x1(), oscillator.exit_x1());
    // A point of the line L, at the fraction s of the way from the equilibrium to the exit point.
    let on_line = |s: f64| Start::State { x1: centre + s * (exit - centre), x2: s * oscillator.belt_speed };
    // Orbits inside the closed one tend to the equilibrium, those outside stick.
    let sticks = |s: f64| {
        let orbit = trace(&oscillator, on_line(s), TOLERANCE, 200.0 * TAU);
        match orbit.ending {
            Ending::Settles | Ending::Failed(_) => false,
            Ending::Closes { .. } | Ending::OutOfTime => {
                orbit.samples.iter().any(|s| s.phase == Phase::Stick)
            }
        }
    };
    let (mut inside, mut outside) = (0.05, 0.999);
    for _ in 0..26 {
        let middle = 0.5 * (inside + outside);
        if sticks(middle) { outside = middle } else { inside = middle }
    }
    let outer = trace(&oscillator, Start::ExitPoint, TOLERANCE, 1.5 * TAU);
    let closed = trace(&oscillator, on_line(0.5 * (inside + outside)), TOLERANCE, 1.02 * TAU);
    let inner = trace(&oscillator, on_line(0.55 * inside), TOLERANCE, 2.0 * TAU);
    let caption = rich(&format!(
        "A closed orbit below the belt line (after the paper's figure 5). It exists in the bistable band, where it is \
         unstable and parts the orbits that reach the stick-slip cycle from those that settle at the equilibrium; \
         {{epsilon}} = 0.5, {{alpha}} = {{beta}} = 0, {{gamma}} = 2, {{V}} = 1, {{c}} = {c:.3}. {{L}}: line from the equilibrium \
         through the exit point.",
    ));
    let closed_stroke = Stroke { color: palette::VERMILION, width: 1.2, dash: &[1.2, 1.6] };
    single("paper-figure-5", caption, [-1.1, 1.95, -1.1, 1.2], |scene, panel, legend| {
        belt(scene, panel, &oscillator);
        scene.clipped(panel.rect, |scene| {
            let reach = 1.12;
            let end = panel.place(centre + reach * (exit - centre), reach * oscillator.belt_speed);
            scene.line(&[panel.place(centre, 0.0), end], &Stroke::solid(palette::BLACK, 0.6));
            scene.text((end.0 + 3.0, end.1 + 5.0), &rich("{L}"), SMALL_TEXT, Anchor::Start);
            orbit(scene, panel, &oscillator, &inner.samples, &OTHER);
            orbit(scene, panel, &oscillator, &closed.samples, &closed_stroke);
            orbit(scene, panel, &oscillator, &outer.samples, &ORBIT);
        });
        exit_point(scene, panel, &oscillator);
        scene.marker(Marker::Square, panel.place(centre, 0.0), 5.0, palette::BLACK, true);
        legend.add(Sample::Line(ORBIT), rich("stick-slip cycle"));
        legend.add(Sample::Line(closed_stroke), rich("unstable closed orbit"));
        legend.add(Sample::Line(OTHER), rich("orbit inside it"));
        legend.add(Sample::Line(SEGMENT), rich("stick segment"));
        legend.add(Sample::Mark(Marker::Square, palette::BLACK, true), rich("stable equilibrium"));
    })
}

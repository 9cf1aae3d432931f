//! Figures of a point, drawn by the crate's own figure code.

use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;
use serde_json::{Value, json};

use super::refusal::Refusal;
use slipmap_column::backbone::Backbone;
use slipmap_column::crossing::beyond_slip;
use slipmap_column::sensitivity;
use slipmap_figure::axis::Scale;
use slipmap_figure::lines::{Chart, Curve, draw, extent};
use slipmap_figure::scene::Width;
use slipmap_figure::scene::{Marker, Scene, Stroke};
use slipmap_figure::style;
use slipmap_figure::style::LineStyle;
pub use slipmap_figure::text::{Rich, rich};
use slipmap_machine::Dimension;
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_page::orbit::{OrbitPlot, orbit_figure};
pub use slipmap_page::units::{Label, UnitSystem};
use slipmap_witness::Start;

const POINTS: usize = 200;
/// Accuracy of the backbone, far below the width of a line.
const TOLERANCE: f64 = 1e-9;

fn answer(name: &str, scene: &Scene, caption: &Rich) -> Value {
    json!({ "svg": scene.svg(name, caption), "caption": caption.plain() })
}

/// Phase portrait and time series.
pub(super) fn orbit(law: &Law, point: &Point, units: &UnitSystem, start: Option<[f64; 2]>) -> Value {
    let start = start.map_or(Start::ExitPoint, |[x1, x2]| Start::State { x1, x2 });
    let plot = OrbitPlot { law, point, start, duration: None, units, width: Width::OneColumn };
    let drawn = orbit_figure(&plot);
    let mut answer = answer("orbit", &drawn.scene, &drawn.caption);
    let panel = drawn.portrait;
    answer["panel"] = json!({
        "x": panel.rect.x,
        "y": panel.rect.y,
        "w": panel.rect.w,
        "h": panel.rect.h,
        "x1": [panel.x.from, panel.x.to],
        "x2": [panel.y.from, panel.y.to],
    });
    answer
}

fn line(name: Rich, color: &'static str, dash: &'static [f64], points: Vec<(f64, f64)>) -> Curve {
    let style = LineStyle { stroke: Stroke { color, width: 1.3, dash }, marker: Marker::Circle };
    Curve { name, style, points, marks: false }
}

fn chart(name: &str, title: &str, curves: Vec<Curve>) -> Chart {
    Chart { name: rich(name), title: rich(title), factor: 1.0, y: None, curves }
}

/// A vertical guide at `x` over the numbers of `curves`.
fn guide(name: Rich, x: f64, curves: &[Curve]) -> Curve {
    let (low, high) = extent(curves, |point| point.1);
    line(name, style::GREY, &[3.0, 2.0], vec![(x, low), (x, high)])
}

fn velocity(units: &UnitSystem, words: &str, symbol: &str) -> Label {
    units.quantity(words, rich(symbol), "", Some(Dimension::Velocity))
}

fn damping(units: &UnitSystem, words: &str, symbol: &str) -> Label {
    units.quantity(words, rich(symbol), "", Some(Dimension::Damping))
}

/// Number of ranges of slip speeds whose weights are shown.
const PARTS: usize = 40;

/// The weight of the friction's slope at each slip speed for the critical damping, in per cent, as steps;
/// empty where there is no critical damping.
fn weights(law: &Law, point: &Point) -> Vec<(f64, f64)> {
    let parts = sensitivity::influence(&law.column(point), PARTS).unwrap_or_default();
    let steps =
        parts.iter().flat_map(|part| [(part.from, 100.0 * part.share), (part.to, 100.0 * part.share)]);
    steps.chain(parts.last().map(|part| (part.to, 0.0))).collect()
}

/// The friction curve, its slope against the damping, and the weight of the slope at each slip speed.
pub(super) fn friction(law: &Law, point: &Point, units: &UnitSystem) -> Value {
    let curve = law.curve(point.epsilon, &point.law);
    let v = point.belt_speed;
    let weights = weights(law, point);
    let fastest = weights.last().map_or(2.0 * v, |(fastest, _)| fastest.max(2.0 * v));
    let sample = |of: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let at = |i: usize| fastest * i as f64 / POINTS as f64;
        (0..=POINTS).map(|i| (at(i), of(at(i)))).collect()
    };
    let phi = line(Rich::default(), style::BLUE, &[], sample(&|u| curve.phi(u)));
    let weakening = line(rich("weakening rate"), style::VERMILION, &[], sample(&|u| curve.weakening(u)));
    let viscous = point.epsilon * point.damping;
    let level = line(rich("damping {epsilon} {c}"), style::BLACK, &[5.0, 2.0], sample(&|_| viscous));
    let belt = |curves: &[Curve]| guide(rich("belt speed {V}"), v, curves);
    // Friction at rest, and the drop as slip begins.
    let rest = Curve {
        marks: true,
        ..line(Rich::default(), style::BLUE, &[1.4, 1.4], vec![(0.0, 1.0), phi.points[0]])
    };
    let mut above = if curve.drop() > 0.0 { vec![phi, rest] } else { vec![phi] };
    above.insert(0, belt(&above));
    let mut below = vec![weakening, level];
    below.insert(0, Curve { name: Rich::default(), ..belt(&below) });
    let rate = damping(units, "weakening", "-{phi}'({u})");
    let mut charts = vec![
        chart("{phi}({u})", "(a)", above),
        Chart { name: rate.text(), factor: rate.factor, ..chart("", "(b)", below) },
    ];
    let mut words = String::from(
        "(a) Friction {phi} over slip speed {u}, in units of friction at rest. (b) How fast it weakens, against the \
         damping: where the rate is above the line the motion gains energy.",
    );
    if !weights.is_empty() {
        let steps = line(Rich::default(), style::GREEN, &[], weights);
        charts.push(chart("weight of slope, %", "(c)", vec![steps]));
        words.push_str(
            " (c) Weight of the friction's slope at each slip speed: the critical damping moves as the weighted mean of \
             the rate does.",
        );
    }
    let slip = velocity(units, "slip speed", "slip speed {u}");
    let x = Scale::linear(0.0, fastest).in_unit(slip.factor);
    let scene = draw(&Rich::default(), x, &slip.text(), &charts, Width::OneColumn);
    answer("friction", &scene, &rich(&words))
}

/// Number of dampings at which cycles that reach the belt speed are searched.
const DAMPINGS: usize = 48;

/// Largest velocities of the stick-slip cycle and of the crossing cycles over the dampings from 0 to `most`,
/// NaN where there is no such cycle; and the kinds that are not known at some of the dampings, in words.
fn reaching_the_belt(
    law: &Law,
    point: &Point,
    most: f64,
    stop: &AtomicBool,
) -> Result<(Vec<Curve>, Vec<String>), Refusal> {
    // At the critical damping itself, which may be the largest, it cannot be decided whether an orbit sticks.
    let at = |i: usize| most * ((1.0 - 1e-6) * i as f64 / (DAMPINGS - 1) as f64);
    let found: Vec<(f64, [Option<f64>; 3])> = (0..DAMPINGS)
        .into_par_iter()
        .map(|i| {
            if stop.load(Ordering::Relaxed) {
                return Err(Refusal::stopped());
            }
            let oscillator = Oscillator::new(law, &Point { damping: at(i), ..*point });
            Ok((at(i), largest_velocities(&oscillator)))
        })
        .collect::<Result<_, _>>()?;
    let styles: [(&str, &str, &[f64]); 3] = [
        ("stick-slip cycle", style::BLUE, &[]),
        ("attracting crossing cycle", style::VERMILION, &[]),
        ("repelling crossing cycle", style::VERMILION, &[3.0, 2.0]),
    ];
    let (mut curves, mut unknown) = (Vec::new(), Vec::new());
    for (kind, (words, color, dash)) in styles.into_iter().enumerate() {
        let of_kind = || found.iter().map(|(c, velocities)| (*c, velocities[kind]));
        let points: Vec<(f64, f64)> =
            of_kind().map(|(c, velocity)| (c, velocity.unwrap_or(f64::NAN))).collect();
        if points.iter().any(|point| point.1.is_finite()) {
            curves.push(line(rich(words), color, dash, points));
        }
        let missing = of_kind().filter(|(_, velocity)| velocity.is_none()).count();
        if missing > 0 {
            unknown.push(format!(
                "at {missing} of {DAMPINGS} dampings it is not known whether there is a {words}"
            ));
        }
    }
    Ok((curves, unknown))
}

/// Largest velocities on the stick-slip cycle, the smallest crossing cycle that attracts and the smallest
/// that repels: NaN where there is none, `None` where it is not known.
fn largest_velocities(oscillator: &Oscillator) -> [Option<f64>; 3] {
    let (sticks, crossing) = beyond_slip(oscillator, TOLERANCE);
    let crosses = |attracts: bool| {
        let cycle = crossing.as_ref()?.iter().find(|cycle| cycle.is_stable() == attracts);
        Some(cycle.map_or(f64::NAN, |cycle| cycle.velocity.hi))
    };
    [sticks.map(|cycle| cycle.map_or(f64::NAN, |cycle| cycle.velocity.hi)), crosses(true), crosses(false)]
}

/// Largest velocity of every cycle against damping: the backbone of the slip cycles, and the cycles that
/// reach the belt speed.
pub(super) fn backbone(
    law: &Law,
    point: &Point,
    units: &UnitSystem,
    stop: &AtomicBool,
) -> Result<Value, Refusal> {
    let oscillator = Oscillator::new(law, point);
    let (v, epsilon) = (point.belt_speed, point.epsilon);
    let backbone = Backbone::of_curve(&oscillator.curve, v, TOLERANCE);
    let mut curves: Vec<Curve> = Vec::new();
    let mut named = [false; 2];
    for ends in backbone.iter().flat_map(|backbone| backbone.turning_points().windows(2)) {
        let attracts = ends[1].viscous < ends[0].viscous;
        let at = |i: usize| ends[0].radius + (ends[1].radius - ends[0].radius) * i as f64 / POINTS as f64;
        let viscous = |radius: f64| backbone.as_ref().map_or(f64::NAN, |backbone| backbone.viscous(radius));
        let points = (0..=POINTS).map(|i| (viscous(at(i)) / epsilon, at(i))).collect();
        let (words, dash): (_, &[f64]) =
            if attracts { ("attracting slip cycle", &[]) } else { ("repelling slip cycle", &[3.0, 2.0]) };
        let first = !std::mem::replace(&mut named[usize::from(attracts)], true);
        let name = if first { rich(words) } else { Rich::default() };
        curves.push(line(name, style::GREEN, dash, points));
    }
    let most = match &backbone {
        Ok(_) => extent(&curves, |point| point.0).1,
        // No cycle closes beyond it.
        Err(_) => Some(oscillator.curve.even_weakening_range(v).hi / epsilon)
            .filter(|c| c.is_finite())
            .unwrap_or(0.0),
    };
    let (reaching, mut unknown) = reaching_the_belt(law, point, most.max(point.damping), stop)?;
    curves.extend(reaching);
    if let Err(failure) = &backbone {
        unknown.push(format!("the slip cycles are not known: {failure}"));
    }
    if curves.is_empty() {
        let words = format!("no cycle can be drawn: {}", unknown.join("; "));
        return Err(Refusal::bad_input(words, "choose another point"));
    }
    let here = damping(units, "damping", "damping {c}");
    curves.push(guide(here.name.clone(), point.damping, &curves));
    let (low, high) = extent(&curves, |point| point.0);
    let room = (0.06 * (high - low)).max(1e-3);
    let largest = velocity(units, "largest velocity", "largest velocity {x_2}");
    let chart = Chart { name: largest.text(), factor: largest.factor, ..chart("", "", curves) };
    let x = Scale::linear(low - room, high + room).in_unit(here.factor);
    let scene = draw(&Rich::default(), x, &here.text(), &[chart], Width::OneColumn);
    let caption = rich(
        "Largest velocity of every cycle over damping. The backbone of the slip cycles is the one damping at which each \
         amplitude closes; cycles that stick or cross reach the belt speed and more.",
    );
    let caption =
        unknown.iter().fold(caption, |caption, what| caption.then(Rich::foreign(&format!(" Note: {what}."))));
    Ok(answer("backbone", &scene, &caption))
}

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_model::friction::Table;

    #[test]
    fn every_legal_damping_has_figures() {
        let units = UnitSystem::default();
        for damping in [0.0, 5e-324, 1e9, 1.7e308, f64::MAX] {
            let point = Law::Stribeck.point(0.1, &[0.3, 0.1, 2.0], 1.0, damping).unwrap();
            let drawn = [
                orbit(&Law::Stribeck, &point, &units, None),
                friction(&Law::Stribeck, &point, &units),
                backbone(&Law::Stribeck, &point, &units, &AtomicBool::new(false)).unwrap(),
            ];
            for figure in drawn {
                let svg = figure["svg"].as_str().unwrap();
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "c = {damping}: {svg}");
            }
        }
    }

    /// All orbits of the backbone and of the cycles leave data that end so soon: the refusal says what is not known.
    #[test]
    fn what_is_not_known_of_cycles_is_told() {
        let data = [(0.0, 1.0), (0.2, 0.8), (0.5, 0.6), (1.0, 0.5), (1.8, 0.48)];
        let law = Law::Table(Table::new("short", &data, 1.0).unwrap());
        let point = law.point(1.0, &[], 1.0, 0.01).unwrap();
        let refused = backbone(&law, &point, &UnitSystem::default(), &AtomicBool::new(false)).unwrap_err();
        let words = format!("{refused:?}");
        assert!(words.contains("whether there is a stick-slip cycle"), "{words}");
        assert!(words.contains("the slip cycles are not known"), "{words}");
    }
}

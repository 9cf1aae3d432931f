//! Figures of a point, drawn by the crate's own figure code.

use serde_json::{Value, json};

use super::refusal::Refusal;
use crate::filippov::Oscillator;
use crate::friction::Law;
use crate::point::Point;
use crate::report::figure::axis::Scale;
use crate::report::figure::lines::{Chart, Curve, draw};
use crate::report::figure::palette::{self, MethodStyle};
use crate::report::figure::scene::{Marker, Scene, Stroke};
use crate::report::figure::{OrbitPlot, Width, orbit_figure};
use crate::report::{Rich, UnitSystem, rich};
use crate::simulate::backbone::Backbone;
use crate::simulate::direct::Start;

/// Number of points of a curve.
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
    let style = MethodStyle { stroke: Stroke { color, width: 1.3, dash }, marker: Marker::Circle };
    Curve { name, style, points, marks: false }
}

fn chart(name: &str, title: &str, curves: Vec<Curve>) -> Chart {
    Chart { name: rich(name), title: rich(title), factor: 1.0, curves }
}

/// A vertical guide at `x` over the numbers of `curves`.
fn guide(name: Rich, x: f64, curves: &[Curve]) -> Curve {
    let numbers = || curves.iter().flat_map(|curve| &curve.points).map(|p| p.1).filter(|y| y.is_finite());
    let (low, high) = (numbers().fold(f64::INFINITY, f64::min), numbers().fold(f64::NEG_INFINITY, f64::max));
    line(name, palette::GREY, &[3.0, 2.0], vec![(x, low), (x, high)])
}

/// The friction curve, and its slope against the damping.
pub(super) fn friction(law: &Law, point: &Point) -> Value {
    let curve = law.curve(point.epsilon, &point.law);
    let v = point.belt_speed;
    let fastest = 2.0 * v;
    let sample = |of: &dyn Fn(f64) -> f64| -> Vec<(f64, f64)> {
        let at = |i: usize| fastest * i as f64 / POINTS as f64;
        (0..=POINTS).map(|i| (at(i), of(at(i)))).collect()
    };
    let phi = line(Rich::default(), palette::BLUE, &[], sample(&|u| curve.phi(u)));
    let weakening = line(rich("weakening rate"), palette::VERMILION, &[], sample(&|u| curve.weakening(u)));
    let viscous = point.epsilon * point.damping;
    let damping = line(rich("damping {epsilon} {c}"), palette::BLACK, &[5.0, 2.0], sample(&|_| viscous));
    let belt = |curves: &[Curve]| guide(rich("belt speed {V}"), v, curves);
    let above = vec![belt(std::slice::from_ref(&phi)), phi];
    let mut below = vec![weakening, damping];
    below.insert(0, Curve { name: Rich::default(), ..belt(&below) });
    let charts = [chart("{phi}({u})", "(a)", above), chart("-{phi}'({u})", "(b)", below)];
    let x = Scale::linear(0.0, fastest);
    let scene = draw(&Rich::default(), x, &rich("slip speed {u}"), &charts, Width::OneColumn);
    let caption = rich(
        "(a) Friction {phi} over slip speed {u}. (b) How fast it weakens, against the damping: where the rate is \
         above the line the motion gains energy.",
    );
    answer("friction", &scene, &caption)
}

/// Amplitude of every slip cycle against damping.
pub(super) fn backbone(law: &Law, point: &Point) -> Result<Value, Refusal> {
    let oscillator = Oscillator::new(law, point);
    let (v, epsilon) = (point.belt_speed, point.epsilon);
    let found = Backbone::of_curve(&oscillator.curve, v, TOLERANCE);
    let backbone = found.map_err(|failure| {
        Refusal::bad_input(format!("the backbone is not known: {failure}"), "choose another point")
    })?;
    let mut curves: Vec<Curve> = Vec::new();
    let mut named = [false; 2];
    for ends in backbone.turning_points().windows(2) {
        let attracts = ends[1].viscous < ends[0].viscous;
        let at = |i: usize| ends[0].radius + (ends[1].radius - ends[0].radius) * i as f64 / POINTS as f64;
        let points = (0..=POINTS).map(|i| (backbone.viscous(at(i)) / epsilon, at(i))).collect();
        let (words, dash): (_, &[f64]) =
            if attracts { ("attracting slip cycle", &[]) } else { ("repelling slip cycle", &[3.0, 2.0]) };
        let first = !std::mem::replace(&mut named[usize::from(attracts)], true);
        let name = if first { rich(words) } else { Rich::default() };
        curves.push(line(name, palette::GREEN, dash, points));
    }
    curves.push(guide(rich("damping {c}"), point.damping, &curves));
    let numbers = || curves.iter().flat_map(|curve| &curve.points).map(|p| p.0).filter(|x| x.is_finite());
    let (low, high) = (numbers().fold(f64::INFINITY, f64::min), numbers().fold(f64::NEG_INFINITY, f64::max));
    let room = (0.06 * (high - low)).max(1e-3);
    let chart = chart("largest {x_2}", "", curves);
    let scene = draw(
        &Rich::default(),
        Scale::linear(low - room, high + room),
        &rich("damping {c}"),
        &[chart],
        Width::OneColumn,
    );
    let caption = rich("The backbone: the one damping at which each amplitude closes to a slip cycle.");
    Ok(answer("backbone", &scene, &caption))
}

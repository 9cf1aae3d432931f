//! Phase portraits: orbits, the sticking segment, exit point, landing and equilibrium.

use super::super::text::{Rich, rich};
use super::axis::{BOTTOM_MARGIN, Labels, Panel, Panels, Scale, TITLE_MARGIN, left_margin};
use super::legend::{Legend, Sample};
use super::plot::wrap;
use super::scene::{Anchor, Marker, Place, Rect, Scene, Stroke, Width};
use super::slice::{equals, telling};
use super::{Figure, curves, palette};
use crate::filippov::{Oscillator, Side};
use crate::friction::Law;
use crate::map::Grid;
use crate::point::Point;
use crate::simulate::direct::{Ending, Phase, Sample as State, Start, Trace, trace};
use crate::simulate::{Fate, flow};
use crate::store::MapFile;

/// Accuracy of the traced orbits.
const TOLERANCE: f64 = 1e-10;
/// Turns of the orbit from the exit point that are drawn at most.
const TURNS: f64 = 4.0;
/// Turns of the orbit from near the equilibrium.
const INNER_TURNS: f64 = 3.0;
/// Where that orbit starts, in units of V above the equilibrium.
const INNER_START: f64 = 0.35;

/// The orbit that leaves the belt at the exit point.
pub(super) const ORBIT: Stroke = Stroke::solid(palette::BLUE, 1.2);
/// Its sticking part.
const STICK: Stroke = Stroke::solid(palette::VERMILION, 2.0);
/// The sticking segment.
pub(super) const SEGMENT: Stroke = Stroke::solid(palette::LIGHT_GREY, 4.5);
/// Other orbits.
pub(super) const OTHER: Stroke = Stroke { color: palette::GREEN, width: 0.9, dash: &[3.0, 1.5] };
/// The belt line.
pub(super) const BELT: Stroke = Stroke { color: palette::GREY, width: 0.6, dash: &[1.0, 1.6] };

/// What is drawn at one point of parameter space.
#[derive(Clone, Debug)]
pub(super) struct Portrait {
    pub(super) oscillator: Oscillator,
    orbit: Trace,
    inner: Trace,
}

impl Portrait {
    fn of(oscillator: Oscillator) -> Self {
        let turn = std::f64::consts::TAU;
        let start = Start::State { x1: oscillator.equilibrium_x1(), x2: INNER_START * oscillator.belt_speed };
        Self {
            oscillator: oscillator.clone(),
            orbit: trace(&oscillator, Start::ExitPoint, TOLERANCE, TURNS * turn),
            inner: trace(&oscillator, start, TOLERANCE, INNER_TURNS * turn),
        }
    }

    /// The smallest rectangle around everything: x1 and x2, least and greatest.
    fn extent(&self) -> [f64; 4] {
        let (exit, v) = (self.oscillator.exit_x1(), self.oscillator.belt_speed);
        let mut extent = [exit, exit, 0.0, v];
        for state in self.orbit.samples.iter().chain(&self.inner.samples) {
            extent = [
                extent[0].min(state.x1),
                extent[1].max(state.x1),
                extent[2].min(state.x2),
                extent[3].max(state.x2),
            ];
        }
        // The sticking segment whole, unless that would make the orbit tiny.
        extent[0] = extent[0].min(self.oscillator.upper_tangency_x1().max(extent[0] - v));
        extent
    }

    /// Whether the orbit sticks, and where it lands.
    fn landing(&self) -> Option<&State> {
        let sticks = |state: &&State| state.phase == Phase::Stick && state.t > 0.0;
        self.orbit.samples.iter().find(sticks)
    }

    pub(super) fn draw(&self, scene: &mut Scene, panel: &Panel) {
        let oscillator = &self.oscillator;
        let v = oscillator.belt_speed;
        let at = |x1: f64, x2: f64| panel.place(x1, x2);
        scene.clipped(panel.rect, |scene| {
            let (exit, tangency) = (oscillator.exit_x1(), oscillator.upper_tangency_x1());
            scene.line(&[at(panel.x.from, v), at(panel.x.to, v)], &BELT);
            scene.line(&[at(tangency, v), at(exit, v)], &SEGMENT);
            orbit(scene, panel, oscillator, &self.inner.samples, &OTHER);
            // Slipping and sticking parts one after the other.
            let mut samples = self.orbit.samples.as_slice();
            while let Some(first) = samples.first() {
                let sticking = first.phase == Phase::Stick;
                let end = samples.iter().take_while(|s| (s.phase == Phase::Stick) == sticking).count();
                let part = &samples[..(end + 1).min(samples.len())];
                orbit(scene, panel, oscillator, part, if sticking { &STICK } else { &ORBIT });
                samples = &samples[end..];
            }
            scene.marker(Marker::Circle, at(exit, v), 5.0, palette::BLACK, true);
            if let Some(landing) = self.landing() {
                scene.marker(Marker::Triangle, at(landing.x1, landing.x2), 6.0, palette::VERMILION, true);
            }
            let stable = oscillator.eigenvalues().is_stable();
            scene.marker(Marker::Square, at(oscillator.equilibrium_x1(), 0.0), 5.0, palette::BLACK, stable);
        });
    }

    /// The entries of its legend.
    fn legend(&self, legend: &mut Portrayed) {
        legend.sticks |= self.landing().is_some();
        match self.oscillator.eigenvalues().is_stable() {
            true => legend.stable = true,
            false => legend.unstable = true,
        }
    }

    /// What becomes of the orbit, in words.
    fn words(&self) -> &'static str {
        let stable = self.oscillator.eigenvalues().is_stable();
        match self.orbit.ending {
            Ending::Closes { .. } if stable => "stick-slip cycle, equilibrium stable too",
            Ending::Closes { .. } => "stick-slip cycle",
            Ending::Failed(_) => "not followed to its end",
            Ending::Settles | Ending::OutOfTime => {
                let above = |s: &State| s.phase == Phase::Slip(Side::Above);
                if self.orbit.samples.iter().any(above) { "crosses the belt line" } else { "spirals inward" }
            }
        }
    }
}

/// Which entries the legend of some portraits needs.
#[derive(Default)]
struct Portrayed {
    sticks: bool,
    stable: bool,
    unstable: bool,
}

impl Portrayed {
    fn legend(&self) -> Legend {
        let mut legend = Legend::default();
        legend.add(Sample::Line(ORBIT), rich("orbit from the exit point"));
        if self.sticks {
            legend.add(Sample::Line(STICK), rich("the same, sticking"));
        }
        legend.add(Sample::Line(OTHER), rich("orbit from near the equilibrium"));
        legend.add(Sample::Line(SEGMENT), rich("sticking segment"));
        legend.add(Sample::Mark(Marker::Circle, palette::BLACK, true), rich("exit point"));
        if self.sticks {
            legend.add(Sample::Mark(Marker::Triangle, palette::VERMILION, true), rich("landing"));
        }
        if self.stable {
            legend.add(Sample::Mark(Marker::Square, palette::BLACK, true), rich("stable equilibrium"));
        }
        if self.unstable {
            legend.add(Sample::Mark(Marker::Square, palette::BLACK, false), rich("unstable equilibrium"));
        }
        legend
    }
}

/// Draws an orbit with arrows along it.
pub(super) fn orbit(
    scene: &mut Scene,
    panel: &Panel,
    oscillator: &Oscillator,
    samples: &[State],
    stroke: &Stroke,
) {
    const BETWEEN: f64 = 75.0;
    let places: Vec<Place> = smooth(oscillator, samples).iter().map(|p| panel.place(p.0, p.1)).collect();
    scene.line(&places, stroke);
    // An arrow after the first third of the distance, then every so often.
    let mut walked = 0.6 * BETWEEN;
    for pair in places.windows(2) {
        let (dx, dy) = (pair[1].0 - pair[0].0, pair[1].1 - pair[0].1);
        walked += dx.hypot(dy);
        if walked > BETWEEN {
            walked = 0.0;
            scene.arrow_head(pair[1], (dx, dy), stroke.color, 5.0);
        }
    }
}

/// Points of an orbit between its samples, by cubic interpolation of the states and their rates of change.
fn smooth(oscillator: &Oscillator, samples: &[State]) -> Vec<(f64, f64)> {
    const PIECES: u8 = 5;
    let mut points = Vec::with_capacity(usize::from(PIECES) * samples.len());
    for pair in samples.windows(2) {
        let (from, to) = (&pair[0], &pair[1]);
        points.push((from.x1, from.x2));
        let Phase::Slip(side) = from.phase else { continue };
        let h = to.t - from.t;
        let rate = |state: &State| oscillator.acceleration(side, state.x1, state.x2);
        let hermite = |s: f64, a: f64, rate_a: f64, b: f64, rate_b: f64| {
            let r = 1.0 - s;
            r * r * (1.0 + 2.0 * s) * a + s * s * (1.0 + 2.0 * r) * b + h * s * r * (r * rate_a - s * rate_b)
        };
        for piece in 1..PIECES {
            let s = f64::from(piece) / f64::from(PIECES);
            points.push((
                hermite(s, from.x1, from.x2, to.x1, to.x2),
                hermite(s, from.x2, rate(from), to.x2, rate(to)),
            ));
        }
    }
    points.extend(samples.last().map(|last| (last.x1, last.x2)));
    points
}

/// Scales of equal units around an extent, for a panel of width `w`, and the panel's height.
pub(super) fn equal_scales(
    [left, right, low, high]: [f64; 4],
    w: f64,
    aspects: (f64, f64),
) -> (Scale, Scale, f64) {
    let (mut width, mut height) = (1.08 * (right - left), 1.14 * (high - low));
    let aspect = (height / width).clamp(aspects.0, aspects.1);
    width = width.max(height / aspect);
    height = height.max(width * aspect);
    let (x, y) = (0.5 * (left + right), 0.5 * (low + high));
    let scale = |middle: f64, size: f64| Scale::linear(middle - 0.5 * size, middle + 0.5 * size);
    (scale(x, width), scale(y, height), w * aspect)
}

/// The phase portrait of one point, and what it shows.
#[must_use]
pub fn portrait(law: &Law, point: &Point, width: Width) -> (Scene, Rich) {
    let portrait = Portrait::of(Oscillator::new(law, point));
    let mut scene = Scene::new(width.points(), 0.0);
    let values = std::iter::once(point.epsilon)
        .chain(point.law.as_slice().iter().copied())
        .chain([point.belt_speed, point.damping]);
    let mut words = Rich::default();
    for (name, value) in Grid::axis_names(law).into_iter().zip(values) {
        let join = rich(if words.pieces.is_empty() { "" } else { ", " });
        words = words.then(join).then(equals(name, value));
    }
    let left = left_margin(18.0);
    let w = scene.width - left - 10.0;
    let (x, y, h) = equal_scales(portrait.extent(), w, (0.4, 0.95));
    let mut top = TITLE_MARGIN - 3.0;
    for line in wrap(&words, w) {
        scene.text((left, top), &line, super::axis::SMALL_TEXT, Anchor::Start);
        top += super::axis::SMALL_TEXT + 2.0;
    }
    let panel = Panel { rect: Rect { x: left, y: top - 4.0, w, h }, x, y };
    portrait.draw(&mut scene, &panel);
    panel.axes(&mut scene, Labels { x: true, y: true });
    panel.x_name(&mut scene, &rich("{x_1}"));
    panel.y_name(&mut scene, &rich("{x_2}"), 18.0);
    let mut portrayed = Portrayed::default();
    portrait.legend(&mut portrayed);
    portrayed.legend().below(&mut scene, left, panel.rect.y + h + BOTTOM_MARGIN);
    let caption =
        rich("Phase portrait at ").then(words).then(rich(": ")).then(rich(portrait.words())).then(rich("."));
    (scene, caption)
}

/// Portraits along one column of the map: below the critical damping, in the bistable band, above it, and,
/// where a column of the map has one, an orbit that crosses the belt line.
#[must_use]
pub fn portraits(map: &MapFile) -> Option<Figure> {
    let grid = map.grid();
    let mut index = telling(map);
    // The largest eps, where orbits differ most to the eye, as long as it has a cycle.
    let root = |index: &[usize]| curves::exact(&[grid.column(index)])[0];
    for epsilon in (0..grid.axes()[0].values.len()).rev() {
        index[0] = epsilon;
        if root(&index) > 0.0 {
            break;
        }
    }
    let column = grid.column(&index);
    let critical = root(&index);
    if !(critical > 0.0) {
        return None;
    }
    let unstable_below = curves::stability(&column).clamp(0.0, critical);
    let mut points = vec![
        (column.clone(), 0.5 * unstable_below),
        (column.clone(), 0.5 * (unstable_below + critical)),
        (column.clone(), 1.3 * critical),
    ];
    let last = grid.axes().len() - 2;
    index[last] = grid.axes()[last].values.len() - 1;
    let fast = grid.column(&index);
    let slowest = grid.dampings()[0];
    let crosses =
        |c: f64| matches!(flow(&Oscillator::in_column(&fast, c), TOLERANCE).fate, Fate::CrossesForever);
    if crosses(slowest) {
        points.push((fast, slowest));
    }
    let drawn: Vec<(f64, Portrait)> =
        points.iter().map(|(column, c)| (*c, Portrait::of(Oscillator::in_column(column, *c)))).collect();
    // The fast belt's orbits have a scale of their own, so they are a figure of their own if present.
    let common = drawn
        .iter()
        .take(3)
        .map(|(_, portrait)| portrait.extent())
        .fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |a, b| {
            [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
        });
    let mut scenes = Vec::new();
    for width in Width::ALL {
        let mut scene = Scene::new(width.points(), 0.0);
        let columns = match width {
            Width::OneColumn => 1,
            Width::TwoColumns => drawn.len().min(3),
        };
        let (x, y, h) = equal_scales(common, 1.0, (0.5, 1.1));
        let mut panels = Panels::new(scene.width, columns, 3, h, x, y);
        let mut portrayed = Portrayed::default();
        for ((panel, (c, portrait)), letter) in panels.panels.iter().zip(&drawn).zip(["(a) ", "(b) ", "(c) "])
        {
            portrait.draw(&mut scene, panel);
            portrait.legend(&mut portrayed);
            panel.title(&mut scene, &rich(letter).then(equals("c", rounded(*c))));
        }
        panels.axes(&mut scene, &rich("{x_1}"), &rich("{x_2}"));
        if let Some((c, portrait)) = drawn.get(3) {
            let w = match width {
                Width::OneColumn => panels.panels[0].rect.w,
                Width::TwoColumns => 0.5 * scene.width,
            };
            let (x, y, h) = equal_scales(portrait.extent(), w, (0.4, 0.9));
            let rect = Rect { x: panels.panels[0].rect.x, y: panels.bottom + TITLE_MARGIN, w, h };
            let panel = Panel { rect, x, y };
            portrait.draw(&mut scene, &panel);
            panel.axes(&mut scene, Labels { x: true, y: true });
            panel.x_name(&mut scene, &rich("{x_1}"));
            panel.y_name(&mut scene, &rich("{x_2}"), Panel::y_labels_width(y, h));
            let speed = grid.axes()[last].values[index[last]];
            panel.title(
                &mut scene,
                &rich("(d) ").then(equals("c", *c)).then(rich(", ")).then(equals("V", speed)),
            );
            portrait.legend(&mut portrayed);
            panels.bottom = rect.y + h + BOTTOM_MARGIN;
        }
        portrayed.legend().below(&mut scene, panels.panels[0].rect.x, panels.bottom);
        scenes.push((width, scene));
    }
    let mut held = equals("epsilon", column.epsilon);
    for (axis, &i) in grid.axes()[1..last].iter().zip(&index[1..]) {
        held = held.then(rich(", ")).then(equals(&axis.name, axis.values[i]));
    }
    held = held.then(rich(", ")).then(equals("V", column.belt_speed));
    let mut caption = rich("Phase portraits at ").then(held).then(rich(": "));
    for ((_, portrait), letter) in
        drawn.iter().zip(["(a) ", "; (b) ", "; (c) ", "; (d) on the fastest belt of the map, "])
    {
        caption = caption.then(rich(letter)).then(rich(portrait.words()));
    }
    Some(Figure { name: "portraits".into(), caption: caption.then(rich(".")), scenes })
}

/// To three digits, for titles.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

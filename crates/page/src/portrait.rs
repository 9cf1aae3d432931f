//! The phase portrait of one point: orbits, cycles, the stick segment, exit point, landing and
//! equilibrium.

use super::units::UnitSystem;
use slipmap_column::slip_cycles;
use slipmap_figure::axis::Scale;
use slipmap_figure::data::Data;
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::Panel;
use slipmap_figure::scene::{Marker, Place, Scene, Stroke};
use slipmap_figure::style;
use slipmap_figure::text::rich;
use slipmap_model::filippov::{Oscillator, Side, Stability};
use slipmap_orbits::flow;
use slipmap_witness::{Ending, Phase, Sample as State, Start, Trace, trace};

const TOLERANCE: f64 = 1e-10;
/// Largest number of turns of the orbit if no duration is given.
const TURNS: f64 = 4.0;
/// Turns of the orbit from near the equilibrium.
const INNER_TURNS: f64 = 3.0;
/// Start of that orbit, in units of V above the equilibrium.
const INNER_START: f64 = 0.35;

/// The requested orbit.
pub const ORBIT: Stroke = Stroke::solid(style::BLUE, 1.2);
/// Its sticking part.
pub const STICK: Stroke = Stroke::solid(style::VERMILION, 2.0);
const SEGMENT: Stroke = Stroke::solid(style::LIGHT_GREY, 4.5);
const OTHER: Stroke = Stroke { color: style::GREEN, width: 0.9, dash: &[3.0, 1.5] };
/// Attracting slip cycles.
const ATTRACTING: Stroke = Stroke::solid(style::BLACK, 1.0);
pub const REPELLING: Stroke = Stroke { color: style::BLACK, width: 1.0, dash: &[1.2, 1.6] };
pub const BELT: Stroke = Stroke { color: style::GREY, width: 0.6, dash: &[1.0, 1.6] };

/// The orbits drawn at one point of parameter space.
#[derive(Clone, Debug)]
pub struct Portrait {
    pub oscillator: Oscillator,
    start: Start,
    /// The requested orbit.
    pub orbit: Trace,
    /// An orbit from near the equilibrium; empty where it would lie on another drawn orbit.
    inner: Trace,
    /// Slip cycles, and whether each attracts.
    cycles: Vec<(Trace, bool)>,
}

/// The orbit from `start`, for the time `duration`, or until it closes, settles or has made four turns.
pub fn orbit_from(oscillator: &Oscillator, start: Start, duration: Option<f64>) -> Trace {
    let Some(duration) = duration else {
        return trace(oscillator, start, TOLERANCE, TURNS * std::f64::consts::TAU);
    };
    let mut orbit = trace(oscillator, start, TOLERANCE, duration);
    // A trace ends where the cycle closes; the cycle is repeated from there.
    let Ending::Closes { period } = orbit.ending else { return orbit };
    let cycle = trace(oscillator, Start::ExitPoint, TOLERANCE, 2.0 * period);
    while let Some(last) = orbit.samples.pop() {
        let left = duration - last.t;
        let is_whole = left >= period;
        let part = if is_whole { &cycle } else { &trace(oscillator, Start::ExitPoint, TOLERANCE, left) };
        orbit.samples.extend(part.samples.iter().map(|sample| State { t: last.t + sample.t, ..*sample }));
        if !is_whole {
            break;
        }
    }
    if let Some(last) = orbit.samples.last_mut() {
        // The sum of the times of many cycles is rounded.
        last.t = duration;
    }
    orbit
}

/// An orbit as a table: time, position, velocity, and whether the mass slips or sticks from there on.
pub fn orbit_data(samples: &[State], units: &UnitSystem) -> Data {
    let column = |factor: f64, of: fn(&State) -> f64| samples.iter().map(|s| of(s) * factor).collect();
    let (t, x1, x2) = (units.time(), units.x1(), units.x2());
    let phase = |state: &State| match state.phase {
        Phase::Slip(_) => "slip",
        Phase::Stick => "stick",
    };
    Data::default()
        .reals(t.header(), column(t.factor, |s| s.t))
        .reals(x1.header(), column(x1.factor, |s| s.x1))
        .reals(x2.header(), column(x2.factor, |s| s.x2))
        .words("phase", samples.iter().map(|s| phase(s).to_owned()).collect())
}

impl Portrait {
    /// The portrait at a point with the orbit from `start`, see [`orbit_from`].
    pub fn of(oscillator: &Oscillator, start: Start, duration: Option<f64>) -> Self {
        let turn = std::f64::consts::TAU;
        let inner = Start::State { x1: oscillator.equilibrium_x1(), x2: INNER_START * oscillator.belt_speed };
        // The portrait is drawn without cycles if they cannot be found.
        let cycles = slip_cycles(oscillator, &flow(oscillator, TOLERANCE), TOLERANCE).unwrap_or_default();
        let cycles = cycles.iter().map(|cycle| {
            let x2 = cycle.velocity.hi;
            // At its highest velocity a cycle has x2' = 0.
            let x1 = oscillator.acceleration(Side::Below, 0.0, x2);
            (trace(oscillator, Start::State { x1, x2 }, TOLERANCE, cycle.period), cycle.is_stable())
        });
        Self {
            start,
            orbit: orbit_from(oscillator, start, duration),
            inner: trace(oscillator, inner, TOLERANCE, INNER_TURNS * turn),
            cycles: cycles.collect(),
            oscillator: oscillator.clone(),
        }
    }

    /// The smallest rectangle around everything: x1 and x2, least and greatest.
    pub fn extent(&self) -> [f64; 4] {
        let (exit, v) = (self.oscillator.exit_x1(), self.oscillator.belt_speed);
        let mut extent = [exit, exit, 0.0, v];
        let cycles = self.cycles.iter().flat_map(|(cycle, _)| &cycle.samples);
        for state in self.orbit.samples.iter().chain(&self.inner.samples).chain(cycles) {
            extent = [
                extent[0].min(state.x1),
                extent[1].max(state.x1),
                extent[2].min(state.x2),
                extent[3].max(state.x2),
            ];
        }
        // The whole stick segment, unless that would make the orbit tiny.
        extent[0] = extent[0].min(self.oscillator.upper_tangency_x1().max(extent[0] - v));
        extent
    }

    /// The state in which the orbit lands, if it sticks.
    fn landing(&self) -> Option<&State> {
        let sticks = |state: &&State| state.phase == Phase::Stick && state.t > 0.0;
        self.orbit.samples.iter().find(sticks)
    }

    pub fn draw(&self, scene: &mut Scene, panel: &Panel) {
        let oscillator = &self.oscillator;
        let v = oscillator.belt_speed;
        let at = |x1: f64, x2: f64| panel.place(x1, x2);
        scene.clipped(panel.rect, |scene| {
            let (exit, tangency) = (oscillator.exit_x1(), oscillator.upper_tangency_x1());
            scene.line(&[at(panel.x.from, v), at(panel.x.to, v)], &BELT);
            scene.line(&[at(tangency, v), at(exit, v)], &SEGMENT);
            orbit(scene, panel, oscillator, &self.inner.samples, &OTHER);
            for (cycle, attracts) in &self.cycles {
                let stroke = if *attracts { ATTRACTING } else { REPELLING };
                let points = smooth(oscillator, &cycle.samples);
                let places: Vec<Place> = points.iter().map(|p| panel.place(p.0, p.1)).collect();
                scene.line(&places, &stroke);
            }
            for (part, sticking) in parts(&self.orbit.samples) {
                orbit(scene, panel, oscillator, part, if sticking { &STICK } else { &ORBIT });
            }
            scene.marker(Marker::Circle, at(exit, v), 5.0, style::BLACK, true);
            if let Start::State { x1, x2 } = self.start {
                scene.marker(Marker::Diamond, at(x1, x2), 5.0, style::BLUE, true);
            }
            if let Some(landing) = self.landing() {
                scene.marker(Marker::Triangle, at(landing.x1, landing.x2), 6.0, style::VERMILION, true);
            }
            let stable = oscillator.stability() == Stability::Attracts;
            scene.marker(Marker::Square, at(oscillator.equilibrium_x1(), 0.0), 5.0, style::BLACK, stable);
        });
    }

    pub fn legend(&self, legend: &mut Legend) {
        let from = match self.start {
            Start::ExitPoint => "orbit from the exit point",
            Start::State { .. } => "orbit from the start",
        };
        legend.add(Sample::Line(ORBIT), rich(from));
        if self.landing().is_some() {
            legend.add(Sample::Line(STICK), rich("the same, sticking"));
        }
        legend.add(Sample::Line(OTHER), rich("orbit from near the equilibrium"));
        for (stroke, attracting, words) in
            [(ATTRACTING, true, "attracting slip cycle"), (REPELLING, false, "repelling slip cycle")]
        {
            if self.cycles.iter().any(|(_, attracts)| *attracts == attracting) {
                legend.add(Sample::Line(stroke), rich(words));
            }
        }
        legend.add(Sample::Line(SEGMENT), rich("stick segment"));
        legend.add(Sample::Mark(Marker::Circle, style::BLACK, true), rich("exit point"));
        if matches!(self.start, Start::State { .. }) {
            legend.add(Sample::Mark(Marker::Diamond, style::BLUE, true), rich("start"));
        }
        if self.landing().is_some() {
            legend.add(Sample::Mark(Marker::Triangle, style::VERMILION, true), rich("landing"));
        }
        let (stable, words) = match self.oscillator.stability() {
            Stability::Attracts => (true, "stable equilibrium"),
            Stability::Neutral => (false, "neutral equilibrium"),
            Stability::Repels => (false, "unstable equilibrium"),
        };
        legend.add(Sample::Mark(Marker::Square, style::BLACK, stable), rich(words));
    }

    /// The long-run behaviour of the orbit, in words.
    pub fn words(&self) -> &'static str {
        let stability = self.oscillator.stability();
        match self.orbit.ending {
            Ending::Closes { .. } if stability == Stability::Attracts => {
                "stick-slip cycle, equilibrium stable too"
            }
            Ending::Closes { .. } if stability == Stability::Neutral => {
                "stick-slip cycle, equilibrium neutral"
            }
            Ending::Closes { .. } => "stick-slip cycle",
            Ending::Failed(_) => "not followed to its end",
            Ending::Settles | Ending::OutOfTime => {
                let above = |s: &State| s.phase == Phase::Slip(Side::Above);
                if self.orbit.samples.iter().any(above) { "crosses the belt line" } else { "spirals inward" }
            }
        }
    }
}

/// Slipping and sticking parts of an orbit one after the other; each ends where the next begins.
pub fn parts(mut samples: &[State]) -> Vec<(&[State], bool)> {
    let mut parts = Vec::new();
    while let Some(first) = samples.first() {
        let sticking = first.phase == Phase::Stick;
        let end = samples.iter().take_while(|s| (s.phase == Phase::Stick) == sticking).count();
        parts.push((&samples[..(end + 1).min(samples.len())], sticking));
        samples = &samples[end..];
    }
    parts
}

/// Draws an orbit with arrows along it.
fn orbit(scene: &mut Scene, panel: &Panel, oscillator: &Oscillator, samples: &[State], stroke: &Stroke) {
    const BETWEEN: f64 = 75.0;
    let places: Vec<Place> = smooth(oscillator, samples).iter().map(|p| panel.place(p.0, p.1)).collect();
    scene.line(&places, stroke);
    // An arrow after the first third of the distance, then at equal distances.
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

/// Equal scales around an extent for a panel of width `w`, and its height; `aspects` bounds height / width.
pub fn equal_scales([left, right, low, high]: [f64; 4], w: f64, aspects: (f64, f64)) -> (Scale, Scale, f64) {
    let (mut width, mut height) = (1.08 * (right - left), 1.14 * (high - low));
    let aspect = (height / width).clamp(aspects.0, aspects.1);
    width = width.max(height / aspect);
    height = height.max(width * aspect);
    let (x, y) = (0.5 * (left + right), 0.5 * (low + high));
    let scale = |middle: f64, size: f64| Scale::linear(middle - 0.5 * size, middle + 0.5 * size);
    (scale(x, width), scale(y, height), w * aspect)
}

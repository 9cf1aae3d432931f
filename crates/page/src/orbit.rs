//! The figure of an orbit: phase portrait, and position and velocity against time.

use super::portrait::{BELT, ORBIT, Portrait, STICK, equal_scales, orbit_data, parts};
use super::units::{UnitSystem, equals, join};
use slipmap_figure::axis::{Scale, extremes};
use slipmap_figure::data::Data;
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::panels::{BOTTOM_MARGIN, Labels, Panel, TITLE_MARGIN, left_margin, write_heading};
use slipmap_figure::scene::{Place, Rect, Scene, Width};
use slipmap_figure::text::{Rich, rich};
use slipmap_machine::Dimension;
use slipmap_model::filippov::Oscillator;
use slipmap_model::friction::Law;
use slipmap_model::point::Point;
use slipmap_witness::{Sample as State, Start};

#[derive(Clone, Debug)]
pub struct OrbitFigure {
    pub scene: Scene,
    pub caption: Rich,
    pub data: Data,
    /// Where the phase portrait is, with its scales in dimensionless x1 and x2.
    pub portrait: Panel,
}

/// Start, duration and units of a drawn orbit.
#[derive(Clone, Debug)]
pub struct OrbitPlot<'a> {
    pub law: &'a Law,
    pub point: &'a Point,
    pub start: Start,
    /// Duration, dimensionless; `None` follows the orbit until it closes, settles or has made four turns.
    pub duration: Option<f64>,
    /// The units in which it is shown.
    pub units: &'a UnitSystem,
    pub width: Width,
}

/// The parameters of a point; for a machine its speed and damping.
fn point_words(plot: &OrbitPlot) -> Rich {
    let point = plot.point;
    if plot.units.machine.is_some() {
        let quantity = |words, dimension, value| {
            plot.units.quantity(words, Rich::default(), "", Some(dimension)).equals(value)
        };
        return join([
            quantity("belt speed", Dimension::Velocity, point.belt_speed),
            quantity("damping", Dimension::Damping, point.damping),
        ]);
    }
    join(plot.law.coordinates(point).into_iter().map(|(name, value)| equals(name, value)))
}

/// Draws phase portrait and time series.
pub fn orbit_figure(plot: &OrbitPlot) -> OrbitFigure {
    let oscillator = Oscillator::new(plot.law, plot.point);
    let portrait = Portrait::of(&oscillator, plot.start, plot.duration);
    let (x1, x2, time) = (plot.units.x1(), plot.units.x2(), plot.units.time());
    let mut scene = Scene::new(plot.width.points(), 0.0);
    let words = point_words(plot);
    let extent = portrait.extent();
    let scales = |w: f64| {
        let (x, y, h) = equal_scales(extent, w, (0.4, 0.95));
        (x.in_unit(x1.factor), y.in_unit(x2.factor), h)
    };
    // The margin depends on the width of the numbers, and these on the height.
    let (x_scale, y_scale, _) = scales(150.0);
    let labels = Panel::y_labels_width(y_scale, 150.0);
    let widest = labels.max(Panel::y_labels_width(x_scale, 75.0)).max(18.0);
    let left = left_margin(widest);
    let whole = scene.width - 12.0;
    let w = plot.width.select(whole, 0.5 * whole) - left;
    let top = write_heading(&mut scene, left, &words) + TITLE_MARGIN;
    let (x, y, h) = scales(w);
    let panel = Panel { rect: Rect { x: left, y: top, w, h }, x, y };
    portrait.draw(&mut scene, &panel);
    panel.named_axes(&mut scene, &x1.text(), &x2.text(), labels);
    panel.title(&mut scene, &rich("(a)"));

    let series_top = plot.width.select(top + h + BOTTOM_MARGIN + TITLE_MARGIN, top);
    let series_left = left + plot.width.select(0.0, 0.5 * whole);
    let each = plot.width.select(75.0, (0.5 * (h - TITLE_MARGIN - 4.0)).max(60.0));
    let end = portrait.orbit.samples.last().map_or(1.0, |state| state.t);
    let t = Scale::linear(0.0, end).in_unit(time.factor);
    let mut bottom = 0.0;
    type Of = fn(&State) -> f64;
    let series: [(&str, _, Of); 2] = [("(b)", &x1, |s| s.x1), ("(c)", &x2, |s| s.x2)];
    for (number, (letter, label, of)) in series.into_iter().enumerate() {
        let (low, high) = extremes(portrait.orbit.samples.iter().map(of));
        let room = 0.06 * (high - low);
        let scale = Scale::linear(low - room, high + room).in_unit(label.factor);
        let y = series_top + number as f64 * (each + TITLE_MARGIN + 4.0);
        let rect = Rect { x: series_left, y, w, h: each };
        let panel = Panel { rect, x: t, y: scale };
        scene.clipped(rect, |scene| {
            if number == 1 {
                let v = oscillator.belt_speed;
                scene.line(&[panel.place(0.0, v), panel.place(end, v)], &BELT);
            }
            for (part, sticking) in parts(&portrait.orbit.samples) {
                let places: Vec<Place> = part.iter().map(|s| panel.place(s.t, of(s))).collect();
                scene.line(&places, if sticking { &STICK } else { &ORBIT });
            }
        });
        panel.axes(&mut scene, Labels { x: number == 1, y: true });
        panel.y_name(&mut scene, &label.text(), Panel::y_labels_width(scale, each));
        panel.title(&mut scene, &rich(letter));
        if number == 1 {
            panel.x_name(&mut scene, &time.text());
            bottom = y + each + BOTTOM_MARGIN;
        }
    }
    let mut legend = Legend::default();
    portrait.legend(&mut legend);
    legend.add(Sample::Line(BELT), rich("speed of the belt"));
    legend.below(&mut scene, left, bottom.max(panel.rect.y + h + BOTTOM_MARGIN));
    let caption = rich("(a) Phase portrait at ")
        .then(words)
        .then(": ")
        .then(rich(portrait.words()))
        .then("; (b), (c) position and velocity of the same orbit against time.");
    // A bit that turns in rock at rest, or a slide on its guide, moves with this velocity itself.
    let slip =
        plot.units.quantity("slip velocity", Rich::default(), "slip_velocity", Some(Dimension::Velocity));
    let samples = &portrait.orbit.samples;
    let slips = samples.iter().map(|s| (oscillator.belt_speed - s.x2) * slip.factor).collect();
    let data = orbit_data(samples, plot.units).reals(slip.header(), slips);
    OrbitFigure { scene, caption, data, portrait: panel }
}

//! One variable on one slice.

use std::sync::atomic::AtomicBool;

use ndarray::Array2;

use super::super::text::{Rich, rich};
use super::super::{ReportError, SIMULATION};
use super::axis::{AXIS, BOTTOM_MARGIN, Labels, Panel, SMALL_TEXT, Scale, TITLE_MARGIN, left_margin};
use super::bifurcations;
use super::legend::{Legend, Sample};
use super::palette;
use super::region::{cell_edges, outlines};
use super::scene::{Anchor, Fill, Hatch, Rect, Scene, Width, text_width};
use super::slice::{ChoiceError, Held, Slice, equals};
use super::slices::{EXACT, draw_exact};
use crate::map::{Plane, PlaneCurves, Regime, Verdict};
use crate::store::MapFile;

/// What to plot.
#[derive(Clone, Debug)]
pub struct Plot<'a> {
    /// Name of the horizontal axis.
    pub x: &'a str,
    /// Name of the vertical axis.
    pub y: &'a str,
    /// Values at which other axes are held, by name.
    pub at: &'a [(String, f64)],
    /// The variable; the verdict of the simulation, or else of the first method, if `None`.
    pub variable: Option<&'a str>,
    /// Whether to find the curves of codimension one if the map does not store them; those that it stores are
    /// drawn in any case.
    pub curves: bool,
    /// Width of the figure.
    pub width: Width,
}

/// A plotted slice.
#[derive(Clone, Debug)]
pub struct Plotted {
    /// The figure.
    pub scene: Scene,
    /// What it shows.
    pub caption: Rich,
    /// Where the other axes are held.
    pub held: Vec<Held>,
    /// Axes of which not all nodes are drawn, and one node in how many is.
    pub thinned: Vec<(String, usize)>,
    /// The curves of codimension one, if they are stored or were asked for.
    pub curves: Option<PlaneCurves>,
}

/// Colours for cells without a number.
const NO_NUMBER: Fill = Fill::hatched(palette::WHITE, Hatch::Rising, "#b4b4b4");
/// Steps of a colour scale; more cannot be told apart, and equal neighbours become one rectangle.
const COLOURS: f64 = 128.0;
const BAR_WIDTH: f64 = 8.0;

/// Plots one variable on one slice.
///
/// # Errors
/// [`ReportError::Choice`] for names that the map does not have, [`ReportError::Map`] if it cannot be read.
pub fn plot(map: &MapFile, plot: &Plot) -> Result<Plotted, ReportError> {
    let (slice, mut held) = Slice::choose(map, plot.x, plot.y, plot.at)?;
    let default = format!("verdict_{SIMULATION}");
    let variable = match plot.variable {
        Some(name) if map.has(name) => name,
        Some(name) => return Err(ChoiceError::unknown("variable", name, map.variables()).into()),
        None if map.has(&default) => &default,
        None => map.variables().next().unwrap_or(&default),
    };
    if variable.starts_with("critical_c_") {
        held.retain(|held| held.axis != "c");
    }
    let mut at = Rich::default();
    for held in &held {
        let join = rich(if at.pieces.is_empty() { "" } else { ", " });
        at = at.then(join).then(equals(&held.axis, held.used));
    }
    let caption = title(variable)
        .then(rich(" over "))
        .then(Rich::symbol(plot.x))
        .then(rich(" and "))
        .then(Rich::symbol(plot.y))
        .then(rich(" at "))
        .then(at.clone())
        .then(rich("."))
        .then(slice.thinned_words());
    let plane = slice.plane();
    let thin = [slice.x_axis(), slice.y_axis()].into_iter().find(|axis| axis.values.len() < 2);
    if let (true, Some(axis)) = (plot.curves, thin) {
        return Err(ChoiceError::OneNode { axis: axis.name.clone() }.into());
    }
    let curves = stored(map, &plane)
        .or_else(|| plot.curves.then(|| PlaneCurves::of(map.grid(), plane, &AtomicBool::new(false))));
    let caption = match &curves {
        Some(curves) if !curves.curves.is_empty() => {
            caption.then(rich(" Lines: where the long-run behaviour changes, by continuation."))
        }
        _ => caption,
    };
    let page = Page::new(&slice, curves.as_ref(), plot.width, &title(variable), &at);
    let scene = if variable.starts_with("verdict_") {
        let codes: Vec<(i8, Fill, &str)> = Verdict::ALL
            .into_iter()
            .map(|verdict| (verdict.code(), palette::verdict(verdict), verdict.name()))
            .collect();
        page.codes(&slice.codes(variable)?, &codes, true)
    } else if variable == "regime" {
        let codes: Vec<(i8, Fill, &str)> = Regime::ALL
            .into_iter()
            .map(|regime| (regime.code(), palette::regime(regime), regime.name()))
            .collect();
        page.codes(&slice.codes(variable)?, &codes, false)
    } else {
        page.reals(&slice.reals(variable)?, variable.starts_with("margin_"))
    };
    let thinned = slice.thinned().map(|(axis, step)| (axis.name.clone(), step)).collect();
    Ok(Plotted { scene, caption, held, thinned, curves })
}

/// The curves that a map stores of a plane.
fn stored(map: &MapFile, plane: &Plane) -> Option<PlaneCurves> {
    map.curves().iter().find_map(|curves| match &curves.plane {
        same if same == plane => Some(curves.clone()),
        turned if *turned == plane.turned() => Some(curves.turned()),
        _ => None,
    })
}

/// A variable in words.
fn title(variable: &str) -> Rich {
    for (prefix, words) in
        [("verdict_", "verdict of "), ("margin_", "margin of "), ("critical_c_", "critical {c} of ")]
    {
        if let Some(method) = variable.strip_prefix(prefix) {
            return rich(words).then(Rich::foreign(&method.replace('_', " ")));
        }
    }
    Rich::foreign(&variable.replace('_', " "))
}

/// The panel and what is around it.
struct Page<'a> {
    slice: &'a Slice<'a>,
    curves: Option<&'a PlaneCurves>,
    scene: Scene,
    panel: Panel,
    x_edges: Vec<f64>,
    y_edges: Vec<f64>,
    labels_width: f64,
    names: [Rich; 2],
}

impl<'a> Page<'a> {
    fn new(
        slice: &'a Slice<'a>,
        curves: Option<&'a PlaneCurves>,
        width: Width,
        title: &Rich,
        held: &Rich,
    ) -> Self {
        let ((x_scale, x_name), (y_scale, y_name)) = (slice.x_scale(), slice.y_scale());
        let mut scene = Scene::new(width.points(), 0.0);
        let height = match width {
            Width::OneColumn => 150.0,
            Width::TwoColumns => 260.0,
        };
        let labels_width = Panel::y_labels_width(y_scale, height);
        let left = left_margin(labels_width);
        let held = wrap(held, scene.width - left - 8.0);
        let mut top = TITLE_MARGIN - 3.0;
        scene.text((left, top), title, SMALL_TEXT, Anchor::Start);
        for line in &held {
            top += SMALL_TEXT + 2.0;
            scene.text((left, top), line, SMALL_TEXT, Anchor::Start);
        }
        let rect = Rect { x: left, y: top + 4.0, w: scene.width - left - 8.0, h: height };
        let panel = Panel { rect, x: x_scale, y: y_scale };
        Self {
            slice,
            curves,
            scene,
            panel,
            x_edges: cell_edges(&slice.x_nodes(), x_scale),
            y_edges: cell_edges(&slice.y_nodes(), y_scale),
            labels_width,
            names: [x_name, y_name],
        }
    }

    /// Draws the curves and the axes.
    fn axes(&mut self, legend: &mut Legend) {
        if let Some(curves) = self.curves {
            bifurcations::draw(&mut self.scene, &self.panel, curves, legend);
        }
        self.panel.axes(&mut self.scene, Labels { x: true, y: true });
        self.panel.x_name(&mut self.scene, &self.names[0]);
        self.panel.y_name(&mut self.scene, &self.names[1], self.labels_width);
    }

    /// Codes with their fills and names.
    fn codes(mut self, cells: &Array2<i8>, codes: &[(i8, Fill, &str)], exact: bool) -> Scene {
        let mut legend = Legend::default();
        for (code, fill, name) in codes {
            let areas = outlines(&self.panel, &self.x_edges, &self.y_edges, |i, j| cells[[i, j]] == *code);
            if !areas.is_empty() {
                self.scene.area(&areas, *fill);
                legend.add(Sample::Area(*fill), Rich::foreign(&name.replace('_', " ")));
            }
        }
        // Grazing is the exact boundary, but for landings past the stick segment.
        if exact && self.curves.is_none() && draw_exact(&mut self.scene, self.slice, &self.panel) {
            legend.add(Sample::Line(EXACT), rich("exact boundary"));
        }
        self.axes(&mut legend);
        let Rect { x, y, h, .. } = self.panel.rect;
        legend.below(&mut self.scene, x, y + h + BOTTOM_MARGIN);
        self.scene
    }

    /// Real numbers by colour; those with a sign by two colours that meet at 0.
    fn reals(mut self, cells: &Array2<f64>, signed: bool) -> Scene {
        let finite = || cells.iter().copied().filter(|value| value.is_finite());
        let least = finite().fold(f64::INFINITY, f64::min);
        let most = finite().fold(f64::NEG_INFINITY, f64::max);
        let range = match () {
            () if least > most => None,
            () if signed && least < 0.0 && most > 0.0 => {
                Some(Scale::linear(-most.max(-least), most.max(-least)))
            }
            () => Some(Scale::linear(least, most)),
        };
        let two_sided = signed && least < 0.0 && most > 0.0;
        let color = |unit: f64| if two_sided { palette::diverging(unit) } else { palette::sequential(unit) };
        if let Some(scale) = range {
            let bar = self.bar(scale, color);
            self.panel.rect.w = bar;
            let step = |value: f64| {
                let unit = if value == f64::NEG_INFINITY { 0.0 } else { scale.unit(value).min(1.0) };
                (!value.is_nan()).then(|| (unit * COLOURS).round())
            };
            let (columns, rows) = cells.dim();
            for i in 0..columns {
                let mut from = 0;
                while from < rows {
                    let run =
                        (from..rows).take_while(|&j| step(cells[[i, j]]) == step(cells[[i, from]])).count();
                    if let Some(step) = step(cells[[i, from]]) {
                        let low = self.panel.place(self.x_edges[i], self.y_edges[from]);
                        let high = self.panel.place(self.x_edges[i + 1], self.y_edges[from + run]);
                        // A hair wider, so that no gap shows between neighbours.
                        let rect =
                            Rect { x: low.0, y: high.1, w: high.0 - low.0 + 0.15, h: low.1 - high.1 + 0.15 };
                        self.scene.pixel(rect, &color(step / COLOURS));
                    }
                    from += run;
                }
            }
        }
        let mut legend = Legend::default();
        let empty = outlines(&self.panel, &self.x_edges, &self.y_edges, |i, j| cells[[i, j]].is_nan());
        if !empty.is_empty() {
            self.scene.area(&empty, NO_NUMBER);
            legend.add(Sample::Area(NO_NUMBER), rich("no number"));
        }
        if two_sided {
            // In grey both sides look alike.
            let fill = Fill::hatched("none", Hatch::Falling, "#4a4a4a");
            let negative = outlines(&self.panel, &self.x_edges, &self.y_edges, |i, j| cells[[i, j]] < 0.0);
            self.scene.area(&negative, fill);
            legend.add(Sample::Area(fill), rich("negative"));
        }
        self.axes(&mut legend);
        let Rect { x, y, h, .. } = self.panel.rect;
        legend.below(&mut self.scene, x, y + h + BOTTOM_MARGIN);
        self.scene
    }

    /// Draws the colour scale on the right; returns the width that is left for the panel.
    fn bar(&mut self, scale: Scale, color: impl Fn(f64) -> String) -> f64 {
        let Rect { x, y, w, h } = self.panel.rect;
        let ticks = scale.ticks(6);
        let labels = ticks.iter().map(|tick| text_width(&tick.label, SMALL_TEXT)).fold(0.0, f64::max);
        let room = w - BAR_WIDTH - labels - 14.0;
        let bar = Rect { x: x + room + 12.0, y, w: BAR_WIDTH, h };
        for i in 0..=COLOURS as usize {
            let unit = i as f64 / COLOURS;
            let step = h / (COLOURS + 1.0);
            let rect = Rect { y: y + h - (i + 1) as f64 * step, h: step + 0.15, ..bar };
            self.scene.pixel(rect, &color(unit));
        }
        self.scene.frame(bar, &AXIS);
        for tick in ticks {
            let at = y + h * (1.0 - scale.unit(tick.value));
            self.scene.line(&[(bar.x + BAR_WIDTH, at), (bar.x + BAR_WIDTH + 2.5, at)], &AXIS);
            let place = (bar.x + BAR_WIDTH + 4.5, at + 0.36 * SMALL_TEXT);
            self.scene.text(place, &tick.label, SMALL_TEXT, Anchor::Start);
        }
        room
    }
}

/// Breaks "a = 1, b = 2, ..." into lines that fit.
pub(super) fn wrap(text: &Rich, width: f64) -> Vec<Rich> {
    let mut lines: Vec<Rich> = Vec::new();
    let mut line = Rich::default();
    // Pieces come in groups that end with ", ".
    let mut group = Rich::default();
    let comma =
        |piece: &super::super::text::Piece| matches!(piece, super::super::text::Piece::Words(w) if w == ", ");
    let mut groups = Vec::new();
    for piece in &text.pieces {
        group.pieces.push(piece.clone());
        if comma(piece) {
            groups.push(std::mem::take(&mut group));
        }
    }
    groups.push(group);
    for group in groups {
        let longer = line.clone().then(group.clone());
        if !line.pieces.is_empty() && text_width(&longer, SMALL_TEXT) > width {
            lines.push(std::mem::replace(&mut line, group));
        } else {
            line = longer;
        }
    }
    lines.push(line);
    lines
}

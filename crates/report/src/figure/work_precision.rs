//! The work-precision chart: time per cell against error, and against the share of cells without the right
//! verdict.

use super::{Data, Figure};
use slipmap_figure::axis::{SMALL_TEXT, Scale, extremes};
use slipmap_figure::legend::{Legend, Sample};
use slipmap_figure::lines::letter;
use slipmap_figure::panels::{Panel, Panels};
use slipmap_figure::scene::{Anchor, Marker, Place, Rect, Scene, Stroke, Width};
use slipmap_figure::style;
use slipmap_figure::style::LineStyle;
use slipmap_figure::text::join;
use slipmap_figure::text::{Rich, rich};
use slipmap_page::palette;
use slipmap_page::units::UnitSystem;
use slipmap_study::benchmark::{ContestantKind, Row, Study};

/// The front, drawn below everything else.
const FRONT: Stroke = Stroke::solid(style::LIGHT_GREY, 2.6);
/// Upper end of the space of methods that label every cell right.
const NONE: Stroke = Stroke { color: style::GREY, width: 0.5, dash: &[2.0, 2.0] };
const MARKER: f64 = 4.6;

/// One method over its parameter.
struct Line<'a> {
    name: &'a str,
    rows: Vec<&'a Row>,
    style: LineStyle,
}

impl Line<'_> {
    /// The largest per cent of cells without an answer.
    fn unanswered(&self) -> f64 {
        let share = |row: &&Row| 100.0 * row.unanswered as f64 / row.cells.max(1) as f64;
        self.rows.iter().map(share).fold(0.0, f64::max).ceil()
    }
}

/// Groups the rows by method, in their order.
fn lines(study: &Study) -> Vec<Line<'_>> {
    let mut lines: Vec<Line> = Vec::new();
    let mut peers = 0;
    for row in &study.rows {
        match lines.iter_mut().find(|line| line.name == row.name) {
            Some(line) => line.rows.push(row),
            None => {
                let style = match row.kind {
                    ContestantKind::Peer => {
                        peers += 1;
                        style::numbered(peers - 1)
                    }
                    ContestantKind::ClosedForm | ContestantKind::Engine | ContestantKind::Naive => {
                        palette::method(&row.name)
                    }
                };
                lines.push(Line { name: &row.name, rows: vec![row], style });
            }
        }
    }
    lines
}

pub fn chart(study: &Study, width: Width) -> Figure {
    let near = study.cells.iter().filter(|cell| cell.near).count();
    let axes = study.grid.axes().iter();
    let place = join(axes.map(|axis| UnitSystem::default().axis(axis).extent(&axis.values, 4)));
    let caption = rich(&format!(
        "Speed against accuracy on {} cells of the law {} with ",
        study.cells.len(),
        study.grid.law().name()
    ))
    .then(place)
    .then(rich(&format!(
        ". (a) Largest error of the scaled grazing margin {{m}}/{{V}} (marks) and its median (lower end of the \
         bars), of the cells with an answer; numbers: per cent of cells without, at most. (b) Share of the {near} cells within {} of \
         the boundary in {{c}} that are not labelled right (marks), and that are labelled wrong (lower end of the bars). \
         Marks below the dashed line have none. Each method over its own knob; filled marks and the broad grey line: the \
         Pareto front.",
        study.settings.near
    )))
    .then(rich(if study.rows.iter().any(|row| row.kind == ContestantKind::Peer) { " Peers are dotted." } else { "" }));
    let mut scene = Scene::new(width.points(), 0.0);
    draw(&mut scene, study, width);
    Figure { name: "work-precision".into(), caption, scene, data: Data::default() }
}

/// Whole decades around numbers; `None` if there are none.
fn decades(values: impl Iterator<Item = f64>) -> Option<(f64, f64)> {
    let logs = values.filter(|value| *value > 0.0 && value.is_finite()).map(f64::log10);
    let (low, high) = extremes(logs);
    // Keeps marks off the frame.
    (low <= high).then(|| (10.0_f64.powf((low - 0.1).floor()), 10.0_f64.powf((high + 0.1).ceil())))
}

fn draw(scene: &mut Scene, study: &Study, width: Width) {
    let lines = lines(study);
    let (from, to) = decades(study.rows.iter().map(|row| row.seconds)).unwrap_or((1e-9, 1e-3));
    let x = Scale::logarithmic(from, to);
    let errors = study.rows.iter().filter_map(|row| row.margin);
    let (least, most) = decades(errors.flat_map(|e| [e.median, e.worst])).unwrap_or((1e-16, 1.0));
    let near = study.cells.iter().filter(|cell| cell.near).count().max(1);
    // Peers may have been measured on more cells.
    let shares = study.rows.iter().filter_map(|row| row.near.and_then(|labels| labels.missed()));
    let one = shares.filter(|share| *share > 0.0).fold(1.0 / near as f64, f64::min);
    // Space at the bottom for methods that label every cell right.
    let none = 0.35 * one;
    let shares = Scale { ticks_from: one, ..Scale::logarithmic(0.2 * one, 1.6) };
    let scales = [Scale::logarithmic(least, most), shares];
    let (columns, aspect) = width.select((1, 0.72), (2, 0.95));
    let time = rich("seconds per cell");
    let names = [rich("largest error of {m}/{V}"), rich("share of cells not labelled right")];
    let mut bottom = 0.0_f64;
    let mut top = 0.0;
    let half = scene.width / f64::from(columns);
    let mut left = 0.0;
    for (number, (y, name)) in scales.into_iter().zip(&names).enumerate() {
        let mut panels = Panels::new(half, 1, 1, aspect, x, y);
        let (right, down) = if columns == 2 { (number as f64 * half, 0.0) } else { (0.0, top) };
        panels.shift((right, down));
        let panel = panels.panels[0];
        if number == 0 {
            left = panel.rect.x;
        }
        let front = |row: &Row| if number == 0 { row.front_error } else { row.front_labels };
        let height = |row: &Row| match number {
            0 => row.margin.map(|errors| errors.worst.max(least)),
            _ => row
                .near
                .and_then(|labels| labels.missed())
                .map(|share| if share > 0.0 { share } else { none }),
        };
        draw_front(scene, &panel, study.rows.iter().filter(|row| front(row)), height);
        if number == 1 {
            zero(scene, &panel, none, 0.6 * one);
        }
        // The lower end of the bar.
        let low = |row: &Row| match number {
            0 => row.margin.map(|errors| errors.median.max(least)),
            _ => row
                .near
                .and_then(|labels| labels.mistaken())
                .map(|share| if share > 0.0 { share } else { none }),
        };
        for line in &lines {
            draw_line(scene, &panel, line, [&height, &low], front, number == 0);
        }
        panels.axes(scene, &time, name);
        panel.title(scene, &letter(number));
        bottom = bottom.max(panels.bottom);
        top = panels.bottom - 2.0;
    }
    let mut legend = Legend::default();
    for line in &lines {
        let sample = match line.rows.len() {
            1 => Sample::Mark(line.style.marker, line.style.stroke.color, false),
            _ => Sample::Method(line.style),
        };
        legend.add(sample, Rich::foreign(&line.name.replace('_', " ")));
    }
    legend.add(Sample::Line(FRONT), rich("Pareto front"));
    legend.add(Sample::Mark(Marker::Circle, style::GREY, true), rich("filled: on the front"));
    let bar = Sample::Line(Stroke::solid(style::GREY, 0.5));
    legend.add(bar, rich("(a): down to the median; (b): to the wrong ones"));
    if lines.iter().any(|line| line.unanswered() > 0.0) {
        legend.add(Sample::Text(rich("7")), rich("(a): % of cells without an answer"));
    }
    legend.add(Sample::Line(NONE), rich("(b): none below this line"));
    legend.below(scene, left, bottom + 2.0);
}

/// The line for errors of zero.
fn zero(scene: &mut Scene, panel: &Panel, none: f64, above: f64) {
    let Rect { x, w, .. } = panel.rect;
    let at = panel.place(panel.x.from, above).1;
    scene.line(&[(x, at), (x + w, at)], &NONE);
    let label = panel.place(panel.x.from, none).1 + 0.36 * SMALL_TEXT;
    scene.text((x - 3.0, label), &rich("0"), SMALL_TEXT, Anchor::End);
}

/// The front as a staircase: at each time the smallest error that is reached.
fn draw_front<'a>(
    scene: &mut Scene,
    panel: &Panel,
    rows: impl Iterator<Item = &'a Row>,
    height: impl Fn(&Row) -> Option<f64>,
) {
    let mut corners: Vec<(f64, f64)> = rows.filter_map(|row| Some((row.seconds, height(row)?))).collect();
    corners.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (Some(first), Some(last)) = (corners.first(), corners.last()) else { return };
    let mut places: Vec<Place> = vec![panel.place(first.0, panel.y.to)];
    let mut level = panel.y.to;
    for &(seconds, error) in &corners {
        places.push(panel.place(seconds, level));
        places.push(panel.place(seconds, error));
        level = error;
    }
    places.push(panel.place(panel.x.to, last.1));
    scene.line(&places, &FRONT);
}

/// The height of a row in a panel.
type Height<'a> = &'a dyn Fn(&Row) -> Option<f64>;

fn draw_line(
    scene: &mut Scene,
    panel: &Panel,
    line: &Line,
    [height, low]: [Height; 2],
    front: impl Fn(&Row) -> bool,
    tells_unanswered: bool,
) {
    let LineStyle { stroke, marker } = line.style;
    let marks: Vec<(Place, &Row)> =
        line.rows.iter().filter_map(|row| Some((panel.place(row.seconds, height(row)?), *row))).collect();
    for (place, row) in &marks {
        if let Some(low) = low(row) {
            let low = panel.place(row.seconds, low).1;
            scene.line(&[*place, (place.0, low)], &Stroke::solid(stroke.color, 0.5));
        }
    }
    let places: Vec<Place> = marks.iter().map(|(place, _)| *place).collect();
    scene.line(&places, &stroke);
    for (place, row) in marks {
        let filled = front(row) && !matches!(marker, Marker::Cross | Marker::Plus);
        // Marks without an interior are drawn larger instead.
        let size = if front(row) { 1.3 * MARKER } else { MARKER };
        scene.marker(marker, place, size, stroke.color, filled);
    }
    // Beside the last mark, where there is room.
    let unanswered = line.unanswered();
    if tells_unanswered
        && unanswered > 0.0
        && let Some(place) = places.last()
    {
        let beside = (place.0 + MARKER, place.1 + 0.36 * SMALL_TEXT);
        scene.text(beside, &Rich::number(unanswered, 3), SMALL_TEXT, Anchor::Start);
    }
}

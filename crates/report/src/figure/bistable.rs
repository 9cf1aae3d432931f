//! The bistable band: dampings between the loss of stability of the equilibrium and the critical damping,
//! at which steady slip and the stick-slip cycle both attract. Where the critical damping is the smaller of
//! the two, a slip cycle attracts between them.

use ndarray::Array2;

use super::super::ReportError;
use super::super::text::{Rich, rich};
use super::super::units::{Label, View};
use super::axis::{Scale, extremes};
use super::curves::Budget;
use super::data::Data;
use super::legend::{Legend, Sample};
use super::panels::{Panel, Panels, write_heading};
use super::region::outlines;
use super::scene::{Marker, Place, Rect, Scene, Stroke, Width};
use super::slice::{Slice, equals};
use super::{Figure, at_each_width, curves, palette};
use slipmap_map::map::Regime;
use slipmap_numbers::text::count;

/// The attractors on either side of the two curves; cycles that begin at folds are left out.
const AREAS: [Regime; 4] = [Regime::StickSlip, Regime::Bistable, Regime::PureSlip, Regime::Equilibrium];

/// The smallest positive double: curves begin at a fraction of the first node, which may round to zero.
const SMALLEST: f64 = f64::from_bits(1);

/// Upper limit of the loss of stability on the damping axis, in critical dampings.
const MOST_OF_HOPF: f64 = 3.0;

const HOPF: Stroke = Stroke { color: palette::BLACK, width: 0.8, dash: &[3.0, 2.0] };
const CRITICAL: Stroke = Stroke::solid(palette::BLACK, 1.0);

/// The figure: (a) the band in the plane of V and c at the largest eps, (b) its width against eps. For a
/// machine, for laws that do not vanish with eps, and where no band is found, only the plane. `None` for a map without a
/// positive critical damping.
pub(crate) fn bistable(view: &View) -> Result<Option<Figure>, ReportError> {
    let budget = Budget::of_figure();
    let map = view.map;
    let axes = map.grid().axes();
    let v = axes.len() - 2;
    let mut index = view.informative_nodes();
    index[0] = axes[0].values.len() - 1;
    let belt = &axes[v].values;
    let full = match belt.as_slice() {
        [only] => Scale::linear((0.1 * only).max(SMALLEST), (2.0 * only).min(f64::MAX)),
        _ => Scale::of_range(belt[0], belt[belt.len() - 1]),
    };
    let samples = curves::samples(full, curves::FEW_POINTS);
    let roots = curves::exact(&curves::columns(map, &index, v, &samples), &budget);
    let x = curves::cut(full, &samples, |i| roots[i]);
    let values = budget.samples(x);
    let columns = curves::columns(map, &index, v, &values);
    let upper = curves::exact(&columns, &budget);
    let lower: Vec<f64> = columns.iter().map(curves::stability).collect();
    let most = upper.iter().copied().filter(|c| c.is_finite()).fold(0.0, f64::max);
    if most == 0.0 {
        return Ok(None);
    }
    let stable = upper.iter().zip(&lower).filter(|(c, _)| c.is_finite()).map(|(_, hopf)| *hopf);
    let y = Scale::linear(0.0, 1.15 * stable.fold(most, f64::max).min(MOST_OF_HOPF * most));
    let (x_label, y_label) = (view.axis(&axes[v]), view.axis(&axes[v + 1]));
    let (x, y) = (x.in_unit(x_label.factor), y.in_unit(y_label.factor));
    let held = view.held(&index, &[0, v, v + 1]);

    let epsilons = &axes[0].values;
    let widths = Scale::logarithmic(
        (0.1 * epsilons[0]).max(SMALLEST),
        epsilons[epsilons.len() - 1].max((epsilons[0] * 1.01).min(f64::MAX)),
    );
    let eps_values = curves::samples(widths, curves::POINTS);
    let mut speeds = vec![0, index[v], belt.len() - 1];
    speeds.dedup();
    let has_widths =
        view.units.machine.is_none() && columns[0].curve.first_order(columns[0].belt_speed).is_ok();
    speeds.retain(|_| has_widths);
    let bands: Vec<(f64, Vec<f64>)> = speeds
        .iter()
        .map(|&speed| {
            let mut index = index.clone();
            index[v] = speed;
            let columns = curves::columns(map, &index, 0, &eps_values);
            let roots = curves::exact(&columns, &budget);
            let width = roots.iter().zip(&columns).map(|(root, column)| {
                // Both ends are legal dampings; logarithmic axes show only positive widths.
                let width = root - curves::stability(column).max(0.0);
                // Smaller differences are rounding errors of two critical dampings.
                if width > 1e-8 * root.abs() { width } else { f64::NAN }
            });
            (belt[speed], width.collect())
        })
        .collect();
    let drawn = bands.iter().flat_map(|(_, width)| width).copied().filter(|width| width.is_finite());
    let (least, largest) = extremes(drawn);
    let alone = least >= largest;
    let width_scale = match alone {
        true => Scale::logarithmic(1.0, 1.0),
        false => Scale::logarithmic(0.8 * least, 1.5 * largest),
    };

    let unknown = unknown_regimes(view, &index, v)?;
    let scenes = at_each_width(|scene, width| {
        let whole = scene.width;
        let half = match width {
            Width::TwoColumns if !alone => 0.5 * scene.width,
            _ => scene.width,
        };
        let aspect = if half > Width::OneColumn.points() { 0.5 } else { 0.7 };
        let mut first = Panels::new(half, 1, 1, aspect, x, y);
        first.shift((0.0, write_heading(scene, first.panels[0].rect.x, &held)));
        let panel = first.panels[0];
        let top = panel.rect.y;
        band(scene, &panel, &values, &lower, &upper);
        let cells = unknown.draw(scene, &panel);
        first.axes(scene, &x_label.text(), &y_label.text());
        let mut legend = Legend::default();
        let slips = upper.iter().zip(&lower).any(|(critical, hopf)| hopf > critical);
        for regime in AREAS.into_iter().filter(|regime| slips || *regime != Regime::PureSlip) {
            let kind = palette::regime(regime);
            legend.add(Sample::Area(kind.fill), rich(&kind.words));
        }
        if cells {
            legend.add(Sample::Area(palette::FAILED), rich("cells of unknown cycles"));
        }
        if upper.iter().any(|critical| !critical.is_finite()) {
            legend.add(Sample::Area(palette::UNKNOWN), rich("critical damping unknown"));
        }
        legend.add(Sample::Line(HOPF), rich("equilibrium becomes stable"));
        legend.add(Sample::Line(CRITICAL), rich("critical damping"));
        scene.width = whole;
        if alone {
            legend.below(scene, panel.rect.x, first.bottom);
            return;
        }
        panel.title(scene, &rich("(a) ").then(equals("epsilon", axes[0].values[index[0]])));

        let mut second = Panels::new(half, 1, 1, 0.7, widths, width_scale);
        second.shift(width.select((0.0, first.bottom + 4.0), (half, top - second.panels[0].rect.y)));
        let panel = second.panels[0];
        let styles = [
            (Stroke::solid(palette::BLUE, 1.2), Marker::Circle),
            (Stroke { color: palette::VERMILION, width: 1.2, dash: &[5.0, 2.0] }, Marker::Square),
            (Stroke { color: palette::GREEN, width: 1.2, dash: &[1.5, 1.5] }, Marker::Triangle),
        ];
        let drawn = bands.iter().filter(|(_, widths)| widths.iter().any(|width| width.is_finite()));
        for (turn, ((speed, widths), (stroke, marker))) in drawn.zip(styles).enumerate() {
            let style = palette::MethodStyle { stroke, marker };
            curves::draw(scene, &panel, &eps_values, widths, &style, 2 * turn);
            legend.add(Sample::Method(style), equals("V", *speed));
        }
        // A guide of slope 2 below the curves.
        let (from, to) = (widths.value(0.35), widths.value(0.75));
        let start = width_scale.value(0.12);
        let line = [panel.place(from, start), panel.place(to, start * (to / from) * (to / from))];
        scene.clipped(panel.rect, |scene| scene.line(&line, &curves::GUIDE));
        legend.add(Sample::Line(curves::GUIDE), rich("slope of {epsilon^2}"));
        panel.title(scene, &rich("(b) width of the band"));
        second.axes(scene, &rich("{epsilon}"), &rich("width in {c}"));
        let bottom = first.bottom.max(second.bottom);
        legend.below(scene, first.panels[0].rect.x, bottom);
    });
    let caption = rich(
        "What attracts below and above the damping at which the equilibrium becomes stable and the critical damping",
    )
    .taken_at(held)
    .then(". Cycles that begin at folds are left out.")
    .then(unknown.words())
    .then(rich(match alone {
        true => "",
        false => " (b) Width of the bistable band at legal dampings {c} ≥ 0, against {epsilon}.",
    }));
    let scaled = |numbers: &[f64], factor: f64| numbers.iter().map(|number| number * factor).collect();
    let header = |key: &str| Label { key: key.into(), ..y_label.clone() }.header();
    let data = Data::default()
        .reals(x_label.header(), scaled(&values, x_label.factor))
        .reals(header("equilibrium_stable_from"), scaled(&lower, y_label.factor))
        .reals(header("critical_damping"), scaled(&upper, y_label.factor));
    Ok(Some(Figure { name: "bistable".into(), caption, scenes, data }))
}

/// The cells of the map in the plane of V and c whose regime is not determined.
struct UnknownRegimes {
    /// Edges of the cells along V and c.
    edges: [Vec<f64>; 2],
    is_unknown: Array2<bool>,
}

/// Finds them; none for a map without regimes, or without cells in the plane.
fn unknown_regimes(view: &View, index: &[usize], v: usize) -> Result<UnknownRegimes, ReportError> {
    let axes = view.map.grid().axes();
    let nothing = UnknownRegimes { edges: [Vec::new(), Vec::new()], is_unknown: Array2::default((0, 0)) };
    if !view.map.has("regime") || axes[v].values.len() < 2 || axes[v + 1].values.len() < 2 {
        return Ok(nothing);
    }
    let slice = Slice::new(view, v, v + 1, index.to_vec());
    let is_unknown = slice.codes("regime")?.map(|code| *code == Regime::Failed.code());
    Ok(UnknownRegimes { edges: slice.edges(), is_unknown })
}

impl UnknownRegimes {
    /// Draws the cells over the areas; `false` if there are none.
    fn draw(&self, scene: &mut Scene, panel: &Panel) -> bool {
        let [x, y] = &self.edges;
        if self.is_unknown.is_empty() {
            return false;
        }
        let areas = outlines(panel, x, y, |i, j| self.is_unknown[[i, j]]);
        scene.clipped(panel.rect, |scene| scene.area(&areas, palette::FAILED));
        !areas.is_empty()
    }

    /// The sentence of the caption; empty if there are none.
    fn words(&self) -> Rich {
        let unknown = self.is_unknown.iter().filter(|unknown| **unknown).count() as u64;
        match unknown {
            0 => Rich::default(),
            _ => rich(&format!(
                " In black: {} of the {} cells of the map in this plane, in which it is not known which cycles attract.",
                count(unknown),
                count(self.is_unknown.len() as u64)
            )),
        }
    }
}

/// The areas between the curves and the frame; where the critical damping is unknown, an area that says so.
fn band(scene: &mut Scene, panel: &Panel, x: &[f64], lower: &[f64], upper: &[f64]) {
    if upper.iter().any(|critical| !critical.is_finite()) {
        let Rect { x, y, w, h } = panel.rect;
        scene.area(&[vec![(x, y), (x + w, y), (x + w, y + h), (x, y + h)]], palette::UNKNOWN);
    }
    let known = |i: usize| upper[i].is_finite();
    let ends = |i: usize| known(i) && (i == 0 || !known(i - 1));
    for first in (0..x.len()).filter(|&i| ends(i)) {
        let last = (first..x.len()).take_while(|&i| known(i)).last().unwrap_or(first);
        let under = |curve: &dyn Fn(usize) -> f64| -> Vec<Place> {
            let top = (first..=last).map(|i| panel.place(x[i], curve(i).max(panel.y.from)));
            top.chain([panel.place(x[last], panel.y.from), panel.place(x[first], panel.y.from)]).collect()
        };
        scene.clipped(panel.rect, |scene| {
            let mut fill = |curve: &dyn Fn(usize) -> f64, regime| {
                scene.area(&[under(curve)], palette::regime(regime).fill);
            };
            // Each area covers a part of the one before.
            fill(&|_| panel.y.to, Regime::Equilibrium);
            fill(&|i| lower[i], Regime::PureSlip);
            fill(&|i| upper[i], Regime::Bistable);
            fill(&|i| lower[i].min(upper[i]), Regime::StickSlip);
            let line = |curve: &[f64]| -> Vec<Place> {
                (first..=last).map(|i| panel.place(x[i], curve[i])).collect()
            };
            scene.line(&line(lower), &HOPF);
            scene.line(&line(upper), &CRITICAL);
        });
    }
}

//! Phase portraits along one column of a map.

use super::super::view::View;
use super::curves::Budget;
use super::{Figure, curves};
use slipmap_figure::data::Data;
use slipmap_figure::legend::Legend;
use slipmap_figure::lines::letter;
use slipmap_figure::panels::{BOTTOM_MARGIN, Panel, Panels, TITLE_MARGIN};
use slipmap_figure::scene::{Rect, Scene, Width};
use slipmap_figure::text::rich;
use slipmap_model::filippov::Oscillator;
use slipmap_model::flow::Fate;
use slipmap_orbits::flow;
use slipmap_page::portrait::{Portrait, equal_scales, orbit_data};
use slipmap_page::units::{Label, UnitSystem};
use slipmap_witness::{Sample as State, Start};

const TOLERANCE: f64 = 1e-10;

/// Portraits along one column of the map: below the critical damping, in the bistable band, above it, and,
/// where a column of the map has one, an orbit that crosses the belt line. `None` for a map without a cycle.
pub(crate) fn portraits(view: &View, width: Width) -> Option<Figure> {
    let grid = view.map.grid();
    let axes = grid.axes();
    let mut index = view.informative_nodes();
    // The largest eps that has a cycle, since orbits differ most there.
    let budget = Budget::of_figure();
    let root =
        |index: &[usize]| grid.column(index).map_or(f64::NAN, |column| curves::exact(&[column], &budget)[0]);
    for epsilon in (0..grid.epsilons().len()).rev() {
        index = grid.at_epsilon(&index, epsilon);
        if root(&index) > 0.0 {
            break;
        }
    }
    let column = grid.column(&index).ok()?;
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
    let belt = axes.len() - 2;
    let held_index = index.clone();
    index[belt] = axes[belt].values.len() - 1;
    let fast = grid.column(&index).ok()?;
    let slowest = grid.dampings()[0];
    let crosses =
        |c: f64| matches!(flow(&Oscillator::in_column(&fast, c), TOLERANCE).fate, Fate::CrossesForever);
    if crosses(slowest) {
        points.push((fast, slowest));
    }
    let of = |column: &_, c: f64| Portrait::of(&Oscillator::in_column(column, c), Start::ExitPoint, None);
    let drawn: Vec<(f64, Portrait)> = points.iter().map(|(column, c)| (*c, of(column, *c))).collect();
    // The orbits of the fast belt have another scale, so they get their own panel.
    let common = drawn
        .iter()
        .take(3)
        .map(|(_, portrait)| portrait.extent())
        .fold([f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY, f64::NEG_INFINITY], |a, b| {
            [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]
        });
    let units = view.units_at(&held_index);
    let (x1, x2) = (units.x1(), units.x2());
    let (belt_label, damping) = (view.axis(&axes[belt]), view.axis(&axes[belt + 1]));
    let held = view.held(&held_index, &[belt + 1]);
    let mut scene = Scene::new(width.points(), 0.0);
    let columns = width.select(2, 3);
    let (x, y, h) = equal_scales(common, 1.0, (0.5, 1.1));
    let (x, y) = (x.in_unit(x1.factor), y.in_unit(x2.factor));
    let mut panels = Panels::below(&mut scene, &held, columns, 3, h, (x, y));
    let mut legend = Legend::default();
    // Equal units in both directions, for the height that is left on the page.
    let aspect = panels.panels[0].rect.h / panels.panels[0].rect.w;
    let (x, y, _) = equal_scales(common, 1.0, (aspect, aspect));
    for panel in &mut panels.panels {
        (panel.x, panel.y) = (x.in_unit(x1.factor), y.in_unit(x2.factor));
    }
    for (number, (panel, (c, portrait))) in panels.panels.iter().zip(&drawn).enumerate() {
        portrait.draw(&mut scene, panel);
        portrait.legend(&mut legend);
        panel.title(&mut scene, &letter(number).then(damping.equals(rounded(*c))));
    }
    panels.axes(&mut scene, &x1.text(), &x2.text());
    let mut bottom = panels.bottom;
    if let Some((c, portrait)) = drawn.get(3) {
        let w = 0.5 * scene.width;
        let (x, y, h) = equal_scales(portrait.extent(), w, (0.4, 0.7));
        let (x, y) = (x.in_unit(x1.factor), y.in_unit(x2.factor));
        let rect = Rect { x: panels.panels[0].rect.x, y: bottom + TITLE_MARGIN, w, h };
        let panel = Panel { rect, x, y };
        portrait.draw(&mut scene, &panel);
        panel.named_axes(&mut scene, &x1.text(), &x2.text(), Panel::y_labels_width(y, h));
        let speed = belt_label.equals(axes[belt].values[index[belt]]);
        panel.title(&mut scene, &letter(3).then(damping.equals(*c)).then(", ").then(speed));
        portrait.legend(&mut legend);
        bottom = rect.y + h + BOTTOM_MARGIN;
    }
    legend.below(&mut scene, panels.panels[0].rect.x, bottom);
    let mut caption = rich("Phase portraits at ").then(held).then(": ");
    for (number, (_, portrait)) in drawn.iter().enumerate() {
        let separator = rich(if number > 0 { "; " } else { "" });
        let fast = rich(if number == 3 { "on the fastest belt of the map, " } else { "" });
        caption = caption.then(separator).then(letter(number)).then(fast).then(rich(portrait.words()));
    }
    let data = data(&drawn, &damping, &units);
    Some(Figure { name: "portraits".into(), caption: caption.then("."), scene, data })
}

/// The orbits from the exit point.
fn data(drawn: &[(f64, Portrait)], damping: &Label, units: &UnitSystem) -> Data {
    let orbits = drawn.iter().map(|(c, portrait)| (c * damping.factor, &portrait.orbit.samples));
    let dampings = orbits.clone().flat_map(|(c, samples)| std::iter::repeat_n(c, samples.len()));
    let samples: Vec<State> = orbits.flat_map(|(_, samples)| samples).copied().collect();
    Data::default().reals(damping.header(), dampings.collect()).join(orbit_data(&samples, units))
}

/// Rounded to three digits, for titles.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

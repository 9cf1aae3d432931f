//! Critical damping of every method against belt speed.

use super::super::view::View;
use super::curves::Budget;
use super::slice::Slice;
use super::verdict_panels::{chosen_epsilons, method_title};
use super::{Figure, curves};
use slipmap_figure::axis::Scale;
use slipmap_figure::data::Data;
use slipmap_figure::lines::{self, Chart, Curve};
use slipmap_figure::scene::Width;
use slipmap_figure::text::{Rich, rich};
use slipmap_page::palette;
use slipmap_page::units::Label;
use slipmap_page::units::equals;

/// If a map has only one V, the range of V shown, as a factor up and down.
const SPREAD: f64 = 10.0;

/// Critical damping against V, one panel per eps; `None` if no method claims a cycle anywhere.
pub(crate) fn critical(view: &View, width: Width) -> Option<Figure> {
    let budget = Budget::of_figure();
    let map = view.map;
    let axes = map.grid().axes();
    let (c, v) = (axes.len() - 1, axes.len() - 2);
    let nodes = &axes[v].values;
    let x = match nodes.as_slice() {
        [only] => Scale::logarithmic(only / SPREAD, (only * SPREAD).min(f64::MAX)),
        nodes => Scale::of_range(nodes[0], nodes[nodes.len() - 1]),
    };
    let epsilons = chosen_epsilons(map);
    let index = view.informative_nodes();
    let values = curves::samples(x);
    let of = |&epsilon: &usize| {
        let index = map.grid().at_epsilon(&index, epsilon);
        curves::by_method(map, &curves::columns(map, &index, v, &values), values.len(), &budget)
    };
    let (panels, errors): (Vec<curves::Boundaries>, Vec<Vec<f64>>) = epsilons.iter().map(of).unzip();
    let is_drawn = |name: &str| {
        let of = panels.iter().flatten().filter(|(method, _)| method == name);
        of.flat_map(|(_, curve)| curve).any(|c| c.is_finite() && *c >= 0.0)
    };
    let most = panels.iter().flatten().flat_map(|(_, curve)| curve).copied().filter(|c| c.is_finite());
    let most = most.fold(0.0, f64::max);
    if most == 0.0 {
        return None;
    }
    let (x_label, y_label) = (view.axis(&axes[v]), view.axis(&axes[c]));
    let y_name = match &*y_label.unit {
        "" => rich("critical damping {c}"),
        _ => rich("critical ").then(y_label.text()),
    };
    // The caption gives the law's parameters only.
    let held = Slice::new(view, v, c, index).held_but_epsilon();
    let curve = |(name, dampings): &(String, Vec<f64>)| Curve {
        name: if is_drawn(name) { method_title(name) } else { Rich::default() },
        style: palette::method(name),
        points: values.iter().copied().zip(dampings.iter().copied()).collect(),
        marks: true,
    };
    let chart = |(methods, &epsilon): (&curves::Boundaries, &usize)| Chart {
        name: y_name.clone(),
        title: match view.units.machine {
            None => equals("epsilon", map.grid().epsilons()[epsilon]),
            Some(_) => Rich::default(),
        },
        factor: y_label.factor,
        y: Some(Scale::linear(0.0, 1.04 * most)),
        curves: methods.iter().map(curve).collect(),
    };
    let charts: Vec<Chart> = panels.iter().zip(&epsilons).map(chart).collect();
    let scene = lines::draw(&held, x.in_unit(x_label.factor), &x_label.text(), &charts, width);
    let mut caption =
        rich("The damping up to which each method claims a stick-slip cycle, against belt speed")
            .taken_at(held)
            .then("; simulation: the exact critical damping {c^*}.");
    if nodes.len() == 1 {
        caption = caption.then(" The map has one {V} only; the curves go beyond it.");
    }
    let mut data = Data::default();
    let shown: Vec<f64> = values.iter().map(|value| value * x_label.factor).collect();
    let count = panels.len();
    if count > 1 {
        let each = epsilons.iter().flat_map(|&e| std::iter::repeat_n(map.grid().epsilons()[e], shown.len()));
        data = data.reals("epsilon", each.collect());
    }
    data = data.reals(x_label.header(), shown.repeat(count));
    let methods: Vec<&String> = panels.iter().flatten().map(|(name, _)| name).take(panels[0].len()).collect();
    for (position, name) in methods.into_iter().enumerate() {
        let label = Label { key: map.critical(name), ..y_label.clone() };
        let numbers = panels.iter().flat_map(|panel| &panel[position].1).map(|c| c * label.factor);
        data = data.reals(label.header(), numbers.collect());
    }
    let label = Label { key: map.critical_error(), ..y_label.clone() };
    data = data.reals(label.header(), errors.concat().iter().map(|error| error * label.factor).collect());
    Some(Figure { name: "critical-damping".into(), caption, scene, data })
}

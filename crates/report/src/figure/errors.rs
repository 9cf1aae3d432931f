//! Error of each method's boundary against eps, on logarithmic axes. At one eps the table says it.

use super::super::boundary::Order;
use super::super::view::View;
use super::super::{MethodBoundary, Report};
use super::Figure;
use super::verdict_panels::method_title;
use slipmap_figure::axis::Scale;
use slipmap_figure::data::Data;
use slipmap_figure::lines::{self, Chart, Curve};
use slipmap_figure::scene::{Place, Stroke, Width};
use slipmap_figure::style::LineStyle;
use slipmap_figure::text::{Rich, rich};
use slipmap_page::palette;
use slipmap_page::units::Label;

/// Median, 95 % quantile and maximum of the error of a method at an eps, if they can be drawn on a
/// logarithmic axis.
fn drawn(method: &MethodBoundary, epsilon: usize) -> Option<(f64, f64, f64)> {
    let errors = &method.errors[epsilon];
    let median = errors.sizes.quantile(0.5).filter(|median| *median > 0.0)?;
    let high = errors.sizes.quantile(0.95)?.max(median);
    Some((median, high, errors.worst.map_or(high, f64::abs).max(high)))
}

/// A logarithmic scale around all errors that are drawn.
fn scale(report: &Report, epsilons: usize) -> Option<Scale> {
    let methods = &report.boundaries.methods;
    let all = methods.iter().flat_map(|method| (0..epsilons).filter_map(|e| drawn(method, e)));
    let (low, high) =
        all.fold((f64::INFINITY, 0.0_f64), |(low, high), errors| (low.min(errors.0), high.max(errors.1)));
    (low <= high).then(|| Scale::logarithmic(0.5 * low, 2.0 * high))
}

/// The figure; `None` at one eps, and if no method has a boundary error to show.
pub(crate) fn errors(view: &View, report: &Report, width: Width) -> Option<Figure> {
    let axes = view.map.grid().axes();
    let epsilons = view.map.grid().epsilons();
    let label = view.axis(&axes[axes.len() - 1]);
    if epsilons.len() == 1 {
        return None;
    }
    let y = scale(report, epsilons.len())?;
    let x = Scale::logarithmic(epsilons[0] / 1.3, epsilons[epsilons.len() - 1] * 1.3);
    let error = Label { name: rich("error of the critical damping"), ..label.clone() };
    let chart = Chart {
        name: error.text(),
        title: Rich::default(),
        factor: label.factor,
        y: Some(y),
        curves: report.boundaries.methods.iter().flat_map(|method| curves(method, epsilons)).collect(),
    };
    let scene = lines::draw(&Rich::default(), x, &Rich::symbol("epsilon"), &[chart], width);
    let caption = rich(
        "How far each method's critical damping is from the exact one, {c^*}. A column of the map is all dampings at \
         one value of each other parameter; in each column where both are known, the error is the distance between the \
         damping up to which the method claims the cycle and {c^*}. For a test that claims only what it proves, this is \
         the width of the band that it leaves open. Marks: median over the columns; thin lines: the error that 95 % of \
         them do not exceed. {p}: the order of the error, {epsilon}^{p}, where it is asymptotic.",
    );
    let cells = report
        .boundaries
        .methods
        .iter()
        .flat_map(|method| (0..epsilons.len()).filter_map(move |e| Some((method, e, drawn(method, e)?))));
    let cells: Vec<_> = cells.collect();
    let column = |of: fn(&(f64, f64, f64)) -> f64| -> Vec<f64> {
        cells.iter().map(|(.., errors)| of(errors) * label.factor).collect()
    };
    let header = |what: &str| Label { key: format!("{what}_error"), ..label.clone() }.header();
    let data = Data::default()
        .words("method", cells.iter().map(|(method, ..)| method.method.clone()).collect())
        .reals("epsilon", cells.iter().map(|(_, e, _)| epsilons[*e]).collect())
        .reals(header("median"), column(|errors| errors.0))
        .reals(header("percentile_95"), column(|errors| errors.1))
        .reals(header("worst"), column(|errors| errors.2));
    Some(Figure { name: "boundary-error".into(), caption, scene, data })
}

/// The curves of the median and of the 95 % quantile of a method's errors; none without errors.
fn curves(method: &MethodBoundary, epsilons: &[f64]) -> Vec<Curve> {
    let known = epsilons.iter().enumerate().filter_map(|(e, &epsilon)| {
        let (median, high, _) = drawn(method, e)?;
        Some(((epsilon, median), (epsilon, high)))
    });
    let (medians, highs): (Vec<Place>, Vec<Place>) = known.unzip();
    if medians.is_empty() {
        return Vec::new();
    }
    let style = palette::method(&method.method);
    let thin = LineStyle { stroke: Stroke { width: 0.5, ..style.stroke }, ..style };
    let name = method_title(&method.method).then(order(method));
    vec![
        Curve { name: Rich::default(), style: thin, points: highs, marks: false },
        Curve { name, style, points: medians, marks: true },
    ]
}

/// ", p = 2.01"; nothing where the error is not asymptotic.
fn order(method: &MethodBoundary) -> Rich {
    let Some(order) = method.orders.first().and_then(Order::asymptotic) else { return Rich::default() };
    rich(", {p} = ").then(Rich::foreign(&format!("{order:.2}").replace('-', "−")))
}

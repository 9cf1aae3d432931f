//! Tables of the error of each method's boundary in c, and of its order in eps.

use super::super::Report;
use super::super::boundary::{MethodBoundary, Order};
use super::super::table::{Cell, Column, ColumnOf, Show, Table};
use super::super::units::{Label, View};
use super::{EPSILON_DIGITS, column_of, epsilons, in_unit, percent, words};
use slipmap_figure::text::{Rich, rich};
use slipmap_format::MapFile;

/// Error of each method's boundary in c.
#[must_use]
pub fn boundary(view: &View, report: &Report) -> Table {
    let map = view.map;
    let boundaries = &report.boundaries;
    let axes = map.grid().axes();
    let damping = view.axis(&axes[axes.len() - 1]);
    let parameters = &axes[1..axes.len() - 1];
    let mut rows = Vec::new();
    for (e, &epsilon) in epsilons(map).iter().enumerate() {
        for method in &boundaries.methods {
            let errors = &method.errors[e];
            let mut row = vec![
                Cell::Real(epsilon),
                words(&method.method),
                Cell::Count(errors.sizes.count),
                in_unit(errors.sizes.quantile(0.5), &damping),
                in_unit(errors.sizes.quantile(0.95), &damping),
                in_unit(errors.worst.as_ref().map(|worst| worst.error), &damping),
                percent(errors.beyond as f64, errors.sizes.count as f64).into(),
                Cell::Count(errors.only_exact),
                Cell::Count(errors.only_method),
            ];
            for (axis, parameter) in parameters.iter().enumerate() {
                let worst = errors.worst.as_ref().map(|worst| parameter.values[worst.column[axis + 1]]);
                row.push(in_unit(worst, &view.axis(parameter)));
            }
            rows.push(row);
        }
    }
    let mut columns = vec![
        Column::new("epsilon", "{epsilon}", EPSILON_DIGITS),
        Column::new("method", "method", Show::AsIs),
        Column::new("columns", "columns", Show::AsIs),
        column_of(&damping, "median_error", "median", Show::Significant(3)),
        column_of(&damping, "percentile_95_error", "95 %", Show::Significant(3)),
        column_of(&damping, "worst_error", "worst", Show::Significant(3)),
        Column::new("percent_beyond", "% beyond", Show::Decimals(1)),
        Column::new("only_exact", "none claimed", Show::AsIs),
        Column::new("only_method", "none exists", Show::AsIs),
    ];
    for parameter in parameters {
        let label = view.axis(parameter);
        let named = Label { name: rich("worst ").then(label.name.clone()), ..label };
        columns.push(Column { key: named.header(), heading: named.text(), show: Show::Trimmed(4) });
    }
    let origin = if boundaries.stored { "read from the map" } else { "computed again for this report" };
    let mut notes = vec![rich(&format!(
        "Error: the damping {{c}} up to which the method claims the cycle minus the exact critical damping {{c^*}} \
         ({origin}), over the columns of the map (all parameters but {{c}} fixed) in which both are at least 0; median \
         and 95 % are of its size, known to 0.05 %. Beyond: columns in which the method claims too much. None claimed, none exists: \
         columns in which only {{c^*}}, or only the method's boundary, is at least 0."
    ))];
    notes.extend(unknown(report));
    Table {
        name: "boundary",
        caption: rich("Error in {c} of the boundary of each method, against the exact critical damping."),
        columns,
        rows,
        notes,
    }
}

fn unknown(report: &Report) -> Option<Rich> {
    let unknown = &report.boundaries.unknown;
    (!unknown.is_empty()).then(|| {
        rich("Left out, because the map does not store their boundary: ")
            .then(Rich::foreign(&unknown.join(", ")))
            .then(".")
    })
}

/// The order in eps of the boundary's error.
#[must_use]
pub fn order(map: &MapFile, report: &Report) -> Table {
    let epsilons = epsilons(map).len();
    let note = match epsilons {
        1 => "The map has one {epsilon}: no order can be fitted.",
        2 => "The map has two {epsilon}: an order, but no confidence interval.",
        _ => {
            "Least squares of the logarithm of the median error on the logarithm of {epsilon}, over the columns that \
             have both boundaries at every {epsilon}; ± is half the 95 % confidence interval. Medians below the error \
             of {c^*} itself are left out; without two others there is no order."
        }
    };
    let (caption, digits) =
        (rich("Order {p} of the boundary's error in {c}, which falls like {epsilon^p}."), Show::Decimals(2));
    let smallest = "{p} at the two smallest {epsilon}";
    let points = |order: Option<Order>| Cell::Count(order.map_or(0, |order| order.points as u64));
    let columns: [ColumnOf<MethodBoundary>; 5] = [
        ("method", "method", Show::AsIs, &|of| words(&of.method)),
        ("order", "{p}", digits, &|of| of.order.map(|order| order.order).into()),
        ("order_error", "±", digits, &|of| of.order.and_then(|order| order.half_width).into()),
        ("order_smallest", smallest, digits, &|of| of.order.map(|order| order.smallest).into()),
        ("epsilons", "{epsilon} in the fit", Show::AsIs, &|of| points(of.order)),
    ];
    Table { notes: vec![rich(note)], ..Table::of("order", caption, &report.boundaries.methods, &columns) }
}

//! Tables of the error of each method's boundary in c, and of its order in eps.

use super::super::Report;
use super::super::boundary::Order;
use super::super::table::{Cell, Column, ColumnOf, Show, Table};
use super::super::view::View;
use super::{EPSILON_DIGITS, column_of, in_unit, percent, words};
use slipmap_figure::text::rich;

pub fn boundary(view: &View, report: &Report) -> Table {
    let map = view.map;
    let boundaries = &report.boundaries;
    let axes = map.grid().axes();
    let damping = view.axis(&axes[axes.len() - 1]);
    let mut rows = Vec::new();
    for (e, &epsilon) in map.grid().epsilons().iter().enumerate() {
        for method in &boundaries.methods {
            let errors = &method.errors[e];
            rows.push(vec![
                Cell::Real(epsilon),
                words(&method.method),
                Cell::Count(errors.sizes.count),
                in_unit(errors.sizes.quantile(0.5), &damping),
                in_unit(errors.sizes.quantile(0.95), &damping),
                in_unit(errors.worst, &damping),
                percent(errors.beyond as f64, errors.sizes.count as f64).into(),
                Cell::Count(errors.only_exact),
                Cell::Count(errors.only_method),
            ]);
        }
    }
    let columns = vec![
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
    let origin = if boundaries.stored { "read from the map" } else { "computed again for this report" };
    let notes = vec![rich(&format!(
        "Error: the damping {{c}} up to which the method claims the cycle minus the exact critical damping {{c^*}} \
         ({origin}), over the columns of the map (all parameters but {{c}} fixed) in which both are at least 0; median \
         and 95 % are of its size, known to 0.05 %. Beyond: columns in which the method claims too much. None claimed, none exists: \
         columns in which only {{c^*}}, or only the method's boundary, is at least 0."
    ))];
    Table {
        name: "boundary",
        caption: rich("Error in {c} of the boundary of each method, against the exact critical damping."),
        columns,
        rows,
        notes,
    }
}

/// The order in eps of the boundary's error, where it is asymptotic.
pub fn order(report: &Report) -> Table {
    let note = "From the median errors at two neighbouring {epsilon}, over the columns that have both boundaries at every \
                {epsilon}; medians below the error of {c^*} itself are left out. {p} ±: how far the exponent is from the \
                order, from the next pair's. It is told where that is at most 0.1.";
    let caption = rich(
        "Order {p} of the boundary's error in {c}, which falls like {epsilon^p} where it is asymptotic.",
    );
    let rows: Vec<(&str, Option<Order>)> = report
        .boundaries
        .methods
        .iter()
        .flat_map(|of| {
            let none = of.orders.is_empty().then_some((of.method.as_str(), None));
            of.orders.iter().map(|order| (of.method.as_str(), Some(*order))).chain(none)
        })
        .collect();
    let why_not = |of: &Option<Order>| match of {
        None => words("fewer than two medians above the error of c*"),
        Some(of) if of.asymptotic().is_some() => Cell::Missing,
        Some(Order { deviation: None, .. }) => words("no larger pair to compare with"),
        Some(of) => words(&format!("not asymptotic: the exponent {:.2} still changes", of.exponent)),
    };
    let columns: [ColumnOf<(&str, Option<Order>)>; 6] = [
        ("method", "method", Show::AsIs, &|(method, _)| words(method)),
        ("epsilon_from", "{epsilon} from", EPSILON_DIGITS, &|(_, of)| of.map(|of| of.epsilons[0]).into()),
        ("epsilon_to", "to", EPSILON_DIGITS, &|(_, of)| of.map(|of| of.epsilons[1]).into()),
        ("order", "{p}", Show::Decimals(2), &|(_, of)| of.and_then(|of| of.asymptotic()).into()),
        ("order_error", "±", Show::Decimals(2), &|(_, of)| of.and_then(|of| of.deviation).into()),
        ("why_not", "not told because", Show::AsIs, &|(_, of)| why_not(of)),
    ];
    Table { notes: vec![rich(note)], ..Table::of("order", caption, &rows, &columns) }
}

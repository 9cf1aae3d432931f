//! The table of what the method `validated` proves between the nodes of a map.

use super::table::{Cell, Column, Show, Table};
use super::text::rich;
use crate::store::MapFile;

/// Proved shares of the whole box of parameters; `None` if the run proved nothing.
#[must_use]
pub(super) fn volume(map: &MapFile) -> Option<Table> {
    let rows = [
        ("present", "proved_present"),
        ("absent", "proved_absent"),
        ("undecided", "proved_undecided"),
        ("undecided, proved bound", "proved_undecided_at_most"),
    ]
    .into_iter()
    .map(|(what, attribute)| Some(vec![Cell::Words(what.into()), Cell::Real(100.0 * map.number(attribute)?)]))
    .collect::<Option<Vec<_>>>()?;
    let (boxes, seconds) = (map.number("proved_boxes")?, map.number("proved_seconds")?);
    let column = |key: &str, heading: &str, show| Column { key: key.into(), heading: rich(heading), show };
    Some(Table {
        name: "proved_volume",
        caption: rich(
            "Volume of parameter space in which `validated` proves that the cycle is present or absent: the whole box \
             from the first to the last node of every axis, with all points between the nodes.",
        ),
        columns: vec![
            column("what", "proved", Show::AsIs),
            column("percent_of_box", "% of the box", Show::Significant(4)),
        ],
        rows,
        notes: vec![rich(&format!(
            "Every point of the first two sets is proved, round-off included. The volumes of the sets are measured on \
             16384 columns; the bound in the last row is proved as well. {boxes} boxes of scaled parameters were tried, in \
             {seconds:.1} s."
        ))],
    })
}

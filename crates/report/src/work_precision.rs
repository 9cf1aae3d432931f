//! Reports of a study of speed against accuracy: a table and a chart; measurements of peers are added here.

use std::path::{Path, PathBuf};

use super::figure::Width;
use super::table::{Cell as Entry, ColumnOf, Show, Table};
use super::{ReportError, figure, write};
use slipmap_figure::text::{Rich, rich};
use slipmap_files::{Existing, write_folder};
pub use slipmap_study::benchmark::{self, ContestantKind, Errors, Labels, Row, Study};

/// Adds the measurements of `scripts/study peers` on the same cells: `peers.csv` in `folder`, if it is there.
///
/// # Errors
/// [`ReportError::Peers`] if the file cannot be read, has another format, or is about other cells.
pub fn add_peers(study: &mut Study, folder: &Path) -> Result<(), ReportError> {
    let path = folder.join("peers.csv");
    if path.exists() {
        study.rows.retain(|row| row.kind != ContestantKind::Peer);
        study.rows.extend(read_peers(&path, &slipmap_format::fingerprint(&study.cells_csv()))?);
        study.mark_fronts();
    }
    Ok(())
}

/// The table of all numbers of the study.
fn table(study: &Study) -> Table {
    let size = |errors: &Option<Errors>, of: fn(&Errors) -> f64| Entry::from(errors.as_ref().map(of));
    let count = |labels: &Option<Labels>, of: fn(&Labels) -> usize| {
        Entry::from(labels.as_ref().map(|labels| of(labels) as u64))
    };
    let yes = |yes: bool| Entry::Words(if yes { "yes" } else { "" }.into());
    let knob =
        |row: &Row| row.setting.as_ref().map_or(Entry::Missing, |(knob, _)| Entry::Words(knob.clone()));
    let digits = Show::Significant(2);
    let columns: [ColumnOf<Row>; 21] = [
        ("kind", "kind", Show::AsIs, &|row| Entry::Words(row.kind.name().into())),
        ("method", "method", Show::AsIs, &|row| Entry::Words(row.name.clone())),
        ("knob", "knob", Show::AsIs, &|row| knob(row)),
        ("setting", "setting", Show::Trimmed(3), &|row| {
            row.setting.as_ref().map(|(_, setting)| *setting).into()
        }),
        ("cells", "cells", Show::AsIs, &|row| Entry::Count(row.cells as u64)),
        ("seconds_per_cell", "seconds per cell", Show::Significant(3), &|row| Entry::Real(row.seconds)),
        ("margin_error_median", "error of {m}/{V}: median", digits, &|row| size(&row.margin, |e| e.median)),
        ("margin_error_95", "95 %", digits, &|row| size(&row.margin, |e| e.high)),
        ("margin_error_worst", "worst", digits, &|row| size(&row.margin, |e| e.worst)),
        ("critical_c_error_median", "error of {c^*}: median", digits, &|row| {
            size(&row.critical, |e| e.median)
        }),
        ("critical_c_error_95", "95 %", digits, &|row| size(&row.critical, |e| e.high)),
        ("critical_c_error_worst", "worst", digits, &|row| size(&row.critical, |e| e.worst)),
        ("unanswered", "unanswered", Show::AsIs, &|row| Entry::Count(row.unanswered as u64)),
        ("near_cells", "near the boundary", Show::AsIs, &|row| count(&row.near, |of| of.cells)),
        ("near_wrong", "wrong", Show::AsIs, &|row| count(&row.near, |of| of.wrong)),
        ("near_undecided", "undecided", Show::AsIs, &|row| count(&row.near, |of| of.none)),
        ("anywhere_cells", "anywhere", Show::AsIs, &|row| count(&row.anywhere, |of| of.cells)),
        ("anywhere_wrong", "wrong", Show::AsIs, &|row| count(&row.anywhere, |of| of.wrong)),
        ("anywhere_undecided", "undecided", Show::AsIs, &|row| count(&row.anywhere, |of| of.none)),
        ("front_error", "front: error", Show::AsIs, &|row| yes(row.front_error)),
        ("front_labels", "front: labels", Show::AsIs, &|row| yes(row.front_labels)),
    ];
    let caption = rich(&format!(
        "Time per cell against error, on {} cells, of which {} lie within {} of the boundary in {{c}}.",
        study.cells.len(),
        study.cells.iter().filter(|cell| cell.near).count(),
        study.settings.near
    ));
    Table { notes: notes(study), ..Table::of("work-precision", caption, &study.rows, &columns) }
}

/// Explanations of the numbers.
fn notes(study: &Study) -> Vec<Rich> {
    let peers = study.rows.iter().any(|row| row.kind == ContestantKind::Peer);
    let mut notes = vec![rich(
        "Time: processor time of one thread, the least of a few passes; each cell on its own, nothing shared \
         between the cells of a column as it is in maps. Errors are against margins and critical dampings to more \
         than 20 digits. Methods that give {c^*} and no margin have the error of {c^*} times |d{m}/d{c}|/{V} there, the \
         margin of the orbit that they take for the grazing one; for methods that give verdicts alone the damping \
         at which these change was searched. Unanswered: cells without the number that the method gives elsewhere; of \
         direct those where the orbit would rise above the belt line by more than {V}/8, which it does not follow, but \
         decides. Undecided: no verdict, for whatever reason. Front: nobody else has both \
         less time and less error.",
    )];
    notes.extend(peers.then(|| {
        rich("Peers: on the same cells, by scripts/study peers; cells near the boundary only where it counted them.")
    }));
    notes
}

/// Writes `work-precision.csv`, `.tex`, `cells.csv` and the chart, of this width, into `folder`.
///
/// # Errors
/// [`ReportError::Write`], or why something could not be drawn or written.
pub fn write_study(
    study: &Study,
    folder: &Path,
    existing: Existing,
    width: Width,
) -> Result<(), ReportError> {
    let table = table(study);
    let chart = figure::work_precision::chart(study, width);
    let mut files: Vec<(PathBuf, Vec<u8>)> = vec![
        ("work-precision.csv".into(), table.csv().into_bytes()),
        ("work-precision.tex".into(), table.latex().into_bytes()),
        ("cells.csv".into(), study.cells_csv().into_bytes()),
    ];
    files.extend(write::figure_files(std::slice::from_ref(&chart), "")?);
    Ok(write_folder(folder, existing, &files)?)
}

/// A short name: "SciPy solve_ivp" with "(x1,x2), DOP853 + events" is "SciPy DOP853".
fn peer_name(peer: &str, form: &str) -> String {
    let (program, what) = peer.split_once(',').map_or((peer, ""), |(program, what)| (program, what.trim()));
    let program = program.split(' ').next().unwrap_or(program);
    let method = form.rsplit(", ").next().unwrap_or(form).split(" +").next().unwrap_or(form);
    match what {
        "" => format!("{program} {method}"),
        what => format!("{program} {method}, {what}"),
    }
}

/// The rows of a file written by `scripts/study peers`, which must be about the cells of this fingerprint.
fn read_peers(path: &Path, own: &str) -> Result<Vec<Row>, ReportError> {
    let failed = |why: String| ReportError::Peers { path: path.to_path_buf(), why };
    let text = std::fs::read_to_string(path).map_err(|error| failed(error.to_string()))?;
    const MARK: &str = "# cells sha256 ";
    if !text.lines().any(|line| line.strip_prefix(MARK).is_some_and(|cells| cells.trim() == own)) {
        return Err(failed(
            "it is about other cells; remove it, or make it anew by scripts/study peers".into(),
        ));
    }
    let mut reader = csv::ReaderBuilder::new().comment(Some(b'#')).from_reader(text.as_bytes());
    let header = reader.headers().map_err(|error| failed(error.to_string()))?.clone();
    let place = |name: &str| header.iter().position(|column| column == name);
    for needed in ["peer", "form", "tolerance", "cells", "seconds_per_cell", "max_error"] {
        if place(needed).is_none() {
            return Err(failed(format!("it has no column `{needed}`")));
        }
    }
    let mut rows = Vec::new();
    for record in reader.records() {
        let record = record.map_err(|error| failed(error.to_string()))?;
        let word = |name: &str| place(name).and_then(|column| record.get(column)).unwrap_or_default();
        let number = |name: &str| word(name).parse::<f64>().ok().filter(|number| number.is_finite());
        let count = |name: &str| word(name).parse::<usize>().ok();
        let Some(seconds) = number("seconds_per_cell").filter(|seconds| *seconds > 0.0) else {
            return Err(failed(format!("a row of {} has no time", word("peer"))));
        };
        let cells = count("cells").unwrap_or(0);
        let worst = number("max_error");
        let labels = |cells: &str, wrong: &str, none: &str| {
            let labels = Labels { cells: count(cells)?, wrong: count(wrong)?, none: count(none)? };
            (labels.cells > 0).then_some(labels)
        };
        rows.push(Row {
            kind: ContestantKind::Peer,
            name: peer_name(word("peer"), word("form")),
            setting: number("tolerance").map(|tolerance| ("tolerance".into(), tolerance)),
            cells,
            seconds,
            margin: worst.map(|worst| Errors {
                count: cells,
                median: number("median_error").unwrap_or(worst),
                high: f64::NAN,
                worst,
            }),
            critical: None,
            unanswered: count("no_answer").unwrap_or(0),
            near: labels("near_cells", "near_wrong", "near_no_answer"),
            anywhere: None,
            front_error: false,
            front_labels: false,
        });
    }
    Ok(rows)
}

//! Writing a report into a folder, and single figures into files.

use std::path::{Path, PathBuf};

use rayon::prelude::*;

use super::figure::{ChoiceError, Figure, Width, nearest_node};
use super::table::Table;
use super::view::View;
use super::{Report, ReportError, document, figure, stale, summary, tables};
use slipmap_figure::render;
use slipmap_figure::text::Rich;
use slipmap_files::{Existing, write_folder};

#[derive(Clone, Debug)]
pub struct ReportOptions {
    /// Behaviour if there is a report already.
    pub existing: Existing,
    /// Whether every figure also writes its numbers as CSV.
    pub data: bool,
    pub width: Width,
    /// The methods in the tables; all if empty.
    pub methods: Vec<String>,
    /// The eps in the tables, each the nearest of the map; all if empty.
    pub epsilons: Vec<f64>,
}

/// Writes the report of a map into `folder`. Files are made in a folder beside it first, so that an error
/// leaves nothing behind. Replacing a report replaces files of the same names and removes the figures and
/// tables of the earlier report that this one does not have; other files stay.
///
/// # Errors
/// [`ReportError::Write`], [`ReportError::Choice`] for a method or eps that the map does not have, or why something
/// could not be drawn or written.
pub fn write(
    view: &View,
    report: &Report,
    folder: &Path,
    options: &ReportOptions,
) -> Result<(), ReportError> {
    let mut tables = tables::all(view, report);
    let known = || view.map.methods().iter().map(|method| method.name());
    if let Some(name) = options.methods.iter().find(|name| known().all(|known| known != *name)) {
        return Err(ChoiceError::unknown("method", name, known()).into());
    }
    let first = &view.map.grid().axes()[0];
    let node = |epsilon: &f64| nearest_node(view, 0, *epsilon).map(|node| first.values[node]);
    let epsilons = options.epsilons.iter().map(node).collect::<Result<Vec<_>, _>>()?;
    tables.iter_mut().for_each(|table| table.keep(&options.methods, &epsilons));
    let figures = figure::all(view, report, options.width)?;
    let mut files = files(view, &summary::summary(view, report), &tables, &figures, options.width)?;
    if options.data {
        let with_data = figures.iter().filter(|figure| figure.data.rows() > 0);
        files.extend(with_data.map(|figure| {
            let path = Path::new("figures").join(format!("{}.csv", figure.name));
            (path, figure.data.csv().into_bytes())
        }));
    }
    let before = stale::listed(folder);
    write_folder(folder, options.existing, &files)?;
    stale::remove(folder, &before);
    Ok(())
}

/// The files of figures, in `folder` of the report: each in every format, drawn by all cores.
pub(super) fn figure_files(figures: &[Figure], folder: &str) -> Result<Vec<(PathBuf, Vec<u8>)>, ReportError> {
    let files: Vec<[(PathBuf, Vec<u8>); 3]> = figures
        .par_iter()
        .map(|figure| {
            let name = &figure.name;
            let svg = figure.scene.svg(name, &figure.caption);
            let (png, pdf) = render::png_and_pdf(name, &svg)?;
            let path = |ending: &str| Path::new(folder).join(format!("{name}.{ending}"));
            Ok([(path("png"), png), (path("pdf"), pdf), (path("svg"), svg.into_bytes())])
        })
        .collect::<Result<_, ReportError>>()?;
    Ok(files.into_iter().flatten().collect())
}

/// Every file of a report, by its path in the folder.
fn files(
    view: &View,
    summary: &[(Rich, Rich)],
    tables: &[Table],
    figures: &[Figure],
    width: Width,
) -> Result<Vec<(PathBuf, Vec<u8>)>, ReportError> {
    let mut files: Vec<(PathBuf, Vec<u8>)> = Vec::new();
    let mut add = |path: String, contents: Vec<u8>| files.push((PathBuf::from(path), contents));
    for table in tables {
        let mut set = table.clone();
        if width == Width::OneColumn {
            set.drop_column("long_name");
        }
        add(format!("tables/{}.tex", table.name), set.latex().into_bytes());
        add(format!("tables/{}.csv", table.name), table.csv().into_bytes());
    }
    add("report.html".into(), document::html(view, summary, tables, figures).into_bytes());
    add("report.tex".into(), document::latex(view.map, summary, tables, figures).into_bytes());
    files.extend(figure_files(figures, "figures")?);
    Ok(files)
}

//! Reports: their numbers and their pages. This file computes the maps for both.

mod numbers;
mod pages;
mod unknown;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;

use ndarray::ArrayD;
use slipmap::column::Method;
use slipmap::friction::Law;
use slipmap::map::{self, Control, Field, Grid, Plan};
use slipmap::orbits::naive::NaiveKnobs;
use slipmap::report::{Cell, Report, Table};
use slipmap::store::Pick::{Every, Node};
use slipmap::store::{MapFile, Outcome, PartialMap, Provenance};

const AXES: [&str; 6] = ["epsilon", "alpha", "beta", "gamma", "V", "c"];

/// Parameters for which the naive methods are fast.
const CHEAP: NaiveKnobs = NaiveKnobs {
    smoothing_width: 1e-2,
    stick_band_width: 1e-2,
    step: 5e-2,
    tolerance: 1e-4,
    turns: 2,
    start_pause: 0.1,
    longest_step: f64::INFINITY,
};

/// A plan with tiles so small that columns, boxes and blocks extend over several.
fn plan(nodes: [&[f64]; 6], methods: &[&str], fields: &[Field]) -> Plan {
    let grid = Grid::new(Law::Stribeck, nodes.iter().map(|values| values.to_vec()).collect()).unwrap();
    let shape: Vec<usize> = grid.shape().iter().map(|&len| len.min(2)).collect();
    // The verdicts of the naive methods do not matter here, but their cost does.
    let methods = methods.iter().map(|name| Method::by_name(name).unwrap().with_knobs(CHEAP));
    Plan::builder(grid)
        .methods(methods)
        .fields(fields.iter().copied())
        .audit_cells(3)
        // Proofs between the nodes take minutes, and have tests of their own.
        .proof_boxes(0)
        .tile_shape(shape)
        .compression(1)
        .build()
        .unwrap()
}

/// All methods but `event_step`, which would take seconds on the few cells of large divergence.
fn all_methods() -> Vec<&'static str> {
    Method::all().map(|method| method.name()).filter(|name| *name != "event_step").collect()
}

fn store_map(folder: &Path, plan: &Plan, title: &str) -> MapFile {
    let path = folder.join("map.h5");
    let provenance = Provenance {
        title: title.into(),
        config_path: "map.toml".into(),
        config_text: format!("# {title}\n"),
        command_line: "slipmap run map.toml".into(),
        git: "a commit".into(),
        threads: 1,
    };
    let writer = PartialMap::begin(&path, plan, &provenance, slipmap::files::Existing::Refuse).unwrap();
    let control = Control { threads: Some(1), ..Control::default() };
    let summary = map::run(plan, &writer, &control).unwrap();
    writer.finish(&Outcome::of(plan, &summary)).unwrap();
    MapFile::open(&path).unwrap()
}

fn gather(map: &MapFile) -> Report {
    Report::gather(map, &Control::default()).unwrap()
}

/// A small map in which every method decides something, with unequal steps on every axis; its columns are not
/// so steep that the limits in epsilon of `validated` take half a minute.
fn small(folder: &Path, methods: &[&str], fields: &[Field]) -> MapFile {
    let nodes: [&[f64]; 6] = [
        &[0.05, 0.2, 0.5],
        &[0.0, 0.3, 0.9],
        &[0.1],
        &[0.5, 1.0, 2.0],
        &[0.5, 1.0, 2.0],
        &[0.0, 0.1, 0.5, 1.0, 1.7],
    ];
    store_map(folder, &plan(nodes, methods, fields), "A small map")
}

/// The small map with every method and every field that a report reads, shared by many tests. It has no
/// limits in epsilon, which no table has, and which would take twice as long as all else.
static SMALL: LazyLock<MapFile> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    let fields: Vec<Field> = Field::ALL.into_iter().filter(|field| *field != Field::EpsilonLimit).collect();
    small(&folder, &all_methods(), &fields)
});

/// All verdicts of a method at one eps, over the other axes.
fn verdicts(map: &MapFile, method: &str, epsilon: usize) -> ArrayD<i8> {
    map.code_slice(
        &format!("verdict_{method}"),
        &[Node(epsilon), Every(1), Every(1), Every(1), Every(1), Every(1)],
    )
    .unwrap()
}

/// Every index of an array.
fn indices(shape: &[usize]) -> Vec<Vec<usize>> {
    shape.iter().fold(vec![vec![]], |all, &len| {
        all.iter().flat_map(|index| (0..len).map(move |i| [index.as_slice(), &[i]].concat())).collect()
    })
}

/// The row of a table with these words or numbers in its first columns, by the column's name.
fn row<'a>(table: &'a Table, epsilon: Option<f64>, method: &str) -> BTreeMap<&'a str, Cell> {
    let wanted = epsilon.map_or(Cell::Missing, Cell::Real);
    let found = table.rows.iter().find(|row| row[0] == wanted && row[1] == Cell::Words(method.into()));
    let found = found.unwrap_or_else(|| panic!("{}: no row {epsilon:?} {method}", table.name));
    table.columns.iter().map(|column| column.key.as_str()).zip(found.iter().cloned()).collect()
}

#[track_caller]
fn assert_close(cell: &Cell, expected: f64, relative: f64) {
    let Cell::Real(found) = *cell else { panic!("{cell:?} is not {expected}") };
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected}");
}

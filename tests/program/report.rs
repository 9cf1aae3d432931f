//! Reports: every number of a table against plain loops over the stored cells, degenerate maps, hostile
//! texts, and the command line.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::AtomicBool;

use crate::command::Scratch;
use ndarray::ArrayD;
use slipmap::friction::Law;
use slipmap::map::{self, Control, Engine, Field, Grid, Method, Plan, Verdict};
use slipmap::report::figure::{self, Plot, Width};
use slipmap::report::{self, Cell, Existing, Report, Table, tables, write};
use slipmap::simulate::critical_damping;
use slipmap::simulate::naive::NaiveKnobs;
use slipmap::store::{self, MapFile, MapWriter, Outcome, Provenance};

const AXES: [&str; 6] = ["epsilon", "alpha", "beta", "gamma", "V", "c"];

/// Choices at which the naive methods answer fast.
const CHEAP: NaiveKnobs = NaiveKnobs {
    smoothing_width: 1e-2,
    stick_band_width: 1e-2,
    step: 5e-2,
    tolerance: 1e-4,
    turns: 2,
    start_pause: 0.1,
    longest_step: f64::INFINITY,
};

/// A plan with tiles so small that columns, boxes and blocks all reach across them.
fn plan(nodes: [&[f64]; 6], methods: &[&str], fields: &[Field]) -> Plan {
    let grid = Grid::new(Law::Stribeck, nodes.iter().map(|values| values.to_vec()).collect()).unwrap();
    let shape = grid.shape().iter().map(|&len| len.min(2)).collect();
    Plan {
        tile_shape: shape,
        grid,
        // What the naive methods say matters little here, what they cost does.
        methods: methods.iter().map(|name| Method::by_name(name).unwrap().with_knobs(CHEAP)).collect(),
        fields: fields.to_vec(),
        engine: Engine::Auto,
        tolerance: 1e-9,
        audit_cells: 3,
        proof_boxes: 0,
        compression: 1,
    }
}

/// All but one, which would spend seconds on the few cells of large divergence.
fn all_methods() -> Vec<&'static str> {
    Method::all().map(|method| method.name()).filter(|name| *name != "event_step").collect()
}

fn store_map(folder: &Path, plan: &Plan, title: &str) -> MapFile {
    let path = folder.join("map.h5");
    let provenance = Provenance {
        title: title.into(),
        config_path: "map.toml".into(),
        // A fence, and one that appears when control characters are left out.
        config_text: format!("# {title}\n```\n``\u{1}``\n"),
        command_line: "slipmap run map.toml".into(),
    };
    let writer = MapWriter::create(&path, plan, &provenance, store::Existing::Refuse).unwrap();
    let control = Control { threads: Some(1), on_cells: &|_| (), stop: &AtomicBool::new(false) };
    let summary = map::compute(plan, &writer, &control).unwrap();
    let outcome = Outcome {
        threads: summary.threads,
        wall_seconds: summary.seconds,
        seconds: summary.methods.iter().map(|method| (method.method, method.seconds)).collect(),
        audit: Some(store::Audit { cells: 3, disagreements: 0 }),
        not_computed: None,
        extra: vec![],
    };
    writer.finish(&outcome).unwrap();
    MapFile::open(&path).unwrap()
}

fn gather(map: &MapFile) -> Report {
    let control = report::Control { on_cells: &|_| (), stop: &AtomicBool::new(false) };
    Report::gather(map, &control).unwrap()
}

/// A small map in which every method decides something, with unequal steps on every axis.
fn small(folder: &Path, methods: &[&str], fields: &[Field]) -> MapFile {
    let nodes: [&[f64]; 6] = [
        &[0.02, 0.05, 0.2, 0.5],
        &[0.0, 0.3, 0.9],
        &[0.1],
        &[0.5, 2.0, 3.0, 6.0],
        &[0.5, 1.0, 4.0],
        &[0.0, 0.1, 0.2, 0.5, 1.0, 1.7, 3.0],
    ];
    store_map(folder, &plan(nodes, methods, fields), "A small map")
}

/// That map with every method and every field, which many tests read.
static SMALL: LazyLock<MapFile> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("report");
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).unwrap();
    small(&folder, &all_methods(), &Field::ALL)
});

/// All verdicts of a method at one eps, over the other axes.
fn verdicts(map: &MapFile, method: &str, epsilon: usize) -> ArrayD<i8> {
    map.code_slice(&format!("verdict_{method}"), &[Some(epsilon), None, None, None, None, None]).unwrap()
}

/// Every index of an array.
fn indices(shape: &[usize]) -> Vec<Vec<usize>> {
    shape.iter().fold(vec![vec![]], |all, &len| {
        all.iter().flat_map(|index| (0..len).map(move |i| [index.as_slice(), &[i]].concat())).collect()
    })
}

/// The row of a table with these words or numbers in its first columns, by the column's name.
fn row(table: &Table, epsilon: Option<f64>, method: &str) -> BTreeMap<&'static str, Cell> {
    let wanted = epsilon.map_or(Cell::Missing, Cell::Real);
    let found = table.rows.iter().find(|row| row[0] == wanted && row[1] == Cell::Words(method.into()));
    let found = found.unwrap_or_else(|| panic!("{}: no row {epsilon:?} {method}", table.name));
    table.columns.iter().map(|column| column.key).zip(found.iter().cloned()).collect()
}

#[track_caller]
fn assert_close(cell: &Cell, expected: f64, relative: f64) {
    let Cell::Real(found) = *cell else { panic!("{cell:?} is not {expected}") };
    assert!((found - expected).abs() <= relative * expected.abs(), "{found} is not {expected}");
}

/// Sums of a few hundred positive numbers in another order.
const SUMS: f64 = 1e-12;

#[test]
fn volumes_are_those_of_the_boxes() {
    let map = &*SMALL;
    let table = tables::volume(map, &gather(map));
    let axes = map.grid().axes();
    let lengths: Vec<usize> = axes[1..].iter().map(|axis| axis.values.len()).collect();
    let steps = |axis: usize, i: usize| axes[axis + 1].values[i + 1] - axes[axis + 1].values[i];
    let extended: Vec<usize> = (0..5).filter(|&axis| lengths[axis] > 1).collect();
    let boxes: Vec<usize> = lengths.iter().map(|&len| len.max(2) - 1).collect();
    let whole: f64 =
        extended.iter().map(|&axis| (0..lengths[axis] - 1).map(|i| steps(axis, i)).sum::<f64>()).product();
    for (e, &epsilon) in axes[0].values.iter().enumerate() {
        let simulated = verdicts(map, "simulation", e);
        let measure = |method: &str| {
            let codes = verdicts(map, method, e);
            let (mut claimed, mut error, mut in_c, mut confirmed) = (0.0, 0.0, 0.0, 0.0);
            for lower in indices(&boxes) {
                let volume: f64 = extended.iter().map(|&axis| steps(axis, lower[axis])).product();
                let corners: Vec<Vec<usize>> = indices(&vec![2; extended.len()])
                    .into_iter()
                    .map(|offsets| {
                        let mut corner = lower.clone();
                        extended.iter().zip(offsets).for_each(|(&axis, offset)| corner[axis] += offset);
                        corner
                    })
                    .collect();
                let share = |inside: &dyn Fn(&Vec<usize>) -> bool| {
                    corners.iter().filter(|corner| inside(corner)).count() as f64 / corners.len() as f64
                };
                let present = |corner: &Vec<usize>| codes[corner.as_slice()] == 1;
                let claims = share(&present);
                claimed += volume * claims;
                confirmed += volume * share(&|corner| present(corner) && simulated[corner.as_slice()] == 1);
                if claims > 0.0 && claims < 1.0 {
                    error += volume * claims.max(1.0 - claims);
                }
                // A corner at the lower damping stands for half of its edge along c, as does the other.
                in_c += volume
                    * share(&|corner| {
                        let mut other = corner.clone();
                        other[4] = 2 * lower[4] + 1 - corner[4];
                        present(corner) != present(&other)
                    })
                    * 0.5;
            }
            (claimed, error, in_c, confirmed)
        };
        let reference = measure("simulation");
        for method in all_methods() {
            let (claimed, error, in_c, confirmed) = measure(method);
            let row = row(&table, Some(epsilon), method);
            assert_close(&row["volume"], claimed, SUMS);
            assert_close(&row["volume_error"], error, SUMS);
            assert_close(&row["volume_error_in_c"], in_c, SUMS);
            assert_close(&row["percent_of_box"], 100.0 * claimed / whole, SUMS);
            assert_close(&row["percent_of_simulation"], 100.0 * claimed / reference.0, SUMS);
            assert_close(&row["percent_of_simulation_confirmed"], 100.0 * confirmed / reference.0, SUMS);
            if method != "simulation" && in_c < claimed && reference.2 < reference.0 {
                let ratio = claimed / reference.0;
                let ends = [
                    (claimed + in_c) / (reference.0 - reference.2),
                    (claimed - in_c) / (reference.0 + reference.2),
                ];
                let worst = (ends[0] - ratio).max(ratio - ends[1]);
                assert_close(&row["percent_of_simulation_error"], 100.0 * worst, 1e-9);
            }
        }
    }
}

#[test]
fn the_volume_of_a_known_set_is_within_its_bounds() {
    // `perturbation` claims presence for c < gamma (1 - alpha) - 2 beta V: over gamma and c in [0, 1], with
    // alpha = beta = 0, half of the square.
    let folder = tempfile::tempdir().unwrap();
    let nodes: Vec<f64> = (0..=10).map(|i| f64::from(i) / 10.0).collect();
    let plan = plan([&[0.1], &[0.0], &[0.0], &nodes, &[1.0], &nodes], &["perturbation"], &[Field::Verdict]);
    let map = store_map(folder.path(), &plan, "A triangle");
    let report = gather(&map);
    let volume = report.verdicts.volumes[0][0];
    assert!((volume.claimed - 0.5).abs() <= volume.error, "{volume:?}");
    assert!(volume.error < 0.2 && volume.error_in_c > 0.0, "{volume:?}");
    assert_eq!((report.verdicts.box_volume, report.verdicts.dimensions), (1.0, 2));
}

#[test]
fn agreement_counts_every_cell_once() {
    let map = &*SMALL;
    let table = tables::agreement(map, &gather(map));
    let epsilons = &map.grid().axes()[0].values;
    for method in all_methods() {
        let mut sums: BTreeMap<&str, u64> = BTreeMap::new();
        for (e, &epsilon) in epsilons.iter().enumerate() {
            let (codes, simulated) = (verdicts(map, method, e), verdicts(map, "simulation", e));
            let mut counts: BTreeMap<&str, u64> = BTreeMap::new();
            for (&code, &simulated) in codes.iter().zip(&simulated) {
                let name = match code {
                    1 => "present",
                    -1 => "absent",
                    0 => "undecided",
                    _ => "failed",
                };
                *counts.entry(name).or_default() += 1;
                match (code, simulated) {
                    (1, -1) => *counts.entry("wrong_presence").or_default() += 1,
                    (-1, 1) => *counts.entry("wrong_absence").or_default() += 1,
                    (_, 1 | -1) => {}
                    _ => *counts.entry("not_compared").or_default() += 1,
                }
            }
            let total = codes.len() as f64;
            check_counts(&row(&table, Some(epsilon), method), &counts, total);
            counts.into_iter().for_each(|(name, count)| *sums.entry(name).or_default() += count);
        }
        check_counts(&row(&table, None, method), &sums, map.grid().cells() as f64);
    }
    // The map is one on which the first-order test is wrong somewhere.
    assert_ne!(row(&table, None, "perturbation")["wrong_presence"], Cell::Count(0));
}

fn check_counts(row: &BTreeMap<&str, Cell>, counts: &BTreeMap<&str, u64>, total: f64) {
    let count = |name: &str| counts.get(name).copied().unwrap_or(0);
    for name in
        ["present", "absent", "undecided", "failed", "wrong_presence", "wrong_absence", "not_compared"]
    {
        assert_eq!(row[name], Cell::Count(count(name)), "{name} in {row:?}");
    }
    let decided = (count("present") + count("absent")) as f64;
    assert_close(&row["percent_decided"], 100.0 * decided / total, SUMS);
}

/// A column, a method's boundary, the exact one, and the size of the divergence there.
type Pair = (Vec<usize>, Option<f64>, Option<f64>, f64);

/// Half a bin of the histogram of errors.
const BIN: f64 = 1.0 / 2048.0;

#[test]
fn boundary_errors_and_orders_are_those_of_the_columns() {
    let usual: Vec<&str> = Method::usual().map(|method| method.name()).collect();
    let folder = tempfile::tempdir().unwrap();
    let bare = small(folder.path(), &usual, &[Field::Verdict]);
    for (map, stored) in [(&bare, false), (&*SMALL, true)] {
        let report = gather(map);
        assert_eq!(report.boundaries.stored, stored);
        let (table, orders) = (tables::boundary(map, &report), tables::order(map, &report));
        let axes = map.grid().axes();
        let shape: Vec<usize> = axes[1..5].iter().map(|axis| axis.values.len()).collect();
        for method in map.methods().iter().map(|method| method.name.as_str()) {
            // The simulation is what the others are measured against; the naive methods know no boundary.
            let Some(Method::Test(test)) = Method::by_name(method) else {
                assert!(table.rows.iter().all(|row| row[1] != Cell::Words(method.into())), "{method}");
                continue;
            };
            // Boundaries at each eps and column, c >= 0 or none.
            let legal = |c: f64| Some(c).filter(|c| *c >= 0.0 && c.is_finite());
            let pairs: Vec<Vec<Pair>> = (0..axes[0].values.len())
                .map(|e| {
                    indices(&shape)
                        .into_iter()
                        .map(|index| {
                            let at = [&[e], index.as_slice(), &[0]].concat();
                            let column = map.grid().column(&at);
                            let exact = critical_damping(&column, 1e-12).ok().and_then(|root| legal(root.c));
                            let range = column.curve.weakening_range(0.0, column.belt_speed);
                            let size = range.lo.abs().max(range.hi.abs()) / column.epsilon;
                            (index, legal((test.claim)(&column).present_below), exact, size)
                        })
                        .collect()
                })
                .collect();
            let mut medians = Vec::new();
            for (e, &epsilon) in axes[0].values.iter().enumerate() {
                let row = row(&table, Some(epsilon), method);
                let both: Vec<(&Vec<usize>, f64, f64)> = pairs[e]
                    .iter()
                    .filter_map(|(index, edge, exact, size)| Some((index, (*edge)? - (*exact)?, *size)))
                    .collect();
                let count = |a: bool, b: bool| {
                    let has = |p: &&Pair| (p.1.is_some(), p.2.is_some()) == (a, b);
                    Cell::Count(pairs[e].iter().filter(has).count() as u64)
                };
                assert_eq!(row["columns"], count(true, true));
                assert_eq!(row["only_exact"], count(false, true));
                assert_eq!(row["only_method"], count(true, false));
                let mut sizes: Vec<f64> = both.iter().map(|(_, error, _)| error.abs()).collect();
                sizes.sort_by(f64::total_cmp);
                if sizes.is_empty() {
                    assert_eq!(row["median_error"], Cell::Missing);
                    continue;
                }
                // The stored exact boundary is good to the map's tolerance, this one to far less.
                let slack =
                    if stored { 1e-9 } else { 1e-11 } * pairs[e].iter().map(|p| p.3).fold(0.0, f64::max);
                for (key, q) in [("median_error", 0.5), ("percentile_95_error", 0.95)] {
                    let exact = sizes[((q * sizes.len() as f64).ceil() as usize).max(1) - 1];
                    let Cell::Real(found) = row[key] else { panic!("{row:?}") };
                    assert!(
                        (found - exact).abs() <= BIN * exact + slack,
                        "{key} {method} {epsilon}: {found} {exact}"
                    );
                }
                let worst = both.iter().max_by(|a, b| a.1.abs().total_cmp(&b.1.abs())).unwrap();
                let Cell::Real(found) = row["worst_error"] else { panic!("{row:?}") };
                assert!((found - worst.1).abs() <= slack, "{method} {epsilon}: {found} {}", worst.1);
                for (axis, name) in [(0, "alpha"), (1, "beta"), (2, "gamma"), (3, "V")] {
                    // Errors that differ by less than the slack may trade places.
                    let unique =
                        both.iter().filter(|b| worst.1.abs() - b.1.abs() <= 2.0 * slack).count() == 1;
                    assert!(!unique || row[name] == Cell::Real(axes[axis + 1].values[worst.0[axis]]));
                }
                let beyond = |tolerance: f64| {
                    let many = both.iter().filter(|(_, error, size)| *error > tolerance * size).count();
                    100.0 * many as f64 / both.len() as f64
                };
                let Cell::Real(found) = row["percent_beyond"] else { panic!("{row:?}") };
                let limits = if stored { (0.0, 2e-9) } else { (0.0, 2e-11) };
                assert!(
                    (beyond(limits.1)..=beyond(limits.0)).contains(&found),
                    "{method} {epsilon}: {found}"
                );
                // Medians over the columns that count at every eps, where they exceed the error of c*.
                let mut common: Vec<f64> = both
                    .iter()
                    .filter(|(index, _, _)| {
                        let counts = |p: &Pair| p.0 == **index && p.1.is_some() && p.2.is_some();
                        pairs.iter().all(|layer| layer.iter().any(counts))
                    })
                    .map(|(_, error, _)| error.abs())
                    .collect();
                common.sort_by(f64::total_cmp);
                if !common.is_empty() {
                    medians.push((epsilon.ln(), common[common.len().div_ceil(2) - 1].ln()));
                }
            }
            let found = orders.rows.iter().find(|row| row[0] == Cell::Words(method.into())).unwrap();
            // Distances below the error of c* itself (those of the proved bounds) have no order.
            if medians.len() < 2 || medians.iter().all(|(_, error)| error.exp() < 1e-9) {
                assert_eq!(found[1], Cell::Missing);
                continue;
            }
            // The slope from the normal equations in another form. Each median is off by half a bin at most,
            // which changes the slope by at most that times sum |x - mean| / sum (x - mean)^2.
            let n = medians.len() as f64;
            let (sx, sy) = medians.iter().fold((0.0, 0.0), |(sx, sy), (x, y)| (sx + x, sy + y));
            let sxy: f64 = medians.iter().map(|(x, y)| x * y).sum();
            let sxx: f64 = medians.iter().map(|(x, _)| x * x).sum();
            let slope = (n * sxy - sx * sy) / (n * sxx - sx * sx);
            let spread: f64 = medians.iter().map(|(x, _)| (x - sx / n).abs()).sum();
            let Cell::Real(order) = found[1] else { panic!("{found:?}") };
            assert!(
                (order - slope).abs() <= 1.5 * BIN * spread / (sxx - sx * sx / n),
                "{method}: {order} {slope}"
            );
            assert_eq!(found[4], Cell::Count(medians.len() as u64));
            // The half width from the residuals; medians off by half a bin move it by at most t/sqrt(sxx)
            // times that, the norm of n residuals growing by at most sqrt(n/(n - 2)) of a bin.
            let centred = sxx - sx * sx / n;
            let residual: f64 =
                medians.iter().map(|(x, y)| (y - sy / n - slope * (x - sx / n)).powi(2)).sum::<f64>();
            // Student's t for 95 % and n - 2 degrees of freedom.
            let t = [f64::NAN, f64::NAN, f64::NAN, 12.706, 4.303][medians.len()];
            match &found[2] {
                Cell::Real(half_width) => {
                    let expected = t * (residual / (n - 2.0) / centred).sqrt();
                    let slack = 1.5 * BIN * t * (n / (n - 2.0) / centred).sqrt();
                    assert!((half_width - expected).abs() <= slack, "{method}: {half_width} {expected}");
                }
                other => assert!(medians.len() == 2 && *other == Cell::Missing, "{found:?}"),
            }
        }
    }
}

#[test]
fn orders_in_epsilon_are_those_of_the_theory() {
    // c* - c(perturbation) is O(eps), c* - c(instability) O(eps^2), c* - c(harmonic balance) O(eps^4).
    let folder = tempfile::tempdir().unwrap();
    let epsilons = [0.01, 0.02, 0.04];
    let nodes: [&[f64]; 6] = [&epsilons, &[0.1, 0.4], &[0.05], &[1.0, 2.0], &[0.8, 1.2], &[0.0, 1.0]];
    let plan = plan(nodes, &["perturbation", "instability", "harmonic_balance"], &[Field::Verdict]);
    let report = gather(&store_map(folder.path(), &plan, "Orders"));
    for (method, expected) in report.boundaries.methods.iter().zip([1.0, 2.0, 4.0]) {
        let order = method.order.unwrap();
        // The next term of the series is smaller by a factor of about k = eps gamma V <= 0.1, and it changes
        // the slope over the fitted octaves by less than that.
        assert!((order.order - expected).abs() < 0.1 * expected.max(1.0), "{}: {order:?}", method.method);
        assert!((order.smallest - expected).abs() < 0.1 * expected.max(1.0), "{}: {order:?}", method.method);
        assert!(order.half_width.is_some());
    }
}

#[test]
fn cost_failures_and_provenance_come_from_the_attributes() {
    let map = &*SMALL;
    let report = gather(map);
    for row in tables::cost(map).rows {
        let Cell::Words(method) = &row[0] else { panic!("{row:?}") };
        let seconds = map.number(&format!("seconds_{method}")).unwrap();
        assert_eq!(row[1], Cell::Count(map.grid().cells() as u64));
        assert_eq!(row[2], Cell::Real(seconds));
        if seconds > 0.0 {
            assert_close(&row[3], map.grid().cells() as f64 / seconds, SUMS);
        }
    }
    let failures = tables::failures(map, &report);
    let entry =
        |what: &str| failures.rows.iter().find(|row| row[0] == Cell::Words(what.into())).unwrap()[1].clone();
    assert_eq!(entry("audit: cells decided again by the direct engine"), Cell::Count(3));
    assert_eq!(entry("audit: verdicts contradicted"), Cell::Count(0));
    for method in all_methods() {
        let codes = map.codes(&format!("verdict_{method}"), &map.grid().shape().map_ranges()).unwrap();
        let failed = codes.iter().filter(|code| **code == Verdict::Failed.code()).count() as u64;
        assert_eq!(entry(&format!("{method}: cells failed")), Cell::Count(failed));
    }
    let provenance = tables::provenance(map);
    for (what, attribute) in [("title", "title"), ("sources", "git"), ("machine", "machine")] {
        let value = map.text(attribute).unwrap();
        assert!(provenance.rows.contains(&vec![Cell::Words(what.into()), Cell::Words(value.into())]));
    }
    let axes = tables::axes(map);
    assert_eq!(axes.rows.len(), AXES.len());
    assert_eq!(axes.rows[3][2..5], [Cell::Count(4), Cell::Real(0.5), Cell::Real(6.0)]);
}

/// Whole ranges of a shape.
trait MapRanges {
    fn map_ranges(&self) -> Vec<std::ops::Range<usize>>;
}

impl MapRanges for Vec<usize> {
    fn map_ranges(&self) -> Vec<std::ops::Range<usize>> {
        self.iter().map(|&len| 0..len).collect()
    }
}

/// Whether a text is well-formed XML with words that can be read.
fn check_svg(svg: &str) {
    roxmltree::Document::parse(svg).unwrap();
    assert!(svg.contains("<text") && !svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    assert!(!svg.contains("href") && !svg.contains("<script"), "nothing from elsewhere");
}

/// What a map lacks, its axes and its methods.
type Case<'a> = (&'a str, [&'a [f64]; 6], &'a [&'a str]);

#[test]
fn degenerate_maps_have_reports() {
    let cases: [Case; 7] = [
        ("one cell", [&[0.1], &[0.3], &[0.1], &[2.0], &[1.0], &[0.5]], &["perturbation", "simulation"]),
        (
            "one eps",
            [&[0.1], &[0.0, 0.5], &[0.1], &[1.0, 2.0], &[1.0], &[0.0, 0.5, 1.0]],
            &["symmetric", "simulation"],
        ),
        (
            "one c",
            [&[0.1, 0.2], &[0.0, 0.5], &[0.1], &[1.0, 2.0], &[1.0], &[0.0]],
            &["symmetric", "simulation"],
        ),
        ("no simulation", [&[0.1], &[0.0, 0.5], &[0.1], &[1.0], &[1.0], &[0.0, 1.0]], &["instability"]),
        (
            "no cycles",
            [&[0.1, 0.3], &[1.0], &[0.1], &[1.0, 2.0], &[1.0], &[0.0, 1.0]],
            &["bendixson", "simulation"],
        ),
        (
            "decides nothing",
            [&[0.1], &[0.9], &[0.5], &[1.0, 2.0], &[1.0, 2.0], &[1.0, 2.0]],
            &["instability", "simulation"],
        ),
        (
            "eps alone",
            [&[0.1, 0.2, 0.3], &[0.1], &[0.1], &[1.0], &[1.0], &[0.1]],
            &["harmonic_balance", "simulation"],
        ),
    ];
    for (what, nodes, methods) in cases {
        let folder = tempfile::tempdir().unwrap();
        let map = store_map(folder.path(), &plan(nodes, methods, &[Field::Verdict, Field::Regime]), what);
        let report = gather(&map);
        for figure in figure::all(&map, &report).unwrap() {
            for (width, scene) in &figure.scenes {
                assert!(
                    scene.height > 50.0 && scene.height < 1200.0,
                    "{what}: {} is {} high",
                    figure.name,
                    scene.height
                );
                check_svg(&scene.svg(width.name(), &figure.caption));
            }
        }
        for table in tables::all(&map, &report) {
            assert!(table.rows.iter().all(|row| row.len() == table.columns.len()), "{what}: {}", table.name);
            for text in [table.markdown(), table.latex(), table.html(), table.csv()] {
                assert!(!text.contains("NaN") && !text.contains("inf"), "{what}: {text}");
            }
        }
        let volume = report.verdicts.volumes[0][0];
        assert!(volume.claimed >= 0.0 && volume.error >= 0.0, "{what}: {volume:?}");
    }
}

#[test]
fn failed_cells_are_counted_and_drawn() {
    // A sink between the engine and the file that breaks every verdict.
    struct Broken<'a>(&'a MapWriter);
    impl map::Sink for Broken<'_> {
        type Packed = <MapWriter as map::Sink>::Packed;
        type Error = <MapWriter as map::Sink>::Error;
        fn pack(&self, data: &map::TileData) -> Result<Self::Packed, Self::Error> {
            let mut data = data.clone();
            for method in &mut data.methods {
                method.verdicts.fill(Verdict::Failed.code());
            }
            self.0.pack(&data)
        }
        fn write(&self, packed: Self::Packed, account: &slipmap::map::Account) -> Result<(), Self::Error> {
            self.0.write(packed, account)
        }
    }
    let folder = tempfile::tempdir().unwrap();
    let plan = plan(
        [&[0.1], &[0.0, 0.5], &[0.1], &[1.0, 2.0], &[1.0], &[0.0, 1.0]],
        &["symmetric", "simulation"],
        &[Field::Verdict],
    );
    let path = folder.path().join("map.h5");
    let writer = MapWriter::create(&path, &plan, &Provenance::default(), store::Existing::Refuse).unwrap();
    let control = Control { threads: Some(1), on_cells: &|_| (), stop: &AtomicBool::new(false) };
    map::compute(&plan, &Broken(&writer), &control).unwrap();
    writer.finish(&Outcome::default()).unwrap();
    let map = MapFile::open(&path).unwrap();
    let report = gather(&map);
    let table = tables::agreement(&map, &report);
    let row = row(&table, Some(0.1), "symmetric");
    assert_eq!(row["failed"], Cell::Count(8));
    assert_eq!(row["not_compared"], Cell::Count(8));
    for figure in figure::all(&map, &report).unwrap() {
        check_svg(&figure.scenes[0].1.svg("failed", &figure.caption));
    }
}

#[test]
fn hostile_texts_stay_texts() {
    let folder = tempfile::tempdir().unwrap();
    let title =
        "</title><script>alert(1)</script> \\input{x} $\\alpha$ | [a](javascript:b) & \"q\" %\u{1}\nnext 中";
    let nodes: [&[f64]; 6] = [&[0.1], &[0.3], &[0.1], &[1.0, 2.0], &[1.0], &[0.0, 0.5]];
    let map = store_map(folder.path(), &plan(nodes, &["symmetric", "simulation"], &[Field::Verdict]), title);
    let out = folder.path().join("out");
    write(&map, &gather(&map), &out, Existing::Refuse).unwrap();
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap();
    let html = read("report.html");
    assert!(
        !html.contains("<script") && html.matches("</title>").count() == 1 + html.matches("<svg").count()
    );
    assert!(html.contains("&lt;script&gt;"));
    let latex = read("report.tex") + &read("tables/provenance.tex");
    assert!(
        !latex.contains("\\input{x}")
            && latex.contains("\\textbackslash{}input\\{x\\} \\$\\textbackslash{}alpha\\$")
    );
    assert!(latex.contains("[U+4E2D]"));
    // In Markdown nothing acts outside of the configuration, which holds the title and a fence of its own;
    // a line that could end the fence around it (at least as many backticks and nothing else) comes last.
    let markdown = read("report.md");
    let (before, config) = markdown.split_once("\n`````toml\n").unwrap();
    assert!(!before.contains("<script") && !before.contains("[a](java"), "{before}");
    let lines: Vec<&str> = config.trim_end().lines().collect();
    let ends = |line: &&str| {
        let text = line.trim();
        text.len() >= 5 && text.bytes().all(|b| b == b'`')
    };
    assert_eq!(lines.iter().position(ends), Some(lines.len() - 1), "{config}");
    assert!(config.contains("<script"), "the configuration is shown as it is");
    let csv = read("tables/provenance.csv");
    let mut records = csv::Reader::from_reader(csv.as_bytes());
    let first = records.records().next().unwrap().unwrap();
    let tame: String = title.chars().map(|c| if c.is_control() { ' ' } else { c }).collect();
    assert_eq!(&first[1], tame, "CSV keeps texts as they are, but for control characters");
}

#[test]
fn plots_say_what_they_hold_and_refuse_what_is_not_there() {
    let map = &*SMALL;
    let at = [("V".to_owned(), 3.0), ("epsilon".to_owned(), 0.06)];
    let variables: Vec<&str> = map.variables().collect();
    for variable in &variables {
        for (x, y) in [("gamma", "alpha"), ("alpha", "gamma"), ("beta", "gamma")] {
            let plot =
                Plot { x, y, at: &at, variable: Some(variable), curves: false, width: Width::OneColumn };
            let plotted = figure::plot(map, &plot).unwrap();
            check_svg(&plotted.scene.svg("plot", &plotted.caption));
            let held = |axis: &str| plotted.held.iter().find(|held| held.axis == axis).map(|held| held.used);
            assert_eq!((held("V"), held("epsilon")), (Some(4.0), Some(0.05)));
            assert_eq!(held("c").is_none(), variable.starts_with("critical_c_"));
            assert!(plotted.caption.plain().contains("V = 4"), "{}", plotted.caption.plain());
        }
    }
    let refused = |x: &str, y: &str, at: &[(String, f64)], variable: Option<&str>| {
        let plot = Plot { x, y, at, variable, curves: false, width: Width::TwoColumns };
        figure::plot(map, &plot).unwrap_err().to_string()
    };
    assert!(refused("gama", "c", &[], None).contains("the nearest is `gamma`"));
    assert!(refused("gamma", "c", &[("bet".into(), 1.0)], None).contains("`beta`"));
    assert!(refused("gamma", "c", &[], Some("verdict_simulatoin")).contains("`verdict_simulation`"));
    assert!(refused("c", "c", &[], None).contains("different axes"));
    assert!(refused("gamma", "c", &[("c".into(), 1.0)], None).contains("shown"));
    assert!(refused("gamma", "c", &[], Some("critical_c_symmetric")).contains("does not vary along `c`"));
    assert!(refused("gamma", "c", &[("V".into(), f64::NAN)], None).contains("finite"));
}

#[test]
fn slices_show_the_stored_cells() {
    // Every cell of a plotted verdict is a node's: the areas of the page add up to the nodes' cells.
    let map = &*SMALL;
    let plot = Plot {
        x: "gamma",
        y: "c",
        at: &[("epsilon".into(), 0.5)],
        variable: None,
        curves: false,
        width: Width::OneColumn,
    };
    let svg = {
        let plotted = figure::plot(map, &plot).unwrap();
        plotted.scene.svg("plot", &plotted.caption)
    };
    let codes =
        map.code_slice("verdict_simulation", &[Some(3), Some(1), Some(0), None, Some(1), None]).unwrap();
    for (fill, code) in [("#0072b2", 1), ("#f7e3bf", -1)] {
        let shown = svg.contains(&format!("fill-rule=\"evenodd\" fill=\"{fill}\""));
        assert_eq!(shown, codes.iter().any(|c| *c == code), "{fill}");
    }
}

#[test]
fn the_commands_write_everything_or_nothing() {
    let scratch = Scratch::new();
    drop(store_map(
        scratch.path(),
        &plan(
            [&[0.1], &[0.3], &[0.1], &[1.0, 2.0, 3.0], &[1.0], &[0.0, 0.5, 1.0]],
            &["symmetric", "simulation"],
            &[Field::Verdict],
        ),
        "Commands",
    ));
    let run = scratch.run(&["report", "map.h5"]).ends_with(0);
    assert_eq!(run.out.trim(), "map-report/report.md");
    assert_eq!(run.err, "");
    assert_eq!(scratch.names(), ["map-report", "map.h5"]);
    let made = |folder: &str, ending: &str| {
        let entries = std::fs::read_dir(scratch.path().join("map-report").join(folder)).unwrap();
        entries.filter(|e| e.as_ref().unwrap().path().extension().is_some_and(|e| e == ending)).count()
    };
    assert_eq!(made("tables", "tex"), made("tables", "csv"));
    assert!(made("figures", "svg") >= 10);
    assert_eq!(
        (made("figures", "svg"), made("figures", "svg")),
        (made("figures", "pdf"), made("figures", "png"))
    );
    // Every file that the Markdown names is there.
    let markdown = scratch.read("map-report/report.md");
    let links: Vec<&str> = markdown.split("](").skip(1).filter_map(|rest| rest.split(')').next()).collect();
    assert!(links.len() > 20);
    for link in links {
        assert!(scratch.path().join("map-report").join(link).is_file(), "{link}");
    }
    scratch.run(&["report", "map.h5"]).refuses(&["map-report", "exists already", "--overwrite"]);
    scratch.file("map-report/mine.txt", "kept");
    scratch.run(&["report", "map.h5", "--overwrite"]).ends_with(0);
    assert_eq!(scratch.read("map-report/mine.txt"), "kept");
    scratch.run(&["report", "nothing.h5"]).refuses(&["nothing.h5"]);
    scratch.file("text.h5", "no map");
    scratch.run(&["report", "text.h5"]).refuses(&["not a map", "slipmap run"]);

    let plot = |rest: &[&str]| scratch.run(&[&["plot", "map.h5", "--x", "gamma", "--y", "c"], rest].concat());
    let run = plot(&["--out", "slice.svg", "--at", "V=1.2"]).ends_with(0);
    assert!(run.err.contains("V = 1 (the node nearest to 1.2)"), "{}", run.err);
    assert!(run.err.contains("alpha = 0.3 (the middle node)"), "{}", run.err);
    assert!(scratch.read("slice.svg").contains("<text"), "text stays text");
    plot(&["--out", "slice.svg"]).refuses(&["slice.svg", "--overwrite"]);
    plot(&["--out", "slice.png", "--columns", "2"]).ends_with(0);
    plot(&["--out", "slice.jpg"]).refuses(&[".svg, .pdf or .png"]);
    plot(&["--out", "a.svg", "--at", "V"]).refuses(&["gamma=2.0"]);
    plot(&["--out", "a.svg", "--variable", "verdict_symetric"]).refuses(&["`verdict_symmetric`"]);
    scratch.run(&["plot", "map.h5", "--x", "gamm", "--y", "c", "--out", "a.svg"]).refuses(&["`gamma`"]);
    assert!(
        !scratch.names().iter().any(|name| name.starts_with('.') || name == "a.svg"),
        "{:?}",
        scratch.names()
    );

    let point = [
        "probe",
        "--epsilon",
        "0.1",
        "--alpha",
        "0.3",
        "--beta",
        "0.1",
        "--gamma",
        "2",
        "--V",
        "1",
        "--c",
        "0.5",
    ];
    scratch.run(&[&point[..], &["--figure", "point.svg"]].concat()).ends_with(0);
    let svg = scratch.read("point.svg");
    assert!(svg.contains("sticking segment") && svg.contains("landing"), "{svg}");
    scratch.run(&[&point[..], &["--figure", "point.svg"]].concat()).refuses(&["point.svg", "--overwrite"]);
}

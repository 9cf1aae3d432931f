//! Verdicts and regimes that maps interpolate between columns, compared with those of each column's own
//! critical damping and backbone, and with the direct engine.

use slipmap::column::{Method, Regime, Verdict, critical_damping};
use slipmap::filippov::Oscillator;
use slipmap::friction::{Law, Table};
use slipmap::map::{Account, Control, Each, Field, Grid, Plan, Queue, TileData, unravel};
use slipmap::orbits::flow;
use std::collections::HashSet;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::sample::{Random, formula};

/// How the cells of a map are decided.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum How {
    /// As in maps, perhaps between columns.
    Between,
    /// Column by column.
    Alone,
    /// Cell by cell, by the direct engine.
    Direct,
}

fn computed(grid: &Grid, how: How, audited: usize) -> (Vec<(Verdict, Regime)>, Account) {
    of_fields(grid, how, audited, &[Field::Regime])
}

/// The verdicts in the cells of a grid.
pub fn verdicts(grid: &Grid, how: How) -> (Vec<Verdict>, Account) {
    let (cells, account) = of_fields(grid, how, 0, &[]);
    (cells.into_iter().map(|(verdict, _)| verdict).collect(), account)
}

fn of_fields(grid: &Grid, how: How, audited: usize, fields: &[Field]) -> (Vec<(Verdict, Regime)>, Account) {
    let method = if how == How::Direct { Method::Direct } else { Method::Simulation };
    let mut tile = grid.shape();
    if how == How::Alone {
        // A tile of one column is not interpolated.
        let last = tile.len() - 1;
        tile[..last].fill(1);
    }
    let plan = Plan::builder(grid.clone()).methods([method]).fields(fields.iter().copied());
    let plan = plan.audit_cells(audited).tile_shape(tile).build().unwrap();
    let (tiles, queue) = (Mutex::new(Vec::new()), Queue::new(plan.tile_count(), HashSet::new()));
    let sink = Each(|data: &TileData| {
        let regimes = data.regime.values().chain(std::iter::repeat(Regime::Failed));
        let cells: Vec<_> = data.methods[0].verdicts.values().zip(regimes).collect();
        tiles.lock().unwrap().push((data.tile.number, cells));
    });
    let (account, _) =
        slipmap::map::compute_tiles(&plan, &sink, &Control::default(), &|| queue.take()).unwrap();
    let mut tiles = tiles.into_inner().unwrap();
    tiles.sort_by_key(|(number, _)| *number);
    (tiles.into_iter().flat_map(|(_, cells)| cells).collect(), account)
}

fn nodes(from: f64, to: f64, points: usize) -> Vec<f64> {
    (0..points).map(|i| from + (to - from) * (i as f64 + 0.5) / points as f64).collect()
}

/// Grids with several regimes: planes of single cells, and columns with two dampings.
fn grids() -> Vec<(&'static str, Grid)> {
    let rows: Vec<(f64, f64)> =
        (0..40).map(|i| 0.25 * f64::from(i)).map(|u| (u, 0.5 + 0.5 * (-0.5 * u).exp())).collect();
    let rough = rows
        .iter()
        .enumerate()
        .map(|(i, &(u, phi))| (u, phi + if i > 0 { 0.002 * (7.0 * u * u).sin() } else { 0.0 }));
    let table = |rows: &[(f64, f64)]| Law::Table(Table::new("rows", rows, 1.0).unwrap());
    let exponential = "mu + (1 - mu)*exp(-u/vs)";
    let one = |value: f64| vec![value];
    let (n, belts) = (32, nodes(0.2, 3.0, 32));
    let grid = |name, law, axes| (name, Grid::new(law, axes).unwrap());
    vec![
        grid(
            "formula",
            formula(exponential),
            vec![one(1.0), nodes(0.1, 1.0, n), one(0.5), belts.clone(), one(0.1)],
        ),
        grid(
            "ridge",
            formula("1 - (0.1 + 0.2*exp(-((p - 0.37)/0.02)^2))*(1 - exp(-u))"),
            vec![one(0.5), nodes(0.0, 1.0, 128), nodes(0.5, 1.5, 16), vec![0.25, 0.3]],
        ),
        grid(
            "crossing",
            formula(exponential),
            vec![one(1.0), one(0.2), nodes(0.3, 2.0, n), nodes(1.0, 6.0, n), one(0.02)],
        ),
        grid(
            "lorentzian",
            Law::Lorentzian,
            vec![one(1.0), nodes(0.1, 1.0, n), one(0.5), one(0.0), nodes(0.2, 2.0, n), one(0.1)],
        ),
        grid(
            "wave",
            formula("1 - 0.3*tanh(u/0.5) + 0.02*sin(k*u)"),
            vec![one(0.5), nodes(1.0, 4.0, 24), nodes(0.2, 1.5, 24), one(0.05)],
        ),
        grid("table", table(&rows), vec![nodes(0.1, 1.0, n), belts.clone(), one(0.1)]),
        grid("rough table", table(&rough.collect::<Vec<_>>()), vec![nodes(0.1, 1.0, n), belts, one(0.1)]),
        grid(
            "box",
            formula(exponential),
            vec![one(1.0), nodes(0.1, 0.9, 8), nodes(0.3, 1.0, 8), nodes(0.2, 2.0, 8), vec![0.1, 0.3]],
        ),
        grid(
            "pushed far out",
            formula("0.6 + 0.4*exp(-u) - p*(1 + tanh((u - 300)/20))"),
            vec![one(1.0), nodes(0.25, 0.45, 24), nodes(0.5, 3.0, 12), one(0.0002)],
        ),
        grid(
            "crossing at the smaller damping",
            formula(exponential),
            vec![one(1.0), nodes(-0.9, 0.3, n), one(0.5), nodes(0.5, 4.0, n), vec![0.02, 0.3]],
        ),
    ]
}

#[test]
fn interpolated_cells_are_those_of_their_own_columns() {
    for (name, grid) in grids() {
        let (found, account) = computed(&grid, How::Between, 20);
        let (wanted, _) = computed(&grid, How::Alone, 0);
        let paths = &account.paths;
        assert_eq!(found.len(), wanted.len());
        for (cell, pair) in found.iter().zip(&wanted).enumerate() {
            assert_eq!(pair.0, pair.1, "{name}: cell {cell}, {paths:?}");
        }
        assert!(account.audit.disagreements.is_empty(), "{name}: {:?}", account.audit);
        // Few cells are left to their own columns.
        if ["formula", "lorentzian", "table"].contains(&name) {
            assert!(2 * account.paths.interpolation as usize > grid.cells(), "{name}: {paths:?}");
        }
    }
}

/// A law that changes within less than the distance of the nodes: its columns refuse the interpolant.
/// Columns that differ in eps alone share their computed cycles, unless the law contains eps.
#[test]
fn columns_with_shared_cycles_have_regimes_of_points() {
    let wave = || formula("1 - 0.3*tanh(u/0.5) + 0.02*sin(3*u)");
    let laws = [
        (Law::Stribeck, vec![vec![0.3, 0.5], vec![0.1], vec![2.0]]),
        (Law::Exponential, vec![vec![0.3, 0.5], vec![0.5], vec![0.0]]),
        (wave(), vec![]),
        (wave().read_as_small(), vec![]),
    ];
    for (law, own) in laws {
        let mut axes = vec![vec![0.2, 0.4, 0.9]];
        axes.extend(own);
        axes.extend([vec![0.3, 1.1, 2.3], vec![0.05, 0.2, 0.7]]);
        let grid = Grid::new(law.clone(), axes).unwrap();
        let (found, _) = computed(&grid, How::Alone, 0);
        let mut seen = Vec::new();
        for (cell, &(_, regime)) in found.iter().enumerate() {
            let point = grid.point(&unravel(cell, &grid.shape()));
            let oscillator = Oscillator::new(&law, &point);
            let alone = slipmap::column::regime(&oscillator, &flow(&oscillator, 1e-9));
            assert_eq!(regime, alone, "{law:?} {point:?}");
            if !seen.contains(&regime) {
                seen.push(regime);
            }
        }
        assert!(seen.len() > 1, "{law:?}: one regime everywhere shows little");
    }
}

/// Laws whose orbits pass a narrow feature on a part of the axis, with its slip speed and its width.
fn laws_with_a_narrow_feature() -> Vec<(Law, [f64; 2])> {
    let mut laws = Vec::new();
    let mut random = Random(46);
    for number in 0..12 {
        let [level, scale, at] =
            [0.3 + 0.5 * random.unit(), 0.2 + 0.8 * random.unit(), 0.6 + 2.0 * random.unit()];
        let [width, height] = [-3.0, -2.5].map(|least| 10_f64.powf(least + 1.5 * random.unit()));
        let (width, height) = (width * at, if number % 3 == 0 { -height } else { height });
        let phi = |u: f64| level + (1.0 - level) * (-u / scale).exp();
        let law = if number % 2 == 0 {
            let smooth = (0..24).map(|i| 0.5 * f64::from(i)).filter(|u| (u - at).abs() > 1.5 * width);
            let outlier =
                [(at - width, 0.0), (at, height), (at + width, 0.0)].map(|(u, off)| (u, phi(u) + off));
            let mut rows: Vec<(f64, f64)> = smooth.map(|u| (u, phi(u))).chain(outlier).collect();
            rows.sort_by(|one, other| one.0.total_cmp(&other.0));
            Law::Table(Table::new("rows", &rows, 1.0).unwrap())
        } else {
            let feature = |u: &str| match number % 4 {
                1 => format!("exp(-(({u} - {at})/{width})^2)"),
                _ => format!("tanh(({u} - {at})/{width})"),
            };
            let smooth = format!("{level} + (1 - {level})*exp(-u/{scale})");
            formula(&format!("{smooth} + ({height})*({} - {})", feature("u"), feature("0")))
        };
        laws.push((law, [at, width]));
    }
    laws
}

/// The maps of `scripts/study outliers` in small; the first has been wrong in two of its cells.
#[test]
fn narrow_features_keep_the_cells_of_their_columns() {
    let speeds = [0.0, 0.3, 0.6, 0.990508400709, 1.0, 1.00949159929, 1.5, 2.5, 4.0];
    let friction = [
        1.0,
        0.819524654438,
        0.720477684765,
        0.655171567866,
        0.674134113295,
        0.653116167177,
        0.619914827347,
        0.6026951788,
        0.600134185051,
    ];
    let rows: Vec<(f64, f64)> = speeds.into_iter().zip(friction).collect();
    let ends =
        |from: f64, to: f64| (0..100).map(|i| from + (to - from) * f64::from(i) / 99.0).collect::<Vec<_>>();
    let first = Law::Table(Table::new("an outlier", &rows, 1.0).unwrap());
    let mut maps = vec![(first, ends(0.3811, 0.5811), vec![0.33353363])];
    for (law, [at, width]) in laws_with_a_narrow_feature() {
        // Twice the belt speed passes the feature.
        let belts = ends(0.42 * at, 0.62 * at);
        let own = |belt: f64| critical_damping(&law.column(&law.point(1.0, &[], belt, 0.0).unwrap()), 1e-9);
        let Ok(critical) = own(0.5 * (at + 0.5 * width)) else { continue };
        if critical.c > 0.0 {
            maps.push((law, belts, vec![0.998 * critical.c, 1.002 * critical.c]));
        }
    }
    let mut interpolated = 0;
    for (number, (law, belts, dampings)) in maps.iter().enumerate() {
        let grid = Grid::new(law.clone(), vec![vec![1.0], belts.clone(), dampings.clone()]).unwrap();
        let (found, account) = verdicts(&grid, How::Between);
        let (wanted, _) = verdicts(&grid, How::Alone);
        assert_eq!(found, wanted, "map {number}: {law:?} {dampings:?}");
        interpolated += account.paths.interpolation;
    }
    assert!(interpolated > 500, "{interpolated}");
}

#[test]
fn a_sudden_change_of_the_law_is_not_interpolated_over() {
    let law = formula("1 - (0.1 + 0.3/(1 + exp((s - 0.5)*2000)))*(1 - exp(-u))");
    let grid = Grid::new(law, vec![vec![0.5], nodes(0.0, 1.0, 32), nodes(0.5, 1.5, 32), vec![0.25]]).unwrap();
    let (found, _) = computed(&grid, How::Between, 0);
    let (wanted, _) = computed(&grid, How::Alone, 0);
    assert_eq!(found, wanted);
    let [present, absent] = [Verdict::Present, Verdict::Absent]
        .map(|verdict| found.iter().filter(|(found, _)| *found == verdict).count());
    assert!(present > 200 && absent > 200, "{present} {absent}");
}

/// Where one worker panics the others end with the tile that they are at.
#[test]
fn a_panic_of_a_worker_ends_all() {
    let nodes = [vec![0.1], vec![0.4], vec![0.2], vec![2.0], nodes(0.5, 2.0, 400), vec![0.5]];
    let plan = Plan::builder(Grid::new(Law::Stribeck, nodes.to_vec()).unwrap()).methods([Method::Simulation]);
    let plan = plan.tile_shape([1; 6]).audit_cells(0).build().unwrap();
    let (done, queue) = (AtomicUsize::new(0), Queue::new(plan.tile_count(), HashSet::new()));
    let sink = Each(|data: &TileData| {
        assert!(data.tile.number > 0, "the first tile");
        std::thread::sleep(std::time::Duration::from_millis(5));
        done.fetch_add(1, Ordering::Relaxed);
    });
    let control = Control { threads: Some(2), ..Control::default() };
    let compute = || slipmap::map::compute_tiles(&plan, &sink, &control, &|| queue.take());
    assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(compute)).is_err());
    assert!(done.load(Ordering::Relaxed) < 100, "{done:?} of {}", plan.tile_count());
}

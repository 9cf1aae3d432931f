//! Compares every number of a table with plain loops over the stored cells.

use std::collections::BTreeMap;

use super::{AXES, SMALL, all_methods, assert_close, gather, indices, plan, row, small, store_map, verdicts};
use slipmap::column::{Method, Verdict, critical_damping};
use slipmap::map::Field;
use slipmap::report::{Cell, Table, View, tables};

/// Relative error of sums of a few hundred positive numbers in another order.
const SUMS: f64 = 1e-12;

#[test]
fn volumes_are_those_of_the_boxes() {
    let map = &*SMALL;
    let table = tables::volume(&View::new(map), &gather(map));
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
                // Each of the two corners of an edge along c represents half of the edge.
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
            assert_close(&row["percent_of_box_error"], 100.0 * error / whole, SUMS);
            assert_close(&row["percent_of_box_error_in_c"], 100.0 * in_c / whole, SUMS);
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
    // The first-order test is wrong somewhere on this map.
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

/// The rows of a method in the table of orders, from logarithms of eps and of the medians.
fn orders_are_those_of(orders: &Table, method: &str, medians: &[(f64, f64)]) {
    let found: Vec<_> = orders.rows.iter().filter(|row| row[0] == Cell::Words(method.into())).collect();
    // Distances below the error of c* itself (those of the proved bounds) have no order.
    if medians.len() < 2 || medians.iter().all(|(_, error)| error.exp() < 1e-9) {
        assert!(found.len() == 1 && found[0][3] == Cell::Missing, "{found:?}");
        return;
    }
    assert_eq!(found.len(), medians.len() - 1);
    for (row, pair) in found.iter().zip(medians.windows(2)) {
        let step = pair[1].0 - pair[0].0;
        let exponent = (pair[1].1 - pair[0].1) / step;
        // Each of the two medians is off by half a bin at most.
        let slack = 3.0 * BIN / step;
        match (&row[3], &row[4]) {
            (Cell::Real(order), Cell::Real(error)) => {
                assert!((order - exponent).abs() <= slack && *error <= 0.1, "{method}: {row:?} {pair:?}");
            }
            (Cell::Missing, Cell::Real(error)) => assert!(*error > 0.1, "{method}: {row:?}"),
            (Cell::Missing, Cell::Missing) => {
                assert!(matches!(row[5], Cell::Words(_)), "{method}: {row:?}")
            }
            _ => panic!("{method}: {row:?}"),
        }
    }
}

#[test]
fn boundary_errors_and_orders_are_those_of_the_columns() {
    let usual: Vec<&str> = Method::usual().map(|method| method.name()).collect();
    let folder = tempfile::tempdir().unwrap();
    let bare = small(folder.path(), &usual, &[Field::Verdict]);
    for (map, stored) in [(&bare, false), (&*SMALL, true)] {
        let report = gather(map);
        assert_eq!(report.boundaries.stored, stored);
        let (table, orders) = (tables::boundary(&View::new(map), &report), tables::order(&report));
        let axes = map.grid().axes();
        let shape: Vec<usize> = axes[1..5].iter().map(|axis| axis.values.len()).collect();
        for method in map.methods().iter().map(|method| method.name()) {
            // The simulation is the reference for the others; the naive methods have no boundary.
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
                            let column = map.grid().column(&at).unwrap();
                            let exact = critical_damping(&column, 1e-12).ok().and_then(|root| legal(root.c));
                            let range = column.curve.weakening_range(0.0, column.belt_speed);
                            let size = range.lo.abs().max(range.hi.abs()) / column.epsilon;
                            (index, legal(test.claim(&column).present_below), exact, size)
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
                // The stored exact boundary is accurate to the map's tolerance, this one far more.
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
            orders_are_those_of(&orders, method, &medians);
        }
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
    let ranges: Vec<_> = map.grid().shape().into_iter().map(|len| 0..len).collect();
    for method in all_methods() {
        let codes = map.codes(&format!("verdict_{method}"), &ranges).unwrap();
        let failed = codes.iter().filter(|code| **code == Verdict::Failed.code()).count() as u64;
        let what = Cell::Words(format!("{method}: cells failed"));
        let row = failures.rows.iter().find(|row| row[0] == what);
        assert_eq!(row.map(|row| row[1].clone()), (failed > 0).then_some(Cell::Count(failed)));
    }
    let provenance = tables::provenance(map);
    for (what, attribute) in [("title", "title"), ("sources", "git"), ("machine", "machine")] {
        let value = map.text(attribute).unwrap();
        assert!(provenance.rows.contains(&vec![Cell::Words(what.into()), Cell::Words(value.into())]));
    }
    let axes = tables::axes(&View::new(map));
    assert_eq!(axes.rows.len(), AXES.len());
    assert_eq!(axes.rows[3][2..5], [Cell::Count(3), Cell::Real(0.5), Cell::Real(2.0)]);
}

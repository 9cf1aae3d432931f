//! `slipmap run` and `slipmap check`: maps that are computed, refused, interrupted and damaged.

use std::ops::Range;
use std::path::Path;
use std::time::{Duration, Instant};

use crate::command::{Run, Says, Scratch, signal};
use crate::proofs::written_again;
use serde_json::Value;
use slipmap::column::{Method, critical_damping};
use slipmap::map::Grid;
use slipmap::store::MapFile;

/// A small map across the boundary of existence.
const SMALL: &str = "\
title = \"small\" # a comment to keep
[grid]
epsilon = [0.05, 0.2]
alpha = { from = 0.0, to = 0.8, points = 5 }
beta = [0.0, 0.2]
gamma = { from = 0.5, to = 8.0, points = 5, spacing = \"log\" }
V = [0.5, 2.0]
c = { from = 0.0, to = 3.0, points = 13 }
[audit]
cells = 50
[output]
path = \"maps/small.h5\"
fields = [\"verdict\", \"margin\", \"critical_c\", \"regime\", \"landing\"]
";
const CELLS: u64 = 2 * 5 * 2 * 5 * 2 * 13;

fn scratch() -> Scratch {
    let scratch = Scratch::new();
    scratch.file("small.toml", SMALL);
    scratch
}

/// What `probe` answers about a point of a map.
fn probed(scratch: &Scratch, grid: &Grid, index: &[usize]) -> Value {
    let axes = grid.axes().iter().zip(index);
    let options = axes.map(|(axis, &i)| format!(" --{} {:?}", axis.name, axis.values[i]));
    scratch.json(&format!("probe{}", options.collect::<String>()))
}

/// Every cell of a map: its index, and as ranges.
fn cells(grid: &Grid) -> impl Iterator<Item = (Vec<usize>, Vec<Range<usize>>)> {
    let tiles = (0..grid.cells()).map(|number| grid.tile(&[1; 6], number).ranges);
    tiles.map(|cell| (cell.iter().map(|range| range.start).collect(), cell))
}

fn maps(scratch: &Scratch) -> Vec<String> {
    let entries = std::fs::read_dir(scratch.path().join("maps")).unwrap();
    entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
}

#[test]
fn a_run_makes_a_sound_map_and_accounts_for_every_cell() {
    let scratch = scratch();
    let run = scratch.run("run small.toml --json --set title=renamed").ends_with(0);
    assert_eq!(run.err, "", "no progress bar without a terminal");
    let summary = run.json();
    assert_eq!(summary["title"], "renamed");
    assert_eq!(summary["output"], "maps/small.h5");
    assert_eq!(summary["cells"], CELLS);
    assert_eq!(summary["columns"], CELLS / 13);
    let methods = summary["methods"].as_object().unwrap();
    assert_eq!(methods.len(), Method::usual().count());
    for (name, method) in methods {
        let count = |verdict: &str| method[verdict].as_u64().unwrap();
        assert_eq!(count("cells"), CELLS, "{name}");
        let verdicts = ["present", "absent", "undecided", "failed", "not_computed"];
        assert_eq!(verdicts.into_iter().map(count).sum::<u64>(), CELLS, "{name}");
    }
    // The grid lies across the boundary, so both verdicts occur.
    assert!(methods["simulation"]["present"].as_u64() > Some(0));
    assert!(methods["simulation"]["absent"].as_u64() > Some(0));
    let paths: u64 =
        summary["paths"].as_object().unwrap().values().map(|cells| cells.as_u64().unwrap()).sum();
    assert_eq!(paths, CELLS, "every simulated cell was decided on some path");
    // Fifty draws; cells that are drawn twice count once.
    let audited = summary["audit"]["cells"].as_u64().unwrap();
    assert!((40..=50).contains(&audited), "{audited} cells are audited");
    assert_eq!(summary["audit"]["disagreements"], Value::Array(Vec::new()));
    assert_eq!(maps(&scratch), ["small.h5"], "no temporary file stays");
    assert_eq!(summary["bytes"], std::fs::metadata(scratch.path().join("maps/small.h5")).unwrap().len());

    let map = MapFile::open(&scratch.path().join("maps/small.h5")).unwrap();
    assert_eq!(map.text("title"), Some("renamed"));
    let config = map.text("config").unwrap();
    config.says(&["title = \"renamed\" # a comment to keep"]);
    let default = [("compression", 2.0), ("tolerance", 1e-9)];
    assert_eq!(default.map(|(name, _)| (name, map.number(name).unwrap())), default);
    assert!(map.text("history").unwrap().ends_with(": slipmap run small.toml --json --set title=renamed"));
    for (name, method) in methods {
        let stored = map.counts(&format!("verdict_{name}")).unwrap();
        let told = ["absent", "undecided", "present", "failed", "not_computed"];
        assert_eq!(stored, told.map(|verdict| method[verdict].as_u64().unwrap()), "{name}");
    }

    scratch.run("check maps/small.h5").ends_with(0).out.says(&["2,600 cells", "sound"]);
    // The configuration in the map is the job that made it.
    scratch.file("again.toml", config);
    let again = scratch.run("run again.toml --resume").ends_with(0);
    again.err.says(&["is complete already"]);
}

#[test]
fn the_table_of_a_run_names_every_method() {
    let scratch = scratch();
    let run = scratch.run("run small.toml --quiet --threads 1").ends_with(0);
    assert_eq!(run.err, "");
    run.out.says(&[
        "small: maps/small.h5",
        "2,600 cells in 200 columns",
        "on 1 thread",
        "present",
        "undecided",
        "perturbation",
        "simulation",
        "simulation decided by:",
        "cells decided again by the direct engine",
        "0 contradicted",
    ]);
}

#[test]
fn the_fields_of_a_map_are_the_answers_of_probe() {
    let scratch = scratch();
    scratch.run("run small.toml").ends_with(0);
    let map = MapFile::open(&scratch.path().join("maps/small.h5")).unwrap();
    let grid = map.grid();
    let shape = grid.shape();
    // A few cells on a diagonal through the grid.
    for i in 0..13 {
        let index: Vec<usize> = shape.iter().map(|&len| i * len / 13).collect();
        let cell: Vec<_> = index.iter().map(|&i| i..i + 1).collect();
        let point = grid.point(&index);
        let answer = probed(&scratch, grid, &index);
        let code = |variable: &str| map.codes(variable, &cell).unwrap().iter().copied().next().unwrap();
        let real = |variable: &str| map.reals(variable, &cell).unwrap().iter().copied().next().unwrap();
        for method in map.methods() {
            let name = method.name();
            let verdict = ["absent", "undecided", "present", "failed", "not_computed"]
                [usize::try_from(code(&format!("verdict_{name}")) + 1).unwrap()];
            assert_eq!(answer["methods"][name]["verdict"], verdict, "{name} at {point:?}");
            let margin = real(&format!("margin_{name}"));
            match answer["methods"][name]["margin"].as_f64() {
                // Both come from the same arithmetic, except for the simulation: its lanes may take another
                // rung of the ladder, and then both are within their tolerances.
                Some(probed) => {
                    assert!((margin - probed).abs() <= 2e-9, "{name}: {margin} and {probed} at {point:?}")
                }
                None => assert!(!margin.is_finite(), "{name}: {margin} at {point:?}"),
            }
        }
        let regimes = slipmap::column::Regime::ALL.map(slipmap::column::Regime::name);
        assert_eq!(answer["regime"], regimes[usize::try_from(code("regime")).unwrap()]);
        match answer["landing"]["x1"].as_f64() {
            Some(x1) => assert_eq!(real("landing_x1"), x1),
            None => assert!(real("landing_x1").is_nan()),
        }
    }
}

#[test]
fn the_cycles_basins_and_limits_of_a_map_are_those_of_probe() {
    let scratch = scratch();
    // At epsilon = 0.4, c = 0.3 both states attract; on the fast belt at c = 0 orbits cross for ever.
    let fields = "output.fields=['landing','cycle','basin','epsilon_limit','sensitivity','regime']";
    let law = "--set grid.alpha=0.2 --set grid.beta=0.001 --set grid.gamma=2.0";
    let axes = "--set grid.epsilon=[0.1,0.4] --set grid.V=[1.0,16.0] --set grid.c=[0.0,0.3,2.0]";
    let methods = "methods.run=['perturbation','bendixson','simulation']";
    scratch.run(&format!("run small.toml --set {fields} --set {methods} {law} {axes}")).ends_with(0);
    let map = MapFile::open(&scratch.path().join("maps/small.h5")).unwrap();
    let grid = map.grid();
    let mut met = [0; 6];
    for (index, cell) in cells(grid) {
        let answer = probed(&scratch, grid, &index);
        let regime = map.codes("regime", &cell).unwrap().iter().copied().next().unwrap();
        met[usize::try_from(regime).unwrap()] += 1;
        let same = |variable: &str, probed: Option<f64>| {
            let stored = map.reals(variable, &cell).unwrap().iter().copied().next().unwrap();
            match probed {
                Some(probed) => assert_eq!(stored, probed, "{variable} at {:?}", grid.point(&index)),
                None => assert!(stored.is_nan(), "{variable} at {:?}", grid.point(&index)),
            }
        };
        let half = |range: &Value| Some(0.5 * (range["to"].as_f64()? - range["from"].as_f64()?));
        let cycle = &answer["attracting_cycle"];
        same("crossings", answer["landing"]["crossings"].as_f64());
        same("cycle_period", cycle["period"].as_f64());
        same("cycle_amplitude_x1", half(&cycle["x1"]));
        same("cycle_amplitude_x2", half(&cycle["x2"]));
        same("cycle_multiplier", cycle["multiplier"].as_f64());
        let basin = &answer["basin_boundary"];
        same("boundary_velocity", basin["cycle"]["x2"]["to"].as_f64());
        same("boundary_multiplier", basin["cycle"]["multiplier"].as_f64());
        same("kick_forward", basin["kick"]["forward"].as_f64());
        same("kick_backward", basin["kick"]["backward"].as_f64());
        for axis in ["epsilon", "alpha", "beta", "gamma", "V"] {
            same(&format!("dc_d{axis}"), answer["sensitivity"]["derivatives"][axis]["value"].as_f64());
        }
        for method in map.methods() {
            let limit = &answer["methods"][method.name()]["epsilon_limit"];
            let limit = if *limit == "inf" { Some(f64::INFINITY) } else { limit.as_f64() };
            same(&format!("epsilon_limit_{}", method.name()), limit);
        }
    }
    // Steady slip, stick-slip, both, and crossing for ever all occur.
    assert!([0, 1, 2, 4].iter().all(|&regime| met[regime] > 0), "{met:?}");
}

/// The margin of the simulation is the distance to the critical damping, of nodes and far past the belt line too.
#[test]
fn the_margin_of_a_map_is_the_distance_to_its_critical_damping() {
    let scratch = scratch();
    let law = "--set grid.alpha=0.3 --set grid.beta=0.1 --set grid.gamma=[1.0,2.0,4.0,40.0]";
    let axes = "--set grid.epsilon=1.0 --set grid.V=[0.3,1.0,3.0] --set grid.c=[0.0,0.2,0.4,1.0,2.0,5.0]";
    let what = "--set output.fields=['margin'] --set methods.run=['simulation','direct'] --set audit.cells=0";
    for tolerance in [1e-9, 1e-2] {
        let how = format!("--set simulation.tolerance={tolerance}");
        scratch.run(&format!("run small.toml --overwrite {law} {axes} {what} {how}")).ends_with(0);
        let map = MapFile::open(&scratch.path().join("maps/small.h5")).unwrap();
        let grid = map.grid();
        for (index, cell) in cells(grid) {
            let real = |name: &str| map.reals(name, &cell).unwrap().iter().copied().next().unwrap();
            let code = |name: &str| map.codes(name, &cell).unwrap().iter().copied().next().unwrap();
            let point = grid.point(&index);
            let found = critical_damping(&grid.law().column(&point), 1e-12).unwrap();
            let (stored, expected) = (real("margin_simulation"), found.c - point.damping);
            // With a coarse tolerance it is not told, where its error is above 1 %.
            let is_told = !stored.is_nan() || tolerance > 1e-3;
            assert!(
                is_told && !((stored - expected).abs() > 10.0 * tolerance),
                "{stored} {expected} at {point:?}"
            );
            assert!(real("margin_direct").is_nan());
            // The orbits of both methods return below it, and need not stick.
            let verdicts = ["simulation", "direct"].map(|method| code(&format!("verdict_{method}")));
            assert!(verdicts[0] == verdicts[1] && (expected > 0.0 || verdicts[0] == -1), "{point:?}");
        }
    }
}

#[test]
fn an_existing_map_is_kept_without_overwrite() {
    let scratch = scratch();
    let small = ["run", "small.toml", "--set", "output.fields=[\"verdict\"]"];
    scratch.run(&small).ends_with(0);
    let path = scratch.path().join("maps/small.h5");
    let before = std::fs::read(&path).unwrap();
    scratch.run("run small.toml").refuses(&["maps/small.h5 exists already", "--overwrite", "output.path"]);
    let dry = scratch.run("run small.toml --dry-run").ends_with(0);
    dry.err.says(&["would be refused: maps/small.h5 exists already"]);
    assert_eq!(std::fs::read(&path).unwrap(), before);
    let run = scratch.run("run small.toml --overwrite").ends_with(0);
    run.err.says(&["maps/small.h5", "will be replaced"]);
    assert_ne!(std::fs::read(&path).unwrap(), before);
    assert_eq!(maps(&scratch), ["small.h5"]);
}

#[test]
fn a_dry_run_estimates_the_size_and_writes_nothing() {
    let scratch = scratch();
    let told = scratch.json("run small.toml --dry-run");
    assert_eq!(told["cells"], CELLS);
    assert_eq!(told["columns"], CELLS / 13);
    assert_eq!(told["axes"]["alpha"], 5);
    // Verdicts of one byte, margins and four numbers of the landing of eight, one regime, and a critical
    // damping for each method and column, with the errors of one of them.
    let methods = Method::usual().count() as u64;
    assert_eq!(told["bytes"], CELLS * (methods + 8 * methods + 8 * 4 + 1) + 8 * (methods + 1) * CELLS / 13);
    assert!(told["seconds"].as_f64().unwrap() > 0.0);
    assert!(told["free_bytes"].as_u64().unwrap() > 0);
    // The whole of so small a map is the sample.
    assert_eq!(told["at_most"], false);
    let packed = told["packed_bytes"].as_u64().unwrap();
    assert_eq!(told["peak_bytes"], 2 * packed, "the journal and the map");
    assert_eq!(told["would_be_refused"], false);
    let proves = "--set methods.run=[\"validated\"] --set output.fields=[\"verdict\"]";
    let proves = scratch.json(&format!("run small.toml --dry-run {proves}"));
    assert!(proves["beside"]["proof"].as_str().unwrap().starts_with("at most "), "{proves}");
    let text = scratch.run("run small.toml --dry-run").ends_with(0).out;
    text.says(&["nothing is written", "2,600 in 200 columns"]);
    assert_eq!(scratch.names(), ["small.toml"]);
    let told = scratch.json("run small.toml --dry-run --set curves.planes=[{x=\"gamma\",y=\"c\"}]");
    assert_eq!(
        told["beside"]["curves"],
        "in 1 plane, of each kind at most 2,000 points and 8.8e7 right-hand sides"
    );
    // The estimate includes the bytes beside the cells, which matter most in a small file.
    scratch.run("run small.toml").ends_with(0);
    let size = std::fs::metadata(scratch.path().join("maps/small.h5")).unwrap().len();
    assert!(packed < 2 * size && size < 2 * packed, "told {packed} B, true {size} B");
}

#[test]
fn a_dry_run_estimates_for_any_machine() {
    let scratch = scratch();
    let threads = 64 * std::thread::available_parallelism().unwrap().get();
    let dry = format!("run small.toml --threads {threads} --dry-run");
    assert_eq!(scratch.json(&dry)["threads"], threads);
    scratch.run(&dry).ends_with(0).out.says(&[" cores for the cells"]);
    assert_eq!(scratch.names(), ["small.toml"]);
}

#[test]
fn methods_can_be_left_out() {
    let scratch = scratch();
    let sets = "--set methods.run=[\"symmetric\",\"perturbation\"] --set output.fields=[\"verdict\"]";
    let methods = &scratch.json(&format!("run small.toml {sets}"))["methods"];
    assert_eq!(methods.as_object().unwrap().keys().collect::<Vec<_>>(), ["perturbation", "symmetric"]);
    scratch.run("check maps/small.h5").ends_with(0);
}

#[test]
fn check_distinguishes_sound_damaged_and_foreign_files() {
    let scratch = scratch();
    scratch.run("run small.toml").ends_with(0);
    let mut bytes = std::fs::read(scratch.path().join("maps/small.h5")).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 0x10;
    scratch.file("damaged.h5", &bytes);
    let check = scratch.run("check damaged.h5 --json");
    // A flipped bit may also hit the file's signature.
    assert!(check.code == 1 || check.code == 2, "{check:?}");
    if check.code == 1 {
        let report = check.json();
        assert_eq!(report["sound"], false);
        assert!(!report["problems"].as_array().unwrap().is_empty());
    }
    scratch.run("check small.toml").refuses(&["small.toml cannot be read as a map", "help: "]);
    scratch.run("check none.h5").refuses(&["none.h5: there is no such file", "help: "]);
    scratch.run("check maps").refuses(&["maps: this is a folder", "help: "]);
}

#[test]
fn the_shipped_configurations_are_legal() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    for (name, dimensions) in [("quickstart", 6), ("paper", 6)] {
        let scratch = Scratch::new();
        let file = folder.join(format!("{name}.toml"));
        let told = scratch.json(&["run", file.to_str().unwrap(), "--dry-run"]);
        assert_eq!(told["axes"].as_object().unwrap().len(), dimensions);
        assert_eq!(told["output"], format!("results/{name}.h5"));
        assert!(scratch.names().is_empty());
    }
}

#[test]
fn usage_errors_and_help() {
    let scratch = scratch();
    scratch.run("run").refuses(&["CONFIG.toml"]);
    scratch.run("fly").refuses(&["fly"]);
    scratch.run("run small.toml --threads 0").refuses(&["--threads"]);
    for command in ["run", "probe", "check"] {
        scratch.run(&[command, "--help"]).ends_with(0).out.says(&[&format!("slipmap {command}"), "Example"]);
    }
    let version = scratch.run("--version").ends_with(0).out;
    assert!(version.starts_with(&format!("slipmap {} (git ", env!("CARGO_PKG_VERSION"))), "{version}");
    assert_eq!(scratch.names(), ["small.toml"]);
}

#[test]
fn an_interrupted_table_leaves_nothing_behind() {
    let scratch = Scratch::new();
    let row = |i: usize| format!("0.5,0.1,0.1,{},{},0.1\n", 2.0 + i as f64 * 1e-4, 0.5 + i as f64 * 1e-4);
    let rows = "epsilon,alpha,beta,gamma,V,c\n".to_owned() + &(0..100_000).map(row).collect::<String>();
    scratch.file("in.csv", rows);
    let child = scratch.start("probe --points in.csv --out out.csv");
    let start = Instant::now();
    while scratch.names().len() < 2 {
        assert!(start.elapsed() < Duration::from_secs(60), "the table was never begun");
        std::thread::sleep(Duration::from_millis(10));
    }
    signal(&child, "-INT");
    Run::after(child).ends_with(130);
    assert_eq!(scratch.names(), ["in.csv"]);
}

#[test]
fn proofs_between_the_nodes_are_printed_stored_and_reported() {
    let scratch = scratch();
    let run = |boxes: &str| {
        let proof = if boxes == "0" { "title=none" } else { "validated.proof=proof.json" };
        let narrow = "--set grid.epsilon=0.05 --set grid.alpha=0.3 --set grid.beta=0.1 --set grid.gamma=[1.0,1.1] \
                      --set grid.V=[0.5,0.6] --set output.fields=[\"verdict\"]";
        let methods =
            format!("--set methods.run=[\"validated\"] --set validated.boxes={boxes} --set {proof}");
        scratch.json(&format!("run small.toml --overwrite {narrow} {methods}"))["proved"].clone()
    };
    let share = |proved: &Value, name: &str| proved[name].as_f64().unwrap();
    assert_eq!(run("0"), Value::Null);
    let (few, more) = (run("1"), run("8"));
    assert!(share(&more, "undecided_at_most") < share(&few, "undecided_at_most"), "{few} {more}");
    let sum: f64 = ["present", "absent", "undecided_at_most"].iter().map(|name| share(&more, name)).sum();
    assert!((sum - 1.0).abs() < 1e-12, "{more}");
    // On the grid the method decides nearly all cells; between the nodes its verdicts must agree.
    assert!(share(&more, "present") > 0.1 && share(&more, "absent") > 0.1, "{more}");

    let map = MapFile::open(&scratch.path().join("maps/small.h5")).unwrap();
    for name in ["present", "absent", "undecided_at_most"] {
        assert_eq!(map.number(&format!("proved_{name}")), Some(share(&more, name)));
    }
    scratch.run("check maps/small.h5").ends_with(0);

    let proof = scratch.json("check --proof proof.json");
    assert!(proof["boxes"].as_u64().unwrap() >= 2 && proof["sound"] == true, "{proof}");
    let text = scratch.read("proof.json");
    // Written again by another program: keys in another order, spaces, integers with decimal points.
    scratch.file("again.json", written_again(&text));
    let again = scratch.run("check --proof again.json").ends_with(0);
    again.out.says(&["sound: orbits are proved again to cross every curve one way"]);
    // A larger claim, and a cut elsewhere.
    let mut large: Value = serde_json::from_str(&text).unwrap();
    let mut cut = large.clone();
    large["parts"][0]["absent"] = (share(&more, "absent") + 1e-3).into();
    cut["parts"][0]["proof"]["cut"]["at"] = 100.0.into();
    for (wrong, problem) in [(large, "the share absent"), (cut, "a cut does not divide its box")] {
        scratch.file("wrong.json", wrong.to_string());
        scratch.run("check --proof wrong.json").ends_with(1).out.says(&[problem]);
    }
    scratch.file("cut.json", &text[..text.len() / 2]);
    let run = scratch.run("check --proof cut.json").ends_with(2);
    run.err.says(&["cut.json: is not a proof: ", "help: name a certificate"]);

    scratch.run("report maps/small.h5 --out report").ends_with(0);
    let table = std::fs::read_to_string(scratch.path().join("report/tables/proved_volume.csv")).unwrap();
    // Rounded so that it remains a bound, by less than the undecided share.
    let told = table.lines().find_map(|line| line.strip_prefix("present at least,")).unwrap();
    let below = 100.0 * share(&more, "present") - told.parse::<f64>().unwrap();
    assert!((0.0..=100.0 * share(&more, "undecided_at_most")).contains(&below), "{table} {more}");
}

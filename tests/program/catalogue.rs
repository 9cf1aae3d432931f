//! `slipmap failures`, and the catalogues in `results`, of which every line is run again.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use crate::command::{Says, Scratch};
use serde_json::Value;
use slipmap::column::Method;

type Row = BTreeMap<String, String>;

fn rows(path: &Path) -> Vec<Row> {
    csv::Reader::from_path(path).unwrap().into_deserialize().map(Result::unwrap).collect()
}

fn repository(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

/// The stored catalogues: the paper's law, and steep friction with and without a drop.
const STORED: [&str; 2] = ["results/failures", "results/failures-steep"];

/// Runs the `slipmap probe` line of each class, those of several classes once, and checks that the failures
/// are there.
fn reproduce(scratch: &Scratch, classes: &[Row]) {
    let mut answers: BTreeMap<&str, Value> = BTreeMap::new();
    for class in classes {
        let line = class["probe"].as_str();
        let answer =
            answers.entry(line).or_insert_with(|| scratch.json(line.strip_prefix("slipmap ").unwrap()));
        has_failure(class, answer);
    }
}

/// Checks that the failure of a class is in the answer about its point.
fn has_failure(class: &Row, answer: &Value) {
    let line = &class["probe"];
    let verdict = |method: &str| answer["methods"][method]["verdict"].as_str().unwrap().to_owned();
    let (said, simulated) = (verdict(&class["method"]), verdict("simulation"));
    let direct = answer["flow"]["direct"]["verdict"].as_str().unwrap();
    assert_eq!(simulated, direct, "the engines agree: {line}");
    let expected = match class["failure"].as_str() {
        "wrong_presence" => ("present", Some("absent")),
        "wrong_absence" => ("absent", Some("present")),
        "undecided" => ("undecided", None),
        "failed" => ("failed", None),
        other => panic!("{other}"),
    };
    assert_eq!(said, expected.0, "{line}");
    match expected.1 {
        Some(truth) => assert_eq!(simulated, truth, "{line}"),
        None => assert!(["present", "absent"].contains(&simulated.as_str()), "{line}"),
    }
    // Some mechanisms are visible in the answer itself.
    let fate = &answer["flow"]["direct"]["fate"];
    match class["mechanism"].as_str() {
        "overshoot" => assert_eq!(fate, "crosses_forever", "{line}"),
        "landing_unproved" => assert!(fate == "sticks" || fate == "crosses_forever", "{line}"),
        // The same test at finite eps decides otherwise.
        "first_order_in_eps" => {
            let finite = if class["method"] == "perturbation" { "harmonic_balance" } else { "bendixson" };
            assert_ne!(verdict(finite), said, "{line}");
        }
        _ => {}
    }
}

#[test]
fn the_stored_catalogue_is_true_line_by_line() {
    let scratch = Scratch::new();
    let classes = STORED.map(|folder| rows(&repository(&format!("{folder}/classes.csv")))).concat();
    reproduce(&scratch, &classes);
    // Each mechanism named in the theory (theory, "Where methods fail") makes one of these methods fail.
    let met: BTreeSet<&str> = classes.iter().map(|class| class["mechanism"].as_str()).collect();
    for mechanism in
        ["missed_double_crossing", "tangent_start", "first_order_in_eps", "overshoot", "node", "smoothing"]
    {
        assert!(met.contains(mechanism), "{met:?}");
    }
}

#[test]
fn the_stored_tables_fit_together() {
    STORED.into_iter().for_each(tables_fit_together);
}

fn tables_fit_together(folder: &str) {
    let [methods, classes] =
        ["methods", "classes"].map(|name| rows(&repository(&format!("{folder}/{name}.csv"))));
    let names: Vec<&str> = methods.iter().map(|row| row["method"].as_str()).collect();
    // The catalogue's configuration leaves out the proved verdicts; the direct engine is its judge.
    let listed =
        Method::all().map(|method| method.name()).filter(|name| !["validated", "direct"].contains(name));
    assert_eq!(names, listed.collect::<Vec<_>>());
    let number = |text: &String| text.parse::<u64>().unwrap();
    for method in &methods {
        let mut failures = 0;
        for kind in ["wrong_presence", "wrong_absence", "undecided", "failed"] {
            let of_kind =
                classes.iter().filter(|row| row["method"] == method["method"] && row["failure"] == kind);
            let cells: u64 = of_kind.map(|row| number(&row["cells"])).sum();
            assert_eq!(cells, number(&method[kind]), "{} {kind}", method["method"]);
            failures += cells;
        }
        assert_eq!(number(&method["cells"]), number(&method["right"]) + failures, "{}", method["method"]);
        // A theorem is never wrong.
        if method["guarantee"] == "finite_epsilon" || method["guarantee"] == "numerical" {
            assert_eq!((&method["wrong_presence"][..], &method["wrong_absence"][..]), ("0", "0"));
        }
    }
    let text = std::fs::read_to_string(repository(&format!("{folder}/failures.md"))).unwrap();
    for class in &classes {
        assert!(text.contains(&class["probe"]), "{}", class["probe"]);
    }
}

/// A small grid on which several methods fail.
const SMALL: &str = "\
title = \"small\"
[grid]
epsilon = [0.1, 1.0]
alpha = 0.3
beta = 0.0
gamma = [2.0, 8.0]
V = [0.5, 10.0]
c = [0.0, 0.05, 1.0, 3.0]
[methods]
run = [\"perturbation\", \"symmetric\", \"simulation\", \"event_step\"]
";

#[test]
fn a_catalogue_is_made_and_its_lines_hold() {
    let scratch = Scratch::new();
    scratch.file("small.toml", SMALL);
    let printed = scratch.run("failures small.toml").ends_with(0);
    assert_eq!(printed.err, "", "no progress bar without a terminal");
    assert_eq!(scratch.names(), ["small.toml"]);
    let run = scratch.run("failures small.toml --out made --threads 1").ends_with(0);
    assert_eq!(run.out, "made/failures.md\n");
    // The page is the same for any number of threads, except for the line with the command.
    let rest = |text: &str| {
        text.lines().filter(|line| !line.starts_with("Made by")).map(str::to_owned).collect::<Vec<_>>()
    };
    assert_eq!(rest(&scratch.read("made/failures.md")), rest(&printed.out));
    printed.out.says(&["Made by `slipmap failures small.toml`."]);
    let classes = rows(&scratch.path().join("made/classes.csv"));
    assert!(classes.len() >= 4, "{classes:?}");
    // Each distance in c has its error beside it.
    let methods = rows(&scratch.path().join("made/methods.csv"));
    for (table, name) in [(&classes, "farthest_c"), (&methods, "farthest_wrong_c")] {
        let number = |row: &Row, name: &str| row[name].parse::<f64>().ok();
        for row in table {
            let [distance, error] = [name, &format!("{name}_error")].map(|name| number(row, name));
            assert_eq!(distance.is_some(), error.is_some(), "{row:?}");
            assert!(error.is_none_or(|error| (0.0..1e-6).contains(&error)), "{row:?}");
        }
        assert!(table.iter().any(|row| number(row, name).is_some()));
    }
    reproduce(&scratch, &classes);
    // An earlier catalogue is kept unless it may be replaced, and that is checked before the computation.
    scratch
        .run("failures small.toml --out made")
        .refuses(&["made/failures.md exists already", "--overwrite"]);
    scratch.run("failures small.toml --out made --overwrite").ends_with(0);
    scratch.run("failures nowhere.toml").refuses(&["nowhere.toml", "help: "]);
    let (long, wide) =
        ("grid.c={ from = 0, to = 1, points = 1000000 }", "grid.V={ from = 1, to = 2, points = 20 }");
    scratch
        .run(&["failures", "small.toml", "--set", long, "--set", wide])
        .refuses(&["a catalogue takes at most 10,000,000"]);
}

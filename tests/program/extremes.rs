//! Legal input at the ends of the range of numbers: every command ends with an answer or a reason, and never
//! in a panic. `scripts/study extremes` tries a thousand random configurations.

use std::process::Child;
use std::time::{Duration, Instant};

use rayon::prelude::*;
use serde_json::Value;
use slipmap::column::Verdict;
use slipmap::config::Job;
use slipmap::files::Existing;
use slipmap::map::{self, Account, Contradiction, Contradictions, Control, Queue, Sink, TileData};
use slipmap::store::{MapFile, PackedTile, PartialMap, Provenance, StoreError};
use slipmap_numbers::random::Random;

use crate::command::{Run, Says, Scratch, signal};

/// A few cells, with one axis changed.
fn config(axis: &str, nodes: &str) -> String {
    let mut text = String::from("[grid]\n");
    let usual = [
        ("epsilon", "0.2"),
        ("alpha", "0.3"),
        ("beta", "0.0"),
        ("gamma", "[1.0, 2.0]"),
        ("V", "1.0"),
        ("c", "[0.0, 1.0]"),
    ];
    for (name, value) in usual {
        text.push_str(&format!("{name} = {}\n", if name == axis { nodes } else { value }));
    }
    text + "[output]\npath = \"map.h5\"\nfields = [\"verdict\", \"critical_c\", \"regime\"]\n"
}

/// Asserts that the command ended by itself, with data or with one message.
#[track_caller]
fn ended(run: Run) -> Run {
    assert!((0..=2).contains(&run.code), "\nstdout:\n{}\nstderr:\n{}", run.out, run.err);
    assert!(!run.err.contains("panicked"), "{}", run.err);
    assert!(run.code < 2 || run.err.contains("error:"), "a refusal has a message: {}", run.err);
    run
}

/// Runs, checks, reports and plots a small map.
#[track_caller]
fn whole_way(axis: &str, nodes: &str) {
    let scratch = Scratch::new();
    scratch.file("map.toml", config(axis, nodes));
    let run = ended(scratch.run("run map.toml --quiet"));
    if run.code == 2 {
        return;
    }
    scratch.run("check map.h5").ends_with(0);
    ended(scratch.run("report map.h5 --out report --quiet"));
    let other = if axis == "c" { "V" } else { "c" };
    let axes = ["--x", axis, "--y", other, "--out"];
    ended(scratch.run(&[&["plot", "map.h5", "--variable", "regime"], &axes[..], &["b.svg"]].concat()));
}

#[test]
fn maps_at_the_ends_of_the_axes_are_drawn() {
    let ends = [
        ("V", "[1e-5, 1.0]"),
        ("c", "[0.0, 5e-324]"),
        ("V", "[1e-300, 1e300]"),
        ("V", "5e-324"),
        ("epsilon", "5e-324"),
        ("c", "[0.0, 1e12]"),
        ("gamma", "[1e16, 2e16]"),
        ("gamma", "[1e308, 1.5e308]"),
    ];
    ends.into_par_iter().for_each(|(axis, values)| whole_way(axis, values));
}

#[test]
fn a_slow_belt_has_an_answer_with_the_reason_of_unknown_limits() {
    let scratch = Scratch::new();
    let fixed = "probe --epsilon 0.1 --alpha 0.3 --beta 0.1 --gamma 2";
    for (speed, damping) in [("1e-8", "0.5"), ("1e-8", "1e8")] {
        let point = format!("{fixed} --V {speed} --c {damping}");
        let run = scratch.run(&point).ends_with(0);
        let answer = scratch.json(&point);
        let methods = answer["methods"].as_object().unwrap();
        // Theorems decide these points, and the simulation agrees.
        let said = |name: &str| methods[name]["verdict"].as_str().unwrap().to_owned();
        assert_eq!(said("simulation"), said("symmetric"), "V = {speed}, c = {damping}");
        for (name, method) in methods {
            let given_up = method["epsilon_limit_reason"].is_string();
            let known = !method["epsilon_limit"].is_null();
            assert!(known != given_up, "{name}: {method}");
            let told =
                run.out.lines().any(|line| line.contains("no epsilon limit of") && line.contains(name));
            assert_eq!(given_up, told, "{name}\n{}", run.out);
        }
    }
}

#[test]
fn formulas_have_limits_with_a_message_and_budgets() {
    let scratch = Scratch::new();
    let point = ["--epsilon", "1", "--V", "1", "--c", "0.1"];
    let long = format!("1{}", "-0*u".repeat(5_000));
    scratch
        .run(&[&["probe", "--phi", &long], &point[..]].concat())
        .refuses(&["operations", "give the law as a table"]);
    let wavy = ["probe", "--phi", "1-0.1*sin(1000*u)", "--json"];
    scratch.run(&[&wavy[..], &point[..]].concat()).ends_with(0);
}

#[test]
fn a_message_says_how_far_data_should_reach_for_an_orbit() {
    let scratch = Scratch::new();
    let rows: String =
        (0..=15).map(|i| 0.1 * f64::from(i)).map(|u| format!("{u},{}\n", 1.0 - 0.3 * u)).collect();
    scratch.file("short.csv", format!("u,phi\n{rows}"));
    let point = "probe --table short.csv --epsilon 1 --V 0.75 --c 0";
    let run = scratch.run(point).ends_with(0);
    run.out.says(&["which end at slip speed 1.5: it needs them up to about"]);
    assert!(!run.out.contains("finite numbers"), "naive methods leave the data too: {}", run.out);
    // Without a simulation no limit in eps exists.
    let answer = scratch.json(point);
    assert_eq!(answer["methods"]["simulation"]["epsilon_limit"], Value::Null, "{answer}");
}

#[test]
fn messages_name_the_intended_key() {
    let scratch = Scratch::new();
    scratch.file("map.toml", config("c", "[0.0, 1.0]"));
    scratch.run("run map.toml --quiet").ends_with(0);
    scratch.run("run map.h5").refuses(&["map.h5", "this is a map, not a configuration file"]);
    scratch.file("eps.toml", config("c", "[0.0, 1.0]").replace("epsilon", "eps"));
    scratch.run("run eps.toml").refuses(&["nearest valid key is `epsilon`"]);
    scratch.file("wide.toml", "\u{feff}x".encode_utf16().flat_map(u16::to_le_bytes).collect::<Vec<u8>>());
    scratch.run("run wide.toml").refuses(&["UTF-16", "save it as UTF-8"]);
    let formula = ["probe", "--phi", "1 - 0.1*x", "--epsilon", "1", "--V", "1", "--c", "0"];
    scratch.run(&formula).refuses(&["--set x", "the slip speed is called u"]);
    let point = ["--epsilon", "0.1", "--alpha", "0.3", "--beta", "0.1", "--gamma", "2", "--c", "0.5"];
    scratch.run(&[&["probe", "--v", "1"], &point[..]].concat()).ends_with(0);
    scratch.run("probe --machine map.toml").refuses(&["map.toml", "`machine` is missing"]);
    scratch.file("there.svg", "");
    let figure = [&["probe", "--V", "1", "--figure", "there.svg"], &point[..]].concat();
    scratch.run(&figure).refuses(&["--figure there.svg exists already", "--overwrite"]);
}

/// Waits until the process has installed its handler of SIGTERM and sleeps.
fn wait_until_listening(child: &Child) {
    let start = Instant::now();
    let caught = || {
        let status = std::fs::read_to_string(format!("/proc/{}/status", child.id())).unwrap_or_default();
        let line = status.lines().find_map(|line| line.strip_prefix("SigCgt:").map(str::trim));
        line.and_then(|mask| u64::from_str_radix(mask, 16).ok()).is_some_and(|mask| mask & (1 << 14) != 0)
    };
    while !caught() {
        assert!(start.elapsed() < Duration::from_secs(60), "it never listened");
        std::thread::sleep(Duration::from_millis(5));
    }
    std::thread::sleep(Duration::from_millis(300));
}

#[cfg(target_os = "linux")]
#[test]
fn the_first_signal_ends_a_command_that_waits_for_a_pipe() {
    let scratch = Scratch::new();
    for name in ["pipe.toml", "pipe.csv", "pipe.json", "pipe.h5"] {
        let made = std::process::Command::new("mkfifo").arg(scratch.path().join(name)).status().unwrap();
        assert!(made.success());
    }
    let point = ["--epsilon", "0.1", "--V", "1", "--c", "0.1"];
    let commands: [&[&str]; 4] = [
        &["run", "pipe.toml"],
        &["probe", "--points", "pipe.csv", "--out", "answers.csv"],
        &[&["probe", "--table", "pipe.csv"], &point[..]].concat(),
        &["check", "--proof", "pipe.json"],
    ];
    for arguments in commands {
        let mut child = scratch.start(arguments);
        wait_until_listening(&child);
        if child.try_wait().unwrap().is_none() {
            signal(&child, "-TERM");
            let run = Run::after(child).ends_with(143);
            assert!(run.err.contains("interrupted; nothing was written"), "{arguments:?}: {}", run.err);
        } else {
            // An immediate refusal is accepted, too.
            Run::after(child).refuses(&["pipe"]);
        }
    }
    assert_eq!(scratch.names(), ["pipe.csv", "pipe.h5", "pipe.json", "pipe.toml"]);
}

#[test]
fn absurd_numbers_of_threads_are_refused() {
    let scratch = Scratch::new();
    scratch.file("map.toml", config("c", "[0.0, 1.0]"));
    scratch.run("run map.toml --threads 65535").refuses(&["--threads", "65535", "from 1 to 4096"]);
    assert_eq!(scratch.names(), ["map.toml"]);
}

/// Writes the tiles of a map with an account that contains contradictions.
struct Contradicted<'a>(&'a PartialMap, Contradictions);

impl Sink for Contradicted<'_> {
    type Packed = PackedTile;
    type Error = StoreError;

    fn pack(&self, data: &TileData) -> Result<PackedTile, StoreError> {
        self.0.pack(data)
    }

    fn write(&self, packed: PackedTile, account: &Account) -> Result<(), StoreError> {
        self.0.write(packed, &Account { contradictions: self.1.clone(), ..account.clone() })
    }
}

#[test]
fn contradictions_between_theorems_and_simulation_are_reported() {
    let scratch = Scratch::new();
    let text = config("c", "[0.0, 1.0]") + "[audit]\ncells = 0\n";
    let file = scratch.file("map.toml", text);
    // The one tile of a run that was stopped before it could complete the map, with contradictions in its
    // account.
    let job = Job::load(&file, &[]).unwrap();
    let provenance = Provenance {
        config_text: job.config_text.clone(),
        git: slipmap::GIT.into(),
        threads: 1,
        ..Provenance::default()
    };
    let path = scratch.path().join("map.h5");
    let map = PartialMap::begin(&path, &job.plan, &provenance, Existing::Refuse).unwrap();
    let verdicts = job.plan.methods.iter().map(|method| match method.name() {
        "symmetric" => Verdict::Present,
        "simulation" => Verdict::Absent,
        _ => Verdict::Undecided,
    });
    let first = vec![Contradiction { tile: 0, index: vec![0; 6], verdicts: verdicts.collect() }];
    let sink = Contradicted(&map, Contradictions { cells: 3, first });
    let queue = Queue::new(map.found.tiles(), map.found.finished());
    map::compute_tiles(&job.plan, &sink, &Control::default(), &|| queue.take()).unwrap();
    drop(map);

    let run = scratch.run("run map.toml --resume").ends_with(1);
    run.out.says(&["3 cells in which methods with a guarantee contradict"]);
    run.out.says(&["present by symmetric; absent by simulation: slipmap probe"]);
    assert_eq!(MapFile::open(&path).unwrap().number("contradicted_cells"), Some(3.0));
    let report = ended(scratch.run("report map.h5 --out report --quiet"));
    assert_eq!(report.code, 0);
    let failures = std::fs::read_to_string(scratch.path().join("report/tables/failures.csv")).unwrap();
    assert!(
        failures.lines().any(|line| line.contains("contradict each other") && line.contains('3')),
        "{failures}"
    );
}

/// A legal number of any size: an ordinary one half of the time.
fn number(random: &mut dyn FnMut() -> f64) -> f64 {
    if random() < 0.5 { 0.05 + 2.0 * random() } else { 10_f64.powf(600.0 * random() - 300.0) }
}

/// A few of the configurations that `scripts/study extremes` tries: runs end by themselves, without a panic.
#[test]
fn random_legal_configurations_end_with_an_answer_or_a_reason() {
    let mut random = Random(20);
    let mut random = move || random.unit();
    let laws: [(&str, &[&str]); 4] = [
        ("law = \"stribeck\"", &["alpha", "beta", "gamma"]),
        ("law = \"exponential\"", &["mu", "vs"]),
        ("law = \"lorentzian\"", &["mu", "vs", "eta"]),
        ("law = \"expression\"\nphi = \"1 - a*sin(b*u)\"", &["a", "b"]),
    ];
    for (law, parameters) in laws {
        let mut text = format!("[friction]\n{law}\n[grid]\n");
        for name in ["epsilon"].iter().chain(parameters).chain(&["V", "c"]) {
            let nodes: Vec<String> = match *name {
                "alpha" | "mu" => vec![format!("{:?}", random())],
                _ => vec![format!("{:?}", number(&mut random))],
            };
            text.push_str(&format!("{name} = [{}]\n", nodes.join(", ")));
        }
        let scratch = Scratch::new();
        scratch.file("map.toml", text + "[audit]\ncells = 2\n[output]\npath = \"map.h5\"\n");
        let run = ended(scratch.run("run map.toml --quiet"));
        if run.code < 2 {
            scratch.run("check map.h5").ends_with(0);
        }
    }
}

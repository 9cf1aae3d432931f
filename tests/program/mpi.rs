//! One map by many processes equals the map of one process, for any number of them and if some are killed.
//!
//! Needs an MPI library with `mpirun`; run by `scripts/mpi`.

use std::fs;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::command::{Run, Scratch};
use crate::map_equal::{JOB, assert_same, scratch};

/// The map of one process.
fn reference(scratch: &Scratch) -> PathBuf {
    scratch.run(&["run", "job.toml"]).ends_with(0);
    let path = scratch.path().join("reference.h5");
    fs::rename(scratch.path().join("map.h5"), &path).unwrap();
    path
}

/// `ranks` processes with the same arguments, on any number of cores.
fn mpirun(scratch: &Scratch, ranks: u32, arguments: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    command
        // Allows Open MPI to start more processes than cores, and to do so in a container.
        .envs([("OMPI_MCA_rmaps_base_oversubscribe", "1"), ("OMPI_MCA_btl_base_warn_component_unused", "0")])
        .envs([("OMPI_ALLOW_RUN_AS_ROOT", "1"), ("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1")])
        .args(["-n", &ranks.to_string(), env!("CARGO_BIN_EXE_slipmap")])
        .args(arguments)
        .current_dir(scratch.path())
        .stdin(Stdio::null());
    command
}

fn ranks(scratch: &Scratch, ranks: u32, arguments: &[&str]) -> Run {
    Run::of(mpirun(scratch, ranks, arguments).output().unwrap())
}

/// The process of a rank, found among the descendants of its launcher.
fn process_of(launcher: &Child, rank: &str) -> Option<u32> {
    let mut waiting = vec![launcher.id()];
    let wanted = format!("OMPI_COMM_WORLD_RANK={rank}");
    while let Some(process) = waiting.pop() {
        let environment = fs::read(format!("/proc/{process}/environ")).unwrap_or_default();
        if environment.split(|byte| *byte == 0).any(|entry| entry == wanted.as_bytes()) {
            return Some(process);
        }
        for task in fs::read_dir(format!("/proc/{process}/task")).into_iter().flatten().flatten() {
            let children = fs::read_to_string(task.path().join("children")).unwrap_or_default();
            waiting.extend(children.split_whitespace().filter_map(|child| child.parse::<u32>().ok()));
        }
    }
    None
}

#[test]
fn any_number_of_ranks_makes_the_same_map() {
    let scratch = scratch();
    let reference = reference(&scratch);
    let map = scratch.path().join("map.h5");
    for number in [2, 4] {
        let run = ranks(&scratch, number, &["run", "job.toml", "--threads", "1", "--json"]).ends_with(0);
        let summary: serde_json::Value = serde_json::from_str(&run.out).unwrap();
        assert_eq!(summary["threads"], number, "the threads of all ranks");
        assert_eq!(summary["audit"]["cells"], 50, "the audits of all ranks");
        assert_eq!(scratch.names(), ["job.toml", "map.h5", "reference.h5"]);
        assert_same(&map, &reference);
        fs::remove_file(&map).unwrap();
    }
}

/// Rank 0 selects the boxes to be proved, and all ranks prove.
#[test]
fn any_number_of_ranks_makes_the_same_proofs() {
    let scratch = Scratch::new();
    let axes = "epsilon = 0.05\nalpha = [0.1, 0.5]\nbeta = 0.0\ngamma = [0.5, 4.0]\nV = [0.5, 1.0]\nc = [0.0, 1.0]\n";
    let validated = "[methods]\nrun = [\"validated\"]\n[validated]\nboxes = 5\nproof = \"proof.json\"\n";
    scratch.file("job.toml", format!("[grid]\n{axes}{validated}[output]\npath = \"map.h5\"\n"));
    let arguments = ["run", "job.toml", "--threads", "1", "--json"];
    scratch.run(&arguments).ends_with(0);
    let reference = scratch.path().join("reference.h5");
    fs::rename(scratch.path().join("map.h5"), &reference).unwrap();
    let proof = scratch.read("proof.json");
    for number in [2, 3] {
        fs::remove_file(scratch.path().join("proof.json")).unwrap();
        ranks(&scratch, number, &arguments).ends_with(0);
        assert_eq!(scratch.read("proof.json"), proof, "{number} ranks");
        assert_same(&scratch.path().join("map.h5"), &reference);
        fs::remove_file(scratch.path().join("map.h5")).unwrap();
    }
    scratch.file("proof.json", proof);
    scratch.run(&["check", "--proof", "proof.json"]).ends_with(0);
}

#[test]
fn a_killed_rank_costs_no_finished_tile() {
    let scratch = scratch();
    let reference = reference(&scratch);
    let journal = scratch.path().join("map.h5.part");
    // Rank 0 writes the map.
    for lost in ["1", "0"] {
        let mut command = mpirun(&scratch, 3, &["run", "job.toml", "--threads", "1"]);
        let launcher = command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap();
        let start = Instant::now();
        // Tiles take about 50 kB each.
        while fs::metadata(&journal).map_or(0, |metadata| metadata.len()) < 250_000 {
            assert!(start.elapsed() < Duration::from_secs(100), "no tiles were ever finished");
            std::thread::sleep(Duration::from_millis(2));
        }
        let process = process_of(&launcher, lost).expect("the rank is at work");
        assert!(Command::new("kill").args(["-9", &process.to_string()]).status().unwrap().success());
        let run = Run::of(launcher.wait_with_output().unwrap());
        assert_ne!(run.code, 0, "a run that lost a rank says so");
        assert!(!scratch.path().join("map.h5").exists(), "killed too late for this test");
        // Resumed by another number of processes, and by one alone.
        let resumed = match lost {
            "1" => ranks(&scratch, 2, &["run", "job.toml", "--resume", "--json"]),
            _ => scratch.run(&["run", "job.toml", "--resume", "--json"]),
        };
        let summary: serde_json::Value = serde_json::from_str(&resumed.ends_with(0).out).unwrap();
        assert!(summary["resumed_tiles"].as_u64() > Some(0), "{summary}");
        assert_eq!(scratch.names(), ["job.toml", "map.h5", "reference.h5"]);
        assert_same(&scratch.path().join("map.h5"), &reference);
        fs::remove_file(scratch.path().join("map.h5")).unwrap();
    }
}

#[test]
fn ranks_that_disagree_do_not_begin() {
    let scratch = scratch();
    scratch.file("other.toml", JOB.replace("0.05, 0.2", "0.05, 0.3"));
    let program = env!("CARGO_BIN_EXE_slipmap");
    let mut command = mpirun(&scratch, 1, &["run", "job.toml"]);
    let run = Run::of(command.args([":", "-n", "1", program, "run", "other.toml"]).output().unwrap());
    assert_eq!(run.code, 2, "{run:?}");
    assert!(run.err.contains("rank 1 would compute another map"), "{}", run.err);
    // One message, not one per rank.
    let run = ranks(&scratch, 3, &["run", "job.toml", "--set", "grid.V=-1.0"]);
    assert_eq!((run.code, run.err.matches("error:").count()), (2, 1), "{run:?}");
    assert_eq!(scratch.names(), ["job.toml", "other.toml"]);
}

/// Processor time in seconds of all ranks, and wall-clock time, for 40 x 40 x 40 x 40 x `nodes` cells; the
/// best of several runs, since other load on the machine only adds to both.
fn timed(scratch: &Scratch, ranks: u32, nodes: u32, runs: u32, map: &str) -> (f64, f64) {
    let axes = [("alpha", nodes), ("beta", 40), ("gamma", 40), ("V", 40), ("c", 40)]
        .map(|(name, points)| format!("{name} = {{ from = 0.05, to = 1.0, points = {points} }}"));
    let grid = format!("[grid]\nepsilon = 0.05\n{}\n", axes.join("\n"));
    scratch.file("rate.toml", grid + "[output]\npath = \"rate.h5\"\n");
    let arguments = ["run", "rate.toml", "--threads", "1", "--quiet", "--overwrite"];
    let runs = (0..runs).map(|_| {
        let command = match ranks {
            1 => scratch.command(&arguments),
            _ => mpirun(scratch, ranks, &arguments),
        };
        // The shell reports the times of its children.
        let mut shell = Command::new("bash");
        shell
            .args(["-c", "\"$@\" >/dev/null; times", "bash"])
            .arg(command.get_program())
            .args(command.get_args())
            .envs(command.get_envs().filter_map(|(name, value)| Some((name, value?))))
            .current_dir(scratch.path());
        let start = Instant::now();
        let times = Run::of(shell.output().unwrap()).ends_with(0).out;
        let seconds = start.elapsed().as_secs_f64();
        let children = times.lines().nth(1).unwrap();
        let read = |text: &str| {
            let (minutes, seconds) = text.trim_end_matches('s').split_once('m').unwrap();
            60.0 * minutes.parse::<f64>().unwrap() + seconds.parse::<f64>().unwrap()
        };
        (children.split_whitespace().map(read).sum(), seconds)
    });
    let runs: Vec<(f64, f64)> = runs.collect();
    fs::rename(scratch.path().join("rate.h5"), scratch.path().join(map)).unwrap();
    let least = |of: fn(&(f64, f64)) -> f64| runs.iter().map(of).fold(f64::INFINITY, f64::min);
    (least(|run| run.0), least(|run| run.1))
}

#[test]
#[ignore = "a measurement: prints a table"]
fn rate_of_ranks() {
    let scratch = Scratch::new();
    let cores = std::thread::available_parallelism().unwrap().get() as u32;
    println!(
        "scaling,ranks,cores,cells,seconds,processor_seconds,processor_seconds_per_rank,efficiency_per_rank,\
         efficiency_per_core,efficiency_of_processor"
    );
    for (scaling, per_rank) in [("strong", None), ("weak", Some(120))] {
        let mut one = None;
        for ranks in [1, 2, 4] {
            let nodes = per_rank.map_or(240, |nodes| nodes * ranks);
            let (processor, seconds) = timed(&scratch, ranks, nodes, 3, "many.h5");
            // By one process, for comparison.
            let alone = match (ranks, per_rank) {
                (1, _) => "many.h5",
                (_, None) => "strong.h5",
                (_, Some(_)) => {
                    timed(&scratch, 1, nodes, 1, "alone.h5");
                    "alone.h5"
                }
            };
            assert_same(&scratch.path().join("many.h5"), &scratch.path().join(alone));
            if (ranks, scaling) == (1, "strong") {
                fs::copy(scratch.path().join("many.h5"), scratch.path().join("strong.h5")).unwrap();
            }
            let (first_processor, first) = *one.get_or_insert((processor, seconds));
            // The work relative to the first row.
            let work = f64::from(per_rank.map_or(1, |_| ranks));
            println!(
                "{scaling},{ranks},{cores},{},{seconds:.2},{processor:.2},{:.2},{:.2},{:.2},{:.2}",
                40_u64.pow(4) * u64::from(nodes),
                processor / f64::from(ranks),
                work * first / (f64::from(ranks) * seconds),
                work * first / (f64::from(ranks.min(cores)) * seconds),
                work * first_processor / processor,
            );
        }
    }
}

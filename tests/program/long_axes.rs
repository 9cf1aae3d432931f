//! Slices of maps with two long axes: drawn from evenly many of their nodes, in bounded memory.

use std::process::{Command, Stdio};

use crate::command::{Run, Scratch};

/// Nodes of each of the two axes.
const NODES: usize = 16_000;

/// Address space in kilobytes: hardly more than the program needs at all, and less than three bytes for each cell
/// of the plane.
const MEMORY_LIMIT: &str = "640000";

#[test]
fn a_plane_of_two_long_axes_is_thinned() {
    let scratch = Scratch::new();
    // 2.56e8 cells: a closed form decides each column at once.
    scratch.file(
        "job.toml",
        format!(
            "[grid]\nepsilon = 0.1\nalpha = 0.3\nbeta = 0.0\ngamma = {{ from = 0.5, to = 2.0, points = {NODES} }}\n\
             V = 1.0\nc = {{ from = 0.0, to = 2.0, points = {NODES} }}\n[methods]\nrun = [\"perturbation\"]\n\
             [output]\npath = \"map.h5\"\n"
        ),
    );
    scratch.run("run job.toml").ends_with(0);
    let plot = |x: &str, y: &str, out: &str| {
        let mut command = Command::new("sh");
        command.args(["-c", "ulimit -v \"$0\"; exec \"$@\"", MEMORY_LIMIT, env!("CARGO_BIN_EXE_slipmap")]);
        // Every thread has memory of its own, and allocators reserve addresses that are never used.
        command.env("RAYON_NUM_THREADS", "1").env("MALLOC_ARENA_MAX", "1").env("MIMALLOC_ARENA_RESERVE", "0");
        command.args(["plot", "map.h5", "--x", x, "--y", y, "--out", out]);
        let run = Run::of(command.current_dir(scratch.path()).stdin(Stdio::null()).output().unwrap());
        let run = run.ends_with(0);
        assert!(run.err.contains("gamma: one node in 16 is drawn\nc: one node in 16 is drawn"), "{run:?}");
        scratch.read(out)
    };
    let svg = plot("gamma", "c", "plot.svg");
    assert!(
        svg.contains("One node in 16 of γ is drawn. One node in 16 of c is drawn."),
        "the caption says so"
    );
    // The verdict changes at c = gamma (1 - alpha) = 0.7 gamma: the figure is that of a map with the drawn
    // nodes.
    assert!(svg.len() < 1_000_000, "{} bytes", svg.len());
}

/// More tiles than memory has bytes: what is kept is that of the tiles that are finished.
#[test]
fn a_grid_of_a_trillion_tiles_takes_no_memory_for_them() {
    let scratch = Scratch::new();
    scratch.file(
        "job.toml",
        "[grid]\nepsilon = 0.1\nalpha = { from = 0.0, to = 0.9, points = 1000000 }\nbeta = 0.0\n\
         gamma = { from = 0.5, to = 2.0, points = 1000000 }\nV = 1.0\nc = { from = 0.0, to = 3.0, points = 1000000 }\n\
         [methods]\nrun = [\"symmetric\"]\n[output]\npath = \"map.h5\"\n",
    );
    let status = scratch.json("status job.toml");
    assert_eq!((&status["done"], &status["complete"]), (&0.into(), &false.into()), "{status}");
    assert!(status["tiles"].as_u64() > Some(1_000_000_000), "{status}");
    scratch.run("merge job.toml").refuses(&["tiles of 1,000,000,000,000 missing"]);
    scratch.run("run job.toml --shard 2/3 --threads 1 --time-limit 5s --quiet").ends_with(75);
    let status = scratch.json("status job.toml");
    assert_eq!(status["missing_shards"], serde_json::json!([1, 2, 3]), "{status}");
}

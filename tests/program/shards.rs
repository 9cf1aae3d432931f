//! A map of many processes equals that of one, whatever happens to them.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::command::{Run, Says, Scratch, journal_bytes, journals, random, signal};
use crate::map_equal::{assert_same, reference, scratch};

fn shard(scratch: &Scratch, number: usize, of: usize) -> Child {
    scratch.start(&format!("run job.toml --threads 1 --shard {number}/{of}"))
}

#[track_caller]
fn finishes(child: Child) -> Run {
    Run::after(child).ends_with(0)
}

/// Merges, compares with the reference, and removes the map.
#[track_caller]
fn merges(scratch: &Scratch, reference: &Path) {
    scratch.run("merge job.toml").ends_with(0);
    scratch.run("check map.h5").ends_with(0);
    // Those of the shards.
    let map = slipmap::store::MapFile::open(&scratch.path().join("map.h5")).unwrap();
    assert_eq!(map.number("threads"), Some(1.0));
    assert_same(&scratch.path().join("map.h5"), reference);
    assert_eq!(scratch.names(), ["job.toml", "map.h5", "reference.h5"]);
    fs::remove_file(scratch.path().join("map.h5")).unwrap();
}

fn status(scratch: &Scratch) -> Value {
    scratch.json("status job.toml")
}

/// Two at a time, as on two cores.
#[test]
fn any_number_of_shards_makes_the_map_of_one_process() {
    let scratch = scratch();
    let reference = reference(&scratch);
    for of in [2, 41] {
        let mut before = None;
        for number in 1..=of {
            let next = shard(&scratch, number, of);
            before.replace(next).map(finishes);
        }
        before.map(finishes);
        merges(&scratch, &reference);
    }
}

#[test]
fn shards_may_overlap_be_lost_and_run_twice() {
    let scratch = scratch();
    let reference = reference(&scratch);
    // Nothing yet: the rest of a run is named, and nothing is made.
    scratch.run("merge job.toml").refuses(&["40 tiles of 40 missing", "slipmap run job.toml --resume"]);
    finishes(shard(&scratch, 3, 4));
    let journal = journals(scratch.path()).remove(0);
    // The same twice at once, another time with another number of shards.
    for child in [shard(&scratch, 1, 4), shard(&scratch, 1, 4), shard(&scratch, 2, 2)] {
        finishes(child);
    }
    let help = "slipmap run job.toml --shard K/4 for K = 3";
    fs::rename(&journal, scratch.path().join("lost")).unwrap();
    scratch.run("merge job.toml").refuses(&["10 tiles of 40 missing", help]);
    let found = status(&scratch);
    assert_eq!([&found["tiles"], &found["done"], &found["left"]], [40, 30, 10], "{found}");
    assert_eq!(found["missing_shards"], serde_json::json!([3]));
    assert!(found["seconds_left"].as_f64() > Some(0.0), "{found}");
    scratch.run("status job.toml").ends_with(0).out.says(&["30 of 40 tiles finished", help]);
    // A shard that finds all its tiles computes nothing, and leaves no journal.
    let before = journals(scratch.path()).len();
    finishes(shard(&scratch, 4, 4)).err.says(&["resuming with 10 of 40 tiles finished"]);
    assert_eq!(journals(scratch.path()).len(), before);
    // The lost journal comes back.
    fs::rename(scratch.path().join("lost"), &journal).unwrap();
    merges(&scratch, &reference);
}

#[test]
fn a_complete_map_is_left_as_it_is() {
    let scratch = scratch();
    finishes(shard(&scratch, 1, 1));
    let leftover = journals(scratch.path()).remove(0);
    let tiles = fs::read(&leftover).unwrap();
    scratch.run("merge job.toml").ends_with(0);
    let map = fs::read(scratch.path().join("map.h5")).unwrap();
    // Of a process that was stopped before it could remove its journal.
    fs::write(leftover, tiles).unwrap();
    // Of one that was stopped before it wrote to its own.
    fs::write(scratch.path().join("map.h5.part.aB1xYz"), "").unwrap();
    for arguments in [&["merge", "job.toml", "--json"][..], &["run", "job.toml", "--shard", "2/5"]] {
        scratch.run(arguments).ends_with(0).err.says(&["map.h5 is complete already"]);
    }
    assert_eq!(status(&scratch)["complete"], true);
    assert_eq!(fs::read(scratch.path().join("map.h5")).unwrap(), map);
    assert_eq!(scratch.names(), ["job.toml", "map.h5"]);
    // It is not that of another plan.
    let other = ["--set", "grid.V=1.0"];
    for command in [&["merge", "job.toml"][..], &["status", "job.toml"], &["run", "job.toml", "--shard=1/2"]]
    {
        scratch
            .run(&[command, &other].concat())
            .refuses(&["map.h5 was begun as something else", "+ V = 1.0"]);
    }
    scratch.run("run job.toml --shard 3/2").refuses(&["--shard", "3/64"]);
    scratch.run("run job.toml --shard 1/2 --overwrite").refuses(&["--overwrite"]);
}

/// Runs random shards, each killed at a random time, until `kills` were killed; then all shards once, and merges.
fn kill(kills: usize, seed: u64) {
    let scratch = scratch();
    let reference = reference(&scratch);
    let (mut state, mut killed) = (seed, 0);
    while killed < kills {
        let of = 1 + (4.0 * random(&mut state)) as usize;
        let mut children: Vec<Child> =
            [0, 1].map(|_| shard(&scratch, 1 + (of as f64 * random(&mut state)) as usize, of)).into();
        std::thread::sleep(Duration::from_secs_f64(0.3 * random(&mut state)));
        for child in &mut children {
            killed += usize::from(child.try_wait().unwrap().is_none());
            let _ = child.kill();
            child.wait().unwrap();
        }
    }
    (1..=3).for_each(|number| drop(finishes(shard(&scratch, number, 3))));
    // Merging is killed as well.
    for _ in 0..kills / 5 {
        let mut merge = scratch.command("merge job.toml").stdout(Stdio::null()).spawn().unwrap();
        std::thread::sleep(Duration::from_secs_f64(0.05 * random(&mut state)));
        let _ = merge.kill();
        merge.wait().unwrap();
    }
    merges(&scratch, &reference);
}

#[test]
fn twenty_random_kills_lose_nothing() {
    kill(20, 6);
}

#[test]
fn a_time_limit_ends_a_shard_with_a_code_of_its_own() {
    let scratch = scratch();
    let reference = reference(&scratch);
    // Until all is done: at every limit something is kept.
    let limited = ["run", "job.toml", "--shard", "1/1", "--threads", "1", "--time-limit", "400ms"];
    let mut before = 0;
    loop {
        let run = scratch.run(&limited);
        if run.code == 0 {
            break;
        }
        let run = run.ends_with(75);
        run.err.says(&["the time limit was reached"]);
        let bytes = journal_bytes(scratch.path());
        assert!(bytes >= before);
        if bytes > before {
            let way = "to continue: slipmap run job.toml --shard 1/1 --threads 1 --time-limit 400ms";
            run.err.says(&[way]);
        }
        before = bytes;
    }
    let child = scratch.start("run job.toml --set output.path=b.h5 --shard=1/2");
    signal(&child, "-TERM");
    let code = child.wait_with_output().unwrap().status.code();
    // The signal may come before the program listens.
    assert!(code == Some(143) || code.is_none(), "{code:?}");
    for journal in journals(scratch.path()).iter().filter(|path| path.to_string_lossy().contains("b.h5")) {
        fs::remove_file(journal).unwrap();
    }
    merges(&scratch, &reference);
    scratch.run("run job.toml --time-limit soon").refuses(&["--time-limit"]);
}

/// A merge that finds no room keeps the journals, and succeeds when there is.
#[test]
fn a_full_disk_in_a_merge_loses_nothing() {
    let scratch = scratch();
    let reference = reference(&scratch);
    finishes(shard(&scratch, 1, 1));
    let length = fs::metadata(&reference).unwrap().len();
    // In blocks of 512 bytes: room for nothing, for some chunks, for all but the seal.
    for limit in [0, length / 512 / 5, length / 512 * 4 / 5, (length - 1) / 512] {
        let script = "trap '' XFSZ; ulimit -f $1; exec \"$0\" merge job.toml";
        let mut shell = Command::new("sh");
        shell.args(["-c", script, env!("CARGO_BIN_EXE_slipmap"), &limit.to_string()]);
        let run = Run::of(shell.current_dir(scratch.path()).output().unwrap()).ends_with(1);
        assert!(
            run.err.contains("no room left for")
                && run.err.contains("slipmap merge job.toml")
                && run.err.matches("rror").count() == 1,
            "HDF5 is silent: {}",
            run.err
        );
        assert_eq!(scratch.names(), ["job.toml", "map.h5.part", "reference.h5"]);
    }
    merges(&scratch, &reference);
}

/// Another process that begins to make the map removes what this one has written of it: it begins anew.
#[test]
fn a_merge_whose_unfinished_map_is_removed_makes_the_map() {
    let scratch = scratch();
    let reference = reference(&scratch);
    drop(finishes(shard(&scratch, 1, 1)));
    let removes = || {
        let names = fs::read_dir(scratch.path()).unwrap().map(|entry| entry.unwrap().path());
        let unfinished: Vec<_> = names.filter(|path| path.to_string_lossy().contains(".part-map.")).collect();
        unfinished.iter().any(|path| fs::remove_file(path).is_ok())
    };
    let mut merge = scratch.start("merge job.toml");
    while !removes() {
        assert!(merge.try_wait().unwrap().is_none(), "it ended before its map was seen");
    }
    let ended = merge.wait_with_output().unwrap();
    assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
    merges(&scratch, &reference);
}

/// Processes that make one map at the same time all end well.
#[test]
fn merges_at_the_same_time_all_end_well() {
    let scratch = scratch();
    let reference = reference(&scratch);
    for _ in 0..5 {
        let _ = fs::remove_file(scratch.path().join("map.h5"));
        drop(finishes(shard(&scratch, 1, 1)));
        let all: Vec<Child> = (0..3).map(|_| scratch.start("merge job.toml")).collect();
        for ended in all.into_iter().map(|merge| merge.wait_with_output().unwrap()) {
            assert!(ended.status.success(), "{}", String::from_utf8_lossy(&ended.stderr));
        }
    }
    merges(&scratch, &reference);
}

//! Stopped runs are resumed to the same map, however they were stopped.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};
use std::time::{Duration, Instant};

use crate::command::{Run, Says, Scratch, journal_bytes, journals, random, signal, wait_for_journals};
use crate::map_equal::{assert_same, contents, reference, scratch};
use slipmap::column::Method;
use slipmap::files::Existing;
use slipmap::friction::Law;
use slipmap::map::{Account, Control, Field, Grid, Plan, Queue, compute_tiles};
use slipmap::store::{Outcome, PartialMap, Provenance};

fn start(scratch: &Scratch, arguments: &[&str]) -> Child {
    scratch.start(&[&["run", "job.toml"], arguments].concat())
}

/// Waits until a run has added some of the 40 tiles, of about 25 kB each, to the `before` bytes of journals.
fn wait_for_tiles(scratch: &Scratch, before: u64) {
    wait_for_journals(scratch.path(), before + 100_000);
}

/// A run stopped by SIGKILL after its first tiles.
fn stopped(scratch: &Scratch) {
    let mut child = start(scratch, &["--threads", "1"]);
    wait_for_tiles(scratch, 0);
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(!scratch.path().join("map.h5").exists(), "killed too late for this test");
}

fn check(scratch: &Scratch, name: &str) {
    scratch.run(&["check", name]).ends_with(0);
}

/// Kills runs at random times, resumes each until it is complete, and compares every map.
fn kill_and_resume(kills: usize, seed: u64) {
    let scratch = scratch();
    let reference = reference(&scratch);
    let map = scratch.path().join("map.h5");
    let begun = Instant::now();
    scratch.run("run job.toml --threads 2").ends_with(0);
    let seconds = begun.elapsed().as_secs_f64();
    assert_same(&map, &reference);
    fs::remove_file(&map).unwrap();
    let resume = |threads| ["run", "job.toml", "--resume", "--threads", threads];
    let (mut killed, mut maps, mut state) = (0, 0, seed);
    while killed < kills {
        // Up to a fifth beyond the end: sealing and renaming are interrupted as well, and some runs finish.
        let child = start(&scratch, &resume("2")[2..]);
        std::thread::sleep(Duration::from_secs_f64(1.2 * seconds * random(&mut state)));
        signal_if_alive(child, &mut killed);
        if map.exists() {
            // After any interruption the resumed map is the same, and other files are removed.
            scratch.run(&resume("2")).ends_with(0);
            assert_eq!(scratch.names(), ["job.toml", "map.h5", "reference.h5"]);
            check(&scratch, "map.h5");
            assert_same(&map, &reference);
            fs::remove_file(&map).unwrap();
            maps += 1;
        }
    }
    scratch.run(&resume("1")).ends_with(0);
    assert_same(&map, &reference);
    println!("{killed} kills, {} maps, each equal to the uninterrupted one", maps + 1);
}

fn signal_if_alive(mut child: Child, killed: &mut usize) {
    if child.try_wait().unwrap().is_none() {
        *killed += 1;
    }
    let _ = child.kill();
    child.wait().unwrap();
}

#[test]
fn kills_leave_no_trace() {
    kill_and_resume(3, 1);
}

#[test]
#[ignore = "minutes: two hundred kills; cargo test --test program resume:: -- --ignored"]
fn two_hundred_kills_leave_no_trace() {
    kill_and_resume(200, 2);
}

/// Every method and every field, in four tiles of a column each.
fn everything() -> Plan {
    let nodes = vec![
        vec![0.05, 0.2],
        vec![0.1, 0.6],
        vec![0.1],
        vec![2.0],
        // A value at which proofs are cheap: the limits in epsilon of `validated` take hundreds of proofs.
        vec![0.25],
        vec![0.0, 0.4, 1.6],
    ];
    Plan::builder(Grid::new(Law::Stribeck, nodes).unwrap())
        .methods(Method::all())
        .fields(Field::ALL)
        .audit_cells(10)
        .proof_boxes(0)
        .tile_shape([1, 1, 1, 1, 1, 3])
        .build()
        .unwrap()
}

/// Computes at most `tiles` of the tiles that are missing from a map; returns their account.
fn add_tiles(map: &PartialMap, tiles: usize) -> (Account, usize) {
    let queue = Queue::new(map.found.tiles(), map.found.finished());
    let left = AtomicUsize::new(tiles);
    let take = |n: usize| n.checked_sub(1);
    let next = || left.fetch_update(Relaxed, Relaxed, take).ok().and_then(|_| queue.take());
    let control = Control { threads: Some(2), ..Control::default() };
    compute_tiles(map.plan(), map, &control, &next).unwrap()
}

#[test]
fn every_method_and_every_field_goes_on_where_it_stopped() {
    let (plan, provenance) = (everything(), Provenance::default());
    let folder = tempfile::tempdir().unwrap();
    let outcome = |account: Account| Outcome {
        attributes: vec![
            ("audit_cells".to_owned(), account.audit.cells.cast_signed().into()),
            ("audit_disagreements".to_owned(), (account.audit.disagreements.len() as i64).into()),
            ("rhs".to_owned(), account.rhs.cast_signed().into()),
        ],
        ..Outcome::default()
    };
    let whole = folder.path().join("whole.h5");
    let map = PartialMap::begin(&whole, &plan, &provenance, Existing::Refuse).unwrap();
    let (account, _) = add_tiles(&map, usize::MAX);
    map.finish(&outcome(account)).unwrap();

    let path = folder.path().join("map.h5");
    drop_after(&path, &plan, 1);
    drop_after(&path, &plan, 2);
    let map = PartialMap::resume(&path, &plan, &provenance, None).unwrap().unwrap();
    assert_eq!(map.tiles(), 3);
    let mut account = map.found.account.clone();
    account.add(add_tiles(&map, usize::MAX).0);
    map.finish(&outcome(account)).unwrap();
    assert_same(&path, &whole);
    let variables = contents(&path).into_keys().filter(|name| name.ends_with(" cells"));
    let names: Vec<String> = variables.collect();
    for start in
        ["verdict_validated", "verdict_fixed_step", "cycle_period", "kick_forward", "epsilon_limit_bendixson"]
    {
        assert!(names.iter().any(|name| name.starts_with(start)), "no {start} among {names:?}");
    }
}

/// Adds some tiles to a map and leaves it to a later run.
fn drop_after(path: &Path, plan: &Plan, tiles: usize) {
    let map = PartialMap::resume(path, plan, &Provenance::default(), None).unwrap().unwrap();
    add_tiles(&map, tiles);
}

#[test]
fn a_folder_that_disappears_during_a_run_is_reported() {
    let scratch = scratch();
    let away = ["--set", "output.path=\"away/map.h5\"", "--threads", "1"];
    let child = start(&scratch, &away);
    wait_for_journals(&scratch.path().join("away"), 100_000);
    fs::remove_dir_all(scratch.path().join("away")).unwrap();
    let run = Run::after(child).ends_with(1);
    run.err.says(&["away/map.h5.part.", " is gone"]);
    assert!(!run.err.contains("to continue"), "nothing is left to continue: {}", run.err);
    assert_eq!(scratch.names(), ["job.toml"]);
}

#[test]
fn an_interrupted_run_keeps_its_tiles_and_names_resume() {
    let scratch = scratch();
    let reference = reference(&scratch);
    for (number, (name, code)) in [("-INT", 130), ("-TERM", 143)].into_iter().enumerate() {
        let before = journal_bytes(scratch.path());
        let child = start(&scratch, &["--threads", "1", "--resume"]);
        wait_for_tiles(&scratch, before);
        signal(&child, name);
        let run = Run::after(child).ends_with(code);
        let way = "to continue: slipmap run job.toml --threads 1 --resume";
        run.err.says(&["tiles finished and kept", way]);
        assert_eq!(journals(scratch.path()).len(), number + 1);
    }
    let run = scratch.run("run job.toml --resume --json").ends_with(0);
    run.err.says(&["tiles finished"]);
    let summary = run.json();
    assert!(summary["resumed_tiles"].as_u64() > Some(0));
    assert_eq!(summary["audit"]["cells"], 50, "the audits of all runs count");
    assert_eq!(scratch.names(), ["job.toml", "map.h5", "reference.h5"]);
    check(&scratch, "map.h5");
    assert_same(&scratch.path().join("map.h5"), &reference);
    // The history lists every run.
    let map = slipmap::store::MapFile::open(&scratch.path().join("map.h5")).unwrap();
    let history = map.text("history").unwrap();
    assert_eq!(history.lines().count(), 3, "{history}");
    assert!(history.lines().skip(1).all(|line| line.contains("(resumed with")), "{history}");
}

#[test]
fn an_interrupted_run_is_neither_ignored_nor_overwritten() {
    let scratch = scratch();
    stopped(&scratch);
    let journal = &journals(scratch.path())[0];
    let before = fs::read(journal).unwrap();
    let help = ["map.h5.part.", "holds the finished tiles of an interrupted run", "--resume", "--overwrite"];
    scratch.run("run job.toml").refuses(&help);
    assert_eq!(fs::read(journal).unwrap(), before);
    scratch.run(&["check", &journal.to_string_lossy()]).refuses(&["a run that was interrupted", "--resume"]);
    scratch.run("run job.toml --resume --overwrite").refuses(&["--resume", "--overwrite"]);
    let small = ["--set", "grid.alpha=0.3", "--set", "grid.gamma.points=2"];
    scratch.run(&[&["run", "job.toml", "--overwrite"][..], &small].concat()).ends_with(0);
    assert_eq!(scratch.names(), ["job.toml", "map.h5"]);
}

#[test]
fn changed_plans_are_refused_and_shown() {
    let scratch = scratch();
    stopped(&scratch);
    let changed = |sets: &[&str], parts: &[&str]| {
        scratch.run(&[&["run", "job.toml", "--resume"], sets].concat()).refuses(parts);
    };
    changed(
        &["--set", "simulation.tolerance=1e-8"],
        &["map.h5.part.", " was begun as something else", "+ tolerance = 1e-8", "--overwrite"],
    );
    changed(&["--set", "grid.V=1.0"], &["- V = [0.5, 2.0]", "+ V = 1.0"]);
    // Changes that do not affect the map are allowed: its title, a comment, the spelling of its path, its
    // place.
    let commented = format!("# a thought\n{}", scratch.read("job.toml"));
    scratch.file("commented.toml", commented);
    fs::rename(&journals(scratch.path())[0], scratch.path().join("moved.h5.part.letters")).unwrap();
    let other = ["--set", "title=Another title", "--set", "output.path=./moved.h5"];
    let run = scratch.run(&[&["run", "commented.toml", "--resume"], &other[..]].concat()).ends_with(0);
    run.err.says(&["resuming with"]);
    let map = slipmap::store::MapFile::open(&scratch.path().join("moved.h5")).unwrap();
    assert_eq!(map.text("title"), Some("Another title"));
    assert!(map.text("config").unwrap().contains("# a thought"));
    fs::rename(scratch.path().join("moved.h5"), scratch.path().join("map.h5")).unwrap();
    // A finished map needs no resuming, but only if it is the requested one.
    scratch.run("run job.toml --resume").ends_with(0).err.says(&["is complete already"]);
    changed(&["--set", "grid.V=1.0"], &["map.h5 was begun as something else", "+ V = 1.0"]);
}

#[test]
fn damaged_tiles_are_reported_and_computed_again() {
    let scratch = scratch();
    let reference = reference(&scratch);
    stopped(&scratch);
    let journal = journals(scratch.path()).remove(0);
    let whole = fs::read(&journal).unwrap();
    let mut state = 3;
    for round in 0..2 {
        let mut bytes = whole.clone();
        // Within its tiles, not within its header.
        let place = 10_000 + (random(&mut state) * (bytes.len() - 10_000) as f64) as usize;
        match round % 2 {
            0 => bytes[place] ^= 1 << (place % 8),
            _ => bytes.truncate(place),
        }
        fs::write(&journal, &bytes).unwrap();
        let run = scratch.run("run job.toml --resume").ends_with(0);
        if round % 2 == 0 {
            assert!(run.err.contains("cut short or damaged"), "byte {place}: {}", run.err);
        }
        assert_same(&scratch.path().join("map.h5"), &reference);
        fs::remove_file(scratch.path().join("map.h5")).unwrap();
    }
}

#[test]
fn files_that_are_not_journals_are_not_changed() {
    let scratch = scratch();
    scratch.file("map.h5.part.mine", "notes of mine");
    // A journal whose header is lost: its tiles are computed again.
    stopped(&scratch);
    let journal = journals(scratch.path()).into_iter().find(|path| !path.ends_with("map.h5.part.mine"));
    let journal = journal.unwrap();
    let mut bytes = fs::read(&journal).unwrap();
    for place in (100..2_000).step_by(100) {
        bytes[place] ^= 1;
    }
    fs::write(journal, bytes).unwrap();
    scratch.run("run job.toml --resume").ends_with(0).err.says(&["cut short or damaged"]);
    check(&scratch, "map.h5");
    assert_eq!(scratch.read("map.h5.part.mine"), "notes of mine");
    assert_eq!(scratch.names(), ["job.toml", "map.h5", "map.h5.part"]);
}

#[test]
fn a_run_that_replaces_a_map_keeps_the_old_one_until_the_end() {
    let scratch = scratch();
    let small = ["--set", "grid.alpha=0.3", "--set", "grid.gamma.points=2"];
    scratch.run(&[&["run", "job.toml"][..], &small].concat()).ends_with(0);
    let map = scratch.path().join("map.h5");
    let old = fs::read(&map).unwrap();
    let child = start(&scratch, &["--overwrite", "--threads", "1"]);
    wait_for_tiles(&scratch, 0);
    signal(&child, "-INT");
    let run = Run::after(child).ends_with(130);
    run.err.says(&["to continue: slipmap run job.toml --threads 1 --resume"]);
    assert_eq!(fs::read(&map).unwrap(), old);
    scratch.run("run job.toml --resume").ends_with(0);
    assert_ne!(fs::read(&map).unwrap(), old);
    check(&scratch, "map.h5");
    assert_eq!(scratch.names(), ["job.toml", "map.h5"]);
}

/// Runs the program as an unprivileged user, if this process is privileged.
fn unprivileged(scratch: &Scratch, arguments: &[&str]) -> Run {
    let program = env!("CARGO_BIN_EXE_slipmap");
    let root = Command::new("id").arg("-u").output().is_ok_and(|id| id.stdout == b"0\n");
    let mut command = Command::new(if root { "setpriv" } else { program });
    if root {
        command.args(["--reuid=65534", "--regid=65534", "--clear-groups", program]);
    }
    Run::of(command.args(arguments).current_dir(scratch.path()).stdin(Stdio::null()).output().unwrap())
}

#[test]
fn a_read_only_folder_is_named() {
    let scratch = scratch();
    set_mode(scratch.path(), 0o555);
    let run = unprivileged(&scratch, &["run", "job.toml"]);
    set_mode(scratch.path(), 0o755);
    run.refuses(&["map.h5: cannot write into the folder .", "output.path"]);
    assert_eq!(scratch.names(), ["job.toml"]);
}

fn set_mode(path: &Path, mode: u32) {
    use std::os::unix::fs::PermissionsExt;
    fs::set_permissions(path, fs::Permissions::from_mode(mode)).unwrap();
}

/// Returns whether this machine lets a test mount a file system of its own.
fn can_mount() -> bool {
    let script = "d=$(mktemp -d) && mount -t tmpfs -o size=64k tmpfs \"$d\" && umount \"$d\"; rmdir \"$d\"";
    let mounted = Command::new("unshare").args(["-rm", "sh", "-c", script]).stderr(Stdio::null()).status();
    mounted.is_ok_and(|status| status.success())
}

/// Runs on a separate file system of `kib` KiB until it is full, then frees space and resumes. Prints the
/// exit code of the first run, its messages, the files that it left, and the exit code of the second run.
const FULL: &str = r#"
mkdir small && mount -t tmpfs -o size="$2"k tmpfs small && cp job.toml small && cd small || exit 1
"$1" run job.toml --threads 2 >../out 2>../err; echo $? >../code
ls >../left
mount -o remount,size=64m . && "$1" run job.toml --resume >../out2 2>../err2; echo $? >../code2
cp map.h5 ../full.h5
"#;

/// As [`FULL`], without a separate file system: with a limit on the size of each file.
const LIMITED: &str = r#"
mkdir small && cp job.toml small && cd small || exit 1
(trap '' XFSZ; ulimit -f $(($2 * 2)); exec "$1" run job.toml --threads 2 >../out 2>../err); echo $? >../code
ls >../left
"$1" run job.toml --resume >../out2 2>../err2; echo $? >../code2
cp map.h5 ../full.h5
"#;

/// Runs on full disks of random sizes.
fn fill_disks(runs: usize, seed: u64) {
    let scratch = scratch();
    let reference = reference(&scratch);
    // The journal contains the same data as the map, so together they take about twice its size.
    let kib = fs::metadata(&reference).unwrap().len() as f64 / 1024.0;
    let mount = can_mount();
    let (script, room) = if mount { (FULL, 2.0 * kib) } else { (LIMITED, kib) };
    let mut state = seed;
    for round in 0..runs {
        let size = (random(&mut state) * 0.99 * room) as u64;
        let program = env!("CARGO_BIN_EXE_slipmap");
        let mut shell = match mount {
            true => Command::new("unshare"),
            false => Command::new("sh"),
        };
        shell.args(if mount { &["-rm", "sh"][..] } else { &[] }).args(["-c", script, "sh", program]);
        let status = shell.arg(size.to_string()).current_dir(scratch.path()).status().unwrap();
        let (code, err) = (scratch.read("code"), scratch.read("err"));
        let what = format!("round {round}, {size} KiB, code {code}{err}{}", scratch.read("err2"));
        assert!(status.success(), "{what}");
        assert!(code == "1\n" || code == "2\n", "{what}");
        assert!(err.contains("no room left for") || err.contains("is free for"), "{what}");
        assert_eq!(err.matches("error:").count(), 1, "{what}");
        assert!(!scratch.read("left").lines().any(|name| name == "map.h5"), "{what}");
        if err.contains("no room left for") {
            assert!(err.contains("to continue: slipmap run job.toml --threads 2 --resume"), "{what}");
        }
        assert_eq!(scratch.read("code2"), "0\n", "{what}");
        assert_same(&scratch.path().join("full.h5"), &reference);
        fs::remove_dir_all(scratch.path().join("small")).unwrap();
    }
    println!("{runs} full disks ({})", if mount { "file systems of their own" } else { "limits on files" });
}

#[test]
fn full_disks_lose_nothing() {
    fill_disks(2, 4);
}

#[test]
#[ignore = "minutes: fifty full disks; cargo test --test program resume:: -- --ignored"]
fn fifty_full_disks_lose_nothing() {
    fill_disks(50, 5);
}

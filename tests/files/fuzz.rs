//! Parsers on damaged input, some thousand cases in each run: every reader of a file must end with an answer
//! or with an error. Inputs are valid ones with pieces changed, removed, doubled or inserted, which reach
//! more code than random bytes.

use std::collections::HashSet;
use std::path::Path;
use std::sync::atomic::AtomicBool;

use proptest::prelude::*;
use proptest::sample::Index;
use slipmap::config::{Job, PointTable};
use slipmap::files::Existing;
use slipmap::friction::Law;
use slipmap::map::{Control, Plan, Plane, PlaneCurves, Queue, Sink, compute_tiles};
use slipmap::store::{Journals, MapFile, PartialMap, Provenance, StoreError, check};

/// A valid configuration with every section.
const JOB: &str = "\
title = \"to be damaged\" # a comment
[friction]
law = \"stribeck\"
[grid]
epsilon = [0.05, 0.2]
alpha = { from = 0.0, to = 0.9, points = 3 }
beta = 0.1
gamma = { from = 0.5, to = 8.0, points = 4, spacing = \"log\" }
V = 1
c = [0.0, 0.2, 0.4, 1e0, 1_6.0]
[methods]
run = [\"symmetric\", \"simulation\", \"fixed_step\"]
[naive]
turns = 1
[simulation]
tolerance = 1e-9
[audit]
cells = 3
[output]
path = \"map.h5\"
fields = [\"verdict\", \"margin\", \"critical_c\", \"regime\"]
compression = 4
[work_precision]
near = 0.01
";

/// One change of some bytes.
#[derive(Clone, Debug)]
enum Change {
    Flip(Index, u8),
    Put(Index, Vec<u8>),
    Cut(Index, usize),
    Double(Index, usize),
    /// Replaces eight bytes, such as a length, by an extreme number.
    Number(Index, u64),
}

fn change() -> impl Strategy<Value = Change> {
    let words =
        "\0 [ { } = . - ' # é \\u \u{feff} \" \"\"\" 1e999 nan inf true 1979-05-27 99999999999999999999";
    let lines = ["\n", "[grid]\n", "points = 1000000", "{ from = 0"];
    let words = prop::sample::select(words.split(' ').chain(lines).collect::<Vec<_>>());
    prop_oneof![
        (any::<Index>(), 0..8u8).prop_map(|(at, bit)| Change::Flip(at, 1 << bit)),
        (any::<Index>(), words).prop_map(|(at, word)| Change::Put(at, word.as_bytes().to_vec())),
        (any::<Index>(), prop::collection::vec(any::<u8>(), 1..9)).prop_map(|(at, put)| Change::Put(at, put)),
        (any::<Index>(), 1..200usize).prop_map(|(at, length)| Change::Cut(at, length)),
        (any::<Index>(), 1..200usize).prop_map(|(at, length)| Change::Double(at, length)),
        (any::<Index>(), prop::sample::select(vec![0, 1, 1 << 31, 1 << 62, u64::MAX, u64::MAX / 16]))
            .prop_map(|(at, number)| Change::Number(at, number)),
    ]
}

/// The valid bytes with a few changes.
fn damaged(good: &[u8], changes: &[Change]) -> Vec<u8> {
    let mut bytes = good.to_vec();
    for change in changes {
        let at = |index: &Index| index.index(bytes.len().max(1)).min(bytes.len());
        match change {
            _ if bytes.is_empty() => {}
            Change::Flip(index, bit) => {
                let at = at(index);
                bytes[at] ^= bit;
            }
            Change::Put(index, put) => {
                let at = at(index);
                drop(bytes.splice(at..at, put.iter().copied()));
            }
            Change::Cut(index, length) => {
                let at = at(index);
                drop(bytes.drain(at..(at + length).min(bytes.len())));
            }
            Change::Double(index, length) => {
                let at = at(index);
                let part = bytes[at..(at + length).min(bytes.len())].to_vec();
                drop(bytes.splice(at..at, part));
            }
            Change::Number(index, number) => {
                let at = at(index);
                let end = (at + 8).min(bytes.len());
                bytes[at..end].copy_from_slice(&number.to_le_bytes()[..end - at]);
            }
        }
    }
    bytes
}

fn job(folder: &Path, contents: &[u8], sets: &[String]) -> Result<Job, String> {
    let path = folder.join("job.toml");
    std::fs::write(&path, contents).unwrap();
    Job::load(&path, sets).map_err(|error| error.to_string())
}

/// Files of valid runs, made once.
struct Good {
    folder: tempfile::TempDir,
    plan: Plan,
    journal: Vec<u8>,
    map: Vec<u8>,
}

fn compute(plan: &Plan, sink: &impl Sink<Error = StoreError>) {
    let queue = Queue::new(plan.tile_count(), HashSet::new());
    let control = Control { threads: Some(1), ..Control::default() };
    compute_tiles(plan, sink, &control, &|| queue.take()).unwrap();
}

fn good() -> Good {
    let folder = tempfile::tempdir().unwrap();
    let plan = job(folder.path(), JOB.as_bytes(), &[]).unwrap().plan;
    let plan = Plan { tile_shape: vec![1, 3, 1, 2, 1, 5], ..plan };
    let path = folder.path().join("map.h5");
    let map = PartialMap::begin(&path, &plan, &Provenance::default(), Existing::Refuse).unwrap();
    compute(&plan, &map);
    let journal = std::fs::read(&slipmap::store::journals(&path).unwrap()[0]).unwrap();
    // gamma and c.
    let plane = Plane::new(3, 5, vec![0; 6]);
    let curves = vec![PlaneCurves::of(&plan.grid, plane, &AtomicBool::new(false))];
    assert!(curves[0].points() > 0);
    map.finish(&slipmap::store::Outcome { curves, ..slipmap::store::Outcome::default() }).unwrap();
    let map = std::fs::read(&path).unwrap();
    std::fs::remove_file(path).unwrap();
    Good { folder, plan, journal, map }
}

fn runs(cases: u32) -> ProptestConfig {
    // Nothing is kept between runs; a failing input is printed.
    ProptestConfig { cases, failure_persistence: None, max_shrink_iters: 200, ..ProptestConfig::default() }
}

fn changes() -> impl Strategy<Value = Vec<Change>> {
    prop::collection::vec(change(), 1..6)
}

#[test]
fn configurations_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    job(folder.path(), JOB.as_bytes(), &[]).unwrap();
    proptest!(runs(1000), |(changes in changes(), set in "[a-zA-Z.]{0,12}=?[\\PC]{0,12}")| {
        for sets in [&[][..], &[set]] {
            if let Err(message) = job(folder.path(), &damaged(JOB.as_bytes(), &changes), sets) {
                prop_assert!(message.contains("help: "), "{message}");
                prop_assert!(message.len() < 4000, "{message}");
            }
        }
    });
}

/// A valid table of points, with everything that CSV allows.
const POINTS: &str = "\
name,epsilon,alpha,\"beta\",gamma,c,V,\"a note, quoted\"
first,0.1,0.3,0.1,2,0.5,1,
\"second \"\"point\"\"\",1e-3,.5,0,+4.0,0, 2 ,\"of two
lines\"
third,0.2,0.9,1e2,0.125,1e-300,7.5,\u{e9}
";

#[test]
fn tables_of_points_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("points.csv");
    // Number of rows read and of points parsed, or the error.
    let read = |bytes: &[u8]| -> Result<(usize, usize), String> {
        std::fs::write(&path, bytes).unwrap();
        let (mut table, law) =
            PointTable::open(&path, &Law::Stribeck, &[]).map_err(|error| error.to_string())?;
        let (mut rows, mut points) = (0, 0);
        loop {
            let batch = table.rows().map_err(|error| error.to_string())?;
            if batch.is_empty() {
                return Ok((rows, points));
            }
            for row in &batch {
                points +=
                    usize::from(table.point(row, &law).map_err(|error| error.to_string())?.damping >= 0.0);
            }
            rows += batch.len();
        }
    };
    assert_eq!(read(POINTS.as_bytes()), Ok((3, 3)));
    proptest!(runs(1000), |(changes in changes())| {
        match read(&damaged(POINTS.as_bytes(), &changes)) {
            Ok((rows, points)) => prop_assert_eq!(rows, points),
            Err(message) => {
                prop_assert!(message.contains("points.csv:") && message.contains("help: "), "{message}");
                prop_assert!(message.len() < 1000, "{message}");
            }
        }
    });
}

/// A valid table of measured friction.
const TABLE: &str = "\
# slip speed, friction
u,phi
0,1.0
0.5, 0.8
1,0.7
2,6.5e-1
4,0.6
";

#[test]
fn measured_laws_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("friction.csv");
    let read = |bytes: &[u8]| {
        std::fs::write(&path, bytes).unwrap();
        slipmap::config::Measured::read(&path, slipmap::config::How::default())?
            .table(slipmap::config::Level::One)
    };
    read(TABLE.as_bytes()).unwrap();
    proptest!(runs(1000), |(changes in changes())| {
        match read(&damaged(TABLE.as_bytes(), &changes)) {
            Ok(table) => prop_assert!(table.fastest() > 0.0 && table.fastest().is_finite()),
            Err((problem, remedy)) => {
                prop_assert!(problem.contains("friction.csv") && !remedy.is_empty(), "{problem}");
                prop_assert!(problem.len() < 4000, "{problem}");
            }
        }
    });
}

#[test]
fn journals_never_panic_and_never_make_another_map() {
    let good = good();
    let path = good.folder.path().join("map.h5");
    proptest!(runs(300), |(changes in changes())| {
        let journal = good.folder.path().join("map.h5.part.damaged");
        std::fs::write(&journal, damaged(&good.journal, &changes)).unwrap();
        // Tiles with a valid fingerprint are the original ones; all others are missing, or the journal is
        // refused.
        if let Ok(Some(found)) = Journals::beside(&path, &good.plan, &Provenance::default(), None) {
            prop_assert!(found.finished_tiles() <= found.tiles());
        }
        let _ = std::fs::remove_file(journal);
    });
}

#[test]
fn maps_never_panic() {
    let good = good();
    let path = good.folder.path().join("map.h5");
    proptest!(runs(300), |(changes in changes())| {
        let bytes = damaged(&good.map, &changes);
        std::fs::write(&path, &bytes).unwrap();
        if let Ok(report) = check(&path, &|_| {}) {
            prop_assert!(bytes == good.map || !report.is_sound(), "damage is found");
        }
        let _ = MapFile::open(&path);
    });
}

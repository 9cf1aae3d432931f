//! Measured friction: arbitrary bytes as the CSV of the law `table`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use slipmap::config::Job;
use tempfile::TempDir;

const JOB: &str = "
[friction]
law = \"table\"
file = \"friction.csv\"
[grid]
epsilon = 1.0
V = 0.3
c = [0.0, 0.1]
";

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| {
    let folder = TempDir::new().expect("a scratch folder");
    std::fs::write(folder.path().join("job.toml"), JOB).expect("room for a file");
    folder
});

fuzz_target!(|bytes: &[u8]| {
    std::fs::write(FOLDER.path().join("friction.csv"), bytes).expect("room for a file");
    let _ = Job::load(&FOLDER.path().join("job.toml"), &[]);
});

//! Configurations: arbitrary bytes as the file of `slipmap run`.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use slipmap::config::Job;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().expect("a scratch folder"));

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("job.toml");
    std::fs::write(&path, bytes).expect("room for a file");
    let _ = Job::load(&path, &[]);
});

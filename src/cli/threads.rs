//! The option `--threads`.

use std::fmt::Display;

use super::Failure;

/// Largest number of threads: more are a slip of the keyboard, on any machine.
const MOST: usize = 4096;

/// Number of cores of this machine.
pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Reads a number of threads.
pub(super) fn parse(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|threads| (1..=MOST).contains(threads));
    threads.ok_or_else(|| format!("this is not a number from 1 to {MOST}"))
}

/// The failure to start threads.
pub(super) fn not_started(error: impl Display) -> Failure {
    Failure::Broken(format!(
        "cannot start the threads: {error}\n  help: use fewer with --threads, or allow the program more threads \
         (ulimit -u) and memory (ulimit -v)"
    ))
}

//! The option `--threads`.

use std::fmt::Display;

use super::Failure;
use super::output::{bytes, number_of};

/// Largest useful number of threads per core: threads may wait for a disk, but thousands would slow a machine
/// down.
const MOST_PER_CORE: usize = 16;

/// Largest number of threads of a machine for which a run is estimated.
const MOST_ANYWHERE: usize = 100_000;

/// Number of cores of this machine.
pub(super) fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Reads a number of threads of this machine.
pub(super) fn parse(text: &str) -> Result<usize, String> {
    let most = MOST_PER_CORE * cores();
    let threads: usize = text.parse().map_err(|_| format!("this is not a number from 1 to {most}"))?;
    if (1..=most).contains(&threads) {
        return Ok(threads);
    }
    Err(format!("this machine has {}; choose from 1 to {most} threads", number_of(cores(), "core")))
}

/// Reads a number of threads of any machine.
pub(super) fn parse_anywhere(text: &str) -> Result<usize, String> {
    let threads = text.parse().ok().filter(|threads| (1..=MOST_ANYWHERE).contains(threads));
    threads.ok_or_else(|| format!("this is not a number from 1 to {MOST_ANYWHERE}"))
}

/// Refuses more threads than this machine should have.
pub(super) fn check(threads: Option<usize>) -> Result<(), Failure> {
    let text = threads.map_or_else(|| "1".to_owned(), |threads| threads.to_string());
    let help = "--dry-run estimates a run on a machine with more";
    parse(&text).map(drop).map_err(|why| Failure::bad_input(format!("--threads {text}: {why}"), help))
}

/// Least number of bytes of address space in which the program and its libraries work, most of it reserved and
/// not used, and for each core two stacks of threads. With 100 to 400 MB the HDF5 library crashed at some sizes.
const LEAST_MEMORY: u64 = 512 << 20;
const STACKS: u64 = 4 << 20;

/// Refuses a limit on the address space (`ulimit -v`) that is too low: libraries end the process without a
/// message where they get no memory.
pub(super) fn check_memory() -> Result<(), Failure> {
    // Only Linux has this file.
    let limits = std::fs::read_to_string("/proc/self/limits").unwrap_or_default();
    let limit = limits.lines().find_map(|line| line.strip_prefix("Max address space"));
    let limit: Option<u64> = limit.and_then(|limits| limits.split_whitespace().next()?.parse().ok());
    let least = LEAST_MEMORY + STACKS * cores() as u64;
    match limit.filter(|limit| *limit < least) {
        None => Ok(()),
        Some(limit) => Err(Failure::Broken(format!(
            "the system grants {} of address space, and slipmap needs {}\n  help: allow more (ulimit -v)",
            bytes(limit.into()),
            bytes(least.into())
        ))),
    }
}

/// The failure to start threads.
pub(super) fn not_started(error: impl Display) -> Failure {
    Failure::Broken(format!(
        "cannot start the threads: {error}\n  help: use fewer with --threads, or allow the program more threads \
         (ulimit -u) and memory (ulimit -v)"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_bounded_by_a_multiple_of_the_cores() {
        let most = MOST_PER_CORE * cores();
        assert_eq!(parse("1"), Ok(1));
        assert_eq!(parse(&most.to_string()), Ok(most));
        for refused in ["0", "65535", "-1", "two", "1.5", &(most + 1).to_string()] {
            assert!(parse(refused).is_err_and(|message| message.contains(&most.to_string())), "{refused}");
        }
        assert_eq!(parse_anywhere(&(most + 1).to_string()), Ok(most + 1));
        assert!(check(Some(most)).is_ok() && check(Some(most + 1)).is_err());
    }
}

//! The option `--threads`.

use super::output::number_of;

/// Largest useful number of threads per core: threads may wait for a disk, but thousands would slow a machine
/// down.
const MOST_PER_CORE: usize = 16;

/// Reads a number of threads.
pub(super) fn parse(text: &str) -> Result<usize, String> {
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let most = MOST_PER_CORE * cores;
    let threads: usize = text.parse().map_err(|_| format!("this is not a number from 1 to {most}"))?;
    if (1..=most).contains(&threads) {
        return Ok(threads);
    }
    let cores = number_of(cores, "core");
    Err(format!("this machine has {cores}; choose from 1 to {most} threads"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn threads_are_bounded_by_a_multiple_of_the_cores() {
        let most = MOST_PER_CORE * std::thread::available_parallelism().map_or(1, usize::from);
        assert_eq!(parse("1"), Ok(1));
        assert_eq!(parse(&most.to_string()), Ok(most));
        for refused in ["0", "65535", "-1", "two", "1.5", &(most + 1).to_string()] {
            assert!(parse(refused).is_err_and(|message| message.contains(&most.to_string())), "{refused}");
        }
    }
}

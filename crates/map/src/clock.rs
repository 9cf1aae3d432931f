//! Processor time, which other programs on the computer do not affect.

use std::time::Duration;

/// Processor time that this thread has used so far.
pub fn thread_time() -> Duration {
    #[cfg(unix)]
    return read(rustix::time::ClockId::ThreadCPUTime);
    #[cfg(not(unix))]
    return time_of_day();
}

/// Processor time that all threads of this process have used so far.
pub fn process_time() -> Duration {
    #[cfg(unix)]
    return read(rustix::time::ClockId::ProcessCPUTime);
    #[cfg(not(unix))]
    return time_of_day();
}

/// The result of `work`, and the processor seconds that this thread used for it.
pub(crate) fn timed<T>(work: impl FnOnce() -> T) -> (T, f64) {
    let start = thread_time();
    let result = work();
    (result, (thread_time() - start).as_secs_f64())
}

#[cfg(unix)]
fn read(clock: rustix::time::ClockId) -> Duration {
    let now = rustix::time::clock_gettime(clock);
    // Neither is negative, and nanoseconds are below a billion.
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or(0))
}

/// Wall-clock time, on systems without a clock of processor time; always zero where there is no clock.
#[cfg(not(unix))]
fn time_of_day() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;
    if cfg!(target_family = "wasm") {
        return Duration::ZERO;
    }
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

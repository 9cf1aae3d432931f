//! Processor time of the calling thread, so that other programs on the machine do not count.

use std::time::Duration;

/// Processor time that this thread has used so far.
#[cfg(unix)]
pub(super) fn processor_time() -> Duration {
    let now = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    // Neither is negative, nor a second more than a billion nanoseconds.
    Duration::new(now.tv_sec.unsigned_abs(), u32::try_from(now.tv_nsec).unwrap_or(0))
}

/// Elsewhere the time of day has to do.
#[cfg(not(unix))]
pub(super) fn processor_time() -> Duration {
    use std::sync::LazyLock;
    use std::time::Instant;
    static START: LazyLock<Instant> = LazyLock::new(Instant::now);
    START.elapsed()
}

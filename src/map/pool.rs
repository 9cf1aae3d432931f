//! Worker threads.

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

/// So many worker threads, or one per core.
pub(crate) fn pool(threads: Option<usize>) -> Result<ThreadPool, ThreadPoolBuildError> {
    ThreadPoolBuilder::new().num_threads(threads.unwrap_or(0)).build()
}

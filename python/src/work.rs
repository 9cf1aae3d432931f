//! Work without the GIL: on all cores, stopped by Ctrl-C, with reports of progress.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;

/// Interval between checks for signals and reports of progress.
const LOOK: Duration = Duration::from_millis(50);

/// Number of pieces of work up to which no threads are used.
pub(crate) const FEW: usize = 64;

/// Shared state of running work: the request to stop, and the progress.
#[derive(Default)]
pub(crate) struct Steering {
    /// Set when the work is to stop as soon as it can; what it returns then is thrown away.
    pub(crate) stop: AtomicBool,
    /// Pieces done.
    pub(crate) done: AtomicUsize,
}

impl Steering {
    pub(crate) fn stopped(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }

    pub(crate) fn advance(&self, pieces: usize) {
        self.done.fetch_add(pieces, Ordering::Relaxed);
    }
}

/// Runs `work` without the GIL, on a pool of threads that lives no longer than this call (all cores if
/// `threads` is `None`), so that nothing is left behind in the process. `progress` is called with the number
/// of pieces done.
///
/// # Errors
/// What a signal handler raises (`KeyboardInterrupt`), or `progress`.
pub(crate) fn run<T: Send>(
    py: Python<'_>,
    threads: Option<usize>,
    progress: Option<&Py<PyAny>>,
    work: impl FnOnce(&Steering) -> T + Send,
) -> PyResult<T> {
    let pool = rayon::ThreadPoolBuilder::new()
        .num_threads(threads.unwrap_or(0))
        .build()
        .map_err(|error| PyRuntimeError::new_err(format!("cannot start the threads: {error}")))?;
    let steering = &Steering::default();
    let tell = |py: Python<'_>| match progress {
        Some(progress) => progress.call1(py, (steering.done.load(Ordering::Relaxed),)).map(drop),
        None => Ok(()),
    };
    py.detach(|| {
        std::thread::scope(|scope| {
            let (sender, receiver) = channel();
            let worker = scope.spawn(move || {
                let _ = sender.send(pool.install(|| work(steering)));
            });
            let look = || Python::attach(|py| py.check_signals().and_then(|()| tell(py)));
            let outcome = loop {
                match receiver.recv_timeout(LOOK) {
                    Ok(result) => break look().map(|()| Some(result)),
                    Err(RecvTimeoutError::Timeout) => {
                        if let Err(error) = look() {
                            steering.stop.store(true, Ordering::Relaxed);
                            break Err(error);
                        }
                    }
                    Err(RecvTimeoutError::Disconnected) => break Ok(None),
                }
            };
            match (worker.join(), outcome?) {
                (Ok(()), Some(result)) => Ok(result),
                (Err(panic), _) => std::panic::resume_unwind(panic),
                (Ok(()), None) => Err(PyRuntimeError::new_err("the work ended without a result")),
            }
        })
    })
}

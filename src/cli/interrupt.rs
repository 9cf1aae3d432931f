//! Handles Ctrl-C and requests to terminate. The first signal requests the work to stop, so that it can keep
//! finished parts and remove unfinished files; work that does not stop in time is abandoned. The program ends
//! within two seconds whether it is computing, drawing, or waiting for the other end of a pipe.

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Set by the first signal.
static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// The exit code of that signal.
static CODE: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);
/// Cleanup and message for the case that the work is abandoned.
static ABANDONMENT: Mutex<Option<Abandonment>> = Mutex::new(None);

/// Message and cleanup of abandoned work.
struct Abandonment {
    left: String,
    tidy: Box<dyn FnOnce() + Send>,
}

/// Handled signals; the exit code of each is 128 plus its number.
const SIGNALS: &[i32] = &[
    SIGINT,
    SIGTERM,
    #[cfg(unix)]
    signal_hook::consts::SIGHUP,
];

/// Time limit for the work to stop by itself.
const STOP_LIMIT: Duration = Duration::from_millis(1300);
/// Time limit of the cleanup after abandoned work: a file system may not answer.
const CLEANUP_LIMIT: Duration = Duration::from_millis(500);
/// Interval between two checks for a signal.
const POLL_INTERVAL: Duration = Duration::from_millis(50);

/// Installs the handlers. A second signal ends the program at once.
pub(super) fn listen() {
    // A file at the limit on its size (ulimit -f) ends a process that does not handle this signal; one that
    // does gets an error, as from a full disk.
    #[cfg(unix)]
    drop(flag::register(signal_hook::consts::SIGXFSZ, Arc::default()));
    for &signal in SIGNALS {
        let code = 128 + signal;
        // In this order, so that the second signal finds the flag set by the first.
        let listening = flag::register_conditional_shutdown(signal, code, Arc::clone(&STOP))
            .and_then(|_| flag::register_usize(signal, Arc::clone(&CODE), code.unsigned_abs() as usize))
            .and_then(|_| flag::register(signal, Arc::clone(&STOP)));
        if let Err(error) = listening {
            // The results are not affected; only an interruption would leave a temporary file behind.
            super::say(&format!("warning: cannot listen for signal {signal}: {error}"));
        }
    }
}

/// The flag set by the first signal.
pub(super) fn flag() -> &'static AtomicBool {
    &STOP
}

/// Exit code of the signal that set the flag; 130 without one.
pub(super) fn code() -> u8 {
    u8::try_from(CODE.load(Ordering::SeqCst)).ok().filter(|&code| code > 0).unwrap_or(130)
}

/// Why the flag was set.
pub(super) fn reason() -> &'static str {
    if code() == TRY_AGAIN { "the time limit was reached" } else { "interrupted" }
}

/// Exit code of a run that has reached its time limit: EX_TEMPFAIL of sysexits.h, "run me again".
const TRY_AGAIN: u8 = 75;

/// Sets the flag after this time, as a signal would.
pub(super) fn after(limit: Duration) {
    let wait = move || {
        std::thread::sleep(limit);
        if CODE.compare_exchange(0, TRY_AGAIN.into(), Ordering::SeqCst, Ordering::SeqCst).is_ok() {
            STOP.store(true, Ordering::SeqCst);
        }
    };
    if let Err(error) = std::thread::Builder::new().spawn(wait) {
        super::say(&format!("warning: there is no time limit: {error}"));
    }
}

/// Sets the message (`left`: what remains of the work) and the cleanup (`tidy`) for the case that the work is
/// abandoned. Replaces earlier ones.
pub(super) fn on_abandonment(left: String, tidy: impl FnOnce() + Send + 'static) {
    *ABANDONMENT.lock().unwrap_or_else(PoisonError::into_inner) =
        Some(Abandonment { left, tidy: Box::new(tidy) });
}

/// Waits for the exit code of the work; `None` if the work has panicked. Ends the process if a signal came
/// and the work does not stop in time.
pub(super) fn wait(work: &Receiver<ExitCode>) -> Option<ExitCode> {
    let mut signalled = None;
    loop {
        match work.recv_timeout(POLL_INTERVAL) {
            Ok(code) => return Some(code),
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) if !STOP.load(Ordering::Relaxed) => {}
            Err(RecvTimeoutError::Timeout) => {
                let since = *signalled.get_or_insert_with(Instant::now);
                if since.elapsed() >= STOP_LIMIT {
                    give_up();
                }
            }
        }
    }
}

/// Cleans up and ends the process.
fn give_up() -> ! {
    let (done, tidied) = channel();
    // The cleanup has its own thread, because a file system that does not answer would block it for ever.
    let tidy = move || {
        let giving_up = ABANDONMENT.lock().unwrap_or_else(PoisonError::into_inner).take();
        let left = giving_up.as_ref().map_or(super::NOTHING_LEFT, |giving_up| &giving_up.left);
        // Print first: the cleanup may never return.
        super::say(&format!("{}; {left}", reason()));
        if let Some(Abandonment { tidy, .. }) = giving_up {
            tidy();
        }
        let _ = done.send(());
    };
    drop(std::thread::Builder::new().spawn(tidy));
    let _ = tidied.recv_timeout(CLEANUP_LIMIT);
    // Exit without destructors, which could block as well.
    signal_hook::low_level::exit(code().into());
}

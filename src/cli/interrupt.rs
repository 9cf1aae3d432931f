//! Ctrl-C and requests to terminate: they ask the work to stop, so that it can keep what is finished and
//! remove what is half written.

use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, LazyLock};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Raised by the first signal.
static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// The exit code of that signal.
static CODE: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);

/// The signals that are listened to; the exit code of each is 128 and its number.
const SIGNALS: &[i32] = &[
    SIGINT,
    SIGTERM,
    #[cfg(unix)]
    signal_hook::consts::SIGHUP,
];

/// Starts listening and returns the flag. A second signal ends the program at once.
pub(super) fn flag() -> &'static AtomicBool {
    for &signal in SIGNALS {
        let code = 128 + signal;
        // In this order: the second signal finds the flag raised by the first.
        let listening = flag::register_conditional_shutdown(signal, code, Arc::clone(&STOP))
            .and_then(|_| flag::register_usize(signal, Arc::clone(&CODE), code.unsigned_abs() as usize))
            .and_then(|_| flag::register(signal, Arc::clone(&STOP)));
        if let Err(error) = listening {
            // The work is still right; only an interruption would leave a temporary file behind.
            super::say(&format!("warning: cannot listen for signal {signal}: {error}"));
        }
    }
    &STOP
}

/// The exit code of the signal that raised the flag; 130 without one.
pub(super) fn code() -> u8 {
    u8::try_from(CODE.load(Ordering::SeqCst)).ok().filter(|&code| code > 0).unwrap_or(130)
}

//! Ctrl-C: asks the work to stop, so that it can remove what is half written.

use std::sync::atomic::{AtomicBool, Ordering};

/// Raised by Ctrl-C or a polite request to terminate.
static STOP: AtomicBool = AtomicBool::new(false);

/// Starts listening and returns the flag. A second Ctrl-C ends the program at once.
pub(super) fn flag() -> &'static AtomicBool {
    let listening = ctrlc::set_handler(|| {
        if STOP.swap(true, Ordering::SeqCst) {
            std::process::exit(130);
        }
    });
    if let Err(error) = listening {
        // The work is still right; only an interruption would leave a temporary file behind.
        super::say(&format!("warning: cannot listen for Ctrl-C: {error}"));
    }
    &STOP
}

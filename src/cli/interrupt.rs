//! Ctrl-C and requests to terminate. The first signal asks the work to stop, so that it can keep what is
//! finished and remove what is half written; work that does not stop in time is given up. Either way the
//! program ends within two seconds, whatever it is at: computing, drawing, or waiting for the other end of a
//! pipe.

use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Arc, LazyLock, Mutex, PoisonError};
use std::time::{Duration, Instant};

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::flag;

/// Raised by the first signal.
static STOP: LazyLock<Arc<AtomicBool>> = LazyLock::new(Arc::default);
/// The exit code of that signal.
static CODE: LazyLock<Arc<AtomicUsize>> = LazyLock::new(Arc::default);
/// What is to be done, and said, if the work is given up.
static GIVING_UP: Mutex<Option<GivingUp>> = Mutex::new(None);

/// What is left of the work, and what removes what must not be left.
struct GivingUp {
    left: String,
    tidy: Box<dyn FnOnce() + Send>,
}

/// The signals that are listened to; the exit code of each is 128 and its number.
const SIGNALS: &[i32] = &[
    SIGINT,
    SIGTERM,
    #[cfg(unix)]
    signal_hook::consts::SIGHUP,
];

/// Time that work has to stop by itself.
const PATIENCE: Duration = Duration::from_millis(1300);
/// Time that tidying up after work that was given up may take: a file system may not answer.
const TIDYING: Duration = Duration::from_millis(500);
/// Between two looks for a signal.
const LOOK: Duration = Duration::from_millis(50);

/// Starts listening. A second signal ends the program at once.
pub(super) fn listen() {
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
}

/// The flag that a signal raises.
pub(super) fn flag() -> &'static AtomicBool {
    &STOP
}

/// The exit code of the signal that raised the flag; 130 without one.
pub(super) fn code() -> u8 {
    u8::try_from(CODE.load(Ordering::SeqCst)).ok().filter(|&code| code > 0).unwrap_or(130)
}

/// Sets what is said and done if the work is given up: what is `left` of it, and how to `tidy` up. In place
/// of what was set before.
pub(super) fn on_giving_up(left: String, tidy: impl FnOnce() + Send + 'static) {
    *GIVING_UP.lock().unwrap_or_else(PoisonError::into_inner) = Some(GivingUp { left, tidy: Box::new(tidy) });
}

/// Waits for the exit code of the work; `None` if the work has panicked. Ends the process if a signal came
/// and the work does not stop in time.
pub(super) fn wait(work: &Receiver<ExitCode>) -> Option<ExitCode> {
    let mut signalled = None;
    loop {
        match work.recv_timeout(LOOK) {
            Ok(code) => return Some(code),
            Err(RecvTimeoutError::Disconnected) => return None,
            Err(RecvTimeoutError::Timeout) if !STOP.load(Ordering::Relaxed) => {}
            Err(RecvTimeoutError::Timeout) => {
                let since = *signalled.get_or_insert_with(Instant::now);
                if since.elapsed() >= PATIENCE {
                    give_up();
                }
            }
        }
    }
}

/// Ends the process.
fn give_up() -> ! {
    let (done, tidied) = channel();
    // In a thread of its own: a file system that does not answer would hold this one for ever.
    let tidy = move || {
        let giving_up = GIVING_UP.lock().unwrap_or_else(PoisonError::into_inner).take();
        let left = giving_up.as_ref().map_or(super::NOTHING_LEFT, |giving_up| &giving_up.left);
        // The message first: the disk may never answer.
        super::say(&format!("interrupted; {left}"));
        if let Some(GivingUp { tidy, .. }) = giving_up {
            tidy();
        }
        let _ = done.send(());
    };
    drop(std::thread::Builder::new().spawn(tidy));
    let _ = tidied.recv_timeout(TIDYING);
    // At once: cleaning up might wait for what is being waited for.
    signal_hook::low_level::exit(code().into());
}

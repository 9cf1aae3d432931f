//! The command-line program; its implementation is [`slipmap::cli`].

/// The system's allocator keeps what a thread has freed for that thread's successors. With new threads for
/// every picture, the memory of `slipmap explore` grew for as long as its page was used.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

/// Whether the process began with a standard output that takes no data. Before `main`, the standard library
/// puts /dev/null in the place of one that is closed, and no error tells of data that are lost there.
#[cfg(target_os = "linux")]
mod output {
    use rustix::fs::{OFlags, fcntl_getfl};
    use std::sync::atomic::{AtomicBool, Ordering};

    static IS_CLOSED: AtomicBool = AtomicBool::new(false);

    /// Called by the loader before the standard library begins.
    #[expect(
        unsafe_code,
        reason = "no safe code runs so early; `look` uses no part of the library that must begin first"
    )]
    #[used]
    #[unsafe(link_section = ".init_array")]
    static AT_THE_BEGINNING: extern "C" fn() = look;

    extern "C" fn look() {
        let flags = fcntl_getfl(rustix::stdio::stdout());
        let takes_data = flags.is_ok_and(|flags| flags & OFlags::RWMODE != OFlags::RDONLY);
        IS_CLOSED.store(!takes_data, Ordering::Relaxed);
    }

    pub(super) fn is_closed() -> bool {
        IS_CLOSED.load(Ordering::Relaxed)
    }
}

/// On other systems this is not known.
#[cfg(not(target_os = "linux"))]
mod output {
    pub(super) fn is_closed() -> bool {
        false
    }
}

fn main() -> std::process::ExitCode {
    slipmap::cli::main(output::is_closed())
}

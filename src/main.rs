//! The command-line program; its implementation is [`slipmap::cli`].

/// The system's allocator keeps what a thread has freed for that thread's successors. With new threads for
/// every picture, the memory of `slipmap explore` grew for as long as its page was used.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;

fn main() -> std::process::ExitCode {
    slipmap::cli::main()
}

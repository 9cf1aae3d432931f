//! The command-line program; everything it does is in [`slipmap::cli`].

fn main() -> std::process::ExitCode {
    slipmap::cli::main()
}

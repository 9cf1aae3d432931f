//! The command-line program. Data goes to standard output, progress and messages to standard error.
//!
//! Exit codes: 0 success; 1 the job ran but part of it failed; 2 bad input, with nothing written; 75 the time
//! limit was reached, run it again; 130 interrupted by Ctrl-C, 143 by a request to terminate; 141 the reader of
//! standard output closed it early.

mod chances;
mod check;
mod complete;
mod configuration;
mod estimate;
#[cfg(feature = "explore")]
mod explore;
mod failures;
mod fit;
mod init;
mod interrupt;
mod machine;
mod marks;
mod merge;
mod notes;
mod output;
mod plot;
mod point;
mod preflight;
mod probe;
mod probe_arguments;
mod probe_machine;
mod probe_table;
mod probe_text;
mod progress;
mod proof;
mod replace;
mod report;
mod run;
mod status;
mod summary;
mod threads;
mod width;
mod work_precision;

use std::fmt::Display;
use std::io::{self, Write as _};
use std::process::ExitCode;

use crate::GIT;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory as _, Parser, Subcommand};
use clap_complete::Shell;

use slipmap_config::ConfigError;
use slipmap_numbers::text::with_short_quotes;

/// Tells when a mass on a moving belt with dry friction stick-slips, how much damping ends it, and what of that
/// is proved.
#[derive(Debug, Parser)]
#[command(name = "slipmap", version = VERSION, max_term_width = 100, before_help = FIRST, after_help = EXIT_CODES)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
}

/// The version, and the commit.
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (git ", env!("SLIPMAP_GIT"), ")");
/// What certificates name as the program that wrote them.
const WRITTEN_BY: &str = concat!("slipmap ", env!("CARGO_PKG_VERSION"), " (git ", env!("SLIPMAP_GIT"), ")");

/// What one does first: the beginning of the help, and the answer to no arguments at all.
const FIRST: &str = "\
Three ways to begin:
  slipmap explore                                        see it: parameter space in the browser
  slipmap init machine && slipmap machine machine.toml   a machine, by its numbers in SI units
  slipmap init grid && slipmap run grid.toml             a map; then slipmap report grid.h5";

const EXIT_CODES: &str = "\
Exit codes: 0 ok, 1 the job ran but something in it failed, 2 bad input, 75 the time limit was reached,\n130 or 143 interrupted, 141 the reader of the output went away";

#[derive(Debug, Subcommand)]
enum Command {
    /// Write a commented configuration to start from
    Init(init::Arguments),
    /// Compute a map from a configuration file
    Run(run::Arguments),
    /// Make the map of what shards have computed
    Merge(merge::Arguments),
    /// Tell how far a map is
    Status(status::Arguments),
    /// Ask every method about one point, or about each row of a table
    Probe(probe::Arguments),
    /// Write tables and figures that compare the methods of a map
    Report(report::Arguments),
    /// Draw variables of a map
    Plot(plot::Arguments),
    /// Assess a machine at its working point, on one page
    Machine(machine::Arguments),
    /// Fit friction laws to measured friction
    Fit(fit::Arguments),
    /// Move through parameter space in the browser
    #[cfg(feature = "explore")]
    Explore(explore::Arguments),
    /// Compare every method with the simulated flow on a grid, and explain each failure
    Failures(failures::Arguments),
    /// Chart the speed of every method and engine against its accuracy
    WorkPrecision(work_precision::Arguments),
    /// Verify a map file, or a proof
    Check(check::Arguments),
    /// Print completions for a shell
    Completions(CompletionArguments),
}

/// Arguments of `slipmap completions`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap completions bash > ~/.local/share/bash-completion/completions/slipmap
  slipmap completions zsh > ~/.zfunc/_slipmap
  slipmap completions fish > ~/.config/fish/completions/slipmap.fish")]
struct CompletionArguments {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

/// Outcome of a command that was not stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Ended {
    /// Success.
    Fine,
    /// The job ran, but part of it failed; the report names the part.
    Flawed,
}

/// Reason why a command stopped.
#[derive(Debug)]
enum Failure {
    /// The input cannot be used; nothing was written.
    BadInput(String),
    /// The input is valid, but the job failed.
    Broken(String),
    /// The user interrupted it; the text states what remains.
    Interrupted(String),
    /// The reader of standard output closed it: a reason to stop without a message.
    ReaderGone,
}

impl Failure {
    /// Bad input: the problem, and what to do about it.
    fn bad_input(problem: impl Display, help: impl Display) -> Self {
        let problem = with_short_quotes(&problem.to_string());
        Failure::BadInput(format!("{problem}\n  help: {help}"))
    }
}

impl From<ConfigError> for Failure {
    fn from(error: ConfigError) -> Self {
        Failure::BadInput(error.to_string())
    }
}

/// Errors of writing to standard output; files have their own messages.
impl From<io::Error> for Failure {
    fn from(error: io::Error) -> Self {
        match error.kind() {
            io::ErrorKind::BrokenPipe => Failure::ReaderGone,
            _ => Failure::Broken(format!(
                "cannot write to standard output: {error}\n  help: free space where it goes, or send it elsewhere"
            )),
        }
    }
}

/// The definition of the command line.
#[must_use]
pub fn command() -> clap::Command {
    Arguments::command()
}

/// Stack size of the working thread in bytes: that of a process's first thread.
const STACK: usize = 8 << 20;

/// Runs the program on the arguments of the process.
#[must_use]
pub fn main() -> ExitCode {
    let command = match Arguments::try_parse() {
        Ok(arguments) => arguments.command,
        // What is wrong with the arguments; or help, the version.
        Err(told) => {
            if told.kind() == ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand
                && std::env::args_os().len() <= 1
            {
                say(&format!("{FIRST}\n\nAll commands: slipmap --help"));
                return ExitCode::from(2);
            }
            return match told.print().and_then(|()| io::stdout().flush()) {
                Err(error) if !told.use_stderr() => end(Err(error.into())),
                _ => ExitCode::from(u8::try_from(told.exit_code()).unwrap_or(2)),
            };
        }
    };
    interrupt::listen();
    // Begun here: where they are first needed, a failure to start them would be a panic.
    if let Err(error) = rayon::ThreadPoolBuilder::new().build_global() {
        return end(Err(threads::not_started(error)));
    }
    // The command runs in its own thread. The first thread only waits, so that it receives signals at once; a
    // thread that waits for a file system (a server that hangs) would not.
    let (done, ended) = std::sync::mpsc::channel();
    let work = std::thread::Builder::new().stack_size(STACK).spawn(move || {
        // The receiver is alive: it waits below.
        let _ = done.send(carry_out(command));
    });
    match work {
        Ok(work) => match (interrupt::wait(&ended), work.join()) {
            (_, Err(panic)) => std::panic::resume_unwind(panic),
            (code, Ok(())) => code.unwrap_or(ExitCode::FAILURE),
        },
        Err(error) => end(Err(threads::not_started(error))),
    }
}

fn carry_out(command: Command) -> ExitCode {
    let result = match command {
        Command::Init(arguments) => init::run(&arguments),
        Command::Run(arguments) => run::run(&arguments),
        Command::Merge(arguments) => merge::run(&arguments),
        Command::Status(arguments) => status::run(&arguments),
        Command::Probe(arguments) => probe::run(&arguments),
        Command::Report(arguments) => report::run(&arguments),
        Command::Plot(arguments) => plot::run(&arguments),
        Command::Machine(arguments) => machine::run(&arguments),
        Command::Fit(arguments) => fit::run(&arguments),
        #[cfg(feature = "explore")]
        Command::Explore(arguments) => explore::run(&arguments),
        Command::Failures(arguments) => failures::run(&arguments),
        Command::WorkPrecision(arguments) => work_precision::run(&arguments),
        Command::Check(arguments) => check::run(&arguments),
        Command::Completions(arguments) => completions(&arguments),
    };
    // What is left in the buffer would be lost without a word.
    end(result.and_then(|ended| Ok(io::stdout().flush().map(|()| ended)?)))
}

/// Prints the completions for a shell.
fn completions(arguments: &CompletionArguments) -> Result<Ended, Failure> {
    // The generator panics on write errors; writing to memory never fails.
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut command(), "slipmap", &mut text);
    io::stdout().lock().write_all(&text)?;
    Ok(Ended::Fine)
}

/// The exit code of a pipe whose reader is gone: that of the signal SIGPIPE, which ends other programs.
const READER_GONE: u8 = 128 + 13;

/// Reports what stopped a command, and returns the exit code.
fn end(result: Result<Ended, Failure>) -> ExitCode {
    let (code, message) = match result {
        Ok(Ended::Fine) => (0, None),
        Err(Failure::ReaderGone) => (READER_GONE, None),
        Ok(Ended::Flawed) => (1, None),
        Err(Failure::Broken(message)) => (1, Some(message)),
        Err(Failure::BadInput(message)) => (2, Some(message)),
        Err(Failure::Interrupted(left)) => {
            say(&format!("{}; {left}", interrupt::reason()));
            (interrupt::code(), None)
        }
    };
    if let Some(message) = message {
        say(&format!("error: {message}"));
    }
    ExitCode::from(code)
}

/// Message after an interruption of a command that writes only at its end.
const NOTHING_LEFT: &str = "nothing was written";

/// Writes a message to standard error. Nothing can be done if that is closed.
fn say(message: &str) {
    let _ = writeln!(io::stderr().lock(), "{}", output::without_control_characters(message));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_command_line_is_well_formed() {
        command().debug_assert();
    }
}

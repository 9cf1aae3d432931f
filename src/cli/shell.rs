//! `slipmap man` and `slipmap completions`, generated from the definition of the command line.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use clap::{Args, Command};
use clap_complete::Shell;

use super::report::unwritten;
use super::{Ended, Failure};

/// Arguments of `slipmap man`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap man | man -l -
  slipmap man probe > slipmap-probe.1
  slipmap man --out ~/.local/share/man/man1")]
pub(crate) struct ManArguments {
    /// The command whose page is printed; default: slipmap itself
    #[arg(value_name = "COMMAND", conflicts_with = "out")]
    command: Option<String>,
    /// Write the pages of slipmap and of all its commands into this folder, replacing earlier ones
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

/// Arguments of `slipmap completions`.
#[derive(Debug, Args)]
#[command(after_help = "\
Examples:
  slipmap completions bash > ~/.local/share/bash-completion/completions/slipmap
  slipmap completions zsh > ~/.zfunc/_slipmap
  slipmap completions fish > ~/.config/fish/completions/slipmap.fish")]
pub(crate) struct CompletionArguments {
    /// The shell
    #[arg(value_name = "SHELL")]
    shell: Shell,
}

fn page(command: &Command) -> io::Result<Vec<u8>> {
    let mut text = Vec::new();
    clap_mangen::Man::new(command.clone()).render(&mut text)?;
    Ok(text)
}

/// Prints one man page, or writes all of them.
pub(crate) fn man(mut program: Command, arguments: &ManArguments) -> Result<Ended, Failure> {
    // Gives each command's page its full name: `slipmap-run`, not `run`.
    program = program.disable_help_subcommand(true);
    program.build();
    if let Some(folder) = &arguments.out {
        return write_all(&program, folder);
    }
    let text = match &arguments.command {
        None => page(&program)?,
        Some(name) => match program.find_subcommand(name) {
            Some(command) => page(command)?,
            None => {
                let names: Vec<&str> = program.get_subcommands().map(Command::get_name).collect();
                let help = format!("the commands are {}", names.join(", "));
                return Err(Failure::bad_input(format!("there is no command `{name}`"), help));
            }
        },
    };
    io::stdout().lock().write_all(&text)?;
    Ok(Ended::Fine)
}

fn write_all(program: &Command, folder: &Path) -> Result<Ended, Failure> {
    fs::create_dir_all(folder).map_err(|error| unwritten(folder, &error))?;
    let write = |name: &str, command: &Command| {
        let path = folder.join(format!("{name}.1"));
        page(command).and_then(|text| fs::write(&path, text)).map_err(|error| unwritten(&path, &error))
    };
    write(program.get_name(), program)?;
    for command in program.get_subcommands() {
        write(&format!("{}-{}", program.get_name(), command.get_name()), command)?;
    }
    Ok(Ended::Fine)
}

/// Prints the completions for a shell.
pub(crate) fn completions(mut program: Command, arguments: &CompletionArguments) -> Result<Ended, Failure> {
    // The generator panics on write errors; writing to memory never fails.
    let mut text = Vec::new();
    clap_complete::generate(arguments.shell, &mut program, "slipmap", &mut text);
    io::stdout().lock().write_all(&text)?;
    Ok(Ended::Fine)
}

#[cfg(test)]
mod tests {
    use super::super::Arguments;
    use super::*;
    use clap::CommandFactory as _;

    #[test]
    fn the_definition_of_the_command_line_is_sound() {
        Arguments::command().debug_assert();
    }

    /// Every command and every long option, hidden ones left out.
    fn names(program: &Command) -> Vec<(String, Vec<String>)> {
        let options = |command: &Command| {
            let long = command.get_arguments().filter(|argument| !argument.is_hide_set());
            long.filter_map(|argument| argument.get_long().map(str::to_owned)).collect()
        };
        program.get_subcommands().map(|command| (command.get_name().to_owned(), options(command))).collect()
    }

    #[test]
    fn pages_name_every_command_and_option() {
        let folder = tempfile::tempdir().unwrap();
        let arguments = ManArguments { command: None, out: Some(folder.path().to_owned()) };
        man(Arguments::command(), &arguments).unwrap();
        // Roff writes a hyphen as `\-`.
        let read = |name: &str| fs::read_to_string(folder.path().join(name)).unwrap().replace('\\', "");
        let main = read("slipmap.1");
        for (command, options) in names(&Arguments::command()) {
            assert!(main.contains(&format!("slipmap-{command}(1)")), "{command}");
            let page = read(&format!("slipmap-{command}.1"));
            for option in options {
                assert!(page.contains(&format!("--{option}")), "{command} --{option}");
            }
        }
    }

    #[test]
    fn completions_name_every_command_and_option() {
        for shell in [Shell::Bash, Shell::Zsh, Shell::Fish] {
            let mut text = Vec::new();
            clap_complete::generate(shell, &mut Arguments::command(), "slipmap", &mut text);
            let text = String::from_utf8(text).unwrap();
            for (command, options) in names(&Arguments::command()) {
                assert!(text.contains(&command), "{shell}: {command}");
                for option in options {
                    assert!(text.contains(&option), "{shell}: {command} --{option}");
                }
            }
        }
    }
}

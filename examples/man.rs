//! Writes the man pages of slipmap and of each of its commands into a folder:
//! `cargo run --example man -- FOLDER`. `scripts/dist` puts them into the release archive.

use std::path::PathBuf;
use std::{env, fs, io};

fn main() -> io::Result<()> {
    let folder = PathBuf::from(env::args_os().nth(1).ok_or_else(|| io::Error::other("name a folder"))?);
    let mut program = slipmap::cli::command().disable_help_subcommand(true);
    // Gives each command's page its full name: `slipmap-run`, not `run`.
    program.build();
    let commands =
        program.get_subcommands().map(|command| (format!("slipmap-{}", command.get_name()), command));
    for (name, command) in commands.chain([("slipmap".to_owned(), &program)]) {
        let mut page = Vec::new();
        clap_mangen::Man::new(command.clone()).render(&mut page)?;
        fs::write(folder.join(format!("{name}.1")), page)?;
    }
    Ok(())
}

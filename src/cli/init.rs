//! `slipmap init`: writes a commented configuration to start from.

use std::path::Path;

use clap::{Args, ValueEnum};

use super::{Ended, Failure, say};
use slipmap_files::{Existing, WriteError, write_file};

/// Arguments of `slipmap init`.
#[derive(Debug, Args)]
#[command(after_help = "\
Writes grid.toml, machine.toml, or table.toml with table.csv into this folder. Each begins with the commands that use it.

Examples:
  slipmap init machine && slipmap machine machine.toml
  slipmap init grid && slipmap run grid.toml
  slipmap init table && slipmap machine table.toml")]
pub(super) struct Arguments {
    /// What to start from
    #[arg(value_name = "KIND", value_enum, default_value = "grid")]
    kind: Kind,
}

/// What a configuration describes.
#[derive(Clone, Copy, Debug, ValueEnum)]
enum Kind {
    /// A map over the parameters of a friction law, without units
    Grid,
    /// A machine in SI units, with coefficients of friction
    Machine,
    /// A machine in SI units, with measured friction
    Table,
}

impl Kind {
    /// The files: names and contents.
    fn files(self) -> &'static [(&'static str, &'static str)] {
        match self {
            Kind::Grid => &[("grid.toml", include_str!("init/grid.toml"))],
            Kind::Machine => &[("machine.toml", include_str!("init/machine.toml"))],
            Kind::Table => &[
                ("table.toml", include_str!("init/table.toml")),
                ("table.csv", include_str!("init/table.csv")),
            ],
        }
    }

    /// The command that answers first.
    fn next(self) -> &'static str {
        match self {
            Kind::Grid => "slipmap run grid.toml",
            Kind::Machine => "slipmap machine machine.toml",
            Kind::Table => "slipmap machine table.toml",
        }
    }
}

/// Writes the files, none of which may exist.
pub(super) fn run(arguments: &Arguments) -> Result<Ended, Failure> {
    let files = arguments.kind.files();
    if let Some((name, _)) = files.iter().find(|(name, _)| Path::new(name).symlink_metadata().is_ok()) {
        return Err(exists(name));
    }
    for (name, text) in files {
        write_file(text.as_bytes(), Path::new(name), Existing::Refuse).map_err(|error| match error {
            WriteError::Exists(_) => exists(name),
            error => Failure::bad_input(error.to_string(), "go to a folder that you may write into"),
        })?;
    }
    let names: Vec<&str> = files.iter().map(|(name, _)| *name).collect();
    say(&format!("wrote {}; next: {}", names.join(" and "), arguments.kind.next()));
    Ok(Ended::Fine)
}

fn exists(name: &str) -> Failure {
    Failure::bad_input(format!("{name} exists already"), format!("move it away: mv {name} my-{name}"))
}

//! The configuration of a command, with the values that replace some of its own.

use std::path::PathBuf;

use clap::Args;

use super::Failure;
use slipmap_config::Job;

#[derive(Debug, Args)]
pub(super) struct Configuration {
    /// The configuration
    #[arg(value_name = "CONFIG.toml")]
    pub(super) config: PathBuf,
    /// Replace one value of the configuration; may be repeated. The value is TOML; a bare word is text
    #[arg(long = "set", value_name = "key.path=value")]
    sets: Vec<String>,
}

impl Configuration {
    pub(super) fn load(&self) -> Result<Job, Failure> {
        Ok(Job::load(&self.config, &self.sets)?)
    }

    /// As on a command line.
    pub(super) fn words(&self) -> String {
        let sets = self.sets.iter().flat_map(|set| ["--set".to_owned(), quoted(set)]);
        std::iter::once(quoted(&self.config.to_string_lossy())).chain(sets).collect::<Vec<_>>().join(" ")
    }
}

/// A word of a command line, quoted for a shell where needed.
pub(super) fn quoted(text: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    match !text.is_empty() && text.chars().all(plain) {
        true => text.to_owned(),
        false => format!("'{}'", text.replace('\'', "'\\''")),
    }
}

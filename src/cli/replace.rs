//! The files of a command: an output is written where something is only with `--overwrite`, and never where anything lies
//! that the command reads, or writes besides.

use std::fmt::Display;
use std::path::{Path, PathBuf};

use super::Failure;
use slipmap_files::folder_of;
use slipmap_machine::{Friction, Machine};
use slipmap_model::friction::Law;

/// The files that a command reads, and those that it writes, by the options that name them.
#[derive(Default)]
pub(super) struct Files<'a> {
    reads: Vec<&'a Path>,
    writes: Vec<(&'a str, PathBuf)>,
}

impl<'a> Files<'a> {
    /// Files that are read.
    pub(super) fn reading<P: AsRef<Path> + ?Sized + 'a>(paths: impl IntoIterator<Item = &'a P>) -> Self {
        Self { reads: paths.into_iter().map(AsRef::as_ref).collect(), writes: Vec::new() }
    }

    /// The table of a law, if it is one.
    pub(super) fn law(mut self, law: &'a Law) -> Self {
        if let Law::Table(table) = law.as_written() {
            self.reads.push(Path::new(table.origin()));
        }
        self
    }

    /// The table of a machine's friction, if it is measured.
    pub(super) fn machine(mut self, machine: &'a Machine) -> Self {
        if let Friction::Measured(table) = &machine.friction {
            self.reads.push(Path::new(table.origin()));
        }
        self
    }

    /// A file that is written, if an option names one.
    pub(super) fn writing(mut self, option: &'a str, path: Option<&Path>) -> Self {
        self.writes.extend(path.map(|path| (option, path.to_owned())));
        self
    }

    /// Refuses an output that is a file of another kind, that is a device or a pipe, or where something exists that may not
    /// be replaced. A folder is refused when it is written to.
    pub(super) fn check(&self, overwrite: bool) -> Result<(), Failure> {
        let reads: Vec<PathBuf> = self.reads.iter().map(|path| place(path)).collect();
        for (number, (option, path)) in self.writes.iter().enumerate() {
            let (name, place_of_it) = (format!("{option} {}", path.display()), place(path));
            let help = "choose another name for what is written";
            if reads.contains(&place_of_it) {
                return Err(Failure::bad_input(format!("{name}: this is what is read"), help));
            }
            let same = self.writes[..number].iter().find(|(_, other)| place(other) == place_of_it);
            if let Some((other, _)) = same {
                return Err(Failure::bad_input(format!("{name}: what {other} names is written there"), help));
            }
            match path.symlink_metadata() {
                Err(_) => {}
                Ok(_) if !overwrite => return Err(exists(name)),
                Ok(it) if it.is_file() || it.is_dir() || it.is_symlink() => {}
                Ok(_) => {
                    let problem = format!("{name}: only files are replaced");
                    return Err(Failure::bad_input(problem, "choose another name"));
                }
            }
        }
        Ok(())
    }
}

/// Where a path leads, links followed; of what does not exist its name in its folder.
fn place(path: &Path) -> PathBuf {
    path.canonicalize().unwrap_or_else(|_| {
        let folder = folder_of(path);
        let folder = folder.canonicalize().unwrap_or_else(|_| folder.to_owned());
        path.file_name().map_or_else(|| folder.clone(), |name| folder.join(name))
    })
}

/// The failure for an output that exists already.
pub(super) fn exists(what: impl Display) -> Failure {
    let help = "choose another name, or add --overwrite to replace it";
    Failure::bad_input(format!("{what} exists already"), help)
}

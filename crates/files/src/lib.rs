//! Files and folders of every command: created in one step, and named only when they are complete; tables as CSV.

pub mod csv;
mod write;

pub use write::{WriteError, write_file, write_folder};

use std::ffi::OsStr;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};

use tempfile::NamedTempFile;
use tempfile::{PathPersistError, TempPath};

/// Behaviour if the output exists already.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Existing {
    /// Leave it and return an error.
    Refuse,
    /// Replace it at the very end, in one step.
    Replace,
}

/// The folder of a path, `.` for a bare name.
pub fn folder_of(path: &Path) -> &Path {
    path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."))
}

/// Forces the entry of `path` in its folder to disk. Where folders cannot be opened (not Unix) the system
/// does so itself.
///
/// # Errors
/// Those of the system.
pub fn sync_folder(path: &Path) -> io::Result<()> {
    match File::open(folder_of(path)) {
        Ok(folder) => folder.sync_all(),
        Err(_) => Ok(()),
    }
}

/// Creates a folder and its parents where they do not exist.
///
/// # Errors
/// The file system's reasons. For a folder that exists but does not answer (a dead mount) the system reports
/// that it exists; this function returns why it cannot be used.
pub fn create_folders(folder: &Path) -> io::Result<()> {
    fs::create_dir_all(folder).map_err(|error| match folder.metadata() {
        Err(reason) if error.kind() == io::ErrorKind::AlreadyExists => reason,
        _ => error,
    })
}

/// A temporary file in a folder, with the permissions of any new file. Other temporary files are readable by
/// their owner only.
pub fn temporary_in(folder: &Path) -> io::Result<NamedTempFile> {
    temporary(&folder.join(".slipmap-"))
}

/// As [`temporary_in`], with a name of `start` and random letters that no other file has.
pub fn temporary(start: &Path) -> io::Result<NamedTempFile> {
    let mut builder = tempfile::Builder::new();
    builder.prefix(start.file_name().unwrap_or_default()).rand_bytes(RANDOM_LETTERS);
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt as _;
        builder.permissions(fs::Permissions::from_mode(0o666));
    }
    builder.tempfile_in(folder_of(start))
}

/// Number of random letters in names of temporary files, of 62 kinds.
const RANDOM_LETTERS: usize = 12;

/// The files whose names begin as `start`, sorted.
///
/// # Errors
/// Why the folder cannot be listed.
pub fn named(start: &Path) -> io::Result<Vec<PathBuf>> {
    let folder = folder_of(start);
    let begins = |name: &OsStr| {
        let first = start.file_name().unwrap_or_default().as_encoded_bytes();
        name.as_encoded_bytes().starts_with(first)
    };
    let mut found = Vec::new();
    for entry in fs::read_dir(folder)? {
        let name = entry?.file_name();
        if begins(&name) {
            found.push(folder.join(name));
        }
    }
    found.sort();
    Ok(found)
}

/// Gives a complete temporary file its name.
///
/// # Errors
/// [`io::ErrorKind::AlreadyExists`] for a name that exists and is not to be replaced, or another I/O error.
pub fn publish_file(file: NamedTempFile, path: &Path, existing: Existing) -> io::Result<()> {
    publish(file.into_temp_path(), path, existing).map_err(|refused| refused.error)
}

/// Gives a complete and closed temporary file its name; or returns it with the error.
pub fn publish(file: TempPath, path: &Path, existing: Existing) -> Result<(), PathPersistError> {
    match existing {
        Existing::Replace => file.persist(path),
        Existing::Refuse => file.persist_noclobber(path).or_else(|refused| match refused.error.kind() {
            io::ErrorKind::AlreadyExists => Err(refused),
            _ if path.exists() => Err(refused),
            // On file systems where only renaming gives a name, it is checked before it is taken.
            _ => refused.path.persist(path),
        }),
    }
}

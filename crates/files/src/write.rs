//! Whole files, written in one step, with the reason where one is not.

use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use super::{Existing, create_folders, folder_of, publish_file, temporary_in};

/// Reason why a file is not written.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// It exists, and is not to be replaced.
    #[error("{0} exists already; choose another place, or ask for it to be replaced")]
    Exists(PathBuf),
    /// Its folder does not exist.
    #[error("{path}: there is no folder {folder}; create it, or choose another place")]
    NoFolder {
        /// The file.
        path: PathBuf,
        /// The folder.
        folder: PathBuf,
    },
    /// No file may be created in its folder.
    #[error("{path}: cannot write into the folder {folder}: {source}; choose a folder that is yours")]
    NotYours {
        /// The file.
        path: PathBuf,
        /// The folder.
        folder: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Another reason of the system.
    #[error("cannot write {path}: {source}")]
    Io {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
}

/// Moves files into `folder`: all of them, or none if anything fails before the last step, the
/// renaming.
///
/// # Errors
/// [`WriteError`].
pub fn write_folder(
    folder: &Path,
    existing: Existing,
    files: &[(PathBuf, Vec<u8>)],
) -> Result<(), WriteError> {
    if existing == Existing::Refuse && folder.symlink_metadata().is_ok() {
        return Err(WriteError::Exists(folder.to_path_buf()));
    }
    let parent = folder_of(folder);
    create(parent)?;
    let scratch = tempfile::Builder::new()
        .prefix(".slipmap-report-")
        .tempdir_in(parent)
        .map_err(|error| nothing_in(parent, folder, &error))?;
    for (name, contents) in files {
        let path = scratch.path().join(name);
        let put = create_folders(folder_of(&path)).and_then(|()| fs::write(path, contents));
        put.map_err(|source| WriteError::Io { path: folder.join(name), source })?;
    }
    // Nothing visible has changed up to here.
    for (name, _) in files {
        let (from, to) = (scratch.path().join(name), folder.join(name));
        create(folder_of(&to))?;
        fs::rename(&from, &to).map_err(|source| WriteError::Io { path: to, source })?;
    }
    Ok(())
}

fn create(folder: &Path) -> Result<(), WriteError> {
    create_folders(folder).map_err(|source| WriteError::Io { path: folder.to_path_buf(), source })
}

/// The error of a temporary file for `path` that could not be created in `folder`, which exists. The message
/// leaves out its name.
fn nothing_in(folder: &Path, path: &Path, error: &io::Error) -> WriteError {
    let path = path.to_path_buf();
    match error.kind() {
        // The folder exists, so these errors mean that no file may be created in it.
        kind @ (io::ErrorKind::PermissionDenied
        | io::ErrorKind::ReadOnlyFilesystem
        | io::ErrorKind::NotFound) => {
            WriteError::NotYours { path, folder: folder.to_path_buf(), source: kind.into() }
        }
        kind => WriteError::Io { path, source: kind.into() },
    }
}

/// Writes one file atomically.
///
/// # Errors
/// [`WriteError`].
pub fn write_file(contents: &[u8], path: &Path, existing: Existing) -> Result<(), WriteError> {
    let failed = |source: io::Error| match source.kind() {
        io::ErrorKind::AlreadyExists => WriteError::Exists(path.to_path_buf()),
        _ => WriteError::Io { path: path.to_path_buf(), source },
    };
    if existing == Existing::Refuse && path.symlink_metadata().is_ok() {
        return Err(WriteError::Exists(path.to_path_buf()));
    }
    let folder = folder_of(path);
    if !folder.is_dir() {
        return Err(WriteError::NoFolder { path: path.to_path_buf(), folder: folder.to_path_buf() });
    }
    let mut file = temporary_in(folder).map_err(|error| nothing_in(folder, path, &error))?;
    file.write_all(contents).map_err(failed)?;
    publish_file(file, path, existing).map_err(failed)
}

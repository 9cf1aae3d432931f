//! Errors of reading and writing map files.

use std::io;
use std::path::{Path, PathBuf};

use super::layout::Unfit;

/// Reason why a map could not be written or read. Messages name the file, the failure and, mostly, a remedy.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// This output exists already.
    #[error("{0} exists already; choose another name, or ask for it to be replaced")]
    Exists(PathBuf),
    /// An interrupted run has left finished tiles in this journal.
    #[error("{0} holds the finished tiles of an interrupted run")]
    Unfinished(PathBuf),
    /// This journal was whole when it was first read, and is not now.
    #[error("{0} changes while it is read: its disk or its memory fails")]
    Unreliable(PathBuf),
    /// The run to be resumed had another plan, another configuration or another version of the program.
    #[error("{path} was begun as something else (- then, + now):\n{difference}")]
    Changed {
        /// The journal, or the finished map.
        path: PathBuf,
        /// The difference, line by line.
        difference: String,
    },
    /// Another program created the output while the map was computed.
    #[error("{path} was made by something else during the run; the finished map is kept as {kept}")]
    Overtaken {
        /// The output.
        path: PathBuf,
        /// Path of the finished map.
        kept: PathBuf,
    },
    /// This folder of the output does not exist.
    #[error("the folder {0} of the output does not exist; create it, or choose another output path")]
    NoFolder(PathBuf),
    /// This journal was removed while its run wrote to it.
    #[error(
        "{0} is gone: it was removed, or its folder was unmounted or moved, while the run went on; should it \
         come back, its tiles can be resumed"
    )]
    Gone(PathBuf),
    /// The file system denies permission.
    #[error("no permission to {doing} {path}; choose a place that you may use, or change its permissions")]
    NoPermission {
        /// The action that failed.
        doing: String,
        /// The path that it failed on.
        path: PathBuf,
    },
    /// There is no room for this file: the disk is full, or a quota or a limit on the size of files is used
    /// up.
    #[error(
        "no room left for {0} (disk, quota or limit on file sizes); free space, write elsewhere, or \
         store fewer fields"
    )]
    DiskFull(PathBuf),
    /// The disk, or the network to it, no longer answers.
    #[error(
        "cannot {doing} {path}: the disk or the network that it lies on has failed or is gone ({source})"
    )]
    Lost {
        /// The action that failed.
        doing: String,
        /// The path that it failed on.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// Another failure of the file system.
    #[error("cannot {doing} {path}: {source}")]
    Io {
        /// The action that failed.
        doing: String,
        /// The path that it failed on.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A failure inside the HDF5 library.
    #[error("cannot {doing} {path}: {detail}")]
    Hdf5 {
        /// The action that failed.
        doing: String,
        /// The path that it failed on.
        path: PathBuf,
        /// The library's reason.
        detail: String,
    },
    /// The file is not a map that this version can read.
    #[error("{path} is not a map: {why}")]
    NotAMap {
        /// The file.
        path: PathBuf,
        /// The part that is missing or wrong.
        why: String,
    },
    /// The HDF5 library cannot open a file of this name.
    #[error("{0}: this name is not UTF-8, and HDF5 opens no other; rename the file, or its folder")]
    Name(PathBuf),
    /// The file has changed after the end of its run.
    #[error("{path} is damaged, and nothing of it is used: {what}")]
    Damaged {
        /// The map.
        path: PathBuf,
        /// The part that does not match its fingerprint.
        what: String,
    },
    /// The map has no such variable.
    #[error("{path} has no variable {name}; it has {available}")]
    NoVariable {
        /// The map.
        path: PathBuf,
        /// The requested variable.
        name: String,
        /// The variables of the map.
        available: String,
    },
    /// Tiles are missing.
    #[error(
        "{path} would be incomplete: {missing} of {tiles} tiles are missing, the first of them number {first}"
    )]
    Incomplete {
        /// The output.
        path: PathBuf,
        /// Number of missing tiles.
        missing: usize,
        /// Number of all tiles.
        tiles: usize,
        /// Number of the first missing tile.
        first: usize,
    },
}

impl StoreError {
    /// Whether a file is gone that was there.
    #[must_use]
    pub fn is_gone(&self) -> bool {
        match self {
            StoreError::Gone(_) => true,
            StoreError::Io { source, .. } => source.kind() == io::ErrorKind::NotFound,
            _ => false,
        }
    }

    /// Maps a failure of the file system to its variant.
    pub(super) fn io(doing: impl Into<String>, path: &Path, source: io::Error) -> Self {
        let (doing, path) = (doing.into(), path.to_path_buf());
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
                StoreError::DiskFull(path)
            }
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                StoreError::NoPermission { doing, path }
            }
            _ if is_loss(&source) => StoreError::Lost { doing, path, source },
            _ => StoreError::Io { doing, path, source },
        }
    }

    /// The error of a part of a file that cannot be used.
    pub(super) fn unfit(doing: impl Into<String>, path: &Path, unfit: Unfit) -> Self {
        match unfit {
            Unfit::Unreadable(error) => Self::hdf5(doing, path, &error),
            Unfit::Foreign(why) => StoreError::NotAMap { path: path.to_path_buf(), why },
        }
    }

    /// Maps a failure inside the HDF5 library to its variant; the library reports the system's errors only as
    /// text.
    pub(super) fn hdf5(doing: impl Into<String>, path: &Path, error: &hdf5::Error) -> Self {
        // The innermost message names the cause, the outermost the action of the library.
        let frames = error.stack();
        let messages: Vec<&str> =
            frames.iter().flat_map(|stack| stack.iter()).map(hdf5::ErrorFrame::description).collect();
        let says = |signs: &[&str]| messages.iter().any(|m| signs.iter().any(|sign| m.contains(sign)));
        let detail = if says(&["unable to lock file"]) {
            "another program holds the file, or its file system knows no locks \
             (then set HDF5_USE_FILE_LOCKING=FALSE)"
                .into()
        } else if says(&["truncated file"]) {
            "the file is cut short".into()
        } else if let Some(cause) = messages.iter().find_map(|message| system_error(message)) {
            return Self::io(doing, path, cause);
        } else if let hdf5::Error::Internal(reason) = error
            && !reason.contains("errorstack")
        {
            // Found without the library, such as a selection beyond the variable.
            reason.clone()
        } else {
            match (messages.first(), messages.last()) {
                (Some(outer), Some(inner)) if messages.len() > 1 => format!("{outer} ({inner})"),
                (Some(only), _) => (*only).into(),
                // Seen where the library finds too little memory to begin.
                _ => format!("{error}; the HDF5 library may need more memory (ulimit -v)"),
            }
        };
        StoreError::Hdf5 { doing: doing.into(), path: path.to_path_buf(), detail }
    }
}

/// Parses the system error that a message of the HDF5 library quotes:
/// `.., errno = 28, error message = '..', ..`.
fn system_error(message: &str) -> Option<io::Error> {
    let (_, rest) = message.split_once("errno = ")?;
    let digits = rest.split(|c: char| !c.is_ascii_digit()).next()?;
    digits.parse().ok().filter(|&number| number != 0).map(io::Error::from_raw_os_error)
}

/// Returns whether the disk or the network is gone: a server that does not answer, a file system whose
/// process has died, a disk that was pulled out.
fn is_loss(error: &io::Error) -> bool {
    use io::ErrorKind::{
        HostUnreachable, NetworkDown, NetworkUnreachable, NotConnected, StaleNetworkFileHandle, TimedOut,
    };
    let by_kind =
        [HostUnreachable, NetworkDown, NetworkUnreachable, NotConnected, StaleNetworkFileHandle, TimedOut];
    by_kind.contains(&error.kind()) || is_device_loss(error)
}

/// Errors of lost devices that have no [`io::ErrorKind`].
#[cfg(unix)]
fn is_device_loss(error: &io::Error) -> bool {
    use rustix::io::Errno;
    let of_devices = [Errno::IO, Errno::NXIO, Errno::NODEV, Errno::HOSTDOWN, Errno::CONNABORTED];
    error.raw_os_error().is_some_and(|number| of_devices.iter().any(|errno| errno.raw_os_error() == number))
}

/// On other systems only the kinds are known.
#[cfg(not(unix))]
fn is_device_loss(_: &io::Error) -> bool {
    false
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_reason_of_the_system_is_read_out_of_the_library() {
        let message = "file write failed: time = Sat Nov 21 18:51:18 2026\n, filename = 'a', file descriptor = 4, \
                       errno = 107, error message = 'Transport endpoint is not connected', buf = 0x7f";
        assert_eq!(system_error(message).unwrap().raw_os_error(), Some(107));
        for none in ["can't write", "errno = ", "errno = 0, error message = 'Success'"] {
            assert!(system_error(none).is_none(), "{none}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn lost_full_and_forbidden_disks_are_distinguished() {
        use rustix::io::Errno;
        let of = |errno: Errno| {
            StoreError::io("write", Path::new("a"), io::Error::from_raw_os_error(errno.raw_os_error()))
        };
        for errno in [Errno::IO, Errno::NOTCONN, Errno::STALE, Errno::TIMEDOUT, Errno::NODEV] {
            assert!(matches!(of(errno), StoreError::Lost { .. }), "{errno}");
        }
        for errno in [Errno::NOSPC, Errno::DQUOT, Errno::FBIG] {
            assert!(matches!(of(errno), StoreError::DiskFull { .. }), "{errno}");
        }
        for errno in [Errno::ACCESS, Errno::PERM, Errno::ROFS] {
            assert!(matches!(of(errno), StoreError::NoPermission { .. }), "{errno}");
        }
        assert!(matches!(of(Errno::NOENT), StoreError::Io { .. }));
    }
}

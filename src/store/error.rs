//! What can go wrong with a map file.

use std::io;
use std::path::{Path, PathBuf};

/// Why a map could not be written or read. Each message says which file, what happened, and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum StoreError {
    /// The output is there already.
    #[error("{path} exists already; choose another name, or ask for it to be replaced")]
    Exists {
        /// The output.
        path: PathBuf,
    },
    /// Another process is writing the same map.
    #[error(
        "another run is writing this map: it holds the lock on {path}; wait for it, or choose another output"
    )]
    Busy {
        /// The journal of the other run.
        path: PathBuf,
    },
    /// An interrupted run has left its finished tiles.
    #[error("{path} holds the finished tiles of an interrupted run")]
    Unfinished {
        /// The journal of that run.
        path: PathBuf,
    },
    /// Something else has the name that the journal of the run is to have.
    #[error("{path} is in the way, and is nothing that slipmap wrote; move it, or choose another output")]
    InTheWay {
        /// What is in the way.
        path: PathBuf,
    },
    /// The journal of a run is damaged beyond use.
    #[error("{path} is damaged so much that the interrupted run cannot be resumed")]
    Unusable {
        /// The journal.
        path: PathBuf,
    },
    /// What is to be resumed was something else.
    #[error("{path} was begun as something else (- then, + now):\n{difference}")]
    Changed {
        /// The journal, or the finished map.
        path: PathBuf,
        /// The difference, line by line.
        difference: String,
    },
    /// The output appeared while the map was computed.
    #[error("{path} was made by something else during the run; the finished map is kept as {kept}")]
    Overtaken {
        /// The output.
        path: PathBuf,
        /// Where the finished map is.
        kept: PathBuf,
    },
    /// The folder of the output is not there.
    #[error("the folder {folder} of the output does not exist; create it, or choose another output path")]
    NoFolder {
        /// The folder.
        folder: PathBuf,
    },
    /// The journal was removed while its run wrote to it.
    #[error("{path} is gone: it was removed, or its folder was unmounted or moved, while the run went on")]
    Gone {
        /// The journal.
        path: PathBuf,
    },
    /// The file system refuses.
    #[error("no permission to {doing} {path}; choose a place that you may use, or change its permissions")]
    NoPermission {
        /// What was tried.
        doing: &'static str,
        /// On what.
        path: PathBuf,
    },
    /// The disk is full, or a quota or a limit on the size of files is used up.
    #[error(
        "no room left for {path} (disk, quota or limit on file sizes); free space, write elsewhere, or \
         store fewer fields"
    )]
    DiskFull {
        /// The file being written.
        path: PathBuf,
    },
    /// Another failure of the file system.
    #[error("cannot {doing} {path}: {source}")]
    Io {
        /// What was tried.
        doing: &'static str,
        /// On what.
        path: PathBuf,
        /// The system's reason.
        source: io::Error,
    },
    /// A failure inside the HDF5 library.
    #[error("cannot {doing} {path}: {detail}")]
    Hdf5 {
        /// What was tried.
        doing: String,
        /// On what.
        path: PathBuf,
        /// The library's reason.
        detail: String,
    },
    /// The file is no map that this version can read.
    #[error("{path} is not a map: {why}")]
    NotAMap {
        /// The file.
        path: PathBuf,
        /// What is missing or wrong.
        why: String,
    },
    /// The file is not as it was when its run finished it.
    #[error("{path} is damaged, and nothing of it is used: {what}")]
    Damaged {
        /// The map.
        path: PathBuf,
        /// What does not match.
        what: String,
    },
    /// The map has no such variable.
    #[error("{path} has no variable {name}; it has {available}")]
    NoVariable {
        /// The map.
        path: PathBuf,
        /// What was asked for.
        name: String,
        /// What there is.
        available: String,
    },
    /// A selection lies outside a variable, or has the wrong number of axes.
    #[error("{path}: the selection {selection} does not fit {name}, whose shape is {shape}")]
    OutOfRange {
        /// The map.
        path: PathBuf,
        /// The variable.
        name: String,
        /// What was asked for.
        selection: String,
        /// What there is.
        shape: String,
    },
    /// Tiles are missing at the end of a run.
    #[error(
        "{path} would be incomplete: {missing} of {tiles} tiles were never written, the first of them number {first}"
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
    /// Cells are labelled "not computed" at the end of a run that did not announce any.
    #[error("{path} would be incomplete: {variable} has {cells} cells that were not computed")]
    NotComputed {
        /// The output.
        path: PathBuf,
        /// The variable.
        variable: String,
        /// Number of such cells.
        cells: u64,
    },
}

impl StoreError {
    /// Classifies a failure of the file system.
    pub(super) fn io(doing: &'static str, path: &Path, source: io::Error) -> Self {
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge => {
                StoreError::DiskFull { path }
            }
            io::ErrorKind::PermissionDenied | io::ErrorKind::ReadOnlyFilesystem => {
                StoreError::NoPermission { doing, path }
            }
            _ => StoreError::Io { doing, path, source },
        }
    }

    /// Classifies a failure inside the HDF5 library, which reports the system's reasons only in words.
    pub(super) fn hdf5(doing: impl Into<String>, path: &Path, error: &hdf5::Error) -> Self {
        let path = path.to_path_buf();
        // The innermost message tells the cause, the outermost what the library was doing.
        let frames = error.stack();
        let messages: Vec<&str> =
            frames.iter().flat_map(|stack| stack.iter()).map(hdf5::ErrorFrame::description).collect();
        let says = |signs: &[&str]| messages.iter().any(|m| signs.iter().any(|sign| m.contains(sign)));
        // ENOSPC, EDQUOT and EFBIG, in the words of the C library.
        if says(&["No space left on device", "Disk quota exceeded", "File too large"]) {
            return StoreError::DiskFull { path };
        }
        let detail = if says(&["unable to lock file"]) {
            "another program holds the file, or its file system knows no locks \
             (then set HDF5_USE_FILE_LOCKING=FALSE)"
                .into()
        } else if says(&["truncated file"]) {
            "the file is cut short".into()
        } else {
            match (messages.first(), messages.last()) {
                (Some(outer), Some(inner)) if messages.len() > 1 => format!("{outer} ({inner})"),
                (Some(only), _) => (*only).into(),
                _ => error.to_string(),
            }
        };
        StoreError::Hdf5 { doing: doing.into(), path, detail }
    }
}

//! A journal: the tiles that one process has computed, an append-only file of frames, each with its
//! fingerprint.
//!
//! ```text
//! frame = magic (8 bytes) | length u64 | tile u64 | SHA-256 of these and the contents (32 bytes) | contents
//! ```
//!
//! A process creates its journal under a name that no other file has, and it alone writes to it. Others read it
//! at any time, also while it grows; so there is nothing to lock. A frame is either whole or ignored: a reader
//! goes from frame to frame by their lengths, passes over frames that do not match their fingerprints, and
//! stops where no frame begins. A kill, a power cut or a full disk leaves a partial frame at the end, and a disk
//! may lose or mix up what was not yet forced to it.

use std::fs::{self, File};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use sha2::{Digest, Sha256};

use crate::files::{self, sync_folder};

use super::error::StoreError;
use super::seal::beside;

/// First bytes of every frame, and so of every journal. They contain line ends, as PNG's signature does.
const MAGIC: [u8; 8] = *b"\x89slip\r\n\x1a";

/// The first frame has this number in place of a tile's.
pub(super) const HEADER: u64 = u64::MAX;

/// Length in bytes of the part of a frame before its contents, and of the part of that before its SHA-256.
const HEAD: usize = 56;
const BEFORE_DIGEST: usize = 24;

/// What the names of journals have after that of the output, before random letters.
const NAME: &str = ".part.";

/// Time after which the next frame forces the journal to disk. It bounds the loss by a power cut.
const SYNC_EVERY: Duration = Duration::from_secs(10);

/// Whether a file is a journal. A pipe is not opened, since that would block.
pub fn is_journal(path: &Path) -> bool {
    let plain = path.symlink_metadata().is_ok_and(|metadata| metadata.is_file());
    let mut first = [0; MAGIC.len()];
    plain && File::open(path).is_ok_and(|mut file| file.read_exact(&mut first).is_ok()) && first == MAGIC
}

/// The journals of the map at `output`, sorted by name.
///
/// # Errors
/// Those of the file system.
pub fn journals(output: &Path) -> Result<Vec<PathBuf>, StoreError> {
    let mut found = files::named(&beside(output, NAME)?)?;
    found.retain(|path| is_journal(path));
    Ok(found)
}

/// Makes the part of a frame before its contents.
fn head(tile: u64, contents: &[u8]) -> [u8; HEAD] {
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&MAGIC);
    head[8..16].copy_from_slice(&(contents.len() as u64).to_le_bytes());
    head[16..24].copy_from_slice(&tile.to_le_bytes());
    let digest = Sha256::new().chain_update(&head[..BEFORE_DIGEST]).chain_update(contents).finalize();
    head[BEFORE_DIGEST..].copy_from_slice(&digest);
    head
}

/// A place of a frame in a journal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Frame {
    /// Number of the tile, or [`HEADER`].
    pub(super) tile: u64,
    /// Position of its first byte.
    pub(super) at: u64,
    /// Length of its contents in bytes.
    pub(super) length: u64,
}

impl Frame {
    /// Length in bytes.
    pub(super) fn bytes(self) -> u64 {
        HEAD as u64 + self.length
    }
}

/// The journal of this process.
#[derive(Debug)]
pub(super) struct Journal {
    pub(super) path: PathBuf,
    file: File,
    /// Length in bytes.
    end: u64,
    synced: Instant,
    /// Whether the file is kept when the journal is dropped: it holds a tile.
    keep: bool,
}

impl Journal {
    /// Creates a journal of the map at `output` with the contents of its header.
    ///
    /// # Errors
    /// Those of the file system.
    pub(super) fn create(output: &Path, header: &[u8]) -> Result<Self, StoreError> {
        let failed = |source| StoreError::io("write", output, source);
        let name = beside(output, NAME)?;
        let (file, path) = files::temporary(&name).and_then(|file| Ok(file.keep()?)).map_err(failed)?;
        let mut journal = Self { path, file, end: 0, synced: Instant::now(), keep: false };
        journal.append(HEADER, header)?;
        journal.sync()?;
        sync_folder(&journal.path).map_err(failed)?;
        Ok(journal)
    }

    /// Appends a frame; a tile keeps the journal when it is dropped.
    pub(super) fn append(&mut self, tile: u64, contents: &[u8]) -> Result<Frame, StoreError> {
        let bytes = [&head(tile, contents), contents].concat();
        let written = self.file.seek(SeekFrom::Start(self.end)).and_then(|_| self.file.write_all(&bytes));
        if let Err(source) = written {
            // Cut off the partial frame. If this fails too, readers ignore it.
            let _ = self.file.set_len(self.end);
            return Err(StoreError::io("write", &self.path, source));
        }
        let frame = Frame { tile, at: self.end, length: contents.len() as u64 };
        self.end += frame.bytes();
        self.keep |= tile != HEADER;
        if self.synced.elapsed() > SYNC_EVERY {
            self.sync()?;
        }
        Ok(frame)
    }

    /// Forces all frames to disk.
    ///
    /// # Errors
    /// [`StoreError::Gone`] if the journal was removed or its folder unmounted: later writes are lost.
    pub(super) fn sync(&mut self) -> Result<(), StoreError> {
        self.synced = Instant::now();
        if !still_there(&self.file, &self.path) {
            return Err(StoreError::Gone(self.path.clone()));
        }
        self.file.sync_data().map_err(|source| StoreError::io("write", &self.path, source))
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        if !self.keep {
            // Nothing more can be done if this fails.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Returns whether `path` still names the opened file.
#[cfg(unix)]
fn still_there(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    let same = |a: fs::Metadata, b: fs::Metadata| (a.dev(), a.ino()) == (b.dev(), b.ino());
    file.metadata().is_ok_and(|opened| path.symlink_metadata().is_ok_and(|named| same(opened, named)))
}

/// On other systems open files cannot be removed.
#[cfg(not(unix))]
fn still_there(_: &File, _: &Path) -> bool {
    true
}

/// A journal, open for reading.
#[derive(Debug)]
pub(super) struct Reader {
    file: File,
    /// Length of the file when it was opened; it may grow.
    pub(super) length: u64,
    next: u64,
    longest: u64,
}

impl Reader {
    /// Opens a journal whose frames have contents of at most `longest` bytes.
    pub(super) fn open(path: &Path, longest: u64) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file, length, next: 0, longest })
    }

    /// The next frame, by its first bytes alone; `None` where no frame begins or a frame is cut short.
    pub(super) fn next(&mut self) -> io::Result<Option<Frame>> {
        let rest = self.length - self.next;
        if rest < HEAD as u64 {
            return Ok(None);
        }
        let mut head = [0; BEFORE_DIGEST];
        self.file.seek(SeekFrom::Start(self.next))?;
        self.file.read_exact(&mut head)?;
        let frame = Frame { tile: number(&head[16..]), at: self.next, length: number(&head[8..16]) };
        if head[..8] != MAGIC || frame.length > self.longest.min(rest - HEAD as u64) {
            return Ok(None);
        }
        self.next += frame.bytes();
        Ok(Some(frame))
    }

    /// Number of bytes after the last frame.
    pub(super) fn rest(&self) -> u64 {
        self.length - self.next
    }

    /// Reads the contents of a frame into `buffer`; `None` if they do not match its fingerprint.
    pub(super) fn contents<'a>(
        &mut self,
        frame: Frame,
        buffer: &'a mut Vec<u8>,
    ) -> io::Result<Option<&'a [u8]>> {
        buffer.clear();
        self.file.seek(SeekFrom::Start(frame.at))?;
        (&self.file).take(frame.bytes()).read_to_end(buffer)?;
        let whole = buffer.len() as u64 == frame.bytes();
        Ok(match buffer.split_at_checked(HEAD) {
            Some((found, contents)) if whole && *found == head(frame.tile, contents) => Some(contents),
            _ => None,
        })
    }
}

/// The number whose bytes are the first eight, the lowest first.
fn number(bytes: &[u8]) -> u64 {
    bytes[..8].iter().rev().fold(0, |n, &byte| n << 8 | u64::from(byte))
}

//! The journal of a run: an append-only file of frames, each with its fingerprint.
//!
//! ```text
//! frame = magic (8 bytes) | length u64 | SHA-256 of magic, length and contents (32 bytes) | contents
//! ```
//!
//! A frame is either whole or ignored. A reopened journal is cut before the first frame that is not whole.
//! This removes a partial frame left by a kill, a power cut or a full disk, and a damaged frame with
//! everything after it. The journal is locked (`flock`) for as long as its process lives.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use fs4::TryLockError;
use sha2::{Digest, Sha256};

use crate::files::sync_folder;

use super::error::StoreError;

/// First bytes of every frame, and so of every journal. They contain line ends, as PNG's signature does.
pub(super) const MAGIC: [u8; 8] = *b"\x89slip\r\n\x1a";

/// Whether a file is the journal of an unfinished run. A pipe is not opened, since that would block.
pub fn is_journal(path: &Path) -> bool {
    if !path.is_file() {
        return false;
    }
    let mut first = [0; MAGIC.len()];
    File::open(path).is_ok_and(|mut file| file.read_exact(&mut first).is_ok()) && first == MAGIC
}

/// Length in bytes of a frame's header.
const HEAD: usize = 48;

/// Time after which the next frame forces the journal to disk. It bounds the loss by a power cut.
const SYNC_EVERY: Duration = Duration::from_secs(10);

/// Makes the header of a frame with these contents.
fn head(contents: &[u8]) -> [u8; HEAD] {
    let mut head = [0; HEAD];
    head[..8].copy_from_slice(&MAGIC);
    head[8..16].copy_from_slice(&(contents.len() as u64).to_le_bytes());
    let digest = Sha256::new().chain_update(&head[..16]).chain_update(contents).finalize();
    head[16..].copy_from_slice(&digest);
    head
}

/// A journal, locked and open for appending.
#[derive(Debug)]
pub(super) struct Journal {
    pub(super) path: PathBuf,
    file: File,
    /// Length in bytes.
    pub(super) end: u64,
    synced: Instant,
    /// Whether the journal is locked against other processes; false on file systems without locks.
    pub(super) locked: bool,
    /// Whether the file is kept when the journal is dropped: it holds a tile, or was not empty when opened.
    keep: bool,
}

impl Journal {
    /// Opens and locks the journal at `path`; creates an empty one if there is none.
    ///
    /// # Errors
    /// [`StoreError::Busy`] if a running process holds it; [`StoreError::InTheWay`] if the path is not a
    /// journal; otherwise the error of the file system.
    pub(super) fn open(path: &Path) -> Result<Self, StoreError> {
        let failed = |source| StoreError::io("write", path, source);
        loop {
            // Follow no links, and accept only regular files.
            if path.symlink_metadata().is_ok_and(|metadata| !metadata.is_file()) {
                return Err(StoreError::InTheWay(path.to_path_buf()));
            }
            let mut options = OpenOptions::new();
            let file =
                options.read(true).write(true).create(true).truncate(false).open(path).map_err(failed)?;
            let locked = match fs4::FileExt::try_lock(&file) {
                Ok(()) => true,
                Err(TryLockError::WouldBlock) => {
                    return Err(StoreError::Busy(path.to_path_buf()));
                }
                // File systems without locks (on some clusters): the caller checks `locked`.
                Err(TryLockError::Error(_)) => false,
            };
            if !still_there(&file, path) {
                continue; // The run that held the lock has just finished and removed it.
            }
            let mut first = Vec::new();
            let length = file.metadata().map_err(failed)?.len();
            (&file).take(MAGIC.len() as u64).read_to_end(&mut first).map_err(failed)?;
            // A kill within the first write leaves a partial or an empty magic, which is accepted too.
            if !MAGIC.starts_with(&first) {
                return Err(StoreError::InTheWay(path.to_path_buf()));
            }
            let (path, synced, keep) = (path.to_path_buf(), Instant::now(), length > 0);
            return Ok(Self { path, file, end: length, synced, locked, keep });
        }
    }

    pub(super) fn is_at(path: &Path) -> bool {
        path.symlink_metadata().is_ok_and(|metadata| metadata.is_file() && metadata.len() > 0)
    }

    pub(super) fn clear(&mut self) -> Result<(), StoreError> {
        self.file.set_len(0).map_err(|source| StoreError::io("write", &self.path, source))?;
        self.end = 0;
        self.keep = false;
        Ok(())
    }

    /// Appends a frame. `keep` keeps the journal when it is dropped.
    pub(super) fn append(&mut self, contents: &[u8], keep: bool) -> Result<(), StoreError> {
        let frame = [&head(contents), contents].concat();
        let written = self.file.seek(SeekFrom::Start(self.end)).and_then(|_| self.file.write_all(&frame));
        if let Err(source) = written {
            // Cut off the partial frame. If this fails too, the next start cuts it off.
            let _ = self.file.set_len(self.end);
            return Err(StoreError::io("write", &self.path, source));
        }
        self.end += frame.len() as u64;
        self.keep |= keep;
        if self.synced.elapsed() > SYNC_EVERY { self.sync() } else { Ok(()) }
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

    /// Forces the journal's entry in its folder to disk.
    pub(super) fn sync_name(&self) -> Result<(), StoreError> {
        sync_folder(&self.path).map_err(|source| StoreError::io("write", &self.path, source))
    }

    /// Calls `visit` with the contents of one frame after the other; it returns false to refuse a frame.
    /// Stops at the first frame that is partial, longer than `longest` bytes or refused, cuts off the rest
    /// (unless it is the whole journal), and returns the number of bytes of the rest. One frame at a time is
    /// in memory.
    pub(super) fn replay(
        &mut self,
        longest: u64,
        mut visit: impl FnMut(&[u8]) -> Result<bool, StoreError>,
    ) -> Result<u64, StoreError> {
        let path = self.path.clone();
        let failed = |source| StoreError::io("read", &path, source);
        let length = self.file.metadata().map_err(failed)?.len();
        let mut reader = BufReader::with_capacity(1 << 20, &self.file);
        reader.seek(SeekFrom::Start(0)).map_err(failed)?;
        let mut end = 0;
        let mut contents = Vec::new();
        while read_frame(&mut reader, longest.min(length - end), &mut contents).map_err(failed)?
            && visit(&contents)?
        {
            end += (HEAD + contents.len()) as u64;
        }
        drop(reader);
        let cut = length - end;
        if cut > 0 && end > 0 {
            self.file.set_len(end).map_err(|source| StoreError::io("write", &path, source))?;
        }
        self.end = end;
        Ok(cut)
    }

    /// Removes the journal: the map is finished, or nothing was computed.
    pub(super) fn remove(mut self) -> Result<(), StoreError> {
        self.keep = true; // so that dropping it does not remove it again
        fs::remove_file(&self.path).map_err(|source| StoreError::io("remove", &self.path, source))
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

/// Reads the contents of the next frame; returns whether it is whole, and at most `longest` bytes long.
fn read_frame(reader: &mut impl Read, longest: u64, contents: &mut Vec<u8>) -> io::Result<bool> {
    contents.clear();
    let mut found = Vec::with_capacity(HEAD);
    if reader.take(HEAD as u64).read_to_end(&mut found)? < HEAD {
        return Ok(false);
    }
    let length = found[8..16].iter().rev().fold(0, |n, &byte| n << 8 | u64::from(byte));
    Ok(length <= longest
        && reader.take(length).read_to_end(contents)? as u64 == length
        && found == head(contents))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn journal(folder: &tempfile::TempDir) -> Journal {
        Journal::open(&folder.path().join("map.h5.part")).unwrap()
    }

    fn frames(journal: &mut Journal) -> (Vec<Vec<u8>>, u64) {
        let mut found = Vec::new();
        let cut = journal.replay(1 << 20, |contents| {
            found.push(contents.to_vec());
            Ok(true)
        });
        (found, cut.unwrap())
    }

    /// Writes frames of several lengths, some of which contain the magic.
    fn written(journal: &mut Journal) -> Vec<Vec<u8>> {
        let all: Vec<Vec<u8>> = (0..5).map(|i| MAGIC.iter().copied().cycle().take(7 * i).collect()).collect();
        for contents in &all {
            journal.append(contents, true).unwrap();
        }
        all
    }

    #[test]
    fn every_cut_leaves_the_frames_before_it() {
        let folder = tempfile::tempdir().unwrap();
        let mut journal = journal(&folder);
        let all = written(&mut journal);
        let ends: Vec<u64> = all
            .iter()
            .scan(0, |end, contents| {
                *end += (HEAD + contents.len()) as u64;
                Some(*end)
            })
            .collect();
        let bytes = fs::read(&journal.path).unwrap();
        assert_eq!(bytes.len() as u64, ends[4]);
        for cut in 0..=bytes.len() {
            journal.file.set_len(0).unwrap();
            journal.file.seek(SeekFrom::Start(0)).unwrap();
            journal.file.write_all(&bytes[..cut]).unwrap();
            let whole = ends.iter().filter(|&&end| end <= cut as u64).count();
            let (found, lost) = frames(&mut journal);
            assert_eq!(found, all[..whole], "cut at {cut}");
            let end = if whole == 0 { 0 } else { ends[whole - 1] };
            assert_eq!(lost, cut as u64 - end);
            // Appending continues from there.
            journal.append(&[9; 9], true).unwrap();
            assert_eq!(frames(&mut journal).0.len(), whole + 1);
        }
    }

    #[test]
    fn a_flipped_byte_costs_its_frame_and_those_after_it() {
        let folder = tempfile::tempdir().unwrap();
        let mut journal = journal(&folder);
        let all = written(&mut journal);
        let bytes = fs::read(&journal.path).unwrap();
        let lengths = all.iter().map(|contents| HEAD + contents.len());
        let frame_of = lengths.enumerate().flat_map(|(frame, length)| std::iter::repeat_n(frame, length));
        for (place, frame) in frame_of.enumerate() {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1 << (place % 8);
            journal.file.set_len(0).unwrap();
            journal.file.seek(SeekFrom::Start(0)).unwrap();
            journal.file.write_all(&damaged).unwrap();
            let (found, cut) = frames(&mut journal);
            assert_eq!(found, all[..frame], "flip at {place}");
            assert!(cut > 0, "flip at {place}");
        }
    }

    #[test]
    fn a_second_opening_is_refused_until_the_first_is_closed() {
        let folder = tempfile::tempdir().unwrap();
        let first = journal(&folder);
        assert!(first.locked);
        let path = first.path.clone();
        assert!(matches!(Journal::open(&path), Err(StoreError::Busy { .. })));
        drop(first);
        Journal::open(&path).unwrap().remove().unwrap();
        assert!(!path.exists());
    }

    #[test]
    fn other_files_are_not_opened_as_journals() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("map.h5.part");
        fs::write(&path, "my notes").unwrap();
        assert!(matches!(Journal::open(&path), Err(StoreError::InTheWay { .. })));
        assert_eq!(fs::read_to_string(&path).unwrap(), "my notes");
        #[cfg(unix)]
        {
            let link = folder.path().join("link.part");
            std::os::unix::fs::symlink(folder.path().join("target"), &link).unwrap();
            assert!(matches!(Journal::open(&link), Err(StoreError::InTheWay { .. })));
            assert!(!folder.path().join("target").exists());
        }
    }
}

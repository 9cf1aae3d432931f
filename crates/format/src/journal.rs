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

use slipmap_files::{folder_of, sync_folder};

use super::error::StoreError;
use super::seal::beside;

/// First bytes of every frame, and so of every journal. They contain line ends, as PNG's signature does.
const MAGIC: [u8; 8] = *b"\x89slip\r\n\x1a";

/// The first frame has this number in place of a tile's.
pub(super) const HEADER: u64 = u64::MAX;

/// Length in bytes of the part of a frame before its contents, and of the part of that before its SHA-256.
const HEAD: usize = 56;
const BEFORE_DIGEST: usize = 24;

/// Longest contents of a frame in bytes. Longer ones are damaged lengths; a tile has far less.
const LONGEST: u64 = u32::MAX as u64;

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
    Ok(named_as_journals(output)?.filter(|path| is_journal(path)).collect())
}

/// The files that have the name of a journal of the map at `output`, sorted.
pub(super) fn named_as_journals(output: &Path) -> Result<impl Iterator<Item = PathBuf>, StoreError> {
    let start = beside(output, NAME)?;
    let listed = slipmap_files::named(&start);
    Ok(listed.map_err(|source| StoreError::io("list the folder", folder_of(&start), source))?.into_iter())
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
        let (file, path) =
            slipmap_files::temporary(&name).and_then(|file| Ok(file.keep()?)).map_err(failed)?;
        // As the output is given, not as the system knows it.
        let path = name.with_file_name(path.file_name().unwrap_or_default());
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
}

impl Reader {
    /// Opens a journal.
    pub(super) fn open(path: &Path) -> io::Result<Self> {
        let file = File::open(path)?;
        let length = file.metadata()?.len();
        Ok(Self { file, length, next: 0 })
    }

    /// The next frame, by its first bytes alone; `None` where no frame begins or a frame is cut short.
    pub(super) fn next(&mut self) -> io::Result<Option<Frame>> {
        let rest = self.length - self.next;
        if rest < HEAD as u64 {
            return Ok(None);
        }
        let mut head = [[0; 8]; BEFORE_DIGEST / 8];
        self.file.seek(SeekFrom::Start(self.next))?;
        self.file.read_exact(head.as_flattened_mut())?;
        let [magic, length, tile] = head;
        let frame =
            Frame { tile: u64::from_le_bytes(tile), at: self.next, length: u64::from_le_bytes(length) };
        if magic != MAGIC || frame.length > LONGEST.min(rest - HEAD as u64) {
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

#[cfg(test)]
mod tests {
    use super::*;
    use slipmap_numbers::random::Random;
    use tempfile::TempDir;

    /// A number below `n`.
    fn below(random: &mut Random, n: usize) -> usize {
        (random.bits() % n.max(1) as u64) as usize
    }

    /// Contents of several lengths, some of which contain the magic.
    fn contents(random: &mut Random, tile: usize) -> Vec<u8> {
        let length = [0, 7, 100, 700, 5000][below(random, 5)] + tile;
        MAGIC.iter().copied().chain(0..=255).cycle().skip(below(random, 8)).take(length).collect()
    }

    /// Frames with their contents.
    type Tiles = Vec<(Frame, Vec<u8>)>;

    /// A journal of `tiles` tiles, its frames, and its bytes.
    fn written(folder: &TempDir, random: &mut Random, tiles: usize) -> (PathBuf, Tiles, Vec<u8>) {
        let mut journal = Journal::create(&folder.path().join("map.h5"), b"a header").unwrap();
        let mut append = |tile| {
            let contents = contents(random, tile);
            (journal.append(tile as u64, &contents).unwrap(), contents)
        };
        let frames = (0..tiles).map(&mut append).collect();
        let path = journal.path.clone();
        drop(journal);
        let bytes = fs::read(&path).unwrap();
        (path, frames, bytes)
    }

    /// The whole tiles in a journal.
    fn read(path: &Path) -> Tiles {
        let mut reader = Reader::open(path).unwrap();
        let (mut found, mut buffer) = (Vec::new(), Vec::new());
        while let Some(frame) = reader.next().unwrap() {
            if let Some(contents) = reader.contents(frame, &mut buffer).unwrap() {
                found.push((frame, contents.to_vec()));
            }
        }
        found.split_off(usize::from(found.first().is_some_and(|(frame, _)| frame.tile == HEADER)))
    }

    #[test]
    fn a_journal_without_a_tile_ends_with_its_process() {
        let folder = tempfile::tempdir().unwrap();
        let (output, mut random) = (folder.path().join("map.h5"), Random(0));
        drop(Journal::create(&output, b"a header").unwrap());
        assert_eq!(journals(&output).unwrap(), Vec::<PathBuf>::new());
        let (one, ..) = written(&folder, &mut random, 1);
        let (two, ..) = written(&folder, &mut random, 1);
        let mut both = [one, two];
        both.sort();
        // Neither other files nor links are journals.
        fs::write(folder.path().join("map.h5.part.notes"), "my notes").unwrap();
        #[cfg(unix)]
        std::os::unix::fs::symlink(&both[0], folder.path().join("map.h5.part.link")).unwrap();
        assert_eq!(journals(&output).unwrap(), both);
        assert!(both.iter().all(|path| is_journal(path)));
    }

    #[test]
    fn a_flipped_byte_costs_its_frame() {
        let folder = tempfile::tempdir().unwrap();
        let (path, frames, bytes) = written(&folder, &mut Random(1), 5);
        for place in (frames[0].0.at as usize..bytes.len()).step_by(7) {
            let mut damaged = bytes.clone();
            damaged[place] ^= 1 << (place % 8);
            fs::write(&path, damaged).unwrap();
            let hit = frames.iter().rposition(|(frame, _)| frame.at <= place as u64).unwrap();
            let found = read(&path);
            // Where its length or its magic is hit, nothing after it is found.
            let head = place as u64 - frames[hit].0.at < 16;
            let expected =
                frames.iter().enumerate().filter(|(frame, _)| *frame < hit || !head && *frame != hit);
            assert_eq!(
                found,
                expected.map(|(_, frame)| frame.clone()).collect::<Vec<_>>(),
                "flip at {place}"
            );
        }
    }

    /// What a disk may hold after a power cut, if it was forced at `synced`: all before that; of what was written
    /// after it any pages, the others as zeros, to any length, the last page perhaps in part.
    fn crashed(bytes: &[u8], synced: usize, random: &mut Random) -> Vec<u8> {
        const PAGE: usize = 512;
        let length = synced + below(random, bytes.len() - synced + 1);
        let mut image = bytes[..length].to_vec();
        for page in (synced / PAGE)..length.div_ceil(PAGE) {
            if below(random, 3) == 0 {
                let end = length.min((page + 1) * PAGE);
                let from = (page * PAGE + below(random, 2) * below(random, PAGE)).max(synced).min(end);
                image[from..end].fill(0);
            }
        }
        image
    }

    /// A simulated disk: whatever it keeps of what was not forced to it, every tile before that is read as it was
    /// written, and no tile is read otherwise.
    #[test]
    fn what_is_on_disk_is_read_and_nothing_unwritten() {
        let folder = tempfile::tempdir().unwrap();
        let seeds = std::env::var("SLIPMAP_SEEDS").map_or(150, |seeds| seeds.parse().unwrap());
        let mut torn = 0;
        for seed in 0..seeds {
            let mut random = Random(seed);
            let tiles = 1 + below(&mut random, 20);
            let (path, frames, bytes) = written(&folder, &mut random, tiles);
            // Forced to disk after some frame, or at the beginning alone.
            let kept = below(&mut random, frames.len() + 1);
            let synced = frames.get(kept).map_or(bytes.len(), |(frame, _)| frame.at as usize);
            fs::write(&path, crashed(&bytes, synced, &mut random)).unwrap();
            let found = read(&path);
            assert!(
                found.starts_with(&frames[..kept]),
                "seed {seed}: a tile that was forced to disk is lost"
            );
            assert!(
                found.iter().all(|frame| frames.contains(frame)),
                "seed {seed}: a tile that was never written"
            );
            torn += usize::from(found.len() < frames.len());
            fs::remove_file(path).unwrap();
        }
        assert!(2 * torn > seeds as usize, "{torn} of {seeds} seeds lose something");
    }
}

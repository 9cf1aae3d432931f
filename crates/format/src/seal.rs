//! Publishes a finished map atomically: seals it, forces it to disk, then gives it its name.
//!
//! The seal is one line of text after the last byte of the HDF5 file: the SHA-256 of every byte before it.
//! HDF5 readers ignore it. It covers bytes that no checksum of HDF5 covers (unused bytes, the heap of
//! references, raw coordinates). A program that opens the map for writing removes it.

use std::fs::{File, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};
use tempfile::TempPath;

use slipmap_files::{Existing, folder_of, sync_folder};
use slipmap_map::dataset::hex;

use super::error::StoreError;

/// The seal's text before the 64 hexadecimal digits.
const LABEL: &str = "\nslipmap seal, sha256 of every byte before this line: ";

/// The message for a file whose seal does not match.
pub(super) const BROKEN: &str = "its bytes are not those that were sealed at the end of the run";

/// What the name of an unfinished map has after that of the output, before random letters.
pub(super) const UNFINISHED: &str = ".part-map.";

/// Length of the seal in bytes.
const LENGTH: u64 = LABEL.len() as u64 + 64 + 1;

/// State of a file's seal.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Seal {
    /// The seal matches: no byte has changed since the map was finished.
    Whole,
    /// The seal does not match: some byte has changed.
    Broken,
    /// The file has no seal.
    Missing,
    /// The file has a seal and is longer than was to be read.
    NotCompared,
}

/// Fingerprint of the next `length` bytes.
fn fingerprint(file: &mut File, length: u64) -> io::Result<String> {
    let mut hash = Sha256::new();
    let mut buffer = vec![0u8; 1 << 20];
    let mut left = length;
    while left > 0 {
        let part = usize::try_from(left).map_or(buffer.len(), |left| left.min(buffer.len()));
        file.read_exact(&mut buffer[..part])?;
        hash.update(&buffer[..part]);
        left -= part as u64;
    }
    Ok(hex(&hash.finalize()))
}

/// Appends the seal to a closed file and forces the file to disk.
pub(super) fn seal(path: &Path) -> io::Result<()> {
    let mut file = OpenOptions::new().read(true).write(true).open(path)?;
    let length = file.metadata()?.len();
    let digits = fingerprint(&mut file, length)?;
    file.seek(SeekFrom::End(0))?;
    file.write_all(format!("{LABEL}{digits}\n").as_bytes())?;
    file.sync_all()
}

/// Compares a file of at most `most` bytes with its seal.
fn verify(path: &Path, most: u64) -> io::Result<Seal> {
    let mut file = File::open(path)?;
    let Some(length) = file.metadata()?.len().checked_sub(LENGTH) else { return Ok(Seal::Missing) };
    file.seek(SeekFrom::Start(length))?;
    let mut line = Vec::new();
    file.read_to_end(&mut line)?;
    let Some(digits) = line.strip_prefix(LABEL.as_bytes()) else { return Ok(Seal::Missing) };
    if length > most {
        return Ok(Seal::NotCompared);
    }
    file.rewind()?;
    let expected = fingerprint(&mut file, length)? + "\n";
    Ok(if digits == expected.as_bytes() { Seal::Whole } else { Seal::Broken })
}

/// The state of a file's seal, determined without the HDF5 library. It is compared with at most `most` bytes.
pub(super) fn of(path: &Path, most: u64) -> Result<Seal, StoreError> {
    let failed = |source| StoreError::io("read", path, source);
    let kind = path.metadata().map_err(failed)?.file_type();
    // For a folder the later open gives the better message.
    if !kind.is_file() && !kind.is_dir() {
        // A pipe could block a reader, and a device may never end.
        let why = "it is a pipe or a device, not a file on a disk".into();
        return Err(StoreError::NotAMap { path: path.to_path_buf(), why });
    }
    verify(path, most).map_err(failed)
}

/// Path of a file beside `output`: the same name with `ending` appended.
pub(super) fn beside(output: &Path, ending: &str) -> Result<PathBuf, StoreError> {
    let folder = folder_of(output);
    let Some(name) = output.file_name() else {
        let source = io::Error::new(io::ErrorKind::InvalidInput, "the path names no file");
        return Err(StoreError::io("write", output, source));
    };
    match folder.metadata() {
        Ok(metadata) if metadata.is_dir() => {}
        Err(source) if source.kind() != io::ErrorKind::NotFound => {
            return Err(StoreError::io("use the folder", folder, source));
        }
        _ => return Err(StoreError::NoFolder(folder.to_path_buf())),
    }
    let mut own = name.to_os_string();
    own.push(ending);
    Ok(folder.join(own))
}

/// Gives the finished map its name and forces the name to disk.
pub(super) fn publish(map: TempPath, output: &Path, existing: Existing) -> Result<(), StoreError> {
    let failed = |source| StoreError::io("write", output, source);
    if let Err(refused) = slipmap_files::publish(map, output, existing) {
        if existing == Existing::Replace || output.symlink_metadata().is_err() {
            return Err(failed(refused.error));
        }
        // Keep the finished map: it is too expensive to lose.
        let kept = refused.path.keep().map_err(|error| failed(error.error))?;
        let kept = folder_of(output).join(kept.file_name().unwrap_or_default());
        return Err(StoreError::Overtaken { path: output.to_path_buf(), kept });
    }
    // The name is an entry of the folder, so the folder must be forced to disk as well.
    sync_folder(output).map_err(failed)
}

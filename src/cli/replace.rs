//! Decides which files `--overwrite` may replace: those of the kind that the command writes, and never the
//! command's own input.

use std::fmt::Display;
use std::io::{self, BufRead as _, Read as _};
use std::path::Path;

use super::Failure;

/// Largest number of bytes of a table's first line that are read.
const LONGEST_LINE: u64 = 1 << 16;

/// Kind of a file that may be replaced.
#[derive(Clone, Copy, Debug)]
pub(super) enum Kind {
    /// A figure, in the format of its file extension.
    Figure,
    /// A table with a column whose name begins with this text.
    Table(&'static str),
}

/// Refuses the place of an option where something exists, unless that may be replaced.
pub(super) fn refuse_existing(option: &str, path: &Path, overwrite: bool) -> Result<(), Failure> {
    match !overwrite && path.symlink_metadata().is_ok() {
        true => Err(exists(format!("{option} {}", path.display()))),
        false => Ok(()),
    }
}

/// The failure for an output that exists already.
pub(super) fn exists(what: impl Display) -> Failure {
    let help = "choose another name, or add --overwrite to replace it";
    Failure::bad_input(format!("{what} exists already"), help)
}

/// Refuses an existing output that is `input` or of another kind.
pub(super) fn check(output: &Path, input: Option<&Path>, kind: Kind) -> Result<(), Failure> {
    let name = output.display();
    let same = |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
    if input.is_some_and(|input| same(output, input)) {
        let problem = format!("--out {name}: this is what is read");
        return Err(Failure::bad_input(problem, "choose another name for what is written"));
    }
    let Ok(metadata) = output.symlink_metadata() else { return Ok(()) };
    // A folder is refused when it is written to. A pipe is never opened, since that could block for ever.
    let fits = match output.metadata() {
        _ if metadata.is_dir() => true,
        Ok(metadata) if metadata.is_file() => metadata.len() == 0 || begins(output, kind).unwrap_or(false),
        Ok(_) => false,
        // A dangling link may be replaced.
        Err(_) => metadata.is_symlink(),
    };
    let what = match kind {
        Kind::Figure => "a figure of its name's ending",
        Kind::Table(_) => "such a table",
    };
    match fits {
        true => Ok(()),
        false => Err(Failure::bad_input(
            format!("--out {name}: this is not {what}, and only those are replaced"),
            "move it away, or choose another name",
        )),
    }
}

/// Returns whether the file begins as files of its kind do.
fn begins(path: &Path, kind: Kind) -> io::Result<bool> {
    let mut file = io::BufReader::new(std::fs::File::open(path)?.take(LONGEST_LINE));
    match kind {
        Kind::Table(column) => {
            let mut line = String::new();
            file.read_line(&mut line)?;
            Ok(line.trim_end().split(',').any(|name| name.starts_with(column)))
        }
        Kind::Figure => {
            let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
            let first: &[u8] = match ending.as_deref() {
                Some("svg") => b"<svg",
                Some("png") => b"\x89PNG",
                Some("pdf") => b"%PDF",
                // An unknown extension is refused later, with a list of the known ones.
                _ => return Ok(true),
            };
            Ok(file.fill_buf()?.starts_with(first))
        }
    }
}

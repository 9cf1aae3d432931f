//! Decides whether an output may be written where something is: a file only with `--overwrite`, and never the
//! command's own input.

use std::fmt::Display;
use std::path::Path;

use super::Failure;

/// Refuses the place of an option that is the `input`, that is a device or a pipe, or where something exists that may
/// not be replaced. A folder is refused when it is written to.
pub(super) fn check(option: &str, path: &Path, input: Option<&Path>, overwrite: bool) -> Result<(), Failure> {
    let name = format!("{option} {}", path.display());
    let same = |a: &Path, b: &Path| a.canonicalize().is_ok_and(|a| b.canonicalize().is_ok_and(|b| a == b));
    if input.is_some_and(|input| same(path, input)) {
        let problem = format!("{name}: this is what is read");
        return Err(Failure::bad_input(problem, "choose another name for what is written"));
    }
    match path.symlink_metadata() {
        Err(_) => Ok(()),
        Ok(_) if !overwrite => Err(exists(name)),
        Ok(it) if it.is_file() || it.is_dir() || it.is_symlink() => Ok(()),
        Ok(_) => Err(Failure::bad_input(format!("{name}: only files are replaced"), "choose another name")),
    }
}

/// The failure for an output that exists already.
pub(super) fn exists(what: impl Display) -> Failure {
    let help = "choose another name, or add --overwrite to replace it";
    Failure::bad_input(format!("{what} exists already"), help)
}

//! Opens a map of unknown origin: verifies all of it before any of it is used.

use std::path::Path;

use super::check;
use super::curves;
use super::error::StoreError;
use super::reader::MapFile;
use super::seal::{self, Seal};
use super::trust;

impl MapFile {
    /// Opens the map at `path`, which may be any file. Refuses files that would take more memory or time than
    /// their length warrants, and files that changed after their run.
    ///
    /// The seal is checked first: every byte is read once, before the HDF5 library sees the file. A map that
    /// another program has written to or copied has no seal; then every cell and attribute is compared with
    /// its fingerprint.
    ///
    /// # Errors
    /// [`StoreError::NotAMap`] for a file that no version of this program wrote, or that this version cannot
    /// read; [`StoreError::Damaged`] for a map that was changed; otherwise the file system's or the library's
    /// reasons.
    pub fn open(path: &Path) -> Result<Self, StoreError> {
        let damaged = |what: String| StoreError::Damaged { path: path.to_path_buf(), what };
        let seal = seal::of(path)?;
        if seal == Seal::Broken {
            return Err(damaged(seal::BROKEN.into()));
        }
        let mut map = Self::open_layout(path)?;
        map.sealed = seal == Seal::Whole;
        for variable in &map.schema.variables {
            let dataset = map.dataset(&variable.name)?;
            trust::variable(&dataset, &map.schema, variable)
                .map_err(|unfit| StoreError::unfit(format!("read {} in", variable.name), path, unfit))?;
        }
        map.curves = curves::read(&map.file, &map.schema.grid, map.length)
            .map_err(|unfit| StoreError::unfit(format!("read {} in", curves::GROUP), path, unfit))?;
        match map.sealed {
            true => Ok(map),
            false => match check::contents(&map).problems.first() {
                None => Ok(map),
                Some(problem) => Err(damaged(problem.to_string())),
            },
        }
    }
}

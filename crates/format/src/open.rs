//! Opens a map of unknown origin: verifies the whole file before any part is used.

use std::path::Path;

use super::check;
use super::curves;
use super::error::StoreError;
use super::reader::MapFile;
use super::seal::{self, Seal};
use super::trust;

impl MapFile {
    /// Opens the map at `path`, which may be any file. Refuses files that would take memory or time out of
    /// proportion to their length, and files that changed after their run.
    ///
    /// The seal is checked first: every byte is read once, before the HDF5 library opens the file. A map that
    /// another program has written to or copied has no seal; then all cells and attributes are compared with
    /// their fingerprints.
    ///
    /// # Errors
    /// [`StoreError::NotAMap`] for a file that no version of this program wrote, or that this version cannot
    /// read; [`StoreError::Damaged`] for a map that was changed; otherwise the error of the file system or of
    /// the library.
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
            trust::variable(&dataset, &map.schema, variable, map.place())
                .map_err(|unfit| StoreError::unfit(format!("read {} in", variable.name), path, unfit))?;
        }
        map.curves = curves::read(&map.file, &map.schema.grid, map.place())
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

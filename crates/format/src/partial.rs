//! An unfinished map, which survives the end of its run and can be resumed.
//!
//! While the map is computed, two files lie beside the output `NAME`:
//!
//! - `NAME.part`, the journal: every finished tile with its account. A stopped run is resumed from it alone;
//! - `NAME.part-map`, the unfinished map itself. HDF5 guarantees nothing for a file whose process died while
//!   it wrote to the file, so a resumed run writes the map again from the journal.
//!
//! Both are removed when the map gets its name.

use std::fs;
use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use serde::{Deserialize, Serialize};

use crate::files::Existing;
use slipmap_map::dataset::{Outcome, Provenance, Schema, Value, attributes};
use slipmap_map::map::{Account, Plan, Sink, TileData};

use super::codec::{from_bytes, to_bytes};
use super::error::StoreError;
use super::identity::{check_finished, difference, get};
use super::journal::Journal;
use super::pack::{PackedTile, Packer};
use super::seal::{beside, temporary};
use super::writer::MapWriter;

/// Suffix of the journal's name.
const JOURNAL: &str = ".part";
/// Suffix of the unfinished map's name.
const UNFINISHED: &str = ".part-map";

/// Key in the journal's header of the flag that the run replaces an existing output.
const REPLACES: &str = "replaces";

/// Largest length of a header in bytes; a tile's frame may be longer.
const LONGEST_HEADER: u64 = 1 << 26;

/// The contents of a frame of the journal.
#[derive(Serialize, Deserialize)]
enum Frame<Tile, Of> {
    /// The plan of the run, as attributes. The first frame.
    Header(Vec<(String, Value)>),
    /// A start of the program: the line that it adds to the history.
    Session(String),
    /// A finished tile, the seconds from the start of the program to its end, and its account.
    Tile(Tile, f64, Of),
}

/// The contents of a frame; `None` for other bytes.
fn frame(bytes: &[u8]) -> Option<Frame<PackedTile, Account>> {
    from_bytes(bytes)
}

/// An unfinished map.
#[derive(Debug)]
pub struct PartialMap {
    // Fields are dropped in order: the map is closed and removed while the journal is still locked.
    map: MapWriter,
    journal: Mutex<Journal>,
    packer: Packer,
    started: Instant,
    /// What was found beside the output.
    pub found: Found,
    written: AtomicUsize,
}

/// The contents of an earlier run's journal.
#[derive(Debug)]
pub struct Found {
    finished: Vec<bool>,
    account: Account,
    /// Seconds that earlier runs took, up to their last finished tiles.
    pub seconds: f64,
    history: String,
    /// Number of bytes at the end of the journal that could not be used: a partial tile, or a damaged frame
    /// and all bytes after it. Tiles in these bytes are not among the finished ones.
    pub lost: u64,
}

impl Found {
    fn nothing(plan: &Plan, history: String) -> Self {
        Self {
            finished: vec![false; plan.grid.tile_count(&plan.tile_shape)],
            account: Account::none(plan),
            seconds: 0.0,
            history,
            lost: 0,
        }
    }
}

/// The result of resuming.
#[derive(Debug)]
pub enum Resumed {
    /// An unfinished map, perhaps without any finished tile.
    Partial(Box<PartialMap>),
    /// The finished map: nothing is left to compute.
    Complete,
}

impl PartialMap {
    /// Starts the map of `plan`.
    ///
    /// # Errors
    /// [`StoreError::Exists`] if the map exists already, [`StoreError::Unfinished`] if an interrupted run has
    /// left tiles, both unless they are to be replaced; [`StoreError::Busy`] if another process is writing
    /// the map; [`StoreError::InTheWay`] if the name of the journal is taken; otherwise the error of the file
    /// system or of the library.
    pub fn begin(
        path: &Path,
        plan: &Plan,
        provenance: &Provenance,
        existing: Existing,
    ) -> Result<Self, StoreError> {
        if existing == Existing::Refuse && path.symlink_metadata().is_ok() {
            return Err(StoreError::Exists(path.to_path_buf()));
        }
        let mut journal = Journal::open(&beside(path, JOURNAL)?)?;
        if existing == Existing::Refuse {
            let unfinished = || StoreError::Unfinished(beside(path, JOURNAL).unwrap_or_default());
            journal.replay(longest(plan), |bytes| match frame(bytes) {
                Some(Frame::Header(_) | Frame::Session(_)) => Ok(true),
                // A tile, or a frame of another version.
                Some(Frame::Tile(..)) | None => Err(unfinished()),
            })?;
        }
        let opening = attributes::opening(plan, provenance);
        let history = attributes::history(provenance);
        Self::fresh(path, plan, &opening, history, existing, journal)
    }

    /// Continues the map of an interrupted run. Starts a new map if there is neither a journal nor a map;
    /// returns [`Resumed::Complete`] if the map is finished.
    ///
    /// # Errors
    /// [`StoreError::Changed`] if the unfinished or finished map belongs to another plan, configuration or
    /// version of the program; [`StoreError::Busy`] if another process is writing the map;
    /// [`StoreError::Unusable`] if the journal's header is lost; otherwise as [`PartialMap::begin`].
    pub fn resume(path: &Path, plan: &Plan, provenance: &Provenance) -> Result<Resumed, StoreError> {
        let journal_path = beside(path, JOURNAL)?;
        let opening = attributes::opening(plan, provenance);
        if !Journal::is_at(&journal_path) {
            if path.symlink_metadata().is_err() {
                let begun = Self::begin(path, plan, provenance, Existing::Refuse)?;
                return Ok(Resumed::Partial(Box::new(begun)));
            }
            check_finished(path, &opening)?;
            return Ok(Resumed::Complete);
        }
        let journal = Journal::open(&journal_path)?;
        Self::replayed(path, plan, provenance, &opening, journal)
    }

    /// Reads the journal of an interrupted run into a new map.
    fn replayed(
        path: &Path,
        plan: &Plan,
        provenance: &Provenance,
        opening: &[(String, Value)],
        mut journal: Journal,
    ) -> Result<Resumed, StoreError> {
        let journal_path = journal.path.clone();
        let mut found = Found::nothing(plan, String::new());
        let mut map: Option<MapWriter> = None;
        let mut session_seconds = 0.0;
        let mut finished_already = false;
        let header_length = header(opening, "", Existing::Refuse).len() as u64;
        let length = journal.end;
        let lost = journal.replay(longest(plan), |bytes| match (frame(bytes), &map) {
            (None, _) | (Some(Frame::Header(_)), Some(_)) | (Some(Frame::Tile(..)), None) => Ok(false),
            (Some(Frame::Header(then)), None) => {
                if let Some(difference) = difference(&then, opening) {
                    return Err(StoreError::Changed { path: journal_path.clone(), difference });
                }
                let replaces = get(&then, REPLACES) == Some(&Value::from(1));
                let existing = if replaces { Existing::Replace } else { Existing::Refuse };
                if !replaces && path.symlink_metadata().is_ok() {
                    // The earlier run finished the map, and was stopped before it removed the journal.
                    check_finished(path, opening)?;
                    finished_already = true;
                }
                if let Some(Value::Text(history)) = get(&then, "history") {
                    found.history.clone_from(history);
                }
                let temporary = temporary(beside(path, UNFINISHED)?)?;
                // The map gets the title, the comments and the paths of this run, not of the earlier one.
                map =
                    Some(MapWriter::begin(path, temporary, plan, opening, found.history.clone(), existing)?);
                Ok(true)
            }
            (Some(Frame::Session(line)), _) => {
                found.seconds += std::mem::take(&mut session_seconds);
                found.history = format!("{}\n{line}", found.history);
                Ok(true)
            }
            (Some(Frame::Tile(tile, seconds, account)), Some(map)) => {
                if !(tile.fits(&map.schema) && account.fits(plan)) {
                    return Ok(false);
                }
                let number = tile.number;
                if !found.finished[number] {
                    map.put(tile)?;
                    found.finished[number] = true;
                    found.account.add(account);
                }
                session_seconds = seconds;
                Ok(true)
            }
        })?;
        if finished_already {
            drop(map);
            journal.remove()?;
            return Ok(Resumed::Complete);
        }
        let Some(mut map) = map else {
            // If the run was stopped before its header was written, a new start loses nothing.
            if length > header_length + 4096 {
                return Err(StoreError::Unusable(journal_path));
            }
            let history = attributes::history(provenance);
            let begun = Self::fresh(path, plan, opening, history, Existing::Refuse, journal)?;
            return Ok(Resumed::Partial(Box::new(begun)));
        };
        found.seconds += session_seconds;
        found.lost = lost;
        let tiles = found.finished.iter().filter(|finished| **finished).count();
        let line = format!(
            "{} (resumed with {tiles} of {} tiles)",
            attributes::history(provenance),
            found.finished.len()
        );
        found.history = format!("{}\n{line}", found.history);
        journal.append(&to_bytes(&Frame::<PackedTile, Account>::Session(line)), false)?;
        map.history.clone_from(&found.history);
        Ok(Resumed::Partial(Box::new(Self::with(map, journal, plan, found))))
    }

    /// Starts a map with an empty journal.
    fn fresh(
        path: &Path,
        plan: &Plan,
        opening: &[(String, Value)],
        history: String,
        existing: Existing,
        mut journal: Journal,
    ) -> Result<Self, StoreError> {
        journal.clear()?;
        let temporary = temporary(beside(path, UNFINISHED)?)?;
        let map = MapWriter::begin(path, temporary, plan, opening, history.clone(), existing)?;
        journal.append(&header(opening, &history, existing), false)?;
        journal.sync()?;
        journal.sync_name()?;
        Ok(Self::with(map, journal, plan, Found::nothing(plan, history)))
    }

    fn with(map: MapWriter, journal: Journal, plan: &Plan, found: Found) -> Self {
        Self {
            map,
            journal: Mutex::new(journal),
            packer: Packer::new(plan),
            started: Instant::now(),
            written: AtomicUsize::new(found.finished.iter().filter(|finished| **finished).count()),
            found,
        }
    }

    fn journal(&self) -> MutexGuard<'_, Journal> {
        self.journal.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// One entry for each tile of the grid: whether an earlier run has finished the tile.
    #[must_use]
    pub fn finished(&self) -> &[bool] {
        &self.found.finished
    }

    /// The sum of the accounts of the tiles that earlier runs have finished.
    #[must_use]
    pub fn account(&self) -> &Account {
        &self.found.account
    }

    /// Number of tiles in the journal.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.written.load(Ordering::Relaxed)
    }

    /// The plan of the map.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.packer.plan
    }

    /// Returns whether the map is locked against other processes; false on file systems without locks.
    pub fn is_locked(&self) -> bool {
        self.journal().locked
    }

    /// Forces the journal to disk. The caller must do so before it leaves the map to a later run.
    pub fn sync(&self) -> Result<(), StoreError> {
        self.journal().sync()
    }

    /// Completes the map, seals it, forces it to disk, gives it its name, and removes the journal.
    ///
    /// # Errors
    /// [`StoreError::Incomplete`] if tiles are missing, [`StoreError::NotComputed`] if cells are,
    /// [`StoreError::Overtaken`] if the output appeared meanwhile and is not to be replaced; otherwise the
    /// error of the file system or of the library. After an error the journal stays, so that no tile is lost.
    pub fn finish(self, outcome: &Outcome) -> Result<(), StoreError> {
        let Self { map, journal, .. } = self;
        let mut journal = journal.into_inner().unwrap_or_else(PoisonError::into_inner);
        // If the power fails after the map's name has reached the disk, the tiles are in the journal.
        journal.sync()?;
        map.finish(outcome)?;
        journal.remove()
    }
}

impl Sink for PartialMap {
    type Packed = PackedTile;
    type Error = StoreError;

    fn pack(&self, data: &TileData) -> Result<PackedTile, StoreError> {
        Ok(self.packer.pack(data))
    }

    fn write(&self, tile: PackedTile, account: &Account) -> Result<(), StoreError> {
        let frame = Frame::Tile(&tile, self.started.elapsed().as_secs_f64(), account);
        self.journal().append(&to_bytes(&frame), true)?;
        self.written.fetch_add(1, Ordering::Relaxed);
        self.map.put(tile)
    }
}

/// The journal's first frame.
fn header(opening: &[(String, Value)], history: &str, existing: Existing) -> Vec<u8> {
    let mut attributes = opening.to_vec();
    attributes.push((REPLACES.into(), Value::from(i64::from(existing == Existing::Replace))));
    attributes.push(("history".into(), history.into()));
    to_bytes(&Frame::<PackedTile, Account>::Header(attributes))
}

/// Length in bytes of the contents of the longest frame that a run of `plan` writes.
fn longest(plan: &Plan) -> u64 {
    let schema = Schema::of(plan);
    let chunk = |variable| schema.chunk(variable).iter().product::<usize>() as u64;
    let plain: u64 = schema.variables.iter().map(|variable| 8 * chunk(variable) + 4096).sum();
    // Deflate lengthens incompressible data by far less than this.
    LONGEST_HEADER.max(plain + plain / 16)
}

/// The files that an interrupted run has left at a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Left {
    /// No journal, so nothing can be resumed.
    Nothing,
    /// A journal, which can be resumed.
    Journal,
    /// Unknown: the path cannot be reached.
    OutOfReach,
}

/// Looks for an interrupted run of the map at `path`.
pub fn left(path: &Path) -> Left {
    let journal = match beside(path, JOURNAL) {
        Ok(journal) => journal,
        Err(StoreError::Lost { .. }) => return Left::OutOfReach,
        Err(_) => return Left::Nothing,
    };
    match journal.symlink_metadata().map_err(|source| StoreError::io("find", &journal, source)) {
        Ok(_) if Journal::is_at(&journal) => Left::Journal,
        Err(StoreError::Lost { .. }) => Left::OutOfReach,
        _ => Left::Nothing,
    }
}

/// Removes the unfinished map, but not the journal, for a process that cannot drop its [`PartialMap`].
pub fn remove_unfinished(path: &Path) {
    if let Ok(unfinished) = beside(path, UNFINISHED) {
        // If it cannot be removed now, the next run removes it.
        let _ = fs::remove_file(unfinished);
    }
}

//! A map while a process computes tiles of it, into a journal of its own.

use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use slipmap_files::Existing;
use slipmap_map::dataset::{Outcome, Provenance, attributes};
use slipmap_map::{Account, Plan, Shard, Sink, TileData};

use super::codec::to_bytes;
use super::error::StoreError;
use super::journal::{Frame, Journal};
use super::journals::{Journals, TileRecord, any_tile, header, remove_parts};
use super::pack::{PackedTile, Packer};

/// An unfinished map: the tiles that earlier and other runs have left, and those of this process.
#[derive(Debug)]
pub struct PartialMap {
    own: Mutex<Own>,
    history: String,
    packer: Packer,
    started: Instant,
    /// What was found beside the output when the run began.
    pub found: Journals,
}

/// The journal of this process, and the tiles in it.
#[derive(Debug)]
struct Own {
    journal: Journal,
    tiles: Vec<Frame>,
}

impl PartialMap {
    /// Starts the map of `plan`.
    ///
    /// # Errors
    /// [`StoreError::Exists`] if the map exists already, [`StoreError::Unfinished`] if other runs have left
    /// tiles, both unless they are to be replaced; otherwise the error of the file system.
    pub fn begin(
        path: &Path,
        plan: &Plan,
        provenance: &Provenance,
        existing: Existing,
    ) -> Result<Self, StoreError> {
        match existing {
            Existing::Replace => remove_parts(path)?,
            Existing::Refuse if path.symlink_metadata().is_ok() => {
                return Err(StoreError::Exists(path.to_path_buf()));
            }
            Existing::Refuse => {
                if let Some(journal) = any_tile(path)? {
                    return Err(StoreError::Unfinished(journal));
                }
            }
        }
        Self::with(Journals::none(path, plan, provenance, existing), provenance, None)
    }

    /// Continues the map, or a shard of it, from whatever journals there are; `None` if the map is finished.
    ///
    /// # Errors
    /// As [`Journals::beside`] and [`PartialMap::begin`].
    pub fn resume(
        path: &Path,
        plan: &Plan,
        provenance: &Provenance,
        shard: Option<Shard>,
    ) -> Result<Option<Self>, StoreError> {
        match Journals::beside(path, plan, provenance, shard)? {
            None => remove_parts(path).map(|()| None),
            Some(found) => Self::with(found, provenance, shard).map(Some),
        }
    }

    /// The map with a new journal beside those found.
    fn with(found: Journals, provenance: &Provenance, shard: Option<Shard>) -> Result<Self, StoreError> {
        let mut history = attributes::history(provenance);
        let tiles = found.finished_tiles();
        if tiles > 0 {
            history = format!("{history} (resumed with {tiles} of {} tiles)", found.tiles());
        }
        let journal = Journal::create(&found.output, &header(&found, &history, shard, provenance.threads))?;
        Ok(Self {
            own: Mutex::new(Own { journal, tiles: Vec::new() }),
            history,
            packer: Packer::new(&found.plan),
            started: Instant::now(),
            found,
        })
    }

    fn own(&self) -> MutexGuard<'_, Own> {
        self.own.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Number of finished tiles, of this process and of those found.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.found.finished_tiles() + self.own().tiles.len()
    }

    /// The plan of the map.
    #[must_use]
    pub fn plan(&self) -> &Plan {
        &self.packer.plan
    }

    /// Forces the journal to disk. The caller must do so before it leaves the map to a later run.
    ///
    /// # Errors
    /// Those of the file system.
    pub fn sync(&self) -> Result<(), StoreError> {
        self.own().journal.sync()
    }

    /// Makes the map of all journals: [`Journals::finish`].
    ///
    /// # Errors
    /// As that.
    pub fn finish(self, outcome: &Outcome) -> Result<(), StoreError> {
        let Self { own, mut found, history, .. } = self;
        let Own { mut journal, tiles } = own.into_inner().unwrap_or_else(PoisonError::into_inner);
        // If the power fails after the map's name has reached the disk, the tiles are in the journal.
        let synced = journal.sync();
        found.add_own(journal.path.clone(), history, tiles);
        found.settle(synced.and_then(|()| found.make(outcome)))
    }
}

impl Sink for PartialMap {
    type Packed = PackedTile;
    type Error = StoreError;

    fn pack(&self, data: &TileData) -> Result<PackedTile, StoreError> {
        Ok(self.packer.pack(data))
    }

    fn write(&self, tile: PackedTile, account: &Account) -> Result<(), StoreError> {
        let seconds = self.started.elapsed().as_secs_f64();
        let contents = to_bytes(&TileRecord { tile: &tile, seconds, account });
        let mut own = self.own();
        let frame = own.journal.append(tile.number as u64, &contents)?;
        own.tiles.push(frame);
        Ok(())
    }
}

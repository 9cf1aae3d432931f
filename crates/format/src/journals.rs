//! The journals beside an output, and the map that is made of them.
//!
//! Beside the output `NAME` lie, until the map is complete:
//!
//! - `NAME.part.LETTERS`, a journal of each process that computes tiles ([`super::PartialMap`]);
//! - `NAME.part-map.LETTERS`, the map itself while it is made of the journals. HDF5 guarantees nothing for a file
//!   whose process died while it wrote to the file, so it is made anew each time.

use std::collections::{BTreeMap, HashMap, HashSet};
use std::fs;
use std::io;
use std::num::NonZeroU32;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};
use tempfile::TempPath;

use slipmap_files::{Existing, folder_of};
use slipmap_map::dataset::{Outcome, Provenance, Value, attributes};
use slipmap_map::{Account, Plan, Shard};

use super::codec::{from_bytes, to_bytes};
use super::error::StoreError;
use super::identity::{check_finished, difference};
use super::journal::{Frame, HEADER, Reader, is_journal, journals, named_as_journals};
use super::pack::PackedTile;
use super::seal::{UNFINISHED, beside};
use super::writer::MapWriter;

/// Key in a journal's header of the flag that the run replaces an existing output.
const REPLACES: &str = "replaces";
/// Key in a journal's header of the number of shards that its run is one of; 0 if it is not a shard.
const SHARDS: &str = "shards";
/// The number of threads of the process.
const THREADS: &str = "threads";

/// Number of bytes of frames that are read at once.
const WINDOW: u64 = 1 << 24;

/// Number of times that a map is begun which other processes remove: each of them does so once.
const ATTEMPTS: usize = 8;

/// Largest number of runs that the history of a map lists.
const LISTED_RUNS: usize = 20;

/// The contents of a tile's frame: the tile, the seconds from the start of the process to its end, its account.
#[derive(Serialize, Deserialize)]
pub(super) struct TileRecord<Tile, Of> {
    pub(super) tile: Tile,
    pub(super) seconds: f64,
    pub(super) account: Of,
}

/// The contents of a journal's header: the attributes of the map that are known before the run, and what
/// concerns the run alone.
pub(super) fn header(found: &Journals, history: &str, shard: Option<Shard>, threads: usize) -> Vec<u8> {
    let mut attributes = found.opening.clone();
    attributes.push((THREADS.into(), (threads as i64).into()));
    let shards = shard.map_or(0, Shard::of) as i64;
    attributes.push((REPLACES.into(), i64::from(found.existing == Existing::Replace).into()));
    attributes.push((SHARDS.into(), shards.into()));
    attributes.push(("history".into(), history.into()));
    to_bytes(&attributes)
}

/// A place of a tile: the number of its journal, from 1, and the frame's position and length there.
#[derive(Clone, Copy, Debug)]
struct FramePlace {
    journal: NonZeroU32,
    length: u32,
    at: u64,
}

/// The tiles that journals hold.
#[derive(Debug)]
pub struct Journals {
    pub(super) output: PathBuf,
    pub(super) plan: Plan,
    pub(super) opening: Vec<(String, Value)>,
    files: Vec<PathBuf>,
    /// The places of those tiles that are finished, by their numbers.
    places: BTreeMap<usize, FramePlace>,
    tiles: usize,
    pub(super) existing: Existing,
    history: Vec<String>,
    /// The sum of the accounts of the tiles.
    pub account: Account,
    /// Seconds that the processes took, each up to its last tile.
    pub seconds: f64,
    /// The largest number of threads of one of these processes; 0 where none had tiles.
    pub threads: usize,
    /// Number of bytes that cannot be used: partial or damaged frames. Their tiles are not among the finished
    /// ones.
    pub lost: u64,
    /// The largest number of shards that a process was one of.
    pub shards: Option<usize>,
}

impl Journals {
    /// No journals.
    pub(super) fn none(output: &Path, plan: &Plan, provenance: &Provenance, existing: Existing) -> Self {
        Self {
            output: output.to_path_buf(),
            plan: plan.clone(),
            opening: attributes::opening(plan, provenance),
            files: Vec::new(),
            places: BTreeMap::new(),
            tiles: plan.tile_count(),
            existing,
            history: Vec::new(),
            account: Account::none(plan),
            seconds: 0.0,
            threads: 0,
            lost: 0,
            shards: None,
        }
    }

    /// The tiles in the journals of the map at `output`, or those of one shard; `None` if the map is there and
    /// complete, without journals of runs that are to replace it.
    ///
    /// # Errors
    /// [`StoreError::Changed`] if a journal or the map at `output` belongs to another plan, configuration or
    /// version of the program; otherwise the error of the file system or of the library.
    pub fn beside(
        output: &Path,
        plan: &Plan,
        provenance: &Provenance,
        shard: Option<Shard>,
    ) -> Result<Option<Self>, StoreError> {
        let mut found = Self::none(output, plan, provenance, Existing::Refuse);
        for path in journals(output)? {
            match found.add(&path, shard) {
                // The map has just been completed.
                Err(StoreError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {}
                added => added?,
            }
        }
        if found.existing == Existing::Replace || output.symlink_metadata().is_err() {
            return Ok(Some(found));
        }
        check_finished(output, &found.opening)?;
        Ok(None)
    }

    /// Adds the tiles of a journal.
    fn add(&mut self, path: &Path, shard: Option<Shard>) -> Result<(), StoreError> {
        let failed = |source| StoreError::io("read", path, source);
        let mut reader = Reader::open(path).map_err(failed)?;
        let mut buffer = Vec::new();
        let Some(frame) = reader.next().map_err(failed)? else { return Ok(()) };
        let header = reader.contents(frame, &mut buffer).map_err(failed)?;
        let header: Option<BTreeMap<String, Value>> =
            header.filter(|_| frame.tile == HEADER).and_then(from_bytes);
        let Some(header) = header else {
            self.lost += reader.length;
            return Ok(());
        };
        if let Some(difference) = difference(&header, &self.opening) {
            return Err(StoreError::Changed { path: path.to_path_buf(), difference });
        }
        if header.get(REPLACES) == Some(&1.into()) {
            self.existing = Existing::Replace;
        }
        if let Some(Value::Integers(shards)) = header.get(SHARDS) {
            let shards = shards.iter().filter_map(|&shards| usize::try_from(shards).ok());
            self.shards = shards.filter(|&shards| shards > 0).chain(self.shards).max();
        }
        let (mut used, mut seconds) = (false, 0.0f64);
        self.files.push(path.to_path_buf());
        while let Some(frame) = reader.next().map_err(failed)? {
            let tile = usize::try_from(frame.tile).ok().filter(|&tile| tile < self.tiles);
            let wanted = |&tile: &usize| shard.is_none_or(|shard| shard.has(tile));
            let Some(tile) = tile.filter(wanted) else { continue };
            let contents = reader.contents(frame, &mut buffer).map_err(failed)?;
            match contents.and_then(|bytes| Self::read(tile, bytes)) {
                None => self.lost += frame.bytes(),
                Some(contents) => {
                    seconds = seconds.max(contents.seconds);
                    if !self.places.contains_key(&tile) {
                        self.account.add(contents.account);
                        self.place(frame);
                        used = true;
                    }
                }
            }
        }
        self.lost += reader.rest();
        self.seconds += seconds;
        if used {
            if let Some(Value::Text(line)) = header.get("history") {
                self.history.push(line.clone());
            }
            if let Some(Value::Integers(threads)) = header.get(THREADS) {
                let threads = threads.iter().filter_map(|&threads| usize::try_from(threads).ok());
                self.threads = threads.fold(self.threads, usize::max);
            }
        }
        Ok(())
    }

    /// The contents of a tile's frame; `None` for other bytes. That they fit the plan follows from its fingerprint in the
    /// header and from that of the frame.
    fn read(tile: usize, bytes: &[u8]) -> Option<TileRecord<PackedTile, Account>> {
        from_bytes(bytes).filter(|record: &TileRecord<PackedTile, Account>| record.tile.number == tile)
    }

    /// Notes the place of a tile in the last journal.
    fn place(&mut self, frame: Frame) {
        let journal = u32::try_from(self.files.len()).ok().and_then(NonZeroU32::new);
        // Readers take no longer frame, and there are fewer files than numbers for them.
        if let (Some(journal), Ok(length)) = (journal, u32::try_from(frame.length)) {
            self.places.insert(frame.tile as usize, FramePlace { journal, length, at: frame.at });
        }
    }

    /// Adds the tiles that this process has written to its own journal.
    pub(super) fn add_own(&mut self, journal: PathBuf, history: String, frames: Vec<Frame>) {
        self.files.push(journal);
        self.history.push(history);
        frames.into_iter().for_each(|frame| self.place(frame));
    }

    /// The tiles that journals hold.
    #[must_use]
    pub fn finished(&self) -> HashSet<usize> {
        self.places.keys().copied().collect()
    }

    /// Number of tiles that journals hold.
    #[must_use]
    pub fn finished_tiles(&self) -> usize {
        self.places.len()
    }

    /// Number of tiles of the grid.
    #[must_use]
    pub fn tiles(&self) -> usize {
        self.tiles
    }

    /// Number of journals.
    #[must_use]
    pub fn journals(&self) -> usize {
        self.files.len()
    }

    /// The numbers of the shards, of `of`, of which tiles are missing, in order.
    #[must_use]
    pub fn missing_shards(&self, of: usize) -> Vec<usize> {
        let mut finished: HashMap<usize, usize> = HashMap::new();
        for tile in self.places.keys() {
            *finished.entry(tile % of + 1).or_default() += 1;
        }
        let is_missing = |shard: &Shard, number: usize| {
            finished.get(&number).copied().unwrap_or(0) < shard.tiles(self.tiles)
        };
        (1..=of)
            .filter(|&number| Shard::new(number, of).is_some_and(|shard| is_missing(&shard, number)))
            .collect()
    }

    /// Makes the map: writes it from the journals, tile by tile in the order of the grid, seals it, forces it to
    /// disk, gives it its name, and removes the journals. In memory are a window of frames and some 40 bytes of each
    /// tile.
    ///
    /// # Errors
    /// [`StoreError::Incomplete`] if tiles are missing, [`StoreError::Overtaken`] if the output appeared
    /// meanwhile, is another map, and is not to be replaced;
    /// otherwise the error of the file system or of the library. After an error the journals stay, so that no
    /// tile is lost.
    pub fn finish(&self, outcome: &Outcome) -> Result<(), StoreError> {
        self.settle(self.make(outcome))
    }

    /// Ends the making of the map: without an error, and where another process has made the same map meanwhile,
    /// and so has removed what this one needs.
    pub(super) fn settle(&self, made: Result<(), StoreError>) -> Result<(), StoreError> {
        match made {
            Err(error) if !self.is_made_meanwhile(&error) => Err(error),
            _ => remove_parts(&self.output),
        }
    }

    /// Whether an error is that of a process that needs no longer do its work: another one has made the same map. Where an
    /// older one was to be replaced, it may be that one, unless what was being written has been removed.
    #[must_use]
    pub fn is_made_meanwhile(&self, error: &StoreError) -> bool {
        (self.existing == Existing::Refuse || error.is_gone()) && self.is_made()
    }

    /// Whether the map is there and complete.
    #[must_use]
    pub fn is_made(&self) -> bool {
        check_finished(&self.output, &self.opening).is_ok()
    }

    pub(super) fn make(&self, outcome: &Outcome) -> Result<(), StoreError> {
        if self.finished_tiles() < self.tiles() {
            let (missing, tiles) = (self.tiles() - self.finished_tiles(), self.tiles());
            let gap = self.places.keys().enumerate().find(|(position, tile)| position != *tile);
            let first = gap.map_or(self.finished_tiles(), |(position, _)| position);
            return Err(StoreError::Incomplete { path: self.output.clone(), missing, tiles, first });
        }
        // Those of killed processes. One that makes the map at the same time loses its own, and begins anew.
        remove_unfinished(&self.output);
        for _ in 0..ATTEMPTS {
            let mut temporary = slipmap_files::temporary(&beside(&self.output, UNFINISHED)?)
                .map_err(|source| StoreError::io("write", &self.output, source))?
                .into_temp_path();
            // Removed below, which tells whether it is still there.
            temporary.disable_cleanup(true);
            let path = temporary.to_path_buf();
            match self.write(temporary, outcome) {
                Err(StoreError::Overtaken { path, kept }) => {
                    return Err(StoreError::Overtaken { path, kept });
                }
                Err(error) => match fs::remove_file(path) {
                    Err(gone) if gone.kind() == io::ErrorKind::NotFound && !self.is_made() => {}
                    _ => return Err(error),
                },
                Ok(()) => return Ok(()),
            }
        }
        Err(StoreError::Gone(self.output.clone()))
    }

    fn write(&self, temporary: TempPath, outcome: &Outcome) -> Result<(), StoreError> {
        let (opening, history) = (&self.opening, self.history());
        let mut map = MapWriter::begin(&self.output, temporary, &self.plan, opening, history, self.existing)?;
        let mut first = 0;
        while first < self.tiles() {
            let tiles = self.window(first)?;
            first += tiles.len();
            tiles.into_iter().try_for_each(|tile| map.put(tile))?;
        }
        map.finish(outcome)
    }

    /// Reads the tiles from number `first` on, as many as a window holds, each journal in the order of its
    /// frames.
    fn window(&self, first: usize) -> Result<Vec<PackedTile>, StoreError> {
        let mut bytes = 0;
        let within = |(_, place): &(usize, FramePlace)| {
            bytes += u64::from(place.length);
            bytes <= WINDOW || bytes == u64::from(place.length)
        };
        let places = self.places.range(first..).map(|(tile, place)| (*tile, *place));
        let mut wanted: Vec<(usize, FramePlace)> = places.take_while(within).collect();
        wanted.sort_by_key(|(_, place)| (place.journal, place.at));
        let mut tiles = Vec::with_capacity(wanted.len());
        let mut buffer = Vec::new();
        for of_journal in wanted.chunk_by(|(_, one), (_, other)| one.journal == other.journal) {
            let path = &self.files[of_journal[0].1.journal.get() as usize - 1];
            let failed = |source| StoreError::io("read", path, source);
            let mut reader = Reader::open(path).map_err(failed)?;
            for &(tile, FramePlace { length, at, .. }) in of_journal {
                let frame = Frame { tile: tile as u64, at, length: length.into() };
                let contents = reader.contents(frame, &mut buffer).map_err(failed)?;
                let contents = contents.and_then(|bytes| Self::read(tile, bytes));
                tiles.push(contents.ok_or_else(|| StoreError::Unreliable(path.clone()))?.tile);
            }
        }
        tiles.sort_by_key(|tile| tile.number);
        Ok(tiles)
    }

    /// The history of the map: a line for each run, the first ones and the last ones of many.
    fn history(&self) -> String {
        let mut lines = self.history.clone();
        lines.sort();
        if lines.len() > LISTED_RUNS {
            let omitted = lines.len() - LISTED_RUNS;
            let half = LISTED_RUNS / 2;
            lines.splice(half..half + omitted, [format!("... {omitted} further runs ...")]);
        }
        lines.join("\n")
    }
}

/// A journal of the map at `output` that holds a tile.
///
/// # Errors
/// Those of the file system.
pub fn any_tile(output: &Path) -> Result<Option<PathBuf>, StoreError> {
    for path in journals(output)? {
        let failed = |source| StoreError::io("read", &path, source);
        let mut reader = Reader::open(&path).map_err(failed)?;
        let frames = [reader.next().map_err(failed)?, reader.next().map_err(failed)?];
        if frames.iter().flatten().any(|frame| frame.tile != HEADER) {
            return Ok(Some(path));
        }
    }
    Ok(None)
}

/// Removes the journals and the unfinished maps beside an output: of a complete map they are what processes have
/// left that were stopped when it had its name, or that began too late.
///
/// # Errors
/// Those of the file system.
pub fn remove_parts(output: &Path) -> Result<(), StoreError> {
    remove_unfinished(output);
    // A process that was stopped before it wrote anything leaves an empty one.
    let is_empty = |path: &Path| path.symlink_metadata().is_ok_and(|file| file.is_file() && file.len() == 0);
    for path in named_as_journals(output)?.filter(|path| is_journal(path) || is_empty(path)) {
        match fs::remove_file(&path) {
            // Another process removes them too.
            Err(source) if source.kind() != io::ErrorKind::NotFound => {
                return Err(StoreError::io("remove", &path, source));
            }
            _ => {}
        }
    }
    slipmap_files::sync_folder(output).map_err(|source| StoreError::io("write", folder_of(output), source))
}

/// Removes unfinished maps, but no journals: those of killed processes, and for a process that cannot drop its
/// own. A process that is making one finds it gone at the end.
pub fn remove_unfinished(output: &Path) {
    let unfinished = beside(output, UNFINISHED).ok().and_then(|start| slipmap_files::named(&start).ok());
    for path in unfinished.unwrap_or_default() {
        // If it cannot be removed now, the next run removes it.
        let _ = fs::remove_file(path);
    }
}

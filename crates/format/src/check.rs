//! Verifies a stored map: attributes, axes, variables and fingerprints.

use std::fmt;
use std::ops::Range;
use std::path::Path;

use hdf5::{Dataset, ObjectReference1};

use slipmap_map::dataset::auxiliary::{self, rank_of};
use slipmap_map::dataset::{Fingerprint, Value, Variable, attributes, fingerprint, hex, si_name};

use super::curves;
use super::error::StoreError;
use super::layout::{self, Unfit};
use super::pack;
use super::reader::{MapFile, read_box};
use super::seal::{self, Seal};
use super::sys::{self, ScaleUse};
use super::value;

/// A problem found in a map.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Problem {
    /// The variable or axis; `None` for the file as a whole.
    pub variable: Option<String>,
    /// The place in the variable: index ranges of a tile, slowest axis first, or the name of an attribute.
    pub place: Option<String>,
    /// Description of the problem.
    pub what: String,
}

impl fmt::Display for Problem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.variable.as_deref().unwrap_or("file"))?;
        if let Some(place) = &self.place {
            write!(f, ", {place}")?;
        }
        write!(f, ": {}", self.what)
    }
}

/// The result of a check.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CheckReport {
    /// Number of variables read.
    pub variables: usize,
    /// Number of cells of the grid.
    pub cells: usize,
    /// Number of tiles of the grid.
    pub tiles: usize,
    /// The problems found.
    pub problems: Vec<Problem>,
}

impl CheckReport {
    /// Returns whether no problem was found.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        self.problems.is_empty()
    }

    /// Records a problem. After [`MOST_PROBLEMS`], records once that there are more.
    fn note(&mut self, variable: Option<&str>, place: Option<String>, what: impl Into<String>) {
        let (variable, place, what) = match self.problems.len() {
            0..MOST_PROBLEMS => (variable, place, what.into()),
            MOST_PROBLEMS => (None, None, "further problems are not listed".into()),
            _ => return,
        };
        self.problems.push(Problem { variable: variable.map(str::to_owned), place, what });
    }

    fn attribute(&mut self, variable: Option<&str>, name: &str, what: impl Into<String>) {
        self.note(variable, Some(format!("attribute {name}")), what);
    }
}

/// Largest number of problems that are listed.
const MOST_PROBLEMS: usize = 1000;

/// Verifies that the map at `path` is complete, unchanged since it was finished, and laid out as this version
/// of the program writes maps. Reads one tile of one variable at a time, and calls `on_chunk` after each with the
/// number of all of them.
///
/// # Errors
/// Only if the file cannot be read at all; the report contains every problem with its contents.
pub fn check(path: &Path, on_chunk: &dyn Fn(usize)) -> Result<CheckReport, StoreError> {
    let mut report = CheckReport::default();
    match seal::of(path, u64::MAX)? {
        Seal::Whole | Seal::NotCompared => {}
        Seal::Broken => report.note(None, None, seal::BROKEN),
        Seal::Missing => report.note(
            None,
            None,
            "it does not end with the seal of a finished map: it was cut, or written to by another program",
        ),
    }
    let map = match MapFile::open_layout(path) {
        Ok(map) => map,
        Err(
            error @ (StoreError::Io { .. }
            | StoreError::Lost { .. }
            | StoreError::NoPermission { .. }
            | StoreError::Name(_)),
        ) => return Err(error),
        Err(error) => {
            report.note(None, None, error.to_string());
            return Ok(report);
        }
    };
    check_contents(&map, true, Some(on_chunk), &mut report);
    Ok(report)
}

/// Checks the parts of a map that readers use: all except the links between variables and dimensions, and the cells only
/// if there is an `on_chunk`.
pub(super) fn contents(map: &MapFile, on_chunk: Option<&dyn Fn(usize)>) -> CheckReport {
    let mut report = CheckReport::default();
    check_contents(map, false, on_chunk, &mut report);
    report
}

/// Compares attributes, axes and, if there is an `on_chunk`, cells with their recorded fingerprints. `ties` also checks
/// the links between variables and dimensions, which programs that copy maps may write differently.
fn check_contents(map: &MapFile, ties: bool, on_chunk: Option<&dyn Fn(usize)>, report: &mut CheckReport) {
    let schema = &map.schema;
    report.cells = schema.grid.cells();
    report.tiles = schema.tiles();
    check_root(map, report);
    if let Err(unfit) = check_curves(map, report) {
        report.note(Some(curves::GROUP), None, unfit.to_string());
    }
    for name in beside(map) {
        if let Err(unfit) = check_auxiliary(map, name, ties, report) {
            report.note(Some(name), None, unfit.to_string());
        }
    }
    for (position, axis) in schema.grid.axes().iter().enumerate() {
        if let Err(error) = check_axis(map, position, ties, report) {
            report.note(Some(&axis.name), None, format!("unreadable: {error}"));
        }
    }
    let chunks = schema.variables.iter().map(|variable| schema.chunks(variable)).sum();
    for variable in &schema.variables {
        report.variables += 1;
        let dataset = match map.file.dataset(&variable.name) {
            Ok(dataset) => dataset,
            Err(error) => {
                report.note(Some(&variable.name), None, format!("missing: {error}"));
                continue;
            }
        };
        if let Err(unfit) = check_layout(map, variable, &dataset, report) {
            report.note(Some(&variable.name), None, unfit.to_string());
            continue;
        }
        if ties {
            let rank = variable.rank(schema.dimensions().len());
            check_ties(&variable.name, rank, &dataset, report);
        }
        if let Some(on_chunk) = on_chunk {
            check_cells(map, variable, &dataset, &|| on_chunk(chunks), report);
        }
    }
}

/// Checks the file's own attributes, and that the file holds nothing but the map.
fn check_root(map: &MapFile, report: &mut CheckReport) {
    let mut attribute = |name: &str, what: &str| report.attribute(None, name, what);
    if !map.text("Conventions").is_some_and(|text| text.starts_with("CF-")) {
        attribute("Conventions", "does not name the CF conventions");
    }
    if map.number("complete") != Some(1.0) {
        attribute("complete", "is not 1: the run did not finish");
    }
    let config = map.text("config").unwrap_or_default();
    if map.text("config_sha256") != Some(attributes::fingerprint(config).as_str()) {
        attribute("config_sha256", "is not the fingerprint of the attribute config");
    }
    for name in ["source", "history", "references", "crate_version", "git", "machine"] {
        if map.text(name).is_none() {
            attribute(name, "is missing");
        }
    }
    for name in ["tolerance", "threads", "wall_seconds", "compression"] {
        if map.number(name).is_none() {
            attribute(name, "is missing");
        }
    }
    match map.file.member_names() {
        Ok(names) => {
            let schema = &map.schema;
            let beside = auxiliary::names(&schema.grid);
            for name in names {
                let axis = schema.dimensions().contains(&name.as_str());
                let known = axis || map.has(&name) || beside.contains(&name.as_str());
                if !known && name != curves::GROUP {
                    report.note(Some(&name), None, "does not belong to the map");
                }
            }
        }
        Err(error) => report.note(None, None, format!("its list of variables is unreadable: {error}")),
    }
}

fn beside(map: &MapFile) -> impl Iterator<Item = &'static str> {
    auxiliary::names(map.grid()).into_iter().filter(|name| map.file.link_exists(name))
}

/// Checks an auxiliary variable.
fn check_auxiliary(map: &MapFile, name: &str, ties: bool, report: &mut CheckReport) -> Result<(), Unfit> {
    let dataset = map.file.dataset(name)?;
    let rank = rank_of(name, map.grid());
    layout::auxiliary(&dataset, name, &map.grid().shape()[..rank])?;
    let digest = fingerprint::of_one_tile(&fingerprint::reals(&dataset.read_raw::<f64>()?));
    expect(&dataset, name, "sha256", &digest, report);
    if ties && rank > 0 {
        check_ties(name, rank, &dataset, report);
    }
    Ok(())
}

/// Checks the curves of codimension one, if there are any.
fn check_curves(map: &MapFile, report: &mut CheckReport) -> Result<(), Unfit> {
    curves::read(&map.file, map.grid())?;
    if !map.file.link_exists(curves::GROUP) {
        return Ok(());
    }
    let group = map.file.group(curves::GROUP)?;
    let known = curves::names(map.grid());
    for column in group.member_names()? {
        let name = format!("{}/{column}", curves::GROUP);
        if !known.contains(&column) {
            report.note(Some(&name), None, "does not belong to the map");
            continue;
        }
        let dataset = group.dataset(&column)?;
        if value::read(&dataset, "sha256")? != curves::fingerprint_of(&dataset)? {
            report.attribute(Some(&name), "sha256", "is not the fingerprint of its numbers");
        }
    }
    Ok(())
}

fn expect(dataset: &Dataset, variable: &str, name: &str, expected: &Value, report: &mut CheckReport) {
    match value::read(dataset, name) {
        Ok(Some(value)) if &value == expected => {}
        Ok(_) => report.attribute(Some(variable), name, format!("is not {expected:?}")),
        Err(error) => report.attribute(Some(variable), name, format!("is unreadable: {error}")),
    }
}

fn check_axis(map: &MapFile, position: usize, ties: bool, report: &mut CheckReport) -> hdf5::Result<()> {
    let axis = &map.grid().axes()[position];
    let dataset = map.file.dataset(&axis.name)?;
    expect(&dataset, &axis.name, "CLASS", &"DIMENSION_SCALE".into(), report);
    expect(&dataset, &axis.name, "NAME", &axis.name.as_str().into(), report);
    expect(&dataset, &axis.name, "units", &si_name(axis.unit).into(), report);
    let digest = fingerprint::of_one_tile(&fingerprint::reals(&axis.values));
    expect(&dataset, &axis.name, "sha256", &digest, report);
    if ties { check_uses(map, position, &dataset, report) } else { Ok(()) }
}

/// Checks a variable's type and shape, without which nothing of it can be read, its chunks and its attributes.
fn check_layout(
    map: &MapFile,
    variable: &Variable,
    dataset: &Dataset,
    report: &mut CheckReport,
) -> Result<(), Unfit> {
    let schema = &map.schema;
    let name = Some(variable.name.as_str());
    layout::variable(dataset, schema, variable)?;
    let chunk = schema.chunk(variable);
    if dataset.chunk().as_ref() != Some(&chunk) {
        report.note(name, None, format!("has chunks of shape {:?} instead of {chunk:?}", dataset.chunk()));
    }
    for (attribute, expected) in &variable.attributes {
        expect(dataset, &variable.name, attribute, expected, report);
    }
    if dataset.attr_names()?.iter().any(|attribute| attribute == "_FillValue") {
        report.attribute(name, "_FillValue", "makes readers turn codes into floating-point numbers");
    }
    Ok(())
}

/// Checks that a variable has a list of its dimensions of the right length. The entries are not read, since
/// they are stored in a heap without checksums, and the HDF5 library (seen in 1.10.8) crashes on damaged
/// heaps. [`check_uses`] compares the lists of the dimensions instead. The seal covers the heap.
fn check_ties(name: &str, rank: usize, dataset: &Dataset, report: &mut CheckReport) {
    if dataset.attr("DIMENSION_LIST").ok().map(|list| list.shape()) != Some(vec![rank]) {
        report.attribute(Some(name), "DIMENSION_LIST", format!("does not tie it to {rank} dimensions"));
    }
}

/// Checks that a dimension lists exactly the variables that have it.
fn check_uses(map: &MapFile, position: usize, scale: &Dataset, report: &mut CheckReport) -> hdf5::Result<()> {
    let mut expected = Vec::new();
    let dimension = i32::try_from(position).unwrap_or(i32::MAX);
    let all = map.schema.ranks(beside(map)).filter(|(_, rank)| position < *rank);
    for (name, _) in all.filter(|(name, _)| map.file.link_exists(name)) {
        let reference: ObjectReference1 = map.file.reference(name)?;
        expected.push((sys::address(reference), dimension));
    }
    let mut found: Vec<_> = scale
        .attr("REFERENCE_LIST")
        .and_then(|list| list.read_raw::<ScaleUse>())
        .unwrap_or_default()
        .iter()
        .map(|usage| (sys::address(usage.dataset), usage.dimension))
        .collect();
    expected.sort_unstable();
    found.sort_unstable();
    if found != expected {
        let name = Some(map.grid().axes()[position].name.as_str());
        report.attribute(name, "REFERENCE_LIST", "does not tie it to the variables that have it");
    }
    Ok(())
}

/// Reads a variable chunk by chunk and compares it with its fingerprint and its counts.
fn check_cells(
    map: &MapFile,
    variable: &Variable,
    dataset: &Dataset,
    on_chunk: &dyn Fn(),
    report: &mut CheckReport,
) {
    let schema = &map.schema;
    let name = Some(variable.name.as_str());
    let written = dataset.num_chunks().unwrap_or(0);
    if written != schema.chunks(variable) {
        report.note(name, None, format!("{written} of {} chunks are in the file", schema.chunks(variable)));
    }
    let codes = variable.codes().unwrap_or_default();
    let (mut chunks, mut sums, mut is_complete) = (Vec::new(), vec![0; codes.len()], true);
    for tile in map.tiles() {
        if !schema.fills(variable, tile.number) {
            continue;
        }
        let ranges = &tile.ranges[..variable.rank(tile.ranges.len())];
        let read = read_chunk(variable, dataset, ranges);
        on_chunk();
        let (fingerprint, counts) = match read {
            Ok(read) => read,
            Err(error) => {
                report.note(name, Some(place(ranges)), format!("unreadable: {error}"));
                is_complete = false;
                continue;
            }
        };
        chunks.push(fingerprint);
        let cells: usize = ranges.iter().map(ExactSizeIterator::len).product();
        let unknown = cells as u64 - counts.iter().sum::<u64>();
        if unknown > 0 && !codes.is_empty() {
            report.note(name, Some(place(ranges)), format!("{unknown} cells have unknown codes"));
        }
        for ((_, meaning), &cells) in codes.iter().zip(&counts) {
            if *meaning == "not_computed" && cells > 0 {
                report.note(name, Some(place(ranges)), format!("{cells} cells were not computed"));
            }
        }
        sums.iter_mut().zip(counts).for_each(|(sum, cells)| *sum += cells);
    }
    if !is_complete {
        return; // The fingerprint of the readable rest would fail for the same reason.
    }
    let digest = hex(&fingerprint::combine(&chunks));
    expect_found(dataset, &variable.name, "sha256", &digest.into(), report);
    if !codes.is_empty() {
        let counts = sums.iter().map(|&cells| i64::try_from(cells).unwrap_or(i64::MAX)).collect();
        expect_found(dataset, &variable.name, "flag_counts", &Value::Integers(counts), report);
    }
}

/// Fingerprint of a chunk, and number of its cells with each code of the variable.
fn read_chunk(
    variable: &Variable,
    dataset: &Dataset,
    ranges: &[Range<usize>],
) -> hdf5::Result<(Fingerprint, Vec<u64>)> {
    if variable.codes().is_none() {
        let cells = read_box::<f64>(dataset, ranges)?.into_raw_vec_and_offset().0;
        return Ok((fingerprint::reals(&cells), Vec::new()));
    }
    let cells = read_box::<i8>(dataset, ranges)?.into_raw_vec_and_offset().0;
    Ok((fingerprint::codes(&cells), pack::count(variable, |wanted| count_of(&cells, wanted))))
}

fn count_of(cells: &[i8], code: i8) -> u64 {
    // Sums of 255 comparisons fit into a byte, so whole vector registers of cells are compared at once: a
    // dozen times faster than counting into 64-bit numbers one by one.
    let count = |part: &[i8]| u64::from(part.iter().map(|&cell| u8::from(cell == code)).sum::<u8>());
    cells.chunks(255).map(count).sum()
}

/// Compares a value computed from the cells with the value recorded when they were written.
fn expect_found(dataset: &Dataset, variable: &str, name: &str, found: &Value, report: &mut CheckReport) {
    let recorded = value::read(dataset, name).ok().flatten();
    if recorded.as_ref() != Some(found) {
        let what = format!("records {recorded:?}, but the cells give {found:?}");
        report.attribute(Some(variable), name, what);
    }
}

fn place(ranges: &[Range<usize>]) -> String {
    let words: Vec<String> = ranges.iter().map(|range| format!("{}..{}", range.start, range.end)).collect();
    format!("tile [{}]", words.join(", "))
}

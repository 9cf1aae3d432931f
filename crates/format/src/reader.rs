//! Reads maps.

use std::collections::BTreeMap;
use std::fs;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};

use hdf5::{Dataset, File, SliceOrIndex};
use ndarray::ArrayD;

use slipmap_column::Method;
use slipmap_machine::{MOTION_ATTRIBUTE, Machine, Motion};
use slipmap_map::dataset::auxiliary::{PROBABILITIES, PROBABILITY};
use slipmap_map::dataset::{SCHEMA, Schema, Value};
use slipmap_map::{Field, Grid, PlaneCurves, Shown, Tile};
use slipmap_model::friction::Law;

use super::error::StoreError;
use super::layout::{self, Unfit};
use super::value;
use super::writer::SHOWN;

/// First bytes of an HDF5 file, and so of every map.
pub const SIGNATURE: [u8; 8] = *b"\x89HDF\r\n\x1a\n";

/// The selection of a slice along one dimension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pick {
    /// One node; the slice does not have the dimension.
    Node(usize),
    /// The first node and every n-th after it; 1 selects all.
    Every(usize),
}

/// A stored map, open for reading. Cells stay on disk until they are read. They were verified when the map was
/// opened; those of a large map are when they are read, by the checksums of their tiles.
#[derive(Debug)]
pub struct MapFile {
    /// Its path.
    pub path: PathBuf,
    pub(super) file: File,
    pub(super) schema: Schema,
    attributes: BTreeMap<String, Value>,
    /// Whether it is so large that its tiles are verified when they are read.
    pub(super) by_parts: bool,
    /// Whether the map ends with its seal; if not, another program has written to it or copied it.
    pub sealed: bool,
    pub(super) curves: Vec<PlaneCurves>,
}

impl MapFile {
    /// Opens a plain file as a map, without checking its variables.
    pub(super) fn open_layout(path: &Path) -> Result<Self, StoreError> {
        let file = open_file(path)?;
        let attributes = value::read_all(&file)
            .map_err(|error| StoreError::hdf5("read the attributes of", path, &error))?;
        let schema = read_schema(&file, path, &attributes)?;
        let path = path.to_path_buf();
        Ok(Self { path, file, schema, attributes, by_parts: false, sealed: false, curves: Vec::new() })
    }

    /// The grid: friction law and axes, slowest first.
    #[must_use]
    pub fn grid(&self) -> &Grid {
        &self.schema.grid
    }

    /// Shape of the tiles in which cells are stored: reading tile by tile ([`Grid::tile`],
    /// [`MapFile::codes`]) reads every byte once.
    #[must_use]
    pub fn tile_shape(&self) -> &[usize] {
        &self.schema.tile_shape
    }

    /// The methods, in the order of the file.
    #[must_use]
    pub fn methods(&self) -> &[Method] {
        &self.schema.methods
    }

    /// The stored fields.
    #[must_use]
    pub fn fields(&self) -> &[Field] {
        &self.schema.fields
    }

    /// The stored curves of codimension one, plane by plane.
    #[must_use]
    pub fn curves(&self) -> &[PlaneCurves] {
        &self.curves
    }

    /// Names of the variables over the grid, in the order of the file.
    pub fn variables(&self) -> impl Iterator<Item = &str> {
        self.schema.variables.iter().map(|variable| variable.name.as_str())
    }

    /// Returns whether the map has this variable over the grid.
    pub fn has(&self, variable: &str) -> bool {
        self.variables().any(|name| name == variable)
    }

    /// Name of the variable with a method's critical dampings.
    pub fn critical(&self, method: &str) -> String {
        format!("{}{method}", Field::critical_of(self.grid())[0])
    }

    /// Name of the variable with the errors of those of the simulation.
    pub fn critical_error(&self) -> String {
        format!("{}{}", Field::critical_of(self.grid())[1], Method::Simulation.name())
    }

    /// Whether the map of a machine has the probability of stick-slip.
    #[must_use]
    pub fn has_probability(&self) -> bool {
        self.grid().machine().is_some() && self.file.link_exists(PROBABILITY)
    }

    /// Attributes of the file, by name.
    #[must_use]
    pub fn attributes(&self) -> &BTreeMap<String, Value> {
        &self.attributes
    }

    /// A text attribute of the file.
    #[must_use]
    pub fn text(&self, name: &str) -> Option<&str> {
        match self.attributes.get(name) {
            Some(Value::Text(text)) => Some(text),
            _ => None,
        }
    }

    /// A numeric attribute of the file, for instance `seconds_METHOD` or `audit_cells`.
    #[must_use]
    pub fn number(&self, name: &str) -> Option<f64> {
        match self.attributes.get(name) {
            Some(Value::Reals(values)) if values.len() == 1 => Some(values[0]),
            Some(Value::Integers(values)) if values.len() == 1 => Some(values[0] as f64),
            _ => None,
        }
    }

    /// Number of cells with each code of a variable of codes, in the order of its `flag_values`, as
    /// recorded when the map was written.
    ///
    /// # Errors
    /// [`StoreError::NoVariable`] if there is no such variable of codes; otherwise the error of the library.
    pub fn counts(&self, variable: &str) -> Result<Vec<u64>, StoreError> {
        let dataset = self.dataset(variable)?;
        let read = value::read(&dataset, "flag_counts").map_err(|error| self.failed(variable, &error))?;
        match read {
            Some(Value::Integers(counts)) => {
                Ok(counts.into_iter().map(|count| u64::try_from(count).unwrap_or(0)).collect())
            }
            _ => Err(StoreError::NotAMap {
                path: self.path.clone(),
                why: format!("the counts of {variable} are not integers"),
            }),
        }
    }

    /// Reads codes (verdicts, regimes) in a box of cells, one index range per dimension of the variable.
    ///
    /// # Errors
    /// [`StoreError::NoVariable`]; otherwise the error of the library, as for a box beyond the variable.
    pub fn codes(&self, variable: &str, ranges: &[Range<usize>]) -> Result<ArrayD<i8>, StoreError> {
        self.read(variable, ranges)
    }

    /// Reads real numbers (margins, critical dampings, landings) in a box of cells, as [`MapFile::codes`].
    ///
    /// # Errors
    /// As [`MapFile::codes`].
    pub fn reals(&self, variable: &str, ranges: &[Range<usize>]) -> Result<ArrayD<f64>, StoreError> {
        self.read(variable, ranges)
    }

    /// Reads codes on a slice. Only the selected cells take memory.
    ///
    /// # Errors
    /// As [`MapFile::codes`].
    pub fn code_slice(&self, variable: &str, at: &[Pick]) -> Result<ArrayD<i8>, StoreError> {
        self.slice(variable, at)
    }

    /// Reads real numbers on a slice, as [`MapFile::code_slice`], also those of the probability of stick-slip.
    ///
    /// # Errors
    /// As [`MapFile::codes`].
    pub fn real_slice(&self, variable: &str, at: &[Pick]) -> Result<ArrayD<f64>, StoreError> {
        self.slice(variable, at)
    }

    /// The tiles of the map, in the order of the file.
    pub fn tiles(&self) -> impl Iterator<Item = Tile> {
        (0..self.schema.tiles()).map(|number| self.schema.grid.tile(&self.schema.tile_shape, number))
    }

    pub(super) fn dataset(&self, variable: &str) -> Result<Dataset, StoreError> {
        let is_probability = PROBABILITIES.contains(&variable) && self.has_probability();
        if !self.has(variable) && !is_probability {
            return Err(StoreError::NoVariable {
                path: self.path.clone(),
                name: variable.into(),
                available: self.variables().collect::<Vec<_>>().join(", "),
            });
        }
        self.file.dataset(variable).map_err(|error| self.failed(variable, &error))
    }

    fn read<T: hdf5::H5Type>(
        &self,
        variable: &str,
        ranges: &[Range<usize>],
    ) -> Result<ArrayD<T>, StoreError> {
        read_box(&self.dataset(variable)?, ranges).map_err(|error| self.failed(variable, &error))
    }

    fn slice<T: hdf5::H5Type>(&self, variable: &str, at: &[Pick]) -> Result<ArrayD<T>, StoreError> {
        let along = |pick: &Pick| match *pick {
            Pick::Node(index) => SliceOrIndex::Index(index),
            Pick::Every(step) => SliceOrIndex::Unlimited { start: 0, step, block: 1 },
        };
        let selection: Vec<SliceOrIndex> = at.iter().map(along).collect();
        let read = self.dataset(variable)?.read_slice(hdf5::Hyperslab::from(selection));
        read.map_err(|error| self.failed(variable, &error))
    }

    /// Converts an error of the library while reading a variable.
    pub(super) fn failed(&self, variable: &str, error: &hdf5::Error) -> StoreError {
        StoreError::hdf5(format!("read {variable} in"), &self.path, error)
    }
}

/// Reads a box of cells that lies inside the variable.
pub(super) fn read_box<T: hdf5::H5Type>(
    dataset: &Dataset,
    ranges: &[Range<usize>],
) -> hdf5::Result<ArrayD<T>> {
    let selection: Vec<SliceOrIndex> = ranges
        .iter()
        .map(|range| SliceOrIndex::SliceTo { start: range.start, step: 1, end: range.end, block: 1 })
        .collect();
    dataset.read_slice(hdf5::Hyperslab::from(selection))
}

/// Opens an HDF5 file.
fn open_file(path: &Path) -> Result<File, StoreError> {
    let failed = |source| StoreError::io("open", path, source);
    let mut head = Vec::new();
    let plain = fs::File::open(path).map_err(failed)?;
    plain.take(SIGNATURE.len() as u64).read_to_end(&mut head).map_err(failed)?;
    if head != SIGNATURE {
        return Err(StoreError::NotAMap { path: path.to_path_buf(), why: "it is not an HDF5 file".into() });
    }
    if path.to_str().is_none() {
        return Err(StoreError::Name(path.to_path_buf()));
    }
    File::open(path).map_err(|error| StoreError::hdf5("open", path, &error))
}

/// Derives the layout of a map from its attributes and coordinates.
fn read_schema(file: &File, path: &Path, attributes: &BTreeMap<String, Value>) -> Result<Schema, StoreError> {
    let not_a_map = |why: String| StoreError::NotAMap { path: path.to_path_buf(), why };
    let text = |name: &str| match attributes.get(name) {
        Some(Value::Text(text)) => Ok(text.as_str()),
        _ => Err(not_a_map(format!("it has no text attribute {name}"))),
    };
    match attributes.get("schema") {
        Some(Value::Integers(version)) if matches!(version[..], [SCHEMA]) => {}
        Some(Value::Integers(version)) => {
            return Err(not_a_map(format!(
                "its layout has number {version:?}, and this version of slipmap reads number {SCHEMA}; use \
                 the version that wrote it"
            )));
        }
        _ => return Err(not_a_map("it has no integer attribute schema".into())),
    }
    let law = text("law")?;
    let definition = text("law_definition").unwrap_or_default();
    let law = Law::from_definition(law, definition)
        .ok_or_else(|| not_a_map(format!("this version of slipmap does not know its friction law {law}")))?;
    let axis = |name: &str| {
        read_axis(file, name)
            .map_err(|unfit| StoreError::unfit(format!("read the axis {name} of"), path, unfit))
    };
    let grid = match attributes.get(MOTION_ATTRIBUTE) {
        None => {
            let nodes = law.axis_names().into_iter().map(axis).collect::<Result<_, _>>()?;
            Grid::new(law, nodes)
        }
        Some(motion) => {
            let motion = Motion::ALL.into_iter().find(|it| *motion == Value::from(it.name()));
            let motion = motion.ok_or_else(|| not_a_map("its machine has no known motion".into()))?;
            let (mut varied, mut first) = (Vec::new(), BTreeMap::new());
            for name in Machine::names(&law, |name| file.link_exists(name))
                .into_iter()
                .filter(|name| file.link_exists(name))
            {
                let values = axis(name)?;
                first.extend(values.first().map(|value| (name, *value)));
                if is_axis(file, name) {
                    varied.push((name, values));
                }
            }
            let machine = Machine::new(motion, &law, |name| first.get(name).copied());
            let machine = machine.ok_or_else(|| not_a_map("its machine lacks quantities".into()))?;
            Grid::of_machine(&machine, &varied).map(|grid| grid.shown_in(|name| shown(file, name)))
        }
    };
    let grid = grid.map_err(|error| not_a_map(error.to_string()))?;
    let tile_shape: Vec<usize> = match attributes.get("tile_shape") {
        Some(Value::Integers(lengths)) => {
            lengths.iter().filter_map(|&len| usize::try_from(len).ok()).collect()
        }
        _ => Vec::new(),
    };
    let shape = grid.shape();
    if tile_shape.len() != shape.len()
        || !tile_shape.iter().zip(&shape).all(|(tile, len)| (1..=*len).contains(tile))
    {
        return Err(not_a_map("its attribute tile_shape does not fit its axes".into()));
    }
    let mut fields = Vec::new();
    for name in text("fields")?.split_whitespace() {
        let of_machine = grid.machine().is_some();
        let known = Field::ALL.into_iter().find(|field| field.name_for(of_machine) == name);
        let known = known.ok_or_else(|| not_a_map(format!("this version does not know its field {name}")))?;
        if !fields.contains(&known) {
            fields.push(known);
        }
    }
    let mut methods = Vec::new();
    for name in text("methods")?.split_whitespace() {
        let known = Method::by_name(name);
        let known =
            known.ok_or_else(|| not_a_map(format!("this version does not know its method {name}")))?;
        if methods.iter().any(|method: &Method| method.name() == name) {
            return Err(not_a_map(format!("its attribute methods names {name} twice")));
        }
        methods.push(known);
    }
    Ok(Schema::new(grid, tile_shape, methods, fields))
}

/// Whether a dataset is an axis, not a single number.
fn is_axis(file: &File, name: &str) -> bool {
    file.dataset(name).is_ok_and(|dataset| dataset.ndim() > 0)
}

/// Reads the nodes of an axis, or the number of a quantity that does not vary.
fn read_axis(file: &File, name: &str) -> Result<Vec<f64>, Unfit> {
    let axis = file.dataset(name)?;
    if axis.ndim() == 0 {
        layout::auxiliary(&axis, name, &[])?;
        return Ok(vec![axis.read_scalar()?]);
    }
    layout::axis(&axis, name)?;
    Ok(axis.read_raw()?)
}

/// The unit in which an axis is shown; `None` for the SI unit.
fn shown(file: &File, name: &str) -> Option<Shown> {
    let axis = file.dataset(name).ok()?;
    let [Some(Value::Text(unit)), Some(Value::Reals(size))] =
        SHOWN.map(|name| value::read(&axis, name).ok()?)
    else {
        return None;
    };
    Some(Shown { unit, size: *size.first().filter(|size| **size > 0.0)? })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_of_axes_have_a_size() {
        let folder = tempfile::tempdir().unwrap();
        let file = File::create(folder.path().join("map.h5")).unwrap();
        for (name, size) in [("V", 1e-3), ("c", 0.0), ("mass", -1.0)] {
            let axis = file.new_dataset_builder().with_data(&[1.0, 2.0]).create(name).unwrap();
            value::write(&axis, SHOWN[0], &"mm/s".into()).unwrap();
            value::write(&axis, SHOWN[1], &size.into()).unwrap();
            let told = shown(&file, name).map(|shown| (shown.unit, shown.size));
            assert_eq!(told, (size > 0.0).then(|| ("mm/s".to_owned(), size)));
        }
    }
}

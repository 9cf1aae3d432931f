//! Writes maps.

use std::path::{Path, PathBuf};

use hdf5::{Dataset, File, ObjectReference1};
use sha2::{Digest, Sha256};
use tempfile::TempPath;

use slipmap_files::Existing;
use slipmap_map::dataset::{
    Auxiliary, Outcome, Schema, Value, Variable, attributes, auxiliary, fingerprint, hex, si_name,
};
use slipmap_map::{Axis, Plan, Shown};

use super::create::{create_file, in_order};
use super::curves;
use super::error::StoreError;
use super::pack::PackedTile;
use super::records::{describe_scale, name_dimensions};
use super::seal;
use super::sys::{self, ScaleUse};
use super::value;

/// Fingerprint and counts of the chunks of one variable written so far.
#[derive(Debug)]
struct Written {
    /// The fingerprints of the chunks.
    digest: Sha256,
    /// Number of cells with each of the variable's codes.
    counts: Vec<u64>,
}

/// A map that is being written. Until [`MapWriter::finish`] the file has a temporary name beside the output;
/// dropping the writer removes the file.
#[derive(Debug)]
pub(super) struct MapWriter {
    // Fields are dropped in order: the file is closed, then removed.
    datasets: Vec<Dataset>,
    file: File,
    temporary: TempPath,
    output: PathBuf,
    existing: Existing,
    history: String,
    schema: Schema,
    written: Vec<Written>,
    /// Number of tiles written.
    tiles: usize,
}

impl MapWriter {
    /// Starts the map with the attributes `opening` in the file `temporary`.
    pub(super) fn begin(
        path: &Path,
        temporary: TempPath,
        plan: &Plan,
        opening: &[(String, Value)],
        history: String,
        existing: Existing,
    ) -> Result<Self, StoreError> {
        let schema = Schema::of(plan);
        let failed = |error: hdf5::Error| StoreError::hdf5("create", path, &error);
        let file = create_file(&temporary).map_err(failed)?;
        for (name, value) in opening {
            value::write(&file, name, value).map_err(failed)?;
        }
        let datasets = create_datasets(&file, &schema, plan.compression).map_err(failed)?;
        let written = schema
            .variables
            .iter()
            .map(|variable| Written {
                digest: Sha256::new(),
                counts: vec![0; variable.codes().map_or(0, |codes| codes.len())],
            })
            .collect();
        Ok(Self {
            datasets,
            file,
            temporary,
            output: path.to_path_buf(),
            existing,
            history,
            schema,
            written,
            tiles: 0,
        })
    }

    /// Completes the map, seals it, forces it to disk, and gives it its name.
    ///
    /// # Errors
    /// [`StoreError::Overtaken`] if the output appeared meanwhile and is not to be replaced; otherwise the error of
    /// the file system or of the library. All errors except `Overtaken` remove the temporary file.
    pub(super) fn finish(self, outcome: &Outcome) -> Result<(), StoreError> {
        assert_eq!(self.tiles, self.schema.tiles(), "every tile is written");
        let Self { datasets, file, temporary, output, existing, history, schema, written, .. } = self;
        let schema = &schema;
        let failed = |error: hdf5::Error| StoreError::hdf5("finish", &output, &error);
        create_auxiliary(&file, schema, &outcome.auxiliary).map_err(failed)?;
        for ((dataset, variable), written) in datasets.iter().zip(&schema.variables).zip(written) {
            close_variable(dataset, variable, written).map_err(failed)?;
        }
        list_uses(&file, schema, &outcome.auxiliary).map_err(failed)?;
        curves::write(&file, &schema.grid, &outcome.curves).map_err(failed)?;
        value::write(&file, "history", &history.into()).map_err(failed)?;
        for (name, value) in attributes::closing(outcome) {
            value::write(&file, &name, &value).map_err(failed)?;
        }
        drop(datasets);
        file.flush().map_err(failed)?;
        sys::unlock(&file).map_err(failed)?;
        file.close().map_err(failed)?;
        seal::seal(&temporary).map_err(|source| StoreError::io("write", &output, source))?;
        seal::publish(temporary, &output, existing)
    }

    /// Writes the next tile, in the order of the grid.
    pub(super) fn put(&mut self, packed: PackedTile) -> Result<(), StoreError> {
        assert_eq!(packed.number, self.tiles, "tiles are written in the order of the grid");
        self.tiles += 1;
        for ((position, variable), chunk) in self.schema.filled_by(packed.number).zip(packed.chunks) {
            let offset = self.schema.offset(variable, packed.number);
            sys::write_chunk(&self.datasets[position], &offset, &chunk.bytes)
                .map_err(|error| StoreError::hdf5("write", &self.output, &error))?;
            let Written { digest, counts } = &mut self.written[position];
            digest.update(chunk.fingerprint);
            counts.iter_mut().zip(chunk.counts).for_each(|(sum, cells)| *sum += cells);
        }
        Ok(())
    }
}

/// Creates the dimensions, and the variables with the lists of their dimensions.
fn create_datasets(file: &File, schema: &Schema, compression: u8) -> hdf5::Result<Vec<Dataset>> {
    let names = schema.dimensions();
    for axis in schema.grid.axes() {
        create_scale(file, axis)?;
    }
    let create = |variable: &Variable| {
        let dataset = create_variable(file, schema, variable, compression)?;
        name_dimensions(file, &dataset, names.iter().copied().take(variable.rank(names.len())))?;
        Ok(dataset)
    };
    schema.variables.iter().map(create).collect()
}

/// Writes, for each dimension, the list of the datasets that have it.
fn list_uses(file: &File, schema: &Schema, auxiliary: &[Auxiliary]) -> hdf5::Result<()> {
    let axes = schema.grid.axes();
    let mut uses: Vec<Vec<ScaleUse>> = vec![Vec::new(); axes.len()];
    for (name, rank) in schema.ranks(auxiliary.iter().map(|variable| variable.name)) {
        let dataset: ObjectReference1 = file.reference(name)?;
        for (dimension, uses) in (0..).zip(&mut uses[..rank]) {
            uses.push(ScaleUse { dataset, dimension });
        }
    }
    for (axis, uses) in axes.iter().zip(&uses) {
        file.dataset(&axis.name)?.new_attr_builder().with_data(uses).create("REFERENCE_LIST")?;
    }
    Ok(())
}

fn create_auxiliary(file: &File, schema: &Schema, auxiliary: &[Auxiliary]) -> hdf5::Result<()> {
    for Auxiliary { name, values, attributes } in auxiliary {
        let rank = auxiliary::rank_of(name, &schema.grid);
        let builder = file.new_dataset_builder().empty::<f64>().shape(&schema.grid.shape()[..rank]);
        let dataset = builder.with_dcpl(in_order).create(*name)?;
        dataset.write_raw(values)?;
        if rank > 0 {
            name_dimensions(file, &dataset, schema.dimensions().into_iter().take(rank))?;
        }
        for (name, value) in attributes {
            value::write(&dataset, name, value)?;
        }
        value::write(&dataset, "sha256", &fingerprint::of_one_tile(&fingerprint::reals(values)))?;
    }
    Ok(())
}

/// The attributes of an axis that tell the unit in which it is shown, and the size of that in SI.
pub(super) const SHOWN: [&str; 2] = ["shown_units", "shown_units_in_si"];

/// Creates the coordinate variable of an axis, which is also a dimension (HDF5 dimension scale).
fn create_scale(file: &File, axis: &Axis) -> hdf5::Result<()> {
    let builder = file.new_dataset_builder().with_data(&axis.values);
    let dataset = builder.with_dcpl(in_order).create(axis.name.as_str())?;
    describe_scale(&dataset, &axis.name, &axis.long_name, &si_name(axis.unit), &axis.values)?;
    let Some(Shown { unit, size }) = &axis.shown else { return Ok(()) };
    value::write(&dataset, SHOWN[0], &unit.as_str().into())?;
    value::write(&dataset, SHOWN[1], &(*size).into())
}

fn create_variable(
    file: &File,
    schema: &Schema,
    variable: &Variable,
    compression: u8,
) -> hdf5::Result<Dataset> {
    let codes = variable.codes().is_some();
    let builder = file.new_dataset_builder();
    let builder = if codes { builder.empty::<i8>() } else { builder.empty::<f64>() };
    let mut builder = builder.shape(schema.shape(variable)).chunk(schema.chunk(variable)).with_dcpl(in_order);
    builder = if codes { builder.fill_value(variable.fill_code()) } else { builder.fill_value(f64::NAN) };
    if compression > 0 {
        if !codes {
            builder = builder.shuffle();
        }
        builder = builder.deflate(compression.min(9));
    }
    let dataset = builder.create(variable.name.as_str())?;
    for (name, value) in &variable.attributes {
        value::write(&dataset, name, value)?;
    }
    Ok(dataset)
}

/// Writes the counts and the fingerprint of a variable.
fn close_variable(dataset: &Dataset, variable: &Variable, written: Written) -> hdf5::Result<()> {
    if variable.codes().is_some() {
        let counts = written.counts.iter().map(|&cells| i64::try_from(cells).unwrap_or(i64::MAX)).collect();
        value::write(dataset, "flag_counts", &Value::Integers(counts))?;
    }
    value::write(dataset, "sha256", &hex(&written.digest.finalize()).into())
}

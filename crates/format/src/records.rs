//! Writes tables into a group, as NetCDF-4 has them. Each kind of row has a dimension, each column a variable.

use hdf5::types::VarLenArray;
use hdf5::{Dataset, Group, ObjectReference1};

use slipmap_map::dataset::{Contents, Series, fingerprint};

use super::create::in_order;
use super::sys::{self, Ending, ScaleUse};
use super::value;

pub(super) fn write_tables(group: &Group, columns: &[Series]) -> hdf5::Result<()> {
    let mut dimensions: Vec<&'static str> = Vec::new();
    for series in columns {
        if !dimensions.contains(&series.dimension) {
            dimensions.push(series.dimension);
        }
    }
    for dimension in dimensions {
        let along: Vec<&Series> = columns.iter().filter(|series| series.dimension == dimension).collect();
        let length = along.first().map_or(0, |series| series.rows());
        let numbers: Vec<f64> = (1..=length).map(|number| number as f64).collect();
        let scale = create(group, dimension, &numbers)?;
        describe_scale(&scale, dimension, &format!("number of the {dimension}"), "1", &numbers)?;
        let mut uses = Vec::with_capacity(along.len());
        for series in along {
            let dataset = write_series(group, series)?;
            name_dimensions(group, &dataset, [dimension])?;
            uses.push(ScaleUse { dataset: group.reference(&series.name)?, dimension: 0 });
        }
        scale.new_attr_builder().with_data(&uses).create("REFERENCE_LIST")?;
    }
    Ok(())
}

/// Writes the list of the dimensions of a dataset.
pub(super) fn name_dimensions<'a>(
    place: &Group,
    dataset: &Dataset,
    dimensions: impl IntoIterator<Item = &'a str>,
) -> hdf5::Result<()> {
    let reference = |name| Ok(VarLenArray::from_slice(&[place.reference(name)?]));
    let list: Vec<VarLenArray<ObjectReference1>> =
        dimensions.into_iter().map(reference).collect::<hdf5::Result<_>>()?;
    dataset.new_attr_builder().with_data(&list).create("DIMENSION_LIST").map(drop)
}

fn create<T: hdf5::H5Type>(group: &Group, name: &str, values: &[T]) -> hdf5::Result<Dataset> {
    group.new_dataset_builder().with_data(values).with_dcpl(in_order).create(name)
}

/// Makes a dataset a dimension (an HDF5 dimension scale) with these values.
pub(super) fn describe_scale(
    dataset: &Dataset,
    name: &str,
    long_name: &str,
    units: &str,
    values: &[f64],
) -> hdf5::Result<()> {
    sys::write_text(dataset, "CLASS", "DIMENSION_SCALE", Ending::Zero)?;
    sys::write_text(dataset, "NAME", name, Ending::Zero)?;
    value::write(dataset, "long_name", &long_name.into())?;
    value::write(dataset, "units", &units.into())?;
    value::write(dataset, "sha256", &fingerprint::of_one_tile(&fingerprint::reals(values)))
}

fn write_series(group: &Group, series: &Series) -> hdf5::Result<Dataset> {
    let (dataset, digest) = match &series.contents {
        Contents::Reals(values) => (create(group, &series.name, values)?, fingerprint::reals(values)),
        Contents::Integers(values) => (create(group, &series.name, values)?, fingerprint::integers(values)),
        Contents::Codes(codes) => (create(group, &series.name, codes)?, fingerprint::codes(codes)),
    };
    for (name, value) in &series.attributes {
        value::write(&dataset, name, value)?;
    }
    value::write(&dataset, "sha256", &fingerprint::of_one_tile(&digest))?;
    Ok(dataset)
}

//! Refuses datasets that do not have the shape and the type that follow from a map's attributes.

use hdf5::Dataset;
use hdf5::types::{FloatSize, IntSize, TypeDescriptor};

use slipmap_map::dataset::{Schema, Variable};

/// Reason why a part of a file cannot be used.
#[derive(Debug, thiserror::Error)]
pub(super) enum Unfit {
    /// The library returned an error.
    #[error("unreadable: {0}")]
    Unreadable(#[from] hdf5::Error),
    /// No map that slipmap writes contains such a part; with the reason.
    #[error("{0}")]
    Foreign(String),
}

/// Returns [`Unfit::Foreign`] with the reason `why` unless `legal`.
fn require(legal: bool, why: impl FnOnce() -> String) -> Result<(), Unfit> {
    if legal { Ok(()) } else { Err(Unfit::Foreign(why())) }
}

/// Refuses an axis that is not a list of numbers.
pub(super) fn axis(dataset: &Dataset, name: &str) -> Result<(), Unfit> {
    require(dataset.ndim() == 1, || {
        format!("its axis {name} has {} dimensions instead of one", dataset.ndim())
    })?;
    holds_reals(dataset, || format!("its axis {name}"))
}

/// Refuses a variable whose shape or type does not follow from the file's attributes.
pub(super) fn variable(dataset: &Dataset, schema: &Schema, variable: &Variable) -> Result<(), Unfit> {
    let name = &variable.name;
    has_shape(dataset, name, &schema.shape(variable))?;
    let (stored, expected) = (kind(dataset)?, kind_of(variable));
    require(stored == expected, || format!("{name} holds {stored} instead of {expected}"))
}

/// Refuses an auxiliary variable that is not an array of this shape of real numbers.
pub(super) fn auxiliary(dataset: &Dataset, name: &str, shape: &[usize]) -> Result<(), Unfit> {
    has_shape(dataset, name, shape)?;
    holds_reals(dataset, || name.to_owned())
}

fn holds_reals(dataset: &Dataset, what: impl Fn() -> String) -> Result<(), Unfit> {
    let is_real = kind(dataset)? == TypeDescriptor::Float(FloatSize::U8);
    require(is_real, || format!("{} does not hold 64-bit floating-point numbers", what()))
}

fn has_shape(dataset: &Dataset, name: &str, shape: &[usize]) -> Result<(), Unfit> {
    let stored = dataset.shape();
    require(stored == shape, || format!("{name} has the shape {stored:?} instead of {shape:?}"))
}

/// Number type of a variable of the schema.
fn kind_of(variable: &Variable) -> TypeDescriptor {
    match variable.codes() {
        Some(_) => TypeDescriptor::Integer(IntSize::U1),
        None => TypeDescriptor::Float(FloatSize::U8),
    }
}

/// Number type of a stored dataset; an error for a type that has no description.
pub(super) fn kind(dataset: &Dataset) -> hdf5::Result<TypeDescriptor> {
    dataset.dtype()?.to_descriptor()
}

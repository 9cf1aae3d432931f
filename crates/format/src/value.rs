//! Reads and writes attributes of the HDF5 file.

use std::collections::BTreeMap;

use hdf5::Location;
use hdf5::types::{FloatSize, IntSize, TypeDescriptor, VarLenAscii, VarLenUnicode};

use slipmap_map::dataset::Value;

use super::sys::{self, Ending};

/// Largest number of values of an attribute that is read; attributes of maps have a dozen at most.
const MOST_VALUES: usize = 1 << 16;

/// Attaches `value` to `place`; an empty text or list is left out.
pub(super) fn write(place: &Location, name: &str, value: &Value) -> hdf5::Result<()> {
    fn numbers<T: hdf5::H5Type>(place: &Location, name: &str, values: &[T]) -> hdf5::Result<()> {
        match values {
            [] => Ok(()),
            [one] => place.new_attr::<T>().create(name)?.write_scalar(one),
            many => place.new_attr_builder().with_data(many).create(name).map(drop),
        }
    }
    match value {
        Value::Text(text) if text.is_empty() => Ok(()),
        Value::Text(text) => sys::write_text(place, name, text, Ending::Exact),
        Value::Integers(values) => numbers(place, name, values),
        Value::Codes(values) => numbers(place, name, values),
        Value::Reals(values) => numbers(place, name, values),
    }
}

/// Reads an attribute; `None` if it has a type or shape that no map uses.
pub(super) fn read(place: &Location, name: &str) -> hdf5::Result<Option<Value>> {
    let attribute = place.attr(name)?;
    if attribute.ndim() > 1 || attribute.size() > MOST_VALUES {
        return Ok(None);
    }
    let Ok(kind) = attribute.dtype()?.to_descriptor() else { return Ok(None) };
    Ok(match kind {
        // Many texts may be the same long one.
        TypeDescriptor::VarLenUnicode | TypeDescriptor::VarLenAscii if attribute.size() != 1 => None,
        TypeDescriptor::FixedAscii(_) | TypeDescriptor::FixedUnicode(_) => {
            sys::read_fixed_text(&attribute)?.map(Value::Text)
        }
        // Tools that copy maps write texts of variable length.
        TypeDescriptor::VarLenUnicode => foreign_text(&attribute.read_raw::<VarLenUnicode>()?)?,
        TypeDescriptor::VarLenAscii => foreign_text(&attribute.read_raw::<VarLenAscii>()?)?,
        TypeDescriptor::Integer(IntSize::U1) => Some(Value::Codes(attribute.read_raw()?)),
        TypeDescriptor::Integer(_) => Some(Value::Integers(attribute.read_raw()?)),
        TypeDescriptor::Float(FloatSize::U8) => Some(Value::Reals(attribute.read_raw()?)),
        _ => None,
    })
}

/// Decodes a text whose bytes the library has not validated; `None` unless there is exactly one text.
fn foreign_text<T: AsRef<[u8]>>(texts: &[T]) -> hdf5::Result<Option<Value>> {
    let [text] = texts else { return Ok(None) };
    let text = std::str::from_utf8(text.as_ref()).map_err(|_| hdf5::Error::from("the text is not UTF-8"))?;
    Ok(Some(Value::Text(text.into())))
}

/// Reads every attribute of `place` that has a type that maps use.
pub(super) fn read_all(place: &Location) -> hdf5::Result<BTreeMap<String, Value>> {
    let value = |name: String| Ok(read(place, &name)?.map(|value| (name, value)));
    place.attr_names()?.into_iter().filter_map(|name| value(name).transpose()).collect()
}

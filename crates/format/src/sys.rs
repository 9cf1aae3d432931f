//! Calls of the HDF5 C library that the safe layer does not offer.
//!
//! This is the only module with unsafe code. Every call runs inside [`hdf5::sync::sync`], the lock that the
//! safe layer takes around its own calls, because the system's library is not thread-safe. The identifiers
//! come from live objects of the safe layer, borrowed for the whole call. The length of every buffer is at
//! least the number of bytes that the library reads or writes.
#![allow(unsafe_code)]

use hdf5::types::TypeDescriptor;
use hdf5::{Attribute, Dataset, Datatype, Error, File, H5Type, Location, ObjectReference1};
use hdf5_sys::h5::{herr_t, hsize_t};
use hdf5_sys::h5a::{H5Aread, H5Awrite};
use hdf5_sys::h5d::H5Dwrite_chunk;
#[cfg(unix)]
use hdf5_sys::h5f::H5Fget_vfd_handle;
use hdf5_sys::h5p::H5P_DEFAULT;
use hdf5_sys::h5t::{H5T_str_t, H5Tset_strpad};

/// Returns the library's error if `status` reports one. To be called under the lock.
fn checked(status: herr_t) -> hdf5::Result<()> {
    if status < 0 { Err(Error::query().unwrap_or_else(|error| error)) } else { Ok(()) }
}

/// Writes one chunk as stored in the file, with all filters applied.
///
/// # Panics
/// If `offset` does not have one entry per dimension.
pub(super) fn write_chunk(dataset: &Dataset, offset: &[usize], bytes: &[u8]) -> hdf5::Result<()> {
    assert_eq!(offset.len(), dataset.ndim(), "one offset per dimension");
    let offset: Vec<hsize_t> = offset.iter().map(|&start| start as hsize_t).collect();
    hdf5::sync::sync(|| {
        // SAFETY: the library reads `offset.len()` offsets (asserted above) and `bytes.len()` bytes.
        checked(unsafe {
            H5Dwrite_chunk(dataset.id(), H5P_DEFAULT, 0, offset.as_ptr(), bytes.len(), bytes.as_ptr().cast())
        })
    })
}

/// Releases the library's lock on a file that is about to be closed.
///
/// Closing the file does not suffice: the lock belongs to the open file description, which a process started
/// meanwhile by another thread inherits. The file would stay locked for as long as that process runs.
///
/// # Errors
/// The library's own. A file system without locks is no error.
#[cfg(unix)]
pub(super) fn unlock(file: &File) -> hdf5::Result<()> {
    hdf5::sync::sync(|| {
        let mut handle = std::ptr::null_mut();
        // SAFETY: the library stores one pointer.
        checked(unsafe { H5Fget_vfd_handle(file.id(), H5P_DEFAULT, &raw mut handle) })?;
        // SAFETY: for the default driver, with which all our files are opened, that pointer is to the file
        // descriptor, which stays open while `file` lives.
        let descriptor = unsafe { std::os::fd::BorrowedFd::borrow_raw(*handle.cast::<i32>()) };
        let _ = rustix::fs::flock(descriptor, rustix::fs::FlockOperation::Unlock);
        Ok(())
    })
}

/// On other systems locks are not inherited.
#[cfg(not(unix))]
pub(super) fn unlock(_: &File) -> hdf5::Result<()> {
    Ok(())
}

/// The termination of a text of fixed length.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// Not terminated: UTF-8 of exactly the text's length.
    Exact,
    /// Terminated by a zero byte: ASCII, as the dimension-scale specification requires.
    Zero,
}

/// Writes a text attribute of fixed length. Such a text is stored in the object's header, under a checksum
/// (texts of variable length are stored elsewhere, without one), and every NetCDF tool can read it.
///
/// # Errors
/// The library's own; an empty text cannot be stored.
pub(super) fn write_text(place: &Location, name: &str, text: &str, ending: Ending) -> hdf5::Result<()> {
    let mut bytes = text.as_bytes().to_vec();
    let datatype = match ending {
        Ending::Exact => Datatype::from_descriptor(&TypeDescriptor::FixedUnicode(bytes.len()))?,
        Ending::Zero => {
            bytes.push(0);
            let datatype = Datatype::from_descriptor(&TypeDescriptor::FixedAscii(bytes.len()))?;
            // SAFETY: changes a datatype that only this function holds.
            hdf5::sync::sync(|| {
                checked(unsafe { H5Tset_strpad(datatype.id(), H5T_str_t::H5T_STR_NULLTERM) })
            })?;
            datatype
        }
    };
    let attribute = place.new_attr_builder().empty_as(&datatype).create(name)?;
    hdf5::sync::sync(|| {
        // SAFETY: one element of `datatype`, whose size is `bytes.len()`.
        checked(unsafe { H5Awrite(attribute.id(), datatype.id(), bytes.as_ptr().cast()) })
    })
}

/// Reads a text of fixed length; `None` if the attribute has another type.
///
/// # Errors
/// The library's own, or that the text is not UTF-8.
pub(super) fn read_fixed_text(attribute: &Attribute) -> hdf5::Result<Option<String>> {
    let datatype = attribute.dtype()?;
    let (TypeDescriptor::FixedUnicode(size) | TypeDescriptor::FixedAscii(size)) = datatype.to_descriptor()?
    else {
        return Ok(None);
    };
    if attribute.size() != 1 {
        return Ok(None);
    }
    let mut bytes = vec![0u8; size];
    hdf5::sync::sync(|| {
        // SAFETY: one element of `datatype`, whose size is `bytes.len()`.
        checked(unsafe { H5Aread(attribute.id(), datatype.id(), bytes.as_mut_ptr().cast()) })
    })?;
    while bytes.last() == Some(&0) {
        bytes.pop();
    }
    String::from_utf8(bytes).map(Some).map_err(|_| Error::from("the text is not UTF-8"))
}

/// An entry of a dimension scale's `REFERENCE_LIST`: a variable that uses the scale, and the dimension of the
/// variable that it is. The layout is that of the dimension-scale specification.
#[derive(Clone, Copy, H5Type)]
#[repr(C)]
pub(super) struct ScaleUse {
    pub(super) dataset: ObjectReference1,
    pub(super) dimension: i32,
}

/// The file address of a reference; it is not dereferenced.
pub(super) fn address(reference: ObjectReference1) -> u64 {
    // SAFETY: the safe layer declares the type as a transparent wrapper of HDF5's `hobj_ref_t`, which is a
    // `u64`; were their sizes to differ, this would not compile.
    unsafe { std::mem::transmute::<ObjectReference1, u64>(reference) }
}

//! Creates HDF5 files and groups in the form that all NetCDF-4 tools read.

use std::path::Path;

use hdf5::file::{FileCloseDegree, LibraryVersion};
use hdf5::plist::DatasetCreateBuilder;
use hdf5::plist::file_create::{AttrCreationOrder, AttrPhaseChange, LinkCreationOrder};
use hdf5::{File, Group};

/// Creates the HDF5 file.
///
/// The format is that of HDF5 1.8: its metadata have checksums, and every NetCDF-4 reader supports it. Later
/// formats are not supported everywhere (netcdf-java, the reader in Panoply, has its own implementation).
/// Creation order is recorded because NetCDF lists dimensions, variables and attributes in that order.
pub(super) fn create_file(path: &Path) -> hdf5::Result<File> {
    hdf5::FileBuilder::new()
        .with_fapl(|access| {
            access
                .libver_bounds(LibraryVersion::V18, LibraryVersion::V18)
                .fclose_degree(FileCloseDegree::Strong)
        })
        .with_fcpl(|creation| {
            creation
                .link_creation_order(LinkCreationOrder::Indexed)
                .attr_creation_order(AttrCreationOrder::Indexed)
                .attr_phase_change(ATTRIBUTES_IN_HEADER.max_compact, ATTRIBUTES_IN_HEADER.min_dense)
                .obj_track_times(false)
        })
        .create(path)
}

/// Creates a group whose members and attributes NetCDF lists in the order of creation.
pub(super) fn group_of_tables(file: &File, name: &str) -> hdf5::Result<Group> {
    file.create_group_builder()
        .with_create_plist(|creation| {
            creation
                .link_creation_order(LinkCreationOrder::Indexed)
                .attr_creation_order(AttrCreationOrder::Indexed)
                .attr_phase_change(ATTRIBUTES_IN_HEADER.max_compact, ATTRIBUTES_IN_HEADER.min_dense)
                .obj_track_times(false)
        })
        .create(name)
}

/// For datasets whose attributes NetCDF lists in the order of creation.
pub(super) fn in_order(creation: &mut DatasetCreateBuilder) -> &mut DatasetCreateBuilder {
    creation
        .attr_creation_order(AttrCreationOrder::Indexed)
        .attr_phase_change(ATTRIBUTES_IN_HEADER.max_compact, ATTRIBUTES_IN_HEADER.min_dense)
}

/// Stores attributes in the header of their object, not in a separate heap: the simplest form for readers.
const ATTRIBUTES_IN_HEADER: AttrPhaseChange = AttrPhaseChange { max_compact: 1024, min_dense: 0 };

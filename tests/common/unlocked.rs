//! HDF5 files as tests open them.

/// Without locks: tests that start processes beside this one hand them its locks for a moment.
pub fn unlocked() -> hdf5::FileBuilder {
    let mut builder = hdf5::File::with_options();
    builder.with_fapl(|access| access.file_locking(false));
    builder
}

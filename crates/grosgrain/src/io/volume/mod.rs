//! Volume files: NIfTI, NRRD, MetaImage, TIFF stacks, NPY and DICOM series become a [`Volume`], and back.
//!
//! Every reader checks what a header claims against the bytes that are there before it makes room for it.

mod dicom;
mod format;
mod geometry;
mod inflate;
mod metaimage;
mod nifti;
mod npy;
mod nrrd;
mod read_error;
mod samples;
mod source;
mod text_header;
mod tiff_stack;
mod units;
mod write;

pub use dicom::{DicomError, SeriesSummary, read_dicom};
pub use format::VolumeFormat;
pub use metaimage::read_metaimage;
pub use nifti::{read_nifti, read_nifti_pair};
pub use npy::read_npy;
pub use nrrd::read_nrrd;
pub use read_error::ReadError;
pub use tiff_stack::read_tiff;
pub use write::{WriteError, write_volume};

use crate::mesh::Volume;
use std::path::Path;

/// Reads a volume file or a folder of slices; what it is, is seen from its content, else from its name.
///
/// Files: NIfTI-1 and -2 (`.nii`, `.nii.gz`, `.hdr` with `.img`), NRRD (`.nrrd`, `.nhdr`), MetaImage (`.mha`, `.mhd`),
/// TIFF (`.tif`, pages along z), NPY (`.npy`, axes z, y, x). Folders: `.tif` files in the order of the numbers
/// in their names, else DICOM slices of one series.
///
/// # Errors
/// [`ReadError::InFile`] with the path and the reason.
pub fn read_volume(path: impl AsRef<Path>) -> Result<Volume, ReadError> {
    let path = path.as_ref();
    let volume = match path.is_dir() {
        true => source::read_folder(path),
        false => source::read_one(path),
    };
    volume.map_err(|e| e.in_file(path))
}

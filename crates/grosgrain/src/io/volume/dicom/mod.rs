//! DICOM series: the files of a folder are the layers of one volume.
//!
//! Own code for the small part of DICOM that a series of grey slices needs: `dicom-object` allocates what an
//! element's length claims (up to 4 GB from a file of a few bytes) and the decoders of `dicom-pixeldata`
//! panic on damaged RLE and JPEG frames.

mod data_set;
mod error;
mod rle;
mod series;
mod slice;

use super::ReadError;
use crate::mesh::Volume;
use series::assemble;
use slice::Slice;
use std::path::Path;

pub use error::{DicomError, SeriesSummary};

/// Reads a DICOM series from the names and bytes of its files, in any order.
///
/// Slices are sorted along their normal (`ImagePositionPatient`); spacing comes from `PixelSpacing` and the
/// distance of the slices; rescale slope and intercept are applied. Files without an image (DICOMDIR, reports)
/// are passed over. Uncompressed and RLE slices are read.
///
/// # Errors
/// Damaged files, several series, several images at one place, slices that differ in size, orientation or
/// distance (by more than 1 %), compressed or multi-frame images, NaN.
pub fn read_dicom<'a>(files: impl IntoIterator<Item = (&'a str, &'a [u8])>) -> Result<Volume, ReadError> {
    let mut slices = Vec::new();
    for (name, bytes) in files {
        slices.extend(slice(name, bytes)?);
    }
    assemble(slices)
}

/// Reads the DICOM files among those of a folder.
pub(super) fn read_files(
    paths: &[impl AsRef<Path>],
    read: impl Fn(&Path) -> Result<Option<Vec<u8>>, ReadError>,
) -> Result<Volume, ReadError> {
    let mut slices = Vec::new();
    for path in paths {
        let path = path.as_ref();
        if let Some(bytes) = read(path)? {
            slices.extend(slice(&path.to_string_lossy(), &bytes)?);
        }
    }
    match slices.is_empty() {
        true => Err(ReadError::NoSlices { files: paths.len() }),
        false => assemble(slices),
    }
}

fn slice(name: &str, bytes: &[u8]) -> Result<Option<Slice>, ReadError> {
    Slice::parse(name, bytes).map_err(|e| e.in_file(Path::new(name)))
}

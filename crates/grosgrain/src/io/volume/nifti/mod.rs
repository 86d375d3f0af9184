//! NIfTI-1 and NIfTI-2, one file or a header with its image, plain or gzip, either byte order.
//!
//! Own code because the `nifti` crate 0.18 knows only version 1, and every size here is checked before it is allocated.

mod header;
mod write;

use super::inflate::{inflate, is_gzip};
use super::samples::SampleLayout;
use super::{ReadError, VolumeFormat};
use crate::mesh::Volume;
use header::{HEADER_BYTES, Header};
use std::borrow::Cow;

pub(super) use write::write;

/// Reads a single NIfTI file (`.nii` or `.nii.gz`) from its bytes.
///
/// The spacing is the length of the columns of the sform, else of the qform, else `pixdim`;
/// lengths without a unit are taken as millimetres. `scl_slope` (unless 0) and `scl_inter` are applied.
///
/// # Errors
/// Not NIfTI, truncated, a voxel type that is not a real number, a time or vector axis, bad spacing, NaN.
pub fn read_nifti(bytes: &[u8]) -> Result<Volume, ReadError> {
    let header = Header::parse(&leading(bytes, HEADER_BYTES)?)?;
    if header.detached {
        return Err(ReadError::Unsupported {
            what: "a NIfTI header whose voxels stand in another file".into(),
            remedy: "give the path of the .hdr with the .img beside it",
        });
    }
    volume(&header, bytes)
}

/// Reads a NIfTI header (`.hdr`) and its image (`.img`), each plain or gzip, from their bytes.
///
/// # Errors
/// As [`read_nifti`].
pub fn read_nifti_pair(header: &[u8], image: &[u8]) -> Result<Volume, ReadError> {
    volume(&Header::parse(&leading(header, HEADER_BYTES)?)?, image)
}

fn volume(header: &Header, bytes: &[u8]) -> Result<Volume, ReadError> {
    let layout = header.layout()?;
    let geometry = header.geometry(layout.cells)?;
    let mut values = voxels(header.data_offset, &layout, bytes)?;
    if let Some((slope, intercept)) = header.scaling {
        values.iter_mut().for_each(|v| *v = *v * slope + intercept);
    }
    geometry.with_values(values)
}

fn voxels(offset: usize, layout: &SampleLayout, bytes: &[u8]) -> Result<Vec<f64>, ReadError> {
    let end = offset.checked_add(layout.byte_count()).ok_or(ReadError::Field {
        format: VolumeFormat::Nifti,
        field: "vox_offset".into(),
        value: offset.to_string(),
        expected: "the position of the voxel data in the file",
    })?;
    let content = match is_gzip(bytes) {
        true => Cow::Owned(inflate(bytes, end, "voxel data")?),
        false => Cow::Borrowed(bytes),
    };
    layout.decode(content.get(offset..).unwrap_or_default())
}

/// At most `count` bytes from the start of the content.
fn leading(bytes: &[u8], count: usize) -> Result<Cow<'_, [u8]>, ReadError> {
    match is_gzip(bytes) {
        true => super::inflate::inflate_at_most(bytes, count).map(Cow::Owned),
        false => Ok(Cow::Borrowed(&bytes[..bytes.len().min(count)])),
    }
}

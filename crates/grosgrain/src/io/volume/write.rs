//! A volume as a file; the name says in which format.

use super::{VolumeFormat, metaimage, nifti, npy, nrrd};
use crate::io::write_atomically;
use crate::mesh::Volume;
use std::path::{Path, PathBuf};

/// Why a volume is not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum WriteError {
    /// Something is wrong with the output; its path and the reason.
    #[error("{}: {reason}", path.display())]
    InFile {
        /// The output.
        path: PathBuf,
        /// What is wrong.
        reason: Box<WriteError>,
    },
    /// The operating system refuses.
    #[error("cannot be written: {0}")]
    Io(#[from] std::io::Error),
    /// The name is that of no format that is written.
    #[error("no volume format is written under this name; use .nii, .nii.gz, .nrrd, .mha, .mhd or .npy")]
    UnknownFormat,
    /// NIfTI cannot leave the spacing open.
    #[error("NIfTI needs a voxel spacing and the volume has none; give one, or write .nrrd, .mha or .npy")]
    NoSpacing,
    /// An extent beyond the format's 16 bits.
    #[error("the extents {0:?} exceed the 32767 voxels per axis of NIfTI-1; write .nrrd, .mha or .npy")]
    NiftiExtent([usize; 3]),
    /// The number of values is not that of the voxels.
    #[error("the volume has {found} values for {expected} voxels")]
    Length {
        /// Number of values.
        found: usize,
        /// Number of voxels.
        expected: usize,
    },
    /// A voxel edge that no reader would accept.
    #[error("the voxel spacing {0:?} m must be positive and finite along every axis")]
    Spacing([f64; 3]),
}

/// Writes a volume in the format that the name stands for; whatever was there is replaced at the end, at once.
///
/// NIfTI-1 (`.nii`, `.nii.gz`) with sform and millimetres, NRRD (`.nrrd`, gzip), MetaImage (`.mha` with zlib, `.mhd`
/// with a `.raw` beside it), NPY (C order, axes z, y, x, without spacing). Whole numbers are written as
/// the smallest of u8, i16, i32 that holds all of them, everything else as f64. NIfTI-1 holds spacing and axes in single precision.
///
/// # Errors
/// [`WriteError::InFile`] with the path and the reason.
pub fn write_volume(path: impl AsRef<Path>, volume: &Volume) -> Result<(), WriteError> {
    let path = path.as_ref();
    let written = validate(volume).and_then(|()| write_as(path, volume));
    written.map_err(|reason| WriteError::InFile { path: path.to_path_buf(), reason: Box::new(reason) })
}

fn write_as(path: &Path, volume: &Volume) -> Result<(), WriteError> {
    let name = path.file_name().unwrap_or_default().to_string_lossy().to_ascii_lowercase();
    match VolumeFormat::of_name(path) {
        Some(VolumeFormat::Nifti) if name.ends_with(".nii") || name.ends_with(".nii.gz") => {
            write_atomically(path, |out| nifti::write(out, volume, name.ends_with(".gz")))
        }
        Some(VolumeFormat::Nrrd) if name.ends_with(".nrrd") => write_atomically(path, |out| nrrd::write(out, volume)),
        Some(VolumeFormat::MetaImage) if name.ends_with(".mhd") => {
            let data = path.with_extension("raw");
            let data_name = data.file_name().unwrap_or_default().to_string_lossy();
            write_atomically(&data, |out| metaimage::write_voxels(out, volume))?;
            write_atomically(path, |out| metaimage::write_header(out, volume, &data_name))
        }
        Some(VolumeFormat::MetaImage) => write_atomically(path, |out| metaimage::write_local(out, volume)),
        Some(VolumeFormat::Npy) => write_atomically(path, |out| npy::write(out, volume)),
        _ => Err(WriteError::UnknownFormat),
    }
}

fn validate(volume: &Volume) -> Result<(), WriteError> {
    let expected = volume.cells.iter().product();
    if volume.values.len() != expected {
        return Err(WriteError::Length { found: volume.values.len(), expected });
    }
    match volume.spacing {
        Some(spacing) if !spacing.iter().all(|h| h.is_finite() && *h > 0.0) => Err(WriteError::Spacing(spacing)),
        _ => Ok(()),
    }
}

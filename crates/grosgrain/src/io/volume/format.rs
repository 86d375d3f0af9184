//! Which format a file has, by its first bytes and its name.

use std::fmt;
use std::path::Path;

/// A volume format.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum VolumeFormat {
    /// NIfTI-1 or NIfTI-2: `.nii`, `.nii.gz`, `.hdr` with `.img`.
    Nifti,
    /// NRRD: `.nrrd`, `.nhdr` with detached data.
    Nrrd,
    /// MetaImage: `.mha`, `.mhd` with `.raw`.
    MetaImage,
    /// A TIFF stack.
    Tiff,
    /// A NumPy array.
    Npy,
    /// A DICOM series.
    Dicom,
}

impl VolumeFormat {
    /// The format that a file's extension stands for; `None` if for none.
    pub fn of_name(path: &Path) -> Option<Self> {
        let name = path.file_name()?.to_string_lossy().to_ascii_lowercase();
        let endings: [(&[&str], Self); 6] = [
            (&[".nii", ".nii.gz", ".hdr", ".hdr.gz", ".img", ".img.gz"], Self::Nifti),
            (&[".nrrd", ".nhdr"], Self::Nrrd),
            (&[".mha", ".mhd"], Self::MetaImage),
            (&[".tif", ".tiff"], Self::Tiff),
            (&[".npy"], Self::Npy),
            (&[".dcm"], Self::Dicom),
        ];
        endings.iter().find(|(ends, _)| ends.iter().any(|e| name.ends_with(e))).map(|(_, format)| *format)
    }

    /// The format that a file's content shows by its first bytes; `None` if none of the known marks stands there.
    pub fn of_content(bytes: &[u8]) -> Option<Self> {
        let header_size = bytes.first_chunk::<4>().map(|b| (u32::from_le_bytes(*b), u32::from_be_bytes(*b)));
        if let Some((348 | 540, _) | (_, 348 | 540)) = header_size {
            return Some(Self::Nifti);
        }
        let marks: [(&[u8], Self); 6] = [
            (b"NRRD000", Self::Nrrd),
            (b"\x93NUMPY", Self::Npy),
            (b"II*\0", Self::Tiff),
            (b"MM\0*", Self::Tiff),
            (b"II+\0", Self::Tiff),
            (b"MM\0+", Self::Tiff),
        ];
        if let Some((_, format)) = marks.iter().find(|(mark, _)| bytes.starts_with(mark)) {
            return Some(*format);
        }
        match bytes {
            [b'O', b'b', b'j', b'e', b'c', b't', b'T', b'y', b'p', b'e', ..] => Some(Self::MetaImage),
            [b'N', b'D', b'i', b'm', b's', ..] => Some(Self::MetaImage),
            _ if bytes.get(128..132) == Some(b"DICM") => Some(Self::Dicom),
            _ => None,
        }
    }
}

impl fmt::Display for VolumeFormat {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Nifti => "NIfTI",
            Self::Nrrd => "NRRD",
            Self::MetaImage => "MetaImage",
            Self::Tiff => "TIFF",
            Self::Npy => "NPY",
            Self::Dicom => "DICOM",
        })
    }
}

//! Why a volume is not read.

use super::VolumeFormat;
use super::dicom::DicomError;
pub(super) use crate::io::excerpt::excerpt;
use std::path::{Path, PathBuf};

/// Why a volume is not read: the place, the numbers and what to do.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ReadError {
    /// Something is wrong with a file; its path and the reason.
    #[error("{}: {reason}", path.display())]
    InFile {
        /// The file or folder.
        path: PathBuf,
        /// What is wrong with it.
        reason: Box<ReadError>,
    },
    /// The operating system refuses.
    #[error("cannot be read: {0}")]
    Io(#[from] std::io::Error),
    /// The path is neither a regular file nor a folder.
    #[error("is not a regular file; give the path of a volume file or of a folder of slices")]
    NotAFile,
    /// Neither name nor content is that of a known format.
    #[error(
        "is in no format that is read: known are NIfTI (.nii, .nii.gz, .hdr with .img), NRRD (.nrrd, .nhdr), MetaImage \
         (.mha, .mhd), TIFF (.tif, or a folder of them), NumPy (.npy) and folders of DICOM slices. Raw voxel \
         data need a header, e.g. a .mhd file"
    )]
    UnknownFormat,
    /// A folder without TIFF pages or DICOM slices.
    #[error("the folder holds neither .tif files nor DICOM slices ({files} files were looked at)")]
    NoSlices {
        /// Number of files in the folder.
        files: usize,
    },
    /// The file is shorter than its header says.
    #[error("the {part} are cut off: {needed} bytes are needed, {found} are there; fetch or write the file again")]
    Truncated {
        /// Which part of the file.
        part: &'static str,
        /// Bytes that the header asks for.
        needed: u64,
        /// Bytes that are there.
        found: u64,
    },
    /// Fewer text-encoded values than the header says.
    #[error(
        "the voxel data are cut off: {needed} numbers are needed, {found} are there; fetch or write the file again"
    )]
    TextTruncated {
        /// Numbers that the header asks for.
        needed: u64,
        /// Numbers that are there.
        found: u64,
    },
    /// Compressed data cannot be expanded.
    #[error("the compressed data are damaged or cut off ({0}); fetch or write the file again")]
    Compression(std::io::Error),
    /// A header field has an unusable value.
    #[error("the {format} header's {field} is {value}; expected: {expected}")]
    Field {
        /// The format of the header.
        format: VolumeFormat,
        /// The field's name.
        field: String,
        /// What stands there.
        value: String,
        /// What must stand there, or what to do.
        expected: &'static str,
    },
    /// A header field is absent.
    #[error("the {format} header has no {field}; it is needed to know how the voxels are stored")]
    MissingField {
        /// The format of the header.
        format: VolumeFormat,
        /// The field's name.
        field: &'static str,
    },
    /// The volume has no voxels.
    #[error("the volume has no voxels: its extents along x, y, z are {}; every one must be at least 1", times(.0))]
    ZeroExtent([u64; 3]),
    /// The number of voxels exceeds what memory can address.
    #[error("the volume claims {} voxels, more than memory can address; the header is wrong", times(.0))]
    TooLarge([u64; 3]),
    /// Not three axes.
    #[error("the volume has {found} axes; three are needed (x, y, z). Save one three-dimensional volume")]
    Axes {
        /// Number of axes.
        found: u64,
    },
    /// Several volumes in one file.
    #[error("the file has {count} {kind}; choose one and save it as a three-dimensional volume, e.g. {example}")]
    SeveralVolumes {
        /// How many.
        count: u64,
        /// What they are: time points, components.
        kind: &'static str,
        /// How to take out one.
        example: &'static str,
    },
    /// A voxel edge is zero, negative, infinite or NaN.
    #[error(
        "the voxel spacing along {axis} is {value} (from {field}); it must be positive and finite. Correct the header"
    )]
    Spacing {
        /// x, y or z.
        axis: char,
        /// The value as stored.
        value: f64,
        /// The field it comes from.
        field: &'static str,
    },
    /// Some voxels hold no number.
    #[error(
        "{count} of {total} voxels are NaN, the first at ({}, {}, {}); replace them by the value of the surroundings or of the background",
        first[0], first[1], first[2]
    )]
    NotANumber {
        /// Number of NaN voxels.
        count: usize,
        /// Number of voxels.
        total: usize,
        /// Position of the first.
        first: [usize; 3],
    },
    /// A 64-bit integer that f64 cannot hold exactly.
    #[error(
        "the integer {value:e} of voxel ({}, {}, {}) is beyond 2^53 and would be rounded; save the volume in a smaller integer type",
        at[0], at[1], at[2]
    )]
    WideInteger {
        /// The value, rounded.
        value: f64,
        /// The voxel's position.
        at: [usize; 3],
    },
    /// A text-encoded value is not a number.
    #[error("value {index} of the text-encoded voxels is `{text}`, not a number of type {expected}")]
    Text {
        /// Which value, from 0.
        index: usize,
        /// What stands there.
        text: String,
        /// The type that the header names.
        expected: &'static str,
    },
    /// A valid file of a kind that is not read.
    #[error("{what} cannot be read; {remedy}")]
    Unsupported {
        /// The voxel type, encoding or arrangement.
        what: String,
        /// What to do.
        remedy: &'static str,
    },
    /// The TIFF structure is damaged.
    #[error("the TIFF structure of page {page} is damaged: {reason}; write the file again")]
    Tiff {
        /// Which page, from 1.
        page: usize,
        /// What the decoder says.
        reason: tiff::TiffError,
    },
    /// The pages of a TIFF stack differ in size.
    #[error(
        "page {page} of the TIFF stack has {} × {} pixels, the first has {} × {}; all must agree (is it a thumbnail?)",
        found[0], found[1], expected[0], expected[1]
    )]
    PageSize {
        /// Which page or file, from 1.
        page: usize,
        /// Its width and height.
        found: [u32; 2],
        /// Width and height of the first.
        expected: [u32; 2],
    },
    /// Something is wrong with the slices of a DICOM series.
    #[error(transparent)]
    Dicom(#[from] DicomError),
}

impl ReadError {
    /// Names the file in which the failure happened, unless it is already named.
    pub(super) fn in_file(self, path: &Path) -> Self {
        match self {
            Self::InFile { .. } => self,
            reason => Self::InFile { path: path.to_path_buf(), reason: Box::new(reason) },
        }
    }
}

fn times(extents: &[u64; 3]) -> String {
    format!("{} × {} × {}", extents[0], extents[1], extents[2])
}

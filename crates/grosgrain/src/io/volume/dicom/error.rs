//! Why a DICOM series is not read.

/// Why a DICOM series is not read.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum DicomError {
    /// The preamble is missing.
    #[error("is not a DICOM file: the mark DICM is missing at byte 128")]
    NoMark,
    /// The element structure is damaged.
    #[error("the DICOM elements are damaged at byte {at}: {reason}; fetch or export the file again")]
    Damaged {
        /// Position in the file.
        at: usize,
        /// What is wrong there.
        reason: &'static str,
    },
    /// An element is absent.
    #[error("the DICOM element {0} is missing; it is needed to place the slice")]
    Missing(&'static str),
    /// An element has an unusable value.
    #[error("the DICOM element {element} is `{value}`; expected: {expected}")]
    Element {
        /// Name of the element.
        element: &'static str,
        /// What stands there.
        value: String,
        /// What must stand there.
        expected: &'static str,
    },
    /// A compressed or unknown transfer syntax.
    #[error(
        "the transfer syntax {uid} ({name}) is not read; expand the slices first, e.g. with \
         `gdcmconv --raw in.dcm out.dcm`, or convert the series with dcm2niix"
    )]
    TransferSyntax {
        /// Its identifier.
        uid: String,
        /// Its name.
        name: &'static str,
    },
    /// Several frames in one file.
    #[error("the file holds {frames} frames; multi-frame DICOM is not read. Convert it to NIfTI, e.g. with dcm2niix")]
    MultiFrame {
        /// How many.
        frames: u64,
    },
    /// More than one series in the folder.
    #[error("the folder holds {} series: {}. Give a folder that holds one of them only", .0.len(), list(.0))]
    SeveralSeries(Vec<SeriesSummary>),
    /// A slice differs from the first in rows or columns.
    #[error(
        "slice {file} has {} × {} pixels, the first has {} × {}; take the odd one (a localiser?) out of the folder",
        found[0], found[1], expected[0], expected[1]
    )]
    Size {
        /// The slice's file.
        file: String,
        /// Its columns and rows.
        found: [u32; 2],
        /// Columns and rows of the first slice.
        expected: [u32; 2],
    },
    /// A slice differs from the first in orientation or pixel spacing.
    #[error("slice {file} has another {what} than the first slice; take it out of the folder")]
    Differs {
        /// The slice's file.
        file: String,
        /// Orientation or pixel spacing.
        what: &'static str,
    },
    /// Two slices at one place.
    #[error(
        "slices {first} and {second} both lie at {position} mm: the folder holds several volumes (time points, \
         echoes, phases) or a slice twice; give a folder that holds one volume only"
    )]
    SamePlace {
        /// One slice's file.
        first: String,
        /// The other's.
        second: String,
        /// Position along the normal \[mm\].
        position: f64,
    },
    /// Unequal distances.
    #[error(
        "slices {first} and {second} are {distance} mm apart where the mean distance is {mean} mm: a slice is missing \
         or the distances vary; complete or resample the series"
    )]
    Distance {
        /// One slice's file.
        first: String,
        /// The next one's.
        second: String,
        /// Their distance \[mm\].
        distance: f64,
        /// Mean distance \[mm\].
        mean: f64,
    },
    /// The slices are not stacked along their normal.
    #[error(
        "slice {file} is shifted by {shift} mm within its plane against a straight stack (a tilted gantry?); resample \
         the series to a straight one, e.g. with dcm2niix"
    )]
    Sheared {
        /// The slice's file.
        file: String,
        /// In-plane shift \[mm\].
        shift: f64,
    },
    /// A single slice without thickness.
    #[error("the folder holds one slice only and no SliceThickness; the distance of slices is unknown")]
    SingleSlice,
}

/// What tells one series from another.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SeriesSummary {
    /// `SeriesInstanceUID`.
    pub uid: String,
    /// `SeriesNumber` and `SeriesDescription`, as far as given.
    pub description: String,
    /// Number of slices.
    pub slices: usize,
    /// One of the files.
    pub file: String,
}

fn list(series: &[SeriesSummary]) -> String {
    let one =
        |s: &SeriesSummary| format!("`{}` with {} slices, e.g. {} (UID {})", s.description, s.slices, s.file, s.uid);
    series.iter().map(one).collect::<Vec<_>>().join("; ")
}

//! Why a VTK file is not written.

/// Why a VTK file is not written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VtkError {
    /// The grid has no cells.
    #[error("the grid has no cells; there is nothing to write")]
    Empty,
    /// A cell names a point that does not exist.
    #[error("cell {cell} names point {point}, but there are only {points}")]
    Corner {
        /// The cell.
        cell: usize,
        /// The point it names.
        point: usize,
        /// How many points there are.
        points: usize,
    },
    /// An array does not have one entry per point or cell.
    #[error("array \"{name}\" holds {found} entries for {expected} {per}; one each is needed")]
    Length {
        /// The array's name.
        name: String,
        /// How many entries it holds.
        found: usize,
        /// How many it must hold.
        expected: usize,
        /// What one entry belongs to.
        per: &'static str,
    },
    /// Two arrays of points, or two of cells, have the same name.
    #[error("two arrays of {per} are named \"{name}\"; readers would show only one")]
    Duplicate {
        /// The name.
        name: String,
        /// What the arrays belong to.
        per: &'static str,
    },
    /// A number is NaN or infinite.
    #[error("entry {index} of \"{name}\" is {value}; only finite numbers are written, check the solve that made it")]
    NotFinite {
        /// The array's name.
        name: String,
        /// Index of the point or cell.
        index: usize,
        /// The offending number.
        value: f64,
    },
    /// Tensors of several dimensions in one array.
    #[error(
        "entry {index} of \"{name}\" is a tensor of another dimension than entry 0; an array holds tensors of one dimension"
    )]
    Dimensions {
        /// The array's name.
        name: String,
        /// Index of the first entry that differs.
        index: usize,
    },
    /// A time is NaN or infinite, or earlier than the frame before.
    #[error("frame {frame} has time {time} s after {before} s; times must be finite and must not decrease")]
    Time {
        /// Index of the frame.
        frame: usize,
        /// Its time.
        time: f64,
        /// Time of the frame before.
        before: f64,
    },
    /// A frame's file is named by an absolute path, which breaks when the folder moves.
    #[error("frame file \"{0}\" must be named relative to the series file, with / between folders")]
    Path(String),
    /// The writer failed.
    #[error("the file could not be written: {0}")]
    Io(#[from] std::io::Error),
}

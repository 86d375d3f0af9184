//! Deformations that have no energy.

use crate::fine::InvertedCell;

/// Why a displacement of the vertices has no energy.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum CorotatedError {
    /// An element is turned inside out or flat, so that it has no rotation.
    #[error(
        "collapsed coarse cell ({}, {}, {}): det = {determinant:.3e} of the deformation gradient at its centre must be positive; take shorter time steps or smaller loads",
        at[0], at[1], at[2]
    )]
    Collapsed {
        /// Position of the coarse cell.
        at: [usize; 3],
        /// det A at its centre.
        determinant: f64,
    },
    /// A fine cell is turned inside out where its material has no energy.
    #[error(transparent)]
    Inverted(#[from] InvertedCell),
}

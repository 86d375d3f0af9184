//! What an update did, and why there is none.

use super::{BatchError, EditError, LooseParts, LooseReport};
use crate::coarsening::{BaseKind, ShapeFunctionError};
use crate::partition::PartitionError;
use crate::training::{RunTimeTraining, TrainingError};

/// Options of a [`super::LiveModel`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LiveOptions {
    /// Training of the first build and of every update.
    pub training: RunTimeTraining,
    /// With substructured training: rings whose bound of the relative error in energy is larger are trained exactly.
    pub data_tolerance: Option<f64>,
    /// Base functions.
    pub base: BaseKind,
    /// Whether the parts of a coarse cell that an edit separates get elements of their own.
    pub split: bool,
    /// Whether an edit renews shape functions. If not, they stay what the first body gave, on a mesh without split cells, and only
    /// stiffness and masses follow: what coarsening can do without local updates.
    pub renew_functions: bool,
    /// What happens to parts that are cut loose.
    pub loose: LooseParts,
    /// Number of updates that can be undone.
    pub undo_depth: usize,
}

impl Default for LiveOptions {
    fn default() -> Self {
        Self {
            training: RunTimeTraining::default(),
            data_tolerance: None,
            base: BaseKind::Harmonic,
            split: true,
            renew_functions: true,
            loose: LooseParts::Drop,
            undo_depth: 32,
        }
    }
}

/// What an update did.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateReport {
    /// Number of fine cells that are something else than before.
    pub changed_fine: usize,
    /// Number of coarse cells that hold them.
    pub changed: usize,
    /// Number of elements that were trained, fitted and assembled again.
    pub dirty: usize,
    /// What was cut loose.
    pub loose: LooseReport,
    /// Where the time went.
    pub seconds: UpdateSeconds,
}

/// Seconds of the stages of an update.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct UpdateSeconds {
    /// Picking the cells, changing the body, searching loose parts.
    pub edit: f64,
    /// Parts of coarse cells, copies of coarse nodes, dirty elements.
    pub topology: f64,
    /// Training data.
    pub training: f64,
    /// Shape functions.
    pub fitting: f64,
    /// Stiffness, masses, carrying the motion.
    pub assembly: f64,
    /// All of it.
    pub total: f64,
}

/// Why a live model was not made or not changed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum LiveError {
    /// An edit of a batch is refused.
    #[error(transparent)]
    Batch(#[from] BatchError),
    /// The edits together are refused.
    #[error(transparent)]
    Edit(EditError),
    /// The lattice cannot be cut into coarse cells.
    #[error(transparent)]
    Partition(#[from] PartitionError),
    /// Training failed.
    #[error(transparent)]
    Training(#[from] TrainingError),
    /// Fitting failed.
    #[error(transparent)]
    Fitting(#[from] ShapeFunctionError),
}

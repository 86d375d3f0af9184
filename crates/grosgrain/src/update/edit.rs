//! What an edit is and which cells it changes.

use super::Batch;
use crate::fine::{CellState, ChangeError, FineModel};
use crate::mesh::{Cell, Label, SelectionError, Selector};

/// What an edit does to a cell.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Change {
    /// Solid cells get this label, with the modulus and density of its material.
    Material(Label),
    /// Solid cells get this Young modulus \[Pa\]; label, density and Poisson's ratio stay.
    Young(f64),
    /// Solid cells become void.
    Remove,
    /// Void cells become solid, with this label and its material.
    Add(Label),
}

/// Where an edit happens.
#[derive(Clone, Debug, PartialEq)]
pub enum Region {
    /// The cells that a selector picks at the time of the edit.
    Selector(Selector),
    /// These cells, in any order.
    Cells(Vec<Cell>),
}

/// A change of a part of the body.
#[derive(Clone, Debug, PartialEq)]
pub struct Edit {
    /// Where.
    pub region: Region,
    /// What.
    pub change: Change,
}

/// What edits really change: cells that are something else afterwards, with the states they get.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Resolved {
    /// Cells, ascending, each once.
    pub changes: Vec<(Cell, CellState)>,
    /// How many of them become void.
    pub removed: usize,
    /// How many of them become solid.
    pub added: usize,
}

/// Why an edit is refused. The body is then as it was.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum EditError {
    /// The selector makes no sense.
    #[error(transparent)]
    Selection(#[from] SelectionError),
    /// The region is empty.
    #[error(
        "the edit's region holds no cell; the body extends over x {:.6}..{:.6}, y {:.6}..{:.6}, z {:.6}..{:.6} m; move or enlarge the region",
        low[0], high[0], low[1], high[1], low[2], high[2]
    )]
    NoCell {
        /// The body's smallest coordinates \[m\].
        low: [f64; 3],
        /// The body's largest coordinates \[m\].
        high: [f64; 3],
    },
    /// Nothing in the region can be changed or removed.
    #[error(
        "all {cells} cells of the edit's region are void, so there is nothing to change; choose a region with solid cells"
    )]
    NothingSolid {
        /// Number of cells in the region.
        cells: usize,
    },
    /// Nothing in the region can be filled.
    #[error("all {cells} cells of the edit's region are solid, so there is nothing to add; choose a region with voids")]
    NothingVoid {
        /// Number of cells in the region.
        cells: usize,
    },
    /// The states are not possible.
    #[error(transparent)]
    Change(#[from] ChangeError),
    /// Every solid cell would go.
    #[error("the edit would remove all {cells} solid cells; keep a part of the body")]
    Everything {
        /// Number of solid cells before.
        cells: usize,
    },
    /// Every part that is left hangs on nothing and would be dropped.
    #[error(
        "after the edit nothing of the body is held, so all {cells} remaining cells would be dropped; keep a held part or keep loose parts"
    )]
    NothingHeld {
        /// Number of solid cells that the edit leaves.
        cells: usize,
    },
}

impl EditError {
    /// Whether the edit is sound but finds nothing to change: an empty region, or only voids, or none.
    pub fn finds_nothing(&self) -> bool {
        matches!(self, Self::NoCell { .. } | Self::NothingSolid { .. } | Self::NothingVoid { .. })
    }
}

/// Why a batch of edits is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("edit {edit} of the batch, counted from 0: {reason}")]
pub struct BatchError {
    /// Which edit, from 0.
    pub edit: usize,
    /// Why.
    pub reason: EditError,
}

impl Edit {
    /// The cells that the edit really changes: a material set where it already is changes nothing.
    ///
    /// # Errors
    /// An unusable selector, a region without cells or without anything to change, cells outside of the grid, labels without a
    /// material, impossible moduli, a modulus for an anisotropic material, a body of which nothing would be left.
    pub fn resolve(&self, model: &FineModel) -> Result<Resolved, EditError> {
        let mut batch = Batch::new(model);
        batch.add(self)?;
        batch.finish()
    }
}

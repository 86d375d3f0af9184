//! Matrix shape functions of coarse hexahedra from training displacements (`chen2018numerical`, `he2022fast`).

mod base;
mod coupled;
mod data_constraints;
mod element_fitter;
mod fit;
mod per_node;
mod shape_functions;

pub use base::{BaseFunctions, BaseKind};
pub use coupled::{CoupledError, fit_coupled};
pub use data_constraints::{DataConstraints, RANK_TOLERANCE};
pub use element_fitter::ElementFitter;
pub use fit::{FittedCell, Fitter};
pub use per_node::{PerNode, Systems};
pub use shape_functions::{Objective, ShapeFunctionError, ShapeFunctions};

/// Columns of a shape function matrix: three displacement components of eight corners.
pub const COLUMNS: usize = 24;
/// Training fields of a fit.
pub const FIELDS: usize = crate::fine::HARMONIC_FIELDS;

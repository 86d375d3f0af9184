//! The fine model: one trilinear hexahedron per voxel, each with its own material.

mod edit;
mod forces;
mod loads;
mod model;
mod stress;

pub use edit::{CellState, ChangeError};
pub use forces::{CellTangents, FineForces, InvertedCell};
pub(crate) use forces::{CellVectors, SingleCell};
pub use loads::{HARMONIC_FIELDS, constant_stress, constant_stress_loads, gravity, node_forces, traction};
pub use model::{FineModel, FineModelError};
pub use stress::{cauchy_stresses, centre_stresses, smallest_determinant, von_mises};

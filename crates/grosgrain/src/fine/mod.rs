//! The fine model: one trilinear hexahedron per voxel, each with its own material.

mod loads;
mod model;

pub use loads::{HARMONIC_FIELDS, constant_stress, constant_stress_loads, gravity, node_forces, traction};
pub use model::{FineModel, FineModelError};

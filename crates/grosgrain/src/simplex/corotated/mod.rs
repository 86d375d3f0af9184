//! The elastic energy of a mesh of simplices under large rotations: every cell in a frame that rotates with it.

mod cell;
mod elasticity;
mod frame;

pub use elasticity::{SimplexElasticity, SimplexElasticityError, SimplexLaw, SimplexMatrix};

//! Meshes of simplices (segments, triangles, tetrahedra) and elasticity in as many dimensions.

mod boundary;
mod bounding_tree;
mod checks;
mod clipping;
mod corotated;
mod distance;
mod enclosing;
mod error;
mod faces;
mod lattice;
mod locate;
mod mesh;
mod overlaps;
mod shells;
mod quality;
mod tensor;

pub use boundary::{Boundary, BoundaryError, BoundaryFace, BranchingRidge, Shell};
pub use bounding_tree::{BoundingBox, BoundingTree};
pub use checks::{MeshFinding, Severity, check_mesh, check_overlap, components, pieces};
pub use corotated::{SimplexElasticity, SimplexElasticityError, SimplexLaw, SimplexMatrix};
pub(crate) use distance::squared_distance_of_face;
pub use error::SimplexMeshError;
pub use lattice::{BoxCut, SimplexLattice, SimplexLatticeError};
pub use locate::{CellWeights, Locator, Place};
pub use mesh::{Dimension, SimplexMesh};
pub use overlaps::{OverlapError, Overlaps};
pub use tensor::{MandelTensor, mandel_strain};

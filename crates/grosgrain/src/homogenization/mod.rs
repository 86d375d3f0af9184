//! Elastic bodies of simplices (segments, triangles, tetrahedra) and their harmonic displacements, from which effective tensors on coarse meshes come
//! (`kharevych2009numerical`).

mod averages;
mod block_columns;
mod bounding_normals;
mod cell_stiffness;
mod downsampling;
mod effective;
mod harmonic;
mod harmonic_displacements;
mod homogenize;
mod model;
mod parts;
mod rigid;
mod supports;
mod system;

pub use averages::{Average, average_tensors, lumped_mass};
pub use bounding_normals::bounding_normals;
pub use cell_stiffness::cell_stiffness;
pub use downsampling::{Downsampled, downsample};
pub use effective::{EffectiveError, EffectiveOptions, EffectiveTensors, effective_tensors};
pub use harmonic::{HarmonicError, HarmonicOptions, HarmonicReport, harmonic_displacements, harmonic_loads};
pub use harmonic_displacements::{HarmonicDisplacements, mollifier_of};
pub use homogenize::{BoundaryNormals, HomogenizeError, HomogenizeOptions, Homogenized, homogenize};
pub use model::{SimplexModel, SimplexModelError};
pub use system::{Holding, NodalVectors, SimplexSystem, SimplexSystemError};

//! Elastic bodies of simplices (segments, triangles, tetrahedra) and their harmonic displacements, from which effective tensors on coarse meshes come
//! (`kharevych2009numerical`).

mod averages;
mod block_columns;
mod bounding_normals;
mod cell_rotation;
mod cell_stiffness;
mod coarse_materials;
mod downsampling;
mod effective;
mod embedding;
mod fitted;
mod harmonic;
mod harmonic_displacements;
mod harmonic_map;
mod homogenize;
mod model;
mod parts;
mod rigid;
mod supports;
mod system;

pub use averages::{Average, average_tensors, lumped_mass};
pub use bounding_normals::bounding_normals;
pub use cell_stiffness::cell_stiffness;
pub use coarse_materials::{CoarseMaterials, CoarseModelError, CoarseSimplexModel, coarse_model, sampled_tensors};
pub use downsampling::{Downsampled, downsample};
pub use effective::{EffectiveError, EffectiveOptions, EffectiveTensors, effective_tensors};
pub use embedding::SimplexEmbedding;
pub use fitted::fit_downsampled;
pub use harmonic::{HarmonicError, HarmonicOptions, HarmonicReport, harmonic_displacements, harmonic_loads};
pub use harmonic_displacements::{HarmonicDisplacements, mollifier_of};
pub use harmonic_map::{Blending, HarmonicMap, Mapped};
pub use homogenize::{BoundaryNormals, Downsampling, HomogenizeError, HomogenizeOptions, Homogenized, homogenize};
pub use model::{SimplexModel, SimplexModelError};
pub use system::{Holding, NodalVectors, SimplexSystem, SimplexSystemError};

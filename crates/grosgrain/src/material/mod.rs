//! Materials: isotropic and fully anisotropic elasticity, its laws of large deformation, and the table label → material.

mod corotational;
mod eight;
mod elasticity_tensor;
mod isotropic;
mod law;
mod linear;
mod neo_hookean;
mod point_law;
mod spectral;
mod table;

pub(crate) use eight::matrix_at;
pub use eight::{EightMatrices, EightTangents};
pub use elasticity_tensor::{ElasticityTensor, ElasticityTensorError};
pub use isotropic::{IsotropicMaterial, IsotropicMaterialError};
pub use law::Law;
pub use point_law::{Matrix9, PointLaw, Projection};
pub use table::{Elasticity, Material, MaterialTable};

//! Materials: isotropic and fully anisotropic linear elasticity, and the table label → material.

mod elasticity_tensor;
mod isotropic;
mod law;
mod table;

pub use elasticity_tensor::{ElasticityTensor, ElasticityTensorError};
pub use isotropic::{IsotropicMaterial, IsotropicMaterialError};
pub use law::Law;
pub use table::{Elasticity, Material, MaterialTable};

//! Files: volumes and meshes are read and written here, frames are written; every output appears whole or not at all.

mod atomic_write;
mod excerpt;
pub mod mesh;
mod model;
mod tensors;
pub mod volume;
pub mod vtk;

pub use atomic_write::write_atomically;
pub use mesh::{MeshFile, MeshFormat, MeshReadError, MeshWriteError, read_mesh, write_mesh};
pub use model::{MODEL_VERSION, ModelWriteError, write_model};
pub use tensors::{TENSORS_VERSION, write_tensors};
pub use volume::{ReadError, VolumeFormat, WriteError, read_volume, write_volume};

//! Files: volumes are read and written here, frames are written; every output appears whole or not at all.

mod atomic_write;
mod model;
pub mod volume;
pub mod vtk;

pub use atomic_write::write_atomically;
pub use model::{MODEL_VERSION, ModelWriteError, write_model};
pub use volume::{ReadError, VolumeFormat, WriteError, read_volume, write_volume};

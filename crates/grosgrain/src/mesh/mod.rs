//! Voxel lattices and the bodies on them.

mod lattice;
mod volume;
mod voxel_grid;

pub use lattice::{Cell, Lattice, Node};
pub use volume::Volume;
pub use voxel_grid::{Label, VoxelGrid, VoxelGridError};

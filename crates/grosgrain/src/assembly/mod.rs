//! From cells to the lattice: which nodes have unknowns, and how cell matrices add up.

mod cell_stiffness;
mod dof_map;
mod lattice_pattern;
mod matrix_free;
mod window;

pub use cell_stiffness::CellStiffness;
pub use dof_map::{Constraints, active_nodes, free_components};
pub use lattice_pattern::LatticePattern;
pub use matrix_free::MatrixFree;
pub use window::Window;

//! From cells to the lattice: which nodes have unknowns, and how cell matrices add up.

mod cell_stiffness;
mod dof_map;

pub use cell_stiffness::CellStiffness;
pub use dof_map::{Constraints, active_nodes};

//! Multifrontal elimination of symmetric positive semidefinite systems made of small dense elements.
//!
//! Made for many systems of one shape of which only a few unknowns are wanted: no sparse matrix is assembled, the loads
//! travel with the elimination as extra rows of the fronts, and only the fronts of the wanted unknowns are kept for
//! the substitution backwards (Duff & Reid 1983, `duff1983multifrontal`). A pivot that vanishes (a rigid motion of a floating part, a node
//! of a void) is skipped: its unknown stays free, which gives an exact generalised inverse where loads are in equilibrium.

mod dense_front;
mod front;
mod plan;
mod solver;
mod tree;

pub use dense_front::DenseFront;
pub use plan::{FrontalPlan, FrontalPlanError};
pub use solver::{Eliminated, FrontalFactors, FrontalSolver};
pub use tree::{box_tree, box_tree_around};

#[cfg(test)]
mod tests;

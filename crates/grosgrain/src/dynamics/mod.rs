//! Solving for motion. So far: the static equilibrium of linear materials, fine and coarse.

mod static_solve;

pub use static_solve::{CoarseSolution, FineSolution, relative_error, solve_coarse, solve_fine};

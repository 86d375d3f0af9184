//! Solving for motion: the static equilibrium of linear materials, fine and coarse, and the motions that held parts are given over time.

mod hold;
mod hold_checks;
mod motion;
mod rigid_velocity;
mod static_solve;

pub use hold::{Hold, Holds};
pub use hold_checks::{GroundPassage, HoldConflict};
pub use motion::{Motion, MotionAt, Ramp, Twist, lasts};
pub use rigid_velocity::{RigidVelocity, centre_of_mass};
pub use static_solve::{CoarseSolution, FineSolution, relative_error, solve_coarse, solve_fine};
